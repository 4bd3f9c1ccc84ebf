"""Sweeps in parts on a Dask cluster come out the same whatever happens to its workers, or the whole of it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from helpers.commands import POSIX
from helpers.parted import (
    HOPS,
    INTERRUPTED,
    LIMIT,
    NAMESPACE,
    Once,
    ended_by,
    made,
    mounts,
    paused,
    resumed,
    undisturbed,
    until,
)

from vibro.errors import FileError, VibroError
from vibro.files.part_sets import MANIFEST, SUCCESS
from vibro.sweeps.executors import Cluster

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vibro.sweeps.parted import Progress

pytest.importorskip("distributed")
pytestmark = POSIX

TTL = "3s"  # after which a worker that says nothing is taken for lost


class Dask:
    """A scheduler and its workers, processes of this machine."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        file = folder / "scheduler.json"
        self._environment = os.environ | {"DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": TTL}
        self._log = (folder / "log").open("wb")
        self.scheduler = self._started(
            *("scheduler", "--host", "127.0.0.1", "--port", "0", "--dashboard-address", "127.0.0.1:0"),
            *("--no-show", "--scheduler-file", str(file)),
        )
        self.workers: list[subprocess.Popen[bytes]] = []
        until(lambda: file.exists() and file.read_text().rstrip().endswith("}"))
        self.address = json.loads(file.read_text())["address"]

    def _started(self, what: str, *options: str, before: tuple[str, ...] = ()) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [*before, sys.executable, "-m", "dask", what, "--no-dashboard", *options],
            cwd=self._folder, env=self._environment, stdout=self._log, stderr=self._log,
        )  # fmt: skip

    def add(self, *options: str, before: tuple[str, ...] = ()) -> subprocess.Popen[bytes]:
        """Start a worker."""
        options = (self.address, "--nthreads", "1", *(options or ("--no-nanny",)))
        self.workers.append(self._started("worker", *options, before=before))
        return self.workers[-1]

    def kill(self, process: subprocess.Popen[bytes]) -> None:
        """Kill the scheduler or a worker."""
        process.kill()
        process.wait(LIMIT)
        self.workers = [worker for worker in self.workers if worker is not process]

    def close(self) -> None:
        """Kill all of it."""
        for process in (*self.workers, self.scheduler):
            self.kill(process)
        self._log.close()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Dask]:
    """Start a cluster."""
    dask = Dask(tmp_path_factory.mktemp("dask"))
    yield dask
    dask.close()


@pytest.fixture
def two_workers(cluster: Dask) -> Dask:
    """Let the cluster have two workers, whatever the test before has done to it."""
    from distributed import Client

    for _ in range(2 - len(cluster.workers)):
        cluster.add()
    with Client(cluster.address, timeout=LIMIT, set_as_default=False) as client:
        until(lambda: len(client.nthreads()) == 2)
    return cluster


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give up soon what does not answer."""
    monkeypatch.setattr("vibro.sweeps.executors._CONNECTING", 1.0)


def test_parts_are_the_same(two_workers: Dask, tmp_path: Path) -> None:
    assert made(tmp_path / "wide", Cluster(two_workers.address)) == undisturbed()


def test_slow_parts_are_shared_though_a_worker_is_killed(two_workers: Dask, tmp_path: Path) -> None:
    solved: list[int] = []

    def kill(progress: Progress) -> None:
        if progress.solved and not progress.parts and not solved:
            solved.append(progress.solved)
            two_workers.kill(two_workers.workers[0])

    found = made(tmp_path / "wide", Cluster(two_workers.address), HOPS, kill, patience=0.002)
    assert found == undisturbed(HOPS)
    assert solved


def test_a_killed_worker_is_replaced(two_workers: Dask, tmp_path: Path) -> None:
    kill = Once(lambda: two_workers.kill(two_workers.workers[0]))
    assert made(tmp_path / "wide", Cluster(two_workers.address), report=kill) == undisturbed()
    assert kill.done


def test_when_all_workers_are_killed_others_go_on(two_workers: Dask, tmp_path: Path) -> None:
    def replace() -> None:
        for worker in tuple(two_workers.workers):
            two_workers.kill(worker)
        two_workers.add()

    assert made(tmp_path / "wide", Cluster(two_workers.address), report=Once(replace)) == undisturbed()


def test_a_killed_client_is_resumed(two_workers: Dask, tmp_path: Path) -> None:
    run = paused(tmp_path, "--scheduler", two_workers.address)
    assert ended_by(signal.SIGKILL, run) == (-signal.SIGKILL, "")
    assert resumed(tmp_path / "wide", Cluster(two_workers.address)) == undisturbed()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupts_end_a_run(two_workers: Dask, tmp_path: Path, number: signal.Signals) -> None:
    run = paused(tmp_path, "--scheduler", two_workers.address)
    assert ended_by(number, run) == (130, INTERRUPTED)
    assert not (tmp_path / "wide" / SUCCESS).exists()
    assert resumed(tmp_path / "wide", Cluster(two_workers.address)) == undisturbed()


def test_a_stopped_worker_is_replaced_and_what_it_says_later_does_no_harm(
    two_workers: Dask, tmp_path: Path
) -> None:
    stopped = two_workers.workers[0]
    stop = Once(lambda: stopped.send_signal(signal.SIGSTOP))
    try:
        assert made(tmp_path / "wide", Cluster(two_workers.address), report=stop) == undisturbed()
        assert stop.done
        before = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "wide").iterdir()}
        stopped.send_signal(signal.SIGCONT)
        assert stopped.wait(LIMIT) == 0  # it finds that it is given up
        assert {path.name: path.stat().st_mtime_ns for path in (tmp_path / "wide").iterdir()} == before
    finally:
        two_workers.kill(stopped)


def test_a_cluster_that_cannot_work_or_ends_is_told(
    tmp_path: Path, impatient: None, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "wide"
    with pytest.raises(FileError, match=r"^no scheduler answers at tcp://127\.0\.0\.1:1: "):
        made(folder, Cluster("tcp://127.0.0.1:1"))
    dask = Dask(tmp_path)
    try:
        with pytest.raises(FileError, match=f"^the scheduler at {dask.address} has no workers"):
            made(folder, Cluster(dask.address), resume=True)
        monkeypatch.setattr("vibro.sweeps.executors._CONNECTING", LIMIT)
        for code, told in (
            ("import vibro.sweeps.plan as plan; plan.__version__ = '0.0'", r"^a worker has vibro 0\.0, "),
            (
                "import sys; sys.modules['vibro'] = None",
                f"a worker of {dask.address} has another",
            ),
        ):
            preload = tmp_path / "preload.py"
            preload.write_text(code, encoding="utf-8")
            worker = dask.add("--no-nanny", "--preload", str(preload))
            with pytest.raises(VibroError, match=told):
                made(folder, Cluster(dask.address), resume=True)
            dask.kill(worker)
        if mounts(tmp_path):
            hides = ("sh", "-c", 'mount -t tmpfs none "$0" && exec "$@"', str(folder.parent))
            worker = dask.add("--no-nanny", before=(*NAMESPACE, *hides))
            with pytest.raises(FileError, match=f"^a worker finds no folder {folder}"):
                made(folder, Cluster(dask.address), resume=True)
            dask.kill(worker)
        dask.add()
        capfd.readouterr()
        monkeypatch.setattr("vibro.sweeps.executors._KNOWN", 0.0)  # it is asked all the time

        def end() -> None:
            monkeypatch.setattr("vibro.sweeps.executors._CONNECTING", 1.0)
            dask.kill(dask.scheduler)

        with pytest.raises(FileError, match=f"^no scheduler answers at {dask.address}: ") as caught:
            made(folder, Cluster(dask.address), report=Once(end), resume=True)
        assert "--resume goes on" in caught.value.hint
        assert capfd.readouterr() == ("", "")
    finally:
        dask.close()
    assert {path.name for path in folder.iterdir()} > {MANIFEST}
    assert resumed(folder) == undisturbed()
