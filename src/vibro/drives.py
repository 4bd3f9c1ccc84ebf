"""The kinds of drive as small values: along a line, along an ellipse, with harmonics, with pieces.

Each kind defines its fields, its reach, the columns that the solver reads, and its abilities. Callers ask a
scene for an ability and never for its kind, so that a new kind is added here alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, NamedTuple, Self, cast

import numpy as np

from vibro.core.numbers import ELLIPSE, HARMONICS, LINE, PIECES
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
# Extreme distances on closed paths: of piecewise polynomials by their roots, of other paths by search.

_NEAR: Final = 0.99  # share of the widest sampled distance from which on a pair is refined
_POLISHING_STEPS: Final = 8  # of Newton's method; each squares the error, which begins at 1e-2
_REAL: Final = 1e-6  # [1] imaginary part up to which a computed root may be a double real one


def _integral(polynomials: Floats, lengths: Floats) -> Floats:
    """Integrate periodic piecewise polynomials; the result is continuous, periodic and has mean 0.

    Parameters
    ----------
    polynomials : float array
        Of shape (..., J, n): coefficients of 1, u, u^2, ... on each piece, u from 0 to 1, with mean 0.
    lengths : float array
        Of the pieces.

    Returns
    -------
    float array
        Of shape (..., J, n + 1).
    """
    powers = np.arange(1, polynomials.shape[-1] + 1)
    risen = np.concatenate([np.zeros_like(polynomials[..., :1]), polynomials / powers], axis=-1)
    risen *= lengths[:, np.newaxis]
    ends = np.cumsum(risen.sum(axis=-1), axis=-1)
    risen[..., 1:, 0] += ends[..., :-1]
    shares = 1.0 / np.arange(1, risen.shape[-1] + 1)
    mean = ((risen * shares).sum(axis=-1) * lengths).sum(axis=-1) / lengths.sum()
    risen[..., 0] -= mean[..., np.newaxis]
    return np.asarray(risen)


def values_at(polynomials: Floats, breaks: Floats, places: Floats) -> Floats:
    """Evaluate piecewise polynomials (..., J, n) at places between the first and the last break."""
    piece = np.clip(np.searchsorted(breaks, places, side="right") - 1, 0, breaks.size - 2)
    u = (places - breaks[piece]) / np.diff(breaks)[piece]
    chosen = polynomials[..., piece, :]
    value = chosen[..., -1]
    for k in range(chosen.shape[-1] - 2, -1, -1):
        value = value * u + chosen[..., k]
    return np.asarray(value)


def _extremes(polynomials: Floats) -> tuple[float, float]:
    """Return the least and the largest value of piecewise polynomials (J, n) in u from 0 to 1."""
    found = [(p, _inside(np.polynomial.polynomial.polyder(p))) for p in polynomials]
    values = np.concatenate([np.polynomial.polynomial.polyval(u, p) for p, u in found])
    return float(values.min()), float(values.max())


def farthest(polynomials: Floats) -> float:
    """Return the largest distance from the origin of piecewise polynomials (2, J, n) in u from 0 to 1."""
    x, y = polynomials
    best = float(np.hypot(x[:, 0], y[:, 0]).max())
    bounds = np.hypot(np.abs(x).sum(axis=1), np.abs(y).sum(axis=1))
    for j in np.argsort(-bounds):
        if bounds[j] <= best:
            break
        square = np.convolve(x[j], x[j]) + np.convolve(y[j], y[j])
        u = _inside(np.polynomial.polynomial.polyder(square))
        both = (np.polynomial.polynomial.polyval(u, p[j]) for p in (x, y))
        best = max(best, float(np.hypot(*both).max()))
    return best


def _inside(derivative: Floats) -> Floats:
    """Return 0, 1 and the roots of a polynomial between them."""
    size = np.abs(derivative)
    kept = np.flatnonzero(size > np.finfo(float).eps * size.max(initial=0.0))
    roots = np.polynomial.polynomial.polyroots(derivative[: kept[-1] + 1]) if kept.size else np.zeros(0)
    real = roots.real[np.abs(roots.imag) <= _REAL]
    return np.concatenate([[0.0, 1.0], real[(real > 0.0) & (real < 1.0)]])


def widest(path: Path, phases: Floats) -> float:
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
_POINTS: Final = 512  # of a path, besides its breaks, among which the widest pair is searched
_PAIRS: Final = f"up to {MOST_HARMONICS} pairs of an amplitude and a phase"
_STEPS: Final = f"up to {MOST_PIECES} pairs of a share of the period and an acceleration"
_SAMPLES: Final = f"a list of {LEAST_SAMPLES} to {MOST_PIECES} finite numbers: one period, equally spaced"
_QUANTITIES: Final = ("acceleration", "displacement")


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
        0.896 g
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

        Errors of the acceleration, root mean square over the largest one, with 128 samples a period
        (benchmarks/samples.py):

        ============================  =========================  =============  ==================
        samples of acceleration       sine with harmonics        trapezoid      two levels
        ============================  =========================  =============  ==================
        spline (used)                 3e-5 %                     0.23 %         8 % (1024: 2.3 %)
        16 harmonics                  rounding                   1.1 %          11 %
        ============================  =========================  =============  ==================

        The trapezoid has ramps of 5 % of the period. For displacements with 0.1 % of noise the errors of the
        sine are 0.3 % with the significant harmonics (used), 4 % with all 16, and 130 % with a spline that is
        differentiated twice.

        Examples
        --------
        >>> import numpy as np, vibro
        >>> share = np.arange(64) / 64
        >>> motion = vibro.Motion.samples(along=-3.0 * np.sin(2.0 * np.pi * share))
        >>> print(f"{motion.largest_acceleration:.6f} m/s^2")
        3.000000 m/s^2
        """
        return sampled_motion(along, normal, of, ("along", "normal"))


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
        return farthest(self.pieces)

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
        return _integral(self.pieces, np.diff(self.breaks))

    @cached_property
    def positions(self) -> Floats:
        """Positions at 1 Hz: as ``pieces``, of degree 5 [m]."""
        return _integral(self.velocities, np.diff(self.breaks))

    @cached_property
    def reach(self) -> float:
        """Largest distance from the mean position at 1 Hz [m]."""
        return farthest(self.positions)

    @cached_property
    def stroke(self) -> float:
        """Largest distance between two points of the path at 1 Hz [m]."""
        moving = [x for x in self.positions if np.any(x)]
        if len(moving) < 2:
            least, most = _extremes(moving[0]) if moving else (0.0, 0.0)
            return most - least

        def path(shares: Floats) -> tuple[Floats, Floats, Floats]:
            at = np.mod(shares, 1.0)
            found = (values_at(x, self.breaks, at) for x in (self.positions, self.velocities, self.pieces))
            position, velocity, acceleration = found
            return position, velocity, acceleration

        return widest(path, np.unique(np.concatenate([np.arange(_POINTS) / _POINTS, self.breaks[:-1]])))

    @shielded
    def accelerations(self, shares: ArrayLike) -> Floats:
        """Return accelerations along and normal, of shape (2, ...), at shares of the period [m/s^2]."""
        return values_at(self.pieces, self.breaks, np.mod(shares, 1.0))


def harmonic_motion(given: Sequence[Any], names: tuple[str, str]) -> HarmonicMotion:
    """Return ``Motion.harmonics`` of both directions; messages call them by these names."""
    read, problems = [], []
    for name, value in zip(names, given, strict=True):
        pairs, wrong = _read_harmonics(name, value)
        read.append(pairs)
        problems += wrong
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
        raise SceneError((Problem("of", shown(of), " or ".join(_QUANTITIES)),))
    sizes = [np.shape(samples) for samples in (along, normal) if samples is not None]
    if [len(size) for size in sizes] == [1, 1] and sizes[0] != sizes[1]:  # else one of them is refused below
        raise SceneError(
            (Problem(names[1], f"{sizes[1][0]} samples", f"as many as {names[0]}, {sizes[0][0]}"),)
        )
    if of == "acceleration":
        return _piecewise(along, normal, names, _read_accelerations)
    given = [
        None if x is None else _harmonics_of(_read_samples(name, x, SHIFTED))
        for name, x in zip(names, (along, normal), strict=True)
    ]
    return harmonic_motion(given, names)


def _read_harmonics(name: str, value: Any) -> tuple[Pairs, list[Problem]]:
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
        return (), [Problem(name, shown(value), _PAIRS)]
    if len(pairs) > MOST_HARMONICS or any(len(pair) != 2 for pair in pairs):
        return (), [Problem(name, shown(value), _PAIRS)]
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
    given = [pieces for pieces in found if pieces is not None]
    if not given and not problems:
        problems.append(Problem(names[0], "none", f"given, or {names[1]}"))
    if problems:
        raise SceneError(tuple(problems))
    breaks = _union([own for own, _ in given])
    if breaks.size > MOST_PIECES + 1:
        told = f"{breaks.size - 1} different pieces along and normal"
        raise SceneError((Problem(names[1], told, f"such that they are at most {MOST_PIECES}"),))
    none = np.zeros((breaks.size - 1, 4))
    pieces = np.array([none if own is None else _cut(*own, breaks) for own in found])
    for _ in range(2):  # the second time what rounding left
        pieces[..., 0] -= _mean(breaks, pieces)[:, np.newaxis]
    breaks.flags.writeable = pieces.flags.writeable = False
    return PiecewiseMotion(breaks, pieces)


def _read_steps(name: str, value: Any) -> Pieces:
    """Read shares and accelerations; refuse a motion that does not come back."""
    try:
        steps = real_array(value if isinstance(value, np.ndarray) else [*value])
    except NotRealError as exc:
        raise SceneError((Problem(name, exc.value, _STEPS),)) from None
    except TypeError:
        raise SceneError((Problem(name, shown(value), _STEPS),)) from None
    if steps.ndim != 2 or steps.shape[1] != 2 or not 0 < len(steps) <= MOST_PIECES:
        raise SceneError((Problem(name, shown(value), _STEPS),))
    shares, accelerations = steps.T
    for share in shares[~((shares > _WHOLE) & (shares <= POSITIVE.high))][:1]:
        allowed = f"shares above {_WHOLE:g}, up to {POSITIVE.high:g}"
        raise SceneError((Problem(name, f"a share of {share:.15g}", allowed),))
    _check(name, accelerations, SHAKEN)
    total = math.fsum(shares)
    if abs(total - 1.0) > _WHOLE:
        last = 1.0 - math.fsum(shares[:-1])
        remedy = f"give the last one {last:.9g}" if last > _WHOLE else f"divide each by {total:.9g}"
        told = f"shares of {total:.10g} in all"
        raise SceneError((Problem(name, told, f"shares that add up to 1: {remedy}"),))
    mean = math.fsum(shares * accelerations) / total
    if abs(mean) > _OPEN * np.abs(accelerations).max():
        last = -math.fsum(shares[:-1] * accelerations[:-1]) / shares[-1]
        told = f"a mean acceleration of {mean:.6g} m/s^2"
        remedy = f"the trough comes back if the last is {last:.9g} m/s^2"
        raise SceneError((Problem(name, told, f"at most {100.0 * _OPEN:g} % of the largest: {remedy}"),))
    breaks = np.concatenate([[0.0], np.cumsum(shares) / total])
    breaks[-1] = 1.0
    return breaks, np.pad(accelerations[:, np.newaxis], ((0, 0), (0, 3)))


def _check(name: str, values: Floats, quantity: Quantity) -> None:
    """Raise SceneError unless all values are in a range [SI], and not all are next to 0 but for zeros."""
    unit, least = quantity.kind.si_unit, quantity.to_si(POSITIVE.low)
    for value in values[~quantity.allows(values)][:1]:
        raise SceneError((Problem(name, f"{value:.15g} {unit}", quantity.range_text),))
    if 0.0 < (largest := float(np.abs(values).max())) < least:
        raise SceneError((Problem(name, f"at most {largest:.15g} {unit}", f"0, or up to {least:g} {unit}"),))


def _read_samples(name: str, value: Any, quantity: Quantity) -> Floats:
    try:
        samples = real_array(value)
    except NotRealError as exc:
        raise SceneError((Problem(name, exc.value, _SAMPLES),)) from None
    if samples.ndim != 1 or not LEAST_SAMPLES <= samples.size <= MOST_PIECES:
        told = f"{samples.size} samples" if samples.ndim == 1 else shown(value)
        raise SceneError((Problem(name, told, _SAMPLES),))
    for sample in samples[~np.isfinite(samples)][:1]:
        raise SceneError((Problem(name, str(sample), _SAMPLES),))
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


def _mean(breaks: Floats, pieces: Floats) -> Floats:
    """Return the means of both directions over the period."""
    return np.asarray(((pieces / np.arange(1, 5)).sum(axis=-1) * np.diff(breaks)).sum(axis=-1))


_ONE: Final = np.ones(())
_NOTHING: Final = np.full((), np.nan)
_PATH_POINTS: Final = 64  # points of the path per harmonic, which bracket the farthest one
_TOGETHER: Final = 65_536  # of such points are computed in one pass: they stay in the processor's cache
_NEWTON_STEPS: Final = 6  # of Newton's method from there; each squares the error, which begins at 1e-3


class Ability(Enum):
    """Results that only some kinds of drive have; every kind has steady cycles, critical loads, histories."""

    ONE_HARMONIC = "closed forms of slides"
    PROOF = "closed forms and proved bounds"


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

    def columns(self) -> _Columns:
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

    def columns(self) -> _Columns:
        """Return the columns that the solver reads."""
        return _Columns((self.amplitude, self.drive_angle, _ONE, *self[1:2], *self[3:]), LINE)

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

    def columns(self) -> _Columns:
        """Return the columns that the solver reads."""
        return _Columns(tuple(self), ELLIPSE)

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

    def columns(self) -> _Columns:
        """Return the columns that the solver reads."""
        return _Columns((*self._first_columns, *self[0], *self[1], *self[2], *self[3]), HARMONICS)

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

    def columns(self) -> _Columns:
        """Return the columns that the solver reads."""
        motion = self.motion
        return _Columns(self._first_columns, PIECES, motion.breaks, motion.pieces, motion.unit)


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
    step = max(_TOGETHER // (_PATH_POINTS * count), 1)
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

    step = 2.0 * np.pi / (_PATH_POINTS * count)
    angles = step * np.outer(np.arange(_PATH_POINTS * count), n)
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
    for _ in range(_NEWTON_STEPS):
        _, slope, bend = square(at)
        at = at - np.clip(slope / np.where(bend < 0.0, bend, -np.inf), -step, step)
        best = np.maximum(best, np.sqrt(square(at)[0]))
    return np.asarray(best * unit)


def _widest(fields: Harmonics) -> Floats:
    """Return the largest distance between two points of a path, of each path by itself."""
    waves, shape = _waves_of(fields)
    count = waves.shape[1]
    n = np.arange(1, count + 1)[:, np.newaxis]
    phases = np.linspace(0.0, 2.0 * np.pi, _PATH_POINTS * count, endpoint=False)
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
