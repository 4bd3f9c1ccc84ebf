"""Read scene files: TOML with the table [scene] and, optionally, [map]."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vibro.axes import AxisSpec, axis_of
from vibro.errors import InputError, Problems
from vibro.files.descriptions import SCENE_FILE
from vibro.files.toml_files import ABSENT, Table, read_toml, refuse_other_kinds, refuse_unknown_tables
from vibro.quantities import QUANTITIES

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["SceneFile", "read_scene_file"]


@dataclass(frozen=True)
class SceneFile:
    """Content of a scene file.

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
        If it is not TOML, is a question of ``vibro design``, or has invalid keys or values; the message
        names all of them.
    """
    content = read_toml(path)
    refuse_other_kinds(content, SCENE_FILE, path)
    problems = Problems(f"{path}: ")
    refuse_unknown_tables(content, SCENE_FILE, problems)
    tables: dict[str, dict[str, AxisSpec]] = {}
    lists: dict[str, list[float]] = {}
    for name in SCENE_FILE.tables:
        given = content.get(name, ABSENT)
        if not isinstance(given, Mapping):
            problems.add(f"{name} must be a table, written [{name}]")
            given = ABSENT
        values = Table(SCENE_FILE, name, given, problems).values
        lists |= {called: value for called, value in values.items() if isinstance(value, list)}
        tables[name] = {called: spec for called, spec in values.items() if called not in lists}
    with problems.taken("[scene] "):
        tables["scene"] |= _harmonics(lists, tables["scene"])
    problems.settle()
    return SceneFile(path.stem, tables["scene"], tables["map"])


def _harmonics(lists: Mapping[str, list[float]], others: Mapping[str, AxisSpec]) -> dict[str, AxisSpec]:
    """Read the lists of a drive with harmonics; a direction without lists does not move."""
    if not lists:
        return {}
    if len({len(values) for values in lists.values()}) > 1:
        keys = {entry.quantity.name: key for key, entry in SCENE_FILE.tables["scene"].entries.items()}
        counts = ", ".join(f"{keys[name]} has {len(values)}" for name, values in lists.items())
        raise InputError(f"lists of different lengths: {counts}", hint="write 0 for what a harmonic lacks")
    specs: dict[str, AxisSpec] = {}
    for plural, values in lists.items():
        first = plural.removesuffix("s")
        for n, value in enumerate(values, 1):
            name = first if n == 1 else f"{first}_{n}"
            specs[name] = axis_of(value, QUANTITIES[name])
    for name in ("along_amplitude", "normal_amplitude"):
        still = axis_of(0.0, QUANTITIES[name])
        specs.setdefault(name, others.get(name, still))
    twice = [name for name in specs if name in others and specs[name] is not others[name]]
    if twice:
        said = ", ".join(QUANTITIES[name].column for name in twice)
        raise InputError(f"{said} beside lists of harmonics", hint="give either the lists or single numbers")
    return specs
