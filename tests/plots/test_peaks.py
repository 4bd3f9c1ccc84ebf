"""Marks of the fastest in pictures of speeds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.drawn import curve, legend, maps_of, only_map

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibro.results.sweep import SweepResult

pytestmark = pytest.mark.usefixtures("unarranged")

MARKS = ("fastest", "fastest_backwards")


def peak_notes(figure: Figure) -> list[str]:
    return [text for text in legend(figure) if text.startswith("fastest")]


def marked(figure: Figure) -> list[tuple[int, str]]:
    """Return the panels that have marks, and which."""
    lines = [(i, line.get_gid()) for i, axes in enumerate(maps_of(figure)) for line in axes.lines]
    return [(i, str(gid)) for i, gid in lines if gid in MARKS]


def test_a_map_marks_its_fastest_cell(nut: SweepResult, pictures: dict[str, Figure]) -> None:
    speed = 1e3 * nut.cycle.mean_velocity  # over amplitude and frequency
    i, j = np.unravel_index(np.nanargmax(speed), speed.shape)
    amplitude, frequency = nut.axes["amplitude"].values[i], nut.axes["frequency"].values[j]
    figure = pictures["speed"]
    np.testing.assert_array_equal(curve(only_map(figure), "fastest"), [[frequency, amplitude]])
    place = f"$A$ = {amplitude:.5g} mm, $f$ = {frequency:.5g} Hz"
    assert peak_notes(figure) == [f"fastest: {speed[i, j]:.5g} mm/s at {place}"]
    for name in ("regime", "traverse"):
        assert peak_notes(pictures[name]) == []


def test_of_facets_only_the_fastest_is_marked_and_its_value_told(facets: dict[str, Figure]) -> None:
    figure = facets["speed"]
    ((panel, _),) = marked(figure)
    (text,) = peak_notes(figure)
    assert text.endswith(f", {maps_of(figure)[panel].get_title()}")


def test_where_transport_reverses_the_fastest_backwards_is_marked_too(
    climb: SweepResult, climb_pictures: dict[str, Figure]
) -> None:
    slowest = np.nanmin(1e3 * climb.cycle.mean_velocity)
    _, backwards = peak_notes(climb_pictures["speed"])
    assert backwards.startswith(f"fastest backwards: \N{MINUS SIGN}{-slowest:.5g} mm/s at $A$ = ")
    assert marked(climb_pictures["speed"]) == [(0, "fastest"), (0, "fastest_backwards")]


def test_a_line_is_marked_at_its_top(one_axis: SweepResult, line_pictures: dict[str, Figure]) -> None:
    figure = line_pictures["speed"]
    speed = 1e3 * one_axis.cycle.mean_velocity
    top = int(np.nanargmax(speed))
    amplitude = one_axis.axes["amplitude"].values[top]
    assert peak_notes(figure) == [f"fastest: {speed[top]:.5g} mm/s at $A$ = {amplitude:.5g} mm"]
    np.testing.assert_allclose(curve(figure.axes[1], "fastest"), [[amplitude, speed[top]]], rtol=1e-15)
