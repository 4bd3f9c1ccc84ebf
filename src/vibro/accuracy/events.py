"""Event-driven simulation: an ODE solver integrates each slide, and an event ends it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, Literal

from scipy.integrate import solve_ivp

from vibro.accuracy.motion import Found

if TYPE_CHECKING:
    from vibro.accuracy.motion import TroughBody

    Solver = Literal["RK45", "DOP853", "LSODA"]

__all__ = ["simulate_by_events"]

_TURN: Final = 2.0 * math.pi
_LONGEST_SLIDE: Final = 2.0 * _TURN  # [rad] no slide of a steady cycle lasts longer than one turn
_MOST_SLIDES: Final = 2000
_SETTLED: Final = 10.0  # [rtol] smaller changes of a slide's start from cycle to cycle count as none


def simulate_by_events(
    motion: TroughBody,
    solver: Solver,
    rtol: float,
    max_step: float = math.inf,
    most_slides: int = _MOST_SLIDES,
) -> Found:
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
    most_slides : int, optional
        When to give up.

    Returns
    -------
    Found
        NaN if the motion does not repeat or a slide does not end.
    """
    onsets = dict(zip("FB", motion.onsets(), strict=True))
    phase, place = 0.0, 0.0
    kind = _next_from_rest(onsets, phase)[0]
    if not kind:
        return Found(0.0, "")
    from_rest = True
    seen: dict[str, tuple[float, float, int]] = {}  # last start from rest: phase, place, slides so far
    previous: tuple[float, float, int] | None = None  # last start of a forward slide
    slides = ""
    while len(slides) < most_slides:
        if from_rest:
            kind, phase = _next_from_rest(onsets, phase)
            previous = None
        here = (phase, place, len(slides))
        if from_rest and kind in seen:
            return _cycle(seen[kind], here, slides)
        if from_rest:
            seen[kind] = here
        elif kind == "F":
            if previous and abs(phase - previous[0] - _TURN) <= max(_SETTLED * rtol, 1e-13):
                return _cycle(previous, here, slides)
            previous = here
        end, distance = _slide(motion, kind, phase, solver, rtol, max_step)
        if end is None:
            break
        slides += kind
        phase, place = end, place + distance
        load = motion.along * math.sin(phase) - motion.tangential
        held = motion.static_friction * (motion.normal - motion.across * math.sin(phase))
        from_rest = abs(load) <= held
        kind = "F" if load > 0.0 else "B"
    return Found(math.nan, "")


def _next_from_rest(onsets: dict[str, float | None], phase: float) -> tuple[str, float]:
    """Direction and phase of the next slide of a body at rest; an empty direction if there is none."""
    coming = [
        (onset + _TURN * math.ceil((phase - onset) / _TURN), kind)
        for kind, onset in onsets.items()
        if onset is not None
    ]
    start, kind = min(coming, default=(phase, ""))
    return kind, start


def _slide(
    motion: TroughBody, kind: str, start: float, solver: Solver, rtol: float, max_step: float
) -> tuple[float | None, float]:
    """End and distance of one slide from rest; no end if the solver finds none."""
    sign = 1.0 if kind == "F" else -1.0
    drag = sign * motion.kinetic_friction
    load = motion.along + drag * motion.across
    resistance = motion.tangential + drag * motion.normal

    def rates(phase: float, y: Any) -> tuple[float, float]:
        return y[1], load * math.sin(phase) - resistance

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


def _cycle(first: tuple[float, float, int], again: tuple[float, float, int], slides: str) -> Found:
    turns = round((again[0] - first[0]) / _TURN)
    return Found((again[1] - first[1]) / turns, "".join(sorted(set(slides[first[2] : again[2]]))))
