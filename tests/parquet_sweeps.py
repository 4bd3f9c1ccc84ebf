"""Directories of Parquet parts, written from a sweep that is held."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from vibro.sweeps.whole import Sweep


def store(
    t: Sweep,
    folder: Path,
    *,
    columns: Sequence[str] | None = None,
    part_cells: int = 100,
    row_group_cells: int = 40,
) -> Path:
    """Write a sweep as ``vibro map --table parquet`` does."""
    folder.mkdir(parents=True)
    frame, grid = t.to_frame(columns), t._grid
    starts = range(0, len(frame), part_cells)
    parts = [
        {"file": f"part-{i:06}.parquet", "first_cell": start, "cells": min(part_cells, len(frame) - start)}
        for i, start in enumerate(starts)
    ]
    manifest: dict[str, Any] = {
        "format": "vibro sweep 1",
        "fingerprint": f"{t._title} {grid.shape}",
        "argv": ["map", "nut.toml"],
        "versions": {},
        "name": t._title,
        "axes": [
            {"column": axis.column, "spacing": axis.spacing, "values": axis.values.tolist()}
            for axis in grid.axes.values()
        ],
        "scene": t.fixed,
        "own": dict(t._own),
        "accuracy": grid.level.value,
        "flight": grid.flight,
        "coexistence": grid.coexistence,
        "part": {},
        "digits": None,
        "columns": dict.fromkeys(frame.columns, ""),
        "cells": len(frame),
        "part_cells": part_cells,
        "row_group_cells": row_group_cells,
        "parts": parts,
    }
    for number, part in enumerate(parts):
        start = int(str(part["first_cell"]))
        footer = {"fingerprint": manifest["fingerprint"], "part": number, **part}
        rows = [
            _table(frame.iloc[i : min(i + row_group_cells, start + int(str(part["cells"])))])
            for i in range(start, start + int(str(part["cells"])), row_group_cells)
        ]
        with pq.ParquetWriter(
            folder / str(part["file"]), rows[0].schema, compression="zstd", write_page_checksum=True
        ) as writer:
            for table in rows:
                writer.write_table(table)
            writer.add_key_value_metadata({"vibro": json.dumps(footer)})
    (folder / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    success = {"cells": len(frame), "parts": len(parts), "status": {"ok": len(frame)}, "regime": {}}
    (folder / "_SUCCESS").write_text(json.dumps(success), encoding="utf-8")
    return folder


def _table(frame: pd.DataFrame) -> pa.Table:
    """Make a table of rows, whose dictionaries hold the texts of these rows alone."""
    arrays = []
    for name in frame.columns:
        column = frame[name]
        if isinstance(column.dtype, pd.CategoricalDtype):
            texts = pa.array(column.astype(object)).dictionary_encode()
            arrays.append(pa.DictionaryArray.from_arrays(texts.indices.cast(pa.int16()), texts.dictionary))
        else:
            arrays.append(pa.array(column, from_pandas=True))
    return pa.Table.from_arrays(arrays, names=list(frame.columns))
