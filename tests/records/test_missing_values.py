"""Rows without a value: a few are skipped and counted, more are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from helpers.cases import each
from helpers.made_tables import read, refusal


def long(lost: dict[int, str], count: int = 100) -> list[str]:
    """Write a table whose rows of data are numbered from 2, with other cells in some of them."""
    rows = {row: f"{(row - 2) / 600.0:.6f},{row}" for row in range(2, count + 2)}
    return ["t [s],x [mm]", *(rows | lost).values()]


@each("cell", ["", "NaN", "-nan", "+nan", "n/a", "NA", "#N/A", "null", "None", "-", "--", "?", "*", "***"])
@each("first", [2, 40, 100])
def test_a_few_rows_without_a_value_are_skipped_and_counted(tmp_path: Path, cell: str, first: int) -> None:
    record = read(tmp_path, long({first: f"0.1,{cell}", first + 1: f"{cell},3", 20: f"0.03,{cell}"}))
    assert record.time.size == 97
    kept = [row for row in range(2, 102) if row not in (first, first + 1, 20)]
    np.testing.assert_allclose(record.signals["displacement"], np.array(kept) / 1000)
    rows = ", ".join(map(str, sorted((first, first + 1, 20))))
    assert f"data.csv: 3 of 100 rows lack a value and are skipped: rows {rows}" in record.notes


def test_cells_of_columns_that_are_not_read_may_be_empty(tmp_path: Path) -> None:
    content = ["t [s],x [mm],v [mm/s]", *(f"{i},{i},{'' if i % 2 else i}" for i in range(10))]
    assert read(tmp_path, content, displacement="x").notes == (
        "time: column 't [s]'",
        "displacement: column 'x [mm]'",
    )
    assert "5 of 10 rows lack a value: at most 5 % are skipped" in str(refusal(tmp_path, content))


def test_one_row_too_many_without_a_value_is_refused(tmp_path: Path) -> None:
    assert read(tmp_path, long(dict.fromkeys(range(10, 60, 10), "0.1,"))).time.size == 95
    error = refusal(tmp_path, long(dict.fromkeys(range(10, 70, 10), "0.1,")))
    assert "row 10, column 'x [mm]': the cell is empty" in str(error)
    assert "column 'x [mm]': 1 more such cell" in str(error)
    assert error.problems[-1].endswith("6 of 100 rows lack a value: at most 5 % are skipped")


def test_two_rows_in_succession_may_lack_a_value_and_three_may_not(tmp_path: Path) -> None:
    assert read(tmp_path, long(dict.fromkeys((50, 51), "0.1,"))).time.size == 98
    error = refusal(tmp_path, long(dict.fromkeys((50, 51, 52), "0.1,")))
    assert "row 53, column 't [s]': time jumps to 0.085 s after 0.078333 s" in str(error)
    assert "as the 3 rows before it lack a value" in str(error)


def test_one_row_without_a_value_beside_a_gap_is_named_in_the_singular(tmp_path: Path) -> None:
    content = [*long({50: "0.1,"})[:50], *long({})[52:]]
    assert "as the row before it lacks a value" in str(refusal(tmp_path, content))


@each("cell", ["overflow", "inf", "-inf", "#DIV/0!", "error"])
def test_what_went_wrong_is_no_row_without_a_value(tmp_path: Path, cell: str) -> None:
    error = refusal(tmp_path, long({30: f"0.1,{cell}"}))
    assert f"row 30, column 'x [mm]': '{cell}' is not a number" in str(error)


@each(
    ("lost", "said"),
    [
        ([10], "1 of 200 rows lacks a value and is skipped: row 10"),
        ([10, 20], "2 of 200 rows lack a value and are skipped: rows 10, 20"),
        ([10, 20, 30, 40, 50], "5 of 200 rows lack a value and are skipped: rows 10, 20, 30, 40, 50"),
        (
            [10, 20, 30, 40, 50, 60, 70],
            "7 of 200 rows lack a value and are skipped: rows 10, 20, 30, 40, 50 and 2 more",
        ),
    ],
)
def test_five_skipped_rows_are_named_and_more_of_them_counted(
    tmp_path: Path, lost: list[int], said: str
) -> None:
    notes = read(tmp_path, long(dict.fromkeys(lost, "0.1,"), 200)).notes
    assert f"data.csv: {said}" in notes


def test_a_row_may_lack_a_value_in_one_column_alone(tmp_path: Path) -> None:
    content = ["t [s],x [mm],v [mm/s]", *(f"{i},{i},{i}" for i in range(40))]
    content[5], content[9] = "4,,4", "8,8,NaN"
    record = read(tmp_path, content)
    assert record.time.tolist() == [i for i in range(40) if i not in (4, 8)]
    assert {values.size for values in record.signals.values()} == {38}


def test_the_row_of_a_wrong_time_is_that_of_the_file_also_behind_skipped_rows(tmp_path: Path) -> None:
    content = long({5: "0.1,", 40: "0.01,3"})
    error = refusal(tmp_path, content)
    assert "row 40, column 't [s]': time goes back to 0.01 s after 0.061667 s" in str(error)
    assert "lack a value" not in str(error)
