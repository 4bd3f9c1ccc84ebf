"""Steady cycles of bodies that hop, in arbitrary precision: a walk from event to event.

A plastic body is followed from rest until its velocity at a lift-off repeats, with closed forms and 60
digits. Nothing of the package is used.
"""

from __future__ import annotations

from typing import Any, Final

import mpmath

DIGITS: Final = 60
_CONTEXT: Final = mpmath.mp.clone()
_CONTEXT.dps = DIGITS
_TURN: Final = 2 * _CONTEXT.pi
_SAME: Final = _CONTEXT.mpf(10) ** (20 - DIGITS)  # [1] smaller differences count as none
_PARTS: Final = 64  # of a turn, in which the height over the trough changes its sign once at most
_MOST_ROUNDS: Final = 40
_MOST_EVENTS: Final = 200


class HoppingBody:
    """A body without restitution on a trough that moves by ``x`` along itself and by ``y`` normal to it.

    Parameters
    ----------
    along, normal, phase : number
        x = along sin(p), y = normal sin(p + phase) [A, A, rad].
    weight_normal, weight_tangential : number
        Over m A w^2.
    static_friction, kinetic_friction : number
        mu_s and mu_d.
    """

    def __init__(
        self, along: Any, normal: Any, phase: Any, weight_normal: Any, weight_tangential: Any,
        static_friction: Any, kinetic_friction: Any,
    ) -> None:  # fmt: skip
        m = _CONTEXT.mpf
        self.a, self.b, self.phi = m(along), m(normal), m(phase)
        self.n, self.t = m(weight_normal), m(weight_tangential)
        self.mu_s, self.mu_d = m(static_friction), m(kinetic_friction)
        self.p, self.v, self.x, self.turns = m(0), m(0), m(0), m(0)

    def settle(self) -> Any:
        """Return the displacement per turn of the cycle in which the body ends; None if none is met."""
        before: list[tuple[Any, Any, Any]] = []
        for _ in range(_MOST_ROUNDS):
            self._contact()
            for phase, velocity, place in before[-8:]:
                turns = _CONTEXT.nint((self.p - phase) / _TURN)
                if abs(self.v - velocity) < _SAME * self.a:
                    return (self.x - place) / turns
            before.append((self.p, self.v, self.x))
            for _ in range(_MOST_EVENTS):
                self._fly()
                if self._pressed() > 0:
                    break
        return None

    def _pressed(self) -> Any:
        return self.n - self.b * _CONTEXT.sin(self.p + self.phi)

    def _zeros(self, sine: Any, cosine: Any, level: Any, end: Any) -> list[Any]:
        """Phases after ``p`` and before ``end`` at which sine sin(p) + cosine cos(p) = level."""
        size = _CONTEXT.hypot(sine, cosine)
        if abs(level) >= size:
            return []
        lead, arc = _CONTEXT.atan2(cosine, sine), _CONTEXT.asin(level / size)
        found = []
        for zero in (arc - lead, _CONTEXT.pi - arc - lead):
            at = self.p + (zero - self.p) % _TURN
            while at < end:
                found.append(at)
                at += _TURN
        return sorted(found)

    def _friction(self, friction: Any, way: int) -> tuple[Any, Any, Any]:
        """Coefficients of the load one way beyond friction."""
        lift = friction * self.b
        sine, cosine = way * self.a + lift * _CONTEXT.cos(self.phi), lift * _CONTEXT.sin(self.phi)
        return sine, cosine, friction * self.n + way * self.t

    def _load(self, friction: Any, way: int) -> Any:
        sine, cosine, level = self._friction(friction, way)
        return sine * _CONTEXT.sin(self.p) + cosine * _CONTEXT.cos(self.p) - level

    def _contact(self) -> None:
        """Rest and slide until the trough falls away."""
        lift = self._zeros(
            self.b * _CONTEXT.cos(self.phi), self.b * _CONTEXT.sin(self.phi), self.n, self.p + _TURN
        )
        rising = [q for q in lift if _CONTEXT.cos(q + self.phi) > 0]
        end = rising[0]
        way = 0 if self.v == 0 else (1 if self.v > 0 else -1)
        for _ in range(_MOST_EVENTS):
            if way == 0:
                onsets = []
                for ahead in (1, -1):
                    if self._load(self.mu_s, ahead) > _SAME:
                        onsets.append((self.p, ahead))
                        continue
                    zeros = self._zeros(*self._friction(self.mu_s, ahead), end)
                    onsets += [(q, ahead) for q in zeros[:1]]
                if not onsets:
                    self.p = end
                    return
                self.p, way = min(onsets)
            if not self._slide(way, end):
                return
            here = [ahead for ahead in (1, -1) if self._load(self.mu_s, ahead) > _SAME]
            way = here[0] if here else 0
        raise AssertionError

    def _speed(self, way: int, begin: Any, speed: Any, s: Any) -> Any:
        sine, cosine, level = self._friction(self.mu_d, way)
        lead, size = _CONTEXT.atan2(cosine, sine), _CONTEXT.hypot(sine, cosine)
        return speed + size * (_CONTEXT.cos(begin + lead) - _CONTEXT.cos(begin + lead + s)) - level * s

    def _slide(self, way: int, end: Any) -> bool:
        """Slide one way until the body stops, or the contact ends; return whether it stops."""
        begin, speed = self.p, abs(self.v)
        marks = [q for q in self._zeros(*self._friction(self.mu_d, way), end) if q > begin] + [end]
        low = begin
        for high in marks:
            if self._speed(way, begin, speed, high - begin) <= 0 < high - begin:
                left, right = low - begin, high - begin
                if low == begin and speed == 0:
                    left = right * _SAME
                for _ in range(4 * DIGITS):
                    middle = (left + right) / 2
                    if self._speed(way, begin, speed, middle) > 0:
                        left = middle
                    else:
                        right = middle
                self._slid(way, begin, speed, right)
                self.v = _CONTEXT.mpf(0)
                return True
            low = high
        self._slid(way, begin, speed, end - begin)
        return False

    def _slid(self, way: int, begin: Any, speed: Any, s: Any) -> None:
        sine, cosine, level = self._friction(self.mu_d, way)
        lead, size = _CONTEXT.atan2(cosine, sine), _CONTEXT.hypot(sine, cosine)
        q = begin + lead
        self.x += way * (
            (speed + size * _CONTEXT.cos(q)) * s
            - size * (_CONTEXT.sin(q + s) - _CONTEXT.sin(q))
            - level * s * s / 2
        )
        self.v = way * self._speed(way, begin, speed, s)
        self.p = begin + s

    def _height(self, s: Any) -> Any:
        q = self.p + self.phi
        sine, cosine = _CONTEXT.sin(q), _CONTEXT.cos(q)
        return self.b * (s * cosine + sine - _CONTEXT.sin(q + s)) - self.n * s * s / 2

    def _fly(self) -> None:
        """Fly from rest off the trough to the first landing, and take what friction takes there."""
        step = _TURN / _PARTS
        low = high = step / 8
        while self._height(high) > 0:
            low, high = high, high + step
        while self._height(low) <= 0:  # lands within the first part
            low, high = low / 8, low
        for _ in range(4 * DIGITS):
            middle = (low + high) / 2
            if self._height(middle) > 0:
                low = middle
            else:
                high = middle
        s, p = high, self.p
        self.x += (
            (self.v + self.a * _CONTEXT.cos(p)) * s
            - self.a * (_CONTEXT.sin(p + s) - _CONTEXT.sin(p))
            - self.t * s * s / 2
        )
        self.v += self.a * (_CONTEXT.cos(p) - _CONTEXT.cos(p + s)) - self.t * s
        q = p + self.phi
        impact = self.n * s - self.b * (_CONTEXT.cos(q) - _CONTEXT.cos(q + s))
        self.p = p + s
        loss = self.mu_d * impact
        self.v = _CONTEXT.mpf(0) if abs(self.v) <= loss else self.v - _CONTEXT.sign(self.v) * loss
