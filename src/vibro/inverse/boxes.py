"""Boxes of bands: every operating point that parts, drift and trough may bring."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple

import numpy as np

from vibro.scene import Scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ends = tuple[Any, Any]  # numbers, or arrays of shape (m, 1)

__all__ = ["AXES", "Box", "Parts", "Points", "inside"]

#: The coordinates of a box of a drive along a line. Amplitude and frequency are one: for a load the speed
#: goes with 1/f.
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


@dataclass(frozen=True, kw_only=True)
class Parts(ABC):
    """A closed box of bands, cut at mu_d <= mu_s, of which this much is the same whatever the drive.

    Both ends of a band are equal where a value is known. Ends may be arrays of shape (m, 1): m boxes at once,
    of which every method serves one a row.

    Attributes
    ----------
    trough_angle, static_friction : pair
        Bands [rad, 1].
    second_friction : pair
        Band of kinetic friction, or of its ratio to the static one [1].
    is_ratio : bool
        Which of the two it is.
    gravity, restitution : float
        As in ``Scene``.
    """

    trough_angle: Ends
    static_friction: Ends
    second_friction: Ends
    is_ratio: bool
    gravity: float
    restitution: float

    #: The coordinates of a box, in order; frictions are last.
    axes: ClassVar[tuple[str, ...]]

    @property
    @abstractmethod
    def load(self) -> tuple[Floats, Floats]:
        """Smallest and largest acceleration of the drive over gravity."""

    @property
    @abstractmethod
    def lift(self) -> Floats:
        """Largest share of such an acceleration that is normal to the trough."""

    @property
    @abstractmethod
    def spans(self) -> tuple[Ends, ...]:
        """Bands of ``axes``, the last one as it is given."""

    @abstractmethod
    def hops(self, points: Any) -> NDArray[np.bool_]:
        """Tell which points throw their bodies."""

    @abstractmethod
    def points(self, shares: Floats) -> Any:
        """Return the points at shares in [0, 1] of the bands, an array of shape (axes, n).

        The share of kinetic friction counts from its lower end to its upper one or to static friction,
        whichever is less.
        """

    @abstractmethod
    def scene(self, points: Any, *, fast: bool) -> Scene:
        """Return scenes at the points, in SI units: of several at a point the fastest, or the slowest."""

    @property
    def varies(self) -> NDArray[np.bool_]:
        """Whether each of ``axes`` has a width, of a single box."""
        return np.array([bool(low < high) for low, high in self.spans])

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


@dataclass(frozen=True, kw_only=True)
class Box(Parts):
    """A closed box of bands of a drive along a line.

    Attributes
    ----------
    amplitude, frequency, drive_angle : pair
        Bands [m, Hz, rad].
    """

    amplitude: Ends
    frequency: Ends
    drive_angle: Ends

    axes = AXES

    @property
    def load(self) -> tuple[Floats, Floats]:
        """Smallest and largest load G."""
        low, high = (
            np.asarray(a * (2.0 * np.pi * np.asarray(f)) ** 2 / self.gravity)
            for a, f in zip(self.amplitude, self.frequency, strict=True)
        )
        return low, high

    @property
    def lift(self) -> Floats:
        """Largest share of a load that is normal to the trough."""
        return np.asarray(np.sin(self.drive_angle[1]))

    @property
    def spans(self) -> tuple[Ends, ...]:
        """Bands of ``axes``, the last one as it is given."""
        return (self.load, self.drive_angle, self.trough_angle, self.static_span, self.second_friction)

    def hops(self, points: Points) -> NDArray[np.bool_]:
        """Tell which points throw their bodies."""
        return np.asarray(points.load * np.sin(points.drive_angle) > np.cos(points.trough_angle))

    def points(self, shares: Floats) -> Points:
        """Return the points at shares of the bands."""
        low, high = self.load
        load = inside((low, high), shares[0])
        alpha, beta = inside(self.drive_angle, shares[1]), inside(self.trough_angle, shares[2])
        mu_s = inside(self.static_span, shares[3])
        return Points(load, alpha, beta, mu_s, inside(self.kinetic_span(mu_s), shares[4]))

    def scene(self, points: Points, *, fast: bool) -> Scene:
        """Return scenes at the points, in SI units."""
        # Of all amplitudes and frequencies with the same load the lowest frequency is the fastest, and the
        # highest the slowest, Eq. (52).
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


def inside(ends: Ends, share: Floats) -> Floats:
    """Value at a share of a band: exact at both ends, and never beyond them."""
    low, high = ends
    value: Floats = np.where(share == 1.0, high, np.clip(low + share * (high - low), low, high))
    return value
