"""Files of a run get their names when all of them are whole, the JSON last."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from helpers.cases import each
from helpers.outputs import NAMES, POSIX, Picture, at_each_step, every, put, staging, texts

from vibro import __version__
from vibro.errors import FileError
from vibro.output.staging import Staging


def test_files_appear_together_are_told_and_describe_themselves(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    with staging(folder) as files:
        files.table().write_text("table", encoding="utf-8")
        assert [path for path in folder.iterdir() if path.is_file()] == []
        figures: Any = {"speed": Picture("picture")}
        record = files.finish(["map", "-A", "1"], {"cells": 3}, figures)
    found = texts(folder)
    assert found.keys() == {*NAMES}
    assert (found["x.csv"], found["x-speed.png"]) == ("table", "picture")
    assert json.loads(found["x.json"]) == record
    assert record == {
        "version": __version__, "argv": ["vibro", "map", "-A", "1"], "cells": 3, "files": list(NAMES),
    }  # fmt: skip
    assert files.told == [f"wrote {folder / name}" for name in NAMES]


def test_pictures_that_are_not_drawn_are_no_files_of_the_set(tmp_path: Path) -> None:
    put(tmp_path, text="old")
    with staging(tmp_path, force=True) as files:
        files.table().write_text("new", encoding="utf-8")
        assert files.finish()["files"] == ["x.csv", "x.json"]
    assert {path.name for path in tmp_path.iterdir()} == {"x.csv", "x.json"}
    assert f"removed {tmp_path / 'x-speed.png'}" in files.told


def test_a_single_file_needs_no_json(tmp_path: Path) -> None:
    (tmp_path / "drive-speed.png").touch()
    for force in (False, True):
        with Staging(tmp_path / "drive", force=force, tables={"": "toml"}, described=False) as files:
            files.table().write_text("x = 1", encoding="utf-8")
            files.finish()
        assert files.told == [f"wrote {tmp_path / 'drive.toml'}"]
    assert {path.name for path in tmp_path.iterdir()} == {"drive.toml", "drive-speed.png"}


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, SystemExit])
def test_nothing_remains_of_a_run_that_ends_early_and_what_was_there_stays(
    tmp_path: Path, error: type[BaseException]
) -> None:
    with pytest.raises(error):
        put(tmp_path / "a" / "b", error=error())
    assert list(tmp_path.iterdir()) == []
    put(tmp_path, text="old")
    with pytest.raises(error):
        put(tmp_path, force=True, error=error())
    assert texts(tmp_path) == every("old")
    assert {path.name for path in tmp_path.iterdir()} == {*NAMES}


def test_existing_files_are_replaced_only_by_force(tmp_path: Path) -> None:
    put(tmp_path, text="old")
    with pytest.raises(FileError, match=r"x\.csv, .*x-speed\.png, .*x\.json exist"):
        put(tmp_path)
    assert texts(tmp_path) == every("old")
    put(tmp_path, force=True)
    assert texts(tmp_path) == every("new")


def test_a_set_without_its_json_is_said_to_come_from_an_interrupted_run(tmp_path: Path) -> None:
    put(tmp_path, text="old")
    (tmp_path / "x.json").unlink()
    with pytest.raises(FileError, match=r"no x\.json"):
        put(tmp_path)
    put(tmp_path, force=True)
    assert texts(tmp_path) == every("new")


def test_other_pictures_of_the_stem_go_with_what_they_were_of(tmp_path: Path) -> None:
    put(tmp_path, text="old", pictures=("flight",))
    kept = ["x-notes.png", "x.png", "x-flight.txt", "y-flight.png", "x-speed-flight.png"]
    for name in kept:
        (tmp_path / name).write_text("mine", encoding="utf-8")
    if sys.platform != "win32":
        (tmp_path / "x-impact.png").symlink_to("x-notes.png")
        kept.append("x-impact.png")
    assert f"removed {tmp_path / 'x-flight.png'}" in put(tmp_path, force=True)
    assert texts(tmp_path) == every("new") | every("mine", *kept)


def test_a_picture_that_would_stay_beside_a_new_table_is_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "x-flight.png").touch()
    with pytest.raises(FileError, match=r"x-flight\.png .* no x\.json"):
        put(tmp_path)


def test_what_the_run_reads_is_never_replaced(tmp_path: Path) -> None:
    scene = tmp_path / "x.csv"
    scene.touch()
    with pytest.raises(FileError, match="this run reads it"):
        Staging(tmp_path / "x", force=True, reads=[None, scene]).__enter__()


@POSIX
def test_a_replaced_file_keeps_its_mode_and_a_new_one_has_the_usual(tmp_path: Path) -> None:
    put(tmp_path, text="old")
    (tmp_path / "x-speed.png").unlink()
    (tmp_path / "x.csv").chmod(0o640)
    mask = os.umask(0o022)
    try:
        put(tmp_path, force=True)
    finally:
        os.umask(mask)
    modes = {name: (tmp_path / name).stat().st_mode & 0o777 for name in NAMES}
    assert modes == {"x.csv": 0o640, "x-speed.png": 0o644, "x.json": 0o644}


@POSIX
@each("force", [False, True])
@each("name", NAMES)
def test_what_is_not_a_regular_file_is_never_replaced(tmp_path: Path, name: str, force: bool) -> None:
    target, other = tmp_path / name, tmp_path / "other"
    other.write_text("mine", encoding="utf-8")
    for pointed in (other, tmp_path / "nowhere", None):
        if pointed is None:
            os.mkfifo(target)
        else:
            target.symlink_to(pointed)
        with pytest.raises(FileError, match=f"cannot write .*{name}: it is "):
            put(tmp_path, force=force)
        assert {path.name for path in tmp_path.iterdir()} == {"other", name}
        target.unlink()
    assert other.read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(("number", "way_out"), [(errno.ENOSPC, "space"), (errno.EIO, "place")])
def test_a_disk_that_fails_leaves_nothing(tmp_path: Path, number: int, way_out: str) -> None:
    with pytest.raises(FileError, match=os.strerror(number)) as caught:
        put(tmp_path, error=OSError(number, os.strerror(number)))
    assert way_out in caught.value.hint
    assert list(tmp_path.iterdir()) == []


@POSIX
@pytest.mark.parametrize("force", [False, True], ids=["new", "force"])
def test_whatever_step_fails_no_file_is_half_and_no_json_beside_files_of_two_runs(
    tmp_path: Path, force: bool
) -> None:
    def fail() -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    failures = 0
    for which in range(1, 100):
        folder = tmp_path / str(which)
        if force:
            put(folder, text="old", pictures=("speed", "flight"))
        with pytest.MonkeyPatch.context() as patch:
            taken = at_each_step(patch, which, fail)
            try:
                put(folder, force=force)
            except FileError:
                failures += 1
        left = texts(folder) if folder.exists() else {}
        if "x.json" in left:
            assert left in (every("new"), every("old", *NAMES, "x-flight.png"))
        assert set(left.values()) <= {"old", "new"}
        put(folder, force=True)
        assert texts(folder) == every("new")
        assert {path.name for path in folder.iterdir()} == {*NAMES}
        if len(taken) < which:
            break
    assert failures >= 5


@POSIX
@pytest.mark.parametrize("links", [True, False])
def test_what_another_program_puts_there_meanwhile_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, links: bool
) -> None:
    if not links:
        monkeypatch.setattr("vibro.output.staging._NO_LINKS", {errno.EEXIST})
    figures: Any = {"speed": Picture("new")}
    with staging(tmp_path) as files:
        files.table().write_text("new", encoding="utf-8")
        (tmp_path / "x-speed.png").write_text("theirs", encoding="utf-8")
        with pytest.raises(FileError, match=r"x-speed\.png exists already"):
            files.finish([], {}, figures)
    assert texts(tmp_path) == {"x.csv": "new", "x-speed.png": "theirs"}


@pytest.mark.parametrize("times", [3, 10])
def test_a_file_that_a_spreadsheet_holds_is_retried_then_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, times: int
) -> None:
    put(tmp_path, text="old")
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
        with pytest.raises(FileError, match=r"cannot replace .*x\.csv"):
            put(tmp_path, force=True)
        assert texts(tmp_path) == every("old", "x.csv", "x-speed.png")


@POSIX
def test_a_signal_between_two_names_ends_the_run_without_a_json(tmp_path: Path) -> None:
    code = """
import os, signal, sys
from pathlib import Path
from helpers.outputs import put
from vibro.interrupts import end_on_signals

end_on_signals()
link = os.link
def link_and_signal(path, target, **more):
    link(path, target, **more)
    if Path(target).name == "x.csv":
        os.kill(os.getpid(), signal.SIGTERM)
os.link = link_and_signal
put(Path(sys.argv[1]))
"""
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)],
        cwd=Path(__file__).parents[1], capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (130, "error: interrupted\n")
    assert [path.name for path in tmp_path.iterdir()] == ["x.csv"]
