"""A body on a drive with harmonics followed in time, flights included; nothing of the package.

Between two events every acceleration is a constant and a few sinusoids, in units of g: speed [g/w] and path
[g/w^2] are closed forms. Events are bracketed on a mesh and found by Brent's method. A body that lands keeps
no normal speed (restitution 0).
"""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize import brentq

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Waves = NDArray[np.complex128]

TURN = 2.0 * math.pi
#: Phases after the start of a leg between which an event is bracketed. Before the first one, speed and height
#: may be rounding.
MESH = np.concatenate([np.geomspace(1e-4, 5e-3, 20), np.linspace(1e-2, 2.0 * TURN, 1200)])


class NeverRepeatsError(ArithmeticError):
    """The body runs away, or has no motion that repeats in every cycle."""


class _Forced(NamedTuple):
    """Motion from phase p0 and speed v0 on, under a constant and the sum of Im(w_n exp(i n p))."""

    p0: float
    v0: float
    constant: float
    waves: NDArray[np.complex128]

    def force(self, since: Floats) -> Floats:
        return self.constant + self._integral(self.p0 + since, 0)

    def speed(self, since: Floats) -> Floats:
        gained = self._integral(self.p0 + since, 1) - self._integral(np.array(self.p0), 1)
        return np.asarray(self.v0 + self.constant * since + gained)

    def path(self, since: Floats) -> Floats:
        start = np.array(self.p0)
        gained = self._integral(self.p0 + since, 2) - self._integral(start, 2)
        straight = (self.v0 - self._integral(start, 1)) * since
        return np.asarray(straight + 0.5 * self.constant * since**2 + gained)

    def _integral(self, p: Floats, times: int) -> Floats:
        orders = np.arange(1, self.waves.size + 1)
        return np.asarray(
            (np.exp(1j * np.multiply.outer(p, orders)) @ (self.waves / (1j * orders) ** times)).imag
        )


class Leg(NamedTuple):
    """A rest "_", slide "F" or "B", or flight "H": start [rad], path before it [g/w^2], and its motion."""

    kind: str
    start: float
    before: float
    motion: _Forced | None


class Body:
    """A body at rest at phase 0, on a trough whose loads are sums of Im(w_n exp(i n p)), n = 1, 2, ...

    ``along`` and ``normal`` are the amplitudes of the trough's motion times (n w)^2 over gravity, with the
    phases as their angles.
    """

    def __init__(self, along: Waves, normal: Waves, mu_s: float, mu_d: float, trough: float = 0.0) -> None:
        self.along, self.normal = along, normal
        self.mu_s, self.mu_d = mu_s, mu_d
        self.weight, self.slope = math.cos(trough), math.sin(trough)

    def follow(self, cycles: float) -> list[Leg]:
        """Return the legs of the motion up to a number of cycles."""
        legs: list[Leg] = []
        p, x, v, aloft = 0.0, 0.0, 0.0, False
        while p < TURN * cycles:
            if aloft:
                motion = _Forced(p, v, -self.slope, self.along)
                height = _Forced(p, 0.0, -self.weight, self.normal)
                length = _first(height.path)
                legs.append(Leg("H", p, x, motion))
                sink = -float(height.speed(np.array(length)))
                speed = float(motion.speed(np.array(length)))
                v = math.copysign(max(abs(speed) - self.mu_d * sink, 0.0), speed)
                aloft = float(height.force(np.array(length))) > 0.0
            else:
                way = int(np.sign(v)) or self._pushed(p)
                leaves = _first(partial(self._lifted, p))
                if way:
                    motion = self._slide(way, p, v)
                    stops = _first(partial(_forwards, motion, way))
                    length = min(stops, leaves)
                    legs.append(Leg("F" if way > 0 else "B", p, x, motion))
                    v = float(motion.speed(np.array(length))) if leaves < stops else 0.0
                else:
                    waits = [_first(partial(self._held, p, w)) for w in (1, -1)]
                    length = min(*waits, leaves)
                    legs.append(Leg("_", p, x, None))
                    motion = None
                aloft = leaves <= length
                if length == math.inf:
                    if motion is not None:
                        raise NeverRepeatsError
                    return legs
            x += float(motion.path(np.array(length))) if motion else 0.0
            p += length
        return legs

    def _lifted(self, p: float, s: Floats) -> Floats:
        """Normal load, falling where the body leaves the trough."""
        return -self._lift(p).force(s)

    def _held(self, p: float, way: int, s: Floats) -> Floats:
        """What is left of static friction against a push one way."""
        return -way * self._slide(way, p, 0.0, self.mu_s).force(s)

    def _lift(self, p: float) -> _Forced:
        return _Forced(p, 0.0, -self.weight, self.normal)

    def _slide(self, way: int, p: float, v: float, mu: float | None = None) -> _Forced:
        mu = self.mu_d if mu is None else mu
        return _Forced(p, v, -self.slope - way * mu * self.weight, self.along + way * mu * self.normal)

    def _pushed(self, p: float) -> int:
        """Direction in which the load exceeds static friction, just after a phase; 0 if none."""
        after = np.array(1e-7)
        return next(
            (w for w in (1, -1) if w * float(self._slide(w, p, 0.0, self.mu_s).force(after)) > 0.0), 0
        )


def _forwards(motion: _Forced, way: int, s: Floats) -> Floats:
    return way * motion.speed(s)


def _first(f: Callable[[Floats], Floats]) -> float:
    """Return where a function first falls through zero; inf if it does not within two turns."""
    values = f(MESH)
    if values[0] <= 0.0:
        return float(MESH[0])
    falls = np.flatnonzero((values[:-1] > 0.0) & (values[1:] <= 0.0))
    if not falls.size:
        return math.inf
    low, high = MESH[falls[0]], MESH[falls[0] + 1]
    return float(brentq(lambda s: float(f(np.array(s))), low, high, xtol=1e-14))


class Settled:
    """The motion of a body that has settled, over phases from 0 on."""

    def __init__(self, body: Body, cycles: int, settling: int = 80) -> None:
        legs = body.follow(settling + cycles + 1)
        self._from = TURN * settling
        self._starts = np.array([leg.start for leg in legs])
        self._legs = legs
        steps = np.diff(self.path(TURN * np.arange(-3.0, 3.0)))
        if np.ptp(steps) > 1e-9 * max(1.0, abs(steps[0])):
            raise NeverRepeatsError
        self.advance = float(steps[-1])
        count = np.searchsorted(self._starts, self._from), np.searchsorted(self._starts, self._from + TURN)
        self.kinds = "".join(leg.kind for leg in legs[slice(*count)])

    def path(self, p: Floats) -> Floats:
        """Path relative to the trough [g/w^2]."""
        return self._sampled(p, lambda leg, s: leg.before + (leg.motion.path(s) if leg.motion else 0.0 * s))

    def speed(self, p: Floats) -> Floats:
        """Speed relative to the trough [g/w]."""
        return self._sampled(p, lambda leg, s: leg.motion.speed(s) if leg.motion else np.zeros_like(s))

    def _sampled(self, p: Floats, value: Callable[[Leg, Floats], Floats]) -> Floats:
        at = p + self._from
        places = np.searchsorted(self._starts, at, "right") - 1
        found = np.empty_like(at)
        for place in np.unique(places):
            there = places == place
            leg = self._legs[place]
            found[there] = value(leg, at[there] - leg.start)
        return found
