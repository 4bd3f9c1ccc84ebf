"""Settings of a drive, and the uncertainty set of a setting: all operating points within bands and drifts.

A setting is a motion of the trough: amplitudes along and normal to it, the phase between them, and the
frequency. Drives along a line and along an ellipse differ in the quantities that set it (knobs), which the
two spaces below describe.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple

import numpy as np

from vibro.drives import Ability, Ellipse, Line
from vibro.inverse.tolerances import TOLERANCES
from vibro.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ends = tuple[Any, Any]  # numbers, or arrays of shape (m, 1)

__all__ = [
    "SPACES", "EllipseSpace", "LineSpace", "Points", "Setting", "Space", "UncertaintySet", "inside", "off",
]  # fmt: skip

_RIGHT_ANGLE: Final = 0.5 * math.pi


class Setting(NamedTuple):
    """Nominal motion of the trough [m, m, rad, Hz]; numbers, or arrays of one shape."""

    along_amplitude: Any
    normal_amplitude: Any
    normal_phase: Any
    frequency: Any

    def scaled(self, factor: Any) -> Setting:
        """Return the motion with both amplitudes multiplied."""
        x, y, phase, frequency = self
        return Setting(factor * x, factor * y, phase, frequency)

    def load(self, gravity: float) -> Floats:
        """Largest acceleration along the path over gravity [1]."""
        one = np.ones(())
        motion = Ellipse._make([*map(np.asarray, self), *[one] * 5])
        return np.asarray(motion.reach * (2.0 * np.pi * motion.frequency) ** 2 / gravity)


class Space:
    """Quantities that set a kind of drive: its knobs.

    Attributes
    ----------
    drive : type
        The kind of drive.
    knobs : tuple of str
        Every quantity that may be chosen, in the order of printed settings.
    shape : tuple of str
        Knobs beside amplitude and frequency: coordinates of a box.
    """

    drive: ClassVar[type[Line] | type[Ellipse]]
    knobs: ClassVar[tuple[str, ...]]
    shape: ClassVar[tuple[str, ...]]

    @property
    def proves(self) -> bool:
        """Whether corners of a box prove bounds."""
        return Ability.PROOF in self.drive.abilities

    def setting(self, **knobs: Any) -> Setting:
        """Return the setting of values of all knobs [SI]."""
        raise NotImplementedError

    def turned(self, setting: Setting) -> dict[str, Any]:
        """Return the values of all knobs at a setting, in their order [SI]."""
        raise NotImplementedError

    def amplitude(self, setting: Setting) -> Any:
        """Amplitude that windows and pictures vary [m]."""
        raise NotImplementedError

    def leading(self, setting: Setting) -> str:
        """Return the name of that amplitude."""
        raise NotImplementedError

    def band(self, setting: Setting, drift: Any, scale: Any, steepest: Any) -> tuple[Ends, dict[str, Ends]]:
        """Return the bands of the factor and of the shape around a setting.

        Parameters
        ----------
        setting : Setting
            Nominal values.
        drift : Drift
            Largest deviations from them.
        scale : float or array
            Factor on all drifts.
        steepest : float or array
            Largest drive angle beside the trough's [rad].
        """
        raise NotImplementedError

    def motion(self, factor: Any, shape: tuple[Any, ...]) -> dict[str, Any]:
        """Return the fields of a scene that describe its motion, except the frequency."""
        raise NotImplementedError

    def normal(self, shape: tuple[Any, ...]) -> Any:
        """Amplitude normal to the trough at a factor of 1."""
        raise NotImplementedError


class LineSpace(Space):
    """Drives along a line: the factor is the amplitude [m], the shape the drive angle."""

    drive = Line
    knobs = ("amplitude", "frequency", "drive_angle")
    shape = ("drive_angle",)

    def setting(self, **knobs: Any) -> Setting:
        """Return the setting of an amplitude [m] and a frequency [Hz] at a drive angle [rad]."""
        size, frequency, alpha = (knobs[knob] for knob in self.knobs)
        return Setting(size * np.cos(alpha), size * np.sin(alpha), 0.0 * size, frequency)

    def turned(self, setting: Setting) -> dict[str, Any]:
        """Return amplitude, frequency and drive angle."""
        angle = np.arctan2(setting.normal_amplitude, setting.along_amplitude)
        return {"amplitude": self.amplitude(setting), "frequency": setting.frequency, "drive_angle": angle}

    def amplitude(self, setting: Setting) -> Any:
        """Amplitude of the motion [m]."""
        return np.hypot(setting.along_amplitude, setting.normal_amplitude)

    def leading(self, setting: Setting) -> str:
        """Return the name of the amplitude."""
        return "amplitude"

    def band(self, setting: Setting, drift: Any, scale: Any, steepest: Any) -> tuple[Ends, dict[str, Ends]]:
        """Return the bands of the amplitude and of the drive angle."""
        amplitude, _, alpha = self.turned(setting).values()
        angles = alpha - drift.drive_angle * scale, alpha + drift.drive_angle * scale
        return off(amplitude, drift.amplitude * scale), {
            "drive_angle": cut(angles, 0.0, np.maximum(alpha, steepest))
        }

    def motion(self, factor: Any, shape: tuple[Any, ...]) -> dict[str, Any]:
        """Return amplitude and drive angle."""
        return {"amplitude": factor, "drive_angle": shape[0]}

    def normal(self, shape: tuple[Any, ...]) -> Any:
        """Sine of the drive angle."""
        return np.sin(shape[0])


class EllipseSpace(Space):
    """Drives along an ellipse: the factor is that of both amplitudes, which drift together."""

    drive = Ellipse
    knobs = Setting._fields
    shape = ("along_amplitude", "normal_amplitude", "normal_phase")

    def setting(self, **knobs: Any) -> Setting:
        """Return the setting of both amplitudes [m], the phase [rad] and the frequency [Hz]."""
        return Setting(**knobs)

    def turned(self, setting: Setting) -> dict[str, Any]:
        """Return the fields of the setting."""
        return setting._asdict()

    def amplitude(self, setting: Setting) -> Any:
        """Amplitude along the trough or, where that is 0, normal to it [m]."""
        return getattr(setting, self.leading(setting))

    def leading(self, setting: Setting) -> str:
        """Return the name of the amplitude along the trough or, where that is 0, normal to it."""
        return "along_amplitude" if np.all(setting.along_amplitude > 0.0) else "normal_amplitude"

    def band(self, setting: Setting, drift: Any, scale: Any, steepest: Any) -> tuple[Ends, dict[str, Ends]]:
        """Return the bands of the factor, the amplitudes and the phase."""
        x, y, phase, _ = setting
        phases = phase - drift.normal_phase * scale, phase + drift.normal_phase * scale
        shape = {"along_amplitude": (x, x), "normal_amplitude": (y, y), "normal_phase": phases}
        return off(1.0, drift.amplitude * scale), shape

    def motion(self, factor: Any, shape: tuple[Any, ...]) -> dict[str, Any]:
        """Return both amplitudes and the phase."""
        x, y, phase = shape
        return {"along_amplitude": factor * x, "normal_amplitude": factor * y, "normal_phase": phase}

    def normal(self, shape: tuple[Any, ...]) -> Any:
        """Amplitude normal to the trough [m]."""
        return shape[1]


#: The space of each kind of drive that can be designed.
SPACES: Final[Mapping[type, Space]] = {Line: LineSpace(), Ellipse: EllipseSpace()}


class Points(NamedTuple):
    """Points of a box, arrays of one shape: they fix a body's motion up to the scales of length and time.

    Attributes
    ----------
    load : array
        w^2 / g times the factor of the motion: G = A w^2 / g of a line [1], 1/m of an ellipse.
    shape : tuple of array
        By ``Space.shape`` [SI].
    trough_angle : array
        [rad].
    static_friction, kinetic_friction : array
        mu_s and mu_d [1].
    """

    load: Floats
    shape: tuple[Floats, ...]
    trough_angle: Floats
    static_friction: Floats
    kinetic_friction: Floats

    def kept(self, which: NDArray[np.bool_]) -> Points:
        """Return some of the points."""
        load, shape, *others = self
        return Points(load[which], tuple(x[which] for x in shape), *(x[which] for x in others))

    def joined(self, others: Points) -> Points:
        """Add points."""
        columns = zip(self.columns(), others.columns(), strict=True)
        return self.of([np.append(x, y) for x, y in columns])

    def columns(self) -> list[Floats]:
        """Return all arrays, broadcast against each other."""
        return [x.copy() for x in np.broadcast_arrays(self.load, *self.shape, *self[2:])]

    @classmethod
    def of(cls, columns: list[Floats]) -> Points:
        """Return the points of arrays in the order of ``columns``."""
        load, *shape, beta, mu_s, mu_d = columns
        return cls(load, tuple(shape), beta, mu_s, mu_d)


@dataclass(frozen=True, kw_only=True)
class UncertaintySet:
    """Operating points within closed bands, a box, cut at mu_d <= mu_s.

    Both ends of a band are equal where a value is known. Ends may be arrays of shape (m, 1) for m boxes at
    once; then every result has a row for each. Amplitude and frequency are one coordinate, the load: at one
    load the speed is proportional to 1/f.

    Attributes
    ----------
    space : Space
        Of the drive.
    factor : pair
        Band of the factor on the motion: the amplitude of a line [m], a number of an ellipse [1].
    frequency : pair
        Band [Hz].
    shape : mapping of str to pair
        Bands by ``Space.shape`` [SI].
    trough_angle, static_friction : pair
        Bands [rad, 1].
    second_friction : pair
        Band of kinetic friction, or of its ratio to the static one [1].
    is_ratio : bool
        Which of the two it is.
    gravity, restitution : float
        As in ``Scene``.
    """

    space: Space
    factor: Ends
    frequency: Ends
    shape: Mapping[str, Ends]
    trough_angle: Ends
    static_friction: Ends
    second_friction: Ends
    is_ratio: bool
    gravity: float
    restitution: float

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the coordinates, in order; frictions are last."""
        return ("load", *self.shape, "trough_angle", "static_friction", "second_friction")

    @property
    def load(self) -> tuple[Floats, Floats]:
        """Smallest and largest load, as in ``Points``."""
        low, high = (
            np.asarray(a * (2.0 * np.pi * np.asarray(f)) ** 2 / self.gravity)
            for a, f in zip(self.factor, self.frequency, strict=True)
        )
        return low, high

    @property
    def hop_load(self) -> Floats:
        """Load above which the first body hops, Eq. (4): on the steepest trough, with the steepest drive."""
        b_low, b_high = self.trough_angle
        normal = self.space.normal(tuple(high for _, high in self.shape.values()))
        with np.errstate(divide="ignore"):
            return np.asarray(np.minimum(np.cos(b_low), np.cos(b_high)) / normal)

    @property
    def may_hop(self) -> bool:
        """Whether some body of a single box hops."""
        return float(self.load[1]) > float(self.hop_load)

    @property
    def throw_number(self) -> float:
        """Largest throw number of a single box [1]."""
        return float(self.load[1] / self.hop_load)

    @property
    def spans(self) -> tuple[Ends, ...]:
        """Bands of ``axes``; that of the second friction is not cut at static friction."""
        return (
            self.load, *self.shape.values(), self.trough_angle, self.static_span, self.second_friction,
        )  # fmt: skip

    @property
    def varies(self) -> NDArray[np.bool_]:
        """Whether each of ``axes`` has a width, of a single box."""
        return np.array([bool(low < high) for low, high in self.spans])

    @property
    def constants(self) -> dict[str, float]:
        """Quantities without a band, by the fields of ``Scene``."""
        return {"gravity": self.gravity, "restitution": self.restitution}

    @property
    def static_span(self) -> Ends:
        """Smallest and largest static friction, cut at the smallest kinetic friction."""
        low, high = self.static_friction
        return (low, high) if self.is_ratio else (np.maximum(low, self.second_friction[0]), high)

    def kinetic_span(self, static_friction: Floats) -> tuple[Floats, Floats]:
        """Smallest and largest kinetic friction beside a static friction."""
        low, high = (
            np.minimum(end * static_friction if self.is_ratio else end, static_friction)
            for end in self.second_friction
        )
        return low, high

    def hops(self, points: Points) -> NDArray[np.bool_]:
        """Return which points make their bodies hop."""
        return np.asarray(points.load * self.space.normal(points.shape) > np.cos(points.trough_angle))

    def points(self, coordinates: Floats) -> Points:
        """Return the points at unit-cube coordinates, an array of shape (axes, ...).

        The coordinate of kinetic friction spans its band up to static friction.
        """
        *spans, static, _ = self.spans
        load, *shape, beta = (inside(span, share) for span, share in zip(spans, coordinates, strict=False))
        mu_s = inside(static, coordinates[-2])
        return Points(load, tuple(shape), beta, mu_s, inside(self.kinetic_span(mu_s), coordinates[-1]))

    def coordinates(self, points: Points) -> Floats:
        """Return the unit-cube coordinates of points, of shape (axes, ...): the inverse of ``points``."""
        load, shape, beta, mu_s, mu_d = points
        spans = (*self.spans[:-1], self.kinetic_span(mu_s))
        return np.array(
            [_share(x, span) for x, span in zip((load, *shape, beta, mu_s, mu_d), spans, strict=True)]
        )

    def scene(self, points: Points, *, fast: bool) -> Scene:
        """Return scenes at the points: of the frequencies that a load allows the fastest, or the slowest."""
        # Of all factors and frequencies with the same load the lowest frequency is the fastest, and the
        # highest the slowest, Eq. (52).
        weight = points.load * self.gravity / (4.0 * math.pi**2)  # factor f^2
        (a_low, a_high), (f_low, f_high) = self.factor, self.frequency
        with np.errstate(over="ignore"):  # an overflow lies beyond the band
            frequency = np.clip(np.sqrt(weight / (a_high if fast else a_low)), f_low, f_high)
        factor = np.clip(weight / (frequency * frequency), a_low, a_high)
        return Scene.allowing_infeasible(
            **self.space.motion(factor, points.shape),
            frequency=frequency,
            static_friction=points.static_friction,
            kinetic_friction=points.kinetic_friction,
            trough_angle=points.trough_angle,
            **self.constants,
        )


def inside(ends: Ends, share: Floats) -> Floats:
    """Value at a share of a band: exact at both ends, and never beyond them."""
    low, high = ends
    value: Floats = np.where(share == 1.0, high, np.clip(low + share * (high - low), low, high))
    return value


def _share(value: Floats, ends: Ends) -> Floats:
    """Return the share of a band at which a value lies; 0 of a band without a width."""
    low, high = ends
    width = np.asarray(high - low)
    return np.where(width > 0.0, np.clip((value - low) / np.where(width > 0.0, width, 1.0), 0.0, 1.0), 0.0)


def cut(ends: Ends, low: float, high: Any) -> Ends:
    """Cut a band to a range."""
    return np.clip(ends[0], low, high), np.clip(ends[1], low, high)


def off(value: Any, share: Any) -> Ends:
    """Return the band of a nominal value with a relative drift, kept positive."""
    return value * np.maximum(1.0 - share, TOLERANCES.short), value * (1.0 + share)
