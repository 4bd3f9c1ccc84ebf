"""``vibro solve``: one scene's report."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer  # typer reads the annotations

from vibro.cli.options import (
    CoexistOption,
    Options,
    RegimesOnlyOption,
    refuse_without_flight,
)
from vibro.cli.table_options import (
    NEEDS_PART,
    ColumnsOption,
    MassOption,
    PitchOption,
    part_of,
    refuse_without_table,
    table_of,
    throughput_of,
)
from vibro.core.codes import Output
from vibro.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from vibro.sweeps.grid import Grid
    from vibro.sweeps.one_scene import OneScene

__all__ = ["solve_command"]

_NEEDS: Final = {
    **NEEDS_PART,
    **dict.fromkeys(("upright", "tipping_load_ratio"), "--stand-ratio 0.6"),
}


def solve_command(
    context: typer.Context,
    options: Options,
    regimes_only: RegimesOnlyOption = False,
    coexist: CoexistOption = False,
    stand_ratio: Annotated[
        str | None,
        typer.Option(
            "--stand-ratio",
            metavar="VALUE",
            help="Half base over height of the centre of mass of a part, to print whether it stays upright."
            " The half base is the distance along the trough from the centre of mass to the nearer edge.",
            show_default=False,
        ),
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option(
            "--speed",
            metavar="SPEED",
            help="List the amplitudes that convey at least at this speed [mm/s], such as 5m/min; the exit"
            " code is 4 if there are none. Amplitudes of an ellipse keep their proportion; of other motions"
            " the scales are listed.",
            show_default=False,
        ),
    ] = None,
    hopping: Annotated[
        bool,
        typer.Option("--hopping", help="With --speed: the body may hop, up to a throw number of 10."),
    ] = False,
    columns: ColumnsOption = None,
    pitch: PitchOption = None,
    mass: MassOption = None,
    trough_mass: Annotated[
        str | None,
        typer.Option(
            "--trough-mass",
            metavar="MASS",
            help="Mass of the empty trough and of what moves with it [kg]; with --filling and without a"
            " machine, to print up to which filling the trough moves as given.",
            show_default=False,
        ),
    ] = None,
) -> int:
    """Report one scene: its regime, speed, where the next regimes begin, and the phases of its cycle.

    -o writes a table of one row; --columns chooses its columns, and those of --json.
    With --speed, and without an amplitude, the amplitudes, or the scales of a motion, that reach the speed
    are listed, with --hopping also those at which the body hops. With --filling the force of that mass on the
    trough is printed, for a trough that moves as given; describe a machine in the table [machine] instead.
    """
    from vibro.cli.answer import answer_one, make_grid
    from vibro.cli.request import question, request_of
    from vibro.quantities import STAND_RATIO, checked_number
    from vibro.sweeps.columns import columns_of
    from vibro.sweeps.derived import (
        WITH_ACCELERATION,
        WITH_EXPONENT,
        WITH_MULTIPLIER,
        WITH_STROKE,
        standing,
    )
    from vibro.sweeps.weighed import weighed

    output = Output.REGIMES if regimes_only else Output.EXACT
    if coexist:
        refuse_without_flight("--coexist", output)
    if speed is not None:
        others = {
            "-o": bool(options.output),
            "--regimes-only": output is not Output.EXACT,
            "--coexist": coexist,
            "--stand-ratio": stand_ratio is not None,
            "--columns": columns is not None,
            "--pitch": pitch is not None,
            "--mass": mass is not None,
            "--filling": "filling" in options.given,
            "--trough-mass": trough_mass is not None,
        }
        refused = [name for name, given in others.items() if given]
        return _amplitudes(speed, options, context.obj, refused, hopping=hopping)
    if hopping:
        raise InputError("--hopping needs --speed", hint="add --speed 5m/min, or leave it out")
    part = part_of(pitch, mass)
    extra = throughput_of(part)
    options, load = _with_filling(options, trough_mass)
    part |= load
    extra += weighed(load)
    if stand_ratio is not None:
        part[STAND_RATIO.column] = checked_number(stand_ratio, STAND_RATIO)
        extra += standing(part[STAND_RATIO.column])
    refuse_without_table(options, columns)
    request = request_of(options, context.obj)
    question(request, options)
    grid = make_grid(request, output=output, coexistence=coexist)
    described: dict[str, Any] = {
        "drive": grid.drive, "made_with": grid.made_with, "machine": grid.machine is not None,
    }  # fmt: skip
    usual = columns_of((), *extra, **described)
    table = table_of(usual, columns, needed=_NEEDS, has_length=grid.length is not None, part=part)
    answer = table
    if columns is None:
        more = (WITH_STROKE, WITH_ACCELERATION, WITH_EXPONENT, WITH_MULTIPLIER)
        every = columns_of((), *extra, *more, **described)
        answer = replace(table, columns=every)
    report = partial(_report, grid=grid, part=part)
    return answer_one(grid, table, options, context.obj, request.name or "vibro-solve", report, answer)


def _with_filling(options: Options, trough_mass: str | None) -> tuple[Options, dict[str, float]]:
    """Take a filling out of the quantities of a scene without a machine; return its mass and the trough's."""
    from vibro.files.scene_files import read_scene_file
    from vibro.quantities import QUANTITIES, TROUGH_MASS, checked_number

    if options.scene is not None and read_scene_file(options.scene).machine is not None:
        if trough_mass is not None:
            raise InputError("--trough-mass: the machine of the scene has one", hint="leave it out")
        return options, {}
    given = dict(options.given)
    filling = given.pop("filling", None)
    if filling is None:
        if trough_mass is not None:
            raise InputError("--trough-mass: there is no filling", hint="add --filling 2kg")
        return options, {}
    load = {QUANTITIES["filling"].column: checked_number(filling, QUANTITIES["filling"])}
    if trough_mass is not None:
        load[TROUGH_MASS.column] = checked_number(trough_mass, TROUGH_MASS)
    return replace(options, given=given), load


def _amplitudes(
    speed: str, options: Options, argv: Sequence[str], others: Sequence[str], *, hopping: bool
) -> int:
    """List the amplitudes that reach a speed."""
    from vibro.cli.amplitudes import list_amplitudes

    if others:
        raise InputError(
            f"--speed lists amplitudes: {', '.join(others)} cannot be used with it", hint="leave it out"
        )
    return list_amplitudes(speed, options, argv, hopping=hopping)


def _upright(one: OneScene, stand_ratio: float) -> str:
    """Say whether a part keeps its base on the trough, and from which drive on it does not."""
    from vibro.limits import stays_upright, tipping_load
    from vibro.sweeps.one_scene import number
    from vibro.waveforms import PiecewiseMotion

    load = float(tipping_load(one.scene, stand_ratio))
    answer = int(stays_upright(one.scene, stand_ratio))
    if answer < 0:
        why = "the body hops, and may land on an edge" if one.hops else "the body cannot rest on the trough"
        return f"unknown: {why}"
    if math.isinf(load):
        return "yes: static friction is at most the stand ratio"
    if not load:
        return "no: an edge lifts under any drive"
    told, edge = ("yes", "an edge would lift") if answer else ("no", "an edge lifts")
    ratio = float(one.scene.load) / load
    if not 0.0 < ratio < math.inf:  # beyond the range of doubles
        return told
    which = f" ({one.all_amplitudes})" if one.all_amplitudes else " stroke" * (one.size == "stroke")
    beginning = f"{told}: {edge} above {one.amplitudes(ratio)}{which}"
    if not isinstance(one.scene.motion, PiecewiseMotion):  # whose accelerations do not depend on it
        beginning += f" or {number(float(one.scene.frequency) / math.sqrt(ratio), 'Hz')}"
    return f"{beginning} (load now / then {number(ratio)})"


def _report(one: OneScene, grid: Grid, part: Mapping[str, float]) -> str:
    from vibro.cli.report import aligned
    from vibro.quantities import STAND_RATIO
    from vibro.sweeps.one_scene import beginnings, facts_of, phase_rows, throughput_text
    from vibro.sweeps.weighed import weighed_facts

    facts = facts_of(one, grid)
    if told := throughput_text(one, part):
        facts.append(("throughput", told))
    if STAND_RATIO.column in part:
        facts.append(("upright", _upright(one, part[STAND_RATIO.column])))
    facts += weighed_facts(one, part)
    tables = [rows for rows in (beginnings(one), phase_rows(one)) if rows]
    return "\n\n".join([aligned(facts, right=False), *map(aligned, tables)])
