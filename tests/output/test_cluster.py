"""Sweeps in shards on a Dask cluster come out the same whatever happens to its workers, or the client."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from helpers.clusters import Dask
from helpers.commands import POSIX
from helpers.sharded import (
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
from vibro.output.shard_folder import SUCCESS
from vibro.output.workers import Cluster

if TYPE_CHECKING:
    from collections.abc import Iterator

pytest.importorskip("distributed")
pytestmark = POSIX


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Dask]:
    """Start a cluster."""
    with Dask(tmp_path_factory.mktemp("dask")) as dask:
        yield dask


@pytest.fixture
def two_workers(cluster: Dask) -> Dask:
    """Let the cluster have two workers, whatever the test before has done to it."""
    from distributed import Client

    for _ in range(2 - len(cluster.workers)):
        cluster.add()
    with Client(cluster.address, timeout=LIMIT, set_as_default=False) as client:
        until(lambda: len(client.nthreads()) == 2)
    return cluster


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


@pytest.mark.parametrize(
    ("number", "ends"),
    [(signal.SIGKILL, (-signal.SIGKILL, "")), (signal.SIGINT, (130, INTERRUPTED))],
)
def test_a_client_that_is_ended_is_resumed(
    two_workers: Dask, tmp_path: Path, number: signal.Signals, ends: tuple[int, str]
) -> None:
    run = paused(tmp_path, "--scheduler", two_workers.address)
    assert ended_by(number, run) == ends
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


@pytest.mark.parametrize("what", ["another version", "other files"])
def test_a_worker_that_cannot_do_the_work_ends_the_run_before_it_changes_anything(
    cluster: Dask, tmp_path: Path, what: str
) -> None:
    folder, preload = tmp_path / "wide", tmp_path.parent / "preload.py"
    before: tuple[str, ...] = ()
    if what == "another version":
        preload.write_text("import vibro.output.plan as plan; plan.__version__ = '0.0'", encoding="utf-8")
        told = r"^a worker has vibro 0\.0, "
    else:
        if not mounts(tmp_path):
            pytest.skip("no disks of their own (unshare, mount) for this user")
        preload.write_text("", encoding="utf-8")
        before = (*NAMESPACE, "sh", "-c", 'mount -t tmpfs none "$0" && exec "$@"', str(tmp_path))
        told = f"^a worker finds no folder {folder}"
    for worker in tuple(cluster.workers):
        cluster.kill(worker)
    worker = cluster.add("--no-nanny", "--preload", str(preload), before=before)
    try:
        with pytest.raises((FileError, VibroError), match=told):
            made(folder, Cluster(cluster.address))
    finally:
        cluster.kill(worker)
    assert not folder.exists()
