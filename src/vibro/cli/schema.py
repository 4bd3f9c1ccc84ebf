"""``vibro schema``: the JSON Schema of scene files and designs, for editors."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import (
    DebugOption,
    ForceOption,
    HelpAllOption,
    Options,
    QuietOption,
    VersionOption,
    output_option,
)  # fmt: skip


class SchemaOf(StrEnum):
    """The kinds of file that have a schema."""

    SCENE = "scene"
    DESIGN = "design"


def schema_command(
    kind: Annotated[
        SchemaOf, typer.Argument(metavar="scene|design", help="The kind of file.")
    ] = SchemaOf.SCENE,
    output: output_option(("json",)) = None,  # type: ignore[valid-type]
    force: ForceOption = False,
    quiet: QuietOption = False,
    debug: DebugOption = False,
    version: VersionOption = False,
    help_all: HelpAllOption = False,
) -> int:
    """Print the JSON Schema of scene files, or of the questions of vibro design.

    Editors complete and check the files with it: keys, units, ranges, and what each key means.
    """
    from vibro.cli.console import Console
    from vibro.cli.outputs import Outputs
    from vibro.files.descriptions import FILES
    from vibro.files.json_schema import schema_of
    from vibro.tables.record import json_text

    text = json_text(schema_of(FILES[kind])) + "\n"
    options = Options(console=Console(quiet=quiet), output=output or ["-"], force=force)
    with Outputs(options, f"vibro-{kind}.schema", forms=("json",), pictures=()) as files:
        files.write_texts({"json": lambda _: text})
        files.finish()
    if files.takes_stdout:
        print(text, end="")
    return ExitCode.DONE
