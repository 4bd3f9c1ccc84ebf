"""Bands of restitution: bounds hold for bodies drawn from them, and bodies in contact have none."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.questions import changed
from helpers.restitution_boxes import beyond, box_of, drawn_band
from helpers.scenes import scene_with

import vibro
from vibro.core.codes import Regime
from vibro.designs.design import find_designs
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.designs.sensitivities import LARGEST, RESTITUTIONS, speeds_over_restitution

HOPS: dict[str, Any] = {"amplitude": 6e-3}  # throw number 1.9 of the nut


def fields_of(guarantee: vibro.Guarantee) -> dict[str, Any]:
    return {name: value for name, value in vars(guarantee).items() if not name.startswith("certificate")}


@pytest.mark.parametrize("seed", [1, 2, 3, 5])
def test_no_body_of_a_band_lies_beyond_its_bounds(seed: int) -> None:
    scene, bands = drawn_band(seed)
    guarantee = vibro.guarantee(scene, **bands)
    assert (guarantee.proof_min, guarantee.samples) == ("sampled", 4096)
    assert max(beyond(guarantee, box_of(scene, bands), 1024, seed)) <= 1e-9


@pytest.mark.parametrize("restitution", [0.0, 0.3])
def test_a_band_without_a_width_is_the_value_of_the_scene(restitution: float) -> None:
    scene = scene_with(**HOPS, restitution=restitution)
    other = scene_with(**HOPS, restitution=0.7)
    same = vibro.guarantee(other, restitution=(restitution, restitution))
    assert fields_of(same) == fields_of(vibro.guarantee(scene))
    assert same.speed_min == same.speed_max or vibro.solve(scene).status == vibro.Status.AVERAGED


@pytest.mark.parametrize("name", ["static_friction", "drive_angle"])
def test_in_contact_a_band_of_restitution_changes_nothing(name: str) -> None:
    scene = scene_with()
    band = {"static_friction": (0.6, 0.8), "drive_angle": (0.3, 0.4)}[name]
    bands: dict[str, Any] = {name: band}
    both: dict[str, Any] = {name: band, "restitution": (0.0, 0.9)}
    assert fields_of(vibro.guarantee(scene, **both)) == fields_of(vibro.guarantee(scene, **bands))
    shares = (vibro.yield_share(scene, 0.012, highest_regime="back-slip", **x) for x in (bands, both))
    assert len({*shares}) == 1
    one, other = (vibro.feasible_amplitudes(scene, 0.012, **x) for x in (bands, both))
    assert one == other


def test_bodies_that_hardly_bounce_are_nearly_as_fast_as_those_that_do_not() -> None:
    scene = scene_with(**HOPS)
    narrow = vibro.guarantee(scene, restitution=(0.0, 1e-9))
    speed = float(vibro.solve(scene).mean_velocity)
    assert (narrow.speed_min, narrow.speed_max) == pytest.approx((speed, speed), rel=1e-6)


def test_the_share_over_a_band_is_that_of_a_plain_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.designs.windows._FIRST", 8)  # 2048 points
    monkeypatch.setattr("vibro.designs.windows._ERROR", 0.1)
    scene, rng = scene_with(**HOPS), np.random.default_rng(5)
    speeds = vibro.solve(scene_with(**HOPS, restitution=rng.uniform(0.0, 0.5, 2048))).mean_velocity
    target = float(np.median(speeds))
    share, error = vibro.yield_share(scene, target, highest_regime="hopping", restitution=(0.0, 0.5))
    plain = float(np.mean(speeds >= target))
    assert abs(share - plain) < 4.0 * math.hypot(error, math.sqrt(plain * (1.0 - plain) / speeds.size))


def test_speeds_over_restitution_are_those_of_single_scenes() -> None:
    scene = scene_with(**HOPS, restitution=0.9)  # which has no say
    given = [scene_with(**HOPS, restitution=LARGEST * n / (RESTITUTIONS - 1)) for n in range(RESTITUTIONS)]
    speeds = [float(vibro.solve(one).mean_velocity) for one in given]
    assert speeds_over_restitution(scene) == pytest.approx((min(speeds), max(speeds)), rel=1e-12)


FIXED = {"amplitude_mm": "5:5", "frequency_hz": 15, "drive_angle_deg": 20}


@pytest.mark.parametrize(("given", "assumed"), [(None, True), (0.2, False)])
def test_designs_that_hop_hold_over_a_band(given: Any, assumed: bool) -> None:
    """The guarantee of the only setting is that of ``vibro.guarantee`` over the band, and said to be so."""
    scene = {"static_friction": 0.74, "kinetic_friction": 0.57}
    goal = {"speed_mm_s": 5, "highest_regime": "hopping"}
    spec = read_spec(changed(scene=scene | ({} if given is None else {"restitution": given}), drive=[FIXED],
                             drift={}, goal=goal))  # fmt: skip
    low, high = spec.bounces
    assert (low, high) == ((0.0, 0.5) if given is None else (given, given))
    fastest = find_designs(spec, goal_only=True).designs[1]
    bound = vibro.guarantee(
        scene_with(amplitude=5e-3, drive_angle=math.radians(20.0)), restitution=(low, high)
    )
    assert fastest.speed_min_mm_s == pytest.approx(1e3 * bound.speed_min, rel=1e-9)
    assert (fastest.restitution_low, fastest.restitution_high) == (low, high)
    assert fastest.restitution_assumed is assumed
    assert not spec.has_bands  # margins widen no band of restitution
    drive = spec.drives[0]
    one = drive.space.setting(amplitude=1e-3, frequency=15.0, drive_angle=0.3)
    assert Question(spec, drive, Regime.BACK_SLIP).box(one).restitution == (0.0, 0.0)
