"""The trough's motion and the drive of a scene, measured by sensors on the trough.

Accelerations are what parts feel, so that every motion is told as one: a harmonic of a velocity or of a
displacement is multiplied by i k w once or twice.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibro.errors import InputError, argument, shown
from vibro.quantities import ELLIPTICAL, QUANTITIES
from vibro.records.folding import Estimate, Floats, fold
from vibro.records.frequencies import Repetition
from vibro.records.reading import Record
from vibro.records.signals import SIGNAL_UNITS, doubt
from vibro.records.tolerances import TOL

_ALONG, _NORMAL = "trough_along", "trough_normal"
_TRENDS: Final = 2  # offset, with gravity's part in it, and slow drift of the sensor
_G: Final = SIGNAL_UNITS["acceleration"]["g"]


@dataclass(frozen=True)
class Wave:
    """The fundamental of an acceleration of the trough.

    Attributes
    ----------
    header : str
        Header of its column.
    value : complex
        Amplitude of the sine at the drive's frequency; its angle is the phase at the clock's zero [m/s^2].
    error : float
        Standard error of the amplitude, and of the phase times the amplitude [m/s^2].
    harmonics, rest : float
        Root mean square of the harmonics, and of the residual, over that of the fundamental.
    sensitivity : str
        Sensitivity of a voltage, as typed; empty for an acceleration.
    """

    header: str
    value: complex
    error: float
    harmonics: float
    rest: float
    sensitivity: str


@dataclass(frozen=True)
class Trough:
    """The measured motion of the trough.

    Attributes
    ----------
    frequency : Estimate
        Drive frequency [Hz].
    along, normal : Wave or None
        Accelerations along the trough's surface, positive in the conveying direction, and normal to it,
        positive up and away from it.
    span : float
        Length of the record [s].
    """

    frequency: Estimate
    along: Wave | None
    normal: Wave | None
    span: float

    @property
    def waves(self) -> tuple[Wave, ...]:
        """The one or two accelerations that were measured."""
        return tuple(wave for wave in (self.along, self.normal) if wave is not None)

    @property
    def phase(self) -> float:
        """Phase by which the normal motion leads the motion along the trough, in (-pi, pi] [rad].

        NaN unless both were measured and are large enough for their phase to matter.
        """
        if self.along is None or self.normal is None:
            return math.nan
        sizes = abs(self.along.value), abs(self.normal.value)
        error = max(self.along.error, self.normal.error)
        if min(sizes) < max(TOL.least_component * max(sizes), TOL.likely_sigmas * error):
            return math.nan
        return float(np.angle(self.normal.value / self.along.value))

    @property
    def phase_error(self) -> float:
        """Standard error of the phase [rad]; NaN without one."""
        if math.isnan(self.phase):
            return math.nan
        return math.hypot(*(wave.error / abs(wave.value) for wave in self.waves))

    @property
    def on_an_ellipse(self) -> bool:
        """Whether the phase differs from a line's by more than noise and the delay of two channels."""
        return abs(math.remainder(self.phase, math.pi)) > max(
            math.radians(TOL.channel_phase), TOL.likely_sigmas * self.phase_error
        )

    @property
    def drive_angle(self) -> Estimate | None:
        """Angle of the longer axis above the trough's surface; None unless both were measured [rad]."""
        if self.along is None or self.normal is None:
            return None
        x, y = self.along.value, self.normal.value
        angle = 0.5 * math.atan2(2.0 * (x * y.conjugate()).real, abs(x) ** 2 - abs(y) ** 2)
        if angle < 0.0:  # by noise, as ``trough_of`` refuses lines that lead down: one of both is next to 0
            angle = 0.0 if abs(x) > abs(y) else 0.5 * math.pi
        across = math.hypot(self.along.error * math.sin(angle), self.normal.error * math.cos(angle))
        return Estimate(angle, across / math.hypot(abs(x), abs(y)))

    def drive_on_line(self, drive_angle: float | None = None) -> MeasuredDrive:
        """Return the quantities of a drive along a line.

        Parameters
        ----------
        drive_angle : float, optional
            Drive angle of the scene, if only one acceleration was measured [rad].

        Raises
        ------
        InputError
            If the only acceleration is at right angles to the drive's line.
        """
        angle = self.drive_angle
        value, error = self._along_the_drive(angle.value if angle else drive_angle or 0.0)
        found = {"amplitude": self._amplitude(value, error), "frequency": self.frequency}
        found |= {"drive_angle": angle} if angle else {}
        return MeasuredDrive(self, found, self._clock(value, error), self.warnings)

    def drive_on_ellipse(self, normal_phase: float | None = None) -> MeasuredDrive:
        """Return the quantities of an elliptical drive.

        Parameters
        ----------
        normal_phase : float, optional
            Phase of the scene [rad]; None if the scene moves along a line, or gives no drive.

        Notes
        -----
        Each acceleration gives its own amplitude, both together give the phase. The clock comes from the
        acceleration along the trough, or else from the normal one and the phase of the scene.
        """
        waves = {"along_amplitude": self.along, "normal_amplitude": self.normal}
        found = {name: self._amplitude(w.value, w.error) for name, w in waves.items() if w is not None}
        found["frequency"] = self.frequency
        if not math.isnan(self.phase):
            found["normal_phase"] = Estimate(self.phase, self.phase_error)
        wave, ahead = self.along, 0.0
        if wave is None or abs(wave.value) < TOL.likely_sigmas * wave.error:
            wave, ahead = self.normal, normal_phase or 0.0
        assert wave is not None
        warnings = (*self.warnings, *_doubts(self, found, normal_phase))
        return MeasuredDrive(self, found, self._clock(wave.value, wave.error, ahead), warnings)

    def _amplitude(self, value: complex, error: float) -> Estimate:
        """Return the amplitude of a motion from its acceleration and the error of that [m]."""
        frequency, frequency_error = self.frequency
        size = Estimate(abs(value), error).scaled((math.tau * frequency) ** -2)
        return Estimate(size.value, math.hypot(size.error, 2.0 * size.value * frequency_error / frequency))

    def _clock(self, value: complex, error: float, ahead: float = 0.0) -> Estimate:
        """Return the trough time at the clock's zero from an acceleration that leads by a phase [s]."""
        frequency, frequency_error = self.frequency
        rate = math.tau * frequency
        # The acceleration of A sin(w t) has the opposite sign.
        shift = (float(np.angle(-value)) - ahead) / rate % (1.0 / frequency)
        # The error of the frequency adds to that of the phase at the ends of the record.
        late = 0.5 * self.span * frequency_error / frequency
        return Estimate(shift, math.hypot(error / abs(value) / rate, late))

    def _along_the_drive(self, drive_angle: float) -> tuple[complex, float]:
        """Return the acceleration along the drive's line, and its standard error."""
        cosine, sine = math.cos(drive_angle), math.sin(drive_angle)
        if self.along is not None and self.normal is not None:
            x, y = self.along, self.normal
            return x.value * cosine + y.value * sine, math.hypot(x.error * cosine, y.error * sine)
        (wave,) = self.waves
        part, name, other = (cosine, _ALONG, _NORMAL) if self.along is not None else (sine, _NORMAL, _ALONG)
        if part < TOL.least_component:
            at = f"at a drive angle of {math.degrees(drive_angle):.6g} deg"
            hint = f"check the drive angle, or give {other}"
            raise InputError(f"{name} cannot measure the motion {at}", hint=hint)
        return wave.value / part, wave.error / part

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons to doubt that each of the two motions is one sinusoid."""
        return self.doubts(pure=True)

    def doubts(self, *, pure: bool) -> tuple[str, ...]:
        """Return reasons to doubt the sensors, and if ``pure`` that each motion is one sinusoid."""
        found = []
        for wave in self.waves:
            size, text = abs(wave.value), f"column {shown(wave.header)}: "
            if size < TOL.likely_sigmas * wave.error:
                text += f"no wave of {self.frequency.value:.5g} Hz stands out: is the sensor connected,"
                found.append(f"{text} and does it point the right way?")
                continue
            if size > TOL.usual_acceleration:
                usual = f"{size / _G:.3g} g is more than conveyors usually have"
                found.append(f"{text}{usual}: {doubt(wave.sensitivity)}")
            if pure and wave.harmonics > TOL.few_harmonics:
                share = f"harmonics have {100.0 * wave.harmonics:.0f} % of the fundamental"
                found.append(f"{text}{share}, but the computed trough moves as a pure sine")
            if wave.rest > TOL.much_rest:
                share = f"the residual has {100.0 * wave.rest:.0f} % of the fundamental"
                found.append(f"{text}{share}: noise, another machine, or a frequency that changes")
        return tuple(found)


class MeasuredDrive(NamedTuple):
    """Measured quantities of a scene's drive.

    Attributes
    ----------
    trough : Trough
        The motion of the trough.
    quantities : dict of str to Estimate
        Measured quantities, by the names of the scene's fields [SI].
    clock : Estimate
        Trough time at the clock's zero, in [0, period); at 0 the trough passes its middle upwards, on an
        ellipse forwards [s].
    warnings : tuple of str
        Reasons to doubt the measurement.
    """

    trough: Trough
    quantities: dict[str, Estimate]
    clock: Estimate
    warnings: tuple[str, ...]

    @property
    def moved(self) -> list[tuple[dict[str, float], dict[str, float]]]:
        """Fields of the scene that each error changes, one standard error to either side [SI]."""
        certain = (0.0, math.inf)
        return [
            ({name: value + error}, {name: value - error})
            for name, (value, error) in self.quantities.items()
            if error not in certain and not math.isnan(error)
        ]


def trough_of(record: Record, *, reverse: bool = False, down: bool = False) -> Trough | None:
    """Measure the trough's motion; return None for a record without any.

    Parameters
    ----------
    record : Record
        Record with motions of the trough; offsets, such as gravity, have no effect.
    reverse : bool
        Whether the axis along the trough points against the conveying direction.
    down : bool
        Whether to allow a line that leads down in the conveying direction, which is an ellipse with a phase
        of half a turn.

    Raises
    ------
    InputError
        If no wave stands out; if the record is too short or too coarse for it; or if the trough moves down
        along a line while it moves forwards, and ``down`` is false: one of the sensors is inverted.

    Notes
    -----
    The frequency minimises the misfit of all harmonics together over the whole record: its error is far below
    the inverse of the record's length. Amplitudes come from the regression of ``folding``.
    """
    if not record.trough:
        return None
    signals = trough_signals(record, reverse=reverse)
    found = drive_frequency(record, signals)
    frequency = Estimate(float(spelled(*found)), found.error)
    waves = {name: _wave(record, name, values, frequency.value) for name, values in signals.items()}
    trough = Trough(frequency, waves.get(_ALONG), waves.get(_NORMAL), float(np.ptp(record.time)))
    if not down:
        refuse_line_down(trough, reverse=reverse)
    return trough


def trough_signals(record: Record, *, reverse: bool) -> dict[str, Floats]:
    """Return the motions of the trough as recorded, positive in the conveying direction and upwards."""
    return {name: -x if reverse and name == _ALONG else x for name, x in record.trough.items()}


def to_accelerations(record: Record, frequency: float, count: int) -> dict[str, NDArray[np.complex128]]:
    """Return what turns the first harmonics of each motion of the trough into those of its acceleration."""
    rates = 2j * math.pi * frequency * np.arange(1, count + 1)
    return {name: np.asarray(rates**power) for name, power in record.trough_derivatives.items()}


def drive_frequency(record: Record, signals: Mapping[str, Floats]) -> Estimate:
    """Return the frequency at which motions of the trough repeat [Hz].

    Raises
    ------
    InputError
        If a signal does not vibrate, or no wave stands out.
    """
    repetition = Repetition(record.time, signals, dict.fromkeys(signals, 0))
    for name, alive in zip(signals, repetition.alive, strict=True):
        if not alive or float(np.abs(signals[name]).max()) < 1.0 / TOL.largest:
            dead = f"column {shown(record.headers[name])} for {name} does not vibrate"
            raise InputError(dead, hint="is its sensor connected?")
    frequency = repetition.fundamental()
    if frequency is None:
        columns = " and ".join(shown(record.headers[name]) for name in signals)
        hint = "was the trough running?"
        raise InputError(f"no wave stands out in column {columns}", hint=hint)
    return frequency


def refuse_line_down(trough: Trough, *, reverse: bool) -> None:
    """Raise InputError if the trough moves down along a line while it moves forwards."""
    if abs(trough.phase) > 0.5 * math.pi and not trough.on_an_ellipse:  # no drive angle is below 0
        why = "the axis along the trough points against the conveying direction"
        option = argument("reverse")
        hint = f"{f'leave out {option}, unless' if reverse else f'give {option}, if'} {why}"
        inverted = "the trough moves down while it moves forwards: one of its two sensors is inverted"
        raise InputError(inverted, hint=f"{hint}; a negative sensitivity turns one sensor alone")


def spelled(value: float, error: float) -> str:
    """Write a value to two digits below the first digit of its error."""
    digits = TOL.digits - math.floor(math.log10(error)) if error > 0.0 else sys.float_info.dig
    return f"{value:.{min(max(0, digits), sys.float_info.dig)}f}"


def _wave(record: Record, name: str, values: Floats, frequency: float) -> Wave:
    """Return the fundamental of an acceleration, by regression on all harmonics."""
    folded = fold(record.time, values, frequency, _TRENDS)
    cosines, sines = folded.coefficients[_TRENDS:].reshape(2, -1)
    factors = to_accelerations(record, frequency, len(sines))[name]
    powers = 0.5 * (cosines**2 + sines**2)
    fundamental = max(float(powers[0]), TOL.rounding**2 * float(np.mean(values**2)))
    variances = np.diagonal(folded.covariance)[_TRENDS:].reshape(2, -1).sum(axis=0)
    left = values - folded.fitted(record.time)
    over_first = np.abs(factors / factors[0]) ** 2
    harmonics = max(0.0, float(((powers - 0.5 * variances) * over_first)[1:].sum()))
    return Wave(
        record.headers[name],
        complex(complex(sines[0], cosines[0]) * factors[0]),
        math.sqrt(0.5 * float(variances[0])) * float(abs(factors[0])),
        math.sqrt(harmonics / fundamental),
        math.sqrt(float(np.mean(left**2)) / fundamental),
        record.sensitivities.get(name, ""),
    )


def _doubts(trough: Trough, found: dict[str, Estimate], normal_phase: float | None) -> list[str]:
    """Warn of an ellipse instead of a line, and of a phase more than 90 deg from the scene's."""
    doubts = []
    if normal_phase is None and trough.on_an_ellipse:
        said = []
        for name in ELLIPTICAL:
            quantity = QUANTITIES[name]
            text = spelled(*map(quantity.from_si, found[name]))
            said.append(f"{quantity.label} {text} {quantity.unit}")
        taken = f"{', '.join(said)}; this ellipse is taken"
        doubts.append(f"the trough moves on an ellipse, not on a line: {taken}")
    off = math.remainder(trough.phase - (normal_phase or 0.0), math.tau)
    if abs(off) > 0.5 * math.pi:
        than = "that along the trough" if normal_phase is None else "where the scene has it"
        lead = f"{abs(math.degrees(off)):.0f} deg {'ahead of' if off > 0.0 else 'behind'} {than}"
        why = "one of the two sensors may be inverted; a negative sensitivity turns it"
        doubts.append(f"the normal motion is {lead}: {why}")
    return doubts
