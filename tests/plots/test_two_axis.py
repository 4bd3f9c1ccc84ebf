"""Pictures of elliptical drives: axes, ticks, and boundaries of critical loads that vary over the map."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.drawn import only_map, words

import vibro
from vibro import Regime
from vibro.plots.fields import BEGINS_AT, Fields
from vibro.plots.view import choose_view, panels
from vibro.results.sweep import SweepResult
from vibro.sweeps.grid import scene_of

if TYPE_CHECKING:
    from vibro.sweeps.whole import Sweep

pytestmark = pytest.mark.usefixtures("unarranged")

FRICTION: dict[str, Any] = {"static_friction": 0.4, "kinetic_friction": 0.3}


@pytest.fixture(scope="module")
def phases() -> Sweep:
    """The regimes of a drive over its amplitude along the trough and its phase, on a climb."""
    return vibro.sweep(
        along_amplitude_mm="0.01:0.6:121", normal_amplitude_mm=0.3, normal_phase_deg="-180:180:121",
        frequency_hz=15, trough_angle_deg=4, **FRICTION,
    )  # fmt: skip


def fields_of(swept: Sweep) -> Fields:
    grid = swept._grid
    limits = vibro.critical_loads(scene_of(grid.values()))
    result = SweepResult(grid.axes, grid.fixed, swept.cycle, limits, None, None, "")
    ((panel,),) = panels(result, choose_view(grid.axes))
    return Fields(panel)


def test_boundaries_are_where_the_solver_changes_its_regime(phases: Sweep) -> None:
    fields = fields_of(phases)
    regime = fields.panel.cycle["regime"]
    seen = np.full(regime.shape, int(Regime.NO_SLIP))
    for name in (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING):
        seen[fields.log_ratio[BEGINS_AT[name]] > 0.0] = int(name)
    np.testing.assert_array_equal(seen, regime)
    assert set(np.unique(regime)) == {Regime.NO_SLIP, Regime.FORWARD_SLIP, Regime.BACK_SLIP}


def test_the_amplitude_is_across_and_the_phase_up_in_eighths_of_a_turn(phases: Sweep) -> None:
    axes = only_map(phases.draw("speed"))
    assert axes.get_xlabel() == "along amplitude $X$ [mm]"
    assert axes.get_ylabel() == "normal phase $\\varphi$ [°]"
    assert axes.get_yticks().tolist() == np.arange(-180.0, 181.0, 45.0).tolist()
    assert "zero speed" in words(axes)


def test_a_trough_that_stands_still_along_or_altogether_is_drawn() -> None:
    swept = vibro.sweep(
        along_amplitude_mm="0:1:41", normal_amplitude_mm="0:0.5:41", frequency_hz=25, normal_phase_deg=-60,
        **FRICTION,
    )  # fmt: skip
    fields = fields_of(swept)
    assert fields.panel.cycle["regime"][0, 0] == Regime.NO_SLIP
    assert all(np.isfinite(field).all() for field in fields.log_ratio.values())
    swept.draw("regime")
