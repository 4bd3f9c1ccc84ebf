"""Workbooks: exact numbers, maps, charts, and nothing of a user's text that a spreadsheet would run."""

from __future__ import annotations

import errno
import io
import re
import sys
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.workbooks import (
    NUT,
    grid_of,
    table_rows,
    without_texts_that_are_empty,
    write,
    written,
)
from xlsxwriter.worksheet import Worksheet

import vibro
from vibro.axes import Axis
from vibro.core.codes import Regime
from vibro.errors import FileError, InputError
from vibro.output import xlsx
from vibro.output.xlsx import Xlsx
from vibro.output.xlsx_sheet import Sheet
from vibro.plots.style import REGIME_COLOURS
from vibro.quantities import DRIVES, SWEPT
from vibro.results.steady import DERIVED, RESULTS
from vibro.sweeps.columns import Table, chosen, column_names, columns_of
from vibro.sweeps.derived import WITH_ARRIVAL

EXAMPLES = Path(__file__).parents[2] / "examples"
ELLIPSE: dict[str, Any] = {
    "along_amplitude_mm": 0.5,
    "normal_amplitude_mm": 0.3,
    "frequency_hz": 30,
    "static_friction": 0.5,
}
ELLIPSE |= {"kinetic_friction": 0.4, "normal_phase_deg": "0:90:7", "trough_angle_deg": [0, 3]}


def matrix(sheet: Any) -> tuple[list[float], list[float], list[list[Any]]]:
    """Return the values down and across, and the cells between them."""
    _, *across = next(sheet.iter_rows(min_row=3, max_row=3, values_only=True))
    rows = [list(row) for row in sheet.iter_rows(min_row=4, values_only=True)]
    return [row[0] for row in rows], across, [row[1:] for row in rows]


def summary(workbook: Any) -> dict[Any, list[Any]]:
    return {row[0]: list(row[1:]) for row in workbook["Summary"].iter_rows(values_only=True) if row[0]}


def texts_of(file: Any) -> str:
    with zipfile.ZipFile(file) as archive:
        return "".join(archive.read(name).decode() for name in archive.namelist())


@pytest.mark.parametrize(
    ("scene", "quantities", "sheets"),
    [
        (None, {"amplitude_mm": "0.1:3:9", "frequency_hz": "5:60:11"}, "Regime Speed Traverse Impact Flight"),
        (None, {"amplitude_mm": "0.3:1.3:7", "frequency_hz": "15"}, "Regime Speed Traverse"),
        (None, {"amplitude_mm": 1, "frequency_hz": 15}, ""),
        (None, {"amplitude_mm": 2, "frequency_hz": 30, "restitution": "0,0.5"}, "all"),
        (None, {"amplitude_mm": [1, 3], "frequency_hz": 15, "kinetic_friction": "0.5,0.9"}, "some"),
        ("", ELLIPSE, "Regime Speed Impact Flight"),
        (EXAMPLES / "slip_stick.toml", {"motion_scale": "0.5:2:7", "static_friction": 0.4}, "some"),
    ],
)
def test_every_cell_is_read_back_as_it_was_solved(
    tmp_path: Path, scene: Any, quantities: dict[str, Any], sheets: str
) -> None:
    grid = vibro.sweep(**quantities)._grid if scene == "" else grid_of(scene, **quantities)
    workbook, rows = written(tmp_path / "x.xlsx", grid)
    assert table_rows(workbook["Cells"]) == without_texts_that_are_empty(rows)
    names = {"all": "Regime Speed Traverse Impact Flight", "some": "Regime Speed Traverse"}.get(
        sheets, sheets
    )
    assert workbook.sheetnames == ["Summary", "Cells", *names.split()]


def test_numbers_have_all_their_digits(tmp_path: Path) -> None:
    grid = grid_of(amplitude_mm="0.1:3:11", frequency_hz="5:60:12", kinetic_friction=0.1 + 0.2)
    workbook, rows = written(tmp_path / "x.xlsx", grid)
    numbers = [value for row in rows for value in row.values() if isinstance(value, float)]
    assert sum(float(f"{x:.16g}") != x for x in numbers) > 100  # 16 digits would not do
    assert table_rows(workbook["Cells"]) == without_texts_that_are_empty(rows)
    down, across, _ = matrix(workbook["Speed"])
    assert down == list(grid.axes["amplitude"].values)
    assert across == list(grid.axes["frequency"].values)
    assert summary(workbook)["kinetic friction"][0] == 0.1 + 0.2 != 0.3


def test_the_cells_are_an_excel_table(tmp_path: Path) -> None:
    grid = grid_of(amplitude_mm="0.1:3:8", frequency_hz="5:60:11")
    sheet = written(tmp_path / "x.xlsx", grid)[0]["Cells"]
    table = sheet.tables["Cells"]
    assert table.ref == table.autoFilter.ref == "A2:X90"
    assert [column.name for column in table.tableColumns] == [
        column.name for column in columns_of(made_with=grid.made_with)
    ]
    assert sheet.dimensions == "A1:X90"
    assert sheet.freeze_panes == "A3"
    units = {sheet.cell(2, i).value: sheet.cell(1, i).value for i in range(1, 23)}
    assert units["mean_velocity_mm_s"] == "[mm/s]"
    assert units["regime"] is units["throw_number"] is None
    formats = {sheet.cell(2, i).value: sheet.cell(50, i).number_format for i in range(1, 23)}
    # five digits of the largest number, and given quantities as they were given where they are short
    assert formats["mean_velocity_mm_s"] == "0.00"
    assert formats["throw_number"] == "0.000"
    assert formats["flight_fraction"] == "0.0000"
    assert formats["amplitude_mm"] == "0.0000"
    assert formats["frequency_hz"] == formats["static_friction"] == "General"
    assert {type(cell.value) for cell in sheet["G"][2:]} == {str}


@pytest.mark.parametrize(
    ("axes", "repeated"),
    [
        ({"amplitude_mm": [1, 2], "frequency_hz": [15, 20]}, "$A:$B"),
        ({"amplitude_mm": [1, 2], "trough_angle_deg": [-3, 0, 3]}, "$A:$F"),
    ],
)
def test_cells_flow_over_readable_pages_with_their_axes(
    tmp_path: Path, axes: dict[str, Any], repeated: str | None
) -> None:
    sheet = written(tmp_path / "x.xlsx", grid_of(**axes))[0]["Cells"]
    assert sheet.page_setup.orientation == "landscape"
    assert not sheet.sheet_properties.pageSetUpPr.fitToPage  # nothing is squeezed on one page
    assert 11 * sheet.page_setup.scale / 100 >= 7.5  # [pt]
    assert sheet.page_setup.pageOrder == "overThenDown"
    assert (sheet.print_title_rows, sheet.print_title_cols) == ("$1:$2", repeated)


@pytest.mark.parametrize(
    ("axes", "is_transposed"),
    [
        ({"amplitude_mm": "0.1:3:8", "frequency_hz": "5:60:11"}, False),
        ({"amplitude_mm": "0.1:3:8", "frequency_hz": 25, "trough_angle_deg": "-10:10:5"}, True),
    ],
)
def test_a_cell_of_a_map_is_the_scene_of_its_row_and_column(
    tmp_path: Path, axes: dict[str, Any], is_transposed: bool
) -> None:
    sweep = vibro.sweep(**NUT | axes)
    workbook, _ = written(tmp_path / "x.xlsx", sweep._grid)
    cycle, names = sweep.cycle, dict(zip("yx", sweep.axes.values(), strict=True))
    found = {
        "Regime": [[Regime(code).label for code in row] for row in cycle.regime.tolist()],
        "Speed": 1e3 * cycle.mean_velocity,
        "Traverse": np.where(np.isfinite(time := cycle.traverse_time(0.6)), time, np.nan).astype(object),
        "Impact": 1e3 * cycle.impact_velocity,
        "Flight": cycle.flight_fraction,
    }
    for name, values in found.items():
        down, across, cells = matrix(workbook[name])
        table = np.array(values, dtype=object)
        table[table != table] = None
        expected = table.T if is_transposed else table
        assert [down, across] == [list(names[way]) for way in ("xy" if is_transposed else "yx")]
        assert cells == expected.tolist(), name
    corner = workbook["Speed"]["A3"].value
    x, y = ("amplitude [mm]", "trough angle [deg]") if is_transposed else ("frequency [Hz]", "amplitude [mm]")
    assert corner == f"{x} \N{RIGHTWARDS ARROW}\n{y} \N{DOWNWARDS ARROW}"
    assert workbook["Speed"].freeze_panes == "B4"


def test_maps_are_coloured(tmp_path: Path) -> None:
    grid = grid_of(amplitude_mm="0.1:3:9", frequency_hz=25, trough_angle_deg="-10:10:5")
    workbook, rows = written(tmp_path / "x.xlsx", grid)

    def rules(name: str) -> list[Any]:
        ((where, found),) = workbook[name].conditional_formatting._cf_rules.items()
        assert str(where.sqref) == "B4:J8"
        return list(found)

    (speed,), (time,) = rules("Speed"), rules("Traverse")
    speeds = [row["mean_velocity_mm_s"] for row in rows]
    most = max(map(abs, speeds))
    assert min(speeds) < 0.0  # so that colours part about it
    assert [end.val for end in speed.colorScale.cfvo] == [-most, 0.0, most]
    times = [row["traverse_time_s"] for row in rows if row["traverse_time_s"] is not None]
    assert [end.val for end in time.colorScale.cfvo] == [min(times), np.median(times), max(times)]
    # fast is blue, be it a speed or a time
    assert speed.colorScale.color[2].rgb == time.colorScale.color[0].rgb
    fills = {rule.formula[0].strip('"'): rule.dxf.fill.bgColor.rgb for rule in rules("Regime")}
    for regime, colour in REGIME_COLOURS.items():
        assert fills[regime.label] == f"FF{colour[1:]}"
    assert len(set(fills.values())) == 5  # and grey where there is no regime


def test_short_times_have_three_digits_beside_long_ones(tmp_path: Path) -> None:
    grid = grid_of(amplitude_mm="0.1:3:15", frequency_hz="5:60:12")
    workbook, rows = written(tmp_path / "x.xlsx", grid)
    times = [row["traverse_time_s"] for row in rows if row["traverse_time_s"] is not None]
    assert max(times) > 500 > 10 > np.median(times)
    assert 0.1 < min(times) < 1
    assert {cell.number_format for row in workbook["Traverse"]["B4:M18"] for cell in row if cell.value} == {
        "[<1]0.000;[<10]0.00;0.0"
    }


def test_a_third_axis_makes_sheets_and_a_fourth_is_held(tmp_path: Path) -> None:
    axes: dict[str, Any] = {
        "amplitude_mm": "0.1:3:4",
        "frequency_hz": "5:60:5",
        "static_friction": "0.6,0.7,0.8",
    }
    sweep = vibro.sweep(**NUT | axes | {"drive_angle_deg": "10:30:3"})
    workbook, _ = written(tmp_path / "x.xlsx", sweep._grid)
    for i, friction in enumerate((0.6, 0.7, 0.8)):
        sheet = workbook[f"Speed mu_s={friction}"]
        assert matrix(sheet)[2] == (1e3 * sweep.cycle.mean_velocity[:, :, 1, i]).tolist()
        assert sheet["A2"].value.endswith(f"drive angle = 20 deg, static friction = {friction}")
        assert sheet["A2"].value in summary(workbook)[sheet.title][0]
    assert len(workbook.sheetnames) == 2 + 3 * 5


def test_numbers_of_the_summary_are_for_people(tmp_path: Path) -> None:
    grid = grid_of(amplitude_mm="0.1:3.1234567:7", frequency_hz="5:60:12", restitution=0.2)
    workbook, rows = written(tmp_path / "x.xlsx", grid, name="")
    told = summary(workbook)
    assert workbook["Summary"]["A1"].value == "Sweep of amplitude x frequency"
    fastest = max(rows, key=lambda row: row["mean_velocity_mm_s"])
    assert len(repr(fastest["amplitude_mm"])) > 8  # so that six digits are fewer
    at = f"amplitude = {fastest['amplitude_mm']:.6g} mm, frequency = {fastest['frequency_hz']:.6g} Hz"
    assert told["forwards"][2].startswith(at)
    given, column = (x for x in workbook["Summary"].iter_rows(values_only=True) if x[0] == "restitution")
    assert given[1:3] == (0.2, "1")
    assert column[1] == "1"


def test_names_of_sheets_are_short_and_differ(tmp_path: Path) -> None:
    near = [0.7 + 1e-9 * i for i in range(3)]
    grid = grid_of(amplitude_mm="0.5:3:4", frequency_hz="5:60:5", static_friction=near)
    workbook, _ = written(tmp_path / "x.xlsx", grid)
    assert workbook.sheetnames[2:5] == ["Regime 1", "Regime 2", "Regime 3"]


@pytest.mark.parametrize(
    ("axes", "names", "logarithmic"),
    [
        ({"amplitude_mm": "0.3:1.3:11:log", "frequency_hz": 15}, ["amplitude"], True),
        ({"amplitude_mm": "0.3:1.3:11", "frequency_hz": "15,20"}, ["f = 15 Hz", "f = 20 Hz"], False),
    ],
)
def test_lines_are_charts_of_their_numbers(
    tmp_path: Path, axes: dict[str, Any], names: list[str], logarithmic: bool
) -> None:
    sweep = vibro.sweep(**NUT | axes)
    workbook, _ = written(tmp_path / "x.xlsx", sweep._grid)
    sheet = workbook["Speed"]
    down, _, cells = matrix(sheet)
    assert down == list(sweep.axes["amplitude_mm"])
    assert cells == (1e3 * sweep.cycle.mean_velocity).reshape(11, -1).tolist()
    (chart,) = sheet._charts
    assert [series.tx.v for series in chart.series] == names
    for letter, series in zip("BC", chart.series, strict=False):
        assert series.xVal.numRef.f == "Speed!$A$4:$A$14"
        assert series.yVal.numRef.f == f"Speed!${letter}$4:${letter}$14"
    title = [chart.x_axis.title.tx.rich.p[0].r[0].t, chart.y_axis.title.tx.rich.p[0].r[0].t]
    assert title == ["amplitude [mm]", "Mean conveying speed [mm/s]"]
    assert chart.x_axis.scaling.logBase == (10 if logarithmic else None)
    assert not sheet.conditional_formatting
    assert workbook["Regime"].conditional_formatting


def test_the_summary_says_what_was_solved_and_found(tmp_path: Path) -> None:
    grid = grid_of(amplitude_mm="0.1:3:9", frequency_hz="5:60:11")
    workbook, rows = written(tmp_path / "x.xlsx", grid, argv=["vibro", "map", "a b.toml"])
    told = summary(workbook)
    assert workbook["Summary"]["A1"].value == "Sweep nut"
    assert told["drive angle"][:2] == [20, "deg"]
    assert told["gravity"][0] == 9.81
    assert told["amplitude"][0] == "9 values, 0.1 ... 3 mm, step 0.362"
    assert told["cells"][0] == 99
    for regime in Regime:
        number = sum(row["regime"] == regime.label for row in rows)
        if number:
            assert told[regime.label][:2] == [number, number / 99]
    assert told["ok"][2] == "solved to rounding"
    for column in columns_of():
        assert told[column.name][0] == column.unit or told[column.name][0] in ("1", "-")
        assert told[column.name][2] == column.meaning
    assert told["vibro"][0] == vibro.__version__
    assert told["command"][0] == "vibro map 'a b.toml'"


def test_every_column_has_a_meaning_in_words_for_people() -> None:
    drives = [name for name in DRIVES if name in SWEPT]
    columns = [*chosen(column_names(), columns_of(drive=drives, machine=True)), WITH_ARRIVAL]
    meanings = [*(column.meaning for column in columns), *(result.meaning for result in (*RESULTS, *DERIVED))]
    assert all(len(meaning) > 10 for meaning in meanings)
    # no names of classes, members or values in Python, and no mathematics but where a page can show it
    assert not [meaning for meaning in meanings if re.search(r"`|NaN|None|\w_\w|\b[A-Z]{3,}\b|-1", meaning)]
    assert not [column.meaning for column in columns if "$" in column.meaning]


@each(
    "text",
    [
        "=1+1",
        "@SUM(A1)",
        "https://vibro.example",
        "<r><t>x</r>",
        "\udcff\x07",
        "17",
    ],
)
def test_no_text_of_a_user_is_run_or_followed(tmp_path: Path, text: str) -> None:
    path = tmp_path / "x.xlsx"
    workbook, _ = written(path, grid_of(amplitude_mm=1, frequency_hz=15), name=text, argv=[text])
    cells = [cell for sheet in workbook for row in sheet.iter_rows() for cell in row]
    assert not any(cell.hyperlink for cell in cells)
    assert {cell.data_type for cell in cells} == {"s", "n"}
    xml = texts_of(path)
    assert "<f>" not in xml
    assert "hyperlink" not in xml
    told = summary(workbook)["command"][0]
    assert isinstance(told, str)
    if text.isprintable():
        assert text in told
        assert text in workbook["Summary"]["A1"].value


def test_digits_are_those_that_are_asked_for(tmp_path: Path) -> None:
    grid = grid_of(amplitude_mm="0.1:3:9", frequency_hz="5:60:11")
    workbook, rows = written(tmp_path / "x.xlsx", grid, digits=3)
    got = table_rows(workbook["Cells"])
    assert got == without_texts_that_are_empty(rows)
    assert all(float(f"{row['mean_velocity_mm_s']:.3g}") == row["mean_velocity_mm_s"] for row in got)
    speeds = [value for row in matrix(workbook["Speed"])[2] for value in row]
    assert speeds == [row["mean_velocity_mm_s"] for row in rows]
    assert summary(workbook)["digits of numbers"][0] == 3


def test_equal_sweeps_make_equal_files() -> None:
    grid = grid_of(amplitude_mm="0.1:3:9", frequency_hz="5:60:11")
    files = [io.BytesIO(), io.BytesIO()]
    for file in files:
        write(file, grid)
    assert files[0].getvalue() == files[1].getvalue()
    assert "2000-01-01T00:00:00Z" in texts_of(files[0])  # and so they do tomorrow


def test_where_nothing_is_feasible_only_statuses_are_shown(tmp_path: Path) -> None:
    grid = grid_of(amplitude_mm=[1, 2], frequency_hz="15:20:3")
    workbook, rows = written(
        tmp_path / "x.xlsx", replace(grid, fixed={**grid.fixed, "kinetic_friction": 0.9})
    )
    assert workbook.sheetnames == ["Summary", "Cells", "Regime"]
    assert table_rows(workbook["Cells"]) == without_texts_that_are_empty(rows)
    assert matrix(workbook["Regime"])[2] == [["no regime"] * 2] * 3
    told = summary(workbook)
    assert told["no regime"][:2] == [6, 1]
    assert "mu_d > mu_s" in told["infeasible"][2]


def test_more_cells_than_rows_are_refused_before_any_is_solved() -> None:
    def sized(amplitudes: int, frequencies: int) -> Any:
        grid = grid_of(amplitude_mm=[1, 2], frequency_hz=[15, 20])
        axes = {
            "amplitude": Axis("amplitude", np.linspace(1, 2, amplitudes), "linear"),
            "frequency": Axis("frequency", np.linspace(5, 60, frequencies), "linear"),
        }
        return replace(grid, axes=axes)

    table = Table(columns_of())
    Xlsx().open(io.BytesIO(), sized(2, 524_287), table)  # with two rows of names the whole sheet
    with pytest.raises(InputError, match=r"1048575 cells: .* 1048574"):
        Xlsx().open(io.BytesIO(), sized(1025, 1023), table)


def test_maps_wider_than_a_sheet_are_left_out_with_a_word(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(xlsx, "MOST_COLUMNS", 11)
    workbook, _ = written(tmp_path / "x.xlsx", grid_of(amplitude_mm="0.1:3:9", frequency_hz="5:60:11"))
    assert workbook.sheetnames == ["Summary", "Cells"]
    assert summary(workbook)["(no maps)"][0].count("11") == 2


def test_maps_show_the_axes_that_are_asked_for(tmp_path: Path) -> None:
    grid = grid_of(amplitude_mm="0.1:3:4", frequency_hz="5:60:5", trough_angle_deg="-5:5:3")
    sink = Xlsx(x="trough_angle", y="frequency", at={"amplitude": 3.0})
    workbook, _ = written(tmp_path / "x.xlsx", grid, sink=sink)
    down, across, _ = matrix(workbook["Speed"])
    assert (down, across) == ([5, 18.75, 32.5, 46.25, 60], [-5, 0, 5])
    assert workbook["Speed"]["A2"].value.endswith("amplitude = 3 mm")


def test_without_xlsxwriter_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xlsxwriter", None)
    grid = grid_of(amplitude_mm=1, frequency_hz=15)
    with pytest.raises(FileError, match="a workbook needs XlsxWriter") as refusal:
        Xlsx().open(io.BytesIO(), grid, Table(columns_of()))
    assert refusal.value.hint == "pip install '.[xlsx]' in the project's folder"


def test_a_release_that_does_not_ask_for_the_rows_is_no_empty_table(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Sheet, "_write_rows", Worksheet._write_rows)
    with pytest.raises(FileError, match="writes no rows") as refusal:
        write(io.BytesIO(), grid_of(amplitude_mm=1, frequency_hz=15))
    assert refusal.value.hint.startswith("pip install 'XlsxWriter<=")


def test_a_full_disk_is_the_systems_error_and_leaves_nothing_beside(tmp_path: Path) -> None:
    class Full(io.FileIO):
        def write(self, data: Any) -> int:
            raise OSError(errno.ENOSPC, "No space left on device")

    grid = grid_of(amplitude_mm=1, frequency_hz=15)
    with Full(str(tmp_path / "x.xlsx"), "w") as file, pytest.raises(OSError, match="No space") as failure:
        write(file, grid)
    assert failure.value.errno == errno.ENOSPC
    assert [path.name for path in tmp_path.iterdir()] == ["x.xlsx"]


def test_the_rows_of_many_blocks_follow_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.sweeps.run._BLOCK", 7)
    monkeypatch.setattr("vibro.output.xlsx_sheet._AT_ONCE", 60)
    grid = grid_of(amplitude_mm="0.1:3:9", frequency_hz="5:60:11")
    workbook, rows = written(tmp_path / "x.xlsx", grid)
    assert table_rows(workbook["Cells"]) == without_texts_that_are_empty(rows)
    assert len(rows) == 99
    assert matrix(workbook["Speed"])[2][8][10] == rows[-1]["mean_velocity_mm_s"]
