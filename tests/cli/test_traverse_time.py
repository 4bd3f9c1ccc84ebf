"""``vibro traverse-time``: one scene, sweeps, and bodies that never arrive."""

from __future__ import annotations

import dataclasses
import json
import re
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.commands import NUT, Run, rows_of

from vibro.core.codes import Status
from vibro.results import SteadyCycle
from vibro.steady import solve

SCENE = """
[scene]
amplitude_mm = 1
frequency_hz = 15
drive_angle_deg = 20
static_friction = 0.74
kinetic_friction = 0.57
trough_length_mm = 600

[map]
amplitude_mm = [0.5, 1, 1.5]
"""


def test_one_scene(run: Run) -> None:
    result = run("traverse-time", *NUT, "-L", "600")
    assert result.exit_code == 0
    lines = [" ".join(line.split()) for line in result.stdout.splitlines()]
    assert lines[0] == "traverse time 36.8925 s over 600 mm"
    assert "mean speed 16.2635 mm/s" in lines
    assert "regime forward-slip, pattern F_" in lines
    assert "strokes 553.388" in lines


def test_json_has_the_strokes_before_the_model(run: Run) -> None:
    answer = json.loads(run("traverse-time", *NUT, "-L", "600", "--json").stdout)
    keys = list(answer)
    assert keys[keys.index("model") - 1] == "strokes"
    assert answer["strokes"] == pytest.approx(15 * answer["traverse_time_s"], rel=1e-15)


def test_a_body_at_rest_says_by_how_much_amplitude_or_frequency_must_grow(run: Run) -> None:
    result = run("traverse-time", *NUT, "-A", "0.5", "-L", "600")
    assert result.exit_code == 0
    advice = result.stdout.splitlines()[0]
    found = re.search(
        r"the amplitude above ([\d.]+) mm \((.*) x\) or with the frequency above ([\d.]+) Hz", advice
    )
    assert found is not None
    amplitude, factor, frequency = map(float, found.groups())
    assert factor == pytest.approx(amplitude / 0.5, rel=1e-3)
    for option, limit, other in (("-A", amplitude, ()), ("-f", frequency, ("-A", "0.5"))):
        for nearby, rests in ((limit * (1 - 1e-5), True), (limit * (1 + 1e-5), False)):
            text = run("traverse-time", *NUT, *other, option, repr(nearby), "-L", "600").stdout
            assert ("the body rests" in text) == rests


def test_a_body_that_hops_before_it_slips_is_told_so(run: Run) -> None:
    args = ("-A", "0.5", "-f", "15", "-a", "80", "--mu-s", "0.9", "--mu-d", "0.9", "-L", "600")
    advice = run("traverse-time", *args).stdout.splitlines()[0]
    assert re.search(r"never: the body rests; (forward slip|hopping) begins with the amplitude above", advice)


def test_a_body_that_is_conveyed_backwards_is_told_so(run: Run) -> None:
    args = ("-A", "0.9", "-f", "15", "-a", "20", "--mu-s", "0.3", "--mu-d", "0.29", "--trough-angle", "15")
    result = run("traverse-time", *args, "-L", "600")
    assert result.exit_code == 0
    first = result.stdout.splitlines()[0]
    assert re.search(r"never: the body is conveyed backwards at [\d.]+ mm/s", first)
    answer = json.loads(run("traverse-time", *args, "-L", "600", "--json").stdout)
    assert answer["mean_velocity_mm_s"] < 0
    assert answer["traverse_time_s"] is None
    assert answer["strokes"] is None


def test_a_body_that_slides_to_and_fro_is_told_so(run: Run) -> None:
    args = ("-A", "1", "-f", "15", "-a", "0", "--mu-s", "0.2", "--mu-d", "0.2", "-L", "600")
    assert "never: the body slides to and fro" in run("traverse-time", *args).stdout


def test_a_runaway_says_why_its_time_is_unknown(run: Run) -> None:
    args = (
        "-A",
        "0.1",
        "-f",
        "15",
        "-a",
        "0",
        "--mu-s",
        "0.2",
        "--mu-d",
        "0.2",
        "--trough-angle",
        "-60",
        "-L",
        "1",
    )
    result = run("traverse-time", *args)
    assert "none at a mean speed: the body runs forwards, down the trough" in result.stdout


STEEP = ("-A", "0.2", "-f", "50", "-a", "25", "--mu-s", "0.3", "--mu-d", "0.2")


def test_a_body_that_runs_down_the_trough_has_an_arrival_and_no_mean_speed(run: Run) -> None:
    downhill = (*STEEP, "--trough-angle=-30")
    told = dict(
        re.split(r"  +", line, maxsplit=1)
        for line in run("traverse-time", *downhill, "-L", "300").stdout.splitlines()
    )
    assert told["traverse time"].startswith("none at a mean speed: the body runs forwards, down the trough")
    assert told["exactly"].startswith("0.4135")
    assert told["why"] == "the body never settles: it gains speed every cycle, forwards, down the trough"
    assert told["mean speed"] == "none: it gains speed every cycle, forwards, down the trough"
    assert told["mean speed"] in run("solve", *downhill).stdout


def test_a_body_that_runs_backwards_is_told_so(run: Run) -> None:
    uphill = (*STEEP, "--trough-angle", "30")
    text = run("traverse-time", *uphill, "-L", "300").stdout
    assert text.startswith("traverse time  none at a mean speed: the body runs backwards, down the track")
    assert "exactly" not in text
    assert "none: it gains speed every cycle, backwards" in text
    near = run("traverse-time", *uphill, "-L", "0.01").stdout.splitlines()
    assert near[2].endswith("the body gets so far before it turns and runs backwards, down the track")


def test_the_length_is_needed(run: Run) -> None:
    result = run("traverse-time", *NUT)
    assert result.exit_code == 2
    error, hint = result.stderr.splitlines()
    assert error == "error: missing: trough length (-L)"
    assert run(*hint.removeprefix("hint: for example: vibro ").split()).exit_code == 0


def test_the_scene_files_axes_count_only_with_sweep(run: Run) -> None:
    Path("nut.toml").write_text(SCENE, encoding="utf-8")
    single = run("traverse-time", "nut.toml")
    assert single.stdout.startswith("traverse time  36.8925 s")
    swept = run("traverse-time", "nut.toml", "--sweep", "-o", "./")
    assert swept.exit_code == 0
    assert swept.stdout == ""
    assert "amplitude: 3 values, 0.5, 1, 1.5 mm" in swept.stderr
    rows = rows_of(Path("nut-traverse-time.csv").read_text(encoding="utf-8"))
    assert [row["amplitude_mm"] for row in rows] == ["0.5", "1", "1.5"]
    assert [bool(row["traverse_time_s"]) for row in rows] == [False, True, True]
    assert float(rows[1]["strokes"]) == pytest.approx(553.388, abs=1e-3)
    assert sorted(path.name for path in Path().iterdir()) == [
        "nut-traverse-time.csv", "nut-traverse-time.json", "nut.toml",
    ]  # fmt: skip


def test_a_sweep_is_printed_where_no_file_is_asked_for(run: Run) -> None:
    args = ("traverse-time", *NUT, "-A", "0.5,1,4", "-f", "1,15", "-L", "600")
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


def test_an_axis_among_the_options_sweeps(run: Run) -> None:
    result = run("traverse-time", *NUT, "-A", "0.5:2:4", "-L", "600", "-o", "-")
    assert result.exit_code == 0
    assert [row["regime"] for row in rows_of(result.stdout)] == [
        "no-slip",
        "forward-slip",
        "back-slip",
        "back-slip",
    ]


def test_flight_can_be_left_out(run: Run) -> None:
    hops = ("traverse-time", *NUT, "-A", "4", "-L", "600", "--json")
    answer = json.loads(run(*hops).stdout)
    assert answer["traverse_time_s"] == pytest.approx(600 / answer["mean_velocity_mm_s"], rel=1e-15)
    without = json.loads(run(*hops, "--flight", "off").stdout)
    assert (without["traverse_time_s"], without["status"]) == (None, "flight-not-modelled")
    told = run(*hops[:-1], "--flight", "off")
    assert told.exit_code == 0
    assert told.stdout.startswith("traverse time  unknown: the body leaves the trough")
    swept = rows_of(run(*hops[:-1], "-A", "1,4", "--flight", "off", "-o", "-").stdout)
    assert [bool(row["traverse_time_s"]) for row in swept] == [True, False]


def test_one_scene_has_the_exact_arrival_and_why_it_differs(run: Run) -> None:
    lines = [" ".join(line.split()) for line in run("traverse-time", *NUT, "-L", "600").stdout.splitlines()]
    assert lines[1] == "exactly 36.8904 s from rest at trough phase 0"
    assert lines[2].startswith(
        "why 0.0314255 drive cycles earlier than at the mean speed: the start from rest"
    )
    answer = json.loads(run("traverse-time", *NUT, "-L", "600", "--json").stdout)
    assert answer["traverse_time_s"] - answer["arrival_time_s"] == pytest.approx(0.0314255 / 15, rel=1e-4)


def test_what_only_the_way_into_the_steady_motion_reaches_is_told(run: Run) -> None:
    args = ("traverse-time", "-A", "1", "-f", "15", "-a", "0", "--mu-s", "0.2", "--mu-d", "0.2", "-L")
    lines = run(*args, "1").stdout.splitlines()
    assert lines[0].startswith("traverse time  never: the body slides to and fro")
    assert lines[1].split()[0] == "exactly"
    assert "before it settles" in lines[2]
    assert not any(line.startswith("exactly") for line in run(*args, "100").stdout.splitlines())


IRREGULAR = (
    "traverse-time", "-A", "7.088276919005166", "-f", "20", "-a", "0.7712478462674884rad",
    "--mu-s", "0.23929552573721188", "--mu-d", "0.1817686890112862", "--restitution", "0.6112762739020561",
    "-L", "4562.80220557782",
)  # fmt: skip


def test_an_arrival_that_rounding_hides_is_unknown(run: Run) -> None:
    result = run(*IRREGULAR)
    assert result.exit_code == 0
    told = dict(re.split(r"  +", line, maxsplit=1) for line in result.stdout.splitlines())
    assert told["status"].startswith("averaged (")
    assert told["exactly"].startswith("unknown: flights amplify rounding, which grows past 1e-9 rad")
    assert told["exactly"].endswith("; a body may differ from the mean by more than its error")
    assert "why" not in told
    found = re.fullmatch(r"(\S+) s \+- (\S+) s \(standard error\) over 4562.8 mm", told["traverse time"])
    assert found is not None
    mean, error = map(float, found.groups())
    speed, its_error = map(float, re.findall(r"([\d.]+)(?: mm/s)", told["mean speed"]))
    assert mean == pytest.approx(4562.80220557782 / speed, rel=1e-5)
    assert error / mean == pytest.approx(its_error / speed, rel=0.11)  # two digits each
    assert told["strokes"].endswith("(standard error)")


def test_an_arrival_on_the_way_into_a_cycle_may_be_unknown_too(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unknown(scene: Any, length: Any) -> Any:
        return np.full(np.broadcast_shapes(scene.shape, np.shape(length)), np.nan)

    monkeypatch.setattr("vibro.sweeps.run.arrival_time", unknown)
    args = ("traverse-time", *NUT, "-A", "4", "-L", "600")
    assert json.loads(run(*args, "--json").stdout)["arrival_time_s"] is None
    text = run(*args).stdout
    lines = text.splitlines()
    assert re.fullmatch(r"traverse time  [\d.]+ s over 600 mm", lines[0])
    assert lines[1].startswith("exactly        unknown: flights amplify rounding")
    assert "standard error" not in text


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

    for error, answer in (
        (0.5, "unknown: within the standard error"),
        (0.1, "never: the body is conveyed backwards"),
    ):
        monkeypatch.setattr("vibro.sweeps.grid.solve", partial(backwards, error=error))
        assert f"traverse time  {answer}" in run("traverse-time", *NUT, "-A", "4", "-L", "600").stdout


def test_a_sweep_has_exact_arrivals_on_request(run: Run) -> None:
    sweep = ("traverse-time", *NUT, "-A", "0.5,1,4", "-L", "600", "-o", "-")
    assert "arrival_time_s" not in rows_of(run(*sweep).stdout)[0]
    rows = rows_of(run(*sweep, "--exact").stdout)
    names = list(rows[0])
    assert names.index("arrival_time_s") < names.index("model")
    assert rows[0]["arrival_time_s"] == ""
    for row, amplitude in zip(rows[1:], ("1", "4"), strict=True):
        alone = json.loads(run("traverse-time", *NUT, "-A", amplitude, "-L", "600", "--json").stdout)
        assert float(row["arrival_time_s"]) == pytest.approx(alone["arrival_time_s"], rel=1e-13)
    without = rows_of(run(*sweep, "--exact", "--flight", "off").stdout)
    assert [bool(row["arrival_time_s"]) for row in without] == [False, True, False]


def test_the_help_says_what_exact_arrivals_cost(run: Run) -> None:
    text = " ".join(run("traverse-time", "--help").stdout.replace("│", " ").split())
    assert "20 us a cell in contact" in text


def test_a_sweep_of_nothing_is_an_error(run: Run) -> None:
    result = run("traverse-time", *NUT, "-L", "600", "--sweep")
    assert result.exit_code == 2
    assert result.stderr == "error: nothing varies\nhint: give an axis, for example -A 0.1:3:200\n"
