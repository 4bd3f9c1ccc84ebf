"""Folders of shards: whole files alone, one run at a time, and nothing of anybody else is touched."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.cases import each
from helpers.commands import POSIX

import vibro.interrupts
from vibro.errors import FileError
from vibro.output.shard_folder import MANIFEST, SUCCESS, ShardFolder, Stamp, shard_name

GO_ON = "go on with resume=True"
SWEEP = [SUCCESS, MANIFEST, "_regime.png", "part-000000.parquet", "part-000001.parquet"]


def held(folder: Path, shards: str = "") -> ShardFolder:
    return ShardFolder(folder, GO_ON, shards)


def names(folder: Path) -> list[str]:
    """Return what there is but what is hidden."""
    return sorted(path.name for path in folder.iterdir() if not path.name.startswith(".vibro-"))


def worker_writes(files: ShardFolder, text: str = "whole") -> str:
    path = files.hidden / os.urandom(4).hex()
    path.write_text(text, encoding="utf-8")
    return path.name


def write_sweep(folder: Path, shards: int = 2) -> None:
    """Write all files of a sweep."""
    with held(folder) as files:
        files.write(MANIFEST, "{}")
        stamps = {shard_name(i): files.publish(worker_writes(files), shard_name(i)) for i in range(shards)}
        with files.new("_regime.png") as path:
            path.write_text("picture", encoding="utf-8")
        files.finish("done", "{}", stamps, dict.fromkeys(stamps, ""))


def test_a_folder_is_made_and_holds_the_files_alone_in_the_end(tmp_path: Path) -> None:
    folder = tmp_path / "far" / "out"
    write_sweep(folder)
    assert sorted(path.name for path in folder.iterdir()) == SWEEP
    with held(folder) as files:
        assert files.shards() == {"part-000000.parquet", "part-000001.parquet"}
        assert (files.read(SUCCESS), files.read("nothing")) == ("done", None)


def test_files_appear_whole(tmp_path: Path) -> None:
    with held(tmp_path) as files:
        with files.new(MANIFEST) as path:
            path.write_text("half", encoding="utf-8")
            assert names(tmp_path) == []
            path.write_text("whole", encoding="utf-8")
        assert files.read(MANIFEST) == "whole"
        temporary = worker_writes(files)
        assert files.shards() == set()
        stamp = files.publish(temporary, shard_name(0))
        assert stamp == Stamp.of(tmp_path / shard_name(0))
        assert names(tmp_path) == [MANIFEST, shard_name(0)]
        with pytest.raises(UnicodeEncodeError):
            files.write(MANIFEST, "half" * 100_000 + "\ud800")
        with pytest.raises(FileError, match="exists already"):
            files.write(MANIFEST, "another", replace=False)
        assert files.read(MANIFEST) == "whole"
    assert sorted(path.name for path in tmp_path.iterdir()) == [MANIFEST, shard_name(0)]


def test_a_manifest_that_changes_meanwhile_is_an_error(tmp_path: Path) -> None:
    with held(tmp_path) as files:
        files.write(MANIFEST, "{ }")
        with pytest.raises(FileError, match=MANIFEST):
            files.finish("done", "{}", {}, {})
    assert names(tmp_path) == [MANIFEST]


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

    with held(tmp_path) as files:
        worker_writes(files)  # and was lost
        monkeypatch.setattr("os.fsync", synced)
        monkeypatch.setattr(Path, "replace", put)
        files.write(MANIFEST, "{}")
        assert steps == ["file", MANIFEST]
        files.finish("done", "{}", {}, {})
        taken = [*steps]
    if Path("/proc/self/fd").exists():
        assert taken == ["file", MANIFEST, "folder", "file", SUCCESS, "folder"]


@pytest.mark.parametrize(
    ("first", "second", "works"),
    [
        ("", "0:4", False), ("0:4", "2:9", True),
    ],
)  # fmt: skip
def test_ranges_work_side_by_side_and_all_shards_alone(
    tmp_path: Path, first: str, second: str, works: bool
) -> None:
    with held(tmp_path / "out", first) as one:
        written = one.hidden / "half"
        written.touch()
        if works:
            with held(tmp_path / "out", second) as other:
                assert one.hidden != other.hidden
        else:
            with pytest.raises(FileError, match="another run") as caught:
                held(tmp_path / "out", second).__enter__()
            assert str(one.hidden.parent) in caught.value.hint
        assert written.exists()
        with held(tmp_path / "other", second):
            pass
    assert list(tmp_path.iterdir()) == []


def begin_and_fail(folder: Path, error: BaseException) -> None:
    with held(folder) as files:
        files.write(MANIFEST, "{}")
        files.publish(worker_writes(files), shard_name(0))
        worker_writes(files, "half")
        raise error


@pytest.mark.parametrize("error", [RuntimeError(), KeyboardInterrupt(), SystemExit()])
def test_what_a_run_leaves_that_fails_is_whole(tmp_path: Path, error: BaseException) -> None:
    folder = tmp_path / "far" / "out"
    with pytest.raises(type(error)) as caught:
        begin_and_fail(folder, error)
    assert sorted(path.name for path in folder.iterdir()) == [MANIFEST, shard_name(0)]
    interrupted = isinstance(error, KeyboardInterrupt)
    assert getattr(caught.value, "__notes__", []) == ([GO_ON] if interrupted else [])


def test_a_signal_keeps_what_is_whole_and_says_how_to_go_on(tmp_path: Path) -> None:
    folder, before = tmp_path / "out", len(vibro.interrupts._acts)
    with held(folder) as files:
        files.publish(worker_writes(files), shard_name(0))
        files.write(MANIFEST, "{}")
        worker_writes(files, "half")
        assert [act() for act in reversed(vibro.interrupts._acts[before:])] == [GO_ON, None]
        assert sorted(path.name for path in folder.iterdir()) == [MANIFEST, shard_name(0)]
    with held(tmp_path / "new"):
        assert vibro.interrupts._acts[-1]() == ""  # nothing to go on with
    assert len(vibro.interrupts._acts) == before


@each(
    ("there", "others"),
    [
        (["notes.txt"], "notes.txt"),
        (["part-000000.parquet"], "part-000000.parquet"),
        ([SUCCESS], SUCCESS),
        ([MANIFEST, "more.parquet"], "more.parquet"),
        ([MANIFEST, "part-000002.parquet"], "part-000002.parquet"),
        ([MANIFEST, "_speed.svg"], "_speed.svg"),  # would be written over
        ([MANIFEST, "part-000001.parquet/"], "part-000001.parquet"),
        ([MANIFEST, "part-0.parquet", "part-0000000.parquet"], "part-0.parquet, part-0000000.parquet"),
        ([MANIFEST, "_regime.png/"], "_regime.png"),
        (["a", "b", "c", "d"], "a, b, c, ..."),
        ([], ""),
        ([".hidden"], ""),
        (["manifest.json"], "manifest.json"),
        ([MANIFEST, "notes.txt", "speed.svg", "notes/"], ""),
        ([*SWEEP, ".hidden"], ""),
    ],
)
def test_a_folder_that_holds_something_else_is_refused(tmp_path: Path, there: list[str], others: str) -> None:
    folder = tmp_path / str(len(names(tmp_path)))
    folder.mkdir()
    for name in there:
        (folder / name).mkdir() if name.endswith("/") else (folder / name).touch()
    ours = SWEEP if MANIFEST in there else []
    with held(folder) as files:
        if others:
            with pytest.raises(FileError, match=f"something else: {re.escape(others)}\n") as caught:
                files.check_free(ours, ["_speed.svg"])
            assert caught.value.hint == "choose another name"
        else:
            files.check_free(ours, ["_speed.svg"])
    assert names(folder) == sorted(name.rstrip("/") for name in there)


def test_clearing_removes_the_files_of_a_sweep_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_sweep(tmp_path, 3)
    ours = [*names(tmp_path), "_speed.svg", "_flight.png", "part-000003.parquet"]
    others = ["regime.png", "speed.svg", "manifest.json", "notes.txt", "_regime.svg", "part-000009.parquet"]
    for name in others:
        (tmp_path / name).touch()
    (tmp_path / "_speed.svg").mkdir()
    (tmp_path / "_flight.png").symlink_to(tmp_path / "notes.txt")
    (tmp_path / "part-000003.parquet").symlink_to(tmp_path / "part-000009.parquet")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "part-000000.parquet").touch()
    others += ["_speed.svg", "_flight.png", "part-000003.parquet", "folder"]
    removed: list[str] = []
    unlink = Path.unlink

    def noted(path: Path, missing_ok: bool = False) -> None:
        removed.append(path.name)
        unlink(path, missing_ok)

    with held(tmp_path) as files:
        monkeypatch.setattr(Path, "unlink", noted)
        files.clear(ours)
        monkeypatch.undo()
        # At no time does anything say that a set is whole which is not, or is it of no sweep.
        assert removed[0] == SUCCESS
        assert removed[-1] == MANIFEST
        assert len(removed) == 6
        assert names(tmp_path) == sorted(others)
        assert (tmp_path / "folder" / "part-000000.parquet").exists()


@pytest.mark.parametrize(
    ("number", "hint"),
    [(errno.ENOSPC, f"free some space; {GO_ON}"), (errno.EIO, "choose another place")],
)
def test_what_the_system_refuses_is_told_with_a_way_out(tmp_path: Path, number: int, hint: str) -> None:
    folder, said = tmp_path / "out", os.strerror(number)
    with pytest.raises(FileError, match=re.escape(f"cannot write to {folder}: {said}")) as caught:
        begin_and_fail(folder, OSError(number, said))
    assert caught.value.hint == hint
    assert names(folder) == [MANIFEST, shard_name(0)]


@pytest.mark.parametrize("made", [Path.mkdir, lambda path: path.write_bytes(b"\xff\xfe")])
def test_a_manifest_that_cannot_be_read(tmp_path: Path, made: Callable[[Path], object]) -> None:
    made(tmp_path / MANIFEST)
    with held(tmp_path) as files, pytest.raises(FileError, match=r"cannot read .*_manifest\.json"):
        files.read(MANIFEST)
