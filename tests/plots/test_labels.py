"""Where words are placed, on an empty map that is measured in pixels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from drawn import corners
from matplotlib.figure import Figure

from vibro.plots.labels import Labeller

if TYPE_CHECKING:
    from drawn import Floats
    from matplotlib.axes import Axes
    from matplotlib.text import Text

WIDTH, HEIGHT = 800, 600  # [px]
NAME = "a name of a line"
UNBROKEN = NAME.replace(" ", "\N{NO-BREAK SPACE}")
MARGIN = 2  # [px] around every label


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


def arc(bend: float, length: float) -> Floats:
    """Arc of a circle whose stretches of a length leave their chords by as many pixels."""
    radius = length**2 / (8 * bend)
    turn = np.linspace(-1.0, 1.0, 200) * length / radius
    return np.column_stack([WIDTH / 2 + radius * np.sin(turn), 100 + radius * (1 - np.cos(turn))])


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


@pytest.mark.parametrize(("pitch", "fits"), [(2.0, False), (10.0, True)])
def test_no_label_on_a_line_that_winds(axes: Axes, pitch: float, fits: bool) -> None:
    # The flanks of its teeth are 2 px high, and over a chord of 1 the line is 1.41 or 1.02 long.
    teeth = np.arange(0, 400, pitch)
    line = np.column_stack([100 + teeth, 300 + 2.0 * (np.arange(len(teeth)) % 2)])
    assert Labeller(axes).along("name", [line]) == fits


@pytest.mark.parametrize(("share", "fits"), [(0.7, False), (0.5, True)])
def test_no_label_where_a_line_bends(axes: Axes, share: float, fits: bool) -> None:
    width, height = size(axes)
    assert Labeller(axes).along(NAME, [arc(share * height, width)]) == fits


@pytest.mark.parametrize("beside", [False, True])
def test_words_are_in_the_middle_of_a_line(axes: Axes, beside: bool) -> None:
    assert Labeller(axes).along(NAME, [straight(600.0)], beside=beside)
    x, y = middle(axes)
    assert x == pytest.approx(400.0, abs=10.0)
    away = abs(y - HEIGHT / 2)
    assert away == pytest.approx(0.5 * size(axes)[1] + 3.5 if beside else 0.0, abs=1.0)


def test_straight_and_level_stretches_are_better(axes: Axes) -> None:
    x = np.linspace(50.0, 750.0, 300)
    line = np.column_stack([x, 100.0 + 400.0 * np.exp(-x / 120.0)])  # steep, bent, then level
    assert Labeller(axes).along(NAME, [line])
    assert middle(axes)[0] > 400.0
    assert math.sin(math.radians(word(axes).get_rotation())) == pytest.approx(0.0, abs=0.1)


def test_the_outer_side_of_a_bend_is_better(axes: Axes) -> None:
    width, height = size(axes)
    arcs = [arc(share * height, width) for share in np.linspace(0.1, 0.5, 9)]
    upside_down = [np.array([0.0, HEIGHT]) + np.array([1.0, -1.0]) * line for line in arcs]
    for line, side in [*((line, -1.0) for line in arcs), *((line, 1.0) for line in upside_down)]:
        labeller = Labeller(axes)
        labeller.avoid_line(line)
        assert labeller.along(NAME, [line], beside=True)
        assert side * (middle(axes)[1] - line[100, 1]) > 0.0
        word(axes).remove()


@pytest.mark.parametrize(("heights", "moves"), [(2.0, True), (5.0, False)])
def test_clear_places_are_better(axes: Axes, heights: float, moves: bool) -> None:
    labeller = Labeller(axes)
    above = HEIGHT / 2 + (0.5 + heights) * size(axes)[1]
    labeller.avoid_line(np.array([[390.0, above], [410.0, above]]))
    assert labeller.along(NAME, [straight(600.0)])
    assert (abs(middle(axes)[0] - 400.0) > 50.0) == moves


@pytest.mark.parametrize("falling", [False, True])
def test_no_word_is_upside_down(axes: Axes, falling: bool) -> None:
    for start, end in (((200.0, 150.0), (500.0, 450.0)), ((500.0, 450.0), (200.0, 150.0))):
        line = np.array([start, end]) * ([1.0, -1.0] if falling else [1.0, 1.0]) + [0.0, 600.0 * falling]
        assert Labeller(axes).along(NAME, [line])
    angles = [(text.get_rotation() + 180.0) % 360.0 - 180.0 for text in axes.texts]
    assert angles == pytest.approx([-45.0 if falling else 45.0] * 2)


@pytest.mark.parametrize(("gap", "fits"), [(2.0, False), (4.5, True)])
def test_words_keep_their_distance_to_lines(axes: Axes, gap: float, fits: bool) -> None:
    labeller = Labeller(axes)
    labeller.avoid_line(straight(600.0, HEIGHT / 2 + 0.5 * size(axes)[1] + gap))
    assert labeller.along(NAME, [straight(600.0)]) == fits


@pytest.mark.parametrize(("gap", "fits"), [(3.0, False), (6.0, True)])
def test_words_keep_their_distance_to_the_frame(axes: Axes, gap: float, fits: bool) -> None:
    text_height = size(axes)[1] - 2 * MARGIN
    assert Labeller(axes).along(NAME, [straight(600.0, 0.5 * text_height + gap)]) == fits


def test_a_line_that_only_cuts_a_corner_is_avoided(axes: Axes) -> None:
    width, height = size(axes)
    line = straight(1.31 * width)  # with hardly another place on it
    corner = line.mean(axis=0) + np.array([0.3 * width, 0.5 * height])
    for shift in np.linspace(0.0, 4.0, 9):  # wherever the points lie that stand for it
        labeller = Labeller(axes)
        labeller.avoid_line(corner + np.array([[-60.0 - shift, 60.0 + shift], [60.0, -60.0]]))
        assert not labeller.along(NAME, [line])


def test_a_gap_that_is_just_wide_enough_is_found(axes: Axes) -> None:
    gap = 0.5 * size(axes)[0] + 11.0
    for place in np.linspace(250.0, 550.0, 31):
        labeller = Labeller(axes)
        for start, end in ((0.0, place - gap), (place + gap, WIDTH)):
            labeller.avoid_line(np.array([[start, HEIGHT / 2], [end, HEIGHT / 2]]))
        assert labeller.along(NAME, [straight(600.0)])
        assert middle(axes)[0] == pytest.approx(place, abs=9.0)
        word(axes).remove()


def test_words_stay_out_of_regions(axes: Axes) -> None:
    labeller = Labeller(axes)
    labeller.avoid_region(member(slice(None), slice(0, 500)))
    assert labeller.along("name", [straight(600.0)])
    assert (corners(word(axes))[:, 0] > 500.0).all()
    for height in range(100, 150, 4):  # wherever the points lie that stand for it
        assert not labeller.along("name", [straight(350.0, height)])


@pytest.mark.parametrize(("share", "fits"), [(1.3, False), (1.6, True)])
def test_a_region_has_room_for_its_name(axes: Axes, share: float, fits: bool) -> None:
    width, height = size(axes, UNBROKEN)
    for x in range(400, 408):
        rows = slice(round(300 - 0.5 * share * height), round(300 + 0.5 * share * height) + 1)
        columns = slice(round(x - 0.5 * share * width), round(x + 0.5 * share * width) + 1)
        assert Labeller(axes).in_region(UNBROKEN, member(rows, columns)) == fits
        if fits:
            np.testing.assert_allclose(middle(axes), [x, 300.0], atol=4.5)
            word(axes).remove()


def test_two_names_in_a_region_are_apart(axes: Axes) -> None:
    labeller = Labeller(axes)
    for name in ("one", "other"):
        assert labeller.in_region(name, member(slice(None), slice(None)))
    one, other = (text.get_window_extent() for text in axes.texts)
    assert not one.overlaps(other)


@pytest.mark.parametrize(("share", "words"), [(1.6, "back-slip"), (0.9, "back-\nslip")])
def test_a_name_is_broken_where_only_that_makes_it_fit(axes: Axes, share: float, words: str) -> None:
    half = round(0.5 * share * size(axes, "back-slip")[0])
    assert Labeller(axes).in_region("back-slip", member(slice(None), slice(400 - half, 400 + half)))
    assert word(axes).get_text() == words


def test_a_name_is_where_its_region_is_widest(axes: Axes) -> None:
    width, height = size(axes)
    x, y = np.meshgrid(np.arange(WIDTH + 1), np.arange(HEIGHT + 1))
    ellipse = np.hypot((x - 600.0) / width, (y - 300.0) / height) < 1.2
    corridor = (x < 600.0) & (np.abs(y - 300.0) < 0.8 * height)
    assert Labeller(axes).in_region(UNBROKEN, ellipse | corridor)
    assert math.dist(middle(axes), (600.0, 300.0)) < 30.0


def test_a_little_more_room_does_not_draw_a_name_into_a_corner(axes: Axes) -> None:
    x, y = np.meshgrid(np.arange(WIDTH + 1), np.arange(HEIGHT + 1))
    band = np.abs(y - 300.0) < 80.0 + 2.0 * x / WIDTH
    assert Labeller(axes).in_region(NAME, band)
    assert middle(axes)[0] == pytest.approx(400.0, abs=60.0)
