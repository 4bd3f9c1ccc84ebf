"""Is what vibro promises of files true? Runs that meet, are killed or interrupted, or cannot write.

Usage: python benchmarks/faults.py [CLASS ...] [--tries N] [--seed 1] [--cells 1e6]

Prints how many tries of each class fail, and how; exits with 1 if one does. Without a class all run but
``resume`` and ``memory``, which take minutes, and GB of disk with --cells 1e8. Needs Linux; what a system
lacks is skipped by name. docs/reference/written-files.md has what ``check`` of fault_runs.py expects.

steps       a fault at each call that changes files; then the next run
kills       SIGKILL at random moments; then the next run
twins       2 and 8 runs at one stem or folder at once, also where file systems lack something
ranges      --shards, ranges at once and twice; then a run that finishes the folder
namespaces  runs that are process 1 each: at one stem, and one that comes while another works
places      names and folders that are unusual, or in the way, or change while a run works
signals     SIGINT, SIGTERM, SIGHUP from the first moment on, once to three times
streams     closed, full and broken stdout and stderr
disk        a disk that is full at any of its pages, and a limit on the size of files
resume      a sweep of --cells, killed and resumed
memory      1e7 cells to a file and to a folder
"""

from __future__ import annotations

import argparse
import atexit
import errno
import functools
import os
import pty
import random
import re
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from fault_runs import (
    FAULTS,
    FORMS,
    LACKS,
    SCENE,
    SWEEPS,
    VIBRO,
    Act,
    BrokenError,
    Fault,
    Run,
    Skipped,
    Started,
    at,
    check,
    contents,
    end_all,
    expect,
    forms,
    run,
    start,
    steps_of,
    whole,
)  # fmt: skip

from vibro.output.hidden import hidden_folder

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

FORCE: Final = ("--force",)
MINE: Final = b"mine"


class Choice(NamedTuple):
    """What the user chose."""

    tries: int
    chance: random.Random
    cells: int


class Try(NamedTuple):
    """A check in a new folder, which raises BrokenError; tries of a kind differ in their numbers."""

    kind: str
    check: Callable[[Path], None]
    numbers: str = ""


def go_on(place: Path, own: Run, *, resumed: bool) -> None:
    """Expect that the next run works, and leaves nothing of all before."""
    following = Run(own.form, own.sweep, own.number, ("--resume",))
    following = following if resumed else Run(own.form, "small", 999, FORCE)
    run(following.begin(place)).check(0)
    expect(check(place, following) == following, "the next run leaves no whole set")


def survives(
    own: Run,
    old: Sequence[Run],
    begin: Callable[[Path], Started],
    codes: Sequence[int],
    hidden: int,
    place: Path,
) -> None:
    """Expect what is promised of a run to which something happens, and of the next."""
    for other in old:
        other.copy(place)
    end = run(begin(place)).check(*codes)
    left = check(place, own, *old, hidden=hidden)
    expect(end.code != 0 or left == own, "exit code 0 without the set")
    go_on(place, own, resumed=own.form == "parquet" and not old)


def steps(choice: Choice) -> Iterator[Try]:
    for form in forms():
        for own, old in (
            (Run(form, "drawn", 2), []),
            (Run(form, "small", 2, FORCE), [Run(form, "drawn", 1)]),
        ):
            with tempfile.TemporaryDirectory() as place:
                for other in old:
                    other.copy(Path(place))
                names = steps_of(own, Path(place))
            expect(len(names) > len(own.files), f"only {len(names)} steps of {form} are watched")
            for label, fault in FAULTS.items():
                for i in sorted(choice.chance.sample(range(len(names)), min(choice.tries, len(names)))):
                    act = at(i + 1, fault.happen, when=fault.when, for_good=fault.for_good)
                    hidden = int(bool(re.match(fault.leaves, names[i])))
                    what = partial(survives, own, old, partial(own.begin, act=act), fault.codes, hidden)
                    yield Try(
                        " ".join([form, *own.more, label]), what, f"{names[i]}, {i + 1} of {len(names)}"
                    )


def kills(choice: Choice) -> Iterator[Try]:
    def killed(own: Run, delay: float, place: Path) -> Started:
        begun = own.begin(place, "env")
        time.sleep(delay)
        os.kill(begun.pid, signal.SIGKILL)
        return begun

    for form in forms():
        for sweep, more in (("drawn", ()), ("large", ()), ("large", FORCE), ("large", ("--workers", "2"))):
            if form != "parquet" and "--workers" in more:
                continue
            own, old = Run(form, sweep, 1, more), [Run(form, "drawn")] * (more == FORCE)
            with tempfile.TemporaryDirectory() as place:
                began = time.perf_counter()
                run(own.begin(Path(place), "env")).check(0)
                duration = time.perf_counter() - began
            for _ in range(choice.tries):
                delay = choice.chance.uniform(0.0, duration)
                what = partial(survives, own, old, partial(killed, own, delay), (0, -signal.SIGKILL), 1)
                yield Try(" ".join([form, sweep, *more]), what, f"after {delay:.3f} s")


def meet(runs: Sequence[Run], place: Path, *, before: Sequence[str] = (), act: Act | None = None) -> None:
    """Expect of runs at one stem that one writes, and others end with an error unless they come after it."""
    begun = [own.begin(place, *before, act=act) for own in runs]
    ends = [run(one, partial(whole, place, *runs)).check(0, 1) for one in begun]
    winners = [own for own, end in zip(runs, ends, strict=True) if end.code == 0]
    expect(winners, f"no run succeeds: {ends[0].err[-300:]!r}")
    expect(len(winners) == 1 or runs[0].more == FORCE, f"{len(winners)} of {len(runs)} runs succeed")
    for end in ends:
        said = "another run is writing" in end.err or "exist" in end.err or "holds a sweep" in end.err
        expect(end.code == 0 or said, f"it fails of something else: {end.err[-300:]!r}")
    expect(check(place, *runs) in winners, "no set of a run that succeeded")


def twins(choice: Choice) -> Iterator[Try]:
    for form in forms():
        for number in (2, 8):
            for more in ((), FORCE):
                runs = [Run(form, "small", i, more) for i in range(number)]
                yield from [Try(" ".join([form, f"{number}", *more]), partial(meet, runs))] * choice.tries
        for name, errors in LACKS.items():
            for error in errors:
                act = at(f"{name} ", Fault(error, (), "").happen)
                for number in (1, 4):
                    runs = [Run(form, "small", i) for i in range(number)]
                    kind = f"{form}, {number}, {name} fails with {errno.errorcode[error]}"
                    yield from [Try(kind, partial(meet, runs, act=act))] * (1 + choice.tries // 4)


def ranges(choice: Choice) -> Iterator[Try]:
    def at_once(own: Run, parts: Sequence[str], codes: Sequence[int], kill: float, place: Path) -> None:
        runs = [Run(own.form, own.sweep, own.number, ("--shards", part) if part else ()) for part in parts]
        begun = [one.begin(place) for one in runs]
        if kill:
            time.sleep(kill)
            os.kill(begun[0].pid, signal.SIGKILL)
        for one in begun:
            run(one, partial(whole, place, own)).check(*codes)
        go_on(place, own, resumed=True)

    own = Run("parquet", "large", 3)
    for _ in range(choice.tries):
        yield Try("apart", partial(at_once, own, ("0:3", "3:5", "5:9", "9:10"), (0,), 0.0))
        yield Try("overlapping", partial(at_once, own, ("0:6", "3:8", "2:10"), (0,), 0.0))
        yield Try("the same", partial(at_once, own, ("0:6", "0:6", "6:10"), (0, 1), 0.0))
        yield Try("beside a whole run", partial(at_once, own, ("0:6", "", "6:10"), (0, 1), 0.0))
        delay = choice.chance.uniform(0.05, 1.0)
        codes = (0, -signal.SIGKILL)
        yield Try("one killed", partial(at_once, own, ("0:6", "6:10"), codes, delay), f"after {delay:.3f} s")


@functools.cache
def apart(*options: str) -> list[str]:
    """Return the words before a command by which it has namespaces of its own."""
    for user in ([], ["-U", "-r"]):
        command = ["unshare", *user, *options]
        if shutil.which("unshare") and not run(start([*command, "true"], Path(tempfile.gettempdir()))).code:
            return command
    raise Skipped(f"no namespaces (unshare {' '.join(options)})")


def namespaces(choice: Choice) -> Iterator[Try]:
    before = apart("-p", "-f", "--mount-proc", "--kill-child")

    def beside(form: str, place: Path) -> None:
        own, late = Run(form, "large", 1), Run(form, "small", 2, FORCE)
        begun = own.begin(place, *before)
        while not contents(place)[1]:
            time.sleep(0.005)
        child = int(Path(f"/proc/{begun.pid}/task/{begun.pid}/children").read_text())
        os.kill(child, signal.SIGSTOP)
        end = run(late.begin(place, *before)).check(1)
        os.kill(child, signal.SIGCONT)
        expect("another run is writing" in end.err, f"it fails of something else: {end.err!r}")
        run(begun).check(0)
        expect(check(place, own, late) == own, "its set is not there")

    for form in forms():
        for _ in range(choice.tries):
            runs = [Run(form, "small", i) for i in range(2)]
            yield Try(f"{form}, at once", partial(meet, runs, before=before))
            yield Try(f"{form}, beside a long run", partial(beside, form))


# What is not ours comes, or what is goes: form, options, at which step (else before), what, and where.
_HIDDEN: Final = hidden_folder(Path("set")).name
_READY, _RENAMED, _LAST = "open set.json", "(link|replace) set.csv", "open _SUCCESS"
PLACES: Final = (
    ("csv", (), "", "file", "set.csv"),
    ("csv", (), "", "file", "set.json"),
    ("csv", FORCE, "", "folder", "set.csv"),
    ("csv", FORCE, "", "link", "set.csv"),
    ("csv", (), _RENAMED, "file", "set.csv"),
    ("csv", (), _RENAMED, "file", "set.json"),
    ("csv", FORCE, _READY, "folder", "set.csv"),
    ("csv", FORCE, _READY, "link", "set.csv"),
    ("csv", FORCE, _RENAMED, "folder", "set.json"),
    ("csv", (), _READY, "gone", "../out"),
    ("csv", FORCE, _RENAMED, "gone", "../out"),
    ("csv", (), _READY, "gone", ".vibro-*"),
    ("csv", FORCE, "", "file", _HIDDEN),
    ("csv", FORCE, "", "link", _HIDDEN),
    ("csv", FORCE, "", "file", f"{_HIDDEN}/lock-another-system"),
    ("parquet", (), "", "file", "set/mine"),
    ("parquet", (), "", "file", "set/part-000000.parquet"),
    ("parquet", (), "replace part-000001", "folder", "set/part-000001.parquet"),
    ("parquet", (), _LAST, "file", "set/part-000000.parquet"),
    ("parquet", (), _LAST, "file", "set/other.parquet"),
    ("parquet", (), _LAST, "file", "set/_manifest.json"),
    ("parquet", (), _LAST, "gone", "set/part-000001.parquet"),
    ("parquet", (), _LAST, "gone", "set/_manifest.json"),
    ("parquet", (), _LAST, "gone", "set/.vibro-*"),
    ("parquet", (), _LAST, "gone", "set"),
)


def happen(what: str, name: str, out: Path) -> None:
    """Let something come or go."""
    path = out / name
    for gone in out.glob(name) if what == "gone" else [path] * path.is_file():
        shutil.rmtree(gone) if gone.is_dir() else gone.unlink()
    if what != "gone":
        path.parent.mkdir(parents=True, exist_ok=True)
        mine = {"file": path, "folder": path / "mine", "link": out / "../other/mine"}[what]
        mine.parent.mkdir(exist_ok=True)
        mine.write_bytes(MINE)
        if what == "link":
            path.symlink_to("../other")


def places(choice: Choice) -> Iterator[Try]:
    def beside(own: Run, step: str, what: str, name: str, place: Path) -> None:
        do = partial(happen, what, name, place / "out")
        if not step:
            do()
        run(own.begin(place, act=at(step or "never", do))).check(1)
        mine = [path for path in place.rglob("*") if path.is_file() and path.read_bytes() == MINE]
        expect(len(mine) == (what != "gone"), "what was not ours is gone, or never came")
        expect(FORMS[own.form].last not in whole(place, own, besides=MINE), "there is a JSON all the same")

    for form, more, step, what, name in PLACES:
        kind = " ".join([form, *more, f"at {step!r}" if step else "before", what, name])
        yield Try(kind, partial(beside, Run(form, more=more), step, what, name))


# Installs the handler of signals as the command does, and says so.
READY: Final = """
from vibro.interrupts import end_on_signals
end_on_signals()
open("ready", "w").close()
from vibro.__main__ import main
main()
"""
_ESCAPE: Final = re.compile(r"\x1b\[[?\d;]*[A-Za-z]")
_HIDE, _SHOW = "\x1b[?25l", "\x1b[?25h"  # the cursor


def signals(choice: Choice) -> Iterator[Try]:
    def interrupted(own: Run, number: int, repeats: int, delay: float, place: Path) -> None:
        ours, theirs = pty.openpty()
        os.set_blocking(ours, False)
        seen = []

        def look() -> None:
            with suppress(OSError):
                seen.append(os.read(ours, 65536))

        try:
            command = [sys.executable, "-c", READY, *own.arguments]
            begun = start(command, place, streams={2: theirs} if own.sweep == "large" else None)
            while not (place / "ready").exists():
                time.sleep(0.001)
            until = time.monotonic() + delay
            while time.monotonic() < until:
                look()
                time.sleep(0.001)
            for _ in range(repeats):
                os.kill(begun.pid, number)
                time.sleep(0.002)
            end = run(begun, look)
            look()
        finally:
            os.close(ours)
            os.close(theirs)
        text = end.err + b"".join(seen).decode()
        end._replace(err=text).check(0, 130)
        expect(text.rfind(_HIDE) <= text.rfind(_SHOW), f"the cursor stays hidden: {text[-200:]!r}")
        lines = [line for line in _ESCAPE.sub("", text).replace("\r", "\n").split("\n") if line.strip()]
        last = [line for line in lines if not line.startswith("hint: ")][-1:]
        expect(end.code == 0 or last == ["error: interrupted"], f"last lines {lines[-2:]}")
        left = check(place, own)
        expect(end.code != 0 or left == own, "exit code 0 without the set")
        go_on(place, own, resumed=own.form == "parquet")

    for form in forms():
        for sweep, latest in (("drawn", 1.5), ("large", 1.5)):  # [s] after the handler is installed
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                for i in range(choice.tries):
                    delay = choice.chance.uniform(0.0, latest)
                    what = partial(interrupted, Run(form, sweep, 1), number, 1 + i % 3, delay)
                    yield Try(f"{form} {sweep} {number.name}", what, f"x {1 + i % 3} after {delay:.3f} s")


def streams(choice: Choice) -> Iterator[Try]:
    runs = {"map": Run("csv", "drawn"), "map --json": Run("csv", "drawn", more=("--json",))}
    commands = {  # arguments, and how the answer on stdout begins
        "solve": (["solve", "-A", "1", "-f", "15", *SCENE, "--mu-s", "0.7"], "scene "),
        "map": (runs["map"].arguments, ""),
        "map --json": (runs["map --json"].arguments, "{"),
        "map -o -": ([*Run("csv").arguments, "-o", "-"], "amplitude_mm,"),
        "--help": (["--help"], "Usage: "),
        "bad input": ([*Run("csv").arguments, "-A", "nan"], ""),
    }

    def written(name: str, given: dict[int, str], place: Path) -> None:
        arguments, begins = commands[name]
        reader, writer = os.pipe()
        os.close(reader)
        known = {"closed": None, "full": os.open("/dev/full", os.O_WRONLY), "broken": writer}
        end = run(start([*VIBRO, *arguments], place, streams={i: known[state] for i, state in given.items()}))
        for number in filter(None, known.values()):
            os.close(number)
        code = 2 if name == "bad input" else int(bool(begins) and 1 in given)
        expect(end.code == code, f"exit code {end.code}, not {code}: {end.err[-300:]!r}")
        if 2 not in given and given.get(1) != "broken":  # who closes a pipe needs no message
            end.check(code)
        if 1 not in given:
            expect(
                end.out.lstrip().startswith(begins) and (begins or not end.out), f"stdout: {end.out[:99]!r}"
            )
        own = [runs[name]] if name in runs else []
        expect(check(place, *own) in (own or [None]), "the set is not whole")

    for name, out, err in product(commands, *[("open", "closed", "full", "broken")] * 2):
        states = enumerate((out if out == err == "closed" else "open", out, err))
        given = {i: state for i, state in states if state != "open"}
        yield Try(name, partial(written, name, given), f"streams {given}")


def disk(choice: Choice) -> Iterator[Try]:
    def limited(own: Run, before: Sequence[str], place: Path) -> None:
        end = run(own.begin(place, *before)).check(0, 1)
        if (place / "left").exists():
            (place / "out").rmdir()
            (place / "left").rename(place / "out")
        left = check(place, own)
        expect(end.code == 0 or "out" in end.err.splitlines()[-2], f"the place is not named: {end.err!r}")
        expect(end.code == 0 or "hint: " in end.err, f"no hint: {end.err[-300:]!r}")
        expect((end.code == 0) == (left == own), f"exit code {end.code}, and the set is whole, or not")

    mounted = (*apart("-m"), "sh", "-c")
    script = (
        'mkdir out; mount -t tmpfs -o "$0" tmpfs out || exit 99; "$@"; code=$?; cp -a out left; exit $code'
    )
    for form in forms():
        own = Run(form, "drawn", 1)
        pages = sum(-(-path.stat().st_size // 4096) for path in own.calm.rglob("*") if path.is_file())
        limits = {f"size={4 * n}k": (*mounted, script) for n in range(1, pages + 3)}
        limits |= {f"nr_inodes={n}": (*mounted, script) for n in range(2, 16)}
        limits |= {f"{n}": ("sh", "-c", 'ulimit -f "$0"; "$@"') for n in range(1, 100, 10)}
        for limit in choice.chance.sample(list(limits), min(choice.tries, len(limits))):
            yield Try(form, partial(limited, own, (*limits[limit], limit)), limit)


def resume(choice: Choice) -> Iterator[Try]:
    axes = ("-A", f"0.1:3:{choice.cells // 10_000}", "-f", "5:60:10000", "--flight", "off")
    SWEEPS["resumed"] = axes, min(1_000_000, choice.cells // 20)
    own = Run("parquet", "resumed")
    began = time.perf_counter()
    expect(own.files, "there are no files")
    duration = time.perf_counter() - began

    def killed(more: tuple[str, ...], place: Path) -> None:
        kills, code = -1, 1
        while code:
            kills += 1
            begun = Run("parquet", "resumed", more=(*more, "--resume")).begin(place, "env")
            time.sleep(choice.chance.uniform(0.5, 1.0) * (1.0 + kills) * duration / 8)
            os.kill(begun.pid, choice.chance.choice((signal.SIGKILL, signal.SIGKILL, signal.SIGINT)))
            code = run(begun).check(0, 130, -signal.SIGKILL).code
        expect(check(place, own) == own, "the files differ from those of a run without a fault")
        print(f"    killed and resumed {kills} times")

    for more in ((), ("--workers", "2")):
        yield Try(" ".join([f"{choice.cells} cells", *more]), partial(killed, more))


def memory(choice: Choice) -> Iterator[Try]:
    def fits(own: Run, place: Path) -> None:
        most = run(own.begin(place, "env")).check(0).memory
        print(f"    {own.form}, 1e7 cells: {most:.0f} MB")
        expect(most < 600.0, f"{most:.0f} MB")

    for form in ("csv", "parquet"):
        yield Try(form, partial(fits, Run(form, "1e7 cells", more=("--flight", "off"))))


CLASSES: Final = {
    "steps": (steps, 1000),
    "kills": (kills, 12),
    "twins": (twins, 8),
    "ranges": (ranges, 6),
    "namespaces": (namespaces, 4),
    "places": (places, 1),
    "signals": (signals, 8),
    "streams": (streams, 1),
    "disk": (disk, 40),
    "resume": (resume, 1),
    "memory": (memory, 1),
}


def attempt(one: Try) -> int:
    """Try once, in a new folder; print how it fails, and count it."""
    failed = 0
    with tempfile.TemporaryDirectory() as place:
        try:
            one.check(Path(place))
        except (BrokenError, Skipped) as exc:
            failed = int(isinstance(exc, BrokenError))
            text = str(exc).replace("\n", " ").replace(place, "...")
            print(f"    {'failed' if failed else 'skipped'}: {one.kind} ({one.numbers}): {text}", flush=True)
        finally:
            end_all()
    return failed


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("classes", nargs="*", metavar="CLASS", help=", ".join(CLASSES))
    parser.add_argument("--tries", type=int, help="of each kind; of the class steps so many of its steps")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cells", type=float, default=1e6, help="of the class resume")
    arguments = parser.parse_args()
    unknown = set(arguments.classes) - set(CLASSES)
    if unknown:
        parser.error(f"no class {', '.join(unknown)}; there are {', '.join(CLASSES)}")

    # A shell that starts this in the background lets it, and whatever it starts, ignore some signals.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.default_int_handler)
    atexit.register(end_all)
    with tempfile.TemporaryDirectory() as root:
        tempfile.tempdir = root
        os.chdir(root)
        print(f"{'class':12}{'tries':>6}{'failures':>10}{'s':>7}", flush=True)
        failed = 0
        for name in arguments.classes or [name for name in CLASSES if name not in ("resume", "memory")]:
            tries, usual = CLASSES[name]
            chance = random.Random(f"{name} {arguments.seed}")
            choice = Choice(arguments.tries or usual, chance, round(arguments.cells))
            began, failures = time.perf_counter(), []
            try:
                for one in tries(choice):
                    failures.append(attempt(one))
            except Skipped as exc:
                print(f"    skipped: {exc}")
            seconds = time.perf_counter() - began
            print(f"{name:12}{len(failures):6}{sum(failures):10}{seconds:7.0f}", flush=True)
            failed += sum(failures)
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
