"""Where a scene changes class as the load grows: the critical G = A w^2 / g of each transition."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibro.core.contact.phase_limits import phase_limits
from vibro.core.contact.windows import static_lifts
from vibro.core.groups import each, take, unit_loads

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vibro.core.contact.slide import Floats
    from vibro.core.groups import Loads

__all__ = ["CriticalLoads", "critical_loads", "critical_loads_of", "tipping_load", "tipping_load_of"]


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
        forward slide outlasts the back window. Elliptical drives on troughs steeper than the angle of kinetic
        friction may lose it again.
    rest_vanishes : array
        Above, the body slides all the time.

    Notes
    -----
    A body starts from rest where its load first exceeds static friction. On inclines phase 0 may lie later
    than that, and where cycles coexist lead to the other one.
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
    """Critical loads of every transition of the steady cycle from rest, of drives along a line.

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
    cycle does not depend on G; but not before back slip has entered. Back slip enters at its onset, or
    where the forward slide stops outlasting the back window: the one root of a monotone function, Eq. (22),
    in a bracket that has both signs, by Chandrupatla's method. The classes follow each other in one order
    as G grows (theory.md, section 6; tests/core/contact/test_limits.py).
    """
    fields = (drive_angle, static_friction, kinetic_friction, trough_angle)
    return critical_loads_of(unit_loads(*(np.asarray(a, np.float64) for a in fields)))


def critical_loads_of(unit: Loads) -> CriticalLoads:
    """Critical loads of every transition, from the loads at G = 1.

    Parameters
    ----------
    unit : Loads
        Of any drive; its arrays broadcast against each other.

    Returns
    -------
    CriticalLoads
        Arrays of the broadcast shape; NaN where the combination is infeasible or mu_s = 0.

    Notes
    -----
    As ``critical_loads``. Of elliptical drives back slip and the end of rest are looked for up to the hop, by
    halving, as classes follow each other in one order there too (theory.md, section 15).
    """
    shape = np.broadcast_shapes(*(a.shape for a in unit.flattened()))
    flat: Loads = each(unit, lambda a: np.broadcast_to(a, shape).reshape(-1))
    feasible = ~flat.infeasible & (flat.static_friction > 0.0)
    out = CriticalLoads(*(np.full(feasible.size, np.nan) for _ in CriticalLoads._fields))
    cells = np.flatnonzero(feasible)
    if cells.size:
        for target, source in zip(out, _critical(take(flat, cells)), strict=True):
            target[cells] = source
    return CriticalLoads(*(a.reshape(shape)[()] for a in out))


def tipping_load(
    drive_angle: ArrayLike,
    static_friction: ArrayLike,
    trough_angle: ArrayLike,
    stand_ratio: ArrayLike,
) -> Floats:
    """Load up to which no edge of a part lifts that starts from rest, Eq. (43), for drives along a line.

    Parameters
    ----------
    drive_angle, trough_angle : array_like
        Drive and trough angle [rad].
    static_friction : array_like
        mu_s [1].
    stand_ratio : array_like
        Half base over height of the centre of mass, > 0 [1].

    Returns
    -------
    array
        Of the broadcast shape: the first of the onsets with the stand ratio in place of mu_s [1]. inf where
        mu_s is at most the stand ratio, 0 where the trough alone is too steep for the part, NaN where drive +
        trough angle reach 90 deg. It is below the load of hopping wherever it is finite.
    """
    fields = (drive_angle, static_friction, static_friction, trough_angle)
    unit = unit_loads(*(np.asarray(a, np.float64) for a in fields))
    return tipping_load_of(unit, np.asarray(stand_ratio, np.float64))


def tipping_load_of(unit: Loads, stand_ratio: Floats) -> Floats:
    """Load up to which no edge lifts, from the loads at G = 1 of any drive; else as ``tipping_load``."""
    standing = unit._replace(static_friction=stand_ratio, kinetic_friction=stand_ratio)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # of ratios that no friction reaches
        first = np.minimum(*_onsets(standing))
    tips = np.where(unit.static_friction > stand_ratio, first, np.inf)
    return (tips if unit.lead else np.where(unit.contrast > 0.0, tips, np.nan))[()]


def _critical(unit: Loads) -> CriticalLoads:
    """Critical loads of feasible scenes; ``unit`` is their loads at G = 1."""
    with np.errstate(divide="ignore", over="ignore"):
        hop = unit.normal / unit.across
        forward, back = _onsets(unit)
        hold = unit.static_friction * unit.normal
    slips_both = np.isfinite(back) & (np.abs(unit.tangential) < hold)

    if unit.lead:
        back_slip, vanishes = phase_limits(unit, hop, forward, back)
        vanishes[np.abs(unit.tangential) >= hold] = 0.0
        return CriticalLoads(hop, forward, back, back_slip, vanishes)
    # The forward slide may outlast the back window for a while, or for ever if nothing brakes it.
    back_slip = back.copy()
    outlasts = slips_both & (back > forward)
    braked = unit.kinetic_friction * unit.normal + unit.tangential > 0.0
    back_slip[outlasts & ~braked] = np.inf
    cells = np.flatnonzero(outlasts & braked)
    if cells.size:
        back_slip[cells] = _back_slip_enters(forward[cells], back[cells], _resistance(take(unit, cells)))

    vanishes = np.full(hop.shape, np.inf)
    cells = np.flatnonzero(slips_both & braked)
    vanishes[cells] = np.maximum(_rest_vanishes(take(unit, cells)), back_slip[cells])
    vanishes[np.abs(unit.tangential) >= hold] = 0.0
    return CriticalLoads(hop, forward, back, back_slip, vanishes)


def _onsets(unit: Loads) -> tuple[Floats, Floats]:
    """Return the loads of the forward and the back onset, Eqs. (5) and (55); 0 where it slips without any."""
    ahead, behind = static_lifts(unit)
    hold = unit.static_friction * unit.normal
    needed, back_load = np.maximum(hold + unit.tangential, 0.0), unit.along + behind
    with np.errstate(divide="ignore", invalid="ignore"):  # troughs that stand still
        forward = np.where(needed > 0.0, needed / (unit.along + ahead), 0.0)
        back = np.maximum(hold - unit.tangential, 0.0) / back_load
    return forward, np.where(back_load > 0.0, back, np.inf)


def _resistance(unit: Loads) -> Floats:
    """G k of the forward slide, Eq. (3)."""
    return (unit.kinetic_friction * unit.normal + unit.tangential) / (
        unit.along + unit.kinetic_friction * unit.across
    )


def _back_slip_enters(forward: Floats, back: Floats, resistance: Floats) -> Floats:
    """Load from which the forward slide ends before the back window closes; at least the back onset."""

    def speed(weight: Floats, forward: Floats, back: Floats, resistance: Floats) -> Floats:
        """Speed of the forward slide where the back window closes, over 1/G, Eq. (22): monotone."""
        s_f, s_b = weight * forward, weight * back
        cosines = np.sqrt((1.0 - s_f) * (1.0 + s_f)) + np.sqrt((1.0 - s_b) * (1.0 + s_b))
        with np.errstate(divide="ignore"):  # inf where both s are 1 to rounding, at the back onset
            gain: Floats = weight * (back - forward) * (back + forward) / cosines
        loss: Floats = resistance * (np.pi + np.arccos(s_f) + np.arccos(s_b))
        return gain - loss

    limit = back.copy()
    with np.errstate(over="ignore", invalid="ignore"):  # loads below 1e-308 have no finite 1/G: NaN, no root
        cells = np.flatnonzero(speed(1.0 / back, forward, back, resistance) > 0.0)
    if cells.size:
        from scipy.optimize import elementwise  # late: most scenes do not need its import time

        members = (forward[cells], back[cells], resistance[cells])
        root = elementwise.find_root(
            speed,
            (np.zeros(cells.size), 1.0 / back[cells]),
            args=members,
            tolerances={"xatol": 0.0, "xrtol": 4 * 2.0**-52, "fatol": 0.0, "frtol": 0.0},
        )
        limit[cells] = 1.0 / root.x
    return limit


def _rest_vanishes(unit: Loads) -> Floats:
    """Load at which the never-at-rest cycle exists, Eq. (21); inf where it never does."""
    mu_s, mu_d = unit.static_friction, unit.kinetic_friction
    possible = mu_d * unit.normal > np.abs(unit.tangential)
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = mu_d * mu_d * unit.across * unit.normal - unit.tangential * unit.along
        y = np.where(possible, 0.5 * np.pi * turn / (mu_d * unit.contrast), np.nan)
    middle = _resistance(unit) * (0.5 * np.pi + y) / np.cos(y)  # G sin m
    drop = middle * np.sin(y)
    static = mu_s * unit.across
    forward = (mu_s * unit.normal + unit.tangential) / (unit.along + static)
    back = (mu_s * unit.normal - unit.tangential) / (unit.along - static)
    needed = np.maximum(forward + drop, back - drop) / np.cos(y)
    return np.where(possible, np.hypot(middle, needed), np.inf)
