"""Walks of tests/engines: right on every reference row, and as the package in random scenes."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from engines import harmonic_walk, two_axis_walk
from helpers.harmonics import drive_of, random_harmonics
from helpers.reference_tables import CONTACT, LINES, UNSETTLED_IMPACT, read_table
from helpers.two_axis_scenes import EPS, TURN, Drives, compare, random_drives

from vibro import Status, solve

# --- the tables -------------------------------------------------------------------------------------


class Walked(NamedTuple):
    """A cycle that a walk repeats, in the units of the tables; what a walk does not tell is NaN."""

    pattern: str
    period: int
    displacement: float
    peak_speed: float = math.nan
    impact_speed: float = math.nan
    flight_fraction: float = math.nan


def walk_two_axes(row: dict[str, Any]) -> Walked:
    """Walk a row of a line or an ellipse."""
    if "amplitude_mm" in row:
        alpha, metre = math.radians(row["drive_angle_deg"]), 1000.0
        x, y, phase = row["amplitude_mm"] * math.cos(alpha), row["amplitude_mm"] * math.sin(alpha), 0.0
        trough = math.radians(row["trough_angle_deg"])
    else:
        x, y, phase, metre = row["x_amplitude_m"], row["y_amplitude_m"], row["phase_rad"], 1.0
        trough = row["trough_angle_rad"]
    frequency = row["frequency_hz"]
    frictions = row["static_friction"], row["kinetic_friction"]
    body = two_axis_walk.Body(x / metre, y / metre, phase, frequency, *frictions, trough)
    cycle, unit = body.settle(), metre * body.unit
    speed = unit * TURN * frequency
    displacement, peak, impact = cycle.displacement * unit, cycle.peak * speed, cycle.impact * speed
    return Walked(cycle.pattern, cycle.period, displacement, peak, impact, cycle.flight_fraction)


def walk_harmonics(row: dict[str, Any]) -> Walked:
    """Walk a row of a drive with harmonics."""
    unit = 9.81 / (TURN * row["frequency_hz"]) ** 2  # [m]

    def waves(axis: str) -> list[tuple[float, float]]:
        pairs = [(n * n * row[f"{axis}{n}_amplitude_m"] / unit, row[f"{axis}{n}_phase_rad"]) for n in (1, 2)]
        return [(load * math.cos(phase), load * math.sin(phase)) for load, phase in pairs]

    frictions = row["static_friction"], row["kinetic_friction"]
    drive = harmonic_walk.Drive(waves("x"), waves("y"), *frictions, row["trough_angle_rad"])
    cycle = drive.settle()
    return Walked(cycle.pattern, 1, cycle.displacement * unit)


@pytest.mark.parametrize("name", [*CONTACT, "elliptic_hopping"])
def test_walks_are_right_on_every_row(name: str) -> None:
    table = read_table(name)
    harmonic = name == "harmonic_contact"
    walk, tolerance = (walk_harmonics, 1e-8) if harmonic else (walk_two_axes, 1e-11)
    unending = ArithmeticError if harmonic else two_axis_walk.NeverEndsError
    for i, (pattern, d, largest) in enumerate(
        zip(table.pattern, table.displacement, table.amplitude, strict=True)
    ):
        row = {column: values[i] for column, values in table.columns.items()}
        if not pattern:
            with pytest.raises(unending):
                walk(row)
            continue
        walked = walk(row)
        assert (walked.pattern, walked.period) == (pattern, row["period_cycles"]), i
        # the extreme lines are worse conditioned than the walk's numbers are exact
        rounding = 16.0 * EPS * np.nan_to_num(row["condition"]) * abs(d) if name in LINES else 0.0
        assert walked.displacement == pytest.approx(d, abs=tolerance * (abs(d) + largest) + rounding), i
        if name == "elliptic_contact":
            assert walked.peak_speed == pytest.approx(row["peak_speed_m_s"], rel=1e-11), i
        if name == "elliptic_hopping":
            assert walked.flight_fraction == pytest.approx(row["flight_fraction"], rel=1e-11), i
            if i != UNSETTLED_IMPACT:
                assert walked.impact_speed == pytest.approx(row["impact_speed_m_s"], rel=1e-11), i


# --- random scenes ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("seed", "steepest", "least_ratio"), [(1, 0.0, 0.4), (2, 0.9, 0.4), (3, 0.0, 0.05), (4, 0.3, 0.05)]
)
def test_random_ellipses_settle_as_the_walk_does(seed: int, steepest: float, least_ratio: float) -> None:
    seen = compare(random_drives(60, seed, steepest=steepest, least_ratio=least_ratio))
    assert len(seen) >= 5


def test_troughs_are_walked_about_as_steep_as_kinetic_friction_holds() -> None:
    some = random_drives(300, 31)
    steep = np.arctan(some.mu_d * np.random.default_rng(31).uniform(0.7, 1.2, 300))
    steep = np.minimum(steep, 0.99 * np.arctan(some.mu_s))
    trough = np.where(some.lead > 0.0, steep, -steep)
    seen = compare(some.changed(trough=trough, normal=some.normal * np.cos(trough)))
    assert seen.keys() >= {"runaway", "FB", "F_B", "FB_"}


def test_a_body_may_start_inside_a_window() -> None:
    some = random_drives(4000, 23, steepest=0.95, throw=(0.8, 0.999))
    normal = np.cos(some.trough) - some.normal * np.sin(some.lead)
    inside = np.abs(np.sin(some.trough)) > some.mu_s * normal
    some = Drives(*(x[inside][:50] for x in some))
    assert {1.0, -1.0} == set(np.sign(some.trough))
    compare(some)


@pytest.mark.parametrize(("seed", "steepest", "least_ratio"), [(1, 0.0, 0.4), (2, 0.5, 0.4), (3, 0.2, 0.1)])
def test_random_hops_settle_as_the_walk_does(seed: int, steepest: float, least_ratio: float) -> None:
    some = random_drives(40, seed, steepest=steepest, least_ratio=least_ratio, throw=(1.01, 3.2))
    seen = compare(some)
    assert "irregular" not in seen
    assert len(seen) >= 6


def test_bouncing_bodies_settle_as_the_walk_does() -> None:
    some = random_drives(20, 4, steepest=0.3, throw=(1.01, 1.9))
    seen = compare(some.changed(e=np.linspace(0.02, 0.3, 20)), tolerance=1e-9)
    assert seen.get("irregular", 0) <= 2


@pytest.mark.parametrize(
    ("harmonics", "kind"),
    [
        (2, {}),
        (2, {"along_only": True}),
        (2, {"ratio": (0.02, 0.4)}),
        (2, {"ratio": (1.0, 1.0)}),
        (2, {"steep": 0.97}),
        (2, {"load": (0.3, 1.0)}),
        (3, {}),
        (3, {"along_only": True, "ratio": (0.1, 1.0)}),
    ],
    ids=str,
)
def test_random_drives_with_harmonics_settle_as_the_walk_does(harmonics: int, kind: dict[str, Any]) -> None:
    count = 10
    scene = random_harmonics(count, 20 + harmonics, harmonics, **kind)
    out = solve(scene, flight=False)
    compared = 0
    for i in range(count):
        status = Status(out.status[i])
        if status is Status.FLIGHT_NOT_MODELLED:
            continue
        drive = drive_of(scene, i)
        try:
            cycle = drive.settle(800)
        except ArithmeticError:
            # endless, or too slow for the walk, which decides nothing
            compared += status is Status.RUNAWAY
            continue
        assert status is Status.OK
        assert out.pattern[i] == cycle.pattern
        assert abs(out.displacement_per_cycle[i] - cycle.displacement) < 1e-8 * scene.scale[i]
        compared += 1
    assert compared > 6


def test_slow_approaches_end_where_they_lead() -> None:
    # bodies that are followed for hundreds of cycles before they settle: into cycles that begin only on the
    # way, past jumps of the return map, into a rest that none of the first cycles has
    count = 1500
    scene = random_harmonics(count, 4, ratio=(0.02, 0.2), along_only=True, steep=0.0)
    out = solve(scene, flight=False)
    assert np.count_nonzero(out.status == Status.UNRESOLVED) <= 1
    rare = np.flatnonzero(np.isin(out.pattern, ["F_B", "FB_B", "FBF_", "FBF_B", "B_", "F_"]))[:8]
    for i in rare.tolist():
        cycle = drive_of(scene, i).settle(20_000)
        assert out.pattern[i] == cycle.pattern
        assert abs(out.displacement_per_cycle[i] - cycle.displacement) < 1e-8 * scene.scale[i]
