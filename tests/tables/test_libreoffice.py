"""LibreOffice reads CSV and workbooks as they were written."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
from typing import TYPE_CHECKING, Any

import openpyxl
import pytest
from helpers.plans import Rows, swept, workbook

from vibro.files.csv_tables import CsvFormat
from vibro.sweeps.columns import Table, columns_of
from vibro.tables.sinks import csv_sink, write_table

if TYPE_CHECKING:
    from pathlib import Path

SOFFICE = shutil.which("soffice")
if SOFFICE is None and os.environ.get("VIBRO_OFFICE") != "required":
    pytest.skip("LibreOffice is not installed", allow_module_level=True)

ROUNDED = 1e-14
"""LibreOffice writes 15 digits, whatever it read."""
UTF_8, GERMAN, US = "76", "1031", "1033"


def converted(folder: Path, *paths: Path, separator: str = ",", language: str = US) -> list[Any]:
    """Open files in LibreOffice and save them as workbooks; return them as openpyxl reads them."""
    assert SOFFICE is not None
    # separator, quotation mark, characters, first line, columns, language, quoted texts stay texts, numbers
    csv = f"--infilter=CSV:{ord(separator)},34,{UTF_8},1,,{language},true,true"
    office = (SOFFICE, f"-env:UserInstallation={(folder / 'home').as_uri()}", "--headless")
    again = folder / f"again-{language}"
    subprocess.run(
        [*office, *([csv] if paths[0].suffix == ".csv" else []), "--convert-to", "xlsx",
         "--outdir", str(again), *map(str, paths)],
        check=True, capture_output=True, timeout=110,
    )  # fmt: skip
    return [openpyxl.load_workbook(again / path.with_suffix(".xlsx").name) for path in paths]


def same(found: object, given: object) -> bool:
    if isinstance(given, str) or given is None:
        return (found or None) == (given or None)
    assert isinstance(given, int | float)
    return isinstance(found, int | float) and math.isclose(found, given, rel_tol=ROUNDED, abs_tol=0.0)


def test_workbooks(tmp_path: Path) -> None:
    path = tmp_path / "map.xlsx"
    solved = swept(amplitude_mm="0.1:3:10", frequency_hz="5:60:11", trough_length_mm=600)
    given, _ = workbook(path, solved, name="=1+1")
    (again,) = converted(tmp_path, path)
    assert again.sheetnames == given.sheetnames
    numbers = 0
    for sheet in given:
        for row in sheet.iter_rows():
            for cell in row:
                there = again[sheet.title][cell.coordinate]
                assert same(there.value, cell.value), (sheet.title, cell.coordinate)
                assert there.data_type != "f"
                numbers += isinstance(cell.value, float)
    assert numbers > 1_000
    assert again["Summary"]["A1"].value == "=1+1"
    ((where, (rule,)),) = again["Speed"].conditional_formatting._cf_rules.items()
    assert (str(where.sqref), rule.type) == ("B3:L12", "colorScale")


@pytest.mark.parametrize(("form", "language"), [(CsvFormat(), US), (CsvFormat(decimal_comma=True), GERMAN)])
def test_csv(tmp_path: Path, form: CsvFormat, language: str) -> None:
    """A table with a point in an English one, a table with decimal commas in a German one."""
    grid = swept(amplitude_mm="0.1:3:10", frequency_hz="5:60:11")._grid
    rows, path = Rows(), tmp_path / "map.csv"
    table = Table(columns_of(grid.axes))
    with path.open("wb") as file:
        write_table(grid, table, [csv_sink(file, table, form), rows.write])
    (book,) = converted(tmp_path, path, separator=form.separator, language=language)
    header, *found = book.active.iter_rows(values_only=True)
    assert header == tuple(rows.cells[0])
    for row, cell in zip(found, rows.cells, strict=True):
        assert all(map(same, row, cell.values())), row
