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
from vibro.core.filling import Reaction, reaction_in_contact, reaction_of_hops
from vibro.core.hops import repeating
from vibro.core.limits import CriticalLoads, critical_loads
from vibro.core.numbers import EPS, INF, NAN, Doubles, doubles, hypotenuse
from vibro.core.return_map import Hops
from vibro.core.slides import thresholds

_ROUNDING: Final = 1e-9  # [1] by which bounds are widened
_LEAST: Final = 1e-3  # [1] of the amplitude of a body that sticks: the least of bodies that never rest
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


class Feeder(NamedTuple):
    """A body in the trough of a machine.

    Attributes
    ----------
    unit : Loads
        Of the body at G = 1.
    length : float
        Amplitude at which G is 1 [m].
    restitution : float
        Of the scene.
    empty : float
        A_0 [m].
    pull_real, pull_imaginary : float
        m H [1].
    flights, hops : Flights, Hops
        Scratch memory.
    """

    unit: Loads
    length: float
    restitution: float
    empty: float
    pull_real: float
    pull_imaginary: float
    flights: Flights
    hops: Hops


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
    loads, length, critical = feeder.unit, feeder.length, critical_loads(feeder.unit)
    pull = hypotenuse(feeder.pull_real, feeder.pull_imaginary)
    onset = length * _first_onset(critical) if loads.static_friction > 0.0 else 0.0
    stuck = feeder.empty / hypotenuse(1.0 + feeder.pull_real, feeder.pull_imaginary)
    friction = loads.static_friction * loads.drive_tangential
    reach = pull * 2.0 * (loads.drive_normal + friction) * loads.weight_normal * length
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


def _trial(feeder: Feeder, amplitude: float) -> _Trial:
    """Look at an amplitude; where the share is unknown its residual is that of none."""
    unit = feeder.unit
    weight = feeder.length / amplitude  # 1/G
    loads = unit._replace(
        weight_normal=weight * unit.weight_normal,
        weight_tangential=weight * unit.weight_tangential,
        weight_across=weight * unit.weight_across,
    )
    at = thresholds(loads)
    found, status = Reaction(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), 0
    if at.hops:
        hop = repeating(loads, feeder.restitution, feeder.flights, feeder.hops)
        status = hop.status
        if _is_known(status):
            found = reaction_of_hops(loads, feeder.restitution, feeder.flights, feeder.hops)
    else:
        cycle = steady_cycle(loads, at)
        status = cycle.status
        if _is_known(status):
            found = reaction_in_contact(loads, cycle.pattern)
    if status == Status.UNRESOLVED:
        status = int(Status.AVERAGED)
    mass, damping = found.added_mass, found.added_damping
    real = 1.0 + (feeder.pull_real * mass + feeder.pull_imaginary * damping)
    imaginary = feeder.pull_imaginary * mass - feeder.pull_real * damping
    return _Trial(amplitude, amplitude * hypotenuse(real, imaginary) - feeder.empty, status)


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
        share = _share(last, other, before)
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


def _share(last: _Trial, other: _Trial, before: _Trial) -> float:
    """Return where in a bracket, from its last end on, to look next."""
    x, y, z = last.amplitude, other.amplitude, before.amplitude
    f, g, h = last.residual, other.residual, before.residual
    place, height = (x - y) / (z - y), (f - g) / (h - g)
    if height * height < place and (1.0 - height) * (1.0 - height) < 1.0 - place:
        return f / (g - f) * (h / (g - h)) + (z - x) / (y - x) * (f / (h - f)) * (g / (h - g))
    return 0.5
