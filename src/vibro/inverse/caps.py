"""Loads up to which every body of a box keeps to a regime, or stays upright."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from vibro.core.codes import Regime
from vibro.limits import critical_loads_of_lines, tipping_load_of_lines

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.inverse.boxes import Box, Parts

    Floats = NDArray[np.float64]

__all__ = ["back_slip_load", "hop_load", "onset_load", "regime_loads", "tip_load"]

_EDGE: Final = 65  # static frictions at which an edge of the box is looked at
_ROUNDS: Final = 5  # of looking closer, each by a factor of 32


def hop_load(box: Parts) -> Floats:
    """Load above which the first body hops, Eq. (4): on the steepest trough, with the steepest drive."""
    b_low, b_high = box.trough_angle
    with np.errstate(divide="ignore"):
        return np.asarray(np.minimum(np.cos(b_low), np.cos(b_high)) / box.lift)


def regime_loads(box: Box, highest: Regime) -> dict[str, Floats]:
    """Return the loads up to which every body keeps to a regime, by what ends there."""
    loads = {}
    if highest is not Regime.HOPPING:
        loads["hop"] = hop_load(box)
    if highest is Regime.FORWARD_SLIP:
        loads["back slip"] = back_slip_load(box)
    return loads


def onset_load(box: Box) -> Floats:
    """Load above which the last body starts forward, Eq. (5).

    Over the drive angle it has one minimum, over the trough angle one maximum.
    """
    mu_s, (low, high) = box.static_friction[1], box.trough_angle
    hardest = np.clip(0.5 * np.pi - np.arctan(mu_s), low, high)
    return np.maximum(
        *(critical_loads_of_lines(alpha, mu_s, mu_s, hardest).forward_onset for alpha in box.drive_angle)
    )


def back_slip_load(box: Box) -> Floats:
    """Load above which the first body slips back.

    It rises with static friction and the drive angle and falls with kinetic friction and the trough angle
    (theory.md, section 14): a corner of the box. Only on a decline, where kinetic friction goes along with
    the static one, it may fall on the way: there the edge is searched.
    """
    least, most = box.trough_angle
    load = _back_slip_load(box, most)
    # where friction is so high that it holds better on a slope, either end may be the first
    return load if np.all(least == most) else np.minimum(load, _back_slip_load(box, least))


def _back_slip_load(box: Box, beta: Floats | float) -> Floats:
    """Return the same at one trough angle."""
    alpha = box.drive_angle[0]
    low, high = box.static_span

    def load(mu_s: Floats) -> Floats:
        return np.asarray(critical_loads_of_lines(alpha, mu_s, box.kinetic_span(mu_s)[1], beta).back_slip)

    if np.all(np.asarray(beta) >= 0.0) or np.all(low == high):
        return load(np.asarray(low))
    start, end = (np.asarray(x, np.float64) for x in (low, high))
    for _ in range(_ROUNDS):
        mu_s = start + np.linspace(0.0, 1.0, _EDGE) * (end - start)
        loads = load(mu_s)
        best = np.argmin(loads, axis=-1)[..., None]
        around = (np.clip(best + side, 0, _EDGE - 1) for side in (-1, 1))
        start, end = (np.take_along_axis(np.broadcast_to(mu_s, loads.shape), i, -1) for i in around)
    least = np.take_along_axis(loads, best, -1)
    return least if np.ndim(alpha) else least[..., 0]


def tip_load(box: Box, stand_ratio: float) -> Floats:
    """Load up to which no edge of any part lifts that starts from rest, Eq. (43); inf where none can.

    The onset that decides is least at an end of each band, or at the angle whose tangent is the stand ratio.
    """
    least = math.atan(stand_ratio)
    (a_low, a_high), mu_s = box.drive_angle, box.static_friction[1]
    loads = [
        tipping_load_of_lines(alpha, mu_s, beta, stand_ratio)
        for alpha in (a_low, a_high, np.clip(least, a_low, a_high))
        for beta in box.trough_angle
    ]
    return np.asarray(np.min(np.broadcast_arrays(*loads), axis=0))
