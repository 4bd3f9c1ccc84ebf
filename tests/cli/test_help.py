"""``--help``: whole summaries, options in groups."""

from __future__ import annotations

import inspect
import re
from typing import Any

import typer
from helpers.cases import each
from helpers.commands import Run

from vibro.cli.app import app
from vibro.cli.help import GROUPS
from vibro.cli.report import stacked

COMMANDS: dict[str, Any] = typer.main.get_command(app).commands  # type: ignore[attr-defined]
#: Parameters that stand in another group than their name says.
ELSEWHERE = {("map", "speed"): "Pictures"}


def test_summaries_of_all_commands_are_whole(run: Run) -> None:
    text = run("--help").stdout
    assert all(len(line) <= 80 for line in text.splitlines())
    told = " ".join(text[text.index("Commands:") : text.index("Exit codes:")].split())
    assert "..." not in told
    for name, command in COMMANDS.items():
        first, _, _ = inspect.cleandoc(command.help).partition(".\n")
        summary = " ".join(first.split()).removesuffix(".")
        assert f"{name} {summary}." in told


@each("name", COMMANDS)
def test_options_stand_in_groups(run: Run, name: str) -> None:
    text = run(name, "--help").stdout
    sections = dict(re.findall(r"(?ms)^(\w+):\n(.*?)(?=^\w+:\n|\Z)", text))
    assert not {*sections} - {*GROUPS, "Arguments"}
    assert list(sections) == [group for group in ("Arguments", *GROUPS) if group in sections]
    for parameter in COMMANDS[name].params:
        if getattr(parameter, "hidden", False):
            continue
        if parameter.param_type_name == "argument":
            group = "Arguments"
        else:
            own = ELSEWHERE.get((name, parameter.name))
            group = own or next(group for group, names in GROUPS.items() if parameter.name in names)
            for option in parameter.opts:
                assert re.search(rf"(?m)^  .*{option}\b", sections[group]), option
        assert parameter.help.split()[0] in sections[group]


def test_a_table_is_stacked_where_lines_are_too_long() -> None:
    rows = [
        ("method", "setting", "time", "max error", "beyond"),
        ("vibro", "exact", "143 ns", "3.1e-15", "0"),
        ("events", "rtol 1e-3", "1.88 ms", "7.4e-02", "6"),
    ]
    whole = stacked(rows, heads=2, width=None)
    assert len(whole.splitlines()) == 3
    for width in (10, 30, 40, 45, 60, 200):
        told = stacked(rows, heads=2, width=width)
        assert sorted({*told.split()}) == sorted({*whole.split()})  # no digit is lost
        widest = max(map(len, told.splitlines()))
        assert widest <= max(width, 28)  # of one column beside the heads
        parts = told.split("\n\n")
        assert all(part.splitlines()[2].startswith("events  rtol 1e-3") for part in parts)
        assert (len(parts) == 1) == (width >= max(map(len, whole.splitlines())))
