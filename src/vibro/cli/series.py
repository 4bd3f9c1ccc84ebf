"""What the commands about motion in time share: one scene from a request, and their files."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from vibro import __version__
from vibro.cli.output import table_stream
from vibro.files.outputs import OutputSet, output_stem, suffixed, write_json
from vibro.quantities import QUANTITIES, to_si
from vibro.scene import Scene
from vibro.sweeps.columns import CsvFormat

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from matplotlib.figure import Figure

    from vibro.cli.console import Console
    from vibro.cli.options import Options
    from vibro.cli.request import Request
    from vibro.sweeps.columns import TableColumns

__all__ = ["scene_of", "scene_record", "write_series"]


def scene_of(request: Request) -> Scene:
    """Make the scene of a request without axes."""
    given = {name: spec.value for name, spec in request.specs.items() if name != "trough_length"}
    values = {name: to_si(name, value) for name, value in given.items()}
    if "friction_ratio" in values:
        values["kinetic_friction"] = values.pop("friction_ratio") * values["static_friction"]
    return Scene(**values)


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
        Columns by their header, by what is appended to the stem before ``.csv``.
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
    sheets = {suffixed(stem, f"{suffix}.csv"): columns for suffix, columns in tables.items()}
    pictures = {suffixed(stem, f".{form_}"): form_ for form_ in formats}
    sidecar = suffixed(stem, ".json")
    targets = [*sheets, *pictures, sidecar]
    with OutputSet(targets, force=options.force) as files:
        whole = {
            "version": __version__,
            "argv": ["vibro", *argv],
            **content,
            "files": [target.name for target in targets],
        }
        for path, columns in sheets.items():
            files[path].write_text(form.table(columns), encoding="utf-8", newline="")
        if pictures:
            from vibro.plots import save

            figure = draw()
            metadata = {
                "Title": targets[0].name,
                "Software": f"vibro {__version__}",
                "Description": json.dumps(whole, allow_nan=False),
            }
            for path, form_ in pictures.items():
                save(figure, files[path], form_, metadata)
        write_json(files[sidecar], whole)
    if console.is_terminal:
        for target in targets:
            console.echo(f"wrote {target}")
