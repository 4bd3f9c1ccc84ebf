"""``--help``: one screen, and all the rest on request."""

from __future__ import annotations

import inspect
from typing import Any

import typer
from helpers.cases import each
from helpers.commands import Run

from vibro.cli.app import app

COMMANDS: dict[str, Any] = typer.main.get_command(app).commands  # type: ignore[attr-defined]
HIDDEN = {"motion", "compare", "schema"}


def test_ten_commands_are_listed_with_whole_summaries(run: Run) -> None:
    text = run("--help").stdout
    told = " ".join(text[text.index("Commands:") : text.index("Exit codes:")].split())
    assert "..." not in told
    for name, command in COMMANDS.items():
        first, _, _ = inspect.cleandoc(command.help).partition("\n\n")
        assert (f" {name} {' '.join(first.split())}" in told) == (name not in HIDDEN)
    assert len({*COMMANDS} - HIDDEN) == 10


@each("name", COMMANDS)
def test_help_is_one_screen_and_all_of_it_has_every_option(run: Run, name: str) -> None:
    lines = run(name, "--help").stdout.splitlines()
    assert len(lines) <= 30
    assert all(len(line) <= 80 for line in lines)
    whole = run(name, "--help-all").stdout
    for parameter in COMMANDS[name].params:
        for option in parameter.opts if parameter.param_type_name == "option" else ():
            assert f" {option}" in whole, option


def test_quantities_without_an_option_are_listed(run: Run) -> None:
    assert "gravity=VALUE" not in run("solve", "--help").stdout
    text = run("solve", "--help-all").stdout
    assert all(f"  {name}=VALUE" in text for name in ("gravity", "filling", "along_2", "trough_mass"))
