"""The steady cycle of hopping scenes: the flights of ``bounce.py`` with the sliding between them.

Friction has no part in the normal motion, so that the flights are known before the sliding. What is left is
one unknown, the relative velocity at the first lift-off of the cycle. Trajectories cannot cross, only merge:
the map from one cycle's velocity to the next, the return map, never decreases. It is piecewise smooth with
a slope of at most 1 (a change of direction under friction, a rest and an impact all bring velocities
closer) and jumps upwards only, where stiction holds one body and not its neighbour. Its orbits are therefore
monotone, each piece has one fixed point at most, and a step that stays in its piece passes none unseen.
Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.bounce import bounces
from vibro.core.codes import Status
from vibro.core.groups import put, take
from vibro.core.motion import Mode, Track, contact_leg, mode_of, track_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.bounce import Bounces
    from vibro.core.groups import Loads
    from vibro.core.slide import Floats

    Bools = NDArray[np.bool_]
    Codes = NDArray[np.int8]
    Words = NDArray[np.int64]

__all__ = ["HoppingCycles", "hopping_cycles", "pattern_text"]

_TURN: Final = 2.0 * np.pi

_LETTERS: Final = " HFB_"  # by Mode
_MOST_LETTERS: Final = 27  # digits to base 5 in an int64; longer patterns are cut

#: [1] Throw number above which the phase of a landing is lost to rounding.
MOST_THROW: Final = 1e6

_MOST_EVALUATIONS: Final = 200
_MOST_LEGS: Final = 64
_FLOOR: Final = 16 * 2.0**-52  # [1] rounding of one evaluation, relative to the velocities in it
_CLOSED: Final = 1e-13  # [A w] distance from the fixed point at which the cycle is closed
_BOLD: Final = 1e6  # [1] longest first step, over the plain one
_SHY: Final = 8.0  # [1] factor by which that shrinks where a step left its piece, or grows

# [1] Coexisting cycles need mu_d well below mu_s; none was found above (benchmarks/hopping.py).
_MOST_COEXISTENCE: Final = 0.6

_BATCHES: Final = 12  # of flights, for the standard error of a mean
_LONGEST: Final = 4.0  # [A w] a step of the iteration, where velocities are below 1
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
        Whether a disturbed body can settle elsewhere; looked at where mu_d < 0.6 mu_s.
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


def pattern_text(code: int) -> str:
    """Phases of a cycle from their code: H flight, F forward slide, B back slide, _ rest.

    A pattern of more than 27 phases is cut, and ends in ``...``.
    """
    if code < 0:
        return pattern_text(-code) + "..."
    return "" if code == 0 else pattern_text(code // 5) + _LETTERS[code % 5]


class _Hops(NamedTuple):
    """What each flight and the impact behind it do to the relative velocity, whatever that is."""

    gain: Floats
    length: Floats
    shift: Floats
    brake: Floats
    high: Floats
    low: Floats


class _Cells(NamedTuple):
    """Scenes under way: their flights in the arrays of ``_Hops``, and their contact."""

    track: Track
    first: NDArray[np.intp]
    number: NDArray[np.intp]
    landing: Floats
    rest: Floats


class _Return(NamedTuple):
    """One cycle from a given velocity at its first lift-off.

    Attributes
    ----------
    velocity : array
        Relative velocity at the next such lift-off.
    slope : array
        Its derivative.
    displacement, peak : array
        Displacement, and largest speed.
    pattern : int64 array
        Phases of the cycle.
    piece : int64 array
        Names the piece of the map.
    ways : int8 array
        1: moves forward in contact somewhere, 2: backward, 4: at rest or stopped by an impact.
    settled : bool array
        Whether every slide was solved.
    """

    velocity: Floats
    slope: Floats
    displacement: Floats
    peak: Floats
    pattern: Words
    piece: Words
    ways: Codes
    settled: Bools


def _hops(scene: Loads, flights: Bounces) -> _Hops:
    """Integrate the free motion along the trough over each flight, Eq. (30)."""
    along, tangential, normal, mu_d = (
        x[flights.owner] if x.ndim else x
        for x in (scene.along, scene.tangential, scene.normal, scene.kinetic_friction)
    )
    s, p = flights.length, flights.phase
    sine, cosine = np.sin(p), np.cos(p)
    sine_s, versine_s = np.sin(s), 1.0 - np.cos(s)
    gain = along * (cosine * versine_s + sine * sine_s) - tangential * s
    shift = along * (cosine * (s - sine_s) + sine * versine_s) - 0.5 * tangential * s * s
    high, low = np.maximum(gain, 0.0), np.minimum(gain, 0.0)
    # extremes inside the flight: where the tangential load changes sign
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = np.arcsin(np.clip(tangential / along, -1.0, 1.0))
    for extreme in (np.pi - kappa, kappa):
        nearest = np.mod(extreme - p, _TURN)
        last = nearest + _TURN * np.floor((s - nearest) / _TURN)
        for at in (nearest, last):
            v = along * (cosine - np.cos(p + at)) - tangential * at
            inside = at <= s
            high = np.where(inside, np.maximum(high, v), high)
            low = np.where(inside, np.minimum(low, v), low)
    return _Hops(gain, s, shift, mu_d * normal * flights.impulse, high, low)


def _return(cells: _Cells, hops: _Hops, velocity: Floats) -> _Return:
    """Follow the bodies through one cycle of their normal motion."""
    n = velocity.size
    out = _Return(
        velocity.copy(),
        np.ones(n),
        np.zeros(n),
        np.abs(velocity),
        np.zeros(n, np.int64),
        np.zeros(n, np.int64),
        np.zeros(n, np.int8),
        np.ones(n, np.bool_),
    )
    for j in range(int(cells.number.max())):
        flying = np.flatnonzero(cells.number > j)
        v = out.velocity[flying]
        hop = take(hops, cells.first[flying] + j)
        out.displacement[flying] += v * hop.length + hop.shift
        top = np.maximum(np.abs(v + hop.high), np.abs(v + hop.low))
        out.peak[flying] = np.maximum(out.peak[flying], top)
        v += hop.gain
        left = np.maximum(np.abs(v) - hop.brake, 0.0)
        stopped = left == 0.0
        out.velocity[flying] = np.copysign(left, v)
        out.slope[flying] *= ~stopped
        way = np.where(stopped, np.int8(4), np.where(v > 0.0, np.int8(1), np.int8(2)))
        out.ways[flying] |= way
        out.piece[flying] = out.piece[flying] * 37 + way
        out.pattern[flying] = _append(out.pattern[flying], np.int64(Mode.FLIGHT))
    on_trough = np.flatnonzero(cells.rest > 0.0)
    if on_trough.size:
        _contact(cells, out, on_trough)
    return out


_WAY_OF_MODE: Final = np.array([0, 0, 1, 2, 4], np.int8)


def _contact(cells: _Cells, out: _Return, active: NDArray[np.intp]) -> None:
    """Slide and rest from the last landing to the lift-off."""
    track = take(cells.track, active)
    phase, left = cells.landing[active], cells.rest[active]
    velocity = out.velocity[active]
    mode = mode_of(track.scene, phase, velocity)
    for _ in range(_MOST_LEGS):
        leg = contact_leg(track, mode, phase, velocity, left)
        way = _WAY_OF_MODE[mode]
        out.ways[active] |= way
        turn = ((phase > np.pi) + np.int64(2) * (phase > 0.0)) * 8
        out.piece[active] = out.piece[active] * 37 + way + turn
        out.pattern[active] = _append(out.pattern[active], mode.astype(np.int64))
        out.displacement[active] += leg.displacement
        out.peak[active] = np.maximum(out.peak[active], leg.top)
        out.slope[active] *= leg.gain
        out.settled[active] &= leg.settled
        out.velocity[active] = leg.velocity
        going = np.flatnonzero(leg.length < left)
        if not going.size:
            return
        active, track = active[going], take(track, going)
        phase, left = phase[going] + leg.length[going], left[going] - leg.length[going]
        velocity, mode = leg.velocity[going], leg.next_mode[going]
    out.settled[active] = False


def _append(pattern: Words, digit: Words | np.int64) -> Words:
    """Append a phase to a pattern; beyond what fits it turns negative and stays as it is."""
    full = np.abs(pattern) >= 5 ** (_MOST_LETTERS - 1)
    return np.where(full, -np.abs(pattern), 5 * pattern + digit)


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
    hops = _hops(scene, flights)
    cells = _Cells(track_of(scene), flights.first, flights.number, flights.landing, flights.rest)
    bound = _bound(scene, flights.cycles)
    mu_s, mu_d = scene.static_friction, scene.kinetic_friction
    unique = np.broadcast_to(mu_d >= _MOST_COEXISTENCE * mu_s, throw.shape) & (
        np.abs(scene.tangential) <= mu_d * scene.normal
    )
    end = _settle(cells, hops, _velocity_from_rest(cells.track), bound, unique)
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
    coexists = np.zeros(throw.shape, np.bool_)
    some = np.flatnonzero(answered & flights.repeats & ~unique & (mu_d > 0.0))
    if some.size:
        coexists[some] = _coexists(take(cells, some), hops, bound[some], end.velocity[some])
    known = [np.where(answered, x, np.nan) for x in numbers]
    return HoppingCycles._make((status, np.where(answered, pattern, 0), *known, coexists))


def _velocity_from_rest(track: Track) -> Floats:
    """Velocity at the first lift-off of a body at rest, which slides forward from its onset, Eq. (34)."""
    start, end, at = track.forward_onset, track.lift_off, track.forward
    velocity: Floats = at.pull * (np.cos(start) - np.cos(end)) - at.drag * (end - start)
    return velocity


class _End(NamedTuple):
    """Where orbits of the return map lead: the velocity at lift-off, the cycle and its status."""

    velocity: Floats
    cycle: _Return
    status: Codes


def _settle(cells: _Cells, hops: _Hops, velocity: Floats, bound: Floats, unique: Bools) -> _End:
    """Follow orbits of the return map to their fixed points.

    Newton's iteration, which stays in a bracket where the fixed point is ``unique``. Elsewhere a step that
    leaves its piece of the map might pass a fixed point, and is shortened, down to the plain walk.
    """
    v = velocity.copy()
    low, high = -bound, bound.copy()
    at = _return(cells, hops, v)
    status = np.full(v.size, Status.UNRESOLVED, np.int8)
    reach = np.full(v.size, _BOLD)
    active = np.arange(v.size)
    for _ in range(_MOST_EVALUATIONS):
        now = at if active.size == v.size else take(at, active)
        here = v[active]
        plain = now.velocity - here
        size = 1.0 + np.abs(here)
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = plain / (1.0 - now.slope)
        closed = (np.abs(plain) <= _FLOOR * size) | (np.abs(newton) <= _CLOSED * size)
        gains = (now.slope == 1.0) & (now.ways == np.where(plain > 0.0, 1, 2)) & ~closed
        status[active[closed]] = Status.OK
        status[active[gains]] = Status.RUNAWAY
        going = np.flatnonzero(~(closed | gains))
        if not going.size:
            break
        if going.size < active.size:
            active, cells, now = active[going], take(cells, going), take(now, going)
            here, plain, newton, size = here[going], plain[going], newton[going], size[going]
        rises = plain > 0.0
        low[active] = np.where(rises, np.maximum(low[active], here), low[active])
        high[active] = np.where(rises, high[active], np.minimum(high[active], here))
        safe = unique[active]
        left, right = low[active], high[active]
        inside = here + newton
        inside = np.where((inside > left) & (inside < right), inside, 0.5 * (left + right))
        walk = np.abs(plain)
        step = np.maximum(np.minimum(np.abs(newton), np.minimum(walk * reach[active], _LONGEST * size)), walk)
        trial = np.where(safe, inside, here + np.copysign(step, plain))
        found = _return(cells, hops, trial)
        fits = safe | (found.piece == now.piece) | (step == walk)
        shorter = np.maximum(step / walk / _SHY, 1.0)
        reach[active] = np.where(fits, np.minimum(reach[active] * _SHY, _BOLD), shorter)
        kept = np.flatnonzero(fits)
        v[active[kept]] = trial[kept]
        put(at, active[kept], take(found, kept))
    status[(status == Status.OK) & ~at.settled] = Status.UNRESOLVED
    return _End(v, at, status)


def _bound(scene: Loads, cycles: NDArray[np.intp]) -> Floats:
    """Limit of the velocity at lift-off at any fixed point.

    The body is stopped, or turns round, once in a cycle; only the drive and gravity can add behind that.
    """
    return 2.0 * scene.along + _TURN * cycles * np.abs(scene.tangential)


def _deviation(cells: _Cells, hops: _Hops, velocity: Floats) -> Floats:
    """Estimate the standard error of the mean displacement per drive cycle from batches of flights."""
    batch = cells.number // _BATCHES
    paths, times = np.empty((2, _BATCHES, velocity.size))
    for i in range(_BATCHES):
        part = cells._replace(first=cells.first + i * batch, number=batch)
        leg = _return(part, hops, velocity)
        velocity, paths[i] = leg.velocity, leg.displacement
        times[i] = [hops.length[a : a + m].sum() for a, m in zip(part.first, batch, strict=True)]
    mean = paths.sum(axis=0) / times.sum(axis=0)
    scatter = ((paths - mean * times) ** 2).sum(axis=0) / (_BATCHES * (_BATCHES - 1))
    deviation: Floats = _TURN * np.sqrt(scatter) / times.mean(axis=0)
    return deviation


def _coexists(cells: _Cells, hops: _Hops, bound: Floats, velocity: Floats) -> Bools:
    """Whether the greatest or the least fixed point of the return map is another than ``velocity``.

    Orbits from beyond the bounds lead to them, since the map never decreases.
    """
    out = np.zeros(velocity.shape, np.bool_)
    for start in (bound, -bound):
        other = _settle(cells, hops, start, bound, out & False)
        out |= (other.status == Status.OK) & (np.abs(other.velocity - velocity) > _APART)
    return out
