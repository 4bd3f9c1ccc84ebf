"""Plans of sweeps in parts: the manifest, and a fingerprint of everything that decides the parts' bytes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from vibro import __version__
from vibro.axes import Axis
from vibro.core.codes import Level
from vibro.errors import FileError, InputError, VibroError
from vibro.files.motions import motion_of
from vibro.files.part_sets import MOST_PARTS, part_name
from vibro.parallel import BLOCK
from vibro.quantities import QUANTITIES
from vibro.sweeps.columns import Table, chosen, columns_of
from vibro.sweeps.derived import throughput
from vibro.sweeps.grid import Grid

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["PART_CELLS", "ROW_GROUP", "Plan", "check_arrow", "check_manifest", "read_plan", "versions"]

#: [cells] of a part, unless asked for: seconds of work, some tens of megabytes.
PART_CELLS: Final = 1_000_000
#: [cells] Solved and encoded at once: the bytes of a part depend on it.
ROW_GROUP: Final = BLOCK

_FORMATS: Final = "vibro sweep "
_FORMAT: Final = f"{_FORMATS}1"
# Keys left out of the fingerprint: command line, settings of pictures, values that follow from others.
_BESIDE: Final = ("argv", "name", "own", "parts", "fingerprint")


def check_arrow() -> None:
    """Say what to install where pyarrow is missing.

    Raises
    ------
    FileError
        If it is missing.
    """
    try:
        import pyarrow.parquet  # noqa: F401 - whether it is installed
    except ImportError:
        raise FileError("Parquet needs pyarrow", hint="pip install 'vibro[parquet]'") from None


@cache
def versions() -> Mapping[str, str]:
    """Return the versions of all libraries that decide a part's bytes."""
    return {"vibro": __version__, **{name: version(name) for name in ("numpy", "scipy", "pyarrow")}}


@dataclass(frozen=True, eq=False)
class Plan:
    """A sweep, cut into parts.

    Attributes
    ----------
    grid : Grid
        The grid. Cells are numbered through, the last axis fastest.
    table : Table
        The columns written.
    part_cells : int
        Cells of each part; the last may have fewer.
    name : str
        Name of the scene.
    own : mapping of str to float
        The scene's own values, in the user's units, for pictures.
    versions : mapping of str to str
        Versions of the libraries that make the parts.
    """

    grid: Grid
    table: Table
    part_cells: int
    name: str
    own: Mapping[str, float]
    versions: Mapping[str, str]

    @property
    def parts(self) -> int:
        """Number of parts."""
        return -(-self.grid.size // self.part_cells)

    def range_of(self, part: int) -> tuple[int, int]:
        """Return the first cell of a part, and the one after its last."""
        return part * self.part_cells, min((part + 1) * self.part_cells, self.grid.size)

    @cached_property
    def fingerprint(self) -> str:
        """Fingerprint, equal for two plans whose parts are the same."""
        return _fingerprint(self.content)

    @property
    def content(self) -> dict[str, Any]:
        """Content of the manifest, without the run that began it."""
        grid, table = self.grid, self.table
        described = grid.describe()
        return {
            "format": _FORMAT,
            "versions": dict(self.versions),
            "name": self.name,
            "axes": [
                {"column": axis.column, "spacing": axis.spacing, "values": axis.values.tolist()}
                for axis in grid.axes.values()
            ],
            "scene": described["scene"],
            **({"motion": described["motion"]} if "motion" in described else {}),
            "own": dict(self.own),
            "accuracy": grid.level.value,
            "flight": grid.flight,
            "coexistence": grid.coexistence,
            "part": dict(table.part),
            "digits": table.digits,
            "columns": {column.name: column.unit for column in table.columns},
            "cells": grid.size,
            "part_cells": self.part_cells,
            "row_group_cells": ROW_GROUP,
            "parts": [
                {"file": part_name(part), "first_cell": first, "cells": end - first}
                for part in range(self.parts)
                for first, end in [self.range_of(part)]
            ],
        }

    def manifest(self, argv: Sequence[str]) -> str:
        """Return the manifest of a run with these arguments."""
        content = {**self.content, "argv": list(argv), "fingerprint": self.fingerprint}
        return json.dumps(content, indent=1, allow_nan=False) + "\n"

    def check(self) -> None:
        """Refuse more parts than names can number."""
        if self.parts > MOST_PARTS:
            least = -(-self.grid.size // MOST_PARTS)
            raise InputError(
                f"part cells = {self.part_cells}: {self.grid.size} cells would be {self.parts} parts,"
                f" more than {MOST_PARTS}",
                hint=f"give at least {least}",
            )

    def differences(self, other: Plan) -> list[str]:
        """List how the plan in the folder differs from this one, as far as it changes the parts."""
        there, here = _counted(other.content), _counted(self.content)
        told = []
        for key in dict.fromkeys([*here, *there]):
            if _text(there.get(key)) == _text(here.get(key)):
                continue
            if key == "axes":
                told += _axis_differences(other.grid, self.grid)
            elif key == "columns":
                told.append(
                    _column_difference(*([name for name, _ in which[key]] for which in (there, here)))
                )
            elif isinstance(here.get(key), Mapping) and isinstance(there.get(key), Mapping):
                told += _entry_differences(there[key], here[key])
            else:
                told.append(_difference(key.replace("_", " "), there.get(key), here.get(key)))
        return told


def check_manifest(text: str, path: object) -> dict[str, Any]:
    """Return the content of a manifest, unchecked.

    Raises
    ------
    FileError
        If it is no manifest of a sweep.
    """
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        content = None
    if not isinstance(content, dict) or not str(content.get("format")).startswith(_FORMATS):
        raise FileError(f"{path} is no manifest of a sweep", hint="choose another folder")
    return content


def read_plan(text: str, path: object) -> Plan:
    """Read a manifest.

    Parameters
    ----------
    text : str
        JSON.
    path : path
        For messages.

    Raises
    ------
    FileError
        If it is no manifest of a sweep, or was changed after it was written.
    """
    content = check_manifest(text, path)
    if content["format"] != _FORMAT:
        raise FileError(f"{path}: {content['format']} is not known here", hint="use the vibro that wrote it")
    try:
        return _plan_of(content)
    except (LookupError, TypeError, ValueError, AttributeError, VibroError):
        raise FileError(
            f"{path} is damaged, or was changed after it was written",
            hint="put back what was there, or start anew with --force",
        ) from None


def _plan_of(content: Mapping[str, Any]) -> Plan:
    """Make a plan of a manifest; ValueError if it was changed after it was written."""
    if _fingerprint(content) != content["fingerprint"]:  # first: changed numbers may ask for endless work
        raise ValueError("fingerprint")
    known = {quantity.column: quantity for quantity in QUANTITIES.values()}
    quantities = [known[entry["column"]] for entry in content["axes"]]
    axes = {
        quantity.name: Axis(quantity.name, np.array(entry["values"], np.float64), entry["spacing"])
        for quantity, entry in zip(quantities, content["axes"], strict=True)
    }
    scene = {known[column].name: float(value) for column, value in content["scene"].items()}
    length = scene.pop("trough_length", None)
    motion = motion_of(content["motion"]) if "motion" in content else None
    solved = Level(content["accuracy"]), content["flight"], content["coexistence"]
    grid = Grid(axes, scene, length, *solved, motion=motion)
    part = content["part"]
    extra = throughput(part["pitch_mm"], part.get("mass_kg")) if "pitch_mm" in part else ()
    columns = chosen(list(content["columns"]), columns_of(axes, *extra, drive=grid.drive))
    table = Table(columns, content["digits"], part)
    own = {str(name): float(value) for name, value in content["own"].items()}
    plan = Plan(grid, table, content["part_cells"], str(content["name"]), own, content["versions"])
    if plan.fingerprint != content["fingerprint"] or plan.content["parts"] != content["parts"]:
        raise ValueError("content")
    return plan


def _fingerprint(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(_text(_counted(content)).encode()).hexdigest()


def _text(value: Any) -> str:
    return json.dumps(value, sort_keys=True, allow_nan=False)


def _counted(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parts of a manifest that the fingerprint covers, with the order of columns."""
    counted = {key: value for key, value in content.items() if key not in _BESIDE}
    return {**counted, "columns": list(content["columns"].items())}


def _difference(what: str, there: object, here: object) -> str:
    said = ["none" if value is None else value for value in (there, here)]
    return f"{what}: {said[0]} there, {said[1]} here"


def _column_difference(there: list[str], here: list[str]) -> str:
    """Name the columns that are on one side alone; where both have the same ones, their orders."""
    alone = [[name for name in names if name not in {*there} & {*here}] for names in (there, here)]
    told = [",".join(names) or None for names in (alone if any(alone) else (there, here))]
    return _difference("columns", *told)


def _entry_differences(there: Mapping[str, Any], here: Mapping[str, Any]) -> list[str]:
    names = [
        name for name in dict.fromkeys([*here, *there]) if _text(there.get(name)) != _text(here.get(name))
    ]
    return [_difference(name, there.get(name), here.get(name)) for name in names]


def _axis_differences(there: Grid, here: Grid) -> list[str]:
    told = []
    for name in [name for name in QUANTITIES if name in {*there.axes, *here.axes}]:
        axes = [grid.axes.get(name) for grid in (there, here)]
        values = [axis.values.tolist() if axis else [] for axis in axes]
        if _text(values[0]) != _text(values[1]):
            said = [str(axis).partition(": ")[2] if axis else "no axis" for axis in axes]
            if said[0] == said[1]:
                changed = next(
                    (pair for pair in zip(*values, strict=False) if _text(pair[0]) != _text(pair[1])), None
                )
                said = [repr(value) for value in changed] if changed else said
            told.append(_difference(QUANTITIES[name].column, *said))
    if not told:
        told = [
            _difference("spacing of axes", *([a.spacing for a in g.axes.values()] for g in (there, here)))
        ]
    return told
