"""What may be called the stem of output files."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from helpers.cases import each

from vibro.axes import parse_axis
from vibro.cli.stems import output_stem
from vibro.errors import FileError, InputError, printable
from vibro.output.names import PICTURES, suffixed
from vibro.plots import choose_view, picture_names
from vibro.plots.design import DESIGN_PICTURES
from vibro.quantities import QUANTITIES


def test_suffixes_are_appended_whatever_dots_the_stem_has(tmp_path: Path) -> None:
    assert suffixed(output_stem("out/run1.5", "nut"), ".csv") == Path("out/run1.5.csv")
    assert output_stem(None, "nut") == Path("nut")
    assert output_stem("out/", "nut") == Path("out/nut")
    assert output_stem("out/.", "nut") == Path("out/nut")
    assert output_stem(str(tmp_path), "nut") == tmp_path / "nut"
    assert output_stem(f"{tmp_path}/..", "nut") == tmp_path / ".." / "nut"
    assert output_stem(str(tmp_path / "new"), "nut") == tmp_path / "new"


@each(
    ("output", "hint"),
    [
        ("l/res.csv", "write -o l/res, which makes l/res.csv"),
        ("m.JSON", "write -o m, which makes m.json"),
        ("a b.v2.png", "write -o a b.v2, which makes a b.v2.csv"),
        ("", "give a name for the files, such as -o out/nut"),
        ("..csv", "give a name for the files, such as -o out/nut"),
        (".svg", "give a name for the files, such as -o out/nut"),
        ("x/.pdf", "give a name for the files, such as -o out/nut"),
        ("no/such/..", "give a name for the files, such as -o out/nut"),
        ("a\0b", "give a name for the files, such as -o out/nut"),
    ],
)
def test_a_name_that_is_no_stem_is_refused_with_a_hint(output: str, hint: str) -> None:
    with pytest.raises(InputError) as caught:
        output_stem(output, "nut")
    assert caught.value.hint == hint
    assert printable(output) in str(caught.value)


def test_a_hint_names_the_table_that_is_made() -> None:
    for output in ("out/y.xlsx", "out/y.csv"):
        with pytest.raises(InputError) as caught:
            output_stem(output, "nut", "xlsx")
        assert caught.value.hint == "write -o out/y, which makes out/y.xlsx"


def test_a_name_that_is_too_long_is_named() -> None:
    with pytest.raises(FileError, match="xxxx"):
        output_stem("x" * 300, "nut")


@pytest.mark.skipif(sys.platform == "win32", reason="no devices among the files, no FIFOs")
def test_what_is_neither_a_file_nor_a_folder_is_refused_with_a_hint(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "fifo")
    for path in (Path(os.devnull), tmp_path / "fifo"):
        with pytest.raises(FileError, match="neither a file nor a folder") as caught:
            output_stem(str(path), "nut")
        assert caught.value.hint == "-o - writes the table to stdout"


def test_every_picture_with_a_name_is_known_by_it() -> None:
    axes = {name: parse_axis("1:2", QUANTITIES[name]).axis(3) for name in ("amplitude", "frequency")}
    of_maps = picture_names(choose_view(axes), has_length=True)
    assert set(PICTURES) == {*of_maps, *DESIGN_PICTURES, "response"}  # the last of ``vibro drive``
    assert len(set(PICTURES)) == len(PICTURES)
