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
    options = Options(output=output or ["-"], force=force)
    console = Console(quiet=quiet)
    with Outputs(options, f"vibro-{kind}.schema", (), console, forms=("json",), pictures=()) as files:
        files.write_text(text)
    return ExitCode.DONE
