"""``vibro solve`` prints the same numbers of a drive given as a line, as an ellipse or by harmonics."""

from __future__ import annotations

import json
import math
import re
from typing import TYPE_CHECKING, NamedTuple

import pytest
from helpers.commands import ELLIPSE, NUT

if TYPE_CHECKING:
    from pathlib import Path

    from helpers.commands import Run


class Case(NamedTuple):
    """A drive along a line at 15 Hz, whose body stays in contact, and what that does."""

    amplitude_mm: float
    drive_angle_deg: float
    static_friction: float
    kinetic_friction: float
    trough_angle_deg: float
    regime: str


CASES = (
    Case(0.5, 20, 0.74, 0.57, 0, "no-slip, pattern _"),
    Case(1, 20, 0.74, 0.57, 0, "forward-slip, pattern F_"),
    Case(1.25, 20, 0.74, 0.57, 0, "back-slip, pattern F_B_"),
    Case(1.5, 20, 0.74, 0.57, 0, "back-slip, pattern FB_"),
    Case(2.5, 20, 0.74, 0.57, 0, "back-slip, pattern FB"),
    Case(1, 36, 0.48, 0.37, 8, "back-slip, pattern F_B"),
    Case(0.8, 22, 0.29, 0.11, 6, "back-slip, pattern B_"),
)
RESULTS = ("regime", "mean speed", "peak speed", "per cycle", "acceleration", "throw number", "sensitivity")
NUMBERS = (
    "mean_velocity_mm_s", "displacement_per_cycle_mm", "peak_velocity_mm_s", "throw_number", "forward_ratio",
    "back_ratio", "acceleration_g",
)  # fmt: skip
# What each kind of drive says in words of its own, before a number and after it.
OWN_WORDS = re.compile(r"^.*amplitudes?: |(?<= g) .*| \(d ln .*")


def written(folder: Path, case: Case, kind: str) -> Path:
    """Write the scene file of a case with one kind of drive."""
    alpha = math.radians(case.drive_angle_deg)
    x, y = case.amplitude_mm * math.cos(alpha), case.amplitude_mm * math.sin(alpha)
    drive = {
        "line": f"amplitude_mm = {case.amplitude_mm}\ndrive_angle_deg = {case.drive_angle_deg}",
        "ellipse": f"along_amplitude_mm = {x!r}\nnormal_amplitude_mm = {y!r}\nnormal_phase_deg = 0",
        # of one harmonic alone a file is that of an ellipse
        "harmonics": f"along_amplitudes_mm = [{x!r}, 0]\nnormal_amplitudes_mm = [{y!r}, 0]",
    }[kind]
    file = folder / f"{kind}.toml"
    file.write_text(
        f"[scene]\n{drive}\nfrequency_hz = 15\nstatic_friction = {case.static_friction}\n"
        f"kinetic_friction = {case.kinetic_friction}\ntrough_angle_deg = {case.trough_angle_deg}\n",
        encoding="utf-8",
    )
    return file


def sections(run: Run, file: Path) -> list[list[str]]:
    """Return what is printed of a scene: results, beginnings, phases."""
    result = run("solve", file)
    assert (result.exit_code, result.stderr) == (0, "")
    return [section.splitlines() for section in result.stdout.split("\n\n")]


def results(lines: list[str]) -> dict[str, str]:
    """Return the results by their names, without what each kind of drive says in words of its own."""
    told = dict(re.split(r"  +", line, maxsplit=1) for line in lines)
    return {name: OWN_WORDS.sub("", told[name]) for name in RESULTS}


def beginnings(lines: list[str]) -> list[tuple[str, str, str]]:
    """Return name, load now over that load, and frequency of what begins; amplitudes are each drive's own."""
    rows = [re.split(r"  +", line) for line in lines[1:]]
    return [(row[0], row[1], row[-1]) for row in rows]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.regime)
def test_motions_are_the_same(run: Run, tmp_path: Path, case: Case) -> None:
    files = [written(tmp_path, case, kind) for kind in ("line", "ellipse", "harmonics")]
    line, ellipse, harmonics = (sections(run, file) for file in files)
    expected = results(line[0])
    assert expected["regime"] == case.regime
    assert all(re.search(r"\d", text) for name, text in expected.items() if name != "regime")
    assert results(ellipse[0]) == results(harmonics[0]) == expected
    assert line[-1][0].split() == ["phase", "start", "[ms]", "end", "[ms]", "displacement", "[mm]"]
    assert ellipse[-1] == harmonics[-1] == line[-1]
    known, *others = (json.loads(run("solve", file, "--json").stdout) for file in files)
    for other in others:
        for name in NUMBERS:
            assert other[name] == pytest.approx(known[name], rel=1e-12, abs=1e-300), name


@pytest.mark.parametrize(
    "case",
    CASES,
    ids=lambda case: case.regime,
)
def test_what_begins_is_the_same(run: Run, tmp_path: Path, case: Case) -> None:
    line, ellipse = (
        beginnings(sections(run, written(tmp_path, case, kind))[1]) for kind in ("line", "ellipse")
    )
    assert len(line) >= 3
    assert ellipse == line


@pytest.mark.parametrize(
    ("drive", "amplitudes", "near", "steps"),
    [
        (
            NUT,
            ("-A",),
            1e-5,
            {
                "forward slip": ("no-slip", "forward-slip"),
                "back slip": ("forward-slip", "back-slip"),
                "hopping": ("back-slip", "hopping"),
            },
        ),
        (
            ELLIPSE,
            ("along=", "normal="),
            1e-4,
            {"forward slip": ("no-slip", "forward-slip"), "hopping": ("back-slip", "hopping")},
        ),
    ],
    ids=["line", "ellipse"],
)
def test_each_regime_begins_where_the_report_says(
    run: Run,
    drive: tuple[str, ...],
    amplitudes: tuple[str, ...],
    near: float,
    steps: dict[str, tuple[str, str]],
) -> None:
    table = run("solve", *drive).stdout.split("\n\n")[1].splitlines()[1:]
    rows = {name: numbers for name, *numbers in (re.split(r"  +", line) for line in table)}
    for name, regimes in steps.items():
        _, sizes, frequency = rows[name]
        limits = [float(text) for text in re.findall(r"[\d.]+", sizes)]
        for factor, regime in zip((1.0 - near, 1.0 + near), regimes, strict=True):
            larger = [x for pair in zip(amplitudes, limits, strict=True) for x in (pair[0], factor * pair[1])]
            for given in (larger, ["-f", factor * float(frequency)]):
                assert json.loads(run("solve", *drive, *given, "--json").stdout)["regime"] == regime
