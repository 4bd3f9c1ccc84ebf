"""Files are put in place all together, whatever fails and whoever dies between the steps."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.outputs import NAMES, POSIX, every, fail_at, output_set, put, texts, visible

from vibro.errors import FileError


@POSIX
@pytest.mark.parametrize("for_good", [False, True], ids=["once", "for good"])
@pytest.mark.parametrize("force", [False, True], ids=["new", "force"])
def test_a_failure_between_the_steps_of_publishing_mixes_nothing(
    tmp_path: Path, force: bool, for_good: bool
) -> None:
    old = ("x.csv", "x-flight.png", "x-speed.png", "x.json")
    failures = 0
    for which in range(1, 100):
        folder = tmp_path / str(which)
        if force:
            put(folder, *old, text="old")
        with pytest.MonkeyPatch.context() as patch:
            try:
                with output_set(folder, force=force) as output:
                    for name in NAMES:
                        output[folder / name].write_text("new", encoding="utf-8")
                    taken = fail_at(patch, which, for_good=for_good)
            except FileError:
                failures += 1
                left = visible(folder) if folder.exists() else {}
                before = every("old", *old) if force else {}
                if for_good:  # what is there cannot all be put back: then it does not look whole
                    assert left == before or "x.json" not in left
                else:
                    assert left == before
            else:
                assert visible(folder) == every("new")
        put(folder, force=True)
        assert texts(folder) == every("new")
        if len(taken) < which:
            break
    assert failures >= (7 if force else 3)


@POSIX
@pytest.mark.parametrize("number", [errno.EPERM, errno.ENOTSUP, errno.EXDEV])
def test_a_file_system_without_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    def refuse(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("os.link", refuse)
    put(tmp_path)
    with pytest.raises(FileError, match="exist already"):
        put(tmp_path, text="newer")
    put(tmp_path, text="newest", force=True)
    assert texts(tmp_path) == every("newest")


@POSIX
@pytest.mark.parametrize("links", [True, False])
def test_what_another_program_puts_there_meanwhile_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, links: bool
) -> None:
    if not links:
        monkeypatch.setattr("vibro.files.placing._NO_LINKS", {errno.EEXIST})
    output = output_set(tmp_path).__enter__()
    for name in NAMES:
        output[tmp_path / name].write_text("new", encoding="utf-8")
    (tmp_path / "x-speed.png").write_text("theirs", encoding="utf-8")
    with pytest.raises(FileError, match=r"x-speed\.png exists already"):
        output.__exit__(None, None, None)
    assert texts(tmp_path) == {"x-speed.png": "theirs"}


def held_open(monkeypatch: pytest.MonkeyPatch, times: int) -> list[float]:
    """Let a program hold a target open for so many attempts; return the pauses between them."""
    replace, failures, pauses = Path.replace, iter(range(times)), list[float]()

    def held(path: Path, target: Path) -> Path:
        if next(failures, None) is not None:
            raise PermissionError(errno.EACCES, "Permission denied", str(target))
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", held)
    monkeypatch.setattr("time.sleep", pauses.append)
    return pauses


def test_a_file_that_a_spreadsheet_holds_is_retried(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put(tmp_path, text="old")
    pauses = held_open(monkeypatch, 3)
    put(tmp_path, force=True)
    assert len(pauses) == 3
    assert texts(tmp_path) == every("new")


def test_a_file_that_stays_held_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put(tmp_path, text="old")
    held_open(monkeypatch, 10)
    with pytest.raises(FileError, match=r"cannot replace .*x\.csv") as caught:
        put(tmp_path, force=True)
    assert caught.value.hint == "close it in the program that holds it open"
    assert texts(tmp_path) == every("old")


@POSIX
@pytest.mark.parametrize(
    "how", ["between-steps", "between-steps-of-force", "any-time", "at-once", "at-once-with-force"]
)
def test_runs_that_are_killed_and_runs_that_meet_mix_nothing(tmp_path: Path, how: str) -> None:
    # in a process of its own: one with threads, such as this, must not fork
    done = subprocess.run(
        [sys.executable, "-m", "helpers.writers", how, str(tmp_path)],
        cwd=Path(__file__).parents[1], capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
