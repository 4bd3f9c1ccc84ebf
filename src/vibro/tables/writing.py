"""Sweeps as folders of Parquet files: begun, continued, replaced."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from vibro.errors import FileError, InputError, shown
from vibro.reals import shielded
from vibro.steady import check_switch
from vibro.sweeps.columns import Table, table_columns
from vibro.sweeps.whole import grid_of_call, request_of_call
from vibro.tables.files import cannot_write, is_regular, whole_file
from vibro.tables.plan import MANIFEST, SUCCESS, Plan, read_plan, shard_name
from vibro.tables.shard_files import read_success
from vibro.tables.shards import make_shards
from vibro.tables.stored import open_sweep

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from os import PathLike

    from vibro.tables.shards import Progress, Summary
    from vibro.tables.stored import StoredSweep

_ADDRESS: Final = re.compile(r"(tcp|tls|wss?)://\S+:[0-9]+")
_MOST_WORKERS: Final = 1024
_ANEW: Final = "choose another name, or replace it: --force (force=True)"
_OURS: Final = re.compile(rf"part-[0-9]{{6}}\.parquet|{MANIFEST}|{SUCCESS}")


def write_folder(
    folder: Path,
    plan: Plan,
    workers: int | str | None,
    argv: Sequence[str],
    *,
    force: bool = False,
    report: Callable[[Progress], None] = lambda progress: None,
) -> Summary:
    """Make what is missing of a sweep in a folder, which says in the end that it is whole.

    Parameters
    ----------
    folder : Path
        Of this sweep, begun or whole, or of nothing; it is created.
    plan : Plan
        The sweep.
    workers : int, str or None
        As of ``make_shards``.
    argv : sequence of str
        Arguments of the program, for the manifest.
    force : bool
        Whether another sweep in the folder is replaced.
    report : callable
        As of ``make_shards``.

    Raises
    ------
    FileError
        If the folder holds something else, or cannot be written.
    """
    if "\0" in str(folder):
        problem = f"folder = {shown(str(folder))}: no file has such a name"
        raise InputError(problem, hint="choose another name")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        there = sorted(path.name for path in folder.iterdir() if not path.name.startswith("."))
        foreign = [name for name in there if not _OURS.fullmatch(name)]
        if foreign and (MANIFEST not in there or any(name.endswith(".parquet") for name in foreign)):
            problem = f"{folder} holds something else: {', '.join(foreign[:3])}"
            raise FileError(problem, hint="choose another name")
        known = None
        try:
            if there:
                known = _known(folder, plan)
        except FileError:
            if not force:
                raise
            there = []
        if not there:
            _clear(folder)
            with whole_file(folder / MANIFEST) as path:
                path.write_text(plan.manifest(argv), encoding="utf-8")
        if known and all(is_regular(folder / shard_name(shard)) for shard in known.made):
            return known
        (folder / SUCCESS).unlink(missing_ok=True)  # until it is true again
        summary = make_shards(plan, folder.absolute(), workers, report)
        with whole_file(folder / SUCCESS) as path:
            path.write_text(summary.success(plan), encoding="utf-8")
    except OSError as exc:
        raise cannot_write(exc, folder) from exc
    return summary


def _known(folder: Path, plan: Plan) -> Summary | None:
    """Return what is known of this sweep in a folder if it was whole; that of another sweep is an error."""
    if not (folder / MANIFEST).is_file():
        raise FileError(f"{folder} has shards, but no {MANIFEST}", hint=_ANEW)
    there = read_plan(folder / MANIFEST)
    if there.fingerprint != plan.fingerprint:
        raise FileError(f"{folder} holds another sweep: {plan.differences(there)}", hint=_ANEW)
    return read_success(folder, plan)


def _clear(folder: Path) -> None:
    """Remove what vibro has written into a folder: first what says that it is whole."""
    ours = [path for path in folder.iterdir() if _OURS.fullmatch(path.name) and is_regular(path)]
    for path in sorted(ours, key=lambda path: (path.name != SUCCESS, path.name == MANIFEST)):
        path.unlink(missing_ok=True)


def checked_workers(workers: object) -> int | str | None:
    """Check a number of processes, or the address of a scheduler.

    Raises
    ------
    InputError
        If it is neither.
    """
    is_number = isinstance(workers, int) and not isinstance(workers, bool) and 1 <= workers <= _MOST_WORKERS
    is_address = isinstance(workers, str) and _ADDRESS.fullmatch(workers)
    if workers is None or is_number or is_address:
        return workers  # type: ignore[return-value]
    rule = f"must be a whole number from 1 to {_MOST_WORKERS}, or an address"
    raise InputError(f"workers = {shown(workers)}: {rule}", hint="write it like 4 or tcp://host:8786")


@shielded
def write_sweep(
    folder: str | PathLike[str],
    scene_file: str | PathLike[str] | None = None,
    *,
    columns: Sequence[str] | None = None,
    workers: int | str | None = None,
    force: bool = False,
    output: Literal["exact", "regimes"] = "exact",
    flight: bool = True,
    starts: int | None = None,
    **quantities: Any,
) -> StoredSweep:
    """Solve all combinations of several axes into a folder of Parquet files, which may exceed memory.

    A call that was interrupted goes on when it is made again.

    Parameters
    ----------
    folder : path
        The folder; it is created.
    scene_file, output, flight, starts, **quantities
        As for ``vibro.sweep``.
    columns : sequence of str, optional
        Names of columns, as for ``--columns`` of ``vibro map``; by default its standard columns.
    workers : int or str, optional
        Number of processes, or the address of a Dask scheduler, such as ``"tcp://host:8786"``; by default
        threads of this process. A script that uses processes needs the line
        ``if __name__ == "__main__":``. Workers of a cluster need the same versions of vibro, NumPy, SciPy and
        pyarrow on the same kind of system, and access to the folder under the same path.
    force : bool, optional
        Whether to replace another sweep that the folder contains.

    Returns
    -------
    StoredSweep
        The sweep, as from ``vibro.open_sweep``.

    Raises
    ------
    InputError
        If an input is wrong or missing; the message lists all problems.
    FileError
        If the folder cannot be written, or contains something else; if distributed is not installed, or no
        scheduler answers.

    Notes
    -----
    The files are the same to the byte for any number or kind of workers and any number of interruptions, on
    one kind of system and with the same versions of the libraries (tests/tables/test_shards.py).

    Examples
    --------
    >>> import tempfile, vibro
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     t = vibro.write_sweep(folder, amplitude_mm="0.5:1.5:3", frequency_hz=15, drive_angle_deg=20,
    ...                           static_friction=0.74, kinetic_friction=0.57)
    ...     t.to_frame({"amplitude_mm": 1}, ["regime", "mean_velocity_mm_s"]).round(3)
             regime  mean_velocity_mm_s
    0  forward-slip              16.263
    """
    if not isinstance(folder, str | os.PathLike):
        raise InputError(f"folder = {shown(folder)}: must be a path", hint='write it like "wide.parquet"')
    if not os.fspath(folder):
        raise InputError("folder is empty", hint='write it like "wide.parquet"')
    workers, path = checked_workers(workers), Path(folder)
    check_switch("force", force)
    request = request_of_call(scene_file, quantities, write_sweep, repr(os.fspath(folder)))
    grid = grid_of_call(request, output, flight=flight, starts=starts)
    table = Table(table_columns(grid, columns))
    write_folder(path, Plan.of(grid, table, request.name or "", request.own), workers, sys.argv, force=force)
    return open_sweep(path)
