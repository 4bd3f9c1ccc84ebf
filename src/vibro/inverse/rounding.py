"""Settings in the units outside, with few digits."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import TYPE_CHECKING, Final

from vibro.inverse.questions import Setting
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from vibro.inverse.questions import Range
    from vibro.inverse.specs import Span

__all__ = ["in_si", "nearest", "outside", "rounded", "within"]

_SPELLED: Final = 15  # digits that tell every value that somebody gave


def in_si(printed: tuple[float, float, float]) -> Setting:
    """Convert a setting from the units outside."""
    return Setting(
        *(QUANTITIES[name].to_si(value) for name, value in zip(Setting._fields, printed, strict=True))
    )


def outside(ends: Range, setting: Setting) -> float:
    """Return how far a setting lies outside a range, relative to its values."""
    pairs = zip(ends, (setting.frequency, setting.drive_angle), strict=True)
    beyond = [max(low - x, x - high, 0.0) / (abs(x) or 1.0) for (low, high), x in pairs]
    return max(map(float, beyond))


def within(value: float, name: str, ends: Span, digits: int) -> float:
    """Round a value in the unit outside, but not beyond its range: a single value is kept."""
    quantity = QUANTITIES[name]
    low, high = (nearest(float(quantity.from_si(end)), _SPELLED) for end in ends)
    return min(max(nearest(value, digits), low), high)


def rounded(value: float, digits: int, *, down: bool) -> float:
    """Round to so many digits in one direction."""
    rounding = ROUND_FLOOR if down else ROUND_CEILING
    return float(Context(prec=digits, rounding=rounding).create_decimal(repr(value)))


def nearest(value: float, digits: int) -> float:
    """Round to so many digits."""
    return float(f"{value:.{digits}g}")
