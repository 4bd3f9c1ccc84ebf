"""What docs/scale.md says of programs that read the parts of a sweep."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Any

import duckdb
import numpy as np
import pandas as pd
import polars
import pytest
import xarray as xr

import vibro

SCALE = (Path(__file__).parents[2] / "docs" / "scale.md").read_text(encoding="utf-8")


READERS = re.findall(r"```python\n(.*?)```", SCALE, flags=re.DOTALL)


@pytest.mark.parametrize("code", READERS, ids=["pandas", "duckdb", "polars", "vibro", "xarray"])
def test_what_the_docs_say_of_readers_runs(
    code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    given: dict[str, Any] = {"amplitude_mm": [0.5, 1, 2], "frequency_hz": "10:40:7", "drive_angle_deg": 20}
    given |= {"static_friction": [0.3, 0.6], "friction_ratio": 0.8, "part_cells": 10}
    frame = vibro.write_sweep("DIR", **given).to_frame()
    lines = ast.parse(code)
    answer = lines.body.pop()
    assert isinstance(answer, ast.Expr)
    names: dict[str, Any] = {}
    exec(compile(lines, "docs/scale.md", "exec"), names)
    found = eval(compile(ast.Expression(answer.value), "docs/scale.md", "eval"), names)
    if isinstance(found, pd.DataFrame):
        assert len(found) == np.sum(frame["amplitude_mm"] < 1) > 0
    elif isinstance(found, polars.DataFrame):
        assert found["throw_number"].to_list() == [k for k in frame["throw_number"] if k > 1] != []
    elif isinstance(found, duckdb.DuckDBPyRelation):
        most = frame[frame["amplitude_mm"] < 1].groupby("regime", observed=True)["throw_number"].max()
        assert dict(found.fetchall()) == most.to_dict()
    elif isinstance(found, xr.DataArray):
        hops = frame["regime"].astype("str") == "hopping"
        shares = hops.groupby([frame["amplitude_mm"], frame["static_friction"]]).mean()
        np.testing.assert_allclose(found.values.ravel(), shares, rtol=1e-12)
        assert 0 < found.mean() < 1
        with xr.open_dataset("wide.nc", engine="h5netcdf") as cells:
            assert cells.regime.size == len(frame)
    else:
        assert Path("regime.png").read_bytes().startswith(b"\x89PNG")


def test_the_drives_that_the_docs_rank(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    given: dict[str, Any] = {"amplitude_mm": "0.5:2:7", "frequency_hz": "15:30:4", "drive_angle_deg": 20}
    given |= {"static_friction": [0.3, 0.6], "friction_ratio": [0.7, 0.8]}
    frame = vibro.write_sweep("DIR", **given).to_frame()
    (query,) = re.findall(r"```sql\n(.*?)```", SCALE, flags=re.DOTALL)
    slowest = []
    for _, parts in frame.groupby(["amplitude_mm", "frequency_hz", "drive_angle_deg"]):
        if not (parts["regime"] == "hopping").any():
            slowest.append(parts["mean_velocity_mm_s"].min())
    ranked = [row[-1] for row in duckdb.sql(query).fetchall()]
    assert ranked == sorted(slowest, reverse=True)[:10]
    assert 10 < len(slowest) < len(frame) / 4
