"""What vibro says, word for word: the sessions in the ``*.txt`` beside this file, run and compared.

README.md shows their form; ``pytest --update-messages`` writes what is said now, to be read in review.
"""

from __future__ import annotations

import contextlib
import difflib
import io
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from typer.testing import CliRunner

import vibro
from vibro.cli.app import app

HERE: Final = Path(__file__).parent
EXAMPLES: Final = HERE.parents[1] / "examples"
# A call with the lines that continue it, its answer, and blank lines.
_CALL: Final = re.compile(
    r"  (?P<prompt>\$|>>>) (?P<call>.*\n(?:  (?:>|\.\.\.)(?: .*)?\n)*)(?:(?:  (?!\$ |>>> ).*)?\n)*"
)


def _vibro(call: str) -> str:
    """Run the command in this process; a shell takes what it prints, where ``|`` or ``>`` follow."""
    arguments, both, pipe = re.split(r"(?:\s+(2>&1))?(?:\s+([|>] .*))?$", call, maxsplit=1, flags=re.DOTALL)[
        :3
    ]
    result = CliRunner().invoke(app, [os.path.expandvars(one) for one in shlex.split(arguments)[1:]])
    out, err = (result.stderr + result.stdout, "") if both else (result.stdout, result.stderr)
    if pipe:
        out = _shell(f"cat {pipe}", out)
    # An error is on stderr, an answer on stdout, unless it is said otherwise.
    if result.exit_code:
        return f"[exit {result.exit_code}]\n{err}" + (f"[stdout]\n{out}" if out else "")
    return out + (f"[stderr]\n{err}" if err else "")


def _shell(call: str, given: str = "") -> str:
    """Return what a shell's command prints; of one that fails this is why, and stands in the session."""
    how: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    return str(subprocess.run(call, shell=True, check=False, text=True, input=given, **how).stdout)


def _python(call: str, names: dict[str, Any]) -> str:
    """Evaluate a statement; an error is its last line and its notes, without the traceback."""
    with contextlib.redirect_stdout(io.StringIO()) as out:
        try:
            exec(compile(call, "<call>", "single"), names)
        except Exception as exc:
            print(f"{type(exc).__name__}: {exc}", *getattr(exc, "__notes__", ()), sep="\n")
    return out.getvalue()


def replay(session: str, folder: Path, patch: pytest.MonkeyPatch) -> str:
    """Return a session with the answers of today; each passage of text begins in a new folder."""
    said, end, names = [], 0, dict[str, Any]()
    for match in _CALL.finditer(session):
        if end == 0 or match.start() > end:
            place = folder / str(end)
            shutil.copytree(HERE / "files", place)
            patch.undo()
            patch.setenv("COLUMNS", "80")
            patch.setenv("EXAMPLES", str(EXAMPLES))
            patch.chdir(place)
            names = {"vibro": vibro, "np": np, "math": math, "Path": Path, "patch": patch}
        call = re.sub(r"^  (>|\.\.\.) ?", "", match["call"], flags=re.MULTILINE)
        if match["prompt"] == ">>>":
            answer = _python(call, names)
        else:
            answer = _vibro(call.replace("\\\n", " ").rstrip()) if call.startswith("vibro ") else _shell(call)
        answer = answer.replace(str(place), "{folder}").replace(str(EXAMPLES), "$EXAMPLES")
        assert not answer or answer.endswith("\n"), f"a line without an end: {answer!r}"
        told = textwrap.indent(answer, "  ")
        said += [session[end : match.start()], f"  {match['prompt']} {match['call']}{told}\n"]
        end = match.end()
    return "".join([*said, session[end:]]).rstrip("\n") + "\n"


@pytest.mark.skipif(sys.platform == "win32", reason="a POSIX shell")
@pytest.mark.parametrize("path", sorted(HERE.glob("*.txt")), ids=lambda path: path.stem)
def test_messages(path: Path, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    session = path.read_text(encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        said = replay(session, tmp_path, patch)
    if request.config.getoption("update_messages"):
        path.write_text(said, encoding="utf-8")
    elif said != session:
        lines = difflib.unified_diff(session.splitlines(), said.splitlines(), "expected", "said", lineterm="")
        pytest.fail("\n".join(["pytest --update-messages writes what is said now", *lines]), pytrace=False)
