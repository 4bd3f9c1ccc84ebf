"""Tracks over the ground, which hold the trough's motion: compared and fitted."""

from __future__ import annotations

import math
import runpy
from dataclasses import replace

import numpy as np
import pytest
from helpers.feeders import feeder
from helpers.made_records import EXAMPLES, ON_ELLIPSES, PERIOD, Walked, nut

import vibro
from vibro.motion.settled import settled_motion
from vibro.plots.comparison import comparison_figure
from vibro.records.alignment import Observation, computed_signals
from vibro.records.comparison import Comparison, Row, compare
from vibro.records.fitting import fit
from vibro.records.problem import HOPS, Problem, scene_cycles

TRIGGER = 0.0137
CYCLES = 4  # of each record
SCENES = {"nut": nut(), "climbing nut": nut(1.3, trough_angle=math.radians(4.0))} | {
    label: scene for label, scene in ON_ELLIPSES.items() if label not in (HOPS, "_")
}


def rows(comparison: Comparison) -> dict[str, Row]:
    return {row.key: row for row in comparison.rows}


@pytest.mark.parametrize("hops", [False, True])
def test_the_trough_moves_as_its_drive_says(hops: bool) -> None:
    """Along a line, an ellipse and with harmonics, on a slope, whether the body flies or not."""
    time = np.linspace(-0.3, 0.7, 501)
    slope = {"trough_angle": math.radians(3.0), "static_friction": 0.5, "kinetic_friction": 0.4}
    line = nut(4.0 if hops else 1.0, **slope)
    ellipse = ON_ELLIPSES[HOPS if hops else "FB"]
    three = feeder(8)
    waves = {line: ([1e-3 * (4.0 if hops else 1.0) * math.cos(math.radians(20.0))], 15.0)}
    waves[ellipse] = ([float(ellipse.along_amplitude or 0.0)], 15.0)
    if not hops:
        waves[vibro.Scene(**three.drive(), **slope)] = (list(three.along), three.frequency)
    for scene, (sizes, frequency) in waves.items():
        motion = settled_motion(scene)
        assert ("H" in motion.pattern) == hops
        rates = math.tau * frequency * np.arange(1, len(sizes) + 1)
        turns = np.exp(1j * np.outer(time, rates))
        for name, power in (("displacement", 0), ("velocity", 1), ("acceleration", 2)):
            exact = (turns @ (np.array(sizes) * (1j * rates) ** power)).imag
            off = np.abs(motion.trough(time)[name] - exact).max()
            assert off < 1e-7 * np.abs(exact).max(), (scene, name)


@pytest.mark.parametrize(
    ("label", "signals"),
    [("FB", ("displacement", "velocity")), ("climbing nut", ("acceleration",))],
)
def test_a_track_over_the_ground_gives_the_figures_of_a_relative_one(
    label: str, signals: tuple[str, ...]
) -> None:
    """Of another solver's body."""
    scene = SCENES[label]
    walked = Walked(scene)
    seen = replace(walked.observe(*signals, cycles=CYCLES, over_ground=True), absolute=True)
    absolute, relative = compare(scene, seen), compare(scene, walked.observe(*signals, cycles=CYCLES))
    off = math.remainder(absolute.alignment.shift - TRIGGER, PERIOD)
    assert abs(off) < 4.0 * absolute.alignment.error < 0.05 * PERIOD
    assert absolute.recorded is seen
    assert not absolute.observation.absolute
    assert absolute.warnings == ()
    found, other = rows(absolute), rows(relative)
    assert found.keys() == other.keys()
    for key, row in other.items():
        if row.measured.error > 0.0:
            error = math.hypot(row.measured.error, found[key].measured.error)
            assert abs(found[key].measured.value - row.measured.value) < 4.0 * error, key
    for name in signals:
        assert found[f"rms_{name}"].measured.value < 2.0 * other[f"rms_{name}"].measured.value


def test_errors_of_starts_and_speeds_are_those_of_repeated_noise() -> None:
    """The clock's error is part of both: the trough's motion is subtracted at it."""
    scene = nut()
    walked = Walked(scene)
    off: dict[str, list[float]] = {}
    exact = rows(compare(scene, walked.observe("velocity", noise=0.0)))
    keys = ("forward_slip_start", "forward_slip_end", "peak_speed", "rest_speed")
    for seed in range(8):
        seen = walked.observe("velocity", seed=seed, cycles=CYCLES, noise=3.0, over_ground=True)
        found = rows(compare(scene, replace(seen, absolute=True)))
        for key in keys:
            value, error = found[key].measured
            off.setdefault(key, []).append((value - exact[key].measured.value) / error)
    for key, values in off.items():
        assert 0.4 < float(np.sqrt(np.mean(np.square(values)))) < 1.4, key


def test_the_committed_video_is_what_its_script_makes() -> None:
    data = EXAMPLES / "data"
    made = runpy.run_path(str(data / "make_nut_video_240fps.py"))["table"]()
    file = data / "nut_video_240fps.csv"
    assert file.read_text(encoding="utf-8").splitlines()[0].split(",") == list(made)
    rows = np.loadtxt(file, delimiter=",", skiprows=1)
    np.testing.assert_allclose(rows, np.transpose(list(made.values())), atol=6e-4)


@pytest.mark.parametrize("label", SCENES)
def test_searches_compute_the_same_motion_over_the_ground(label: str) -> None:
    scene = SCENES[label]
    time, names = np.linspace(0.0, 0.2, 101), ("displacement", "velocity", "acceleration", "friction")
    fields = Problem(scene, Walked(scene).observe("velocity"), ["kinetic_friction"]).fixed
    many = scene_cycles({name: np.full(2, value) for name, value in fields.items()})
    seen = Observation(time, dict.fromkeys(names, time), 1.0 / 0.05, absolute=True)
    found = many.signals(seen, time, np.array([0.0, 0.01]), 1e-3)
    for i, shift in enumerate((0.0, 0.01)):
        exact = computed_signals(settled_motion(scene), names, time + shift, 1e-3, absolute=True)
        for name in names:
            size = float(np.abs(exact[name]).max())
            np.testing.assert_allclose(found[name][i], exact[name], atol=1e-7 * size, err_msg=name)


def test_friction_and_amplitude_are_fitted_to_a_track_over_the_ground() -> None:
    """From a scene that is far off, whose own place in the cycle would be wrong."""
    walked = Walked(nut(1.1))
    seen = replace(walked.observe("displacement", seed=3, over_ground=True), absolute=True)
    found = fit(
        nut(1.0, static_friction=0.9, kinetic_friction=0.45),
        seen,
        ["static_friction", "kinetic_friction", "amplitude"],
    )
    for parameter, true in zip(found.parameters, (0.74, 0.57, 1.1e-3), strict=True):
        assert parameter.identified
        assert parameter.low < true < parameter.high
        assert parameter.high - parameter.low < 0.05 * true


def test_a_picture_of_a_fit_shows_the_track_relative_to_the_trough_of_the_fit() -> None:
    """That of a scene with wrong friction was aligned, and subtracted, elsewhere."""
    seen = replace(Walked(nut()).observe("displacement", cycles=CYCLES, over_ground=True), absolute=True)
    wrong, right = compare(nut(static_friction=0.9, kinetic_friction=0.45), seen), compare(nut(), seen)
    figure = comparison_figure(wrong, "", {}, right)
    dots = np.asarray(figure.axes[0].lines[0].get_ydata(), np.float64)
    shown = 1e3 * right.observation.signals["displacement"][: np.size(dots)]
    np.testing.assert_allclose(dots, shown)
    assert np.abs(shown - 1e3 * wrong.observation.signals["displacement"][: np.size(dots)]).max() > 0.01
