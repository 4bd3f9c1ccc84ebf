"""What a shell is told when somebody presses the tabulator."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest
from helpers.cases import each
from helpers.commands import TELLS_LOADED, VIBRO
from typer.testing import CliRunner

from vibro.cli.app import app
from vibro.plots.history import PANELS
from vibro.quantities import DRIVES, QUANTITIES, SWEPT
from vibro.sweeps.columns import chosen, column_names, columns_of

if TYPE_CHECKING:
    from pathlib import Path

SHELLS = {
    "bash": {"COMP_WORDS": "vibro map --at mu_", "COMP_CWORD": "3"},
    "zsh": {"_TYPER_COMPLETE_ARGS": "vibro map --at mu_"},
    "fish": {"_TYPER_COMPLETE_ARGS": "vibro map --at mu_", "_TYPER_COMPLETE_FISH_ACTION": "get-args"},
    "powershell": {
        "_TYPER_COMPLETE_ARGS": "vibro map --at mu_",
        "_TYPER_COMPLETE_WORD_TO_COMPLETE": "mu_",
    },
}


def completed(*words: str) -> list[str]:
    """Return what bash is told to complete the last word with."""
    asked = {
        "COMP_WORDS": " ".join(("vibro", *words)),
        "COMP_CWORD": str(len(words)),
        "_VIBRO_COMPLETE": "complete_bash",
    }
    result = CliRunner().invoke(app, [], env=asked)
    assert (result.exit_code, result.stderr) == (0, "")
    return result.stdout.split()


@each(
    ("words", "names"),
    [
        (("sim",), ["simulate"]),
        (("map", "--x", "mu_"), ["mu_s", "mu_ratio", "mu_d"]),
        (("map", "--y", "dr"), ["drive_angle"]),
        (("map", "--at", "f"), ["f0=", "f=", "filling=", "frequency=", "friction_ratio="]),
        (("map", "--show", "im"), ["impact"]),
        (("map", "--columns", "regime,amp"), ["regime,amplitude_mm", "regime,amplitude_empty_mm"]),
        (
            ("solve", "--columns", "mean_velocity_mm_s,mean_v"),
            [
                "mean_velocity_mm_s,mean_velocity_error_mm_s",
                "mean_velocity_mm_s,mean_velocity_with_second_harmonic_mm_s",
            ],
        ),
        (("simulate", "--panels", "forces,v"), ["forces,velocity"]),
        (
            ("compare", "--fit", "mu_s,"),
            ["mu_s,mu_d", "mu_s,A", "mu_s,alpha", "mu_s,X", "mu_s,Y", "mu_s,phi"],
        ),
        (("solve", "--flight", "o"), ["on", "off"]),
        (("schema", ""), ["scene", "design"]),
        (("traverse-time", "--sw"), ["--sweep"]),
        # Names of files, which the shell itself completes where it is told nothing.
        (("solve", "examples/"), []),
    ],
)
def test_names_are_completed(words: tuple[str, ...], names: list[str]) -> None:
    assert completed(*words) == names


def test_every_name_is_there() -> None:
    # An empty last word: bash joins its words with spaces.
    assert completed("map", "--x", "") == [*(QUANTITIES[name].letter for name in SWEPT), *SWEPT]
    assert completed("simulate", "--panels", "") == list(PANELS)
    assert completed("map", "--columns", "") == column_names()
    every = columns_of(drive=[name for name in DRIVES if name in SWEPT], machine=True)
    assert [column.name for column in chosen(column_names(), every)] == column_names()


@pytest.mark.parametrize("shell", SHELLS)
def test_every_shell_is_answered(shell: str) -> None:
    result = CliRunner().invoke(app, [], env={**SHELLS[shell], "_VIBRO_COMPLETE": f"complete_{shell}"})
    assert result.exit_code == 0
    for letter in ("mu_s=", "mu_ratio=", "mu_d="):
        assert letter in result.stdout


def test_fish_gets_a_line_an_option_with_its_unit(tmp_path: Path) -> None:
    asked = {
        "_TYPER_COMPLETE_ARGS": "vibro solve --l",
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
        "_VIBRO_COMPLETE": "complete_fish",
    }
    done = subprocess.run(
        VIBRO, cwd=tmp_path, capture_output=True, text=True, check=True, env=os.environ | asked
    )
    (line,) = done.stdout.splitlines()
    assert line.startswith("--length\t")
    assert "[mm]" in line


def test_an_option_that_ends_a_run_does_not_end_completion() -> None:
    assert completed("--version", "ma") == ["map"]


def test_completion_in_a_process_of_its_own_loads_no_numerical_library(tmp_path: Path) -> None:
    done = subprocess.run(
        TELLS_LOADED,
        cwd=tmp_path, capture_output=True, text=True, check=True,
        env=os.environ | SHELLS["bash"] | {"_VIBRO_COMPLETE": "complete_bash"},
    )  # fmt: skip
    assert done.stdout.splitlines() == ["mu_s=", "mu_ratio=", "mu_d=", "LOADED []"]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_is_installed_for_the_shell_it_is_run_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shell: str
) -> None:
    monkeypatch.setattr("shellingham.detect_shell", lambda: (shell, f"/bin/{shell}"))
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    shown = CliRunner().invoke(app, ["--show-completion"])
    assert shown.exit_code == 0
    assert f"_VIBRO_COMPLETE=complete_{shell}" in shown.stdout
    assert list(tmp_path.iterdir()) == []
    installed = CliRunner().invoke(app, ["--install-completion"])
    assert installed.exit_code == 0
    scripts = [path.read_text() for path in tmp_path.rglob("*vibro*") if path.is_file()]
    assert [shown.stdout.strip()] == [script.strip() for script in scripts]


@pytest.mark.skipif(sys.platform == "win32", reason="bash")
def test_bash_completes_what_is_typed(tmp_path: Path) -> None:
    program = tmp_path / "vibro"
    program.write_text(f'#!/bin/sh\nexec {" ".join(VIBRO)} "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    script = tmp_path / "script"
    shown = subprocess.run(
        ["bash", "-c", '"$0" --show-completion; true', program], capture_output=True, text=True, check=True
    )
    script.write_text(shown.stdout, encoding="utf-8")
    words = "COMP_WORDS=(vibro map --show i); COMP_CWORD=3"
    asked = f'source "$0"; {words}; _vibro_completion "$1"; echo "$COMPREPLY"'
    done = subprocess.run(["bash", "-c", asked, script, program], capture_output=True, text=True, check=True)
    assert done.stdout == "impact\n"
