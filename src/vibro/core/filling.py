"""What a body in the trough weighs to its drive: the harmonics of the force with which it acts on the trough.

By parts each harmonic of the body's absolute acceleration is an integral of its relative velocity over the
settled cycle, Eqs. (73)-(75) of docs/theory: rests contribute nothing, and jumps of the velocity need no
terms of their own. Lengths in A, speeds in A w, phases of the normal motion in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.bounces import ACCUMULATED, Flights, after_landing, single_bounce
from vibro.core.codes import Mode, Status
from vibro.core.contact import SlideLeg, cycle_slides
from vibro.core.drive import (
    Loads,
    beyond_friction,
    free_along,
    free_normal,
    mix_of,
    phase_difference,
    trough_along,
)
from vibro.core.flight import bed_of, flight
from vibro.core.hops import (
    Bodies,
    cycle_of,
    enter,
    kick,
    means_of,
    repeating,
    spread_of,
    start_of,
)
from vibro.core.legs import Track, contact_leg, mode_of, track_of
from vibro.core.machines import Complex
from vibro.core.numbers import BODIES, INF, NAN, TURN, braked, circle, doubles, hypotenuse, integers, wrap
from vibro.core.return_map import CLOSE, MOST_LEGS, Hops, hopping_cycle, landed, orbit_from, write_hop
from vibro.core.slides import thresholds
from vibro.core.wave_cycle import Begin, cycle_begin
from vibro.core.waves import FORCE, NORMAL, SINE, Mix, at_break, depart, moved

# [rad] Legs up to this length are integrated by Gauss's rule of eight nodes, whose terms all are as small as
# the leg, within 4e-16 (tests/test_fillings.py). Longer ones have closed forms.
_SHORT: Final = 1.0
_NODE_1: Final = 0.18343464249564980494
_NODE_2: Final = 0.52553240991632898582
_NODE_3: Final = 0.79666647741362673959
_NODE_4: Final = 0.96028985649753623168
_SHARE_1: Final = 0.18134189168918099148
_SHARE_2: Final = 0.15685332293894364367
_SHARE_3: Final = 0.11119051722668723527
_SHARE_4: Final = 0.050614268145188129576

# [1] Throw number below which stable cycles of one bounce capture irregular motion within some thousand
# cycles; above it their basins are narrow.
_CAPTURED: Final = 2.0
# Drive cycles of the longest of these.
_MOST_TURNS: Final = 64


class Reaction(NamedTuple):
    """Harmonics of the force of a body on the trough, over m A w^2.

    Attributes
    ----------
    added_mass, added_damping : float
        lambda and delta: first harmonic, Eq. (74).
    second_real, second_imaginary : float
        Second harmonic along the line, Eq. (75); of an ellipse its size, and 0.
    mass_error, damping_error : float
        Standard errors of the first two where they are means, else 0.
    """

    added_mass: float
    added_damping: float
    second_real: float
    second_imaginary: float
    mass_error: float
    damping_error: float


class _Integrals(NamedTuple):
    """Integrals of a velocity times e^(-ip) and e^(-2ip) over the phase p."""

    first_real: float
    first_imaginary: float
    second_real: float
    second_imaginary: float


class _Walk(NamedTuple):
    """Integrals of the velocities along and normal to the trough so far, and the velocity along it now."""

    along: _Integrals
    normal: _Integrals
    velocity: float


class _Motion(NamedTuple):
    """Velocity v0 + C (1 - cos s) + S sin s - D s, a phase s after the start of a leg."""

    start: float
    cosine: float
    sine: float
    drag: float


class _Sum(NamedTuple):
    """Integrals of a velocity alone, and of its harmonics."""

    path: float
    harmonics: _Integrals


def reaction_in_contact(loads: Loads, pattern: int) -> Reaction:
    """Sum over the slides of a steady contact cycle, whose pattern is known."""
    slides = cycle_slides(loads, pattern)
    walk = _from_rest()
    if slides.first.way != 0.0:
        walk = _with_slide(loads, walk, slides.first)
    if slides.second.way != 0.0:
        walk = _with_slide(loads, walk, slides.second)
    return _reaction(loads, walk, TURN)


def _from_rest() -> _Walk:
    return _Walk(_nothing(), _nothing(), 0.0)


def _with_slide(loads: Loads, walk: _Walk, leg: SlideLeg) -> _Walk:
    """Add a slide that begins without speed."""
    phase, length = leg.begin + phase_difference(loads), leg.end - leg.begin
    motion = _sliding(loads, phase, 0.0, leg.way)
    return walk._replace(along=_plus(walk.along, _integrals(motion, phase, length, leg.displacement)))


def _sliding(loads: Loads, phase: float, velocity: float, way: float) -> _Motion:
    """Slide from a phase on: friction is mu_d N, and N falls where the trough does."""
    friction = way * loads.kinetic_friction
    a, pressed = loads.drive_tangential, friction * loads.drive_normal
    at = trough_along(loads, phase)
    return _Motion(
        velocity,
        a * at.velocity + pressed * math.cos(phase),
        a * at.path + pressed * math.sin(phase),
        loads.weight_tangential + friction * loads.weight_normal,
    )


def reaction_of_hops(loads: Loads, restitution: float, flights: Flights, hops: Hops) -> Reaction:
    """Sum over the flights and slides of a steady cycle that ``hopping`` has found.

    ``flights`` and ``hops`` are scratch memory.
    """
    cycle = _hopping_cycle(loads, restitution, flights, hops)
    return _reaction(loads, cycle.walk, cycle.duration)


class _WholeCycle(NamedTuple):
    """A steady cycle, and how long it lasts [rad]."""

    walk: _Walk
    duration: float


def _hopping_cycle(loads: Loads, restitution: float, flights: Flights, hops: Hops) -> _WholeCycle:
    track, bed = track_of(loads, restitution), bed_of(loads)
    entry = enter(track, restitution, flights, hops)
    cycle = cycle_of(track, entry.motion)
    walk = _from_rest()._replace(velocity=orbit_from(cycle, hops, entry.velocity).velocity)
    for row in range(cycle.first, cycle.last):
        landing, rest = hops.landing[row], hops.rest[row]
        if row + 1 == cycle.last and cycle.rest > 0.0:
            landing, rest = cycle.landing, cycle.rest
        phase, impact, length, bounced = flights.phase[row], flights.impact[row], flights.length[row], 0.0
        if rest > 0.0:
            bounced = after_landing(bed, phase + length, impact, restitution, ACCUMULATED).length
        hop = _Hop(phase, flights.speed[row], length - bounced, bounced, impact)
        walk = _with_flight(loads, restitution, hop, landed(hops, row, walk.velocity), walk)
        if rest > 0.0:
            walk = _with_contact(track, landing, rest, walk)
    return _WholeCycle(walk, TURN * entry.motion.cycles)


class Share(NamedTuple):
    """What a body weighs, its status, and how far it advances in a drive cycle [A]; 0 where it is unknown."""

    reaction: Reaction
    status: int
    displacement: float


def reaction_on_harmonics(
    loads: Loads, line: Loads, second: Complex, restitution: float, flights: Flights, hops: Hops
) -> Share:
    """Solve the steady cycle on a trough that moves along a line with two harmonics, and sum over it.

    Parameters
    ----------
    loads : Loads
        Groups of the scene; lengths in the amplitude of the first harmonic.
    line : Loads
        Those of a drive along the same line with one harmonic.
    second : Complex
        The second harmonic; the trough is at Im(e^ip + second e^2ip).
    restitution : float
        Of the scene.
    flights, hops : Flights, Hops
        Scratch memory.
    """
    at, cycle = thresholds(loads), _WholeCycle(_from_rest(), TURN)
    hopping = at.hops and loads.kinetic_friction <= loads.static_friction
    begin = Begin(0.0, 0.0, 0, 0.0)
    if hopping:
        hop = repeating(loads, restitution, flights, hops)
        begin = begin._replace(status=hop.status, displacement=hop.displacement)
    else:
        begin = cycle_begin(loads, at)
    if begin.status != Status.OK and begin.status != Status.BOUNDARY:
        return Share(Reaction(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), begin.status, 0.0)
    if hopping:
        cycle = _hopping_cycle(loads, restitution, flights, hops)
    elif at.forward or at.back:
        walk = _from_rest()._replace(velocity=begin.velocity)
        cycle = _WholeCycle(_with_contact(track_of(loads, 0.0), begin.phase, TURN, walk), TURN)
    found = _reaction(line, cycle.walk, cycle.duration)
    own_real, own_imaginary = found.second_real + 4.0 * second.real, 4.0 * second.imaginary
    found = found._replace(second_real=own_real, second_imaginary=found.second_imaginary + own_imaginary)
    return Share(found, begin.status, begin.displacement)


class _Hop(NamedTuple):
    """A flight: its take-off, length and landing speed, and how long the bounces last that are summed."""

    phase: float
    speed: float
    length: float
    bounced: float
    impact: float


def _with_flight(loads: Loads, restitution: float, hop: _Hop, after: float, walk: _Walk) -> _Walk:
    """Add a flight, and the bounces that are summed after it; ``after`` is the velocity then.

    These are so short and low that the body keeps the speed along the trough which the first impact leaves,
    and none normal to it.
    """
    phase, length, n = hop.phase, hop.length, loads.weight_normal
    flown = free_along(loads, phase, walk.velocity, length)
    if loads.waves.kind == SINE:
        a, b = loads.drive_tangential, loads.drive_normal
        at = trough_along(loads, phase)
        ahead = _Motion(walk.velocity, a * at.velocity, a * at.path, loads.weight_tangential)
        off = _Motion(n * hop.speed, b * math.cos(phase), b * math.sin(phase), n)
        along = _integrals(ahead, phase, length, flown.path)
        normal = _integrals(off, phase, length, 0.0)
    else:
        along = _over_waves(loads, mix_of(loads, FORCE), phase, walk.velocity, length)
        normal = _over_waves(loads, mix_of(loads, NORMAL), phase, n * hop.speed, length)
    along, normal = _plus(walk.along, along), _plus(walk.normal, normal)
    if hop.bounced > 0.0:
        left = braked(flown.velocity, loads.kinetic_friction * n * hop.impact * (1.0 + restitution))
        chain = _Motion(left, 0.0, 0.0, 0.0)
        along = _plus(along, _integrals(chain, phase + length, hop.bounced, left * hop.bounced))
    return _Walk(along, normal, after)


def _with_contact(track: Track, landing: float, rest: float, walk: _Walk) -> _Walk:
    """Add the legs from a landing until the lift-off."""
    loads, phase, left, velocity, along = track.loads, landing, rest, walk.velocity, walk.along
    mode = mode_of(loads, landing, velocity, track.landed_friction)
    for _ in range(MOST_LEGS):
        leg = contact_leg(track, mode, phase, velocity, left)
        if mode != Mode.REST:
            way = 1.0 if mode == Mode.FORWARD else -1.0
            if loads.waves.kind == SINE:
                slide = _integrals(_sliding(loads, phase, velocity, way), phase, leg.length, leg.displacement)
            else:
                braked_by = beyond_friction(loads, loads.kinetic_friction, way)
                slide = _scaled(_over_waves(loads, braked_by, phase, way * velocity, leg.length), way)
            along = _plus(along, slide)
        velocity = leg.velocity
        if not leg.length < left - CLOSE:
            break
        phase, left, mode = at_break(loads.waves, phase + leg.length), left - leg.length, leg.next_mode
    return _Walk(along, walk.normal, velocity)


def _reaction(loads: Loads, walk: _Walk, duration: float) -> Reaction:
    """Project the harmonics on the trough's path, Eqs. (73)-(75)."""
    a, b, x, y = loads.drive_tangential, loads.drive_normal, walk.along, walk.normal
    square = a * a + b * b
    if square == 0.0:
        return Reaction(1.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # where the trough stands still the body rests on it
    scale = 2.0 / (square * duration)
    first = _projected(loads, x, y)
    mass, damping = 1.0 + scale * first.real, 0.0 - scale * first.imaginary
    ahead, scale = a * loads.phase_cosine, 2.0 * scale
    if loads.phase_sine == 0.0:
        second_real = scale * (ahead * x.second_real + b * y.second_real)
        second_imaginary = scale * (ahead * x.second_imaginary + b * y.second_imaginary)
        return Reaction(mass, damping, second_real + 0.0, second_imaginary + 0.0, 0.0, 0.0)
    forward = hypotenuse(x.second_real, x.second_imaginary)
    upward = hypotenuse(y.second_real, y.second_imaginary)
    size = scale * hypotenuse(forward, upward) * hypotenuse(a, b)
    return Reaction(mass, damping, size, 0.0, 0.0, 0.0)


class _Parts(NamedTuple):
    real: float
    imaginary: float


def _projected(loads: Loads, along: _Integrals, normal: _Integrals) -> _Parts:
    """Project integrals of the first harmonic on the trough's path: a e^(i phi) x + b y."""
    a, b = loads.drive_tangential, loads.drive_normal
    ahead, beside = a * loads.phase_cosine, a * loads.phase_sine
    return _Parts(
        ahead * along.first_real - beside * along.first_imaginary + b * normal.first_real,
        ahead * along.first_imaginary + beside * along.first_real + b * normal.first_imaginary,
    )


def mean_reaction(loads: Loads, restitution: float, flights: Flights, hops: Hops) -> Reaction:
    """Average over the samples of ``averages``, with the standard errors of the means.

    ``flights`` and ``hops`` are scratch memory. The bodies and their kicks are those whose mean speed
    ``hopping`` tells, as are the stable cycles of one bounce that count as one motion each.
    """
    track = track_of(loads, restitution)
    time, path, gain = doubles(2 * BODIES), doubles(2 * BODIES), doubles(2 * BODIES)
    swing, start, rows = doubles(2 * BODIES), doubles(2 * BODIES), integers(3 * BODIES)
    bodies, total, lands = Bodies(time, path, gain, swing, start, rows), 0.0, False
    if means_of(track, restitution, flights, hops, bodies).status != Status.AVERAGED:
        return Reaction(NAN, NAN, NAN, NAN, NAN, NAN)
    for row in range(rows[3 * BODIES - 1]):
        lands = lands or hops.rest[row] > 0.0
    whole, begun = _from_rest(), 0
    for i in range(BODIES):
        walk = _from_rest()._replace(velocity=start[2 * i])
        flown = -1.0
        for half in range(2):
            walk = _from_rest()._replace(velocity=walk.velocity)
            for row in range(rows[3 * i + half], rows[3 * i + half + 1]):
                hop = _hop_of_sample(loads, restitution, hops, i, begun, row, flown)
                flown = hop.impact
                walk = _with_flight(loads, restitution, hop, landed(hops, row, walk.velocity), walk)
                if hops.rest[row] > 0.0:
                    walk = _with_contact(track, hops.landing[row], hops.rest[row], walk)
            here = _projected(loads, walk.along, walk.normal)
            path[2 * i + half], gain[2 * i + half] = here.real, here.imaginary
            total += time[2 * i + half]
            whole = _Walk(_plus(whole.along, walk.along), _plus(whole.normal, walk.normal), 0.0)
        begun = rows[3 * i + 2]
    found = _reaction(loads, whole, total)
    # the shares are 2 / (a^2 + b^2) times means per radian
    scale = 2.0 / (loads.drive_tangential * loads.drive_tangential + loads.drive_normal * loads.drive_normal)
    mass_error = scale * math.sqrt(spread_of(bodies, (found.added_mass - 1.0) / scale, total, lands).variance)
    for i in range(2 * BODIES):
        path[i] = gain[i]
    damping_error = scale * math.sqrt(spread_of(bodies, -found.added_damping / scale, total, lands).variance)
    found = found._replace(mass_error=mass_error, damping_error=damping_error)
    if loads.drive_normal < _CAPTURED * loads.weight_normal:
        return _with_single_bounces(track, restitution, found, hops)
    return found


def _hop_of_sample(
    loads: Loads, restitution: float, hops: Hops, body: int, begun: int, row: int, impact: float
) -> _Hop:
    """Find a flight of a body from what ``hops`` holds of it, whose first row is ``begun``.

    ``impact`` is the landing speed of the flight before; negative where that is unknown.
    """
    bed, n, length = bed_of(loads), loads.weight_normal, hops.length[row]
    rested = hops.rest[row - 1] > 0.0
    phase = bed.lift_off if rested else hops.landing[row - 1]
    if hops.rest[row] > 0.0 and (rested or impact >= 0.0):
        # its length has that of the bounces that are summed after it
        speed = kick(row - begun, body) if rested else restitution * impact
        flown = flight(bed, phase, speed)
        alone = min(flown.length, length)
        return _Hop(phase, speed, alone, length - alone, flown.impact)
    fall = free_normal(loads, phase, 0.0, length)
    speed = -fall.path / (n * length)  # at which the body is back on the trough then
    return _Hop(phase, speed, length, 0.0, max(-fall.velocity / n - speed, 0.0))


def _with_single_bounces(track: Track, restitution: float, found: Reaction, hops: Hops) -> Reaction:
    """Average over irregular motion and the stable cycles of one bounce, as ``averages`` does."""
    loads, bed, start = track.loads, bed_of(track.loads), start_of(track)
    motions, mass, damping = 1, found.added_mass, found.added_damping
    mass_squares, damping_squares = mass * mass, damping * damping
    real, imaginary = found.second_real, found.second_imaginary
    for turns in range(1, _MOST_TURNS + 1):
        bounce = single_bounce(bed, restitution, turns, 0)
        if not (bounce.exists and bounce.stable):
            continue
        length = TURN * turns
        write_hop(loads, bounce.phase, length, length, hops, 0)
        orbit = orbit_from(hopping_cycle(track, 0, 1, 0.0, 0.0, length), hops, start)
        hop = _Hop(bounce.phase, bounce.speed, length, 0.0, length / (1.0 + restitution))
        walk = _from_rest()._replace(velocity=orbit.velocity)
        one = _reaction(loads, _with_flight(loads, restitution, hop, orbit.velocity, walk), length)
        motions += 1
        mass, damping = mass + one.added_mass, damping + one.added_damping
        mass_squares += one.added_mass * one.added_mass
        damping_squares += one.added_damping * one.added_damping
        real, imaginary = real + one.second_real, imaginary + one.second_imaginary
    if motions == 1:
        return found
    mass, damping = mass / motions, damping / motions
    mass_variance = max(mass_squares - motions * mass * mass, 0.0) / (motions - 1)
    damping_variance = max(damping_squares - motions * damping * damping, 0.0) / (motions - 1)
    return Reaction(
        mass, damping, real / motions, imaginary / motions,
        math.sqrt(found.mass_error * found.mass_error + mass_variance),
        math.sqrt(found.damping_error * found.damping_error + damping_variance),
    )  # fmt: skip


def force_bound(loads: Loads) -> float:
    """Bound the first harmonic, and each other one, by the weight alone, Eq. (76).

    The mean normal force of a settled body is its weight, and friction takes mu_s of it at most.
    """
    a, b = loads.drive_tangential, loads.drive_normal
    friction = a * loads.static_friction
    force = hypotenuse(b + friction * abs(loads.phase_cosine), friction * loads.phase_sine)
    whole = a * a + b * b
    return 2.0 * loads.weight_normal * force / whole if whole > 0.0 else INF


def _integrals(motion: _Motion, phase: float, length: float, path: float) -> _Integrals:
    """Integrate a leg of a known path."""
    if length <= _SHORT:
        return _short(motion, phase, length, path)
    return _long(motion, phase, length)


def _short(motion: _Motion, phase: float, length: float, path: float) -> _Integrals:
    """Integrate by Gauss's rule.

    The path is known better than from the phase at the start, which is rounded: what it differs by from the
    integral of the velocity belongs to the middle of the leg.
    """
    half, middle = 0.5 * length, phase + 0.5 * length
    out = _Sum(0.0, _nothing())
    for i in range(4):
        node, share = _NODE_1, _SHARE_1
        if i == 1:
            node, share = _NODE_2, _SHARE_2
        elif i == 2:
            node, share = _NODE_3, _SHARE_3
        elif i == 3:
            node, share = _NODE_4, _SHARE_4
        out = _at(motion, phase, half * (1.0 - node), share * length, out)
        out = _at(motion, phase, half * (1.0 + node), share * length, out)
    return _with_impulse(out.harmonics, middle, path - out.path)


def _at(motion: _Motion, phase: float, s: float, share: float, out: _Sum) -> _Sum:
    """Add a node of the rule."""
    h = circle(0.5 * s)
    rise, versine = 2.0 * h.sine * h.cosine, 2.0 * h.sine * h.sine
    velocity = motion.start + motion.cosine * versine + motion.sine * rise - motion.drag * s
    return _Sum(out.path + share * velocity, _with_impulse(out.harmonics, phase + s, share * velocity))


def _with_impulse(out: _Integrals, phase: float, weight: float) -> _Integrals:
    """Add a weight at a phase."""
    at = circle(phase)
    return _Integrals(
        out.first_real + weight * at.cosine,
        out.first_imaginary - weight * at.sine,
        out.second_real + weight * (at.cosine - at.sine) * (at.cosine + at.sine),
        out.second_imaginary - weight * 2.0 * at.sine * at.cosine,
    )


def _long(motion: _Motion, phase: float, length: float) -> _Integrals:
    """Integrate in closed form, Eq. (77): powers of e^(-is), times those at the start."""
    c1, s1 = math.cos(length), math.sin(length)
    c2, s2 = (c1 - s1) * (c1 + s1), 2.0 * s1 * c1
    c3, s3 = c1 * c2 - s1 * s2, s1 * c2 + c1 * s2
    # E_m = integral of e^(-ims), real and imaginary part
    r1, i1, r2, i2 = s1, c1 - 1.0, 0.5 * s2, 0.5 * (c2 - 1.0)
    r3, i3 = s3 / 3.0, (c3 - 1.0) / 3.0
    level, c, s, d = motion.start + motion.cosine, 0.5 * motion.cosine, 0.5 * motion.sine, motion.drag
    # less (C + iS) E_(k-1) / 2 and (C - iS) E_(k+1) / 2, and D times the integral of s e^(-iks)
    x1 = level * r1 - c * length - (c * r2 + s * i2) - d * (length * s1 + i1)
    y1 = level * i1 - s * length - (c * i2 - s * r2) - d * (length * c1 - r1)
    x2 = level * r2 - (c * r1 - s * i1) - (c * r3 + s * i3) - 0.5 * d * (length * s2 + i2)
    y2 = level * i2 - (c * i1 + s * r1) - (c * i3 - s * r3) - 0.5 * d * (length * c2 - r2)
    at_sine, at_cosine = math.sin(phase), math.cos(phase)
    twice_sine, twice_cosine = 2.0 * at_sine * at_cosine, (at_cosine - at_sine) * (at_cosine + at_sine)
    return _Integrals(
        x1 * at_cosine + y1 * at_sine,
        y1 * at_cosine - x1 * at_sine,
        x2 * twice_cosine + y2 * twice_sine,
        y2 * twice_cosine - x2 * twice_sine,
    )


def _over_waves(loads: Loads, mix: Mix, phase: float, start: float, length: float) -> _Integrals:
    """Integrate a leg on a trough with several harmonics, from its velocity on, by Gauss's rule."""
    waves, begin, out = loads.waves, wrap(phase), _nothing()
    value = depart(waves, mix, begin).load
    parts = int(math.ceil(length / _SHORT))
    half = 0.5 * length / max(parts, 1)
    for part in range(parts):
        for i in range(8):
            node, share = _NODE_1, _SHARE_1
            if i % 4 == 1:
                node, share = _NODE_2, _SHARE_2
            elif i % 4 == 2:
                node, share = _NODE_3, _SHARE_3
            elif i % 4 == 3:
                node, share = _NODE_4, _SHARE_4
            s = half * (2.0 * part + 1.0 + (node if i < 4 else -node))
            velocity = start + moved(waves, mix, begin, value, s).velocity
            out = _with_impulse(out, begin + s, 2.0 * half * share * velocity)
    return out


def _scaled(one: _Integrals, factor: float) -> _Integrals:
    return _Integrals(
        factor * one.first_real,
        factor * one.first_imaginary,
        factor * one.second_real,
        factor * one.second_imaginary,
    )


def _nothing() -> _Integrals:
    return _Integrals(0.0, 0.0, 0.0, 0.0)


def _plus(one: _Integrals, other: _Integrals) -> _Integrals:
    return _Integrals(
        one.first_real + other.first_real,
        one.first_imaginary + other.first_imaginary,
        one.second_real + other.second_real,
        one.second_imaginary + other.second_imaginary,
    )
