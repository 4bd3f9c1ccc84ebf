"""Hatches: no answer, two cycles."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.drawn import legend, only_map, patch, path_of, pictures_of, said, sweep, words
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba

from vibro import Status
from vibro.plots import map_figures
from vibro.plots.style import AVERAGED_LABEL, COEXISTS_LABEL, ERROR_LABEL, MINORITY_LABEL, NO_ANSWER_HATCH
from vibro.results.sweep import SweepResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

pytestmark = pytest.mark.usefixtures("unarranged")


def test_infeasible_half_is_cut_along_its_exact_boundary(friction_pictures: dict[str, Figure]) -> None:
    for figure in friction_pictures.values():
        axes = only_map(figure)
        found = patch(axes, "infeasible")
        assert found is not None
        assert found.get_hatch() == NO_ANSWER_HATCH[Status.INFEASIBLE]
        static = np.linspace(0.21, 0.99, 100)
        above = np.column_stack([static, static + 1e-6])
        below = np.column_stack([static, static - 1e-6])
        assert found.get_path().contains_points(above).all()
        assert not found.get_path().contains_points(below).any()
        assert "infeasible" in words(axes)


def test_unmodelled_flight_is_hatched_but_for_the_regimes() -> None:
    result = sweep(points=121, length=600, amplitude="0.1:3", frequency="5:60", flight=False)
    pictures = pictures_of(result)
    assert patch(only_map(pictures["regime"]), "flight not modelled") is None
    assert path_of(only_map(pictures["speed"]), "flight not modelled").contains_point((30, 2))
    assert "flight not modelled" in said(pictures["traverse"])


@pytest.mark.parametrize(
    "status", [Status.RUNAWAY, Status.INDETERMINATE, Status.UNRESOLVED, Status.FLIGHT_NOT_MODELLED]
)
def test_cells_of_every_status(nut: SweepResult, status: Status) -> None:
    codes = np.full(nut.shape, Status.OK, np.int8)
    codes[100:200, 150:250] = status  # amplitude 0.9 ... 1.7 mm, frequency 28 ... 43 Hz
    velocity = np.where(codes == status, np.nan, 0.05)
    cycle = dataclasses.replace(nut.cycle, status=codes, mean_velocity=velocity)
    figure = map_figures(dataclasses.replace(nut, cycle=cycle, length=None), ["speed"])["speed"]
    label = status.label.replace("-", " ")
    found = patch(only_map(figure), label)
    assert found is not None
    assert found.get_hatch() == NO_ANSWER_HATCH[status]
    inside = found.get_path().contains_points([(30, 1.3), (20, 1.3), (30, 0.8), (30, 1.8), (45, 1.3)])
    assert inside.tolist() == [True, False, False, False, False]
    assert label in said(figure)


def test_coexisting_cycles_are_hatched_over_the_colours() -> None:
    ranges: dict[str, Any] = {"amplitude": "0.1:3", "drive_angle": "5:60"}
    result = sweep(points=101, static_friction=0.4, kinetic_friction=0.02, **ranges)
    assert (result.cycle.coexists == 1).any()
    for figure in pictures_of(result).values():
        found = patch(only_map(figure), COEXISTS_LABEL)
        assert found is not None
        assert found.get_hatch() == "..."
        assert to_rgba(found.get_facecolor())[3] == 0
        columns, rows = np.nonzero(result.cycle.coexists == 1)
        amplitude, angle = (axis.values for axis in result.axes.values())
        points = np.column_stack([amplitude[columns], angle[rows]])
        assert found.get_path().contains_points(points).mean() > 0.98  # those on its edge are cut in half
        assert COEXISTS_LABEL in legend(figure)


def test_cells_where_most_parts_move_otherwise_are_hatched_in_place_of_other_cycles(nut: SweepResult) -> None:
    for share, hatched in ((0.5, False), (np.nextafter(0.5, 0.0), True), (0.0, True)):
        shares, coexists = np.ones(nut.shape), np.ones(nut.shape, np.int8)
        shares[:, 200:210] = share
        cycle = dataclasses.replace(nut.cycle, coexists=coexists, share=shares)
        figures = pictures_of(dataclasses.replace(nut, cycle=cycle, length=None))
        for figure in figures.values():
            found = patch(only_map(figure), MINORITY_LABEL)
            assert (found is not None) == (MINORITY_LABEL in legend(figure)) == hatched
            assert patch(only_map(figure), COEXISTS_LABEL) is None
            if found is not None:
                amplitude, frequency = (axis.values for axis in nut.axes.values())
                inside = found.get_path().contains_points(
                    [(frequency[205], amplitude[150]), (20.0, amplitude[150])]
                )
                assert inside.tolist() == [True, False]


def test_means_of_irregular_motion_are_dots_beside_a_line() -> None:
    result = sweep(points=201, amplitude="1:4")
    codes = result.cycle.status.copy()
    codes[50:60] = Status.AVERAGED
    error = np.where(codes == Status.AVERAGED, 0.003, 0.0)
    cycle = dataclasses.replace(result.cycle, status=codes, mean_velocity_error=error)
    figure = map_figures(dataclasses.replace(result, cycle=cycle), ["speed"])["speed"]
    drawn = {line.get_gid(): line for line in figure.axes[1].lines}
    speed = 1e3 * result.cycle.mean_velocity
    np.testing.assert_array_equal(np.asarray(drawn[AVERAGED_LABEL].get_ydata()), speed[50:60])
    line = np.asarray(drawn["numbers"].get_ydata(), float)
    assert not np.isin(speed[50:60], line).any()
    assert np.isin(speed[:50], line).all()
    assert AVERAGED_LABEL in legend(figure)
    (bars,) = [bars for bars in figure.axes[1].collections if bars.get_gid() == ERROR_LABEL]
    assert isinstance(bars, LineCollection)
    ends = np.array([segment[:, 1] for segment in bars.get_segments()])
    np.testing.assert_allclose(ends, speed[50:60, np.newaxis] + [-3.0, 3.0])
    assert ERROR_LABEL in legend(figure)
