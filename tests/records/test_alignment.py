"""The position of a record in the cycle, and the regression on a trend and harmonics, with their errors."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.cases import each
from helpers.made_records import FREQUENCY, NOISE, PERIOD, Walked, bowl, nut

from vibro.errors import InputError
from vibro.motion.settled import settled_motion
from vibro.records.alignment import Observation, align, computed_signals, fold, independent_samples

if TYPE_CHECKING:
    import vibro

SIGNALS = ("displacement", "velocity", "acceleration", "friction")
TIME = np.arange(401) / 600.0


@pytest.mark.parametrize("scene", [nut(1.5), nut(1.2, trough_angle=0.05), bowl()])
def test_signals_that_jump_are_averaged_over_the_window(scene: vibro.Scene) -> None:
    """What the speed gains over it; of friction the trough's acceleration is taken at its middle."""
    walked, window = Walked(scene), 1.0 / 600.0
    found = computed_signals(settled_motion(scene), SIGNALS, TIME, window)
    np.testing.assert_allclose(found["velocity"], walked.velocity(TIME), atol=1e-10)
    gained = walked.velocity(TIME + 0.5 * window) - walked.velocity(TIME - 0.5 * window)
    np.testing.assert_allclose(found["acceleration"], gained / window, atol=1e-7)
    exact = walked.friction(TIME) - walked.acceleration(TIME)
    np.testing.assert_allclose(found["friction"] - found["acceleration"], exact, atol=1e-7)


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


@each("signals", [("displacement",), ("velocity",), ("displacement", "velocity")])
def test_the_error_is_that_of_noise_over_the_slope(signals: tuple[str, ...]) -> None:
    """The root of the sum of squared slopes, of all signals; of a displacement those beside its growth."""
    walked, motion, noise = Walked(nut()), settled_motion(nut()), 10.0
    slopes = {"displacement": walked.velocity(TIME + 0.02), "velocity": walked.acceleration(TIME + 0.02)}
    slopes["displacement"] -= slopes["displacement"].mean()
    known = sum(float(slopes[name] @ slopes[name]) / (noise * NOISE[name]) ** 2 for name in signals)
    told = [
        align(walked.observe(*signals, trigger=0.02, noise=noise, seed=seed), motion).error
        for seed in range(4)
    ]
    assert np.median(told) == pytest.approx(known**-0.5, rel=0.15)


@pytest.mark.parametrize("signal", ["acceleration", "friction"])
def test_jumps_alone_are_placed_no_better_than_a_sample(signal: str) -> None:
    """A jump lies anywhere between two samples: its standard error is that of an even distribution."""
    observation = Walked(nut()).observe(signal, noise=0.01, trigger=0.02)
    anywhere = np.linspace(0.0, observation.sample_time, 10_001)
    alignment = align(observation, settled_motion(nut()))
    assert alignment.error == pytest.approx(float(np.std(anywhere)), rel=0.01)


def test_where_all_positions_fit_alike_there_is_none() -> None:
    """Noise a hundred thousand times as large as the motion; but not noise of ten times."""
    walked, motion = Walked(nut()), settled_motion(nut())
    level = 100.0 * 60e-3 / NOISE["velocity"]
    hopeless = align(walked.observe("velocity", noise=1e3 * level), motion)
    assert np.isnan([hopeless.shift, hopeless.error]).all()
    assert hopeless.rivals == ()
    assert not math.isnan(align(walked.observe("velocity", noise=0.03 * level), motion).shift)


def test_a_position_that_nothing_tells_may_lie_half_a_period_off() -> None:
    """A large wave that the model has not repeats in every cycle, so that no other record could tell more."""
    walked = Walked(nut())
    other = 3.0 * np.sin(6.0 * math.pi * FREQUENCY * TIME)
    observed = Observation(TIME, {"velocity": walked.velocity(TIME + 0.02) + other}, FREQUENCY)
    assert align(observed, settled_motion(nut())).error == pytest.approx(0.5 * PERIOD)


# --- the regression on a trend and harmonics ------------------------------------------------------------


def test_a_trend_is_one_about_the_middle_of_the_record() -> None:
    """2 + 3 s + 5 s^2, s from the middle, beside a third harmonic, with a gap; and all its derivatives."""
    time = np.delete(7.3 + np.arange(200) / 40.0, slice(60, 75))
    since = time - (7.3 + 0.5 * 199 / 40.0)
    rate = 6.0 * math.pi
    waves = [np.sin(rate * time), np.cos(rate * time), -np.sin(rate * time)]
    folded = fold(time, 2.0 + 3.0 * since + 5.0 * since**2 + 0.1 * np.sin(rate * time), 1.0, 3)
    assert [folded.trend(power).value for power in range(3)] == pytest.approx([2.0, 3.0, 5.0], rel=1e-8)
    trends = [2.0 + 3.0 * since + 5.0 * since**2, 3.0 + 10.0 * since, 10.0 + 0.0 * since]
    for order, trend in enumerate(trends):
        periodic = 0.1 * rate**order * waves[order]
        np.testing.assert_allclose(folded.periodic(time), periodic, atol=1e-6 * rate**order)
        np.testing.assert_allclose(folded.fitted(time), trend + periodic, atol=1e-6 * rate**order)
        folded = folded.derivative()


@each(("cycles", "samples", "found"), [
    (1.99, 40.0, "1.99 cycles"), (1.999, 1000.0, "1.99 cycles"), (2.0, 8.0, ""), (2.0 - 1e-6, 20.0, ""),
    (500.0, 7.998, "7.99 samples"), (4.0, 7.75, "7.75 samples"),
])  # fmt: skip
def test_two_cycles_of_eight_samples_are_enough(cycles: float, samples: float, found: str) -> None:
    """Numbers that are too small are never rounded up; the clock's own rounding does not count."""
    time = np.linspace(3.0, 3.0 + cycles, round(cycles * samples) + 1)
    if found:
        with pytest.raises(InputError, match=found):
            fold(time, time, 1.0, 1)
    else:  # harmonics up to nine tenths of half the rate
        assert fold(time, time, 1.0, 1).coefficients.size == 1 + 2 * int(0.45 * samples)


@pytest.mark.parametrize(("count", "rate"), [(161, 600.0), (25, 180.0)])
def test_standard_errors_are_those_of_repeated_noise(count: int, rate: float) -> None:
    """Also of short records, of which trend and harmonics take half the degrees of freedom."""
    random = np.random.default_rng(3)
    time = np.arange(count) / rate
    trends, harmonics = [], []
    for _ in range(200):
        folded = fold(time, time + 0.1 * random.standard_normal(time.size), FREQUENCY, 2)
        trends.append((folded.trend(1).value, folded.trend(1).error))
        at = np.array([0.02])
        harmonics.append((float(folded.fitted(at)[0]), float(folded.error(at)[0])))
    for values in (np.array(trends), np.array(harmonics)):
        assert np.std(values[:, 0]) == pytest.approx(np.median(values[:, 1]), rel=0.2)


def test_a_misfit_that_repeats_counts_as_two_samples() -> None:
    """However long the record is; white noise counts as all of them."""
    for count in (801, 8001):
        time = np.arange(count) / 600.0
        wave = np.sin(2 * math.pi * FREQUENCY * time)
        white = np.random.default_rng(4).standard_normal(count)
        assert independent_samples(time, wave, FREQUENCY) == pytest.approx(2.0, rel=0.01)
        assert independent_samples(time, white, FREQUENCY) == pytest.approx(count, rel=0.15)
