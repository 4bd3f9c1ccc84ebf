"""Plans of sweeps in shards: what the manifest says, with a fingerprint of what decides their cells."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np

from vibro.axes import Axis
from vibro.core.codes import Output
from vibro.errors import FileError, InputError, cut, shown
from vibro.files.machines import machine_of
from vibro.files.motions import motion_of
from vibro.files.reading import opened
from vibro.quantities import QUANTITIES
from vibro.sweeps.columns import Table, table_columns
from vibro.sweeps.derived import throughput
from vibro.sweeps.grid import GIVEN_IN, Grid
from vibro.tables.record import sweep_record
from vibro.threads import BLOCK
from vibro.version import __version__

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

#: Programs that read a folder of Parquet files skip names that begin with _ or a point.
MANIFEST: Final = "_manifest.json"
SUCCESS: Final = "_SUCCESS"

# [cells] of a shard: seconds of work, some tens of megabytes. Means of bodies that bounce, and searches for
# other motions, take up to some ms a cell: there a shard takes about a minute.
_SHARD_CELLS: Final = 1_000_000
_DEAR_SHARD_CELLS: Final = 20_000
_MOST_SHARDS: Final = 1_000_000  # that six digits can number
_FORMATS: Final = "vibro sweep "
_FORMAT: Final = f"{_FORMATS}4"
# Keys left out of the fingerprint: command line, settings of pictures, values that follow from others.
_NOT_COMPARED: Final = ("argv", "name", "own", "fingerprint", "checksum", GIVEN_IN)
_LONGEST: Final = 60  # characters of a value in a message


def sealed(content: Mapping[str, Any]) -> str:
    """Write JSON with a checksum of what it says."""
    return json.dumps({**content, "checksum": _digest(content)}, indent=1, allow_nan=False) + "\n"


def unsealed(text: str | bytes) -> dict[str, Any]:
    """Read what ``sealed`` wrote.

    Raises
    ------
    Exception
        Of any kind, if it was changed since.
    """
    content = json.loads(text)
    if content.pop("checksum", "") != _digest(content):
        raise ValueError("its checksum is another one")
    return dict(content)


def _digest(content: Mapping[str, Any]) -> str:
    text = json.dumps(content, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


@cache
def made_by() -> Mapping[str, str]:
    """Return what decides the last bits of a shard: versions of libraries, and the platform's functions."""
    libraries = {name: version(name) for name in ("numpy", "scipy", "pyarrow")}
    return {"vibro": __version__, **libraries, "platform": f"{platform.system()} {platform.machine()}"}


def shard_name(number: int) -> str:
    """Name the file of a shard."""
    return f"part-{number:06d}.parquet"


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
    content : mapping
        What the manifest says, without the run that began it; with ``fingerprint``, which is equal for two
        plans whose shards are the same.
    """

    grid: Grid
    table: Table
    shard_cells: int
    name: str
    own: Mapping[str, float]
    content: Mapping[str, Any] = field(repr=False)

    @classmethod
    def of(
        cls, grid: Grid, table: Table, name: str, own: Mapping[str, float], shard_cells: int | None = None
    ) -> Self:
        """Make the plan of a sweep, in shards of the usual size unless that is given."""
        is_dear = grid.is_dear or grid.machine is not None
        cells = shard_cells or (_DEAR_SHARD_CELLS if is_dear else _SHARD_CELLS)
        if grid.size > (most := _MOST_SHARDS * cells):
            problem = f"{grid.size} cells are more than a folder holds, {most}"
            raise InputError(problem, hint="ask for fewer values")
        begun = {"format": _FORMAT, "made_by": dict(made_by()), "name": name, "own": dict(own)}
        content = {**begun, **sweep_record(grid, table, every_value=True)}
        content |= {"shard_cells": cells, "row_group_cells": BLOCK}
        content["fingerprint"] = _digest(_counted(content))
        return cls(grid, table, cells, name, own, content)

    @property
    def shards(self) -> int:
        """Number of shards."""
        return -(-self.grid.size // self.shard_cells)

    @property
    def row_group_cells(self) -> int:
        """Cells of each row group of a shard; the last may have fewer."""
        return int(self.content["row_group_cells"])

    @property
    def fingerprint(self) -> str:
        """Fingerprint of everything that decides the shards' cells."""
        return str(self.content["fingerprint"])

    def range_of(self, shard: int) -> tuple[int, int]:
        """Return the first cell of a shard, and the one after its last."""
        return shard * self.shard_cells, min((shard + 1) * self.shard_cells, self.grid.size)

    def manifest(self, argv: Sequence[str]) -> str:
        """Return the manifest of a run with these arguments."""
        return sealed({**self.content, "argv": list(argv)})

    def differences(self, there: Plan) -> str:
        """Say how the plan in the folder differs from this one, as far as it changes the shards."""
        differences = _differences(_described(there.content), _described(self.content))
        return "; ".join(differences or _differences(_counted(there.content), _counted(self.content)))


def read_plan(path: Path) -> Plan:
    """Read a manifest.

    Raises
    ------
    FileError
        If it is no manifest of a sweep, or was changed after it was written.
    """
    try:
        with opened(path) as stream:
            text = stream.read()
        form = json.loads(text)["format"]
    except OSError as exc:
        raise FileError(f"cannot read {path}: {exc.strerror or exc}") from exc
    except Exception:  # it is something else
        form = None
    if not str(form).startswith(_FORMATS):
        raise FileError(f"{path} is no manifest of a sweep", hint="choose another folder")
    if form != _FORMAT:
        raise FileError(f"{path}: {shown(form)} is an unknown format", hint="use the vibro that wrote it")
    try:
        return _plan_of(unsealed(text))  # first: changed numbers may ask for endless work
    except MemoryError:
        raise
    except Exception:  # whatever a change may lead to
        hint = "restore the file, or choose another folder"
        raise FileError(f"{path} is damaged, or was changed after it was written", hint=hint) from None


def _plan_of(content: Mapping[str, Any]) -> Plan:
    names = {quantity.column: quantity.name for quantity in QUANTITIES.values()}
    axes = {
        names[key]: Axis(names[key], np.array(axis["values"], np.float64), axis["spacing"])
        for key, axis in content["axes"].items()
    }
    scene = {names[key]: float(value) for key, value in content["scene"].items()}
    length = scene.pop("trough_length", None)
    motion = motion_of(content["motion"]) if "motion" in content else None
    machine = machine_of(content["machine"]) if "machine" in content else None
    solved = Output(content["accuracy"]), content["flight"], content.get("starts")
    in_stroke = content.get(GIVEN_IN) == QUANTITIES["stroke"].column
    grid = Grid(axes, scene, length, *solved, motion=motion, in_stroke=in_stroke, machine=machine)
    part = content.get("part", {})
    table = Table(table_columns(grid, list(content["columns"]), throughput(part)), part)
    return Plan(grid, table, content["shard_cells"], content["name"], content["own"], content)


def _counted(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the fingerprint covers of a manifest, with the order of columns."""
    counted = {key: value for key, value in content.items() if key not in _NOT_COMPARED}
    return {**counted, "columns": list(content["columns"].items())}


def _described(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the fingerprint covers, for people."""
    counted = _counted(content)
    del counted["cells"]  # they follow from the axes
    axes = {
        column: f"{len(axis['values'])} values, {axis['values'][0]:.10g} ... {axis['values'][-1]:.10g}"
        for column, axis in content["axes"].items()
    }
    return {**counted, "axes": axes, "columns": ", ".join(content["columns"])}


def _differences(there: Mapping[str, Any], here: Mapping[str, Any], within: str = "") -> list[str]:
    differences = []
    for key in dict.fromkeys([*here, *there]):
        old, new = there.get(key), here.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            differences += _differences(old, new, f"{within}{key} ")
        elif old != new:
            texts = (x if isinstance(x, str) else json.dumps(x) for x in (old, new))
            before, now = (cut(text, _LONGEST) for text in texts)
            differences.append(f"{within}{key}: {before} there, {now} here")
    return differences
