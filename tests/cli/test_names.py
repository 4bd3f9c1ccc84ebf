"""Names of files are text: whole runs on files whose names are markup elsewhere, or no text at all."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import pytest
from helpers.made_records import EXAMPLES, STUDY_FILE
from PIL import Image

if TYPE_CHECKING:
    from helpers.commands import Run

# A name, and how the metadata of pictures tell it.
NAME = TOLD = r"a$_{x$ =cmd 振动🔩$\frac{x$"
if sys.platform == "linux":  # others have no such names
    NAME, TOLD = f"{NAME}\x1b[31m\x07\n\udce9", f"{TOLD}�[31m���"


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / f"{NAME}.toml"
    shutil.copy(EXAMPLES / "safety_nut.toml", path)
    return path


def titles(stem: str) -> list[str]:
    """Return the titles in the metadata of a picture as PNG and as SVG."""
    with Image.open(f"{stem}.png") as image:
        image.load()
        found = [image.info["Title"]]
    elements = ElementTree.parse(f"{stem}.svg").iter()
    return found + [e.text or "" for e in elements if e.tag.endswith("}title")][:1]


def test_comparisons(run: Run, scene: Path) -> None:
    data = scene.with_suffix(".csv")
    header, *rows = STUDY_FILE.read_text(encoding="utf-8").splitlines()
    header = header.replace("X [mm]", r"$\frac{X$ 振 [mm]")
    data.write_text("\n".join([header, *rows[:121]]) + "\n", encoding="utf-8")
    args = ("--mass", "0.1", "-o", "out.png", "-o", "out.svg", "-q")
    result = run("measure", scene, data, *args)
    assert (result.exit_code, result.stderr) == (0, "")
    assert titles("out") == [f"{TOLD}.csv – {TOLD}, computed pattern F_"] * 2
