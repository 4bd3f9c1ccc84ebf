"""How to write a range that somebody wrote in another way: as in MATLAB, as in a text, or downwards."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from vibro.errors import InputError
from vibro.quantities import exact_number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.quantities import Quantity

__all__ = ["order_hint", "spelling_hint"]

_REPEATED: Final = 40  # characters of a text that a hint repeats
_BARE = re.compile(r"[^a-zA-Z\u00b0\u00b5\u03bc]*")
_NUMBER: Final = r"([+-]?(?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)(?:e[+-]?[0-9]+)?)\s*([^\W\d_]+|\u00b0)?"
_OTHERWISE = re.compile(rf"\s*{_NUMBER}\s*(\.{{2,}}|[-\u2013\u2014\u2026;]|to)\s*{_NUMBER}\s*", re.IGNORECASE)


def spelling_hint(text: str, quantity: Quantity) -> str:
    """Return how to write a range given as ``5..60``, ``5-60``, ``5 to 60`` or ``5;60``; else an empty text.

    A unit that stands at the end alone is meant for both ends.
    """
    match = _OTHERWISE.fullmatch(text) if len(text) <= _REPEATED else None
    if match is None:
        return ""
    first, unit, between, last, last_unit = match.groups("")
    ends = [first + (unit or last_unit), last + last_unit]
    try:
        ends.sort(key=lambda end: exact_number(end, quantity))
    except InputError:
        return ""
    also = f", for two values '{', '.join(ends)}'" if between == ";" else ""
    return f"for a range write {':'.join(ends)}{also}"


def order_hint(parts: Sequence[str], quantity: Quantity) -> str:
    """Return how to write a range whose parts are in another order, as in MATLAB's start:step:stop."""
    try:
        numbers = [exact_number(part, quantity) for part in parts]
    except InputError:
        numbers = []
    if not numbers or max(map(len, parts)) > _REPEATED:
        return "write lo:hi:count, or lo:hi:step=d"
    first, second, *third = numbers
    if third and 0 < second <= third[0] - first:
        return f"for start:step:stop write {parts[0]}:{parts[2]}:step={parts[1]}"
    if third and 0 < third[0] <= second - first:
        return f"write {parts[0]}:{parts[1]}:step={parts[2]}"
    if first == second:
        return f"write {parts[0]} for one value"
    if first < second:
        return f"write {parts[0]}:{parts[1]}:3 for 3 values, or {parts[0]}:{parts[1]}:step=d for a step of d"
    bare = [bool(_BARE.fullmatch(part)) for part in parts[:2]]
    if quantity.unit and bare[0] != bare[1]:
        return f"a number without a unit is in {quantity.unit}: give both ends their unit"
    return f"write {parts[1]}:{parts[0]}, or {parts[1]}:{parts[0]}:step=d for a step of d"
