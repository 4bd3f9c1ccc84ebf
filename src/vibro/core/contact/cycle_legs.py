"""The legs of one scene's steady contact cycle: when it slides which way, and when it rests."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibro.core.codes import PATTERNS
from vibro.core.contact.never_at_rest import never_at_rest
from vibro.core.contact.onset import thresholds
from vibro.core.contact.slide import slide, start_inside
from vibro.core.contact.starts import resting_start

if TYPE_CHECKING:
    from vibro.core.contact.slide import Onset
    from vibro.core.groups import Loads

__all__ = ["CycleLeg", "cycle_legs"]

_TURN = 2.0 * math.pi


class CycleLeg(NamedTuple):
    """One leg of a cycle.

    Attributes
    ----------
    kind : str
        F forward slide, B back slide, _ rest, as in a pattern.
    start, end : float
        Drive phase [rad]; the first start lies in [0, 2 pi), each other one at the end before it.
    displacement : float
        Displacement relative to the trough during the leg [A].
    """

    kind: str
    start: float
    end: float
    displacement: float


def cycle_legs(scene: Loads, pattern_code: int) -> list[CycleLeg]:
    """Legs of the steady cycle of one scene, in the order of its pattern.

    Parameters
    ----------
    scene : Loads
        Groups of one scene, each of shape (1,).
    pattern_code : int
        The scene's pattern, from ``steady_state``.

    Returns
    -------
    list of CycleLeg
        Empty where there is no steady contact cycle.
    """
    pattern = PATTERNS[pattern_code] if 0 <= pattern_code < len(PATTERNS) else ""
    if pattern in ("", "_"):
        return [CycleLeg("_", 0.0, _TURN, 0.0)] if pattern else []
    slides = _slides(scene, pattern)
    shift = _TURN * math.floor(slides[0].start / _TURN)
    legs = [s._replace(start=s.start - shift, end=s.end - shift) for s in slides]
    for i, kind in enumerate(pattern):
        if kind == "_":
            until = legs[i].start if i < len(legs) else legs[0].start + _TURN
            legs.insert(i, CycleLeg("_", legs[i - 1].end, until, 0.0))
    return legs


def _slides(scene: Loads, pattern: str) -> list[CycleLeg]:
    """Solve the slides of a cycle, without its rests, in the order of the pattern."""
    margins = thresholds(scene).margins
    forward = resting_start(scene, margins, 1) if "F" in pattern else None
    back = resting_start(scene, margins, -1) if "B" in pattern else None
    if pattern == "FB" and forward and back:
        cycle, _ = never_at_rest(scene, forward, back)
        m, x = math.pi - math.asin(cycle.sin_m.item()), 0.5 * math.pi + cycle.y.item()
        ahead = start_inside(0.5 * np.pi - (m - x) + 0.0 * cycle.y, forward.onset.k)
        behind = start_inside(1.5 * np.pi - (m + x) + 0.0 * cycle.y, back.onset.k)
        return [_slide_leg("F", ahead, forward.load), _slide_leg("B", behind, back.load)]
    if pattern == "FB_" and forward and back:
        first = _slide_leg("F", forward.onset, forward.load)
        return [first, _after(first, back.onset, back.load)]
    if pattern == "F_B" and forward and back:
        second = _slide_leg("B", back.onset, back.load)
        first = _after(second, forward.onset, forward.load)
        return [first, second._replace(start=second.start + _TURN, end=second.end + _TURN)]
    slides = []
    if forward:
        slides.append(_slide_leg("F", forward.onset, forward.load))
    if back:
        slides.append(_slide_leg("B", back.onset, back.load))
    return slides


def _slide_leg(kind: str, onset: Onset, load: np.ndarray) -> CycleLeg:
    """Solve one slide; a back slide's phases lie half a turn later, its displacement is negative."""
    end = slide(onset)
    start = 0.5 * math.pi - onset.c.item() + (math.pi if kind == "B" else 0.0)
    sign = -1.0 if kind == "B" else 1.0
    return CycleLeg(kind, start, start + 2.0 * end.x.item(), sign * (load * end.reach).item())


def _after(before: CycleLeg, resting: Onset, load: np.ndarray) -> CycleLeg:
    """Solve the opposite slide that follows another one directly."""
    kind = "B" if before.kind == "F" else "F"
    zero = math.pi if kind == "B" else _TURN
    c = 0.5 * np.pi - (before.end - zero) + 0.0 * resting.c
    slid = _slide_leg(kind, start_inside(c, resting.k), load)
    return slid._replace(start=before.end, end=before.end + (slid.end - slid.start))
