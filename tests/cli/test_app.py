"""How runs begin and end: start-up, messages, exit codes, faults, terminals."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.cases import each
from helpers.commands import NUT, NUT_ANGLE_AND_FRICTION, POSIX, SMALL, TABLE, TELLS_LOADED, VIBRO, Run, other

from vibro.cli.exit_codes import ExitCode
from vibro.core.compiled import library_path
from vibro.interrupts import EXIT_CODE


@pytest.mark.parametrize("args", [["--version"], ["map", "--help"]])
def test_help_loads_no_numerical_library(args: list[str]) -> None:
    done = subprocess.run([*TELLS_LOADED, *args], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "LOADED []"


@pytest.mark.skipif(library_path() is None, reason="without the library its source is loaded")
def test_solving_loads_numpy_alone() -> None:
    args = ["solve", "-A", "1", "-f", "15", *NUT_ANGLE_AND_FRICTION]
    done = subprocess.run([*TELLS_LOADED, *args], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "LOADED ['numpy']"


@each(("given", "threads"), [({}, "1"), ({"OMP_NUM_THREADS": "2"}, "2")])
def test_products_of_matrices_take_one_thread_unless_the_user_wants_more(
    monkeypatch: pytest.MonkeyPatch, given: dict[str, str], threads: str
) -> None:
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        monkeypatch.delenv(name, raising=False)
    program = (
        "import atexit, os, sys; from vibro.__main__ import main; sys.argv[1:] = ['--version'];"
        "atexit.register(lambda: print(os.environ['OPENBLAS_NUM_THREADS'])); main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], env=os.environ | given, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == threads


@each(
    ("args", "problem", "hint"),
    [
        (["mapp"], "'mapp'", "the commands are solve, traverse-time, map, simulate"),
        (["map", "--mu-x", "1"], "--mu-x", "see vibro map --help"),
        (["solve", "-A"], "-A", "see vibro solve --help"),
        (["map", "a.toml", "b.toml"], "b.toml", "leave one out"),
        (["solve", "--sweep"], "--sweep", "see vibro solve --help"),
        (["solve", "--workers", 5000 * "9"], "--workers", "see vibro solve --help"),
    ],
)
def test_wrong_arguments_are_one_error_and_one_hint(
    run: Run, args: list[str], problem: str, hint: str
) -> None:
    result = run(*args)
    assert result.exit_code == 2
    assert result.stdout == ""
    error, last = result.stderr.splitlines()
    assert error.startswith("error: ")
    assert problem in error
    assert len(error) < 600
    assert last.startswith(f"hint: {hint}")


def test_help_tells_every_exit_code(run: Run) -> None:
    told = run("--help").stdout
    for code in ExitCode:
        assert f"{code:d} " in told
        assert code.meaning in told
    assert ExitCode.INTERRUPTED == EXIT_CODE == 130
    assert [*ExitCode] == [0, 1, 2, 3, 4, 130]


def test_a_traceback_is_shown_only_for_debugging(run: Run) -> None:
    plain, debug = run("map", "no.toml"), run("map", "no.toml", "--debug")
    assert "Traceback" not in plain.stderr
    assert "Traceback" in debug.stderr
    assert debug.stderr.endswith(plain.stderr)


def test_an_interrupted_run_is_exit_code_130(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr("vibro.files.csv_tables.CsvFormat.rows", interrupt)
    result = run(*SMALL, "-o", "nut")
    assert (result.exit_code, list(Path().iterdir())) == (130, [])


def test_quiet_prints_errors_alone(run: Run) -> None:
    assert run(*TABLE, "-o", "nut", "-q").stderr == ""
    assert run(*TABLE, "-o", "nut", "-q").stderr.startswith("error: nut.csv")


@POSIX
def test_a_terminal_sees_progress_files_and_shares(tmp_path: Path) -> None:
    import pty

    ours, theirs = pty.openpty()
    environment = {name: value for name, value in os.environ.items() if name != "NO_COLOR"}
    environment |= {"TERM": "xterm-256color", "COLUMNS": "100"}
    args = ("map", *other(NUT, "-A", "0.5:4:300"), "-o", "n")
    with subprocess.Popen(
        [*VIBRO, *args],
        cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=theirs,
    ) as run:  # fmt: skip
        os.close(theirs)
        seen = b""
        while True:
            try:
                part = os.read(ours, 4096)
            except OSError:  # the other end has been closed
                break
            if not part:
                break
            seen += part
        assert run.stdout is not None
        assert run.stdout.read() == b""
    os.close(ours)
    text = seen.decode()
    assert run.returncode == 0
    assert "solving" in text
    assert "300/300" in text
    assert re.search("drawing .*1/1", text)
    assert "\x1b[3" in text
    lines = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]|\r(?!\n)", "", text).splitlines()  # without cursor movements
    assert [line for line in lines if line.startswith("wrote ")] == [
        "wrote n.csv", "wrote n-speed.png", "wrote n.json",
    ]  # fmt: skip
    assert re.fullmatch(r"fastest: [\d.]+ mm/s at amplitude 4 mm", lines[-1])
    assert lines[-2].startswith("restitution 0: ")
    shares = {line.split()[0]: float(line.split()[1].rstrip("%")) for line in lines[-6:-2]}
    assert set(shares) == {"no-slip", "forward-slip", "back-slip", "hopping"}
    assert sum(shares.values()) == pytest.approx(100, abs=0.3)


def test_a_console_without_the_characters_shows_substitutes(tmp_path: Path) -> None:
    (tmp_path / "\u03bc.toml").write_text("[scene]\nx = 1\n", encoding="utf-8")
    run = subprocess.run(
        [*VIBRO, "map", "\u03bc.toml"],
        cwd=tmp_path, capture_output=True, check=False, env=os.environ | {"PYTHONIOENCODING": "cp1252"},
    )  # fmt: skip
    assert run.returncode == 2
    assert run.stderr.startswith(b"error: ?.toml: [scene] unknown key 'x'")
