"""Frictions that keep a regime: their ends against Newton's law, and against ``solve`` on both sides."""

from __future__ import annotations

import math
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibro
from vibro.core.codes import Regime, Status
from vibro.inverse.friction_windows import MOST_FRICTION, friction_windows

EXAMPLES = Path(__file__).parents[2] / "examples"
NUT = {
    "amplitude": 1e-3,
    "frequency": 15.0,
    "drive_angle": math.radians(20),
    "static_friction": 0.74,
    "kinetic_friction": 0.57,
}


def regime(scene: vibro.Scene, **frictions: float) -> tuple[int, int]:
    """Regime of a scene with other frictions, and whether its cycle is steady."""
    given: dict[str, Any] = {f.name: getattr(scene, f.name) for f in fields(scene)} | frictions
    cycle = vibro.solve(vibro.Scene(**{name: x for name, x in given.items() if x is not None}))
    return int(cycle.regime), int(cycle.status) <= Status.BOUNDARY


def test_rest_begins_where_static_friction_bears_the_drive() -> None:
    # At rest the drive unloads and pushes by G cos(alpha) and G sin(alpha) of the weight at the same moment.
    scene = vibro.Scene(**NUT)
    load, angle = float(scene.load), NUT["drive_angle"]
    window = friction_windows(scene)["static_friction"]
    needed = load * math.cos(angle) / (1.0 - load * math.sin(angle))
    assert window.high == pytest.approx(needed, rel=1e-14)
    assert (window.below, window.above, window.is_proved) == (Regime.BACK_SLIP, Regime.NO_SLIP, True)


@pytest.mark.parametrize(
    "name", ["safety_nut", "bowl_feeder", "climbing_track", "slip_stick", "slip_stick_harmonics"]
)
def test_both_sides_of_every_end(name: str) -> None:
    scene = vibro.read_scene(EXAMPLES / f"{name}.toml")
    mu_s, mu_d = float(scene.static_friction), float(scene.kinetic_friction)
    own = regime(scene)
    for which, window in friction_windows(scene).items():
        for end, beyond, out in ((window.low, window.below, -1e-9), (window.high, window.above, 1e-9)):
            for side in (-out, out) if beyond is not None else (-out,):
                x = end * (1.0 + side)
                pair = (x, min(mu_d / mu_s * x, x)) if which == "static_friction" else (mu_s, x)
                found = regime(scene, static_friction=pair[0], kinetic_friction=pair[1])
                if side == out:
                    assert found == ((int(beyond), True) if isinstance(beyond, Regime) else (found[0], False))
                else:
                    assert found == own


@pytest.mark.parametrize("mu_s", [0.65, 1.232])
def test_the_window_is_the_same_from_next_to_its_ends(mu_s: float) -> None:
    frictions = {"static_friction": mu_s, "kinetic_friction": 0.57 / 0.74 * mu_s}
    near, middle = (friction_windows(vibro.Scene(**x))["static_friction"] for x in (NUT | frictions, NUT))
    assert near[:2] == pytest.approx(middle[:2])
    assert near[2:] == middle[2:]


def test_a_window_that_is_proved_has_no_holes() -> None:
    climbs = NUT | {"trough_angle": math.radians(3)}
    window = friction_windows(vibro.Scene(**climbs))["static_friction"]
    assert window.is_proved
    inside = np.geomspace(window.low, window.high, 3000)
    frictions = {"static_friction": inside, "kinetic_friction": 0.57 / 0.74 * inside}
    assert set(vibro.solve(vibro.Scene(**climbs | frictions)).regime.tolist()) == {Regime.FORWARD_SLIP}
    # on a trough that is steeper than some kinetic friction of the window a body may run away
    steep = vibro.read_scene(EXAMPLES / "climbing_track.toml")
    assert not friction_windows(steep)["kinetic_friction"].is_proved


def test_friction_never_ends_a_hop_and_rest_has_no_upper_end() -> None:
    hops = friction_windows(vibro.Scene(**NUT | {"amplitude": 4e-3}))
    assert {window[2:] for window in hops.values()} == {(None, None, True)}
    rests = friction_windows(vibro.Scene(**NUT | {"amplitude": 0.3e-3}))
    assert (rests["static_friction"].high, rests["static_friction"].above) == (MOST_FRICTION, None)
    assert rests["kinetic_friction"][:2] == (0.0, 0.74)


def test_without_a_steady_cycle_there_is_no_window() -> None:
    assert friction_windows(vibro.Scene(**NUT | {"static_friction": 0.0, "kinetic_friction": 0.0})) == {}
    assert friction_windows(vibro.Scene(**NUT | {"trough_angle": math.radians(-40)})) == {}
    with pytest.raises(vibro.SceneError, match="one operating point"):
        friction_windows(vibro.Scene(**NUT | {"frequency": [15.0, 16.0]}))
