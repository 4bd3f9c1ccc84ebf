"""Time histories: rest for ever, the end on arrival, and phases beyond memory."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.scenes import at_load, scene_with

import vibro
from vibro import VibroError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def test_a_body_that_rests_for_ever() -> None:
    history = vibro.simulate(scene_with(amplitude=5e-4), cycles=10.5)
    (phase,) = history.phases
    assert (phase.kind, phase.start) == ("_", 0.0)
    assert phase.end == pytest.approx(0.7)
    sample = history.sample(np.linspace(0.0, 0.7, 11))
    assert not sample.position.any()
    assert history.pattern == ""
    assert math.isnan(history.cycle_displacement)


def test_the_history_of_a_length_ends_on_arrival() -> None:
    history = vibro.simulate(scene_with(), length=0.6)
    assert history.end == vibro.arrival_time(scene_with(), 0.6)
    assert history.phases[-1].end_position == pytest.approx(0.6, rel=1e-13)
    assert max(p.end_position for p in history.phases) == history.phases[-1].end_position
    moved = vibro.simulate(scene_with(), length=0.02, start_velocity=1.0)
    assert moved.end < vibro.simulate(scene_with(), length=0.02).end


def test_phases_beyond_memory_are_not_spelt_out() -> None:
    history = vibro.simulate(at_load(0.9, 20.0, 0.74, 0.57), cycles=1e12)
    with pytest.raises(VibroError, match="2000000000001"):
        _ = history.phases
    moved = float(history.sample(history.end).position)
    assert moved == pytest.approx(1e12 * history.cycle_displacement, rel=1e-9)
