"""Bands of a caller: exact edges of what is allowed, and the set that they span."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.scenes import scene_with

from vibro import Scene, SceneError
from vibro.designs.spaces import uncertainty_set

OVAL = Scene(
    along_amplitude=5e-4, normal_amplitude=2e-4, normal_phase=-0.5, frequency=25.0, static_friction=0.4,
    kinetic_friction=0.3, restitution=0.1, gravity=1.62,
)  # fmt: skip
QUARTER = 0.25 * math.pi


def refusal(scene: Scene, **bands: Any) -> str:
    """Return the message of a refusal; empty where there is none."""
    try:
        uncertainty_set(scene, bands)
    except SceneError as exc:
        return str(exc)
    return ""


@pytest.mark.parametrize(
    ("band", "refused"),
    [
        ((-math.pi, math.pi), False),
        ((0.0, 2.0 * math.pi), False),
        ((0.0, np.nextafter(2.0 * math.pi, 7.0)), True),
        ((0.3, 0.3), False),
    ],
)
def test_a_band_of_the_phase_has_one_turn_at_most(band: Any, refused: bool) -> None:
    assert ("normal_phase" in refusal(OVAL, normal_phase=band)) is refused


@pytest.mark.parametrize(
    ("band", "refused"), [((15.0, 15.0), False), ((15.0, math.nextafter(15.0, 0.0)), True)]
)
def test_a_band_goes_upwards(band: Any, refused: bool) -> None:
    assert ("low <= high" in refusal(scene_with(), frequency=band)) is refused


@pytest.mark.parametrize(
    ("drive", "trough", "refused"),
    [
        ((0.1, QUARTER), (0.0, QUARTER), True),  # a right angle together
        ((0.1, QUARTER), (0.0, QUARTER * (1.0 - 1e-15)), False),
        ((0.1, QUARTER), (-QUARTER, 0.0), False),
        ((QUARTER, QUARTER), (QUARTER, QUARTER), True),
    ],
)
def test_drive_and_trough_stay_short_of_a_right_angle(drive: Any, trough: Any, refused: bool) -> None:
    scene = scene_with(static_friction=2.0, drive_angle=0.2)
    assert ("(45 deg)" in refusal(scene, drive_angle=drive, trough_angle=trough)) is refused


@pytest.mark.parametrize(
    ("bands", "refused"),
    [
        ({"static_friction": (0.3, 0.4), "kinetic_friction": (0.4, 0.6)}, False),  # one point is left
        ({"static_friction": (0.3, 0.4), "kinetic_friction": (0.41, 0.6)}, True),
        ({"static_friction": (0.3, 0.4), "kinetic_friction": (0.1, 0.6)}, False),
        ({"static_friction": (0.3, 0.4), "friction_ratio": (0.7, 0.9)}, False),  # the scene's 0.57 has no say
        ({"static_friction": (0.3, 0.4)}, True),
    ],
)
def test_some_kinetic_friction_is_below_static_friction(bands: dict[str, Any], refused: bool) -> None:
    assert ("static_friction = 0.4" in refusal(scene_with(), **bands)) is refused
