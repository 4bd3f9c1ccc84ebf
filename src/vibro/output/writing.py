"""Sweeps written in shards, from Python and for the command line."""

from __future__ import annotations

import os
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, overload

from vibro.core.codes import Output
from vibro.errors import FileError, InputError, cut, shown
from vibro.output.plan import Plan, check_arrow, read_plan
from vibro.output.shard_folder import MANIFEST, SUCCESS, ShardFolder
from vibro.output.shards import Job, Progress, check_workers, make_shards
from vibro.output.stored import open_sweep
from vibro.output.workers import workers_of
from vibro.reals import shielded
from vibro.steady import check_switch, output_of
from vibro.sweeps.columns import Table, chosen, columns_of
from vibro.sweeps.whole import request_of_call

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from os import PathLike

    from vibro.output.shards import Summary
    from vibro.output.stored import StoredSweep
    from vibro.sweeps.grid import Grid

__all__ = ["Sharding", "shard_folder", "write_sweep"]

_ADDRESS: Final = re.compile(r"(tcp|tls|wss?)://\S+:[0-9]+")
_MOST_WORKERS: Final = 1024
_MOST_CELLS: Final = 100_000_000  # [cells] of a shard: more would cost hours of work at a fault
_RANGE: Final = re.compile(r"([0-9]{1,7}):([0-9]{1,7})")
_ANEW: Final = "ask for the same, choose another name, or start anew with force=True"


@dataclass(frozen=True, kw_only=True)
class Sharding:
    """How a sweep is written in shards.

    Parameters
    ----------
    shard_cells : int, optional
        Cells of each shard; the usual number, or as many as existing shards have.
    shards : str, optional
        The shards to make, such as ``"0:40"`` for the first 40; without, all. Others may make other ranges at
        the same time. The folder is finished by a run without a range.
    workers : int, optional
        Processes that make the shards; without, threads of this one.
    scheduler : str, optional
        Address of a Dask cluster that makes them.
    resume, force : bool
        Whether to continue the sweep in the folder, or to replace it.

    Raises
    ------
    InputError
        If one of them is out of range, or they exclude each other.
    """

    shard_cells: int | None = None
    shards: str | None = None
    workers: int | None = None
    scheduler: str | None = None
    resume: bool = False
    force: bool = False

    def __post_init__(self) -> None:
        _check_number("shard_cells", self.shard_cells, _MOST_CELLS, "1000000 is usual")
        _check_number("workers", self.workers, _MOST_WORKERS, "one a core is usual")
        check_switch("resume", self.resume)
        check_switch("force", self.force)
        if self.workers is not None and self.scheduler is not None:
            raise InputError(
                "workers= and scheduler= are both given",
                hint="leave one of them out",
            )
        if self.force and (self.resume or self.shards is not None):
            other = "resume" if self.resume else "shards"
            raise InputError(
                f"{other}= and force=True are both given: one continues the sweep, the other starts anew",
                hint="leave one of them out",
            )
        if self.scheduler is not None and not _ADDRESS.fullmatch(str(self.scheduler)):
            raise InputError(
                f"scheduler={_text(self.scheduler)}: is no address",
                hint='write it like scheduler="tcp://host:8786"',
            )

    @property
    def goes_on(self) -> bool:
        """Whether a sweep that is there is continued."""
        return self.resume or self.shards is not None

    def plan(
        self, grid: Grid, table: Table, name: str, own: Mapping[str, float], pictures: Sequence[str] = ()
    ) -> Plan:
        """Make the plan of a sweep; pictures are drawn by the run that finishes it."""
        check_arrow()
        return Plan.of(grid, table, self.shard_cells, name, own, pictures if self.shards is None else ())

    def folder(self, folder: Path, how_to_go_on: str) -> ShardFolder:
        """Return the folder, to be entered."""
        return ShardFolder(folder, how_to_go_on, self.shards or "")

    def agree(self, folder: ShardFolder, plan: Plan) -> tuple[Plan, Sequence[int]]:
        """Plan the files of a folder, without changing it.

        Parameters
        ----------
        folder : ShardFolder
            Entered.
        plan : Plan
            The requested plan.

        Returns
        -------
        Plan
            The plan, with the size of existing shards unless another one is requested.
        sequence of int
            The shards to be made or checked.

        Raises
        ------
        FileError
            If the folder holds something else; of another sweep it names the differences.
        InputError
            If there are no such shards.
        """
        there = _plan_in(folder)
        folder.check_free(there.files if there else (), plan.pictures)
        if there and self.goes_on:
            plan = self._continued(folder, plan, there)
        elif there and not self.force:
            raise _exists(folder)
        return plan, self._wanted(plan)

    def carry_out(
        self,
        plan: Plan,
        shards: Sequence[int],
        folder: ShardFolder,
        argv: Sequence[str],
        report: Callable[[Progress], None] = lambda progress: None,
        tell: Callable[[str], None] = lambda text: None,
    ) -> tuple[Summary, str]:
        """Make the shards that ``agree`` has found, in a folder that is entered.

        Returns
        -------
        Summary
            Of these shards.
        str
            The manifest, for ``Summary.finish``.
        """
        with workers_of(len(shards), self.workers, self.scheduler, tell) as workers:
            check_workers(workers, Job(plan, folder.hidden, workers.threads))
            if self.force and (there := _plan_in(folder)):
                folder.clear(there.files)
            manifest = self._manifest(plan, folder, argv)
            return make_shards(plan, folder, workers, shards, report), manifest

    def _manifest(self, plan: Plan, folder: ShardFolder, argv: Sequence[str]) -> str:
        """Write the manifest, if it is not there; one that another run has just written must be the same."""
        if folder.read(MANIFEST) is None:
            try:
                folder.write(MANIFEST, plan.manifest(argv), replace=False)
            except FileError:
                if folder.read(MANIFEST) is None:
                    raise
        manifest = folder.read(MANIFEST) or ""
        there = read_plan(manifest, folder.shown / MANIFEST)
        if there.fingerprint != plan.fingerprint:
            raise FileError(f"another run has begun another sweep in {folder.shown}", hint=_ANEW)
        if not set(plan.pictures) <= set(there.pictures):
            manifest = there.manifest(there.content["argv"], plan.pictures)
            folder.write(MANIFEST, manifest)
        return manifest

    def _continued(self, folder: ShardFolder, plan: Plan, there: Plan) -> Plan:
        if self.shard_cells is None:
            plan = Plan.of(plan.grid, plan.table, there.shard_cells, plan.name, plan.own, plan.pictures)
        differences = plan.differences(there)
        if differences:
            raise FileError(f"{folder.shown} holds another sweep: {'; '.join(differences)}", hint=_ANEW)
        return plan

    def _wanted(self, plan: Plan) -> Sequence[int]:
        if self.shards is None:
            return range(plan.shards)
        match = _RANGE.fullmatch(str(self.shards))
        first, stop = (int(match[1]), int(match[2])) if match else (0, 0)
        if not first < stop <= plan.shards:
            raise InputError(
                f"shards={_text(self.shards)}: must be first:stop, of {plan.shards} shards",
                hint=f'write it like shards="0:{-(-plan.shards // 2)}"',
            )
        return range(first, stop)


def _plan_in(folder: ShardFolder) -> Plan | None:
    """Read the manifest of a folder, if there is one."""
    text = folder.read(MANIFEST)
    return None if text is None else read_plan(text, folder.shown / MANIFEST)


def _exists(folder: ShardFolder) -> FileError:
    if folder.read(SUCCESS) is not None:
        return FileError(
            f"{folder.shown} holds a sweep already",
            hint="choose another name, or start anew with force=True; vibro.open_sweep reads what is there",
        )
    hint = "resume=True goes on with it, force=True starts anew"
    return FileError(f"{folder.shown} holds a sweep that is not finished", hint=hint)


def shard_folder(folder: str) -> Path:
    """Return the folder of a sweep in shards.

    Raises
    ------
    InputError
        If it can be no folder's name.
    """
    if not folder or "\0" in folder or folder == "-":
        raise InputError(
            f"folder={_text(folder)}: shards go into a folder", hint='write it like folder="out/wide"'
        )
    path = Path(folder)
    if path.suffix.casefold() in (".csv", ".parquet", ".json", ".xlsx"):
        raise InputError(
            f"folder={_text(folder)}: shards go into a folder",
            hint=f"write it like folder={_text(path.with_suffix(''))}",
        )
    return path


@overload
def write_sweep(
    folder: str | PathLike[str],
    scene_file: str | PathLike[str] | None = None,
    *,
    shards: None = None,
    **more: Any,
) -> StoredSweep: ...
@overload
def write_sweep(
    folder: str | PathLike[str], scene_file: str | PathLike[str] | None = None, *, shards: str, **more: Any
) -> None: ...
@shielded
def write_sweep(
    folder: str | PathLike[str],
    scene_file: str | PathLike[str] | None = None,
    *,
    columns: Sequence[str] | None = None,
    shard_cells: int | None = None,
    shards: str | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    resume: bool = False,
    force: bool = False,
    output: Literal["exact", "regimes"] = "exact",
    flight: bool = True,
    coexistence: bool = False,
    **quantities: Any,
) -> StoredSweep | None:
    """Solve all combinations of several axes into a folder of Parquet files, which may exceed memory.

    Parameters
    ----------
    folder : path
        The folder; it is created.
    scene_file, output, flight, coexistence, **quantities
        As for ``vibro.sweep``.
    columns : sequence of str, optional
        Names of columns, as for ``--columns`` of ``vibro map``; by default its standard columns.
    shard_cells : int, optional
        Number of cells per file, a shard. By default 1e6, or 20 000 with bouncing bodies or
        ``coexistence=True``, or that of the existing files.
    shards : str, optional
        Range of shards to make, such as ``"0:40"`` for the first 40, so that the jobs of a batch system can
        make different ranges at the same time. A last call with ``resume=True`` and without ``shards``
        finishes the folder.
    workers : int, optional
        Number of processes; by default threads of this process. A script that uses processes needs the
        line ``if __name__ == "__main__":``.
    scheduler : str, optional
        Address of a Dask cluster, such as ``"tcp://host:8786"``. Its workers need the same versions of vibro,
        NumPy, SciPy and pyarrow, and access to the folder under the same path.
    resume : bool, optional
        Whether to continue an interrupted sweep with the same arguments.
    force : bool, optional
        Whether to replace a sweep that the folder contains.

    Returns
    -------
    StoredSweep or None
        The sweep, as from ``vibro.open_sweep``; None with ``shards``.

    Raises
    ------
    InputError
        If an input is wrong or missing; the message lists all problems.
    FileError
        If the folder cannot be written, contains something else, or is in use by another run; if pyarrow is
        not installed, or distributed with ``scheduler``.

    Notes
    -----
    The files are the same to the byte for any number or kind of workers and any number of interruptions, on
    one kind of processor and with the same versions of the libraries (tests/output/test_shards.py).

    Examples
    --------
    >>> import tempfile, vibro
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     t = vibro.write_sweep(folder, amplitude_mm="0.5:1.5:3", frequency_hz=15, drive_angle_deg=20,
    ...                           static_friction=0.74, kinetic_friction=0.57, shard_cells=2)
    ...     t.to_frame({"amplitude_mm": 1}, ["regime", "mean_velocity_mm_s"]).round(3)
             regime  mean_velocity_mm_s
    0  forward-slip              16.263
    """
    if not isinstance(folder, str | os.PathLike):
        raise InputError(f"folder = {shown(folder)}: must be a path", hint='write it like "wide_sweep"')
    how = Sharding(
        shard_cells=shard_cells,
        shards=shards,
        workers=workers,
        scheduler=scheduler,
        resume=resume,
        force=force,
    )
    path = shard_folder(os.fspath(folder))
    request = request_of_call(scene_file, quantities, write_sweep, repr(os.fspath(folder)))
    kept = output_of(output)
    check_switch("flight", flight)
    check_switch("coexistence", coexistence)
    grid = request.grid(kept, flight=flight and kept is Output.EXACT, coexistence=coexistence)
    usual = columns_of(
        grid.axes, drive=grid.drive, made_with=grid.made_with, machine=grid.machine is not None
    )
    table = Table(usual if columns is None else chosen(columns, usual))
    plan = how.plan(grid, table, request.name or "", request.own)
    with how.folder(path, "the same call with resume=True goes on") as files:
        plan, wanted = how.agree(files, plan)
        summary, manifest = how.carry_out(plan, wanted, files, sys.argv)
        if shards is not None:
            return None
        summary.finish(files, manifest)
    return open_sweep(path)


def _check_number(name: str, value: Any, most: int, hint: str) -> None:
    if value is None:
        return
    whole = isinstance(value, int) and not isinstance(value, bool)
    if not (whole and 1 <= value <= most):
        raise InputError(f"{name}={shown(value)}: must be a whole number from 1 to {most}", hint=hint)


def _text(value: object) -> str:
    return f'"{cut(str(value))}"'
