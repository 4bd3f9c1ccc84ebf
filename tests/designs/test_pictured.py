"""Data of pictures: their ranges, the bodies that they draw, and critical loads by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.questions import answered, changed

import vibro
from vibro import Regime
from vibro.designs.design import chosen_of
from vibro.designs.pictured import (
    _tips,
    setting_fields,
    speed_band,
)
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.limits import critical_loads_of_lines
from vibro.results.designs import Design

if TYPE_CHECKING:
    from vibro.designs.design import Chosen
    from vibro.designs.questions import Spec
    from vibro.designs.spaces import UncertaintySet

ANGLE = math.radians(25.0)
SCENE: dict[str, Any] = {"static_friction": "0.4:0.5", "kinetic_friction": "0.3:0.35"}
DRIVE: dict[str, Any] = {"amplitude_mm": "1:3", "frequency_hz": "10:30", "drive_angle_deg": "10:40"}
UNIT = 9.81 / (2.0 * math.pi) ** 2  # [m] of load 1 at 1 Hz


def chosen(
    amplitude: float = 2.0, frequency: float = 15.0, window: Any = (None, None), **changes: Any
) -> tuple[Spec, Chosen]:
    """Choose a setting of the drive by hand."""
    content = {"scene": SCENE, "drive": [DRIVE], "goal": {"speed_mm_s": 5}} | changes
    spec = read_spec(changed(**content))
    design = Design(
        drive="drive 1", highest_regime=spec.goal.highest_regime.label, design="safest",
        amplitude_mm=amplitude, frequency_hz=frequency, drive_angle_deg=25.0,
        amplitude_low_mm=window[0], amplitude_high_mm=window[1],
    )  # fmt: skip
    found = chosen_of(spec, answered(True, design))
    assert found is not None
    return spec, found


def box_of(scene: dict[str, Any], drift: dict[str, Any] | None = None, angle: float = 25.0) -> UncertaintySet:
    """The box of a setting of load 1 at 1 Hz."""
    spec = read_spec(changed(scene=scene, drive=[{**DRIVE, "drive_angle_deg": angle}], drift=drift or {}))
    question = Question(spec, spec.drives[0], Regime.HOPPING)
    return question.box(
        question.space.setting(amplitude=UNIT, frequency=1.0, drive_angle=math.radians(angle))
    )


@cache
def fields_of(amplitude: float = 2.0, frequencies: str = "10:30") -> Any:
    several: Any = [10, 14, 30] if frequencies == "list" else frequencies
    return setting_fields(
        *chosen(amplitude, 10.0, drive=[{**DRIVE, "frequency_hz": several, "acceleration_g": 4}])
    )


def test_guaranteed_speeds_over_the_load() -> None:
    fields = fields_of()
    static, kinetic = (x.ravel() for x in np.meshgrid([0.4, 0.45, 0.5], [0.3, 0.325, 0.35]))
    indices = np.arange(0, fields.load.size, 57)
    scene = vibro.Scene(
        amplitude=UNIT * fields.load[indices, None] / 20.0**2, frequency=20.0, drive_angle=ANGLE,
        static_friction=static, kinetic_friction=kinetic,
    )  # fmt: skip
    slowest = 20.0 * 1e3 * np.min(vibro.solve(scene).mean_velocity, axis=1)
    np.testing.assert_allclose(fields.speed_min[indices], slowest, rtol=1e-6, atol=1e-6)


def test_loads_at_which_regimes_begin() -> None:
    begins = fields_of().begins
    onsets = critical_loads_of_lines(ANGLE, np.array([0.4, 0.5]), 0.3, 0.0).forward_onset
    assert begins[Regime.FORWARD_SLIP] == pytest.approx(tuple(onsets), rel=1e-9)
    slips = critical_loads_of_lines(ANGLE, np.array([0.4, 0.5]), np.array([0.35, 0.3]), 0.0).back_slip
    assert begins[Regime.BACK_SLIP] == pytest.approx(
        tuple(np.minimum(slips, 1.0 / math.sin(ANGLE))), rel=1e-9
    )
    assert begins[Regime.HOPPING] == pytest.approx((1.0 / math.sin(ANGLE),) * 2, rel=1e-9)


@pytest.mark.parametrize("limits", [("impact_speed_mm_s",), ("impact_speed_mm_s", "flight_fraction")])
def test_landings_are_shown_where_they_have_a_limit(limits: tuple[str, ...]) -> None:
    """Of the drift of a load the lowest frequency lands hardest."""
    goal = {"speed_mm_s": 5, "highest_regime": "hopping"} | dict.fromkeys(limits, 0.5)
    single = {"static_friction": 0.5, "kinetic_friction": 0.4, "restitution": 0}
    spec, choice = chosen(
        scene=single, goal=goal, drift={"amplitude_percent": 8, "frequency_percent": 5},
        drive=[{**DRIVE, "amplitude_mm": "1:12", "frequency_hz": 15}],
    )  # fmt: skip
    fields = setting_fields(spec, choice)
    nominal = UNIT * fields.load[:, None] / 15.0**2
    shares = np.linspace(0.0, 1.0, 3)  # of the band of loads
    least, most = (fields.load[:, None] * (1 + 0.08 * s) * (1 + 0.05 * s) ** 2 for s in (-1.0, 1.0))
    weight = UNIT * (least + shares * (most - least))  # A f^2
    lowest, highest = (np.clip(np.sqrt(weight / (nominal * a)), 14.25, 15.75) for a in (1.08, 0.92))
    fast, slow = (
        vibro.solve(
            vibro.Scene(
                amplitude=weight / f**2,
                frequency=f,
                drive_angle=ANGLE,
                static_friction=0.5,
                kinetic_friction=0.4,
            )
        )
        for f in (lowest, highest)
    )
    hardest = 15.0 * 1e3 * np.max(fast.impact_velocity, axis=1)
    assert np.max(hardest / np.maximum(15.0 * 1e3 * np.max(slow.impact_velocity, axis=1), 1.0)) > 1.01
    found = fields.impact_speed, fields.flight_fraction
    expected = hardest, np.max(fast.flight_fraction, axis=1)
    for name, values, numbers in zip(("impact_speed_mm_s", "flight_fraction"), found, expected, strict=True):
        if name in limits:
            assert values is not None
            np.testing.assert_allclose(values, numbers, rtol=1e-6, atol=1e-9)
        else:
            assert values is None


@pytest.mark.parametrize(("ratio", "by_hop"), [(0.3, False), (0.49, False), (5.0, True)])
def test_parts_tip_or_hop(ratio: float, by_hop: bool) -> None:
    """Parts wider than their friction do not tip, but fall where they hop."""
    part = {"half_base_mm": 10 * ratio, "centre_height_mm": 10}
    spec, choice = chosen(part=part)
    question = Question(spec, choice.drive, Regime.HOPPING)
    box = box_of(SCENE)
    hop = 1.0 / math.sin(ANGLE)
    # the edge lifts where G (cos a + r sin a) > r, and where friction holds the part: r < mu_s
    tip = ratio / (math.cos(ANGLE) + ratio * math.sin(ANGLE))
    assert _tips(question, box) == pytest.approx(hop if by_hop else min(tip, hop), rel=1e-9)
    free = replace(spec, stand_ratio=math.inf)
    assert _tips(Question(free, choice.drive, Regime.HOPPING), box) == math.inf
    level = Question(spec, choice.drive, Regime.HOPPING)
    if by_hop:
        assert _tips(level, box_of(SCENE, angle=0.0)) == math.inf


def test_speeds_of_the_slowest_the_middle_and_the_fastest_part() -> None:
    goal = {"speed_mm_s": 5, "highest_regime": "hopping"}
    band = speed_band(*chosen(2.0, window=(1.1, 2.2), goal=goal, drive=[{**DRIVE, "frequency_hz": 15}]))
    assert band.window == (1.1, 2.2)
    indices = np.arange(0, band.amplitude.size, 83)
    assert band.amplitude[indices[-1]] > 1e3 * UNIT / 225.0 / math.sin(ANGLE)  # some of them hop
    static, kinetic = (x.ravel() for x in np.meshgrid([0.4, 0.45, 0.5], [0.3, 0.325, 0.35]))
    scene = vibro.Scene(
        amplitude=1e-3 * band.amplitude[indices, None], frequency=15.0, drive_angle=ANGLE,
        static_friction=static, kinetic_friction=kinetic,
    )  # fmt: skip
    cycle = vibro.solve(scene)
    error = np.where(cycle.status == vibro.Status.AVERAGED, cycle.mean_velocity_error, 0.0)
    slow, fast = (1e3 * (cycle.mean_velocity + side * 3.0 * error) for side in (-1.0, 1.0))
    middle = 1e3 * cycle.mean_velocity[:, 4]
    assert (static[4], kinetic[4]) == (0.45, 0.325)
    for found, expected in (
        (band.speed_min, np.nanmin(slow, axis=1)), (band.speed_nominal, middle),
        (band.speed_max, np.nanmax(fast, axis=1)),
    ):  # fmt: skip
        np.testing.assert_allclose(found[indices], expected, rtol=1e-6, atol=1e-9)
