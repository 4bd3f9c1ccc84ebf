"""Frictions that give a speed, against scans by independent engines; the friction at which nothing slips."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from engines import harmonic_walk, steps_walk, two_axis_walk
from helpers.cases import each
from helpers.draws import draws

import vibro
from vibro import InputError, Motion, Scene, SceneError, Status, solve
from vibro.inverse_friction import LEAST_FRICTION, MOST_FRICTION

if TYPE_CHECKING:
    from collections.abc import Callable

    Speed = Callable[[float, float], float]

ANY: dict[str, Any] = {"static_friction": 1.0, "kinetic_friction": 1.0}
FREQUENCY, GRAVITY = 25.0, 9.81
UNIT = GRAVITY / (math.tau * FREQUENCY) ** 2  # [m]


def nut(**values: Any) -> Scene:
    given = {"amplitude": 1e-3, "frequency": 15.0, "drive_angle": math.radians(20.0), **ANY}
    return Scene(**(given | values))


def _with(scene: Scene, mu_s: Any, mu_d: Any) -> Scene:
    values = {name: getattr(scene, name) for name in scene.__dataclass_fields__}
    return Scene(**{**values, "static_friction": mu_s, "kinetic_friction": mu_d})


def two_axes(random: np.random.Generator, *, line: bool, throw: float) -> tuple[Scene, Speed]:
    """Draw a line, or an ellipse, by its throw number; and a walk with given frictions."""
    trough = float(random.uniform(-0.2, 0.2) * random.integers(0, 2))
    along, lead = float(np.exp(random.uniform(math.log(0.3), math.log(4.0)))), 0.0
    normal = throw * math.cos(trough)
    if not line:
        lead = float(random.uniform(-math.pi, math.pi))
    e = float(random.choice([0.0, 0.0, 0.2])) if throw > 1.0 else 0.0
    given = {"frequency": FREQUENCY, "trough_angle": trough, "gravity": GRAVITY, "restitution": e, **ANY}
    if line:
        size, angle = math.hypot(along, normal) * UNIT, math.atan2(normal, along)
        scene = Scene(amplitude=size, drive_angle=angle, **given)
        along, normal = size * math.cos(angle) / UNIT, size * math.sin(angle) / UNIT
    else:
        scene = Scene(
            along_amplitude=along * UNIT, normal_amplitude=normal * UNIT, normal_phase=lead, **given
        )

    def speed(mu_s: float, mu_d: float) -> float:
        body = two_axis_walk.Body(
            along * UNIT, normal * UNIT, lead, FREQUENCY, mu_s, mu_d, trough, GRAVITY, e
        )
        try:
            return body.settle(200 if throw > 1.0 else 4000).displacement * body.unit * FREQUENCY
        except (two_axis_walk.NeverEndsError, two_axis_walk.NeverSettlesError):
            return math.nan

    return scene, speed


def harmonics(random: np.random.Generator) -> tuple[Scene, Speed]:
    """Draw a drive with two or three harmonics that keeps bodies in contact."""
    count = int(random.integers(2, 4))
    n = np.arange(1, count + 1)
    along = random.uniform(0.2, 1.0, count) * float(np.exp(random.uniform(-0.5, 1.2))) / n**2
    normal = random.uniform(0.1, 0.3, count) / n**2
    phases = random.uniform(-math.pi, math.pi, (2, count))
    pairs = [
        list(zip(sizes.tolist(), p.tolist(), strict=True))
        for sizes, p in zip((along, normal), phases, strict=True)
    ]
    trough = float(random.uniform(-0.2, 0.2) * random.integers(0, 2))
    scene = Scene(
        along_harmonics=pairs[0], normal_harmonics=pairs[1], frequency=1.0 / math.tau, trough_angle=trough,
        gravity=1.0, **ANY,
    )  # fmt: skip
    waves = [
        [(k * k * size * math.cos(p), k * k * size * math.sin(p)) for k, (size, p) in enumerate(pair, 1)]
        for pair in pairs
    ]

    def speed(mu_s: float, mu_d: float) -> float:
        try:
            return (
                harmonic_walk.Drive(waves[0], waves[1], mu_s, mu_d, trough).settle().displacement / math.tau
            )
        except ArithmeticError:
            return math.nan

    return scene, speed


def steps(random: np.random.Generator) -> tuple[Scene, Speed]:
    """Draw a trough of constant accelerations."""
    size = int(random.integers(2, 5))
    shares = random.dirichlet(np.ones(size))
    along, normal = random.normal(0.0, 6.0, size), random.normal(0.0, 1.5, size) * random.integers(0, 2)
    along, normal = (x - (shares * x).sum() for x in (along, normal))
    given = Motion.steps(
        along=list(zip(shares.tolist(), along.tolist(), strict=True)),
        normal=list(zip(shares.tolist(), normal.tolist(), strict=True)),
    )
    trough = float(random.uniform(-0.1, 0.1) * random.integers(0, 2))
    scene = Scene(motion=given, frequency=5.0, trough_angle=trough, **ANY)

    def speed(mu_s: float, mu_d: float) -> float:
        weight = GRAVITY * math.cos(trough), GRAVITY * math.sin(trough)
        levels = list(zip(shares.tolist(), along.tolist(), normal.tolist(), strict=True))
        return steps_walk.displacement(steps_walk.Drive(levels, mu_s, mu_d, *weight, 0.2)) / 0.2

    return scene, speed


def question(kind: str, random: np.random.Generator) -> tuple[Scene, Speed]:
    if kind in ("harmonics", "steps"):
        return harmonics(random) if kind == "harmonics" else steps(random)
    line = kind == "line" or (kind == "hops" and random.uniform() < 0.5)
    return two_axes(
        random, line=line, throw=float(random.uniform(*((1.05, 2.0) if kind == "hops" else (0.05, 0.99))))
    )


@pytest.mark.parametrize(
    ("kind", "count", "scan", "dense"),
    [
        ("line", 8, 28, 10_000),
        ("ellipse", 6, 28, 10_000),
        ("hops", 5, 12, 8_000),
        ("harmonics", 3, 8, 1_000),
        ("steps", 4, 28, 4_000),
    ],
)
def test_all_frictions_are_found_and_none_is_invented(kind: str, count: int, scan: int, dense: int) -> None:
    """Scans by engines that share no code, and denser ones at random frictions by the solver."""
    random = np.random.default_rng(520)
    solutions = 0
    for _ in range(draws(count)):
        scene, speed = question(kind, random)
        ratio = float(random.choice([0.8, 1.0, random.uniform(0.5, 1.0)]))
        x = np.geomspace(0.02, MOST_FRICTION, scan) * 0.999
        walked = np.array([speed(max(mu / ratio, mu), mu) for mu in x.tolist()])
        moves = walked[walked > 0.0]
        target = 0.01 if not moves.size else float(random.uniform(0.9 * moves.min(), 1.02 * moves.max()))
        found = vibro.friction_for_speed(scene, target, ratio=ratio)
        here = f"{scene!r} {target!r} {ratio!r}"
        for one in found.solutions:
            if not one.error:
                again = speed(one.static_low, one.low)
                assert math.isnan(again) or again == pytest.approx(target, rel=1e-7), here
        for jump in found.jumps:
            sides = [speed(max(mu / ratio, mu), mu) for mu in (jump.low * (1 - 1e-9), jump.high * (1 + 1e-9))]
            assert any(map(math.isnan, sides)) or min(sides) < target < max(sides), here
        if found.fastest.error == 0.0 and not found.unanswered:
            known = walked[~np.isnan(walked)]
            assert known.max() <= found.fastest.speed_low * (1.0 + 1e-8) + 1e-12, here
            assert known.min() >= found.slowest.speed_low - 1e-8 * target, here
        _same_changes(x, walked, target, found, here)
        if not any(one.error for one in (*found.solutions, found.fastest)):
            kinetic = np.sort(
                np.exp(random.uniform(math.log(LEAST_FRICTION), math.log(MOST_FRICTION), dense))
            )
            denser = _with(scene, np.maximum(kinetic / ratio, kinetic), kinetic)
            _same_changes(kinetic, solve(denser).mean_velocity, target, found, here)
            solutions += len(found.solutions)
    assert solutions > 0.5 * count


def _same_changes(x: Any, speeds: Any, target: float, found: Any, here: str) -> None:
    """Between neighbours on both sides of the target lies an odd number of solutions, else an even one."""
    places = np.array([one.low for one in (*found.solutions, *found.jumps)])
    known = ~np.isnan(speeds)
    for i in np.flatnonzero(known[1:] & known[:-1]):
        between = int(((places > x[i]) & (places <= x[i + 1])).sum())
        assert between % 2 == ((speeds[i] > target) != (speeds[i + 1] > target)), (
            here,
            x[i],
            x[i + 1],
            between,
        )


def test_all_of_a_level_stretch_is_one_solution() -> None:
    """A trough that drops its part in steps, which sticks at once where it lands if friction is large."""
    thrown = Motion.steps(along=[(0.5, 8.0), (0.5, -8.0)], normal=[(0.5, 14.0), (0.5, -14.0)])
    scene = Scene(motion=thrown, frequency=10.0, **ANY)
    level = float(solve(scene).mean_velocity)
    found = vibro.friction_for_speed(scene, level)
    (one,) = found.solutions
    assert one.high == MOST_FRICTION
    kinetic = one.low * np.array([0.99, 1.0 + 1e-12])
    beside = solve(_with(scene, kinetic / 0.8, kinetic)).mean_velocity
    assert abs(beside[0] - level) > 1e-9 * level
    assert beside[1] == pytest.approx(level, rel=2e-10)
    assert not vibro.friction_for_speed(scene, level * 1.0001).solutions


def test_the_fastest_friction_is_a_solution_and_beyond_it_is_none() -> None:
    scene = Scene(along_amplitude=2e-3, normal_amplitude=3e-4, normal_phase=-1.0, frequency=25.0, **ANY)
    fastest = vibro.friction_for_speed(scene, 0.01).fastest
    near = fastest.low * np.linspace(0.99, 1.01, 20_001)
    most = float(solve(_with(scene, near / 0.8, near)).mean_velocity.max())
    assert fastest.speed_low == pytest.approx(most, rel=2e-10)
    assert len(vibro.friction_for_speed(scene, most * (1.0 - 1e-9)).solutions) == 2
    (touching,) = vibro.friction_for_speed(scene, fastest.speed_low).solutions
    assert touching.low == pytest.approx(fastest.low, rel=1e-4)
    assert len(vibro.friction_for_speed(scene, fastest.speed_low * (1.0 - 1e-6)).solutions) == 2
    assert not vibro.friction_for_speed(scene, fastest.speed_low * (1.0 + 1e-9)).solutions


def test_a_speed_that_is_jumped_over_is_no_solution() -> None:
    """Below its onset a part does not creep: speeds between rest and the least slide are made by none."""
    scene = nut(trough_angle=-0.1, amplitude=0.9e-3)
    threshold = float(vibro.critical_friction(scene).forward)
    slow = float(solve(_with(scene, threshold * (1.0 - 1e-9), 0.8 * threshold * (1.0 - 1e-9))).mean_velocity)
    found = vibro.friction_for_speed(scene, 0.5 * slow)
    assert not found.solutions
    (jump,) = found.jumps
    assert jump.static_low == pytest.approx(threshold, rel=1e-12)
    assert jump.speed_low == pytest.approx(slow, rel=1e-3)
    assert jump.speed_high == 0.0
    assert found.slowest.low == jump.high
    assert found.slowest.high == MOST_FRICTION
    assert [one.status for one in found.unanswered] == [Status.RUNAWAY]
    assert 0.99 * math.tan(0.1) < found.unanswered[0].high <= math.tan(0.1)


def test_static_friction_may_be_known() -> None:
    scene = nut(static_friction=0.74, kinetic_friction=0.1)
    target = float(solve(_with(scene, 0.74, 0.57)).mean_velocity)
    found = vibro.friction_for_speed(scene, target, ratio=None)
    assert any(one.low == pytest.approx(0.57, rel=1e-12) for one in found.solutions)
    assert all(one.static_low == 0.74 and one.low <= 0.74 for one in found.solutions)


def test_means_of_irregular_motion_carry_their_error() -> None:
    scene = nut(amplitude=2e-3, frequency=25.0, drive_angle=math.radians(25.0), restitution=0.3)
    found = vibro.friction_for_speed(scene, 0.19)
    assert found.solutions
    for one in found.solutions:
        assert one.error > 0.0
        middle = math.sqrt(one.low * one.high)
        cycle = solve(_with(scene, middle / 0.8, middle))
        assert abs(float(cycle.mean_velocity) - 0.19) < 6.0 * (float(cycle.mean_velocity_error) + one.error)
    assert not vibro.friction_for_speed(scene, 0.3).solutions


def test_without_flights_a_part_that_hops_has_no_speed() -> None:
    found = vibro.friction_for_speed(nut(amplitude=4e-3), 0.1, flight=False)
    assert found.unanswered == ((LEAST_FRICTION, MOST_FRICTION, Status.FLIGHT_NOT_MODELLED),)
    assert not found.solutions
    assert math.isnan(found.fastest.low)


@each(
    ("wrong", "message"),
    [
        ({"speed": 0}, "speed = 0 m/s: must be finite and > 0 m/s"),
        ({"speed": -0.1}, "speed = -0.1 m/s"),
        ({"speed": math.inf}, "speed = inf m/s"),
        ({"speed": math.nan}, "speed = nan m/s"),
        ({"speed": "fast"}, "speed = 'fast': must be"),
        ({"ratio": 0.0}, r"ratio = 0: must be in \(0, 1\]"),
        ({"ratio": 1.1}, "ratio = 1.1"),
        (
            {"ratio": None, "scene": nut(static_friction=0.0, kinetic_friction=0.0)},
            "static_friction = 0: must be > 1e-06",
        ),
    ],
)
def test_wrong_arguments_are_named(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        vibro.friction_for_speed(**{"scene": nut(), "speed": 0.01, **wrong})


def test_one_operating_point_is_searched_at_a_time() -> None:
    with pytest.raises(SceneError, match="one operating point"):
        vibro.friction_for_speed(nut(frequency=[15.0, 20.0]), 0.01)


# ------------------------------------------------------------------------------
# The least static friction at which nothing slips.


def test_the_critical_friction_of_a_line_is_a_closed_form() -> None:
    load, angle, trough = 1.3, math.radians(20.0), np.array([-0.3, 0.0, 0.3])
    scene = nut(amplitude=load * GRAVITY / (math.tau * 15.0) ** 2, drive_angle=angle, trough_angle=trough)
    found = vibro.critical_friction(scene)
    a, b = load * math.cos(angle), load * math.sin(angle)
    assert found.forward == pytest.approx((a - np.sin(trough)) / (np.cos(trough) - b), rel=1e-13)
    assert found.back == pytest.approx((a + np.sin(trough)) / (np.cos(trough) + b), rel=1e-13)


@pytest.mark.parametrize("kind", ["line", "ellipse", "harmonics", "steps"])
def test_nothing_slips_from_the_critical_friction_on(kind: str) -> None:
    random = np.random.default_rng(52)
    for _ in range(draws(10)):
        scene, _ = question(kind, random)
        found = vibro.critical_friction(scene)
        least = max(float(found.forward), float(found.back))
        if math.isinf(least):
            assert solve(scene).throw_number > 1.0
            continue
        friction = least * np.array([1.0 - 1e-12, 1.0, 1.0 + 1e-12])
        below, *others = solve(_with(scene, friction, friction), output="regimes").regime.tolist()
        assert others == [0, 0], scene
        assert below in (1, 2), scene
        for one, ratio in ((found.forward, "forward_ratio"), (found.back, "back_ratio")):
            if one > 0.0:
                friction = one * np.array([1.0 - 1e-12, 1.0])
                cycle = solve(_with(scene, friction, friction), output="regimes")
                assert getattr(cycle, ratio)[0] > 1.0 >= getattr(cycle, ratio)[1], scene


def test_no_friction_holds_a_part_that_hops() -> None:
    found = vibro.critical_friction(nut(amplitude=[1e-3, 4e-3]))
    assert np.isfinite(found).tolist() == [[True, False], [True, False]]
    still = vibro.critical_friction(nut(amplitude=1e-12))
    assert 0.0 < still.forward < 1e-6
