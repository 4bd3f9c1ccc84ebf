"""Rooms below the command line speak to callers of Python; the command line translates what they say."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer
from helpers.cases import each
from helpers.commands import NUT, Run
from helpers.made_records import EXAMPLES

import vibro
from vibro.cli.app import app
from vibro.cli.words import COMMANDS, in_options, options_of, speak_in

ROOT = Path(vibro.__file__).parent
GROUP = typer.main.get_command(app)
COMMAND = rf"\bvibro (?:{'|'.join(GROUP.commands)})\b"  # type: ignore[attr-defined]
OPTION = r"(?:^|[\s(\"'=])(?:--[a-z]|-[A-Za-z](?:\s|$))"
DATA = str(EXAMPLES / "data" / "nut_trough_mv.csv")


@pytest.fixture
def compare() -> Iterator[None]:
    speak_in(options_of(GROUP.commands["compare"].params))  # type: ignore[attr-defined]
    yield
    speak_in({})


def test_functions_and_commands_are_there() -> None:
    assert {*COMMANDS.values()} <= {*GROUP.commands}  # type: ignore[attr-defined]
    assert {*COMMANDS} <= {*vibro.__all__}


@pytest.mark.usefixtures("compare")
@each(
    ("said", "shown"),
    [
        ("replace with force=True, or go", "replace with --force, or go"),
        ("may be inverted (reverse=True, or", "may be inverted (--reverse, or"),
        ('name time="t [s]" mass="0.02kg"', 'name --time "t [s]" --mass 0.02kg'),
        ('give normal_phase="-60deg"', "give phase=-60deg"),
        ("mass='20 g': no", '--mass "20 g": no'),
        ('output="-" writes it', "-o - writes it"),
        ("frequency=15.25", "-f 15.25"),
        ("mass=2e-2.", "--mass 2e-2."),
        ("drive_angle=math.radians(20)", "-a 20"),
        ("leave out drive_angle=, or trough_along=: both", "leave out -a, or --trough-along: both"),
        ('sensitivity="trough-along=1 mV/g": no', '--sensitivity "trough-along=1 mV/g": no'),
        ('run vibro.solve, vibro.sweep or vibro.design("my spec.toml")',
         'run vibro solve, vibro map or vibro design "my spec.toml"'),
        # no options of this command; names of files; what the command line wrote itself
        ("give panels= or workers=4", "give panels= or workers=4"),
        ("cannot read mass=1.csv", "cannot read mass=1.csv"),
        ("out/mass=1 'mass=1' mass=1/x mass=1-x.png", "out/mass=1 'mass=1' mass=1/x mass=1-x.png"),
        ("--at mass=3: 'mass' is no axis", "--at mass=3: 'mass' is no axis"),
    ],
)  # fmt: skip
def test_arguments_become_options_and_functions_commands(said: str, shown: str) -> None:
    assert in_options(said) == shown


def test_arguments_of_other_commands_stay(run: Run) -> None:
    """What a run before has spoken of is forgotten."""
    run("compare", *NUT, "no.csv")
    assert in_options("mass=0.02") == "--mass 0.02"
    run("solve", "no.toml")
    assert in_options("reverse=True") == "reverse=True"
    run("--version")
    assert in_options("mass=0.02") == "mass=0.02"


def test_one_fact_in_both_words(run: Run) -> None:
    """A single sensor without an angle, and an inverted one: an error, a hint and a warning."""
    with pytest.raises(vibro.InputError) as caught:
        vibro.measured_motion(DATA, trough_along="Trog längs", sensitivity="100mV/g")
    assert caught.value.hint.startswith("name trough_normal= too, or ")
    assert caught.value.hint.endswith(": drive_angle=math.radians(20)")
    sensor = ("--trough-along", "Trog längs", "--sensitivity", "100mV/g")
    told = run("motion", DATA, *sensor).stderr
    assert "hint: name --trough-normal too, or " in told
    assert told.endswith(": -a 20\n")
    way = ("--displacement", "Weg", "-a", "20", "--reverse", "--mu-s", ".74", "--mu-d", ".57", "--json")
    warned = run("compare", DATA, *sensor, *way)
    said = "the data run against the computed direction: --reverse reverses their axis"
    assert f"warning: {said}\n" in warned.stderr
    assert said in json.loads(warned.stdout)["warnings"]
