"""``vibro report``: one page about a scene or the answer to a design question, to be read and printed."""

from __future__ import annotations

import shlex
import sys
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import typer  # typer reads the annotations

from vibro.cli.console import Console
from vibro.cli.design import design_record
from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import Options
from vibro.cli.outputs import PAGES, Outputs
from vibro.cli.table_options import MassOption, PitchOption, part_of, throughput_of
from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    Write = Callable[[str, Mapping[str, Any]], None]

__all__ = ["report_command"]


def report_command(
    context: typer.Context, options: Options, pitch: PitchOption = None, mass: MassOption = None
) -> int:
    """Write a report on one page, about a scene or the answer of vibro design, to read and to print.

    The page about a scene has the motion and speed of the part, a map, the next regimes, the sensitivity of
    the speed, the limits of the regime, three cycles of the motion and the assumptions; that about a design
    file has the designs and their guarantees. Without -o the page goes to stdout. It needs no other file and
    no network, and prints on A4. Install with pip install '.[report]' in the project's folder.
    """
    from vibro.files.descriptions import DESIGN_FILE
    from vibro.files.toml_files import kind_of, read_toml
    from vibro.reports.page import check_extra

    check_extra()
    console = Console(quiet=options.quiet)
    part = part_of(pitch, mass)
    if options.scene is not None and kind_of(read_toml(options.scene)) is DESIGN_FILE:
        if options.given or part:
            raise InputError(
                f"{options.scene} is {DESIGN_FILE.meaning}; it has no options of a scene",
                hint=_remedy(options.given, part),
            )
        return _report_design(options.scene, options, context.obj, console)
    return _report_scene(options, context.obj, part, console)


def _remedy(given: Iterable[str], part: Mapping[str, float]) -> str:
    """Raise InputError for options of a scene beside a design file, with the keys to use instead."""
    from vibro.quantities import QUANTITIES

    hints = []
    if names := ", ".join(QUANTITIES[name].options[0] for name in given):
        hints.append(
            f"leave out {names}: the file's [scene] says what is known, its [[drive]] what may be set"
        )
    if part:
        names = "--pitch and --mass" if len(part) > 1 else "--pitch"
        hints.append(
            f"leave out {names}: parts a minute are told of a scene, such as a setting of the answer"
        )
    return "\n".join(hints)


def _report_scene(options: Options, argv: Sequence[str], part: Mapping[str, float], console: Console) -> int:
    from vibro.cli.answer import make_grid
    from vibro.cli.outputs import scene_record
    from vibro.cli.request import question, request_of
    from vibro.core.codes import Status
    from vibro.quantities import STANDS_FOR
    from vibro.reports.page import page_html
    from vibro.reports.scene_page import SceneReport, scene_page
    from vibro.sweeps.columns import arrow_table, columns_of
    from vibro.sweeps.derived import WITH_ACCELERATION, WITH_EXPONENT, WITH_STROKE
    from vibro.sweeps.machines import check_operating
    from vibro.sweeps.request import RANGES
    from vibro.sweeps.run import sweep_blocks

    request = request_of(options, argv)
    question(request, options)
    swept = request_of(options, argv, reads_map=True, takes_axes=True, ranges=RANGES, must_vary=False)
    grid = make_grid(request)
    with _placed(request.name or "vibro-report", options, argv, console) as write:
        (block,) = sweep_blocks(grid)
        if grid.machine is not None:
            check_operating(grid.machine, block.values)
        given = frozenset(STANDS_FOR.get(name, name) for name in options.given) | request.own.keys()
        command = shlex.join(["vibro", *argv])
        with console.progress("drawing", None):
            html = page_html(scene_page(SceneReport(request, swept, given, part, grid, block, command)))
        more = (*throughput_of(part), WITH_STROKE, WITH_ACCELERATION, WITH_EXPONENT)
        columns = columns_of((), *more, drive=grid.drive, machine=grid.machine is not None)
        (result,) = arrow_table(columns, block).to_pylist()
        motion = {} if request.motion is None else {"motion": dict(request.motion.table)}
        write(html, {"scene": {**scene_record(request), **motion}, "part": dict(part), "result": result})
    return ExitCode.UNRESOLVED if block.cycle.status == Status.UNRESOLVED else ExitCode.DONE


def _report_design(source: Path, options: Options, argv: Sequence[str], console: Console) -> int:
    from vibro.inverse.designs import chosen_of, find_designs
    from vibro.inverse.reading import read_spec
    from vibro.reports.design_page import design_page
    from vibro.reports.page import page_html

    spec = read_spec(source)
    for doubt in spec.doubts():
        console.warn(doubt)
    with _placed(spec.name or "vibro-report", options, argv, console) as write:
        with console.progress("searching", None) as report:
            result = find_designs(spec, lambda done, total, what: report(done, what, total))
        with console.progress("drawing", None):
            record = design_record(source, result)
            page = design_page(
                spec, result, chosen_of(spec, result), record["spec"], shlex.join(["vibro", *argv])
            )
        write(page_html(page), record)
    return ExitCode.DONE if result.met else ExitCode.NOT_MET


@contextmanager
def _placed(name: str, options: Options, argv: Sequence[str], console: Console) -> Iterator[Write]:
    """Check the files before anything is computed, and give what writes a page and its record."""
    if not options.output or "-" in options.output:
        sys.stdout.reconfigure(encoding="utf-8")  # type: ignore[union-attr]
    told = replace(options, output=options.output or ["-"])
    reads = [options.scene]
    with Outputs(told, name, argv, console, forms=PAGES, pictures=(), reads=reads) as files:
        yield files.write_text
