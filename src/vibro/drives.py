"""Drives of a trough as small values: along a line, along an ellipse, with harmonics, with pieces.

A ``Motion`` is a sum of harmonics or a piecewise polynomial. A drive is a named tuple of a scene's fields,
which also gives what the solver reads. Callers ask it for an ability and never for its kind.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, NamedTuple, Self, cast

import numpy as np

from vibro.core.numbers import ELLIPSE, HARMONICS, LINE, PIECES, TURN
from vibro.errors import InputError, Problem, SceneError, shown
from vibro.quantities import ELLIPTICAL, LINEAR, MOST_HARMONICS, POSITIVE, SHAKEN, SHIFTED
from vibro.reals import NotRealError, real_array, shielded

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import ArrayLike

    from vibro.quantities import Quantity
    from vibro.reals import Floats

    Path = Callable[[Floats], tuple[Floats, Floats, Floats]]
    Pairs = tuple[tuple[Floats, Floats], ...]
    GivenPairs = ArrayLike | Iterable[tuple[ArrayLike, ArrayLike]]
    Pieces = tuple[Floats, Floats]

# ------------------------------------------------------------------------------
# Closed paths: the farthest point from the origin, and the widest pair of points.

_POINTS: Final = 512  # of a path of pieces, besides its breaks, among which the widest pair is searched
_PATH_POINTS: Final = 64  # of a path per harmonic
_TOGETHER: Final = 65_536  # of such points are computed in one pass: they stay in the processor's cache
_NEWTON_STEPS: Final = 6  # for the farthest point; each squares the error, which begins at 1e-3
_NEAR: Final = 0.99  # share of the widest sampled distance from which on a pair is refined
_POLISHING_STEPS: Final = 8  # for the widest pair; each squares the error, which begins at 1e-2


def values_at(polynomials: Floats, breaks: Floats, places: Floats) -> Floats:
    """Evaluate piecewise polynomials (..., J, n) at places between the first and the last break."""
    piece = np.clip(np.searchsorted(breaks, places, side="right") - 1, 0, breaks.size - 2)
    u = (places - breaks[piece]) / np.diff(breaks)[piece]
    chosen = polynomials[..., piece, :]
    value = chosen[..., -1]
    for k in range(chosen.shape[-1] - 2, -1, -1):
        value = value * u + chosen[..., k]
    return np.asarray(value)


def _mean(polynomials: Floats, breaks: Floats) -> Floats:
    """Return the means of piecewise polynomials (..., J, n) over the period."""
    orders = np.arange(1, polynomials.shape[-1] + 1)
    return np.asarray(((polynomials / orders).sum(axis=-1) * np.diff(breaks)).sum(axis=-1))


def _integral(polynomials: Floats, breaks: Floats) -> Floats:
    """Integrate periodic piecewise polynomials (..., J, n); the result is continuous and has mean 0."""
    orders = np.arange(1, polynomials.shape[-1] + 1)
    risen = np.concatenate([np.zeros_like(polynomials[..., :1]), polynomials / orders], axis=-1)
    risen *= np.diff(breaks)[:, np.newaxis]
    risen[..., 1:, 0] += np.cumsum(risen.sum(axis=-1), axis=-1)[..., :-1]
    risen[..., 0] -= _mean(risen, breaks)[..., np.newaxis]
    return np.asarray(risen)


def _peaks(polynomials: Floats, of: Floats) -> Floats:
    """Evaluate polynomials (..., J, n) at the ends of pieces, and where ``of`` (J, m) is stationary."""
    found = [polynomials[..., 0], polynomials.sum(axis=-1)]
    if np.any(of[:, 1:]):
        from scipy.interpolate import PPoly

        knots = np.arange(len(of) + 1.0)  # the unit is a piece, so that its u is ours
        roots = PPoly(of[:, ::-1].T, knots).derivative().roots(extrapolate=False)
        found.append(values_at(polynomials, knots, roots[np.isfinite(roots)]))
    return np.concatenate(found, axis=-1)


def _farthest_of_pieces(polynomials: Floats) -> float:
    """Return the largest distance from the origin of piecewise polynomials (2, J, n)."""
    square = np.sum([[np.convolve(p, p) for p in way] for way in polynomials], axis=0)
    return float(np.hypot(*_peaks(polynomials, square)).max())


def _harmonic_path(waves: Floats, phase: Floats) -> tuple[Floats, Floats, Floats]:
    """Return positions, slopes and bends of sums of harmonics, each along and normal.

    Parameters
    ----------
    waves : (4, H, ...) array
        Amplitudes and phases along, and those normal.
    phase : array
        Of the drive; it broadcasts with each wave.
    """
    ways = []
    for sizes, leads in (waves[:2], waves[2:]):
        terms = []
        for k, (size, lead) in enumerate(zip(sizes, leads, strict=True), 1):
            sine, cosine = np.sin(k * phase + lead), np.cos(k * phase + lead)
            terms.append((size * sine, k * size * cosine, -k * k * size * sine))
        ways.append([sum(column) for column in zip(*terms, strict=True)])
    position, slope, bend = (np.array(both) for both in zip(*ways, strict=True))
    return position, slope, bend


def _farthest_of_harmonics(waves: Floats) -> Floats:
    """Return the largest distance from the origin of each path of waves (4, H, paths).

    The square of the distance is a trigonometric polynomial of degree 2 H. Parabolas through neighbouring
    points find its highest maximum to within 1e-6 of the value, and Newton's method refines that one.
    """
    _, count, paths = waves.shape
    unit = _or_one(waves[::2].max(axis=(0, 1)))
    waves = np.concatenate([waves[:1] / unit, waves[1:2], waves[2:3] / unit, waves[3:]])

    def square(phase: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the squared distance at a phase of each path, and its first two derivatives."""
        r, v, a = _harmonic_path(waves, phase)
        return (r * r).sum(axis=0), (2.0 * r * v).sum(axis=0), (2.0 * (v * v + r * a)).sum(axis=0)

    step = TURN / (_PATH_POINTS * count)
    angles = step * np.outer(np.arange(_PATH_POINTS * count), np.arange(1, count + 1))
    sine, cosine = np.sin(angles), np.cos(angles)
    ways = ((waves[0], waves[1]), (waves[2], waves[3]))
    here = sum(np.square(sine @ (x * np.cos(lead)) + cosine @ (x * np.sin(lead))) for x, lead in ways)
    before, after = np.roll(here, 1, axis=0), np.roll(here, -1, axis=0)
    rise, bend = 0.5 * (after - before), after - 2.0 * here + before
    peaks = (bend < 0.0) & (np.abs(rise) <= -bend)
    offset = np.where(peaks, -rise / np.where(peaks, bend, -1.0), 0.0)
    highest = np.argmax(here + 0.5 * rise * offset, axis=0)
    at = step * (highest + offset[highest, np.arange(paths)])
    best = np.sqrt(square(at)[0])
    for _ in range(_NEWTON_STEPS):
        _, slope, bend = square(at)
        at = at - np.clip(slope / np.where(bend < 0.0, bend, -np.inf), -step, step)
        best = np.maximum(best, np.sqrt(square(at)[0]))
    return np.asarray(best * unit)


def _or_one(sizes: Floats) -> Floats:
    """Return sizes, and 1 where they are 0: units of length of troughs that stand still too."""
    return sizes if np.all(sizes) else np.where(sizes > 0.0, sizes, 1.0)


def _widest(path: Path, phases: Floats) -> float:
    """Return the largest distance between two points of a closed path.

    Parameters
    ----------
    path : callable
        From phases to positions of shape (2, n), their slopes and their bends.
    phases : float array
        Of points so close that the widest pair is within 1 % of its distance from a pair of them.
    """
    x, y = path(phases)[0]
    square = (x[:, np.newaxis] - x) ** 2 + (y[:, np.newaxis] - y) ** 2
    best = float(square.max())
    is_peak = square >= _NEAR**2 * best
    for axis in (0, 1):
        for shift in (-1, 1):
            is_peak &= square >= np.roll(square, shift, axis)
    i, j = np.nonzero(np.triu(is_peak))
    p, q = phases[i], phases[j]
    limit = float(np.diff(phases).max())
    for _ in range(_POLISHING_STEPS):
        step = _towards(path(p), path(q))
        p, q = (at - np.clip(part, -limit, limit) for at, part in zip((p, q), step, strict=True))
        distance = path(p)[0] - path(q)[0]
        best = max(best, float((distance**2).sum(axis=0).max(initial=0.0)))
    return float(np.sqrt(best))


def _towards(first: Any, second: Any) -> tuple[Floats, Floats]:
    """Return Newton's step for the phases of pairs of points, at which their distance is stationary."""
    (r, slope_r, bend_r), (s, slope_s, bend_s) = first, second
    gap = r - s
    g, h = (gap * slope_r).sum(axis=0), -(gap * slope_s).sum(axis=0)
    a = (slope_r**2).sum(axis=0) + (gap * bend_r).sum(axis=0)
    b = -(slope_r * slope_s).sum(axis=0)
    c = (slope_s**2).sum(axis=0) - (gap * bend_s).sum(axis=0)
    det = a * c - b * b
    # On a circle one of both phases is free, and the determinant is zero: each phase moves by itself.
    joint = np.abs(det) > 1e-9 * np.abs(a * c)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.where(joint, (c * g - b * h) / det, g / a)
        v = np.where(joint, (a * h - b * g) / det, h / c)
    return np.nan_to_num(u, posinf=0.0, neginf=0.0), np.nan_to_num(v, posinf=0.0, neginf=0.0)


# ------------------------------------------------------------------------------
# Periodic motions of a trough: sums of harmonics, steps of its acceleration, samples of one period.

#: Pieces of a period, also samples of it, that the solver takes.
MOST_PIECES: Final = 4096
#: Samples of a period, at least: fewer carry three harmonics at most.
LEAST_SAMPLES: Final = 8

_WHOLE: Final = 1e-9  # [1] by which shares may miss 1, and breaks along and normal each other
_OPEN: Final = 0.01  # [1] of the largest acceleration: a mean up to this is rounding of what was typed
_OPEN_ENDS: Final = 1e-9  # [1] of the largest acceleration: a smaller gap between two pieces is rounding
_HEARD: Final = 1e-12  # [1] of the largest acceleration: harmonics below it are rounding of the samples
_LEAST_NOISE: Final = 8  # harmonics beyond those kept whose mean power is a level of noise
_CHANCE: Final = 1e-3  # that noise is taken for the last harmonic
_PAIRS: Final = f"up to {MOST_HARMONICS} pairs of an amplitude and a phase"
_STEPS: Final = f"up to {MOST_PIECES} pairs of a share of the period and an acceleration"
_SAMPLES: Final = f"a list of {LEAST_SAMPLES} to {MOST_PIECES} finite numbers: one period, equally spaced"
_QUANTITIES: Final = ("acceleration", "displacement")
_ZERO: Final = np.zeros(())
_ONE: Final = np.ones(())
_NAN: Final = np.full((), np.nan)


class Motion:
    """One period of any periodic motion of a trough, for ``Scene(motion=...)``.

    Make it with ``Motion.harmonics``, ``Motion.steps``, ``Motion.samples`` or ``vibro.trough_motion``. Motion
    along the trough is positive in the conveying direction, motion normal to it is positive upwards. Without
    values for a direction the trough does not move in it.
    """

    @staticmethod
    @shielded
    def harmonics(along: GivenPairs | None = None, normal: GivenPairs | None = None) -> Motion:
        """Return a sum of harmonics ``amplitude * sin(2 pi n frequency t + phase)``, n = 1 first.

        Parameters
        ----------
        along, normal : sequence of pair of array_like, optional
            Up to 16 pairs of an amplitude, >= 0 [m], and a phase [rad]; arrays broadcast with the fields of
            the scene.

        Raises
        ------
        SceneError
            If they are not such pairs, or there are none; ``Scene`` checks the ranges of the values.

        Examples
        --------
        >>> import vibro
        >>> slip_stick = vibro.Motion.harmonics(along=[(20e-3, 0.0), (5e-3, -1.92)])
        >>> scene = vibro.Scene(motion=slip_stick, frequency=2.5,
        ...                     static_friction=0.3, kinetic_friction=0.25)
        >>> print(f"{float(scene.load):.3f} g")
        1.000 g
        """
        return harmonic_motion((along, normal), ("along", "normal"))

    @staticmethod
    @shielded
    def steps(along: GivenPairs | None = None, normal: GivenPairs | None = None) -> Motion:
        """Return a motion with piecewise constant acceleration.

        Parameters
        ----------
        along, normal : sequence of pair of float, optional
            Up to 4096 pairs of a share of the period, > 0 [1], and the acceleration of the trough during it
            [m/s^2]. The shares must add up to 1 within 1e-9. Those of the two directions may differ.

        Raises
        ------
        SceneError
            If they are not such pairs, or if the mean acceleration exceeds 1 % of the largest one, with which
            the trough would not return; the message names a last acceleration with which it does. A smaller
            mean is subtracted.

        Notes
        -----
        The accelerations do not depend on the frequency; the displacements fall with its square. The solver
        represents steps exactly.

        Examples
        --------
        >>> import vibro
        >>> vibro.Motion.steps(along=[(0.8, 6.9), (0.2, -27.5)]).accelerations([0.0, 0.5, 0.9]).round(3)
        array([[  6.88,   6.88, -27.52],
               [  0.  ,   0.  ,   0.  ]])
        """
        return step_motion(along, normal, ("along", "normal"))

    @staticmethod
    @shielded
    def samples(
        along: ArrayLike | None = None,
        normal: ArrayLike | None = None,
        *,
        of: Literal["acceleration", "displacement"] = "acceleration",
    ) -> Motion:
        """Return a motion through samples of one period, equally spaced, the first at phase 0.

        Parameters
        ----------
        along, normal : sequence of float, optional
            8 to 4096 samples, the same number in both directions; the first one is not repeated at the end.
            Their mean, such as the offset of a sensor, is subtracted.
        of : {"acceleration", "displacement"}
            What is sampled: accelerations [m/s^2] or displacements [m].

        Raises
        ------
        SceneError
            If they are not such samples.

        Notes
        -----
        Accelerations are interpolated by a periodic cubic spline. Displacements are fitted by up to 16
        harmonics: those that are significant against the noise, which is estimated from the harmonics above
        16 (available from 49 samples on). For an acceleration that jumps use ``Motion.steps``, which is
        exact.

        Examples
        --------
        >>> import numpy as np, vibro
        >>> share = np.arange(64) / 64
        >>> motion = vibro.Motion.samples(along=-3.0 * np.sin(2.0 * np.pi * share))
        >>> print(f"{motion.largest_acceleration:.6f} m/s^2")
        3.000000 m/s^2
        """
        return sampled_motion(along, normal, of, ("along", "normal"))


class _Columns(NamedTuple):
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


@dataclass(frozen=True, eq=False)
class HarmonicMotion(Motion):
    """A sum of harmonics; made by ``Motion.harmonics``, or by ``Motion.samples`` of displacement.

    Attributes
    ----------
    along, normal : tuple of pair of array
        Amplitude [m] and phase [rad] of each harmonic, the first harmonic first; empty without motion in that
        direction.
    """

    along: Pairs
    normal: Pairs

    @cached_property
    def table(self) -> tuple[tuple[Floats, ...], ...]:
        """Amplitudes along, their phases, amplitudes normal and their phases: zeros fill up the shorter."""
        count = max(len(self.along), len(self.normal))
        padded = (pairs + ((_ZERO, _ZERO),) * (count - len(pairs)) for pairs in (self.along, self.normal))
        return tuple(column for pairs in padded for column in zip(*pairs, strict=True))

    @property
    def size(self) -> Floats:
        """Largest of all amplitudes [m]."""
        amplitudes = np.broadcast_arrays(*self.table[0], *self.table[2])
        return np.asarray(np.max(amplitudes, axis=0))

    @cached_property
    def reach(self) -> Floats:
        """Largest distance from the mean position [m]."""
        return self._farthest(0)

    @cached_property
    def acceleration_reach(self) -> Floats:
        """Amplitude of a motion along a line with the same largest acceleration [m]."""
        return self._farthest(2)

    @cached_property
    def stroke(self) -> Floats:
        """Largest distance between two points of each path [m]."""
        waves, shape = self._waves
        phases = np.linspace(0.0, TURN, _PATH_POINTS * waves.shape[1], endpoint=False)
        each = np.moveaxis(waves, -1, 0)[..., np.newaxis]
        return np.reshape([_widest(partial(_harmonic_path, one), phases) for one in each], shape)

    @property
    def moves_normal(self) -> bool:
        """Whether any trough moves normal to itself."""
        return any(np.any(size != 0.0) for size, _ in self.normal)

    def columns(self, fields: tuple[Floats, ...]) -> _Columns:
        """Return what the solver reads, after the fields that all motions have."""
        return _Columns((*fields, *(x for column in self.table for x in column)), HARMONICS)

    def changed(self, change: Callable[[Floats], Floats]) -> HarmonicMotion:
        """Change every array."""
        x, xi, y, eta = (tuple(map(change, column)) for column in self.table)
        return HarmonicMotion(tuple(zip(x, xi, strict=True)), tuple(zip(y, eta, strict=True)))

    def members(self) -> list[tuple[str, str, Floats]]:
        """Return each array, after the names of its field and of a quantity with its unit and range."""
        names = [
            ("along_harmonics", "along_amplitude"),
            ("along_harmonics", "normal_phase"),
            ("normal_harmonics", "normal_amplitude"),
            ("normal_harmonics", "normal_phase"),
        ]
        return [(*name, x) for name, column in zip(names, self.table, strict=True) for x in column]

    @property
    def _waves(self) -> tuple[Floats, tuple[int, ...]]:
        """The table as an array (4, H, paths), and the shape of the paths."""
        arrays = np.broadcast_arrays(*(x for column in self.table for x in column))
        return np.reshape(arrays, (4, len(self.table[0]), -1)), arrays[0].shape

    def _farthest(self, derivative: int) -> Floats:
        """Return the largest distance from the origin of each path's n-th derivative over w^n [m]."""
        waves, shape = self._waves
        _, count, paths = waves.shape
        waves[::2] *= np.arange(1, count + 1)[:, np.newaxis] ** derivative
        step = max(_TOGETHER // (_PATH_POINTS * count), 1)
        found = [_farthest_of_harmonics(waves[..., i : i + step]) for i in range(0, paths, step)]
        return np.reshape(np.concatenate([*found, np.zeros(0)]), shape)


@dataclass(frozen=True, eq=False)
class PiecewiseMotion(Motion):
    """A piecewise cubic acceleration; made by ``Motion.steps`` or by ``Motion.samples`` of acceleration.

    Attributes
    ----------
    breaks : float array
        Of shape (J + 1,), ascending from 0 to 1: shares of the period [1].
    pieces : float array
        Of shape (2, J, 4): along and normal, coefficients of 1, u, u^2 and u^3 on each piece, with u from 0
        to 1, and mean 0 over the period [m/s^2].
    """

    breaks: Floats
    pieces: Floats

    @cached_property
    def largest_acceleration(self) -> float:
        """Largest size of the acceleration [m/s^2]."""
        return _farthest_of_pieces(self.pieces)

    @property
    def unit(self) -> float:
        """Bound of both accelerations, their largest Bernstein coefficient; 1 without motion [m/s^2]."""
        a, b, c, d = np.moveaxis(self.pieces, -1, 0)
        corners = (a, a + b / 3.0, a + (2.0 * b + c) / 3.0, a + b + c + d)
        return float(np.abs(corners).max()) or 1.0

    @cached_property
    def jumps(self) -> Floats:
        """Shares of the period, in [0, 1), at which an acceleration jumps [1]."""
        ends, starts = self.pieces.sum(axis=-1), self.pieces[..., 0]
        gaps = np.abs(starts - np.roll(ends, 1, axis=-1)).max(axis=0)
        return np.asarray(self.breaks[:-1][gaps > _OPEN_ENDS * self.unit])

    @cached_property
    def velocities(self) -> Floats:
        """Velocities at 1 Hz: as ``pieces``, of degree 4 [m/s]."""
        return _integral(self.pieces, self.breaks)

    @cached_property
    def positions(self) -> Floats:
        """Positions at 1 Hz: as ``pieces``, of degree 5 [m]."""
        return _integral(self.velocities, self.breaks)

    @property
    def size(self) -> float:
        """Bound of the accelerations over w^2 at 1 Hz [m]."""
        return self.unit / TURN**2

    @cached_property
    def reach(self) -> float:
        """Largest distance from the mean position at 1 Hz [m]."""
        return _farthest_of_pieces(self.positions)

    @property
    def acceleration_reach(self) -> float:
        """Amplitude at 1 Hz of a motion along a line with the same largest acceleration [m]."""
        return self.largest_acceleration / TURN**2

    @cached_property
    def stroke(self) -> float:
        """Largest distance between two points of the path at 1 Hz [m]."""
        x, y = self.positions
        if not (np.any(x) and np.any(y)):
            return float(np.ptp(_peaks(x + y, x + y)))

        def path(shares: Floats) -> tuple[Floats, Floats, Floats]:
            at = np.mod(shares, 1.0)
            r, v, a = (values_at(p, self.breaks, at) for p in (self.positions, self.velocities, self.pieces))
            return r, v, a

        return _widest(path, np.unique(np.concatenate([np.arange(_POINTS) / _POINTS, self.breaks[:-1]])))

    @property
    def moves_normal(self) -> bool:
        """Whether the trough moves normal to itself."""
        return bool(np.any(self.pieces[1]))

    @shielded
    def accelerations(self, shares: ArrayLike) -> Floats:
        """Return accelerations along and normal, of shape (2, ...), at shares of the period [m/s^2]."""
        return values_at(self.pieces, self.breaks, np.mod(shares, 1.0))

    def columns(self, fields: tuple[Floats, ...]) -> _Columns:
        """Return what the solver reads, after the fields that all motions have."""
        return _Columns(fields, PIECES, self.breaks, self.pieces, self.unit)

    def changed(self, _: Callable[[Floats], Floats]) -> PiecewiseMotion:
        """Return itself: the motion serves all cells."""
        return self

    def members(self) -> list[tuple[str, str, Floats]]:
        """Return nothing: no array of it is a field of a scene."""
        return []


def harmonic_motion(given: Sequence[Any], names: tuple[str, str]) -> HarmonicMotion:
    """Return ``Motion.harmonics`` of both directions; messages call them by these names."""
    problems: list[Problem] = []
    read = [_read_harmonics(name, x, problems) for name, x in zip(names, given, strict=True)]
    if not any(read) and not problems:
        problems.append(Problem(names[0], "none", f"at least one pair, or {names[1]}"))
    if problems:
        raise SceneError(tuple(problems))
    return HarmonicMotion(*read)


def step_motion(along: Any, normal: Any, names: tuple[str, str]) -> PiecewiseMotion:
    """Return ``Motion.steps``; messages call its arguments by these names."""
    return _piecewise(along, normal, names, _read_steps)


def sampled_motion(along: Any, normal: Any, of: Any, names: tuple[str, str]) -> Motion:
    """Return ``Motion.samples``; messages call its arguments by these names."""
    if not isinstance(of, str) or of not in _QUANTITIES:
        raise SceneError.of("of", shown(of), " or ".join(_QUANTITIES))
    sizes = [np.shape(samples) for samples in (along, normal) if samples is not None]
    if [len(size) for size in sizes] == [1, 1] and sizes[0] != sizes[1]:  # else one of them is refused below
        raise SceneError.of(names[1], f"{sizes[1][0]} samples", f"as many as {names[0]}, {sizes[0][0]}")
    if of == "acceleration":
        return _piecewise(along, normal, names, _read_accelerations)
    given = [
        None if x is None else _harmonics_of(_read_samples(name, x, SHIFTED))
        for name, x in zip(names, (along, normal), strict=True)
    ]
    return harmonic_motion(given, names)


def _read_harmonics(name: str, value: Any, problems: list[Problem]) -> Pairs:
    """Read pairs of amplitude and phase as read-only copies; none of a value that is None."""
    try:
        pairs = [] if value is None else [tuple(pair) for pair in value]
    except TypeError:
        pairs = [()]
    if len(pairs) > MOST_HARMONICS or any(len(pair) != 2 for pair in pairs):
        problems.append(Problem(name, shown(value), _PAIRS))
        return ()
    read = []
    for pair in pairs:
        try:
            amplitude, phase = map(real_array, pair)
        except NotRealError as exc:
            problems.append(Problem(name, exc.value, exc.allowed))
            continue
        amplitude.flags.writeable = phase.flags.writeable = False
        read.append((amplitude, phase))
    return tuple(read)


def _piecewise(
    along: Any, normal: Any, names: tuple[str, str], read: Callable[[str, Any], Pieces]
) -> PiecewiseMotion:
    """Read both directions, cut both at the breaks of either, and subtract the rest of their means."""
    problems: list[Problem] = []
    found: list[Pieces | None] = []
    for name, value in zip(names, (along, normal), strict=True):
        try:
            found.append(None if value is None else read(name, value))
        except SceneError as exc:
            problems += exc.problems
    if along is None and normal is None:
        problems.append(Problem(names[0], "none", f"given, or {names[1]}"))
    if problems:
        raise SceneError(tuple(problems))
    breaks = _union([own[0] for own in found if own])
    if breaks.size > MOST_PIECES + 1:
        different = f"{breaks.size - 1} different pieces along and normal"
        raise SceneError.of(names[1], different, f"such that they are at most {MOST_PIECES}")
    none = np.zeros((breaks.size - 1, 4))
    pieces = np.array([_cut(*own, breaks) if own else none for own in found])
    for _ in range(2):  # the second time what rounding left
        pieces[..., 0] -= _mean(pieces, breaks)[:, np.newaxis]
    breaks.flags.writeable = pieces.flags.writeable = False
    return PiecewiseMotion(breaks, pieces)


def _read_steps(name: str, value: Any) -> Pieces:
    """Read shares and accelerations; refuse a motion that does not come back."""
    try:
        steps = real_array(value if isinstance(value, np.ndarray) else [*value])
    except NotRealError as exc:
        raise SceneError.of(name, exc.value, _STEPS) from None
    except TypeError:
        raise SceneError.of(name, shown(value), _STEPS) from None
    if steps.ndim != 2 or steps.shape[1] != 2 or not 0 < len(steps) <= MOST_PIECES:
        raise SceneError.of(name, shown(value), _STEPS)
    shares, accelerations = steps.T
    for share in shares[~((shares > _WHOLE) & (shares <= POSITIVE.high))][:1]:
        allowed = f"shares above {_WHOLE:g}, up to {POSITIVE.high:g}"
        raise SceneError.of(name, f"a share of {share:.15g}", allowed)
    _check(name, accelerations, SHAKEN)
    total = math.fsum(shares)
    if abs(total - 1.0) > _WHOLE:
        last = 1.0 - math.fsum(shares[:-1])
        remedy = f"give the last one {last:.9g}" if last > _WHOLE else f"divide each by {total:.9g}"
        raise SceneError.of(name, f"shares of {total:.10g} in all", f"shares that add up to 1: {remedy}")
    mean = math.fsum(shares * accelerations) / total
    if abs(mean) > _OPEN * np.abs(accelerations).max():
        last = -math.fsum(shares[:-1] * accelerations[:-1]) / shares[-1]
        remedy = f"the trough comes back if the last is {last:.9g} m/s^2"
        allowed = f"at most {100.0 * _OPEN:g} % of the largest: {remedy}"
        raise SceneError.of(name, f"a mean acceleration of {mean:.6g} m/s^2", allowed)
    breaks = np.concatenate([[0.0], np.cumsum(shares) / total])
    breaks[-1] = 1.0
    return breaks, np.pad(accelerations[:, np.newaxis], ((0, 0), (0, 3)))


def _check(name: str, values: Floats, quantity: Quantity) -> None:
    """Raise SceneError unless all values are in a range [SI], and not all are next to 0 but for zeros."""
    unit, least = quantity.kind.si_unit, quantity.to_si(POSITIVE.low)
    for value in values[~quantity.allows(values)][:1]:
        raise SceneError.of(name, f"{value:.15g} {unit}", quantity.range_text)
    if 0.0 < (largest := float(np.abs(values).max())) < least:
        raise SceneError.of(name, f"at most {largest:.15g} {unit}", f"0, or up to {least:g} {unit}")


def _read_samples(name: str, value: Any, quantity: Quantity) -> Floats:
    try:
        samples = real_array(value)
    except NotRealError as exc:
        raise SceneError.of(name, exc.value, _SAMPLES) from None
    if samples.ndim != 1:
        raise SceneError.of(name, shown(value), _SAMPLES)
    if not LEAST_SAMPLES <= samples.size <= MOST_PIECES:
        raise SceneError.of(name, f"{samples.size} samples", _SAMPLES)
    for sample in samples[~np.isfinite(samples)][:1]:
        raise SceneError.of(name, str(sample), _SAMPLES)
    _check(name, samples, quantity)
    return samples


def _read_accelerations(name: str, value: Any) -> Pieces:
    """Join samples by a periodic cubic spline."""
    from scipy.interpolate import CubicSpline

    samples = _read_samples(name, value, SHAKEN)
    steps = np.arange(samples.size + 1)  # the spline's unit is a piece, so that its u is ours
    spline = CubicSpline(steps, np.append(samples, samples[0]), bc_type="periodic")
    return np.asarray(steps / samples.size), np.ascontiguousarray(spline.c[::-1].T)


def _harmonics_of(samples: Floats) -> list[tuple[float, float]]:
    """Return the harmonics of displacements that stand out from their noise, and are more than rounding."""
    count = (samples.size - 1) // 2
    spectrum = np.fft.rfft(samples)[1 : count + 1]
    sizes = np.abs(spectrum) * (2.0 / samples.size)
    kept = sizes[:MOST_HARMONICS]
    loads = kept * np.arange(1, kept.size + 1) ** 2
    heard = loads > _HEARD * loads.max()
    if (beyond := sizes[MOST_HARMONICS:]).size >= _LEAST_NOISE:
        # The power of noise in one harmonic over its mean in m others is F(2, 2 m), whose tail is elementary.
        m = beyond.size
        heard &= kept**2 > np.mean(beyond**2) * m * (_CHANCE ** (-1.0 / m) - 1.0)
    last = int(np.flatnonzero(heard).max(initial=0)) + 1
    phases = np.angle(spectrum) + 0.5 * math.pi
    return [(float(size), float(phase)) for size, phase in zip(kept[:last], phases, strict=False)]


def _union(several: Sequence[Floats]) -> Floats:
    """Return the breaks of all; those that agree within rounding are one."""
    breaks = np.unique(np.concatenate(several))
    breaks = np.append(0.0, breaks[1:][np.diff(breaks) > _WHOLE])
    breaks[-1] = 1.0
    return breaks


def _cut(own: Floats, pieces: Floats, breaks: Floats) -> Floats:
    """Return the same cubics on the pieces between more breaks."""
    piece = np.clip(np.searchsorted(own, 0.5 * (breaks[1:] + breaks[:-1])) - 1, 0, len(pieces) - 1)
    length = np.diff(own)[piece]
    u, ratio = (breaks[:-1] - own[piece]) / length, np.diff(breaks) / length
    a, b, c, d = pieces[piece].T
    moved = (a + u * (b + u * (c + u * d)), b + u * (2.0 * c + 3.0 * u * d), c + 3.0 * u * d, d)
    return np.stack([x * ratio**k for k, x in enumerate(moved)], axis=-1)


# ------------------------------------------------------------------------------
# Drives: the fields of a scene by its kind of drive.


class Ability(Enum):
    """Results that only some kinds of drive have; every kind has steady cycles, critical loads, histories."""

    ONE_HARMONIC = "formulas of slides"
    PROOF = "formulas and proved bounds"


class Drive:
    """Base class of all kinds of drive, named tuples of a scene's fields.

    Attributes
    ----------
    kind : str
        Its motion, in the words of messages.
    own_names : tuple of str
        Fields of a scene that distinguish this kind from the others.
    abilities : frozenset of Ability
        Results that can be computed for it.
    """

    kind: ClassVar[str]
    own_names: ClassVar[tuple[str, ...]]
    abilities: ClassVar[frozenset[Ability]] = frozenset()

    @classmethod
    def of(cls, scene: Any) -> Self:
        """Return the fields of a scene that has this kind of drive; NaN for one that is left out."""
        given = [getattr(scene, name) for name in cast("Any", cls)._fields]
        return cls(*[_NAN if x is None else x for x in given])

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
            able = " or ".join(kind.kind for kind in KINDS if ability in kind.abilities)
            hint = hint or "vibro.solve, vibro.simulate, vibro.arrival_time and vibro.sweep take it"
            text = f"a drive {self.kind}: {ability.value} are known of drives {able} alone"
            raise InputError(text, hint=hint)

    @property
    def shape(self) -> tuple[int, ...]:
        """Common shape of the fields."""
        return np.broadcast(*cast("Any", self)).shape

    @property
    def scale(self) -> Floats:
        """Unit of length of the solvers [m]."""
        raise NotImplementedError

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
        self.require(Ability.ONE_HARMONIC)
        raise NotImplementedError

    @property
    def phase(self) -> Floats:
        """Phase by which the normal motion leads that along the trough [rad]; 0 where both have harmonics."""
        return _ZERO

    @property
    def moves_normal(self) -> bool:
        """Whether any trough moves normal to itself."""
        return True

    def columns(self) -> _Columns:
        """Return the columns that the solver reads."""
        raise NotImplementedError

    def at_any_load(self) -> Self:
        """Replace the fields that critical loads do not depend on by scalars, to keep their shapes out."""
        fields: Any = self
        free = {name: _ONE for name in ("amplitude", "motion_scale", "frequency") if name in fields._fields}
        clamping = getattr(fields, "normal_acceleration", np.nan)
        if np.isnan(clamping).all():  # else the weight is compared with a given force
            free["gravity"] = _ONE
        at_any: Self = fields._replace(**free, restitution=_ZERO)
        return at_any

    def changed(self, change: Callable[[Floats], Floats]) -> Self:
        """Change every array."""
        fields: Any = self
        return type(self)(*(change(x) if isinstance(x, np.ndarray) else x.changed(change) for x in fields))

    def members(self) -> list[tuple[str, str, Floats]]:
        """Return each array, after the names of its field and of a quantity with its unit and range."""
        fields: Any = self
        return [(name, name, x) for name, x in zip(fields._fields, fields, strict=True)]


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
    own_names = LINEAR
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

    def columns(self) -> _Columns:
        """Return the columns that the solver reads."""
        return _Columns((self.amplitude, self.drive_angle, _ONE, self.frequency, *self[3:]), LINE)


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
    own_names = ELLIPTICAL
    abilities = frozenset({Ability.ONE_HARMONIC})

    @property
    def scale(self) -> Floats:
        """Unit of length of the solvers: the larger of both amplitudes; 1 where both are 0 [m]."""
        return _or_one(np.maximum(self.along_amplitude, self.normal_amplitude))

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

    def columns(self) -> _Columns:
        """Return the columns that the solver reads."""
        return _Columns(tuple(self), ELLIPSE)


class _MovedFields(NamedTuple):
    motion: HarmonicMotion | PiecewiseMotion
    motion_scale: Floats
    normal_acceleration: Floats
    frequency: Floats
    static_friction: Floats
    kinetic_friction: Floats
    trough_angle: Floats
    gravity: Floats
    restitution: Floats


class Moved(_MovedFields, Drive):
    """A drive that is a ``Motion``: its scene's fields; ``normal_acceleration`` is NaN for free bodies."""

    __slots__ = ()
    own_names = ("motion", "along_harmonics", "normal_harmonics")

    @property
    def _factor(self) -> Floats:
        """Factor of the motion's lengths [1]."""
        return self.motion_scale

    @property
    def scale(self) -> Floats:
        """Unit of length of the solvers: the largest amplitude, or a bound of accelerations over w^2 [m]."""
        return _or_one(np.asarray(self.motion.size * self._factor))

    @property
    def reach(self) -> Floats:
        """Largest distance of the trough from its mean position [m]."""
        return np.asarray(self.motion.reach * self._factor)

    @property
    def acceleration_reach(self) -> Floats:
        """Amplitude of a motion along a line with the same largest acceleration [m]."""
        return np.asarray(self.motion.acceleration_reach * self._factor)

    @property
    def stroke(self) -> Floats:
        """Largest distance between two points of the path [m]."""
        return np.asarray(self.motion.stroke * self._factor)

    @property
    def shape(self) -> tuple[int, ...]:
        """Common shape of the fields."""
        return np.broadcast_shapes(*(x.shape for _, _, x in self.members()))

    @property
    def moves_normal(self) -> bool:
        """Whether any trough moves normal to itself."""
        return self.motion.moves_normal

    def columns(self) -> _Columns:
        """Return the columns that the solver reads."""
        motion, scale, normal, *others = self
        return motion.columns((scale, normal, _ZERO, *others))

    def members(self) -> list[tuple[str, str, Floats]]:
        """Return each array, after the names of its field and of a quantity with its unit and range."""
        own = [(name, name, x) for name, x in zip(self._fields[1:], self[1:], strict=True)]
        return self.motion.members() + [one for one in own if one[2].ndim or not np.isnan(one[2])]


class Harmonics(Moved):
    """A drive with harmonics: the sum of ``motion_scale * amplitude * sin(n w t + phase)``."""

    __slots__ = ()
    kind = "with harmonics"


class Piecewise(Moved):
    """A drive whose acceleration is ``motion_scale`` times a cubic on each piece of the period."""

    __slots__ = ()
    kind = "with steps or sampled accelerations"

    @property
    def _factor(self) -> Floats:
        """Factor of lengths at 1 Hz."""
        return np.asarray(self.motion_scale / self.frequency**2)


#: All kinds of drive.
KINDS: Final[tuple[type[Line | Ellipse | Harmonics | Piecewise], ...]] = (Line, Ellipse, Harmonics, Piecewise)
