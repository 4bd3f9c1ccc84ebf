"""The file that was meant."""

from __future__ import annotations

from pathlib import Path

import pytest

from vibro.errors import FileError
from vibro.files.reading import content_of


def hint(path: Path, *endings: str) -> str:
    with pytest.raises(FileError, match="cannot read") as caught:
        content_of(path, endings)
    return caught.value.hint


def test_the_closest_name_with_one_of_the_endings_is_suggested(tmp_path: Path) -> None:
    for name in ("nut.csv", "nut.toml", "NUTS.TXT", "feeder.csv"):
        (tmp_path / name).touch()
    assert hint(tmp_path / "nutt.csv", ".csv", ".txt") == f"did you mean '{tmp_path / 'nut.csv'}'?"
    assert hint(tmp_path / "NUT.TXT", ".csv", ".txt") == f"did you mean '{tmp_path / 'NUTS.TXT'}'?"
    assert hint(tmp_path / "nut.tml", ".toml") == f"did you mean '{tmp_path / 'nut.toml'}'?"
    assert hint(tmp_path / "thermometer", ".csv") == ""
    assert hint(tmp_path / "no folder" / "nut.csv", ".csv") == ""
