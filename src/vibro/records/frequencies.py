"""Frequency at which signals repeat, its standard error, and whether it is that of the drive."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from vibro.records.alignment import Observation
from vibro.records.folding import Estimate, Floats, harmonics, independent_share
from vibro.records.tolerances import TOL

__all__ = ["Foreign", "Repetition", "foreign_frequency"]

Places = NDArray[np.intp]

# Of each signal the powers of 2 pi f that turn its spectrum into that of a velocity. There the fundamental
# stands out: jumps of an acceleration have strong harmonics, a displacement drifts.
_TO_VELOCITY: Final = {"displacement": 1, "velocity": 0, "acceleration": -1, "friction": -1}


class Repetition:
    """Share of signals that a frequency explains with its harmonics, besides an offset and a slow drift.

    Parameters
    ----------
    time : array, shape (N,)
        Ascending [s].
    signals : mapping of str to array
        On any scale.
    powers : mapping of str to int
        Power of the frequency by which the spectrum of each is multiplied to find the largest wave.

    Attributes
    ----------
    alive : bool array
        Which of the signals vibrate, beyond rounding; the others do not count.
    """

    def __init__(self, time: Floats, signals: Mapping[str, Floats], powers: Mapping[str, int]) -> None:
        self.span = float(np.ptp(time))
        self._rate = (time.size - 1) / self.span
        self._time = time - 0.5 * float(time[0] + time[-1])
        self._trend = np.vander(self._time / (0.5 * self.span), 2, increasing=True)
        columns = np.array([values / (np.abs(values).max() or 1.0) for values in signals.values()]).T
        left = columns - self._trend @ np.linalg.lstsq(self._trend, columns, rcond=None)[0]
        self.alive = np.abs(left).max(axis=0) > TOL.rounded
        self._signals = left[:, self.alive]
        self._powers = np.array([powers[name] for name in signals])[self.alive]
        self._power = np.einsum("ij,ij->j", self._signals, self._signals)

    @cached_property
    def peak(self) -> float:
        """Frequency of the largest wave; NaN where no wave can be resolved [Hz]."""
        count = self._time.size
        even = np.linspace(self._time[0], self._time[-1], count)
        frequency = np.arange(TOL.padding * count // 2 + 1) * self._rate / (TOL.padding * count)
        sought = (frequency * self.span >= TOL.least_cycles) & (frequency * TOL.coarsest <= self._rate)
        if not sought.any() or not self.alive.any():
            return math.nan
        columns = [np.interp(even, self._time, column) for column in self._signals.T]
        waves = np.abs(np.fft.rfft(columns, TOL.padding * count, axis=1)[:, sought]) ** 2
        shaped = waves * frequency[sought] ** (2.0 * self._powers[:, None])
        total = (shaped / np.maximum(shaped.sum(axis=1, keepdims=True), np.finfo(float).tiny)).sum(axis=0)
        return float(frequency[sought][np.argmax(total)])

    def _count(self, frequency: float) -> int:
        """Harmonics of a frequency, up to one that is common to all that are tried."""
        top = min(TOL.explained_up_to * self.peak, 0.5 * TOL.of_nyquist * self._rate)
        most = min(TOL.most_harmonics, self._time.size // 6)
        return max(1, min(most, int(top / frequency * (1.0 + TOL.printed))))

    def _explained(self, frequency: float, which: Places | None = None) -> tuple[Floats, Floats]:
        """Coefficients of the trend and of all harmonics, or some, and what is left, (N, signals)."""
        count = self._count(frequency) if which is None else int(which[-1]) + 1
        basis = harmonics(self._time, frequency, count)
        if which is not None:
            basis = basis[:, np.concatenate([which, count + which])]
        basis = np.hstack([self._trend, basis])
        # Normal equations are quick, and accurate enough where waves are nearly orthogonal. The ridge keeps
        # them solvable where waves are indistinguishable.
        ridge = TOL.rounding * self._time.size * np.eye(basis.shape[1])
        coefficients = np.linalg.solve(basis.T @ basis + ridge, basis.T @ self._signals)
        made_up = math.sqrt(self._time.size / (self._time.size - basis.shape[1]))
        return np.asarray(coefficients, np.float64), (self._signals - basis @ coefficients) * made_up

    def _powers_of_waves(self, frequency: float) -> Floats:
        """Power of each harmonic over that of the signal, shape (harmonics, signals)."""
        waves = self._explained(frequency)[0][2:]
        cosines, sines = np.split(0.5 * self._time.size * waves**2, 2)
        return np.asarray((cosines + sines) / self._power)

    def squares(self, frequency: float, which: Places | None = None) -> Floats:
        """Sum of squares of what is left of each signal, made up for the number of waves."""
        left = self._explained(frequency, which)[1]
        return np.asarray(np.einsum("ij,ij->j", left, left) + TOL.rounding * self._power)

    def counts(self, frequency: float) -> Floats:
        """Effective number of independent samples of what is left of each signal."""
        return np.array([left.size * independent_share(left) for left in self._explained(frequency)[1].T])

    def near(self, frequency: float) -> Estimate:
        """Best frequency in the neighbourhood of another, with its standard error [Hz]."""
        step = 1.0 / self.span
        grid = frequency + TOL.near_peak * step * np.linspace(-1.0, 1.0, 9)
        tried = np.array([self.squares(f) for f in grid])
        place = int(np.argmin(np.log(tried).sum(axis=1)))
        # Noise at a harmonic that is not there would shift the frequency, and the more the higher it is.
        noise = 2.0 * tried[place] / self._power / self._time.size
        real = (self._powers_of_waves(float(grid[place])) > TOL.significant * noise).any(axis=1)
        which = np.flatnonzero(real) if real.any() else np.array([0])
        best = minimize_scalar(
            lambda f: float((self.squares(f, which) / tried[place]).sum()),
            bounds=(grid[max(place - 1, 0)], grid[min(place + 1, grid.size - 1)]),
            method="bounded",
            options={"xatol": 1e-6 * step},
        )
        found, h = float(best.x), TOL.curvature_step * step
        least = self.squares(found, which)
        bend = (self.squares(found + h, which) + self.squares(found - h, which) - 2.0 * least) / (2.0 * h * h)
        certainty = float((self.counts(found) * bend / least).sum())
        return Estimate(found, 1.0 / math.sqrt(certainty) if certainty > 0.0 else math.inf)

    def gain(self, one: float, other: float | None, counts: Floats) -> float:
        """By how much a frequency explains more than another, or than none: log of the likelihoods' ratio."""
        less = self._power if other is None else self.squares(other)
        return 0.5 * float(counts @ np.log(less / self.squares(one)))

    def share(self, frequency: float) -> float:
        """Share of the power that a frequency explains, of the signal that it explains most of."""
        return float((1.0 - self.squares(frequency) / self._power).max(initial=0.0))

    def is_clear(self, gain: float) -> bool:
        """Whether a gain is more than noise gives among all frequencies that were tried."""
        return gain > TOL.clear + math.log(self._time.size)

    def fundamental(self) -> Estimate | None:
        """Frequency of which the largest wave is a harmonic, mostly the first; None without a clear wave."""
        if math.isnan(self.peak):
            return None
        found = self.near(self.peak)
        lower = [found.value / n for n in range(2, TOL.lowest_fraction + 1)]
        shares = {
            f: self.share(f) for f in lower if f * self.span >= TOL.least_cycles and self._adds(f, found)
        }
        # A fraction of the fundamental explains as much as that: the highest that explains the most.
        best = next((f for f, share in shares.items() if share > max(shares.values()) - TOL.missing), None)
        # Near the wave of another machine a fraction may add to what is explained, and explain little itself.
        for candidate in ([] if best is None else [self.near(best)]) + [found]:
            share = self.share(candidate.value)
            # What is left may be another machine's wave, which counts as few samples, and nothing is clear.
            clear = share >= TOL.most_share and candidate.value * self.span >= TOL.many_cycles
            clear |= self.is_clear(self.gain(candidate.value, None, self.counts(candidate.value)))
            if clear and share >= TOL.least_share:
                return candidate
        return None

    def _adds(self, lower: float, largest: Estimate) -> bool:
        """Whether a lower frequency has a wave of its own, and adds to what is explained."""
        own, other = (float(self._powers_of_waves(f)[0].max()) for f in (lower, largest.value))
        gain = self.gain(lower, largest.value, self.counts(lower))
        return own > max(TOL.missing, TOL.own_wave * other) and self.is_clear(gain)


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
    apart = max(TOL.drifted / signals.span, TOL.sigmas * found.error)
    if abs(found.value - drive) <= apart:
        return None
    multiple = round(found.value / drive)
    if multiple > 1 and abs(found.value - multiple * drive) <= multiple * apart:
        odd = signals.share(drive) - signals.share(found.value)
        return Foreign(found, 0) if odd < TOL.missing * signals.share(found.value) else None
    if not signals.is_clear(signals.gain(found.value, drive, signals.counts(found.value))):
        return None
    cycles = round(drive / found.value)
    whole = 1 < cycles <= TOL.most_cycles and abs(cycles * found.value - drive) <= cycles * apart
    return Foreign(found, cycles if whole else 0)
