"""The table [motion] of scene files, and clamped parts: what they give, and what is refused."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from vibro import read_scene, solve
from vibro.drives import HarmonicMotion, PiecewiseMotion
from vibro.files.descriptions import SCENE_FILE
from vibro.files.json_schema import schema_of
from vibro.files.motions import harmonic_lists
from vibro.files.scene_files import read_scene_file
from vibro.quantities import QUANTITIES

POINT = "[scene]\nfrequency_hz = 2.5\nstatic_friction = 0.3\nkinetic_friction = 0.25\n"
STEPS = "along_steps = [[0.8, 6.9], [0.2, -27.6]]\n"
SAMPLES = "[0, 1.4, 2, 1.4, 0, -1.4, -2, -1.4]"
CLAMPED = "[motion]\n" + STEPS


def written(folder: Path, text: str) -> Path:
    """Write a file that the schema takes."""
    assert Draft202012Validator(schema_of(SCENE_FILE)).is_valid(tomllib.loads(text))
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_steps_and_their_scale(tmp_path: Path) -> None:
    text = f"{POINT}motion_scale = 0.5\n[motion]\n{STEPS}normal_steps = [[0.5, 1], [0.5, -1]]\n"
    path = written(tmp_path, text)
    scene = read_scene(path)
    assert isinstance(scene.motion, PiecewiseMotion)
    assert scene.motion.breaks.tolist() == [0.0, 0.5, 0.8, 1.0]
    np.testing.assert_allclose(
        scene.motion.pieces[:, :, 0], [[6.9, 6.9, -27.6], [1.0, -1.0, -1.0]], rtol=1e-14
    )
    assert scene.motion_scale == 0.5
    assert float(scene.load) == pytest.approx(0.5 * np.hypot(27.6, 1.0) / 9.81, rel=1e-14)
    given = read_scene_file(path).motion
    assert given is not None
    assert given.table == {"along_steps": [[0.8, 6.9], [0.2, -27.6]], "normal_steps": [[0.5, 1], [0.5, -1]]}


def test_samples_of_accelerations_and_of_displacements(tmp_path: Path) -> None:
    motion = read_scene(written(tmp_path, f"{POINT}[motion]\nalong_samples_m_s2 = {SAMPLES}\n")).motion
    assert isinstance(motion, PiecewiseMotion)
    np.testing.assert_allclose(motion.accelerations(np.arange(8) / 8)[0], tomllib.loads(f"x={SAMPLES}")["x"])
    motion = read_scene(written(tmp_path, f"{POINT}[motion]\nnormal_samples_mm = {SAMPLES}\n")).motion
    assert isinstance(motion, HarmonicMotion)
    assert motion.along == ()
    assert float(motion.normal[0][0]) == pytest.approx(2e-3, rel=0.01)


def test_pairs_of_harmonics_are_the_lists_of_a_scene(tmp_path: Path) -> None:
    pairs = "[motion]\nalong_harmonics_mm_deg = [[20, 0], [5, -110]]\nnormal_harmonics_mm_deg = [[1, 30]]\n"
    lists = (
        "along_amplitudes_mm = [20, 5]\nalong_phases_deg = [0, -110]\n"
        "normal_amplitudes_mm = [1, 0]\nnormal_phases_deg = [30, 0]\n"
    )
    here, there = (read_scene_file(written(tmp_path, POINT + text)) for text in (pairs, lists))
    assert here.motion is there.motion is None
    assert here.scene == there.scene


def test_a_clamped_part_by_its_force_and_mass_or_their_quotient(tmp_path: Path) -> None:
    by_force = read_scene(written(tmp_path, f"{POINT}normal_force_n = 20\nmass_kg = 2.5\n{CLAMPED}"))
    by_quotient = read_scene(written(tmp_path, f"{POINT}normal_acceleration_m_s2 = 8\n{CLAMPED}"))
    assert by_force.normal_acceleration == by_quotient.normal_acceleration == 8.0
    vertical = written(tmp_path, f"{POINT}normal_acceleration_m_s2 = 8\ntrough_angle_deg = -90\n{CLAMPED}")
    assert float(read_scene(vertical).trough_angle) == -np.pi / 2
    assert read_scene(written(tmp_path, f"{POINT}{CLAMPED}")).normal_acceleration is None


def test_harmonics_given_one_by_one_are_those_of_their_lists(tmp_path: Path) -> None:
    listed = {"along_amplitude": 1.5, "along_amplitude_2": 0.1, "along_phase_2": 30.0}
    others = {"normal_amplitude": 0.2, "frequency": 15.0, "static_friction": 0.3, "kinetic_friction": 0.25}
    lists, left = harmonic_lists(listed | others)
    assert left == others

    def speed(values: dict[str, Any]) -> float:
        lines = [f"{key} = {value}\n" for key, value in values.items()]
        return float(solve(read_scene(written(tmp_path, f"[scene]\n{''.join(lines)}"))).mean_velocity)

    columns = [{QUANTITIES[name].column: x for name, x in part.items()} for part in (listed, others)]
    assert speed(columns[0] | columns[1]) == speed(lists | columns[1]) != 0.0
