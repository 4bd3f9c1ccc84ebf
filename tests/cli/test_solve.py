"""``vibro solve``: the report, its JSON, and every way in which a scene can be wrong."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.commands import ELLIPSE, NUT, Run, other, rows_of

from vibro import Scene, Status, SteadyCycle, solve
from vibro.sweeps.columns import columns_of
from vibro.sweeps.derived import WITH_ACCELERATION, WITH_EXPONENT, WITH_MULTIPLIER, WITH_STROKE


def test_json_has_the_keys_of_a_table(run: Run) -> None:
    result = run("solve", *NUT, "--json")
    assert result.exit_code == 0
    assert result.stderr == ""
    answer = json.loads(result.stdout)
    extra = (WITH_STROKE, WITH_ACCELERATION, WITH_EXPONENT, WITH_MULTIPLIER)
    columns = [column.name for column in columns_of((), *extra, made_with=["restitution"])]
    assert list(answer) == [*columns, "over_restitution", "beginnings", "sensitivities", "phases"]
    assert answer["over_restitution"] is None  # no part hops
    assert answer["mean_velocity_mm_s"] == pytest.approx(16.263456166287, rel=1e-13)
    assert answer["regime"] == "forward-slip"
    assert answer["pattern"] == "F_"
    assert answer["largest_multiplier"] == 0
    assert answer["status"] == "ok"
    assert answer["traverse_time_s"] is None
    assert answer["amplitude_mm"] == 1


def test_an_unresolved_scene_is_exit_code_3(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def doubtful(scene: Scene, **how: Any) -> SteadyCycle:
        return dataclasses.replace(solve(scene, **how), status=np.array(Status.UNRESOLVED, np.int8))

    monkeypatch.setattr("vibro.sweeps.grid.solve", doubtful)
    assert run("solve", *NUT, "--json").exit_code == 3


def test_seven_lines_tell_what_a_part_does(run: Run) -> None:
    text = run("solve", *NUT, "-L", "600").stdout
    assert text.splitlines() == [
        "forward-slip   16.26 mm/s (0.976 m/min), 1.084 mm a cycle",
        "traverse time  36.89 s over 600 mm (36.8904 s from rest)",
        "peak speed     60.15 mm/s",
        "throw number   0.310 (the part hops above 1)",
        "begins         amplitude  frequency",
        "back slip        1.19 mm    16.4 Hz",
        "hopping          3.23 mm    27.0 Hz",
    ]
    assert "sensitivities" not in text
    assert "A little more of each input" in run("solve", *NUT, "-L", "600", "--all").stdout


def test_lists_and_files_stand_below_each_other(run: Run) -> None:
    for name, size in (("one", 1), ("two", 4)):
        scene = f"amplitude_mm = {size}\nfrequency_hz = 15\ndrive_angle_deg = 20\nstatic_friction = 0.74\n"
        Path(f"{name}.toml").write_text(f"[scene]\n{scene}kinetic_friction = 0.57\n", encoding="utf-8")
    listed = run("solve", *other(NUT, "-A", "1, 4"), "--json")
    cells = json.loads(listed.stdout)
    assert [cell["regime"] for cell in cells] == ["forward-slip", "hopping"]
    for cell in cells:
        alone = json.loads(run("solve", *other(NUT, "-A", str(cell["amplitude_mm"])), "--json").stdout)
        assert cell == {name: alone[name] for name in cell}
    files = json.loads(run("solve", "one.toml", "two.toml", "--json", "-o", "both.csv").stdout)
    assert files == [{"scene": name, **cell} for name, cell in zip(("one", "two"), cells, strict=True)]
    rows = rows_of(Path("both.csv").read_text(encoding="utf-8"))
    assert [row["scene"] for row in rows] == ["one", "two"]
    assert [float(row["mean_velocity_mm_s"]) for row in rows] == [c["mean_velocity_mm_s"] for c in cells]
    text = run("solve", "one.toml", "two.toml").stdout.splitlines()
    heads = [" ".join(line.split()[:2]) for line in text if line[:1].isalpha()]
    assert "frequency 15 Hz" in run("solve", "one.toml", "two.toml", "--all").stdout
    assert heads[:3] == ["scene regime", "one forward-slip", "two hopping"]
    assert "vibro map" in run("solve", *other(NUT, "-A", "1:3:500")).stderr
    longer_than_a_name = ",".join(f"{0.001 * i:.3f}" for i in range(1, 61))
    assert "60 scenes: at most 50" in run("solve", *ELLIPSE[1:], f"along={longer_than_a_name}").stderr


def test_several_motions_are_noted_below_lists_and_what_is_found(run: Run) -> None:
    drive = ("-f", "15", "-a", "40.3")
    pair = (*drive, "--mu-s", ".458", "--mu-d", ".043")
    note = "several motions exist {}; speeds are those of a part released at the start of a cycle: solve"
    told = {
        "in 2 of 3 scenes": ("-A", "0.5,1.4,1.65", *pair),
        "at some of these amplitudes": ("--speed", "100", *pair),
        "at some of these frictions": ("-A", "1.65", "--speed", "107", *drive, "--mu-s", ".458"),
    }
    for where, args in told.items():
        found = run("solve", *args)
        assert found.exit_code == 0
        assert found.stdout.count(note.format(where)) == 1
    for one in (("-A", "1,2", *NUT[2:]), ("--speed", "20", *NUT[2:]), ("--speed", "16.3", *NUT[:-4])):
        assert "several motions" not in run("solve", *one).stdout
