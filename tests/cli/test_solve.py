"""``vibro solve``: the report, its JSON, and every way in which a scene can be wrong."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.commands import NUT, Run, rows_of

from vibro import Scene, Status, SteadyCycle, solve
from vibro.sweeps.columns import columns_of
from vibro.sweeps.derived import WITH_ACCELERATION, WITH_EXPONENT, WITH_MULTIPLIER, WITH_STROKE


def test_json_has_the_keys_of_a_table(run: Run) -> None:
    result = run("solve", *NUT, "--json")
    assert result.exit_code == 0
    assert result.stderr == ""
    answer = json.loads(result.stdout)
    extra = (WITH_STROKE, WITH_ACCELERATION, WITH_EXPONENT, WITH_MULTIPLIER)
    assert list(answer) == [column.name for column in columns_of((), *extra, made_with=["restitution"])]
    assert answer["mean_velocity_mm_s"] == pytest.approx(16.263456166287, rel=1e-13)
    assert answer["regime"] == "forward-slip"
    assert answer["pattern"] == "F_"
    assert answer["largest_multiplier"] == 0
    assert answer["status"] == "ok"
    assert answer["traverse_time_s"] is None
    assert answer["amplitude_mm"] == 1


def test_an_unresolved_scene_is_exit_code_3(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def doubtful(scene: Scene, **how: Any) -> SteadyCycle:
        return dataclasses.replace(solve(scene, **how), status=np.array(Status.UNRESOLVED, np.int8))

    monkeypatch.setattr("vibro.sweeps.grid.solve", doubtful)
    assert run("solve", *NUT, "--json").exit_code == 3


def test_the_length_gives_a_traverse_time(run: Run) -> None:
    answer = json.loads(run("solve", *NUT, "-L", "600", "--json").stdout)
    assert answer["traverse_time_s"] == pytest.approx(600 / answer["mean_velocity_mm_s"], rel=1e-15)


def test_the_report_says_what_a_practitioner_dials(run: Run) -> None:
    result = run("solve", *NUT)
    assert result.exit_code == 0
    lines = {line.split("  ")[0]: " ".join(line.split()) for line in result.stdout.splitlines()}
    assert lines["regime"] == "regime forward-slip, pattern F_"
    assert lines["mean speed"] == "mean speed 16.2635 mm/s"
    assert lines["peak speed"] == "peak speed 60.1496 mm/s"
    assert lines["per cycle"] == "per cycle 1.08423 mm"
    assert lines["acceleration"] == "acceleration 0.905468 g along the drive (machine number A w^2/g)"
    # Published: physics of the nut's scene, amplitudes at which the classes begin.
    assert lines["forward slip"].split()[2:4] == ["1.4595", "0.685165"]
    assert lines["back slip"].split()[3] == "1.1903"
    assert lines["hopping"].split()[2] == "3.22905"
    assert lines["forward slide"] == "forward slide 8.00900 38.68329 1.08423"
    assert lines["rest"] == "rest 38.68329 74.67567 0.00000"


def test_all_that_is_wrong_is_named_in_the_users_units(run: Run) -> None:
    result = run("solve", "-A", "-1", "-f", "nan", "-a", "95", "--mu-s", ".5", "--mu-d", ".6")
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.splitlines() == [
        "error: amplitude = -1 mm: must be finite and > 0 mm",
        "error: frequency = nan: must be a finite number",
        "error: drive angle = 95 deg: must be in [0, 90) deg",
        "error: kinetic friction = 0.6: must be at most static friction = 0.5",
    ]


@each(
    ("args", "problem"),
    [
        (("-A", "0"), "amplitude = 0 mm: must be finite and > 0 mm"),
        (("-A", "inf"), "amplitude = inf: must be a finite number"),
        (("--stroke", "-2"), "stroke = -2 mm: must be finite and > 0 mm"),
        (("-f", "0"), "frequency = 0 Hz: must be finite and > 0 Hz"),
        (("-a", "-1"), "drive angle = -1 deg: must be in [0, 90) deg"),
        (("-a", "90"), "drive angle = 90 deg: must be in [0, 90) deg"),
        (("--mu-s", "-0.1"), "static friction = -0.1: must be finite and >= 0"),
        (("--mu-d", "-0.1"), "kinetic friction = -0.1: must be finite and >= 0"),
        (("--mu-ratio", "1.1"), "friction ratio = 1.1: must be in [0, 1]"),
        (("--mu-ratio", "-0.1"), "friction ratio = -0.1: must be in [0, 1]"),
        (("--trough-angle", "90"), "trough angle = 90 deg: must be in (-90, 90) deg"),
        (("--gravity", "0"), "gravity = 0 m/s^2: must be finite and > 0 m/s^2"),
        (("--restitution", "1"), "restitution = 1: must be in [0, 1)"),
        (("-L", "0"), "trough length = 0 mm: must be finite and > 0 mm"),
        (("-f", "15mm"), "frequency = '15mm': 'mm' is no unit of frequency"),
        (("--mu-s", "0,74"), "static friction = '0,74': a decimal comma"),
        (("-A", "1:2"), "amplitude = 1 mm...2 mm: vibro solve takes one value"),
        (("-L", "1,2"), "trough length = 1 mm...2 mm: it cannot be an axis"),
    ],
)
def test_a_value_out_of_range_is_named(run: Run, args: tuple[str, str], problem: str) -> None:
    base = dict(zip(NUT[::2], NUT[1::2], strict=True))
    replaced = {"--stroke": "-A", "--mu-ratio": "--mu-d"}.get(args[0], args[0])
    base.pop(replaced, None)
    result = run("solve", *(part for pair in base.items() for part in pair), *args)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.splitlines()[0] == f"error: {problem}"


@pytest.mark.parametrize(
    ("args", "problem"),
    [
        (("--stroke", "2"), "the command line gives both amplitude and stroke"),
        (("--mu-ratio", "0.8"), "the command line gives both friction ratio and kinetic friction"),
    ],
)
def test_two_ways_of_the_same_exclude_each_other(run: Run, args: tuple[str, str], problem: str) -> None:
    result = run("solve", *NUT, *args)
    assert result.exit_code == 2
    assert result.stderr == f"error: {problem}\nhint: give one of them\n"


def test_what_is_missing_is_named_at_once_with_an_example_that_runs(run: Run) -> None:
    result = run("solve", "-A", "2", "--mu-s", "0.3")
    assert result.exit_code == 2
    error, hint = result.stderr.splitlines()
    assert error == (
        "error: missing: frequency (-f), drive angle (-a), kinetic friction (--mu-d or --mu-ratio)"
    )
    example = hint.removeprefix("hint: for example: vibro ")
    assert example.startswith("solve -A 2 --mu-s 0.3 ")
    assert run(*example.split()).exit_code == 0


@each(
    ("one", "other"),
    [
        (("--stroke", "2"), ("-A", "1")),
        (("--stroke", "2mm"), ("-A", "1000um")),
        (("-A", "0.05in"), ("-A", "1.27")),
        (("-f", "900rpm"), ("-f", "15")),
        (("-a", "20\u00b0"), ("--alpha", "20")),
        (("--mu-ratio", "0.5"), ("--mu-d", "0.37")),
    ],
)
def test_the_same_scene_in_other_words(run: Run, one: tuple[str, str], other: tuple[str, str]) -> None:
    base = dict(zip(NUT[::2], NUT[1::2], strict=True))
    for option in (one[0], other[0]):
        base.pop({"--stroke": "-A", "--mu-ratio": "--mu-d", "--alpha": "-a"}.get(option, option), None)
    common = [part for pair in base.items() for part in pair]
    first, second = (run("solve", *common, *given, "--json") for given in (one, other))
    assert first.exit_code == 0
    assert first.stdout == second.stdout


def facts(text: str) -> dict[str, str]:
    """Return the report's facts by name."""
    lines = text.partition("\n\n")[0].splitlines()
    return dict(re.split(r"  +", line, maxsplit=1) for line in lines)


def test_a_scene_that_hops_reports_its_flight(run: Run) -> None:
    answer = json.loads(run("solve", *NUT, "-A", "4", "--json").stdout)
    assert answer["model"] == "flight"
    result = run("solve", *NUT, "-A", "4")
    assert result.exit_code == 0
    told = facts(result.stdout)
    assert told["regime"] == f"hopping, pattern {answer['pattern']}"
    assert told["mean speed"] == f"{answer['mean_velocity_mm_s']:.6g} mm/s"
    assert told["in flight"] == f"{100 * answer['flight_fraction']:.6g} % of the time"
    assert told["impact speed"] == f"{answer['impact_speed_mm_s']:.6g} mm/s normal to the trough"
    assert told["repeats"] == "every drive cycle"
    assert "in flight" not in facts(run("solve", *NUT).stdout)


@pytest.mark.parametrize(
    "args", [("-A", "4"), ("-A", "8"), ("-A", "10", "-f", "25"), ("-A", "4", "--restitution", "0.3")]
)
def test_the_phases_of_a_hopping_cycle_fill_it(run: Run, args: tuple[str, ...]) -> None:
    answer = json.loads(run("solve", *NUT, *args, "--json").stdout)
    table = run("solve", *NUT, *args).stdout.split("\n\n")[-1].splitlines()
    assert table[0].split()[0] == "phase"
    rows = [re.split(r"  +", line) for line in table[1:]]
    names = [row[0] for row in rows]
    letters = {"H": "flight", "F": "forward slide", "B": "back slide", "_": "rest"}
    expected = [letters[letter] for letter in answer["pattern"]]
    if "--restitution" in args:  # one row stands for the last bounces of a landing
        flights = expected.index("forward slide")
        shown = names.index("short flights")
        assert 0 < shown < flights - 1
        expected[shown:flights] = ["short flights"]
    assert names == expected
    start, end, moved = np.array([row[1:] for row in rows], float).T
    np.testing.assert_array_equal(start[1:], end[:-1])
    period = 1e3 * answer["period_cycles"] / answer["frequency_hz"]
    assert end[-1] - start[0] == pytest.approx(period, abs=2e-5)
    advance = answer["displacement_per_cycle_mm"] * answer["period_cycles"]
    assert moved.sum() == pytest.approx(advance, abs=1e-4)
    aloft = sum(end[i] - start[i] for i, name in enumerate(names) if "flight" in name)
    assert aloft / period == pytest.approx(answer["flight_fraction"], abs=1e-5)


def test_longer_periods_are_counted(run: Run) -> None:
    throw_number_5 = ("-A", repr(5 / math.sin(math.radians(20)) * 9.81e3 / (30 * math.pi) ** 2))
    assert facts(run("solve", *NUT, *throw_number_5).stdout)["repeats"] == "every 2 drive cycles"


def test_a_mean_of_irregular_motion_has_its_error(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    import vibro.sweeps.grid
    from vibro.core.codes import Status
    from vibro.steady import solve

    def irregular(*args: Any, **how: Any) -> SteadyCycle:
        return dataclasses.replace(
            solve(*args, **how),
            status=np.array(Status.AVERAGED),
            period_cycles=np.array(np.nan),
            mean_velocity_error=np.array(1.25e-3),
        )

    monkeypatch.setattr(vibro.sweeps.grid, "solve", irregular)
    result = run("solve", *NUT, "-A", "4")
    assert result.exit_code == 0
    told = facts(result.stdout)
    assert told["mean speed"].endswith(" mm/s +- 1.2 mm/s (standard error)")
    assert told["repeats"] == "never: irregular motion"
    assert told["status"].startswith("averaged (")


@pytest.mark.parametrize("args", [("-A", "4", "--flight", "off"), ("--regimes-only",)])
def test_numbers_that_were_not_asked_for_are_not_there(run: Run, args: tuple[str, ...]) -> None:
    result = run("solve", *NUT, *args)
    assert result.exit_code == 0
    assert facts(result.stdout)["mean speed"] == "unknown"
    assert "nan" not in result.stdout
    assert "peak speed" not in result.stdout
    assert json.loads(run("solve", *NUT, *args, "--json").stdout)["mean_velocity_mm_s"] is None


TWO_CYCLES = ("-A", "1.647208", "-f", "15", "-a", "0.7034rad", "--mu-s", "0.457783", "--mu-d", "0.0429106")
"""The scene of docs/theory that conveys a pushed body otherwise."""
STEEP = (*NUT, "-a", "55", "--trough-angle", "31")
"""Gravity along the trough exceeds kinetic friction."""


@pytest.mark.parametrize(
    ("args", "coexists", "note"),
    [
        (NUT, 0, None),
        (TWO_CYCLES, 1, "settle into another steady motion"),
        ((*NUT, "-A", "0.1", "--trough-angle", "31"), 1, "a body pushed downhill runs away"),
        ((*NUT, "-A", "4"), None, None),
        ((*NUT, "-A", "4", "--coexist"), 0, "no other steady motion was found"),
        ((*NUT, "-A", "4.4", "--restitution", "0.4", "--coexist"), 1, "settle into another steady motion"),
        ((*STEEP, "-A", "6"), 1, "a body pushed downhill runs away"),
        ((*STEEP, "-A", "6", "--coexist"), 1, "a body pushed downhill runs away"),
    ],
)
def test_other_motions_are_told_where_they_were_looked_for(
    run: Run, args: tuple[str, ...], coexists: int | None, note: str | None
) -> None:
    assert json.loads(run("solve", *args, "--json").stdout)["coexists"] == coexists
    told = facts(run("solve", *args).stdout).get("note")
    assert told is None if note is None else note in str(told)


def test_minus_o_writes_the_row_beside_the_report(run: Run) -> None:
    result = run("solve", *NUT, "-o", "out/nut", "--json")
    assert result.exit_code == 0
    (row,) = rows_of(Path("out/nut.csv").read_text(encoding="utf-8"))
    answer = json.loads(result.stdout)
    assert float(row["mean_velocity_mm_s"]) == answer["mean_velocity_mm_s"]
    assert json.loads(Path("out/nut.json").read_text(encoding="utf-8"))["cells"] == 1
    assert run("solve", *NUT, "-o", "out/nut").exit_code == 1
    assert run("solve", *NUT, "-o", "out/nut", "--force").exit_code == 0


def test_minus_o_minus_puts_the_row_on_stdout(run: Run) -> None:
    result = run("solve", *NUT, "-o", "-")
    assert result.exit_code == 0
    header, row = result.stdout.splitlines()
    assert header == ",".join(column.name for column in columns_of(made_with=["restitution"]))
    assert row.startswith("1,15,20,0.74,0.57,0,forward-slip,F_,16.263456166287")
    clash = run("solve", *NUT, "-o", "-", "--json")
    assert clash.exit_code == 2
    assert clash.stderr.startswith("error: --json and -o - both want stdout\n")


@pytest.mark.parametrize(
    ("args", "upright", "ratio", "said"),
    [
        (("--stand-ratio", "0.74"), 1, 0.0, "yes: static friction is at most the stand ratio"),
        (("--stand-ratio", ".6"), 0, 1.72779, "no: an edge lifts above 0.578774 mm or 11.4116 Hz"),
        (("--stand-ratio", ".6", "-A", ".5"), 1, 0.863896, "yes: an edge would lift above 0.578774 mm"),
        (("--stand-ratio", ".7", "--trough-angle", "36"), 0, None, "no: an edge lifts under any drive"),
        (("--stand-ratio", ".8", "-A", "4"), None, 0.0, "unknown: the body hops, and may land on an edge"),
        (("--stand-ratio", ".7", "--trough-angle", "40"), None, None, "unknown: the body cannot rest"),
    ],
)
def test_a_part_stays_upright_or_does_not(
    run: Run, args: tuple[str, ...], upright: int | None, ratio: float | None, said: str
) -> None:
    answer = json.loads(run("solve", *NUT, *args, "--json").stdout)
    assert answer["upright"] == upright
    assert answer["tipping_load_ratio"] == (None if ratio is None else pytest.approx(ratio, rel=1e-5))
    told = facts(run("solve", *NUT, *args).stdout)["upright"]
    assert told.startswith(said)
    if ratio:
        assert told.endswith(f"(load now / then {ratio:g})")


def test_a_stand_ratio_that_is_none_is_refused(run: Run) -> None:
    for text, problem in (
        ("0", "stand ratio = 0: must be finite and > 0"),
        ("6mm", "stand ratio = '6mm': 'mm' is no unit of stand ratio"),
        ("wide", "stand ratio = 'wide': not a number"),
    ):
        result = run("solve", *NUT, "--stand-ratio", text)
        assert result.exit_code == 2
        assert result.stderr.startswith(f"error: {problem}\n")
