"""Is anything lost or mixed up? Runs that meet each other, are killed or interrupted, or cannot write.

Usage: python benchmarks/faults.py [CLASS ...] [--tries N] [--seed 1] [--processes 1] [--cells 100000000]

Prints how many tries of each class fail, and how; exits with 1 if one does. Without a class all run but
``memory``, which takes minutes and 2 GB of disk. Needs Linux; what a system lacks is skipped by name.

namespaces  runs that are process 1 both write different stems into one folder; one comes beside a long one
writers     2 and 8 runs at one stem at once, without and with --force
kills       SIGKILL at random moments, at up to 1e6 cells; then the next run
steps       a fault between any two steps of publishing (fault_runs.py); then the next run
signals     SIGINT, SIGTERM, SIGHUP in the first second, once to three times
streams     closed, full and broken stdout and stderr
disk        a disk that fills up, and a limit on the size of files
memory      1e7 cells to a file, and as many as --cells says to stdout
"""

from __future__ import annotations

import argparse
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from fault_runs import (
    FAULTS,
    PATIENCE,
    STEM,
    VIBRO,
    BrokenError,
    Choice,
    Run,
    Skipped,
    Try,
    check_nothing,
    check_set,
    check_unmixed,
    ended,
    expect,
    faulty,
    names_in,
    published,
    run,
    started,
)
from fault_surroundings import disk, memory, signals, streams

import vibro

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

OLD: Final = Run("plane", 0)
NEXT: Final = Run("table", 999)
_PUBLISHING: Final = 0.0005  # [s] in which files are put in place
_SHOWN: Final = 25  # kinds of failures of a class
_ALIKE: Final = 70  # characters that failures of a kind share, numbers apart
_WIDTH: Final = 300  # characters of a failure


def write(folder: Path, own: Run, *, force: bool = False) -> None:
    """Write a set, undisturbed."""
    run([*VIBRO, *own.arguments(folder, force=force)]).check(0)


def check_next(folder: Path) -> None:
    """Expect that the next run at the stem works, and sweeps what is left of all before."""
    found = names_in(folder)
    if f"{STEM}.csv" in found and f"{STEM}.json" not in found:
        stopped = run([*VIBRO, *NEXT.arguments(folder)])
        stopped.check(1)
        said = f"no {STEM}.json" in stopped.err or "incomplete" in stopped.err
        expect(said, f"an incomplete set is not called so: {stopped.err!r}")
    write(folder, NEXT, force=True)
    check_set(folder, (NEXT, STEM))


def check_beside(folder: Path) -> None:
    """Expect that a run at another stem works, sweeps what is left, and leaves the set alone."""
    before = published(folder)
    run([*VIBRO, *NEXT.arguments(folder, "other")]).check(0)
    after = names_in(folder) - NEXT.files("other")
    expect(published(folder) == before, f"a run at another stem changes {sorted(before)}")
    expect(after == set(before), f"a run at another stem leaves {sorted(after)}")


def namespaces(choice: Choice) -> Iterator[Try]:
    def at_once(place: Path) -> None:
        runs = [(Run("line", i), f"stem{i}") for i in range(2)]
        command = [*_namespaced(), *VIBRO]
        with started(*([*command, *own.arguments(place / "out", stem)] for own, stem in runs)) as both:
            for end in [ended(process) for process in both]:
                end.check(0)
        check_set(place / "out", *runs)

    def comes_and_goes(place: Path) -> None:
        folder = place / "out"
        long, short = (Run("large", 1), "long"), (Run("table", 2), "short")
        command = [*_namespaced(), *VIBRO]
        with started([*command, *long[0].arguments(folder, long[1])]) as (process,):
            deadline = time.monotonic() + PATIENCE
            while not _has_rows(folder):
                expect(time.monotonic() < deadline and process.poll() is None, "it never writes")
                time.sleep(0.005)
            run([*command, *short[0].arguments(folder, short[1])]).check(0)
            expect(process.poll() is None, "the long run was too short to be met")
            ended(process).check(0)
        check_set(folder, long, short)

    for _ in range(choice.tries):
        yield Try("at once", at_once)
        yield Try("beside a long run", comes_and_goes)


def _has_rows(folder: Path) -> bool:
    """Whether something has been written to a file below a folder, by whatever name."""
    for place, _, names in os.walk(folder):
        with suppress(FileNotFoundError):
            if any(Path(place, name).stat().st_size > 1000 for name in names):
                return True
    return False


@cache
def _namespaced() -> list[str]:
    """Return the command that starts another as process 1 of a namespace."""
    for user in ([], ["-U", "-r"]):
        command = ["unshare", *user, "-p", "-f", "--mount-proc", "--kill-child"]
        if (
            shutil.which("unshare")
            and run([*command, sys.executable, "-c", "import os; print(os.getpid())"]).out == "1\n"
        ):
            return command
    raise Skipped("no namespaces of processes (unshare -p)")


def writers(choice: Choice) -> Iterator[Try]:
    for number in (2, 8):
        for force in (False, True):

            def command(own: Run, folder: Path, force: bool = force) -> list[str]:
                return [*VIBRO, *own.arguments(folder, force=force)]

            check = partial(_meet, command, number, force)
            yield from [Try(f"{number} at once" + ", --force" * force, check)] * choice.tries


def _meet(command: Callable[[Run, Path], Sequence[str]], number: int, force: bool, place: Path) -> None:
    """Let runs write to one stem at once."""
    folder = place / "out"
    runs = [Run("line", i) for i in range(number)]
    with started(*(command(own, folder) for own in runs)) as processes:
        ends = [ended(process) for process in processes]
    for end in ends:
        end.check(0, 1)
    winners = [own for own, end in zip(runs, ends, strict=True) if end.code == 0]
    expect(bool(winners), "no run succeeds")
    expect(force or len(winners) == 1, f"{len(winners)} of {number} runs succeed")
    last = check_unmixed(folder, winners)
    if last is None:
        raise BrokenError("no JSON")
    check_set(folder, (last, STEM))


def kills(choice: Choice) -> Iterator[Try]:
    old = choice.place / "old"
    write(old, OLD)
    durations = {}
    for kind in ("line", "plane", "large"):
        start = time.perf_counter()
        write(choice.place / kind, Run(kind, 1))
        durations[kind] = time.perf_counter() - start

    def killed(kind: str, force: bool, share: float, follow: Callable[[Path], None], place: Path) -> None:
        folder, own = place / "out", Run(kind, 1)
        if force:
            shutil.copytree(old, folder)
        with started([*VIBRO, *own.arguments(folder, force=force)]) as (process,):
            if share < 1.0:
                time.sleep(share * durations[kind])
            else:
                _wait_for_change(folder, process)
                time.sleep((share - 1.0) * _PUBLISHING)
            process.kill()
            end = ended(process)
        end.check(0, -signal.SIGKILL)
        left = check_unmixed(folder, [own, OLD] if force else [own])
        if end.code == 0:
            check_set(folder, (own, STEM))
        elif force and share < 0.3:
            expect(left == OLD, "the older set is gone long before the new one is there")
        follow(folder)

    for i in range(choice.tries):
        kind = ("large", "line", "line", "plane", "line", "line", "line", "plane")[i // 2 % 8]
        force = bool(i // 16 % 2)
        # Files are put in place in a moment at the end: half of the kills falls there.
        share = choice.chance.random() + i % 2
        follow = (check_next, check_beside)[i // 32 % 2]
        check = partial(killed, kind, force, share, follow)
        yield Try(kind + ", --force" * force, check, f"at {share:.3f}")


def _wait_for_change(folder: Path, process: subprocess.Popen[str]) -> None:
    """Wait until a run puts files in place, or has ended."""
    before = published(folder)
    while process.poll() is None and published(folder) == before:
        time.sleep(0.0001)


def steps(choice: Choice) -> Iterator[Try]:
    old = choice.place / "old"
    write(old, OLD)

    def disturbed(fault: str, number: int, own: Run, force: bool, place: Path) -> None:
        folder, report = place / "out", place / "report"
        if force:
            shutil.copytree(old, folder)
        end = run(faulty(fault, number, folder, report, own.arguments(folder, force=force)))
        reached = report.read_text().split()
        expect(len(reached) >= number, f"only {len(reached)} steps")
        codes = {"SIGKILL": (-signal.SIGKILL,), "SIGINT": (0, 130)}.get(fault.split()[0], (0, 1))
        try:
            end.check(*codes)
            left = check_unmixed(folder, [own, OLD] if force else [own])
            expect(end.code != 0 or left == own, "exit code 0 without the set")
            if fault not in ("SIGKILL", "EIO always"):
                if end.code == 0:
                    check_set(folder, (own, STEM))
                elif force:
                    check_set(folder, (OLD, STEM))
                else:
                    check_nothing(folder)
            check_next(folder)
        except BrokenError as exc:
            raise BrokenError(f"({reached[number - 1]}) exit code {end.code}, {exc}") from None

    for own, force in ((Run("line", 1), False), (Run("table", 1), True)):
        folder, report = choice.place / own.kind, choice.place / "report"
        if force:
            shutil.copytree(old, folder)
        run(faulty("none", 0, folder, report, own.arguments(folder, force=force))).check(0)
        number = len(report.read_text().split())
        if number < len(own.files()):
            raise BrokenError(f"only {number} steps: fault_runs.py misses how files are published")
        for fault in FAULTS:
            for i in range(1, number + 1):
                check = partial(disturbed, fault, i, own, force)
                yield Try(fault + ", --force" * force, check, f"step {i} of {number}")
    yield from _without_links()


def _without_links() -> Iterator[Try]:
    def alone(error: str, place: Path) -> None:
        folder = place / "out"
        first, second = Run("line", 1), Run("table", 2)
        for own, force, code, left in (
            (first, False, 0, first),
            (second, False, 1, first),
            (second, True, 0, second),
        ):
            arguments = own.arguments(folder, force=force)
            run(faulty(f"links {error}", 0, folder, place / "report", arguments)).check(code)
            check_set(folder, (left, STEM))

    def command(own: Run, folder: Path) -> list[str]:
        report = folder.parent / f"report{own.number}"
        return faulty("links EPERM", 0, folder, report, own.arguments(folder))

    yield from (Try(f"no links ({error})", partial(alone, error)) for error in ("EPERM", "ENOTSUP"))
    yield from [Try("no links, 8 at once", partial(_meet, command, 8, False))] * 6


CLASSES: Final = {
    "namespaces": (namespaces, 12),
    "writers": (writers, 8),
    "kills": (kills, 200),
    "steps": (steps, 1),
    "signals": (signals, 40),
    "streams": (streams, 1),
    "disk": (disk, 1),
    "memory": (memory, 1),
}


class Failure(NamedTuple):
    """A try that failed, or that was skipped."""

    one: Try
    skipped: bool
    text: str

    def alike(self) -> tuple[str, str]:
        """Return what failures of a kind share."""
        return self.one.kind, re.sub(r"[\d.]+", "", self.text)[:_ALIKE]


def prepare(tries: Callable[[Choice], Iterator[Try]], choice: Choice) -> list[Try]:
    """Return the tries of a class, or one that fails if what they need cannot be made."""
    try:
        return list(tries(choice))
    except BrokenError as exc:
        error = exc

    def fail(place: Path) -> None:
        raise error

    return [Try("undisturbed, beforehand", fail)]


def attempt(one: Try, place: Path) -> Failure | None:
    """Try once, in a new folder."""
    with tempfile.TemporaryDirectory(dir=place) as folder:
        try:
            one.check(Path(folder))
        except (BrokenError, Skipped) as exc:
            text = str(exc).replace("\n", " ").replace(folder, "...")[:_WIDTH]
            return Failure(one, isinstance(exc, Skipped), text)
    return None


def report(name: str, number: int, failures: Sequence[Failure], seconds: float) -> bool:
    """Print the line of a class, and a line for the first failure of each kind; return whether any failed."""
    skipped = sum(f.skipped for f in failures)
    failed = len(failures) - skipped
    print(f"{name:12}{number - skipped:6}{failed:10}{seconds:6.0f}")
    kinds: dict[tuple[str, str], list[Failure]] = {}
    for failure in failures:
        kinds.setdefault(failure.alike(), []).append(failure)
    for (kind, _), alike in list(kinds.items())[:_SHOWN]:
        what = "skipped" if alike[0].skipped else "failed"
        print(f"    {len(alike)} {what}: {kind} {alike[0].one.numbers}: {alike[0].text}")
    sys.stdout.flush()
    return failed > 0


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("classes", nargs="*", metavar="CLASS", help=", ".join(CLASSES))
    parser.add_argument("--tries", type=int, help="of each kind, where they are drawn at random")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=1, help="tries at a time")
    parser.add_argument("--cells", type=int, default=100_000_000, help="to stdout, in the class memory")
    arguments = parser.parse_args()
    wanted = arguments.classes or [name for name in CLASSES if name != "memory"]
    unknown = set(wanted) - set(CLASSES)
    if unknown:
        parser.error(f"no class {', '.join(unknown)}; there are {', '.join(CLASSES)}")

    # A shell that starts this in the background lets it, and whatever it starts, ignore some signals.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.default_int_handler)  # children are ended, and folders removed
    os.environ["PYTHONPATH"] = str(Path(vibro.__file__).parents[1])
    failed = False
    print(f"{'class':12}{'tries':>6}{'failures':>10}{'s':>6}", flush=True)
    with tempfile.TemporaryDirectory() as root:
        os.environ["MPLCONFIGDIR"] = f"{root}/matplotlib"  # fonts are listed once, by the first run
        run([*VIBRO, *OLD.arguments(Path(root) / "first")])
        for name in wanted:
            tries, usual = CLASSES[name]
            start = time.perf_counter()
            with (
                tempfile.TemporaryDirectory(dir=root) as folder,
                ThreadPoolExecutor(arguments.processes) as pool,
            ):
                place = Path(folder)
                chance = random.Random(f"{name} {arguments.seed}")
                choice = Choice(arguments.tries or usual, chance, arguments.cells, place)
                made = prepare(tries, choice)
                ends = list(pool.map(partial(attempt, place=place), made))
            seconds = time.perf_counter() - start
            failed |= report(name, len(ends), [end for end in ends if end], seconds)
    if failed:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
