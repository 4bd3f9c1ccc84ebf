"""Zeros of functions of one variable: by halving, by false position, and by Newton's iteration.

Each function takes ``of``, a record that says what it is of. Which method a zero needs, and that its bracket
holds one, is proved where it is called.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["Root", "Value", "bisected", "illinois", "newton"]

_HALVINGS: Final = 60  # from an interval of some turns, or of its end's size, down to an ulp
_FALSE_POSITIONS: Final = 200
_ROOT_NOISE: Final = 4.0 * 2.220446049250313e-16  # [1] of a bracket's width
_NEWTON_STEPS: Final = 60  # monotone, quadratic but next to double zeros; few zeros need more than 8

Of = TypeVar("Of")


class Value(NamedTuple):
    """Value of a function, and its slope there."""

    value: float
    slope: float


class Root(NamedTuple):
    """Where Newton's iteration ends, and whether that is a zero."""

    at: float
    found: bool


def bisected(
    function: Callable[[Of, float], float], of: Of, low: float, high: float, positive: bool
) -> float:
    """Halve an interval at whose end a function has another sign; ``positive``: where it starts, it is."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if (function(of, middle) > 0.0) == positive:
            low = middle
        else:
            high = middle
    return high


def illinois(
    function: Callable[[Of, float], float], of: Of, low: float, high: float, below: float, above: float
) -> float:
    """Solve for a zero between a value ``below`` 0 and one ``above``, at the end.

    By false position that halves the weight of an end which stays.
    """
    x = high
    for _ in range(_FALSE_POSITIONS):
        if above - below <= 0.0 or high - low <= _ROOT_NOISE * high:
            break
        x = high - above * ((high - low) / (above - below))
        if not low < x < high:
            x = 0.5 * (low + high)
        value = function(of, x)
        if value == 0.0:
            break
        if value > 0.0:
            high, above, below = x, value, 0.5 * below
        else:
            low, below, above = x, value, 0.5 * above
    return x


def newton(
    function: Callable[[Of, float], Value], of: Of, start: float, end: float, share: float, least: float
) -> Root:
    """Fall from a start to a zero, where the curvature makes steps converge from one side.

    There is none where the function ceases to fall, or not before ``end``. A last step below ``least``, or a
    ``share`` of the zero, leaves rounding errors alone.
    """
    x = start
    for _ in range(_NEWTON_STEPS):
        now = function(of, x)
        if now.slope >= 0.0:
            return Root(x, False)
        step = -now.value / now.slope
        x += step
        if x > end:
            return Root(x, False)
        if abs(step) <= share * x + least:
            break
    return Root(x, True)
