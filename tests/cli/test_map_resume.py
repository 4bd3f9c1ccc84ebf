"""``vibro map -o NAME.parquet``: what is there already is gone on with, kept, or refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.commands import SMALL, Run

QUICK = (*SMALL, "--regimes-only", "-o", "wide.parquet")
FOLDER = Path("wide.parquet")
SHARDS = ["part-000000.parquet", "part-000001.parquet", "part-000002.parquet"]
WHOLE = ["_SUCCESS", "_manifest.json", *SHARDS]


@pytest.fixture(autouse=True)
def _small_shards(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.tables.plan._SHARD_CELLS", 4)


def contents() -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(FOLDER.iterdir())}


def test_the_same_command_goes_on(run: Run) -> None:
    assert run(*QUICK).exit_code == 0
    before, kept = contents(), (FOLDER / SHARDS[0]).stat()
    assert list(before) == WHOLE
    again = run(*QUICK)
    assert (again.exit_code, contents()) == (0, before)
    assert "complete already: wide.parquet" in again.stderr
    for name in ("_SUCCESS", SHARDS[1]):
        (FOLDER / name).unlink()
    assert run(*QUICK).exit_code == 0
    assert contents() == before
    there = (FOLDER / SHARDS[0]).stat()
    assert (there.st_ino, there.st_mtime_ns) == (kept.st_ino, kept.st_mtime_ns)


def test_another_sweep_and_other_files_are_kept(run: Run) -> None:
    FOLDER.mkdir()
    (FOLDER / "notes.txt").touch()
    for more in ((), ("--force",)):
        assert run(*QUICK, *more).exit_code == 1
        assert list(contents()) == ["notes.txt"]
    (FOLDER / "notes.txt").unlink()
    assert run(*QUICK).exit_code == 0
    before = contents()
    other = run(*QUICK, "-A", "0.5:2:2")
    assert (other.exit_code, contents()) == (1, before)
    assert "--force" in other.stderr
    (FOLDER / "notes.txt").touch()
    assert run(*QUICK, "-A", "0.5:2:2", "--force").exit_code == 0
    assert {*contents()} == {*WHOLE[:-1], "notes.txt"}
