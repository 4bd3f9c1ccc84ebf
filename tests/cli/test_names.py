"""Names of files are text: whole runs on files whose names are markup elsewhere, or no text at all."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import pytest
from helpers.commands import NUT
from helpers.made_records import EXAMPLES, STUDY_FILE
from PIL import Image

if TYPE_CHECKING:
    from helpers.commands import Run

# Names, and how the metadata of pictures tell them.
NAMES = {"a$_{x$ =cmd 振动🔩": "a$_{x$ =cmd 振动🔩"}
if sys.platform == "linux":  # others have no such names
    NAMES[r"$\frac{x$" + "\x1b[31m\x07\n\udce9"] = r"$\frac{x$�[31m���"


@pytest.fixture(params=NAMES, ids=ascii)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def scene(tmp_path: Path, name: str) -> Path:
    path = tmp_path / f"{name}.toml"
    shutil.copy(EXAMPLES / "safety_nut.toml", path)
    return path


def titles(stem: str) -> list[str]:
    """Return the titles in the metadata of a picture as PNG and as SVG."""
    with Image.open(f"{stem}.png") as image:
        image.load()
        found = [image.info["Title"]]
    elements = ElementTree.parse(f"{stem}.svg").iter()
    return found + [e.text or "" for e in elements if e.tag.endswith("}title")][:1]


def test_maps(run: Run, scene: Path, name: str) -> None:
    result = run("map", scene, "-f", "15", "-A", "0.5:2:5", "-o", "out", "--format", "png,svg", "-q")
    assert (result.exit_code, result.stderr) == (0, "")
    assert titles("out-speed") == [f"Mean conveying speed – {NAMES[name]}"] * 2


def test_histories(run: Run, scene: Path, name: str) -> None:
    args = ("--cycles", "1", "-o", "out", "--format", "png,svg", "-q")
    result = run("simulate", scene, *args)
    assert (result.exit_code, result.stderr) == (0, "")
    assert titles("out") == [NAMES[name]] * 2


def test_scenes_of_no_file(run: Run) -> None:
    for args, title in (
        (("simulate", "--cycles", "1"), "Motion"),
        (("compare", STUDY_FILE), f"{STUDY_FILE.name}, computed pattern F_"),
    ):
        result = run(*args, *NUT, "-o", "out", "--format", "png,svg", "-q", "--force")
        assert (result.exit_code, result.stderr) == (0, "")
        assert titles("out") == [title] * 2


def test_comparisons(run: Run, scene: Path, name: str) -> None:
    data = scene.with_suffix(".csv")
    header, *rows = STUDY_FILE.read_text(encoding="utf-8").splitlines()
    header = header.replace("X [mm]", r"$\frac{X$ 振 [mm]")
    data.write_text("\n".join([header, *rows[:121]]) + "\n", encoding="utf-8")
    args = ("--mass", "0.1", "-o", "out", "--format", "png,svg", "-q")
    result = run("compare", scene, data, *args)
    assert (result.exit_code, result.stderr) == (0, "")
    assert titles("out") == [f"{NAMES[name]}.csv – {NAMES[name]}, computed pattern F_"] * 2
