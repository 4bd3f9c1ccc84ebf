"""Operating points of a vibratory conveyor, in SI units and radians."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from vibro.errors import Problem, SceneError

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

__all__ = ["STANDARD_GRAVITY", "Scene"]

STANDARD_GRAVITY = 9.81  # [m/s^2], the value of the paper and of all published figures here

# field, in declared order -> (unit for messages, allowed range in words, test of each finite value)
_RULES: dict[str, tuple[str, str, Callable[[Any], Any]]] = {
    "amplitude": ("m", "finite and > 0 m", lambda x: x > 0),
    "frequency": ("Hz", "finite and > 0 Hz", lambda x: x > 0),
    "drive_angle": ("rad", "in [0, 90) deg", lambda x: (x >= 0) & (x < math.pi / 2)),
    "static_friction": ("", "finite and >= 0", lambda x: x >= 0),
    "kinetic_friction": ("", "finite and >= 0", lambda x: x >= 0),
    "trough_angle": ("rad", "in (-90, 90) deg", lambda x: (x > -math.pi / 2) & (x < math.pi / 2)),
    "gravity": ("m/s^2", "finite and > 0 m/s^2", lambda x: x > 0),
    "restitution": ("", "in [0, 1)", lambda x: (x >= 0) & (x < 1)),
}


def _text(value: float, unit: str) -> str:
    """Write a value with its unit; angles in degrees too."""
    number = f"{value:.15g}"
    if unit == "rad":
        return f"{number} rad ({math.degrees(value):.6g} deg)"
    return f"{number} {unit}".rstrip()


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
        scene._set({"trough_angle": 0.0, "gravity": STANDARD_GRAVITY, "restitution": 0.0, **values})
        if problems := scene._field_problems():
            raise SceneError(tuple(problems))
        return scene

    @property
    def shape(self) -> tuple[int, ...]:
        """Common shape of the fields."""
        return np.broadcast(*self.arrays()).shape

    def arrays(self) -> tuple[Floats, ...]:
        """Return the fields in their declared order."""
        return tuple(getattr(self, name) for name in _RULES)

    def _set(self, values: dict[str, Any]) -> None:
        problems = []
        for f in fields(self):
            try:
                x = np.array(values[f.name], dtype=np.float64)
            except (TypeError, ValueError):
                problems.append(Problem(f.name, repr(values[f.name]), "a number or an array of numbers"))
                continue
            x.flags.writeable = False
            object.__setattr__(self, f.name, x)
        if problems:
            raise SceneError(tuple(problems))
        try:
            _ = self.shape
        except ValueError:
            shapes = ", ".join(f"{f.name} {getattr(self, f.name).shape}" for f in fields(self))
            problem = Problem("shapes", shapes, "broadcastable against each other, like a ufunc's arguments")
            raise SceneError((problem,)) from None

    def _field_problems(self) -> list[Problem]:
        problems = []
        for name, (unit, allowed, rule) in _RULES.items():
            x = getattr(self, name)
            good = np.isfinite(x) & rule(x)
            if np.count_nonzero(good) < x.size:
                problems.append(Problem(name, _text(float(x[~good].flat[0]), unit), allowed))
        return problems

    def _combination_problems(self) -> list[Problem]:
        problems = []
        bad = self.kinetic_friction > self.static_friction
        if np.count_nonzero(bad):
            mu_d, mu_s = (
                np.broadcast_to(x, bad.shape) for x in (self.kinetic_friction, self.static_friction)
            )
            limit = f"<= static_friction = {mu_s[bad].flat[0]:.15g}"
            problems.append(Problem("kinetic_friction", f"{mu_d[bad].flat[0]:.15g}", limit))
        with np.errstate(over="ignore", invalid="ignore"):  # of angles that are no angles
            bad = self.drive_angle + self.trough_angle >= math.pi / 2
        if np.count_nonzero(bad):
            drive, trough = (np.broadcast_to(x, bad.shape) for x in (self.drive_angle, self.trough_angle))
            valid = (drive >= 0) & (drive < math.pi / 2) & (np.abs(trough) < math.pi / 2)  # each alone
            bad &= valid
        if np.count_nonzero(bad):
            limit = f"less than 90 deg together with trough_angle = {_text(trough[bad].flat[0], 'rad')}"
            problems.append(Problem("drive_angle", _text(drive[bad].flat[0], "rad"), limit))
        return problems
