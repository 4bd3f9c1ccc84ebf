"""The answer about times or speeds of parts: friction and restitution that fit, and each row beside them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from vibro.answers.answer import Answer, Fact, Table, given_text, shown
from vibro.errors import printable
from vibro.files.csv_tables import columns_of
from vibro.files.points import MEAN_VELOCITY, TRAVERSE_TIME
from vibro.quantities import QUANTITIES
from vibro.records.speeds import next_text
from vibro.units import SPEED

if TYPE_CHECKING:
    from vibro.files.csv_tables import TableColumns
    from vibro.records.speeds import SpeedFit, SpeedParameter, SpeedQuestion

_DIGITS: Final = 3
_ERROR_IS: Final = {
    "stated": "as stated",
    "widened": "more than stated, as the rows scatter more",
    "scatter": "from the scatter of the rows",
    "assumed": "assumed",
}


def speeds_answer(found: SpeedFit, question: SpeedQuestion) -> Answer:
    """Make the answer about times or speeds.

    Parameters
    ----------
    found : SpeedFit
        What they tell.
    question : SpeedQuestion
        The rest of the scene.
    """
    table, request = found.table, question.request
    taken = {*table.settings, *(["amplitude"] if "stroke" in table.settings else [])}
    taken |= {parameter.name for parameter in found.parameters}
    others = {name: x for name, x in request.given_values.items() if name not in taken}
    others |= {name: x for name, x in question.frictions.items() if name not in taken}
    count = f"{len(table.rows)} row" + "s" * (len(table.rows) > 1)
    what = "time" if table.is_time else "speed"
    error = f"{100.0 * found.error:.2g} % of a {what}, {_ERROR_IS[found.error_is]}"
    facts = [
        Fact("table", f"{printable(table.where)}: {count}"),
        Fact("scene", ": ".join(filter(None, (printable(request.name or ""), given_text(others))))),
        *map(_fact, found.parameters),
        Fact("error", error),
    ]
    if ahead := next_text(found):
        facts.append(Fact("measure next", ahead))
    rows = _rows(found)
    measured = TRAVERSE_TIME if table.is_time else MEAN_VELOCITY
    heads = [("row", ""), *((QUANTITIES[name].label, QUANTITIES[name].unit) for name in table.settings)]
    heads += [("measured", measured.unit), ("computed", measured.unit), ("difference", "errors"), ("", "")]
    cells = [[str(row["row"]), *_shown([*row.values()][1:])] for row in rows]
    notes = list(found.statements)
    if not found.parameters and not found.left_out:
        notes.append("nothing is fitted, as all is given: name what is to be found, such as --fit mu_d")
    record: dict[str, Any] = {
        "table": table.where,
        "scene": {**{QUANTITIES[n].column: x for n, x in others.items()}, "trough_length_mm": request.length},
        "fit": {parameter.name: _record(parameter) for parameter in found.parameters},
        "error_percent": 100.0 * found.error,
        "error_is": found.error_is,
        "rows": rows,
        "left_out": [table.rows[i] for i in found.left_out],
        "next_point": _next_record(found),
    }
    title = " – ".join(filter(None, (table.where.rpartition("/")[2], request.name)))
    return Answer(facts, [Table("table_rows", heads, cells, "Rows")], notes, record, title)


def speed_tables(found: SpeedFit) -> dict[str, TableColumns]:
    """Return the columns of its CSV: the rows, measured and computed."""
    return {"": columns_of(_rows(found))}


def _fact(parameter: SpeedParameter) -> Fact:
    """Write an estimate with its intervals."""
    label, pieces = QUANTITIES[parameter.name].label, []
    if parameter.is_untold:
        return Fact(label, None, note="all values that are tried fit")
    for interval in parameter.intervals:
        low, high = (shown(x, _DIGITS) for x in interval)
        pieces.append(f"{low} to {high}")
        if parameter.open_low and interval is parameter.intervals[0]:
            pieces[-1] = f"up to {high}"
        if parameter.open_high and interval is parameter.intervals[-1]:
            pieces[-1] = f"from {low}"
    return Fact(label, f"{shown(parameter.value, _DIGITS)} (95 %: {' or '.join(pieces)})")


def _record(parameter: SpeedParameter) -> dict[str, Any]:
    return {
        "estimate": None if parameter.is_untold else parameter.value,
        "intervals": [list(pair) for pair in parameter.intervals],
        "open_low": parameter.open_low,
        "open_high": parameter.open_high,
    }


def _rows(found: SpeedFit) -> list[dict[str, Any]]:
    """Return the rows, with what was measured as the table has it."""
    table, rows = found.table, []
    quantity = TRAVERSE_TIME if table.is_time else MEAN_VELOCITY
    for i, number in enumerate(table.rows):
        row: dict[str, Any] = {"row": number}
        row |= {QUANTITIES[name].column: float(x[i]) for name, x in table.settings.items()}
        speed = float(found.computed[i])
        computed = float(SPEED.from_si(speed))
        if table.is_time:
            computed = found.length / speed if speed > 0.0 else math.nan if math.isnan(speed) else math.inf
        measured = float(quantity.from_si(table.measured[i]))
        remark = "left out" if i in found.left_out else ""
        rows.append({
            **row, quantity.column: measured, f"computed_{quantity.column}": computed,
            "difference_errors": float(found.errors[i]), "remark": remark,
        })  # fmt: skip
    return rows


def _shown(cells: list[Any]) -> list[Any]:
    """Write cells for people: never for a time that does not end, a difference to a tenth of an error."""
    *values, difference, remark = cells
    values = ["never" if x == math.inf else x for x in values]
    return [*values, None if math.isnan(difference) else f"{difference:z.1f}", remark]


def _next_record(found: SpeedFit) -> dict[str, Any] | None:
    point = found.next_point
    if point is None:
        return None
    return {
        **{QUANTITIES[name].column: value for name, value in point.setting.items()},
        "mean_velocity_low_mm_s": float(SPEED.from_si(point.low)),
        "mean_velocity_high_mm_s": float(SPEED.from_si(point.high)),
        "errors_apart": point.errors,
    }
