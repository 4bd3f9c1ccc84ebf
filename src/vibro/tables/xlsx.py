"""A sweep as an Excel workbook: a summary, its cells, results over two axes in colours, pictures."""

from __future__ import annotations

import io
import json
import math
import shlex
from datetime import datetime
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.errors import FileError, InputError, how_to_install
from vibro.plots.style import INK, REGIME_COLOURS, visible
from vibro.plots.view import value_of
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    import pyarrow as pa
    from numpy.typing import NDArray

    from vibro.plots.view import View
    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid

_MOST_ROWS, _MOST_COLUMNS = 1_048_576, 16_384  # of a sheet, by the format
_MOST_CHARACTERS: Final = 32_767  # of a cell
_DECIMALS: Final = 7  # from so many before or behind the point on, numbers have an exponent
_LONGEST_NAME: Final = 31  # characters of a sheet's
#: Results that have a sheet of their own, where the table has their column, and its name.
_OVER_AXES: Final = {
    "regime": "Regime",
    "mean_velocity_mm_s": "Speed",
    "traverse_time_s": "Traverse",
    "impact_speed_mm_s": "Impact",
    "flight_fraction": "Flight",
}
_WIDTH: Final = 12  # [characters] of a column that holds regimes or numbers
_COLOURS: Final = {
    "type": "3_color_scale", "min_color": "#FFFFFF", "mid_color": "#CFDDEE", "max_color": "#6699CC",
}  # fmt: skip
_BACKWARDS: Final = {
    "min_color": "#EECC66", "mid_color": "#FFFFFF", "mid_type": "num", "mid_value": 0.0,
}  # fmt: skip


class Xlsx:
    """Cells as a workbook; rows go to a file as they come.

    Parameters
    ----------
    path : Path
        Where the workbook goes.
    scratch : Path
        A folder for temporary files.
    grid : Grid
        What is solved.
    table : Table
        What is written of it.
    view : View, optional
        What the pictures show.

    Raises
    ------
    InputError
        If it has more cells than a sheet has rows.
    FileError
        If XlsxWriter is not installed.
    """

    def __init__(self, path: Path, scratch: Path, grid: Grid, table: Table, view: View | None) -> None:
        try:
            import xlsxwriter
        except ImportError:
            raise FileError("a workbook needs XlsxWriter", hint=how_to_install("xlsx")) from None
        if grid.size >= _MOST_ROWS:
            problem = f"{grid.size} cells: a sheet of a workbook holds {_MOST_ROWS - 1}"
            raise InputError(problem, hint="ask for fewer values, or write a folder, such as -o wide.parquet")
        self._grid, self._table, self._view = grid, table, view
        self._book = xlsxwriter.Workbook(path, {"constant_memory": True, "tmpdir": str(scratch)})
        self._book.use_zip64()
        self._bold = self._book.add_format({"bold": True, "bottom": 1})
        self._summary, self._cells = self._sheet("Summary"), self._sheet("Cells")
        for place, column in enumerate(table.columns):
            self._cells.set_column(place, place, max(_WIDTH, len(column.name) + 3))
            self._cells.write_string(0, place, column.name, self._bold)
        self._cells.freeze_panes(1, 0)
        self._cells.repeat_rows(0)
        self._cells.autofilter(0, 0, grid.size, len(table.columns) - 1)
        self._row = 1
        self._kept: dict[str, list[Any]] = {c.name: [] for c in table.columns if c.name in _OVER_AXES}

    def write(self, cells: pa.Table) -> None:
        """Write a row a cell."""
        for name, kept in self._kept.items():
            kept += cells[name].to_pylist()
        for row in zip(*(column.to_pylist() for column in cells.columns), strict=True):
            self._write_row(self._cells, self._row, row)
            self._row += 1

    def close(self, record: Mapping[str, Any], pictures: Mapping[str, bytes]) -> None:
        """Write the other sheets, and the file.

        Parameters
        ----------
        record : mapping
            The description of the run, as in its JSON.
        pictures : mapping of str to bytes
            PNG, by name.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        from xlsxwriter.exceptions import FileCreateError

        self._book.set_properties({"title": visible(record.get("name", "")), "created": datetime(2000, 1, 1)})
        for row, cells in enumerate(self._overview(record)):
            self._write_row(self._summary, row, cells, self._bold if len(cells) == 1 else None)
        self._summary.set_column(0, 2, 26)
        if self._view is not None and self._view.y is not None and len(self._view.x) < _MOST_COLUMNS:
            for name, values in self._kept.items():
                if any(value not in (None, 0.0) for value in values):
                    self._add_matrices(name, np.array(values, object).reshape(self._grid.shape))
        for name, png in pictures.items():
            sheet = self._sheet(f"Picture of {name}"[:_LONGEST_NAME])
            sheet.insert_image(0, 0, f"{name}.png", {"image_data": io.BytesIO(png)})
        try:
            self._book.close()
        except FileCreateError as exc:
            raise exc.args[0] from None  # the system's own error

    def _sheet(self, name: str) -> Any:
        """Add a sheet, which is printed as wide as a page."""
        sheet = self._book.add_worksheet(name)
        sheet.set_landscape()
        sheet.fit_to_pages(1, 0)
        return sheet

    def _write_row(self, sheet: Any, row: int, cells: Iterable[Any], style: Any = None) -> None:
        """Write numbers as numbers, and all texts as texts: none is a formula, or a link."""
        for place, cell in enumerate(cells):
            if isinstance(cell, str):
                text = visible(cell)[: _MOST_CHARACTERS - 1]
                if text.startswith("<r>"):  # which XlsxWriter takes for markup if it ends in it, too
                    text += " "
                sheet.write_string(row, place, text, style)
            elif cell is not None and math.isfinite(cell):
                sheet.write_number(row, place, cell, style)

    def _overview(self, record: Mapping[str, Any]) -> Iterator[tuple[Any, ...]]:
        """Yield what was solved and what was found, a row each; one of a single cell is a heading."""
        grid, axes, cells = self._grid, self._grid.given_axes, record["cells"]
        yield (record.get("name") or "Sweep",)
        yield "command", shlex.join(map(str, record.get("argv", ())))
        yield "vibro", record.get("version", "")
        yield ("Scene",)
        meanings = {quantity.column: quantity.meaning for quantity in QUANTITIES.values()}
        for column, value in record["scene"].items():
            yield column, value, "", meanings[column]
        for key, value in {**record.get("motion", {}), **record.get("part", {})}.items():
            yield key, json.dumps(value)
        yield ("Axes",)
        for axis in axes.values():
            yield axis.column, str(axis).partition(": ")[2]
        yield ("Cells",)
        yield "in all", cells
        messages = {status.label: status.message for status in Status}
        for label, count in {**record["regime"], **record["status"]}.items():
            yield label, count, f"{count / cells:.2%}", messages.get(label, "")
        for label, cell in record["peaks"].items():
            values = grid.as_given({name: cell[axis.column] for name, axis in grid.axes.items()})
            place = ", ".join(f"{axis.column} = {values[name]:.10g}" for name, axis in axes.items())
            yield label.replace("_", " "), cell["mean_velocity_mm_s"], "mm/s", place
        yield ("Columns of Cells",)
        for column in self._table.columns:
            yield column.name, column.unit, "", column.meaning

    def _add_matrices(self, name: str, values: NDArray[Any]) -> None:
        """Add a sheet of a result over two axes: one matrix, or one for each value of a third axis."""
        view = self._view
        assert view is not None
        assert view.y is not None
        sheet, axes = self._sheet(_OVER_AXES[name]), self._grid.given_axes
        styles = {}
        for regime, colour in REGIME_COLOURS.items():
            ink = "#FFFFFF" if regime is Regime.HOPPING else INK
            look = {"bg_color": colour, "font_color": ink, "align": "center"}
            styles[regime.label] = self._book.add_format(look)
        of_axes = self._book.add_format({"bold": True, "num_format": "0.####"})
        sheet.set_column(0, len(view.x), _WIDTH)
        sheet.freeze_panes(2 if view.facet is None else 0, 1)
        row = 0
        for facet in view.facet_indices:
            held = {**view.held, **({} if view.facet is None else {view.facet.name: facet})}
            matrix = values[tuple(held.get(of, slice(None)) for of in axes)]
            if next(of for of in axes if of not in held) == view.x.name:
                matrix = matrix.T
            at = ", ".join(f"{axes[of].label} = {value_of(axes[of], i)}" for of, i in held.items())
            title = f"{name}: {view.y.column} down, {view.x.column} across{'; ' if at else ''}{at}"
            self._write_row(sheet, row, (title,), self._bold)
            self._write_row(sheet, row + 1, ("", *view.x.values.tolist()), of_axes)
            self._write_matrix(sheet, row + 2, matrix, view.y.values.tolist(), styles, of_axes)
            row += len(view.y) + 3

    def _write_matrix(
        self, sheet: Any, first: int, matrix: NDArray[Any], y: list[float], styles: Any, of_axes: Any
    ) -> None:
        """Write the rows of a matrix, each after its value of y: texts in their colours, or numbers."""
        known = [cell for cell in matrix.ravel().tolist() if isinstance(cell, float)]
        shown = self._book.add_format({"num_format": _number_format(known)})
        for row, (value, cells) in enumerate(zip(y, matrix.tolist(), strict=True), first):
            sheet.write_number(row, 0, value, of_axes)
            for place, cell in enumerate(cells, 1):
                if isinstance(cell, str):
                    sheet.write_string(row, place, cell, styles.get(cell))
                elif cell is not None:
                    sheet.write_number(row, place, cell, shown)
        if known:
            backwards = _BACKWARDS if min(known) < 0.0 else {}
            last = first + len(y) - 1
            sheet.conditional_format(first, 1, last, matrix.shape[1], {**_COLOURS, **backwards})


def _number_format(values: Sequence[float]) -> str:
    """Return a format that shows four digits of most numbers; what a cell holds is exact."""
    sizes = sorted(abs(value) for value in values if value) or [1.0]
    power, most = (math.floor(math.log10(size)) for size in (sizes[len(sizes) // 2], sizes[-1]))
    if not -_DECIMALS < power <= most < _DECIMALS:
        return "0.000E+00"
    return "0." + "0" * (3 - power) if power < 3 else "0"
