"""Of several runs at one stem one writes, and nobody removes what another may be writing."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from vibro.errors import FileError
from vibro.files import claims
from vibro.files.claims import Claim, sweep

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL, file modes, locks by flock")
NAMESPACE = ("unshare", "--pid", "--fork", "--mount-proc")

HOLD = """
import sys, time
from pathlib import Path
from vibro.files.claims import Claim

claim = Claim(Path(sys.argv[1]))
claim.take()
claim.new_file()
print("taken", flush=True)
time.sleep(60)
"""


def held_elsewhere(stem: Path, *before: str) -> subprocess.Popen[str]:
    """Let another process take a claim."""
    holder = subprocess.Popen(
        [*before, sys.executable, "-c", HOLD, str(stem)], stdout=subprocess.PIPE, text=True
    )
    assert holder.stdout is not None
    assert holder.stdout.readline() == "taken\n"
    return holder


def end(holder: subprocess.Popen[str]) -> None:
    holder.kill()
    holder.communicate()


def namespaces() -> bool:
    """Whether this system lets a process have process numbers of its own; CI must."""
    try:
        works = subprocess.run([*NAMESPACE, "true"], capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        works = False
    assert works or "CI" not in os.environ
    return works


def test_a_stem_is_claimed_once_until_it_is_given_up(tmp_path: Path) -> None:
    first, second = Claim(tmp_path / "nut"), Claim(tmp_path / "nut")
    first.take()
    with pytest.raises(FileError, match=r"another run is writing .*nut\.\* at this moment") as caught:
        second.take()
    assert str(first.folder) in caught.value.hint
    second.give_up()  # what it does not have
    sweep(tmp_path)
    assert first.folder.is_dir()
    Claim(tmp_path / "bolt").take()
    first.give_up()
    first.give_up()
    second.take()


@POSIX
def test_files_wait_under_names_of_their_own_with_the_rights_of_new_files(tmp_path: Path) -> None:
    claim = Claim(tmp_path / "nut")
    claim.take()
    mask = os.umask(0o027)
    try:
        paths = {claim.new_file() for _ in range(10)}
    finally:
        os.umask(mask)
    assert len(paths) == 10
    assert {path.stat().st_mode & 0o777 for path in paths} == {0o640}
    claim.give_up()
    assert list(tmp_path.iterdir()) == []


@POSIX
def test_a_killed_run_is_swept_and_its_stem_is_free(tmp_path: Path) -> None:
    for stem in ("nut", "bolt"):
        holder = held_elsewhere(tmp_path / stem)
        with pytest.raises(FileError):
            Claim(tmp_path / stem).take()
        sweep(tmp_path)
        assert len(list(tmp_path.glob(".vibro-*/*"))) == 2  # the lock and a file
        end(holder)
        if stem == "nut":
            Claim(tmp_path / stem).take()
            shutil.rmtree(Claim(tmp_path / stem).folder)
        else:
            sweep(tmp_path)
        assert list(tmp_path.iterdir()) == []


def test_another_namespace_of_processes_neither_sweeps_nor_claims_what_is_alive(tmp_path: Path) -> None:
    if not namespaces():
        pytest.skip("no namespaces of processes (unshare) for this user")
    holder = held_elsewhere(tmp_path / "nut")
    code = """
import os, sys
from pathlib import Path
from vibro.errors import FileError
from vibro.files.claims import Claim, sweep

assert os.getpid() == 1
folder = Path(sys.argv[1])
sweep(folder)
try:
    Claim(folder / "nut").take()
except FileError as exc:
    print(exc)
"""
    done = subprocess.run(
        [*NAMESPACE, sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, check=True
    )
    assert "another run is writing" in done.stdout
    assert len(list(tmp_path.glob(".vibro-*/*"))) == 2
    end(holder)


def leftover(folder: Path, *names: str, age: float = 0.0) -> Path:
    """Make what a run of another system may have left, or be writing."""
    place = folder / ".vibro-0123456789abcdef"
    place.mkdir()
    for path in [*(place / name for name in names), place]:
        path.touch()
        os.utime(path, (time.time() - age, time.time() - age))
    return place


@pytest.mark.parametrize("names", [("0",), ("lock-of-another-system", "0")])
def test_what_another_system_may_be_writing_is_kept_for_a_month(
    tmp_path: Path, names: tuple[str, ...]
) -> None:
    month = claims._FOREIGN_AGE
    place = leftover(tmp_path, *names, age=month - 60.0)
    sweep(tmp_path)
    assert sorted(path.name for path in place.iterdir()) == sorted(names)
    shutil.rmtree(place)
    place = leftover(tmp_path, *names, age=month + 60.0)
    sweep(tmp_path)
    assert not place.exists()
    place = leftover(tmp_path, *names, age=month + 60.0)
    (place / names[-1]).touch()  # it still changes
    sweep(tmp_path)
    assert place.exists()


def test_a_claim_that_was_half_made_or_half_removed_is_nobodys(tmp_path: Path) -> None:
    claim = Claim(tmp_path / "nut")
    for files in ([], [f"{claims._lock_name()}-0"]):
        claim.folder.mkdir()
        for name in files:
            (claim.folder / name).touch()
        claim.take()
        claim.give_up()
        (tmp_path / ".vibro-fedcba9876543210").mkdir()
        sweep(tmp_path)
        assert list(tmp_path.iterdir()) == []


def test_what_is_no_claim_is_never_swept(tmp_path: Path) -> None:
    month = claims._FOREIGN_AGE
    real = leftover(tmp_path, "notes", age=2 * month)
    real.rename(tmp_path / ".vibro-notes")
    (tmp_path / ".vibro-0123456789abcdef").touch()
    if sys.platform != "win32":
        (tmp_path / ".vibro-00000000000000aa").symlink_to(tmp_path / ".vibro-notes", target_is_directory=True)
    before = sorted(tmp_path.rglob("*"))
    sweep(tmp_path)
    assert sorted(tmp_path.rglob("*")) == before


@POSIX
def test_a_lock_that_was_replaced_meanwhile_is_not_taken_for_a_dead_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between opening a dead run's lock and getting it, another run sweeps that and claims the stem anew."""
    import fcntl

    stem = tmp_path / "nut"
    end(held_elsewhere(stem))
    flock, other = fcntl.flock, Claim(stem)

    def slow(lock: int, how: int) -> None:
        monkeypatch.setattr("fcntl.flock", flock)
        other.take()
        flock(lock, how)

    monkeypatch.setattr("fcntl.flock", slow)
    with pytest.raises(FileError, match="another run"):
        Claim(stem).take()
    assert other.folder.is_dir()
    assert list(other.folder.iterdir())


@POSIX
def test_without_locks_a_claim_holds_until_it_is_given_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr("fcntl.flock", refuse)
    first = Claim(tmp_path / "nut")
    first.take()
    sweep(tmp_path)
    with pytest.raises(FileError, match="another run"):
        Claim(tmp_path / "nut").take()
    first.give_up()
    assert list(tmp_path.iterdir()) == []
