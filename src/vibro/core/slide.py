"""One slide from rest: where it ends, how far it goes, how fast it gets.

Equation numbers are those of docs/theory. Lengths in A, speeds in A w, phases in radians. A forward slide
and a back slide are the same problem in the slide's own phase; the caller turns the sign.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.elementary import INF, NAN, PI, QUARTER, series_q, series_r
from vibro.core.roots import bisected

__all__ = ["Onset", "Slide", "slide", "start_inside"]

# [1] The step of a slide of no length would be 0 / 0: added to its denominator.
_TINY: Final = 1e-300
# [rad] Where k -> 0 and p0 -> 0 the estimate divides 0 by 0; this, the rounding of p0 = pi/2 - c, is added.
_PHASE_NOISE: Final = 1e-15
# [1] A second step above this fraction of x would leave more than rounding errors.
_SETTLED: Final = 1e-4


class Onset(NamedTuple):
    """Start of a slide at its own phase p0, in the form that does not cancel near the crest of the load.

    Attributes
    ----------
    c : float
        pi/2 - p0 [rad]: positive before the load's crest, negative after it.
    cos, sin, vers : float
        cos c = sin p0, sin c = cos p0, and 1 - cos c computed without cancellation.
    excess : float
        sin p0 - k >= 0, computed without cancellation.
    k : float
        Resistance over load amplitude while sliding.
    load : float
        Load amplitude while sliding, C of Eq. (55).
    """

    c: float
    cos: float
    sin: float
    vers: float
    excess: float
    k: float
    load: float


class Slide(NamedTuple):
    """End of a slide.

    Attributes
    ----------
    half_length : float
        x: the slide ends at p0 + 2 x [rad]; inf where it never ends.
    displacement : float
        Path, >= 0 [A]; NaN where it never ends.
    peak : float
        Largest speed, Eq. (14) [A w], as a sum of terms that all vanish like the cube of the length.
    settled : bool
        Whether the last refinement step was as small as it must be.
    """

    half_length: float
    displacement: float
    peak: float
    settled: bool


class _Evaluation(NamedTuple):
    """Halley's step of Eq. (12) at x, with what the displacement needs; u = x - c."""

    step: float
    sin_x: float
    cos_x: float
    sin_u: float
    cos_u: float


def start_inside(c: float, k: float, load: float) -> Onset:
    """Start of a slide that follows another one directly, anywhere inside its load window; NaN for inf."""
    if not abs(c) < INF:
        c = NAN
    half = math.sin(0.5 * c)
    vers = 2.0 * half * half
    cosine = 1.0 - vers
    return Onset(c, cosine, math.sin(c), vers, cosine - k, k, load)


def slide(onset: Onset) -> Slide:
    """Solve a slide from rest, for ``k <= sin p0 <= 1``.

    Notes
    -----
    For k >= 0, two steps of Halley's iteration on Eq. (12): from within 1.2 % the first leaves at most
    4.5e-6, the second rounding errors (tests/core/test_slide.py). The second is applied to the displacement,
    Eq. (11), by its Taylor series, whose first neglected term is as small.
    """
    c, k = onset.c, onset.k
    kappa = onset.vers + onset.excess  # 1 - k, without cancellation for k -> 1
    theta = 2.0 * math.asin(math.sqrt(min(max(0.5 * kappa, 0.0), 1.0)))  # acos k; pi for k < -1
    square, c_square = theta * theta, c * c
    peak = onset.load * (theta * (square * series_r(square)) + c * (kappa - c_square * series_q(c_square)))
    if k < 0.0:
        return _slide_downhill(onset, peak)
    x = _first_estimate(c, k, theta)
    y = x * x
    # series_q to 1e-7 (1 - x^2 / pi^2): exact where sin x vanishes
    rough = (
        ((2.07021594934088201e-8 * y - 2.710588200256295715e-6) * y + 0.0001982099143356336995) * y
        - 0.008332991690635963418
    ) * y + 0.1666665646386242498
    x += _halley(x, y * rough, onset).step
    y = x * x
    at = _halley(x, y * series_q(y), onset)
    bulge = y * series_r(y) * x  # sin x - x cos x
    slope = x * at.sin_x  # its derivative
    first = at.cos_u * bulge + at.sin_u * slope
    second = at.sin_u * (at.sin_x + x * at.cos_x - bulge) + 2.0 * at.cos_u * slope
    reach = 2.0 * (at.sin_u * bulge + at.step * (first + 0.5 * at.step * second))
    return Slide(x + at.step, onset.load * reach, peak, abs(at.step) <= _SETTLED * x + _PHASE_NOISE)


def _first_estimate(c: float, k: float, theta: float) -> float:
    """Estimate half the slide's length, Eq. (13).

    Exact for k -> 0, of the right order for theta -> 0 and with the right branch point in the corner
    k -> 0, p0 -> 0; everywhere within 1.2 % of the distance to the nearest other root.
    """
    p0 = QUARTER - c
    resistance = 2.0 * k
    root = math.sqrt(p0 * p0 + max(resistance * (PI + 2.0 * c), 0.0))
    corner = resistance / (p0 + root + _PHASE_NOISE)
    rho = c / (theta + _TINY)
    bend = (-0.07074 * rho + 0.001219) * (theta * theta) + (0.11467 * rho - 0.314847)
    return (theta + c) * (1.0 - corner - k * bend)


def _halley(x: float, gap: float, onset: Onset) -> _Evaluation:
    """Halley's step at x, written in terms that all vanish like x^2; ``gap`` is 1 - sin(x)/x."""
    half = 0.5 * x
    half_sine = math.sin(half)
    sin_x = 2.0 * half_sine * math.cos(half)
    vers_x = 2.0 * half_sine * half_sine
    cos_x = 1.0 - vers_x
    cos_minus = onset.sin * sin_x - onset.cos * vers_x  # cos u - cos c
    cos_u = onset.cos + cos_minus
    sin_u = onset.cos * sin_x - onset.sin * cos_x
    f = x * (cos_minus + onset.excess - cos_u * gap)
    slope = 2.0 * sin_x * sin_u - onset.excess  # -f'
    bend = sin_x * cos_u + cos_x * sin_u  # -f''/2
    return _Evaluation(f * slope / (f * bend + (slope * slope + _TINY)), sin_x, cos_x, sin_u, cos_u)


def _speed_downhill(onset: Onset, phase: float) -> float:
    """Return the speed, over C, at a phase of the slide's own."""
    return onset.sin - math.cos(phase) - onset.k * (phase - (QUARTER - onset.c))


def _slide_downhill(onset: Onset, peak: float) -> Slide:
    """Solve a slide with k < 0: gravity along the trough exceeds kinetic friction.

    The speed, over C, cos p0 - cos p + |k| (p - p0) grows up to p = pi + asin|k|, falls up to
    2 pi - asin|k| and grows from cycle to cycle. The slide ends between 2 pi - p0 (or the speed's maximum)
    and that minimum, Eq. (16), or never. Bisection: a rare case without a proven start.
    """
    c, k = onset.c, -onset.k
    p0 = QUARTER - c
    least = 3.0 * QUARTER + math.acos(min(k, 1.0))  # 2 pi - asin|k|
    low, high = max(3.0 * QUARTER + c, 6.0 * QUARTER - least), least
    # cos p0 - sqrt(1 - k^2) may be far below the rounding of either
    if onset.sin > 0.0:
        cosines = onset.sin + math.sqrt(max((1.0 - k) * (1.0 + k), 0.0)) + _PHASE_NOISE
        ends = k * (least - p0) - onset.excess * (onset.excess - 2.0 * k) / cosines <= 0.0
    else:
        ends = _speed_downhill(onset, high) <= 0.0
    if not ends:
        return Slide(INF, NAN, peak, True)
    x = 0.5 * (bisected(_speed_downhill, onset, low, high, True) - p0)
    reach = 2.0 * math.sin(x - c) * (x * x * x * series_r(x * x))
    return Slide(x, onset.load * reach, peak, True)
