"""What a comparison takes of a record, and its position in the cycle, with errors and rivals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.made_records import FREQUENCY, NOISE, PERIOD, Walked, bowl, nut

import vibro
from vibro.errors import InputError
from vibro.motion.settled import settled_motion
from vibro.records.alignment import (
    Estimate,
    Observation,
    align,
    check_scene,
    computed_signals,
    independent_samples,
)
from vibro.records.reading import Record

SIGNALS = ("displacement", "velocity", "acceleration", "friction")
TIME = np.arange(401) / 600.0


# --- what is taken of a record ------------------------------------------------------------------------


def force_record(**sensitivities: str) -> Record:
    return Record(np.arange(81) / 600.0, {"friction": np.arange(81.0)}, {}, {}, sensitivities)


@pytest.mark.parametrize("reverse", [False, True])
def test_friction_is_the_force_over_the_mass_in_the_conveying_direction(reverse: bool) -> None:
    clock = Estimate(0.01, 1e-4)
    taken = Observation.of(force_record(friction="50mV/N"), 15.0, mass=0.25, reverse=reverse, clock=clock)
    np.testing.assert_allclose(taken.signals["friction"], np.arange(81.0) * (-4.0 if reverse else 4.0))
    assert (list(taken.signals), taken.frequency, taken.clock) == (["friction"], 15.0, clock)
    assert taken.sensitivities == {"friction": "50mV/N"}
    assert taken.period == pytest.approx(1.0 / 15.0)


@pytest.mark.parametrize("mass", [1e-20, 1e20])
def test_masses_at_the_ends_of_what_is_allowed(mass: float) -> None:
    values = Observation.of(force_record(), 15.0, mass=mass).signals["friction"]
    np.testing.assert_allclose(values * mass, np.arange(81.0))
    beyond = mass * (1.001 if mass > 1.0 else 0.999)
    with pytest.raises(InputError, match="mass"):
        Observation.of(force_record(), 15.0, mass=beyond)


def test_the_sample_time_is_the_usual_one() -> None:
    """A gap does not change it."""
    assert Observation(np.array([0.0, 1.0, 2.0, 3.0, 6.0]), {}, 1.0).sample_time == 1.0


def test_a_motion_too_small_to_be_compared_is_refused_by_its_larger_amplitude() -> None:
    check_scene(bowl(along_amplitude=1e-25, normal_amplitude=1e-20))
    check_scene(bowl(along_amplitude=1e-3, normal_amplitude=0.0))
    with pytest.raises(InputError, match=r"^normal_amplitude = 9.99e-21 "):
        check_scene(bowl(along_amplitude=1e-25, normal_amplitude=0.999e-20))


# --- the model beside it ------------------------------------------------------------------------------


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
    assert list(computed_signals(settled_motion(scene), ["friction"], TIME, window)) == ["friction"]


def test_neither_zero_nor_growth_of_a_displacement_moves_it() -> None:
    walked, motion = Walked(nut()), settled_motion(nut())
    found = [
        align(Observation(TIME, {"displacement": walked.displacement(TIME + 0.02) + off}, FREQUENCY), motion)
        for off in (0.0 * TIME, 3.0 + 2e-3 * TIME)
    ]
    assert found[0].shift == pytest.approx(0.02, abs=1e-5)
    assert found[1].shift == pytest.approx(found[0].shift, abs=1e-7)


@pytest.mark.parametrize("signals", [*((name,) for name in SIGNALS), SIGNALS[:2]])
def test_the_rough_search_compares_one_cycle_at_every_shift(signals: tuple[str, ...]) -> None:
    """Half the samples times the logarithm of the squares; the growth of a displacement does not count."""
    scene = nut(1.5, trough_angle=0.02)
    observed = Walked(scene).observe(*signals, trigger=0.03)
    motion = settled_motion(scene)
    best, losses = observed.rough_shift(motion)
    assert abs(best - 0.03) < 1.5 * PERIOD / 512
    grid = np.arange(512) * PERIOD / 512
    places = [0, 100, 150, 300, 511]
    expected = np.zeros(len(places))
    for name in signals:
        folded = observed.folded[name]
        measured = folded.periodic(grid) + (0.0 if name == "displacement" else folded.trend(0).value)
        for i, place in enumerate(places):
            later = grid + grid[place]
            model = computed_signals(motion, [name], later, 1.0 / 600.0)[name]
            if name == "displacement":
                model = model - motion.advance / PERIOD * later
                model = model - model.mean()
            expected[i] += 0.5 * TIME.size * math.log(float(np.square(measured - model).sum()))
    np.testing.assert_allclose(losses[places] - losses[0], expected - expected[0], atol=1e-3)
    # it is deep, as nothing but noise and the missing harmonics is left
    assert float(np.ptp(losses)) > 0.5 * TIME.size * math.log(30.0) * len(signals)


# --- errors and rivals --------------------------------------------------------------------------------


@pytest.mark.parametrize(("signal", "noise"), [("displacement", 30.0), ("velocity", 10.0)])
def test_the_error_is_that_of_noise_over_the_slope(signal: str, noise: float) -> None:
    """The root of the sum of squared slopes; of a displacement those beside its growth."""
    walked, motion = Walked(nut()), settled_motion(nut())
    slopes = {"displacement": walked.velocity, "velocity": walked.acceleration}[signal](TIME + 0.02)
    if signal == "displacement":
        slopes = slopes - slopes.mean()
    expected = noise * NOISE[signal] / math.sqrt(float(slopes @ slopes))
    told = [align(walked.observe(signal, trigger=0.02, noise=noise, seed=s), motion).error for s in range(4)]
    assert np.median(told) == pytest.approx(expected, rel=0.15)


def test_two_signals_place_a_record_by_the_certainty_of_both() -> None:
    walked, motion = Walked(nut()), settled_motion(nut())
    errors = []
    for names in (("displacement",), ("velocity",), ("displacement", "velocity")):
        found = [align(walked.observe(*names, noise=8.0, seed=seed), motion).error for seed in range(2)]
        errors.append(float(np.median(found)))
    one, other, both = errors
    assert both == pytest.approx((one**-2.0 + other**-2.0) ** -0.5, rel=0.15)


def test_another_position_is_a_rival_within_three_sigma() -> None:
    """Data half of the motion at one position and half at another fit both; the more of one, the less so."""
    walked, motion = Walked(nut()), settled_motion(nut())
    seen = []
    for share in (0.5, 0.35, 0.2, 0.05, 0.02):
        values = (1.0 - share) * walked.velocity(TIME + 0.01) + share * walked.velocity(TIME + 0.043)
        observed = Observation(TIME, {"velocity": values}, FREQUENCY)
        found = align(observed, motion)
        best, losses = observed.rough_shift(motion)
        other = 0.043 if abs(best - 0.01) < abs(best - 0.043) else 0.01
        count = independent_samples(TIME, values - motion.sample(TIME + best).velocity, FREQUENCY)
        apart = (losses[round(other / PERIOD * 512)] - losses.min()) * count / TIME.size
        if abs(apart - 4.5) > 0.3:
            told = [rival for rival in found.rivals if abs(rival - other) < 2.0 * PERIOD / 512]
            assert (len(told) == 1) == (apart < 4.5)
            seen.append(apart < 4.5)
    assert {*seen} == {True, False}


def test_the_best_position_lies_in_one_period_whatever_the_noise() -> None:
    walked, motion = Walked(nut()), settled_motion(nut())
    offs = []
    for seed in range(6):
        shift = align(walked.observe("velocity", trigger=0.0, seed=seed), motion).shift
        assert 0.0 <= shift < PERIOD
        offs.append(math.remainder(shift, PERIOD))
    assert min(offs) < 0.0 < max(offs)


def test_of_several_signals_the_one_with_most_samples_tells_of_rivals() -> None:
    """A misfit of every cycle counts as two samples, white noise as all of them."""
    walked, motion = Walked(nut()), settled_motion(nut())
    values = 0.55 * walked.velocity(TIME + 0.01) + 0.45 * walked.velocity(TIME + 0.043)
    noise = 100.0 * np.random.default_rng(1).standard_normal(TIME.size)
    alone = align(Observation(TIME, {"velocity": values}, FREQUENCY), motion)
    both = align(Observation(TIME, {"velocity": values, "friction": noise}, FREQUENCY), motion)
    assert (len(alone.rivals), both.rivals) == (1, ())


def test_where_all_positions_fit_alike_there_is_none() -> None:
    """Noise a hundred thousand times as large as the motion; but not noise of ten times."""
    walked, motion = Walked(nut()), settled_motion(nut())
    level = 100.0 * 60e-3 / NOISE["velocity"]
    hopeless = align(walked.observe("velocity", noise=1e3 * level), motion)
    assert math.isnan(hopeless.shift)
    assert math.isnan(hopeless.error)
    assert hopeless.rivals == ()
    assert not math.isnan(align(walked.observe("velocity", noise=0.03 * level), motion).shift)


def test_a_position_that_nothing_tells_may_lie_half_a_period_off() -> None:
    """A large wave that the model has not repeats in every cycle, so that no other record could tell more."""
    walked = Walked(nut())
    other = 3.0 * np.sin(6.0 * math.pi * FREQUENCY * TIME)
    observed = Observation(TIME, {"velocity": walked.velocity(TIME + 0.02) + other}, FREQUENCY)
    assert align(observed, settled_motion(nut())).error == pytest.approx(0.5 * PERIOD)
