"""Waves for the tests, as the core keeps them, and the same waves by NumPy alone.

A wave is ``constant + sum a_k sin k p + b_k cos k p``; pieces are cubics in the phase since they began.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from vibro.core.numbers import HARMONICS, MIXES, PIECES, ROOM, TURN
from vibro.core.waves import Waves, prepare_cells, prepare_pieces, read_harmonic, tabulate, with_bounds

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def view(values: Any) -> Any:
    """See numbers as a buffer."""
    array: Any = np.ascontiguousarray(values)
    return memoryview(array)


@functools.lru_cache
def _prepared(harmonics: int) -> bytes:
    numbers = np.zeros(ROOM * 2 * harmonics + 8 * harmonics * harmonics)
    prepare_cells(harmonics, view(numbers))
    return numbers.tobytes()


def harmonic_waves(along: Any, normal: Any) -> Waves:
    """Make S and B of complex coefficients: S = sum of Im(c_k exp(i k p))."""
    count = len(along)
    numbers = memoryview(bytearray(_prepared(count))).cast("d")
    waves = Waves(HARMONICS, count, numbers, view(np.zeros(2 * MIXES, np.int64)), 0.0, 0.0, 0.0)
    for is_normal, coefficients in ((False, along), (True, normal)):
        for k, c in enumerate(coefficients.tolist(), 1):
            read_harmonic(waves, is_normal, k, abs(c) / k**2, math.atan2(c.imag, c.real))
    tabulate(waves)
    return with_bounds(waves)


def coefficients_of(waves: Waves, *, normal: bool) -> Any:
    """Return the complex coefficients that the core keeps, rounded as they are."""
    start, count = (2 if normal else 0) * waves.size, waves.size
    numbers = np.array(waves.number[start : start + 2 * count])
    return numbers[:count] + 1j * numbers[count:]


def piecewise_waves(breaks: Floats, accelerations: Floats) -> Waves:
    """Make S and B of accelerations (2, J, 4) as ``Piecewise`` has them, in units of 1."""
    count = breaks.size - 1
    numbers = view(np.zeros(ROOM * 4 * count + 5 * count + 1))
    waves = Waves(PIECES, count, numbers, view(np.zeros(2 * MIXES, np.int64)), 0.0, 0.0, 0.0)
    prepare_pieces(waves, view(breaks), view(accelerations.reshape(-1)), 1.0)
    return with_bounds(waves)


def drawn_harmonics(rng: np.random.Generator, count: int) -> Any:
    """Draw the coefficients of a wave: harmonics fall with a random power of their order."""
    k = np.arange(1, count + 1)
    return (rng.normal(size=count) + 1j * rng.normal(size=count)) / k ** rng.uniform(0.0, 2.0)


def drawn_pieces(rng: np.random.Generator, count: int) -> tuple[Floats, Floats]:
    """Draw pieces of accelerations of up to 1 without a mean, with jumps; some are constant."""
    breaks = np.concatenate(([0.0], np.sort(rng.uniform(0.02, 0.98, count - 1)), [1.0]))
    pieces = rng.normal(size=(2, count, 4))
    pieces[:, 1:][:, rng.uniform(size=count - 1) < 0.3, 1:] = 0.0
    shares = np.diff(breaks)
    pieces[:, :, 0] -= (pieces @ (1.0 / np.arange(1, 5)) @ shares)[:, None]
    return breaks, pieces / np.abs(pieces).sum(axis=-1).max()


def harmonic_value(coefficients: Any, p: Any, constant: float = 0.0) -> Any:
    """Evaluate a wave of harmonics at many phases."""
    k = np.arange(1, len(coefficients) + 1)
    return constant + (np.exp(1j * np.multiply.outer(np.asarray(p), k)) @ coefficients).imag


def piecewise_value(breaks: Floats, pieces: Floats, p: Any) -> Any:
    """Evaluate accelerations (J, 4) of pieces at many phases."""
    share = np.asarray(p) / TURN
    share = share - np.floor(share)
    j = np.clip(np.searchsorted(breaks, share, side="right") - 1, 0, breaks.size - 2)
    u = (share - breaks[j]) / (breaks[j + 1] - breaks[j])
    return pieces[j, 0] + u * (pieces[j, 1] + u * (pieces[j, 2] + u * pieces[j, 3]))
