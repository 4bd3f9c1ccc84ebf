"""Which part of a sweep is drawn."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from vibro.axes import parse_axis
from vibro.errors import InputError
from vibro.plots.view import choose_view
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from vibro.plots.view import View


DRAWN = {"amplitude": "1, 2", "frequency": "5:60", "restitution": "0:0.5"}


@pytest.mark.parametrize(
    ("held", "fixed", "at", "middle"),
    [
        ({"static_friction": "0.2,0.3,0.4,0.5"}, {"kinetic_friction": 0.35}, {}, {"static_friction": 0.5}),
        ({"friction_ratio": "0.8,0.9,1,1.1,1.2"}, {"static_friction": 0.45}, {}, {"friction_ratio": 0.9}),
        # Held in their order, each beside those held before it.
        (
            {"drive_angle": "10,30,50", "static_friction": "0.2,0.4,0.6", "kinetic_friction": "0.1,0.3,0.5"},
            {}, {"kinetic_friction": 0.5}, {"drive_angle": 30, "static_friction": 0.6},
        ),
        # What is asked for cannot be: the picture shows that.
        ({"static_friction": "0.2,0.3,0.4"}, {"kinetic_friction": 0.5}, {}, {"static_friction": 0.3}),
    ],
)  # fmt: skip
def test_axes_are_held_in_the_middle_of_what_can_be(
    held: dict[str, str], fixed: dict[str, float], at: dict[str, float], middle: dict[str, float]
) -> None:
    axes = axes_of(**DRAWN, **held)
    view = choose_view(axes, at=at, fixed=fixed)
    assert {name: axes[name].values[i] for name, i in view.held.items()} == middle | at


def shown(view: View) -> str:
    """Name x, y, curves and facets."""
    return " ".join(axis.name if axis else "-" for axis in (view.x, view.y, view.curves, view.facet))


LIST = "0.2,0.3,0.4"
LONG = ",".join(f"0.{i}" for i in range(21, 34))


@pytest.mark.parametrize(
    ("texts", "drawn"),
    [
        ({"frequency": "5:60", "amplitude": "1, 2"}, "frequency - amplitude -"),
        ({"amplitude": "1:2", "static_friction": LIST}, "amplitude - static_friction -"),
        ({"amplitude": "1:2", "static_friction": LONG}, "amplitude static_friction - -"),
        (
            {"amplitude": "1:2", "frequency": "50, 100", "static_friction": LIST},
            "amplitude - frequency static_friction",
        ),
        (
            {"amplitude": "1:2", "frequency": "5:60", "drive_angle": "10:40", "static_friction": LIST},
            "frequency amplitude - static_friction",
        ),
        (
            {"amplitude": "1:2", "frequency": "50, 100", "drive_angle": "10:40", "static_friction": LIST},
            "amplitude drive_angle - frequency",
        ),
        ({"amplitude": "1, 2", "static_friction": LIST}, "static_friction - amplitude -"),
        ({"amplitude": "1, 2", "frequency": "50, 100"}, "amplitude - frequency -"),
        (
            {"amplitude": "1, 2", "frequency": "50, 100", "static_friction": LIST},
            "static_friction - amplitude frequency",
        ),
    ],
)
def test_lists_are_curves_and_facets_but_no_axes_of_maps(texts: dict[str, str], drawn: str) -> None:
    view = choose_view(axes_of(**texts))
    assert shown(view) == drawn
    for axis in (view.x, view.curves):
        if axis is not None and axis.spacing == "list" and len(axis) <= 12:
            assert view.drawn[axis.name] == tuple(range(len(axis)))
    assert "static_friction" in view.drawn or texts.get("static_friction") != LIST


@pytest.mark.parametrize("text", ["10,20,30,40", "10:40:4", "10:40:20", "10:40:7:log", "-10:20:7"])
def test_a_value_that_is_not_on_its_axis_is_refused_with_those_that_are(text: str) -> None:
    axes = axes_of(amplitude="1:2", trough_angle=text)
    values = axes["trough_angle"].values
    for value in (0.3 * values[1] + 0.7 * values[2], values[-1] + 1.0, values[0] - 1.0, 1.001 * values[1]):
        with pytest.raises(InputError, match="trough angle = ") as caught:
            choose_view(axes, at={"trough_angle": value})
        nearest = re.findall(r"-?[\d.]+", caught.value.hint)
        found = [choose_view(axes, at={"trough_angle": float(v)}).held["trough_angle"] for v in nearest]
        above = int(np.searchsorted(values, value))
        assert found == [i for i in (above - 1, above) if 0 <= i < len(values)]


def axes_of(**texts: str) -> dict[str, Any]:
    return {name: parse_axis(texts[name], QUANTITIES[name]).axis(20) for name in QUANTITIES if name in texts}
