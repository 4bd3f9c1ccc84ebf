"""The regression on a trend and harmonics: coefficients, standard errors and degrees of freedom by hand.

Most records here have 16 samples in each of 4 or 40 whole cycles of 1 s, so that harmonics are orthogonal; 7
of them are resolved. Samples of alternating sign are at half the rate, orthogonal to all of these.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.cases import each
from helpers.made_records import FREQUENCY

from vibro.errors import InputError
from vibro.records.alignment import fold, harmonics, independent_samples, independent_share

if TYPE_CHECKING:
    from vibro.reals import Floats


def clock(cycles: int = 4) -> Floats:
    return np.arange(16 * cycles) / 16.0


def alternating(size: int) -> Floats:
    return np.asarray((-1.0) ** np.arange(size))


@pytest.mark.parametrize("start", [0.0, 7.3, -2000.0])
def test_a_trend_is_one_about_the_middle_of_the_record(start: float) -> None:
    """2 + 3 s + 5 s^2, s from the middle, beside a third harmonic; and all its derivatives."""
    time = start + np.arange(200) / 40.0
    since = time - (start + 0.5 * 199 / 40.0)
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


def test_a_trend_and_its_error_are_in_the_signals_unit_per_second() -> None:
    """The slope of N evenly spaced samples has the variance 12 s^2 / (N T^2), with noise of variance s^2."""
    time = clock(40)
    slope = fold(time, 3.0 * time + alternating(640), 1.0, 2).trend(1)
    assert slope.value == pytest.approx(3.0, abs=1e-3)
    assert slope.error == pytest.approx(math.sqrt(12.0 / 640.0) / 40.0 * math.sqrt(640.0 / 624.0), rel=2e-3)


@each(("samples", "count"), [(8, 3), (12, 5), (13, 5), (30, 13), (53, 23), (54, 24), (100, 24)])
def test_harmonics_are_resolved_up_to_nine_tenths_of_half_the_rate(samples: int, count: int) -> None:
    """But no more than 24 of them."""
    time = np.arange(2 * samples + 1) / samples
    folded = fold(time, time, 1.0, 1)
    assert folded.coefficients.size == 1 + 2 * count
    assert harmonics(time, 1.0, count).shape == (time.size, 2 * count)


@each(("cycles", "samples", "found"), [
    (1.99, 40.0, "1.99 cycles"), (1.999, 1000.0, "1.99 cycles"), (1.96, 40.0, "1.96 cycles"),
    (500.0, 7.998, "7.99 samples"), (4.0, 7.75, "7.75 samples"),
])  # fmt: skip
def test_two_cycles_of_eight_samples_are_enough(cycles: float, samples: float, found: str) -> None:
    """Numbers that are too small are never rounded up."""
    enough = np.linspace(3.0, 5.0, 17)
    assert fold(enough, enough, 1.0, 1).coefficients.size == 1 + 2 * 3
    time = np.linspace(3.0, 3.0 + cycles, round(cycles * samples) + 1)
    with pytest.raises(InputError, match=found):
        fold(time, time, 1.0, 1)


def test_two_cycles_may_be_short_by_the_rounding_of_the_clock() -> None:
    time = np.linspace(0.0, 2.0 * (1.0 - 5e-7), 41)
    assert fold(time, time, 1.0, 1).coefficients.size == 1 + 2 * 9
    with pytest.raises(InputError, match="cycles"):
        fold(time * (1.0 - 1e-6), time, 1.0, 1)


# --- independent samples ------------------------------------------------------------------------------


@pytest.mark.parametrize(("power", "counts"), [(0.0245, False), (0.0255, True)])
def test_a_harmonic_counts_beyond_eight_times_what_noise_leaves(power: float, counts: bool) -> None:
    """Noise of variance 1 leaves a power of 2/640 in each: eight times that are 0.025."""
    time = clock(40)
    values = alternating(640) + math.sqrt(2.0 * power) * np.sin(4.0 * math.pi * time)
    expected = (1.0 + power) / (1.0 / 640.0 + 0.5 * power) if counts else 640.0
    assert independent_samples(time, values, 1.0) == pytest.approx(expected, rel=1e-6)


# --- at 600 1/s ---------------------------------------------------------------------------------------


def test_a_trend_and_harmonics_are_found_exactly_also_with_gaps() -> None:
    time = np.delete(np.arange(400) / 600.0, slice(100, 130))
    signal = (
        3.0
        - 2.0 * time
        + np.sin(2 * math.pi * FREQUENCY * time)
        + 0.5 * np.cos(6 * math.pi * FREQUENCY * time)
    )
    folded = fold(time, signal, FREQUENCY, 2)
    assert folded.trend(1).value == pytest.approx(-2.0, rel=1e-11)
    at = np.array([0.013, 0.4])
    slope = 2 * math.pi * FREQUENCY * np.cos(2 * math.pi * FREQUENCY * at)
    slope -= 3 * math.pi * FREQUENCY * np.sin(6 * math.pi * FREQUENCY * at)
    np.testing.assert_allclose(folded.derivative().periodic(at), slope, rtol=1e-10)


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


def test_the_share_of_independent_samples_of_an_autoregressive_process() -> None:
    """(1 - r) / (1 + r) of the samples, where neighbours are correlated by r; never more than all of them."""
    white = np.random.default_rng(2).standard_normal(20_000)
    for r, share in ((0.8, 1.0 / 9.0), (0.5, 1.0 / 3.0), (0.0, 1.0), (-0.5, 1.0)):
        lasting = np.convolve(white, r ** np.arange(60), "valid")
        assert independent_share(lasting) == pytest.approx(share, rel=0.06)
    assert independent_share(np.ones(50)) == 2.0 / 50


def test_independent_samples() -> None:
    random = np.random.default_rng(4)
    time = np.arange(801) / 600.0
    white = random.standard_normal(time.size)
    assert independent_samples(time, white, FREQUENCY) == pytest.approx(801, rel=0.15)
    slow = np.convolve(white, np.ones(10) / 10, "same")
    assert independent_samples(time, slow, FREQUENCY) < 200
    # A misfit that repeats counts the same however long the record is.
    long = np.arange(8001) / 600.0
    for t in (time, long):
        wave = np.sin(2 * math.pi * FREQUENCY * t)
        assert independent_samples(t, wave, FREQUENCY) == pytest.approx(2.0, rel=0.01)
    assert independent_samples(time, np.zeros_like(time), FREQUENCY) == 801


@each(("cycles", "digits"), [(10, 15), (10, 6), (20, 6)])
@each("frequency", [13.0, 15.0, 17.3, 33.3])
def test_rounded_times_resolve_as_many_harmonics_as_exact_ones(
    frequency: float, cycles: int, digits: int
) -> None:
    """At 40 samples a cycle 18, and 8 are enough: the last digit of a time decides nothing."""
    for samples, count in ((40, 18), (8, 3)):
        time = np.round(np.arange(cycles * samples + 1) / (samples * frequency), digits)
        assert fold(time, time, frequency, 1).coefficients.size == 1 + 2 * count
