"""At which frequency signals repeat, how sharply that is known, and whether it is that of the drive."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from vibro.records.folding import Estimate, harmonics, independent_share

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from vibro.records.alignment import Observation

    Floats = NDArray[np.float64]
    Places = NDArray[np.intp]

__all__ = ["Foreign", "Repetition", "foreign_frequency"]

# Of each signal the powers of 2 pi f that turn its spectrum into that of a velocity. There the fundamental
# stands out: jumps of an acceleration have strong harmonics, a displacement drifts.
_TO_VELOCITY: Final = {"displacement": 1, "velocity": 0, "acceleration": -1, "friction": -1}
_LEAST_CYCLES: Final = 2.0  # in the record, of any wave
_LEAST_SAMPLES: Final = 4.0  # in a cycle of the fundamental
_OF_NYQUIST: Final = 0.9
_MOST_HARMONICS: Final = 24
_HARMONICS: Final = 8.0  # of the largest wave: up to there signals are explained
_PADDING: Final = 4  # of the spectrum, so that its peaks lie within an eighth of 1/T
_NEAR: Final = 0.6  # of 1/T: how far the best frequency may lie from the peak
_STEP: Final = 0.02  # of 1/T: step of the curvature, over which the end of the record turns by 3.6 deg
_FRACTIONS: Final = (2, 3, 4, 5, 6)  # the largest wave may be this harmonic
_DIGITS: Final = 1e-6  # of a signal's largest value: less than that beside its trend is rounding
# Times the power that noise leaves in a harmonic on average: less is none; noise is more in 3 of 10 000.
_SIGNIFICANT: Final = 8.0
_RIDGE: Final = 1e-12  # of the power of a wave
_ROUNDING: Final = 1e-12  # of the power: less of it is not left unexplained
# Log-likelihood that must be gained: 5 sigma, and the logarithm of the number of frequencies tried.
_CLEAR: Final = 12.5
_OWN: Final = 0.1  # of the power of the largest wave, which a lower one has at least if that is its harmonic
_LEAST_SHARE: Final = 0.3  # of a signal's power that must repeat, for a frequency to be claimed
_MOST_SHARE, _MANY_CYCLES = 0.8, 5.0  # so much in so many cycles of a wave is no noise
_MISSING: Final = 0.05  # share of the power: with less, a wave counts as missing
_FOREIGN: Final = 0.05  # cycles by which drive and data may drift apart over the record
_SIGMAS: Final = 4.0  # of the frequency: less is no difference
_MOST_CYCLES: Final = 8  # of the drive, after which a body that hops may repeat its motion


class Repetition:
    """How much of signals a frequency explains with its harmonics, beside an offset and a slow drift.

    Parameters
    ----------
    time : array, shape (N,)
        Ascending [s].
    signals : mapping of str to array
        On any scale.
    powers : mapping of str to int
        Power of the frequency by which the spectrum of each is multiplied to find the largest wave.
    """

    def __init__(self, time: Floats, signals: Mapping[str, Floats], powers: Mapping[str, int]) -> None:
        self.span = float(np.ptp(time))
        self._time = time - 0.5 * float(time[0] + time[-1])
        self._trend = np.vander(self._time / (0.5 * self.span), 2, increasing=True)
        columns = np.array([values / (np.abs(values).max() or 1.0) for values in signals.values()]).T
        left = columns - self._trend @ np.linalg.lstsq(self._trend, columns, rcond=None)[0]
        self._signals = np.where(np.abs(left).max(axis=0) > _DIGITS, left, 0.0)
        self._powers = [powers[name] for name in signals]
        self.power = np.einsum("ij,ij->j", self._signals, self._signals)

    @property
    def rate(self) -> float:
        """Samples per second."""
        return (self._time.size - 1) / self.span

    @cached_property
    def peak(self) -> float:
        """Frequency of the largest wave; NaN where no wave can be resolved [Hz]."""
        count = self._time.size
        even = np.linspace(self._time[0], self._time[-1], count)
        columns = [np.interp(even, self._time, column) for column in self._signals.T]
        waves = np.abs(np.fft.rfft(columns, _PADDING * count, axis=1)) ** 2
        frequency = np.arange(waves.shape[1]) * self.rate / (_PADDING * count)
        sought = (frequency * self.span >= _LEAST_CYCLES) & (frequency * _LEAST_SAMPLES <= self.rate)
        if not sought.any() or not self.power.any():
            return math.nan
        total = np.zeros(int(np.count_nonzero(sought)))
        for wave, power in zip(waves[:, sought], self._powers, strict=True):
            shaped = wave * frequency[sought] ** (2.0 * power)
            total += shaped / (shaped.sum() or 1.0)
        return float(frequency[sought][np.argmax(total)])

    def _count(self, frequency: float) -> int:
        """Harmonics of a frequency, up to one that is common to all that are tried."""
        top = min(_HARMONICS * self.peak, 0.5 * _OF_NYQUIST * self.rate)
        most = min(_MOST_HARMONICS, self._time.size // 6)
        return max(1, min(most, int(top / frequency * (1.0 + 1e-9))))

    def _explained(self, frequency: float, which: Places | None = None) -> tuple[Floats, Floats]:
        """Coefficients of the trend and of all harmonics, or some, and what is left, (N, signals)."""
        count = self._count(frequency) if which is None else int(which[-1]) + 1
        basis = harmonics(self._time, frequency, count)
        if which is not None:
            basis = basis[:, np.concatenate([which, count + which])]
        basis = np.hstack([self._trend, basis])
        # Normal equations are quick, and accurate enough where waves are nearly orthogonal. The ridge keeps
        # them solvable where waves are indistinguishable.
        ridge = _RIDGE * self._time.size * np.eye(basis.shape[1])
        coefficients = np.linalg.solve(basis.T @ basis + ridge, basis.T @ self._signals)
        left = self._signals - basis @ coefficients
        made_up = math.sqrt(self._time.size / (self._time.size - basis.shape[1]))
        return np.asarray(coefficients, np.float64), left * made_up

    def _powers_of_waves(self, frequency: float) -> Floats:
        """Power of each harmonic over that of the signal, shape (harmonics, signals)."""
        waves = self._explained(frequency)[0][2:]
        squares = 0.5 * self._time.size * waves**2
        cosines, sines = np.split(squares, 2)
        return np.asarray((cosines + sines) / np.where(self.power > 0.0, self.power, 1.0))

    def squares(self, frequency: float, which: Places | None = None) -> Floats:
        """Sum of squares of what is left of each signal, made up for the number of waves."""
        left = self._explained(frequency, which)[1]
        return np.asarray(np.einsum("ij,ij->j", left, left) + _ROUNDING * self.power)

    def counts(self, frequency: float) -> Floats:
        """Effective number of independent samples of what is left of each signal."""
        return np.array([left.size * independent_share(left) for left in self._explained(frequency)[1].T])

    def near(self, frequency: float) -> Estimate:
        """Best frequency in the neighbourhood of another, with its standard error [Hz]."""
        step = 1.0 / self.span
        grid = frequency + _NEAR * step * np.linspace(-1.0, 1.0, 9)
        tried = [self.squares(f) for f in grid]
        weights = self.power > 0.0
        place = int(np.argmin([float(np.log(s[weights]).sum()) for s in tried]))
        scale = np.where(weights, tried[place], 1.0)
        # Noise at a harmonic that is not there would shift the frequency, and the more the higher it is.
        noise = 2.0 * tried[place] / np.where(weights, self.power, 1.0) / self._time.size
        real = (self._powers_of_waves(float(grid[place])) > _SIGNIFICANT * noise).any(axis=1)
        which = np.flatnonzero(real) if real.any() else np.array([0])
        best = minimize_scalar(
            lambda f: float((self.squares(f, which) / scale).sum()),
            bounds=(grid[max(place - 1, 0)], grid[min(place + 1, grid.size - 1)]),
            method="bounded",
            options={"xatol": 1e-6 * step},
        )
        found, h = float(best.x), _STEP * step
        least = self.squares(found, which)
        bend = (self.squares(found + h, which) + self.squares(found - h, which) - 2.0 * least) / (2.0 * h * h)
        certainty = float((self.counts(found) * bend / np.where(weights, least, 1.0))[weights].sum())
        return Estimate(found, 1.0 / math.sqrt(certainty) if certainty > 0.0 else math.inf)

    def gain(self, one: float, other: float | None, counts: Floats) -> float:
        """By how much a frequency explains more than another, or than none: log of the likelihoods' ratio."""
        real = self.power > 0.0
        less = self.power if other is None else self.squares(other)
        ratio = np.log(less[real] / self.squares(one)[real])
        return 0.5 * float(counts[real] @ ratio)

    def share(self, frequency: float) -> float:
        """Share of the power that a frequency explains, of the signal that it explains most of."""
        real = self.power > 0.0
        return float((1.0 - self.squares(frequency)[real] / self.power[real]).max(initial=0.0))

    def is_clear(self, gain: float) -> bool:
        """Whether a gain is more than noise gives among all frequencies that were tried."""
        return gain > _CLEAR + math.log(self._time.size)

    def fundamental(self) -> Estimate | None:
        """Frequency of which the largest wave is a harmonic, mostly the first; None without a clear wave."""
        if math.isnan(self.peak):
            return None
        found = self.near(self.peak)
        lower = [found.value / n for n in _FRACTIONS if found.value / n * self.span >= _LEAST_CYCLES]
        shares = {f: self.share(f) for f in lower if self._adds(f, found.value)}
        # A fraction of the fundamental explains as much as that: the highest that explains the most.
        best = next((f for f, share in shares.items() if share > max(shares.values()) - _MISSING), None)
        # Near the wave of another machine a fraction may add to what is explained, and explain little itself.
        for candidate in ([] if best is None else [self.near(best)]) + [found]:
            share = self.share(candidate.value)
            # What is left may be another machine's wave, which counts as few samples, and nothing is clear.
            clear = share >= _MOST_SHARE and candidate.value * self.span >= _MANY_CYCLES
            clear |= self.is_clear(self.gain(candidate.value, None, self.counts(candidate.value)))
            if clear and share >= _LEAST_SHARE:
                return candidate
        return None

    def _adds(self, lower: float, frequency: float) -> bool:
        """Whether a lower frequency has a wave of its own, and adds to what is explained."""
        own, largest = (float(self._powers_of_waves(f)[0].max()) for f in (lower, frequency))
        return own > max(_MISSING, _OWN * largest) and self.is_clear(
            self.gain(lower, frequency, self.counts(lower))
        )


class Foreign(NamedTuple):
    """A frequency at which data repeat, and which is not that of the drive.

    Attributes
    ----------
    frequency : Estimate
        [Hz].
    cycles : int
        Of the drive in one period of the data; 0 where that is no whole number of them.
    """

    frequency: Estimate
    cycles: int


def foreign_frequency(observation: Observation) -> Foreign | None:
    """Find the frequency at which a record repeats, where that is clearly not the one of the drive.

    Clearly: it explains more than noise could, and lies beyond its own uncertainty. Where it is a multiple of
    the drive's, the drive's own wave must be missing from the record.

    Parameters
    ----------
    observation : Observation
        The record, with the frequency that the drive should have.
    """
    part, drive = observation.middle, observation.frequency
    signals = Repetition(part.time, part.signals, _TO_VELOCITY)
    found = signals.fundamental()
    if found is None:
        return None
    apart = max(_FOREIGN / signals.span, _SIGMAS * found.error)
    if abs(found.value - drive) <= apart:
        return None
    multiple = round(found.value / drive)
    if multiple > 1 and abs(found.value - multiple * drive) <= multiple * apart:
        odd = signals.share(drive) - signals.share(found.value)
        return Foreign(found, 0) if odd < _MISSING * signals.share(found.value) else None
    if not signals.is_clear(signals.gain(found.value, drive, signals.counts(found.value))):
        return None
    cycles = round(drive / found.value)
    whole = 1 < cycles <= _MOST_CYCLES and abs(cycles * found.value - drive) <= cycles * apart
    return Foreign(found, cycles if whole else 0)
