"""Runs for faults.py: what each writes, whether that is whole, and runs with a fault between two steps.

Usage: python benchmarks/fault_runs.py FAULT NUMBER FOLDER REPORT [arguments of vibro]

Runs vibro; at the call of that number that makes, renames or removes something in the folder, the fault
happens. The report is a file outside the folder; it gets the names of such calls, one a line.
"""

from __future__ import annotations

import builtins
import contextlib
import errno
import io
import json
import os
import random
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

VIBRO: Final = (sys.executable, "-m", "vibro")
PATIENCE: Final = 300  # [s] no run takes so long
STEM: Final = "set"


class Choice(NamedTuple):
    """What the user of faults.py chose."""

    tries: int
    chance: random.Random
    cells: int
    place: Path  # for what tries share


class Try(NamedTuple):
    """A check in a new folder, which raises BrokenError; tries of a kind differ in their numbers."""

    kind: str
    check: Callable[[Path], None]
    numbers: str = ""


class Skipped(Exception):  # noqa: N818 (no error)
    """What the system lacks."""


class BrokenError(Exception):
    """What does not hold, in one line."""


def expect(holds: bool, text: str) -> None:
    if not holds:
        raise BrokenError(text)


class Kind(NamedTuple):
    """A sweep: its axes, and what it writes."""

    arguments: tuple[str, ...]
    rows: int
    pictures: tuple[str, ...]


KINDS: Final = {
    "table": Kind(("-A", "0.1:3:50", "-f", "15", "--accuracy", "regimes"), 50, ()),
    "line": Kind(("-A", "0.1:3:50", "-f", "15"), 50, ("speed",)),
    "plane": Kind(("-A", "0.1:3:12", "-f", "5:60:12"), 144, ("regime", "speed")),
    "large": Kind(("-A", "0.1:3:1000", "-f", "5:25:1000", "--accuracy", "regimes"), 1_000_000, ("regime",)),
}


@dataclass(frozen=True)
class Run:
    """A sweep with a static friction of its own, by which every file tells whose it is."""

    kind: str
    number: int = 0

    @property
    def friction(self) -> str:
        """The static friction as it is given and written."""
        return f"0.6{self.number:03d}7"

    def sweep(self) -> list[str]:
        """Return the arguments without those that say where to write."""
        return ["map", *KINDS[self.kind].arguments, "-a", "20", "--mu-s", self.friction, "--mu-d", "0.3"]

    def arguments(self, folder: Path, stem: str = STEM, *, force: bool = False) -> list[str]:
        """Return the arguments that write to a stem."""
        return [*self.sweep(), "-o", str(folder / stem), *["--force"][: int(force)]]

    def files(self, stem: str = STEM) -> set[str]:
        """Return the names of all that it writes."""
        return {f"{stem}.csv", f"{stem}.json", *(f"{stem}-{p}.png" for p in KINDS[self.kind].pictures)}


class Ended(NamedTuple):
    """How a process ended."""

    code: int
    out: str
    err: str

    def check(self, *codes: int) -> None:
        """Expect one of these exit codes, a message with it, and no trace of the program's inside."""
        expect(self.code in codes, f"exit code {self.code}, not {codes}: {self.err[-300:]!r}")
        for words in ("Traceback", "Exception ignored", "unexpected", "Warning"):
            expect(words not in self.err, f"{words!r} on stderr: {self.err[-300:]!r}")
        if self.code in (1, 2):
            expect("error: " in self.err, f"exit code {self.code} without an error: {self.err[-300:]!r}")


@contextlib.contextmanager
def started(*commands: Sequence[str], **options: Any) -> Iterator[list[subprocess.Popen[str]]]:
    """Start processes at once; what still runs at the end is killed."""
    settings: dict[str, Any] = {
        "stdin": subprocess.DEVNULL,
        "stdout": subprocess.PIPE,
        "stderr": subprocess.PIPE,
        "encoding": "utf-8",
        "errors": "replace",
    }
    processes: list[subprocess.Popen[str]] = []
    try:
        for command in commands:
            processes.append(subprocess.Popen(command, **settings | options))
        yield processes
    finally:
        for process in processes:
            process.kill()
            process.communicate()


def ended(process: subprocess.Popen[str]) -> Ended:
    """Wait for the end of a process."""
    try:
        out, err = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        raise BrokenError(f"it does not end within {PATIENCE} s") from None
    return Ended(process.returncode, out or "", err or "")


def run(command: Sequence[str], **options: Any) -> Ended:
    """Run a process from start to end."""
    with started(command, **options) as (process,):
        return ended(process)


def names_in(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} if folder.exists() else set()


def published(folder: Path) -> dict[str, int]:
    """Return the number of every file of the set in a folder, which another of that name would not have."""
    with contextlib.suppress(FileNotFoundError), os.scandir(folder) as entries:
        own = [e for e in entries if e.name.startswith((f"{STEM}.", f"{STEM}-"))]
        return {e.name: e.inode() for e in own if e.name.endswith((".csv", ".json", ".png"))}
    return {}


def check_nothing(folder: Path) -> None:
    """Expect that nothing is there, or an empty folder."""
    expect(not names_in(folder), f"left behind: {sorted(names_in(folder))}")


def check_set(folder: Path, *sets: tuple[Run, str]) -> None:
    """Expect the whole sets of these runs at their stems, and nothing else."""
    expected = set().union(*(own.files(stem) for own, stem in sets))
    found = names_in(folder)
    expect(found == expected, f"{sorted(found)} instead of {sorted(expected)}")
    for own, stem in sets:
        for name in own.files(stem):
            owner(folder / name, [own], stem)


def check_unmixed(folder: Path, runs: Collection[Run]) -> Run | None:
    """Expect whole files at the stem and, beside a JSON, the set of its run alone; return that run.

    Temporary files may be there as well.
    """
    found = set(published(folder))
    owners = {name: owner(folder / name, runs, STEM) for name in found}
    first = owners.get(f"{STEM}.json")
    if first is not None:
        expect(found == first.files(), f"a JSON beside {sorted(found)}")
        expect(set(owners.values()) == {first}, f"a mix of runs: {owners}")
    return first


def owner(path: Path, runs: Collection[Run], stem: str) -> Run:
    """Expect a whole file, and return the run that wrote it."""
    return {".csv": _owner_of_table, ".json": _owner_of_json, ".png": _owner_of_picture}[path.suffix](
        path, runs, stem
    )


def _owner_of_table(path: Path, runs: Collection[Run], stem: str) -> Run:
    header, _, rows = path.read_bytes().partition(b"\n")
    expect(header.startswith(b"amplitude_mm,frequency_hz,"), f"{path.name} begins with {header[:80]!r}")
    lines = rows.count(b"\n")
    for own in runs:
        marked = rows.count(f",{own.friction},0.3,0,".encode())
        if marked:
            expected = KINDS[own.kind].rows
            expect(
                lines == marked == expected and rows.endswith(b"\n"),
                f"{path.name}: {lines} rows, {marked} its own, of {expected}, ends in {rows[-20:]!r}",
            )
            return own
    raise BrokenError(f"{path.name}: {lines} rows, of no run that should be there")


def _owner_of_json(path: Path, runs: Collection[Run], stem: str) -> Run:
    try:
        content = json.loads(path.read_bytes())
    except ValueError as exc:
        raise BrokenError(f"{path.name} is no JSON: {exc}") from None
    own = _by_friction(content, runs, path)
    expect(set(content["files"]) == own.files(stem), f"{path.name} lists {content['files']}")
    return own


def _owner_of_picture(path: Path, runs: Collection[Run], stem: str) -> Run:
    from PIL import Image  # not in the runs with a fault

    try:
        with Image.open(path) as picture:
            picture.load()
            content = json.loads(picture.info["Description"])
    except (OSError, SyntaxError, KeyError, ValueError) as exc:
        raise BrokenError(f"{path.name} does not open: {exc!r}") from None
    return _by_friction(content, runs, path)


def _by_friction(content: dict[str, Any], runs: Collection[Run], path: Path) -> Run:
    friction = str(content["scene"]["static_friction"])
    for own in runs:
        if own.friction == friction:
            return own
    raise BrokenError(f"{path.name} is of a run that should not be there, friction {friction}")


# What can happen at a call; "always": at all later calls, too; "after": once the call has done its work.
FAULTS: Final = ("EIO", "EIO always", "ENOSPC", "SIGKILL", "SIGINT before", "SIGINT after")
_STEPS: Final = ("link", "rename", "replace", "unlink", "remove", "mkdir", "rmdir", "chmod", "open")


def faulty(fault: str, number: int, folder: Path, report: Path, arguments: Sequence[str]) -> list[str]:
    """Return the command that runs vibro with a fault; ``none`` only counts, ``links`` lack throughout."""
    return [sys.executable, __file__, fault, str(number), str(folder), str(report), *arguments]


class _Steps:
    """Calls that change a folder, and the fault at one of them."""

    def __init__(self, fault: str, number: int, folder: str, report: str) -> None:
        self._fault, self._number, self._folder = fault, number, folder
        self._count = 0
        self._report = os.open(report, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        for name in _STEPS:
            setattr(os, name, self._wrapped(name, getattr(os, name)))
        builtins.open = io.open = self._wrapped("io.open", io.open)

    def _wrapped(self, name: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def step(*args: Any, **options: Any) -> Any:
            if not self._concerns(name, args, options):
                return real(*args, **options)
            if self._fault.startswith("links"):
                if name == "link":
                    raise OSError(getattr(errno, self._fault.split()[1]), "no links here")
                return real(*args, **options)
            self._count += 1
            os.write(self._report, f"{name}\n".encode())
            if self._count == self._number or (
                self._count > self._number > 0 and self._fault == "EIO always"
            ):
                self._happen("before")
                try:
                    return real(*args, **options)
                finally:
                    self._happen("after")
            return real(*args, **options)

        return step

    def _concerns(self, name: str, args: tuple[Any, ...], options: dict[str, Any]) -> bool:
        """Whether a call may change the folder."""
        if name == "open" and not (args[1] if len(args) > 1 else options["flags"]) & os.O_CREAT:
            return False
        if name == "io.open":
            mode = args[1] if len(args) > 1 else options.get("mode", "r")
            if not set(mode) & set("wxa+"):
                return False
        if any(number is not None for key, number in options.items() if key.endswith("dir_fd")):
            return True
        paths = [os.fspath(p) for p in args[:2] if isinstance(p, str | os.PathLike)]
        whole = [os.path.abspath(p) for p in paths]  # noqa: PTH100 (of Path.absolute, '..' remains)
        return any(p == self._folder or p.startswith(self._folder + os.sep) for p in whole)

    def _happen(self, when: str) -> None:
        first, _, rest = self._fault.partition(" ")
        if first.startswith("SIG"):
            if rest in ("", when):
                os.kill(os.getpid(), getattr(signal, first))
        elif when == "before" and first != "none":
            number = getattr(errno, first)
            raise OSError(number, os.strerror(number))


def main() -> None:
    fault, number, folder, report, *arguments = sys.argv[1:]
    sys.argv[1:] = arguments
    _Steps(fault, int(number), folder, report)
    import vibro.__main__  # after the steps are wrapped

    vibro.__main__.main()


if __name__ == "__main__":
    main()
