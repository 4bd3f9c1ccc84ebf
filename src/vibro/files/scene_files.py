"""Scene files: TOML with the table [scene] and, optionally, [map]."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from vibro.axes import AxisSpec, axis_of
from vibro.errors import InputError, shown
from vibro.files.toml_files import did_you_mean, read_toml
from vibro.quantities import BY_COLUMN, STANDS_FOR, SWEPT, exact_number

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from vibro.quantities import Quantity

__all__ = ["SceneFile", "read_scene_file"]

_TABLES: Final = ("scene", "map")


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
                if key not in BY_COLUMN:
                    guess = did_you_mean(key, BY_COLUMN, len(problems))
                    problems.append(f"{path}: [{name}] unknown key {shown(key)}{guess}")
                    continue
                try:
                    spec = _entry(name, BY_COLUMN[key], value)
                    tables[name][spec.quantity.name] = spec
                except InputError as exc:
                    problems += [f"{path}: [{name}] {problem}" for problem in exc.problems]
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


def _as_number(key: str, text: str, quantity: Quantity) -> str:
    """Say how to write a text, with a unit or a decimal comma, as the number that it means; empty if none."""
    for reading in (text, text.replace(",", ".")):
        with suppress(InputError):
            return f"write {key} = {float(exact_number(reading, quantity)):.15g}"
    return ""
