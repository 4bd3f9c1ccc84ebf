"""Loads of a drive on the body, over the inertial load m A w^2: everything that decides its motion.

Equation numbers are those of docs/theory.md. Phases are those of the trough's motion normal to itself, which
leads its motion along itself by phi: the inertial load off the trough is ``drive_normal * sin(p)``, that
along it ``drive_tangential * sin(p - phi)``. So lift-off and flights do not depend on phi. A drive along a
line has phi = 0.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.elementary import QUARTER, TURN

__all__ = [
    "Directions", "Loads", "along_cosine", "along_sine", "directions", "ellipse_loads", "ellipse_scale",
    "line_loads", "mirrored", "normal_load", "phase_difference", "tangential_load", "weight_over_load",
]  # fmt: skip

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


class Directions(NamedTuple):
    """What the angles of a scene contribute to its loads: the same for many cells of a map.

    ``first`` is the drive angle of a line, and the phase difference phi of an ellipse; ``sum_cosine`` is
    cos(alpha + beta) of a line.
    """

    first: float
    trough: float
    cosine: float
    sine: float
    trough_cosine: float
    trough_sine: float
    sum_cosine: float


def directions(first: float, trough: float) -> Directions:
    """Evaluate the trigonometric functions of both angles [rad]."""
    cosine, sine = math.cos(first), math.sin(first)
    if trough == 0.0:
        return Directions(first, trough, cosine, sine, 1.0, 0.0, cosine)
    # the double next to a right angle still has a positive cosine
    total = first + trough
    sum_cosine = math.cos(total) if total < QUARTER else -abs(math.cos(total))
    return Directions(first, trough, cosine, sine, math.cos(trough), math.sin(trough), sum_cosine)


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
    )


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


def along_sine(loads: Loads, phase: float) -> float:
    """Sine of the motion along the trough, at a phase of the normal motion."""
    return math.sin(phase - phase_difference(loads))


def along_cosine(loads: Loads, phase: float) -> float:
    """Cosine of the motion along the trough, at a phase of the normal motion."""
    return math.cos(phase - phase_difference(loads))


def tangential_load(loads: Loads, phase: float) -> float:
    """F of Eq. (54): load along the trough on a body in contact or in flight."""
    return loads.drive_tangential * along_sine(loads, phase) - loads.weight_tangential


def normal_load(loads: Loads, phase: float) -> float:
    """N of Eq. (54): load on the trough, negative where it falls away under the body."""
    return loads.weight_normal - loads.drive_normal * math.sin(phase)
