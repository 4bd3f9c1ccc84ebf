"""Pictures as files."""

from __future__ import annotations

import io
import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib
import pytest
from helpers.drawn import coarse_pictures, sweep
from PIL import Image

from vibro.plots import map_figures, save

if TYPE_CHECKING:
    from matplotlib.figure import Figure


METADATA = {"Software": "vibro 0.1.0", "scene": '{"amplitude_mm": 1.0}'}


def test_png_carries_everything(pictures: dict[str, Figure], tmp_path: Path) -> None:
    path = tmp_path / "picture.tmp"
    save(pictures["regime"], path, "png", METADATA)
    with Image.open(path) as image:
        assert image.format == "PNG"
        assert image.width > 1000
        assert {key: image.info[key] for key in METADATA} == METADATA
        assert json.loads(image.info["scene"]) == {"amplitude_mm": 1.0}


def test_svg_and_pdf_are_small_and_carry_a_description(pictures: dict[str, Figure], tmp_path: Path) -> None:
    for form in ("svg", "pdf"):
        save(pictures["speed"], tmp_path / form, form, METADATA)
        content = (tmp_path / form).read_bytes()
        assert b"Software: vibro 0.1.0" in content
        assert len(content) < 1_500_000  # 130 000 cells as paths would be a hundred times that


@pytest.mark.parametrize("picture_format", ["png", "svg", "pdf"])
def test_the_same_picture_is_the_same_file(
    climb_pictures: dict[str, Figure], tmp_path: Path, picture_format: str
) -> None:
    for name in ("one", "other"):
        save(climb_pictures["regime"], tmp_path / name, picture_format, METADATA)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "other").read_bytes()


def test_threads_draw_and_save_at_once() -> None:
    """Matplotlib's parser of formulas and its settings are common to all threads."""
    with coarse_pictures():
        result = sweep(points=31, amplitude="0.1:3", frequency="5:60")

        def work(name: str) -> None:
            figure = map_figures(result, [name])[name]
            save(figure, io.BytesIO(), "png", {})
            figure.savefig(io.BytesIO(), format="svg")

        before = dict(matplotlib.rcParams)
        with ThreadPoolExecutor(2) as threads:
            list(threads.map(work, ["regime", "speed"]))
    assert dict(matplotlib.rcParams) == before
