"""Accelerometers on the trough: what they tell of the drive, against motions with known truth."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers.made_records import FREQUENCY, PERIOD, Walked, bowl, nut, trough_record

from vibro.errors import InputError
from vibro.motion.settled import settled_motion
from vibro.records.alignment import Observation, align
from vibro.records.comparison import compare
from vibro.records.folding import Estimate
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


@pytest.mark.parametrize("offset", [0.0, 9.81, -300.0])
@pytest.mark.parametrize("start", [0.0, -3.7, 5000.0])
@pytest.mark.parametrize("cycles", [2.2, 5.5, 12.0, 60.0])
def test_exact_accelerations_give_the_exact_motion(cycles: float, start: float, offset: float) -> None:
    """Whatever the clock and the sensor's zero, such as gravity on a sensor that is not level."""
    drive = measured(trough_record(cycles=cycles, offset=offset, start=start))
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


@pytest.mark.parametrize("columns", [ALONG, NORMAL, ALONG + NORMAL])
def test_errors_are_those_of_repeated_noise(columns: tuple[str, ...]) -> None:
    """Also with rows left out; gated on the root mean square and on the largest of all."""
    off: dict[str, list[float]] = {}
    for seed in range(60):
        record = trough_record(noise=1.5, offset=3.0, columns=columns, seed=seed, lost=0.03)
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
        record = trough_record(noise=1.5, seed=seed)
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
    with pytest.raises(InputError, match="--trough-normal cannot measure the motion at a drive angle of 0"):
        measured(trough_record(columns=NORMAL), 0.0)


@pytest.mark.parametrize("angle", [0.0, 0.01, 89.9])
def test_a_drive_angle_at_an_end_of_its_range_stays_in_it(angle: float) -> None:
    for seed in range(10):
        drive = measured(trough_record(angle=math.radians(angle), noise=0.5, seed=seed))
        value, error = drive.quantities["drive_angle"]
        assert 0.0 <= value <= 0.5 * math.pi
        assert abs(value - math.radians(angle)) < 4.0 * error


def test_inverted_sensors() -> None:
    record = trough_record()
    for name in record.trough:
        other = Record(record.time, {}, {**record.trough, name: -record.trough[name]}, record.headers)
        with pytest.raises(InputError, match="moves down while it moves forwards") as caught:
            trough_of(other)
        assert "--reverse, if" in caught.value.hint
    against = Record(
        record.time, {}, {**record.trough, "trough_along": -record.trough["trough_along"]}, record.headers
    )
    right = measured(record)
    assert measured(against, reverse=True).quantities == right.quantities
    with pytest.raises(InputError) as caught:
        trough_of(record, reverse=True)
    assert "leave out --reverse" in caught.value.hint


@pytest.mark.parametrize("share", [0.02, 0.2, 0.9, 3.0])
def test_harmonics_are_told_and_warned_of(share: float) -> None:
    """A third harmonic that is larger than the fundamental does not take its place."""
    drive = measured(trough_record(harmonic=share, noise=0.05))
    assert drive.quantities["frequency"].value == pytest.approx(15.003, abs=1e-3)
    assert drive.quantities["amplitude"].value == pytest.approx(1.02e-3, rel=2e-3)
    for wave in drive.trough.waves:
        assert wave.harmonics == pytest.approx(share, rel=0.02, abs=2e-3)
    warned = [
        text for text in drive.trough.warnings if "but the computed trough moves as a pure sine" in text
    ]
    assert len(warned) == (2 if share > 0.1 else 0)


def test_what_is_neither_the_wave_nor_its_harmonics_is_told() -> None:
    record = trough_record(noise=0.5)
    disturbed = {
        name: values + 3.0 * np.sin(2.0 * math.pi * 22.7 * record.time)
        for name, values in record.trough.items()
    }
    trough = trough_of(Record(record.time, {}, disturbed, record.headers))
    assert trough is not None
    assert [wave.rest for wave in trough.waves] == pytest.approx([0.364, 0.972], rel=0.02)
    assert all("the residual has" in text for text in trough.warnings)
    assert len(trough.warnings) >= 2


@pytest.mark.parametrize("kind", ["noise", "drift", "zero"])
def test_a_trough_that_does_not_run_is_refused(kind: str) -> None:
    record = trough_record(columns=ALONG)
    values = {
        "noise": np.random.default_rng(2).standard_normal(record.time.size),
        "drift": 2.0 + record.time,
        "zero": 0.0 * record.time,
    }[kind]
    with pytest.raises(InputError, match=r"in column 'trough_along'|for --trough-along does not vibrate"):
        trough_of(Record(record.time, {}, {"trough_along": values}, record.headers))


def test_a_sensor_that_shows_nothing_is_told() -> None:
    """A dead one is refused; of one that shows noise alone it is said, as a drive may be level."""
    record = trough_record(noise=0.5)
    noise = np.random.default_rng(3).standard_normal(record.time.size)
    for dead in (0.0 * noise, 3.0 + 0.0 * noise, 1e-200 * noise):
        with pytest.raises(InputError, match="'trough_normal' for --trough-normal does not vibrate"):
            trough_of(Record(record.time, {}, {**record.trough, "trough_normal": dead}, record.headers))
    trough = trough_of(Record(record.time, {}, {**record.trough, "trough_normal": noise}, record.headers))
    assert trough is not None
    (warning,) = trough.warnings
    assert warning.startswith("column 'trough_normal': no wave of 15")
    assert math.isnan(trough.phase)


def test_a_record_that_is_too_short_or_too_coarse_is_refused() -> None:
    with pytest.raises(InputError, match=r"at least 2 are needed|no wave stands out"):
        trough_of(trough_record(cycles=1.5))
    with pytest.raises(InputError, match="samples a drive cycle"):
        trough_of(trough_record(samples=6))


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


@pytest.mark.parametrize(
    ("late", "said"),
    [
        (0.0, None),
        (0.1e-3, None),
        (4e-3, "fit best 4 ms (22 deg) earlier in the cycle than the trough's acceleration says"),
        (-4e-3, "fit best 4 ms (22 deg) later in the cycle than the trough's acceleration says"),
        (0.5 * PERIOD, "one of the sensors may be inverted"),
    ],
)  # fmt: skip
def test_a_clock_that_the_body_contradicts_is_told(late: float, said: str | None) -> None:
    warnings = compare(nut(), timed((0.02 + late) % PERIOD)).warnings
    assert len(warnings) == (said is not None)
    assert said is None or said in warnings[0]


def test_the_bodys_own_frequency_is_told_beside_the_troughs() -> None:
    observed = timed(0.02)
    off = Observation(observed.time, observed.signals, 20.0, observed.clock)
    warnings = compare(nut(frequency=20.0), off).warnings
    assert any(
        "signals repeat at 15 Hz, the trough at 20 Hz: are both of one run" in text for text in warnings
    )


@pytest.mark.parametrize("offset", [0.0, 9.81, -40.0])
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
    ("value", "error", "text"),
    [(15.00325123, 0.0009, "15.003251"), (1234.5, 20.0, "1234.5"), (1.5, 0.0, "1.500000000000000")],
)
def test_digits_far_below_the_error_are_left_out(value: float, error: float, text: str) -> None:
    assert spelled(value, error) == text


@pytest.mark.parametrize(
    ("share", "ratio"), [(0.2, 0.2), (0.2, 0.371), (0.2, 0.5), (0.2, 0.8), (0.3, 0.371), (0.3, 0.8)]
)
def test_another_machine_in_the_record_does_not_hide_the_drive(ratio: float, share: float) -> None:
    for seed in range(4):
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


@pytest.mark.parametrize("lead_deg", [-179.0, -60.0, 0.0, 90.0])
def test_errors_of_an_ellipse_are_those_of_repeated_noise(lead_deg: float) -> None:
    lead = math.radians(lead_deg)
    x, y = (1.02e-3 * side(math.radians(20.5)) for side in (math.cos, math.sin))
    true = {"along_amplitude": x, "normal_amplitude": y, "normal_phase": lead, "frequency": 15.003}
    off: dict[str, list[float]] = {}
    for seed in range(20):
        drive = on_ellipse(0.0, lead, noise=0.5, offset=3.0, seed=seed)
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


@pytest.mark.parametrize(
    ("lead_deg", "noise", "ellipse"),
    [(0.0, 0.0, False), (1.9, 0.0, False), (2.1, 0.0, True), (-2.1, 0.0, True), (4.0, 3.0, False),
     (60.0, 3.0, True), (-150.0, 0.0, True), (177.8, 0.0, True)],
)  # fmt: skip
def test_an_ellipse_is_one_beyond_its_error(lead_deg: float, noise: float, ellipse: bool) -> None:
    trough = trough_of(trough_record(ellipse=math.radians(lead_deg), noise=noise))
    assert trough is not None
    assert trough.on_an_ellipse == ellipse


@pytest.mark.parametrize("lead_deg", [-150.0, -60.0, 12.0, 120.0])
def test_an_ellipse_in_the_place_of_a_line_is_told_with_the_options_to_give(lead_deg: float) -> None:
    drive = on_ellipse(None, math.radians(lead_deg), noise=1e-3)
    said, *more = drive.warnings
    numbers = [float(word) for word in said.replace("=", " ").replace("mm", " ").replace("deg", " ").split()
               if word.lstrip("-").replace(".", "").isdigit()]  # fmt: skip
    expected = [1.02 * math.cos(math.radians(20.5)), 1.02 * math.sin(math.radians(20.5)), lead_deg]
    assert numbers == pytest.approx([*expected, *expected], rel=2e-3)
    assert f"--phase{'=' if lead_deg < 0.0 else ' '}" in said
    assert len(more) == (abs(lead_deg) > 90.0)
    assert all("one of the two sensors may be inverted" in text for text in more)


@pytest.mark.parametrize(("given", "doubts"), [(170.0, 0), (-170.0, 0), (0.0, 1), (-75.0, 1), (-85.0, 0)])
def test_a_phase_nearly_opposite_to_the_scenes_is_doubted(given: float, doubts: int) -> None:
    drive = on_ellipse(math.radians(given), math.radians(-170.0))
    assert len(drive.warnings) == doubts


def test_the_troughs_clock_places_the_record() -> None:
    observed = Walked(bowl()).observe("velocity", trigger=0.02)
    drive = on_ellipse(None, math.radians(-60.0), frequency=FREQUENCY, trigger=0.02)
    comparison = compare(bowl(), replace(observed, clock=drive.clock))
    assert comparison.alignment.shift == pytest.approx(0.02, abs=1e-6)
    assert comparison.warnings == ()
