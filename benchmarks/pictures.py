"""What a map with its pictures costs beside the answer for one scene: CPU of both commands, and its budget.

Usage: python benchmarks/pictures.py [--repeats 10]

The commands take turns, each in a process of its own with warm file caches; user and system time of all its
threads count. Exits with 1 if the ratio of the medians exceeds its budget.
"""

from __future__ import annotations

import argparse
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

VIBRO: Final = (sys.executable, "-m", "vibro")
SCENE: Final = str(Path(__file__).parents[1] / "examples" / "safety_nut.toml")
BUDGET: Final = 5.5  # CPU of a map of 100 x 100 cells and three pictures, over that of one scene


def cpu_time(arguments: tuple[str, ...]) -> float:
    """User and system time of a process [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(arguments, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=10)
    repeats = parser.parse_args().repeats

    with tempfile.TemporaryDirectory() as folder:
        commands = {
            "vibro solve": (*VIBRO, "solve", SCENE),
            "vibro map": (*VIBRO, "map", SCENE, "-o", f"{folder}/nut", "--force"),
        }
        times: dict[str, list[float]] = {name: [] for name in commands}
        for number in range(1 + repeats):
            for name, arguments in commands.items():
                seconds = cpu_time(arguments)
                if number > 0:  # the first turn warms the caches
                    times[name].append(seconds)

    print(f"{'CPU [ms]':12}{'least':>8}{'median':>8}{'most':>8}")
    for name, values in times.items():
        row = (min(values), statistics.median(values), max(values))
        print(f"{name:12}" + "".join(f"{1e3 * value:8.0f}" for value in row))
    one, pictures = (statistics.median(values) for values in times.values())
    exceeded = pictures > BUDGET * one
    print(f"ratio {pictures / one:.2f}, budget {BUDGET}{'  EXCEEDED' * exceeded}")
    if exceeded:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
