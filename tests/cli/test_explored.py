"""What the explorer tells is what the commands say, and its commands and files make its maps."""

from __future__ import annotations

import json
import re
import shlex
from html import unescape
from pathlib import Path
from typing import Any

import pytest
from helpers.commands import Run, rows_of
from helpers.packed import FEEDER, GIVEN_DRIVES, state_of, table_of

from vibro.explore.answers import Answers
from vibro.explore.state import State, initial_state, read_state
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


def check_map(run: Run, answers: Answers, state: State, *scene: str) -> dict[str, Any]:
    """Type the command of a state, and read its scene file again: both make its map. Return its texts."""
    told, table = answers.point(state), table_of(answers, state)
    Path("scene.toml").write_text(told["toml"], encoding="utf-8")
    words = shlex.split(told["command"])
    assert words[: 2 + len(scene)] == ["vibro", "map", *scene]
    assert words[-2] == "-o"
    for typed in (words[1:-1], ["map", "scene.toml", "-o"]):
        made = run(*typed, "-")
        assert (made.exit_code, made.stdout) == (0, table)
    again = initial_state(request_of_call("scene.toml", {}))
    kept = {key: text for key, text in state.texts.items() if key not in NOT_IN_FILES}
    assert kept.items() <= again.texts.items()  # and so is the fingerprint of a motion
    return told


def rows_in(told: dict[str, Any]) -> set[str]:
    """Return the rows of the tables beside the map, but for that which has an error of its own."""
    rows = re.findall("<tr>(.*?)</tr>", told["tables"])
    texts = {" ".join(unescape(re.sub("<[^>]*>", " ", row)).split()) for row in rows}
    return {text for text in texts if not text.startswith("traverse time")}


def lines_of(text: str) -> set[str]:
    return {" ".join(line.split()) for line in text.splitlines()}


@pytest.mark.parametrize("name", STATES)
def test_command_and_scene_file_make_the_same_map(name: str, answers: Answers, run: Run) -> None:
    state = state_of(**STATES[name])
    check_map(run, answers, state)
    assert len(rows_of(table_of(answers, state))) == WIDTH * HEIGHT


MOVED = {"motion_scale": "1.25", "static_friction": "0.5", "gravity_m_s2": "1.62"}
STEPS = {"x": "static_friction", "y": "motion_scale", "target": "5"}
CALM = {"x_range": "5:15"}  # else bodies hop, which takes long
FULL = {"filling_kg": "1.5", "setting_percent": "40", "x": "frequency_hz", "y": "drive_angle_deg"}
PACK = {"filling_kg": "0", "natural_hz": "47.6", "setting_percent": "30", "x": "frequency_hz"}


@pytest.mark.parametrize(
    ("text", "query"),
    [
        # without steps bodies soon hop, which takes long
        *(
            (text, MOVED | (STEPS if "steps" in name else {"x_range": "5:15"}))
            for name, text in GIVEN_DRIVES.items()
        ),
        (FEEDER, FULL),
        (FEEDER, {"y": "setting_percent", **PACK}),
    ],
    ids=[*GIVEN_DRIVES, "a full machine", "another pack"],
)
def test_a_motion_or_machine_comes_with_its_scene_file(text: str, query: dict[str, str], run: Run) -> None:
    Path("given.toml").write_text(text, encoding="utf-8")
    initial = initial_state(request_of_call("given.toml", {}))
    told = check_map(run, Answers(initial), read_state(query, initial), "scene.toml")
    assert "scene.toml" in told["apart"]
    if "natural_hz" not in query:
        speed = float(json.loads(run("solve", "scene.toml", "--json").stdout)["mean_velocity_mm_s"])
        assert told["speed"] == f"{speed:.6g} mm/s"
    if query is FULL:
        assert rows_in(told) <= lines_of(run("solve", "scene.toml", "--all").stdout)


@pytest.mark.parametrize(
    "query", [{"restitution": "0.2", "amplitude_mm": "3", "frequency_hz": "30"}, {"drive": "harmonics"}]
)
def test_the_operating_point_is_told_as_solve_does(query: dict[str, str], answers: Answers, run: Run) -> None:
    state = state_of(**query)
    told = answers.point(state)
    json.dumps(told, allow_nan=False)
    options = [f"{name}={value!r}" for name, value in state.point.fixed.items()]
    assert len(rows_in(told)) > 3
    assert rows_in(told) <= lines_of(run("solve", *options, "--all").stdout)
    assert told["state"] == state.texts
