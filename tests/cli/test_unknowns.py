"""What ``vibro solve`` finds where something is left out: given back, it gives what was asked for."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from helpers.made_records import EXAMPLES

if TYPE_CHECKING:
    from helpers.commands import Run

LINE = ("-A", "1.1", "-f", "25", "-a", "20")
FEEDER = (str(EXAMPLES / "linear_feeder.toml"), "--pack", "6 leaves")
FULL = (*FEEDER, "setting=35", "filling=1")


def answer(run: Run, *arguments: Any) -> dict[str, Any]:
    result = run("solve", *arguments, "--json")
    assert result.exit_code in (0, 4), result.stderr
    found: dict[str, Any] = json.loads(result.stdout)
    assert found.get("met", True) == (result.exit_code == 0)
    return found


@pytest.mark.parametrize(
    ("scene", "target", "count", "tolerance"),
    [
        (LINE, ("--time", "3.9s", "-L", "300"), 2, 1e-12),
        (LINE, ("--speed", "70", "--mu-s", "0.7"), 1, 1e-12),
        (("--stroke", "2.2", *LINE[2:]), ("--speed", "70"), 2, 1e-12),
        (("along=2", "normal=0.3", "phase=-60", "-f", "25"), ("--speed", "120"), 1, 1e-12),
        (("along=1", "along_2=0.3", "along_phase_2=-90", "-f", "9"), ("--speed", "10"), 2, 1e-12),
        (("-A", "2", "-f", "25", "-a", "25"), ("--speed", "190", "--hopping"), 1, 1e-12),
        (FULL, ("--time", "30", "--mu-ratio", "0.7"), 2, 1e-9),
    ],
)
def test_frictions_that_are_found_give_the_speed(
    run: Run, scene: tuple[str, ...], target: tuple[str, ...], count: int, tolerance: float
) -> None:
    found = answer(run, *scene, *target)
    assert len(found["frictions"]) == count
    for one in found["frictions"]:
        static, kinetic = one["static_friction_low"], one["kinetic_friction_low"]
        cycle = answer(run, *scene, "--mu-s", repr(static), "--mu-d", repr(kinetic))
        assert cycle["mean_velocity_mm_s"] == pytest.approx(found["speed_mm_s"], rel=tolerance)
        assert cycle["regime"] == one["regime"]
        if found["friction_ratio"] is None:
            assert static == float(target[target.index("--mu-s") + 1])
        else:
            assert kinetic / static == pytest.approx(found["friction_ratio"], rel=1e-12)


def test_the_fastest_and_the_slowest_friction_are_told_where_none_gives_the_speed(run: Run) -> None:
    found = answer(run, *LINE, "--speed", "6m/min")
    assert not found["met"]
    most = found["fastest"]["mean_velocity_low_mm_s"]
    assert found["slowest"]["mean_velocity_low_mm_s"] < most < 100.0
    assert answer(run, *LINE, "--speed", repr(most * (1.0 - 1e-9)))["met"]
    assert not answer(run, *LINE, "--speed", repr(most * (1.0 + 1e-9)))["met"]


@pytest.mark.parametrize(
    "scene",
    [
        LINE,
        ("along=2", "normal=0.3", "phase=-60", "-f", "25"),
        ("-A", "0.4", *LINE[2:], "--trough-angle", "-10"),
        ("-A", "0.2", *LINE[2:], "--trough-angle", "10"),
        (*FEEDER, "setting=30"),
    ],
)
def test_nothing_slips_from_the_least_friction_on(run: Run, scene: tuple[str, ...], tmp_path: Path) -> None:
    given = scene
    if scene[0] == FEEDER[0]:
        scene_file = tmp_path / "feeder.toml"
        scene_file.write_text(re.sub(".*_friction.*\n", "", Path(scene[0]).read_text("utf-8")), "utf-8")
        given = (str(scene_file), *scene[1:])
    found = answer(run, *given)
    least = found["least_static_friction"]
    assert least == max(found["least_static_friction_forward"], found["least_static_friction_back"])
    regimes = [
        answer(run, *scene, "--mu-s", repr(least * share), "--mu-ratio", "0.8")["regime"]
        for share in (1.0 - 1e-9, 1.0)
    ]
    assert regimes == [found["regime_below"], "no-slip"]


@pytest.mark.parametrize(
    ("known", "option", "column"),
    [(("-f", "25"), "-A", "amplitude_mm"), (("-A", "1"), "-f", "frequency_hz")],
)
def test_motions_begin_where_it_is_said(run: Run, known: tuple[str, ...], option: str, column: str) -> None:
    scene = (*known, "-a", "20", "--mu-s", "0.5", "--mu-d", "0.4")
    begins = {one["motion"]: one[column] for one in answer(run, *scene)["beginnings"]}
    assert [*begins] == ["forward slip", "back slip", "continuous sliding", "hopping"]
    regimes = {"forward slip": "forward-slip", "back slip": "back-slip", "hopping": "hopping"}
    for motion, regime in regimes.items():
        below, above = (
            answer(run, *scene, option, repr(begins[motion] * share))["regime"]
            for share in (1.0 - 1e-9, 1.0 + 1e-9)
        )
        assert above == regime != below, motion
