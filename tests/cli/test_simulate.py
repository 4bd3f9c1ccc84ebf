"""``vibro simulate``: its phase table, files and figure, and wrong input."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd
import pytest
from helpers.commands import Run, rows_of
from helpers.made_records import EXAMPLES

import vibro

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCENE = EXAMPLES / "safety_nut.toml"


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """Return the pictures that a run saves."""
    figures: list[Figure] = []

    def save(figure: Figure, path: Path, *_: object) -> None:
        figures.append(figure)
        path.touch()

    monkeypatch.setattr("vibro.plots.save", save)
    return figures


def table_of(name: str) -> list[dict[str, str]]:
    return rows_of(Path(name).read_text(encoding="utf-8"))


def test_the_files(run: Run) -> None:
    assert run("simulate", SCENE, "-o", "nut.csv", "-o", "nut.svg", "-q").exit_code == 0
    rows = table_of("nut.csv")
    assert len(rows) == 3 * 200 + 1 + 6
    phases = table_of("nut-phases.csv")
    assert [row["phase"] for row in phases] == ["rest", "forward slide"] * 3 + ["rest"]
    frame = vibro.simulate(vibro.read_scene(SCENE), cycles=3).to_frame()
    pd.testing.assert_frame_equal(pd.read_csv("nut-phases.csv"), frame, rtol=1e-14, check_dtype=False)
    times = [row["time_s"] for row in rows]
    assert {row["start_s"] for row in phases} <= set(times)
    content = json.loads(Path("nut.json").read_text(encoding="utf-8"))
    assert content["files"] == ["nut.csv", "nut-phases.csv", "nut.svg", "nut.json"]
    assert content["cycles"] == 3
    assert content["samples_per_cycle"] == 200
    assert content["scene"]["kinetic_friction"] == 0.57


def test_another_start(run: Run) -> None:
    start = ("start_phase=180", "start_velocity=0.02m/s")
    result = run("simulate", SCENE, "--cycles", "0.75", *start, "--json")
    assert result.exit_code == 0, result.stderr
    answer = json.loads(result.stdout)
    first = answer["phases"][0]
    assert first["phase"] == "forward slide"
    assert first["start_velocity_mm_s"] == pytest.approx(20.0)
    assert first["trough_phase_at_start_deg"] == pytest.approx(180.0)
    assert answer["phases"][-1]["end_s"] == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("args", "part", "limits"),
    [
        (("--cycles", "6"), "time [ms]", (0, 400)),
        (("--cycles", "20"), "time [ms], the last 6 of 20 drive cycles", (14e3 / 15, 20e3 / 15)),
        (("--from", "50ms", "--to", "0.1"), "time [ms], from 0.75 to 1.5 of 3 drive cycles", (50, 100)),
    ],
)
def test_the_picture_shows_the_end_or_what_is_asked_for(
    run: Run, drawn: list[Figure], args: tuple[str, ...], part: str, limits: tuple[float, float]
) -> None:
    result = run("simulate", SCENE, *args, "-o", "nut")
    assert result.exit_code == 0, result.stderr
    (figure,) = drawn
    axes = next(axes for axes in figure.axes if axes.get_xlabel().startswith("time"))
    assert axes.get_xlim() == pytest.approx(limits)
    assert axes.get_xlabel() == part
    assert figure.get_label() == "safety_nut"
    said = [line for line in result.stderr.splitlines() if line.startswith("the picture shows ")]
    assert said == ([f"the picture shows {part.removeprefix('time [ms], ')}"] if "," in part else [])


def test_a_history_has_a_cap_that_says_what_to_do(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.motion.histories.MOST_PHASES", 2000)
    irregular = ("simulate", SCENE, "-A", "5", "--restitution", "0.8", "--samples-per-cycle", "0")
    result = run(*irregular, "--cycles", "100000")
    assert result.exit_code == 2
    known = result.stderr.split("hint: ask for at most ")[1].split()[0]
    assert run(*irregular, "--cycles", known).exit_code == 0


def test_a_body_is_dropped_or_thrown(run: Run) -> None:
    thrown = ("start_height=2mm", "start_normal_velocity=-0.1m/s", "--json")
    answer = json.loads(run("simulate", SCENE, *thrown).stdout)
    assert (answer["start_height_mm"], answer["start_normal_velocity_mm_s"]) == (2, -100)
    assert answer["phases"][0]["phase"] == "flight"
    history = vibro.simulate(vibro.read_scene(SCENE), cycles=3, start_height=2e-3, start_normal_velocity=-0.1)
    assert answer["phases"][0]["end_s"] == history.phases[0].end
