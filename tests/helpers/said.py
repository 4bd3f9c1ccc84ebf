"""What the sessions of tests/messages call: short records and questions, read as users' are."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from helpers.questions import changed

import vibro
from vibro.inverse.reading import read_spec
from vibro.records.reading import Record, read_record
from vibro.records.signals import read_sensitivities


def record(*rows: str | bytes, sensitivity: str | list[str] = "", **columns: str) -> Record:
    """Read a table of these rows, or of these bytes."""
    data = b"".join(row if isinstance(row, bytes) else f"{row}\n".encode() for row in rows)
    Path("data.csv").write_bytes(data)
    texts = [sensitivity] if isinstance(sensitivity, str) else sensitivity
    return read_record(Path("data.csv"), columns, read_sensitivities([text for text in texts if text]))


def table(
    count: int, cells: Mapping[int, str] | None = None, times: Mapping[int, float] | None = None
) -> list[str]:
    """Write a table whose rows of data are numbered from 2, with other cells or times in some of them."""
    clock = {row: (row - 2) / 600.0 for row in range(2, count + 2)} | dict(times or {})
    return ["t [s],x [mm]", *(f"{clock[row]:.6f},{(cells or {}).get(row, row)}" for row in clock)]


def volts(*sensitivities: str, **columns: str) -> Record:
    """Read a table with a voltage."""
    rows = ("t [s],x [mm],u [mV]", "0,1,100", "1,2,200", "2,3,300")
    return record(*rows, sensitivity=[*sensitivities], **columns)


BOWL = vibro.Scene(
    along_amplitude=3e-3, normal_amplitude=1e-3, normal_phase=-1.0, frequency=25.0, static_friction=0.4,
    kinetic_friction=0.3,
)  # fmt: skip


def question(**entries: Any) -> None:
    """Read a good question with other entries."""
    read_spec(changed(**entries))
