"""Find the columns of a table that hold the signals, by their units or by the names that a user gives."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, NamedTuple

from vibro.errors import InputError, argument, did_you_mean, shown
from vibro.records.signals import (
    DERIVATIVES,
    EXAMPLES,
    KINDS,
    SIGNAL_UNITS,
    SIGNALS,
    TROUGH,
    Sensitivity,
    Unit,
    kinds_of,
    signal_unit,
)
from vibro.records.tolerances import TOL

# Words in a header that decide between columns whose units are of the same kind.
_WORDS: Final = {
    role: re.compile(rf"(?:{words})(?:[\W_\d].*)?", re.IGNORECASE)
    for role, words in (
        ("time", r"time|zeit|t"),
        ("displacement", r"displacement|position|weg|relative.*|x|xi|s"),
        ("velocity", r"velocity|speed|geschwindigkeit|relative.*|v|vx"),
        ("acceleration", r"acceleration|beschleunigung|relative.*|a|ax"),
        ("friction", r"friction|friction force|reibkraft|f"),
    )
}
_BRACKETS: Final = re.compile(r"(.*?)\s*[\[(](?:in\s+)?([^\])]*)[\])]\s*")
_IN: Final = re.compile(r"(.*\S)\s+(?:in|/)\s+(\S.*)", re.IGNORECASE)  # Zeit in s, or Zeit / s
_OVER: Final = re.compile(r"([^/]*[^/\s])\s*/\s*(\S.*)")  # Zeit/s, v/mm/s


class Header(NamedTuple):
    """Header of a column: its place and text, the name and the unit in that, and the unit's kind and size."""

    place: int
    text: str
    name: str
    stated: str
    unit: Unit | None


class Wanted(NamedTuple):
    """Columns that a user names: headers by the keys of ``KINDS``, and the sensitivities of voltages.

    Signals of the body are needed unless ``body`` is false: then motions of the trough are.
    """

    headers: Mapping[str, str]
    sensitivities: Sequence[Sensitivity] = ()
    body: bool = True


class Column(NamedTuple):
    """Column of a signal: its header, kind and size of its unit in SI units, sensitivity of a voltage."""

    header: Header
    kind: str
    size: float
    sensitivity: Sensitivity | None = None


#: Columns by the keys of ``KINDS``.
Columns = dict[str, Column]


def _headers(above: list[list[str]]) -> list[Header]:
    """Read the header row, the last one of ``above``, and a row of units under it if there is one."""
    texts = above[-1]
    units = [text.strip("[]()") for text in texts]
    if len(above) > 1 and len(above[-2]) == len(units) and all(signal_unit(unit) for unit in units if unit):
        texts = [f"{name} [{unit}]" if unit else name for name, unit in zip(above[-2], units, strict=True)]
    headers = []
    for place, text in enumerate(texts):
        name, unit = _split(text)
        headers.append(Header(place, text, name, unit, signal_unit(unit) if unit else _unit_at_end(name)))
    return headers


def _split(text: str) -> tuple[str, str]:
    """Split ``X [mm]``, ``X in mm`` or ``X/mm`` into name and unit."""
    if match := _BRACKETS.fullmatch(text):
        name = match[1].removesuffix("/")
        if name == match[1]:
            return name, match[2].strip()
        parts = name.rstrip(), match[2].strip()
        return parts if signal_unit(parts[1]) is None or _is_quotient(*parts) else (text, "")
    if signal_unit(text):  # m / s is a unit
        return text, ""
    if (match := _IN.fullmatch(text)) and signal_unit(match[2].strip()):
        return match[1], match[2].strip()
    match = _OVER.fullmatch(text)
    return (match[1], match[2].strip()) if match and _is_quotient(match[1], match[2].strip()) else (text, "")


def _is_quotient(name: str, unit_text: str) -> bool:
    """Whether a text is the name of a signal over its unit, as ``s/mm``, unlike ``N/mm`` and ``Weg/s``."""
    unit = signal_unit(unit_text)
    if unit is None:
        return False
    kinds = [KINDS[role] for role, word in _WORDS.items() if word.fullmatch(name)]
    return unit[0] in (*kinds, "voltage") if kinds else signal_unit(name) is None


def _unit_at_end(name: str) -> Unit | None:
    """Return the unit at the end of a name in vibro's own tables, such as ``velocity_mm_s``."""
    words = name.split("_")
    for count in (2, 1):
        if len(words) > count and (unit := signal_unit("_".join(words[-count:]))):
            return unit
    return None


def columns_of(path: Path, above: list[list[str]], wanted: Wanted) -> Columns:
    """Find the columns of the signals.

    Parameters
    ----------
    path : Path
        Name of the file, for messages.
    above : list of list of str
        Rows above the first one of data; the last one is the header row, or a row of units under it.
    wanted : Wanted
        Columns that a user names. If no signal of the body is among them, every other column whose unit is
        unambiguous is taken too. Voltages and motions of the trough must be named, and so must a signal of
        the body that has the kind of one of the trough: it may as well be another one of the trough.

    Raises
    ------
    InputError
        If a column is missing, ambiguous, without a unit, or named twice; if a voltage lacks a sensitivity,
        or a sensitivity a voltage.
    """
    headers = _headers(above)
    problems, hints, found = list[str](), list[str](), Columns()
    # A user who names one signal wants no others; the time is always needed.
    named_one = any(role in wanted.headers for role in SIGNALS)
    sought = ("time",) if named_one or not wanted.body else ("time", *SIGNALS)
    named = [role for role in KINDS if role in wanted.headers]
    for role in dict.fromkeys([*named, *sought]):
        try:
            if role in wanted.headers:
                found[role] = _named(path, headers, role, wanted)
            else:
                taken = {column.header.place for column in found.values()}
                if KINDS[role] not in {found[name].kind for name in TROUGH if name in found}:
                    found |= _detected(path, [h for h in headers if h.place not in taken], role)
        except InputError as exc:
            if role in SIGNALS and role not in wanted.headers and not found.keys().isdisjoint(TROUGH):
                continue  # the trough alone is measured too
            problems += exc.raw[0]
            hints += [exc.raw[1]]
    if not problems and "time" not in found:
        problems.append(f"{path}: no column of time found among {_list(headers)}")
        hints.append(f"name it, with its unit: {argument('time', 't [s]')}")
    if not problems and found.keys().isdisjoint((*SIGNALS, *TROUGH) if wanted.body else TROUGH):
        what = "signal found" if wanted.body else "motion of the trough named"
        problems.append(f"{path}: no {what} among {_list(headers)}")
        hints.append(_name_one(headers, wanted))
    if problems:
        raise InputError(*problems, hint="\n".join(dict.fromkeys(filter(None, hints))))
    _check_use(path, headers, found, wanted)
    return {role: found[role] for role in KINDS if role in found}


def _check_use(path: Path, headers: list[Header], columns: Columns, wanted: Wanted) -> None:
    """Refuse a column that is given as two signals, and a sensitivity that no voltage uses."""
    for column in columns.values():
        same = [role for role, other in columns.items() if other.header == column.header]
        if len(same) > 1:
            names = " and as ".join(role.replace("_", " ") for role in same)
            raise InputError(f"{path}: column {shown(column.header.text)} is given as {names}")
    used = [column.sensitivity for column in columns.values()]
    for sensitivity in wanted.sensitivities:
        if sensitivity not in used:
            role = sensitivity.role or next(name for name in SIGNALS if KINDS[name] == sensitivity.kind)
            read = [column.header for column in columns.values()]
            free = [header.text for header in _voltages(headers) if header not in read]
            hint = f"name the column: {argument(role, free[0])}" if free else "leave it out"
            said = f"{path}: no column that is read as {role.replace('_', ' ')}"
            raise InputError(
                f"{said} is a voltage for {argument('sensitivity', sensitivity.text)}", hint=hint
            )


def _voltages(headers: list[Header]) -> list[Header]:
    return [header for header in headers if header.unit and header.unit[0] == "voltage"]


def _name_one(headers: list[Header], wanted: Wanted) -> str:
    """Show how to name a signal, with a sensitivity if the table holds a voltage."""
    if not wanted.body:
        sensitivities = {"voltage": f" {argument('sensitivity', EXAMPLES['acceleration'])}"}
        of_kind = {header.unit[0]: header for header in reversed(headers) if header.unit}
        for kind in ("voltage", *DERIVATIVES):
            if kind in of_kind:
                example = f"{argument('trough_along', of_kind[kind].text)}{sensitivities.get(kind, '')}"
                return f"name one or both, along and normal to the trough: {example}"
        both = argument("trough_along", "ax [m/s^2]"), argument("trough_normal", "ay [m/s^2]")
        return f"name one or both, with the unit: {both[0]} {both[1]}"
    for header in _voltages(headers):
        role = next((role for role in SIGNALS if _WORDS[role].fullmatch(header.name)), "acceleration")
        name = argument(role, header.text)
        if any(sensitivity.serves(role) for sensitivity in wanted.sensitivities):
            return f"name the voltage: {name}"
        example = EXAMPLES[KINDS[role]]
        return f"name one, and the sensitivity of its sensor: {name} {argument('sensitivity', example)}"
    return f"name one, with its unit: {argument('displacement', 'X [mm]')}"


def _named(path: Path, headers: list[Header], role: str, wanted: Wanted) -> Column:
    """Find the column that a user names; its unit is the one in its header, or else in the user's name."""
    key = wanted.headers[role].strip()
    name, unit_text = _split(key)
    found = (
        [h for h in headers if h.text == key]
        or [h for h in headers if h.text.casefold() == key.casefold()]
        or [h for h in headers if h.name.casefold() == name.casefold() and not (unit_text and h.stated)]
    )
    kind = KINDS[role]
    if not found:
        hint = did_you_mean(key, (h.text for h in headers)) or "write it as the header row does"
        missing = f"{path}: no column {shown(key)} for {role}; its columns are {_list(headers)}"
        raise InputError(missing, hint=hint)
    if len(found) > 1:
        several = f"{path}: {len(found)} columns are called {shown(key)}"
        raise InputError(several, hint="give them different names in the file")
    (header,) = found
    unit = signal_unit(unit_text) if unit_text and not header.stated else header.unit
    if unit is not None and unit[0] in kinds_of(role):
        return Column(header, *unit)
    said, example = f"{path}: column {shown(header.text)} for {role}", EXAMPLES.get(kind)
    if unit is not None and unit[0] == "voltage" and example:
        serving = [sensitivity for sensitivity in wanted.sensitivities if sensitivity.serves(role)]
        if serving:
            # A sensitivity of this column has priority over one of its kind.
            sensitivity = max(serving, key=lambda sensitivity: bool(sensitivity.role))
            return Column(header, sensitivity.kind, unit[1] * sensitivity.per_volt, sensitivity)
        what, hint = "the sensitivity of its sensor is missing", "give the sensor's sensitivity:"
        idle = (s for s in wanted.sensitivities if not any(map(s.serves, wanted.headers)))
        if (other := next(idle, None)) is not None:
            given = argument("sensitivity", other.text)
            what = f"{given} is a sensitivity of {other.kind}, one of {kind} is needed"
            if other.kind == kind:
                what = f"{given} is for {other.served}, for which no column is named"
                column = argument(other.role, "HEADER")
                hint = f"name that column too, {column}, and give this sensor's sensitivity:"
                example = f"{role.replace('_', '-')}={example}"
        raise InputError(f"{said}: {what}", hint=f"{hint} {argument('sensitivity', example)}")
    stated = unit_text or header.stated
    kinds = " or ".join(kinds_of(role))
    problem = f"{shown(stated)} is no unit of {kinds}" if stated else "it has no unit"
    voltage = f", or mV and V with {argument('sensitivity', example)}" if example else ""
    usual, units = next(iter(SIGNAL_UNITS[kind])), ", ".join(SIGNAL_UNITS[kind])
    named = argument(role, f"{header.name} [{usual}]")
    hint = f"write the unit in brackets: {named}; units of {kind} are {units}"
    raise InputError(f"{said}: {problem}", hint=hint + voltage)


def _detected(path: Path, headers: list[Header], role: str) -> Columns:
    """Find the column whose unit fits, among several the one whose name fits; empty if there is none."""
    fitting = [Column(h, *h.unit) for h in headers if h.unit and h.unit[0] == KINDS[role]]
    if len(fitting) > 1:
        fitting = [column for column in fitting if _WORDS[role].fullmatch(column.header.name)] or fitting
    if len(fitting) > 1:
        several = f"{path}: {_list([column.header for column in fitting])} could each be the {role}"
        first = fitting[0].header.text
        own = f" of a part, {argument('trough_along', first)} of the trough" if role in DERIVATIVES else ""
        raise InputError(several, hint=f"choose: {argument(role, first)}{own}")
    return {role: fitting[0]} if fitting else {}


def _list(headers: Sequence[Header]) -> str:
    texts = [shown(h.text) for h in headers if h.text]
    more = len(texts) - TOL.headers_named
    return ", ".join(texts[: TOL.headers_named]) + (f" and {more} more" if more > 0 else "")
