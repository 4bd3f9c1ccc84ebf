"""The tables of docs/nomenclature.md that list inputs and results, made from their descriptions.

python tests/nomenclature.py    # writes them into the page
"""

from __future__ import annotations

import re
from pathlib import Path

from vibro.quantities import QUANTITIES
from vibro.results.designs import DESIGN_COLUMNS
from vibro.results.steady import (
    ARRIVAL_TIME,
    RESULTS,
    STROKES,
    TIPPING_LOAD_RATIO,
    TRAVERSE_TIME,
    UPRIGHT,
    Result,
)
from vibro.scene import Fields

PAGE = Path(__file__).parents[1] / "docs" / "nomenclature.md"
ELSEWHERE = (ARRIVAL_TIME, STROKES, UPRIGHT, TIPPING_LOAD_RATIO)
"""Results that are no attributes of ``SteadyCycle``, each described by its name in capitals."""
HEADER = "| symbol | code name | unit | CSV column | meaning |"


def _row(symbol: str, name: str, unit: str, column: str, meaning: str) -> str:
    shown = f"${symbol}$" if symbol else "-"
    return f"| {shown} | {f'`{name}`' if name else '-'} | {unit or '1'} | `{column}` | {meaning} |"


def _result(result: Result) -> str:
    name = f"SteadyCycle.{result.name}"
    if result in ELSEWHERE:
        name = f"results.steady.{result.name.upper()}"
    unit = result.kind.si_unit if result.dtype is float or result.is_number else "code"
    return _row(result.symbol, name, unit, result.column, result.meaning)


def tables() -> str:
    """Make the tables, as they stand in the page."""
    inputs = [
        _row(
            q.symbol,
            f"Scene.{q.name}" if q.name in Fields._fields else "",
            q.kind.si_unit.replace("^2", "²"),
            q.column,
            q.meaning,
        )
        for q in QUANTITIES.values()
    ]
    results = []
    for result in RESULTS:
        results.append(_result(result))
        if result.name == "peak_velocity":
            results.append(_result(TRAVERSE_TIME))
    results += [_result(result) for result in ELSEWHERE]
    head = [HEADER, "|---|---|---|---|---|"]
    parts = [["## Inputs", "", *head, *inputs], ["## Results", "", *head, *results]]
    designs = [f"| `{c.name}` | {c.unit or '1'} | {c.meaning} |" for c in DESIGN_COLUMNS]
    parts.append(["## Designs", "", "| CSV column | unit | meaning |", "|---|---|---|", *designs])
    return "".join("\n".join([*part, "", ""]) for part in parts)


def page_with(text: str) -> str:
    """Put the tables into the page."""
    page = PAGE.read_text(encoding="utf-8")
    return re.sub(r"## Inputs\n.*?(?=## Groups and loads)", lambda _: text, page, flags=re.DOTALL)


if __name__ == "__main__":
    PAGE.write_text(page_with(tables()), encoding="utf-8")
