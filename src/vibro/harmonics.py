"""Drives with harmonics: their fields, and what their paths come to."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Final, NamedTuple, NoReturn

import numpy as np

from vibro.core.harmonic.arrays import largest_amplitude
from vibro.core.harmonic.loads import HarmonicLoads, harmonic_loads
from vibro.errors import InputError, Problem, shown
from vibro.quantities import MOST_HARMONICS
from vibro.reals import NotRealError, real_array

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Harmonics = tuple[tuple[Floats, Floats], ...]

__all__ = ["HarmonicFields", "harmonic_fields", "read_harmonics"]

_POINTS: Final = 64  # of the path for each harmonic, between which the farthest one is bracketed
_STEPS: Final = 6  # of Newton's method from there: it squares an error of 1e-3 until nothing is left
_ALLOWED: Final = f"up to {MOST_HARMONICS} pairs of an amplitude and a phase"


class HarmonicFields(NamedTuple):
    """A drive with harmonics: its scene's fields, in the units of ``EllipticalFields``.

    The trough moves along itself as the sum of ``along_amplitudes[n-1] * sin(n w t + along_phases[n-1])``,
    and normal to itself alike, with as many harmonics.
    """

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

    @property
    def scale(self) -> Floats:
        """Length that the solvers count in, the largest of all amplitudes [m]."""
        return largest_amplitude(*self.along_amplitudes, *self.normal_amplitudes)

    @property
    def reach(self) -> Floats:
        """Farthest that the trough gets from its mean position [m]."""
        return _farthest(self, 0)

    @property
    def acceleration_reach(self) -> Floats:
        """Largest acceleration of the trough over w^2: a line of such an amplitude has the same load [m]."""
        return _farthest(self, 2)

    def harmonic_loads(self) -> HarmonicLoads:
        """Form the dimensionless groups, all but the restitution."""
        return harmonic_loads(
            self.along_amplitudes,
            self.along_phases,
            self.normal_amplitudes,
            self.normal_phases,
            self.frequency,
            self.static_friction,
            self.kinetic_friction,
            self.trough_angle,
            self.gravity,
        )

    def refuse(self) -> NoReturn:
        """Refuse what is known of drives along lines and ellipses alone."""
        raise InputError(
            "a drive with harmonics: of its bodies the steady cycle in contact alone is known",
            hint="vibro solve and vibro map, or vibro.solve and vibro.sweep, give it",
        )

    def members(self) -> list[tuple[str, str, Floats]]:
        """Return every array with the name of its field, and of a quantity with the same unit and range."""
        harmonics = [
            ("along_harmonics", "along_amplitude", self.along_amplitudes),
            ("along_harmonics", "normal_phase", self.along_phases),
            ("normal_harmonics", "normal_amplitude", self.normal_amplitudes),
            ("normal_harmonics", "normal_phase", self.normal_phases),
        ]
        found = [(field, name, x) for field, name, several in harmonics for x in several]
        return found + [(name, name, getattr(self, name)) for name in self._fields[4:]]


def harmonic_fields(along: Harmonics, normal: Harmonics, others: Iterable[Floats]) -> HarmonicFields:
    """Make the fields of a drive of which either motion may have fewer harmonics than the other."""
    count = max(len(along), len(normal))
    nothing = (np.zeros(()), np.zeros(()))
    (x, xi), (y, eta) = (
        zip(*pairs, *[nothing] * (count - len(pairs)), strict=True) for pairs in (along, normal)
    )
    return HarmonicFields(x, xi, y, eta, *others)


def read_harmonics(name: str, value: Any) -> tuple[Harmonics, list[Problem]]:
    """Read pairs of amplitudes and phases, the first harmonic first, and tell what is wrong with them.

    Returns
    -------
    tuple of pair of array
        Read-only copies as doubles; without any where the value is None.
    list of Problem
        Empty if nothing is.
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


def _farthest(fields: HarmonicFields, derivative: int) -> Floats:
    """Find how far a path gets from the origin, or that of its derivative over w^derivative.

    Its square is a trigonometric polynomial of degree 2 H. Parabolas through neighbouring points tell the
    highest of its tops but for 1e-6 of it, and Newton's method goes up to that one.
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
