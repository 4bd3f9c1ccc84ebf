"""``draw`` of results: what the command writes, into a file or not, in the examples' words."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

import vibro

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from helpers.commands import Run

EXAMPLES = Path(__file__).parents[2] / "examples"
NUT, RECORD = EXAMPLES / "safety_nut.toml", EXAMPLES / "data" / "nut_smoothed_600hz.csv"
QUESTION = EXAMPLES / "design_nut.toml"


@pytest.fixture(autouse=True, scope="module")
def coarse() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibro.plots.design._RESOLVED", 41)
        patch.setattr("vibro.designs.pictured._POINTS", {False: 41, True: 41})
        yield


@pytest.fixture(scope="module")
def designs() -> vibro.DesignResult:
    return vibro.design(QUESTION, only="goal")


def nut(cycles: float = 3.0) -> vibro.History:
    return vibro.simulate(vibro.read_scene(NUT), cycles=cycles)


def seen_in(figure: Figure) -> dict[str, Any]:
    """Return what a picture shows but for its headline: labels, lines, patches, texts."""
    return {
        f"{i} {name}": value
        for i, axes in enumerate(figure.axes)
        for name, value in {
            "labels": (axes.get_xlabel(), axes.get_ylabel(), axes.get_title()),
            "limits": (axes.get_xlim(), axes.get_ylim()),
            "lines": [repr(np.asarray(line.get_xydata()).tolist()) for line in axes.lines],  # NaN too
            "patches": len(axes.patches),
            "collections": len(axes.collections),
            "texts": [text.get_text() for text in axes.texts],
        }.items()
    }


def test_a_result_draws_what_its_command_writes(
    run: Run, designs: vibro.DesignResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[dict[str, Any]] = []

    def save(figure: Figure, path: Path, *_: Any) -> None:
        written.append(seen_in(figure))
        path.touch()

    monkeypatch.setattr("vibro.plots.save", save)
    part = ("--from", 0.1, "--to", 0.3, "--panels", "forces,velocity")
    pictures: dict[tuple[Any, ...], list[Callable[[], Figure]]] = {
        ("simulate", NUT): [nut().draw],
        ("simulate", NUT, "--cycles", 9): [nut(9).draw],
        ("simulate", NUT, "--cycles", 9, *part): [
            lambda: nut(9).draw(start=0.1, end=0.3, panels="forces,velocity")
        ],
        ("measure", NUT, RECORD): [vibro.compare(vibro.read_scene(NUT), RECORD).draw],
        ("design", QUESTION): [lambda: designs.draw("regime"), designs.draw, lambda: designs.draw("band")],
    }
    for command, draws in pictures.items():
        written.clear()
        result = run(*command, "-o", f"{command[0]}.svg", "--force")
        assert result.exit_code == 0, result.stderr
        assert [seen_in(draw()) for draw in draws] == written, command


def test_a_history_is_drawn_between_two_times() -> None:
    figure = nut(9).draw(start=0.1, end=0.3, panels="forces,velocity")
    assert [axes.get_xlim() for axes in figure.axes] == [pytest.approx((100.0, 300.0))] * 3
    assert nut(9).draw().axes[1].get_xlim() == pytest.approx((200.0, 600.0))  # the last six cycles


def test_another_design_is_drawn_where_it_is_asked_for(designs: vibro.DesignResult) -> None:
    for design in designs.designs:
        figure = designs.draw("band", design=design)
        lines = [line for axes in figure.axes for line in axes.lines]
        marks = [line.get_xdata() for line in lines if line.get_marker() == "o"]
        assert any(x == pytest.approx([design.amplitude_mm]) for x in marks), design
    with pytest.raises(vibro.InputError, match="must be one of designs, and guarantee a speed"):
        designs.draw(design=replace(designs.designs[0]))


def test_the_speed_that_is_wanted_stands_out_in_a_sweep() -> None:
    sweep = vibro.sweep(NUT, amplitude_mm="0.1:3:41", frequency_hz=15)
    heights = [
        {y.item(0) for line in axes.lines if np.ptp(y := np.asarray(line.get_ydata(), float)) == 0.0}
        for axes in (sweep.draw("speed").axes[-1], sweep.draw("speed", target_speed="1.2m/min").axes[-1])
    ]
    assert heights[1] - heights[0] == {20.0}
    with pytest.raises(vibro.InputError, match="speed = -1"):
        sweep.draw("speed", target_speed=-1)


def test_a_picture_is_written_by_the_ending_of_its_file(tmp_path: Path, designs: vibro.DesignResult) -> None:
    history, comparison = nut(), vibro.compare(vibro.read_scene(NUT), RECORD)
    sweep = vibro.sweep(NUT, amplitude_mm="0.1:3:5", frequency_hz=15)
    for draw, name in (
        (history.draw, "a.png"),
        (comparison.draw, "b.SVG"),
        (lambda path: designs.draw("band", path), "c.pdf"),
        (lambda path: sweep.draw("speed", path=path), "d.png"),
    ):
        path = tmp_path / name
        path.write_text("what was there", encoding="utf-8")
        assert isinstance(draw(path), Figure)
        data = path.read_bytes()
        if name.endswith("png"):
            assert imread(path).shape[1] > 200
        else:
            assert data.startswith(b"%PDF" if name.endswith("pdf") else b"<?xml")
        with pytest.raises(vibro.InputError, match=r"must end in \.png or \.svg or \.pdf"):
            draw(tmp_path / "a.gif")
        with pytest.raises(vibro.FileError, match="cannot write"):
            draw(tmp_path / "nowhere" / name)


def test_the_designs_of_a_question_that_nothing_meets_are_drawn_as_far_as_there_are_any() -> None:
    question = {
        "scene": {"static_friction": 0.4, "kinetic_friction": 0.3},
        "drive": {"amplitude_mm": 0.01, "frequency_hz": 10, "drive_angle_deg": 20},
        "goal": {"speed_mm_s": 80},
    }
    with pytest.raises(vibro.InputError, match="no setting of any drive guarantees a speed"):
        vibro.design(question, only="goal").draw()
    with pytest.raises(vibro.InputError, match="no such picture of a design"):
        vibro.design(question, only="goal").draw("traverse")  # type: ignore[arg-type]
    with pytest.raises(vibro.InputError, match="no question to draw"):
        vibro.DesignResult(True, (), ()).draw()


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"start": 0.3}, r"start = 0.3 s: must ascend within the history, 0 to 0.2 s"),
        ({"start": 0.1, "end": 0.1}, "must ascend"),
        ({"end": float("nan")}, r"end = nan: must be finite"),
        ({"end": "0.1"}, r"end = '0.1': must be one real number"),
        ({"panels": "speed"}, "is no panel"),
    ],
)
def test_what_a_history_cannot_show_is_refused(asked: dict[str, Any], message: str) -> None:
    with pytest.raises(vibro.InputError, match=message):
        nut().draw(**asked)
    with pytest.raises(vibro.InputError, match=r"101 drive cycles are too many"):
        nut(101).draw(start=0.0)
