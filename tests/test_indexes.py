"""The indexes of helpers and engines list every module, and markers are of tests that are there."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

import pytest

TESTS: Final = Path(__file__).parent


@pytest.mark.parametrize("package", ["helpers", "engines"])
def test_an_index_lists_every_module_once(package: str) -> None:
    text = (TESTS / package / "README.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `(\w+\.py)`", text, flags=re.MULTILINE)
    assert sorted(listed) == sorted(path.name for path in (TESTS / package).glob("[!_]*.py"))


def test_markers_are_of_files_that_are_there() -> None:
    settings = (TESTS / "conftest.py").read_text(encoding="utf-8")
    for beginning in re.findall(r'"((?:\w+/)?test_\w+(?:\.py)?)"', settings):
        assert [*TESTS.glob(f"{beginning}*")], beginning
