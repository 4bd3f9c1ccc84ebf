"""Scenes: every field's range, what the error says, and that a scene never changes."""

from __future__ import annotations

import dataclasses
import math
import pickle
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.scenes import line_of

from vibro import Scene, SceneError, Status, solve
from vibro.drives import Line

VALID: dict[str, Any] = {
    "amplitude": 1e-3,
    "frequency": 15.0,
    "drive_angle": math.radians(20.0),
    "static_friction": 0.74,
    "kinetic_friction": 0.57,
    "trough_angle": 0.0,
    "gravity": 9.81,
    "restitution": 0.0,
}


ELLIPSE: dict[str, Any] = {
    **{name: value for name, value in VALID.items() if name not in ("amplitude", "drive_angle")},
    "along_amplitude": 1e-3,
    "normal_amplitude": 3e-4,
    "normal_phase": math.radians(-60.0),
}


def _error(drive: dict[str, Any] = VALID, /, **values: Any) -> SceneError:
    with pytest.raises(SceneError) as caught:
        Scene(**(drive | values))
    return caught.value


@each("field", VALID)
@each(("value", "shown"), [(math.nan, "nan"), (math.inf, "inf"), (-math.inf, "-inf")])
def test_a_value_that_is_not_finite_is_refused(field: str, value: float, shown: str) -> None:
    problems = _error(**{field: value}).problems
    assert problems[0].field == field
    assert shown in problems[0].value


@each("field", VALID)
@each("value", ["wide", "1 mm", [1.0, [2.0]], object(), 1j, None, True])
def test_a_value_that_is_no_number_is_refused(field: str, value: Any) -> None:
    (problem,) = _error(**{field: value}).problems
    assert problem.field == field


def test_a_drive_may_point_beyond_the_vertical() -> None:
    """From 90 deg on the drive never pushes a body forward; while it stays on the trough that is solved."""
    angles = np.radians([[10.0], [10.5], [40.0]])
    scene = Scene(**(VALID | {"drive_angle": np.radians(80.0), "trough_angle": angles}))
    cycle = solve(scene)
    assert not scene.infeasible.any()
    assert cycle.status[:, 0].tolist() == [Status.OK, Status.OK, Status.RUNAWAY]


def test_all_problems_are_reported_at_once_in_the_order_of_the_fields() -> None:
    error = _error(
        amplitude=-1.0, frequency=math.nan, static_friction=0.3, kinetic_friction=0.4, restitution=2.0
    )
    assert [p.field for p in error.problems] == ["amplitude", "frequency", "restitution", "kinetic_friction"]
    assert str(error) == "; ".join(str(p) for p in error.problems)
    wrong_types = _error(amplitude="a", gravity=1j).problems
    assert [p.field for p in wrong_types] == ["amplitude", "gravity"]


def test_the_error_survives_pickling() -> None:
    error = _error(amplitude=0.0, gravity=-1.0)
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is SceneError
    assert copy.problems == error.problems
    assert str(copy) == str(error)


def test_a_scene_is_frozen() -> None:
    scene = Scene(**VALID)
    with pytest.raises(dataclasses.FrozenInstanceError):
        scene.amplitude = np.array(2e-3)  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        scene.frequency[...] = 2e-3


def test_a_scene_keeps_its_values_when_the_caller_s_array_changes() -> None:
    mine = np.array([1e-3, 2e-3])
    scene = Scene(**(VALID | {"amplitude": mine}))
    mine[0] = 5.0
    assert scene.scale.tolist() == [1e-3, 2e-3]
    assert mine.flags.writeable


def test_a_scene_s_fields_are_doubles_and_its_shape_is_their_common_one() -> None:
    scene = Scene(**(VALID | {"amplitude": [[1], [2]], "frequency": np.array([15, 20, 25], np.float32)}))
    assert scene.shape == (2, 3)
    assert {x.dtype for x in line_of(scene)} == {np.dtype(np.float64)}
    assert Scene(**VALID).shape == ()


def test_a_sweep_may_hold_combinations_that_cannot_be() -> None:
    values = VALID | {
        "static_friction": [0.5, 0.7],
        "kinetic_friction": 0.6,
    }
    with pytest.raises(SceneError):
        Scene(**values)
    status = solve(Scene.allowing_infeasible(**values)).status
    assert [Status(s) for s in status] == [Status.INFEASIBLE, Status.OK]


def test_a_sweep_checks_each_field_alone_and_fills_in_the_defaults() -> None:
    required = {k: v for k, v in VALID.items() if k not in ("trough_angle", "gravity", "restitution")}
    scene = Scene.allowing_infeasible(**required)
    assert [float(x) for x in (scene.trough_angle, scene.gravity, scene.restitution)] == [0.0, 9.81, 0.0]
    with pytest.raises(SceneError, match="amplitude = -1 m"):
        Scene.allowing_infeasible(**(required | {"amplitude": -1.0}))
    with pytest.raises(SceneError, match="shapes"):
        Scene.allowing_infeasible(**(required | {"amplitude": [1, 2], "frequency": [1, 2, 3]}))


# --- elliptical drives ------------------------------------------------------------------------------


def test_fields_of_an_ellipse_are_replaced_and_one_drive_by_another() -> None:
    turned: dict[str, Any] = {"normal_phase": 0.5}
    ellipse = dataclasses.replace(Scene(**ELLIPSE), **turned)
    assert ellipse.normal_phase == 0.5
    line: dict[str, Any] = dict.fromkeys(ellipse.arrays()._fields[:3]) | {
        "amplitude": 1e-3,
        "drive_angle": 0.3,
    }
    assert isinstance(dataclasses.replace(ellipse, **line).arrays(), Line)
    mixed: dict[str, Any] = {"amplitude": 1e-3}
    with pytest.raises(SceneError, match="drive = "):
        dataclasses.replace(ellipse, **mixed)
