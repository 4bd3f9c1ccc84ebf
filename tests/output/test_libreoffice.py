"""Workbooks in LibreOffice: it reads what was written."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
from typing import TYPE_CHECKING, Any

import openpyxl
import pytest
from helpers.workbooks import grid_of, write

if TYPE_CHECKING:
    from pathlib import Path

SOFFICE = shutil.which("soffice")
if SOFFICE is None and os.environ.get("VIBRO_OFFICE") != "required":
    pytest.skip("LibreOffice is not installed", allow_module_level=True)

ROUNDED = 1e-14
"""LibreOffice writes 15 digits, whatever it read."""


def converted(folder: Path, *names: str) -> list[Any]:
    """Open workbooks in LibreOffice and save them anew; return them as openpyxl reads them."""
    assert SOFFICE is not None
    home, again = folder / "home", folder / "again"
    paths = [str(folder / name) for name in names]
    subprocess.run(
        [
            SOFFICE,
            f"-env:UserInstallation={home.as_uri()}",
            "--headless",
            "--convert-to",
            "xlsx",
            "--outdir",
            str(again),
            *paths,
        ],
        check=True,
        capture_output=True,
        timeout=110,
    )
    return [openpyxl.load_workbook(again / name) for name in names]


def same(found: object, given: object) -> bool:
    if isinstance(given, str) or given is None:
        return found == given
    assert isinstance(given, int | float)
    return isinstance(found, int | float) and math.isclose(found, given, rel_tol=ROUNDED, abs_tol=0.0)


def test_libreoffice_reads_every_value(tmp_path: Path) -> None:
    names = "map.xlsx", "line.xlsx"
    grids = [
        grid_of(amplitude_mm="0.1:3:10", frequency_hz="5:60:11", trough_angle_deg=8),
        grid_of(amplitude_mm="0.3:1.3:11", frequency_hz="15,20"),
    ]
    for name, grid in zip(names, grids, strict=True):
        with (tmp_path / name).open("wb") as file:
            write(file, grid, name="=1+1")
    numbers = 0
    for name, again in zip(names, converted(tmp_path, *names), strict=True):
        given = openpyxl.load_workbook(tmp_path / name)
        assert again.sheetnames == given.sheetnames
        for sheet in given:
            found = again[sheet.title]
            for row in sheet.iter_rows():
                for cell in row:
                    there = found[cell.coordinate]
                    assert same(there.value, cell.value), (sheet.title, cell.coordinate)
                    assert there.data_type != "f"
                    numbers += isinstance(cell.value, float)
            assert len(found._charts) == len(sheet._charts)
        table = again["Cells"].tables["Cells"]
        assert table.ref == table.autoFilter.ref == given["Cells"].tables["Cells"].ref
        assert again["Summary"]["A1"].value == "Sweep =1+1"
    assert numbers > 1_000
    again = openpyxl.load_workbook(tmp_path / "again" / "map.xlsx")
    ((where, (rule,)),) = again["Speed"].conditional_formatting._cf_rules.items()
    assert (str(where.sqref), rule.type) == ("B4:L13", "colorScale")
