"""Motions in which bodies from many starts settle, and how many of the starts each takes.

Bodies are laid down at rest on the trough, or dropped on it, at evenly spread phases. In contact all cycles
are the fixed points of the return map of one turn, Eq. (36); of bodies that hop they are those to which the
starts lead. Lengths in A, speeds in A w, normal speeds over n = cos(beta)/G [A w n], phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.bounces import Bounces, Flights, normal_multiplier
from vibro.core.codes import Mode, Regime, Status
from vibro.core.contact import without_cycle
from vibro.core.drive import Loads, phase_difference, proved_multiplier
from vibro.core.flight import bed_of
from vibro.core.history import Course, Launch, State, course_of, first_step, launched, step
from vibro.core.hops import Settled, cycle_of, enter, settle, unsettled
from vibro.core.legs import Track, next_onset, track_of
from vibro.core.numbers import INF, MOST_THROW, NAN, TURN, Doubles, Integers, until, wrap, wrap_around
from vibro.core.return_map import (
    HoppingCycle,
    Hops,
    Orbit,
    Release,
    between,
    cycle_from,
    differ,
    has_stop,
    hopping_cycle,
    in_contact,
    laid,
    orbit_from,
    return_map,
    stopping,
    stops_of,
    write_hops,
)
from vibro.core.slides import Thresholds

# [1] Landing speeds, displacements and peak velocities of one motion differ by less, relative to them, from
# start to start.
_SAME: Final = 1e-6
_MOST_BOUNCES: Final = 1024  # flights of a body that was dropped on a trough that throws none
_LONGEST: Final = 64  # flights of a cycle of such a body
_CLOSED: Final = 1e-9  # [rad, A w n] distance at which it is closed


class Attractors(NamedTuple):
    """Buffers of the motions found, one a row.

    Attributes
    ----------
    phase : Doubles
        Of the trough's motion along itself, where the row's cycle begins [rad].
    rate : Doubles
        Normal speed there, 0 on the trough [A w n].
    velocity : Doubles
        Along the trough, relative to it, there.
    displacement : Doubles
        Per drive cycle [A].
    period : Doubles
        Drive cycles until the motion repeats.
    multiplier : Doubles
        The largest, by modulus.
    impact, impacts : Doubles
        The largest landing speed, and the sum of all [A w n].
    flights : Doubles
        Their number.
    peak : Doubles
        Largest speed along the trough.
    pattern : Integers
        Legs, as ``Return`` has them.
    regime : Integers
        ``Regime``.
    starts : Integers
        How many starts have led there.
    """

    phase: Doubles
    rate: Doubles
    velocity: Doubles
    displacement: Doubles
    period: Doubles
    multiplier: Doubles
    impact: Doubles
    impacts: Doubles
    flights: Doubles
    peak: Doubles
    pattern: Integers
    regime: Integers
    starts: Integers


class Survey(NamedTuple):
    """What starts have led to.

    Attributes
    ----------
    number : int
        Motions that repeat: rows written.
    home : int
        Row of the motion of a body laid down at phase 0; -1 if that does not repeat.
    irregular : int
        Starts whose motion does not repeat.
    displacement, deviation : float
        Mean displacement per drive cycle of these, and its standard error; NaN if there are none [A].
    lost : int
        Starts that run away or were not solved.
    runs_away : bool
        Whether a body that is pushed hard enough down the trough never stops.
    mean : float
        Mean displacement per drive cycle of all starts; NaN if any is lost [A].
    """

    number: int
    home: int
    irregular: int
    displacement: float
    deviation: float
    lost: int
    runs_away: bool
    mean: float


class _Sample(NamedTuple):
    """Means of quarters of irregular motions: their number, mean and sum of squared deviations [A]."""

    number: float
    mean: float
    squares: float


def survey(
    loads: Loads, at: Thresholds, restitution: float, starts: int, height: float, flights: Flights,
    hops: Hops, out: Attractors, room: int,
) -> Survey:  # fmt: skip
    """Follow bodies from evenly spread phases, and tell their motions apart.

    Parameters
    ----------
    loads, at, restitution : Loads, Thresholds, float
        The scene.
    starts : int
        How many: at the phases 2 pi i / ``starts`` of the trough's motion along itself.
    height : float
        From which they are dropped, at rest relative to the trough; 0 where they are laid down [A].
    flights, hops : Flights, Hops
        Scratch memory.
    out, room : Attractors, int
        Rows for the motions; in contact all that are known come first, also those that no start leads to.
    """
    n, t = loads.weight_normal, abs(loads.weight_tangential)
    away = t > loads.kinetic_friction * n
    if not at.hops:
        if without_cycle(loads, at).status != Status.OK:
            return _nothing(starts, away)
        return _on_the_trough(loads, at, restitution, starts, height, flights, hops, out, room, away)
    held = loads.kinetic_friction <= loads.static_friction and t < loads.static_friction * n
    if loads.static_friction == 0.0 or not held or loads.drive_normal > MOST_THROW * n:
        return _nothing(starts, away)
    return _of_hops(loads, restitution, starts, height, flights, hops, out, room, away)


def _nothing(starts: int, away: bool) -> Survey:
    return Survey(0, -1, 0, NAN, NAN, starts, away, NAN)


def _start(starts: int, i: int, height: float) -> Launch:
    return Launch(TURN * i / starts, 0.0, height, 0.0)


def _of_hops(
    loads: Loads, restitution: float, starts: int, height: float, flights: Flights, hops: Hops,
    out: Attractors, room: int, away: bool,
) -> Survey:  # fmt: skip
    """Survey a trough that throws bodies."""
    course = course_of(loads, restitution)
    track = track_of(loads, restitution)
    number, home, lost, irregular = 0, -1, 0, 0
    sample = _Sample(0.0, 0.0, 0.0)
    for i in range(starts):
        settled = unsettled(0.0)
        if i == 0 and height == 0.0:  # as ``solve`` does it
            entry = enter(track, restitution, flights, hops)
            settled = settled._replace(motion=entry.motion, velocity=entry.velocity)
        if not settled.motion.repeats:
            settled = _followed(course, track, starts, i, height, flights, hops)
        motion = settled.motion
        if not motion.repeats:
            fastest = loads.drive_tangential + loads.kinetic_friction * loads.weight_normal * settled.impact
            runs = away and abs(settled.velocity) > 2.0 * fastest
            if runs or not (settled.third_time > 0.0 and settled.fourth_time > 0.0):
                lost += 1
            else:
                irregular += 1
                sample = _with(sample, TURN * settled.third_path / settled.third_time)
                sample = _with(sample, TURN * settled.fourth_path / settled.fourth_time)
            continue
        cycle = cycle_of(track, motion)
        found = orbit_from(cycle, hops, settled.velocity)
        row = -1
        if found.status <= Status.BOUNDARY:
            row = _row_of(motion, found, flights, out, number)
            if row < 0 and number < room:
                row = number
                normal = normal_multiplier(bed_of(loads), restitution, flights, motion)
                _write(cycle, motion, found, normal, flights, hops, out, row)
                number += 1
        home = row if i == 0 and height == 0.0 else home
        if row < 0:
            lost += 1
        else:
            out.starts[row] += 1
    return _summed(out, number, home, irregular, sample, lost, starts, away)


def _followed(
    course: Course, track: Track, starts: int, i: int, height: float, flights: Flights, hops: Hops
) -> Settled:
    """Follow one of the bodies on a trough that throws them."""
    start = _start(starts, i, height)
    first, friction = launched(course, start), track.loads.static_friction
    if height > 0.0:
        first, friction = first_step(course, start, first).after, track.landed_friction
    begin = Release(True, first.phase, first.velocity)
    if first.mode != Mode.FLIGHT:
        begin = laid(track, first.phase, first.velocity, friction)
    return settle(track, course.restitution, begin, first.rate, i, flights, hops)


def _with(sample: _Sample, value: float) -> _Sample:
    """Add a value, by Welford's formula."""
    number, off = sample.number + 1.0, value - sample.mean
    mean = sample.mean + off / number
    return _Sample(number, mean, sample.squares + off * (value - mean))


def _summed(
    out: Attractors, number: int, home: int, irregular: int, sample: _Sample, lost: int, starts: int,
    away: bool,
) -> Survey:  # fmt: skip
    """Average over all starts."""
    mean, deviation, total = NAN, NAN, 0.0
    if irregular > 0:
        mean, deviation = sample.mean, math.sqrt(sample.squares / (sample.number - 1.0) / sample.number)
        total = irregular * mean
    for row in range(number):
        total += out.starts[row] * out.displacement[row]
    return Survey(
        number, home, irregular, mean, deviation, lost, away, NAN if lost > 0 else total / starts
    )  # fmt: skip


def _row_of(motion: Bounces, found: Orbit, flights: Flights, out: Attractors, number: int) -> int:
    """Return the row of a motion; -1 if it is none of them.

    Motions have one period, and the same landing speeds, displacement and largest speed.
    """
    largest, total = _impacts(motion, flights)
    displacement, peak = found.cycle.displacement / max(motion.cycles, 1), found.cycle.peak
    for row in range(number):
        lands = _near(largest, out.impact[row], largest) and _near(total, out.impacts[row], total)
        slides = _near(displacement, out.displacement[row], peak) and _near(peak, out.peak[row], peak)
        if lands and slides and out.period[row] == motion.cycles:
            return row
    return -1


def _near(one: float, other: float, scale: float) -> bool:
    return abs(one - other) <= _SAME * scale


def _impacts(motion: Bounces, flights: Flights) -> tuple[float, float]:
    largest, total = 0.0, 0.0
    for row in range(motion.first, motion.first + motion.count):
        largest, total = max(largest, flights.impact[row]), total + flights.impact[row]
    return largest, total


def _write(
    cycle: HoppingCycle, motion: Bounces, found: Orbit, normal: float, flights: Flights, hops: Hops,
    out: Attractors, row: int,
) -> None:  # fmt: skip
    """Write a row, to which no start has led yet."""
    now, velocity = found.cycle, found.velocity
    phase, rate, flies = cycle.landing, 0.0, cycle.last > cycle.first
    if flies and cycle.rest == 0.0:
        phase, rate = flights.phase[motion.first], flights.speed[motion.first]
    elif flies:  # the row begins at the landing before the contact
        velocity = return_map(cycle.track, hops, cycle.first, cycle.last, 0.0, 0.0, velocity).velocity
    out.phase[row] = wrap(phase - phase_difference(cycle.track.loads))
    out.rate[row] = rate
    out.velocity[row] = velocity
    out.displacement[row] = now.displacement / motion.cycles
    out.period[row] = motion.cycles
    out.multiplier[row] = proved_multiplier(cycle.track.loads, max(now.slope, normal))
    out.impact[row], out.impacts[row] = _impacts(motion, flights)
    out.flights[row] = motion.count
    out.peak[row] = now.peak
    out.pattern[row] = now.pattern
    out.regime[row] = Regime.HOPPING
    if not flies:
        out.regime[row] = Regime.BACK_SLIP if now.back else Regime.FORWARD_SLIP
        if not (now.back or now.forward):
            out.regime[row] = Regime.NO_SLIP
    out.starts[row] = 0


# ------------------------------------------------------------------------------
# Troughs that throw no body.


def _on_the_trough(
    loads: Loads, at: Thresholds, restitution: float, starts: int, height: float, flights: Flights,
    hops: Hops, out: Attractors, room: int, away: bool,
) -> Survey:  # fmt: skip
    """Survey a trough that throws no body: all cycles in contact, and what the starts lead to."""
    course, track = course_of(loads, restitution), track_of(loads, 0.0)
    begin, slid = phase_difference(loads), Bounces(True, 0, 0, 0, 1, 0.0, 0.0, 0.0)
    slips = at.forward or at.back
    phase, wait = begin, 0.0
    if slips:
        ahead, behind = next_onset(track, 1.0, begin), next_onset(track, -1.0, begin)
        onset = ahead if loads.line or ahead.wait <= behind.wait else behind
        onset = behind if not onset.wait < INF else onset
        if onset.wait < INF:  # else rounding hides it, and the body rests
            phase, wait = onset.phase, onset.wait
    cycle = hopping_cycle(track, 0, 0, phase, TURN, TURN)
    velocity = return_map(track, hops, 0, 0, begin, wait, 0.0).velocity if wait > 0.0 else 0.0
    home = orbit_from(cycle, hops, velocity)
    number = 0
    if slips:
        number = _fixed_points(cycle, slid, velocity, home, flights, hops, out, room)
    elif room > 0:
        _write(cycle, slid, home, 0.0, flights, hops, out, 0)
        out.phase[0], out.multiplier[0], out.regime[0], number = 0.0, 0.0, Regime.NO_SLIP, 1
    first, lost, irregular, sample = -1, 0, 0, _Sample(0.0, 0.0, 0.0)
    for i in range(starts):
        now = launched(course, _start(starts, i, height))
        friction = loads.static_friction
        if height > 0.0:
            now = first_step(course, _start(starts, i, height), now).after
            friction = course.track.landed_friction
            for _ in range(_MOST_BOUNCES):
                if now.mode != Mode.FLIGHT:
                    break
                now = step(course, now).after
        settled = unsettled(now.velocity)
        row, found, here = -1, home, cycle
        if now.mode == Mode.FLIGHT:
            settled = _bounced(course, now, flights, hops)
            if not settled.motion.repeats and settled.fourth_time > 0.0:
                irregular += 1
                sample = _with(sample, TURN * settled.third_path / settled.third_time)
                sample = _with(sample, TURN * settled.fourth_path / settled.fourth_time)
                continue
            here = cycle_of(course.track, settled.motion) if settled.motion.repeats else cycle
        elif not slips:
            here = cycle._replace(landing=now.phase)
        motion = settled.motion if now.mode == Mode.FLIGHT else slid
        if i > 0 or height > 0.0:
            enters = now.velocity
            if now.mode != Mode.FLIGHT and here.landing != now.phase:
                wait = until(here.landing, now.phase)
                enters = in_contact(track, now.phase, wait, now.velocity, friction).velocity
            found = orbit_from(here, hops, enters)
        if found.status <= Status.BOUNDARY and motion.repeats:
            row = _row_of(motion, found, flights, out, number)
            if row < 0 and number < room:
                row = number
                normal = 0.0
                if motion.count > 0:
                    normal = normal_multiplier(course.bed, restitution, flights, motion)
                _write(here, motion, found, normal, flights, hops, out, row)
                number += 1
        first = row if i == 0 and height == 0.0 else first
        if row < 0:
            lost += 1
        else:
            out.starts[row] += 1
    return _summed(out, number, first, irregular, sample, lost, starts, away)


def _bounced(course: Course, start: State, flights: Flights, hops: Hops) -> Settled:
    """Look for the cycle of a body that still bounces, else follow it for two samples of its flights."""
    now, time, settled = start, 0.0, unsettled(start.velocity)
    for row in range(_LONGEST):
        leg = step(course, now)
        flights.phase[row], flights.speed[row] = now.phase, now.rate
        flights.length[row], flights.impact[row] = leg.length, leg.impact
        flights.impulse[row], flights.before[row] = (1.0 + course.restitution) * leg.impact, time
        flights.landing[row], flights.rest[row] = 0.0, 0.0
        time, now = time + leg.length, leg.after
        if now.mode != Mode.FLIGHT:
            return settled
        apart = abs(wrap_around(now.phase - start.phase)) + abs(now.rate - start.rate)
        if apart <= _CLOSED * (1.0 + start.rate):
            cycles = int(math.floor(time / TURN + 0.5))
            write_hops(course.track.loads, flights, hops, 0, row + 1)
            return settled._replace(motion=Bounces(True, 0, row + 1, 0, cycles, 0.0, 0.0, start.phase))
    middle = _some_flights(course, now)
    end = _some_flights(course, middle)
    return settled._replace(
        third_time=_elapsed(now, middle), third_path=middle.position - now.position,
        fourth_time=_elapsed(middle, end), fourth_path=end.position - middle.position,
    )  # fmt: skip


def _some_flights(course: Course, now: State) -> State:
    for _ in range(_MOST_BOUNCES // 4):
        if now.mode == Mode.FLIGHT:
            now = step(course, now).after
    return now


def _elapsed(one: State, other: State) -> float:
    return TURN * (other.cycle - one.cycle) + (other.phase - one.phase)


def _fixed_points(
    cycle: HoppingCycle, motion: Bounces, start: float, home: Orbit, flights: Flights, hops: Hops,
    out: Attractors, room: int,
) -> int:  # fmt: skip
    """Write all cycles in contact; return their number.

    ``home`` is the one to which a body leads that enters with the velocity ``start``.
    """
    number = 0
    solved = home.status <= Status.BOUNDARY
    if solved:
        number = _listed(cycle, motion, home, flights, hops, out, number, room)
        if cycle.neutral and not has_stop(home.cycle):
            return number  # every other velocity repeats too
    begin = cycle_from(cycle, hops, start)
    low, high, slides = cycle.bound, -cycle.bound, solved and not has_stop(home.cycle)
    if solved:
        low, high = min(low, home.velocity), max(high, home.velocity)
    for index in range(stops_of(cycle)):
        found = stopping(cycle, hops, start, begin, 0.0, index)
        if found.status == Status.OK:
            low, high = min(low, found.velocity), max(high, found.velocity)
            number = _listed(cycle, motion, found, flights, hops, out, number, room)
    for side in range(2):
        if slides or not cycle.bounded:
            continue
        bound, near = (-cycle.bound, low) if side == 0 else (cycle.bound, high)
        found = between(cycle, hops, bound, near)
        if found.status == Status.OK:
            number = _listed(cycle, motion, found, flights, hops, out, number, room)
    return number


def _listed(
    cycle: HoppingCycle, motion: Bounces, found: Orbit, flights: Flights, hops: Hops, out: Attractors,
    number: int, room: int,
) -> int:  # fmt: skip
    """Write a fixed point that is no row yet, if there is room; return the number of rows then."""
    if number == room:
        return number
    for row in range(number):
        beside = Orbit(out.velocity[row], found.cycle, found.status)
        near = _near(found.cycle.displacement, out.displacement[row], found.cycle.peak)
        if near and not differ(cycle, found, beside):
            return number
    _write(cycle, motion, found, 0.0, flights, hops, out, number)
    return number + 1
