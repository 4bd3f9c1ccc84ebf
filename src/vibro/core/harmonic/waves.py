"""Trigonometric polynomials: their turning points, and the zeros between these, none of which is missed.

A wave f(p) = c_0 + sum_n s_n sin(n p) + c_n cos(n p), n = 1 ... H, is a column [c_0, s_1 ... s_H, c_1 ...
c_H] of an array. Its derivative is a wave too, and neither has more than 2 H zeros a turn.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.harmonic.chain import zeros_by_derivatives
from vibro.core.harmonic.zeros import FINE, ROUGH, Tolerance, level_start, zeros

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]

__all__ = [
    "TURN",
    "crossings",
    "harmonics",
    "in_order",
    "rough_crossings",
    "slopes_of",
    "turning_points",
    "values",
    "wrapped",
]

TURN: Final = 2.0 * np.pi

# [1] Samples of a wave a harmonic; see ``_isolated``.
_SAMPLES: Final = 12
# Products of matrices of this size stay in cache, and in the thread that asks for them.
_PRODUCT: Final = 250_000


def wrapped(p: Floats) -> Floats:
    """Phases in [0, 2 pi), whole turns away; a tenth of the time of ``np.mod``."""
    return np.asarray(p - TURN * np.floor(p / TURN))


def harmonics(p: Floats, count: int) -> list[tuple[Floats, Floats]]:
    """Sines and cosines of n p, n = 1 ... count."""
    t = np.tan(0.5 * p)  # one function in place of a sine and a cosine
    rise = 2.0 / (1.0 + t * t)
    sine, cosine = rise * t, rise - 1.0
    out = [(sine, cosine)]
    for _ in range(count - 1):
        s, c = out[-1]
        out.append((s * cosine + c * sine, c * cosine - s * sine))
    return out


def values(waves: Floats, p: Floats) -> Floats:
    """Waves, one a column, at phases: one a column, or rows of them."""
    h = waves.shape[0] // 2
    total: Floats = waves[0]
    for n, (s, c) in enumerate(harmonics(p, h), 1):
        total = total + (waves[n] * s + waves[h + n] * c)
    return total


def _with_derivatives(p: Floats, waves: Floats) -> tuple[Floats, Floats, Floats]:
    h = waves.shape[0] // 2
    total, slope, bend = waves[0].copy(), np.zeros(p.shape), np.zeros(p.shape)
    for n, (s, c) in enumerate(harmonics(p, h), 1):
        part = waves[n] * s + waves[h + n] * c
        total += part
        slope += n * (waves[n] * c - waves[h + n] * s)
        bend -= n * n * part
    return total, slope, bend


def slopes_of(waves: Floats) -> Floats:
    """Differentiate waves; their derivatives are waves."""
    h = waves.shape[0] // 2
    n = np.arange(1, h + 1)[:, np.newaxis]
    return np.concatenate([np.zeros((1, waves.shape[1])), -n * waves[h + 1 :], n * waves[1 : h + 1]])


class _Isolated(NamedTuple):
    """All zeros of some waves.

    Attributes
    ----------
    sure : bool array
        Whether these are all; a wave without that has none here.
    column : int array
        Wave of each zero, in rising order.
    row : int array
        Its number within the wave.
    phase : array
        In rising order within each wave, from 0 to 2 pi.
    falls : bool array
        Whether the wave falls there.
    """

    sure: Bools
    column: Indices
    row: Indices
    phase: Floats
    falls: Bools


def _isolated(waves: Floats) -> _Isolated:
    """Find all zeros of waves by samples where these leave no doubt.

    Notes
    -----
    A wave has 2 H zeros at most. Where the samples change their sign as often, there is one in between each
    time. Else there may be two more between neighbours. Let the wave's second derivative be B at most, and
    neighbours d apart. Two zeros between samples of one sign need one of these within B d^2/8 of zero; and
    three between samples of opposite sign both of them within H B d^3/6, which is less.
    """
    h = waves.shape[0] // 2
    count = _SAMPLES * h
    apart = TURN / count
    samples = waves.T @ _sampling(h)  # one before the first phase, and two from a turn on
    inner = samples[:, 1:-1]
    positive = inner > 0.0
    changes = positive[:, 1:] != positive[:, :-1]
    number = changes.sum(axis=1)
    sure = number == 2 * h
    doubtful = (number < 2 * h).nonzero()[0]
    n = np.arange(1, h + 1)
    most = n * n @ np.hypot(waves[1 : h + 1, doubtful], waves[h + 1 :, doubtful])
    size = np.abs(inner[doubtful])
    ends = size[:, 1:], size[:, :-1]
    least = np.where(changes[doubtful], np.maximum(*ends), np.minimum(*ends))
    sure[doubtful] = (least > (apart * apart / 8.0 * most)[:, np.newaxis]).all(axis=1)
    changes &= sure[:, np.newaxis]
    column: Indices
    place: Indices
    column, place = np.divmod(changes.reshape(-1).nonzero()[0], count)
    number[~sure] = 0
    row = np.arange(column.size) - np.repeat(np.cumsum(number) - number, number)
    # the zero of the parabola between two samples, by those beside them too
    base = column * samples.shape[1] + place
    flat = samples.reshape(-1)
    left, right = flat[base + 1], flat[base + 2]
    bend = 0.25 * (flat[base] - left - right + flat[base + 3])
    share = left / (left - right)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        better = share - bend * share * (share - 1.0) / (right - left + bend * (2.0 * share - 1.0))
    low = apart * place
    start = low + apart * np.where(np.abs(better - 0.5) <= 0.5, better, share)
    falls = left > 0.0
    phase, _ = zeros(
        _with_derivatives, waves.take(column, axis=1), start, low, low + apart, falls, tolerance=ROUGH
    )
    return _Isolated(sure, column, row, phase, falls)


def _pieces(waves: Floats) -> list[slice]:
    """Columns to be sampled together."""
    size = max(1, _PRODUCT // _sampling(waves.shape[0] // 2).size)
    return [slice(i, i + size) for i in range(0, waves.shape[1], size)]


@lru_cache
def _sampling(h: int) -> Floats:
    """Columns that give a wave's values at equidistant phases, from one before 0 to one after a turn."""
    count = _SAMPLES * h
    angles = TURN / count * np.outer(np.arange(1, h + 1), np.arange(-1, count + 2) % count)
    return np.concatenate([np.ones((1, count + 3)), np.sin(angles), np.cos(angles)])


def in_order(phases: Floats) -> Floats:
    """Sort each column of a few rows, NaN last; faster than ``np.sort``."""
    rows = list(phases)
    for last in range(len(rows) - 1, 0, -1):
        for i in range(last):
            rows[i], rows[i + 1] = np.fmin(rows[i], rows[i + 1]), np.maximum(rows[i], rows[i + 1])
    return np.array(rows)


def turning_points(waves: Floats) -> Floats:
    """Phases in rising order, at most a turn apart, between which each wave is monotone.

    Returns
    -------
    array
        2 H rows: every turning point, to about 1e-9, and where there are fewer, other phases.
    """
    slopes = slopes_of(waves)
    points = np.full((waves.shape[0] - 1, waves.shape[1]), -np.inf)
    sure = np.empty(waves.shape[1], np.bool_)
    for part in _pieces(waves):
        found = _isolated(slopes[:, part])
        sure[part] = found.sure
        points[found.row, part.start + found.column] = found.phase
    points = np.maximum.accumulate(points, axis=0)  # the last one again where there are fewer
    rest = (~sure).nonzero()[0]
    points[:, rest] = zeros_by_derivatives(slopes.take(rest, axis=1))
    return points


def rough_crossings(waves: Floats) -> tuple[Floats, Floats]:
    """Find the zeros of waves to about 1e-9; see ``crossings``."""
    h, count = waves.shape[0] // 2, waves.shape[1]
    phases = np.full((2, 2 * h, count), np.nan)  # upwards, downwards
    sure = np.empty(count, np.bool_)
    for part in _pieces(waves):
        found = _isolated(waves[:, part])
        sure[part] = found.sure
        falls = found.falls.astype(np.intp)
        phases[falls, found.row, part.start + found.column] = wrapped(found.phase)
    up, down = (in_order(x)[:h] for x in phases)
    rest = (~sure).nonzero()[0]
    some = waves.take(rest, axis=1)
    points = turning_points(some)
    up[:, rest], down[:, rest] = crossings(some, points, values(some, points), ROUGH)
    return up, down


def crossings(
    waves: Floats, points: Floats, at: Floats, tolerance: Tolerance = FINE
) -> tuple[Floats, Floats]:
    """Find the zeros of waves, by their turning points and the values there.

    Parameters
    ----------
    waves : array
        One a column.
    points, at : array
        From ``turning_points``, and the waves' values there.
    tolerance : Tolerance, optional
        Of the zeros.

    Returns
    -------
    up, down : array
        Phases where a wave becomes positive, and where it ceases to be, H rows, in [0, 2 pi) and rising
        order; NaN after the last.
    """
    h = waves.shape[0] // 2
    edges = np.concatenate([points, points[:1] + TURN])
    at = np.concatenate([at, at[:1]])
    positive = at > 0.0
    changes = positive[1:] != positive[:-1]
    row, column = np.nonzero(changes)
    low, high = (row, column), (row + 1, column)
    found = np.full(points.shape, np.nan)
    ends = edges[low], edges[high]
    start = level_start(*ends, at[low], at[high])
    found[low], _ = zeros(
        _with_derivatives, waves.take(column, axis=1), start, *ends, positive[low], tolerance=tolerance
    )
    found = wrapped(found)
    rises = positive[1:]
    up, down = (in_order(np.where(which, found, np.nan))[:h] for which in (rises, ~rises))
    return up, down
