"""Workers do their tasks, run no file of the current folder, and nobody waits for them without end."""

from __future__ import annotations

import gc
import logging
import os
import signal
import socket
import subprocess
import sys
import threading
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from helpers.commands import POSIX
from helpers.sharded import COMMAND, LIMIT, made, undisturbed

from vibro.errors import FileError
from vibro.output import workers as room
from vibro.output.workers import Cluster, Processes

if TYPE_CHECKING:
    from collections.abc import Iterator

distributed = pytest.importorskip("distributed")

HOSTILE = (
    *sys.stdlib_module_names,
    *("numpy", "pandas", "scipy", "pyarrow", "matplotlib", "typer", "rich", "click", "vibro"),
    *("sitecustomize", "usercustomize"),
)

AS_INSTALLED = "from vibro.__main__ import main\n\nif __name__ == '__main__':\n    main()\n"
"""What pip makes of the command."""


def test_no_file_of_the_current_folder_is_run(tmp_path: Path) -> None:
    here, there, markers = (tmp_path / name for name in ("here", "there", "markers"))
    for folder in (here, there, markers):
        folder.mkdir()
    for name in HOSTILE:
        (here / f"{name}.py").write_text(f"open({str(markers / name)!r}, 'w').close()\n", encoding="utf-8")
    (there / "run.py").write_text(AS_INSTALLED, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(there / "run.py"), *COMMAND, "--workers", "1"],
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


def levels() -> dict[str, int]:
    """Return the levels of all loggers."""
    return {name: logging.getLogger(name).level for name in [*logging.root.manager.loggerDict]}


@contextmanager
def answering(kind: str) -> Iterator[str]:
    """Return an address where no scheduler is."""
    if kind == "silence":
        with socket.create_server(("127.0.0.1", 0)) as server_socket:
            yield f"tcp://127.0.0.1:{server_socket.getsockname()[1]}"
    else:
        yield {"nothing": "tcp://127.0.0.1:1", "tls": "tls://127.0.0.1:1", "no address": "http://host"}[kind]


@pytest.mark.parametrize(
    ("kind", "told"),
    [
        ("nothing", "^no Dask scheduler answers at tcp://127.0.0.1:1: "),
        ("silence", "^no Dask scheduler answers at tcp:.*: no reason is given"),
        ("no address", "^no Dask scheduler answers at http://host: unknown address scheme 'http'"),
        ("tls", "^tls://127.0.0.1:1 needs certificates, and Dask's configuration names none"),
    ],
)
def test_an_address_without_a_scheduler_is_told_and_nothing_remains(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], kind: str, told: str
) -> None:
    if kind != "tls":  # that is told at once
        monkeypatch.setattr(room, "_CONNECTING", 0.5)
    with answering(kind) as address:
        before, levels_before = set(threading.enumerate()), levels()
        with pytest.raises(FileError, match=told) as caught:
            Cluster(address).__enter__()
        assert "--" not in f"{caught.value} {caught.value.hint}"  # options are the command line's matter
        left = set(threading.enumerate()) - before
        assert [thread.name for thread in left] == []
        assert levels() | levels_before == levels()
    del caught
    gc.collect()  # a client that is left behind writes a traceback now, or a warning
    assert capfd.readouterr() == ("", "")


def test_a_cluster_makes_the_same_shards(tmp_path: Path) -> None:
    how = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "protocol": "tcp"}
    with distributed.LocalCluster(**how, dashboard_address=None) as dask:
        assert made(tmp_path / "wide", Cluster(dask.scheduler_address)) == undisturbed()
