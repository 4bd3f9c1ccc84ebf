"""Build the JSON Schema of scene files and design questions from their description.

Every file that the readers accept is valid. Readers refuse some valid files: the schema checks the form and
unit of a text, but neither the size of its numbers nor one key against another.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from vibro.files.entries import WORDS
from vibro.quantities import QUANTITIES, RATES, STANDS_FOR

if TYPE_CHECKING:
    from vibro.files.descriptions import FileKind
    from vibro.files.entries import Entry, TableKind
    from vibro.quantities import Quantity
    from vibro.units import Kind

#: Version of the schemas; it rises when files that were valid become invalid.
VERSION: Final = 1

_DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"
_DIGITS: Final = r"[+\u2212-]?(?:[0-9]+(?:\.[0-9]*|,[0-9]+)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"

Schema = dict[str, Any]


def schema_of(file: FileKind) -> Schema:
    """Return the schema of a kind of file, for JSON Schema draft 2020-12."""
    tables = file.tables.items()
    return {
        "$schema": _DIALECT,
        "$id": f"urn:vibro:schema:{file.name}:{VERSION}",
        "title": f"vibro {file.name} file",
        "description": f"{_sentence(file.meaning)}, read by vibro.",
        "type": "object",
        "properties": {name: _any(_tables(table, {"$ref": f"#/$defs/{name}"})) for name, table in tables},
        "required": [name for name, table in tables if table.required],
        "additionalProperties": False,
        "$defs": {name: _table(table) for name, table in tables},
    }


def _any(ways: list[Schema]) -> Schema:
    return ways[0] if len(ways) == 1 else {"anyOf": ways}


def _tables(table: TableKind, one: Schema) -> list[Schema]:
    """Return the schemas of a table, which may be a list of tables if it is repeated."""
    return [{"type": "array", "items": one, "minItems": 1}, one] if table.is_repeated else [one]


def _table(table: TableKind) -> Schema:
    choices = [{"oneOf": [{"required": [key]} for key in keys]} for keys in table.needs if len(keys) > 1]
    return {
        "description": f"{_sentence(table.meaning)}.",
        "type": "object",
        "properties": {key: _entry(entry) for key, entry in table.entries.items()},
        "required": [keys[0] for keys in table.needs if len(keys) == 1],
        "additionalProperties": False,
    } | ({"allOf": choices} if choices else {})


def _entry(entry: Entry) -> Schema:
    form, quantity = entry.form, entry.quantity
    unit = f" [{quantity.unit}]" if quantity.unit else ""
    usual = entry.usual if entry.usual.startswith("needed") else f"{entry.usual} where it is left out"
    parts = [f"{quantity.meaning}{unit}: {form.says}", *([usual] if entry.usual else [])]
    schema: Schema = {"description": f"{_sentence('; '.join(parts))}.".replace("`", "")}
    schema |= _any(_ways(entry))
    return schema if entry.example is None else {**schema, "examples": [entry.example]}


def _ways(entry: Entry) -> list[Schema]:
    """Return the schemas of an entry's values, one for each TOML type."""
    form, quantity = entry.form, entry.quantity
    if form.table:
        return _tables(form.table, _table(form.table))
    kinds = [quantity.kind]
    if {"single", "axis"} & {*form.spellings} and STANDS_FOR.get(quantity.name, quantity.name) == "amplitude":
        kinds += [QUANTITIES[name].kind for name in RATES]
    text = _number_text(*kinds)
    texts = {
        "text": text,
        **{word: rf"{_folded(word)}\s*{text}" for word in WORDS},
        "ends": rf"{text}\s*:\s*{text}",
        "listed": rf"{text}(?:\s*,\s*{text})+",
        "axis": rf"{text}\s*:\s*{text}(?:\s*:\s*(?:{_DIGITS}|{_folded('step=')}\s*{text}))?"
        rf"(?:\s*:\s*{_folded('log')})?",
        "name": r"[^\W\d_][\s\S]*",
        "line": r"\S[\s\S]*",
    }
    items = {"anyOf": [_bounded(quantity.swept), _matching([text])]}
    several = {"type": "array", "items": items, "minItems": 1}
    ways = {
        "number": _bounded(quantity), "list": several, "single": {**several, "maxItems": 1},
        "rows": _rows(entry),
    }  # fmt: skip
    found = [ways[spelling] for spelling in form.spellings if spelling in ways]
    if spelled := [texts[spelling] for spelling in form.spellings if spelling in texts]:
        found.append(_matching(spelled))
    return [*found, *([{"enum": [*form.words]}] if form.words else [])]


def _rows(entry: Entry) -> Schema:
    """Return the schema of a list of numbers, or of rows of them, with or without units."""
    (least, most), kinds = entry.form.rows, entry.form.columns or (entry.quantity.kind,)
    columns = [
        {"anyOf": [_bounded(quantity), _matching([_number_text(quantity.kind)])]}
        for quantity in (replace(entry.quantity, kind=kind) for kind in kinds)
    ]
    row = {"type": "array", "prefixItems": columns, "items": False, "minItems": len(columns)}
    items = row if len(columns) > 1 else columns[0]
    return {"type": "array", "items": items, "minItems": least, "maxItems": most}


def _matching(texts: list[str]) -> Schema:
    return {"type": "string", "pattern": rf"^\s*(?:{'|'.join(texts)})\s*$"}


def _bounded(quantity: Quantity) -> Schema:
    """Return the schema of a number within the quantity's range, in users' units."""
    allowed = quantity.allowed
    schema: Schema = {"type": "number"}
    if math.isfinite(allowed.low):
        schema["minimum" if allowed.with_low else "exclusiveMinimum"] = allowed.low
    if math.isfinite(allowed.high):
        schema["maximum" if allowed.with_high else "exclusiveMaximum"] = allowed.high
    return schema


def _number_text(*kinds: Kind) -> str:
    """Return the pattern of a number that may carry a unit."""
    units = "|".join(_folded(unit) for kind in kinds for unit in kind.units)
    return rf"{_DIGITS}(?:\s*(?:{units}))?" if units else _DIGITS


def _folded(word: str) -> str:
    """Return the pattern of a word in letters of any case."""
    cases = (sorted({c, c.lower(), c.upper(), c.casefold()}) for c in word)
    return "".join(f"[{''.join(same)}]" if len(same) > 1 else re.escape(same[0]) for same in cases)


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]
