"""Sweeps in Parquet files, read: as frames, as pictures, by others; and what is refused."""

from __future__ import annotations

import json
import shutil
import sys
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from helpers.cases import each
from helpers.pixels import pixels
from helpers.plans import store, swept

import vibro
from vibro.core.codes import Regime
from vibro.errors import FileError

if TYPE_CHECKING:
    from vibro.sweeps.whole import Sweep
    from vibro.tables.stored import StoredSweep


@pytest.fixture(scope="module")
def held() -> Sweep:
    """Hold cells of which some hop, and whose patterns differ from shard to shard."""
    axes: dict[str, Any] = {"amplitude_mm": "0.2:6:11", "frequency_hz": "5:25:7"}
    axes |= {"drive_angle_deg": [20, 70, 85], "trough_angle_deg": "-4:8:4"}
    return swept(**axes, trough_length_mm=600)


@pytest.fixture(scope="module")
def folder(held: Sweep, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return store(held, tmp_path_factory.mktemp("sweeps") / "nut")


@pytest.fixture
def stored(folder: Path) -> StoredSweep:
    return vibro.open_sweep(folder)


def test_all_cells_are_those_of_a_sweep_that_is_held(held: Sweep, stored: StoredSweep) -> None:
    frame = held.to_frame()
    assert {"_", "F_", "hopping"} <= {*frame["pattern"], *frame["status"], *frame["regime"]}
    assert frame["coexists"].isna().any()
    pd.testing.assert_frame_equal(stored.to_frame(), frame)
    assert list(frame["regime"].cat.categories) == [*(regime.label for regime in Regime if regime >= 0), ""]
    assert repr(stored) == repr(held).replace("Sweep", "StoredSweep")
    assert (stored.shape, stored.fixed, stored.columns) == (held.shape, held.fixed, tuple(frame))
    for name, values in held.axes.items():
        np.testing.assert_array_equal(stored.axes[name], values)


@each(
    ("filters", "kept"),
    [
        ({"f": 15}, {"frequency_hz": [15]}),
        ({"frequency_hz": "900rpm", "beta": (0, 4)}, {"frequency_hz": [15], "trough_angle_deg": [0, 4]}),
        ({"alpha": [20, 85], "A": (0.2, 0.78)}, {"drive_angle_deg": [20, 85], "amplitude_mm": [0.2, 0.78]}),
        ({"amplitude": np.array([0.2, 6])}, {"amplitude_mm": [0.2, 6]}),
        ({"stroke_mm": ["0.4", 12]}, {"amplitude_mm": [0.2, 6]}),
        ({"A": (5.42, None), "f": (None, 5)}, {"amplitude_mm": [5.42, 6], "frequency_hz": [5]}),
        ({"beta": (-9, -4), "alpha": [20.0001]}, {"trough_angle_deg": [-4], "drive_angle_deg": [20]}),
    ],
)
def test_filters_keep_cells_in_their_order(
    held: Sweep, stored: StoredSweep, filters: dict[str, Any], kept: dict[str, list[float]]
) -> None:
    frame = held.to_frame()
    for name, values in kept.items():
        frame = frame[frame[name].isin(values)]
    assert len(frame)
    expected = frame.reset_index(drop=True)
    expected["pattern"] = expected["pattern"].cat.remove_unused_categories()
    pd.testing.assert_frame_equal(stored.to_frame(filters), expected)


def test_only_what_is_needed_is_read(stored: StoredSweep, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[tuple[int, list[int], list[str]]] = []
    whole = pq.ParquetFile.read_row_groups

    def noting(file: pq.ParquetFile, groups: list[int], columns: list[str]) -> Any:
        first = json.loads(file.metadata.metadata[b"vibro"])["first_cell"]
        read.append((first // 100, groups, columns))
        return whole(file, groups, columns)

    monkeypatch.setattr(pq.ParquetFile, "read_row_groups", noting)
    # A value of the amplitude is 84 cells: the third of them is cells 168 to 251.
    wanted = ["regime", "mean_velocity_mm_s"]
    stored.to_frame({"A": 1.36}, wanted)
    assert read == [(1, [1, 2], wanted), (2, [0, 1], wanted)]
    stored.draw("speed", x="beta", at={"A": 0.2, "f": 5})
    assert (len(read), read[2][:2], "pattern" in read[2][2]) == (3, (0, [0]), False)


def test_pictures_are_those_of_a_sweep_that_is_held(held: Sweep, stored: StoredSweep) -> None:
    how: dict[str, Any] = {"x": "A", "y": "beta", "at": {"alpha": 20, "f": 25}}
    np.testing.assert_array_equal(pixels(stored.draw("speed", **how)), pixels(held.draw("speed", **how)))


def test_what_is_no_finished_sweep_is_refused(folder: Path, held: Sweep, tmp_path: Path) -> None:
    copy = Path(shutil.copytree(folder, tmp_path / "copy"))

    def refused(problem: str) -> None:
        with pytest.raises(FileError, match=problem) as caught:
            vibro.open_sweep(copy)
        assert caught.value.hint

    success, there = copy / "_SUCCESS", (copy / "_SUCCESS").read_text(encoding="utf-8")
    other = store(held, tmp_path / "other", columns=["regime"]) / "_SUCCESS"
    changed = there.replace('"cells": 924', '"cells": 9'), other.read_text(encoding="utf-8")
    for text in ("", "[]", "[" * 100_000, there[:-20], *changed):
        success.write_text(text, encoding="utf-8")
        refused("_SUCCESS is damaged")
    (copy / "_manifest.json").unlink()
    refused("holds no sweep")
    shutil.rmtree(copy)
    refused("is not there")
    copy.touch()
    refused("is no folder")


def test_a_shard_that_is_not_what_was_written_is_refused_where_it_is_read(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    name = "~" if sys.platform == "win32" else "s3:"  # which mean something elsewhere
    stored = vibro.open_sweep(shutil.copytree(folder, name))
    assert len(stored.to_frame(columns=["regime"])) == 924
    path = Path(name, "part-000003.parquet")
    whole, neighbour = path.read_bytes(), path.with_name("part-000002.parquet").read_bytes()
    for content in (b"", whole[:1000], whole[:50] + whole[51:], neighbour):
        path.write_bytes(content)
        with pytest.raises(FileError, match=r"part-000003\.parquet is damaged: ") as caught:
            stored.to_frame()
        assert "goes on" in caught.value.hint
        assert len(stored.to_frame({"A": 0.2})) == 84
    path.unlink()
    with pytest.raises(FileError, match=r"part-000003\.parquet is missing"):
        stored.to_frame()


def test_no_flipped_bit_gives_other_numbers(tmp_path: Path) -> None:
    """Of pages, their headers and the footer; all bits of a shard were tried once.

    The checksums of pages leave out their headers: with more values there, cells of the next row group come.
    """
    held = swept(amplitude_mm="0.2:6:4", frequency_hz=[5, 15, 25])
    stored = vibro.open_sweep(store(held, tmp_path / "out", shard_cells=12, row_group_cells=8))
    path, wanted, refused = tmp_path / "out" / "part-000000.parquet", held.to_frame(), 0
    whole, group = path.read_bytes(), pq.read_metadata(path).row_group(0)
    footer = len(whole) - 8 - int.from_bytes(whole[-8:-4], "little")
    bits = [(i, i % 8) for i in (*range(0, footer, 57), *range(footer, len(whole), 401))]
    for page in (group.column(0).data_page_offset, group.column(6).dictionary_page_offset):
        bits += product(range(page, page + 40), (0, 3, 6))
    for i, bit in bits:
        path.write_bytes(whole[:i] + bytes([whole[i] ^ 1 << bit]) + whole[i + 1 :])
        try:
            pd.testing.assert_frame_equal(stored.to_frame(), wanted)
        except FileError:
            refused += 1
    assert len(bits) > refused > 300
