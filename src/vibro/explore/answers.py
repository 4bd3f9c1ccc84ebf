"""Answers to the page's requests; maps that are still being refined are kept between requests."""

from __future__ import annotations

from collections import OrderedDict
from threading import Lock
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.core.codes import Regime, Status
from vibro.explore.bands import certain_of, searched_text
from vibro.explore.controls import CONTROLS, drives_of
from vibro.explore.form import form_html
from vibro.explore.levels import MapCells
from vibro.explore.looks import MARKS
from vibro.explore.maps import packed_map
from vibro.explore.packed_histories import packed_history
from vibro.explore.points import point_of
from vibro.files.csv_tables import CsvFormat
from vibro.quantities import QUANTITIES
from vibro.results.sweep import Block, Column
from vibro.sweeps.columns import arrow_table, table_columns
from vibro.sweeps.grid import scene_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vibro.explore.state import State

__all__ = ["Answers"]

_KEPT: Final = 16  # maps of about 8 MB
_PATIENCE: Final = 0.05  # [s] to wait for a first picture while somebody moves a slider
_REQUEST_TIME: Final = 0.1  # [s] of work on a map for one request


class Answers:
    """Answers to all requests of the page; safe to call from any thread.

    Parameters
    ----------
    initial : State
        State at the start.
    """

    def __init__(self, initial: State) -> None:
        self._initial = initial
        self._maps: OrderedDict[str, _Kept] = OrderedDict()
        self._lock = Lock()
        self._pace = _Pace()

    def schema(self) -> dict[str, Any]:
        """Return what the page has to know at the start, as JSON values.

        Returns
        -------
        dict
            ``initial``, the state at the start; ``form``, the settings as HTML; ``idle``, for each drive the
            keys of quantities that it does not have; ``regimes`` and ``statuses`` of cells; ``marks``, the
            bits of marks on cells.
        """
        drives = self._initial.drives
        columns = {name: QUANTITIES[name].column for name in CONTROLS if name != "friction_ratio"}
        return {
            "initial": dict(self._initial.texts),
            "form": form_html(self._initial),
            "idle": {
                drive: [column for name, column in columns.items() if drive not in drives_of(name, drives)]
                for drive in drives
            },
            "regimes": [{"code": int(regime), "label": regime.label} for regime in Regime],
            "statuses": [{"code": int(s), "message": "" if s is Status.OK else s.message} for s in Status],
            "marks": MARKS,
        }

    def map(self, state: State, *, advance: bool = False) -> bytes:
        """Return a map as ``packed_map`` does, as it is or after some more work."""
        kept = self._kept(state)
        return packed_map(state, kept.cells(_REQUEST_TIME if advance else 0.0).shown)

    def point(self, state: State) -> dict[str, Any]:
        """Return the report on the operating point, as JSON values."""
        return point_of(state)

    def guarantee(self, state: State) -> dict[str, Any]:
        """Return the searched bounds on the speed of all bodies in the bands, as JSON values."""
        return {"text": searched_text(state)}

    def history(self, state: State) -> bytes:
        """Return the motion of the operating point, as ``packed_history`` does."""
        return packed_history(state)

    def table(self, state: State, *, decimal_comma: bool = False) -> Iterator[bytes]:
        """Yield the cells of a map as CSV, piece by piece; while it is solved, empty pieces.

        The columns are those of ``vibro map``; with bands the axes and the guarantees of every cell. Its
        cells are those of the page's map, solved in turns: if the client leaves, the rest is not.
        """
        grid = state.grid()
        kept = self._kept(state)
        found = certain_of(state, scene_of(kept.cells(0.0).shown.values)) if state.bands else None
        columns = table_columns(grid)
        if found is not None:
            axes = [
                column for column in columns if column.name in {axis.column for axis in grid.axes.values()}
            ]
            labels = (*(regime.label for regime in Regime if regime >= 0), "")
            columns = (
                *axes,
                Column("lowest_regime", "", lambda block: found.lowest, labels),
                Column("highest_regime", "", lambda block: found.highest, labels),
                Column("guaranteed_speed_mm_s", "mm/s", lambda block: np.asarray(1e3 * found.speed_min)),
            )
        form = CsvFormat(decimal_comma=decimal_comma)
        yield form.header(column.name for column in columns)
        while not (shown := kept.cells(_REQUEST_TIME).shown).exact.all():
            yield b""
        yield form.rows(arrow_table(columns, Block(shown.values, shown.cycle, grid.length)))

    def _kept(self, state: State) -> _Kept:
        """Return the cells of a state's map, partly solved if it was requested before."""
        grid = state.grid()
        key = repr(
            (
                state.texts["x"],
                state.texts["x_range"],
                state.texts["y"],
                state.texts["y_range"],
                sorted(grid.fixed.items()),
            )
        )
        with self._lock:
            kept = self._maps.setdefault(key, _Kept(state, self._pace))
            self._maps.move_to_end(key)
            while len(self._maps) > _KEPT:
                self._maps.popitem(last=False)
        return kept


class _Pace:
    """How long the first loads of the last map took [s]."""

    took = 0.0


class _Kept:
    """A map that is kept: several threads may ask for it, one at a time works on it."""

    def __init__(self, state: State, pace: _Pace) -> None:
        self._state = state
        self._pace = pace
        self._cells: MapCells | None = None
        self._lock = Lock()

    def cells(self, seconds: float) -> MapCells:
        """Return the cells, after so much work on them."""
        cells = self._cells
        if cells is None or (seconds and not cells.shown.is_done):
            with self._lock:
                if self._cells is None:
                    self._cells = MapCells(self._state.grid(), patience=_PATIENCE, expected=self._pace.took)
                if seconds:
                    self._cells.advance(seconds)
                cells = self._cells
                self._pace.took = cells.took or self._pace.took
        return cells
