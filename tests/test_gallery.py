"""Commands of the gallery run, and of maps and curves command and Python make the same pictures."""

from __future__ import annotations

import os
import runpy
import shlex
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from commands import copy_examples
from figures import EXAMPLES, ORDER, commands_of, pictures_of
from helpers.drawn import coarse_pictures
from PIL import Image
from typer.testing import CliRunner

from vibro.cli.app import app

SITE = os.environ.get("VIBRO_SITE")  # path of the site, where it is built already
SCRIPTS = sorted((EXAMPLES / "gallery").glob("plot_*.py"))
NAMES = ("regime", "speed", "traverse", "impact", "flight", "band")  # what stems get
KINDS = ("curves", "one_axis", "regimes", "speed")  # compared


def test_every_picture_that_has_a_name_has_a_page() -> None:
    endings = {name.rpartition("-")[2] for script in SCRIPTS for name in pictures_of(script)}
    assert {f"{name}.png" for name in NAMES} <= endings


def test_every_page_has_a_place_in_the_gallery() -> None:
    assert [f"plot_{name}.py" for name in sorted(ORDER)] == [script.name for script in SCRIPTS]


def by_command() -> dict[str, list[Path]]:
    """List the pages that show each command."""
    pages: dict[str, list[Path]] = {}
    for script in SCRIPTS:
        pages.setdefault(commands_of(script), []).append(script)
    return pages


@pytest.mark.parametrize(
    "scripts", by_command().values(), ids=lambda scripts: scripts[0].stem.removeprefix("plot_")
)
def test_the_command_writes_what_the_scripts_draw(
    scripts: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compared = {
        script: tmp_path / f"{script.stem}.png"
        for script in scripts
        if script.stem.removeprefix("plot_") in KINDS
    }
    for script, drawn in compared.items():
        if SITE:  # its build has run the script
            compared[script] = Path(SITE, "_images", f"sphx_glr_{script.stem}_001.png").resolve()
        else:
            monkeypatch.chdir(script.parent)
            runpy.run_path(str(script))["figure"].savefig(drawn)
    copy_examples(tmp_path)
    monkeypatch.chdir(tmp_path)
    for line in commands_of(scripts[0]).replace("\\\n", " ").splitlines():
        program, *args = shlex.split(line)
        assert program == "vibro"
        with nullcontext() if compared else coarse_pictures():
            result = CliRunner().invoke(app, args)
        assert result.exit_code == 0, result.stderr
    assert all(Path(name).is_file() for script in scripts for name in pictures_of(script))
    for script, drawn in compared.items():
        python, command = (np.asarray(Image.open(file), float) for file in (drawn, pictures_of(script)[0]))
        # Values of an axis may differ by rounding, and a colour then by one step.
        np.testing.assert_allclose(python, command, rtol=0.0, atol=1.0)
