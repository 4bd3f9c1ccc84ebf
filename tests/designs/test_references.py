"""Every row of the reference table of designs, within its tolerance."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.boxed import ROWS, friction_of, question_of

import vibro
from vibro.designs.optima import LineOptimiser
from vibro.designs.rows import find

KINDS = {"amplitude": 4, "range": 4, "window": 2, "fastest": 4, "gentlest": 1, "yield": 1}


def of(*kinds: str) -> pytest.MarkDecorator:
    rows = [row for row in ROWS if row["kind"] in kinds]
    return pytest.mark.parametrize("row", rows, ids=[row["id"] for row in rows])


def scene_of(row: dict[str, Any], **values: float) -> vibro.Scene:
    """Read the setting of a row; frictions that have bands are taken from their upper ends."""
    static = row["mu_s"][1] if isinstance(row["mu_s"], list) else row["mu_s"]
    kinetic = row.get("mu_d", static)
    fields = {
        "amplitude": row.get("amplitude_mm", 1.0) / 1e3,
        "frequency": row["frequency_hz"],
        "drive_angle": math.radians(row["drive_angle_deg"]),
        "trough_angle": math.radians(row["trough_angle_deg"]),
        "static_friction": static,
        "kinetic_friction": kinetic[1] if isinstance(kinetic, list) else kinetic,
    }
    return vibro.Scene(**(fields | values))


def test_no_row_is_left_out() -> None:
    kinds = [row["kind"] for row in ROWS]
    assert {kind: kinds.count(kind) for kind in set(kinds)} == KINDS


@of("amplitude", "window")
def test_amplitudes(row: dict[str, Any]) -> None:
    answer = row["answer"]
    if row["kind"] == "amplitude":
        bands: dict[str, Any] = {}
        expected = answer["feasible_mm"]
    else:
        bands, expected = friction_of(row), []
        if answer["feasible"]:
            expected = [[*answer["amplitude_mm"], answer["lower_set_by"], answer["upper_set_by"]]]
    found = vibro.feasible_amplitudes(
        scene_of(row), row["target_mm_s"] / 1e3, highest_regime=row.get("regime", "back-slip"), **bands
    )
    assert [i[2:] for i in found] == [tuple(e[2:]) for e in expected]
    ends = [1e3 * end for i in found for end in i[:2]]
    assert ends == pytest.approx([end for e in expected for end in e[:2]], rel=row["rtol"])
    if row["kind"] == "amplitude":
        assert ends[0] == pytest.approx(answer["smallest_mm"], rel=row["rtol"])


@of("range")
def test_ranges(row: dict[str, Any]) -> None:
    answer, scene = row["answer"], scene_of(row)
    bands = friction_of(row)
    for name in ("amplitude", "frequency"):
        value, drift = float(getattr(scene, name)), row[f"tol_{name}_percent"] / 100
        bands[name] = (value * (1 - drift), value * (1 + drift))
    for name in ("drive_angle", "trough_angle"):
        middle, drift = row[f"{name}_deg"], row[f"tol_{name}_deg"]
        bands[name] = (math.radians(middle - drift), math.radians(middle + drift))
    found = vibro.guarantee(scene, **bands)
    assert 1e3 * found.found_min == pytest.approx(answer["speed_min_mm_s"], rel=row["rtol"])
    assert 1e3 * found.found_max == pytest.approx(answer["speed_max_mm_s"], rel=row["rtol"])
    assert sorted(regime.label for regime in found.regimes) == answer["regimes"]


@of("fastest", "gentlest")
def test_designs(row: dict[str, Any]) -> None:
    """The optimum and what limits it, printed with many digits."""
    answer, question = row["answer"], question_of(row)
    finder = find(question, {}, 9, until="gentlest")
    gentlest, fastest = finder.row("gentlest"), finder.row("fastest")
    if row["kind"] == "gentlest":
        assert gentlest.acceleration_g == pytest.approx(answer["acceleration_g"], rel=row["rtol"])
        assert (gentlest.speed_min_mm_s or 0.0) >= row["target_mm_s"]
        for name in ("amplitude_mm", "frequency_hz", "drive_angle_deg"):
            assert getattr(gentlest, name) == pytest.approx(answer[name], rel=row["rtol_setting"]), name
        return
    speed = fastest.speed_min_mm_s or 0.0
    assert speed == pytest.approx(answer["speed_guaranteed_mm_s"], rel=row["rtol"])
    assert fastest.acceleration_g == pytest.approx(answer["load"], rel=row["rtol_setting"])
    assert (speed >= row["target_mm_s"]) is answer["feasible"]
    if "set_by" in answer:  # two limits may meet at an optimum
        load, angle = fastest.acceleration_g or 0.0, math.radians(fastest.drive_angle_deg or 0.0)
        caps = LineOptimiser(question)._caps(np.array([[angle]]))
        reached = {name for name, cap in caps.items() if float(cap[0, 0]) <= load * (1 + 1e-6)}
        assert answer["set_by"] in reached
    if not answer["feasible"]:  # the same load at a lower frequency would do, exactly
        assert fastest.frequency_needed_hz == pytest.approx(answer["frequency_needed_hz"], rel=row["rtol"])
        assert fastest.amplitude_needed_mm == pytest.approx(answer["amplitude_then_mm"], rel=3 * row["rtol"])


@of("yield")
def test_yields(row: dict[str, Any]) -> None:
    share, error = vibro.yield_share(
        scene_of(row), row["target_mm_s"] / 1e3, highest_regime=row["regime"], **friction_of(row)
    )
    assert 0 < error <= 3e-4
    assert abs(share - row["answer"]["share"]) <= 4 * error
