"""guide/makers.md: makers' formulas for the speed beside the solver, and the limit in which one is exact."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibro

PAGE = (Path(__file__).parents[1] / "docs" / "guide" / "makers.md").read_text(encoding="utf-8")
GRAVITY = 9.81


def throw_of(share: float) -> float:
    """Throw number at which a flight takes this share of a period."""
    p = 2.0 * math.pi * share
    return math.hypot((math.cos(p) + 0.5 * p * p - 1.0) / (p - math.sin(p)), 1.0)


def flight_share(throw: float) -> float:
    """Share of a period that a flight takes, by bisection; the throw number rises with it."""
    low, high = 1e-9, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if throw_of(middle) < throw else (low, middle)
    return low


def throw_speed(amplitude: float, frequency: float, angle: float) -> float:
    """VDI 2333: g n^2 / (2 f) cot(drive angle) [m/s], of a part that sticks on the trough."""
    throw = amplitude * (2.0 * math.pi * frequency) ** 2 * math.sin(angle) / GRAVITY
    if throw <= 1.0:
        return 0.0
    return GRAVITY * flight_share(throw) ** 2 / (2.0 * frequency) / math.tan(angle)


def stroke_speed(amplitude: float, frequency: float) -> float:
    """A maker's rule, 3.81 N S a minute of N strokes a minute and an amplitude S [m/s]."""
    return 3.81 * frequency * amplitude


def rows() -> list[list[str]]:
    lines = [line for line in PAGE.splitlines() if re.match(r"\| [\d.]+ mm,", line)]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def solved(drive: str, frictions: str) -> tuple[list[float], vibro.SteadyCycle]:
    given = [float(number) for number in re.findall(r"[\d.]+", drive)]
    amplitude, frequency, angle = given[0] * 1e-3, given[1], math.radians(given[2])
    static, kinetic = (float(number) for number in frictions.split(","))
    return [amplitude, frequency, angle], solve(amplitude, frequency, angle, static, kinetic)


def solve(amplitude: float, frequency: float, angle: float, static: Any, kinetic: Any) -> vibro.SteadyCycle:
    scene = vibro.Scene(
        amplitude=amplitude,
        frequency=frequency,
        drive_angle=angle,
        static_friction=static,
        kinetic_friction=kinetic,
    )
    return vibro.solve(scene)


@pytest.mark.parametrize("row", rows(), ids=lambda row: f"{row[0]}, {row[1]}")
def test_the_numbers_of_the_page(row: list[str]) -> None:
    drive, frictions, throw, ours, theirs, rule = row
    given, cycle = solved(drive, frictions)
    assert f"{float(cycle.throw_number):.2f}" == throw
    assert f"{1e3 * float(cycle.mean_velocity):.1f}" == ours
    assert f"{1e3 * throw_speed(*given):.1f}" == theirs
    assert f"{1e3 * stroke_speed(*given[:2]):.1f}" == rule


def test_there_are_rows_of_sliding_and_of_thrown_parts() -> None:
    throws = [float(row[2]) for row in rows()]
    assert sum(throw < 1.0 for throw in throws) >= 2
    assert sum(throw > 1.0 for throw in throws) >= 4


def test_the_formula_of_throws_is_the_limit_of_high_friction() -> None:
    frictions = 10.0 ** np.arange(2.0, 7.0)
    for amplitude in (0.3e-3, 0.4e-3, 0.5e-3, 0.6e-3):
        given = amplitude, 50.0, math.radians(30.0)
        speeds = solve(*given, frictions, frictions).mean_velocity
        errors = np.abs(speeds / throw_speed(*given) - 1.0)
        assert np.all(errors < 1.0 / frictions), (amplitude, errors)
