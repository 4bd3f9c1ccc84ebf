"""``vibro map``: axes, defaults, files, pictures and their options."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import pytest
from helpers.commands import NUT, NUT_ANGLE_AND_FRICTION, NUT_FILE, Run, other, rows_of

from vibro.sweeps.columns import columns_of


def names() -> list[str]:
    return sorted(path.name for path in Path().rglob("*") if path.is_file())


NUT_MAP = ("map", "-A", "0.5:1.1:2", "-f", "10:30:5", *NUT_ANGLE_AND_FRICTION, "-L", "600", "-o", "out/nut")


def test_a_map_writes_its_table_and_pictures_and_how_to_run_it_again(run: Run) -> None:
    from PIL import Image

    result = run(*NUT_MAP)
    assert (result.exit_code, result.stdout) == (0, "")
    files = ["nut.csv", "nut-regime.png", "nut-speed.png", "nut-traverse.png", "nut.json"]
    assert names() == sorted(files)
    rows = rows_of(Path("out/nut.csv").read_text(encoding="utf-8"))
    usual = columns_of(made_with=["restitution", "trough_length"])
    assert list(rows[0]) == [column.name for column in usual]
    assert [(row["amplitude_mm"], row["frequency_hz"]) for row in rows] == list(
        itertools.product(["0.5", "1.1"], ["10", "15", "20", "25", "30"])
    )
    content = json.loads(Path("out/nut.json").read_text(encoding="utf-8"))
    assert content["version"]
    assert content["argv"] == ["vibro", *NUT_MAP]
    assert content["scene"] == {
        "drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57, "trough_angle_deg": 0,
        "gravity_m_s2": 9.81, "restitution": 0, "trough_length_mm": 600,
    }  # fmt: skip
    assert content["axes"]["amplitude_mm"] == {"count": 2, "first": 0.5, "last": 1.1, "spacing": "linear"}
    assert content["cells"] == 10
    for key in ("status", "regime"):
        for label, number in content[key].items():
            assert sum(row[key] == label for row in rows) == number
    assert content["columns"]["mean_velocity_mm_s"] == "mm/s"
    assert content["files"] == files
    for name, title in (("regime", "Steady regimes"), ("speed", "Mean conveying speed")):
        with Image.open(f"out/nut-{name}.png") as picture:
            assert json.loads(picture.info["Description"]) == content
            assert picture.info["Title"] == title


@pytest.mark.usefixtures("unsaved")
def test_json_is_the_sidecar_on_stdout(run: Run) -> None:
    result = run("map", *other(NUT, "-A", "0.5:2:3"), "--regimes-only", "-o", "nut", "--json")
    assert json.loads(result.stdout) == json.loads(Path("nut.json").read_text(encoding="utf-8"))


HOPS = ("map", "-A", "0.5:6:3", "-f", "15:25:2", *NUT_ANGLE_AND_FRICTION, "-o", "hop")


def test_pictures_of_flight_on_request(run: Run) -> None:
    from PIL import Image

    assert run(*HOPS, "--show", "impact").exit_code == 0
    pictures = [name for name in names() if name.endswith(".png")]
    assert pictures == ["hop-impact.png", "hop-regime.png", "hop-speed.png"]
    with Image.open("hop-impact.png") as picture:
        assert picture.info["Title"] == "Impact speed"
    for row in rows_of(Path("hop.csv").read_text(encoding="utf-8")):
        hops = row["regime"] == "hopping"
        assert (row["model"] == "flight") == hops
        assert (float(row["flight_fraction"]) > 0) == hops
        assert (float(row["impact_speed_mm_s"]) > 0) == hops
        assert row["status"] == "ok"


@pytest.mark.usefixtures("unsaved")
def test_regimes_alone(run: Run) -> None:
    assert run(*HOPS, "--regimes-only").exit_code == 0
    assert [name for name in names() if name.endswith(".png")] == ["hop-regime.png"]
    assert json.loads(Path("hop.json").read_text(encoding="utf-8"))["flight"] is False
    regimes = rows_of(Path("hop.csv").read_text(encoding="utf-8"))
    exact = rows_of(run(*HOPS[:-1], "-").stdout)
    for quick, full in zip(regimes, exact, strict=True):
        for column in ("regime", "throw_number", "forward_ratio", "back_ratio"):
            assert quick[column] == full[column]
        if quick["regime"] != "no-slip":
            assert quick["mean_velocity_mm_s"] == quick["pattern"] == quick["model"] == ""
    assert {row["regime"] for row in regimes} >= {"no-slip", "back-slip", "hopping"}


def test_infeasible_combinations_are_rows_without_numbers(run: Run) -> None:
    result = run("map", *NUT[:6], "--mu-s", "0.2:1:5", "--mu-d", "0.2:1:5", "-o", "-")
    assert result.exit_code == 0
    given = {"amplitude_mm", "frequency_hz", "drive_angle_deg", "static_friction", "kinetic_friction"}
    for row in rows_of(result.stdout):
        infeasible = float(row["kinetic_friction"]) > float(row["static_friction"])
        assert (row["status"] == "infeasible") == infeasible
        if infeasible:
            empty = set(row) - given - {"trough_angle_deg", "restitution", "status"}
            assert {row[name] for name in empty} == {""}


def test_a_ratio_is_an_axis_and_a_stroke_is_its_amplitude(run: Run) -> None:
    axes = ["--stroke", "1:2:3", "-f", "15", "-a", "20", "--mu-s", "0.4,0.8", "--mu-ratio", "0.5,1"]
    rows = rows_of(run("map", *axes, "-o", "-").stdout)
    assert [row["amplitude_mm"] for row in rows[::4]] == ["0.5", "0.75", "1"]
    pairs = [(row["static_friction"], row["kinetic_friction"]) for row in rows[:4]]
    assert pairs == [("0.4", "0.2"), ("0.4", "0.4"), ("0.8", "0.4"), ("0.8", "0.8")]


def test_scene_file_and_options_merge_by_name(run: Run) -> None:
    Path("nut.toml").write_text(
        NUT_FILE + '\n[map]\namplitude_mm = "0.5:1.5:3"\nstatic_friction = [0.7, 0.8]\n', encoding="utf-8"
    )
    result = run("map", "nut.toml", "--mu-s", "0.75", "-a", "25", "-o", "-")
    rows = rows_of(result.stdout)
    assert [row["amplitude_mm"] for row in rows] == ["0.5", "1", "1.5"]
    assert {(row["static_friction"], row["drive_angle_deg"]) for row in rows} == {("0.75", "25")}
    # A stroke is the same quantity as an amplitude, a ratio the same as kinetic friction.
    result = run("map", "nut.toml", "--stroke", "2", "--mu-ratio", "0.5", "-o", "-")
    assert {row["amplitude_mm"] for row in rows_of(result.stdout)} == {"1"}
    assert {row["kinetic_friction"] for row in rows_of(result.stdout)} == {"0.35", "0.4"}
