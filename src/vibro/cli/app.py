"""The command ``vibro``: its commands, and how every run ends."""

from __future__ import annotations

import gc
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Final, NoReturn

import typer
from typer.core import TyperGroup

from vibro.cli.accuracy import accuracy_command
from vibro.cli.console import (
    open_closed_streams,
    print_error,
    print_unexpected,
    silence,
    tell_traceback,
    tolerate_any_encoding,
)
from vibro.cli.design import design_command
from vibro.cli.drive import drive_command
from vibro.cli.exit_codes import ExitCode
from vibro.cli.explore import explore_command
from vibro.cli.forms import HISTORIES, MAPS, TABLES
from vibro.cli.friction import friction_command
from vibro.cli.map import map_command
from vibro.cli.measure import FORMS, measure_command
from vibro.cli.options import IN_ITS_UNIT, SHOW_VERSION, option, shares_options
from vibro.cli.schema import schema_command
from vibro.cli.simulate import STARTS, simulate_command
from vibro.cli.solve import solve_command
from vibro.cli.traverse_time import traverse_time_command
from vibro.errors import FileError, InputError, VibroError
from vibro.interrupts import end_on_signals, ignore_signals
from vibro.quantities import RATES, TROUGH_MASS, find_quantity

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

_OBJECTS = 100_000  # made before garbage is collected


class _Made(Mapping[str, Any]):
    """The commands by their names, each made when it is asked for: to read the options of all takes long."""

    def __getitem__(self, name: str) -> Any:
        run, shared = _COMMANDS[name]
        alone = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
        alone.command(name)(run if shared is None else shares_options(run, **shared))
        return typer.main.get_command(alone)

    def __iter__(self) -> Iterator[str]:
        return iter(_COMMANDS)

    def __len__(self) -> int:
        return len(_COMMANDS)


class _Commands(TyperGroup):
    """The group of commands; it turns whatever a run raises into a message and an exit code."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands = _Made()  # type: ignore[assignment]  # nobody adds to them

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        windows_expand_args: bool = True,
        **extra: Any,
    ) -> NoReturn:
        argv = list(sys.argv[1:] if args is None else args)
        tolerate_any_encoding()
        try:
            code = super().main(
                args=argv,
                prog_name="vibro",
                complete_var=complete_var,
                standalone_mode=False,
                obj=argv,
                **extra,
            )
            sys.stdout.flush()
        except KeyboardInterrupt:
            code = ExitCode.INTERRUPTED
        except Exception as exc:
            code = _report(exc, argv)
        if code == ExitCode.INTERRUPTED:  # typer's, too, where signals raise exceptions
            print_error(["interrupted"])
        sys.exit(code)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the summaries of the commands, none of which is made for that."""
        with formatter.section("Commands"):
            formatter.write_dl(
                [
                    (name, run.__doc__.partition("\n\n")[0])
                    for name, (run, _) in _COMMANDS.items()
                    if name not in _HIDDEN
                ]
            )


def _report(exc: Exception, argv: Sequence[str]) -> int:
    """Print what went wrong and return the exit code."""
    if "--debug" in argv:
        tell_traceback(exc)
    if isinstance(exc, InputError):
        print_error(*exc.as_typed())
        return ExitCode.WRONG_INPUT
    if isinstance(exc, FileError):
        print_error([str(exc)], exc.hint)
        return ExitCode.FAILED
    if isinstance(exc, VibroError):
        print_error([str(exc)])
        return ExitCode.WRONG_INPUT
    if hasattr(exc, "format_message"):  # how typer says that the arguments are wrong
        command = next((arg for arg in argv if not arg.startswith("-")), "")
        see = f"see vibro {command} --help" if command in _COMMANDS else "see vibro --help"
        return _report(InputError(exc.format_message().strip(), hint=_hint(exc, command, argv) or see), [])
    if isinstance(exc, OSError):
        silence(sys.stdout)
        if not isinstance(exc, BrokenPipeError):
            what = f"read or write {exc.filename}" if exc.filename else "write to stdout"
            print_error([f"cannot {what}: {exc.strerror or exc}"])
        return ExitCode.FAILED
    if isinstance(exc, MemoryError):
        print_error(["not enough memory"], "ask for fewer values")
        return ExitCode.FAILED
    print_unexpected(exc)
    return ExitCode.FAILED


def _hint(exc: Any, command: str, argv: Sequence[str]) -> str:
    """Return how to give what was typed in another way; an empty text where that is not known."""
    if type(exc).__name__ == "NoSuchOption":
        return _hint_of_option(exc.option_name, argv)
    if isinstance(exc, typer.BadParameter) or "No such command" not in exc.format_message():
        return ""
    if command.casefold().endswith(".toml"):
        return f"write vibro solve {command}"
    names = ", ".join(name for name in _COMMANDS if name not in _HIDDEN)
    return _GONE.get(command, f"the commands are {names}")


def _hint_of_option(option: str, argv: Sequence[str]) -> str:
    if option in _GONE:
        return _GONE[option]
    called = option.lstrip("-").replace("-", "_")
    own = (quantity for quantity in (*STARTS, TROUGH_MASS) if quantity.name == called)
    if called in RATES:
        return IN_ITS_UNIT
    if quantity := find_quantity(option) or next(own, None):
        if not quantity.typed().startswith(option):
            return f"write it as {quantity.typed()}"
        return f"the design file gives the {quantity.label}" if "design" in argv else ""
    long = next((arg for arg in argv if arg.startswith(option) and arg[:2] != "--" and len(arg) > 2), "")
    return f"write it with two dashes: -{long}" if long else ""


app = typer.Typer(
    cls=_Commands,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # rich would double the time that --help takes
    context_settings={"help_option_names": ["-h", "--help"]},
)


_OF_RECORDS: Final = {
    "files": "[SCENE.toml] RECORD.csv",
    "most": 2,
    "forms": FORMS,
    "first": ("amplitude", "frequency", "drive_angle", "static_friction", "kinetic_friction"),
}
#: What is typed otherwise now, by how it was.
_GONE: Final = {
    "speed": "vibro solve tells the speed",
    "--mu": "static friction is --mu-s, kinetic friction --mu-d",
    "report": "a page is -o NAME.html of solve, drive, design or measure",
    "--flight": "--regimes-only leaves all speeds out",
    "--format": "the ending of -o says the form: -o NAME.csv, NAME.xlsx, NAME.parquet",
    "--table": "-o NAME.csv writes a table, -o - prints it",
    "--excel": "-o NAME.xlsx writes a workbook",
    "--shards": "-o NAME.parquet writes a folder; --workers says how many processes make it",
    "--scheduler": "--workers tcp://host:8786 takes the address of a cluster",
}
_OF_MACHINE: Final = ("frequency", "drive_angle", "static_friction", "kinetic_friction", "friction_ratio")
#: Commands that lists leave out: their names, or what they do, belong to few.
_HIDDEN: Final = ("motion", "compare", "schema")
_EXIT_CODES = "\b\nExit codes:\n" + "".join(f"  {code:<3}  {code.meaning}\n" for code in ExitCode)


@app.callback(invoke_without_command=True, epilog=_EXIT_CODES)
def _vibro(
    context: typer.Context, version: Annotated[bool, option("version", **SHOW_VERSION)] = False
) -> None:
    """Regimes, conveying speed and traverse time of parts on vibratory conveyors."""
    if context.invoked_subcommand is None:
        print(context.get_help())


# The functions of the commands, and which of the shared options they take; None if they have only their own.
_COMMANDS: Final[dict[str, Any]] = {
    "solve": (
        solve_command,
        {"files": "[SCENE.toml]...", "most": None, "forms": TABLES, "more": (TROUGH_MASS,)},
    ),
    "traverse-time": (traverse_time_command, {"forms": TABLES[:-1]}),
    "map": (map_command, {"forms": MAPS}),
    "simulate": (simulate_command, {"forms": HISTORIES, "more": STARTS}),
    "design": (design_command, {"files": "DESIGN.toml", "of_scene": False}),
    "drive": (drive_command, {"files": "MACHINE.toml...", "most": None, "first": _OF_MACHINE}),
    **dict.fromkeys(("measure", "motion", "compare"), (measure_command, _OF_RECORDS)),
    "explore": (
        explore_command,
        {"files": "[SCENE.toml]...", "most": None, "forms": ("html",), "prints": False},
    ),
    "accuracy": (accuracy_command, {"forms": HISTORIES}),
    "friction": (friction_command, None),
    "schema": (schema_command, None),
}


def main() -> None:
    """Run the command line of this process."""
    end_on_signals()
    open_closed_streams()
    # Imports and figures make many small objects, nearly all of them in use. Searching them for garbage as
    # often as Python does takes a tenth of a map's time.
    gc.set_threshold(_OBJECTS)
    try:
        app()
    finally:
        ignore_signals()
        gc.freeze()  # searching all that is left for garbage as Python ends takes a twentieth of a short run
