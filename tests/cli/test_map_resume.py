"""``vibro map --table parquet``: what is there already is kept, gone on with, or refused."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest
from helpers.commands import NUT_ANGLE_AND_FRICTION, Run
from helpers.sharded_maps import (
    QUICK,
    SHARD_NAMES,
    SHARDED,
    WHOLE,
    contents,
    error,
    frame,
    names,
    refusal,
    told,
)

OLD = Path(__file__).parents[1] / "data" / "sweep_folder"
pytestmark = pytest.mark.usefixtures("no_pictures")


def test_a_folder_that_holds_something_else_is_kept(run: Run) -> None:
    Path("out").mkdir()
    Path("out", "notes.txt").write_text("mine", encoding="utf-8")
    for more in ((), ("--force",), ("--resume",)):
        result = run(*SHARDED, "-o", "out", *more)
        assert result.exit_code == 1
        assert error(result) == refusal("out holds something else: notes.txt", "choose another name")
    Path("out", "_manifest.json").write_text('{"name": "an app"}', encoding="utf-8")
    for more in ((), ("--force",), ("--resume",)):
        result = run(*SHARDED, "-o", "out", *more)
        assert result.exit_code == 1
        manifest = Path("out", "_manifest.json")
        assert error(result) == refusal(f"{manifest} is no manifest of a sweep", "choose another folder")
    assert names() == ["_manifest.json", "notes.txt"]


def test_an_empty_folder_is_taken_and_a_file_is_not(run: Run) -> None:
    Path("out").mkdir()
    assert run(*SHARDED, "-o", "out/").exit_code == 0
    assert "_SUCCESS" in names()
    Path("file").touch()
    result = run(*SHARDED, "-o", "file")
    assert result.exit_code == 1
    assert error(result)[0].startswith("error: cannot write to file: ")
    assert "is a file; choose another place" in error(result)[1]


def test_a_sweep_that_is_there_is_kept(run: Run) -> None:
    run(*SHARDED, "-o", "out")
    before = contents()
    result = run(*SHARDED, "-o", "out")
    assert result.exit_code == 1
    assert error(result) == refusal(
        "out holds a sweep already",
        "choose another name, or start anew with --force; vibro map reads what is there",
    )
    Path("out", "_SUCCESS").unlink()
    result = run(*SHARDED, "-o", "out")
    assert result.exit_code == 1
    assert error(result) == refusal(
        "out holds a sweep that is not finished", "--resume goes on with it, --force starts anew"
    )
    assert contents() == {name: data for name, data in before.items() if name != "_SUCCESS"}


def test_force_starts_anew(run: Run) -> None:
    run(*SHARDED, "-o", "out")
    Path("out", "notes.txt").write_text("mine", encoding="utf-8")
    Path("out", "_speed.svg").write_text("of the sweep before", encoding="utf-8")
    assert run(*QUICK, "-f", "10:30:4", "--table", "parquet", "-o", "out", "--force").exit_code == 0
    assert names() == ["_SUCCESS", "_manifest.json", "notes.txt", "part-000000.parquet"]
    assert len(frame()) == told()["cells"] == 12


def test_resuming_makes_what_is_missing_alone(run: Run) -> None:
    run(*SHARDED, "-o", "out")
    before = contents()
    kept = Path("out", SHARD_NAMES[0]).stat()
    for name in ("_SUCCESS", SHARD_NAMES[1]):
        Path("out", name).unlink()
    Path("out", SHARD_NAMES[2]).write_bytes(before[SHARD_NAMES[2]][:-3])
    assert run(*SHARDED, "-o", "out", "--resume").exit_code == 0
    assert contents() == before
    assert Path("out", SHARD_NAMES[0]).stat().st_ino == kept.st_ino
    assert Path("out", SHARD_NAMES[0]).stat().st_mtime_ns == kept.st_mtime_ns


def test_resuming_where_there_is_nothing_starts(run: Run) -> None:
    for folder in ("new", "empty"):
        if folder == "empty":
            Path(folder).mkdir()
        assert run(*SHARDED, "-o", folder, "--resume").exit_code == 0
        assert names(folder) == WHOLE


def test_resuming_takes_the_size_of_the_shards_that_are_there(run: Run) -> None:
    run(*SHARDED, "-o", "out")
    before = contents()
    Path("out", "_SUCCESS").unlink()
    assert run(*QUICK, "--table", "parquet", "-o", "out", "--resume").exit_code == 0
    assert contents() == before
    result = run(*QUICK, "--table", "parquet", "-o", "out", "--resume", "--shard-cells", "5")
    assert result.exit_code == 1
    assert error(result)[0] == "error: out holds another sweep: shard cells: 4 there, 5 here"


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
    asked = (*SHARDED, "--columns", "regime,status", "-o", "out")
    run(*asked)
    before = contents()
    result = run(*asked, *more, "--resume")
    assert result.exit_code == 1
    assert error(result) == refusal(
        f"out holds another sweep: {difference}",
        "ask for the same, choose another name, or start anew with --force",
    )
    assert contents() == before


def test_a_manifest_that_was_changed_is_not_gone_on_with(run: Run) -> None:
    run(*SHARDED, "-o", "out")
    path = Path("out", "_manifest.json")
    path.write_text(path.read_text(encoding="utf-8").replace("9.81", "9.82"), encoding="utf-8")
    result = run(*SHARDED, "-o", "out", "--resume")
    assert result.exit_code == 1
    assert error(result) == refusal(
        f"{path} is damaged, or was changed after it was written",
        "put back what was there, or start anew with --force",
    )
    assert run(*SHARDED, "-o", "out", "--force").exit_code == 0


def test_what_changes_while_a_run_goes_on_is_an_error(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def change(*_: object) -> list[str]:
        status, path = Path("out", SHARD_NAMES[1]).stat(), Path("out", SHARD_NAMES[1])
        path.write_bytes(path.read_bytes()[::-1])
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
        return []

    monkeypatch.setattr("vibro.cli.shards._draw", change)
    result = run(*SHARDED, "-o", "out")
    assert result.exit_code == 1
    assert error(result) == refusal(
        f"{Path('out', SHARD_NAMES[1])} was removed or changed while this run went on",
        "the same command with --resume goes on",
    )
    assert names() == WHOLE[1:]
    monkeypatch.undo()


def test_ranges_are_made_by_jobs_and_finished_by_a_run_without_one(run: Run) -> None:
    wrote = []
    for shards in ("1:3", "0:1"):
        result = run(*SHARDED, "-o", "out", "--shards", shards, "--json")
        assert result.exit_code == 0
        wrote += [json.loads(result.stdout)]
        assert "_SUCCESS" not in names()
        assert f"shards {shards} of 3 are there; --resume without --shards finishes" in result.stderr
        shares = [float(line.split()[-1][:-1]) for line in result.stderr.splitlines() if line[-1] == "%"]
        assert sum(shares) == pytest.approx(100.0, abs=0.2)
    assert [one["shards"] for one in wrote] == [2, 1]
    assert [one["cells"] for one in wrote] == [sum(one["status"].values()) for one in wrote] == [5, 4]
    result = run(*SHARDED, "-o", "out", "--resume")
    assert result.exit_code == 0
    assert "3 shards there, checked first\n" in result.stderr
    assert run(*SHARDED, "-o", "calm").exit_code == 0
    assert names() == WHOLE
    assert told()["digest"] == told(folder="calm")["digest"]


def test_a_range_at_rest_says_nothing_of_the_others(run: Run) -> None:
    result = run(*SHARDED, "-A", "0.001:2:3", "-o", "out", "--shards", "0:1", "--shard-cells", "3")
    assert result.exit_code == 0
    assert told("_manifest.json")["cells"] == 9
    assert "at rest everywhere" not in result.stderr


def test_a_folder_of_an_older_version_is_kept_or_replaced_as_a_whole(run: Run) -> None:
    shutil.copytree(OLD, "out")
    before = contents()
    same = ("map", "-A", "1,4", "-f", "15,20", *NUT_ANGLE_AND_FRICTION, "--restitution", ".3", "-L", "600",
            "--table", "parquet", "-o", "out")  # fmt: skip
    assert error(run(*same))[0] == "error: out holds a sweep already"
    for more in (["--resume"], ["--shards", "0:1"]):
        result = run(*same, *more)
        assert result.exit_code == 1
        assert error(result) == refusal(
            "an older version of vibro began the sweep in out",
            "ask for the same, choose another name, or start anew with --force",
        )
    assert contents() == before
    (Path("out") / "regime.png").touch()  # as it named its pictures
    assert run(*same, "--force", "--shard-cells", "2").exit_code == 0
    assert names() == WHOLE[:4]
    assert frame()["restitution"].tolist() == [0.3] * 4
