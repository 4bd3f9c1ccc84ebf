"""What the explorer tells is what the commands say, and its commands and files make its maps."""

from __future__ import annotations

import json
import re
import shlex
from html import unescape
from pathlib import Path

import pytest
from helpers.commands import Run, rows_of
from helpers.packed import FEEDER, GIVEN_DRIVES, state_of, table_of

from vibro.explore.answers import Answers
from vibro.explore.state import initial_state, read_state
from vibro.sweeps.whole import request_of_call

WIDTH, HEIGHT = 24, 20
NOT_IN_FILES = ("view", "target", "follow", "x", "y", "x_range", "y_range")
STATES = {
    "nut": {},
    "log": {"x_range": "5:60:log", "restitution": "0", "trough_angle_deg": "-3.3", "trough_length_mm": ""},
    "frictions": {"x": "static_friction", "y": "drive_angle_deg", "y_range": "0:60"},
    "ratio": {"x": "friction_ratio", "y": "amplitude_mm", "gravity_m_s2": "1.62"},
    "harmonics": {"drive": "harmonics", "normal_amplitude_2_mm": "0.1", "normal_phase_2_deg": "-30"},
}


@pytest.fixture(autouse=True)
def _small_maps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make maps of a hundredth of the cells: each is solved three times, and compared cell by cell."""
    for module in ("state", "points"):
        monkeypatch.setattr(f"vibro.explore.{module}.WIDTH", WIDTH)
        monkeypatch.setattr(f"vibro.explore.{module}.HEIGHT", HEIGHT)


@pytest.fixture
def answers() -> Answers:
    return Answers(initial_state())


@pytest.mark.parametrize("name", STATES)
def test_command_and_scene_file_make_the_same_map(
    name: str, answers: Answers, run: Run, tmp_path: Path
) -> None:
    state = state_of(**STATES[name])
    told = answers.point(state)
    table = table_of(answers, state)
    assert len(rows_of(table)) == WIDTH * HEIGHT
    words = shlex.split(told["command"])
    assert words[:2] == ["vibro", "map"]
    assert words[-2:] == ["-o", "out/map"]
    typed = run(*words[1:-1], "-")
    assert typed.exit_code == 0
    assert typed.stdout == table
    file = tmp_path / "scene.toml"
    file.write_text(told["toml"], encoding="utf-8")
    stored = run("map", str(file), "-o", "-")
    assert stored.exit_code == 0
    assert stored.stdout == table
    explored = initial_state(request_of_call(file, {}))
    kept = {key: text for key, text in state.texts.items() if key not in NOT_IN_FILES}
    assert kept.items() <= explored.texts.items()


@pytest.mark.parametrize("name", GIVEN_DRIVES)
def test_a_given_motion_comes_with_its_scene_file(
    name: str, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    given = tmp_path / "given.toml"
    given.write_text(GIVEN_DRIVES[name], encoding="utf-8")
    initial = initial_state(request_of_call(given, {}))
    moved = {"motion_scale": "1.25", "static_friction": "0.5", "gravity_m_s2": "1.62"}
    others = {"x": "static_friction", "y": "motion_scale", "target": "5"}
    query = others if "steps" in name else {"x_range": "5:15"}  # else bodies hop, which takes long
    state = read_state({**moved, **query}, initial)
    answers = Answers(initial)
    told, table = answers.point(state), table_of(answers, state)
    (tmp_path / "scene.toml").write_text(told["toml"], encoding="utf-8")
    assert "scene.toml" in told["apart"]
    words = shlex.split(told["command"])
    assert words[:3] == ["vibro", "map", "scene.toml"]
    typed = run(*words[1:-1], "-")
    assert typed.exit_code == 0
    assert typed.stdout == table
    speed = float(json.loads(run("solve", "scene.toml", "--json").stdout)["mean_velocity_mm_s"])
    assert told["speed"] == f"{speed:.6g} mm/s"
    again = initial_state(request_of_call(tmp_path / "scene.toml", {}))
    kept = {key: text for key, text in state.texts.items() if key not in NOT_IN_FILES}
    assert kept.items() <= again.texts.items()  # and so is the fingerprint of the motion


@pytest.mark.parametrize(
    "query",
    [
        {"filling_kg": "1.5", "setting_percent": "40", "x": "frequency_hz", "y": "drive_angle_deg"},
        {"filling_kg": "0", "natural_hz": "47.6", "setting_percent": "30", "x": "frequency_hz"},
    ],
    ids=["full", "another pack"],
)
def test_a_machine_comes_with_its_scene_file(
    query: dict[str, str], run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "feeder.toml").write_text(FEEDER, encoding="utf-8")
    initial = initial_state(request_of_call(tmp_path / "feeder.toml", {}))
    state = read_state({"y": "setting_percent", **query}, initial)
    answers = Answers(initial)
    told, table = answers.point(state), table_of(answers, state)
    (tmp_path / "scene.toml").write_text(told["toml"], encoding="utf-8")
    assert "scene.toml" in told["apart"]
    words = shlex.split(told["command"])
    assert words[:3] == ["vibro", "map", "scene.toml"]
    typed = run(*words[1:-1], "-")
    assert typed.exit_code == 0
    assert typed.stdout == table
    again = initial_state(request_of_call(tmp_path / "scene.toml", {}))
    kept = {key: text for key, text in state.texts.items() if key not in NOT_IN_FILES}
    assert kept.items() <= again.texts.items()
    if "natural_hz" not in query:
        solved = run("solve", "scene.toml", "--json")
        speed = float(json.loads(solved.stdout)["mean_velocity_mm_s"])
        assert told["speed"] == f"{speed:.6g} mm/s"
        rows = re.findall("<tr>(.*?)</tr>", told["tables"])
        texts = [" ".join(unescape(re.sub("<[^>]*>", " ", row)).split()) for row in rows]
        lines = [" ".join(line.split()) for line in run("solve", "scene.toml", "--all").stdout.splitlines()]
        assert {text for text in texts if not text.startswith("traverse time")} <= {*lines}


def test_the_operating_point_is_told_as_solve_does(answers: Answers, run: Run) -> None:
    cases = {
        "line": {"restitution": "0.2", "amplitude_mm": "3", "frequency_hz": "30"},
        "harmonics": {"drive": "harmonics"},
    }
    for query in cases.values():
        state = state_of(**query)
        told = answers.point(state)
        json.dumps(told, allow_nan=False)
        options = [f"{name}={value!r}" for name, value in state.point.fixed.items()]
        said = run("solve", *options, "--all").stdout
        lines = [" ".join(line.split()) for line in said.splitlines()]
        rows = re.findall("<tr>(.*?)</tr>", told["tables"])
        texts = [" ".join(unescape(re.sub("<[^>]*>", " ", row)).split()) for row in rows]
        assert len(texts) > 4
        assert {text for text in texts if not text.startswith("traverse time")} <= {*lines}
        assert told["state"] == state.texts
