"""The answer about methods: what each costs, and how wrong it is."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from vibro.accuracy.trade import advice
from vibro.answers.answer import Answer, Fact, Table

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.accuracy.trade import Trade


def trade_answer(trade: Trade, record: Mapping[str, Any]) -> Answer:
    """Make the answer about methods that were compared; ``record`` is what JSON says."""
    usual = [
        (row.method, row.setting, _time(row.time_us), _error(row.error_max), row.beyond_tolerance)
        for row in trade.rows
    ]
    rare = [
        (
            row.method, row.setting, row.scenes, _error(row.error_999), f"{row.wrong_regime_share:.2%}",
            row.silent_failures, row.gave_up, _error(row.drift_at_rest),
        )
        for row in trade.rows
    ]  # fmt: skip
    heads = ("method", "setting", "time", "largest error", "beyond")
    rare_heads = (
        "method", "setting", "scenes", "99.9 %", "wrong regime", "silent", "gave up", "drift at rest",
    )  # fmt: skip
    return Answer(
        [
            Fact("scenes", f"{trade.scenes} in contact"),
            Fact("errors", f"of the mean speed, in A f, against {trade.reference}"),
            Fact("beyond", f"answers that are wrong by more than {trade.tolerance:g}"),
            Fact("silent", "answers that miss half the speed or more, without a word", is_rare=True),
            Fact("advice", advice(trade)),
        ],
        [
            Table("methods", [(head, "") for head in heads], usual, "Time a scene, and errors"),
            Table("methods", [(head, "") for head in rare_heads], rare, "Failures", is_rare=True),
        ],
        record=record,
    )


def _error(error: float) -> str:
    return "-" if math.isnan(error) else f"{error:.1e}" if error else "0"


def _time(microseconds: float) -> str:
    for size, unit in ((1e3, "ms"), (1.0, "us")):
        if microseconds >= size:
            return f"{microseconds / size:.3g} {unit}"
    return f"{1e3 * microseconds:.3g} ns"
