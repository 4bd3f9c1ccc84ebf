"""Read the values of files: numbers, bands, choices, axes, texts."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from contextlib import suppress
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.axes import axis_of, parse_axis
from vibro.errors import InputError, did_you_mean, shown
from vibro.quantities import MOST_HARMONICS, catalogue_hint, exact_number, nearest_double
from vibro.reals import NotRealError, real_number
from vibro.waveforms import LEAST_SAMPLES, MOST_PIECES

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from vibro.axes import AxisSpec
    from vibro.quantities import Quantity

__all__ = [
    "AXIS", "BAND", "CHOICES", "COUNT", "FRICTION", "LIMITS", "LIST", "MASS_OR_FLOOR", "NUMBER", "PAIRS",
    "POINT", "POINTS", "SAMPLES", "SPAN", "TEXT", "VALUE", "Entry", "Form", "Span", "one_of", "table_of",
]  # fmt: skip

#: Both ends of a closed interval.
Span = tuple[float, float]

_NUMBER: Final = "a finite number"
_BAND: Final = 'a finite number or a band "lo:hi"'
_LIMITS: Final = 'a finite number, the largest, or a range "lo:hi"'
_CHOICES: Final = 'a finite number, a list, or a range "lo:hi"'
_NO_MORE: Final = 'no list or count is possible: "lo:hi" is all between two ends; decimals have a point'
# Matches the beginning of a name in the friction catalogue, but not of a number.
_NAME: Final = re.compile(r"\s*(?!(nan|inf|infinity)\b)[^\W\d_]", re.IGNORECASE)


class Form(NamedTuple):
    """A form of values.

    Attributes
    ----------
    says : str
        Its name, for tables of keys.
    read : callable
        ``read(quantity, value)`` returns an axis as given for scene files, SI units for designs. It
        raises InputError, which names the key or the quantity.
    spellings : tuple of str
        How it may be written: ``number``; as a text a number with a unit (``text``), ``lo:hi`` (``ends``),
        ``a,b,c`` (``listed``), an ``axis``, the ``name`` of a row of the catalogue or any ``line``; a
        ``list`` of these, a list of a ``single`` one, or a list of ``numbers``, ``pairs`` or ``samples``.
    words : tuple of str
        Allowed words, if it is one of a few.
    entries : tuple of Entry
        Keys of a table within a table.
    needed : tuple of str
        Those of them that every such table has.
    """

    says: str
    read: Callable[[Quantity, Any], Any]
    spellings: tuple[str, ...]
    words: tuple[str, ...] = ()
    entries: tuple[Entry, ...] = ()
    needed: tuple[str, ...] = ()


class Entry(NamedTuple):
    """A key of a table, with the quantity and the form of its value.

    Attributes
    ----------
    form : Form
        Form of the value.
    quantity : Quantity
        Unit, range and meaning; its column is the key.
    usual : str
        Default, for tables of keys.
    example : object
        Example for hints; None where no hint shows it.
    """

    form: Form
    quantity: Quantity
    usual: str = ""
    example: Any = None

    @property
    def key(self) -> str:
        """Key in the file, with its unit."""
        return self.quantity.column

    @property
    def shown(self) -> str:
        """Line of the file with the example."""
        return f"{self.key} = {json.dumps(self.example)}"

    def read(self, value: Any) -> Any:
        """Read a value of the key; raise InputError if it is not allowed."""
        return self.form.read(self.quantity, value)


def _number(quantity: Quantity, value: Any, wanted: str = _NUMBER) -> float:
    return _checked(quantity, value, [_double(quantity, value, wanted)])[0]


def _band(quantity: Quantity, value: Any) -> Span:
    """Read a number, or ``lo:hi``, whose ends may be equal."""
    if _has_ends(value):
        return _range(quantity, value, _BAND)
    end = _number(quantity, value, _BAND)
    return end, end


def _friction(quantity: Quantity, value: Any) -> Span | str:
    """Read a band; return the name of a catalogue row unchanged."""
    return value if isinstance(value, str) and _NAME.match(value) else _band(quantity, value)


def _limits(quantity: Quantity, value: Any) -> Span:
    """Read the largest value, or ``lo:hi`` where lo may be 0."""
    if not _has_ends(value):
        return 0.0, _number(quantity, value, _LIMITS)
    low, high = _ends(quantity, value, _LIMITS)
    if low == 0.0:
        return 0.0, _checked(quantity, value, [high])[0]
    return _range(quantity, value, _LIMITS)


def _choices(quantity: Quantity, value: Any) -> tuple[Span, ...]:
    """Read a number, an ascending list, or ``lo:hi``."""
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
        raise _refusal(quantity, value, "the values of a list must ascend and differ")
    return tuple((end, end) for end in _checked(quantity, value, numbers))


def _mass_or_floor(quantity: Quantity, value: Any) -> float:
    """Read a mass; that of the floor is infinite."""
    if value == "floor":
        return math.inf
    if isinstance(value, str) and not value.strip()[:1].isdigit():
        raise _wrong(quantity, value, f'{_NUMBER} or "floor"')
    return _number(quantity, value)


def _count(quantity: Quantity, value: Any) -> int:
    """Read a whole number, 1 or more."""
    number = _number(quantity, value)
    if number != int(number) or number < 1:
        raise _refusal(quantity, value, "must be a whole number, 1 or more")
    return int(number)


def _points(quantity: Quantity, value: Any) -> Any:
    """Read the name of a table, or pairs of numbers."""
    return _text(quantity, value) if isinstance(value, str) else _pairs(quantity, value)


def _text(quantity: Quantity, value: Any) -> str:
    """Read a text of one line that is not empty."""
    if not isinstance(value, str) or not value.strip() or not value.isprintable():
        raise _refusal(quantity, value, "must be a text on one line")
    return value.strip()


def _axis(quantity: Quantity, value: Any) -> AxisSpec:
    return axis_of(value, quantity)


def _point(quantity: Quantity, value: Any) -> AxisSpec:
    """Read an axis of one value, of a quantity that cannot be swept."""
    spec = axis_of(value, quantity)
    if spec.varies:
        hint = f"give {quantity.column} one value"
        raise _refusal(quantity, value, f"{quantity.label} cannot be an axis", hint)
    return spec


def _value(quantity: Quantity, value: Any) -> AxisSpec:
    """Read a number as an axis of one value; a text, also of a number with a unit, is refused."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return axis_of(value, quantity)
    hint = f"write {quantity.column} = 1.5"
    if isinstance(value, str):
        hint = _as_number(value, quantity) or catalogue_hint(value, quantity) or hint
        hint = "axes belong in the table [map]" if ":" in value else hint
    raise _refusal(quantity, value, "must be a number, without quotes", hint)


def _as_number(text: str, quantity: Quantity) -> str:
    """Return a text with a unit or a decimal comma rewritten as a number; empty if it is none."""
    for reading in (text, text.replace(",", ".")):
        with suppress(InputError):
            return f"write {quantity.column} = {float(exact_number(reading, quantity)):.15g}"
    return ""


def _list(quantity: Quantity, value: Any) -> list[float]:
    """Read a number for each harmonic."""
    if not _is_numbers(value, 1, MOST_HARMONICS):
        hint = f"write {quantity.column} = [1, 0.2]: a number for each of at most {MOST_HARMONICS} harmonics"
        raise _refusal(quantity, value, "must be a list of numbers", hint)
    return [*value]


def _pairs(quantity: Quantity, value: Any) -> list[list[float]]:
    """Read a list of pairs of numbers; the motion checks their values."""
    if not isinstance(value, list) or not value or not all(_is_numbers(pair, 2, 2) for pair in value):
        hint = f"write {quantity.column} = [[0.8, 6.9], [0.2, -27.6]]"
        raise _refusal(quantity, value, "must be a list of pairs of numbers", hint)
    return value


def _samples(quantity: Quantity, value: Any) -> list[float]:
    """Read samples of one period."""
    if not _is_numbers(value, LEAST_SAMPLES, MOST_PIECES):
        hint = f"write {quantity.column} = [0, 1.4, 2, 1.4, 0, -1.4, -2, -1.4]: one period, equally spaced"
        rule = f"must be a list of {LEAST_SAMPLES} to {MOST_PIECES} numbers"
        raise _refusal(quantity, value, rule, hint)
    return [*value]


def _is_numbers(value: Any, least: int, most: int) -> bool:
    return isinstance(value, list) and least <= len(value) <= most and all(map(_is_number, value))


def _is_number(value: Any) -> bool:
    return type(value) in (int, float)


def one_of(values: Mapping[str, Any]) -> Form:
    """Make the form of an entry whose value is one of several words."""

    def read(quantity: Quantity, value: Any) -> Any:
        if not isinstance(value, str) or value not in values:
            hint = did_you_mean(value, values)
            raise _refusal(quantity, value, f"must be {' or '.join(values)}", hint)
        return values[value]

    return Form(" or ".join(f"`{word}`" for word in values), read, (), (*values,))


def table_of(says: str, *entries: Entry, needed: tuple[str, ...], several: bool = False) -> Form:
    """Make the form of a table within a table, or of a list of such tables.

    Its ``read`` returns a dict of the values of its entries, by the names of their quantities; or a tuple of
    such.
    """
    keys = {entry.key: entry for entry in entries}

    def read_one(quantity: Quantity, value: Any) -> dict[str, Any]:
        if not isinstance(value, Mapping):
            example = ", ".join(entry.shown for entry in entries if entry.key in needed)
            raise _refusal(quantity, value, "must be a table", f"write {quantity.column} = {{ {example} }}")
        found = {}
        for key, given in value.items():
            if key not in keys:
                hint = did_you_mean(key, keys) or f"known are {', '.join(keys)}"
                raise InputError(f"{quantity.column} has an unknown key {shown(key)}", hint=hint)
            found[keys[key].quantity.name] = keys[key].read(given)
        for key in needed:
            if key not in value:
                raise InputError(
                    f"{quantity.column}: {key} is missing", hint=f"for example: {keys[key].shown}"
                )
        return found

    def read(quantity: Quantity, value: Any) -> Any:
        if not several:
            return read_one(quantity, value)
        tables = value if isinstance(value, list) and value else [value]
        return tuple(read_one(quantity, table) for table in tables)

    return Form(says, read, ("tables" if several else "table",), (), entries, needed)


def _has_ends(value: Any) -> bool:
    return isinstance(value, str) and ":" in value


def _range(quantity: Quantity, value: str, wanted: str) -> Span:
    low, high = _checked(quantity, value, _ends(quantity, value, wanted))
    return low, high


def _ends(quantity: Quantity, value: str, wanted: str) -> Span:
    """Read both ends of a range, in users' units."""
    ends = value.split(":")
    if len(ends) != 2 or not all(map(str.strip, ends)):
        raise _wrong(quantity, value, wanted)
    low, high = (_double(quantity, end, wanted) for end in ends)
    if low > high:
        unit = f"; without a unit of its own an end is in {quantity.unit}" if quantity.unit else ""
        hint = f"{quantity.column}: give the lower end first{unit}"
        raise _refusal(quantity, value, "must be lo:hi with lo at most hi", hint)
    return low, high


def _double(quantity: Quantity, value: Any, wanted: str) -> float:
    """Read a number, in users' units."""
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
    """Convert to SI units; raise InputError outside the quantity's range."""
    converted = [float(quantity.to_si(double)) for double in numbers]
    if not all(map(quantity.allows, converted)):
        raise _refusal(quantity, value, f"must be {quantity.allowed.text(quantity.unit)}")
    return converted


def _wrong(quantity: Quantity, value: Any, wanted: str) -> InputError:
    several = isinstance(value, list | tuple) or (isinstance(value, str) and ("," in value or ":" in value))
    hint = f"{quantity.column}: {_NO_MORE}" if several and wanted != _NUMBER else ""
    return _refusal(quantity, value, f"must be {wanted}", hint)


def _refusal(quantity: Quantity, value: Any, rule: str, hint: str = "") -> InputError:
    return InputError(f"{quantity.column} = {shown(value)}: {rule}", hint=hint)


def _by_column(exc: InputError, quantity: Quantity) -> InputError:
    """Return the quantity's key, for messages."""
    (problem,) = exc.problems
    hint = f"{quantity.column}: {exc.hint}" if exc.hint else ""
    return InputError(quantity.column + problem.removeprefix(quantity.label), hint=hint)


# Forms of scene files.
VALUE: Final = Form("number", _value, ("number",))
LIST: Final = Form(f"list of up to {MOST_HARMONICS} numbers", _list, ("numbers",))
PAIRS: Final = Form("list of pairs of numbers", _pairs, ("pairs",))
SAMPLES: Final = Form(f"list of {LEAST_SAMPLES} to {MOST_PIECES} numbers", _samples, ("samples",))
AXIS: Final = Form("number, list or axis", _axis, ("number", "text", "listed", "axis", "list"))
POINT: Final = Form("number", _point, ("number", "text", "single"))
# Forms of design questions.
NUMBER: Final = Form("number", _number, ("number", "text"))
BAND: Final = Form("number or band", _band, ("number", "text", "ends"))
FRICTION: Final = Form("number, band or row of the catalogue", _friction, (*BAND.spellings, "name"))
LIMITS: Final = Form("number, the largest, or range", _limits, ("number", "text", "ends"))
SPAN: Final = Form("number, fixed, or range", _band, BAND.spellings)
CHOICES: Final = Form("number, list or range", _choices, ("number", "text", "ends", "listed", "list"))
TEXT: Final = Form("text", _text, ("line",))
# Forms of machines.
MASS_OR_FLOOR: Final = Form("number or `floor`", _mass_or_floor, ("number", "text"), ("floor",))
COUNT: Final = Form("whole number", _count, ("number", "text"))
POINTS: Final = Form("name of a file, or list of pairs of numbers", _points, ("line", "pairs"))
