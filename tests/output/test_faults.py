"""Sweeps in shards come out the same whatever happens to workers, runs, disks and files."""

from __future__ import annotations

import json
import multiprocessing
import os
import shutil
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from helpers.commands import POSIX
from helpers.sharded import (
    INTERRUPTED,
    SHARDS,
    Once,
    ended_by,
    made,
    paused,
    resumed,
    small_plan,
    undisturbed,
)

from vibro.errors import FileError
from vibro.output.shard_folder import MANIFEST, SUCCESS, ShardFolder, shard_name
from vibro.output.workers import Processes, Threads

if TYPE_CHECKING:
    from collections.abc import Callable


HOSTILE = (
    *sys.stdlib_module_names,
    *("numpy", "pandas", "scipy", "pyarrow", "matplotlib", "typer", "rich", "click", "vibro"),
    *("sitecustomize", "usercustomize"),
)


class Counted(Processes):
    """Processes which tell how often they were begun."""

    begun = 0

    def __enter__(self) -> Counted:
        self.begun += 1
        super().__enter__()
        return self


def kill_a_child() -> None:
    multiprocessing.active_children()[0].kill()


def states(folder: Path) -> dict[str, tuple[int, int, bytes]]:
    """Say which files are in a folder."""
    return {
        path.name: (path.stat().st_ino, path.stat().st_mtime_ns, path.read_bytes())
        for path in folder.iterdir()
        if path.is_file()
    }


@POSIX
def test_a_killed_process_is_replaced(tmp_path: Path) -> None:
    workers = Counted(1)
    kill = Once(kill_a_child)
    assert made(tmp_path / "wide", workers, report=kill) == undisturbed()
    assert kill.done
    assert workers.begun == 2


@POSIX
def test_interrupts_end_a_command_whose_processes_run_no_file_of_the_folder(
    tmp_path: Path,
) -> None:
    here, ran = tmp_path / "here", tmp_path / "ran"
    for folder in (here, ran):
        folder.mkdir()
    for name in HOSTILE:
        (here / f"{name}.py").write_text(f"open({str(ran / name)!r}, 'w').close()\n", encoding="utf-8")
    run = paused(here, "--workers", "2")
    assert ended_by(signal.SIGINT, run) == (130, INTERRUPTED)
    assert list(ran.iterdir()) == []
    there = {path.name for path in (here / "wide").iterdir()}
    assert {MANIFEST} < there < {MANIFEST, *SHARDS}
    assert resumed(here / "wide") == undisturbed()


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a sweep, for tests that copy it."""
    folder = tmp_path_factory.mktemp("whole") / "wide"
    assert made(folder) == undisturbed()
    return folder


@pytest.fixture
def folder(tmp_path: Path, whole: Path) -> Path:
    return Path(shutil.copytree(whole, tmp_path / "wide"))


def test_a_finished_sweep_that_is_resumed_stays_as_it_is(folder: Path) -> None:
    before = states(folder)
    assert resumed(folder) == undisturbed() == json.loads((folder / SUCCESS).read_bytes())["digest"]
    after = states(folder)
    assert {name: after[name][-1] for name in after} == {name: before[name][-1] for name in before}
    assert {name for name in after if after[name] != before[name]} <= {SUCCESS}


def swapped(path: Path, place: int) -> None:
    """Change a bit of a file in place; its size and the time that it tells stay."""
    status, content = path.stat(), bytearray(path.read_bytes())
    content[place] ^= 1
    path.write_bytes(content)
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


def test_damaged_shards_are_made_again(tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = tmp_path / "other"
    made(other, plan=small_plan(frequency_hz="10:31:300"))
    paths = [folder / shard_name(shard) for shard in range(15)]
    content = paths[0].read_bytes()
    paths[0].write_bytes(content[:-1])
    paths[1].write_bytes(paths[1].read_bytes()[: len(content) // 2])
    paths[2].write_bytes(b"")
    paths[3].unlink()
    paths[4].write_bytes((other / shard_name(4)).read_bytes())  # of another sweep
    paths[5].write_bytes(paths[6].read_bytes())  # of another place
    swapped(paths[7], len(content) // 3)
    swapped(paths[8], paths[8].read_bytes().rindex(b"regime") + 2)  # its footer
    before = states(folder)
    publish = ShardFolder.publish

    def publish_not_finished(files: ShardFolder, temporary: str, name: str) -> Any:
        assert not (folder / SUCCESS).exists()
        return publish(files, temporary, name)

    monkeypatch.setattr(ShardFolder, "publish", publish_not_finished)
    assert resumed(folder) == undisturbed()
    after = states(folder)
    same = {name for name in after if before.get(name) == after[name]}
    assert same - {SUCCESS} == {MANIFEST, *(shard_name(shard) for shard in (6, *range(9, 15)))}


CHANGES: dict[str, Callable[[Path], object]] = {
    "a shard is deleted": lambda folder: (folder / shard_name(0)).unlink(),
    "one is altered in place": lambda folder: swapped(folder / shard_name(1), 1000),
    "the manifest is edited": lambda folder: (folder / MANIFEST).write_text("{}", encoding="utf-8"),
}
ONE = Threads(1)  # which makes or checks shards in their order


@pytest.mark.parametrize(
    ("change", "resume"), [*((change, False) for change in CHANGES), ("a shard is deleted", True)]
)
def test_what_changes_while_a_run_goes_on_is_noticed_before_it_says_that_all_is_there(
    tmp_path: Path, whole: Path, resume: bool, change: str
) -> None:
    folder, manifest = tmp_path / "wide", (whole / MANIFEST).read_bytes()
    if resume:
        shutil.copytree(whole, folder)
        (folder / SUCCESS).unlink()
    act = Once(lambda: CHANGES[change](folder))
    with pytest.raises(FileError, match="while this run went on") as caught:
        made(folder, ONE, report=act, resume=resume)
    assert act.done
    assert caught.value.hint
    assert {path.name for path in folder.iterdir()} <= {MANIFEST, *SHARDS}
    (folder / MANIFEST).write_bytes(manifest)
    assert resumed(folder) == undisturbed()


def test_what_is_not_of_the_sweep_is_refused(folder: Path) -> None:
    before = states(folder)
    other = small_plan(frequency_hz="10:31:300")
    for how in ({"resume": True}, {"shards": "0:4"}):
        with pytest.raises(FileError, match=r"another sweep: frequency_hz: .*30 Hz.* there, .*31 Hz.* here"):
            made(folder, plan=other, **how)
        with pytest.raises(FileError, match="another sweep: shard cells: 200 there, 300 here"):
            made(folder, plan=small_plan(10), shard_cells=300, **how)
    shutil.copy(folder / shard_name(3), folder / shard_name(15))
    for how in ({"resume": True}, {"force": True}, {"shards": "0:4"}, {}):
        with pytest.raises(FileError, match=r"something else: part-000015\.parquet"):
            made(folder, **how)
    (folder / shard_name(15)).unlink()
    with pytest.raises(FileError, match="holds a sweep already"):
        made(folder)
    assert states(folder) == before
    for text in ('{"name": "an extension", "version": "1.0"}', "[]", "no JSON", ""):
        (folder / MANIFEST).write_text(text, encoding="utf-8")
        for how in ({"resume": True}, {"force": True}, {"shards": "0:4"}, {}):
            with pytest.raises(FileError, match="no manifest"):
                made(folder, **how)
        assert (folder / MANIFEST).read_text(encoding="utf-8") == text
        assert {**states(folder), MANIFEST: None} == {**before, MANIFEST: None}


def test_other_versions_are_not_mixed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = states(folder)
    monkeypatch.setattr("vibro.output.plan.versions", lambda: {"vibro": "0.1.0", "numpy": "1.0"})
    with pytest.raises(FileError, match=r"another sweep: numpy: .* there, 1\.0 here; scipy: .*none here"):
        made(folder, plan=small_plan(), resume=True)
    assert states(folder) == before
