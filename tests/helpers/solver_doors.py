"""The solver through its compiled doors, or as plain Python, whatever the tests run with."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest

from vibro.core.compiled import Doors, doors, library_path

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextmanager
def plain() -> Iterator[Doors]:
    """Run the solver as plain Python."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("VIBRO_SOLVER", "python")
        doors.cache_clear()
        try:
            yield doors()
        finally:
            doors.cache_clear()


@contextmanager
def compiled() -> Iterator[Doors]:
    """Run the solver compiled; skip the test where it is not."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("VIBRO_SOLVER", raising=False)
        if library_path() is None:
            pytest.skip("the solver is not compiled")
        doors.cache_clear()
        try:
            yield doors()
        finally:
            doors.cache_clear()
