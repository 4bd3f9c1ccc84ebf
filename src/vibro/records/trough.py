"""The trough's periodic motion, measured by sensors on it, and the drive of a scene that follows from it.

Each record is regressed as it was recorded: a displacement by double integration would drift by many
amplitudes, and an acceleration by differences would be noise. Harmonics are those of the acceleration, which
the loads of a drive are: of a velocity or a displacement they are multiplied by i k w once or twice.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from scipy.special import fdtrc, fdtri

from vibro.core.codes import Regime, Status
from vibro.drives import Motion
from vibro.errors import InputError, argument, shown
from vibro.quantities import AMPLITUDES, DRIVES, ELLIPTICAL, LINEAR, MOST_HARMONICS, QUANTITIES
from vibro.reals import shielded
from vibro.records.alignment import Estimate, Repetition, below, harmonics, independent_share, regress
from vibro.records.reading import TOL, Record, doubt, read_record, read_sensitivities, rounded
from vibro.records.sensors import Mounting, Placement, place, place_one, read_sensor_errors
from vibro.records.steadiness import (
    STEADY_HINT,
    Change,
    Envelope,
    apparent,
    change_of,
    clock_text,
    course_of_frequency,
    envelope_of,
    folding_onto,
    gravity_notes,
    part_of,
    rate_of,
    room_of,
    scale_notes,
    steady_part,
)
from vibro.scene import Scene
from vibro.steady import solve
from vibro.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from os import PathLike

    from vibro.reals import Complexes, Floats

_ALONG, _NORMAL, _ACROSS = "trough_along", "trough_normal", "trough_across"
_EXACT: Final = Mounting()
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
            fields = {"along_harmonics": _pairs(x), "normal_harmonics": _pairs(y)}
        return {**fields, "frequency": self.frequency}

    def up_to(self, order: int) -> Motions:
        """Leave out the harmonics above an order, which become 0."""
        kept = np.arange(1, len(self.along) + 1) <= order
        kept = kept.reshape(-1, *([1] * self.frequency.ndim))
        return replace(self, along=self.along * kept, normal=self.normal * kept)


def _pairs(way: Complexes) -> list[tuple[Any, Any]] | tuple[()]:
    """Return modulus and phase of each harmonic; none of a way without motion."""
    return [(abs(z), np.angle(z)) for z in way] if way.any() else ()


class Sensor(NamedTuple):
    """One sensor on the trough.

    Attributes
    ----------
    header, sensitivity : str
        Header of its column; sensitivity of a voltage, as typed, empty without one.
    harmonics, rest : float
        Root mean square of the harmonics of the acceleration, and of the residual, over that of the
        fundamental.
    """

    header: str
    sensitivity: str
    harmonics: float
    rest: float


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
        Covariance of the noise in each harmonic over the channels, E[da conj(db)]. The covariance of the real
        parts, and that of the imaginary parts, is half of its real part [m^2/s^4].
    freedom : float
        Degrees of freedom of this covariance; random draws follow Student's t [1].
    p_values : array
        For every harmonic that was tested, the probability that noise alone is as large [1].
    significant : int
        Order of the last significant harmonic. H is smaller if a drive cannot have so many harmonics.
    drive_angle : float or None
        Angle of the drive's line, which gives the other direction with one sensor; None with more [rad].
    drive_angle_error : float
        Its standard error [rad].
    placement : Placement
        How the sensors are turned, and what their errors make of the accelerations.
    clock : float
        Time in the record at which the phase is 0 [s].
    span : float
        Length of the part of the record that was taken [s].
    rows : int
        Number of its rows.
    sensors : tuple of Sensor
        Header and noise of each channel.
    warnings : tuple of str
        Reasons to doubt the measurement.
    notes : tuple of str
        What else is to be known of it.
    start : float
        Beginning of the part that was taken, on the record's clock [s].

    Notes
    -----
    Errors of amplitudes, phases and the drive angle, and random draws, are those of noise and of the sensors.
    Those of the frequency, and which harmonics are significant, are of noise alone.
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
    drive_angle_error: float
    placement: Placement
    clock: float
    span: float
    rows: int
    sensors: tuple[Sensor, ...]
    warnings: tuple[str, ...]
    notes: tuple[str, ...] = ()
    start: float = 0.0

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
        return np.asarray(self.acceleration_errors / self._rates[:, None] ** 2)

    @property
    def acceleration_errors(self) -> Floats:
        """Standard errors of the amplitudes of the accelerations, shape (H, channels) [m/s^2]."""
        ahead = np.exp(-1j * np.angle(self.accelerations))
        return np.asarray(np.hypot(self.noise_errors, np.linalg.norm((self._effects * ahead).real, axis=0)))

    @property
    def noise_errors(self) -> Floats:
        """What noise alone contributes to them [m/s^2]."""
        return np.asarray(np.sqrt(0.5 * np.diagonal(self.covariance, axis1=1, axis2=2).real))

    @property
    def _effects(self) -> Complexes:
        """What one standard error of each kind of a sensor adds to them, (errors, H, channels) [m/s^2]."""
        return np.concatenate([np.empty((0, *self.accelerations.shape)), *self.placement.effects.values()])

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
        turned = (self._effects / self.accelerations).imag
        turned -= orders * turned[:, :1, first, None]
        variances += np.square(turned).sum(axis=0)
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
        """Draw random motions from the errors of noise and sensors together, as fields of a ``Scene``.

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
        off += np.einsum("jka,jn->kan", self._effects, random.standard_normal((len(self._effects), count)))
        turned = self.drive_angle_error * random.standard_normal(count)
        return self._motions(frequency, self.accelerations[..., None] + off, turned)

    # --- the first harmonic: a line, or an ellipse ------------------------------------------------------

    @property
    def is_short(self) -> bool:
        """Whether the record has too few cycles for harmonics: their errors are those of white noise."""
        return self.span * self.frequency < TOL.motion_cycles * (1.0 - TOL.about)

    @property
    def phase(self) -> float:
        """Phase by which the first harmonic normal to the trough leads that along it, in (-pi, pi] [rad].

        NaN unless both were measured, stand out of the noise, and the phase matters.
        """
        sizes, error = abs(self.accelerations[0]), float(self.noise_errors[0].max())
        # Of noise alone sizes^2 / 2 error^2 follows F(2, freedom).
        least = error * math.sqrt(2.0 * fdtri(2.0, self.freedom, 1.0 - TOL.by_chance))
        if sizes.size == 1 or sizes.min() < max(TOL.least_component * sizes.max(), least):
            return math.nan
        return float(np.angle(self.accelerations[0, 1] / self.accelerations[0, 0]))

    @property
    def on_an_ellipse(self) -> bool:
        """Whether the phase differs from a line's by more than noise and the delay of two channels."""
        if math.isnan(phase := self.phase):
            return False
        noise = TOL.likely_sigmas * float(self.phase_errors[0, 1])
        return abs(math.remainder(phase, math.pi)) > max(math.radians(TOL.channel_phase), noise)

    @property
    def line_angle(self) -> Estimate:
        """Angle of the longer axis above the trough's surface [rad]; with one sensor, the given one."""
        if self.drive_angle is not None:
            return Estimate(self.drive_angle, self.drive_angle_error)
        x, y = self.accelerations[0].tolist()
        angle = 0.5 * math.atan2(2.0 * (x * y.conjugate()).real, abs(x) ** 2 - abs(y) ** 2)
        if angle < 0.0:  # by noise, as ``_refuse_line_down`` refuses lines that lead down: one is next to 0
            angle = 0.0 if abs(x) > abs(y) else 0.5 * math.pi
        across = self._errors_along(angle + 0.5 * math.pi, x * math.cos(angle) + y * math.sin(angle))[0]
        return Estimate(angle, across / math.hypot(abs(x), abs(y)))

    def drive_on_line(self) -> MeasuredDrive:
        """Return the quantities of a drive along a line."""
        angle, first = self.line_angle, self.accelerations[0]
        cosine, sine = math.cos(angle.value), math.sin(angle.value)
        if first.size == 2:
            value = complex(first @ (cosine, sine))
            error, noise = self._errors_along(angle.value, value)
        else:
            part, other = (cosine, sine) if self.channels == (_ALONG,) else (sine, cosine)
            value, noise = complex(first[0]) / part, float(self.noise_errors[0, 0]) / part
            by_angle = abs(value) * other / part * angle.error
            error = math.hypot(float(self.acceleration_errors[0, 0]) / part, by_angle)
        found = {"amplitude": self._amplitude(value, error), "frequency": self._frequency}
        found |= {"drive_angle": angle} if first.size == 2 else {}
        return MeasuredDrive(self, found, self._clock(value, noise))

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
        sizes, errors = self.accelerations[0].tolist(), self.acceleration_errors[0].tolist()
        found = {
            f"{channel.removeprefix('trough_')}_amplitude": self._amplitude(size, error)
            for channel, size, error in zip(self.channels, sizes, errors, strict=True)
        }
        found["frequency"] = self._frequency
        if not math.isnan(self.phase):
            found["normal_phase"] = Estimate(self.phase, float(self.phase_errors[0, 1]))
        by_normal = self.channels == (_NORMAL,) or abs(sizes[0]) < TOL.likely_sigmas * errors[0]
        place, ahead = (-1, normal_phase or 0.0) if by_normal else (0, 0.0)
        clock = self._clock(sizes[place], float(self.noise_errors[0, place]), ahead)
        return MeasuredDrive(self, found, clock, _doubts(self, found, normal_phase))

    def drive_by_harmonics(self) -> MeasuredDrive:
        """Return the harmonics as quantities with standard errors."""
        motion, both = self.motion, len(self.channels) == 2
        own = motion.along if _ALONG in self.channels else motion.normal
        quantities = {"frequency": self._frequency}
        for i, (way, values) in enumerate((("along", motion.along), ("normal", motion.normal))):
            for k, z in enumerate(values):
                end = f"_{k + 1}" if k else ""
                # One sensor gives both motions, with the same relative errors but for that of the angle.
                channel, share = (i, 1.0) if both else (0, abs(z) / abs(own[k]))
                error = float(share * self.standard_errors[k, channel])
                if values is not own and self.drive_angle:
                    error = math.hypot(
                        error, 2.0 * abs(z) * self.drive_angle_error / math.sin(2.0 * self.drive_angle)
                    )
                size = Estimate(float(abs(z)), error)
                phase = Estimate(float(np.angle(z)), float(self.phase_errors[k, channel]))
                quantities |= {f"{way}_amplitude{end}": size, f"{way}_phase{end}": phase}
        return MeasuredDrive(self, quantities, self.drive_on_ellipse().clock)

    @property
    def impurities(self) -> list[str]:
        """Doubts that each direction moves as one sinusoid."""
        stands = abs(self.accelerations[0]) >= TOL.likely_sigmas * self.noise_errors[0]
        return [
            f"column {shown(sensor.header)}: harmonics have {100.0 * sensor.harmonics:.0f} % of the"
            " fundamental, but the computed trough moves as a pure sine"
            for sensor, has_wave in zip(self.sensors, stands.tolist(), strict=True)
            if has_wave and sensor.harmonics > TOL.few_harmonics
        ]

    @property
    def _frequency(self) -> Estimate:
        return Estimate(self.frequency, self.frequency_error)

    def _errors_along(self, angle: float, value: complex) -> tuple[float, float]:
        """Return the standard error of the first harmonic of two sensors in a direction, and that of noise.

        It is that of the part that has the phase of a value [m/s^2].
        """
        way = np.array([math.cos(angle), math.sin(angle)])
        noise = math.sqrt(max(0.5 * float(way @ self.covariance[0].real @ way), 0.0))
        effects = (self._effects[:, 0] @ way * np.exp(-1j * np.angle(value))).real
        return math.hypot(noise, *effects.tolist()), noise

    def _amplitude(self, value: complex, error: float) -> Estimate:
        """Return the amplitude of a motion from its acceleration and the error of that [m]."""
        size = Estimate(abs(value), error).scaled((math.tau * self.frequency) ** -2)
        by_frequency = 2.0 * size.value * self.frequency_error / self.frequency
        return Estimate(size.value, math.hypot(size.error, by_frequency))

    def _clock(self, value: complex, error: float, ahead: float = 0.0) -> Estimate:
        """Return the trough time at the clock's zero from an acceleration that leads by a phase [s]."""
        rate, period = math.tau * self.frequency, 1.0 / self.frequency
        # The acceleration of A sin(w t) has the opposite sign.
        shift = ((float(np.angle(-value)) - ahead) / rate - self.clock) % period
        # The error of the frequency adds to that of the phase at the ends of the record.
        late = 0.5 * self.span * self.frequency_error * period
        return Estimate(shift, math.hypot(error / abs(value) / rate, late))

    @property
    def moved_by_kind(self) -> dict[str, list[tuple[MeasuredMotion, MeasuredMotion]]]:
        """The motion one standard error to either side of it: of noise, and of each kind of a sensor's."""
        found = {"noise": self._sides(self._noise, self.frequency_error)}
        found |= {kind: self._sides(effects) for kind, effects in self.placement.effects.items()}
        if self.drive_angle_error:
            found["angle"] = self._sides(self._noise[:0], turned=self.drive_angle_error)
        return found

    @property
    def _noise(self) -> Complexes:
        """What one standard error of each independent noise adds to them, (errors, H, channels) [m/s^2]."""
        order, channels = self.accelerations.shape
        values, vectors = np.linalg.eigh(self.covariance)
        roots = np.sqrt(0.5 * np.maximum(values, 0.0))[:, None] * vectors
        noise = np.zeros((order, channels, order, channels), np.complex128)
        noise[range(order), :, range(order)] = roots.swapaxes(1, 2)
        return np.concatenate([noise, 1j * noise]).reshape(-1, order, channels)

    def _sides(
        self, offs: Complexes, late: float = 0.0, turned: float = 0.0
    ) -> list[tuple[MeasuredMotion, MeasuredMotion]]:
        """Move the accelerations, the frequency and the angle of the line to either side, each by itself."""

        def moved(side: float, off: Complexes | float, late: float, turned: float) -> MeasuredMotion:
            angle = None if self.drive_angle is None else self.drive_angle + side * turned
            found, frequency = self.accelerations + side * off, self.frequency + side * late
            return replace(self, accelerations=found, frequency=frequency, drive_angle=angle)

        steps: list[tuple[Complexes | float, float, float]] = [(off, 0.0, 0.0) for off in offs if off.any()]
        steps += [step for step in ((0.0, late, 0.0), (0.0, 0.0, turned)) if any(step)]
        return [(moved(1.0, *step), moved(-1.0, *step)) for step in steps]

    @property
    def _rates(self) -> Floats:
        return np.asarray(math.tau * self.frequency * np.arange(1, self.order + 1), np.float64)

    def _motions(self, frequency: Floats, accelerations: Complexes, turned: Floats | float = 0.0) -> Motions:
        """Return motions by their accelerations, (H, channels, n), with the clock set to each.

        The line of one sensor is turned upwards by an angle [rad].
        """
        first = _reference(self.accelerations, self.covariance)
        orders = np.arange(1, self.order + 1)[:, None, None]
        # The acceleration of X sin(k w t + xi) has the opposite sign.
        motion = -accelerations / (math.tau * orders * frequency) ** 2
        motion = motion * np.exp(-1j * orders * np.angle(motion[0, first]))
        motion[0, first] = abs(motion[0, first])
        motion = motion.reshape(self.order, len(self.channels), *frequency.shape)
        if self.drive_angle is None:
            return Motions(frequency, motion[:, 0], motion[:, 1])
        (one,), slope = motion.transpose(1, 0, *range(2, motion.ndim)), np.tan(self.drive_angle + turned)
        along, normal = (one, slope * one) if _ALONG in self.channels else (one / slope, one)
        return Motions(frequency, along, normal)


class MeasuredDrive(NamedTuple):
    """Measured quantities of a scene's drive.

    Attributes
    ----------
    motion : MeasuredMotion
        The motion of the trough.
    quantities : dict of str to Estimate
        Measured quantities, by the names of the scene's fields [SI].
    clock : Estimate
        Trough time at the clock's zero, in [0, period); at 0 the trough passes its middle upwards, on an
        ellipse forwards [s].
    warnings : sequence of str
        Reasons to doubt that it is the drive of the scene.
    """

    motion: MeasuredMotion
    quantities: dict[str, Estimate]
    clock: Estimate
    warnings: Sequence[str] = ()

    def fields_of(self, motion: MeasuredMotion) -> dict[str, Any]:
        """Return fields of the kind of this drive for another motion."""
        if "along_phase" in self.quantities:
            return {n: float(x) if isinstance(x, np.ndarray) else x for n, x in motion.drive().items()}
        is_line = "amplitude" in self.quantities
        found = (motion.drive_on_line() if is_line else motion.drive_on_ellipse()).quantities
        fields = {name: found[name].value for name in self.quantities if name in found}
        if is_line and motion.drive_angle_error:
            fields["drive_angle"] = max(motion.line_angle.value, 0.0)
        return fields


def spelled(value: float, error: float) -> str:
    """Write a value to two digits below the first digit of its error."""
    digits = TOL.digits - math.floor(math.log10(error)) if error > 0.0 else sys.float_info.dig
    return f"{value:.{min(max(0, digits), sys.float_info.dig)}f}"


def _doubts(motion: MeasuredMotion, found: dict[str, Estimate], normal_phase: float | None) -> list[str]:
    """Warn of an ellipse instead of a line, and of a phase more than 90 deg from the scene's."""
    doubts = []
    if normal_phase is None and motion.on_an_ellipse:
        sizes = []
        for name in ELLIPTICAL:
            quantity = QUANTITIES[name]
            text = spelled(*map(quantity.from_si, found[name]))
            sizes.append(f"{quantity.label} {text} {quantity.unit}")
        taken = f"{', '.join(sizes)}; this ellipse is taken"
        doubts.append(f"the trough moves on an ellipse, not on a line: {taken}")
    off = math.remainder(motion.phase - (normal_phase or 0.0), math.tau)
    if abs(off) > 0.5 * math.pi:
        than = "that along the trough" if normal_phase is None else "where the scene has it"
        lead = f"{abs(math.degrees(off)):.0f} deg {'ahead of' if off > 0.0 else 'behind'} {than}"
        why = "one of the two sensors may be inverted; a negative sensitivity turns it"
        doubts.append(f"the normal motion is {lead}: {why}")
    return doubts


def _refuse_line_down(motion: MeasuredMotion, *, reverse: bool) -> None:
    """Raise InputError if the trough moves down along a line while it moves forwards."""
    leads_down = abs(motion.phase) > 0.5 * math.pi and not motion.on_an_ellipse  # no drive angle is below 0
    if (
        leads_down
        and (abs(motion.accelerations[0]) > TOL.likely_sigmas * motion.acceleration_errors[0]).all()
    ):
        why = "the axis along the trough points against the conveying direction"
        option = argument("reverse")
        hint = f"{f'leave out {option}, unless' if reverse else f'give {option}, if'} {why}"
        down = "the trough moves down while it moves forwards"
        if motion.placement.by_gravity:
            raise InputError(f"{down}, by gravity in the record", hint=hint)
        inverted = f"{down}: one of its two sensors is inverted"
        raise InputError(inverted, hint=f"{hint}; a negative sensitivity turns one sensor alone")


@shielded
def measured_motion(
    path: str | PathLike[str],
    *,
    trough_along: str | None = None,
    trough_normal: str | None = None,
    trough_across: str | None = None,
    time: str | None = None,
    rate: float | str | None = None,
    sensitivity: str | Sequence[str] = (),
    reverse: bool = False,
    drive_angle: float | None = None,
    turned: float | None = None,
    trough_angle: float = 0.0,
    sensor: str = "",
    frequency: float | None = None,
    start: float | None = None,
    end: float | None = None,
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
    trough_across : str, optional
        Header of the third axis of a sensor, by which its turn about the normal is found.
    time : str, optional
        Header of the time column; by default the only column with a unit of time.
    rate : float or str, optional
        Sampling rate, in place of a column of time: in Hz, or with its unit.
    sensitivity : str or sequence of str
        Sensitivities of voltages: ``"100mV/g"`` for all columns, or ``"trough-along=101mV/g"`` for one.
    reverse : bool
        Whether the axis of the sensor along the trough points against the conveying direction.
    drive_angle : float, optional
        With one sensor, the angle of the line along which the trough moves; 0 if it moves along itself [rad].
    turned : float, optional
        Angle of the sensors' axis along the trough above its surface [rad]. By default gravity in the record
        gives it; without that it is 0.
    trough_angle : float
        Inclination of the trough, by which gravity is off its normal [rad].
    sensor : str
        Standard errors of the sensors, such as ``"tilt=0.2deg,gain=1%,cross=1%,lowpass=100Hz"``; those that
        are not named are those of cheap sensors.
    frequency : float, optional
        About the drive's frequency, within a tenth. It may be above half the sampling rate [Hz].
    start, end : float, optional
        Part of the record that is taken, on its own clock; by default all of it, or what is steady [s].

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
    F-test at the level of 1 in 1000. The errors of amplitudes, phases and the drive angle hold noise and the
    errors of sensors: of 300 synthetic records with such sensors 95 % of the results lie within 1.96 standard
    errors (tests/records/test_trough_sensors.py).

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
    given = {_ALONG: trough_along, _NORMAL: trough_normal, _ACROSS: trough_across, "time": time}
    columns = {name: text for name, text in given.items() if text is not None}
    texts = [sensitivity] if isinstance(sensitivity, str) else sensitivity
    record = read_record(Path(path), columns, read_sensitivities(texts), body=False, rate=rate)
    mounting = Mounting(read_sensor_errors(sensor), turned, trough_angle)
    return motion_of(
        record, mounting, reverse=reverse, drive_angle=drive_angle, stated=frequency, start=start, end=end
    )


@shielded
def trough_motion(path: str | PathLike[str], **columns: Any) -> Motion:
    """Return the motion that sensors on a trough have measured, as a sum of harmonics.

    ``vibro.measured_motion`` returns the frequency and the standard errors too.

    Parameters
    ----------
    path : str or path
        File of the record.
    **columns
        Other arguments of ``vibro.measured_motion``.

    Raises
    ------
    FileError, InputError
        As for ``vibro.measured_motion``.

    Examples
    --------
    >>> import vibro
    >>> motion = vibro.trough_motion(
    ...     "examples/data/nut_trough_mv.csv", trough_along="Trog längs",
    ...     trough_normal="Trog normal", sensitivity="100mV/g")
    >>> print(f"{1e3 * float(motion.along[0][0]):.2f} mm along")
    0.96 mm along
    """
    measured = measured_motion(path, **columns).motion
    return Motion.harmonics(_pairs(measured.along) or None, _pairs(measured.normal) or None)


def motion_of(
    record: Record,
    mounting: Mounting = _EXACT,
    *,
    reverse: bool = False,
    drive_angle: float | None = None,
    down: bool = False,
    short: bool = False,
    stated: float | None = None,
    start: float | None = None,
    end: float | None = None,
) -> MeasuredMotion:
    """Measure the trough's motion from a record of it.

    Parameters
    ----------
    record, reverse, drive_angle, start, end
        As for ``measured_motion``.
    mounting : Mounting
        How the sensors are mounted; by default exactly as they are named.
    stated : float, optional
        Its ``frequency``.
    down : bool
        Whether to allow a line that leads down in the conveying direction, which is an ellipse with a phase
        of half a turn.
    short : bool
        Whether a record of fewer than six cycles gives its first harmonic, with the errors of white noise;
        else it is refused.

    Raises
    ------
    InputError
        As for ``measured_motion``.
    """
    record = part_of(record, start, end)
    _check_sensors(record, drive_angle, mounting)
    measure = partial(
        _motion_in,
        mounting=mounting,
        stated=stated,
        reverse=reverse,
        drive_angle=drive_angle,
        down=down,
        short=short,
    )
    motion, envelope, change = measure(record)
    if change and change.is_large:
        part = steady_part(envelope)
        if part is None:
            raise InputError(_course_of(record, alone=False) or change.text, hint=STEADY_HINT)
        motion, _, left = measure(part_of(record, *part), is_part=True)
        if left and left.is_large:
            raise InputError(change.text, hint=STEADY_HINT)
        ends = f"from {clock_text(part[0])} to {clock_text(part[1])} s"
        text = f"{change.text}: the steady part {ends} is taken; --from and --to choose another one"
        motion = replace(motion, warnings=(text, *motion.warnings))
    return replace(motion, warnings=(*motion.warnings, *_clipped(record)))


def _motion_in(
    record: Record,
    *,
    mounting: Mounting,
    stated: float | None,
    reverse: bool,
    drive_angle: float | None,
    down: bool,
    short: bool,
    is_part: bool = False,
) -> tuple[MeasuredMotion, Envelope, Change | None]:
    """Measure the motion in a record, and how it changes if that is beyond noise."""
    signals = {name: -x if reverse and name == _ALONG else x for name, x in record.trough.items()}
    span = float(np.ptp(record.time))
    frequency = _frequency(record, signals, stated)
    rate = rate_of(record.time)
    _check_room(frequency, rate, span, TOL.least_cycles if short else TOL.motion_cycles)
    middle = 0.5 * float(record.time[0] + record.time[-1])
    time, values = record.time - middle, np.stack(list(signals.values()), axis=1)
    count = max(1, min(TOL.motion_harmonics, int(TOL.of_sampling * (time.size - 1) / span / frequency)))

    is_short = span * frequency < TOL.motion_cycles * (1.0 - TOL.about)
    frequency, significant, noise, kept, error = _fitted(time, values, frequency, count, is_short=is_short)
    # So many frequencies next to the stated one may look like a wave by chance.
    tried = 1.0 if stated is None else max(1.0, 2.0 * TOL.near_stated * stated * span)
    if stated is not None and noise.p_values[0] > TOL.by_chance / tried:
        raise _no_wave(record, stated)

    # (i k w)^power turns a harmonic of a displacement or a velocity into one of the acceleration.
    rates = np.asarray(math.tau * frequency * np.arange(1, significant + 1), np.float64)
    powers = np.array([*record.trough_derivatives.values()])
    factors = (1j * rates[:, None]) ** powers / mounting.errors.response(rates[:, None] / math.tau)
    sizes, order = noise.sizes[:significant] * factors, kept.count
    seen = abs(sizes[0]).tolist()
    level = np.where(powers == 0, kept.level, np.nan)
    notes = [] if [*signals] == [_ALONG] else gravity_notes(record, level, seen)
    if sizes.shape[1] == 1:
        other = math.tan(drive_angle or 0.0)
        is_along = _ALONG in signals
        placement = place_one(
            sizes[:order], other if is_along else 1.0 / other, 1.0 if is_along else -1.0, mounting
        )
    else:
        leads = 0 if _ALONG in signals else -1 if reverse else 1
        headers = [record.headers[name] for name in signals]
        placement = place(sizes[:order], level, rates[:order], mounting, headers, leads)
    axes = placement.axes
    sizes, spare = sizes @ axes.T, sizes.shape[1] - len(axes)
    powers = 0.5 * abs(sizes) ** 2
    own = np.where(powers[0] > 0.0, powers[0], 1.0)
    rest = np.sqrt(np.square(kept.left * abs(factors[0]) @ axes.T).mean(axis=0) / own)
    sizes, factors = sizes[:order], factors[:order]
    covariance = axes @ (noise.covariance[:order] * factors[:, :, None] * factors[:, None, :].conj()) @ axes.T

    envelope = envelope_of(time, kept.left, kept.sizes[0], kept.weights, frequency)
    envelope = envelope._replace(start=float(record.time[0]))
    line = 1.0 if drive_angle is None else _line_of(record, drive_angle)
    change = None
    if not is_short and (is_part or envelope.p_value < TOL.by_chance):
        along = float(np.linalg.norm(sizes[0])) / line / (math.tau * frequency) ** 2
        change = change_of(envelope, along, is_part=is_part)
        # amplitude and phase of all channels together
        covariance = covariance + 2.0 * change.amplitude**2 * sizes[:, :, None] * sizes[:, None, :].conj()
        error = math.hypot(error, change.frequency)

    phase = float(np.angle(-sizes[0, _reference(sizes, covariance)]))
    clock = np.exp(-1j * np.arange(1, order + 1) * phase)[:, None]
    columns = [(record.headers[name], record.sensitivities.get(name, "")) for name in signals]
    columns = columns if not spare else [(", ".join(header for header, _ in columns), "")] * len(axes)
    numbers = zip(np.sqrt(powers[1:].sum(axis=0) / own).tolist(), rest.tolist(), strict=True)
    motion = MeasuredMotion(
        frequency=frequency,
        frequency_error=error,
        channels=(_ALONG, _NORMAL) if len(axes) == 2 else tuple(signals),
        accelerations=sizes * clock,
        covariance=covariance,
        freedom=noise.freedom + 2.0 * spare,
        p_values=noise.p_values,
        significant=significant,
        drive_angle=drive_angle,
        drive_angle_error=0.0 if drive_angle is None else mounting.errors.angle,
        placement=placement._replace(effects={kind: x * clock for kind, x in placement.effects.items()}),
        clock=middle - phase / (math.tau * frequency),
        span=span,
        rows=time.size,
        sensors=tuple(Sensor(*column, *pair) for column, pair in zip(columns, numbers, strict=True)),
        warnings=(),
        start=float(record.time[0]),
    )
    if change and change.is_large:
        return motion, envelope, change
    same = _same_drives(motion, rate) if stated is None else ""
    cause = f"{same}: give the frequency of the drive, {argument('frequency', '50')}; or " if same else ""
    for channel, size in zip(signals, seen, strict=True):
        believable = frequency if rate >= TOL.slowest_rate else apparent(frequency, rate)
        notes += scale_notes(record, channel, size, believable, cause)
    if count == 1:
        notes.append(f"{rate / frequency:.3g} samples a cycle show the first harmonic alone")
    if not down:
        _refuse_line_down(motion, reverse=reverse)
    warnings = [f"{change.text}: errors include it"] if change and change.is_seen else []
    if same:  # hardly any drive is so slow
        (warnings if frequency < TOL.slow_drive else notes).append(
            f"{same}: give the frequency of the drive (-f)"
        )
    warnings += [
        *placement.warnings,
        *_sampling_doubts(motion, rate),
        *_sensor_doubts(motion),
        *_left_out(motion),
    ]
    return replace(motion, warnings=tuple(warnings), notes=tuple(notes)), envelope, change


def _fitted(
    time: Floats, values: Floats, frequency: float, count: int, *, is_short: bool
) -> tuple[float, int, _Noise, _Regression, float]:
    """Return the best frequency, the last significant harmonic, the noise, the fit and the frequency's error.

    The fit has the harmonics that a drive takes, and of a short record the first alone.
    """
    frequency = _refined(time, values, frequency, count)
    p_values = _noise_of(_Regression(time, values, frequency, count)).p_values
    standing = np.flatnonzero(p_values < TOL.by_chance)
    significant = int(standing[-1]) + 1 if standing.size else 1
    # Noise in a harmonic that the motion lacks would shift the frequency, the more the higher it is.
    frequency = _refined(time, values, frequency, significant)
    noise = _noise_of(_Regression(time, values, frequency, count))
    kept = _Regression(time, values, frequency, 1 if is_short else min(significant, MOST_HARMONICS))
    return frequency, significant, noise, kept, _frequency_error(kept, noise)


def _check_room(frequency: float, rate: float, span: float, least: float) -> None:
    """Refuse a record of too few cycles, or sampled at nearly a multiple of half the frequency."""
    cycles, room = span * frequency, span * room_of(frequency, rate)
    if cycles < least * (1.0 - TOL.about):
        few = f"the record has {below(cycles)} cycles of {frequency:.6g} Hz: at least {least:g} are needed"
        raise InputError(few, hint="record longer, or check the frequency and the unit of the time")
    if room < least * (1.0 - TOL.about):
        raise _too_near(frequency, rate)


def _too_near(frequency: float, rate: float) -> InputError:
    """Say that samples hold too little of a wave."""
    slow = room_of(frequency, rate) == apparent(frequency, rate)
    beside = f"{rate:.5g} samples a second" if slow else f"half of {rate:.5g} samples a second"
    near = f"{frequency:.5g} Hz is too near to a multiple of {beside}"
    return InputError(f"{near}: the amplitude cannot be told", hint="sample at another rate, or longer")


def _no_wave(record: Record, stated: float | None) -> InputError:
    """Say why no wave stands out."""
    rate = rate_of(record.time)
    if stated is not None and room_of(stated, rate) * float(np.ptp(record.time)) < TOL.least_cycles:
        return _too_near(stated, rate)
    if changes := _course_of(record, alone=True):
        return InputError(changes, hint=STEADY_HINT)
    columns = " and ".join(shown(record.headers[name]) for name in record.trough)
    at = "" if stated is None else f" of {stated:.6g} Hz"
    hint = "was the trough running?"
    if stated is None and rate < TOL.hides_drives:
        must = f"The frequency of a drive above {rate / TOL.coarsest:.4g} Hz must be given"
        hint += f" {must}: {argument('frequency', '50')}"
    return InputError(f"no wave{at} stands out in column {columns}", hint=hint)


def _line_of(record: Record, drive_angle: float) -> float:
    """Return what one sensor sees of a motion along a line."""
    return math.cos(drive_angle) if _ALONG in record.trough else math.sin(drive_angle)


def _sampling_doubts(motion: MeasuredMotion, rate: float) -> list[str]:
    """Warn of a frequency that samples show at another one, and of a harmonic that they show at it."""
    frequency, shown_at = motion.frequency, apparent(motion.frequency, rate)
    found = []
    if 2.0 * frequency > rate:
        text = f"{frequency:.6g} Hz is above half of {rate:.5g} samples a second"
        text += f", which show it at {shown_at:.4g} Hz (aliasing)"
        found.append(f"{text}: right only if the sensor has no filter against this")
    for k in (2, 3, 4):
        if k * frequency > 0.5 * rate and abs(apparent(k * frequency, rate) - shown_at) * motion.span < 2.0:
            text = f"{rate:.5g} samples a second show harmonic {k} as the first one"
            return [*found, f"{text}, which is wrong by as much: sample at another rate"]
    return found


def _same_drives(motion: MeasuredMotion, rate: float) -> str:
    """Name drives above half a low sampling rate that would look the same; empty if there are none."""
    is_slow = TOL.slowest_rate <= rate < TOL.hides_drives
    others = folding_onto(motion.frequency, rate, TOL.highest_drive) if is_slow else []
    if not others:
        return ""
    size = 1e3 * float(np.linalg.norm([motion.along[0], motion.normal[0]])) * motion.frequency**2
    same = [f"{x:.4g} Hz ({size / x**2:.2g} mm)" for x in others[: TOL.drives_named]]
    more = " and others" if len(others) > len(same) else ""
    return f"at {rate:.5g} samples a second drives of {', '.join(same)}{more} would look the same"


def _sensor_doubts(motion: MeasuredMotion) -> list[str]:
    """Doubt sensors that show no wave, far too large a one, or much besides its harmonics."""
    found = []
    sizes, errors = abs(motion.accelerations[0]).tolist(), motion.noise_errors[0].tolist()
    for sensor, size, error in zip(motion.sensors, sizes, errors, strict=True):
        text = f"column {shown(sensor.header)}: "
        if size < TOL.likely_sigmas * error:
            text += f"no wave of {motion.frequency:.5g} Hz stands out: is the sensor connected,"
            found.append(f"{text} and does it point the right way?")
            continue
        if size > TOL.usual_acceleration:
            usual = f"{size / STANDARD_GRAVITY:.3g} g is more than conveyors usually have"
            found.append(f"{text}{usual}: {doubt(sensor.sensitivity)}")
        if sensor.rest > TOL.much_rest:
            share = f"the residual has {100.0 * sensor.rest:.0f} % of the fundamental"
            found.append(f"{text}{share}: noise, another machine, or a frequency that changes")
    return found


def _left_out(motion: MeasuredMotion) -> list[str]:
    """Warn of more harmonics than a drive can have."""
    beyond = 0 if motion.is_short else motion.significant - motion.order
    many = f"the motion has {motion.significant} harmonics, a drive has at most {motion.order}"
    return [f"{many}: {beyond} are left out"] if beyond else []


def _check_sensors(record: Record, drive_angle: float | None, mounting: Mounting) -> None:
    """Refuse one sensor without a drive angle, and more with one."""
    if _ACROSS in record.trough and not {_ALONG, _NORMAL} <= record.trough.keys():
        lacks = f"{argument(_ACROSS)} is the third axis of a sensor"
        raise InputError(lacks, hint=f"name {argument(_ALONG)} and {argument(_NORMAL)} too")
    if len(record.trough) > 1:
        if drive_angle is not None:
            both = f"{len(record.trough)} columns measure the drive angle, which is given too"
            raise InputError(both, hint="leave out the drive angle, or one of the sensors")
        return
    (name,) = record.trough
    other, missing, line = _NORMAL, "normal to the trough", math.cos  # the share of the motion that it shows
    if name == _NORMAL:
        other, missing, line = _ALONG, "along it", math.sin
    if drive_angle is None:
        unknown = f"one sensor alone does not measure the motion {missing}"
        hint = f"name {argument(other)} too, or give the drive angle, if the trough moves along a line"
        raise InputError(unknown, hint=hint)
    quantity = QUANTITIES["drive_angle"]
    if not (math.isfinite(drive_angle) and quantity.allows(drive_angle)):
        given = f"drive angle = {quantity.text(quantity.from_si(drive_angle))}"
        raise InputError(f"{given}: must be {quantity.allowed.text(quantity.unit)}")
    errors = mounting.errors
    least = max(TOL.least_component, TOL.likely_sigmas * math.hypot(errors.angle, errors.tilt, errors.cross))
    if min(line(drive_angle), line(drive_angle - (mounting.turned or 0.0))) < least:
        at = f"at a drive angle of {math.degrees(drive_angle):.6g} deg"
        hint = f"name {argument(other)}, or check the drive angle"
        raise InputError(f"{argument(name)} cannot measure the motion {at}", hint=hint)


def _frequency(record: Record, signals: Mapping[str, Floats], stated: float | None) -> float:
    """Return the frequency at which the motions repeat, to well within 1/T, T the record's length [Hz].

    It is the one of the wave next to the stated frequency, if one is given.

    The search takes long in many rows: it begins in the middle of a long record, whose part then grows.

    Raises
    ------
    InputError
        If a signal does not vibrate, no wave stands out, or the stated frequency is another one's.
    """
    size, rows = record.time.size, min(record.time.size, TOL.frequency_rows)
    part = slice((size - rows) // 2, (size - rows) // 2 + rows)
    middle = {name: values[part] for name, values in signals.items()}
    repetition = Repetition(record.time[part], middle, dict.fromkeys(signals, 0))
    for name, alive in zip(signals, repetition.alive, strict=True):
        if name not in (_ALONG, _NORMAL) and repetition.alive.any():
            continue  # a trough does not move across itself
        if not alive or float(np.abs(middle[name]).max()) < 1.0 / TOL.largest:
            dead = f"column {shown(record.headers[name])} for {name} does not vibrate"
            raise InputError(dead, hint="is its sensor connected?")
    frequency = _found(repetition, stated)
    if frequency is None:
        raise _no_wave(record, stated)
    while (rows := TOL.frequency_growth * rows) < size:
        part = slice((size - rows) // 2, (size - rows) // 2 + rows)
        time = record.time[part] - 0.5 * float(record.time[part][0] + record.time[part][-1])
        values = np.stack([x[part] for x in signals.values()], axis=1)
        frequency = _refined(time, values, frequency, 1)
    return frequency


def _course_of(record: Record, *, alone: bool) -> str:
    """Say what ``course_of_frequency`` does of a record."""
    return course_of_frequency(record.time, np.stack(list(record.trough.values()), axis=1), alone=alone)


def _found(repetition: Repetition, stated: float | None) -> float | None:
    """Return the frequency of the drive, near the stated one if there is one; None if no wave stands out.

    Raises
    ------
    InputError
        If the motion repeats at another frequency than the stated one.
    """
    near = None if stated is None else repetition.near(stated)
    if stated is not None and near is not None and 2.0 * near > repetition.rate:
        return near
    found = repetition.fundamental()
    if stated is None or found is None or abs(found.value - stated) <= TOL.near_stated * stated:
        return found.value if found and near is None else near
    other = found.value
    # A larger wave of another machine does not matter, but half or a third of the frequency does.
    if near is not None and abs(near / other - round(near / other)) > TOL.drifted:
        return near
    text = f"the trough moves at {other:.5g} Hz, the drive is given as {stated:.6g} Hz"
    why = "if it is right"
    if abs(other / stated - 2.0) < TOL.near_stated:
        why = "magnets pull twice in a period of the mains"
    raise InputError(
        text, hint=f"{why}, give {argument('frequency', f'{other:.5g}')}, or leave the frequency out"
    )


def _reference(sizes: Complexes, covariance: Complexes) -> int:
    """Return the channel whose first harmonic has the phase 0: the first, unless it does not stand out."""
    error = math.sqrt(0.5 * float(covariance[0, 0, 0].real))
    return 0 if abs(sizes[0, 0]) >= TOL.likely_sigmas * error or sizes.shape[1] == 1 else 1


# --- regression -----------------------------------------------------------------------------------------


class _Regression:
    """Least squares of all channels, (N, channels), on a trend and the first harmonics of a frequency.

    Attributes
    ----------
    sizes : complex array, shape (count, channels)
        Amplitude of the sine of each harmonic; its angle is the phase at time 0.
    level : array, shape (channels,)
        Constant part in the middle of the record.
    left : array, shape (N, channels)
        Residuals.
    weights : array, shape (channels,)
        Inverse of their variance, which is at least that of rounding.
    """

    def __init__(self, time: Floats, values: Floats, frequency: float, count: int) -> None:
        trend = np.vander(time / float(time[-1]), _TRENDS, increasing=True)
        self.time, self.values, self.frequency, self.count = time, values, frequency, count
        self.basis = np.hstack([trend, harmonics(time, frequency, count)])
        # In long records the products of the normal equations take most of the time: once for all.
        coefficients, self.inverse = regress(self.basis, values)
        self.level, self.left = coefficients[0], values - self.basis @ coefficients
        cosines, sines = coefficients[_TRENDS:].reshape(2, count, -1)
        self.sizes = sines + 1j * cosines
        variances = np.square(self.left).mean(axis=0) + TOL.rounding * np.square(values).mean(axis=0)
        self.weights = 1.0 / variances

    def step(self) -> float:
        """Return the step of Gauss and Newton's method to the best frequency [Hz]."""
        rates = math.tau * np.arange(1, self.count + 1)[:, None]  # of phases, over the frequency
        sines, cosines = self.sizes.real * rates, self.sizes.imag * rates
        slope = self.basis[:, _TRENDS:] @ np.concatenate([sines, -cosines]) * self.time[:, None]
        slope -= self.basis @ regress(self.basis, slope, self.inverse)[0]
        return float((slope * self.left).sum(axis=0) @ self.weights / ((slope**2).sum(axis=0) @ self.weights))


def _refined(time: Floats, values: Floats, frequency: float, count: int) -> float:
    """Return the frequency of least squares of all channels together, by Gauss and Newton's method.

    Each channel weighs by the inverse of its residual's variance.
    """
    step_limit = TOL.frequency_step / float(np.ptp(time))
    for _ in range(TOL.frequency_rounds):
        step = _Regression(time, values, frequency, count).step()
        frequency += min(max(step, -step_limit), step_limit)
        if abs(step) < TOL.frequency_close * step_limit:
            break
    return frequency


class _Noise(NamedTuple):
    """Harmonics, (K, channels), their error covariance and its degrees of freedom.

    ``p_values`` are the probabilities that noise alone is as large.
    """

    sizes: Complexes
    covariance: Complexes
    freedom: float
    p_values: Floats


def _noise_of(regression: _Regression) -> _Noise:
    """Return the noise in each harmonic: from the spectrum beside it, in a short record as of white noise."""
    values, sizes = regression.values, regression.sizes
    channels = sizes.shape[1]
    covariance, bins = _spectral(regression)
    # Data may be exact: add their rounding.
    rounding = TOL.rounding * np.square(values).mean(axis=0)
    # of an axis that nothing moves along, that of the others
    covariance = covariance + np.diag(np.where(rounding > 0.0, rounding, rounding.max()) / len(values))
    # Hotelling's test: T^2 (bins - channels + 1) / (bins channels) follows F.
    statistic = np.einsum("ka,kab,kb->k", sizes.conj(), np.linalg.inv(covariance), sizes).real
    freedom = bins - channels + 1
    p_values = fdtrc(2.0 * channels, 2.0 * freedom, statistic * freedom / (bins * channels))
    return _Noise(sizes, covariance, 2.0 * freedom, np.asarray(p_values))


def _spectral(regression: _Regression) -> tuple[Complexes, float]:
    """Return the covariance of each harmonic by the spectrum of the residual beside it, and its bins.

    The bins lie at whole multiples of 1/T from the harmonic, where they are independent of it and of each
    other. They see noise through the same window as the regression does: no taper is wanted. Rows that are
    left out, and times that are rounded, do no harm where each row takes the nearest place of an even clock.
    """
    time, left, frequency = regression.time, regression.left, regression.frequency
    rate = rate_of(time)
    step = 1.0 / rate
    places = np.rint((time - time[0]) / step).astype(np.intp)
    clock = np.zeros((int(places[-1]) + 1, left.shape[1]), np.complex128)
    each = int(TOL.band * room_of(frequency, rate) * len(clock) * step)
    if each < TOL.least_bins:
        return _white(regression)
    found = np.empty((regression.count, left.shape[1], left.shape[1]), np.complex128)
    for k in range(1, regression.count + 1):
        clock[:] = 0.0
        np.add.at(clock, places, left * np.exp(-1j * math.tau * k * frequency * time)[:, None])
        waves = np.fft.fft(clock, axis=0)
        beside = np.concatenate([waves[1 : each + 1], waves[-each:]])
        found[k - 1] = 4.0 / time.size**2 * (beside.T @ beside.conj()) / (2 * each)
    return found, 2 * each


def _white(regression: _Regression) -> tuple[Complexes, float]:
    """Return the covariance of each harmonic as of white noise, and half its degrees of freedom.

    Neighbours that are correlated make fewer independent samples (``independent_share``).
    """
    left, (rows, columns) = regression.left, regression.basis.shape
    shares = np.array([independent_share(x) for x in left.T])
    freedom = max(1, rows - columns)
    noise = left.T @ left / freedom / np.sqrt(np.outer(shares, shares))
    # E|d|^2 of the sines and cosines together: 4 / N, where these are orthogonal
    gains = np.diagonal(regression.inverse)[_TRENDS:].reshape(2, -1).sum(axis=0)
    return gains[:, None, None] * noise.astype(np.complex128), max(0.5 * freedom * float(shares.min()), 2.0)


def _frequency_error(kept: _Regression, noise: _Noise) -> float:
    """Return the standard error of the frequency, from the noise around each harmonic."""
    sizes, covariance = noise.sizes[: kept.count], noise.covariance[: kept.count]
    rates = (math.tau * np.arange(1, kept.count + 1)) ** 2
    weighed = sizes * kept.weights
    power = (abs(sizes) ** 2 @ kept.weights) @ rates
    variance = np.einsum("ka,kab,kb->k", weighed.conj(), covariance, weighed).real @ rates
    return math.sqrt(6.0 * float(variance)) / (float(power) * float(np.ptp(kept.time)))


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


# ------------------------------------------------------------------------------
# The conveying speed of a measured motion and its distance to the hop, with standard errors.


class HopOnset(NamedTuple):
    """How far a measured motion is from lifting parts off the trough.

    Attributes
    ----------
    throw_number : Estimate
        Largest downward acceleration normal to the trough over that of gravity; above 1 parts hop.
    growth : Estimate
        Factor of the whole motion, all harmonics alike, at which it is 1; inf of a motion along the trough
        alone.
    amplitudes : mapping of str to Estimate
        Amplitudes of the first harmonic then, by the names of the scene's fields: of a line, or both of an
        ellipse [m]. Empty where nothing makes parts hop.
    parts : mapping of str to float
        What each kind of error contributes to that of the throw number, the largest first [1].
    """

    throw_number: Estimate
    growth: Estimate
    amplitudes: Mapping[str, Estimate]
    parts: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Speeds:
    """The conveying speed of a measured motion.

    Attributes
    ----------
    speed : Estimate
        Of the motion that was measured; its error, of noise and sensors together, is the standard deviation
        of the draws that have a speed, NaN with fewer than two [m/s].
    regime : Regime
        Of the motion that was measured.
    status : Status
        Whether its speed is exact, or why there is none.
    draws : int
        Number of draws.
    shares : mapping of Regime to float
        Share of the draws in each regime that occurs, the most frequent first.
    unknown : float
        Share of the draws without a speed.
    last_harmonic : float
        Change of the speed by the last harmonic; NaN with one harmonic, or where a speed is unknown [m/s].
    parts : mapping of str to float
        What each kind of error contributes to that of the speed: ``noise``, and the kinds of a sensor, the
        largest first; NaN if unknown [m/s].
    """

    speed: Estimate
    regime: Regime
    status: Status
    draws: int
    shares: Mapping[Regime, float]
    unknown: float
    last_harmonic: float
    parts: Mapping[str, float]


def speeds_of(measured: MeasuredMotion, others: Mapping[str, float], draws: int = TOL.draws) -> Speeds:
    """Solve a measured motion, draws of its errors, and the motion moved by each of them.

    Parameters
    ----------
    measured : MeasuredMotion
        The motion.
    others : mapping of str to float
        The fields of ``Scene`` besides the drive's: friction at least [SI].
    draws : int
        Number of draws.
    """
    motion, kinds = measured.motion, measured.moved_by_kind
    sides = [one.motion for pairs in kinds.values() for pair in pairs for one in pair]
    cycle = solve(
        Scene(**_stacked([motion, motion.up_to(max(measured.order - 1, 1)), *sides]).drive(), **others)
    )
    sample = solve(Scene(**measured.drawn(draws).drive(), **others))

    speed, last, *moved = cycle.mean_velocity.tolist()
    known = sample.mean_velocity[np.isfinite(sample.mean_velocity)]
    regimes, counts = np.unique(sample.regime, return_counts=True)
    shares = {Regime(int(regimes[i])): float(counts[i]) / draws for i in np.argsort(-counts, kind="stable")}
    return Speeds(
        speed=Estimate(speed, float(known.std(ddof=1)) if known.size > 1 else math.nan),
        regime=Regime(int(cycle.regime[0])),
        status=Status(int(cycle.status[0])),
        draws=draws,
        shares=shares,
        unknown=1.0 - known.size / draws,
        last_harmonic=speed - last if measured.order > 1 else math.nan,
        parts=_parts(kinds, moved),
    )


def _parts(kinds: Mapping[str, Sequence[Any]], moved: Sequence[float]) -> dict[str, float]:
    """Return what each kind of error contributes to a standard error, the largest first.

    ``moved`` are the values on either side of each error.
    """
    effects = 0.5 * np.diff(np.reshape(moved, (-1, 2)), axis=1)
    ends = np.cumsum([len(pairs) for pairs in kinds.values()])
    sizes = [float(np.linalg.norm(part)) for part in np.split(effects, ends[:-1])]
    sizes = [size if size > TOL.idle * max(sizes) else 0.0 for size in sizes]  # rounding
    return dict(sorted(zip(kinds, sizes, strict=True), key=lambda part: -part[1]))


def change_by_harmonics(measured: MeasuredMotion, others: Mapping[str, float]) -> float:
    """Return by how much the harmonics change the speed of the fundamental alone, relative to that [1].

    NaN where a speed is unknown, inf where the fundamental alone conveys nothing. Parameters are those of
    ``speeds_of``.
    """
    both = _stacked([measured.motion, measured.motion.up_to(1)])
    speed, first = (float(x) for x in solve(Scene(**both.drive(), **others)).mean_velocity)
    if speed == first:
        return 0.0
    return (speed - first) / abs(first) if first else math.copysign(math.inf, speed)


def hop_onset(measured: MeasuredMotion, others: Mapping[str, float], draws: int = TOL.draws) -> HopOnset:
    """Return the throw number of a measured motion and where it becomes 1; friction changes neither.

    Parameters are those of ``speeds_of``. Errors are standard deviations of the draws.
    """
    frictionless = {"static_friction": 0.0, "kinetic_friction": 0.0}
    motions, kinds = (measured.motion, measured.drawn(draws)), measured.moved_by_kind
    sides = _stacked([one.motion for pairs in kinds.values() for pair in pairs for one in pair])
    known, sample, moved = (
        solve(Scene(**motion.drive(), **{**others, **frictionless})).throw_number
        for motion in (*motions, sides)
    )
    parts = _parts(kinds, moved.tolist())

    def estimate(value: Floats, values: Floats) -> Estimate:
        return Estimate(float(value), float(np.std(values, ddof=1)))

    throw = estimate(known, sample)
    if not throw.value:
        return HopOnset(throw, Estimate(math.inf, 0.0), {}, parts)
    now, drawn = (
        {"along_amplitude": abs(motion.along[0]), "normal_amplitude": abs(motion.normal[0])}
        for motion in motions
    )
    if not measured.on_an_ellipse:
        now, drawn = ({"amplitude": np.hypot(*sizes.values())} for sizes in (now, drawn))
    # The throw number is proportional to the whole motion.
    amplitudes = {name: estimate(now[name] / known, drawn[name] / sample) for name in now}
    return HopOnset(throw, estimate(1.0 / known, 1.0 / sample), amplitudes, parts)


def _stacked(motions: list[Motions]) -> Motions:
    """Put single motions into one with an axis."""
    arrays = [(m.frequency, m.along, m.normal) for m in motions]
    frequency, along, normal = (np.stack(parts, axis=-1) for parts in zip(*arrays, strict=True))
    return Motions(frequency, along, normal)


# ------------------------------------------------------------------------------
# Which of the trough's measured motions stands in a scene, in place of the drive that the scene gives.

#: What sensors on the trough measure: every quantity of a drive, and its frequency.
MEASURED: Final = (*DRIVES, "frequency")
_ANY_LINE: Final = 0.25 * math.pi  # [rad] one sensor's own harmonics are the same on any line


class TroughDrive(NamedTuple):
    """The measured motion of a trough.

    Attributes
    ----------
    first : MeasuredDrive
        Line or ellipse of its first harmonic.
    drive : MeasuredDrive
        What stands in the scene.
    measured : MeasuredMotion or None
        All harmonics; None if the record does not determine them.
    record : Record
        The part of the record that was taken.
    notes, warnings : sequence of str
        How it was chosen, and reasons to doubt it.
    """

    first: MeasuredDrive
    drive: MeasuredDrive
    measured: MeasuredMotion | None
    record: Record
    notes: Sequence[str]
    warnings: Sequence[str]

    @property
    def needed(self) -> set[str]:
        """Quantities of the drive that one sensor does not measure, and the scene gives."""
        family = LINEAR if "amplitude" in self.first.quantities else ELLIPTICAL
        return {*family} - self.first.quantities.keys()

    @property
    def texts(self) -> dict[str, str]:
        """Quantities of the drive in users' units, to two digits below their standard errors."""
        return {
            name: spelled(*map(QUANTITIES[name].from_si, estimate))
            for name, estimate in self.drive.quantities.items()
        }


def trough_drive(
    record: Record,
    own: Mapping[str, float],
    others: Mapping[str, float] | None = None,
    *,
    mounting: Mounting = _EXACT,
    reverse: bool = False,
    fits: bool = False,
) -> TroughDrive:
    """Measure the trough's motion, and choose what stands in a scene.

    Parameters
    ----------
    record : Record
        Record with motions of the trough.
    own : mapping of str to float
        Quantities of the drive that the scene gives [SI].
    others : mapping of str to float, optional
        The other fields of ``Scene``, if the record holds signals of a part.
    mounting : Mounting
        How the sensors are mounted.
    reverse : bool
        Whether the axis along the trough points against the conveying direction.
    fits : bool
        Whether quantities are fitted to the part's signals.

    Raises
    ------
    InputError
        As for ``motion_of``; a record that is too short for harmonics is compared with, without them.

    Notes
    -----
    A part is computed on the harmonics if they change its speed. An estimate would take their effect for
    friction: it is on them wherever they stand out of the noise, and refused where they are not known.
    """
    elliptical = not own.keys().isdisjoint(ELLIPTICAL)
    is_single = len(record.trough) == 1
    is_half = is_single and elliptical and others is not None  # of a motion whose other half the scene gives
    angle = _ANY_LINE if is_half else own.get("drive_angle") if is_single else None
    compares = others is not None and not fits
    if is_half:
        mounting = mounting._replace(errors=mounting.errors._replace(angle=0.0))
        if mounting.turned:
            unknown = "one sensor that is turned shows both motions of an ellipse"
            raise InputError(unknown, hint=f"leave out {argument('turned')}, or name the other sensor too")
    motion = motion_of(
        record,
        mounting,
        reverse=reverse,
        drive_angle=angle,
        down=elliptical,
        short=compares,
        stated=own.get("frequency"),
    )
    record = part_of(record, motion.start, motion.start + motion.span * (1.0 + TOL.rounding))
    if elliptical or motion.on_an_ellipse:
        first = motion.drive_on_ellipse(own.get("normal_phase", 0.0) if elliptical else None)
    else:
        first = motion.drive_on_line()
    if fits and is_half and motion.order > 1:
        raise InputError(
            f"the trough moves with {motion.order} harmonics: one sensor measures one direction alone",
            hint=f"a fit needs {argument('trough_along')} and {argument('trough_normal')}",
        )
    measured = None if is_half or motion.is_short else motion
    warnings = [*motion.warnings, *_far_off(first, own)]
    takes, text = (True, "") if others is None else _takes_harmonics(measured, others, fits=fits)
    if takes:
        drive = motion.drive_by_harmonics() if motion.order > 1 else first
        return TroughDrive(first, drive, measured, record, [*motion.notes, *filter(None, [text])], warnings)
    warnings += [*motion.impurities, *first.warnings, *filter(None, [text])]
    return TroughDrive(first, first, measured, record, motion.notes, warnings)


def _takes_harmonics(
    measured: MeasuredMotion | None, others: Mapping[str, float], *, fits: bool
) -> tuple[bool, str]:
    """Return whether a part is computed on all harmonics; and a note if it is, a warning if it is not."""
    if measured is None or measured.order == 1:
        return False, ""
    many = f"the trough moves with {measured.order} harmonics"
    if fits:
        return True, f"{many}: they are part of the fit"
    change = change_by_harmonics(measured, others)
    if math.isnan(change):
        return False, f"{many}, but the speed of a part on them is not known: the first is taken alone"
    if abs(change) <= TOL.harmonics_matter:
        return False, ""
    by = f"by {100.0 * change:+.2g} %" if math.isfinite(change) else "from 0"
    return True, f"{many}, which change the computed speed {by}: they are taken"


def _far_off(drive: MeasuredDrive, own: Mapping[str, float]) -> list[str]:
    """Question the sensors where an amplitude, or the drive angle, is far from the scene's."""
    sensors, found = drive.motion.sensors, []
    columns = " and ".join(shown(sensor.header) for sensor in sensors)
    for name in {*AMPLITUDES} & drive.quantities.keys() & own.keys():
        ratio = drive.quantities[name].value / own[name] if own[name] else 1.0
        if not 1.0 / TOL.far_off <= ratio <= TOL.far_off:
            texts = dict.fromkeys(sensor.sensitivity for sensor in sensors if sensor.sensitivity)
            what = f"the {QUANTITIES[name].label} is about {rounded(float(ratio))} times the scene's"
            found.append(f"column {columns}: {what}: {doubt(' or '.join(texts))}")
    angle, given = drive.quantities.get("drive_angle"), own.get("drive_angle")
    if angle and given is not None and abs(angle.value - given) > TOL.far_angle:
        here, there = (f"{QUANTITIES['drive_angle'].from_si(x):.3g} deg" for x in (angle.value, given))
        what = f"the drive angle is {here}, the scene's {there}: does each name stand for its sensor?"
        found.append(f"column {columns}: {what}")
    return found
