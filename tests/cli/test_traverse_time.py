"""``vibro traverse-time``: one scene, sweeps, and bodies that never arrive."""

from __future__ import annotations

import dataclasses
import json
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.commands import NUT, NUT_FILE, Run, other, rows_of

from vibro.core.codes import Status
from vibro.steady import solve

if TYPE_CHECKING:
    from vibro.results.steady import SteadyCycle

SCENE = NUT_FILE + "trough_length_mm = 600\n\n[map]\namplitude_mm = [0.5, 1, 1.5]\n"


def test_a_body_that_is_conveyed_backwards_never_arrives(run: Run) -> None:
    args = ("-A", "0.9", "-f", "15", "-a", "20", "--mu-s", "0.3", "--mu-d", "0.29", "--trough-angle", "15")
    answer = json.loads(run("traverse-time", *args, "-L", "600", "--json").stdout)
    assert answer["mean_velocity_mm_s"] < 0
    assert answer["traverse_time_s"] is None
    assert answer["strokes"] is None


def test_the_scene_files_axes_count_only_with_sweep(run: Run) -> None:
    Path("nut.toml").write_text(SCENE, encoding="utf-8")
    single = json.loads(run("traverse-time", "nut.toml", "--json").stdout)
    assert single["traverse_time_s"] == pytest.approx(36.8925, abs=1e-4)
    swept = run("traverse-time", "nut.toml", "--sweep", "-o", "./")
    assert swept.exit_code == 0
    assert swept.stdout == ""
    rows = rows_of(Path("nut-traverse-time.csv").read_text(encoding="utf-8"))
    assert [row["amplitude_mm"] for row in rows] == ["0.5", "1", "1.5"]
    assert [bool(row["traverse_time_s"]) for row in rows] == [False, True, True]
    assert float(rows[1]["strokes"]) == pytest.approx(553.388, abs=1e-3)
    assert sorted(path.name for path in Path().iterdir()) == [
        "nut-traverse-time.csv", "nut-traverse-time.json", "nut.toml",
    ]  # fmt: skip


def test_a_sweep_is_printed_where_no_file_is_asked_for(run: Run) -> None:
    args = ("traverse-time", *other(NUT, "-A", "0.5,1,4", "-f", "1, 15"), "-L", "600")
    table, content = run(*args), run(*args, "--json")
    assert table.exit_code == content.exit_code == 0
    assert table.stdout == run(*args, "-o", "-").stdout
    rows, cells = rows_of(table.stdout), json.loads(content.stdout)
    assert len(cells) == len(rows) == 6
    for row, cell in zip(rows, cells, strict=True):
        assert list(cell) == list(row)
        for name, value in cell.items():
            assert row[name] == ("" if value is None else str(value).removesuffix(".0"))
    assert list(Path().iterdir()) == []


def test_which_way_an_uncertain_mean_goes_is_left_open(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def backwards(*args: Any, error: float, **how: Any) -> SteadyCycle:
        cycle = solve(*args, **how)
        speed = -np.asarray(cycle.mean_velocity)
        return dataclasses.replace(
            cycle,
            status=np.array(Status.AVERAGED),
            mean_velocity=speed,
            mean_velocity_error=np.abs(speed) * error,
        )

    for error, answer in ((0.5, "unknown"), (0.1, "never")):
        monkeypatch.setattr("vibro.sweeps.grid.solve", partial(backwards, error=error))
        assert f"traverse time  {answer}" in run("traverse-time", *other(NUT, "-A", "4"), "-L", "600").stdout


def test_a_sweep_has_exact_arrivals_on_request(run: Run) -> None:
    sweep = ("traverse-time", *other(NUT, "-A", "0.5,1,4"), "-L", "600", "-o", "-")
    assert "arrival_time_s" not in rows_of(run(*sweep).stdout)[0]
    rows = rows_of(run(*sweep, "--exact").stdout)
    names = list(rows[0])
    assert names.index("arrival_time_s") < names.index("model")
    assert rows[0]["arrival_time_s"] == ""
    for row, amplitude in zip(rows[1:], ("1", "4"), strict=True):
        alone = json.loads(run("traverse-time", *other(NUT, "-A", amplitude), "-L", "600", "--json").stdout)
        assert float(row["arrival_time_s"]) == pytest.approx(alone["arrival_time_s"], rel=1e-13)
