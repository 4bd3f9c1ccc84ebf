"""What tests of fits share."""

from __future__ import annotations

import pytest

from vibro.records.problem import FITTABLE


@pytest.fixture
def own_start_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Search from the scene's own values alone, which takes a fraction of the time."""
    monkeypatch.setattr("vibro.records.problem._GRID", dict.fromkeys(FITTABLE, ()))
