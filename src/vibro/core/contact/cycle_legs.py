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
from vibro.core.contact.windows import own_phase

if TYPE_CHECKING:
    from vibro.core.contact.never_at_rest import NeverAtRest
    from vibro.core.contact.slide import Floats, Onset
    from vibro.core.groups import Loads

__all__ = ["CycleLeg", "cycle_legs", "middle_of", "zero_of"]

_TURN = 2.0 * math.pi
_WAYS = {"F": 1, "B": -1}
_ROUNDING = 1e-9  # [1] of a turn: two phases so close are one


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


def middle_of(scene: Loads, cycle: NeverAtRest) -> Floats:
    """Phase of the middle of the forward slide of a cycle without a rest."""
    if scene.lead:
        return np.asarray(scene.lead.angle + np.pi - np.arctan2(cycle.sin_m, cycle.cos_m))
    return np.asarray(np.pi - np.arcsin(cycle.sin_m))


class _Way(NamedTuple):
    """Slides in one direction: the drive phase of their load's zero, their start from rest and their load."""

    kind: str
    zero: float
    resting: Onset
    load: Floats


def _slides(scene: Loads, pattern: str) -> list[CycleLeg]:
    """Solve the slides of a cycle, without its rests, in the order of the pattern."""
    margins = thresholds(scene).margins
    resting = {kind: resting_start(scene, margins, _WAYS[kind]) for kind in pattern if kind in _WAYS}
    ways = {
        kind: _Way(kind, zero_of(scene, _WAYS[kind]).item(), start.onset, start.load)
        for kind, start in resting.items()
    }
    if pattern == "FB":
        cycle, _ = never_at_rest(scene, resting["F"], resting["B"])
        lead = scene.lead.angle.item() if scene.lead else 0.0
        m, x = middle_of(scene, cycle).item() - lead, 0.5 * math.pi + cycle.y.item()
        return [_slide_from(ways["F"], m - x), _slide_from(ways["B"], m + x)]
    if pattern == "FB_":
        first = _slide_leg(ways["F"], ways["F"].resting)
        return [first, _slide_from(ways["B"], first.end)]
    if pattern == "F_B":
        second = _slide_leg(ways["B"], ways["B"].resting)
        first = _slide_from(ways["F"], second.end)
        return [first, _later(second, first.end)]
    slides = [_slide_leg(way, way.resting) for way in ways.values()]
    return [slides[0], *(_later(leg, slides[0].end) for leg in slides[1:])]


def zero_of(scene: Loads, way: int) -> Floats:
    """Drive phase at which the load of slides, forward (+1) or back (-1), is zero and rises."""
    if scene.lead:
        return np.asarray(-(own_phase(scene, way) + scene.lead.angle))
    return np.asarray(math.pi if way < 0 else 0.0)


def _slide_leg(way: _Way, onset: Onset) -> CycleLeg:
    """Solve one slide; the displacement of a back slide is negative."""
    end = slide(onset)
    start = 0.5 * math.pi - onset.c.item() + way.zero
    path = _WAYS[way.kind] * (way.load * end.reach).item()
    return CycleLeg(way.kind, start, start + 2.0 * end.x.item(), path)


def _slide_from(way: _Way, start: float) -> CycleLeg:
    """Solve a slide that starts at a drive phase, at once after another one."""
    c = 0.5 * math.pi - (start - way.zero)
    slid = _slide_leg(way, start_inside(c - _TURN * round(c / _TURN) + 0.0 * way.resting.c, way.resting.k))
    return slid._replace(start=start, end=start + (slid.end - slid.start))


def _later(leg: CycleLeg, end: float) -> CycleLeg:
    """Move a slide by whole turns, to the first that begins at the end of another one or after it."""
    turns = math.ceil((end - leg.start) / _TURN - _ROUNDING)
    return leg._replace(start=leg.start + _TURN * turns, end=leg.end + _TURN * turns)
