"""Hopping without a cycle that could be told: means over long samples, with their standard errors.

Irregular flights amplify every disturbance until nothing is left of the start, so that rounding, and on a
real trough its noise, chooses the flights. What stays is their statistics. Several bodies are followed side
by side, kicked a little whenever they leave the trough after a contact; the scatter of their means gives the
error. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Mode, Status, is_answered
from vibro.core.contact.legs import track_of
from vibro.core.flight.cycles import HoppingCycles, one_each, unresolved
from vibro.core.flight.drift import has_stop, span_of
from vibro.core.flight.landing import FlightList
from vibro.core.flight.orbits import from_rest
from vibro.core.flight.repeats import single_bounces
from vibro.core.flight.returns import Cells, hops_of, return_map, velocity_from_rest
from vibro.core.flight.samples import BODIES, Sample, fly
from vibro.core.groups import put, take
from vibro.core.roots import OpenCells

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.legs import Track
    from vibro.core.contact.slide import Floats
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]

__all__ = ["AVERAGES"]

_TURN: Final = 2.0 * np.pi

# [1] Ratio of the variance of a body's mean to that expected from its two halves: above which the sample is
# shorter than the memory of the motion, and above which bodies have gone different ways. For halves without
# memory it is F-distributed about 1.
_DRIFTS: Final = 3.0
_PARTED: Final = 8.0
_STUDENT: Final = (BODIES - 1) / (BODIES - 3)  # variance of Student's t for a scatter of so many bodies
# [1] Throw number below which stable cycles of one bounce capture irregular motion within some thousand
# cycles; above it their basins are narrow.
_CAPTURED: Final = 2.0
_MOST_TURNS: Final = 64
_FIRST_REACH: Final = 0.25  # [A w cos alpha] first step in search of the velocity of balance
_BALANCED: Final = 0.1  # [1] imbalance left, over its statistical error
_MOST_STEPS: Final = 24


def averages(scene: Loads, restitution: Floats, length: int, longest: bool) -> HoppingCycles:
    """Mean motion of hopping scenes in which no cycle can be told.

    Parameters
    ----------
    scene : Loads
        Groups of the scenes, 1-D, or 0-d members for all.
    restitution : array
        Their normal coefficients of restitution, 1-D or 0-d.
    length : int
        Events (flights, of which a chain of short bounces counts as one) in each half of the samples.
    longest : bool
        Whether no longer samples are to follow.

    Returns
    -------
    HoppingCycles
        One element per scene: ``AVERAGED``; ``RUNAWAY`` where a body does not stop again; ``UNRESOLVED``
        where a longer sample is needed, or bounces are too many.

    Notes
    -----
    A longer sample is needed where the means of bodies differ by more than the halves of their samples
    explain, and where they remember their velocities for longer than it lasts. Where they differ for good, as
    they have gone different ways or as the size of the kicks decides, the scatter of the bodies is told.
    """
    return one_each(scene, restitution, partial(_means, length=length, longest=longest))


#: Averages over longer and longer samples, with the number of scenes that fit into memory.
AVERAGES: Final = (
    (partial(averages, length=12, longest=False), 384),
    (partial(averages, length=48, longest=False), 96),
    (partial(averages, length=240, longest=True), 24),
)


def _means(scene: Loads, throw: Floats, restitution: Floats, length: int, longest: bool) -> HoppingCycles:
    n = throw.size
    owner = np.repeat(np.arange(n), BODIES)
    sample = fly(take(scene, owner), throw[owner], restitution[owner], np.tile(np.arange(BODIES), n), length)
    track = take(track_of(scene), owner)
    slid, remembers, correction = _slide(track, sample, balance=longest)
    time, aloft = (x[-2:].reshape(2, n, BODIES) for x in (sample.time, sample.aloft))
    paths = (slid.path + correction).reshape(2, n, BODIES)
    total = _over_all(time)
    mean = _over_all(paths) / total
    off = (paths - mean[:, None] * time) * (BODIES / total)[:, None]
    own, halves = off.sum(axis=0).var(axis=1, ddof=1), ((off[0] - off[1]) ** 2).mean(axis=1)
    lands = sample.lands.reshape(n, BODIES).any(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = own / halves
    # Without memory both are the variance of a body's mean.
    variance = np.where(ratio > _DRIFTS, own, 0.5 * (own + halves)) / BODIES
    differ = lands | (ratio > _PARTED)
    variance += np.where(differ, _STUDENT * np.maximum(own - halves, 0.0), 0.0)
    runs, undecided = _running(scene, sample, slid)
    drifts = remembers | (~lands & (ratio > _DRIFTS)) | undecided

    out = unresolved(n)
    ends = sample.ends.reshape(n, BODIES).all(axis=1)
    out.status[ends & (longest | ~drifts)] = Status.AVERAGED
    out.status[ends & (runs | (undecided & longest))] = Status.RUNAWAY
    known = out.status == Status.AVERAGED
    out.pattern[known] = -np.int64(Mode.FLIGHT)
    numbers = (
        _TURN * mean,
        _TURN * np.sqrt(variance),
        np.full(n, np.nan),
        _over_all(aloft) / total,
        scene.normal * sample.impact.reshape(n, BODIES).max(axis=1),
        slid.peak.max(axis=0).reshape(n, BODIES).max(axis=1),
    )
    put(out[2:-1], np.arange(n), tuple(np.where(known, x, np.nan) for x in numbers))
    _lot(scene, throw, restitution, out)
    return out


def _lot(scene: Loads, throw: Floats, restitution: Floats, means: HoppingCycles) -> None:
    """Tell, in place, of bodies that any of several motions may capture.

    At low throw numbers stable cycles of one bounce stand beside the irregular motion and capture it after
    some hundreds or thousands of cycles, nobody knows which of them and when. The mean over all these motions
    is given, with their scatter.
    """
    turns = np.arange(1, _MOST_TURNS + 1)
    phase, _, stable = single_bounces(throw[:, None], restitution[:, None], turns)
    stable &= ((throw < _CAPTURED) & (means.status == Status.AVERAGED))[:, None]
    owner, which = np.nonzero(stable)
    if not owner.size:
        return
    n = owner.size
    length = np.multiply(_TURN, turns[which])
    impact = length / (1.0 + restitution[owner])
    one, none = np.ones(n, np.intp), np.zeros(n)
    flights = FlightList(np.arange(n), one, np.arange(n), phase[stable], length, impact, length)
    loads = take(scene, owner)
    track = take(track_of(scene), owner)
    cells = Cells(track, flights.first, flights.number, none, none)
    start = np.broadcast_to(velocity_from_rest(track), n)
    end = from_rest(cells, hops_of(loads, flights), start, span_of(cells, length))
    found = end.cycle.displacement / turns[which]
    motions = 1 + np.bincount(owner, minlength=throw.size)
    center = (means.displacement + np.bincount(owner, found, throw.size)) / motions
    squares = (means.displacement - center) ** 2
    squares += np.bincount(owner, (found - center[owner]) ** 2, throw.size)
    several = np.unique(owner)
    scatter = squares[several] / (motions[several] - 1)
    means.displacement[several] = center[several]
    means.deviation[several] = np.sqrt(means.deviation[several] ** 2 + scatter)
    share = means.flight_fraction[several]
    means.flight_fraction[several] = 1.0 + (share - 1.0) / motions[several]
    np.maximum.at(means.impact, owner, loads.normal * impact)
    np.maximum.at(means.peak, owner, end.cycle.peak)
    lost = np.flatnonzero(~is_answered(end.status))
    means.status[owner[lost]], means.pattern[owner[lost]] = end.status[lost], 0
    for numbers in means[2:-1]:
        numbers[owner[lost]] = np.nan


def _running(scene: Loads, sample: Sample, slid: _Slid) -> tuple[Bools, Bools]:
    """Tell in which scenes bodies run away, and in which they might, as they have not stopped again.

    Where friction is too weak to hold gravity every flight without a stop adds speed downhill. The drive
    takes no more than twice its own speed from that, and one landing no more than its friction.
    """
    grip = scene.kinetic_friction * scene.normal
    loose = np.broadcast_to(np.abs(scene.tangential) > grip, sample.impact.size // BODIES)
    speed = (-np.sign(scene.tangential) * slid.velocity[1].reshape(-1, BODIES).T).T
    out_of_reach = 2.0 * (scene.along + grip * sample.impact.reshape(-1, BODIES).max(axis=1))
    away = loose & (speed.max(axis=1) > out_of_reach)
    return away, loose & ~away & ~slid.forgets[1].reshape(-1, BODIES).all(axis=1)


def _over_all(halves: Floats) -> Floats:
    """Sum over the halves and the bodies of each scene, of shape (2, scenes, BODIES).

    In one step NumPy would sum in an order that depends on the number of scenes.
    """
    total: Floats = halves.sum(axis=0).sum(axis=1)
    return total


class _Slid(NamedTuple):
    """Bodies followed along the trough through the halves of their samples; all of shape (2, bodies).

    Attributes
    ----------
    path : array
        Displacement.
    gain : array
        Change of the velocity over the ground.
    peak : array
        Largest speed relative to the trough.
    velocity : array
        At the end, relative to the trough.
    forgets : bool array
        Whether the body stops, so that it forgets its velocity.
    """

    path: Floats
    gain: Floats
    peak: Floats
    velocity: Floats
    forgets: Bools


def _follow(track: Track, sample: Sample, bodies: Indices, velocity: Floats) -> _Slid:
    """Follow bodies from their velocities at the start of the sample."""
    none = np.zeros(bodies.size)
    parts = []
    for i in (2, 3):
        part = Cells(take(track, bodies), sample.first[i, bodies], sample.number[i, bodies], none, none)
        leg = return_map(part, sample.hops, velocity)
        scene, turned = part.track.scene, sample.swing[i, bodies]
        # as ``drift`` has it: without a stop gravity and friction alone act
        fall = -scene.tangential * sample.time[i, bodies]
        stops = has_stop(leg)
        gain = np.where(stops, leg.velocity - velocity - scene.along * turned, fall + leg.friction)
        parts.append((leg.displacement, gain, leg.peak, leg.velocity, stops))
        velocity = leg.velocity
    return _Slid(*(np.stack(pair) for pair in zip(*parts, strict=True)))


def _slide(track: Track, sample: Sample, *, balance: bool) -> tuple[_Slid, Bools, Floats]:
    """Slide through the samples; return also which scenes need longer ones, and corrections of the paths.

    Where a body never stops in its sample it is off, the longer the less friction there is, by the error of
    its velocity at the start. All bodies of such a scene get the one velocity over the ground at which
    gravity and friction balance over all their samples. What the balance of each is off by moves that
    velocity, and with it the mean: this is the correction, whose sum is 0. It is left out without
    ``balance``, where longer samples follow.
    """
    everyone = np.arange(sample.impact.size)
    none = np.zeros(everyone.size)
    start = np.broadcast_to(velocity_from_rest(track), everyone.shape)
    lead = Cells(track, sample.first[0], sample.number[0] + sample.number[1], none, none)
    velocity = return_map(lead, sample.hops, start).velocity
    slid = _follow(track, sample, everyone, velocity)
    correction = np.zeros((2, everyone.size))
    bounded = span_of(lead, sample.time[2]).bounded
    remembers = (bounded & ~slid.forgets.all(axis=0)).reshape(-1, BODIES)
    needs_longer: Bools = np.asarray(remembers.any(axis=1))
    long = np.flatnonzero(needs_longer)
    if long.size and balance:
        bodies = (long[:, None] * BODIES + np.arange(BODIES)).reshape(-1)
        found, moved = _balanced(track, sample, bodies, velocity[bodies])
        for whole, part in zip(slid, found, strict=True):
            whole[:, bodies] = part
        correction[:, bodies] = moved
    return slid, needs_longer, correction


def _balanced(track: Track, sample: Sample, bodies: Indices, velocity: Floats) -> tuple[_Slid, Floats]:
    """Give the bodies of each scene the same velocity over the ground, that of balance.

    The sum of what they gain falls with it. Bracket the zero, and go on by false position and halving in turn
    until less than a tenth of its statistical error is left.
    """
    along = np.broadcast_to(track.scene.along, sample.impact.shape)
    trough = (along * sample.trough)[bodies].reshape(-1, BODIES)
    n = trough.shape[0]
    out = _follow(track, sample, bodies, velocity)
    correction = np.zeros((2, bodies.size))
    ground = (velocity.reshape(n, BODIES) + trough).mean(axis=1)
    low, high = (np.full((3, n), np.nan) for _ in range(2))  # velocity, gain and path on each side
    reach = _FIRST_REACH * along[bodies].reshape(n, BODIES)[:, 0]
    left = OpenCells(np.arange(n), (ground, reach), _MOST_STEPS)
    for step, (scenes, (ground, reach)) in enumerate(left):
        place = (scenes[:, None] * BODIES + np.arange(BODIES)).reshape(-1)
        start = (ground[:, None] - trough[scenes]).reshape(-1)
        slid = _follow(track, sample, bodies[place], start)
        gain, path = (x.sum(axis=0).reshape(-1, BODIES) for x in (slid.gain, slid.path))
        here = np.stack((ground, gain.sum(axis=1), path.sum(axis=1)))
        rises = here[1] > 0.0
        low[:, scenes[rises]], high[:, scenes[~rises]] = here[:, rises], here[:, ~rises]
        below, above = low[:, scenes], high[:, scenes]
        enclosed = np.isfinite(below[0] + above[0])
        scatter = np.sqrt((gain * gain).sum(axis=1))
        done = enclosed & (np.abs(here[1]) <= _BALANCED * scatter)
        for whole, part in zip(out, slid, strict=True):
            whole[:, place] = part
        with np.errstate(divide="ignore", invalid="ignore"):
            effect = np.where(enclosed, (above[2] - below[2]) / (above[1] - below[1]), 0.0)
            share = 0.5 if step % 3 == 2 else below[1] / (below[1] - above[1])
        correction[:, place] = -np.repeat(effect, BODIES) * slid.gain
        inside = below[0] + share * (above[0] - below[0])
        onward = np.where(enclosed, inside, np.where(rises, ground + reach, ground - reach))
        left.keep(~done, (onward, 2.0 * reach))
    return out, correction
