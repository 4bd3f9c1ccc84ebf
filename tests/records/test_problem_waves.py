"""Steady motions on drives with harmonics, against Newton's law in small steps; compared and fitted."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.feeders import Complexes, Feeder

import vibro
from vibro.motion.settled import settled_motion
from vibro.records.alignment import Observation
from vibro.records.comparison import compare
from vibro.records.drive_errors import DriveError
from vibro.records.fitting import fit
from vibro.records.problem import FITTABLE

if TYPE_CHECKING:
    from numpy.typing import NDArray

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
