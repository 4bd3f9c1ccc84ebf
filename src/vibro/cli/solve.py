"""``vibro solve``: what a part does in one scene, or in a few of them."""

from __future__ import annotations

from typing import Annotated, Final

from vibro.cli.options import (
    AllOption,
    Options,
    RegimesOnlyOption,
    option,
    rare,
    typed_names,
)
from vibro.cli.table_options import NEEDS_PART, ColumnsOption, MassOption, PitchOption, part_of, table_of
from vibro.core.codes import Output
from vibro.errors import InputError

_MOST_CELLS: Final = 50  # of lists: a screen; more are a map's
_NEEDS: Final = {**NEEDS_PART, **dict.fromkeys(("upright", "tipping_load_ratio"), "--stand-ratio 0.6")}


def solve_command(
    options: Options,
    speed: Annotated[
        str | None, option("speed", "Find the amplitudes, or the friction, for a speed [mm/s].", "X")
    ] = None,
    time: Annotated[str | None, option("time", "The same for the time over the length [s].", "X")] = None,
    every: AllOption = False,
    hopping: Annotated[bool, rare("hopping", "With --speed or --time: the part may hop.")] = False,
    regimes_only: RegimesOnlyOption = False,
    stand_ratio: Annotated[
        str | None,
        rare(
            "stand-ratio",
            "Half base over height of the centre of mass of a part, to tell whether it stays upright.",
            "X",
        ),
    ] = None,
    columns: ColumnsOption = None,
    pitch: PitchOption = None,
    mass: MassOption = None,
) -> int:
    """Solve a scene: regime, speed, time over the trough, and what begins next.

    A list, such as -A 1,1.5,2, or several files give a table. If an amplitude, a frequency or friction is
    left out, it tells where motions begin; with --speed or --time, which amplitude or friction it is.
    """
    from vibro.cli.answer import Run, answer_cells, answer_one
    from vibro.cli.request import request_of
    from vibro.cli.unknowns import begins, sought, target
    from vibro.quantities import QUANTITIES, RATES, STAND_RATIO, STANDS_FOR, checked_number
    from vibro.sweeps.columns import table_columns
    from vibro.sweeps.derived import (
        WITH_ACCELERATION,
        WITH_ARRIVAL,
        WITH_EXPONENT,
        WITH_MULTIPLIER,
        WITH_STROKE,
        standing,
        throughput,
    )
    from vibro.sweeps.weighed import weighed

    output = Output.REGIMES if regimes_only else Output.EXACT
    unused = typed_names(
        regimes_only=regimes_only, stand_ratio=stand_ratio, columns=columns, pitch=pitch, mass=mass,
    )  # fmt: skip
    if speed is not None or time is not None:
        return target(speed, time, options, unused, every=every, hopping=hopping)
    if hopping:
        raise InputError("--hopping needs --speed or --time", hint="add --speed 5m/min, or leave it out")
    if (name := sought(options)) and not unused:
        return begins(name, options, every=every)
    part = part_of(pitch, mass)
    extra = throughput(part)
    options, load = _with_filling(options)
    part |= load
    extra += weighed(load)
    if stand_ratio is not None:
        part[STAND_RATIO.column] = checked_number(stand_ratio, STAND_RATIO)
        extra += standing(part[STAND_RATIO.column])
    more = (*extra, WITH_STROKE, WITH_ACCELERATION, WITH_EXPONENT, WITH_MULTIPLIER)
    runs = []
    for own in [options.of(file) for file in options.files] or [options]:
        request = request_of(own, takes_axes=True)
        arrives = output is Output.EXACT and request.length is not None
        grid = request.grid(output, arrivals=arrives)
        table = table_of(grid, columns, extra, needed=_NEEDS, part=part)
        whole = (
            table_columns(grid, extra=(WITH_ARRIVAL, *more) if arrives else more)
            if columns is None
            else table.columns
        )
        runs.append(Run(request, grid, table, whole, columns is not None))
    if len(runs) == 1 and not runs[0].request.varying:
        return answer_one(runs[0], options, "vibro-solve", every=every)
    if (size := sum(run.grid.size for run in runs)) > _MOST_CELLS:
        axis = next(iter(runs[0].grid.axes.values()))
        unit = axis.unit if axis.name in RATES else ""
        option = QUANTITIES[STANDS_FOR.get(axis.name, axis.name)]
        fewer = option.typed(f"{axis.values[0]:g}{unit}:{axis.values[-1]:g}{unit}:10")
        raise InputError(
            f"{size} scenes: at most {_MOST_CELLS} are listed",
            hint=f"give fewer, such as {fewer}, or use vibro map",
        )
    return answer_cells(runs, options, "vibro-solve", every=every)


def _with_filling(options: Options) -> tuple[Options, dict[str, float]]:
    """Take a filling out of the quantities of a scene without a machine; return its mass and the trough's."""
    from vibro.files.scene_files import read_scene_file
    from vibro.quantities import QUANTITIES, TROUGH_MASS, checked_number

    trough = options.own.get(TROUGH_MASS.name)
    has_machine = any(read_scene_file(path).machine is not None for path in options.files)
    filling = None if has_machine else options.given.get("filling")
    if filling is None:
        if trough is not None:
            why = "the machine of the scene has one" if has_machine else "there is no filling"
            raise InputError(f"trough_mass={trough}: {why}", hint="leave it out, or add filling=2kg")
        return options, {}
    load = {QUANTITIES["filling"].column: checked_number(filling, QUANTITIES["filling"])}
    if trough is not None:
        load[TROUGH_MASS.column] = checked_number(trough, TROUGH_MASS)
    given = {name: text for name, text in options.given.items() if name != "filling"}
    return options.of(*options.files, given=given), load
