"""Loads and settings of drives along a line by hand: caps, reaches, what limits a setting, the best angle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.questions import changed

from vibro import Regime, solve
from vibro.designs.optima import LineOptimiser
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
WHOLE = ((0.5e-3, 2e-3), (10.0, 30.0), (math.radians(10.0), math.radians(40.0)))


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
CLIMB = {"static_friction": 0.45, "kinetic_friction": 0.2, "trough_angle_deg": 10, "restitution": 0}
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
    setting = search._slowest(np.array([load]), (10.0, 30.0), np.array([ANGLE]))
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
    setting = search._slowest(np.array([3.0]), (10.0, 30.0), np.array([ANGLE]))
    assert float(search._question.load(setting)[0]) == pytest.approx(3.0)


@pytest.mark.parametrize(("share", "holds"), [(0.5, True), (1.0, True), (1.0 + 1e-11, False), (1.1, False)])
def test_a_setting_holds_up_to_its_cap(share: float, holds: bool) -> None:
    search = optimiser(Regime.FORWARD_SLIP, {"acceleration_g": 0.5}, drift=DRIFT)
    cap = caps(search)["back slip"]
    assert cap > 0.5  # the limit of the drive counts elsewhere
    setting = Setting(*(np.array([float(x)]) for x in setting_of(search, share * cap)))
    assert search._holds(setting, 1.0).tolist() == [holds]
    assert search._holds(setting, 3.0).tolist() == [share < 1.0]


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
    assert search.limit(setting, 1.0) == expected


@pytest.mark.parametrize(("share", "expected"), [(0.97, "speed"), (0.99, "limit")])
def test_a_landing_near_its_limit_limits_a_setting(share: float, expected: str) -> None:
    """98 % of a limit on landings count, which are sampled."""
    single = {"static_friction": 0.74, "kinetic_friction": 0.57, "restitution": 0}
    free = optimiser(Regime.HOPPING, {"amplitude_mm": "0.5:20"}, scene=single)
    setting = setting_of(free, 6.0)
    scene = free._question.nominal_scene(setting)
    hardest = 1e3 * float(solve(scene).impact_velocity)
    goal = {"speed_mm_s": 5, "highest_regime": "hopping", "impact_speed_mm_s": hardest / share}
    search = optimiser(Regime.HOPPING, {"amplitude_mm": "0.5:20"}, scene=single, goal=goal)
    assert search.limit(setting, 1.0) == expected


@pytest.mark.parametrize(
    ("scene", "drive", "highest", "expected"),
    [
        ({}, {"acceleration_g": 0.5}, Regime.BACK_SLIP, "limit"),
        ({}, {"amplitude_mm": "0.05:0.1"}, Regime.BACK_SLIP, "limit"),
        ({"static_friction": "0.3:0.9"}, {"drive_angle_deg": 5}, Regime.FORWARD_SLIP, "back slip"),
        (CLIMB, {"drive_angle_deg": 20, "amplitude_mm": "0.5:9"}, Regime.BACK_SLIP, "hop"),
    ],
)
def test_what_bounds_the_load_where_no_setting_conveys(
    scene: dict[str, Any], drive: dict[str, Any], highest: Regime, expected: str
) -> None:
    search = optimiser(highest, drive, scene=SCENE | scene)
    assert search.fastest() is None
    assert search.first_cap() == expected


def test_frequencies_and_angles_are_combined() -> None:
    search = optimiser(drive={"frequency_hz": [12, 15], "drive_angle_deg": [20, 25, 30]})
    assert len(search._ranges) == 6
    assert {spans[1] for spans in search._ranges} == {(12.0, 12.0), (15.0, 15.0)}
    assert {round(math.degrees(spans[2][0])) for spans in search._ranges} == {20, 25, 30}


def test_a_limit_on_impacts_frees_the_least_frequency() -> None:
    """At the same load impacts go with 1/f."""
    goal = {"speed_mm_s": 5, "highest_regime": "hopping", "impact_speed_mm_s": 900}
    search = optimiser(Regime.HOPPING, goal=goal)
    assert search._free(search._ranges[0]).tolist() == [True, True, True]
    coordinates = np.array([[0.5, 0.5], [0.0, 1.0], [0.0, 0.0]])
    setting, _, _ = search._settings(coordinates, search._ranges[0], 1.0)
    assert setting.frequency[0] < setting.frequency[1] == 30.0
    assert search._question.load(setting)[0] == pytest.approx(search._question.load(setting)[1])


@pytest.mark.parametrize(
    ("drive", "free"),
    [
        ({}, [True, False, True]),
        ({"drive_angle_deg": 20}, [True, False, False]),
        ({"amplitude_mm": 1}, [True, False, True]),
        ({"amplitude_mm": 1, "frequency_hz": 15}, [True, False, True]),  # up to 1 mm
    ],
)
def test_load_and_drive_angle_are_searched(drive: dict[str, Any], free: list[bool]) -> None:
    search = optimiser(drive=drive)
    assert search._free(search._ranges[0]).tolist() == free


def test_loads_are_from_the_least_within_reach_to_the_first_cap() -> None:
    search = optimiser(drift=DRIFT)
    coordinates = np.array([[0.0, 0.5, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    setting, shares, possible = search._settings(coordinates, WHOLE, 1.0)
    least, hops = 0.5e-3 * 10.0**2 / UNIT, 1.0 / np.sin(np.radians([10.0, 40.0])) / GROWTH
    top = min(hops[0], 2e-3 * 30.0**2 / UNIT)
    assert search._question.load(setting) == pytest.approx([least, 0.5 * (least + top), hops[1]], rel=1e-9)
    assert shares.tolist() == [0.0, 0.5, 1.0]
    assert possible.all()
    angles = search._question.space.turned(setting)["drive_angle"]
    assert np.degrees(angles) == pytest.approx([10.0, 10.0, 40.0])


def test_a_load_below_the_reach_of_the_amplitudes_is_not_possible() -> None:
    """At the steepest angle the hop comes before the least amplitude at the lowest frequency."""
    search = optimiser(drive={"amplitude_mm": "3:4", "frequency_hz": "16:20", "drive_angle_deg": "10:40"})
    least = 3e-3 * 16.0**2 / UNIT
    assert 1.0 / math.sin(math.radians(40.0)) < least < 1.0 / math.sin(math.radians(10.0))
    ends = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 1.0]])
    assert search._settings(ends, search._ranges[0], 1.0)[2].tolist() == [True, False]
    # narrow parts tip before it at every angle, though they would convey
    tipping = optimiser(drive={"amplitude_mm": "1:2"}, part={"half_base_mm": 2, "centre_height_mm": 10})
    assert not tipping._settings(ends, tipping._ranges[0], 1.0)[2].any()
