"""Event-driven simulation: each slide is followed to its end, which an event or a root finds."""

from __future__ import annotations

import itertools
import math
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Literal

from scipy.integrate import solve_ivp

from vibro.accuracy.motion import Found

if TYPE_CHECKING:
    from collections.abc import Callable

    from vibro.accuracy.motion import TroughBody

    Solver = Literal["RK45", "DOP853", "LSODA"]
    Visit = tuple[Any, Any, int]  # start of a slide: phase, place [A], and the number of slides before it


_TURN: Final = 2.0 * math.pi
_LONGEST_SLIDE: Final = 2.0 * _TURN  # [rad] no slide of a steady cycle lasts longer than one turn
_MOST_SLIDES: Final = 2000  # before a walk gives up
_SETTLED: Final = 10.0  # [rtol] smaller changes of a slide's start from cycle to cycle count as none
_ROUNDING: Final = 1e-13  # [rad] of phases after many cycles


def walk(
    motion: TroughBody,
    slide: Callable[[TroughBody, str, Any], tuple[Any, Any]],
    settled: float,
    library: Any = math,
    *,
    extrapolates: bool = False,
) -> Found:
    """Follow one scene in contact from rest, from slide to slide, until the motion repeats.

    Parameters
    ----------
    motion : TroughBody
        One scene.
    slide : callable
        ``slide(motion, kind, phase)`` follows a slide from rest, forward (F) or back (B): its end and its
        distance [A]; the end is None if there is none.
    settled : float
        Smaller changes of the start of a slide from cycle to cycle count as none [rad].
    library : module, optional
        Where functions come from: ``math``, or a context of ``mpmath``.
    extrapolates : bool, optional
        Speed up chains of slides without rest: Steffensen's method on the starts of forward slides.

    Returns
    -------
    Found
        NaN if the motion does not repeat or a slide does not end.
    """
    turn = 2 * library.pi
    onsets = dict(zip("FB", motion.onsets(library), strict=True))
    phase, place, slides, kind = 0.0, 0.0, "", ""
    from_rest = True
    seen: dict[str, Visit] = {}  # last start from rest
    starts: list[Visit] = []  # of the forward slides since the last rest
    while len(slides) < _MOST_SLIDES:
        if from_rest:
            coming = [
                (onset + turn * library.ceil((phase - onset) / turn), way)
                for way, onset in onsets.items()
                if onset is not None
            ]
            if not coming:
                return Found(0.0, "")
            phase, kind = min(coming)
            starts = []
        here = (phase, place, len(slides))
        if from_rest:
            if kind in seen:
                return _cycle(seen[kind], here, slides)
            seen[kind] = here
        elif kind == "F":
            starts.append(here)
            changes = [again[0] - first[0] - turn for first, again in itertools.pairwise(starts)]
            if changes and abs(changes[-1]) <= settled:
                return _cycle(starts[-2], here, slides)
            if extrapolates and len(changes) == 2 and changes[0] != changes[1]:
                limit = phase + changes[1] ** 2 / (changes[0] - changes[1])
                load, held = motion.load_and_hold(library.sin(limit))
                if load > held:
                    phase = limit
                starts = [(phase, place, len(slides))]
        end, distance = slide(motion, kind, phase)
        if end is None:
            break
        slides += kind
        phase, place = end, place + distance
        load, held = motion.load_and_hold(library.sin(phase))
        from_rest = abs(load) <= held
        kind = "F" if load > 0.0 else "B"
    return Found(math.nan, "")


def _cycle(first: Visit, again: Visit, slides: str) -> Found:
    turns = round(float(again[0] - first[0]) / _TURN)
    return Found((again[1] - first[1]) / turns, "".join(sorted(set(slides[first[2] : again[2]]))))


def simulate_by_events(motion: TroughBody, solver: Solver, rtol: float, max_step: float = math.inf) -> Found:
    """Simulate from rest until the motion repeats.

    The body starts from rest where the load reaches static friction, known in closed form; ``solve_ivp``
    integrates the slide and stops when the speed falls to zero. Then the body rests, or the load drives it
    the other way at once.

    Parameters
    ----------
    motion : TroughBody
        One scene in contact.
    solver : str
        ``method`` of ``solve_ivp``.
    rtol : float
        Relative tolerance, and the absolute one in units of A and A w.
    max_step : float, optional
        Longest step [rad].

    Returns
    -------
    Found
        NaN if the motion does not repeat or a slide does not end.
    """
    slide = partial(_slide, solver=solver, rtol=rtol, max_step=max_step)
    return walk(motion, slide, max(_SETTLED * rtol, _ROUNDING))


def _slide(
    motion: TroughBody, kind: str, start: float, *, solver: Solver, rtol: float, max_step: float
) -> tuple[float | None, float]:
    """End and distance of one slide from rest; no end if the solver finds none."""
    sign = 1.0 if kind == "F" else -1.0
    load, resistance = motion.sliding(sign)

    def rates(phase: float, y: Any) -> tuple[float, float]:
        return y[1], load * math.sin(phase) - sign * resistance

    def speed(phase: float, y: Any) -> float:
        return float(y[1])

    speed.terminal = True  # type: ignore[attr-defined]
    speed.direction = -sign  # type: ignore[attr-defined]
    run = solve_ivp(
        rates, (start, start + _LONGEST_SLIDE), (0.0, 0.0), method=solver, events=speed,
        rtol=rtol, atol=rtol, max_step=max_step,
    )  # fmt: skip
    if run.status != 1:
        return None, math.nan
    return float(run.t[-1]), float(run.y[0, -1])
