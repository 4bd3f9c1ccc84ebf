"""Programs that read Parquet take a sweep folder as it is; what guide/scale.md says of them runs."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import pytest
from helpers.plans import store, swept
from pyarrow import parquet

import vibro

if TYPE_CHECKING:
    from collections.abc import Callable

SCALE = (Path(__file__).parents[2] / "docs" / "guide" / "scale.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Store a sweep whose patterns differ from shard to shard."""
    solved = swept(
        amplitude_mm="0.2:6:5", frequency_hz="5:25:3", drive_angle_deg=[20, 70], trough_angle_deg="-4:4:3"
    )
    return store(solved, tmp_path_factory.mktemp("sweeps") / "wide.parquet", shard_cells=20)


READERS: dict[str, Callable[[Any, str], pd.DataFrame]] = {
    "pandas": lambda pandas, folder: pandas.read_parquet(folder),
    "pyarrow.dataset": lambda dataset, folder: dataset.dataset(folder).to_table().to_pandas(),
    "dask.dataframe": lambda dataframe, folder: dataframe.read_parquet(folder).compute(),
    "duckdb": lambda duckdb, folder: duckdb.sql(f"from '{folder}/*.parquet'").df(),
    "polars": lambda polars, folder: polars.scan_parquet(f"{folder}/*.parquet").collect().to_pandas(),
}


@pytest.mark.filterwarnings("ignore:The inplace keyword")  # how Dask calls pandas
@pytest.mark.parametrize("reader", READERS)
def test_other_programs_read_all_rows(folder: Path, reader: str) -> None:
    """Texts of each shard have a dictionary of their own."""
    dictionaries = {
        tuple(parquet.read_table(path)["pattern"].combine_chunks().dictionary.to_pylist())
        for path in folder.glob("*.parquet")
    }
    assert len(dictionaries) > 2
    whole, frame = vibro.open_sweep(folder).to_frame(), READERS[reader](import_module(reader), str(folder))
    assert len(frame) == len(whole) == 90
    assert list(frame.columns) == list(whole.columns)
    for name, column in whole.items():
        if isinstance(column.dtype, pd.CategoricalDtype):
            assert frame[name].tolist() == column.tolist(), name
        else:
            found, wanted = (x.to_numpy(float, na_value=np.nan) for x in (frame[name], column))
            np.testing.assert_array_equal(found, wanted, err_msg=str(name))


def test_what_the_docs_say_of_readers_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("vibro.tables.plan._SHARD_CELLS", 10)
    given: dict[str, Any] = {"amplitude_mm": "0.5:2:3", "frequency_hz": "10:40:7", "drive_angle_deg": 20}
    given |= {"static_friction": [0.3, 0.6], "friction_ratio": 0.8}
    cells = vibro.write_sweep("wide.parquet", **given).shape
    examples = re.findall(r"```python\n(.*?)```", SCALE, flags=re.DOTALL)
    assert len(examples) == 5
    for code in examples:
        exec(compile(code, "docs/guide/scale.md", "exec"), {})
    assert Path("regime.png").read_bytes().startswith(b"\x89PNG")
    with import_module("xarray").open_dataset("wide.nc", engine="h5netcdf") as found:
        assert found.regime.size == np.prod(cells)


def test_the_drives_that_the_docs_rank(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    given: dict[str, Any] = {"amplitude_mm": "0.5:2:7", "frequency_hz": "15:30:4", "drive_angle_deg": 20}
    given |= {"static_friction": [0.3, 0.6], "friction_ratio": [0.7, 0.8]}
    frame = vibro.write_sweep("wide.parquet", **given).to_frame()
    (query,) = re.findall(r"```sql\n(.*?)```", SCALE, flags=re.DOTALL)
    slowest = []
    for _, parts in frame.groupby(["amplitude_mm", "frequency_hz", "drive_angle_deg"]):
        if not (parts["regime"] == "hopping").any():
            slowest.append(parts["mean_velocity_mm_s"].min())
    ranked = [row[-1] for row in import_module("duckdb").sql(query).fetchall()]
    assert ranked == sorted(slowest, reverse=True)[:10]
    assert 10 < len(slowest) < len(frame) / 4
