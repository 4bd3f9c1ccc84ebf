"""Run the commands and scripts of a page in its order; compare what they print with what the page shows.

A ``console`` block holds one command after ``$`` and the output that it must have, where a line ``...``
stands for any lines: its answer, or of a command that has none (``vibro map``) its messages. It must end with
0, or with the code that a comment above it names: ``<!-- exit code 4 -->``. A ``bash`` block holds commands,
a ``python`` block a script. They run in a folder that has the examples, one folder a page, so that the page
can show their pictures: ``../_made/feeder/out/nut-speed.png`` is the picture that ``-o out/nut`` of
``tasks/feeder.md`` writes.
"""

from __future__ import annotations

import doctest
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Collection

    from sphinx.application import Sphinx

DOCS: Final = Path(__file__).parents[1]
BLOCK: Final = re.compile(
    r"(?:^<!-- exit code (\d+) -->\n)?^```(console|bash|python)\n(.*?)^```$", re.DOTALL | re.MULTILINE
)
KINDS: Final = ("console", "bash", "python")
SHELL: Final = ("bash", "-euo", "pipefail", "-c")
COMMAND: Final = re.compile(r"\$ ((?:[^\n]*\\\n)*[^\n]*\n)(.*)", re.DOTALL)


def pages() -> dict[Path, tuple[str, ...]]:
    """Return the pages that run, and the kinds of their blocks that do."""
    tasks = sorted({*DOCS.glob("tasks/*.md")} - {DOCS / "tasks" / "index.md"})
    tour = [DOCS.parent / "README.md", DOCS / "index.md", *sorted(DOCS.glob("guide/tour*.md"))]
    others = {*tour, DOCS / "guide" / "scale.md"}  # whose scripts tests/tables run
    guides = [
        page for page in sorted({*DOCS.glob("guide/*.md")} - others) if BLOCK.search(page.read_text("utf-8"))
    ]
    return dict.fromkeys([*tasks, *guides], KINDS) | dict.fromkeys(tour, ("console", "python"))


def run_page(page: Path, folder: Path, kinds: Collection[str] = KINDS) -> None:
    """Run all blocks of these kinds of a page in a new folder.

    Raises
    ------
    RuntimeError
        If a command fails or prints something else than the page shows.
    """
    copy_examples(folder)
    for code, kind, block in BLOCK.findall(page.read_text(encoding="utf-8")):
        if kind not in kinds:
            continue
        if kind == "python":
            output_of([sys.executable, "-c", block], page, folder)
        elif kind == "bash":
            output_of([*SHELL, block], page, folder)
        else:
            command, shown = COMMAND.findall(block)[0]
            printed = output_of([*SHELL, command], page, folder, code or "0")
            if not doctest.OutputChecker().check_output(shown, printed, doctest.ELLIPSIS):
                raise RuntimeError(f"{page.name}: {command}prints\n{printed}in place of\n{shown}")


def copy_examples(folder: Path) -> None:
    """Put the examples where the commands of a page look for them."""
    shutil.copytree(DOCS.parent / "examples", folder / "examples", ignore=shutil.ignore_patterns("gallery"))


def output_of(command: list[str], page: Path, folder: Path, code: str = "0") -> str:
    """Run a command of a page; return what it prints, its messages if it prints nothing else.

    Raises
    ------
    RuntimeError
        If it ends with another exit code.
    """
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, "PATH": path},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    if str(done.returncode) != code:
        raise RuntimeError(f"{page.name}: {command[-1]}ends with {done.returncode}:\n{done.stderr}")
    return done.stdout or done.stderr


def _make(app: Sphinx) -> None:
    made = DOCS / "_made"
    shutil.rmtree(made, ignore_errors=True)
    for page, kinds in pages().items():
        run_page(page, made / page.stem, kinds)


def setup(app: Sphinx) -> dict[str, Any]:
    """Run the pages before Sphinx reads them."""
    app.connect("builder-inited", _make)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
