"""The equations of motion for simulations, and their results.

Methods must not share formulas with the solver that they are compared with, so nothing here comes from
``vibro.core``. Lengths are in A, speeds in A w, loads in m A w^2, phases p = w t in radians.
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from vibro.scene import Scene


class TroughBody(NamedTuple):
    """A body on a trough; numbers for one scene, or arrays for many.

    Attributes
    ----------
    along, across : float or array
        Amplitudes of the inertial load along the trough and off it: cos(alpha), sin(alpha).
    normal, tangential : float or array
        Weight on the trough and down it: g cos(beta) / (A w^2), g sin(beta) / (A w^2).
    static_friction, kinetic_friction : float or array
        mu_s and mu_d.
    """

    along: Any
    across: Any
    normal: Any
    tangential: Any
    static_friction: Any
    kinetic_friction: Any

    def onsets(self, library: Any = math) -> tuple[Any, Any]:
        """Phases in [0, 2 pi) at which one scene at rest starts forward and back; None if it never does."""
        mu_s = self.static_friction
        phases: list[Any] = []
        for sign, zero in ((1, 0), (-1, library.pi)):
            load = self.along + sign * mu_s * self.across
            threshold = mu_s * self.normal + sign * self.tangential
            starts = 0.0 <= threshold < load
            phases.append(zero + library.asin(threshold / load) if starts else None)
        return phases[0], phases[1]

    def load_and_hold(self, sine: Any) -> tuple[Any, Any]:
        """Load along the trough, and the static friction that can balance it, at the sine of a phase."""
        return (
            self.along * sine - self.tangential,
            self.static_friction * (self.normal - self.across * sine),
        )

    def sliding(self, sign: float) -> tuple[Any, Any]:
        """Amplitude of the load on a body that slides forward (1) or back (-1), and what resists it."""
        mu_d = self.kinetic_friction
        return self.along + sign * mu_d * self.across, mu_d * self.normal + sign * self.tangential


class Found(NamedTuple):
    """What a method finds for one scene.

    Attributes
    ----------
    displacement : float
        Displacement per drive cycle [A]; NaN if the method gave up.
    slides : str
        Directions of sliding in the steady cycle: any of F and B, empty at rest.
    """

    displacement: float
    slides: str


def trough_body(values: Iterable[Any], library: Any) -> TroughBody:
    """Form the equations of motion from the fields of scenes, with functions of NumPy, math or mpmath."""
    amplitude, frequency, alpha, mu_s, mu_d, beta, gravity = values
    weight = gravity / (amplitude * (2 * library.pi * frequency) ** 2)
    along, across = library.cos(alpha), library.sin(alpha)
    return TroughBody(along, across, weight * library.cos(beta), weight * library.sin(beta), mu_s, mu_d)


def motion_arrays(scene: Scene) -> TroughBody:
    """Form the equations of motion of all scenes at once, as flat arrays in the order of their cells."""
    return trough_body(scene.flat()[:-1], np)


def motions(scene: Scene) -> Iterator[TroughBody]:
    """Form the equations of motion of scenes one by one, in the order of their cells."""
    return itertools.starmap(TroughBody, zip(*(a.tolist() for a in motion_arrays(scene)), strict=True))
