"""Operating points of a vibratory conveyor, in SI units and radians."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.drives import (
    KINDS,
    Ellipse,
    HarmonicMotion,
    Harmonics,
    Line,
    Motion,
    Piecewise,
    PiecewiseMotion,
    harmonic_motion,
)
from vibro.errors import Problem, SceneError, shown
from vibro.html_tables import Shown, span
from vibro.quantities import DEFAULTS, QUANTITIES, STANDARD_GRAVITY, of_part
from vibro.reals import NotRealError, real_array, shielded

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike, NDArray

    from vibro.drives import Pairs
    from vibro.reals import Floats


Fields = Line | Ellipse | Harmonics | Piecewise

_EITHER: Final = (
    "either amplitude and drive_angle, or along_amplitude and normal_amplitude, or along_harmonics and"
    " normal_harmonics, or motion"
)
_HARMONICS: Final = ("along_harmonics", "normal_harmonics")
_OF_MOTIONS: Final = {
    "motion_scale": "left out: it scales a motion; multiply the amplitude of this drive",
    "normal_acceleration": "given beside a motion along the trough alone, such as along_harmonics",
}


def field_text(name: str, value: float) -> str:
    """Write a value with its unit; angles in degrees too."""
    quantity = QUANTITIES[name]
    number = f"{value:.15g} {quantity.kind.si_unit}".rstrip()
    if quantity.kind.si_unit == "rad":
        return f"{number} ({math.degrees(value):.6g} deg)"
    return number


def field_range(name: str) -> str:
    """Return the allowed range of a field as text, angles in degrees."""
    return QUANTITIES[name].range_text


def _kind_of(values: dict[str, Any]) -> type[Fields]:
    """Return the kind of drive that is given, and fill in fields that may be left out."""
    given = {kind.own_names: [n for n in kind.own_names if values.get(n) is not None] for kind in KINDS}
    drives = [(names, found) for names, found in given.items() if found]
    if len(drives) != 1 or (values.get("motion") is not None and len(drives[0][1]) > 1):
        named = " and ".join(name for found in given.values() for name in found) or "none"
        raise SceneError.of("drive", named, _EITHER)
    ((names, found),) = drives
    if "motion" in names:
        if values.get("motion") is None:
            values["motion"] = harmonic_motion([values.get(name) for name in _HARMONICS], _HARMONICS)
        if values.get("motion_scale") is None:
            values["motion_scale"] = 1.0
        return _kind_of_motion(values["motion"])
    for name, allowed in _OF_MOTIONS.items():
        if values.get(name) is not None:
            raise SceneError.of(name, shown(values[name]), allowed)
    if "normal_phase" in names and values.get("normal_phase") is None:
        values["normal_phase"] = 0.0
    if missing := [name for name in names if values.get(name) is None]:
        raise SceneError(tuple(Problem(name, "None", f"given beside {found[0]}") for name in missing))
    return next(kind for kind in KINDS if kind.own_names == names)


def _kind_of_motion(motion: object) -> type[Harmonics | Piecewise]:
    """Return the kind of drive of a motion."""
    if not isinstance(motion, Motion):
        allowed = "a motion, such as vibro.Motion.steps(along=[(0.8, 6.9), (0.2, -27.6)])"
        raise SceneError.of("motion", shown(motion), allowed)
    return Harmonics if isinstance(motion, HarmonicMotion) else Piecewise


@dataclass(frozen=True, eq=False, init=False)
class Scene(Shown):
    """A trough, its drive and a body on it: one operating point, or a whole grid of them.

    A point body lies on a rigid trough, with Coulomb friction and stiction between the two. The trough moves

    * along a line: ``amplitude * sin(2 pi frequency t)`` in the direction ``drive_angle``;
    * along an ellipse: ``along_amplitude * sin(2 pi frequency t)`` along its surface and ``normal_amplitude *
      sin(2 pi frequency t + normal_phase)`` normal to it;
    * or as a ``motion`` prescribes.

    Give exactly one of these drives. Fields broadcast against each other like the arguments of a NumPy ufunc.
    They are copied, converted to ``float64`` and made read-only.

    Parameters
    ----------
    amplitude : array_like
        Amplitude of the motion along a line, half of the stroke, > 0 [m].
    drive_angle : array_like
        Angle of the line above the trough's surface, in [0, pi/2) [rad].
    along_amplitude, normal_amplitude : array_like
        Amplitudes of the elliptical motion, along the trough (positive in the conveying direction) and normal
        to it (positive upwards), >= 0 [m].
    normal_phase : array_like, optional
        Phase lead of the normal motion over the motion along the trough, modulo 2 pi [rad]. For other
        conventions see theory, section 15.
    along_harmonics, normal_harmonics : sequence of pair of array_like
        Up to 16 pairs of an amplitude [m] and a phase [rad] of the harmonics ``amplitude * sin(2 pi n
        frequency t + phase)``, n = 1 first. One of the two may be left out. Short for
        ``motion=Motion.harmonics(along, normal)``.
    motion : Motion
        Any periodic motion: harmonics, steps, samples or a measured motion.
    motion_scale : array_like, optional
        Factor by which the amplitudes or accelerations of a ``motion`` are multiplied, > 0 [1].
    normal_acceleration : array_like, optional
        For a body that is clamped to the trough: constant normal force over the body's mass, > 0 [m/s^2]. The
        trough then moves along itself only, and may be vertical; the normal component of gravity is ignored.
    frequency : array_like
        Drive frequency, > 0 [Hz].
    static_friction, kinetic_friction : array_like
        Coefficients of friction mu_s and mu_d, ``0 <= mu_d <= mu_s`` [1].
    trough_angle : array_like, optional
        Inclination of the trough, positive if it rises in the conveying direction, in (-pi/2, pi/2), with a
        clamped body in [-pi/2, pi/2] [rad].
    gravity : array_like, optional
        Acceleration of gravity, > 0 [m/s^2].
    restitution : array_like, optional
        Normal coefficient of restitution of an impact, in [0, 1) [1].

    Raises
    ------
    SceneError
        If a field or a combination of fields is out of range, or not exactly one drive is given; the message
        lists every problem.

    Examples
    --------
    >>> import math
    >>> Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...       static_friction=0.74, kinetic_friction=0.57).shape
    ()
    >>> Scene(along_amplitude=1e-3, normal_amplitude=3e-4, normal_phase=[-1.0, 0.0, 1.0],
    ...       frequency=25, static_friction=0.4, kinetic_friction=0.3).shape
    (3,)
    >>> sawtooth = Motion.steps(along=[(0.8, 2.4), (0.2, -9.6)])
    >>> Scene(motion=sawtooth, motion_scale=[0.5, 1.0], frequency=2.5,
    ...       static_friction=0.3, kinetic_friction=0.25).load.round(3)
    array([0.489, 0.979])
    """

    amplitude: Floats | None
    frequency: Floats
    drive_angle: Floats | None
    along_amplitude: Floats | None
    normal_amplitude: Floats | None
    normal_phase: Floats | None
    motion: Motion | None
    motion_scale: Floats | None
    normal_acceleration: Floats | None
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats
    gravity: Floats
    restitution: Floats

    @shielded
    def __init__(
        self,
        *,
        amplitude: ArrayLike | None = None,
        frequency: ArrayLike,
        drive_angle: ArrayLike | None = None,
        along_amplitude: ArrayLike | None = None,
        normal_amplitude: ArrayLike | None = None,
        normal_phase: ArrayLike | None = None,
        along_harmonics: ArrayLike | Iterable[tuple[ArrayLike, ArrayLike]] | None = None,
        normal_harmonics: ArrayLike | Iterable[tuple[ArrayLike, ArrayLike]] | None = None,
        motion: Motion | ArrayLike | None = None,
        motion_scale: ArrayLike | None = None,
        normal_acceleration: ArrayLike | None = None,
        static_friction: ArrayLike,
        kinetic_friction: ArrayLike,
        trough_angle: ArrayLike = 0.0,
        gravity: ArrayLike = STANDARD_GRAVITY,
        restitution: ArrayLike = 0.0,
    ) -> None:
        self._set(locals())
        if problems := self._field_problems() + self._combination_problems():
            raise SceneError(tuple(problems))

    def _table(self) -> tuple[str, list[tuple[str, str]], tuple[()]]:
        """Return the fields in the units of scene files."""
        rows: list[tuple[str, str]] = []
        seen: dict[str, int] = {}
        for field, name, x in self.arrays().members():
            quantity = QUANTITIES[name]
            label = quantity.label
            if field != name:  # one of several harmonics, along the trough or normal to it
                size = "amplitude" if "amplitude" in name else "phase"
                seen[field + size] = seen.get(field + size, 0) + 1
                label = f"{field.partition('_')[0]} {size} {seen[field + size]}"
            rows.append((label, span(quantity.from_si(x), quantity.unit)))
        if isinstance(self.motion, PiecewiseMotion):
            pieces = len(self.motion.breaks) - 1
            largest = span(self.motion.largest_acceleration, QUANTITIES["gravity"].unit)
            rows.insert(0, ("motion", f"{pieces} pieces, at most {largest}"))
        caption = " x ".join(map(str, self.shape)) + " scenes" if self.shape else "scene"
        return caption, rows, ()

    @classmethod
    @shielded
    def allowing_infeasible(cls, **values: ArrayLike) -> Scene:
        """Make a scene that may contain infeasible combinations of valid values (mu_d > mu_s).

        A grid over both coefficients of friction contains such combinations; ``solve`` gives these cells the
        status ``INFEASIBLE`` and no numbers.

        Parameters
        ----------
        **values
            As for ``Scene``.

        Returns
        -------
        Scene
            ``Scene.infeasible`` marks the infeasible combinations.

        Raises
        ------
        SceneError
            If a value is out of its range, or the shapes do not broadcast.

        Examples
        --------
        >>> scene = Scene.allowing_infeasible(amplitude=1e-3, frequency=15, drive_angle=0.35,
        ...                                   static_friction=0.4, kinetic_friction=[0.3, 0.5])
        >>> scene.infeasible.tolist()
        [False, True]
        """
        scene = cls.computed(**values)
        if problems := scene._field_problems():
            raise SceneError(tuple(problems))
        return scene

    @classmethod
    def computed(cls, **values: Any) -> Scene:
        """Return the same of values that a search computes: it may go beyond what users may give."""
        scene = cls.__new__(cls)
        scene._set({**_SI_DEFAULTS, **values})
        return scene

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape to which the fields broadcast."""
        return self.arrays().shape

    @property
    @shielded
    def load(self) -> Floats:
        """Load G: largest acceleration of the trough over gravity; A w^2 / g along a line [1].

        With harmonics the maximum is searched numerically: where two local maxima agree to within 1e-6, the
        lower one may be returned.
        """
        with np.errstate(over="ignore", invalid="ignore"):  # inf, or NaN, beyond the range of doubles
            w = 2.0 * np.pi * self.frequency
            return np.asarray(self.arrays().acceleration_reach * w**2 / self.gravity)

    @property
    @shielded
    def scale(self) -> Floats:
        """Unit of length of the solver: the amplitude, or the largest of several amplitudes [m]."""
        return self.arrays().scale

    @property
    @shielded
    def reach(self) -> Floats:
        """Largest distance of the trough from its mean position: A, or an ellipse's larger semi-axis [m]."""
        return self.arrays().reach

    def arrays(self) -> Fields:
        """Return the fields as a named tuple of the drive's kind, for the solver.

        Returns
        -------
        Line, Ellipse, Harmonics or Piecewise
            Fields in SI units, not broadcast.
        """
        if self.motion is not None:
            return _kind_of_motion(self.motion).of(self)
        return (Ellipse if self.amplitude is None else Line).of(self)

    @property
    def along_harmonics(self) -> Pairs | None:
        """Pairs of amplitude [m] and phase [rad] along the trough; None unless the motion is harmonics."""
        return self.motion.along if isinstance(self.motion, HarmonicMotion) else None

    @property
    def normal_harmonics(self) -> Pairs | None:
        """Pairs of amplitude [m] and phase [rad] normal to it; None unless the motion is harmonics."""
        return self.motion.normal if isinstance(self.motion, HarmonicMotion) else None

    def flat(self) -> Fields:
        """Return the fields broadcast and flattened, for the solver.

        Returns
        -------
        Line, Ellipse, Harmonics or Piecewise
            1-D arrays with one value per cell, the last axis fastest.
        """
        shape = self.shape
        return self.arrays().changed(lambda x: np.broadcast_to(x, shape).reshape(-1))

    @property
    def infeasible(self) -> NDArray[np.bool_]:
        """Whether mu_d > mu_s in each cell, which is impossible; bool array of the scene's shape."""
        return np.broadcast_to(self.kinetic_friction > self.static_friction, self.shape)

    def _set(self, values: dict[str, Any]) -> None:
        """Copy the values of the drive's kind; those of others are None."""
        kind, problems = _kind_of(values), []
        for name in self.__dataclass_fields__:
            x = values.get(name) if name in kind._fields else None
            is_left_out = name == "motion" or (name == "normal_acceleration" and x is None)
            if name in kind._fields and not is_left_out:
                try:
                    x = real_array(x)
                except NotRealError as exc:
                    problems.append(Problem(name, exc.value, exc.allowed))
                    continue
                x.flags.writeable = False
                if name == "normal_acceleration" and np.isnan(x).any():  # NaN means none in the solver
                    problems.append(Problem(name, field_text(name, math.nan), field_range(name)))
            object.__setattr__(self, name, x)
        if problems:
            raise SceneError(tuple(problems))
        try:
            _ = self.shape
        except ValueError:
            shapes = ", ".join(f"{name} {x.shape}" for name, _, x in self.arrays().members())
            allowed = "broadcastable against each other, like a ufunc's arguments"
            raise SceneError.of("shapes", shapes, allowed) from None

    def _field_problems(self) -> list[Problem]:
        problems = []
        is_clamped = self.normal_acceleration is not None
        for field, name, x in self.arrays().members():
            quantity = of_part(QUANTITIES[name], is_clamped=is_clamped)
            if not x.ndim:  # plain numbers take a tenth of the time
                number = float(x)
                wrong = [] if math.isfinite(number) and quantity.allows(number) else [number]
            else:
                wrong = x[~(np.isfinite(x) & quantity.allows(x))][:1].tolist()
            for value in wrong:
                problems.append(Problem(field, field_text(name, value), quantity.range_text))
        if self.normal_acceleration is not None and self.arrays().moves_normal:
            force = field_text("normal_acceleration", float(np.ravel(self.normal_acceleration)[0]))
            allowed = "left out where the trough moves normal to itself, as then the force on a part changes"
            problems.append(Problem("normal_acceleration", force, allowed))
        return problems

    def _combination_problems(self) -> list[Problem]:
        bad = np.asarray(self.kinetic_friction > self.static_friction)
        if not bad.any():
            return []
        mu_d, mu_s = (np.broadcast_to(x, bad.shape) for x in (self.kinetic_friction, self.static_friction))
        limit = f"<= static_friction = {mu_s[bad].flat[0]:.15g}"
        return [Problem("kinetic_friction", f"{mu_d[bad].flat[0]:.15g}", limit)]


def check_single(scene: Scene) -> None:
    """Raise SceneError unless a scene is one operating point."""
    if scene.shape:
        raise SceneError.of("scene", f"shape {scene.shape}", "one operating point, of shape ()")


_SI_DEFAULTS: Final = {name: QUANTITIES[name].to_si(value) for name, value in DEFAULTS.items()}


def values_of(scene: Scene) -> dict[str, float]:
    """Return the quantities of a single scene in the units outside, those of each harmonic too."""
    values = {
        name: float(QUANTITIES[name].from_si(value))
        for name, value in vars(scene).items()
        if name in QUANTITIES and value is not None
    }
    return values | (harmonic_values(scene.motion) if isinstance(scene.motion, HarmonicMotion) else {})


def harmonic_values(motion: HarmonicMotion) -> dict[str, float]:
    """Return the quantities of harmonics that samples were fitted by, in the units outside."""
    return {
        name: float(QUANTITIES[name].from_si(value))
        for way, pairs in (("along", motion.along), ("normal", motion.normal))
        for n, pair in enumerate(pairs, 1)
        for of, value in zip((f"{way}_amplitude", f"{way}_phase"), pair, strict=True)
        for name in [of if n == 1 else f"{of}_{n}"]
    }
