"""Folders of sweeps: gone on with, replaced, and what is not of the sweep is refused and never touched."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd
import pytest
from helpers.cases import each
from helpers.commands import POSIX
from helpers.plans import NUT, plan_of, swept, written

import vibro
from vibro.errors import FileError, InputError
from vibro.tables.plan import MANIFEST, SUCCESS, shard_name
from vibro.tables.writing import checked_workers

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


def test_a_whole_sweep_stays_as_it_is(folder: Path, plan: Plan) -> None:
    before = {path: (path.stat().st_ino, path.stat().st_mtime_ns) for path in folder.iterdir()}
    summary = written(folder, plan)
    assert summary.digest == json.loads((folder / SUCCESS).read_bytes())["digest"]
    assert summary.tally.status.total() == 20
    assert not any(made.is_new for made in summary.made.values())
    assert {path: (path.stat().st_ino, path.stat().st_mtime_ns) for path in folder.iterdir()} == before


@pytest.mark.parametrize("gone", [SHARDS[:1], SHARDS[1:3], [SUCCESS], [SUCCESS, *SHARDS]])
def test_what_is_missing_is_made_and_nothing_else(folder: Path, plan: Plan, gone: list[str]) -> None:
    before, kept = contents(folder), {path.name: path.stat().st_ino for path in folder.iterdir()}
    for name in gone:
        (folder / name).unlink()
    summary = written(folder, plan)
    assert contents(folder) == before
    assert {shard_name(shard) for shard, made in summary.made.items() if made.is_new} == {*gone} & {*SHARDS}
    for name in {*kept} - {*gone, SUCCESS}:
        assert (folder / name).stat().st_ino == kept[name]


def test_another_sweep_is_refused_or_replaced_by_force(folder: Path, plan: Plan) -> None:
    before = contents(folder)
    other = plan_of(swept(**{**GIVEN, "amplitude_mm": "0.5:2:2"}), 6)
    for wrong, said in ((other, "last: 2.0|cells: 20 there, 10 here"), (plan_of(swept(**GIVEN), 7), "shard")):
        with pytest.raises(FileError, match=f"holds another sweep: .*{said}") as caught:
            written(folder, wrong)
        assert "force=True" in caught.value.hint
        assert contents(folder) == before
    mine = ["regime.png", "notes.txt"]
    for name in mine:
        (folder / name).touch()
    written(folder, other, force=True)
    assert {*contents(folder)} == {MANIFEST, SUCCESS, *SHARDS[:2], *mine}
    assert len(vibro.open_sweep(folder).to_frame()) == 10


def test_what_says_that_a_sweep_is_whole_goes_first(
    folder: Path, plan: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    removed: list[str] = []
    unlink = Path.unlink

    def noted(path: Path, missing_ok: bool = False) -> None:
        removed.append(path.name)
        unlink(path, missing_ok)

    monkeypatch.setattr(Path, "unlink", noted)
    written(folder, plan, force=True)
    ours = [name for name in removed if not name.startswith(".")][:6]
    assert ours[0] == SUCCESS
    assert ours[-1] == MANIFEST
    assert {*ours[1:-1]} == {*SHARDS}


@each(
    "there",
    [
        ["notes.txt"],
        ["a", "b", "c", "d"],
        [MANIFEST, "more.parquet"],
        [MANIFEST, "part-0000000.parquet"],
        [SHARDS[0]],
        [SUCCESS],
    ],
)
@pytest.mark.parametrize("force", [False, True])
def test_a_folder_that_holds_something_else_is_refused(
    tmp_path: Path, plan: Plan, force: bool, there: list[str]
) -> None:
    if force and there in ([SHARDS[0]], [SUCCESS]):
        return  # they are of a sweep
    (tmp_path / "out").mkdir(exist_ok=True)
    for name in there:
        (tmp_path / "out" / name).touch()
    with pytest.raises(FileError, match=r"holds something else|has shards, but no") as caught:
        written(tmp_path / "out", plan, force=force)
    assert caught.value.hint
    assert sorted(contents(tmp_path / "out")) == sorted(there)
    for name in there:
        (tmp_path / "out" / name).unlink()


@POSIX
def test_links_are_never_written_through(folder: Path, plan: Plan, tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("mine", encoding="utf-8")
    for name in (SHARDS[0], MANIFEST, SUCCESS):
        (folder / name).unlink()
        (folder / name).symlink_to(tmp_path / "mine")
        with pytest.raises(FileError):
            written(folder, plan, force=True)
        assert (tmp_path / "mine").read_text(encoding="utf-8") == "mine"
        (folder / name).unlink()
        written(folder, plan, force=True)


def test_a_manifest_that_was_changed_is_no_reason_to_write(folder: Path, plan: Plan) -> None:
    path = folder / MANIFEST
    path.write_text(path.read_text(encoding="utf-8").replace("9.81", "9.82"), encoding="utf-8")
    before = contents(folder)
    with pytest.raises(FileError, match="is damaged, or was changed"):
        written(folder, plan)
    assert contents(folder) == before


def test_from_python(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.tables.plan._SHARD_CELLS", 6)
    held = vibro.sweep(**GIVEN, **NUT)
    stored = vibro.write_sweep(tmp_path / "out", **GIVEN, **NUT)
    assert {*contents(tmp_path / "out")} == {MANIFEST, SUCCESS, *SHARDS}
    pd.testing.assert_frame_equal(stored.to_frame(), held.to_frame())
    assert repr(vibro.write_sweep(tmp_path / "out", workers=1, **GIVEN, **NUT)) == repr(stored)
    columns = ["regime", "stroke_mm"]
    with pytest.raises(FileError, match="another sweep"):
        vibro.write_sweep(tmp_path / "out", columns=columns, **GIVEN, **NUT)
    again = vibro.write_sweep(str(tmp_path / "out"), columns=columns, force=True, **GIVEN, **NUT)
    pd.testing.assert_frame_equal(again.to_frame(), held.to_frame(columns))
    for folder in (3, "a\0b"):
        with pytest.raises(InputError, match="folder = "):
            vibro.write_sweep(folder, **GIVEN, **NUT)  # type: ignore[arg-type]


def test_workers_are_a_number_or_an_address() -> None:
    good = (None, 1, 1024, "tcp://host:8786", "tls://[::1]:1", "ws://a.b:80")
    assert [checked_workers(workers) for workers in good] == list(good)
    for wrong in (0, -1, 1025, True, 2.0, "4", "host:8786", "tcp://host", "http://host:80", "tcp://a b:1"):
        with pytest.raises(InputError, match="workers="):
            checked_workers(wrong)
