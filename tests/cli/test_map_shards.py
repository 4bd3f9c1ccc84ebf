"""``vibro map -o NAME.parquet``: the folder, and what is said of it."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from helpers.cases import each
from helpers.commands import NUT, SMALL, Run, other

SHARDED = (*SMALL, "--regimes-only", "-o", "out.parquet")


@pytest.fixture(autouse=True)
def _small_shards(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write three shards, one after the other."""
    monkeypatch.setattr("vibro.tables.plan._SHARD_CELLS", 4)
    monkeypatch.setattr("os.cpu_count", lambda: 1)


def told(name: str = "_SUCCESS") -> dict[str, Any]:
    content: dict[str, Any] = json.loads(Path("out.parquet", name).read_text(encoding="utf-8"))
    return content


def test_what_was_written_is_told(run: Run) -> None:
    said = run(*SHARDED).stderr.splitlines()
    success = told()
    size = sum(path.stat().st_size for path in Path("out.parquet").glob("part-*"))
    assert said[-6] == (
        f"wrote out.parquet: 3 shards, {size / 1e3:.3g} kB, {size / 9:.1f} bytes a cell;"
        f" digest {success['digest']}"
    )
    assert said[-5].startswith("3 of 9 cells: flight-not-modelled")
    assert "     hopping   33.3%" in said
    lines = [line for line in said if " % of " in line]
    assert 1 <= len(lines) <= 2
    progress = r"\d0 % of 9 cells: [0-2] of 3 shards, \S+ cells/s, about \d+ s left"
    assert all(re.fullmatch(progress, line) for line in lines), lines
    assert told("_manifest.json")["argv"] == ["vibro", *SHARDED]
    again = run(*SHARDED, "--json", "-q")
    assert again.stderr == ""
    answer = json.loads(again.stdout)
    expected = {"folder": "out.parquet", "shards": 3, "bytes": size, "cells": 9}
    assert answer.items() >= expected.items()
    for key in ("digest", "status", "regime"):
        assert answer[key] == success[key]


@each(("more", "is_told"), [(-0.3, True), (0.3, False)])
def test_a_disk_with_less_room_than_the_shards_to_come_need_is_told_early(
    run: Run, monkeypatch: pytest.MonkeyPatch, more: float, is_told: bool
) -> None:
    assert run(*SHARDED, "--force").exit_code == 0
    one = Path("out.parquet", "part-000000.parquet").stat().st_size

    def room(folder: Path) -> SimpleNamespace:
        left = 3 - len([*folder.glob("part-*")])
        return SimpleNamespace(free=(left + more) * one)

    monkeypatch.setattr("shutil.disk_usage", room)
    shutil.rmtree("out.parquet")
    assert ("more are needed" in run(*SHARDED).stderr) is is_told


def test_unresolved_cells_are_exit_code_3_however_often_asked(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    import vibro.sweeps.grid
    from vibro.core.codes import Status
    from vibro.results.steady import SteadyCycle
    from vibro.scene import Scene
    from vibro.steady import solve

    def doubtful(scene: Scene, **how: Any) -> SteadyCycle:
        cycle = solve(scene, **how)
        cycle.status.flat[0] = Status.UNRESOLVED
        return cycle

    with monkeypatch.context() as patch:
        patch.setattr(vibro.sweeps.grid, "solve", doubtful)
        assert run(*SHARDED[:-1], "out.csv").exit_code == 3
        result = run(*SHARDED)
    assert Path("out.csv").exists()
    assert result.exit_code == 3
    assert "3 of 9 cells: unresolved" in result.stderr
    assert told()["status"] == {"ok": 4, "flight-not-modelled": 2, "unresolved": 3}
    assert run(*SHARDED).exit_code == 3


def test_bodies_that_all_rest_are_told_where_motion_begins(run: Run) -> None:
    still = ("map", *other(NUT, "-A", "0.001,0.002"), "--restitution", "0:0.3:2")
    said = [
        run(*still, "-o", output).stderr.splitlines()[-1] for output in ("x.csv", "x.parquet", "x.parquet")
    ]
    assert said[0].startswith("at rest everywhere: motion begins at ")
    assert said == said[:1] * 3
    assert "at rest" not in run(*SHARDED).stderr
