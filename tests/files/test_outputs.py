"""Output files appear whole or not at all."""

from __future__ import annotations

import errno
import json
import os
import signal
import sys
from pathlib import Path
from types import FrameType

import pytest
from helpers.outputs import NAMES, POSIX, every, output_set, put, texts

from vibro.errors import FileError


def test_files_appear_together_are_told_and_make_their_folder(tmp_path: Path) -> None:
    folder, told = tmp_path / "a" / "b", list[str]()
    with output_set(folder, told=told) as output:
        for name in NAMES:
            output[folder / name].write_text(name, encoding="utf-8")
            assert not (folder / name).exists()
        assert told == []
    assert texts(folder) == {name: name for name in NAMES}
    assert told == [f"wrote {folder / name}" for name in NAMES]


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, SystemExit])
def test_nothing_remains_of_a_run_that_ends_early(tmp_path: Path, error: type[BaseException]) -> None:
    with pytest.raises(error):
        put(tmp_path / "a" / "b", error=error())
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_ends_early_keeps_what_was_there(tmp_path: Path) -> None:
    put(tmp_path, text="old")
    with pytest.raises(KeyboardInterrupt):
        put(tmp_path, force=True, error=KeyboardInterrupt())
    assert texts(tmp_path) == every("old")


class SignalledError(Exception):
    """What this test's handler makes of a signal."""


@POSIX
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_a_signal_while_files_are_put_in_place_comes_too_late(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: signal.Signals
) -> None:
    def stop(_: int, __: FrameType | None) -> None:
        raise SignalledError

    link, linked = os.link, list[str]()

    def link_and_signal(path: Path, target: Path) -> None:
        link(path, target)
        linked.append(target.name)
        signal.raise_signal(number)

    monkeypatch.setattr("os.link", link_and_signal)
    before = signal.signal(number, stop)
    try:
        put(tmp_path)
        assert signal.getsignal(number) is stop
    finally:
        signal.signal(number, before)
    assert linked == list(NAMES)
    assert texts(tmp_path) == every("new")


def test_existing_files_are_replaced_only_by_force(tmp_path: Path) -> None:
    put(tmp_path, text="old")
    with pytest.raises(FileError, match=r"x\.csv, .*x-speed\.png, .*x\.json exist already(\n|$)") as caught:
        put(tmp_path)
    assert "--force" in caught.value.hint
    assert texts(tmp_path) == every("old")
    put(tmp_path, force=True)
    assert texts(tmp_path) == every("new")


def test_a_set_without_its_last_file_is_said_to_be_incomplete(tmp_path: Path) -> None:
    put(tmp_path, text="old")
    (tmp_path / "x.json").unlink()
    with pytest.raises(FileError, match=r"exist already, but no x\.json: a run did not end there"):
        put(tmp_path)
    assert put(tmp_path, force=True)[0] == f"replacing an incomplete set: there is no {tmp_path / 'x.json'}"
    assert texts(tmp_path) == every("new")


def test_other_pictures_of_the_stem_go_with_what_they_were_of(tmp_path: Path) -> None:
    put(tmp_path, "x.csv", "x-flight.svg", "x.json", text="old")
    kept = ["x-notes.png", "x.png", "x-flight.txt", "y-flight.svg", "x-speed-flight.svg"]
    for name in kept:
        (tmp_path / name).write_text("mine", encoding="utf-8")
    if sys.platform != "win32":
        (tmp_path / "x-impact.png").symlink_to("x-notes.png")
        kept.append("x-impact.png")
    (tmp_path / "x.json").write_text(json.dumps({"files": ["x-notes.png"]}), encoding="utf-8")
    assert f"removed {tmp_path / 'x-flight.svg'}" in put(tmp_path, force=True)
    assert texts(tmp_path) == every("new") | every("mine", *kept)


def test_a_picture_that_would_stay_beside_a_new_table_is_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "x-flight.png").touch()
    with pytest.raises(FileError, match=r"x-flight\.png exists already, but no x\.json"):
        put(tmp_path)


@POSIX
def test_a_replaced_file_keeps_its_mode_and_a_new_one_has_the_usual(tmp_path: Path) -> None:
    put(tmp_path, "x.csv", "x.json", text="old")
    (tmp_path / "x.csv").chmod(0o640)
    (tmp_path / "x.json").chmod(0o600)
    mask = os.umask(0o022)
    try:
        put(tmp_path, force=True)
    finally:
        os.umask(mask)
    modes = {name: (tmp_path / name).stat().st_mode & 0o777 for name in NAMES}
    assert modes == {"x.csv": 0o640, "x-speed.png": 0o644, "x.json": 0o600}


@POSIX
@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_what_is_not_a_regular_file_is_never_replaced(tmp_path: Path, name: str, force: bool) -> None:
    target, other = tmp_path / name, tmp_path / "other"
    other.write_text("mine", encoding="utf-8")
    for pointed in (other, tmp_path / "nowhere", None):
        if pointed is None:
            os.mkfifo(target)
        else:
            target.symlink_to(pointed)
        with pytest.raises(FileError, match=f"cannot write .*{name}: it is ") as caught:
            put(tmp_path, force=force)
        assert "-o -" in caught.value.hint
        assert {path.name for path in tmp_path.iterdir()} == {"other", name}
        target.unlink()
    assert other.read_text(encoding="utf-8") == "mine"


def test_a_folder_in_the_way_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "x.csv").mkdir()
    with pytest.raises(FileError, match="a folder is in the way"):
        put(tmp_path, force=True)


def test_a_file_in_the_way_of_a_folder(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("", encoding="utf-8")
    for folder in (tmp_path / "out", tmp_path / "out" / "deeper"):
        with pytest.raises(FileError, match=r"cannot write to .*out") as caught:
            put(folder)
        assert caught.value.hint == f"{tmp_path / 'out'} is a file"


def test_a_name_that_is_too_long_is_named_before_anything_is_computed(tmp_path: Path) -> None:
    with (
        pytest.raises(FileError, match=r"cannot write .*y{255}\.json: "),
        output_set(tmp_path, "x.csv", f"{255 * 'y'}.json"),
    ):
        raise AssertionError
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_to(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: str, *_: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", path)

    monkeypatch.setattr("os.open", refuse)
    with pytest.raises(FileError, match=r"cannot write to .*Permission denied") as caught:
        put(tmp_path / "new")
    assert caught.value.hint == "choose another place with -o"
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_another_run_removes_meanwhile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, mkdir, removals = tmp_path / "new", Path.mkdir, iter(range(2))

    def mkdir_late(path: Path) -> None:
        if path.name.startswith(".vibro") and next(removals, None) is not None:
            folder.rmdir()
        mkdir(path)

    monkeypatch.setattr(Path, "mkdir", mkdir_late)
    put(folder)
    assert texts(folder) == every("new")


@pytest.mark.parametrize(
    ("number", "hint"),
    [
        (errno.ENOSPC, "free some space, or choose another place with -o"),
        (errno.EIO, "choose another place with -o"),
    ],
)
def test_a_disk_that_fails_leaves_nothing(tmp_path: Path, number: int, hint: str) -> None:
    with pytest.raises(FileError, match="cannot write to") as caught:
        put(tmp_path, error=OSError(number, os.strerror(number)))
    assert os.strerror(number) in str(caught.value)
    assert caught.value.hint == hint
    assert list(tmp_path.iterdir()) == []
