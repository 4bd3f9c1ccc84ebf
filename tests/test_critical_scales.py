"""Critical loads and intervals of classes of motions beyond one harmonic."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.periodic_tables import read_rows, scene_of

import vibro
from vibro import Regime, Scene, Status
from vibro.drives import PiecewiseMotion
from vibro.limits import stays_upright, tipping_load

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

CLASSES = {
    "forward slip": lambda pattern: "F" in pattern,
    "back slip": lambda pattern: "B" in pattern,
    "continuous sliding": lambda pattern: "_" not in pattern,
}
ENDS = 1e-11
"""Relative, of the ends of intervals; the worst of 60 rows is 3e-12."""


def intervals(scene: Scene) -> dict[str, list[tuple[float, float]]]:
    """List the scales between which each class lasts."""
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in CLASSES}
    for t in vibro.transitions(scene):
        if t.name in found:
            found[t.name].append(t.scales)
    return found


def check_ends(scale: Any, most: float) -> int:
    """Solve inside and outside of each end of the intervals of ``scale(1)``; return how many there were."""
    found, count = intervals(scale(1.0)), 0
    for name, spans in found.items():
        for span in spans:
            for end, inwards in zip(span, (1.0, -1.0), strict=True):
                if end > most:
                    continue
                inside, outside = (
                    vibro.solve(scale(end * (1.0 + side * inwards * 1e-9))) for side in (1, -1)
                )
                assert inside.regime != Regime.HOPPING
                assert CLASSES[name](str(inside.pattern)), (name, end)
                assert outside.regime == Regime.HOPPING or not CLASSES[name](str(outside.pattern)), (
                    name,
                    end,
                )
                count += 1
    return count


# ------------------------------------------------------------------------------------------- harmonics


@each("row", read_rows("critical_scales"))
def test_the_table_of_critical_scales(row: dict[str, str]) -> None:
    scene = scene_of(row)
    loads, now = vibro.critical_loads(scene), float(scene.load)
    for name, column in (
        ("hop", "hop_scale"), ("forward_onset", "forward_onset_scale"), ("back_onset", "back_onset_scale"),
    ):  # fmt: skip
        assert float(getattr(loads, name)) / now == pytest.approx(float(row[column] or "inf"), rel=1e-13)
    for name, column in (("back_slip", "back_slip_scale"), ("continuous_sliding", "never_at_rest_scale")):
        assert float(getattr(loads, name)) / now == pytest.approx(float(row[column] or "inf"), rel=ENDS)
    for name, spans in intervals(scene).items():
        called = "never at rest" if name == "continuous sliding" else name  # in the reference table
        expected = [
            tuple(map(float, pair)) for pair in json.loads(row[f"{called.replace(' ', '_')}_intervals"])
        ]
        assert len(spans) == len(expected)
        for span, listed in zip(spans, expected, strict=True):
            assert span == pytest.approx(listed, rel=ENDS)
    # onsets that start no slide are told as loads
    names = [t.name for t in vibro.transitions(scene)]
    for way in ("forward", "back"):
        onset, first = (float(row[f"{way}_{name}_scale"] or "inf") for name in ("onset", "slip"))
        is_late = onset < float(row["hop_scale"]) and not math.isclose(onset, first, rel_tol=1e-9)
        assert (f"load for {way} slip" in names) == is_late
    assert names[-1] == "hopping"


def test_loads_do_not_depend_on_scale_frequency_and_gravity_and_broadcast() -> None:
    fields: dict[str, Any] = {
        "along_harmonics": [(1e-3, 0.0), (2e-4, 1.0)], "normal_harmonics": [(np.array([5e-4, 8e-4]), 0.4)],
        "static_friction": np.array([[0.3], [0.4], [0.5]]), "kinetic_friction": 0.25,
    }  # fmt: skip
    found = vibro.critical_loads(Scene(frequency=np.full((4, 1, 1), 20.0), **fields))
    other = vibro.critical_loads(Scene(frequency=55.0, gravity=1.62, motion_scale=3.0, **fields))
    for load, same in zip(found, other, strict=True):
        assert load.shape == (3, 2)
        np.testing.assert_allclose(load, same, rtol=1e-12)
    fields["normal_harmonics"], fields["static_friction"] = [(8e-4, 0.4)], 0.4
    one = vibro.critical_loads(Scene(frequency=20.0, **fields))
    assert [x[1, 1] for x in found] == [float(x) for x in one]


def test_what_has_no_critical_loads() -> None:
    fields: dict[str, Any] = {"along_harmonics": [(1e-3, 0.0), (2e-4, 1.0)], "frequency": 20.0}
    slippery = vibro.critical_loads(Scene(static_friction=0.0, kinetic_friction=0.0, **fields))
    assert all(math.isnan(load) for load in slippery)
    cannot_be = vibro.critical_loads(
        Scene.allowing_infeasible(static_friction=0.2, kinetic_friction=0.3, **fields)
    )
    assert all(math.isnan(load) for load in cannot_be)
    fields |= {"static_friction": 0.3, "kinetic_friction": 0.25}
    for angle, back in ((0.4, 0.0), (-0.4, math.inf)):  # steeper than static friction: it runs down
        loads = vibro.critical_loads(Scene(trough_angle=angle, **fields))
        found = loads.back_slip, loads.continuous_sliding, loads.hop
        assert list(map(float, found)) == [back, 0.0, math.inf]
    still = Scene(**(fields | {"along_harmonics": [(0.0, 0.0), (0.0, 0.0)]}))
    assert all(load == math.inf for load in vibro.critical_loads(still))
    assert vibro.transitions(still) == ()


# ---------------------------------------------------------------------------------------- pieces, clamps

SLIP_STICK = vibro.Motion.steps(along=[(0.8, 2.4), (0.2, -9.6)])


def conveyor(scale: float = 1.0, motion: vibro.Motion = SLIP_STICK, **others: Any) -> Scene:
    fields = {"frequency": 2.5, "static_friction": 0.3, "kinetic_friction": 0.25, **others}
    return Scene(motion=motion, motion_scale=scale, **fields)


def test_a_slip_stick_conveyor_of_steps() -> None:
    """Friction gives way where the acceleration is mu_s g; rest ends with the stretch that it held."""
    loads = vibro.critical_loads(conveyor())
    g, friction = 9.81, 0.3 * 9.81
    assert loads.forward_onset == pytest.approx(friction / g, rel=1e-14)
    assert loads.back_onset == pytest.approx(4.0 * friction / g, rel=1e-14)
    assert loads.hop == math.inf
    scales = [friction / 9.6, friction / 2.4]
    spans = intervals(conveyor())
    for name, first in zip(CLASSES, (scales[0], scales[1], scales[1]), strict=True):
        (span,) = spans[name]
        assert span == pytest.approx((first, math.inf), rel=1e-14)
    assert check_ends(conveyor, 1e5) == 3
    for scale, below, above in zip(scales, ("_", "F_"), ("F_", "FB"), strict=True):
        assert [str(vibro.solve(conveyor(scale * x)).pattern) for x in (1.0 - 1e-12, 1.0, 1.0 + 1e-12)] == [
            below, below, above,
        ]  # fmt: skip
    for t in vibro.transitions(conveyor()):
        assert math.isnan(t.frequency)
        assert t.end_ratio == 0.0
        assert t.loads == (t.load, math.inf)
        assert t.amplitude == pytest.approx(float(conveyor().reach) * t.scales[0], rel=1e-14)


# --------------------------------------------------------------------------------------------- tipping


@pytest.mark.parametrize("pieces", [False, True], ids=["harmonics", "samples"])
def test_the_load_at_which_an_edge_lifts(pieces: bool) -> None:
    random = np.random.default_rng(3)
    share = np.arange(100_000) / 100_000
    for _ in range(12):
        sizes, phases = random.uniform(1e-4, 5e-4, (2, 3)), random.uniform(0.0, 6.0, (2, 3))
        sizes[:, 0] += 5e-4
        motion = vibro.Motion.harmonics(
            *(list(zip(*x, strict=True)) for x in zip(sizes, phases, strict=True))
        )
        k, w = np.arange(1, 4)[:, None], 2.0 * math.pi * 20.0
        s, b = (
            np.sum(x[:, None] * (w * k) ** 2 * np.sin(2.0 * np.pi * k * share + xi[:, None]), axis=0)
            for x, xi in zip(sizes, phases, strict=True)
        )
        if pieces:
            motion = vibro.Motion.samples(along=-s[:: len(s) // 100], normal=-b[:: len(b) // 100])
            assert isinstance(motion, PiecewiseMotion)
            s, b = -motion.accelerations(share)
        angle, r = random.uniform(-0.1, 0.1), random.uniform(0.2, 0.4)
        n, t = 9.81 * math.cos(angle), 9.81 * math.sin(angle)
        first = min((r * n + t) / (s + r * b).max(), (r * n - t) / (r * b - s).max())

        def at(scale: float, motion: vibro.Motion = motion, angle: float = angle, **others: Any) -> Scene:
            fields = {"static_friction": 0.5, "kinetic_friction": 0.4, "trough_angle": angle, **others}
            return Scene(motion=motion, motion_scale=scale, frequency=20.0, **fields)

        found = float(tipping_load(at(1.0), r)) / float(at(1.0).load)
        assert found == pytest.approx(first, rel=1e-7)
        assert [int(stays_upright(at(found * x), r)) for x in (1.0 - 1e-9, 1.0 + 1e-9)] == [1, 0]
        assert tipping_load(at(1.0, static_friction=r, kinetic_friction=r), r) == math.inf
        assert tipping_load(at(1.0, trough_angle=math.atan(r) + 0.01), r) == 0.0


@pytest.mark.parametrize("side", [-1, 1], ids=["down the conveying way", "against it"])
@pytest.mark.parametrize("pieces", [False, True], ids=["harmonics", "steps"])
def test_a_body_that_runs_away_slides_one_way_from_its_onset_on(side: int, pieces: bool) -> None:
    """Between both frictions a body rests until it slips, and never again, whatever its first cycles are."""
    motion = vibro.Motion.harmonics(along=[(1e-3, 0.0), (2e-4, 1.0)], normal=[(1e-4, 0.3)])
    if pieces:
        motion = vibro.Motion.steps(along=[(0.4, 3.0), (0.6, -2.0)], normal=[(0.5, 1.0), (0.5, -1.0)])

    def at(scale: Any) -> Scene:
        friction = {"static_friction": 0.2, "kinetic_friction": 0.05, "trough_angle": side * 0.195}
        return Scene(motion=motion, motion_scale=scale, frequency=10.0, **friction)

    own, other = ("back slip", "forward slip") if side > 0 else ("forward slip", "back slip")
    found, loads = intervals(at(1.0)), vibro.critical_loads(at(1.0))
    onset = min(float(loads.forward_onset), float(loads.back_onset)) / float(at(1.0).load)
    hop = float(loads.hop) / float(at(1.0).load)
    assert found[other] == []
    for name in (own, "continuous sliding"):
        ((first, last),) = found[name]
        assert (first, last) == pytest.approx((onset, hop), rel=1e-12)
    cycle = vibro.solve(at(np.geomspace(onset * 1.001, hop * 0.999, 60)))
    assert set(cycle.status) == {Status.RUNAWAY}
    assert set(cycle.regime) == {Regime.BACK_SLIP if side > 0 else Regime.FORWARD_SLIP}


@pytest.mark.parametrize("harmonics", [1, 5, 16])
def test_a_few_ulp_above_an_onset_a_body_slips_or_rounding_decides(harmonics: int) -> None:
    """Rounding of many harmonics may hide a window that the largest load has opened."""
    rng, count = np.random.default_rng(harmonics), 1000
    k = np.arange(1, harmonics + 1)
    sizes = rng.uniform(0.0, 1e-4, (2, harmonics, count)) / (k**2)[:, None]
    phases = rng.uniform(-3.0, 3.0, (2, harmonics, count))
    along, normal = (list(zip(*x, strict=True)) for x in zip(sizes, phases, strict=True))
    static, motion = rng.uniform(0.2, 0.8, count), vibro.Motion.harmonics(along=along, normal=normal)

    def at(scale: Any) -> Scene:
        friction = {"static_friction": static, "kinetic_friction": 0.9 * static}
        return Scene(motion=motion, motion_scale=scale, frequency=15.0, **friction)

    begins = vibro.solve(at(1.0), flight=False)
    onset = 1.0 / np.maximum(begins.forward_ratio, begins.back_ratio)
    for ulps in (0, 4, 8, 9, 10, 16, 64):
        cycle = vibro.solve(at(onset * (1.0 + ulps * 2.0**-52)))
        assert set(cycle.status) <= {Status.OK, Status.BOUNDARY}
        assert set(cycle.status[cycle.pattern == "_"]) <= {Status.BOUNDARY}
        if ulps in (0, 64):
            assert set(cycle.status) == {Status.OK if ulps else Status.BOUNDARY}


def test_an_interval_a_thousandth_wide_is_found_amid_a_step() -> None:
    along = [
        (0.00084053, -0.65019661), (0.00019971, 2.19125973), (9.12186168e-06, 2.0820522),
        (4.2724601e-05, -1.14157344), (1.91164182e-05, 2.8320665), (1.07262116e-05, -1.52844219),
        (2.01760851e-05, -3.07228796), (7.59881662e-06, -1.07080817),
    ]  # fmt: skip
    normal = [
        (6.96200754e-06, 1.74286225), (1.49235296e-06, 2.34180824), (1.18309205e-06, 0.90958532),
        (5.45651682e-07, -1.83783158), (9.11899814e-07, -1.50991417), (4.06431606e-07, -0.7194717),
        (1.58207654e-07, 0.95494859), (2.68993237e-07, -2.68588552),
    ]  # fmt: skip
    friction = {"static_friction": 0.6773332963983565, "kinetic_friction": 0.6578788625919502}

    def at(scale: float) -> Scene:
        return Scene(
            along_harmonics=along, normal_harmonics=normal, motion_scale=scale, frequency=20.0, **friction
        )

    spans = intervals(at(1.0))["continuous sliding"]
    assert [low for low, _ in spans] == pytest.approx([1.2269, 3.2437, 3.9166], rel=1e-4)
    assert spans[1][1] == pytest.approx(3.2462, rel=1e-4)
    assert check_ends(at, 10.0) == 7
