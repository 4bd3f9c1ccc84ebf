"""The steady cycle of hopping scenes: the flights of ``bounce.py`` with the sliding between them.

Friction has no part in the normal motion, so that one unknown is left: the relative velocity at the first
lift-off of the cycle, a fixed point of the return map of ``returns.py``. That map never decreases, so that
its orbits are monotone; its slope is at most 1 and it jumps upwards only, so that a piece of it has one
fixed point at most, and a step that stays in its piece passes none unseen.
Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.bounce import bounces
from vibro.core.codes import Status
from vibro.core.groups import put, take
from vibro.core.motion import Mode, track_of
from vibro.core.returns import Cells, Hops, Return, follow, hops_of, pattern_text, velocity_from_rest

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.groups import Loads
    from vibro.core.slide import Floats

    Bools = NDArray[np.bool_]
    Codes = NDArray[np.int8]
    Words = NDArray[np.int64]

__all__ = ["HoppingCycles", "hopping_cycles", "pattern_text"]

_TURN: Final = 2.0 * np.pi

#: [1] Throw number above which the phase of a landing is lost to rounding.
MOST_THROW: Final = 1e6

_MOST_EVALUATIONS: Final = 200
_FLOOR: Final = 16 * 2.0**-52  # [1] rounding of one evaluation, relative to the velocities in it
_CLOSED: Final = 1e-13  # [A w] distance from the fixed point at which the cycle is closed
_SHY: Final = 8.0  # [1] factor by which the longest step shrinks where one left its piece, or grows

# [1] Coexisting cycles need mu_d well below mu_s; none was found above (benchmarks/hopping.py).
_MOST_COEXISTENCE: Final = 0.75

_BATCHES: Final = 12  # of flights, for the standard error of a mean
_APART: Final = 1e-9  # [A w] fixed points closer than this are one


class HoppingCycles(NamedTuple):
    """Steady cycles of hopping scenes, 1-D.

    Attributes
    ----------
    status : int8 array
        ``OK``; ``AVERAGED`` where no short period exists and the numbers are means over many cycles;
        ``RUNAWAY``, ``INDETERMINATE`` or ``UNRESOLVED``, with NaN for numbers.
    pattern : int64 array
        Phases of the cycle, for ``pattern_text``; 0 where there is no cycle.
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
    coexists : bool array
        Whether a disturbed body can settle elsewhere; looked at where mu_d < 0.75 mu_s.
    """

    status: Codes
    pattern: Words
    displacement: Floats
    deviation: Floats
    period: Floats
    flight_fraction: Floats
    impact: Floats
    peak: Floats
    coexists: Bools


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
        One entry a scene.

    Notes
    -----
    At K > 1 a body at rest slides forward before it is lifted off, Eq. (34), so that the cycle from rest
    starts with a known velocity. Newton's iteration on the return map then stands for hundreds of cycles;
    a step that leaves its piece of the map is shortened down to the plain walk. Over a cycle the normal
    impulse is that of the weight; where gravity along the trough exceeds static friction under it, every
    cycle adds speed: ``RUNAWAY``.
    """
    n = np.broadcast(*scene, restitution).size
    throw = np.broadcast_to(scene.across / scene.normal, n)
    numbers = np.full((6, n), np.nan)
    out = HoppingCycles._make(
        (np.full(n, Status.OK, np.int8), np.zeros(n, np.int64), *numbers, np.zeros(n, np.bool_))
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
    end, coexists = _from_rest(cells, hops, _bound(scene, flights.cycles))
    cycle, status = end.cycle, end.status
    answered = status == Status.OK

    time_aloft = np.bincount(flights.owner, flights.length)
    time = np.where(flights.repeats, _TURN * flights.cycles, time_aloft)
    landings = np.zeros(throw.size)
    np.maximum.at(landings, flights.owner, flights.impact)
    displacement = cycle.displacement / (time / _TURN)
    deviation = np.zeros(throw.size)
    pattern = cycle.pattern.copy()
    sampled = np.flatnonzero(~flights.repeats & answered)
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
    known = [np.where(answered, x, np.nan) for x in numbers]
    coexists &= answered & flights.repeats
    return HoppingCycles._make((status, np.where(answered, pattern, 0), *known, coexists))


def _from_rest(cells: Cells, hops: Hops, bound: Floats) -> tuple[_End, Bools]:
    """Find the fixed points that bodies from rest reach, and whether they are not the only ones.

    Where friction wins over gravity along the trough, all orbits stay bounded. There the greatest and the
    least fixed point are looked for if they may differ; only if they do must the orbit from rest be
    followed step by step. Without kinetic friction fixed points come in families.
    """
    scene = cells.track.scene
    mu_s, mu_d = scene.static_friction, scene.kinetic_friction
    start = np.broadcast_to(velocity_from_rest(cells.track), bound.shape)
    bounded = np.broadcast_to((mu_d > 0.0) & (np.abs(scene.tangential) <= mu_d * scene.normal), bound.shape)
    end = _bracketed(cells, hops, start, bound)
    coexists = np.zeros(bound.shape, np.bool_)
    doubtful = np.flatnonzero(bounded & (mu_d < _MOST_COEXISTENCE * mu_s) & (end.status == Status.OK))
    if doubtful.size:
        home = _End(end.velocity[doubtful], take(end.cycle, doubtful), end.status[doubtful])
        coexists[doubtful] = _coexists(take(cells, doubtful), hops, bound[doubtful], home)
    stepwise = np.flatnonzero(coexists | ~bounded)
    if stepwise.size:
        found = _careful(take(cells, stepwise), hops, start[stepwise], bound[stepwise])
        _move(end, stepwise, found.velocity, found.cycle)
        end.status[stepwise] = found.status
    return end, coexists


class _End(NamedTuple):
    """Where orbits of the return map lead: the velocity at lift-off, the cycle and its status."""

    velocity: Floats
    cycle: Return
    status: Codes


class _Steps(NamedTuple):
    """What the states of some orbits ask for."""

    walk: Floats
    rises: Bools
    newton: Floats
    closed: Bools
    gains: Bools


def _steps(here: Floats, now: Return) -> _Steps:
    """Compare states with their images: the plain step, Newton's, and whether the orbit ends.

    It ends in a fixed point, or gains velocity for ever: if it slides one way only, and faster each time.
    """
    plain = now.velocity - here
    walk, rises, size = np.abs(plain), plain > 0.0, 1.0 + np.abs(here)
    with np.errstate(divide="ignore", invalid="ignore"):
        newton = walk / (1.0 - now.slope)
    closed = (walk <= _FLOOR * size) | (newton <= _CLOSED * size)
    gains = (now.slope == 1.0) & (now.ways == np.where(rises, 1, 2)) & ~closed
    return _Steps(walk, rises, newton, closed, gains)


def _bracketed(cells: Cells, hops: Hops, velocity: Floats, bound: Floats) -> _End:
    """Find the fixed points of maps that have one: Newton's iteration in the bracket its steps leave."""
    end = _begin(cells, hops, velocity)
    low, high = -bound, bound.copy()
    active = np.arange(velocity.size)
    for _ in range(_MOST_EVALUATIONS):
        here = end.velocity[active]
        steps = _steps(here, end.cycle if active.size == velocity.size else take(end.cycle, active))
        end.status[active[steps.closed]] = Status.OK
        end.status[active[steps.gains]] = Status.RUNAWAY
        going = np.flatnonzero(~(steps.closed | steps.gains))
        if not going.size:
            break
        if going.size < active.size:
            active, cells, here, steps = active[going], take(cells, going), here[going], take(steps, going)
        low[active[steps.rises]] = here[steps.rises]
        high[active[~steps.rises]] = here[~steps.rises]
        room = np.where(steps.rises, high[active] - here, here - low[active])
        step = np.where(steps.newton < room, steps.newton, 0.5 * room)
        here = here + np.where(steps.rises, step, -step)
        _move(end, active, here, follow(cells, hops, here))
    return _checked(end)


def _careful(cells: Cells, hops: Hops, velocity: Floats, bound: Floats, home: _End | None = None) -> _End:
    """Follow orbits to the fixed points that they lead to.

    A Newton step that leaves its piece of the map might pass a fixed point, and is shortened, down to the
    plain walk. A body that only slides forward in a whole cycle is above all fixed points, one that only
    slides back below them. With a ``home``, an orbit ends there once it is known to lead there: in its
    piece of the map, or stepping over states known to be in it.
    """
    end = _begin(cells, hops, velocity)
    low, high = -bound, bound.copy()
    if home is not None:
        low, high = (
            np.where(velocity > 0.0, home.velocity, low),
            np.where(velocity < 0.0, home.velocity, high),
        )
    reach = np.full(velocity.size, np.inf)
    active = np.arange(velocity.size)
    for _ in range(_MOST_EVALUATIONS):
        here, now = end.velocity[active], take(end.cycle, active)
        steps = _steps(here, now)
        closed = steps.closed
        if home is not None:
            same = np.where(steps.rises, now.velocity >= high[active], now.velocity <= low[active])
            same |= now.piece == home.cycle.piece[active]
            end.velocity[active[same]] = home.velocity[active[same]]
            closed = closed | same
        end.status[active[closed]] = Status.OK
        end.status[active[steps.gains & ~closed]] = Status.RUNAWAY
        going = np.flatnonzero(~(closed | steps.gains))
        if not going.size:
            break
        if going.size < active.size:
            active, cells, now = active[going], take(cells, going), take(now, going)
            here, steps = here[going], take(steps, going)
        room = np.where(steps.rises, high[active] - here, here - low[active])
        bold = np.minimum(np.minimum(steps.newton, steps.walk * reach[active]), 0.5 * room)
        plain = bold <= steps.walk
        step = np.where(plain, steps.walk, bold)
        trial = np.where(plain, now.velocity, here + np.where(steps.rises, step, -step))
        found = follow(cells, hops, trial)
        low[active] = np.where(found.ways == 2, np.maximum(low[active], trial), low[active])
        high[active] = np.where(found.ways == 1, np.minimum(high[active], trial), high[active])
        fits = plain | (found.piece == now.piece)
        shorter = np.maximum(step / steps.walk / _SHY, 1.0)
        if home is not None:
            same = (found.piece == home.cycle.piece[active]) & ~plain
            low[active] = np.where(same & ~steps.rises, trial, low[active])
            high[active] = np.where(same & steps.rises, trial, high[active])
            fits &= ~same
            shorter = np.where(same, reach[active], shorter)
        reach[active] = np.where(fits, reach[active] * _SHY, shorter)
        kept = np.flatnonzero(fits)
        _move(end, active[kept], trial[kept], take(found, kept))
    return _checked(end)


def _begin(cells: Cells, hops: Hops, velocity: Floats) -> _End:
    status = np.full(velocity.size, Status.UNRESOLVED, np.int8)
    return _End(velocity.copy(), follow(cells, hops, velocity), status)


def _move(end: _End, active: NDArray[np.intp], velocity: Floats, cycle: Return) -> None:
    end.velocity[active] = velocity
    put(end.cycle, active, cycle)


def _checked(end: _End) -> _End:
    end.status[(end.status == Status.OK) & ~end.cycle.settled] = Status.UNRESOLVED
    return end


def _bound(scene: Loads, cycles: NDArray[np.intp]) -> Floats:
    """Limit of the velocity at lift-off at any fixed point.

    The body is stopped, or turns round, once in a cycle; only the drive and gravity can add behind that.
    """
    return 2.0 * scene.along + _TURN * cycles * np.abs(scene.tangential)


def _deviation(cells: Cells, hops: Hops, velocity: Floats) -> Floats:
    """Estimate the standard error of the mean displacement per drive cycle from batches of flights."""
    batch = cells.number // _BATCHES
    paths, times = np.empty((2, _BATCHES, velocity.size))
    for i in range(_BATCHES):
        part = cells._replace(first=cells.first + i * batch, number=batch)
        leg = follow(part, hops, velocity)
        velocity, paths[i] = leg.velocity, leg.displacement
        times[i] = [hops.length[a : a + m].sum() for a, m in zip(part.first, batch, strict=True)]
    mean = paths.sum(axis=0) / times.sum(axis=0)
    scatter = ((paths - mean * times) ** 2).sum(axis=0) / (_BATCHES * (_BATCHES - 1))
    deviation: Floats = _TURN * np.sqrt(scatter) / times.mean(axis=0)
    return deviation


def _coexists(cells: Cells, hops: Hops, bound: Floats, home: _End) -> Bools:
    """Whether the greatest or the least fixed point of the return map is another than ``home``.

    Orbits from beyond the bounds lead to them, since the map never decreases.
    """
    out = np.zeros(bound.shape, np.bool_)
    with np.errstate(divide="ignore"):
        noise = _FLOOR * (1.0 + np.abs(home.velocity)) / (1.0 - home.cycle.slope)
    for start in (bound, -bound):
        other = _careful(cells, hops, start, bound, home)
        apart = np.abs(other.velocity - home.velocity)
        out |= (other.status == Status.OK) & (apart > np.maximum(_APART, 8.0 * noise))
    return out
