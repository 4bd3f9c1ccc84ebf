"""Settings of all tests."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Final

import pytest
from hypothesis import settings

if TYPE_CHECKING:
    from collections.abc import Iterator

# Several processes of tests fill the cores: threads of BLAS would only wait for each other. It is asked for
# before anything imports NumPy; programs that tests start inherit it.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A busy machine exceeds any time limit for an example, and a failure that comes from new random examples
# cannot be repeated: no limit, and the same examples in every run. For many more of them, run pytest
# with --hypothesis-profile=thorough.
settings.register_profile("vibro", deadline=None, derandomize=True, database=None, max_examples=40)
settings.register_profile("thorough", settings.get_profile("vibro"), max_examples=1000)
settings.load_profile("vibro")


@pytest.fixture(scope="session", autouse=True)
def _one_core() -> Iterator[None]:
    """Let vibro too use one thread in each of several processes of tests, but where a test asks for two."""
    with pytest.MonkeyPatch.context() as patch:
        if "PYTEST_XDIST_WORKER" in os.environ:
            patch.setattr("os.cpu_count", lambda: 1)
        yield


@pytest.fixture
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let vibro use two threads, whatever the machine has."""
    monkeypatch.setattr("os.cpu_count", lambda: 2)


# Tests of all rooms that together take less than a minute on two cores: ``pytest -m fast``.
_FAST: Final = (
    "cli/test_completion.py", "cli/test_friction.py", "core/test_", "explore/test_form.py",
    "explore/test_guards.py", "explore/test_state.py", "files/test_claims.py", "files/test_part_sets.py",
    "files/test_rounding.py", "files/test_scene_files.py", "inverse/test_catalogue.py",
    "inverse/test_reading.py", "motion/test_trace.py", "plots/test_labels.py", "plots/test_neighbours.py",
    "records/test_missing_values.py", "records/test_reading.py", "records/test_signals.py", "results/",
    "sweeps/test_plan.py", "sweeps/test_readers.py", "sweeps/test_selection.py", "test_axes.py",
    "test_errors.py", "test_quantities.py", "test_reals.py", "test_reference.py", "test_scene.py",
    "test_translate.py", "test_two_axis.py",
)  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the fast tests."""
    tests = Path(__file__).parent
    for item in items:
        if item.path.relative_to(tests).as_posix().startswith(_FAST):
            item.add_marker(pytest.mark.fast)
