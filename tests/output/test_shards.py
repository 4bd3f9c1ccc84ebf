"""Shards: their cells are those of the sweep bit for bit, and their bytes the same whoever writes them."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import pyarrow as arrow
import pytest
from helpers.plans import plan_of, swept, written
from hypothesis import given, settings
from hypothesis import strategies as st
from pyarrow import parquet

from vibro.core.codes import Status
from vibro.errors import FileError
from vibro.output.parquet import Parquet, read_footer
from vibro.output.plan import ROW_GROUP
from vibro.output.shard_folder import MANIFEST, SUCCESS, shard_name
from vibro.output.shards import Job, check_job, check_shard, make_shard
from vibro.output.workers import Processes, Threads
from vibro.quantities import BY_COLUMN
from vibro.results.sweep import Block
from vibro.sweeps.columns import to_frame

if TYPE_CHECKING:
    from pathlib import Path

    from vibro.output.plan import Plan
    from vibro.sweeps.whole import Sweep


def shards_in(folder: Path) -> list[Path]:
    return sorted(folder.glob("part-*.parquet"))


def table_in(folder: Path) -> arrow.Table:
    """Read all shards in their order."""
    tables = [parquet.read_table(path, page_checksum_verification=True) for path in shards_in(folder)]
    return arrow.concat_tables([table.unify_dictionaries() for table in tables])


def check_cells(folder: Path, plan: Plan, solved: Sweep) -> None:
    """Compare what is there with the sweep that was held, bit for bit."""
    block = Block(solved._grid.values(), solved.cycle, solved._grid.length)
    expected = to_frame(plan.table.columns, block)
    if not plan.table.part and len(plan.table.columns) > 15:  # what users get
        pd.testing.assert_frame_equal(expected, solved.to_frame())
    found = table_in(folder)
    assert found.column_names == list(expected.columns)
    assert found.num_rows == plan.grid.size
    for name in found.column_names:
        column, held = found[name].combine_chunks(), expected[name]
        if arrow.types.is_floating(column.type):
            numbers = held.to_numpy(np.float64)
            if plan.table.digits is not None:
                numbers = np.array([float(f"{x:.{plan.table.digits}g}") for x in numbers])
            known = np.isfinite(numbers)
            assert column.is_valid().to_pylist() == known.tolist(), name
            there = column.drop_null().to_numpy()
            assert np.all(np.isfinite(there)), name
            np.testing.assert_array_equal(
                there.view(np.int64), numbers[known].view(np.int64), err_msg=name, strict=True
            )
        elif arrow.types.is_integer(column.type):
            assert column.to_pylist() == [None if x is pd.NA else int(x) for x in held], name
        else:
            assert column.cast(arrow.string()).to_pylist() == held.tolist(), name


def check_footers(folder: Path, plan: Plan) -> None:
    """Look whether each shard says which cells of which sweep it has, and how many of each kind."""
    assert [path.name for path in shards_in(folder)] == [shard_name(i) for i in range(plan.shards)]
    for shard, path in enumerate(shards_in(folder)):
        said = parquet.read_metadata(path)
        first, end = plan.range_of(shard)
        footer = read_footer(said)
        place = {"fingerprint": plan.fingerprint, "first_cell": first, "cells": end - first}
        assert place.items() <= footer.items()
        assert said.num_rows == sum(footer["status"].values()) == sum(footer["regime"].values())
        record = {key: value for key, value in footer.items() if key != "sha256"}
        assert hashlib.sha256(json.dumps(record).encode()).hexdigest() == footer["sha256"]


def check_success(folder: Path, solved: Sweep, digest: str) -> None:
    """Look whether the last file counts what is there, and nothing else is there."""
    paths = shards_in(folder)
    told = json.loads((folder / SUCCESS).read_text(encoding="utf-8"))
    lines = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in paths]
    frame = solved.to_frame()
    check_peaks(told.pop("peaks"), frame)
    assert told == {
        "cells": len(frame),
        "shards": len(paths),
        "bytes": sum(path.stat().st_size for path in paths),
        "digest": hashlib.sha256("".join(lines).encode()).hexdigest(),
        "status": dict(Counter(frame["status"])),
        "regime": {label or "none": number for label, number in Counter(frame["regime"]).items()},
    }
    assert told["digest"] == digest
    assert {path.name for path in folder.iterdir()} == {SUCCESS, MANIFEST, *(path.name for path in paths)}


def check_peaks(told: dict[str, dict[str, float]], frame: pd.DataFrame) -> None:
    """Look whether the fastest cells that the last file names are the first such rows of the table."""
    speed = frame["mean_velocity_mm_s"].astype(float)
    error = frame["mean_velocity_error_mm_s"].astype(float).fillna(0.0)
    sure = speed[np.isfinite(speed) & (speed.abs() > 3.0 * error)]
    ways = {"fastest": sure[sure > 0.0], "fastest_backwards": -sure[sure < 0.0]}
    assert told.keys() == {name for name, speeds in ways.items() if len(speeds)}
    for name, peak in told.items():
        row = frame.to_dict("records")[int(ways[name].index[int(ways[name].argmax())])]
        shared = [column for column in peak if column in frame and column != "mean_velocity_error_mm_s"]
        assert [peak[column] for column in shared] == [row[column] for column in shared]


HOPS = {"amplitude_mm": "1:6:4", "frequency_hz": "20,40", "trough_length_mm": 600}
ELLIPSE: dict[str, Any] = {"along_amplitude_mm": 1, "normal_phase_deg": 40, "normal_amplitude_mm": "0.1,1,3"}
SWEEPS: dict[str, dict[str, Any]] = {
    "lines": {"amplitude_mm": "0.1:3:5", "frequency_hz": "10:60:6", "trough_length_mm": 600},
    "logarithmic": {"amplitude_mm": "0.1:3:5:log", "frequency_hz": "10:60:3:log"},
    "bouncing": {**HOPS, "restitution": 0.3},
    "infeasible": {
        "static_friction": "0.2,0.5,0.8",
        "drive_angle_deg": [0, 45, 89],
        "trough_angle_deg": [0, 5],
    },
    "ratios": {"static_friction": "0.2,0.5,0.8", "friction_ratio": "0.5:1.5:5", "amplitude_mm": "1,2"},
    "harmonics": {**ELLIPSE, "frequency_hz": "10:40:4", "along_amplitude_2_mm": [0, 0.2]},
    "no flight": {**HOPS, "flight": False},
    "coexistence": {
        "amplitude_mm": "0.1,6",
        "drive_angle_deg": 55,
        "trough_angle_deg": "0:31:2",
        "coexistence": True,
    },
    "runaway": {"trough_angle_deg": [-40, 0, 40], "amplitude_mm": "0.1,1", "trough_length_mm": 600},
}


@pytest.fixture(scope="module")
def sweeps() -> dict[str, Sweep]:
    """Solve each sweep once."""
    return {name: swept(**quantities) for name, quantities in SWEEPS.items()}


@pytest.mark.parametrize("name", SWEEPS)
def test_the_cells_are_those_of_the_sweep_whatever_the_shards(
    tmp_path: Path, sweeps: dict[str, Sweep], name: str
) -> None:
    solved = sweeps[name]
    for shard_cells in (7, 1000):
        folder = tmp_path / str(shard_cells)
        plan = plan_of(solved, shard_cells)
        summary = written(folder, plan)
        check_cells(folder, plan, solved)
        check_footers(folder, plan)
        check_success(folder, solved, summary.digest)


def test_the_sweeps_have_cells_of_every_kind(sweeps: dict[str, Sweep]) -> None:
    found = {Status(int(code)) for solved in sweeps.values() for code in np.unique(solved.cycle.status)}
    assert found >= {
        Status.OK, Status.AVERAGED, Status.INFEASIBLE, Status.FLIGHT_NOT_MODELLED, Status.RUNAWAY,
    }  # fmt: skip
    flags = {int(flag) for solved in sweeps.values() for flag in np.unique(solved.cycle.coexists)}
    assert flags == {-1, 0, 1}


@pytest.mark.parametrize(
    ("how", "more", "missing"),
    [
        ({"columns": ["status", "stroke_mm", "mean_velocity_mm_s", "amplitude_mm"]}, [], []),
        ({"columns": ["pattern"]}, [], ["status"]),
        ({"columns": ["coexists"]}, [], []),
        ({"digits": 4}, [], ["parts_per_min"]),
        ({"digits": 17, "part": {"pitch_mm": 25.0}}, ["parts_per_min"], ["mass_flow_kg_h"]),
        ({"part": {"pitch_mm": 25.0, "mass_kg": 0.012}}, ["parts_per_min", "mass_flow_kg_h"], []),
        ({"shard_cells": 1}, [], []),
    ],
)
def test_columns_and_digits_are_those_asked_for(
    tmp_path: Path, sweeps: dict[str, Sweep], how: dict[str, Any], more: list[str], missing: list[str]
) -> None:
    plan = plan_of(sweeps["lines"], **{"shard_cells": 13, **how})
    written(tmp_path / "out", plan)
    check_cells(tmp_path / "out", plan, sweeps["lines"])
    names = table_in(tmp_path / "out").column_names
    assert names == how.get("columns", names)
    assert {*more} <= {*names}
    assert not {*missing} & {*names}


@settings(max_examples=2)
@given(st.lists(st.integers(2, 5), min_size=1, max_size=4), st.integers(1, 40), st.integers(1, 12))
def test_shards_and_row_groups_may_cut_axes_anywhere(
    tmp_path_factory: pytest.TempPathFactory, shape: list[int], shard_cells: int, row_group: int
) -> None:
    axes = ("amplitude_mm", "frequency_hz", "static_friction", "friction_ratio")
    first = dict(zip(axes, (0.5, 10.0, 0.3, 0.4), strict=True))
    quantities: dict[str, Any] = {
        name: [first[name] + 0.3 * i for i in range(n)] for name, n in zip(axes, shape, strict=False)
    }
    solved = swept("regimes", **quantities)
    plan = plan_of(solved, max(shard_cells, solved._grid.size // 10))
    folder = tmp_path_factory.mktemp("cut") / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibro.output.shards.ROW_GROUP", row_group)
        written(folder, plan)
    check_cells(folder, plan, solved)
    check_footers(folder, plan)
    for path in shards_in(folder):
        said = parquet.read_metadata(path)
        rows = [said.row_group(i).num_rows for i in range(said.num_row_groups)]
        assert {*rows[:-1]} <= {row_group}
        assert 0 < rows[-1] <= row_group


def test_types_and_encodings(tmp_path: Path, sweeps: dict[str, Sweep]) -> None:
    plan = plan_of(sweeps["lines"])
    assert json.loads(plan.manifest([]))["row_group_cells"] == ROW_GROUP
    written(tmp_path / "out", plan)
    (path,) = shards_in(tmp_path / "out")
    table = parquet.read_table(path)
    group = parquet.read_metadata(path).row_group(0)
    assert group.num_columns == len(plan.table.columns)
    text = arrow.dictionary(arrow.int32(), arrow.string())
    for i, column in enumerate(plan.table.columns):
        said = group.column(i)
        wanted = arrow.float64() if column.is_number else arrow.int8() if column.is_flag else text
        assert table.schema.field(column.name).type == wanted
        assert said.compression == "ZSTD"
        # Inputs, which come again and again, are smaller as they are (benchmarks/sweeps.py --encodings).
        # The trough's length is written as results are: on request it is a column without values too.
        split = column.is_number and column.name not in BY_COLUMN.keys() - {"trough_length_mm"}
        assert ("BYTE_STREAM_SPLIT" in said.encodings) == split
        assert ("RLE_DICTIONARY" in said.encodings) != column.is_number
        assert said.is_stats_set == (column.name in BY_COLUMN), column.name
    statistics = group.column(0).statistics
    assert (statistics.min, statistics.max) == (0.1, 3.0)


@pytest.mark.usefixtures("two_cores")
def test_bytes_are_the_same_whoever_writes_them(tmp_path: Path, sweeps: dict[str, Sweep]) -> None:
    plan = plan_of(sweeps["bouncing"], 3)
    alone, each = Threads(1), Threads(plan.shards)
    assert [(who.number, who.threads) for who in (alone, each, Processes(2))] == [(1, 2), (2, 1), (2, 1)]
    digests = [written(tmp_path / str(i), plan, who).digests for i, who in enumerate((alone, each))]
    assert digests[0] == digests[1]
    assert len(digests[0]) == 3


def job_of(plan: Plan, folder: Path) -> Job:
    """Make a job whose run has its hidden folder in a folder."""
    hidden = folder / ".vibro-hidden" / "run"
    hidden.mkdir(parents=True, exist_ok=True)
    return Job(plan, hidden, 1)


def test_no_changed_bit_of_a_shard_is_overlooked(tmp_path: Path, sweeps: dict[str, Sweep]) -> None:
    plan = plan_of(sweeps["lines"], 16)
    written(tmp_path / "out", plan)
    first, second = shards_in(tmp_path / "out")
    job, whole = job_of(plan, tmp_path / "out"), first.read_bytes()
    made = check_shard(job, 0)
    assert made is not None
    assert (made.name, made.size, made.digest) == (
        first.name, len(whole), hashlib.sha256(whole).hexdigest(),
    )  # fmt: skip
    assert made.tally.status.total() == 16
    footer = len(whole) - 8 - int.from_bytes(whole[-8:-4], "little")
    places = (*range(0, footer, 397), *range(footer, len(whole), 131))
    bits = [whole[:i] + bytes([whole[i] ^ (1 << i % 8)]) + whole[i + 1 :] for i in places]
    edited = whole.replace(b'"first_cell": 0', b'"first_cell": 1')
    assert edited != whole
    for other in (*bits, edited, whole[:-1], whole[:100], b"", b"PAR1", second.read_bytes(), whole + b"\0"):
        first.write_bytes(other)
        assert check_shard(job, 0) is None
    first.unlink()
    assert check_shard(job, 0) is None


def test_a_shard_of_another_sweep_or_with_another_footer_is_none_of_this(
    tmp_path: Path, sweeps: dict[str, Sweep]
) -> None:
    plan, folder = plan_of(sweeps["lines"]), tmp_path / "out"
    written(folder, plan)
    for other in (
        plan_of(sweeps["lines"], digits=17),
        plan_of(sweeps["lines"], 1000),
        plan_of(sweeps["lines"], columns=[column.name for column in reversed(plan.table.columns)]),
    ):
        assert check_shard(job_of(other, folder), 0) is None
    assert check_shard(job_of(replace(plan, name="bolt"), folder), 0) is not None
    path = folder / shard_name(0)
    table, footer = parquet.read_table(path), read_footer(parquet.read_metadata(path))
    del footer["sha256"]
    edits: dict[str, Any] = {"fingerprint": "0", "first_cell": 1, "cells": 29, "status": {"ok": 29}}
    for edit in (None, *({name: value} for name, value in edits.items())):
        form = Parquet()
        form.open(path, plan.grid, plan.table)
        form.copy(table)
        form.close(None if edit is None else {**footer, **edit})
        assert check_shard(job_of(plan, folder), 0) is None


def test_a_worker_refuses_other_versions_and_other_files(tmp_path: Path, sweeps: dict[str, Sweep]) -> None:
    plan = plan_of(sweeps["lines"])
    job = job_of(plan, tmp_path)
    check_job(job)
    other = {**plan.content, "versions": {**plan.content["versions"], "numpy": "1.0"}}
    elsewhere = replace(job, hidden=tmp_path / "nowhere" / ".vibro-hidden" / "run")
    for work in (check_job, lambda job: make_shard(job, 0)):
        with pytest.raises(FileError, match=r"a worker has .*; this sweep is made with .*numpy 1\.0"):
            work(replace(job, plan=replace(plan, content=other)))
        with pytest.raises(FileError, match=r"a worker finds no folder .*nowhere") as caught:
            work(elsewhere)
        assert "same files" in caught.value.hint
