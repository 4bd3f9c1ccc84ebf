"""Bodies that are dropped, thrown or knocked onto the trough, against bodies that SciPy integrates."""

from __future__ import annotations

import math

import numpy as np
import pytest
from engines.integrated import TURN, Body
from helpers.scenes import Groups, driven, replaced

import vibro

NUT = Groups(0.9, 20.0, 0.74, 0.57)  # does not hop
HOPS = Groups(3.4, 30.0, 0.5, 0.4)
# two cycles coexist (tests/motion/test_attractors.py)
TWO_FLIGHTS = Groups(
    0.0012534742194341873 * (TURN * 20.0) ** 2 / 9.81,
    math.degrees(0.6448704695649682), 0.46894843081393256, 0.39128583597305744,
)  # fmt: skip
STARTS = [  # phase [rad], velocity [A w], height [A], normal velocity [A w]
    (0.0, 0.0, 3.0, 0.0),
    (2.0, 0.4, 0.02, -0.3),
    (5.0, -0.5, 0.0, 1.5),
    (1.0, 0.3, 0.0, -0.8),
    (4.0, 0.0, 40.0, 2.0),
]


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize(
    ("groups", "restitution", "phase_deg"),
    [
        (NUT, 0.0, None),
        (NUT, 0.4, None),
        (HOPS, 0.0, None),
        (HOPS, 0.3, None),
        (NUT, 0.3, 50.0),
        (HOPS, 0.2, -70.0),
    ],
)
def test_integrated_bodies_go_the_same_way(
    groups: Groups, restitution: float, phase_deg: float | None, start: tuple[float, float, float, float]
) -> None:
    scene = driven(groups, phase_deg, restitution)
    phase, velocity, height, rate = start
    scale, w = float(scene.scale), TURN * float(scene.frequency)
    unit = math.hypot(math.cos(math.radians(groups.drive_deg)), math.sin(math.radians(groups.drive_deg)))
    if phase_deg is not None:  # of an ellipse the solver counts in its larger amplitude
        unit = max(math.cos(math.radians(groups.drive_deg)), math.sin(math.radians(groups.drive_deg)))
    size = scale / unit
    history = vibro.simulate(
        scene, cycles=4.0, start_phase=phase, start_velocity=velocity * size * w,
        start_height=height * size, start_normal_velocity=rate * size * w,
    )  # fmt: skip
    lead = math.radians(phase_deg or 0.0)
    body = Body(groups, restitution, phase=phase, velocity=velocity, lead=lead)
    knocked = max(abs(velocity) + groups.mu_d * (1.0 + restitution) * min(rate, 0.0), 0.0)
    if height == 0.0 and rate < 0.0:
        velocity, rate = math.copysign(knocked, velocity), -restitution * rate
    body.aloft, body.state[1:] = True, (velocity, height, rate)
    if height == rate == 0.0:
        body.aloft, body.way = body.normal(phase) < 0.0, int(np.sign(velocity))
        if not body.way:
            body._stick()
    for turns in (0.7, 2.3, 3.9):
        body.until(phase + turns * TURN)
        sample = history.sample(turns / float(scene.frequency))
        assert sample.position / size == pytest.approx(body.state[0], abs=2e-5)
        assert sample.gap / size == pytest.approx(max(body.state[2], 0.0), abs=2e-5)
    if history.phases[0].kind == "H" and height:
        begin = history.sample(0.0)
        assert begin.gap / size == pytest.approx(height, rel=1e-12)


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize(("groups", "restitution"), [(NUT, 0.4), (HOPS, 0.0), (HOPS, 0.3)])
def test_a_drive_with_hardly_any_harmonics_throws_as_its_line(
    groups: Groups, restitution: float, start: tuple[float, float, float, float]
) -> None:
    line = driven(groups, None, restitution)
    scale, w = float(line.scale), TURN * float(line.frequency)
    along, normal = (scale * part(math.radians(groups.drive_deg)) for part in (math.cos, math.sin))
    motion = vibro.Motion.harmonics(
        along=[(along, 0.0), (1e-10 * along, 0.0)], normal=[(normal, 0.0), (1e-10 * normal, 0.0)]
    )
    same = {"static_friction": groups.mu_s, "kinetic_friction": groups.mu_d, "restitution": restitution}
    scene = vibro.Scene(motion=motion, frequency=line.frequency, **same)
    keys = ("start_phase", "start_velocity", "start_height", "start_normal_velocity")
    given = dict(
        zip(keys, (start[0], start[1] * scale * w, start[2] * scale, start[3] * scale * w), strict=True)
    )
    ends = [vibro.simulate(one, cycles=5.3, **given).phases[-1].end_position for one in (scene, line)]
    assert ends[0] == pytest.approx(ends[1], abs=1e-6 * scale)


def test_a_bouncing_body_keeps_bouncing_where_nothing_else_hops() -> None:
    """K = 0.9: at e = 0.7 the cycle of one bounce, Eq. (37), is stable from K = 0.554 on."""
    throw, e = 0.9, 0.7
    scene = replaced(driven(Groups(throw / math.sin(0.5), math.degrees(0.5), 0.5, 0.4), None), restitution=e)
    phase = math.acos(math.pi * (1.0 - e) / (1.0 + e) / throw)
    n = math.sin(0.5) / throw
    speed = float(scene.scale * TURN * scene.frequency) * n * TURN * e / (1.0 + e)
    history = vibro.simulate(scene, cycles=4000.0, start_phase=phase, start_normal_velocity=speed)
    assert {p.kind for p in history.phases[-20:]} == {"H"}
    impacts = [p.impact_velocity for p in history.phases[-20:-1]]
    assert impacts == pytest.approx([speed / e] * 19, rel=1e-6)


def test_attractors_are_followed_from_their_starts() -> None:
    scenes = [
        driven(Groups(1.49149, math.degrees(0.7034), 0.457783, 0.0429106), None),
        driven(TWO_FLIGHTS, None, 0.5618659984445926),
        driven(Groups(3.768 / math.sin(0.6), math.degrees(0.6), 0.5, 0.1), None),
    ]
    for scene in scenes:
        found = vibro.attractors(scene)
        assert len(found)
        for one in found:
            history = vibro.simulate(
                scene, cycles=400.0, start_phase=one.start_phase, start_velocity=one.start_velocity,
                start_normal_velocity=one.start_normal_velocity,
            )  # fmt: skip
            assert history.period_cycles == one.period_cycles
            assert history.cycle_displacement == pytest.approx(one.displacement_per_cycle, rel=1e-9)
            assert sorted(history.pattern) == sorted(one.pattern)
