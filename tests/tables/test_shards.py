"""Shards: their cells are those of the sweep bit for bit, and their bytes the same whatever made them."""

from __future__ import annotations

import contextlib
import hashlib
import shutil
from collections import Counter
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from helpers.plans import plan_of, swept, written
from pyarrow import parquet

from vibro.errors import FileError, VibroError
from vibro.results.sweep import Block
from vibro.sweeps.columns import arrow_table
from vibro.sweeps.grid import Grid
from vibro.tables.files import hidden_folder, remove_hidden
from vibro.tables.plan import MANIFEST, SUCCESS, shard_name, unsealed
from vibro.tables.shards import Summary, make_shard

if TYPE_CHECKING:
    from vibro.sweeps.whole import Sweep
    from vibro.tables.plan import Plan

SWEEPS: dict[str, dict[str, Any]] = {
    "lines": {"amplitude_mm": "0.1:3:5", "frequency_hz": "10:60:6", "trough_length_mm": 600},
    "bouncing": {"amplitude_mm": "1:6:4", "frequency_hz": "20, 40", "restitution": 0.3},
    "infeasible": {"static_friction": "0.2,0.5,0.8", "drive_angle_deg": [0, 45], "trough_angle_deg": [0, 5]},
}


@pytest.fixture(scope="module")
def lines() -> Sweep:
    return swept(**SWEEPS["lines"])


def shards_in(folder: Path) -> list[Path]:
    return sorted(folder.glob("part-*.parquet"))


@pytest.mark.parametrize("name", SWEEPS)
def test_cells_are_those_of_a_sweep_in_memory(tmp_path: Path, name: str) -> None:
    """Bit for bit; what is told last is what can be counted."""
    solved, folder = swept(**SWEEPS[name]), tmp_path / "out"
    plan, grid = plan_of(solved, 7, row_group_cells=3), solved._grid
    digest = written(folder, plan).digest
    expected = arrow_table(plan.table.columns, Block(grid.values(), solved.cycle, grid.length))
    paths, lines = shards_in(folder), ""
    assert {path.name for path in folder.iterdir()} == {SUCCESS, MANIFEST, *(path.name for path in paths)}
    for shard, path in enumerate(paths):
        found = parquet.read_table(path, page_checksum_verification=True)
        for item, column in zip(found.schema, found.columns, strict=True):
            held = expected[item.name].slice(7 * shard, 7)
            assert repr(column.to_pylist()) == repr(held.to_pylist()), item.name
            assert expected.schema.field(item.name).equals(item, check_metadata=True)
        lines += f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n"
    told, frame = unsealed((folder / SUCCESS).read_bytes()), solved.to_frame()
    assert told["digest"] == hashlib.sha256(lines.encode()).hexdigest() == digest
    assert told["bytes"] == sum(path.stat().st_size for path in paths)
    assert (told["cells"], told["shards"]) == (len(frame), len(paths))
    assert told["status"] == dict(Counter(frame["status"]))
    assert told["regime"] == {label or "none": n for label, n in Counter(frame["regime"]).items()}


@pytest.mark.usefixtures("two_cores")
def test_bytes_are_the_same_whatever_makes_them(tmp_path: Path) -> None:
    plan = plan_of(swept(**SWEEPS["bouncing"]), 3)
    threads = written(tmp_path / "threads", plan)
    turned = Summary(dict(sorted(threads.made.items(), reverse=True)))
    digests = {threads.digest, turned.digest, written(tmp_path / "processes", plan, 2).digest}
    if find_spec("distributed"):
        from distributed import LocalCluster

        how = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "protocol": "tcp"}
        with LocalCluster(**how, dashboard_address=None) as dask:
            digests.add(written(tmp_path / "dask", plan, dask.scheduler_address).digest)
    assert len(digests) == 1


def make(plan: Plan, folder: Path, shard: int = 0) -> Any:
    return make_shard(plan, folder, folder.parent, shard, 1)


def test_a_shard_of_other_cells_is_refused_and_never_replaced(tmp_path: Path, lines: Sweep) -> None:
    plan, folder = plan_of(lines, 16), tmp_path / "out"
    summary = written(folder, plan)
    first, second = shards_in(folder)
    whole = first.read_bytes()
    found = make(plan, folder)
    assert (found.digest, found.is_new) == (summary.made[0].digest, False)
    for other in (plan_of(lines), plan_of(lines, 16, columns=["regime"]), plan_of(lines, 15)):
        with pytest.raises(FileError, match=r"part-000000\.parquet belongs to another sweep"):
            make(other, folder)
    assert not make(replace(plan, name="bolt"), folder).is_new
    turned = [whole[:i] + bytes([whole[i] ^ 1 << i % 8]) + whole[i + 1 :] for i in range(99, len(whole), 97)]
    for content in (*turned, second.read_bytes(), whole[:-1], whole[:100], b""):
        first.write_bytes(content)
        with pytest.raises(FileError, match=r"another sweep|is damaged") as caught:
            make(plan, folder)
        assert caught.value.hint.startswith("remove it")
        assert first.read_bytes() == content


def test_a_folder_that_lost_a_shard_is_whole_when_it_is_there_again(tmp_path: Path, lines: Sweep) -> None:
    plan, folder = plan_of(lines, 10), tmp_path / "out"
    summary = written(folder, plan)
    first, _, last = shards_in(folder)
    last.unlink()
    first.write_bytes(b"")
    with pytest.raises(FileError, match=r"part-000000\.parquet is damaged"):
        written(folder, plan)
    assert not (folder / SUCCESS).exists()
    first.unlink()
    assert written(folder, plan).digest == summary.digest


def test_nobody_makes_a_shard_without_the_folder_of_the_run_or_with_other_versions(
    tmp_path: Path, lines: Sweep
) -> None:
    plan = plan_of(lines)
    with pytest.raises(FileError, match=r"a worker finds no folder .*gone"):
        make_shard(plan, tmp_path, tmp_path / "gone", 0, 1)
    other = {**plan.content, "made_by": {**plan.content["made_by"], "numpy": "1.0"}}
    with pytest.raises(FileError, match=r"a worker has .*; this sweep is made with .*numpy 1\.0"):
        make(replace(plan, content=other), tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_an_error_names_the_cells_and_leaves_nothing_half(
    tmp_path: Path, lines: Sweep, monkeypatch: pytest.MonkeyPatch
) -> None:
    solve = Grid.solve_cells

    def fail(grid: Grid, start: int, stop: int, *more: Any) -> Any:
        if start >= 24:
            raise ZeroDivisionError("no such load")
        return solve(grid, start, stop, *more)

    monkeypatch.setattr(Grid, "solve_cells", fail)
    with pytest.raises(VibroError, match="cells 24 to 27: ZeroDivisionError: no such load"):
        written(tmp_path / "out", plan_of(lines, 8, row_group_cells=4))
    assert {path.name for path in (tmp_path / "out").iterdir()} <= {MANIFEST, *map(shard_name, range(3))}


def test_nobody_begins_a_file_in_a_folder_that_goes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Or the folder stays, and the workers of a run that ended go on."""
    remove, late = shutil.rmtree, []

    def begin(path: Path, **options: Any) -> None:
        with contextlib.suppress(OSError):
            late.append((running / "late").open("wb"))
        remove(path, **options)

    with hidden_folder(tmp_path) as running:
        (running / "begun").touch()
        monkeypatch.setattr(shutil, "rmtree", begin)
        remove_hidden(running)
        assert not late
    assert not [*tmp_path.iterdir()]
