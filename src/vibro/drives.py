"""The kinds of drive as small values: along a line, along an ellipse, with harmonics, with pieces.

Each kind defines its fields, its reach, the columns that the solver reads, and its abilities. Callers ask a
scene for an ability and never for its kind, so that a new kind is added here alone.
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple, Self, cast

import numpy as np

from vibro.core.numbers import ELLIPSE, HARMONICS, LINE, PIECES
from vibro.errors import InputError
from vibro.paths import widest
from vibro.quantities import ELLIPTICAL, LINEAR
from vibro.waveforms import HarmonicMotion, PiecewiseMotion

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["KINDS", "Ability", "Columns", "Drive", "Ellipse", "Harmonics", "Line", "Piecewise"]

_ONE: Final = np.ones(())
_NOTHING: Final = np.full((), np.nan)
_POINTS: Final = 64  # points of the path per harmonic, which bracket the farthest one
_TOGETHER: Final = 65_536  # of such points are computed in one pass: they stay in the processor's cache
_STEPS: Final = 6  # of Newton's method from there; each squares the error, which begins at 1e-3


class Ability(Enum):
    """Results that only some kinds of drive have; every kind has steady cycles, critical loads, histories."""

    ONE_HARMONIC = "closed forms of slides"
    PROOF = "closed forms and proved bounds"


class Columns(NamedTuple):
    """A scene as the solver reads it.

    Attributes
    ----------
    fields : tuple of array
        Nine, and four more for each harmonic; they broadcast.
    kind : int
        ``LINE``, ``ELLIPSE``, ``HARMONICS`` or ``PIECES``.
    breaks, pieces : float array
        Of ``PiecewiseMotion``, for all cells alike; zeros of other kinds.
    unit : float
        Its bound of the accelerations [m/s^2].
    """

    fields: tuple[Floats, ...]
    kind: int
    breaks: Floats = np.zeros(1)
    pieces: Floats = np.zeros(1)
    unit: float = 0.0


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
        hint = hint or "vibro.solve, vibro.simulate, vibro.arrival_time and vibro.sweep take it"
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
        """Amplitude of the motion along the trough [m]; InputError without ONE_HARMONIC."""
        raise self._refusal(Ability.ONE_HARMONIC)

    @property
    def phase(self) -> Floats:
        """Phase by which the normal motion leads that along the trough [rad]; 0 where both have harmonics."""
        return np.zeros(())

    def columns(self) -> Columns:
        """Return the columns that the solver reads."""
        raise NotImplementedError

    def at_any_load(self) -> Self:
        """Replace the fields that critical loads do not depend on by scalars, to keep their shapes out."""
        raise NotImplementedError

    def changed(self, change: Callable[[Floats], Floats]) -> Self:
        """Change every array."""
        changed: Self = _each(self, change)
        return changed

    def members(self) -> list[tuple[str, str, Floats]]:
        """Return each array, after the names of its field and of a quantity with its unit and range."""
        return [(name, name, getattr(self, name)) for name in _names(self)]


def _names(fields: Any) -> tuple[str, ...]:
    return tuple(fields._fields)


def _each(group: Any, change: Callable[[Floats], Floats]) -> Any:
    """Change every array of a nested (named) tuple of arrays."""
    if not isinstance(group, tuple):
        return change(group)
    members = [_each(member, change) for member in group]
    return group._make(members) if hasattr(group, "_make") else tuple(members)


def _largest_amplitude(first: Floats, *others: Floats) -> Floats:
    """Scale of the lengths of a drive with several amplitudes; 1 where the trough stands still [m]."""
    largest = first
    for amplitude in others:
        largest = np.maximum(largest, amplitude)
    return largest if np.all(largest) else np.where(largest > 0.0, largest, 1.0)


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

    def columns(self) -> Columns:
        """Return the columns that the solver reads."""
        return Columns((self.amplitude, self.drive_angle, _ONE, *self[1:2], *self[3:]), LINE)

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
    abilities = frozenset({Ability.ONE_HARMONIC})

    @property
    def scale(self) -> Floats:
        """Unit of length of the solvers: the larger of both amplitudes [m]."""
        return _largest_amplitude(self.along_amplitude, self.normal_amplitude)

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
        return Columns(tuple(self), ELLIPSE)

    def at_any_load(self) -> Self:
        """Replace the fields that critical loads do not depend on by scalars, to keep their shapes out."""
        return self._replace(frequency=_ONE, gravity=_ONE, restitution=_ONE - _ONE)


class _MovedFields(NamedTuple):
    """The last fields of all drives that are a motion."""

    motion_scale: Floats
    normal_acceleration: Floats
    frequency: Floats
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats
    gravity: Floats
    restitution: Floats


class _Moved(Drive):
    """Base class of drives that are a ``Motion``; ``normal_acceleration`` is NaN for free bodies."""

    told_by = ("motion", "along_harmonics", "normal_harmonics")

    @property
    def moved(self) -> _MovedFields:
        """The last fields."""
        return _MovedFields._make(cast("tuple[Floats, ...]", self)[-len(_MovedFields._fields) :])

    @property
    def shape(self) -> tuple[int, ...]:
        """Common shape of the fields, in several steps: a NumPy iterator accepts a limited number."""
        return np.broadcast_shapes(*(x.shape for _, _, x in self.members()))

    @property
    def moves_normal(self) -> bool:
        """Whether any trough moves normal to itself."""
        raise NotImplementedError

    def at_any_load(self) -> Self:
        """Replace the fields that critical loads do not depend on by scalars, to keep their shapes out."""
        moved = self.moved._replace(motion_scale=_ONE, frequency=_ONE, restitution=_ONE - _ONE)
        if not (~np.isnan(moved.normal_acceleration)).any():  # else the weight is compared with a given force
            moved = moved._replace(gravity=_ONE)
        at_any: Self = cast("Any", self)._replace(**moved._asdict())
        return at_any

    def members(self) -> list[tuple[str, str, Floats]]:
        """Return each array, after the names of its field and of a quantity with its unit and range."""
        return [
            (name, name, x)
            for name, x in self.moved._asdict().items()
            if name != "normal_acceleration" or x.ndim or not np.isnan(x)
        ]

    @property
    def _first_columns(self) -> tuple[Floats, ...]:
        scale, normal, *others = self.moved
        return scale, normal, _ONE - _ONE, *others


class _HarmonicFields(NamedTuple):
    along_amplitudes: tuple[Floats, ...]
    along_phases: tuple[Floats, ...]
    normal_amplitudes: tuple[Floats, ...]
    normal_phases: tuple[Floats, ...]
    motion_scale: Floats
    normal_acceleration: Floats
    frequency: Floats
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats
    gravity: Floats
    restitution: Floats


class Harmonics(_HarmonicFields, _Moved):
    """A drive with harmonics: its scene's fields, in the units of ``Ellipse``.

    The trough moves along itself as ``motion_scale`` times the sum of
    ``along_amplitudes[n-1] * sin(n w t + along_phases[n-1])``, and normal to itself alike, with as many
    harmonics.
    """

    __slots__ = ()
    kind = "with harmonics"
    abilities = frozenset()

    @classmethod
    def of(cls, scene: Any) -> Self:
        """Return the fields of a scene; the motion with fewer harmonics is filled up with zeros."""
        motion: HarmonicMotion = scene.motion
        count = max(len(motion.along), len(motion.normal))
        nothing = (np.zeros(()), np.zeros(()))
        (x, xi), (y, eta) = (
            zip(*pairs, *[nothing] * (count - len(pairs)), strict=True)
            for pairs in (motion.along, motion.normal)
        )
        return cls(x, xi, y, eta, *_moved_of(scene))

    @property
    def scale(self) -> Floats:
        """Unit of length of the solvers: the largest of all amplitudes [m]."""
        return _largest_amplitude(*(self.motion_scale * x for x in (*self[0], *self[2])))

    @property
    def reach(self) -> Floats:
        """Largest distance of the trough from its mean position [m]."""
        return self.motion_scale * _farthest(self, 0)

    @property
    def acceleration_reach(self) -> Floats:
        """Amplitude of a motion along a line with the same largest acceleration [m]."""
        return self.motion_scale * _farthest(self, 2)

    @property
    def stroke(self) -> Floats:
        """Largest distance between two points of the path [m]."""
        return self.motion_scale * _widest(self)

    @property
    def moves_normal(self) -> bool:
        """Whether any trough moves normal to itself."""
        return any(np.any(x != 0.0) for x in self.normal_amplitudes)

    def columns(self) -> Columns:
        """Return the columns that the solver reads."""
        return Columns((*self._first_columns, *self[0], *self[1], *self[2], *self[3]), HARMONICS)

    def members(self) -> list[tuple[str, str, Floats]]:
        """Return each array, after the names of its field and of a quantity with its unit and range."""
        harmonics = [
            ("along_harmonics", "along_amplitude", self.along_amplitudes),
            ("along_harmonics", "normal_phase", self.along_phases),
            ("normal_harmonics", "normal_amplitude", self.normal_amplitudes),
            ("normal_harmonics", "normal_phase", self.normal_phases),
        ]
        return [(field, name, x) for field, name, several in harmonics for x in several] + super().members()


class _PiecewiseFields(NamedTuple):
    motion: PiecewiseMotion
    motion_scale: Floats
    normal_acceleration: Floats
    frequency: Floats
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats
    gravity: Floats
    restitution: Floats


class Piecewise(_PiecewiseFields, _Moved):
    """A drive whose acceleration is a cubic on each piece of the period: its motion, its scene's fields."""

    __slots__ = ()
    kind = "with steps or sampled accelerations"
    abilities = frozenset()

    @classmethod
    def of(cls, scene: Any) -> Self:
        """Return the fields of a scene."""
        return cls(scene.motion, *_moved_of(scene))

    @property
    def scale(self) -> Floats:
        """Unit of length of the solvers: a bound of the accelerations over w^2 [m]."""
        return self.motion.unit / (2.0 * np.pi) ** 2 * self._at_frequency

    @property
    def reach(self) -> Floats:
        """Largest distance of the trough from its mean position [m]."""
        return self.motion.reach * self._at_frequency

    @property
    def acceleration_reach(self) -> Floats:
        """Amplitude of a motion along a line with the same largest acceleration [m]."""
        return self.motion.largest_acceleration / (2.0 * np.pi) ** 2 * self._at_frequency

    @property
    def stroke(self) -> Floats:
        """Largest distance between two points of the path [m]."""
        return self.motion.stroke * self._at_frequency

    @property
    def moves_normal(self) -> bool:
        """Whether the trough moves normal to itself."""
        return bool(np.any(self.motion.pieces[1] != 0.0))

    @property
    def _at_frequency(self) -> Floats:
        """Factor of lengths at 1 Hz."""
        return np.asarray(self.motion_scale / self.frequency**2)

    def changed(self, change: Callable[[Floats], Floats]) -> Self:
        """Change every array; the motion serves all cells."""
        moved: _MovedFields = _each(self.moved, change)
        return self._replace(**moved._asdict())

    def columns(self) -> Columns:
        """Return the columns that the solver reads."""
        motion = self.motion
        return Columns(self._first_columns, PIECES, motion.breaks, motion.pieces, motion.unit)


#: All kinds of drive.
KINDS: Final[tuple[type[Line | Ellipse | Harmonics | Piecewise], ...]] = (Line, Ellipse, Harmonics, Piecewise)


def _moved_of(scene: Any) -> _MovedFields:
    """Return the last fields of a scene with a motion."""
    clamped = _NOTHING if scene.normal_acceleration is None else scene.normal_acceleration
    return _MovedFields(
        scene.motion_scale, clamped, *(getattr(scene, name) for name in _MovedFields._fields[2:])
    )


def _farthest(fields: Harmonics, derivative: int) -> Floats:
    """Return the largest distance of each path from the origin, or of its n-th derivative over w^n."""
    waves, shape = _waves_of(fields)
    _, count, paths = waves.shape
    step = max(_TOGETHER // (_POINTS * count), 1)
    found = [_farthest_of(waves[..., i : i + step], derivative) for i in range(0, paths, step)]
    return np.reshape(np.concatenate([*found, np.zeros(0)]), shape)


def _waves_of(fields: Harmonics) -> tuple[Floats, tuple[int, ...]]:
    """Return amplitudes and phases along, then those normal, of shape (4, H, paths); and the paths' shape."""
    arrays = np.broadcast_arrays(*(x for part in fields[:4] for x in part))
    return np.reshape(arrays, (4, len(fields[0]), -1)), arrays[0].shape


def _farthest_of(waves: Floats, derivative: int) -> Floats:
    """Return ``_farthest`` of waves of shape (4, H, paths).

    The square of the distance is a trigonometric polynomial of degree 2 H. Parabolas through neighbouring
    points find its highest maximum to within 1e-6 of the value, and Newton's method refines that one.
    """
    _, count, paths = waves.shape
    unit, n = _largest_amplitude(*waves[0], *waves[2]), np.arange(1, count + 1)
    sizes = n[:, np.newaxis] ** derivative * (waves[::2] / unit)
    ways = list(zip(sizes, waves[1::2], strict=True))

    def square(p: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the squared distance at a phase of each path, and its first two derivatives."""
        value, slope, bend = np.zeros(()), np.zeros(()), np.zeros(())
        for way in ways:
            harmonics = list(zip(n, *way, strict=True))
            s = sum(x * np.sin(k * p + phase) for k, x, phase in harmonics)
            d = sum(k * x * np.cos(k * p + phase) for k, x, phase in harmonics)
            dd = sum(-k * k * x * np.sin(k * p + phase) for k, x, phase in harmonics)
            value, slope, bend = value + s * s, slope + 2.0 * s * d, bend + 2.0 * (d * d + s * dd)
        return value, slope, bend

    step = 2.0 * np.pi / (_POINTS * count)
    angles = step * np.outer(np.arange(_POINTS * count), n)
    sine, cosine = np.sin(angles), np.cos(angles)
    distances = [sine @ (x * np.cos(phase)) + cosine @ (x * np.sin(phase)) for x, phase in ways]
    here = sum(np.square(x) for x in distances)
    before, after = np.roll(here, 1, axis=0), np.roll(here, -1, axis=0)
    rise, bend = 0.5 * (after - before), after - 2.0 * here + before
    peaks = (bend < 0.0) & (np.abs(rise) <= -bend)
    offset = np.where(peaks, -rise / np.where(peaks, bend, -1.0), 0.0)
    highest = np.argmax(here + 0.5 * rise * offset, axis=0)
    at = step * (highest + offset[highest, np.arange(paths)])
    best = np.sqrt(square(at)[0])
    for _ in range(_STEPS):
        _, slope, bend = square(at)
        at = at - np.clip(slope / np.where(bend < 0.0, bend, -np.inf), -step, step)
        best = np.maximum(best, np.sqrt(square(at)[0]))
    return np.asarray(best * unit)


def _widest(fields: Harmonics) -> Floats:
    """Return the largest distance between two points of a path, of each path by itself."""
    waves, shape = _waves_of(fields)
    count = waves.shape[1]
    n = np.arange(1, count + 1)[:, np.newaxis]
    phases = np.linspace(0.0, 2.0 * np.pi, _POINTS * count, endpoint=False)
    strokes = []
    for x, xi, y, eta in waves.transpose(2, 0, 1)[..., np.newaxis]:

        def path(p: Floats, x: Floats = x, xi: Floats = xi, y: Floats = y, eta: Floats = eta) -> Any:
            angles = [n * p + phase for phase in (xi, eta)]
            s, c = ([f(angle) for angle in angles] for f in (np.sin, np.cos))
            sizes = (x, y)
            return tuple(
                np.array(
                    [np.sum(size * n**k * wave, axis=0) for size, wave in zip(sizes, waves, strict=True)]
                )
                for k, waves in enumerate((s, c, [-wave for wave in s]))
            )

        strokes.append(widest(path, phases))
    return np.reshape(strokes, shape)
