"""Frequency at which signals repeat, its standard error, and whether it differs from that of the drive."""

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

Places = NDArray[np.intp]

# Of each signal the powers of 2 pi f that turn its spectrum into that of a velocity. There the fundamental
# stands out: jumps of an acceleration have strong harmonics, a displacement drifts.
_TO_VELOCITY: Final = {"displacement": 1, "velocity": 0, "acceleration": -1, "friction": -1}


class Repetition:
    """Regression of signals on the harmonics of a trial frequency, an offset and a slow drift.

    Parameters
    ----------
    time : array, shape (N,)
        Ascending [s].
    signals : mapping of str to array
        In any units.
    powers : mapping of str to int
        Power of the frequency by which the spectrum of each is multiplied to find the largest wave.

    Attributes
    ----------
    span : float
        Length of the record [s].
    alive : bool array
        Which of the signals vibrate by more than rounding; the others are left out.
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

    def fundamental(self) -> Estimate | None:
        """Find the drive frequency, of which the largest wave is a harmonic, mostly the first; or None."""
        if math.isnan(self._peak):
            return None
        found = self._near(self._peak)
        lower = [found.value / n for n in range(2, TOL.lowest_fraction + 1)]
        shares = {
            f: self.share(f)
            for f in lower
            if f * self.span >= TOL.least_cycles and self._adds(f, found.value)
        }
        # A fraction of the fundamental explains as much as the fundamental: take the highest of the best.
        best = next((f for f, share in shares.items() if share > max(shares.values()) - TOL.missing), None)
        # Near the wave of another machine a fraction may explain little beside the harmonics that it adds to:
        # try the largest wave itself after it.
        for candidate in ([] if best is None else [self._near(best)]) + [found]:
            share = self.share(candidate.value)
            # A wave of another machine in the residual leaves few independent samples, and no gain is clear:
            # a large share over many cycles is enough.
            clear = share >= TOL.most_share and candidate.value * self.span >= TOL.many_cycles
            if share >= TOL.least_share and (clear or self.explains_more(candidate.value)):
                return candidate
        return None

    def share(self, frequency: float) -> float:
        """Return the share of the power that a frequency explains, of the signal that it explains best."""
        return float((1.0 - self._squares(frequency) / self._power).max(initial=0.0))

    def explains_more(self, one: float, other: float | None = None) -> bool:
        """Whether a frequency explains more than another, or than none, beyond noise.

        Noise raises the likelihood too, the more the more frequencies are tried.
        """
        less = self._power if other is None else self._squares(other)
        gain = 0.5 * float(self._counts(one) @ np.log(less / self._squares(one)))
        return gain > TOL.clear + math.log(self._time.size)

    @cached_property
    def _peak(self) -> float:
        """Frequency of the largest wave; NaN where no wave can be resolved [Hz]."""
        size = TOL.padding * self._time.size
        even = np.linspace(self._time[0], self._time[-1], self._time.size)
        frequency = np.fft.rfftfreq(size, 1.0 / self._rate)
        sought = (frequency * self.span >= TOL.least_cycles) & (frequency * TOL.coarsest <= self._rate)
        if not sought.any() or not self.alive.any():
            return math.nan
        columns = [np.interp(even, self._time, column) for column in self._signals.T]
        waves = np.abs(np.fft.rfft(columns, size, axis=1)[:, sought]) ** 2
        shaped = waves * frequency[sought] ** (2.0 * self._powers[:, None])
        total = (shaped / np.maximum(shaped.sum(axis=1, keepdims=True), np.finfo(float).tiny)).sum(axis=0)
        return float(frequency[sought][np.argmax(total)])

    def _near(self, frequency: float) -> Estimate:
        """Refine a frequency to the one of least misfit, with its standard error [Hz]."""
        step = 1.0 / self.span
        grid = frequency + TOL.near_peak * step * np.linspace(-1.0, 1.0, 9)
        tried = np.array([self._squares(f) for f in grid])
        place = int(np.argmin(np.log(tried).sum(axis=1)))
        # Noise in a harmonic that the signal lacks would shift the frequency, the more the higher it is: use
        # those that stand out.
        noise = 2.0 * tried[place] / self._power / self._time.size
        real = (self._powers_of_waves(float(grid[place])) > TOL.significant * noise).any(axis=1)
        which = np.flatnonzero(real) if real.any() else np.array([0])
        best = minimize_scalar(
            lambda f: float((self._squares(f, which) / tried[place]).sum()),
            bounds=(grid[max(place - 1, 0)], grid[min(place + 1, grid.size - 1)]),
            method="bounded",
            options={"xatol": 1e-6 * step},
        )
        found, h = float(best.x), TOL.curvature_step * step
        before, least, after = (self._squares(found + shift, which) for shift in (-h, 0.0, h))
        bend = (after + before - 2.0 * least) / (2.0 * h * h)
        certainty = float((self._counts(found) * bend / least).sum())
        return Estimate(found, 1.0 / math.sqrt(certainty) if certainty > 0.0 else math.inf)

    def _adds(self, lower: float, largest: float) -> bool:
        """Whether a lower frequency has a wave of its own, and explains more than the largest wave."""
        own, other = (float(self._powers_of_waves(f)[0].max()) for f in (lower, largest))
        return own > max(TOL.missing, TOL.own_wave * other) and self.explains_more(lower, largest)

    def _regression(self, frequency: float, which: Places | None = None) -> tuple[Floats, Floats]:
        """Return coefficients of the trend and of all harmonics, or some, and the residuals, (N, signals).

        The harmonics end at a frequency that is the same for all that are tried. Residuals are scaled up for
        the number of coefficients.
        """
        top = min(TOL.explained_up_to * self._peak, 0.5 * TOL.of_nyquist * self._rate)
        most = min(TOL.most_harmonics, self._time.size // 6)
        count = max(1, min(most, int(top / frequency * (1.0 + TOL.printed))))
        which = np.arange(count) if which is None else which
        count = int(which[-1]) + 1
        waves = harmonics(self._time, frequency, count)[:, np.concatenate([which, count + which])]
        basis = np.hstack([self._trend, waves])
        # Normal equations are quick, and accurate enough where waves are nearly orthogonal. The ridge keeps
        # them solvable where waves are indistinguishable.
        ridge = TOL.rounding * self._time.size * np.eye(basis.shape[1])
        coefficients = np.linalg.solve(basis.T @ basis + ridge, basis.T @ self._signals)
        scale = math.sqrt(self._time.size / (self._time.size - basis.shape[1]))
        return np.asarray(coefficients, np.float64), (self._signals - basis @ coefficients) * scale

    def _powers_of_waves(self, frequency: float) -> Floats:
        """Return the power of each harmonic over that of the signal, shape (harmonics, signals)."""
        waves = self._regression(frequency)[0][2:]
        cosines, sines = np.split(0.5 * self._time.size * waves**2, 2)
        return np.asarray((cosines + sines) / self._power)

    def _squares(self, frequency: float, which: Places | None = None) -> Floats:
        """Sum the squares of the residuals of each signal."""
        left = self._regression(frequency, which)[1]
        return np.asarray(np.einsum("ij,ij->j", left, left) + TOL.rounding * self._power)

    def _counts(self, frequency: float) -> Floats:
        """Return the effective number of independent samples in the residuals of each signal."""
        return np.array([left.size * independent_share(left) for left in self._regression(frequency)[1].T])


class Foreign(NamedTuple):
    """A frequency at which data repeat, and which differs from that of the drive.

    Attributes
    ----------
    frequency : Estimate
        [Hz].
    cycles : int
        Drive cycles in one period of the data; 0 if they are no whole number.
    """

    frequency: Estimate
    cycles: int


def foreign_frequency(observation: Observation) -> Foreign | None:
    """Find the frequency at which a record repeats, if that clearly differs from the drive's.

    It must explain more than noise could, and lie beyond its own uncertainty. If it is a multiple of the
    drive's, the drive's own wave must be missing from the record.

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
    if not signals.explains_more(found.value, drive):
        return None
    cycles = round(drive / found.value)
    whole = 1 < cycles <= TOL.most_cycles and abs(cycles * found.value - drive) <= cycles * apart
    return Foreign(found, cycles if whole else 0)
