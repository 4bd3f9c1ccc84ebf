"""Symbols, units and numbers along axes, as the page prints them."""

from __future__ import annotations

import re
import unicodedata
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.ticker import LogLocator, MaxNLocator

from vibro.explore.bands import box_of
from vibro.plots.style import UNIT_SIGNS, number_text, value_text
from vibro.quantities import LISTED_HARMONICS, QUANTITIES, counted_harmonics

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from vibro.explore.state import State
    from vibro.quantities import Quantity

__all__ = ["caption_of", "even_ticks", "round_numbers", "symbol_of", "ticks_of", "unit_of"]

_NARROW: Final = 5.0  # ratio of its ends up to which a logarithmic axis has even steps


def symbol_of(quantity: Quantity) -> str:
    """Return the letter of a quantity: ``μ_s``."""
    return re.sub(
        r"\\(?:var)?([a-z]+)",
        lambda name: unicodedata.lookup(f"GREEK SMALL LETTER {name[1]}"),
        quantity.symbol,
    )


def unit_of(quantity: Quantity) -> str:
    """Return the unit outside: ``m/s²``."""
    return UNIT_SIGNS.get(quantity.unit, quantity.unit)


def caption_of(state: State) -> str:
    """List fixed quantities of a map without their usual values, as pictures do: ``α = 20°, μ_s = 0.74``."""
    grid = state.grid()
    spans = {name: (value, value) for name, value in {**grid.fixed, "trough_length": grid.length}.items()}
    if state.bands:
        static, second, is_ratio = box_of(state)
        del spans["kinetic_friction"]
        spans |= {"static_friction": static, "friction_ratio" if is_ratio else "kinetic_friction": second}
    parts = []
    for name, quantity in QUANTITIES.items():
        low, high = spans.get(name, (None, None))
        if low is None or high is None or quantity.order > LISTED_HARMONICS:
            continue
        if low != high or low != quantity.default:
            ends = dict.fromkeys((value_text(name, low), value_text(name, high)))
            parts.append(f"{symbol_of(quantity)} = {' to '.join(ends)}")
    return ", ".join([*parts, *counted_harmonics(grid.fixed)])


def round_numbers(low: float, high: float, *, log: bool = False, most: int = 8) -> list[float]:
    """List round numbers from ``low`` to ``high``, with at most so many steps."""
    if log and high > _NARROW * low:
        locator: Any = LogLocator(subs=(1.0, 2.0, 5.0) if high < 200.0 * low else (1.0,), numticks=99)
    else:
        locator = MaxNLocator(most, steps=[1, 2, 2.5, 5, 10])
    slack = 1e-9 * (high - low)
    return [
        float(number) for number in locator.tick_values(low, high) if low - slack <= number <= high + slack
    ]


def ticks_of(numbers: Iterable[float], share: Callable[[float], Any]) -> list[tuple[float, str]]:
    """Return positions of ticks, as shares of an axis, and their texts."""
    return [(float(np.clip(share(number), 0.0, 1.0)), number_text(number)) for number in numbers]


def even_ticks(low: float, high: float, *, most: int = 8) -> list[tuple[float, str]]:
    """Return the ticks of an axis with even spacing."""
    return ticks_of(round_numbers(low, high, most=most), lambda number: (number - low) / (high - low))
