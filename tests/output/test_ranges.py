"""Ranges of shards: jobs make them one after the other or at once, and a run of all shards finishes them."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from helpers.plans import NUT, written
from helpers.sharded import PLAN, SHARDS, made, small_plan, undisturbed

import vibro
from vibro.errors import FileError
from vibro.output.shard_folder import MANIFEST, SUCCESS, shard_name

GIVEN: dict[str, Any] = {"amplitude_mm": "0.5:2:4", "frequency_hz": "10:30:5", "flight": False, **NUT}
OTHER = small_plan(frequency_hz="10:31:300")


def test_ranges_one_after_the_other_are_finished_by_a_run_without_one(tmp_path: Path) -> None:
    folder = tmp_path / "wide"
    there: set[str] = set()
    for first, stop in ((9, 15), (0, 4), (3, 9), (0, 4)):
        summary = written(folder, PLAN, shards=f"{first}:{stop}")
        there |= {shard_name(shard) for shard in range(first, stop)}
        assert sorted(summary.sizes) == list(range(first, stop))
        assert summary.tally.status.total() == 200 * (stop - first)
        assert {path.name for path in folder.iterdir()} == {MANIFEST, *there}
    assert there == SHARDS
    before = {path.name: path.stat().st_ino for path in folder.iterdir()}
    with pytest.raises(FileError, match="not finished"):
        made(folder)
    assert made(folder, resume=True) == undisturbed()
    assert {path.name: path.stat().st_ino for path in folder.glob("[!_]*.parquet")}.items() <= before.items()
    written(folder, PLAN, shards="0:4")
    assert (folder / SUCCESS).exists()
    (folder / shard_name(2)).unlink()
    written(folder, PLAN, shards="4:9")
    assert not (folder / shard_name(2)).exists()
    written(folder, PLAN, shards="0:4")
    assert not (folder / SUCCESS).exists()
    assert made(folder, resume=True) == undisturbed()


@pytest.mark.parametrize(("plan", "works"), [(PLAN, True), (OTHER, False)])
def test_of_two_that_begin_at_once_the_later_takes_the_manifest_of_the_first_or_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, plan: Any, works: bool
) -> None:
    """The first writes it when the later has found none."""
    folder = tmp_path / "wide"

    def begin(*_: Any) -> None:
        monkeypatch.undo()
        written(folder, plan, shards="4:9")

    monkeypatch.setattr("vibro.output.writing.check_workers", begin)
    late = partial(written, folder, PLAN, shards="0:4")
    if works:
        late()
        assert made(folder, resume=True) == undisturbed()
    else:
        with pytest.raises(FileError, match="another sweep"):
            late()
        assert {path.name for path in folder.iterdir()} == {MANIFEST, *map(shard_name, range(4, 9))}
        assert json.loads((folder / MANIFEST).read_bytes())["fingerprint"] == plan.fingerprint


def test_calls_make_ranges_of_the_size_that_is_there(tmp_path: Path) -> None:
    folder = tmp_path / "wide"
    assert vibro.write_sweep(folder, shard_cells=6, shards="1:2", **GIVEN) is None
    assert vibro.write_sweep(folder, shards="0:2", **GIVEN) is None
    with pytest.raises(FileError, match="2 of 4"):
        vibro.open_sweep(folder)
    whole = vibro.write_sweep(folder, resume=True, **GIVEN)
    assert whole is not None
    calm = vibro.write_sweep(tmp_path / "calm", shard_cells=6, **GIVEN)
    assert calm is not None
    assert [(folder / shard_name(i)).read_bytes() for i in range(4)] == [
        (tmp_path / "calm" / shard_name(i)).read_bytes() for i in range(4)
    ]
