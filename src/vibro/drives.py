"""The kinds of drive as small values: along a line, along an ellipse, with harmonics.

Each kind defines its fields, its reach, the columns that the solver reads, and its abilities. Callers ask a
scene for an ability and never for its kind, so that a new kind is added here alone.
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple, Self, cast

import numpy as np

from vibro.core.harmonic.arrays import largest_amplitude
from vibro.core.harmonic.loads import HarmonicLoads, harmonic_loads
from vibro.errors import InputError, Problem, shown
from vibro.quantities import ELLIPTICAL, LINEAR, MOST_HARMONICS
from vibro.reals import NotRealError, real_array

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Pairs = tuple[tuple[Floats, Floats], ...]

__all__ = ["KINDS", "Ability", "Columns", "Drive", "Ellipse", "Harmonics", "Line", "read_harmonics"]

_ONE: Final = np.ones(())
_POINTS: Final = 64  # points of the path per harmonic, which bracket the farthest one
_STEPS: Final = 6  # of Newton's method from there; each squares the error, which begins at 1e-3
_ALLOWED: Final = f"up to {MOST_HARMONICS} pairs of an amplitude and a phase"


class Ability(Enum):
    """Results that only some kinds of drive have; every kind has a steady cycle in contact."""

    FLIGHT = "flights, histories and critical loads"
    PROOF = "closed forms and proved bounds"


class Columns(NamedTuple):
    """A scene as the solver reads it: its fields, its kind, and the pieces of its acceleration."""

    fields: tuple[Floats, ...]
    kind: int
    breaks: Floats = np.zeros(1)
    pieces: Floats = np.zeros(1)


class Drive:
    """Base class of all kinds of drive.

    Attributes
    ----------
    kind : str
        Its motion, in the words of messages.
    told_by : tuple of str
        Fields of a scene that distinguish this kind from the others.
    abilities : frozenset of Ability
        Results that can be computed for it.
    """

    kind: ClassVar[str]
    told_by: ClassVar[tuple[str, ...]]
    abilities: ClassVar[frozenset[Ability]]

    @classmethod
    def of(cls, scene: Any) -> Self:
        """Return the fields of a scene that has this kind of drive."""
        return cls(*(getattr(scene, name) for name in _names(cls)))

    def can(self, ability: Ability) -> bool:
        """Return whether this kind of drive has an ability."""
        return ability in self.abilities

    def require(self, ability: Ability, hint: str = "") -> None:
        """Raise unless this kind of drive has an ability.

        Raises
        ------
        InputError
            If it lacks the ability; the message names the kinds of drive that have it.
        """
        if ability not in self.abilities:
            raise self._refusal(ability, hint)

    def _refusal(self, ability: Ability, hint: str = "") -> InputError:
        able = " or ".join(kind.kind for kind in KINDS if ability in kind.abilities)
        hint = hint or "vibro.solve and vibro.sweep, vibro solve and vibro map give its cycle in contact"
        return InputError(f"a drive {self.kind}: {ability.value} are known of drives {able} alone", hint=hint)

    @property
    def shape(self) -> tuple[int, ...]:
        """Common shape of the fields."""
        return np.broadcast(*cast("Iterable[Floats]", self)).shape

    @property
    def reach(self) -> Floats:
        """Largest distance of the trough from its middle position [m]."""
        raise NotImplementedError

    @property
    def acceleration_reach(self) -> Floats:
        """Amplitude of a motion along a line with the same largest acceleration [m]."""
        return self.reach

    @property
    def stroke(self) -> Floats:
        """Largest distance between two points of the path [m]."""
        return 2.0 * self.reach

    @property
    def along(self) -> Floats:
        """Amplitude of the motion along the trough [m]; InputError without FLIGHT."""
        raise self._refusal(Ability.FLIGHT)

    @property
    def phase(self) -> Floats:
        """Phase by which the normal motion leads that along the trough [rad]; InputError without FLIGHT."""
        raise self._refusal(Ability.FLIGHT)

    def columns(self) -> Columns:
        """Return the columns that the solver reads; raise InputError without ``Ability.FLIGHT``."""
        raise self._refusal(Ability.FLIGHT)

    def at_any_load(self) -> Self:
        """Replace fields that critical loads do not depend on by scalars; InputError without FLIGHT."""
        raise self._refusal(Ability.FLIGHT)

    def members(self) -> list[tuple[str, str, Floats]]:
        """Return each array, after the names of its field and of a quantity with its unit and range."""
        return [(name, name, getattr(self, name)) for name in _names(self)]


def _names(fields: Any) -> tuple[str, ...]:
    return tuple(fields._fields)


class _LineFields(NamedTuple):
    amplitude: Floats
    frequency: Floats
    drive_angle: Floats
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats
    gravity: Floats
    restitution: Floats


class Line(_LineFields, Drive):
    """A drive along a line: its scene's fields, [m, Hz, rad, 1, 1, rad, m/s^2, 1]."""

    __slots__ = ()
    kind = "along a line"
    told_by = LINEAR
    abilities = frozenset(Ability)

    @property
    def scale(self) -> Floats:
        """Unit of length of the solvers: A [m]."""
        return self.amplitude

    @property
    def reach(self) -> Floats:
        """Largest distance of the trough from its middle position [m]."""
        return self.amplitude

    @property
    def along(self) -> Floats:
        """Amplitude of the motion along the trough [m]."""
        return np.asarray(self.amplitude * np.cos(self.drive_angle))

    @property
    def phase(self) -> Floats:
        """Phase by which the normal motion leads the motion along the trough [rad]."""
        return np.zeros(())

    def columns(self) -> Columns:
        """Return the columns that the solver reads."""
        return Columns((self.amplitude, self.drive_angle, _ONE, *self[1:2], *self[3:]), 0)

    def at_any_load(self) -> Self:
        """Replace the fields that critical loads do not depend on by scalars, to keep their shapes out."""
        return self._replace(amplitude=_ONE, frequency=_ONE, gravity=_ONE, restitution=_ONE - _ONE)


class _EllipseFields(NamedTuple):
    along_amplitude: Floats
    normal_amplitude: Floats
    normal_phase: Floats
    frequency: Floats
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats
    gravity: Floats
    restitution: Floats


class Ellipse(_EllipseFields, Drive):
    """A drive along an ellipse: its scene's fields, [m, m, rad, Hz, 1, 1, rad, m/s^2, 1]."""

    __slots__ = ()
    kind = "along an ellipse"
    told_by = ELLIPTICAL
    abilities = frozenset({Ability.FLIGHT})

    @property
    def scale(self) -> Floats:
        """Unit of length of the solvers: the larger of both amplitudes [m]."""
        return largest_amplitude(self.along_amplitude, self.normal_amplitude)

    @property
    def reach(self) -> Floats:
        """Largest distance of the trough from its middle position: the ellipse's larger semi-axis [m]."""
        x, y = self.along_amplitude, self.normal_amplitude
        # An ellipse is the sum of two opposite rotations: its larger semi-axis is the sum of their radii.
        sine, cosine = y * np.sin(self.normal_phase), y * np.cos(self.normal_phase)
        return np.asarray(0.5 * (np.hypot(x + sine, cosine) + np.hypot(x - sine, cosine)))

    @property
    def along(self) -> Floats:
        """Amplitude of the motion along the trough [m]."""
        return self.along_amplitude

    @property
    def phase(self) -> Floats:
        """Phase by which the normal motion leads the motion along the trough [rad]."""
        return self.normal_phase

    def columns(self) -> Columns:
        """Return the columns that the solver reads."""
        return Columns(tuple(self), 1)

    def at_any_load(self) -> Self:
        """Replace the fields that critical loads do not depend on by scalars, to keep their shapes out."""
        return self._replace(frequency=_ONE, gravity=_ONE, restitution=_ONE - _ONE)


class _HarmonicFields(NamedTuple):
    along_amplitudes: tuple[Floats, ...]
    along_phases: tuple[Floats, ...]
    normal_amplitudes: tuple[Floats, ...]
    normal_phases: tuple[Floats, ...]
    frequency: Floats
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats
    gravity: Floats
    restitution: Floats


class Harmonics(_HarmonicFields, Drive):
    """A drive with harmonics: its scene's fields, in the units of ``Ellipse``.

    The trough moves along itself as the sum of ``along_amplitudes[n-1] * sin(n w t + along_phases[n-1])``,
    and normal to itself alike, with as many harmonics.
    """

    __slots__ = ()
    kind = "with harmonics"
    told_by = ("along_harmonics", "normal_harmonics")
    abilities = frozenset({Ability.FLIGHT})

    @classmethod
    def of(cls, scene: Any) -> Self:
        """Return the fields of a scene; the motion with fewer harmonics is filled up with zeros."""
        along, normal = scene.along_harmonics or (), scene.normal_harmonics or ()
        count = max(len(along), len(normal))
        nothing = (np.zeros(()), np.zeros(()))
        (x, xi), (y, eta) = (
            zip(*pairs, *[nothing] * (count - len(pairs)), strict=True) for pairs in (along, normal)
        )
        return cls(x, xi, y, eta, *(getattr(scene, name) for name in cls._fields[4:]))

    @property
    def shape(self) -> tuple[int, ...]:
        """Common shape of the fields, of which there are more than one NumPy iterator accepts."""
        return np.broadcast_shapes(*(x.shape for _, _, x in self.members()))

    @property
    def scale(self) -> Floats:
        """Unit of length of the solvers: the largest of all amplitudes [m]."""
        return largest_amplitude(*self.along_amplitudes, *self.normal_amplitudes)

    @property
    def reach(self) -> Floats:
        """Largest distance of the trough from its mean position [m]."""
        return _farthest(self, 0)

    @property
    def acceleration_reach(self) -> Floats:
        """Amplitude of a motion along a line with the same largest acceleration [m]."""
        return _farthest(self, 2)

    @property
    def stroke(self) -> Floats:
        """NaN: the width of a path with harmonics, which need not be symmetric, is not computed [m]."""
        return np.array(np.nan)

    def columns(self) -> Columns:
        """Return the columns that the solver reads."""
        nothing = np.zeros(())
        harmonics = (*self.along_amplitudes, *self.along_phases, *self.normal_amplitudes, *self.normal_phases)
        return Columns((_ONE, nothing + np.nan, nothing, *self[4:], *harmonics), 2)

    def loads(self) -> HarmonicLoads:
        """Return the dimensionless groups, without the restitution."""
        return harmonic_loads(*self[:9])

    def members(self) -> list[tuple[str, str, Floats]]:
        """Return each array, after the names of its field and of a quantity with its unit and range."""
        harmonics = [
            ("along_harmonics", "along_amplitude", self.along_amplitudes),
            ("along_harmonics", "normal_phase", self.along_phases),
            ("normal_harmonics", "normal_amplitude", self.normal_amplitudes),
            ("normal_harmonics", "normal_phase", self.normal_phases),
        ]
        found = [(field, name, x) for field, name, several in harmonics for x in several]
        return found + [(name, name, getattr(self, name)) for name in self._fields[4:]]


#: All kinds of drive.
KINDS: Final[tuple[type[Line] | type[Ellipse] | type[Harmonics], ...]] = (Line, Ellipse, Harmonics)


def read_harmonics(name: str, value: Any) -> tuple[Pairs, list[Problem]]:
    """Read pairs of amplitude and phase, the first harmonic first, and return their problems too.

    Returns
    -------
    tuple of pair of array
        Read-only copies as doubles; empty if the value is None.
    list of Problem
        Empty if there are none.
    """
    try:
        pairs = [] if value is None else [tuple(pair) for pair in value]
    except TypeError:
        return (), [Problem(name, shown(value), _ALLOWED)]
    if len(pairs) > MOST_HARMONICS or any(len(pair) != 2 for pair in pairs):
        return (), [Problem(name, shown(value), _ALLOWED)]
    read, problems = [], []
    for pair in pairs:
        try:
            amplitude, phase = map(real_array, pair)
        except NotRealError as exc:
            problems.append(Problem(name, exc.value, exc.allowed))
            continue
        for x in (amplitude, phase):
            x.flags.writeable = False
        read.append((amplitude, phase))
    return tuple(read), problems


def _farthest(fields: Harmonics, derivative: int) -> Floats:
    """Return the largest distance of a path from the origin, or of its n-th derivative over w^n.

    Its square is a trigonometric polynomial of degree 2 H. Parabolas through neighbouring points find its
    highest maximum to within 1e-6 of the value, and Newton's method refines that one.
    """
    count, unit = len(fields.along_amplitudes), fields.scale
    waves = [
        [(n, n**derivative * (x / unit), phase) for n, (x, phase) in enumerate(zip(*part, strict=True), 1)]
        for part in (fields[0:2], fields[2:4])
    ]

    def square(p: Any) -> tuple[Floats, Floats, Floats]:
        """Return the squared distance at a phase, and its first two derivatives."""
        value, slope, bend = np.zeros(()), np.zeros(()), np.zeros(())
        for part in waves:
            s = sum(x * np.sin(n * p + phase) for n, x, phase in part)
            d = sum(n * x * np.cos(n * p + phase) for n, x, phase in part)
            dd = sum(-n * n * x * np.sin(n * p + phase) for n, x, phase in part)
            value, slope, bend = value + s * s, slope + 2.0 * s * d, bend + 2.0 * (d * d + s * dd)
        return value, slope, bend

    step = 2.0 * np.pi / (_POINTS * count)
    before, here = square(-step)[0], square(0.0)[0]
    top, at = np.asarray(here), np.zeros(np.shape(here))
    for i in range(_POINTS * count):
        after = square((i + 1) * step)[0]
        rise, bend = 0.5 * (after - before), after - 2.0 * here + before
        peaks = (bend < 0.0) & (np.abs(rise) <= -bend)
        offset = np.where(peaks, -rise / np.where(peaks, bend, -1.0), 0.0)
        guess = here + np.where(peaks, 0.5 * rise * offset, 0.0)
        higher = guess > top
        top, at = np.where(higher, guess, top), np.where(higher, (i + offset) * step, at)
        before, here = here, after
    best = np.sqrt(square(at)[0])
    for _ in range(_STEPS):
        _, slope, bend = square(at)
        at = at - np.clip(slope / np.where(bend < 0.0, bend, -np.inf), -step, step)
        best = np.maximum(best, np.sqrt(square(at)[0]))
    return np.asarray(best * unit)
