"""docs/theory/validation.md: parts on a vibrating finger, as a laboratory measured them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each
from validation import (
    GRAVITY,
    MASS,
    MM,
    PAGE_FRICTION,
    SCRIPT_FRICTION,
    VARIANTS,
    Run,
    Trial,
    closed_form,
    compare_table,
    computed_advances,
    computed_speeds,
    known_runs,
    misses,
    read_table,
    repeating,
    walked_advances,
    walked_speeds,
)

PAGE = (Path(__file__).parents[1] / "docs" / "theory" / "validation.md").read_text(encoding="utf-8")
ROWS = {
    int(row[1]): row[0] for row in re.finditer(r"^\| (\d+) \|.*\|$", PAGE.split("## 67 runs")[0], flags=re.M)
}
TRIALS = read_table()
RUNS = known_runs()
MEASURED = np.array([run.speed for run in RUNS])


def row(trial: Trial) -> str:
    less, computed, _ = computed_advances(trial) / MM
    error = f" ± {trial.error / MM:.3f}" if trial.cycles > 1 else ""
    cells = (
        trial.number,
        f"{1.0 / trial.period:.1f}",
        f"{trial.force:.1f}",
        f"{trial.advance / MM:.3f}{error}",
        *(f"{advance:.3f}" for advance in (computed, less)),
    )
    return "| " + " | ".join(map(str, cells)) + " |"


def test_all_ten_trials_are_told() -> None:
    assert sorted(ROWS) == [trial.number for trial in TRIALS] == list(range(1, 11))


@each("trial", TRIALS)
def test_every_row_is_what_the_benchmark_computes(trial: Trial) -> None:
    assert ROWS[trial.number] == row(trial)


@each("trial", TRIALS)
def test_the_solver_agrees_with_a_walk_that_shares_nothing_with_it(trial: Trial) -> None:
    assert computed_advances(trial) == pytest.approx(walked_advances(trial), rel=0.0, abs=1e-12)


def test_what_the_page_says_of_all_ten() -> None:
    found = np.array([computed_advances(trial) for trial in TRIALS])
    measured = np.array([trial.advance for trial in TRIALS])
    share = found[:, 1] / measured
    assert np.flatnonzero(share < 0.0).tolist() == [2]
    assert np.sum(share < 1.0) == 9
    assert f"The median miss of all ten is {100.0 * np.median(np.abs(share - 1.0)):.0f} %" in PAGE
    assert f"the mean {np.mean(np.abs(found[:, 1] - measured)) / MM:.2f} mm" in PAGE
    loose = np.array([f"{trial.force:.1f}" == "5.3" for trial in TRIALS])
    assert (loose.sum(), np.sum(found[loose, 0] * found[loose, 1] < 0.0)) == (7, 5)


# ------------------------------------------------------------------------------
# The 67 runs.


def setting_rows() -> list[str]:
    """Rows of the page's table of settings."""
    computed, rows = computed_speeds(RUNS, SCRIPT_FRICTION), []
    settings = [run[:3] for run in RUNS]
    for setting in dict.fromkeys(settings):
        places = [i for i, other in enumerate(settings) if other == setting]
        shown = [places[0], places[len(places) // 2], places[-1]]
        frequency, rise, drop = setting
        miss = misses(computed[places], MEASURED[places]).median
        three = (
            ", ".join(f"{x:.{digits}f}" for x in values)
            for values, digits in (
                ([RUNS[i].force for i in shown], 0),
                (MEASURED[shown], 1),
                (computed[shown], 1),
            )
        )
        cells = (f"{frequency:.0f}", f"{rise}, {drop:.0f}", len(places), *three, f"{miss:+.0f} %")
        rows.append("| " + " | ".join(map(str, cells)) + " |")
    return rows


def variant_rows() -> list[str]:
    """Rows of the page's table of frictions and fingers."""
    rows = []
    for _, friction, repeats in VARIANTS:
        runs = repeating(RUNS) if repeats else RUNS
        finger = "as parts repeat" if repeats else "as commanded"
        for name, formula in (("solver", computed_speeds), ("closed form", closed_form)):
            median, absolute, _, wrong, rest = misses(formula(runs, friction), MEASURED)
            numbers = f"{median:+.1f} % | {absolute:.1f} % | {wrong} | {rest}"
            rows.append(f"| {friction[0]}, {friction[1]} | {finger} | {name} | {numbers} |")
    return rows


def test_the_page_shows_the_runs_as_the_benchmark_computes_them() -> None:
    assert len(RUNS) == 67
    for row in setting_rows() + variant_rows():
        assert row in PAGE


def test_what_the_page_says_of_the_runs() -> None:
    computed, slower = (
        computed_speeds(RUNS, SCRIPT_FRICTION),
        computed_speeds(repeating(RUNS), SCRIPT_FRICTION),
    )
    formula = closed_form(RUNS, SCRIPT_FRICTION)
    last = RUNS[-1]
    assert np.flatnonzero(computed * MEASURED < 0.0).tolist() == [66]
    assert computed[:-1] == pytest.approx(formula[:-1], rel=1e-12)
    assert f"{last.speed:.1f} ± {last.error:.1f} mm/s" in PAGE
    assert f"the closed form gives {formula[-1]:.0f}" in PAGE
    assert f"but gives {computed[-1]:.0f}:" in PAGE
    assert f"carries {SCRIPT_FRICTION[0] * last.force / MASS / GRAVITY - 1.0:.2f} g" in PAGE
    enough, short = (computed_speeds([last._replace(force=x)], SCRIPT_FRICTION)[0] for x in (31.93, 31.92))
    assert enough == pytest.approx(58.0, abs=0.5)
    assert short < 0.0
    weak = np.array([run.drop == 5.0 for run in RUNS])
    share = 100.0 * (computed[weak] / MEASURED[weak] - 1.0)
    assert weak.sum() == 11
    assert f"by {share.min():.0f} to {share.max():.0f} %" in PAGE
    assert slower[-1] > 10.0 * MEASURED[-1]
    strong = np.array([run.drop > 5.0 and run.force > 34.0 for run in RUNS])
    assert strong.sum() == 44
    assert f"(44 runs) {misses(computed[strong], MEASURED[strong]).median_absolute:.0f} %" in PAGE
    resting = computed_speeds(RUNS, PAGE_FRICTION) == 0.0
    assert (resting & weak).sum() == resting.sum() == 10
    frequencies = sorted({run.frequency for run in repeating(RUNS)})
    assert "{1:.2f} and {0:.2f} times a second".format(*frequencies) in PAGE


@each(
    ("friction", "runs"), [(SCRIPT_FRICTION, RUNS), (SCRIPT_FRICTION, repeating(RUNS)), (PAGE_FRICTION, RUNS)]
)
def test_the_solver_agrees_with_the_walk_on_the_runs(friction: tuple[float, float], runs: list[Run]) -> None:
    assert computed_speeds(runs, friction) == pytest.approx(walked_speeds(runs, friction), rel=0.0, abs=1e-10)


# ------------------------------------------------------------------------------
# Tables of others.

TABLE = f"""{re.findall("^amplitude_mm.*$", PAGE, re.MULTILINE)[0]}
1.0,15,20,0.74,0.57,17.1,2,"A. Smith, bench 3"
0.2,15,20,0.74,0.57,0,2,a
"""


def test_a_table_of_measured_speeds_stands_beside_the_model(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "table.csv"
    path.write_text(TABLE)
    miss = compare_table(path)
    assert miss.median == pytest.approx(100.0 * (16.263 / 17.1 - 1.0), abs=0.01)  # vibro.sweep's own example
    assert (
        "  2    17.100 +-   0.342     16.263            -4.9      -2.4  A. Smith, bench 3"
        in capsys.readouterr().out
    )
