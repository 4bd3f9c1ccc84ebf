"""Names that users give are text in every picture and in its files: never markup, never a warning."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import pytest
from helpers.drawn import coarse_pictures, sweep
from PIL import Image

from vibro.plots import map_figures, save
from vibro.plots.frame import renderer_of
from vibro.plots.style import figure_text, house_style

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure

    from vibro.results.sweep import SweepResult

# Names, and how they appear in pictures.
SHOWN = {
    r"a$\frac{x$ =cmd": r"a$\frac{x$ =cmd",
    r"\$a\\$b$c\$": r"\$a\\$b$c\$",
    "<b>&amp; -- ]]> (a\\( %s {x} _^": "<b>&amp; -- ]]> (a\\( %s {x} _^",
    "nut\x1b[31m\x07\x9b": "nut�[31m��",
    "a\nb\r\tc\u2028d": "a�b��c�d",
    "\u202eevil\u2066\u200b\ufeff": "�evil���",
    "caf\udce9": "caf�",
    "振动 🔩": "□□ □",
    "می\u200cخواهم": "می\u200cخواهم",
    "i$" * 120: ("i$" * 13)[:25] + "…" + "i$" * 12,
}


@pytest.fixture(scope="module")
def row() -> SweepResult:
    return sweep(points=31, amplitude="0.1:4")


def titled(result: SweepResult, name: str, picture: str = "speed") -> Figure:
    return map_figures(dataclasses.replace(result, title=name), [picture])[picture]


def assert_heading_is_inside(figure: Figure) -> None:
    heading = figure._suptitle  # type: ignore[attr-defined]
    with house_style():
        box = heading.get_window_extent(renderer_of(figure))
    width, height = figure.get_size_inches() * figure.dpi
    assert 0.02 * width < box.x0
    assert box.x1 < 0.98 * width
    assert 0.85 * height < box.y0
    assert box.y1 < height


def test_names_are_shown_as_they_are() -> None:
    for name, shown in SHOWN.items():
        assert figure_text(name, 50 + 50 * (len(name) < 50)) == shown.replace("$", r"\$")


@pytest.mark.parametrize("name", ["LONG NAME " * 25, "i$" * 120])
def test_headings_are_inside(row: SweepResult, name: str) -> None:
    figure = titled(row, name)
    first, second = figure.get_suptitle().split("\n")
    assert first.startswith("Mean conveying speed – ")
    assert second == r"$f$ = 15 Hz, $\alpha$ = 20°, $\mu_s$ = 0.74, $\mu_d$ = 0.57, $e$ = 0"
    assert_heading_is_inside(figure)


def test_names_in_files(row: SweepResult, tmp_path: Path) -> None:
    name = "<b>&amp; -- ]]> (a\\( %s -\x1b[31m\x07\x9b\n\udce9"
    name += r"a$\frac{x$ " + "long " * 50 + "振动 🔩\u202e\ufffe"
    told = r"<b>&amp; -- ]]> (a\( %s -�[31m����a$\frac{x$ " + "long " * 50 + "振动 🔩��"
    headline = f"Mean conveying speed – {told}"
    with coarse_pictures():
        figure = titled(row, name)
        for form in ("png", "svg"):
            save(figure, tmp_path / form, form, {"Software": "vibro"})
    with Image.open(tmp_path / "png") as image:
        image.load()
        assert image.info["Title"] == headline
    titles = [e.text for e in ElementTree.parse(tmp_path / "svg").iter() if e.tag.endswith("}title")]
    assert headline in titles
