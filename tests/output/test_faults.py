"""Sweeps in parts come out the same whatever happens to workers, clients, disks and files."""

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
from typing import Any

import pytest
from helpers.commands import POSIX, VIBRO
from helpers.parted import (
    COMMAND,
    HOPS,
    INTERRUPTED,
    LIMIT,
    NAMESPACE,
    PLAN,
    Once,
    ended_by,
    made,
    mounts,
    paused,
    plan_of,
    resumed,
    undisturbed,
)
from vibro.files.part_sets import MANIFEST, SUCCESS, PartSet, new_part, part_name
from vibro.sweeps.parted import Progress
from vibro.sweeps.parts import Job, check_part, solve_piece, write_part

from vibro.errors import FileError
from vibro.output.workers import Processes, Threads, Workers

pytest.importorskip("pyarrow")

ON_THREADS: tuple[str, ...] = ()
IN_PROCESSES = ("--workers", "2")


class Counted(Processes):
    """Processes which tell how often they were begun."""

    begun = 0

    def __enter__(self) -> Counted:
        self.begun += 1
        super().__enter__()
        return self


def kill_a_child() -> None:
    multiprocessing.active_children()[0].kill()


def job_of(folder: Path, plan: object = PLAN, wanted: Path | None = None) -> Job:
    folder.mkdir(exist_ok=True)
    return Job(plan, folder, "0" * 16, wanted or folder, 1, 1e9)  # type: ignore[arg-type]


def states(folder: Path) -> dict[str, tuple[int, int, bytes]]:
    """Say which files are in a folder."""
    return {
        path.name: (path.stat().st_ino, path.stat().st_mtime_ns, path.read_bytes())
        for path in folder.glob("part-*")
    }


@pytest.mark.parametrize("workers", [Threads(15), Processes(2)])
def test_parts_are_the_same_whoever_makes_them(two_cores: None, tmp_path: Path, workers: Workers) -> None:
    assert made(tmp_path / "wide", workers) == undisturbed()


@POSIX
def test_a_killed_process_is_replaced(tmp_path: Path) -> None:
    workers = Counted(1)
    kill = Once(kill_a_child)
    assert made(tmp_path / "wide", workers, report=kill) == undisturbed()
    assert kill.done
    assert workers.begun == 2


def test_processes_that_end_at_once_change_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.output.workers._begin_worker", partial(os._exit, 1))
    with pytest.raises(FileError, match="workers end as soon as they begin"):
        made(tmp_path / "wide", Processes(1))
    assert not (tmp_path / "wide").exists()


def test_processes_that_end_again_and_again_end_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def kill_for_good() -> None:
        monkeypatch.setattr("vibro.output.workers._begin_worker", partial(os._exit, 1))
        for child in multiprocessing.active_children():
            child.kill()

    with pytest.raises(FileError, match="again and again") as caught:
        made(tmp_path / "wide", Processes(1), report=Once(kill_for_good))
    assert "--resume" in caught.value.hint
    monkeypatch.undo()
    assert resumed(tmp_path / "wide") == undisturbed()


@pytest.mark.parametrize("workers", [Threads(1), Processes(2)])
def test_slow_parts_are_shared_where_there_are_several_workers(tmp_path: Path, workers: Workers) -> None:
    shared = []

    def look(progress: Progress) -> None:
        if progress.solved and not progress.parts:
            shared.append(progress.solved)

    found = made(tmp_path / "wide", workers, HOPS, look, patience=0.002)
    assert found == undisturbed(HOPS)
    assert bool(shared) == (workers.number > 1)


@POSIX
def test_a_process_that_is_killed_amid_pieces_is_replaced(tmp_path: Path) -> None:
    workers = Counted(2)

    def kill(progress: Progress) -> None:
        if progress.solved and not progress.parts and workers.begun == 1:
            kill_a_child()

    assert made(tmp_path / "wide", workers, HOPS, kill, patience=0.002) == undisturbed(HOPS)
    assert workers.begun == 2


@POSIX
@pytest.mark.parametrize("more", [ON_THREADS, IN_PROCESSES])
def test_a_killed_client_leaves_no_process_and_is_resumed(tmp_path: Path, more: tuple[str, ...]) -> None:
    run = paused(tmp_path, *more)
    assert ended_by(signal.SIGKILL, run, group=False) == (-signal.SIGKILL, "")
    assert resumed(tmp_path / "wide") == undisturbed()


@POSIX
@pytest.mark.parametrize(
    ("more", "number"),
    [(ON_THREADS, "SIGINT"), (IN_PROCESSES, "SIGINT"), (IN_PROCESSES, "SIGTERM"), (IN_PROCESSES, "SIGHUP")],
)
def test_interrupts_end_a_run_and_its_processes(tmp_path: Path, more: tuple[str, ...], number: str) -> None:
    run = paused(tmp_path, *more)
    assert ended_by(getattr(signal, number), run) == (130, INTERRUPTED)
    there = {path.name for path in (tmp_path / "wide").iterdir()}
    assert there > {MANIFEST}
    assert there - {MANIFEST} < {part_name(part) for part in range(15)}
    assert resumed(tmp_path / "wide") == undisturbed()


@POSIX
def test_the_second_of_two_clients_is_refused_and_harms_nothing(tmp_path: Path) -> None:
    first = paused(tmp_path)
    before = states(tmp_path / "wide")
    for more in ("--force", "--resume"):
        second = subprocess.run(
            [*VIBRO, *COMMAND, more], cwd=tmp_path, text=True, capture_output=True, check=False
        )
        assert second.returncode == 1
        assert second.stderr.startswith("error: another run is writing wide at this moment\nhint: wait")
    assert states(tmp_path / "wide") == before
    assert (tmp_path / "wide" / MANIFEST).exists()
    assert len(list((tmp_path / "wide").glob(".vibro-*/*"))) == 2  # the lock, and what says parts are wanted
    assert ended_by(signal.SIGINT, first) == (130, INTERRUPTED)
    assert resumed(tmp_path / "wide") == undisturbed()


def test_what_workers_of_a_dead_run_still_write_never_gets_in(tmp_path: Path) -> None:
    """They may write when the run that goes on has begun already."""
    folder = tmp_path / "wide"
    with PartSet(folder, "go on") as files:
        files.write(MANIFEST, PLAN.manifest(["test"]))
    late = [new_part(folder, part, "0123456789abcdef") for part in (0, 7)]
    late[0].write_bytes(b"late")

    def write_late() -> None:
        assert not late[0].exists()
        late[1].write_bytes(b"late")

    late_writing = Once(write_late)
    assert made(folder, Threads(15), report=late_writing, resume=True) == undisturbed()
    assert late_writing.done


@pytest.mark.parametrize("pieces", [False, True])
def test_a_worker_removes_what_it_has_made_when_nobody_wants_it_any_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, pieces: bool
) -> None:
    job = job_of(tmp_path / "wide", wanted=tmp_path / "wanted")
    work = partial(solve_piece, start=0, stop=100) if pieces else write_part
    assert work(job, 0) is None
    job.wanted.touch()
    begun = []

    def new(*args: Any) -> Path:
        begun.append(args)
        job.wanted.unlink()
        return new_part(*args)

    monkeypatch.setattr("vibro.sweeps.parts.new_part", new)
    assert work(job, 0) is None
    assert len(begun) == 1
    assert list(job.folder.iterdir()) == []


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a sweep, for tests that copy it."""
    folder = tmp_path_factory.mktemp("whole") / "wide"
    assert made(folder, Threads(15)) == undisturbed()
    return folder


def test_a_finished_sweep_that_is_resumed_stays_as_it_is(tmp_path: Path, whole: Path) -> None:
    folder = tmp_path / "wide"
    shutil.copytree(whole, folder)
    before = states(folder)
    said = (folder / SUCCESS).read_text(encoding="utf-8")
    assert resumed(folder, Processes(1)) == undisturbed() == json.loads(said)["digest"]
    assert states(folder) == before
    assert (folder / SUCCESS).read_text(encoding="utf-8") == said


def test_damaged_parts_are_made_again(tmp_path: Path, whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "wide"
    shutil.copytree(whole, folder)
    other = tmp_path / "other"
    made(other, Threads(15), plan_of(amplitude="0.5:2:10", frequency="10:31:300"))
    paths = [folder / part_name(part) for part in range(15)]
    content = paths[0].read_bytes()
    middle, name = len(content) // 3, content.rindex(b"regime") + 2
    paths[0].write_bytes(content[:-1])
    paths[1].write_bytes(paths[1].read_bytes()[: len(content) // 2])
    paths[2].write_bytes(b"")
    paths[3].unlink()
    paths[4].write_bytes((other / part_name(4)).read_bytes())  # of another sweep
    paths[5].write_bytes(paths[6].read_bytes())  # of another place
    for path, place in ((paths[7], middle), (paths[8], name)):
        content = path.read_bytes()
        path.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
    before = states(folder)
    publish = PartSet.publish

    def publish_not_finished(files: PartSet, temporary: str, name: str) -> None:
        assert not (folder / SUCCESS).exists()
        publish(files, temporary, name)

    monkeypatch.setattr(PartSet, "publish", publish_not_finished)
    assert resumed(folder) == undisturbed()
    after = states(folder)
    same = {name for name in after if before.get(name) == after[name]}
    assert same == {part_name(part) for part in (6, *range(9, 15))}


def test_no_changed_bit_of_a_part_is_overlooked(tmp_path: Path, whole: Path) -> None:
    folder = tmp_path / "wide"
    shutil.copytree(whole, folder)
    job, path = job_of(folder), folder / part_name(3)
    content = path.read_bytes()
    said = check_part(job, 3)
    assert said
    assert said.tally.status.total() == 200
    footer = len(content) - 8 - int.from_bytes(content[-8:-4], "little")
    for place in (*range(0, footer, 997), *range(footer, len(content), 31)):
        path.write_bytes(content[:place] + bytes([content[place] ^ (1 << place % 8)]) + content[place + 1 :])
        assert check_part(job, 3) is None, place


def test_what_is_not_of_the_sweep_is_refused(tmp_path: Path, whole: Path) -> None:
    folder = tmp_path / "wide"
    shutil.copytree(whole, folder)
    before = states(folder)
    other = plan_of(amplitude="0.5:2:10", frequency="10:31:300")
    with pytest.raises(FileError, match=r"another sweep: frequency_hz: .*30 Hz.* there, .*31 Hz.* here"):
        made(folder, Threads(15), other, resume=True)
    shutil.copy(folder / part_name(3), folder / part_name(15))
    with pytest.raises(FileError, match=r"parts that are none of this sweep: part-000015\.parquet"):
        made(folder, Threads(15), resume=True)
    (folder / part_name(15)).rename(folder / "more.parquet")
    for how in ("resume", "force"):
        with pytest.raises(FileError, match=r"holds something else: more\.parquet"):
            made(folder, Threads(15), **{how: True})  # type: ignore[arg-type]
    (folder / "more.parquet").unlink()
    with pytest.raises(FileError, match="holds a sweep already"):
        made(folder, Threads(15))
    assert states(folder) == before
    for text in ('{"name": "an extension", "version": "1.0"}', "[]", "no JSON", ""):
        (folder / MANIFEST).write_text(text, encoding="utf-8")
        for how in ("resume", "force"):
            with pytest.raises(FileError, match="is no manifest of a sweep"):
                made(folder, Threads(15), **{how: True})  # type: ignore[arg-type]
        assert (folder / MANIFEST).read_text(encoding="utf-8") == text
        assert states(folder) == before


def test_anew_begins_with_what_says_that_all_is_there(tmp_path: Path, whole: Path) -> None:
    folder = tmp_path / "wide"
    shutil.copytree(whole, folder)
    other = plan_of(parts=4, amplitude="0.5:2:10", frequency="10:31:300")
    assert made(folder, Threads(4), other, force=True) == undisturbed(other)


def test_a_worker_that_sees_other_files_under_the_same_name_is_told(tmp_path: Path) -> None:
    """As on another machine, whose disk is its own."""

    class Elsewhere(Threads):
        def submit(self, work, job, *args):  # type: ignore[no-untyped-def]
            (tmp_path / "elsewhere").mkdir(exist_ok=True)
            wanted = tmp_path / "elsewhere" / job.wanted.name
            return super().submit(work, Job(job.plan, wanted.parent, job.run, wanted, 1, 1e9), *args)

    with pytest.raises(FileError, match="a worker does not see the same files in"):
        made(tmp_path / "wide", Elsewhere(15))


FULL_DISK = """
import logging, sys
from pathlib import Path
from typing import Any
from helpers.parted import made, resumed, undisturbed
from vibro.errors import FileError
from vibro.output.workers import Cluster, Processes, Threads

def check(workers, folder):
    ballast = folder.with_name("ballast")
    ballast.write_bytes(bytes(1_350_000))
    try:
        made(folder, workers)
    except FileError as exc:
        assert str(exc) == f"cannot write to {folder}: No space left on device", exc
        assert exc.hint == "free some space; go on", exc.hint
    else:
        raise AssertionError("there was room for all")
    names = {path.name for path in folder.iterdir()}
    assert "manifest.json" in names and names - {"manifest.json"}, names
    assert all(name == "manifest.json" or name.startswith("part-") for name in names), names
    ballast.unlink()
    assert resumed(folder, workers) == sys.argv[2]
    for path in folder.iterdir():
        path.unlink()

if __name__ == "__main__":
    folder = Path(sys.argv[1]) / "wide"
    check(Threads(15), folder)
    check(Processes(1), folder)
    try:
        from distributed import LocalCluster
    except ImportError:
        sys.exit()
    # A part that fails after the sweep has ended is logged by the worker, here in this process.
    logging.getLogger("distributed.worker").setLevel(logging.CRITICAL)
    with LocalCluster(n_workers=1, processes=False, dashboard_address=":0") as cluster:
        check(Cluster(cluster.scheduler_address), folder)
    print("and Dask")
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
