"""The steady cycle that a body at rest settles into, for every contact pattern.

Equation numbers are those of docs/theory.md. Lengths in A, speeds in A w, phases in radians.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from vibro.core.codes import Pattern
from vibro.core.contact.first_slides import first_from_rest
from vibro.core.contact.never_at_rest import (
    by_half_length,
    is_sure,
    likely_never_at_rest,
    never_at_rest_motion,
)
from vibro.core.contact.slide import slide, start_inside
from vibro.core.contact.starts import pair_of, resting_start
from vibro.core.contact.windows import skew_of
from vibro.core.groups import mirrored, put, take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.contact.never_at_rest import NeverAtRest, Slides
    from vibro.core.contact.onset import Margins
    from vibro.core.contact.slide import Floats, Onset
    from vibro.core.contact.starts import Pair, Verdict
    from vibro.core.groups import Loads

    Bools = NDArray[np.bool_]
    Codes = NDArray[np.int8]

__all__ = ["Cycles", "one_way_cycles", "slides_forward_only", "two_way_cycles"]


# The pattern of a cycle that is seen from the other side.
_MIRRORED: Final = np.array(
    [
        Pattern.NONE,
        Pattern.R,
        Pattern.B_,
        Pattern.F_,
        Pattern.F_B_,
        Pattern.F_B,
        Pattern.FB_,
        Pattern.FB,
    ],
    np.int8,
)


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


def slides_forward_only(scene: Loads, at: Margins) -> tuple[Bools, Bools]:
    """Whether the forward slide of a scene that slips both ways outlasts the back window, and if barely."""
    outlasts = pair_of(scene, at).outlasts(1)
    return outlasts.positive | outlasts.edge, outlasts.edge


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


def _slides(which: Bools, start: _Slide, after: tuple[_Slides, Floats] | None = None) -> _Slides:
    """Slide the selected cells from rest, or from where an opposite slide ends.

    Phases are the slide's own, whose zero lies half a turn and a ``swing`` after that of the slide before it.
    Cells not selected have NaN for an end, and neither path nor speed.
    """
    n = which.size
    out = _Slides(np.full(n, np.nan), np.full(n, np.nan), np.zeros(n), np.zeros(n), np.ones(n, np.bool_))
    cells = which.nonzero()[0]
    if cells.size:
        load = take(start.load, cells)
        if after is None:
            onset = take(start.onset, cells)
        else:
            before, swing = after
            c = np.pi + before.c[cells] - 2.0 * before.x[cells] + take(swing, cells)
            onset = start_inside(c, start.onset.k[cells])
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
    pair = pair_of(scene, at)
    out = _forward_first(scene, pair)
    if scene.lead and np.count_nonzero(scene.tangential):
        cells = (out.coexists | np.isnan(out.displacement)).nonzero()[0]
        if cells.size:
            _start_as_they_lie(take(scene, cells), take(pair, cells), out, cells)
    return out


def _start_as_they_lie(scene: Loads, pair: Pair, out: Cycles, cells: NDArray[np.intp]) -> None:
    """Solve again, in place, where cycles coexist and the first slide from a rest is not a forward one."""
    way = first_from_rest(scene, pair)
    back = (way < 0).nonzero()[0]
    if back.size:
        cycles = _forward_first(mirrored(take(scene, back)), take(pair, back).mirrored())
        pattern, displacement = _MIRRORED[cycles.pattern], -cycles.displacement
        put(out, cells[back], cycles._replace(pattern=pattern, displacement=displacement))
    never = (way == 0).nonzero()[0]
    if never.size:
        scene, pair = take((scene, pair), never)
        motion, valid = by_half_length(scene, pair.forward, pair.back)
        displacement, peak = never_at_rest_motion(scene, _slides_of(pair), motion)
        flags = np.ones(never.size, np.bool_), valid.edge, valid.positive
        put(out, cells[never], Cycles(np.full(never.size, Pattern.FB, np.int8), displacement, peak, *flags))


def _forward_first(scene: Loads, pair: Pair) -> Cycles:
    """Steady cycles of bodies whose first slide goes forward from rest."""
    seen = _Seen(pair.reaches(1), pair.outlasts(1), pair.reaches(-1), pair.outlasts(-1))
    motion, valid = likely_never_at_rest(scene, pair.forward, pair.back)

    # Equality belongs to rest: a slide that stops just where the opposite window closes stays at rest.
    f_only = seen.outlasts.positive | seen.outlasts.edge
    meets = seen.reaches.positive & ~f_only  # ends inside the back window
    never = meets & valid.positive
    out = _blank(never.size)
    cells = never.nonzero()[0]
    if cells.size:
        _write_never_at_rest(out, cells, take((scene, _slides_of(pair), motion), cells), seen)
        out.edge[cells] |= valid.edge[cells]
    cells = (~never).nonzero()[0]
    if cells.size:
        starts = _Slide(pair.forward.onset, pair.forward.load), _Slide(pair.back.onset, pair.back.load)
        rests = _Rests(*starts, skew_of(scene, scene.kinetic_friction), seen, f_only, meets, valid)
        put(out, cells, _cycles_with_rest(take(rests, cells)))
    if scene.lead:
        _look_again(scene, pair, out, seen, meets, motion)
    return out


class _Seen(NamedTuple):
    """Whether the forward slide from rest reaches and outlasts the back window, and the other way round."""

    reaches: Verdict
    outlasts: Verdict
    b_reaches: Verdict
    b_outlasts: Verdict


def _slides_of(pair: Pair) -> Slides:
    """Return what the never-at-rest motion needs of both slides."""
    return (pair.forward.onset.k, pair.forward.load), (pair.back.onset.k, pair.back.load)


def _write_never_at_rest(
    out: Cycles, cells: NDArray[np.intp], chosen: tuple[Loads, Slides, NeverAtRest], seen: _Seen
) -> None:
    """Put never-at-rest cycles where they belong."""
    out.pattern[cells] = Pattern.FB
    out.displacement[cells], out.peak[cells] = never_at_rest_motion(*chosen)
    out.edge[cells] = (seen.outlasts.edge | seen.reaches.edge)[cells]
    out.coexists[cells] = seen.b_outlasts.positive[cells]
    out.settled[cells] = True


def _look_again(
    scene: Loads, pair: Pair, out: Cycles, seen: _Seen, meets: Bools, motion: NeverAtRest
) -> None:
    """Find never-at-rest cycles of elliptical drives that the quick way may have missed, in place.

    Where FB is the answer, the back slide after the forward slide from rest reaches the forward window.
    """
    late = meets & ((out.pattern == Pattern.F_B) | (out.pattern == Pattern.B_))
    beside = out.pattern == Pattern.F_
    cells = ((late | beside) & ~is_sure(scene, motion)).nonzero()[0]
    if not cells.size:
        return
    motion, valid = by_half_length(*take((scene, pair.forward, pair.back), cells))
    out.coexists[cells] |= valid.positive & beside[cells]
    here = (valid.positive & late[cells]).nonzero()[0]
    if here.size:
        cells = cells[here]
        chosen = *take((scene, _slides_of(pair)), cells), take(motion, here)
        _write_never_at_rest(out, cells, chosen, seen)


class _Slide(NamedTuple):
    """A slide from rest: its onset and its load amplitude."""

    onset: Onset
    load: Floats


class _Rests(NamedTuple):
    """Both slides of scenes that are at rest once a cycle, and what is known of them.

    ``swing`` is what the back slide's own phase is beyond half a turn after that of the forward slide.
    """

    forward: _Slide
    back: _Slide
    swing: Floats
    seen: _Seen
    f_only: Bools  # the forward slide outlasts the back window
    meets: Bools  # it ends inside that window
    never_at_rest: Verdict


def _cycles_with_rest(rests: _Rests) -> Cycles:
    """Steady cycles from rest of scenes whose load exceeds static friction both ways, but for FB."""
    forward, back, swing, seen = rests.forward, rests.back, rests.swing, rests.seen
    f_only, chained, b_outlasts = rests.f_only, rests.meets, seen.b_outlasts
    b_lasts = b_outlasts.positive | b_outlasts.edge
    f = _slides(np.ones(f_only.size, np.bool_), forward)
    b_next = _slides(chained, back, after=(f, swing))
    # phase from the end of that back slide to p_f + 2 pi
    f_then_b = chained & (np.pi - forward.onset.c + b_next.c - 2.0 * b_next.x - swing >= 0.0)

    apart = ~(f_only | f_then_b)  # back slip starts from rest
    b_only = apart & b_lasts
    b_then_f = apart & seen.b_reaches.positive & ~b_only
    f_and_b = apart & ~b_only & ~b_then_f
    # Without kinetic friction other cycles are a neutral family: none attracts.
    probe = f_only & ~rests.never_at_rest.positive & seen.b_reaches.positive & ~b_lasts
    probe &= forward.onset.k > 0.0
    b = _slides(apart | probe, back)
    f_next = _slides(b_then_f | probe, forward, after=(b, -swing))

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
    probe &= 2.0 * f_next.x - f_next.c + back.onset.c - swing < np.pi  # its forward slide ends before p_b
    out.coexists[:] = (f_only & (rests.never_at_rest.positive | probe)) | (f_then_b & b_outlasts.positive)
    out.edge[:] = seen.outlasts.edge | (~f_only & seen.reaches.edge) | (chained & rests.never_at_rest.edge)
    out.edge[:] |= apart & (seen.b_reaches.edge | b_outlasts.edge)
    return out
