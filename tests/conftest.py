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
    "cli/test_friction.py", "core/test_contact.py", "core/test_cycle_slides.py", "core/test_drives.py",
    "core/test_elementary.py", "core/test_flight.py", "core/test_legs.py", "core/test_loop.py",
    "core/test_motions.py", "core/test_samples.py", "core/test_scenes.py", "core/test_steps.py",
    "core/test_windows.py", "files/test_descriptions.py", "files/test_scene_files.py",
    "output/test_hidden.py", "output/test_plan.py", "output/test_selection.py", "output/test_shard_folder.py",
    "plots/test_labels.py", "records/test_minimisation.py",
    "records/test_missing_values.py", "test_axes.py", "test_errors.py",
    "test_quantities.py", "test_reals.py", "test_reference.py", "test_scene.py", "test_translate.py",
    "test_walks.py",
)  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the fast tests."""
    tests = Path(__file__).parent
    for item in items:
        if item.path.relative_to(tests).as_posix().startswith(_FAST):
            item.add_marker(pytest.mark.fast)
