"""Where the orbits of the return map of ``returns.py`` lead: its fixed points.

The map never decreases, so that its orbits are monotone and end at the first fixed point on their way.
A cycle either has a stop, a rest or an impact that takes all of the velocity, or it has none.

* After its last stop a cycle is the same whatever was before: the few velocities that can repeat are known
  beforehand.
* Without a stop the drive adds nothing over a cycle. What friction takes off grows with the velocity, as
  faster bodies are ahead at every phase, so that there is one fixed point at most; and none where gravity
  along the trough exceeds kinetic friction.

Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.codes import Status
from vibro.core.flight.drift import CLOSED, FLOOR, Span, drift, has_stop, size_of
from vibro.core.flight.returns import Cells, Hops, Return, after_stops, return_map
from vibro.core.groups import put, take
from vibro.core.roots import OpenCells

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats

    Bools = NDArray[np.bool_]
    Codes = NDArray[np.int8]
    Indices = NDArray[np.intp]

__all__ = [
    "MOST_EVALUATIONS",
    "Fixed",
    "Orbits",
    "between",
    "from_rest",
    "joined",
    "stopping",
]

#: Evaluations of the return map, of which the slowest orbits need the most.
MOST_EVALUATIONS: Final = 200
# [1] Where an onset lies close to the lift-off, its phase is known to the root of an ulp only, and so is the
# velocity at the lift-off after it. A velocity that returns within this distance is replaced by its image and
# checked again.
_NEAR: Final = 1e-6
# [1] Only with mu_d well below mu_s may there be more fixed points than one; none were found above
# (benchmarks/hopping.py).
_MOST_COEXISTENCE: Final = 0.75
_BESIDE: Final = 4.0 * CLOSED  # [1] distance of another body from a cycle, over the velocities in it


class Orbits(NamedTuple):
    """Where orbits lead.

    Attributes
    ----------
    velocity : array
        At the lift-off.
    cycle : Return
        The cycle from there.
    status : int8 array
        ``OK``, ``BOUNDARY``, ``RUNAWAY`` or ``UNRESOLVED``.
    """

    velocity: Floats
    cycle: Return
    status: Codes


def from_rest(cells: Cells, hops: Hops, start: Floats, span: Span, most: int = MOST_EVALUATIONS) -> Orbits:
    """Find the fixed points that bodies reach.

    Parameters
    ----------
    cells, hops : Cells, Hops
        Scenes and their flights.
    start : array
        Velocity at the first lift-off.
    span : Span
        Sizes of the cycles.
    most : int, optional
        Number of evaluations of the return map after which an orbit is left ``UNRESOLVED``.

    Returns
    -------
    Orbits
        One element per scene.
    """
    free = np.flatnonzero(~span.bounded)
    if free.size == start.size:
        return _until_stopped(cells, hops, start, span)
    if not free.size:
        return _held(cells, hops, start, span, most)
    end = _unsolved(start.size)
    held = np.flatnonzero(span.bounded)
    _put(end, held, _held(take(cells, held), hops, start[held], take(span, held), most))
    _put(end, free, _until_stopped(take(cells, free), hops, start[free], take(span, free)))
    return end


def _held(cells: Cells, hops: Hops, start: Floats, span: Span, most: int) -> Orbits:
    """Follow orbits where friction holds gravity, so that they stay bounded."""
    end = _bracketed(cells, hops, start, span, (-span.bound, span.bound), most)
    scene = cells.track.scene
    low = scene.kinetic_friction < _MOST_COEXISTENCE * scene.static_friction
    doubtful = np.flatnonzero(low & (end.status == Status.OK))
    if doubtful.size:
        home = _taken(end, doubtful)
        _lead_first(take(cells, doubtful), hops, start[doubtful], take(span, doubtful), home)
        _put(end, doubtful, home)
    edge = np.flatnonzero((end.status == Status.OK) & span.edge)
    if edge.size:
        # Where friction just holds gravity, a body may stop in its cycle by rounding alone. It does not if a
        # body that slides downhill a little faster stops too.
        velocity, part = end.velocity[edge], take(cells, edge)
        downhill = -np.sign(np.broadcast_to(scene.tangential, start.shape))[edge]
        near = velocity + downhill * _BESIDE * size_of(take(span, edge), velocity)
        end.status[edge[~has_stop(return_map(part, hops, near))]] = Status.BOUNDARY
    return end


def _lead_first(cells: Cells, hops: Hops, start: Floats, span: Span, home: Orbits) -> None:
    """Move ``home``, some fixed point, to the first one on the way from the start, which the orbits reach.

    Those with a stop are listed. The one without a stop is either ``home`` or looked for, unless the first
    cycle of the orbit leads to ``home`` by a stop.
    """
    now = return_map(cells, hops, start)
    steps = drift(start, now, span)
    way = np.where(steps.closed, 0.0, np.where(steps.rises, 1.0, -1.0))
    left = np.flatnonzero(~(has_stop(now) & (np.abs(now.velocity - home.velocity) <= FLOOR * span.drive)))
    if not left.size:
        return
    cells, start, span, way = take(cells, left), start[left], take(span, left), way[left]
    end, n = _taken(home, left), left.size
    fixed = stopping(cells, hops, start, span, take(now, left), way)
    fixed = joined(fixed, Fixed(np.arange(n), end.velocity, end.cycle))
    unknown = np.flatnonzero(has_stop(end.cycle) & (way != 0.0))
    if unknown.size:
        target = way * span.bound
        found, first = _first_on_way(fixed, start, way)
        target[found] = fixed.velocity[first]
        part = take(cells, unknown)
        sliding = between(part, hops, start[unknown], target[unknown], take(span, unknown))
        seen = np.flatnonzero(sliding.status == Status.OK)
        fixed = joined(fixed, Fixed(unknown[seen], sliding.velocity[seen], take(sliding.cycle, seen)))
    found, first = _first_on_way(fixed, start, way)
    _move(home, left[found], fixed.velocity[first], take(fixed.cycle, first))


def _unsolved(count: int) -> Orbits:
    numbers = np.empty((5, count))
    cycle = Return._make((*numbers, np.zeros(count, np.int64), np.zeros(count, np.bool_)))
    return Orbits(np.empty(count), cycle, np.full(count, Status.UNRESOLVED, np.int8))


def _started(cells: Cells, hops: Hops, velocity: Floats) -> Orbits:
    return _unsolved(velocity.size)._replace(
        velocity=velocity.copy(), cycle=return_map(cells, hops, velocity)
    )


def _taken(end: Orbits, cells: Indices) -> Orbits:
    return Orbits(end.velocity[cells], take(end.cycle, cells), end.status[cells])


def _put(end: Orbits, cells: Indices, part: Orbits) -> None:
    _move(end, cells, part.velocity, part.cycle)
    end.status[cells] = part.status


def _move(end: Orbits, cells: Indices, velocity: Floats, cycle: Return) -> None:
    end.velocity[cells] = velocity
    put(end.cycle, cells, cycle)


def _checked(end: Orbits) -> Orbits:
    end.status[(end.status == Status.OK) & ~end.cycle.settled] = Status.UNRESOLVED
    return end


def _bracketed(
    cells: Cells,
    hops: Hops,
    velocity: Floats,
    span: Span,
    bracket: tuple[Floats, Floats],
    most: int = MOST_EVALUATIONS,
) -> Orbits:
    """Find fixed points, any where there are several: Newton's iteration in the bracket its steps leave.

    Where kinetic friction just holds gravity, all velocities at which the body slides downhill alone are
    fixed points; the orbit ends at the first of them.
    """
    end = _unsolved(velocity.size)
    group = cells, span, velocity, *bracket, velocity
    unclosed = OpenCells(np.arange(velocity.size), group, most)
    for at, (cells, span, start, low, high, here) in unclosed:
        now = return_map(cells, hops, here)
        _move(end, at, here, now)
        steps = drift(here, now, span)
        past = steps.closed & span.edge & (now.slope == 1.0) & (here != start)
        rises = np.where(past, here < start, steps.rises)
        low, high = np.where(rises, here, low), np.where(rises, high, here)
        room = high - low
        closed = (steps.closed & ~past) | (room <= FLOOR * (span.drive + np.abs(here)))
        end.status[at[closed]] = Status.OK
        step = np.where(steps.newton < room, steps.newton, 0.5 * room)
        onward = here + np.where(rises, step, -step)
        unclosed.keep(~closed, (cells, span, start, low, high, onward))
    return _checked(end)


def _until_stopped(cells: Cells, hops: Hops, start: Floats, span: Span) -> Orbits:
    """Follow orbits where gravity drives the body on in every cycle without a stop, or nothing acts on it.

    They end at the first fixed point with a stop on their way, or nowhere: ``RUNAWAY``.
    """
    end = _started(cells, hops, start)
    downhill = -np.sign(np.broadcast_to(cells.track.scene.tangential, start.shape))
    change = end.cycle.velocity - start
    change[np.abs(change) <= FLOOR * size_of(span, start)] = 0.0
    way = np.where(has_stop(end.cycle), np.sign(change), downhill)
    end.status[way == downhill] = Status.RUNAWAY
    end.status[way == 0.0] = Status.OK
    going = np.flatnonzero(way != 0.0)
    if going.size:
        part = take(cells, going), hops, start[going], take(span, going)
        fixed = stopping(*part, take(end.cycle, going), way[going])
        found, first = _first_on_way(fixed, start[going], way[going])
        _move(end, going[found], fixed.velocity[first], take(fixed.cycle, first))
        end.status[going[found]] = Status.OK
    return _checked(end)


class Fixed(NamedTuple):
    """Fixed points and the scenes they belong to."""

    owner: Indices
    velocity: Floats
    cycle: Return


def stopping(
    cells: Cells, hops: Hops, start: Floats, span: Span, begin: Return, way: Floats | None = None
) -> Fixed:
    """Find fixed points with a stop, or after one where nothing acts on the body: all, or those on a way.

    ``begin`` is the cycle from the start, which stands for a rest that ends at the forward onset.
    """
    owner, velocity = after_stops(cells, hops)
    if way is not None:
        ahead = np.flatnonzero(way[owner] * (velocity - start[owner]) >= 0.0)
        owner, velocity = owner[ahead], velocity[ahead]
    cycle = joined(begin, return_map(take(cells, owner), hops, velocity))
    owner = np.concatenate((np.arange(start.size), owner))
    velocity = np.concatenate((start, velocity))
    size = size_of(take(span, owner), velocity)
    apart = np.abs(cycle.velocity - velocity)
    near = np.flatnonzero(has_stop(cycle) & (apart > FLOOR * size) & (apart <= _NEAR * size))
    if near.size:
        velocity[near] = cycle.velocity[near]
        put(cycle, near, return_map(take(cells, owner[near]), hops, velocity[near]))
        apart[near] = np.abs(cycle.velocity[near] - velocity[near])
    again = np.where(has_stop(cycle), apart <= FLOOR * size, span.neutral[owner])
    repeats = np.flatnonzero(cycle.settled & again)
    return Fixed(owner[repeats], velocity[repeats], take(cycle, repeats))


def _first_on_way(fixed: Fixed, start: Floats, way: Floats) -> tuple[Indices, Indices]:
    """Scenes that have a fixed point on the way from their starts, and the first of each."""
    ahead, way = fixed.velocity - start[fixed.owner], way[fixed.owner]
    distance = np.where(way == 0.0, np.abs(ahead), way * ahead)
    order = np.lexsort((distance, fixed.owner))
    order = order[distance[order] >= 0.0]
    found, first = np.unique(fixed.owner[order], return_index=True)
    return found, order[first]


def joined(one: Any, other: Any) -> Any:
    """Concatenate two nested tuples of arrays."""
    if isinstance(one, tuple):
        return type(one)(*(joined(*pair) for pair in zip(one, other, strict=True)))
    return np.concatenate((one, other))


def between(cells: Cells, hops: Hops, velocity: Floats, target: Floats, span: Span) -> Orbits:
    """Look for the fixed points without a stop on the way to a target, with none with a stop before it.

    As there is one at most, it lies ahead of every velocity without a stop that is carried on. ``far`` is a
    velocity beyond which it cannot lie: from there the orbit leads back, or to the target by stops alone.
    Where it is found the status is ``OK``.
    """
    end = _started(cells, hops, velocity)
    way, far = np.sign(target - velocity), target.copy()
    crossed = np.zeros(velocity.shape, np.bool_)
    active, rest, sizes = np.arange(velocity.size), cells, span
    for _ in range(MOST_EVALUATIONS):
        here, now, onward = end.velocity[active], take(end.cycle, active), way[active]
        steps = drift(here, now, sizes)
        end.status[active[steps.closed & ~has_stop(now)]] = Status.OK
        room = onward * (far[active] - here)
        over = steps.closed | crossed[active] | (room <= FLOOR * (sizes.drive + np.abs(here)))
        over |= (onward * (now.velocity - far[active]) >= 0.0) | (steps.rises != (onward > 0.0))
        going = np.flatnonzero(~over)
        if not going.size:
            break
        active, rest, sizes = active[going], take(rest, going), take(sizes, going)
        here, onward, room, newton = here[going], onward[going], room[going], steps.newton[going]
        trial = here + onward * np.fmin(newton, 0.5 * room)
        found = return_map(rest, hops, trial)
        steps, stops = drift(trial, found, sizes), has_stop(found)
        leads_back = ~steps.closed & (steps.rises != (onward > 0.0))
        arrives = stops & (steps.closed | (onward * (found.velocity - far[active]) >= 0.0))
        blocked = leads_back | arrives
        # A stop leads on, as the map never decreases: by others to a cycle without one, or to the target.
        through = np.flatnonzero(stops & ~blocked)
        group = take(rest, through), take(sizes, through), onward[through], far[active[through]]
        led_on = OpenCells(through, (*group, found.velocity[through]), MOST_EVALUATIONS)
        for through, (part, size, ahead, limit, position) in led_on:
            behind = return_map(part, hops, position)
            again = has_stop(behind)
            free = np.flatnonzero(~again)
            trial[through[free]] = position[free]
            put(found, through[free], take(behind, free))
            path, left = ahead * (behind.velocity - position), ahead * (limit - behind.velocity)
            on = again & (left > 0.0) & (path > FLOOR * size_of(size, position))
            blocked[through[again & ~on]] = True
            led_on.keep(on, (part, size, ahead, limit, behind.velocity))
        blocked[led_on.cells] = True
        far[active[blocked]] = trial[blocked]
        crossed[active] = leads_back
        moved = np.flatnonzero(~blocked)
        _move(end, active[moved], trial[moved], take(found, moved))
    inside = np.flatnonzero(crossed)
    if inside.size:
        near, far = end.velocity[inside], far[inside]
        bracket = np.minimum(near, far), np.maximum(near, far)
        _put(end, inside, _bracketed(take(cells, inside), hops, near, take(span, inside), bracket))
    return _checked(end)
