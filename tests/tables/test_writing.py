"""Folders of sweeps: gone on with, replaced, and what is not of the sweep is refused and never touched."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from helpers.cases import each
from helpers.commands import POSIX
from helpers.plans import plan_of, swept, written

from vibro.errors import FileError
from vibro.tables.plan import MANIFEST, SUCCESS, shard_name

if TYPE_CHECKING:
    from vibro.tables.plan import Plan

GIVEN: dict[str, Any] = {"amplitude_mm": "0.5:2:4", "frequency_hz": "10:30:5", "flight": False}
SHARDS = [shard_name(shard) for shard in range(4)]


@pytest.fixture(scope="module")
def plan() -> Plan:
    return plan_of(swept(**GIVEN), 6)


@pytest.fixture
def folder(tmp_path: Path, plan: Plan) -> Path:
    written(tmp_path / "out", plan)
    return tmp_path / "out"


def contents(folder: Path) -> dict[str, bytes | None]:
    return {path.name: path.read_bytes() if path.is_file() else None for path in folder.iterdir()}


@pytest.mark.parametrize("gone", [SHARDS[:1], SHARDS[1:3], [SUCCESS, *SHARDS]])
def test_what_is_missing_is_made_and_nothing_else(folder: Path, plan: Plan, gone: list[str]) -> None:
    before, kept = contents(folder), {path.name: path.stat().st_ino for path in folder.iterdir()}
    for name in gone:
        (folder / name).unlink()
    summary = written(folder, plan)
    assert contents(folder) == before
    assert {shard_name(shard) for shard, made in summary.made.items() if made.is_new} == {*gone} & {*SHARDS}
    for name in {*kept} - {*gone, SUCCESS}:
        assert (folder / name).stat().st_ino == kept[name]


def test_what_says_that_a_sweep_is_whole_goes_first(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = plan_of(swept(**{**GIVEN, "amplitude_mm": "0.5:2:2"}), 6)
    removed, unlink = list[str](), Path.unlink

    def noted(path: Path, missing_ok: bool = False) -> None:
        removed.append(path.name)
        unlink(path, missing_ok)

    (folder / "notes.txt").touch()
    with pytest.raises(
        FileError, match=r"another sweep: axes amplitude_mm: 4 values, .* 2 there, 2 values, .* 2 here"
    ):
        written(folder, other)
    monkeypatch.setattr(Path, "unlink", noted)
    written(folder, other, force=True)
    ours = [name for name in removed if not name.startswith(".")][:6]
    assert (ours[0], {*ours[1:-1]}, ours[-1]) == (SUCCESS, {*SHARDS}, MANIFEST)
    assert {*contents(folder)} == {MANIFEST, SUCCESS, *SHARDS[:2], "notes.txt"}


@each(
    ("there", "force"),
    [
        (["a", "b", "c", "d"], False),
        (["notes.txt"], True),
        ([MANIFEST, "part-0000000.parquet"], True),
        ([SHARDS[0]], False),
        ([SUCCESS], False),
    ],
)
def test_a_folder_that_holds_something_else_is_refused(
    tmp_path: Path, plan: Plan, force: bool, there: list[str]
) -> None:
    folder = tmp_path / there[-1]
    folder.mkdir()
    for name in there:
        (folder / name).touch()
    with pytest.raises(FileError, match=r"holds something else|has shards, but no") as caught:
        written(folder, plan, force=force)
    assert caught.value.hint
    assert sorted(contents(folder)) == sorted(there)


@POSIX
def test_links_are_never_written_through(folder: Path, plan: Plan, tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("mine", encoding="utf-8")
    for name in (SHARDS[0], MANIFEST, SUCCESS):
        (folder / name).unlink(missing_ok=True)
        (folder / name).symlink_to(tmp_path / "mine")
        with nullcontext() if name == SUCCESS else pytest.raises(FileError):  # that goes, as it is not true
            written(folder, plan, force=True)
        assert (tmp_path / "mine").read_text(encoding="utf-8") == "mine"
        (folder / name).unlink()
