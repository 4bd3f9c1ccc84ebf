"""``vibro schema``: the JSON Schema of scene files and designs, for editors."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import DebugOption, ForceOption, OutputOption, QuietOption, VersionOption

__all__ = ["SchemaOf", "schema_command"]


class SchemaOf(StrEnum):
    """The kinds of file that have a schema."""

    SCENE = "scene"
    DESIGN = "design"


def schema_command(
    kind: Annotated[
        SchemaOf, typer.Argument(metavar="scene|design", help="The kind of file.")
    ] = SchemaOf.SCENE,
    output: OutputOption = None,
    force: ForceOption = False,
    quiet: QuietOption = False,
    debug: DebugOption = False,
    version: VersionOption = False,
) -> int:
    """Print the JSON Schema of scene files, or of the questions of vibro design.

    Editors complete and check the files with it: keys, units, ranges, and what each key means. With -o it
    goes to STEM.json.
    """
    from vibro.cli.console import Console
    from vibro.cli.stems import output_stem
    from vibro.files.descriptions import FILES
    from vibro.files.json_schema import schema_of
    from vibro.output.record import json_text
    from vibro.output.staging import Staging

    text = json_text(schema_of(FILES[kind]))
    if output in (None, "-"):
        print(text)
        return ExitCode.DONE
    stem = output_stem(output, f"vibro-{kind}.schema")
    with Staging(stem, force=force, tables={"": "json"}, described=False) as files:
        files.table().write_text(text + "\n", encoding="utf-8")
        files.finish()
    Console(quiet=quiet).echo_all(files.told)
    return ExitCode.DONE
