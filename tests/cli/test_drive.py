"""``vibro drive``: the set-up sheet, its files and JSON, and what it refuses."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.commands import Run, rows_of
from helpers.fed_machines import feeder, written

from vibro import Scene, Status, SteadyCycle, solve

if TYPE_CHECKING:
    from pathlib import Path

BANDS = 'voltage_percent = "90:110"\nfilling_kg = "0:2"\n'
PACKS = '[[machine.pack]]\nname = "6 leaves"\nnatural_hz = 52.632\n'


def test_a_sheet_with_an_unresolved_speed_is_exit_code_3(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import vibro.answers.set_up_sheet

    def doubtful(scene: Scene) -> SteadyCycle:
        cycle = solve(scene)
        cycle.status.flat[0] = Status.UNRESOLVED
        return cycle

    monkeypatch.setattr(vibro.answers.set_up_sheet, "solve", doubtful)
    assert run("drive", written(tmp_path, feeder(0.9, BANDS))).exit_code == 3


def test_bands_of_options_replace_those_of_the_file(run: Run, tmp_path: Path) -> None:
    path = written(tmp_path, feeder(1.05, BANDS))
    told = json.loads(
        run(
            "drive", path, "voltage=95:105", "filling=1kg", "--mu-s", "0.32:0.38", "--mu-d",
            "0.26:0.30", "setting=50, 100", "--json",
        ).stdout
    )  # fmt: skip
    assert told["bands"] == {
        "voltage_percent": [95.0, 105.0],
        "filling_kg": [1.0, 1.0],
        "static_friction": [0.32, 0.38],
        "kinetic_friction": [0.26, 0.3],
    }
    assert [row["empty"]["setting_percent"] for row in told["settings"]] == [50.0, 100.0]
    assert told["scene"]["static_friction"] == 0.35  # the file's own, as it lies within the band
    outside = json.loads(run("drive", path, "--mu-s", "0.4:0.5", "--json").stdout)
    assert outside["scene"]["static_friction"] == pytest.approx(0.45)
    fixed = json.loads(run("drive", path, "voltage=95", "--json").stdout)
    assert "voltage_percent" not in fixed["bands"]
    assert fixed["settings"][-1]["empty"]["voltage_percent"] == 95.0


def test_json_has_every_number_of_the_sheet(run: Run, tmp_path: Path) -> None:
    told = json.loads(run("drive", written(tmp_path, feeder(1.05, BANDS + PACKS)), "--json").stdout)
    assert [*told] == [
        "scene", "machine", "bands", "settings", "bounds", "changes", "sensitivities", "packs",
        "no_load_proof_pack", "resonant_filling_kg", "tolerated_filling_kg", "notes",
    ]  # fmt: skip
    empty, full = (told["settings"][-1][state] for state in ("empty", "full"))
    assert empty["mean_velocity_mm_s"] == pytest.approx(24.24, abs=0.01)
    assert full["amplitude_mm"] == pytest.approx(0.2527, abs=1e-4)
    assert empty["added_mass_share"] is None
    assert empty["mean_velocity_with_second_harmonic_mm_s"] is None
    assert told["resonant_filling_kg"] is None
    assert 0.02 < told["tolerated_filling_kg"] < 0.05
    assert [pack["name"] for pack in told["packs"]] == ["as fitted", "6 leaves", "load-proof"]
    low, high = told["bounds"][-1]["speed_mm_s"]
    assert low <= full["mean_velocity_mm_s"] <= empty["mean_velocity_mm_s"] <= high
    assert told["bounds"][-1]["proof"] == ["sampled", "sampled"]
    assert told["machine"]["natural_hz"] == 50.0 / 1.05


@pytest.mark.usefixtures("unsaved")
def test_files(run: Run, tmp_path: Path) -> None:
    path = written(tmp_path, feeder(1.05, BANDS))
    result = run("drive", path, "-o", "out/sheet")
    assert result.exit_code == 0, result.stderr
    names = ["sheet-response.png", "sheet.csv", "sheet.json"]
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == names
    rows = rows_of((tmp_path / "out/sheet.csv").read_text(encoding="utf-8"))
    assert [*rows[0]][:6] == [
        "case", "setting_percent", "voltage_percent", "filling_kg", "frequency_hz", "natural_hz",
    ]  # fmt: skip
    assert len(rows) == 2 * (4 + 4 + 2)
    record = json.loads((tmp_path / "out/sheet.json").read_text(encoding="utf-8"))
    assert record["files"] == ["sheet.csv", "sheet-response.png", "sheet.json"]
    by_case = {(row["case"], float(row["setting_percent"]), float(row["filling_kg"])): row for row in rows}
    full = record["settings"][-1]["full"]
    assert float(by_case["setting", 100.0, 2.0]["mean_velocity_mm_s"]) == full["mean_velocity_mm_s"]
    again = run("drive", path, "-o", "out/sheet")
    assert again.exit_code == 1
    assert "--force" in again.stderr
    table = run("drive", path, "-o", "-", "-q")
    assert rows_of(table.stdout) == rows


POINTS = """f [Hz];stroke [mm]
48,0;0,330
50,0;0,508
52,0;1,120
54,0;1,065
56,0;0,492
58,0;0,294
"""


@pytest.fixture
def points(tmp_path: Path) -> Path:
    path = tmp_path / "points.csv"
    path.write_text(POINTS, encoding="utf-8")
    return path


def test_the_fit_as_json_and_files(run: Run, points: Path, tmp_path: Path) -> None:
    told = json.loads(
        run("drive", "--fit", points, "--law", "constant", "--amplitude-error", "2%", "--json").stdout
    )
    low, high = told["natural_frequency_hz"]["interval"]
    assert low < told["natural_frequency_hz"]["estimate"] < high
    assert told["amplitude_error_is"] == "stated"
    assert told["table"]["error_percent"] == pytest.approx([2.0] * 6)
    measured, fitted, off = (
        np.array(told["table"][name])
        for name in ("amplitude_mm", "fitted_amplitude_mm", "difference_percent")
    )
    np.testing.assert_allclose(measured / fitted - 1.0, off / 100.0, rtol=1e-9)
    assert np.abs(off).max() > 0.1
    result = run("drive", "--fit", points, "--law", "constant", "-o", "fit")
    assert result.exit_code == 0, result.stderr
    rows = rows_of((tmp_path / "fit.csv").read_text(encoding="utf-8"))
    assert float(rows[0]["amplitude_mm"]) == pytest.approx(0.165)
    assert (tmp_path / "fit-response.png").stat().st_size > 10_000


def test_points_on_one_side_give_an_interval_alone(run: Run, points: Path) -> None:
    points.write_text("".join(POINTS.splitlines(keepends=True)[:4]), encoding="utf-8")
    result = run("drive", "--fit", points, "--law", "constant", "--amplitude-error", "2%", "--json")
    assert result.exit_code == 3
    told = json.loads(result.stdout)
    assert told["natural_frequency_hz"]["estimate"] is None
    assert told["machine"] is None


def test_a_fitted_machine_keeps_its_force(run: Run, points: Path, tmp_path: Path) -> None:
    """Nobody says at which setting the points were measured: the file's calibration stays."""
    path = written(tmp_path, feeder(1.05, "setting_percent = 80\n" + PACKS))
    told = json.loads(run("drive", path, "--fit", points, "--amplitude-error", "2%", "--json").stdout)
    assert told["machine"]["calibration"] == {"amplitude_mm": 0.35, "frequency_hz": 50}
    assert told["machine"]["pack"] == [{"name": "6 leaves", "natural_hz": 52.632}]
    result = run("drive", path, "--fit", points, "--amplitude-error", "2%")
    pasted = result.stdout[result.stdout.index("[machine]") :]
    solved = run("solve", written(tmp_path, feeder().split("[machine]")[0] + pasted, "pasted"), "--json")
    assert solved.exit_code == 0, solved.stderr
    assert json.loads(solved.stdout)["natural_hz"] == told["machine"]["natural_hz"]
    assert math.isclose(told["machine"]["natural_hz"], told["natural_frequency_hz"]["estimate"], rel_tol=1e-5)
