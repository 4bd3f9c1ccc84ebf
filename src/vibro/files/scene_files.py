"""Scene files: TOML with the table [scene] and, optionally, [map]."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, cast

from vibro.axes import AxisSpec, axis_of
from vibro.errors import InputError, shown
from vibro.files.toml_files import did_you_mean, read_toml
from vibro.quantities import BY_COLUMN, MOST_HARMONICS, QUANTITIES, STANDS_FOR, SWEPT, exact_number

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from vibro.quantities import Quantity

__all__ = ["SceneFile", "read_scene_file"]

_TABLES: Final = ("scene", "map")
# Lists of a drive with harmonics, the first of which has the name of its quantity alone.
_LISTS: Final = {
    "along_amplitudes_mm": "along_amplitude",
    "along_phases_deg": "along_phase",
    "normal_amplitudes_mm": "normal_amplitude",
    "normal_phases_deg": "normal_phase",
}


@dataclass(frozen=True)
class SceneFile:
    """What a scene file says.

    Attributes
    ----------
    name : str
        The file's name without its suffix.
    scene : mapping of str to AxisSpec
        The table ``[scene]``: one value each, by the quantity's name.
    sweep : mapping of str to AxisSpec
        The table ``[map]``: values and axes, by the quantity's name.
    """

    name: str
    scene: Mapping[str, AxisSpec]
    sweep: Mapping[str, AxisSpec]


def read_scene_file(path: Path) -> SceneFile:
    """Read a scene file.

    Parameters
    ----------
    path : Path
        TOML with a table ``[scene]`` and, optionally, ``[map]``; the keys are names with units.

    Returns
    -------
    SceneFile
        Values are not checked against their physical ranges.

    Raises
    ------
    FileError
        If the file cannot be read.
    InputError
        If it is no TOML, or has keys or values that it may not have; all of them are named.
    """
    content = read_toml(path)
    problems: list[str] = []
    hints: list[str] = []
    tables: dict[str, dict[str, AxisSpec]] = {name: {} for name in _TABLES}
    lists: dict[str, object] = {}
    for name, table in content.items():
        if name not in tables:
            known = isinstance(table, dict)
            what = f"unknown {'table' if known else 'key'} {shown(name)}"
            problems.append(f"{path}: {what}{did_you_mean(name, _TABLES, len(problems))}")
            if not known:
                hints.append("keys belong in the table [scene] or [map]")
        elif not isinstance(table, dict):
            problems.append(f"{path}: {name} must be a table, written [{name}]")
        else:
            for key, value in table.items():
                if name == "scene" and key in _LISTS:
                    lists[key] = value
                    continue
                if key not in BY_COLUMN:
                    guess = did_you_mean(key, [*BY_COLUMN, *_LISTS], len(problems))
                    problems.append(f"{path}: [{name}] unknown key {shown(key)}{guess}")
                    continue
                try:
                    spec = _entry(name, BY_COLUMN[key], value)
                    tables[name][spec.quantity.name] = spec
                except InputError as exc:
                    problems += [f"{path}: [{name}] {problem}" for problem in exc.problems]
                    hints += [exc.hint] if exc.hint else []
    try:
        tables["scene"] |= _harmonics(lists, tables["scene"])
    except InputError as exc:
        problems += [f"{path}: [scene] {problem}" for problem in exc.problems]
        hints += [exc.hint] if exc.hint else []
    if problems:
        raise InputError(*problems, hint="\n".join(dict.fromkeys(hints)))
    return SceneFile(path.stem, tables["scene"], tables["map"])


def _entry(table: str, quantity: Quantity, value: object) -> AxisSpec:
    key = quantity.column
    if table == "map":
        spec = axis_of(value, quantity)
        if spec.varies and STANDS_FOR.get(quantity.name, quantity.name) not in SWEPT:
            raise InputError(
                f"{key} = {shown(value)}: {quantity.label} cannot be an axis", hint=f"give {key} one value"
            )
        return spec
    if isinstance(value, int | float) and not isinstance(value, bool):
        return axis_of(value, quantity)
    hint = f"write {key} = 1.5"
    if isinstance(value, str):
        hint = "axes belong in the table [map]" if ":" in value else _as_number(key, value, quantity) or hint
    raise InputError(f"{key} = {shown(value)}: must be a number, without quotes", hint=hint)


def _harmonics(lists: Mapping[str, object], others: Mapping[str, AxisSpec]) -> dict[str, AxisSpec]:
    """Read the lists of a drive with harmonics: a motion of which there is none stands still."""
    if not lists:
        return {}
    wrong = [key for key, value in lists.items() if not _is_list(value)]
    if wrong:
        raise InputError(
            *(f"{key} = {shown(lists[key])}: must be a list of numbers" for key in wrong),
            hint=f"write {wrong[0]} = [1, 0.2]: a number for each of at most {MOST_HARMONICS} harmonics",
        )
    read = {key: list(cast("list[float]", value)) for key, value in lists.items()}
    if len({len(values) for values in read.values()}) > 1:
        counts = ", ".join(f"{key} has {len(values)}" for key, values in read.items())
        raise InputError(f"lists of different lengths: {counts}", hint="write 0 for what a harmonic lacks")
    specs: dict[str, AxisSpec] = {}
    for key, values in read.items():
        for n, value in enumerate(values, 1):
            name = _LISTS[key] if n == 1 else f"{_LISTS[key]}_{n}"
            specs[name] = axis_of(value, QUANTITIES[name])
    for name in ("along_amplitude", "normal_amplitude"):
        still = axis_of(0.0, QUANTITIES[name])
        specs.setdefault(name, others.get(name, still))
    twice = [name for name in specs if name in others and specs[name] is not others[name]]
    if twice:
        said = ", ".join(QUANTITIES[name].column for name in twice)
        raise InputError(f"{said} beside lists of harmonics", hint="give either the lists or single numbers")
    return specs


def _is_list(value: object) -> bool:
    numbers = isinstance(value, list) and all(type(item) in (int, float) for item in value)
    return numbers and 0 < len(cast("list[float]", value)) <= MOST_HARMONICS


def _as_number(key: str, text: str, quantity: Quantity) -> str:
    """Say how to write a text, with a unit or a decimal comma, as the number that it means; empty if none."""
    for reading in (text, text.replace(",", ".")):
        with suppress(InputError):
            return f"write {key} = {float(exact_number(reading, quantity)):.15g}"
    return ""
