"""One slide from rest: where it ends, how far it goes, how fast it gets.

Equation numbers are those of docs/theory. Lengths in A, speeds in A w, phases in radians. A forward slide
and a back slide are the same problem in the slide's own phase; the caller turns the sign.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.cells import find_nodes, largest, number_of_nodes
from vibro.core.drive import Loads, mix_of
from vibro.core.numbers import (
    FEW_ULP,
    INF,
    NAN,
    NOISE,
    PI,
    PIECES,
    QUARTER,
    bisected,
    hypotenuse,
    rounded_sign,
    series_q,
    series_r,
)
from vibro.core.waves import NORMAL, SINE, STATIC_BACK, STATIC_FORWARD, Mix, stays_zero

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
    4.5e-6, the second rounding errors (tests/core/test_slides.py). The second is applied to the displacement,
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


# ------------------------------------------------------------------------------
# Where the load of a body at rest exceeds static friction, and what a slide that starts there meets.
#
# Each direction has one static window a cycle, Eqs. (5) and (55)-(58) of docs/theory. A slide in the
# direction s = +1 (forward) or -1 (back) with the coefficient mu is pulled by C sin(p + psi), C e^{i psi} = s
# a e^{-i phi} + mu b: p + psi is the slide's own phase. Loads are over m A w^2, phases in radians.

# [1] The least double keeps quotients of a drive without load from being 0 / 0.
_LEAST: Final = 5e-324
_NEARLY_LIFTED: Final = 0.25  # [n] normal load below which it is formed without a difference


class Thresholds(NamedTuple):
    """Where a scene stands beside the closed-form thresholds.

    Attributes
    ----------
    forward_margin, back_margin : float
        (1 - s_f) C_f and (1 - s_b) C_b, sharing their rounding: > 0 where the load exceeds static friction
        that way, Eqs. (5) and (55).
    forward_load, back_load : float
        C_f and C_b with static friction, >= 0.
    forward, back : bool
        Whether slip begins that way, by more than rounding.
    hops : bool
        Whether the throw number exceeds 1, by more than rounding.
    unheld : bool
        Whether the trough is steeper than static friction can hold a body on, by more than rounding.
    edge : bool
        Whether rounding decides one of the above.
    """

    forward_margin: float
    back_margin: float
    forward_load: float
    back_load: float
    forward: bool
    back: bool
    hops: bool
    unheld: bool
    edge: bool


def thresholds(loads: Loads) -> Thresholds:
    """Compare each load with its threshold; equality is rest, and contact."""
    if loads.waves.kind != SINE:
        return _over_waves(loads)
    a, n, t = loads.drive_tangential, loads.weight_normal, loads.weight_tangential
    capacity, lift = loads.static_friction * n, loads.static_friction * loads.drive_normal
    # C - a, without cancellation where b is small
    if loads.line:
        ahead, behind = lift, (-lift if lift <= a else lift - 2.0 * a)
    else:
        level, steep = a * loads.phase_cosine, a * loads.phase_sine
        ahead = lift * ((lift + 2.0 * level) / (hypotenuse(lift + level, steep) + (a + _LEAST)))
        behind = lift * ((lift - 2.0 * level) / (hypotenuse(lift - level, steep) + (a + _LEAST)))
    slack = a - capacity
    forward_margin, back_margin = slack + (ahead - t), slack + (behind + t)
    forward_load, back_load = a + ahead, a + behind
    return _compared(loads, forward_margin, back_margin, forward_load, back_load)


def _over_waves(loads: Loads) -> Thresholds:
    """Take the largest loads of a drive beyond one harmonic; next to K = 1 it hops if N falls below 0."""
    friction = loads.static_friction
    ahead = largest(loads.waves, Mix(0.0, 1.0, friction))
    behind = largest(loads.waves, Mix(0.0, -1.0, friction))
    at = thresholds_of(loads, ahead, behind)
    if is_held_at_limit(loads):
        at = at._replace(edge=True)
    if at.hops:
        find_nodes(loads.waves, NORMAL, mix_of(loads, NORMAL))
        if number_of_nodes(loads.waves, NORMAL) == 0:
            return at._replace(hops=False, edge=True)
    return at


def is_held_at_limit(loads: Loads) -> bool:
    """Return whether a piece keeps the load at static friction, above kinetic: rounding lets a body slip."""
    if loads.waves.kind != PIECES or loads.kinetic_friction == loads.static_friction:
        return False
    forward, back, lift = mix_of(loads, STATIC_FORWARD), mix_of(loads, STATIC_BACK), mix_of(loads, NORMAL)
    return stays_zero(loads.waves, forward, lift) or stays_zero(loads.waves, back, lift)


def thresholds_of(loads: Loads, ahead: float, behind: float) -> Thresholds:
    """Compare the largest loads, forward and back, of a drive beyond one harmonic with their thresholds."""
    n, t, friction = loads.weight_normal, loads.weight_tangential, loads.static_friction
    return _compared(loads, ahead - (friction * n + t), behind - (friction * n - t), ahead, behind)


def _compared(
    loads: Loads, forward_margin: float, back_margin: float, forward_load: float, back_load: float
) -> Thresholds:
    """Tell where a scene stands, and whether rounding decides it."""
    n, t = loads.weight_normal, loads.weight_tangential
    capacity = loads.static_friction * n
    noise = FEW_ULP * (forward_load + capacity + abs(t))
    throw, throw_noise = loads.drive_normal - n, FEW_ULP * n
    over, held_noise = abs(t) - capacity, FEW_ULP * capacity
    edge = abs(forward_margin) <= noise or abs(throw) <= throw_noise
    edge = edge or (back_load > 0.0 and abs(back_margin) <= noise) or (t != 0.0 and abs(over) <= held_noise)
    return Thresholds(
        forward_margin,
        back_margin,
        forward_load,
        back_load,
        forward=forward_margin > noise,
        back=back_load > 0.0 and back_margin > noise,
        hops=throw > throw_noise,
        unheld=over > held_noise,
        edge=edge,
    )


def load_amplitude(loads: Loads, way: float, friction: float) -> float:
    """C of Eq. (55), >= 0."""
    lift = friction * loads.drive_normal
    if loads.line:
        return abs(loads.drive_tangential + way * lift)
    level, steep = _complex_load(loads, way, lift)
    return hypotenuse(level, steep)


def own_phase(loads: Loads, way: float, friction: float) -> float:
    """Psi of Eq. (55), in [-pi, pi]: added to a phase it gives the slide's own."""
    lift = friction * loads.drive_normal
    if loads.line:
        return PI if way * loads.drive_tangential + lift < 0.0 else 0.0
    level, steep = _complex_load(loads, way, lift)
    return math.atan2(-steep, level)


def _complex_load(loads: Loads, way: float, lift: float) -> tuple[float, float]:
    """Real and negative imaginary part of C e^{i psi}."""
    along = way * loads.drive_tangential
    return along * loads.phase_cosine + lift, along * loads.phase_sine


def phase_offset(loads: Loads, friction: float) -> float:
    """E of Eq. (57): the angle beyond half a turn between the phases of the forward and the back load.

    With static friction it tells how much more than half a turn after the forward window the back window
    lies; with kinetic friction the same of the zeros of both slides' own phases.
    """
    if loads.line:
        return 0.0
    a, lift = loads.drive_tangential, friction * loads.drive_normal
    scale = a + lift
    if scale == 0.0:
        return 0.0
    return math.atan2(2.0 * (a / scale) * (lift / scale) * loads.phase_sine, (a - lift) / scale)


class Start(NamedTuple):
    """A slide from rest, and the static window that it starts from.

    Attributes
    ----------
    onset : Onset
        Where it starts, in its own phase.
    window : float
        Half-length of the window [rad].
    open_rate, close_rate : float
        How fast the load of the opposite slide changes where the window opens, and where it closes.
    """

    onset: Onset
    window: float
    open_rate: float
    close_rate: float


def no_start() -> Start:
    """Stand for the slide of a body that never slips in a direction."""
    return Start(Onset(NAN, NAN, NAN, NAN, NAN, NAN, NAN), NAN, NAN, NAN)


def resting_start(loads: Loads, at: Thresholds, way: float) -> Start:
    """Slide from rest, forward (+1) or back (-1), Eqs. (3)-(6) and (56), without cancellation.

    ``at`` says that slip begins that way.
    """
    margin, static_load = at.forward_margin, at.forward_load
    if way < 0.0:
        margin, static_load = at.back_margin, at.back_load
    mu_s, mu_d, b = loads.static_friction, loads.kinetic_friction, loads.drive_normal
    less, both = mu_s - mu_d, (mu_s + mu_d) * b
    drag = mu_d * loads.weight_normal + way * loads.weight_tangential
    if loads.line:
        load, vers = loads.drive_tangential + way * mu_d * b, margin / static_load
        k, excess = drag / load, less * loads.weight_across / (static_load * load)
        c, sine = 2.0 * math.asin(math.sqrt(0.5 * vers)), math.sqrt(vers * (2.0 - vers))
        window, close_rate = c, (static_load - way * both) * sine
        open_rate = -close_rate
    else:
        loss, capacity = less * b, mu_s * loads.weight_normal + way * loads.weight_tangential
        level, steep = _complex_load(loads, way, mu_s * b)
        kinetic = level - loss
        load = hypotenuse(kinetic, steep) + _LEAST
        # half of the window about the crest of the static load, and that load's direction
        ratio = margin / static_load
        c_sine, c_cosine = math.sqrt(ratio * (2.0 - ratio)), capacity / static_load
        level, steep = level / static_load, steep / static_load
        rate = c_sine * static_load  # of the load at the window's edges
        # sine of the normal motion's phase at the window's start, its cosine there and, turned, at its end
        crest, near, far = c_cosine * level + c_sine * steep, c_sine * level, c_cosine * steep
        opens = near - far
        normal = loads.weight_normal - b * crest
        if normal < _NEARLY_LIFTED * loads.weight_normal:  # a sum of what is not negative
            normal = (loads.weight_normal - b) + b * opens * opens / (1.0 + crest)
        k, excess, sine = drag / load, less * normal / load, (rate - loss * opens) / load
        half = sine / max(1.0 + (excess + k), _LEAST)
        c, vers = 2.0 * math.atan(half), sine * half
        window = 2.0 * math.atan(c_sine / (1.0 + c_cosine))
        open_rate, close_rate = both * opens - rate, rate - both * (near + far)
    if loads.weight_tangential != 0.0:
        # Where the weight down the trough nearly cancels friction, rounding may bring k above sin p0, and no
        # slide would start: take it from sin p0 there.
        shared = 1.0 - vers - excess
        if abs(k - shared) > NOISE:
            k = shared
    # cos c as this sum keeps its digits where p0 -> 0, unlike 1 - vers
    return Start(Onset(c, excess + k, sine, vers, excess, k, load), window, open_rate, close_rate)


def reaches(loads: Loads, own: Start, other: Start, offset: float) -> int:
    """Whether a slide still moves (+1) where the opposite window opens, Eqs. (17) and (58).

    0 where rounding decides.

    ``offset`` is E of static friction, seen from this slide.
    """
    onset = own.onset
    drag = onset.load * onset.k
    loss = drag * (own.window - other.window + (offset + PI))
    begin = onset.load * onset.sin
    scale = begin - other.open_rate if loads.line else _rounding_size(own, other)
    return rounded_sign(begin - other.open_rate - loss, scale + abs(drag))


def cosine_lead(loads: Loads, at: Thresholds, forward: Onset, back: Onset) -> tuple[float, float]:
    """Return cos p_f - cos p_b of a line's two onsets, and the size of what cancels in it.

    From the difference of their squared sines, which cancels only where they do: it decides between cycles
    whose k is far below the rounding of either cosine.
    """
    lift, capacity = loads.static_friction * loads.drive_normal, loads.static_friction * loads.weight_normal
    product = at.forward_load * at.back_load
    scale = 4.0 / (product * product * (forward.sin + back.sin))
    a, b = lift * capacity, loads.weight_tangential * loads.drive_tangential
    c, d = capacity * loads.drive_tangential, loads.weight_tangential * lift
    return (a - b) * (c - d) * scale, (a + abs(b)) * (c + abs(d)) * scale


def outlasts(own: Start, other: Start, offset: float, ahead: float, size: float) -> int:
    """Whether a slide still moves (+1) where the opposite window closes, Eqs. (17) and (58).

    0 where rounding decides.

    In the opposite window the load is against the slide, whose speed falls up to there, for k < 0 too.

    Parameters
    ----------
    own, other : Start
        The slide, and the opposite one.
    offset : float
        E of static friction, seen from this slide [rad].
    ahead, size : float
        Speed that the load alone would leave, over C, and the size of what cancels in it: ``cosine_lead`` of
        lines, ``speed_at_close`` of other drives.
    """
    onset = own.onset
    loss = onset.k * (PI + own.window + other.window + offset)
    return rounded_sign(ahead - loss, size + abs(loss))


def speed_at_close(own: Start, other: Start) -> tuple[float, float]:
    """Return what ``outlasts`` needs of drives that do not move along a line."""
    load = own.onset.load
    return own.onset.sin - other.close_rate / load, _rounding_size(own, other) / load


def _rounding_size(own: Start, other: Start) -> float:
    """Size of what cancels between rates of two windows: in one of half-length w they are good to eps / w."""
    shorter = min(own.window, other.window) + _LEAST
    return (own.onset.load + other.onset.load) * (1.0 + 1.0 / shorter)
