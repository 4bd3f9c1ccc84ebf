"""``vibro map``: which part of a sweep its pictures show, and what it says of the others."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from helpers import sharded_maps
from helpers.cases import each
from helpers.commands import NUT, NUT_ANGLE_AND_FRICTION, Run, rows_of
from helpers.drawn import only_map

from vibro.plots import map_figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def names() -> list[str]:
    return sorted(path.name for path in Path().rglob("*") if path.is_file())


def test_four_axes_draw_a_slice_and_the_table_holds_all(run: Run) -> None:
    args = ("-A", "0.5:2:3", "-f", "10:30:3", "-a", "10,20", "--mu-s", "0.6,0.7", "--mu-d", "0.5")
    result = run("map", *args, "-o", "nut", "--at", "mu_s=0.7", "--x", "amplitude", "--y", "frequency")
    assert result.exit_code == 0
    assert "pictures:" not in result.stderr
    assert len(rows_of(Path("nut.csv").read_text(encoding="utf-8"))) == 36
    assert names() == ["nut-regime.png", "nut-speed.png", "nut.csv", "nut.json"]


def test_the_axes_of_a_picture_are_those_asked_for(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: dict[str, Figure] = {}

    def noted(*args: Any, **how: Any) -> dict[str, Figure]:
        drawn.update(map_figures(*args, **how))
        return drawn

    monkeypatch.setattr("vibro.plots.map_figures", noted)
    args = ("-A", "0.5:2:3", "-f", "10:30:3", *NUT_ANGLE_AND_FRICTION)
    assert run("map", *args, "-o", "nut", "--x", "amplitude", "--y", "frequency").exit_code == 0
    axes = only_map(drawn["regime"])
    assert axes.get_xlabel().startswith("amplitude")
    assert axes.get_ylabel().startswith("frequency")


@each(
    ("args", "problem"),
    [
        (("--x", "mu_s"), "static friction does not vary in this sweep"),
        (("--x", "f", "--y", "f"), "frequency is asked for twice"),
        (("--at", "f=15"), "frequency = 15 Hz is none of the values of this axis"),
        (("--at", "f=20", "--at", "frequency=20"), "--at: frequency is given twice"),
        (("--at", "A=9"), "amplitude = 9 mm lies outside of the sweep"),
        (("--at", "A"), "--at A: not of the form AXIS=VALUE"),
        (("--at", "colour=1"), "--at colour=1: 'colour' is no axis"),
        (("--at", "A=1,f=12"), "every axis of the sweep is fixed: nothing is left to draw"),
        (("--format", "bmp"), "--format bmp: 'bmp' is not a format of pictures"),
    ],
)
def test_a_wrong_choice_of_picture_is_refused_beforehand(
    run: Run, args: tuple[str, ...], problem: str
) -> None:
    result = run("map", "-A", "0.5:2:3", "-f", "10:30:3", *NUT_ANGLE_AND_FRICTION, "-o", "nut", *args)
    assert result.exit_code == 2
    assert f"error: {problem}" in result.stderr
    assert names() == []


FOUR = ("map", "-A", "0.5:2:3", "-f", "10:30:13", *NUT_ANGLE_AND_FRICTION[2:], "--regimes-only")


def test_what_pictures_do_not_show_is_said(run: Run) -> None:
    args = (*FOUR, "-a", "10:30:13", "--mu-s", "0.3,0.4,0.6,0.74,0.9", "--trough-angle", "0.0,5")
    result = run(*args, "-o", "nut")
    assert [line for line in result.stderr.splitlines() if line.startswith("pictures")] == [
        "pictures: drive angle held at 20 deg; --at alpha=VALUE chooses",
        "pictures: trough angle held at 5 deg; --at beta=VALUE chooses",
    ]
    result = run(*FOUR, "-a", "10:30:13", "-o", "more")
    assert "pictures: drive angle at 12 of its 13 values; --at alpha=VALUE chooses one\n" in result.stderr
    result = run(*args, "-o", "held", "--at", "alpha=0.3490658503988659rad,beta=0")
    assert result.exit_code == 0
    assert "pictures" not in result.stderr
    assert "pictures" not in run(*args, "-o", "-").stderr


def test_the_nearest_values_can_be_typed(run: Run) -> None:
    result = run(*FOUR, "-a", "10:40:7", "-o", "nut", "--at", "drive_angle=33")
    assert result.exit_code == 2
    error, hint = [line for line in result.stderr.splitlines() if line.startswith(("error", "hint"))]
    assert error == "error: drive angle = 33 deg is none of the values of this axis"
    assert hint == "hint: give the nearest, 30 or 35 deg"
    assert run(*FOUR, "-a", "10:40:7", "-o", "nut", "--at", "drive_angle=35").exit_code == 0


def test_a_list_beside_a_range_is_curves(run: Run) -> None:
    args = ("map", "-A", "0.01:0.3:5", "-f", "50,100", *NUT_ANGLE_AND_FRICTION)
    assert run(*args, "-o", "all").exit_code == 0
    assert run(*args, "-o", "few", "--regimes-only").exit_code == 0
    assert run("map", *NUT, "-f", "25,50,100", "-o", "dots").exit_code == 0
    assert [name for name in names() if name.endswith(".png")] == [
        "all-regime.png", "all-speed.png", "dots-speed.png", "few-regime.png",
    ]  # fmt: skip
    result = run(*args, "-o", "no", "--y", "f")
    assert result.exit_code == 2
    assert "error: frequency is a list of 2 values, drawn one by one: no axis of a map" in result.stderr
    assert "hint: for a map give it as a range, 50:100; else leave y out" in result.stderr


def test_a_map_without_motion_says_where_motion_begins(run: Run) -> None:
    result = run("map", "-A", ".01:.1:9", "-f", "5:10:9", *NUT_ANGLE_AND_FRICTION, "-o", "x")
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("at rest everywhere")]
    amplitude, frequency = (float(number) for number in re.findall(r"at ([\d.]+) (?:mm|Hz)", line))
    for factor, regime in ((0.999, "no-slip"), (1.001, "forward-slip")):
        for given in (("-A", factor * amplitude, "-f", 10), ("-A", 0.1, "-f", factor * frequency)):
            answer = json.loads(run("solve", *given, *NUT_ANGLE_AND_FRICTION, "--json").stdout)
            assert answer["regime"] == regime
    moving = run("map", "-A", ".01:2:9", "-f", "5:10:9", *NUT_ANGLE_AND_FRICTION, "-o", "-")
    assert "at rest" not in moving.stderr


def test_a_map_is_not_at_rest_because_its_last_cells_are(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.sweeps.run._BLOCK", 1)
    args = ("-A", 1, "-f", 15, "-a", 20, "--mu-s", "0.3:3:4", "--mu-d", 0.2)
    assert "at rest" not in run("map", *args, "-o", "-").stderr


def test_a_stroke_is_chosen_among_strokes(run: Run) -> None:
    sweep = ("-f", "10:30:3", "-a", "20,30", "--mu-s", "0.74", "--mu-d", "0.57", "-o", "x")
    result = run("map", "--stroke", "1:4:3", *sweep, "--at", "stroke=2.5")
    assert result.exit_code == 0, result.stderr
    assert "pictures:" not in result.stderr
    wrong = run("map", "--stroke", "1:4:3", *sweep, "--at", "stroke=3", "--force")
    assert "hint: give the nearest, 2.5 or 4 mm" in wrong.stderr


def test_pictures_go_into_the_folder_of_a_table_in_shards(run: Run) -> None:
    from PIL import Image

    asked = (*sharded_maps.AXES, "-L", "600", "--table", "parquet", "-o", "out")
    result = run(*asked)
    assert result.exit_code == 0
    drawn = ["_regime.png", "_speed.png", "_traverse.png"]
    assert sharded_maps.names() == ["_SUCCESS", "_manifest.json", *drawn, "part-000000.parquet"]
    assert [f"wrote {Path('out', name)}" in result.stderr for name in drawn] == [True] * 3
    for name, title in zip(
        drawn, ("Steady regimes", "Mean conveying speed", "Traverse time over 600 mm"), strict=True
    ):
        with Image.open(Path("out", name)) as picture:
            picture.load()
            assert picture.info["Title"] == title
            assert picture.info["Software"].startswith("vibro ")
            said = json.loads(picture.info["Description"])
        assert (said["digest"], said["cells"]) == (sharded_maps.told()["digest"], 9)
        assert said["scene"]["trough_length_mm"] == 600
    # They are drawn again, and go with the sweep that they are of.
    Path("out", "_regime.png").unlink()
    assert run(*asked, "--resume").exit_code == 0
    assert "_regime.png" in sharded_maps.names()
    asked = (*sharded_maps.QUICK, "--table", "parquet", "-o", "out", "--format")
    there = ["_SUCCESS", "_manifest.json", "_regime.svg", "part-000000.parquet"]
    assert run(*asked, "svg", "--force").exit_code == 0
    assert sharded_maps.names() == there
    assert run(*asked, "pdf", "--resume").exit_code == 0
    assert sharded_maps.names() == sorted([*there, "_regime.pdf"])
    assert run(*asked, "svg", "--force").exit_code == 0
    assert sharded_maps.names() == there
    # What the manifest does not list is somebody's own.
    Path("out", "_regime.png").write_text("mine", encoding="utf-8")
    result = run(*asked, "png", "--resume")
    assert sharded_maps.error(result)[0] == "error: out holds something else: _regime.png"
    assert Path("out", "_regime.png").read_text(encoding="utf-8") == "mine"
