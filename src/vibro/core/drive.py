"""Loads of a drive on the body, over the inertial load m A w^2: everything that decides its motion.

Equation numbers are those of docs/theory. Phases are those of the trough's motion normal to itself, which
leads its motion along itself by phi: the inertial load off the trough is ``drive_normal * sin(p)``, that
along it ``drive_tangential * sin(p - phi)``. So lift-off and flights do not depend on phi. A drive along a
line has phi = 0.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.numbers import NAN, TURN, PathPoint, free_motion
from vibro.core.waves import (
    FORCE,
    NORMAL,
    SINE,
    STATIC_BACK,
    Mix,
    Waves,
    depart,
    load_at,
    moved,
    one_harmonic,
    trough_at,
)

# [1] Range of 1/G in which no product of it overflows or vanishes; the body rests, or leaves, long before.
_LEAST_WEIGHT: Final = 1e-307
_MOST_WEIGHT: Final = 1e307


class Loads(NamedTuple):
    """Dimensionless groups of one scene, Eq. (1).

    Attributes
    ----------
    drive_tangential, drive_normal : float
        a and b: amplitudes of the inertial load along the trough and off it; cos(alpha) and sin(alpha) of a
        drive along a line, X/A and Y/A of an ellipse, where A is the larger of both.
    weight_normal, weight_tangential : float
        n and t: cos(beta)/G and sin(beta)/G, weight on the trough and down it, G = A w^2 / g.
    weight_across : float
        h = a n - b t = cos(alpha + beta)/G, of lines without its cancellation.
    static_friction, kinetic_friction : float
        mu_s and mu_d.
    phase_sine, phase_cosine : float
        Of phi.
    line : bool
        Whether phi = 0 and h > 0: some formulas are shorter there.
    waves : Waves
        S and B of a drive beyond one harmonic. Then a is a bound of the velocity along the trough, b the
        largest B, and phi = 0.
    """

    drive_tangential: float
    drive_normal: float
    weight_normal: float
    weight_tangential: float
    weight_across: float
    static_friction: float
    kinetic_friction: float
    phase_sine: float
    phase_cosine: float
    line: bool
    waves: Waves = one_harmonic()


class Directions(NamedTuple):
    """What the angles of a scene contribute to its loads.

    ``cosine`` and ``sine`` are of the drive angle of a line, and of the phase difference phi of an ellipse;
    ``sum_cosine`` is cos(alpha + beta) of a line.
    """

    cosine: float
    sine: float
    trough_cosine: float
    trough_sine: float
    sum_cosine: float


def directions(first: float, trough: float) -> Directions:
    """Evaluate the trigonometric functions of both angles [rad]."""
    cosine, sine = math.cos(first), math.sin(first)
    if trough == 0.0:
        return Directions(cosine, sine, 1.0, 0.0, cosine)
    total = first + trough
    # what rounding has taken from the sum decides its cosine next to a right angle
    other = total - first
    lost = (first - (total - other)) + (trough - other)
    sum_cosine = math.cos(total) - lost * math.sin(total)
    return Directions(cosine, sine, math.cos(trough), math.sin(trough), sum_cosine)


def weight_over_load(amplitude: float, frequency: float, gravity: float) -> float:
    """Compute 1/G from factors that stay finite where A, f or G are extreme."""
    w = TURN * frequency
    return min(max(gravity / w / amplitude / w, _LEAST_WEIGHT), _MOST_WEIGHT)


def line_loads(weight: float, angles: Directions, static_friction: float, kinetic_friction: float) -> Loads:
    """Form the groups of a drive along a line, Eq. (1), from 1/G."""
    across = weight * angles.sum_cosine
    return Loads(
        drive_tangential=angles.cosine,
        drive_normal=angles.sine,
        weight_normal=weight * angles.trough_cosine,
        weight_tangential=weight * angles.trough_sine,
        weight_across=across,
        static_friction=static_friction,
        kinetic_friction=kinetic_friction,
        phase_sine=0.0,
        phase_cosine=1.0,
        line=across > 0.0,
        waves=one_harmonic(),
    )


def ellipse_scale(along_amplitude: float, normal_amplitude: float) -> float:
    """Length that the solver counts in: the larger amplitude, 1 m where the trough stands still [m]."""
    scale = max(along_amplitude, normal_amplitude)
    return scale if scale > 0.0 else 1.0


def ellipse_loads(
    along: float, normal: float, weight: float, angles: Directions, static_friction: float,
    kinetic_friction: float,
) -> Loads:  # fmt: skip
    """Form the groups of an elliptical drive, Eq. (1), from X/A, Y/A and 1/G."""
    return Loads(
        drive_tangential=along,
        drive_normal=normal,
        weight_normal=weight * angles.trough_cosine,
        weight_tangential=weight * angles.trough_sine,
        weight_across=0.0,
        static_friction=static_friction,
        kinetic_friction=kinetic_friction,
        phase_sine=angles.sine,
        phase_cosine=angles.cosine,
        line=False,
        waves=one_harmonic(),
    )


def wave_loads(
    waves: Waves, normal: float, weight_normal: float, weight_tangential: float, static_friction: float,
    kinetic_friction: float,
) -> Loads:  # fmt: skip
    """Form the groups of a drive beyond one harmonic; ``normal`` is the largest B."""
    return Loads(
        drive_tangential=waves.velocity,
        drive_normal=normal,
        weight_normal=weight_normal,
        weight_tangential=weight_tangential,
        weight_across=0.0,
        static_friction=static_friction,
        kinetic_friction=kinetic_friction,
        phase_sine=0.0,
        phase_cosine=1.0,
        line=False,
        waves=waves,
    )


def mix_of(loads: Loads, row: int) -> Mix:
    """Return the load whose zeros a row of ``Waves`` holds."""
    n, t = loads.weight_normal, loads.weight_tangential
    if row == FORCE:
        return Mix(-t, 1.0, 0.0)
    if row == NORMAL:
        return Mix(-n, 0.0, 1.0)  # -N, as rows are positive where a body is no longer held
    friction = loads.static_friction if row <= STATIC_BACK else loads.kinetic_friction
    return beyond_friction(loads, friction, -1.0 if row % 2 == 1 else 1.0)  # backward rows are odd


def beyond_friction(loads: Loads, friction: float, way: float) -> Mix:
    """Return the load along the trough, forward (+1.0) or back (-1.0), less friction."""
    return Mix(-(friction * loads.weight_normal + way * loads.weight_tangential), way, friction)


def mirrored(loads: Loads) -> Loads:
    """Look at the drive from the other side: half a turn more of phase, and the slope turned."""
    return loads._replace(
        weight_tangential=-loads.weight_tangential,
        phase_sine=-loads.phase_sine,
        phase_cosine=-loads.phase_cosine,
        line=False,
    )


def phase_difference(loads: Loads) -> float:
    """Phi, in [-pi, pi]; at the phase phi of the normal motion the trough passes phase 0 of its own."""
    return 0.0 if loads.line else math.atan2(loads.phase_sine, loads.phase_cosine)


def trough_along(loads: Loads, phase: float) -> PathPoint:
    """Position and velocity of the trough along itself over a, at a phase of the normal motion."""
    if loads.waves.kind == SINE:
        own = phase - phase_difference(loads)
        return PathPoint(math.sin(own), math.cos(own))
    a, at = loads.drive_tangential, trough_at(loads.waves, False, phase)
    return PathPoint(at.value / a, at.slope / a) if a > 0.0 else PathPoint(0.0, 0.0)


def tangential_load(loads: Loads, phase: float) -> float:
    """F of Eq. (54): load along the trough on a body in contact or in flight."""
    if loads.waves.kind != SINE:
        return load_at(loads.waves, mix_of(loads, FORCE), phase)
    return loads.drive_tangential * trough_along(loads, phase).path - loads.weight_tangential


def normal_load(loads: Loads, phase: float) -> float:
    """N of Eq. (54): load on the trough, negative where it falls away under the body."""
    if loads.waves.kind != SINE:
        return -load_at(loads.waves, mix_of(loads, NORMAL), phase)
    return loads.weight_normal - loads.drive_normal * math.sin(phase)


def free_along(loads: Loads, phase: float, velocity: float, s: float) -> PathPoint:
    """Move along the trough, relative to it, without friction; phases are those of the normal motion."""
    waves = loads.waves
    if waves.kind == SINE:
        at = trough_along(loads, phase)
        return free_motion(loads.drive_tangential, loads.weight_tangential, at.path, at.velocity, velocity, s)
    mix = mix_of(loads, FORCE)
    flown = moved(waves, mix, phase, depart(waves, mix, phase).load, s)
    return PathPoint(velocity * s + flown.path, velocity + flown.velocity)


def free_normal(loads: Loads, phase: float, velocity: float, s: float) -> PathPoint:
    """Move off the trough, relative to it, under the weight alone [A, A w]."""
    waves = loads.waves
    if waves.kind == SINE:
        sine, cosine = math.sin(phase), math.cos(phase)
        return free_motion(loads.drive_normal, loads.weight_normal, sine, cosine, velocity, s)
    mix = mix_of(loads, NORMAL)
    flown = moved(waves, mix, phase, depart(waves, mix, phase).load, s)
    return PathPoint(velocity * s + flown.path, velocity + flown.velocity)


def normal_height(loads: Loads, phase: float) -> float:
    """Height of the trough above its mean position."""
    if loads.waves.kind != SINE:
        return trough_at(loads.waves, True, phase).value
    return loads.drive_normal * math.sin(phase)


def proved_multiplier(loads: Loads, multiplier: float) -> float:
    """Return a multiplier, NaN without kinetic friction unless it is 1.

    Nothing damps a slide there. A body that stops does so at an instant, beside cycles that do not: the
    multiplier of one side is 0, that of the other is 1.
    """
    return NAN if loads.kinetic_friction == 0.0 and multiplier < 1.0 else multiplier
