"""Hopping scenes as ``solve`` tells them: exact, or a mean where rounding would choose the motion."""

from __future__ import annotations

import math
import random

import mpmath
import numpy as np
import pytest
from engines.digits_hops import HoppingBody
from helpers.reference_tables import UNSETTLED_IMPACT, read_table
from helpers.scenes import at_load, replaced
from helpers.two_axis_scenes import displacement, random_drives, rotated
from mpmath import mp, mpf

import vibro
from vibro import Regime, Scene, Status, SteadyCycle

FREQUENCY = 20.0
ANGULAR = 2.0 * math.pi * FREQUENCY


def _scene(amplitude: float, drive: float, mu_s: float, mu_d: float, restitution: float = 0.0) -> Scene:
    return Scene(
        amplitude=amplitude,
        frequency=FREQUENCY,
        drive_angle=drive,
        static_friction=mu_s,
        kinetic_friction=mu_d,
        restitution=restitution,
    )


# --- tables -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "within"), [("hopping", 5e-11), ("elliptic_hopping", 1e-11)])
def test_every_hopping_row_is_the_reference_s(name: str, within: float) -> None:
    table = read_table(name)
    columns, cycle = table.columns, table.cycle
    assert (cycle.regime == Regime.HOPPING).all()
    assert (cycle.status == Status.OK).all()
    # K = 3.48392: one flight of one cycle each time; the table counts two
    twice = np.array(table.pattern) == "HH"
    patterns = ["H" if text == "HH" else rotated(text) for text in table.pattern]
    assert [rotated(text) for text in cycle.pattern.tolist()] == patterns
    np.testing.assert_array_equal(cycle.period_cycles, np.where(twice, 1, columns["period_cycles"]))
    error = np.abs(cycle.displacement_per_cycle * table.metre - table.displacement)
    assert (error <= within * (np.abs(table.displacement) + table.size)).all()
    np.testing.assert_allclose(cycle.flight_fraction, columns["flight_fraction"], rtol=1e-11)


def test_impacts_and_throw_numbers_of_ellipses_are_the_reference_s() -> None:
    table = read_table("elliptic_hopping")
    columns, impact = table.columns, table.columns["impact_speed_m_s"].copy()
    row = UNSETTLED_IMPACT
    assert columns["pattern"][row] == "H"
    impact[row] = 9.81 * math.cos(columns["trough_angle_rad"][row]) / columns["frequency_hz"][row]
    np.testing.assert_allclose(table.cycle.impact_velocity, impact, rtol=1e-11)
    np.testing.assert_allclose(table.cycle.throw_number, columns["throw_number"], rtol=1e-13)


# --- the onset --------------------------------------------------------------------------------------


def test_bodies_are_lifted_above_a_throw_number_of_one() -> None:
    some = random_drives(30, 18, steepest=0.5, least_ratio=0.6)
    below, at, above = (
        some.changed(normal=(1.0 + h) * np.cos(some.trough)).solve() for h in (-1e-12, 0.0, 1e-12)
    )
    answered = below.status != Status.RUNAWAY
    assert answered.sum() > 25
    assert (below.status[answered] == Status.OK).all()
    assert (at.status[answered] == Status.BOUNDARY).all()
    assert Regime.HOPPING not in np.concatenate([below.regime, at.regime])
    assert (above.regime == Regime.HOPPING).all()
    assert below.pattern.tolist() == at.pattern.tolist()
    size = np.abs(displacement(below)) + np.maximum(some.along, 1.0)
    assert not (np.abs(displacement(at) - displacement(below)) > 1e-4 * size).any()
    # flights are so short that nothing changes
    told = answered & (above.status == Status.OK)
    assert told.sum() > 22
    assert not (np.abs(displacement(above) - displacement(below))[told] > 1e-4 * size[told]).any()


# --- peak speeds ------------------------------------------------------------------------------------


def test_the_peak_of_a_hop_is_no_speed_from_before_its_take_off() -> None:
    cycle = vibro.solve(
        _scene(0.0006307198628055661, 1.4007303478064574, 1.1189054618278202, 0.9411474078945082)
    )
    assert cycle.status == Status.OK
    assert float(cycle.peak_velocity) == pytest.approx(0.0100291, rel=1e-5)


@pytest.mark.parametrize(("most_restitution", "seed"), [(0.0, 1), (0.5, 2)])
def test_peaks_are_those_of_the_motion_sampled_finely(most_restitution: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    throw = np.concatenate((1.0 + 10.0 ** random.uniform(-4.0, -1.5, 6), random.uniform(1.0, 3.2, 6)))
    drive, mu_s = random.uniform(10.0, 80.0, 12), random.uniform(0.2, 1.2, 12)
    load, mu_d = throw / np.sin(np.radians(drive)), mu_s * random.uniform(0.6, 1.0, 12)
    restitution = most_restitution * random.random(12)
    seen = 0
    for row in zip(load, drive, mu_s, mu_d, restitution, strict=True):
        scene = replaced(at_load(*row[:4]), restitution=row[4])
        cycle = vibro.solve(scene)
        if cycle.status != Status.OK:
            continue
        history = vibro.simulate(scene, cycles=100)
        if not history.settles_at < history.end:
            continue
        seen += 1
        period = int(cycle.period_cycles)
        end = history.settles_at + period / float(scene.frequency)
        times = np.linspace(history.settles_at, end, 1500 * period)
        sampled = np.abs(history.sample(times).velocity).max()
        # speeds jump at impacts: those on either side of each are told
        phases = [p for p in history.phases if history.settles_at <= p.start < end]
        ends = max(max(abs(p.start_velocity), abs(p.end_velocity)) for p in phases)
        assert float(cycle.peak_velocity) == pytest.approx(max(sampled, ends), rel=1e-5), row
    assert seen >= 8


# --- chains of bounces ------------------------------------------------------------------------------


def test_a_long_chain_of_bounces_that_accumulates_is_one_event() -> None:
    cycle = vibro.solve(_scene(0.001254875524558309, math.pi / 6, 0.5, 0.4, 0.95))
    assert cycle.status == Status.OK
    assert cycle.period_cycles == 1
    assert f"{cycle.mean_velocity:.6f}" == "0.064459"
    assert f"{cycle.flight_fraction:.4f}" == "0.2696"


# --- where rounding would choose the motion ---------------------------------------------------------


def test_a_body_that_its_bounces_stop_is_held_by_kinetic_friction_alone() -> None:
    # however small they are: a summed chain ends as one that is flown bounce by bounce
    draw = np.random.default_rng(1)
    n = 600
    drive, mu_s = draw.uniform(0.2, 1.2, n), draw.uniform(0.2, 1.5, n)
    trough = draw.uniform(-0.3, 0.3, n) * np.arctan(mu_s)
    throw, mu_d = draw.uniform(1.05, 3.0, n), mu_s * draw.uniform(0.2, 0.7, n)
    amplitude = throw * 9.81 * np.cos(trough) / np.sin(drive) / ANGULAR**2
    plastic, tiny, small = (
        vibro.solve(Scene(
            amplitude=amplitude, frequency=FREQUENCY, drive_angle=drive, static_friction=mu_s,
            kinetic_friction=mu_d, trough_angle=trough, restitution=e,
        )).displacement_per_cycle / amplitude
        for e in (0.0, 1e-9, 1e-7)
    )  # fmt: skip
    known = ~np.isnan(tiny)
    assert np.array_equal(known, ~np.isnan(small))
    assert np.abs(tiny - small)[known].max() < 2e-6
    assert np.count_nonzero(np.abs(plastic - small)[known] > 1e-3) > 20  # where stiction holds it


@pytest.mark.parametrize(
    "values",
    [
        (0.0020474208511995144, 0.4827495094596426, 0.2654692864610031, 0.23758149756649322,
         0.5657701716863576),
        (0.0018015861452903238, 0.516812434649499, 0.3513152396429374, 0.33490215540735446,
         0.7499557923333563),
        (0.007718065953433521, 0.33669881340850877, 0.26965814310580927, 0.21193762500279054,
         0.5545462625724595),
    ],
)  # fmt: skip
def test_where_rounding_would_choose_the_cycle_there_is_a_mean(
    values: tuple[float, float, float, float, float],
) -> None:
    cycle = vibro.solve(_scene(*values))
    assert cycle.status == Status.AVERAGED
    assert math.isfinite(cycle.mean_velocity)
    assert cycle.mean_velocity_error > 0.0
    assert math.isnan(cycle.period_cycles)


def _level_scenes(count: int, seed: int, least: float, most: float, steps: int = 0) -> SteadyCycle:
    """Draw level scenes with restitutions in a range, at some ulp of the amplitude."""
    random = np.random.default_rng(seed)
    throw, restitution = random.uniform(1.0, 6.0, count), random.uniform(least, most, count)
    mu_s, drive = random.uniform(0.2, 0.9, count), random.uniform(10.0, 50.0, count)
    scene = at_load(throw / np.sin(np.radians(drive)), drive, mu_s, mu_s * random.uniform(0.6, 1.0, count))
    amplitude = np.asarray(scene.amplitude)
    changed = amplitude + steps * np.spacing(amplitude)
    return vibro.solve(replaced(scene, amplitude=changed, restitution=restitution))


def test_scenes_that_are_ok_at_neighbouring_amplitudes_agree() -> None:
    several = [_level_scenes(200, 1, 0.0, 0.9, steps) for steps in range(4)]
    told = np.all([x.status == Status.OK for x in several], axis=0)
    assert told.sum() > 80
    paths = np.array([x.displacement_per_cycle[told] for x in several])
    assert (np.ptp(paths, axis=0) <= 1e-6 * np.abs(paths).max(axis=0)).all()
    assert (np.ptp([x.period_cycles[told] for x in several], axis=0) == 0.0).all()


# --- no friction ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("amplitude", "drive", "mu_s", "restitution", "displacement"),
    [
        (0.00832842715129821, 0.2759119957044087, 0.684972411896944, 0.02454508144177142, "80.9690"),
        (0.002800464550237822, 0.9688820618904932, 0.7351274461536152, 0.04050056452565116, "15.8819"),
    ],
)
def test_without_kinetic_friction_a_body_keeps_the_speed_it_was_thrown_with(
    amplitude: float, drive: float, mu_s: float, restitution: float, displacement: str
) -> None:
    scene = _scene(amplitude, drive, mu_s, 0.0, restitution)
    cycle = vibro.solve(scene)
    assert cycle.status == Status.BOUNDARY  # others keep theirs: a neutral family
    unit = 9.81 / ANGULAR**2
    assert f"{cycle.displacement_per_cycle / unit:.4f}" == displacement
    history = vibro.simulate(scene, cycles=1000)
    assert history.cycle_displacement == pytest.approx(float(cycle.displacement_per_cycle), rel=1e-9)


def _beside_the_vertical(case: int, beside: float) -> tuple[Scene, float, HoppingBody]:
    """Draw a scene whose drive is nearly vertical, and its body; the size of the drive [m]."""
    pick = random.Random(f"vertical {beside} {case}")
    throw, mu_s = pick.uniform(1.02, 1.6), pick.uniform(0.1, 1.2)
    size, trough = throw * 9.81 / ANGULAR**2, 0.0
    mu_d = mu_s * pick.choice((1.0, pick.uniform(0.1, 1.0)))
    if case % 2 == 0:  # below a right angle, and on either side of it to the ground
        drive = 0.5 * math.pi - beside
        trough = (0.0, 2.0, -2.0)[case // 2 % 3] * pick.random() * beside
        scene = replaced(_scene(size, drive, mu_s, mu_d), trough_angle=trough)
        x, y, phase = mpmath.cos(drive), mpmath.sin(drive), 0.0
    else:  # on both sides; at some phases the load along the trough changes its sign at the lift-off
        along, phase = size * beside * pick.uniform(0.5, 1.0), pick.choice((0.0, 1e-3, 0.5, 2.0, -1.0))
        if case % 4 == 3:
            phase = math.asin(1.0 / throw) + pick.uniform(-3.0, 3.0) * beside / mu_s
        phase += pick.choice((0.0, math.pi))
        scene = Scene(
            along_amplitude=along, normal_amplitude=size, normal_phase=phase, frequency=FREQUENCY,
            static_friction=mu_s, kinetic_friction=mu_d,
        )  # fmt: skip
        x, y = mpf(along) / size, mpf(1)
    weight = mpf(9.81) / (size * (2 * mpmath.pi * FREQUENCY) ** 2)
    body = HoppingBody(x, y, phase, weight * mpmath.cos(trough), weight * mpmath.sin(trough), mu_s, mu_d)
    return scene, size, body


@pytest.mark.parametrize("beside", [1e-3, 1e-5, 1e-7, 1e-8, 1e-9, 1e-11, 1e-13, 4e-15, 3e-16])
def test_next_to_a_vertical_drive_hops_have_all_digits(beside: float) -> None:
    told = 0
    with mp.workdps(60):
        for case in range(12):
            scene, size, body = _beside_the_vertical(case, beside)
            found, exact = vibro.solve(scene), body.settle()
            if found.status > Status.BOUNDARY or exact is None:
                continue
            told += 1
            error = abs(mpf(float(found.displacement_per_cycle)) / size - exact)
            assert error <= 2e-14 * max(abs(exact), beside), case
    assert told >= 9


def test_next_to_a_vertical_drive_every_motion_follows_the_drive_s_small_share_along() -> None:
    pick = random.Random("share along")
    several = 0
    for _ in range(25):
        size, phase = pick.uniform(1.6, 2.2) * 9.81 / ANGULAR**2, pick.uniform(-3.0, 3.0)
        mu_s, ratio = pick.uniform(0.1, 0.4), pick.uniform(0.2, 1.0)
        told = []
        for share in (1e-11, 4e-15):
            scene = Scene(
                along_amplitude=share * size, normal_amplitude=size, normal_phase=phase, frequency=FREQUENCY,
                static_friction=mu_s, kinetic_friction=mu_s * ratio, restitution=0.3,
            )  # fmt: skip
            found = vibro.attractors(scene, drops=size)
            told.append([float(motion.mean_velocity) / share for motion in found])
        several += len(told[0]) > 1
        assert told[1] == pytest.approx(told[0], rel=1e-7)
    assert several >= 2
