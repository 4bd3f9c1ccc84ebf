"""Loads and settings of drives along a line by hand: caps, reaches, what limits a setting, the best angle."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.questions import changed

from vibro import Regime, solve
from vibro.designs import optima
from vibro.designs.guarantees import guarantee_of
from vibro.designs.optima import Found, LineOptimiser, Optimum, Range, _best
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.designs.spaces import Setting
from vibro.limits import critical_loads_of_lines, tipping_load_of_lines

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

ANGLE = math.radians(20.0)
SCENE = {"static_friction": "0.7:0.8", "kinetic_friction": "0.4:0.5"}
DRIVE = {"amplitude_mm": "0.5:2", "frequency_hz": "10:30", "drive_angle_deg": "10:40"}
DRIFT = {"amplitude_percent": 5, "frequency_percent": 1}
GROWTH = 1.05 * 1.01**2
UNIT = 9.81 / (2.0 * math.pi) ** 2  # [m] of load 1 at 1 Hz
WHOLE = Range((10.0, 30.0), (math.radians(10.0), math.radians(40.0)))


def asked(highest: Regime = Regime.BACK_SLIP, drive: Any = None, **changes: Any) -> Question:
    content = {"scene": SCENE, "drive": [DRIVE | (drive or {})], "goal": {"speed_mm_s": 5}} | changes
    spec = read_spec(changed(**content))
    return Question(spec, spec.drives[0], highest)


def optimiser(highest: Regime = Regime.BACK_SLIP, drive: Any = None, **changes: Any) -> LineOptimiser:
    return LineOptimiser(asked(highest, drive, **changes))


def caps(search: LineOptimiser, scale: float = 1.0, angle: float = ANGLE) -> dict[str, float]:
    return {name: float(cap[0, 0]) for name, cap in search._caps(np.array([[angle]]), scale).items()}


def setting_of(search: LineOptimiser, load: float) -> Setting:
    """A setting of a load at 15 Hz."""
    space = search._question.space
    return space.setting(amplitude=load * UNIT / 15.0**2, frequency=15.0, drive_angle=ANGLE)


HOP = 1.0 / math.sin(ANGLE)
SLIP = float(critical_loads_of_lines(ANGLE, 0.7, 0.5, 0.0).back_slip)


@pytest.mark.parametrize(
    ("highest", "expected"),
    [
        (Regime.FORWARD_SLIP, {"hop": HOP / GROWTH, "back slip": SLIP / GROWTH, "limit": 4.0}),
        (Regime.BACK_SLIP, {"hop": HOP / GROWTH, "limit": 4.0}),
        (Regime.HOPPING, {"limit": 4.0}),
    ],
)
def test_caps_are_nominal_loads(highest: Regime, expected: dict[str, float]) -> None:
    found = caps(optimiser(highest, {"acceleration_g": 4}, drift=DRIFT))
    assert found == pytest.approx(expected, rel=1e-9)
    for name in expected.keys() - {"limit"}:
        assert found[name] < expected[name]  # rounding must bring no body beyond


def test_caps_of_wider_bands() -> None:
    """Twice the bands and drifts about their middles."""
    wide = caps(optimiser(Regime.FORWARD_SLIP, {"acceleration_g": 4}, drift=DRIFT), 2.0)
    growth = 1.1 * 1.02**2
    slip = float(critical_loads_of_lines(ANGLE, 0.65, 0.55, 0.0).back_slip)
    assert wide == pytest.approx({"hop": HOP / growth, "back slip": slip / growth, "limit": 4.0}, rel=1e-9)


def test_parts_that_hop_end_at_a_throw_number_of_ten() -> None:
    assert caps(optimiser(Regime.HOPPING, drift=DRIFT)) == pytest.approx({"limit": 10.0 * HOP / GROWTH})
    assert caps(optimiser(Regime.HOPPING, {"acceleration_g": 4}, drift=DRIFT)) == {"limit": 4.0}


@pytest.mark.parametrize("highest", [Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING])
@pytest.mark.parametrize(("base", "tips"), [(5.0, True), (20.0, False)])
def test_parts_that_must_stay_upright_tip_or_hop(highest: Regime, base: float, tips: bool) -> None:
    part = {"half_base_mm": base, "centre_height_mm": 10}
    found = caps(optimiser(highest, drift=DRIFT, part=part))
    load = float(tipping_load_of_lines(ANGLE, 0.8, 0.0, base / 10))
    assert math.isfinite(load) is tips
    if highest is Regime.HOPPING:
        load = min(load, HOP)
    assert found["tip"] == pytest.approx(load / GROWTH, rel=1e-9)


def test_without_static_friction_no_load_is_allowed() -> None:
    found = caps(
        optimiser(Regime.FORWARD_SLIP, scene={"static_friction": "0.3:0.5", "friction_ratio": 0.8}), 10.0
    )
    assert found["back slip"] == 0.0
    assert found["hop"] == pytest.approx(HOP)


@pytest.mark.parametrize(
    ("load", "frequency", "amplitude"),
    [
        (2e-3 * 100.0 / UNIT, 10.0, 2e-3),  # the lowest frequency takes the largest amplitude
        (1e-3 * 100.0 / UNIT, 10.0, 1e-3),
        (2e-3 * 400.0 / UNIT, 20.0, 2e-3),
        (2e-3 * 900.0 / UNIT, 30.0, 2e-3),
        (2e-3 * 2500.0 / UNIT, 30.0, 2e-3),  # beyond reach
        (0.1e-3 * 100.0 / UNIT, 10.0, 0.5e-3),
    ],
)
def test_a_load_is_fastest_at_the_lowest_frequency(load: float, frequency: float, amplitude: float) -> None:
    search = optimiser()
    setting = search._setting(np.array([load]), (10.0, 30.0), np.array([ANGLE]))
    turned = search._question.space.turned(setting)
    assert float(turned["frequency"][0]) == pytest.approx(frequency)
    assert float(turned["amplitude"][0]) == pytest.approx(amplitude)
    assert float(turned["drive_angle"][0]) == pytest.approx(ANGLE)


def test_settings_on_another_planet() -> None:
    """Loads are of the gravity that is given."""
    search = optimiser(scene={**SCENE, "gravity_m_s2": 1.62})
    assert search._reach(WHOLE) == pytest.approx(
        (0.5e-3 * (2 * math.pi * 10) ** 2 / 1.62, 2e-3 * (2 * math.pi * 30) ** 2 / 1.62)
    )
    setting = search._setting(np.array([3.0]), (10.0, 30.0), np.array([ANGLE]))
    assert float(search._question.load(setting)[0]) == pytest.approx(3.0)


@pytest.mark.parametrize(("share", "holds"), [(0.5, True), (1.0, True), (1.0 + 1e-11, False), (1.1, False)])
def test_a_setting_holds_up_to_its_cap(share: float, holds: bool) -> None:
    search = optimiser(Regime.FORWARD_SLIP, {"acceleration_g": 0.5}, drift=DRIFT)
    cap = caps(search)["back slip"]
    assert cap > 0.5  # the limit of the drive counts elsewhere
    setting = Setting(*(np.array([float(x)]) for x in setting_of(search, share * cap)))
    assert search._holds(setting, 1.0).tolist() == [holds]
    assert search._holds(setting, 3.0).tolist() == [share < 1.0]


def test_the_largest_load_is_the_least_of_caps_and_reach() -> None:
    angles = np.array([ANGLE, 0.5])
    reach = 2e-3 * 30.0**2 / UNIT
    assert reach > HOP
    hops = 1.0 / np.sin(angles) / GROWTH
    assert optimiser(drift=DRIFT)._tops(angles, WHOLE, 1.0) == pytest.approx(hops, rel=1e-9)
    slow = WHOLE._replace(frequency=(10.0, 12.0))
    assert optimiser()._tops(angles, slow, 1.0) == pytest.approx([2e-3 * 144.0 / UNIT] * 2)
    assert optimiser(drive={"acceleration_g": 1.3})._tops(angles, WHOLE, 1.0).tolist() == [1.3, 1.3]


@pytest.mark.parametrize(
    ("share", "known"),
    [(1.0, True), (1 - 1e-13, True), (0.999, False), (7.2, True), (36.0, True), (36.1, False), (0.0, False)],
)
def test_a_load_beyond_reach_has_no_speed(share: float, known: bool) -> None:
    """From 0.05 mm at 10 Hz to 0.2 mm at 30 Hz, which is 36 times as much."""
    search = optimiser(drive={"amplitude_mm": "0.05:0.2"})
    least = 0.05e-3 * 10.0**2 / UNIT
    value = search._value(np.array([ANGLE]), np.array([share * least]), WHOLE, 1.0)
    assert bool(np.isfinite(value[0])) is known


def test_bodies_begin_to_slip_back_at_their_own_loads() -> None:
    search = optimiser(drift=DRIFT)
    found = search._entries(np.array([ANGLE, 0.5]))
    assert found.shape == (2, search.scenarios.size)
    for row, angle in enumerate((ANGLE, 0.5)):
        load, _, _, mu_s, mu_d = search.scenarios.coordinates
        slip = critical_loads_of_lines(angle, 0.7 + 0.1 * mu_s, 0.4 + 0.1 * mu_d, 0.0).back_slip
        growth = np.where(load == 1.0, GROWTH, 0.95 * 0.99**2)
        assert found[row] == pytest.approx(slip / growth, rel=1e-9)
    never = optimiser()._entries(np.array([1.4]))
    assert not never.any()


def test_first_loads_of_a_speed_are_where_the_slowest_body_reaches_it() -> None:
    """Between the onset and the largest load, by a fine grid."""
    search = optimiser(drift=DRIFT)
    angles = np.array([0.25, 0.45])
    target = 0.02
    found = search._first_load(angles, target, WHOLE)
    for angle, load in zip(angles, found, strict=True):
        for factor, reaches in ((1.0, True), (1.0 - 1e-9, False)):
            value = search._value(np.array([angle]), np.array([load * factor]), WHOLE, 1.0)
            assert bool(value[0] >= target) is reaches
        grid = np.linspace(0.02, 1.0, 400) * load * (1 - 1e-9)
        assert np.all(search._value(np.full(400, angle), grid, WHOLE, 1.0) < target)
    assert np.isinf(search._first_load(angles, 5.0, WHOLE)).all()


def test_the_first_load_may_be_the_least_within_reach() -> None:
    """The least amplitude at the lowest frequency is faster than needed."""
    drive = {"amplitude_mm": "1.5:2", "frequency_hz": "14:30"}
    choice = WHOLE._replace(frequency=(14.0, 30.0))
    for highest in (Regime.FORWARD_SLIP, Regime.BACK_SLIP):
        search = optimiser(
            highest, drive | ({"amplitude_mm": "0.9:2"} if highest is Regime.FORWARD_SLIP else {})
        )
        least = search._reach(choice)[0]
        assert search._first_load(np.array([ANGLE]), 1e-4, choice) == pytest.approx([least], rel=1e-9)


@pytest.mark.parametrize(
    ("load", "highest", "changes", "expected"),
    [
        (0.9999985 * SLIP, Regime.FORWARD_SLIP, {}, "speed"),
        (0.9999995 * SLIP, Regime.FORWARD_SLIP, {}, "back slip"),
        (0.9999995 * HOP, Regime.BACK_SLIP, {"drive": {"amplitude_mm": "0.5:9"}}, "hop"),
        (2e-3 * 225.0 / UNIT * (1 - 5e-7), Regime.BACK_SLIP, {}, "limit"),
        (2e-3 * 225.0 / UNIT * (1 - 2e-6), Regime.BACK_SLIP, {}, "speed"),
        (1.3, Regime.BACK_SLIP, {"drive": {"acceleration_g": 1.3 * (1 + 5e-7)}}, "limit"),
        (1.3, Regime.BACK_SLIP, {"drive": {"acceleration_g": 1.3 * (1 + 2e-6)}}, "speed"),
        (1.3, Regime.BACK_SLIP, {"part": {"half_base_mm": 2, "centre_height_mm": 10}}, "tip"),
    ],
)
def test_what_limits_a_setting(load: float, highest: Regime, changes: dict[str, Any], expected: str) -> None:
    search = optimiser(highest, **changes)
    setting = setting_of(search, load)
    assert search.limit(Found(setting, (), guarantee_of(search._question.box(setting))), 1.0) == expected


@pytest.mark.parametrize(("share", "expected"), [(0.97, "speed"), (0.99, "limit")])
def test_a_landing_near_its_limit_limits_a_setting(share: float, expected: str) -> None:
    """98 % of a limit on landings count, which are sampled."""
    single = {"static_friction": 0.74, "kinetic_friction": 0.57}
    free = optimiser(Regime.HOPPING, {"amplitude_mm": "0.5:20"}, scene=single)
    setting = setting_of(free, 6.0)
    scene = free._question.nominal_scene(setting)
    hardest = 1e3 * float(solve(scene).impact_velocity)
    goal = {"speed_mm_s": 5, "highest_regime": "hopping", "impact_speed_mm_s": hardest / share}
    search = optimiser(Regime.HOPPING, {"amplitude_mm": "0.5:20"}, scene=single, goal=goal)
    found = Found(setting, (), guarantee_of(search._question.box(setting)))
    assert search.limit(found, 1.0) == expected


@pytest.mark.parametrize(
    ("drive", "highest", "expected"),
    [
        ({}, Regime.FORWARD_SLIP, "back slip"),
        ({}, Regime.BACK_SLIP, "hop"),
        ({"acceleration_g": 0.5}, Regime.FORWARD_SLIP, "limit"),
        ({"amplitude_mm": "0.05:0.1"}, Regime.BACK_SLIP, "limit"),
        ({"frequency_hz": [3, 30]}, Regime.FORWARD_SLIP, "back slip"),  # the highest of all frequencies
        (
            {"drive_angle_deg": "10:80", "acceleration_g": 1.2},
            Regime.BACK_SLIP,
            "limit",
        ),  # 45 deg: hop at 1.41
        ({"drive_angle_deg": "10:80", "acceleration_g": 1.6}, Regime.BACK_SLIP, "hop"),
    ],
)
def test_what_bounds_the_load_at_the_middle_angle(
    drive: dict[str, Any], highest: Regime, expected: str
) -> None:
    assert optimiser(highest, drive).first_cap() == expected


@pytest.mark.parametrize(
    ("highest", "scene", "monotone"),
    [
        (Regime.FORWARD_SLIP, {}, True),
        (Regime.BACK_SLIP, {}, False),
        (
            Regime.FORWARD_SLIP,
            {"kinetic_friction": "0.1:0.5", "trough_angle_deg": "-6:0"},
            False,
        ),  # runs away
        (Regime.FORWARD_SLIP, {"kinetic_friction": "0.11:0.5", "trough_angle_deg": "-6:0"}, True),
        (Regime.FORWARD_SLIP, {"static_friction": "1.5:2.5", "trough_angle_deg": "-22:0"}, False),  # Eq. (53)
    ],
)
def test_where_the_speed_is_monotone_few_corners_do(highest: Regime, scene: Any, monotone: bool) -> None:
    """The slowest bodies: at the least load, steepest, roughest; and those that may run away, smoothest."""
    search = optimiser(
        highest,
        scene=SCENE | scene,
        drift={**DRIFT, "drive_angle_deg": 1, "trough_angle_deg": 0.1} if scene == {} else DRIFT,
    )
    assert search._monotone is monotone
    if monotone:
        found = {tuple(column) for column in search.scenarios.coordinates.T}
        assert found == {(0, 0, 1, 1, 1), (0, 1, 1, 1, 1), (1, 0, 0, 0, 0), (1, 1, 0, 0, 0)}


def test_frequencies_and_angles_are_combined() -> None:
    search = optimiser(drive={"frequency_hz": [12, 15], "drive_angle_deg": [20, 25, 30]})
    assert len(search._ranges) == 6
    assert {r.frequency for r in search._ranges} == {(12.0, 12.0), (15.0, 15.0)}
    assert {round(math.degrees(r.drive_angle[0])) for r in search._ranges} == {20, 25, 30}


def test_the_best_of_all_ranges_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    search = optimiser(drive={"frequency_hz": [12, 15, 18]})
    speeds = {12.0: 0.01, 15.0: 0.03, 18.0: 0.02}
    setting = setting_of(search, 1.0)

    def fastest(choice: Range, scale: float, generations: int) -> Optimum:
        return Optimum(setting, speeds[choice.frequency[0]])

    monkeypatch.setattr(search, "_fastest_below", fastest)
    best = search._fastest(1.0, 5)
    assert best is not None
    assert best.speed == 0.03
    speeds.update(dict.fromkeys(speeds, 0.0))  # at rest none is fastest
    assert search._fastest(1.0, 5) is None


def test_without_a_load_there_is_no_speed() -> None:
    """An amplitude may begin at 0, and a cap may be 0."""
    question = asked()
    drive = replace(question.drive, choices={**question.drive.choices, "amplitude": ((0.0, 2e-3),)})
    search = LineOptimiser(replace(question, drive=drive))
    value = search._value(np.array([ANGLE, ANGLE]), np.array([0.0, 1e-3]), WHOLE, 1.0)
    assert value.tolist() == [-math.inf, 0.0]


GOAL = {"speed_mm_s": 5, "highest_regime": "hopping", "impact_speed_mm_s": 900}


@pytest.mark.parametrize(("drive", "dimensions"), [({}, 2), ({"drive_angle_deg": 20}, 1)])
def test_the_cube_of_the_fastest_setting(
    drive: Any, dimensions: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Drive angle, and load from the largest to a hundredth of it."""
    search = optimiser(Regime.HOPPING, drive, goal={"speed_mm_s": 5})
    calls: list[Any] = []
    met: list[Setting] = []

    def minimised(cost: Any, first: Floats, generations: int) -> Floats:
        calls.append((cost, first))
        return first[:, :1]

    def least(setting: Setting, scale: float) -> Floats:
        met.append(setting)
        return speeds[: np.size(setting.frequency)]

    speeds = np.ones(1)
    monkeypatch.setattr(search, "_minimised", minimised)
    monkeypatch.setattr(search, "least", least)
    choice = search._ranges[0]
    search._fastest_below(choice, 1.0, 3)
    ((cost, first),) = calls
    assert first.shape == (dimensions, 2**8)
    turns = "drive_angle_deg" not in drive
    assert not first[int(turns), :64].any()  # a quarter of them at the largest load
    if turns:
        assert first[0, :64] == pytest.approx(np.linspace(0.0, 1.0, 64))
    assert first[:, 64:].std(axis=1).min() > 0.2

    def at(angle: float, load: float) -> Floats:
        return np.array([[angle]] * turns + [[load]])

    # faster settings are cheaper; at rest those of more load are, but dearer than any that moves
    speeds = np.array([0.3])
    assert cost(at(0.5, 0.2)).tolist() == [-0.3]
    speeds = np.array([0.0])
    rests = [float(cost(at(0.5, load))[0]) for load in (0.2, 0.4)]
    assert 1e6 < rests[0] < rests[1]
    assert rests[1] - rests[0] == pytest.approx(0.2)
    met.clear()
    speeds = np.array([0.3])
    cost(at(0.5, 0.3))
    (low,) = met
    tops = search._tops(np.arctan2(low.normal_amplitude, low.along_amplitude), choice, 1.0)
    load = float(tops[0]) * max(1e-2, search._reach(choice)[0] / float(tops[0])) ** 0.3
    assert search._question.load(low)[0] == pytest.approx(load)
    assert float(low.frequency[0]) < 29.0


@pytest.mark.parametrize(("hardest", "raised"), [(0.2, 1.0), (0.899, 1.0), (1.35, 1.5), (90.0, math.inf)])
def test_impacts_that_are_too_hard_raise_the_frequency(
    hardest: float, raised: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To what keeps them at 0.9 m/s at the same load, up to the largest frequency."""
    search = optimiser(Regime.HOPPING, goal=GOAL)
    monkeypatch.setattr(Question, "hardest_impacts", lambda *_: np.array([hardest]))
    load, angle, span = np.array([2.0]), np.array([ANGLE]), search._ranges[0].frequency
    plain, soft = search._setting(load, span, angle), search._soft_setting(load, span, angle, 1.0)
    assert soft.frequency[0] == pytest.approx(min(raised * plain.frequency[0], span[1]), rel=1e-11)
    assert search._question.load(soft)[0] == pytest.approx(2.0)


def test_the_hardest_impact_of_a_setting_goes_with_one_over_its_frequency() -> None:
    search = optimiser(Regime.HOPPING, goal=GOAL)
    load, angle = np.array([1.6 / math.sin(ANGLE)]), np.array([ANGLE])
    slow, quick = (search._setting(load, (f, f), angle) for f in (25.0, 30.0))
    impacts = [search._question.hardest_impacts(s, search.scenarios)[0] for s in (slow, quick)]
    assert impacts[0] > 0.0
    assert impacts[0] == pytest.approx(1.2 * impacts[1], rel=1e-9)


def test_a_load_below_the_reach_of_the_amplitudes_is_not_possible(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the steepest angle the hop comes before the least amplitude at the lowest frequency."""
    search = optimiser(drive={"amplitude_mm": "3:4", "frequency_hz": "16:20", "drive_angle_deg": "10:40"})
    calls: list[Any] = []

    def minimised(cost: Any, first: Floats, generations: int) -> Floats:
        calls.append(cost)
        return first[:, :1]

    monkeypatch.setattr(search, "_minimised", minimised)
    search._fastest_below(search._ranges[0], 1.0, 3)
    least = 3e-3 * 16.0**2 / UNIT
    assert 1.0 / math.sin(math.radians(40.0)) < least < 1.0 / math.sin(math.radians(10.0))
    costs = calls[0](np.array([[0.0, 1.0], [0.0, 0.0]]))
    assert np.isfinite(costs).tolist() == [True, False]
    # narrow parts tip before it at every angle, though they would convey
    tipping = optimiser(drive={"amplitude_mm": "1:2"}, part={"half_base_mm": 2, "centre_height_mm": 10})
    monkeypatch.setattr(tipping, "_minimised", minimised)
    tipping._fastest_below(tipping._ranges[0], 1.0, 3)
    assert np.isinf(calls[1](np.array([[0.0, 0.5, 1.0], [0.0, 0.0, 0.0]]))).all()


def test_the_least_load_of_all_ranges_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Angles that miss the target are told apart by the speed at their largest load."""
    search = optimiser(drive={"frequency_hz": [12, 15, 18]})
    loads = {12.0: 1.3, 15.0: 0.9, 18.0: math.inf}
    ranked: list[Any] = []

    def first_load(angles: Floats, target: float, choice: Range) -> Floats:
        return np.where(angles < 0.3, loads[choice.frequency[0]], math.inf)

    def value(angles: Floats, loads: Floats, choice: Range, scale: float) -> Floats:
        return np.where(angles < 0.5, 0.04, 0.02)

    def best(value: Any, span: Any, effort: Any) -> float:
        ranked.append(value(np.array([0.2, 0.4, 0.6])))
        return 0.2

    monkeypatch.setattr(search, "_first_load", first_load)
    monkeypatch.setattr(search, "_value", value)
    monkeypatch.setattr(optima, "_best", best)
    found = search._least_acceleration(0.05)
    assert found is not None
    assert found.speed == 0.04
    assert found.setting.frequency == 15.0
    assert float(search._question.load(found.setting)) == pytest.approx(0.9)
    for load, ranks in zip((1.3, 0.9, None), ranked, strict=True):
        assert ranks[0] > ranks[1] > ranks[2] if load else ranks[0] == ranks[1] > ranks[2]
        assert load is None or ranks[0] == -load
        assert ranks[2] < -1e6
    loads.update(dict.fromkeys(loads, math.inf))
    assert search._least_acceleration(0.05) is None


EFFORT = replace(optima._LINE_IN_CONTACT, angles=9, rounds=9)


@pytest.mark.parametrize("centre", [0.2, 0.2613, 0.5, 0.78, 0.9])
def test_the_best_angle_of_a_peak(centre: float) -> None:
    found = _best(lambda x: -np.abs(x - centre), (0.2, 0.9), EFFORT)
    assert found == pytest.approx(centre, abs=1e-8)
    assert 0.2 <= found <= 0.9
    assert _best(lambda x: -np.abs(x - centre), (0.3, 0.3), EFFORT) == 0.3


def test_the_three_highest_peaks_are_looked_at() -> None:
    """The third of the grid's peaks hides the highest one; a fourth is left out."""
    grid = np.linspace(0.0, 1.0, 9)

    def value(x: Floats) -> Floats:
        peaks = [(0.125, 1.0, 0.0), (0.375, 0.9, 0.0), (0.625, 0.8, 5.0), (0.875, 0.7, 9.0)]
        return np.asarray(
            np.max(
                [
                    height - 3.0 * np.abs(x - at) + hidden * (np.abs(x - at - 0.03) < 0.01)
                    for at, height, hidden in peaks
                ],
                axis=0,
            )
        )

    assert value(grid).argmax() == 1
    assert _best(value, (0.0, 1.0), EFFORT) == pytest.approx(0.645, abs=0.01)
