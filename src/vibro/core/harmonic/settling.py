"""Which cycle a body settles into: the nearest one on the side to which its velocity changes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.harmonic.cycle import (
    Bodies,
    Cycles,
    Start,
    Track,
    follow,
    from_onsets,
    near_cycles,
    no_cycles,
    onsets_of,
    read,
    signs,
    stopped,
    without_rest,
    write,
)
from vibro.core.harmonic.jumps import direction_after_turn, jumps_of, leads
from vibro.core.harmonic.waves import values, wrapped

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.harmonic.slides import Lanes

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]

__all__ = ["Settled", "settle"]

# Slides a harmonic after which the nearest cycle is looked for elsewhere; after the last a body is given up.
_LOOKS: Final = (4, 7, 11, 17, 26, 40, 60)
# [1] Shares of the way to a cycle that is none, at which one is looked for.
_LEAPS: Final = (1.0, 0.8, 0.6, 0.45, 0.3, 0.2, 0.1, 0.05)


class Settled(NamedTuple):
    """Steady cycles of bodies.

    Attributes
    ----------
    cycles : Cycles
        Without a slide where there is none.
    endless : int array
        Lane of the slide that never ends; -1 where all end.
    edge : bool array
        Whether rounding decided something on the way.
    """

    cycles: Cycles
    endless: Indices
    edge: Bools


def settle(at: Lanes, cell: Indices, begun: Start) -> Settled:
    """Find the cycles that bodies settle into.

    Parameters
    ----------
    at : Lanes
        Scenes.
    cell : int array
        That of each body.
    begun : Start
        Their first slides.

    Notes
    -----
    Trajectories do not cross. So a body's velocity at a given phase rises, or falls, from cycle to cycle, and
    tends to the nearest fixed point on that side. If it does not rest for a whole cycle, that is either the
    one cycle without rest or a cycle with one. A cycle that rests before an onset, where it has no velocity,
    lies between two others only if these pass the onset in different directions.
    """
    count, h = cell.size, at.onset.shape[0]
    track, out = Track(count, h), no_cycles(count, h)
    track.edge |= begun.edge
    bodies = Bodies(np.arange(count), cell, begun, np.zeros(count), np.zeros(count, np.intp))
    for k in range(1, _LOOKS[-1] * h + 1):
        bodies = follow(at, bodies, track, out, range(k - 1, k))
        if k <= _LOOKS[0] * h:
            bodies = _nearest_without_rest(at, bodies, track, out, k)
        if k % h == 0 and k // h in _LOOKS:
            bodies = _nearest(at, bodies, track, out, k)
        if not bodies.number.size:
            break
    return Settled(out, track.endless, track.edge)


def _side(at: Lanes, orbit: Cycles, bodies: Bodies) -> NDArray[np.int8]:
    """Direction in which the velocity of bodies without rest changes: +1 where it rises.

    A forward slide that starts later than a cycle before is slower.
    """
    forward = np.where(orbit.lane[0] < at.noise.size // 2, 1.0, -1.0)
    later = wrapped(bodies.now.phase - orbit.start[0] + np.pi) - np.pi
    return np.asarray(np.sign(-forward * later), np.int8)


def _nearest_without_rest(at: Lanes, bodies: Bodies, track: Track, out: Cycles, k: int) -> Bodies:
    """Settle bodies that tend to the cycle without rest, with nothing in between; return the others."""
    near = near_cycles(bodies, track, k)
    n = at.noise.size // 2
    held = (at.kinetic[0, bodies.cell] < 0.0) & (at.kinetic[0, bodies.cell + n] < 0.0)
    tried = ((near > 0) & held).nonzero()[0]
    if not tried.size:
        return bodies
    some, near = bodies.some(tried), near[tried]
    orbit = track.cut(some.number, k - near, near)
    found, valid, edge = without_rest(at, orbit)
    good = valid & _is_next(at, some, orbit, found)
    done = good.nonzero()[0]
    write(out, some.number[done], read(found, done))
    track.edge[some.number[done]] |= edge[done]
    stays = np.ones(bodies.number.size, np.bool_)
    stays[tried[done]] = False
    return bodies.some(stays.nonzero()[0])


def _is_next(at: Lanes, bodies: Bodies, orbit: Cycles, cycle: Cycles) -> Bools:
    """Whether cycles without rest lie on the side to which bodies tend, and no onset in between."""
    onsets = onsets_of(at, bodies.cell)
    onsets = np.where(np.arange(onsets.shape[0])[:, np.newaxis] == orbit.row[0], np.nan, onsets)
    lanes = at.noise.size
    same = (signs(orbit, lanes, onsets) == signs(cycle, lanes, onsets)) | np.isnan(onsets)
    side = _side(at, orbit, bodies)
    towards = signs(cycle, lanes, orbit.start[:1])[0]
    apart = np.abs(wrapped(cycle.start[0] - orbit.start[0] + np.pi) - np.pi)
    return np.asarray(same.all(axis=0) & ((side == towards) | (apart < 1e-9)))


def _nearest(at: Lanes, bodies: Bodies, track: Track, out: Cycles, k: int) -> Bodies:
    """Choose the nearest of all cycles on the right side; return the bodies where that is not possible."""
    near = near_cycles(bodies, track, k)
    pick = (near > 0).nonzero()[0]
    if not pick.size:
        return bodies
    n, h = at.noise.size // 2, at.onset.shape[0]
    some = bodies.some(pick)
    orbit = track.cut(some.number, k - near[pick], near[pick])
    side = _side(at, orbit, some)
    resting = _with_rest(at, some.cell)
    # Where gravity exceeds friction no cycle goes without rest: the mean force along it would not be 0.
    loose = np.array([at.kinetic[0, some.cell] >= 0.0, at.kinetic[0, some.cell + n] >= 0.0])
    held = np.asarray(~loose.any(axis=0))
    pull = np.where(side > 0, at.kinetic[0, some.cell], at.kinetic[0, some.cell + n])
    runaway = pull > 0.0
    restless = no_cycles(pick.size, h)
    done = np.zeros(pick.size, np.bool_)
    for look in (_here, _leap):
        left = (~done & held).nonzero()[0]
        write(restless, left, look(at, some.some(left), read(orbit, left)))
        left = (~done).nonzero()[0]
        candidates = [read(x, left) for x in (*resting, restless)]
        chosen, restless_beside = _choose(at, some.some(left), candidates, read(orbit, left), side[left])
        # one without rest that was not found may yet exist
        for i, cycles in enumerate(candidates):
            own = (chosen == i).nonzero()[0]
            cells = left[own]
            sure = np.ones(own.size, np.bool_)
            sure[held[cells]] = restless_beside[own[held[cells]]]
            if i < 2 * h and not sure.all():
                open_ = (~sure).nonzero()[0]
                args = read(orbit, cells[open_]), read(cycles, own[open_]), side[cells[open_]]
                sure[open_] = _nothing_between(at, some.cell[cells[open_]], *args)
            write(out, some.number[cells[sure]], read(cycles, own[sure]))
            done[cells[sure]] = True
        runs = left[(chosen == -1) & runaway[left]]
        track.endless[some.number[runs]] = some.cell[runs] + np.where(side[runs] > 0, 0, n)
        done[runs] = True
    stays = np.ones(bodies.number.size, np.bool_)
    stays[pick[done]] = False
    return bodies.some(stays.nonzero()[0])


def _choose(
    at: Lanes, bodies: Bodies, candidates: list[Cycles], orbit: Cycles, side: NDArray[np.int8]
) -> tuple[Indices, Bools]:
    """Choose the nearest of cycles, in the order of the onsets they rest until and last the one without rest.

    All others on that side pass its onset, or its first start, on the far side. It is -1 where there is none,
    -2 where rounding decides. Tell too whether that without rest is among them.
    """
    lanes = at.noise.size
    exists = np.array([(x.size > 0) & (signs(x, lanes, orbit.start[:1])[0] == side) for x in candidates])
    probes = np.concatenate([onsets_of(at, bodies.cell), candidates[-1].start[:1]])
    order = np.array([signs(x, lanes, probes) for x in candidates])  # [cycle, probe, body]
    chosen = np.where(exists.any(axis=0), -2, -1)
    for i in range(len(candidates)):
        beyond = (order[:, i] * side >= 0) | ~exists
        beyond[i] = True
        np.copyto(chosen, i, where=exists[i] & beyond.all(axis=0))
    return chosen, exists[-1]


def _nothing_between(at: Lanes, cell: Indices, orbit: Cycles, cycle: Cycles, side: NDArray[np.int8]) -> Bools:
    """Whether no cycle without rest lies between bodies and the nearest cycle with a rest.

    If one did, it would attract from both sides, as the other does: between them the return map would jump.
    It does where a body at rest stays so but would slide on at the least speed, and on the near side of the
    jump bodies would tend back.
    """
    jumps = jumps_of(at, cell)
    between = (signs(orbit, at.noise.size, jumps) * side < 0) & (
        signs(cycle, at.noise.size, jumps) * side >= 0
    )
    row, column = np.nonzero(between & ~np.isnan(jumps))
    toward = side[column]
    # slides towards the cycle lie on the far side of the jump, bodies at rest on the near one; or the other
    # way round
    back = direction_after_turn(at, cell[column], row, leads(at, row) != toward) * toward < 0
    return np.asarray(np.bincount(column[back], minlength=cell.size) == 0)


def _with_rest(at: Lanes, cell: Indices) -> list[Cycles]:
    """Cycles that rest until each of the onsets, where there are such."""
    h = at.onset.shape[0]
    row, column = np.nonzero(~np.isnan(onsets_of(at, cell)))
    track, out = Track(row.size, h), no_cycles(row.size, h)
    still = np.zeros(row.size, np.intp)
    begun = from_onsets(at, cell[column], row)
    follow(
        at,
        Bodies(np.arange(row.size), cell[column], begun, np.zeros(still.size), still),
        track,
        out,
        range(2 * h),
    )
    other = ~((out.row == row) & (np.arange(2 * h + 1)[:, np.newaxis] < out.size)).any(axis=0)
    out.size[other] = 0
    cycles = [no_cycles(cell.size, h) for _ in range(2 * h)]
    for i, of_row in enumerate(cycles):
        own = (row == i).nonzero()[0]
        write(of_row, column[own], read(out, own))
    return cycles


def _here(at: Lanes, bodies: Bodies, orbit: Cycles) -> Cycles:
    """Cycles without rest near the bodies' own; without a slide where there are none."""
    out, valid, _ = without_rest(at, orbit)
    out.size[~valid] = 0
    return out


def _leap(at: Lanes, bodies: Bodies, orbit: Cycles) -> Cycles:
    """Look for cycles without rest far from where bodies are; a cycle without a slide where none is found.

    Starts that link the slides of a body up to a cycle are no cycle where one of them stops too early, or
    starts too late. On the way there the body turns to other slides: they show which ones the cycle consists
    of.
    """
    h = at.onset.shape[0]
    out, _, _ = without_rest(at, orbit)
    with np.errstate(invalid="ignore"):
        way = wrapped(out.start[0] - orbit.start[0] + np.pi) - np.pi
    out.size[:] = 0
    shares, body = np.meshgrid(np.array(_LEAPS), np.arange(way.size), indexing="ij")
    body = body.reshape(-1)
    phase = wrapped(orbit.start[0, body] + shares.reshape(-1) * way[body])
    lane = orbit.lane[0, body]
    inside = values(at.static.take(lane, axis=1), phase) > at.noise[lane]
    body, lane, phase = body[inside], lane[inside], phase[inside]
    if body.size:
        still = np.zeros(body.size, np.intp)
        track, ignored = Track(body.size, h), no_cycles(body.size, h)
        begun = stopped(at, bodies.cell[body], phase, (lane,))
        leapt = Bodies(np.arange(body.size), bodies.cell[body], begun, np.zeros(still.size), still)
        leapt = follow(at, leapt, track, ignored, range(4 * h))
        near = near_cycles(leapt, track, 4 * h)
        going = (near > 0).nonzero()[0]
        there = leapt.number[going]
        found, valid, _ = without_rest(at, track.cut(there, 4 * h - near[going], near[going]))
        good = valid.nonzero()[0]
        write(out, body[there[good]], read(found, good))
    return out
