"""A second solver of drives with harmonics: a walk from slide to slide that uses nothing of the package.

Speeds are Newton's law integrated in closed form, in units of g/w; every zero is bracketed on a fine mesh and
found by Brent's method. The walk ends when the slides of a drive cycle repeat.
"""

from __future__ import annotations

import math
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

TURN = 2.0 * math.pi
MESH = np.linspace(0.0, TURN, 361)


class Slide(NamedTuple):
    """One slide: +1 forward or -1 back, start and length in phase, and whether a rest came before."""

    way: int
    start: float
    length: float
    from_rest: bool


class Cycle(NamedTuple):
    """What a walk repeats: the least rotation of its pattern, displacement a drive cycle [g/w^2]."""

    pattern: str
    displacement: float


class Drive(NamedTuple):
    """Loads along the trough and off it over the weight: pairs of sine and cosine for n = 1, 2, ..."""

    along: Sequence[tuple[float, float]]
    across: Sequence[tuple[float, float]]
    mu_s: float
    mu_d: float
    beta: float

    def push(self, p: NDArray[np.float64] | float) -> NDArray[np.float64]:
        return _sum(self.along, p) - math.sin(self.beta)

    def weight(self, p: NDArray[np.float64] | float) -> NDArray[np.float64]:
        return math.cos(self.beta) - _sum(self.across, p)

    def begins(self, way: int, p: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Load of a resting body beyond static friction."""
        return way * self.push(p) - self.mu_s * self.weight(p)

    def speed(self, way: int, p0: float, p: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Speed of a slide from rest at p0."""
        mean = -way * math.sin(self.beta) - self.mu_d * math.cos(self.beta)
        gained = mean * (p - p0)
        for waves, factor in ((self.along, way), (self.across, self.mu_d)):
            for n, (s, c) in enumerate(waves, 1):
                gained = gained - factor * s * (np.cos(n * p) - math.cos(n * p0)) / n
                gained = gained + factor * c * (np.sin(n * p) - math.sin(n * p0)) / n
        return np.asarray(gained)

    def path(self, way: int, p0: float, s: float) -> float:
        """Integral of that speed over a phase s, by Gauss's rule on short pieces."""
        nodes, weights = np.polynomial.legendre.leggauss(12)
        edges = np.linspace(p0, p0 + s, 13)
        half = 0.5 * np.diff(edges)
        at = 0.5 * (edges[1:] + edges[:-1])[:, None] + half[:, None] * nodes
        return float((self.speed(way, p0, at) * weights * half[:, None]).sum())

    def slide(self, way: int, start: float, from_rest: bool) -> Slide:
        def speed(p: float) -> float:
            return float(self.speed(way, start, p))

        # a start has zero speed, too: look from a first small step on, at which it must move
        mesh = start + MESH[1:]
        v = self.speed(way, start, mesh)
        first = 1e-7
        while speed(start + first) <= 0.0 and first < 1e-2:
            first *= 2.0
        low = start + first
        for p, there in zip(mesh.tolist(), v.tolist(), strict=True):
            if p <= low:
                continue
            if there <= 0.0:
                end = brentq(speed, low, p, xtol=1e-15, rtol=1e-15)
                return Slide(way, start % TURN, end - start, from_rest)
            low = p
        raise ArithmeticError("the slide never ends")

    def onsets(self) -> list[tuple[float, int]]:
        """Phases at which a body at rest starts to slide, with the direction."""
        return sorted((p % TURN, way) for way in (1, -1) for p in _rising(partial(self.begins, way)))

    def settle(self, most: int = 2000, phase: float = 0.0, way: int = 0) -> Cycle:
        """Walk from rest at a phase, or a slide from there, until the slides of a cycle repeat."""
        onsets = self.onsets()
        if not onsets:
            return Cycle("_", 0.0)
        slides = list[Slide]()
        h = len(self.along)
        while len(slides) < most:
            from_rest = bool(way) and not slides
            way = way or next((w for w in (1, -1) if self.begins(w, phase) > 0.0), 0)
            if not way:
                from_rest = True
                wait, way = min(((onset - phase) % TURN, way) for onset, way in onsets)
                phase += wait
            slides.append(self.slide(way, phase, from_rest))
            phase, way = (slides[-1].start + slides[-1].length) % TURN, 0
            for count in range(1, min(2 * h, len(slides) - 1) + 1):
                if _repeats(slides[-1 - count], slides[-1]):
                    return self._cycle(slides[-count:])
        raise ArithmeticError("the walk does not settle")

    def _cycle(self, slides: list[Slide]) -> Cycle:
        legs = []
        for i, slide in enumerate(slides):
            rests = slides[(i + 1) % len(slides)].from_rest
            legs.append(("F" if slide.way > 0 else "B") + "_" * rests)
        turned = ["".join(legs[i:] + legs[:i]) for i in range(len(legs))]
        order = str.maketrans("FB_", "123")
        pattern = min(turned, key=lambda text: text.translate(order))
        return Cycle(
            pattern, sum(slide.way * self.path(slide.way, slide.start, slide.length) for slide in slides)
        )


def _sum(waves: Sequence[tuple[float, float]], p: NDArray[np.float64] | float) -> NDArray[np.float64]:
    total = np.zeros(np.shape(p))
    for n, (s, c) in enumerate(waves, 1):
        total = total + s * np.sin(n * p) + c * np.cos(n * p)
    return total


def _rising(f: Callable[[NDArray[np.float64] | float], NDArray[np.float64]]) -> list[float]:
    """Zeros at which a periodic function rises, with those about a maximum between two points of the mesh."""
    edges = list(MESH)
    at = f(MESH)
    for i in range(MESH.size - 1):
        if at[i] >= max(at[i - 1 if i else -2], at[i + 1]):
            step = MESH[1]
            top = minimize_scalar(
                lambda p: -float(f(p)), bounds=(MESH[i] - step, MESH[i] + step), method="bounded",
                options={"xatol": 1e-12},
            )  # fmt: skip
            edges.append(float(top.x))
    edges.sort()
    return [
        brentq(lambda p: float(f(p)), low, high, xtol=1e-15, rtol=1e-15)
        for low, high in pairwise(edges)
        if f(low) <= 0.0 < f(high)
    ]


def _repeats(before: Slide, now: Slide) -> bool:
    same = before.way == now.way and before.from_rest == now.from_rest
    shift = math.remainder(now.start - before.start, TURN)
    return same and max(abs(shift), abs(now.length - before.length)) < 1e-11
