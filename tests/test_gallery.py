"""Every page of the gallery runs, and its command and its Python make one picture."""

from __future__ import annotations

import io
import runpy
import shlex
from typing import TYPE_CHECKING

import numpy as np
import pytest
from commands import copy_examples
from figures import EXAMPLES, ORDER, commands_of, pictures_of
from PIL import Image
from typer.testing import CliRunner

from vibro.cli.app import app
from vibro.output.names import PICTURES

if TYPE_CHECKING:
    from pathlib import Path

SCRIPTS = sorted((EXAMPLES / "gallery").glob("plot_*.py"))


def test_every_picture_that_has_a_name_has_a_page() -> None:
    endings = {name.rpartition("-")[2] for script in SCRIPTS for name in pictures_of(script)}
    assert {f"{name}.png" for name in PICTURES} <= endings


def test_every_page_has_a_place_in_the_gallery() -> None:
    assert [f"plot_{name}.py" for name in sorted(ORDER)] == [script.name for script in SCRIPTS]


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem.removeprefix("plot_"))
def test_the_command_writes_what_the_script_draws(
    script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(script.parent)
    figure = runpy.run_path(str(script)).get("figure")
    copy_examples(tmp_path)
    monkeypatch.chdir(tmp_path)
    for line in commands_of(script).replace("\\\n", " ").splitlines():
        program, *args = shlex.split(line)
        assert program == "vibro"
        result = CliRunner().invoke(app, args)
        assert result.exit_code == 0, result.stderr
    names = pictures_of(script)
    assert all((tmp_path / name).is_file() for name in names)
    assert figure or names
    assert bool(figure) != (f"/images/sphx_glr_{script.stem}_001.png" in script.read_text(encoding="utf-8"))
    if figure and names:
        drawn = io.BytesIO()
        figure.savefig(drawn)
        python, command = (np.asarray(Image.open(file), float) for file in (drawn, tmp_path / names[0]))
        # Values of an axis may differ by rounding, and a colour then by one step.
        np.testing.assert_allclose(python, command, rtol=0.0, atol=1.0)
