"""Doubles: arguments of any type become such, and what callers ask of NumPy about them stays outside."""

from __future__ import annotations

import sys
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from numbers import Real
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.errors import shown

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    # Arrays, in the annotations of all rooms.
    Floats = NDArray[np.float64]
    Bools = NDArray[np.bool_]
    Complexes = NDArray[np.complex128]


_ALLOWED: Final = "a real number or an array of real numbers"
_A_NUMBER: Final = "one real number"
_FINITE: Final = "finite"
#: Decorator of what is called from outside. Numbers may underflow or be undefined on the way to an answer, or
#: to its status. A caller's ``np.errstate(all="raise")`` is about the caller's own arithmetic: here NumPy
#: treats these as it does by default.
shielded: Final = np.errstate(divide="warn", over="warn", under="ignore", invalid="warn")
# Sequences of these alone are converted at once.
_PLAIN: Final = {int, float, np.int64, np.float64}


class NotRealError(ValueError):
    """Raised for a value that is no real number; the caller adds the name of the argument.

    Attributes
    ----------
    value : str
        The first such value, as a message shows it.
    allowed : str
        What it must be.
    """

    def __init__(self, value: str, allowed: str) -> None:
        self.value = value
        self.allowed = allowed
        super().__init__(f"{value}: must be {allowed}")


def real_array(value: Any, allowed: str = _ALLOWED) -> Floats:
    """Convert numbers to doubles, and refuse values that NumPy converts although they are no numbers.

    Parameters
    ----------
    value : array_like
        Numbers of any type and shape, with ``Fraction`` and ``Decimal``. Refused are texts and bytes, truth
        values, complex numbers, dates and times, masked and missing values, and whole numbers beyond the
        range of doubles; a masked array without any masked value is an array.
    allowed : str, optional
        What it must be, for the message.

    Returns
    -------
    float array
        A new one, of the value's shape; it may hold NaN and inf, which are numbers to NumPy.

    Raises
    ------
    NotRealError
        With the first value that is no real number.
    """
    if type(value) is float:
        return np.array(value)
    if isinstance(value, list | tuple):
        return _of_sequence(value, allowed)
    if isinstance(value, str | bytes | bytearray | memoryview):
        raise NotRealError(shown(value), allowed)
    # Importing ``numpy.ma`` takes long; where nobody has, there is no such array.
    is_masked = "numpy.ma" in sys.modules and isinstance(value, np.ma.MaskedArray)
    if is_masked and not value.dtype.names and np.ma.is_masked(value):
        index = ", ".join(map(str, np.argwhere(np.ma.getmaskarray(value))[0]))
        raise NotRealError(f"masked (index {index})" if index else "masked", allowed)
    try:
        array = np.asarray(value)
    except (TypeError, ValueError, OverflowError, RuntimeError):
        raise NotRealError(shown(value), allowed) from None
    if array.dtype.kind in "fiu":
        with np.errstate(over="ignore"):  # of a type that is wider: inf, as all that is beyond the range
            return array.astype(np.float64)
    if array.dtype.kind != "O":
        first = array.flat[0] if array.ndim and array.size else value
        raise NotRealError(shown(first), allowed)
    return np.array([_of_object(item, allowed) for item in array.flat], np.float64).reshape(array.shape)


def real_number(value: Any) -> float:
    """Convert one number to a double, as ``real_array`` does.

    Raises
    ------
    NotRealError
        If it is no real number, or more than one.
    """
    array = real_array(value, _A_NUMBER)
    if array.shape:
        raise NotRealError(shown(value), _A_NUMBER)
    return float(array)


def _of_sequence(values: Sequence[Any], allowed: str) -> Floats:
    if _PLAIN.issuperset(map(type, values)):
        try:
            return np.array(values, np.float64)
        except OverflowError:  # some whole number: it is found below
            pass
    try:
        return np.array([real_array(value, allowed) for value in values], np.float64)
    except NotRealError:
        raise
    except (ValueError, RecursionError):  # lists of different lengths, or in themselves
        raise NotRealError(shown(values), allowed) from None


def _of_object(value: Any, allowed: str) -> float:
    # NumPy counts a span of time among the whole numbers, and Python a truth value.
    if isinstance(value, bool | np.timedelta64) or not isinstance(value, Real | Decimal):
        raise NotRealError(shown(value), allowed)
    try:
        return float(value)
    except OverflowError:
        raise NotRealError(shown(value), _FINITE) from None
    except ValueError:  # a signalling NaN
        raise NotRealError(shown(value), allowed) from None


def rounded(value: float, digits: int, *, down: bool) -> float:
    """Round to so many digits in one direction."""
    rounding = ROUND_FLOOR if down else ROUND_CEILING
    return float(Context(prec=digits, rounding=rounding).create_decimal(repr(float(value))))
