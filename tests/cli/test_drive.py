"""``vibro drive``: the set-up sheet, its files and JSON, and what it refuses."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from helpers.cases import each
from helpers.commands import Run, rows_of
from helpers.fed_machines import feeder, other, written

from vibro import Scene, Status, SteadyCycle, solve

BANDS = 'voltage_percent = "90:110"\nfilling_kg = "0:2"\n'
PACKS = '[[machine.pack]]\nname = "6 leaves"\nnatural_hz = 52.632\n'


def lines_of(text: str) -> dict[str, str]:
    """First words of each line, and the line with its blanks folded."""
    return {line.split("  ")[0]: " ".join(line.split()) for line in text.splitlines() if line.strip()}


def folded(text: str) -> str:
    return " ".join(text.split())


def test_the_sheet(run: Run, tmp_path: Path) -> None:
    result = run("drive", written(tmp_path, feeder(1.05, BANDS + PACKS)))
    assert result.exit_code == 0, result.stderr
    said, lines = folded(result.stdout), lines_of(result.stdout)
    assert "f/f0 = 1.05 empty, 1.064 full: 5 % above resonance when empty." in said
    assert "This filling brings less amplitude" in said
    assert "no filling brings the machine to resonance" in said
    assert "2 kg act like 0.2477 kg more of trough, a mass share of 12.4 %" in said
    assert "100 % empty 0.35 24.24 1.2 1.05 hopping" in said
    assert "100 % 2 kg 0.2518 16.4" in said
    assert "25 % 2 kg 0.02602 0 " in said
    assert lines["voltage 90 %"].startswith("voltage 90 % 0.2835 18.58")
    assert lines["frequency -1 %"].startswith("frequency -1 % 0.4345 35.3")
    assert lines["6 leaves"].startswith("6 leaves 52.63 0.95 1")
    assert lines["load-proof"].startswith("load-proof 86.6 0.577 20.6 0.35 24.24 0.3499")
    assert "It takes 20.6 times today's force" in said
    assert "for a trough that moves as a sine" in said
    assert "warning: the filling adds a second harmonic of up to 1 %" in result.stderr
    assert "* with the second harmonic that the filling gives its trough" in said
    assert [path.name for path in tmp_path.iterdir()] == ["feeder.toml"]


@pytest.mark.parametrize("kind", ["feeder", "unbalance", "crank", "exciter", "rod"])
def test_every_line_fits_into_80_columns(run: Run, tmp_path: Path, kind: str) -> None:
    text = feeder(1.05, BANDS + PACKS) if kind == "feeder" else other(kind)
    band = "0.3:0.4" if kind == "feeder" else "0.45:0.55"
    result = run("drive", written(tmp_path, text), "--mu-s", band, "-q")
    assert result.exit_code == 0, result.stderr
    assert result.stderr == ""
    assert max(map(len, result.stdout.splitlines())) <= 80


def test_a_sheet_with_an_unresolved_speed_is_exit_code_3(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import vibro.reports.set_up_sheet

    def doubtful(scene: Scene) -> SteadyCycle:
        cycle = solve(scene)
        cycle.status.flat[0] = Status.UNRESOLVED
        return cycle

    monkeypatch.setattr(vibro.reports.set_up_sheet, "solve", doubtful)
    assert run("drive", written(tmp_path, feeder(0.9, BANDS))).exit_code == 3


def test_below_resonance_a_filling_adds_amplitude(run: Run, tmp_path: Path) -> None:
    said = folded(run("drive", written(tmp_path, feeder(0.9, BANDS))).stdout)
    assert "10 % below resonance when empty. This filling brings more amplitude" in said
    assert "kg of filling, at this share, bring the machine to resonance" in said


def test_bands_of_options_replace_those_of_the_file(run: Run, tmp_path: Path) -> None:
    path = written(tmp_path, feeder(1.05, BANDS))
    told = json.loads(
        run(
            "drive", path, "--voltage", "95:105", "--filling", "1kg", "--mu-s", "0.32:0.38", "--mu-d",
            "0.26:0.30", "--setting", "50,100", "--json",
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
    fixed = json.loads(run("drive", path, "--voltage", "95", "--json").stdout)
    assert "voltage_percent" not in fixed["bands"]
    assert fixed["settings"][-1]["empty"]["voltage_percent"] == 95.0


def test_json_has_every_number_of_the_sheet(run: Run, tmp_path: Path) -> None:
    told = json.loads(run("drive", written(tmp_path, feeder(1.05, BANDS + PACKS)), "--json").stdout)
    assert [*told] == [
        "scene", "machine", "bands", "settings", "guaranteed", "changes", "least_filling", "sensitivities",
        "packs", "no_load_proof_pack", "resonant_filling_kg", "tolerated_filling_kg", "warnings",
    ]  # fmt: skip
    empty, full = (told["settings"][-1][state] for state in ("empty", "full"))
    assert empty["mean_velocity_mm_s"] == pytest.approx(24.24, abs=0.01)
    assert full["amplitude_mm"] == pytest.approx(0.2518, abs=1e-4)
    assert empty["added_mass_share"] is None
    assert empty["mean_velocity_with_second_harmonic_mm_s"] is None
    bent = full["mean_velocity_with_second_harmonic_mm_s"]
    assert full["second_harmonic_percent"] > 0.1
    assert 0.01 < abs(bent / full["mean_velocity_mm_s"] - 1.0) < 0.2
    assert told["resonant_filling_kg"] is None
    assert 0.02 < told["tolerated_filling_kg"] < 0.05
    assert [pack["name"] for pack in told["packs"]] == ["as fitted", "6 leaves", "load-proof"]
    assert [(row["changed"], row["value"]) for row in told["changes"]] == [
        ("voltage_percent", 90.0), ("voltage_percent", 110.0), ("frequency_hz", 49.5), ("frequency_hz", 50.5),
    ]  # fmt: skip
    low, high = told["guaranteed"][-1]["speed_mm_s"]
    assert low <= full["mean_velocity_mm_s"] <= empty["mean_velocity_mm_s"] <= high
    assert told["guaranteed"][-1]["proof"] == ["sampled", "sampled"]
    assert told["sensitivities"]["setting"]["empty"] is None
    assert told["machine"]["natural_hz"] == 50.0 / 1.05


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


def test_rates_that_are_all_unknown_are_one_line(run: Run, tmp_path: Path) -> None:
    path = written(tmp_path, feeder(1.05, BANDS))
    hopping = run("drive", path, "--setting", "200", "--voltage", "100", "--filling", "0.1").stdout
    assert "no rates for 1 % more: bodies hop, rest or never settle; see the table above" in hopping
    assert "1 % more of  " not in hopping
    sliding = lines_of(run("drive", path, "--setting", "70").stdout)
    assert not sliding["setting"].endswith("-")
    assert "1 % more of" in sliding


def test_a_pack_that_is_fitted(run: Run, tmp_path: Path) -> None:
    path = written(tmp_path, feeder(1.05, PACKS))
    said = folded(run("drive", path, "--pack", "6 leaves").stdout)
    assert "natural frequency 52.632 Hz" in said
    assert "fitted: 6 leaves 52.63 0.95 1" in said
    wrong = run("drive", path, "--pack", "7 leaves")
    assert wrong.exit_code == 2
    assert "6 leaves" in wrong.stderr


def test_settings_are_quarters_of_the_machines_own(run: Run, tmp_path: Path) -> None:
    path = written(tmp_path, feeder(1.05, "setting_percent = 80\n"))
    told = json.loads(run("drive", path, "--json").stdout)
    assert [row["empty"]["setting_percent"] for row in told["settings"]] == [20.0, 40.0, 60.0, 80.0]
    told = json.loads(run("drive", path, "--setting", "40:100", "--json").stdout)
    assert [row["empty"]["setting_percent"] for row in told["settings"]] == [40.0, 60.0, 80.0, 100.0]


@each(
    ("options", "says"),
    [
        (["--filling", "2:1"], "must be a value or lo:hi"),
        (["--filling", "-1:1"], "must be"),
        (["--voltage", "90:100:110"], "must be a value or lo:hi"),
        (["--voltage", "90:x"], "not a number"),
        (["--setting", "1:100:50"], "at most 12 settings"),
        (["--setting", "0"], "setting"),
        (["-A", "1"], "amplitude"),
        (["--law", "square"], "--law belongs to --fit"),
        (["--amplitude-error", "2%"], "--amplitude-error belongs to --fit"),
        (["--json", "-o", "-"], "both want stdout"),
        (["--format", "gif"], "not a format"),
    ],
)
def test_wrong_options(run: Run, tmp_path: Path, options: list[str], says: str) -> None:
    result = run("drive", written(tmp_path, feeder()), *options)
    assert result.exit_code == 2
    assert says in result.stderr
    assert result.stdout == ""


def test_files_without_a_machine_or_with_one_that_strikes(run: Run, tmp_path: Path) -> None:
    assert run("drive").exit_code == 2
    bare = run("drive", written(tmp_path, feeder().split("[machine]")[0], "bare"))
    assert bare.exit_code == 2
    assert "there is no table [machine]" in bare.stderr
    strikes = run("drive", written(tmp_path, feeder(1.05, "gap_mm = 0.3\n")))
    assert strikes.exit_code == 2
    assert "masses strike" in strikes.stderr
    hinted = strikes.stderr.partition("such as --setting ")[2].partition(",")[0]
    assert 50.0 < float(hinted) < 75.0
    lower = run("drive", written(tmp_path, feeder(1.05, "gap_mm = 0.3\n")), "--setting", hinted)
    assert lower.exit_code == 0, lower.stderr
    assert run("drive", tmp_path / "none.toml").exit_code == 1


def test_a_body_that_runs_away_has_no_speed(run: Run, tmp_path: Path) -> None:
    result = run("drive", written(tmp_path, feeder(1.05, BANDS)), "--trough-angle", "25", "--setting", "80")
    assert result.exit_code == 0, result.stderr
    said = folded(result.stdout)
    assert "80 % empty 0.28 - " in said
    assert "runaway" in said
    assert "unknown, as the empty trough has no speed" in said
    assert "setting 80 %: no speed is guaranteed" in result.stderr


def test_bands_of_friction_are_cut_where_kinetic_exceeds_static(run: Run, tmp_path: Path) -> None:
    path = written(tmp_path, feeder(1.05, BANDS))
    cut = json.loads(run("drive", path, "--mu-s", "0:0.5", "--setting", "20", "--json").stdout)
    whole = json.loads(run("drive", path, "--mu-s", "0.28:0.5", "--setting", "20", "--json").stdout)
    assert cut["guaranteed"][0]["amplitude_mm"] == whole["guaranteed"][0]["amplitude_mm"]
    ratio = run("drive", path, "--mu-ratio", "0.8", "--mu-s", "0.3:0.4")
    assert ratio.exit_code == 2
    assert "give --mu-d lo:hi" in ratio.stderr


def test_resonance_without_damping(run: Run, tmp_path: Path) -> None:
    path = written(tmp_path, feeder(1.25).replace("0.015", "0"))
    result = run("drive", path, "-f", "40")
    assert result.exit_code == 2
    assert "damping" in result.stderr


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


def test_the_fit(run: Run, points: Path) -> None:
    result = run("drive", "--fit", points, "--law", "constant")
    assert result.exit_code == 0, result.stderr
    lines = lines_of(result.stdout)
    assert lines["amplitude error"].endswith("from the residuals")
    assert lines["natural frequency [Hz]"].startswith("natural frequency [Hz] 52.99")
    assert lines["48"].startswith("48 0.165 ")
    assert 'kind = "measured"' in result.stdout
    assert max(map(len, result.stdout.splitlines()[2:])) <= 80
    pasted = result.stdout[result.stdout.index("[machine]") :]
    scene = feeder().split("[machine]")[0]
    bare = run("solve", written(points.parent, f"{scene}{pasted}", "pasted"))
    assert bare.exit_code == 2
    assert "trough_mass_kg is missing" in bare.stderr
    weighed = written(points.parent, f"{scene}{pasted}trough_mass_kg = 6\n", "pasted")
    solved = run("solve", weighed, "--json")
    assert solved.exit_code == 0, solved.stderr
    assert json.loads(solved.stdout)["frequency_ratio"] == pytest.approx(50.0 / 52.994, abs=1e-4)


def test_the_fit_as_json_and_files(run: Run, points: Path, tmp_path: Path) -> None:
    told = json.loads(
        run("drive", "--fit", points, "--law", "constant", "--amplitude-error", "2%", "--json").stdout
    )
    low, high = told["natural_frequency_hz"]["interval"]
    assert low < told["natural_frequency_hz"]["estimate"] < high
    assert told["amplitude_error_is"] == "stated"
    assert told["table"]["error_percent"] == pytest.approx([2.0] * 6)
    result = run("drive", "--fit", points, "--law", "constant", "-o", "fit")
    assert result.exit_code == 0, result.stderr
    rows = rows_of((tmp_path / "fit.csv").read_text(encoding="utf-8"))
    assert float(rows[0]["amplitude_mm"]) == pytest.approx(0.165)
    assert (tmp_path / "fit-response.png").stat().st_size > 10_000


def test_points_on_one_side_give_an_interval_alone(run: Run, points: Path) -> None:
    points.write_text("".join(POINTS.splitlines(keepends=True)[:4]), encoding="utf-8")
    result = run("drive", "--fit", points, "--law", "constant", "--amplitude-error", "2%")
    assert result.exit_code == 3
    assert "no estimate" in result.stdout
    assert "Measure at higher frequencies too" in result.stdout
    assert "[machine]" not in result.stdout
    lines = lines_of(result.stdout)
    assert lines["natural frequency [Hz]"].startswith("natural frequency [Hz] - ")
    told = json.loads(
        run("drive", "--fit", points, "--law", "constant", "--amplitude-error", "2%", "--json").stdout
    )
    assert told["natural_frequency_hz"]["estimate"] is None
    assert told["machine"] is None
    unknown = run("drive", "--fit", points, "--law", "constant")
    assert "--amplitude-error 2%" in unknown.stderr
    assert unknown.exit_code == 3


def test_a_fitted_machine_keeps_its_force(run: Run, points: Path, tmp_path: Path) -> None:
    """Nobody says at which setting the points were measured: the file's calibration stays."""
    path = written(tmp_path, feeder(1.05, "setting_percent = 80\n" + PACKS))
    told = json.loads(run("drive", path, "--fit", points, "--amplitude-error", "2%", "--json").stdout)
    assert told["machine"]["calibration"] == {"amplitude_mm": 0.35, "frequency_hz": 50}
    assert told["machine"]["pack"] == [{"name": "6 leaves", "natural_hz": 52.632}]
    result = run("drive", path, "--fit", points, "--amplitude-error", "2%")
    assert "warning: the points have" in result.stderr
    pasted = result.stdout[result.stdout.index("[machine]") :]
    solved = run("solve", written(tmp_path, feeder().split("[machine]")[0] + pasted, "pasted"), "--json")
    assert solved.exit_code == 0, solved.stderr
    assert json.loads(solved.stdout)["natural_hz"] == told["machine"]["natural_hz"]
    assert math.isclose(told["machine"]["natural_hz"], told["natural_frequency_hz"]["estimate"], rel_tol=1e-5)


@each(
    ("options", "says"),
    [
        ([], "--law constant"),
        (["--law", "cubic"], "must be constant or square"),
        (["--law", "constant", "--amplitude-error", "0"], "amplitude error"),
        (["--law", "constant", "--mu-s", "0.3"], "not used by --fit"),
        (["--law", "constant", "--pack", "x"], "not used by --fit"),
    ],
)
def test_wrong_options_of_the_fit(run: Run, points: Path, options: list[str], says: str) -> None:
    result = run("drive", "--fit", points, *options)
    assert result.exit_code == 2
    assert says in result.stderr


def test_laws_of_the_file(run: Run, points: Path, tmp_path: Path) -> None:
    unbalance = written(tmp_path, other("unbalance"), "unbalance")
    assert json.loads(run("drive", unbalance, "--fit", points, "--json").stdout)["law"] == "square"
    assert "has the law square" in run("drive", unbalance, "--fit", points, "--law", "constant").stderr
    crank = run("drive", written(tmp_path, other("crank"), "crank"), "--fit", points)
    assert crank.exit_code == 2
    assert "crank does not depend on frequency" in crank.stderr


def test_points_with_errors_of_their_own(run: Run, points: Path) -> None:
    points.write_text(
        "frequency_hz,amplitude_mm,error_percent\n48,0.15,2\n52,0.61,3\n54,0.65,3\n58,0.18,2\n",
        encoding="utf-8",
    )
    told = json.loads(run("drive", "--fit", points, "--law", "constant", "--json").stdout)
    assert told["table"]["error_percent"] == pytest.approx([2.0, 3.0, 3.0, 2.0])
    twice = run("drive", "--fit", points, "--law", "constant", "--amplitude-error", "2%")
    assert twice.exit_code == 2
    assert "column of errors" in twice.stderr
    points.write_text("frequency_hz,amplitude_mm\n48,0.15\n52,0.6\n", encoding="utf-8")
    assert "a fit needs 3 or more" in run("drive", "--fit", points, "--law", "constant").stderr


def test_the_pack_that_was_measured_is_fitted_too(run: Run, points: Path, tmp_path: Path) -> None:
    mine = f'[[machine.pack]]\nname = "mine"\nnatural_hz = {50.0 / 1.05!r}\n'
    path = written(tmp_path, feeder(1.05, PACKS + mine))
    told = json.loads(run("drive", path, "--fit", points, "--amplitude-error", "2%", "--json").stdout)
    fitted = {"name": "mine", "natural_hz": told["machine"]["natural_hz"]}
    assert told["machine"]["pack"] == [{"name": "6 leaves", "natural_hz": 52.632}, fitted]
