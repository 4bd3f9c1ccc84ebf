"""A second witness: SciPy integrates the equations of motion, with events for stick and slip."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pytest
from scenes import Groups, at_load, solve_one
from scipy.integrate import solve_ivp

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TURN = 2.0 * math.pi
TOLERANCE = 1e-12  # of the integrator, relative and absolute [g/w^2]


class Settled(NamedTuple):
    pattern: str
    displacement: float


class Motion:
    """A body on the trough in time, as Coulomb's law says it: no closed form, no threshold, no onset."""

    def __init__(self, groups: Groups) -> None:
        alpha, self.beta = math.radians(groups.drive_deg), math.radians(groups.trough_deg)
        self.a, self.b = groups.load * math.cos(alpha), groups.load * math.sin(alpha)
        self.mu_s, self.mu_d = groups.mu_s, groups.mu_d

    def tangential(self, p: float) -> float:
        return self.a * math.sin(p) - math.sin(self.beta)

    def normal(self, p: float) -> float:
        return math.cos(self.beta) - self.b * math.sin(p)

    def advance(self, way: int, p: float, position: float, end: float) -> tuple[float, float]:
        """Slide one way from rest until the speed returns to zero."""

        def equations(p: float, state: Floats) -> list[float]:
            return [state[1], self.tangential(p) - way * self.mu_d * self.normal(p)]

        def stops(p: float, state: Floats) -> float:
            return float(way * state[1])

        stops.terminal, stops.direction = True, -1.0  # type: ignore[attr-defined]
        result = solve_ivp(
            equations, (p, end), [position, 0.0], "DOP853", events=stops, rtol=TOLERANCE, atol=TOLERANCE
        )
        assert result.t_events is not None
        assert result.y_events is not None
        assert result.status == 1, "the slide did not end"
        return float(result.t_events[0][0]), float(result.y_events[0][0][0])

    def stick(self, p: float, end: float) -> tuple[float, int]:
        """Stick until friction can no longer hold the body; 0 if it always can."""

        def equations(p: float, state: Floats) -> list[float]:
            return [0.0]

        def lets_go(way: int) -> Callable[[float, Floats], float]:
            def event(p: float, state: Floats) -> float:
                return way * self.tangential(p) - self.mu_s * self.normal(p)

            event.terminal, event.direction = True, 1.0  # type: ignore[attr-defined]
            return event

        events = [lets_go(1), lets_go(-1)]
        result = solve_ivp(
            equations, (p, end), [0.0], events=events, max_step=0.05, rtol=TOLERANCE, atol=TOLERANCE
        )
        assert result.t_events is not None
        for way, times in zip((1, -1), result.t_events, strict=True):
            if times.size:
                return float(times[0]), way
        return end, 0

    def slips(self, p: float) -> int:
        for way in (1, -1):
            if way * self.tangential(p) > self.mu_s * self.normal(p):
                return way
        return 0

    def settle(self, cycles: int) -> Settled:
        """Integrate from rest at phase 0, and report the last whole cycle."""
        p, position, last = 0.0, 0.0, cycles * TURN
        phases: list[tuple[str, float, float]] = []  # kind, start, position at the start
        while p < last:
            way = self.slips(p)
            if not way:
                start = p
                p, way = self.stick(p, p + 1.001 * TURN)
                phases.append(("_", start, position))
            if way:
                phases.append(("F" if way > 0 else "B", p, position))
                p, position = self.advance(way, p, position, p + 2.0 * TURN)
        if all(kind == "_" for kind, _, _ in phases):
            return Settled("_", 0.0)
        # between two starts of the last phase that leads a cycle
        lead = "F" if any(kind == "F" for kind, _, _ in phases[-6:]) else "B"
        starts = [i for i, (kind, _, _) in enumerate(phases) if kind == lead]
        first, second = starts[-2:]
        assert phases[second][1] - phases[first][1] == pytest.approx(TURN, abs=1e-6)
        pattern = "".join(kind for kind, _, _ in phases[first:second])
        return Settled(pattern, phases[second][2] - phases[first][2])


@pytest.mark.parametrize(
    ("pattern", "groups", "cycles"),
    [
        ("_", Groups(0.5, 20.0, 0.74, 0.57), 3),
        ("F_", Groups(0.9, 20.0, 0.74, 0.57), 4),
        ("F_", Groups(0.95, 75.0, 0.4, 0.25, 9.0), 4),
        ("F_", Groups(0.25, 10.0, 0.5, 0.2, -13.0), 4),
        ("B_", Groups(0.582, 0.43, 0.752, 0.565, 10.62), 4),
        ("F_B_", Groups(1.1, 20.0, 0.74, 0.57), 4),
        ("F_B_", Groups(0.922, 9.38, 0.692, 0.62, 2.97), 4),
        ("FB_", Groups(1.36, 20.0, 0.74, 0.57), 4),
        ("FB_", Groups(1.007, 16.82, 0.51, 0.426, -8.95), 4),
        ("F_B", Groups(0.781, 57.03, 0.27, 0.155, 3.46), 4),
        ("F_B", Groups(0.599, 16.44, 0.359, 0.242, 2.97), 4),
        ("FB", Groups(2.0, 20.0, 0.74, 0.57), 40),
        ("FB", Groups(2.859, 19.78, 0.831, 0.6, 10.47), 40),
    ],
)
def test_integrated_motion_settles_into_the_same_cycle(pattern: str, groups: Groups, cycles: int) -> None:
    cycle = solve_one(groups)
    assert cycle.pattern == pattern
    scene = at_load(*groups)
    w = TURN * float(scene.frequency)
    expected = float(cycle.displacement_per_cycle) * w**2 / float(scene.gravity)
    settled = Motion(groups).settle(cycles)
    assert settled.pattern == pattern
    assert settled.displacement == pytest.approx(expected, abs=1e-9 * groups.load)
