"""Motions on the command line: steps from scene files, where they begin, stored and replaced."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from helpers.commands import Run
from helpers.periodic_tables import harmonics_of, read_rows

import vibro

pytestmark = pytest.mark.usefixtures("unsaved")

STEPS = "[motion]\nalong_steps = [[0.8, 2.4], [0.2, -9.6]]\n"
POINT = """
[scene]
frequency_hz = 2.5
static_friction = 0.3
kinetic_friction = 0.25
trough_length_mm = 3000
"""
MOTION = vibro.Motion.steps(along=[(0.8, 2.4), (0.2, -9.6)])


def written(folder: Path, text: str) -> Path:
    file = folder / "conveyor.toml"
    file.write_text(text, encoding="utf-8")
    return file


def scene(**fields: float) -> vibro.Scene:
    given = {"frequency": 2.5, "static_friction": 0.3, "kinetic_friction": 0.25, **fields}
    return vibro.Scene(motion=MOTION, **given)


def test_where_motions_of_steps_begin(run: Run, tmp_path: Path) -> None:
    told = json.loads(run("solve", written(tmp_path, POINT + STEPS), "--json").stdout)
    # the slide is p/2 (s + p/b) T^2 long, p = (9.6 c - f) s, b = 2.4 c + f, f = mu_d g, s = 0.2
    f = 0.25 * 9.81
    peak, fall = 0.2 * (9.6 - f), 2.4 + f
    power = 0.2 * 9.6 / peak + (0.2 * 9.6 / fall - peak * 2.4 / fall**2) / (0.2 + peak / fall)
    assert told["speed_amplitude_exponent"] == pytest.approx(power, rel=1e-9)
    # 0.3 g is the acceleration of the sharp stretch, then that of the gentle one
    first, then = 0.3 * 9.81 / 9.6, 0.3 * 9.81 / 2.4
    keys = "begins", "times_the_drive", "motion_scale", "until_times_the_drive"
    assert [tuple(row[key] for key in keys) for row in told["beginnings"]] == [
        (name, pytest.approx(scale, rel=1e-12), pytest.approx(scale, rel=1e-12), None)
        for name, scale in (("forward slip", first), ("back slip", then), ("continuous sliding", then))
    ]
    text = run("solve", written(tmp_path, POINT + STEPS), "--all").stdout
    assert " motion of 2 pieces, frequency 2.5 Hz, motion scale 1," in text
    assert "38.4 mm\n" in text


def test_intervals_of_classes_are_told(run: Run, tmp_path: Path) -> None:
    """Row 51 of critical_scales.csv: back slip ends and begins again before the hop."""
    row = read_rows("critical_scales")[51]
    text = "[scene]\n" + "".join(
        f"{name} = {row[name]}\n" for name in ("frequency_hz", "static_friction", "kinetic_friction")
    )
    text += "[motion]\n"
    for way in ("along", "normal"):
        pairs = [[1e3 * size, math.degrees(phase)] for size, phase in harmonics_of(row, way)]
        text += f"{way}_harmonics_mm_deg = {json.dumps(pairs)}\n"
    rows = json.loads(run("solve", written(tmp_path, text), "--json").stdout)["beginnings"]
    keys = "times_the_drive", "until_times_the_drive"
    told = [[r[key] for key in keys] for r in rows if r["begins"] == "back slip"]
    listed = json.loads(row["back_slip_intervals"])
    assert told == [pytest.approx(list(map(float, span)), rel=1e-9) for span in listed]
    assert (rows[-1]["begins"], rows[-1][keys[1]]) == ("hopping", None)


def test_a_map_with_pictures_says_what_was_given(run: Run, tmp_path: Path) -> None:
    file = written(tmp_path, f'{POINT}{STEPS}[map]\nmotion_scale = "0.2:3:12"\nfrequency_hz = "1:5:9"\n')
    assert run("map", file, "-o", tmp_path / "out").exit_code == 0
    content = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))
    assert content["motion"] == {"along_steps": [[0.8, 2.4], [0.2, -9.6]]}
    assert {"out-regime.png", "out-speed.png", "out-traverse.png"} <= {p.name for p in tmp_path.iterdir()}


def test_stored_sweeps_keep_their_motion(run: Run, tmp_path: Path) -> None:
    file = written(tmp_path, f'{POINT}{STEPS}[map]\nmotion_scale = "0.2:3:30"\nfrequency_hz = "1:5:20"\n')
    arguments = ("map", file, "-o", tmp_path / "stored.parquet")
    assert run(*arguments).exit_code == 0
    stored, swept = vibro.open_sweep(tmp_path / "stored.parquet"), vibro.sweep(file)
    speed = stored.to_frame()["mean_velocity_mm_s"].to_numpy().reshape(stored.shape)
    np.testing.assert_allclose(speed, 1e3 * swept.cycle.mean_velocity, rtol=1e-14)
    assert stored.fixed == swept.fixed
    assert stored.draw("speed").axes
    # another motion is another sweep
    other = f"{POINT}{STEPS}".replace("-9.6", "-9.61")
    written(tmp_path, f'{other}[map]\nmotion_scale = "0.2:3:30"\nfrequency_hz = "1:5:20"\n')
    refused = run(*arguments)
    assert refused.exit_code != 0
    assert "along_steps: [[0.8, 2.4], [0.2, -9.6]] there, [[0.8, 2.4], [0.2, -9.61]] here" in refused.stderr


def test_a_drive_of_the_command_line_replaces_the_motion(run: Run, tmp_path: Path) -> None:
    drive = ("-A", 1, "-a", 20, "-f", 15, "--mu-s", 0.74, "--mu-d", 0.57)
    here = json.loads(run("solve", written(tmp_path, POINT + STEPS), *drive, "--json").stdout)
    assert here["mean_velocity_mm_s"] == pytest.approx(16.263456166287, rel=1e-12)
    assert "motion_scale" not in here
