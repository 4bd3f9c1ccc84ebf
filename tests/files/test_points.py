"""Measured amplitudes over frequency: names, units, separators, and what is wrong with a file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.cases import each

from vibro.files.points import read_points

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def points(tmp_path: Path) -> Path:
    return tmp_path / "points.csv"


@each(
    "text",
    [
        "Frequency [Hz], A (mm) \n48, 0.2\n\n50, 0.35\n",
        "f in rpm;Stroke [um];note\n2880;400;first\n3000;700;\n",
        "Frequenz [Hz]\tHub [mm]\n48\t0,4\n50\t0,7\n",
        "f [Hz];A [\u00b5m]\n48;200\n50;350\n",
        "f [Hz];A [\u03bcm]\n48,0;200,0\n50,0;350,0\n",
        "f [rpm],A [um]\n48Hz,200\n3000,0.35mm\n",
    ],
)
@each("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_the_same_points_in_many_spellings(points: Path, text: str, encoding: str) -> None:
    points.write_bytes(text.encode(encoding))
    found = read_points(points)
    np.testing.assert_allclose(found.pairs, [[48.0, 0.2e-3], [50.0, 0.35e-3]], rtol=1e-15)
    assert found.error is None
    assert found.in_stroke == ("700" in text or "0,7" in text)


def test_an_older_spreadsheet_writes_micro_signs_in_its_code_page(points: Path) -> None:
    points.write_bytes("f [Hz];A [\u00b5m]\n48;200\n".encode("cp1252"))
    assert read_points(points).amplitude == pytest.approx([0.2e-3])


def test_errors_are_relative(points: Path) -> None:
    points.write_text("frequency_hz,amplitude_mm,error_percent\n48,0.2,2\n50,0.35,1.5\n", encoding="utf-8")
    error = read_points(points).error
    assert error is not None
    np.testing.assert_allclose(error, [0.02, 0.015])
