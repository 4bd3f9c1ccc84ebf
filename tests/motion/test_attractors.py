"""Cycles that coexist: against ``solve`` and its flag, and against bodies that SciPy integrates."""

from __future__ import annotations

import math

import numpy as np
import pytest
from engines.integrated import TURN, Body
from helpers.scenes import Groups, at_load, driven, random_scenes, replaced

import vibro
from vibro import Scene, Status

LOW_FRICTION = Groups(1.49149, math.degrees(0.7034), 0.457783, 0.0429106)
BOUNCING = 0.5618659984445926
TWO_FLIGHTS = Groups(
    0.0012534742194341873 * (TURN * 20.0) ** 2 / 9.81,
    math.degrees(0.6448704695649682), 0.46894843081393256, 0.39128583597305744,
)  # fmt: skip


def cells(scene: Scene) -> list[Scene]:
    names = ("amplitude", "frequency", "drive_angle", "static_friction", "kinetic_friction", "trough_angle")
    columns = {name: np.broadcast_to(getattr(scene, name), scene.shape) for name in (*names, "restitution")}
    return [
        Scene(**{name: x.flat[i] for name, x in columns.items()}) for i in range(scene.static_friction.size)
    ]


def hopping(count: int, seed: int) -> Scene:
    random = np.random.default_rng(seed)
    drive, mu_s = random.uniform(10.0, 50.0, count), random.uniform(0.1, 1.0, count)
    load = 1.02 * (4.0 / 1.02) ** random.random(count) / np.sin(np.radians(drive))
    scene = at_load(load, drive, mu_s, mu_s * random.uniform(0.02, 1.0, count))
    return replaced(scene, restitution=random.choice([0.0, 0.1, 0.3, 0.5, 0.7], count))


@pytest.mark.parametrize(
    "scene",
    [
        hopping(100, 1),
        random_scenes(100, 2, least_ratio=0.01),
        random_scenes(60, 3, most_trough_deg=20.0, least_ratio=0.05),
    ],
    ids=["hopping", "level", "inclined"],
)
def test_there_are_others_where_the_flag_says_so(scene: Scene) -> None:
    flagged = 0
    for one in cells(scene):
        cycle, found = vibro.solve(one, coexistence=True), vibro.attractors(one)
        others = [other for other in found if not other.from_rest]
        if cycle.coexists >= 0:
            assert (bool(others) or found.runs_away) == (cycle.coexists == 1)
        flagged += cycle.coexists == 1
        assert [one.from_rest for one in found[1:]] == [False] * len(found[1:])
        if cycle.status in (Status.OK, Status.BOUNDARY):
            assert found[0].from_rest
            assert found[0].pattern == cycle.pattern
            assert found[0].period_cycles == cycle.period_cycles
            scale = abs(cycle.displacement_per_cycle) + 1e-3 * float(one.scale)
            assert abs(found[0].displacement_per_cycle - cycle.displacement_per_cycle) < 1e-9 * scale
            assert found[0].largest_multiplier == pytest.approx(cycle.largest_multiplier, abs=1e-7)
    assert flagged > 2


@pytest.mark.parametrize(
    ("groups", "restitution", "patterns"),
    [(LOW_FRICTION, 0.0, {"F_", "FB"}), (TWO_FLIGHTS, BOUNCING, {"H" * 33 + "FBF", "H"})],
)
def test_bodies_from_anywhere_end_in_one_of_them(
    groups: Groups, restitution: float, patterns: set[str]
) -> None:
    scene = driven(groups, None, restitution)
    found = vibro.attractors(scene)
    assert {one.pattern for one in found} == patterns
    assert not found.unsettled
    scale, random, met = float(scene.scale), np.random.default_rng(7), set()
    for _ in range(2):
        body = Body(groups, restitution, phase=random.uniform(0.0, TURN), velocity=random.uniform(-3.0, 3.0))
        if restitution:
            body.aloft, body.state[2:] = True, (0.0, random.uniform(0.5, 1.5))
        body.until(body.p + (20.0 if restitution else 80.0) * TURN)
        before = body.state[0]
        body.until(body.p + TURN)
        ends = [abs(scale * (body.state[0] - before) - one.displacement_per_cycle) for one in found]
        assert min(ends) < 1e-3 * scale
        met.add(int(np.argmin(ends)))
    assert met == {0, 1}


def test_a_cycle_of_flights_begins_where_it_says() -> None:
    scene = driven(TWO_FLIGHTS, None, BOUNCING)
    (one,) = (one for one in vibro.attractors(scene) if one.pattern == "H")
    speed = float(scene.scale * TURN * scene.frequency)
    body = Body(TWO_FLIGHTS, BOUNCING, phase=one.start_phase, velocity=one.start_velocity / speed)
    body.aloft, body.state[3] = True, one.start_normal_velocity / speed
    body.until(one.start_phase + TURN + 1e-9)
    assert body.state[0] == pytest.approx(one.displacement_per_cycle / float(scene.scale), abs=1e-6)
    assert body.state[1] * speed == pytest.approx(one.start_velocity, abs=1e-6 * speed)
    assert body.state[3] * speed == pytest.approx(one.start_normal_velocity, rel=1e-6)


def test_what_the_search_covered_is_said() -> None:
    assert "all cycles are known" in repr(vibro.attractors(driven(LOW_FRICTION, None)))
    bounces_on = vibro.attractors(driven(LOW_FRICTION, None, 0.7))
    assert not bounces_on.complete
    assert "were not searched" in bounces_on.covered
    irregular = vibro.attractors(replaced(at_load(8.0, 20.0, 0.5, 0.4), restitution=0.8))
    assert irregular.unsettled > 0
    assert f"{irregular.starts} starts followed, {irregular.unsettled} led to no cycle" in repr(irregular)
    assert "from rest" in vibro.attractors(driven(TWO_FLIGHTS, None, BOUNCING))._repr_html_()
    frame = vibro.attractors(driven(TWO_FLIGHTS, None, BOUNCING)).to_frame()
    assert list(frame["from_rest"]) == [True, False]


def test_a_body_at_rest_and_what_cannot_be_followed() -> None:
    (rest,) = vibro.attractors(at_load(0.1, 20.0, 0.74, 0.57))
    assert (rest.pattern, rest.mean_velocity, rest.largest_multiplier, rest.stable) == ("_", 0.0, 0.0, True)


def test_the_cycle_of_one_bounce_doubles_where_its_closed_form_says() -> None:
    """Eq. (72): e = 0.5 doubles at K = 1.5268, where the multiplier passes -1, and is born at pi / 3."""
    e = 0.5
    born = math.pi * (1.0 - e) / (1.0 + e)
    doubles = math.hypot(born, 2.0 * (1.0 + e * e) / (1.0 + e) ** 2)
    assert doubles == pytest.approx(1.5268, abs=5e-5)

    def flights(throw: float) -> dict[str, vibro.Attractor]:
        scene = driven(Groups(throw / math.sin(0.5), math.degrees(0.5), 0.6, 0.5), None, e)
        return {one.pattern: one for one in vibro.attractors(scene) if set(one.pattern) == {"H"}}

    for throw in (born + 1e-4, 1.3, doubles - 1e-6):
        # the trace and the determinant of (34) over one flight
        lift = math.sqrt(throw**2 - born**2)
        trace, determinant = 1.0 + e * e - (1.0 + e) ** 2 * lift, e * e
        expected = max(abs(np.roots([1.0, -trace, determinant])))
        slides = flights(throw)["H"].largest_multiplier
        assert slides == pytest.approx(expected, rel=1e-7)
    assert flights(doubles - 1e-6)["H"].largest_multiplier == pytest.approx(1.0, abs=1e-5)
    assert "H" not in flights(born - 1e-4)
    doubled = flights(doubles + 1e-4)
    assert "H" not in doubled
    assert doubled["HH"].period_cycles == 2
