"""Axes of sweeps: the range syntax, and values in the user's units exactly as given."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro.errors import InputError, cut, shown
from vibro.quantities import QUANTITIES, Quantity, exact_number, quantity_meant
from vibro.reals import NotRealError, real_array

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

_BARE: Final = re.compile(r"[^a-zA-Z\u00b0\u00b5\u03bc]*")
_UNITS: Final = "its units are"  # how a hint about a unit begins
_REPEATED: Final = 40  # characters of a text that a hint repeats
# Two numbers between which something stands that vibro does not read: 5..60, 5-60, 5 to 60, 5;60.
_OTHERWISE: Final = re.compile(r".*[0-9]\S*\s*(?:\.\.|[-\u2013\u2014\u2026;]|to)\s*[+-]?\.?[0-9].*")


def _order_hint(parts: Sequence[str], quantity: Quantity) -> str:
    """Return how to write a range that descends, or whose parts stand as in MATLAB's start:step:stop."""
    try:
        first, second, *third = (exact_number(part, quantity) for part in parts)
    except InputError:
        return "write lo:hi:count, or lo:hi:step=d"
    if third and 0 < second <= third[0] - first:
        return f"for start:step:stop write {parts[0]}:{parts[2]}:step={parts[1]}"
    if first == second:
        return f"write {parts[0]} for one value"
    bare = [bool(_BARE.fullmatch(part)) for part in parts[:2]]
    if second < first and bare[0] != bare[1]:
        return f"a number without a unit is in {quantity.unit}: give both ends their unit"
    low, high = (parts[0], parts[1]) if first < second else (parts[1], parts[0])
    step = parts[2] if third and 0 < third[0] <= abs(second - first) else "d"
    return f"write {low}:{high}:step={step}" + f", or {low}:{high}:count" * (step == "d")


# An axis longer than the largest sweep that is written to one table is a slip of the keyboard.
MAX_VALUES: Final = 10_000_000

_ALLOWED: Final = "a number or an axis"
_HINTED: Final = 12  # values that a hint lists

_COUNT: Final = Quantity("count")
_STEP: Final = Quantity("step of a logarithmic range")
# Two whole numbers without a blank between them: 1,5 may be a decimal.
_DECIMAL_COMMA = re.compile(
    r"\s*([+\u2212-]?(?:[0-9]{1,20}|[0-9]{1,3}(?:\.[0-9]{3})+)),"
    r"([0-9]{1,20}(?:[eE][+-]?[0-9]+)?\s*(?:[^\W\d_][^,:]*|[\u00b0%]|1?/[^,:]*)?)\s*"
)
# Of these any comma may be that of a decimal.
_WHOLE_NUMBERS = re.compile("'[0-9]+(?:,[0-9]+)+'")


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis of a sweep.

    Attributes
    ----------
    name : str
        A key of ``QUANTITIES``.
    values : float array
        Strictly ascending, in the quantity's default unit.
    spacing : str
        ``"linear"``, ``"log"`` or ``"list"``.
    """

    name: str
    values: NDArray[np.float64]
    spacing: str

    @property
    def label(self) -> str:
        """The quantity in words."""
        return QUANTITIES[self.name].label

    @property
    def unit(self) -> str:
        """Unit of the values; empty for pure numbers."""
        return QUANTITIES[self.name].unit

    @property
    def column(self) -> str:
        """Name with unit, as tables spell it."""
        return QUANTITIES[self.name].column

    @property
    def on_paper(self) -> NDArray[np.float64]:
        """The values as pictures space them: of a logarithmic axis their logarithms."""
        return np.log(self.values) if self.spacing == "log" else self.values

    @property
    def in_stroke(self) -> Axis:
        """The same axis in strokes, if it is one of amplitudes of a line."""
        return replace(self, name="stroke", values=2.0 * self.values) if self.name == "amplitude" else self

    def __len__(self) -> int:
        return len(self.values)

    def __str__(self) -> str:
        """Return a summary of the axis: ``amplitude: 200 values, 0.1 ... 3 mm, step 0.0146``."""
        n, first, last = len(self), float(self.values[0]), float(self.values[-1])
        if self.spacing == "list":
            values = ", ".join(f"{v:.6g}" for v in self.values[:8]) + (", ..." if n > 8 else "")
            return f"{self.label}: {n} values, {values} {self.unit}".rstrip()
        if self.spacing == "log":
            step = f"factor {(last / first) ** (1 / (n - 1)):.4g}"
        else:
            step = f"step {(last - first) / (n - 1):.3g}"
        digits = next(d for d in (6, 9, 12, 17) if d == 17 or f"{first:.{d}g}" != f"{last:.{d}g}")
        ends = f"{first:.{digits}g} ... {last:.{digits}g}"
        return f"{self.label}: {n} values, {ends} {self.unit}".rstrip() + f", {step}"


@dataclass(frozen=True)
class AxisSpec:
    """Values as a user gives them: one value, a list, or a range whose count may still be open.

    Numbers are in the quantity's default unit.

    Attributes
    ----------
    quantity : Quantity
        What is given.
    values : tuple of Fraction or float
        The value or the list; or both ends of the range, exact, from which its values follow.
    is_range : bool
        Whether ``values`` are both ends of a range.
    count : int or None
        Number of values of a range; None where the number of axes decides.
    log : bool
        Whether a range is spaced geometrically.
    """

    quantity: Quantity
    values: tuple[Fraction | float, ...]
    is_range: bool = False
    count: int | None = None
    log: bool = False

    @property
    def varies(self) -> bool:
        """Whether this is more than one value."""
        return len(self.values) > 1

    @property
    def value(self) -> float:
        """The only value."""
        (value,) = self.values
        return float(value)

    def halved(self, quantity: Quantity) -> AxisSpec:
        """Give half the values as another quantity: a stroke as its amplitude."""
        return replace(self, quantity=quantity, values=tuple(v / 2 for v in self.values))

    def axis(self, count: int) -> Axis:
        """Spell out the values.

        Parameters
        ----------
        count : int
            Number of values of a range that leaves it open.

        Returns
        -------
        Axis
            Every value is the double nearest to the exact one, so ``0.1:0.5:5`` holds 0.3, not
            0.30000000000000004. Between its ends a geometric range is rounded to 15 digits.
        """
        values = self._spelled_out(count)
        if not np.all(values[1:] > values[:-1]):
            ends = f"{self.quantity.text(self.values[0])} ... {self.quantity.text(self.values[-1])}"
            raise InputError(
                f"{self.quantity.label} = {ends}: {len(values)} values are too close for doubles",
                hint="ask for fewer values, or a wider range",
            )
        spacing = "list" if not self.is_range else "log" if self.log else "linear"
        return Axis(self.quantity.name, values, spacing)

    def _spelled_out(self, count: int) -> NDArray[np.float64]:
        if not self.is_range:
            return np.array(self.values, np.float64)
        n = self.count or count
        first, last = (Fraction(end) for end in self.values)
        if self.log:
            with np.errstate(over="ignore"):  # at the end, which is replaced by the exact value
                powers = np.geomspace(float(first), float(last), n)
            # 15 digits, so that 5:80:step=2:log holds 10, not 10.000000000000002.
            powers[1:-1] = [float(f"{v:.15g}") for v in powers[1:-1].tolist()]
            return powers
        # i-th value = (start + i step) / scale in whole numbers, whose quotient Python rounds correctly.
        scale = first.denominator * last.denominator * (n - 1)
        start = first.numerator * last.denominator * (n - 1)
        step = last.numerator * first.denominator - first.numerator * last.denominator
        return np.fromiter(((start + i * step) / scale for i in range(n)), float, n)


def default_count(varying: int) -> int:
    """Return the number of values of a range that does not say, where so many axes vary."""
    return {1: 200, 2: 100}.get(varying, 20)


def axis_of(value: object, quantity: Quantity) -> AxisSpec:
    """Read an axis from what a program or a scene file gives.

    Parameters
    ----------
    value : float, str, or list, tuple, range or array of them
        One value, ascending values, or the syntax of ``parse_axis``; in the quantity's unit outside, or as a
        text with a unit of its own.
    quantity : Quantity
        What the axis is of.

    Returns
    -------
    AxisSpec
        Numbers mean their shortest decimal form, as they would be typed.

    Raises
    ------
    InputError
        If it is none of these.
    """
    if isinstance(value, str):
        return parse_axis(value, quantity)
    if isinstance(value, range) and value[MAX_VALUES:]:  # before memory is spent on it
        raise _too_many(shown(value), quantity)
    try:
        values = _doubles(value, quantity)
        if values.ndim > 1 or not values.size:
            raise NotRealError(shown(value), _ALLOWED)
    except NotRealError as exc:
        raise InputError(
            f"{quantity.column} = {exc.value}: must be {exc.allowed}",
            hint='write it like 1.5, "0.1:3:200" or [10, 20, 30]',
        ) from None
    if values.size > MAX_VALUES:
        raise _too_many(shown(value), quantity)
    beyond = values[~np.isfinite(values)]
    if beyond.size:
        raise InputError(f"{quantity.label} = {beyond[0]}: must be a finite number")
    if values.ndim:
        _check_order(values, shown(value), quantity, "[{}]", ", ")
    return AxisSpec(quantity, tuple(_unsigned(values.ravel()).tolist()))


def one_value_of(value: object, quantity: Quantity) -> AxisSpec:
    """Read what should be one value as ``axis_of`` does, but a comma in a text as that of a decimal."""
    if isinstance(value, str) and _DECIMAL_COMMA.fullmatch(value):
        return AxisSpec(quantity, (exact_number(value, quantity),))
    return axis_of(value, quantity)


def drive_axis_of(
    value: object, quantity: Quantity, read: Callable[[object, Quantity], AxisSpec] = axis_of
) -> AxisSpec:
    """Read what a drive is given by; the unit of an amplitude may make it an acceleration or a speed.

    Parameters
    ----------
    value : object
        As for ``read``.
    quantity : Quantity
        What the axis is of, unless the value is an amplitude, or a stroke, in other units.
    read : callable
        ``axis_of`` or ``one_value_of``.

    Returns
    -------
    AxisSpec
        Of the quantity, or of ``acceleration`` or ``drive_speed``: of a stroke half of what is given, as this
        is from peak to peak.
    """
    items = value if isinstance(value, list | tuple) else [value]
    meant = quantity_meant((item for item in items if isinstance(item, str)), quantity)
    try:
        spec = read(value, meant)
    except InputError as exc:
        is_size = meant.name in ("amplitude", "stroke")
        rates = "; of its acceleration g or m/s^2, of its speed mm/s; from peak to peak it is the stroke"
        more = rates if is_size and _UNITS in exc.hint else ""
        raise InputError(*exc.problems, hint=exc.hint + more) from None
    return spec.halved(meant) if quantity.name == "stroke" and meant is not quantity else spec


def _doubles(value: Any, quantity: Quantity) -> NDArray[np.float64]:
    """Convert given values to doubles; texts among them may have units."""
    if hasattr(value, "__array__") and not isinstance(value, np.ma.MaskedArray):
        value = np.asarray(value)  # of pandas
        value = value.tolist() if value.dtype.kind in "OTU" else value
    if isinstance(value, list | tuple):
        kinds = set(map(type, value))
        if not kinds <= {int, float} and any(issubclass(kind, str) for kind in kinds):
            value = [float(exact_number(item, quantity)) if isinstance(item, str) else item for item in value]
    return real_array(value, _ALLOWED)


def _unsigned(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Replace -0.0 by 0.0: they are equal, and messages about either must be the same."""
    return values + 0.0


def _check_order(
    values: NDArray[np.float64], text: str, quantity: Quantity, form: str, separator: str
) -> None:
    """Refuse a list that does not ascend; the hint writes it as given, if it is short."""
    if np.all(values[1:] > values[:-1]):
        return
    hint = "sort its values, and give each once"
    if values.size <= _HINTED:
        hint = f"write {form.format(separator.join(f'{v:.15g}' for v in np.unique(values).tolist()))}"
        if _WHOLE_NUMBERS.fullmatch(text):
            hint = f"decimals have a point, like 1.5; if these are whole numbers {hint}"
    raise InputError(f"{quantity.label} = {text}: the values of a list must ascend and differ", hint=hint)


def parse_axis(text: str, quantity: Quantity) -> AxisSpec:
    """Read an axis: a value, a list ``a,b,c``, or a range.

    Parameters
    ----------
    text : str
        ``15``, ``15,20,25``, ``lo:hi``, ``lo:hi:count`` or ``lo:hi:step=d``; a range may end in
        ``:log``, where the step is the factor from one value to the next. Numbers may carry units.
    quantity : Quantity
        What the axis is of.

    Returns
    -------
    AxisSpec
        Its numbers are exact.

    Raises
    ------
    InputError
        If the text does not follow the syntax, does not ascend or has too many values.
    """
    if ":" in text:
        return _parse_range(text, quantity)
    if "," in text and ";" not in text:
        return _parse_list(text, quantity)
    try:
        return AxisSpec(quantity, (exact_number(text, quantity),))
    except InputError as exc:
        if len(text) <= _REPEATED and _OTHERWISE.fullmatch(text):
            hint = "write a range like 5:60, and a list like 15,20,25"
            raise InputError(*exc.problems, hint=hint) from None
        raise


def _parse_list(text: str, quantity: Quantity) -> AxisSpec:
    if len(text) <= _REPEATED and (match := _DECIMAL_COMMA.fullmatch(text)):
        first, last = match[1].replace(".", ""), match[2]
        raise InputError(
            f"{quantity.label} = {shown(text)}: a decimal comma, or two values",
            hint=f"write {first}.{last} or '{first}, {last}' for two values",
        )
    items = text.split(",")
    if not all(map(str.strip, items)):
        raise InputError(
            f"{quantity.label} = {shown(text)}: a list with an empty item", hint="write a list like 15,20,25"
        )
    if len(items) > MAX_VALUES:
        raise _too_many(shown(text), quantity)
    values = np.array([float(exact_number(item, quantity)) for item in items])
    _check_order(values, shown(text), quantity, *(("'{}'", ", ") if values.size == 2 else ("{}", ",")))
    return AxisSpec(quantity, tuple(_unsigned(values).tolist()))


def _parse_range(text: str, quantity: Quantity) -> AxisSpec:
    parts = [part.strip() for part in text.split(":")]
    log = len(parts) > 2 and parts[-1].casefold() == "log"
    if log:
        parts.pop()
    if not 2 <= len(parts) <= 3 or not all(parts):
        raise InputError(
            f"{quantity.label} = {shown(text)}: not a range",
            hint="write lo:hi, lo:hi:count or lo:hi:step=d, each with an optional :log",
        )
    first, last = exact_number(parts[0], quantity), exact_number(parts[1], quantity)
    third = parts[2] if len(parts) == 3 else None
    if last <= first:
        raise InputError(
            f"{quantity.label} = {shown(text)}: the range does not ascend", hint=_order_hint(parts, quantity)
        )
    if log and first <= 0:
        raise InputError(f"{quantity.label} = {shown(text)}: a logarithmic range must start above 0")
    if third is None:
        return AxisSpec(quantity, (first, last), is_range=True, log=log)
    if third.casefold().startswith("step="):
        return _stepped(text, quantity, first, last, third[5:], log)
    return AxisSpec(quantity, (first, last), is_range=True, count=_count(text, quantity, parts), log=log)


def _count(text: str, quantity: Quantity, parts: list[str]) -> int:
    try:
        count = exact_number(parts[2], _COUNT)
    except InputError:
        count = Fraction(1, 2)
    if count.denominator != 1:
        raise InputError(
            f"{quantity.label} = {shown(text)}: the count {shown(parts[2])} is not a whole number",
            hint=_order_hint(parts, quantity),
        )
    if count < 2:
        raise InputError(
            f"{quantity.label} = {shown(text)}: a range has at least 2 values", hint=f"write {cut(parts[0])}"
        )
    if count > MAX_VALUES:
        raise _too_many(shown(text), quantity)
    return int(count)


def _stepped(
    text: str, quantity: Quantity, first: Fraction, last: Fraction, step_text: str, log: bool
) -> AxisSpec:
    if log:
        factor = exact_number(step_text, _STEP)
        if float(factor) <= 1.0:
            raise InputError(
                f"{quantity.label} = {shown(text)}: the step of a logarithmic range is a factor above 1"
            )
        # The quotient's rounding must not cost the last value of 5:80:step=2:log.
        steps = int((math.log(last) - math.log(first)) / math.log(factor) + 1e-9)
        end = Fraction(_decimal(first) * _decimal(factor) ** min(steps, MAX_VALUES))
    else:
        step = exact_number(step_text, quantity)
        if step <= 0:
            raise InputError(f"{quantity.label} = {shown(text)}: the step must be above 0")
        steps = int((last - first) / step)
        end = first + steps * step
    if steps < 1:
        raise InputError(f"{quantity.label} = {shown(text)}: the step is longer than the range")
    if steps >= MAX_VALUES:
        raise _too_many(shown(text), quantity)
    return AxisSpec(quantity, (first, end), is_range=True, count=steps + 1, log=log)


def _decimal(number: Fraction) -> Decimal:
    """Return a number to 28 digits, whose powers neither grow as a fraction's do nor overflow."""
    return Decimal(number.numerator) / Decimal(number.denominator)


def _too_many(text: str, quantity: Quantity) -> InputError:
    return InputError(
        f"{quantity.label} = {text}: more than {MAX_VALUES} values on one axis", hint="ask for fewer values"
    )
