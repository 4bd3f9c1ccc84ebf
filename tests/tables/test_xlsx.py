"""Workbooks: the numbers of the sweep, results over two axes in colours, and texts that nobody runs."""

from __future__ import annotations

import io
import zipfile
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from helpers.cases import each
from helpers.plans import swept, workbook
from matplotlib.figure import Figure

import vibro
from vibro.errors import InputError
from vibro.plots.style import REGIME_COLOURS
from vibro.sweeps.columns import columns_of
from vibro.tables import xlsx

MAP: dict[str, Any] = {"amplitude_mm": "0.1:3:5", "frequency_hz": "5:60:6", "trough_length_mm": 600}
ELLIPSE: dict[str, Any] = {"along_amplitude_mm": 0.5, "normal_amplitude_mm": 0.3, "frequency_hz": 30}
ALL = "Regime Speed Traverse Flight Impact"
SHOWN = {"Regime": "regime", "Speed": "mean_velocity_mm_s", "Traverse": "traverse_time_s"}
NO_LENGTH = "Regime Speed Flight Impact"


def rows_of(sheet: Any) -> list[list[Any]]:
    return [list(row) for row in sheet.iter_rows(values_only=True)]


def to_16_digits(value: Any) -> Any:
    """Round as XlsxWriter does."""
    return float(f"{value:.16g}") if isinstance(value, float) else value


@pytest.mark.parametrize(
    ("quantities", "sheets"),
    [
        ({**MAP, "restitution": [0, 0.5]}, ALL),
        ({"stroke_mm": 2}, ""),
        ({**ELLIPSE, "normal_phase_deg": "0:90:5", "kinetic_friction": "0.5:0.9:3"}, NO_LENGTH),
    ],
)
def test_every_cell_is_read_back_as_it_was_solved(
    tmp_path: Path, quantities: dict[str, Any], sheets: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vibro.sweeps.run._BLOCK", 7)
    book, cells = workbook(tmp_path / "x.xlsx", swept(**quantities))
    assert rows_of(book["Cells"]) == [
        [*cells[0]],
        *([to_16_digits(x) for x in cell.values()] for cell in cells),
    ]
    assert book.sheetnames == ["Summary", "Cells", *sheets.split()]


def test_a_third_axis_has_one_matrix_below_another_and_more_are_held(tmp_path: Path) -> None:
    solved = swept(**MAP, trough_angle_deg="-8:8:3", drive_angle_deg=[20, 40])
    held: dict[str, Any] = {"x": "trough_angle", "y": "frequency", "at": {"amplitude": 3.0}}
    book, cells = workbook(tmp_path / "x.xlsx", solved, **held)
    for name, column in SHOWN.items():
        rows = rows_of(book[name])
        assert len(rows) == 2 * (2 + 6) + 1
        for i, angle in enumerate((20, 40)):
            (head, *_), across, *matrix = rows[9 * i : 9 * i + 8]
            assert head.startswith(f"{column}: frequency_hz down, trough_angle_deg across; ")
            assert head.endswith(f"; amplitude = 3 mm, drive angle = {angle} deg")
            assert across == ["", -8, 0, 8]
            assert [row[0] for row in matrix] == list(solved.axes["frequency_hz"])
            there = [cell for cell in cells if (cell["amplitude_mm"], cell["drive_angle_deg"]) == (3, angle)]
            found = [x for row in matrix for x in row[1:]]
            assert found == [to_16_digits(cell[column]) for cell in there]


def test_results_are_coloured(tmp_path: Path) -> None:
    solved = swept(**{**MAP, "frequency_hz": 25}, trough_angle_deg="-10:10:4")
    book, _ = workbook(tmp_path / "x.xlsx", solved)
    assert solved.cycle.mean_velocity.min() < 0.0
    ends = {}
    for name in ("Speed", "Flight"):
        ((where, (rule,)),) = book[name].conditional_formatting._cf_rules.items()
        assert str(where.sqref) == "B3:F6"
        ends[name] = [(end.type, end.val) for end in rule.colorScale.cfvo]
    assert ends["Speed"][1] == ("num", 0.0)  # so that colours part about it
    assert ends["Flight"][1][0] == "percentile"
    fills = {cell.value: cell.fill.fgColor.rgb for row in book["Regime"]["B3:F6"] for cell in row}
    assert len(fills) > 2
    assert fills.items() <= {regime.label: f"FF{x[1:]}" for regime, x in REGIME_COLOURS.items()}.items()


def test_the_summary_says_what_was_solved_and_found(tmp_path: Path) -> None:
    book, cells = workbook(tmp_path / "x.xlsx", swept(**MAP), argv=["map", "a b.toml"])
    said = {row[0]: row[1:] for row in rows_of(book["Summary"])}  # of inputs the last row, of their column
    given = {row[0]: row[1] for row in reversed(rows_of(book["Summary"]))}
    assert (book["Summary"]["A1"].value, said["in all"][0]) == ("nut", 30)
    assert (said["command"][0], said["vibro"][0]) == ("vibro map 'a b.toml'", vibro.__version__)
    assert given["drive_angle_deg"] == 20
    assert given["amplitude_mm"].startswith("5 values, 0.1 ... 3 mm")
    for regime, number in Counter(cell["regime"] for cell in cells).items():
        assert said[regime][:2] == [number, f"{number / 30:.2%}"]
    fastest = max(cells, key=lambda cell: cell["mean_velocity_mm_s"])
    assert said["fastest"][0] == to_16_digits(fastest["mean_velocity_mm_s"])
    assert said["fastest"][2].startswith(f"amplitude_mm = {fastest['amplitude_mm']:.10g}, frequency_hz = ")
    for column in columns_of():
        assert said[column.name][2] == column.meaning


@each("text", ["=1+1", "@SUM(A1)", "{=A1}", "https://vibro.example", "<r><t>x</r>", "\udcff\x07", "17"])
def test_no_text_of_a_user_is_run_or_followed(tmp_path: Path, text: str) -> None:
    path = tmp_path / "x.xlsx"
    book, _ = workbook(path, swept(), name=text, argv=[text])
    cells = [cell for sheet in book for row in sheet.iter_rows() for cell in row if cell.value is not None]
    assert not any(cell.hyperlink for cell in cells)
    assert {cell.data_type for cell in cells} == {"s", "n"}
    assert isinstance(book["Summary"]["A1"].value, str)
    with zipfile.ZipFile(path) as archive:
        xml = "".join(archive.read(name).decode() for name in archive.namelist())
    assert "<f>" not in xml
    assert "hyperlink" not in xml
    if text.isprintable():
        assert book["Summary"]["A1"].value.rstrip() == text


def test_pictures_have_sheets(tmp_path: Path) -> None:
    png = io.BytesIO()
    Figure().savefig(png, format="png")
    names = ["regime", "a name that is longer than a sheet's may be"]
    book, _ = workbook(tmp_path / "x.xlsx", swept(), pictures=dict.fromkeys(names, png.getvalue()))
    assert book.sheetnames[2:] == ["Picture of regime", "Picture of a name that is longer"[:31]]
    with zipfile.ZipFile(tmp_path / "x.xlsx") as archive:
        images = [archive.read(name) for name in archive.namelist() if name.endswith(".png")]
    assert {*images} == {png.getvalue()}


def test_what_exceeds_a_sheet_is_refused_or_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xlsx, "_MOST_ROWS", 10)
    with pytest.raises(InputError, match=r"10 cells: .* 9"):
        workbook(tmp_path / "x.xlsx", swept(amplitude_mm="1:2:10"))
    assert list(tmp_path.iterdir()) == []
    assert len(workbook(tmp_path / "x.xlsx", swept(amplitude_mm="1:2:9"))[1]) == 9
    monkeypatch.undo()
    monkeypatch.setattr(xlsx, "_MOST_COLUMNS", 6)
    assert workbook(tmp_path / "x.xlsx", swept(**MAP))[0].sheetnames == ["Summary", "Cells"]
