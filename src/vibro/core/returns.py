"""The return map of hopping bodies: from the velocity at a lift-off to that at the next one like it.

The flights are known before the sliding (``bounce.py``). Trajectories cannot cross, only merge, so that the
map never decreases. It is piecewise smooth with a slope of at most 1 (a change of direction under friction,
a rest and an impact all bring velocities closer) and jumps upwards only, where stiction holds one body and
not its neighbour. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.groups import take
from vibro.core.motion import Mode, Track, contact_leg, mode_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.bounce import Bounces
    from vibro.core.groups import Loads
    from vibro.core.slide import Floats

    Bools = NDArray[np.bool_]
    Codes = NDArray[np.int8]
    Words = NDArray[np.int64]

__all__ = ["Cells", "Hops", "Return", "follow", "hops_of", "pattern_text", "velocity_from_rest"]

_TURN: Final = 2.0 * np.pi

_LETTERS: Final = " HFB_"  # by Mode
_MOST_LETTERS: Final = 27  # digits to base 5 in an int64; longer patterns are cut

_MOST_LEGS: Final = 64


def pattern_text(code: int) -> str:
    """Phases of a cycle from their code: H flight, F forward slide, B back slide, _ rest.

    A pattern of more than 27 phases is cut, and ends in ``...``.
    """
    if code < 0:
        return pattern_text(-code) + "..."
    return "" if code == 0 else pattern_text(code // 5) + _LETTERS[code % 5]


class Hops(NamedTuple):
    """What each flight and the impact behind it do to the relative velocity, whatever that is."""

    gain: Floats
    length: Floats
    shift: Floats
    brake: Floats
    high: Floats
    low: Floats


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


def hops_of(scene: Loads, flights: Bounces) -> Hops:
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
    return Hops(gain, s, shift, mu_d * normal * flights.impulse, high, low)


def follow(cells: Cells, hops: Hops, velocity: Floats) -> Return:
    """Follow the bodies through one cycle of their normal motion."""
    n = velocity.size
    out = Return(
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


def _contact(cells: Cells, out: Return, active: NDArray[np.intp]) -> None:
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


def velocity_from_rest(track: Track) -> Floats:
    """Velocity at the first lift-off of a body at rest, which slides forward from its onset, Eq. (34)."""
    start, end, at = track.forward_onset, track.lift_off, track.forward
    velocity: Floats = at.pull * (np.cos(start) - np.cos(end)) - at.drag * (end - start)
    return velocity
