"""Many steady cycles at once: the signals of every pattern are those of other solvers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.made_records import FREQUENCY, ON_ELLIPSES, PERIOD, Walked, nut

import vibro
from vibro.motion.settled import settled_motion
from vibro.records.alignment import Observation, computed_signals
from vibro.records.problem import HOPS, labels_of, scene_cycles

SIGNALS = ("displacement", "velocity", "acceleration", "friction")
CLIMBING: dict[str, Any] = {
    "trough_angle": math.radians(8.0),
    "static_friction": 0.3,
    "kinetic_friction": 0.15,
}
SCENES = {
    "_": nut(0.5),
    "F_": nut(1.0),
    "F_B_": nut(1.2),
    "FB_": nut(1.5),
    "FB": nut(2.0),
    "F_B": nut(2.0, **CLIMBING),
    HOPS: nut(6.0),
}
TIME = np.linspace(0.0, 3.0 * PERIOD, 1501)
WINDOW = 1e-7 * PERIOD


def values_of(*scenes: vibro.Scene) -> dict[str, Any]:
    return {name: np.array([float(getattr(s, name)) for s in scenes]) for name in scenes[0].arrays()._fields}


@pytest.mark.parametrize("scenes", [SCENES, ON_ELLIPSES], ids=["lines", "ellipses"])
def test_every_pattern_has_the_signals_of_another_solver(scenes: dict[str, vibro.Scene]) -> None:
    """All at once, so that none may disturb another; each with its own position in the cycle."""
    cycles = scene_cycles(values_of(*scenes.values()))
    assert cycles.labels.tolist() == list(scenes)
    shifts = PERIOD * np.linspace(0.0, 0.9, len(scenes))
    signals = cycles.signals(Observation(TIME, dict.fromkeys(SIGNALS, TIME), FREQUENCY), TIME, shifts, WINDOW)
    for row, (label, scene) in enumerate(scenes.items()):
        trough = TIME + shifts[row]
        if label == HOPS:
            expected = computed_signals(settled_motion(scene), SIGNALS, trough, WINDOW)
        else:
            walked = Walked(scene)
            assert walked.pattern == label
            expected = {name: getattr(walked, name)(trough) for name in SIGNALS}
        for name in SIGNALS:
            found, true = signals[name][row], expected[name]
            if name == "displacement":
                found, true = found - found[0], true - true[0]
            scale = 1.0 if name in ("acceleration", "friction") else 1e-6
            np.testing.assert_allclose(found, true, atol=1e-5 * scale, err_msg=f"{label} {name}")


@pytest.mark.parametrize(
    "scene",
    [
        vibro.Scene.allowing_infeasible(
            amplitude=1e-3, frequency=FREQUENCY, drive_angle=0.3, static_friction=0.5, kinetic_friction=0.6
        ),
        nut(1.0, static_friction=0.0, kinetic_friction=0.0),
        nut(1.0, trough_angle=math.radians(-60.0)),
    ],
    ids=["mu_d above mu_s", "without friction", "running away"],
)
def test_what_has_no_steady_cycle_has_no_label(scene: vibro.Scene) -> None:
    assert labels_of(values_of(scene, nut())).tolist() == ["", "F_"]
