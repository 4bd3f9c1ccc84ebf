"""Legs of a body in contact: rest until an onset, or a slide until it stops or the trough falls away.

A slide's speed is s(p) = s0 + P (cos p0 - cos p) - Q (p - p0), Eq. (23) of docs/theory, with P the
amplitude of its forcing and Q its drag. Between a maximum of s and the minimum after it s falls, and from one
minimum to the next it changes by -2 pi Q. So the branch with the first zero follows in closed form, and the
zero has a proven bracket. Slides from rest in contact scenes have the sharper solution of ``slides.py``.

A rounded phase does not tell on which side of an onset it lies. So each leg names the one that follows,
instead of asking the loads at a phase again. Lengths in A, speeds in A w, phases of the normal motion in rad.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.cells import Event, behind, find_nodes, forget_nodes, next_event, number_of_nodes
from vibro.core.codes import Mode
from vibro.core.drive import Loads, beyond_friction, mix_of, trough_along
from vibro.core.numbers import (
    EPS,
    HARMONICS,
    INF,
    NAN,
    NOISE,
    PI,
    PIECES,
    QUARTER,
    TURN,
    bisected,
    circle,
    free_motion,
    until,
    wrap,
    wrap_around,
)
from vibro.core.slides import load_amplitude, own_phase
from vibro.core.waves import (
    FORCE,
    KINETIC_BACK,
    KINETIC_FORWARD,
    NORMAL,
    SINE,
    STATIC_BACK,
    STATIC_FORWARD,
    Mix,
    Moved,
    Ride,
    Waves,
    depart,
    integrals_of,
    mixed,
    moved,
    nodes_of,
    place_in,
    ride,
)

# ------------------------------------------------------------------------------
# Slides under any periodic load: from zero to zero of what accelerates them, until the speed is lost.
#
# Between two zeros of the load beyond kinetic friction the speed is monotone. It is least where that load
# begins to rise above 0: the body stops before the first such phase at which no speed would be left. Lengths
# in A, speeds in A w, phases in radians.

_STEPS: Final = 100  # of Halley's iteration with halvings, in a bracket
_SETTLED_PHASE: Final = 0.1 * EPS  # [1] error, over the phase, that Halley's next step may have
# [A w] Below this a difference of integrals would leave too few digits of a change of the speed.
_SMALL: Final = 0.01
_MOST_BEND: Final = 0.5  # [1] share of the rate that the curvature may change over a step
# [turn] A slide that outlasts so many turns never ends: a phase has no digit left to say where.
_MOST_TURNS: Final = 1e15
# [turn] that are followed one by one: one before all but the last are skipped, one after, and rounding.
_FOLLOWED_TURNS: Final = 64


class Fall(NamedTuple):
    """What falls to 0 under a load: a speed, or a height that begins with a rate.

    Attributes
    ----------
    waves, mix : Waves, Mix
        The load, kept by ``depart``.
    phase, load : float
        Start of the leg, and the load there [rad].
    height : bool
        Whether it is a height.
    value, rate : float
        At the start; the rate of a height alone.
    """

    waves: Waves
    mix: Mix
    phase: float
    load: float
    height: bool
    value: float
    rate: float


def _fallen(fall: Fall, s: float) -> Moved:
    """Integrate the load over a phase since the start."""
    return moved(fall.waves, fall.mix, fall.phase, fall.load, s)


class Left(NamedTuple):
    """What is left a phase after the start, its rate, and its second derivative."""

    phase: float
    value: float
    rate: float
    bend: float


def left_after(fall: Fall, s: float) -> Left:
    """Return what is left after a phase."""
    return _speed_now(fall, s, _fallen(fall, s))


def _speed_now(fall: Fall, s: float, now: Moved) -> Left:
    if fall.height:
        return Left(s, fall.value + (fall.rate * s + now.path), fall.rate + now.velocity, now.load)
    return Left(s, fall.value + now.velocity, now.load, now.slope)


def _noise(waves: Waves) -> float:
    """Return the speed, or height, that rounding may leave of none: pieces may keep a body there."""
    return NOISE if waves.kind == PIECES else 0.0


class Crossing(NamedTuple):
    """Where nothing is left, and what the load has done until then."""

    phase: float
    moved: Moved


def crossing(fall: Fall, low: Left, high: Left) -> Crossing:
    """Find where nothing is left, between phases at which values have opposite signs, or are 0.

    Halley's iteration in the bracket that its steps leave, from the zero of the cubic that is level at both
    ends; halving where it converges slowly, next to a double zero.
    """
    begin, end, fell = low.phase, high.phase, low.value - high.value
    lost = min(max(low.value / fell, 0.0), 1.0) if fell != 0.0 else 0.5
    if lost == 1.0:  # at the end the load may have jumped, and nothing be left long before
        lost = 0.5
    x = begin + (end - begin) * (0.5 - math.sin(math.asin(1.0 - 2.0 * lost) / 3.0))
    before, least, most = end - begin, begin, end
    now = _fallen(fall, x)
    for _ in range(_STEPS):
        here = _speed_now(fall, x, now)
        # pieces may leave nothing for a while: then find where that begins
        if (here.value > 0.0) != (fell > 0.0) or (here.rate == 0.0 and abs(here.value) <= _noise(fall.waves)):
            most = x
        else:
            least = x
        step = -here.value / here.rate if here.rate != 0.0 else INF
        bend = -0.5 * step * here.bend
        if abs(bend) < _MOST_BEND * abs(here.rate):
            step *= here.rate / (here.rate - bend)
        inside = least <= x + step <= most and abs(step) < 0.5 * before
        if not inside:
            step = 0.5 * (least + most) - x
        before = abs(step)
        x += step
        # the next step would be of the cube of this one, over the square of the distance from a double zero,
        # unless the load jumps
        room = min(x - begin, end - x) if inside and fall.waves.kind == HARMONICS else 0.0
        if before <= 4.0 * EPS * x or before * before * before <= _SETTLED_PHASE * x * room * room:
            return Crossing(x, _onward(now, step))
        now = _fallen(fall, x)
    return Crossing(x, now)


def _onward(now: Moved, s: float) -> Moved:
    """Go on by a phase so short that the load's curvature does not matter."""
    return Moved(
        now.load + s * now.slope,
        now.velocity + s * (now.load + s * now.slope / 2.0),
        now.path + s * (now.velocity + s * (now.load / 2.0 + s * now.slope / 6.0)),
        now.slope,
    )


class WaveSlide(NamedTuple):
    """A slide: as ``_SlideEnd`` and, relative to its way, its path.

    ``spare`` is the speed by which it would have to change to stop at another minimum of it [A w].
    """

    length: float
    stopped: bool
    speed: float
    top: float
    path: float
    spare: float


def first_ahead(waves: Waves, row: int, phase: float) -> int:
    """Return the index of the first zero of a row that lies ahead of a phase in [0, 2 pi), from 0 on."""
    return place_in(waves, nodes_of(waves, row), number_of_nodes(waves, row), phase)


def ahead(waves: Waves, row: int, phase: float, index: int) -> float:
    """Return how far ahead of a phase in [0, 2 pi) a zero lies; indices beyond the last count on, a turn on.

    The row must not be empty.
    """
    count = number_of_nodes(waves, row)
    turns = index // count
    return waves.number[nodes_of(waves, row) + index - turns * count] - phase + TURN * turns


def slide_over_waves(loads: Loads, way: float, phase: float, speed: float, limit: float) -> WaveSlide:
    """Follow a slide until it stops or the contact ends.

    Parameters
    ----------
    loads : Loads
        Groups of the scene; zeros of its load beyond kinetic friction are found when first needed.
    way : float
        +1.0 forward, -1.0 back.
    phase, speed : float
        Of its start, speed >= 0; where that is 0 the load must exceed friction [rad, A w].
    limit : float
        Phase from the start to the end of the contact; inf where there is none [rad].
    """
    waves = loads.waves
    row = KINETIC_FORWARD if way > 0.0 else KINETIC_BACK
    mix, phase = mix_of(loads, row), wrap(phase)
    if number_of_nodes(waves, row) < 0:
        _find(waves, row, mix)
    start = depart(waves, mix, phase)
    fall = Fall(waves, mix, phase, start.load, False, speed, 0.0)
    count = number_of_nodes(waves, row)
    if count == 0:
        return _monotone(fall, limit)
    index = first_ahead(waves, row, phase)
    rises = behind(waves, row, index % count)
    if speed == 0.0 and rises:
        # rounding has put the onset in front of the phase from which the load exceeds friction
        index, rises = index + 1, False
    drop, noise = -TURN * mix.constant, _noise(waves)
    low, top, least, minima, spare = Left(0.0, speed, start.load, 0.0), speed, INF, 0, INF
    for _ in range(_FOLLOWED_TURNS * count):
        far = ahead(waves, row, phase, index)
        if far >= limit:
            then = _fallen(fall, limit)
            high = _speed_now(fall, limit, then)
            if not (high.value <= noise and rises):
                end = max(high.value, 0.0)
                return WaveSlide(limit, False, end, max(top, high.value), speed * limit + then.path, spare)
        else:
            high = _at_node(fall, row, index, far, start.integral)
        if rises:
            spare = min(spare, abs(high.value))
        if high.value <= noise and rises:
            return _stopped(fall, crossing(fall, low, high), top, spare)
        top = max(top, high.value)
        if rises:
            least = min(least, high.value)
            minima += 2
        low, index, rises = high, index + 1, not rises
        if minima >= count and rises and limit == INF:
            # all minima of a turn were passed, and all maxima: each turn takes as much from them
            if not drop > 0.0 or least / drop > _MOST_TURNS:
                return WaveSlide(INF, False, NAN, NAN, NAN, INF)
            turns = float(math.floor(least / drop))
            if turns >= 1.0:
                index += count * int(turns)
                low = _at_node(fall, row, index - 1, ahead(waves, row, phase, index - 1), start.integral)
            least, minima = INF, 0
    return WaveSlide(NAN, False, NAN, NAN, NAN, INF)


def _find(waves: Waves, row: int, mix: Mix) -> None:
    """Find the zeros of a load beyond kinetic friction, and its integral there."""
    find_nodes(waves, row, mix)
    for i in range(number_of_nodes(waves, row)):
        zero = waves.number[nodes_of(waves, row) + i]
        waves.number[integrals_of(waves, row) + i] = depart(waves, mix, zero).integral


def _at_node(fall: Fall, row: int, index: int, far: float, integral: float) -> Left:
    """Return what is left at a zero of the load, from its integrals there and at the start."""
    node = integrals_of(fall.waves, row) + index % number_of_nodes(fall.waves, row)
    gain = fall.mix.constant * far + (fall.waves.number[node] - integral)
    if abs(gain) < _SMALL:
        gain = _fallen(fall, far).velocity
    return Left(far, fall.value + gain, 0.0, 0.0)


def _monotone(fall: Fall, limit: float) -> WaveSlide:
    """Follow a slide under a load that never changes its sign."""
    drop = -TURN * fall.mix.constant
    if limit == INF:
        if not drop > 0.0 or fall.value / drop > _MOST_TURNS:
            return WaveSlide(INF, False, NAN, NAN, NAN, INF)
        limit = TURN * (math.floor(fall.value / drop) + 1.0)
    then = _fallen(fall, limit)
    high = _speed_now(fall, limit, then)
    if high.value > 0.0:
        path = fall.value * limit + then.path
        return WaveSlide(limit, False, high.value, max(fall.value, high.value), path, INF)
    if fall.value == 0.0:
        return WaveSlide(0.0, True, 0.0, 0.0, 0.0, INF)
    return _stopped(fall, crossing(fall, left_after(fall, 0.0), high), fall.value, INF)


def _stopped(fall: Fall, stop: Crossing, top: float, spare: float) -> WaveSlide:
    return WaveSlide(stop.phase, True, 0.0, top, fall.value * stop.phase + stop.moved.path, spare)


# [1] Loads beyond this stop a slide at once, and would overflow in the sums and products below.
_MOST_LOAD: Final = 1e300

# [turn] A slide that outlasts so many turns never ends: a phase has no digit left to say where.

_HALLEY_STEPS: Final = 4
# [1] A last step below this fraction of the way from the maximum leaves rounding errors only, at double zeros
# too: a step leaves a third of the error there, and the speed is of its square.
_SETTLED: Final = 1e-9


class Forcing(NamedTuple):
    """What accelerates and what brakes slides in one direction, s'' = P sin(p + psi) - Q, Eq. (23).

    Attributes
    ----------
    shift : float
        psi of Eq. (55): p + psi is the slide's own phase; 0 or pi for a drive along a line [rad].
    amplitude, drag : float
        P >= 0 and Q.
    kappa : float
        asin(Q / P), within +- pi/2: the speed's minima lie there in the own phase, its maxima at pi - kappa.
    bend : float
        P cos(kappa), the speed's curvature there.
    excess : float
        Q - P sin(kappa): where it is not 0, the speed falls, or grows, all the time.
    """

    shift: float
    amplitude: float
    drag: float
    kappa: float
    bend: float
    excess: float


def forcing(loads: Loads, way: float) -> Forcing:
    """Form the forcing of slides forward (+1.0) or back (-1.0)."""
    friction = loads.kinetic_friction
    drag = friction * loads.weight_normal + way * loads.weight_tangential
    drag = max(min(drag, _MOST_LOAD), -_MOST_LOAD)
    amplitude = min(load_amplitude(loads, way, friction), _MOST_LOAD)
    shift = own_phase(loads, way, friction)
    if abs(drag) < amplitude:
        ratio = drag / amplitude
        bend = amplitude * math.sqrt((1.0 - ratio) * (1.0 + ratio))
        return Forcing(shift, amplitude, drag, math.asin(ratio), bend, 0.0)
    kappa = math.copysign(QUARTER, drag)
    return Forcing(shift, amplitude, drag, kappa, 0.0, drag - math.copysign(amplitude, drag))


class Track(NamedTuple):
    """A scene with what its legs need again and again.

    Attributes
    ----------
    loads : Loads
        Its groups.
    forward, back : Forcing
        Of slides either way.
    forward_onset, back_onset : float
        Phase at which a body at rest starts to slide, in [0, 2 pi); NaN where it never starts that way [rad].
        A drive beyond one harmonic may have several: ``next_onset``.
    lift_off : float
        Phase asin(1/K) at which the trough falls away under the body, Eq. (27), the first of them where there
        are several: ``next_lift_off``; inf where K <= 1 [rad].
    landed_friction : float
        Coefficient that holds a body which a landing has stopped: mu_s, but mu_d where it bounces, since
        nothing holds it between two bounces (theory, section 10).
    """

    loads: Loads
    forward: Forcing
    back: Forcing
    forward_onset: float
    back_onset: float
    lift_off: float
    landed_friction: float


def track_of(loads: Loads, restitution: float) -> Track:
    """Prepare a scene for its legs."""
    if loads.waves.kind != SINE:
        return _track_over_waves(loads, restitution)
    lift_off = INF
    if loads.drive_normal > loads.weight_normal:
        lift_off = math.asin(loads.weight_normal / loads.drive_normal)
    forward, back = forcing(loads, 1.0), forcing(loads, -1.0)
    landed = loads.static_friction if restitution == 0.0 else loads.kinetic_friction
    return Track(loads, forward, back, _onset(loads, 1.0), _onset(loads, -1.0), lift_off, landed)


def _track_over_waves(loads: Loads, restitution: float) -> Track:
    """Find where each load of a drive beyond one harmonic changes its sign; slides look for theirs."""
    find_nodes(loads.waves, STATIC_FORWARD, mix_of(loads, STATIC_FORWARD))
    find_nodes(loads.waves, STATIC_BACK, mix_of(loads, STATIC_BACK))
    forget_nodes(loads.waves, KINETIC_FORWARD)
    forget_nodes(loads.waves, KINETIC_BACK)
    lift_off = INF
    if loads.drive_normal > loads.weight_normal:
        find_nodes(loads.waves, NORMAL, mix_of(loads, NORMAL))
        find_nodes(loads.waves, FORCE, mix_of(loads, FORCE))
        lift_off = next_event(loads.waves, NORMAL, True, 0.0).phase
    forward = next_event(loads.waves, STATIC_FORWARD, True, 0.0).phase
    back = next_event(loads.waves, STATIC_BACK, True, 0.0).phase
    none = Forcing(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    landed = loads.static_friction if restitution == 0.0 else loads.kinetic_friction
    return Track(
        loads, none, none, forward if forward < INF else NAN, back if back < INF else NAN, lift_off, landed
    )


def next_onset(track: Track, way: float, phase: float) -> Event:
    """Return where a body that rests next starts to slide in a direction."""
    if track.loads.waves.kind != SINE:
        return next_event(track.loads.waves, STATIC_FORWARD if way > 0.0 else STATIC_BACK, True, phase)
    onset = track.forward_onset if way > 0.0 else track.back_onset
    return Event(INF, INF) if math.isnan(onset) else Event(onset, until(onset, phase))


def next_lift_off(track: Track, phase: float) -> Event:
    """Return where the trough next falls away under a body that rests on it."""
    if track.loads.waves.kind != SINE and track.lift_off < INF:
        return next_event(track.loads.waves, NORMAL, True, phase)
    return Event(track.lift_off, until(track.lift_off, phase) if track.lift_off < INF else INF)


def _onset(loads: Loads, way: float) -> float:
    """Return the phase at which the load begins to exceed static friction; NaN if it never does."""
    friction = loads.static_friction
    amplitude, shift = load_amplitude(loads, way, friction), own_phase(loads, way, friction)
    threshold = friction * loads.weight_normal + way * loads.weight_tangential
    # a line that presses the body down more than it pushes never starts it back in contact, Eq. (7)
    pressed = loads.line and way < 0.0 and shift == 0.0
    # without any load the trough falls away where friction would let go
    free = loads.drive_tangential == 0.0 and loads.weight_tangential == 0.0
    if pressed or free or not abs(threshold) < amplitude:
        return NAN
    return wrap(math.asin(threshold / amplitude) - shift)


class _SlideEnd(NamedTuple):
    """End of a slide.

    Attributes
    ----------
    length : float
        Phase from its start to its end; inf where it never ends [rad].
    stopped : bool
        Whether it ends because the speed is zero, not because the contact does.
    speed : float
        Speed at its end, >= 0; NaN where it never ends.
    top : float
        Largest speed; NaN where it never ends.
    settled : bool
        Whether the end was found to rounding.
    """

    length: float
    stopped: bool
    speed: float
    top: float
    settled: bool


def _speed_loss(d: float, at: Forcing) -> float:
    """Return the speed lost a phase d after the maximum, Eq. (25); negative phases are before it."""
    half_sine = math.sin(0.5 * d)
    sine = 2.0 * half_sine * math.cos(0.5 * d)
    return at.bend * (2.0 * half_sine * half_sine) + at.drag * (d - sine) + at.excess * sine


def slide_from_speed(at: Forcing, phase: float, speed: float, limit: float) -> _SlideEnd:
    """Follow a slide until it stops or the contact ends.

    Parameters
    ----------
    at : Forcing
        Of the slide's direction.
    phase : float
        Phase at the start [rad].
    speed : float
        Speed at the start, >= 0; where it is 0 the forcing must exceed the drag.
    limit : float
        Phase from the start to the end of the contact, inf where there is none [rad].

    Returns
    -------
    SlideEnd
        NaN speeds for a slide that never ends.
    """
    # d counts from the maximum pi - kappa of the turn that begins at the minimum kappa
    fall = PI + 2.0 * at.kappa
    d0 = wrap(phase + at.shift - at.kappa) + 2.0 * at.kappa - PI
    if speed == 0.0:
        # A slide from rest starts between the minimum and the maximum. Rounding may put its phase a little
        # before the minimum, and so into the turn before: count from the middle between the two instead.
        half = QUARTER - at.kappa
        d0 = wrap_around(d0 + half) - half
    elif d0 >= fall:
        d0 -= TURN
    first_top = speed + _speed_loss(d0, at)
    over = first_top - (2.0 * at.bend + at.drag * fall)  # speed at the first minimum
    per_turn = TURN * at.drag
    turns, endless = 0.0, False
    if over > 0.0:
        endless = at.drag <= 0.0 or over / per_turn > _MOST_TURNS
        if not endless:
            turns = float(math.ceil(over / per_turn))
    offset = TURN * turns - d0  # phase from the start to the maximum of the falling branch
    top = first_top - per_turn * turns
    low = 0.0 if turns > 0.0 else max(d0, 0.0)
    high = min(fall, limit - offset)
    # From the rates at the start: differences of speeds of order 1 would drown those of a steep drive.
    sine, cosine = circle(phase + at.shift)
    end_speed = -INF
    if limit < INF:
        end_speed = free_motion(at.amplitude, at.drag, sine, cosine, speed, limit).velocity
    stopped = not endless and high > low and (high == fall or end_speed <= 0.0)
    if not stopped and limit == INF:
        return _SlideEnd(INF, False, NAN, NAN, True)
    length = limit
    if stopped:
        length, end_speed = min(offset + _zero_of_speed(at, top, low, high), limit), 0.0
    # of the maxima on the way the first is the highest, or the last where gravity wins over friction
    next_top, last_top = 0.0 if d0 < 0.0 else 1.0, float(math.floor((length + d0) / TURN))
    highest = max(speed, end_speed)
    if last_top >= next_top:
        s = TURN * (last_top if at.drag < 0.0 else next_top) - d0
        highest = max(highest, free_motion(at.amplitude, at.drag, sine, cosine, speed, s).velocity)
    return _SlideEnd(length, stopped, end_speed, highest, math.isfinite(length))


def _zero_of_speed(at: Forcing, top: float, low: float, high: float) -> float:
    """Return the phase after a maximum of the speed at which all of it is lost, in [low, high].

    The loss grows monotonically, so the bracket is proven. Halley's iteration starts from the zero of the
    cubic that is level at both ends, as the loss is. Near a double zero it converges slowly, and halving
    takes over.
    """
    fall = PI + 2.0 * at.kappa
    whole = 2.0 * at.bend + at.drag * fall
    share = min(1.0 - 2.0 * top / whole, 1.0) if top < whole else -1.0
    d = fall * (0.5 - math.sin(math.asin(share) / 3.0))
    for _ in range(_HALLEY_STEPS):
        half_sine = math.sin(0.5 * d)
        versine, sine = 2.0 * half_sine * half_sine, 2.0 * half_sine * math.cos(0.5 * d)
        left = top - at.bend * versine - at.drag * (d - sine) - at.excess * sine
        rate = at.bend * sine + at.drag * versine + at.excess * (1.0 - versine)
        curve = (at.drag - at.excess) * sine + at.bend * (1.0 - versine)
        scale = rate * rate + 0.5 * left * curve
        if scale == 0.0:
            break
        onward = min(max(d + left * rate / scale, low), high)
        step, d = onward - d, onward
        if abs(step) <= _SETTLED * d:
            return d
    return bisected(_speed_left, _Falling(at, top), low, high, True)


class _Falling(NamedTuple):
    """A slide whose speed falls from a maximum."""

    at: Forcing
    top: float


def _speed_left(slide: _Falling, d: float) -> float:
    """Return the speed a phase d after its maximum."""
    return slide.top - _speed_loss(d, slide.at)


def mode_of(loads: Loads, phase: float, velocity: float, friction: float) -> int:
    """Return what a body in contact does, a ``Mode``: at zero velocity the loads decide, Eq. (2).

    ``friction`` is the coefficient that holds it there.
    """
    way = velocity
    if velocity == 0.0:
        at = _ride(loads, phase)
        force = math.copysign(1.0, at.along - loads.weight_tangential)
        if _slips(loads, at, friction, force):
            way = force
    if way == 0.0:
        return Mode.REST
    return Mode.FORWARD if way > 0.0 else Mode.BACK


def _slips(loads: Loads, at: Ride, friction: float, way: float) -> bool:
    """Return whether a body that stands slips in a direction; one that the trough does not press is free."""
    return mixed(beyond_friction(loads, friction, way), at.along, min(at.normal, loads.weight_normal)) > 0.0


def _ride(loads: Loads, phase: float) -> Ride:
    """Evaluate the inertial loads at a phase; of one harmonic without the velocity."""
    if loads.waves.kind != SINE:
        return ride(loads.waves, phase, 0.0)
    along = loads.drive_tangential * trough_along(loads, phase).path
    return Ride(along, loads.drive_normal * math.sin(phase), NAN)


class Leg(NamedTuple):
    """One leg in contact.

    Attributes
    ----------
    length : float
        Phase from its start to its end; inf where it never ends [rad].
    velocity : float
        Relative velocity at its end; as the next one and ``top`` NaN where it never ends.
    displacement : float
        Displacement relative to the trough.
    next_mode : int
        The ``Mode`` that follows, as long as the contact lasts.
    impulse : float
        Normal impulse while it slides, with the sign of its velocity.
    gain : float
        Change of the velocity after the leg per change of it before, in [0, 1], Eq. (26).
    top : float
        Largest speed.
    settled : bool
        Whether its end was found to rounding.
    spare : float
        How much its phases and speeds, over the loads, may change until another leg follows; inf of one
        harmonic [rad].
    """

    length: float
    velocity: float
    displacement: float
    next_mode: int
    impulse: float
    gain: float
    top: float
    settled: bool
    spare: float


def contact_leg(track: Track, mode: int, phase: float, velocity: float, limit: float) -> Leg:
    """Follow a body through one leg in contact.

    Parameters
    ----------
    track : Track
        Its scene.
    mode : int
        What it does: ``Mode.REST``, ``FORWARD`` or ``BACK``.
    phase, velocity : float
        Its state [rad, A w].
    limit : float
        Phase from here to the end of the contact; inf where there is none [rad].
    """
    if mode == Mode.REST:
        return _rest(track, phase, limit)
    if mode == Mode.FORWARD:
        return _slide(track.loads, track.forward, 1.0, phase, abs(velocity), limit)
    return _slide(track.loads, track.back, -1.0, phase, abs(velocity), limit)


def _rest(track: Track, phase: float, limit: float) -> Leg:
    """Rest until the nearer onset, which forgets the velocity before."""
    ahead, behind = next_onset(track, 1.0, phase).wait, next_onset(track, -1.0, phase).wait
    next_mode = Mode.FORWARD if ahead <= behind else Mode.BACK
    wait = min(ahead, behind)
    return Leg(min(wait, limit), 0.0, 0.0, next_mode, 0.0, 0.0, 0.0, True, wait)


def _slide(loads: Loads, at: Forcing, way: float, phase: float, speed: float, limit: float) -> Leg:
    """Slide until the body stops or the contact ends."""
    same = Mode.FORWARD if way > 0.0 else Mode.BACK
    if loads.waves.kind != SINE:
        slid = slide_over_waves(loads, way, phase, speed, limit)
        found = _SlideEnd(slid.length, slid.stopped, slid.speed, slid.top, math.isfinite(slid.length))
        if slid.length == INF:
            return Leg(INF, NAN, NAN, same, NAN, 1.0, NAN, True, INF)
        before, then = ride(loads.waves, phase, 0.0), ride(loads.waves, phase, slid.length)
        pressed = loads.weight_normal * slid.length + (then.velocity - before.velocity)
        return _lifted_off(loads, found, way, slid.path, pressed, then)._replace(spare=slid.spare)
    end = slide_from_speed(at, phase, speed, limit)
    if end.length == INF:
        return Leg(INF, NAN, NAN, same, NAN, 1.0, NAN, True, INF)
    sine, cosine = math.sin(phase), math.cos(phase)
    own_sine, own_cosine = sine, cosine
    if not loads.line:
        own_sine, own_cosine = math.sin(phase + at.shift), math.cos(phase + at.shift)
    elif at.shift > 0.0:
        own_sine, own_cosine = -sine, -cosine
    path = free_motion(at.amplitude, at.drag, own_sine, own_cosine, speed, end.length).path
    # the impulse of the trough takes the normal speed that the body would have in flight
    impulse = -free_motion(loads.drive_normal, loads.weight_normal, sine, cosine, 0.0, end.length).velocity
    then = _ride(loads, phase + end.length) if end.stopped else Ride(NAN, NAN, NAN)
    return _lifted_off(loads, end, way, path, impulse, then)


def _lifted_off(loads: Loads, end: _SlideEnd, way: float, path: float, impulse: float, then: Ride) -> Leg:
    """Tell what follows a slide of a path, under a normal impulse: both without their signs.

    ``then`` are the inertial loads at its end, of which only one that stops takes notice.
    """
    next_mode, gain = Mode.FORWARD if way > 0.0 else Mode.BACK, 1.0
    if end.stopped:
        next_mode, gain = Mode.REST, 0.0
        if _slips(loads, then, loads.static_friction, -way):
            friction = loads.kinetic_friction * max(loads.weight_normal - then.normal, 0.0)
            against = way * (loads.weight_tangential - then.along)
            next_mode = Mode.BACK if way > 0.0 else Mode.FORWARD
            gain = (against - friction) / (against + friction)
    return Leg(
        end.length, way * end.speed, way * path, next_mode, way * impulse, gain, end.top, end.settled, INF
    )
