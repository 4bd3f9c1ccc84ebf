"""What a body on the trough does next: rest until an onset, or slide until it stops or is lifted off.

A rounded phase does not tell on which side of an onset it lies. So each leg says what comes after it, and
that is not asked of the phase again. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Mode
from vibro.core.contact.coast import Coast, Pull, coast, pull_of
from vibro.core.contact.windows import load_amplitude, own_phase
from vibro.core.free import free_motion
from vibro.core.groups import put, take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.slide import Floats
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]
    Modes = NDArray[np.int8]

__all__ = ["Leg", "Track", "after_slide", "contact_leg", "loads_at", "mode_of", "track_of", "until"]

_TURN: Final = 2.0 * np.pi
_ZERO: Final = np.zeros(())

# [rad] The phases of an event and of a body are rounded, so that a body at the event may seem to have just
# missed it, and would wait for a whole turn. This close after an event it counts as being at the event.
_AT_EVENT: Final = 1e-9


def until(event: Floats, phase: Floats) -> Floats:
    """Phase from ``phase`` to the next passage of an event phase, 0 where it is there [rad]."""
    return np.maximum(np.mod(event - phase + _AT_EVENT, _TURN) - _AT_EVENT, 0.0)


class Track(NamedTuple):
    """Scenes with what their motion needs again and again; members 1-D, or 0-d for all.

    Attributes
    ----------
    scene : Loads
        Their groups.
    forward, back : Pull
        Pull and drag of their slides.
    forward_onset, back_onset : array
        Phase at which a body at rest starts to slide; NaN where it never does.
    lift_off : array
        Phase asin(1/K) at which the trough falls away under the body; inf where it never does.
    """

    scene: Loads
    forward: Pull
    back: Pull
    forward_onset: Floats
    back_onset: Floats
    lift_off: Floats


def track_of(scene: Loads) -> Track:
    """Prepare scenes whose body can rest."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        falls_away = scene.normal / scene.across
        return Track(
            scene,
            pull_of(scene, 1),
            pull_of(scene, -1),
            forward_onset=_onset(scene, 1),
            back_onset=_onset(scene, -1),
            lift_off=np.where(falls_away < 1.0, np.arcsin(falls_away), np.inf),
        )


def _onset(scene: Loads, direction: int) -> Floats:
    """Phase at which the load begins to exceed static friction in a direction; NaN where it never does."""
    mu_s = scene.static_friction
    load = load_amplitude(scene, direction, mu_s)
    ratio = (mu_s * scene.normal + direction * scene.tangential) / load
    begins = np.abs(ratio) < 1.0
    if scene.lead:
        return np.where(begins, np.arcsin(ratio) - own_phase(scene, direction, mu_s), np.nan)
    # along a line: where the drive presses the body down more than it pushes, none in contact, Eq. (7)
    zero = 0.0 if direction > 0 else np.pi
    return np.where((load > 0.0) & begins, zero + np.arcsin(ratio), np.nan)


def loads_at(scene: Loads, phase: Floats) -> tuple[Floats, Floats]:
    """Load along the trough, and load on it, of a body in contact."""
    sine = np.sin(phase)
    along = scene.along_sine(phase) if scene.lead else sine
    return scene.along * along - scene.tangential, scene.normal - scene.across * sine


def mode_of(scene: Loads, phase: Floats, velocity: Floats) -> Modes:
    """Tell what a body in contact does: at zero velocity the loads decide."""
    load, normal = loads_at(scene, phase)
    hold = scene.static_friction * normal
    way = np.where(velocity == 0.0, np.where(np.abs(load) > hold, load, 0.0), velocity)
    return np.where(way == 0.0, Mode.REST, np.where(way > 0.0, Mode.FORWARD, Mode.BACK)).astype(np.int8)


class Leg(NamedTuple):
    """One leg in contact.

    Attributes
    ----------
    length : array
        Phase from its start to its end [rad]; inf where it never ends.
    velocity : array
        Relative velocity at its end.
    displacement : array
        Displacement relative to the trough.
    next_mode : int8 array
        What follows, as long as the contact lasts.
    impulse : array
        Normal impulse while it slides, with the sign of its velocity.
    gain : array
        Change of the velocity after the leg per change of it before, in [0, 1], Eq. (26).
    top : array
        Largest speed.
    settled : bool array
        Whether its end was found to rounding.
    """

    length: Floats
    velocity: Floats
    displacement: Floats
    next_mode: Modes
    impulse: Floats
    gain: Floats
    top: Floats
    settled: Bools


def contact_leg(track: Track, mode: Modes, phase: Floats, velocity: Floats, limit: Floats) -> Leg:
    """Follow the bodies through one leg in contact.

    Parameters
    ----------
    track : Track
        Their scenes.
    mode, phase, velocity : array
        Their states; 1-D.
    limit : array
        Phase from here to the end of the contact; inf where there is none.

    Returns
    -------
    Leg
        One element per body.
    """
    n = mode.size
    out = Leg(
        limit.copy(),
        np.zeros(n),
        np.zeros(n),
        np.full(n, Mode.REST, np.int8),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.ones(n, np.bool_),
    )
    for kind, motion in ((Mode.REST, _rest), (Mode.FORWARD, _forward), (Mode.BACK, _back)):
        cells = np.flatnonzero(mode == kind)
        if cells.size == n:
            return motion(track, phase, velocity, limit)
        if cells.size:
            leg = motion(take(track, cells), phase[cells], velocity[cells], limit[cells])
            put(out, cells, leg)
    return out


def _rest(track: Track, phase: Floats, velocity: Floats, limit: Floats) -> Leg:
    """Rest until the nearer onset; whatever came before is forgotten."""
    ahead, behind = (
        np.where(np.isnan(onset), np.inf, until(onset, phase))
        for onset in (track.forward_onset, track.back_onset)
    )
    still = np.zeros(phase.shape)
    next_mode = np.where(ahead <= behind, np.int8(Mode.FORWARD), np.int8(Mode.BACK))
    length = np.minimum(np.minimum(ahead, behind), limit)
    return Leg(length, still, still, next_mode, still, still, still, np.ones(phase.shape, np.bool_))


def _forward(track: Track, phase: Floats, velocity: Floats, limit: Floats) -> Leg:
    return _slide(track, track.forward, 1.0, phase, velocity, limit)


def _back(track: Track, phase: Floats, velocity: Floats, limit: Floats) -> Leg:
    return _slide(track, track.back, -1.0, phase, velocity, limit)


def _slide(track: Track, at: Pull, direction: float, phase: Floats, velocity: Floats, limit: Floats) -> Leg:
    """Slide until the body stops or the contact ends."""
    speed = np.abs(velocity)
    end = coast(at, phase, speed, limit)
    with np.errstate(invalid="ignore"):  # endless slides
        sine, cosine = np.sin(phase), np.cos(phase)
        if track.scene.lead:
            own = np.sin(phase + at.shift), np.cos(phase + at.shift)
        else:
            way = np.where(at.shift > 0.0, -1.0, 1.0)
            own = way * sine, way * cosine
        path, _ = free_motion(at.pull, at.drag, *own, speed, end.length)
        # the impulse of the trough takes the normal speed that the body would have in flight
        _, rate = free_motion(track.scene.across, track.scene.normal, sine, cosine, _ZERO, end.length)
    return after_slide(track.scene, direction, phase, end, path, -rate)


def after_slide(
    scene: Loads, direction: float, phase: Floats, end: Coast, path: Floats, impulse: Floats
) -> Leg:
    """Tell what follows slides whose ends are known: rest, a turn, or flight if they did not stop."""
    with np.errstate(divide="ignore", invalid="ignore"):  # endless slides
        load, normal = loads_at(scene, phase + end.length)
        back_load = -direction * load
        turns = end.stopped & (back_load > scene.static_friction * normal)
        drag = scene.kinetic_friction * normal
        turned = (back_load - drag) / (back_load + drag)
    opposite = np.int8(Mode.BACK if direction > 0.0 else Mode.FORWARD)
    same = np.int8(Mode.FORWARD if direction > 0.0 else Mode.BACK)
    return Leg(
        end.length,
        direction * end.speed,
        direction * path,
        np.where(turns, opposite, np.where(end.stopped, np.int8(Mode.REST), same)),
        direction * impulse,
        np.where(turns, turned, np.where(end.stopped, 0.0, 1.0)),
        end.top,
        end.settled,
    )
