"""Constants, series and the motion between two events: what all rooms of the solver share.

Equation numbers are those of docs/theory. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

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
    (tests/core/test_numbers.py), since the difference cancels for small x.
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


class _Circle(NamedTuple):
    """Sine and cosine of a phase."""

    sine: float
    cosine: float


def circle(phase: float) -> _Circle:
    """Return sine and cosine, both within 1.5 ulp: in half the time of the library's where that is compiled.

    Of the rest to the nearest quarter turn, with the polynomials of fdlibm (k_sin.c and k_cos.c, Sun
    Microsystems 1993); a phase of many turns is left to the library.
    """
    if not abs(phase) < _MOST_REDUCED:
        return _Circle(math.sin(phase), math.cos(phase))
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
    return _Circle(up if quarter < 2 else -up, right if quarter == 0 or quarter == 3 else -right)


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


# ------------------------------------------------------------------------------
# Zeros of functions of one variable: by halving, by false position, and by Newton's iteration.
#
# Each function takes ``of``, a record that says what it is of. Which method a zero needs, and that its
# bracket holds one, is proved where it is called.

_HALVINGS: Final = 60  # from an interval of some turns, or of its end's size, down to an ulp
_FALSE_POSITIONS: Final = 200
_ROOT_NOISE: Final = 4.0 * 2.220446049250313e-16  # [1] of a bracket's width
_NEWTON_STEPS: Final = 60  # monotone, quadratic but next to double zeros; few zeros need more than 8

Of = TypeVar("Of")


class Value(NamedTuple):
    """Value of a function, and its slope there."""

    value: float
    slope: float


class _Root(NamedTuple):
    """Where Newton's iteration ends, and whether that is a zero."""

    at: float
    found: bool


def bisected(
    function: Callable[[Of, float], float], of: Of, low: float, high: float, positive: bool
) -> float:
    """Halve an interval at whose end a function has another sign; ``positive``: where it starts, it is."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if (function(of, middle) > 0.0) == positive:
            low = middle
        else:
            high = middle
    return high


def illinois(
    function: Callable[[Of, float], float], of: Of, low: float, high: float, below: float, above: float
) -> float:
    """Solve for a zero between a value ``below`` 0 and one ``above``, at the end.

    By false position that halves the weight of an end which stays.
    """
    x = high
    for _ in range(_FALSE_POSITIONS):
        if above - below <= 0.0 or high - low <= _ROOT_NOISE * high:
            break
        x = high - above * ((high - low) / (above - below))
        if not low < x < high:
            x = 0.5 * (low + high)
        value = function(of, x)
        if value == 0.0:
            break
        if value > 0.0:
            high, above, below = x, value, 0.5 * below
        else:
            low, below, above = x, value, 0.5 * above
    return x


def newton(
    function: Callable[[Of, float], Value], of: Of, start: float, end: float, share: float, least: float
) -> _Root:
    """Fall from a start to a zero, where the curvature makes steps converge from one side.

    There is none where the function ceases to fall, or not before ``end``. A last step below ``least``, or a
    ``share`` of the zero, leaves rounding errors alone.
    """
    x = start
    for _ in range(_NEWTON_STEPS):
        now = function(of, x)
        if now.slope >= 0.0:
            return _Root(x, False)
        step = -now.value / now.slope
        x += step
        if x > end:
            return _Root(x, False)
        if abs(step) <= share * x + least:
            break
    return _Root(x, True)


# ------------------------------------------------------------------------------
# What is handed to the solver: flat buffers of one type of number, their sizes, kinds of drives, and limits.
#
# The rooms above import these from here, since they need no other source of a solver that is compiled.

Doubles: TypeAlias = "memoryview[float]"
Integers: TypeAlias = "memoryview[int]"
Bytes: TypeAlias = "memoryview[int]"

#: [kind] Drives of one harmonic, along a line or an ellipse; of several; of pieces of cubic polynomials.
LINE: Final = 0
ELLIPSE: Final = 1
HARMONICS: Final = 2
PIECES: Final = 3
#: Fields that every scene has; each harmonic brings four more.
FIELDS: Final = 9
#: [1] Parts of the memory, each of which has room for the coefficients of one wave, before the tables.
ROOM: Final = 4 + 6 + 2 + 16
#: [row] Mixes of loads of which zeros are kept.
MIXES: Final = 6
#: [row] Intervals are kept of forward slip, of back slip, and of cycles without a rest.
CLASSES: Final = 3
#: Bodies of each scene whose samples are averaged.
BODIES: Final = 12
#: Most hops of such a body, short bounces included: rows that it needs.
MOST_HOPS: Final = 10_000
#: Flights of one scene, short bounces included; restitutions above 0.995 may need more.
MOST_BOUNCES: Final = 8192
#: Flights in a cycle that never rests on the trough.
LONGEST_CYCLE: Final = 64
#: Starts of a scene that are followed where nothing else is asked for.
STARTS: Final = 64
#: Rows for cycles in contact that no start leads to.
KNOWN: Final = 64
#: [1] Throw number above which the phase of a landing is lost to rounding.
MOST_THROW: Final = 1e6
#: [1] Of so many cycles doubles hold the phase.
MOST_CYCLES: Final = 1e15
#: [1] Of loads and frictions, and one over the least: motions form products of up to four of them, and
#: differences of those.
EXTREME: Final = 1e50


def doubles(count: int) -> memoryview[float]:
    """Make an array of zeros; compiled it has a constant length, and ends with the function that makes it."""
    return memoryview(bytearray(8 * count)).cast("d")


def integers(count: int) -> memoryview[int]:
    """Make an array of zeros, as ``doubles``."""
    return memoryview(bytearray(8 * count)).cast("q")


class Span(NamedTuple):
    """What of a history's legs repeats.

    Attributes
    ----------
    first, number : int
        The first leg of the cycle that repeats, and the number of all legs; the same if none repeat.
    period : int
        Drive cycles of that cycle; 0 without one.
    advance : float
        Displacement in it [A].
    frequency : float
        Of the drive [Hz].
    """

    first: int
    number: int
    period: int
    advance: float
    frequency: float


class Sampled(NamedTuple):
    """Motion and forces of a history at times, as ``vibro.Sample`` describes them, one element each."""

    trough_displacement: Doubles
    trough_along: Doubles
    trough_normal: Doubles
    position: Doubles
    velocity: Doubles
    acceleration: Doubles
    inertial: Doubles
    friction: Doubles
    normal: Doubles
    static_limit: Doubles
    gap: Doubles


class Springs(NamedTuple):
    """A machine that drives a trough: fields of ``vibro.Machine``, and the amplitudes that are allowed.

    Attributes
    ----------
    trough_mass, counter_mass : float
        m1 and m2; m1 is infinite of a crank [kg].
    damping_ratio : float
        Of the empty machine [1].
    base_stiffness : float
        Of the mount of the counter mass on the floor [N/m].
    gap : float
        Relative amplitude at which the masses strike each other [m].
    pushes_counter_mass : bool
        Whether the force acts on the counter mass alone, as that of an exciter.
    narrowest, widest : float
        Least and largest amplitude of the empty trough that is allowed [m].
    """

    trough_mass: float
    counter_mass: float
    damping_ratio: float
    base_stiffness: float
    gap: float
    pushes_counter_mass: bool
    narrowest: float
    widest: float


class Fillings(NamedTuple):
    """What differs from cell to cell of a machine, besides its scenes: one element each.

    Attributes
    ----------
    force, natural_frequency : Doubles
        Amplitude of the force [N], of a crank [m], and natural frequency of the empty machine [Hz].
    filling : Doubles
        Mass of the filling [kg].
    added_mass_share, added_damping_share : Doubles
        Shares of it that are known; NaN where they are to be found [1].
    """

    force: Doubles
    natural_frequency: Doubles
    filling: Doubles
    added_mass_share: Doubles
    added_damping_share: Doubles


class Operated(NamedTuple):
    """Operating points of cells, as ``vibro.OperatingPoints`` describes them.

    ``solved_at`` is the amplitude of the scenes there, also where there is no operating point [m].
    """

    amplitude: Doubles
    amplitude_empty: Doubles
    amplitude_low: Doubles
    amplitude_high: Doubles
    solved_at: Doubles
    phase: Doubles
    relative_amplitude: Doubles
    filled_frequency_ratio: Doubles
    added_mass_share: Doubles
    added_damping_share: Doubles
    second_real: Doubles
    second_imaginary: Doubles
    amplitude_sine: Doubles
    number: Integers
    at_jump: Bytes
    strikes: Bytes
    uncertain: Bytes
    status: Bytes
