"""Which part of a sweep is drawn."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import pytest

from vibro.axes import parse_axis
from vibro.errors import InputError
from vibro.plots import choose_view
from vibro.plots.view import check_drawable
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    pass


def test_frequency_across_amplitude_up() -> None:
    view = choose_view(grid_axes("amplitude", "frequency", "drive_angle"))
    assert view.y is not None
    assert view.facet is not None
    assert (view.x.name, view.y.name, view.facet.name) == ("frequency", "amplitude", "drive_angle")


@pytest.mark.parametrize(
    ("names", "x", "y"),
    [
        (("amplitude", "drive_angle"), "amplitude", "drive_angle"),
        (("static_friction", "kinetic_friction"), "static_friction", "kinetic_friction"),
        (("frequency", "friction_ratio", "trough_angle"), "frequency", "friction_ratio"),
    ],
)
def test_else_the_first_two_axes(names: tuple[str, ...], x: str, y: str) -> None:
    view = choose_view(grid_axes(*names))
    assert view.y is not None
    assert (view.x.name, view.y.name) == (x, y)


def test_one_axis_has_no_y() -> None:
    view = choose_view(grid_axes("drive_angle"))
    assert (view.x.name, view.y, view.facet, view.facet_indices) == ("drive_angle", None, None, (-1,))


def test_axes_that_are_asked_for() -> None:
    axes = grid_axes("amplitude", "frequency", "drive_angle")
    view = choose_view(axes, x="drive_angle", at={"frequency": 15})
    assert view.y is not None
    assert (view.x.name, view.y.name, view.facet) == ("drive_angle", "amplitude", None)
    assert axes["frequency"].values[view.held["frequency"]] == pytest.approx(15, abs=55 / 19 / 2)


def test_only_y_is_asked_for() -> None:
    view = choose_view(grid_axes("amplitude", "frequency"), y="frequency")
    assert view.x.name == "amplitude"


def test_more_than_three_axes_show_their_first_slice() -> None:
    view = choose_view(grid_axes("amplitude", "frequency", "drive_angle", "static_friction", "trough_angle"))
    assert view.held == {"static_friction": 0, "trough_angle": 0}
    assert view.drawn.keys() == {"drive_angle", "static_friction", "trough_angle"}


def test_facets_reach_from_end_to_end() -> None:
    view = choose_view(grid_axes("amplitude", "frequency", "drive_angle"))
    assert len(view.facet_indices) == 12
    assert (view.facet_indices[0], view.facet_indices[-1]) == (0, 19)
    assert len(set(view.facet_indices)) == 12


@pytest.mark.parametrize(
    ("x", "y", "at", "message"),
    [
        ("trough_angle", None, {}, "trough angle does not vary"),
        (None, "gravity", {}, "gravity does not vary"),
        ("amplitude", "amplitude", {}, "amplitude is asked for twice"),
        ("amplitude", None, {"amplitude": 1.0}, "amplitude is asked for twice"),
        (None, None, {"frequency": 100.0}, "frequency = 100 Hz lies outside"),
        (None, None, {"frequency": math.nan}, "frequency = nan Hz lies outside"),
        (None, None, {"amplitude": 1.0, "frequency": 15.0}, "nothing is left to draw"),
    ],
)
def test_what_cannot_be_drawn(x: str | None, y: str | None, at: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        choose_view(grid_axes("amplitude", "frequency"), x, y, at)
    assert caught.value.hint


def grid_axes(*names: str) -> dict[str, Any]:
    ranges = {
        "amplitude": "0.1:3",
        "frequency": "5:60",
        "drive_angle": "5:40",
        "static_friction": "0.6:0.9",
        "kinetic_friction": "0.1:0.5",
        "friction_ratio": "0.1:1",
        "trough_angle": "-5:5",
    }
    return {name: parse_axis(ranges[name], QUANTITIES[name]).axis(20) for name in names}


@pytest.mark.parametrize(
    ("text", "drawn"),
    [
        ("1e-100:1e100:5:log", True),
        ("1e-101:1:5:log", False),
        ("1:1e101:5", False),
        ("1e308:1.5e308:5", False),
    ],
)
def test_axes_that_no_picture_can_have(text: str, drawn: bool) -> None:
    view = choose_view({"amplitude": parse_axis(text, QUANTITIES["amplitude"]).axis(5)})
    if drawn:
        check_drawable(view)
        return
    with pytest.raises(InputError, match="no picture has such an axis") as caught:
        check_drawable(view)
    assert caught.value.hint == "-o - writes the table alone"
