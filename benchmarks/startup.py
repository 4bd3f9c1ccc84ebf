"""How much CPU short commands take, over that of importing NumPy, and which imports it goes to.

Usage: python benchmarks/startup.py [--rounds 15] [--before PYTHON]

Every round runs each command once, in a process of its own; of the ratios within rounds the median counts, so
that other work on the machine cancels. With ``--before`` the commands of another environment, given by its
Python, take part, and ratios to those follow. Exits with 1 if a limit is exceeded. POSIX only.
"""

from __future__ import annotations

import argparse
import os
import pty
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

SCENE: Final = ("-A", "1", "-f", "15", "-a", "20", "--mu-s", ".74", "--mu-d", ".57")
FILE: Final = str(Path(__file__).parents[1] / "examples" / "safety_nut.toml")
LARGE_MAP: Final = ("-m", "vibro", "map", "-A", "0.1:3:500", "-f", "5:60:500", *SCENE[4:])
NUMPY: Final = "import numpy"
COMMANDS: Final = {
    NUMPY: ("-c", NUMPY),
    "vibro --help": ("-m", "vibro", "--help"),
    "vibro solve -A": ("-m", "vibro", "solve", *SCENE),
    "vibro solve FILE": ("-m", "vibro", "solve", FILE),
    "vibro map FILE": ("-m", "vibro", "map", FILE, "--force"),  # 100 x 100 cells, three pictures
}
LIMITS: Final = {
    "vibro --help": 1.2,
    "vibro solve -A": 2.2,
    "vibro map FILE": 20.0,
}  # [1] over importing NumPy
FILE_LIMIT: Final = 0.07  # [s] that a file takes more
PROGRESS_LIMIT: Final = 1.0  # [s] until the first line of a map's progress
MANY_IMPORTS: Final = 5  # packages


def children_time() -> float:
    """CPU time of all processes that were started and have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def cpu_time(python: str, arguments: tuple[str, ...], folder: str) -> float:
    """CPU time of a process from start to end, with as many threads of BLAS as a user would have [s]."""
    environment = {k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")}
    before = children_time()
    subprocess.run((python, *arguments), check=True, capture_output=True, env=environment, cwd=folder)
    return children_time() - before


def progress_time() -> float:
    """CPU time from the start of a map to the first byte on its terminal [s]."""
    ours, theirs = pty.openpty()
    before = children_time()
    with (
        tempfile.TemporaryDirectory() as folder,
        subprocess.Popen(
            (sys.executable, *LARGE_MAP), cwd=folder, stdout=subprocess.DEVNULL, stderr=theirs
        ) as process,
    ):  # fmt: skip
        os.read(ours, 1)
        process.kill()
    os.close(theirs)
    os.close(ours)
    return children_time() - before


def largest_imports(arguments: tuple[str, ...]) -> list[tuple[float, str]]:
    """Time of top-level packages with all that they import [s], largest first."""
    done = subprocess.run(
        (sys.executable, "-X", "importtime", *arguments),
        check=True, capture_output=True, text=True, encoding="utf-8",
    )  # fmt: skip
    packages: dict[str, float] = {}
    for line in done.stderr.splitlines():
        own, _, name = (part.strip() for part in line.removeprefix("import time:").split("|", 2))
        if own.isdigit():
            package = name.split(".")[0]
            packages[package] = packages.get(package, 0.0) + 1e-6 * int(own)
    return sorted(((seconds, name) for name, seconds in packages.items()), reverse=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--before", metavar="PYTHON")
    given = parser.parse_args()
    pythons = [sys.executable, *filter(None, [given.before])]
    taken: dict[tuple[str, str], list[float]] = {(p, name): [] for name in COMMANDS for p in pythons}
    with tempfile.TemporaryDirectory() as folder:
        for number in range(given.rounds + 1):
            for (python, name), times in taken.items():
                spent = cpu_time(python, COMMANDS[name], folder)
                times += [spent] * (number > 0)  # the first round warms the caches

    def middle(name: str, python: str, other: str) -> float:
        return statistics.median(
            x / y for x, y in zip(taken[sys.executable, name], taken[python, other], strict=True)
        )

    exceeded = False
    print(f"{'':20}{'CPU [ms]':>9}{'/ numpy':>9}{'limit':>7}{'/ before':>10}")
    for name in COMMANDS:
        ratio, limit = middle(name, sys.executable, NUMPY), LIMITS.get(name)
        exceeded |= limit is not None and ratio > limit
        before = f"{middle(name, given.before, name):10.2f}" if given.before else ""
        spent = 1e3 * statistics.median(taken[sys.executable, name])
        print(f"{name:20}{spent:9.0f}{ratio:9.2f}{limit or '':>7}{before}")
    scene, file = (taken[sys.executable, name] for name in ("vibro solve -A", "vibro solve FILE"))
    more, first = statistics.median(y - x for x, y in zip(scene, file, strict=True)), progress_time()
    exceeded |= more > FILE_LIMIT or first > PROGRESS_LIMIT
    print(f"a file takes {1e3 * more:.0f} ms more; limit {1e3 * FILE_LIMIT:.0f}")
    print(f"vibro map, first sign of progress: {1e3 * first:.0f} ms; limit {1e3 * PROGRESS_LIMIT:.0f}")
    for name in ("vibro --help", "vibro solve -A"):
        imports = largest_imports(COMMANDS[name])[:MANY_IMPORTS]
        print(f"{name}: " + ", ".join(f"{package} {1e3 * seconds:.0f} ms" for seconds, package in imports))
    if exceeded:
        raise SystemExit("a limit is exceeded")


if __name__ == "__main__":
    main()
