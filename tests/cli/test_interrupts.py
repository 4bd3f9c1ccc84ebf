"""Runs that are interrupted end at once with 130, say so, and leave nothing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from helpers.commands import LONG, POSIX, VIBRO, other, started

pytestmark = POSIX

# Tells when signals are handled, and goes on as the program does.
READY = (
    sys.executable,
    "-c",
    "from vibro.__main__ import main; from vibro.interrupts import end_on_signals;"
    " end_on_signals(); print('ready', flush=True); main()",
)


def wait_until_it_writes(run: subprocess.Popen[str], folder: Path, *, at_least: int = 1) -> None:
    """Wait until a run has so many bytes in one of the files that wait."""

    def writes() -> bool:
        waiting = folder.glob(".big.csv-*")
        return any(path.stat().st_size >= at_least for path in waiting)

    while not writes():
        assert run.poll() is None
        time.sleep(0.01)


def interrupted(run: subprocess.Popen[str], folder: Path) -> None:
    """Check how a run ended."""
    _, stderr = run.communicate()
    *echo, last = stderr.splitlines()
    assert run.returncode == 130
    assert last == "error: interrupted"
    assert all(line.startswith(("amplitude: ", "frequency: ", "warning: 9 000 000 rows")) for line in echo)
    assert list(folder.iterdir()) == []


def test_while_it_writes(tmp_path: Path) -> None:
    run = started(*LONG, "-o", "big", cwd=tmp_path)
    wait_until_it_writes(run, tmp_path)
    run.send_signal(signal.SIGINT)
    interrupted(run, tmp_path)


def test_while_bodies_hop_for_minutes(tmp_path: Path) -> None:
    run = started(
        *other(LONG, "-A", "4:8:3000", "-f", "30:60:3000"), "--restitution", "0.9", "-o", "big", cwd=tmp_path
    )
    wait_until_it_writes(run, tmp_path, at_least=0)
    time.sleep(0.2)  # into the first block
    run.send_signal(signal.SIGINT)
    interrupted(run, tmp_path)


@pytest.mark.parametrize(("number", "milliseconds"), [("SIGINT", 0), ("SIGHUP", 60)])
def test_from_the_first_moment_on_and_again_and_again(tmp_path: Path, number: str, milliseconds: int) -> None:
    run = started(*LONG, "-o", "big", cwd=tmp_path, program=READY)
    assert run.stdout is not None
    assert run.stdout.readline() == "ready\n"
    time.sleep(milliseconds / 1000)
    for _ in range(3):
        run.send_signal(getattr(signal, number))
        time.sleep(0.001)
    interrupted(run, tmp_path)


def test_a_signal_that_is_ignored_from_outside_stays_ignored(tmp_path: Path) -> None:
    """As in a script's background job, and under nohup."""
    code = """
import os, signal
for name in ("SIGINT", "SIGHUP"):
    signal.signal(getattr(signal, name), signal.SIG_IGN)
from vibro.interrupts import end_on_signals
end_on_signals()
os.kill(os.getpid(), signal.SIGINT)
os.kill(os.getpid(), signal.SIGHUP)
print("alive", flush=True)
os.kill(os.getpid(), signal.SIGTERM)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr, done.returncode) == ("alive\n", "error: interrupted\n", 130)


def test_the_cursor_is_shown_again(tmp_path: Path) -> None:
    """The progress bar hides it."""
    import pty

    ours, theirs = pty.openpty()
    with subprocess.Popen(
        [*VIBRO, *LONG, "-o", "big"],
        cwd=tmp_path, env=os.environ | {"TERM": "xterm-256color"}, stdout=subprocess.PIPE, stderr=theirs,
    ) as run:  # fmt: skip
        os.close(theirs)
        seen = b""
        while b"\x1b[?25l" not in seen:
            seen += os.read(ours, 4096)
        run.send_signal(signal.SIGINT)
        while True:
            try:
                seen += os.read(ours, 4096)
            except OSError:  # the other end has been closed
                break
    os.close(ours)
    assert run.returncode == 130
    assert seen.rindex(b"\x1b[?25h") > seen.rindex(b"\x1b[?25l")
    assert seen.endswith(b"error: interrupted\r\n")
    assert list(tmp_path.iterdir()) == []
