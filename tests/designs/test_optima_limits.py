"""What limits a setting, and what prevents any: of lines and ellipses, just within each limit and beyond."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.questions import changed

from vibro import Regime, solve
from vibro.designs.optima import EllipseOptimiser, LineOptimiser
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.designs.spaces import SPACES, Setting
from vibro.drives import Line
from vibro.limits import critical_loads_of_lines, tipping_load_of_lines

ANGLE, PHASE = math.radians(20.0), math.radians(-50.0)
ROUGH = {"static_friction": "0.7:0.8", "kinetic_friction": "0.4:0.5"}
SMOOTH = {"static_friction": "0.35:0.45", "friction_ratio": 0.9}
LINE = {"amplitude_mm": "0.5:2", "frequency_hz": "10:30", "drive_angle_deg": "10:40"}
OVAL = {
    "along_amplitude_mm": "0.1:1", "normal_amplitude_mm": "0.05:0.5", "normal_phase_deg": "-180:180",
    "frequency_hz": 25,
}  # fmt: skip
DRIFT = {"amplitude_percent": 5, "frequency_percent": 1}
GROWTH = 1.05 * 1.01**2
UNIT = 9.81 / (2.0 * math.pi) ** 2  # [m] of load 1 at 1 Hz
HOP = 1.0 / math.sin(ANGLE)
SLIP = float(critical_loads_of_lines(ANGLE, 0.7, 0.5, 0.0).back_slip)
FORWARD, BACK, HOPPING = Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING


def asked(scene: Any, drive: Any, highest: Regime, **changes: Any) -> Question:
    spec = read_spec(changed(**({"scene": scene, "drive": [drive], "goal": {"speed_mm_s": 5}} | changes)))
    return Question(spec, spec.drives[0], highest)


def of_line(highest: Regime = BACK, drive: Any = None, scene: Any = None, **changes: Any) -> LineOptimiser:
    return LineOptimiser(asked(ROUGH | (scene or {}), LINE | (drive or {}), highest, **changes))


def of_oval(highest: Regime = BACK, drive: Any = None, scene: Any = None, **changes: Any) -> EllipseOptimiser:
    return EllipseOptimiser(asked(scene or SMOOTH, OVAL | (drive or {}), highest, **changes))


def at_load(load: float) -> Setting:
    """A setting of a line of a load at 15 Hz."""
    return SPACES[Line].setting(amplitude=load * UNIT / 15.0**2, frequency=15.0, drive_angle=ANGLE)


@pytest.mark.parametrize(
    ("highest", "part", "scale", "expected"),
    [
        (FORWARD, None, 1.0, {"hop": HOP / GROWTH, "back slip": SLIP / GROWTH, "limit": 4.0}),
        (BACK, None, 1.0, {"hop": HOP / GROWTH, "limit": 4.0}),
        (HOPPING, None, 1.0, {"limit": 4.0}),
        (BACK, None, 2.0, {"hop": HOP / (1.1 * 1.02**2), "limit": 4.0}),  # drifts twice as wide
        (BACK, 5.0, 1.0, {"tip": tipping_load_of_lines(ANGLE, 0.8, 0.0, 0.5) / GROWTH}),
        (BACK, 20.0, 1.0, {"tip": math.inf}),
        (HOPPING, 20.0, 1.0, {"tip": HOP / GROWTH}),  # may land on an edge
    ],
)
def test_caps_are_nominal_loads(highest: Regime, part: Any, scale: float, expected: dict[str, float]) -> None:
    upright = {} if part is None else {"part": {"half_base_mm": part, "centre_height_mm": 10}}
    search = of_line(highest, {"acceleration_g": 4}, drift=DRIFT, **upright)
    found = {name: float(cap[0, 0]) for name, cap in search._caps(np.array([[ANGLE]]), scale).items()}
    assert {name: found[name] for name in expected} == pytest.approx(expected, rel=1e-9)
    assert part is not None or found.keys() == expected.keys()
    for name in expected.keys() - {"limit"}:
        assert math.isinf(expected[name]) or found[name] < expected[name]  # rounding brings none beyond


@pytest.mark.parametrize(
    ("load", "highest", "changes", "expected"),
    [
        (0.9999985 * SLIP, FORWARD, {}, "speed"),
        (0.9999995 * SLIP, FORWARD, {}, "back slip"),
        (0.9999995 * HOP, BACK, {"drive": {"amplitude_mm": "0.5:9"}}, "hop"),
        (2e-3 * 225.0 / UNIT * (1 - 5e-7), BACK, {}, "limit"),
        (2e-3 * 225.0 / UNIT * (1 - 2e-6), BACK, {}, "speed"),
        (1.3, BACK, {"drive": {"acceleration_g": 1.3 * (1 + 5e-7)}}, "limit"),
        (1.3, BACK, {"drive": {"acceleration_g": 1.3 * (1 + 2e-6)}}, "speed"),
        (1.3, BACK, {"part": {"half_base_mm": 2, "centre_height_mm": 10}}, "tip"),
    ],
)
def test_what_limits_a_setting_of_a_line(
    load: float, highest: Regime, changes: dict[str, Any], expected: str
) -> None:
    assert of_line(highest, **changes).limit(at_load(load), 1.0) == expected


NORMAL = UNIT / 25.0**2 / GROWTH  # at which the first part hops


@pytest.mark.parametrize(
    ("setting", "highest", "drive", "expected"),
    [
        (Setting(5e-4, 2e-4, PHASE, 25.0), BACK, {}, "speed"),
        (Setting(5e-4, NORMAL * (1 - 5e-7), PHASE, 25.0), BACK, {}, "hop"),
        (Setting(5e-4, NORMAL * (1 - 3e-6), PHASE, 25.0), BACK, {}, "speed"),
        (Setting(1e-3 * (1 - 5e-7), 2e-4, PHASE, 25.0), BACK, {}, "limit"),
        (Setting(1e-3 * (1 - 2e-6), 2e-4, PHASE, 25.0), BACK, {}, "speed"),
        (Setting(5e-4, 2e-4 * (1 - 5e-7), PHASE, 25.0), BACK, {"normal_amplitude_mm": "0.05:0.2"}, "limit"),
        (Setting(5e-4, 2e-4 * (1 - 2e-6), PHASE, 25.0), BACK, {"normal_amplitude_mm": "0.05:0.2"}, "speed"),
        (Setting(5e-4, 2e-4, PHASE, 25.0), BACK, {"acceleration_g": (1 + 5e-7)}, "limit"),
        (Setting(5e-4, 2e-4, PHASE, 25.0), BACK, {"acceleration_g": (1 + 2e-6)}, "speed"),
        (Setting(9e-4, 2e-4, PHASE, 25.0), FORWARD, {}, "back slip"),
    ],
)
def test_what_limits_a_setting_of_an_ellipse(
    setting: Setting, highest: Regime, drive: dict[str, Any], expected: str
) -> None:
    if "acceleration_g" in drive:
        drive = {"acceleration_g": drive["acceleration_g"] * float(setting.load(9.81))}
    assert of_oval(highest, drive, drift=DRIFT).limit(setting, 1.0) == expected


@pytest.mark.parametrize(("share", "expected"), [(0.97, "speed"), (0.99, "limit")])
def test_a_landing_near_its_limit_limits_a_setting(share: float, expected: str) -> None:
    """98 % of a limit on landings count, which are sampled."""
    single = {"static_friction": 0.74, "kinetic_friction": 0.57, "restitution": 0}
    free = of_line(HOPPING, {"amplitude_mm": "0.5:20"}, single)
    hardest = 1e3 * float(solve(free._question.nominal_scene(at_load(6.0))).impact_velocity)
    goal = {"speed_mm_s": 5, "highest_regime": "hopping", "impact_speed_mm_s": hardest / share}
    assert (
        of_line(HOPPING, {"amplitude_mm": "0.5:20"}, single, goal=goal).limit(at_load(6.0), 1.0) == expected
    )


NARROW = {"half_base_mm": 1, "centre_height_mm": 10}
CLIMB = {"static_friction": 0.45, "kinetic_friction": 0.2, "trough_angle_deg": 10, "restitution": 0}


@pytest.mark.parametrize(
    ("search", "expected"),
    [
        (of_line(BACK, {"acceleration_g": 0.5}), "limit"),
        (of_line(BACK, {"amplitude_mm": "0.05:0.1"}), "limit"),
        (of_line(FORWARD, {"drive_angle_deg": 5}, {"static_friction": "0.3:0.9"}), "back slip"),
        (of_line(BACK, {"drive_angle_deg": 20, "amplitude_mm": "0.5:9"}, CLIMB), "hop"),
        (of_oval(BACK, {"normal_amplitude_mm": "0.41:0.5"}), "hop"),  # the least one throws parts
        (of_oval(BACK, {"along_amplitude_mm": 0.1, "normal_amplitude_mm": 0.05}), "limit"),
        (of_oval(BACK, {"along_amplitude_mm": 0.8, "normal_phase_deg": 0}, part=NARROW), "tip"),
        (of_oval(FORWARD, {"along_amplitude_mm": 0.9, "normal_amplitude_mm": 0.05}), "back slip"),
    ],
)
def test_what_bounds_the_load_where_no_setting_conveys(
    search: LineOptimiser | EllipseOptimiser, expected: str
) -> None:
    assert search.fastest() is None
    assert search.first_cap() == expected
