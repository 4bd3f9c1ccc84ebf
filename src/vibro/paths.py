"""Extreme distances on closed paths: of piecewise polynomials by their roots, of other paths by search."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    # From phases to positions (2, n), and to their first and second derivatives by phase.
    Path = Callable[[Floats], tuple[Floats, Floats, Floats]]

__all__ = ["extremes", "farthest", "integral", "values_at", "widest"]

_NEAR: Final = 0.99  # share of the widest sampled distance from which on a pair is refined
_STEPS: Final = 8  # of Newton's method; each squares the error, which begins at 1e-2
_REAL: Final = 1e-6  # [1] imaginary part up to which a computed root may be a double real one


def integral(polynomials: Floats, lengths: Floats) -> Floats:
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


def extremes(polynomials: Floats) -> tuple[float, float]:
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
    for _ in range(_STEPS):
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
