"""``vibro schema``: what it prints and writes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from vibro.files.descriptions import FILES
from vibro.files.json_schema import schema_of

if TYPE_CHECKING:
    from helpers.commands import Run


@pytest.mark.parametrize(("args", "name"), [((), "scene"), (("scene",), "scene"), (("design",), "design")])
def test_it_prints_the_schema(run: Run, args: tuple[str, ...], name: str) -> None:
    result = run("schema", *args)
    assert (result.exit_code, result.stderr) == (0, "")
    assert json.loads(result.stdout) == schema_of(FILES[name])
    assert result.stdout.isascii()  # whatever encoding the shell writes a file in
    assert run("schema", *args, "-o", "-").stdout == result.stdout


def test_it_writes_a_file_that_is_not_replaced_unasked(run: Run) -> None:
    assert run("schema", "design", "-o", "out/design").stderr == f"wrote {Path('out/design.json')}\n"
    assert json.loads(Path("out/design.json").read_text(encoding="utf-8")) == schema_of(FILES["design"])
    again = run("schema", "-o", "out/design")
    assert (again.exit_code, again.stdout) == (1, "")
    assert run("schema", "-o", "out/design", "--force", "-q").stderr == ""
    assert json.loads(Path("out/design.json").read_text(encoding="utf-8")) == schema_of(FILES["scene"])
    run("schema", "-o", "out/")
    assert Path("out/vibro-scene.schema.json").exists()
