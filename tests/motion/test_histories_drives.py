"""Histories, settled motion and arrivals of all drives: integrated motion and reference rows."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from engines.integrated import LEAST_BOUNCE, TURN, Body
from helpers.cases import each
from helpers.reference_tables import CONTACT, columns_of, read_rows, read_table, scene_of
from helpers.scenes import GRAVITY, Groups, driven

import vibro
from vibro.motion.settled import cycle_phases, settled_motion

EPS = float(np.finfo(float).eps)
FREQUENCY = 15.0


class Motion(NamedTuple):
    """A scene, and for how many cycles the integration follows it."""

    groups: Groups  # load of the hypotenuse of both amplitudes and its angle, as a line has them
    phase_deg: float | None = None  # of an ellipse
    restitution: float = 0.0
    cycles: int = 3

    @property
    def scene(self) -> vibro.Scene:
        return driven(self.groups, self.phase_deg, self.restitution)

    @property
    def phase(self) -> float:
        """Lead of the motion normal to the trough [rad]."""
        return math.radians(self.phase_deg or 0.0)


LINES = {
    "slips forward between rests": Motion(Groups(0.9, 20.0, 0.5, 0.4)),
    "slips both ways": Motion(Groups(1.35, 20.0, 0.74, 0.57)),
    "continuous sliding, low friction": Motion(Groups(2.0, 25.0, 0.2, 0.15)),
    "continuous sliding, high friction": Motion(Groups(2.0, 20.0, 0.74, 0.57)),
    "continuous sliding, uphill": Motion(Groups(2.2, 20.0, 0.45, 0.3, 3.0)),
    "downhill": Motion(Groups(1.1, 30.0, 0.5, 0.4, -6.0)),
    "downhill, high friction": Motion(Groups(1.007, 16.82, 0.51, 0.426, -8.95)),
    "hops": Motion(Groups(3.4, 30.0, 0.5, 0.4)),
    "hops, high friction": Motion(Groups(5.8, 20.0, 0.74, 0.57)),
    "hops uphill": Motion(Groups(4.5, 25.0, 0.6, 0.45, 5.0)),
    "hops high": Motion(Groups(8.6, 30.0, 0.5, 0.4)),
    "bounces": Motion(Groups(3.0, 30.0, 0.5, 0.4), restitution=0.3),
    "bounces, high friction": Motion(Groups(5.8, 20.0, 0.74, 0.57), restitution=0.3),
    "bounces high uphill": Motion(Groups(8.0, 20.0, 0.3, 0.2, 3.0), restitution=0.3, cycles=2),
}
ELLIPSES = {
    "slips between rests": Motion(Groups(0.9, 20.0, 0.5, 0.4), -60.0),
    "conveys backwards": Motion(Groups(1.35, 20.0, 0.74, 0.57), 160.0),
    "continuous sliding": Motion(Groups(2.0, 25.0, 0.2, 0.15), -90.0),
    "continuous sliding, uphill": Motion(Groups(2.2, 20.0, 0.45, 0.3, 3.0), 75.0),
    "presses more than it pushes": Motion(Groups(0.95, 75.0, 0.6, 0.5, -6.0), 120.0),
    "near the hop, at rest inside a window": Motion(Groups(1.03, 75.0, 0.7, 0.6, 8.0), -100.0),
    "hops, slides forward before": Motion(Groups(3.4, 30.0, 0.5, 0.4), -35.0),
    "hops, slides back before": Motion(Groups(3.4, 30.0, 0.5, 0.4), -170.0),
    "hops uphill, thrown at once": Motion(Groups(4.5, 25.0, 0.6, 0.45, 5.0), 80.0),
    "hops high": Motion(Groups(8.6, 30.0, 0.5, 0.4), 130.0),
    "bounces": Motion(Groups(3.0, 30.0, 0.5, 0.4), -120.0, 0.3),
}
MOTIONS = {f"line {name}": motion for name, motion in LINES.items()} | {
    f"ellipse {name}": motion for name, motion in ELLIPSES.items()
}
SEVERAL_CYCLES = {
    "line hops high",
    "line bounces, high friction",
    "line bounces high uphill",
    "ellipse hops high",
}
"""These repeat every few cycles, or never."""


def units(groups: Groups) -> tuple[float, float]:
    """Return the hypotenuse of the amplitudes [m] and w [1/s]."""
    w = TURN * FREQUENCY
    return groups.load * GRAVITY / w**2, w


@each(("phase", "velocity"), [(0.0, 0.0), (4.0, -0.8)])
@each("name", MOTIONS)
def test_motion_and_forces_are_those_of_the_integrated_body(name: str, phase: float, velocity: float) -> None:
    motion = MOTIONS[name]
    groups, restitution, lead = motion.groups, motion.restitution, motion.phase
    a, w = units(groups)
    history = vibro.simulate(
        motion.scene, cycles=motion.cycles, start_phase=phase, start_velocity=velocity * a * w
    )
    body = Body(groups, restitution, phase=phase, velocity=velocity, lead=lead)
    # the integration leaves out the smallest bounces, each of which shifts all that follows
    tolerance = 1e-9 if restitution == 0.0 else motion.cycles**2 * LEAST_BOUNCE
    since, followed = np.arange(0.37, motion.cycles * TURN, 1.31), []
    for p in phase + since:
        body.until(p)
        height = body.state[2] if body.aloft else 0.0
        followed.append((*body.state[:2], height, body.aloft, body.way))
    place, speed, height, aloft, way = np.array(followed).T
    at, p = history.sample(since / w), phase + since
    assert at.position / a == pytest.approx(place, abs=tolerance)
    assert at.velocity / (a * w) == pytest.approx(speed, abs=tolerance)
    assert at.gap / a == pytest.approx(height, abs=tolerance)
    assert at.trough_along / a == pytest.approx(body.along * np.sin(p), abs=1e-13)
    assert at.trough_normal / a == pytest.approx(body.across * np.sin(p + lead), abs=1e-13)
    along_the_line = np.full(p.shape, math.nan) if motion.phase_deg is not None else np.sin(p)
    assert at.trough_displacement / a == pytest.approx(along_the_line, abs=1e-13, nan_ok=True)
    assert at.inertial / (a * w * w) == pytest.approx(body.along * np.sin(p) - body.slope, abs=1e-13)
    normal, touches = body.weight - body.across * np.sin(p + lead), aloft == 0.0
    assert at.normal[touches] / (a * w * w) == pytest.approx(normal[touches], abs=1e-13)
    slides = touches & (way != 0.0)
    friction = (-way * groups.mu_d * normal)[slides]
    assert at.friction[slides] / (a * w * w) == pytest.approx(friction, abs=1e-12)


@pytest.mark.parametrize(
    ("name", "count", "limit"), [("hopping", 47, 5e-11), ("elliptic_hopping", 30, 1e-11)]
)
def test_hops_settle_into_the_cycles_of_the_reference_rows(name: str, count: int, limit: float) -> None:
    rows = read_rows(name)
    assert len(rows) == count
    metre, unit = (1000.0, "mm") if name == "hopping" else (1.0, "m")
    for row in rows:
        scene = scene_of_row(row)
        history = vibro.simulate(scene, cycles=1000)
        expected = float(row[f"displacement_per_cycle_{unit}"]) / metre
        error = abs(history.cycle_displacement - expected)
        assert error <= limit * (abs(expected) + float(scene.scale))
        # K = 3.48392: one flight of one cycle each time; the table counts two
        pattern, period = ("H", 1) if row["pattern"] == "HH" else (row["pattern"], int(row["period_cycles"]))
        assert len(history.pattern) == len(pattern)
        assert pattern in 2 * history.pattern
        assert history.period_cycles == period


def scene_of_row(row: dict[str, str]) -> vibro.Scene:
    return scene_of({name: column[0] for name, column in columns_of([row]).items()})


@pytest.mark.parametrize("name", CONTACT)
def test_phases_of_contact_cycles_follow_each_other_and_add_up_to_the_reference_rows(name: str) -> None:
    table, rows = read_table(name), read_rows(name)
    seen = set()
    for i, pattern in enumerate(table.pattern):
        if not set(pattern) & set("FB"):  # rests or runs away
            continue
        phases = cycle_phases(scene_of_row(rows[i]))
        expected, condition = table.displacement[i], table.columns["condition"][i]
        error = abs(sum(p.displacement for p in phases) * table.metre - expected)
        # Bodies with harmonics are followed until their motion repeats, to 1e-12; positions are sums.
        most = 4096 if name.startswith("harmonic") else 32
        assert error <= most * EPS * (condition * abs(expected) + table.size[i])
        assert "".join(p.kind for p in phases) == pattern
        turns = [table.columns["frequency_hz"][i] * t for p in phases for t in (p.start, p.end)]
        assert 0.0 <= turns[0] < 1.0
        assert turns[-1] - turns[0] == pytest.approx(1.0, abs=1e-12)
        assert turns[2::2] == pytest.approx(turns[1:-1:2], abs=1e-12)
        seen.add(pattern)
    assert len(seen) >= 3
    assert name != "elliptic_contact" or seen == {"FB", "F_B_", "FB_", "F_B", "F_", "B_"}


@pytest.mark.parametrize("name", [name for name in MOTIONS if name not in SEVERAL_CYCLES])
def test_the_settled_motion_is_the_history_at_trough_times(name: str) -> None:
    groups, scene = MOTIONS[name].groups, MOTIONS[name].scene
    a, w = units(groups)
    settled, late = settled_motion(scene), vibro.simulate(scene, cycles=400)
    assert late.settles_at < 300.0 / FREQUENCY
    times = np.linspace(0.0, 1.0 / FREQUENCY, 41)
    one, other = settled.sample(times), late.sample(times + 350.0 / FREQUENCY)
    for field in ("velocity", "gap", "trough_along", "trough_normal"):
        assert getattr(one, field) == pytest.approx(getattr(other, field), abs=1e-9 * a * w), field
    assert np.diff(one.position) == pytest.approx(np.diff(other.position), abs=1e-9 * a)
    for kind, start, end in [(p.kind, p.start, p.end) for p in cycle_phases(scene) if p.kind in "FB"]:
        # the same slide in the history
        middles = [
            (0.5 * (p.start + p.end) - 0.5 * (start + end)) * FREQUENCY
            for p in late.phases[-30:-1]
            if p.kind == kind and p.end - p.start == pytest.approx(end - start, abs=1e-9)
        ]
        assert min(abs(turns - round(turns)) for turns in middles) < 1e-9


@each("name", MOTIONS)
def test_the_first_arrival_is_that_of_the_history(name: str) -> None:
    motion = MOTIONS[name]
    a, _ = units(motion.groups)
    if vibro.solve(motion.scene).mean_velocity < 0.0:  # look from the other end
        level = motion.groups._replace(trough_deg=-motion.groups.trough_deg)
        motion = motion._replace(groups=level, phase_deg=(motion.phase_deg or 0.0) - 180.0)
    scene = motion.scene
    lengths = a * np.array([0.02, 1.7, 23.0])
    for length, time in zip(lengths, vibro.arrival_time(scene, lengths), strict=True):
        history = vibro.simulate(scene, duration=time * (1.0 + 1e-9))
        assert history.sample(time).position == pytest.approx(length, rel=1e-11)
        before = history.sample(np.linspace(0.0, time * (1.0 - 1e-9), 2_001)).position
        assert before.max() < length


def test_a_trough_that_only_rises_and_falls_moves_no_body() -> None:
    scene = vibro.Scene(
        along_amplitude=0.0,
        normal_amplitude=[1e-4, 2e-3, 3e-3],
        frequency=FREQUENCY,
        static_friction=0.5,
        kinetic_friction=0.4,
        gravity=GRAVITY,
    )
    cycle = vibro.solve(scene)
    assert cycle.pattern.tolist() == ["_", "H_", "H_"]
    assert cycle.displacement_per_cycle.tolist() == [0.0, 0.0, 0.0]
    assert np.isinf(vibro.arrival_time(scene, 0.1)).all()
