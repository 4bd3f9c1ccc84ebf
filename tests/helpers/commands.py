"""What the tests of the command line share."""

from __future__ import annotations

import csv
import io
import subprocess
import sys
from collections.abc import Callable
from itertools import chain
from pathlib import Path

import pytest
from typer.testing import Result

Run = Callable[..., Result]

NUT = ("-A", "1", "-f", "15", "-a", "20", "--mu-s", "0.74", "--mu-d", "0.57")
"""The paper's scene."""

NUT_FILE = """
[scene]
amplitude_mm = 1
frequency_hz = 15
drive_angle_deg = 20
static_friction = 0.74
kinetic_friction = 0.57
"""

STEPS_FILE = """[scene]
frequency_hz = 2.5
static_friction = 0.3
kinetic_friction = 0.25
trough_length_mm = 3000
[motion]
along_steps = [[0.8, 2.4], [0.2, -9.6]]
"""

NUT_ANGLE_AND_FRICTION = NUT[4:]

FRICTION = ("--mu-s", "0.4", "--mu-d", "0.3")

ELLIPSE = ("along=1", "normal=0.3", "phase=-60", "-f", "25", *FRICTION)

SMALL = ("map", "-A", "0.5:2:3", "-f", "10:30:3", *NUT_ANGLE_AND_FRICTION)
TABLE = ("traverse-time", *SMALL[1:], "-L", "600")
"""A table and its sidecar, without pictures, which take most of a small run's time."""

LONG = ("map", "-A", "0.1:3:3000", "-f", "5:60:3000", *NUT_ANGLE_AND_FRICTION)

VIBRO = (sys.executable, "-m", "vibro")
"""The program, in a process of its own."""

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals, limits and terminals")

TELLS_LOADED = (
    sys.executable,
    "-c",
    """
import atexit, sys

heavy = "numpy", "numpy.ma", "scipy", "pandas", "matplotlib", "rich", "pydantic"
heavy += "vibro.core.waves", "vibro.machines"
atexit.register(lambda: print("LOADED", [name for name in heavy if sys.modules.get(name)]))
from vibro.__main__ import main

main()
""",
)
"""The same, which prints in the end what it has loaded: libraries, or the source of the solver."""


def started(*args: str, cwd: Path, program: tuple[str, ...] = VIBRO) -> subprocess.Popen[str]:
    """Start the program."""
    return subprocess.Popen(
        [*program, *args],
        cwd=cwd, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


def other(scene: tuple[str, ...], *given: str) -> tuple[str, ...]:
    """Return a scene with some quantities, as options or NAME=VALUE, in place of those of the same names."""
    words: dict[str, tuple[str, ...]] = {}
    for one in (scene, given):
        rest = iter(one)
        for text in rest:
            words[text.partition("=")[0]] = (text, next(rest)) if text.startswith("-") else (text,)
    return tuple(chain(*words.values()))


def rows_of(text: str) -> list[dict[str, str]]:
    """Read a CSV as a user's script would."""
    return list(csv.DictReader(io.StringIO(text, newline="")))
