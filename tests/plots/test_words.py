"""What is written on whole pictures: apart, each name on its own line, and a legend of what is to be seen."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.drawn import OWN, corners, curve, legend, maps_of, pictures_of, sweep, unarranged, words
from matplotlib.path import Path as Outline

from vibro.plots.style import CURVES

if TYPE_CHECKING:
    from helpers.drawn import Floats
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LABELS = {style.label: name for name, style in CURVES.items()}
POINT = "operating point"


@pytest.fixture(scope="module")
def parallel() -> dict[str, Figure]:
    """Curves that are straight, parallel and close together."""
    with unarranged():
        return pictures_of(sweep(own=OWN, points=121, amplitude="0.01:10:log", frequency="5:200:log"))


@pytest.fixture(scope="module")
def joined() -> dict[str, Figure]:
    """Two curves in one place."""
    ranges: dict[str, Any] = {"amplitude": "0.1:3", "drive_angle": "5:60"}
    return pictures_of(sweep(static_friction=0.4, kinetic_friction=0.02, points=121, **ranges))


@pytest.fixture(params=["pictures", "climb_pictures", "friction_pictures", "facets", "parallel", "joined"])
def figures(request: pytest.FixtureRequest) -> list[Figure]:
    return list(request.getfixturevalue(request.param).values())


def pixels(axes: Axes, gid: str) -> Floats:
    """Return points on a line in pixels, closer together than its letters are high."""
    points = axes.transData.transform(curve(axes, gid))
    steps = [np.linspace(one, other, 20) for one, other in itertools.pairwise(points)]
    return np.concatenate([step for step in steps if np.hypot(*(step[-1] - step[0])) < 60.0])


def curves_of(axes: Axes) -> list[str]:
    return [str(line.get_gid()) for line in axes.lines if line.get_gid() in CURVES]


def test_words_are_apart_on_the_map_and_off_the_operating_point(figures: list[Figure]) -> None:
    for axes in itertools.chain.from_iterable(map(maps_of, figures)):
        outlines = {text: corners(text) for text in axes.texts}
        box = axes.get_window_extent()
        for text, outline in outlines.items():
            assert (outline >= [box.x0, box.y0]).all(), text
            assert (outline <= [box.x1, box.y1]).all(), text
        paths = [Outline(outline) for outline in outlines.values()]
        for line in axes.lines:
            if line.get_gid() == POINT:
                (middle,) = axes.transData.transform(curve(axes, POINT))
                figure: Any = axes.figure
                paths.append(Outline.circle(middle, 0.5 * line.get_markersize() * figure.dpi / 72.0))
        for first, second in itertools.combinations(paths, 2):
            assert not first.intersects_path(second, filled=True), [text.get_text() for text in outlines]


def test_names_of_curves_lie_beside_their_own_curve_and_on_none(figures: list[Figure]) -> None:
    for axes in itertools.chain.from_iterable(map(maps_of, figures)):
        lines = {name: pixels(axes, name) for name in curves_of(axes)}
        for text in axes.texts:
            box = corners(text)
            assert not any(Outline(box).contains_points(line).any() for line in lines.values()), text
            if text.get_text() in LABELS:
                middle = box[:-1].mean(axis=0)
                apart = {n: np.hypot(*(line - middle).T).min() for n, line in lines.items()}
                height = np.hypot(*(box[1:] - box[:-1]).T).min()
                assert apart[LABELS[text.get_text()]] < 1.5 * height + 12.0


def test_every_curve_is_named_once(figures: list[Figure]) -> None:
    for figure in figures:
        explained = legend(figure)
        for axes in maps_of(figure):
            written = [text for text in words(axes) if text in LABELS]
            assert len(written) == len(set(written))
            for name in curves_of(axes):
                assert (CURVES[name].label in explained) != (CURVES[name].label in written), name


def test_every_contour_that_is_seen_has_its_number_on_it(figures: list[Figure]) -> None:
    for axes in itertools.chain.from_iterable(map(maps_of, figures)):
        numbers: dict[str, list[Outline]] = {}
        for text in axes.texts:
            numbers.setdefault(text.get_text().replace("\N{MINUS SIGN}", "-"), []).append(
                Outline(corners(text))
            )
        contours = [line for line in axes.lines if str(line.get_gid()).startswith("contour")]
        assert sum(line.get_visible() for line in contours) >= 0.5 * len(contours)
        for line in contours:
            gid = str(line.get_gid())
            if line.get_visible():
                outlines = numbers[gid.split()[1]]
                assert all(outline.contains_points(pixels(axes, gid)).any() for outline in outlines), gid
