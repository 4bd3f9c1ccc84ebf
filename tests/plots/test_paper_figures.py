"""The paper's figures, drawn by examples."""

from __future__ import annotations

import math
import runpy
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.drawn import GRAVITY, coarse_pictures, words
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


def test_figure_11_has_the_published_speeds() -> None:
    """The study's nut reaches "up to 55" mm/s and advances "about 1" mm a stroke."""
    velocity, displacement = drawn("paper-figure-11").axes
    exact, study = (np.asarray(line.get_ydata()) for line in velocity.lines[:2])
    assert exact.max() == pytest.approx(60.15, abs=0.01)
    assert study.max() == pytest.approx(55.6, abs=0.2)
    exact, study = (np.asarray(line.get_ydata()) for line in displacement.lines[:2])
    assert exact[-1] / 3 == pytest.approx(1.08423, abs=1e-5)
    assert study[-1] / 3 == pytest.approx(0.9554, abs=1e-3)


def test_maps_of_the_paper(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.setattr(sys, "argv", ["paper_maps.py", str(tmp_path / "new")])
    with coarse_pictures():
        names = runpy.run_path(str(EXAMPLES / "paper_maps.py"), run_name="__main__")
    assert sorted(p.name for p in (tmp_path / "new").iterdir()) == [
        "paper-figure-3.png",
        "paper-figure-5.png",
    ]
    at_15_hz = 1e3 * GRAVITY / (2 * math.pi * 15) ** 2
    assert names["onset_load"](0.74) * at_15_hz == pytest.approx(0.685165, abs=5e-7)
    assert names["onset_load_as_printed"](0.74) * at_15_hz == pytest.approx(0.720276, abs=5e-7)
    assert "0.74  0.685165  0.720276  +5.1%" in capsys.readouterr().out
    assert names["hop_load"](20) * at_15_hz == pytest.approx(3.229052, abs=5e-7)
    axes = names["hop_limits"]().axes[0]
    assert {"α = 10°", "α = 15°", "α = 20°", "α = 30°", "α = 45°"} <= set(words(axes))
