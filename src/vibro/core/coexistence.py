"""Other motions of a body that hops than the one from rest: where a disturbed body can settle.

Two kinds: it slides otherwise between the same flights, or it flies otherwise.
Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.bounces import Flights, bounces, single_bounce
from vibro.core.cells import behind, number_of_nodes
from vibro.core.drives import Loads
from vibro.core.elementary import NAN, PI, QUARTER, TURN
from vibro.core.flight import Bed, bed_of
from vibro.core.hopping import enter
from vibro.core.legs import track_of
from vibro.core.orbits import hopping_cycle, orbit_from, others_on
from vibro.core.return_map import Hops
from vibro.core.waves import NORMAL, SINE, nodes_of

__all__ = ["OTHER", "SearchStart", "coexisting", "most_flights", "number_of_starts", "start_at"]

OTHER: Final = 1e-6  # [A w n] difference of the largest landing speeds of two cycles of flights

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
    for i in range(number_of_starts(bed)):
        start = start_at(bed, restitution, i, most)
        most += 1 if start.bounces else 0
        leaves = not math.isnan(start.phase)
        if leaves and _leads_elsewhere(bed, restitution, start.phase, start.speed, period, impact, flights):
            return True
    return False


class SearchStart(NamedTuple):
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


def number_of_starts(bed: Bed) -> int:
    """Return how many starts there are: the lift-offs, those of one bounce, and a grid of the others."""
    lift_offs = number_of_nodes(bed.waves, NORMAL) if bed.waves.kind != SINE else 0
    return lift_offs + _LONGEST + _PHASES * _SPEEDS


def start_at(bed: Bed, restitution: float, index: int, most: int) -> SearchStart:
    """Return one of the starts; ``most`` is how many before it are on cycles of one bounce."""
    i = index
    if bed.waves.kind != SINE:
        lift_offs = number_of_nodes(bed.waves, NORMAL)
        if i < lift_offs:  # bodies that rest until another lift-off
            lifts = behind(bed.waves, NORMAL, i)
            return SearchStart(
                bed.waves.number[nodes_of(bed.waves, NORMAL) + i] if lifts else NAN, 0.0, False
            )
        i -= lift_offs
    if i < _LONGEST:
        bounce = single_bounce(bed, restitution, i + 1, 0)
        # where there is no such bounce a start from the crest, with its speed, is as good as any
        speed = TURN * (i + 1) * restitution / (1.0 + restitution)
        return SearchStart(bounce.phase if bounce.exists else QUARTER, speed, bounce.exists)
    i -= _LONGEST
    speed = (float(i // _PHASES) + 0.5) / _SPEEDS * (max(most, 1) + 0.5) * PI
    return SearchStart(TURN * (i % _PHASES) / _PHASES, speed, False)


def most_flights() -> int:
    """Return after how many flights from a start the search ends."""
    return _MOST_FLIGHTS


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
    if not motion.repeats or (motion.rest > 0.0 and bed.waves.kind == SINE):
        return False  # a contact leads to the motion from rest, where there is one lift-off
    largest = 0.0
    for row in range(motion.first, motion.first + motion.count):
        largest = max(largest, flights.impact[row])
    return motion.cycles != period or abs(largest - impact) > OTHER * (1.0 + largest)


def _slides_otherwise(loads: Loads, restitution: float, flights: Flights, hops: Hops) -> bool:
    """Return whether other velocities repeat with the flights from rest."""
    track = track_of(loads, restitution)
    entry = enter(track, restitution, flights, hops)
    motion = entry.motion
    if not motion.repeats:
        return False
    last, duration = motion.first + motion.count, TURN * motion.cycles
    cycle = hopping_cycle(track, motion.first, last, motion.landing, motion.rest, duration)
    home = orbit_from(cycle, hops, entry.velocity)
    return others_on(cycle, hops, entry.velocity, home)
