"""How much of a sweep to file is the solver? What a faster one could gain end to end.

Usage: python benchmarks/share.py [--side 1000]

Runs ``vibro map`` over amplitude and frequency, pictures and all, and takes the time inside ``solve``.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from typing import Any
from unittest.mock import patch

from typer.testing import CliRunner

from vibro import sweep
from vibro.cli.app import app

MAPS = {
    "in contact, hopping left out": ("-A", "0.1:3", "-f", "5:60", "--flight", "off"),
    "62 % hopping": ("-A", "0.1:3", "-f", "5:60"),
}


def measure(arguments: tuple[str, ...], side: int, folder: str) -> tuple[float, float]:
    """Wall time of a map, and of the solver in it [s]."""
    spent = 0.0
    solve = sweep.solve

    def timed(*args: Any, **kwargs: Any) -> Any:
        nonlocal spent
        start = time.perf_counter()
        try:
            return solve(*args, **kwargs)
        finally:
            spent += time.perf_counter() - start

    sized = [f"{a}:{side}" if ":" in a else a for a in arguments]
    command = ["map", *sized, "-a", "20", "--mu-s", ".74", "--mu-d", ".57", "-o", f"{folder}/map", "--force"]
    with patch.object(sweep, "solve", timed):
        start = time.perf_counter()
        result = CliRunner().invoke(app, command)
        total = time.perf_counter() - start
    if result.exit_code:
        raise SystemExit(result.stderr)
    return total, spent


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=1000, help="values of each axis")
    side = parser.parse_args().side
    print(f"{'map of ' + str(side) + ' x ' + str(side):32}  total [s]  solver [s]  share  gain at most")
    with tempfile.TemporaryDirectory() as folder:
        for name, arguments in MAPS.items():
            total, spent = measure(arguments, side, folder)
            gain = total / (total - spent)
            print(f"{name:32}  {total:9.2f}  {spent:10.2f}  {spent / total:5.1%}  {gain:10.2f} x")


if __name__ == "__main__":
    main()
