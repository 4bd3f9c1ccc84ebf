"""The first harmonic of a trough's motion, a line or an ellipse, against motions with known truth."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.made_records import FREQUENCY, PERIOD, Walked, bowl, trough_record

from vibro.errors import InputError
from vibro.records.comparison import compare
from vibro.records.reading import Record
from vibro.records.trough import MeasuredDrive, motion_of

TRUE = {"amplitude": 1.02e-3, "frequency": 15.003, "drive_angle": math.radians(20.5)}
TRIGGER = 0.0137
ALONG, NORMAL = ("trough_along",), ("trough_normal",)


def on_line(record: Record, **options: Any) -> MeasuredDrive:
    return motion_of(record, short=True, **options).drive_on_line()


@each(
    ("cycles", "start", "offset"),
    [(2.2, 0.0, -300.0), (5.5, -3.7, 0.0), (12.0, 5000.0, -300.0), (60.0, 0.0, 0.0)],
)
def test_exact_accelerations_give_the_exact_motion(cycles: float, start: float, offset: float) -> None:
    """Whatever the clock and the sensor's zero, such as gravity on a sensor that is not level."""
    drive = on_line(trough_record(cycles=cycles, samples=20, offset=offset, start=start))
    assert drive.quantities["amplitude"].value == pytest.approx(TRUE["amplitude"], rel=1e-5)
    assert drive.quantities["frequency"].value == pytest.approx(TRUE["frequency"], rel=1e-6)
    assert drive.quantities["drive_angle"].value == pytest.approx(TRUE["drive_angle"], abs=1e-6)
    # the clock counts where the record is: at its middle
    middle = start + 0.5 * cycles / TRUE["frequency"]
    turns = (middle + drive.clock.value) * drive.quantities["frequency"].value - (
        middle - start + TRIGGER
    ) * 15.003
    assert abs(math.remainder(turns, 1.0)) < 1e-5
    assert all("clipped" in text for text in drive.motion.warnings)  # samples repeat exactly


@each("cycles", [3.0, 12.0])
@pytest.mark.parametrize("columns", [NORMAL, ALONG + NORMAL])
def test_errors_are_those_of_repeated_noise(columns: tuple[str, ...], cycles: float) -> None:
    """Also with rows left out; gated on the root mean square and on the largest of all."""
    off: dict[str, list[float]] = {}
    one = TRUE["drive_angle"] if columns == NORMAL else None
    for seed in range(20):
        record = trough_record(
            noise=0.5, offset=3.0, columns=columns, samples=20, seed=seed, lost=0.03, cycles=cycles
        )
        drive = on_line(record, drive_angle=one)
        for name, estimate in drive.quantities.items():
            off.setdefault(name, []).append((estimate.value - TRUE[name]) / estimate.error)
        off.setdefault("clock", []).append(
            math.remainder(drive.clock.value - TRIGGER, PERIOD) / drive.clock.error
        )
    assert len(off) == 3 + (len(columns) == 2)
    for name, values in off.items():
        assert 0.6 < float(np.sqrt(np.mean(np.square(values)))) < 1.5, name
        assert max(map(abs, values)) < 4.5, name


@pytest.mark.parametrize("angle", [0.0, 0.01, 89.9])
def test_a_drive_angle_at_an_end_of_its_range_stays_in_it(angle: float) -> None:
    for seed in range(6):
        record = trough_record(angle=math.radians(angle), noise=0.5, samples=20, seed=seed)
        drive = on_line(record)
        value, error = drive.quantities["drive_angle"]
        assert 0.0 <= value <= 0.5 * math.pi
        assert abs(value - math.radians(angle)) < 4.0 * error


def test_inverted_sensors() -> None:
    record = trough_record()
    for name in record.trough:
        other = Record(record.time, {}, {**record.trough, name: -record.trough[name]}, record.headers)
        with pytest.raises(InputError):
            motion_of(other)
        assert abs(motion_of(other, down=True).phase) == pytest.approx(math.pi)
    against = replace(record, trough={**record.trough, "trough_along": -record.trough["trough_along"]})
    assert on_line(against, reverse=True).quantities == on_line(record).quantities
    with pytest.raises(InputError):
        motion_of(record, reverse=True)


@each(("share", "cycles"), [(0.02, 12.0), (0.2, 4.0), (0.9, 12.0), (3.0, 4.0)])
def test_harmonics_are_counted_and_warned_of(share: float, cycles: float) -> None:
    """A third harmonic that is larger than the fundamental does not take its place."""
    drive = on_line(trough_record(harmonic=share, noise=0.05, cycles=cycles))
    assert drive.quantities["frequency"].value == pytest.approx(15.003, abs=5e-3)
    assert drive.quantities["amplitude"].value == pytest.approx(1.02e-3, rel=4e-3)
    for found in drive.motion.sensors:
        assert found.harmonics == pytest.approx(share, rel=0.03, abs=4e-3)
    assert len(drive.motion.impurities) == (2 if share > 0.1 else 0)


def test_a_sensor_that_shows_nothing_is_refused_and_noise_alone_doubted() -> None:
    """As a drive may be level."""
    record = trough_record(noise=0.5)
    noise = np.random.default_rng(3).standard_normal(record.time.size)
    for dead in (0.0 * noise, 3.0 + 0.0 * noise, 1e-200 * noise):
        with pytest.raises(InputError, match="'trough_normal'"):
            motion_of(replace(record, trough={**record.trough, "trough_normal": dead}))
    motion = motion_of(replace(record, trough={**record.trough, "trough_normal": noise}))
    assert sum("stands out" in text for text in motion.warnings) == 1
    assert math.isnan(motion.phase)


# --- the clock of the trough ------------------------------------------------------------------------


@pytest.mark.parametrize(("share", "ratio"), [(0.2, 0.2), (0.2, 0.5), (0.3, 0.371), (0.3, 0.8)])
def test_another_machine_in_the_record_does_not_hide_the_drive(ratio: float, share: float) -> None:
    for seed in range(2):
        record = trough_record(noise=0.1, seed=seed, cycles=10.0 + 7.0 * seed)
        wave = np.sin(2.0 * math.pi * 15.003 * ratio * record.time + seed)
        shaken = {name: a + 0.5 * share * np.ptp(a) * wave for name, a in record.trough.items()}
        drive = on_line(replace(record, trough=shaken))
        assert drive.quantities["frequency"].value == pytest.approx(15.003, rel=0.01)
        assert drive.quantities["amplitude"].value == pytest.approx(TRUE["amplitude"], rel=0.15)


# --- elliptical drives -------------------------------------------------------------------------------


def on_ellipse(phase: float | None, lead: float, **options: Any) -> MeasuredDrive:
    record = trough_record(ellipse=lead, **options)
    angle = 1.0 if len(record.trough) == 1 else None
    return motion_of(record, drive_angle=angle, down=True).drive_on_ellipse(phase)


@pytest.mark.parametrize("lead_deg", [-179.0, 90.0])
def test_errors_of_an_ellipse_are_those_of_repeated_noise(lead_deg: float) -> None:
    lead = math.radians(lead_deg)
    x, y = (1.02e-3 * side(math.radians(20.5)) for side in (math.cos, math.sin))
    true = {"along_amplitude": x, "normal_amplitude": y, "normal_phase": lead, "frequency": 15.003}
    off: dict[str, list[float]] = {}
    for seed in range(20):
        drive = on_ellipse(0.0, lead, noise=0.5, offset=3.0, samples=20, seed=seed, cycles=30.0)
        assert list(drive.quantities) == ["along_amplitude", "normal_amplitude", "frequency", "normal_phase"]
        for name, estimate in drive.quantities.items():
            wrapped = math.remainder(estimate.value - true[name], math.tau)
            off.setdefault(name, []).append(wrapped / estimate.error)
        error = math.remainder(drive.clock.value - 0.0137, 1.0 / 15.003)
        off.setdefault("clock", []).append(error / drive.clock.error)
    for name, values in off.items():
        assert 0.5 < float(np.sqrt(np.mean(np.square(values)))) < 1.6, name
        assert max(map(abs, values)) < 4.0, name


@each(
    ("lead_deg", "noise", "ellipse"),
    [(0.0, 0.0, False), (1.9, 0.0, False), (2.1, 0.0, True), (-2.1, 0.0, True), (4.0, 3.0, False),
     (60.0, 3.0, True), (-150.0, 0.0, True), (177.8, 0.0, True)],
)  # fmt: skip
def test_an_ellipse_is_one_beyond_its_error(lead_deg: float, noise: float, ellipse: bool) -> None:
    record = trough_record(ellipse=math.radians(lead_deg), noise=noise)
    assert motion_of(record).on_an_ellipse == ellipse


def test_the_troughs_clock_places_the_record() -> None:
    observed = Walked(bowl()).observe("velocity", trigger=0.02)
    drive = on_ellipse(None, math.radians(-60.0), frequency=FREQUENCY, trigger=0.02)
    comparison = compare(bowl(), replace(observed, clock=drive.clock))
    assert comparison.alignment.shift == pytest.approx(0.02, abs=1e-6)
    assert comparison.warnings == ()
