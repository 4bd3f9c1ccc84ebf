"""A record as it is compared with the model, and its position in the drive cycle."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from vibro.errors import InputError
from vibro.motion.settled import SettledMotion
from vibro.quantities import AMPLITUDES
from vibro.records.folding import Estimate, Floats, Folded, detrended, fold, independent_samples
from vibro.records.reading import Record
from vibro.records.tolerances import TOL
from vibro.scene import Scene

_RANGE: Final = f"[{1.0 / TOL.largest:g}, {TOL.largest:g}]"
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
    """

    time: Floats
    signals: Mapping[str, Floats]
    frequency: float
    clock: Estimate | None = None
    sensitivities: Mapping[str, str] = field(default_factory=dict)
    absolute: bool = False
    frequency_error: float = 0.0

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

        Raises
        ------
        InputError
            If a force is the only signal and the mass is missing; or if the mass is beyond 1e-20 to 1e20 kg.
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
        if "acceleration" in signals:
            # The velocity of a steady motion repeats, so that its acceleration has no mean. A mean in the
            # record is the sensor's zero, or gravity on a sensor that is not level: subtract it.
            steady = fold(record.time, signals["acceleration"], frequency, _TRENDS["acceleration"])
            signals["acceleration"] = signals["acceleration"] - steady.coefficients[0]
        about = clock, record.sensitivities, absolute, frequency_error
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
        trough = motion.trough(self.time + shift)
        signals = {name: values - trough.get(name, 0.0) for name, values in self.signals.items()}
        return replace(self, signals=signals, absolute=False)

    def model(self, motion: SettledMotion, time: Floats) -> dict[str, Floats]:
        """Compute what the record's sensors show at trough times."""
        return computed_signals(motion, self.signals, time, self.sample_time, absolute=self.absolute)

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
