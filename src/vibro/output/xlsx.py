"""A sweep as an Excel workbook: a summary, the table, and maps or lines with native charts."""

from __future__ import annotations

import json
import math
import shlex
from datetime import datetime
from functools import cached_property
from pathlib import Path
from shutil import copyfileobj
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, BinaryIO, Final, NamedTuple

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.errors import FileError, InputError, how_to_install
from vibro.files.rounding import rounded
from vibro.plots.style import INK, NO_ANSWER_FACE, REGIME_COLOURS, visible
from vibro.plots.view import choose_view, is_discrete, value_of
from vibro.quantities import QUANTITIES
from vibro.results.steady import NO_REGIME
from vibro.sweeps.columns import columns_of
from vibro.sweeps.one_scene import number

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from vibro.axes import Axis
    from vibro.output.xlsx_sheet import Cells, Sheet
    from vibro.plots.view import View
    from vibro.results.sweep import Block, Column
    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid

__all__ = ["MOST_COLUMNS", "MOST_ROWS", "Xlsx"]

#: Of a sheet, by the format.
MOST_ROWS: Final = 1_048_576
MOST_COLUMNS: Final = 16_384
_TABLE_HEAD: Final = 2  # [rows] units and names
_MAP_HEAD: Final = 3  # [rows] title, fixed quantities, and the horizontal axis
_MOST_POINTS: Final = 32_000  # of a line: charts of more take a spreadsheet minutes
_SMALLER: Final = 0.8  # width of a letter of maps, over that of the usual type
_MOST_CHARACTERS: Final = 32_767  # of a cell
_SIGNIFICANT, _ON_MAPS = 5, 4  # digits that are shown of the largest number of a column, and of a map
_PLAIN: Final = range(-4, 9)  # powers of ten that are shown without an exponent
_WIDEST, _WIDEST_TEXT = 100, 18  # [characters] of a line of the summary, and of texts of *Cells*
_SMALL: Final = 8  # [pt] type of maps
_SCALE: Final = 70  # [%] of *Cells* on paper: some 200 characters across a page, of 8 pt
_MOST_REPEATED: Final = 120  # [characters] of a page of *Cells*
_OF_TIMES: Final = 3  # significant digits on maps, where times differ by orders of magnitude
_NARROWEST, _REGIME_WIDTH, _CURVE_WIDTH = 6, 8.5, 14  # [characters]

_QUANTITIES: Final = {quantity.column: quantity for quantity in QUANTITIES.values()}

_TRIED: Final = "3.3.1"  # the newest XlsxWriter that is known to work
_LINE: Final = "#BBBBBB"
_FAST, _MIDDLE, _SLOW = "#6699CC", "#CFDDEE", "#FFFFFF"  # light enough for the numbers on them
_BACKWARDS: Final = "#EECC66"
# Of curves, from the first value to the last: matplotlib's plasma, whose light end is too light for lines.
_CURVES: Final = np.array([[13, 8, 135], [126, 3, 168], [204, 71, 120], [248, 149, 64]])
_DASHES: Final = ("solid", "dash", "square_dot", "dash_dot")


class _Picture(NamedTuple):
    """A result that is shown over the axes: name of its sheets, title, and its column in tables."""

    name: str
    title: str
    column: str


_REGIME: Final = _Picture("Regime", "Steady regime", "regime")
_SPEED: Final = _Picture("Speed", "Mean conveying speed", "mean_velocity_mm_s")
_TIME: Final = _Picture("Traverse", "Traverse time", "traverse_time_s")
_IMPACT: Final = _Picture("Impact", "Largest normal speed of a landing", "impact_speed_mm_s")
_FLIGHT: Final = _Picture("Flight", "Share of the time in flight", "flight_fraction")

# What codes of regimes mean on maps, the last one standing for -1.
_REGIME_TEXTS: Final = (*(r.label for r in Regime if r >= 0), NO_REGIME)


class Xlsx:
    """A table as a workbook, written when it is closed; until then it keeps the solved cells, 110 bytes each.

    Parameters
    ----------
    name : str, optional
        Of the scene.
    x, y, at : optional
        The part of the sweep that the maps show, as ``choose_view`` takes it.
    """

    def __init__(
        self,
        name: str = "",
        x: str | None = None,
        y: str | None = None,
        at: Mapping[str, float] | None = None,
    ) -> None:
        self._name, self._asked = name, (x, y, at)
        self._blocks: list[Block] = []

    def open(self, file: BinaryIO, grid: Grid, table: Table) -> None:
        """Check that a workbook holds the sweep.

        Parameters
        ----------
        file : binary file
            Where to; temporary files are put beside it if it has a path.
        grid : Grid
            The sweep.
        table : Table
            Columns of the sheet *Cells*, and the digits of all numbers.

        Raises
        ------
        InputError
            If it has more cells than a sheet has rows, or the axes of maps cannot be drawn.
        FileError
            If XlsxWriter is not installed.
        """
        try:
            import xlsxwriter  # noqa: F401
        except ImportError:
            raise FileError("a workbook needs XlsxWriter", hint=how_to_install("xlsx")) from None
        most = MOST_ROWS - _TABLE_HEAD
        if grid.size > most:
            raise InputError(
                f"{grid.size} cells: a sheet of a workbook holds {most}",
                hint='ask for fewer values, or write Parquet files with table="parquet"',
            )
        self._file, self._grid, self._table = file, grid, table
        x, y, at = self._asked
        self._view = choose_view(grid.told_axes, x, y, at, grid.told(grid.fixed)) if grid.axes else None

    def write(self, block: Block) -> None:
        """Keep a block, in the order of the grid's cells."""
        self._blocks.append(block)

    def close(self, record: Mapping[str, Any]) -> None:
        """Write the workbook.

        Parameters
        ----------
        record : mapping
            The description of the run, as in its JSON.

        Raises
        ------
        OSError
            If a file cannot be written.
        FileError
            If XlsxWriter is a release that does not write these rows.
        """
        import xlsxwriter
        from xlsxwriter.exceptions import FileCreateError

        path = getattr(self._file, "name", None)
        beside = Path(path).parent if isinstance(path, str) else None
        with TemporaryDirectory(dir=beside, ignore_cleanup_errors=True) as scratch:
            # After a failure XlsxWriter's archive is ended only when it is collected: in a file of its own.
            made = Path(scratch, "made.xlsx")
            workbook = _Workbook(xlsxwriter.Workbook(made, {"tmpdir": scratch}), self._table.digits)
            summary = workbook.sheet("Summary")
            workbook.add_cells(self._grid, self._table.columns, self._blocks)
            notes = [] if self._view is None else workbook.add_pictures(self._grid, self._view, self._blocks)
            workbook.add_summary(summary, self._name, self._grid, self._table.columns, record, notes)
            try:
                workbook.book.close()
            except FileCreateError as exc:
                raise exc.args[0] from None  # the system's own error
            if not all(sheet.is_complete for sheet in workbook.book.worksheets()):
                raise FileError(
                    f"XlsxWriter {xlsxwriter.__version__} writes no rows of vibro's",
                    hint=f"pip install 'XlsxWriter<={_TRIED}'",
                )
            with made.open("rb") as file:
                copyfileobj(file, self._file)


class _Workbook:
    """XlsxWriter's workbook, and its formats."""

    def __init__(self, book: Any, digits: int | None) -> None:
        book.use_zip64()
        self.book, self.digits = book, digits
        self.header = self.style(bold=True, valign="vcenter", bg_color=NO_ANSWER_FACE, bottom=1)
        self.names = self.style(bold=True, font_size=9, bg_color=NO_ANSWER_FACE, bottom=1)
        self.corner = self.style(bold=True, font_size=_SMALL, text_wrap=True, bg_color=NO_ANSWER_FACE)
        self.title = self.style(bold=True, font_size=14)
        self.grey = self.style(font_color="#666666")
        self.left = self.style(align="left")

    def style(self, **properties: Any) -> Any:
        """Return a format with these properties."""
        return self.book.add_format(properties)

    def sheet(self, name: str) -> Sheet:
        """Add a sheet that prints on A4 across, as wide as the page."""
        from vibro.output.xlsx_sheet import Sheet

        sheet: Sheet = self.book.add_worksheet(name, Sheet)
        sheet.set_landscape()
        sheet.set_paper(9)
        sheet.set_margins(0.4, 0.4, 0.5, 0.6)
        sheet.fit_to_pages(1, 0)
        sheet.set_footer("&L&A&RPage &P of &N")
        return sheet

    def add_cells(self, grid: Grid, columns: Sequence[Column], blocks: Sequence[Block]) -> None:
        """Add the table: units, header, and a row a cell."""
        sheet = self.sheet("Cells")
        styles, widths = [], []
        for place, column in enumerate(columns):
            width = max(0.85 * len(column.name) + 3, 9)
            if column.is_number or column.is_flag:
                styles.append(self.style(num_format=self._column_format(column, blocks)))
            else:
                texts = [text for block in blocks for text in column.coded(block)[1]]
                sheet.note_texts(texts)
                styles.append(self.style(indent=1))
                width = max(width, min(max(map(len, texts)), _WIDEST_TEXT) + 2)
            sheet.set_column(place, place, width)
            widths.append(width)
            if column.unit:
                sheet.write_string(0, place, f"[{column.unit}]", self.grey)
        names, first = [column.name for column in columns], _TABLE_HEAD - 1
        sheet.put_table(
            first, grid.size, names, self.names, {"style": "Table Style Light 1", "name": "Cells"}
        )
        sheet.put_rows(_TABLE_HEAD, grid.size, self._rows(sheet, columns, styles, blocks))
        sheet.freeze_panes(_TABLE_HEAD, 0)
        self._flow_over_pages(sheet, grid, names, widths)

    def _flow_over_pages(
        self, sheet: Sheet, grid: Grid, names: Sequence[str], widths: Sequence[float]
    ) -> None:
        """Print columns side by side over several pages, each with the header and the axes.

        Axes are repeated with what stands among them, as far as they leave room for other columns.
        """
        sheet.set_print_scale(_SCALE)
        sheet.print_across()
        sheet.repeat_rows(0, _TABLE_HEAD - 1)
        axes, repeated, taken = {axis.column for axis in grid.axes.values()}, -1, 0.0
        for place, (name, width) in enumerate(zip(names, widths, strict=True)):
            taken += width
            if name not in _QUANTITIES or taken > _MOST_REPEATED:
                break
            repeated = place if name in axes else repeated
        if repeated >= 0:
            sheet.repeat_columns(0, repeated)

    def _column_format(self, column: Column, blocks: Sequence[Block]) -> str:
        if column.is_flag:
            return "0"
        numbers = [_rounded(column, block, self.digits) for block in blocks]
        if column.name in _QUANTITIES:
            return _input_format(numbers)
        return _number_format(numbers, self.digits or _SIGNIFICANT)[0]

    def _rows(
        self, sheet: Sheet, columns: Sequence[Column], styles: Sequence[Any], blocks: Sequence[Block]
    ) -> Iterator[list[Cells]]:
        for block in blocks:
            row = []
            for column, style in zip(columns, styles, strict=True):
                if column.is_number:
                    row.append(sheet.numbers(_rounded(column, block, self.digits), block.shape, style))
                elif column.is_flag:
                    flags = column.values(block)
                    row.append(sheet.numbers(np.where(flags < 0, np.nan, flags), block.shape, style))
                else:
                    which, texts = column.coded(block)
                    row.append(sheet.strings(which, texts.tolist(), block.shape, style))
            yield row

    def add_pictures(self, grid: Grid, view: View, blocks: Sequence[Block]) -> list[tuple[str, str]]:
        """Add sheets of the results over the axes; return the name and the subject of each."""
        shown = _Shown(grid, view, blocks, self.digits)
        if shown.width >= MOST_COLUMNS:
            why = f"the axis across has {shown.width} values, and a sheet {MOST_COLUMNS} columns"
            return [("(no maps)", why)]
        pictures = [_REGIME, _SPEED, *([_TIME] if grid.length is not None else []), _IMPACT, _FLIGHT]
        return [note for picture in pictures for note in self._add_picture(shown, picture)]

    def _add_picture(self, shown: _Shown, picture: _Picture) -> Iterator[tuple[str, str]]:
        column = shown.columns[picture.column]
        whole = shown.values(column)
        known = whole[np.isfinite(whole)]
        if not known.size or (picture in (_IMPACT, _FLIGHT) and not known.any()):
            return
        for index in shown.view.facet_indices:
            matrix = shown.cut(whole, index)
            if not np.isfinite(matrix).any():
                continue
            name = f"{picture.name} {shown.facet_text(index)}".rstrip()
            subject = f"{picture.title}{_in_brackets(column.unit)}"
            sheet = self._sheet_over_axes(name, subject, shown, index)
            down, across = matrix.shape
            box = _MAP_HEAD, 1, _MAP_HEAD + down - 1, across
            if column.is_number:
                usual = _ON_MAPS if shown.is_map else _SIGNIFICANT
                shown_as, characters = _number_format([whole], self.digits or usual)
                if picture is _TIME and shown.is_map:
                    shown_as = _graded_format(known, self.digits or _OF_TIMES) or shown_as
                style = self.style(num_format=shown_as, font_size=_SMALL)
                width = 1 + _SMALLER * max(characters, _NARROWEST)
                if shown.is_map:
                    sheet.conditional_format(*box, _colour_scale(picture, known))
                elif down <= _MOST_POINTS:
                    self._insert_chart(sheet, shown, subject, box)
            else:
                style, width = self.style(font_size=_SMALL, align="center"), _REGIME_WIDTH
                sheet.note_texts(_REGIME_TEXTS)
                self._fill_regimes(sheet, box)
            sheet.set_column(1, across, width if shown.is_map else _CURVE_WIDTH)
            sheet.put_rows(_MAP_HEAD, down, self._matrix_rows(sheet, shown.down, matrix, style))
            yield name, f"{subject}: {shown.subject(index)}"

    def _matrix_rows(
        self, sheet: Sheet, axis: Axis, matrix: NDArray[Any], style: Any
    ) -> Iterator[list[Cells]]:
        shape, texts = (len(axis),), None if matrix.dtype == np.float64 else _REGIME_TEXTS
        yield [
            sheet.numbers(axis.values, shape, self._axis_style(axis)),
            *(
                sheet.strings(values, texts, shape, style) if texts else sheet.numbers(values, shape, style)
                for values in matrix.T
            ),
        ]

    def _axis_style(self, axis: Axis) -> Any:
        return self.style(
            bold=True, font_size=_SMALL, bg_color=NO_ANSWER_FACE, num_format=_input_format([axis.values])
        )

    def _sheet_over_axes(self, name: str, subject: str, shown: _Shown, index: int) -> Sheet:
        """Add a sheet with a title and the values of the axis across."""
        sheet = self.sheet(name)
        sheet.set_row(0, 20)
        sheet.write_string(0, 0, subject, self.title)
        sheet.write_string(1, 0, shown.subject(index), self.grey)
        sheet.set_row(2, 25)
        sheet.write_string(2, 0, shown.corner, self.corner)
        if shown.across is None:
            sheet.write_string(2, 1, subject, self.corner)
        else:
            sheet.write_row(2, 1, shown.across.values.tolist(), self._axis_style(shown.across))
        sheet.set_column(0, 0, 14)
        sheet.freeze_panes(_MAP_HEAD, 1)
        sheet.repeat_rows(2)
        if shown.is_map:
            sheet.fit_to_pages(1, 1)
        return sheet

    def _fill_regimes(self, sheet: Sheet, box: tuple[int, int, int, int]) -> None:
        """Fill cells by their regime, and those without one in grey."""
        fills = {regime.label: (colour, _ink_on(regime)) for regime, colour in REGIME_COLOURS.items()}
        fills[NO_REGIME] = NO_ANSWER_FACE, INK
        for label, (face, ink) in fills.items():
            style = self.style(bg_color=face, font_color=ink)
            rule = {"type": "cell", "criteria": "==", "value": f'"{label}"', "format": style}
            sheet.conditional_format(*box, rule)

    def _insert_chart(
        self, sheet: Sheet, shown: _Shown, subject: str, box: tuple[int, int, int, int]
    ) -> None:
        """Insert a chart of the columns over the first: a scatter, as Excel's lines take x for words."""
        first, _, last, across = box
        x, points = shown.down, is_discrete(shown.down)
        subtype = "straight_with_markers" if points else "straight"
        chart = self.book.add_chart({"type": "scatter", "subtype": subtype})
        for place, name in enumerate(shown.curve_names):
            colour = _curve_colour(place, across)
            dot = {"type": "circle", "fill": {"color": colour}, "border": {"color": colour}}
            line = {"color": colour, "width": 1.75, "dash_type": _DASHES[place % len(_DASHES)]}
            chart.add_series(
                {
                    "name": name,
                    "categories": [sheet.get_name(), first, 0, last, 0],
                    "values": [sheet.get_name(), first, place + 1, last, place + 1],
                    "line": line,
                    "marker": dot if points else {"type": "none"},
                }
            )
        scale = {"log_base": 10} if x.spacing == "log" else _even_scale(x.values)
        lines = {"visible": True, "line": {"color": _LINE, "width": 0.5}}
        common = {"num_format": "General", "major_gridlines": lines}
        chart.set_x_axis({"name": _axis_name(x), "label_position": "low", **common, **scale})
        chart.set_y_axis({"name": subject, **common})
        chart.set_title({"name": subject, "name_font": {"size": 12}, "overlay": False})
        chart.set_legend({"none": True} if across == 1 else {"position": "right"})
        chart.set_size({"width": 760, "height": 420})
        sheet.insert_chart(_MAP_HEAD, across + 2, chart)

    def add_summary(
        self,
        sheet: Sheet,
        name: str,
        grid: Grid,
        columns: Sequence[Column],
        record: Mapping[str, Any],
        notes: Iterable[tuple[str, str]],
    ) -> None:
        """Write what was solved, what was found, and how to read it."""
        page = _Page(self, sheet)
        name = _text(name)
        axes = " x ".join(axis.label for axis in grid.told_axes.values())
        page.title(f"Sweep {name}" if name else f"Sweep of {axes or 'one operating point'}")
        self.book.set_properties({"title": name, "created": datetime(2000, 1, 1)})  # equal runs, equal bytes

        page.section("Scene", "value", "unit", "meaning")
        scene = {_QUANTITIES[column].name: value for column, value in record["scene"].items()}
        for of, value in grid.told(scene).items():
            quantity = QUANTITIES[of]
            page.line(quantity.label, value, quantity.unit or "1", quantity.meaning)
        for key, value in {**record.get("motion", {}), **record.get("part", {})}.items():
            page.line(key, value if isinstance(value, int | float) else json.dumps(value))

        page.section("Solved")
        for axis in grid.told_axes.values():
            page.line(axis.label, str(axis).partition(": ")[2])
        page.line("cells", record["cells"])
        page.line("accuracy", record["accuracy"])
        page.line("flights", "solved" if record["flight"] else "not solved")
        page.line("other motions", "looked for" if record["coexistence"] else "not looked for")
        page.line("digits of numbers", "exact" if self.digits is None else self.digits)

        page.section("Regimes", "cells", "share")
        colours = {regime.label: colour for regime, colour in REGIME_COLOURS.items()}
        inks = {regime.label: _ink_on(regime) for regime in REGIME_COLOURS}
        for label, count in record["regime"].items():
            fill = {"bg_color": colours.get(label, NO_ANSWER_FACE), "font_color": inks.get(label, INK)}
            told = label if label in colours else NO_REGIME
            page.share(told, count, record["cells"], style=self.style(border=1, **fill))
        page.section("Statuses", "cells", "share", "meaning")
        messages = {status.label: status.message for status in Status}
        for label, count in record["status"].items():
            page.share(label, count, record["cells"], messages[label])

        if record["peaks"]:
            page.section("Fastest cells", "speed", "unit", "at")
        for label, cell in record["peaks"].items():
            place = grid.told({of: cell[axis.column] for of, axis in grid.axes.items()})
            at = ", ".join(
                f"{axis.label} = {number(place[of], axis.unit)}" for of, axis in grid.told_axes.items()
            )
            speed, error = cell[_SPEED.column], cell["mean_velocity_error_mm_s"]
            known = f"standard error {error:.3g} mm/s" if error else ""
            way = "forwards" if label == "fastest" else "backwards"
            shown, _ = _number_format([np.array([speed])], _SIGNIFICANT)
            in_short = self.style(align="left", num_format=shown)
            page.line(way, speed, "mm/s", ", ".join(filter(None, [at, known])), style=in_short)

        page.section("Sheets")
        page.line("Cells", "one row a combination; where a number is missing, its status says why")
        for sheet_name, subject in notes:
            page.line(sheet_name, subject)

        page.section("Columns of Cells", "unit", "", "meaning")
        for column in columns:
            unit = column.unit or ("1" if column.is_number else "-")
            page.line(column.name, unit, "", column.meaning)

        page.section("Made with")
        page.line("vibro", record.get("version", ""))
        page.paragraph("command", shlex.join(map(str, record.get("argv", ()))))


class _Page:
    """The summary, line by line."""

    def __init__(self, workbook: _Workbook, sheet: Sheet) -> None:
        self._book, self._sheet, self._row = workbook, sheet, 0
        for place, width in enumerate((28, 22, 9, 90)):
            sheet.set_column(place, place, width)

    def title(self, text: str) -> None:
        self._write((text,), self._book.title)

    def section(self, *heads: str) -> None:
        """Begin a section, after an empty row."""
        self._row += 1
        self._write((*heads, *[""] * (4 - len(heads))), self._book.header)

    def line(self, *cells: str | float, style: Any = None) -> None:
        """Write a label, a value, its unit and its meaning, as far as there are any."""
        self._write(cells, style or self._book.left)

    def share(self, label: str, count: int, of: int, meaning: str = "", *, style: Any = None) -> None:
        """Write a number of cells, and its share of all of them."""
        self._sheet.write_string(self._row, 0, label, style or self._book.left)
        self._sheet.write_number(self._row, 1, count, self._book.style(align="left", num_format="0"))
        self._sheet.write_number(self._row, 2, count / of, self._book.style(align="left", num_format="0.00%"))
        if meaning:
            self._sheet.write_string(self._row, 3, meaning)
        self._row += 1

    def paragraph(self, label: str, text: str) -> None:
        """Write a long text over several lines."""
        style = self._book.style(text_wrap=True, valign="top")
        self._sheet.write_string(self._row, 0, label, style)
        self._sheet.merge_range(self._row, 1, self._row, 3, "", style)
        self._sheet.write_string(self._row, 1, _text(text), style)
        self._sheet.set_row(self._row, min(400, 15 * (1 + len(text) // _WIDEST)))
        self._row += 1

    def _write(self, cells: Sequence[str | float], style: Any) -> None:
        for place, cell in enumerate(cells):
            if not isinstance(cell, str):
                self._sheet.write_number(self._row, place, cell, style)
            elif cell:
                self._sheet.write_string(self._row, place, _text(cell), style)
            else:
                self._sheet.write_blank(self._row, place, None, style)
        self._row += 1


class _Shown:
    """The part of a sweep that sheets show: one axis down and one across, or one value or curve a column."""

    def __init__(self, grid: Grid, view: View, blocks: Sequence[Block], digits: int | None) -> None:
        self._grid, self.view, self._blocks, self._digits = grid, view, blocks, digits
        self.is_map = view.y is not None
        self.down, self.across = (view.x, view.curves) if view.y is None else (view.y, view.x)
        self.columns = {
            column.name: column
            for column in columns_of(grid.axes, drive=grid.drive, machine=grid.machine is not None)
        }

    @property
    def width(self) -> int:
        """Columns of a sheet beside its axis."""
        return 1 if self.across is None else len(self.across)

    def values(self, column: Column) -> NDArray[Any]:
        """Return a column of the whole grid: numbers, or for regimes which of their texts each cell has."""
        if column.is_number:
            found = self._joined(column)
            return found if self._digits is None else rounded(found, self._digits)
        return self._joined(column) % len(_REGIME_TEXTS)

    def _joined(self, column: Column) -> NDArray[Any]:
        parts = [np.broadcast_to(column.values(block), block.shape).ravel() for block in self._blocks]
        return np.concatenate(parts).reshape(self._grid.shape)

    def cut(self, values: NDArray[Any], facet_index: int) -> NDArray[Any]:
        """Cut the matrix of a facet out of values of the grid's shape: down, across."""
        held = self._held(facet_index)
        part = values[tuple(held.get(name, slice(None)) for name in self._grid.told_axes)]
        if self.across is None:
            return part[:, np.newaxis]
        first = next(name for name in self._grid.told_axes if name not in held)
        return part if first == self.down.name else part.T

    def _held(self, facet_index: int) -> dict[str, int]:
        facet = {} if self.view.facet is None else {self.view.facet.name: facet_index}
        return {**self.view.held, **facet}

    @cached_property
    def curve_names(self) -> list[str]:
        """What the columns of a sheet are, where each is a curve."""
        if self.across is None:
            return [self.down.label]
        letter = QUANTITIES[self.across.name].letter
        return [f"{letter} = {value_of(self.across, i)}" for i in range(len(self.across))]

    @property
    def corner(self) -> str:
        """What the axes are: down, and across."""
        down = f"{_axis_name(self.down)} \N{DOWNWARDS ARROW}"
        return down if self.across is None else f"{_axis_name(self.across)} \N{RIGHTWARDS ARROW}\n{down}"

    def facet_text(self, index: int) -> str:
        """Name a facet for its sheet, in the few characters that a name may have."""
        facet = self.view.facet
        if facet is None:
            return ""
        texts = {i: f"{QUANTITIES[facet.name].letter}={facet.values[i]:.6g}" for i in self.view.facet_indices}
        return texts[index] if len(set(texts.values())) == len(texts) else f"{list(texts).index(index) + 1}"

    def subject(self, facet_index: int) -> str:
        """Say what a sheet shows over what, and at which values of the other axes."""
        over = [self.down, *([self.across] if self.across else [])]
        axes = self._grid.told_axes
        at = [
            f"{axes[name].label} = {value_of(axes[name], i)}" for name, i in self._held(facet_index).items()
        ]
        return ", ".join([f"over {' and '.join(axis.label for axis in over)}", *at])


def _axis_name(axis: Axis) -> str:
    return axis.label + _in_brackets(axis.unit)


def _in_brackets(unit: str) -> str:
    return f" [{unit}]" if unit else ""


def _input_format(values: Sequence[NDArray[np.float64]]) -> str:
    """Return the format of given quantities: as they were given, or with fewer digits where that is long."""
    different = np.unique(np.concatenate([x.ravel() for x in values]))
    if all(value == float(f"{value:.{_SIGNIFICANT}g}") for value in different.tolist()):
        return "General"
    return _number_format([different], _SIGNIFICANT)[0]


def _number_format(values: Sequence[NDArray[np.float64]], significant: int) -> tuple[str, int]:
    """Choose decimals so that the largest number has so many digits; whole numbers have none.

    Returns
    -------
    str
        The number format, with an exponent where numbers are very large or small.
    int
        Characters that a number takes.
    """
    size = max((float(np.max(np.abs(x), where=np.isfinite(x), initial=0.0)) for x in values), default=0.0)
    power = math.floor(math.log10(size)) if size else 0
    plain = power in _PLAIN
    whole = plain and all(np.all((x == np.trunc(x)) | ~np.isfinite(x)) for x in values)
    decimals = 0 if whole else max(significant - 1 - (power if plain else 0), 0)
    shown = f"0.{'0' * decimals}" if decimals else "0"
    return (shown, max(power, 0) + len(shown) + 1) if plain else (f"{shown}E+00", len(shown) + 5)


def _graded_format(values: NDArray[np.float64], significant: int) -> str:
    """Return the format of numbers > 0 that shows so many digits of each of the three least powers of ten.

    It is empty where that needs exponents.
    """
    power, most = (math.floor(math.log10(float(end))) for end in (values.min(), values.max()))
    if power not in _PLAIN or most not in _PLAIN:
        return ""
    zeros = ["0" * max(significant - 1 - power - i, 0) for i in range(3)]
    least, middle, rest = (f"0.{some}" if some else "0" for some in zeros)
    return f"[<{10.0 ** (power + 1):.10g}]{least};[<{10.0 ** (power + 2):.10g}]{middle};{rest}"


def _colour_scale(picture: _Picture, known: NDArray[np.float64]) -> dict[str, Any]:
    """Colour numbers alike on all sheets of a picture: about 0 if some are negative, else the median."""
    low, high = float(known.min()), float(known.max())
    colours = [_SLOW, _MIDDLE, _FAST]
    ends = [low, float(np.median(known)), high]
    if low < 0.0:
        most = max(-low, high)
        colours, ends = [_BACKWARDS, _SLOW, _FAST], [-most, 0.0, most]
    elif picture is _TIME:
        colours.reverse()
    scale: dict[str, Any] = {"type": "3_color_scale"}
    for end, colour, value in zip(("min", "mid", "max"), colours, ends, strict=True):
        scale |= {f"{end}_type": "num", f"{end}_value": value, f"{end}_color": colour}
    return scale


def _even_scale(values: NDArray[np.float64]) -> dict[str, float]:
    """Return the ends and the step of an axis with round numbers; Excel begins at 0 however far that is."""
    low, high = float(values[0]), float(values[-1])
    power = 10.0 ** math.floor(math.log10(high - low))
    step = next(size for size in (0.1 * power, 0.2 * power, 0.5 * power, power) if (high - low) / size <= 12)
    return {"min": step * math.floor(low / step), "max": step * math.ceil(high / step), "major_unit": step}


def _curve_colour(place: int, count: int) -> str:
    where = 0.0 if count == 1 else place / (count - 1) * (len(_CURVES) - 1)
    parts = [round(float(np.interp(where, range(len(_CURVES)), part))) for part in _CURVES.T]
    return "#{:02X}{:02X}{:02X}".format(*parts)


def _ink_on(regime: Regime) -> str:
    return "#FFFFFF" if regime is Regime.HOPPING else INK


def _text(text: str) -> str:
    """Make a user's text that of a cell: visible characters, and not too many."""
    return visible(text)[:_MOST_CHARACTERS]


def _rounded(column: Column, block: Block, digits: int | None) -> NDArray[np.float64]:
    values = column.values(block)
    return values if digits is None else rounded(values, digits)
