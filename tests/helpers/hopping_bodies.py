"""Bodies that hop, for the tests: their loads by the throw number, and the walk apart from the package."""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, NamedTuple

from engines.two_axis_walk import Body, Cycle

from vibro.core.bounces import Flights
from vibro.core.drive import Loads, directions, ellipse_loads, line_loads
from vibro.core.numbers import BODIES, LONGEST_CYCLE, MOST_BOUNCES, MOST_HOPS
from vibro.core.return_map import Hops

if TYPE_CHECKING:
    from collections.abc import Iterator

TURN = 2.0 * math.pi


def _buffer(rows: int) -> memoryview[float]:
    return memoryview(bytearray(8 * rows)).cast("d")


FLIGHTS = Flights(*(_buffer(MOST_BOUNCES + LONGEST_CYCLE) for _ in Flights._fields))
HOPS = Hops(*(_buffer(BODIES * MOST_HOPS) for _ in range(8)))


def line(throw: float, drive_deg: float, mu_s: float, mu_d: float, trough_deg: float = 0.0) -> Loads:
    """Form the groups of a drive along a line from K = G sin(alpha) / cos(beta)."""
    drive, trough = math.radians(drive_deg), math.radians(trough_deg)
    weight = math.sin(drive) / throw / math.cos(trough)
    return line_loads(weight, directions(drive, trough), mu_s, mu_d)


def ellipse(
    throw: float, along: float, normal: float, phase: float, mu_s: float, mu_d: float, trough: float = 0.0
) -> Loads:
    """Form the groups of an elliptical drive, X/A and Y/A, from K; angles [rad]."""
    return ellipse_loads(
        along, normal, normal / throw / math.cos(trough), directions(phase, trough), mu_s, mu_d
    )


class Drawn(NamedTuple):
    """A scene drawn at random."""

    loads: Loads
    restitution: float


def draw(
    count: int,
    seed: int,
    *,
    throw: tuple[float, float] = (1.001, 3.2),
    ratio: tuple[float, float] = (0.05, 1.0),
    slope: float = 0.8,
    restitution: float = 0.0,
    ellipses: bool = False,
) -> Iterator[Drawn]:
    """Draw scenes; half of the troughs are level; kinetic friction holds on the others if ``slope`` < 1."""
    pick = random.Random(seed)
    for _ in range(count):
        k = math.exp(pick.uniform(math.log(throw[0]), math.log(throw[1])))
        mu_s = math.exp(pick.uniform(math.log(0.1), math.log(1.5)))
        mu_d = mu_s * pick.uniform(*ratio)
        trough = pick.choice((0.0, 1.0)) * pick.uniform(-slope, slope) * min(math.atan(mu_d), 0.4)
        e = restitution * pick.random()
        if ellipses:
            along = math.exp(pick.uniform(math.log(0.3), math.log(4.0)))
            scale, phase = max(along, 1.0), pick.uniform(-math.pi, math.pi)
            yield Drawn(ellipse(k, along / scale, 1.0 / scale, phase, mu_s, mu_d, trough), e)
        else:
            yield Drawn(line(k, pick.uniform(5.0, 60.0), mu_s, mu_d, math.degrees(trough)), e)


def lift_off(loads: Loads) -> float:
    """Return the phase at which the trough falls away under a body."""
    return math.asin(loads.weight_normal / loads.drive_normal)


def walker(loads: Loads, restitution: float = 0.0) -> Body:
    """Put a body at rest at phase 0, followed apart from the package; its lengths are in ``unit(loads)``."""
    load = unit(loads)
    return Body(
        load * loads.drive_tangential,
        load * loads.drive_normal,
        math.atan2(loads.phase_sine, loads.phase_cosine),
        1.0 / TURN,
        loads.static_friction,
        loads.kinetic_friction,
        math.atan2(loads.weight_tangential, loads.weight_normal),
        1.0,
        restitution,
    )


def unit(loads: Loads) -> float:
    """Return A in lengths of g / w^2, which the walk counts in: G."""
    return 1.0 / math.hypot(loads.weight_normal, loads.weight_tangential)


def walked(loads: Loads, restitution: float = 0.0) -> Cycle:
    """Return the cycle that a walk from rest settles into, with lengths in A."""
    cycle, a = walker(loads, restitution).settle(), unit(loads)
    return cycle._replace(displacement=cycle.displacement / a, peak=cycle.peak / a, impact=cycle.impact / a)


class Round(NamedTuple):
    """What a body does from one lift-off to the next."""

    velocity: float
    displacement: float
    peak: float
    pattern: str
    impulse: float  # of friction, while the body does not stop


def walk_round(loads: Loads, restitution: float, velocity: float) -> Round:
    """Walk from a lift-off, with a velocity, to the next lift-off after a contact."""
    body, a = walker(loads, restitution), unit(loads)
    phi = math.atan2(loads.phase_sine, loads.phase_cosine)
    body.p, body.v = (lift_off(loads) - phi) % TURN, velocity * a
    rise, kinds, path, peak, change = 0.0, "", 0.0, abs(velocity * a), 0.0
    while True:
        before = body.v
        p = body.p
        leg, rise, aloft = body._fly(rise)
        flown = body.a * (math.cos(p) - math.cos(p + leg.length)) - body.slope * leg.length
        change += body.v - before - flown
        body.p = (p + leg.length) % TURN
        kinds, path, peak = kinds + "H", path + leg.path, max(peak, leg.peak)
        if not aloft:
            break
    while not aloft:
        before, p = body.v, body.p
        leg, aloft = body._touch()
        body.p = (p + leg.length) % TURN
        flown = body.a * (math.cos(p) - math.cos(p + leg.length)) - body.slope * leg.length
        change += body.v - before - flown
        if leg.length > 0.0:
            kinds, path, peak = kinds + leg.kind, path + leg.path, max(peak, leg.peak)
    return Round(body.v / a, path / a, peak / a, kinds, change / a)
