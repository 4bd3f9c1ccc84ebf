"""Arrival times against the reference table, histories, and bodies that never arrive."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.reference_tables import columns_of, read_rows, scene_of
from helpers.scenes import Groups, at_load, contact_groups, driven, replaced, scene_with
from hypothesis import given
from hypothesis import strategies as st

import vibro
from vibro import Status

if TYPE_CHECKING:
    from numpy.typing import NDArray


TURN = 2.0 * math.pi


def table() -> tuple[vibro.Scene, NDArray[np.float64], NDArray[np.float64]]:
    columns = columns_of(read_rows("arrival"))
    return scene_of(columns), 1e-3 * columns["length_mm"], columns["traverse_time_s"]


def test_the_reference_table() -> None:
    scene, length, expected = table()
    assert length.size == 40
    np.testing.assert_allclose(vibro.arrival_time(scene, length), expected, rtol=1e-13, atol=0.0)


@given(contact_groups(), st.floats(0.01, 30.0), st.floats(0.0, TURN), st.floats(-2.0, 2.0))
def test_a_body_is_there_on_arrival_and_never_was_before(
    groups: Groups, reach: float, phase: float, velocity: float
) -> None:
    scene = at_load(*groups)
    size, f = float(scene.scale), float(scene.frequency)
    start = {"start_phase": phase, "start_velocity": velocity * size * TURN * f}
    time = float(vibro.arrival_time(scene, reach * size, **start))
    is_soon = time <= 12.0 / f  # not where it is unknown, NaN: the body has hardly a net advance
    history = vibro.simulate(scene, duration=time if is_soon else 12.0 / f, **start)
    slack = 1e-12 * max(reach, 1.0) * size
    assert max(phase.end_position for phase in history.phases) <= reach * size + slack  # slides are monotone
    if is_soon:
        assert history.sample(history.end).position == pytest.approx(reach * size, abs=slack)


FAR = {
    "F_": at_load(0.9, 20.0, 0.74, 0.57),
    "F_B_": at_load(0.7, 1.0, 0.5, 0.49),
    "FB_": at_load(0.9, 20.0, 0.5, 0.4),
    "FB": at_load(2.0, 25.0, 0.2, 0.15),
    "FB, long settling": at_load(2.0, 10.0, 0.05, 0.03),
    "FB of an ellipse, long settling": driven(Groups(2.04, 11.0, 0.3, 0.05), -20.0),
    "no kinetic friction": at_load(1.5, 20.0, 0.5, 0.0),
    "HFB": at_load(3.4, 30.0, 0.5, 0.4),
    "HB uphill": at_load(4.5, 25.0, 0.2, 0.1, 5.0),
    "HHB": at_load(8.6, 30.0, 0.5, 0.4),
    "bounces": replaced(at_load(3.0, 30.0, 0.5, 0.4), restitution=0.3),
    "bounces alone": replaced(at_load(8.5, 30.0, 0.5, 0.4), restitution=0.3),
}


@pytest.mark.parametrize("name", FAR)
def test_far_arrivals_are_where_the_history_is(name: str) -> None:
    """Transients are summed, and whole cycles added; histories go through each, or repeat a fixed point."""
    scene, cycle = FAR[name], vibro.solve(FAR[name])
    advance, period = float(cycle.displacement_per_cycle), float(cycle.period_cycles)
    f = float(scene.frequency)
    for cycles in (3.3, 120.3, 2000.7):
        length = cycles * advance
        time = float(vibro.arrival_time(scene, length))
        history = vibro.simulate(scene, duration=time)
        assert history.sample(time).position == pytest.approx(length, rel=1e-11)
        just_before = np.linspace(max(time - 2.0 * period / f, 0.0), time * (1.0 - 1e-9), 2_001)
        assert history.sample(just_before).position.max() < length
    later = float(vibro.arrival_time(scene, length + 1e6 * period * advance))
    assert (later - time) * f == pytest.approx(1e6 * period, rel=1e-11)


def test_a_slide_that_does_not_come_again_is_not_waited_for() -> None:
    """Pushed back at first, the body slides forward alone later."""
    scene = FAR["F_"]
    start = {"start_velocity": -0.8 * float(scene.scale) * TURN * 15.0}
    assert vibro.simulate(scene, cycles=1, **start).phases[0].kind == "B"
    length = 1e11 * float(vibro.solve(scene).displacement_per_cycle)
    assert vibro.arrival_time(scene, length, **start) * 15.0 == pytest.approx(1e11, rel=1e-9)


def test_a_body_in_another_cycle_than_that_from_rest_arrives_where_that_leads() -> None:
    """It conveys 6.4684 g/w^2 a cycle from rest, and 0.5732 if disturbed."""
    scene = at_load(1.49149, math.degrees(0.7034), 0.457783, 0.0429106)
    start = {"start_velocity": -float(scene.scale) * TURN * 15.0}
    advance = vibro.simulate(scene, cycles=3000, **start).cycle_displacement
    assert advance / float(scene.scale) * 1.49149 == pytest.approx(0.5732, abs=5e-5)
    for cycles in (3.3, 120.3, 20_000.7):
        time = float(vibro.arrival_time(scene, cycles * advance, **start))
        history = vibro.simulate(scene, duration=time, **start)
        assert history.sample(time).position == pytest.approx(cycles * advance, rel=1e-11)


@pytest.mark.parametrize(
    ("groups", "later", "velocity"),
    [  # a hundred turns; within half a turn the velocity turns twice, or gravity outgrows the drive
        (Groups(600.0, 40.0, 0.5, 0.4), 0.5, -0.4),
        (Groups(600.0, 40.0, 0.5, 0.4, 3.0), 0.5, 0.3),
        (Groups(600.0, 40.0, 0.5, 0.4, -3.0), 0.5, 2.0),
        (Groups(1.53, 52.0, 1.9, 1.5, 29.7), 0.465, -0.135),
        (Groups(1.582, 48.85, 1.9, 1.5, -28.67), 0.07, -0.963),
    ],
)
def test_arrivals_in_flight(groups: Groups, later: float, velocity: float) -> None:
    scene = at_load(*groups)
    throw = groups.load * math.sin(math.radians(groups.drive_deg)) / math.cos(math.radians(groups.trough_deg))
    unit = float(scene.scale) * TURN * float(scene.frequency)
    start = {"start_phase": math.asin(1.0 / throw) + later, "start_velocity": velocity * unit}
    history = vibro.simulate(scene, cycles=60.0, **start)
    assert history.phases[0].kind == "H"
    times = np.linspace(0.0, history.phases[0].end, 40_001)
    positions = history.sample(times).position
    for share in (1e-4, 0.03, 0.2, 0.5, 0.97, 0.99999):
        length = share * float(positions.max())
        time = float(vibro.arrival_time(scene, length, **start))
        assert history.sample(time).position == pytest.approx(length, rel=1e-11)
        assert positions[times < time].max() < length


def test_the_end_of_a_slide_is_reached_and_what_lies_behind_it_is_not() -> None:
    """Rest follows, and the next slide a cycle later goes on."""
    scene = scene_with()
    _, slide, _, following, *_ = vibro.simulate(scene, cycles=3).phases
    end = slide.end_position
    for length in (math.nextafter(end, 0.0), end):
        assert vibro.arrival_time(scene, length) == pytest.approx(slide.end, abs=1e-8)
    assert following.start < vibro.arrival_time(scene, end * (1.0 + 1e-9)) < following.start + 0.02 / 15.0


def test_arrivals_later_than_the_most_cycles_are_unknown() -> None:
    scene = scene_with(amplitude=1e-9, frequency=15e3)
    most = 1e15 * float(vibro.solve(scene).displacement_per_cycle)
    assert vibro.arrival_time(scene, 0.9 * most) * 15e3 == pytest.approx(0.9e15, rel=1e-14)
    assert math.isnan(vibro.arrival_time(scene, 1.1 * most))


@pytest.mark.timeout(10)  # where one is followed to the end, it takes a minute
@pytest.mark.parametrize(
    "groups",
    [
        Groups(0.4, 20.0, 0.5, 0.4),
        Groups(0.5, 5.0, 0.3, 0.29, 12.0),
        Groups(0.781, 57.03, 0.27, 0.155, 3.46),
        Groups(2.2, 20.0, 0.45, 0.3, 3.0),
        Groups(3.0, 0.0, 0.74, 0.57),
    ],
    ids=["rest", "B_", "F_B", "FB uphill", "to and fro"],
)
def test_a_pushed_body_never_arrives_beyond_its_farthest_position(groups: Groups) -> None:
    scene = at_load(*groups)
    start = {"start_velocity": 0.9 * float(scene.scale) * TURN * 15.0}
    top = max(phase.end_position for phase in vibro.simulate(scene, cycles=400, **start).phases)
    assert top > 0.0
    assert vibro.arrival_time(scene, top * (1.0 - 1e-9), **start) < 30.0
    assert vibro.arrival_time(scene, top * (1.0 + 1e-9), **start) == math.inf


def test_a_length_that_the_first_slide_covers_needs_no_steady_advance() -> None:
    """Nearly horizontal, so that the steady cycle advances by 1e-17 amplitudes."""
    scene = at_load(999.0, 1.8e-15, 1.0, 1.0)
    length = np.array([0.5, 1.0, 10.0, 1e4]) * float(scene.scale)
    cycles = vibro.arrival_time(scene, length) * float(scene.frequency)
    assert (cycles[:3] < 10.0).all()
    assert np.isnan(cycles[3])


def test_bodies_that_never_arrive() -> None:
    at_rest = scene_with(amplitude=5e-4)
    assert vibro.arrival_time(at_rest, 1e-9) == math.inf
    to_and_fro = scene_with(drive_angle=0.0, amplitude=3e-3)
    assert vibro.solve(to_and_fro).displacement_per_cycle == 0.0
    assert vibro.arrival_time(to_and_fro, 1.0) == math.inf
    backwards = scene_with(amplitude=9e-4, static_friction=0.3, kinetic_friction=0.29, trough_angle=0.26)
    assert vibro.solve(backwards).mean_velocity < 0.0
    assert vibro.arrival_time(backwards, 1.0) == math.inf


def test_runaways() -> None:
    steep = math.radians(50.0)
    scene = scene_with(trough_angle=[-steep, steep], amplitude=1e-3)
    assert (vibro.solve(scene).status == Status.RUNAWAY).all()
    forward, back = vibro.arrival_time(scene, 1.0)
    fall = 9.81 * (math.sin(steep) - 0.57 * math.cos(steep))
    assert forward == pytest.approx(math.sqrt(2.0 / fall), rel=0.1)
    assert back == math.inf


def test_without_static_friction_the_motion_from_rest_is_still_known() -> None:
    scene = scene_with(static_friction=0.0, kinetic_friction=0.0, amplitude=1e-3)
    assert vibro.solve(scene).status == Status.INDETERMINATE
    # free of friction the body moves by 2 pi A cos(alpha) a cycle, as v = A w cos(alpha) (1 - cos wt)
    length = 2.0 * math.pi * 1e-3 * math.cos(math.radians(20.0)) * 10.0
    assert vibro.arrival_time(scene, length) == pytest.approx(10.0 / 15.0, rel=1e-4)


def test_an_arrival_that_rounding_chooses_is_unknown() -> None:
    # true between 214.85 and 220.14 cycles, and what doubles find lies anywhere there and beyond
    amplitude = [0.007088276919005166]
    for _ in range(3):
        amplitude.append(math.nextafter(amplitude[-1], 1.0))
    scene = vibro.Scene(
        amplitude=amplitude,
        frequency=20,
        drive_angle=0.7712478462674884,
        static_friction=0.23929552573721188,
        kinetic_friction=0.1817686890112862,
        restitution=0.6112762739020561,
    )
    assert np.isnan(vibro.arrival_time(scene, 4.56280220557782)).all()
    # the first moments are known
    assert np.isfinite(vibro.arrival_time(scene, 1e-3)).all()
