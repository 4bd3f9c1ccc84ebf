"""Bodies followed from leg to leg: rest, slide, flight, each with the state that it hands over.

The state keeps the drive cycles completed and a phase in [0, 2 pi), so that no phase grows with time, and
says what the body does from there on: a rest ends at the onset itself, so that rounding cannot send the
body back to rest. Lengths in A, speeds in A w, normal speeds over n = cos(beta)/G [A w n], phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Mode
from vibro.core.contact.legs import Leg, Track, contact_leg, mode_of, track_of
from vibro.core.contact.onset import Margins, thresholds
from vibro.core.contact.slide import Onset, slide, start_inside
from vibro.core.contact.starts import resting_start
from vibro.core.contact.windows import load_amplitude, own_phase
from vibro.core.flight.landing import after_landing
from vibro.core.flight.trajectory import ONE_CYCLE, Flight, flight, lift_off_flight
from vibro.core.free import free_motion
from vibro.core.groups import each, put, take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]
    Counts = NDArray[np.int64]
    Modes = NDArray[np.int8]

__all__ = [
    "Course",
    "State",
    "Step",
    "course_of",
    "starting",
    "step",
    "tangential_motion",
]

_TURN: Final = 2.0 * np.pi


class Course(NamedTuple):
    """Scenes with what a walk through them needs; members 1-D.

    Attributes
    ----------
    track : Track
        Onsets, pulls and lift-off phases; the lift-off is inf where the body never hops.
    margins : Margins
        Distances from slipping, for slides from rest.
    rests : bool array
        Whether friction can hold a body on the trough at all.
    throw, restitution : array
        K and e.
    """

    track: Track
    margins: Margins
    rests: Bools
    throw: Floats
    restitution: Floats


class State(NamedTuple):
    """Bodies at the start of a leg.

    Attributes
    ----------
    cycle : int64 array
        Drive cycles completed.
    phase : array
        Phase of the trough's motion normal to itself, in [0, 2 pi) [rad].
    mode : int8 array
        What they do from here on.
    position, velocity : array
        Relative to the trough.
    rate : array
        Normal speed of a take-off [A w n], 0 in contact.
    """

    cycle: Counts
    phase: Floats
    mode: Modes
    position: Floats
    velocity: Floats
    rate: Floats


class Step(NamedTuple):
    """One leg of each body, and what follows it.

    Attributes
    ----------
    length : array
        Phase from its start to its end [rad]; inf where it never ends, and the rest is NaN.
    displacement : array
        Displacement during it.
    velocity : array
        Relative velocity at its end, before an impact.
    impact : array
        Speed towards the trough at its end, 0 in contact [A w n].
    gain : array
        Change of the velocity after the leg per change of it before, in [0, 1].
    after : State
        The start of the next leg.
    """

    length: Floats
    displacement: Floats
    velocity: Floats
    impact: Floats
    gain: Floats
    after: State


def course_of(scene: Loads, restitution: Floats) -> Course:
    """Prepare scenes, 1-D."""
    n = np.broadcast(*scene.flattened(), restitution).size
    scene = each(scene, lambda x: np.broadcast_to(x, n))
    at = thresholds(scene)
    track = track_of(scene)
    rests = np.abs(scene.tangential) < scene.static_friction * scene.normal
    onsets = []
    with np.errstate(divide="ignore", invalid="ignore"):
        for direction, slips, coarse in (
            (1, at.forward, track.forward_onset),
            (-1, at.back, track.back_onset),
        ):
            crest = _crest(scene, direction)
            sharp = np.where(slips, crest - resting_start(scene, at.margins, direction).onset.c, np.nan)
            onsets.append(np.mod(np.where(rests, sharp, coarse), _TURN))
        throw: Floats = scene.across / scene.normal
    track = track._replace(
        forward_onset=onsets[0],
        back_onset=onsets[1],
        lift_off=np.where(at.hops, track.lift_off, np.inf),
    )
    return Course(track, at.margins, rests, throw, np.broadcast_to(restitution, n))


def _crest(scene: Loads, direction: int) -> Floats:
    """Phase at which the load of slides in a direction is largest."""
    if scene.lead:
        return np.asarray(0.5 * np.pi - own_phase(scene, direction))
    return np.array((1.0 if direction > 0 else 3.0) * 0.5 * np.pi)


def starting(course: Course, phase: Floats, velocity: Floats) -> State:
    """Bodies on the trough at a drive phase with a velocity; where the load is negative they leave."""
    if lead := course.track.scene.lead:
        phase = phase + lead.angle
    turns = np.floor(phase / _TURN)
    phase = phase - _TURN * turns
    mode = mode_of(course.track.scene, phase, velocity)
    aloft = np.isfinite(course.track.lift_off) & (course.throw * np.sin(phase) > 1.0)
    zero = np.zeros(phase.shape)
    return State(
        np.zeros(phase.shape, np.int64),
        phase,
        np.where(aloft, np.int8(Mode.FLIGHT), mode),
        zero,
        velocity.astype(np.float64),
        zero.copy(),
    )


def step(course: Course, now: State) -> Step:
    """Follow bodies through one leg.

    Parameters
    ----------
    course : Course
        Their scenes.
    now : State
        Where they are.

    Returns
    -------
    Step
        One element per body.
    """
    aloft = now.mode == Mode.FLIGHT
    if not aloft.any():
        return _in_contact(course, now)
    if aloft.all():
        return _in_flight(course, now)
    n = aloft.size
    after = State._make(np.empty_like(x) for x in now)
    out = Step(np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), after)
    for which, motion in ((aloft, _in_flight), (~aloft, _in_contact)):
        cells = np.flatnonzero(which)
        *numbers, after = motion(take(course, cells), take(now, cells))
        put(out[:-1], cells, tuple(numbers))
        put(out.after, cells, after)
    return out


def _advanced(cycle: Counts, phase: Floats) -> tuple[Counts, Floats]:
    """Reduce a phase to [0, 2 pi)."""
    turns = np.floor(phase / _TURN)
    with np.errstate(invalid="ignore"):
        phase = phase - _TURN * turns
    whole = np.where(np.isfinite(turns), turns, 0.0)
    return cycle + whole.astype(np.int64), phase


def _in_contact(course: Course, now: State) -> Step:
    track = course.track
    with np.errstate(invalid="ignore"):
        limit = np.where(np.isinf(track.lift_off), np.inf, np.mod(track.lift_off - now.phase, _TURN))
    leg = _sharpened(course, now, contact_leg(track, now.mode, now.phase, now.velocity, limit))
    leaves = (leg.length >= limit) & np.isfinite(limit)
    end = now.phase + leg.length
    cycle, phase = _advanced(now.cycle, end)
    mode = np.where(leaves, np.int8(Mode.FLIGHT), leg.next_mode)
    # a rest ends at the onset itself, a contact at the lift-off itself
    waits = now.mode == Mode.REST
    for which, exact in (
        (waits & (mode == Mode.FORWARD), track.forward_onset),
        (waits & (mode == Mode.BACK), track.back_onset),
        (leaves, track.lift_off),
    ):
        cells = np.flatnonzero(which & np.isfinite(leg.length))
        if cells.size:
            cycle[cells] += np.rint((phase[cells] - exact[cells]) / _TURN).astype(np.int64)
            phase[cells] = exact[cells]
    after = State(cycle, phase, mode, now.position + leg.displacement, leg.velocity, np.zeros(phase.shape))
    return Step(leg.length, leg.displacement, leg.velocity, np.zeros(phase.shape), leg.gain, after)


def _sharpened(course: Course, now: State, leg: Leg) -> Leg:
    """Solve slides from rest by the form that does not cancel for short ones."""
    scene, track = course.track.scene, course.track
    for direction, mode, onset in (
        (1, Mode.FORWARD, track.forward_onset),
        (-1, Mode.BACK, track.back_onset),
    ):
        cells = np.flatnonzero(
            (now.mode == mode) & (now.velocity == 0.0) & course.rests & np.isinf(track.lift_off)
        )
        if not cells.size:
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            start = resting_start(take(scene, cells), take(course.margins, cells), direction)
        phase, crest = now.phase[cells], _crest(take(scene, cells), direction)
        inside = start_inside(np.mod(crest - phase + np.pi, _TURN) - np.pi, start.onset.k)
        at_onset = phase == onset[cells]
        begin = Onset(*(np.where(at_onset, a, b) for a, b in zip(start.onset, inside, strict=True)))
        end = slide(begin)
        good = end.settled & np.isfinite(end.x)
        cells = cells[good]
        leg.length[cells] = 2.0 * end.x[good]
        leg.displacement[cells] = direction * (start.load * end.reach)[good]
    return leg


def tangential_motion(scene: Loads, mode: Modes) -> tuple[Floats, Floats, Floats]:
    """Pull and drag along the trough of slides and flights, and what makes a phase that of the pull."""
    way = np.where(mode == Mode.FORWARD, 1.0, np.where(mode == Mode.BACK, -1.0, 0.0))
    grip = way * scene.kinetic_friction
    drag = scene.tangential + grip * scene.normal
    if not scene.lead:
        return scene.along + grip * scene.across, drag, np.zeros(())
    sign, friction = np.where(way < 0.0, -1.0, 1.0), np.abs(grip)
    return sign * load_amplitude(scene, sign, friction), drag, own_phase(scene, sign, friction)


def _in_flight(course: Course, now: State) -> Step:
    scene, throw = course.track.scene, course.throw
    hop = _flight(course, now)
    touch = now.phase + hop.length
    after = after_landing(throw, touch, hop.impact, course.restitution)
    length = hop.length + after.length
    sine, cosine = scene.along_sine(now.phase), scene.along_cosine(now.phase)
    path, velocity = free_motion(scene.along, scene.tangential, sine, cosine, now.velocity, length)
    left = np.maximum(np.abs(velocity) - scene.kinetic_friction * scene.normal * after.impulse, 0.0)
    slowed = np.where(velocity < 0.0, -left, left)
    cycle, phase = _advanced(now.cycle, touch + after.length)
    mode = np.where(after.contact, mode_of(scene, phase, slowed), np.int8(Mode.FLIGHT))
    then = State(cycle, phase, mode, now.position + path, slowed, after.take_off)
    return Step(length, path, velocity, hop.impact, (left > 0.0).astype(np.float64), then)


def _flight(course: Course, now: State) -> Flight:
    """Fly; a take-off from rest on the trough at the lift-off phase has the sharper solution."""
    out = Flight(np.empty(now.phase.shape), np.empty(now.phase.shape))
    c = np.sqrt((course.throw - 1.0) * (course.throw + 1.0))
    lifted = (now.rate == 0.0) & (now.phase == course.track.lift_off)
    short = np.flatnonzero(lifted & (c <= ONE_CYCLE))
    put(out, short, lift_off_flight(c[short]))
    rest = np.flatnonzero(~lifted | (c > ONE_CYCLE))
    if rest.size:
        put(out, rest, flight(course.throw[rest], now.phase[rest], now.rate[rest]))
    return out
