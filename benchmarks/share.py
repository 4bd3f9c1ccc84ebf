"""How much of a sweep to file is the solver, and how much the CSV? What faster ones gain end to end.

Usage: python benchmarks/share.py [--side 1000] [--contact]

Runs ``vibro map`` over amplitude and frequency, pictures and all, and takes the time in ``Grid.solve`` and
``CsvFormat.rows``.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any
from unittest.mock import patch

from typer.testing import CliRunner

from vibro.cli.app import app
from vibro.files import csv_tables
from vibro.sweeps.grid import Grid

WARM_UP = 300  # values of each axis of a first map, that pays for the imports
COLUMNS = "amplitude_mm,frequency_hz,regime,mean_velocity_mm_s"
MAPS = {
    "in contact": ("-A", "0.1:1", "-f", "5:25"),
    "62 % hopping": ("-A", "0.1:3", "-f", "5:60"),
    "the same, few columns": ("-A", "0.1:3", "-f", "5:60", "--columns", COLUMNS),
}


def measure(axes: tuple[str, ...], side: int, folder: str) -> tuple[float, float, float, float]:
    """Wall time of a map, of the solver in it, and of the rows of its CSV [s]; size of the CSV [MB]."""
    spent = {"solve": 0.0, "rows": 0.0}

    def timed(name: str, call: Any) -> Any:
        def run(*args: Any, **kwargs: Any) -> Any:
            start = time.perf_counter()
            try:
                return call(*args, **kwargs)
            finally:
                spent[name] += time.perf_counter() - start

        return run

    sized = [f"{a}:{side}" if ":" in a else a for a in axes]
    command = ["map", *sized, "-a", "20", "--mu-s", ".74", "--mu-d", ".57", "-o", f"{folder}/map", "--force"]
    with (
        patch.object(Grid, "solve", timed("solve", Grid.solve)),
        patch.object(csv_tables.CsvFormat, "rows", timed("rows", csv_tables.CsvFormat.rows)),
    ):
        start = time.perf_counter()
        result = CliRunner().invoke(app, command)
        total = time.perf_counter() - start
    if result.exit_code:
        raise SystemExit(result.stderr)
    return total, spent["solve"], spent["rows"], (Path(folder) / "map.csv").stat().st_size / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=1000, help="values of each axis")
    parser.add_argument("--contact", action="store_true", help="only the map in contact, the fastest way")
    arguments = parser.parse_args()
    side, maps = arguments.side, list(MAPS.items())
    if arguments.contact:
        maps = maps[:1]
    print(f"{f'map of {side} x {side}':30}  total [s]  CSV [s]  CSV [MB]  solver [s]  share  gain at most")
    with tempfile.TemporaryDirectory() as folder:
        for name, axes in maps:
            measure(axes, WARM_UP, folder)
            total, solver, rows, size = measure(axes, side, folder)
            share, gain = solver / total, total / (total - solver)
            csv = f"{rows:7.2f}  {size:8.1f}"
            print(f"{name:30}  {total:9.2f}  {csv}  {solver:10.2f}  {share:5.1%}  {gain:10.2f} x")


if __name__ == "__main__":
    main()
