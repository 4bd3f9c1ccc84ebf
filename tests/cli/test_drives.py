"""Drives on the command line: options, lists and steps of scene files, replaced, swept and stored."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.commands import ELLIPSE, NUT, STEPS_FILE, Run, other, rows_of

import vibro

pytestmark = pytest.mark.usefixtures("unsaved")

BODY = "frequency_hz = 25\nstatic_friction = 0.4\nkinetic_friction = 0.3\n"
LINE = f"[scene]\namplitude_mm = 1\ndrive_angle_deg = 20\n{BODY}"
ON_ELLIPSE = f"[scene]\nalong_amplitude_mm = 1\nnormal_amplitude_mm = 0.3\nnormal_phase_deg = -60\n{BODY}"
HARMONICS = f"[scene]\nalong_amplitudes_mm = [1, 0.3]\nalong_phases_deg = [0, 90]\n{BODY}"


def written(text: str) -> Path:
    file = Path("drive.toml")
    file.write_text(text, encoding="utf-8")
    return file


def test_a_drive_given_whole_takes_the_place_of_a_file_s(run: Run) -> None:
    answer = json.loads(run("solve", written(LINE), "along=1", "normal=.3", "phase=-60", "--json").stdout)
    assert answer["mean_velocity_mm_s"] == pytest.approx(89.0577, rel=1e-6)
    assert "amplitude_mm" not in answer
    file = written(ON_ELLIPSE)
    assert json.loads(run("solve", file, "phase=30", "--json").stdout)["normal_phase_deg"] == 30.0
    for text in (ON_ELLIPSE, HARMONICS, STEPS_FILE):
        answer = json.loads(run("solve", written(text), "--stroke", "2", "-a", "20", "--json").stdout)
        assert (answer["amplitude_mm"], answer["drive_angle_deg"]) == (1.0, 20.0)
        assert "motion_scale" not in answer


def test_a_file_s_map_may_sweep_another_drive_than_its_scene(run: Run) -> None:
    table = '[map]\nalong_amplitude_mm = "0.5:1.5:3"\nnormal_amplitude_mm = 0.3\n'
    rows = rows_of(run("map", written(LINE + table), "-o", "-").stdout)
    assert [row["along_amplitude_mm"] for row in rows] == ["0.5", "1", "1.5"]
    assert {row["normal_phase_deg"] for row in rows} == {"0"}


def test_an_option_replaces_an_entry_of_a_list_and_is_an_axis(run: Run) -> None:
    file = written(HARMONICS)
    forth, back = (
        json.loads(run("solve", file, f"along_phase_2={phase}", "--json").stdout)["mean_velocity_mm_s"]
        for phase in (-90, 90)
    )
    assert forth == pytest.approx(-back, rel=1e-13)
    answer = json.loads(run("solve", file, "normal=0.2", "normal_2=0.1", "--json").stdout)
    expected = {"normal_amplitude_mm": 0.2, "normal_amplitude_2_mm": 0.1, "normal_phase_2_deg": 0}
    assert answer.items() >= expected.items()
    result = run("map", file, "along_2=0:.3:4", "along_phase_2=-90:90:3", "-o", "x")
    assert result.exit_code == 0, result.stderr
    rows = rows_of(Path("x.csv").read_text(encoding="utf-8"))
    assert len(rows) == 12
    assert [name for name in rows[0] if "_2_" in name] == ["along_amplitude_2_mm", "along_phase_2_deg"]
    assert {"x-regime.png", "x-speed.png"} <= {path.name for path in Path().iterdir()}


@pytest.mark.parametrize(
    ("drive", "sizes"),
    [
        (NUT, {"-A": "amplitude_mm"}),
        (ELLIPSE, {"along=": "along_amplitude_mm", "normal=": "normal_amplitude_mm"}),
    ],
    ids=["line", "ellipse"],
)
def test_each_regime_begins_where_the_report_says(
    run: Run, drive: tuple[str, ...], sizes: dict[str, str]
) -> None:
    known = json.loads(run("solve", *drive, "--json").stdout)
    begun = {"forward slip": "forward-slip", "back slip": "back-slip", "hopping": "hopping"}
    rows = {row["begins"]: row for row in known["beginnings"] if row["begins"] in begun}
    assert {"forward slip", "hopping"} <= {*rows}
    for name, row in rows.items():
        regimes = []
        for factor in (1.0 - 1e-4, 1.0 + 1e-4):
            times = factor * row["times_the_drive"]
            texts = {name: repr(times * known[column]) for name, column in sizes.items()}
            larger = [f"{name}{text}" if name.endswith("=") else name for name, text in texts.items()]
            larger += [text for name, text in texts.items() if not name.endswith("=")]
            for given in (other(drive, *larger), other(drive, "-f", repr(factor * row["frequency_hz"]))):
                regimes.append(json.loads(run("solve", *given, "--json").stdout)["regime"])
        assert regimes[2] == regimes[3] == begun[name]
        assert begun[name] not in regimes[:2]


def test_where_motions_of_steps_begin(run: Run) -> None:
    told = json.loads(run("solve", written(STEPS_FILE), "--json").stdout)
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


def test_stored_sweeps_keep_their_motion(run: Run) -> None:
    axes = '[map]\nmotion_scale = "0.2:3:12"\nfrequency_hz = "1:5:9"\n'
    file = written(STEPS_FILE + axes)
    arguments = ("map", file, "-o", "stored.parquet")
    assert run(*arguments).exit_code == 0
    stored, swept = vibro.open_sweep("stored.parquet"), vibro.sweep(file)
    speed = stored.to_frame()["mean_velocity_mm_s"].to_numpy().reshape(stored.shape)
    np.testing.assert_allclose(speed, 1e3 * swept.cycle.mean_velocity, rtol=1e-14)
    assert stored.fixed == swept.fixed
    assert stored.draw("speed").axes
    # another motion is another sweep
    written(STEPS_FILE.replace("-9.6", "-9.61") + axes)
    refused = run(*arguments)
    assert refused.exit_code != 0
    assert "along_steps: [[0.8, 2.4], [0.2, -9.6]] there, [[0.8, 2.4], [0.2, -9.61]] here" in refused.stderr
