"""A small sweep in shards, what may happen to it, and a program that makes it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from helpers.commands import NUT_ANGLE_AND_FRICTION
from helpers.plans import NUT, written

from vibro.core.codes import Output
from vibro.output.plan import Plan, read_plan
from vibro.output.shard_folder import MANIFEST, SUCCESS, shard_name
from vibro.output.shards import Progress
from vibro.output.workers import Threads, Workers
from vibro.sweeps.columns import Table, columns_of
from vibro.sweeps.whole import request_of_call

GIVEN: dict[str, Any] = {"amplitude_mm": "0.5:2:10", "frequency_hz": "10:30:300", "restitution": 0.3, **NUT}
COMMAND = (
    *("map", "-A", "0.5:2:10", "-f", "10:30:300", *NUT_ANGLE_AND_FRICTION, "--flight", "off"),
    *("--restitution", "0.3", "--table", "parquet", "--shard-cells", "200", "-o", "wide", "-q"),
)
"""A sweep of 15 shards, on the command line."""

LIMIT = 60.0  # [s] for what takes moments on a machine that is not busy

INTERRUPTED = "error: interrupted\nhint: the same command with --resume goes on\n"

AS_COMMAND = """
import signal, time

# A shell starts what it runs in the background with interrupts ignored, nohup with hang-ups.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)

from vibro.output import shards

tell = shards._Run._tell

def tell_and_pause(run):
    tell(run)
    if len(run._summary.sizes) >= 3:
        print("paused", flush=True)
        time.sleep(120.0)

if __name__ == "__main__":
    shards._Run._tell = tell_and_pause
    from vibro.__main__ import main
    main()
"""
"""The program, which pauses for ever when some shards are there."""


def small_plan(shards: int = 15, **changed: Any) -> Plan:
    """Plan a sweep of 3000 cells, or of others."""
    grid = request_of_call(None, {**GIVEN, **changed}).grid(Output.EXACT, flight=False, coexistence=False)
    table = Table(columns_of(grid.axes, drive=grid.drive, made_with=grid.made_with))
    return Plan.of(grid, table, -(-grid.size // shards), "", {})


class Once:
    """Does something when a run has come so far, once."""

    def __init__(self, act: Callable[[], object], shards: int = 3) -> None:
        self._act, self._shards = act, shards
        self.done = False

    def __call__(self, progress: Progress) -> None:
        if not self.done and progress.shards >= self._shards:
            self.done = True
            self._act()


PLAN = small_plan()
SHARDS = {shard_name(shard) for shard in range(PLAN.shards)}


def made(
    folder: Path,
    workers: Workers | None = None,
    plan: Plan = PLAN,
    report: Callable[[Progress], None] = lambda progress: None,
    **how: Any,
) -> str:
    """Make a sweep, check that its files alone are left, and return its digest."""
    digest = written(folder, plan, workers, report, **how).digest
    names = {path.name for path in folder.iterdir()}
    assert names == {MANIFEST, SUCCESS, *(shard_name(shard) for shard in range(plan.shards))}
    return digest


def resumed(folder: Path, workers: Workers | None = None) -> str:
    """Go on with whatever sweep is in a folder."""
    plan = read_plan((folder / MANIFEST).read_text(encoding="utf-8"), folder)
    return made(folder, workers, plan, resume=True)


@cache
def undisturbed(plan: Plan = PLAN) -> str:
    """Return the digest of a sweep that is made in this process in one go."""
    with TemporaryDirectory() as folder:
        return made(Path(folder) / "wide", Threads(1), plan)


def paused(folder: Path, *more: str) -> subprocess.Popen[str]:
    """Start the program in a session of its own, as a shell does, and wait until it has made some shards."""
    file = folder.with_name("paused.py")
    file.write_text(AS_COMMAND, encoding="utf-8")
    run = subprocess.Popen(
        [sys.executable, str(file), *COMMAND, *more],
        cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip
    assert run.stdout is not None
    assert run.stdout.readline() == "paused\n"
    return run


def ended_by(number: signal.Signals, run: subprocess.Popen[str]) -> tuple[int, str]:
    """Send a signal, as terminals do to a whole group; return the exit code and what was said on stderr."""
    os.killpg(run.pid, number)
    code = run.wait(LIMIT)
    # Whatever it has started has its stderr too, which ends with the last of them.
    _, said = run.communicate(timeout=LIMIT)
    return code, said
