"""``vibro solve`` prints the same numbers of a drive given as a line, as an ellipse or by harmonics."""

from __future__ import annotations

import json
import math
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
    Case(0.5, 20, 0.74, 0.57, 0, "no-slip"),
    Case(1, 20, 0.74, 0.57, 0, "forward-slip"),
    Case(1.25, 20, 0.74, 0.57, 0, "back-slip"),
    Case(1.5, 20, 0.74, 0.57, 0, "back-slip"),
    Case(2.5, 20, 0.74, 0.57, 0, "back-slip"),
    Case(1, 36, 0.48, 0.37, 8, "back-slip"),
    Case(0.8, 22, 0.29, 0.11, 6, "back-slip"),
)
NUMBERS = (
    "mean_velocity_mm_s", "displacement_per_cycle_mm", "peak_velocity_mm_s", "throw_number", "forward_ratio",
    "back_ratio", "acceleration_g",
)  # fmt: skip


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


@pytest.mark.parametrize("case", CASES)
def test_motions_and_what_begins_are_the_same(run: Run, tmp_path: Path, case: Case) -> None:
    files = [written(tmp_path, case, kind) for kind in ("line", "ellipse", "harmonics")]
    known, *others = (json.loads(run("solve", file, "--json").stdout) for file in files)
    assert known["regime"] == case.regime
    assert len(known["beginnings"]) >= 3
    for other in others:
        for name in ("regime", "pattern"):
            assert other[name] == known[name]
        for name in NUMBERS:
            assert other[name] == pytest.approx(known[name], rel=1e-12, abs=1e-300), name
    for name in ("times_the_drive", "frequency_hz"):
        ends = [[row[name] for row in x["beginnings"]] for x in (known, others[0])]
        assert ends[0] == pytest.approx(ends[1], rel=1e-9)
    for other in others:
        for one, same in zip(known["phases"], other["phases"], strict=True):
            assert same["phase"] == one["phase"]
            assert same["end_ms"] == pytest.approx(one["end_ms"], rel=1e-9)


@pytest.mark.parametrize(
    ("drive", "sizes", "near", "steps"),
    [
        (
            NUT,
            ("amplitude",),
            1e-5,
            {
                "forward slip": ("no-slip", "forward-slip"),
                "back slip": ("forward-slip", "back-slip"),
                "hopping": ("back-slip", "hopping"),
            },
        ),
        (
            ELLIPSE,
            ("along_amplitude", "normal_amplitude"),
            1e-4,
            {"forward slip": ("no-slip", "forward-slip"), "hopping": ("back-slip", "hopping")},
        ),
    ],
    ids=["line", "ellipse"],
)
def test_each_regime_begins_where_the_report_says(
    run: Run,
    drive: tuple[str, ...],
    sizes: tuple[str, ...],
    near: float,
    steps: dict[str, tuple[str, str]],
) -> None:
    known = json.loads(run("solve", *drive, "--json").stdout)
    rows = {row["begins"]: row for row in known["beginnings"]}
    for name, regimes in steps.items():
        times, frequency = rows[name]["times_the_drive"], rows[name]["frequency_hz"]
        limits = [times * known[f"{amplitude}_mm"] for amplitude in sizes]
        for factor, regime in zip((1.0 - near, 1.0 + near), regimes, strict=True):
            larger = [f"{x}={factor * limit!r}" for x, limit in zip(sizes, limits, strict=True)]
            others = (
                drive[2:] if drive is NUT else [text for text in drive if text[:4] not in ("alon", "norm")]
            )
            for given in ((*others, *larger), (*drive, "-f", repr(factor * frequency))):
                assert json.loads(run("solve", *given, "--json").stdout)["regime"] == regime
