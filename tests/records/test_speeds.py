"""Friction and restitution from times: within their intervals, and clear about what rows cannot tell."""

from __future__ import annotations

import math
import runpy
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.made_times import LENGTH, made_table, walked_speed

import vibro

if TYPE_CHECKING:
    from vibro.records.speeds import SpeedFit, SpeedParameter

DATA = Path(__file__).parents[2] / "examples" / "data"
NUT: dict[str, Any] = {"frequency_hz": 15, "drive_angle_deg": 20, "trough_length_mm": 600}
DRIVE = math.radians(20.0)


def parameters(found: SpeedFit) -> dict[str, SpeedParameter]:
    return {p.name: p for p in found.parameters}


def holds(p: SpeedParameter, value: float) -> bool:
    return any(low <= value <= high for low, high in p.intervals)


def nut_times(*amplitudes: float, mu_s: float = 0.74, mu_d: float = 0.57, e: float = 0.0) -> list[float]:
    """Return the times of the nut over 600 mm."""
    return [LENGTH / walked_speed(1e-3 * a, 15.0, DRIVE, mu_s, mu_d, e) for a in amplitudes]


def nut_speeds(amplitude_mm: float, mu_d: Any, ratio: Any = 0.8, e: Any = 0.0) -> Any:
    return vibro.solve(
        vibro.Scene(
            amplitude=1e-3 * amplitude_mm, frequency=15.0, drive_angle=DRIVE, static_friction=mu_d / ratio,
            kinetic_friction=mu_d, restitution=e,
        )
    ).mean_velocity  # fmt: skip


@pytest.mark.parametrize(("kind", "tables"), [("ratio", 12), ("both", 6), ("hops", 1)])
def test_intervals_hold_the_true_values(kind: str, tables: int) -> None:
    random, held = np.random.default_rng(52), []
    for _ in range(tables):
        made = made_table(random, kind)
        found = vibro.fit_speeds(made.table, **made.rest)
        assert not found.left_out
        assert {p.name for p in found.parameters} == {*made.truth}
        held += [holds(p, made.truth[p.name]) for p in found.parameters]
    assert sum(held) >= 0.85 * len(held)


def test_the_example_is_what_its_program_makes_and_is_fitted() -> None:
    made = runpy.run_path(str(DATA / "make_nut_times.py"))["rows"]()
    assert (DATA / "nut_times.csv").read_text(encoding="utf-8").splitlines()[1:] == made
    found = vibro.fit_speeds(DATA / "nut_times.csv", **NUT)
    assert holds(parameters(found)["kinetic_friction"], 0.57)
    assert holds(parameters(found)["static_friction"], 0.74)
    assert found.error_is == "scatter"
    assert found.computed[0] == 0.0
    best = {name: p.value for name, p in parameters(found).items()}
    scenes = vibro.Scene(
        amplitude=[0.6e-3, 1e-3, 1.4e-3, 1.8e-3, 1.8e-3, 2.4e-3], frequency=15.0, drive_angle=DRIVE, **best
    )
    np.testing.assert_allclose(vibro.solve(scenes).mean_velocity, found.computed, rtol=1e-12)


def test_one_row_gives_every_friction_with_its_time() -> None:
    """The speed rises and falls with friction, and jumps: two intervals, as a scan of all frictions shows."""
    speed = walked_speed(1.5e-3, 15.0, DRIVE, 0.57 / 0.8, 0.57)
    found = vibro.fit_speeds({"amplitude_mm": [1.5], "mean_velocity_mm_s": [1e3 * speed]}, **NUT)
    (p,) = found.parameters
    mu_d = np.geomspace(0.02, 2.0, 200_001)
    off = np.log(np.maximum(nut_speeds(1.5, mu_d), 1e-300) / speed)
    roots = mu_d[:-1][(off[:-1] < 0.0) != (off[1:] < 0.0)]
    assert len(roots) == 4
    assert all(holds(p, root) for root in roots.tolist())
    assert min(abs(roots / p.value - 1.0)) < 1e-4
    fits = mu_d[abs(off) <= 1.96 * 0.02]  # the error that is assumed
    edges = np.flatnonzero(np.diff(fits) > 1e-3)
    ends = np.split(fits, edges + 1)
    assert len(ends) == len(p.intervals)
    np.testing.assert_allclose(p.intervals, [(piece[0], piece[-1]) for piece in ends], rtol=5e-3)
    assert found.error_is == "assumed"
    assert found.error == 0.02


def test_repeats_of_one_setting_tell_the_error() -> None:
    (time,) = nut_times(2.4)
    rows = {"amplitude_mm": [2.4] * 4, "traverse_time_s": [time * x for x in (0.98, 1.0, 1.01, 1.03)]}
    found = vibro.fit_speeds(rows, static_friction=0.74, **NUT)
    assert found.error_is == "scatter"
    error = float(np.std(np.log((0.98, 1.0, 1.01, 1.03)), ddof=1))
    assert found.error == pytest.approx(error, rel=0.02)
    ((low, high),) = found.parameters[0].intervals
    mean = float(np.log((0.98, 1.0, 1.01, 1.03)).mean())
    ends = np.array([low, high])
    off = np.log(LENGTH / nut_speeds(2.4, ends, ends / 0.74) / time) - mean
    np.testing.assert_allclose(abs(off), 3.182 * error / 2.0, rtol=0.05)  # Student's t, 3 degrees of freedom


def test_rows_that_hop_tell_restitution_and_hardly_friction() -> None:
    amplitudes = [4.0, 4.5, 5.0]
    rows = {"amplitude_mm": amplitudes, "traverse_time_s": nut_times(*amplitudes), "error_percent": [1] * 3}
    found = vibro.fit_speeds(rows, static_friction=0.74, kinetic_friction=0.57, **NUT)
    (p,) = found.parameters
    assert p.name == "restitution"
    assert holds(p, 0.0)
    assert p.intervals[0][1] < 0.3
    assert not p.open_low
    slides = {"amplitude_mm": [1, 1.5], "traverse_time_s": nut_times(1.0, 1.5)}
    both: dict[str, Any] = {"static_friction": 0.74, "kinetic_friction": 0.57}
    none = vibro.fit_speeds(slides, fit=["restitution"], **both, **NUT)
    assert none.parameters[0].intervals == ((0.0, 0.6),)
    assert "no part hops in these rows: restitution has no effect" in none.statements


def test_a_part_that_does_not_arrive_bounds_static_friction() -> None:
    """With any friction at rest above the onset of forward slip it rests, and no row says more."""
    rows = {"amplitude_mm": [0.6], "traverse_time_s": ["never"]}
    found = vibro.fit_speeds(rows, kinetic_friction=0.2, **NUT)
    (p,) = found.parameters
    assert p.open_high
    low = p.intervals[0][0]
    at = {"amplitude": 0.6e-3, "frequency": 15.0, "drive_angle": DRIVE, "kinetic_friction": 0.2}
    slower, rests = vibro.solve(vibro.Scene(**at, static_friction=[0.97 * low, 1.03 * low])).mean_velocity
    assert slower > 1e-4
    assert rests < 2e-5


def test_wrong_rows_are_named() -> None:
    amplitudes = [1.0, 1.2, 1.5, 1.8, 2.1, 2.4]
    times = nut_times(*amplitudes)
    # faster than any friction makes it: left out
    fast = [*times[:3], times[3] / 3.0, *times[4:]]
    found = vibro.fit_speeds(
        {"amplitude_mm": amplitudes, "traverse_time_s": fast}, friction_ratio=0.77, **NUT
    )
    assert found.left_out == (3,)
    assert holds(found.parameters[0], 0.57)
    fastest = float(nut_speeds(1.8, np.geomspace(0.02, 2.0, 20_001), 0.77).max())
    assert found.reach[3, 1] == pytest.approx(fastest, rel=0.02)
    # errors that are stated too small are widened
    wavy = [t * x for t, x in zip(times, (1.03, 0.97, 1.03, 0.97, 1.03, 0.97), strict=True)]
    stated = {"amplitude_mm": amplitudes, "traverse_time_s": wavy, "error_percent": [0.3] * 6}
    found = vibro.fit_speeds(stated, friction_ratio=0.77, **NUT)
    assert found.error_is == "widened"
    assert found.error == pytest.approx(0.03, rel=0.4)
    assert holds(found.parameters[0], 0.57)
    # none can be fitted
    found = vibro.fit_speeds({"amplitude_mm": [1.0], "traverse_time_s": [1.0]}, friction_ratio=0.77, **NUT)
    assert found.left_out == (0,)
    assert found.parameters == ()


def test_the_next_point_narrows_the_interval_more_than_the_others() -> None:
    """Other settings, measured without noise, leave longer intervals."""
    truth = {"mu_s": 0.74, "mu_d": 0.57}
    rows = {
        "amplitude_mm": [1.5, 2.4],
        "traverse_time_s": nut_times(1.5, 2.4, **truth),
        "error_percent": [2.0, 2.0],
    }

    def length(*more: float) -> float:
        longer = {
            "amplitude_mm": [*rows["amplitude_mm"], *more],
            "traverse_time_s": [*rows["traverse_time_s"], *nut_times(*more, **truth)],
            "error_percent": [2.0] * (2 + len(more)),
        }
        found = vibro.fit_speeds(longer, fit=["kinetic_friction"], friction_ratio=0.77, **NUT)
        return sum(high - low for low, high in found.parameters[0].intervals)

    point = vibro.fit_speeds(rows, fit=["kinetic_friction"], friction_ratio=0.77, **NUT).next_point
    assert point is not None
    best = length(point.setting["amplitude"])
    others = [length(a) for a in (1.5, 1.8, 2.1, 2.4)]
    assert best < length()
    assert best <= 1.1 * min(others)


def test_other_columns_and_kinds_of_drive() -> None:
    """Strokes, micrometres, revolutions a minute, speeds in m/min: one feeder."""
    times = nut_times(1.2, 2.0)
    speeds = [60.0 * LENGTH / t for t in times]
    tables: tuple[dict[str, Any], ...] = (
        {"stroke_mm": [2.4, 4.0], "frequency_hz": [15, 15], "mean_velocity [m/min]": speeds},
        {
            "amplitude_mm": [1.2, 2.0],
            "frequency [rpm]": [900, 900],
            "drive_angle_deg": [20, 20],
            "speed_m_min": speeds,
        },
        {
            "amplitude_um": [1200, 2000],
            "frequency_hz": ["15", "900rpm"],
            "time [s]": times,
            "error [%]": [1, 1],
        },
    )
    for table in tables:
        rest = {name: x for name, x in NUT.items() if name not in table and "frequency" not in name}
        found = vibro.fit_speeds(table, friction_ratio=0.77, **rest)
        assert found.parameters[0].value == pytest.approx(0.57, rel=2e-3)


def test_parts_that_slide_back_are_fitted_too() -> None:
    speeds = [
        walked_speed(1e-3 * a, 15.0, math.radians(5.0), 0.5, 0.4, trough=math.radians(10.0))
        for a in (1.2, 1.6)
    ]
    assert max(speeds) < 0.0
    rows = {
        "amplitude_mm": [1.2, 1.6],
        "mean_velocity_mm_s": [1e3 * v for v in speeds],
        "error_percent": [1, 1],
    }
    rest: dict[str, Any] = {"frequency_hz": 15, "drive_angle_deg": 5, "trough_angle_deg": 10}
    found = vibro.fit_speeds(rows, friction_ratio=0.8, **rest)
    assert holds(found.parameters[0], 0.4)
    assert not found.left_out
