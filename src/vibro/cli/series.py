"""What the commands share that write tables over time, of methods or of designs: their files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

from vibro.cli.output import table_stream
from vibro.files.publication import Publication
from vibro.files.stems import output_stem
from vibro.files.tables import CsvFormat
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path
    from types import TracebackType

    from matplotlib.figure import Figure

    from vibro.cli.console import Console
    from vibro.cli.options import Options
    from vibro.files.tables import TableColumns
    from vibro.sweeps.request import Request

__all__ = ["SeriesOutput", "scene_record"]


def scene_record(request: Request) -> dict[str, float]:
    """Return the quantities of a request by their columns, as given."""
    return {QUANTITIES[name].column: spec.value for name, spec in request.specs.items()}


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
        self._stream = table_stream(json=options.json) if options.output == "-" else None
        self._files: Publication | None = None
        if options.output not in (None, "-"):
            self._files = Publication(
                output_stem(options.output, name),
                argv,
                force=options.force,
                tell=console.echo,
                tables=tables,
                pictures=pictures,
                formats=formats,
                reads=reads,
            )

    @property
    def takes_stdout(self) -> bool:
        """Whether stdout is for the table alone."""
        return self._stream is not None

    def write(
        self,
        tables: Callable[[], Mapping[str, TableColumns]],
        draw: Callable[[], Mapping[str, Figure]],
        content: Mapping[str, Any],
    ) -> None:
        """Write what is wanted of it.

        Parameters
        ----------
        tables : callable
            Makes the columns by their header, by the name of the table.
        draw : callable
            Makes the pictures, by their names: all of them, or none if there is nothing to be drawn.
        content : mapping
            What the sidecar says beside version, arguments and files.
        """
        if self._stream:
            self._stream.write(self._form.table(next(iter(tables().values()))))
        if not self._files:
            return
        for name, columns in tables().items():
            with self._files.table(name) as stream:
                stream.write(self._form.table(columns))
        from vibro.plots import save

        figures = draw()

        def save_one(name: str, path: Path, form: str, metadata: Mapping[str, str]) -> None:
            save(figures[name], path, form, metadata)

        self._files.finish(content, save_one if figures else None)

    def __enter__(self) -> Self:
        if self._files:
            self._files.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, exc: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if self._files:
            self._files.__exit__(kind, exc, traceback)
