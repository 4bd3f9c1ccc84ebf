"""``vibro solve --speed``: amplitudes along lines and ellipses, in contact and with hops."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.commands import NUT, STEPS_FILE, Run

if TYPE_CHECKING:
    from pathlib import Path


def test_the_amplitudes_that_reach_a_speed(run: Run) -> None:
    scene = NUT[2:]
    answer = json.loads(run("solve", *scene, "--speed", "0.02815m/s", "--json").stdout)
    assert (answer["met"], answer["speed_mm_s"], answer["highest_regime"]) == (True, 28.15, "back-slip")
    assert "amplitude_mm" not in answer["scene"]
    brief, every = (run("solve", *scene, "--speed", "28.15", *all_).stdout for all_ in ((), ("--all",)))
    assert "drive angle 20 deg" in every
    assert "drive angle 20 deg" not in brief
    ends = [(x["amplitude_low_mm"], x["amplitude_high_mm"]) for x in answer["amplitudes"]]
    published = [(1.177843, 1.190299), (1.233006, 3.229052)]
    np.testing.assert_allclose(ends, published, rtol=1e-6)
    for interval in answer["amplitudes"]:
        for end in ("amplitude_low_mm", "amplitude_high_mm"):
            cycle = json.loads(run("solve", *scene, "-A", repr(interval[end]), "--json").stdout)
            assert cycle["mean_velocity_mm_s"] >= 28.15 * (1.0 - 1e-12)
            assert cycle["regime"] != "hopping"


STEPS = STEPS_FILE.replace("trough_length_mm = 3000", "motion_scale = 7")
DISPLACEMENTS = STEPS.partition("along")[0] + "along_samples_mm = [0, -13, -14, -12, -1, 23, 16, 1]\n"
WAVE = """[scene]
frequency_hz = 15
static_friction = 0.5
kinetic_friction = 0.4
along_amplitudes_mm = [1, 0.2, 0.05]
along_phases_deg = [10, 20, 30]
normal_amplitudes_mm = [0.3, 0.1, 0.03]
normal_phases_deg = [0, 20, 50]
"""
CLAMPED = """[scene]
frequency_hz = 25
static_friction = 0.4
kinetic_friction = 0.3
trough_angle_deg = 90
normal_acceleration_m_s2 = 200
along_amplitudes_mm = [4, 1.2]
along_phases_deg = [0, -90]
"""


@pytest.mark.parametrize(
    ("text", "hopping"),
    [(STEPS, ()), (DISPLACEMENTS, ()), (CLAMPED, ()), (WAVE, ("--hopping",))],
)
def test_the_scales_of_a_motion_that_reach_a_speed(
    run: Run, tmp_path: Path, text: str, hopping: tuple[str, ...]
) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(text, encoding="utf-8")
    speed = 15.0
    result = run("solve", file, "--speed", speed, *hopping, "--json")
    assert (result.exit_code, result.stderr) == (0, "")
    answer = json.loads(result.stdout)
    assert answer["met"]
    assert "motion_scale" not in answer["scene"]
    assert ("motion" in answer["scene"]) == ("[motion]" in text)

    def solved(scale: float) -> dict[str, Any]:
        found = json.loads(run("solve", file, f"motion_scale={scale!r}", "--json").stdout)
        assert isinstance(found, dict)
        return found

    for interval in answer["amplitudes"][:3]:
        low, high = interval["motion_scale_low"], interval["motion_scale_high"]
        at = solved(low)
        assert at["mean_velocity_mm_s"] >= speed * (1.0 - 1e-9)
        assert (at["regime"] == "hopping") <= bool(hopping)
        if interval["low_set_by"] == "speed":
            assert solved(low * (1.0 - 1e-6))["mean_velocity_mm_s"] < speed
        if high is not None and interval["high_set_by"] == "hop" and not hopping:
            assert solved(high)["regime"] != "hopping"
            assert solved(high * (1.0 + 1e-9))["regime"] == "hopping"
        assert solved(2.0 * low if high is None else 0.5 * (low + high))["mean_velocity_mm_s"] >= speed
        if "along_amplitude_low_mm" in interval:  # as large as the scene's times the scale
            given = answer["scene"].get("along_amplitude_mm", interval["along_amplitude_low_mm"] / low)
            assert interval["along_amplitude_low_mm"] == pytest.approx(low * given, rel=1e-15)
    assert ("along_amplitude_low_mm" in answer["amplitudes"][0]) == (text != STEPS)


def test_a_speed_that_no_amplitude_reaches(run: Run) -> None:
    result = run("solve", *NUT[2:], "--speed", "500", "--json")
    answer = json.loads(result.stdout)
    assert result.exit_code == 4
    assert (answer["met"], answer["amplitudes"]) == (False, [])
