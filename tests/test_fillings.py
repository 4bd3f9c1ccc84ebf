"""What a filling weighs: the reference rows, energy, the bound, and forces sampled from histories."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.cases import each
from helpers.draws import examples
from helpers.reactions import measured_means, measured_reaction
from helpers.reference_tables import read_rows
from helpers.scenes import Groups, at_load, contact_groups, driven, line_of, replaced
from hypothesis import assume, given
from hypothesis import strategies as st

import vibro
from vibro import Scene, Status, filling
from vibro.fillings import TYPICAL_MACHINES, amplitude_exponent, most_mass_ratio
from vibro.steady import slides_of

ROUNDING = 1e-12  # [1] of shares, which are of the order of 1
ROWS = read_rows("reactions")
ALL = (
    "added_mass_share", "added_damping_share", "added_mass_share_error", "added_damping_share_error",
    "second_harmonic", "energy_per_cycle", "bound", "status",
)  # fmt: skip


def row_scene(row: dict[str, str]) -> Scene:
    """Return the scene of a row of the reference."""
    names = ("load_G", "drive_angle_deg", "static_friction", "kinetic_friction", "trough_angle_deg")
    scene = at_load(*(float(row[name]) for name in names))
    return replaced(scene, restitution=float(row["restitution"]))


# ------------------------------------------------------------------------------------- the reference


@each("row", ROWS)
def test_shares_agree_with_a_walk_in_34_digits(row: dict[str, str]) -> None:
    scene = row_scene(row)
    found, cycle = filling(scene), vibro.solve(scene)
    assert sorted(cycle.pattern) == sorted(row["pattern"])
    assert cycle.period_cycles == float(row["period_cycles"])
    assert found.added_mass_share == pytest.approx(float(row["added_mass_share"]), rel=0.0, abs=1e-11)
    assert found.added_damping_share == pytest.approx(float(row["added_damping_share"]), rel=0.0, abs=1e-11)
    moved = cycle.displacement_per_cycle / scene.scale
    assert moved == pytest.approx(float(row["displacement_per_cycle_over_A"]), rel=0.0, abs=1e-11)


# ------------------------------------------------------------------------- histories, as a second walk

# in contact without rest; hops that end in slides or bounce, for several turns too; ellipses of both kinds
FOLLOWED = {
    "FB": driven(Groups(1.27116, 15.0, 0.69, 0.483), None),
    "HFB uphill": driven(Groups(3.3, 20.0, 0.5, 0.4, 2.0), None),
    "many bounces, then contact": driven(Groups(3.3, 25.0, 0.5, 0.4), None, 0.3),
    "a bounce a turn": driven(Groups(8.0, 20.0, 0.74, 0.57), None, 0.1),
    "three turns": driven(Groups(3.1 / math.sin(0.5), math.degrees(0.5), 0.5, 0.4), None, 0.2),
    "HH in two turns": driven(Groups(3.768 / math.sin(0.6), math.degrees(0.6), 0.5, 0.1), None),
    "an ellipse in contact": driven(Groups(1.2, 30.0, 0.4, 0.3), 40.0),
    "an ellipse that hops": driven(Groups(2.2, 50.0, 0.4, 0.3), -110.0),
    "an ellipse that bounces": driven(Groups(3.1, 51.3, 0.4, 0.3), 57.3, 0.25),
    "an ellipse against the sun": driven(Groups(4.2, 50.0, 0.4, 0.3), 143.0),
}


@pytest.mark.parametrize("name", FOLLOWED)
def test_forces_of_a_history_have_these_harmonics(name: str) -> None:
    scene = FOLLOWED[name]
    found, seen = filling(scene), measured_reaction(scene)
    assert found.status <= Status.BOUNDARY
    assert abs(found.share - seen.share) < ROUNDING
    assert found.energy_per_cycle == pytest.approx(seen.work, rel=ROUNDING)
    assert found.energy_per_cycle == pytest.approx(seen.losses, rel=ROUNDING)
    if scene.amplitude is None:
        second: complex = math.hypot(abs(seen.second_along), abs(seen.second_normal))
    else:
        angle = float(line_of(scene).drive_angle)
        second = seen.second_along * math.cos(angle) + seen.second_normal * math.sin(angle)
    assert abs(found.second_harmonic - second) < ROUNDING


def _assert_energy(scene: Scene) -> None:
    """Compare the energy with what friction, impacts and the climb take."""
    cycle = vibro.solve(scene)
    assume(cycle.status == Status.OK)
    found = filling(scene, threads=1)
    assert abs(found.share) <= found.bound * (1.0 + ROUNDING)
    assert abs(found.second_harmonic) <= found.bound * (1.0 + ROUNDING)
    # downhill the weight gives more energy than friction takes
    climb = float(scene.gravity * np.sin(scene.trough_angle) * cycle.displacement_per_cycle)
    assert found.energy_per_cycle - climb >= -ROUNDING * abs(climb)
    assert found.added_mass_share_error == found.added_damping_share_error == 0.0
    if cycle.pattern == "_":
        assert found.share == 1.0
        assert found.second_harmonic == 0.0
        return
    seen = measured_reaction(scene, cycles=3000.0)
    size = math.pi * float(scene.scale * 2.0 * math.pi * scene.frequency) ** 2
    assert abs(found.share - seen.share) < 1e-9
    assert abs(found.energy_per_cycle - seen.losses) < 1e-9 * size


@given(contact_groups(), st.one_of(st.none(), st.floats(-179.0, 179.0)))
def test_energy_is_what_friction_and_the_climb_take(groups: Groups, phase_deg: float | None) -> None:
    scene = driven(groups, phase_deg)
    assume(vibro.solve(scene, flight=False).coexists == 0)
    assume(vibro.solve(scene, flight=False).largest_multiplier < 0.97)
    _assert_energy(scene)


@examples(25)
@given(
    st.floats(1.001, 4.0), st.floats(8.0, 50.0), st.floats(0.1, 0.9), st.floats(0.3, 1.0),
    st.floats(-3.0, 3.0), st.sampled_from([0.0, 0.0, 0.15, 0.5]),
)  # fmt: skip
def test_energy_is_what_impacts_take_too(
    throw: float, drive: float, mu_s: float, ratio: float, trough: float, restitution: float
) -> None:
    load = throw * math.cos(math.radians(trough)) / math.sin(math.radians(drive))
    scene = driven(Groups(load, drive, mu_s, mu_s * ratio, trough), None, restitution)
    cycle = vibro.solve(scene)
    assume(cycle.status == Status.OK and cycle.largest_multiplier < 0.97)
    history = vibro.simulate(scene, cycles=3000.0)
    # from rest both come to the same cycle, but where several are near
    assume(history.period_cycles == cycle.period_cycles)
    assume(abs(history.cycle_displacement - cycle.displacement_per_cycle) < 1e-9 * scene.scale)
    _assert_energy(scene)


# --------------------------------------------------------------------------------- irregular motion


@pytest.mark.parametrize(
    ("throw", "drive", "restitution", "phase_deg"),
    [(2.6, 30.0, 0.24, None), (4.3, 35.0, 0.5, None), (2.9, 20.0, 0.43, None), (3.4, 40.0, 0.6, 70.0)],
)
def test_means_agree_with_a_long_history_within_their_errors(
    throw: float, drive: float, restitution: float, phase_deg: float | None
) -> None:
    groups = Groups(throw / math.sin(math.radians(drive)), drive, 0.5, 0.4)
    scene = driven(groups, phase_deg, restitution)
    found = filling(scene)
    assert found.status == Status.AVERAGED
    assert abs(found.share) <= found.bound
    seen = np.array([part.share for part in measured_means(scene, 100, 10)])
    for ours, error, theirs in (
        (found.added_mass_share, found.added_mass_share_error, seen.real),
        (found.added_damping_share, found.added_damping_share_error, -seen.imag),
    ):
        assert 0.0 < error < 0.1
        assert abs(ours - theirs.mean()) < 4.0 * math.hypot(
            error, theirs.std(ddof=1) / math.sqrt(theirs.size)
        )


# ------------------------------------------------------------------------------------ limits and scales


def test_shares_leave_rest_smoothly_at_the_onset_of_slip() -> None:
    onset = float(vibro.critical_loads(at_load(1.0, 20.0, 0.5, 0.5)).forward_onset)
    assert filling(at_load(onset * (1.0 - 1e-12), 20.0, 0.5, 0.5)).share == 1.0
    # of equal frictions a slide of the length h loses energy like h^5: in all digits, however short it is
    scenes = at_load(onset * (1.0 + 10.0 ** np.arange(-9.0, -2.0)), 20.0, 0.5, 0.5)
    above, slides = filling(scenes), slides_of(scenes, vibro.solve(scenes).pattern_code)
    middle = 0.5 * (slides.begin[0] + slides.end[0])
    near = math.cos(math.radians(20.0)) / math.pi * slides.displacement[0] * np.sin(middle)
    length = slides.end[0] - slides.begin[0]
    assert (np.abs(above.added_damping_share / near - 1.0) < 0.2 * length + 1e-11).all()
    assert (np.diff(above.added_damping_share) > 0.0).all()
    assert (above.added_damping_share > 0.0).all()


def test_shares_are_continuous_where_bodies_begin_to_hop() -> None:
    hop = 1.0 / math.sin(math.radians(20.0))
    found = filling(at_load(hop * np.array([1.0 - 1e-9, 1.0, 1.0 + 1e-9]), 20.0, 0.5, 0.4))
    assert np.ptp(found.added_mass_share) < 1e-8
    assert np.ptp(found.added_damping_share) < 1e-8


def test_long_and_short_legs_agree_where_they_meet() -> None:
    from vibro.core import filling as core  # the rule's limit is private

    motion = core._Motion(0.3, 0.9, -0.4, 0.7)
    for length in (0.2, 0.9, 1.0):
        path = (
            0.3 * length
            + 0.9 * (length - math.sin(length))
            - 0.4 * (1.0 - math.cos(length))
            - 0.35 * length**2
        )
        short, long = core._short(motion, 2.1, length, path), core._long(motion, 2.1, length)
        np.testing.assert_allclose(short, long, rtol=0.0, atol=4e-16)


# -------------------------------------------------------------------------------- cells and statuses


def test_a_filling_that_is_conveyed_downhill_may_drive_its_trough() -> None:
    scene = at_load(0.3853, 43.4, 0.32, 0.0383, -2.4)
    found, cycle = filling(scene), vibro.solve(scene)
    assert cycle.displacement_per_cycle > 0.0
    assert -found.bound < found.added_damping_share < 0.0
    assert found.energy_per_cycle == pytest.approx(measured_reaction(scene).losses, rel=ROUNDING)


def test_a_grid_has_the_numbers_of_its_cells() -> None:
    loads, angles = np.array([0.2, 0.9, 1.5, 3.3, 5.0, 9.0])[:, np.newaxis], np.array([15.0, 25.0, 40.0])
    whole = filling(at_load(loads, angles, 0.5, 0.4), threads=2)
    assert whole.share.shape == (6, 3)
    for i, j in np.ndindex(6, 3):
        cell = filling(at_load(loads[i, 0], angles[j], 0.5, 0.4))
        for name in ALL:
            a, b = getattr(whole, name)[i, j], getattr(cell, name)
            assert a == b or (np.isnan(a) and np.isnan(b)), name
        assert np.ndim(cell.added_mass_share) == 0


# ------------------------------------------------------------------- up to what mass the motion is given

# [% of the trough's mass] on soft mounts, and on two masses below and above resonance, as first derived: from
# the exponent of the speed, the share, and the machine's compliance
GIVEN = {
    "nut": (Scene(amplitude=1e-3, frequency=15, drive_angle=math.radians(20), static_friction=0.74,
                  kinetic_friction=0.57), 3.80, (0.30, 0.13, 0.04)),
    "slider at 50 Hz": (Scene(amplitude=0.15e-3, frequency=50, drive_angle=math.radians(20),
                              static_friction=0.35, kinetic_friction=0.28), 1.11, (3.1, 1.3, 0.5)),
    "thrower": (Scene(amplitude=5e-3, frequency=16, drive_angle=math.radians(30), static_friction=0.5,
                      kinetic_friction=0.4), 1.36, (3.6, 1.5, 0.5)),
}  # fmt: skip


@pytest.mark.parametrize("name", GIVEN)
def test_up_to_what_filling_the_motion_is_as_given(name: str) -> None:
    scene, exponent, percent = GIVEN[name]
    cycle, found = vibro.solve(scene), filling(scene)
    assert round(float(amplitude_exponent(scene, cycle)), 2) == exponent
    for machine, expected in zip(TYPICAL_MACHINES.values(), percent, strict=True):
        ratio = 100.0 * most_mass_ratio(scene, cycle, found, machine)
        digits = len(str(expected).partition(".")[2])
        assert round(float(ratio), digits) == expected


def test_a_filling_at_the_limit_changes_the_speed_by_one_percent() -> None:
    for scene, _, _ in GIVEN.values():
        cycle, found = vibro.solve(scene), filling(scene)
        for compliance in (1.07, 2.5 * np.exp(0.4j)):
            # the worst phase of the share against the machine's compliance
            change = most_mass_ratio(scene, cycle, found, compliance) * abs(found.share * compliance)
            less = vibro.solve(replaced(scene, amplitude=scene.scale * (1.0 - change)))
            assert abs(less.mean_velocity / cycle.mean_velocity - 1.0) == pytest.approx(0.01, rel=0.03)


def test_the_exponent_is_unknown_where_the_regime_changes() -> None:
    hop = 1.0 / math.sin(math.radians(20.0))
    scene = at_load([0.1, 0.999 * hop, 1.005 * hop, 1.5 * hop], 20.0, 0.5, 0.4)
    exponent = amplitude_exponent(scene, vibro.solve(scene))
    assert np.isnan(exponent).tolist() == [True, False, True, False]


def _compliance(ratio: float, share: float) -> complex:
    """Solve the two masses of a machine with unit natural frequency for m1 H, without a closed form."""
    m2 = (1.0 - share) / share if share else 1e12
    reduced = m2 / (1.0 + m2)
    spring = reduced * (1.0 + 2j * 0.015 * ratio)
    system = np.array([[spring - ratio**2, -spring], [-spring, spring - m2 * ratio**2]])
    return complex(-(ratio**2) * np.linalg.inv(system)[0, 0])


MACHINES = {"soft": (4.0, 0.0), "below": (0.9, 1.0 / 3.0), "above": (1.05, 1.0 / 3.0)}


def test_compliances_are_those_of_two_masses() -> None:
    for value, (ratio, share) in zip(TYPICAL_MACHINES.values(), MACHINES.values(), strict=True):
        assert value == pytest.approx(abs(_compliance(ratio, share)), rel=1e-6)


@pytest.mark.parametrize("machine", MACHINES)
def test_speeds_stay_within_one_percent_with_the_second_harmonic_too(machine: str) -> None:
    ratio, share = MACHINES[machine]
    scenes = [scene for scene, _, _ in GIVEN.values()]
    scenes += [at_load(throw / math.sin(0.5), math.degrees(0.5), 0.5, 0.4) for throw in (0.4, 0.7, 1.5, 2.1)]
    for scene in scenes:
        cycle, found = vibro.solve(scene), filling(scene)
        gain = _compliance(ratio, share)
        mass = most_mass_ratio(scene, cycle, found, gain)
        amplitude = scene.scale / abs(1.0 + mass * found.share * gain)
        bent = -mass * found.second_harmonic * _compliance(2.0 * ratio, share) / 4.0
        angle = float(line_of(scene).drive_angle)
        along, normal = (
            [(size * amplitude, 0.0), (size * amplitude * abs(bent), float(np.angle(bent)))]
            for size in (math.cos(angle), math.sin(angle))
        )
        friction = {"static_friction": scene.static_friction, "kinetic_friction": scene.kinetic_friction}
        full = vibro.solve(
            Scene(along_harmonics=along, normal_harmonics=normal, frequency=scene.frequency, **friction)
        )
        assert abs(full.mean_velocity / cycle.mean_velocity - 1.0) < 0.0105
