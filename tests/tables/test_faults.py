"""Sweeps come out the same whatever happens to runs, to their workers, and to the disk."""

from __future__ import annotations

import multiprocessing
import signal
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import pytest
from helpers.commands import NUT_ANGLE_AND_FRICTION, POSIX
from helpers.plans import plan_of, swept, written

from vibro.errors import FileError
from vibro.tables.plan import MANIFEST, SUCCESS, read_plan, shard_name

if TYPE_CHECKING:
    from vibro.tables.shards import Progress

resource = pytest.importorskip("resource")  # of POSIX
pytestmark = POSIX

LIMIT = 60.0  # [s] for what takes moments on a machine that is not busy
COMMAND = ("map", "-A", "0.5:2:10", "-f", "10:30:30", *NUT_ANGLE_AND_FRICTION, "-q", "-o", "wide.parquet")
PLAN = plan_of(swept(amplitude_mm="0.5:2:10", frequency_hz="10:30:30"), 20)
SHARDS = {shard_name(shard) for shard in range(15)}
LIBRARIES = "numpy pandas scipy pyarrow matplotlib typer rich click vibro sitecustomize usercustomize"
HOSTILE = (*sys.stdlib_module_names, *LIBRARIES.split())
AS_COMMAND = """
import signal, sys
# A shell starts what it runs in the background with interrupts ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
from vibro.tables import plan, writing
plan._SHARD_CELLS = 20
make, said = writing.make_shards, []
def make_and_pause(plan, folder, workers, report):
    def pause(progress):
        report(progress)
        if progress.shards >= 3 and not said:
            said.append("paused")
            print("paused", flush=True)
            sys.stdin.readline()
    return make(plan, folder, workers, pause)
if __name__ == "__main__":
    writing.make_shards = make_and_pause
    from vibro.__main__ import main
    main()
"""
"""The program, which pauses when some shards are there, until it is told to go on."""


def paused(here: Path, *more: str) -> subprocess.Popen[str]:
    """Start the program, and wait until it has made some shards."""
    here.with_name("paused.py").write_text(AS_COMMAND, encoding="utf-8")
    run = subprocess.Popen(
        [sys.executable, str(here.with_name("paused.py")), *COMMAND, *more],
        cwd=here, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert run.stdout is not None
    assert run.stdout.readline() == "paused\n", run.communicate()
    return run


def ended(run: subprocess.Popen[str], number: signal.Signals | None = None) -> tuple[int, str]:
    """End a run by a signal, or let it go on; return its exit code and what it says.

    Its workers have its streams, which end with the last of them.
    """
    if number is not None:
        run.send_signal(number)
    _, said = run.communicate("" if number else "\n", timeout=LIMIT)
    return run.returncode, said


@pytest.fixture(scope="module")
def undisturbed() -> str:
    """Return the digest of a sweep that is made in one go."""
    with TemporaryDirectory() as folder:
        return written(Path(folder) / "wide.parquet", PLAN).digest


@pytest.fixture
def here(tmp_path: Path) -> Path:
    (tmp_path / "here").mkdir()
    return tmp_path / "here"


def check_whole(
    folder: Path, digest: str, workers: int | str | None = None, *, was_killed: bool = False
) -> None:
    """Go on with the whole shards that are there and nothing else, and compare."""
    names = {path.name for path in folder.glob("[!.]*" if was_killed else "*")}
    assert {MANIFEST} < names < {MANIFEST, *SHARDS}
    summary = written(folder, read_plan(folder / MANIFEST), workers)
    assert (summary.digest, all(made.is_new for made in summary.made.values())) == (digest, False)
    assert {path.name for path in folder.glob("[!.]*")} == {MANIFEST, SUCCESS, *SHARDS}


def test_a_killed_run_goes_on_and_its_workers_end_with_it(here: Path, undisturbed: str) -> None:
    code, said = ended(paused(here, "--workers", "2"), signal.SIGKILL)
    assert (code, "Error" in said) == (-signal.SIGKILL, False)
    check_whole(here / "wide.parquet", undisturbed, 2, was_killed=True)


def test_an_interrupt_ends_a_run_whose_processes_run_no_file_of_the_folder(
    tmp_path: Path, here: Path, undisturbed: str
) -> None:
    ran = tmp_path / "ran"
    ran.mkdir()
    for name in HOSTILE:
        (here / f"{name}.py").write_text(f"open({str(ran / name)!r}, 'w').close()\n", encoding="utf-8")
    code, said = ended(paused(here, "--workers", "2"), signal.SIGINT)
    assert (code, said.splitlines()[0]) == (130, "error: interrupted")
    assert "goes on" in said
    assert list(ran.iterdir()) == []
    check_whole(here / "wide.parquet", undisturbed)


def test_twin_runs_of_one_folder_make_it_together(here: Path, undisturbed: str) -> None:
    run = paused(here)
    folder = here / "wide.parquet"
    assert written(folder, read_plan(folder / MANIFEST)).digest == undisturbed
    assert ended(run) == (0, "")
    assert written(folder, read_plan(folder / MANIFEST)).digest == undisturbed


def test_a_lost_process_ends_the_run_with_a_word(tmp_path: Path, undisturbed: str) -> None:
    killed: list[Any] = []

    def kill(progress: Progress) -> None:
        if progress.shards >= 3 and not killed:
            killed.append(multiprocessing.active_children()[0])
            killed[0].kill()

    with pytest.raises(FileError, match="a worker has ended") as caught:
        written(tmp_path / "wide.parquet", PLAN, 1, report=kill)
    assert "goes on" in caught.value.hint
    check_whole(tmp_path / "wide.parquet", undisturbed)


@pytest.mark.skipif(sys.platform != "linux", reason="a limit of another process is Linux's")
def test_a_full_disk_is_told_and_leaves_whole_shards(here: Path, undisturbed: str) -> None:
    run = paused(here)
    resource.prlimit(run.pid, resource.RLIMIT_FSIZE, (5000, 5000))
    code, said = ended(run)
    assert code == 1
    assert said.startswith("error: cannot write to wide.parquet: ")
    assert "File too large" in said
    check_whole(here / "wide.parquet", undisturbed)


def test_without_a_scheduler_nothing_is_begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("vibro.tables.shards._CONNECTING", 0.1)
    with pytest.raises(FileError, match=r"no Dask scheduler answers at tcp://127.0.0.1:1") as caught:
        written(tmp_path / "out", PLAN, "tcp://127.0.0.1:1")
    assert "dask scheduler" in caught.value.hint
    assert {path.name for path in (tmp_path / "out").iterdir()} == {MANIFEST}
