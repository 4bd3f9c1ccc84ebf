"""Extreme bodies: how speeds and landings count, and which of the frequencies of a load is taken."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from helpers.scenes import replaced, scene_with

import vibro
from vibro import Regime, Status
from vibro.designs.guarantees import (
    BRIEF,
    Landings,
    Seen,
    counted,
    look_around,
    searched,
    taken,
)
from vibro.designs.spaces import uncertainty_set

INF, NAN = math.inf, math.nan


def cycle(**fields: Any) -> Any:
    """Cycles of which only some fields are known."""
    return SimpleNamespace(**{name: np.array(values) for name, values in fields.items()})


@pytest.mark.parametrize(
    ("status", "speed", "slow", "fast"),
    [
        (Status.OK, 0.5, 0.5, 0.5),
        (Status.BOUNDARY, 0.5, 0.5, 0.5),
        (Status.AVERAGED, 0.5, 0.2, 0.8),  # three errors of 0.1
        (Status.RUNAWAY, NAN, -INF, INF),
        (Status.INDETERMINATE, NAN, -INF, INF),
        (Status.INFEASIBLE, NAN, -INF, INF),
        (Status.FLIGHT_NOT_MODELLED, NAN, NAN, NAN),
        (Status.UNRESOLVED, NAN, NAN, NAN),
    ],
)
def test_speeds_count_by_their_status(status: Status, speed: float, slow: float, fast: float) -> None:
    found = cycle(status=[status], mean_velocity=[speed], mean_velocity_error=[0.1])
    assert counted(found, fast=False) == pytest.approx([slow], nan_ok=True)
    assert counted(found, fast=True) == pytest.approx([fast], nan_ok=True)


@pytest.mark.parametrize(
    ("impact", "flight", "exceeds"),
    [(1.0, 0.5, False), (1.001, 0.5, True), (1.0, 0.501, True), (0.0, 0.0, False), (NAN, NAN, False)],
)
def test_a_landing_at_its_limit_is_allowed(impact: float, flight: float, exceeds: bool) -> None:
    found = cycle(impact_velocity=[impact], flight_fraction=[flight])
    assert Landings(1.0, 0.5).exceeded(found).tolist() == [exceeds]


def test_the_hardest_landing_may_lie_inside_a_band() -> None:
    """Samples find harder landings than both ends of the frequencies have."""
    steps = np.linspace(14.0, 18.0, 401)
    hardness = np.asarray(vibro.solve(scene_with(amplitude=10e-3, frequency=steps)).impact_velocity)
    inside, ends = np.nanmax(hardness), max(hardness[0], hardness[-1])
    assert inside > ends * 1.02  # or the test shows nothing
    box = uncertainty_set(scene_with(amplitude=10e-3), {"frequency": (14.0, 18.0)})
    worst = Landings(impact_speed=0.5 * (inside + ends)).worst(box)
    assert worst.shape == (6, 1)
    assert 0.0 < worst[0, 0] < 1.0


@pytest.mark.parametrize("conveys", ["forward", "backward"])
@pytest.mark.parametrize("fast", [False, True])
def test_of_the_frequencies_of_a_load_the_extreme_one_is_taken(conveys: str, fast: bool) -> None:
    """Speeds go with 1/f: backward, down a climb, the lowest frequency is the slowest."""
    back: dict[str, Any] = {"drive_angle": 0.05, "trough_angle": 0.3, "kinetic_friction": 0.5}
    scene = scene_with(**({} if conveys == "forward" else back))
    box = uncertainty_set(scene, {"amplitude": (1.4e-3, 2.2e-3), "frequency": (12.0, 15.0)})
    share = np.array([[0.5], [0.0], [0.0], [0.0], [0.0], [0.0]])
    weight = float(box.points(share).load[0]) * 9.81 / (2.0 * math.pi) ** 2
    frequency = np.linspace(math.sqrt(weight / 2.2e-3), 15.0, 9)
    speeds = vibro.solve(replaced(scene, amplitude=weight / frequency**2, frequency=frequency)).mean_velocity
    assert np.all(speeds > 0.0) if conveys == "forward" else np.all(speeds < 0.0)
    found = taken(box, share, fast=fast, flight=False, seen=Seen())
    assert found.speed == pytest.approx(np.max(speeds) if fast else np.min(speeds), rel=1e-9)
    assert float(np.ravel(vibro.solve(found.scene).mean_velocity)[0]) == found.speed
    every = np.array([[0.0, 1.0], *[[0.0, 0.0]] * 5])
    best, _ = searched(box, fast=fast, boxes=BRIEF, seen=Seen())
    ends = [taken(box, every[:, [i]], fast=fast, flight=False, seen=Seen()).speed for i in range(2)]
    extreme = max(found.speed, *ends) if fast else min(found.speed, *ends)
    assert (best.speed >= extreme - 1e-12) if fast else (best.speed <= extreme + 1e-12)


def test_forward_slip_is_seen_at_the_angle_of_friction_alone() -> None:
    """The onset load is least where tan(alpha) = mu_s: mu_s / sqrt(1 + mu_s^2), within 1e-5 rad of it."""
    least = 0.5 / math.sqrt(1.25) * (1.0 + 1e-11)
    amplitude = least * 9.81 / (2.0 * math.pi * 15.0) ** 2
    scene = scene_with(amplitude=amplitude, static_friction=0.5, kinetic_friction=0.4)
    seen = Seen()
    look_around(uncertainty_set(scene, {"drive_angle": (0.2, 1.0)}), seen)
    assert seen.regimes == {Regime.NO_SLIP, Regime.FORWARD_SLIP}


def test_a_regime_between_the_corners_is_seen_beside_their_critical_loads() -> None:
    """Loads from below the onset to beyond the hop hold all regimes, though corners have two alone."""
    seen = Seen()
    look_around(uncertainty_set(scene_with(), {"amplitude": (1e-4, 5e-3)}), seen)
    regimes = {Regime.NO_SLIP, Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING}
    assert seen.regimes == regimes


@pytest.mark.parametrize("fast", [False, True])
def test_the_slowest_body_is_on_the_steepest_trough(fast: bool) -> None:
    """Where parts slip back, but none runs away: beside a grid of frictions and troughs."""
    scene, troughs = scene_with(amplitude=2e-3), (-0.02, 0.03)
    bands: dict[str, Any] = {"trough_angle": troughs, "static_friction": (0.7, 0.78)}
    best, _ = searched(uncertainty_set(scene, bands), fast=fast, boxes=BRIEF, seen=Seen())
    assert best.coordinates[2].tolist() == [0.0 if fast else 1.0]
    friction, trough = np.meshgrid(np.linspace(0.7, 0.78, 201), np.linspace(*troughs, 21))
    speeds = vibro.solve(replaced(scene, static_friction=friction, trough_angle=trough)).mean_velocity
    extreme = float(np.max(speeds) if fast else np.min(speeds))
    assert best.speed == pytest.approx(extreme, rel=1e-6)
