"""Bounds on speeds against bodies of another solver: drawn in each box, and moved on to its extremes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from engines.two_axis_walk import Body, NeverEndsError, NeverSettlesError
from helpers.boxed import with_fields
from helpers.scenes import scene_with

import vibro
from vibro import Guarantee, Scene
from vibro.results.designs import GUARANTEED

DRAWN, ROUNDS, AROUND = 40, 5, 12
ROUNDING = 1e-12  # [1] of the trough's largest speed, or of the body's
#: A line of two bands: its fastest body is the last one before back slip begins.
RIDGE = {
    "frequency": 21.998882466482705, "drive_angle": 0.5789874163008492, "static_friction": 0.3583543812944443,
}  # fmt: skip
RIDGE_BANDS = {
    "amplitude": (0.0002492117514110885, 0.00032326187741966886),
    "kinetic_friction": (0.15378, 0.16346957711732987),
}


def walked(at: dict[str, float]) -> float:
    """Return the mean speed of a body [m/s]; NaN where it does not repeat."""
    if "drive_angle" in at:
        along, normal = (at["amplitude"] * f(at["drive_angle"]) for f in (math.cos, math.sin))
        phase = 0.0
    else:
        along, normal, phase = (at[name] for name in ("along_amplitude", "normal_amplitude", "normal_phase"))
    frictions = at["static_friction"], at["kinetic_friction"]
    body = Body(along, normal, phase, at["frequency"], *frictions, at["trough_angle"])
    try:
        cycle = body.settle()
    except (NeverSettlesError, NeverEndsError):
        return math.nan
    return cycle.displacement * body.unit * at["frequency"]


def drawn_box(seed: int) -> tuple[Scene, dict[str, Any]]:
    """Draw a scene in contact with bands, a line or an ellipse."""
    rng = np.random.default_rng([52, seed])
    low, frequency = rng.uniform(0.15, 0.8), rng.uniform(8.0, 50.0)
    ratio = np.sort(rng.uniform(0.4, 1.0, 2))
    trough = rng.choice([0.0, 1.0, -1.0]) * rng.uniform(0.05, 0.6) * math.atan(low * ratio[0])
    parts = {"frequency": frequency, "static_friction": low, "kinetic_friction": low * ratio[0]}
    unit = rng.uniform(0.2, 0.95) * 9.81 * math.cos(1.1 * trough) / (2.0 * math.pi * frequency) ** 2
    bands: dict[str, Any] = {
        "static_friction": (low, low * rng.uniform(1.0, 1.5)),
        "trough_angle": (trough - 0.1 * abs(trough), trough + 0.1 * abs(trough)),
    }
    if rng.random() < 0.5:
        bands["friction_ratio"] = tuple(ratio)
    else:
        bands["kinetic_friction"] = (low * ratio[0], low * ratio[1])
    if seed % 3:
        angle = rng.uniform(0.1, 1.0)
        amplitude = unit / math.sin(angle + 0.03)
        bands["drive_angle"] = (angle, angle + 0.03)
        bands["amplitude"] = (amplitude * rng.uniform(0.7, 0.95), amplitude)
        scene = Scene(amplitude=amplitude, drive_angle=angle, trough_angle=trough, **parts)
    else:
        phase, along = rng.uniform(-math.pi, math.pi), unit * rng.uniform(0.8, 8.0)
        bands["normal_phase"] = (phase, phase + 0.05)
        bands["along_amplitude"] = (along * 0.95, along)
        oval = {"along_amplitude": along, "normal_amplitude": unit, "normal_phase": phase}
        scene = Scene(**oval, trough_angle=trough, **parts)
    return scene, {name: band for name, band in bands.items() if rng.random() < 0.6}


def bodies(scene: Scene, bands: dict[str, Any], shares: Any) -> list[dict[str, float]]:
    """Return the bodies at shares of all bands, one a column; mu_d beyond mu_s is cut."""
    known = {name: float(value) for name, value in scene.arrays()._asdict().items()}
    found = []
    for column in shares.T:
        at = dict(known)
        for (name, (low, high)), share in zip(bands.items(), column, strict=True):
            at[name] = min(max(low + share * (high - low), low), high)
        if "friction_ratio" in at:
            at["kinetic_friction"] = at.pop("friction_ratio") * at["static_friction"]
        if at["kinetic_friction"] <= at["static_friction"]:
            found.append(at)
    return found


def assert_holds(scene: Scene, bands: dict[str, Any], found: Guarantee, seed: int) -> None:
    """Draw bodies and move the extreme ones on, from those that are said to be extreme too."""
    rng = np.random.default_rng([2, seed])
    size = max(float(np.max(scene.load)) * 9.81 / (2.0 * math.pi * float(scene.frequency)), 1e-12)
    for side, bound, place in ((1.0, found.speed_min, found.min_at), (-1.0, found.speed_max, found.max_at)):
        speeds = [walked(dict(place))]
        x = np.clip(1.3 * rng.random((len(bands), DRAWN)) - 0.15, 0.0, 1.0)
        width = 0.1
        for _ in range(ROUNDS):
            met = [walked(at) for at in bodies(scene, bands, x)]
            known = [speed for speed in met if not math.isnan(speed)]
            speeds += known
            if len(met) == x.shape[1] and known:
                best = x[:, [int(np.nanargmin(side * np.array(met)))]]
            else:
                best = x[:, :1]
            x = np.clip(best + width * rng.standard_normal((len(bands), AROUND)), 0.0, 1.0)
            width *= 0.3
        least = np.nanmin(side * np.array(speeds))
        assert side * bound <= least + ROUNDING * max(size, abs(least))


@pytest.mark.parametrize("seed", range(8, 18))
def test_no_body_of_another_solver_is_beyond_a_guaranteed_speed(seed: int) -> None:
    scene, bands = drawn_box(seed)
    found = vibro.guarantee(scene, **bands)
    assert {found.proof_min, found.proof_max} <= set(GUARANTEED)
    assert found.speed_min <= found.found_min <= found.found_max <= found.speed_max
    if bands:
        assert_holds(scene, bands, found, seed)


def test_the_fastest_body_just_below_the_load_of_back_slip_is_found() -> None:
    scene = Scene(amplitude=2.8e-4, kinetic_friction=0.16, **RIDGE)
    found = vibro.guarantee(scene, **RIDGE_BANDS)
    critical = with_fields(scene, kinetic_friction=0.15378)
    load = float(vibro.critical_loads(critical).back_slip)
    amplitude = 2.8e-4 * load / float(critical.load)
    at = dict(found.max_at) | {"amplitude": amplitude * (1.0 - 1e-10)}
    just_below = walked(at)
    assert just_below == pytest.approx(0.0140801, abs=1e-7)
    assert walked(at | {"amplitude": amplitude * (1.0 + 1e-6)}) < 0.0108
    assert found.found_max == pytest.approx(just_below, rel=1e-8)
    assert found.speed_max == pytest.approx(just_below, rel=1e-5)
    assert found.max_limit == "from below the load at which back slip begins"
    assert found.proof_max == "proved"
    assert_holds(scene, RIDGE_BANDS, found, 0)


@pytest.mark.parametrize("end", [1.0 - 1e-9, 1.0 - 1e-15, 1.0, 1.0 + 1e-15, 1.0 + 1e-9])
def test_a_band_that_ends_at_the_load_of_back_slip_has_the_speed_below_it(end: float) -> None:
    scene = scene_with(amplitude=1.19e-3)
    amplitude = 1.19e-3 * float(vibro.critical_loads(scene).back_slip / scene.load)
    found = vibro.guarantee(scene, amplitude=(0.99 * amplitude, amplitude * end))
    below = walked(dict(scene.arrays()._asdict()) | {"amplitude": amplitude * (1.0 - 2e-9)})
    assert found.speed_max >= below
    assert found.speed_max == pytest.approx(below, rel=2e-6)
    assert found.proof_max in GUARANTEED
