"""What the commands about motion in time share: their files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vibro.cli.output import table_stream
from vibro.files.outputs import output_stem
from vibro.files.publication import Publication
from vibro.files.tables import CsvFormat
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from matplotlib.figure import Figure

    from vibro.cli.console import Console
    from vibro.cli.options import Options
    from vibro.files.tables import TableColumns
    from vibro.sweeps.request import Request

__all__ = ["scene_record", "write_series"]


def scene_record(request: Request) -> dict[str, float]:
    """Return the quantities of a request by their columns, as given."""
    return {QUANTITIES[name].column: spec.value for name, spec in request.specs.items()}


def write_series(
    name: str,
    tables: Mapping[str, TableColumns],
    draw: Callable[[], Figure],
    content: Mapping[str, Any],
    *,
    formats: Sequence[str],
    options: Options,
    argv: Sequence[str],
    console: Console,
) -> None:
    """Write tables, a picture and a sidecar, all or none; or the first table to stdout.

    Parameters
    ----------
    name : str
        The files' name where the options name none.
    tables : mapping of str to mapping
        Columns by their header, by the name that is appended to the stem.
    draw : callable
        Makes the picture.
    content : mapping
        What the sidecar says beside version, arguments and files.
    formats : sequence of str
        Of the picture.
    options : Options
        Where to write, and how.
    argv : sequence of str
        The arguments as typed.
    console : Console
        For messages.

    Raises
    ------
    InputError, FileError
        If the files cannot be written.
    """
    form = CsvFormat(options.excel, options.decimal_comma)
    if options.output == "-":
        table_stream(json=options.json).write(form.table(next(iter(tables.values()))))
        return
    stem = output_stem(options.output, name)
    with Publication(
        stem, argv, force=options.force, tables=list(tables), pictures=("",), formats=formats
    ) as files:
        for table, columns in tables.items():
            with files.table(table) as stream:
                stream.write(form.table(columns))
        from vibro.plots import save

        figure = draw()
        files.finish(content, lambda _, path, form_, metadata: save(figure, path, form_, metadata))
    if console.is_terminal:
        for target in files.targets:
            console.echo(f"wrote {target}")
