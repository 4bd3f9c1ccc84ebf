"""Operating points of a vibratory conveyor, in SI units and radians."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.core.groups import Loads, angle_excess, friction_excess, loads
from vibro.errors import Problem, SceneError
from vibro.quantities import DEFAULTS, QUANTITIES, STANDARD_GRAVITY
from vibro.reals import NotRealError, real_array

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

__all__ = ["Fields", "Scene", "field_range", "field_text"]


class Fields(NamedTuple):
    """The fields of a scene, in their declared order, [m, Hz, rad, 1, 1, rad, m/s^2, 1]."""

    amplitude: Floats
    frequency: Floats
    drive_angle: Floats
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats
    gravity: Floats
    restitution: Floats

    def loads(self) -> Loads:
        """Form the dimensionless groups, all but the restitution."""
        return loads(*self[:-1])


_NAMES: Final = Fields._fields


def field_text(name: str, value: float) -> str:
    """Write a value with its unit; angles in degrees too."""
    quantity = QUANTITIES[name]
    number = f"{value:.15g} {quantity.kind.si_unit}".rstrip()
    if quantity.kind.si_unit == "rad":
        return f"{number} ({math.degrees(value):.6g} deg)"
    return number


def field_range(name: str) -> str:
    """Say what a field may be, angles in degrees."""
    kind = QUANTITIES[name].kind
    return QUANTITIES[name].allowed.text("deg" if kind.si_unit == "rad" else kind.si_unit)


@dataclass(frozen=True, eq=False, init=False)
class Scene:
    """One operating point, a line of them, or a whole grid.

    The fields broadcast against each other like the arguments of a NumPy ufunc. They are
    copied, converted to ``float64`` and made read-only. A point body lies on a rigid trough that
    moves as ``amplitude * sin(2 pi frequency t)`` along a line ``drive_angle`` above the trough's
    surface; Coulomb friction with stiction acts between the two.

    Parameters
    ----------
    amplitude : array_like
        Amplitude of the trough's motion, half of its stroke, > 0 [m].
    frequency : array_like
        Drive frequency, > 0 [Hz].
    drive_angle : array_like
        Angle of the drive's line above the trough's surface, in [0, pi/2) [rad].
    static_friction, kinetic_friction : array_like
        Coefficients of friction mu_s and mu_d, ``0 <= mu_d <= mu_s`` [1].
    trough_angle : array_like, optional
        Climb of the trough in the conveying direction, in (-pi/2, pi/2), and
        ``drive_angle + trough_angle < pi/2`` [rad].
    gravity : array_like, optional
        Acceleration of gravity, > 0 [m/s^2].
    restitution : array_like, optional
        Normal coefficient of restitution of an impact, in [0, 1) [1].

    Raises
    ------
    SceneError
        If a field, or a combination of fields, is out of its range; it lists all that is wrong.

    Examples
    --------
    >>> import math
    >>> Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20),
    ...       static_friction=0.74, kinetic_friction=0.57).shape
    ()
    """

    amplitude: Floats
    frequency: Floats
    drive_angle: Floats
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats
    gravity: Floats
    restitution: Floats

    def __init__(
        self,
        *,
        amplitude: ArrayLike,
        frequency: ArrayLike,
        drive_angle: ArrayLike,
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

        A sweep over both coefficients of friction, or over both angles, crosses combinations that
        cannot be (mu_d > mu_s; drive + trough angle of 90 deg or more). ``solve`` gives those cells
        the status ``INFEASIBLE`` and no numbers.

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
        return np.broadcast(*self.arrays()).shape

    @property
    def load(self) -> Floats:
        """Peak acceleration of the drive over gravity, G = A w^2 / g [1]."""
        with np.errstate(over="ignore", invalid="ignore"):  # inf, or NaN, beyond the range of doubles
            w = 2.0 * np.pi * self.frequency
            return np.asarray(self.amplitude * w**2 / self.gravity)

    def arrays(self) -> Fields:
        """Return the fields in their declared order."""
        return Fields(*(getattr(self, name) for name in _NAMES))

    def flat(self) -> Fields:
        """Return the fields as 1-D arrays over all scenes, in the order of their cells."""
        shape = self.shape
        return Fields(*(np.broadcast_to(x, shape).reshape(-1) for x in self.arrays()))

    @property
    def infeasible(self) -> NDArray[np.bool_]:
        """Whether each combination cannot be: mu_d > mu_s, or drive + trough angle of 90 deg or more."""
        friction = friction_excess(self.static_friction, self.kinetic_friction) > 0.0
        angles = angle_excess(self.drive_angle, self.trough_angle) >= 0.0
        return np.broadcast_to(friction | angles, self.shape)

    def _set(self, values: dict[str, Any]) -> None:
        problems = []
        for name in _NAMES:
            try:
                x = real_array(values[name])
            except NotRealError as exc:
                problems.append(Problem(name, exc.value, exc.allowed))
                continue
            x.flags.writeable = False
            object.__setattr__(self, name, x)
        if problems:
            raise SceneError(tuple(problems))
        try:
            _ = self.shape
        except ValueError:
            shapes = ", ".join(f"{name} {getattr(self, name).shape}" for name in _NAMES)
            problem = Problem("shapes", shapes, "broadcastable against each other, like a ufunc's arguments")
            raise SceneError((problem,)) from None

    def _field_problems(self) -> list[Problem]:
        problems = []
        for name, x in zip(_NAMES, self.arrays(), strict=True):
            good = np.isfinite(x) & QUANTITIES[name].allows(x)
            if np.count_nonzero(good) < x.size:
                problems.append(Problem(name, field_text(name, float(x[~good].flat[0])), field_range(name)))
        return problems

    def _combination_problems(self) -> list[Problem]:
        problems = []
        bad = friction_excess(self.static_friction, self.kinetic_friction) > 0.0
        if np.count_nonzero(bad):
            mu_d, mu_s = (
                np.broadcast_to(x, bad.shape) for x in (self.kinetic_friction, self.static_friction)
            )
            limit = f"<= static_friction = {mu_s[bad].flat[0]:.15g}"
            problems.append(Problem("kinetic_friction", f"{mu_d[bad].flat[0]:.15g}", limit))
        with np.errstate(over="ignore", invalid="ignore"):  # of angles that are no angles
            bad = angle_excess(self.drive_angle, self.trough_angle) >= 0.0
        if np.count_nonzero(bad):  # what is wrong with either alone has been said
            drive, trough = (np.broadcast_to(x, bad.shape) for x in (self.drive_angle, self.trough_angle))
            bad &= QUANTITIES["drive_angle"].allows(drive) & QUANTITIES["trough_angle"].allows(trough)
        if np.count_nonzero(bad):
            beside = field_text("trough_angle", trough[bad].flat[0])
            limit = f"less than 90 deg together with trough_angle = {beside}"
            problems.append(Problem("drive_angle", field_text("drive_angle", drive[bad].flat[0]), limit))
        return problems


_SI_DEFAULTS: Final = {name: QUANTITIES[name].to_si(value) for name, value in DEFAULTS.items()}
