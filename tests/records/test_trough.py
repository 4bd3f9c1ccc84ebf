"""The first harmonic of a trough's motion, a line or an ellipse, against motions with known truth."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.made_records import FREQUENCY, PERIOD, Walked, bowl, nut, trough_record

from vibro.errors import InputError
from vibro.motion.settled import settled_motion
from vibro.records.alignment import Estimate, Observation, align
from vibro.records.comparison import compare
from vibro.records.reading import Record
from vibro.records.sensors import Placement
from vibro.records.trough import MeasuredDrive, MeasuredMotion, Sensor, motion_of, spelled

TRUE = {"amplitude": 1.02e-3, "frequency": 15.003, "drive_angle": math.radians(20.5)}
TRIGGER = 0.0137
ALONG, NORMAL = ("trough_along",), ("trough_normal",)


def on_line(record: Record, **options: Any) -> MeasuredDrive:
    return motion_of(record, short=True, **options).drive_on_line()


@each("offset", [0.0, -300.0])
@each("start", [0.0, -3.7, 5000.0])
@each("cycles", [2.2, 5.5, 12.0, 60.0])
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


@each("cycles", [3.0, 5.0, 12.0])
@pytest.mark.parametrize("columns", [NORMAL, ALONG + NORMAL])
def test_errors_are_those_of_repeated_noise(columns: tuple[str, ...], cycles: float) -> None:
    """Also with rows left out; gated on the root mean square and on the largest of all."""
    off: dict[str, list[float]] = {}
    one = TRUE["drive_angle"] if columns == NORMAL else None
    for seed in range(30):
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


def test_a_frequency_is_known_far_below_the_inverse_of_the_record() -> None:
    """A part in a thousand of 1/T, with noise of a tenth of the wave."""
    record = trough_record(noise=0.9, cycles=40.0)
    drive = on_line(record)
    assert abs(drive.quantities["frequency"].value - 15.003) < 1e-3 / float(np.ptp(record.time))


@pytest.mark.parametrize("angle", [0.0, 5.0, 45.0, 80.0])
def test_one_acceleration_needs_the_drive_angle_of_the_scene(angle: float) -> None:
    alpha = math.radians(angle)
    along = on_line(trough_record(angle=alpha, columns=ALONG), drive_angle=alpha).quantities
    assert along["amplitude"].value == pytest.approx(1.02e-3, rel=1e-5)
    assert "drive_angle" not in along
    if angle:
        normal = on_line(trough_record(angle=alpha, columns=NORMAL, noise=1e-9), drive_angle=alpha)
        assert normal.quantities["amplitude"].value == pytest.approx(1.02e-3, rel=1e-5)


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


@pytest.mark.parametrize("share", [0.02, 0.2, 0.9, 3.0])
@each("cycles", [4.0, 12.0])
def test_harmonics_are_counted_and_warned_of(share: float, cycles: float) -> None:
    """A third harmonic that is larger than the fundamental does not take its place."""
    drive = on_line(trough_record(harmonic=share, noise=0.05, cycles=cycles))
    assert drive.quantities["frequency"].value == pytest.approx(15.003, abs=5e-3)
    assert drive.quantities["amplitude"].value == pytest.approx(1.02e-3, rel=4e-3)
    for found in drive.motion.sensors:
        assert found.harmonics == pytest.approx(share, rel=0.03, abs=4e-3)
    assert len(drive.motion.impurities) == (2 if share > 0.1 else 0)


def test_what_is_neither_the_wave_nor_its_harmonics_is_doubted() -> None:
    record = trough_record(noise=0.5)
    other = 3.0 * np.sin(2.0 * math.pi * 22.7 * record.time)
    motion = motion_of(replace(record, trough={name: a + other for name, a in record.trough.items()}))
    assert [sensor.rest for sensor in motion.sensors] == pytest.approx([0.364, 0.972], rel=0.03)
    assert len(motion.warnings) >= 2


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


def test_a_record_that_is_too_short_is_refused() -> None:
    with pytest.raises(InputError):
        motion_of(trough_record(cycles=1.5), short=True)


# --- the clock of the trough ------------------------------------------------------------------------


def timed(clock: float | None, trigger: float = 0.02) -> Observation:
    observed = Walked(nut()).observe("velocity", trigger=trigger)
    given = None if clock is None else Estimate(clock, 1e-5)
    return Observation(observed.time, observed.signals, FREQUENCY, given)


def test_a_measured_clock_is_taken_also_by_a_body_at_rest() -> None:
    assert align(timed(0.02), settled_motion(nut())) == (0.02, 1e-5, ())
    resting = compare(nut(0.5), timed(0.02))
    assert resting.alignment.shift == 0.02
    assert not any("cannot be found" in text for text in resting.warnings)


def test_the_bodys_own_frequency_is_told_beside_the_troughs() -> None:
    observed = timed(0.02)
    off = Observation(observed.time, observed.signals, 20.0, observed.clock)
    warnings = compare(nut(frequency=20.0), off).warnings
    assert any("15 Hz" in text and "20 Hz" in text for text in warnings)


@pytest.mark.parametrize("offset", [9.81, -40.0])
def test_the_zero_of_an_acceleration_does_not_matter(offset: float) -> None:
    observed = Walked(nut()).observe("acceleration", trigger=0.02)
    record = Record(observed.time, {"acceleration": observed.signals["acceleration"] + offset}, {}, {})
    comparison = compare(nut(), Observation.of(record, FREQUENCY))
    assert abs(comparison.alignment.shift - 0.02) < 3.0 * comparison.alignment.error < 2e-3
    (row,) = (row for row in comparison.rows if row.key == "rms_acceleration")
    exact = compare(nut(), Observation(observed.time, observed.signals, FREQUENCY))
    (own,) = (row for row in exact.rows if row.key == "rms_acceleration")
    # sampled, the jumps of the exact acceleration leave a mean too, which is taken off as well
    assert 0.8 * own.measured.value < row.measured.value < own.measured.value


@pytest.mark.parametrize(
    ("share", "ratio"), [(0.2, 0.2), (0.2, 0.371), (0.2, 0.5), (0.2, 0.8), (0.3, 0.371), (0.3, 0.8)]
)
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


@pytest.mark.parametrize("column", ["trough_along", "trough_normal"])
def test_one_acceleration_gives_one_amplitude_and_the_clock(column: str) -> None:
    drive = on_ellipse(1.1, 1.1, columns=(column,))
    amplitude = "along_amplitude" if column == "trough_along" else "normal_amplitude"
    assert list(drive.quantities) == [amplitude, "frequency"]
    assert drive.clock.value == pytest.approx(0.0137, abs=1e-6)
    assert not drive.warnings


def test_a_motion_normal_to_the_trough_alone_has_its_clock_by_the_scenes_phase() -> None:
    drive = on_ellipse(1.1, 1.1, angle=0.5 * math.pi, noise=0.3)
    assert "normal_phase" not in drive.quantities
    assert abs(drive.clock.value - 0.0137) < 4.0 * drive.clock.error < 1e-3


@each(
    ("lead_deg", "noise", "ellipse"),
    [(0.0, 0.0, False), (1.9, 0.0, False), (2.1, 0.0, True), (-2.1, 0.0, True), (4.0, 3.0, False),
     (60.0, 3.0, True), (-150.0, 0.0, True), (177.8, 0.0, True)],
)  # fmt: skip
def test_an_ellipse_is_one_beyond_its_error(lead_deg: float, noise: float, ellipse: bool) -> None:
    record = trough_record(ellipse=math.radians(lead_deg), noise=noise)
    assert motion_of(record).on_an_ellipse == ellipse


@each(("given", "doubts"), [(170.0, 0), (-170.0, 0), (0.0, 1), (-75.0, 1), (-85.0, 0)])
def test_a_phase_nearly_opposite_to_the_scenes_is_doubted(given: float, doubts: int) -> None:
    drive = on_ellipse(math.radians(given), math.radians(-170.0))
    assert len(drive.warnings) == doubts


def test_the_troughs_clock_places_the_record() -> None:
    observed = Walked(bowl()).observe("velocity", trigger=0.02)
    drive = on_ellipse(None, math.radians(-60.0), frequency=FREQUENCY, trigger=0.02)
    comparison = compare(bowl(), replace(observed, clock=drive.clock))
    assert comparison.alignment.shift == pytest.approx(0.02, abs=1e-6)
    assert comparison.warnings == ()


# --- by hand: harmonics of given size, phase and error ------------------------------------------------


def moved(*sizes: complex, errors: tuple[float, ...], frequency_error: float = 0.0) -> MeasuredMotion:
    """Make a motion of 15 Hz that both sensors saw for 2 s; its acceleration is opposed to it."""
    return MeasuredMotion(
        frequency=15.0,
        frequency_error=frequency_error,
        channels=ALONG + NORMAL,
        accelerations=-np.array([sizes], np.complex128),
        covariance=np.diag(2.0 * np.square(errors)).astype(np.complex128)[None],
        freedom=1e6,
        p_values=np.zeros(1),
        significant=1,
        drive_angle=None,
        drive_angle_error=0.0,
        placement=Placement(np.eye(2), {}, 0.0, 0.0),
        clock=0.0,
        span=2.0,
        rows=1000,
        sensors=(Sensor("u [g]", "", 0.0, 0.0),) * 2,
        warnings=(),
    )


def wave(size: float, phase: float) -> complex:
    return size * complex(math.cos(phase), math.sin(phase))


def test_errors_of_the_frequency_count_in_amplitude_and_clock() -> None:
    """By the square of the frequency, and by half the record."""
    drive = moved(3.0, 4.0, errors=(0.05, 0.05), frequency_error=0.15).drive_on_line()
    amplitude, clock = drive.quantities["amplitude"], drive.clock
    assert amplitude.value == pytest.approx(5.0 / (30.0 * math.pi) ** 2)
    assert amplitude.error / amplitude.value == pytest.approx(math.hypot(0.01, 2.0 * 0.01))
    assert clock.error == pytest.approx(math.hypot(0.01 / (30.0 * math.pi), 0.5 * 2.0 * 0.01))


@each(
    ("sizes", "errors", "has_phase"),
    [
        ((4.0, 0.0041), (0.0, 0.0), True),
        ((4.0, 0.0039), (0.0, 0.0), False),
        ((0.0039, 4.0), (0.0, 0.0), False),
        # of 3.72 errors, the root of 2 log 1000, of either sensor
        ((4.0, 0.373), (0.0, 0.1), True),
        ((4.0, 0.37), (0.0, 0.1), False),
        ((4.0, 0.37), (0.1, 0.0), False),
        ((0.37, 4.0), (0.1, 0.0), False),
        ((0.373, 4.0), (0.0, 0.1), True),
    ],
)
def test_a_motion_has_a_phase_beyond_a_thousandth_of_the_other_and_what_noise_makes_once_in_1000(
    sizes: tuple[float, float], errors: tuple[float, float], has_phase: bool
) -> None:
    assert math.isnan(moved(*sizes, errors=errors).phase) == (not has_phase)


@each("turn", [0.0, 180.0, -180.0])
@each(
    ("off_deg", "error", "ellipse"),
    [(1.95, 0.0, False), (2.05, 0.0, True), (3.3, 0.08, False), (3.6, 0.08, True), (-3.6, 0.08, True)],
)
def test_a_line_is_left_beyond_two_degrees_and_three_errors(
    off_deg: float, error: float, ellipse: bool, turn: float
) -> None:
    """An error of 0.08 of 4 is one of 0.02 rad, three of which are 3.44 deg."""
    motion = moved(4.0, wave(4.0, math.radians(off_deg + turn)), errors=(0.0, error))
    assert motion.on_an_ellipse == ellipse


@pytest.mark.parametrize(
    ("x", "y", "lead"), [(3.0, 4.0, 1.0), (4.0, 3.0, -1.2), (5.0, 1.0, 0.6), (2.0, 2.1, 1.5)]
)
def test_the_drive_angle_is_that_of_the_longer_axis(x: float, y: float, lead: float) -> None:
    """Where the acceleration in a direction is largest."""
    angle = moved(x, wave(y, lead), errors=(0.0, 0.0)).line_angle
    directions = np.linspace(0.0, 0.5 * math.pi, 200_001)
    sizes = np.abs(x * np.cos(directions) + y * np.exp(1j * lead) * np.sin(directions))
    assert angle.value == pytest.approx(float(directions[np.argmax(sizes)]), abs=1e-5)


def test_a_line_that_leads_down_by_noise_alone_is_level_or_upright() -> None:
    for x, y, expected, error in ((4.0, 0.01, 0.0, 0.2), (0.01, 4.0, 0.5 * math.pi, 0.1)):
        angle = moved(x, -y, errors=(0.1, 0.2)).line_angle
        assert angle == pytest.approx((expected, error / math.hypot(x, y)))


@pytest.mark.parametrize(("size", "from_normal"), [(0.29, True), (0.31, False)])
def test_the_clock_of_an_ellipse_is_that_along_it_where_it_moves_so(size: float, from_normal: bool) -> None:
    """Else it follows from the normal motion by the scene's phase."""
    clock = moved(wave(size, 0.2), wave(4.0, 1.5), errors=(0.1, 0.1)).drive_on_ellipse(0.7).clock
    rate = 30.0 * math.pi
    assert clock.value * rate == pytest.approx(1.5 - 0.7 if from_normal else 0.2)
    assert clock.error * rate == pytest.approx(0.1 / (4.0 if from_normal else size))


@each(
    ("value", "error", "text"),
    [(15.00325123, 0.0009, "15.003251"), (1234.5, 20.0, "1234.5"), (1.5, 0.0, "1.500000000000000")],
)
def test_digits_far_below_the_error_are_left_out(value: float, error: float, text: str) -> None:
    assert spelled(value, error) == text


# --- records ------------------------------------------------------------------------------------------


@each("order", [2, 5])
@each("cycles", [4.0, 12.0])
def test_each_harmonic_counts(order: int, cycles: float) -> None:
    record = trough_record(columns=ALONG, cycles=cycles)
    rate = 2.0 * math.pi * 15.003
    peak = 1.02e-3 * rate**2 * math.cos(math.radians(20.5))
    values = record.trough["trough_along"] + 0.2 * peak * np.sin(order * rate * record.time + 1.0)
    motion = motion_of(replace(record, trough={"trough_along": values}), drive_angle=0.0, short=True)
    assert motion.sensors[0].harmonics == pytest.approx(0.2, rel=1e-3)
    if not motion.is_short:
        assert motion.sensors[0].rest < 1e-3


def test_a_sensor_may_drift_slowly() -> None:
    record = trough_record(columns=ALONG)
    drifting = replace(record, trough={"trough_along": record.trough["trough_along"] + 5.0 * record.time})
    slow, plain = (motion_of(one, drive_angle=0.0) for one in (drifting, record))
    assert abs(slow.accelerations[0, 0]) == pytest.approx(abs(plain.accelerations[0, 0]), rel=1e-4)
    assert slow.sensors[0].rest < 1e-3
