"""The steady solve of drives with harmonics: limits, symmetries, statuses."""

from __future__ import annotations

import contextlib
import itertools
import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.harmonics import drawn, drive_of, solved

import vibro
from vibro.core.codes import Pattern, Regime, Status, pattern_texts
from vibro.core.harmonic.arrays import each, largest_amplitude
from vibro.core.harmonic.legs import harmonic_legs
from vibro.core.harmonic.loads import HarmonicLoads, harmonic_loads

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


def scene_at(loads: HarmonicLoads, cell: int) -> HarmonicLoads:
    """Select one scene."""
    one: HarmonicLoads = each(loads, lambda x: x.take([cell]) if x.ndim else x)
    return one


SWAPPED = str.maketrans("FB", "BF")


def scene(
    along: tuple[float, ...] = (1.0, 0.0),
    across: tuple[float, ...] = (0.0, 0.0),
    frictions: tuple[float, float] = (0.4, 0.3),
    beta: float = 0.0,
    phases: tuple[float, ...] = (0.0, 0.0),
) -> HarmonicLoads:
    """Make one scene of amplitudes in g/w^2."""

    def arrays(numbers: tuple[float, ...]) -> tuple[Floats, ...]:
        return tuple(np.array([x]) for x in numbers)

    none = arrays((0.0,) * len(across))
    f = np.array([1.0 / (2.0 * np.pi)])
    mu_s, mu_d = arrays(frictions)
    return harmonic_loads(
        arrays(along), arrays(phases), arrays(across), none, f, mu_s, mu_d, np.array([beta]), np.ones(())
    )


@pytest.mark.parametrize("harmonics", [1, 2, 3])
def test_one_harmonic_is_the_linear_drive(harmonics: int) -> None:
    count = 3000
    rng = np.random.default_rng(3)
    alpha = rng.uniform(0.0, 1.3, count)
    static = rng.uniform(0.1, 1.0, count)
    kinetic = static * rng.uniform(0.05, 1.0, count)
    beta = 0.98 * np.arctan(static) * rng.uniform(-1.0, 1.0, count) * (rng.uniform(size=count) < 0.5)
    beta = np.minimum(beta, 0.49 * np.pi - alpha)
    size = np.exp(rng.uniform(np.log(0.1), np.log(8.0), count))
    f = np.full(count, 1.0 / (2.0 * np.pi))
    wanted = vibro.solve(
        vibro.Scene(
            amplitude=size, frequency=f, drive_angle=alpha, static_friction=static, kinetic_friction=kinetic,
            trough_angle=beta, gravity=1.0,
        ),
        flight=False,
    )  # fmt: skip
    none = (np.zeros(()),) * (harmonics - 1)
    along, across = (size * np.cos(alpha), *none), (size * np.sin(alpha), *none)
    phases = (np.zeros(()),) * harmonics
    loads = harmonic_loads(along, phases, across, phases, f, static, kinetic, beta, np.ones(()))
    out = solved(loads, count)
    scale = largest_amplitude(*along, *across) / size
    names = {"status": "status", "regime": "regime", "pattern": "pattern_code", "coexists": "coexists"}
    for name, attribute in names.items():
        assert np.array_equal(getattr(out, name), getattr(wanted, attribute)), name
    assert len(set(out.pattern)) == len(Pattern)
    displacement, peak = wanted.displacement_per_cycle / size, wanted.peak_velocity / size
    known = ~np.isnan(displacement)
    assert np.array_equal(known, ~np.isnan(out.displacement))
    for found, true, tolerance in ((out.displacement, displacement, 2e-12), (out.peak, peak, 1e-13)):
        assert np.abs(found * scale - true)[known].max() < tolerance
    for name in ("throw_number", "forward_ratio", "back_ratio"):
        got, true = getattr(out, name), getattr(wanted, name)
        finite = np.isfinite(true)
        assert np.array_equal(finite, np.isfinite(got)), name
        assert np.max(np.abs(got - true)[finite] / (1.0 + true[finite])) < 1e-14


@pytest.mark.parametrize("harmonics", [2, 3])
def test_mirrored_scenes_move_the_other_way(harmonics: int) -> None:
    # the push is turned round, the load off the trough stays
    count = 600
    loads = drawn(count, 6, harmonics)
    turned = loads._replace(
        along_sine=tuple(-x for x in loads.along_sine),
        along_cosine=tuple(-x for x in loads.along_cosine),
        tangential=-loads.tangential,
    )
    here, there = solved(loads, count), solved(turned, count)
    assert np.array_equal(here.status, there.status)
    assert np.array_equal(here.coexists, there.coexists)
    known = here.status == Status.OK
    assert known.sum() > 300
    assert np.max(np.abs(here.displacement + there.displacement)[known]) < 1e-12
    assert np.array_equal(here.forward_ratio, there.back_ratio)

    def turned_text(text: str) -> str:
        swapped = text.translate(SWAPPED)
        order = str.maketrans("FB_", "123")
        return min((swapped[i:] + swapped[:i] for i in range(len(swapped))), key=lambda t: t.translate(order))

    ours, theirs = (pattern_texts(x.pattern[known]).tolist() for x in (here, there))
    assert all(turned_text(a) == b for a, b in set(zip(ours, theirs, strict=True)))


def test_odd_harmonics_along_a_level_trough_convey_nothing() -> None:
    count = 500
    loads = drawn(count, 7, 3, along_only=True, steep=0.0)
    zero = np.zeros(count)
    loads = loads._replace(
        along_sine=(loads.along_sine[0], zero, loads.along_sine[2]),
        along_cosine=(loads.along_cosine[0], zero, loads.along_cosine[2]),
    )
    out = solved(loads, count)
    slips = out.pattern > Pattern.R
    assert slips.sum() > 200
    # but for cycles that are no mirror image of themselves: the mirrored one is another
    alone = slips & (out.coexists == 0)
    assert alone.sum() > 200
    assert np.max(np.abs(out.displacement[alone])) < 1e-13


def test_statuses() -> None:
    cases = [
        (scene(along=(0.3, 0.0)), Status.OK, Regime.NO_SLIP, "_"),
        (scene(along=(0.4, 0.0)), Status.BOUNDARY, Regime.NO_SLIP, "_"),
        (scene(along=(0.0, 0.0)), Status.OK, Regime.NO_SLIP, "_"),
        (scene(across=(0.5, 0.3)), Status.FLIGHT_NOT_MODELLED, Regime.HOPPING, ""),
        (scene(across=(1.0, 0.0)), Status.BOUNDARY, Regime.BACK_SLIP, "FB"),
        (scene(frictions=(0.3, 0.4)), Status.INFEASIBLE, Regime.UNDEFINED, ""),
        (scene(frictions=(0.0, 0.0)), Status.INDETERMINATE, Regime.UNDEFINED, ""),
        (scene(beta=0.5), Status.RUNAWAY, Regime.BACK_SLIP, ""),
        (scene(beta=-0.5), Status.RUNAWAY, Regime.FORWARD_SLIP, ""),
        (scene(beta=0.35), Status.RUNAWAY, Regime.BACK_SLIP, ""),
    ]
    for loads, status, regime, text in cases:
        out = solved(loads, 1)
        assert (Status(out.status[0]), Regime(out.regime[0])) == (status, regime)
        assert pattern_texts(out.pattern).tolist() == [text]
        assert np.isnan(out.displacement[0]) == (text == "")
        assert out.coexists[0] == (0 if text else -1)


def test_onsets_just_below_at_and_just_above() -> None:
    # the second harmonic alone opens two windows each way at once
    for size, status, pattern in (
        (1.0 - 1e-9, Status.OK, "_"),
        (1.0, Status.BOUNDARY, "_"),
        (1.0 + 1e-9, Status.OK, "F_B_F_B_"),
    ):
        out = solved(scene(along=(0.0, size * 0.1)), 1)
        assert Status(out.status[0]) is status
        assert pattern_texts(out.pattern).tolist() == [pattern]
        assert abs(out.forward_ratio[0] - size) < 1e-15


def test_hopping_just_below_at_and_just_above() -> None:
    for size, status in (
        (1.0 - 1e-9, Status.OK),
        (1.0, Status.BOUNDARY),
        (1.0 + 1e-9, Status.FLIGHT_NOT_MODELLED),
    ):
        out = solved(scene(across=(0.0, 0.25 * size)), 1)
        assert Status(out.status[0]) is status
        assert abs(out.throw_number[0] - size) < 1e-15


def test_rest_at_phase_0_inside_a_window_slides_at_once() -> None:
    loads = scene(along=(1.0, 0.2), phases=(0.5 * math.pi, 0.0))
    drive, weight = drive_of(loads, 0)
    assert drive.begins(1, 0.0) > 0.0
    cycle = drive.settle()
    out = solved(loads, 1)
    assert pattern_texts(out.pattern).tolist() == [cycle.pattern]
    assert abs(out.displacement[0] - cycle.displacement * weight) < 1e-9


def test_legs_follow_each_other_for_a_turn() -> None:
    count = 60
    loads = drawn(count, 10)
    out = solved(loads, count)
    texts = pattern_texts(out.pattern).tolist()
    for i in range(count):
        legs = harmonic_legs(scene_at(loads, i))
        assert "".join(leg.kind for leg in legs) == texts[i]
        if not legs:
            continue
        assert 0.0 <= legs[0].start < 2.0 * math.pi
        assert abs(legs[-1].end - legs[0].start - 2.0 * math.pi) < 1e-12
        for leg, following in itertools.pairwise(legs):
            assert leg.end == following.start
            assert leg.end > leg.start
        assert abs(sum(leg.displacement for leg in legs) - out.displacement[i]) < 1e-14 * len(legs)


def test_other_cycles_are_told_where_bodies_reach_them() -> None:
    count = 400
    loads = drawn(count, 11, ratio=(0.05, 0.3), along_only=True, steep=0.0)
    out = solved(loads, count)
    slips = (out.status == Status.OK) & (out.pattern > Pattern.R)
    for told in (0, 1):
        several = 0
        cells = np.flatnonzero(slips & (out.coexists == told))[:6]
        for i in cells:
            drive, weight = drive_of(loads, int(i))
            ends = {round(float(out.displacement[i]), 6)}
            for phase, way in itertools.product(np.linspace(0.0, 2.0 * math.pi, 9)[:-1], (1, -1)):
                if drive.speed(way, float(phase), float(phase) + 1e-3) <= 0.0:
                    continue
                with contextlib.suppress(ArithmeticError):  # a walk that settles too slowly decides nothing
                    ends.add(round(drive.settle(400, float(phase), way).displacement * weight, 6))
            several += len(ends) > 1
        assert cells.size == 6
        assert several == 0 if told == 0 else several >= 4
