"""A small version of the comparison in docs/theory/accuracy.md, and the order that its text claims."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from helpers.commands import rows_of

if TYPE_CHECKING:
    from helpers.commands import Run


def test_the_order_of_the_methods(run: Run) -> None:
    result = run("accuracy", "--scenes", "8", "-o", "trade")
    assert result.exit_code == 0, result.stderr
    assert "Use vibro (exact" in result.stdout
    assert all(len(line) <= 80 for line in result.stdout.partition("Time a scene")[2].splitlines())
    assert Path("trade.png").stat().st_size > 10_000
    assert json.loads(Path("trade.json").read_text(encoding="utf-8"))["argv"]
    table = rows_of(Path("trade.csv").read_text(encoding="utf-8"))
    rows = {(row["method"], row["setting"]): row for row in table}
    error = {key: float(row["error_max_af"]) for key, row in rows.items() if row["error_max_af"]}
    exact = error.pop(("vibro", "exact"))
    assert exact < 1e-13
    # nothing is closer, and tighter settings of one method come closer
    assert min(error.values()) > exact
    assert error["events, DOP853", "rtol 1e-12"] < error["events, DOP853", "rtol 1e-9"] < 1e-5
    assert error["events, DOP853", "rtol 1e-9"] < error["events, DOP853", "rtol 1e-6"] < 1e-2
    assert error["events, RK45", "rtol 1e-9"] < error["events, RK45", "rtol 1e-6"]
    assert error["smoothed friction", "width 0.01 A w"] > 1e-2
    assert error["time steps", "40 a cycle"] > 1e-2
    assert error["time steps", "4000 a cycle"] < error["time steps", "40 a cycle"]
    # smoothed friction creeps at rest, by about its width
    drift = {key: float(row["drift_at_rest_af"] or "nan") for key, row in rows.items()}
    assert drift["vibro", "exact"] == 0.0
    assert 3e-3 < drift["smoothed friction", "width 0.01 A w"] < 3e-2
    assert rows["vibro", "exact"]["wrong_regime_share"] in ("0", "0.0")
