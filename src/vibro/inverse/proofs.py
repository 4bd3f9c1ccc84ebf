"""Bound the loads at which the bodies of an uncertainty set change their regime: by corners, else by search.

Results are ratios of a body's load to its critical load. If the largest ratio of a box exceeds 1, some body
is in the regime; if the smallest one does, all are. Ratios are proportional to the amplitude.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.inverse.changes import begin_load, slip_load
from vibro.inverse.search import evolve, placed, sobol
from vibro.limits import critical_loads_of_lines, tipping_load, tipping_load_of_lines

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.inverse.spaces import UncertaintySet
    from vibro.scene import Scene

    Floats = NDArray[np.float64]

__all__ = [
    "back_slip_load", "corners", "extreme_ratio", "first_ratio", "is_braked", "last_ratio", "onset_load",
    "regime_loads", "slip_ratio", "steeper_is_slower", "tip_load", "tip_ratio",
]  # fmt: skip

_EDGE: Final = 65  # static frictions of each grid along an edge of the box
_SLOPES: Final = 33  # trough angles of each grid, where the first body need not be at an end
_ROUNDS: Final = 5  # refinements of these grids
_FIRST: Final = 5  # base-2 logarithm of the first population, beside the corners
_GENERATIONS: Final = 60
_FEWER: Final = 15  # of given motions, whose loads are searched by many steady cycles
_SEED: Final = 1


def corners(varies: NDArray[np.bool_]) -> Floats:
    """Return distinct corners of a box in the unit cube, of shape (axes, n); 0 where a band has no width."""
    ends = np.meshgrid(*((0.0, 1.0) if free else (0.0,) for free in varies), indexing="ij")
    return np.array([end.ravel() for end in ends])


def first_ratio(box: UncertaintySet, regime: Regime) -> float:
    """Return the largest ratio of a load to that at which a regime begins; above 1 some body is in it."""
    most = float(box.load[1])
    if regime is Regime.HOPPING:
        return box.throw_number
    if not box.space.proves:
        return extreme_ratio(box, _critical(regime), largest=True)[0]
    if regime is Regime.BACK_SLIP:
        return _ratio(most, back_slip_load(box))
    # the onset is least at an end of the drive angles, or at the angle of friction, on the flattest trough
    (a_low, a_high), mu_s = box.shape["drive_angle"], box.static_span[0]
    angles = np.array([a_low, a_high, np.clip(math.atan(mu_s), a_low, a_high)])
    onsets = critical_loads_of_lines(angles, mu_s, mu_s, box.trough_angle[0]).forward_onset
    return _ratio(most, np.min(onsets))


def last_ratio(box: UncertaintySet, regime: Regime) -> float:
    """Return the smallest ratio of a load to that at which a regime begins; above 1 every body is in it."""
    if not box.space.proves:
        return extreme_ratio(box, _critical(regime), largest=False)[0]
    least, (b_low, b_high) = float(box.load[0]), box.trough_angle
    if regime is Regime.FORWARD_SLIP:
        return _ratio(least, onset_load(box))
    if regime is Regime.BACK_SLIP:
        return _ratio(least, back_slip_load(box, last=True))
    flattest = 1.0 if b_low < 0.0 < b_high else np.maximum(np.cos(b_low), np.cos(b_high))
    with np.errstate(divide="ignore"):  # spelled as ``hop_load`` is: without bands first and last are equal
        return _ratio(least, np.divide(flattest, np.sin(box.shape["drive_angle"][0])))


def slip_ratio(box: UncertaintySet) -> tuple[float, Floats]:
    """Return a ratio that is above 1 if a body of a single box slips back, and where it is largest."""
    return extreme_ratio(box, slip_load, largest=True)


def tip_ratio(box: UncertaintySet, stand_ratio: float) -> float:
    """Return the largest ratio of a load to that at which a part tips; 0 where none can."""
    if math.isinf(stand_ratio):
        return 0.0
    if box.space.proves:
        return _ratio(box.load[1], tip_load(box, stand_ratio))
    return extreme_ratio(box, lambda scene: tipping_load(scene, stand_ratio), largest=True)[0]


def _ratio(load: Floats | float, critical: Floats | float) -> float:
    """Divide a load by a critical one, which may be 0 or inf."""
    with np.errstate(divide="ignore"):
        return float(np.divide(load, critical))


def _critical(regime: Regime) -> Callable[[Scene], Floats]:
    return lambda scene: begin_load(scene, regime)


def extreme_ratio(
    box: UncertaintySet, critical_load: Callable[[Scene], Floats], *, largest: bool
) -> tuple[float, Floats]:
    """Search a single box for the largest, or the smallest, load over a critical load.

    Parameters
    ----------
    box : UncertaintySet
        A single box.
    critical_load : callable
        Returns that load of scenes.
    largest : bool
        Which of the two.

    Returns
    -------
    ratio, coordinates : float, (axes, 1) array
        The ratio, and where it is.
    """
    free = box.varies
    side = -1.0 if largest else 1.0

    def ratios(coordinates: Floats) -> Floats:
        scene = box.scene(box.points(coordinates), fast=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(scene.load / critical_load(scene))

    best = np.zeros((0, 1))
    if free.any():
        first = np.hstack([corners(free)[free], sobol(int(free.sum()), _FIRST, _SEED)])
        generations = _GENERATIONS if box.space.is_bounded else _FEWER
        best, _ = evolve(lambda x: side * ratios(placed(free, x)), first, generations=generations, seed=_SEED)
    return float(ratios(placed(free, best))[0]), placed(free, best)


def regime_loads(box: UncertaintySet, highest: Regime) -> dict[str, Floats]:
    """Return the loads up to which every body on a line keeps to a regime, by the constraint that ends it."""
    loads = {}
    if highest is not Regime.HOPPING:
        loads["hop"] = box.hop_load
    if highest is Regime.FORWARD_SLIP:
        loads["back slip"] = back_slip_load(box)
    return loads


def onset_load(box: UncertaintySet) -> Floats:
    """Load above which the last body starts forward, Eq. (5).

    Over the drive angle it has one minimum, over the trough angle one maximum.
    """
    mu_s, angles = box.static_friction[1], box.shape["drive_angle"]
    hardest = np.clip(0.5 * np.pi - np.arctan(mu_s), *box.trough_angle)
    return np.maximum(*(critical_loads_of_lines(a, mu_s, mu_s, hardest).forward_onset for a in angles))


def back_slip_load(box: UncertaintySet, *, last: bool = False) -> Floats:
    """Load above which the first body, or the last, slips back.

    It rises with static friction and the drive angle and falls with kinetic friction and the trough angle
    (theory, section 14): a corner of the box. Two cases are searched: on a decline, where kinetic friction
    goes along with the static one, the edge of static frictions; where mu_s tan |beta| >= 1, trough angles.
    """
    sign = -1.0 if last else 1.0
    low, high = (np.asarray(end, np.float64) for end in box.trough_angle)
    load = _back_slip_load(box, low if last else high, sign)
    if np.all(low == high):
        return sign * load
    load = np.minimum(load, _back_slip_load(box, high if last else low, sign))
    if steeper_is_slower(box):
        return sign * load
    # So high a friction holds better on a steeper trough, and the extreme may lie between both ends. There
    # it is the only one (measured), which refined grids find.
    for _ in range(_ROUNDS):
        angles = np.linspace(0.0, 1.0, _SLOPES)
        betas = [low + share * (high - low) for share in angles]
        loads = np.array(np.broadcast_arrays(*(_back_slip_load(box, beta, sign) for beta in betas)))
        best = np.argmin(loads, axis=0)
        load = np.minimum(load, loads.min(axis=0))
        width = high - low
        low, high = (low + width * angles[np.clip(best + side, 0, _SLOPES - 1)] for side in (-1, 1))
    return sign * load


def _back_slip_load(box: UncertaintySet, beta: Floats | float, sign: float) -> Floats:
    """Return the least ``sign`` times load of back slip at one trough angle: sign -1 is of the last body."""
    first = sign > 0.0
    alpha = box.shape["drive_angle"][0 if first else 1]
    low, high = box.static_span

    def load(mu_s: Floats) -> Floats:
        mu_d = box.kinetic_span(mu_s)[1 if first else 0]
        return sign * np.asarray(critical_loads_of_lines(alpha, mu_s, mu_d, beta).back_slip)

    if np.all(np.asarray(beta) >= 0.0) or np.all(low == high):
        return load(np.asarray(low if first else high))
    start, end = (np.asarray(x, np.float64) for x in (low, high))
    for _ in range(_ROUNDS):
        mu_s = start + np.linspace(0.0, 1.0, _EDGE) * (end - start)
        loads = load(mu_s)
        best = np.argmin(loads, axis=-1)[..., None]
        around = (np.clip(best + side, 0, _EDGE - 1) for side in (-1, 1))
        start, end = (np.take_along_axis(np.broadcast_to(mu_s, loads.shape), i, -1) for i in around)
    least = np.take_along_axis(loads, best, -1)
    return least if np.ndim(alpha) else least[..., 0]


def tip_load(box: UncertaintySet, stand_ratio: float) -> Floats:
    """Load up to which no edge of any part lifts that starts from rest, Eq. (43); inf where none can.

    The onset that decides is least at an end of each band, or at the angle whose tangent is the stand ratio.
    """
    least = math.atan(stand_ratio)
    (a_low, a_high), mu_s = box.shape["drive_angle"], box.static_friction[1]
    loads = [
        tipping_load_of_lines(alpha, mu_s, beta, stand_ratio)
        for alpha in (a_low, a_high, np.clip(least, a_low, a_high))
        for beta in box.trough_angle
    ]
    return np.asarray(np.min(np.broadcast_arrays(*loads), axis=0))


def is_braked(box: UncertaintySet) -> bool:
    """Whether kinetic friction outweighs the weight down the trough for every body that slides forward."""
    steepest = box.trough_angle[0]
    kinetic, _ = box.kinetic_span(np.asarray(box.static_span[0]))
    return bool(kinetic * math.cos(steepest) + math.sin(steepest) >= 0.0)


def steeper_is_slower(box: UncertaintySet) -> bool:
    """Whether a steeper trough is slower for every body of all boxes, Eq. (53)."""
    steepest = np.maximum(*np.abs(box.trough_angle))
    return bool(np.all(box.static_friction[1] * np.tan(steepest) < 1.0))
