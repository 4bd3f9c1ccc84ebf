"""LibreOffice reads workbooks as they were written."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
from typing import TYPE_CHECKING, Any

import openpyxl
import pytest
from helpers.plans import swept, workbook

if TYPE_CHECKING:
    from pathlib import Path

SOFFICE = shutil.which("soffice")
if SOFFICE is None and os.environ.get("VIBRO_OFFICE") != "required":
    pytest.skip("LibreOffice is not installed", allow_module_level=True)

ROUNDED = 1e-14
"""LibreOffice writes 15 digits, whatever it read."""


def converted(folder: Path, path: Path) -> Any:
    """Open a workbook in LibreOffice and save it again; return it as openpyxl reads it."""
    assert SOFFICE is not None
    office = (SOFFICE, f"-env:UserInstallation={(folder / 'home').as_uri()}", "--headless")
    convert = ("--convert-to", "xlsx", "--outdir", str(folder / "again"), str(path))
    subprocess.run([*office, *convert], check=True, capture_output=True, timeout=110)
    return openpyxl.load_workbook(folder / "again" / path.name)


def same(found: object, given: object) -> bool:
    if isinstance(given, str) or given is None:
        return (found or None) == (given or None)
    assert isinstance(given, int | float)
    return isinstance(found, int | float) and math.isclose(found, given, rel_tol=ROUNDED, abs_tol=0.0)


def test_workbooks(tmp_path: Path) -> None:
    path = tmp_path / "map.xlsx"
    solved = swept(amplitude_mm="0.1:3:10", frequency_hz="5:60:11", trough_length_mm=600)
    given, _ = workbook(path, solved, name="=1+1")
    again = converted(tmp_path, path)
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
