"""What accelerometers on the trough tell of its motion, and of a drive along a line."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.errors import InputError, shown
from vibro.records.folding import Estimate, fold
from vibro.records.frequencies import Repetition
from vibro.records.signals import MOST, SIGNAL_UNITS, doubt, option_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.records.reading import Record

    Floats = NDArray[np.float64]

__all__ = ["MeasuredDrive", "Trough", "Wave", "spelled", "trough_of"]

_ALONG, _NORMAL = "trough_along", "trough_normal"
_TRENDS: Final = 2  # an offset, gravity's part in it, and a slow drift of the sensor
_FEW: Final = 0.1  # of the fundamental's root mean square: harmonics below it are told, and no more
_MUCH: Final = 0.3  # of the same: what else may be left
_ROUND: Final = math.radians(2.0)  # phase between two channels that is theirs, and no ellipse
_LEAST_SINE: Final = 1e-3  # of the drive's direction: less of the motion cannot be scaled up to all of it
_DIGITS: Final = 2  # below the first one of the error
_ROUNDING: Final = 1e-24  # of the power of a signal: a wave counts as at least this
_G: Final = SIGNAL_UNITS["acceleration"]["g"]
_USUAL: Final = 50.0  # [m/s^2] of a wave: hardly a conveyor vibrates with more
_SIGMAS: Final = 3.0  # of a wave: with less there is none
_SHORTEST: Final = 1e-3  # of the longer axis of the motion: less of it has no phase that would matter


@dataclass(frozen=True)
class Wave:
    """The fundamental of an acceleration of the trough.

    Attributes
    ----------
    header : str
        The column that it is from.
    value : complex
        Of the sine with the drive's frequency; its angle is the phase at the clock's zero [m/s^2].
    error : float
        Standard error of its size, and of its phase times its size [m/s^2].
    harmonics, rest : float
        Root mean square of the harmonics, and of what else is left, over that of the fundamental.
    sensitivity : str
        Of a voltage, as typed; empty for an acceleration.
    """

    header: str
    value: complex
    error: float
    harmonics: float
    rest: float
    sensitivity: str


@dataclass(frozen=True)
class Trough:
    """The trough's motion as it was measured.

    Attributes
    ----------
    frequency : Estimate
        [Hz].
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
        """What was measured, one or two."""
        return tuple(wave for wave in (self.along, self.normal) if wave is not None)

    @property
    def phase(self) -> float:
        """Angle by which the normal motion runs ahead of that along the trough, in (-pi, pi] [rad].

        NaN without either of them, or where one is too small to have a phase that matters.
        """
        if self.along is None or self.normal is None:
            return math.nan
        sizes = abs(self.along.value), abs(self.normal.value)
        error = max(self.along.error, self.normal.error)
        if min(sizes) < max(_SHORTEST * max(sizes), _SIGMAS * error):
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
        """Whether the motion leaves a line by more than noise, and than two channels may differ."""
        return abs(math.remainder(self.phase, math.pi)) > max(_ROUND, _SIGMAS * self.phase_error)

    @property
    def drive_angle(self) -> Estimate | None:
        """Direction of the motion's longer axis above the trough's surface, with both accelerations [rad]."""
        if self.along is None or self.normal is None:
            return None
        x, y = self.along.value, self.normal.value
        angle = 0.5 * math.atan2(2.0 * (x * y.conjugate()).real, abs(x) ** 2 - abs(y) ** 2)
        if angle < 0.0:  # by noise alone (_check_direction): one of the two is next to nothing
            angle = 0.0 if abs(x) > abs(y) else 0.5 * math.pi
        across = math.hypot(self.along.error * math.sin(angle), self.normal.error * math.cos(angle))
        return Estimate(angle, across / math.hypot(abs(x), abs(y)))

    def drive(self, drive_angle: float | None = None) -> MeasuredDrive:
        """Tell what the scene needs to know of the motion.

        Parameters
        ----------
        drive_angle : float, optional
            Of the scene [rad], where one acceleration alone was measured.

        Raises
        ------
        InputError
            If the one acceleration is across the drive's line.
        """
        angle = self.drive_angle
        value, error = self._along_the_drive(angle.value if angle else drive_angle or 0.0)
        frequency, size = self.frequency, abs(value)
        rate = 2.0 * math.pi * frequency.value
        relative_error = frequency.error / frequency.value
        relative = math.hypot(error / size, 2.0 * relative_error)
        # The acceleration of A sin(w t) is opposed to it.
        shift = float(np.angle(-value)) / rate % (1.0 / frequency.value)
        return MeasuredDrive(
            self,
            Estimate(size / rate**2, size / rate**2 * relative),
            frequency,
            angle,
            # The frequency is known less well than the phase: at the ends of the record both errors count.
            Estimate(shift, math.hypot(error / size / rate, 0.5 * self.span * relative_error)),
        )

    def _along_the_drive(self, drive_angle: float) -> tuple[complex, float]:
        """Acceleration along the drive's line, and its standard error."""
        cosine, sine = math.cos(drive_angle), math.sin(drive_angle)
        if self.along is not None and self.normal is not None:
            x, y = self.along, self.normal
            return x.value * cosine + y.value * sine, math.hypot(x.error * cosine, y.error * sine)
        (wave,) = self.waves
        part, name, other = (cosine, _ALONG, _NORMAL) if self.along is not None else (sine, _NORMAL, _ALONG)
        if part < _LEAST_SINE:
            raise InputError(
                f"{option_of(name)} shows nothing of the motion at a drive angle of"
                f" {math.degrees(drive_angle):.6g} deg",
                hint=f"check the drive angle, or give {option_of(other)}",
            )
        return wave.value / part, wave.error / part

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons to doubt that each of the two motions is one sinusoid."""
        found = []
        for wave in self.waves:
            column = f"column {shown(wave.header)}"
            if abs(wave.value) < _SIGMAS * wave.error:
                found.append(
                    f"{column}: no wave of {self.frequency.value:.5g} Hz stands out: is the sensor connected,"
                    " and does it point the right way?"
                )
                continue
            if abs(wave.value) > _USUAL:
                found.append(
                    f"{column}: {abs(wave.value) / _G:.3g} g is more than conveyors usually have:"
                    f" {doubt(wave.sensitivity)}"
                )
            if wave.harmonics > _FEW:
                found.append(
                    f"{column}: harmonics have {100.0 * wave.harmonics:.0f} % of the fundamental: the trough"
                    " does not move as one sine, as the computed one does"
                )
            if wave.rest > _MUCH:
                found.append(
                    f"{column}: {100.0 * wave.rest:.0f} % of the fundamental is neither it nor its harmonics:"
                    " noise, another machine, or a frequency that changes"
                )
        return tuple(found)


class MeasuredDrive(NamedTuple):
    """What was measured of a drive along a line, for its scene.

    Attributes
    ----------
    trough : Trough
        From which it is.
    amplitude, frequency : Estimate
        Along the drive's line [m]; [Hz].
    drive_angle : Estimate or None
        [rad]; None where the scene has to give it.
    clock : Estimate
        Trough time at the clock's zero, in [0, period); at 0 the trough passes its middle upwards [s].
    """

    trough: Trough
    amplitude: Estimate
    frequency: Estimate
    drive_angle: Estimate | None
    clock: Estimate

    @property
    def quantities(self) -> dict[str, Estimate]:
        """What it gives of a scene, by the names of its fields [SI]."""
        found = {"amplitude": self.amplitude, "frequency": self.frequency}
        return found | ({"drive_angle": self.drive_angle} if self.drive_angle else {})

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons to doubt it."""
        return self.trough.warnings


def trough_of(record: Record, *, reverse: bool = False, down: bool = False) -> Trough | None:
    """Measure the trough's motion from its accelerations; None where a record has none of them.

    Parameters
    ----------
    record : Record
        Its accelerations of the trough count; an offset, such as gravity's, does not matter.
    reverse : bool
        Whether the axis along the trough points against the conveying direction.
    down : bool
        Whether the trough may move along a line that leads down in the conveying direction, as an ellipse
        does with a phase of half a turn.

    Raises
    ------
    InputError
        If no wave stands out; if the record is too short or too coarse for it; or if the trough moves down
        along a line while it moves forwards, and may not: then one of the sensors is inverted.

    Notes
    -----
    The frequency has the least misfit of all harmonics together, over the whole record, so that it is known
    to far less than the inverse of the record's length. Amplitudes come from the regression of ``folding``.
    """
    if not record.trough:
        return None
    signals = {
        name: -values if reverse and name == _ALONG else values for name, values in record.trough.items()
    }
    repetition = Repetition(record.time, signals, dict.fromkeys(signals, 0))
    for name, power in zip(signals, repetition.power, strict=True):
        if not power or float(np.abs(signals[name]).max()) < 1.0 / MOST:
            raise InputError(
                f"column {shown(record.headers[name])} for {option_of(name)} does not vibrate",
                hint="is its sensor connected?",
            )
    frequency = repetition.fundamental()
    if frequency is None:
        columns = " and ".join(shown(record.headers[name]) for name in signals)
        raise InputError(
            f"no wave stands out in column {columns}", hint="is it the acceleration of a trough that runs?"
        )
    frequency = Estimate(float(spelled(*frequency)), frequency.error)
    waves = {name: _wave(record, name, values, frequency.value) for name, values in signals.items()}
    trough = Trough(frequency, waves.get(_ALONG), waves.get(_NORMAL), float(np.ptp(record.time)))
    if not down:
        _check_direction(trough, reverse)
    return trough


def spelled(value: float, error: float) -> str:
    """Write a value without the digits that are far below its error."""
    digits = _DIGITS - math.floor(math.log10(error)) if error > 0.0 else sys.float_info.dig
    return f"{value:.{min(max(0, digits), sys.float_info.dig)}f}"


def _wave(record: Record, name: str, values: Floats, frequency: float) -> Wave:
    """Take the fundamental of an acceleration from its regression on all harmonics."""
    folded = fold(record.time, values, frequency, _TRENDS)
    count = (folded.coefficients.size - _TRENDS) // 2
    cosines, sines = folded.coefficients[_TRENDS:].reshape(2, count)
    powers = 0.5 * (cosines**2 + sines**2)
    fundamental = max(float(powers[0]), _ROUNDING * float(np.mean(values**2)))
    noise = 0.5 * np.diagonal(folded.covariance)[_TRENDS:].reshape(2, count).sum(axis=0)
    left = values - folded.fitted(record.time)
    first = (_TRENDS, _TRENDS + count)
    error = math.sqrt(0.5 * float(folded.covariance[first, first].sum()))
    return Wave(
        record.headers[name],
        complex(sines[0], cosines[0]),
        error,
        math.sqrt(max(0.0, float((powers - noise)[1:].sum())) / fundamental),
        math.sqrt(float(np.mean(left**2)) / fundamental),
        record.sensitivities.get(name, ""),
    )


def _check_direction(trough: Trough, reverse: bool) -> None:
    """Refuse a line that leads down in the conveying direction: no drive angle is below 0."""
    if abs(trough.phase) > 0.5 * math.pi and not trough.on_an_ellipse:
        raise InputError(
            "the trough moves down while it moves forwards: one of its two sensors is inverted",
            hint=f"{'leave out --reverse, unless' if reverse else '--reverse, if'} the axis along the trough"
            " points against the conveying direction; a negative sensitivity turns one sensor alone",
        )
