"""Zeros of trigonometric polynomials between those of their derivatives: none can be missed.

A wave times (1 + t^2)^H with t = tan(p/2) is a polynomial of degree 2 H in t, whose real zeros lie between
those of its derivative, which lie between those of the next, and so on.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibro.core.harmonic.zeros import ROUGH, level_start, zeros

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["zeros_by_derivatives"]


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
    phases = 2.0 * np.pi / (4 * h) * np.arange(4 * h)
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


def _horner(t: Floats, coefficients: Floats) -> tuple[Floats, Floats, Floats]:
    """Values and two derivatives of polynomials, lowest power first."""
    value, slope, bend = coefficients[-1], np.zeros(t.shape), np.zeros(t.shape)
    for a in coefficients[-2::-1]:
        bend = bend * t + slope
        slope = slope * t + value
        value = value * t + a
    return value, slope, 2.0 * bend


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
        ends_ = edges[pick[0]], edges[pick[1]]
        start = level_start(*ends_, at[pick[0]], at[pick[1]])
        points[row, column], _ = zeros(
            _horner, f.take(column, axis=1), start, *ends_, positive[pick[0]], tolerance=ROUGH
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


def zeros_by_derivatives(waves: Floats) -> Floats:
    """Find all zeros of waves between the zeros of their derivatives; other phases where there are fewer."""
    h = waves.shape[0] // 2
    tables = _tables(h)
    sampled = np.abs(tables.samples @ waves)
    best = np.argmax(sampled, axis=0)
    polynomials = np.empty(waves.shape)
    for k, rows in enumerate(tables.polynomials):
        of_k = (best == k).nonzero()[0]
        if of_k.size:
            polynomials[:, of_k] = rows @ waves[:, of_k]
    size = sampled.max(axis=0)
    polynomials /= np.where(size > 0.0, size, 1.0)
    points = _chain(polynomials, tables.reach)
    return np.asarray(2.0 * np.arctan(points) + (tables.phases[best] + np.pi))
