"""The indexes of helpers and engines list every module."""

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
