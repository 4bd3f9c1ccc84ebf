"""Time histories: samples, energy, friction, and the way into the steady cycle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.scenes import Groups, at_load, replaced, scene_with

import vibro
from vibro import VibroError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)

PATTERNS = [
    ("F_", Groups(0.9, 20.0, 0.74, 0.57)),
    ("F_", Groups(0.95, 75.0, 0.4, 0.25, 9.0)),
    ("F_", Groups(0.25, 10.0, 0.5, 0.2, -13.0)),
    ("B_", Groups(0.582, 0.43, 0.752, 0.565, 10.62)),
    ("F_B_", Groups(1.1, 20.0, 0.74, 0.57)),
    ("F_B_", Groups(0.922, 9.38, 0.692, 0.62, 2.97)),
    ("FB_", Groups(1.36, 20.0, 0.74, 0.57)),
    ("FB_", Groups(1.007, 16.82, 0.51, 0.426, -8.95)),
    ("F_B", Groups(0.781, 57.03, 0.27, 0.155, 3.46)),
    ("F_B", Groups(0.599, 16.44, 0.359, 0.242, 2.97)),
    ("FB", Groups(2.0, 20.0, 0.74, 0.57)),
    ("FB", Groups(2.859, 19.78, 0.831, 0.6, 10.47)),
]
HOPS = [  # bodies that rest, and two that leave again where they land
    (throw / math.sin(math.radians(20.0)), restitution)
    for throw, restitution in (
        (1.5, 0.0),
        (2.0, 0.0),
        (2.5, 0.0),
        (3.0, 0.0),
        (3.6, 0.0),
        (1.5, 0.3),
        (2.25, 0.3),
    )
]


def hopping(load: float, restitution: float) -> vibro.Scene:
    return replaced(at_load(load, 20.0, 0.74, 0.57), restitution=restitution)


def rotations(pattern: str) -> set[str]:
    return {pattern[i:] + pattern[:i] for i in range(len(pattern))}


@pytest.mark.parametrize(("pattern", "groups"), PATTERNS)
def test_the_transient_leads_to_the_steady_cycle(pattern: str, groups: Groups) -> None:
    scene = at_load(*groups)
    steady = vibro.solve(scene)
    assert steady.pattern == pattern
    history = vibro.simulate(scene, cycles=100_000)
    assert history.pattern in rotations(pattern)
    assert history.cycle_displacement == pytest.approx(float(steady.displacement_per_cycle), rel=1e-12)
    period = 1.0 / float(scene.frequency)
    late = history.settles_at + period * np.array([90_000.0, 90_001.0])
    before, after = history.sample(late).position
    assert after - before == pytest.approx(float(steady.displacement_per_cycle), rel=1e-7)  # of 1e5 cycles
    whole = np.array([0.0, 90_000.0])
    start, end = history.sample(history.settles_at + period * whole).position
    assert (end - start) / 90_000.0 == pytest.approx(float(steady.displacement_per_cycle), rel=1e-12, abs=0.0)


@pytest.mark.parametrize(("load", "restitution"), HOPS)
def test_hopping_leads_to_the_steady_cycle(load: float, restitution: float) -> None:
    scene = hopping(load, restitution)
    steady = vibro.solve(scene)
    assert steady.status == vibro.Status.OK
    history = vibro.simulate(scene, cycles=600)
    assert history.settles_at < math.inf
    assert history.cycle_displacement == pytest.approx(float(steady.displacement_per_cycle), rel=1e-12)
    speed = float(np.abs(history.sample(np.linspace(history.settles_at, history.end, 20_001)).velocity).max())
    assert speed == pytest.approx(float(steady.peak_velocity), rel=1e-3)
    impacts = [p.impact_velocity for p in history.phases if p.start > history.settles_at]
    assert max(impacts) == pytest.approx(float(steady.impact_velocity), rel=1e-11)


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
