"""Dimensionless groups of a drive with harmonics: everything that decides its motion, up to its scale."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.harmonic.arrays import largest_amplitude

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["HarmonicLoads", "harmonic_loads"]

# [1] Range of 1/G in which no product of it overflows or vanishes; the body rests, or leaves, long before.
_WEIGHTS: Final = (1e-307, 1e307)


class HarmonicLoads(NamedTuple):
    """Loads on the body over m A w^2, A the scene's scale; the members broadcast against each other.

    Along the trough the drive pushes the body with sum_n along_sine[n-1] sin(n p) + along_cosine[n-1] cos(n
    p), off the trough alike.

    Attributes
    ----------
    along_sine, along_cosine : tuple of arrays
        n^2 X_n/A cos(xi_n) and n^2 X_n/A sin(xi_n), n = 1, 2, ..., of x = sum_n X_n sin(n p + xi_n).
    across_sine, across_cosine : tuple of arrays
        The same of y, as many.
    normal, tangential : array
        cos(beta)/G and sin(beta)/G: weight on the trough and down it, G = A w^2 / g.
    static_friction, kinetic_friction : array
        mu_s and mu_d.
    """

    along_sine: tuple[Floats, ...]
    along_cosine: tuple[Floats, ...]
    across_sine: tuple[Floats, ...]
    across_cosine: tuple[Floats, ...]
    normal: Floats
    tangential: Floats
    static_friction: Floats
    kinetic_friction: Floats


def harmonic_loads(
    along_amplitudes: tuple[Floats, ...],
    along_phases: tuple[Floats, ...],
    normal_amplitudes: tuple[Floats, ...],
    normal_phases: tuple[Floats, ...],
    frequency: Floats,
    static_friction: Floats,
    kinetic_friction: Floats,
    trough_angle: Floats,
    gravity: Floats,
) -> HarmonicLoads:
    """Form the groups, in SI units and radians; nothing is broadcast before it must be.

    Parameters
    ----------
    along_amplitudes, normal_amplitudes : tuple of arrays
        X_n and Y_n, n = 1, 2, ..., >= 0, as many of either [m].
    along_phases, normal_phases : tuple of arrays
        xi_n and eta_n of the same harmonics [rad].
    frequency : array
        Of the first harmonic [Hz].
    static_friction, kinetic_friction : array
        Coefficients of friction.
    trough_angle : array
        Positive uphill [rad].
    gravity : array
        [m/s^2].
    """
    scale = largest_amplitude(*along_amplitudes, *normal_amplitudes)
    with np.errstate(over="ignore", divide="ignore"):
        w = 2.0 * np.pi * frequency
        weight = np.asarray((gravity / w / scale / w).clip(*_WEIGHTS))

    def parts(
        amplitudes: tuple[Floats, ...], phases: tuple[Floats, ...]
    ) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
        sizes = [n * n * (x / scale) for n, x in enumerate(amplitudes, 1)]
        pairs = list(zip(sizes, phases, strict=True))
        sines = tuple(np.asarray(size * np.cos(phase)) for size, phase in pairs)
        return sines, tuple(np.asarray(size * np.sin(phase)) for size, phase in pairs)

    return HarmonicLoads(
        *parts(along_amplitudes, along_phases),
        *parts(normal_amplitudes, normal_phases),
        normal=np.asarray(weight * np.cos(trough_angle)),
        tangential=np.asarray(weight * np.sin(trough_angle)),
        static_friction=static_friction,
        kinetic_friction=kinetic_friction,
    )
