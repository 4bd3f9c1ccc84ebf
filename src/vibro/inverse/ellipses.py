"""Boxes of bands of an elliptical drive, and the bodies that stand for them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.inverse.boxes import Parts, inside
from vibro.inverse.evolution import evolve, sobol
from vibro.inverse.extremes import corners
from vibro.limits import critical_loads
from vibro.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from vibro.inverse.boxes import Ends

    Floats = NDArray[np.float64]

__all__ = ["EllipticalBodies", "EllipticalBox", "EllipticalPoints", "critical", "extreme_ratio"]

_FIRST: Final = 5  # base-2 logarithm of the bodies looked at first, beside corners
_GENERATIONS: Final = 60
_SEED: Final = 1
_SAME: Final = 6  # digits of shares in which bodies differ


class EllipticalPoints(NamedTuple):
    """Points of a box, by the fields of ``Scene`` [m, m, rad, Hz, rad, 1, 1]."""

    along_amplitude: Floats
    normal_amplitude: Floats
    normal_phase: Floats
    frequency: Floats
    trough_angle: Floats
    static_friction: Floats
    kinetic_friction: Floats


@dataclass(frozen=True, kw_only=True)
class EllipticalBox(Parts):
    """A closed box of bands of an elliptical drive.

    Attributes
    ----------
    factor : pair
        Band of what both amplitudes are multiplied with: they drift together [1].
    along_amplitude, normal_amplitude, normal_phase, frequency : pair
        Bands [m, m, rad, Hz].
    """

    along_amplitude: Ends
    normal_amplitude: Ends
    normal_phase: Ends
    frequency: Ends
    factor: Ends = (1.0, 1.0)

    axes = (
        "factor", "along_amplitude", "normal_amplitude", "normal_phase", "frequency", "trough_angle",
        "static_friction", "second_friction",
    )  # fmt: skip

    @property
    def load(self) -> tuple[Floats, Floats]:
        """Smallest and largest acceleration normal to the trough over gravity."""
        low, high = (
            np.asarray(s * y * (2.0 * np.pi * np.asarray(f)) ** 2 / self.gravity)
            for s, y, f in zip(self.factor, self.normal_amplitude, self.frequency, strict=True)
        )
        return low, high

    @property
    def lift(self) -> Floats:
        """Largest share of a load that is normal to the trough."""
        return np.ones(())

    @property
    def spans(self) -> tuple[Ends, ...]:
        """Bands of ``axes``, the last one as it is given."""
        return (
            self.factor, self.along_amplitude, self.normal_amplitude, self.normal_phase, self.frequency,
            self.trough_angle, self.static_span, self.second_friction,
        )  # fmt: skip

    def hops(self, points: EllipticalPoints) -> NDArray[np.bool_]:
        """Tell which points throw their bodies."""
        w = 2.0 * np.pi * points.frequency
        return np.asarray(points.normal_amplitude * w**2 / self.gravity > np.cos(points.trough_angle))

    def points(self, shares: Floats) -> EllipticalPoints:
        """Return the points at shares of the bands."""
        factor, *others, mu_s = (inside(span, s) for span, s in zip(self.spans[:-1], shares, strict=False))
        x, y, phase, frequency, beta = others
        mu_d = inside(self.kinetic_span(mu_s), shares[-1])
        return EllipticalPoints(factor * x, factor * y, phase, frequency, beta, mu_s, mu_d)

    def scene(self, points: EllipticalPoints, *, fast: bool) -> Scene:  # a point is one scene
        """Return scenes at the points, in SI units."""
        return Scene.allowing_infeasible(**points._asdict(), **self.constants)


class EllipticalBodies(NamedTuple):
    """Bodies of a box, at shares of its bands, of shape (axes, n)."""

    shares: Floats

    def joined(self, box: Any, shares: Floats) -> EllipticalBodies:  # wherever they move
        """Add bodies; those that are there already are left out."""
        both = np.hstack([self.shares, shares])
        _, first = np.unique(np.round(both, _SAME), axis=1, return_index=True)
        return EllipticalBodies(both[:, np.sort(first)])

    def at(self, boxes: EllipticalBox) -> Floats:
        """Return the shares of all bodies in m boxes, of shape (axes, m, n)."""
        m = np.broadcast(*(end for span in boxes.spans for end in span)).shape[0]
        return np.repeat(self.shares[:, None, :], m, axis=1)


def critical(name: str) -> Callable[[Scene], Floats]:
    """Return what tells the load of scenes at which something begins: a field of ``CriticalLoads``."""

    def load(scene: Scene) -> Floats:
        return np.asarray(getattr(critical_loads(scene), name))

    return load


def extreme_ratio(
    box: EllipticalBox, critical_load: Callable[[Scene], Floats], *, largest: bool
) -> tuple[float, Floats]:
    """Search a box for the largest, or the least load over the load at which something begins.

    Parameters
    ----------
    box : EllipticalBox
        A single box.
    critical_load : callable
        Returns that load of scenes.
    largest : bool
        Which of the two.

    Returns
    -------
    ratio, shares : float, (axes, 1) array
        The ratio, and where it is.
    """
    free = box.varies
    side = -1.0 if largest else 1.0

    def ratios(shares: Floats) -> Floats:
        scene = box.scene(box.points(shares), fast=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(scene.load / critical_load(scene))

    def placed(x: Floats) -> Floats:
        shares = np.zeros((len(box.axes), x.shape[1]))
        shares[free] = x
        return shares

    best = np.zeros((0, 1))
    if free.any():
        first = np.hstack([corners(box)[free], sobol(int(free.sum()), _FIRST, _SEED)])
        best, _ = evolve(lambda x: side * ratios(placed(x)), first, generations=_GENERATIONS, seed=_SEED)
    return float(ratios(placed(best))[0]), placed(best)
