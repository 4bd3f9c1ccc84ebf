"""Classes of faults.py about what surrounds a run: signals, streams, the disk, memory."""

from __future__ import annotations

import contextlib
import functools
import json
import os
import pty
import re
import shutil
import signal
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from fault_runs import (
    KINDS,
    STEM,
    VIBRO,
    BrokenError,
    Choice,
    Ended,
    Run,
    Skipped,
    Try,
    check_nothing,
    check_set,
    ended,
    expect,
    names_in,
    owner,
    run,
    started,
)

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Iterator, Sequence

# Reports when the entry module is ready: it begins to import the rest.
READY: Final = """
import sys, vibro.__main__
class Ready:
    def find_spec(name, *rest):
        if name == "vibro.cli":
            sys.meta_path.remove(Ready)
            print("ready", flush=True)
sys.meta_path.insert(0, Ready)
vibro.__main__.main()
"""
SCENE: Final = ("-a", "20", "--mu-s", "0.7", "--mu-d", "0.3")
SOLVE: Final = ("solve", "-A", "1", "-f", "15", *SCENE)
ECHO: Final = re.compile(r"(amplitude|frequency): \d+ values, .*")
ESCAPE: Final = re.compile(r"\x1b\[[?\d;]*[A-Za-z]")
_SETTLED: Final = 10_000_000  # rows after which memory that is used again and again grows no more
HIDE, SHOW = "\x1b[?25l", "\x1b[?25h"  # the cursor
STREAMS: Final = (  # stdin, stdout, stderr
    ("", "closed", ""),
    ("", "", "closed"),
    ("", "closed", "closed"),
    ("closed", "closed", "closed"),
    ("", "full", ""),
    ("", "", "full"),
    ("", "full", "full"),
    ("", "broken", ""),
    ("", "", "broken"),
    ("", "broken", "broken"),
)


def signals(choice: Choice) -> Iterator[Try]:
    # One scene takes less than a second, a map with pictures more; a large sweep shows progress.
    latest = {"plane": 1.0, "solve": 0.5, "large": 1.0}  # [s] after the entry module is ready
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        for i in range(choice.tries):
            kind, repeats = list(latest)[i % 3], 1 + i // 3 % 3
            delay = choice.chance.uniform(0.0, latest[kind])
            check = functools.partial(_interrupt, getattr(signal, name), kind, repeats, delay)
            yield Try(f"{name}, {kind}", check, f"x {repeats} after {delay:.3f} s")


def _interrupt(number: signal.Signals, kind: str, repeats: int, delay: float, place: Path) -> None:
    folder, own = place / "out", Run(kind, 1) if kind in KINDS else None
    command = [sys.executable, "-c", READY, *(own.arguments(folder) if own else SOLVE)]

    def disturbed(process: subprocess.Popen[str]) -> Ended:
        expect(process.stdout is not None and process.stdout.readline() == "ready\n", "never ready")
        time.sleep(delay)
        for _ in range(repeats):
            process.send_signal(number)
            time.sleep(0.002)
        return ended(process)

    if kind == "large":
        end = _on_terminal(command, disturbed)
        expect(end.err.rfind(HIDE) <= end.err.rfind(SHOW), f"the cursor stays hidden: {end.err[-200:]!r}")
    else:
        with started(command) as (process,):
            end = disturbed(process)
    end.check(0, 130)
    if end.code == 130:
        lines = ESCAPE.sub("", end.err).replace("\r", "\n").split("\n")
        *before, last = [line for line in lines if line.strip()] or [""]
        expect(last == "error: interrupted", f"last line {last!r}")
        if kind != "large":
            expect(all(ECHO.fullmatch(line) for line in before), f"on stderr: {before}")
        check_nothing(folder)
    elif own:
        check_set(folder, (own, STEM))
    else:
        expect("regime" in end.out, f"exit code 0 and {end.out!r}")


def _on_terminal(command: Sequence[str], disturbed: Any) -> Ended:
    """Run a command whose stderr is a terminal."""

    def seen() -> str:
        parts = []
        with contextlib.suppress(OSError):  # so it ends on Linux
            while part := os.read(ours, 65536):
                parts.append(part)
        return b"".join(parts).decode("utf-8", "replace")

    ours, theirs = pty.openpty()
    try:
        environment = os.environ | {"TERM": "xterm-256color"}
        with ThreadPoolExecutor(1) as pool, started(command, stderr=theirs, env=environment) as (process,):
            os.close(theirs)
            text = pool.submit(seen)
            end = disturbed(process)
        return Ended(end.code, end.out, text.result())
    finally:
        os.close(ours)


def streams(choice: Choice) -> Iterator[Try]:
    own = Run("line", 1)
    commands = {  # arguments; whether stdout carries the answer, and whether files are written
        "solve": (SOLVE, True, False),
        "map -o STEM": (own.arguments(Path("out")), False, True),
        "map -o -": ((*own.sweep(), "-o", "-"), True, False),
        "map --json": ((*own.arguments(Path("out")), "--json"), True, True),
        "bad input": (("map", "-A", "nan", "-f", "15", *SCENE, "-o", f"out/{STEM}"), False, False),
        "--help": (("--help",), True, False),
    }
    for name, (arguments, answers, writes) in commands.items():
        for states in (("", "", ""), *STREAMS):
            code = 2 if name == "bad input" else int(answers and bool(states[1]))
            label = ", ".join(
                f"{stream} {state}"
                for stream, state in zip(("stdin", "stdout", "stderr"), states, strict=True)
                if state
            )
            check = functools.partial(_write_to, name, arguments, states, code, own if writes else None)
            yield Try(f"{name}, {label or 'all open'}", check)
    for name in ("solve", "map -o STEM"):
        arguments, _, writes = commands[name]
        check = functools.partial(
            _write_to, name, arguments, ("", "", ""), 0, own if writes else None, backend="bogus"
        )
        yield Try(f"{name}, MPLBACKEND=bogus", check)


def _write_to(
    name: str,
    arguments: Sequence[str],
    states: tuple[str, str, str],
    code: int,
    own: Run | None,
    place: Path,
    *,
    backend: str = "",
) -> None:
    """Run with streams that are closed, full or broken, and look at the others and at the files."""
    if "full" in states and not Path("/dev/full").exists():
        raise Skipped("no /dev/full")
    forms = {"": "", "broken": "", "closed": "{0}>&-", "full": "{0}>/dev/full"}
    redirections = " ".join(forms[state].format(i) for i, state in enumerate(states))
    options: dict[str, Any] = {"cwd": place}
    if backend:
        options["env"] = os.environ | {"MPLBACKEND": backend}
    with contextlib.ExitStack() as stack:
        for stream, state in zip(("stdout", "stderr"), states[1:], strict=True):
            if state == "broken":
                reader, writer = os.pipe()
                os.close(reader)
                stack.callback(os.close, writer)
                options[stream] = writer
        end = run(["sh", "-c", f'exec "$@" {redirections}', "sh", *VIBRO, *arguments], **options)
    expect(end.code == code, f"exit code {end.code}, not {code}: {end.err[-300:]!r}")
    if not states[2] and states[1] != "broken":  # who closed a pipe needs no message
        end.check(code)
    expect(names_in(place) <= {"out"}, f"files in the way: {names_in(place)}")
    if own:
        check_set(place / "out", (own, STEM))
    else:
        check_nothing(place / "out")
    if states[1]:
        return
    if name == "map -o -":
        (place / "answer.csv").write_text(end.out, encoding="utf-8")
        owner(place / "answer.csv", [Run("line", 1)], "answer")
    elif name == "map --json":
        try:
            json.loads(end.out)
        except ValueError:
            raise BrokenError(f"no JSON on stdout: {end.out[:200]!r}") from None
    else:
        begins = {"solve": "scene ", "--help": "Usage: "}.get(name, "")
        expect(end.out.lstrip().startswith(begins), f"stdout begins with {end.out[:200]!r}")
        expect(bool(begins) or not end.out, f"on stdout: {end.out[:200]!r}")


def disk(choice: Choice) -> Iterator[Try]:
    # Numbers of as many digits as a double has make rows longer than can be foreseen.
    angles = "-a 20.123456789012345 --trough-angle 1.2345678901234567"
    frictions = "--mu-s 0.7412345678901234 --mu-d 0.3123456789012345"
    long = f"-A 0.1012345678901234:2:95 -f 5.012345678901234:25:95 {angles} {frictions}".split()
    pictures = ["-A", "0.1:3:95", "-f", "5:25:95", *SCENE, "--format", "png,svg,pdf"]
    small = ["-A", "0.1:3:12", "-f", "5:25:12", *SCENE]
    for name, arguments in (("pictures", small), ("table", long)):
        yield Try(f"limited size of files, {name}", functools.partial(_limit, arguments))
    for name, arguments, filled in (("table", long, 0), ("pictures", pictures, 0), ("full before", small, 4)):
        yield Try(f"2 MB, {name}", functools.partial(_fill, arguments, filled))


def _check_full(end: Ended, folder: Path) -> None:
    end.check(1)
    expect(str(folder) in end.err, f"the place is not named: {end.err[-300:]!r}")
    expect("hint: " in end.err, f"no hint: {end.err[-300:]!r}")


def _limit(arguments: Sequence[str], place: Path) -> None:
    command = (*VIBRO, "map", *arguments, "-o", str(place / "out" / STEM))
    end = run(["sh", "-c", 'ulimit -f 160; exec "$@"', "sh", *command])
    _check_full(end, place / "out")
    check_nothing(place / "out")


@functools.cache
def _mounting() -> list[str]:
    """Return the command that starts another where it may mount a disk that is its own."""
    for user in ([], ["-U", "-r"]):
        command = ["unshare", *user, "-m"]
        if shutil.which("unshare") and not run([*command, "mount", "-t", "tmpfs", "tmpfs", "/mnt"]).code:
            return command
    raise Skipped("no disks of one's own (unshare -m)")


def _fill(arguments: Sequence[str], filled: int, place: Path) -> None:
    """Write to a disk of 2 MB, of which some are filled before."""
    folder, left = place / "disk", place / "left"
    folder.mkdir()
    script = (
        f'mount -t tmpfs -o size=2m tmpfs "$0" || exit 99; head -c {filled}M /dev/zero > "$0/filler"; '
        f'"$@"; code=$?; ls -A "$0" "$0/out" > {left}; exit $code'
    )
    command = (*VIBRO, "map", *arguments, "-o", str(folder / "out" / STEM))
    end = run([*_mounting(), "sh", "-c", script, str(folder), *command])
    _check_full(end, folder)
    names = [line for line in left.read_text().splitlines() if line and not line.startswith("/")]
    expect(set(names) <= {"filler", "out"}, f"left behind: {names}")


def memory(choice: Choice) -> Iterator[Try]:
    yield Try("1e7 cells to a file", _to_file)
    yield Try(f"{choice.cells} cells to stdout", functools.partial(_to_stdout, choice.cells))


def _to_file(place: Path) -> None:
    sweep = ("map", "-A", "0.1:3:5000", "-f", "5:60:2000", *SCENE)
    with started([*VIBRO, *sweep, "-o", str(place / "out")]) as (process,):
        most = 0.0
        while process.poll() is None:
            most = max(most, _memory(process, "VmHWM"))
            time.sleep(0.02)
        ended(process).check(0)
    expect(0.0 < most < 600.0, f"{most:.0f} MB")


def _to_stdout(cells: int, place: Path) -> None:
    """Read and drop a table; the memory in its first tenth must do for the rest."""
    settled = max(cells / 10, _SETTLED)
    axes = ("-A", f"0.1:3:{cells // 10_000}", "-f", "5:60:10000")
    sweep = ("map", *axes, *SCENE, "--flight", "off", "-o", "-")
    first = later = 0.0
    rows = 0
    # It may write a warning only: nobody reads its stderr meanwhile.
    with started([*VIBRO, *sweep, "-q"], encoding=None, errors=None) as (process,):
        assert process.stdout is not None
        while part := os.read(process.stdout.fileno(), 1 << 20):
            rows += part.count(b"\n")
            resident = _memory(process, "VmRSS")
            if rows < settled:
                first = max(first, resident)
            else:
                later = max(later, resident)
        expect(process.wait() == 0, f"exit code {process.returncode}")
    expect(rows == cells // 10_000 * 10_000 + 1, f"{rows} lines")
    expect(0.0 < later < first + 50.0, f"{first:.0f} MB in {settled:.0f} rows, {later:.0f} MB later")


def _memory(process: subprocess.Popen[str], name: str) -> float:
    """Resident memory of a process, now (VmRSS) or the most until now (VmHWM) [MB]; 0 once it has ended."""
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{process.pid}/status").read_text().splitlines():
            if line.startswith(f"{name}:"):
                return float(line.split()[1]) * 1024 / 1e6
    return 0.0
