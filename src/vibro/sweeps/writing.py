"""Sweeps written in parts, from Python and for the command line: the request, and its workers."""

from __future__ import annotations

import os
import re
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal

from vibro.core.codes import Level
from vibro.errors import InputError, shown
from vibro.files.part_sets import PartSet, part_folder
from vibro.output.workers import workers_of
from vibro.steady import check_switch, level_of
from vibro.sweeps.columns import Table, chosen, columns_of
from vibro.sweeps.parted import agree, make_parts
from vibro.sweeps.plan import PART_CELLS, Plan, check_arrow, versions
from vibro.sweeps.stored import open_sweep
from vibro.sweeps.whole import request_of_call

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from os import PathLike

    from vibro.sweeps.grid import Grid
    from vibro.sweeps.parted import Progress, Summary
    from vibro.sweeps.stored import StoredSweep

__all__ = ["Parting", "write_sweep"]

_ADDRESS: Final = re.compile(r"(tcp|tls|wss?)://\S+:\d+")
_MOST_WORKERS: Final = 1024
_MOST_CELLS: Final = 100_000_000  # [cells] of a part: more would cost hours of work at a fault


@dataclass(frozen=True, kw_only=True)
class Parting:
    """How a table in parts is made.

    Parameters
    ----------
    part_cells : int, optional
        Cells of each part; 1e6, or as many as existing parts have.
    workers : int, optional
        Processes that make the parts; without, threads of this one.
    scheduler : str, optional
        Address of a Dask cluster that makes them.
    resume, force : bool
        Whether to continue the sweep in the folder, or to replace it.

    Raises
    ------
    InputError
        If one of them is out of range, or they exclude each other.
    """

    part_cells: int | None = None
    workers: int | None = None
    scheduler: str | None = None
    resume: bool = False
    force: bool = False

    def __post_init__(self) -> None:
        _check_number("part cells", self.part_cells, _MOST_CELLS, "1000000 is usual")
        _check_number("workers", self.workers, _MOST_WORKERS, "one a core is usual")
        check_switch("resume", self.resume)
        check_switch("force", self.force)
        if self.workers is not None and self.scheduler is not None:
            raise InputError(
                "workers and scheduler are both given: either makes all parts", hint="leave one of them out"
            )
        if self.resume and self.force:
            raise InputError(
                "resume and force are both given: the one goes on, the other starts anew",
                hint="leave one of them out",
            )
        if self.scheduler is not None and not _ADDRESS.fullmatch(str(self.scheduler)):
            raise InputError(
                f"scheduler = {shown(self.scheduler)}: is no address", hint="write it like tcp://host:8786"
            )

    def plan(self, grid: Grid, table: Table, name: str, own: Mapping[str, float]) -> Plan:
        """Make the plan of a sweep."""
        check_arrow()
        return Plan(grid, table, self.part_cells or PART_CELLS, name, own, versions())

    def carry_out(
        self,
        plan: Plan,
        files: PartSet,
        argv: Sequence[str],
        report: Callable[[Progress], None] = lambda progress: None,
    ) -> Summary:
        """Make the parts of a plan in a folder that is entered; see ``make_parts``."""
        given = self.part_cells is not None
        agreed = agree(files, plan, resume=self.resume, force=self.force, own_size=given)
        with workers_of(agreed.parts, self.workers, self.scheduler) as workers:
            return make_parts(agreed, files, workers, argv, resume=self.resume, report=report)


def write_sweep(
    folder: str | PathLike[str],
    scene_file: str | PathLike[str] | None = None,
    *,
    columns: Sequence[str] | None = None,
    part_cells: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    resume: bool = False,
    force: bool = False,
    accuracy: Literal["exact", "regimes"] = "exact",
    flight: bool = True,
    coexistence: bool = False,
    **quantities: Any,
) -> StoredSweep:
    """Solve all combinations of the axes, however many, into a folder of Parquet files.

    Parameters
    ----------
    folder : path
        The folder; it is created.
    scene_file, accuracy, flight, coexistence, **quantities
        As for ``vibro.sweep``.
    columns : sequence of str, optional
        Names as for ``--columns`` of ``vibro map``, in the order wanted; without, its usual ones.
    part_cells : int, optional
        Cells of each file; 1e6, or as many as existing files have.
    workers : int, optional
        Processes that make the files; without, threads of this one. A script that asks for them needs the
        line ``if __name__ == "__main__":``.
    scheduler : str, optional
        Address of a Dask cluster that makes the files, such as ``"tcp://host:8786"``. Its workers need the
        same versions of vibro, NumPy, SciPy and pyarrow, and the same folder under the same path.
    resume : bool, optional
        Whether to continue the same sweep in a folder where it was cut short.
    force : bool, optional
        Whether to start anew in a folder that holds a sweep.

    Returns
    -------
    StoredSweep
        As ``vibro.open_sweep`` returns it.

    Raises
    ------
    InputError
        It names everything that is wrong or missing.
    FileError
        If the folder cannot be written, holds something else, or is being written by another run; if pyarrow,
        or for a scheduler distributed, is not installed.

    Notes
    -----
    The bytes of the files follow from the arguments and the versions of the libraries alone, on one kind
    of processor: not from the number or kind of workers, or from how often the sweep is resumed
    (tests/sweeps/test_parts.py).

    Examples
    --------
    >>> import tempfile, vibro
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     t = vibro.write_sweep(folder, amplitude_mm="0.5:1.5:3", frequency_hz=15, drive_angle_deg=20,
    ...                           static_friction=0.74, kinetic_friction=0.57, part_cells=2)
    ...     t.to_frame({"amplitude_mm": 1}, ["regime", "mean_velocity_mm_s"]).round(3)
             regime  mean_velocity_mm_s
    0  forward-slip              16.263
    """
    if not isinstance(folder, str | os.PathLike):
        raise InputError(f"folder = {shown(folder)}: must be a path", hint='write it like "wide_sweep"')
    parting = Parting(part_cells=part_cells, workers=workers, scheduler=scheduler, resume=resume, force=force)
    request = request_of_call(scene_file, quantities)
    level = level_of(accuracy)
    check_switch("flight", flight)
    check_switch("coexistence", coexistence)
    grid = request.grid(level, flight=flight and level is Level.EXACT, coexistence=coexistence)
    usual = columns_of(grid.axes, drive=grid.drive)
    table = Table(usual if columns is None else chosen(columns, usual))
    plan = parting.plan(grid, table, request.name or "", request.own)
    path = part_folder(os.fspath(folder), "")
    with PartSet(path, "the same call with resume=True goes on") as files:
        files.finish(parting.carry_out(plan, files, sys.argv).text())
    return open_sweep(path)


def _check_number(name: str, value: Any, most: int, hint: str) -> None:
    if value is None:
        return
    whole = isinstance(value, int) and not isinstance(value, bool)
    if not (whole and 1 <= value <= most):
        raise InputError(f"{name} = {shown(value)}: must be a whole number from 1 to {most}", hint=hint)
