"""Describe the tables and keys of scene files and design questions, which keys.txt lists.

The readers, the tables of keys in docs/ and the JSON Schema are derived from this description.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from vibro import quantities, units
from vibro.core.codes import Regime
from vibro.files import entries as form
from vibro.files.entries import Entry, Form, Table, TableKind
from vibro.quantities import BY_COLUMN, MACHINE, POSITIVE, QUANTITIES, SWEPT, ZERO_OR_MORE, Quantity, Range

if TYPE_CHECKING:
    from vibro.errors import Problems


class FileKind(NamedTuple):
    """A kind of file: its name, its description, the function that reads it, and its tables by name."""

    name: str
    meaning: str
    function: str
    tables: dict[str, TableKind]

    def table(self, name: str, given: Any, problems: Problems, place: int = 0) -> Table:
        """Read a table; ``place`` is its number, if it is repeated."""
        kind = self.tables[name]
        return Table(kind, given, problems, f"{kind.heading} {place or ''}".rstrip(), self.tables.values())


#: Example values by quantity: the nut of examples/safety_nut.toml, and other drives of about its load.
EXAMPLES: Final = {
    "amplitude": 1, "along_amplitude": 1, "normal_amplitude": 0.3, "frequency": 15, "drive_angle": 20,
    "normal_phase": -60, "along_amplitude_2": 0.2, "along_phase_2": 90, "normal_amplitude_2": 0.1,
    "static_friction": 0.74, "friction_ratio": 0.77, "kinetic_friction": 0.57, "trough_length": 600,
}  # fmt: skip

#: Kinds of machines, as files spell them.
KINDS: Final = ("unbalance", "magnet", "exciter", "crank", "rod", "measured")

_WORDS: Final[dict[str, dict[str, Any]]] = {
    "kind": {kind: kind for kind in KINDS},
    "law": {law: law for law in ("constant", "square")},
    "amplitude or stroke": {"amplitude": 1.0, "stroke": 0.5},
    "regime": {regime.label: regime for regime in (Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING)},
}
_FORMS: Final = form.FORMS | {name: form.one_of(words) for name, words in _WORDS.items()}
_RANGES: Final = {
    "finite": Range(), "> 0": POSITIVE, ">= 0": ZERO_OR_MORE, ">= 1": replace(POSITIVE, low=1.0)
}  # fmt: skip
_BY_KEY: Final = {q.column: q for q in QUANTITIES.values() if q.name not in quantities.RATES}
_SUFFIXES: Final = {kind.suffix: kind for kind in vars(units).values() if isinstance(kind, units.Kind)}


def _value(quantity: Quantity) -> Entry:
    quantity = quantities.of_part(quantity, is_clamped=True)  # other keys decide whether a part is clamped
    usual = "" if quantity.default is None else f"{quantity.default:g}"
    return Entry(_FORMS["value"], quantity, usual, EXAMPLES.get(quantity.name))


def _axis(quantity: Quantity) -> Entry:
    is_swept = quantities.STANDS_FOR.get(quantity.name, quantity.name) in SWEPT
    return _value(quantity)._replace(form=_FORMS["axis" if is_swept else "value"], usual="", example=None)


def _entry(of: Form, key: str, meaning: str, usual: str, example: str, allowed: str, kinds: str) -> Entry:
    """Make a key of its row."""
    quantity = _BY_KEY.get(key)
    if quantity is None:
        suffix = "" if of.columns else max(filter(key.endswith, _SUFFIXES), key=len)
        quantity = Quantity(key.removesuffix(suffix), _SUFFIXES[suffix], allowed=POSITIVE)
    span = _range(allowed) if allowed else quantity.allowed
    quantity = replace(quantity, meaning=meaning or quantity.meaning, allowed=span)
    needed = tuple(kind[:-1] for kind in kinds.split() if kind.endswith("!"))
    both = " and ".join(filter(None, [", ".join(needed[:-1]), *needed[-1:]]))
    usual = "; ".join(filter(None, [f"needed of {both}" if needed else "", usual]))
    shown = json.loads(example) if example else None
    return Entry(of, quantity, usual, shown, tuple(kinds.replace("!", "").split()), needed)


def _range(text: str) -> Range:
    if text in _RANGES:
        return _RANGES[text]
    low, high = map(float, text[1:-1].split(","))
    return Range(low, high, text.startswith("["), text.endswith("]"))


def _tables() -> dict[str, TableKind]:
    """Read keys.txt: each table by its file and name."""
    values = {key: _value(quantity) for key, quantity in BY_COLUMN.items() if quantity.name not in MACHINE}
    groups = {"values": values, "axes": {key: _axis(quantity) for key, quantity in BY_COLUMN.items()}}
    tables: dict[str, TableKind] = {}
    for line in Path(__file__).with_name("keys.txt").read_text(encoding="utf-8").splitlines():
        mark, _, name = line.partition(" ")
        first, *cells = [cell.strip() for cell in f"{line}||||||".split("|")][:7]
        if mark == "##":
            heading, meaning, required, needs, *_ = cells
            ways = tuple(tuple(keys.split(" or ")) for keys in needs.split(", ") if keys)
            entries: dict[str, Entry] = {}
            name = first.removeprefix("## ")
            groups[name], tables[name] = entries, TableKind(heading, meaning, entries, bool(required), ways)
        elif mark == "+":
            entries |= groups[name]
        elif first and mark != "#":
            of, *more = cells
            entries[first] = _entry(form.table_of(tables[of]) if of in tables else _FORMS[of], first, *more)
    return tables


_TABLES: Final = _tables()


def _file(name: str, meaning: str, function: str) -> FileKind:
    own = {key.removeprefix(f"{name}."): kind for key, kind in _TABLES.items() if key.startswith(f"{name}.")}
    return FileKind(name, meaning, function, own)


#: Input of the commands that take a scene.
SCENE_FILE: Final = _file("scene", "a scene of vibro: a drive, a trough and a part", "read_scene")
#: Input of ``vibro design``; static friction must be positive, since without it no body rests.
DESIGN_FILE: Final = _file("design", "a design question: parts, drives and a goal", "design")
#: All kinds of file, by name.
FILES: Final = {kind.name: kind for kind in (SCENE_FILE, DESIGN_FILE)}
#: Keys of a machine, in ``[machine]`` of a scene file and in ``[[drive]]`` of a design question.
MACHINE_KEYS: Final = SCENE_FILE.tables["machine"].entries
