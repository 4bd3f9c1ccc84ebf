"""The steady cycle of hopping scenes: the flights of ``bounces.py`` with the sliding between them.

Friction has no part in the normal motion, so that one unknown is left: the relative velocity at the first
lift-off of the cycle, a fixed point of the return map that ``orbits.py`` finds.
Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Status, is_answered
from vibro.core.contact.legs import track_of
from vibro.core.flight.bounces import MOST_FLIGHTS, bounces
from vibro.core.flight.drift import span_of
from vibro.core.flight.orbits import MOST_EVALUATIONS, from_rest
from vibro.core.flight.returns import Cells, hops_of, return_map, velocity_from_rest
from vibro.core.groups import put, take

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.flight.bounces import Bounces
    from vibro.core.groups import Loads

    Codes = NDArray[np.int8]
    Words = NDArray[np.int64]

__all__ = ["MOST_THROW", "HoppingCycles", "cycles", "entered", "one_each", "short_cycles", "unresolved"]

_TURN: Final = 2.0 * np.pi

#: [1] Throw number above which the phase of a landing is lost to rounding.
MOST_THROW: Final = 1e6

# A few cells with many flights cost as many steps as many cells: most cells need no more than this.
_FEW_FLIGHTS: Final = 6
_FEW_EVALUATIONS: Final = 8


class HoppingCycles(NamedTuple):
    """Steady motions of hopping scenes, 1-D.

    Attributes
    ----------
    status : int8 array
        ``OK``; ``BOUNDARY`` where kinetic friction just holds gravity; ``AVERAGED`` where no cycle was found
        before rounding could choose it, and the numbers are means over many cycles; ``RUNAWAY``,
        ``INDETERMINATE`` or ``UNRESOLVED``, with NaN for numbers.
    pattern : int64 array
        Legs of the cycle, for ``spelt_text``; 0 where there are no numbers.
    displacement : array
        Mean displacement per drive cycle [A].
    deviation : array
        Standard error of that mean [A]; 0 where the cycle repeats.
    period : array
        Drive cycles until the motion repeats; NaN where it does not.
    flight_fraction : array
        Share of the time spent off the trough; bounces that accumulate count as flight.
    impact : array
        Largest normal speed of a landing [A w].
    peak : array
        Largest relative speed along the trough, either way [A w].
    coexists : int8 array
        1 where a pushed body may run away; -1 elsewhere, as cycles are not looked for here.
    """

    status: Codes
    pattern: Words
    displacement: Floats
    deviation: Floats
    period: Floats
    flight_fraction: Floats
    impact: Floats
    peak: Floats
    coexists: Codes


def short_cycles(scene: Loads, restitution: Floats) -> HoppingCycles:
    """Steady cycles of few flights; the other scenes are ``UNRESOLVED``. See ``cycles``."""
    return one_each(scene, restitution, partial(_solve, flights=_FEW_FLIGHTS, evaluations=_FEW_EVALUATIONS))


def cycles(scene: Loads, restitution: Floats) -> HoppingCycles:
    """Steady cycles, from rest, of scenes whose throw number exceeds 1.

    Parameters
    ----------
    scene : Loads
        Groups of the scenes, 1-D, or 0-d members for all.
    restitution : array
        Their normal coefficients of restitution, 1-D or 0-d.

    Returns
    -------
    HoppingCycles
        One element per scene; ``UNRESOLVED`` where no cycle was found before rounding could choose it.

    Notes
    -----
    At K > 1 a body at rest slides before it is lifted off, forward where the drive is a line, Eq. (35), so
    that the cycle from rest starts with a known velocity, and ends at a fixed point of the return map. Over a
    cycle the normal impulse is that of the weight; where gravity along the trough exceeds static friction
    under it, every cycle adds speed: ``RUNAWAY``.
    """
    return one_each(scene, restitution, partial(_solve, flights=MOST_FLIGHTS, evaluations=MOST_EVALUATIONS))


def one_each(
    scene: Loads, restitution: Floats, solve: Callable[[Loads, Floats, Floats], HoppingCycles]
) -> HoppingCycles:
    """Solve scenes in which a body can rest, from their groups, throw numbers and restitutions."""
    n = np.broadcast(*scene.flattened(), restitution).size
    throw = np.broadcast_to(scene.across / scene.normal, n)
    out = unresolved(n)
    mu_s = scene.static_friction
    runs = np.abs(scene.tangential) >= mu_s * scene.normal
    out.status[np.broadcast_to(runs, n)] = Status.RUNAWAY
    out.status[np.broadcast_to(mu_s == 0.0, n)] = Status.INDETERMINATE
    solved = np.flatnonzero((out.status == Status.UNRESOLVED) & (throw <= MOST_THROW))
    if solved.size:
        e = restitution[solved] if restitution.ndim else np.broadcast_to(restitution, solved.size)
        put(out, solved, solve(take(scene, solved), throw[solved], e))
    if np.count_nonzero(scene.tangential):
        # Where gravity along the trough exceeds kinetic friction a pushed body may slide on for ever.
        loose = np.abs(scene.tangential) > scene.kinetic_friction * scene.normal
        out.coexists[loose & is_answered(out.status)] = 1
    return out


def unresolved(scenes: int) -> HoppingCycles:
    """Make results to be filled."""
    status, pattern = np.full(scenes, Status.UNRESOLVED, np.int8), np.zeros(scenes, np.int64)
    return HoppingCycles._make((status, pattern, *np.full((6, scenes), np.nan), np.full(scenes, -1, np.int8)))


def _solve(scene: Loads, throw: Floats, restitution: Floats, flights: int, evaluations: int) -> HoppingCycles:
    motion = bounces(throw, restitution, flights)
    out = unresolved(throw.size)
    found = np.flatnonzero(motion.repeats)
    if not found.size:
        return out
    cells, start = take(entered(scene, motion), found)
    hops, turns = hops_of(scene, motion.cycle), np.multiply(_TURN, motion.cycles[found])
    end = from_rest(cells, hops, start, span_of(cells, turns), evaluations)
    aloft = np.bincount(motion.cycle.owner, motion.cycle.length, throw.size)
    landings = np.zeros(throw.size)
    np.maximum.at(landings, motion.cycle.owner, motion.cycle.impact)
    numbers = (
        end.cycle.displacement / motion.cycles[found],
        np.zeros(found.size),
        motion.cycles[found],
        aloft[found] / turns,
        (scene.normal * landings)[found],
        end.cycle.peak,
    )
    known = is_answered(end.status)
    given = [np.where(known, x, np.nan) for x in numbers]
    looked_at = np.full(found.size, -1, np.int8)
    put(out, found, (end.status, np.where(known, end.cycle.pattern, 0), *given, looked_at))
    return out


def entered(scene: Loads, motion: Bounces) -> tuple[Cells, Floats]:
    """Scenes with the flights of their cycles, and the velocities with which bodies from rest enter them."""
    flights = motion.cycle
    cells = Cells(track_of(scene), flights.first, flights.number, motion.landing, motion.rest)
    start = np.broadcast_to(velocity_from_rest(cells.track), flights.first.shape)
    amid = np.flatnonzero(motion.repeats & (motion.rest == 0.0))
    if amid.size:
        start = start.copy()
        lead = motion.approach
        none = np.zeros(amid.size)
        way = Cells(take(cells.track, amid), lead.first[amid], lead.number[amid], none, none)
        start[amid] = return_map(way, hops_of(scene, lead), start[amid]).velocity
        # the cycle begins at another phase than the approach ends: the velocity over the ground is the same
        ends = np.broadcast_to(cells.track.lift_off, start.shape)[amid]
        flown = np.flatnonzero(way.number > 0)
        ends[flown] = lead.phase[(way.first + way.number)[flown]]
        trough = way.track.scene
        begins = flights.phase[flights.first[amid]]
        start[amid] += trough.along * (trough.along_cosine(ends) - trough.along_cosine(begins))
    return cells, start
