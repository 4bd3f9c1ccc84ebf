"""Who makes a sweep in shards in which time and memory, and does it survive? The ways to do so, side by side.

Usage: python benchmarks/sweeps.py [--cells 1e7] [--repeats 3] [--flight] [--in FOLDER]
       python benchmarks/sweeps.py --faults | --encodings

The grid is that of examples/wide_sweep.toml, with as many amplitudes as make the cells; bodies are followed
through flight with --flight alone. Each way to make the shards runs in a process of its own, in turn with
``vibro.solve`` of the same cells on as many cores: ratios are of times within one run. Workers are started,
and have imported what they need, before the time begins. Times are the least of the repeats. "Of core time"
is the ratio of what processes had of the cores, which others on the machine disturb less.

With --faults a worker is killed in the middle of a run, then the process that started the workers, and the
run is resumed. With --encodings ways to write a shard, and to solve its cells, are compared. Linux alone.
"""

from __future__ import annotations

import argparse
import importlib.util
import io
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import wait
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final
from unittest.mock import patch

from vibro.axes import parse_axis
from vibro.output.plan import ROW_GROUP, Plan
from vibro.output.workers import Cluster, Processes, Threads, Workers
from vibro.parallel import cores
from vibro.quantities import DEFAULTS, QUANTITIES
from vibro.sweeps.columns import Table, columns_of
from vibro.sweeps.grid import Grid

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from vibro.output.shards import Summary

EXAMPLE: Final = Path(__file__).parent.parent / "examples" / "wide_sweep.toml"
LENGTH: Final = 600.0  # [mm] of the trough
AXES: Final = {
    "frequency": "12:50:20",
    "drive_angle": "6:44:20",
    "static_friction": "0.2:0.98:40",
    "friction_ratio": "0.5:0.98:25",
}
AN_AMPLITUDE: Final = 400_000  # [cells]
AT_ONCE: Final = 5  # amplitudes that ``vibro.solve`` gets at once
WAYS: Final = {
    "one thread": 1,
    "threads": cores(),
    "2 processes": 2,
    "Dask, 2 workers": 2,
}  # cores that each has
# Of Dask's workers, as docs/guide/scale.md advises; vibro's own processes have these settings anyway.
RETAINING: Final = {"MALLOC_MMAP_THRESHOLD_": f"{32 << 20}", "MALLOC_TRIM_THRESHOLD_": f"{64 << 20}"}
SHARD_CELLS: Final = 1_000_000
TASKS: Final = 300  # that do nothing, to see what one costs
MEGA: Final = 1e6
FAULT_SHARDS: Final = 3  # after which a fault happens


def grid_of(cells: float, flight: bool = False, axes: dict[str, str] = AXES) -> Grid:
    """Return the grid of the example, with so many cells."""
    number = max(1, round(cells / AN_AMPLITUDE))
    texts = {"amplitude": f"0.06:1.5:{number}" if number > 1 else "1", **axes}
    known = {name: parse_axis(text, QUANTITIES[name]).axis(0) for name, text in texts.items()}
    fixed = {name: value for name, value in DEFAULTS.items() if name not in known}
    return Grid(known, fixed, LENGTH, flight=flight)


def plan_of(grid: Grid, shard_cells: int = SHARD_CELLS) -> Plan:
    table = Table(columns_of(grid.axes, made_with=grid.made_with))
    return Plan.of(grid, table, shard_cells, "wide_sweep", {})


# Times and memory of a process and those that it starts.


def children(pid: int | str = "self") -> list[int]:
    """Return the processes below one."""
    found = []
    for path in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in path.read_text().split():
            found += [int(child), *children(child)]
    return found


def core_seconds() -> float:
    """Time of all cores that this process and those below it have had."""
    ticks = 0
    for pid in children():
        ticks += sum(map(int, Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11:13]))
    return time.process_time() + ticks / os.sysconf("SC_CLK_TCK")


def peak_memory(pid: int | str = "self") -> float:
    """Most memory that a process has had [MB]."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next((int(line.split()[1]) * 1024 / MEGA for line in lines if line.startswith("VmHWM")), 0.0)


def timed(run: Callable[[], Any]) -> tuple[float, float, Any]:
    """Return how long something takes, how much of the cores' time, and what it returns."""
    start, start_cores = time.perf_counter(), core_seconds()
    result = run()
    return time.perf_counter() - start, core_seconds() - start_cores, result


# The ways.


@contextmanager
def workers_of(way: str) -> Iterator[Workers]:
    """Give those who make shards, at work."""
    with ExitStack() as stack:
        workers: Workers
        if way == "2 processes":
            workers = Processes(2)
        elif way == "Dask, 2 workers":
            from distributed import LocalCluster

            os.environ.update(RETAINING)
            cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0")
            workers = Cluster(stack.enter_context(cluster).scheduler_address)
        else:
            workers = Threads(WAYS[way])
            workers.number, workers.threads = WAYS[way], 1
        yield stack.enter_context(workers)


def make(plan: Plan, folder: Path, workers: Workers) -> Summary:
    from vibro.output.shard_folder import MANIFEST, ShardFolder
    from vibro.output.shards import make_shards

    with ShardFolder(folder, "") as files:
        files.write(MANIFEST, plan.manifest([]))
        summary = make_shards(plan, files, workers, range(plan.shards))
        summary.finish(files, plan.manifest([]))
    return summary


def solve_alone(grid: Grid, threads: int) -> None:
    rest = (slice(None),) * (len(grid.axes) - 1)
    for i in range(0, grid.shape[0], AT_ONCE):
        grid.solve(grid.values((slice(i, i + AT_ONCE), *rest)), threads)


def run_way(way: str, cells: float, repeats: int, flight: bool, place: Path) -> dict[str, Any]:
    """Measure one way to make the shards."""
    grid = grid_of(cells, flight)
    plan = plan_of(grid)
    folder = place / "sweep"
    with workers_of(way) as workers:
        wait([workers.submit(time.sleep, 1.0) for _ in range(workers.number)])
        make(plan_of(grid_of(AN_AMPLITUDE), 10_000), place / "warm", workers)
        tasks = timed(lambda: wait([workers.submit(int) for _ in range(TASKS)]))
        runs: list[Any] = []
        alone: list[Any] = []
        memory = [0.0, 0.0]
        for _ in range(repeats):
            shutil.rmtree(folder, ignore_errors=True)
            runs.append(timed(lambda: make(plan, folder, workers)))
            if not alone:
                memory = [peak_memory(), max(map(peak_memory, children()), default=0.0)]
            alone.append(timed(lambda: solve_alone(grid, WAYS[way])))
        if runs[1:]:
            memory[1] = max(map(peak_memory, children()), default=0.0)
    shutil.rmtree(folder)
    digests = {summary.digest for _, _, summary in runs}
    return {
        "seconds": min(run[0] for run in runs),
        "core_seconds": min(run[1] for run in runs),
        "alone": min(run[0] for run in alone),
        "alone_cores": min(run[1] for run in alone),
        "size": runs[0][2].size / grid.size,
        "memory": memory,
        "task": tasks[0] / TASKS,
        "digests": sorted(digests),
    }


def compare_ways(cells: float, repeats: int, flight: bool, place: Path) -> None:
    size = grid_of(cells).size
    print(f"{size} cells, {'flight followed' if flight else 'in contact'}, {cores()} cores")
    print(
        f"{'':16}  {'s':>7}  {'cells/s':>8}  {'solve alone s':>13}  {'ratio':>5}  {'of core time':>12}"
        f"  {'bytes/cell':>10}  {'client MB':>9}  {'worker MB':>9}"
        f"  {'ms/task':>7}  digest"
    )
    for way in WAYS:
        if way.startswith("Dask") and importlib.util.find_spec("distributed") is None:
            print(f"{way:16}  skipped: there is no distributed")
            continue
        words = ["--way", way, "--cells", f"{cells}", "--repeats", f"{repeats}", "--in", f"{place}"]
        found = json.loads(own_process(*words, *["--flight"][: int(flight)]))
        ratio = found["seconds"] / found["alone"]
        core_ratio = found["core_seconds"] / found["alone_cores"]
        client, worker = found["memory"]
        print(
            f"{way:16}  {found['seconds']:7.2f}  {size / found['seconds']:8.3g}  {found['alone']:13.2f}"
            f"  {ratio:5.2f}  {core_ratio:12.2f}  {found['size']:10.2f}  {client:9.0f}"
            f"  {f'{worker:9.0f}' if worker else '        -'}"
            f"  {1e3 * found['task']:7.2f}  {' '.join(d[:12] for d in found['digests'])}",
            flush=True,
        )


def own_process(*words: str) -> str:
    command = [sys.executable, __file__, *words]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


# Faults.


def command(folder: Path, *more: str) -> list[str]:
    words = [
        "map",
        f"{EXAMPLE}",
        "--flight",
        "off",
        "--table",
        "parquet",
        "--workers",
        "2",
        "-o",
        f"{folder}",
    ]
    return [sys.executable, "-m", "vibro", *words, *more]


@contextmanager
def started(folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Start a run, and wait until some shards are there."""
    with subprocess.Popen(command(folder), stderr=subprocess.DEVNULL) as process:
        while len(list(folder.glob("part-*"))) < FAULT_SHARDS and process.poll() is None:
            time.sleep(0.02)
        yield process


def words_of(pid: int) -> bytes:
    return Path(f"/proc/{pid}/cmdline").read_bytes()


def told(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / "_SUCCESS").read_text())
    return content


def faults(place: Path) -> None:
    print("a run with 2 processes, killed (kill -9) after 3 of its 10 shards")
    calm = place / "calm"
    subprocess.run(command(calm), check=True, stderr=subprocess.DEVNULL)
    expected = told(calm)["digest"]

    folder = place / "worker"
    with started(folder) as process:
        workers = [pid for pid in children(process.pid) if b"spawn_main" in words_of(pid)]
        os.kill(workers[0], signal.SIGKILL)
        code = process.wait()
    print(f"  a worker: the run ends with {code}, digest equal: {told(folder)['digest'] == expected}")

    folder = place / "client"
    with started(folder) as process:
        process.kill()
    time.sleep(3.0)  # until its workers have noticed
    there = len(list(folder.glob("part-*")))
    print(f"  who started it: {there} shards are there, _SUCCESS: {(folder / '_SUCCESS').exists()}")
    subprocess.run(command(folder, "--resume"), check=True, stderr=subprocess.DEVNULL)
    print(f"  resumed: digest equal: {told(folder)['digest'] == expected}")


# How a shard is written, and its cells are solved.


def encodings(repeats: int) -> None:
    from pyarrow import parquet

    from vibro.output import parquet as room
    from vibro.results.sweep import Block

    grid = grid_of(1e7)
    table = plan_of(grid).table
    starts = range(0, grid.size - ROW_GROUP, grid.size // 6)
    blocks = [
        Block(grid.cells(start, start + ROW_GROUP), grid.solve_cells(start, start + ROW_GROUP, 1), LENGTH)
        for start in starts
    ]
    writer = parquet.ParquetWriter
    inputs = [column.name for column in table.columns if column.name in room._GIVEN]
    numbers = [column.name for column in table.columns if column.is_number]
    results = [name for name in numbers if name not in inputs]
    texts = [column.name for column in table.columns if not column.is_number]
    changes: dict[str, dict[str, Any]] = {
        "as it is": {},
        **{f"zstd level {level}": {"compression_level": level} for level in (-5, -3, 1, 3)},
        "LZ4": {"compression": "lz4", "compression_level": None},
        "not compressed": {"compression": "none", "compression_level": None},
        "bytes never split": {"use_byte_stream_split": False},
        "bytes of inputs split too": {"use_byte_stream_split": numbers},
        "inputs by dictionaries": {"use_dictionary": [*texts, *inputs], "use_byte_stream_split": results},
        "statistics of all columns": {"write_statistics": True},
        "pages of 20 000 cells": {"max_rows_per_page": 20_000},
        "one page a row group": dict.fromkeys(("max_rows_per_page", "data_page_size"), 8 * ROW_GROUP),
        "inputs like results": {"like_results": True},
    }

    def write(like_results: bool = False, **change: Any) -> int:
        def changed(*arguments: Any, **options: Any) -> Any:
            return writer(*arguments, **{**options, **change})

        file = io.BytesIO()
        with ExitStack() as stack:
            stack.enter_context(patch.object(parquet, "ParquetWriter", changed))
            if like_results:
                stack.enter_context(patch.object(room, "_GIVEN", frozenset()))
            form = stack.enter_context(closing(room.Parquet()))
            form.open(room.HashedFile(file), grid, table)
            for block in blocks:
                form.write(block)
        return file.tell()

    cells = ROW_GROUP * len(blocks)
    spent = best_of(repeats, {name: partial(write, **change) for name, change in changes.items()})
    print(f"{'how a shard is written':28}  {'ns/cell':>7}  {'bytes/cell':>10}")
    for name, change in changes.items():
        print(f"{name:28}  {1e9 * spent[name] / cells:7.1f}  {write(**change) / cells:10.2f}")

    print(f"\n{'cells in a row, solved':28}  {'as cells':>8}  {'as rows':>8}  ns/cell")
    for length in (25, 60, 250, 1000, 4000):
        line = grid_of(1e7, axes={"drive_angle": "10:40:4000", "static_friction": f"0.2:0.98:{length}"})
        line = Grid(line.axes, {**line.fixed, "frequency": 20.0, "friction_ratio": 0.8}, LENGTH, flight=False)
        start = line.size // 4 + 77
        ways = {"cells": 1e9, "rows": 1}

        def solve(least: float, line: Grid = line, start: int = start) -> None:
            with patch("vibro.sweeps.grid._LEAST_ROW", least):
                line.solve_cells(start, start + ROW_GROUP, 1)

        spent = best_of(3 * repeats, {name: partial(solve, least) for name, least in ways.items()})
        a, b = (1e9 * spent[name] / ROW_GROUP for name in ways)
        print(f"{f'rows of {length}':28}  {a:8.1f}  {b:8.1f}")


def best_of(repeats: int, runs: dict[str, Callable[[], Any]]) -> dict[str, float]:
    """Return the least time of this thread for each, all of them in turn."""
    best = dict.fromkeys(runs, math.inf)
    for _ in range(repeats):
        for name, run in runs.items():
            start = time.thread_time()
            run()
            best[name] = min(best[name], time.thread_time() - start)
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=float, default=1e7)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--flight", action="store_true", help="follow bodies through flight")
    parser.add_argument("--faults", action="store_true", help="kill runs, and nothing else")
    parser.add_argument("--encodings", action="store_true", help="ways to write a part, and nothing else")
    parser.add_argument("--in", dest="place", type=Path, help="where there is room; a folder of the system")
    parser.add_argument("--way", choices=WAYS, help="measure one in this process, and print JSON")
    arguments = parser.parse_args()
    if arguments.encodings:
        encodings(5 * arguments.repeats)
        return
    place: AbstractContextManager[str] = tempfile.TemporaryDirectory(dir=arguments.place)
    with place as name:
        measured = arguments.cells, arguments.repeats, arguments.flight, Path(name)
        if arguments.faults:
            faults(Path(name))
        elif arguments.way:
            print(json.dumps(run_way(arguments.way, *measured)))
        else:
            compare_ways(*measured)


if __name__ == "__main__":
    main()
