"""From a checked request to its answer: one scene, or a few of them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vibro.answers.answer import Answer
from vibro.answers.scene import OneScene, cells_answer, scene_answer
from vibro.cli.exit_codes import ExitCode
from vibro.cli.forms import TABLES
from vibro.cli.outputs import Outputs
from vibro.cli.request import warn_of_machine
from vibro.cli.sweeps import conclude, write_sweep
from vibro.core.codes import Output, Status
from vibro.errors import InputError
from vibro.files.csv_tables import column_of
from vibro.quantities import STAND_RATIO
from vibro.sweeps.derived import standing
from vibro.sweeps.run import sweep_blocks
from vibro.sweeps.tally import Tally

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from vibro.cli.options import Options
    from vibro.results.sweep import Block, Column
    from vibro.sweeps.columns import Table
    from vibro.sweeps.grid import Grid
    from vibro.sweeps.request import Request


@dataclass(frozen=True)
class Run:
    """A request to solve.

    Attributes
    ----------
    request : Request
        It.
    grid : Grid
        Its cells.
    table : Table
        What files hold of it.
    columns : sequence of Column
        What JSON holds of a cell.
    is_chosen : bool
        Whether somebody has chosen these: JSON then has nothing else, and there is no text.
    """

    request: Request
    grid: Grid
    table: Table
    columns: Sequence[Column]
    is_chosen: bool = False

    def refuse_text(self, options: Options) -> None:
        """Refuse chosen columns where nothing is written that has them."""
        if self.is_chosen and not options.json and not options.output:
            raise InputError("--columns: the answer is no table", hint="add --json, -o - or -o NAME.csv")

    def records(self, block: Block) -> list[dict[str, Any]]:
        """Return cells as JSON has them."""
        from vibro.sweeps.columns import arrow_table

        found: list[dict[str, Any]] = arrow_table(self.columns, block).to_pylist()
        return found


def answer_one(
    run: Run,
    options: Options,
    name: str,
    make: Callable[[OneScene, dict[str, Any]], Answer] | None = None,
    *,
    every: bool = False,
) -> int:
    """Solve one scene and print its answer; write its row and its page if the options name an output.

    Parameters
    ----------
    run : Run
        Of a single cell.
    options : Options
        What to print and where to write.
    name : str
        The files' name where the options name a folder.
    make : callable, optional
        Makes another answer than that of ``vibro solve``, from the scene and its record.
    every : bool
        Whether all that is known is printed.

    Returns
    -------
    int
        The exit code.

    Raises
    ------
    InputError, FileError
        If the files cannot be written.
    """
    grid = run.grid
    run.refuse_text(options)
    forms = TABLES if make is None else TABLES[:-1]
    outputs = Outputs(options, run.request.name or name, forms=forms, pictures=())
    if grid.machine is not None:
        from vibro.sweeps.machines import check_operating  # late: few scenes have a machine

        check_operating(grid.machine, grid.values())
    warn_of_machine(grid, options.console)
    blocks: list[Block] = []

    def answer(*, whole: bool, recorded: bool) -> Answer:
        one = OneScene(blocks[0])
        record = run.records(blocks[0])[0] if recorded else {}
        if run.is_chosen and recorded:
            return Answer((), record=record)
        if make is not None:
            return make(one, record)
        title = run.request.name or "Scene"
        assumes = run.request.assumes_plastic
        return scene_answer(
            one, grid, run.table.part, record, every=whole, assumes_plastic=assumes, title=title
        )

    def page(_: Any) -> str:
        from vibro.answers.scene_pictures import scene_pictures

        pictures = scene_pictures(run.request, grid, OneScene(blocks[0]))
        return outputs.page(answer(whole=True, recorded=False), pictures)

    if options.output:
        tally = write_sweep(
            grid, run.table, outputs, look=blocks.append,
            more=lambda: answer(whole=True, recorded=True).content(), page=page,
        )  # fmt: skip
        conclude(tally, grid, options.console)
    else:
        blocks += sweep_blocks(grid)
    if not outputs.takes_stdout:
        outputs.print_answer(answer(whole=every or options.json, recorded=options.json), every=every)
    return ExitCode.UNRESOLVED if _is_unknown(run, blocks[0], exactly=make is not None) else ExitCode.DONE


def _is_unknown(run: Run, block: Block, *, exactly: bool) -> bool:
    """Whether the one value that was asked for is unknown: speed, time from rest, whether a part stands."""
    status, ratio = Status(block.cycle.status.item()), run.table.part.get(STAND_RATIO.column)
    if status is Status.UNRESOLVED or (exactly and block.arrival is not None and np.isnan(block.arrival)):
        return True
    if ratio is not None and standing(ratio)[0].values(block).item() < 0:
        return True
    # that a part gains speed every cycle is an answer
    return run.grid.output is Output.EXACT and not status.answered and status is not Status.RUNAWAY


def answer_cells(runs: Sequence[Run], options: Options, name: str, *, every: bool) -> int:
    """Solve a few scenes and print a line for each; write their table if the options name an output.

    Parameters are those of ``answer_one``.
    """
    runs[0].refuse_text(options)
    cells: list[dict[str, Any]] = []
    unresolved = False
    names = options.names or ["scene"]
    for file, run in zip(names, runs, strict=True):
        warn_of_machine(run.grid, options.console)
        own = {"scene": file} if len(runs) > 1 else {}
        for block in sweep_blocks(run.grid):
            unresolved |= bool((block.cycle.status == Status.UNRESOLVED).any())
            cells += [{**own, **record} for record in run.records(block)]
    whole = not runs[0].is_chosen
    given = dict(zip(names, (run.request.given_values for run in runs), strict=True))
    answer = cells_answer(cells, [*runs[0].grid.given_axes], given) if whole else Answer(())
    forms = TABLES if len(runs) == 1 else tuple(form for form in TABLES if form != "xlsx")
    outputs = Outputs(options, name, forms=forms, pictures=())

    def page(_: Any) -> str:
        return outputs.page(answer)

    if options.output and len(runs) == 1:
        write_sweep(runs[0].grid, runs[0].table, outputs, more=lambda: {"cells": cells}, page=page)
    elif options.output:
        keys = dict.fromkeys(key for cell in cells for key in cell)
        table = {key: column_of([cell.get(key) for cell in cells]) for key in keys}
        with outputs:
            outputs.write(lambda: {"": table}, dict, {"cells": cells}, {"html": page})
    if options.json:
        print(json.dumps(cells, indent=2, allow_nan=False))
    elif whole and not outputs.takes_stdout:
        print(answer.text(every=every))
    return ExitCode.UNRESOLVED if unresolved else ExitCode.DONE


def answer_sweep(run: Run, options: Options, name: str) -> int:
    """Solve a grid and print its table, as CSV or as JSON; write files if the options name an output.

    Parameters are those of ``answer_one``.
    """
    console = options.console
    if options.output or not options.json:
        outputs = Outputs(options, name, forms=TABLES[:-1], pictures=(), default="-")
        tally = write_sweep(run.grid, run.table, outputs)
        outputs.print_record()
        return conclude(tally, run.grid, console)
    tally = Tally()
    between = "[\n"
    for block in sweep_blocks(run.grid):
        tally.add(block)
        for cell in run.records(block):
            print(between, json.dumps(cell, allow_nan=False), sep="", end="")
            between = ",\n"
    print("\n]")
    return conclude(tally, run.grid, console)
