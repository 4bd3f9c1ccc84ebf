"""Steady motions on drives with harmonics, against Newton's law in small steps; compared and fitted."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.feeders import Complexes, Feeder, feeder
from numpy.typing import NDArray

import vibro
from vibro.errors import VibroError
from vibro.motion.settled import settled_motion
from vibro.records.alignment import Observation, check_scene
from vibro.records.comparison import compare
from vibro.records.drive_errors import DriveError, drive_errors
from vibro.records.fitting import fit
from vibro.records.problem import FITTABLE, HOPS, scene_cycles
from vibro.records.sensors import SensorErrors
from vibro.records.trough import MeasuredMotion, TroughDrive, motion_of

GRAVITY, FREQUENCY, RATE = 9.81, 15.0, 600.0
ANGLE = math.radians(20.0)
_SIZE = 0.7e-3
DRIVE = Feeder(
    FREQUENCY,
    _SIZE * math.cos(ANGLE) * np.array([1.0, 0.05 * np.exp(1.0j)], np.complex128),
    _SIZE * math.sin(ANGLE) * np.array([1.0, 0.05 * np.exp(0.7j)], np.complex128),
)


def scene_of(mu_s: float, mu_d: float, drive: Feeder = DRIVE, **others: float) -> vibro.Scene:
    return vibro.Scene(**drive.drive(), static_friction=mu_s, kinetic_friction=mu_d, **others)


def stepped(mu_s: float, mu_d: float, cycles: int, slope: float = 0.0, steps: int = 200) -> dict[str, Any]:
    """Follow a body by steps of constant acceleration, from rest; return what it does after ten cycles."""
    first = round(10 * RATE / FREQUENCY)
    count = first + round(cycles * RATE / FREQUENCY) + 1
    time = np.arange(count * steps) / (RATE * steps)

    def acceleration(way: Complexes, at: NDArray[np.float64]) -> NDArray[np.float64]:
        rates = math.tau * FREQUENCY * np.arange(1, way.size + 1)
        return -(np.exp(1j * np.outer(at, rates)) @ (way * rates**2)).imag

    push = (-acceleration(DRIVE.along, time) - GRAVITY * math.sin(slope)).tolist()
    weight = (acceleration(DRIVE.normal, time) + GRAVITY * math.cos(slope)).tolist()
    step, x, v, positions, velocities = 1.0 / (RATE * steps), 0.0, 0.0, [], []
    for i, (force, normal) in enumerate(zip(push, weight, strict=True)):
        if i % steps == 0:
            positions.append(x)
            velocities.append(v)
        if v == 0.0 and abs(force) <= mu_s * normal:
            continue
        way = math.copysign(1.0, v or force)
        after = v + (force - way * mu_d * normal) * step
        after = after if after * way > 0.0 else 0.0
        x, v = x + 0.5 * (v + after) * step, after
    at = np.arange(count - first) / RATE
    inertial = -acceleration(DRIVE.along, at) - GRAVITY * math.sin(slope)
    moved = np.array(positions[first:]) - positions[first]
    return {"time": at, "displacement": moved, "velocity": np.array(velocities[first:]), "inertial": inertial}


@pytest.mark.parametrize(
    ("mu_s", "mu_d", "slope", "pattern"),
    [(0.5, 0.4, 0.0, "F_B_"), (0.2, 0.15, 0.0, "FB"), (0.6, 0.48, 0.1, "B_"), (0.9, 0.8, 0.0, "_")],
)
def test_motions_are_those_of_small_steps(mu_s: float, mu_d: float, slope: float, pattern: str) -> None:
    scene = scene_of(mu_s, mu_d, trough_angle=slope)
    motion = settled_motion(scene)
    assert motion.pattern == pattern
    walked = stepped(mu_s, mu_d, 3, slope)
    found = motion.sample(walked["time"])
    size = _SIZE * math.tau * FREQUENCY
    np.testing.assert_allclose(found.velocity, walked["velocity"], atol=2e-3 * size)
    np.testing.assert_allclose(found.position - found.position[0], walked["displacement"], atol=4e-3 * _SIZE)
    np.testing.assert_allclose(found.inertial, walked["inertial"], atol=1e-9)
    assert motion.advance == pytest.approx(float(vibro.solve(scene).displacement_per_cycle), abs=1e-9 * _SIZE)
    later = motion.sample(walked["time"] + 7.0 * motion.period)
    np.testing.assert_allclose(later.position - found.position, 7.0 * motion.advance, atol=1e-9 * _SIZE)
    np.testing.assert_allclose(later.velocity, found.velocity, atol=1e-9 * size)


def test_cycles_of_several_scenes_are_those_of_each() -> None:
    fields: dict[str, Any] = {
        **{name: value for name, value in DRIVE.drive().items() if name != "frequency"},
        "frequency": np.full(3, FREQUENCY),
        "static_friction": np.array([0.5, 0.2, 0.9]),
        "kinetic_friction": np.array([0.4, 0.15, 0.8]),
        "trough_angle": np.zeros(3),
        "gravity": np.full(3, GRAVITY),
        "restitution": np.zeros(3),
    }
    cycles = scene_cycles(fields)
    assert cycles.labels.tolist() == ["F_B_", "FB", "_"]
    time, shift = np.linspace(0.0, 0.2, 50), np.array([0.0, 0.01, 0.02])
    seen = Observation(time, dict.fromkeys(("velocity", "displacement", "friction"), time), FREQUENCY)
    signals = cycles.signals(seen, time, shift, 1e-4)
    for i, (mu_s, mu_d) in enumerate(((0.5, 0.4), (0.2, 0.15), (0.9, 0.8))):
        exact = settled_motion(scene_of(mu_s, mu_d)).sample(time + shift[i])
        np.testing.assert_allclose(signals["velocity"][i], exact.velocity, atol=1e-12)
        np.testing.assert_allclose(signals["displacement"][i], exact.position, atol=1e-12)
    assert [cycles.edges(i).size for i in range(3)] == [4, 4, 0]
    # A body at rest is held by friction alone.
    still = settled_motion(scene_of(0.9, 0.8)).sample(time + shift[2])
    np.testing.assert_allclose(signals["friction"][2], -still.inertial, atol=1e-9)


def test_a_scene_whose_motion_is_not_known_is_told_or_left_out() -> None:
    high = DRIVE._replace(along=8.0 * DRIVE.along, normal=8.0 * DRIVE.normal)
    cycle = vibro.solve(scene_of(0.5, 0.4, high))
    assert cycle.regime == vibro.Regime.HOPPING
    if math.isnan(float(cycle.mean_velocity)):
        with pytest.raises(VibroError, match="no steady motion"):
            settled_motion(scene_of(0.5, 0.4, high))
    fields: dict[str, Any] = {
        **high.drive(),
        "gravity": np.full(1, GRAVITY),
        "frequency": np.full(1, FREQUENCY),
    }
    for name, value in {"static_friction": 0.5, "kinetic_friction": 0.4, "trough_angle": 0.0}.items():
        fields[name] = np.full(1, value)
    fields["restitution"] = np.zeros(1)
    assert scene_cycles(fields, hops=False).labels.tolist() == [HOPS]
    assert scene_cycles(fields, hops=False).followed == {}


def observed(noise: float = 2e-6) -> Observation:
    """Record a body on the drive, its displacement alone."""
    walked = stepped(0.5, 0.4, 4)
    random = np.random.default_rng(3)
    way = walked["displacement"] + noise * random.standard_normal(walked["time"].size)
    return Observation(walked["time"], {"displacement": way}, FREQUENCY)


def test_a_record_is_compared_with_harmonics() -> None:
    comparison = compare(scene_of(0.5, 0.4), observed())
    assert comparison.motion.pattern == "F_B_"
    assert comparison.warnings == ()
    rows = {row.key: row for row in comparison.rows}
    advance = rows["stroke_advance"]
    assert advance.measured.value == pytest.approx(advance.computed, rel=2e-3)
    assert min(comparison.alignment.shift, 1.0 / FREQUENCY - comparison.alignment.shift) < 1e-4
    alone = compare(
        scene_of(0.5, 0.4, DRIVE._replace(along=DRIVE.along[:1], normal=DRIVE.normal[:1])), observed()
    )
    other = {row.key: row for row in alone.rows}["stroke_advance"]
    assert abs(other.computed / other.measured.value - 1.0) > 0.2


def test_friction_is_fitted_with_harmonics(monkeypatch: pytest.MonkeyPatch) -> None:
    """And the error of a measured drive, here of 1 % of both amplitudes, widens the interval."""
    monkeypatch.setattr("vibro.records.problem._GRID", dict.fromkeys(FITTABLE, ()))
    record, names = observed(), ["kinetic_friction"]
    exact = fit(scene_of(0.5, 0.36), record, names).parameters[0]
    assert exact.identified
    assert exact.low - 1e-4 < 0.4 < exact.high + 1e-4
    assert exact.high - exact.low < 0.01
    more, less = (
        {**DRIVE._replace(along=gain * DRIVE.along, normal=gain * DRIVE.normal).drive()}
        for gain in (1.01, 0.99)
    )
    wide = fit(scene_of(0.5, 0.36), record, names, [DriveError("gain", more, less)]).parameters[0]
    assert wide.low < 0.4 < wide.high
    assert wide.high - wide.low > 3.0 * (exact.high - exact.low)


def errors_of(measured: MeasuredMotion) -> list[DriveError]:
    """Return the errors of a drive of harmonics, of exact sensors."""
    first, drive = measured.drive_on_ellipse(0.0), measured.drive_by_harmonics()
    scene = vibro.Scene(**measured.drive(), static_friction=0.5, kinetic_friction=0.4)
    exact = SensorErrors(0.0, 0.0, 0.0, 0.0, 0.0, angle=0.0, amplitude=0.0)
    return drive_errors(scene, TroughDrive(first, drive, measured, feeder(3).record(3), (), ()), exact)


def test_a_measured_drive_is_moved_by_all_its_errors() -> None:
    """By twice as many as there are harmonics of both sensors, and by that of the frequency."""
    measured = motion_of(feeder(3).record(3))
    drive = measured.drive_by_harmonics()
    errors = errors_of(measured)
    assert [error.name for error in errors] == 13 * ["noise"]
    squares = np.zeros((2, 3))
    late = 0.0
    for _, more, less in errors:
        late += (0.5 * (more["frequency"] - less["frequency"])) ** 2 if "frequency" in more else 0.0
        for i, name in enumerate(("along_harmonics", "normal_harmonics")):
            if name not in more or "frequency" in more:
                continue
            sizes = [np.array([float(size) for size, _ in fields[name]]) for fields in (more, less)]
            squares[i] += (0.5 * (sizes[0] - sizes[1])) ** 2
    assert math.sqrt(late) == pytest.approx(measured.frequency_error)
    np.testing.assert_allclose(np.sqrt(squares).T, measured.standard_errors, rtol=1e-3)
    quantities = drive.quantities
    assert list(quantities)[:5] == [
        "frequency", "along_amplitude", "along_phase", "along_amplitude_2", "along_phase_2",
    ]  # fmt: skip
    assert quantities["normal_amplitude_3"].value == pytest.approx(abs(measured.normal[2]))
    assert quantities["normal_phase_3"].error == pytest.approx(measured.phase_errors[2, 1])
    turns = (drive.clock.value + measured.clock) * measured.frequency
    assert abs(math.remainder(turns, 1.0)) < 1e-6


def test_one_sensor_gives_both_motions_the_same_relative_errors() -> None:
    measured = motion_of(feeder(3).record(3, sensors=1), drive_angle=0.4)
    drive = measured.drive_by_harmonics()
    assert len(errors_of(measured)) == 2 * 3 + 1
    for end in ("", "_2", "_3"):
        along, normal = (drive.quantities[f"{way}_amplitude{end}"] for way in ("along", "normal"))
        assert normal.value == pytest.approx(math.tan(0.4) * along.value)
        assert normal.error == pytest.approx(math.tan(0.4) * along.error)


def test_the_scale_of_a_motion_counts() -> None:
    time = np.linspace(0.0, 0.2, 301)
    drive = {name: DRIVE.drive()[name] for name in ("along_harmonics", "normal_harmonics")}
    halved = {name: [(0.5 * size, phase) for size, phase in pairs] for name, pairs in drive.items()}
    rest: dict[str, Any] = {"frequency": FREQUENCY, "static_friction": 0.2, "kinetic_friction": 0.15}
    whole, scaled = vibro.Scene(**(rest | drive)), vibro.Scene(**(rest | halved), motion_scale=2.0)
    expected, got = (settled_motion(scene).sample(time) for scene in (whole, scaled))
    assert np.abs(expected.velocity).max() > 1e-3
    np.testing.assert_allclose(got.velocity, expected.velocity, atol=1e-13)
    np.testing.assert_allclose(got.position, expected.position, atol=1e-13)


def test_a_clamped_body_slides_under_its_own_force() -> None:
    time = np.linspace(0.0, 0.2, 301)
    along: dict[str, Any] = {"along_harmonics": DRIVE.drive()["along_harmonics"]}
    rest: dict[str, Any] = {"frequency": FREQUENCY, "static_friction": 0.2, "kinetic_friction": 0.15}
    rest["gravity"] = GRAVITY
    free, clamped = (vibro.Scene(**(rest | along), normal_acceleration=n) for n in (None, GRAVITY))
    expected, got = (settled_motion(scene).sample(time) for scene in (free, clamped))
    assert np.abs(expected.velocity).max() > 1e-3
    np.testing.assert_allclose(got.velocity, expected.velocity, atol=1e-13)


def test_a_body_on_steps_is_compared_too() -> None:
    scene = vibro.Scene(
        motion=vibro.Motion.steps([(0.8, 2.4), (0.2, -9.6)]),
        frequency=FREQUENCY,
        static_friction=0.3,
        kinetic_friction=0.25,
    )
    check_scene(scene)
    motion = settled_motion(scene)
    start, end = motion.sample(np.array([0.1, 0.1 + 3.0 / FREQUENCY])).position
    advance = float(vibro.solve(scene).displacement_per_cycle)
    assert end - start == pytest.approx(3.0 * advance, rel=1e-12)
    assert advance > 0.0
