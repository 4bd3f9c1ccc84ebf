"""A record as it is compared with the model, and its position in the drive cycle."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.optimize import brentq, minimize_scalar

from vibro.errors import InputError
from vibro.motion.settled import SettledMotion
from vibro.quantities import AMPLITUDES
from vibro.records.reading import TOL, Record
from vibro.records.steadiness import scale_notes
from vibro.scene import Scene

if TYPE_CHECKING:
    from vibro.reals import Floats

# ------------------------------------------------------------------------------
# The periodic part of a noisy signal: regression on the harmonics of the drive, with standard errors.


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
    check_size(time, frequency)
    span = float(time[-1] - time[0])
    samples = (time.size - 1) / (span * frequency) * (1.0 + TOL.printed)
    count = min(TOL.most_harmonics, int(TOL.of_nyquist * 0.5 * samples))
    size, middle = trends + 2 * count, float(time[0]) + 0.5 * span
    empty = Folded(frequency, trends, middle, 0.5 * span, np.zeros(size), np.zeros((size, size)))
    basis = empty._basis(time)
    coefficients, inverse = regress(basis, signal)
    residual = signal - basis @ coefficients
    freedom = max(1, time.size - size)
    variance = float(residual @ residual) / freedom / independent_share(residual)
    return replace(empty, coefficients=coefficients, covariance=np.asarray(variance * inverse))


def check_size(time: Floats, frequency: float) -> None:
    """Refuse a record of too few cycles, or too few samples a cycle."""
    cycles = float(time[-1] - time[0]) * frequency
    samples = (time.size - 1) / max(cycles, TOL.rounding)
    for what, size, least, more in (
        ("cycles", cycles, TOL.least_cycles, "record longer"),
        ("samples a cycle", samples, TOL.least_samples, "sample faster"),
    ):
        if size < least * (1.0 - TOL.printed):
            few = f"the record has {below(size)} {what} of {frequency:.6g} Hz: at least {least:g} are needed"
            raise InputError(few, hint=f"{more}, or check the frequency and the unit of the time")


def regress(basis: Floats, values: Floats, inverse: Floats | None = None) -> tuple[Floats, Floats]:
    """Return the coefficients of least squares, and the inverse of the normal equations.

    Normal equations lose digits. Harmonics are nearly orthogonal: few digits are lost, and one step of
    refinement restores them.
    """
    known = np.asarray(np.linalg.pinv(basis.T @ basis)) if inverse is None else inverse
    coefficients = known @ (basis.T @ values)
    coefficients += known @ (basis.T @ (values - basis @ coefficients))
    return np.asarray(coefficients), known


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


def below(number: float) -> str:
    """Write a number below a limit with at most two decimals, rounded down: it must not read as the limit."""
    return f"{math.floor(100.0 * number + 1e-6) / 100.0:g}"


_RANGE: Final = f"[{1.0 / TOL.largest:g}, {TOL.largest:g}]"
_MOVING: Final = ("displacement", "velocity")
_TRENDS: Final = {"displacement": 2, "velocity": 1, "acceleration": 1, "friction": 1}


class Alignment(NamedTuple):
    """Trough time of the record's clock.

    Attributes
    ----------
    shift : float
        Trough time at the clock's zero, in [0, period): the trough passes its middle upwards at trough
        time 0, on an ellipse forwards [s]. NaN where the computed motion is the same at any time.
    error : float
        Its standard error from noise [s].
    rivals : tuple of float
        Other shifts that fit almost as well [s].
    """

    shift: float
    error: float
    rivals: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Observation:
    """A record as it is compared with the model, in SI units.

    Attributes
    ----------
    time : array
        Ascending [s].
    signals : mapping of str to array
        ``displacement``, ``velocity``, ``acceleration`` of the body and ``friction`` on it per unit mass,
        positive in the conveying direction; any subset.
    frequency : float
        Drive frequency [Hz].
    clock : Estimate or None
        Trough time at the clock's zero, in [0, period), if it was measured [s].
    sensitivities : mapping of str to str
        Sensitivities of the signals that are voltages, as typed.
    absolute : bool
        Whether the body's motion is that over the ground, which holds the trough's; else it is relative to
        the trough.
    frequency_error : float
        Standard error of the frequency, 0 if it was given [Hz].
    lowpass : float
        Corner of the first-order low-pass filter in each channel; inf without one [Hz].
    """

    time: Floats
    signals: Mapping[str, Floats]
    frequency: float
    clock: Estimate | None = None
    sensitivities: Mapping[str, str] = field(default_factory=dict)
    absolute: bool = False
    frequency_error: float = 0.0
    lowpass: float = math.inf

    @classmethod
    def of(
        cls,
        record: Record,
        frequency: float,
        *,
        mass: float | None = None,
        reverse: bool = False,
        clock: Estimate | None = None,
        absolute: bool = False,
        frequency_error: float = 0.0,
        lowpass: float = math.inf,
    ) -> Observation:
        """Select the signals of a record that can be compared.

        Parameters
        ----------
        record : Record
            A record with at least one signal.
        frequency : float
            Drive frequency [Hz].
        mass : float, optional
            Mass of the body [kg]; without it forces cannot be compared.
        reverse : bool
            Whether the record's axis points against the conveying direction.
        clock : Estimate, optional
            Trough time at the clock's zero [s].
        absolute : bool
            Whether the record's motions are those over the ground, as a camera on a tripod sees them.
        frequency_error : float
            Standard error of the frequency, 0 if it was given [Hz].
        lowpass : float
            Corner of the first-order low-pass filter in each channel [Hz].

        Raises
        ------
        InputError
            If a force is the only signal and the mass is missing; if the mass is beyond 1e-20 to 1e20 kg; or
            if a signal is so large that its unit must be wrong.
        """
        if mass is not None and not 1.0 / TOL.largest <= mass <= TOL.largest:
            raise InputError(f"mass = {mass:.15g} kg: must be in {_RANGE} kg beside a record")
        sign = -1.0 if reverse else 1.0
        signals = {name: sign * values for name, values in record.signals.items() if name != "friction"}
        if "friction" in record.signals and mass is not None:
            signals["friction"] = sign * record.signals["friction"] / mass
        if not signals:
            unknown = "the data contain only a force, and the mass is unknown"
            raise InputError(unknown, hint="give its mass, such as 20g")
        check_size(record.time, frequency)
        for name, values in signals.items():
            speed = np.gradient(values, record.time) if name == "displacement" else values
            size = math.sqrt(2.0) * float(np.std(speed)) * (math.tau * frequency) ** (name in _MOVING)
            if name != "friction":
                scale_notes(record, name, size, frequency)
        if "acceleration" in signals:
            # The velocity of a steady motion repeats, so that its acceleration has no mean. A mean in the
            # record is the sensor's zero, or gravity on a sensor that is not level: subtract it.
            steady = fold(record.time, signals["acceleration"], frequency, _TRENDS["acceleration"])
            signals["acceleration"] = signals["acceleration"] - steady.coefficients[0]
        about = clock, record.sensitivities, absolute, frequency_error, lowpass
        return cls(record.time, signals, frequency, *about)

    @property
    def period(self) -> float:
        """Drive period [s]."""
        return 1.0 / self.frequency

    @cached_property
    def sample_time(self) -> float:
        """Median time between two samples [s]."""
        return float(np.median(np.diff(self.time)))

    @cached_property
    def folded(self) -> Mapping[str, Folded]:
        """Regression of each signal on its trend and the harmonics of the drive."""
        fields = self.signals.items()
        return {name: fold(self.time, values, self.frequency, _TRENDS[name]) for name, values in fields}

    @cached_property
    def middle(self) -> Observation:
        """The record as searches use it: only the middle of a long one."""
        cycles = (float(self.time[-1]) - float(self.time[0])) * self.frequency
        rows = max(TOL.searched_rows, math.ceil(TOL.searched_cycles * self.time.size / cycles))
        if self.time.size <= rows:
            return self
        first = (self.time.size - rows) // 2
        part = slice(first, first + rows)
        signals = {name: values[part] for name, values in self.signals.items()}
        return replace(self, time=self.time[part], signals=signals)

    def relative_to(self, motion: SettledMotion, shift: float) -> Observation:
        """Return the record relative to the trough, whose motion at a shift is subtracted if need be."""
        if not self.absolute:
            return self
        trough = low_passed(
            lambda time, _: motion.trough(time), self.time + shift, motion.period, self.lowpass
        )
        signals = {name: values - trough.get(name, 0.0) for name, values in self.signals.items()}
        return replace(self, signals=signals, absolute=False)

    def model(self, motion: SettledMotion, time: Floats) -> dict[str, Floats]:
        """Compute what the record's sensors show at trough times."""

        def sample(time: Floats, window: float) -> dict[str, Floats]:
            return computed_signals(motion, self.signals, time, window, absolute=self.absolute)

        return low_passed(sample, time, motion.period, self.lowpass, self.sample_time)

    def rough_shift(self, motion: SettledMotion) -> tuple[float, Floats]:
        """Return the best shift on a grid over the cycle, and the negative log-likelihood of every shift.

        Displacements are compared without their trend.
        """
        grid = np.arange(TOL.shifts) * self.period / TOL.shifts
        loss = np.zeros(TOL.shifts)
        models = self.model(motion, grid)
        for name, folded in self.folded.items():
            measured, model = folded.periodic(grid), models[name]
            if name == "displacement":
                model = model - motion.advance * grid / self.period
                model = model - model.mean()
            else:
                measured = measured + folded.coefficients[0]
            misfits, energy = misfits_at_shifts(measured, model)
            misfits = np.maximum(misfits, 0.0) + TOL.least_misfit * energy
            loss += 0.5 * self.time.size * np.log(misfits + np.finfo(float).tiny)
        return float(grid[np.argmin(loss)]), loss


def misfits_at_shifts(measured: Floats, models: Floats) -> tuple[Floats, Floats]:
    """Return the sum of squared differences of a measured cycle from models, for every shift of these.

    Parameters
    ----------
    measured : array, shape (N,)
        One cycle.
    models : array, shape (..., N)
        One cycle of each model.

    Returns
    -------
    tuple of array
        The sums, (..., N), by one correlation; and the sum of squares of both cycles, (..., 1).
    """
    both = np.fft.irfft(np.conj(np.fft.rfft(measured)) * np.fft.rfft(models), measured.size)
    energy = measured @ measured + np.square(models).sum(axis=-1, keepdims=True)
    return energy - 2.0 * both, energy


def check_scene(scene: Scene) -> None:
    """Refuse a scene that cannot be compared with a record.

    Raises
    ------
    InputError
        If its amplitude, of several the largest one, is below 1e-20 m: squares could not be summed with the
        record's.
    """
    fields = scene.arrays()
    own = [name for name in AMPLITUDES if name in fields._fields]
    name = max(own, key=lambda name: getattr(fields, name), default="along_amplitude")
    value, least = float(getattr(scene, name) if own else scene.scale), 1.0 / TOL.largest
    if value < least:
        raise InputError(f"{name} = {value:.15g} m: must be at least {least:g} m beside a record")


def low_passed(
    sample: Callable[[Floats, float], dict[str, Floats]],
    time: Floats,
    period: float,
    corner: float,
    window: float = 0.0,
) -> dict[str, Floats]:
    """Return signals behind a low-pass filter of the first order.

    Parameters
    ----------
    sample : callable
        Returns the signals, (..., N), at trough times, (N,), averaged over a window [s].
    time : array, shape (..., N)
        Trough times [s].
    period : float
        After which the signals repeat, but for an advance [s].
    corner : float
        Of the filter; inf without one [Hz].
    window : float
        Of the averages, without a filter [s].
    """
    if math.isinf(corner):
        return sample(time, window)
    count = TOL.filtered
    cycle = period * np.arange(count + 1) / count
    turns = np.floor(time / period)
    found = {}
    for name, values in sample(cycle, period / count).items():
        advance = values[..., -1:] - values[..., :1]
        waves = np.fft.rfft(values[..., :-1] - advance * cycle[:-1] / period)
        waves /= 1.0 + 1j * np.arange(waves.shape[-1]) / (period * corner)
        smooth = np.fft.irfft(waves, count)
        smooth = np.concatenate([smooth, smooth[..., :1]], axis=-1)
        at = np.broadcast_to(time - turns * period, (*smooth.shape[:-1], time.shape[-1]))
        rows = zip(at.reshape(-1, at.shape[-1]), smooth.reshape(-1, count + 1), strict=True)
        folded = np.array([np.interp(a, cycle, s) for a, s in rows]).reshape(at.shape)
        found[name] = folded + advance * (time / period - 1.0 / (math.tau * period * corner))
    return found


def computed_signals(
    motion: SettledMotion, names: Iterable[str], time: Floats, window: float, *, absolute: bool = False
) -> dict[str, Floats]:
    """Compute signals of the model at trough times.

    Accelerations and friction jump where a slide starts or ends, which no record resolves and no search can
    follow. They are therefore averaged, exactly, over a window.

    Parameters
    ----------
    motion : SettledMotion
        The model.
    names : iterable of str
        Signals of ``Observation``.
    time : array
        Trough times [s].
    window : float
        Width of the averages [s].
    absolute : bool
        Whether to add the trough's motion to those of the body, which are relative to it.
    """
    names = list(names)
    jumping = {"acceleration", "friction"} & set(names)
    shifts = (0.0, 0.5 * window, -0.5 * window) if jumping else (0.0,)
    sample = motion.sample(np.concatenate([time + shift for shift in shifts]))
    n = time.size
    velocity = sample.velocity
    signals = {"displacement": sample.position[:n], "velocity": velocity[:n]}
    if jumping:
        signals["acceleration"] = (velocity[n : 2 * n] - velocity[2 * n :]) / window
        signals["friction"] = signals["acceleration"] - sample.inertial[:n]
    if absolute:
        trough = motion.trough(time)
        signals = {name: values + trough.get(name, 0.0) for name, values in signals.items()}
    return {name: signals[name] for name in names}


def align(observation: Observation, motion: SettledMotion) -> Alignment:
    """Find the trough time of a record's clock, unless it was measured.

    The shift of least mean absolute misfit is searched, each signal weighted by the inverse of its own
    misfit, displacements without their trend. Friction that is smoothed, by a solver or an elastic body,
    differs most from the model in the few samples where a slide starts or ends. Squares would give these
    samples too much weight, so absolute values are used. The error is the shift at which the (Laplace)
    log-likelihood has fallen by 1/2, as at one sigma.

    Parameters
    ----------
    observation : Observation
        The record.
    motion : SettledMotion
        The model.
    """
    if observation.clock is not None:
        return Alignment(observation.clock.value, observation.clock.error, ())
    observation = observation.middle
    signals, period = observation.signals, observation.period
    rough, losses = observation.rough_shift(motion)
    if float(np.ptp(losses)) < TOL.flat * observation.time.size:
        return Alignment(math.nan, math.nan, ())

    def residuals(shift: float) -> dict[str, Floats]:
        model = observation.model(motion, observation.time + shift)
        found = {name: values - model[name] for name, values in signals.items()}
        if "displacement" in found:
            found["displacement"] = detrended(observation.time, found["displacement"], 1)
        return found

    counts = {
        name: independent_samples(observation.time, r, observation.frequency)
        for name, r in residuals(rough).items()
    }
    least = {name: TOL.least_misfit * float(np.abs(s).mean()) for name, s in signals.items()}
    # The rough search took all samples as independent: reduce its likelihoods to the effective number.
    losses = losses * max(counts.values()) / observation.time.size

    def loss(shift: float) -> float:
        sizes = {name: float(np.abs(r).mean()) + least[name] for name, r in residuals(shift).items()}
        return sum(counts[name] * math.log(x + np.finfo(float).tiny) for name, x in sizes.items())

    near = rough + period * np.linspace(-TOL.searched, TOL.searched, TOL.searched_steps)
    place = float(near[np.argmin([loss(shift) for shift in near])])
    step = float(near[1] - near[0])
    bounds = (place - step, place + step)
    best = minimize_scalar(loss, bounds=bounds, method="bounded", options={"xatol": 1e-9 * period})
    shift, least_loss = float(best.x), float(best.fun)
    error = 0.5 * sum(_reach(loss, shift, least_loss, way * period) for way in (1, -1))
    if not {"displacement", "velocity"} & signals.keys():
        # Accelerations and friction show only jumps, and a jump may lie anywhere between two samples: add the
        # standard deviation of a uniform distribution over one sample time.
        error = math.hypot(error, observation.sample_time / math.sqrt(12.0))
    low = (losses <= np.roll(losses, 1)) & (losses <= np.roll(losses, -1))
    rivals = np.flatnonzero(low & (losses - losses.min() < 0.5 * TOL.likely_sigmas**2)) * period / TOL.shifts
    apart = np.abs((rivals - shift + 0.5 * period) % period - 0.5 * period) > TOL.searched * period
    return Alignment(shift % period, error, tuple(rivals[apart].tolist()))


def _reach(loss: Callable[[float], float], shift: float, least: float, period: float) -> float:
    """Return the distance at which the log-likelihood has fallen by 1/2: forward for ``period`` > 0."""

    def fallen(distance: float) -> float:
        return loss(shift + distance) - least - 0.5

    near, far = 0.0, 1e-7 * period
    while fallen(far) < 0.0:
        near, far = far, 2.0 * far
        if abs(far) > 0.5 * abs(period):
            return 0.5 * abs(period)
    return abs(brentq(fallen, near, far, xtol=1e-6 * abs(far)))


# ------------------------------------------------------------------------------
# Frequency at which signals repeat, its standard error, and whether it differs from that of the drive.

_Places = NDArray[np.intp]

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
    rate : float
        Rows in a second [Hz].
    alive : bool array
        Which of the signals vibrate by more than rounding; the others are left out.
    """

    def __init__(self, time: Floats, signals: Mapping[str, Floats], powers: Mapping[str, int]) -> None:
        self.span = float(np.ptp(time))
        self.rate = (time.size - 1) / self.span
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

    def near(self, stated: float) -> float | None:
        """Find the largest wave within a tenth of a frequency, however few samples a cycle it has.

        Samples show a frequency above half their rate at a lower one: a wave there is taken for the frequency
        nearest to the stated one. None if no wave stands up there, or another one is far larger.
        """
        frequency, waves = self._spectrum
        turns = np.round((stated - frequency) / self.rate), np.round((stated + frequency) / self.rate)
        meant = np.stack([turns[0] * self.rate + frequency, turns[1] * self.rate - frequency])
        meant = meant[np.argmin(abs(meant - stated), axis=0), np.arange(frequency.size)]
        inside = abs(meant - stated) <= TOL.near_stated * stated
        if not inside.any():
            return None
        place = int(np.argmax(np.where(inside, waves, 0.0)))
        beside = waves[max(place - 1, 0) : place + 2]
        if waves[place] < beside.max() or waves[place] < TOL.own_wave * waves.max():
            return None
        return float(meant[place])

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
    def _spectrum(self) -> tuple[Floats, Floats]:
        """Return frequencies of at least two cycles [Hz], and all signals' power at them, over its total."""
        size = TOL.padding * self._time.size
        even = np.linspace(self._time[0], self._time[-1], self._time.size)
        frequency = np.fft.rfftfreq(size, 1.0 / self.rate)
        frequency = frequency[frequency * self.span >= TOL.least_cycles]
        if not frequency.size or not self.alive.any():
            return np.zeros(0), np.zeros(0)
        columns = [np.interp(even, self._time, column) for column in self._signals.T]
        waves = np.abs(np.fft.rfft(columns, size, axis=1)[:, -frequency.size :]) ** 2
        shaped = waves * frequency ** (2.0 * self._powers[:, None])
        shaped /= np.maximum(shaped.sum(axis=1, keepdims=True), np.finfo(float).tiny)
        return np.asarray(frequency, np.float64), np.asarray(shaped.sum(axis=0), np.float64)

    @cached_property
    def _peak(self) -> float:
        """Frequency of the largest wave; NaN where no wave can be resolved [Hz]."""
        frequency, waves = self._spectrum
        able = frequency * TOL.coarsest <= self.rate
        return float(frequency[able][np.argmax(waves[able])]) if able.any() else math.nan

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

    def _regression(self, frequency: float, which: _Places | None = None) -> tuple[Floats, Floats]:
        """Return coefficients of the trend and of all harmonics, or some, and the residuals, (N, signals).

        The harmonics end at a frequency that is the same for all that are tried. Residuals are scaled up for
        the number of coefficients.
        """
        top = min(TOL.explained_up_to * self._peak, 0.5 * TOL.of_nyquist * self.rate)
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

    def _squares(self, frequency: float, which: _Places | None = None) -> Floats:
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
