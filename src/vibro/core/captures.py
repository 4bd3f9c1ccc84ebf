"""Stable cycles that capture a body after long irregular motion, for ``averages.py``.

Chaos may be a transient: a mean over its first flights is not that of the cycle in which the body ends.
So bodies are followed on, along the normal motion alone, until their flights repeat.
Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from vibro.core.bounces import Bounces, Flights, bounces
from vibro.core.codes import Status
from vibro.core.elementary import TURN
from vibro.core.flight import Bed, bed_of
from vibro.core.legs import Track
from vibro.core.orbits import hopping_cycle, orbit_from
from vibro.core.return_map import Hops, write_hops
from vibro.core.samples import kick
from vibro.core.waves import SINE

__all__ = ["Captures", "captures"]

_BODIES: Final = 8  # followed of each scene
_FLIGHTS: Final = 512  # flights of each body, short bounces not counted


class Captures(NamedTuple):
    """Cycles in which bodies have ended.

    Attributes
    ----------
    number : int
        Bodies that were captured.
    displacement, squares : float
        Sum of what their mean displacements per drive cycle differ from that of irregular motion, and sum of
        the squares [A, A^2].
    aloft : float
        Sum of their flight fractions.
    impact, peak : float
        Largest normal speed of a landing, and largest relative speed along the trough [A w].
    """

    number: int
    displacement: float
    squares: float
    aloft: float
    impact: float
    peak: float


def captures(
    track: Track, restitution: float, irregular: float, start: float, flights: Flights, hops: Hops
) -> Captures:
    """Follow the bodies of a scene until cycles capture them.

    Parameters
    ----------
    track : Track
        Scene.
    restitution : float
        e.
    irregular : float
        Mean displacement per drive cycle of irregular motion [A].
    start : float
        Velocity along the trough with which the cycles are entered [A w].
    flights, hops : Flights, Hops
        Scratch memory.
    """
    loads, bed = track.loads, bed_of(track.loads)
    number, total, squares, aloft, impact, peak = 0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(_BODIES):
        motion = _followed(bed, restitution, i, flights)
        if not motion.repeats:
            continue
        last, turns = motion.first + motion.count, float(motion.cycles)
        write_hops(loads, flights, hops, motion.first, last)
        hops.rest[last - 1] = 0.0  # it is that of the cycle's end
        cycle = hopping_cycle(track, motion.first, last, motion.landing, motion.rest, TURN * turns)
        orbit = orbit_from(cycle, hops, start)
        if orbit.status > Status.BOUNDARY:
            continue
        number += 1
        off = orbit.cycle.displacement / turns - irregular
        total, squares, peak = total + off, squares + off * off, max(peak, orbit.cycle.peak)
        for row in range(motion.first, last):
            aloft += flights.length[row] / (TURN * turns)
            impact = max(impact, loads.weight_normal * flights.impact[row])
    return Captures(number, total, squares, aloft, impact, peak)


def _followed(bed: Bed, restitution: float, body: int, flights: Flights) -> Bounces:
    """Follow a body, kicked whenever it leaves the trough, until its flights repeat.

    A contact of a trough with one lift-off closes no cycle here: that from rest was looked for before.
    """
    left, phase, speed = _FLIGHTS, bed.lift_off, kick(body, 0)
    motion = Bounces(False, 0, 0, 0, 0, 0.0, 0.0, phase)
    for _ in range(_FLIGHTS):  # each search takes one at least
        motion = bounces(bed, restitution, flights, left, phase, speed, False)
        if motion.repeats and not (motion.rest > 0.0 and bed.waves.kind == SINE):
            return motion
        flown = motion.approach + motion.count
        left -= flown
        if flown == 0 or left <= 0:
            break
        phase, speed = motion.approach_end, kick(body + left, 0)
    return motion._replace(repeats=False)
