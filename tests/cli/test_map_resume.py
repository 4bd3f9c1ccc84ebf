"""``vibro map --table parquet``: what is there already is kept, gone on with, or refused."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from helpers.commands import Run
from helpers.sharded_maps import QUICK, SHARD_NAMES, SHARDED, WHOLE, contents, error, names, told

MANIFEST = Path("out", "_manifest.json")
pytestmark = pytest.mark.usefixtures("no_pictures")


def check_refused(run: Run, *args: str) -> None:
    """Run a command that is refused, and look whether everything there stays."""
    before = contents()
    result = run(*args)
    assert (result.exit_code, result.stdout) == (1, "")
    assert contents() == before


def test_a_folder_that_holds_something_else_is_kept(run: Run) -> None:
    Path("out").mkdir()
    Path("out", "notes.txt").touch()
    for more in ("--force", "--resume"):
        args = (*SHARDED, "-o", "out", more)
        check_refused(run, *args)
        MANIFEST.write_text('{"name": "an app"}', encoding="utf-8")
        check_refused(run, *args)
        MANIFEST.unlink()


def test_a_sweep_that_is_there_is_kept(run: Run) -> None:
    asked = (*SHARDED, "-o", "out")
    Path("out").mkdir()
    run(*asked)
    check_refused(run, *asked)
    Path("out", "_SUCCESS").unlink()
    check_refused(run, *asked)
    MANIFEST.write_text(MANIFEST.read_text(encoding="utf-8").replace("9.81", "9.82"), encoding="utf-8")
    for more in ("--resume", "--force"):  # of what it lists nothing is certain any more
        check_refused(run, *asked, more)


def test_resuming_makes_what_is_missing_alone_in_shards_of_the_size_that_is_there(run: Run) -> None:
    assert run(*SHARDED, "-o", "out", "--resume").exit_code == 0
    before = contents()
    kept = Path("out", SHARD_NAMES[0]).stat()
    for name in ("_SUCCESS", SHARD_NAMES[1]):
        Path("out", name).unlink()
    Path("out", SHARD_NAMES[2]).write_bytes(before[SHARD_NAMES[2]][:-3])
    asked = (*QUICK, "--table", "parquet", "-o", "out", "--resume")
    assert run(*asked).exit_code == 0
    assert contents() == before
    there = Path("out", SHARD_NAMES[0]).stat()
    assert (there.st_ino, there.st_mtime_ns) == (kept.st_ino, kept.st_mtime_ns)
    check_refused(run, *asked, "--shard-cells", "5")


def test_what_changes_while_a_run_goes_on_is_an_error(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    path = Path("out", SHARD_NAMES[1])

    def change(*_: object) -> list[str]:
        status = path.stat()
        path.write_bytes(path.read_bytes()[::-1])
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
        return []

    monkeypatch.setattr("vibro.cli.shards._draw", change)
    result = run(*SHARDED, "-o", "out")
    assert result.exit_code == 1
    assert error(result)[0].startswith(f"error: {path} ")
    assert names() == WHOLE[1:]


def test_ranges_are_made_by_jobs_and_finished_by_a_run_without_one(run: Run) -> None:
    for shards, number, cells in (("1:3", 2, 5), ("0:1", 1, 4)):
        result = run(*SHARDED, "-o", "out", "--shards", shards, "--json")
        assert result.exit_code == 0
        wrote = json.loads(result.stdout)
        assert (wrote["shards"], wrote["cells"], sum(wrote["status"].values())) == (number, cells, cells)
        assert "_SUCCESS" not in names()
    assert run(*SHARDED, "-o", "out", "--resume").exit_code == 0
    assert run(*SHARDED, "-o", "calm").exit_code == 0
    assert names() == WHOLE
    assert told()["digest"] == told(folder="calm")["digest"]


def test_a_range_at_rest_says_nothing_of_the_others(run: Run) -> None:
    result = run(*SHARDED, "-A", "0.001:2:3", "-o", "out", "--shards", "0:1", "--shard-cells", "3")
    assert result.exit_code == 0
    assert told("_manifest.json")["cells"] == 9
    assert "at rest everywhere" not in result.stderr


def test_starting_anew_leaves_what_is_not_of_the_sweep(run: Run) -> None:
    asked = (*SHARDED, "-o", "out")
    assert run(*asked).exit_code == 0
    mine = ["regime.png", "speed.svg", "manifest.json", "notes.txt", "_flight.png"]
    for name in mine:
        Path("out", name).write_text("mine", encoding="utf-8")
    folder = Path("out", "measured")
    folder.mkdir()
    (folder / SHARD_NAMES[0]).touch()
    assert run(*asked, "--force", "--shard-cells", "9").exit_code == 0
    assert names() == sorted([*WHOLE[:3], *mine, "measured"])
    assert {Path("out", name).read_text(encoding="utf-8") for name in mine} == {"mine"}
    assert (folder / SHARD_NAMES[0]).exists()
    for shard in SHARD_NAMES[:2]:  # one of this sweep, and one that a reader would take for a shard of it
        Path("out", shard).unlink(missing_ok=True)
        Path("out", shard).symlink_to(Path("out", "notes.txt").absolute())
        before = names()
        assert run(*asked, "--force").exit_code == 1
        assert names() == before
        Path("out", shard).unlink()
