"""Parts: their cells are those of the sweep bit for bit, and their bytes the same whoever writes them."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
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

import vibro.sweeps.parted
from vibro.core.codes import Status
from vibro.errors import FileError, VibroError
from vibro.files.part_sets import PartSet
from vibro.quantities import BY_COLUMN
from vibro.results.sweep import Block
from vibro.sweeps.columns import to_frame
from vibro.sweeps.executors import Processes, Threads
from vibro.sweeps.parts import Job, Written, check_part, read_footer, solve_piece, write_part

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from vibro.sweeps.plan import Plan
    from vibro.sweeps.whole import Sweep


def parts_in(folder: Path) -> list[Path]:
    return sorted(folder.glob("part-*.parquet"))


def table_in(folder: Path) -> arrow.Table:
    """Read all parts in their order."""
    tables = [parquet.read_table(path, page_checksum_verification=True) for path in parts_in(folder)]
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


HOPS = {"amplitude_mm": "1:6:4", "frequency_hz": "20,40", "trough_length_mm": 600}
ELLIPSE: dict[str, Any] = {"along_amplitude_mm": 1, "normal_phase_deg": 40, "normal_amplitude_mm": "0.1,1,3"}
SWEEPS: dict[str, dict[str, Any]] = {
    "lines": {"amplitude_mm": "0.1:3:5", "frequency_hz": "10:60:6", "trough_length_mm": 600},
    "lists": {"amplitude_mm": [0.1, 1, 1.7], "drive_angle_deg": [10, 45.1], "trough_angle_deg": [-3.3, 0, 4]},
    "logarithmic": {"amplitude_mm": "0.1:3:5:log", "frequency_hz": "10:60:3:log"},
    "hopping": {**HOPS, "restitution": 0},
    "bouncing": {**HOPS, "restitution": 0.3},
    "restitutions": {"amplitude_mm": "1:6:3", "restitution": [0, 0.3]},
    "infeasible": {
        "static_friction": "0.2,0.5,0.8",
        "drive_angle_deg": [0, 45, 89],
        "trough_angle_deg": [0, 5],
    },
    "ratios": {"static_friction": "0.2,0.5,0.8", "friction_ratio": "0.5:1.5:5", "amplitude_mm": "1,2"},
    "a ratio": {"static_friction": "0.2,0.5,0.8", "friction_ratio": 0.77, "amplitude_mm": "1,2"},
    "ellipses": {**ELLIPSE, "frequency_hz": "10:40:4", "restitution": [0, 0.3]},
    "harmonics": {**ELLIPSE, "frequency_hz": "10:40:4", "along_amplitude_2_mm": [0, 0.2]},
    "regimes": {**HOPS, "accuracy": "regimes"},
    "no flight": {**HOPS, "flight": False},
    "coexistence": {
        "amplitude_mm": "0.1,6",
        "drive_angle_deg": 55,
        "trough_angle_deg": "0:31:2",
        "coexistence": True,
    },
    "runaway": {"trough_angle_deg": [-40, 0, 40], "amplitude_mm": "0.1,1", "trough_length_mm": 600},
    "one cell": {},
}


@pytest.fixture(scope="module")
def sweeps() -> dict[str, Sweep]:
    """Solve each sweep once."""
    return {name: swept(**quantities) for name, quantities in SWEEPS.items()}


@pytest.mark.parametrize("name", SWEEPS)
def test_the_cells_are_those_of_the_sweep_whatever_the_parts(
    tmp_path: Path, sweeps: dict[str, Sweep], name: str
) -> None:
    solved = sweeps[name]
    for part_cells in (7, 1000):
        folder = tmp_path / str(part_cells)
        plan = plan_of(solved, part_cells)
        summary = written(folder, plan)
        check_cells(folder, plan, solved)
        check_parts(folder, plan)
        check_success(folder, solved, summary.digest)


def check_parts(folder: Path, plan: Plan) -> None:
    """Look whether each part is what the manifest says."""
    told = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    assert [path.name for path in parts_in(folder)] == [part["file"] for part in told["parts"]]
    for number, part in enumerate(told["parts"]):
        said = parquet.read_metadata(folder / part["file"])
        assert said.num_rows == part["cells"]
        footer = read_footer(said)
        assert footer is not None
        place = {"fingerprint": plan.fingerprint, "part": number, "first_cell": part["first_cell"]}
        assert {**place, "cells": part["cells"]}.items() <= footer.items()
        assert sum(footer["status"].values()) == sum(footer["regime"].values()) == part["cells"]


def check_success(folder: Path, solved: Sweep, digest: str) -> None:
    """Look whether the last file counts what is there, and nothing else is there."""
    paths = parts_in(folder)
    told = json.loads((folder / "_SUCCESS").read_text(encoding="utf-8"))
    lines = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in paths]
    frame = solved.to_frame()
    check_peaks(told.pop("peaks"), frame)
    assert told == {
        "cells": len(frame),
        "parts": len(paths),
        "bytes": sum(path.stat().st_size for path in paths),
        "digest": hashlib.sha256("".join(lines).encode()).hexdigest(),
        "status": dict(Counter(frame["status"])),
        "regime": {label or "none": number for label, number in Counter(frame["regime"]).items()},
    }
    assert told["digest"] == digest
    names = {path.name for path in folder.iterdir()}
    assert names == {"_SUCCESS", "manifest.json", *(path.name for path in paths)}


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


def test_the_sweeps_have_cells_of_every_kind(sweeps: dict[str, Sweep]) -> None:
    found = {Status(int(code)) for solved in sweeps.values() for code in np.unique(solved.cycle.status)}
    assert found >= {
        Status.OK,
        Status.AVERAGED,
        Status.INFEASIBLE,
        Status.FLIGHT_NOT_MODELLED,
        Status.RUNAWAY,
    }
    flags = {int(flag) for solved in sweeps.values() for flag in np.unique(solved.cycle.coexists)}
    assert flags == {-1, 0, 1}


def test_a_part_may_be_a_cell_or_all_of_them(tmp_path: Path, sweeps: dict[str, Sweep]) -> None:
    solved = sweeps["ratios"]
    for part_cells, number in ((1, solved._grid.size), (solved._grid.size, 1)):
        folder = tmp_path / str(number)
        plan = plan_of(solved, part_cells)
        written(folder, plan)
        assert len(parts_in(folder)) == number
        check_cells(folder, plan, solved)


def test_columns_are_those_asked_for_in_their_order(tmp_path: Path, sweeps: dict[str, Sweep]) -> None:
    for i, columns in enumerate(
        (
            ["status", "stroke_mm", "mean_velocity_mm_s", "amplitude_mm"],
            ["pattern"],
            ["throw_number"],
            ["coexists"],
        )
    ):
        plan = plan_of(sweeps["lines"], 13, columns=columns)
        written(tmp_path / str(i), plan)
        assert table_in(tmp_path / str(i)).column_names == columns
        check_cells(tmp_path / str(i), plan, sweeps["lines"])


def test_parts_in_a_row_and_digits(tmp_path: Path, sweeps: dict[str, Sweep]) -> None:
    for i, (digits, part) in enumerate(
        ((4, None), (17, {"pitch_mm": 25.0}), (None, {"pitch_mm": 25.0, "mass_kg": 0.012}))
    ):
        plan = plan_of(sweeps["lines"], 13, digits=digits, part=part)
        written(tmp_path / str(i), plan)
        names = table_in(tmp_path / str(i)).column_names
        assert ("parts_per_min" in names, "mass_flow_kg_h" in names) == (i > 0, i > 1)
        check_cells(tmp_path / str(i), plan, sweeps["lines"])


LARGE: dict[str, Any] = {"amplitude_mm": "0.1:3:400", "frequency_hz": "5:60:370", "accuracy": "regimes"}


def test_row_groups_are_those_of_the_manifest(tmp_path: Path) -> None:
    solved = swept(**LARGE)
    plan = plan_of(solved, 140_000, columns=["frequency_hz", "regime"])
    written(tmp_path / "out", plan)
    size = json.loads((tmp_path / "out" / "manifest.json").read_text(encoding="utf-8"))["row_group_cells"]
    said = [parquet.read_metadata(path) for path in parts_in(tmp_path / "out")]
    rows = [[one.row_group(i).num_rows for i in range(one.num_row_groups)] for one in said]
    assert rows == [[size, 140_000 - size], [8_000]]
    check_cells(tmp_path / "out", plan, solved)


@settings(max_examples=8)
@given(st.lists(st.integers(2, 5), min_size=1, max_size=4), st.integers(1, 40), st.integers(1, 12))
def test_ranges_may_cut_axes_anywhere(
    tmp_path_factory: pytest.TempPathFactory, shape: list[int], part_cells: int, row_group: int
) -> None:
    axes = ("amplitude_mm", "frequency_hz", "static_friction", "friction_ratio")
    first = dict(zip(axes, (0.5, 10.0, 0.3, 0.4), strict=True))
    quantities: dict[str, Any] = {
        name: [first[name] + 0.3 * i for i in range(n)] for name, n in zip(axes, shape, strict=False)
    }
    solved = swept("regimes", **quantities)
    plan = plan_of(solved, max(part_cells, plan_of(solved).grid.size // 10))
    folder = tmp_path_factory.mktemp("cut") / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibro.sweeps.parts.ROW_GROUP", row_group)
        written(folder, plan)
    check_cells(folder, plan, solved)
    check_parts(folder, plan)


def test_types_and_encodings(tmp_path: Path, sweeps: dict[str, Sweep]) -> None:
    plan = plan_of(sweeps["lines"])
    written(tmp_path / "out", plan)
    (path,) = parts_in(tmp_path / "out")
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


def test_a_changed_byte_is_found(tmp_path: Path, sweeps: dict[str, Sweep]) -> None:
    plan = plan_of(sweeps["lines"], 16)
    written(tmp_path / "out", plan)
    first, second = parts_in(tmp_path / "out")
    job = job_of(plan, tmp_path / "out")
    assert isinstance(check_part(job, 0), Written)
    whole = first.read_bytes()
    page = parquet.read_metadata(first).row_group(0).column(8)
    middle = page.data_page_offset + page.total_compressed_size - 1
    for other in (
        whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :],
        whole[:-1], whole[:100], b"", b"PAR1", second.read_bytes(),
    ):  # fmt: skip
        first.write_bytes(other)
        assert check_part(job, 0) is None
    first.unlink()
    assert check_part(job, 0) is None


def job_of(plan: Plan, folder: Path, patience: float = 20.0) -> Job:
    folder.mkdir(exist_ok=True)
    return Job(plan, folder, "0" * 16, folder, 1, patience)


def test_a_part_of_another_sweep_is_none_of_this(tmp_path: Path, sweeps: dict[str, Sweep]) -> None:
    plan = plan_of(sweeps["lines"])
    written(tmp_path / "out", plan)
    for other in (
        plan_of(sweeps["lines"], digits=17),
        plan_of(sweeps["lines"], 1000),
        plan_of(sweeps["lines"], columns=[column.name for column in reversed(plan.table.columns)]),
    ):
        assert check_part(job_of(other, tmp_path / "out"), 0) is None
    assert check_part(job_of(replace(plan, name="bolt"), tmp_path / "out"), 0) is not None
    table = parquet.read_table(tmp_path / "out" / "part-000000.parquet")
    parquet.write_table(table.replace_schema_metadata(), tmp_path / "out" / "part-000000.parquet")
    assert check_part(job_of(plan, tmp_path / "out"), 0) is None


@pytest.mark.skipif(shutil.which("sha256sum") is None, reason="no sha256sum")
def test_the_digest_is_what_the_system_says(tmp_path: Path, sweeps: dict[str, Sweep]) -> None:
    summary = written(tmp_path / "out", plan_of(sweeps["lines"], 4))
    said = subprocess.run(
        "sha256sum part-*.parquet | sha256sum",
        shell=True, cwd=tmp_path / "out", capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    assert said.split()[0] == summary.digest


@pytest.mark.usefixtures("two_cores")
def test_bytes_are_the_same_whoever_writes_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.sweeps.parts._SAMPLES", (1,))
    solved = swept(amplitude_mm="3:9:3", frequency_hz="20:60:9", restitution=0.3)
    plan = plan_of(solved, 10)
    pieces: list[int] = []

    def counted(*args: Any) -> Any:
        found = solve_piece(*args)
        assert found is not None
        pieces.append(found.stop - found.start)
        return found

    monkeypatch.setattr(vibro.sweeps.parted, "solve_piece", counted)
    alone = Threads(1)
    assert (alone.number, alone.threads) == (1, 2)
    one = written(tmp_path / "one", plan, alone)
    assert written(tmp_path / "threads", plan, Threads(plan.parts)).digests == one.digests
    assert pieces == []
    assert written(tmp_path / "pieces", plan, Threads(plan.parts), patience=1e-3).digests == one.digests
    assert len(pieces) > plan.parts
    assert sum(pieces) == plan.grid.size
    assert written(tmp_path / "processes", plan, Processes(2)).digests == one.digests
    for name in ("one", "pieces", "processes"):
        check_cells(tmp_path / name, plan, solved)
        check_success(tmp_path / name, solved, one.digest)


@pytest.mark.parametrize("name", ["coexistence", "restitutions", "ellipses", "harmonics"])
def test_pieces_hold_all_there_is_of_a_cell(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sweeps: dict[str, Sweep], name: str
) -> None:
    monkeypatch.setattr("vibro.sweeps.parts.ROW_GROUP", 3)
    monkeypatch.setattr("vibro.sweeps.parts._FIRST_STEP", 2)
    plan = plan_of(sweeps[name], 8)
    patient, at_once = (job_of(plan, tmp_path, patience=patience) for patience in (1e9, 0.0))
    whole = write_part(patient, 0)
    first, end = plan.range_of(0)
    for cut in range(first + 1, end):
        pieces = [solve_piece(patient, 0, *ends) for ends in ((first, cut), (cut, end))]
        assert [(piece.start, piece.stop) for piece in pieces if piece] == [(first, cut), (cut, end)]
        again = write_part(patient, 0, [piece for piece in pieces if piece])
        assert isinstance(whole, Written)
        assert again == replace(whole, temporary=again.temporary if isinstance(again, Written) else "")
    piece = solve_piece(at_once, 0, first, end)
    assert piece is not None
    assert (piece.start, piece.stop) == (first, first + 2)


def test_nobody_writes_what_nobody_wants(tmp_path: Path, sweeps: dict[str, Sweep]) -> None:
    plan = plan_of(sweeps["lines"])
    with PartSet(tmp_path / "out", "go on") as files:
        job = Job(plan, files.folder, files.run, files.wanted, 1, 20.0)
        files.stop()
        assert write_part(job, 0) is None
        assert solve_piece(job, 0, 0, 10) is None
        assert [path for path in files.folder.iterdir() if path.name.startswith(".part-")] == []


WORK: list[Callable[[Job], object]] = [
    lambda job: write_part(job, 0), lambda job: check_part(job, 0), lambda job: solve_piece(job, 0, 0, 1),
]  # fmt: skip


@pytest.mark.parametrize("work", WORK)
def test_a_worker_refuses_other_versions_and_other_files(
    tmp_path: Path, sweeps: dict[str, Sweep], work: Callable[[Job], object]
) -> None:
    plan = plan_of(sweeps["lines"])
    other = replace(plan, versions={**plan.versions, "numpy": "1.0"})
    with pytest.raises(VibroError, match=r"a worker has .*; this sweep is made with .*numpy 1\.0"):
        work(job_of(other, tmp_path))
    job = replace(job_of(plan, tmp_path), folder=tmp_path / "nowhere")
    with pytest.raises(FileError, match=r"a worker finds no folder .*nowhere") as caught:
        work(job)
    assert "same files" in caught.value.hint
