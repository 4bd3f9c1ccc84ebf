"""Measure what it costs to write a sweep, and to read it, beside solving it.

Usage: python benchmarks/sweeps.py [--cells 1e7] [--repeats 3] [--flight] [--in FOLDER]

The grid is that of examples/wide_sweep.toml, with as many amplitudes as make the cells; bodies are followed
through flight with --flight alone. Each way to write it runs in a process of its own, in turn with
``vibro.solve`` of the same cells on as many cores; one file of CSV has a tenth of the cells. "CPU ratio" is
the CPU time of all processes divided by that of solving, the start of workers left out. Times are the least
of the repeats. What is read is a tenth of the cells, too; those times are divided by that of
``pandas.read_parquet``.

Linux alone.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from vibro.axes import parse_axis
from vibro.files.csv_tables import CsvFormat
from vibro.quantities import DEFAULTS, QUANTITIES
from vibro.sweeps.columns import Table, columns_of
from vibro.sweeps.grid import Grid
from vibro.tables.plan import Plan
from vibro.tables.sinks import csv_sink, write_table
from vibro.tables.stored import open_sweep
from vibro.tables.writing import write_folder
from vibro.threads import cores

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

LENGTH: Final = 600.0  # [mm] of the trough
AXES: Final = {
    "frequency": "12:50:20",
    "drive_angle": "6:44:20",
    "static_friction": "0.2:0.98:40",
    "friction_ratio": "0.5:0.98:25",
}
FEW: Final = {**AXES, "static_friction": "0.7", "friction_ratio": "0.8"}
AN_AMPLITUDE: Final = 400_000  # [cells]
AT_ONCE: Final = 5  # amplitudes that ``vibro.solve`` gets at once
A_TENTH: Final = 0.1  # of the cells
WAYS: Final = {"CSV": cores(), "threads": cores(), "2 processes": 2, "Dask, 2 workers": 2}  # and their cores
# Of Dask's workers, as docs/guide/scale.md advises.
RETAINING: Final = {"MALLOC_MMAP_THRESHOLD_": f"{32 << 20}", "MALLOC_TRIM_THRESHOLD_": f"{64 << 20}"}
MEGA: Final = 1e6


def grid_of(cells: float, flight: bool = False, axes: dict[str, str] = AXES) -> Grid:
    """Return the grid of the example, with so many cells."""
    number = max(1, round(cells / AN_AMPLITUDE))
    texts = {"amplitude": f"0.06:1.5:{number}" if number > 1 else "1", **axes}
    known = {name: parse_axis(text, QUANTITIES[name]).axis(0) for name, text in texts.items()}
    fixed = {name: value for name, value in DEFAULTS.items() if name not in known}
    return Grid(known, fixed, LENGTH, flight=flight)


def table_of(grid: Grid) -> Table:
    return Table(columns_of(grid.axes, made_with=grid.made_with))


def plan_of(grid: Grid, shard_cells: int | None = None) -> Plan:
    return Plan.of(grid, table_of(grid), "wide_sweep", {}, shard_cells)


# Times and memory of a process and those that it starts.


def children(pid: int | str = "self") -> list[int]:
    """Return the processes below one."""
    found = []
    for path in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in path.read_text().split():
            found += [int(child), *children(child)]
    return found


def core_seconds() -> float:
    """Time of all cores that this process has had, and those below it, whether they have ended or not."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    ticks = 0
    for pid in children():
        ticks += sum(map(int, Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11:13]))
    return time.process_time() + ended.ru_utime + ended.ru_stime + ticks / os.sysconf("SC_CLK_TCK")


def peak_memory(pid: int | str = "self") -> float:
    """Most memory that a process has had [MB]."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next((int(line.split()[1]) * 1024 / MEGA for line in lines if line.startswith("VmHWM")), 0.0)


def timed(run: Callable[[], Any]) -> tuple[float, float, Any]:
    """Return how long something takes, how much of the cores' time, and what it returns."""
    start, start_cores = time.perf_counter(), core_seconds()
    result = run()
    return time.perf_counter() - start, core_seconds() - start_cores, result


# Writing.


@contextmanager
def workers_of(way: str) -> Iterator[int | str | None]:
    """Give what ``--workers`` would say."""
    if not way.startswith("Dask"):
        yield 2 if way == "2 processes" else None
        return
    from distributed import LocalCluster

    os.environ.update(RETAINING)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        yield cluster.scheduler_address


def write(way: str, grid: Grid, place: Path, workers: int | str | None, shard_cells: int | None) -> int:
    """Write a sweep; return its size [B]."""
    if way == "CSV":
        path, table = place / "sweep.csv", table_of(grid)
        with path.open("wb") as file:
            write_table(grid, table, [csv_sink(file, table, CsvFormat())])
        return path.stat().st_size
    return write_folder(place / "sweep", plan_of(grid, shard_cells), workers, [], force=True).size


def solve_alone(grid: Grid, threads: int) -> None:
    rest = (slice(None),) * (len(grid.axes) - 1)
    for i in range(0, grid.shape[0], AT_ONCE):
        grid.solve(grid.values((slice(i, i + AT_ONCE), *rest)), threads)


def run_way(way: str, cells: float, repeats: int, flight: bool, place: Path) -> dict[str, Any]:
    """Measure one way to write a sweep."""
    grid, small = grid_of(cells, flight), grid_of(1, flight, FEW)
    with workers_of(way) as workers:
        start = [timed(lambda: write(way, small, place, workers, 200)) for _ in range(2)][1]
        runs: list[Any] = []
        alone: list[Any] = []
        for _ in range(repeats):
            runs.append(timed(lambda: write(way, grid, place, workers, None)))
            if not alone:
                memory = peak_memory()
            alone.append(timed(lambda: solve_alone(grid, WAYS[way])))
    # of the processes that have ended, whichever of them had most
    of_workers = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024 / MEGA
    return {
        "cells": grid.size,
        "seconds": min(run[0] for run in runs) - start[0],
        "core_seconds": min(run[1] for run in runs) - start[1],
        "alone": min(run[1] for run in alone),
        "size": runs[0][2] / grid.size,
        "memory": [memory, of_workers],
    }


def compare_ways(cells: float, repeats: int, flight: bool, place: Path) -> None:
    print(f"{'flight followed' if flight else 'in contact'}, {cores()} cores")
    print(
        f"{'written':16}  {'cells':>9}  {'s':>7}  {'CPU s':>7}  {'CPU s, solving':>14}  {'CPU ratio':>9}"
        f"  {'bytes a cell':>12}  {'MB':>5}  {'MB, worker':>10}"
    )
    for way in WAYS:
        if way.startswith("Dask") and importlib.util.find_spec("distributed") is None:
            print(f"{way:16}  skipped: there is no distributed")
            continue
        number = cells * A_TENTH if way == "CSV" else cells
        words = ["--way", way, "--cells", f"{number}", "--repeats", f"{repeats}", "--in", f"{place}"]
        found = json.loads(own_process(*words, *["--flight"][: int(flight)]))
        memory, of_workers = found["memory"]
        print(
            f"{way:16}  {found['cells']:9.3g}  {found['seconds']:7.2f}  {found['core_seconds']:7.2f}"
            f"  {found['alone']:14.2f}  {found['core_seconds'] / found['alone']:9.2f}  {found['size']:12.2f}"
            f"  {memory:5.0f}  {f'{of_workers:10.0f}' if of_workers else '         -'}",
            flush=True,
        )


def own_process(*words: str) -> str:
    command = [sys.executable, __file__, *words]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


# Reading.


def compare_readers(cells: float, repeats: int, flight: bool, place: Path) -> None:
    import pandas as pd

    folder = place / "read"
    grid = grid_of(cells * A_TENTH, flight)
    write_folder(folder, plan_of(grid), None, [])
    stored = open_sweep(folder)
    readers: dict[str, Callable[[], Any]] = {
        "pandas.read_parquet": lambda: pd.read_parquet(folder),
        "to_frame": stored.to_frame,
        "to_xarray": stored.to_xarray,
        "one column of to_frame": lambda: stored.to_frame(columns=["regime"]),
    }
    if not all(importlib.util.find_spec(name) for name in ("xarray", "h5netcdf")):
        del readers["to_xarray"]
    spent = best_of(repeats, readers, time.process_time)
    print(f"\n{f'read, {grid.size:.3g} cells':24}  {'CPU s':>6}  ratio")
    for name, seconds in spent.items():
        print(f"{name:24}  {seconds:6.2f}  {seconds / spent['pandas.read_parquet']:5.2f}")
    shutil.rmtree(folder)


def best_of(
    repeats: int, runs: dict[str, Callable[[], Any]], clock: Callable[[], float] = time.thread_time
) -> dict[str, float]:
    """Return the least time of this thread, or of another clock, for each, all of them in turn."""
    best = dict.fromkeys(runs, math.inf)
    for _ in range(repeats):
        for name, run in runs.items():
            start = clock()
            run()
            best[name] = min(best[name], clock() - start)
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=float, default=1e7)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--flight", action="store_true", help="follow bodies through flight")
    parser.add_argument("--in", dest="place", type=Path, help="where there is room; a folder of the system")
    parser.add_argument("--way", choices=WAYS, help="measure one in this process, and print JSON")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=arguments.place) as name:
        measured = arguments.cells, arguments.repeats, arguments.flight, Path(name)
        if arguments.way:
            print(json.dumps(run_way(arguments.way, *measured)))
        else:
            compare_ways(*measured)
            compare_readers(*measured)


if __name__ == "__main__":
    main()
