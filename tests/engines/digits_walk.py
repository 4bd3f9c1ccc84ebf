"""Steady cycles in arbitrary precision: a walk from event to event, independent of the solver.

It assumes nothing about the order of slides and rests, and uses nothing of the package: the body is
followed from rest until its motion repeats, with closed-form speeds and 60 digits.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import mpmath
from scipy.optimize import brentq

if TYPE_CHECKING:
    from collections.abc import Sequence

DIGITS: Final = 60
_CONTEXT: Final = mpmath.mp.clone()
_CONTEXT.dps = DIGITS
_TURN: Final = 2 * _CONTEXT.pi
_CLOSED: Final = _CONTEXT.mpf(10) ** (16 - DIGITS)  # [1] smaller differences count as none
_NEARLY: Final = _CONTEXT.mpf(10) ** (4 - DIGITS // 2)
_SHORT: Final = 1e-3  # [rad]
_STEP: Final = _CONTEXT.mpf(10) ** -20  # [1] relative change of an input, for derivatives

_WEAKEST: Final = 1e-14  # [m A w^2] friction that the digits resolve

_MOST_SLIDES: Final = 400
_MOST_STEPS: Final = 200
_TRY_EVERY: Final = 8  # [slides] between attempts to find the limit of a chain without rest


class Exact(NamedTuple):
    """A steady cycle from rest.

    Attributes
    ----------
    displacement : mpf
        Per drive cycle [A]; NaN where the body hops, runs away or has no memory of rest.
    pattern : str
        As ``SteadyCycle.pattern``; or ``hopping``, ``runaway``, ``indeterminate``; or empty if the walk was
        given up, because too little changes from one cycle to the next.
    """

    displacement: Any
    pattern: str


class _UndecidedError(Exception):
    """The digits do not suffice to decide what happens next."""


class _Body(NamedTuple):
    """Loads in m A w^2, as multiple-precision numbers; one tuple per direction, forward first."""

    along: Any
    across: Any
    normal: Any
    tangential: Any
    static_friction: Any
    # Phase at which a body at rest starts to slide that way, in the direction's own phase; None if it never
    # does.
    onsets: tuple[Any, Any]
    # Load amplitude while it slides that way, and the resistance divided by it.
    loads: tuple[Any, Any]
    resistances: tuple[Any, Any]


def exact_cycle(values: Sequence[Any]) -> Exact:
    """Follow one scene from rest until its motion repeats.

    Parameters
    ----------
    values : sequence
        Amplitude [m], frequency [Hz], drive angle [rad], mu_s, mu_d, trough angle [rad], gravity [m/s^2], as
        doubles, taken as exact, or multiple-precision numbers.

    Returns
    -------
    Exact
        Good to more than 30 digits of A.
    """
    values = [_CONTEXT.mpf(v) for v in values]
    body = _body(values)
    if body.across > body.normal:
        return Exact(_CONTEXT.nan, "hopping")
    if body.static_friction == 0 and body.tangential == 0:
        return Exact(_CONTEXT.nan, "indeterminate")
    if abs(body.tangential) > body.static_friction * body.normal:
        # The mean load along the trough is that of the weight, and here it exceeds what friction can balance.
        return Exact(_CONTEXT.nan, "runaway")
    try:
        return _Walk(body).run()
    except _UndecidedError:
        return Exact(_CONTEXT.nan, "")


def exact_sensitivity(values: Sequence[Any]) -> Any:
    """Sum over the inputs of the displacement's change per relative change of the input [A].

    The condition number of the displacement times the displacement; gravity is no input.
    """
    values = [_CONTEXT.mpf(v) for v in values]
    here = values[0] * exact_cycle(values).displacement
    total = _CONTEXT.mpf(0)
    for i in range(6):
        moved = [v * (1 + _STEP) if i == j else v for j, v in enumerate(values)]
        if i == 4 and moved[4] > moved[3]:  # mu_d stays below mu_s
            moved[4] = values[4] * (1 - _STEP)
        if i == 3 and moved[3] < moved[4]:
            moved[3] = values[3] * (1 - _STEP)
        total += abs(moved[0] * exact_cycle(moved).displacement - here) / (_STEP * values[0])
    return total


def _body(values: Sequence[Any]) -> _Body:
    amplitude, frequency, alpha, mu_s, mu_d, beta, gravity = values
    weight = gravity / (amplitude * (_TURN * frequency) ** 2)
    along, across = _CONTEXT.cos(alpha), _CONTEXT.sin(alpha)
    normal, tangential = weight * _CONTEXT.cos(beta), weight * _CONTEXT.sin(beta)
    onsets, loads, resistances = [], [], []
    for sign in (1, -1):
        load = along + sign * mu_s * across
        threshold = mu_s * normal + sign * tangential
        onsets.append(_CONTEXT.asin(threshold / load) if abs(threshold) < load else None)
        loads.append(along + sign * mu_d * across)
        resistances.append((mu_d * normal + sign * tangential) / loads[-1])
    return _Body(along, across, normal, tangential, mu_s, _pair(onsets), _pair(loads), _pair(resistances))


def _pair(items: Sequence[Any]) -> tuple[Any, Any]:
    first, second = items
    return first, second


class _Visit(NamedTuple):
    """Where and when a slide began: its phase since the start of the walk, its place, and its number."""

    phase: Any
    place: Any
    number: int


class _Walk:
    """One body, from rest at phase 0. Way 0 is forward, way 1 back; each has a zero of phase of its own."""

    def __init__(self, body: _Body) -> None:
        self.body = body
        self.phase = _CONTEXT.mpf(0)
        self.place = _CONTEXT.mpf(0)
        self.kinds: list[str] = []  # every slide and rest so far

    def run(self) -> Exact:
        """Walk until a slide begins as an earlier one did."""
        if self.body.static_friction * self.body.normal < _WEAKEST:
            raise _UndecidedError
        seen: dict[int, _Visit] = {}
        chain = 0  # slides since the last rest
        way = self._way_of_load()
        while len(self.kinds) < _MOST_SLIDES:
            if way is None:
                chain = 0
                way = self._rest()
                if way is None:
                    return Exact(_CONTEXT.mpf(0), "_")
                visit = _Visit(self.phase, self.place, len(self.kinds))
                if way in seen:
                    return self._cycle(seen[way], visit)
                seen[way] = visit
            elif way == 0 and chain % _TRY_EVERY in (2, 3):
                limit = self._limit_of_chain()
                if limit is not None:
                    return Exact(limit, "FB")
            if self._advance(way) is None:
                return Exact(_CONTEXT.nan, "runaway")
            self.kinds.append("FB"[way])
            chain += 1
            way = self._way_of_load()
        raise _UndecidedError

    def _own_phase(self, way: int) -> Any:
        """Phase in [-pi/2, 3 pi/2) since the load in this direction was zero and rising."""
        quarter = _TURN / 4
        return (self.phase - way * _CONTEXT.pi + quarter) % _TURN - quarter

    def _way_of_load(self) -> int | None:
        """Direction in which the load exceeds static friction now; None if it does not."""
        body = self.body
        sine = _CONTEXT.sin(self.phase)
        load = body.along * sine - body.tangential
        excess = abs(load) - body.static_friction * (body.normal - body.across * sine)
        if abs(excess) < _CLOSED and (body.tangential != 0 or body.across != 0):
            raise _UndecidedError
        if excess < _CLOSED:
            return None
        return 0 if load > 0 else 1

    def _rest(self) -> int | None:
        """Rest until the next onset, and return its way."""
        waits = [
            ((onset - self._own_phase(way)) % _TURN, way)
            for way, onset in enumerate(self.body.onsets)
            if onset is not None
        ]
        if not waits:
            return None
        wait, way = min(waits)
        self.phase += wait
        self.kinds.append("_")
        return way

    def _advance(self, way: int) -> Any:
        """Slide until it ends; return how much the end moves per change of the start, or None if never."""
        slide = _slide(self.body.loads[way], self.body.resistances[way], self._own_phase(way))
        if slide is None:
            return None
        self.phase += slide.length
        self.place += slide.distance if way == 0 else -slide.distance
        return slide.slope

    def _limit_of_chain(self) -> Any:
        """Displacement of the cycle of continuous sliding to which the walk tends; None without one.

        Plain walking takes hundreds of cycles at low friction, so Newton's method is used on the map from
        one forward start to the next. The map rises with a slope below 1 and therefore has a single fixed
        point; if the walk is a chain both here and there, it is a chain in between. Without friction every
        start is a fixed point.
        """
        frictionless = not any(self.body.resistances)
        start = self._own_phase(0)
        near = False
        while 0 < start < _CONTEXT.pi:
            turn = self._turn_of_chain(start)
            if turn is None:
                return None
            change, slope, displacement = turn
            if near or frictionless:
                return displacement
            if abs(1 - slope) < _CLOSED / _NEARLY:
                raise _UndecidedError
            step = change / (1 - slope)
            start += step
            near = abs(step) < _NEARLY
        return None

    def _turn_of_chain(self, start: Any) -> tuple[Any, Any, Any] | None:
        """Change of the forward start over a turn without rest, the map's slope, and the displacement."""
        walk = _Walk(self.body)
        walk.phase = start
        slope = 1
        for way in (0, 1):
            moved = walk._advance(way) if walk._way_of_load() == way else None
            if moved is None:
                return None
            slope *= moved
        if walk._way_of_load() != 0:
            return None
        return walk.phase - start - _TURN, slope, walk.place

    def _cycle(self, first: _Visit, again: _Visit) -> Exact:
        turns = round((again.phase - first.phase) / _TURN)
        kinds = "".join(self.kinds[first.number : again.number])
        while "__" in kinds:
            kinds = kinds.replace("__", "_")
        return Exact((again.place - first.place) / turns, _as_printed(kinds))


def _as_printed(kinds: str) -> str:
    """Rotate a cycle with rests so that it begins with a slide after a rest, or with its forward slide."""
    rotations = [kinds[i:] + kinds[:i] for i in range(len(kinds))]
    return min(rotations, key=lambda r: (r[0] == "_", r[0] == "B", r[-1] != "_"))


class _Slide(NamedTuple):
    """Length in phase, distance [A], and the change of the end per change of the start."""

    length: Any
    distance: Any
    slope: Any


def _slide(load: Any, resistance: Any, start: Any) -> _Slide | None:
    """Follow a slide that starts at rest; None if it never ends.

    Its speed over ``load`` is cos p0 - cos p - k (p - p0): it rises to p = pi - asin k and falls to
    2 pi + asin k, so its first zero lies between the two, or there is none (k <= 0).
    """
    cos, sin = _CONTEXT.cos_sin(start)
    turn = _CONTEXT.asin(max(resistance, -1)) if resistance < 1 else _CONTEXT.pi / 2
    low = _CONTEXT.pi - turn - start  # lengths since the start from here on
    high = _TURN + turn - start

    def speed(length: Any) -> tuple[Any, Any]:
        c, s = _CONTEXT.cos_sin(start + length)
        return cos - c - resistance * length, s - resistance

    if resistance <= 0 and speed(high)[0] > 0:
        return None
    if low < _SHORT:  # a slide symmetrical about its peak ends close to the true end, and never before it
        high = min(high, low + low * 1.01)
    x = _estimate(float(start), float(resistance), low, high)
    for _ in range(_MOST_STEPS):
        v, slope = speed(x)
        if v > 0:
            low = x
        else:
            high = x
        step = -v / slope if slope else high - low
        x += step
        if step * step <= _CLOSED * x * abs(slope):  # the remaining error is smaller than that
            break
        if not low <= x <= high:
            x = (low + high) / 2
    end = _CONTEXT.sin(start + x)
    distance = x * cos - (end - sin) - resistance * x * x / 2
    return _Slide(x, load * distance, (sin - resistance) / (end - resistance))


def _estimate(start: float, resistance: float, low: Any, high: Any) -> Any:
    """Find the end of a slide in double precision, or at least a point within its bracket."""

    def speed(length: float) -> float:
        half = 0.5 * length
        return 2.0 * math.sin(start + half) * math.sin(half) - resistance * length

    a, b = float(low), float(high)
    if speed(a) > 0.0 > speed(b):
        x = _CONTEXT.mpf(brentq(speed, a, b, xtol=1e-300, rtol=1e-15))
        if low < x < high:
            return x
    return (low + high) / 2
