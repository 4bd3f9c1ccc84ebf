"""Sets of output files, written as runs do."""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path

import pytest

from vibro.files.outputs import OutputSet

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="links, SIGKILL, file modes")
NAMES = ("x.csv", "x-speed.png", "x.json")


def output_set(folder: Path, *names: str, force: bool = False, told: list[str] | None = None) -> OutputSet:
    """Make a set whose stem is x; what it tells goes to a list."""
    tell = ([] if told is None else told).append
    return OutputSet(folder / "x", [folder / name for name in names or NAMES], force=force, tell=tell)


def put(
    folder: Path, *names: str, text: str = "new", force: bool = False, error: BaseException | None = None
) -> list[str]:
    """Write files as a run does, which may end early; return what it tells."""
    told: list[str] = []
    with output_set(folder, *names, force=force, told=told) as output:
        for name in names or NAMES:
            output[folder / name].write_text(text, encoding="utf-8")
        if error:
            raise error
    return told


def texts(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}


def every(text: str, *names: str) -> dict[str, str]:
    return dict.fromkeys(names or NAMES, text)


def visible(folder: Path) -> dict[str, str]:
    """Return the files themselves, without what waits."""
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir() if path.is_file()}


STEPS = ("link", "rename", "replace", "unlink", "chmod")


def fail_at(
    monkeypatch: pytest.MonkeyPatch, which: int, *, for_good: bool, number: int = errno.EIO
) -> list[str]:
    """Let a step of publishing fail, and all later ones too if wanted; return the steps that were taken."""
    taken: list[str] = []

    def failing(name: str) -> None:
        real = getattr(os, name)

        def step(*args: object, **options: object) -> object:
            taken.append(name)
            if len(taken) == which or (for_good and len(taken) > which):
                raise OSError(number, os.strerror(number))
            return real(*args, **options)

        monkeypatch.setattr(f"os.{name}", step)

    for name in STEPS:
        failing(name)
    return taken
