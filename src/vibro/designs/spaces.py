"""Settings of a drive, and the uncertainty set of a setting: all operating points within bands and drifts.

A setting is a motion of the trough: of drives along a line or an ellipse amplitudes along and normal to it,
the phase between them, and the frequency; of any other periodic motion its scale and the frequency. The
drives differ in the quantities that set them (knobs), which the three spaces below describe.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple, cast

import numpy as np

from vibro.drives import Ability, Ellipse, HarmonicMotion, Harmonics, Line, Piecewise
from vibro.errors import Problem, SceneError, shown
from vibro.quantities import QUANTITIES
from vibro.reals import NotRealError, real_array
from vibro.scene import Scene, check_single, field_range, field_text
from vibro.steady import solve

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from numpy.typing import NDArray

    from vibro.drives import Motion
    from vibro.reals import Floats

    Ends = tuple[Any, Any]
    Span = tuple[float, float]  # both ends of a closed interval

# ------------------------------------------------------------------------------
# The tolerances of inverse design, each with its unit and the reason for its size.


class _Tolerances(NamedTuple):
    """Distances at which two numbers count as one; all are relative, unless they have a unit.

    Attributes
    ----------
    beside : float
        From a load that is not to be exceeded: more than the rounding of the products that form a load (4
        ulp), less than any number that is printed.
    rounding : float
        Of a load that is formed anew from its setting, and of conversions between units: below ``beside``.
    converted : float
        Of a printed setting against the limits of its drive, after two conversions of units.
    short : float
        Distance of scaled bands from impossible values: from a right angle [rad], from a load of 0 [1].
    searched : float
        Of a speed, by which the slowest body of a search may exceed the slowest of the scenarios
        (tests/designs/test_guarantees.py: searches agree to 1e-9 with ten times their effort).
    near : float
        Distance from a critical load within which its one-sided limit is computed: searches end within 1e-7.
    either_side : float
        From a critical load at which both sides are compared: beyond the rounding of 1e-12 of its root.
    jump : float
        Change of a speed over ``either_side`` that is a jump: slopes just above an onset reach 1e3.
    fall : float
        The same over ``at``, where a design is scaled instead of a body.
    at : float
        From a limit, within which a design stands at it: the coarsest margins are found to 1e-6.
    nearly : float
        Share of a limit on landings that counts as reached: landings are sampled.
    digits : int
        [decimals of coordinates] In which scenarios differ.
    braked : float
        Share of the weight down the trough by which friction must exceed it: below, rounding decides whether
        bodies run away.
    """

    beside: float = 1e-12
    rounding: float = 1e-13
    converted: float = 1e-12
    short: float = 1e-6
    searched: float = 1e-9
    near: float = 1e-7
    either_side: float = 1e-9
    jump: float = 1e-6
    fall: float = 1e-4
    at: float = 1e-6
    nearly: float = 0.98
    digits: int = 6
    braked: float = 1e-12


TOLERANCES: Final = _Tolerances()


_RIGHT_ANGLE: Final = 0.5 * math.pi
_UNIT: Final = 4.0 * math.pi**2  # [m/s^2] largest acceleration of an amplitude of 1 m at 1 Hz


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


class Scaled(NamedTuple):
    """Nominal scale and frequency of a motion [1, Hz]; numbers, or arrays of one shape."""

    motion_scale: Any
    frequency: Any

    def scaled(self, factor: Any) -> Scaled:
        """Return the motion with its scale multiplied."""
        return Scaled(factor * self.motion_scale, self.frequency)


#: ``Setting``, or ``Scaled`` of a given motion: each space has settings of one kind.
AnySetting = Any


class Space:
    """Quantities that set a kind of drive: its knobs.

    Attributes
    ----------
    drive : type
        The kind of drive.
    knobs : tuple of str
        Every quantity that may be chosen, in the order of printed settings.
    sizes : tuple of str
        Those with which the load grows, at any frequency.
    shape : tuple of str
        Knobs beside amplitude and frequency: coordinates of a box.
    settings : type
        Of its settings.
    unit : float
        Largest acceleration at 1 Hz of the motion whose factor is 1, along a line or where both amplitudes
        are measured by it [m/s^2].
    power : int
        Power of the frequency with which the load goes: 2, or 0 of a motion that is given by accelerations.
    is_bounded : bool
        Whether the solver covers boxes of bodies in contact by proved bounds.
    """

    drive: type[Line | Ellipse | Harmonics | Piecewise]
    knobs: ClassVar[tuple[str, ...]]
    sizes: ClassVar[tuple[str, ...]]
    shape: ClassVar[tuple[str, ...]]
    settings: ClassVar[type[Setting | Scaled]] = Setting
    unit: float
    power: int
    is_bounded: ClassVar[bool] = True

    @property
    def proves(self) -> bool:
        """Whether corners of a box prove bounds."""
        return Ability.PROOF in self.drive.abilities

    def setting(self, **knobs: Any) -> Setting:
        """Return the setting of values of all knobs [SI]; of a given motion ``Scaled``."""
        return cast("Setting", self.settings(**knobs))

    def turned(self, setting: Any) -> dict[str, Any]:
        """Return the values of all knobs at a setting, in their order [SI]."""
        return dict(setting._asdict())

    def leading(self, setting: Any) -> str:
        """Return the name of the amplitude, or scale, that windows and pictures vary."""
        return self.sizes[0]

    def amplitude(self, setting: Any) -> Any:
        """Amplitude that windows and pictures vary [m], or the scale of a motion [1]."""
        return self.turned(setting)[self.leading(setting)]

    def load(self, setting: Any, gravity: float) -> Floats:
        """Largest acceleration of a setting along its path over gravity [1]."""
        return np.asarray(setting.load(gravity))

    def load_at(self, factor: Any, frequency: Any, gravity: float) -> Floats:
        """Load of a factor of the motion at a frequency, as in ``Points``; inf beyond doubles."""
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray(factor * (2.0 * np.pi * np.asarray(frequency)) ** 2 / gravity)

    def parts(
        self, load: Floats, gravity: float, factor: Ends, frequency: Ends, *, fast: bool
    ) -> tuple[Floats, Floats]:
        """Split loads into factor and frequency, within bands: the fastest pair, or the slowest."""
        if not self.power:  # accelerations do not depend on the frequency, speeds fall with it
            return np.clip(load * gravity / self.unit, *factor), np.asarray(frequency[0 if fast else 1])
        # Of all factors and frequencies with the same load the lowest frequency is the fastest, and the
        # highest the slowest, Eq. (52).
        weight = load * gravity / self.unit  # factor f^2
        (a_low, a_high), (f_low, f_high) = factor, frequency
        with np.errstate(over="ignore"):  # an overflow lies beyond the band
            f = np.clip(np.sqrt(weight / (a_high if fast else a_low)), f_low, f_high)
        return np.clip(weight / (f * f), a_low, a_high), f

    def band(self, setting: Any, drift: Any, scale: Any, steepest: Any) -> tuple[Ends, dict[str, Ends]]:
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


class _LineSpace(Space):
    """Drives along a line: the factor is the amplitude [m], the shape the drive angle."""

    drive = Line
    knobs = ("amplitude", "frequency", "drive_angle")
    sizes = ("amplitude",)
    unit, power = _UNIT, 2
    shape = ("drive_angle",)

    def setting(self, **knobs: Any) -> Setting:
        """Return the setting of an amplitude [m] and a frequency [Hz] at a drive angle [rad]."""
        size, frequency, alpha = (knobs[knob] for knob in self.knobs)
        return Setting(size * np.cos(alpha), size * np.sin(alpha), 0.0 * size, frequency)

    def turned(self, setting: Setting) -> dict[str, Any]:
        """Return amplitude, frequency and drive angle."""
        x, y, _, frequency = setting
        return {"amplitude": np.hypot(x, y), "frequency": frequency, "drive_angle": np.arctan2(y, x)}

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


class _EllipseSpace(Space):
    """Drives along an ellipse: the factor is that of both amplitudes, which drift together."""

    drive = Ellipse
    knobs = Setting._fields
    sizes = ("along_amplitude", "normal_amplitude")
    unit, power = _UNIT, 2
    shape = ("along_amplitude", "normal_amplitude", "normal_phase")

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


@dataclass(frozen=True)
class MotionSpace(Space):
    """Drives that are a given motion: the factor is its scale [1], its shape is fixed.

    Attributes
    ----------
    given : Motion
        The motion, without axes of its own.
    drive, unit, power
        As for all spaces.
    throw : float
        Its largest downward acceleration over its largest acceleration [1].
    normal_acceleration : float
        Of a clamped body, as in ``Scene``; NaN of one that lies on the trough [m/s^2].
    """

    given: Motion
    drive: type[Line | Ellipse | Harmonics | Piecewise]
    unit: float
    power: int
    throw: float
    normal_acceleration: float = math.nan

    knobs = Scaled._fields
    sizes = ("motion_scale",)
    settings = Scaled
    shape = ()
    is_bounded = False

    @classmethod
    def of(cls, motion: Motion, normal_acceleration: float = math.nan) -> MotionSpace:
        """Return the space of a motion."""
        light = Scene(motion=motion, frequency=1.0, static_friction=1.0, kinetic_friction=1.0, gravity=1.0)
        unit, hops = float(light.load), float(solve(light, output="regimes").throw_number)
        power = 2 if isinstance(motion, HarmonicMotion) else 0
        return cls(
            motion, type(light.arrays()), unit, power, hops / unit if unit else 0.0, normal_acceleration
        )

    def load(self, setting: Scaled, gravity: float) -> Floats:
        """Largest acceleration of a setting over gravity [1]."""
        return self.load_at(*setting, gravity)

    def load_at(self, factor: Any, frequency: Any, gravity: float) -> Floats:
        """Load of a scale at a frequency: the largest acceleration over gravity [1]."""
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray(factor * (self.unit * np.asarray(frequency) ** self.power) / gravity)

    def band(self, setting: Scaled, drift: Any, scale: Any, steepest: Any) -> tuple[Ends, dict[str, Ends]]:
        """Return the band of the scale."""
        return off(setting.motion_scale, drift.amplitude * scale), {}

    def motion(self, factor: Any, shape: tuple[Any, ...]) -> dict[str, Any]:
        """Return the motion, its scale, and what clamps the body, if anything."""
        clamped = self.normal_acceleration
        beside = {} if math.isnan(clamped) else {"normal_acceleration": clamped}
        return {"motion": self.given, "motion_scale": factor, **beside}

    def normal(self, shape: tuple[Any, ...]) -> Any:
        """Largest downward acceleration over the largest one [1]."""
        return self.throw


#: The space of each kind of drive that is given by its knobs alone.
SPACES: Final[Mapping[type, Space]] = {Line: _LineSpace(), Ellipse: _EllipseSpace()}


def space_of(scene: Scene) -> Space:
    """Return the space of a scene's drive."""
    if scene.motion is None:
        return SPACES[type(scene.arrays())]
    clamped = scene.normal_acceleration
    return MotionSpace.of(scene.motion, math.nan if clamped is None else float(clamped))


class Points(NamedTuple):
    """Points of a box, arrays of one shape: they fix a body's motion up to the scales of length and time.

    Attributes
    ----------
    load : array
        w^2 / g times the factor of the motion: G = A w^2 / g of a line [1], 1/m of an ellipse. Of a given
        motion G, its largest acceleration over g [1].
    shape : tuple of array
        By ``Space.shape`` [SI].
    trough_angle : array
        [rad].
    static_friction, kinetic_friction, restitution : array
        mu_s, mu_d and e [1].
    """

    load: Floats
    shape: tuple[Floats, ...]
    trough_angle: Floats
    static_friction: Floats
    kinetic_friction: Floats
    restitution: Floats

    def kept(self, which: NDArray[np.bool_]) -> Points:
        """Return some of the points."""
        load, shape, *others = self
        return Points(load[which], tuple(x[which] for x in shape), *(x[which] for x in others))


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
        Band of the factor on the motion: the amplitude of a line [m], a number of an ellipse [1], the
        scale of a given motion [1].
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
    restitution : pair
        Band [1]; without effect on bodies in contact.
    gravity : float
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
    restitution: Ends
    gravity: float

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the coordinates, in order."""
        return ("load", *self.shape, "trough_angle", "static_friction", "second_friction", "restitution")

    @property
    def load(self) -> tuple[Floats, Floats]:
        """Smallest and largest load, as in ``Points``."""
        low, high = (
            self.space.load_at(a, f, self.gravity) for a, f in zip(self.factor, self.frequency, strict=True)
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
            self.restitution,
        )  # fmt: skip

    @property
    def varies(self) -> NDArray[np.bool_]:
        """Whether each of ``axes`` has a width, of a single box."""
        return np.array([bool(low < high) for low, high in self.spans])

    @property
    def bounces(self) -> bool:
        """Whether some landing of a single box is not plastic."""
        return float(self.restitution[1]) > 0.0

    @property
    def in_contact(self) -> UncertaintySet:
        """The box of bodies in contact, whose restitution has no effect, so that its band has no width."""
        return replace(self, restitution=(self.restitution[0],) * 2)

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
        *spans, _, restitution = self.spans
        load, *shape, beta, mu_s = (
            inside(span, share) for span, share in zip(spans, coordinates[:-2], strict=True)
        )
        mu_d = inside(self.kinetic_span(mu_s), coordinates[-2])
        return Points(load, tuple(shape), beta, mu_s, mu_d, inside(restitution, coordinates[-1]))

    def coordinates(self, points: Points) -> Floats:
        """Return the unit-cube coordinates of points, of shape (axes, ...): the inverse of ``points``."""
        load, shape, *others = points
        *spans, _, restitution = self.spans
        spans += [self.kinetic_span(points.static_friction), restitution]
        return np.array([share(x, span) for x, span in zip((load, *shape, *others), spans, strict=True)])

    def scene(self, points: Points, *, fast: bool) -> Scene:
        """Return scenes at the points: of the frequencies that a load allows the fastest, or the slowest."""
        factor, frequency = self.space.parts(
            points.load, self.gravity, self.factor, self.frequency, fast=fast
        )
        return Scene.computed(
            **self.space.motion(factor, points.shape),
            frequency=frequency,
            static_friction=points.static_friction,
            kinetic_friction=points.kinetic_friction,
            trough_angle=points.trough_angle,
            restitution=points.restitution,
            gravity=self.gravity,
        )


def inside(ends: Ends, share: Floats) -> Floats:
    """Value at a share of a band: exact at both ends, and never beyond them."""
    low, high = ends
    value: Floats = np.where(share == 1.0, high, np.clip(low + share * (high - low), low, high))
    return value


def share(value: Floats, ends: Ends) -> Floats:
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


# ------------------------------------------------------------------------------
# Check the bands that a caller passes with a scene, and build the uncertainty set that they span.

_PARTS: Final = ("static_friction", "friction_ratio", "kinetic_friction", "trough_angle", "restitution")


def _one_point(scene: object) -> None:
    """Raise SceneError unless the scene is one operating point of a trough that moves."""
    if not isinstance(scene, Scene):
        raise SceneError.of("scene", shown(scene), "a vibro.Scene")
    check_single(scene)
    if scene.motion is not None and not scene.load > 0.0:
        raise SceneError.of("motion", "no acceleration at all", "a motion that moves the trough")


def uncertainty_set(
    scene: Scene, bands: Mapping[str, Any], *, leaves_out: Collection[str] = ()
) -> UncertaintySet:
    """Return the uncertainty set (box) that bands span around a scene.

    Parameters
    ----------
    scene : Scene
        One operating point; it gives the values of fields without a band.
    bands : mapping of str to pair of float
        By field name, in SI units and radians.
    leaves_out : collection of str
        Fields that must not have a band.

    Raises
    ------
    SceneError
        If the scene is more than one operating point or a band is invalid; it lists every problem.
    """
    _one_point(scene)
    space = space_of(scene)
    banded = (*space.knobs, *_PARTS)
    known = [name for name in banded if name not in leaves_out]
    problems = []
    given: dict[str, Span] = {}
    for name, band in bands.items():
        if name not in known:
            problems.append(Problem(f"band {shown(name)}", shown(band), f"of one of {', '.join(known)}"))
            continue
        found = _span(name, band)
        if isinstance(found, Problem):
            problems.append(found)
        elif name == "normal_phase" and found[1] - found[0] > 2.0 * math.pi:
            problems.append(Problem(name, shown(band), "a band of at most one turn, in radians"))
        else:
            given[name] = found
    if "friction_ratio" in given and "kinetic_friction" in given:
        problems.append(
            Problem("friction_ratio", shown(bands["friction_ratio"]), "left out beside kinetic_friction")
        )
    if problems:
        raise SceneError(tuple(problems))
    fields = {name: float(value) for _, name, value in scene.arrays().members()}
    spans = {name: given.get(name, (fields.get(name, math.nan),) * 2) for name in banded}
    is_ratio = "friction_ratio" in given
    shape = {name: spans[name] for name in space.shape}
    box = UncertaintySet(
        space=space,
        factor=spans.get("amplitude", spans.get("motion_scale", (1.0, 1.0))),
        frequency=spans["frequency"],
        shape=shape,
        trough_angle=spans["trough_angle"],
        static_friction=spans["static_friction"],
        second_friction=spans["friction_ratio" if is_ratio else "kinetic_friction"],
        is_ratio=is_ratio,
        restitution=spans["restitution"],
        gravity=fields["gravity"],
    )
    if not is_ratio and spans["kinetic_friction"][0] > spans["static_friction"][1]:
        limit = f"<= static_friction = {spans['static_friction'][1]:.15g} somewhere in its band"
        problems.append(Problem("kinetic_friction", f"{spans['kinetic_friction'][0]:.15g}", limit))
    if "drive_angle" in shape:
        problems += _line_problems(box)
    if problems:
        raise SceneError(tuple(problems))
    return box


def _line_problems(box: UncertaintySet) -> list[Problem]:
    """Return the problem of a drive along a line with too steep an angle."""
    drive, trough = box.shape["drive_angle"][1], box.trough_angle[1]
    if drive + trough < _RIGHT_ANGLE:
        return []
    limit = f"less than 90 deg together with trough_angle = {field_text('trough_angle', trough)}"
    return [Problem("drive_angle", field_text("drive_angle", drive), limit)]


def _span(name: str, band: Any) -> Span | Problem:
    """Read a band; return the problem if it is invalid."""
    try:
        ends = real_array(band)
    except NotRealError as exc:
        return Problem(name, exc.value, "a pair of numbers (low, high)")
    if ends.shape != (2,):
        return Problem(name, shown(band), "a pair of numbers (low, high)")
    low, high = (float(end) for end in ends)
    for end in (low, high):
        if not (math.isfinite(end) and QUANTITIES[name].allows(end)):
            return Problem(name, field_text(name, end), field_range(name))
    if low > high:
        return Problem(name, shown(band), "a pair (low, high) with low <= high")
    return low, high
