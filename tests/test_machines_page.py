"""guide/machines.md says what the program says: kinds, the table of the worked feeder."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import NamedTuple

import pytest
from engines import two_way
from helpers.two_way_machines import Case, masses_of
from typer.testing import CliRunner

import vibro
from vibro.cli.app import app
from vibro.files.machines import machine_of
from vibro.files.toml_files import read_toml

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "guide" / "machines.md").read_text(encoding="utf-8")
FREQUENCIES = {"magnet": 50, "measured": 50, "unbalance": 25, "exciter": 25, "rod": 12, "crank": 10}
BODY = {"drive_angle": math.radians(20.0), "static_friction": 0.35, "kinetic_friction": 0.28}
SCENE = (
    "\n[scene]\nfrequency_hz = {}\ndrive_angle_deg = 20\nstatic_friction = 0.35\nkinetic_friction = 0.28\n"
)


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)```", PAGE, flags=re.DOTALL | re.MULTILINE)


def kind_of(table: str) -> str:
    return str(re.findall(r'^kind = "(\w+)"', table, flags=re.MULTILINE)[0])


def test_every_kind_is_shown() -> None:
    assert sorted(kind_of(table) for table in blocks("toml")) == sorted(FREQUENCIES)


@pytest.mark.parametrize("table", blocks("toml"), ids=kind_of)
def test_every_table_is_a_machine_of_a_size_that_is_built(table: str, tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(table + SCENE.format(FREQUENCIES[kind_of(table)]), encoding="utf-8")
    result = CliRunner().invoke(app, ["solve", str(file), "--json"])
    assert result.exit_code == 0, result.stderr
    machine = machine_of(read_toml(file)["machine"]).machine
    amplitude = float(machine.response(FREQUENCIES[kind_of(table)]).amplitude)
    assert 1e-4 < amplitude < 1e-2


class Cell(NamedTuple):
    """A cell of the table: f/f0, filling [kg], changes of speed, predicted and followed [%]."""

    ratio: float
    filling: float
    predicted: int
    followed: int


def cells() -> list[Cell]:
    found = []
    for ratio, *texts in re.findall(
        r"^\| \$f/f_0=([\d.]+)\$ \|(.*?)\|(.*?)\|(.*?)\|$", PAGE, flags=re.MULTILINE
    ):
        for filling, text in zip((1.0, 2.0, 4.0), texts, strict=True):
            numbers = [int(number.replace("−", "-")) for number in re.findall(r"[+−]\d+", text)]
            found.append(Cell(float(ratio), filling, *numbers))
    return found


def test_the_table_is_read() -> None:
    assert len(cells()) == 12


@pytest.mark.parametrize("cell", cells(), ids=lambda cell: f"{cell.ratio}, {cell.filling:g} kg")
def test_the_worked_feeder_does_what_the_table_says(cell: Cell) -> None:
    machine = vibro.Machine.magnet(
        trough_mass=6,
        counter_mass=12,
        natural_frequency=50.0 / cell.ratio,
        damping_ratio=0.015,
        calibration=vibro.Calibration(0.35e-3, 50.0),
    )
    full = Case("full", machine, 50.0, cell.filling, BODY)
    empty = vibro.Scene(amplitude=0.35e-3, frequency=50.0, **BODY)
    speed = float(vibro.solve(empty).mean_velocity)
    predicted = float(vibro.solve(full.operate().scene).mean_velocity) / speed - 1.0
    assert 100.0 * predicted == pytest.approx(cell.predicted, abs=0.501)
    followed = two_way.follow(masses_of(machine, 50.0), two_way.Body(mass=cell.filling, **BODY)).speed
    assert 100.0 * (followed / speed - 1.0) == pytest.approx(cell.followed, abs=0.501)
