"""Restitution: every answer about parts that hop says which one it was made with; guide/restitution."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest
from helpers.commands import Run, rows_of

import vibro

PAGE = (Path(__file__).parents[2] / "docs" / "guide" / "restitution.md").read_text(encoding="utf-8")
HOPS = ("-A", "2", "-f", "20", "-a", "30", "--mu-s", "0.5", "--mu-d", "0.4")


def test_the_page_tells_the_speeds_of_its_command(run: Run) -> None:
    restitutions, speeds = (
        [cell.strip() for cell in re.findall(r"\|([^|]+)(?=\|)", line)[1:]]
        for line in PAGE.splitlines()
        if line.startswith(("| $e$", "| mean speed"))
    )
    (command,) = re.findall(r"vibro (map .*) -o", PAGE)
    rows = rows_of(run(*command.split(), "-o", "-").stdout)
    assert [row["restitution"] for row in rows] == restitutions
    for row, told in zip(rows, speeds, strict=True):
        speed, *error = (float(number) for number in told.split(" ± "))
        assert float(row["mean_velocity_mm_s"]) == pytest.approx(speed, abs=0.05)
        assert float(row["mean_velocity_error_mm_s"]) == pytest.approx(sum(error), abs=0.05)


def test_a_mean_that_a_cycle_ends_says_so(run: Run) -> None:
    scene = vibro.Scene(
        amplitude=2e-3, frequency=20, drive_angle=math.radians(30), static_friction=0.5, kinetic_friction=0.4,
        restitution=0.5,
    )  # fmt: skip
    (one,) = vibro.attractors(scene)
    assert vibro.solve(scene).status == vibro.Status.AVERAGED
    told = run("solve", *HOPS, "--restitution", "0.5").stdout.splitlines()
    speeds = f"100 % {1e3 * one.mean_velocity:.3g} mm/s (released at the start of a cycle: "
    assert told[0].startswith(f"of parts laid down at random: {speeds}")
