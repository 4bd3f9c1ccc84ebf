"""Facets of a third axis."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.drawn import GRAVITY, curve, legend, maps_of, sweep

from vibro.plots import map_figures
from vibro.plots.style import CURVES, REGIME_COLOURS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

pytestmark = pytest.mark.usefixtures("unarranged")


def test_a_map_for_every_value(facets: dict[str, Figure]) -> None:
    for figure in facets.values():
        titles = [axes.get_title() for axes in maps_of(figure)]
        assert titles == [r"$\alpha$ = 10°", r"$\alpha$ = 20°", r"$\alpha$ = 30°"]
        assert r"\alpha" not in figure.get_suptitle()
    maps = maps_of(facets["regime"])
    assert [axes.get_ylabel() for axes in maps] == ["amplitude $A$ [mm]", "", ""]
    marked = [any(line.get_gid() == "operating point" for line in axes.lines) for axes in maps]
    assert marked == [False, True, False]


def test_every_map_has_its_own_curves(facets: dict[str, Figure]) -> None:
    for axes, angle in zip(maps_of(facets["regime"]), (10, 20, 30), strict=True):
        frequency, amplitude = curve(axes, "hop").T
        load = amplitude * 1e-3 * (2 * math.pi * frequency) ** 2 / GRAVITY
        np.testing.assert_allclose(load, 1 / math.sin(math.radians(angle)), rtol=1e-12)


def test_one_colour_scale_and_one_legend(facets: dict[str, Figure]) -> None:
    scales = {(i.norm.vmin, i.norm.vmax) for a in maps_of(facets["speed"]) for i in a.images}
    assert len(scales) == 1
    assert {style.label for style in CURVES.values()} <= set(legend(facets["speed"]))
    assert {regime.label for regime in REGIME_COLOURS} <= set(legend(facets["regime"]))


def test_held_axes_are_in_the_heading() -> None:
    result = sweep(
        at={"drive_angle": 30},
        points=31,
        amplitude="0.2:3",
        frequency="10:50",
        drive_angle="10,20,30",
        trough_angle="0.0,5",
    )
    figure = map_figures(result, ["regime"])["regime"]
    assert r"$\alpha$ = 30°" in figure.get_suptitle()
    assert [axes.get_title() for axes in maps_of(figure)] == [r"$\beta$ = 0°", r"$\beta$ = 5°"]
