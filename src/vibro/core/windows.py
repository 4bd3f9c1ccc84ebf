"""Where the load of a body at rest exceeds static friction, and what a slide that starts there meets.

Each direction has one static window a cycle, Eqs. (5) and (55)-(58) of docs/theory. A slide in the
direction s = +1 (forward) or -1 (back) with the coefficient mu is pulled by C sin(p + psi), C e^{i psi} = s a
e^{-i phi} + mu b: p + psi is the slide's own phase. Loads are over m A w^2, phases in radians.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from vibro.core.buffers import PIECES
from vibro.core.cells import find_nodes, largest, number_of_nodes
from vibro.core.drives import Loads, mix_of
from vibro.core.elementary import FEW_ULP, NOISE, PI, hypotenuse, rounded_sign
from vibro.core.slide import Onset
from vibro.core.waves import NORMAL, SINE, STATIC_BACK, STATIC_FORWARD, Mix, stays_zero

__all__ = [
    "Start", "Thresholds", "cosine_lead", "is_held_at_limit", "load_amplitude", "outlasts", "own_phase",
    "phase_offset", "reaches", "resting_start", "speed_at_close", "thresholds", "thresholds_of",
]  # fmt: skip

# [1] The least double keeps quotients of a drive without load from being 0 / 0.
_TINY: Final = 5e-324
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
        ahead = lift * ((lift + 2.0 * level) / (hypotenuse(lift + level, steep) + (a + _TINY)))
        behind = lift * ((lift - 2.0 * level) / (hypotenuse(lift - level, steep) + (a + _TINY)))
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
        load = hypotenuse(kinetic, steep) + _TINY
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
        half = sine / max(1.0 + (excess + k), _TINY)
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
    shorter = min(own.window, other.window) + _TINY
    return (own.onset.load + other.onset.load) * (1.0 + 1.0 / shorter)
