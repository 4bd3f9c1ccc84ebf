"""The steady cycle of hopping scenes: the flights of ``bounces.py`` with the sliding between them.

Friction has no part in the normal motion, so that one unknown is left: the relative velocity at the first
lift-off of the cycle, a fixed point of the return map that ``orbits.py`` finds.
Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Mode, Status, is_answered
from vibro.core.contact.legs import track_of
from vibro.core.flight.bounces import bounces
from vibro.core.flight.orbits import from_rest
from vibro.core.flight.returns import Cells, Hops, hops_of, return_map
from vibro.core.groups import put, take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]
    Codes = NDArray[np.int8]
    Words = NDArray[np.int64]

__all__ = ["MOST_THROW", "HoppingCycles", "hopping_cycles"]

_TURN: Final = 2.0 * np.pi

#: [1] Throw number above which the phase of a landing is lost to rounding.
MOST_THROW: Final = 1e6

_BATCHES: Final = 12  # of flights, for the standard error of a mean


class HoppingCycles(NamedTuple):
    """Steady cycles of hopping scenes, 1-D.

    Attributes
    ----------
    status : int8 array
        ``OK``; ``BOUNDARY`` where kinetic friction just holds gravity; ``AVERAGED`` where no short period
        exists and the numbers are means over many cycles; ``RUNAWAY``, ``INDETERMINATE`` or ``UNRESOLVED``,
        with NaN for numbers.
    pattern : int64 array
        Legs of the cycle, for ``hopping_text``; 0 where there is no cycle.
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
        1 where a disturbed body can settle elsewhere, 0 where it cannot, -1 where that was not looked at:
        mu_d is not below 0.75 mu_s, or there is no cycle.
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


def hopping_cycles(scene: Loads, restitution: Floats) -> HoppingCycles:
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
        One element per scene.

    Notes
    -----
    At K > 1 a body at rest slides forward before it is lifted off, Eq. (34), so that the cycle from rest
    starts with a known velocity, and ends at a fixed point of the return map. Over a cycle the normal
    impulse is that of the weight; where gravity along the trough exceeds static friction under it, every
    cycle adds speed: ``RUNAWAY``.
    """
    n = np.broadcast(*scene, restitution).size
    throw = np.broadcast_to(scene.across / scene.normal, n)
    numbers = np.full((6, n), np.nan)
    out = HoppingCycles._make(
        (np.full(n, Status.OK, np.int8), np.zeros(n, np.int64), *numbers, np.full(n, -1, np.int8))
    )
    mu_s = scene.static_friction
    out.status[throw > MOST_THROW] = Status.UNRESOLVED
    out.status[np.broadcast_to(np.abs(scene.tangential) >= mu_s * scene.normal, n)] = Status.RUNAWAY
    out.status[np.broadcast_to(mu_s == 0.0, n)] = Status.INDETERMINATE
    solved = np.flatnonzero(out.status == Status.OK)
    if solved.size:
        loads = take(scene, solved)
        e = restitution[solved] if restitution.ndim else np.broadcast_to(restitution, solved.size)
        put(out, solved, _solve(loads, throw[solved], e))
    return out


def _solve(scene: Loads, throw: Floats, restitution: Floats) -> HoppingCycles:
    flights = bounces(throw, restitution)
    hops = hops_of(scene, flights)
    cells = Cells(track_of(scene), flights.first, flights.number, flights.landing, flights.rest)
    end, coexists = from_rest(cells, hops, flights)
    cycle, status = end.cycle, end.status
    known = is_answered(status)

    time_aloft = np.bincount(flights.owner, flights.length)
    time = np.where(flights.repeats, _TURN * flights.cycles, time_aloft)
    landings = np.zeros(throw.size)
    np.maximum.at(landings, flights.owner, flights.impact)
    displacement = cycle.displacement / (time / _TURN)
    deviation = np.zeros(throw.size)
    pattern = cycle.pattern.copy()
    sampled = np.flatnonzero(~flights.repeats & known)
    if sampled.size:
        deviation[sampled] = _deviation(take(cells, sampled), hops, end.velocity[sampled])
        status[sampled], pattern[sampled] = Status.AVERAGED, -np.int64(Mode.FLIGHT)
    numbers = (
        displacement,
        deviation,
        np.where(flights.repeats, flights.cycles, np.nan),
        time_aloft / time,
        scene.normal * landings,
        cycle.peak,
    )
    given = [np.where(known, x, np.nan) for x in numbers]
    coexists[~(known & flights.repeats)] = -1
    return HoppingCycles._make((status, np.where(known, pattern, 0), *given, coexists))


def _deviation(cells: Cells, hops: Hops, velocity: Floats) -> Floats:
    """Estimate the standard error of the mean displacement per drive cycle from batches of flights.

    Where the body never stops, it is the longer off by the error of the velocity at the start, the less
    friction there is: that which balances the sums of all batches.
    """
    batch = cells.number // _BATCHES
    paths, times, gains, slopes = np.empty((4, _BATCHES, velocity.size))
    for i in range(_BATCHES):
        part = cells._replace(first=cells.first + i * batch, number=batch)
        leg = return_map(part, hops, velocity)
        velocity, paths[i] = leg.velocity, leg.displacement
        times[i] = [hops.length[a : a + m].sum() for a, m in zip(part.first, batch, strict=True)]
        gains[i], slopes[i] = leg.friction - cells.track.scene.tangential * times[i], leg.slope
    mean = paths.sum(axis=0) / times.sum(axis=0)
    scatter = ((paths - mean * times) ** 2).sum(axis=0) / (_BATCHES * (_BATCHES - 1))
    memory = np.cumprod(slopes, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        outset = np.sqrt(_BATCHES * gains.var(axis=0, ddof=1)) / (1.0 - memory[-1])
    outset = np.where((memory[-1] > 0.0) & (memory[-1] < 1.0), memory.mean(axis=0) * outset, 0.0)
    deviation: Floats = _TURN * np.hypot(np.sqrt(scatter) / times.mean(axis=0), outset)
    return deviation
