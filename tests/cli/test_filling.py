"""``vibro solve filling=``: what lies in a trough that moves as the scene says."""

from __future__ import annotations

import csv
import io
import json
from typing import TYPE_CHECKING

import pytest

import vibro
from vibro.cli.exit_codes import ExitCode

if TYPE_CHECKING:
    from pathlib import Path

    from helpers.commands import Run

FEEDER = ["-A", ".15", "-f", "50", "-a", "20", "--mu-s", ".35", "--mu-d", ".28"]
KEYS = {
    "filling_kg", "trough_mass_kg", "added_mass_share", "added_mass_share_error", "added_damping_share",
    "added_damping_share_error", "share_bound", "energy_per_cycle_j", "power_w", "second_harmonic_force_n",
    "given_motion_soft_mounts_percent", "given_motion_below_resonance_percent",
    "given_motion_above_resonance_percent",
}  # fmt: skip


def test_json_and_tables_have_the_same_numbers(run: Run, tmp_path: Path) -> None:
    args = "solve", *FEEDER, "filling=2000g", "trough_mass=6kg"
    told = json.loads(run(*args, "--json").stdout)
    assert set(told) >= KEYS
    assert set(json.loads(run("solve", *FEEDER, "--json").stdout)).isdisjoint(KEYS)
    scene = vibro.Scene(
        amplitude=0.15e-3, frequency=50, drive_angle=told["drive_angle_deg"] * 3.141592653589793 / 180.0,
        static_friction=0.35, kinetic_friction=0.28,
    )  # fmt: skip
    found = vibro.filling(scene)
    assert told["added_mass_share"] == pytest.approx(found.added_mass_share, rel=1e-13)
    assert told["energy_per_cycle_j"] == pytest.approx(2.0 * found.energy_per_cycle, rel=1e-12)
    assert told["power_w"] == pytest.approx(100.0 * found.energy_per_cycle, rel=1e-12)
    (row,) = csv.DictReader(io.StringIO(run(*args, "-o", "-").stdout))
    assert {name: float(row[name]) for name in KEYS} == {name: told[name] for name in KEYS}
    assert run(*args, "-o", tmp_path / "full").exit_code == ExitCode.DONE
    record = json.loads((tmp_path / "full.json").read_text(encoding="utf-8"))
    assert record["part"] == {"filling_kg": 2.0, "trough_mass_kg": 6.0}
