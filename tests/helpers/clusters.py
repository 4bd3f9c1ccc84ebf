"""A Dask cluster of this machine's processes, whose members can be killed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Self

from helpers.sharded import LIMIT, until

TTL = "3s"  # after which a worker that says nothing is taken for lost


class Dask:
    """A scheduler and its workers, processes of this machine; a context.

    Parameters
    ----------
    folder : path
        For their log and other files.
    failures : int
        How many workers a task may lose before it is given up.
    """

    def __init__(self, folder: Path, failures: int = 3) -> None:
        self._folder = folder
        file = folder / "scheduler.json"
        self._environment = os.environ | {
            "DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": TTL,
            "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": str(failures),
        }
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

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for process in (*self.workers, self.scheduler):
            self.kill(process)
        self._log.close()
