"""Harmonics of a trough's motion against motions with known truth: values, errors, order, refusals."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers.feeders import QUIET, Feeder, feeder, noise
from helpers.made_records import trough_record

import vibro
from vibro.quantities import MOST_HARMONICS
from vibro.records.trough import MeasuredMotion, motion_of

FRICTION = {"static_friction": 0.4, "kinetic_friction": 0.3}


def offs(measured: MeasuredMotion, true: Feeder) -> list[float]:
    """Return the errors of all amplitudes and phases that are measured, in standard errors."""
    true = true.on_its_clock
    found = []
    for k in range(min(measured.order, true.along.size)):
        for i, (got, exact) in enumerate(((measured.along, true.along), (measured.normal, true.normal))):
            found.append((abs(got[k]) - abs(exact[k])) / measured.standard_errors[k, i])
            if k or i:
                turned = float(np.angle(got[k] / exact[k]))
                found.append(turned / measured.phase_errors[k, i])
    return found


@pytest.mark.parametrize("sensors", [1, 2])
@pytest.mark.parametrize("start", [0.0, -3.7, 500.0])
def test_exact_records_give_exact_harmonics(sensors: int, start: float) -> None:
    true = feeder(3)
    record = true.record(3, seconds=1.0, density=0.0, sensors=sensors)
    record = replace(record, time=record.time + start)
    measured = motion_of(record, drive_angle=0.0 if sensors == 1 else None)
    assert measured.order == 3
    assert measured.frequency == pytest.approx(true.frequency, rel=1e-9)
    np.testing.assert_allclose(measured.along, true.on_its_clock.along, rtol=1e-7)
    np.testing.assert_allclose(
        measured.normal, true.on_its_clock.normal if sensors == 2 else np.zeros(3), rtol=1e-7
    )
    turns = (measured.clock - start) * true.frequency + np.angle(true.along[0]) / math.tau
    assert abs(math.remainder(turns, 1.0)) < 1e-6


@pytest.mark.parametrize("kind", ["velocity", "displacement"])
def test_velocities_and_displacements_give_the_same_motion(kind: str) -> None:
    true = feeder(3)
    exact = motion_of(true.record(3, density=0.0, kind=kind))
    assert exact.order == 3
    np.testing.assert_allclose(exact.along, true.on_its_clock.along, rtol=1e-6)
    np.testing.assert_allclose(exact.normal, true.on_its_clock.normal, rtol=1e-6)
    of_accelerations = motion_of(true.record(3, density=0.0))
    assert exact.sensors[0].harmonics == pytest.approx(of_accelerations.sensors[0].harmonics, rel=1e-4)


def test_errors_are_those_of_noise_and_the_order_is_right() -> None:
    """Of 32 feeders, in turns quiet and noisy; frequencies too."""
    off: list[float] = []
    late: list[float] = []
    orders = []
    for seed in range(32):
        true = feeder(seed)
        record = (
            true.record(seed, seconds=1.0, density=10.0 * QUIET)
            if seed % 2
            else true.record(seed, seconds=1.0, rate=800.0)
        )
        measured = motion_of(record)
        off += offs(measured, true)
        late.append((measured.frequency - true.frequency) / measured.frequency_error)
        orders.append(measured.significant)
    sizes = np.abs(off)
    assert sizes.size > 330
    assert 0.60 < np.mean(sizes < 1.0) < 0.74
    assert 0.93 < np.mean(sizes < 2.0) < 0.98
    assert sizes.max() < 5.0
    assert abs(np.mean(off)) < 0.15  # no bias
    assert 0.55 < np.mean(np.abs(late) < 1.0) < 0.82
    assert orders.count(3) >= 31


def test_errors_hold_in_short_records_and_with_rows_left_out() -> None:
    """Of 12 cycles, in which eight bins give the covariance: draws follow Student's t."""
    within = []
    for seed in range(40):
        true = feeder(seed)
        record = true.record(seed, seconds=12.0 / true.frequency, rate=60.0 * true.frequency, density=QUIET)
        kept = np.random.default_rng(seed).random(record.time.size) > 0.03
        signals = {name: values[kept] for name, values in record.trough.items()}
        measured = motion_of(replace(record, time=record.time[kept], trough=signals))
        drawn = measured.drawn(400, seed)
        exact = true.on_its_clock
        for sample, one, best in (
            (drawn.along, exact.along, measured.along),
            (drawn.normal, exact.normal, measured.normal),
        ):
            for k in range(min(3, measured.order)):
                within.append(np.mean(abs(abs(sample[k]) - abs(best[k])) < abs(abs(one[k]) - abs(best[k]))))
    # The rank of the truth among draws is uniform.
    for share in (0.5, 0.68, 0.95):
        assert np.mean(np.array(within) < share) == pytest.approx(share, abs=0.05)


def test_correlated_channels_are_drawn_correlated() -> None:
    """Noise that both sensors share, as of one machine beside the other."""
    true, random = feeder(5), np.random.default_rng(5)
    record = true.record(5, density=0.0)
    shared = noise(record.time.size, 1600.0, 10.0 * QUIET, random)
    own = noise(record.time.size, 1600.0, QUIET, random)
    ways = record.trough
    both = {
        "trough_along": ways["trough_along"] + shared,
        "trough_normal": ways["trough_normal"] + shared + own,
    }
    measured = motion_of(replace(record, trough=both))
    for k in range(3):
        (a, cross), (_, b) = measured.covariance[k]
        assert (cross / np.sqrt(a * b)).real > 0.95
    drawn = measured.drawn(300)
    off = abs(drawn.along[1]) - abs(measured.along[1]), abs(drawn.normal[1]) - abs(measured.normal[1])
    assert np.std(off[0]) == pytest.approx(measured.standard_errors[1, 0], rel=0.2)
    assert np.std(off[1]) == pytest.approx(measured.standard_errors[1, 1], rel=0.2)


def test_draws_are_fields_of_scenes_and_repeat_by_their_seed() -> None:
    measured = motion_of(feeder(1).record(1))
    draws = measured.draws(50)
    scene = vibro.Scene(**draws, **FRICTION)
    assert scene.shape == (50,)
    np.testing.assert_array_equal(draws["frequency"], measured.draws(50)["frequency"])
    assert (draws["frequency"] != measured.draws(50, seed=2)["frequency"]).any()
    np.testing.assert_array_equal(draws["along_harmonics"][0][1], 0.0)  # the clock of each
    speeds = vibro.solve(scene).mean_velocity
    own = float(vibro.solve(vibro.Scene(**measured.drive(), **FRICTION)).mean_velocity)
    assert abs(speeds.mean() - own) < 0.5 * speeds.std() < 0.01 * own


def test_speeds_are_within_the_errors_of_draws() -> None:
    """By 24 feeders: the standardised error of the speed is that of a normal distribution."""
    off = []
    for seed in range(24):
        true = feeder(seed)
        measured = motion_of(true.record(seed, seconds=1.0, rate=800.0, density=10.0 * QUIET))
        speeds = vibro.solve(vibro.Scene(**measured.draws(100), **FRICTION)).mean_velocity
        own, exact = (
            float(vibro.solve(vibro.Scene(**drive, **FRICTION)).mean_velocity)
            for drive in (measured.drive(), true.drive())
        )
        assert own == pytest.approx(exact, rel=0.06)
        off.append((own - exact) / speeds.std())
    assert 0.5 < np.mean(np.abs(off) < 1.0) < 0.85
    assert np.mean(np.abs(off) < 2.0) > 0.89
    assert np.max(np.abs(off)) < 4.5


def test_harmonics_beyond_those_of_a_drive_are_counted_and_left_out() -> None:
    rates = math.tau * 25.0 * np.arange(1, 17)
    for count in (MOST_HARMONICS, min(MOST_HARMONICS + 1, 16)):
        sizes = np.where(np.arange(1, 17) <= count, 2.0, 0.0) / rates**2
        measured = motion_of(Feeder(25.0, sizes + 0j, 0.5 * sizes + 0j).record(1, seconds=1.0))
        assert measured.significant == count
        assert measured.order == min(count, MOST_HARMONICS)
        assert len(measured.warnings) == (count > MOST_HARMONICS)


# --- refusals and warnings ----------------------------------------------------------------------------


@pytest.mark.parametrize(("most", "warned"), [(0.9, True), (0.98, True), (1.01, False)])
def test_clipped_signals_are_warned_of(most: float, warned: bool) -> None:
    record = trough_record(cycles=30.0, samples=50)
    values = record.trough["trough_along"]
    cut = np.minimum(values, most * values.max())
    measured = motion_of(replace(record, trough={**record.trough, "trough_along": cut}))
    assert len([text for text in measured.warnings if "clipped" in text]) == warned
