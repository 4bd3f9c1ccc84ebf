"""One hopping body in arbitrary precision, from rest until its motion repeats: a witness for the solver.

Every bounce is an event of its own, with its impulse of friction, and the digits are doubled until they
decide nothing any more. It needs mpmath, and takes nothing from ``vibro``. Lengths are in A, speeds in A w,
loads in m A w^2; p = w t is the phase.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import mpmath

FEWEST_DIGITS: Final = 40
MOST_DIGITS: Final = 320
MOST_CYCLES: Final = 3000
MOST_LANDINGS: Final = 40_000
LEAST_BOUNCE: Final = 1e-12  # slower bounces on a trough that presses up count as contact: errors are squares
SAME: Final = 1e-18  # smaller differences of states count as none
SAME_CYCLE: Final = 1e-9  # differences of states on the same cycle, once it nearly repeats
NEARLY_SAME: Final = 1e-3  # the same after the most cycles: one that attracts slowly
AGREED: Final = 1e-15  # relative, of displacements with some digits and with twice as many
_LANDINGS_BACK: Final = 64  # of a cycle without contact
_SHORT: Final = 1e-3  # [A w] a slower take-off makes a short flight, nearly a parabola
_MOST_STEPS: Final = 10_000


class Settled(NamedTuple):
    """A steady motion from rest.

    Attributes
    ----------
    period : int
        Drive cycles until it repeats.
    displacement : float
        A drive cycle [A].
    peak : float
        Largest relative speed along the trough [A w].
    flight_fraction : float
        Share of time in flight.
    digits : int
        That decided it.
    change : float
        Difference of the states [A, A w] a period apart: not 0 where a cycle attracts so slowly that the body
        is not there yet.
    """

    period: int
    displacement: float
    peak: float
    flight_fraction: float
    digits: int
    change: float


def settled(values: Sequence[float]) -> Settled | None:
    """Follow one scene from rest with more and more digits, until twice as many change nothing.

    Parameters
    ----------
    values : sequence of float
        Fields of ``vibro.Scene``, in their order, taken as exact; the body must hop.

    Returns
    -------
    Settled or None
        None where no number of digits up to ``MOST_DIGITS`` shows a cycle that twice as many confirm.
    """
    digits = FEWEST_DIGITS
    before = None
    while digits <= MOST_DIGITS:
        now = follow(values, digits)
        if before is not None and now is not None and now.period == before.period:
            size = max(abs(now.displacement), abs(now.peak))
            if abs(now.displacement - before.displacement) <= AGREED * size:
                return before
        before, digits = now, 2 * digits
    return None


def follow(values: Sequence[float], digits: int) -> Settled | None:
    """Follow one scene from rest until its state recurs, with so many digits; None if it does not."""
    return _Body(values, digits).run()


class _Visit(NamedTuple):
    """A state after a landing, or at a lift-off from contact, and what led to it from the one before."""

    lifts: bool
    cycle: int
    phase: Any
    rise: Any
    velocity: Any
    place: Any
    flying: Any  # phase spent in flight so far
    peak: Any  # largest speed since the visit before

    def change(self, other: _Visit) -> float:
        """Difference of the states since an earlier visit; inf where they cannot be compared."""
        if self.lifts != other.lifts or self.cycle == other.cycle:
            return math.inf
        return float(max(abs(self[i] - other[i]) for i in (2, 3, 4)))


class _Course(NamedTuple):
    """Motion from a phase on under a load C sin p - k."""

    context: Any
    phase: Any
    place: Any
    rate: Any
    load: Any
    pull: Any
    cos: Any
    sin: Any

    @classmethod
    def of(cls, context: Any, phase: Any, place: Any, rate: Any, load: Any, pull: Any) -> _Course:
        return cls(context, phase, place, rate, load, pull, *context.cos_sin(phase))

    def after(self, t: Any) -> tuple[Any, Any, Any]:
        """Place, its rate, and the load after a while."""
        cos, sin = self.context.cos_sin(self.phase + t)
        swing = self.rate + self.load * self.cos
        place = self.place + swing * t - self.load * (sin - self.sin) - self.pull * t * t / 2
        return place, swing - self.load * cos - self.pull * t, self.load * sin - self.pull

    def crossing(self, which: int, low: Any, high: Any, guess: Any = None) -> Any:
        """Find where place (0) or rate (1) changes its sign for good, once in (low, high]."""
        if self.context is not mpmath.fp:  # a good start from doubles
            rough = _Course(mpmath.fp, *(float(x) for x in self[1:]))
            guess = self.context.mpf(rough.crossing(which, float(low), float(high), guess))
        sign = 1 if self.after(high)[which] <= 0 else -1
        t = guess if guess is not None and low < guess < high else (low + high) / 2
        for _ in range(_MOST_STEPS):
            value, slope = self.after(t)[which : which + 2]
            if sign * value > 0:
                low = t
            else:
                high = t
            new = t - value / slope if slope else low
            if not low < new < high:
                new = (low + high) / 2
            noise = 8 * self.context.eps * (1 + t) * (1 + 1 / abs(slope)) if slope else 0
            if abs(new - t) <= noise or not low < new < high:
                return new
            t = new
        raise ArithmeticError("no zero")


class _Body:
    """One body from rest at phase 0."""

    def __init__(self, values: Sequence[float], digits: int) -> None:
        self.context = context = mpmath.mp.clone()
        context.dps = digits
        amplitude, frequency, alpha, self.mu_s, self.mu_d, beta, gravity, self.e = map(context.mpf, values)
        self.turn = 2 * context.pi
        weight = gravity / (amplitude * (self.turn * frequency) ** 2)
        self.along, self.across = context.cos(alpha), context.sin(alpha)
        self.normal, self.tangential = weight * context.cos(beta), weight * context.sin(beta)
        if self.across <= self.normal:
            raise ValueError("the body does not hop")
        self.lifts = context.asin(self.normal / self.across)
        self.presses = context.pi - self.lifts
        self.cycle, self.phase, self.place, self.rise, self.velocity = 0, *(context.zero,) * 4
        self.flying, self.peak, self.landings, self.lifted = context.zero, context.zero, 0, False
        self.loads = {way: self._load(way) for way in (0, 1, -1)}
        self.visits: list[_Visit] = []
        self.last_lift = 0

    def run(self) -> Settled | None:
        """Follow the body until a visit recurs."""
        self._stay()
        while self.cycle < MOST_CYCLES and self.landings < MOST_LANDINGS:
            if found := self._visit(SAME):
                return found
            self._fly()
            if self._land():
                self._stay()
        return self._visit(NEARLY_SAME)

    def _visit(self, within: float) -> Settled | None:
        """Note the state; if it is one of before, what happened since is the cycle."""
        here = _Visit(
            self.lifted, self.cycle, self.phase, self.rise, self.velocity, self.place, self.flying, self.peak
        )
        self.peak = abs(self.velocity)
        self.visits.append(here)
        last = len(self.visits) - 1
        if here.lifts:  # all since the lift-off before but the velocity is as it was after that one
            candidates, self.last_lift = [self.last_lift], last
        else:
            candidates = list(range(last - 1, max(last - _LANDINGS_BACK, self.last_lift), -1))
        changes = [here.change(self.visits[i]) for i in candidates]
        if not min(changes, default=math.inf) < within:
            return None
        # Where a cycle attracts in turns from either side, twice its period is the first to change so little.
        first = next(
            i for i, change in zip(candidates, changes, strict=True) if change < max(within, SAME_CYCLE)
        )
        before = self.visits[first]
        period = here.cycle - before.cycle
        return Settled(
            period,
            float((here.place - before.place) / period),
            float(max(visit.peak for visit in self.visits[first + 1 :])),
            float((here.flying - before.flying) / (period * self.turn)),
            self.context.dps,
            here.change(before),
        )

    def _later(self, phase: Any) -> Any:
        """Phase until another."""
        return (phase - self.phase) % self.turn

    def _proceed(self, t: Any) -> None:
        cycles = int(self.context.floor((self.phase + t) / self.turn))
        self.phase += t - cycles * self.turn
        self.cycle += cycles

    def _load(self, way: int) -> tuple[Any, Any, list[Any]]:
        """Form the load C sin p - k of a slide one way, or in flight (0): C, k, and phases of its zeros."""
        load = self.along + way * self.mu_d * self.across
        pull = self.tangential + way * self.mu_d * self.normal
        if abs(pull) >= abs(load):
            return load, pull, []
        zero = self.context.asin(pull / load)
        return load, pull, [zero, self.context.pi - zero]

    def _course(self, way: int) -> _Course:
        load, pull, _ = self.loads[way]
        return _Course.of(self.context, self.phase, self.place, self.velocity, load, pull)

    def _move(self, way: int, t: Any) -> None:
        """Move along the trough for a while, and note the largest speed."""
        course = self._course(way)
        self.place, self.velocity, _ = course.after(t)
        self.peak = max(self.peak, abs(course.rate), abs(self.velocity))
        for zero in self.loads[way][2]:
            first = self._later(zero)
            if first < t:
                last = first + self.turn * self.context.floor((t - first) / self.turn)
                self.peak = max(self.peak, abs(course.after(first)[1]), abs(course.after(last)[1]))
        self._proceed(t)

    def _fly(self) -> None:
        """Fly to the first zero of the height."""
        zero = self.context.zero
        height = _Course.of(self.context, self.phase, zero, self.rise, self.across, self.normal)
        if self.lifted:
            height = height._replace(sin=self.normal / self.across)
        lifts, presses = self._later(self.lifts), self._later(self.presses)
        curves_up = self.lifted or presses < lifts
        before, after = zero, presses if curves_up else lifts
        up = self.presses - self.lifts
        while (t := self._landing(height, before, after, curves_up)) is None:
            curves_up = not curves_up
            before, after = after, after + (up if curves_up else self.turn - up)
        self.flying += t
        self.rise = height.after(t)[1]
        self._move(0, t)

    def _landing(self, height: _Course, before: Any, after: Any, curves_up: bool) -> Any:
        """First zero of the height in a part of the flight where it curves one way; None if there is none."""
        if curves_up:
            if (height.rate if before == 0 else height.after(before)[1]) >= 0:
                return None
            if height.after(after)[1] > 0:
                after = height.crossing(1, before, after)
        if after == before or height.after(after)[0] > 0:
            return None
        net = height.load * height.sin - height.pull
        short = before == 0 and height.rate < _SHORT
        return height.crossing(0, before, after, -2 * height.rate / net if short else None)

    def _land(self) -> bool:
        """Apply the impulses of an impact: normal, and friction up to what stops the body.

        Returns whether contact follows: the bounces to come would end while hardly anything changes. Then the
        impact is plastic, and contact carries the weight meanwhile, just as the bounces would.
        """
        cos, sin = self.context.cos_sin(self.phase)
        impact = max(-self.rise, self.context.zero)
        presses = self.normal - self.across * sin
        rise = self.e * impact
        stays = False
        if presses > 0 and rise <= LEAST_BOUNCE:
            lasting = 2 * rise / (presses * (1 - self.e))
            stays = bool(abs(self.across * cos) * lasting <= LEAST_BOUNCE * presses)
            self.flying += lasting if stays else 0
        self.rise = self.context.zero if stays else rise
        lost = self.mu_d * (impact + self.rise)
        self.velocity = self.context.sign(self.velocity) * max(abs(self.velocity) - lost, self.context.zero)
        self.lifted = False
        self.landings += 1
        return stays

    def _stay(self) -> None:
        """Slide and rest until the trough lets go."""
        way = int(self.context.sign(self.velocity))
        while True:
            starts = not way
            way = way or self._slips() or self._rest()
            t = self._stop(way, starts)
            if t is None:
                break
            self._move(way, t)
            self.velocity, way = self.context.zero, 0
        self._move(way, self._later(self.lifts))
        self.phase, self.rise, self.lifted = self.lifts, self.context.zero, True

    def _slips(self) -> int:
        """Which way a body starts to slide that has stopped; 0 if it rests."""
        sin = self.context.sin(self.phase)
        load = self.along * sin - self.tangential
        if abs(load) <= self.mu_s * (self.normal - self.across * sin):
            return 0
        return 1 if load > 0 else -1

    def _rest(self) -> int:
        """Rest until a slide starts; the way of it. Forward it starts before a lift-off."""
        waits = []
        for way, zero in ((1, 0), (-1, self.context.pi)):
            load = self.along + way * self.mu_s * self.across
            threshold = self.mu_s * self.normal + way * self.tangential
            if threshold < load:
                waits.append((self._later(zero + self.context.asin(threshold / load)), way))
        wait, way = min(waits)
        self._proceed(wait)
        return way

    def _stop(self, way: int, starts: bool) -> Any:
        """Time until a slide stops; None if the body lifts off before."""
        course, before, whole = self._course(way), self.context.zero, self._later(self.lifts)
        bounds = [min(self._later(zero), whole) for zero in self.loads[way][2]]
        for after in sorted([*bounds, whole]):
            falls = way * course.after((before + after) / 2)[2] < 0 and not (starts and before == 0)
            if after > before and falls and way * course.after(after)[1] <= 0:
                return course.crossing(1, before, after)
            before = after
        return None
