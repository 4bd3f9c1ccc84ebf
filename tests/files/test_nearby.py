"""The file that was meant."""

from __future__ import annotations

from pathlib import Path

from vibro.files.nearby import suggestion


def test_the_closest_name_with_one_of_the_endings_is_suggested(tmp_path: Path) -> None:
    for name in ("nut.csv", "nut.toml", "NUTS.TXT", "feeder.csv"):
        (tmp_path / name).touch()
    assert suggestion(tmp_path / "nutt.csv", (".csv", ".txt")) == f"did you mean '{tmp_path / 'nut.csv'}'?"
    assert suggestion(tmp_path / "NUT.TXT", (".csv", ".txt")) == f"did you mean '{tmp_path / 'NUTS.TXT'}'?"
    assert suggestion(tmp_path / "nut.tml", (".toml",)) == f"did you mean '{tmp_path / 'nut.toml'}'?"


def test_without_a_close_name_nothing_is_suggested(tmp_path: Path) -> None:
    (tmp_path / "feeder.csv").touch()
    assert suggestion(tmp_path / "nut.csv", (".csv",)) == ""
    assert suggestion(tmp_path / "no folder" / "nut.csv", (".csv",)) == ""
