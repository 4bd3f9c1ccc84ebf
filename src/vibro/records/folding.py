"""The periodic part of a noisy signal: regression on the harmonics of the drive, with standard errors."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz

from vibro.errors import InputError
from vibro.records.tolerances import TOL

Floats = NDArray[np.float64]


class Estimate(NamedTuple):
    """A measured value and its standard error; NaN if unknown."""

    value: float
    error: float

    def scaled(self, factor: float) -> Estimate:
        """Multiply both by a positive factor."""
        return Estimate(self.value * factor, self.error * factor)


@dataclass(frozen=True, eq=False)
class Folded:
    """A signal as a trend and harmonics of the drive.

    Attributes
    ----------
    frequency : float
        Drive frequency [Hz].
    trends : int
        Number of coefficients of the trend: powers of (time - middle) / half.
    middle, half : float
        Middle and half of the record's duration [s].
    coefficients, covariance : array
        Coefficients of the trend, then of the cosines and of the sines; their covariance, increased for
        noise that is correlated over several samples.
    order : int
        Order of the derivative of the signal that the methods return.
    """

    frequency: float
    trends: int
    middle: float
    half: float
    coefficients: Floats
    covariance: Floats
    order: int = 0

    def trend(self, power: int) -> Estimate:
        """Return the coefficient of a power of the time, in the signal's unit per s to that power."""
        error = math.sqrt(self.covariance[power, power])
        return Estimate(float(self.coefficients[power]), error).scaled(self.half**-power)

    def periodic(self, time: Floats) -> Floats:
        """Return the harmonic part of the signal at times on the record's clock [s]."""
        return np.asarray(self._basis(time)[:, self.trends :] @ self.coefficients[self.trends :])

    def fitted(self, time: Floats) -> Floats:
        """Return trend and harmonic part of the signal at times on the record's clock [s]."""
        return np.asarray(self._basis(time) @ self.coefficients)

    def error(self, time: Floats) -> Floats:
        """Return the standard error of ``fitted``."""
        basis = self._basis(time)
        return np.asarray(np.sqrt(np.einsum("ij,jk,ik->i", basis, self.covariance, basis)))

    def derivative(self) -> Folded:
        """Differentiate the signal with respect to the time."""
        return replace(self, order=self.order + 1)

    def _basis(self, time: Floats) -> Floats:
        powers = np.vander((time - self.middle) / self.half, self.trends, increasing=True)
        for _ in range(self.order):
            powers = np.pad(powers[:, :-1] * np.arange(1, self.trends) / self.half, ((0, 0), (1, 0)))
        count = (self.coefficients.size - self.trends) // 2
        return np.hstack([powers, harmonics(time, self.frequency, count, self.order)])


def harmonics(time: Floats, frequency: float, count: int, derivative: int = 0) -> Floats:
    """Return cosines, then sines, of the harmonics of a frequency, or their derivatives, in columns."""
    rates = math.tau * frequency * np.arange(1, count + 1)
    angles = np.outer(time, rates) + 0.5 * math.pi * derivative
    found = np.empty((time.size, 2 * count))  # long records take longer to copy than to evaluate
    np.cos(angles, out=found[:, :count])
    np.sin(angles, out=found[:, count:])
    if derivative:
        found *= np.tile(rates**derivative, 2)
    return found


def detrended(time: Floats, values: Floats, degree: int) -> Floats:
    """Subtract the best polynomial of a degree."""
    centred = time - time.mean()
    return np.asarray(values - np.polyval(np.polyfit(centred, values, degree), centred))


def fold(time: Floats, signal: Floats, frequency: float, trends: int) -> Folded:
    """Regress a signal on a trend and the harmonics of the drive.

    Parameters
    ----------
    time : array
        Ascending, at least two drive cycles [s].
    signal : array
        Values at these times.
    frequency : float
        Drive frequency [Hz].
    trends : int
        Number of coefficients of the trend, a polynomial.

    Raises
    ------
    InputError
        If there are too few cycles, or too few samples a cycle.
    """
    span = float(time[-1] - time[0])
    cycles, cycle = span * frequency, f"of {1e3 / frequency:.6g} ms: at least"
    if cycles < TOL.least_cycles * (1.0 - TOL.printed):
        short = f"the data cover {_below(cycles)} drive cycles {cycle} {TOL.least_cycles:.0f} are needed"
        raise InputError(short, hint="record longer, or check the frequency and the unit of the time")
    samples = (time.size - 1) / cycles * (1.0 + TOL.printed)
    if samples < TOL.least_samples:
        coarse = (
            f"the data have {_below(samples)} samples a drive cycle {cycle} {TOL.least_samples} are needed"
        )
        raise InputError(coarse, hint="sample faster, or check the frequency and the unit of the time")
    count = min(TOL.most_harmonics, int(TOL.of_nyquist * 0.5 * samples))
    size, middle = trends + 2 * count, float(time[0]) + 0.5 * span
    empty = Folded(frequency, trends, middle, 0.5 * span, np.zeros(size), np.zeros((size, size)))
    basis = empty._basis(time)
    # Normal equations lose digits. Harmonics are nearly orthogonal: few digits are lost, and one step of
    # refinement restores them.
    inverse = np.linalg.pinv(basis.T @ basis)
    coefficients = inverse @ (basis.T @ signal)
    coefficients += inverse @ (basis.T @ (signal - basis @ coefficients))
    residual = signal - basis @ coefficients
    freedom = max(1, time.size - size)
    variance = float(residual @ residual) / freedom / independent_share(residual)
    return replace(empty, coefficients=coefficients, covariance=np.asarray(variance * inverse))


def independent_samples(time: Floats, residual: Floats, frequency: float) -> float:
    """Return the effective number of independent samples of a residual.

    Correlated neighbours count less. A residual that repeats in every cycle, because the model lacks it, is
    not averaged out by more cycles: it counts as two samples for each of its strong harmonics, for any number
    of cycles.

    Parameters
    ----------
    time, residual : array
        As ``time`` and ``signal`` of ``fold``.
    frequency : float
        Drive frequency [Hz].
    """
    folded = fold(time, residual, frequency, 1)
    rest = residual - folded.fitted(time)
    noise = float(np.var(rest))
    powers = 0.5 * (folded.coefficients[1:].reshape(2, -1) ** 2).sum(axis=0)
    powers[powers < TOL.significant * 2.0 * noise / time.size] = 0.0
    total = float(powers.sum())
    if total + noise == 0.0:
        return float(time.size)
    variance_of_mean = noise / (time.size * independent_share(rest))
    if total > 0.0:
        # the total over twice the effective number of strong harmonics
        variance_of_mean += float(powers @ powers) / (2.0 * total)
    return (total + noise) / variance_of_mean


def whitening_filter(time: Floats, residual: Floats, frequency: float) -> Floats:
    """Return the filter that makes noise white: 1, and minus the weights of the samples before.

    What repeats in every cycle is no noise. The weights are those of an autoregressive process by Yule and
    Walker's equations, whose order is that of Schwarz's criterion: white noise stays as it is. Rows that are
    left out are not counted.

    Parameters
    ----------
    time, residual : array
        As ``time`` and ``signal`` of ``fold``.
    frequency : float
        Drive frequency [Hz].
    """
    rest = residual - fold(time, residual, frequency, 1).fitted(time)
    size, most = rest.size, min(TOL.most_predecessors, rest.size // TOL.rows_of_a_predecessor)
    covariance = np.array([rest[k:] @ rest[: size - k] for k in range(most + 1)]) / size
    best, least = np.ones(1), 0.0
    for order in range(1, most + 1 if covariance[0] > 0.0 else 1):
        weights = solve_toeplitz(covariance[:order], covariance[1 : order + 1])
        left = 1.0 - float(weights @ covariance[1 : order + 1]) / covariance[0]
        cost = size * math.log(max(left, TOL.rounding)) + math.log(size) * order
        # Like ``independent_share``, never take slow noise for less than white noise of the same power.
        if cost < least and float(weights.sum()) > 0.0:
            best, least = np.append(1.0, -weights), cost
    return best


def independent_share(residual: Floats) -> float:
    """Return the effective share of independent samples, from the correlation of neighbours."""
    power = float(residual @ residual)
    if power == 0.0 or residual.size < 3:
        return 1.0
    neighbours = float(residual[1:] @ residual[:-1]) / power
    return min(1.0, max((1.0 - neighbours) / (1.0 + neighbours), 2.0 / residual.size))


def _below(number: float) -> str:
    """Write a number below a limit with at most two decimals, rounded down: it must not read as the limit."""
    return f"{math.floor(100.0 * number + 1e-6) / 100.0:g}"
