"""``vibro accuracy``: its advice and its files. How good the methods are is tested in tests/accuracy."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from helpers.commands import rows_of

if TYPE_CHECKING:
    from helpers.commands import Run


def test_the_advice_and_the_files(run: Run) -> None:
    result = run("accuracy", "--scenes", "2", "-o", "trade")
    assert result.exit_code == 0, result.stderr
    assert "Use vibro (exact" in result.stdout
    assert all(len(line) <= 80 for line in result.stdout.partition("Time a scene")[2].splitlines())
    assert Path("trade.png").stat().st_size > 10_000
    assert json.loads(Path("trade.json").read_text(encoding="utf-8"))["argv"]
    rows = rows_of(Path("trade.csv").read_text(encoding="utf-8"))
    assert {row["method"] for row in rows} >= {"vibro", "events, DOP853", "smoothed friction", "time steps"}
