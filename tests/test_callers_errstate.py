"""What a caller asks of NumPy about floating-point errors is about the caller's own arithmetic."""

from __future__ import annotations

import contextlib
import inspect
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.cases import each

import vibro

if TYPE_CHECKING:
    from collections.abc import Iterator

NUT: dict[str, Any] = {"drive_angle": math.radians(20), "static_friction": 0.74, "kinetic_friction": 0.57}
SWEPT: dict[str, Any] = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}


@pytest.fixture(autouse=True)
def _raises() -> Iterator[None]:
    with np.errstate(all="raise"):
        yield


@each(
    ("amplitude", "frequency"),
    [(1e-15, 1e-12), (1e-15, 1.0), (1e-3, 1e-12), (1e6, 1e3), (1e-15, 1e12), (2e-3, 50.0)],
)
def test_extreme_scenes_are_answered(amplitude: float, frequency: float) -> None:
    scene = vibro.Scene(amplitude=amplitude, frequency=frequency, restitution=0.5, **NUT)
    cycle = vibro.solve(scene)
    assert np.isnan(cycle.mean_velocity) or cycle.status in (vibro.Status.OK, vibro.Status.AVERAGED)
    assert cycle._repr_html_()
    assert cycle.traverse_time(0.6) > 0.0 or np.isnan(cycle.traverse_time(0.6))
    assert vibro.critical_loads(scene).hop > 0.0
    assert isinstance(vibro.transitions(scene), tuple)
    vibro.arrival_time(scene, 0.6)
    assert scene.load >= 0.0
    with contextlib.suppress(vibro.VibroError):  # of scenes without a motion to follow
        vibro.simulate(scene, cycles=2).to_frame()


def test_sweeps_and_their_pictures_are_made() -> None:
    swept = vibro.sweep(amplitude_mm="1e-12:1:9:log", frequency_hz="1e-12:60:9:log", **SWEPT)
    assert len(swept.to_frame()) == 81
    swept = vibro.sweep(amplitude_mm="0.1:3:9", frequency_hz="5:60:9", **SWEPT)
    assert swept.draw("speed").axes


def test_every_public_function_is_shielded() -> None:
    functions = {name: getattr(vibro, name) for name in vibro.__all__}
    plain = [name for name, f in functions.items() if inspect.isroutine(f) and not hasattr(f, "__wrapped__")]
    assert not plain
