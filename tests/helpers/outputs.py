"""Sets of output files, written as runs do."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import pytest

from vibro.output.staging import Staging

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="links, SIGKILL, file modes")
NAMES = ("x.csv", "x-speed.png", "x.json")
STEPS = ("mkdir", "link", "rename", "replace", "unlink", "rmdir", "chmod")
"""What puts files in place, or removes them."""


class Picture:
    """A picture that is a text."""

    def __init__(self, text: str) -> None:
        self._text = text

    def get_label(self) -> str:
        return "picture"

    def savefig(self, path: Path, **_: Any) -> None:
        path.write_text(self._text, encoding="utf-8")


def staging(folder: Path, *, force: bool = False, pictures: tuple[str, ...] = ("speed",)) -> Staging:
    """Make a set whose stem is x."""
    return Staging(folder / "x", force=force, pictures=pictures, formats=("png",))


def put(
    folder: Path, *, text: str = "new", force: bool = False, pictures: tuple[str, ...] = ("speed",),
    error: BaseException | None = None,
) -> list[str]:  # fmt: skip
    """Write a set as a run does, which may end early; return what it tells."""
    with staging(folder, force=force, pictures=pictures) as files:
        files.table().write_text(text, encoding="utf-8")
        if error:
            raise error
        figures: dict[str, Any] = {name: Picture(text) for name in pictures}
        files.finish(["map"], {"text": text}, figures)
    return files.told


def texts(folder: Path) -> dict[str, str]:
    """Return the files of a folder; of a JSON the text that it was written with."""
    found = {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir() if path.is_file()}
    return {name: text.split('"text": "')[1].split('"')[0] if '"text": "' in text else text
            for name, text in found.items()}  # fmt: skip


def every(text: str, *names: str) -> dict[str, str]:
    return dict.fromkeys(names or NAMES, text)


def at_each_step(monkeypatch: pytest.MonkeyPatch, which: int, act: Any) -> list[str]:
    """Let ``act`` happen before the step of that number; return the names of the steps taken."""
    taken: list[str] = []

    def watched(name: str) -> None:
        real = getattr(os, name)

        def step(*args: object, **options: object) -> object:
            taken.append(name)
            if len(taken) == which:
                act()
            return real(*args, **options)

        monkeypatch.setattr(f"os.{name}", step)

    for name in STEPS:
        watched(name)
    return taken
