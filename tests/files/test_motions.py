"""The table [motion] of scene files, and clamped parts: what they give, and what is refused."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each
from jsonschema import Draft202012Validator

from vibro import InputError, read_scene
from vibro.files.descriptions import SCENE_FILE
from vibro.files.json_schema import schema_of
from vibro.files.scene_files import read_scene_file
from vibro.waveforms import HarmonicMotion, PiecewiseMotion

POINT = "[scene]\nfrequency_hz = 2.5\nstatic_friction = 0.3\nkinetic_friction = 0.25\n"
STEPS = "along_steps = [[0.8, 6.9], [0.2, -27.6]]\n"
SAMPLES = "[0, 1.4, 2, 1.4, 0, -1.4, -2, -1.4]"


def written(folder: Path, text: str) -> Path:
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return path


def refused(folder: Path, text: str) -> InputError:
    path = written(folder, text)
    with pytest.raises(InputError) as caught:
        read_scene(path)
    return caught.value


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
    a, b = (read_scene(written(tmp_path, POINT + text)) for text in (pairs, lists))
    assert a.along_harmonics == b.along_harmonics


@each(
    ("text", "problem", "hint"),
    [
        ("", "[motion] gives no motion", "[motion] for example: along_steps = [[0.8, 6.9], [0.2, -27.6]]"),
        (
            f"{STEPS}normal_samples_mm = {SAMPLES}",
            "[motion] gives along_steps and normal_samples_mm",
            "give both directions as harmonics, as steps or as samples of one kind",
        ),
        (
            f"along_samples_m_s2 = {SAMPLES}\nnormal_samples_mm = {SAMPLES}",
            "[motion] gives along_samples_m_s2 and normal_samples_mm",
            "give both directions",
        ),
        (
            "along_steps = 3",
            "[motion] along_steps = 3: must be a list of pairs of numbers",
            "write along_steps = [[0.8, 6.9], [0.2, -27.6]]",
        ),
        ("along_steps = [[0.8, 6.9, 1]]", "must be a list of pairs of numbers", "write along_steps"),
        ("along_steps = [[0.8, true]]", "must be a list of pairs of numbers", "write along_steps"),
        (
            "along_steps = [[0.8, 6.9], [0.2, -24]]",
            "[motion] along_steps = a mean acceleration of 0.72 m/s^2: must be at most 1 % of the largest:"
            " the trough comes back if the last is -27.6 m/s^2",
            "",
        ),
        (
            "normal_steps = [[0.8, 6.9], [0.3, -27.6]]",
            "[motion] normal_steps = shares of 1.1 in all: must be shares that add up to 1: give the last one"
            " 0.2",
            "",
        ),
        (
            "along_samples_mm = [1, 2, 3, 4, 5, 6, 7]",
            "[motion] along_samples_mm = [1, 2, 3, 4, 5, 6, ...]: must be a list of 8 to 4096 numbers",
            "write along_samples_mm = [0, 1.4, 2, 1.4, 0, -1.4, -2, -1.4]: one period, equally spaced",
        ),
        (
            f"along_samples_mm = {SAMPLES}\nnormal_samples_mm = [1, 2, 3, 4, 5, 6, 7, 8, 9]",
            "[motion] normal_samples_mm = 9 samples: must be as many as along_samples_mm, 8",
            "",
        ),
        (
            f"along_samples_m_s2 = [{'1' * 400}, 1, 1, 1, 1, 1, 1, 1]",
            "[motion] along_samples_m_s2 = a whole number of about 400 digits: must be a list of 8 to 4096",
            "",
        ),
        (
            "along_harmonics_mm_deg = [[-1, 0]]",
            "along amplitude = -1 mm: must be finite and >= 0 mm",
            "",
        ),
        (f"along_harmonics_mm_deg = {[[1, 0]] * 17}", "[motion] gives 17 harmonics", "give at most"),
        ("along_step = [[1, 0]]", "[motion] unknown key 'along_step'; did you mean 'along_steps'?", ""),
        ("amplitude_mm = 1", "[motion] unknown key 'amplitude_mm'; it belongs in [scene] or [map]", ""),
    ],
)
def test_what_is_wrong_in_a_motion_is_named(tmp_path: Path, text: str, problem: str, hint: str) -> None:
    error = refused(tmp_path, f"{POINT}[motion]\n{text}\n")
    assert problem in str(error)
    assert error.hint.startswith(hint)
    assert bool(error.hint) == bool(hint)


@each(
    ("scene", "motion", "problem"),
    [
        ("amplitude_mm = 1\ndrive_angle_deg = 20", STEPS, "[motion] gives motion: a drive has one motion"),
        ("along_amplitude_mm = 1", STEPS, "[scene] gives along amplitude and [motion] gives motion"),
        (
            "along_amplitudes_mm = [1, 2]",
            "along_harmonics_mm_deg = [[1, 0]]",
            "[motion] gives harmonics beside lists of [scene]",
        ),
        (
            "along_amplitude_mm = 1",
            "along_harmonics_mm_deg = [[1, 0]]",
            "along_amplitude_mm beside lists of harmonics",
        ),
        (
            "amplitude_mm = 1\ndrive_angle_deg = 20\nmotion_scale = 2",
            None,
            "[scene] gives amplitude, drive angle, motion scale: a drive along a line has no motion scale",
        ),
    ],
)
def test_two_drives_are_refused(tmp_path: Path, scene: str, motion: str | None, problem: str) -> None:
    table = "" if motion is None else f"[motion]\n{motion}"
    error = refused(tmp_path, f"{POINT}{scene}\n{table}")
    assert problem in str(error)
    assert error.hint


def test_a_motion_is_a_table(tmp_path: Path) -> None:
    assert "motion must be a table, written [motion]" in str(refused(tmp_path, f"motion = 1\n{POINT}"))


CLAMPED = "[motion]\n" + STEPS


def test_a_clamped_part_by_its_force_and_mass_or_their_quotient(tmp_path: Path) -> None:
    by_force = read_scene(written(tmp_path, f"{POINT}normal_force_n = 20\nmass_kg = 2.5\n{CLAMPED}"))
    by_quotient = read_scene(written(tmp_path, f"{POINT}normal_acceleration_m_s2 = 8\n{CLAMPED}"))
    assert by_force.normal_acceleration == by_quotient.normal_acceleration == 8.0
    vertical = written(tmp_path, f"{POINT}normal_acceleration_m_s2 = 8\ntrough_angle_deg = -90\n{CLAMPED}")
    assert float(read_scene(vertical).trough_angle) == -np.pi / 2
    assert read_scene(written(tmp_path, f"{POINT}{CLAMPED}")).normal_acceleration is None


@each(
    ("scene", "problem", "hint"),
    [
        ("mass_kg = 2", "[scene] mass_kg is given alone", "give normal_force_n and mass_kg, or normal_acc"),
        ("normal_force_n = 2", "[scene] normal_force_n is given alone", "give normal_force_n and mass_kg"),
        ("mass_kg = 0\nnormal_force_n = 2", "[scene] mass_kg = 0: must be finite and > 0 kg", ""),
        ("mass_kg = 1\nnormal_force_n = -2", "[scene] normal_force_n = -2: must be finite and > 0 N", ""),
        (
            "mass_kg = 1\nnormal_force_n = 2\nnormal_acceleration_m_s2 = 2",
            "[scene] normal_force_n beside normal_acceleration_m_s2",
            "give normal_force_n and mass_kg, or normal_acceleration_m_s2 alone",
        ),
        ("normal_acceleration_m_s2 = 0", "normal acceleration = 0 m/s^2: must be finite and > 0 m/s^2", ""),
        ("normal_acceleration_m_s2 = 9\ntrough_angle_deg = 90.1", "must be in [-90, 90] deg", ""),
        ("trough_angle_deg = 90", "trough angle = 90 deg: must be in (-90, 90) deg", ""),
    ],
)
def test_what_is_wrong_with_a_clamped_part_is_named(
    tmp_path: Path, scene: str, problem: str, hint: str
) -> None:
    error = refused(tmp_path, f"{POINT}{scene}\n{CLAMPED}")
    assert problem in str(error)
    assert error.hint.startswith(hint)


@pytest.mark.parametrize(
    ("drive", "problem"),
    [
        ("amplitude_mm = 1\ndrive_angle_deg = 0", "of a clamped part, whose trough moves along itself alone"),
        (
            "along_amplitude_mm = 1\nnormal_amplitude_mm = 0.1",
            "beside normal amplitude = 0.1 mm: the trough of a clamped part moves along itself alone",
        ),
        (
            "along_amplitude_mm = 1\nnormal_amplitude_mm = 0\nnormal_amplitude_2_mm = 1",
            "beside second normal amp",
        ),
    ],
)
def test_a_clamped_part_needs_a_motion_along_the_trough_alone(
    tmp_path: Path, drive: str, problem: str
) -> None:
    error = refused(tmp_path, f"{POINT}normal_acceleration_m_s2 = 9\n{drive}\n")
    assert "normal acceleration = 9 m/s^2" in str(error)
    assert problem in str(error)


@each(
    "text",
    [
        f"{POINT}[motion]\n{STEPS}",
        f"{POINT}[motion]\nalong_samples_mm = {SAMPLES}",
        f"{POINT}[motion]\nalong_harmonics_mm_deg = [[1, 0]]",
        f"{POINT}normal_acceleration_m_s2 = 9\ntrough_angle_deg = 90\n{CLAMPED}",
        f'{POINT}normal_force_n = 9\nmass_kg = 3\n{CLAMPED}[map]\nmotion_scale = "0.5:2"',
    ],
)
def test_the_schema_takes_what_is_read(tmp_path: Path, text: str) -> None:
    read_scene(written(tmp_path, text))
    assert Draft202012Validator(schema_of(SCENE_FILE)).is_valid(tomllib.loads(text))


@each(
    "text",
    ["along_steps = [[1]]", "along_steps = []", "along_samples_mm = [1, 2]", "along_steps = 1", "along = 1"],
)
def test_the_schema_marks_what_is_refused(text: str) -> None:
    assert not Draft202012Validator(schema_of(SCENE_FILE)).is_valid(tomllib.loads(f"[motion]\n{text}"))
