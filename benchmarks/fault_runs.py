"""For faults.py: what runs write, the processes they are, faults at their steps, what is promised of files.

Each run is made once without a fault. Whatever else happens, a file of it has those bytes or is not there.
"""

from __future__ import annotations

import builtins
import errno
import fcntl
import functools
import hashlib
import importlib.util
import io
import json
import os
import re
import shutil
import signal
import sys
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import vibro.__main__

if TYPE_CHECKING:
    from collections.abc import Iterator

Act = Callable[[str], None]
PATIENCE: Final = 900.0  # [s] no run takes so long
VIBRO: Final = (sys.executable, "-m", "vibro")
_CALM: Final = Path("calm")  # where the runs without a fault are, below the place where the benchmark works


class BrokenError(Exception):
    """What does not hold, in one line."""


class Skipped(Exception):  # noqa: N818 (no error)
    """What the system lacks."""


def expect(holds: object, text: str) -> None:
    if not holds:
        raise BrokenError(text)


# What runs write.


class Form(NamedTuple):
    """A form of table: its option, the file that says that all are whole, and the modules that it needs."""

    options: tuple[str, ...]
    last: str
    needs: tuple[str, ...] = ()


#: A new form gets a line here.
FORMS: Final = {
    "csv": Form((), "set.json"),
    "xlsx": Form(("--table", "xlsx"), "set.json", ("vibro.output.xlsx", "xlsxwriter")),
    "parquet": Form(("--table", "parquet"), "set/_SUCCESS", ("pyarrow",)),
}
SWEEPS: Final = {  # axes, and cells of a shard
    "small": (("-A", "0.1:3:50", "-f", "15", "--regimes-only"), 20),  # without pictures
    "drawn": (("-A", "0.1:3:50", "-f", "15"), 20),
    "large": (("-A", "0.1:3:500", "-f", "5:25:1000", "--regimes-only"), 50_000),
    "1e7 cells": (("-A", "0.1:3:5000", "-f", "5:60:2000"), 1_000_000),
}
SCENE: Final = ("-a", "20", "--mu-d", "0.3")


def forms() -> Iterator[str]:
    """Return the forms that can be written here, and name the others."""
    for name, form in FORMS.items():
        lacking = [module for module in form.needs if not importlib.util.find_spec(module)]
        if lacking:
            print(f"    skipped: {name}, there is no {lacking[0]}")
        else:
            yield name


@dataclass(frozen=True)
class Run:
    """A sweep to the stem or folder ``out/set``, with a static friction that tells it from others."""

    form: str
    sweep: str = "small"
    number: int = 0
    more: tuple[str, ...] = ()

    @property
    def arguments(self) -> list[str]:
        """The arguments of vibro."""
        axes, shard_cells = SWEEPS[self.sweep]
        cut = ("--shard-cells", f"{shard_cells}") if self.form == "parquet" else ()
        scene = (*SCENE, "--mu-s", f"0.6{self.number:03d}7")
        return ["map", *axes, *scene, *FORMS[self.form].options, *cut, "-o", "out/set", *self.more]

    @functools.cached_property
    def calm(self) -> Path:
        """The place where it has run without a fault."""
        # Pictures beside a CSV know the arguments; nothing in a folder does but the manifest.
        told = (self.sweep, self.number, () if self.form == "parquet" else self.more)
        place = _CALM / f"{self.form} {told}".replace("/", "_")
        if not place.exists():
            place.mkdir(parents=True)
            run(Run(self.form, *told).begin(place)).check(0)
        return place.absolute()

    def copy(self, place: Path) -> None:
        """Have its set in a place."""
        shutil.copytree(self.calm / "out", place / "out")

    @functools.cached_property
    def files(self) -> dict[str, str]:
        """What its files hold, by their paths."""
        return contents(self.calm)[0]

    def begin(self, place: Path, *before: str, act: Act | None = None) -> Started:
        """Begin it in a place, as a fork of this process, or as a command behind other words."""
        return start([*before, *VIBRO, *self.arguments] if before else self.arguments, place, act=act)


# What is promised.


def contents(place: Path) -> tuple[dict[str, str], list[str]]:
    """Return what the files below a place hold, by their paths, and the paths of hidden folders."""
    found, hidden = {}, []
    top = place / "out"
    for folder, folders, names in os.walk(top):
        hidden += [name for name in folders if name.startswith(".vibro-")]
        folders[:] = [name for name in folders if not name.startswith(".vibro-")]
        for name in names:
            with suppress(FileNotFoundError):  # while runs go on
                found[str(Path(folder, name).relative_to(top))] = _content(Path(folder, name))
    return found, hidden


def _content(path: Path) -> str:
    data = path.read_bytes()
    if path.suffix == ".json":  # which tells the arguments, too
        with suppress(ValueError):
            data = json.dumps({**json.loads(data), "argv": None}).encode()
    return hashlib.sha256(data).hexdigest()


def whole(place: Path, *runs: Run, besides: bytes | None = None) -> dict[str, str]:
    """Expect that every file is whole, and of one of these runs; return what they hold.

    Files that hold ``besides`` are left out.
    """
    other = None if besides is None else hashlib.sha256(besides).hexdigest()
    found = {path: content for path, content in contents(place)[0].items() if content != other}
    for path, content in found.items():
        expect(any(own.files.get(path) == content for own in runs), f"{path} is half, or of no such run")
    return found


def check(place: Path, *runs: Run, hidden: int = 0) -> Run | None:
    """Expect what is promised of files; return the run whose set is whole, if there is one."""
    found, left = whole(place, *runs), contents(place)[1]
    expect(len(left) <= hidden, f"hidden folders left: {left}")
    done = [own for own in runs if found.get(FORMS[own.form].last) == own.files[FORMS[own.form].last]]
    for own in done:
        wrong = sorted(dict(found.items() ^ own.files.items()))
        expect(not wrong, f"beside its JSON {wrong} are of another run, or are not there")
    return done[0] if done else None


# Processes.


class Ended(NamedTuple):
    """How a process ended, with its peak memory [MB]."""

    code: int
    out: str
    err: str
    memory: float

    def check(self, *codes: int) -> Ended:
        """Expect one of these exit codes, a message with it, and no trace of the program's inside."""
        expect(self.code in codes, f"exit code {self.code}, not {codes}: {self.err[-300:]!r}")
        for words in ("Traceback", "Exception ignored", "unexpected", "Warning"):
            expect(words not in self.err, f"{words!r} on stderr: {self.err[-300:]!r}")
        expect(self.code not in (1, 2) or "error: " in self.err, f"exit code {self.code} without an error")
        return self


class Started(NamedTuple):
    """A process, and the place where it writes its streams."""

    pid: int
    place: Path


_running: set[int] = set()


def start(
    words: list[str], place: Path, *, act: Act | None = None, streams: dict[int, int | None] | None = None
) -> Started:
    """Begin a command in a place, with descriptors for its streams (None: closed).

    ``vibro map`` without its name is a fork of this process, where all is imported already. There ``act`` is
    called with the name of each call that changes files, before and after it.
    """
    sys.stdout.flush()
    pid = os.fork()
    if pid:
        _running.add(pid)
        return Started(pid, place)
    code = 1
    try:
        os.chdir(place)
        for number, name in ((1, "out"), (2, "err")):
            os.dup2(os.open(f"{os.getpid()}.{name}", os.O_CREAT | os.O_WRONLY), number)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        for number, other in (streams or {}).items():
            os.close(number) if other is None else os.dup2(other, number)
        if words[0] != "map":
            os.execvp(words[0], words)
        if act:
            _watch(act)
        sys.argv[1:] = words
        vibro.__main__.main()
    except SystemExit as exc:
        code = int(exc.code or 0)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        os._exit(code)


def run(started: Started, look: Callable[[], object] = lambda: None) -> Ended:
    """Wait for the end of a process, and look at something meanwhile."""
    pid, place = started
    deadline = time.monotonic() + PATIENCE
    while not (ended := os.wait4(pid, os.WNOHANG))[0]:
        look()
        time.sleep(0.001)
        if time.monotonic() > deadline:
            os.kill(pid, signal.SIGKILL)
    _running.discard(pid)
    out, err = ((place / f"{pid}.{name}").read_text("utf-8", "replace") for name in ("out", "err"))
    return Ended(os.waitstatus_to_exitcode(ended[1]), out, err, ended[2].ru_maxrss * 1024 / 1e6)


def end_all() -> None:
    """Kill what this process has begun and not waited for."""
    for pid in _running:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


# Faults at the steps of a run: calls that change files.


class Fault(NamedTuple):
    """A signal or an error; exit codes that may come of it, and steps at which a hidden folder may stay."""

    number: int
    codes: tuple[int, ...]
    leaves: str
    when: str = "before"
    for_good: bool = False

    def happen(self) -> None:
        """Let it happen to this process."""
        if isinstance(self.number, signal.Signals):
            os.kill(os.getpid(), self.number)
        else:
            raise OSError(self.number, os.strerror(self.number))


# As well as it can: neither when a lock is half taken, nor when the removal itself fails.
_LOCK, _REMOVAL = "(open|flock) lock-", "(open|flock) lock-|unlink|rmdir"
FAULTS: Final = {
    "SIGKILL": Fault(signal.SIGKILL, (-signal.SIGKILL,), ""),
    "SIGINT before": Fault(signal.SIGINT, (0, 130), _LOCK),
    "SIGINT after": Fault(signal.SIGINT, (0, 130), _LOCK, when="after"),
    "EIO": Fault(errno.EIO, (0, 1), _REMOVAL),
    "ENOSPC": Fault(errno.ENOSPC, (0, 1), _REMOVAL),
    "EACCES": Fault(errno.EACCES, (0, 1), _REMOVAL),
    "EIO for good": Fault(errno.EIO, (0, 1), "", for_good=True),
}
#: What some file systems lack: a call, and how they say so.
LACKS: Final = {
    "link": (errno.EPERM, errno.ENOTSUP),
    "flock": (errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP),
}
_CALLS: Final = {
    os: ("link", "rename", "replace", "unlink", "rmdir", "mkdir", "chmod", "open", "fsync"),
    fcntl: ("flock",),
    io: ("open",),
}


def at(step: int | str, do: Callable[[], object], *, when: str = "before", for_good: bool = False) -> Act:
    """Return an ``act`` that does something at the step of a number (and all later ones) or of a name."""
    count = 0

    def act(call: str) -> None:
        nonlocal count
        moment, _, name = call.partition(" ")
        count += moment == "before"
        if isinstance(step, int):
            here = count == step or (for_good and count > step)
        else:
            here = bool(re.match(step, name))
        if moment == when and here:
            do()

    return act


def steps_of(own: Run, place: Path) -> list[str]:
    """Return the names of the steps of a run without a fault."""
    path = place / "steps"

    def act(call: str) -> None:
        with path.open("a") as file:
            file.write(call + "\n")

    run(own.begin(place, act=act)).check(0)
    calls = path.read_text().splitlines()
    return [call.removeprefix("before ") for call in calls if call.startswith("before ")]


def _watch(act: Act) -> None:
    """Have ``act`` called before and after each call that changes something below ``out``."""
    top = os.path.abspath("out")  # noqa: PTH100 (of Path.absolute, '..' remains)

    def place_of(path: Any) -> str:
        """Return the last part of a path or of an open file's, if it is below."""
        with suppress(OSError, TypeError):
            whole = os.readlink(f"/proc/self/fd/{path}") if isinstance(path, int) else os.path.abspath(path)  # noqa: PTH100, PTH115
            return os.path.basename(whole) if f"{whole}/".startswith(f"{top}/") else ""  # noqa: PTH119
        return ""

    def watched(name: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any, **options: Any) -> Any:
            below = list(filter(None, map(place_of, (*args[:2], *options.values()))))
            mode = args[1] if args[1:] else options.get("flags", options.get("mode", "r"))
            reads = name == "open" and not (
                mode & os.O_CREAT if isinstance(mode, int) else set(mode) & set("wxa+")
            )
            if reads or not below:
                return real(*args, **options)
            act(f"before {name} {below[0]}")
            try:
                return real(*args, **options)
            finally:
                act(f"after {name} {below[0]}")

        return call

    for module, names in _CALLS.items():
        for name in names:
            setattr(module, name, watched(name, getattr(module, name)))
    builtins.open = io.open
