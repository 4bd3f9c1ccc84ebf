"""Files appear when all of a set are whole, the JSON last, and nothing else is ever touched."""

from __future__ import annotations

import errno
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any
from unittest.mock import Mock

import pytest
from helpers.commands import POSIX

import vibro.interrupts
from vibro.errors import FileError
from vibro.tables.files import whole_files

if TYPE_CHECKING:
    from collections.abc import Iterator

NAMES = ("x.csv", "x-speed.png", "x.json")


def put(
    folder: Path, text: str = "new", *, force: bool = False, during: Any = lambda: None, **how: Any
) -> None:
    """Write a set as a run does; something happens before it ends."""
    with whole_files([folder / name for name in NAMES], force=force, **how) as waiting:
        for path in waiting.values():
            path.write_text(text, encoding="utf-8")
        during()


def texts(folder: Path) -> dict[str, str]:
    """Return all files of a folder, temporary ones too."""
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir() if path.is_file()}


def every(text: str, *names: str) -> dict[str, str]:
    return dict.fromkeys(names or NAMES, text)


def test_nothing_remains_of_a_run_that_ends_early_and_what_was_there_stays(tmp_path: Path) -> None:
    put(tmp_path, "old")
    for error in (KeyboardInterrupt, ValueError):
        with pytest.raises(error):
            put(tmp_path, force=True, during=Mock(side_effect=error))
        assert texts(tmp_path) == every("old")


def test_a_signal_removes_temporary_files_alone(tmp_path: Path) -> None:
    put(tmp_path, "old")
    with whole_files([tmp_path / name for name in NAMES], force=True) as waiting:
        for target, path in waiting.items():
            assert (path.parent, path.name.rpartition("-")[0]) == (tmp_path, f".{target.name}-{os.getpid()}")
        waiting[tmp_path / "x.csv"].touch()
        assert len(texts(tmp_path)) == 4
        vibro.interrupts._acts[-1]()
        assert texts(tmp_path) == every("old")


@POSIX
def test_links_folders_and_what_the_run_reads_are_never_replaced(tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("mine", encoding="utf-8")
    target = tmp_path / "x.csv"
    for make, kind in (
        (lambda: target.symlink_to(tmp_path / "mine"), "a symbolic link"),
        (target.mkdir, "a folder"),
        (lambda: os.mkfifo(target), "no file"),
    ):
        with pytest.raises(FileError, match=f"it is {kind}"):
            put(tmp_path, force=True, during=make)
        assert {path.name for path in tmp_path.iterdir()} == {"mine", "x.csv"}
        target.rmdir() if kind == "a folder" else target.unlink()
    os.link(tmp_path / "mine", target)
    with pytest.raises(FileError, match="this run reads it"):
        put(tmp_path, force=True, reads=[tmp_path / "mine"])
    assert texts(tmp_path) == every("mine", "mine", "x.csv")


def test_a_target_that_appears_meanwhile_is_kept(tmp_path: Path) -> None:
    theirs = tmp_path / "x-speed.png"
    with pytest.raises(FileError, match=r"x-speed\.png exists already"):
        put(tmp_path, during=lambda: theirs.write_text("theirs", encoding="utf-8"))
    assert texts(tmp_path) == {"x-speed.png": "theirs"}


@POSIX
def test_a_replaced_file_keeps_its_rights_and_a_new_one_has_the_usual(tmp_path: Path) -> None:
    put(tmp_path, "old")
    (tmp_path / "x.csv").chmod(0o640)
    put(tmp_path, force=True)
    rights = [(tmp_path / name).stat().st_mode & 0o777 for name in NAMES]
    (tmp_path / "usual").touch()
    assert rights == [0o640, *[(tmp_path / "usual").stat().st_mode & 0o777] * 2]


def test_the_json_goes_first_and_comes_last_whatever_step_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So that it never stands beside files of two runs."""
    replace = Path.replace
    for steps in range(3):
        put(tmp_path, "old", force=True)
        left = iter(range(steps))

        def step(path: Path, target: Path, left: Iterator[int] = left) -> Path:
            assert not (tmp_path / "x.json").exists()
            if next(left, None) is None:
                raise OSError(errno.EIO, "Input/output error")
            return replace(path, target)

        with monkeypatch.context() as patch:
            patch.setattr(Path, "replace", step)
            with pytest.raises(FileError, match=r"cannot write to .*: Input/output error"):
                put(tmp_path, force=True)
        assert texts(tmp_path) == dict(zip(NAMES[:2], ["new"] * steps + ["old"] * 2, strict=False))


@pytest.mark.parametrize("times", [3, 10])
def test_a_file_that_a_spreadsheet_holds_is_retried_then_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, times: int
) -> None:
    put(tmp_path, "old")
    replace, failures, pauses = Path.replace, iter(range(times)), Mock()

    def held(path: Path, target: Path) -> Path:
        if next(failures, None) is not None:
            raise PermissionError(errno.EACCES, "Permission denied", str(target))
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", held)
    monkeypatch.setattr(time, "sleep", pauses)
    if times == 10:
        with pytest.raises(FileError, match=r"cannot replace .*x\.csv") as caught:
            put(tmp_path, force=True)
        assert "holds it open" in caught.value.hint
    else:
        put(tmp_path, force=True)
        assert (pauses.call_count, texts(tmp_path)) == (3, every("new"))
