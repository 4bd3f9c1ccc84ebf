"""The answer about times or speeds of parts: friction and restitution that fit, and each row beside them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from vibro.answers.answer import Answer, Fact, Table, given_text, shown
from vibro.answers.measurement import scene_table
from vibro.errors import printable
from vibro.files.csv_tables import columns_of
from vibro.files.points import ACCELERATION, MEAN_VELOCITY, TRAVERSE_TIME
from vibro.quantities import QUANTITIES, SIZES
from vibro.records.speeds import is_untold, next_text
from vibro.units import SPEED

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vibro.files.csv_tables import TableColumns
    from vibro.quantities import Quantity
    from vibro.records.speeds import SpeedFit, SpeedParameter, SpeedQuestion

_DIGITS: Final = 3
_ERROR_IS: Final = {
    "stated": "as stated",
    "widened": "more than stated, as the rows scatter more",
    "scatter": "from the scatter of the rows",
    "assumed": "assumed",
}
_SETTINGS: Final[Mapping[str, Quantity]] = {**QUANTITIES, ACCELERATION.name: ACCELERATION}


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
    columns = {name: _SETTINGS[name] for name in table.settings}
    settings = len({*zip(*(x.tolist() for x in table.settings.values()), strict=True)}) if columns else 1
    size = f"{len(table.rows)} rows, {settings} settings".replace("1 rows", "1 row").replace(
        "1 settings", "1 setting"
    )
    varied = [
        f"{columns[name].label} {x.min():.6g} to {x.max():.6g} {columns[name].unit}".rstrip()
        for name, x in table.settings.items()
        if x.min() < x.max()
    ]
    taken = {*columns, "amplitude", "restitution"} if {*columns} & {*SIZES} else {*columns, "restitution"}
    others = {name: x for name, x in request.given_values.items() if name not in taken}
    others |= dict(question.frictions)
    what = "time" if table.is_time else "speed"
    error = f"{100.0 * found.error:.2g} % of a {what}, {_ERROR_IS[found.error_is]}"
    facts = [
        Fact("table", f"{printable(table.where)}: {', '.join([size, *varied])}"),
        Fact("scene", ": ".join(filter(None, (printable(request.name or ""), given_text(others))))),
        *map(_fact, found.parameters),
        Fact("error", error),
    ]
    if ahead := next_text(found):
        facts.append(Fact("measure next", ahead))
    rows = _rows(found)
    measured = TRAVERSE_TIME if table.is_time else MEAN_VELOCITY
    heads = [("row", ""), *((q.label, q.unit) for q in columns.values())]
    heads += [("measured", measured.unit), ("computed", measured.unit), ("difference", "errors"), ("", "")]
    cells = [[str(row["row"]), *_shown([*row.values()][1:])] for row in rows]
    notes = list(found.statements)
    if not found.parameters and not found.left_out:
        notes.append("nothing is fitted, as all is given: name what is to be found, such as --fit mu_d")
    record: dict[str, Any] = {
        "table": table.where,
        "scene": {
            key: x
            for key, x in scene_table(request).items()
            if key not in {QUANTITIES[n].column for n in taken if n != "restitution"}
        }
        | {QUANTITIES[name].column: x for name, x in question.frictions.items()},
        "fit": {parameter.name: _record(parameter) for parameter in found.parameters},
        "error_percent": 100.0 * found.error,
        "error_is": found.error_is,
        "rows": rows,
        "left_out": [table.rows[i] for i in found.left_out],
        "doubtful": [table.rows[i] for i in found.doubtful],
        "next_point": _next_record(found),
    }
    title = " – ".join(filter(None, (table.where.rpartition("/")[2], request.name)))
    return Answer(facts, [Table("table_rows", heads, cells, "Rows")], notes, record, title)


def speed_tables(found: SpeedFit) -> dict[str, TableColumns]:
    """Return the columns of its CSV: the rows, measured and computed."""
    return {"": columns_of(_rows(found))}


def _fact(parameter: SpeedParameter) -> Fact:
    """Write estimates with their intervals."""
    label = QUANTITIES[parameter.name].label
    if is_untold(parameter):
        return Fact(label, None, note="all values that are tried fit")
    pieces = []
    for i, (low, high) in enumerate(parameter.intervals):
        value = " or ".join(shown(x, _DIGITS) for x in parameter.values[i])
        ends = [shown(low, _DIGITS), shown(high, _DIGITS)]
        interval = f"{ends[0]} to {ends[1]}"
        if parameter.open_low and i == 0:
            interval = f"up to {ends[1]}"
        if parameter.open_high and i == len(parameter.intervals) - 1:
            interval = f"from {ends[0]}"
        pieces.append(f"{value} (95 %: {interval})")
    return Fact(label, ", or ".join(pieces) or None)


def _record(parameter: SpeedParameter) -> dict[str, Any]:
    pieces = parameter.intervals
    return {
        "estimate": None if is_untold(parameter) else parameter.value,
        "estimates": [list(values) for values in parameter.values],
        "intervals": [list(pair) for pair in pieces],
        "low": pieces[0][0] if pieces else math.nan,
        "high": pieces[-1][1] if pieces else math.nan,
        "open_low": parameter.open_low,
        "open_high": parameter.open_high,
    }


def _rows(found: SpeedFit) -> list[dict[str, Any]]:
    """Return the rows, with what was measured as the table has it."""
    table, rows = found.table, []
    quantity = TRAVERSE_TIME if table.is_time else MEAN_VELOCITY
    for i, number in enumerate(table.rows):
        row: dict[str, Any] = {"row": number}
        row |= {_SETTINGS[name].column: float(x[i]) for name, x in table.settings.items()}
        speed = float(found.computed[i])
        computed = float(SPEED.from_si(speed))
        if table.is_time:
            computed = (
                float(found.length[i]) / speed if speed > 0.0 else math.nan if math.isnan(speed) else math.inf
            )
        measured = float(quantity.from_si(table.measured[i]))
        remark = "left out" if i in found.left_out else "in doubt" if i in found.doubtful else ""
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
        **{_SETTINGS[name].column: value for name, value in point.setting.items()},
        "mean_velocity_low_mm_s": float(SPEED.from_si(point.low)),
        "mean_velocity_high_mm_s": float(SPEED.from_si(point.high)),
        "errors_apart": point.errors,
    }
