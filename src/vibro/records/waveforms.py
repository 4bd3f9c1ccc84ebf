"""The trough's motion with all its harmonics, measured by sensors on it, and its uncertainty.

Each record is regressed as it was recorded: a displacement by double integration would drift by many
amplitudes, and an acceleration by differences would be noise. Its harmonics are told as those of the
acceleration, which the loads of a drive are.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from vibro.errors import InputError, argument, shown
from vibro.quantities import MOST_HARMONICS, QUANTITIES
from vibro.reals import shielded
from vibro.records.folding import Estimate, Floats, harmonics
from vibro.records.reading import Record, read_record
from vibro.records.signals import read_sensitivities
from vibro.records.tolerances import TOL
from vibro.records.trough import (
    Trough,
    Wave,
    drive_frequency,
    refuse_line_down,
    to_accelerations,
    trough_signals,
)

if TYPE_CHECKING:
    from os import PathLike


Complexes = NDArray[np.complex128]

_ALONG, _NORMAL = "trough_along", "trough_normal"
_TRENDS: Final = 2  # offset, with gravity's part in it, and slow drift of the sensor
_SEED: Final = 1


@dataclass(frozen=True, eq=False)
class Motions:
    """One motion of a trough, or one of each of several draws.

    Attributes
    ----------
    frequency : array
        Drive frequency [Hz], of any shape.
    along, normal : complex array
        Displacement harmonics, the first one first, shape (H, *shape of the frequency): the trough moves
        along itself as the sum of ``abs(x) * sin(k w t + angle(x))`` [m].
    """

    frequency: Floats
    along: Complexes
    normal: Complexes

    def drive(self) -> dict[str, Any]:
        """Return the fields of a ``Scene``: of an ellipse if there is one harmonic, else of harmonics."""
        x, y = self.along, self.normal
        if len(x) == 1:
            phase = np.angle(y[0]) - np.angle(x[0])
            fields = {"along_amplitude": abs(x[0]), "normal_amplitude": abs(y[0]), "normal_phase": phase}
        else:
            fields = {
                name: [(abs(z), np.angle(z)) for z in way] if way.any() else ()
                for name, way in (("along_harmonics", x), ("normal_harmonics", y))
            }
        return {**fields, "frequency": self.frequency}

    def scaled(self, along: float = 1.0, normal: float = 1.0) -> Motions:
        """Multiply the motions along the trough and normal to it by factors."""
        return replace(self, along=along * self.along, normal=normal * self.normal)

    def turned(self, angle: float) -> Motions:
        """Turn the sensors in their plane: what the trough moves along itself seems to lead upwards [rad]."""
        cosine, sine = math.cos(angle), math.sin(angle)
        x, y = self.along, self.normal
        return replace(self, along=cosine * x - sine * y, normal=sine * x + cosine * y)

    def delayed(self, delay: float) -> Motions:
        """Delay the motion normal to the trough [s]."""
        count = len(self.normal)
        orders = np.arange(1, count + 1).reshape(count, *([1] * self.frequency.ndim))
        return replace(self, normal=self.normal * np.exp(-1j * math.tau * orders * self.frequency * delay))

    def up_to(self, order: int) -> Motions:
        """Leave out the harmonics above an order, which become 0."""
        kept = np.arange(1, len(self.along) + 1) <= order
        kept = kept.reshape(-1, *([1] * self.frequency.ndim))
        return replace(self, along=self.along * kept, normal=self.normal * kept)


@dataclass(frozen=True, eq=False)
class MeasuredMotion:
    """Periodic motion of a trough, measured by one or two sensors on it; returned by ``measured_motion``.

    The phase is 0 where the first harmonic along the trough passes its mean position forwards or, without
    motion along the trough, where that normal to it passes its mean position upwards.

    Attributes
    ----------
    frequency, frequency_error : float
        Drive frequency and its standard error [Hz].
    channels : tuple of str
        Measured directions: ``"trough_along"``, ``"trough_normal"`` or both.
    accelerations : complex array, shape (H, channels)
        Harmonics a_k of the accelerations, the sum of ``abs(a_k) * sin(k w t + angle(a_k))`` [m/s^2].
    covariance : complex array, shape (H, channels, channels)
        Error covariance of each harmonic over the channels, E[da conj(db)]. The covariance of the real parts,
        and that of the imaginary parts, is half of its real part [m^2/s^4].
    freedom : float
        Degrees of freedom of this covariance; random draws follow Student's t [1].
    p_values : array
        For every harmonic that was tested, the probability that noise alone is as large [1].
    significant : int
        Order of the last significant harmonic. H is smaller if a drive cannot have so many harmonics.
    drive_angle : float or None
        Angle of the drive's line, which gives the other direction with one sensor; None with two [rad].
    clock : float
        Time in the record at which the phase is 0 [s].
    span : float
        Length of the record [s].
    rows : int
        Number of rows of the record.
    trough : Trough
        The first harmonic alone: line or ellipse, with standard errors.
    warnings : tuple of str
        Reasons to doubt the measurement.
    """

    frequency: float
    frequency_error: float
    channels: tuple[str, ...]
    accelerations: Complexes
    covariance: Complexes
    freedom: float
    p_values: Floats
    significant: int
    drive_angle: float | None
    clock: float
    span: float
    rows: int
    trough: Trough
    warnings: tuple[str, ...]

    @property
    def order(self) -> int:
        """Number of harmonics, H."""
        return len(self.accelerations)

    @property
    def motion(self) -> Motions:
        """The measured motion: frequency [Hz] and displacement harmonics [m]."""
        return self._motions(np.array(self.frequency), self.accelerations[..., None])

    @property
    def along(self) -> Complexes:
        """Displacement harmonics along the trough, shape (H,): complex, modulus [m] and phase."""
        return self.motion.along

    @property
    def normal(self) -> Complexes:
        """Displacement harmonics normal to the trough, shape (H,): complex, modulus [m] and phase."""
        return self.motion.normal

    @property
    def standard_errors(self) -> Floats:
        """Standard errors of the displacement amplitudes, shape (H, channels) [m]."""
        variances = 0.5 * np.diagonal(self.covariance, axis1=1, axis2=2).real
        return np.asarray(np.sqrt(variances) / self._rates[:, None] ** 2)

    @property
    def phase_errors(self) -> Floats:
        """Standard errors of the phases, shape (H, channels) [rad].

        Phases are relative to that of the first harmonic, whose own error is therefore 0. An error is at most
        pi / sqrt(3), that of an unknown phase.
        """
        first = _reference(self.accelerations, self.covariance)
        relative = self.covariance / (self.accelerations[:, :, None] * self.accelerations[:, None, :].conj())
        own = 0.5 * np.diagonal(relative, axis1=1, axis2=2).real
        orders = np.arange(1, self.order + 1)[:, None]
        variances = own + orders**2 * own[0, first]
        variances[0] -= relative[0, :, first].real
        return np.asarray(np.minimum(np.sqrt(np.maximum(variances, 0.0)), math.pi / math.sqrt(3.0)))

    @property
    def shares(self) -> Floats:
        """Acceleration of each harmonic over that of the first, both directions together; shape (H,) [1]."""
        sizes = np.linalg.norm(self.accelerations, axis=1)
        shares: Floats = sizes / sizes[0]
        return shares

    def drive(self) -> dict[str, Any]:
        """Return the measured motion as fields of a ``Scene``.

        Returns
        -------
        dict
            ``frequency``, with ``along_amplitude``, ``normal_amplitude`` and ``normal_phase`` if one harmonic
            is significant, else ``along_harmonics`` and ``normal_harmonics``; in SI units and radians.
        """
        return self.motion.drive()

    def draws(self, count: int, seed: int = _SEED) -> dict[str, Any]:
        """Draw random motions from the measurement's error distribution, as fields of a ``Scene``.

        Parameters
        ----------
        count : int
            Number of draws n.
        seed : int
            Seed of the random numbers; the same seed gives the same draws.

        Returns
        -------
        dict
            Fields as from ``drive``, arrays of shape (n,).

        Examples
        --------
        >>> import vibro
        >>> feeder = vibro.measured_motion("examples/data/nut_trough_mv.csv", trough_along="Trog längs",
        ...                                trough_normal="Trog normal", sensitivity="100mV/g")
        >>> nuts = vibro.Scene(**feeder.draws(100), static_friction=0.74, kinetic_friction=0.57)
        >>> vibro.solve(nuts).mean_velocity.shape
        (100,)
        """
        return self.drawn(count, seed).drive()

    def drawn(self, count: int, seed: int = _SEED) -> Motions:
        """Draw random motions as ``draws`` does, and return them as harmonics."""
        random = np.random.default_rng(seed)
        size, channels = self.accelerations.shape
        normal = random.standard_normal((2, size, channels, count))
        # The covariance is itself measured, from few bins in a short record: errors follow Student's t,
        # whose scale makes Hotelling's statistic exact.
        bins = 0.5 * self.freedom + channels - 1.0
        heavy = np.sqrt(self.freedom / random.chisquare(self.freedom, (size, 1, count)))
        heavy *= math.sqrt(bins / (0.5 * self.freedom))
        roots = np.linalg.cholesky(self.covariance)
        off = np.einsum("kab,kbn->kan", roots, (normal[0] + 1j * normal[1]) / math.sqrt(2.0)) * heavy
        frequency = self.frequency + self.frequency_error * random.standard_normal(count)
        return self._motions(frequency, self.accelerations[..., None] + off)

    def measured_drive(self) -> HarmonicDrive:
        """Return the harmonics as quantities with standard errors."""
        motion, both = self.motion, len(self.channels) == 2
        own = motion.along if _ALONG in self.channels else motion.normal
        frequency = Estimate(self.frequency, self.frequency_error)
        quantities = {"frequency": frequency}
        for i, (way, values) in enumerate((("along", motion.along), ("normal", motion.normal))):
            for k, z in enumerate(values):
                end = f"_{k + 1}" if k else ""
                # One sensor gives both motions, with the same relative errors.
                channel, share = (i, 1.0) if both else (0, abs(z) / abs(own[k]))
                size = Estimate(float(abs(z)), float(share * self.standard_errors[k, channel]))
                phase = Estimate(float(np.angle(z)), float(self.phase_errors[k, channel]))
                quantities |= {f"{way}_amplitude{end}": size, f"{way}_phase{end}": phase}
        warnings = self.trough.doubts(pure=False)
        return HarmonicDrive(
            self.trough, quantities, self.trough.drive_on_ellipse().clock, warnings, self._moved
        )

    @property
    def _moved(self) -> list[tuple[dict[str, Any], dict[str, Any]]]:
        """Fields of a scene for each independent error, one standard error to either side."""
        offsets = []
        values, vectors = np.linalg.eigh(self.covariance)
        for k, channel, unit in product(range(self.order), range(len(self.channels)), (1.0, 1j)):
            off = np.zeros_like(self.accelerations)
            off[k] = unit * math.sqrt(0.5 * max(float(values[k, channel]), 0.0)) * vectors[k, :, channel]
            offsets.append((0.0, off))
        offsets.append((self.frequency_error, np.zeros_like(self.accelerations)))

        def fields(late: float, off: Complexes) -> dict[str, Any]:
            moved = self._motions(np.array(self.frequency + late), (self.accelerations + off)[..., None])
            return {n: float(x) if isinstance(x, np.ndarray) else x for n, x in moved.drive().items()}

        return [(fields(late, off), fields(-late, -off)) for late, off in offsets]

    @property
    def _rates(self) -> Floats:
        return np.asarray(math.tau * self.frequency * np.arange(1, self.order + 1), np.float64)

    def _motions(self, frequency: Floats, accelerations: Complexes) -> Motions:
        """Return motions by their accelerations, (H, channels, n), with the clock set to each."""
        first = _reference(self.accelerations, self.covariance)
        orders = np.arange(1, self.order + 1)[:, None, None]
        # The acceleration of X sin(k w t + xi) has the opposite sign.
        motion = -accelerations / (math.tau * orders * frequency) ** 2
        motion = motion * np.exp(-1j * orders * np.angle(motion[0, first]))
        motion[0, first] = abs(motion[0, first])
        motion = motion.reshape(self.order, len(self.channels), *frequency.shape)
        if self.drive_angle is None:
            return Motions(frequency, motion[:, 0], motion[:, 1])
        (one,), slope = motion.transpose(1, 0, *range(2, motion.ndim)), math.tan(self.drive_angle)
        along, normal = (one, slope * one) if _ALONG in self.channels else (one / slope, one)
        return Motions(frequency, along, normal)


class HarmonicDrive(NamedTuple):
    """Measured harmonics of a scene's drive, with the attributes of ``MeasuredDrive``."""

    trough: Trough
    quantities: dict[str, Estimate]
    clock: Estimate
    warnings: tuple[str, ...]
    moved: list[tuple[dict[str, Any], dict[str, Any]]]


@shielded
def measured_motion(
    path: str | PathLike[str],
    *,
    trough_along: str | None = None,
    trough_normal: str | None = None,
    time: str | None = None,
    sensitivity: str | Sequence[str] = (),
    reverse: bool = False,
    drive_angle: float | None = None,
) -> MeasuredMotion:
    """Determine a trough's periodic motion from a record of one or two sensors on it.

    Parameters
    ----------
    path : str or path
        Text file of columns, with any separator and decimal points or commas.
    trough_along, trough_normal : str, optional
        Headers of the columns of the motion along the trough (positive in the conveying direction) and normal
        to it (positive upwards): accelerations [m/s^2, g], velocities [mm/s], displacements [mm] or voltages.
        One of them may be left out.
    time : str, optional
        Header of the time column; by default the only column with a unit of time.
    sensitivity : str or sequence of str
        Sensitivities of voltages: ``"100mV/g"`` for all columns, or ``"trough-along=101mV/g"`` for one.
    reverse : bool
        Whether the axis of the sensor along the trough points against the conveying direction.
    drive_angle : float, optional
        With one sensor, the angle of the line along which the trough moves; 0 if it moves along itself [rad].

    Returns
    -------
    MeasuredMotion
        The motion with its errors: ``drive()`` returns fields of a ``Scene``, ``draws(n)`` those of n random
        scenes from the error distribution.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If columns are missing or wrong; if no oscillation is significant, or the record is too short or
        sampled too coarsely; if one sensor comes without a drive angle, or two with one; if one of two
        sensors is inverted.

    Notes
    -----
    Both channels are fitted by least squares with one frequency, up to 16 harmonics, and an offset and a
    trend each. The error covariance of a harmonic is the spectral matrix of the residuals within 0.35 of the
    drive frequency on both sides of it. Harmonics are kept up to the last one that is significant in an
    F-test at the level of 1 in 1000. The errors are those of noise, without those of calibration: on
    synthetic feeders 68 % of the results lie within one standard error and 95 % within two
    (tests/records/test_waveforms.py).

    Examples
    --------
    >>> import vibro
    >>> feeder = vibro.measured_motion("examples/data/nut_trough_mv.csv", trough_along="Trog längs",
    ...                                trough_normal="Trog normal", sensitivity="100mV/g")
    >>> print(f"{feeder.frequency:.2f} Hz, {feeder.order} harmonic")
    15.00 Hz, 1 harmonic
    >>> nut = vibro.Scene(**feeder.drive(), static_friction=0.74, kinetic_friction=0.57)
    >>> print(f"{1e3 * float(vibro.solve(nut).mean_velocity):.1f} mm/s")
    17.7 mm/s
    """
    given = {_ALONG: trough_along, _NORMAL: trough_normal, "time": time}
    columns = {name: text for name, text in given.items() if text is not None}
    texts = [sensitivity] if isinstance(sensitivity, str) else sensitivity
    record = read_record(Path(path), columns, read_sensitivities(texts), body=False)
    return motion_of(record, reverse=reverse, drive_angle=drive_angle)


def motion_of(
    record: Record, *, reverse: bool = False, drive_angle: float | None = None, down: bool = False
) -> MeasuredMotion:
    """Measure the trough's motion from a record of it.

    Parameters and errors are those of ``measured_motion``, and ``down`` of ``trough_of``.
    """
    _check_sensors(record, drive_angle)
    signals = trough_signals(record, reverse=reverse)
    span = float(np.ptp(record.time))
    frequency = _frequency(record, signals)
    _check_size(record, span, frequency)
    middle = 0.5 * float(record.time[0] + record.time[-1])
    time, values = record.time - middle, np.stack(list(signals.values()), axis=1)
    rate = (time.size - 1) / span
    count = min(TOL.motion_harmonics, int(TOL.of_sampling * rate / frequency))

    frequency = _refined(time, values, frequency, count)
    _, _, p_values, _ = _measured(time, values, frequency, count)
    standing = np.flatnonzero(p_values < TOL.by_chance)
    significant = int(standing[-1]) + 1 if standing.size else 1
    # Noise in a harmonic that the motion lacks would shift the frequency, the more the higher it is.
    frequency = _refined(time, values, frequency, significant)
    sizes, covariance, p_values, bins = _measured(time, values, frequency, count)
    order = min(significant, MOST_HARMONICS)
    sizes, covariance = sizes[:order], covariance[:order]
    error = _frequency_error(time, values, frequency, sizes, covariance)
    channels = tuple(signals)

    factors = np.stack([to_accelerations(record, frequency, order)[name] for name in channels], axis=1)
    sizes = sizes * factors
    covariance = covariance * factors[:, :, None] * factors[:, None, :].conj()
    first = _reference(sizes, covariance)
    phase = float(np.angle(-sizes[0, first]))
    rest = _rest(time, values, frequency, order) * abs(factors[0])
    trough = _fundamental(record, Estimate(frequency, error), sizes, covariance, rest, span)
    if not down:
        refuse_line_down(trough, reverse=reverse)
    beyond = significant - order
    too_many = f"the motion has {significant} harmonics, a drive has at most {order}: {beyond} are left out"
    return MeasuredMotion(
        frequency=frequency,
        frequency_error=error,
        channels=channels,
        accelerations=sizes * np.exp(-1j * np.arange(1, order + 1) * phase)[:, None],
        covariance=covariance,
        freedom=2.0 * (bins - len(channels) + 1),
        p_values=p_values,
        significant=significant,
        drive_angle=drive_angle,
        clock=middle - phase / (math.tau * frequency),
        span=span,
        rows=time.size,
        trough=trough,
        warnings=(*trough.doubts(pure=False), *_clipped(record), *([too_many] if beyond else [])),
    )


def _check_sensors(record: Record, drive_angle: float | None) -> None:
    """Refuse one sensor without a drive angle, and two with one."""
    if len(record.trough) == 2:
        if drive_angle is not None:
            both = "two sensors measure the drive angle, which is given too"
            raise InputError(both, hint="leave out the drive angle, or one of the sensors")
        return
    (name,) = record.trough
    other = _NORMAL if name == _ALONG else _ALONG
    if drive_angle is None:
        missing = "normal to the trough" if other == _NORMAL else "along it"
        unknown = f"one sensor alone does not measure the motion {missing}"
        hint = f"name {argument(other)} too, or give the drive angle, if the trough moves along a line"
        raise InputError(unknown, hint=hint)
    quantity = QUANTITIES["drive_angle"]
    if not (math.isfinite(drive_angle) and quantity.allows(drive_angle)):
        said = f"drive angle = {quantity.text(quantity.from_si(drive_angle))}"
        raise InputError(f"{said}: must be {quantity.allowed.text(quantity.unit)}")
    if name == _NORMAL and math.sin(drive_angle) < TOL.least_component:
        level = f"{argument(name)} cannot measure a motion along the trough, at a drive angle of"
        raise InputError(f"{level} {math.degrees(drive_angle):.6g} deg", hint=f"name {argument(other)}")


def _check_size(record: Record, span: float, frequency: float) -> None:
    """Refuse a record that is too short for errors, or too coarse for harmonics."""
    cycles, samples = span * frequency, (record.time.size - 1) / (span * frequency)
    if cycles < TOL.motion_cycles * (1.0 - TOL.about):
        short = f"the record has {math.floor(100.0 * cycles) / 100.0:g} cycles of {frequency:.6g} Hz"
        raise InputError(f"{short}: at least {TOL.motion_cycles:g} are needed", hint="record longer")
    if samples < TOL.least_samples * (1.0 - TOL.about):
        coarse = (
            f"the record has {math.floor(100.0 * samples) / 100.0:g} samples a cycle of {frequency:.6g} Hz"
        )
        faster = math.ceil(TOL.usual_samples * frequency)
        hint = f"sample faster: at {faster} Hz and more harmonics are seen"
        raise InputError(f"{coarse}: at least {TOL.least_samples} are needed", hint=hint)


def _frequency(record: Record, signals: Mapping[str, Floats]) -> float:
    """Return the frequency of a record to well within 1/T, T its length.

    The search takes long in many rows: it begins in the middle of a long record, whose part then grows.
    """
    size, rows = record.time.size, min(record.time.size, TOL.frequency_rows)
    part = slice((size - rows) // 2, (size - rows) // 2 + rows)
    middle = {name: values[part] for name, values in signals.items()}
    frequency = drive_frequency(replace(record, time=record.time[part]), middle).value
    while (rows := TOL.frequency_growth * rows) < size:
        part = slice((size - rows) // 2, (size - rows) // 2 + rows)
        time = record.time[part] - 0.5 * float(record.time[part][0] + record.time[part][-1])
        values = np.stack([x[part] for x in signals.values()], axis=1)
        frequency = _refined(time, values, frequency, 1)
    return frequency


def _reference(sizes: Complexes, covariance: Complexes) -> int:
    """Return the channel whose first harmonic has the phase 0: the first, unless it does not stand out."""
    error = math.sqrt(0.5 * float(covariance[0, 0, 0].real))
    return 0 if abs(sizes[0, 0]) >= TOL.likely_sigmas * error or sizes.shape[1] == 1 else 1


# --- regression -----------------------------------------------------------------------------------------


def _basis(time: Floats, frequency: float, count: int) -> Floats:
    trend = np.vander(time / float(time[-1]), _TRENDS, increasing=True)
    return np.hstack([trend, harmonics(time, frequency, count)])


def _inverse(basis: Floats) -> Floats:
    """Return the inverse of the normal equations: in long records its products take most of the time."""
    return np.asarray(np.linalg.pinv(basis.T @ basis))


def _solved(basis: Floats, values: Floats, inverse: Floats) -> Floats:
    """Return the coefficients of least squares, refined once, as normal equations lose digits."""
    coefficients = inverse @ (basis.T @ values)
    return np.asarray(coefficients + inverse @ (basis.T @ (values - basis @ coefficients)))


def _refined(time: Floats, values: Floats, frequency: float, count: int) -> float:
    """Return the frequency of least squares of all channels together, by Gauss and Newton's method.

    Each channel weighs by the inverse of its residual's variance.
    """
    step_limit = TOL.frequency_step / float(np.ptp(time))
    rates = math.tau * np.arange(1, count + 1)[:, None]  # of phases, over the frequency
    for _ in range(TOL.frequency_rounds):
        basis = _basis(time, frequency, count)
        inverse = _inverse(basis)
        coefficients = _solved(basis, values, inverse)
        left = values - basis @ coefficients
        cosines, sines = coefficients[_TRENDS:].reshape(2, count, -1) * rates
        slope = basis[:, _TRENDS:] @ np.concatenate([sines, -cosines]) * time[:, None]
        slope -= basis @ _solved(basis, slope, inverse)
        weights = 1.0 / _variances(left, values)
        step = float((slope * left).sum(axis=0) @ weights / ((slope**2).sum(axis=0) @ weights))
        frequency += min(max(step, -step_limit), step_limit)
        if abs(step) < TOL.frequency_close * step_limit:
            break
    return frequency


def _variances(left: Floats, values: Floats) -> Floats:
    """Return the variance of each residual, at least that of rounding."""
    return np.asarray(np.square(left).mean(axis=0) + TOL.rounding * np.square(values).mean(axis=0))


def _measured(
    time: Floats, values: Floats, frequency: float, count: int
) -> tuple[Complexes, Complexes, Floats, int]:
    """Return all harmonics, (K, channels), their covariances, how likely noise is so large, and the bins."""
    basis = _basis(time, frequency, count)
    coefficients = _solved(basis, values, _inverse(basis))
    cosines, sines = coefficients[_TRENDS:].reshape(2, count, -1)
    sizes = sines + 1j * cosines
    covariance, bins = _covariances(time, values - basis @ coefficients, frequency, count)
    # Data may be exact: add their rounding.
    rounding = TOL.rounding * np.square(values).mean(axis=0) / time.size
    covariance = covariance + np.diag(rounding)
    statistic = np.einsum("ka,kab,kb->k", sizes.conj(), np.linalg.inv(covariance), sizes).real
    channels = sizes.shape[1]
    freedom = bins - channels + 1
    p_values = fdtrc(2.0 * channels, 2.0 * freedom, statistic * freedom / (bins * channels))
    return sizes, covariance, np.asarray(p_values), bins


def _covariances(time: Floats, left: Floats, frequency: float, count: int) -> tuple[Complexes, int]:
    """Return the covariance of each harmonic by the spectrum of the residual beside it, and its bins.

    The bins lie at whole multiples of 1/T from the harmonic, where they are independent of it and of each
    other. They see noise through the same window as the regression does: no taper is wanted. Rows that are
    left out, and times that are rounded, do no harm where each row takes the nearest place of an even clock.
    """
    steps = np.diff(time)
    # Where times are rounded the median is too: the mean of the steps over which no row is left out is not.
    step = float(steps[steps < 1.5 * np.median(steps)].mean())
    places = np.rint((time - time[0]) / step).astype(np.intp)
    clock = np.zeros((int(places[-1]) + 1, left.shape[1]), np.complex128)
    each = int(TOL.band * frequency * len(clock) * step)
    found = np.empty((count, left.shape[1], left.shape[1]), np.complex128)
    for k in range(1, count + 1):
        clock[:] = 0.0
        np.add.at(clock, places, left * np.exp(-1j * math.tau * k * frequency * time)[:, None])
        waves = np.fft.fft(clock, axis=0)
        beside = np.concatenate([waves[1 : each + 1], waves[-each:]])
        found[k - 1] = 4.0 / time.size**2 * (beside.T @ beside.conj()) / (2 * each)
    return found, 2 * each


def _frequency_error(
    time: Floats, values: Floats, frequency: float, sizes: Complexes, covariance: Complexes
) -> float:
    """Return the standard error of the frequency, from the noise around each harmonic."""
    basis = _basis(time, frequency, len(sizes))
    weights = 1.0 / _variances(values - basis @ _solved(basis, values, _inverse(basis)), values)
    rates = (math.tau * np.arange(1, len(sizes) + 1)) ** 2
    noise = np.einsum("ka,kab,kb->k", (sizes * weights).conj(), covariance, sizes * weights).real @ rates
    power = (abs(sizes) ** 2 @ weights) @ rates
    return math.sqrt(6.0 * float(noise)) / (float(power) * float(np.ptp(time)))


def _rest(time: Floats, values: Floats, frequency: float, order: int) -> Floats:
    """Return the root mean square of what harmonics leave of each channel, as recorded."""
    basis = _basis(time, frequency, order)
    left = values - basis @ _solved(basis, values, _inverse(basis))
    return np.asarray(np.sqrt(np.square(left).mean(axis=0)))


def _fundamental(
    record: Record, frequency: Estimate, sizes: Complexes, covariance: Complexes, rest: Floats, span: float
) -> Trough:
    """Return the fundamental; ``rest`` are the residuals by channel [m/s^2]."""
    middle = 0.5 * float(record.time[0] + record.time[-1])
    at_zero = np.exp(-1j * math.tau * frequency.value * middle)
    powers = 0.5 * abs(sizes) ** 2
    waves: dict[str, Wave] = {}
    for i, name in enumerate(record.trough):
        own = float(powers[0, i]) or 1.0
        waves[name] = Wave(
            record.headers[name],
            complex(sizes[0, i] * at_zero),
            math.sqrt(0.5 * float(covariance[0, i, i].real)),
            math.sqrt(float(powers[1:, i].sum()) / own),
            float(rest[i]) / math.sqrt(own),
            record.sensitivities.get(name, ""),
        )
    return Trough(frequency, waves.get(_ALONG), waves.get(_NORMAL), span)


def _clipped(record: Record) -> list[str]:
    """Warn of signals that stand at their largest or smallest value, as a sensor beyond its range does."""
    found = []
    for name, values in record.trough.items():
        levels = np.unique(values)
        near = max(TOL.clip_band * float(np.ptp(values)), 1.5 * float(np.diff(levels).min(initial=math.inf)))
        for end in (levels[0], levels[-1]):
            off = abs(values - end)
            there = int(np.count_nonzero(off == 0.0))
            beside = int(np.count_nonzero(off <= near)) - there
            if there > TOL.clip_ratio * max(beside, 1):
                unit = ("m/s^2", "m/s", "m")[record.trough_derivatives[name]]
                text = f"column {shown(record.headers[name])} stands at {end:.6g} {unit} in {there} rows"
                found.append(f"{text}: it looks clipped, and so do its harmonics; record with a larger range")
    return found
