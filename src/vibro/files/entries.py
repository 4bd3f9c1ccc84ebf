"""Read the values of files: numbers, bands, choices, axes, texts, lists, tables."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from vibro.axes import drive_axis_of, one_value_of, parse_axis
from vibro.drives import LEAST_SAMPLES, MOST_PIECES
from vibro.errors import MOST_LISTED, InputError, Problems, did_you_mean, shown
from vibro.quantities import MOST_HARMONICS, QUANTITIES, RATES, STANDS_FOR, SWEPT, exact_number
from vibro.reals import real_number
from vibro.units import ACCELERATION, ANGLE, FREQUENCY, LENGTH, PURE

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from vibro.axes import AxisSpec
    from vibro.quantities import Quantity
    from vibro.units import Kind

#: Stands for a table that a file does not have.
ABSENT: Final[Mapping[Any, Any]] = MappingProxyType({})
#: Both ends of a closed interval.
Span = tuple[float, float]

# Matches the beginning of a name in the friction catalogue, but not of a number.
_NAME: Final = re.compile(r"\s*(?!(nan|inf|infinity)\b)[^\W\d_]", re.IGNORECASE)
#: Words before a number: what it means for a value that is chosen.
AT_MOST, AT_LEAST, EXACTLY = WORDS = ("at most", "at least", "exactly")
_OTHER_WORD: Final = re.compile(rf"{_NAME.pattern}|\s*[<>=\u2264\u2265~]", re.IGNORECASE)
_WORDED: Final = re.compile(rf"\s*({'|'.join(WORDS)})\b(.*)".replace(" ", r"\s+"), re.IGNORECASE | re.DOTALL)


class Form(NamedTuple):
    """A form of values.

    Attributes
    ----------
    says : str
        Its name, for tables of keys.
    read : callable
        ``read(quantity, value)`` returns an axis, or lists as given, for scene files, SI units for designs.
        It raises ValueError for a value of another form, InputError for one that is not allowed.
    spellings : tuple of str
        How it may be written: ``number``; as a text a number with a unit (``text``), that after one of
        ``WORDS``, ``lo:hi`` (``ends``), ``a,b,c`` (``listed``), an ``axis``, the ``name`` of a row of the
        catalogue or any ``line``; a ``list`` of these, a list of a ``single`` one, or ``rows``.
    example : str
        How such a value is written, for hints.
    words : mapping of str
        Allowed words, if there are any, and what they mean.
    table : TableKind, optional
        Of a table within a table.
    rows : tuple of int
        Least and largest length of a list of numbers, or of rows of them.
    columns : tuple of Kind
        Units of the numbers in each row.
    alone : str
        What a number without such a word means; empty where no word may stand before it.
    """

    says: str
    read: Callable[[Quantity, Any], Any]
    spellings: tuple[str, ...] = ()
    example: str = "1.5"
    words: Mapping[str, Any] = ABSENT
    table: TableKind | None = None
    rows: tuple[int, int] = (0, 0)
    columns: tuple[Kind, ...] = ()
    alone: str = ""

    def plain(self, value: Any) -> Any:
        """Return a value of a file with what a number alone means written before it."""
        marks = ":," if "listed" in self.spellings else ":"
        is_several = isinstance(value, list | tuple) or any(mark in f"{value}" for mark in marks)
        return value if not self.alone or is_several or _worded(value)[0] else f"{self.alone} {value}"


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
    kinds, needed : tuple of str
        The kinds of machine that have it, and those that must; none if all have it.
    """

    form: Form
    quantity: Quantity
    usual: str = ""
    example: Any = None
    kinds: tuple[str, ...] = ()
    needed: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """Key in the file, with its unit."""
        return self.quantity.column

    @property
    def shown(self) -> str:
        """Line of the file with the example."""
        return f"{self.key} = {json.dumps(self.example)}"

    def read(self, value: Any) -> Any:
        """Read a value of the key; raise InputError, which names the key, if it is not allowed."""
        try:
            if self.form.words and isinstance(value, str) and not value.strip()[:1].isdigit():
                return self.form.words[value]
            return self.form.read(self.quantity, value)
        except InputError as exc:
            label = f"{self.quantity.label} = "
            problems = (f"{self.key} = {p[len(label) :]}" if p.startswith(label) else p for p in exc.problems)
            hint = exc.hint if self.key in exc.hint or not exc.hint else f"{self.key}: {exc.hint}"
            raise InputError(*problems, hint=hint) from None
        except (KeyError, ValueError):
            says = f"a {self.form.says}" if self.form.spellings else self.form.says
            hint = did_you_mean(value, self.form.words) or f"write {self.key} = {self.form.example}"
            rule = f"must be {says.replace('`', '')}"
            raise InputError(f"{self.key} = {shown(value)}: {rule}", hint=hint) from None


class TableKind(NamedTuple):
    """A table of a file.

    Attributes
    ----------
    heading : str
        Its heading in the file: ``[scene]``, or ``[[drive]]`` for a table that may be repeated.
    meaning : str
        Description for docs and the schema.
    entries : mapping of str to Entry
        Allowed entries, by key.
    required : bool
        Whether every file must have it.
    needs : tuple of tuple of str
        Groups of keys; the table must have exactly one key of each.
    """

    heading: str
    meaning: str
    entries: dict[str, Entry]
    required: bool = False
    needs: tuple[tuple[str, ...], ...] = ()

    @property
    def is_repeated(self) -> bool:
        """Whether there may be several tables of this kind."""
        return self.heading.startswith("[[")

    def example(self, *keys: str) -> str:
        """Return an example line for the first of some keys that has one."""
        return next(self.entries[key].shown for key in keys if self.entries[key].example is not None)


class Table:
    """One table of a file; every key is read or refused.

    Parameters
    ----------
    kind : TableKind
        Its description.
    given : object
        Content in the file; ``ABSENT`` without such a table.
    problems : Problems
        Collects the problems.
    heading : str, optional
        As messages call it, in place of its heading.
    others : iterable of TableKind
        The tables of the file, to which an unknown key may belong.

    Attributes
    ----------
    values : dict
        Valid values by the names of their quantities.
    """

    def __init__(
        self,
        kind: TableKind,
        given: Any,
        problems: Problems,
        heading: str = "",
        others: Iterable[TableKind] = (),
    ) -> None:
        self.heading = heading or kind.heading
        self._kind, self._problems = kind, problems
        self.values: dict[str, Any] = {}
        self.given: Mapping[Any, Any] = given if isinstance(given, Mapping) else {}
        if not isinstance(given, Mapping):
            name = self.heading.strip("[]0123456789 ")
            problems.add(f"{name} = {shown(given)}: must be a table, written {kind.heading}")
            return
        for key, value in given.items():
            if key in kind.entries:
                with problems.taken(f"{self.heading} "):
                    self.values[kind.entries[key].quantity.name] = kind.entries[key].read(value)
            else:
                refuse_unknown(f"{self.heading} unknown key", key, kind.entries, others, problems)
        for keys in kind.needs if kind.required or given is not ABSENT else ():
            self.needs(*keys)

    def refuse(self, key: str, why: str, hint: str = "") -> None:
        """Add a problem with an entry."""
        self._problems.add(f"{self.heading} {key} = {shown(self.given[key])}: {why}", hint)

    def needs(self, *keys: str) -> None:
        """Check that exactly one of some keys is given."""
        found = [key for key in keys if key in self.given]
        if not found:
            hint = f"{self.heading} for example: {self._kind.example(*keys)}"
            self._problems.add(f"{self.heading} {' or '.join(keys)} is missing", hint)
        elif len(found) > 1:
            both = f"{self.heading} gives both {' and '.join(found)}"
            self._problems.add(both, f"give {' or '.join(found)}")


def refuse_unknown(
    what: str,
    word: object,
    known: Iterable[str],
    tables: Iterable[TableKind],
    problems: Problems,
    hint: str = "",
) -> None:
    """Refuse a key or table, and suggest the table in which it belongs or a similar name."""
    homes = [kind.heading for kind in tables if word in kind.entries]
    if homes:
        meant = f"; it belongs in {' or '.join(homes)}"
    elif len(problems.found) >= MOST_LISTED:
        meant = ""  # the message leaves it out, and each lookup takes 0.1 ms
    else:
        known = [*known]
        meant = "; " + (_in_unit(word, known) or did_you_mean(word, known) or f"known are {', '.join(known)}")
    problems.add(f"{what} {shown(word)}{meant}", "" if len(homes) == 1 else hint)


def _in_unit(word: object, known: Sequence[str]) -> str:
    """Say how to give a quantity in the unit of an unknown key, such as ``amplitude_m``."""
    name, _, unit = word.rpartition("_") if isinstance(word, str) else ("", "", "")
    for rate in map(QUANTITIES.__getitem__, RATES):
        if word in (rate.column, f"amplitude{rate.kind.suffix}") and (own := "amplitude_mm") in known:
            return f'write {own} = "1.5{rate.unit}", with your number'
    quantity = QUANTITIES.get(name)
    if quantity is None or quantity.column not in known or unit.casefold() not in quantity.kind.ratios:
        return ""
    return f'write {quantity.column} = "1.5{unit}", with your number'


def _axis(quantity: Quantity, value: Any) -> AxisSpec:
    return drive_axis_of(value, quantity)


def _one(quantity: Quantity, value: Any) -> AxisSpec:
    """Read an axis of one value."""
    is_value = type(value) in (int, float, str, list)
    spec = drive_axis_of(value, quantity, one_value_of) if is_value else None
    if spec is None or spec.varies:
        is_swept = STANDS_FOR.get(quantity.name, quantity.name) in SWEPT
        axes = "; axes belong in the table [map]" if is_swept else ""
        raise _refusal(quantity, value, "must be one number", f"write {quantity.column} = 1.5{axes}")
    return spec


def ends_of(quantity: Quantity, value: Any) -> list[float]:
    """Read a number, or both ends of ``lo:hi``, in users' units."""
    items = value.split(":") if isinstance(value, str) else [value]
    if len(items) > 2 or (len(items) > 1 and not all(map(str.strip, items))):
        raise ValueError
    ends = [_double(quantity, item) for item in items]
    if ends[0] > ends[-1]:
        unit = f"; without a unit of its own an end is in {quantity.unit}" if quantity.unit else ""
        raise _refusal(quantity, value, "must be lo:hi with lo at most hi", f"give the lower end first{unit}")
    return ends


def _double(quantity: Quantity, value: Any) -> float:
    double = float(exact_number(value, quantity)) if isinstance(value, str) else real_number(value)
    if not math.isfinite(double):
        raise _refusal(quantity, value, "must be a finite number")
    return double


def _number(quantity: Quantity, value: Any) -> float:
    (number,) = _checked(quantity, value, ends_of(quantity, value))
    return number


def _band(quantity: Quantity, value: Any) -> Span:
    """Read a number, or ``lo:hi``, whose ends may be equal."""
    ends = _checked(quantity, value, ends_of(quantity, value))
    return ends[0], ends[-1]


def _friction(quantity: Quantity, value: Any) -> Span | str:
    """Read a band; return the name of a catalogue row unchanged."""
    return value if isinstance(value, str) and _NAME.match(value) else _band(quantity, value)


def _worded(value: Any) -> tuple[str, Any]:
    """Part a text into the word before its number, if there is one, and the rest."""
    found = _WORDED.fullmatch(value) if isinstance(value, str) else None
    if found:
        return " ".join(found[1].casefold().split()), found[2].strip()
    if isinstance(value, str) and _OTHER_WORD.match(value):
        raise ValueError
    return "", value


def _after_word(quantity: Quantity, value: str, number: str) -> float:
    """Read the number after a word; ``value`` is the whole text."""
    if ":" in number or not number:
        raise ValueError
    return _checked(quantity, value, [_double(quantity, number)])[0]


def _bound(of: str) -> Callable[[Quantity, Any], float]:
    """Return what reads a number, the least or the largest value, after its word or alone."""

    def read(quantity: Quantity, value: Any) -> float:
        word, number = _worded(value)
        if word not in ("", of):
            raise ValueError
        return _after_word(quantity, value, number) if word else _number(quantity, value)

    return read


def _limits(quantity: Quantity, value: Any) -> Span:
    """Read ``at most hi``, which a number alone means too, ``exactly x``, or ``lo:hi`` where lo may be 0."""
    word, number = _worded(value)
    if word == AT_MOST:
        return 0.0, _after_word(quantity, value, number)
    if only := _only(quantity, value):
        return only
    *low, high = ends_of(quantity, value)
    return _checked(quantity, value, low)[0] if any(low) else 0.0, _checked(quantity, value, [high])[0]


def _size(quantity: Quantity, value: Any) -> Span:
    """Read ``exactly x``, which a number alone means too, ``at most hi``, or ``lo:hi``."""
    return _limits(quantity, value) if _worded(value)[0] else _band(quantity, value)


def _span(quantity: Quantity, value: Any) -> Span:
    """Read ``exactly x``, which a number alone means too, or ``lo:hi``."""
    return _only(quantity, value) or _band(quantity, value)


def _only(quantity: Quantity, value: Any) -> Span | None:
    """Read ``exactly x``; return None of a value without a word, and refuse another word."""
    word, number = _worded(value)
    if word == AT_MOST:
        hint = f'write {quantity.column} = "lo:hi", from the least to the largest'
        raise _refusal(quantity, value, "a least value is needed too", hint)
    if word == AT_LEAST:
        raise ValueError
    return (_after_word(quantity, value, number),) * 2 if word else None


def _choices(quantity: Quantity, value: Any) -> tuple[Span, ...]:
    """Read ``exactly x``, which a number alone means too, an ascending list, or ``lo:hi``."""
    if only := _only(quantity, value):
        return (only,)
    if isinstance(value, str) and ":" in value:
        return (_band(quantity, value),)
    items = [*map(float, parse_axis(value, quantity).values)] if isinstance(value, str) else value
    items = items.tolist() if isinstance(items, np.ndarray) else items
    numbers = [_double(quantity, item) for item in (items if isinstance(items, list | tuple) else [items])]
    if not numbers:
        raise ValueError
    if any(after <= before for before, after in pairwise(numbers)):
        raise _refusal(quantity, value, "the values of a list must ascend and differ")
    return tuple((end, end) for end in _checked(quantity, value, numbers))


def _count(quantity: Quantity, value: Any) -> int:
    """Read a whole number, 1 or more."""
    number = _number(quantity, value)
    if number != int(number):
        raise ValueError
    return int(number)


def _text(quantity: Quantity, value: Any) -> str:
    """Read a text of one line that is not empty."""
    if not isinstance(value, str) or not value.strip() or not value.isprintable():
        raise ValueError
    return value.strip()


def _rows(says: str, most: int, example: str, *columns: Kind, least: int = 1) -> Form:
    """Make the form of a list of numbers, or of rows of a number in each of several units, all as given."""

    def read(quantity: Quantity, value: Any) -> list[Any]:
        of = [replace(quantity, kind=kind) for kind in columns] or [quantity]
        rows = value if isinstance(value, list) else []
        rows = rows if len(of) > 1 else [[item] for item in rows]
        if not least <= len(rows) <= most or not all(_is_row(row, len(of)) for row in rows):
            raise ValueError
        found = [
            [float(exact_number(x, q)) if isinstance(x, str) else x for q, x in zip(of, row, strict=True)]
            for row in rows
        ]
        return found if len(of) > 1 else [item for (item,) in found]

    return Form(says, read, ("rows",), example, rows=(least, most), columns=columns)


def _is_row(row: Any, size: int) -> bool:
    return isinstance(row, list) and len(row) == size and {int, float, str}.issuperset(map(type, row))


def one_of(words: Mapping[str, Any]) -> Form:
    """Make the form of an entry whose value is one of several words."""
    return Form(" or ".join(f"`{word}`" for word in words), _word, (), json.dumps(next(iter(words))), words)


def _word(quantity: Quantity, value: Any) -> Any:
    raise ValueError  # what is no word


def table_of(kind: TableKind) -> Form:
    """Make the form of a table within a table, or of a list of such tables."""

    def read(quantity: Quantity, value: Any) -> Any:
        problems = Problems()
        tables = value if kind.is_repeated and isinstance(value, list) and value else [value]
        found = tuple(Table(kind, table, problems, quantity.column).values for table in tables)
        problems.settle()
        return found if kind.is_repeated else found[0]

    return Form("table, or list of tables" if kind.is_repeated else "table", read, ("table",), table=kind)


def _checked(quantity: Quantity, value: Any, numbers: list[float]) -> list[float]:
    """Convert to SI units; raise InputError outside the quantity's range."""
    converted = [float(quantity.to_si(double)) for double in numbers]
    if not all(map(quantity.allows, converted)):
        raise _refusal(quantity, value, f"must be {quantity.allowed.text(quantity.unit)}")
    return converted


def _refusal(quantity: Quantity, value: Any, rule: str, hint: str = "") -> InputError:
    return InputError(f"{quantity.column} = {shown(value)}: {rule}", hint=hint)


_PAIRS: Final = "list of pairs of numbers"
_HARMONICS: Final = f"list of up to {MOST_HARMONICS} pairs of numbers"
_SAMPLES: Final = f"list of {LEAST_SAMPLES} to {MOST_PIECES} numbers"
_PERIOD: Final = "[0, 1.4, 2, 1.4, 0, -1.4, -2, -1.4]: one period, equally spaced"
_LOHI: Final = '0.5 or "0.3:0.7", which is all between two ends'
_NUMBER: Final = ("number", "text")
_ENDS: Final = (*_NUMBER, "ends")
_ONLY: Final = (*_ENDS, EXACTLY)
_RANGE: Final = '"exactly 0.5" or "0.3:0.7", which is all between two ends'
_FLOOR: Final = {"floor": math.inf}  # its mass
_MEASURED: Final = _rows(_PAIRS, MOST_PIECES, "[[45, 0.2], [50, 0.5]]", FREQUENCY, LENGTH)


def _points(quantity: Quantity, value: Any) -> Any:
    return (_text if isinstance(value, str) else _MEASURED.read)(quantity, value)


#: Forms by name, as keys.txt has them.
FORMS: Final = {
    "value": Form("number", _one, ("number", "text", "single")),
    "axis": Form("number, list or axis", _axis, ("number", "text", "listed", "axis", "list")),
    "list": _rows(f"list of up to {MOST_HARMONICS} numbers", MOST_HARMONICS, "[1, 0.2]"),
    "harmonics": _rows(_HARMONICS, MOST_HARMONICS, "[[20, 0], [5, -110]]", LENGTH, ANGLE),
    "steps": _rows(_PAIRS, MOST_PIECES, "[[0.8, 6.9], [0.2, -27.6]]", PURE, ACCELERATION),
    "accelerations": _rows(_SAMPLES, MOST_PIECES, _PERIOD, ACCELERATION, least=LEAST_SAMPLES),
    "displacements": _rows(_SAMPLES, MOST_PIECES, _PERIOD, LENGTH, least=LEAST_SAMPLES),
    "number": Form("number", _number, _NUMBER),
    "most": Form("number (at most)", _bound(AT_MOST), (*_NUMBER, AT_MOST), '"at most 1.5"', alone=AT_MOST),
    "least": Form(
        "number (at least)", _bound(AT_LEAST), (*_NUMBER, AT_LEAST), '"at least 1.5"', alone=AT_LEAST
    ),
    "band": Form("number or band", _band, _ENDS, _LOHI),
    "friction": Form("number, band or row of the catalogue", _friction, (*_ENDS, "name"), _LOHI),
    "limits": Form(
        'number (at most), `"exactly 1"`, or range',
        _limits,
        (*_ONLY, AT_MOST),
        f'"at most 0.5", {_RANGE}',
        alone=AT_MOST,
    ),
    "size": Form(
        'number (exactly), `"at most 1"`, or range',
        _size,
        (*_ONLY, AT_MOST),
        f'"at most 0.5", {_RANGE}',
        alone=EXACTLY,
    ),
    "span": Form("number (exactly) or range", _span, _ONLY, _RANGE, alone=EXACTLY),
    "choices": Form(
        "number (exactly), list or range",
        _choices,
        (*_ONLY, "listed", "list"),
        f"[0.3, 0.7], {_RANGE}",
        alone=EXACTLY,
    ),
    "text": Form("text on one line", _text, ("line",), '"feeder"'),
    "mass or floor": Form("number or `floor`", _number, _NUMBER, '12 or "floor"', _FLOOR),
    "count": Form("whole number", _count, _NUMBER, "2"),
    "points": _MEASURED._replace(
        says=f"name of a file, or {_PAIRS}", read=_points, spellings=("line", "rows")
    ),
}
