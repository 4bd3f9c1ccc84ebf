"""Settings of all tests."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final

import pytest
from hypothesis import settings

if TYPE_CHECKING:
    from collections.abc import Iterator

# Several processes of tests fill the cores: threads of BLAS would only wait for each other. It is asked for
# before anything imports NumPy; programs that tests start inherit it.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Many shells and containers forbid byte code. Without it every process compiles all tests anew, which takes
# three times as long, and so does every program that they start: write it all the same.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

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


@pytest.fixture(scope="session", autouse=True)
def _in_node(request: pytest.FixtureRequest) -> Iterator[None]:
    """Let node solve, if that is asked for."""
    if not request.config.getoption("--in-node"):
        yield
        return
    from helpers.node_doors import in_node

    with in_node():
        yield


@pytest.fixture
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let vibro use two threads, whatever the machine has."""
    monkeypatch.setattr("os.cpu_count", lambda: 2)


# Sessions of tests/messages that are said in a second and notice much.
_SHORT: Final = ("design", "drives", "machines", "map", "python_questions", "simulate", "tables")

# What the markers pick (CONTRIBUTING.md), by the beginnings of tests. ``fast`` has those of each room that
# notice most of benchmarks/faults.toml for their time: more than half of it, in half a minute on a core.
# Files of ``slow`` take six seconds or more there, those of ``process`` start programs, workers or clusters.
_MARKED: Final = {
    "fast": (
        "answers/test_answer.py", "cli/test_amplitude_units.py", "cli/test_friction.py",
        "cli/test_map_pictures.py", "cli/test_simulate.py", "cli/test_traverse_time.py",
        "core/test_bounces.py", "core/test_contact.py", "core/test_drive.py", "core/test_flight.py",
        "core/test_history.py", "core/test_legs.py", "core/test_loop.py", "core/test_numbers.py",
        "core/test_scenes.py", "core/test_slides.py",
        "designs/test_guarantees_extremes.py", "designs/test_optima_limits.py", "designs/test_reading.py",
        "designs/test_rows_rounding.py", "designs/test_search.py", "designs/test_sensitivities.py",
        "designs/test_spaces", "designs/test_windows_families.py", "designs/test_windows_yields.py",
        "explore/test_page_file.py", "explore/test_scenes.py", "files/test_descriptions.py",
        "files/test_machines.py", "files/test_motions.py", "files/test_points.py",
        "machines/test_machine.py", *(f"messages/test_messages.py::test_messages[{name}]" for name in _SHORT),
        "motion/test_histories_arrivals.py", "motion/test_histories_trace.py", "plots/test_curves.py",
        "plots/test_fields.py", "plots/test_history.py", "plots/test_neighbours.py", "plots/test_view.py",
        "records/test_formats.py", "records/test_problem_cycles.py", "records/test_reading.py", "results/",
        "sweeps/test_columns.py", "sweeps/test_grid.py",
        "sweeps/test_run.py", "sweeps/test_tally.py", "sweeps/test_whole.py", "tables/test_files.py",
        "tables/test_plan.py", "tables/test_stored.py", "tables/test_writing.py", "tables/test_xlsx.py",
        "test_axes.py", "test_errors.py", "test_friction_catalogue.py", "test_indexes.py", "test_makers.py",
        "test_mutants.py", "test_periodic.py", "test_quantities.py", "test_reals.py", "test_reference.py",
        "test_scales.py", "test_scene.py", "test_steady.py",
    ),
    "slow": (
        "accuracy/test_trade.py", "core/test_javascript.py",
        "cli/test_capabilities.py",
        "explore/test_browser", "designs/test_design.py",
        "designs/test_machine_drives.py", "designs/test_motions.py", "designs/test_windows.py",
        "explore/test_page_map.py",
        "messages/", "records/test_drive_errors.py", "records/test_fitting.py", "records/test_speeds.py",
        "answers/test_printed.py", "test_frozen.py", "test_gallery.py", "test_inverse_friction.py",
        "test_walks.py",
    ),
    "process": (
        "cli/test_app.py", "cli/test_interrupts.py",
        "cli/test_map_shards.py", "cli/test_streams.py", "core/test_compiled.py", "core/test_javascript.py",
        "explore/test_page_begins.py", "explore/test_page_file.py", "explore/test_page_map.py",
        "explore/test_page_motion.py", "explore/test_page_numbers.py", "explore/test_page_state.py",
        "plots/test_style.py", "tables/test_faults.py", "tables/test_readers.py", "tables/test_shards.py",
        "test_building.py", "test_gallery.py", "test_imports.py", "test_threads.py", "test_translate.py",
    ),
    "browser": (
        "explore/test_browser", "answers/test_printed.py", "test_site.py",
    ),
}  # fmt: skip


def pytest_addoption(parser: pytest.Parser) -> None:
    """Let the files of tests/messages be written anew, and tests run with the solver of pages."""
    parser.addoption(
        "--update-messages", action="store_true", help="write into tests/messages what is said now"
    )
    parser.addoption("--in-node", action="store_true", help="take the solver's script for the compiled one")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Where one marker alone is asked for, do not import files that lack it, which takes seconds."""
    beginnings = _MARKED.get(config.getoption("markexpr"))
    path = collection_path.relative_to(Path(__file__).parent).as_posix()
    if beginnings is None or not path.endswith(".py") or path.startswith(beginnings):
        return None
    is_named = any(one.partition("::")[0].endswith(path) for one in (*config.args, *beginnings))
    return None if is_named else True


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of each list."""
    tests = Path(__file__).parent
    for item in items:
        name = f"{item.path.relative_to(tests).as_posix()}::{item.name}"
        for marker, beginnings in _MARKED.items():
            if name.startswith(beginnings):
                item.add_marker(marker)
