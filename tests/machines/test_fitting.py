"""Fits of machines to measured amplitudes: reference rows, coverage of intervals, and what is refused."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.draws import draws

from vibro.machines.fitting import fit_response

if TYPE_CHECKING:
    from vibro.machines.fitting import Law

with (Path(__file__).parents[1] / "data/machines/fits.csv").open(encoding="utf-8", newline="") as _file:
    ROWS: list[dict[str, Any]] = [*csv.DictReader(_file)]
BELOW = {"f03", "f06", "f09"}  # points on one side of the resonance alone


def points_of(row: dict[str, str]) -> Any:
    """Return frequency [Hz] and amplitude [m] of each point."""
    pairs = np.array([[float(x) for x in pair.split(":")] for pair in row["points_hz_mm"].split(";")])
    return pairs * [1.0, 1e-3]


def amplitudes(x: Any, damping: float, law: str) -> Any:
    """Amplitude over the static one at frequencies over the natural one."""
    return (x**2 if law == "square" else 1.0) / np.sqrt((1.0 - x**2) ** 2 + 4.0 * (damping * x) ** 2)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["id"])
def test_no_estimate_without_points_on_both_sides(row: dict[str, Any]) -> None:
    law: Law = row["force_law"]
    found = fit_response(points_of(row), law=law, amplitude_error=float(row["amplitude_sd"]))
    low, high = found.natural_frequency_interval
    assert low < float(row["true_f0_hz"]) < high
    if row["id"] in BELOW:
        assert not found.brackets_peak
        assert np.isnan([found.natural_frequency, found.damping_ratio, found.static_amplitude]).all()
    else:
        for got, name in (
            (found.natural_frequency, "f0_hz"), (found.damping_ratio, "damping_ratio"),
            (1e3 * found.static_amplitude, "static_amplitude_mm"),
            (found.natural_frequency_sd, "f0_sd_hz"), (found.damping_ratio_sd, "damping_sd"),
        ):  # fmt: skip
            assert got == pytest.approx(float(row[name]), rel=1e-8), name


COVERED = [
    pytest.param([0.94, 0.98, 1.04], 0.04, "constant", True, 50, id="three points"),
    pytest.param([0.95, 0.98, 1.0, 1.02, 1.05], 0.04, "constant", False, 40, id="error from residuals"),
    pytest.param([1.05, 1.2, 1.4, 2.0], 0.03, "square", True, 40, id="above alone"),
]


@pytest.mark.parametrize(("ratios", "damping", "law", "is_stated", "count"), COVERED)
def test_coverage(ratios: list[float], damping: float, law: Law, is_stated: bool, count: int) -> None:
    count = draws(count)
    rng, natural, static, error = np.random.default_rng(7), 50.0, 1e-3, 0.02
    x, held = np.array(ratios), np.zeros(3)
    for _ in range(count):
        noisy = static * amplitudes(x, damping, law) * np.exp(error * rng.standard_normal(x.size))
        fit = fit_response(
            np.stack([natural * x, noisy], axis=1), law=law, amplitude_error=error if is_stated else None
        )
        intervals = fit.natural_frequency_interval, fit.damping_ratio_interval, fit.static_amplitude_interval
        truth = natural, damping, static
        held += [low <= value <= high for (low, high), value in zip(intervals, truth, strict=True)]
    # 95 % less three standard errors of a share of them
    assert np.all(held / count >= 0.95 - 3.0 * math.sqrt(0.95 * 0.05 / count)), held / count


def test_exact_points_give_the_machine_back() -> None:
    x = np.array([0.8, 0.95, 1.0, 1.03, 1.2])
    for law in ("constant", "square"):
        points = np.stack([50.0 * x, 2e-3 * amplitudes(x, 0.02, law)], axis=1)
        fit = fit_response(points[::-1], law=law)
        assert fit.natural_frequency == pytest.approx(50.0, rel=1e-10)
        assert fit.damping_ratio == pytest.approx(0.02, rel=1e-9)
        assert fit.static_amplitude == pytest.approx(2e-3, rel=1e-9)
        assert np.abs(fit.residual).max() < 1e-9
        np.testing.assert_allclose(fit.amplitudes(fit.frequency), fit.amplitude, rtol=1e-9)


def test_an_unknown_error_needs_five_points() -> None:
    points = points_of(ROWS[0])
    fit = fit_response(points)
    assert fit.natural_frequency == pytest.approx(float(ROWS[0]["f0_hz"]), rel=1e-8)  # three points: exact
    assert np.isnan([*fit.natural_frequency_interval, fit.natural_frequency_sd, fit.damping_ratio_sd]).all()
    assert np.isnan(fit.amplitude_error).all()
    seven = fit_response(points_of(ROWS[1]))
    assert not seven.is_error_stated
    assert 0.01 < seven.amplitude_error[0] < 0.06
    low, high = seven.natural_frequency_interval
    assert low < 98.0 < high


def test_errors_of_each_point_weight_it() -> None:
    x = np.array([0.9, 0.96, 1.0, 1.04, 1.1])
    exact = 1e-3 * amplitudes(x, 0.03, "constant")
    wrong = exact * [1.0, 1.0, 1.0, 1.0, 1.5]
    points = np.stack([50.0 * x, wrong], axis=1)
    errors = np.array([0.02, 0.02, 0.02, 0.02, 5e-1])
    even, weighted = (fit_response(points, amplitude_error=e).natural_frequency for e in (0.02, errors))
    assert abs(weighted - 50.0) < 0.1 * abs(even - 50.0)
    shuffled = fit_response(points[::-1], amplitude_error=errors[::-1])
    assert shuffled.natural_frequency == pytest.approx(weighted, rel=1e-12)


def test_no_damping_ratio_where_its_square_is_negative() -> None:
    points = [(49.0, 1e-3), (50.2, 18.3e-3), (51.0, 1.29e-3)]  # 1 / A^2 vanishes between them
    fit = fit_response(points, amplitude_error=0.1)
    assert fit.brackets_peak
    assert fit.damping_squared < 0.0
    assert math.isnan(fit.damping_ratio)
    assert math.isnan(fit.damping_ratio_sd)
    assert fit.damping_ratio_interval[0] == 0.0


def test_intervals_of_points_on_one_side_hold_all_that_fits() -> None:
    """Of three points far above a resonance, and of points below one that do without damping."""
    above = [(99.45, 1.29e-3), (101.25, 1.27e-3), (118.04, 1.19e-3)]
    fit = fit_response(above, law="square", amplitude_error=0.006)
    low, high = fit.natural_frequency_interval
    assert 0.0 <= low < 50.0 < high < 99.45
    frequency = [15.16, 18.58, 19.58, 20.61, 28.79, 39.34, 48.86]
    amplitude = [1.14e-3, 1.10e-3, 1.19e-3, 1.21e-3, 1.51e-3, 2.76e-3, 9.79e-3]
    below = fit_response(np.stack([frequency, amplitude], axis=1), amplitude_error=0.075)
    assert below.damping_ratio_interval[0] == 0.0
