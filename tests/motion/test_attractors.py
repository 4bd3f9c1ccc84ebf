"""Motions of bodies from many starts: against ``solve``, a walk from random phases, and integrated bodies."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pytest
from engines.integrated import TURN, Body
from engines.two_axis_walk import Body as WalkedBody
from helpers.scenes import GRAVITY, Groups, at_load, driven, random_scenes, replaced

import vibro
from vibro import Scene, Status

if TYPE_CHECKING:
    from collections.abc import Iterator

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
    scene = at_load(load, drive, mu_s, mu_s * random.uniform(0.02, 0.3, count))
    return replaced(scene, restitution=random.choice([0.0, 0.1, 0.3, 0.5, 0.7], count))


@pytest.mark.parametrize(
    "scene",
    [
        hopping(100, 1),
        random_scenes(200, 2, least_ratio=0.01),
        random_scenes(100, 3, most_trough_deg=20.0, least_ratio=0.05),
    ],
    ids=["hopping", "level", "inclined"],
)
def test_the_motion_from_rest_is_that_of_solve_and_shares_are_its(scene: Scene) -> None:
    whole, several = vibro.solve(scene, starts=16), 0
    for i, one in enumerate(cells(scene)):
        cycle, found = vibro.solve(one), vibro.attractors(one, 16)
        kinds = len(found) + (found.irregular_share > 0.0)
        assert math.fsum(x.share for x in found) + found.irregular_share + found.lost / 16 == 1.0
        assert [x.from_rest for x in found[1:]] == [False] * len(found[1:])
        assert all(0.0 <= x.share_low <= x.share <= x.share_high <= 1.0 for x in found)
        assert all(x.share_high - x.share_low > 0.1 for x in found)
        several += kinds > 1 or found.runs_away
        if cycle.regime == vibro.Regime.HOPPING:
            assert whole.coexists[i] == (kinds > 1)
        elif Status(int(cycle.status)).answered:
            assert (len(found) > 1 or found.runs_away) == (cycle.coexists == 1)
        share = next((x.share for x in found if x.from_rest), found.irregular_share)
        if cycle.status in (Status.OK, Status.BOUNDARY):
            assert found[0].from_rest
            assert found[0].pattern == cycle.pattern
            assert found[0].regime == cycle.regime
            assert found[0].period_cycles == cycle.period_cycles
            scale = abs(cycle.displacement_per_cycle) + 1e-3 * float(one.scale)
            assert abs(found[0].displacement_per_cycle - cycle.displacement_per_cycle) < 1e-9 * scale
            assert found[0].largest_multiplier == pytest.approx(cycle.largest_multiplier, abs=1e-7)
            assert found[0].peak_velocity == pytest.approx(cycle.peak_velocity, rel=1e-9, abs=1e-15)
        if math.isnan(cycle.mean_velocity):
            assert math.isnan(whole.share[i])
            continue
        assert whole.share[i] == share
        means = whole.mean_velocity_over_starts[i], found.mean_velocity
        assert means[0] == pytest.approx(means[1], rel=1e-9, abs=1e-15, nan_ok=True)
    assert several


class Walked(NamedTuple):
    """Where walks from random phases have got to: shares by motion, and of those that repeat as none."""

    shares: list[float]
    other: float
    speed: float


def walked(scene: Scene, found: vibro.Attractors, bodies: int, seed: int, legs: int) -> Walked:
    """Follow bodies from random phases by the walk, and compare their last cycles with the motions."""
    pick, counts, others = np.random.default_rng(seed), [0] * len(found), []
    speeds = [one.mean_velocity for one in found]
    apart = min(abs(x - y) for x, y in itertools.combinations(speeds, 2))  # some walks get there slowly
    for _ in range(bodies):
        body = walker(scene)
        body.p = pick.uniform(0.0, TURN)
        times, paths = [0.0], [0.0]
        for leg in itertools.islice(body.legs(), legs):
            if not math.isfinite(leg.length):  # it rests for good
                times.append(times[-1] + 200.0 * TURN)
                paths.append(paths[-1])
                break
            times.append(times[-1] + leg.length)
            paths.append(paths[-1] + leg.path)
        end, unit = times[-1], body.unit * TURN * float(scene.frequency)

        def speed(begin: float, stop: float, at: Any = (times, paths), unit: float = unit) -> float:
            return unit * float(np.interp(stop, *at) - np.interp(begin, *at)) / (stop - begin)

        for i, one in enumerate(found):
            turns = TURN * one.period_cycles
            speeds = [speed(end - (k + 1) * turns, end - k * turns) for k in range(2)]
            if max(abs(x - one.mean_velocity) for x in speeds) < 0.02 * apart:
                counts[i] += 1
                break
        else:
            others.append(speed(0.5 * end, end))
    mean = math.fsum(others) / len(others) if others else math.nan
    return Walked([count / bodies for count in counts], len(others) / bodies, mean)


def walker(scene: Scene) -> WalkedBody:
    """Put a body at rest on the trough, to be followed apart from the package."""
    fields = {name: float(value) for name, value in scene.arrays()._asdict().items()}
    along, normal, phase = (
        fields.get(name, 0.0) for name in ("along_amplitude", "normal_amplitude", "normal_phase")
    )
    if "amplitude" in fields:
        along, normal = (fields["amplitude"] * f(fields["drive_angle"]) for f in (math.cos, math.sin))
    names = ("frequency", "static_friction", "kinetic_friction", "trough_angle", "gravity", "restitution")
    frequency, mu_s, mu_d, trough, gravity, e = (fields[name] for name in names)
    return WalkedBody(along, normal, phase, frequency, mu_s, mu_d, trough, gravity, e)


def slippery(count: int, seed: int, *, ellipse: bool) -> Iterator[tuple[Scene, vibro.Attractors]]:
    """Draw scenes that have several motions, in contact and with hops."""
    pick = np.random.default_rng(seed)
    while count > 0:
        mu_s, trough = pick.uniform(0.1, 0.8), pick.choice([0.0, 0.02])
        angle, throw = math.radians(pick.uniform(15.0, 50.0)), pick.uniform(0.85, 1.6)
        mu_d = max(mu_s * pick.uniform(0.03, 0.2), 1.2 * trough)
        phase = math.degrees(pick.uniform(-0.3, 0.3)) if ellipse else None
        load = throw / math.sin(angle)
        groups = Groups(load, math.degrees(angle), max(mu_s, mu_d), mu_d, math.degrees(trough))
        scene = driven(groups, phase, float(pick.choice([0.0, 0.0, 0.2, 0.4])))
        found = vibro.attractors(scene)
        if sum(one.share > 0.1 for one in found) > 1:
            count -= 1
            yield scene, found


@pytest.mark.parametrize(("ellipse", "seed"), [(False, 21), (True, 22)])
def test_shares_are_those_of_walks_from_random_phases(ellipse: bool, seed: int) -> None:
    """Nothing is shared with tests/engines/two_axis_walk.py; shares are within 4 combined errors."""
    bodies = 16
    for scene, found in slippery(3, seed, ellipse=ellipse):
        seen = walked(scene, found, bodies, seed, 400)
        for one, share in zip(found, seen.shares, strict=True):
            errors = [math.sqrt(max(x * (1.0 - x), 0.05) / n) for x, n in ((one.share, 64), (share, bodies))]
            assert abs(one.share - share) < 4.0 * math.hypot(*errors)
        assert seen.other <= found.irregular_share + 4.0 * math.sqrt(0.05 / bodies)


def drop_of_one_bounce(scene: Scene) -> float:
    """Height over a trough at rest of a flight that lasts a drive cycle [m]."""
    return 0.5 * math.pi**2 * GRAVITY / (TURN * float(scene.frequency)) ** 2


def test_bodies_with_any_velocity_end_in_one_of_them() -> None:
    scene = driven(LOW_FRICTION, None)
    found = vibro.attractors(scene)
    assert {one.pattern for one in found} == {"F_", "FB"}
    scale, random, met = float(scene.scale), np.random.default_rng(7), set()
    for _ in range(2):
        body = Body(LOW_FRICTION, phase=random.uniform(0.0, TURN), velocity=random.uniform(-3.0, 3.0))
        body.until(body.p + 80.0 * TURN)
        before = body.state[0]
        body.until(body.p + TURN)
        ends = [abs(scale * (body.state[0] - before) - one.displacement_per_cycle) for one in found]
        assert min(ends) < 1e-3 * scale
        met.add(int(np.argmin(ends)))
    assert met == {0, 1}


def test_a_cycle_of_flights_begins_where_it_says() -> None:
    scene = driven(TWO_FLIGHTS, None, BOUNCING)
    height = drop_of_one_bounce(scene)
    (one,) = (one for one in vibro.attractors(scene, drops=height) if one.pattern == "H")
    speed = float(scene.scale * TURN * scene.frequency)
    body = Body(TWO_FLIGHTS, BOUNCING, phase=one.start_phase, velocity=one.start_velocity / speed)
    body.aloft, body.state[3] = True, one.start_normal_velocity / speed
    body.until(one.start_phase + TURN + 1e-9)
    assert body.state[0] == pytest.approx(one.displacement_per_cycle / float(scene.scale), abs=1e-6)
    assert body.state[1] * speed == pytest.approx(one.start_velocity, abs=1e-6 * speed)
    assert body.state[3] * speed == pytest.approx(one.start_normal_velocity, rel=1e-6)


def test_what_starts_can_tell_is_said() -> None:
    known = vibro.attractors(driven(LOW_FRICTION, None))
    assert "all motions are known" in repr(known)
    assert [f"{1e3 * one.mean_velocity:.6g}" for one in known] == ["107.156", "9.49547"]
    many = vibro.attractors(driven(LOW_FRICTION, None), 360)
    assert many[1].share == pytest.approx(0.831, abs=1e-3)
    assert known[1].share_low < many[1].share < known[1].share_high
    bounces_on = vibro.attractors(driven(LOW_FRICTION, None, 0.7), 16)
    assert not bounces_on.complete
    assert f"motions of less than {bounces_on.missed:.2g} of all starts may be missing" in bounces_on.covered
    assert vibro.attractors(driven(LOW_FRICTION, None), 64).missed == pytest.approx(0.0566, abs=1e-4)
    irregular = vibro.attractors(replaced(at_load(8.0, 20.0, 0.5, 0.4), restitution=0.8), 16)
    assert irregular.irregular_share == 1.0
    assert not len(irregular)
    assert "a share of 1 does not repeat" in repr(irregular)
    cycle = vibro.solve(replaced(at_load(8.0, 20.0, 0.5, 0.4), restitution=0.8))
    error = math.hypot(cycle.mean_velocity_error, irregular.irregular_velocity_error)
    assert abs(irregular.irregular_velocity - cycle.mean_velocity) < 4.0 * error
    assert irregular.mean_velocity == irregular.irregular_velocity
    assert "from rest" in vibro.attractors(driven(TWO_FLIGHTS, None, BOUNCING))._repr_html_()
    frame = known.to_frame()
    assert list(frame["from_rest"]) == [True, False]
    assert frame["share"].sum() == 1.0


@pytest.mark.parametrize(
    ("more", "field"),
    [
        ({"starts": 0}, "starts"), ({"starts": 4097}, "starts"), ({"starts": 8.0}, "starts"),
        ({"starts": True}, "starts"), ({"drops": -1e-3}, "drops"), ({"drops": math.nan}, "drops"),
        ({"drops": 1e13}, "drops"),
    ],
)  # fmt: skip
def test_wrong_starts_are_refused(more: dict[str, Any], field: str) -> None:
    with pytest.raises(vibro.VibroError, match=field):
        vibro.attractors(driven(LOW_FRICTION, None), **more)


def test_dropped_bodies_get_into_bounces_that_laid_ones_do_not() -> None:
    """K = 0.944 of e = 0.55 bears the cycle of one bounce, Eq. (37), which no body laid down gets into."""
    e = 0.55
    throw = 1.03 * math.pi * (1.0 - e) / (1.0 + e)
    scene = driven(Groups(throw / math.sin(0.5), math.degrees(0.5), 0.6, 0.5), None, e)
    height = drop_of_one_bounce(scene)
    (laid,), dropped = vibro.attractors(scene), vibro.attractors(scene, drops=height)
    assert "H" not in laid.pattern
    bounce = next(one for one in dropped if one.pattern == "H")
    assert bounce.regime == vibro.Regime.HOPPING
    assert 0.02 < bounce.share < 0.5
    history = vibro.simulate(
        scene, cycles=300.0, start_phase=bounce.start_phase, start_velocity=bounce.start_velocity,
        start_normal_velocity=bounce.start_normal_velocity,
    )  # fmt: skip
    assert history.cycle_displacement == pytest.approx(bounce.displacement_per_cycle, rel=1e-8)
    assert f"dropped from {1e3 * height:.6g} mm" in repr(dropped)


def test_the_cycle_of_one_bounce_doubles_where_its_closed_form_says() -> None:
    """Eq. (72): e = 0.5 doubles at K = 1.5268, where the multiplier passes -1, and is born at pi / 3."""
    e = 0.5
    born = math.pi * (1.0 - e) / (1.0 + e)
    doubles = math.hypot(born, 2.0 * (1.0 + e * e) / (1.0 + e) ** 2)
    assert doubles == pytest.approx(1.5268, abs=5e-5)

    def flights(throw: float) -> dict[str, vibro.Attractor]:
        scene = driven(Groups(throw / math.sin(0.5), math.degrees(0.5), 0.6, 0.5), None, e)
        found = vibro.attractors(scene, 256, drops=drop_of_one_bounce(scene))
        return {one.pattern: one for one in found if set(one.pattern) == {"H"}}

    for throw in (1.02 * born, 1.3, doubles - 1e-6):
        # the trace and the determinant of (34) over one flight
        lift = math.sqrt(throw**2 - born**2)
        trace, determinant = 1.0 + e * e - (1.0 + e) ** 2 * lift, e * e
        expected = max(abs(np.roots([1.0, -trace, determinant])))
        slides = flights(throw)["H"].largest_multiplier
        assert slides == pytest.approx(expected, rel=1e-7)
    assert flights(doubles - 1e-6)["H"].largest_multiplier == pytest.approx(1.0, abs=1e-5)
    assert "H" not in flights(born * (1.0 - 1e-9))
    doubled = flights(doubles + 1e-4)
    assert "H" not in doubled
    assert doubled["HH"].period_cycles == 2
