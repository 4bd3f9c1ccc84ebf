"""Sweeps as labelled arrays: the numbers of the frame, through netCDF and back, and read block by block."""

from __future__ import annotations

import os
import shutil
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from helpers.plans import store, swept

import vibro
from vibro.errors import FileError, InputError
from vibro.tables import shard_files

if TYPE_CHECKING:
    from pathlib import Path

    from vibro.sweeps.whole import Sweep
    from vibro.tables.stored import StoredSweep

HARMONICS = """
along_amplitudes_mm = [1, 0.2, 0.1]
along_phases_deg = [5, 30, 10]
normal_amplitude_mm = 0.3
"""
STEPS = "\n[motion]\nalong_steps = [[0.8, 2.4], [0.2, -9.6]]\n"
SCENE = "[scene]\nfrequency_hz = 20\nstatic_friction = 0.4\nkinetic_friction = 0.3\n"

# What each case is, how it is swept, and its dimensions.
CASES: dict[str, tuple[dict[str, Any], dict[str, int]]] = {
    "one point": ({}, {}),
    "three axes": (
        {"friction_ratio": [0.5, 0.9, 1.2], "amplitude_mm": "0.2:6:4", "restitution": [0, 0.3]},
        {"friction_ratio": 3, "amplitude_mm": 4, "restitution": 2},
    ),
    "regimes": ({"amplitude_mm": [0.1, 1, 6], "output": "regimes"}, {"amplitude_mm": 3}),
    "starts": ({"amplitude_mm": "2:6:4", "starts": 16}, {"amplitude_mm": 4}),
}


def texts(coded: xr.DataArray) -> list[str]:
    """Decode codes by their attributes alone, as another reader of netCDF would, to the texts of tables."""
    meanings = coded.attrs["flag_meanings"].split(" ")
    words = dict(zip(coded.attrs["flag_values"].tolist(), meanings, strict=True))
    return ["" if words[code] == "none" else words[code].replace("_", "-") for code in coded.values.ravel()]


def check(found: xr.Dataset, frame: pd.DataFrame) -> None:
    """Compare with a data frame of the same cells."""
    for name, column in frame.items():
        cells = found[str(name)].broadcast_like(found.status)
        if name == "coexists":
            flags = [{"yes": 1, "no": 0, "unknown": pd.NA}[text] for text in texts(found[name])]
            assert column.tolist() == flags
        elif name == "pattern":
            assert cells.values.ravel().tolist() == column.tolist()
        elif isinstance(column.dtype, pd.CategoricalDtype):
            assert texts(cells) == column.tolist(), name
        else:
            cells = cells.transpose(*found.status.dims)
            np.testing.assert_array_equal(cells.values.ravel(), column, err_msg=str(name))


def comes_back(dataset: xr.Dataset, path: Path) -> None:
    """Write to netCDF and read what was written."""
    dataset.to_netcdf(path, engine="h5netcdf")
    with xr.open_dataset(path, engine="h5netcdf") as read:
        xr.testing.assert_identical(read.load(), dataset.compute())
        assert list(read.coords) == list(dataset.coords)


@pytest.mark.parametrize("name", CASES)
def test_every_number_of_the_frame_comes_back_from_netcdf(name: str, tmp_path: Path) -> None:
    given, sizes = CASES[name]
    solved = swept(**given)
    dataset = solved.to_xarray()
    assert dict(dataset.sizes) == sizes
    check(dataset, solved.to_frame())
    if name in ("one point", "three axes"):
        comes_back(dataset, tmp_path / "sweep.nc")
    for key, value in solved.fixed.items():
        assert dataset[key].shape == ()
        assert dataset[key] == value
    assert dataset.attrs["flight"] == (given.get("flight", True) and name != "regimes")
    assert dataset.attrs.get("starts") == (16 if name == "starts" else None)
    assert dataset.attrs["accuracy"] == given.get("output", "exact")
    back = store(solved, tmp_path / "stored", shard_cells=13, row_group_cells=5)
    xr.testing.assert_identical(vibro.open_sweep(back).to_xarray(chunks="auto").compute(), dataset)


@pytest.mark.parametrize(("drive", "key"), [(HARMONICS, "along_amplitude_3_mm"), (STEPS, "motion_scale")])
def test_drives_of_scene_files_are_told_whole(drive: str, key: str, tmp_path: Path) -> None:
    scene = tmp_path / "shaker.toml"
    scene.write_text(SCENE + drive, encoding="utf-8")
    solved = vibro.sweep(scene, frequency_hz="2:30:6")
    dataset = solved.to_xarray()
    check(dataset, solved.to_frame())
    if drive is STEPS:
        comes_back(dataset, tmp_path / "sweep.nc")
    stored = vibro.open_sweep(store(solved, tmp_path / "sweep"))
    assert stored.fixed == solved.fixed
    pd.testing.assert_frame_equal(stored.to_frame(), solved.to_frame())
    assert {key, *solved.fixed} < set(dataset.coords)
    assert dataset.attrs["title"] == "shaker: sweep of frequency_hz"
    assert dataset.attrs.get("motion") == (
        '{"along_steps": [[0.8, 2.4], [0.2, -9.6]]}' if drive is STEPS else None
    )


def test_attributes_are_those_of_the_cf_conventions() -> None:
    dataset = swept(amplitude_mm=[0.1, 1], trough_length_mm=600).to_xarray()
    assert dataset.attrs["Conventions"] == "CF-1.11"
    assert dataset.attrs["source"] == f"vibro {vibro.__version__}"
    spelled = {name: x.attrs["units"] for name, x in dataset.variables.items() if "units" in x.attrs}
    assert spelled["amplitude_mm"] == spelled["trough_length_mm"] == "mm"
    assert (spelled["frequency_hz"], spelled["drive_angle_deg"]) == ("Hz", "degree")
    assert (spelled["gravity_m_s2"], spelled["static_friction"]) == ("m s-2", "1")
    assert (spelled["mean_velocity_mm_s"], spelled["traverse_time_s"]) == ("mm s-1", "s")
    assert dataset.variables.keys() - spelled.keys() == {"regime", "pattern", "coexists", "model", "status"}
    assert dataset.mean_velocity_mm_s.attrs["long_name"] == "mean conveying speed"
    assert all(x.attrs["long_name"] and not set(x.attrs["long_name"]) & set("$`:;") for x in dataset.values())
    assert np.isnan(dataset.traverse_time_s.sel(amplitude_mm=0.1))
    some = swept(amplitude_mm=[0.5, 1.5]).to_xarray(["stroke_mm", "acceleration_g", "amplitude_mm"])
    assert list(some) == ["stroke_mm", "acceleration_g"]
    np.testing.assert_array_equal(some.stroke_mm, [1, 3])
    assert some.acceleration_g.attrs["units"] == "1"  # g is a gram in UDUNITS


@pytest.fixture(scope="module")
def held() -> Sweep:
    """Hold 924 cells of which some hop, and whose patterns differ from file to file."""
    axes: dict[str, Any] = {"amplitude_mm": "0.2:6:11", "frequency_hz": "5:25:7"}
    return swept(**axes, drive_angle_deg=[20, 70, 85], trough_angle_deg="-4:8:4")


@pytest.fixture(scope="module")
def stored(held: Sweep, tmp_path_factory: pytest.TempPathFactory) -> StoredSweep:
    """Store them in 10 files of 100 cells: an amplitude has 84."""
    return vibro.open_sweep(store(held, tmp_path_factory.mktemp("stored") / "wide"))


def test_blocks_are_read_when_they_are_computed_with(
    held: Sweep, stored: StoredSweep, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[int] = []
    really = shard_files._rows

    def noting(path: Path, *more: Any) -> Any:
        opened.append(int(path.stem[-6:]))
        return really(path, *more)

    monkeypatch.setattr(shard_files, "_rows", noting)
    lazy = stored.to_xarray(chunks={"A": 2, "frequency": 7})
    assert opened == []
    assert lazy.regime.chunks == ((2, 2, 2, 2, 2, 1), (7,), (3,), (4,))
    # The second block is cells 168 to 335.
    speed = lazy.mean_velocity_mm_s.isel(amplitude_mm=3, trough_angle_deg=1)
    whole = held.to_xarray()
    np.testing.assert_array_equal(speed, whole.mean_velocity_mm_s.isel(amplitude_mm=3, trough_angle_deg=1))
    assert sorted(opened) == [1, 2, 3]
    xr.testing.assert_identical(lazy.compute(), whole)
    filters: dict[str, Any] = {"alpha": [20, 85], "A": (0.2, 3), "f": 15}
    expected = whole.sel(frequency_hz=[15], drive_angle_deg=[20, 85]).sel(amplitude_mm=slice(0.2, 3))
    for chunks in (None, {"amplitude_mm": 1}):
        found = stored.to_xarray(filters, ["regime", "pattern"], chunks=chunks)
        xr.testing.assert_identical(found.compute(), expected[["regime", "pattern"]])


def test_files_are_found_from_another_folder_and_damage_is_told(
    held: Sweep, stored: StoredSweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(stored._shards.folder, tmp_path / "wide")
    lazy = vibro.open_sweep("wide").to_xarray(chunks={"A": 1})
    monkeypatch.chdir("/")
    assert lazy.throw_number.max() == held.to_xarray().throw_number.max()
    (tmp_path / "wide" / "part-000003.parquet").unlink()
    assert lazy.throw_number[0].max() > 0
    with pytest.raises(FileError, match=r"part-000003.parquet is missing"):
        lazy.throw_number.max().compute(scheduler="synchronous")  # else others still read


def test_what_memory_does_not_hold_is_read_in_blocks(
    stored: StoredSweep, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = os.sysconf
    monkeypatch.setattr("os.sysconf", lambda name: 1 if name == "SC_PHYS_PAGES" else real(name))
    with pytest.raises(InputError, match=r"11 x 7 x 3 x 4 = 924 cells take about .* GB") as caught:
        stored.to_xarray()
    assert 'chunks="auto"' in caught.value.hint
    assert stored.to_xarray({"A": 0.2}, ["throw_number"]).throw_number.shape == (1, 7, 3, 4)
    assert stored.to_xarray(chunks="auto").throw_number.shape == (11, 7, 3, 4)
