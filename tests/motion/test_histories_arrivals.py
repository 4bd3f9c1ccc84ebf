"""Arrival times against the reference table, histories, and bodies that never arrive."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.reference_tables import columns_of, read_rows, scene_of
from helpers.scenes import Groups, at_load, contact_groups, random_scenes, replaced, scene_with
from hypothesis import given
from hypothesis import strategies as st

import vibro
from vibro import Status

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray


def table() -> tuple[vibro.Scene, NDArray[np.float64], NDArray[np.float64]]:
    columns = columns_of(read_rows("arrival"))
    return scene_of(columns), 1e-3 * columns["length_mm"], columns["traverse_time_s"]


def cells_of(scene: vibro.Scene) -> Iterator[vibro.Scene]:
    fields = [np.broadcast_to(x, scene.shape).ravel() for _, _, x in scene.arrays().members()]
    for values in zip(*fields, strict=True):
        yield vibro.Scene(**dict(zip(scene.arrays()._fields, map(float, values), strict=True)))


def test_the_reference_table() -> None:
    scene, length, expected = table()
    assert length.size == 40
    np.testing.assert_allclose(vibro.arrival_time(scene, length), expected, rtol=1e-13, atol=0.0)


def test_one_scene_and_many_agree() -> None:
    scene, length, _ = table()
    together = vibro.arrival_time(scene, length)
    alone = [vibro.arrival_time(cell, x) for cell, x in zip(cells_of(scene), length, strict=True)]
    np.testing.assert_allclose(together, alone, rtol=1e-14, atol=0.0)


def test_the_length_broadcasts_against_the_scene() -> None:
    scene = scene_with(amplitude=[[1e-3], [2e-3]])
    time = vibro.arrival_time(scene, [0.1, 0.2, 0.3])
    assert time.shape == (2, 3)
    assert time[1, 2] == vibro.arrival_time(scene_with(amplitude=2e-3), 0.3)
    assert np.ndim(vibro.arrival_time(scene_with(), 0.1)) == 0
    assert vibro.arrival_time(scene_with(amplitude=np.ones((0, 3))), 0.1).shape == (0, 3)


@given(contact_groups(), st.floats(0.01, 30.0))
def test_a_body_is_there_on_arrival_and_never_was_before(groups: Groups, reach: float) -> None:
    scene = at_load(*groups)
    length = reach * float(scene.scale)
    time = float(vibro.arrival_time(scene, length))
    horizon = 12.0 / float(scene.frequency)
    history = vibro.simulate(scene, duration=min(time, horizon))
    farthest = max(phase.end_position for phase in history.phases)  # slides are monotone
    slack = 1e-12 * max(length, float(scene.scale))
    assert farthest <= length + slack
    if time <= horizon:
        assert history.sample(history.end).position == pytest.approx(length, abs=slack)


def test_a_length_that_the_first_slide_covers_needs_no_steady_advance() -> None:
    """Nearly horizontal, so that the steady cycle advances by 1e-17 amplitudes."""
    scene = at_load(999.0, 1.8e-15, 1.0, 1.0)
    length = np.array([0.5, 1.0, 10.0, 1e4]) * float(scene.scale)
    cycles = vibro.arrival_time(scene, length) * float(scene.frequency)
    assert (cycles[:3] < 10.0).all()
    assert np.isnan(cycles[3])


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("reach", [0.05, 3.0, 17.77])
def test_hopping_bodies_too(restitution: float, reach: float) -> None:
    throws = np.array([1.05, 1.2, 1.4, 1.9, 2.9])
    scene = replaced(
        at_load(throws / math.sin(math.radians(20.0)), 20.0, 0.74, 0.57), restitution=restitution
    )
    periodic = [cell for cell in cells_of(scene) if vibro.solve(cell).status == Status.OK]
    assert len(periodic) >= 3
    for cell in periodic:
        length = reach * float(cell.scale)
        history = vibro.simulate(cell, length=length)
        positions = history.sample(np.linspace(0.0, history.end, 1_001)).position
        assert positions[-1] == pytest.approx(length, rel=1e-12)
        assert positions[:-1].max() < length


def test_a_body_that_slides_back_arrives_before_the_cycle_ends() -> None:
    """Within a cycle of FB the body gets farther than where it ends, by more than it advances."""
    scene = at_load(2.0, 3.0, 0.4, 0.35)
    cycle = vibro.solve(scene)
    assert cycle.pattern == "FB"
    history = vibro.simulate(scene, cycles=300)
    forward = next(p for p in history.phases if p.start > history.settles_at and p.kind == "F")
    back = next(p for p in history.phases if p.start >= forward.end)
    assert back.end_position - back.start_position < -float(cycle.displacement_per_cycle)
    length = 0.5 * (back.start_position + max(back.end_position, forward.start_position))
    assert vibro.arrival_time(scene, length) < back.end
    assert history.sample(float(vibro.arrival_time(scene, length))).position == pytest.approx(
        length, rel=1e-12
    )


def test_long_ways_are_as_exact_as_short_ones() -> None:
    """After n cycles a settled body is n displacements farther, and n periods later."""
    scene = scene_with(amplitude=[1e-3, 1.3e-3, 1.5e-3, 2e-3, 4e-3])
    cycle = vibro.solve(scene)
    count = 10.0**7
    near = 200.5 * cycle.displacement_per_cycle
    first = vibro.arrival_time(scene, near)
    later = vibro.arrival_time(scene, near + count * cycle.displacement_per_cycle)
    np.testing.assert_allclose((later - first) * 15.0, count, rtol=1e-13, atol=0.0)


def test_the_steady_figure_is_the_limit_for_long_troughs() -> None:
    scene = random_scenes(400, 3, most_trough_deg=6.0)
    cycle = vibro.solve(scene)
    forward = cycle.displacement_per_cycle > 1e-3 * scene.scale
    length = np.where(forward, 1e5 * cycle.displacement_per_cycle, 1.0)
    exact = np.where(forward, vibro.arrival_time(scene, length), 0.0)
    # the start gains or loses a distance that does not grow with the length; at a slow advance it takes many
    # cycles
    ahead = cycle.mean_velocity[forward] * (cycle.traverse_time(length) - exact)[forward]
    assert (np.abs(ahead) < 200.0 * scene.scale[forward]).all()


def test_bodies_that_never_arrive() -> None:
    at_rest = scene_with(amplitude=5e-4)
    assert vibro.arrival_time(at_rest, 1e-9) == math.inf
    to_and_fro = scene_with(drive_angle=0.0, amplitude=3e-3)
    assert vibro.solve(to_and_fro).displacement_per_cycle == 0.0
    assert vibro.arrival_time(to_and_fro, 1.0) == math.inf
    backwards = scene_with(amplitude=9e-4, static_friction=0.3, kinetic_friction=0.29, trough_angle=0.26)
    assert vibro.solve(backwards).mean_velocity < 0.0
    assert vibro.arrival_time(backwards, 1.0) == math.inf


def test_a_transient_may_reach_what_the_steady_cycle_would_not() -> None:
    to_and_fro = scene_with(drive_angle=0.0, amplitude=3e-3)
    top = max(p.end_position for p in vibro.simulate(to_and_fro, cycles=300).phases)
    assert top > 0.0
    assert vibro.arrival_time(to_and_fro, top * (1.0 - 1e-9)) < 20.0
    assert vibro.arrival_time(to_and_fro, top * (1.0 + 1e-9)) == math.inf


def test_runaways() -> None:
    steep = math.radians(50.0)
    scene = scene_with(trough_angle=[-steep, steep], amplitude=1e-3)
    assert (vibro.solve(scene).status == Status.RUNAWAY).all()
    forward, back = vibro.arrival_time(scene, 1.0)
    fall = 9.81 * (math.sin(steep) - 0.57 * math.cos(steep))
    assert forward == pytest.approx(math.sqrt(2.0 / fall), rel=0.1)
    assert back == math.inf


def test_hopping_bodies_that_slide_off_backwards_never_arrive() -> None:
    scene = at_load(6.0, 20.0, 0.1, 0.05, 10.0)
    assert vibro.solve(scene).status == Status.RUNAWAY
    assert vibro.arrival_time(scene, 1.0) == math.inf


def test_without_static_friction_the_motion_from_rest_is_still_known() -> None:
    scene = scene_with(static_friction=0.0, kinetic_friction=0.0, amplitude=1e-3)
    assert vibro.solve(scene).status == Status.INDETERMINATE
    # free of friction the body moves by 2 pi A cos(alpha) a cycle, as v = A w cos(alpha) (1 - cos wt)
    length = 2.0 * math.pi * 1e-3 * math.cos(math.radians(20.0)) * 10.0
    assert vibro.arrival_time(scene, length) == pytest.approx(10.0 / 15.0, rel=1e-4)


def test_motion_without_a_period_is_unknown_once_rounding_has_grown() -> None:
    scene = scene_with(amplitude=8e-3, restitution=0.3)
    assert vibro.solve(scene).status == Status.AVERAGED
    soon, late = vibro.arrival_time(scene, float(scene.scale) * np.array([1.0, 1e4]))
    assert vibro.simulate(scene, duration=soon).sample(soon).position == pytest.approx(float(scene.scale))
    assert math.isnan(late)


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


def test_a_drive_and_a_trough_of_more_than_a_right_angle_are_followed() -> None:
    scene = scene_with(drive_angle=1.2, trough_angle=0.5, amplitude=[5e-4, 3e-3])
    lengths = np.array([1e-4, 1e-4])
    times = vibro.arrival_time(scene, lengths)
    assert not np.isnan(times).any()
    for cell, length, time in zip(cells_of(scene), lengths, times, strict=True):
        history = vibro.simulate(cell, duration=min(float(time), 0.5))
        assert math.isinf(time) or history.sample(history.end).position == pytest.approx(length)


def test_infeasible_cells_are_unknown() -> None:
    scene = vibro.Scene.allowing_infeasible(
        amplitude=2e-3, frequency=15, drive_angle=0.3, static_friction=[0.2, 0.4], kinetic_friction=0.3
    )
    infeasible, feasible = vibro.arrival_time(scene, 0.1)
    assert math.isnan(infeasible)
    assert feasible > 0.0
