"""Guarantees over boxes of bands: never beaten by a sample, and where corners are not enough."""

from __future__ import annotations

import math
from typing import Any
from unittest import mock

import numpy as np
import pytest
from helpers.boxed import Boxed, boxes, tolerance
from helpers.draws import examples
from helpers.scenes import replaced, scene_with
from hypothesis import given
from hypothesis import strategies as st

import vibro
from vibro import Regime, Status
from vibro.designs import guarantees, proofs
from vibro.designs.guarantees import BRIEF, Seen, bound
from vibro.designs.proofs import back_slip_load, slowest_in_contact
from vibro.designs.spaces import uncertainty_set
from vibro.limits import critical_loads
from vibro.results.designs import Guarantee

BANDED = (
    "amplitude", "frequency", "drive_angle", "static_friction", "kinetic_friction", "trough_angle",
)  # fmt: skip


def deg(low: float, high: float) -> tuple[float, float]:
    return math.radians(low), math.radians(high)


def about(value: float, percent: float) -> tuple[float, float]:
    return value * (1 - percent / 100), value * (1 + percent / 100)


def at(place: Any, factor: float = 1.0) -> float:
    """Solve where a guarantee says that an end is, its amplitude times a factor."""
    fields = dict(place)
    fields["amplitude"] *= factor
    return float(vibro.solve(vibro.Scene(**fields)).mean_velocity)


def assert_not_beaten(box: Boxed, found: Guarantee) -> None:
    """Compare with samples of the box, and with the places that are said to have the ends."""
    cycle = box.samples()
    assert found.speed_min <= found.found_min
    assert found.speed_min <= np.min(cycle.mean_velocity)
    assert np.max(cycle.mean_velocity) <= found.speed_max
    assert found.found_max <= found.speed_max
    slack = tolerance(found)
    low, high = found.found_min, found.found_max
    assert low - slack * abs(low) <= np.min(cycle.mean_velocity)
    assert np.max(cycle.mean_velocity) <= high + slack * abs(high)
    assert {Regime(code) for code in np.unique(cycle.regime)} <= found.regimes
    for end, place, limit in ((low, found.min_at, found.min_limit), (high, found.max_at, found.max_limit)):
        sides = [1 - 1e-9, 1 + 1e-9] if limit else [1.0]
        assert min(abs(at(place, side) - end) for side in sides) <= 1e-4 * abs(end) * bool(limit)
        for name in BANDED:
            if name == "kinetic_friction" and "friction_ratio" in box.bands:
                continue
            ends = box.span(name)
            assert ends[0] <= place[name] <= ends[1], name


@examples(20)
@given(boxes(most_load=0.999))
def test_a_box_without_width_is_a_scene(box: Boxed) -> None:
    cycle = vibro.solve(box.scene)
    bands = {
        name: (float(value),) * 2 for name, value in box.scene.arrays()._asdict().items() if name in BANDED
    }
    for found in (vibro.guarantee(box.scene), vibro.guarantee(box.scene, **bands)):
        assert found.speed_min == found.speed_max == float(cycle.mean_velocity)
        assert found.regimes == {Regime(int(cycle.regime))}
        assert (found.proof_min, found.proof_max, found.min_limit, found.max_limit) == ("corners",) * 2 + (
            "",
        ) * 2
        assert found.min_at == found.max_at == {n: float(x) for n, x in box.scene.arrays()._asdict().items()}


@examples(15)
@given(boxes(forward=True, drifts=True))
def test_no_sample_beats_corners(box: Boxed) -> None:
    found = vibro.guarantee(box.scene, **box.bands)
    assert {found.proof_min, found.proof_max} <= {"corners", "proved"}
    assert max(found.regimes) <= Regime.FORWARD_SLIP
    assert_not_beaten(box, found)


@pytest.mark.parametrize("trough", [3.0, -3.0], ids=["climbing", "declining"])
def test_no_sample_beats_a_box_of_everything(trough: float) -> None:
    scene = scene_with(amplitude=1.1e-3)
    bands = {
        "amplitude": about(1.1e-3, 5),
        "frequency": about(15, 1),
        "drive_angle": deg(19, 21),
        "trough_angle": deg(trough - 0.5, trough + 0.5),
        "static_friction": (0.6, 0.8),
        "friction_ratio": (0.7, 0.9),
    }
    found = vibro.guarantee(scene, **bands)
    assert found.proof_min == found.proof_max == "proved"
    assert_not_beaten(Boxed(scene, bands), found)


@examples(15)
@given(boxes(forward=True, drifts=True), st.floats(1.0, 3.0))
def test_wider_bands_never_help(box: Boxed, factor: float) -> None:
    wider = {}
    for name, (low, high) in box.bands.items():
        more = 0.05 * (factor - 1) * (high - low)
        most = 1.0 if name == "friction_ratio" else math.inf
        wider[name] = (low - more, min(high + more, most))
    inner, outer = (vibro.guarantee(box.scene, **bands) for bands in (box.bands, wider))
    slack = 1e-6 * abs(inner.found_min), 1e-6 * abs(inner.found_max)
    assert outer.found_min <= inner.found_min + slack[0]
    assert outer.found_max >= inner.found_max - slack[1]
    assert outer.regimes >= inner.regimes


@pytest.mark.parametrize("trough", [3.0, -3.0], ids=["climbing", "declining"])
def test_corners_find_what_a_search_finds(trough: float) -> None:
    scene = scene_with(amplitude=0.9e-3, trough_angle=math.radians(trough))
    bands = {
        "amplitude": about(0.9e-3, 1),
        "static_friction": (0.7, 0.8),
        "friction_ratio": (0.7, 0.8),
    }
    quick = vibro.guarantee(scene, **bands)
    assert quick.proof_min == "corners"
    with mock.patch.object(guarantees, "is_braked", return_value=False):  # so that it has to search
        slow = vibro.guarantee(scene, **bands)
    assert slow.proof_min == slow.proof_max == "proved"
    assert quick.found_min == pytest.approx(slow.found_min, rel=1e-9)
    assert quick.found_max == pytest.approx(slow.found_max, rel=1e-9)


def test_the_fastest_drive_angle_may_lie_inside_its_band() -> None:
    """Slip of a weak drive, which starts only about atan(mu_s)."""
    mu_s = 0.5
    onset = mu_s / math.hypot(1.0, mu_s)
    amplitude = 1.001 * onset * 9.81 / (2 * math.pi * 15) ** 2
    scene = scene_with(amplitude=amplitude, static_friction=mu_s, kinetic_friction=0.3)
    found = vibro.guarantee(scene, drive_angle=deg(5, 60))
    angles = np.radians(np.linspace(5, 60, 200001))
    fastest = np.max(vibro.solve(replaced(scene, drive_angle=angles)).mean_velocity)
    assert found.speed_min == 0.0
    assert fastest <= found.speed_max * (1 + 1e-9)
    assert found.found_max == pytest.approx(fastest, rel=1e-6)
    assert found.proof_max == "proved"
    assert found.regimes == {Regime.NO_SLIP, Regime.FORWARD_SLIP}


class TestWhereCornersAreNotEnough:
    """The counterexamples, with their printed digits; [mm/s]."""

    def speeds(self, **changes: Any) -> list[float]:
        return [1e3 * float(v) for v in vibro.solve(scene_with(**changes)).mean_velocity]

    def test_more_amplitude_is_slower(self) -> None:
        assert self.speeds(amplitude=[1.1904e-3, 1.1941e-3]) == pytest.approx([27.194, 27.046], abs=5e-4)
        found = vibro.guarantee(scene_with(amplitude=1.195e-3), amplitude=about(1.195e-3, 1))
        corners = self.speeds(amplitude=np.array(about(1.195e-3, 1)))
        assert corners == pytest.approx([28.522, 27.290], abs=5e-4)
        assert 1e3 * found.found_min == pytest.approx(27.0464, abs=5e-5)
        assert 1e3 * found.found_max == pytest.approx(29.0414, abs=5e-5)
        assert 1e3 * found.max_at["amplitude"] == pytest.approx(1.190300, abs=2e-6)
        assert found.max_limit == "from below the load at which back slip begins"
        assert found.min_limit == ""
        assert 1e3 * at(found.max_at, 1 - 1e-9) == pytest.approx(29.0414, abs=5e-5)
        assert 1e3 * at(found.max_at, 1 + 1e-6) < 27.3

    def test_the_slowest_friction_lies_inside_on_a_decline(self) -> None:
        fields = {
            "amplitude": 0.9e-3,
            "frequency": 18.0,
            "drive_angle": math.radians(28),
            "trough_angle": math.radians(-2),
        }
        mu_s, ratio = (x.ravel() for x in np.meshgrid([0.36, 0.62], [0.41, 0.48]))
        corners = self.speeds(**fields, static_friction=mu_s, kinetic_friction=mu_s * ratio)
        assert min(corners) == pytest.approx(41.1554, abs=5e-5)
        found = vibro.guarantee(
            scene_with(**fields), static_friction=(0.36, 0.62), friction_ratio=(0.41, 0.48)
        )
        assert 1e3 * found.found_min == pytest.approx(41.1333, abs=5e-5)


def test_where_a_part_runs_away_nothing_is_guaranteed() -> None:
    scene = scene_with(static_friction=0.3, kinetic_friction=0.15)
    boxes_of_parts: list[dict[str, Any]] = [
        {"trough_angle": deg(-10, -10)},
        {"trough_angle": deg(-10, -5)},
        {"trough_angle": deg(-5, -5), "kinetic_friction": (0.05, 0.15)},
        {"trough_angle": deg(10, 20)},
        {"trough_angle": deg(10, 20), "static_friction": (0.2, 0.3)},
    ]
    for bands in boxes_of_parts:
        found = vibro.guarantee(scene, **bands)
        assert (found.speed_min, found.speed_max) == (-math.inf, math.inf), bands
        assert vibro.feasible_amplitudes(scene, 0.01, **bands) == []


def test_hopping_is_sampled() -> None:
    scene = scene_with(amplitude=4e-3)
    bands = {"static_friction": (0.5, 0.8), "friction_ratio": (0.7, 0.9)}
    found = vibro.guarantee(scene, **bands)
    assert found.proof_min == found.proof_max == "sampled"
    assert found.regimes == {Regime.HOPPING}
    cycle = Boxed(scene, bands).samples(9)
    known = np.isfinite(cycle.mean_velocity)
    error = np.where(cycle.status == Status.AVERAGED, cycle.mean_velocity_error, 0.0)
    # samples, so that others may be a little slower or faster
    width = found.speed_max - found.speed_min
    assert found.speed_min <= np.min((cycle.mean_velocity - 3 * error)[known]) + 0.02 * width
    assert found.speed_max >= np.max((cycle.mean_velocity + 3 * error)[known]) - 0.02 * width


def test_means_count_with_three_errors_to_their_disadvantage() -> None:
    scene = scene_with(amplitude=6.489e-3, restitution=0.3)
    cycle, found = vibro.solve(scene), vibro.guarantee(scene)
    assert cycle.status == Status.AVERAGED
    mean, error = float(cycle.mean_velocity), float(cycle.mean_velocity_error)
    assert error > 0
    assert (found.speed_min, found.speed_max) == (mean - 3 * error, mean + 3 * error)
    assert (found.proof_min, found.proof_max) == ("sampled", "sampled")


def test_yields_of_certain_things() -> None:
    bands = {"static_friction": (0.7, 0.78), "kinetic_friction": (0.5, 0.6)}
    found = vibro.guarantee(scene_with(), **bands)
    for speed, regime, share in (
        (found.found_min * 0.999, "back-slip", 1.0),
        (found.found_max * 1.001, "back-slip", 0.0),
        (found.found_min * 0.999, "forward-slip", 1.0),
    ):
        found_share, error = vibro.yield_share(scene_with(), speed, highest_regime=regime, **bands)
        assert found_share == share
        assert 0.0 < error < 1e-5  # a sliver of a sample's size may have been missed
    back = scene_with(amplitude=2e-3)
    assert vibro.yield_share(back, 1e-3, highest_regime="forward-slip", **bands)[0] == 0.0


@pytest.mark.parametrize("amplitude", [3e-4, 1e-3])
def test_nothing_is_guaranteed_where_some_part_runs_away(amplitude: float) -> None:
    """Down 14 degrees, parts of mu_d below 0.249 slide for ever; those above convey at 17 to 95 mm/s."""
    scene = scene_with(
        amplitude=amplitude, static_friction=0.4, kinetic_friction=0.2, trough_angle=math.radians(-14.0)
    )
    found = vibro.guarantee(scene, kinetic_friction=(0.15, 0.3))
    assert (found.speed_min, found.speed_max) == (-math.inf, math.inf)
    assert (found.proof_min, found.proof_max) == ("proved", "proved")
    assert (found.proved_min, found.proved_max) == (-math.inf, math.inf)
    held = vibro.guarantee(scene, kinetic_friction=(0.26, 0.3))
    assert 0.0 < held.speed_min < held.speed_max < math.inf


@pytest.mark.parametrize(("angles", "slowest"), [((40.0, 60.0), 60.0), ((8.0, 20.0), 8.0)])
def test_either_end_of_the_drive_angles_may_be_the_slowest(
    angles: tuple[float, float], slowest: float
) -> None:
    """The speed rises with the drive angle, then falls."""
    scene = scene_with(amplitude=0.8e-3, drive_angle=math.radians(angles[0]))
    found = vibro.guarantee(scene, drive_angle=deg(*angles), static_friction=(0.7, 0.74))
    assert found.proof_min == "proved"
    assert math.degrees(found.min_at["drive_angle"]) == pytest.approx(slowest)
    steps = np.radians(np.linspace(*angles, 21))
    speeds = vibro.solve(replaced(scene, drive_angle=steps)).mean_velocity
    assert found.found_min == pytest.approx(np.min(speeds), rel=1e-12)


def test_the_onset_of_forward_slip_is_a_limit_of_its_speed() -> None:
    """Static friction exceeds kinetic friction, so that parts start with a jump."""
    unit = scene_with(amplitude=1.0)
    amplitude = float(critical_loads(unit).forward_onset / unit.load)
    speed = float(vibro.solve(scene_with(amplitude=amplitude * (1 + 1e-9))).mean_velocity)
    assert speed > 1e-4
    found = vibro.guarantee(scene_with(), amplitude=(amplitude * 0.99, amplitude * (1 - 1e-10)))
    assert (found.speed_max, found.max_limit) == (0.0, "from below the load at which forward slip begins")


@pytest.mark.parametrize("angles", [(0.1, 1.2), (0.1, 0.3), (0.6, 1.2), (0.42, 0.48)])
def test_the_fastest_body_where_none_slips_back(angles: tuple[float, float]) -> None:
    """Of a grid of drive angles, at the largest load, the least frictions and the flattest trough."""
    unit = 9.81 / (2.0 * math.pi * 15.0) ** 2
    least, most = 0.5 * unit, 0.55 * unit
    scene = scene_with(amplitude=least, drive_angle=angles[0], static_friction=0.6, kinetic_friction=0.5)
    bands: dict[str, Any] = {
        "amplitude": (least, most), "drive_angle": angles, "static_friction": (0.55, 0.6),
        "friction_ratio": (0.8, 0.9), "trough_angle": (0.0, 0.03),
    }  # fmt: skip
    box = uncertainty_set(scene, bands)
    found = bound(box, fast=True, seen=Seen(), boxes=BRIEF)
    assert float(box.load[1]) <= float(back_slip_load(box))
    grid = np.linspace(*angles, 2001)
    fields: dict[str, Any] = {
        "amplitude": most,
        "drive_angle": grid,
        "static_friction": 0.55,
        "kinetic_friction": 0.44,
        "trough_angle": 0.0,
    }
    speeds = np.asarray(vibro.solve(replaced(scene, **fields)).mean_velocity)
    assert np.max(speeds) > 0.0
    assert found.extreme.speed >= np.max(speeds) * (1 - 1e-12)
    assert found.extreme.speed == pytest.approx(np.max(speeds), rel=1e-5)


def test_a_slower_body_that_the_boxes_meet_starts_the_evolution_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Here the first population is not moved, and has missed it."""
    monkeypatch.setattr(proofs, "_MOST_GENERATIONS", 0)
    box = uncertainty_set(scene_with(), {"amplitude": (1.18e-3, 1.21e-3)})
    alone, met = (slowest_in_contact(box, fast=False, boxes=boxes).speeds[0] for boxes in (1, BRIEF))
    assert met < alone * (1.0 - 1e-9)
