"""Where a scene changes class as the load grows: the critical G = A w^2 / g of each transition."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.cycle import resting_start, speed_at_closing, speed_at_opening
from vibro.core.groups import Loads, cosine_of_sum, take
from vibro.core.onset import thresholds

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from vibro.core.slide import Floats, Onset

__all__ = ["CriticalLoads", "critical_loads"]

# [1] 1/G of the lower end of a bracket over that of the upper: s is then below 1e-9 at either onset, and
# the speeds at the edges of the windows have their signs for G -> infinity.
_SMALL: Final = 1e-9


class CriticalLoads(NamedTuple):
    """Critical loads G = A w^2 / g; inf where a transition never happens, 0 where it always has.

    Attributes
    ----------
    hop : array
        Above, the throw number exceeds 1 and the body leaves the trough.
    forward_onset, back_onset : array
        Above, the load of a body at rest exceeds static friction forward, or back.
    back_slip : array
        Above, the steady cycle from rest has a back slide; at least ``back_onset``, and more where the
        forward slide outlasts the back window.
    rest_vanishes : array
        Above, the body slides all the time.
    """

    hop: Floats
    forward_onset: Floats
    back_onset: Floats
    back_slip: Floats
    rest_vanishes: Floats


def critical_loads(
    drive_angle: ArrayLike,
    static_friction: ArrayLike,
    kinetic_friction: ArrayLike,
    trough_angle: ArrayLike = 0.0,
) -> CriticalLoads:
    """Critical loads of every transition of the steady cycle from rest.

    Parameters
    ----------
    drive_angle, trough_angle : array_like
        Drive and trough angle [rad].
    static_friction, kinetic_friction : array_like
        mu_s and mu_d [1].

    Returns
    -------
    CriticalLoads
        Arrays of the broadcast shape; NaN where the combination is infeasible or mu_s = 0.

    Notes
    -----
    Hop and onsets are closed forms, Eqs. (4) and (5). Rest vanishes where both slides of the
    never-at-rest cycle start on their onsets, a closed form too, Eq. (21), since the shape of that
    cycle does not depend on G; but not before a cycle with rest has given way to it. Back slip enters
    at its onset, or where the forward slide stops outlasting the back window: the root of a speed in
    a bracket that has both signs by Eq. (22), by Chandrupatla's method. Classes follow each other in
    one order as G grows in every scene tried (tests/core/test_limits.py).
    """
    fields = [
        np.asarray(a, np.float64) for a in (drive_angle, static_friction, kinetic_friction, trough_angle)
    ]
    shape = np.broadcast_shapes(*(a.shape for a in fields))
    alpha, mu_s, mu_d, beta = (np.broadcast_to(a, shape).reshape(-1) for a in fields)
    unit = Loads(
        np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta), cosine_of_sum(alpha, beta), mu_s, mu_d
    )
    feasible = (mu_d <= mu_s) & (mu_s > 0.0) & (unit.contrast > 0.0)
    out = CriticalLoads(*(np.full(alpha.size, np.nan) for _ in CriticalLoads._fields))
    cells = np.flatnonzero(feasible)
    if cells.size:
        for target, source in zip(out, _critical(take(unit, cells)), strict=True):
            target[cells] = source
    return CriticalLoads(*(a.reshape(shape)[()] for a in out))


def _critical(unit: Loads) -> CriticalLoads:
    """Critical loads of feasible scenes; ``unit`` is their loads at G = 1."""
    lift = unit.static_friction * unit.across
    hold = unit.static_friction * unit.normal
    with np.errstate(divide="ignore", over="ignore"):
        hop = unit.normal / unit.across
        forward = np.maximum(hold + unit.tangential, 0.0) / (unit.along + lift)
        back = np.where(
            unit.along > lift, np.maximum(hold - unit.tangential, 0.0) / (unit.along - lift), np.inf
        )
    slips_both = np.isfinite(back) & (np.abs(unit.tangential) < hold)
    start = np.maximum(forward, back)

    # Back slip: the forward slide may outlast the back window for a while, or for ever if k <= 0.
    back_slip = back.copy()
    resists = unit.kinetic_friction * unit.normal + unit.tangential > 0.0
    waits = np.flatnonzero(slips_both & (back > forward) & resists)
    back_slip[slips_both & (back > forward) & ~resists] = np.inf
    _advance(back_slip, waits, unit, speed_at_closing)

    # Rest: the closed form, then until a cycle with rest has given way.
    vanishes = np.full(hop.shape, np.inf)
    cells = np.flatnonzero(slips_both & np.isfinite(back_slip) & resists)
    vanishes[cells] = np.maximum(_rest_vanishes(take(unit, cells)), start[cells])
    cells = cells[np.isfinite(vanishes[cells])]
    _advance(vanishes, cells, unit, lambda forward, back: -speed_at_opening(forward, back))
    vanishes = np.maximum(vanishes, back_slip)
    vanishes[np.abs(unit.tangential) >= hold] = 0.0
    return CriticalLoads(hop, forward, back, back_slip, vanishes)


def _advance(limit: Floats, cells: np.ndarray, unit: Loads, speed: Callable[[Onset, Onset], Floats]) -> None:
    """Raise limits to where a speed of the forward slide falls to zero, if it is positive at the limit."""
    if not cells.size:
        return
    scenes = take(unit, cells)

    def value(weight: Floats, /, *members: Any) -> Floats:
        return _edge_speed(weight, Loads(*members), speed)

    high = 1.0 / limit[cells]
    waits = np.flatnonzero(value(high, *scenes) > 0.0)
    if waits.size:
        from scipy.optimize import elementwise  # late: most scenes do not need its import time

        high = high[waits]
        root = elementwise.find_root(
            value,
            (_SMALL * high, high),
            args=tuple(take(scenes, waits)),
            tolerances={"xatol": 0.0, "xrtol": 4 * 2.0**-52, "fatol": 0.0, "frtol": 0.0},
        )
        limit[cells[waits]] = 1.0 / root.x


def _edge_speed(weight: Floats, unit: Loads, speed: Callable[[Onset, Onset], Floats]) -> Floats:
    """Speed of the forward slide from rest at an edge of the back window, at G = 1 / weight."""
    scene = unit._replace(
        normal=weight * unit.normal, tangential=weight * unit.tangential, contrast=weight * unit.contrast
    )
    margins = thresholds(scene).margins
    # At a critical load itself a margin is zero up to rounding.
    margins = margins._replace(forward=np.maximum(margins.forward, 0.0), back=np.maximum(margins.back, 0.0))
    return speed(resting_start(scene, margins, 1).onset, resting_start(scene, margins, -1).onset)


def _rest_vanishes(unit: Loads) -> Floats:
    """Load at which the never-at-rest cycle exists, Eq. (21); inf where it never does."""
    mu_s, mu_d = unit.static_friction, unit.kinetic_friction
    possible = mu_d * unit.normal > np.abs(unit.tangential)
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = mu_d * mu_d * unit.across * unit.normal - unit.tangential * unit.along
        y = np.where(possible, 0.5 * np.pi * turn / (mu_d * unit.contrast), np.nan)
    lift = mu_d * unit.across
    k = (mu_d * unit.normal + unit.tangential) / (unit.along + lift)
    middle = k * (0.5 * np.pi + y) / np.cos(y)  # G sin m
    drop = middle * np.sin(y)
    static = mu_s * unit.across
    forward = (mu_s * unit.normal + unit.tangential) / (unit.along + static)
    back = (mu_s * unit.normal - unit.tangential) / (unit.along - static)
    needed = np.maximum(np.maximum(forward + drop, back - drop), 0.0) / np.cos(y)
    return np.where(possible, np.hypot(middle, needed), np.inf)
