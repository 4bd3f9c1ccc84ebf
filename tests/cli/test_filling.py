"""``vibro solve --filling``: what lies in a trough that moves as the scene says."""

from __future__ import annotations

import csv
import io
import json
from typing import TYPE_CHECKING

import pytest
from helpers.cases import each
from helpers.commands import NUT

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


def lines_of(stdout: str) -> list[str]:
    """Return the lines about the filling."""
    lines = stdout.split("\n\n")[0].splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("filling"))
    return [" ".join(line.split()) for line in lines[first:]]


def test_shares_energy_and_what_the_given_motion_is_good_for_are_told(run: Run) -> None:
    result = run("solve", *FEEDER, "--filling", "2kg", "--trough-mass", "6kg")
    assert result.exit_code == ExitCode.DONE
    filling, energy, force, first, *others = lines_of(result.stdout)
    assert filling == (
        "filling 2 kg: acts as 0.338842 kg of added mass (share 0.169421) and 0.426865 kg of added damping"
        " (share 0.213433)"
    )
    assert energy == "energy lost 0.00297799 J a cycle, 0.148899 W"
    assert force == "force at 2 f 2.49717 N on the trough"
    assert first.startswith(
        "given motion good to 1 % of speed up to 3.1 % of the trough's mass, 0.19 kg (exceeded)"
    )
    assert [line.split(" kg")[0] for line in others[:2]] == [
        "1.3 % of the trough's mass, 0.08", "0.46 % of the trough's mass, 0.028"
    ]  # fmt: skip
    assert others[2] == "this filling changes the motion itself: describe its machine in a table [machine]"


def test_a_single_part_leaves_the_motion_as_given(run: Run) -> None:
    result = run("solve", *FEEDER, "--filling", "20g", "--trough-mass", "6kg")
    assert "exceeded" not in result.stdout
    assert "changes the motion" not in result.stdout


def test_the_mass_of_the_trough_may_be_unknown(run: Run) -> None:
    result = run("solve", *NUT, "--filling", "2kg")
    told = lines_of(result.stdout)
    assert told[3].startswith("given motion good to 1 % of speed up to 0.3 % of the trough's mass: unbalance")
    assert "exceeded" not in result.stdout


def test_json_and_tables_have_the_same_numbers(run: Run, tmp_path: Path) -> None:
    args = "solve", *FEEDER, "--filling", "2000g", "--trough-mass", "6kg"
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


@each(
    ("args", "told"),
    [
        ("-A .1 -f 15", "given motion the part rests: it moves with the trough"),
        ("-A 12 -f 15 --restitution .6", "given motion unknown: the motion is irregular"),
        ("-A 8 -f 15 --flight off", "filling 2 kg: unknown, as the motion is"),
        ("-A 3.2291 -f 15", "given motion unknown: the regime changes within 1 % of amplitude"),
    ],
)
def test_what_is_unknown_is_said(run: Run, args: str, told: str) -> None:
    result = run(
        "solve",
        *args.split(),
        *["-a", "20", "--mu-s", ".74", "--mu-d", ".57", "--filling", "2kg", "--trough-mass", "6"],
    )
    assert result.exit_code == ExitCode.DONE
    assert any(told in line for line in lines_of(result.stdout))


@each(
    ("args", "message"),
    [
        (("--trough-mass", "6kg"), "error: --trough-mass: there is no filling\nhint: add --filling 2kg\n"),
        (("--filling", "2m"), "error: filling = '2m': 'm' is no unit of filling"),
        (("--filling", "-1kg"), "error: filling = -1kg: must be finite and >= 0 kg"),
        (("--filling", "2kg", "--trough-mass", "0"), "error: trough mass = 0: must be finite and > 0 kg"),
        (("--filling", "2kg", "--speed", "10"), "error: --speed lists amplitudes: --filling cannot be used"),
    ],
)
def test_what_makes_no_sense_is_refused(run: Run, args: tuple[str, ...], message: str) -> None:
    result = run("solve", *NUT, *args)
    assert result.exit_code == ExitCode.WRONG_INPUT
    assert result.stderr.startswith(message)


def test_drives_with_harmonics_are_refused(run: Run) -> None:
    drive = ["--along", "1", "--normal", ".6", "--along-2", ".3", "-f", "20", "--mu-s", ".4", "--mu-d", ".3"]
    result = run("solve", *drive, "--filling", "2kg")
    assert result.exit_code == ExitCode.WRONG_INPUT
    assert "drive = with harmonics: must be along a line or an ellipse" in result.stderr


def test_means_over_irregular_motion_have_errors(run: Run) -> None:
    args = [*NUT, "-A", "12", "--restitution", ".6", "--filling", "2kg"]
    filling = lines_of(run("solve", *args).stdout)[0]
    assert filling.count("(standard error)") == 2
    told = json.loads(run("solve", *args, "--json").stdout)
    assert told["status"] == "averaged"
    assert 0.0 < told["added_mass_share_error"] < 0.05
    assert 0.0 < told["added_damping_share_error"] < told["added_damping_share"] < told["share_bound"]
