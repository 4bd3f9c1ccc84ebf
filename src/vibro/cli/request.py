"""What the options and the scene file ask for together."""

from __future__ import annotations

import shlex
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from vibro.errors import InputError, cut, shown
from vibro.files.scene_files import read_scene_file
from vibro.quantities import QUANTITIES, RATES, STANDS_FOR, Quantity, exact_number
from vibro.sweeps.request import amplitude_ends, gather
from vibro.sweeps.whole import Inputs

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from vibro.cli.console import Console
    from vibro.cli.options import Options
    from vibro.files.scene_files import SceneFile
    from vibro.sweeps.grid import Grid
    from vibro.sweeps.request import Request


class _CommandLine(NamedTuple):
    """How messages speak of options; ``argv`` are the arguments as typed, the command first."""

    argv: Sequence[str]
    gives: str = "the command line"

    @property
    def takes_one_value(self) -> tuple[str, str]:
        command, *options = self.argv
        if command == "solve":  # which takes lists, unless it finds what is left out
            target = [name for name in ("--speed", "--time") if any(o.startswith(name) for o in options)]
            which = f"vibro solve {target[0]} takes one value" if target else ""
            why = which or "vibro solve takes one value where a quantity is left out"
            return why, "ask for each by itself; decimals have a point"
        return f"vibro {command} takes one value", "vibro map takes axes; decimals have a point"

    def name(self, quantity: Quantity) -> str:
        return quantity.options[0] if quantity.is_option else quantity.typed()

    def example(self, values: Mapping[str, str], *, from_scratch: bool) -> str:
        typed = self.argv[:1] if from_scratch else self.argv
        wanted = (QUANTITIES[name].typed(value) for name, value in values.items())
        return " ".join(["vibro", shlex.join(typed), *wanted])


def whole_number(option: str, text: str, allowed: range) -> int:
    """Read the whole number that an option of a run takes."""
    hint = "write a whole number, such as 3"
    try:
        number = exact_number(text, Quantity(option))
    except InputError as exc:
        raise InputError(*exc.problems, hint=hint) from None
    if number.denominator != 1:
        raise InputError(f"{option} = {cut(text)}: not a whole number", hint=hint)
    if int(number) not in allowed:
        raise InputError(f"{option} {shown(int(number))}: must be in [{allowed[0]}, {allowed[-1]}]")
    return int(number)


def request_of(options: Options, found: Collection[str] = (), **wanted: Any) -> Request:
    """Read a request as ``read_request`` does, and warn of unusual values, as ``question`` does."""
    request = read_request(options, **wanted)
    question(request, options.console, found)
    return request


def read_request(
    options: Options,
    *,
    without_file: SceneFile | None = None,
    without_machine: str = "",
    measured: Collection[str] = (),
    varies: bool = False,
    **wanted: Any,
) -> Request:
    """Read the options and the scene file that they name, and check them together.

    Parameters
    ----------
    options : Options
        The shared options.
    without_file : SceneFile, optional
        In place of a scene file that is not given.
    without_machine : str
        Why the command takes no machine; empty if it does.
    measured : collection of str
        Quantities that are measured: those of the file do not count, nor do its motion and machine.
    varies : bool
        Whether a quantity has to vary.
    **wanted
        As for ``gather``.

    Raises
    ------
    InputError
        It names everything that is wrong or missing.
    FileError
        If the scene file cannot be read.
    """
    file = read_scene_file(options.scene) if options.scene else without_file
    if measured and file is not None:
        kept = {name: spec for name, spec in file.scene.items() if STANDS_FOR.get(name, name) not in measured}
        file = replace(file, scene=kept, motion=None, machine=None)
    if without_machine and file is not None and file.machine is not None:
        raise InputError(
            f"{options.scene}: [machine]: {without_machine}",
            hint="vibro solve tells the amplitude at its operating point: give that in place of [machine]",
        )
    request = gather(options.given, file, _CommandLine(options.argv), pack=options.pack, **wanted)
    if varies and not request.varying:
        example = QUANTITIES[request.drive[0]].typed("0.1:3:200")
        raise InputError("nothing varies", hint=f"give an axis, for example {example}")
    for name, text in options.given.items():
        # of a decimal comma, and of an rms value
        if (
            ("," in text or "rms" in text.casefold())
            and name in request.specs
            and not request.specs[name].varies
        ):
            quantity = QUANTITIES[name]
            options.console.echo(f"{quantity.label}: {quantity.text(request.specs[name].value)}")
    for name in RATES.keys() & request.specs.keys() - {*request.varying}:
        frequencies = [float(request.specs["frequency"].values[i]) for i in (-1, 0)]
        found, at = (
            " ... ".join(dict.fromkeys(f"{x:.4g}" for x in ends))
            for ends in (amplitude_ends(request.specs), frequencies)
        )
        given = f"{request.specs[name].value:.6g} {QUANTITIES[name].unit}"
        options.console.echo(f"amplitude {given} ({found} mm at {at} Hz)")
    return request


def inputs_of(options: Options) -> Inputs:
    """Read the scene file that the options name, for a question that decides itself what must be given."""
    file = read_scene_file(options.scene) if options.scene else None
    return Inputs(options.given, file, _CommandLine(options.argv), options.pack)


def warn_of_machine(grid: Grid, console: Console) -> None:
    """Warn of operating points of a machine, if a grid has one."""
    from vibro.sweeps.machines import points_of

    if grid.machine is not None:
        axes = [*grid.given_axes.values()]
        named = ([f"{x:g}" for x in axes[0].values], axes[0].unit) if len(axes) == 1 else ()
        for text in points_of(grid.machine, grid.values()).remarks(*named):
            console.warn(text)


def question(request: Request, console: Console, found: Collection[str]) -> None:
    """Warn of unusual values, which are probably in wrong units, but for quantities that were found."""
    for doubt in request.doubts(found):
        console.warn(doubt)
