"""Sweeps in Parquet files, read: as frames, as pictures, by others; and what is refused."""

from __future__ import annotations

import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from helpers.cases import each
from helpers.drawn import coarse_pictures
from helpers.pixels import pixels
from helpers.plans import store, swept

import vibro
from vibro.core.codes import Status
from vibro.errors import FileError, InputError
from vibro.tables.shard_files import ShardFiles

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vibro.sweeps.whole import Sweep
    from vibro.tables.stored import StoredSweep

NUT: dict[str, Any] = {"static_friction": 0.74, "kinetic_friction": 0.57, "trough_length_mm": 600}


@pytest.fixture(scope="module", autouse=True)
def _coarse_pictures() -> Iterator[None]:
    """What is drawn matters here, not how well."""
    with coarse_pictures():
        yield


@pytest.fixture(scope="module")
def held() -> Sweep:
    """Hold cells of which some hop, and whose patterns differ from shard to shard."""
    return vibro.sweep(
        amplitude_mm="0.2:6:11",
        frequency_hz="5:25:7",
        drive_angle_deg=[20, 70, 85],
        trough_angle_deg="-4:8:4",
        **NUT,
    )


@pytest.fixture(scope="module")
def folder(held: Sweep, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return store(held, tmp_path_factory.mktemp("sweeps") / "nut")


@pytest.fixture
def stored(folder: Path) -> StoredSweep:
    return vibro.open_sweep(folder)


def test_it_covers_what_was_swept(held: Sweep, stored: StoredSweep) -> None:
    assert stored.shape == held.shape == (11, 7, 3, 4)
    assert list(stored.axes) == list(held.axes)
    for name, values in held.axes.items():
        np.testing.assert_array_equal(stored.axes[name], values)
    assert stored.fixed == held.fixed
    assert stored.columns == tuple(held.to_frame().columns)
    assert repr(stored) == repr(held).replace("Sweep", "StoredSweep")


def test_all_cells_are_those_of_a_sweep_that_is_held(held: Sweep, stored: StoredSweep) -> None:
    frame = held.to_frame()
    assert {"_", "F_", "hopping"} <= {*frame["pattern"], *frame["status"], *frame["regime"]}
    assert frame["coexists"].isna().any()
    pd.testing.assert_frame_equal(stored.to_frame(), frame)


def test_categories_are_in_the_order_of_physics(held: Sweep, stored: StoredSweep) -> None:
    other = pd.read_parquet(stored._shards.folder)
    for frame in (held.to_frame(), stored.to_frame(), stored.to_frame({"A": 0.2})):
        assert list(frame["regime"].cat.categories) == [
            "no-slip", "forward-slip", "back-slip", "hopping", "",
        ]  # fmt: skip
        assert list(frame["status"].cat.categories) == [status.label for status in Status]
        for name in ("regime", "model", "status"):
            assert list(frame[name].cat.categories) == list(other[name].cat.categories)


@each(
    ("filters", "kept"),
    [
        ({"f": 15}, {"frequency_hz": [15]}),
        ({"frequency_hz": "900rpm", "beta": (0, 4)}, {"frequency_hz": [15], "trough_angle_deg": [0, 4]}),
        ({"alpha": [20, 85], "A": (0.2, 0.78)}, {"drive_angle_deg": [20, 85], "amplitude_mm": [0.2, 0.78]}),
        ({"amplitude": np.array([0.2, 6])}, {"amplitude_mm": [0.2, 6]}),
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
    for name in expected.columns:
        if name == "pattern":
            expected[name] = expected[name].cat.remove_unused_categories()
    pd.testing.assert_frame_equal(stored.to_frame(filters), expected)


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, list[int], list[str]]]:
    """Note which row groups and columns are read of which shard."""
    noted: list[tuple[int, list[int], list[str]]] = []
    whole = pq.ParquetFile.read_row_groups

    def noting(file: pq.ParquetFile, groups: list[int], columns: list[str]) -> Any:
        first = json.loads(file.metadata.metadata[b"vibro"])["first_cell"]
        noted.append((first // 100, groups, columns))
        return whole(file, groups, columns)

    monkeypatch.setattr(pq.ParquetFile, "read_row_groups", noting)
    return noted


def test_only_what_is_needed_is_read(
    stored: StoredSweep, read: list[tuple[int, list[int], list[str]]]
) -> None:
    # A value of the amplitude is 84 cells: the third of them is cells 168 to 251.
    stored.to_frame({"A": 1.36}, ["regime", "mean_velocity_mm_s"])
    wanted = ["regime", "mean_velocity_mm_s"]
    assert read == [(1, [1, 2], wanted), (2, [0, 1], wanted)]
    read.clear()
    stored.to_frame({"A": 0.2, "f": 5}, ["status"])
    assert read == [(0, [0], ["status"])]
    read.clear()
    stored.draw("regime", x="beta", at={"A": 0.2, "f": 5})
    ((shard, groups, columns),) = read
    assert (shard, groups) == (0, [0])
    assert not {"pattern", "back_ratio"} & {*columns}


def test_pictures_are_those_of_a_sweep_that_is_held(held: Sweep, stored: StoredSweep) -> None:
    how: dict[str, Any] = {"x": "A", "y": "beta", "at": {"alpha": 20, "f": 25}}
    np.testing.assert_array_equal(pixels(stored.draw("speed", **how)), pixels(held.draw("speed", **how)))


def test_a_drive_of_listed_harmonics_is_read_whole(tmp_path: Path) -> None:
    scene = tmp_path / "shaker.toml"
    scene.write_text(
        "[scene]\nalong_amplitudes_mm = [1, 0.2, 0.1]\nalong_phases_deg = [5, 30, 10]\n"
        "normal_amplitude_mm = 0.3\nfrequency_hz = 20\nstatic_friction = 0.4\nkinetic_friction = 0.3\n",
        encoding="utf-8",
    )
    held = vibro.sweep(scene, frequency_hz="5:30:6")
    assert {"along_phase_deg", "along_amplitude_3_mm"} < held.fixed.keys()
    stored = vibro.open_sweep(store(held, tmp_path / "sweep"))
    assert stored.fixed == held.fixed
    pd.testing.assert_frame_equal(stored.to_frame(), held.to_frame())


def test_a_picture_without_its_columns_is_refused(tmp_path: Path) -> None:
    held = vibro.sweep(amplitude_mm="0.1:3:5", frequency_hz="5:40:5", drive_angle_deg=20, **NUT)
    columns = ["status", "regime", "mean_velocity_mm_s", "coexists"]
    stored = vibro.open_sweep(store(held, tmp_path / "sweep", columns=columns))
    assert stored.columns == tuple(columns)
    pd.testing.assert_frame_equal(stored.to_frame(), held.to_frame(columns))
    with pytest.raises(InputError, match="displacement_per_cycle_mm, period_cycles"):
        stored.draw("regime")


@pytest.fixture
def copy(folder: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(folder, tmp_path / "copy"))


SHARD = "part-000003.parquet"


def test_what_is_no_finished_sweep_is_refused(copy: Path, held: Sweep, tmp_path: Path) -> None:
    def refused(problem: str) -> None:
        with pytest.raises(FileError, match=problem) as caught:
            vibro.open_sweep(copy)
        assert caught.value.hint

    success = (copy / "_SUCCESS").read_text(encoding="utf-8")
    other = store(held, tmp_path / "other", columns=["regime"]) / "_SUCCESS"
    for text in (
        *("", "[]", "{}", "[" * 100_000, success[:-20], other.read_text(encoding="utf-8")),
        *(success.replace(*pair) for pair in (('"cells": 924', '"cells": 9'), ('"ok"', '"no"'), ("0", "1"))),
    ):
        assert text != success
        (copy / "_SUCCESS").write_text(text, encoding="utf-8")
        refused("_SUCCESS is damaged")
    (copy / "_SUCCESS").unlink()
    (copy / SHARD).unlink()
    refused("9 of 10")
    (copy / "_manifest.json").unlink()
    refused("holds no sweep")
    shutil.rmtree(copy)
    refused("is not there")
    copy.touch()
    refused("is no folder")


def test_a_shard_that_is_not_what_was_written_is_refused_where_it_is_read(copy: Path) -> None:
    stored, path, whole = vibro.open_sweep(copy), copy / SHARD, (copy / SHARD).read_bytes()
    resealed = pq.read_table(path).replace_schema_metadata(pq.read_metadata(path).metadata)
    pq.write_table(resealed, tmp := copy / "tmp")
    footer = len(whole) - 8 - int.from_bytes(whole[-8:-4], "little")
    contents = [
        *(b"", whole[:1000], whole[:-1000], whole[-1000:], b"x" * 1000, tmp.read_bytes()),
        *((copy / "part-000002.parquet").read_bytes(), whole[100:], whole[:50] + whole[51:]),
    ]
    for content in contents:
        path.write_bytes(content)
        with pytest.raises(FileError, match=f"{SHARD} is damaged: ") as caught:
            stored.to_frame()
        assert "goes on" in caught.value.hint
        assert len(stored.to_frame({"A": 0.2})) == 84
    path.unlink()
    with pytest.raises(FileError, match=f"{SHARD} is missing"):
        stored.to_frame()
    assert len(whole) > footer > 10_000


def test_no_flipped_bit_gives_other_numbers(tmp_path: Path) -> None:
    """Of pages, their headers and the footer; all bits of a shard were tried once."""
    held = swept(amplitude_mm="0.2:6:4", frequency_hz=[5, 15, 25])
    stored = vibro.open_sweep(store(held, tmp_path / "out", shard_cells=12, row_group_cells=8))
    path, wanted = tmp_path / "out" / "part-000000.parquet", held.to_frame()
    whole, refused = path.read_bytes(), 0
    footer = len(whole) - 8 - int.from_bytes(whole[-8:-4], "little")
    places = [*range(0, footer, 19), *range(footer, len(whole), 173)]
    for i in places:
        path.write_bytes(whole[:i] + bytes([whole[i] ^ (1 << i % 8)]) + whole[i + 1 :])
        try:
            pd.testing.assert_frame_equal(stored.to_frame(), wanted)
        except FileError:
            refused += 1
    assert len(places) > 250
    assert refused > 200


def test_a_filter_may_have_an_open_end(folder: Path) -> None:
    stored = vibro.open_sweep(folder)
    amplitudes = stored.axes["amplitude_mm"]
    assert len(stored.to_frame({"A": (None, None)})) == len(stored.to_frame())
    found = stored.to_frame({"A": (amplitudes[3], None)})["amplitude_mm"]
    assert sorted(set(found)) == list(amplitudes[3:])
    found = stored.to_frame({"A": (None, amplitudes[3])})["amplitude_mm"]
    assert sorted(set(found)) == list(amplitudes[:4])


@pytest.mark.parametrize("name", ["~", "file:x", "s3:"])
def test_names_that_mean_something_elsewhere_are_those_of_folders(
    copy: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if sys.platform == "win32" and ":" in name:
        pytest.skip("no name has a colon there")
    monkeypatch.chdir(copy.parent)
    copy.rename(name)
    assert len(vibro.open_sweep(name).to_frame(columns=["regime"])) == 924


def test_texts_that_this_version_does_not_know_are_told(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stored = vibro.open_sweep(copy)
    known = {"status": replace(stored._shards.columns["status"], texts=("ok",))}
    monkeypatch.setattr(ShardFiles, "columns", known)
    with pytest.raises(FileError, match=r"status = 'averaged': .* knows no such status"):
        stored.to_frame(columns=["status"])
