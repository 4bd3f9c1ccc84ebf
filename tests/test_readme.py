"""What the README shows is what happens; .ci/run runs its commands line by line."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from vibro.cli.app import app

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


SHOWN = [tuple(block.removeprefix("$ ").split("\n", 1)) for block in blocks("console")]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)


def arguments(line: str) -> list[str]:
    return shlex.split(line, comments=True)[1:]


def test_there_are_outputs_to_test() -> None:
    assert len(SHOWN) >= 1


@pytest.mark.parametrize(("line", "output"), SHOWN)
def test_every_output_is_the_shown_one(line: str, output: str) -> None:
    assert CliRunner().invoke(app, arguments(line)).stdout == output


@pytest.mark.parametrize("code", blocks("python"))
def test_every_script_runs(code: str, capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(code, "README.md", "exec"), {})
    assert capsys.readouterr().out.strip()


@pytest.mark.parametrize(
    "target",
    re.findall(r"\]\((?!http)([^)#]+)\)", README)
    + re.findall(r"`((?:docs|examples|benchmarks)/[\w./]+)`", README),
)
def test_every_file_that_it_names_exists(target: str) -> None:
    assert (ROOT / target).exists()
