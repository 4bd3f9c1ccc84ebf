"""All cycles in which bodies were found to settle: those that coexist on one trough.

In contact they are the fixed points of the return map of one turn, Eq. (36). Of bodies that hop they are
those along the flights from rest, and along the flights to which the starts of ``coexisting`` lead.
Lengths in A, speeds in A w, normal speeds over n = cos(beta)/G [A w n], phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.bounces import Bounces, Flights, bounces, normal_multiplier, rests_as_from_rest, single_bounce
from vibro.core.cells import Event, behind
from vibro.core.codes import Mode, Status
from vibro.core.contact import without_cycle
from vibro.core.drive import Loads, phase_difference, proved_multiplier
from vibro.core.flight import Bed, bed_of, lift_offs
from vibro.core.hops import cycle_of, enter, entered
from vibro.core.legs import next_onset, track_of
from vibro.core.numbers import INF, MOST_THROW, NAN, PI, QUARTER, TURN, Doubles, Integers, wrap
from vibro.core.return_map import (
    HoppingCycle,
    Hops,
    Orbit,
    between,
    cycle_from,
    differ,
    has_stop,
    hopping_cycle,
    no_hops,
    orbit_from,
    others_on,
    return_map,
    stopping,
    stops_of,
)
from vibro.core.slides import Thresholds
from vibro.core.waves import NORMAL, nodes_of

# ------------------------------------------------------------------------------
# Other motions of a body that hops than the one from rest: where a disturbed body can settle.
#
# Two kinds: it slides otherwise between the same flights, or it flies otherwise. Lengths in A, speeds in A w,
# phases in radians.

_OTHER: Final = 1e-6  # [A w n] difference of the largest landing speeds of two cycles of flights

# Starts from which other flights are looked for: on the cycles of one bounce each that lasts up to so many
# turns, and on a grid of phases and speeds.
_LONGEST: Final = 16
_PHASES: Final = 8
_SPEEDS: Final = 6
_MOST_FLIGHTS: Final = 64


def coexisting(
    loads: Loads, restitution: float, period: float, impact: float, flights: Flights, hops: Hops
) -> bool:
    """Return whether other motions than that from rest were found.

    Parameters
    ----------
    loads : Loads
        Groups of a scene that hops.
    restitution : float
        e.
    period, impact : float
        Drive cycles of the motion from rest, NaN where it does not repeat, and its largest landing speed
        [A w].
    flights, hops : Flights, Hops
        Scratch memory.

    Returns
    -------
    bool
        True where other relative velocities repeat with the same flights (all of them are found), or where
        other flights repeat, of those that 64 starts lead to within 64 flights.
    """
    if not math.isnan(period) and _slides_otherwise(loads, restitution, flights, hops):
        return True
    track_of(loads, restitution)  # the zeros of the normal load
    return _flies_otherwise(bed_of(loads), restitution, period, impact / loads.weight_normal, flights)


def _flies_otherwise(bed: Bed, restitution: float, period: float, impact: float, flights: Flights) -> bool:
    """Return whether other flights repeat than those from rest, whose largest landing speed is ``impact``."""
    most = 0
    for i in range(_number_of_starts(bed)):
        start = _start_at(bed, restitution, i, most)
        most += 1 if start.bounces else 0
        leaves = not math.isnan(start.phase)
        if leaves and _leads_elsewhere(bed, restitution, start.phase, start.speed, period, impact, flights):
            return True
    return False


class _SearchStart(NamedTuple):
    """A take-off from which other flights are looked for.

    Attributes
    ----------
    phase, speed : float
        Of the take-off [rad, A w n]; NaN where there is none.
    bounces : bool
        Whether it is on a cycle of one bounce.
    """

    phase: float
    speed: float
    bounces: bool


def _number_of_starts(bed: Bed) -> int:
    """Return how many starts there are: the lift-offs, those of one bounce, and a grid of the others."""
    return lift_offs(bed) + _LONGEST + _PHASES * _SPEEDS


def _start_at(bed: Bed, restitution: float, index: int, most: int) -> _SearchStart:
    """Return one of the starts; ``most`` is how many before it are on cycles of one bounce."""
    i = index
    if i < lift_offs(bed):  # bodies that rest until another lift-off
        lifts = behind(bed.waves, NORMAL, i)
        return _SearchStart(bed.waves.number[nodes_of(bed.waves, NORMAL) + i] if lifts else NAN, 0.0, False)
    i -= lift_offs(bed)
    if i < _LONGEST:
        bounce = single_bounce(bed, restitution, i + 1, 0)
        # where there is no such bounce a start from the crest, with its speed, is as good as any
        speed = TURN * (i + 1) * restitution / (1.0 + restitution)
        return _SearchStart(bounce.phase if bounce.exists else QUARTER, speed, bounce.exists)
    i -= _LONGEST
    speed = (float(i // _PHASES) + 0.5) / _SPEEDS * (max(most, 1) + 0.5) * PI
    return _SearchStart(TURN * (i % _PHASES) / _PHASES, speed, False)


def _leads_elsewhere(
    bed: Bed,
    restitution: float,
    phase: float,
    speed: float,
    period: float,
    impact: float,
    flights: Flights,
) -> bool:
    """Return whether a take-off leads to flights that repeat and are not those from rest."""
    motion = bounces(bed, restitution, flights, _MOST_FLIGHTS, phase, speed, False)
    if not motion.repeats or rests_as_from_rest(bed, motion):
        return False  # a contact leads to the motion from rest, where there is one lift-off
    largest = 0.0
    for row in range(motion.first, motion.first + motion.count):
        largest = max(largest, flights.impact[row])
    return motion.cycles != period or abs(largest - impact) > _OTHER * (1.0 + largest)


def _slides_otherwise(loads: Loads, restitution: float, flights: Flights, hops: Hops) -> bool:
    """Return whether other velocities repeat with the flights from rest."""
    track = track_of(loads, restitution)
    entry = enter(track, restitution, flights, hops)
    motion = entry.motion
    if not motion.repeats:
        return False
    cycle = cycle_of(track, motion)
    home = orbit_from(cycle, hops, entry.velocity)
    return others_on(cycle, hops, entry.velocity, home)


class Attractors(NamedTuple):
    """Buffers of the cycles found, one a row.

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
        The largest landing speed, and the sum of all: they tell cycles of flights apart [A w n].
    flights : Doubles
        Their number.
    pattern : Integers
        Legs, as ``Return`` has them.
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
    pattern: Integers


class _Survey(NamedTuple):
    """What a search has found.

    Attributes
    ----------
    number : int
        Cycles: rows written.
    from_rest : bool
        Whether the first of them is that of a body from rest.
    starts, lost : int
        Starts that were followed, that from rest included, and those of them whose flights did not repeat.
    runs_away : bool
        Whether a body that is pushed hard enough down the trough never stops.
    """

    number: int
    from_rest: bool
    starts: int
    lost: int
    runs_away: bool


def list_attractors(
    loads: Loads, at: Thresholds, restitution: float, flights: Flights, hops: Hops, out: Attractors, room: int
) -> _Survey:
    """List the cycles of a scene, the one from rest first; ``flights`` and ``hops`` are scratch memory."""
    n, t = loads.weight_normal, abs(loads.weight_tangential)
    away = t > loads.kinetic_friction * n
    if not at.hops:
        if without_cycle(loads, at).status != Status.OK:
            return _Survey(0, False, 1, 0, away)
        return _in_contact(loads, at, out, room, away)
    held = loads.kinetic_friction <= loads.static_friction and t < loads.static_friction * n
    if loads.static_friction == 0.0 or not held or loads.drive_normal > MOST_THROW * n:
        return _Survey(0, False, 1, 0, away)
    track, bed = track_of(loads, restitution), bed_of(loads)
    entry = enter(track, restitution, flights, hops)
    number, most, starts, lost = 0, 0, 1, 0
    if entry.motion.repeats:
        cycle = cycle_of(track, entry.motion)
        normal = normal_multiplier(bed, restitution, flights, entry.motion)
        home = orbit_from(cycle, hops, entry.velocity)
        number = _along(cycle, entry.motion, entry.velocity, home, normal, flights, hops, out, 0, room)
        from_rest = home.status <= Status.BOUNDARY
    else:
        from_rest = False
        lost = 1
    for i in range(_number_of_starts(bed)):
        start = _start_at(bed, restitution, i, most)
        most += 1 if start.bounces else 0
        if math.isnan(start.phase):
            continue
        starts += 1
        motion = bounces(bed, restitution, flights, _MOST_FLIGHTS, start.phase, start.speed, False)
        if not motion.repeats:
            lost += 1
            continue
        if rests_as_from_rest(bed, motion):
            lost += 0 if entry.motion.repeats else 1
            continue  # there is one lift-off: a contact leads to the flights from rest
        if _is_listed(motion, flights, out, number):
            continue
        mine = entered(track, motion, 0.0, flights, hops)
        cycle = cycle_of(track, motion)
        normal = normal_multiplier(bed, restitution, flights, motion)
        home = orbit_from(cycle, hops, mine.velocity)
        number = _along(cycle, motion, mine.velocity, home, normal, flights, hops, out, number, room)
    return _Survey(number, from_rest, starts, lost, away)


def _is_listed(motion: Bounces, flights: Flights, out: Attractors, number: int) -> bool:
    """Return whether flights are those of a row: of one period, with the same landing speeds."""
    largest, total = _impacts(motion, flights)
    for row in range(number):
        near = _OTHER * (1.0 + total)
        same = abs(largest - out.impact[row]) <= near and abs(total - out.impacts[row]) <= near
        if same and out.period[row] == motion.cycles:
            return True
    return False


def _impacts(motion: Bounces, flights: Flights) -> tuple[float, float]:
    largest, total = 0.0, 0.0
    for row in range(motion.first, motion.first + motion.count):
        largest, total = max(largest, flights.impact[row]), total + flights.impact[row]
    return largest, total


def _along(
    cycle: HoppingCycle, motion: Bounces, start: float, home: Orbit, normal: float, flights: Flights,
    hops: Hops, out: Attractors, number: int, room: int,
) -> int:  # fmt: skip
    """Write all cycles along the same flights, or in contact; return the number of rows then.

    ``home`` is the one to which a body leads that enters with the velocity ``start``.
    """
    begun = number
    if home.status <= Status.BOUNDARY:
        number = _write(cycle, motion, home, normal, flights, hops, out, number, room)
        if cycle.neutral and not has_stop(home.cycle):
            return number  # every other velocity repeats too
    begin = cycle_from(cycle, hops, start)
    low, high, slides = cycle.bound, -cycle.bound, home.status <= Status.BOUNDARY and not has_stop(home.cycle)
    if home.status <= Status.BOUNDARY:
        low, high = min(low, home.velocity), max(high, home.velocity)
    for index in range(stops_of(cycle)):
        found = stopping(cycle, hops, start, begin, 0.0, index)
        if found.status == Status.OK:
            low, high = min(low, found.velocity), max(high, found.velocity)
            if not _is_known(cycle, found, hops, out, begun, number, motion):
                number = _write(cycle, motion, found, normal, flights, hops, out, number, room)
    for side in range(2):
        if slides or not cycle.bounded:
            continue
        bound, near = (-cycle.bound, low) if side == 0 else (cycle.bound, high)
        found = between(cycle, hops, bound, near)
        if found.status == Status.OK and not _is_known(cycle, found, hops, out, begun, number, motion):
            number = _write(cycle, motion, found, normal, flights, hops, out, number, room)
    return number


def _begin(cycle: HoppingCycle, hops: Hops, velocity: float) -> float:
    """Return the velocity where a row's cycle begins: at the landing before its contact, if it has one."""
    if cycle.rest > 0.0 and cycle.last > cycle.first:
        return return_map(cycle.track, hops, cycle.first, cycle.last, 0.0, 0.0, velocity).velocity
    return velocity


def _is_known(
    cycle: HoppingCycle, found: Orbit, hops: Hops, out: Attractors, begun: int, number: int, motion: Bounces
) -> bool:
    """Return whether a fixed point is one of the rows from ``begun`` on, which have the same flights."""
    velocity = _begin(cycle, hops, found.velocity)
    for row in range(begun, number):
        displacement = found.cycle.displacement / motion.cycles
        beside = Orbit(out.velocity[row], found.cycle, found.status)
        same = abs(out.displacement[row] - displacement) <= _OTHER
        if same and not differ(cycle, found._replace(velocity=velocity), beside):
            return True
    return False


def _write(
    cycle: HoppingCycle, motion: Bounces, found: Orbit, normal: float, flights: Flights, hops: Hops,
    out: Attractors, row: int, room: int,
) -> int:  # fmt: skip
    """Write a row, if there is room; return the number of rows then."""
    if row == room:
        return row
    phase, rate = cycle.landing, 0.0
    if cycle.last > cycle.first and cycle.rest == 0.0:
        phase, rate = flights.phase[motion.first], flights.speed[motion.first]
    out.phase[row] = wrap(phase - phase_difference(cycle.track.loads))
    out.rate[row] = rate
    out.velocity[row] = _begin(cycle, hops, found.velocity)
    out.displacement[row] = found.cycle.displacement / motion.cycles
    out.period[row] = motion.cycles
    out.multiplier[row] = proved_multiplier(cycle.track.loads, max(found.cycle.slope, normal))
    largest, total = _impacts(motion, flights)
    out.impact[row], out.impacts[row], out.flights[row] = largest, total, motion.count
    out.pattern[row] = found.cycle.pattern
    return row + 1


def _in_contact(loads: Loads, at: Thresholds, out: Attractors, room: int, away: bool) -> _Survey:
    """List the cycles of one turn without flights."""
    track, hops, start = track_of(loads, 0.0), no_hops(), phase_difference(loads)
    none = Bounces(True, 0, 0, 0, 1, 0.0, 0.0, 0.0)
    if not (at.forward or at.back):
        out.phase[0], out.rate[0], out.velocity[0], out.displacement[0] = 0.0, 0.0, 0.0, 0.0
        out.period[0], out.multiplier[0], out.impact[0], out.impacts[0] = 1.0, 0.0, 0.0, 0.0
        out.flights[0] = 0.0
        out.pattern[0] = Mode.REST
        return _Survey(1, True, 1, 0, away)
    ahead, behind = next_onset(track, 1.0, start), next_onset(track, -1.0, start)
    onset = ahead if loads.line or ahead.wait <= behind.wait else behind
    if not onset.wait < INF:
        onset = behind if behind.wait < INF else Event(start, 0.0)  # rounding hides it, and the body rests
    cycle = hopping_cycle(track, 0, 0, onset.phase, TURN, TURN)
    velocity = return_map(track, hops, 0, 0, start, onset.wait, 0.0).velocity
    home = orbit_from(cycle, hops, velocity)
    number = _along(cycle, none, velocity, home, 0.0, _no_flights(hops), hops, out, 0, room)
    return _Survey(number, home.status <= Status.BOUNDARY, 1, 0, away)


def _no_flights(hops: Hops) -> Flights:
    none = hops.gain
    return Flights(none, none, none, none, none, none, none, none)
