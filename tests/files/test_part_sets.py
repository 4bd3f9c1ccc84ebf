"""Folders of parts: whole files alone, one run at a time, and nothing of anybody else is touched."""

from __future__ import annotations

import errno
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

import vibro.interrupts
from vibro.errors import FileError
from vibro.files.part_sets import MANIFEST, SUCCESS, PartSet, new_part, part_name

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="links, file modes")
GO_ON = "go on with --resume"


def part_set(folder: Path) -> PartSet:
    return PartSet(folder, GO_ON)


def names(folder: Path) -> list[str]:
    """Return what there is but the claim."""
    return sorted(path.name for path in folder.iterdir() if not path.name.startswith(".vibro-"))


def worker_writes(files: PartSet, number: int, text: str = "whole") -> str:
    path = new_part(files.folder, number, files.run)
    path.write_text(text, encoding="utf-8")
    return path.name


def write_sweep(folder: Path, parts: int = 2) -> None:
    """Write all files of a sweep."""
    with part_set(folder) as files:
        files.write(MANIFEST, "{}")
        for number in range(parts):
            files.publish(worker_writes(files, number), part_name(number))
        with files.new("regime.png") as path:
            path.write_text("picture", encoding="utf-8")
        files.finish("done")


SWEEP = [SUCCESS, MANIFEST, "part-000000.parquet", "part-000001.parquet", "regime.png"]


def test_a_folder_is_made_and_holds_the_files_alone_in_the_end(tmp_path: Path) -> None:
    folder = tmp_path / "far" / "out"
    write_sweep(folder)
    assert sorted(path.name for path in folder.iterdir()) == SWEEP
    assert (folder / SUCCESS).read_text(encoding="utf-8") == "done"
    with part_set(folder) as files:
        assert files.parts() == {"part-000000.parquet", "part-000001.parquet"}
        assert (files.read(SUCCESS), files.read("nothing")) == ("done", None)


def test_files_appear_whole(tmp_path: Path) -> None:
    with part_set(tmp_path) as files:
        with files.new(MANIFEST) as path:
            path.write_text("half", encoding="utf-8")
            assert names(tmp_path) == []
            path.write_text("whole", encoding="utf-8")
        assert files.read(MANIFEST) == "whole"
        temporary = worker_writes(files, 0)
        assert names(tmp_path) == [temporary, MANIFEST]
        assert files.parts() == set()
        files.publish(temporary, part_name(0))
        assert names(tmp_path) == [MANIFEST, "part-000000.parquet"]
        with pytest.raises(UnicodeEncodeError):
            files.write(MANIFEST, "half" * 100_000 + "\ud800")
        assert files.read(MANIFEST) == "whole"
    assert sorted(path.name for path in tmp_path.iterdir()) == [MANIFEST, "part-000000.parquet"]


@POSIX
def test_what_says_that_all_is_there_comes_last_and_all_is_on_the_disk_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps: list[str] = []
    replace, fsync = Path.replace, os.fsync

    def synced(number: int) -> None:
        steps.append("folder" if Path(f"/proc/self/fd/{number}").resolve() == tmp_path else "file")
        fsync(number)

    def put(path: Path, target: Path) -> Path:
        steps.append(target.name)
        return replace(path, target)

    with part_set(tmp_path) as files:
        worker_writes(files, 0)  # and was lost
        monkeypatch.setattr("os.fsync", synced)
        monkeypatch.setattr(Path, "replace", put)
        files.write(MANIFEST, "{}")
        assert steps == ["file", MANIFEST]
        files.finish("done")
        assert names(tmp_path) == [SUCCESS, MANIFEST]
    if Path("/proc/self/fd").exists():
        assert steps == ["file", MANIFEST, "folder", "file", SUCCESS, "folder"]


@pytest.mark.parametrize("number", [errno.EINVAL, errno.ENOTSUP, errno.EROFS])
def test_a_file_system_that_cannot_sync_is_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    def refuse(_: int) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("os.fsync", refuse)
    write_sweep(tmp_path / "out")
    assert names(tmp_path / "out") == SWEEP


def test_one_run_at_a_time(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with part_set(folder) as files:
        files.write(MANIFEST, "{}")
        temporary = worker_writes(files, 0)
        with pytest.raises(FileError, match=r"another run is writing .*out at this moment") as caught:
            part_set(folder).__enter__()
        assert str(files.wanted.parent) in caught.value.hint
        assert names(folder) == [temporary, MANIFEST]
        assert files.wanted.exists()
        with part_set(tmp_path / "other"):
            pass
    write_sweep(folder)


@POSIX
def test_a_link_to_a_folder_is_that_folder(tmp_path: Path) -> None:
    folder, link = tmp_path / "out", tmp_path / "link"
    folder.mkdir()
    link.symlink_to(folder, target_is_directory=True)
    with part_set(folder), pytest.raises(FileError, match="another run is writing"):
        part_set(link).__enter__()
    write_sweep(link)
    assert names(folder) == SWEEP
    assert link.is_symlink()


def begin_and_fail(folder: Path, error: Exception, *, part: bool = False) -> None:
    with part_set(folder) as files:
        files.write(MANIFEST, "{}")
        if part:
            files.publish(worker_writes(files, 0), part_name(0))
        worker_writes(files, 1, "half")
        raise error


def test_what_a_run_leaves_that_fails_is_whole(tmp_path: Path) -> None:
    folder = tmp_path / "far" / "out"
    with pytest.raises(RuntimeError):
        begin_and_fail(folder, RuntimeError(), part=True)
    assert sorted(path.name for path in folder.iterdir()) == [MANIFEST, "part-000000.parquet"]


def test_folders_that_are_made_for_nothing_are_removed(tmp_path: Path) -> None:
    with pytest.raises(RuntimeError), part_set(tmp_path / "far" / "out"):
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "mine").mkdir()
    with pytest.raises(RuntimeError), part_set(tmp_path / "mine"):
        raise RuntimeError
    assert names(tmp_path) == ["mine"]
    assert names(tmp_path / "mine") == []


def test_a_signal_keeps_what_is_whole_and_says_how_to_go_on(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with part_set(folder) as files:
        files.publish(worker_writes(files, 0), part_name(0))
        files.write(MANIFEST, "{}")
        worker_writes(files, 1, "half")
        assert vibro.interrupts._unfinished[-1]() == GO_ON
        assert sorted(path.name for path in folder.iterdir()) == [MANIFEST, "part-000000.parquet"]
    before = len(vibro.interrupts._unfinished)
    with part_set(tmp_path / "new"):
        assert vibro.interrupts._unfinished[-1]() == ""  # nothing to go on with
        assert not (tmp_path / "new").exists()
    assert len(vibro.interrupts._unfinished) == before


def test_temporaries_older_than_the_lock_are_removed_and_in_the_end_all(tmp_path: Path) -> None:
    ours = [new_part(tmp_path, number, "0123456789abcdef") for number in range(3)]
    notes = [tmp_path / ".part-000000-notes", tmp_path / ".part-000000-0123456789abcdef-0", tmp_path / ".x"]
    for path in (*ours, *notes):
        path.touch()
        os.utime(path, (1e9, 1e9))
    os.utime(ours[2], (4e9, 4e9))  # which a worker of that run still writes
    with part_set(tmp_path) as files:
        assert not ours[0].exists()
        assert not ours[1].exists()
        assert ours[2].exists()
        files.write(MANIFEST, "{}")
        files.finish("done")
    assert not ours[2].exists()  # all parts are there: nobody wants it any more
    assert all(path.exists() for path in notes)


def test_nobody_wants_parts_of_a_run_that_stops_or_ends(tmp_path: Path) -> None:
    with part_set(tmp_path) as files:
        assert files.wanted.exists()
        files.stop()
        assert not files.wanted.exists()
        files.stop()
    with part_set(tmp_path) as files:
        assert files.wanted.exists()
    assert not files.wanted.exists()


def free(folder: Path) -> None:
    with part_set(folder) as files:
        files.check_free()


@pytest.mark.parametrize(
    ("there", "others"),
    [
        (["notes.txt"], "notes.txt"),
        (["part-000000.parquet"], "part-000000.parquet"),
        ([SUCCESS], SUCCESS),
        ([MANIFEST, "more.parquet"], "more.parquet"),
        ([MANIFEST, "part-0.parquet", "part-0000000.parquet"], "part-0.parquet, part-0000000.parquet"),
        (["a", "b", "c", "d"], "a, b, c, ..."),
    ],
)
def test_a_folder_that_holds_something_else_is_refused(tmp_path: Path, there: list[str], others: str) -> None:
    for name in there:
        (tmp_path / name).touch()
    with pytest.raises(FileError, match=f"holds something else: {re.escape(others)}\n") as caught:
        free(tmp_path)
    assert caught.value.hint == "choose another name with -o"
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(there)


@pytest.mark.parametrize(
    "there", [[], [".hidden"], [MANIFEST], [MANIFEST, "notes.txt", "speed.svg"], SWEEP, [*SWEEP, ".hidden"]]
)
def test_a_folder_of_parts_is_free(tmp_path: Path, there: list[str]) -> None:
    for name in there:
        (tmp_path / name).touch()
    free(tmp_path)


def test_clearing_removes_the_files_of_a_sweep_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_sweep(tmp_path, 3)
    others = [
        "notes.txt", "part-1.parquet", "part-000000.parquet.bak", "xpart-000000.parquet", "manifest.json.old",
        "_SUCCESS2", "hill.png", "regime.png.txt", ".hidden", "part-000009.parquet~",
    ]  # fmt: skip
    for name in others:
        (tmp_path / name).touch()
    removed: list[str] = []
    unlink = Path.unlink

    def noted(path: Path, missing_ok: bool = False) -> None:
        removed.append(path.name)
        unlink(path, missing_ok)

    with part_set(tmp_path) as files:
        monkeypatch.setattr(Path, "unlink", noted)
        files.clear()
        monkeypatch.undo()
        # At no time does anything say that a set is whole which is not, or is it of no sweep.
        assert removed[0] == SUCCESS
        assert removed[-1] == MANIFEST
        assert len(removed) == 6
        assert names(tmp_path) == sorted(others)


def fail(number: int) -> OSError:
    return OSError(number, os.strerror(number))


@pytest.mark.parametrize(
    ("number", "hint"),
    [
        (errno.ENOSPC, f"free some space; {GO_ON}"),
        (errno.EIO, "choose another name with -o"),
        (errno.EACCES, "choose another name with -o"),
    ],
)
def test_what_the_system_refuses_is_told_with_a_way_out(tmp_path: Path, number: int, hint: str) -> None:
    folder = tmp_path / "out"
    said = f"cannot write to {folder}: {os.strerror(number)}"
    with pytest.raises(FileError, match=re.escape(said)) as caught:
        begin_and_fail(folder, fail(number))
    assert caught.value.hint == hint
    assert names(folder) == [MANIFEST]
    with pytest.raises(RuntimeError), part_set(folder):
        raise RuntimeError  # which is no matter of files


def test_a_disk_that_is_full_from_the_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise fail(errno.ENOSPC)

    with monkeypatch.context() as patch:
        patch.setattr("os.open", full)
        with pytest.raises(FileError, match="No space left") as caught:
            part_set(tmp_path / "far" / "out").__enter__()
    assert "free some space" in caught.value.hint
    assert list(tmp_path.iterdir()) == []
    assert vibro.interrupts._unfinished == []


@pytest.mark.parametrize("name", ["file", "file/out", "file/far/out"])
def test_a_file_in_the_way_is_named(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match="cannot write to") as caught:
        part_set(tmp_path / name).__enter__()
    assert caught.value.hint == f"{tmp_path / 'file'} is a file; choose another name with -o"
    assert names(tmp_path) == ["file"]


@POSIX
@pytest.mark.parametrize("kind", ["long name", "loop", "dangling"])
def test_names_that_no_folder_can_have(tmp_path: Path, kind: str) -> None:
    folder = tmp_path / ("x" * 300 if kind == "long name" else "link")
    if kind != "long name":
        folder.symlink_to(folder if kind == "loop" else tmp_path / "nowhere")
    before = list(tmp_path.iterdir())
    with pytest.raises(FileError, match="cannot write to") as caught:
        part_set(folder).__enter__()
    assert caught.value.hint == "choose another name with -o"
    assert list(tmp_path.iterdir()) == before


def test_a_folder_in_the_place_of_a_file_is_told_beforehand(tmp_path: Path) -> None:
    write_sweep(tmp_path / "out")
    (tmp_path / "out" / "flight.png").mkdir()
    with pytest.raises(FileError, match=r"holds something else: flight\.png"):
        free(tmp_path / "out")
    (tmp_path / "out" / "flight.png").rename(tmp_path / "out" / "notes")
    free(tmp_path / "out")


@contextmanager
def as_nobody() -> Iterator[None]:
    """Be nobody where root, who may write anywhere, runs the tests."""
    user = os.geteuid()
    if user == 0:
        os.seteuid(65_534)
    try:
        yield
    finally:
        os.seteuid(user)


@POSIX
def test_a_folder_that_must_not_be_written() -> None:
    with TemporaryDirectory() as place:  # not tmp_path, which its owner alone may enter
        Path(place).chmod(0o555)
        with as_nobody():
            for folder in (Path(place), Path(place, "out")):
                with pytest.raises(FileError, match="Permission denied"):
                    part_set(folder).__enter__()
        Path(place).chmod(0o755)


@pytest.mark.parametrize("made", [lambda path: path.mkdir(), lambda path: path.write_bytes(b"\xff\xfe")])
def test_a_manifest_that_cannot_be_read(tmp_path: Path, made: object) -> None:
    assert callable(made)
    made(tmp_path / MANIFEST)
    with part_set(tmp_path) as files, pytest.raises(FileError, match=r"cannot read .*manifest\.json"):
        files.read(MANIFEST)
