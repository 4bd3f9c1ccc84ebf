"""``vibro simulate``: its phase table, files and figure, and wrong input."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from commands import NUT, Run, rows_of
from made_records import EXAMPLES

SCENE = EXAMPLES / "safety_nut.toml"
# The cheapest picture, for tests that do not look at it.
PLAIN = ("--panels", "velocity")


def table_of(name: str) -> list[dict[str, str]]:
    return rows_of(Path(name).read_text(encoding="utf-8"))


def test_the_phase_table_is_printed(run: Run) -> None:
    result = run("simulate", SCENE, "--cycles", "3", "-o", "out/nut")
    assert result.exit_code == 0, result.stderr
    lines = [" ".join(line.split()) for line in result.stdout.splitlines()]
    assert lines[0] == "phase start [ms] end [ms] from [mm] to [mm] from [mm/s] to [mm/s]"
    assert lines[1] == "rest 0.00000 8.00900 0.00000 0.00000 0.00000 0.00000"
    assert lines[2] == "forward slide 8.00900 38.68329 0.00000 1.08423 0.00000 0.00000"
    assert lines[-2] == "after 0.2 s: 3.25269 mm along the trough"
    assert lines[-1] == "from 8.009 ms on the phases F_ repeat: 1.08423 mm a cycle"
    assert {p.name for p in Path("out").iterdir()} == {"nut.csv", "nut-phases.csv", "nut.json", "nut.png"}


def test_the_files(run: Run) -> None:
    assert run("simulate", SCENE, *PLAIN, "-o", "nut", "--format", "svg", "-q").exit_code == 0
    rows = table_of("nut.csv")
    assert len(rows) == 3 * 200 + 1 + 6
    phases = table_of("nut-phases.csv")
    assert [row["phase"] for row in phases] == ["rest", "forward slide"] * 3 + ["rest"]
    times = [row["time_s"] for row in rows]
    assert {row["start_s"] for row in phases} <= set(times)
    content = json.loads(Path("nut.json").read_text(encoding="utf-8"))
    assert content["files"] == ["nut.csv", "nut-phases.csv", "nut.svg", "nut.json"]
    assert content["cycles"] == 3
    assert content["samples_per_cycle"] == 200
    assert content["scene"]["kinetic_friction"] == 0.57


def test_files_are_written_where_that_is_asked_for(run: Run) -> None:
    for _ in range(2):
        for more in ((), ("--json",)):
            assert run("simulate", SCENE, *PLAIN, "--cycles", "1", *more).exit_code == 0
    assert list(Path().iterdir()) == []
    run("simulate", SCENE, *PLAIN, "--cycles", "1", "-o", "out/")
    assert Path("out/safety_nut-history.csv").exists()
    run("simulate", *NUT, *PLAIN, "--cycles", "1", "-o", "out/")
    assert Path("out/vibro-history.csv").exists()


def test_json_holds_every_phase(run: Run) -> None:
    result = run("simulate", SCENE, *PLAIN, "--cycles", "30", "--json", "-o", "nut")
    answer = json.loads(result.stdout)
    assert len(answer["phases"]) == 61
    assert answer["phases"][1]["end_position_mm"] == pytest.approx(1.0842304, rel=1e-7)
    assert "the picture shows the first 6 of 30 cycles" in result.stderr


def test_long_runs_print_the_first_phases(run: Run) -> None:
    result = run("simulate", SCENE, "--cycles", "1000", "--samples-per-cycle", "0", *PLAIN, "-o", "nut")
    assert "... 1977 more phases" in result.stdout
    assert "1084.23 mm along the trough" in result.stdout
    assert len(table_of("nut.csv")) == 2002


def test_a_duration_and_another_start(run: Run) -> None:
    result = run(
        "simulate",
        SCENE,
        "--duration",
        "50ms",
        "--start-phase",
        "180",
        "--start-velocity",
        "0.02m/s",
        "--json",
        *PLAIN,
    )
    assert result.exit_code == 0, result.stderr
    answer = json.loads(result.stdout)
    assert answer["cycles"] == pytest.approx(0.75)
    first = answer["phases"][0]
    assert first["phase"] == "forward slide"
    assert first["start_velocity_mm_s"] == pytest.approx(20.0)
    assert first["trough_phase_at_start_deg"] == pytest.approx(180.0)
    assert answer["phases"][-1]["end_s"] == pytest.approx(0.05)


def test_a_resting_body(run: Run) -> None:
    result = run("simulate", SCENE, *PLAIN, "-A", "0.5")
    assert result.exit_code == 0
    assert result.stdout.endswith("the body rests\n")


def test_the_motion_goes_to_stdout(run: Run) -> None:
    result = run("simulate", SCENE, "--cycles", "1", "-o", "-", "-q")
    assert result.exit_code == 0
    rows = rows_of(result.stdout)
    assert len(rows) == 203
    assert list(Path.cwd().iterdir()) == []


def test_its_table_can_be_compared_with_the_scene(run: Run) -> None:
    assert run("simulate", SCENE, *PLAIN, "--cycles", "8", "-o", "own", "-q").exit_code == 0
    result = run("compare", SCENE, "own.csv", "--json")
    assert result.exit_code == 0, result.stderr
    answer = json.loads(result.stdout)
    assert set(answer["columns"]) == {"time", "displacement", "velocity", "acceleration"}
    assert answer["columns"]["displacement"] == "relative_position_mm"
    figures = answer["figures"]
    assert figures["stroke_advance"]["measured"] == pytest.approx(
        figures["stroke_advance"]["computed"], rel=1e-5
    )
    period = 1 / 15
    shift = answer["trough_time_at_zero_s"]
    assert min(shift, period - shift) < 1e-5
    assert figures["rms_velocity"]["measured"] < 0.02


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("--cycles", "0"), "--cycles 0: must be finite and > 0"),
        (("--cycles", "nan"), "--cycles nan: must be finite"),
        (("--cycles", "2", "--duration", "1"), "--cycles and --duration are both given"),
        (("--duration", "-1"), "--duration -1: must be finite and > 0 s"),
        (("--duration", "1mm"), "'mm' is no unit of duration"),
        (("--start-velocity", "3Hz"), "'Hz' is no unit of start velocity"),
        (("--panels", "force"), "--panels force: 'force' is no panel"),
        (("--panels", "forces,forces"), "'forces' is named twice"),
        (("--samples-per-cycle", "-1"), "--samples-per-cycle -1: must be in [0, 5000000]"),
        (("--cycles", "1e6"), "more than 5e+06 rows"),
        (("-f", "10:20"), "takes one value"),
        (("--mu-d", "0.8"), "must be at most"),
    ],
)
def test_wrong_input_ends_with_code_2(run: Run, args: tuple[str, ...], said: str) -> None:
    result = run("simulate", SCENE, *args)
    assert result.exit_code == 2
    assert said in result.stderr
    assert list(Path.cwd().iterdir()) == []


def test_existing_files_are_kept(run: Run) -> None:
    assert run("simulate", SCENE, *PLAIN, "-o", "a").exit_code == 0
    before = Path("a.csv").read_bytes()
    result = run("simulate", SCENE, "-A", "2", "-o", "a")
    assert result.exit_code == 1
    assert "--force" in result.stderr
    assert Path("a.csv").read_bytes() == before
    assert run("simulate", SCENE, *PLAIN, "-A", "2", "-o", "a", "--force").exit_code == 0
    assert Path("a.csv").read_bytes() != before


def test_numbers_read_back_as_the_same_doubles(run: Run) -> None:
    run("simulate", SCENE, *PLAIN, "--cycles", "1", "-o", "a", "--decimal-comma", "--excel")
    text = Path("a.csv").read_text(encoding="utf-8")
    assert text.startswith("\ufefftime_s;trough_phase_deg;phase;")
    import vibro

    scene = vibro.Scene(
        amplitude=1e-3,
        frequency=15,
        drive_angle=np.radians(20),
        static_friction=0.74,
        kinetic_friction=0.57,
    )
    end = vibro.simulate(scene, cycles=1).phases[1].end
    assert str(end).replace(".", ",") in text
