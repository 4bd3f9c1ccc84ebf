"""How runs begin and end: start-up, messages, exit codes, faults, terminals."""

from __future__ import annotations

import errno
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.cases import each
from helpers.commands import NUT, NUT_ANGLE_AND_FRICTION, POSIX, SMALL, TABLE, TELLS_LOADED, VIBRO, Run

import vibro
from vibro.cli.exit_codes import ExitCode
from vibro.core.compiled import library_path
from vibro.interrupts import EXIT_CODE

COMMANDS = ("map", "solve", "traverse-time")


@pytest.mark.parametrize("args", [["--help"], ["--version"], ["map", "--help"], ["solve", "-h"]])
def test_help_loads_no_numerical_library(args: list[str]) -> None:
    done = subprocess.run([*TELLS_LOADED, *args], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "LOADED []"


@pytest.mark.skipif(library_path() is None, reason="without the library its source is loaded")
def test_solving_loads_numpy_alone() -> None:
    args = ["solve", "-A", "1", "-f", "15", *NUT_ANGLE_AND_FRICTION]
    done = subprocess.run([*TELLS_LOADED, *args], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "LOADED ['numpy']"


@each(
    ("given", "threads"), [({}, "1"), ({"OMP_NUM_THREADS": "2"}, "2"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")]
)
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


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_every_shared_option(run: Run, command: str) -> None:
    text = run(command, "--help").stdout
    for option in (
        "-A", "--amplitude", "--stroke", "-f", "--frequency", "-a", "--drive-angle", "--alpha", "--mu-s",
        "--mu-d", "--mu-ratio", "--trough-angle", "--gravity", "--restitution", "-L", "--length", "-o",
        "--output", "--json", "--force", "-q", "--quiet", "--debug", "--version", "SCENE.toml",
    ):  # fmt: skip
        assert option in text


@pytest.mark.parametrize("args", [["--version"], *([command, "--version"] for command in COMMANDS)])
def test_version(run: Run, args: list[str]) -> None:
    result = run(*args)
    assert (result.exit_code, result.stdout) == (0, f"vibro {vibro.__version__}\n")


def test_without_arguments_help_is_shown(run: Run) -> None:
    result = run()
    assert result.exit_code == 0
    assert all(command in result.stdout for command in COMMANDS)


@each(
    ("args", "problem", "hint"),
    [
        (["mapp"], "'mapp'", "see vibro --help"),
        (["map", "--mu-x", "1"], "--mu-x", "see vibro map --help"),
        (["solve", "-A"], "-A", "see vibro solve --help"),
        (["solve", "a.toml", "b.toml"], "b.toml", "see vibro solve --help"),
        (["solve", "--sweep"], "--sweep", "see vibro solve --help"),
        (["solve", "--flight", 5000 * "9"], "--flight", "see vibro solve --help"),
        (["solve", "--flight", "x"], "'--flight': 'x' is not one of 'on', 'off'", "see vibro solve --help"),
        (
            ["map", *NUT_ANGLE_AND_FRICTION, "--digits", "x", "-q"],
            "--digits = 'x': not a number",
            "write a whole number, such as 3",
        ),
        (["accuracy", "--scenes", "1e3s"], "'s' is no unit of --scenes", "write a whole number, such as 3"),
        (["accuracy", "--tolerance", "low"], "--tolerance = 'low': not a number", "write it like 0.5"),
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
    assert last == f"hint: {hint}"


def test_a_missing_scene_file_is_exit_code_1(run: Run) -> None:
    Path("nut.toml").touch()
    result = run("map", "nutt.toml")
    assert result.exit_code == 1
    assert result.stderr.startswith("error: cannot read nutt.toml: ")
    assert result.stderr.endswith("hint: did you mean 'nut.toml'?\n")


@pytest.mark.parametrize("name", ["wid", "wid/", "wide.parquet"])
def test_a_map_of_what_is_not_there_is_told_what_is(run: Run, name: str) -> None:
    Path("wide").mkdir()
    Path("other.csv").touch()
    result = run("map", name)
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr == (
        f"error: cannot read {Path(name)}: there is no such file or folder\nhint: did you mean 'wide'?\n"
    )


@each("command", ["solve", "simulate", "traverse-time", "accuracy", "compare", "design"])
def test_every_command_says_that_its_file_is_missing(run: Run, command: str) -> None:
    record = ["record.csv"] if command == "compare" else []
    Path("record.csv").write_text("t [s],x [mm]\n" + "".join(f"{i / 600},1\n" for i in range(99)))
    result = run(command, "nut.parquet" if command == "design" else "nut.toml", *record)
    assert result.exit_code == 1
    assert result.stderr.splitlines()[-1].startswith("error: cannot read nut.")


def test_help_tells_every_exit_code(run: Run) -> None:
    told = run("--help").stdout
    for code in ExitCode:
        assert f"{code:d} " in told
        assert code.meaning in told
    assert ExitCode.INTERRUPTED == EXIT_CODE == 130
    assert [*ExitCode] == [0, 1, 2, 3, 4, 130]


def test_a_wrong_scene_file_is_exit_code_2(run: Run) -> None:
    Path("nut.toml").write_text("[scene]\namplitude = 1\nfrequency = 2\n", encoding="utf-8")
    result = run("map", "nut.toml")
    assert result.exit_code == 2
    assert result.stderr.splitlines() == [
        "error: nut.toml: [scene] unknown key 'amplitude'; did you mean 'amplitude_mm'?",
        "error: nut.toml: [scene] unknown key 'frequency'; did you mean 'frequency_hz'?",
    ]


def test_a_scene_file_must_not_give_the_same_twice(run: Run) -> None:
    Path("nut.toml").write_text("[scene]\namplitude_mm = 1\nstroke_mm = 2\n", encoding="utf-8")
    assert "error: [scene] gives both amplitude and stroke\n" in run("map", "nut.toml").stderr


def test_a_traceback_is_shown_only_for_debugging(run: Run) -> None:
    plain, debug = run("map", "no.toml"), run("map", "no.toml", "--debug")
    assert "Traceback" not in plain.stderr
    assert "Traceback" in debug.stderr
    assert debug.stderr.endswith(plain.stderr)


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (ZeroDivisionError("oops"), "error: unexpected ZeroDivisionError: oops\nhint: please report it"),
        (MemoryError(), "error: not enough memory\nhint: ask for fewer values"),
        (OSError(errno.EIO, "Input/output error"), "error: cannot write to .: Input/output error\n"),
        (
            OSError(errno.ENOSPC, "No space left"),
            "error: cannot write to .: No space left\nhint: free some space",
        ),
    ],
)
def test_faults_are_told_in_one_line_and_leave_nothing(
    run: Run, monkeypatch: pytest.MonkeyPatch, error: Exception, message: str
) -> None:
    def fail(*_: object) -> str:
        raise error

    monkeypatch.setattr("vibro.files.csv_tables.CsvFormat.rows", fail)
    result = run(*SMALL, "-o", "nut")
    assert result.exit_code == 1
    assert message in result.stderr
    assert "Traceback" not in result.stderr
    assert list(Path().iterdir()) == []


def test_an_interrupted_run_is_exit_code_130(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr("vibro.files.csv_tables.CsvFormat.rows", interrupt)
    result = run(*SMALL, "-o", "nut")
    assert (result.exit_code, list(Path().iterdir())) == (130, [])


def test_existing_files_are_known_before_computing(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("nut-speed.png").touch()
    monkeypatch.setattr("vibro.output.run.sweep_blocks", None)
    result = run(*SMALL, "-o", "nut")
    assert result.exit_code == 1
    assert result.stderr.endswith(
        "error: nut-speed.png exists already, but no nut.json: it is left from an interrupted run\n"
        "hint: replace with --force, or choose another name\n"
    )
    assert [path.name for path in Path().iterdir()] == ["nut-speed.png"]


def test_a_file_in_the_way_of_the_folder(run: Run) -> None:
    Path("out").touch()
    result = run(*SMALL, "-o", "out/nut")
    assert result.exit_code == 1
    assert result.stderr.splitlines()[-2].startswith("error: cannot write to out: ")
    assert result.stderr.endswith("hint: out is a file; choose another place\n")


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (
            ("map", "-A", "0.1:3:1000000", "-f", "5:60:1000000", *NUT_ANGLE_AND_FRICTION),
            "error: 1000000 x 1000000 = 1 000 000 000 000 cells are about 283 TB, but only 100 B are free",
        ),
        (TABLE, "error: 3 x 3 = 9 cells are about 2.79 kB, but only 100 B are free in new"),
        (
            (*SMALL, "--columns", "amplitude_mm,mean_velocity_mm_s,regime", "--digits", "4"),
            "error: 3 x 3 = 9 cells are about 180 B, but only 100 B are free in new",
        ),
        (("solve", *NUT), "error: one cell is about 261 B, but only 100 B are free in new"),
    ],
)
def test_what_the_disk_cannot_hold_is_refused_with_its_size(
    run: Run, monkeypatch: pytest.MonkeyPatch, args: tuple[str, ...], said: str
) -> None:
    monkeypatch.setattr("vibro.output.staging.Staging.free_space", lambda _: 100)
    result = run(*args, "-o", "new/nut")
    assert result.exit_code == 1
    assert said in result.stderr
    assert list(Path().iterdir()) == []


@pytest.mark.parametrize(
    ("command", "stroke"),
    [
        (("solve", *NUT), "stroke, 2 mm"),
        (("traverse-time", *NUT), "stroke, 2 mm"),
        (("traverse-time", "-A", "0.5:2:3", *NUT[2:], "-o", "-"), "largest stroke, 4 mm"),
        (("map", "-A", "0.5:2:3", *NUT[2:], "-o", "-"), "largest stroke, 4 mm"),
    ],
)
def test_a_trough_shorter_than_the_stroke_is_questioned_once(
    run: Run, command: tuple[str, ...], stroke: str
) -> None:
    said = f"warning: trough length = 1.2 mm is less than the {stroke}: for metres write -L 1.2m\n"
    result = run(*command, "-L", "1.2")
    assert result.exit_code == 0
    assert result.stderr.startswith(said)
    assert result.stderr.count("warning: ") == 1
    assert "trough length" not in run(*command, "-L", "1.2", "-q").stderr
    for enough in ("1.2m", "4"):
        assert "warning" not in run(*command, "-L", enough).stderr


@pytest.mark.parametrize(
    ("axes", "hint"),
    [
        (("-A", "0.1:3:1000000", "-f", "5:60:1000000"), "ask for at most 35 335 cells, such as 180 x 180,"),
        (("-A", "0.1:3:1000000", "-f", "20,30,40"), "ask for at most 35 335 cells, such as 11000 x 3,"),
        (("-A", "0.1:3:1000000", "-f", "20"), "ask for at most 36 764 cells,"),
    ],
)
def test_a_grid_that_is_too_large_is_told_what_would_fit(
    run: Run, monkeypatch: pytest.MonkeyPatch, axes: tuple[str, ...], hint: str
) -> None:
    monkeypatch.setattr("vibro.output.staging.Staging.free_space", lambda _: 10_000_000)
    result = run("map", *axes, *NUT_ANGLE_AND_FRICTION, "-o", "nut")
    assert result.exit_code == 1
    assert hint in result.stderr.splitlines()[-1]
    counts = [int(n) for n in re.findall(r"\d+", hint.partition("such as")[2])]
    assert 0.8 * 36_363 < math.prod(counts) <= 36_363 or not counts


def test_more_rows_than_a_sheet_holds_are_a_warning(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibro.cli.answer._ROWS_OF_A_SHEET", 8)
    result = run(*SMALL, "-o", "-")
    assert (
        "warning: 9 rows are more than the 8 of a spreadsheet; --table parquet suits them better\n"
        in result.stderr
    )
    assert result.exit_code == 0


def test_quiet_prints_errors_alone(run: Run) -> None:
    assert run(*TABLE, "-o", "nut", "-q").stderr == ""
    assert run(*TABLE, "-o", "nut", "-q").stderr.startswith("error: nut.csv")


def test_stems_and_folders(run: Run) -> None:
    Path("nut.toml").write_text(
        "[scene]\ndrive_angle_deg = 20\nstatic_friction = 0.7\nkinetic_friction = 0.6\n"
    )
    axes = ("-A", "1,2", "-f", "15", "-q", "--regimes-only")
    for output, written in (
        (("-o", "run1.5"), "run1.5.csv"),
        (("-o", "new/"), "new/nut.csv"),
        (("-o", "new/stem"), "new/stem.csv"),
        (("-o", "new"), "new/nut.csv"),
        ((), "nut.csv"),
    ):
        assert run("map", "nut.toml", *axes, *output, "--force").exit_code == 0
        assert Path(written).is_file()
        Path(written).unlink()
    assert run("map", *NUT, *axes).exit_code == 0
    assert Path("vibro-map.csv").is_file()


def test_csv_for_spreadsheets(run: Run) -> None:
    assert run(*TABLE, "-o", "nut", "--excel", "--decimal-comma", "-q").exit_code == 0
    content = Path("nut.csv").read_bytes()
    assert content.startswith(b"\xef\xbb\xbfamplitude_mm;frequency_hz;")
    assert b"\n0,5;10;20;0,74;0,57;0;no-slip;" in content
    assert b"\r" not in content
    stdout = run(*SMALL, "-o", "-", "--excel", "-q").stdout_bytes
    assert stdout.startswith(b"\xef\xbb\xbfamplitude_mm,")


@POSIX
@pytest.mark.parametrize("colour", [True, False])
def test_a_terminal_sees_progress_files_and_shares(tmp_path: Path, colour: bool) -> None:
    import pty

    ours, theirs = pty.openpty()
    environment = {name: value for name, value in os.environ.items() if name != "NO_COLOR"}
    environment |= {"TERM": "xterm-256color", "COLUMNS": "100"} | ({} if colour else {"NO_COLOR": "1"})
    args = ("map", *NUT, "-A", "0.5:4:300", "-o", "n")
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
    assert ("\x1b[38;5;" in text or "\x1b[3" in text) == colour
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
