"""Return map of hopping bodies: from the velocity at a lift-off to that at the next one like it, Eq. (36).

The normal motion does not depend on sliding, so that the flights of a cycle are known before
(``bounces.py``). Trajectories cannot cross, only merge: the map never decreases. It is piecewise smooth
with a slope of at most 1, as a turn under friction, a rest and an impact all bring velocities closer, and
jumps upwards only, where static friction holds one body and not its neighbour. Lengths in A, speeds in A w,
phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.bounces import Flights
from vibro.core.buffers import Doubles
from vibro.core.cells import number_of_nodes
from vibro.core.codes import MOST_LETTERS, Mode
from vibro.core.drives import Loads, along_cosine, mix_of, normal_load, phase_difference
from vibro.core.elementary import PI, TURN, braked, free_motion, wrap
from vibro.core.flight import BOUNCE
from vibro.core.legs import Track, contact_leg, mode_of, next_lift_off
from vibro.core.waves import (
    FORCE,
    SINE,
    at_break,
    depart,
    moved,
    nodes_of,
)

__all__ = [
    "CLOSE", "MOST_LEGS", "Hops", "Release", "Return", "is_chained", "landed", "no_hops", "release",
    "return_map", "with_same_ground_speed", "write_hop", "write_hops",
]  # fmt: skip

#: [1] Legs of one contact, which lasts less than a drive cycle: four and more for each harmonic, or piece.
MOST_LEGS: Final = 20_000
#: [rad] An onset this close to the lift-off is at it: where a load jumps both are at the same phase.
CLOSE: Final = 1e-14
# Of marks: two numbers without a common divisor, whose product an int64 has room for; the second is prime.
_RADIX: Final = 131
_MARKS: Final = 2**55 - 55
_FULL: Final = 5 ** (MOST_LETTERS - 1)  # [1] a pattern from here on has no room for another digit


_NONE: Doubles = memoryview(b"").cast("d")


class Hops(NamedTuple):
    """What each flight and the impact after it do to the relative velocity, whatever that is.

    Scratch memory of one scene; one row per flight.

    Attributes
    ----------
    gain, length, shift : Doubles
        Velocity added in flight, duration [rad], and displacement that this velocity adds.
    brake : Doubles
        Largest change of velocity by friction in the impact, Eq. (31).
    high, low : Doubles
        Extremes of the velocity added on the way, 0 at take-off included.
    landing, rest : Doubles
        Phase at which a contact amid the flights begins, and its duration; 0 where the body takes off at
        once. The contact at the end of a cycle is an argument of ``return_map``.
    """

    gain: Doubles
    length: Doubles
    shift: Doubles
    brake: Doubles
    high: Doubles
    low: Doubles
    landing: Doubles
    rest: Doubles


def no_hops() -> Hops:
    """Stand for the flights of a cycle without any."""
    return Hops(_NONE, _NONE, _NONE, _NONE, _NONE, _NONE, _NONE, _NONE)


class Return(NamedTuple):
    """One cycle from a given velocity at its first lift-off.

    Attributes
    ----------
    velocity : float
        Relative velocity at the next such lift-off.
    slope : float
        Its derivative, in [0, 1]; 0 where the body stops on the way and so forgets its velocity.
    friction : float
        Change of the velocity by friction, as long as the body does not stop.
    displacement, peak : float
        Displacement, and largest speed.
    delay : float
        Derivative of the displacement with respect to the velocity at the start.
    pattern : int
        Legs of the cycle, as digits of ``Mode`` to base 5; of more than ``MOST_LETTERS`` legs a negative mark
        of all of them.
    settled : bool
        Whether every slide was solved.
    """

    velocity: float
    slope: float
    friction: float
    displacement: float
    peak: float
    delay: float
    pattern: int
    settled: bool


def write_hop(loads: Loads, phase: float, length: float, impulse: float, hops: Hops, row: int) -> None:
    """Integrate the free motion along the trough over one flight, Eq. (30), into a row of ``hops``.

    Parameters
    ----------
    loads : Loads
        Groups of the scene.
    phase, length : float
        Take-off phase and duration of the flight [rad].
    impulse : float
        Normal impulse of its landing [A w n].
    hops : Hops
        Written at ``row``, without a contact after the landing.
    row : int
        Where.
    """
    if loads.waves.kind != SINE:
        _write_over_waves(loads, phase, length, impulse, hops, row)
        return
    a, t = loads.drive_tangential, loads.weight_tangential
    p = phase - phase_difference(loads)
    sine, cosine = math.sin(p), math.cos(p)
    flown = free_motion(a, t, sine, cosine, 0.0, length)
    high, low = max(flown.velocity, 0.0), min(flown.velocity, 0.0)
    # Inside the flight the velocity is extreme where the load along the trough changes sign. Minima, and
    # maxima, change monotonically from one turn to the next: the first and the last of each suffice.
    if abs(t) < a:
        kappa = math.asin(t / a)
        for i in range(2):
            first = wrap((PI - kappa if i == 0 else kappa) - p)
            if first <= length:
                v = free_motion(a, t, sine, cosine, 0.0, first).velocity
                high, low = max(high, v), min(low, v)
                last = first + TURN * math.floor((length - first) / TURN)
                if last > first:
                    v = free_motion(a, t, sine, cosine, 0.0, last).velocity
                    high, low = max(high, v), min(low, v)
    _write(loads, flown.velocity, length, flown.path, impulse, hops, row)
    hops.high[row] = high
    hops.low[row] = low


def write_hops(loads: Loads, flights: Flights, hops: Hops, first: int, last: int) -> None:
    """Integrate the motion along the trough over flights and the contacts after them, into the same rows."""
    for row in range(first, last):
        write_hop(loads, flights.phase[row], flights.length[row], flights.impulse[row], hops, row)
        hops.landing[row], hops.rest[row] = flights.landing[row], flights.rest[row]


def _write_over_waves(
    loads: Loads, phase: float, length: float, impulse: float, hops: Hops, row: int
) -> None:
    """Do the same for a drive beyond one harmonic; extremes lie where the load along changes its sign."""
    waves, mix = loads.waves, mix_of(loads, FORCE)
    phase = wrap(phase)
    value = depart(waves, mix, phase).load
    flown = moved(waves, mix, phase, value, length)
    high, low = max(flown.velocity, 0.0), min(flown.velocity, 0.0)
    for i in range(number_of_nodes(waves, FORCE)):
        first = wrap(waves.number[nodes_of(waves, FORCE) + i] - phase)
        last = first + TURN * math.floor((length - first) / TURN)
        for k in range(2):
            s = first if k == 0 else last
            if s <= length and (k == 0 or last > first):
                v = moved(waves, mix, phase, value, s).velocity
                high, low = max(high, v), min(low, v)
    _write(loads, flown.velocity, length, flown.path, impulse, hops, row)
    hops.high[row] = high
    hops.low[row] = low


def _write(
    loads: Loads, gain: float, length: float, shift: float, impulse: float, hops: Hops, row: int
) -> None:
    """Put what a flight does into a row, without a contact after the landing."""
    hops.gain[row] = gain
    hops.length[row] = length
    hops.shift[row] = shift
    hops.brake[row] = loads.kinetic_friction * loads.weight_normal * impulse
    hops.landing[row] = 0.0
    hops.rest[row] = 0.0


def return_map(
    track: Track, hops: Hops, first: int, last: int, landing: float, rest: float, velocity: float
) -> Return:
    """Follow a body through one cycle of its normal motion.

    Parameters
    ----------
    track : Track
        Scene.
    hops : Hops
        Its flights.
    first, last : int
        Rows of the flights of the cycle: from ``first`` to before ``last``.
    landing, rest : float
        Phase at which the contact after the last flight begins, and its duration, 0 without one [rad].
    velocity : float
        Relative velocity at the first take-off.

    Returns
    -------
    Return
        The cycle.
    """
    out = Return(velocity, 1.0, 0.0, 0.0, abs(velocity), 0.0, 0, True)
    for row in range(first, last):
        v = out.velocity
        top = max(abs(v + hops.high[row]), abs(v + hops.low[row]))
        path = v * hops.length[row] + hops.shift[row]
        v = landed(hops, row, v)
        out = Return(
            v,
            out.slope if abs(v) > 0.0 else 0.0,
            out.friction - math.copysign(hops.brake[row], v),
            out.displacement + path,
            max(out.peak, top),
            out.delay + out.slope * hops.length[row],
            _with_flight(track, out.pattern, hops.length[row]),
            out.settled,
        )
        if hops.rest[row] > 0.0:
            out = _contact(track, out, hops.landing[row], hops.rest[row], track.landed_friction)
    if rest > 0.0:
        out = _contact(track, out, landing, rest, track.landed_friction)
    return out


def landed(hops: Hops, row: int, velocity: float) -> float:
    """Return the velocity after a flight and its impact; one that the impact stops keeps its sign."""
    return braked(velocity + hops.gain[row], hops.brake[row])


def _contact(track: Track, out: Return, landing: float, rest: float, friction: float) -> Return:
    """Slide and rest from a landing until the lift-off; ``friction`` holds a body that stands there."""
    phase, left = landing, rest
    mode = mode_of(track.loads, landing, out.velocity, friction)
    for _ in range(MOST_LEGS):
        leg = contact_leg(track, mode, phase, out.velocity, left)
        out = Return(
            leg.velocity,
            out.slope * leg.gain,
            out.friction - track.loads.kinetic_friction * leg.impulse,
            out.displacement + leg.displacement,
            max(out.peak, leg.top),
            out.delay + out.slope * leg.length,
            _append(out.pattern, mode),
            out.settled and leg.settled,
        )
        if not leg.length < left - CLOSE:
            return out
        phase, left, mode = at_break(track.loads.waves, phase + leg.length), left - leg.length, leg.next_mode
    return out._replace(settled=False)


def is_chained(track: Track, before: int, length: float) -> bool:
    """Return whether a flight is one with the leg before it, as a chain of short ones is one flight.

    A trough that moves along a sine has no such chains.
    """
    return track.loads.waves.kind != SINE and length < BOUNCE and before == Mode.FLIGHT


def _with_flight(track: Track, pattern: int, length: float) -> int:
    """Append a flight."""
    return pattern if is_chained(track, abs(pattern) % 5, length) else _append(pattern, Mode.FLIGHT)


def _append(pattern: int, digit: int) -> int:
    """Append a leg to a pattern; one that is full turns into a mark, whose last digit is still the leg's."""
    if 0 <= pattern < _FULL:
        return 5 * pattern + digit
    return -(5 * (1 + _RADIX * (abs(pattern) % _MARKS) % _MARKS) + digit)


class Release(NamedTuple):
    """How a body that is released at rest, at phase 0 of the trough's motion along itself, first takes off.

    Attributes
    ----------
    aloft : bool
        Whether the trough cannot bear it there, so that it takes off at once.
    phase : float
        Phase of the take-off: that of the release if ``aloft``, else the lift-off [rad].
    velocity : float
        Relative velocity along the trough at the take-off.
    """

    aloft: bool
    phase: float
    velocity: float


def release(track: Track) -> Release:
    """Follow a body from its release until it takes off; K > 1.

    Along a line phase 0 is followed by a rest until the forward onset, and by the slide of Eq. (35). On an
    elliptical trough the body may slide either way, and more than once. Where K sin(phi) > 1 it takes off at
    once, with the trough's velocity; the flight of one at the lift-off phase itself begins there.
    """
    loads, at = track.loads, track.forward
    if loads.line:
        start, end = track.forward_onset, track.lift_off
        velocity = 0.0
        if start < end:
            velocity = at.amplitude * (math.cos(start) - math.cos(end)) - at.drag * (end - start)
        return Release(False, end, velocity)
    phase = phase_difference(loads)
    begins = next_lift_off(track, phase)
    if begins.wait == 0.0:
        return Release(False, begins.phase, 0.0)
    if normal_load(loads, phase) < 0.0:
        return Release(True, wrap(phase), 0.0)
    at_rest = Return(0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0, True)
    slid = _contact(track, at_rest, phase, begins.wait, loads.static_friction)
    return Release(False, begins.phase, slid.velocity)


def with_same_ground_speed(loads: Loads, velocity: float, phase: float, other: float) -> float:
    """Return the velocity relative to the trough of the same velocity over the ground, at another phase."""
    if phase == other:
        return velocity
    return velocity + loads.drive_tangential * (along_cosine(loads, phase) - along_cosine(loads, other))
