"""``vibro map``: which part of a sweep its pictures show, and what it says of the others."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from helpers.commands import NUT_ANGLE_AND_FRICTION, Run
from helpers.drawn import curve, legend, only_map

from vibro.plots import map_figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> dict[str, Figure]:
    found: dict[str, Figure] = {}

    def noted(*args: Any, **how: Any) -> dict[str, Figure]:
        found.update(map_figures(*args, **how))
        return found

    monkeypatch.setattr("vibro.plots.map_figures", noted)
    return found


@pytest.mark.usefixtures("unsaved")
def test_table_and_picture_name_the_same_fastest_cell(run: Run, drawn: dict[str, Figure]) -> None:
    """Of a coarse table; the cells of the picture are finer, and some of them faster."""
    args = ("map", "--stroke", "1:6:8", "-f", "10:60:8", *NUT_ANGLE_AND_FRICTION)
    for output in (("-o", "nut"), ("-o", "nut.parquet", "-o", "folder.png")):
        assert run(*args, *output).exit_code == 0
        peak = json.loads(Path("nut.json").read_text(encoding="utf-8"))["peaks"]["fastest"]
        (told,) = (text for text in legend(drawn["speed"]) if text.startswith("fastest"))
        assert told.startswith(f"fastest: {peak['mean_velocity_mm_s']:.5g} mm/s at $2A$ = ")
        place = peak["frequency_hz"], 2.0 * peak["amplitude_mm"]
        assert curve(only_map(drawn["speed"]), "fastest")[0].tolist() == pytest.approx(place)


@pytest.mark.usefixtures("unsaved")
def test_the_axes_of_a_picture_are_those_asked_for(run: Run, drawn: dict[str, Figure]) -> None:
    args = ("-A", "0.5:2:3", "-f", "10:30:3", *NUT_ANGLE_AND_FRICTION)
    assert run("map", *args, "-o", "nut", "--x", "amplitude", "--y", "frequency").exit_code == 0
    axes = only_map(drawn["regime"])
    assert axes.get_xlabel().startswith("amplitude")
    assert axes.get_ylabel().startswith("frequency")


FOUR = ("map", "-A", "0.5:2:3", "-f", "10:30:13", *NUT_ANGLE_AND_FRICTION[2:], "--regimes-only")


@pytest.mark.usefixtures("unsaved")
def test_what_pictures_do_not_show_is_said(run: Run) -> None:
    more = "-a 10:30:13 --mu-s 0.3,0.4,0.6,0.74,0.9 --trough-angle 0.0,5"
    args = (*FOUR[:5], *FOUR[7:], *more.split())
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


def test_a_map_is_not_at_rest_because_its_last_cells_are(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.sweeps.run._BLOCK", 1)
    args = ("-A", 1, "-f", 15, "-a", 20, "--mu-s", "0.3:3:4", "--mu-d", 0.2)
    assert "at rest" not in run("map", *args, "-o", "-").stderr


@pytest.mark.usefixtures("unsaved")
def test_a_stroke_is_chosen_among_strokes(run: Run) -> None:
    sweep = ("-f", "10:30:3", "-a", "20, 30", "--mu-s", "0.74", "--mu-d", "0.57", "-o", "x")
    result = run("map", "--stroke", "1:4:3", *sweep, "--at", "stroke=2.5")
    assert result.exit_code == 0, result.stderr
    assert "pictures:" not in result.stderr
