"""The motion that the page follows itself: the curves of vibro.simulate, and the panels of its pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.page_states import cells, state_of
from helpers.whole_page import in_modules

from vibro import simulate
from vibro.motion.histories import trace
from vibro.plots.history import most_force, panels_of, values_of
from vibro.sweeps.grid import scene_of

if TYPE_CHECKING:
    from vibro.sweeps.grid import Grid

_CYCLES = 4
_SAMPLES = 100
_NEAR = 1e-9  # [1] of the size of a curve
_RUN = """
export const run = ({ data, engine, motionOf }, states) => states.map((one) => motionOf(data, engine, one));
"""


@pytest.fixture(scope="module")
def motions() -> dict[str, Any]:
    """Return what the page draws of each scene."""
    asked = cells()
    found = in_modules(_RUN, [state_of(grid, _CYCLES) for grid in asked.values()])
    return dict(zip(asked, found, strict=True))


@each(("name", "grid"), [*cells().items()])
def test_curves_are_those_of_vibro_simulate(name: str, grid: Grid, motions: dict[str, Any]) -> None:
    history = simulate(scene_of(grid.values()), cycles=_CYCLES)
    rows = trace(history, until=history.end, samples_per_cycle=_SAMPLES, both_sides=True)
    found = motions[name]
    flies = ["gap"] * any(phase.kind == "H" for phase in history.phases)
    panels = panels_of(["trough", "forces", "velocity", "position", *flies], rows)
    assert [panel["name"] for panel in found["panels"]] == [*panels]
    assert [x["start"] for x in found["phases"]] == pytest.approx(
        [x.start for x in history.phases], rel=_NEAR
    )
    time = np.array(found["rows"]["time"])
    assert time == pytest.approx(rows.time, rel=_NEAR)
    presses = rows.normal > _NEAR * rows.normal.max()
    for panel, drawn in zip(panels.values(), found["panels"], strict=True):
        curves = iter(drawn["curves"])
        for curve in panel.curves:
            line, known = next(curves), values_of(curve, panel, rows)
            most = np.nanmax(np.abs(known), initial=0.0)
            drawn_values = np.array(line["values"])
            if curve.in_contact:  # as a body takes off, rounding decides whether it still presses
                drawn_values, known = drawn_values[presses], known[presses]
            assert drawn_values == pytest.approx(known, abs=_NEAR * most, rel=0.0, nan_ok=True), curve
            assert line["label"].startswith(curve.label if len(panel.curves) > 1 else "")
            is_cut = drawn["name"] == "forces" and most > most_force(rows)
            assert line["label"].endswith(" (cut off)") == is_cut
            if curve.field == "static_limit":
                assert np.array(next(curves)["values"]) == pytest.approx(
                    -np.array(line["values"]), nan_ok=True
                )
        assert not [*curves]
        assert drawn["low"] < 0.0 < drawn["high"]


def test_a_motion_that_cannot_be_followed_is_none() -> None:
    state = state_of(next(iter(cells().values())))
    state["values"] |= {"static_friction": 1e11, "kinetic_friction": 1e-60, "amplitude": 1e8, "gravity": 1e-9}
    assert in_modules(_RUN, [state]) == [None]
