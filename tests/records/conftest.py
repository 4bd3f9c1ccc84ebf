"""Settings of tests of records."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def _one_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take records in the frame that is given: to doubt it takes most of the time, and has its own tests."""
    monkeypatch.setattr("vibro.records.comparison.of_another_frame", lambda *_: [])
