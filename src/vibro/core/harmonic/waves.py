"""Trigonometric polynomials: their turning points, and the zeros between these, none of which is missed.

A wave f(p) = c_0 + sum_n s_n sin(n p) + c_n cos(n p), n = 1 ... H, is a column [c_0, s_1 ... s_H, c_1 ...
c_H] of an array. Its derivative is a wave too; times (1 + t^2)^H with t = tan(p/2) it is a polynomial of
degree 2 H in t, whose real zeros lie between those of its derivative, which lie between those of the next,
and so on.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.roots import OpenCells

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Indices = NDArray[np.intp]
    #: Values and slopes at points, one per column of an array that is handed on.
    Function = Callable[[Floats, Floats], tuple[Floats, Floats]]

__all__ = ["TURN", "crossings", "harmonics", "slopes_of", "turning_points", "values", "wrapped", "zeros"]

TURN: Final = 2.0 * np.pi

_MOST_STEPS: Final = 80  # halvings from a turn down to an ulp, and a few more

# [1] A Newton step below this share of the unit leaves rounding errors: its error is the step's square over
# the distance from the next turning point, and its conditioning is one over that distance.
_SETTLED: Final = 3e-9
# [1] Where waves or speeds turn need not be known so well: their values there change with the square of an
# error, and that is what is left of the square of the last step.
_ROUGH: Final = 1e-5 / _SETTLED


def wrapped(p: Floats) -> Floats:
    """Phases in [0, 2 pi), whole turns away; a tenth of the time of ``np.mod``."""
    return np.asarray(p - TURN * np.floor(p / TURN))


def harmonics(p: Floats, count: int) -> list[tuple[Floats, Floats]]:
    """Sines and cosines of n p, n = 1 ... count."""
    t = np.tan(0.5 * p)  # a tenth of the time of a sine and a cosine
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


def _value_and_slope(p: Floats, waves: Floats) -> tuple[Floats, Floats]:
    h = waves.shape[0] // 2
    total, slope = waves[0].copy(), np.zeros(p.shape)
    for n, (s, c) in enumerate(harmonics(p, h), 1):
        total += waves[n] * s + waves[h + n] * c
        slope += n * (waves[n] * c - waves[h + n] * s)
    return total, slope


def slopes_of(waves: Floats) -> Floats:
    """Differentiate waves; their derivatives are waves."""
    h = waves.shape[0] // 2
    n = np.arange(1, h + 1)[:, np.newaxis]
    return np.concatenate([np.zeros((1, waves.shape[1])), -n * waves[h + 1 :], n * waves[1 : h + 1]])


def zeros(
    function: Function,
    group: Floats,
    low: Floats,
    high: Floats,
    at_low: Floats,
    at_high: Floats,
    unit: Floats | float = 1.0,
) -> tuple[Floats, Bools]:
    """Find where monotone functions change their sign, by Newton's method inside their brackets.

    Parameters
    ----------
    function : callable
        Of points and of their columns of ``group``.
    group : array
        What belongs to each bracket, one column each.
    low, high : array
        Brackets.
    at_low, at_high : array
        The functions' values there, of opposite sign or zero.
    unit : array or float, optional
        Lengths beside which the last step must be small.

    Returns
    -------
    zeros : array
        One each.
    settled : bool array
        Whether the iteration ended.

    Notes
    -----
    It starts from the zero of the cubic that is level at both ends, where the functions mostly are, too. A
    step out of the bracket is replaced by halving it.
    """
    share = np.clip((at_low + at_high) / (at_low - at_high), -1.0, 1.0)  # 1 - 2 at_low / (at_low - at_high)
    x = low + (high - low) * (0.5 + np.sin(np.arcsin(share) / 3.0))
    found, settled = x.copy(), np.zeros(x.shape, np.bool_)
    last = np.broadcast_to(_SETTLED * unit, x.shape)
    cells = OpenCells(np.arange(x.size), (x, low, high, at_low > 0.0, last, group), _MOST_STEPS)
    for open_, (x, low, high, falls, last, own) in cells:
        value, slope = function(x, own)
        before = (value > 0.0) == falls
        low, high = np.where(before, x, low), np.where(before, high, x)
        with np.errstate(divide="ignore", invalid="ignore"):
            better = x - value / slope
        # a last step may leave the bracket by rounding
        close = np.abs(better - x) <= last
        inside = (better >= low) & (better <= high)
        middle = 0.5 * (low + high)
        better = np.where(inside, better, np.where(close, np.clip(better, low, high), middle))
        close |= high - low <= 4e-16 * np.abs(middle)
        found[open_] = better
        settled[open_] = close
        cells.group = (better, low, high, falls, last, own)
        stays = ~close
        if np.count_nonzero(stays) < stays.size:
            going = stays.nonzero()[0]
            cells.cells = open_[going]
            cells.group = (better[going], low[going], high[going], falls[going], last[going], own[:, going])
    return found, settled


class _Tables(NamedTuple):
    """Constants of waves of so many harmonics.

    Attributes
    ----------
    samples : array
        Rows that give a wave's values at equidistant phases.
    polynomials : tuple of arrays
        For each of them the rows that give the coefficients, lowest power first, of the wave's polynomial in
        tan((p - phase - pi)/2): its pole lies at that phase.
    phases : array
        Those phases.
    reach : float
        No zero of a wave lies further out in t if its pole is where the largest of the values is.
    """

    samples: Floats
    polynomials: tuple[Floats, ...]
    phases: Floats
    reach: float


@lru_cache
def _tables(h: int) -> _Tables:
    """Make the constants.

    By a theorem of M. Riesz a wave falls from its largest modulus, at p0, no faster than cos(H (p - p0)): it
    has no zero within pi/(2 H) of p0, nor within half of that of the nearest of 4 H samples.
    """
    n = np.arange(1, h + 1)
    phases = TURN / (4 * h) * np.arange(4 * h)
    angles = np.outer(phases, n)
    samples = np.concatenate([np.ones((4 * h, 1)), np.sin(angles), np.cos(angles)], axis=1)
    # (1 + t^2)^H exp(i n p) = (1 + i t)^(H + n) (1 - i t)^(H - n)
    turns = [np.poly1d([1j, 1.0]) ** (h + k) * np.poly1d([-1j, 1.0]) ** (h - k) for k in range(h + 1)]
    rows = [np.pad(turn.c[::-1], (0, 2 * h + 1 - turn.c.size)) for turn in turns]
    plain = np.array([rows[0].real, *(row.imag for row in rows[1:]), *(row.real for row in rows[1:])]).T
    polynomials = []
    for phase in phases:
        turned = np.eye(2 * h + 1)
        for k in n:
            s, c = np.sin(k * (phase + np.pi)), np.cos(k * (phase + np.pi))
            turned[k, k], turned[k, h + k] = c, -s
            turned[h + k, k], turned[h + k, h + k] = s, c
        polynomials.append(plain @ turned)
    reach = 1.0 / float(np.tan(np.pi / (8 * h))) * (1.0 + 1e-9)
    return _Tables(samples, tuple(polynomials), np.asarray(phases, np.float64), reach)


def _horner(t: Floats, coefficients: Floats) -> tuple[Floats, Floats]:
    """Values and slopes of polynomials, lowest power first."""
    value, slope = coefficients[-1], np.zeros(t.shape)
    for a in coefficients[-2::-1]:
        slope = slope * t + value
        value = value * t + a
    return value, slope


def _chain(polynomials: Floats, reach: float) -> Floats:
    """Points in rising order that contain all real zeros of polynomials within +-reach.

    As many as the degree, one a row; where there are fewer zeros, others that do no harm.
    """
    degree = polynomials.shape[0] - 1
    count = polynomials.shape[1]
    ends = np.full((1, count), reach)
    points = np.empty((0, count))
    derivatives = [polynomials]
    for _ in range(degree - 1):
        last = derivatives[-1]
        derivatives.append(last[1:] * np.arange(1, last.shape[0])[:, np.newaxis])
    for f in reversed(derivatives):
        if f.shape[0] == 3:  # a quadratic needs no turning point
            points = _quadratic(f, reach)
            continue
        if f.shape[0] == 2:
            continue
        edges = np.concatenate([-ends, points, ends])
        at = f[-1]
        for a in f[-2::-1]:
            at = at * edges + a
        positive = at > 0.0
        row, column = np.nonzero(positive[1:] != positive[:-1])
        points = edges[1:].copy()
        pick = (row, column), (row + 1, column)
        points[row, column], _ = zeros(
            _horner, f[:, column], edges[pick[0]], edges[pick[1]], at[pick[0]], at[pick[1]], _ROUGH
        )
    return points


def _quadratic(f: Floats, reach: float) -> Floats:
    """Zeros of quadratics, in rising order within +-reach; the vertex twice where there are none."""
    c, b, a = f
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0))
        q = -0.5 * (b + np.copysign(root, b))
        pair = np.array([q / a, np.where(q == 0.0, 0.0, c / q)])
        vertex = -0.5 * b / a
    pair = np.where(root > 0.0, pair, vertex)
    pair = np.nan_to_num(pair, nan=0.0, posinf=reach, neginf=-reach).clip(-reach, reach)
    return np.sort(pair, axis=0)


def turning_points(waves: Floats) -> Floats:
    """Phases in rising order, less than a turn apart, between which each wave is monotone.

    Returns
    -------
    array
        2 H rows: every turning point, to about 1e-9, and where there are fewer, other phases.
    """
    slopes = slopes_of(waves)
    h = waves.shape[0] // 2
    tables = _tables(h)
    sampled = np.abs(tables.samples @ slopes)
    best = np.argmax(sampled, axis=0)
    polynomials = np.empty(waves.shape)
    for k, rows in enumerate(tables.polynomials):
        of_k = (best == k).nonzero()[0]
        if of_k.size:
            polynomials[:, of_k] = rows @ slopes[:, of_k]
    size = sampled.max(axis=0)
    polynomials /= np.where(size > 0.0, size, 1.0)
    points = _chain(polynomials, tables.reach)
    return np.asarray(2.0 * np.arctan(points) + (tables.phases[best] + np.pi))


def crossings(waves: Floats, points: Floats, at: Floats, *, rough: bool = False) -> tuple[Floats, Floats]:
    """Find the zeros of waves, by their turning points and the values there.

    Parameters
    ----------
    waves : array
        One a column.
    points, at : array
        From ``turning_points``, and the waves' values there.
    rough : bool, optional
        Whether about 1e-9 will do.

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
    ends = edges[low], edges[high], at[low], at[high]
    found[low], _ = zeros(_value_and_slope, waves[:, column], *ends, _ROUGH if rough else 1.0)
    found = wrapped(found)
    rises = positive[1:]
    up, down = (np.sort(np.where(which, found, np.nan), axis=0)[:h] for which in (rises, ~rises))
    return up, down
