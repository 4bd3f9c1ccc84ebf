"""Records made by other solvers, compared with the exact motion: alignment, figures, misfits and warnings."""

from __future__ import annotations

import math
import re
import runpy
from dataclasses import replace

import numpy as np
import pytest
from helpers.cases import each
from helpers.made_records import (
    EXAMPLES,
    FREQUENCY,
    ON_ELLIPSES,
    PERIOD,
    STUDY,
    STUDY_FILE,
    Walked,
    bowl,
    nut,
)

import vibro
from vibro.errors import InputError
from vibro.records.alignment import Estimate, Observation
from vibro.records.comparison import Comparison, Row, compare
from vibro.records.fitting import fit
from vibro.records.reading import Record, read_record

MASS = STUDY["MASS"]


def study(mass: float | None = MASS) -> Observation:
    """Read the motion study with smoothed friction and noise, as a user does."""
    return Observation.of(read_record(STUDY_FILE), FREQUENCY, mass=mass)


def rows(comparison: Comparison) -> dict[str, Row]:
    return {row.key: row for row in comparison.rows}


# --- the study itself -----------------------------------------------------------------------------


def test_the_committed_study_is_what_its_script_makes() -> None:
    made = STUDY["table"]()
    lines = STUDY_FILE.read_text(encoding="utf-8").splitlines()
    assert lines[0] == ",".join(made)
    committed = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]]).T
    for values, column in zip(made.values(), committed, strict=True):
        np.testing.assert_allclose(column, values, atol=2e-4 * np.ptp(values))
    assert STUDY_FILE.stat().st_size < 300_000


def test_how_far_smoothing_alone_moves_speed_and_advance() -> None:
    """The figures of guide/compare.md, without noise: the fourth cycle of the study against the exact one."""
    times = 3.0 * PERIOD + np.linspace(0.0, PERIOD, 2001)
    displacement, velocity = STUDY["simulate"](times)
    exact = vibro.solve(nut())
    assert velocity.max() == pytest.approx(55.6825e-3, rel=1e-4)
    assert displacement[-1] - displacement[0] == pytest.approx(0.955436e-3, rel=1e-4)
    assert velocity.max() / exact.peak_velocity - 1.0 == pytest.approx(-0.0743, abs=5e-4)
    assert (displacement[-1] - displacement[0]) / exact.displacement_per_cycle - 1.0 == pytest.approx(
        -0.1188, abs=5e-4
    )


# --- alignment -------------------------------------------------------------------------------------


@pytest.mark.parametrize("cycles", [2.25, 3.5, 7.9])
def test_the_zero_of_an_acceleration_is_that_of_its_whole_cycles(cycles: float) -> None:
    """Of a part of a cycle the mean is none: it would shift the others."""
    time = np.arange(round(cycles * 40) + 1) / 600.0
    wave = 5.0 * np.sin(2.0 * math.pi * FREQUENCY * time)
    record = Record(time, {"acceleration": wave + 9.81}, {}, {})
    np.testing.assert_allclose(Observation.of(record, FREQUENCY).signals["acceleration"], wave, atol=1e-9)


def test_a_body_at_rest_has_no_place_in_the_cycle() -> None:
    observation = Walked(nut(0.5)).observe("displacement", "velocity")
    comparison = compare(nut(0.5), observation)
    assert math.isnan(comparison.alignment.shift)
    assert len(comparison.warnings) == 1
    assert "cannot be found" in comparison.warnings[0]
    assert abs(rows(comparison)["stroke_advance"].measured.value) < 1e-7
    assert rows(comparison)["stroke_advance"].computed == 0.0


@pytest.mark.parametrize(
    ("label", "signals"),
    [
        ("F_", ("displacement",)),
        ("B_", ("velocity",)),
        ("F_B_", ("acceleration", "friction")),
        ("FB_", ("displacement",)),
        ("F_B", ("velocity",)),
        ("FB", ("acceleration", "friction")),
    ],
)
def test_a_record_is_aligned_and_compared(label: str, signals: tuple[str, ...]) -> None:
    walked = Walked(ON_ELLIPSES[label])
    comparison = compare(ON_ELLIPSES[label], walked.observe(*signals, cycles=8))
    assert comparison.passing == "forwards"
    assert comparison.motion.pattern == label
    assert abs(comparison.alignment.shift - 0.0137) < 4.0 * comparison.alignment.error < 0.05 * PERIOD
    assert comparison.warnings == ()
    for row in comparison.rows:
        if row.key in ("stroke_advance", "mean_speed"):
            assert abs(row.measured.value - row.computed) < 4.0 * row.measured.error


def test_scenes_that_cannot_be_compared_are_refused() -> None:
    observed = Walked(bowl()).observe("velocity", cycles=3)
    for x, y in ((0.0, 0.0), (1e-21, 1e-22)):
        with pytest.raises(InputError, match="along_amplitude = "):
            compare(bowl(along_amplitude=x, normal_amplitude=y), observed)
    assert compare(bowl(along_amplitude=0.0, trough_angle=-0.28), observed).passing == ""
    shared = {"frequency": FREQUENCY, "static_friction": 0.4, "kinetic_friction": 0.3}
    waves = vibro.Scene(along_harmonics=[(1e-21, 0.0), (0.3e-21, 1.0)], **shared)
    for run in (compare, lambda scene, seen: fit(scene, seen, ["static_friction"])):
        with pytest.raises(InputError, match=r"along_amplitude = 1e-21 m"):
            run(waves, observed)


# --- figures ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("amplitude", [1.0, 1.2, 2.0])
def test_measured_figures_of_exact_data_are_the_computed_ones(amplitude: float) -> None:
    comparison = compare(nut(amplitude), Walked(nut(amplitude)).observe("displacement", "velocity"))
    found = rows(comparison)
    for key in ("stroke_advance", "mean_speed", "drift"):
        assert abs(found[key].measured.value - found[key].computed) < 4.0 * found[key].measured.error
    # 18 harmonics, from 600 samples per second, round the corners of the speed.
    assert found["peak_speed"].measured.value == pytest.approx(found["peak_speed"].computed, rel=0.01)
    slips = [row for key, row in found.items() if "_slip_" in key]
    assert len(slips) == 2 * len(comparison.motion.slides)
    for row in slips:
        assert abs(row.measured.value - row.computed) < 0.3e-3, row.key
    assert found["rms_velocity"].measured.value == pytest.approx(4e-4, rel=0.1)
    assert found["rms_displacement"].measured.value == pytest.approx(2e-6, rel=0.2)
    assert comparison.warnings == ()


def test_errors_of_starts_and_ends_are_those_of_repeated_noise() -> None:
    """A noisy speed passes the level early or late by its error over its slope."""
    walked = Walked(nut())
    comparisons = [compare(nut(), walked.observe("velocity", cycles=4, seed=seed)) for seed in range(10)]
    for key in ("forward_slip_start", "forward_slip_end"):
        found = [rows(comparison)[key].measured for comparison in comparisons]
        scatter = float(np.std([estimate.value for estimate in found], ddof=1))
        told = float(np.median([estimate.error for estimate in found]))
        assert 0.5 * scatter < told < 2.0 * scatter, key


@each("label", ["F_", "B_", "F_B_", "FB"])
def test_starts_and_ends_are_where_the_speed_passes_a_tenth_of_its_peak(label: str) -> None:
    """Of each slide; and the peak speed is that of the faster one, whichever way it goes."""
    walked = Walked(ON_ELLIPSES[label])
    found = rows(compare(ON_ELLIPSES[label], walked.observe("velocity", cycles=20)))
    speed = walked.velocity(np.linspace(0.0, PERIOD, 20_001))
    peak = found["peak_speed"]
    assert peak.computed == pytest.approx(float(np.abs(speed).max()), rel=1e-5)
    assert peak.measured.value == pytest.approx(peak.computed, rel=0.06)
    for way, name, fastest in ((1, "forward", speed.max()), (-1, "back", -speed.min())):
        assert (f"{name}_slip_start" in found) == (fastest > 0.0)
        for key in ("start", "end") if fastest > 0.0 else ():
            row = found[f"{name}_slip_{key}"]
            at = way * walked.velocity(np.array([row.computed - 2e-5, row.computed, row.computed + 2e-5]))
            assert at[1] == pytest.approx(0.1 * fastest, rel=0.02)
            assert (at[2] > at[0]) == (key == "start")
            assert row.measured.value == pytest.approx(row.computed, abs=0.6e-3)


def test_a_late_clock_moves_what_is_measured_and_its_error_counts() -> None:
    observed = Walked(nut()).observe("velocity", trigger=0.02, noise=0.1)
    starts = []
    for clock in (Estimate(0.02, 1e-5), Estimate(0.023, 1e-5), Estimate(0.02, 2e-3)):
        row = rows(compare(nut(), Observation(observed.time, observed.signals, FREQUENCY, clock)))
        starts.append(row["forward_slip_end"].measured)
    assert starts[1].value - starts[0].value == pytest.approx(3e-3, abs=1e-6)
    assert starts[0].error < 2e-4
    assert starts[2].error == pytest.approx(2e-3, rel=0.01)


# --- warnings --------------------------------------------------------------------------------------


def test_the_error_of_a_measured_frequency_is_one_of_the_advance() -> None:
    observation = Walked(nut()).observe("displacement")
    given, measured = (
        {row.key: row.measured for row in compare(nut(), seen).rows}
        for seen in (observation, replace(observation, frequency_error=1e-3 * FREQUENCY))
    )
    advance = measured["stroke_advance"]
    assert advance.value == given["stroke_advance"].value
    assert advance.error == pytest.approx(1e-3 * advance.value, rel=1e-3)
    assert measured["mean_speed"] == given["mean_speed"]


def test_data_that_run_the_other_way_are_noticed_and_turned() -> None:
    record = read_record(STUDY_FILE)
    reversed_ = Observation.of(record, FREQUENCY, mass=MASS, reverse=True)
    assert any("reverse" in text for text in compare(nut(), reversed_).warnings)
    for name, values in reversed_.signals.items():
        np.testing.assert_array_equal(values, -study().signals[name])


@each(
    ("signal", "factor", "told"),
    [
        ("displacement", 6.7, False),
        ("displacement", 7.3, True),
        ("velocity", 1 / 6.7, False),
        ("velocity", 1 / 7.3, True),
        ("acceleration", 7.3, True),
        ("friction", 1 / 7.3, True),
    ],
)
def test_a_signal_is_far_off_beyond_seven_times_and_below_a_seventh(
    signal: str, factor: float, told: bool
) -> None:
    """Of a displacement what it grows does not count."""
    walked = Walked(nut(1.5))
    time = np.arange(161) / 600.0
    values = factor * getattr(walked, signal)(time + 0.02)
    clock = Estimate(0.02, 1e-5)
    observed = Observation(time, {signal: values}, FREQUENCY, clock, {signal: "3V/x"})
    warnings = [text for text in compare(nut(1.5), observed).warnings if "times the computed" in text]
    assert len(warnings) == told
    for text in warnings:
        begin, _, end = text.partition(" times the computed one: ")
        assert begin.startswith(f"the {signal} is about ")
        assert float(begin.split()[-1]) == pytest.approx(factor, rel=0.07)
        assert end == "is its sensitivity 3V/x right?" + " Is the mass?" * (signal == "friction")


@each(
    ("off", "error", "said"),
    [
        # less than 2 % of a cycle, and within four errors, is no difference
        (0.018, 1e-5, False),
        (0.022, 1e-5, True),
        (-0.022, 1e-5, True),
        (0.055, 1e-3, False),
        (0.065, 1e-3, True),
        # nor is a whole cycle
        (1.01, 1e-5, False),
        (-0.99, 1e-5, False),
        (0.43, 1e-5, True),
    ],
)
def test_how_far_the_clocks_of_trough_and_body_may_be_apart(off: float, error: float, said: bool) -> None:
    clock = Estimate(0.0005 + off * PERIOD, error)
    observed = Walked(nut()).observe("velocity", trigger=0.0005, cycles=4)
    warnings = compare(nut(), Observation(observed.time, observed.signals, FREQUENCY, clock)).warnings
    assert len(warnings) == said
    if said:
        assert f"{-360.0 * off:+.0f} deg" in warnings[0]


def test_rivals_are_told_in_ms_after_the_troughs_middle() -> None:
    """They are where the data begin, wherever the clock has its zero."""
    walked, time = Walked(nut()), np.arange(801) / 600.0
    values = 0.6 * walked.velocity(time + 0.01) + 0.4 * walked.velocity(time + 0.043)
    warnings = compare(nut(), Observation(time + 5.02, {"velocity": values}, FREQUENCY)).warnings
    (said,) = (text for text in warnings if "fit almost as well" in text)
    (number,) = re.findall(r"([\d.]+) ms", said)
    assert float(number) == pytest.approx(43.0, abs=0.14)


@pytest.mark.parametrize(
    ("true", "cycles", "noise", "remedy"),
    [
        (20.013, 30.0, 0.001, "give the frequency 20.01Hz"),
        (20.0131, 400.0, 1e-4, "give the frequency 20.013Hz"),
        (20.4, 30.0, 1.0, "give the frequency 20.4Hz"),
    ],
)
def test_a_frequency_is_proposed_with_the_digits_that_the_record_tells(
    true: float, cycles: float, noise: float, remedy: str
) -> None:
    """It drifts by less than a hundredth of a cycle over the record, or by its error."""
    time = np.arange(round(40.0 * cycles) + 1) / (40.0 * true)
    values = 0.05 * np.sin(2.0 * math.pi * true * time)
    values += 0.05 * noise * np.random.default_rng(1).standard_normal(time.size)
    warnings = compare(nut(), Observation(time, {"velocity": values}, FREQUENCY)).warnings
    (said,) = (text for text in warnings if "the data repeat at" in text)
    proposed = float(re.findall(r"([0-9.]+)Hz$", said)[0])
    assert abs(proposed - true) * time[-1] < max(0.01, 0.2 * noise)
    assert said.endswith(remedy)


# --- over the ground -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scene", "signals"),
    [
        (ON_ELLIPSES["FB"], ("displacement", "velocity")),
        (nut(1.3, trough_angle=math.radians(4.0)), ("acceleration",)),
    ],
)
def test_a_track_over_the_ground_gives_the_figures_of_a_relative_one(
    scene: vibro.Scene, signals: tuple[str, ...]
) -> None:
    """Of another solver's body; it holds the trough's motion too."""
    walked = Walked(scene)
    seen = replace(walked.observe(*signals, cycles=4, over_ground=True), absolute=True)
    absolute, relative = compare(scene, seen), compare(scene, walked.observe(*signals, cycles=4))
    off = math.remainder(absolute.alignment.shift - 0.0137, PERIOD)
    assert abs(off) < 4.0 * absolute.alignment.error < 0.05 * PERIOD
    assert absolute.warnings == ()
    found, other = rows(absolute), rows(relative)
    assert found.keys() == other.keys()
    for key, row in other.items():
        if row.measured.error > 0.0:
            error = math.hypot(row.measured.error, found[key].measured.error)
            assert abs(found[key].measured.value - row.measured.value) < 4.0 * error, key
    for name in signals:
        assert found[f"rms_{name}"].measured.value < 2.0 * other[f"rms_{name}"].measured.value


def test_the_committed_video_is_what_its_script_makes() -> None:
    data = EXAMPLES / "data"
    made = runpy.run_path(str(data / "make_nut_video_240fps.py"))["table"]()
    file = data / "nut_video_240fps.csv"
    assert file.read_text(encoding="utf-8").splitlines()[0].split(",") == list(made)
    rows = np.loadtxt(file, delimiter=",", skiprows=1)
    np.testing.assert_allclose(rows, np.transpose(list(made.values())), atol=6e-4)


@each("size", [0.0, 1e-323, 1e-200, 1.0])
@each("kind", ["still", "ramp", "spike"])
def test_records_without_a_wave_are_compared_too(size: float, kind: str) -> None:
    """Of a sensor that hangs, drifts or is touched once."""
    time = np.arange(33) / 240.0
    values = size * {"still": 0.0 * time, "ramp": time, "spike": 1.0 * (time == time[16])}[kind]
    comparison = compare(nut(), Observation(time, {"acceleration": values}, FREQUENCY))
    assert np.isfinite(rows(comparison)["rms_acceleration"].measured.value)
    assert not any("not steady" in text for text in comparison.warnings)
