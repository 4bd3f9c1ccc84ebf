"""Counts of cells, and the fastest of them, whatever the order in which blocks come."""

from __future__ import annotations

import json
from itertools import permutations

import numpy as np
import pytest
from helpers.plans import swept

from vibro.results.sweep import Block, Peak
from vibro.sweeps.run import sweep_blocks
from vibro.sweeps.tally import Tally


def tally_of(*cells: tuple[float, float]) -> Tally:
    """Return a tally that knows the fastest cell alone, of pairs of a speed and an amplitude."""
    tally = Tally()
    for speed, amplitude in cells:
        other = Tally()
        other.peaks["fastest"] = Peak(speed, 0.0, {"amplitude": amplitude})
        tally.include([other])
    return tally


def test_the_fastest_of_blocks_is_that_of_all_cells() -> None:
    grid = swept(amplitude_mm="0.1:3:7", trough_angle_deg=[-10, 0, 10])._grid
    whole, parts = Tally(), []
    (block,) = sweep_blocks(grid)
    whole.add(block)
    for start in range(0, grid.size, 4):
        stop = min(start + 4, grid.size)
        part = Tally()
        part.add(Block(*grid.solve_cells(start, stop), None))
        parts.append(part)
    for order in (parts, parts[::-1]):
        together = Tally()
        together.include(order)
        assert together == whole
    speed = 1e3 * block.cycle.mean_velocity
    amplitude, angle = (grid.axes[name].values for name in ("amplitude", "trough_angle"))
    assert Tally.read(json.loads(json.dumps(whole.record()))) == whole
    for name, place in (("fastest", np.argmax(speed)), ("fastest_backwards", np.argmin(speed))):
        i, j = np.unravel_index(place, speed.shape)
        peak = whole.peaks[name]
        assert (peak.values["amplitude"], peak.values["trough_angle"]) == (amplitude[i], angle[j])
        assert peak.speed == pytest.approx(speed[i, j], rel=1e-15)


def test_of_equally_fast_cells_the_first_in_any_order() -> None:
    cells = [(5.0, 3.0), (7.0, 2.0), (7.0, 1.0)]
    for order in permutations(cells):
        assert tally_of(*order).peaks["fastest"] == Peak(7.0, 0.0, {"amplitude": 1.0})
