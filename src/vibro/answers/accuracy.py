"""The answer about methods: what each costs, and how wrong it is."""

from __future__ import annotations

from dataclasses import asdict
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Final

from vibro.accuracy.trade import advice
from vibro.answers.answer import Answer, Fact, Table

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.accuracy.trade import Trade

# What people call the columns of a table, and their units, by attribute of a row.
_USUAL: Final = {
    "method": ("method", ""), "setting": ("setting", ""), "time_us": ("time", "us"),
    "error_max": ("largest error", ""), "beyond_tolerance": ("beyond", ""),
}  # fmt: skip
_FAILURES: Final = {
    "method": ("method", ""), "setting": ("setting", ""), "scenes": ("scenes", ""),
    "error_999": ("99.9 %", ""), "wrong_regime_share": ("wrong regime", ""),
    "silent_failures": ("silent", ""), "gave_up": ("gave up", ""), "drift_at_rest": ("drift at rest", ""),
}  # fmt: skip


def trade_answer(trade: Trade, drawn_from: Mapping[str, Any]) -> Answer:
    """Make the answer about methods that were compared, on scenes that JSON says they were drawn from."""
    tables = [
        Table("methods", [*columns.values()], [*map(attrgetter(*columns), trade.rows)], title, is_rare)
        for columns, title, is_rare in (
            (_USUAL, "Time a scene, and errors", False),
            (_FAILURES, "Failures", True),
        )
    ]
    facts = [
        Fact("scenes", f"{trade.scenes} in contact"),
        Fact("errors", f"of the mean speed, in A f, against {trade.reference}"),
        Fact("beyond", f"answers that are wrong by more than {trade.tolerance:g}"),
        Fact("silent", "answers that miss half the speed or more, without a word", is_rare=True),
        Fact("advice", advice(trade)),
    ]
    record = {
        **drawn_from,
        "scenes_drawn": trade.drawn,
        "scenes_in_contact": trade.scenes,
        "reference": trade.reference,
        "tolerance_af": trade.tolerance,
        "methods": [asdict(row) for row in trade.rows],
    }
    return Answer(facts, tables, record=record)
