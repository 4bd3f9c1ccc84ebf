"""Operating points of a vibratory conveyor, in SI units and radians."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.harmonic.arrays import each
from vibro.drives import KINDS, Ellipse, Harmonics, Line, read_harmonics
from vibro.errors import Problem, SceneError
from vibro.quantities import DEFAULTS, QUANTITIES, STANDARD_GRAVITY
from vibro.reals import NotRealError, real_array

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike, NDArray

    from vibro.drives import Pairs

    Floats = NDArray[np.float64]

__all__ = ["Fields", "Scene", "field_range", "field_text"]


Fields = Line | Ellipse | Harmonics

_EITHER: Final = (
    "either amplitude and drive_angle, or along_amplitude and normal_amplitude, or along_harmonics and"
    " normal_harmonics"
)


def field_text(name: str, value: float) -> str:
    """Write a value with its unit; angles in degrees too."""
    quantity = QUANTITIES[name]
    number = f"{value:.15g} {quantity.kind.si_unit}".rstrip()
    if quantity.kind.si_unit == "rad":
        return f"{number} ({math.degrees(value):.6g} deg)"
    return number


def field_range(name: str) -> str:
    """Return the allowed range of a field as text, angles in degrees."""
    kind = QUANTITIES[name].kind
    return QUANTITIES[name].allowed.text("deg" if kind.si_unit == "rad" else kind.si_unit)


def _kind_of(values: dict[str, Any]) -> type[Fields]:
    """Return the kind of drive that is given, and fill in fields that may be left out."""
    given = {kind: [n for n in kind.told_by if values.get(n) is not None] for kind in KINDS}
    kinds = [kind for kind, names in given.items() if names]
    if len(kinds) != 1:
        named = " and ".join(name for names in given.values() for name in names) or "none"
        raise SceneError((Problem("drive", named, _EITHER),))
    (kind,) = kinds
    may_miss = {"normal_phase": 0.0, "along_harmonics": (), "normal_harmonics": ()}
    for name in kind.told_by:
        if values.get(name) is None and name in may_miss:
            values[name] = may_miss[name]
    missing = [name for name in kind.told_by if values.get(name) is None]
    if missing:
        beside = f"given beside {given[kind][0]}"
        raise SceneError(tuple(Problem(name, "None", beside) for name in missing))
    return kind


@dataclass(frozen=True, eq=False, init=False)
class Scene:
    """One operating point, a line of them, or a whole grid.

    The fields broadcast against each other like the arguments of a NumPy ufunc. They are
    copied, converted to ``float64`` and made read-only. A point body lies on a rigid trough;
    Coulomb friction with stiction acts between the two. The trough moves either along a line, as
    ``amplitude * sin(2 pi frequency t)`` in the direction ``drive_angle``, or along an ellipse, as
    ``along_amplitude * sin(2 pi frequency t)`` along its surface and
    ``normal_amplitude * sin(2 pi frequency t + normal_phase)`` normal to it.

    Parameters
    ----------
    amplitude : array_like
        Amplitude of a motion along a line, half of its stroke, > 0 [m].
    drive_angle : array_like
        Angle of that line above the trough's surface, in [0, pi/2) [rad].
    along_amplitude, normal_amplitude : array_like
        Amplitudes of an elliptical motion, in place of the former two: along the trough, positive in the
        conveying direction, and normal to it, positive upwards; >= 0 [m].
    normal_phase : array_like, optional
        Phase by which the normal motion leads the motion along the trough, modulo 2 pi [rad]. Others count
        the lag, or from the normal motion: theory.md, section 15.
    along_harmonics, normal_harmonics : sequence of pair of array_like
        In place of all these, up to 8 pairs of an amplitude [m] and a phase [rad], of a motion with harmonics
        ``amplitude * sin(2 pi n frequency t + phase)``, n = 1 first; either may be left out.
    frequency : array_like
        Drive frequency, > 0 [Hz].
    static_friction, kinetic_friction : array_like
        Coefficients of friction mu_s and mu_d, ``0 <= mu_d <= mu_s`` [1].
    trough_angle : array_like, optional
        Climb of the trough in the conveying direction, in (-pi/2, pi/2) [rad].
    gravity : array_like, optional
        Acceleration of gravity, > 0 [m/s^2].
    restitution : array_like, optional
        Normal coefficient of restitution of an impact, in [0, 1) [1].

    Raises
    ------
    SceneError
        If a field or a combination of fields is out of range, or not exactly one drive is given; it lists
        every problem.

    Examples
    --------
    >>> import math
    >>> Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...       static_friction=0.74, kinetic_friction=0.57).shape
    ()
    >>> Scene(along_amplitude=1e-3, normal_amplitude=3e-4, normal_phase=[-1.0, 0.0, 1.0],
    ...       frequency=25, static_friction=0.4, kinetic_friction=0.3).shape
    (3,)
    """

    amplitude: Floats | None
    frequency: Floats
    drive_angle: Floats | None
    along_amplitude: Floats | None
    normal_amplitude: Floats | None
    normal_phase: Floats | None
    along_harmonics: Pairs | None
    normal_harmonics: Pairs | None
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats
    gravity: Floats
    restitution: Floats

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
        static_friction: ArrayLike,
        kinetic_friction: ArrayLike,
        trough_angle: ArrayLike = 0.0,
        gravity: ArrayLike = STANDARD_GRAVITY,
        restitution: ArrayLike = 0.0,
    ) -> None:
        self._set(locals())
        if problems := self._field_problems() + self._combination_problems():
            raise SceneError(tuple(problems))

    @classmethod
    def allowing_infeasible(cls, **values: ArrayLike) -> Scene:
        """Make a scene whose fields are valid but whose combinations may be infeasible.

        A sweep over both coefficients of friction crosses combinations that cannot be (mu_d > mu_s).
        ``solve`` gives those cells the status ``INFEASIBLE`` and no numbers.

        Parameters
        ----------
        **values
            As for ``Scene``.

        Raises
        ------
        SceneError
            If a field alone is out of its range, or the shapes do not broadcast.
        """
        scene = cls.__new__(cls)
        scene._set({**_SI_DEFAULTS, **values})
        if problems := scene._field_problems():
            raise SceneError(tuple(problems))
        return scene

    @property
    def shape(self) -> tuple[int, ...]:
        """Common shape of the fields."""
        return self.arrays().shape

    @property
    def load(self) -> Floats:
        """Largest acceleration of the trough over gravity, G; A w^2 / g along a line [1].

        With harmonics the largest maximum along the path is searched: of two maxima that agree to within 1e-6
        it may be the lower one.
        """
        with np.errstate(over="ignore", invalid="ignore"):  # inf, or NaN, beyond the range of doubles
            w = 2.0 * np.pi * self.frequency
            return np.asarray(self.arrays().acceleration_reach * w**2 / self.gravity)

    @property
    def scale(self) -> Floats:
        """Unit of length of the solvers: A, or the largest of all amplitudes [m]."""
        return self.arrays().scale

    @property
    def reach(self) -> Floats:
        """Largest distance of the trough from its middle: A, or the ellipse's larger semi-axis [m]."""
        return self.arrays().reach

    def arrays(self) -> Fields:
        """Return the fields of this scene's drive, in their declared order."""
        return next(kind for kind in KINDS if getattr(self, kind.told_by[0]) is not None).of(self)

    def flat(self) -> Fields:
        """Return the fields as 1-D arrays over all scenes, in the order of their cells."""
        shape = self.shape
        flat: Fields = each(self.arrays(), lambda x: np.broadcast_to(x, shape).reshape(-1))
        return flat

    @property
    def infeasible(self) -> NDArray[np.bool_]:
        """Whether each combination of frictions is impossible: mu_d > mu_s."""
        return np.broadcast_to(self.kinetic_friction > self.static_friction, self.shape)

    def _set(self, values: dict[str, Any]) -> None:
        kind, problems = _kind_of(values), []
        is_given = {*kind.told_by, *kind._fields}
        for name in self.__dataclass_fields__:
            x: Any = None
            if name in Harmonics.told_by and name in is_given:
                x, wrong = read_harmonics(name, values[name])
                problems += wrong
            elif name in is_given:
                try:
                    x = real_array(values[name])
                except NotRealError as exc:
                    problems.append(Problem(name, exc.value, exc.allowed))
                    continue
                x.flags.writeable = False
            object.__setattr__(self, name, x)
        if kind is Harmonics and not (problems or self.along_harmonics or self.normal_harmonics):
            problems.append(Problem("along_harmonics", "none", "at least one pair, or normal_harmonics"))
        if problems:
            raise SceneError(tuple(problems))
        try:
            _ = self.shape
        except ValueError:
            shapes = ", ".join(f"{name} {x.shape}" for name, _, x in self.arrays().members())
            problem = Problem("shapes", shapes, "broadcastable against each other, like a ufunc's arguments")
            raise SceneError((problem,)) from None

    def _field_problems(self) -> list[Problem]:
        problems = []
        for field, name, x in self.arrays().members():
            if not x.ndim:  # plain numbers take a tenth of the time
                number = float(x)
                if not (math.isfinite(number) and QUANTITIES[name].allows(number)):
                    problems.append(Problem(field, field_text(name, number), field_range(name)))
                continue
            good = np.isfinite(x) & QUANTITIES[name].allows(x)
            if np.count_nonzero(good) < x.size:
                problems.append(Problem(field, field_text(name, float(x[~good].flat[0])), field_range(name)))
        return problems

    def _combination_problems(self) -> list[Problem]:
        bad = np.asarray(self.kinetic_friction > self.static_friction)
        if not bad.any():
            return []
        mu_d, mu_s = (np.broadcast_to(x, bad.shape) for x in (self.kinetic_friction, self.static_friction))
        limit = f"<= static_friction = {mu_s[bad].flat[0]:.15g}"
        return [Problem("kinetic_friction", f"{mu_d[bad].flat[0]:.15g}", limit)]


_SI_DEFAULTS: Final = {name: QUANTITIES[name].to_si(value) for name, value in DEFAULTS.items()}
