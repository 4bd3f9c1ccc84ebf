"""One slide from rest, solved once: where it ends, how far it goes, how fast it gets.

Equation numbers are those of docs/theory.md. All quantities are normalised by the inertial load:
lengths by A, speeds by A w, phases in radians. A forward slide and a back slide are the same
problem; the caller turns the sign.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.groups import put, take
from vibro.core.roots import bisect
from vibro.core.series import Q, R, polynomial

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

__all__ = ["Onset", "Slide", "slide", "start_inside"]

# Q to 1e-7 (1 - x^2 / pi^2), as far as the first step of the refinement needs it: exact where sin x vanishes.
_ROUGH_Q: Final = tuple(map(np.array, (
    2.07021594934088201e-8, -2.710588200256295715e-6, 0.0001982099143356336995,
    -0.008332991690635963418, 0.1666665646386242498,
)))  # fmt: skip
# Q, R, R and Q as the rows of one polynomial, to be evaluated at once.
_ROWS: Final = tuple(np.array([[q], [r], [r], [q]]) for q, r in zip((0.0, *Q), R, strict=True))

# Start of the refinement, Eq. (13): coefficients of rho theta^2, theta^2, rho and 1, with rho = c / theta.
_START: Final = (-0.07074, 0.001219, 0.11467, -0.314847)

_TINY: Final = 1e-300  # [1] the step of a slide of no length would be 0 / 0: added to its denominator
# [rad] Where k -> 0 and p0 -> 0 the estimate divides 0 by 0; this, the rounding of p0 = pi/2 - c, is added.
_PHASE_NOISE: Final = 1e-15

# A second step above this fraction of x would leave more than rounding errors.
_SETTLED: Final = 1e-4


class Onset(NamedTuple):
    """Start of a slide at phase p0, in the form that does not cancel near the crest of the load.

    Attributes
    ----------
    c : array
        pi/2 - p0 [rad]: positive before the load's crest, negative after it.
    cos, sin, vers : array
        cos c = sin p0, sin c = cos p0, and 1 - cos c computed without cancellation.
    excess : array
        sin p0 - k, computed without cancellation.
    k : array
        Resistance over load amplitude while sliding.
    """

    c: Floats
    cos: Floats
    sin: Floats
    vers: Floats
    excess: Floats
    k: Floats


def start_inside(c: Floats, k: Floats) -> Onset:
    """Onset of a slide that follows another one directly, anywhere inside its load window."""
    half = np.sin(0.5 * c)
    vers = 2.0 * half * half
    cos = 1.0 - vers
    return Onset(c, cos, np.sin(c), vers, cos - k, k)


def _theta(onset: Onset) -> tuple[Floats, Floats]:
    """1 - k and theta = acos k, without cancellation for k -> 1; pi for k < -1, where no slide ends."""
    kappa = onset.vers + onset.excess
    return kappa, 2.0 * np.arcsin(np.sqrt(np.minimum(0.5 * kappa, 1.0)))


def _start(onset: Onset, theta: Floats) -> Floats:
    """First estimate of half the slide's length in phase, Eq. (13).

    Exact for k -> 0, of the right order for theta -> 0 and with the right branch point in the corner
    k -> 0, p0 -> 0; everywhere within 1.2 % of the distance to the nearest other root (test_slide.py).
    """
    c, k = onset.c, onset.k
    p0 = 0.5 * np.pi - c
    resistance = 2.0 * k
    corner = resistance / (p0 + np.sqrt(p0 * p0 + resistance * (np.pi + 2.0 * c)) + _PHASE_NOISE)
    rho = c / theta
    bend = (_START[0] * rho + _START[1]) * (theta * theta) + (_START[2] * rho + _START[3])
    return (theta + c) * (1.0 - corner - k * bend)


class _Evaluation(NamedTuple):
    """Eq. (12) at x, with what the displacement needs; u = x - c."""

    step: Floats
    sin_x: Floats
    cos_x: Floats
    sin_u: Floats
    cos_u: Floats


def _evaluate(x: Floats, gap: Floats, onset: Onset) -> _Evaluation:
    """Halley's step at x, written in terms that all vanish like x^2; ``gap`` is 1 - sin(x)/x."""
    t = np.tan(0.5 * x)
    vers_x = 2.0 / (1.0 + t * t)
    sin_x = vers_x * t
    vers_x = sin_x * t
    cos_x = 1.0 - vers_x
    cos_minus = onset.sin * sin_x - onset.cos * vers_x  # cos u - cos c
    cos_u = onset.cos + cos_minus
    sin_u = onset.cos * sin_x - onset.sin * cos_x
    f = x * (cos_minus + onset.excess - cos_u * gap)
    slope = 2.0 * sin_x * sin_u - onset.excess  # -f'
    bend = sin_x * cos_u + cos_x * sin_u  # -f''/2
    return _Evaluation(f * slope / (f * bend + (slope * slope + _TINY)), sin_x, cos_x, sin_u, cos_u)


class Slide(NamedTuple):
    """End of a slide.

    Attributes
    ----------
    x : array
        Half of the slide's length in phase [rad]: it ends at p0 + 2 x; inf where it never ends.
    reach : array
        Displacement over the slide's load amplitude, >= 0 [A]: D = C * reach; NaN where it never ends.
    peak : array
        Largest speed over the slide's load amplitude, Eq. (14) [A w], as a sum of terms that all vanish
        like the cube of the slide's length.
    settled : bool array
        Whether the last refinement step was as small as it must be.
    """

    x: Floats
    reach: Floats
    peak: Floats
    settled: NDArray[np.bool_]


def slide(onset: Onset) -> Slide:
    """Solve slides from rest, 1-D arrays, for ``k <= sin p0``, ``0 < sin p0 <= 1``.

    Notes
    -----
    For k >= 0, two steps of Halley's iteration on Eq. (12): from within 1.2 % the first leaves at most
    4.5e-6, the second rounding errors. The second is applied to the displacement, Eq. (11), by its Taylor
    series, whose first neglected term is as small; so the trigonometric functions are needed only twice.
    For k < 0 (the trough steeper than the friction angle) see ``_slide_downhill``.
    """
    downhill = onset.k < 0.0
    if not np.count_nonzero(downhill):
        return _slide_uphill(onset)
    x, reach, peak = np.empty((3, onset.c.size))
    whole = Slide(x, reach, peak, np.empty(onset.c.shape, np.bool_))
    for part, solver in ((~downhill, _slide_uphill), (downhill, _slide_downhill)):
        cells = part.nonzero()[0]
        put(whole, cells, solver(take(onset, cells)))
    return whole


def _slide_uphill(onset: Onset) -> Slide:
    kappa, theta = _theta(onset)
    x = _start(onset, theta)
    y = x * x
    x += _evaluate(x, y * polynomial(y, _ROUGH_Q), onset).step
    y = x * x
    squares = np.array((y, y, theta * theta, onset.c * onset.c))
    gap, bulge, bulge_top, gap_start = squares * polynomial(squares, _ROWS)
    step, sin_x, cos_x, sin_u, cos_u = _evaluate(x, gap, onset)
    bulge *= x  # sin x - x cos x
    slope = x * sin_x  # its derivative
    first = cos_u * bulge + sin_u * slope
    second = sin_u * (sin_x + x * cos_x - bulge) + 2.0 * cos_u * slope
    reach = 2.0 * (sin_u * bulge + step * (first + 0.5 * step * second))
    peak = theta * bulge_top + onset.c * (kappa - gap_start)
    return Slide(x + step, reach, peak, np.abs(step) <= _SETTLED * x + _PHASE_NOISE)


def _slide_downhill(onset: Onset) -> Slide:
    """Slides with k < 0: gravity along the trough exceeds kinetic friction.

    The speed, over C, cos p0 - cos p + |k| (p - p0) grows up to p = pi + asin|k|, falls up to
    2 pi - asin|k| and grows from cycle to cycle. The slide ends between 2 pi - p0 (or the speed's maximum)
    and that minimum, Eq. (16), or never. Bisection: rare cells, no start to prove.
    """
    c, k = onset.c, -onset.k
    least = 1.5 * np.pi + np.arccos(np.minimum(k, 1.0))  # 2 pi - asin|k|

    def speed(p: Floats) -> Floats:
        return onset.sin - np.cos(p) + k * (p - (0.5 * np.pi - c))

    low = np.maximum(1.5 * np.pi + c, 3.0 * np.pi - least)
    high = least
    # cos p0 - sqrt(1 - k^2) may be far below the rounding of either
    cosines = np.abs(onset.sin) + np.sqrt(np.maximum((1.0 - k) * (1.0 + k), 0.0)) + _PHASE_NOISE
    gain = k * (least - (0.5 * np.pi - c)) - onset.excess * (onset.excess - 2.0 * k) / cosines
    ends = np.where(onset.sin > 0.0, gain, speed(high)) <= 0.0
    end = bisect(speed, low, high)
    x = 0.5 * (end - (0.5 * np.pi - c))
    reach = 2.0 * np.sin(x - c) * (x * x * x * polynomial(x * x, R))
    kappa, theta = _theta(onset)
    peak = theta**3 * polynomial(theta * theta, R) + c * (kappa - c * c * polynomial(c * c, Q))
    return Slide(np.where(ends, x, np.inf), np.where(ends, reach, np.nan), peak, np.ones(c.shape, np.bool_))
