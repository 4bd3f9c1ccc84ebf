"""Sweeps in parts, small ones, and programs that make them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from helpers.commands import NUT_ANGLE_AND_FRICTION

from vibro.axes import parse_axis
from vibro.files.part_sets import MANIFEST, SUCCESS, PartSet, part_name
from vibro.quantities import QUANTITIES
from vibro.sweeps.columns import Table, columns_of
from vibro.sweeps.executors import Threads, Workers
from vibro.sweeps.grid import Grid
from vibro.sweeps.parted import Progress, agree, make_parts
from vibro.sweeps.plan import Plan, read_plan, versions

FIXED = {
    "drive_angle": 20.0,
    "static_friction": 0.74,
    "kinetic_friction": 0.57,
    "trough_angle": 0.0,
    "gravity": 9.81,
    "restitution": 0.3,
}
COMMAND = (
    *("map", "-A", "0.5:2:10", "-f", "10:30:300", *NUT_ANGLE_AND_FRICTION, "--flight", "off"),
    *("--restitution", "0.3", "--table", "parquet", "--part-cells", "200", "-o", "wide", "-q"),
)
"""A sweep of 15 parts, on the command line."""

LIMIT = 60.0  # [s] for what takes moments on a machine that is not busy

INTERRUPTED = "error: interrupted\nhint: the same command with --resume goes on\n"

AS_ROOT = () if getattr(os, "geteuid", int)() == 0 else ("--user", "--map-root-user")
NAMESPACE = ("unshare", *AS_ROOT, "--mount")
"""In which a process may mount disks of its own."""

PAUSES = (
    sys.executable,
    "-c",
    """
import signal, time

# A shell starts what it runs in the background with interrupts ignored, nohup with hang-ups.
for number in signal.SIGINT, signal.SIGHUP:
    signal.signal(number, signal.SIG_DFL)

from vibro.sweeps import parted

tell = parted._Run._tell

def tell_and_pause(run):
    tell(run)
    if len(run._summary.sizes) >= 3:
        print("paused", flush=True)
        time.sleep(120.0)

parted._Run._tell = tell_and_pause
from vibro.__main__ import main

main()
""",
)
"""The program, which pauses for ever when some parts are there."""


def plan_of(*, flight: bool = False, parts: int = 15, **texts: str) -> Plan:
    """Plan a sweep of the given axes, or of 3000 cells."""
    texts = texts or {"amplitude": "0.5:2:10", "frequency": "10:30:300"}
    axes = {name: parse_axis(text, QUANTITIES[name]).axis(5) for name, text in texts.items()}
    grid = Grid(axes, FIXED, None, flight=flight)
    table = Table(columns_of(axes, drive=grid.drive, made_with=grid.made_with))
    return Plan(grid, table, -(-grid.size // parts), "small", {}, versions())


class Once:
    """Does something when a run has come so far, once."""

    def __init__(self, act: Callable[[], object], parts: int = 3) -> None:
        self._act, self._parts = act, parts
        self.done = False

    def __call__(self, progress: Progress) -> None:
        if not self.done and progress.parts >= self._parts:
            self.done = True
            self._act()


PLAN = plan_of()
HOPS = plan_of(flight=True, parts=2, amplitude="4:6:80", frequency="20:22:80")
"""Of cells whose bodies bounce: a part takes long enough to be shared, where patience is short."""


def made(
    folder: Path,
    workers: Workers,
    plan: Plan = PLAN,
    report: Callable[[Progress], None] = lambda progress: None,
    *,
    resume: bool = False,
    force: bool = False,
    patience: float = 1e9,
) -> str:
    """Make a sweep, check what is left of that, and return its digest."""
    with PartSet(folder, "go on") as files:
        plan = agree(files, plan, resume=resume, force=force, own_size=True)
        with workers:
            summary = make_parts(
                plan, files, workers, ["test"], resume=resume, report=report, patience=patience
            )
        files.finish(summary.text())
    names = {path.name for path in folder.iterdir()}
    assert names == {MANIFEST, SUCCESS, *(part_name(part) for part in range(plan.parts))}
    return summary.digest


def resumed(folder: Path, workers: Workers | None = None) -> str:
    """Go on with whatever sweep is in a folder."""
    plan = read_plan((folder / MANIFEST).read_text(encoding="utf-8"), folder)
    return made(folder, workers or Threads(plan.parts), plan, resume=True)


@cache
def undisturbed(plan: Plan = PLAN) -> str:
    """Return the digest of a sweep that is made in this process in one go."""
    with TemporaryDirectory() as folder:
        return made(Path(folder) / "wide", Threads(1), plan)


def until(happens: Callable[[], bool]) -> None:
    """Wait until something happens."""
    end = time.monotonic() + LIMIT
    while not happens():
        assert time.monotonic() < end
        time.sleep(0.01)


def paused(folder: Path, *more: str) -> subprocess.Popen[str]:
    """Start the command in a session of its own, as a shell does, and wait until it has made some parts."""
    run = subprocess.Popen(
        [*PAUSES, *COMMAND, *more],
        cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip
    assert run.stdout is not None
    assert run.stdout.readline() == "paused\n"
    return run


def ended_by(number: signal.Signals, run: subprocess.Popen[str], *, group: bool = True) -> tuple[int, str]:
    """Send a signal, as terminals do to a whole group; return the exit code and what was said on stderr."""
    began = time.monotonic()
    if group:
        os.killpg(run.pid, number)
    else:
        run.send_signal(number)
    code = run.wait(LIMIT)
    assert time.monotonic() - began < 2.0
    # Whatever it has started has its stderr too, which ends with the last of them.
    _, said = run.communicate(timeout=LIMIT)
    return code, said


def mounts(folder: Path) -> bool:
    """Whether this system lets users mount a small disk for a process; CI must."""
    mount = [*NAMESPACE, "mount", "-t", "tmpfs", "none", str(folder)]
    try:
        works = subprocess.run(mount, capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        works = False
    assert works or "CI" not in os.environ
    return works
