"""Records made by other solvers, compared with the exact motion: alignment, figures, misfits and warnings."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.cases import each
from helpers.made_records import FREQUENCY, ON_ELLIPSES, PERIOD, STUDY, STUDY_FILE, Walked, bowl, nut

import vibro
from vibro.errors import InputError
from vibro.motion.settled import settled_motion
from vibro.records.alignment import Estimate, Observation, align
from vibro.records.comparison import Comparison, Row, compare
from vibro.records.fitting import fit
from vibro.records.reading import Record, read_record

MASS = STUDY["MASS"]


def study(mass: float | None = MASS) -> Observation:
    """Read the motion study with smoothed friction and noise, as a user does."""
    return Observation.of(read_record(STUDY_FILE), FREQUENCY, mass=mass)


def only(observation: Observation, *names: str) -> Observation:
    return Observation(
        observation.time, {name: observation.signals[name] for name in names}, observation.frequency
    )


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


# --- the settled motion that records are compared with ---------------------------------------------


@pytest.mark.parametrize("amplitude", [0.5, 1.0, 1.2, 1.5, 2.0])
def test_the_settled_motion_is_that_of_another_solver(amplitude: float) -> None:
    motion, other = settled_motion(nut(amplitude)), Walked(nut(amplitude))
    assert motion.pattern == other.pattern
    assert motion.advance == pytest.approx(other.advance, rel=1e-12, abs=1e-15)
    time = np.linspace(-0.05, 0.3, 5001)
    sample = motion.sample(time)
    np.testing.assert_allclose(sample.velocity, other.velocity(time), atol=1e-12)
    np.testing.assert_allclose(sample.position - sample.position[0], other.displacement(time), atol=1e-9)


def test_a_settled_flight_repeats_itself_over_trough_time() -> None:
    """At K = 1.24 the nut hops once per cycle; each cycle of the model starts with the flight."""
    motion, cycle = settled_motion(nut(4.0)), vibro.solve(nut(4.0))
    assert motion.pattern == "HFB"
    assert [phase.kind for phase in motion.phases] == list("HFB")
    assert motion.advance == cycle.displacement_per_cycle
    time = np.linspace(0.0, PERIOD, 201)
    first, later = motion.sample(time), motion.sample(time + 3 * PERIOD)
    np.testing.assert_allclose(later.position - first.position, 3 * motion.advance, rtol=1e-9)
    np.testing.assert_allclose(later.gap, first.gap, atol=1e-12)
    flight = motion.phases[0]
    flies = (time > flight.start) & (time < flight.end)
    assert (first.gap[flies] > 0.0).all()
    assert (first.gap[~flies] == 0.0).all()


def test_flights_can_be_compared_too() -> None:
    """With data of the model itself, which only shows that signals, alignment and figures agree."""
    motion = settled_motion(nut(4.0))
    time = np.arange(401) / 600.0
    sample = motion.sample(time + 0.02)
    observation = Observation(time, {"displacement": sample.position, "velocity": sample.velocity}, FREQUENCY)
    comparison = compare(nut(4.0), observation)
    assert comparison.alignment.shift == pytest.approx(0.02, abs=1e-6)
    assert rows(comparison)["stroke_advance"].measured.value == pytest.approx(motion.advance, rel=1e-3)
    assert not any("_slip_" in key for key in rows(comparison))


# --- alignment -------------------------------------------------------------------------------------

SIGNALS = ("displacement", "velocity", "acceleration", "friction")


@pytest.mark.parametrize(
    ("amplitude", "signals"),
    [*((1.0, (name,)) for name in SIGNALS), (1.5, SIGNALS), (2.0, ("displacement",))],
)
def test_the_trigger_time_of_exact_data_is_found(amplitude: float, signals: tuple[str, ...]) -> None:
    observation = Walked(nut(amplitude)).observe(*signals, trigger=0.0501)
    alignment = align(observation, settled_motion(nut(amplitude)))
    assert abs(alignment.shift - 0.0501) < 4.0 * alignment.error
    assert alignment.error < 5e-4
    assert alignment.rivals == ()


@pytest.mark.parametrize("trigger", [0.0, 0.5 / 600.0, PERIOD - 1e-4])
def test_the_trigger_time_wraps_round(trigger: float) -> None:
    observation = Walked(nut()).observe("velocity", trigger=trigger)
    shift = align(observation, settled_motion(nut())).shift
    assert 0.0 <= shift < PERIOD
    assert abs(math.remainder(shift - trigger, PERIOD)) < 1e-4


@pytest.mark.parametrize("signal", ["acceleration", "friction"])
def test_jumps_alone_are_placed_no_better_than_a_sample(signal: str) -> None:
    """A jump lies anywhere between two samples: its standard error is that of an even distribution."""
    observation = Walked(nut()).observe(signal, noise=0.01, trigger=0.02)
    anywhere = np.linspace(0.0, observation.sample_time, 10_001)
    alignment = align(observation, settled_motion(nut()))
    assert alignment.error == pytest.approx(float(np.std(anywhere)), rel=0.01)


def test_other_positions_that_fit_as_well_are_rivals() -> None:
    """Data of another frequency fit badly everywhere."""
    observed = Walked(ON_ELLIPSES["F_B"]).observe("friction")
    scene = bowl(60.0, along_amplitude=8e-4, normal_amplitude=1e-3, frequency=1.3 * FREQUENCY)
    other = Observation(observed.time, observed.signals, 1.3 * FREQUENCY)
    alignment = align(other, settled_motion(scene))
    assert len(alignment.rivals) > 2
    for rival in alignment.rivals:
        away = math.remainder(rival - alignment.shift, other.period)
        assert abs(away) > 0.05 * other.period
    said = [text for text in compare(scene, other).warnings if "fit almost as well" in text]
    assert len(said) == len(alignment.rivals)


@pytest.mark.parametrize("cycles", [2.25, 3.5, 7.9])
def test_the_zero_of_an_acceleration_is_that_of_its_whole_cycles(cycles: float) -> None:
    """Of a part of a cycle the mean is none: it would shift the others."""
    time = np.arange(round(cycles * 40) + 1) / 600.0
    wave = 5.0 * np.sin(2.0 * math.pi * FREQUENCY * time)
    record = Record(time, {"acceleration": wave + 9.81}, {}, {})
    np.testing.assert_allclose(Observation.of(record, FREQUENCY).signals["acceleration"], wave, atol=1e-9)


def test_searches_use_the_middle_of_a_long_record() -> None:
    observation = Walked(nut()).observe("velocity", cycles=250, trigger=0.02)
    part = observation.middle
    assert part.time.size == 6000
    np.testing.assert_array_equal(part.time, observation.time[2000:8000])
    np.testing.assert_array_equal(part.signals["velocity"], observation.signals["velocity"][2000:8000])
    assert align(observation, settled_motion(nut())).shift == pytest.approx(0.02, abs=5e-5)
    short = Walked(nut()).observe("velocity")
    assert short.middle is short
    # A fast sensor: the part covers at least four cycles.
    time = np.arange(100_000) / 50_000.0
    quick = Observation(time, {"velocity": Walked(nut()).velocity(time)}, FREQUENCY)
    assert float(np.ptp(quick.middle.time)) == pytest.approx(4 * PERIOD, rel=1e-3)


def test_a_body_at_rest_has_no_place_in_the_cycle() -> None:
    observation = Walked(nut(0.5)).observe("displacement", "velocity")
    comparison = compare(nut(0.5), observation)
    assert math.isnan(comparison.alignment.shift)
    assert len(comparison.warnings) == 1
    assert "cannot be found" in comparison.warnings[0]
    assert abs(rows(comparison)["stroke_advance"].measured.value) < 1e-7
    assert rows(comparison)["stroke_advance"].computed == 0.0


def test_friction_tells_the_place_of_a_body_at_rest() -> None:
    observation = Walked(nut(0.5)).observe("friction", trigger=0.02)
    assert align(observation, settled_motion(nut(0.5))).shift == pytest.approx(0.02, abs=1e-4)


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


def test_speeds_come_from_a_displacement_alone() -> None:
    both = rows(compare(nut(), study()))
    alone = rows(compare(nut(), only(study(), "displacement")))
    assert alone["peak_speed"].measured.value == pytest.approx(both["peak_speed"].measured.value, rel=0.01)
    assert alone["forward_slip_end"].measured.value == pytest.approx(
        both["forward_slip_end"].measured.value, abs=0.5e-3
    )


def test_a_velocity_alone_tells_advance_and_drift() -> None:
    found = rows(compare(nut(), only(study(), "velocity")))
    assert found["stroke_advance"].measured.value == pytest.approx(0.955436e-3, rel=5e-3)
    assert abs(found["drift"].measured.value) < 3.0 * found["drift"].measured.error


def test_a_drifting_sensor_is_noticed() -> None:
    observation = Walked(nut()).observe("displacement", "velocity")
    middle = observation.time - observation.time.mean()
    drifting = dict(observation.signals)
    drifting["displacement"] = drifting["displacement"] + 0.5 * 1e-3 * middle**2
    found = rows(compare(nut(), Observation(observation.time, drifting, FREQUENCY)))
    span = float(np.ptp(observation.time))
    assert found["drift"].measured.value == pytest.approx(1e-3 * span, rel=0.02)


def test_a_drift_of_a_velocity_is_told_as_it_is() -> None:
    observation = Walked(nut()).observe("velocity")
    drifting = {"velocity": observation.signals["velocity"] + 0.03 * observation.time}
    found = rows(compare(nut(), Observation(observation.time, drifting, FREQUENCY)))
    assert found["drift"].measured.value == pytest.approx(0.03 * np.ptp(observation.time), rel=0.02)


def test_a_slide_that_the_data_do_not_show_is_not_seen() -> None:
    resting = Walked(nut(0.5)).observe("velocity")
    found = rows(compare(nut(), resting))
    assert math.isnan(found["forward_slip_start"].measured.value)


def test_signals_and_curves_are_on_one_clock() -> None:
    comparison = compare(nut(), study())
    for name, values in comparison.observation.signals.items():
        assert np.corrcoef(values, comparison.computed[name])[0, 1] > 0.95
        assert comparison.curves[name].shape == comparison.curve_time.shape
    assert comparison.curve_time[-1] == PERIOD
    assert comparison.curves["displacement"][-1] == pytest.approx(comparison.motion.advance)
    measured = comparison.observation.signals["displacement"]
    assert comparison.computed["displacement"].mean() == pytest.approx(measured.mean())


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


def test_of_a_record_of_both_the_advance_is_the_displacements_and_the_peak_the_velocitys() -> None:
    observed = Walked(nut()).observe("displacement", "velocity")
    signals = {**observed.signals, "velocity": 2.0 * observed.signals["velocity"]}
    plain = rows(compare(nut(), observed))
    other = rows(compare(nut(), Observation(observed.time, signals, FREQUENCY)))
    for key, factor in (("stroke_advance", 1.0), ("mean_speed", 1.0), ("peak_speed", 2.0)):
        assert other[key].measured.value == pytest.approx(factor * plain[key].measured.value)
    advance, speed = plain["stroke_advance"], plain["mean_speed"]
    assert advance.measured == pytest.approx(tuple(PERIOD * x for x in speed.measured))
    assert advance.computed == pytest.approx(PERIOD * speed.computed)


def test_offsets_count_in_misfits_but_not_that_of_a_displacement() -> None:
    walked = Walked(nut())
    observed = walked.observe("displacement", "velocity", noise=0.0, trigger=0.02)
    time = observed.time - observed.time.mean()
    off = {"displacement": 3.0 + 2e-3 * time, "velocity": 0.01 + 0.0 * time}
    signals = {name: values + off[name] for name, values in observed.signals.items()}
    found = rows(compare(nut(), Observation(observed.time, signals, FREQUENCY, Estimate(0.02, 1e-6))))
    expected = {"displacement": 2e-3 * float(np.std(time)), "velocity": 0.01}
    for name, size in expected.items():
        assert found[f"rms_{name}"].measured.value == pytest.approx(size, rel=1e-4)
    assert found["rms_displacement_without_trend"].measured.value < 1e-3 * expected["displacement"]
    assert "rms_velocity_without_trend" not in found


def test_a_body_at_rest_has_no_speed_at_rest() -> None:
    found = rows(compare(nut(0.5), Walked(nut(0.5)).observe("velocity")))
    assert "rest_speed" not in found
    assert found["peak_speed"].computed == 0.0


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


@pytest.mark.parametrize(("off", "noticed"), [(-0.1, True), (0.02, False), (0.1, True)])
def test_a_frequency_is_wrong_when_drive_and_data_part_within_the_record(off: float, noticed: bool) -> None:
    """Over 20 cycles, 0.1 Hz are an eighth of a cycle, and 0.02 Hz a fortieth."""
    observation = Walked(nut()).observe("velocity")
    other = Observation(observation.time, observation.signals, FREQUENCY + off)
    warnings = compare(nut(frequency=FREQUENCY + off), other).warnings
    assert any("the data repeat at" in text for text in warnings) == noticed


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


def test_friction_on_the_trough_instead_of_the_body_is_noticed() -> None:
    signals = dict(study().signals)
    signals["friction"] = -signals["friction"]
    warnings = compare(nut(), Observation(study().time, signals, FREQUENCY)).warnings
    assert any("opposite sign" in text for text in warnings)


def test_a_force_needs_a_mass() -> None:
    record = read_record(STUDY_FILE, {"friction": "F [N]"})
    with pytest.raises(InputError, match="mass"):
        Observation.of(record, FREQUENCY)
    np.testing.assert_allclose(
        Observation.of(record, FREQUENCY, mass=0.5).signals["friction"], 2.0 * record.signals["friction"]
    )


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


def test_a_small_motion_in_noise_is_not_too_small() -> None:
    """A twentieth of the computed one, but with noise the whole signal is as large as a motion may be."""
    observed = Walked(nut()).observe("velocity", noise=0.0)
    small = 0.05 * observed.signals["velocity"]
    noise = float(np.std(observed.signals["velocity"])) * np.random.default_rng(1).standard_normal(
        observed.time.size
    )
    for level, told in ((0.5, False), (0.02, True)):
        data = Observation(observed.time, {"velocity": small + level * noise}, FREQUENCY)
        warnings = compare(nut(), data).warnings
        assert any("times the computed one" in text for text in warnings) == told


def test_a_displacement_that_only_grows_is_too_small() -> None:
    observed = Walked(nut()).observe("displacement", noise=0.0)
    even = nut().frequency * settled_motion(nut()).advance * observed.time
    small = even + 0.05 * (observed.signals["displacement"] - even)
    warnings = compare(nut(), Observation(observed.time, {"displacement": small}, FREQUENCY)).warnings
    assert any("displacement is about 0.05 times" in text for text in warnings)


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


def test_a_clock_as_uncertain_as_the_bodys_own_place_is_none_apart() -> None:
    """Of a noisy body: four of both errors, as the root of the sum of their squares."""
    observed = Walked(nut()).observe("velocity", trigger=0.02, noise=300.0, cycles=40)
    own = align(observed, settled_motion(nut()))
    assert 4.0 * own.error > 0.03 * PERIOD
    for times, told in ((5.0, False), (6.5, True)):
        clock = Estimate(own.shift + times * own.error, own.error)
        warnings = compare(nut(), Observation(observed.time, observed.signals, FREQUENCY, clock)).warnings
        assert any("by its own signals" in text for text in warnings) == told


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
