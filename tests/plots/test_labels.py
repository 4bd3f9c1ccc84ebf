"""Where words are placed, on an empty map that is measured in pixels."""

from __future__ import annotations

import math
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


@pytest.mark.parametrize(("share", "fits"), [(0.7, False), (0.4, True)])
def test_no_label_where_a_line_bends(axes: Axes, share: float, fits: bool) -> None:
    width, height = size(axes)
    assert Labeller(axes).along(NAME, [arc(share * height, width)]) == fits


def test_words_are_in_the_middle_of_a_line_and_on_it(axes: Axes) -> None:
    width, height = size(axes)
    for line in (straight(600.0), arc(0.4 * height, width)):
        assert Labeller(axes).along(NAME, [line])
        x, y = middle(axes)
        assert x == pytest.approx(400.0, abs=10.0)
        assert abs(y - np.interp(x, line[:, 0], line[:, 1])) < 0.3 * height
        word(axes).remove()


def test_straight_stretches_are_taken(axes: Axes) -> None:
    x = np.linspace(50.0, 750.0, 300)
    line = np.column_stack([x, 300.0 + np.where(x < 500.0, 20.0 * np.sin(x / 12.0), 0.0)])
    assert Labeller(axes).along("name", [line])
    assert middle(axes)[0] > 500.0


def test_the_first_piece_with_room_is_taken(axes: Axes) -> None:
    pieces = [straight(0.5 * size(axes)[0], 100.0), straight(600.0, 200.0), straight(600.0, 300.0)]
    assert Labeller(axes).along(NAME, pieces)
    assert middle(axes)[1] == pytest.approx(200.0, abs=1.0)


@pytest.mark.parametrize("cut", [250.0, 550.0])
def test_the_longest_free_stretch_is_taken_next_to_the_middle(axes: Axes, cut: float) -> None:
    labeller = Labeller(axes)
    labeller.avoid_lines([np.array([[cut, 0.0], [cut, HEIGHT]])])
    assert labeller.along("name", [straight(600.0)])
    longer = 1.0 if cut < 400.0 else -1.0
    assert 50.0 < longer * (middle(axes)[0] - cut) < 200.0


@pytest.mark.parametrize("falling", [False, True])
def test_no_word_is_upside_down(axes: Axes, falling: bool) -> None:
    for start, end in (((200.0, 150.0), (500.0, 450.0)), ((500.0, 450.0), (200.0, 150.0))):
        line = np.array([start, end]) * ([1.0, -1.0] if falling else [1.0, 1.0]) + [0.0, 600.0 * falling]
        assert Labeller(axes).along(NAME, [line])
    angles = [(text.get_rotation() + 180.0) % 360.0 - 180.0 for text in axes.texts]
    assert angles == pytest.approx([-45.0 if falling else 45.0] * 2)


@pytest.mark.parametrize(("gap", "fits"), [(0.0, False), (5.0, True)])
def test_words_keep_clear_of_other_lines(axes: Axes, gap: float, fits: bool) -> None:
    for shift in np.linspace(0.0, 4.0, 9):  # wherever the cells lie
        labeller = Labeller(axes)
        line = straight(600.0, HEIGHT / 2 + shift)
        other = straight(600.0, HEIGHT / 2 + shift + 0.5 * size(axes)[1] + gap)
        labeller.avoid_lines([line, other])
        assert labeller.along(NAME, [line]) == fits
        for text in list(axes.texts):
            text.remove()


def test_lines_are_forgotten(axes: Axes) -> None:
    labeller = Labeller(axes)
    line = straight(600.0)
    other = straight(600.0, HEIGHT / 2 + 8.0)
    labeller.avoid_lines([line, other])
    assert not labeller.along(NAME, [line])
    labeller.forget_lines([other])
    assert labeller.along(NAME, [line])


def test_two_lines_in_one_place_have_one_name(axes: Axes) -> None:
    labeller = Labeller(axes)
    line = straight(600.0)
    labeller.avoid_lines([line, line])
    assert not labeller.along(NAME, [line])
    assert labeller.along(NAME, [line, line])


@pytest.mark.parametrize(("gap", "fits"), [(1.0, False), (8.0, True)])
def test_words_stay_on_the_map(axes: Axes, gap: float, fits: bool) -> None:
    text_height = size(axes)[1] - 2 * MARGIN
    assert Labeller(axes).along(NAME, [straight(600.0, 0.5 * text_height + gap)]) == fits


def test_a_line_may_leave_the_map(axes: Axes) -> None:
    labeller = Labeller(axes)
    line = np.array([[-300.0, 300.0], [500.0, 300.0]])
    labeller.avoid_lines([line])
    assert labeller.along(NAME, [line])
    assert (corners(word(axes))[:, 0] > 0.0).all()


def test_a_line_that_only_cuts_a_corner_is_avoided(axes: Axes) -> None:
    width, height = size(axes)
    line = straight(1.31 * width)  # with hardly another place on it
    corner = line.mean(axis=0) + np.array([0.3 * width, 0.4 * height])
    for shift in np.linspace(0.0, 4.0, 9):  # wherever the cells lie
        labeller = Labeller(axes)
        labeller.avoid_lines([corner + np.array([[-60.0 - shift, 60.0 + shift], [60.0, -60.0]])])
        assert not labeller.along(NAME, [line])


def test_words_keep_clear_of_points(axes: Axes) -> None:
    for x in range(300, 500, 7):
        labeller = Labeller(axes)
        labeller.avoid(np.array([[x, HEIGHT / 2]]), radius=9.0)
        assert labeller.along("name", [straight(600.0)])
        assert (np.abs(corners(word(axes))[:, 0] - x) > 9.0).all()
        word(axes).remove()


def test_a_gap_that_is_just_wide_enough_is_found(axes: Axes) -> None:
    gap = 0.5 * size(axes)[0] + 11.0
    for place in np.linspace(250.0, 550.0, 31):
        labeller = Labeller(axes)
        ends = (0.0, place - gap), (place + gap, WIDTH)
        labeller.avoid_lines([np.array([[x, HEIGHT / 2 + 4.0] for x in pair]) for pair in ends])
        assert labeller.along(NAME, [straight(600.0)])
        assert middle(axes)[0] == pytest.approx(place, abs=12.0)
        word(axes).remove()


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
    ellipse = np.hypot((x - 600.0) / width, (y - 300.0) / height) < 2.0
    corridor = (x < 600.0) & (np.abs(y - 300.0) < 0.8 * height)
    assert Labeller(axes).in_region(UNBROKEN, ellipse | corridor)
    assert math.dist(middle(axes), (600.0, 300.0)) < 30.0


def test_a_little_more_room_does_not_draw_a_name_into_a_corner(axes: Axes) -> None:
    x, y = np.meshgrid(np.arange(WIDTH + 1), np.arange(HEIGHT + 1))
    band = np.abs(y - 300.0) < 80.0 + 2.0 * x / WIDTH
    assert Labeller(axes).in_region(NAME, band)
    assert middle(axes)[0] == pytest.approx(400.0, abs=60.0)
