"""Operating points of a machine with a body in its trough: the amplitudes at which both agree, Eq. (87).

The machine has the amplitude A_0 without the body, and A_0 / abs(1 + m H z) with it, where m H says how far
the body's mass pulls it, and z = lambda - i delta is the body's share, which depends on A. So operating
points are zeros of A abs(1 + m H z(A)) - A_0. They lie between two proved bounds, Eq. (89). Between these
some amplitudes are looked at, and more where slides begin or change their kind, where z jumps.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.bounces import Flights
from vibro.core.codes import Status
from vibro.core.contact import steady_cycle
from vibro.core.drive import Loads
from vibro.core.feedback import Body, Fed, feed_back, loads_at
from vibro.core.filling import Reaction, Share, reaction_in_contact, reaction_of_hops
from vibro.core.hops import repeating
from vibro.core.limits import CriticalLoads, critical_loads
from vibro.core.machines import (
    Complex,
    Transfer,
    bend,
    filled_natural_frequency,
    over,
    plus,
    scaled,
    size_of,
    times,
    transfer,
)
from vibro.core.numbers import EPS, EXTREME, INF, NAN, Doubles, Operated, Springs, doubles
from vibro.core.return_map import Hops
from vibro.core.scenes import Point
from vibro.core.slides import thresholds

_ROUNDING: Final = 1e-9  # [1] by which bounds are widened
_LEAST: Final = 1e-3  # [1] of the amplitude of a body that sticks: the least of bodies that never rest
# Amplitudes that are looked at between the bounds: logarithms of the ratio of neighbours, and their largest
# number; where one operating point is wanted, and where all of them are listed.
_STEP: Final = 0.03
_MOST_STEPS: Final = 512
_FINE_STEP: Final = 0.002
_MOST_FINE_STEPS: Final = 2048
_FEWEST: Final = 3  # steps between both bounds
# Where slides begin or change their kind shares jump, and have roots of the distance: amplitudes that are
# looked at beside each critical one, and their relative distances.
_CRITICAL: Final = 5
_SIDES: Final = 6
_BEFORE: Final = 1e-12
_FARTHEST: Final = 1e-2
_CLOSING: Final = 200  # steps; smooth zeros take ten
_ZERO: Final = 4.0 * EPS  # [1] residual over A_0 that is rounding
_JUMP: Final = 1e-9  # [1] residual over A_0 that only a jump leaves in a closed bracket
# An operating point is uncertain where the second harmonic over the amplitude exceeds this, of bodies that
# bounce this, or where it changes the speed by more than this [1].
_MOST_HARMONIC: Final = 0.015
_MOST_BOUNCING_HARMONIC: Final = 0.005
_MOST_CHANGE: Final = 0.075


class Machine(NamedTuple):
    """A machine in one cell.

    Attributes
    ----------
    springs : Springs
        Its masses and springs.
    frequency, natural_frequency : float
        Of the drive, and of the empty machine [Hz].
    force : float
        Its amplitude [N], of a crank that of the trough [m].
    filling : float
        Mass of the body in its trough [kg].
    share : Complex
        lambda - i delta where it is known, else NaN [1].
    """

    springs: Springs
    frequency: float
    natural_frequency: float
    force: float
    filling: float
    share: Complex


class Feeder(NamedTuple):
    """A body in the trough of a machine.

    Attributes
    ----------
    machine : Machine
        Without the body.
    still : Transfer
        Its motion.
    body : Body
        The body.
    empty : float
        A_0 [m].
    pull : Complex
        m H [1].
    """

    machine: Machine
    still: Transfer
    body: Body
    empty: float
    pull: Complex


def feeder_of(machine: Machine, one: Point, unit: Loads, flights: Flights, hops: Hops) -> Feeder:
    """Put a body, whose loads at G = 1 are ``unit``, into a machine; ``one`` has an amplitude of 1 m."""
    still = transfer(machine.springs, machine.frequency, machine.natural_frequency, Complex(0.0, 0.0))
    length, empty = one.loads.weight_normal / unit.weight_normal, machine.force * size_of(still.trough)
    pull = scaled(still.compliance, machine.filling)
    return Feeder(machine, still, Body(unit, length, one.restitution, flights, hops), empty, pull)


class OperatingPoint(NamedTuple):
    """The operating point of least amplitude.

    Attributes
    ----------
    amplitude, low, high : float
        Amplitude and its bounds, which differ where the motion there does not repeat; NaN without one [m].
    solved_at : float
        Amplitude at which the status was found, if there is no operating point [m].
    number : int
        Of all operating points between the bounds; 0 where none can be determined.
    status : int
        ``OK``; ``BOUNDARY`` at a jump; ``AVERAGED`` where the share is known to a bound; else why there is
        no steady motion.
    """

    amplitude: float
    low: float
    high: float
    solved_at: float
    number: int
    status: int


class _Trial(NamedTuple):
    """Residual at an amplitude, both in m, and the status of the body there."""

    amplitude: float
    residual: float
    status: int


class _Ascent(NamedTuple):
    """What was found on the way up.

    Attributes
    ----------
    above : bool
        Whether the residual was positive at the last amplitude where the share is known.
    known, last : _Trial
        Of that amplitude, and of the last one at all.
    number : int
        Changes of sign so far.
    doubted : float
        Amplitude before the first motion that does not repeat; inf if there was none.
    failed : _Trial
        The first one without a steady motion; its status is OK if there was none.
    """

    above: bool
    known: _Trial
    last: _Trial
    number: int
    doubted: float
    failed: _Trial


def operating_point(feeder: Feeder, step: float, most: int, found: Doubles, room: int) -> OperatingPoint:
    """Find the least operating point, and count all of them.

    Parameters
    ----------
    feeder : Feeder
        The machine with the body.
    step : float
        Between the logarithms of amplitudes that are looked at.
    most : int
        Number of these steps at most.
    found : Doubles
        Is written with the amplitudes of all operating points, as far as it has room.
    room : int
        Their number at most.
    """
    loads, length, critical = feeder.body.unit, feeder.body.length, critical_loads(feeder.body.unit)
    onset = length * _first_onset(critical) if loads.static_friction > 0.0 else 0.0
    stuck, reach = _shrunk(feeder, Complex(1.0, 0.0)), _reach(feeder)
    low = max(feeder.empty * (1.0 - _ROUNDING) - reach, onset * (1.0 - _BEFORE))
    low = low if low > 0.0 else _LEAST * stuck
    high = (feeder.empty + reach) * (1.0 + _ROUNDING)
    sticks = stuck <= onset
    point = OperatingPoint(NAN, NAN, NAN, stuck, 0, Status.OK)
    if sticks:
        point = OperatingPoint(stuck, stuck, stuck, stuck, 1, Status.OK)
        _write(found, room, 0, stuck)
    below = _Trial(low, -1.0, Status.OK)
    ascent = _Ascent(sticks, below, below, 1 if sticks else 0, INF, below)
    places = doubles(_SIDES * _CRITICAL)
    _write_sides(places, 0, length * critical.hop)
    _write_sides(places, _SIDES, length * critical.forward_onset)
    _write_sides(places, 2 * _SIDES, length * critical.back_onset)
    _write_sides(places, 3 * _SIDES, length * critical.back_slip)
    _write_sides(places, 4 * _SIDES, length * critical.continuous_sliding)
    span = math.log(high / low) if low < high else 0.0
    steps = min(max(int(math.ceil(span / step)), _FEWEST), most)
    amplitude, first = 0.0, True
    for k in range(steps + 1 if span > 0.0 else 0):
        end = low * math.exp(span * (k / steps))
        for _ in range(_SIDES * _CRITICAL + 1):
            if amplitude >= end:
                break
            amplitude = _next(places, max(amplitude, low), min(end, high)) if k > 0 else end
            trial = _trial(feeder, amplitude)
            known = _is_known(trial.status)
            if known and (trial.residual >= 0.0) != ascent.above:
                if ascent.number < max(room, 1):
                    at = _turn(feeder, ascent, trial, first)
                    _write(found, room, ascent.number, at.amplitude)
                    if ascent.number == 0:
                        point = at
                ascent = ascent._replace(above=not ascent.above, number=ascent.number + 1)
            ascent = _after(ascent, trial, known)
            first = first and not known
    if not ascent.above and span > 0.0:  # at the upper bound the residual is not negative, known or not
        at = _unknown(ascent, high)
        _write(found, room, ascent.number, at.amplitude)
        if ascent.number == 0:
            point = at
        ascent = ascent._replace(number=ascent.number + 1)
    return point if math.isnan(point.amplitude) else point._replace(number=ascent.number)


def _write(found: Doubles, room: int, row: int, amplitude: float) -> None:
    if row < room:
        found[row] = amplitude


def _first_onset(critical: CriticalLoads) -> float:
    """Load at which slides begin; 0 where it is unknown."""
    if math.isnan(critical.forward_onset):
        return 0.0
    return min(critical.forward_onset, critical.back_onset)


def _write_sides(places: Doubles, row: int, amplitude: float) -> None:
    """Write amplitudes beside a critical one, which is exact to a few ulp."""
    places[row] = amplitude * (1.0 - _BEFORE)
    places[row + 1] = amplitude * (1.0 + _BEFORE)
    distance = _FARTHEST
    for i in range(2, _SIDES):
        places[row + i] = amplitude * (1.0 + distance)
        distance *= 0.1


def _next(places: Doubles, low: float, high: float) -> float:
    """Return the next amplitude to look at above ``low``: one of these places, else ``high``."""
    least = high
    for i in range(_SIDES * _CRITICAL):
        if low < places[i] < least:
            least = places[i]
    return least


def _is_known(status: int) -> bool:
    return status == Status.OK or status == Status.BOUNDARY


def _shrunk(feeder: Feeder, share: Complex) -> float:
    """Return the amplitude with a body of a known share; infinite where it brings resonance."""
    shrinks = size_of(plus(Complex(1.0, 0.0), times(feeder.pull, share)))
    return feeder.empty / shrinks if shrinks > 0.0 else INF


def _reach(feeder: Feeder) -> float:
    """Return an upper bound of m abs(H) A abs(lambda - i delta) for all amplitudes, Eq. (89) [m]."""
    loads = feeder.body.unit
    pressed = loads.drive_normal + loads.static_friction * loads.drive_tangential
    return size_of(feeder.pull) * 2.0 * pressed * loads.weight_normal * feeder.body.length


def _share_at(feeder: Feeder, amplitude: float) -> Share:
    """Return what a body weighs under a sine."""
    body = feeder.body
    loads = loads_at(body, amplitude)
    at = thresholds(loads)
    found, status, displacement = Reaction(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), 0, 0.0
    if at.hops and loads.kinetic_friction <= loads.static_friction:
        hop = repeating(loads, body.restitution, body.flights, body.hops)
        status, displacement = hop.status, hop.displacement
        if _is_known(status):
            found = reaction_of_hops(loads, body.restitution, body.flights, body.hops)
    else:
        cycle = steady_cycle(loads, at)
        status, displacement = cycle.status, cycle.displacement
        if _is_known(status):
            found = reaction_in_contact(loads, cycle.pattern)
    if status == Status.UNRESOLVED:
        status = int(Status.AVERAGED)
    return Share(found, status, displacement)


def _trial(feeder: Feeder, amplitude: float) -> _Trial:
    """Look at an amplitude; where the share is unknown its residual is that of none."""
    found = _share_at(feeder, amplitude)
    share = Complex(found.reaction.added_mass, -found.reaction.added_damping)
    shrinks = size_of(plus(Complex(1.0, 0.0), times(feeder.pull, share)))
    return _Trial(amplitude, amplitude * shrinks - feeder.empty, found.status)


def _after(ascent: _Ascent, trial: _Trial, known: bool) -> _Ascent:
    """Go on behind an amplitude."""
    if known:
        return ascent._replace(known=trial, last=trial)
    if trial.status == Status.AVERAGED:
        return ascent._replace(doubted=min(ascent.doubted, ascent.last.amplitude), last=trial)
    failed = trial if ascent.failed.status == Status.OK else ascent.failed
    return ascent._replace(failed=failed, last=trial)


def _turn(feeder: Feeder, ascent: _Ascent, trial: _Trial, first: bool) -> OperatingPoint:
    """Find the operating point before an amplitude at which the sign has changed."""
    if ascent.failed.status != Status.OK or ascent.last.amplitude > ascent.known.amplitude:
        return _unknown(ascent, trial.amplitude)
    if first and ascent.last.amplitude == ascent.known.amplitude:  # at the bound, which is exact to rounding
        point = OperatingPoint(
            trial.amplitude, trial.amplitude, trial.amplitude, trial.amplitude, 1, Status.OK
        )
    else:
        point = _closed(feeder, ascent.known, trial)
    if ascent.doubted < INF:  # a point may hide in irregular motion at less amplitude too
        return point._replace(low=min(point.low, ascent.doubted), status=int(Status.AVERAGED))
    return point


def _unknown(ascent: _Ascent, high: float) -> OperatingPoint:
    """Say what is known of an operating point amid amplitudes whose shares are not."""
    low = ascent.known.amplitude
    if ascent.failed.status != Status.OK:
        return OperatingPoint(NAN, NAN, NAN, ascent.failed.amplitude, 0, ascent.failed.status)
    amid = ascent.last.amplitude if ascent.last.amplitude > low else high
    return OperatingPoint(amid, min(low, ascent.doubted), high, amid, 1, Status.AVERAGED)


def _closed(feeder: Feeder, low: _Trial, high: _Trial) -> OperatingPoint:
    """Close a bracket, by Chandrupatla's method (1997): inverse quadratic interpolation, else halving."""
    last, other, before, share = high, low, high, 0.5
    for _ in range(_CLOSING):
        trial = _trial(feeder, last.amplitude + share * (other.amplitude - last.amplitude))
        if (trial.residual >= 0.0) == (last.residual >= 0.0):
            before = last
        else:
            before, other = other, last
        last = trial
        best = last if abs(last.residual) < abs(other.residual) else other
        width = abs(other.amplitude - last.amplitude)
        if abs(best.residual) <= _ZERO * feeder.empty or width <= 4.0 * EPS * best.amplitude:
            break
        share = _next_share(last, other, before)
        least = 2.0 * EPS * best.amplitude / width
        share = min(max(share, least), 1.0 - least)
    left, right = (last, other) if last.amplitude < other.amplitude else (other, last)
    below, above = abs(left.residual), abs(right.residual)
    jumps = min(below, above) > _JUMP * feeder.empty
    best = left if jumps or below <= above else right
    if _is_known(best.status) and (_is_known(right.status) or not jumps):
        status = int(Status.BOUNDARY) if jumps else int(Status.OK)
        return OperatingPoint(best.amplitude, best.amplitude, best.amplitude, best.amplitude, 1, status)
    at = best if not _is_known(best.status) else right
    return OperatingPoint(at.amplitude, low.amplitude, high.amplitude, at.amplitude, 1, Status.AVERAGED)


def _next_share(last: _Trial, other: _Trial, before: _Trial) -> float:
    """Return where in a bracket, from its last end on, to look next."""
    x, y, z = last.amplitude, other.amplitude, before.amplitude
    f, g, h = last.residual, other.residual, before.residual
    place, height = (x - y) / (z - y), (f - g) / (h - g)
    if height * height < place and (1.0 - height) * (1.0 - height) < 1.0 - place:
        return f / (g - f) * (h / (g - h)) + (z - x) / (y - x) * (f / (h - f)) * (g / (h - g))
    return 0.5


# ------------------------------------------------------------------------------
# All that a machine does at its operating point.


def all_amplitudes(feeder: Feeder, found: Doubles, room: int) -> int:
    """List the amplitudes of all operating points under a sine, if there is room; return their number."""
    return operating_point(feeder, _FINE_STEP, _MOST_FINE_STEPS, found, room).number


def _fed_back(feeder: Feeder, amplitude: float, sine: Share) -> Fed:
    """Feed the second harmonic back, from the operating point under a sine on."""
    second_pull = _second_pull(feeder.machine)
    return feed_back(feeder.body, feeder.empty, feeder.pull, second_pull, Fed(amplitude, sine, False))


def _second_pull(machine: Machine) -> Complex:
    """Return m H of the empty machine at twice the frequency [1]."""
    still, frequency = Complex(0.0, 0.0), 2.0 * machine.frequency
    moved = transfer(machine.springs, frequency, machine.natural_frequency, still)
    return scaled(moved.compliance, machine.filling)


class _Filled(NamedTuple):
    """An operating point, whether the share jumps there, and it with its second harmonic; NaN if unknown.

    ``sine`` is the amplitude without that harmonic [m], ``uncertain`` whether that changes the motion much.
    """

    point: OperatingPoint
    jumps: bool
    share: Complex
    second: Complex
    sine: float
    uncertain: bool


def _settled(feeder: Feeder) -> _Filled:
    """Find where a machine settles with a body whose share is unknown; a crank does not depend on it."""
    nothing, empty = Complex(NAN, NAN), feeder.empty
    point, stiff = OperatingPoint(empty, empty, empty, empty, 1, Status.OK), size_of(feeder.pull) == 0.0
    none = doubles(1)
    if not stiff:
        point = operating_point(feeder, _STEP, _MOST_STEPS, none, 0)
    found = _share_at(feeder, point.solved_at)
    known, jumps = _is_known(found.status), point.status == Status.BOUNDARY
    if stiff or point.status == Status.OK:
        point = point._replace(status=found.status)
        if not stiff and not known:
            point = point._replace(amplitude=NAN, low=NAN, high=NAN, number=0)
    if not known or math.isnan(point.amplitude):
        return _Filled(point, jumps, nothing, nothing, point.amplitude, False)
    sine, uncertain = point.amplitude, False
    if _is_known(point.status):
        fed = _fed_back(feeder, sine, found)
        uncertain, found = _is_uncertain(feeder, fed), fed.share
        if fed.agrees and fed.amplitude != sine:
            a, jumps = fed.amplitude, False
            point = OperatingPoint(a, a, a, a, point.number, found.status)
    reaction = found.reaction
    share = Complex(reaction.added_mass, -reaction.added_damping)
    second = Complex(reaction.second_real, reaction.second_imaginary)
    return _Filled(point, jumps, share, second, sine, uncertain)


def _is_uncertain(feeder: Feeder, fed: Fed) -> bool:
    """Return whether the second harmonic changes the motion of the body much, or no agreement was found."""
    body, reaction = feeder.body, fed.share.reaction
    force = Complex(reaction.second_real, reaction.second_imaginary)
    harmonic = 0.25 * size_of(_second_pull(feeder.machine)) * size_of(force)
    if harmonic == 0.0:
        return False
    loads = loads_at(body, fed.amplitude)
    bounces = body.restitution > 0.0 and loads.drive_normal > loads.weight_normal
    if not fed.agrees or harmonic > (_MOST_BOUNCING_HARMONIC if bounces else _MOST_HARMONIC):
        return True
    sine = _share_at(feeder, fed.amplitude)
    change = abs(fed.share.displacement - sine.displacement)
    return not (_is_known(sine.status) and change <= _MOST_CHANGE * abs(sine.displacement))


def write_operated(feeder: Feeder, out: Operated, row: int) -> None:
    """Find the operating point of least amplitude, and write what the machine does there.

    Where the empty trough's amplitude is not allowed, nothing is searched.
    """
    machine, empty, mass = feeder.machine, feeder.empty, feeder.machine.filling
    springs = machine.springs
    allowed = springs.narrowest < empty <= springs.widest and size_of(feeder.pull) < EXTREME
    amplitude = empty
    if mass > 0.0 and not math.isnan(machine.share.real):
        amplitude = _shrunk(feeder, machine.share)
    start = OperatingPoint(amplitude, amplitude, amplitude, amplitude, 1, Status.OK)
    at = _Filled(start, False, machine.share, Complex(NAN, NAN), amplitude, False)
    if allowed and mass > 0.0 and math.isnan(machine.share.real):
        at = _settled(feeder)
    point, share = at.point, at.share
    infinite = not (allowed or empty <= springs.narrowest) or point.amplitude == INF
    # a crank moves its trough as it does, whatever the share is
    unsure = mass > 0.0 and math.isnan(share.real) and size_of(feeder.pull) > 0.0
    unsure = unsure and point.status == Status.AVERAGED
    frequency, natural = machine.frequency, machine.natural_frequency
    added, moved, harmonic = Complex(0.0, 0.0), feeder.still, Complex(0.0, 0.0)
    if mass > 0.0:
        harmonic = times(scaled(at.second, -0.25), _second_pull(machine))  # Eq. (90)
        if not math.isnan(share.real):
            added = scaled(share, mass)
            moved = transfer(springs, frequency, natural, added)
    relative = point.amplitude * bend(moved)
    if unsure:
        relative = _most_relative(feeder, point.high)
    if infinite:
        relative = INF
    strikes = relative > springs.gap or infinite
    phase, ratio = NAN, NAN
    if not unsure and not math.isnan(point.amplitude):
        phase = math.atan2(moved.trough.imaginary + 0.0, moved.trough.real + 0.0)
        filled = filled_natural_frequency(springs, natural, added.real)
        ratio = frequency / filled if filled > 0.0 else INF
    if strikes:
        point = point._replace(amplitude=NAN, low=NAN, high=NAN, number=0)
    out.amplitude[row] = point.amplitude
    out.amplitude_low[row], out.amplitude_high[row] = point.low, point.high
    out.amplitude_empty[row] = empty if allowed or empty <= springs.narrowest else INF
    out.solved_at[row] = min(springs.widest, empty) if infinite else point.solved_at
    out.phase[row], out.relative_amplitude[row], out.filled_frequency_ratio[row] = phase, relative, ratio
    out.added_mass_share[row], out.added_damping_share[row] = share.real, 0.0 - share.imaginary
    out.second_real[row], out.second_imaginary[row] = harmonic.real, harmonic.imaginary
    out.amplitude_sine[row] = NAN if strikes else at.sine
    out.number[row], out.status[row] = point.number, point.status
    out.strikes[row], out.at_jump[row] = 1 if strikes else 0, 1 if at.jumps else 0
    out.uncertain[row] = 1 if at.uncertain else 0


def _most_relative(feeder: Feeder, high: float) -> float:
    """Return an upper bound of the relative amplitude, whatever the share is [m].

    Over the amplitude of the trough it is linear in the added mass, of which Eq. (89) bounds m A abs(z).
    """
    machine, still = feeder.machine, feeder.still
    one = transfer(machine.springs, machine.frequency, machine.natural_frequency, Complex(1.0, 0.0))
    own, more = over(still.relative, still.trough), over(one.relative, one.trough)
    slope = size_of(plus(more, scaled(own, -1.0)))
    return high * size_of(own) + slope * _reach(feeder) / size_of(still.compliance)
