"""Drives with harmonics: symmetries, statuses, other motions."""

from __future__ import annotations

import contextlib
import itertools
import math
from typing import Any

import numpy as np
import pytest
from helpers.harmonics import drive_of, random_harmonics
from helpers.periodic_tables import least_rotation

import vibro
from vibro import Regime, Scene, Status, solve
from vibro.core.compiled import doors

TURN = 2.0 * math.pi
SWAPPED = str.maketrans("FB", "BF")


def scene(
    along: tuple[float, ...] = (1.0, 0.0),
    across: tuple[float, ...] = (0.0, 0.0),
    frictions: tuple[float, float] = (0.4, 0.3),
    beta: float = 0.0,
    phases: tuple[float, ...] = (0.0, 0.0),
) -> Scene:
    """Make one scene of amplitudes in g/w^2."""
    return Scene(
        along_harmonics=list(zip(along, phases, strict=True)),
        normal_harmonics=[(size, 0.0) for size in across],
        frequency=1.0 / TURN,
        static_friction=frictions[0],
        kinetic_friction=frictions[1],
        trough_angle=beta,
        gravity=1.0,
    )


def replaced(drawn: Scene, **values: Any) -> Scene:
    """Change fields of a scene with harmonics."""
    names = ("frequency", "static_friction", "kinetic_friction", "trough_angle", "gravity")
    kept: dict[str, Any] = {name: getattr(drawn, name) for name in names}
    kept |= {"along_harmonics": drawn.along_harmonics, "normal_harmonics": drawn.normal_harmonics}
    return Scene(**(kept | values))


@pytest.mark.parametrize("harmonics", [2, 3, 8])
def test_mirrored_scenes_move_the_other_way(harmonics: int) -> None:
    """The motion along the trough is turned round, that off it stays; in contact and above it."""
    count = 200 if doors().compiled else 40
    drawn = random_harmonics(count, 6, harmonics)
    assert drawn.along_harmonics is not None
    turned = replaced(
        drawn,
        along_harmonics=[(size, phase + math.pi) for size, phase in drawn.along_harmonics],
        trough_angle=-np.asarray(drawn.trough_angle),
    )
    here, there = solve(drawn, starts=16), solve(turned, starts=16)
    assert np.array_equal(here.status, there.status)
    known = (here.status == Status.OK) & (here.throw_number <= 1.0)
    assert known.sum() > count // 4
    assert np.array_equal(here.coexists[known], there.coexists[known])
    size = np.asarray(drawn.scale) + np.abs(here.displacement_per_cycle)
    off = np.abs(here.displacement_per_cycle + there.displacement_per_cycle) / size
    assert off[known].max() < 1e-12
    # among motions of bodies that hop, errors grow from landing to landing
    hops = (here.status == Status.OK) & (here.throw_number > 1.0)
    assert hops.sum() > count // 10
    assert np.quantile(off[hops], 0.98) < 1e-11
    ratios = np.abs(here.forward_ratio - there.back_ratio) / (1.0 + here.forward_ratio)
    assert ratios.max() < 1e-13
    texts = ([str(x) for x in cycle.pattern[known]] for cycle in (here, there))
    assert all(
        least_rotation(a.translate(SWAPPED)) == least_rotation(b) for a, b in zip(*texts, strict=True) if a
    )


def test_odd_harmonics_along_a_level_trough_convey_nothing() -> None:
    drawn = random_harmonics(500, 7, 3, along_only=True, steep=0.0)
    assert drawn.along_harmonics is not None
    first, _, third = drawn.along_harmonics
    cycle = solve(replaced(drawn, along_harmonics=[first, (0.0, 0.0), third]), starts=16)
    slips = cycle.regime != Regime.NO_SLIP
    assert slips.sum() > 200
    # but for cycles that are no mirror image of themselves: the mirrored one is another
    alone = slips & (cycle.coexists == 0)
    assert alone.sum() > 200
    off = np.abs(cycle.displacement_per_cycle) / np.maximum(first[0], third[0])
    assert off[alone].max() < 1e-13


@pytest.mark.parametrize(
    ("made", "status", "regime", "pattern"),
    [
        (scene(along=(0.3, 0.0)), Status.OK, Regime.NO_SLIP, "_"),
        (scene(along=(0.4, 0.0)), Status.BOUNDARY, Regime.NO_SLIP, "_"),
        (scene(along=(0.0, 0.0)), Status.OK, Regime.NO_SLIP, "_"),
        (scene(across=(1.0, 0.0)), Status.BOUNDARY, Regime.BACK_SLIP, "FB"),
        (scene(frictions=(0.0, 0.0)), Status.INDETERMINATE, Regime.UNDEFINED, ""),
        (scene(beta=0.5), Status.RUNAWAY, Regime.BACK_SLIP, ""),
        (scene(beta=-0.5), Status.RUNAWAY, Regime.FORWARD_SLIP, ""),
        (scene(beta=0.35), Status.RUNAWAY, Regime.BACK_SLIP, ""),
    ],
)
def test_statuses(made: Scene, status: Status, regime: Regime, pattern: str) -> None:
    cycle = solve(made)
    assert (Status(int(cycle.status)), Regime(int(cycle.regime))) == (status, regime)
    assert str(cycle.pattern) == pattern
    assert bool(np.isnan(cycle.displacement_per_cycle)) == (pattern == "")


def test_other_cycles_are_told_where_bodies_reach_them() -> None:
    drawn = random_harmonics(400, 11, ratio=(0.05, 0.3), along_only=True, steep=0.0)
    found = vibro.solve(drawn, starts=16)
    slips = (found.status == Status.OK) & (found.regime != Regime.NO_SLIP)
    for told in (0, 1):
        several = 0
        cells = np.flatnonzero(slips & (found.coexists == told))[:3]
        for i in cells:
            drive = drive_of(drawn, int(i))
            ends = {round(float(found.displacement_per_cycle[i]), 6)}
            for phase, way in itertools.product(np.linspace(0.0, TURN, 5)[:-1], (1, -1)):
                if drive.speed(way, float(phase), float(phase) + 1e-3) <= 0.0:
                    continue
                with contextlib.suppress(ArithmeticError):  # a walk that settles too slowly decides nothing
                    ends.add(round(drive.settle(400, float(phase), way).displacement, 6))
            several += len(ends) > 1
        assert cells.size == 3
        assert several == 0 if told == 0 else several >= 2
