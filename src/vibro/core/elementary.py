"""Constants, series and the motion between two events: what all rooms of the solver share.

Equation numbers are those of docs/theory. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

__all__ = [
    "EPS", "FEW_ULP", "INF", "NAN", "NOISE", "PI", "QUARTER", "TURN", "Circle", "PathPoint", "braked",
    "circle",
    "free_motion", "hypotenuse", "positive_part", "rounded_sign", "series_q", "series_r", "sine_gap",
    "until", "wrap", "wrap_around",
]  # fmt: skip

PI: Final = math.pi
TURN: Final = 2.0 * math.pi  # [rad] one drive cycle
QUARTER: Final = 0.5 * math.pi  # [rad]
INF: Final = math.inf
NAN: Final = math.nan
EPS: Final = 2.220446049250313e-16  # [1] 2^-52
# [1] Relative distance to a threshold below which rounding of the inputs decides the side: f^2, g and the
# angles bring about four roundings into G.
FEW_ULP: Final = 4.0 * 2.220446049250313e-16
# [1] Relative rounding error of a slide's speed, and of a load, where the next leg is decided.
NOISE: Final = 16.0 * 2.220446049250313e-16
_QUARTERS_PER_RADIAN: Final = 0.6366197723675814  # 2 / pi
# [rad] Quarter of a turn, in two parts: the first has 33 bits, so that multiples of it are exact.
_QUARTER_HIGH: Final = 1.57079632673412561417
_QUARTER_LOW: Final = 6.07710050650619224932e-11
_MOST_REDUCED: Final = 1e5  # [rad]
#: [rad] The phases of an event and of a body are rounded, so that a body at the event may seem to have just
# missed it, and would wait for a whole turn. This close after an event it counts as being at the event.
AT_EVENT: Final = 1e-9
# [1] Between these a sum of two squares has all of its digits.
_LEAST_SQUARE: Final = 1e-280
_MOST_SQUARE: Final = 1e300


def wrap(phase: float) -> float:
    """Reduce a phase to [0, 2 pi)."""
    # most phases are: a branch costs less than the division
    return phase if 0.0 <= phase < TURN else phase - TURN * math.floor(phase / TURN)


def until(event: float, phase: float) -> float:
    """Return the phase from ``phase`` to the next passage of an event, 0 for a body at the event [rad]."""
    return max(wrap(event - phase + AT_EVENT) - AT_EVENT, 0.0)


def wrap_around(phase: float) -> float:
    """Reduce a phase to [-pi, pi)."""
    return wrap(phase + PI) - PI


def positive_part(value: float) -> float:
    """Return the value where it is positive, else 0; 0 for NaN."""
    return value if value > 0.0 else 0.0


def braked(velocity: float, loss: float) -> float:
    """Take a loss of speed from a velocity: 0, with its sign, where no more than rounding is left."""
    left = abs(velocity) - loss
    return math.copysign(left if left > NOISE * loss else 0.0, velocity)


def hypotenuse(x: float, y: float) -> float:
    """Compute the length of a vector, also where squares of its components overflow or vanish."""
    square = x * x + y * y
    if _LEAST_SQUARE < square < _MOST_SQUARE:
        return math.sqrt(square)
    scale = max(abs(x), abs(y))
    if not 0.0 < scale < INF:
        return scale
    u, v = x / scale, y / scale
    return scale * math.sqrt(u * u + v * v)


def rounded_sign(value: float, scale: float) -> int:
    """Return the sign of a number that rounding has changed by up to 16 eps of a scale, 0 if that decides."""
    noise = NOISE * scale
    if value > noise:
        return 1
    return 0 if abs(value) <= noise else -1


def series_q(y: float) -> float:
    """Compute (1 - sin(x)/x) / x^2 for y = x^2, 0 <= x <= pi.

    A Chebyshev economisation computed with 60 digits, error below 6e-18 of the value
    (tests/core/test_elementary.py), since the difference cancels for small x.
    """
    return (
        (((((((
            (-1.77516651900580094e-20 * y + 8.18304374281322528e-18) * y - 2.81102438733084008e-15) * y
            + 7.64713352785736226e-13) * y - 1.60590425313094057e-10) * y + 2.50521083511001472e-8) * y
            - 2.75573192234679305e-6) * y + 0.00019841269841265893) * y - 0.00833333333333332184) * y
        + 0.166666666666666666
    )  # fmt: skip


def series_r(y: float) -> float:
    """Compute (sin x - x cos x) / x^3 for y = x^2, 0 <= x <= pi; else as ``series_q``."""
    return (
        ((((((((
            (7.7088580917279416e-22 * y - 3.89610970345939686e-19) * y + 1.47947161254262735e-16) * y
            - 4.49831175269064113e-14) * y + 1.07060281802820307e-11) * y - 1.92708525689134348e-9) * y
            + 2.5052108384699699e-7) * y - 0.0000220458553791796289) * y + 0.00119047619047618481) * y
            - 0.033333333333333332) * y
        + 0.333333333333333333
    )  # fmt: skip


def sine_gap(x: float) -> float:
    """Compute x - sin x, 0 <= x <= pi, to rounding."""
    y = x * x
    return x * y * series_q(y)


class Circle(NamedTuple):
    """Sine and cosine of a phase."""

    sine: float
    cosine: float


def circle(phase: float) -> Circle:
    """Return sine and cosine, both within 1.5 ulp: in half the time of the library's where that is compiled.

    Of the rest to the nearest quarter turn, with the polynomials of fdlibm (k_sin.c and k_cos.c, Sun
    Microsystems 1993); a phase of many turns is left to the library.
    """
    if not abs(phase) < _MOST_REDUCED:
        return Circle(math.sin(phase), math.cos(phase))
    quarters = int(phase * _QUARTERS_PER_RADIAN + math.copysign(0.5, phase))
    x = (phase - quarters * _QUARTER_HIGH) - quarters * _QUARTER_LOW
    y = x * x
    z = y * y
    # in pairs, which do not wait for each other
    low, middle = -1.66666666666666324348e-01 + 8.33333333332248946124e-03 * y, 2.75573137070700676789e-06 * y
    middle -= 1.98412698298579493134e-04
    high = 1.58969099521155010221e-10 * y - 2.50507602534068634195e-08
    sine = x + x * y * (low + z * (middle + z * high))
    low, middle = 4.16666666666666019037e-02 - 1.38888888888741095749e-03 * y, 2.75573143513906633035e-07 * y
    middle = 2.48015872894767294178e-05 - middle
    high = 2.08757232129817482790e-09 - 1.13596475577881948265e-11 * y
    gap = z * (low + z * (middle + z * high))
    half = 0.5 * y
    near = 1.0 - half
    cosine = near + ((1.0 - near - half) + gap)
    quarter = quarters & 3
    up = sine if quarter % 2 == 0 else cosine
    right = cosine if quarter % 2 == 0 else sine
    return Circle(up if quarter < 2 else -up, right if quarter == 0 or quarter == 3 else -right)


class PathPoint(NamedTuple):
    """Path since a start, and the velocity there."""

    path: float
    velocity: float


def free_motion(
    amplitude: float, drag: float, sine: float, cosine: float, velocity: float, s: float
) -> PathPoint:
    """Move under x'' = amplitude sin p - drag for a phase s >= 0, Eq. (40).

    Slides, flights along the trough and flights off it differ in amplitude and drag alone; ``sine`` and
    ``cosine`` are those of the phase at the start. Exact to rounding of its terms, however short s is:
    s - sin s has a series of its own up to s = 1 (error below 6e-18 of the value).
    """
    half = 0.5 * s
    half_sine = math.sin(half)
    rise = 2.0 * half_sine * math.cos(half)  # sin s
    versine = 2.0 * half_sine * half_sine
    gap = s - rise
    if s < 1.0:
        y = s * s
        gap = (
            (((((
                7.54937170418124304e-13 * y - 1.60577019225797864e-10) * y + 2.50520992449141141e-08) * y
                - 2.75573191920112204e-06) * y + 0.000198412698412165663) * y - 0.00833333333333330026) * y
            + 0.166666666666666657
        ) * y * s  # fmt: skip
    fall = drag * s
    path = s * (velocity - 0.5 * fall) + amplitude * (sine * versine + cosine * gap)
    return PathPoint(path, velocity + amplitude * (cosine * versine + sine * rise) - fall)
