"""Pictures of cells that are solved already: they show all that matters of them, and no more than is seen."""

from __future__ import annotations

from typing import Any

import numpy as np
from helpers.drawn import colours_of, image_of
from helpers.pixels import pixels

import vibro
from vibro.plots import map_figures, results_drawn
from vibro.results.steady import RESULTS
from vibro.results.sweep import SweepResult
from vibro.sweeps import run

FRICTION: dict[str, Any] = {"static_friction": 0.74, "kinetic_friction": 0.57}
LINE: dict[str, Any] = {"drive_angle_deg": 20, **FRICTION}
ELLIPSE: dict[str, Any] = {"normal_amplitude_mm": 0.4, "normal_phase_deg": 40, **FRICTION}


def test_pictures_need_no_other_results() -> None:
    t = vibro.sweep(
        along_amplitude_mm="0.1:3:15", frequency_hz="5:40:15", **ELLIPSE, normal_amplitude_2_mm=0.2,
        trough_length_mm=600,
    )  # fmt: skip
    grid = t._grid
    whole = SweepResult(
        grid.axes, grid.fixed, t.cycle, run.limits_of(grid.values()), grid.length, None, ""
    )  # of which a picture may show whatever it likes
    assert len(results_drawn(["flight"], has_limits=True, of_starts=False)) < len(RESULTS)
    every = map_figures(whole, ["flight"])["flight"]
    np.testing.assert_array_equal(pixels(t.draw("flight")), pixels(every))


def test_every_cell_has_the_colour_of_its_speed_where_it_lies() -> None:
    amplitudes = [*np.linspace(0.5, 1.1, 13), 1.5, 3, 8]
    t = vibro.sweep(amplitude_mm=amplitudes, frequency_hz="15:30:4", **LINE)
    axes = t.draw("speed").axes[0]
    image = image_of(axes)
    left, right, low, high = image.get_extent()
    drawn = image.get_array()
    rows, columns = drawn.shape[:2]
    speeds = 1e3 * t.cycle.mean_velocity
    seen = 0
    for (i, j), speed in np.ndenumerate(speeds):
        place = t.axes["frequency_hz"][j], t.axes["amplitude_mm"][i]
        across, up = axes.transAxes.inverted().transform(axes.transData.transform(place))
        row, column = (up - low) / (high - low) * rows, (across - left) / (right - left) * columns
        if speed > image.norm.vmin:  # rests are covered, and slow cells have the colour of the scale's foot
            seen += 1
            colour = drawn[int(row), int(column)]
            np.testing.assert_array_equal(colour, colours_of(axes, np.asarray(speed)), err_msg=str(place))
    assert seen > 0.7 * speeds.size
