"""Many bodies on vibrating troughs at once, from event to event in doubles: a witness for the solver.

Each bounce is an event of its own, with its impulse of friction. Nothing is taken from ``vibro``: the motion
follows from Newton's law, Coulomb's law of friction, and Newton's law of impact. All bodies are followed turn
by turn of the drive. Inside, lengths are in g/w^2 and speeds in g/w; outside, SI. p = w t is the phase.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]
Way = Indices | int
Fields = Mapping[str, ArrayLike]  # of ``vibro.Scene``

TURN: Final = 2.0 * np.pi
LEAST_BOUNCE: Final = 1e-7  # [A w] slower bounces on a trough that presses up count as contact
KICK: Final = 1e-12  # [A w] take-off speed that noise adds to a lift-off: far less than any real trough's
NAMES: Final = (
    "amplitude",
    "frequency",
    "drive_angle",
    "static_friction",
    "kinetic_friction",
    "trough_angle",
    "gravity",
    "restitution",
)
_DEFAULTS: Final = {"trough_angle": 0.0, "gravity": 9.81, "restitution": 0.0}
_FLIGHT, _SLIDE, _REST = range(3)
_SHORT: Final = 0.1  # [rad] below, series instead of differences
_CUBIC: Final = [(-1) ** n / math.factorial(2 * n + 3) for n in (4, 3, 2, 1, 0)]  # t - sin t, over t^3
_QUARTIC: Final = [
    (-1) ** n / math.factorial(2 * n + 4) for n in (4, 3, 2, 1, 0)
]  # t^2/2 - (1 - cos t), over t^4
_STEADY: Final = 1e-5  # [1] change of the press on the trough that is neglected in the last bounces
_MOST_STEPS: Final = 200


class Course(NamedTuple):
    """Motion from a phase p0 on under a load C sin p - k; arrays over bodies.

    Attributes
    ----------
    place, rate : array
        At p0.
    swing, net, pull : array
        C cos p0, C sin p0 - k, and k.
    """

    place: Floats
    rate: Floats
    swing: Floats
    net: Floats
    pull: Floats

    def after(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Place, its rate, and the load after a while."""
        half = np.sin(0.5 * t)
        cubic, square, sine = t - np.sin(t), 2.0 * half * half, np.sin(t)
        quartic = 0.5 * t * t - square
        short = np.flatnonzero(t < _SHORT)
        if short.size:
            s = t[short]
            z = s * s
            cubic[short], quartic[short] = np.polyval(_CUBIC, z) * z * s, np.polyval(_QUARTIC, z) * z * z
        place = self.place + self.rate * t + self.swing * cubic + self.net * square - self.pull * quartic
        rate = self.rate + self.swing * square + self.net * sine - self.pull * cubic
        return place, rate, self.swing * sine + self.net - (self.net + self.pull) * square

    def of(self, some: Mask | Indices) -> Course:
        """Pick some bodies."""
        return Course(*(x[some] for x in self))

    def crossing(self, which: int, low: Floats, high: Floats, guess: Floats) -> Floats:
        """Find when place (0) or rate (1) falls through zero, once in each bracket (low, high].

        A step is Newton's where that stays inside the bracket, and half of the bracket elsewhere.
        """
        course, out, left = self, high.copy(), np.arange(high.size)
        if not out.size:
            return out
        t = np.where((guess > low) & (guess < high), guess, high)
        for _ in range(_MOST_STEPS):
            value, slope = course.after(t)[which : which + 2]
            above = value > 0.0
            low, high = np.where(above, t, low), np.where(above, high, t)
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                new = t - value / slope
            new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
            out[left] = new
            going = (np.abs(new - t) > 4e-16 * (1.0 + t)) & (value != 0.0)
            if not going.any():
                break
            left, t, low, high, course = left[going], new[going], low[going], high[going], course.of(going)
        return out

    def lowest(self, low: Floats, high: Floats) -> Floats:
        """Find where a place that curves up between ``low`` and ``high`` is least."""
        falls, rises = self.after(low)[1] < 0.0, self.after(high)[1] > 0.0
        out = np.where(falls, high, low)
        turns = np.flatnonzero(falls & rises)
        if turns.size:
            out[turns] = Course(*(-x[turns] for x in self)).crossing(1, low[turns], high[turns], high[turns])
        return out


class Scenes(NamedTuple):
    """Loads and events of contact, one value a body: in weights, and as phases (inf where there is none)."""

    along: Floats
    across: Floats
    normal: Floats
    tangential: Floats
    mu_s: Floats
    mu_d: Floats
    e: Floats
    load: Floats  # A w^2 / g
    lifts: Floats  # phase at which the load on the trough falls to zero
    presses: Floats  # and at which it is back
    forward: Floats  # phase at which a body at rest starts to slide forward
    back: Floats


def scenes_of(fields: Fields, copies: int = 1) -> tuple[Scenes, Floats, Floats]:
    """Form the loads of copies of each scene, and the units of length g/w^2 and of speed g/w in SI.

    Parameters
    ----------
    fields : mapping of str to array_like
        Fields of ``vibro.Scene``, which broadcast against each other.
    copies : int, optional
        Bodies of each scene, next to each other.
    """
    values = np.broadcast_arrays(*(np.asarray(fields.get(n, _DEFAULTS.get(n)), np.float64) for n in NAMES))
    amplitude, frequency, alpha, mu_s, mu_d, beta, gravity, e = (np.repeat(v, copies) for v in values)
    w = TURN * frequency
    load = amplitude * w**2 / gravity
    a, b = load * np.cos(alpha), load * np.sin(alpha)
    normal, tangential = np.cos(beta), np.sin(beta)
    with np.errstate(divide="ignore", invalid="ignore"):
        lifts = np.where(b > normal, np.arcsin(np.minimum(normal / b, 1.0)), np.inf)
        forward = _onset(mu_s * normal + tangential, a + mu_s * b, 0.0)
        back = _onset(mu_s * normal - tangential, a - mu_s * b, np.pi)
    presses = np.where(b > normal, np.pi - lifts, np.inf)
    forward = np.where(forward < np.pi, np.minimum(forward, lifts), forward)
    scenes = Scenes(a, b, normal, tangential, mu_s, mu_d, e, load, lifts, presses, forward, back)
    return scenes, gravity / w**2, gravity / w


def _onset(threshold: Floats, load: Floats, zero: float) -> Floats:
    """Phase in [0, 2 pi) at which a load beyond a threshold is reached; inf where it never is."""
    return np.where(threshold < load, (zero + np.arcsin(np.clip(threshold / load, -1.0, 1.0))) % TURN, np.inf)


class Along(NamedTuple):
    """Loads C sin p - k along the trough in flight and in slides forward and back (index 0, 1 and -1)."""

    load: Floats
    pull: Floats
    zeros: tuple[Floats, Floats]  # phases at which they are zero, in order; inf where they never are

    @classmethod
    def of(cls, s: Scenes) -> Along:
        """Form them for scenes."""
        drag = np.array([[0.0], [1.0], [-1.0]]) * s.mu_d
        load, pull = s.along + drag * s.across, s.tangential + drag * s.normal
        with np.errstate(divide="ignore", invalid="ignore"):
            first = np.arcsin(pull / load)
        zeros = np.sort(np.nan_to_num([first % TURN, (np.pi - first) % TURN], nan=np.inf), axis=0)
        return cls(load, pull, (zeros[0], zeros[1]))


class Bodies:
    """Bodies on troughs, from rest at phase 0 or from any state on.

    Parameters
    ----------
    fields, copies
        As for ``scenes_of``.
    start : tuple of array_like, optional
        Phase [rad], take-off speed and relative velocity [m/s] of each body; a body that takes off at no
        speed while the trough presses up is in contact.
    kick : float, optional
        At each lift-off from contact the take-off speed is random, about so much [A w]. In doubles a body
        that comes to rest on the trough repeats the same excursion for ever, which a noisy trough's does not.
    seed : int, optional
        Of the kicks.

    Attributes
    ----------
    phase, height, rise, velocity, place : array
        Of each body, relative to the trough, in g/w^2 and g/w.
    flying : array
        Phase spent in flight so far.
    peak, impact : array
        Largest relative speed along the trough and largest normal speed of a landing since they were reset.
    landings : array of int
        So far.
    """

    def __init__(
        self,
        fields: Fields,
        copies: int = 1,
        *,
        start: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
        kick: float = 0.0,
        seed: int = 1,
    ) -> None:
        self.scenes, self.length, self.speed = scenes_of(fields, copies)
        self._along = Along.of(self.scenes)
        self.kick, self.random = kick, np.random.default_rng(seed)
        shape = self.length.shape
        self.phase, self.height, self.place, self.flying, self.peak, self.impact = np.zeros((6, *shape))
        self.rise, self.velocity = np.zeros((2, *shape))
        self.landings = np.zeros(shape, np.int64)
        self._mode = np.full(shape, _FLIGHT, np.int8)
        self._starts = np.zeros(shape, np.bool_)  # to slide, from rest
        self._way = np.zeros(shape, np.intp)
        if start is not None:
            self.phase += np.asarray(start[0]) % TURN
            self.rise += np.asarray(start[1]) / self.speed
            self.velocity += np.asarray(start[2]) / self.speed
        every = np.arange(self.phase.size)
        self._take(every, self.rise, self._settles(every, self.rise)[0])

    def turn(self, bodies: Indices | None = None) -> None:
        """Follow all bodies, or some, to the end of the present turn of the drive."""
        going = np.arange(self.phase.size) if bodies is None else bodies
        self.phase[going[self.phase[going] >= TURN]] = 0.0
        advance = ((_FLIGHT, self._fly), (_SLIDE, self._slide), (_REST, self._rest))
        while going.size:
            for mode, follow in advance:
                some = going[self._mode[going] == mode]
                if some.size:
                    follow(some)
            going = going[self.phase[going] < TURN]

    def states(self, some: Indices) -> Floats:
        """Height, its rate and relative velocity of some bodies, in A and A w; last axis the three."""
        state = np.stack([self.height[some], self.rise[some], self.velocity[some]], axis=-1)
        return np.asarray(state / self.scenes.load[some, None])

    def _fly(self, i: Indices) -> None:
        """Fly to the next landing, the first zero of the height, or to the end of the turn.

        Between the phases at which the drive balances the weight, the height curves one way. While it curves
        down it has one zero at most; while it curves up, at most one before its only minimum.
        """
        s, p = self.scenes, self.phase[i]
        lifts, presses, never = s.lifts[i], s.presses[i], np.full(p.shape, np.inf)
        net = np.where(p == lifts, 0.0, s.across[i] * np.sin(p) - s.normal[i])
        normal = Course(self.height[i], self.rise[i], s.across[i] * np.cos(p), net, s.normal[i])
        before, end, lands = np.zeros(i.size), TURN - p, np.zeros(i.size, np.bool_)
        for bound, curves_up in ((lifts, False), (presses, True), (never, False)):
            after = np.clip(bound - p, before, TURN - p)
            some = np.flatnonzero(~lands & (after > before))
            if not some.size:
                continue
            part, low, high = normal.of(some), before[some], after[some]
            if curves_up:
                high = part.lowest(low, high)
            hits = np.flatnonzero((high > low) & (part.after(high)[0] <= 0.0))
            part, low, high, some = part.of(hits), low[hits], high[hits], some[hits]
            with np.errstate(divide="ignore", invalid="ignore"):
                parabola = -2.0 * part.rate / part.net
            end[some] = part.crossing(0, low, high, parabola)
            lands[some] = True
            before = after
        self.flying[i] += end
        self._move(i, 0, end)
        height, self.rise[i], _ = normal.after(end)
        self.height[i] = np.where(lands, 0.0, height)
        self.phase[i] = np.where(lands, np.minimum(p + end, TURN), TURN)
        self._land(i[lands])

    def _land(self, i: Indices) -> None:
        """Apply the impulses of an impact: normal, and friction up to what stops the body.

        Where the bounces to come would end while hardly anything changes, the impact is plastic and contact
        follows, which carries the weight meanwhile just as the bounces would.
        """
        if not i.size:
            return
        s, impact = self.scenes, np.maximum(-self.rise[i], 0.0)
        self.impact[i] = np.maximum(self.impact[i], impact)
        self.landings[i] += 1
        rise = s.e[i] * impact
        stays, lasting = self._settles(i, rise)
        rise[stays] = 0.0
        self.flying[i[stays]] += lasting[stays]
        speed = np.maximum(np.abs(self.velocity[i]) - s.mu_d[i] * (impact + rise), 0.0)
        self.velocity[i] = np.copysign(speed, self.velocity[i])
        self._take(i, rise, stays)

    def _settles(self, i: Indices, rise: Floats) -> tuple[Mask, Floats]:
        """Whether the bounces after a take-off at this speed end at once, and how long they last."""
        s, p = self.scenes, self.phase[i]
        presses = s.normal[i] - s.across[i] * np.sin(p)
        with np.errstate(divide="ignore", invalid="ignore"):
            lasting = 2.0 * rise / (presses * (1.0 - s.e[i]))
        steady = np.abs(s.across[i] * np.cos(p)) * lasting <= _STEADY * presses
        return (presses > 0.0) & (rise <= LEAST_BOUNCE * s.load[i]) & steady, lasting

    def _take(self, i: Indices, rise: Floats, stays: Mask) -> None:
        """Take off at some speed, or stay in contact."""
        self.rise[i] = np.where(stays, 0.0, rise)
        self._mode[i] = np.where(stays, _SLIDE, _FLIGHT)
        self._way[i] = np.sign(self.velocity[i])
        self._starts[i] = False
        self._hold(i[stays & (self.velocity[i] == 0.0)])

    def _hold(self, i: Indices) -> None:
        """Decide whether a body that has stopped in contact rests or starts to slide."""
        if not i.size:
            return
        s, sine = self.scenes, np.sin(self.phase[i])
        load = s.along[i] * sine - s.tangential[i]
        slides = np.abs(load) > s.mu_s[i] * (s.normal[i] - s.across[i] * sine)
        self._mode[i] = np.where(slides, _SLIDE, _REST)
        self._way[i] = np.sign(load)
        self._starts[i] = slides

    def _rest(self, i: Indices) -> None:
        """Rest until the next onset of a slide, or to the end of the turn."""
        s, p = self.scenes, self.phase[i]
        # An onset that rounding alone puts before the phase is still to come.
        forward, back = (np.where(o >= p - 1e-9, o, np.inf) for o in (s.forward[i], s.back[i]))
        onset = np.minimum(forward, back)
        slides = onset < TURN
        self.phase[i] = np.where(slides, np.maximum(onset, p), TURN)
        self._mode[i] = np.where(slides, _SLIDE, _REST)
        self._way[i] = np.where(forward <= back, 1, -1)
        self._starts[i] = slides

    def _slide(self, i: Indices) -> None:
        """Slide one way until the body stops or lifts off, or to the end of the turn.

        Between the phases at which the drive balances friction, the speed grows or falls throughout.
        """
        s, p, way = self.scenes, self.phase[i], self._way[i]
        until = np.minimum(np.where(p < s.presses[i], s.lifts[i], np.inf), TURN)
        whole = np.maximum(until - p, 0.0)
        speed = self._course(i, way)
        speed = Course(*(way * x for x in speed))
        before, end, stops = np.zeros(i.size), whole.copy(), np.zeros(i.size, np.bool_)
        for bound in (*(zeros[way, i] for zeros in self._along.zeros), np.full(i.size, np.inf)):
            after = np.clip(bound - p, before, whole)
            falls = speed.after(0.5 * (before + after))[2] < 0.0
            falls &= ~(self._starts[i] & (before == 0.0))
            some = np.flatnonzero(~stops & falls & (after > before))
            if not some.size:
                before = after
                continue
            some = some[speed.of(some).after(after[some])[1] <= 0.0]
            end[some] = speed.of(some).crossing(1, before[some], after[some], after[some])
            stops[some] = True
            before = after
        self._move(i, way, end)
        self._starts[i] = False
        self.phase[i] = np.where(stops, np.minimum(p + end, TURN), until)
        stopped, lifted = i[stops], i[~stops & (until < TURN)]
        self.velocity[stopped] = 0.0
        self._hold(stopped)
        self._mode[lifted] = _FLIGHT
        if self.kick:
            self.rise[lifted] = self.kick * s.load[lifted] * self.random.uniform(0.5, 1.5, lifted.size)

    def _course(self, i: Indices, way: Way) -> Course:
        """Motion along the trough: way 1 or -1 of a slide, 0 in flight."""
        load, pull, p = self._along.load[way, i], self._along.pull[way, i], self.phase[i]
        return Course(self.place[i], self.velocity[i], load * np.cos(p), load * np.sin(p) - pull, pull)

    def _move(self, i: Indices, way: Way, t: Floats) -> None:
        """Move bodies along the trough for a while, and note their largest speeds."""
        course, p = self._course(i, way), self.phase[i]
        self.place[i], self.velocity[i], _ = course.after(t)
        largest = np.maximum(np.abs(course.rate), np.abs(self.velocity[i]))
        for zeros in self._along.zeros:
            zero = zeros[way, i]
            some = np.flatnonzero((zero > p) & (zero - p < t))
            if some.size:
                speed = np.abs(course.of(some).after(zero[some] - p[some])[1])
                largest[some] = np.maximum(largest[some], speed)
        self.peak[i] = np.maximum(self.peak[i], largest)
