"""Workers do their tasks, run no file of the current folder, and nobody waits for them without end."""

from __future__ import annotations

import gc
import http.server
import logging
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import BrokenExecutor, wait
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from helpers.clusters import Dask
from helpers.commands import POSIX
from helpers.sharded import COMMAND, LIMIT, until

from vibro.errors import FileError, VibroError
from vibro.output import workers as room
from vibro.output.workers import Cluster, Processes, Workers
from vibro.parallel import cores

if TYPE_CHECKING:
    from collections.abc import Iterator
    from concurrent.futures import Future

pytest.importorskip("distributed")

HOSTILE = (
    *sys.stdlib_module_names,
    *("numpy", "pandas", "scipy", "pyarrow", "matplotlib", "typer", "rich", "click", "vibro"),
    *("sitecustomize", "usercustomize"),
)

AS_INSTALLED = "from vibro.__main__ import main\n\nif __name__ == '__main__':\n    main()\n"
"""What pip makes of the command."""

OF_A_USER = """
import sys
import own
import vibro

if __name__ == "__main__":
    vibro.write_sweep(
        "wide", amplitude_mm="0.5:2:10", frequency_hz="10:30:30", drive_angle_deg=20, static_friction=0.74,
        kinetic_friction=0.57, shard_cells=50, workers=2,
    )
"""


@pytest.mark.parametrize("script", [AS_INSTALLED, OF_A_USER])
def test_no_file_of_the_current_folder_is_run(tmp_path: Path, script: str) -> None:
    here, there, markers = (tmp_path / name for name in ("here", "there", "markers"))
    for folder in (here, there, markers):
        folder.mkdir()
    for name in HOSTILE:
        (here / f"{name}.py").write_text(f"open({str(markers / name)!r}, 'w').close()\n", encoding="utf-8")
    (there / "run.py").write_text(script, encoding="utf-8")
    (there / "own.py").touch()  # what the script imports stays importable for its workers
    arguments = [*COMMAND, "--workers", "2"] if script is AS_INSTALLED else []
    done = subprocess.run(
        [sys.executable, str(there / "run.py"), *arguments],
        cwd=here, env={name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"},
        capture_output=True, text=True, timeout=LIMIT, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert (here / "wide" / "_SUCCESS").exists()
    assert list(markers.iterdir()) == []


def signals_blocked() -> set[int]:
    return set(signal.pthread_sigmask(signal.SIG_BLOCK, ()))


@POSIX
def test_processes_leave_interrupts_to_their_parent_which_stays_as_it_was(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    before = signals_blocked()
    with Processes(1) as workers:
        blocked = workers.submit(signals_blocked).result(LIMIT)
        assert signals_blocked() == before
        assert "PYTHONSAFEPATH" not in os.environ
        assert {signal.SIGINT, signal.SIGHUP} <= blocked
        assert signal.SIGTERM not in blocked  # by which a broken pool ends its others
        pool = workers.submit(os.getpid).result(LIMIT)
        with pytest.raises(BrokenExecutor):
            workers.submit(os._exit, 1).result(LIMIT)
    with workers:
        assert workers.submit(os.getpid).result(LIMIT) not in (pool, os.getpid())


def checked(workers: Workers, future: Future[Any]) -> Any:
    """Wait for a task as runs do."""
    end = time.monotonic() + LIMIT
    while not wait([future], 0.05).done:
        assert time.monotonic() < end
        workers.check()
    return future.result()


def levels() -> dict[str, int]:
    """Return the levels of all loggers."""
    return {name: logging.getLogger(name).level for name in [*logging.root.manager.loggerDict]}


@contextmanager
def answering(kind: str) -> Iterator[str]:
    """Return an address where no scheduler is."""
    if kind == "HTTP":
        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), http.server.BaseHTTPRequestHandler) as server:
            threading.Thread(target=server.serve_forever, args=(0.05,)).start()
            yield f"tcp://127.0.0.1:{server.server_port}"
            server.shutdown()
    elif kind == "silence":
        with socket.create_server(("127.0.0.1", 0)) as server_socket:
            yield f"tcp://127.0.0.1:{server_socket.getsockname()[1]}"
    else:
        yield {"nothing": "tcp://127.0.0.1:1", "tls": "tls://127.0.0.1:1", "no address": "http://host"}[kind]


@pytest.mark.parametrize(
    ("kind", "told"),
    [
        ("nothing", "^no Dask scheduler answers at tcp://127.0.0.1:1: "),
        ("HTTP", "^no Dask scheduler answers at tcp:.*: no reason is given"),
        ("silence", "^no Dask scheduler answers at tcp:.*: no reason is given"),
        ("no address", "^no Dask scheduler answers at http://host: unknown address scheme 'http'"),
        ("tls", "^tls://127.0.0.1:1 needs certificates, and Dask's configuration names none"),
    ],
)
def test_an_address_without_a_scheduler_is_told_and_nothing_remains(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], kind: str, told: str
) -> None:
    monkeypatch.setattr(http.server.BaseHTTPRequestHandler, "log_message", lambda *_: None)
    if kind != "tls":  # that is told at once
        monkeypatch.setattr(room, "_CONNECTING", 0.5)
    with answering(kind) as address:
        before, levels_before = set(threading.enumerate()), levels()
        with pytest.raises(FileError, match=told) as caught:
            Cluster(address).__enter__()
        assert "--" not in f"{caught.value} {caught.value.hint}"  # options are the command line's matter
        left = set(threading.enumerate()) - before
        assert [thread.name for thread in left if "process_request" not in thread.name] == []
        assert levels() | levels_before == levels()
    del caught
    gc.collect()  # a client that is left behind writes a traceback now, or a warning
    assert capfd.readouterr() == ("", "")


@pytest.fixture(scope="module")
def dask(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Dask]:
    """Start a scheduler that gives a task up as soon as it has lost a worker by it."""
    with Dask(tmp_path_factory.mktemp("dask"), failures=0) as cluster:
        yield cluster


@POSIX
def test_a_cluster_says_that_it_has_no_workers_and_waits_for_them(
    dask: Dask, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They come late, one dies of a task, those that replace it come late, and then none comes any more."""
    monkeypatch.setattr(room, "_LOOK", 0.5)
    said: list[str] = []

    def told() -> bool:
        workers.check()
        return bool(said)

    with Cluster(dask.address, said.append) as workers:
        future = workers.submit(max, 1, 2)
        until(told)
        assert said == [f"the scheduler at {dask.address} has no workers: waiting for 60 s"]
        dask.add()
        assert checked(workers, future) == 2
        until(lambda: not workers._absent)
        said.clear()
        with pytest.raises(ZeroDivisionError):
            checked(workers, workers.submit(divmod, 1, 0))
        with pytest.raises(BrokenExecutor):
            checked(workers, workers.submit(os._exit, 1))
        dask.kill(dask.workers[0])
        until(told)
        dask.add("--no-nanny", "--nthreads", "3")
        assert checked(workers, workers.submit(cores)) >= 1  # what vibro says there
        until(lambda: workers.number == 3)
        dask.kill(dask.workers[0])
        monkeypatch.setattr(room, "_ALONE", 1.0)
        with pytest.raises(FileError, match=r"^the scheduler at .* has no workers, for 1 s now") as caught:
            checked(workers, workers.submit(max, 1, 2))
    assert "resume=True" in caught.value.hint


@POSIX
def test_a_worker_that_has_no_vibro_is_told(dask: Dask, tmp_path: Path) -> None:
    (tmp_path / "preload.py").write_text("import sys; sys.modules['vibro'] = None", encoding="utf-8")
    worker = dask.add("--no-nanny", "--preload", str(tmp_path / "preload.py"))
    told = f"^a worker of {dask.address} has another version of vibro, or none: "
    with Cluster(dask.address) as workers, pytest.raises(VibroError, match=told):
        checked(workers, workers.submit(cores))
    dask.kill(worker)


@POSIX
def test_a_scheduler_that_stops_or_ends_is_told(
    dask: Dask, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(room, "_LOOK", 0.1)
    monkeypatch.setattr(room, "_ALONE", 0.5)
    with Cluster(dask.address) as workers:
        future = workers.submit(max, 1, 2)
        dask.scheduler.send_signal(signal.SIGSTOP)
        with pytest.raises(FileError, match=f"^the scheduler at {dask.address} does not answer, for 0 s"):
            checked(workers, future)
    dask.scheduler.send_signal(signal.SIGCONT)
    monkeypatch.setattr(room, "_ALONE", LIMIT)
    monkeypatch.setattr(
        room, "_CONNECTING", 3.0
    )  # for so long a client looks for a scheduler that it has lost
    with Cluster(dask.address) as workers:
        future = workers.submit(max, 1, 2)
        dask.kill(dask.scheduler)
        with pytest.raises(BrokenExecutor):
            checked(workers, future)
        with pytest.raises(BrokenExecutor):
            checked(workers, workers.submit(max, 1, 2))
        monkeypatch.setattr(room, "_CONNECTING", 0.5)
        workers.__exit__()
        with pytest.raises(FileError, match=f"^no Dask scheduler answers at {dask.address}: "):
            workers.__enter__()
    assert capfd.readouterr() == ("", "")
