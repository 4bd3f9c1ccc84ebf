"""Mean motion of a body whose hopping does not repeat: long samples, with the standard error of their mean.

Irregular flights amplify every disturbance until nothing is left of the start, so that rounding, and on a
real trough its noise, chooses the flights. What stays is their statistics. Several bodies are followed, each
kicked a little whenever it leaves the trough after a contact; the scatter of their means gives the error.
Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.bounces import Flights, single_bounce
from vibro.core.buffers import BODIES, Doubles, Integers
from vibro.core.captures import captures
from vibro.core.codes import Status
from vibro.core.elementary import INF, NAN, TURN
from vibro.core.flight import bed_of
from vibro.core.legs import Track
from vibro.core.orbits import has_stop, hopping_cycle, orbit_from
from vibro.core.return_map import Hops, release, return_map, with_same_ground_speed, write_hop
from vibro.core.samples import fly
from vibro.core.waves import SINE

__all__ = [
    "CAPTURED", "MOST_TURNS", "Bodies", "Means", "Spread", "averages", "spread_of", "start_of",
]  # fmt: skip

# [1] Ratio of the variance of a body's mean to that expected from its two halves: above which the sample is
# shorter than the memory of the motion, and above which bodies have gone different ways. For halves without
# memory it is F-distributed about 1.
_DRIFTS: Final = 3.0
_PARTED: Final = 8.0
# [1] Square of Student's t, of first halves against second ones: above it bodies drift or run side by side.
_TOGETHER: Final = 5.0
_STUDENT: Final = (BODIES - 1) / (BODIES - 3)  # variance of Student's t for a scatter of so many bodies

#: [1] Throw number below which stable cycles of one bounce capture irregular motion within some thousand
#: cycles; above it their basins are narrow.
CAPTURED: Final = 2.0
#: Drive cycles of the longest of these.
MOST_TURNS: Final = 64

_FIRST_REACH: Final = 0.25  # [A w cos alpha] first step in search of the velocity of balance
_BALANCED: Final = 0.1  # [1] imbalance left, over its statistical error
_MOST_STEPS: Final = 24


class Means(NamedTuple):
    """Means over samples.

    Attributes
    ----------
    status : int
        ``AVERAGED``; ``RUNAWAY`` where a body does not stop again; ``UNRESOLVED`` where a longer sample is
        needed, or bounces are too many. NaN for numbers but with the first.
    displacement, deviation : float
        Mean displacement per drive cycle and its standard error [A].
    flight_fraction : float
        Share of the time spent off the trough.
    impact, peak : float
        Largest normal speed of a landing, and largest relative speed along the trough [A w].
    """

    status: int
    displacement: float
    deviation: float
    flight_fraction: float
    impact: float
    peak: float


class Bodies(NamedTuple):
    """What is known of ``BODIES`` bodies of a scene; of their halves in rows 2 i and 2 i + 1 of body i.

    Attributes
    ----------
    time, path, gain : Doubles
        Duration of each half [rad], displacement in it, and change of the velocity over the ground.
    swing : Doubles
        Velocity relative to the trough, over a, that the drive adds in each half.
    start : Doubles
        In row 2 i the relative velocity of a body at the start of its sample, in row 2 i + 1 the velocity of
        the trough there, over a.
    row : Integers
        Rows of ``Hops``, from 3 i on: the first of each half, and the one behind the last.
    """

    time: Doubles
    path: Doubles
    gain: Doubles
    swing: Doubles
    start: Doubles
    row: Integers


class _Slid(NamedTuple):
    """All bodies followed along the trough through their samples.

    Attributes
    ----------
    peak : float
        Largest speed.
    fastest : float
        Largest velocity downhill at the end.
    always_forgets, forgets : bool
        Whether each body stops in each half of its sample, and in the second half.
    """

    peak: float
    fastest: float
    always_forgets: bool
    forgets: bool


def averages(
    track: Track, restitution: float, length: int, longest: bool, flights: Flights, hops: Hops,
    bodies: Bodies,
) -> Means:  # fmt: skip
    """Average the motion of a scene in which no cycle can be told.

    Parameters
    ----------
    track : Track
        Scene.
    restitution : float
        e.
    length : int
        Events (flights, of which a chain of short bounces counts as one) in each half of the samples.
    longest : bool
        Whether no longer samples are to follow.
    flights, hops : Flights, Hops
        Scratch memory; ``BODIES * MOST_HOPS`` rows of ``hops``.
    bodies : Bodies
        Written.

    Returns
    -------
    Means
        The averages.

    Notes
    -----
    A longer sample is needed where the means of bodies differ by more than the halves of their samples
    explain, and where they remember their velocities for longer than it lasts. Where they differ for good, as
    they have gone different ways or as the size of the kicks decides, the standard error is the scatter of
    the bodies.
    """
    loads = track.loads
    unresolved = Means(Status.UNRESOLVED, NAN, NAN, NAN, NAN, NAN)
    throw, start = loads.drive_normal / loads.weight_normal, start_of(track)
    total, aloft, impact, lands = 0.0, 0.0, 0.0, False
    row = 0
    for i in range(BODIES):
        sample = fly(loads, restitution, i, length, hops, row)
        if not sample.ends:
            return unresolved
        before = return_map(track, hops, row, sample.first, 0.0, 0.0, start)
        row = sample.last
        bodies.start[2 * i], bodies.start[2 * i + 1] = before.velocity, sample.trough
        bodies.row[3 * i], bodies.row[3 * i + 1], bodies.row[3 * i + 2] = sample.first, sample.middle, row
        bodies.time[2 * i], bodies.time[2 * i + 1] = sample.first_time, sample.second_time
        bodies.swing[2 * i], bodies.swing[2 * i + 1] = sample.first_swing, sample.second_swing
        total += sample.first_time + sample.second_time
        aloft += sample.aloft
        impact = max(impact, sample.impact)
        lands = lands or sample.lands
    slid = _slide(track, hops, bodies)
    slope, friction = abs(loads.weight_tangential), loads.kinetic_friction * loads.weight_normal
    bounded = hopping_cycle(track, 0, 0, 0.0, 0.0, TURN).bounded
    remembers = bounded and not slid.always_forgets
    if remembers and longest:
        slid = _balance(track, hops, bodies)
        # Friction holds gravity, so that bodies turn round at times, and are no faster than drive, gravity
        # and friction make them. Where it holds it by less than samples can tell, they seem to balance far
        # beyond.
        ground = bodies.start[0] + loads.drive_tangential * bodies.start[1]
        if abs(ground) > 2.0 * loads.drive_tangential + (slope + friction) * total / BODIES:
            return unresolved

    mean = 0.0
    for i in range(2 * BODIES):
        mean += bodies.path[i]
    mean /= total
    spread = spread_of(bodies, mean, total, lands)

    # Where friction is too weak to hold gravity every flight without a stop adds speed downhill. The drive
    # takes no more than twice its own speed from that, and one landing no more than its friction.
    loose = slope > friction
    runs = loose and slid.fastest > 2.0 * (loads.drive_tangential + friction * impact)
    undecided = loose and not runs and not slid.forgets
    if runs or (undecided and longest):
        return unresolved._replace(status=Status.RUNAWAY)
    if not longest and (
        remembers or undecided or spread.drift > 0.0 or (not lands and spread.ratio > _DRIFTS)
    ):
        return unresolved
    means = Means(
        status=Status.AVERAGED,
        displacement=TURN * mean,
        deviation=TURN * math.sqrt(spread.variance),
        flight_fraction=min(aloft / total, 1.0),
        impact=loads.weight_normal * impact,
        peak=slid.peak,
    )
    if loads.waves.kind != SINE:
        means = _with_captures(track, restitution, means, start, flights, hops)
    if throw < CAPTURED:
        return _with_single_bounces(track, restitution, means, start, hops, flights.speed)
    return means


def start_of(track: Track) -> float:
    """Return the relative velocity of a body from rest at the first lift-off."""
    released = release(track)
    return with_same_ground_speed(track.loads, released.velocity, released.phase, track.lift_off)


class Spread(NamedTuple):
    """How far a mean over the bodies may be off.

    Attributes
    ----------
    variance : float
        Square of its standard error.
    ratio : float
        Variance of a body's mean over that expected from its halves.
    drift : float
        Part of the variance by which first halves of all bodies differ from second ones.
    """

    variance: float
    ratio: float
    drift: float


def spread_of(bodies: Bodies, mean: float, total: float, lands: bool) -> Spread:
    """Tell how far the mean of ``bodies.path`` per radian may be off.

    ``total`` is the duration of all samples [rad]; ``lands`` says whether there are contacts.
    """
    own, halves, drift = _variances(bodies, mean, total)
    ratio = own / halves if halves > 0.0 else (INF if own > 0.0 else 1.0)
    # Without memory both are the variance of a body's mean.
    variance = (own if ratio > _DRIFTS else 0.5 * (own + halves)) / BODIES
    if lands or ratio > _PARTED:
        variance += _STUDENT * max(own - halves, 0.0)
    return Spread(variance + drift, ratio, drift)


def _variances(bodies: Bodies, mean: float, total: float) -> tuple[float, float, float]:
    """Return the variance of a body's mean, from the scatter of the bodies and from their halves.

    The third number is the square of what first halves of all bodies differ by from second ones; 0 where
    independent bodies without memory may differ as much. The sum of all deviations from the mean is 0.
    """
    own, halves, drift, scale = 0.0, 0.0, 0.0, BODIES / total
    for i in range(BODIES):
        first = (bodies.path[2 * i] - mean * bodies.time[2 * i]) * scale
        second = (bodies.path[2 * i + 1] - mean * bodies.time[2 * i + 1]) * scale
        own += (first + second) * (first + second)
        halves += (first - second) * (first - second)
        drift += (first - second) / BODIES
    drift *= drift
    halves /= BODIES
    if drift * (BODIES - 1) <= _TOGETHER * (halves - drift):
        drift = 0.0
    return own / (BODIES - 1), halves, drift


def _slide(track: Track, hops: Hops, bodies: Bodies) -> _Slid:
    """Follow the bodies from their velocities at the start of the samples; write paths and gains."""
    loads = track.loads
    downhill = -math.copysign(1.0, loads.weight_tangential) if loads.weight_tangential != 0.0 else 0.0
    peak, fastest, always_forgets, forgets = 0.0, -INF, True, True
    for i in range(BODIES):
        velocity = bodies.start[2 * i]
        for half in range(2):
            row, here = 3 * i + half, 2 * i + half
            first, last = bodies.row[row], bodies.row[row + 1]
            leg = return_map(track, hops, first, last, 0.0, 0.0, velocity)
            # without a stop gravity and friction alone act
            gain = leg.friction - loads.weight_tangential * bodies.time[here]
            if has_stop(leg):
                gain = leg.velocity - velocity - loads.drive_tangential * bodies.swing[here]
            elif half == 0:
                always_forgets = False
            else:
                always_forgets, forgets = False, False
            bodies.path[here], bodies.gain[here] = leg.displacement, gain
            peak, velocity = max(peak, leg.peak), leg.velocity
        fastest = max(fastest, downhill * velocity)
    return _Slid(peak, fastest, always_forgets, forgets)


class _Imbalance(NamedTuple):
    """A velocity over the ground, and the gain and the path of all bodies from there; NaN if unknown."""

    ground: float
    gain: float
    path: float


def _balance(track: Track, hops: Hops, bodies: Bodies) -> _Slid:
    """Give all bodies the same velocity over the ground, that at which gravity and friction balance.

    Where a body never stops in its sample it is off, the longer the less friction there is, by the error of
    its velocity at the start. The sum of what all bodies gain falls with the velocity. Bracket the zero, and
    go on by false position and halving in turn until less than a tenth of its statistical error is left. What
    the balance of each is off by moves that velocity, and with it the mean: each path is corrected for that,
    and the sum of the corrections is 0.
    """
    a = track.loads.drive_tangential
    ground, reach = 0.0, _FIRST_REACH * a
    for i in range(BODIES):
        ground += bodies.start[2 * i] + a * bodies.start[2 * i + 1]
    ground /= BODIES
    low, high = _Imbalance(NAN, NAN, NAN), _Imbalance(NAN, NAN, NAN)
    slid = _Slid(0.0, 0.0, True, True)
    effect = 0.0
    for step in range(_MOST_STEPS):
        for i in range(BODIES):
            bodies.start[2 * i] = ground - a * bodies.start[2 * i + 1]
        slid = _slide(track, hops, bodies)
        gain, path, scatter = 0.0, 0.0, 0.0
        for i in range(BODIES):
            own = bodies.gain[2 * i] + bodies.gain[2 * i + 1]
            gain += own
            scatter += own * own
            path += bodies.path[2 * i] + bodies.path[2 * i + 1]
        rises = gain > 0.0
        if rises:
            low = _Imbalance(ground, gain, path)
        else:
            high = _Imbalance(ground, gain, path)
        if math.isnan(low.ground) or math.isnan(high.ground):
            ground += reach if rises else -reach
            reach *= 2.0
            continue
        effect = (high.path - low.path) / (high.gain - low.gain)
        if abs(gain) <= _BALANCED * math.sqrt(scatter):
            break
        share = 0.5 if step % 3 == 2 else low.gain / (low.gain - high.gain)
        ground = low.ground + share * (high.ground - low.ground)
    for i in range(2 * BODIES):
        bodies.path[i] -= effect * bodies.gain[i]
    return slid


def _with_captures(
    track: Track, restitution: float, means: Means, start: float, flights: Flights, hops: Hops
) -> Means:
    """Average over the irregular motion, as one body, and the cycles in which bodies have ended.

    Nobody knows which of them it will be, so that the error is the scatter of these motions.
    """
    found = captures(track, restitution, means.displacement, start, flights, hops)
    if found.number == 0:
        return means
    # Bodies that have not ended yet do not count: most will be captured later.
    shift = found.displacement / (found.number + 1)
    variance = (found.squares - found.displacement * shift) / found.number
    return Means(
        status=Status.AVERAGED,
        displacement=means.displacement + shift,
        deviation=math.sqrt(means.deviation * means.deviation + variance),
        flight_fraction=(means.flight_fraction + found.aloft) / (found.number + 1),
        impact=max(means.impact, found.impact),
        peak=max(means.peak, found.peak),
    )


def _with_single_bounces(
    track: Track, restitution: float, means: Means, start: float, hops: Hops, found: Doubles
) -> Means:
    """Average over the irregular motion and the stable cycles of one bounce that may capture it, Eq. (37).

    At low throw numbers they do so after some hundreds or thousands of cycles, nobody knows which of them and
    when. The mean over all these motions is returned, with their scatter. ``start`` is the velocity of a body
    from rest at its first lift-off, ``found`` scratch memory.
    """
    loads = track.loads
    motions, total, impact, peak = 1, means.displacement, means.impact, means.peak
    bed = bed_of(loads)
    indices = 1 if loads.waves.kind == SINE else 2 * loads.waves.size
    for i in range(MOST_TURNS * indices):
        turns = 1 + i // indices
        bounce = single_bounce(bed, restitution, turns, i % indices)
        if not (bounce.exists and bounce.stable):
            continue
        length = TURN * turns
        write_hop(loads, bounce.phase, length, length, hops, 0)
        orbit = orbit_from(hopping_cycle(track, 0, 1, 0.0, 0.0, length), hops, start)
        if orbit.status != Status.OK and orbit.status != Status.BOUNDARY:
            return Means(orbit.status, NAN, NAN, NAN, NAN, NAN)
        found[motions] = orbit.cycle.displacement / turns
        total += found[motions]
        motions += 1
        impact = max(impact, loads.weight_normal * length / (1.0 + restitution))
        peak = max(peak, orbit.cycle.peak)
    if motions == 1:
        return means
    center = total / motions
    found[0] = means.displacement
    squares = 0.0
    for i in range(motions):
        squares += (found[i] - center) * (found[i] - center)
    return Means(
        status=Status.AVERAGED,
        displacement=center,
        deviation=math.sqrt(means.deviation * means.deviation + squares / (motions - 1)),
        flight_fraction=1.0 + (means.flight_fraction - 1.0) / motions,
        impact=impact,
        peak=peak,
    )
