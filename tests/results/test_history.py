"""What a history says at any time: samples, sides of events, phases."""

from __future__ import annotations

import math
from typing import Final, Literal

import numpy as np
import pytest
from helpers.scenes import scene_with

import vibro

SIDES: Final[tuple[Literal["left", "right"], ...]] = ("left", "right")


def test_both_sides_of_an_event() -> None:
    history = vibro.simulate(scene_with(amplitude=4e-3), cycles=3)
    onset = next(p for p in history.phases if p.kind == "F" and p.start_velocity == 0.0)
    before, after = (history.sample(onset.start, side) for side in SIDES)
    assert before.acceleration == 0.0
    assert before.friction == pytest.approx(float(before.static_limit) * -1.0, rel=1e-9)
    assert after.friction == pytest.approx(0.57 / 0.74 * float(before.friction), rel=1e-9)
    assert after.velocity == 0.0
    landing = next(p for p in history.phases if p.kind == "H")
    before, after = (history.sample(landing.end, side) for side in SIDES)
    assert before.velocity == landing.end_velocity
    assert abs(float(after.velocity)) < abs(landing.end_velocity)
    assert before.normal == 0.0
    assert after.normal > 0.0
    assert before.gap == after.gap == 0.0
    loss = abs(landing.end_velocity) - abs(float(after.velocity))
    assert loss == pytest.approx(0.57 * landing.impact_velocity, rel=1e-12)


def test_a_flight_that_the_end_cuts_short_has_no_impact() -> None:
    scene = scene_with(amplitude=4e-3)
    landing = next(p for p in vibro.simulate(scene, cycles=3).phases if p.kind == "H")
    cut = vibro.simulate(scene, duration=0.5 * (landing.start + landing.end)).phases[-1]
    assert (cut.kind, cut.start, cut.impact_velocity) == ("H", landing.start, 0.0)
    assert landing.impact_velocity > 0.0


STEPS = vibro.Motion.steps(along=[(0.8, 2.4), (0.2, -9.6)])


@pytest.mark.parametrize(("frequency", "start_phase"), [(2.5, 0.0), (3.7, -2.0)])
def test_both_sides_of_a_jump_of_the_acceleration(frequency: float, start_phase: float) -> None:
    """Where steps change: rounding would decide which acceleration a time exactly there has."""
    scene = vibro.Scene(motion=STEPS, frequency=frequency, static_friction=0.3, kinetic_friction=0.25)
    history = vibro.simulate(scene, cycles=50, start_phase=start_phase)
    shares = (np.arange(-60, 60)[:, np.newaxis] + [0.0, 0.8]).ravel() - start_phase / math.tau
    wanted = shares / frequency
    times = history.jumps(0.0, history.end)
    assert times == pytest.approx(wanted[(wanted > 0.0) & (wanted < history.end)], abs=1e-12)
    assert np.array_equal(history.jumps(times[3], times[7]), times[4:7])
    starts = np.array([p.start for p in history.phases])
    near = np.abs(times[:, np.newaxis] - starts).argmin(axis=1)  # a phase begins there, but for rounding
    times = np.where(np.isclose(times, starts[near], rtol=0.0, atol=1e-9), starts[near], times)
    before, after = (history.sample(times, side=side) for side in SIDES)
    begins = np.isclose((times * frequency + start_phase / math.tau) % 1.0, 0.8)
    for sample, is_back in ((before, ~begins), (after, begins)):
        assert np.array_equal(sample.inertial > 0.0, is_back)
        assert np.abs(sample.inertial) == pytest.approx(np.where(is_back, 9.6, 2.4))
        assert (np.abs(sample.friction) <= sample.static_limit).all()
        assert sample.acceleration == pytest.approx(sample.inertial + sample.friction, abs=1e-12)
    for name in ("position", "velocity", "trough_along"):
        assert getattr(before, name) == pytest.approx(getattr(after, name), abs=1e-12)


def test_smooth_motions_do_not_jump() -> None:
    wave = np.sin(np.arange(32) * math.tau / 32)
    fields = {"frequency": 8.0, "static_friction": 0.4, "kinetic_friction": 0.3}
    smooth = vibro.Scene(motion=vibro.Motion.samples(along=6.0 * wave), **fields)
    harmonics = vibro.Scene(along_harmonics=[(1e-3, 0.0), (1e-3, 1.0)], **fields)
    for scene in (smooth, harmonics, scene_with()):
        assert vibro.simulate(scene, cycles=2).jumps(0.0, 1.0).size == 0


def test_samples_at_the_events_are_those_of_the_phases() -> None:
    history = vibro.simulate(scene_with(amplitude=2e-3), cycles=60)
    starts = np.array([p.start for p in history.phases])
    ends = np.array([p.end for p in history.phases])
    np.testing.assert_array_equal(starts[1:], ends[:-1])
    right, left = history.sample(starts), history.sample(ends, side="left")
    np.testing.assert_array_equal(right.velocity, [p.start_velocity for p in history.phases])
    np.testing.assert_array_equal(left.velocity, [p.end_velocity for p in history.phases])
    np.testing.assert_array_equal(right.position, [p.start_position for p in history.phases])
    np.testing.assert_allclose(
        left.position, [p.end_position for p in history.phases], rtol=1e-13, atol=1e-17
    )


def test_samples_keep_the_shape_and_order_of_the_times() -> None:
    history = vibro.simulate(scene_with(), duration=0.2, start_phase=-9.0)
    times = np.array([[0.1, 0.03], [0.02, 0.07]])
    together = history.sample(times)
    for name in together.__dataclass_fields__:
        values = getattr(together, name)
        assert values.shape == (2, 2), name
        np.testing.assert_array_equal(
            values.ravel(), [getattr(history.sample(t), name) for t in times.ravel()]
        )
    for time in (-0.1, 0.21, math.nan):
        with pytest.raises(vibro.VibroError, match=r"is outside of the history, 0 to 0\.2 s"):
            history.sample(time)
    driven = 1e-3 * np.sin(math.tau * 15.0 * times - 9.0)
    np.testing.assert_allclose(together.trough_displacement, driven, atol=1e-16, rtol=0.0)
