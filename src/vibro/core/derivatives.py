"""How the displacement of a steady contact cycle follows the loads, in closed form.

Equation numbers are those of docs/theory. Lengths in A, phases in radians.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vibro.core.codes import Pattern
from vibro.core.cycle_slides import SlideLeg, cycle_slides
from vibro.core.drives import Loads, normal_load, phase_difference
from vibro.core.elementary import NAN, hypotenuse

__all__ = ["Change", "displacement_rate", "load_slope"]


class Change(NamedTuple):
    """Rates at which the groups of ``Loads`` change with one input; ``phase`` is that of phi [rad]."""

    drive_tangential: float
    drive_normal: float
    weight_normal: float
    weight_tangential: float
    static_friction: float
    kinetic_friction: float
    phase: float


class _Load(NamedTuple):
    """Load of a direction, Eq. (55): amplitude C, and the rates of C, of psi and of (mu n + s t) / C."""

    amplitude: float
    amplitude_rate: float
    phase_rate: float
    ratio_rate: float


class _Response(NamedTuple):
    """Response of a slide to a change; phases are those of the normal motion.

    Its end moves by ``end`` plus ``end_gain`` times the shift of its start [rad], its displacement changes by
    ``path`` plus ``path_gain`` times that [A].
    """

    end: float
    end_gain: float
    path: float
    path_gain: float


def load_slope(loads: Loads, pattern: int) -> float:
    """Differentiate the displacement with respect to ln G, the amplitudes keeping their ratio.

    0 at rest; NaN where there is no steady contact cycle. Just above an onset it grows without bound, like 1
    over the root of the distance.
    """
    weight, along = -loads.weight_normal, -loads.weight_tangential
    return displacement_rate(loads, pattern, Change(0.0, 0.0, weight, along, 0.0, 0.0, 0.0))


def displacement_rate(loads: Loads, pattern: int, change: Change) -> float:
    """Differentiate the displacement of a steady contact cycle by one input, Eqs. (45)-(50) and (64).

    Within its pattern: 0 at rest, NaN where there is no steady contact cycle of up to two slides.
    """
    if pattern == Pattern.R:
        return 0.0
    slides = cycle_slides(loads, pattern)
    first, second = slides.first, slides.second
    if first.way == 0.0 or math.isnan(first.displacement):
        return NAN
    one = _respond(loads, change, first)
    if second.way == 0.0:
        return one.path + one.path_gain * _start_shift(loads, change, first)
    if math.isnan(second.displacement):
        return NAN
    two = _respond(loads, change, second)
    if first.from_rest:
        one_shift = _start_shift(loads, change, first)
        two_shift = one.end + one.end_gain * one_shift
        if second.from_rest:
            two_shift = _start_shift(loads, change, second)
    elif second.from_rest:
        two_shift = _start_shift(loads, change, second)
        one_shift = two.end + two.end_gain * two_shift
    else:  # continuous sliding: both starts follow each other, Eq. (64)
        closing = _closing(loads, first, second)
        if closing == 0.0:  # next to no friction: any cycle closes
            return NAN
        one_shift = (two.end + two.end_gain * one.end) / closing
        two_shift = one.end + one.end_gain * one_shift
    return one.path + one.path_gain * one_shift + two.path + two.path_gain * two_shift


def _load_rates(loads: Loads, change: Change, way: float, friction: float, friction_rate: float) -> _Load:
    """Differentiate C, psi and the ratio of resistance to load, Eq. (49)."""
    along, b = way * loads.drive_tangential, loads.drive_normal
    real = along * loads.phase_cosine + friction * b
    imaginary = -along * loads.phase_sine
    size = hypotenuse(real, imaginary)
    if size == 0.0:
        return _Load(NAN, NAN, NAN, NAN)
    rate = way * change.drive_tangential
    real_rate = rate * loads.phase_cosine - along * loads.phase_sine * change.phase
    real_rate += friction_rate * b + friction * change.drive_normal
    imaginary_rate = -rate * loads.phase_sine - along * loads.phase_cosine * change.phase
    size_rate = (real * real_rate + imaginary * imaginary_rate) / size
    phase_rate = (real / size * imaginary_rate - imaginary / size * real_rate) / size
    resistance = friction * loads.weight_normal + way * loads.weight_tangential
    resistance_rate = friction_rate * loads.weight_normal + friction * change.weight_normal
    resistance_rate += way * change.weight_tangential
    return _Load(size, size_rate, phase_rate, (resistance_rate - resistance / size * size_rate) / size)


def _start_shift(loads: Loads, change: Change, leg: SlideLeg) -> float:
    """Rate of the phase at which a slide starts from rest, on the edge of its static window."""
    static = _load_rates(loads, change, leg.way, loads.static_friction, change.static_friction)
    return static.ratio_rate / math.sin(leg.start.window) - static.phase_rate


def _respond(loads: Loads, change: Change, leg: SlideLeg) -> _Response:
    """Differentiate a slide, Eqs. (45) and (46)."""
    kinetic = _load_rates(loads, change, leg.way, loads.kinetic_friction, change.kinetic_friction)
    onset = leg.start.onset
    x = 0.5 * (leg.end - leg.begin)
    u = x - onset.c
    braking = 2.0 * math.sin(u) * math.sin(x) - onset.excess  # k - sin p1
    if braking == 0.0:  # friction and load balance where it ends, which then has no derivative
        return _Response(NAN, NAN, NAN, NAN)
    turned = kinetic.phase_rate  # a later phase of the slide's own
    end = -(2.0 * x * kinetic.ratio_rate + onset.excess * turned) / braking - turned
    reach = leg.displacement / onset.load  # with its sign
    lost = 2.0 * x * onset.load * leg.way
    path = reach * kinetic.amplitude_rate - lost * (x * kinetic.ratio_rate + onset.excess * turned)
    return _Response(end, -onset.excess / braking, path, -lost * onset.excess)


def _closing(loads: Loads, first: SlideLeg, second: SlideLeg) -> float:
    """1 - T' of continuous sliding, section 5, from terms of one sign.

    At each turn the load along the trough is common to both slides, and friction changes its sign.
    """
    phi = phase_difference(loads)
    own = first.start.onset.load * first.start.onset.excess
    other = second.start.onset.load * second.start.onset.excess
    before = 2.0 * loads.kinetic_friction * normal_load(loads, first.begin + phi)
    between = 2.0 * loads.kinetic_friction * normal_load(loads, second.begin + phi)
    if own + before == 0.0 or other + between == 0.0:
        return 0.0
    return before / (own + before) + between / (other + between) * (own / (own + before))
