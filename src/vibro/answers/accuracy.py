"""The answer about methods: what each costs, and how wrong it is."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from vibro.accuracy.trade import advice
from vibro.answers.answer import Answer, Fact, Table

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.accuracy.trade import Row, Trade

_USUAL: Final = ("time", "largest error", "beyond")
_RARE: Final = ("scenes", "99.9 %", "wrong regime", "silent", "gave up", "drift at rest")


def trade_answer(trade: Trade, record: Mapping[str, Any]) -> Answer:
    """Make the answer about methods that were compared; ``record`` is what JSON says."""

    def table(title: str, names: tuple[str, ...], *, is_rare: bool) -> Table:
        rows = [
            (row.method, row.setting, *(cells[name] for name in names))
            for row, cells in zip(trade.rows, map(_cells, trade.rows), strict=True)
        ]
        columns = [(name, "") for name in ("method", "setting", *names)]
        return Table("methods", columns, rows, title, is_rare)

    return Answer(
        [
            Fact("scenes", f"{trade.scenes} in contact"),
            Fact("errors", f"of the mean speed, in A f, against {trade.reference}"),
            Fact("beyond", f"answers that are wrong by more than {trade.tolerance:g}"),
            Fact("silent", "answers that miss half the speed or more, without a word", is_rare=True),
            Fact("advice", advice(trade)),
        ],
        [
            table("Time a scene, and errors", _USUAL, is_rare=False),
            table("Failures", _RARE, is_rare=True),
        ],
        record=record,
    )


def _cells(row: Row) -> dict[str, str]:
    return {
        "time": _time(row.time_us),
        "largest error": _error(row.error_max),
        "beyond": str(row.beyond_tolerance),
        "scenes": str(row.scenes),
        "99.9 %": _error(row.error_999),
        "wrong regime": f"{row.wrong_regime_share:.2%}",
        "silent": str(row.silent_failures),
        "gave up": str(row.gave_up),
        "drift at rest": _error(row.drift_at_rest) if row.drift_at_rest else "0",
    }


def _error(error: float) -> str:
    return "-" if math.isnan(error) else f"{error:.1e}"


def _time(microseconds: float) -> str:
    for size, unit in ((1e3, "ms"), (1.0, "us")):
        if microseconds >= size:
            return f"{microseconds / size:.3g} {unit}"
    return f"{1e3 * microseconds:.3g} ns"
