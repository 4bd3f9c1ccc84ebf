"""The indexes of helpers and engines list every module, and the rooms whose tests use it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

import pytest

TESTS: Final = Path(__file__).parent


def users(package: str, module: str) -> list[str]:
    """Return the folders of tests whose files name a module; ``tests`` for the files beside this one."""
    named = re.compile(rf"\b{package}(\.| import (\w+, )*){module}\b")
    own = TESTS / package / f"{module}.py"
    found = [path for path in TESTS.rglob("*.py") if path != own and named.search(path.read_text("utf-8"))]
    return sorted({path.relative_to(TESTS).parts[0] if path.parent != TESTS else "tests" for path in found})


@pytest.mark.parametrize("package", ["helpers", "engines"])
def test_an_index_lists_every_module_and_who_uses_it(package: str) -> None:
    text = (TESTS / package / "README.md").read_text(encoding="utf-8")
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| `")]
    listed = {row[0].strip("`"): row[-1].split(", ") for row in rows}
    assert len(listed) == len(rows)
    modules = sorted(path.name for path in (TESTS / package).glob("*.py") if path.name != "__init__.py")
    assert listed == {name: users(package, name.removesuffix(".py")) for name in modules}
