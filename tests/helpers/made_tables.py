"""Small tables as engineers write them, read as records."""

from __future__ import annotations

from pathlib import Path

from vibro.records.reading import Record, read_record


def read(folder: Path, content: list[str] | bytes, newline: str = "\n", **columns: str) -> Record:
    path = folder / "data.csv"
    data = content if isinstance(content, bytes) else (newline.join(content) + newline).encode()
    path.write_bytes(data)
    return read_record(path, columns)
