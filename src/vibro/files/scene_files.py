"""Read scene files: TOML with the table [scene] and, optionally, [motion], [machine] and [map]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vibro.axes import AxisSpec, axis_of
from vibro.errors import InputError, Problems
from vibro.files.descriptions import SCENE_FILE
from vibro.files.entries import ABSENT
from vibro.files.machines import given_machine
from vibro.files.motions import HARMONICS, motion_of, way_of
from vibro.files.toml_files import read_toml, refuse_other_kinds, refuse_unknown_tables
from vibro.quantities import MASS, NORMAL_FORCE, QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from vibro.files.machines import GivenMachine
    from vibro.files.motions import GivenMotion


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
    motion : GivenMotion or None
        The table ``[motion]``, if it gives steps or samples; harmonics are in ``scene``.
    machine : GivenMachine or None
        The table ``[machine]``.
    """

    name: str
    scene: Mapping[str, AxisSpec]
    sweep: Mapping[str, AxisSpec]
    motion: GivenMotion | None = None
    machine: GivenMachine | None = None


def read_scene_file(path: Path) -> SceneFile:
    """Read a scene file.

    Parameters
    ----------
    path : Path
        TOML with a table ``[scene]`` and, optionally, ``[motion]``, ``[machine]`` and ``[map]``; the keys are
        names with units.

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
    tables = {
        name: SCENE_FILE.table(name, content.get(name, ABSENT), problems).values for name in SCENE_FILE.tables
    }
    scene, motion = tables["scene"], None
    lists = {called: scene.pop(called) for called, value in [*scene.items()] if isinstance(value, list)}
    machine = None
    if not problems.found:
        with problems.taken("[motion] "):
            if "motion" in content and way_of(tables["motion"]) == HARMONICS:
                lists |= _lists_of(tables["motion"], lists)
            elif "motion" in content:
                motion = motion_of(tables["motion"])
        with problems.taken("[machine] "):
            if "machine" in content:
                machine = given_machine(content["machine"], tables["machine"], path.parent)
        with problems.taken("[scene] "):
            scene |= _clamped(scene)
    with problems.taken("[scene] "):
        scene |= _harmonics(lists, scene)
    problems.settle()
    return SceneFile(path.stem, scene, tables["map"], motion, machine)


def _lists_of(table: Mapping[str, list[list[float]]], lists: Mapping[str, Any]) -> dict[str, list[float]]:
    """Return pairs of harmonics as the lists of [scene], as many for both directions."""
    if lists:
        raise InputError("gives harmonics beside lists of [scene]", hint="give either [motion] or the lists")
    count = max(map(len, table.values()))
    found = {}
    for key, pairs in table.items():
        way = key.partition("_")[0]
        filled = [*pairs, *[[0.0, 0.0]] * (count - len(pairs))]
        found[f"{way}_amplitudes"], found[f"{way}_phases"] = map(list, zip(*filled, strict=True))
    return found


def _clamped(scene: dict[str, Any]) -> dict[str, AxisSpec]:
    """Replace the normal force on a part and its mass by their quotient."""
    force, mass = (scene.pop(quantity.name, None) for quantity in (NORMAL_FORCE, MASS))
    clamped = QUANTITIES["normal_acceleration"]
    if force is None and mass is None:
        return {}
    if force is None or mass is None or clamped.name in scene:
        both = f"{NORMAL_FORCE.column} and {MASS.column}"
        alone = f"{MASS.column if force is None else NORMAL_FORCE.column} is given alone"
        problem = f"{both} beside {clamped.column}" if clamped.name in scene else alone
        raise InputError(problem, hint=f"give {both}, or {clamped.column}")
    return {clamped.name: axis_of(force / mass, clamped)}


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
    if twice := ", ".join(QUANTITIES[name].column for name in specs if name in others):
        raise InputError(f"{twice} beside lists of harmonics", hint="give either the lists or single numbers")
    moved = {*specs, *others}
    still = [name for name in ("along_amplitude", "normal_amplitude") if name not in moved]
    return specs | {name: axis_of(0.0, QUANTITIES[name]) for name in still}
