"""Errors of sensors and of a stated drive: what they make of the drive, and that intervals hold them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from engines.sensed import Drawn, Sensors, draw, record
from helpers.made_records import Walked, nut

import vibro
from vibro.records.alignment import low_passed
from vibro.records.drive_errors import drive_errors
from vibro.records.measurement import measure
from vibro.records.problem import Problem
from vibro.records.reading import Record
from vibro.records.sensors import Mounting, SensorErrors
from vibro.records.trough import trough_drive

if TYPE_CHECKING:
    from vibro.records.fitting import Fit

pytestmark = pytest.mark.usefixtures("own_start_alone")

SLIP = ("static_friction", "kinetic_friction")
DEGREE = math.radians(1.0)


def test_patterns_are_told_with_the_drive_free() -> None:
    """The drive's quantities follow those that are asked; their deviations cost what their errors say."""
    errors = drive_errors(nut(), None, SensorErrors())
    problem = Problem(nut(), Walked(nut()).observe("velocity", cycles=4), SLIP, errors)
    assert problem.names == (*SLIP, "amplitude", "drive_angle")
    assert problem.asked == 2
    points = np.array([[0.74, 0.57, 1.03e-3, math.radians(22.0), 0.2]])
    assert problem.pulled(points[0]) == pytest.approx([1.0, 2.0], rel=1e-5)
    assert (problem.residuals("F_", points).values[0, -2:]) == pytest.approx([1.0, 2.0], rel=1e-5)
    fitted = Problem(nut(), Walked(nut()).observe("velocity", cycles=4), (*SLIP, "amplitude"), errors)
    assert fitted.names == (*SLIP, "amplitude", "drive_angle")
    assert fitted.asked == 3


# --- behind a filter ------------------------------------------------------------------------------------


def test_a_filter_delays_and_weakens_each_harmonic() -> None:
    """And an advance comes late by 1 / (2 pi f)."""
    period, corner = 0.05, 35.0
    time = np.linspace(-0.1, 0.3, 101)

    def sample(at: np.ndarray, window: float) -> dict[str, np.ndarray]:
        return {"x": np.sin(2.0 * math.pi * at / period) + np.cos(6.0 * math.pi * at / period) + 7.0 * at}

    found = low_passed(sample, time, period, corner)["x"]
    waves = 7.0 * (time - 1.0 / (2.0 * math.pi * corner))
    for order, turn in ((1, 0.0), (3, 0.5 * math.pi)):
        response = 1.0 / (1.0 + 1j * order / (period * corner))
        waves = waves + (response * np.exp(1j * (2.0 * math.pi * order * time / period + turn))).imag
    np.testing.assert_allclose(found, waves, atol=2e-4)
    assert low_passed(sample, time, period, math.inf)["x"] == pytest.approx(sample(time, 0.0)["x"])


# --- intervals ------------------------------------------------------------------------------------------


def measured(
    drawn: Drawn,
    sensors: Sensors,
    seed: int,
    errors: SensorErrors,
    *,
    stated: tuple[float, float] | None = None,
) -> Fit:
    """Fit friction to a record, from wrong coefficients."""
    columns = record(np.random.default_rng(seed), drawn, sensors, cycles=8.0 if stated is None else 30.0)
    trough = {"trough_along": columns["along"], "trough_normal": columns["normal"]} if stated is None else {}
    table = Record(
        columns["time"], {drawn.kind: columns[drawn.kind]}, trough, {name: name for name in trough}
    )
    mu_s, mu_d = drawn.frictions
    others = {
        "static_friction": 1.1 * mu_s, "kinetic_friction": 0.95 * mu_d, "trough_angle": drawn.slope,
        "gravity": 9.81, "restitution": 0.0,
    }  # fmt: skip
    found = trough_drive(table, {}, others, mounting=Mounting(errors), fits=True) if trough else None
    if found is None:
        assert stated is not None
        drive: dict[str, Any] = {"amplitude": stated[0], "drive_angle": stated[1]}
        drive["frequency"] = drawn.body.along.frequency
    else:
        drive = {name: estimate.value for name, estimate in found.drive.quantities.items()}
    scene, absolute = vibro.Scene(**drive, **others), drawn.kind == "acceleration"
    fit = measure(table, found, others, scene, SLIP, absolute=absolute, errors=errors).fit
    assert fit is not None
    return fit


def held(found: Fit, drawn: Drawn) -> list[bool]:
    """Whether each interval that is told holds the true value."""
    pairs = zip(found.parameters, drawn.frictions, strict=True)
    return [any(low <= true <= high for low, high in p.intervals) for p, true in pairs if p.intervals]


def test_intervals_hold_what_data_sheets_say() -> None:
    """Also those of benchmarks/measured_drives.py, of which a few are taken here."""
    inside: list[bool] = []
    for number, sensors in enumerate((
        Sensors(tilt=-DEGREE, gains=(0.03, -0.03, 0.03)),
        Sensors(crosses=(0.03, -0.03, 0.03)),
        Sensors(gains=(-0.04, 0.02, -0.03), crosses=(0.02, 0.03, 0.01)),
    )):  # fmt: skip
        drawn = draw(np.random.default_rng((7, number)), number)
        inside += held(measured(drawn, sensors, number, SensorErrors()), drawn)
    assert len(inside) >= 5
    assert inside.count(False) <= 1


def test_intervals_hold_the_errors_of_a_stated_drive_and_name_them() -> None:
    """Without one of the errors they are as much narrower as is said."""
    drawn = draw(np.random.default_rng(3), 0)
    true = (drawn.amplitude, drawn.angle)
    off = measured(drawn, Sensors(), 1, SensorErrors(), stated=(0.97 * true[0], true[1] + DEGREE))
    assert all(held(off, drawn))
    usual, better = (
        measured(drawn, Sensors(), 1, SensorErrors(amplitude=size), stated=true) for size in (0.03, 0.0)
    )
    for p, q in zip(usual.parameters, better.parameters, strict=True):
        assert set(p.narrower) == {"amplitude", "angle", "gain", "tilt"}
        assert all(-1e-6 < share < 1.0 for share in p.narrower.values())
        assert 1.0 - (q.high - q.low) / (p.high - p.low) == pytest.approx(p.narrower["amplitude"], abs=0.1)


def test_intervals_hold_behind_a_filter_that_is_stated() -> None:
    drawn = draw(np.random.default_rng(5), 1)
    found = measured(drawn, Sensors(corner=60.0), 2, SensorErrors(lowpass=60.0))
    assert all(held(found, drawn))
    assert not any("repeats in every cycle" in text for text in found.statements)
