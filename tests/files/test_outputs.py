"""Output files appear whole or not at all."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path
from types import FrameType

import pytest

from vibro.errors import FileError
from vibro.files.outputs import OutputSet, output_stem, suffixed


def put(target: Path, text: str = "new", *, force: bool = False, error: BaseException | None = None) -> None:
    """Write a file as a run does, which may end early."""
    with OutputSet([target], force=force) as output:
        output[target].write_text(text, encoding="utf-8")
        if error:
            raise error


def test_suffixes_are_appended_whatever_dots_the_stem_has(tmp_path: Path) -> None:
    assert suffixed(output_stem("out/run1.5", "nut"), ".csv") == Path("out/run1.5.csv")
    assert output_stem(None, "nut") == Path("nut")
    assert output_stem("out/", "nut") == Path("out/nut")
    assert output_stem(str(tmp_path), "nut") == tmp_path / "nut"
    assert output_stem(str(tmp_path / "new"), "nut") == tmp_path / "new"


def test_files_appear_together_and_make_their_folder(tmp_path: Path) -> None:
    targets = [tmp_path / "a" / "b" / name for name in ("x.csv", "x.json")]
    with OutputSet(targets, force=False) as output:
        for target in targets:
            output[target].write_text(target.name, encoding="utf-8")
            assert not target.exists()
    assert [target.read_text(encoding="utf-8") for target in targets] == ["x.csv", "x.json"]
    assert sorted(path.name for path in (tmp_path / "a" / "b").iterdir()) == ["x.csv", "x.json"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, SystemExit])
def test_nothing_remains_of_a_run_that_ends_early(tmp_path: Path, error: type[BaseException]) -> None:
    target = tmp_path / "a" / "b" / "x.csv"
    with pytest.raises(error):
        put(target, error=error())
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_ends_early_keeps_what_was_there(tmp_path: Path) -> None:
    target = tmp_path / "x.csv"
    target.write_text("old", encoding="utf-8")
    with pytest.raises(KeyboardInterrupt):
        put(target, force=True, error=KeyboardInterrupt())
    assert target.read_text(encoding="utf-8") == "old"
    assert list(tmp_path.iterdir()) == [target]


class SignalledError(Exception):
    """What this test's handler makes of a signal."""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_a_signal_between_two_renames_does_not_leave_half_a_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: signal.Signals
) -> None:
    def stop(_: int, __: FrameType | None) -> None:
        raise SignalledError

    replace, renamed = Path.replace, list[str]()

    def replace_and_signal(path: Path, target: Path) -> Path:
        result = replace(path, target)
        renamed.append(target.name)
        signal.raise_signal(number)
        return result

    monkeypatch.setattr(Path, "replace", replace_and_signal)
    targets = [tmp_path / name for name in ("x.csv", "x.png", "x.json")]
    before = signal.signal(number, stop)
    try:
        with OutputSet(targets, force=False) as output:
            for target in targets:
                output[target].write_text("new", encoding="utf-8")
        assert signal.getsignal(number) is stop
    finally:
        signal.signal(number, before)
    assert renamed == ["x.csv", "x.png", "x.json"]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(renamed)


def test_existing_files_are_replaced_only_by_force(tmp_path: Path) -> None:
    target = tmp_path / "x.csv"
    target.write_text("old", encoding="utf-8")
    with pytest.raises(FileError, match=r"x\.csv exists already") as caught:
        put(target)
    assert "--force" in caught.value.hint
    assert list(tmp_path.iterdir()) == [target]
    put(target, force=True)
    assert target.read_text(encoding="utf-8") == "new"


def test_a_folder_in_the_way_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "x.csv").mkdir()
    with (
        pytest.raises(FileError, match="a folder is in the way"),
        OutputSet([tmp_path / "x.csv"], force=True),
    ):
        pass


def test_a_file_in_the_way_of_a_folder(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("", encoding="utf-8")
    for folder in (tmp_path / "out", tmp_path / "out" / "deeper"):
        with pytest.raises(FileError, match="cannot use the folder") as caught:
            put(folder / "x.csv")
        assert caught.value.hint == f"{tmp_path / 'out'} is a file"


def test_a_folder_that_cannot_be_written_to(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path, *_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    monkeypatch.setattr(Path, "touch", refuse)
    with pytest.raises(FileError, match=r"cannot write to .*Permission denied") as caught:
        put(tmp_path / "new" / "x.csv")
    assert caught.value.hint == "choose another place with -o"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("number", "hint"), [(errno.ENOSPC, "free some space, or choose another place with -o"), (errno.EIO, "")]
)
def test_a_disk_that_fails_leaves_nothing(tmp_path: Path, number: int, hint: str) -> None:
    target = tmp_path / "x.csv"
    with pytest.raises(FileError, match="cannot write to") as caught:
        put(target, error=OSError(number, os.strerror(number)))
    assert os.strerror(number) in str(caught.value)
    assert caught.value.hint == hint
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_a_spreadsheet_holds_is_retried(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    replace, failures, pauses = Path.replace, iter(range(3)), list[float]()

    def held(path: Path, target: Path) -> Path:
        if next(failures, None) is not None:
            raise PermissionError(errno.EACCES, "Permission denied", str(target))
        return replace(path, target)

    monkeypatch.setattr(Path, "replace", held)
    monkeypatch.setattr("time.sleep", pauses.append)
    put(tmp_path / "x.csv")
    assert len(pauses) == 3
    assert list(tmp_path.iterdir()) == [tmp_path / "x.csv"]


def test_a_file_that_stays_held_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def held(path: Path, target: Path) -> Path:
        raise PermissionError(errno.EACCES, "Permission denied", str(target))

    monkeypatch.setattr(Path, "replace", held)
    monkeypatch.setattr("time.sleep", lambda _: None)
    with pytest.raises(FileError, match=r"cannot replace .*x\.csv") as caught:
        put(tmp_path / "x.csv")
    assert caught.value.hint == "close it in the program that holds it open"
    assert list(tmp_path.iterdir()) == []


def test_leftovers_of_killed_runs_are_swept_and_those_of_live_ones_kept(tmp_path: Path) -> None:
    dead = subprocess.run(
        [sys.executable, "-c", "import os; print(os.getpid())"], capture_output=True, check=True
    )
    leftover = tmp_path / f".vibro-{int(dead.stdout)}-0.tmp"
    # The first process of a system, and on Windows its idle process, never ends.
    alive = tmp_path / f".vibro-{os.getppid()}-0.tmp"
    other = tmp_path / ".vibro-notes.tmp"
    for path in (leftover, alive, other):
        path.touch()
    put(tmp_path / "x.csv")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([alive.name, other.name, "x.csv"])


@pytest.mark.skipif(sys.platform == "win32", reason="no fork, no SIGKILL")
def test_no_reader_sees_half_a_file_of_a_killed_run(tmp_path: Path) -> None:
    """Kill a writer at 100 instants: each file is whole, and the next run sweeps what remained."""
    script = textwrap.dedent("""
        import os, random, signal, sys, time
        from pathlib import Path
        from vibro.files.outputs import OutputSet

        folder, instants = Path(sys.argv[1]), random.Random(7)
        targets = [folder / name for name in ("x.csv", "x.json")]

        def write_for_ever():
            generation = 0
            while True:
                generation += 1
                with OutputSet(targets, force=True) as output:
                    for target in targets:
                        with output[target].open("w", encoding="utf-8") as stream:
                            for _ in range(50):
                                stream.write(f"{generation}\\n" * 1000)

        for _ in range(100):
            child = os.fork()
            if not child:
                write_for_ever()
            time.sleep(instants.uniform(0, 0.02))
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            for target in targets:
                if target.exists():
                    lines = target.read_text(encoding="utf-8").splitlines()
                    assert len(lines) == 50000 and len(set(lines)) == 1, (target, len(lines))
                    print("whole")
        with OutputSet(targets, force=True) as output:
            pass
        print(sorted(path.name for path in folder.iterdir()))
    """)
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path)],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    *whole, last = done.stdout.splitlines()
    assert last == "['x.csv', 'x.json']"
    assert len(whole) > 100
