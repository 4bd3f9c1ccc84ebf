"""Small tables as engineers write them, read as records."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vibro.errors import InputError
from vibro.records.reading import Record, read_record

TIMES = np.arange(6) / 600.0
POSITIONS = np.array([0.0, 0.25, 1.0, 1.5, -0.125, 2.0])  # [mm]


def lines(separator: str = ",", header: str = "Time [s],X [mm]", comma: bool = False) -> list[str]:
    rows = [f"{t!r}{separator}{x!r}" for t, x in zip(TIMES.tolist(), POSITIONS.tolist(), strict=True)]
    if comma:
        rows = [row.replace(".", ",") for row in rows]
    return [header, *rows]


def read(folder: Path, content: list[str] | bytes, newline: str = "\n", **columns: str) -> Record:
    path = folder / "data.csv"
    data = content if isinstance(content, bytes) else (newline.join(content) + newline).encode()
    path.write_bytes(data)
    return read_record(path, columns)


def refusal(folder: Path, content: list[str] | bytes, **columns: str) -> InputError:
    with pytest.raises(InputError) as caught:
        read(folder, content, **columns)
    return caught.value
