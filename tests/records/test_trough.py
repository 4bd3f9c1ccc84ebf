"""Accelerometers on the trough: what they tell of the drive, against motions with known truth."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.made_records import FREQUENCY, PERIOD, Walked, bowl, moved, nut, trough_record, wave

from vibro.errors import InputError
from vibro.motion.settled import settled_motion
from vibro.records.alignment import Estimate, Observation, align
from vibro.records.comparison import compare
from vibro.records.reading import Record
from vibro.records.trough import MeasuredDrive, Trough, Wave, spelled, trough_of

TRUE = {"amplitude": 1.02e-3, "frequency": 15.003, "drive_angle": math.radians(20.5)}
TRIGGER = 0.0137
ALONG, NORMAL = ("trough_along",), ("trough_normal",)


def measured(record: Record, angle: float | None = None, **options: Any) -> MeasuredDrive:
    trough = trough_of(record, **options)
    assert trough is not None
    return trough.drive_on_line(angle)


def test_a_record_without_accelerations_of_the_trough_tells_nothing() -> None:
    assert trough_of(trough_record(columns=())) is None


@each("offset", [0.0, 9.81, -300.0])
@each("start", [0.0, -3.7, 5000.0])
@each("cycles", [2.2, 5.5, 12.0, 60.0])
def test_exact_accelerations_give_the_exact_motion(cycles: float, start: float, offset: float) -> None:
    """Whatever the clock and the sensor's zero, such as gravity on a sensor that is not level."""
    drive = measured(trough_record(cycles=cycles, samples=20, offset=offset, start=start))
    assert drive.quantities["amplitude"].value == pytest.approx(TRUE["amplitude"], rel=1e-5)
    assert drive.quantities["frequency"].value == pytest.approx(TRUE["frequency"], rel=1e-6)
    assert drive.quantities["drive_angle"].value == pytest.approx(TRUE["drive_angle"], abs=1e-6)
    # the clock counts where the record is: at its middle
    middle = start + 0.5 * cycles / TRUE["frequency"]
    turns = (middle + drive.clock.value) * drive.quantities["frequency"].value - (
        middle - start + TRIGGER
    ) * 15.003
    assert abs(math.remainder(turns, 1.0)) < 1e-5
    assert drive.trough.warnings == ()


@pytest.mark.parametrize("columns", [NORMAL, ALONG + NORMAL])
def test_errors_are_those_of_repeated_noise(columns: tuple[str, ...]) -> None:
    """Also with rows left out; gated on the root mean square and on the largest of all."""
    off: dict[str, list[float]] = {}
    for seed in range(30):
        record = trough_record(noise=1.5, offset=3.0, columns=columns, samples=20, seed=seed, lost=0.03)
        drive = measured(record, TRUE["drive_angle"])
        for name, estimate in drive.quantities.items():
            off.setdefault(name, []).append((estimate.value - TRUE[name]) / estimate.error)
        off.setdefault("clock", []).append(
            math.remainder(drive.clock.value - TRIGGER, PERIOD) / drive.clock.error
        )
    assert len(off) == 3 + (len(columns) == 2)
    for name, values in off.items():
        assert 0.6 < float(np.sqrt(np.mean(np.square(values)))) < 1.4, name
        assert max(map(abs, values)) < 4.0, name


def test_errors_of_the_frequency_count_in_amplitude_and_clock() -> None:
    """By the square of the frequency, and by half the record."""
    wave = Wave("a [g]", 3.0 - 4.0j, 0.05, 0.0, 0.0, "")
    drive = Trough(Estimate(15.0, 0.15), wave, None, 2.0).drive_on_line(0.0)
    amplitude, clock = drive.quantities["amplitude"], drive.clock
    assert amplitude.value == pytest.approx(5.0 / (30.0 * math.pi) ** 2)
    assert amplitude.error / amplitude.value == pytest.approx(math.hypot(0.01, 2.0 * 0.01))
    assert clock.error == pytest.approx(math.hypot(0.01 / (30.0 * math.pi), 0.5 * 2.0 * 0.01))


def test_the_error_of_a_wave_is_that_of_white_noise() -> None:
    """The root of 2 / N times the noise; and noise counts as no harmonics."""
    errors, harmonics = [], []
    for seed in range(20):
        record = trough_record(noise=1.5, samples=20, seed=seed)
        trough = trough_of(record)
        assert trough is not None
        errors += [wave.error for wave in trough.waves]
        harmonics += [wave.harmonics**2 for wave in trough.waves if wave is trough.along]
    assert np.mean(errors) == pytest.approx(1.5 * math.sqrt(2.0 / record.time.size), rel=0.1)
    assert np.mean(harmonics) < 1.5e-3


def test_the_error_of_the_direction_is_that_across_it() -> None:
    x, y = 4.0 * math.cos(0.3), 4.0 * math.sin(0.3)
    for along, normal, across in ((0.2, 0.0, math.sin(0.3)), (0.0, 0.2, math.cos(0.3))):
        waves = Wave("a [g]", -x, along, 0.0, 0.0, ""), Wave("b [g]", -y, normal, 0.0, 0.0, "")
        angle = Trough(Estimate(15.0, 0.0), *waves, 2.0).drive_angle
        assert angle == pytest.approx((0.3, 0.2 * across / 4.0))


def test_a_frequency_is_known_far_below_the_inverse_of_the_record() -> None:
    """A part in a thousand of 1/T, with noise of a tenth of the wave."""
    record = trough_record(noise=0.9, cycles=40.0)
    drive = measured(record)
    assert abs(drive.quantities["frequency"].value - 15.003) < 1e-3 / float(np.ptp(record.time))


@pytest.mark.parametrize("angle", [0.0, 5.0, 45.0, 80.0])
def test_one_acceleration_needs_the_drive_angle_of_the_scene(angle: float) -> None:
    alpha = math.radians(angle)
    along = trough_record(angle=alpha, columns=ALONG)
    assert measured(along, alpha).quantities["amplitude"].value == pytest.approx(1.02e-3, rel=1e-5)
    assert "drive_angle" not in measured(along, alpha).quantities
    normal = trough_record(angle=alpha, columns=NORMAL, noise=1e-9)
    if angle:
        assert measured(normal, alpha).quantities["amplitude"].value == pytest.approx(1.02e-3, rel=1e-5)
    with pytest.raises(InputError, match="trough_normal cannot"):
        measured(trough_record(columns=NORMAL), 0.0)


@pytest.mark.parametrize("angle", [0.0, 0.01, 89.9])
def test_a_drive_angle_at_an_end_of_its_range_stays_in_it(angle: float) -> None:
    for seed in range(6):
        drive = measured(trough_record(angle=math.radians(angle), noise=0.5, samples=20, seed=seed))
        value, error = drive.quantities["drive_angle"]
        assert 0.0 <= value <= 0.5 * math.pi
        assert abs(value - math.radians(angle)) < 4.0 * error


def test_inverted_sensors() -> None:
    record = trough_record()
    for name in record.trough:
        other = Record(record.time, {}, {**record.trough, name: -record.trough[name]}, record.headers)
        with pytest.raises(InputError):
            trough_of(other)
        assert trough_of(other, down=True) is not None
    against = Record(
        record.time, {}, {**record.trough, "trough_along": -record.trough["trough_along"]}, record.headers
    )
    right = measured(record)
    assert measured(against, reverse=True).quantities == right.quantities
    with pytest.raises(InputError):
        trough_of(record, reverse=True)


@pytest.mark.parametrize("share", [0.02, 0.2, 0.9, 3.0])
def test_harmonics_are_told_and_warned_of(share: float) -> None:
    """A third harmonic that is larger than the fundamental does not take its place."""
    drive = measured(trough_record(harmonic=share, noise=0.05))
    assert drive.quantities["frequency"].value == pytest.approx(15.003, abs=1e-3)
    assert drive.quantities["amplitude"].value == pytest.approx(1.02e-3, rel=2e-3)
    for found in drive.trough.waves:
        assert found.harmonics == pytest.approx(share, rel=0.02, abs=2e-3)
    assert len([text for text in drive.trough.warnings if "harmonics" in text]) == (2 if share > 0.1 else 0)


def test_what_is_neither_the_wave_nor_its_harmonics_is_told() -> None:
    record = trough_record(noise=0.5)
    other = 3.0 * np.sin(2.0 * math.pi * 22.7 * record.time)
    trough = trough_of(replace(record, trough={name: a + other for name, a in record.trough.items()}))
    assert trough is not None
    assert [wave.rest for wave in trough.waves] == pytest.approx([0.364, 0.972], rel=0.02)
    assert len(trough.warnings) >= 2


def test_a_sensor_that_shows_nothing_is_told() -> None:
    """A dead one is refused; of one that shows noise alone it is said, as a drive may be level."""
    record = trough_record(noise=0.5)
    noise = np.random.default_rng(3).standard_normal(record.time.size)
    for dead in (0.0 * noise, 3.0 + 0.0 * noise, 1e-200 * noise):
        with pytest.raises(InputError, match="'trough_normal'"):
            trough_of(Record(record.time, {}, {**record.trough, "trough_normal": dead}, record.headers))
    trough = trough_of(Record(record.time, {}, {**record.trough, "trough_normal": noise}, record.headers))
    assert trough is not None
    assert len(trough.warnings) == 1
    assert math.isnan(trough.phase)


def test_a_record_that_is_too_short_or_too_coarse_is_refused() -> None:
    for short in (trough_record(cycles=1.5), trough_record(samples=6)):
        with pytest.raises(InputError):
            trough_of(short)


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


@each(
    ("value", "error", "text"),
    [(15.00325123, 0.0009, "15.003251"), (1234.5, 20.0, "1234.5"), (1.5, 0.0, "1.500000000000000")],
)
def test_digits_far_below_the_error_are_left_out(value: float, error: float, text: str) -> None:
    assert spelled(value, error) == text


@pytest.mark.parametrize(
    ("share", "ratio"), [(0.2, 0.2), (0.2, 0.371), (0.2, 0.5), (0.2, 0.8), (0.3, 0.371), (0.3, 0.8)]
)
def test_another_machine_in_the_record_does_not_hide_the_drive(ratio: float, share: float) -> None:
    for seed in range(2):
        record = trough_record(noise=0.1, seed=seed, cycles=10.0 + 7.0 * seed)
        wave = np.sin(2.0 * math.pi * 15.003 * ratio * record.time + seed)
        shaken = {name: a + 0.5 * share * np.ptp(a) * wave for name, a in record.trough.items()}
        drive = measured(replace(record, trough=shaken))
        assert drive.quantities["frequency"].value == pytest.approx(15.003, rel=0.01)
        assert drive.quantities["amplitude"].value == pytest.approx(TRUE["amplitude"], rel=0.15)


# --- elliptical drives -------------------------------------------------------------------------------


def on_ellipse(phase: float | None, lead: float, **options: Any) -> MeasuredDrive:
    trough = trough_of(trough_record(ellipse=lead, **options), down=True)
    assert trough is not None
    return trough.drive_on_ellipse(phase)


@pytest.mark.parametrize("lead_deg", [-179.0, 90.0])
def test_errors_of_an_ellipse_are_those_of_repeated_noise(lead_deg: float) -> None:
    lead = math.radians(lead_deg)
    x, y = (1.02e-3 * side(math.radians(20.5)) for side in (math.cos, math.sin))
    true = {"along_amplitude": x, "normal_amplitude": y, "normal_phase": lead, "frequency": 15.003}
    off: dict[str, list[float]] = {}
    for seed in range(20):
        drive = on_ellipse(0.0, lead, noise=0.5, offset=3.0, samples=20, seed=seed)
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
    assert drive.warnings == ()


def test_a_motion_normal_to_the_trough_alone_tells_the_clock_by_the_scenes_phase() -> None:
    drive = on_ellipse(1.1, 1.1, angle=0.5 * math.pi, noise=0.3)
    assert "normal_phase" not in drive.quantities
    assert abs(drive.clock.value - 0.0137) < 4.0 * drive.clock.error < 1e-3


@each(
    ("lead_deg", "noise", "ellipse"),
    [(0.0, 0.0, False), (1.9, 0.0, False), (2.1, 0.0, True), (-2.1, 0.0, True), (4.0, 3.0, False),
     (60.0, 3.0, True), (-150.0, 0.0, True), (177.8, 0.0, True)],
)  # fmt: skip
def test_an_ellipse_is_one_beyond_its_error(lead_deg: float, noise: float, ellipse: bool) -> None:
    trough = trough_of(trough_record(ellipse=math.radians(lead_deg), noise=noise))
    assert trough is not None
    assert trough.on_an_ellipse == ellipse


@pytest.mark.parametrize("lead_deg", [-150.0, -60.0, 12.0, 120.0])
def test_an_ellipse_in_the_place_of_a_line_is_told_with_its_size(lead_deg: float) -> None:
    drive = on_ellipse(None, math.radians(lead_deg), noise=1e-3)
    said, *more = drive.warnings
    numbers = [float(text) for text in re.findall(r"-?\d+\.?\d*(?= ?(?:mm|deg))", said)]
    expected = [1.02 * math.cos(math.radians(20.5)), 1.02 * math.sin(math.radians(20.5)), lead_deg]
    assert numbers == pytest.approx(expected, rel=2e-3)
    assert len(more) == (abs(lead_deg) > 90.0)


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


# --- by hand: waves of given size, phase and error ----------------------------------------------------


@pytest.mark.parametrize("lead", [0.7, -2.0, 3.0])
def test_the_phase_is_that_of_the_normal_motion_ahead_of_that_along(lead: float) -> None:
    trough = moved(wave(3.0, 0.4, 0.03), wave(4.0, 0.4 + lead, 0.08))
    assert trough.phase == pytest.approx(lead)
    assert trough.phase_error == pytest.approx(math.hypot(0.01, 0.02))
    assert math.isnan(moved(wave(3.0), None).phase)
    assert math.isnan(moved(None, wave(3.0)).phase_error)


@each(
    ("along", "normal", "has_phase"),
    [
        ((4.0, 0.0), (0.0041, 0.0), True),
        ((4.0, 0.0), (0.0039, 0.0), False),
        ((0.0039, 0.0), (4.0, 0.0), False),
        # of three errors, of either sensor
        ((4.0, 0.0), (0.31, 0.1), True),
        ((4.0, 0.0), (0.29, 0.1), False),
        ((4.0, 0.1), (0.29, 0.0), False),
        ((0.29, 0.1), (4.0, 0.0), False),
        ((0.31, 0.0), (4.0, 0.1), True),
    ],
)
def test_a_motion_has_a_phase_beyond_a_thousandth_of_the_other_and_three_errors(
    along: tuple[float, float], normal: tuple[float, float], has_phase: bool
) -> None:
    trough = moved(wave(along[0], error=along[1]), wave(normal[0], 0.5, normal[1]))
    assert math.isnan(trough.phase) == (not has_phase)


@each("turn", [0.0, 180.0, -180.0])
@each(
    ("off_deg", "error", "ellipse"),
    [(1.95, 0.0, False), (2.05, 0.0, True), (3.3, 0.08, False), (3.6, 0.08, True), (-3.6, 0.08, True)],
)
def test_a_line_is_left_beyond_two_degrees_and_three_errors(
    off_deg: float, error: float, ellipse: bool, turn: float
) -> None:
    """An error of 0.08 of 4 is one of 0.02 rad, three of which are 3.44 deg."""
    trough = moved(wave(4.0), wave(4.0, math.radians(off_deg + turn), error))
    assert trough.on_an_ellipse == ellipse


@pytest.mark.parametrize(
    ("x", "y", "lead"), [(3.0, 4.0, 1.0), (4.0, 3.0, -1.2), (5.0, 1.0, 0.6), (2.0, 2.1, 1.5)]
)
def test_the_drive_angle_is_that_of_the_longer_axis(x: float, y: float, lead: float) -> None:
    """Where the acceleration in a direction is largest."""
    angle = moved(wave(x, 0.3), wave(y, 0.3 + lead)).drive_angle
    assert angle is not None
    directions = np.linspace(0.0, 0.5 * math.pi, 200_001)
    sizes = np.abs(x * np.cos(directions) + y * np.exp(1j * lead) * np.sin(directions))
    assert angle.value == pytest.approx(float(directions[np.argmax(sizes)]), abs=1e-5)


def test_a_line_that_leads_down_by_noise_alone_is_level_or_upright() -> None:
    for x, y, expected, error in ((4.0, 0.01, 0.0, 0.2), (0.01, 4.0, 0.5 * math.pi, 0.1)):
        angle = moved(wave(x, error=0.1), wave(y, math.pi, error=0.2)).drive_angle
        assert angle == pytest.approx((expected, error / math.hypot(x, y)))


def test_one_acceleration_is_scaled_up_with_its_error() -> None:
    for trough, part in ((moved(wave(3.0, error=0.3), None), 0.6), (moved(None, wave(3.0, error=0.3)), 0.8)):
        value, error = trough.drive_on_line(math.acos(0.6)).quantities["amplitude"]
        assert value == pytest.approx(3.0 / part / (30.0 * math.pi) ** 2)
        assert error == pytest.approx(0.1 * value)


def test_two_accelerations_along_the_drive_have_the_errors_of_their_parts() -> None:
    trough = moved(wave(3.0, error=0.1), wave(4.0, error=0.2))
    value, error = trough.drive_on_line().quantities["amplitude"]
    assert value == pytest.approx(5.0 / (30.0 * math.pi) ** 2)
    assert error / value == pytest.approx(math.hypot(0.06, 0.16) / 5.0)


@pytest.mark.parametrize(("size", "from_normal"), [(0.29, True), (0.31, False)])
def test_the_clock_of_an_ellipse_is_that_along_it_where_it_moves_so(size: float, from_normal: bool) -> None:
    """Else it follows from the normal motion by the scene's phase."""
    trough = moved(wave(size, 0.2, 0.1), wave(4.0, 1.5, 0.1))
    clock = trough.drive_on_ellipse(0.7).clock
    rate = 30.0 * math.pi
    assert clock.value * rate == pytest.approx(1.5 - 0.7 if from_normal else 0.2)
    assert clock.error * rate == pytest.approx(0.1 / (4.0 if from_normal else size))


def test_amplitudes_of_an_ellipse_have_their_own_errors() -> None:
    found = moved(wave(3.0, 0.2, 0.03), wave(4.0, 0.9, 0.08)).drive_on_ellipse(0.7).quantities
    size = (30.0 * math.pi) ** -2
    assert found["along_amplitude"] == pytest.approx((3.0 * size, 0.03 * size))
    assert found["normal_amplitude"] == pytest.approx((4.0 * size, 0.08 * size))
    assert found["normal_phase"] == pytest.approx((0.7, math.hypot(0.01, 0.02)))


# --- records ------------------------------------------------------------------------------------------


def test_reverse_does_not_turn_a_sensor_normal_to_the_trough() -> None:
    record = trough_record(columns=NORMAL, noise=0.1)
    plain, turned = (trough_of(record, reverse=reverse) for reverse in (False, True))
    assert plain is not None
    assert plain == turned
    for columns in (ALONG, ALONG + NORMAL):
        record = trough_record(columns=columns, noise=0.1, ellipse=1.0)
        plain, turned = (trough_of(record, reverse=reverse) for reverse in (False, True))
        assert plain is not None
        assert turned is not None
        assert plain.along is not None
        assert turned.along is not None
        assert turned.along.value == pytest.approx(-plain.along.value)
        assert turned.normal == plain.normal


@each("order", [2, 3, 5])
def test_each_harmonic_counts(order: int) -> None:
    record = trough_record(columns=ALONG)
    rate = 2.0 * math.pi * 15.003
    peak = 1.02e-3 * rate**2 * math.cos(math.radians(20.5))
    values = record.trough["trough_along"] + 0.2 * peak * np.sin(order * rate * record.time + 1.0)
    trough = trough_of(replace(record, trough={"trough_along": values}))
    assert trough is not None
    assert trough.along is not None
    assert trough.along.harmonics == pytest.approx(0.2, rel=1e-3)
    assert trough.along.rest < 1e-3


def test_a_sensor_may_drift_slowly() -> None:
    record = trough_record(columns=ALONG)
    drifting = replace(record, trough={"trough_along": record.trough["trough_along"] + 5.0 * record.time})
    trough, plain = trough_of(drifting), trough_of(record)
    assert trough is not None
    assert plain is not None
    assert trough.along is not None
    assert plain.along is not None
    assert trough.along.value == pytest.approx(plain.along.value, rel=1e-4)
    assert trough.along.rest < 1e-3


def test_waves_have_the_header_and_the_sensitivity_of_their_column() -> None:
    headers = {"trough_along": "u [V]", "trough_normal": "w [V]"}
    record = replace(trough_record(), headers=headers, sensitivities={"trough_normal": "1V/g"})
    trough = trough_of(record)
    assert trough is not None
    assert [(wave.header, wave.sensitivity) for wave in trough.waves] == [("u [V]", ""), ("w [V]", "1V/g")]
    assert float(spelled(*trough.frequency)) == trough.frequency.value
    for name in ("trough_along", "trough_normal"):
        dead = replace(record, trough={**record.trough, name: 0.0 * record.time})
        with pytest.raises(InputError, match=re.escape(repr(headers[name]))):
            trough_of(dead)
