"""A vibrating machine and the body on it, each acting on the other, followed from event to event.

Newton's law for trough, counter mass and body, Coulomb's law with stiction, Newton's law of impact with
Routh's account of the friction during it. While the body sticks, slides one way or flies, all is linear, each
state with an inertia of its own: matrix exponentials carry the motion from event to event without an error of
stepping. Events are zeros of Taylor polynomials inside steps that are too short for two of them.

The trough is guided along the drive's line. s is its absolute motion, y that of the counter mass, r = s - y;
xi and eta are the body's along and normal to the trough, relative to it. A constant force on the counter
mass carries the body's weight, as very soft mounts do. Only the acceleration of the trough moves anything:
the drift of a counter mass that nothing ties to the floor is dropped. Inside, lengths are in g/w^2, times in
1/w, masses in the trough's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TURN = 2.0 * math.pi
STEPS = 128  # a turn; the shortest natural period of a machine is to be 20 steps or more
AHEAD = 32  # steps that are looked at together
MESH = 8  # parts of a step in which zeros are looked for
TERMS = 18  # of Taylor's series: 2 pi/20 to the 18th power over 18! is 1e-25
FLAT = 1e-9  # [1] coefficients below are rounding: a slide or flight that starts smoothly
LEAST_BOUNCE = 1e-9  # [g/w] slower take-offs are left out where the trough presses
MOST_LEGS = 1000  # a turn
LONGEST_PERIOD = 8  # turns
SAME = 1e-12  # [g/w^2, g/w] states of two turns that are the same
RELATIVE, RELATIVE_SPEED, COUNTER, COUNTER_SPEED, XI, XI_SPEED, ETA, ETA_SPEED, COS, SIN, ONE = range(11)
STICK, FORWARD, BACK, FLIGHT = range(4)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


@dataclass(frozen=True)
class Machine:
    """Masses [kg], springs [N/m] and a damper [N s/m] between them, forces [N] that go as cos(wt)."""

    frequency: float
    trough_mass: float
    counter_mass: float = math.inf  # the floor
    stiffness: float = 0.0
    damping: float = 0.0
    base_stiffness: float = 0.0
    force_on_trough: float = 0.0
    force_on_counter_mass: float = 0.0


@dataclass(frozen=True)
class Body:
    """A body: mass [kg], angles [rad], frictions, restitution."""

    mass: float
    drive_angle: float
    static_friction: float
    kinetic_friction: float
    trough_angle: float = 0.0
    restitution: float = 0.0


class Motion(NamedTuple):
    """What a machine and its body do, over the turns that repeat, or the last ones where none do."""

    amplitude: complex  # [m] phasor of the trough's first harmonic: Re(amplitude e^iwt)
    second: complex  # [m] that of its second harmonic
    relative: complex  # [m] that of the springs' first harmonic
    speed: float  # [m/s] mean speed of the body along the trough
    turns: int  # after which the motion repeats; 0 where it does not


class Reaction(NamedTuple):
    """What a body does to a trough that moves as A sin(wt), whatever lies on it; all per kg of the body.

    Its force along the drive's line has the harmonics Im(share e^iwt) and Im(second e^2iwt), times A w^2.
    """

    share: complex
    second: complex
    energy: float  # [J/kg] lost a turn to friction, impacts and climb, each from its own law
    speed: float  # [m/s]
    turns: int


class Leg(NamedTuple):
    """Part of a motion in one mode: its first phase, the state of all then, its length in phase."""

    mode: int
    phase: float
    start: Floats
    length: float


class Blow(NamedTuple):
    """An impact: phase, impulse on the trough along the drive's line, energy that is lost."""

    phase: float
    impulse: float
    loss: float


def _powers(one: Floats) -> Floats:
    powers = [np.eye(len(one))]
    for _ in range(AHEAD):
        powers.append(one @ powers[-1])
    return np.stack(powers)


def _taylor(flow: Floats) -> Floats:
    """Matrices that give the coefficients of Taylor's series of a state."""
    terms = [np.eye(len(flow))]
    for n in range(1, TERMS):
        terms.append(flow @ terms[-1] / n)
    return np.stack(terms)


def _polynomial(x: float, coefficients: Floats) -> float:
    total = 0.0
    for c in coefficients[::-1].tolist():
        total = total * x + c
    return total


class _Run:
    """One motion, in dimensionless numbers; ``load`` is A w^2/g of a trough that moves as prescribed."""

    def __init__(self, machine: Machine, body: Body, gravity: float, load: float | None = None) -> None:
        w = TURN * machine.frequency
        m1 = machine.trough_mass
        self.body, self.load, self.mass = body, load, body.mass / m1
        self.a, self.b = math.cos(body.drive_angle), math.sin(body.drive_angle)
        self.tilt, self.weight = math.sin(body.trough_angle), math.cos(body.trough_angle)
        self.inverse_counter = m1 / machine.counter_mass
        self.k, self.c = machine.stiffness / (m1 * w * w), machine.damping / (m1 * w)
        self.base = machine.base_stiffness / (m1 * w * w)
        self.on_trough = machine.force_on_trough / (m1 * gravity)
        self.on_counter = machine.force_on_counter_mass / (m1 * gravity)
        self.inverse_trough = 0.0 if load is not None else 1.0
        self.pull = {STICK: 0.0, FORWARD: -body.kinetic_friction, BACK: body.kinetic_friction, FLIGHT: 0.0}
        if load is None and 1.0 + self.mass * self.b * (self.b - body.static_friction * self.a) <= 0.0:
            raise ValueError("so heavy a body on so light a trough jams: rigid bodies have no motion")
        self.trough = [self._acceleration(mode) for mode in range(4)]
        self.flow = [self._flow(mode) for mode in range(4)]
        self.step = TURN / STEPS
        self.ahead = [_powers(expm(flow * self.step)) for flow in self.flow]
        self.taylor = [_taylor(flow) for flow in self.flow]
        self.mesh = np.linspace(0.0, self.step, MESH + 1)[:, None] ** np.arange(TERMS)
        self.margins = [self._margins(mode) for mode in range(4)]
        self.rates = [margins @ flow for margins, flow in zip(self.margins, self.flow, strict=True)]
        self.state, self.mode, self.phase = self._beginning(), STICK, 0.0
        self.legs: list[Leg] = []
        self.blows: list[Blow] = []

    def _acceleration(self, mode: int) -> Floats:
        """Row that gives the trough's acceleration: m1 s'' = forces - what the body takes."""
        row = np.zeros(11)
        if self.load is not None:  # s = G sin p
            row[SIN] = -self.load
            return row
        row[[RELATIVE, RELATIVE_SPEED, COS]] = -self.k, -self.c, self.on_trough
        m, a, b, mu = self.mass, self.a, self.b, self.pull[mode]
        if mode == STICK:  # the body takes m (s'' + g sin(alpha + beta))
            row[ONE] = -m * (a * self.tilt + b * self.weight)
            return row / (1.0 + m)
        if mode == FLIGHT:
            return row
        # N = m (b s'' + g cos beta), of which the body takes b + mu a along the line
        row[ONE] = -m * self.weight * (b + mu * a)
        return row / (1.0 + m * b * (b + mu * a))

    def _normal(self, mode: int) -> Floats:
        """Row of the normal force, per mass of the body."""
        row = self.b * self.trough[mode]
        row[ONE] += self.weight
        return row

    def _needed(self) -> Floats:
        """Row of the force along the trough that holds the body at rest, per mass of the body."""
        row = self.a * self.trough[STICK]
        row[ONE] += self.tilt
        return row

    def _flow(self, mode: int) -> Floats:
        flow = np.zeros((11, 11))
        for place, speed in (
            (RELATIVE, RELATIVE_SPEED),
            (COUNTER, COUNTER_SPEED),
            (XI, XI_SPEED),
            (ETA, ETA_SPEED),
        ):
            flow[place, speed] = 1.0
        flow[COS, SIN], flow[SIN, COS] = -1.0, 1.0
        trough, counter = self.trough[mode], np.zeros(11)
        if self.load is None:
            counter[[RELATIVE, RELATIVE_SPEED, COUNTER, COS]] = self.k, self.c, -self.base, self.on_counter
            counter[ONE] = self.mass * (self.a * self.tilt + self.b * self.weight)
            counter *= self.inverse_counter
            flow[RELATIVE_SPEED], flow[COUNTER_SPEED] = trough - counter, counter
        if mode == FLIGHT:
            flow[XI_SPEED], flow[ETA_SPEED] = -self.a * trough, -self.b * trough
            flow[XI_SPEED, ONE] -= self.tilt
            flow[ETA_SPEED, ONE] -= self.weight
        elif mode != STICK:
            flow[XI_SPEED] = self.pull[mode] * self._normal(mode) - self.a * trough
            flow[XI_SPEED, ONE] -= self.tilt
        return flow

    def _margins(self, mode: int) -> Floats:
        """Rows of what stays positive as long as the mode lasts; the last is of contact, or of flight."""
        unit = np.eye(11)
        if mode == FLIGHT:
            return unit[[ETA]]
        normal = self._normal(mode)
        if mode == STICK:
            mu = self.body.static_friction
            return np.stack([mu * normal + self._needed(), mu * normal - self._needed(), normal])
        return np.stack([(1.0 if mode == FORWARD else -1.0) * unit[XI_SPEED], normal])

    def _beginning(self) -> Floats:
        """State at phase 0: the steady motion of the empty machine, the body at rest on the trough."""
        state = np.zeros(11)
        state[[COS, ONE]] = 1.0
        if self.load is None:
            # unknowns s and y as phasors: both masses' equations of motion without the body
            kappa = self.k + 1j * self.c
            matrix = np.array(
                [
                    [kappa - 1.0, -kappa],
                    [-kappa * self.inverse_counter, (kappa + self.base) * self.inverse_counter - 1.0],
                ]
            )
            s, y = np.linalg.solve(matrix, [self.on_trough, self.on_counter * self.inverse_counter])
            state[[RELATIVE, RELATIVE_SPEED]] = (s - y).real, -(s - y).imag
            state[[COUNTER, COUNTER_SPEED]] = y.real, -y.imag
        return state

    def settle(self, most: int, mean_over: int) -> int:
        """Follow the motion until it repeats, then these turns again; return how many, 0 if it never does."""
        self._decide()
        seen: list[Floats] = []
        for _ in range(most):
            self._turn()
            seen.append(
                np.append(self.state[[RELATIVE, RELATIVE_SPEED, XI_SPEED, ETA, ETA_SPEED]], self.mode)
            )
            for turns in range(1, LONGEST_PERIOD + 1):
                if len(seen) > turns and np.abs(seen[-1] - seen[-1 - turns]).max() < SAME:
                    self._record(turns)
                    return turns
        self._record(mean_over)
        return 0

    def _record(self, turns: int) -> None:
        self.legs.clear()
        self.blows.clear()
        self.progress, self.turns = 0.0, turns
        for _ in range(turns):
            self.progress += self._turn()

    def _turn(self) -> float:
        """Follow one turn, and return by how much the body advances."""
        self.phase = 0.0
        self.state[[COS, SIN]] = 1.0, 0.0
        for _ in range(MOST_LEGS):
            if self.phase >= TURN:
                break
            self._leg(TURN - self.phase)
        else:
            raise ArithmeticError("events pile up")
        advance = float(self.state[XI])
        self.state[XI] = 0.0
        if self.base == 0.0:
            self.state[[COUNTER, COUNTER_SPEED]] = 0.0
        return advance

    def _leg(self, longest: float) -> None:
        """Follow one mode to its end, for ``AHEAD`` steps, or to the end of the turn."""
        mode, start = self.mode, self.state
        states = self.ahead[mode] @ start
        margins, rates = states @ self.margins[mode].T, states @ self.rates[mode].T
        last = min(AHEAD, math.ceil(longest / self.step))
        after = margins[1 : last + 1]
        # a margin that dips inside a step falls at its start and grows at its end
        dips = (rates[:last] < 0.0) & (rates[1 : last + 1] > 0.0)
        suspicious = (after <= 0.0) | dips
        suspicious[0] |= margins[0] < FLAT  # a mode may begin with a margin of zero
        for j in np.flatnonzero(suspicious.any(axis=1)):
            series = (self.taylor[mode] @ states[j]).T
            found = [
                (time, int(which))
                for which in np.flatnonzero(suspicious[j])
                if (time := self._zero(self.margins[mode][which] @ series, j == 0)) is not None
            ]
            if found:
                time, which = min(found, key=lambda zero: zero[0])
                if j * self.step + time < longest:
                    self._go(j * self.step + time, series, time)
                    self._event(mode, which)
                    return
        length = min(longest, last * self.step)
        whole = min(int(length / self.step), last)
        self._go(length, (self.taylor[mode] @ states[whole]).T, length - whole * self.step)
        if length == longest:
            self.phase = TURN

    def _zero(self, series: Floats, first: bool) -> float | None:
        """First zero of a margin inside a step; ``first``: at the mode's beginning it may be zero."""
        if first:
            while series.size > 4 and abs(series[0]) < FLAT:
                series = series[1:]
        if series[0] <= 0.0:
            return 0.0
        slope = series[1:] * np.arange(1, series.size)
        values, slopes = self.mesh[:, : series.size] @ series, self.mesh[:, : slope.size] @ slope
        for j in np.flatnonzero((values[1:] <= 0.0) | ((slopes[:-1] < 0.0) & (slopes[1:] > 0.0))):
            low, high = float(j * self.step / MESH), float((j + 1) * self.step / MESH)
            if values[j + 1] > 0.0:
                high = brentq(_polynomial, low, high, args=(slope,), xtol=1e-15)
                if _polynomial(high, series) > 0.0:
                    continue
            return float(brentq(_polynomial, low, high, args=(series,), xtol=1e-16, rtol=1e-15))
        return None

    def _go(self, length: float, series: Floats, time: float) -> None:
        if length > 0.0:
            self.legs.append(Leg(self.mode, self.phase, self.state, length))
        self.state = np.asarray(series @ time ** np.arange(TERMS))
        self.phase += length
        self.state[[COS, SIN, ONE]] = math.cos(self.phase), math.sin(self.phase), 1.0

    def _event(self, mode: int, which: int) -> None:
        if mode == FLIGHT:
            self._impact()
        elif which == len(self.margins[mode]) - 1:
            self._take_off()
        elif mode == STICK:
            self.mode = FORWARD if which == 0 else BACK
        else:
            self.state[XI_SPEED] = 0.0
            self._decide()

    def _take_off(self) -> None:
        self.mode = FLIGHT
        self.state[ETA] = 0.0

    def _decide(self) -> None:
        """Mode of a body in contact."""
        self.state[[ETA, ETA_SPEED]] = 0.0
        # whether the trough presses on a body does not depend on whether that sticks or slides
        if float(self._normal(FLIGHT) @ self.state) < 0.0:
            self._take_off()
        elif (speed := float(self.state[XI_SPEED])) != 0.0:
            self.mode = FORWARD if speed > 0.0 else BACK
        else:
            forward, back, _ = (float(x) for x in self.margins[STICK] @ self.state)
            self.mode = FORWARD if forward < 0.0 else BACK if back < 0.0 else STICK

    def _impact(self) -> None:
        """Impulses of an impact, normal and by friction: the body slides, and may stop or turn meanwhile."""
        a, b, m, light = self.a, self.b, self.mass, self.inverse_trough
        along, normal = float(self.state[XI_SPEED]), float(self.state[ETA_SPEED])
        rise = -self.body.restitution * normal
        if rise < LEAST_BOUNCE and float(self._normal(FLIGHT) @ self.state) >= 0.0:
            rise = 0.0
        left = rise - normal
        total_t, total_n = 0.0, 0.0
        before = along * along + normal * normal
        # share of a unit of normal impulse that acts along the trough and keeps a body that sticks
        stick = -(a * b * light) / (1.0 / m + a * a * light)
        while left > 0.0:
            sticks = along == 0.0 and -stick <= self.body.static_friction
            share = stick if sticks else math.copysign(self.body.kinetic_friction, -along)
            if along == 0.0 and not sticks:  # the trough recoils backwards
                share = -self.body.kinetic_friction
            gain = 0.0 if sticks else share / m + a * (share * a + b) * light
            lift = 1.0 / m + b * (share * a + b) * light
            stops = along * gain < 0.0 and -along / gain <= left / lift
            impulse = -along / gain if stops else left / lift
            total_t, total_n = total_t + share * impulse, total_n + impulse
            left = left - lift * impulse if stops else 0.0
            along = 0.0 if stops else along + gain * impulse
        self.state[[XI_SPEED, ETA_SPEED, ETA]] = along, rise, 0.0
        impulse = total_t * a + total_n * b
        if self.load is None:
            self.state[RELATIVE_SPEED] -= impulse
        self.blows.append(Blow(self.phase, impulse, 0.5 * (before - along * along - rise * rise)))
        if rise > 0.0:
            self.mode = FLIGHT
        else:
            self._decide()

    def taken(self) -> list[Floats]:
        """Rows of the force along the drive's line that the body takes, per mass of the trough."""
        stick = self.trough[STICK].copy()
        stick[ONE] += self.a * self.tilt + self.b * self.weight
        slides = [(self.b + self.pull[mode] * self.a) * self._normal(mode) for mode in (FORWARD, BACK)]
        return [self.mass * row for row in (stick, *slides, np.zeros(11))]

    def harmonic(self, rows: list[Floats], order: int) -> complex:
        """Phasor of a quantity that each mode gives by a row, impacts apart."""
        total = 0j
        for mode, phases, weights, states in self._points():
            total += complex((weights * (states @ rows[mode])) @ np.exp(-1j * order * phases))
        return 2.0 * total / (TURN * self.turns)

    def blow(self, order: int) -> complex:
        """Phasor of the impulses that the body takes from the trough, per mass of the trough."""
        total = sum((blow.impulse * np.exp(-1j * order * blow.phase) for blow in self.blows), 0j)
        return 2.0 * complex(total) / (TURN * self.turns)

    def friction(self) -> float:
        """Energy a turn that friction takes, per mass of the body."""
        total = 0.0
        for mode, _, weights, states in self._points():
            total -= float(weights @ (states @ (self.pull[mode] * self._normal(mode)) * states[:, XI_SPEED]))
        return total / self.turns

    def _points(self) -> Iterator[tuple[int, Floats, Floats, Floats]]:
        """Gauss's points of all legs recorded: mode, phases, weights and states."""
        for mode, phase, start, length in self.legs:
            parts = math.ceil(length / (4.0 * self.step))
            half = 0.5 * length / parts
            times = half * (1.0 + NODES)
            inside, whole = expm(self.flow[mode] * times[:, None, None]), expm(self.flow[mode] * 2.0 * half)
            state = start
            for part in range(parts):
                yield mode, phase + 2.0 * half * part + times, half * WEIGHTS, inside @ state
                state = whole @ state


def follow(
    machine: Machine, body: Body, gravity: float = 9.81, most: int = 3000, mean_over: int = 300
) -> Motion:
    """Follow a machine and its body from the empty machine's steady motion on, until all repeats."""
    run = _Run(machine, body, gravity)
    turns = run.settle(most, mean_over)
    w = TURN * machine.frequency
    unit = gravity / (w * w)
    # the acceleration's phasor is -n^2 that of the motion; an impact changes the trough's speed at once
    first, second = (run.harmonic(run.trough, n) - run.blow(n) for n in (1, 2))
    relative = run.harmonic([np.eye(11)[RELATIVE]] * 4, 1)
    speed = run.progress * unit * machine.frequency / run.turns
    return Motion(-first * unit, -0.25 * second * unit, relative * unit, speed, turns)


def react(
    amplitude: float,
    frequency: float,
    body: Body,
    gravity: float = 9.81,
    most: int = 500,
    mean_over: int = 300,
) -> Reaction:
    """Follow a body on a trough that moves as A sin(wt), and return what it does to the trough."""
    w = TURN * frequency
    load = amplitude * w * w / gravity
    run = _Run(Machine(frequency, body.mass), body, gravity, load)
    turns = run.settle(most, mean_over)
    # i times the phasor of a real part is that of an imaginary part
    first, second = (-1j * (run.harmonic(run.taken(), n) + run.blow(n)) / load for n in (1, 2))
    climb = run.tilt * run.progress
    lost = run.friction() + (sum(blow.loss for blow in run.blows) + climb) / run.turns
    unit = gravity / (w * w)
    return Reaction(first, second, lost * gravity * unit, run.progress * unit * frequency / run.turns, turns)
