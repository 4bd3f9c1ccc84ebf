"""Questions, their uncertainty sets and scenarios, beside what a short calculation gives."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from helpers.questions import answered

import vibro
from vibro import Regime
from vibro.inverse import designs
from vibro.inverse.designs import chosen_of, find_designs
from vibro.inverse.ellipses import EllipseOptimiser
from vibro.inverse.exchange import Found
from vibro.inverse.guarantees import guarantee_of
from vibro.inverse.lines import LineOptimiser
from vibro.inverse.proofs import corners
from vibro.inverse.questions import MOST_THROW, Question
from vibro.inverse.reading import read_spec
from vibro.inverse.rows import KINDS
from vibro.inverse.scenarios import Scenarios
from vibro.inverse.spaces import SPACES, Setting
from vibro.results.designs import Design

LINE: dict[str, Any] = {
    "scene": {"static_friction": "0.66:0.82", "friction_ratio": 0.77},
    "drive": [{"amplitude_mm": "0.5:3", "frequency_hz": 15, "drive_angle_deg": "10:40"}],
    "drift": {"amplitude_percent": 2, "frequency_percent": 1, "drive_angle_deg": 0.5},
    "goal": {"speed_mm_s": 5},
}
ELLIPSE: dict[str, Any] = {
    **LINE,
    "drive": [
        {"along_amplitude_mm": "0.1:1", "normal_amplitude_mm": "0.05:0.2", "normal_phase_deg": "-90:0",
         "frequency_hz": 25},
    ],
    "drift": {"amplitude_percent": 2, "frequency_percent": 1, "normal_phase_deg": 3},
}  # fmt: skip


def asked(question: dict[str, Any], highest: Regime = Regime.BACK_SLIP) -> Question:
    spec = read_spec(question)
    return Question(spec, spec.drives[0], highest)


def line(amplitude: float, angle_deg: float = 20.0, frequency: float = 15.0) -> Setting:
    space = SPACES[asked(LINE).drive.kind]
    return space.setting(amplitude=amplitude, frequency=frequency, drive_angle=math.radians(angle_deg))


@pytest.mark.parametrize("scale", [0.0, 0.5, 1.0, 3.0])
def test_every_drift_is_scaled(scale: float) -> None:
    box = asked(LINE).box(line(1e-3), scale)
    for (low, high), value, share in (
        (box.factor, 1e-3, 0.02), (box.frequency, 15.0, 0.01),
        (box.shape["drive_angle"], math.radians(20.0), 0.5 / 20.0), (box.static_friction, 0.74, 0.08 / 0.74),
    ):  # fmt: skip
        assert (low, high) == pytest.approx((value * (1 - share * scale), value * (1 + share * scale)))
    setting = Setting(5e-4, 1e-4, -0.5, 25.0)
    ellipse = asked(ELLIPSE).box(setting, scale)
    assert ellipse.frequency == pytest.approx((25.0 * (1 - 0.01 * scale), 25.0 * (1 + 0.01 * scale)))
    drift = math.radians(3.0) * scale
    assert ellipse.shape["normal_phase"] == pytest.approx((-0.5 - drift, -0.5 + drift))
    assert ellipse.factor == pytest.approx((1 - 0.02 * scale, 1 + 0.02 * scale))


def test_designs_that_hop_end_at_a_throw_number_of_ten_drift_included() -> None:
    question = asked(LINE, Regime.HOPPING)
    caps = LineOptimiser(question)._caps(np.array([[math.radians(20.0)]]))
    load = float(caps["limit"][0, 0])
    amplitude = load * 9.81 / (2.0 * math.pi * 15.0) ** 2
    assert question.box(line(amplitude)).throw_number == pytest.approx(10.0, rel=1e-9)


def test_a_rounded_frequency_keeps_the_load() -> None:
    setting = line(1e-3, frequency=14.5)
    printed = next(iter(LineOptimiser(asked(LINE)).roundings(setting, 9, up=False)))
    assert printed[1] == 15.0
    assert printed[0] == pytest.approx((14.5 / 15.0) ** 2, rel=2e-8)


def test_a_margin_ends_where_bands_exceed_the_regime() -> None:
    optimiser = LineOptimiser(asked(LINE, Regime.FORWARD_SLIP))
    fastest = optimiser.fastest()
    assert fastest is not None
    assert optimiser.margin(fastest.setting, 1e-6) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(("normal", "set_by"), [(2e-4, "limit"), (1.5e-4, "speed")])
def test_a_normal_amplitude_at_its_end_is_a_limit(normal: float, set_by: str) -> None:
    question = asked(ELLIPSE)
    setting = Setting(5e-4, normal, math.radians(-50.0), 25.0)
    found = Found(setting, (), guarantee_of(question.box(setting)))
    assert EllipseOptimiser(question).limit(found, 1.0) == set_by


@pytest.mark.parametrize("amplitude", [1.19e-3, 1.195e-3, 1.2e-3])
def test_a_scenario_on_a_drop_stays_just_past_it(amplitude: float) -> None:
    """Back slip enters at some static friction of the band, which moves with the amplitude."""
    question = asked({**LINE, "drift": {}})
    box = question.box(line(1.195e-3))
    assert box.axes[3] == "static_friction"
    shares = np.full((5, 20001), 0.0)
    shares[3] = np.linspace(0.0, 1.0, 20001)
    regimes = vibro.solve(box.scene(box.points(shares), fast=False)).regime
    (drop,) = np.flatnonzero(regimes[1:] != regimes[:-1])
    at = np.zeros((5, 1))
    low, high = shares[3, drop], shares[3, drop + 1]
    for _ in range(40):
        at[3] = 0.5 * (low + high)
        slips = vibro.solve(box.scene(box.points(at), fast=False)).regime[0] == regimes[drop]
        low, high = (float(at[3, 0]), high) if slips else (low, float(at[3, 0]))
    scenarios = Scenarios.fixed(corners(box.varies)).joined(box, at)
    assert scenarios.axes[-1] == 3
    moved = question.box(Setting(*(np.full((1, 1), float(x)) for x in line(amplitude))))
    there = scenarios.at(moved)[:, 0, -1:]
    found = {}
    for step in (0.0, 1e-6, -1e-6):
        beside = there.copy()
        beside[3] += step
        cycle = vibro.solve(moved.scene(moved.points(beside[:, None, :]), fast=False))
        found[step] = int(cycle.regime.item())
    assert found[0.0] == Regime.BACK_SLIP
    assert {found[-1e-6], found[1e-6]} == {Regime.FORWARD_SLIP, Regime.BACK_SLIP}


def test_loads_of_the_chosen_design_are_of_the_first_and_the_last_part() -> None:
    spec = read_spec({**LINE, "drive": [{"amplitude_mm": 1, "frequency_hz": 15, "drive_angle_deg": 20}]})
    chosen = chosen_of(spec, find_designs(spec))
    assert chosen is not None
    box = asked(LINE).box(chosen.setting)
    grid = np.array(np.meshgrid(*[[0.0, 0.5, 1.0]] * 5)).reshape(5, -1)
    scene = box.scene(box.points(grid), fast=False)
    loads = vibro.critical_loads(scene)
    ratios = {name: scene.load / load for name, load in loads._asdict().items()}
    assert chosen.loads["the first part slips back"] == pytest.approx(np.max(ratios["back_slip"]), rel=1e-9)
    assert chosen.loads["the first part hops"] == pytest.approx(np.max(ratios["hop"]), rel=1e-9)
    assert chosen.loads["the last part starts"] == pytest.approx(np.min(ratios["forward_onset"]), rel=1e-9)


@pytest.mark.parametrize(
    ("scene", "scale", "field", "ends"),
    [
        ({"friction_ratio": "0.8:1"}, 2.0, "second_friction", (0.7, 1.0)),  # mu_d <= mu_s
        ({"friction_ratio": "0.2:0.8"}, 2.0, "second_friction", (0.0, 1.0)),
        ({"kinetic_friction": "0.8:1.2"}, 2.0, "second_friction", (0.6, 1.4)),
        ({"kinetic_friction": "0.2:1.2"}, 2.0, "second_friction", (0.0, 1.7)),
        ({"static_friction": "0.1:0.5"}, 2.0, "static_friction", (0.0, 0.7)),
        ({"static_friction": "1.1:1.5"}, 2.0, "static_friction", (0.9, 1.7)),
    ],
)
def test_scaled_frictions_are_cut_where_they_cannot_be(
    scene: dict[str, Any], scale: float, field: str, ends: tuple[float, float]
) -> None:
    given = {"static_friction": "1.3:1.5"} | ({} if "kinetic_friction" in scene else {"friction_ratio": 0.77})
    box = asked({**LINE, "scene": given | scene}).box(line(1e-3), scale)
    assert [float(end) for end in getattr(box, field)] == pytest.approx(ends)
    assert box.is_ratio is ("kinetic_friction" not in scene)


@pytest.mark.parametrize(
    ("trough", "scale", "ends"),
    [
        ("2:4", 0.0, (3.0, 3.0)),
        ("2:4", 1.0, (1.5, 4.5)),
        ("2:4", 2.0, (0.0, 6.0)),
        ("-20:4", 10.0, (-90.0, 90.0)),
    ],
)
def test_the_band_of_the_trough_takes_its_drift(trough: str, scale: float, ends: tuple[float, float]) -> None:
    """Half a degree either way; a millionth of a radian is left to the right angle."""
    content = {
        **LINE,
        "scene": {**LINE["scene"], "trough_angle_deg": trough},
        "drift": {"trough_angle_deg": 0.5},
    }
    box = asked(content).box(line(1e-3), scale)
    assert [math.degrees(end) for end in box.trough_angle] == pytest.approx(ends, abs=1e-4)
    assert all(abs(end) <= 0.5 * math.pi - 1e-6 for end in box.trough_angle)


def test_bands_of_a_scale_of_one_are_kept_to_the_last_bit() -> None:
    """0.5 (0.1 + 0.7) - 0.5 (0.7 - 0.1) is not 0.1 in doubles."""
    content = {**LINE, "scene": {"static_friction": "0.1:0.7", "friction_ratio": "0.1:0.7"}}
    for scale in (1.0, np.ones((1, 1))):
        box = asked(content).box(line(1e-3), scale)
        for band in (box.static_friction, box.second_friction):
            assert [float(np.ravel(end)[0]) for end in band] == [0.1, 0.7]


@pytest.mark.parametrize(("scale", "growth"), [(0.0, 1.0), (1.0, 1.02 * 1.01**2), (3.0, 1.06 * 1.03**2)])
def test_the_largest_load_grows_with_both_drifts(scale: float, growth: float) -> None:
    question = asked(LINE)
    assert question.growth(scale) == pytest.approx(growth)
    most = question.box(line(1e-3), scale).load[1]
    assert float(most) == pytest.approx(growth * float(question.load(line(1e-3))))


def test_constants_of_a_question_are_those_of_its_scenes() -> None:
    moon = asked({**LINE, "scene": {**LINE["scene"], "gravity_m_s2": 1.62, "restitution": 0.3}})
    scene = moon.nominal_scene(line(1e-3))
    assert (float(scene.gravity), float(scene.restitution)) == (1.62, 0.3)
    assert float(moon.load(line(1e-3))) == pytest.approx(1e-3 * (2 * math.pi * 15.0) ** 2 / 1.62)


def test_the_nominal_scene_is_in_the_middle_of_all_bands() -> None:
    content = {
        **LINE,
        "scene": {"static_friction": "0.6:0.8", "friction_ratio": "0.7:0.9", "trough_angle_deg": "1:3"},
    }
    fields = asked(content).nominal_scene(line(1e-3)).arrays()._asdict()
    expected = {
        "amplitude": 1e-3, "frequency": 15.0, "drive_angle": math.radians(20.0), "static_friction": 0.7,
        "kinetic_friction": 0.56, "trough_angle": math.radians(2.0), "gravity": 9.81, "restitution": 0.0,
    }  # fmt: skip
    assert {name: float(value) for name, value in fields.items()} == pytest.approx(expected)
    several = asked(content).nominal_scene(Setting(*(np.array([x, x]) for x in line(1e-3))))
    assert several.shape == (2,)


@pytest.mark.parametrize(("highest", "limited"), [(Regime.BACK_SLIP, False), (Regime.HOPPING, True)])
def test_limits_on_landings_count_where_parts_may_hop(highest: Regime, limited: bool) -> None:
    goal = {"speed_mm_s": 5, "highest_regime": "hopping", "impact_speed_mm_s": 100, "flight_fraction": 0.4}
    landings = asked({**LINE, "goal": goal}, highest).landings
    assert landings == ((0.1, 0.4) if limited else (math.inf, math.inf))
    assert MOST_THROW == 10.0


@pytest.mark.parametrize(
    ("setting", "highest", "part", "allowed"),
    [
        (Setting(2e-4, 2e-4, -0.5, 25.0), Regime.FORWARD_SLIP, None, True),
        (Setting(1.5e-3, 1e-4, -0.5, 25.0), Regime.FORWARD_SLIP, None, False),  # slips back
        (Setting(1.5e-3, 1e-4, -0.5, 25.0), Regime.BACK_SLIP, None, True),
        (Setting(6e-4, 4.5e-4, -0.5, 25.0), Regime.BACK_SLIP, None, False),  # hops
        (Setting(6e-4, 4.5e-4, -0.5, 25.0), Regime.HOPPING, None, True),
        (Setting(6e-4, 4.5e-4, -0.5, 25.0), Regime.HOPPING, 9.0, False),  # may land on an edge
        (Setting(6e-4, 1e-4, -0.5, 25.0), Regime.BACK_SLIP, 9.0, True),
        (Setting(1.5e-3, 1e-4, -0.5, 25.0), Regime.BACK_SLIP, 1.0, False),  # tips
    ],
)
def test_bodies_of_an_ellipse_that_break_a_constraint_are_slowest(
    setting: Setting, highest: Regime, part: float | None, allowed: bool
) -> None:
    upright = {} if part is None else {"part": {"half_base_mm": part, "centre_height_mm": 10}}
    scene = {"static_friction": 0.4, "kinetic_friction": 0.36}
    question = asked({**ELLIPSE, "scene": scene, "drift": {}} | upright, highest)
    one = Setting(*(np.array([x]) for x in setting))
    box = question.box(setting)
    speeds = question.speeds(one, Scenarios.fixed(corners(box.varies)))
    solved = float(vibro.solve(question.nominal_scene(setting)).mean_velocity)
    assert speeds.tolist() == [[solved if allowed else -math.inf]]


def test_a_hard_landing_breaks_a_constraint() -> None:
    scene = {"static_friction": 0.4, "kinetic_friction": 0.36}
    drive = [{"amplitude_mm": "0.5:9", "frequency_hz": 15, "drive_angle_deg": 20}]
    free = asked({**LINE, "scene": scene, "drive": drive, "drift": {}}, Regime.HOPPING)
    hardest = 1e3 * float(vibro.solve(free.nominal_scene(line(6e-3))).impact_velocity)
    one = Setting(*(np.array([float(x)]) for x in line(6e-3)))
    for factor, allowed in ((1.001, True), (0.999, False)):
        goal = {"speed_mm_s": 5, "highest_regime": "hopping", "impact_speed_mm_s": factor * hardest}
        question = asked({"scene": scene, "drive": drive, "goal": goal}, Regime.HOPPING)
        speeds = question.speeds(one, Scenarios.fixed(np.zeros((5, 1))))
        assert bool(np.isfinite(speeds[0, 0])) is allowed


class Known:
    """A finder that finds designs of known speeds, and records what it is given."""

    def __init__(self, speeds: dict[tuple[str, Regime], float]) -> None:
        self.speeds = speeds
        self.asked: list[Any] = []

    def __call__(self, question: Question, calmer: Any) -> Any:
        place = question.drive.name, question.highest
        self.asked.append((*place, dict(calmer)))
        speed = self.speeds.get(place)
        bounds: Any = None
        found = Found(line(1e-3 * (1 + question.highest)), (), bounds)
        designs = {} if speed is None else dict.fromkeys(KINDS, found)

        def row(kind: str) -> Design:
            return Design(drive=place[0], highest_regime=place[1].label, design=kind, speed_min_mm_s=speed)

        return SimpleNamespace(found=designs, row=row)


TWO = {**LINE, "drive": [{**LINE["drive"][0], "name": name} for name in "ab"]}


def test_every_regime_takes_over_the_designs_of_the_lower_one(monkeypatch: pytest.MonkeyPatch) -> None:
    regimes = [Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING]
    known = Known({(name, regime): 4.0 for name in "ab" for regime in regimes[1:]})
    monkeypatch.setattr(designs, "find", known)
    progress: list[Any] = []
    result = find_designs(read_spec(TWO), lambda *done: progress.append(done))
    assert [(name, highest) for name, highest, _ in known.asked] == [(n, r) for n in "ab" for r in regimes]
    assert progress == [(3, 18), (6, 18), (9, 18), (12, 18), (15, 18), (18, 18)]
    # a drive begins anew
    assert [bool(calmer) for *_, calmer in known.asked] == [False, False, True] * 2
    amplitude = known.asked[2][2]["safest"].setting[0] / line(1e-3)[0]
    assert amplitude == pytest.approx(3.0)
    assert [d.design for d in result.designs] == [*KINDS] * 6
    settings = [None if s is None else s[0] / line(1e-3)[0] for s in result.settings]
    assert settings == pytest.approx([None] * 3 + [3.0] * 3 + [4.0] * 3 + [None] * 3 + [3.0] * 3 + [4.0] * 3)
    assert not result.met


@pytest.mark.parametrize(
    ("speeds", "met"),
    [
        ({("b", Regime.BACK_SLIP): 5.0}, True),  # just the goal
        ({("b", Regime.BACK_SLIP): 5.0 * (1 - 1e-12)}, False),
        ({("a", Regime.HOPPING): 9.0}, False),  # its own highest regime is back slip
        ({("a", Regime.FORWARD_SLIP): 9.0}, False),
        ({}, False),
    ],
)
def test_a_goal_is_met_within_its_regime(speeds: Any, met: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(designs, "find", Known(speeds))
    assert find_designs(read_spec(TWO)).met is met


@pytest.mark.parametrize(("met", "kind"), [(True, "safest"), (False, "fastest")])
def test_what_is_shown_is_the_safest_or_else_the_fastest_within_the_goal(met: bool, kind: str) -> None:
    spec = read_spec(TWO)
    rows = [
        Design(
            drive=name, highest_regime=regime, design=each, amplitude_mm=amplitude, frequency_hz=15.0,
            drive_angle_deg=20.0, speed_min_mm_s=speed,
        )
        for name, amplitude in (("a", 1.0), ("b", 2.0))
        for regime, speed in (("forward-slip", 9.0), ("back-slip", amplitude), ("hopping", 9.0))
        for each in KINDS
    ]  # fmt: skip
    chosen = chosen_of(spec, answered(met, *rows))
    assert chosen is not None
    assert (chosen.design.drive, chosen.design.highest_regime, chosen.design.design) == (
        "b",
        "back-slip",
        kind,
    )
    assert chosen.setting == pytest.approx(line(2e-3))
    assert chosen_of(spec, answered(met, *(r for r in rows if r.highest_regime != "back-slip"))) is None
    assert list(chosen.costs)[:2] == ["amplitude", "frequency"]
