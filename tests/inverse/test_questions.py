"""Questions, their uncertainty sets and scenarios, beside what a short calculation gives."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import vibro
from vibro import Regime
from vibro.inverse.designs import chosen_of, find_designs
from vibro.inverse.ellipses import EllipseOptimiser
from vibro.inverse.exchange import Found
from vibro.inverse.guarantees import guarantee_of
from vibro.inverse.lines import LineOptimiser
from vibro.inverse.proofs import corners
from vibro.inverse.questions import Question
from vibro.inverse.reading import read_spec
from vibro.inverse.scenarios import Scenarios
from vibro.inverse.spaces import SPACES, Setting

LINE = {
    "scene": {"static_friction": "0.66:0.82", "friction_ratio": 0.77},
    "drive": [{"amplitude_mm": "0.5:3", "frequency_hz": 15, "drive_angle_deg": "10:40"}],
    "drift": {"amplitude_percent": 2, "frequency_percent": 1, "drive_angle_deg": 0.5},
    "goal": {"speed_mm_s": 5},
}
ELLIPSE = {
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
