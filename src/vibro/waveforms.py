"""Periodic motions of a trough: sums of harmonics, steps of its acceleration, samples of one period."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from vibro.errors import Problem, SceneError, shown
from vibro.paths import extremes, farthest, integral, values_at, widest
from vibro.quantities import MOST_HARMONICS, POSITIVE, SHAKEN, SHIFTED
from vibro.reals import NotRealError, real_array, shielded

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence
    from os import PathLike

    from numpy.typing import ArrayLike, NDArray

    from vibro.quantities import Quantity

    Floats = NDArray[np.float64]
    Pairs = tuple[tuple[Floats, Floats], ...]
    GivenPairs = ArrayLike | Iterable[tuple[ArrayLike, ArrayLike]]
    Pieces = tuple[Floats, Floats]  # breaks (J + 1,), and the acceleration on each piece (J, 4)

__all__ = [
    "LEAST_SAMPLES",
    "MOST_PIECES",
    "HarmonicMotion",
    "Motion",
    "PiecewiseMotion",
    "harmonic_motion",
    "sampled_motion",
    "step_motion",
]

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

    Make it with ``Motion.harmonics``, ``Motion.steps``, ``Motion.samples`` or ``Motion.measured``. Motion
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

    @staticmethod
    @shielded
    def measured(path: str | PathLike[str], **columns: Any) -> Motion:
        """Return the motion that sensors on a trough have measured, as a sum of harmonics.

        ``vibro.measured_motion`` returns the frequency and the standard errors too.

        Parameters
        ----------
        path : str or path
            File of the record.
        **columns
            Other arguments of ``vibro.measured_motion``.

        Raises
        ------
        FileError, InputError
            As for ``vibro.measured_motion``.

        Examples
        --------
        >>> import vibro
        >>> motion = vibro.Motion.measured(
        ...     "examples/data/nut_trough_mv.csv", trough_along="Trog längs",
        ...     trough_normal="Trog normal", sensitivity="100mV/g")
        >>> print(f"{1e3 * float(motion.along[0][0]):.2f} mm along")
        0.96 mm along
        """
        from vibro.records.waveforms import measured_motion  # late: reading records is a room above

        measured = measured_motion(path, **columns).motion
        along, normal = (
            [(abs(z), np.angle(z)) for z in way] if way.any() else None
            for way in (measured.along, measured.normal)
        )
        return Motion.harmonics(along, normal)


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
        return integral(self.pieces, np.diff(self.breaks))

    @cached_property
    def positions(self) -> Floats:
        """Positions at 1 Hz: as ``pieces``, of degree 5 [m]."""
        return integral(self.velocities, np.diff(self.breaks))

    @cached_property
    def reach(self) -> float:
        """Largest distance from the mean position at 1 Hz [m]."""
        return farthest(self.positions)

    @cached_property
    def stroke(self) -> float:
        """Largest distance between two points of the path at 1 Hz [m]."""
        moving = [x for x in self.positions if np.any(x)]
        if len(moving) < 2:
            least, most = extremes(moving[0]) if moving else (0.0, 0.0)
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
