"""Doors of single motions: scenes in buffers in, histories, their moments and arrival times out."""

from __future__ import annotations

import math
from typing import NamedTuple

from vibro.core.arrival import arrival_cycles
from vibro.core.attractors import Attractors, list_attractors
from vibro.core.bounces import Bounces, Flights, fly_round
from vibro.core.buffers import EXTREME, MOST_THROW, Doubles, Integers, Moments
from vibro.core.codes import Mode
from vibro.core.drives import (
    Loads,
    along_sine,
    free_along,
    free_normal,
    normal_height,
    normal_load,
    phase_difference,
    tangential_load,
)
from vibro.core.elementary import NAN, TURN, wrap
from vibro.core.history import LastStarts, Legs, follow_legs, sections_from
from vibro.core.hopping import cycle_of, entered
from vibro.core.orbits import orbit_from
from vibro.core.return_map import Hops
from vibro.core.scenes import Place, Point, Scenes, point_at, seek
from vibro.core.steps import Launch, course_of
from vibro.core.windows import thresholds

__all__ = [
    "Cycle", "Turn", "arrivals", "attractors", "flights_along", "followed", "history", "moments",
    "return_of_flights",
]  # fmt: skip


class Cycle(NamedTuple):
    """Steady cycle of a history: the fields of ``Followed``, one element each."""

    first: Integers
    period: Integers
    advance: Doubles


def _is_followed(loads: Loads) -> bool:
    """Whether a body can be followed.

    It cannot where mu_d > mu_s, where it is thrown so high that the phase of a landing is lost, or where
    products of its loads and frictions overflow.
    """
    n, t = loads.weight_normal, loads.weight_tangential
    mu_s, mu_d = loads.static_friction, loads.kinetic_friction
    if mu_d > mu_s or loads.drive_normal > MOST_THROW * n or mu_s > EXTREME:
        return False
    weight = max(n, abs(t))
    return 1.0 / EXTREME <= weight <= EXTREME and (mu_d == 0.0 or mu_d >= 1.0 / EXTREME)


def _point(scenes: Scenes, place: Place, cell: int) -> Point:
    """Read the scene of a cell."""
    seek(scenes, place, cell)
    return point_at(scenes, place)


def followed(scenes: Scenes, place: Place, cell: int) -> int:
    """Return 1 if the body of a cell can be followed, else 0."""
    return 1 if _is_followed(_point(scenes, place, cell).loads) else 0


def arrivals(
    scenes: Scenes, place: Place, phase: float, velocity: float, height: float, rate: float, length: Doubles,
    advance: Doubles, times: Doubles, flights: Flights, begin: int, end: int,
) -> None:  # fmt: skip
    """Write the times until bodies have moved by a length; NaN where nobody knows.

    Parameters
    ----------
    scenes, place : Scenes, Place
        The cells, and the thread's memory.
    phase, velocity : float
        Phase of the trough's motion along itself [rad], and how fast the bodies slide [m/s], at the start.
    height, rate : float
        Of the bodies above the trough [m], and how fast they leave it [m/s], at the start.
    length, advance : Doubles
        Of each cell, where the body shall arrive, and the displacement per drive cycle of its steady cycle,
        NaN where that is unknown [m].
    times : Doubles
        When it arrives, inf where it never does [s].
    flights : Flights
        Scratch memory.
    begin, end : int
        Range of the cells.
    """
    for i in range(begin, end):
        times[i] = NAN
        point = _point(scenes, place, i)
        if _is_followed(point.loads):
            course = course_of(point.loads, point.restitution)
            speed = point.scale * TURN * point.frequency
            up = rate / speed / point.loads.weight_normal
            start = Launch(phase, velocity / speed, height / point.scale, up)
            sections = sections_from(course, start, flights)
            reach, steady = length[i] / point.scale, advance[i] / point.scale
            times[i] = arrival_cycles(course, sections, reach, start, steady) / point.frequency


def history(
    scenes: Scenes, place: Place, phase: float, velocity: float, height: float, rate: float, cycles: float,
    legs: Legs, rows: int, cycle: Cycle, last: LastStarts, flights: Flights,
) -> int:  # fmt: skip
    """Follow the body of the first cell; return the number of its legs, -1 if they do not fit.

    Parameters
    ----------
    scenes, place : Scenes, Place
        The cells, and the thread's memory.
    phase, velocity : float
        Phase of the trough's motion along itself [rad], and how fast the body slides [A w], at the start.
    height, rate : float
        Of the body above the trough [A], and how fast it leaves it [A w], at the start.
    cycles : float
        Drive cycles to be followed.
    legs, rows : Legs, int
        Buffers of ``rows`` elements: the legs until the motion repeats.
    cycle : Cycle
        The steady cycle.
    last, flights : LastStarts, Flights
        Scratch memory.
    """
    point = _point(scenes, place, 0)
    course = course_of(point.loads, point.restitution)
    start = Launch(phase, velocity, height, rate / point.loads.weight_normal)
    sections = sections_from(course, start, flights)
    found = follow_legs(course, sections, start, cycles, legs, rows, last)
    cycle.first[0] = found.first
    cycle.period[0] = found.period
    cycle.advance[0] = found.advance
    return found.number


def attractors(
    scenes: Scenes, place: Place, flights: Flights, hops: Hops, out: Attractors, told: Integers, room: int
) -> int:
    """List the cycles that coexist in the first cell; return their number.

    ``told`` is written with four numbers: whether the first is that from rest, starts that were followed,
    those of them that did not lead to a cycle, and whether a body may run away. Normal speeds in A w.
    """
    point = _point(scenes, place, 0)
    at = thresholds(point.loads)
    found = list_attractors(point.loads, at, point.restitution, flights, hops, out, room)
    for row in range(found.number):
        out.rate[row] *= point.loads.weight_normal
    told[0] = 1 if found.from_rest else 0
    told[1] = found.starts
    told[2] = found.lost
    told[3] = 1 if found.runs_away else 0
    return found.number


class Turn(NamedTuple):
    """Some flights of one scene, one after the other: one element each.

    Attributes
    ----------
    elapsed, speed : Doubles
        Phase until the take-off after them [rad], and its normal speed [A w n].
    phase_phase, phase_speed, speed_phase, speed_speed : Doubles
        Derivatives of that take-off with respect to the first one.
    weight : Doubles
        n = cos(beta)/G, the unit of normal speeds over A w.
    """

    elapsed: Doubles
    speed: Doubles
    phase_phase: Doubles
    phase_speed: Doubles
    speed_phase: Doubles
    speed_speed: Doubles
    weight: Doubles


def return_of_flights(
    scenes: Scenes, place: Place, flights: Flights, phase: float, speed: float, count: int, out: Turn
) -> int:
    """Fly ``count`` times in the first cell, from a phase of the trough's motion along itself.

    Returns 1; 0 where a landing leads to a contact, and -1 where the trough throws no body: then the weight
    alone is written.
    """
    point = _point(scenes, place, 0)
    out.weight[0] = point.loads.weight_normal
    if not thresholds(point.loads).hops:
        return -1
    bed, begin = course_of(point.loads, point.restitution).bed, wrap(phase + phase_difference(point.loads))
    flown = fly_round(bed, point.restitution, flights, 0, count, begin, speed)
    if not flown.flies:
        return 0
    out.elapsed[0], out.speed[0] = flown.elapsed, flown.speed
    out.phase_phase[0], out.phase_speed[0] = flown.derivatives.phase_phase, flown.derivatives.phase_speed
    out.speed_phase[0], out.speed_speed[0] = flown.derivatives.speed_phase, flown.derivatives.speed_speed
    return 1


def flights_along(
    scenes: Scenes, place: Place, flights: Flights, hops: Hops, count: int, cycles: int, velocity: float,
    out: Doubles,
) -> int:  # fmt: skip
    """Follow a body along the trough, over flights that ``return_of_flights`` has written and that repeat.

    ``out`` is written with the velocity at the first take-off at which the motion repeats [A w], the
    displacement per drive cycle [A] and the slope of the return map; the status is returned.
    """
    point = _point(scenes, place, 0)
    course = course_of(point.loads, point.restitution)
    motion = Bounces(True, 0, count, 0, cycles, 0.0, 0.0, flights.phase[0])
    entry = entered(course.track, motion, velocity, flights, hops)
    found = orbit_from(cycle_of(course.track, motion), hops, entry.velocity)
    out[0], out[1], out[2] = found.velocity, found.cycle.displacement / cycles, found.cycle.slope
    return found.status


def moments(
    scenes: Scenes, place: Place, legs: Legs, height: float, row: Integers, since: Doubles, found: Moments,
    count: int,
) -> None:  # fmt: skip
    """Evaluate the motion of the first cell's body at moments of its legs.

    Parameters
    ----------
    scenes, place : Scenes, Place
        The cells, of which the first is the history's, and the thread's memory.
    legs, height : Legs, float
        The history, and the body's height above the trough at its start.
    row, since : Integers, Doubles
        Leg of each moment, and the phase since its start, at most its length [rad].
    found : Moments
        Motion and loads there.
    count : int
        Number of moments.
    """
    loads = _point(scenes, place, 0).loads
    a, mu_d = loads.drive_tangential, loads.kinetic_friction
    for i in range(count):
        leg, s = row[i], since[i]
        mode, start = legs.mode[leg], legs.phase[leg]
        flies, over = mode == Mode.FLIGHT, s >= legs.length[leg]
        phase = start + (wrap(s) if mode == Mode.REST else s)
        load, normal = tangential_load(loads, phase), max(normal_load(loads, phase), 0.0)
        found.sine[i] = math.sin(phase)
        found.trough_along[i] = a * along_sine(loads, phase)
        found.trough_normal[i] = normal_height(loads, phase)
        found.inertial[i] = load
        found.normal[i] = 0.0 if flies else normal
        found.path[i] = 0.0
        found.velocity[i] = 0.0
        found.acceleration[i] = 0.0
        found.gap[i] = 0.0
        if mode != Mode.REST:
            # N = -eta'': friction moves the body as far as the normal motion of a body without support would
            friction = -mu_d if mode == Mode.BACK else mu_d
            if flies:
                friction = 0.0
            found.acceleration[i] = load - friction * normal
            if over:
                found.path[i] = legs.displacement[leg]
                found.velocity[i] = legs.end_velocity[leg]
            else:
                along = free_along(loads, start, legs.velocity[leg], s)
                off = free_normal(loads, start, legs.rate[leg], s)
                found.path[i] = along.path + friction * off.path
                found.velocity[i] = along.velocity + friction * off.velocity
                above = height if leg == 0 else 0.0
                found.gap[i] = max(above + off.path, 0.0) if flies else 0.0
