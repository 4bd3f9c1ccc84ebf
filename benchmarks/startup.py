"""How long until a command answers, and which imports that time goes to: budgets, and what is spent of them.

Usage: python benchmarks/startup.py [--repeats 10]

Each command runs in a process of its own with warm file caches; the shortest time counts. The largest imports
follow, from ``python -X importtime``. Exits with 1 if a budget is exceeded.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from typing import Final, NamedTuple

VIBRO: Final = (sys.executable, "-m", "vibro")
SCENE: Final = ("-A", "1", "-f", "15", "-a", "20", "--mu-s", ".74", "--mu-d", ".57")
MAP: Final = ("map", "-A", "0.1:3:500", "-f", "5:60:500", *SCENE[4:], "--force")
MANY_IMPORTS: Final = 5  # lines


class Task(NamedTuple):
    """A command and what it may take."""

    name: str
    arguments: tuple[str, ...]
    budget: float  # [s]


TASKS: Final = (
    Task("python -c pass", (sys.executable, "-c", "pass"), 0.1),
    Task("import vibro", (sys.executable, "-c", "import vibro"), 0.1),
    Task("vibro --help", (*VIBRO, "--help"), 0.15),
    Task("vibro solve, one scene", (*VIBRO, "solve", *SCENE), 0.3),
)
PROGRESS_BUDGET: Final = 1.0  # [s] until the first line of a map's progress


def run_time(arguments: tuple[str, ...], repeats: int) -> float:
    """Shortest time of a process from start to end [s]."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        subprocess.run(arguments, check=True, capture_output=True)
        times.append(time.perf_counter() - start)
    return min(times)


def progress_time(repeats: int) -> float:
    """Shortest time from the start of a map to the first byte on its terminal [s]."""
    import pty  # no such terminal on Windows

    times = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(repeats):
            ours, theirs = pty.openpty()
            start = time.perf_counter()
            with subprocess.Popen(
                (*VIBRO, *MAP, "-o", f"{folder}/map"), stdout=subprocess.DEVNULL, stderr=theirs
            ) as process:
                os.read(ours, 1)
                times.append(time.perf_counter() - start)
                process.kill()
            os.close(theirs)
            os.close(ours)
    return min(times)


def largest_imports(arguments: tuple[str, ...]) -> list[tuple[float, str]]:
    """Time of top-level packages with all that they import [s], largest first."""
    python, *rest = arguments
    done = subprocess.run(
        (python, "-X", "importtime", *rest), check=True, capture_output=True, text=True, encoding="utf-8"
    )
    packages: dict[str, float] = {}
    for line in done.stderr.splitlines():
        own, _, name = (part.strip() for part in line.removeprefix("import time:").split("|", 2))
        if own.isdigit():
            package = name.split(".")[0]
            packages[package] = packages.get(package, 0.0) + 1e-6 * int(own)
    return sorted(((seconds, name) for name, seconds in packages.items()), reverse=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=10)
    repeats = parser.parse_args().repeats

    rows = [(task.name, run_time(task.arguments, repeats), task.budget) for task in TASKS]
    if os.name == "posix":
        rows.append(("vibro map, first sign of progress", progress_time(repeats), PROGRESS_BUDGET))
    print(f"{'':36}{'ms':>6}{'budget':>9}")
    for name, seconds, budget in rows:
        print(f"{name:36}{1e3 * seconds:6.0f}{1e3 * budget:9.0f}{'  EXCEEDED' * (seconds > budget)}")
    for task in TASKS[2:]:
        imports = largest_imports(task.arguments)[:MANY_IMPORTS]
        print(f"\n{task.name}: " + ", ".join(f"{name} {1e3 * seconds:.0f} ms" for seconds, name in imports))
    if any(seconds > budget for _, seconds, budget in rows):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
