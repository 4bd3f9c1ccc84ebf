"""Standard streams that are closed, full or left: the answer arrives or the exit code says so."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.commands import LONG, NUT, POSIX, SMALL, TABLE, VIBRO, Run, other, started

pytestmark = POSIX

SOLVE = ("solve", *NUT)
WRONG = ("solve", *other(NUT, "-A", "-1"))
LOST, FULL = (f"error: cannot write to stdout: {os.strerror(e)}\n" for e in (errno.EBADF, errno.ENOSPC))


def in_shell(
    folder: Path, *args: str, redirected: str = "", **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run the program from a shell, which can close streams."""
    return subprocess.run(
        ["sh", "-c", f'"$@" {redirected}', "sh", *VIBRO, *args],
        cwd=folder, capture_output=True, text=True, check=False, env=os.environ | environment,
    )  # fmt: skip


def test_files_do_not_need_streams(tmp_path: Path) -> None:
    done = in_shell(tmp_path, *TABLE, "-o", "nut", redirected="<&- >&- 2>&-")
    assert (done.returncode, done.stdout) == (0, "")
    lines = (tmp_path / "nut.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 10
    assert lines[0].startswith("amplitude_mm,")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["nut.csv", "nut.json"]


@pytest.mark.parametrize(
    ("args", "redirected", "code", "error"),
    [
        (SOLVE, ">&-", 1, LOST),
        ((*SMALL, "-o", "-", "-q"), ">/dev/full", 1, FULL),
        (WRONG, ">&- 2>&- <&-", 2, ""),
    ],
)  # fmt: skip
def test_an_answer_that_cannot_be_written_and_an_error_that_nobody_sees(
    tmp_path: Path, args: tuple[str, ...], redirected: str, code: int, error: str
) -> None:
    done = in_shell(tmp_path, *args, redirected=redirected)
    assert (done.returncode, done.stdout, done.stderr) == (code, "", error)


def test_messages_never_get_into_the_table(run: Run, tmp_path: Path) -> None:
    done = in_shell(tmp_path, *TABLE, "-o", "-", redirected="2>/dev/full")
    assert done.returncode == 0
    assert done.stdout == run(*TABLE, "-o", "-").stdout
    assert done.stdout.startswith("amplitude_mm,")


def test_a_reader_that_stops_early_ends_the_run_quietly(tmp_path: Path) -> None:
    run = started(*LONG, "-o", "-", "-q", cwd=tmp_path)
    assert run.stdout is not None
    assert run.stderr is not None
    assert run.stdout.readline().startswith("amplitude_mm,")
    run.stdout.close()
    assert run.stderr.read() == ""
    assert run.wait() == 1
    run.stderr.close()


def test_a_file_that_may_not_grow_is_told_and_leaves_nothing(tmp_path: Path) -> None:
    code = (
        "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (500_000, 500_000));"
        " from vibro.__main__ import main; main()"
    )
    run = started(*LONG, "-o", "big", cwd=tmp_path, program=(sys.executable, "-c", code))
    _, stderr = run.communicate()
    assert run.returncode == 1
    assert "error: cannot write to .: " in stderr
    assert list(tmp_path.iterdir()) == []


def test_names_do_not_command_the_terminal(run: Run) -> None:
    """Escape sequences, bells and line ends of a path are shown, not obeyed."""
    name = "nut\x1b[31m\x07\n\u202e.toml"
    for args in (
        ("solve", name),
        ("measure", *NUT, f"{name}.csv"),
        ("solve", "--\x1b]0;title\x07"),
        ("solve", *NUT, "-o", f"{name}.abc"),
    ):
        done = run(*args)
        assert done.exit_code in (1, 2)
        lines = done.stderr.splitlines()
        assert all(line.isprintable() and line.startswith(("error: ", "hint: ")) for line in lines)
        assert "\\x1b" in done.stderr
    done = run(*SOLVE, "-o", name.removesuffix(".toml"))
    assert done.exit_code == 0
    assert all(line.isprintable() for line in done.stderr.splitlines())
    assert "wrote nut\\x1b[31m\\x07\\n\\u202e.csv" in done.stderr.splitlines()
