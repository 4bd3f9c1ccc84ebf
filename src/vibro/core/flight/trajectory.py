"""One flight: from take-off to the first return to the trough.

The normal motion is free of friction, so that a flight depends on K = G sin(alpha) / cos(beta), its
take-off phase and its take-off speed alone. Normal speeds are over n = cos(beta)/G [A w n], phases in
radians; eta'' / n = K sin p - 1.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.free import free_motion
from vibro.core.groups import take
from vibro.core.roots import OpenCells
from vibro.core.series import sine_gap

if TYPE_CHECKING:
    from vibro.core.contact.slide import Floats

__all__ = ["ONE_CYCLE", "Flight", "flight", "lift_off_flight"]

_TURN: Final = 2.0 * np.pi

#: [1] sqrt(K^2 - 1) up to which a flight from rest on the trough lasts at most one drive cycle.
ONE_CYCLE: Final = np.pi

_WEIGHT: Final = np.ones(())  # on the trough [n]

_TABLE: Final = 2048  # nodes of the first estimate; leaves 1e-6 relative to one Halley step
_NEWTON_STEPS: Final = 60  # monotone, quadratic but for grazing landings; few cells need more than 8
_SETTLED: Final = 1e-8  # [1] a last Newton step below this fraction of the length leaves rounding errors only

# [1] Newton's iteration from the far end of a turn needs many steps to the landing of a short bounce, which
# lasts 2 v / N. Start it this much of v / N after the take-off, if that is after the landing: half the steps.
_SHORT_BOUNCE: Final = 2.2


class Flight(NamedTuple):
    """End of a flight.

    Attributes
    ----------
    length : array
        Phase from take-off to landing [rad].
    impact : array
        Speed towards the trough at landing, >= 0 [A w n].
    """

    length: Floats
    impact: Floats


def _half_angle(s: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Compute h = s/2, sin h, 1 - cos h and h - sin h, for 0 <= s <= 2 pi."""
    h = 0.5 * s
    t = np.tan(0.5 * h)
    sine = 2.0 * t / (1.0 + t * t)
    return h, sine, sine * t, sine_gap(h)


@cache
def _lift_off_table() -> tuple[Floats, Floats]:
    """Flight length and the sqrt(K^2 - 1) it belongs to: Eq. (32) solved for K has no root to find."""
    s = np.linspace(0.0, _TURN, _TABLE)
    h, sine, versine, gap = _half_angle(s[1:])
    c = gap * (h + sine) / (gap + sine * versine)
    return np.concatenate(([0.0], c)), s


def lift_off_flight(c: Floats) -> Flight:
    """Flight of a body that the trough leaves at rest, sin p = 1/K, within one drive cycle.

    Parameters
    ----------
    c : array
        sqrt(K^2 - 1), in (0, ONE_CYCLE].

    Notes
    -----
    c is a monotone function of the flight's length, so that the root is the only one. One step of Halley's
    iteration, written in terms that do not cancel for short flights.
    """
    s = np.interp(c, *_lift_off_table())
    h, sine, versine, gap = _half_angle(s)
    level = c * (gap + sine * versine) - gap * (h + sine)  # eta / 2
    slope = c * sine * sine - gap - sine * versine  # eta' / 2
    bend = 2.0 * (c * sine * (1.0 - versine) - sine * sine)  # eta''
    length = s - level * slope / (slope * slope - 0.25 * level * bend)
    h, sine, versine, gap = _half_angle(length)
    return Flight(length, 2.0 * (gap + sine * versine - c * sine * sine))


class _Path(NamedTuple):
    """Flights by what decides them: K, sin and cos of the take-off phase, take-off speed."""

    throw: Floats
    sine: Floats
    cosine: Floats
    speed: Floats


def _height(s: Floats, at: _Path) -> tuple[Floats, Floats]:
    """Height over n and its rate, a phase s after take-off, Eq. (30)."""
    return free_motion(at.throw, _WEIGHT, at.sine, at.cosine, at.speed, s)


def flight(throw: Floats, phase: Floats, speed: Floats) -> Flight:
    """Flight from any take-off.

    Parameters
    ----------
    throw : array
        Throw number K > 1, 1-D.
    phase : array
        Phase of take-off [rad]; where the speed is 0 it lies where K sin p >= 1.
    speed : array
        Speed of take-off, >= 0 [A w n].

    Notes
    -----
    Seen from the ground the body flies along a parabola, and every crest of the trough that the parabola
    does not clear ends the flight. So the landing lies in the turn before the first crest, or, if that is
    cleared, in the turn before the first crest after the parabola's way down. Within such a turn the
    height is convex, concave and convex again, and in each piece Newton's iteration from the proper end
    meets the first zero monotonically, or proves that there is none.
    """
    at = _Path(throw, np.sin(phase), np.cos(phase), speed)
    crest = np.mod(0.5 * np.pi - phase, _TURN)
    rise = speed + throw * at.cosine
    depth = throw * (1.0 - at.sine)
    clearance = rise * rise - 2.0 * depth  # of the parabola's apex over the crests, doubled
    with np.errstate(invalid="ignore"):
        down = np.where(rise > 0.0, rise + np.sqrt(clearance), 0.0)
    cleared = down > crest
    sure = cleared & (speed == 0.0)  # accelerated off the trough up to the crest
    length = np.full(phase.shape, np.nan)
    first = np.flatnonzero(~sure)
    if first.size:
        part = take(at, first)
        length[first] = _landing(part, np.zeros(first.size), crest[first])
    later = np.flatnonzero(np.isnan(length))
    if later.size:
        part = take(at, later)
        start = np.where(cleared[later], down[later], crest[later])
        end = start + np.mod(0.5 * np.pi - phase[later] - start, _TURN)
        found = _landing(part, start, end)
        length[later] = np.where(np.isnan(found), end, found)
    return Flight(length, -_height(length, at)[1])


def _landing(at: _Path, start: Floats, crest: Floats) -> Floats:
    """First zero of the height after ``start`` and up to the next crest; NaN where there is none."""
    lift_off = np.arcsin(1.0 / at.throw)
    second = np.maximum(start, crest - 0.5 * np.pi + lift_off)
    first = np.maximum(start, crest - 1.5 * np.pi - lift_off)
    found = np.full(start.shape, np.nan)
    cells = np.flatnonzero((start > 0.0) & (first > start))
    if cells.size:
        # where the height at the end of the first piece is positive and still falling, the piece has no zero
        height, rate = _height(first[cells], take(at, cells))
        cells = cells[(height < 0.0) | (rate > 0.0)]
    if cells.size:
        found[cells] = _newton(take(at, cells), start[cells], first[cells])
    height, _ = _height(second, at)
    sinks = height < 0.0
    cells = np.flatnonzero(sinks & (at.speed > 0.0) & (first == 0.0))
    if cells.size:
        part = take(at, cells)
        with np.errstate(divide="ignore"):
            near = _SHORT_BOUNCE * part.speed / np.maximum(1.0 - part.throw * part.sine, 0.0)
        near = np.minimum(near, second[cells])
        second[cells] = np.where(_height(near, part)[0] < 0.0, near, second[cells])
    cells = np.flatnonzero(np.isnan(found))
    found[cells] = _newton(take(at, cells), second[cells], np.where(sinks[cells], np.inf, crest[cells]))
    return found


def _newton(at: _Path, start: Floats, end: Floats) -> Floats:
    """Zero of the height by Newton's iteration; NaN where it turns round or passes ``end`` first."""
    zero = np.empty(start.shape)
    open_cells = OpenCells(np.arange(start.size), (at, start, end), _NEWTON_STEPS)
    with np.errstate(divide="ignore", invalid="ignore"):
        for cells, (path, s, last) in open_cells:
            height, rate = _height(s, path)
            step = np.where(height == 0.0, 0.0, -height / rate)
            moved = s + step
            lost = (rate >= 0.0) | (moved > last)
            zero[cells] = np.where(lost, np.nan, moved)
            open_cells.keep(~lost & (np.abs(step) > _SETTLED * moved), (path, moved, last))
    return zero
