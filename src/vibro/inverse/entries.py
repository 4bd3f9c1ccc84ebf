"""What a key of a question may hold: a number, a band, limits, choices; read into SI units and radians."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.axes import parse_axis
from vibro.errors import InputError, shown
from vibro.quantities import nearest_double
from vibro.reals import NotRealError, real_number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vibro.quantities import Quantity

__all__ = ["Span", "band", "choices", "limits", "number", "text"]

#: Both ends of a closed interval.
Span = tuple[float, float]

_NUMBER: Final = "a finite number"
_BAND: Final = 'a finite number or a band "lo:hi"'
_LIMITS: Final = 'a finite number, the largest, or a range "lo:hi"'
_CHOICES: Final = 'a finite number, a list, or a range "lo:hi"'
_NO_MORE: Final = 'it takes no such list or count: "lo:hi" is all between two ends; decimals have a point'


def number(quantity: Quantity, value: Any) -> float:
    """Read one number.

    Parameters
    ----------
    quantity : Quantity
        What it is.
    value : object
        A number in the unit of the quantity's column, or a text that may have another unit.

    Returns
    -------
    float
        In SI units and radians.

    Raises
    ------
    InputError
        If it is no number that the quantity may have; the text begins with the quantity's column.
    """
    return _checked(quantity, value, [_double(quantity, value, _NUMBER)])[0]


def band(quantity: Quantity, value: Any) -> Span:
    """Read a band, as ``number`` does: a number, or ``lo:hi``, whose ends may be equal."""
    if _has_ends(value):
        return _range(quantity, value, _BAND)
    end = _checked(quantity, value, [_double(quantity, value, _BAND)])[0]
    return end, end


def limits(quantity: Quantity, value: Any) -> Span:
    """Read limits, as ``number`` does: the largest value, or ``lo:hi`` where lo may be 0."""
    if not _has_ends(value):
        return 0.0, _checked(quantity, value, [_double(quantity, value, _LIMITS)])[0]
    low, high = _ends(quantity, value, _LIMITS)
    if low == 0.0:
        return 0.0, _checked(quantity, value, [high])[0]
    return _range(quantity, value, _LIMITS)


def choices(quantity: Quantity, value: Any) -> tuple[Span, ...]:
    """Read choices, as ``number`` does: a number, an ascending list, or ``lo:hi``."""
    if _has_ends(value):
        return (_range(quantity, value, _CHOICES),)
    if isinstance(value, str):
        try:
            numbers = [float(item) for item in parse_axis(value, quantity).values]
        except InputError as exc:
            raise _by_column(exc, quantity) from exc
    else:
        items = value.tolist() if isinstance(value, np.ndarray) else value
        items = items if isinstance(items, list | tuple) else [items]
        numbers = [_double(quantity, item, _CHOICES) for item in items]
    if not numbers:
        raise _wrong(quantity, value, _CHOICES)
    if any(after <= before for before, after in pairwise(numbers)):
        raise InputError(f"{quantity.column} = {shown(value)}: the values of a list must ascend and differ")
    return tuple((end, end) for end in _checked(quantity, value, numbers))


def text(key: str, value: Any) -> str:
    """Read a text on one line that says something."""
    if not isinstance(value, str) or not value.strip() or not value.isprintable():
        raise InputError(f"{key} = {shown(value)}: must be a text on one line")
    return value.strip()


def _has_ends(value: Any) -> bool:
    return isinstance(value, str) and ":" in value


def _range(quantity: Quantity, value: str, wanted: str) -> Span:
    low, high = _checked(quantity, value, _ends(quantity, value, wanted))
    return low, high


def _ends(quantity: Quantity, value: str, wanted: str) -> Span:
    """Read both ends of a range, in the unit outside."""
    ends = value.split(":")
    if len(ends) != 2 or not all(map(str.strip, ends)):
        raise _wrong(quantity, value, wanted)
    low, high = (_double(quantity, end, wanted) for end in ends)
    if low > high:
        unit = f"; without a unit of its own an end is in {quantity.unit}" if quantity.unit else ""
        raise InputError(
            f"{quantity.column} = {shown(value)}: must be lo:hi with lo at most hi",
            hint=f"{quantity.column}: give the lower end first{unit}",
        )
    return low, high


def _double(quantity: Quantity, value: Any, wanted: str) -> float:
    """Read a number in the unit outside."""
    if isinstance(value, str):
        if "," in value:
            raise _wrong(quantity, value, wanted)
        try:
            return nearest_double(value, quantity)
        except InputError as exc:
            raise _by_column(exc, quantity) from exc
    try:
        double = real_number(value)
    except NotRealError:
        double = math.nan
    if not math.isfinite(double):
        raise _wrong(quantity, value, wanted)
    return double


def _checked(quantity: Quantity, value: Any, numbers: Sequence[float]) -> list[float]:
    """Convert to SI units, and refuse what the quantity may not be."""
    converted = [float(quantity.to_si(double)) for double in numbers]
    if not all(map(quantity.allows, converted)):
        allowed = quantity.allowed.text(quantity.unit)
        raise InputError(f"{quantity.column} = {shown(value)}: must be {allowed}")
    return converted


def _wrong(quantity: Quantity, value: Any, wanted: str) -> InputError:
    several = isinstance(value, list | tuple) or (isinstance(value, str) and ("," in value or ":" in value))
    hint = f"{quantity.column}: {_NO_MORE}" if several and wanted != _NUMBER else ""
    return InputError(f"{quantity.column} = {shown(value)}: must be {wanted}", hint=hint)


def _by_column(exc: InputError, quantity: Quantity) -> InputError:
    """Name a quantity as the file does, with its unit."""
    (problem,) = exc.problems
    hint = f"{quantity.column}: {exc.hint}" if exc.hint else ""
    return InputError(quantity.column + problem.removeprefix(quantity.label), hint=hint)
