"""What comes next from one operating point, and the loads of whole grids."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scenes import scene_with

import vibro
from vibro import Regime, SceneError

EXAMPLES = Path(__file__).parents[1] / "examples"


def test_critical_loads_have_the_shape_of_angles_and_frictions() -> None:
    scene = scene_with(
        amplitude=np.linspace(1e-3, 2e-3, 5)[:, None, None],
        drive_angle=np.radians([[10.0], [20.0], [30.0]]),
        static_friction=np.array([0.6, 0.74]),
    )
    loads = vibro.critical_loads(scene)
    assert scene.shape == (5, 3, 2)
    assert loads.hop.shape == (3, 2)
    np.testing.assert_allclose(loads.hop[:, 0], 1 / np.sin(np.radians([10.0, 20.0, 30.0])), rtol=1e-15)
    np.testing.assert_allclose(
        scene.load[:, 0, 0] / loads.hop[1, 1], vibro.solve(scene).throw_number[:, 1, 1]
    )


def test_each_transition_is_where_the_motion_changes() -> None:
    scene = vibro.read_scene(EXAMPLES / "safety_nut.toml")
    seen = []
    for t in vibro.transitions(scene):
        assert t.ratio == pytest.approx(float(scene.amplitude) / t.amplitude, rel=1e-14)
        assert t.ratio == pytest.approx((float(scene.frequency) / t.frequency) ** 2, rel=1e-14)
        for name, value in (("amplitude", t.amplitude), ("frequency", t.frequency)):
            below, above = (
                vibro.solve(scene_with(**{name: value * factor})) for factor in (1 - 1e-9, 1 + 1e-9)
            )
            assert (below.regime, below.pattern) != (above.regime, above.pattern), t.name
        seen.append(Regime(int(above.regime)).label)
    assert seen == ["forward-slip", "back-slip", "back-slip", "hopping"]
    assert [t.name for t in vibro.transitions(scene)] == [
        "forward slip", "back slip", "never at rest", "hopping",
    ]  # fmt: skip


def test_what_hopping_forestalls_is_left_out() -> None:
    names = [t.name for t in vibro.transitions(scene_with(drive_angle=math.radians(80)))]
    assert names == ["forward slip", "hopping"]


def test_more_than_one_operating_point_is_refused() -> None:
    with pytest.raises(SceneError, match=r"scene = shape \(2,\): must be one operating point"):
        vibro.transitions(scene_with(frequency=[10.0, 20.0]))
