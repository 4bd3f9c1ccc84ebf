"""What the reference takes from the code: a page a command, JSON Schemas, signatures of what people make.

``reference/commands`` and ``_made`` are made anew by each build.
"""

from __future__ import annotations

import re
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from sphinx.util.rst import escape

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sphinx.application import Sphinx

DOCS: Final = Path(__file__).parents[1]
COMMANDS: Final = DOCS / "reference" / "commands"
MADE: Final = DOCS / "_made"
MADE_BY_HAND: Final = ("Scene", "Calibration")  #: classes that people call
OPTION: Final = re.compile(r"((?<![\w-])--?[A-Za-z][\w-]*)")


class Groups:
    """Takes what a command writes as help, in place of a formatter: rows of options by group."""

    def __init__(self) -> None:
        self.rows: dict[str, list[tuple[str, str]]] = {}

    @contextmanager
    def section(self, name: str) -> Iterator[None]:
        """Begin a group."""
        self.rows[name] = []
        yield

    def write_dl(self, rows: list[tuple[str, str]]) -> None:
        """Take the rows of the last group."""
        self.rows[list(self.rows)[-1]] += rows


def _text(told: str) -> str:
    """Write a help text as reStructuredText, with options as code."""
    pieces = OPTION.split(told)
    return "".join(f"``{piece}``" if i % 2 else escape(piece) for i, piece in enumerate(pieces))


def _paragraphs(told: str) -> str:
    return "\n\n".join(_text(" ".join(paragraph.split())) for paragraph in told.split("\n\n"))


def _groups(command: Any, context: Any) -> dict[str, list[tuple[str, str]]]:
    groups = Groups()
    command.format_options(context, groups)
    return groups.rows


def _page(name: str, command: Any) -> str:
    context = command.context_class(command, info_name=name)
    parts = [
        heading_of(name),
        _paragraphs(command.help),
        ".. code-block:: text\n\n   " + " ".join(command.get_usage(context).removeprefix("Usage: ").split()),
        f".. program:: {name}",
    ]
    for group, rows in _groups(command, context).items():
        parts.append(heading_of(group, "-"))
        parts += [f".. option:: {names}\n\n   {_text(told) or '..'}" for names, told in rows]
    return "\n\n".join(parts) + "\n"


def heading_of(title: str, line: str = "=") -> str:
    """Write a title."""
    return f"{title}\n{line * len(title)}"


def _index(main: Any) -> str:
    context = main.context_class(main, info_name="vibro")
    commands = main.commands.items()
    parts = [
        heading_of("Command line"),
        "What ``vibro COMMAND --help`` prints. Options may be mixed with a scene file, and override it."
        " :doc:`Exit codes <../statuses>` say how a run ended.",
        ".. toctree::\n   :hidden:\n\n" + "\n".join(f"   {name}" for name, _ in commands),
        "\n".join(
            f":doc:`vibro {name} <{name}>`\n   {_text(command.get_short_help_str())}"
            for name, command in commands
        ),
        heading_of("Options of vibro itself", "-"),
        ".. program:: vibro",
        *(
            f".. option:: {names}\n\n   {_text(told)}"
            for names, told in (p.get_help_record(context) or ("", "") for p in main.get_params(context))
            if names
        ),
    ]
    return "\n\n".join(parts) + "\n"


def _write(path: Path, text: str) -> None:
    """Write a page if it changed, so that the next build need not read it again."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def make_commands() -> None:
    """Write the pages of the command line."""
    from typer.main import get_command

    from vibro.cli.app import app

    main: Any = get_command(app)
    COMMANDS.mkdir(exist_ok=True)
    pages = {name: _page(f"vibro {name}", command) for name, command in main.commands.items()}
    pages["index"] = _index(main)
    for path in COMMANDS.iterdir():
        if path.stem not in pages:
            path.unlink()
    for name, page in pages.items():
        _write(COMMANDS / f"{name}.rst", page)


def make_schemas() -> None:
    """Write the JSON Schemas, as ``vibro schema`` does."""
    from vibro.files.descriptions import FILES
    from vibro.files.json_schema import schema_of
    from vibro.tables.record import json_text

    MADE.mkdir(exist_ok=True)
    for name, kind in FILES.items():
        _write(MADE / f"vibro-{name}.schema.json", json_text(schema_of(kind)) + "\n")


def _make(app: Sphinx) -> None:
    make_commands()
    make_schemas()


def _sign(app: Sphinx, kind: str, name: str, found: Any, options: Any, arguments: str | None, *_: Any) -> Any:
    """Leave out the arguments of a class whose objects people get and do not make."""
    if arguments and kind in ("class", "exception") and found.__name__ not in MADE_BY_HAND:
        return "", ""
    return None


def _skip(app: Sphinx, kind: str, name: str, found: Any, skip: bool, options: Any) -> bool | None:
    """Leave out the fields of named tuples, which the section Attributes describes."""
    return True if str(getattr(found, "__doc__", "")).startswith("Alias for field number") else None


def setup(app: Sphinx) -> dict[str, Any]:
    """Make the files before Sphinx looks for pages, after the commands of the pages have run."""
    app.connect("builder-inited", _make, priority=600)
    app.connect("autodoc-process-signature", _sign)
    app.connect("autodoc-skip-member", _skip)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
