"""Round settings to few digits in users' units."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import TYPE_CHECKING, Final

from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from vibro.inverse.specs import Span

__all__ = ["moved", "rounded", "within"]

_SPELLED: Final = 15  # digits that reproduce every value that a user gives


def within(value: float, name: str, ends: Span, digits: int) -> float:
    """Round a value in users' units, but not beyond its range; one that may be 0 is rounded to decimals."""
    quantity = QUANTITIES[name]
    low, high = (nearest(float(quantity.from_si(end)), _SPELLED) for end in ends)
    value = round(value, digits - 3) if quantity.allowed.low < 0.0 else nearest(value, digits)
    return min(max(value, low), high)


def rounded(value: float, digits: int, *, down: bool) -> float:
    """Round to so many digits in one direction."""
    rounding = ROUND_FLOOR if down else ROUND_CEILING
    return float(Context(prec=digits, rounding=rounding).create_decimal(repr(value)))


def nearest(value: float, digits: int) -> float:
    """Round to so many digits."""
    return float(f"{value:.{digits}g}")


def moved(value: float, digits: int, steps: int, *, up: bool) -> float:
    """Round a value up or down to some digits, then move it by some steps of the last one."""
    if value == 0.0:
        return value
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    count = math.ceil(value / unit) if up else math.floor(value / unit)
    return (count + steps) * unit
