"""A body on a trough that moves along two axes, followed from event to event; nothing of the package.

Along the trough x = X sin p, normal to it y = Y sin(p + phi), p = w t. Every acceleration is a constant and
one sinusoid. Between two changes of sign of its derivative a function is monotone, and Brent's method finds
its one zero there: of the acceleration first, with these of the velocity, and with those of the height.
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, NamedTuple

from scipy.optimize import brentq

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

TURN = 2.0 * math.pi
LONGEST = 40  # legs of a cycle
SAME = 1e-13  # [rad, relative] a leg and its repetition differ by less
# [1] A bounce that takes off slower than this, over the load [g/w], is left out: an error of its square.
LEAST_BOUNCE = 1e-6


class NeverSettlesError(ArithmeticError):
    """The motion has no cycle that the walk could see."""


class NeverEndsError(ArithmeticError):
    """A slide gains speed every turn."""


class Arc(NamedTuple):
    """Motion under the acceleration first + sine sin(s) - cosine (1 - cos(s)), s phase since its start."""

    velocity0: float
    first: float
    sine: float
    cosine: float

    def acceleration(self, s: float) -> float:
        return self.first + self.sine * math.sin(s) - self.cosine * 2.0 * math.sin(0.5 * s) ** 2

    def velocity(self, s: float) -> float:
        bend = self.sine * 2.0 * math.sin(0.5 * s) ** 2 - self.cosine * (s - math.sin(s))
        return self.velocity0 + self.first * s + bend

    def path(self, s: float) -> float:
        half = math.sin(0.5 * s)
        bend = self.sine * (s - math.sin(s)) - self.cosine * 2.0 * (0.5 * s - half) * (0.5 * s + half)
        return self.velocity0 * s + 0.5 * self.first * s * s + bend

    def crests(self) -> Iterator[float]:
        """Extremes of the acceleration after the start."""
        first = math.atan2(self.sine, self.cosine) % math.pi
        return (first + i * math.pi for i in itertools.count(0 if first > 0.0 else 1))

    def turns(self) -> Iterator[float]:
        """Extremes of the velocity after the start, and the extremes of the acceleration between them."""
        return _zeros_and_ends(self.acceleration, self.crests())

    def stop(self) -> float:
        """Return where a positive velocity first falls to zero."""
        gains = self.first - self.cosine >= 0.0  # a whole turn takes no speed away
        for low, high in itertools.pairwise(itertools.chain((0.0,), self.turns())):
            if self.velocity(low) > 0.0 >= self.velocity(high):
                return _zero(self.velocity, low, high)
            if low > 2.0 * TURN:
                if gains:
                    raise NeverEndsError
                assert self.velocity(low) > 0.0
        raise AssertionError

    def landing(self) -> float:
        """Return where a positive height first falls to zero."""
        for low, high in itertools.pairwise(
            itertools.chain((0.0,), _zeros_and_ends(self.velocity, self.turns()))
        ):
            if self.path(low) > 0.0 >= self.path(high):
                return _zero(self.path, low, high)
        raise AssertionError

    def opening(self) -> float:
        """Return where the acceleration first rises through zero; inf where it never does."""
        for low, high in itertools.pairwise(itertools.chain((0.0,), self.crests())):
            if self.acceleration(low) <= 0.0 < self.acceleration(high):
                return _zero(self.acceleration, low, high)
            if low > TURN:
                break
        return math.inf

    def fastest(self, length: float) -> float:
        """Return the largest speed up to a phase."""
        extremes = itertools.takewhile(lambda s: s < length, self.turns())
        return max(abs(self.velocity(s)) for s in (0.0, *extremes, length))


def _zero(f: Callable[[float], float], low: float, high: float) -> float:
    return high if f(high) == 0.0 else float(brentq(f, low, high, xtol=1e-15, rtol=1e-15))


def _zeros_and_ends(f: Callable[[float], float], ends: Iterator[float]) -> Iterator[float]:
    """Ends of pieces on which a function is monotone, and its zeros between them."""
    for low, high in itertools.pairwise(itertools.chain((0.0,), ends)):
        if f(low) * f(high) < 0.0:
            yield _zero(f, low, high)
        yield high


class Leg(NamedTuple):
    """F, B, _ or H; start and length [rad], path [g/w^2], largest speed and a flight's impact speed [g/w]."""

    kind: str
    start: float
    length: float
    path: float
    peak: float
    impact: float = 0.0


class Cycle(NamedTuple):
    """What a walk repeats: displacement per drive cycle [g/w^2], largest speed and impact speed [g/w]."""

    pattern: str
    period: int
    displacement: float
    peak: float
    flight_fraction: float
    impact: float
    legs: tuple[Leg, ...]


class Body:
    """A point body at rest at phase 0.

    Parameters are those of the package's scene: [m, m, rad, Hz, 1, 1, rad, m/s^2, 1].
    """

    def __init__(
        self,
        along: float,
        normal: float,
        lead: float,
        frequency: float,
        mu_s: float,
        mu_d: float,
        trough: float = 0.0,
        gravity: float = 9.81,
        e: float = 0.0,
    ) -> None:
        self.unit = gravity / (TURN * frequency) ** 2  # [m]
        self.a, self.b, self.lead = along / self.unit, normal / self.unit, lead
        self.weight, self.slope = math.cos(trough), math.sin(trough)
        self.mu_s, self.mu_d, self.e = mu_s, mu_d, e
        self.throw = self.b / self.weight
        self.p, self.v, self.way = 0.0, 0.0, 0
        # phases where static friction gives way, and where the body is lifted; inf where that never happens
        self.opens = {way: self.push(way, mu_s).opening() for way in (1, -1)}
        self.lifts = self.lift().opening() if self.b > self.weight else math.inf

    def push(self, way: int, mu: float, v0: float = 0.0) -> Arc:
        """Motion one way from here on, against friction of a coefficient."""
        along, across = self.a, way * mu * self.b
        p, q = self.p, self.p + self.lead
        first = along * math.sin(p) - self.slope - way * mu * self.weight + across * math.sin(q)
        sine = along * math.cos(p) + across * math.cos(q)
        cosine = along * math.sin(p) + across * math.sin(q)
        return Arc(v0, way * first, way * sine, way * cosine)

    def lift(self, rate: float = 0.0) -> Arc:
        """Motion off the trough from here on."""
        sine, cosine = math.sin(self.p + self.lead), math.cos(self.p + self.lead)
        return Arc(rate, self.b * sine - self.weight, self.b * cosine, self.b * sine)

    def legs(self) -> Iterator[Leg]:
        """Leg after leg for ever, or until the body can only rest."""
        rise, aloft = 0.0, self.lift().first > 0.0  # rate of take-off; the trough may fall away at once
        while True:
            start = self.p
            if aloft:
                leg, rise, aloft = self._fly(rise)
            else:
                leg, aloft = self._touch()
                rise = 0.0
            if leg.length == math.inf:
                yield leg
                return
            self.p = (start + leg.length) % TURN
            if leg.length > 0.0:
                yield leg

    def _fly(self, rise: float) -> tuple[Leg, float, bool]:
        over, across = self.push(1, 0.0, self.v), self.lift(rise)
        length = across.landing()
        speed, impact = over.velocity(length), -across.velocity(length)
        leg = Leg("H", self.p, length, over.path(length), over.fastest(length), impact)
        rise, up = self.e * impact, across.acceleration(length)
        aloft = up > 0.0 or rise > -LEAST_BOUNCE * up
        # without the bounces that are left out the load takes away what they would have taken
        impulse = impact + (rise if aloft else 0.0)
        self.v = math.copysign(max(abs(speed) - self.mu_d * impulse, 0.0), speed)
        self.way = (self.v > 0.0) - (self.v < 0.0)
        return leg, rise, aloft

    def _touch(self) -> tuple[Leg, bool]:
        """Rest or slide; whether the body leaves the trough after it."""
        leaves = self._wait(self.lifts)
        if not self.way:
            waits = {way: self._wait(opens) for way, opens in self.opens.items()}
            self.way = min(waits, key=waits.__getitem__)
            for way in (1, -1):
                if self.push(way, self.mu_s).first > 0.0:
                    self.way, waits[way] = way, 0.0
            if (wait := waits[self.way]) > 0.0:
                return Leg("_", self.p, min(wait, leaves), 0.0, 0.0), leaves < wait
        way, self.way = self.way, 0
        arc = self.push(way, self.mu_d, abs(self.v))
        try:
            length = arc.stop()
        except NeverEndsError:
            if leaves == math.inf:
                raise
            length = math.inf
        aloft = leaves < length
        length = min(length, leaves)
        self.v = way * arc.velocity(length) if aloft else 0.0
        return Leg("FB"[way < 0], self.p, length, way * arc.path(length), arc.fastest(length)), aloft

    def _wait(self, phase: float) -> float:
        """Return how far a phase is ahead."""
        return phase if phase == math.inf else (phase - self.p) % TURN

    def settle(self, most: int = 4000) -> Cycle:
        """Walk from rest at phase 0 until the legs of some drive cycles repeat."""
        legs: list[Leg] = []
        for leg in self.legs():
            if leg.length == math.inf:
                return Cycle("_", 1, 0.0, 0.0, 0.0, 0.0, (leg,))
            legs.append(leg)
            for count in range(1, min(len(legs) // 2, LONGEST) + 1):
                if _same(legs[-1 - count], leg) and _repeat(legs[-2 * count :], count):
                    return _cycle(_shortest(legs[-count:]))
            if len(legs) > most:
                raise NeverSettlesError
            self._leap(legs)
        raise AssertionError

    def _leap(self, legs: list[Leg]) -> None:
        """Extrapolate to where the starts of slides that never rest tend: it may be too far to walk."""
        if len(legs) % 16 or {leg.kind for leg in legs[-16:]} != {"F", "B"}:
            return
        s = [self.p, *(legs[-1 - i].start + legs[-1 - i].length for i in (2, 4))]
        new, old = (math.remainder(s[i] - s[i + 1], TURN) for i in (0, 1))
        if old == new or not 0.0 < new / old < 1.0:
            return
        here = self.p
        self.p = (here + new * new / (old - new)) % TURN
        way = 1 if legs[-1].kind == "B" else -1
        if self.push(way, self.mu_s).first <= 0.0:  # no slide that never rests starts there
            self.p = here


def _same(one: Leg, other: Leg, within: float = SAME) -> bool:
    near = max(abs(math.remainder(one.start - other.start, TURN)), abs(one.length - other.length)) < within
    # a body that is thrown may land at one phase with different velocities
    return one.kind == other.kind and near and abs(one.peak - other.peak) <= within * (1.0 + one.peak)


def _repeat(legs: list[Leg], count: int, within: float = SAME) -> bool:
    """Whether legs are the same as those some legs before."""
    return all(_same(one, other, within) for one, other in zip(legs, legs[count:], strict=False))


def _shortest(legs: list[Leg]) -> list[Leg]:
    """Return a cycle of which several were found: legs that tend to it from both sides in turn."""
    counts = (n for n in range(1, len(legs) + 1) if len(legs) % n == 0)
    return legs[: next(n for n in counts if _repeat(legs, n, 1e4 * SAME))]


def _cycle(legs: list[Leg]) -> Cycle:
    turns = math.fsum(leg.length for leg in legs) / TURN
    period = round(turns)
    if abs(turns - period) > 1e-9 or period < 1:
        raise NeverSettlesError
    kinds = "".join(leg.kind for leg in legs)
    first = smallest_rotation(kinds)
    legs = legs[first:] + legs[:first]
    return Cycle(
        kinds[first:] + kinds[:first],
        period,
        math.fsum(leg.path for leg in legs) / period,
        max(leg.peak for leg in legs),
        math.fsum(leg.length for leg in legs if leg.kind == "H") / (TURN * period),
        max(leg.impact for leg in legs),
        tuple(legs),
    )


def smallest_rotation(kinds: str) -> int:
    """Where the smallest rotation of a pattern begins, in the order H < F < B < _ of the tables."""
    order = [kinds[i:] + kinds[:i] for i in range(len(kinds))]
    return min(range(len(kinds)), key=lambda i: ["HFB_".index(kind) for kind in order[i]])
