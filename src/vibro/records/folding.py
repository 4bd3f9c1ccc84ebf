"""What repeats in every drive cycle of a noisy record: a harmonic regression with standard errors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["Estimate", "Folded", "fold", "harmonics", "independent_samples", "independent_share"]

# The velocity of a slide has kinks, whose harmonics fall off quadratically: more of them add nothing.
_MOST_HARMONICS: Final = 24
# Evenly spaced samples cannot resolve a harmonic at half their rate: stay below it.
_OF_NYQUIST: Final = 0.9
# Times the power that noise alone leaves in a harmonic; noise exceeds that in 3 of 10 000 harmonics.
_SIGNIFICANT: Final = 8.0
_LEAST_CYCLES: Final = 2.0
_LEAST_SAMPLES: Final = 8  # per cycle


class Estimate(NamedTuple):
    """A measured value and its standard error; NaN where there is none."""

    value: float
    error: float


@dataclass(frozen=True, eq=False)
class Folded:
    """A signal as a trend and harmonics of the drive.

    Attributes
    ----------
    frequency : float
        Of the drive [Hz].
    trends : int
        Number of coefficients of the trend: powers of (time - middle) / half.
    middle, half : float
        Middle and half of the record's duration [s].
    coefficients, covariance : array
        Trend, then the cosines and the sines of the harmonics; their covariance, increased for noise that
        lasts longer than one sample.
    """

    frequency: float
    trends: int
    middle: float
    half: float
    coefficients: Floats
    covariance: Floats

    def trend(self, power: int) -> Estimate:
        """Coefficient of a power of the time, in the signal's unit per s to that power."""
        scale = self.half**-power
        error = math.sqrt(self.covariance[power, power])
        return Estimate(float(self.coefficients[power] * scale), error * scale)

    def periodic(self, time: Floats, derivative: int = 0) -> Floats:
        """Harmonic part of the signal, or a derivative of it, at times on the record's clock [s]."""
        return np.asarray(self._basis(time, derivative) @ self.coefficients)

    def fitted(self, time: Floats) -> Floats:
        """Trend and harmonic part of the signal at times on the record's clock [s]."""
        powers = np.vander((time - self.middle) / self.half, self.trends, increasing=True)
        return powers @ self.coefficients[: self.trends] + self.periodic(time)

    def error(self, time: Floats, derivative: int = 0, power: int | None = None) -> Floats:
        """Return the standard error of ``periodic``, plus one of the trend's coefficients if named."""
        basis = self._basis(time, derivative)
        if power is not None:
            basis[:, power] = self.half**-power
        return np.asarray(np.sqrt(np.einsum("ij,jk,ik->i", basis, self.covariance, basis)))

    def _basis(self, time: Floats, derivative: int) -> Floats:
        count = (self.coefficients.size - self.trends) // 2
        waves = harmonics(np.atleast_1d(time), self.frequency, count, derivative)
        return np.hstack([np.zeros((waves.shape[0], self.trends)), waves])


def harmonics(time: Floats, frequency: float, count: int, derivative: int = 0) -> Floats:
    """Return cosines, then sines, of the harmonics of a frequency, or derivatives of them, by column."""
    rates = 2.0 * math.pi * frequency * np.arange(1, count + 1)
    angles = np.outer(time, rates) + 0.5 * math.pi * derivative
    return np.hstack([np.cos(angles), np.sin(angles)]) * np.tile(rates**derivative, 2)


def fold(time: Floats, signal: Floats, frequency: float, trends: int) -> Folded:
    """Regress a signal on a trend and the harmonics of the drive.

    Parameters
    ----------
    time : array
        Ascending, at least two drive cycles [s].
    signal : array
        Of the same length.
    frequency : float
        Of the drive [Hz].
    trends : int
        Number of coefficients of the trend, a polynomial.

    Returns
    -------
    Folded
        The regression.

    Raises
    ------
    InputError
        If there are too few cycles, or too few samples a cycle.
    """
    span = float(time[-1] - time[0])
    cycles = span * frequency
    if cycles < _LEAST_CYCLES * (1.0 - 1e-9):
        raise InputError(
            f"the data cover {cycles:.3g} drive cycles of {1e3 / frequency:.6g} ms: at least"
            f" {_LEAST_CYCLES:.0f} are needed",
            hint="record longer, or check the frequency and the unit of the time",
        )
    samples = (time.size - 1) / cycles
    if samples < _LEAST_SAMPLES:
        raise InputError(
            f"the data have {samples:.3g} samples a drive cycle of {1e3 / frequency:.6g} ms: at least"
            f" {_LEAST_SAMPLES} are needed",
            hint="sample faster, or check the frequency and the unit of the time",
        )
    count = min(_MOST_HARMONICS, int(_OF_NYQUIST * 0.5 * samples))
    middle, half = float(time[0]) + 0.5 * span, 0.5 * span
    powers = np.vander((time - middle) / half, trends, increasing=True)
    basis = np.hstack([powers, harmonics(time, frequency, count)])
    # Normal equations lose digits. Harmonics are nearly orthogonal, so they lose few, and one step of
    # refinement restores them.
    inverse = np.linalg.pinv(basis.T @ basis)
    coefficients = inverse @ (basis.T @ signal)
    coefficients += inverse @ (basis.T @ (signal - basis @ coefficients))
    residual = signal - basis @ coefficients
    freedom = max(1, time.size - basis.shape[1])
    variance = float(residual @ residual) / freedom / independent_share(residual)
    return Folded(frequency, trends, middle, half, coefficients, variance * inverse)


def independent_samples(time: Floats, misfit: Floats, frequency: float) -> float:
    """Effective number of independent samples of a misfit.

    Correlated neighbours count less. A misfit that repeats in every cycle, because the model does not
    contain it, is not averaged out by more cycles: it counts as two samples for each of its strong
    harmonics, however many cycles there are.

    Parameters
    ----------
    time, misfit : array
        As for ``fold``.
    frequency : float
        Of the drive [Hz].
    """
    folded = fold(time, misfit, frequency, 1)
    repeated = folded.periodic(time)
    rest = misfit - repeated - folded.coefficients[0]
    noise = float(np.var(rest))
    waves = folded.coefficients[1:].reshape(2, -1)
    powers = 0.5 * (waves**2).sum(axis=0)
    powers[powers < _SIGNIFICANT * 2.0 * noise / time.size] = 0.0
    total = float(powers.sum())
    if total + noise == 0.0:
        return float(time.size)
    spread = noise / (time.size * independent_share(rest))
    if total > 0.0:
        # the total over twice the effective number of strong harmonics
        spread += float(powers @ powers) / (2.0 * total)
    return (total + noise) / spread


def independent_share(residual: Floats) -> float:
    """Effective number of independent samples over their number, from the correlation of neighbours."""
    power = float(residual @ residual)
    if power == 0.0 or residual.size < 3:
        return 1.0
    neighbours = float(residual[1:] @ residual[:-1]) / power
    return min(1.0, max((1.0 - neighbours) / (1.0 + neighbours), 2.0 / residual.size))
