"""A second solver for the tests: a walk from slide to slide that uses nothing of the package.

The body's state is "rests at this phase" or "slides this way from this phase on"; each slide's end is the
first zero of its speed, by Brent's method in a bracket that holds only that zero.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from scipy.optimize import brentq

if TYPE_CHECKING:
    from collections.abc import Iterator

    from helpers.scenes import Groups

TURN = 2.0 * math.pi


class Slide(NamedTuple):
    """One slide: +1 forward or -1 back, start in [0, 2 pi), length in phase, path [g/w^2], rest before it."""

    way: int
    start: float
    length: float
    path: float
    from_rest: bool


class Cycle(NamedTuple):
    """What a walk repeats: pattern as the package writes it, displacement a drive cycle [g/w^2]."""

    pattern: str
    displacement: float


class Body:
    """A body on a trough, by its dimensionless groups."""

    def __init__(self, groups: Groups) -> None:
        alpha, beta = math.radians(groups.drive_deg), math.radians(groups.trough_deg)
        a, b = groups.load * math.cos(alpha), groups.load * math.sin(alpha)
        tilt, weight = math.sin(beta), math.cos(beta)
        self.load = {way: a + way * groups.mu_d * b for way in (1, -1)}
        self.k = {way: (groups.mu_d * weight + way * tilt) / self.load[way] for way in (1, -1)}
        # phase at which each window of slip opens, and its middle; None where it never does
        self.opens: dict[int, float] = {}
        for way in (1, -1):
            pull = a + way * groups.mu_s * b
            if pull > 0.0 and (s := (groups.mu_s * weight + way * tilt) / pull) < 1.0:
                self.opens[way] = math.asin(s) + (0.0 if way > 0 else math.pi)

    def slide(self, way: int, start: float, from_rest: bool) -> Slide:
        """Slide one way from a phase inside its window."""
        k = self.k[way]
        p0 = (start if way > 0 else start - math.pi) % TURN
        if k <= -1.0:
            raise ArithmeticError("the slide never ends")

        def speed(p: float) -> float:
            return math.cos(p0) - math.cos(p) - k * (p - p0)

        top = math.pi - math.asin(k)
        least = TURN - p0 if k > 0.0 else TURN + math.asin(k)
        if speed(least) > 0.0:
            raise ArithmeticError("the slide never ends")
        p1 = brentq(speed, top, least, xtol=1e-15, rtol=1e-15)
        path = math.cos(p0) * (p1 - p0) - (math.sin(p1) - math.sin(p0)) - k * (p1 - p0) ** 2 / 2.0
        return Slide(way, start % TURN, p1 - p0, way * self.load[way] * path, from_rest)

    def inside(self, way: int, phase: float) -> bool:
        """Whether the load exceeds static friction that way at a phase."""
        if way not in self.opens:
            return False
        half = abs(self._crest(way) - self.opens[way])
        return abs(math.remainder(phase - self._crest(way), TURN)) < half

    def walk(self, phase: float, way: int = 0) -> Iterator[Slide]:
        """Slide after slide, at rest at a phase or (``way``) starting to slide there, if it must."""
        while self.opens:
            from_rest = way == 0
            if from_rest:
                waits = {w: (opens - phase) % TURN for w, opens in self.opens.items()}
                way = min(waits, key=waits.__getitem__)
                phase += waits[way]
            slide = self.slide(way, phase, from_rest)
            yield slide
            phase = slide.start + slide.length
            way = next((w for w in (1, -1) if self.inside(w, phase)), 0)

    def settle(self, phase: float = 0.0, way: int = 0, most: int = 20_000) -> Cycle:
        """Walk until the slides of a drive cycle repeat."""
        slides: list[Slide] = []
        for slide in self.walk(phase, way):
            slides.append(slide)
            for count in (1, 2):
                if len(slides) > count and self._repeats(slides[-1 - count], slide):
                    return self._cycle(slides[-count:])
            if len(slides) > most:
                raise ArithmeticError("the walk does not settle")
        return Cycle("_", 0.0)

    def _crest(self, way: int) -> float:
        return 0.5 * math.pi if way > 0 else 1.5 * math.pi

    @staticmethod
    def _repeats(before: Slide, now: Slide) -> bool:
        same = before.way == now.way and before.from_rest == now.from_rest
        return same and max(abs(now.start - before.start), abs(now.length - before.length)) < 1e-14

    @staticmethod
    def _cycle(slides: list[Slide]) -> Cycle:
        slides = sorted(slides, key=lambda s: -s.way)  # the package writes the forward slide first
        pattern = ""
        for i, slide in enumerate(slides):
            rests = slides[(i + 1) % len(slides)].from_rest
            pattern += ("F" if slide.way > 0 else "B") + "_" * rests
        return Cycle(pattern, sum(s.path for s in slides))
