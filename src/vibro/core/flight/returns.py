"""The return map of hopping bodies: from the velocity at a lift-off to that at the next one like it.

The flights are known before the sliding (``bounces.py``). Trajectories cannot cross, only merge, so that the
map never decreases, Eq. (36). It is piecewise smooth with a slope of at most 1 (a change of direction under
friction, a rest and an impact all bring velocities closer) and jumps upwards only, where stiction holds one
body and not its neighbour. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import MOST_LETTERS, Mode
from vibro.core.contact.legs import Track, contact_leg, mode_of, until
from vibro.core.free import free_motion
from vibro.core.groups import each, take
from vibro.core.roots import OpenCells

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.flight.landing import FlightList
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]
    Words = NDArray[np.int64]

__all__ = [
    "Cells",
    "Hops",
    "Return",
    "after_stops",
    "hops_of",
    "return_map",
    "velocity_from_rest",
]

_TURN: Final = 2.0 * np.pi
_ZERO: Final = np.zeros(())

_MOST_LEGS: Final = 64


class Hops(NamedTuple):
    """What each flight and the impact after it do to the relative velocity, whatever that is.

    ``gain`` and ``shift`` are velocity and displacement added in flight, ``brake`` is the most that friction
    takes off in the impact, ``high`` and ``low`` are the extremes of the velocity added on the way. A contact
    that follows begins at ``landing`` and lasts ``rest``; that at the end of a cycle is told in ``Cells``.
    """

    gain: Floats
    length: Floats
    shift: Floats
    brake: Floats
    high: Floats
    low: Floats
    landing: Floats = _ZERO
    rest: Floats = _ZERO


_NO_HOPS: Final = Hops(*np.zeros((6, 0)))


class Cells(NamedTuple):
    """Scenes under way: their flights in the arrays of ``Hops``, and their contact."""

    track: Track
    first: NDArray[np.intp]
    number: NDArray[np.intp]
    landing: Floats
    rest: Floats


class Return(NamedTuple):
    """One cycle from a given velocity at its first lift-off.

    Attributes
    ----------
    velocity : array
        Relative velocity at the next such lift-off.
    slope : array
        Its derivative.
    friction : array
        What friction adds to the velocity.
    displacement, peak : array
        Displacement, and largest speed.
    pattern : int64 array
        Legs of the cycle.
    settled : bool array
        Whether every slide was solved.
    """

    velocity: Floats
    slope: Floats
    friction: Floats
    displacement: Floats
    peak: Floats
    pattern: Words
    settled: Bools


def hops_of(scene: Loads, flights: FlightList) -> Hops:
    """Integrate the free motion along the trough over each flight, Eq. (30)."""
    scene = take(scene, flights.owner)
    along, tangential = scene.along, scene.tangential
    s, p = flights.length, flights.phase - scene.lead.angle if scene.lead else flights.phase
    sine, cosine = np.sin(p), np.cos(p)
    shift, gain = free_motion(along, tangential, sine, cosine, _ZERO, s)
    high, low = np.maximum(gain, 0.0), np.minimum(gain, 0.0)
    # extremes inside the flight: where the tangential load changes sign
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = np.arcsin(np.clip(tangential / along, -1.0, 1.0))
    for extreme in (np.pi - kappa, kappa):
        nearest = np.mod(extreme - p, _TURN)
        last = nearest + _TURN * np.floor((s - nearest) / _TURN)
        for at in (nearest, last):
            _, v = free_motion(along, tangential, sine, cosine, _ZERO, at)
            inside = (at >= 0.0) & (at <= s)
            high = np.where(inside, np.maximum(high, v), high)
            low = np.where(inside, np.minimum(low, v), low)
    return Hops(gain, s, shift, scene.kinetic_friction * scene.normal * flights.impulse, high, low)


def return_map(cells: Cells, hops: Hops, velocity: Floats) -> Return:
    """Follow the bodies through one cycle of their normal motion."""
    n = velocity.size
    out = Return(
        velocity.copy(),
        np.ones(n),
        np.zeros(n),
        np.zeros(n),
        np.abs(velocity),
        np.zeros(n, np.int64),
        np.ones(n, np.bool_),
    )
    for j in range(int(cells.number.max(initial=0))):
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
        out.friction[flying] -= np.copysign(hop.brake, v)
        out.pattern[flying] = _append(out.pattern[flying], np.int64(Mode.FLIGHT))
        if hop.rest.ndim:
            stays = np.flatnonzero(hop.rest > 0.0)
            _contact(cells.track, out, flying[stays], hop.landing[stays], hop.rest[stays])
    on_trough = np.flatnonzero(cells.rest > 0.0)
    _contact(cells.track, out, on_trough, cells.landing[on_trough], cells.rest[on_trough])
    return out


def _contact(track: Track, out: Return, on_trough: NDArray[np.intp], landing: Floats, rest: Floats) -> None:
    """Slide and rest from a landing to the lift-off."""
    if not on_trough.size:
        return
    track = take(track, on_trough)
    velocity = out.velocity[on_trough]
    mode = mode_of(track.scene, landing, velocity)
    going = OpenCells(on_trough, (track, landing, rest, velocity, mode), _MOST_LEGS)
    for at, (track, phase, left, velocity, mode) in going:
        leg = contact_leg(track, mode, phase, velocity, left)
        out.pattern[at] = _append(out.pattern[at], mode.astype(np.int64))
        out.displacement[at] += leg.displacement
        out.peak[at] = np.maximum(out.peak[at], leg.top)
        out.slope[at] *= leg.gain
        out.friction[at] -= track.scene.kinetic_friction * leg.impulse
        out.settled[at] &= leg.settled
        out.velocity[at] = leg.velocity
        state = phase + leg.length, left - leg.length, leg.velocity, leg.next_mode
        going.keep(leg.length < left, (track, *state))
    out.settled[going.cells] = False


def after_stops(cells: Cells, hops: Hops) -> tuple[NDArray[np.intp], Floats]:
    """Velocities at lift-off after the last stop in a cycle, wherever that can be.

    Parameters
    ----------
    cells : Cells
        The scenes.
    hops : Hops
        Their flights.

    Returns
    -------
    owner : int array
        Scene of each velocity; a scene may have many. Along a line a rest that ends at the forward onset is
        left to ``velocity_from_rest``.
    velocity : array
        At the lift-off that follows an impact, or a rest until an onset, without another stop.
    """
    number = cells.number
    owner = np.repeat(np.arange(number.size), number)
    impact = 1 + np.arange(owner.size) - np.repeat(np.cumsum(number) - number, number)
    behind = take(cells, owner)
    behind = behind._replace(first=behind.first + impact, number=behind.number - impact)
    stopped = return_map(behind, hops, np.zeros(owner.size))
    last = np.flatnonzero(stopped.slope > 0.0)
    owners, velocities = [owner[last]], [stopped.velocity[last]]

    track = cells.track
    for waits in (track.forward_onset, track.back_onset) if track.scene.lead else (track.back_onset,):
        onset = np.mod(np.broadcast_to(waits, number.shape), _TURN)
        with np.errstate(invalid="ignore"):
            rests = np.flatnonzero(until(onset, cells.landing) < cells.rest)
        behind = take(cells, rests)
        left = until(behind.track.lift_off, onset[rests])
        behind = behind._replace(number=np.zeros(rests.size, np.intp), landing=onset[rests], rest=left)
        owners.append(rests)
        velocities.append(return_map(behind, hops, np.zeros(rests.size)).velocity)
    return np.concatenate(owners), np.concatenate(velocities)


def _append(pattern: Words, digit: Words | np.int64) -> Words:
    """Append a leg to a pattern; once an int64 is full the pattern turns negative and stays as it is."""
    full = np.abs(pattern) >= 5 ** (MOST_LETTERS - 1)
    return np.where(full, -np.abs(pattern), 5 * pattern + digit)


def velocity_from_rest(track: Track) -> Floats:
    """Velocity at the first lift-off of a body at rest, Eq. (35)."""
    if track.scene.lead:
        return _followed_from_rest(track)
    start, end, at = track.forward_onset, track.lift_off, track.forward
    velocity: Floats = at.pull * (np.cos(start) - np.cos(end)) - at.drag * (end - start)
    return velocity


def _followed_from_rest(track: Track) -> Floats:
    """Velocity at the first lift-off of a body at rest at drive phase 0, of elliptical drives.

    It may slide either way, and more than once. Where the trough falls away under it at that phase, it is
    taken to rest until the trough bears it again.
    """
    scene = track.scene
    assert scene.lead is not None
    n = np.broadcast(*scene.flattened()).size
    track = each(track, lambda x: np.broadcast_to(x, n))
    begin, bears = np.broadcast_to(scene.lead.angle, n), np.pi - track.lift_off
    begin = np.where(np.sin(begin) > np.sin(bears), bears, begin)
    rest = np.mod(track.lift_off - begin, _TURN)
    none = np.zeros(n)
    cells = Cells(track, np.zeros(n, np.intp), np.zeros(n, np.intp), begin, rest)
    return return_map(cells, _NO_HOPS, none).velocity
