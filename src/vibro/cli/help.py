"""What ``--help`` prints of a command: its options in groups, and its summary whole."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from typer.core import TyperCommand

from vibro.quantities import DRIVES, MACHINE, QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["GROUPS", "GroupedCommand"]

_OF_DRIVE: Final = ("stroke", "frequency", *DRIVES)
#: Parameters by the group that they stand in; one that says ``rich_help_panel`` itself stands there.
GROUPS: Final[Mapping[str, tuple[str, ...]]] = {
    "Drive": tuple(name for name in QUANTITIES if name in _OF_DRIVE),
    "Scene": (
        *(name for name in QUANTITIES if name not in (*_OF_DRIVE, *MACHINE)), "stand_ratio", "pitch", "mass",
    ),
    "Machine": (*MACHINE, "pack", "trough_mass"),
    "Record": (
        "time", "displacement", "velocity", "acceleration", "friction", "trough_along", "trough_normal",
        "sensitivity", "reverse", "absolute", "fit", "law", "amplitude_error",
    ),
    "Axes": ("x", "y", "at", "sweep"),
    "Solving": (
        "speed", "hopping", "exact", "flight", "regimes_only", "coexist", "scenes", "tolerance", "only",
        "cycles", "duration", "start_phase", "start_velocity", "start_height", "start_normal_velocity",
        "every",
    ),
    "Pictures": ("show", "panels", "begin", "end"),
    "Tables": ("columns", "digits", "samples", "decimal_comma", "workers"),
    "Run": (
        "output", "json", "force", "quiet", "debug", "version", "port", "no_open", "help",
    ),
}  # fmt: skip
_WHOLE: Final = 10_000  # characters
_GROUP_OF: Final = {name: group for group, names in GROUPS.items() for name in names}


class GroupedCommand(TyperCommand):
    """A command whose help has its options in groups.

    Typer does so only by rich, which would double the time that ``--help`` takes.
    """

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the options, group by group."""
        groups: dict[str, list[tuple[str, str]]] = {group: [] for group in ("Arguments", *GROUPS)}
        for parameter in self.get_params(ctx):
            told = parameter.get_help_record(ctx)
            if told is not None:
                own = getattr(parameter, "rich_help_panel", None) or _GROUP_OF.get(parameter.name or "")
                group = "Arguments" if parameter.param_type_name == "argument" else own or "Run"
                groups[group].append(told)
        for group, rows in groups.items():
            if rows:
                with formatter.section(group):
                    formatter.write_dl(rows)

    def get_short_help_str(self, limit: int = 0) -> str:
        """Return the summary: the first sentence whole, which lists of commands wrap."""
        return super().get_short_help_str(limit=_WHOLE)
