"""The paper's figures over time, drawn by an example."""

from __future__ import annotations

import runpy
import sys
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.drawn import coarse_pictures
from helpers.made_records import EXAMPLES
from matplotlib.figure import Figure

from vibro.plots.style import house_style

SCRIPT = EXAMPLES / "paper_figures.py"


@cache
def example() -> dict[str, Any]:
    return runpy.run_path(str(SCRIPT))


DRAWN = dict(example()["FIGURES"])


@cache
def drawn(name: str) -> Figure:
    """Draw a figure of the example; tests only look at it."""
    with house_style():
        figure = DRAWN[name]()
    assert isinstance(figure, Figure)
    return figure


def test_every_figure_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", [SCRIPT.name, str(tmp_path / "new")])
    for name in example()["FIGURES"]:
        monkeypatch.setitem(example()["FIGURES"], name, partial(drawn, name))
    with coarse_pictures():
        example()["main"]()
    assert {p.name for p in (tmp_path / "new").iterdir()} == {
        f"paper-figure-{number}.png" for number in (2, 4, 6, 7, 9, 10, 11)
    }


def test_figure_6_marks_both_onsets() -> None:
    (axes,) = drawn("paper-figure-6").axes
    starts = {
        round(float(np.asarray(line.get_ydata())[0]), 6): np.asarray(line.get_xdata())
        for line in axes.lines
        if line.get_marker() == "s" and len(np.asarray(line.get_xdata()))
    }
    assert set(starts) == {0.685165, 0.720276}
    # Published: start of the slide by the derived and by the printed condition.
    assert starts[0.685165][0] == pytest.approx(8.00900, abs=5e-6)
    assert starts[0.720276][0] == pytest.approx(8.53282, abs=5e-6)


def test_figure_11_has_the_published_speeds() -> None:
    """The study's nut reaches "up to 55" mm/s and advances "about 1" mm a stroke."""
    velocity, displacement = drawn("paper-figure-11").axes
    exact, study = (np.asarray(line.get_ydata()) for line in velocity.lines[:2])
    assert exact.max() == pytest.approx(60.15, abs=0.01)
    assert study.max() == pytest.approx(55.6, abs=0.2)
    exact, study = (np.asarray(line.get_ydata()) for line in displacement.lines[:2])
    assert exact[-1] / 3 == pytest.approx(1.08423, abs=1e-5)
    assert study[-1] / 3 == pytest.approx(0.9554, abs=1e-3)
