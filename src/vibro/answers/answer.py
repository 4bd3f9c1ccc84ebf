"""An answer: named numbers, tables and notes, written as text, JSON, CSV or a page by one renderer each."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

from vibro.core.codes import PHASE_NAMES
from vibro.errors import printable
from vibro.quantities import DEFAULTS, LISTED_HARMONICS, MACHINE, QUANTITIES
from vibro.reals import rounded

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Value: TypeAlias = "float | str | None"

NO_BOUNCE: Final = "restitution 0: parts land without a bounce"
UNKNOWN: Final = "unknown"
METRES_PER_MINUTE: Final = 0.06  # of 1 mm/s
_DIGITS: Final = 4  # for people; JSON has all
_BRIEF: Final = 3
_WIDTH: Final = 80  # characters of a terminal
_EXACT: Final = 1e-9, 1e-12  # of a value, and of its unit: nobody measures with less error


class Fact(NamedTuple):
    """A named value.

    Attributes
    ----------
    label : str
        What it is, for people.
    value : float, str or None
        None, or NaN, where it is unknown.
    unit : str
        Unit of a number.
    error : float
        Standard error, 0 where there is none.
    note : str
        What stands in brackets behind it.
    is_rare : bool
        Whether it is printed on request only.
    is_line : bool
        Whether it is a sentence, printed on a line of its own before the others.
    """

    label: str
    value: Value
    unit: str = ""
    error: float = 0.0
    note: str = ""
    is_rare: bool = False
    is_line: bool = False

    @property
    def text(self) -> str:
        """The value with its unit, error and note."""
        note = f" ({self.note})" if self.note else ""
        if self.value is None or (isinstance(self.value, float) and math.isnan(self.value)):
            return f"{UNKNOWN}{note}"
        number = uncertain(self.value, self.error) if isinstance(self.value, float) else str(self.value)
        return f"{number} {self.unit}".rstrip() + note


class Table(NamedTuple):
    """Rows of numbers and texts.

    Attributes
    ----------
    name : str
        Its key in JSON.
    columns : sequence of tuple of str
        Label and unit of each; from both follows its key.
    rows : sequence of sequence
        Numbers, texts, None; the first of a row names it.
    title : str
        What stands above it, if anything.
    is_rare : bool
        Whether it is printed on request only.
    is_brief : bool
        Whether it goes on where the facts end: its numbers have three digits, and their units behind them.
    """

    name: str
    columns: Sequence[tuple[str, str]]
    rows: Sequence[Sequence[Value]]
    title: str = ""
    is_rare: bool = False
    is_brief: bool = False

    @property
    def texts(self) -> list[list[str]]:
        """Its rows for people, the heads first, without columns that are empty."""
        heads = [f"{label} [{unit}]" if unit and not self.is_brief else label for label, unit in self.columns]
        return [[row[i] for i in self._filled] for row in (heads, *self._cells)]

    @property
    def _cells(self) -> list[list[str]]:
        if not self.is_brief:
            return [[shown(cell) for cell in row] for row in self.rows]
        return [[brief(x, unit) for x, (_, unit) in zip(row, self.columns, strict=True)] for row in self.rows]

    @property
    def _filled(self) -> list[int]:
        """The places of columns that are not empty."""
        return [i for i, cells in enumerate(zip(*self._cells, strict=True)) if any(cells)]

    @property
    def text(self) -> str:
        """Its lines, with the units of a wide table below the labels."""
        head, *rows = self.texts
        lines = aligned([head, *rows])
        if max(map(len, lines.splitlines())) > _WIDTH:
            labels, units = zip(*(self.columns[i] for i in self._filled), strict=True)
            lines = aligned([labels, [f"[{unit}]" if unit else "" for unit in units], *rows])
        return f"{self.title}\n{lines}" if self.title else lines

    @property
    def keys(self) -> list[str]:
        """Names of the columns, with their units."""
        return [_key(label, unit) for label, unit in self.columns]


@dataclass(frozen=True)
class Answer:
    """What is known, made once, and how to write it.

    Attributes
    ----------
    facts, tables : sequence of Fact, Table
        What people read; those that are rare on request only.
    notes : sequence of str
        One sentence each: what a status means, what is proved, what is in doubt.
    record : mapping
        What JSON says, by keys with units; a table that is not in it is added under its name.
    title : str
        Of its page.
    paste : str
        Lines of a file, to be copied.
    """

    facts: Sequence[Fact]
    tables: Sequence[Table] = ()
    notes: Sequence[str] = ()
    record: Mapping[str, Any] = field(default_factory=dict)
    title: str = ""
    paste: str = ""

    def text(self, *, every: bool = False) -> str:
        """Write it for a terminal: the usual part, or every fact and table."""
        there = [fact for fact in self.facts if every or not fact.is_rare]
        lines = [printable(f"{fact.label}: {fact.text}") for fact in there if fact.is_line]
        facts = [[fact.label, fact.text] for fact in there if not fact.is_line]
        tables = [table for table in self.tables if every or not table.is_rare]
        parts = [aligned(facts, right=False)] if facts else []
        if facts and tables and tables[0].is_brief:
            label = max(len(fact[0]) for fact in facts)
            (head, *heads), *rows = tables.pop(0).texts
            parts[0] += "\n" + aligned([[head.ljust(label), *heads], *rows])
        parts += [table.text for table in tables]
        parts += ["\n".join(map(printable, self.notes))] if self.notes else []
        whole = "\n\n".join([*parts, *([self.paste] if self.paste else [])])
        return "\n".join([*lines, whole])

    def content(self) -> dict[str, Any]:
        """Return what JSON says."""
        tables = {
            table.name: [dict(zip(table.keys, map(_known, row), strict=True)) for row in table.rows]
            for table in self.tables
            if table.name not in self.record
        }
        return {**_known(self.record), **tables, **({"notes": list(self.notes)} if self.notes else {})}

    def json(self) -> str:
        """Write all of it as JSON; unknown numbers are null."""
        return json.dumps(self.content(), indent=2, allow_nan=False)

    def csv(self, name: str) -> str:
        """Write a table as CSV, its numbers with all digits."""
        table = next(table for table in self.tables if table.name == name)
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([table.keys, *map(_known, table.rows)])
        return text.getvalue()

    def html(self, pictures: Mapping[str, Figure] | None = None, command: str = "") -> str:
        """Write all of it as a page to print, which needs no other file.

        Parameters
        ----------
        pictures : mapping of str to Figure
            By what each shows.
        command : str
            That makes the same page.
        """
        from vibro.answers.page import page_html

        return page_html(self, pictures or {}, command)


def aligned(rows: Sequence[Sequence[str]], *, right: bool = True) -> str:
    """Return rows as lines with their cells below each other, all but the first to the right if wanted."""
    safe = [[*map(printable, row)] for row in rows]
    widths = [max(map(len, column)) for column in zip(*safe, strict=True)]
    lines = []
    for first, *rest in safe:
        cells = [cell.rjust(w) if right else cell.ljust(w) for cell, w in zip(rest, widths[1:], strict=True)]
        lines.append("  ".join([first.ljust(widths[0]), *cells]).rstrip())
    return "\n".join(lines)


def shown(value: Value, digits: int = _DIGITS) -> str:
    """Write a value for people: a number to some digits, nothing for None."""
    if isinstance(value, float):
        return "-" if math.isnan(value) else f"{value:z.{digits}g}"
    return "" if value is None else str(value)


def uncertain(value: float, error: float, digits: int = _DIGITS) -> str:
    """Write a value with its standard error, to two digits of that; one without, or exact, to some digits."""
    if not max(_EXACT[0] * abs(value), _EXACT[1]) < error < math.inf:
        return shown(value, digits)
    decimals = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:z.{decimals}f} ± {error:.{decimals}f}"


def brief(value: Value, unit: str = "") -> str:
    """Write a number to three digits, zeros at its end among them, with its unit: ``27.0 Hz``."""
    if not isinstance(value, float) or not 1e-4 <= abs(value) < 1e6:
        return f"{shown(value, _BRIEF)} {unit}".rstrip() if value is not None else ""
    return f"{value:.{max(0, _BRIEF - 1 - math.floor(math.log10(abs(value))))}f} {unit}".rstrip()


def number(value: float, unit: str = "") -> str:
    """Write a number for people, with six digits."""
    return f"{shown(float(value), 6)} {unit}".rstrip()


def bound(value: float, unit: str = "", *, upper: bool, digits: int = 6) -> str:
    """Write a bound for people, rounded so that it still holds."""
    return f"{shown(rounded(value, digits, down=not upper), digits)} {unit}".rstrip()


def given_text(given: Mapping[str, float]) -> str:
    """Name the quantities of a scene, but for those that are as usual."""
    return ", ".join(
        f"{QUANTITIES[name].label} {QUANTITIES[name].text(value)}"
        for name, value in given.items()
        if value != DEFAULTS.get(name) and is_listed(name)
    )


def letters(pattern: str) -> str:
    """Say what the letters of a pattern stand for, each once: ``F forward slide, _ rest``."""
    return ", ".join(f"{kind} {PHASE_NAMES[kind]}" for kind in dict.fromkeys(pattern) if kind in PHASE_NAMES)


def is_listed(name: str) -> bool:
    """Whether a quantity of a scene is named one by one, not as one of many harmonics, or with a machine."""
    return QUANTITIES[name].order <= LISTED_HARMONICS and name not in MACHINE


def _known(value: Any) -> Any:
    """Return a value, or what is in it, with None for numbers that are not finite."""
    if isinstance(value, Mapping):
        return {key: _known(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [*map(_known, value)]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def label_of(key: str, unit: str) -> str:
    """Return the name of a column without its unit: that of ``energy_per_cycle_j`` is energy per cycle."""
    return key.removesuffix(f"_{_key('', unit)}").replace("_", " ")


def _key(label: str, unit: str) -> str:
    words = [*label.split(), *unit.replace("/", " ").replace("%", "percent").split()]
    return "_".join(words).lower()
