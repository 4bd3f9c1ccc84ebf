"""``vibro map --table parquet``: what is there already is kept, gone on with, or refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.commands import Run
from helpers.parted_maps import PART_NAMES, PARTS, QUICK, contents, error, frame, names, told

pytestmark = pytest.mark.usefixtures("no_pictures")


def test_a_folder_that_holds_something_else_is_kept(run: Run) -> None:
    Path("out").mkdir()
    Path("out", "notes.txt").write_text("mine", encoding="utf-8")
    for more in ((), ("--force",), ("--resume",)):
        result = run(*PARTS, "-o", "out", *more)
        assert result.exit_code == 1
        assert error(result) == [
            "error: out holds something else: notes.txt", "hint: choose another name with -o",
        ]  # fmt: skip
    Path("out", "manifest.json").write_text('{"name": "an app"}', encoding="utf-8")
    for more in ((), ("--force",), ("--resume",)):
        result = run(*PARTS, "-o", "out", *more)
        assert result.exit_code == 1
        assert error(result) == [
            f"error: {Path('out', 'manifest.json')} is no manifest of a sweep", "hint: choose another folder",
        ]  # fmt: skip
    assert names() == ["manifest.json", "notes.txt"]


def test_an_empty_folder_is_taken_and_a_file_is_not(run: Run) -> None:
    Path("out").mkdir()
    assert run(*PARTS, "-o", "out/").exit_code == 0
    assert "_SUCCESS" in names()
    Path("file").touch()
    result = run(*PARTS, "-o", "file")
    assert result.exit_code == 1
    assert error(result)[0].startswith("error: cannot write to file: ")
    assert "is a file; choose another name with -o" in error(result)[1]


def test_a_sweep_that_is_there_is_kept(run: Run) -> None:
    run(*PARTS, "-o", "out")
    before = contents()
    result = run(*PARTS, "-o", "out")
    assert result.exit_code == 1
    assert error(result) == [
        "error: out holds a sweep already",
        "hint: vibro map and vibro.open_sweep read it; choose another name, or start anew with --force"
        " (force=True)",
    ]  # fmt: skip
    Path("out", "_SUCCESS").unlink()
    result = run(*PARTS, "-o", "out")
    assert result.exit_code == 1
    assert error(result) == [
        "error: out holds a sweep that is not finished",
        "hint: --resume (resume=True) goes on with it, --force (force=True) starts anew",
    ]
    assert contents() == {name: data for name, data in before.items() if name != "_SUCCESS"}


def test_force_starts_anew(run: Run) -> None:
    run(*PARTS, "-o", "out")
    Path("out", "notes.txt").write_text("mine", encoding="utf-8")
    Path("out", "speed.svg").write_text("of the sweep before", encoding="utf-8")
    assert run(*QUICK, "-f", "10:30:4", "--table", "parquet", "-o", "out", "--force").exit_code == 0
    assert names() == ["_SUCCESS", "manifest.json", "notes.txt", "part-000000.parquet"]
    assert len(frame()) == told()["cells"] == 12


def test_resuming_makes_what_is_missing_alone(run: Run) -> None:
    run(*PARTS, "-o", "out")
    before = contents()
    kept = Path("out", PART_NAMES[0]).stat()
    for name in ("_SUCCESS", PART_NAMES[1]):
        Path("out", name).unlink()
    Path("out", PART_NAMES[2]).write_bytes(before[PART_NAMES[2]][:-3])
    assert run(*PARTS, "-o", "out", "--resume").exit_code == 0
    assert contents() == before
    assert Path("out", PART_NAMES[0]).stat().st_ino == kept.st_ino
    assert Path("out", PART_NAMES[0]).stat().st_mtime_ns == kept.st_mtime_ns


def test_resuming_where_there_is_nothing_starts(run: Run) -> None:
    for folder in ("new", "empty"):
        if folder == "empty":
            Path(folder).mkdir()
        assert run(*PARTS, "-o", folder, "--resume").exit_code == 0
        assert names(folder) == ["_SUCCESS", "manifest.json", *PART_NAMES]


def test_resuming_takes_the_size_of_the_parts_that_are_there(run: Run) -> None:
    run(*PARTS, "-o", "out")
    before = contents()
    Path("out", "_SUCCESS").unlink()
    assert run(*QUICK, "--table", "parquet", "-o", "out", "--resume").exit_code == 0
    assert contents() == before
    result = run(*QUICK, "--table", "parquet", "-o", "out", "--resume", "--part-cells", "5")
    assert result.exit_code == 1
    assert error(result)[0] == "error: out holds another sweep: part cells: 4 there, 5 here"


@pytest.mark.parametrize(
    ("more", "difference"),
    [
        (["-A", "0.5:2:4"], "amplitude_mm: 3 values, 0.5 ... 2 mm, step 0.75 there, 4 values, 0.5 ... 2 mm, "
         "step 0.5 here; cells: 9 there, 12 here"),
        (["--mu-s", "0.75"], "static_friction: 0.74 there, 0.75 here"),
        (["--restitution", "0.3"], "restitution: 0.0 there, 0.3 here"),
        (["-L", "600"], "trough_length_mm: none there, 600.0 here"),
        (["--accuracy", "exact", "--flight", "off"], "accuracy: regimes there, exact here"),
        (["--digits", "4"], "digits: none there, 4 here"),
        (["--columns", "status,regime"], "columns: regime,status there, status,regime here"),
    ],
)  # fmt: skip
def test_another_sweep_is_not_gone_on_with(run: Run, more: list[str], difference: str) -> None:
    asked = (*PARTS, "--columns", "regime,status", "-o", "out")
    run(*asked)
    before = contents()
    result = run(*asked, *more, "--resume")
    assert result.exit_code == 1
    assert error(result) == [
        f"error: out holds another sweep: {difference}",
        "hint: ask for the same, choose another name with -o, or start anew with --force",
    ]
    assert contents() == before


def test_a_part_too_many_is_told(run: Run) -> None:
    run(*PARTS, "-o", "out")
    Path("out", PART_NAMES[0]).rename(Path("out", "part-000003.parquet"))
    result = run(*PARTS, "-o", "out", "--resume")
    assert result.exit_code == 1
    assert error(result) == ["error: out holds parts that are none of this sweep: part-000003.parquet"]


def test_a_manifest_that_was_changed_is_not_gone_on_with(run: Run) -> None:
    run(*PARTS, "-o", "out")
    path = Path("out", "manifest.json")
    path.write_text(path.read_text(encoding="utf-8").replace("9.81", "9.82"), encoding="utf-8")
    result = run(*PARTS, "-o", "out", "--resume")
    assert result.exit_code == 1
    assert error(result) == [
        f"error: {path} is damaged, or was changed after it was written",
        "hint: put back what was there, or start anew with --force",
    ]
    assert run(*PARTS, "-o", "out", "--force").exit_code == 0
