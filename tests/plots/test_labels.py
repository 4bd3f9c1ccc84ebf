"""Where words are placed, on an empty map that is measured in pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.drawn import corners
from matplotlib.figure import Figure

from vibro.plots.labels import Labeller

if TYPE_CHECKING:
    from helpers.drawn import Floats
    from matplotlib.axes import Axes
    from matplotlib.text import Text

WIDTH, HEIGHT = 800, 600  # [px]
NAME = "a name of a line"
UNBROKEN = NAME.replace(" ", "\N{NO-BREAK SPACE}")
MARGIN = 3  # [px] around every label


@pytest.fixture
def axes() -> Axes:
    figure = Figure(figsize=(WIDTH / 100, HEIGHT / 100), dpi=100)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0, WIDTH), ylim=(0, HEIGHT))
    return axes


def size(axes: Axes, name: str = NAME) -> tuple[float, float]:
    """Width and height of a name with its margin."""
    text = axes.text(0, 0, name)
    box = text.get_window_extent()
    text.remove()
    return box.width + 2 * MARGIN, box.height + 2 * MARGIN


def straight(length: float, height: float = HEIGHT / 2) -> Floats:
    return np.array([[100.0, height], [100.0 + length, height]])


def word(axes: Axes) -> Text:
    (text,) = axes.texts
    return text


def middle(axes: Axes) -> Floats:
    return np.asarray(corners(word(axes))[:-1].mean(axis=0))


def member(rows: slice, columns: slice) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    """Region of a grid with a point every pixel."""
    cells = np.zeros((HEIGHT + 1, WIDTH + 1), np.bool_)
    cells[rows, columns] = True
    return cells


@pytest.mark.parametrize(("share", "fits"), [(1.2, False), (1.4, True)])
def test_a_line_stays_visible_beside_its_label(axes: Axes, share: float, fits: bool) -> None:
    assert Labeller(axes).along(NAME, [straight(share * size(axes)[0])]) == fits
    assert len(axes.texts) == fits


@pytest.mark.parametrize("cut", [250.0, 550.0])
def test_the_longest_free_stretch_is_taken_next_to_the_middle(axes: Axes, cut: float) -> None:
    labeller = Labeller(axes)
    labeller.avoid_lines([np.array([[cut, 0.0], [cut, HEIGHT]])])
    assert labeller.along("name", [straight(600.0)])
    longer = 1.0 if cut < 400.0 else -1.0
    assert 30.0 < longer * (middle(axes)[0] - cut) < 200.0


@pytest.mark.parametrize("falling", [False, True])
def test_no_word_is_upside_down(axes: Axes, falling: bool) -> None:
    for start, end in (((200.0, 150.0), (500.0, 450.0)), ((500.0, 450.0), (200.0, 150.0))):
        line = np.array([start, end]) * ([1.0, -1.0] if falling else [1.0, 1.0]) + [0.0, 600.0 * falling]
        assert Labeller(axes).along(NAME, [line])
    angles = [(text.get_rotation() + 180.0) % 360.0 - 180.0 for text in axes.texts]
    assert angles == pytest.approx([-45.0 if falling else 45.0] * 2)


@pytest.mark.parametrize("above", [True, False])
def test_a_name_beside_a_line_is_on_the_side_with_room(axes: Axes, above: bool) -> None:
    line, height = straight(600.0), size(axes)[1]
    other = straight(600.0, HEIGHT / 2 + (-0.8 if above else 0.8) * height)
    labeller = Labeller(axes)
    labeller.avoid_lines([line, other])
    assert labeller.along(NAME, [line], beside=True)
    assert 0.5 * height < (middle(axes)[1] - HEIGHT / 2) * (1.0 if above else -1.0) < 1.2 * height


def test_names_of_points_that_lie_together_are_apart(axes: Axes) -> None:
    labeller = Labeller(axes)
    points = [(400.0, 300.0), (410.0, 305.0), (405.0, 295.0)]
    labeller.avoid(np.array(points), radius=4.0)
    for point in points:
        labeller.beside("name", point)
    boxes = [text.get_window_extent() for text in axes.texts]
    assert not any(box.count_overlaps(boxes[:i]) for i, box in enumerate(boxes))
    assert all(np.hypot(*(np.array([box.x0, box.y0]) - points[0])) < 120.0 for box in boxes)


@pytest.mark.parametrize(("share", "fits"), [(0.9, False), (1.4, True)])
def test_a_region_has_room_for_its_name(axes: Axes, share: float, fits: bool) -> None:
    width, height = size(axes, UNBROKEN)
    for x in range(400, 408):
        rows = slice(round(300 - 0.5 * share * height), round(300 + 0.5 * share * height) + 1)
        columns = slice(round(x - 0.5 * share * width), round(x + 0.5 * share * width) + 1)
        assert Labeller(axes).in_region(UNBROKEN, member(rows, columns)) == fits
        if fits:
            np.testing.assert_allclose(middle(axes), [x, 300.0], atol=4.5)
            word(axes).remove()


@pytest.mark.parametrize(("share", "words"), [(1.6, "back-slip"), (0.9, "back-\nslip")])
def test_a_name_is_broken_where_only_that_makes_it_fit(axes: Axes, share: float, words: str) -> None:
    half = round(0.5 * share * size(axes, "back-slip")[0])
    assert Labeller(axes).in_region("back-slip", member(slice(None), slice(400 - half, 400 + half)))
    assert word(axes).get_text() == words
