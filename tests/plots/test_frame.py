"""Axes, units, headings, the operating point."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np
import pytest
from helpers.drawn import OWN, curve, legend, maps_of, only_map, said, sweep
from matplotlib.figure import Figure

from vibro.plots import map_figures
from vibro.plots.frame import make_logarithmic, renderer_of
from vibro.plots.style import house_style
from vibro.results.sweep import SweepResult


def test_axes_have_names_units_and_the_range_of_the_sweep(pictures: dict[str, Figure]) -> None:
    axes = only_map(pictures["regime"])
    assert axes.get_xlabel() == "frequency $f$ [Hz]"
    assert axes.get_ylabel() == "amplitude $A$ [mm]"
    assert axes.get_xlim() == (5, 60)
    assert axes.get_ylim() == (0.1, 3)
    assert curve(axes, "operating point").tolist() == [[15, 1]]
    assert "operating point" in legend(pictures["regime"])


def test_heading_says_what_of_what_and_where(pictures: dict[str, Figure]) -> None:
    heading = pictures["traverse"].get_suptitle()
    assert heading.startswith("Traverse time over 600 mm – a sweep\n")
    for part in (r"$\alpha$ = 20°", r"$\mu_s$ = 0.74", r"$\mu_d$ = 0.57"):
        assert part in heading
    assert r"\beta" not in heading  # a level trough goes without saying


def test_a_logarithmic_axis_of_many_decades_has_powers_of_ten() -> None:
    axes = Figure().add_subplot()
    make_logarithmic(axes.xaxis, 0.01, 100.0)
    make_logarithmic(axes.yaxis, 0.1, 10.0)
    np.testing.assert_allclose(axes.get_xticks(), 10.0 ** np.round(np.log10(axes.get_xticks())))
    assert 2.0 in axes.get_yticks()


@pytest.mark.parametrize(
    "changes",
    [
        {"amplitude": "1:1.00001:log", "frequency": "15:15.00001:log"},
        {"frequency": "15:15.00001"},
    ],
    ids=str,
)
def test_numbers_along_axes_are_full_and_apart(changes: dict[str, Any]) -> None:
    result = sweep(points=31, **changes)
    figure = map_figures(result, ["speed"])["speed"]
    renderer = renderer_of(figure)
    with house_style():
        figure.draw(renderer)
    for axis in [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]:
        assert axis.get_offset_text().get_text() == ""
        shown = [label for label in axis.get_ticklabels() if label.get_visible() and label.get_text()]
        boxes = [label.get_window_extent(renderer) for label in shown]
        assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))
    ends = result.axes["frequency"].values[[0, -1]]
    bottom = maps_of(figure)[-1]
    ticks = [float(label.get_text()) for label in bottom.get_xticklabels()]
    within = [tick for tick in ticks if ends[0] - 1e-12 <= tick <= ends[1] + 1e-12]
    assert len(set(within)) >= 2
    assert all("e" not in label.get_text() for label in bottom.get_xticklabels())


@pytest.mark.parametrize(
    "own", [None, OWN | {"static_friction": 0.8}, OWN | {"amplitude": 4.0}], ids=["none", "held", "outside"]
)
@pytest.mark.usefixtures("unarranged")
def test_no_operating_point_elsewhere(nut: SweepResult, own: dict[str, float] | None) -> None:
    figure = map_figures(dataclasses.replace(nut, operating_point=own, length=None), ["regime"])["regime"]
    assert "operating point" not in said(figure)
