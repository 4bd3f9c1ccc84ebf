"""Estimates from records: right within their intervals, and clear about what the data cannot identify."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.made_records import (
    FREQUENCY,
    NOISE,
    ON_ELLIPSES,
    PERIOD,
    STUDY,
    STUDY_FILE,
    Walked,
    nut,
    trough_record,
)
from scipy import stats
from scipy.signal import lfilter

import vibro
from vibro.motion.settled import settled_motion
from vibro.records.alignment import Observation
from vibro.records.drive_errors import drive_errors
from vibro.records.fitting import Fit, Parameter, fit
from vibro.records.reading import read_record
from vibro.records.sensors import SensorErrors
from vibro.records.trough import trough_drive

if TYPE_CHECKING:
    from vibro.reals import Floats

EXACT = SensorErrors(0.0, 0.0, 0.0, 0.0, 0.0, angle=0.0, amplitude=0.0)
SLIP = ("static_friction", "kinetic_friction")
MOTION = ("displacement", "velocity", "acceleration")
ELLIPSE = ("along_amplitude", "normal_amplitude", "normal_phase")
WRONG = {"static_friction": 0.5, "kinetic_friction": 0.45}


def parameters(found: Fit) -> dict[str, Parameter]:
    return {p.name: p for p in found.parameters}


def assert_contains(found: Fit, scene: vibro.Scene, *names: str, within: float = 0.1) -> None:
    """Check that estimates are within three standard errors, of which an interval has 1.96, and precise."""
    for name in names:
        p, true = parameters(found)[name], float(getattr(scene, name))
        assert p.identified
        half = 0.5 * (p.high - p.low)
        assert abs(p.value - true) < 3.0 / 1.96 * half, name
        assert half < within * true, name


# Every pattern with a rest, and a signal alone, those of motion, and all.
@pytest.mark.parametrize(
    ("amplitude", "pattern", "signals"),
    [
        (1.0, "F_", (*MOTION, "friction")),
        (1.2, "F_B_", ("velocity",)),
        (1.5, "FB_", MOTION),
    ],
)
def test_friction_is_found_from_a_wrong_start(
    amplitude: float, pattern: str, signals: tuple[str, ...]
) -> None:
    walked = Walked(nut(amplitude))
    assert walked.pattern == pattern
    found = fit(nut(amplitude, **WRONG), walked.observe(*signals, cycles=10), SLIP)
    assert_contains(found, nut(amplitude), *SLIP, within=0.12)
    assert pattern in found.statements[0]
    assert found.scene.kinetic_friction == parameters(found)["kinetic_friction"].value


def test_friction_and_amplitude_are_fitted_to_a_track_over_the_ground() -> None:
    """From a scene that is far off, whose own place in the cycle would be wrong."""
    seen = replace(Walked(nut(1.1)).observe("displacement", seed=3, over_ground=True), absolute=True)
    found = fit(nut(1.0, static_friction=0.9, kinetic_friction=0.45), seen, (*SLIP, "amplitude"))
    assert_contains(found, nut(1.1), *SLIP, "amplitude", within=0.025)


@pytest.mark.usefixtures("own_start_alone")
def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    walked = Walked(nut())
    inside = 0
    for seed in range(12):
        found = fit(nut(), walked.observe("velocity", cycles=6, seed=seed), ["kinetic_friction"])
        (p,) = found.parameters
        inside += p.low <= 0.57 <= p.high
    assert inside >= 10


@pytest.mark.usefixtures("own_start_alone")
def test_an_offset_and_a_drift_of_the_sensor_are_fitted_too() -> None:
    walked = Walked(nut(1.2))
    clean = walked.observe("velocity", cycles=6)
    peak = float(np.abs(clean.signals["velocity"]).max())
    drifting = clean.signals["velocity"] + peak * (0.03 + 0.05 * clean.time / clean.time[-1])
    found = fit(nut(1.2, **WRONG), Observation(clean.time, {"velocity": drifting}, FREQUENCY), SLIP)
    assert_contains(found, nut(1.2), *SLIP)
    for p, same in zip(found.parameters, fit(nut(1.2, **WRONG), clean, SLIP).parameters, strict=True):
        assert p.value == pytest.approx(same.value, rel=1e-4)


@pytest.mark.usefixtures("own_start_alone")
def test_samples_beside_a_jump_of_the_acceleration_do_not_count() -> None:
    """Nobody knows what a sensor shows there: a spike at every start and end of a slide moves nothing."""
    walked = Walked(nut(1.2))
    clean = walked.observe("acceleration", cycles=6)
    jumps = [start + edge * length for _, start, length in walked.slides for edge in (0.0, 1.0)]
    away = (np.subtract.outer(clean.time + 0.0137, jumps) / PERIOD + 0.5) % 1.0 - 0.5
    beside = (np.abs(away) * PERIOD < 0.7 / 600.0).any(axis=1)
    assert np.count_nonzero(beside) >= 12
    spiky = Observation(clean.time, {"acceleration": clean.signals["acceleration"] + 0.5 * beside}, FREQUENCY)
    found, same = (fit(nut(1.2), one, ["kinetic_friction"]).parameters[0] for one in (spiky, clean))
    assert same.identified
    assert found.value == pytest.approx(same.value, rel=1e-6)


def test_a_value_near_the_onset_of_back_slip_is_not_pinned_there() -> None:
    """The misfit jumps where back slip begins: both sides of the onset are looked at."""
    onset = 0.7444
    for static_friction, pattern in ((onset - 0.003, "F_B_"), (onset + 0.003, "F_")):
        scene = nut(1.2, static_friction=static_friction)
        walked = Walked(scene)
        assert walked.pattern == pattern
        found = fit(nut(1.2, **WRONG), walked.observe("velocity", cycles=6, noise=2.0), SLIP)
        for name, p in parameters(found).items():
            assert any(low <= float(getattr(scene, name)) <= high for low, high in p.intervals)


@pytest.mark.usefixtures("own_start_alone")
def test_four_unknowns_of_one_slide_cannot_be_told_apart_without_force() -> None:
    everything = ("static_friction", "kinetic_friction", "amplitude", "drive_angle")
    walked = Walked(nut())
    found = fit(nut(), walked.observe("velocity", cycles=4), everything)
    assert not parameters(found)["drive_angle"].identified
    assert any("cannot tell mu_s" in s and "and alpha apart" in s for s in found.statements)
    # At rest friction balances the inertial load, which depends on amplitude and angle.
    found = fit(nut(), walked.observe("displacement", "friction", cycles=5), everything)
    # Their effects are not linear that far from the estimate: alpha is known to 18 %.
    assert_contains(found, nut(), *everything, within=0.2)


@pytest.mark.usefixtures("own_start_alone")
def test_equal_coefficients_are_at_the_limit() -> None:
    walked = Walked(nut(static_friction=0.5, kinetic_friction=0.5))
    observation = walked.observe("velocity", noise=1e-3, cycles=4)
    found = fit(nut(), observation, SLIP)
    assert parameters(found)["static_friction"].value == pytest.approx(0.5, abs=2e-3)
    assert float(found.scene.kinetic_friction) <= float(found.scene.static_friction)
    # With a fixed kinetic friction above the true static one, static friction stops there.
    bounded = fit(nut(static_friction=0.74, kinetic_friction=0.6), observation, ["static_friction"])
    assert bounded.parameters[0].value == pytest.approx(0.6, abs=1e-3)
    assert any("mu_s is at its limit" in s for s in bounded.statements)
    below = fit(nut(static_friction=0.4, kinetic_friction=0.3), observation, ["kinetic_friction"])
    assert below.parameters[0].value == pytest.approx(0.4, abs=1e-3)
    assert any("mu_d is at its limit" in s for s in below.statements)


@pytest.mark.usefixtures("own_start_alone")
def test_smoothed_friction_looks_like_more_friction() -> None:
    """The figures of docs/guide/compare.md: what smoothing adds to both coefficients."""
    observation = Observation.of(read_record(STUDY_FILE), FREQUENCY, mass=STUDY["MASS"])
    found = parameters(fit(nut(), observation, SLIP))
    assert found["static_friction"].value == pytest.approx(0.89, abs=0.01)
    assert found["kinetic_friction"].value == pytest.approx(0.582, abs=0.003)
    # A misfit in every cycle widens the intervals, but not enough to contain the true values.
    assert found["static_friction"].high - found["static_friction"].low > 0.02
    assert found["static_friction"].low > 0.74


# --- elliptical drives -------------------------------------------------------------------------------


def held(found: Fit, true: vibro.Scene) -> list[bool]:
    """Whether each interval holds the true value; phases within their turn."""
    return [
        any(low <= float(getattr(true, p.name)) <= high for low, high in p.intervals)
        for p in found.parameters
    ]


def begun(true: vibro.Scene, **wrong: float) -> vibro.Scene:
    return vibro.Scene(**{n: float(x) for n, x in true.arrays()._asdict().items()} | wrong)


@pytest.mark.parametrize(
    ("label", "names", "wrong"),
    [
        ("FB_", (*SLIP, "normal_phase"), {"static_friction": 0.42, "normal_phase": -1.1}),
        # the valley of the misfit bends: straight steps would end far from its lowest point
        ("FB", ELLIPSE, {"along_amplitude": 1.95e-3, "normal_amplitude": 7e-4, "normal_phase": 0.5}),
    ],
)
@pytest.mark.usefixtures("own_start_alone")
def test_intervals_hold_the_unknowns_of_an_ellipse(
    label: str, names: tuple[str, ...], wrong: dict[str, float]
) -> None:
    """Of quantities at 95 % at most one lies outside, and none by far."""
    true = ON_ELLIPSES[label]
    walked = Walked(true)
    inside: list[bool] = []
    for seed in range(2):
        observed = walked.observe("displacement", "velocity", cycles=6, seed=seed)
        found = fit(begun(true, **wrong), observed, names)
        inside += held(found, true)
        for p in found.parameters:
            value = float(getattr(true, p.name))
            assert p.identified
            assert abs(p.value - value) < 4.0 / 1.96 * 0.5 * (p.high - p.low), p.name
            assert p.high - p.low < 0.35 * abs(value), p.name
    assert inside.count(False) <= 1


@pytest.mark.parametrize("given", [119.0, -420.0])
def test_a_phase_is_told_in_the_turn_of_the_scenes(given: float) -> None:
    """Also next to the phase opposite to it, where a search crosses from one turn to the other."""
    true = ON_ELLIPSES["FB_"]
    observed = Walked(true).observe("velocity", cycles=6)
    (p,) = fit(begun(true, normal_phase=math.radians(given)), observed, ["normal_phase"]).parameters
    assert p.identified
    assert abs(p.value - math.radians(given)) <= 0.5 * math.tau
    off = math.remainder(p.value - math.radians(-60.0), math.tau)
    assert abs(off) < 4.0 / 1.96 * 0.5 * (p.high - p.low) < 0.02
    assert p.low < p.value < p.high


def test_one_slide_a_cycle_leaves_phases_to_both_sides() -> None:
    """Its load is the same for a phase and its opposite, and the start of a slide tells little."""
    true = ON_ELLIPSES["F_"]
    wrong = begun(true, static_friction=0.42, normal_phase=1.1)
    found = fit(wrong, Walked(true).observe("velocity", cycles=6), ("static_friction", "normal_phase"))
    assert all(held(found, true))
    phase = found.parameters[1]
    assert [low > 0.0 for low, _ in phase.intervals] == [False, True]
    assert not phase.identified
    assert any("phases to both sides" in text for text in found.statements)


# --- what is said -------------------------------------------------------------------------------------


def test_a_body_that_hops_is_not_taken_for_one_that_slides(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four quantities let a body in contact follow the record nearly; its intervals took 20 s, and lied."""
    few = {"static_friction": (0.3, 0.6, 1.0), "kinetic_friction": (-0.4, -0.75)}
    few |= {"amplitude": (0.7, 1.0), "drive_angle": (0.2, 0.4, 0.6)}
    monkeypatch.setattr("vibro.records.problem._GRID", few)
    true = {"amplitude": 1.5052e-3, "frequency": 25.0, "drive_angle": math.radians(25.0)}
    true |= {"static_friction": 0.4, "kinetic_friction": 0.3}
    motion = settled_motion(vibro.Scene(**true))
    time = np.arange(320.0) * (float(motion.period) / 40.0)
    exact = motion.sample(time + 0.3 * motion.period).position
    size = 0.02 * float(np.ptp(exact[:40]))
    values = exact + size * np.random.default_rng(5).standard_normal(time.size)
    start = vibro.Scene(**true | {"static_friction": 0.48, "kinetic_friction": 0.36})
    names = (*SLIP, "amplitude", "drive_angle")
    found = fit(start, Observation(time, {"displacement": values}, 25.0), names)
    assert found.statements[0].startswith("the body hops")
    assert_contains(found, vibro.Scene(**true), *names[1:], within=0.3)


# --- how wide intervals are ---------------------------------------------------------------------------


def linear_half_width(names: tuple[str, ...], noise: float, cycles: int, lasting: float = 0.0) -> list[float]:
    """Student's t times standard errors, by differences of another solver's speeds.

    Unknown beside the quantities are the trigger time, an offset and a drift. The noise is an AR(1) process,
    of which a share is that of the sample before.
    """
    time = np.arange(cycles * 40 + 1) / 600.0
    true, step = nut(), 1e-5

    def speeds(later: float = 0.0, **changes: float) -> Floats:
        return Walked(begun(true, **changes)).velocity(time + 0.0137 + later)

    columns = []
    for name in names:
        value = float(getattr(true, name))
        change = speeds(**{name: value * (1.0 + step)}) - speeds(**{name: value * (1.0 - step)})
        columns.append(change / (2.0 * step * value))
    columns += [(speeds(1e-6) - speeds(-1e-6)) / 2e-6, np.ones(time.size), time]
    jacobian = np.stack(columns, axis=1)
    jacobian = (jacobian[1:] - lasting * jacobian[:-1]) / math.sqrt(1.0 - lasting**2)
    sizes = np.linalg.norm(jacobian, axis=0)
    covariance = np.linalg.inv((jacobian / sizes).T @ (jacobian / sizes)) / np.outer(sizes, sizes)
    factor = float(stats.t.ppf(0.975, time.size))
    return [factor * noise * math.sqrt(covariance[i, i]) for i in range(len(names))]


@pytest.mark.usefixtures("own_start_alone")
def test_intervals_of_correlated_noise_are_those_of_linear_theory() -> None:
    """Its power at each frequency counts: taken for slow at all of them, they were 1.6 times as wide."""
    walked, names, widths = Walked(nut()), ("kinetic_friction",), []
    for seed in range(6):
        clean = walked.observe("velocity", cycles=12, noise=0.0)
        white = np.random.default_rng(seed).standard_normal(clean.time.size + 100)
        noise = lfilter([math.sqrt(1.0 - 0.7**2)], [1.0, -0.7], white)[100:]
        values = clean.signals["velocity"] + NOISE["velocity"] * noise
        found = fit(nut(), replace(clean, signals={"velocity": values}), names).parameters
        widths.append([0.5 * (p.high - p.low) for p in found])
    assert np.mean(widths, axis=0) == pytest.approx(
        linear_half_width(names, NOISE["velocity"], 12, 0.7), rel=0.1
    )


# --- a measured drive ----------------------------------------------------------------------------------


def fitted_with_its_drive(seed: int, *, carried: bool) -> Fit:
    """Fit the frictions of a nut, with the drive that two noisy accelerometers measured."""
    record = trough_record(1e-3, FREQUENCY, math.radians(20.0), noise=1.5, seed=seed, trigger=0.0137)
    random = np.random.default_rng(seed + 1000)
    way = Walked(nut()).displacement(record.time + 0.0137) + 2e-6 * random.standard_normal(record.time.size)
    trough = trough_drive(record, {})
    scene = nut(**{name: estimate.value for name, estimate in trough.drive.quantities.items()})
    observation = Observation.of(replace(record, signals={"displacement": way}), float(scene.frequency))
    errors = drive_errors(scene, trough, EXACT) if carried else ()
    return fit(scene, observation, ["static_friction", "kinetic_friction"], errors)


@pytest.mark.usefixtures("own_start_alone")
def test_intervals_carry_the_errors_of_a_measured_drive() -> None:
    """Without them most intervals of mu_d miss its true value, by many of their widths."""
    held = {False: np.zeros(2), True: np.zeros(2)}
    for carried, seeds in ((True, 8), (False, 4)):
        for seed in range(seeds):
            static, kinetic = fitted_with_its_drive(seed, carried=carried).parameters
            held[carried] += static.low < 0.74 < static.high, kinetic.low < 0.57 < kinetic.high
            if carried:
                assert abs(kinetic.value - 0.57) < 1.2 * (kinetic.high - kinetic.low)
    assert (held[True] >= 7).all()
    assert held[False][1] <= 2
