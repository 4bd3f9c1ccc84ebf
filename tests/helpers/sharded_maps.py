"""What the tests of ``vibro map --table parquet`` share."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd
from helpers.commands import NUT_ANGLE_AND_FRICTION

if TYPE_CHECKING:
    from typer.testing import Result

AXES = ("map", "-A", "0.5:2:3", "-f", "10:30:3", *NUT_ANGLE_AND_FRICTION)
QUICK = (*AXES, "--regimes-only")
SHARDED = (*QUICK, "--table", "parquet", "--shard-cells", "4")
SHARD_NAMES = ["part-000000.parquet", "part-000001.parquet", "part-000002.parquet"]
WHOLE = ["_SUCCESS", "_manifest.json", *SHARD_NAMES]


def names(folder: str = "out") -> list[str]:
    return sorted(path.name for path in Path(folder).iterdir())


def frame(folder: str = "out") -> pd.DataFrame:
    return pd.concat([pd.read_parquet(path) for path in sorted(Path(folder).glob("part-*.parquet"))])


def told(name: str = "_SUCCESS", folder: str = "out") -> dict[str, Any]:
    content: dict[str, Any] = json.loads((Path(folder) / name).read_text(encoding="utf-8"))
    return content


def contents(folder: str = "out") -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


def error(result: Result) -> list[str]:
    """Return what a run says that fails, without the echo of its axes."""
    return [line for line in result.stderr.splitlines() if line.startswith(("error: ", "hint: "))]
