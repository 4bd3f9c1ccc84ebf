"""The solver's doors: loops over scenes, from buffers into buffers.

Compiled they hold no lock, so that threads may run them side by side; each cell's numbers depend on its scene
alone, whatever range it is solved in. Results are in SI units.
"""

from __future__ import annotations

from typing import NamedTuple

from vibro.core.bounces import Flights
from vibro.core.branches import cover
from vibro.core.buffers import Bytes, Doubles, Integers
from vibro.core.codes import SPELT_PATTERNS, Model, Regime, Status
from vibro.core.coexistence import coexisting
from vibro.core.contact import outlasts_back, pair_of, ratio_of, regime_alone, steady_cycle
from vibro.core.cycle_slides import SlideLeg, cycle_slides
from vibro.core.derivatives import Change, displacement_rate, load_slope
from vibro.core.drives import proved_multiplier
from vibro.core.elementary import NAN, TURN
from vibro.core.evolution import evolve
from vibro.core.filling import Reaction, force_bound, mean_reaction, reaction_in_contact, reaction_of_hops
from vibro.core.hopping import hopping, write_hopping_letters
from vibro.core.limits import critical_loads, tipping_load
from vibro.core.motions import (
    arrivals,
    attractors,
    flights_along,
    followed,
    history,
    moments,
    return_of_flights,
)
from vibro.core.return_map import Hops
from vibro.core.scales import wave_limits, write_spans
from vibro.core.scenes import Place, Scenes, point_at, prepare, seek, unit_point_at, visit
from vibro.core.wave_cycle import wave_cycle, write_contact_letters
from vibro.core.waves import SINE
from vibro.core.windows import thresholds

__all__ = [
    "arrivals", "attractors", "class_scales", "cover", "cycle_legs", "displacement_gradients", "evolve",
    "find_others", "flights_along", "followed", "history", "load_slopes", "moments", "prepare",
    "return_of_flights", "slips_back", "solve_contact", "solve_hops", "tipping_loads", "transition_loads",
    "weigh", "write_letters",
]  # fmt: skip


class Answers(NamedTuple):
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
    model_code: Bytes
    status: Bytes
    largest_multiplier: Doubles


def solve_contact(
    scenes: Scenes, place: Place, out: Answers, begin: int, end: int, classes_alone: bool
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
    scenes: Scenes, place: Place, out: Answers, cells: Integers, flights: Flights, hops: Hops, begin: int,
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


def find_others(
    scenes: Scenes, place: Place, out: Answers, cells: Integers, flights: Flights, hops: Hops, begin: int,
    end: int,
) -> None:  # fmt: skip
    """Look whether other motions coexist with those that ``solve_hops`` has found."""
    for k in range(begin, end):
        i = cells[k]
        seek(scenes, place, i)
        point = point_at(scenes, place)
        impact = out.impact_velocity[i] / (TURN * point.frequency * point.scale)
        others = coexisting(point.loads, point.restitution, out.period_cycles[i], impact, flights, hops)
        out.coexists[i] = 1 if others else 0


def write_letters(
    scenes: Scenes, place: Place, cell: int, flights: Flights, hops: Hops, out: Bytes, room: int
) -> int:
    """Write the legs of the steady cycle of a cell that has one, as ``spell``; return their number.

    ``flights`` and ``hops`` are scratch memory.
    """
    seek(scenes, place, cell)
    point = point_at(scenes, place)
    at = thresholds(point.loads)
    if at.hops:
        return write_hopping_letters(point.loads, point.restitution, flights, hops, out, room)
    return write_contact_letters(point.loads, at, out, room)


def slips_back(scenes: Scenes, place: Place, out: Bytes, begin: int, end: int) -> None:
    """Tell by Eqs. (5) and (17) alone whether bodies slip back, also where mu_d > mu_s."""
    for i in range(begin, end):
        visit(scenes, place, i, begin)
        point = point_at(scenes, place)
        at = thresholds(point.loads)
        back = at.back
        if at.back and at.forward:
            back = outlasts_back(point.loads, pair_of(point.loads, at)) < 0
        out[i] = 1 if back else 0


class Limits(NamedTuple):
    """Critical loads of cells, as ``vibro.CriticalLoads`` describes them."""

    hop: Doubles
    forward_onset: Doubles
    back_onset: Doubles
    back_slip: Doubles
    continuous_sliding: Doubles


def transition_loads(scenes: Scenes, place: Place, out: Limits, begin: int, end: int) -> None:
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


class Gradients(NamedTuple):
    """Derivatives of the displacements of cells, as ``vibro.slopes.Gradient`` describes them."""

    log_load: Doubles
    drive_angle: Doubles
    static_friction: Doubles
    kinetic_friction: Doubles
    trough_angle: Doubles


def displacement_gradients(
    scenes: Scenes, place: Place, pattern: Integers, out: Gradients, begin: int, end: int
) -> None:
    """Differentiate the displacement over A of lines' contact cycles with respect to each input."""
    for i in range(begin, end):
        seek(scenes, place, i)
        loads = point_at(scenes, place).loads
        a, b = loads.drive_tangential, loads.drive_normal
        n, t = loads.weight_normal, loads.weight_tangential
        out.log_load[i] = load_slope(loads, pattern[i])
        turned = Change(-b, a, 0.0, 0.0, 0.0, 0.0, 0.0)
        out.drive_angle[i] = displacement_rate(loads, pattern[i], turned)
        tilted = Change(0.0, 0.0, -t, n, 0.0, 0.0, 0.0)
        out.trough_angle[i] = displacement_rate(loads, pattern[i], tilted)
        static = Change(0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
        out.static_friction[i] = displacement_rate(loads, pattern[i], static)
        kinetic = Change(0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
        out.kinetic_friction[i] = displacement_rate(loads, pattern[i], kinetic)


class CycleLegs(NamedTuple):
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
    scenes: Scenes, place: Place, pattern: Integers, out: CycleLegs, begin: int, end: int, half: int
) -> None:
    """Solve the slides of contact cycles of known patterns; the second ones go to ``half`` and on."""
    for i in range(begin, end):
        seek(scenes, place, i)
        loads = point_at(scenes, place).loads
        found = cycle_slides(loads, pattern[i])
        _write_leg(found.first, out, i)
        _write_leg(found.second, out, half + i)


def _write_leg(leg: SlideLeg, out: CycleLegs, row: int) -> None:
    out.way[row], out.zero[row], out.begin[row], out.end[row] = leg.way, leg.zero, leg.begin, leg.end
    out.load[row], out.resistance[row] = leg.start.onset.load, leg.start.onset.k
    out.displacement[row] = leg.displacement


class Weights(NamedTuple):
    """What bodies weigh to their drive, as ``vibro.results.filling.Filling`` describes it."""

    added_mass: Doubles
    added_damping: Doubles
    second_real: Doubles
    second_imaginary: Doubles
    mass_error: Doubles
    damping_error: Doubles
    bound: Doubles


def weigh(
    scenes: Scenes, place: Place, pattern: Integers, status: Bytes, out: Weights, flights: Flights,
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
