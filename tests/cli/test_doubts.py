"""Values that are possible but likely slips of units are questioned on stderr, once a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from helpers.cases import each

if TYPE_CHECKING:
    from helpers.commands import Run

EXAMPLES = Path(__file__).parents[2] / "examples"
SENSORS = ("--trough-along", "Trog längs", "--trough-normal", "Trog normal", "--sensitivity", "100mV/g")


def warnings(stderr: str) -> list[str]:
    return [line.removeprefix("warning: ") for line in stderr.splitlines() if line.startswith("warning: ")]


@each(
    "args",
    [
        ("map", "odd.toml", "-A", "0.5:2:3", "-f", "10:30:3", "-o", "-"),
        ("simulate", "odd.toml"),
        ("traverse-time", "odd.toml"),
        ("measure", "odd.toml", EXAMPLES / "data" / "nut_smoothed_600hz.csv"),
        ("measure", "odd.toml", EXAMPLES / "data" / "nut_trough_mv.csv", *SENSORS),
    ],
)
def test_every_command_questions_what_it_reads(run: Run, args: tuple[object, ...]) -> None:
    Path("odd.toml").write_text(
        "[scene]\namplitude_mm = 1\nfrequency_hz = 15\ndrive_angle_deg = 20\nstatic_friction = 74\n"
        "kinetic_friction = 0.5\ntrough_length_mm = 600\n"
    )
    result = run(*args)
    found = [text for text in warnings(result.stderr) if "usual" in text]
    assert found == ["static friction = 74 is above what is usual, 2: for 74 % write 0.74"], result.stderr
