"""Sweeps in shards come out the same whatever happens to workers, runs, disks and files."""

from __future__ import annotations

import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from helpers.commands import POSIX
from helpers.plans import written
from helpers.sharded import (
    INTERRUPTED,
    LIMIT,
    NAMESPACE,
    PLAN,
    SHARDS,
    Once,
    ended_by,
    made,
    mounts,
    paused,
    resumed,
    small_plan,
    undisturbed,
)
from pyarrow import parquet

from vibro.errors import FileError
from vibro.output.shard_folder import MANIFEST, SUCCESS, ShardFolder, shard_name
from vibro.output.shards import Job
from vibro.output.workers import Processes, Threads

if TYPE_CHECKING:
    from collections.abc import Callable

    from vibro.output.shards import Progress


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


def test_readers_see_whole_files_while_a_run_goes_on(tmp_path: Path) -> None:
    folder, seen = tmp_path / "wide", set()

    def look(progress: Progress) -> None:
        paths = set(folder.glob("*.parquet"))
        assert {path.name for path in paths} <= SHARDS
        assert len(paths) >= progress.shards
        assert not (folder / SUCCESS).exists()
        seen.add(len(paths))
        assert sum(len(parquet.read_table(path, columns=["regime"])) for path in paths) == 200 * len(paths)

    assert made(folder, report=look) == undisturbed()
    assert len(seen) > 2


@POSIX
def test_a_killed_process_is_replaced(tmp_path: Path) -> None:
    workers = Counted(1)
    kill = Once(kill_a_child)
    assert made(tmp_path / "wide", workers, report=kill) == undisturbed()
    assert kill.done
    assert workers.begun == 2


def test_processes_that_end_at_once_change_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.output.workers._begin_worker", partial(os._exit, 1))
    with pytest.raises(FileError, match="workers end"):
        made(tmp_path / "wide", Processes(1))
    assert not (tmp_path / "wide").exists()


@POSIX
def test_interrupts_end_a_command_and_its_processes(tmp_path: Path) -> None:
    run = paused(tmp_path, "--workers", "2")
    assert ended_by(signal.SIGTERM, run) == (130, INTERRUPTED)
    there = {path.name for path in (tmp_path / "wide").iterdir()}
    assert {MANIFEST} < there < {MANIFEST, *SHARDS}
    assert resumed(tmp_path / "wide") == undisturbed()


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
    "one is cut short": lambda folder: (folder / shard_name(2)).write_bytes(b"PAR1"),
    "one is replaced": lambda folder: shutil.copy(folder / shard_name(1), folder / shard_name(0)),
    "the manifest is edited": lambda folder: (folder / MANIFEST).write_text("{}", encoding="utf-8"),
    "the manifest is removed": lambda folder: (folder / MANIFEST).unlink(),
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


def touch(folder: Path) -> None:
    (folder / shard_name(0)).chmod(0o600)
    os.link(folder / shard_name(1), folder.with_name("link"))
    os.utime(folder / shard_name(2))
    (folder / MANIFEST).touch()
    (folder / "notes.txt").touch()


@POSIX
def test_what_is_touched_and_stays_the_same_is_no_fault(tmp_path: Path) -> None:
    folder = tmp_path / "wide"
    assert written(folder, PLAN, ONE, Once(partial(touch, folder))).digest == undisturbed()
    assert (folder / SUCCESS).exists()


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


def test_a_start_anew_that_is_killed_at_any_step_can_be_repeated(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Tables without a manifest would be taken for somebody else's."""
    unlink, removed = Path.unlink, []

    def killed(path: Path, **more: Any) -> None:
        if path.parent == folder and not more:
            removed.append(path)
            if len(removed) % 3 == 0:
                raise SystemExit
        unlink(path, **more)

    monkeypatch.setattr(Path, "unlink", killed)
    other = small_plan(4, frequency_hz="10:31:300")
    for _ in range(30):
        try:
            assert made(folder, plan=other, force=True) == undisturbed(other)
        except SystemExit:
            continue
        break
    assert len(removed) > 15
    assert made(folder, plan=other, resume=True) == undisturbed(other)


def test_a_worker_that_sees_other_files_under_the_same_name_is_told(tmp_path: Path) -> None:
    """As on another machine, whose disk is its own."""

    class Elsewhere(Threads):
        def submit(self, work, job, *args):  # type: ignore[no-untyped-def]
            hidden = tmp_path / "elsewhere" / ".vibro-hidden" / "run"
            hidden.parent.mkdir(parents=True, exist_ok=True)
            return super().submit(work, Job(job.plan, hidden, 1), *args)

    with pytest.raises(FileError, match="same files"):
        made(tmp_path / "wide", Elsewhere(15))


FULL_DISK = """
import sys
from pathlib import Path
from helpers.sharded import made, resumed
from vibro.errors import FileError
from vibro.output.workers import Threads

if __name__ == "__main__":
    folder = Path(sys.argv[1]) / "wide"
    ballast = folder.with_name("ballast")
    ballast.write_bytes(bytes(1_350_000))
    try:
        made(folder, Threads(15))
    except FileError as exc:
        assert str(exc) == f"cannot write to {folder}: No space left on device", exc
        assert exc.hint == "free some space; go on", exc.hint
    else:
        raise AssertionError("there was room for all")
    names = {path.name for path in folder.iterdir()}
    assert "_manifest.json" in names and names - {"_manifest.json"}, names
    assert all(name == "_manifest.json" or name.startswith("part-") for name in names), names
    ballast.unlink()
    assert resumed(folder) == sys.argv[2]
"""


def test_a_full_disk_is_told_and_the_sweep_resumed(tmp_path: Path) -> None:
    if not mounts(tmp_path):
        pytest.skip("no disks of their own (unshare, mount) for this user")
    program = tmp_path / "program.py"
    program.write_text(FULL_DISK, encoding="utf-8")
    disk = tmp_path / "disk"
    disk.mkdir()
    done = subprocess.run(
        [
            *(*NAMESPACE, "sh", "-c", 'mount -t tmpfs -o size=1500k none "$2" && exec "$0" "$@"'),
            *(sys.executable, str(program), str(disk), undisturbed()),
        ],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        capture_output=True, text=True, timeout=LIMIT, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
