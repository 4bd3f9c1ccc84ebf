"""Plans of sweeps in shards: what the manifest says, with a fingerprint of what decides their bytes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np

from vibro import __version__
from vibro.axes import Axis
from vibro.core.codes import Output
from vibro.errors import FileError, InputError, VibroError, how_to_install
from vibro.files.machines import machine_of
from vibro.files.motions import motion_of
from vibro.output.names import PICTURE_FILES
from vibro.output.record import sweep_record
from vibro.output.shard_folder import MANIFEST, MOST_SHARDS, SUCCESS, shard_name
from vibro.parallel import BLOCK
from vibro.quantities import QUANTITIES
from vibro.sweeps.columns import Table, chosen, columns_of
from vibro.sweeps.derived import throughput
from vibro.sweeps.grid import GIVEN_IN, Grid

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["ROW_GROUP", "Plan", "check_arrow", "read_plan", "usual_shard_cells", "versions"]

#: [cells] Solved and encoded at once: the bytes of a shard depend on it.
ROW_GROUP: Final = BLOCK

# [cells] of a shard by default: seconds of work, some tens of megabytes. Means of bodies that bounce,
# and searches for other motions, take up to some ms a cell: there a shard takes about a minute.
_SHARD_CELLS: Final = 1_000_000
_DEAR_SHARD_CELLS: Final = 20_000

_FORMATS: Final = "vibro sweep "
_FORMAT: Final = f"{_FORMATS}3"
# Keys left out of the fingerprint: command line, settings of pictures, values that follow from others.
_NOT_COMPARED: Final = ("argv", "name", "own", "pictures", "fingerprint", GIVEN_IN)


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
        raise FileError("Parquet needs pyarrow", hint=how_to_install("parquet")) from None


@cache
def versions() -> Mapping[str, str]:
    """Return the versions of all libraries that decide a shard's bytes."""
    return {"vibro": __version__, **{name: version(name) for name in ("numpy", "scipy", "pyarrow")}}


def usual_shard_cells(grid: Grid) -> int:
    """Return how many cells a shard has where nobody asks for a number: fewer where cells are dear."""
    restitution = grid.axes["restitution"].values if "restitution" in grid.axes else grid.fixed["restitution"]
    dear = grid.machine is not None or (grid.flight and (grid.coexistence or np.any(restitution)))
    return _DEAR_SHARD_CELLS if dear else _SHARD_CELLS


@dataclass(frozen=True, eq=False)
class Plan:
    """A sweep, cut into shards.

    Attributes
    ----------
    grid : Grid
        The grid. Cells are numbered through, the last axis fastest.
    table : Table
        The columns written.
    shard_cells : int
        Cells of each shard; the last may have fewer.
    name : str
        Name of the scene.
    own : mapping of str to float
        The scene's own values, in the user's units, for pictures.
    pictures : tuple of str
        File names of the pictures that are drawn into the folder.
    content : mapping
        What the manifest says, without the run that began it; with ``fingerprint``, which is equal for two
        plans whose shards are the same.
    """

    grid: Grid
    table: Table
    shard_cells: int
    name: str
    own: Mapping[str, float]
    pictures: tuple[str, ...]
    content: Mapping[str, Any] = field(repr=False)

    @classmethod
    def of(
        cls,
        grid: Grid,
        table: Table,
        shard_cells: int | None,
        name: str,
        own: Mapping[str, float],
        pictures: Sequence[str] = (),
    ) -> Self:
        """Make the plan of a sweep, in shards of the usual size unless that is given.

        Raises
        ------
        InputError
            If there would be more shards than names can number.
        """
        cells = shard_cells or usual_shard_cells(grid)
        shards = -(-grid.size // cells)
        if shards > MOST_SHARDS:
            raise InputError(
                f"shard_cells={cells}: {grid.size} cells would be {shards} shards, more than {MOST_SHARDS}",
                hint=f"give at least shard_cells={-(-grid.size // MOST_SHARDS)}",
            )
        content = {
            "format": _FORMAT,
            "versions": dict(versions()),
            "name": name,
            "own": dict(own),
            "pictures": list(pictures),
            **sweep_record(grid, table, every_value=True),
            "shard_cells": cells,
            "row_group_cells": ROW_GROUP,
        }
        content["fingerprint"] = _fingerprint(content)
        return cls(grid, table, cells, name, own, tuple(pictures), content)

    @property
    def shards(self) -> int:
        """Number of shards."""
        return -(-self.grid.size // self.shard_cells)

    @property
    def fingerprint(self) -> str:
        """Fingerprint of everything that decides the shards' bytes."""
        return str(self.content["fingerprint"])

    @property
    def files(self) -> set[str]:
        """Names of its files, each one that vibro gives and the manifest lists."""
        pictures = PICTURE_FILES.intersection(self.pictures)
        return {MANIFEST, SUCCESS, *map(shard_name, range(self.shards)), *pictures}

    def range_of(self, shard: int) -> tuple[int, int]:
        """Return the first cell of a shard, and the one after its last."""
        return shard * self.shard_cells, min((shard + 1) * self.shard_cells, self.grid.size)

    def manifest(self, argv: Sequence[str], pictures: Sequence[str] = ()) -> str:
        """Return the manifest of a run with these arguments, with more pictures than the plan's own."""
        content = {**self.content, "pictures": list(dict.fromkeys((*self.pictures, *pictures)))}
        return json.dumps({**content, "argv": list(argv)}, indent=1, allow_nan=False) + "\n"

    def differences(self, other: Plan) -> list[str]:
        """List how the plan in the folder differs from this one, as far as it changes the shards."""
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
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        content = None
    if not isinstance(content, dict) or not str(content.get("format")).startswith(_FORMATS):
        raise FileError(f"{path} is no manifest of a sweep", hint="choose another folder")
    if content["format"] != _FORMAT:
        raise FileError(
            f"{path}: {content['format']} is an unknown format", hint="use the vibro that wrote it"
        )
    try:
        if _fingerprint(content) != content["fingerprint"]:  # first: changed numbers may ask for endless work
            raise ValueError("fingerprint")
        return _plan_of(content)
    except (LookupError, TypeError, ValueError, AttributeError, VibroError):
        raise FileError(
            f"{path} is damaged, or was changed after it was written",
            hint="restore the file, or choose another folder",
        ) from None


def _plan_of(content: Mapping[str, Any]) -> Plan:
    known = {quantity.column: quantity for quantity in QUANTITIES.values()}
    axes = {}
    for column, entry in content["axes"].items():
        name = known[column].name
        axes[name] = Axis(name, np.array(entry["values"], np.float64), entry["spacing"])
    scene = {known[column].name: float(value) for column, value in content["scene"].items()}
    length = scene.pop("trough_length", None)
    motion = motion_of(content["motion"]) if "motion" in content else None
    machine = machine_of(content["machine"]) if "machine" in content else None
    solved = Output(content["accuracy"]), content["flight"], content["coexistence"]
    in_stroke = content.get(GIVEN_IN) == QUANTITIES["stroke"].column
    grid = Grid(axes, scene, length, *solved, motion=motion, in_stroke=in_stroke, machine=machine)
    part = content.get("part", {})
    extra = throughput(part["pitch_mm"], part.get("mass_kg")) if "pitch_mm" in part else ()
    columns = chosen(
        list(content["columns"]), columns_of(axes, *extra, drive=grid.drive, machine=machine is not None)
    )
    table = Table(columns, content["digits"], part)
    own = {str(name): float(value) for name, value in content["own"].items()}
    pictures = tuple(map(str, content["pictures"]))
    return Plan(grid, table, content["shard_cells"], str(content["name"]), own, pictures, content)


def _fingerprint(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(_text(_counted(content)).encode()).hexdigest()


def _text(value: Any) -> str:
    return json.dumps(value, sort_keys=True, allow_nan=False)


def _counted(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the fingerprint covers of a manifest, with the order of columns."""
    counted = {key: value for key, value in content.items() if key not in _NOT_COMPARED}
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
