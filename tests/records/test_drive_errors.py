"""Errors of sensors and of a stated drive: what they make of the drive, and that intervals hold them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from engines.sensed import Drawn, Sensors, draw, record
from helpers.made_records import Walked, bowl, nut

import vibro
from vibro.records.alignment import low_passed
from vibro.records.drive_errors import drive_errors
from vibro.records.measurement import Measurement, measure
from vibro.records.problem import FITTABLE, Problem
from vibro.records.reading import Record
from vibro.records.sensors import Mounting, SensorErrors
from vibro.records.trough import trough_drive

SLIP = ("static_friction", "kinetic_friction")
EXACT = SensorErrors(0.0, 0.0, 0.0, 0.0, 0.0, angle=0.0, amplitude=0.0)
DEGREE = math.radians(1.0)


@pytest.fixture
def own_start_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Search from the scene's own values alone, which takes a fraction of the time."""
    monkeypatch.setattr("vibro.records.problem._GRID", dict.fromkeys(FITTABLE, ()))


def halves(scene: vibro.Scene, kind: str, **errors: Any) -> list[dict[str, float]]:
    """Return half the difference of both sides of each stated error of a kind."""
    stated = EXACT._replace(**errors)
    found = [error for error in drive_errors(scene, None, stated) if error.name == kind]
    return [{n: 0.5 * (error.more[n] - error.less[n]) for n in error.more} for error in found]


def test_a_stated_drive_has_errors_of_its_amplitudes_and_angles() -> None:
    assert drive_errors(nut(), None, EXACT) == []
    (size,) = halves(nut(), "amplitude", amplitude=0.03)
    assert size == {"amplitude": pytest.approx(0.03e-3)}
    (angle,) = halves(nut(), "angle", angle=DEGREE)
    assert angle == {"drive_angle": pytest.approx(DEGREE)}
    sizes = halves(bowl(), "amplitude", amplitude=0.03)
    assert sizes == [{"along_amplitude": pytest.approx(3e-5)}, {"normal_amplitude": pytest.approx(1.5e-5)}]
    phase, turned = halves(bowl(), "angle", angle=1e-6)
    assert phase == {"normal_phase": pytest.approx(1e-6)}
    # An ellipse that is turned: x - e y, y + e x, of which the sizes and the phase between them change.
    x, y, phi = 1e-3, 5e-4, math.radians(-60.0)
    assert turned["along_amplitude"] == pytest.approx(-1e-6 * y * math.cos(phi), rel=1e-4)
    assert turned["normal_amplitude"] == pytest.approx(1e-6 * x * math.cos(phi), rel=1e-4)
    assert turned["normal_phase"] == pytest.approx(-1e-6 * (x / y - y / x) * math.sin(phi), rel=1e-4)


def test_stated_harmonics_are_scaled_and_turned() -> None:
    rest: dict[str, Any] = {"frequency": 20.0, "static_friction": 0.4, "kinetic_friction": 0.3}
    scene = vibro.Scene(along_harmonics=[(1e-3, 0.0), (1e-4, 1.0)], normal_harmonics=[(5e-4, 0.2)], **rest)
    size, turned = drive_errors(scene, None, EXACT._replace(amplitude=0.03, angle=1e-3))
    assert (size.more, size.less) == ({"motion_scale": 1.03}, {"motion_scale": 0.97})
    (along, second), (normal, added) = turned.more["along_harmonics"], turned.more["normal_harmonics"]
    assert along[0] == pytest.approx(1e-3 - 1e-3 * 5e-4 * math.cos(0.2), rel=1e-6)
    assert second[0] == pytest.approx(1e-4, rel=1e-5)
    assert added[0] == pytest.approx(1e-3 * 1e-4)
    assert normal[0] == pytest.approx(5e-4 + 1e-3 * 1e-3 * math.cos(0.2), rel=1e-5)


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


def test_a_gain_multiplies_the_motion_of_each_point() -> None:
    """Signals that are 3 % too large, noise included, cost a standard error of 3 %: 1, wherever they fit."""
    plain = Walked(nut()).observe("displacement", cycles=60)
    shift = 0.0137 * float(nut().frequency)
    points = np.array([[0.74, 0.57, shift], [0.735, 0.568, shift], [0.72, 0.565, shift], [0.7, 0.57, shift]])
    squares = []
    for gain in (1.0, 1.03):
        seen = replace(plain, signals={name: gain * values for name, values in plain.signals.items()})
        problem = Problem(nut(), seen, SLIP, (), SensorErrors(tilt=0.0))
        problem.weigh(points[0])
        squares.append(problem.residuals("F_", points).squares)
    assert squares[1] - squares[0] == pytest.approx(np.ones(len(points)), abs=0.6)


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
) -> Measurement:
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
    return measure(table, found, others, scene, SLIP, absolute=absolute, errors=errors)


def held(m: Measurement, drawn: Drawn) -> list[bool]:
    """Whether each interval that is told holds the true value."""
    assert m.fit is not None
    pairs = zip(m.fit.parameters, drawn.frictions, strict=True)
    return [any(low <= true <= high for low, high in p.intervals) for p, true in pairs if p.intervals]


@pytest.mark.usefixtures("own_start_alone")
def test_intervals_hold_what_data_sheets_say() -> None:
    """Also those of benchmarks/measured_drives.py, of which a few are taken here."""
    inside: list[bool] = []
    for number, sensors in enumerate(
        [
            Sensors(tilt=DEGREE),
            Sensors(tilt=-DEGREE, gains=(0.03, -0.03, 0.03)),
            Sensors(crosses=(0.03, -0.03, 0.03)),
            Sensors(gains=(-0.04, 0.02, -0.03), crosses=(0.02, 0.03, 0.01)),
        ]
    ):
        random = np.random.default_rng((7, number))
        drawn = draw(random, number)
        inside += held(measured(drawn, sensors, number, SensorErrors()), drawn)
    assert len(inside) >= 6
    assert inside.count(False) <= 1


@pytest.mark.usefixtures("own_start_alone")
def test_intervals_hold_the_errors_of_a_stated_drive_and_name_them() -> None:
    drawn = draw(np.random.default_rng(3), 0)
    off = (0.97 * drawn.amplitude, drawn.angle + DEGREE)
    m = measured(drawn, Sensors(), 1, SensorErrors(), stated=off)
    assert all(held(m, drawn))
    sharp = measured(drawn, Sensors(), 1, EXACT, stated=(drawn.amplitude, drawn.angle))
    assert m.fit is not None
    assert sharp.fit is not None
    for p, exact in zip(m.fit.parameters, sharp.fit.parameters, strict=True):
        assert exact.high - exact.low < p.high - p.low
        assert not any(exact.narrower.values())
        assert set(p.narrower) == {"amplitude", "angle", "gain", "tilt"}
        assert all(-1e-6 < share < 1.0 for share in p.narrower.values())
    # Without one of the errors intervals are as much narrower as is said.
    true = (drawn.amplitude, drawn.angle)
    usual, better = (
        measured(drawn, Sensors(), 1, SensorErrors(amplitude=size), stated=true) for size in (0.03, 0.0)
    )
    assert usual.fit is not None
    assert better.fit is not None
    for p, q in zip(usual.fit.parameters, better.fit.parameters, strict=True):
        assert 1.0 - (q.high - q.low) / (p.high - p.low) == pytest.approx(p.narrower["amplitude"], abs=0.1)


@pytest.mark.usefixtures("own_start_alone")
def test_a_filter_that_is_stated_is_computed_and_one_that_is_not_is_told() -> None:
    random = np.random.default_rng(5)
    drawn = draw(random, 1)
    filtered = Sensors(corner=60.0)
    stated = measured(drawn, filtered, 2, SensorErrors(lowpass=60.0))
    assert stated.fit is not None
    assert all(held(stated, drawn))
    assert not any("repeats in every cycle" in text for text in stated.fit.statements)
    silent = measured(drawn, filtered, 2, SensorErrors())
    assert silent.fit is not None
    assert any("repeats in every cycle" in text and "low-pass" in text for text in silent.fit.doubts)
    assert {*silent.fit.doubts} <= {*silent.fit.statements}
