"""Boxes of bands: every operating point that parts, drift and trough may bring."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ends = tuple[Any, Any]  # numbers, or arrays of shape (m, 1)

__all__ = ["AXES", "Box", "Points"]

#: The coordinates of a box, in order. Amplitude and frequency are one: for a load the speed goes with 1/f.
AXES: Final = ("load", "drive_angle", "trough_angle", "static_friction", "second_friction")


class Points(NamedTuple):
    """Points of a box, 1-D: what decides a body's motion up to the scales of length and time.

    Attributes
    ----------
    load : array
        G = A w^2 / g [1].
    drive_angle, trough_angle : array
        [rad].
    static_friction, kinetic_friction : array
        mu_s and mu_d [1].
    """

    load: Floats
    drive_angle: Floats
    trough_angle: Floats
    static_friction: Floats
    kinetic_friction: Floats


@dataclass(frozen=True)
class Box:
    """A closed box of bands, cut at mu_d <= mu_s; both ends of a band are equal where a value is known.

    Ends may be arrays of shape (m, 1): m boxes at once, of which every method serves one a row.

    Attributes
    ----------
    amplitude, frequency, drive_angle, trough_angle, static_friction : pair
        Bands [m, Hz, rad, rad, 1].
    second_friction : pair
        Band of kinetic friction, or of its ratio to the static one [1].
    is_ratio : bool
        Which of the two it is.
    gravity, restitution : float
        As in ``Scene``.
    """

    amplitude: Ends
    frequency: Ends
    drive_angle: Ends
    trough_angle: Ends
    static_friction: Ends
    second_friction: Ends
    is_ratio: bool
    gravity: float
    restitution: float

    @property
    def load(self) -> tuple[Floats, Floats]:
        """Smallest and largest load G."""
        low, high = (
            np.asarray(a * (2.0 * np.pi * np.asarray(f)) ** 2 / self.gravity)
            for a, f in zip(self.amplitude, self.frequency, strict=True)
        )
        return low, high

    @property
    def constants(self) -> dict[str, float]:
        """What has no band, by the fields of ``Scene``."""
        return {"gravity": self.gravity, "restitution": self.restitution}

    @property
    def static_span(self) -> Ends:
        """Smallest and largest static friction: not below what kinetic friction there is."""
        low, high = self.static_friction
        return (low, high) if self.is_ratio else (np.maximum(low, self.second_friction[0]), high)

    def kinetic_span(self, static_friction: Floats) -> tuple[Floats, Floats]:
        """Smallest and largest kinetic friction beside a static friction."""
        low, high = (
            np.minimum(end * static_friction if self.is_ratio else end, static_friction)
            for end in self.second_friction
        )
        return low, high

    @property
    def spans(self) -> tuple[Ends, ...]:
        """Bands of ``AXES``, the last one as it is given."""
        return (self.load, self.drive_angle, self.trough_angle, self.static_span, self.second_friction)

    @property
    def varies(self) -> NDArray[np.bool_]:
        """Whether each of ``AXES`` has a width, of a single box."""
        return np.array([bool(low < high) for low, high in self.spans])

    def points(self, shares: Floats) -> Points:
        """Return the points at shares in [0, 1] of the bands, an array of shape (5, n) in the order of AXES.

        The share of kinetic friction counts from its lower end to its upper one or to static friction,
        whichever is less.
        """
        low, high = self.load
        load = _inside((low, high), shares[0])
        alpha, beta = _inside(self.drive_angle, shares[1]), _inside(self.trough_angle, shares[2])
        mu_s = _inside(self.static_span, shares[3])
        return Points(load, alpha, beta, mu_s, _inside(self.kinetic_span(mu_s), shares[4]))

    def scene(self, points: Points, *, fast: bool) -> Scene:
        """Return scenes at the points, in SI units.

        Of all amplitudes and frequencies with the same load the lowest frequency is the fastest, and the
        highest the slowest, Eq. (52); ``fast`` says which is taken.
        """
        weight = points.load * self.gravity / (4.0 * math.pi**2)  # A f^2
        (a_low, a_high), (f_low, f_high) = self.amplitude, self.frequency
        with np.errstate(over="ignore"):  # beyond the range of doubles, and so beyond the band
            frequency = np.clip(np.sqrt(weight / (a_high if fast else a_low)), f_low, f_high)
        amplitude = np.clip(weight / (frequency * frequency), a_low, a_high)
        return Scene.allowing_infeasible(
            amplitude=amplitude,
            frequency=frequency,
            drive_angle=points.drive_angle,
            static_friction=points.static_friction,
            kinetic_friction=points.kinetic_friction,
            trough_angle=points.trough_angle,
            **self.constants,
        )


def _inside(ends: Ends, share: Floats) -> Floats:
    """Value at a share of a band: exact at both ends, and never beyond them."""
    low, high = ends
    value: Floats = np.where(share == 1.0, high, np.clip(low + share * (high - low), low, high))
    return value
