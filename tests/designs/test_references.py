"""Every row of the reference table of designs, within its tolerance."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.boxed import REGIMES, ROWS, friction_of, question_of

import vibro
from vibro.designs.guarantees import guarantee_of
from vibro.designs.optima import LineOptimiser, Optimum
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


def guaranteed(row: dict[str, Any], found: Optimum | None) -> float:
    """Recompute the guarantee of a setting that was found, which has to keep to the regime [mm/s]."""
    assert found is not None
    result = guarantee_of(question_of(row).box(found.setting))
    assert max(result.regimes) <= REGIMES[row["regime"]]
    assert found.speed == pytest.approx(result.found_min, rel=1e-9)
    return 1e3 * result.found_min


def turned(row: dict[str, Any], found: Optimum) -> dict[str, Any]:
    """Return amplitude, frequency and drive angle of a setting."""
    return question_of(row).space.turned(found.setting)


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


@of("fastest")
def test_fastest(row: dict[str, Any]) -> None:
    answer, question = row["answer"], question_of(row)
    found = LineOptimiser(question).fastest()
    speed = guaranteed(row, found)
    assert found is not None
    assert speed == pytest.approx(answer["speed_guaranteed_mm_s"], rel=row["rtol"])
    load = float(question.load(found.setting))
    assert load == pytest.approx(answer["load"], rel=row["rtol_setting"])
    assert (speed >= row["target_mm_s"]) is answer["feasible"]
    if "set_by" in answer:  # two limits may meet at an optimum
        caps = LineOptimiser(question)._caps(np.array([[turned(row, found)["drive_angle"]]]))
        reached = {name for name, cap in caps.items() if float(cap[0, 0]) <= load * (1 + 1e-6)}
        assert answer["set_by"] in reached
        assert load <= min(float(cap[0, 0]) for cap in caps.values()) * (1 + 1e-12)
    if not answer["feasible"]:  # the same load at a lower frequency would do, exactly
        share = speed / row["target_mm_s"]
        assert found.setting.frequency * share == pytest.approx(
            answer["frequency_needed_hz"], rel=row["rtol"]
        )
        needed = 1e3 * turned(row, found)["amplitude"] / share**2
        assert needed == pytest.approx(answer["amplitude_then_mm"], rel=3 * row["rtol"])


@of("gentlest")
def test_gentlest(row: dict[str, Any]) -> None:
    answer, question = row["answer"], question_of(row)
    found = LineOptimiser(question).least_acceleration(row["target_mm_s"] / 1e3)
    assert guaranteed(row, found) >= row["target_mm_s"] * (1 - 1e-12)
    assert found is not None
    assert float(question.load(found.setting)) == pytest.approx(answer["acceleration_g"], rel=row["rtol"])
    amplitude, frequency, angle = turned(row, found).values()
    found_setting = (1e3 * amplitude, frequency, math.degrees(angle))
    names = ("amplitude_mm", "frequency_hz", "drive_angle_deg")
    assert found_setting == pytest.approx([answer[name] for name in names], rel=row["rtol_setting"])


@of("fastest", "gentlest")
def test_designs_that_are_printed_with_many_digits(row: dict[str, Any]) -> None:
    answer, question = row["answer"], question_of(row)
    finder = find(question, {}, 9, until="gentlest")
    gentlest, fastest = finder.row("gentlest"), finder.row("fastest")
    if row["kind"] == "gentlest":
        assert gentlest.acceleration_g == pytest.approx(answer["acceleration_g"], rel=row["rtol"])
        assert gentlest.speed_min_mm_s is not None
        assert gentlest.speed_min_mm_s >= row["target_mm_s"]
        return
    assert fastest.speed_min_mm_s is not None
    assert fastest.speed_min_mm_s == pytest.approx(answer["speed_guaranteed_mm_s"], rel=row["rtol"])
    assert (fastest.speed_min_mm_s >= row["target_mm_s"]) is answer["feasible"]
    if not answer["feasible"]:
        assert fastest.frequency_needed_hz == pytest.approx(answer["frequency_needed_hz"], rel=row["rtol"])
        assert fastest.amplitude_needed_mm == pytest.approx(answer["amplitude_then_mm"], rel=3 * row["rtol"])


@of("yield")
def test_yields(row: dict[str, Any]) -> None:
    share, error = vibro.yield_share(
        scene_of(row), row["target_mm_s"] / 1e3, highest_regime=row["regime"], **friction_of(row)
    )
    assert 0 < error <= 3e-4
    assert abs(share - row["answer"]["share"]) <= 4 * error
