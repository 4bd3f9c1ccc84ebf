"""The solver's doors: loops over scenes, from buffers into buffers.

Compiled they hold no lock, so that threads may run them side by side; each cell's numbers depend on its scene
alone, whatever range it is solved in. Results are in SI units.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.attractors import Attractors, survey
from vibro.core.bounces import Bounces, Flights, fly_round
from vibro.core.boxes import cover, evolve
from vibro.core.codes import SPELT_PATTERNS, Mode, Model, Regime, Status
from vibro.core.contact import (
    SlideLeg,
    cycle_slides,
    load_slope,
    outlasts_back,
    pair_of,
    ratio_of,
    regime_alone,
    steady_cycle,
)
from vibro.core.drive import Loads, phase_difference, proved_multiplier
from vibro.core.filling import Reaction, force_bound, mean_reaction, reaction_in_contact, reaction_of_hops
from vibro.core.history import LastStarts, Launch, Legs, arrival_cycles, course_of, follow_legs, sections_from
from vibro.core.hops import cycle_of, entered, hopping, write_hopping_letters
from vibro.core.limits import critical_loads, tipping_load, wave_limits, write_spans
from vibro.core.machines import Complex, filled_natural_frequency, transfer
from vibro.core.numbers import (
    EXTREME,
    LINE,
    MOST_THROW,
    NAN,
    TURN,
    Bytes,
    Doubles,
    Fillings,
    Integers,
    Operated,
    Sampled,
    Span,
    Springs,
    wrap,
)
from vibro.core.operating import Feeder, Machine, all_amplitudes, feeder_of, write_operated
from vibro.core.return_map import Hops, orbit_from
from vibro.core.scenes import Place, Point, Scenes, point_at, prepare, seek, unit_point_at, visit
from vibro.core.slides import thresholds
from vibro.core.timeline import (
    instant_at,
    moment_of,
    phase_at,
    position_of,
    row_of,
    start_of,
    steady_legs,
    turn_letters,
)
from vibro.core.wave_cycle import wave_cycle, write_contact_letters
from vibro.core.waves import SINE

# ------------------------------------------------------------------------------
# Doors of single motions: scenes in buffers in, histories, their moments and arrival times out.


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


class Found(NamedTuple):
    """What a survey says beside its motions: the fields of ``Survey``, one element each.

    ``counts`` holds number, home, irregular, lost and, as 1 or 0, runs_away; ``means`` displacement and
    deviation of irregular motion, and the mean of all starts.
    """

    counts: Integers
    means: Doubles


def attractors(
    scenes: Scenes, place: Place, starts: int, height: float, flights: Flights, hops: Hops, out: Attractors,
    found: Found, room: int,
) -> None:  # fmt: skip
    """Survey the first cell; a height in m, normal speeds in A w."""
    point = _point(scenes, place, 0)
    at, n = thresholds(point.loads), point.loads.weight_normal
    here = survey(point.loads, at, point.restitution, starts, height / point.scale, flights, hops, out, room)
    for row in range(here.number):
        out.rate[row] *= n
    found.counts[0], found.counts[1], found.counts[2] = here.number, here.home, here.irregular
    found.counts[3], found.counts[4] = here.lost, 1 if here.runs_away else 0
    found.means[0], found.means[1], found.means[2] = here.displacement, here.deviation, here.mean


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


def sample(
    scenes: Scenes, place: Place, legs: Legs, span: Span, height: float, off: float, times: Doubles,
    after: Bytes, out: Sampled, count: int,
) -> None:  # fmt: skip
    """Sample the motion of the first cell's body, and the forces on it.

    Parameters
    ----------
    scenes, place : Scenes, Place
        The cells, of which the first is the history's, and the thread's memory.
    legs, span, height : Legs, Span, float
        The history, and the body's height above the trough at its start [A].
    off : float
        From a time to the moment whose forces are those there, where the trough's acceleration jumps and
        rounding would decide on which side of a jump a time lies [rad]; else 0.
    times, after : Doubles, Bytes
        When [s], and whether after what happens then, or before.
    out : Sampled
        Is written.
    count : int
        Number of times.
    """
    point = _point(scenes, place, 0)
    loads, scale, line = point.loads, point.scale, scenes.kind == LINE
    speed = scale * TURN * point.frequency
    force = speed * TURN * point.frequency
    for i in range(count):
        at = instant_at(legs, span, times[i], after[i] != 0)
        leg, now = at.row, moment_of(loads, legs, at.row, at.since, height)
        acts = now
        if off > 0.0:
            beside = at.since + off if after[i] != 0 else at.since - off
            acts = moment_of(loads, legs, leg, min(max(beside, 0.0), legs.length[leg]), height)
        out.trough_displacement[i] = scale * now.sine if line else NAN
        out.trough_along[i], out.trough_normal[i] = scale * now.trough_along, scale * now.trough_normal
        out.position[i] = scale * (legs.position[leg] + at.advance + now.path)
        out.velocity[i], out.acceleration[i] = speed * now.velocity, force * acts.acceleration
        out.inertial[i], out.normal[i] = force * acts.inertial, force * acts.normal
        out.friction[i] = 0.0
        if legs.mode[leg] != Mode.FLIGHT:
            out.friction[i] = force * (acts.acceleration - acts.inertial)
        out.static_limit[i] = loads.static_friction * out.normal[i]
        out.gap[i] = scale * now.gap


def phases(legs: Legs, span: Span, row: Integers, start: Doubles, position: Doubles, count: int) -> None:
    """List the first phases of a history: their legs, and where they begin, in time [s] and along it [A].

    After the last phase ``start`` is inf, and the rest is that of the one before.
    """
    for i in range(count):
        start[i] = start_of(legs, span, i)
        known = i if math.isfinite(start[i]) else max(i - 1, 0)
        row[i], position[i] = row_of(span, known), position_of(legs, span, known)


class _Answers(NamedTuple):
    """Results of cells, as ``vibro.SteadyCycle`` has them, one buffer each."""

    regime: Bytes
    pattern_code: Integers
    mean_velocity: Doubles
    displacement_per_cycle: Doubles
    peak_velocity: Doubles
    throw_number: Doubles
    forward_ratio: Doubles
    back_ratio: Doubles
    flight_fraction: Doubles
    impact_velocity: Doubles
    period_cycles: Doubles
    mean_velocity_error: Doubles
    coexists: Bytes
    share: Doubles
    mean_velocity_over_starts: Doubles
    model_code: Bytes
    status: Bytes
    largest_multiplier: Doubles


def solve_contact(
    scenes: Scenes, place: Place, out: _Answers, begin: int, end: int, classes_alone: bool
) -> int:
    """Solve the steady contact cycle of cells; return how many of them hop, which are left unmodelled.

    Buffers that are 0 in contact are expected to be zero.
    """
    hopping = 0
    for i in range(begin, end):
        visit(scenes, place, i, begin)
        point = point_at(scenes, place)
        loads = point.loads
        at = thresholds(loads)
        if loads.waves.kind != SINE:
            cycle = wave_cycle(loads, at, classes_alone)
        else:
            cycle = regime_alone(loads, at) if classes_alone else steady_cycle(loads, at)
        if cycle.status == Status.INFEASIBLE:
            out.throw_number[i], out.forward_ratio[i], out.back_ratio[i] = NAN, NAN, NAN
        else:
            capacity = loads.static_friction * loads.weight_normal
            out.throw_number[i] = loads.drive_normal / loads.weight_normal
            out.forward_ratio[i] = ratio_of(at.forward_load, capacity + loads.weight_tangential)
            out.back_ratio[i] = ratio_of(at.back_load, capacity - loads.weight_tangential)
        displacement = point.scale * cycle.displacement
        out.displacement_per_cycle[i] = displacement
        out.mean_velocity[i] = displacement * point.frequency
        out.peak_velocity[i] = cycle.peak * TURN * point.frequency * point.scale
        out.regime[i], out.status[i], out.model_code[i] = cycle.regime, cycle.status, cycle.model
        out.pattern_code[i], out.coexists[i] = cycle.pattern, cycle.coexists
        out.period_cycles[i] = 1.0
        out.largest_multiplier[i] = cycle.multiplier
        if cycle.regime != Regime.NO_SLIP:
            out.largest_multiplier[i] = proved_multiplier(loads, cycle.multiplier)
        if cycle.model == Model.NONE:
            out.flight_fraction[i], out.impact_velocity[i] = NAN, NAN
            out.period_cycles[i], out.mean_velocity_error[i] = NAN, NAN
        hopping += cycle.status == Status.FLIGHT_NOT_MODELLED
    return hopping


def solve_hops(
    scenes: Scenes, place: Place, out: _Answers, cells: Integers, flights: Flights, hops: Hops, begin: int,
    end: int,
) -> None:  # fmt: skip
    """Follow bodies that hop; ``cells`` are listed, ``flights`` and ``hops`` are scratch memory."""
    for k in range(begin, end):
        i = cells[k]
        seek(scenes, place, i)
        point = point_at(scenes, place)
        found = hopping(point.loads, point.restitution, flights, hops)
        displacement = point.scale * found.displacement
        speed = TURN * point.frequency * point.scale
        out.displacement_per_cycle[i] = displacement
        out.mean_velocity[i] = displacement * point.frequency
        out.mean_velocity_error[i] = point.scale * found.deviation * point.frequency
        out.peak_velocity[i], out.impact_velocity[i] = speed * found.peak, speed * found.impact
        out.flight_fraction[i], out.period_cycles[i] = found.flight_fraction, found.period
        out.status[i], out.coexists[i] = found.status, found.coexists
        out.largest_multiplier[i] = proved_multiplier(point.loads, found.multiplier)
        out.pattern_code[i], out.model_code[i] = 0, Model.NONE
        if found.pattern != 0:
            out.pattern_code[i] = found.pattern + SPELT_PATTERNS if found.pattern > 0 else found.pattern
            out.model_code[i] = Model.FLIGHT


def share_starts(
    scenes: Scenes, place: Place, out: _Answers, cells: Integers, starts: int, flights: Flights, hops: Hops,
    motions: Attractors, room: int, begin: int, end: int,
) -> None:  # fmt: skip
    """Write the share of bodies that move as one from phase 0, the mean of all, and ``coexists`` of hops.

    ``motions`` of ``room`` rows, ``flights`` and ``hops`` are scratch memory.
    """
    for k in range(begin, end):
        i = cells[k]
        point = _point(scenes, place, i)
        if not _is_followed(point.loads):
            continue
        at = thresholds(point.loads)
        here = survey(point.loads, at, point.restitution, starts, 0.0, flights, hops, motions, room)
        alike = here.irregular
        if here.home >= 0:
            alike = motions.starts[here.home]
        out.share[i] = alike / starts
        out.mean_velocity_over_starts[i] = point.scale * point.frequency * here.mean
        if at.hops and out.coexists[i] < 0:
            out.coexists[i] = 1 if here.number + (1 if here.irregular > 0 else 0) > 1 else 0


def write_letters(
    scenes: Scenes, place: Place, cell: int, flights: Flights, hops: Hops, out: Bytes, room: int
) -> int:
    """Write the legs of the steady cycle of a cell that has one; return their number.

    Beyond one harmonic they are counted from wherever the cycle begins, and so turned. ``flights`` and
    ``hops`` are scratch memory.
    """
    seek(scenes, place, cell)
    point = point_at(scenes, place)
    loads = point.loads
    at = thresholds(loads)
    if at.hops:
        number = write_hopping_letters(loads, point.restitution, flights, hops, out, room)
    else:
        number = write_contact_letters(loads, at, out, room)
    return number if loads.waves.kind == SINE or number > room else turn_letters(out, number)


def slips_back(scenes: Scenes, place: Place, out: Bytes, begin: int, end: int) -> None:
    """Tell by Eqs. (5) and (17) alone whether bodies slip back, also where mu_d > mu_s."""
    for i in range(begin, end):
        visit(scenes, place, i, begin)
        point = point_at(scenes, place)
        at = thresholds(point.loads)
        back = at.back
        if at.back and at.forward:
            back = outlasts_back(pair_of(point.loads, at)) < 0
        out[i] = 1 if back else 0


class _Limits(NamedTuple):
    """Critical loads of cells, as ``vibro.CriticalLoads`` describes them."""

    hop: Doubles
    forward_onset: Doubles
    back_onset: Doubles
    back_slip: Doubles
    continuous_sliding: Doubles


def transition_loads(scenes: Scenes, place: Place, out: _Limits, begin: int, end: int) -> None:
    """Find the load G at which each kind of motion begins, over that of the scene beyond one harmonic."""
    for i in range(begin, end):
        visit(scenes, place, i, begin)
        point = unit_point_at(scenes, place)
        waves = point.loads.waves.kind != SINE
        found = wave_limits(point.loads) if waves else critical_loads(point.loads)
        out.hop[i], out.forward_onset[i], out.back_onset[i] = found.hop, found.forward_onset, found.back_onset
        out.back_slip[i], out.continuous_sliding[i] = found.back_slip, found.continuous_sliding


def class_scales(scenes: Scenes, place: Place, out: Doubles, counts: Integers, room: int) -> None:
    """List the scales at which the first cell has each class, as ``write_spans``."""
    seek(scenes, place, 0)
    write_spans(point_at(scenes, place).loads, out, counts, room)


def tipping_loads(
    scenes: Scenes, place: Place, stand_ratio: Doubles, out: Doubles, begin: int, end: int
) -> None:
    """Find the load G up to which no edge of parts lifts; one stand ratio a cell."""
    for i in range(begin, end):
        visit(scenes, place, i, begin)
        point = unit_point_at(scenes, place)
        out[i] = tipping_load(point.loads, stand_ratio[i])


def load_slopes(scenes: Scenes, place: Place, pattern: Integers, out: Doubles, begin: int, end: int) -> None:
    """Differentiate the displacement over A of contact cycles, of known patterns, with respect to ln G."""
    for i in range(begin, end):
        seek(scenes, place, i)
        loads = point_at(scenes, place).loads
        out[i] = load_slope(loads, pattern[i])


class _CycleLegs(NamedTuple):
    """Slides of cells, as ``vibro.slopes.Slides`` describes them.

    Those of the first slide fill the first half of each buffer, those of the second one the other half.
    """

    way: Doubles
    zero: Doubles
    begin: Doubles
    end: Doubles
    load: Doubles
    resistance: Doubles
    displacement: Doubles


def cycle_legs(
    scenes: Scenes, place: Place, pattern: Integers, out: _CycleLegs, begin: int, end: int, half: int
) -> None:
    """Solve the slides of contact cycles of known patterns; the second ones go to ``half`` and on."""
    for i in range(begin, end):
        seek(scenes, place, i)
        loads = point_at(scenes, place).loads
        found = cycle_slides(loads, pattern[i])
        _write_leg(found.first, out, i)
        _write_leg(found.second, out, half + i)


def _write_leg(leg: SlideLeg, out: _CycleLegs, row: int) -> None:
    out.way[row], out.zero[row], out.begin[row], out.end[row] = leg.way, leg.zero, leg.begin, leg.end
    out.load[row], out.resistance[row] = leg.start.onset.load, leg.start.onset.k
    out.displacement[row] = leg.displacement


class _Weights(NamedTuple):
    """What bodies weigh to their drive, as ``vibro.results.operating.Filling`` describes it."""

    added_mass: Doubles
    added_damping: Doubles
    second_real: Doubles
    second_imaginary: Doubles
    mass_error: Doubles
    damping_error: Doubles
    bound: Doubles


def weigh(
    scenes: Scenes, place: Place, pattern: Integers, status: Bytes, out: _Weights, flights: Flights,
    hops: Hops, begin: int, end: int, averages: bool,
) -> None:  # fmt: skip
    """Sum up the force of bodies on the trough, in cells whose patterns and statuses are known.

    ``flights`` and ``hops`` are scratch memory. Means over irregular motion are left NaN unless ``averages``.
    """
    for i in range(begin, end):
        visit(scenes, place, i, begin)
        found, bound = Reaction(NAN, NAN, NAN, NAN, NAN, NAN), NAN
        if status[i] <= Status.BOUNDARY or status[i] == Status.AVERAGED:
            point = point_at(scenes, place)
            bound = force_bound(point.loads)
            if 0 <= pattern[i] < SPELT_PATTERNS:
                found = reaction_in_contact(point.loads, pattern[i])
            elif status[i] != Status.AVERAGED:
                found = reaction_of_hops(point.loads, point.restitution, flights, hops)
            elif averages:
                found = mean_reaction(point.loads, point.restitution, flights, hops)
        out.added_mass[i], out.added_damping[i] = found.added_mass, found.added_damping
        out.second_real[i], out.second_imaginary[i] = found.second_real, found.second_imaginary
        out.mass_error[i], out.damping_error[i] = found.mass_error, found.damping_error
        out.bound[i] = bound


def operate(
    scenes: Scenes, place: Place, springs: Springs, fillings: Fillings, out: Operated, flights: Flights,
    hops: Hops, begin: int, end: int,
) -> None:  # fmt: skip
    """Find the operating point of least amplitude of each cell; the scenes have an amplitude of 1 m."""
    for i in range(begin, end):
        visit(scenes, place, i, begin)
        write_operated(_feeder(scenes, place, springs, fillings, i, flights, hops), out, i)


def operating_points(
    scenes: Scenes, place: Place, springs: Springs, fillings: Fillings, flights: Flights, hops: Hops,
    out: Doubles, room: int,
) -> int:  # fmt: skip
    """List the amplitudes of all operating points of the first cell, as far as there is room."""
    seek(scenes, place, 0)
    return all_amplitudes(_feeder(scenes, place, springs, fillings, 0, flights, hops), out, room)


def _feeder(
    scenes: Scenes, place: Place, springs: Springs, fillings: Fillings, cell: int, flights: Flights,
    hops: Hops,
) -> Feeder:  # fmt: skip
    one = point_at(scenes, place)
    unit = unit_point_at(scenes, place).loads
    share = Complex(fillings.added_mass_share[cell], -fillings.added_damping_share[cell])
    machine = Machine(
        springs, one.frequency, fillings.natural_frequency[cell], fillings.force[cell],
        fillings.filling[cell], share,
    )  # fmt: skip
    return feeder_of(machine, one, unit, flights, hops)


def transfers(
    springs: Springs, frequency: Doubles, natural_frequency: Doubles, real: Doubles, imaginary: Doubles,
    out: Doubles, filled: Doubles, count: int,
) -> None:  # fmt: skip
    """Move a machine by a force of 1 N.

    Parameters
    ----------
    springs : Springs
        The machine.
    frequency, natural_frequency, real, imaginary : Doubles
        Of each case: the drive's, that of the empty machine [Hz], and the mass on the trough [kg].
    out : Doubles
        Is written with both parts of the four numbers of ``Transfer``, case after case.
    filled : Doubles
        Is written with the natural frequencies with that mass [Hz].
    count : int
        Number of cases.
    """
    for i in range(count):
        added = Complex(real[i], imaginary[i])
        found = transfer(springs, frequency[i], natural_frequency[i], added)
        _write_complex(out, 8 * i, found.trough)
        _write_complex(out, 8 * i + 2, found.counter)
        _write_complex(out, 8 * i + 4, found.relative)
        _write_complex(out, 8 * i + 6, found.compliance)
        filled[i] = filled_natural_frequency(springs, natural_frequency[i], added.real)


def _write_complex(out: Doubles, at: int, value: Complex) -> None:
    out[at], out[at + 1] = value.real, value.imaginary


#: What is compiled as functions of the library.
DOORS: Final = (
    arrivals,
    attractors,
    class_scales,
    cover,
    cycle_legs,
    evolve,
    flights_along,
    followed,
    history,
    load_slopes,
    operate,
    operating_points,
    phase_at,
    phases,
    prepare,
    return_of_flights,
    sample,
    share_starts,
    slips_back,
    solve_contact,
    solve_hops,
    steady_legs,
    tipping_loads,
    transfers,
    transition_loads,
    weigh,
    write_letters,
)
