"""A slide from any speed: where it stops, or that it does not before the contact ends.

A slide's speed (its modulus) is s(p) = s0 + P (cos p0 - cos p) - Q (p - p0), Eq. (23), with P and Q for
``pull`` and ``drag``. Between a maximum of s and the minimum after it s falls
monotonically, and from one minimum to the next it changes by -2 pi Q, so that the branch with the first
zero follows in closed form and the zero has a proven bracket. Slides from rest in contact scenes have the
sharper solution of ``slide.py``. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.contact.windows import load_amplitude, own_phase
from vibro.core.groups import take
from vibro.core.roots import bisect

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]

__all__ = ["Coast", "Pull", "coast", "pull_of"]

_TURN: Final = 2.0 * np.pi

_HALLEY_STEPS: Final = 4
# [1] A last step below this fraction of the way from the maximum leaves rounding errors only, at double zeros
# too: a step leaves a third of the error there, and the speed is of its square.
_SETTLED: Final = 1e-9


class Pull(NamedTuple):
    """What drives and brakes a slide in one direction; the fields broadcast against each other.

    Attributes
    ----------
    shift : array
        Phase to add so that the pull is P sin p with P >= 0: the slide's own phase; 0 or pi along a line.
    pull, drag : array
        P and Q of s'' = P sin p - Q.
    kappa : array
        asin(Q / P), within +- pi/2: the speed's minima lie there, its maxima at pi - kappa.
    bend : array
        P cos(kappa), the speed's curvature there.
    excess : array
        Q - P sin(kappa): where not 0, the speed falls, or grows, at least that fast.
    """

    shift: Floats
    pull: Floats
    drag: Floats
    kappa: Floats
    bend: Floats
    excess: Floats


def pull_of(scene: Loads, direction: int) -> Pull:
    """Pull and drag of slides in the direction +1 (forward) or -1 (back), Eq. (23)."""
    mu_d = scene.kinetic_friction
    drag = mu_d * scene.normal + direction * scene.tangential
    pull = np.abs(load_amplitude(scene, direction, mu_d))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.clip(drag / pull, -1.0, 1.0)
    return Pull(
        shift=own_phase(scene, direction),
        pull=pull,
        drag=drag,
        kappa=np.arcsin(ratio),
        bend=pull * np.sqrt((1.0 - ratio) * (1.0 + ratio)),
        excess=np.where(np.abs(ratio) < 1.0, 0.0, drag - ratio * pull),
    )


class Coast(NamedTuple):
    """End of a slide.

    Attributes
    ----------
    length : array
        Phase from its start to its end [rad]; inf where it never ends.
    stopped : bool array
        Whether it ends because the speed is zero, not because the contact does.
    speed : array
        Speed at its end, >= 0; NaN where it never ends.
    top : array
        Largest speed; NaN where it never ends.
    settled : bool array
        Whether the end was found to rounding.
    """

    length: Floats
    stopped: Bools
    speed: Floats
    top: Floats
    settled: Bools


def _turned(d: Floats) -> tuple[Floats, Floats]:
    """Sin d and 1 - cos d from one tangent."""
    t = np.tan(0.5 * d)
    sine = 2.0 * t / (1.0 + t * t)
    return sine, sine * t


def _loss(d: Floats, at: Pull) -> Floats:
    """Speed lost a phase d after the maximum, Eq. (25); negative phases are before it."""
    sine, versine = _turned(d)
    return at.bend * versine + at.drag * (d - sine) + at.excess * sine


def coast(at: Pull, phase: Floats, speed: Floats, limit: Floats) -> Coast:
    """Follow slides until they stop or the contact ends.

    Parameters
    ----------
    at : Pull
        Of the slides' direction; 1-D, or 0-d members for all.
    phase : array
        Phase at the start [rad].
    speed : array
        Speed at the start, >= 0; where it is 0 the pull must exceed the drag.
    limit : array
        Phase from the start to the end of the contact, inf where there is none.

    Returns
    -------
    Coast
        One element per slide.
    """
    # d counts from the maximum pi - kappa of the turn that begins at the minimum kappa
    d0 = np.mod(phase + at.shift - at.kappa, _TURN) + 2.0 * at.kappa - np.pi
    still = np.flatnonzero(speed == 0.0)
    if still.size:
        # A slide from rest starts between the minimum and the maximum. Rounding may put its phase a little
        # before the minimum, and so into the turn before: count from the middle between the two instead.
        half = 0.5 * np.pi - (at.kappa[still] if at.kappa.ndim else at.kappa)
        d0[still] = np.mod(d0[still] + half + np.pi, _TURN) - np.pi - half
    fall = np.pi + 2.0 * at.kappa
    first_top = speed + _loss(d0, at)
    bottom = 2.0 * at.bend + at.drag * fall
    per_turn = _TURN * at.drag
    with np.errstate(divide="ignore", invalid="ignore"):
        turns = np.ceil((first_top - bottom) / per_turn)
    endless = (at.drag <= 0.0) & (first_top > bottom)
    turns = np.where(endless, np.inf, np.where(at.drag > 0.0, np.maximum(turns, 0.0), 0.0))
    with np.errstate(invalid="ignore"):
        offset = _TURN * turns - d0  # phase from the start to the maximum of the falling branch
        top = first_top - per_turn * turns
        low = np.where(turns > 0.0, 0.0, np.maximum(d0, 0.0))
        high = np.minimum(fall, limit - offset)
    stopped = (high > low) & ~endless
    cut = np.flatnonzero(stopped & (high < fall))
    if cut.size:
        stopped[cut] = _loss(high[cut], take(at, cut)) >= top[cut]
    length = np.where(endless, np.inf, limit).astype(np.float64)
    end_speed = np.zeros(length.shape)
    settled = np.ones(length.shape, np.bool_)
    cells = np.flatnonzero(stopped)
    if cells.size:
        d, good = _fall(take(at, cells), top[cells], low[cells], high[cells])
        length[cells] = offset[cells] + d
        settled[cells] = good
    length = np.where(stopped, length, limit)
    cells = np.flatnonzero(~stopped)
    if cells.size:
        d_end = d0[cells] + limit[cells]
        with np.errstate(invalid="ignore"):
            end_speed[cells] = np.maximum(first_top[cells] - _loss(d_end, take(at, cells)), 0.0)
    # of the maxima on the way the first is the highest, or the last where gravity wins over friction
    with np.errstate(invalid="ignore"):
        next_top = np.where(d0 < 0.0, 0.0, 1.0)
        last_top = np.floor((length + d0) / _TURN)
        chosen = np.where(at.drag < 0.0, last_top, next_top)
        highest = np.where(last_top >= next_top, first_top - per_turn * chosen, 0.0)
    highest = np.maximum(highest, np.maximum(speed, end_speed))
    highest = np.where(np.isinf(length), np.nan, highest)
    return Coast(length, stopped, end_speed, highest, settled)


def _fall(at: Pull, top: Floats, low: Floats, high: Floats) -> tuple[Floats, Bools]:
    """Phase after a maximum of the speed where the speed is lost, in [low, high].

    The loss grows monotonically, so the bracket is proven. Halley's iteration starts from the zero of the
    cubic that is level at both ends, as the loss is. Near a double zero it converges slowly; such cells are
    bisected.
    """
    fall = np.pi + 2.0 * at.kappa
    whole = 2.0 * at.bend + at.drag * fall
    share = np.clip(1.0 - 2.0 * top / whole, -1.0, 1.0)
    d = fall * (0.5 - np.sin(np.arcsin(share) / 3.0))
    step = d
    for _ in range(_HALLEY_STEPS):
        sine, versine = _turned(d)
        left = top - at.bend * versine - at.drag * (d - sine) - at.excess * sine
        rate = at.bend * sine + at.drag * versine + at.excess * (1.0 - versine)
        curve = (at.drag - at.excess) * sine + at.bend * (1.0 - versine)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = left * rate / (rate * rate + 0.5 * left * curve)
        d_next = np.clip(d + step, low, high)
        step = d_next - d
        d = d_next
    settled = np.abs(step) <= _SETTLED * d
    rest = np.flatnonzero(~settled)
    if rest.size:
        pull, most = take(at, rest), top[rest]
        d[rest] = bisect(lambda d: most - _loss(d, pull), low[rest], high[rest])
    return d, np.isfinite(d)
