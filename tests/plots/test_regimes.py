"""Regions, critical curves and their words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.drawn import GRAVITY, curve, drawn_regime, only_map, sweep

from vibro import Scene, Status, critical_loads, solve
from vibro.core.codes import is_answered
from vibro.plots import map_figures
from vibro.plots.style import CURVES
from vibro.plots.view import choose_view
from vibro.quantities import scene_fields, with_amplitude
from vibro.results.sweep import SweepResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

pytestmark = pytest.mark.usefixtures("unarranged")


def test_critical_curves_are_exact(pictures: dict[str, Figure], nut: SweepResult) -> None:
    for name in CURVES:
        frequency, amplitude = curve(only_map(pictures["regime"]), name).T
        load = amplitude * 1e-3 * (2 * math.pi * frequency) ** 2 / GRAVITY
        assert len(load) > 100
        np.testing.assert_allclose(load, getattr(nut.limits, name).item(), rtol=1e-12)


@pytest.mark.parametrize("changes", [
    {"amplitude": "0.1:3", "static_friction": "0.2:1", "kinetic_friction": 0.2},
    {"amplitude": "0.1:3", "trough_angle": "-25:25"},
    {"drive_angle": "1:60", "frequency": "5:60:log"},
    {"amplitude": 1.5, "static_friction": "0.1:1", "friction_ratio": "0.01:1"},
    {"acceleration": "0.3:5", "frequency": "5:60"},
    {"drive_speed": "20:300", "frequency": "5:60:log"},
], ids=str)  # fmt: skip
def test_colours_agree_with_the_solver_anywhere(changes: dict[str, Any]) -> None:
    result = sweep(**changes)
    axes = only_map(map_figures(result, ["regime"])["regime"])
    rng = np.random.default_rng(1)
    x, y = rng.uniform(*axes.get_xlim(), 1500), rng.uniform(*axes.get_ylim(), 1500)
    view = choose_view(result.axes)
    assert view.y is not None
    values = with_amplitude({**result.fixed, view.x.name: x, view.y.name: y})
    scene = Scene(**scene_fields(values))
    limits, cycle = critical_loads(scene), solve(scene)
    load = values["amplitude"] * 1e-3 * (2 * math.pi * values["frequency"]) ** 2 / GRAVITY
    near = np.zeros(x.shape, bool)  # linear interpolation between the grid's points may be this far off
    for name in ("forward_onset", "back_slip", "hop"):
        near |= np.abs(load / getattr(limits, name) - 1) < 2e-3
    answered = is_answered(cycle.status)
    checked = ~near & (answered | (cycle.status == Status.FLIGHT_NOT_MODELLED))
    assert checked.mean() > 0.6
    np.testing.assert_array_equal(drawn_regime(axes, x, y)[checked], cycle.regime[checked])
