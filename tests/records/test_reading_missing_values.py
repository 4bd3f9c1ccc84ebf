"""Rows without a value: a few are skipped."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from helpers.cases import each
from helpers.made_tables import read


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


@each("rows", [(50, 51), tuple(range(10, 60, 10))])
def test_two_rows_in_succession_and_one_in_twenty_may_lack_a_value(
    tmp_path: Path, rows: tuple[int, ...]
) -> None:
    assert read(tmp_path, long(dict.fromkeys(rows, "0.1,"))).time.size == 100 - len(rows)


def test_a_row_may_lack_a_value_in_one_column_alone(tmp_path: Path) -> None:
    content = ["t [s],x [mm],v [mm/s]", *(f"{i},{i},{i}" for i in range(40))]
    content[5], content[9] = "4,,4", "8,8,NaN"
    record = read(tmp_path, content)
    assert record.time.tolist() == [i for i in range(40) if i not in (4, 8)]
    assert {values.size for values in record.signals.values()} == {38}


def test_a_row_apart_by_spaces_that_is_too_short_is_skipped(tmp_path: Path) -> None:
    """Nothing tells which of its cells is missing."""
    content = ["t x v", "s mm mm/s", *(f"{i}  {i}  {2 * i}" for i in range(40))]
    content[12] = "10      20"
    record = read(tmp_path, content, displacement="x")
    assert record.time.tolist() == [i for i in range(40) if i != 10]
    np.testing.assert_allclose(record.signals["displacement"], 1e-3 * record.time)


@each("fill", ["", "last"])
@each("every", [2, 4, 5])
def test_a_column_that_is_sampled_more_slowly(tmp_path: Path, every: int, fill: str) -> None:
    """Its own rows are used, whether the others are empty or repeat its value."""
    slow = [f"{(i // every) % 7 + 0.1 * (i // every)}" for i in range(80)]
    if not fill:
        slow = ["" if i % every else cell for i, cell in enumerate(slow)]
    content = ["t [s],a [g],x [mm]", *(f"{i},{i % 9},{cell}" for i, cell in enumerate(slow))]
    record = read(tmp_path, content, displacement="x")
    assert record.time.tolist() == [*range(0, 80, every)]
    np.testing.assert_allclose(record.signals["displacement"], [1e-3 * float(x) for x in slow[::every]])
