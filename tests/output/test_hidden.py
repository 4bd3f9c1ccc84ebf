"""A hidden folder belongs to one run at a time, and nobody removes what another may be writing."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

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


@pytest.mark.parametrize("age", [0.0, 31 * 86400.0], ids=["now", "a month ago"])
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
