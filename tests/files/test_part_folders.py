"""The folder that ``-o`` names for a table in parts."""

from __future__ import annotations

from pathlib import Path

import pytest

from vibro.errors import InputError
from vibro.files.part_sets import part_folder


@pytest.mark.parametrize(
    ("output", "folder"),
    [
        (None, "nut"),
        ("out", "out"),
        ("out/wide/", "out/wide"),
        ("run1.5", "run1.5"),
        (".", "."),
        ("a.d", "a.d"),
    ],
)
def test_the_output_is_the_folder(output: str | None, folder: str) -> None:
    assert part_folder(output, "nut") == Path(folder)


@pytest.mark.parametrize(
    ("output", "hint"),
    [
        ("-", "give it a name, such as -o out/wide"),
        ("", "give it a name, such as -o out/wide"),
        ("a\0b", "give it a name, such as -o out/wide"),
        ("out/nut.csv", "write -o out/nut"),
        ("nut.parquet", "write -o nut"),
        ("nut.JSON", "write -o nut"),
        ("run1.5.csv", "write -o run1.5"),
    ],
)
def test_what_cannot_be_a_folder_is_refused(output: str, hint: str) -> None:
    with pytest.raises(InputError, match="parts go into a folder") as caught:
        part_folder(output, "nut")
    assert caught.value.hint == hint
