"""Guarantees of elliptical drives: those of lines where an ellipse is one, and beaten by no sample."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.draws import examples
from hypothesis import given
from hypothesis import strategies as st

import vibro
from vibro import Regime
from vibro.designs.sensitivities import speed_costs

BASE: dict[str, Any] = {
    "along_amplitude": 1e-3,
    "normal_amplitude": 3e-4,
    "normal_phase": math.radians(-60.0),
    "frequency": 25.0,
    "static_friction": 0.4,
    "kinetic_friction": 0.3,
}


def scene(**changed: Any) -> vibro.Scene:
    return vibro.Scene(**{**BASE, **changed})


def about(value: float, share: float) -> tuple[float, float]:
    return value - share * abs(value), value + share * abs(value)


@pytest.mark.parametrize("amplitude", [5e-4, 8e-4, 1.2e-3])
def test_an_ellipse_that_is_a_line_has_the_lines_guarantee(amplitude: float) -> None:
    alpha = math.radians(20.0)
    bands: dict[str, Any] = {
        "static_friction": (0.5, 0.7),
        "friction_ratio": (0.7, 0.9),
        "trough_angle": (0.0, math.radians(2.0)),
        "frequency": (14.8, 15.2),
    }
    frictions = {"frequency": 15.0, "static_friction": 0.6, "kinetic_friction": 0.5}
    line = vibro.guarantee(vibro.Scene(amplitude=amplitude, drive_angle=alpha, **frictions), **bands)
    x, y = amplitude * math.cos(alpha), amplitude * math.sin(alpha)
    ellipse = vibro.guarantee(vibro.Scene(along_amplitude=x, normal_amplitude=y, **frictions), **bands)
    assert ellipse.found_min == pytest.approx(line.found_min, rel=1e-8, abs=1e-12)
    assert ellipse.found_max == pytest.approx(line.found_max, rel=1e-8)
    assert ellipse.regimes == line.regimes
    assert (ellipse.proof_min, ellipse.proof_max) == ("proved", "proved")


@examples(2)
@given(
    st.floats(0.3, 2.0),
    st.floats(0.05, 0.95),
    st.floats(-180.0, 180.0),
    st.floats(0.2, 0.6),
    st.floats(0.6, 1.0),
)
def test_no_sample_of_a_box_is_beyond_its_guarantee(
    load: float, throw: float, phase: float, friction: float, ratio: float
) -> None:
    unit = 9.81 / (2.0 * math.pi * 25.0) ** 2
    one = scene(
        along_amplitude=load * unit,
        normal_amplitude=throw * unit,
        normal_phase=math.radians(phase),
        static_friction=friction,
        kinetic_friction=ratio * friction,
    )
    bands = {
        "along_amplitude": about(load * unit, 0.04),
        "normal_amplitude": about(throw * unit, 0.04),
        "normal_phase": (math.radians(phase - 5.0), math.radians(phase + 5.0)),
        "static_friction": about(friction, 0.1),
    }
    found = vibro.guarantee(one, **bands, friction_ratio=(0.95 * ratio, ratio))
    rng = np.random.default_rng(0)
    drawn = {name: rng.uniform(*band, 3000) for name, band in bands.items()}
    kinetic = drawn["static_friction"] * rng.uniform(0.95 * ratio, ratio, 3000)
    cycle = vibro.solve(scene(**drawn, kinetic_friction=kinetic), flight=False)
    speed, tiny = np.asarray(cycle.mean_velocity), 1e-9 * load * unit * 25.0
    assert speed.min() >= found.speed_min - 1e-7 * abs(found.speed_min) - tiny
    assert speed.max() <= found.speed_max + 1e-7 * abs(found.speed_max) + tiny
    assert {Regime(code) for code in np.unique(cycle.regime)} <= found.regimes
    for speed_there, place, limit in (
        (found.found_min, found.min_at, found.min_limit),
        (found.found_max, found.max_at, found.max_limit),
    ):
        if not limit:
            there = float(vibro.solve(vibro.Scene(**place), flight=False).mean_velocity)
            assert there == pytest.approx(speed_there, rel=1e-12, abs=tiny)


def test_costs_are_what_small_changes_change() -> None:
    costs = speed_costs(scene())
    speed = float(vibro.solve(scene()).mean_velocity)
    for name, cost in costs.items():
        assert not isinstance(cost, str)
        field = name.removesuffix("_deg")
        value = float(getattr(scene(), field))
        step = 1e-3 * math.radians(1.0) if name.endswith("_deg") else 1e-5 * value
        there = float(vibro.solve(scene(**{field: value + step})).mean_velocity)
        share = 1e-3  # of 1 deg, and of 1 %
        assert (there / speed - 1.0) * 100.0 == pytest.approx(share * cost, rel=1e-3, abs=1e-7)
    assert set(costs) >= {"along_amplitude", "normal_amplitude", "normal_phase_deg", "trough_angle_deg"}
    at_rest = speed_costs(scene(along_amplitude=1e-5, normal_amplitude=1e-5))
    assert set(at_rest.values()) == {"rests: no speed to change"}
