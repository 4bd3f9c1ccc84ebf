"""The paper's figures, drawn by an example."""

from __future__ import annotations

import math
import runpy
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from helpers.drawn import GRAVITY, coarse_pictures, words

if TYPE_CHECKING:
    pass


EXAMPLES = Path(__file__).parents[2] / "examples"


def test_the_papers_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
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
