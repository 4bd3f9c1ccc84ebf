"""Limits of elliptical drives by hand: largest amplitudes, what limits a setting, costs of the searches."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.questions import changed

from vibro import Regime, solve
from vibro.designs.optima import EllipseOptimiser, Optimum, below
from vibro.designs.proofs import first_ratio
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.designs.spaces import Setting

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

SCENE = {"static_friction": "0.35:0.45", "friction_ratio": 0.9}
DRIVE = {
    "along_amplitude_mm": "0.1:1", "normal_amplitude_mm": "0.05:0.5", "normal_phase_deg": "-180:180",
    "frequency_hz": 25,
}  # fmt: skip
DRIFT = {"amplitude_percent": 5, "frequency_percent": 1}
GROWTH = 1.05 * 1.01**2
UNIT = 9.81 / (2.0 * math.pi * 25.0) ** 2  # [m] of load 1
PHASE = math.radians(-50.0)


def asked(highest: Regime = Regime.BACK_SLIP, drive: Any = None, **changes: Any) -> Question:
    content = {"scene": SCENE, "drive": [DRIVE | (drive or {})], "goal": {"speed_mm_s": 5}} | changes
    spec = read_spec(changed(**content))
    return Question(spec, spec.drives[0], highest)


def optimiser(highest: Regime = Regime.BACK_SLIP, drive: Any = None, **changes: Any) -> EllipseOptimiser:
    return EllipseOptimiser(asked(highest, drive, **changes))


@pytest.mark.parametrize(
    ("most", "share", "value", "possible"),
    [
        (9.0, 0.0, 2.0, True), (9.0, 0.5, 3.0, True), (9.0, 1.0, 4.0, True),
        (3.0, 0.0, 2.0, True), (3.0, 0.5, 2.5, True), (3.0, 1.0, 3.0, True),
        (2.0, 1.0, 2.0, True), (2.0 * (1 - 1e-16), 0.3, 2.0, True), (1.9, 0.3, 2.0, False),
        (0.0, 1.0, 2.0, False),
    ],
)  # fmt: skip
def test_a_value_of_a_range_below_a_limit(most: float, share: float, value: float, possible: bool) -> None:
    found, fits = below(np.array([most]), (2.0, 4.0), np.array([share]))
    assert found == pytest.approx([value])
    assert fits.tolist() == [possible]
    assert float(below(np.array([9.0]), (0.3, 0.9), np.ones(1))[0][0]) == 0.9  # to the last bit


@pytest.mark.parametrize(
    ("highest", "scale", "throw", "growth"),
    [
        (Regime.BACK_SLIP, 1.0, 1.0, GROWTH),
        (Regime.BACK_SLIP, 2.0, 1.0, 1.1 * 1.02**2),
        (Regime.HOPPING, 1.0, 10.0, GROWTH),
    ],
)
def test_the_largest_normal_amplitude_hops_no_part_or_throws_it_by_ten(
    highest: Regime, scale: float, throw: float, growth: float
) -> None:
    search = optimiser(highest, drift=DRIFT, scene={**SCENE, "trough_angle_deg": -8})
    found = search._most(Setting(1.0, 1.0, 0.0, np.array([25.0, 50.0])), scale)
    most = throw * math.cos(math.radians(8.0)) * UNIT / growth
    assert found == pytest.approx([most, most / 4.0], rel=1e-9)
    assert found[0] < most


@pytest.mark.parametrize(
    ("most", "frequency", "highest", "more"),
    [
        (0.01, 25, Regime.HOPPING, False),
        (0.38, 25, Regime.HOPPING, True),  # throws parts with margins
        (0.3, 25, Regime.HOPPING, False),
        (0.3, [10, 35], Regime.HOPPING, True),
        (0.3, 25, Regime.BACK_SLIP, True),
    ],
)
def test_a_higher_regime_has_more_where_parts_may_hop(
    most: float, frequency: Any, highest: Regime, more: bool
) -> None:
    """0.398 mm hop parts at 25 Hz; ten times a drift of 0.5 % may be on top."""
    drive = {"normal_amplitude_mm": most, "frequency_hz": frequency}
    assert optimiser(highest, drive, drift={"amplitude_percent": 0.5}).has_more() is more


@pytest.mark.parametrize(
    ("highest", "regimes", "keeps"),
    [
        (Regime.BACK_SLIP, {Regime.FORWARD_SLIP, Regime.BACK_SLIP}, True),
        (Regime.BACK_SLIP, {Regime.FORWARD_SLIP, Regime.HOPPING}, False),
        (Regime.HOPPING, {Regime.HOPPING}, True),
        (Regime.FORWARD_SLIP, {Regime.FORWARD_SLIP, Regime.BACK_SLIP}, False),
    ],
)
def test_no_body_may_exceed_the_regime(highest: Regime, regimes: set[Regime], keeps: bool) -> None:
    search = optimiser(highest)
    assert search.keeps_to_regime(Setting(5e-4, 1e-4, PHASE, 25.0), regimes) is keeps


@pytest.mark.parametrize(("factor", "keeps"), [(0.999, True), (1.001, False)])
def test_the_first_body_to_slip_back_ends_forward_slip(factor: float, keeps: bool) -> None:
    search, setting = optimiser(Regime.FORWARD_SLIP), Setting(5e-4, 2e-4, 0.0, 25.0)
    ratio = first_ratio(search._question.box(setting), Regime.BACK_SLIP)
    there = setting.scaled(factor / ratio)
    assert search.keeps_to_regime(there, {Regime.FORWARD_SLIP}) is keeps
    # such a body joins the scenarios if none is slower
    search.scenarios = np.full((len(search._question.box(setting).axes), 1), 0.5)
    optimum = Optimum(there, -1.0)
    before = search.scenarios.shape[1]
    assert search.confirmed(optimum)[1] is not keeps
    assert search.scenarios.shape[1] - before >= (not keeps)
    assert not search.confirmed(optimum)[1]
    assert not optimiser(Regime.BACK_SLIP).confirmed(optimum)[1]


HOP = 1.0 / GROWTH  # nominal throw number at which a part hops
LOAD = float(Setting(5e-4, 2e-4, PHASE, 25.0).load(9.81))


@pytest.mark.parametrize(
    ("setting", "drive", "expected"),
    [
        (Setting(5e-4, 2e-4, PHASE, 25.0), {}, "speed"),
        (Setting(5e-4, HOP * UNIT * (1 - 5e-7), PHASE, 25.0), {}, "hop"),
        (Setting(5e-4, HOP * UNIT * (1 - 3e-6), PHASE, 25.0), {}, "speed"),
        (Setting(1e-3 * (1 - 5e-7), 2e-4, PHASE, 25.0), {}, "limit"),
        (Setting(1e-3 * (1 - 2e-6), 2e-4, PHASE, 25.0), {}, "speed"),
        (Setting(5e-4, 2e-4 * (1 - 5e-7), PHASE, 25.0), {"normal_amplitude_mm": "0.05:0.2"}, "limit"),
        (Setting(5e-4, 2e-4 * (1 - 2e-6), PHASE, 25.0), {"normal_amplitude_mm": "0.05:0.2"}, "speed"),
        (Setting(5e-4, 2e-4, PHASE, 25.0), {"acceleration_g": LOAD * (1 + 5e-7)}, "limit"),
        (Setting(5e-4, 2e-4, PHASE, 25.0), {"acceleration_g": LOAD * (1 + 2e-6)}, "speed"),
    ],
)
def test_what_limits_a_setting(setting: Setting, drive: dict[str, Any], expected: str) -> None:
    search = optimiser(drive=drive, drift=DRIFT)
    assert search.limit(setting, 1.0) == expected
    if expected == "hop":  # even if no scenario hops there
        search.scenarios = np.full((7, 1), 0.5)
        assert search.limit(setting, 1.0) == expected


@pytest.mark.parametrize(("share", "expected"), [(0.97, "speed"), (0.99, "limit")])
def test_a_landing_near_its_limit_limits_a_setting(share: float, expected: str) -> None:
    single = {"static_friction": 0.4, "kinetic_friction": 0.36}
    setting = Setting(5e-4, 4.9e-4, PHASE, 25.0)
    question = asked(Regime.HOPPING, scene=single)
    hardest = 1e3 * float(solve(question.nominal_scene(setting)).impact_velocity)
    assert hardest > 0.0
    goal = {"speed_mm_s": 5, "highest_regime": "hopping", "impact_speed_mm_s": hardest / share}
    search = optimiser(Regime.HOPPING, scene=single, goal=goal)
    assert search.limit(setting, 1.0) == expected


NARROW = {"half_base_mm": 1, "centre_height_mm": 10}


def least_is(monkeypatch: pytest.MonkeyPatch, search: EllipseOptimiser, beyond: float) -> None:
    """Let the least speed be 1, and another one at a larger setting."""
    monkeypatch.setattr(search, "least", lambda setting, scale: np.array([1.0, beyond]))


@pytest.mark.parametrize(
    ("beyond", "expected"),
    [(1.0, "speed"), (1.0 - 0.9e-4, "speed"), (1.0 - 1.1e-4, "back slip"), (-math.inf, "forbidden")],
)
def test_a_fall_of_the_speed_beyond_a_setting_is_back_slip(
    beyond: float, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    search, setting = optimiser(), Setting(5e-4, 2e-4, PHASE, 25.0)
    least_is(monkeypatch, search, beyond)
    asked_of: list[Any] = []

    def forbids(*args: Any) -> str:
        asked_of.append(args)
        return "forbidden"

    monkeypatch.setattr(search, "_forbids", forbids)
    assert search.limit(setting, 1.5) == expected
    assert [(a[:2], scale) for a, scale in asked_of] == (
        [(pytest.approx((5e-4 * (1 + 1e-6), 2e-4 * (1 + 1e-6))), 1.5)] if expected == "forbidden" else []
    )


@pytest.mark.parametrize(
    ("setting", "highest", "changes", "expected"),
    [
        # along a line of 18 deg the narrow part tips before it slips
        (Setting(6e-4, 2e-4, 0.0, 25.0), Regime.BACK_SLIP, {"part": NARROW}, "tip"),
        (Setting(9e-4, 2e-4, PHASE, 25.0), Regime.FORWARD_SLIP, {}, "back slip"),
        (Setting(5e-4, 4.2e-4, PHASE, 25.0), Regime.BACK_SLIP, {}, "hop"),
        (
            Setting(5e-4, 4.9e-4, PHASE, 25.0), Regime.HOPPING,
            {"goal": {"speed_mm_s": 5, "highest_regime": "hopping", "impact_speed_mm_s": 1}}, "limit",
        ),
    ],
)  # fmt: skip
def test_the_constraint_that_forbids_a_setting(
    setting: Setting, highest: Regime, changes: dict[str, Any], expected: str
) -> None:
    search = optimiser(highest, **changes)
    one = Setting(*(np.array([float(x)]) for x in setting))
    assert np.isinf(search.least(one, 1.0)[0])
    assert search._forbids(setting, 1.0) == expected


@pytest.mark.parametrize(
    ("drive", "changes", "highest", "expected"),
    [
        ({"normal_amplitude_mm": "0.41:0.5"}, {}, Regime.BACK_SLIP, "hop"),  # the least one throws parts
        ({"along_amplitude_mm": 0.1, "normal_amplitude_mm": 0.05}, {}, Regime.BACK_SLIP, "limit"),
        ({"along_amplitude_mm": 0.8, "normal_phase_deg": 0}, {"part": NARROW}, Regime.BACK_SLIP, "tip"),
        ({"along_amplitude_mm": 0.9, "normal_amplitude_mm": 0.05}, {}, Regime.FORWARD_SLIP, "back slip"),
    ],
)
def test_what_bounds_the_load_where_no_setting_conveys(
    drive: dict[str, Any], changes: dict[str, Any], highest: Regime, expected: str
) -> None:
    search = optimiser(highest, drive, **changes)
    assert search.fastest() is None
    assert search.first_cap() == expected


def costs_of(
    monkeypatch: pytest.MonkeyPatch, search: EllipseOptimiser, speeds: list[float], find: Any
) -> tuple[list[float], Any]:
    """Return the costs that a search gives to settings of known speeds, and what it makes of the least."""
    found: list[float] = []
    settings = Setting(*(np.linspace(x, 2.0 * x, len(speeds)) for x in (5e-4, 2e-4, 0.1, 20.0)))
    monkeypatch.setattr(search, "least", lambda setting, _: np.array(speeds)[: np.size(setting.frequency)])

    def best(cost: Any, scale: float, share: float = 1.0) -> tuple[Setting, float]:
        found.extend(cost(settings, np.linspace(0.0, 1.0, len(speeds))).tolist())
        index = int(np.argmin(found))
        return Setting(*(float(x[index]) for x in settings)), found[index]

    monkeypatch.setattr(search, "_best", best)
    return found, find(search)


def test_costs_of_the_fastest_setting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Faster before slower before backward before rest, more amplitude first, before what is forbidden."""
    speeds = [0.3, 0.2, -0.1, 0.0, 0.0, -math.inf]
    costs, best = costs_of(monkeypatch, optimiser(), speeds, lambda s: s._fastest(1.0))
    assert costs[:3] == [-0.3, -0.2, 0.1]
    assert costs[2] < costs[4] < costs[3] < costs[5] < math.inf
    assert best.speed == 0.3
    for slow in (0.0, -0.1, -math.inf):
        assert costs_of(monkeypatch, optimiser(), [slow], lambda s: s._fastest(1.0))[1] is None


def test_costs_of_the_least_acceleration(monkeypatch: pytest.MonkeyPatch) -> None:
    """The load where the target is reached; else faster settings first, before what is forbidden."""
    search = optimiser()
    speeds = [0.3, 0.2, 0.19, 0.1, 0.0, -math.inf]
    costs, best = costs_of(monkeypatch, search, speeds, lambda s: s._least_acceleration(0.2))
    loads = [float(search._question.load(Setting(5e-4 * r, 2e-4 * r, 0.1 * r, 20.0 * r))) for r in (1.0, 1.2)]
    assert costs[:2] == pytest.approx(loads)
    assert loads[1] < costs[2] < costs[3] < costs[4] < costs[5] < math.inf
    assert best == (pytest.approx((5e-4, 2e-4, 0.1, 20.0)), 0.3)
    assert costs_of(monkeypatch, optimiser(), [0.199], lambda s: s._least_acceleration(0.2))[1] is None


def test_every_range_of_frequencies_is_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    search = optimiser(drive={"frequency_hz": [20, 25, 30]})
    costs = {20.0: 3.0, 25.0: 1.0, 30.0: 2.0}
    monkeypatch.setattr(search, "_best_of", lambda cost, s, *_: (Setting(0, 0, 0, s[3][0]), costs[s[3][0]]))
    assert search._best(lambda *_: np.zeros(1), 1.0) == (Setting(0, 0, 0, 25.0), 1.0)


def test_a_search_stays_within_the_drive_and_its_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    """Coordinates are the amplitudes along and normal to the trough, the phase, and the frequency."""
    drive = {"frequency_hz": "20:30", "acceleration_g": 1.5, "normal_phase_deg": "-90:90"}
    search = optimiser(drive=drive)
    met: list[Setting] = []

    def cost(setting: Setting, shares: Floats) -> Floats:
        met.append(setting)
        goals, weights = (6e-4, 1e-4, 0.3, 23.0), (1.0, 1.0, 1e-8, 1e-10)
        terms = (w * (x - goal) ** 2 for x, goal, w in zip(setting, goals, weights, strict=True))
        return np.asarray(sum(terms))

    best, least = search._best_of(cost, search._ranges[0], 1.0, 1.0)
    assert best == pytest.approx((6e-4, 1e-4, 0.3, 23.0), rel=2e-2)
    assert least < 1e-10
    every = Setting(*(np.concatenate([getattr(s, name) for s in met]) for name in Setting._fields))
    assert np.all(search._question.load(every) <= 1.5)
    assert np.all(every.normal_amplitude <= search._most(Setting(1.0, 1.0, 0.0, every.frequency), 1.0))
    for values, (low, high) in zip(
        every, ((1e-4, 1e-3), (5e-5, 5e-4), (-1.6, 1.6), (20.0, 30.0)), strict=True
    ):
        assert low <= values.min() < values.max() <= high
        assert values.max() - values.min() > 0.4 * (high - low)


# 0.5 mm at 25 Hz, which is 1.26 g
HEAVY = {"along_amplitude_mm": 0.4, "normal_amplitude_mm": 0.3, "normal_phase_deg": 0, "acceleration_g": 1.1}


def test_the_phase_is_searched_at_a_fixed_frequency_and_the_frequency_at_a_fixed_phase() -> None:
    for drive, expected in (
        ({"normal_phase_deg": "-90:90"}, (0.3, 25.0)),
        ({"normal_phase_deg": 10, "frequency_hz": "20:30"}, (math.radians(10.0), 23.0)),
    ):
        search = optimiser(drive=drive | {"along_amplitude_mm": 0.5, "normal_amplitude_mm": 0.1})

        def cost(setting: Setting, shares: Floats) -> Floats:
            return np.asarray((setting.normal_phase - 0.3) ** 2 + (setting.frequency - 23.0) ** 2)

        best, _ = search._best_of(cost, search._ranges[0], 1.0, 1.0)
        assert best == pytest.approx((5e-4, 1e-4, *expected), rel=1e-3)


@pytest.mark.parametrize("drive", [{"normal_amplitude_mm": 0.45}, HEAVY])
def test_a_setting_beyond_the_limits_is_dearer_than_all(drive: dict[str, Any]) -> None:
    search = optimiser(drive=drive)
    cost: Any = lambda *_: pytest.fail("none is possible")  # noqa: E731
    assert search._best_of(cost, search._ranges[0], 1.0, 1.0)[1] >= 6e6
