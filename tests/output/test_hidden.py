"""A hidden folder belongs to one run at a time, and nobody removes what another may be writing."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from helpers.outputs import POSIX

from vibro.errors import FileError
from vibro.output.hidden import Hidden, hidden_folder

HOLD = """
import sys, time
from pathlib import Path
from vibro.output.hidden import Hidden

with Hidden(Path(sys.argv[1]), "nut.*") as hidden:
    (hidden.path / "table").touch()
    print("held", flush=True)
    time.sleep(60)
"""


def held_elsewhere(folder: Path) -> subprocess.Popen[str]:
    """Let another process hold a folder."""
    holder = subprocess.Popen([sys.executable, "-c", HOLD, str(folder)], stdout=subprocess.PIPE, text=True)
    assert holder.stdout is not None
    assert holder.stdout.readline() == "held\n"
    return holder


def end(holder: subprocess.Popen[str]) -> None:
    holder.kill()
    holder.communicate()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return hidden_folder(tmp_path / "nut")


def test_one_run_at_a_time_holds_it_and_leaves_nothing(folder: Path, tmp_path: Path) -> None:
    with Hidden(folder, "nut.*") as first:
        (first.path / "table").touch()
        with pytest.raises(FileError, match=r"nut\.\*") as caught:
            Hidden(folder, "nut.*").__enter__()
        assert str(folder) in caught.value.hint
        assert (first.path / "table").exists()
        with Hidden(hidden_folder(tmp_path / "bolt"), "bolt.*"):
            pass
    assert list(tmp_path.iterdir()) == []
    with Hidden(folder, "nut.*"):
        pass


def test_names_are_short_and_differ() -> None:
    names = {hidden_folder(Path(stem)).name for stem in ("a", "b", "a" * 250, "\udcff", "a\n")}
    assert len(names) == 5
    assert {len(name) for name in names} == {len(".vibro-") + 16}


def test_folders_that_are_missing_are_made_and_go_if_they_stay_empty(tmp_path: Path) -> None:
    deep = tmp_path / "a" / "b"
    with Hidden(hidden_folder(deep / "nut"), "nut.*"):
        assert deep.is_dir()
    assert list(tmp_path.iterdir()) == []
    with Hidden(hidden_folder(deep / "nut"), "nut.*"):
        (tmp_path / "a" / "mine").touch()
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["mine"]


@POSIX
def test_what_a_killed_run_left_goes_with_the_next_at_its_stem_alone(folder: Path, tmp_path: Path) -> None:
    end(held_elsewhere(folder))
    left = sorted(folder.rglob("*"))
    assert len(left) == 3  # the lock, a folder and a file
    with Hidden(hidden_folder(tmp_path / "bolt"), "bolt.*"):
        assert sorted(folder.rglob("*")) == left
    with Hidden(folder, "nut.*") as hidden:
        assert [path for path in folder.iterdir() if path.is_dir()] == [hidden.path]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("age", [0.0, 31 * 86400.0, -31 * 86400.0], ids=["now", "a month ago", "in a month"])
def test_beside_a_lock_of_another_system_nothing_is_removed_whatever_its_age(
    folder: Path, age: float
) -> None:
    theirs = folder / "0123"
    theirs.mkdir(parents=True)
    (folder / "lock-another-system").touch()
    for path in (folder / "lock-another-system", theirs, folder):
        os.utime(path, (time.time() - age, time.time() - age))
    with pytest.raises(FileError, match="another machine is writing") as caught:
        Hidden(folder, "nut.*").__enter__()
    assert caught.value.hint.endswith(f"remove the folder {folder}")
    assert sorted(path.name for path in folder.iterdir()) == ["0123", "lock-another-system"]


def test_a_folder_that_was_half_made_is_nobodys(folder: Path, tmp_path: Path) -> None:
    folder.mkdir()
    with Hidden(folder, "nut.*"):
        pass
    assert list(tmp_path.iterdir()) == []


@POSIX
def test_a_lock_that_somebody_removes_between_its_opening_and_its_getting_guards_nothing(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A dead run's lock is opened; before it is got, another run gets it, ends, and a third begins."""
    import fcntl

    end(held_elsewhere(folder))
    flock, third = fcntl.flock, Hidden(folder, "nut.*")

    def late(lock: int, how: int) -> None:
        monkeypatch.setattr("fcntl.flock", flock)
        with Hidden(folder, "nut.*"):
            pass
        third.__enter__()
        flock(lock, how)

    monkeypatch.setattr("fcntl.flock", late)
    with pytest.raises(FileError, match="another run"):
        Hidden(folder, "nut.*").__enter__()
    assert third.path.is_dir()
    third.__exit__()


@POSIX
def test_without_locks_the_folder_itself_says_that_it_is_taken(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr("fcntl.flock", refuse)
    with Hidden(folder, "nut.*") as first:
        with pytest.raises(FileError, match="another run"):
            Hidden(folder, "nut.*").__enter__()
        assert first.path.is_dir()
    assert list(tmp_path.iterdir()) == []
    (folder / "left").mkdir(parents=True)  # by a killed run, or by one on another machine
    with pytest.raises(FileError, match="another run"):
        Hidden(folder, "nut.*").__enter__()
    assert (folder / "left").is_dir()


def test_a_folder_that_another_run_removes_meanwhile_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place, mkdir, removals = tmp_path / "new", Path.mkdir, iter(range(2))

    def mkdir_late(path: Path, **more: Any) -> None:
        if path.name.startswith(".vibro") and next(removals, None) is not None:
            place.rmdir()
        mkdir(path, **more)

    monkeypatch.setattr(Path, "mkdir", mkdir_late)
    with Hidden(hidden_folder(place / "nut"), "nut.*") as hidden:
        assert hidden.path.is_dir()
