"""Answers are those that are frozen in tests/data/frozen, to within what is promised of them: regression."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from helpers.frozen import SETS, compare, read

if TYPE_CHECKING:
    from helpers.frozen import Stored

_LEFT_OUT = 0.01  # [1] of the cells, at most: those whose text rounding may change


@pytest.fixture(scope="module")
def stored() -> Stored:
    return read()


@pytest.mark.parametrize("name", SETS)
def test_answers_are_those_that_are_frozen(name: str, stored: Stored) -> None:
    """A change that means to differ says so in CHANGELOG.md and makes them anew (tests/data/README.md)."""
    found = compare(name, stored)
    assert not found.beyond, "\n".join([f"{len(found.beyond)} of {found.cells} differ:", *found.beyond[:3]])
    assert found.left_out <= max(1.0, _LEFT_OUT * found.cells)
