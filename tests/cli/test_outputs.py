"""``-o``: which files come of a name and its ending, and which names are refused."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from helpers.cases import each
from helpers.commands import NUT, POSIX, SMALL, Run, other

SCENE = Path(__file__).parents[2] / "examples" / "safety_nut.toml"
QUICK = (*SMALL, "--regimes-only")
LINE = ("map", *other(NUT, "-A", "0.5:2:3"), "--regimes-only")  # of which there is no picture
SOLVE = ("solve", *NUT)
SIMULATE = ("simulate", *NUT, "--cycles", "1", "--samples-per-cycle", "9")
FOLDER = ("_SUCCESS", "_manifest.json", "part-000000.parquet")
STEM = ("x-regime.png", "x.csv", "x.json")

pytestmark = pytest.mark.usefixtures("unsaved")


def files() -> set[str]:
    return {path.as_posix() for path in Path().rglob("*") if path.is_file()}


def opened(*outputs: str) -> list[str]:
    return [part for output in outputs for part in ("-o", output)]


@each(
    ("command", "outputs", "written"),
    [
        (QUICK, ("x",), STEM),
        (QUICK, ("run1.5",), ("run1.5-regime.png", "run1.5.csv", "run1.5.json")),
        (QUICK, ("new/x.csv",), ("new/x.csv", "new/x.json")),
        (QUICK, ("x.CSV",), ("x.CSV", "x.json")),
        (QUICK, ("x.json",), ("x.json",)),
        (QUICK, ("x.svg", "y.PDF"), ("x.svg", "y.PDF")),
        (SMALL, ("x.png",), ("x-regime.png", "x-speed.png")),
        (QUICK, ("x.csv", "y.csv"), ("x.csv", "x.json", "y.csv", "y.json")),
        (QUICK, ("-", "x.csv"), ("x.csv", "x.json")),
        (QUICK, (), ("vibro-map-regime.png", "vibro-map.csv", "vibro-map.json")),
        (QUICK, ("new/",), ("new/vibro-map-regime.png", "new/vibro-map.csv", "new/vibro-map.json")),
        (QUICK, ("x.parquet/", "./x.parquet"), [f"x.parquet/{name}" for name in FOLDER]),
        (QUICK, ("x.Parquet", "x.png", "x.json"), ["x.png", "x.json", *(f"x.Parquet/{n}" for n in FOLDER)]),
        (LINE, ("x.xlsx",), ("x.xlsx", "x.json")),
        (SOLVE, ("x.csv", "x.xlsx"), ("x.csv", "x.xlsx", "x.json")),
        (SIMULATE, ("x",), ("x-phases.csv", "x.csv", "x.json", "x.png")),
        (SIMULATE, ("x.csv",), ("x-phases.csv", "x.csv", "x.json")),
        (SOLVE, ("x.HTML", "x.csv"), ("x.HTML", "x.csv", "x.json")),
        (("schema",), ("x",), ("x.json",)),
    ],
)
def test_endings_say_what_is_written(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    command: tuple[object, ...], outputs: tuple[str, ...], written: tuple[str, ...],
) -> None:  # fmt: skip
    place = tmp_path / f"{len(list(tmp_path.iterdir()))}"
    place.mkdir()
    monkeypatch.chdir(place)
    result = run(*command, *opened(*outputs))
    assert result.exit_code == 0, result.stderr
    assert files() == set(written)
    assert (result.stdout == "") is (command[0] in ("map", "schema") and "-" not in outputs)


@each(("command", "said", "error"), [
    (QUICK, "-o .csv", "-o .csv: the name is missing"),
    (QUICK, "-o no/..", "-o no/..: the name is missing"),
    (QUICK, "-o ", "-o '': no file has such a name"),
    (QUICK, "-o a\0b", "-o a\\x00b: no file has such a name"),
    (LINE, "-o x.png", "-o x.png: there is nothing to draw"),
    (QUICK, "-o x.parquet --workers tcp://a", "workers = 'tcp://a': must be a whole"),
])  # fmt: skip
def test_what_cannot_be_written_is_refused(
    run: Run, command: tuple[object, ...], said: str, error: str
) -> None:
    """Endings: tests/messages."""
    result = run(*command, *said.split(" "))
    assert result.exit_code == 2
    told = [line for line in result.stderr.splitlines() if line.startswith(("error: ", "hint: "))]
    assert error in told[0]
    assert told[1].startswith("hint: ")
    assert files() == set()


def test_a_name_that_is_too_long_is_named(run: Run) -> None:
    result = run(*QUICK, "-o", "x" * 300)
    assert result.exit_code == 1
    assert "xxxx" in result.stderr


@POSIX
def test_what_is_neither_a_file_nor_a_folder_is_refused(run: Run) -> None:
    os.mkfifo("fifo")
    for path in (os.devnull, "fifo"):
        result = run(*QUICK, "-o", path)
        assert f"error: -o {path}: it is neither a file nor a folder\nhint: -o - writes" in result.stderr


def test_folders_take_the_name_of_the_scene(run: Run) -> None:
    Path("there.csv").mkdir()
    Path("bolt.toml").write_text(SCENE.read_text(encoding="utf-8"), encoding="utf-8")
    for output in ("there.csv", "new/", "new/."):
        assert run("map", "bolt.toml", "-f", "15", *LINE[-3:], "-o", output, "--force").exit_code == 0
    assert run("map", "bolt.toml", "-f", "15", *LINE[-3:]).exit_code == 0
    assert files() == {
        "bolt.toml", "bolt.csv", "bolt.json", "there.csv/bolt.csv", "there.csv/bolt.json", "new/bolt.csv",
        "new/bolt.json",
    }  # fmt: skip


def test_the_json_of_one_scene_has_its_answer(run: Run) -> None:
    answer = json.loads(run(*SOLVE, "--json").stdout)
    run(*SOLVE, "-o", "x.json")
    record = json.loads(Path("x.json").read_text("utf-8"))
    assert answer.items() <= record.items()
    assert record["argv"][-2:] == ["-o", "x.json"]


@each(
    ("there", "command"), [("x.csv", QUICK), ("x-regime.png", QUICK), ("x.json", SOLVE), ("x.png", SIMULATE)]
)
def test_existing_files_are_kept_unless_forced(run: Run, there: str, command: tuple[str, ...]) -> None:
    for name in files():
        Path(name).unlink()
    Path(there).write_text("mine", encoding="utf-8")
    kept = run(*command, "-o", "x")
    assert (kept.exit_code, files()) == (1, {there})
    assert f"error: {there} exists already\nhint: --force (force=True) replaces it" in kept.stderr
    assert Path(there).read_text(encoding="utf-8") == "mine"
    assert run(*command, "-o", "x", "--force").exit_code == 0
    assert "mine" not in Path(there).read_bytes().decode("utf-8", "replace")
