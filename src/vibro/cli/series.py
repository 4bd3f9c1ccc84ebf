"""What the commands share that write tables over time, of methods or of designs: their files."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any, Self

from vibro.cli.answer import check_stdout
from vibro.cli.stems import output_stem
from vibro.files.csv_tables import CsvFormat
from vibro.output.staging import Staging
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path
    from types import TracebackType

    from matplotlib.figure import Figure

    from vibro.cli.console import Console
    from vibro.cli.options import Options
    from vibro.files.csv_tables import TableColumns
    from vibro.sweeps.request import Request

__all__ = ["SeriesOutput", "scene_record"]


def scene_record(request: Request) -> dict[str, Any]:
    """Return the quantities of a request by their columns, as given, and its machine."""
    machine = {} if request.machine is None else {"machine": dict(request.machine.table)}
    return {QUANTITIES[name].column: spec.value for name, spec in request.specs.items()} | machine


class SeriesOutput:
    """Where tables, pictures and a sidecar go: to files, all or none; the first table to stdout; or nowhere.

    To be entered before anything is computed: that claims the files.

    Parameters
    ----------
    name : str
        The files' name where the options name a folder.
    tables : sequence of str
        What is appended to the stem for each table.
    pictures : sequence of str
        The same for each picture.
    formats : sequence of str
        Of every picture.
    options : Options
        Where to write, and how.
    argv : sequence of str
        The arguments as typed.
    console : Console
        For messages.
    reads : sequence of Path or None
        Files that are never replaced: the run's own input.

    Attributes
    ----------
    takes_stdout : bool
        Whether stdout is for the table alone.
    writes_files : bool
        Whether there will be files.

    Raises
    ------
    InputError, FileError
        If the files cannot be written.
    """

    def __init__(
        self,
        name: str,
        tables: Sequence[str],
        *,
        pictures: Sequence[str] = ("",),
        formats: Sequence[str],
        options: Options,
        argv: Sequence[str],
        console: Console,
        reads: Sequence[Path | None] = (),
    ) -> None:
        self._form = CsvFormat(options.excel, options.decimal_comma)
        self._argv, self._console = argv, console
        self.takes_stdout = options.output == "-"
        self.writes_files = options.output is not None and not self.takes_stdout
        self._files: Staging | None = None
        if self.takes_stdout:
            check_stdout(json=options.json)
        elif options.output is not None:
            self._files = Staging(
                output_stem(options.output, name),
                force=options.force,
                tables=dict.fromkeys(tables, "csv"),
                pictures=pictures,
                formats=formats,
                reads=reads,
            )

    def write(
        self,
        tables: Callable[[], Mapping[str, TableColumns]],
        draw: Callable[[], Mapping[str, Figure]],
        content: Mapping[str, Any],
    ) -> None:
        """Write the requested files.

        Parameters
        ----------
        tables : callable
            Makes the columns by their header, by the name of the table.
        draw : callable
            Makes the pictures, by their names: all of them, or none.
        content : mapping
            What the sidecar says beside version, arguments and files.
        """
        if self.takes_stdout:
            sys.stdout.buffer.write(self._form.table(next(iter(tables().values()))))
        if not self._files:
            return
        for name, columns in tables().items():
            self._files.table(name).write_bytes(self._form.table(columns))
        self._files.finish(self._argv, content, draw())
        self._console.echo_all(self._files.told)

    def __enter__(self) -> Self:
        if self._files:
            self._files.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._files:
            self._files.__exit__(kind, exc, traceback)
