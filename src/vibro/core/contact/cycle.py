"""The steady cycle that a body at rest settles into, for every contact pattern.

Equation numbers are those of docs/theory.md. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Pattern
from vibro.core.contact.slide import Onset, slide, start_inside
from vibro.core.groups import put, take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.onset import Margins
    from vibro.core.contact.slide import Floats
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]
    Codes = NDArray[np.int8]

__all__ = [
    "Cycles",
    "NeverAtRest",
    "never_at_rest",
    "one_way_cycles",
    "resting_start",
    "slides_forward_only",
    "two_way_cycles",
]

# [1] Relative rounding noise of a slide's speed, and of a load, where the next leg is decided.
_NOISE: Final = 16 * 2.0**-52


class Cycles(NamedTuple):
    """Steady cycles of slipping scenes, 1-D.

    Attributes
    ----------
    pattern : int8 array
        Codes of ``Pattern``.
    displacement : array
        Displacement per drive cycle [A]; NaN where the slide never ends.
    peak : array
        Largest relative speed [A w].
    coexists, edge, settled : bool array
        Whether another steady cycle attracts too; whether rounding decided the pattern; whether every
        slide was solved.
    """

    pattern: Codes
    displacement: Floats
    peak: Floats
    coexists: Bools
    edge: Bools
    settled: Bools


class _Start(NamedTuple):
    """A slide from rest: its onset and the load amplitude while it slides, C or B of Eq. (3)."""

    onset: Onset
    load: Floats


def resting_start(scene: Loads, at: Margins, direction: int) -> _Start:
    """Slide from rest, forward (+1) or back (-1), Eqs. (3)-(6), without cancellation."""
    margin, static_load = (at.forward, at.forward_load) if direction > 0 else (at.back, at.back_load)
    mu_d = scene.kinetic_friction
    load = scene.along + direction * mu_d * scene.across
    vers = margin / static_load  # 1 - sin p0
    excess = (scene.static_friction - mu_d) * scene.contrast / (static_load * load)
    k = (mu_d * scene.normal + direction * scene.tangential) / load
    if np.count_nonzero(scene.tangential):
        # Where the weight down the trough nearly cancels friction, rounding may bring k above sin p0, and no
        # slide would start: take it from sin p0 there.
        shared = 1.0 - vers - excess
        k = np.where(np.abs(k - shared) > _NOISE, shared, k)
    onset = Onset(
        c=2.0 * np.arcsin(np.sqrt(0.5 * vers)),
        cos=excess + k,  # keeps its digits where p0 -> 0, unlike 1 - vers
        sin=np.sqrt(vers * (2.0 - vers)),
        vers=vers,
        excess=excess,
        k=k,
    )
    return _Start(onset, load)


class _Verdict(NamedTuple):
    """Sign of a speed or a load margin, and whether rounding decides it."""

    positive: Bools
    edge: Bools


def _verdict(value: Floats, scale: Floats) -> _Verdict:
    noise = _NOISE * scale
    return _Verdict(value > noise, np.abs(value) <= noise)


def _reaches(start: Onset, other: Onset) -> _Verdict:
    """Whether a slide still moves where the opposite load window opens, own phase 3 pi/2 - c, Eq. (17)."""
    speed = start.sin + other.sin - start.k * (np.pi + start.c - other.c)
    return _verdict(speed, start.sin + other.sin + np.abs(start.k))


class _Lead(NamedTuple):
    """cos p_f - cos p_b of the two onsets, and the size of what cancels in it."""

    value: Floats
    size: Floats


def _lead(scene: Loads, at: Margins, forward: Onset, back: Onset) -> _Lead:
    """Difference of the onsets' cosines from that of their squared sines, which cancels only where they do.

    It decides between cycles whose k is far below the rounding of either cosine.
    """
    mu_s = scene.static_friction
    lift, hold = mu_s * scene.across, mu_s * scene.normal
    loads = at.forward_load * at.back_load
    scale = 4.0 / (loads * loads * (forward.sin + back.sin))
    if not np.count_nonzero(scene.tangential):
        value = lift * hold * (hold * scene.along) * scale
        return _Lead(value, value)
    a, b = lift * hold, scene.tangential * scene.along
    c, d = hold * scene.along, scene.tangential * lift
    return _Lead((a - b) * (c - d) * scale, (a + np.abs(b)) * (c + np.abs(d)) * scale)


def _outlasts(start: Onset, other: Onset, lead: _Lead, sign: int) -> _Verdict:
    """Whether a slide still moves where the opposite load window closes, own phase 3 pi/2 + c, Eq. (17).

    For k < 0 the speed grows again after 2 pi - asin|k|, and is looked at there if that comes first. |k| < 1
    where the other onset exists and the body can rest.
    """
    k, c = start.k, other.c
    ahead, size = sign * lead.value, lead.size
    early = -k > other.cos
    if early.any():
        c = np.where(early, np.arccos(-k), c)
        cosines = start.sin + np.sqrt((1.0 - k) * (1.0 + k))
        ahead = np.where(early, -start.excess * (start.excess + 2.0 * k) / cosines, ahead)
        size = np.where(early, start.excess * (start.excess - 2.0 * k) / cosines, size)
    loss = k * (np.pi + start.c + c)
    return _verdict(ahead - loss, size + np.abs(loss))


def slides_forward_only(scene: Loads, at: Margins) -> tuple[Bools, Bools]:
    """Whether the forward slide of a scene that slips both ways outlasts the back window, and if barely."""
    forward, back = (resting_start(scene, at, direction).onset for direction in (1, -1))
    outlasts = _outlasts(forward, back, _lead(scene, at, forward, back), 1)
    return outlasts.positive | outlasts.edge, outlasts.edge


class NeverAtRest(NamedTuple):
    """The never-at-rest cycle, Eqs. (18)-(19): y = x - pi/2 and m; NaN where there is none."""

    y: Floats
    sin_y: Floats
    cos_y: Floats
    sin_m: Floats
    cos_m: Floats  # of pi - m: positive


def never_at_rest(scene: Loads, forward: _Start, back: _Start) -> tuple[NeverAtRest, _Verdict]:
    """Phases of the never-at-rest cycle, and whether both its slides start beyond static friction."""
    mu_d = scene.kinetic_friction
    possible = (forward.onset.k > 0.0) & (back.onset.k > 0.0)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        turn = mu_d * scene.across * scene.normal - scene.tangential / mu_d * scene.along
        y = np.where(possible, 0.5 * np.pi * turn / scene.contrast, np.nan)
    t = np.tan(0.5 * y)
    cos_y = 2.0 / (1.0 + t * t)
    sin_y = cos_y * t
    cos_y -= 1.0
    sin_m = forward.onset.k * (0.5 * np.pi + y) / cos_y
    possible &= (sin_m > 0.0) & (sin_m < 1.0)
    sin_m = np.where(possible, sin_m, np.nan)
    cos_m = np.sqrt((1.0 - sin_m) * (1.0 + sin_m))
    rise, fall = cos_m * cos_y, sin_m * sin_y
    scale = 1.0 + sin_m
    ahead = _verdict(rise - fall - forward.onset.cos, scale)
    behind = _verdict(rise + fall - back.onset.cos, scale)
    valid = (ahead.positive | ahead.edge) & (behind.positive | behind.edge)
    return NeverAtRest(y, sin_y, cos_y, sin_m, cos_m), _Verdict(valid, valid & (ahead.edge | behind.edge))


def _never_at_rest_motion(
    lift: Floats, along: Floats, slides: tuple[tuple[Floats, Floats], ...], cycle: NeverAtRest
) -> tuple[Floats, Floats]:
    """Displacement, Eq. (20), and peak speed of the never-at-rest cycle.

    ``lift`` is mu_d sin(alpha); ``slides`` the k and the load of the forward and the back slide, which
    start at c = pi - m + y and c = pi - m - y. They are never short, so that Eq. (14) is used as it stands.
    """
    lean = 2.0 * lift * cycle.cos_y + (2.0 * lift * cycle.y + np.pi * along) * cycle.sin_y
    c_m = np.arcsin(cycle.sin_m)
    middle, tilt = cycle.sin_m * cycle.cos_y, cycle.cos_m * cycle.sin_y
    peaks = [
        load
        * (middle + side * tilt + np.sqrt((1.0 - k) * (1.0 + k)) - k * (c_m + side * cycle.y + np.arccos(k)))
        for (k, load), side in zip(slides, (1.0, -1.0), strict=True)
    ]
    return 2.0 * cycle.cos_m * lean, np.maximum(*peaks)


def one_way_cycles(scene: Loads, at: Margins, direction: int) -> Cycles:
    """Steady cycles from rest of scenes that slip one way only: one slide.

    Parameters
    ----------
    scene : Loads
        Scenes in contact that can rest, 1-D, or 0-d members for all.
    at : Margins
        Their distances from slipping, 1-D.
    direction : int
        +1 where they slip forward, -1 where they slip back.

    Returns
    -------
    Cycles
        One element per scene.
    """
    start = resting_start(scene, at, direction)
    end = slide(start.onset)
    pattern = np.empty(end.x.shape, np.int8)
    pattern.fill(Pattern.F_ if direction > 0 else Pattern.B_)
    no = np.zeros(end.x.shape, np.bool_)
    displacement, peak = direction * start.load * end.reach, start.load * end.peak
    return Cycles(pattern, displacement, peak, coexists=no, edge=no, settled=end.settled)


def _blank(n: int) -> Cycles:
    flags = np.zeros((2, n), np.bool_)
    return Cycles(np.zeros(n, np.int8), np.zeros(n), np.zeros(n), flags[0], flags[1], np.ones(n, np.bool_))


class _Slides(NamedTuple):
    """Slides of selected cells, in arrays for all: start c, half-length x, path, top speed, settled."""

    c: Floats
    x: Floats
    path: Floats
    top: Floats
    settled: Bools


def _slides(which: Bools, start: _Start, after: tuple[Onset, _Slides] | None = None) -> _Slides:
    """Slide the selected cells from rest, or from where an opposite slide ends.

    Phases count from the slide's own zero: p0 - pi of the slide before it. Cells not selected have NaN
    for an end, and neither path nor speed.
    """
    n = which.size
    out = _Slides(np.full(n, np.nan), np.full(n, np.nan), np.zeros(n), np.zeros(n), np.ones(n, np.bool_))
    cells = which.nonzero()[0]
    if cells.size:
        load = take(start.load, cells)
        if after is None:
            onset = take(start.onset, cells)
        else:
            before, slides = after
            onset = start_inside(np.pi + before.c[cells] - 2.0 * slides.x[cells], start.onset.k[cells])
        end = slide(onset)
        put(out, cells, (onset.c, end.x, load * end.reach, load * end.peak, end.settled))
    return out


def two_way_cycles(scene: Loads, at: Margins) -> Cycles:
    """Steady cycles from rest of scenes whose load exceeds static friction both ways.

    The finite rule of theory.md, section 5: the sign of the speed at the edges of the opposite load
    window decides the pattern; only a slide that follows another one directly needs its end for that.

    Parameters
    ----------
    scene : Loads
        Scenes in contact that can rest, 1-D, or 0-d members for all.
    at : Margins
        Their distances from slipping, 1-D.

    Returns
    -------
    Cycles
        One element per scene.
    """
    forward, back = resting_start(scene, at, 1), resting_start(scene, at, -1)
    lead = _lead(scene, at, forward.onset, back.onset)
    reaches = _reaches(forward.onset, back.onset)
    outlasts = _outlasts(forward.onset, back.onset, lead, 1)
    motion, valid = never_at_rest(scene, forward, back)

    # Equality belongs to rest: a slide that stops just where the opposite window closes stays at rest.
    f_only = outlasts.positive | outlasts.edge
    meets = reaches.positive & ~f_only  # ends inside the back window
    never = meets & valid.positive
    out = _blank(never.size)
    cells = never.nonzero()[0]
    if cells.size:
        slides = ((forward.onset.k, forward.load), (back.onset.k, back.load))
        parts = (scene.kinetic_friction * scene.across, scene.along, slides, motion)
        out.pattern[cells] = Pattern.FB
        out.displacement[cells], out.peak[cells] = _never_at_rest_motion(*take(parts, cells))
        edge = outlasts.edge | reaches.edge | valid.edge
        out.edge[cells] = edge[cells]
        if np.count_nonzero(scene.tangential):  # on a level trough no back slide outlasts the forward window
            out.coexists[cells] = _outlasts(back.onset, forward.onset, lead, -1).positive[cells]
    cells = (~never).nonzero()[0]
    if cells.size:
        pair = _Pair(forward, back, lead, reaches.edge, outlasts.edge, f_only, meets, valid)
        put(out, cells, _cycles_with_rest(take(pair, cells)))
    return out


class _Pair(NamedTuple):
    """Both slides from rest of scenes that are at rest once a cycle, and what is known of them."""

    forward: _Start
    back: _Start
    lead: _Lead
    reaches_edge: Bools
    outlasts_edge: Bools
    f_only: Bools  # the forward slide outlasts the back window
    meets: Bools  # it ends inside that window
    never_at_rest: _Verdict


def _cycles_with_rest(pair: _Pair) -> Cycles:
    """Steady cycles from rest of scenes whose load exceeds static friction both ways, but for FB."""
    forward, back, lead, f_only, chained = pair.forward, pair.back, pair.lead, pair.f_only, pair.meets
    b_reaches = _reaches(back.onset, forward.onset)
    b_outlasts = _outlasts(back.onset, forward.onset, lead, -1)
    b_lasts = b_outlasts.positive | b_outlasts.edge
    f = _slides(np.ones(f_only.size, np.bool_), forward)
    b_next = _slides(chained, back, after=(forward.onset, f))
    # phase from the end of that back slide to p_f + 2 pi
    f_then_b = chained & (np.pi - forward.onset.c + b_next.c - 2.0 * b_next.x >= 0.0)

    apart = ~(f_only | f_then_b)  # back slip starts from rest
    b_only = apart & b_lasts
    b_then_f = apart & b_reaches.positive & ~b_only
    f_and_b = apart & ~b_only & ~b_then_f
    # Without kinetic friction other cycles are a neutral family: none attracts.
    probe = f_only & ~pair.never_at_rest.positive & b_reaches.positive & (forward.onset.k > 0.0) & ~b_lasts
    b = _slides(apart | probe, back)
    f_next = _slides(b_then_f | probe, forward, after=(back.onset, b))

    out = _blank(f_only.size)
    for which, code, way, retour in (
        (f_only, Pattern.F_, f, None),
        (f_then_b, Pattern.FB_, f, b_next),
        (f_and_b, Pattern.F_B_, f, b),
        (b_then_f, Pattern.F_B, f_next, b),
        (b_only, Pattern.B_, None, b),
    ):
        cells = which.nonzero()[0]
        if cells.size:
            out.pattern[cells] = code
            for slides, sign in ((way, 1.0), (retour, -1.0)):
                if slides is not None:
                    out.displacement[cells] += sign * slides.path[cells]
                    out.peak[cells] = np.maximum(out.peak[cells], slides.top[cells])
                    out.settled[cells] &= slides.settled[cells]

    # A disturbed body can settle elsewhere: F_ beside FB or F_B, and the mirrored pairs.
    probe &= 2.0 * f_next.x - f_next.c + back.onset.c < np.pi  # its forward slide ends before p_b
    out.coexists[:] = (f_only & (pair.never_at_rest.positive | probe)) | (f_then_b & b_outlasts.positive)
    out.edge[:] = pair.outlasts_edge | (~f_only & pair.reaches_edge) | (chained & pair.never_at_rest.edge)
    out.edge[:] |= apart & (b_reaches.edge | b_outlasts.edge)
    return out
