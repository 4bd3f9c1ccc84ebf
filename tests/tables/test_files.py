"""Files appear when all of a set are whole, the JSON last, and nothing else is ever touched."""

from __future__ import annotations

import errno
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from helpers.commands import POSIX

import vibro.interrupts
from vibro.errors import FileError
from vibro.tables.files import hidden_folder, whole_file, whole_files

if TYPE_CHECKING:
    from collections.abc import Callable

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


def test_files_wait_beside_their_targets_and_appear_together(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    with whole_files([folder / name for name in NAMES]) as waiting:
        for target, path in waiting.items():
            assert path.parent == folder
            assert path.name.startswith(f".{target.name}-{os.getpid()}-")
            path.write_text("new", encoding="utf-8")
        assert not {*NAMES} & texts(folder).keys()
    assert texts(folder) == every("new")
    with whole_files([folder / "y.csv", folder / "y.json"]) as waiting:
        waiting[folder / "y.csv"].touch()
    assert texts(folder).keys() == {*NAMES, "y.csv"}  # what is not written is left out
    with whole_files([]) as waiting:
        assert waiting == {}


def raised(error: type[BaseException]) -> Any:
    def fail() -> None:
        raise error

    return fail


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, SystemExit, BrokenPipeError])
def test_nothing_remains_of_a_run_that_ends_early_and_what_was_there_stays(
    tmp_path: Path, error: type[BaseException]
) -> None:
    with pytest.raises(error):
        put(tmp_path, during=raised(error))
    assert texts(tmp_path) == {}
    put(tmp_path, "old")
    with pytest.raises(error):
        put(tmp_path, force=True, during=raised(error))
    assert texts(tmp_path) == every("old")


def test_a_signal_removes_temporary_files_alone(tmp_path: Path) -> None:
    put(tmp_path, "old")
    with whole_files([tmp_path / name for name in NAMES], force=True) as waiting:
        waiting[tmp_path / "x.csv"].touch()
        assert len(texts(tmp_path)) == 4
        vibro.interrupts._acts[-1]()
        assert texts(tmp_path) == every("old")


def test_existing_files_are_replaced_only_by_force(tmp_path: Path) -> None:
    put(tmp_path, "old")
    with pytest.raises(FileError, match=r"x\.csv, .*x-speed\.png, .*x\.json exist already") as caught:
        put(tmp_path)
    assert "force=True" in caught.value.hint
    assert texts(tmp_path) == every("old")
    put(tmp_path, force=True)
    assert texts(tmp_path) == every("new")


def test_a_target_that_appears_meanwhile_is_kept(tmp_path: Path) -> None:
    theirs = tmp_path / "x-speed.png"
    with pytest.raises(FileError, match=r"x-speed\.png exists already"):
        put(tmp_path, during=lambda: theirs.write_text("theirs", encoding="utf-8"))
    assert texts(tmp_path) == {"x-speed.png": "theirs"}


@POSIX
def test_links_folders_and_what_the_run_reads_are_never_replaced(tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("mine", encoding="utf-8")
    target = tmp_path / "x.csv"
    kinds: tuple[tuple[Callable[[], None], str], ...] = (
        (lambda: target.symlink_to(tmp_path / "mine"), "a symbolic link"),
        (target.mkdir, "a folder"),
        (lambda: os.mkfifo(target), "no file"),
    )
    for make, kind in kinds:
        for early in (True, False):
            if early:
                make()
            with pytest.raises(FileError, match=f"it is {kind}"):
                put(tmp_path, force=True, during=make if not early else lambda: None)
            assert {path.name for path in tmp_path.iterdir()} == {"mine", "x.csv"}
            target.rmdir() if target.is_dir() and not target.is_symlink() else target.unlink()
    os.link(tmp_path / "mine", target)
    with pytest.raises(FileError, match="this run reads it"):
        put(tmp_path, force=True, reads=[tmp_path / "mine"])
    assert texts(tmp_path) == every("mine", "mine", "x.csv")


@POSIX
def test_a_replaced_file_keeps_its_rights_and_a_new_one_has_the_usual(tmp_path: Path) -> None:
    put(tmp_path, "old")
    (tmp_path / "x-speed.png").unlink()
    (tmp_path / "x.csv").chmod(0o640)
    mask = os.umask(0o022)
    try:
        put(tmp_path, force=True)
    finally:
        os.umask(mask)
    assert [oct((tmp_path / name).stat().st_mode & 0o777) for name in NAMES] == ["0o640", "0o644", "0o644"]


def test_the_json_goes_first_and_comes_last_whatever_step_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So that it never stands beside files of two runs."""
    replace = Path.replace
    for steps in range(4):
        put(tmp_path, "old", force=True)
        taken: list[str] = []

        def step(path: Path, target: Path, steps: int = steps, taken: list[str] = taken) -> Path:
            assert not (tmp_path / "x.json").exists()
            if len(taken) == steps:
                raise OSError(errno.EIO, "Input/output error")
            taken.append(target.name)
            return replace(path, target)

        with monkeypatch.context() as patch:
            patch.setattr(Path, "replace", step)
            if steps == len(NAMES):
                put(tmp_path, force=True)
            else:
                with pytest.raises(FileError, match=r"cannot write to .*: Input/output error"):
                    put(tmp_path, force=True)
        assert taken == [*NAMES[:steps]]
        expected = {**every("old"), **every("new", *NAMES[:steps])} if steps else every("old")
        assert texts(tmp_path) == {
            name: text for name, text in expected.items() if name != "x.json" or steps == len(NAMES)
        }


@pytest.mark.parametrize("times", [3, 10])
def test_a_file_that_a_spreadsheet_holds_is_retried_then_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, times: int
) -> None:
    put(tmp_path, "old")
    replace, failures, pauses = Path.replace, iter(range(times)), list[float]()

    def held(path: Path, target: Path) -> Path:
        if next(failures, None) is not None:
            raise PermissionError(errno.EACCES, "Permission denied", str(target))
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", held)
    monkeypatch.setattr(time, "sleep", pauses.append)
    if times == 3:
        put(tmp_path, force=True)
        assert len(pauses) == 3
        assert texts(tmp_path) == every("new")
    else:
        with pytest.raises(FileError, match=r"cannot replace .*x\.csv") as caught:
            put(tmp_path, force=True)
        assert "holds it open" in caught.value.hint
        assert texts(tmp_path) == every("old", "x.csv", "x-speed.png")


def test_what_the_system_refuses_is_told_with_a_way_out(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match="cannot write to") as caught:
        put(tmp_path / "file" / "deep")
    assert f"{tmp_path / 'file'} is a file" in caught.value.hint

    def full() -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with pytest.raises(FileError, match=os.strerror(errno.ENOSPC)) as caught:
        put(tmp_path, during=full)
    assert "free some space" in caught.value.hint
    if sys.platform == "linux":  # where nobody may write, not even root
        with pytest.raises(FileError, match="cannot write to /proc/vibro"):
            put(Path("/proc/vibro"))
    assert texts(tmp_path) == every("", "file")


def test_one_file_is_replaced_when_it_is_whole(tmp_path: Path) -> None:
    for text in ("old", "new"):
        with whole_file(tmp_path / "x") as path:
            path.write_text(text, encoding="utf-8")
    assert texts(tmp_path) == {"x": "new"}


@pytest.mark.parametrize("error", [None, KeyboardInterrupt])
def test_a_hidden_folder_goes_with_what_is_in_it(tmp_path: Path, error: type[BaseException] | None) -> None:
    def use() -> None:
        with hidden_folder(tmp_path) as first, hidden_folder(tmp_path) as second:
            assert first != second
            for folder in (first, second):
                assert folder.name.startswith(".vibro-")
                (folder / "table").touch()
            vibro.interrupts._acts[-1]()
            assert [path.name for path in tmp_path.iterdir()] == [first.name]
            if error:
                raise error

    if error:
        with pytest.raises(error):
            use()
    else:
        use()
    assert list(tmp_path.iterdir()) == []
