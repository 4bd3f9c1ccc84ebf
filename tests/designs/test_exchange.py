"""The exchange of scenarios with an optimiser whose answers are known: limits, margins, repetitions."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.questions import changed

from vibro import Regime
from vibro.designs.guarantees import guarantee_of
from vibro.designs.optima import (
    MOST_MARGIN,
    Effort,
    EllipseOptimiser,
    Exchange,
    Found,
    LineOptimiser,
    Optimum,
)
from vibro.designs.proofs import corners
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.designs.spaces import SPACES, Setting

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

EFFORT = Effort(population=4, generations=10, polish=10, margins=5, margin=1e-6, scale=1e-6, exchanges=3)
SETTING = Setting(1e-3, 4e-4, 0.0, 15.0)
LINE = {
    "scene": {"static_friction": "0.66:0.82", "friction_ratio": 0.77},
    "drive": [{"amplitude_mm": "0.5:1.25", "frequency_hz": 15, "drive_angle_deg": "10:40"}],
}
OVAL = {
    "scene": LINE["scene"],
    "drive": [
        {
            "along_amplitude_mm": "0.1:3",
            "normal_amplitude_mm": "0.05:2",
            "normal_phase_deg": "-90:90",
            "frequency_hz": 25,
        }
    ],
}


class Known(Exchange):
    """An optimiser whose fastest setting has a known speed at every scale, and which records its calls."""

    surpluses = (0.0,)
    _least_set_by = "onset"

    def __init__(self, question: Question, speed: Callable[[float], float | None] = lambda _: None) -> None:
        box = question.box(SETTING)
        super().__init__(question, EFFORT, corners(box.varies))
        self.speed = speed
        self.calls: list[tuple[float, float]] = []

    def _fastest(self, scale: float, share: float = 1.0) -> Optimum | None:
        self.calls.append((scale, share))
        speed = self.speed(scale)
        return None if speed is None else Optimum(SETTING, speed)

    def _least_acceleration(self, target: float) -> Optimum | None:
        return Optimum(SETTING, target)

    def limit(self, found: Found, scale: float) -> str:
        return "limit"

    def first_cap(self) -> str:
        return "hop"


def asked(content: dict[str, Any], highest: Regime = Regime.BACK_SLIP, **more: Any) -> Question:
    """Ask of the first drive; several frequencies of a line are ranges here."""
    spec = read_spec(changed(**(content | more)))
    (drive,) = spec.drives
    if drive.space.proves:
        ranges = ((10.0, 12.0), (15.0, 15.0), (20.0, 25.0))
        drive = replace(drive, choices={**drive.choices, "frequency": ranges})
    return Question(spec, drive, highest)


def line(amplitude: float, frequency: float = 15.0, angle_deg: float = 20.0) -> Setting:
    (space,) = (space for space in SPACES.values() if space.proves)
    return space.setting(amplitude=amplitude, frequency=frequency, drive_angle=math.radians(angle_deg))


@pytest.mark.parametrize(
    ("share", "allowed"), [(0.5, True), (1.0, True), (1 + 5e-13, True), (1 + 1e-11, False)]
)
def test_an_acceleration_at_its_limit_is_allowed(share: float, allowed: bool) -> None:
    question = asked(LINE)
    setting = line(share * 1e-3)
    limit = 1e-3 * (2 * math.pi * 15.0) ** 2 / 9.81
    limited = replace(question, drive=replace(question.drive, acceleration=limit))
    assert Known(limited).is_allowed(setting) is allowed
    assert Known(question).is_allowed(setting)


def test_without_bands_the_safest_setting_is_the_fastest_that_reaches_the_goal() -> None:
    single = asked(LINE, scene={"static_friction": 0.74, "kinetic_friction": 0.57})
    for speed, target, reaches in ((0.02, 0.02, True), (0.02, 0.01, True), (0.02, 0.021, False)):
        optimiser = Known(single, lambda _, speed=speed: speed)  # type: ignore[misc]
        optimiser.finds_slower = lambda *_: False  # type: ignore[method-assign]
        assert optimiser.safest(target) == (Optimum(SETTING, speed) if reaches else None)
        assert optimiser.calls == [(1.0, 1.0)]
    assert Known(single).safest(0.01) is None


def test_no_setting_is_safe_that_does_not_reach_the_goal() -> None:
    assert Known(asked(LINE), lambda _: 0.0099)._safest(0.01) == (None, 1.0)
    assert Known(asked(LINE))._safest(0.01) == (None, 1.0)
    found, scale = Known(asked(LINE), lambda s: 0.02 if s < 3.0 else None)._safest(0.01)
    assert found is not None
    assert scale == pytest.approx(3.0, abs=1e-5)


def known_least(speed: Callable[[Floats], Floats], holds: Callable[[Floats], Any]) -> Known:
    """Make an optimiser with a known least speed, and critical loads, at every scale."""
    optimiser = Known(asked(LINE))

    def least(setting: Setting, scale: Floats | float) -> Floats:
        return speed(np.atleast_1d(scale))

    def allowed(setting: Setting, scale: Floats | float) -> Any:
        return holds(np.atleast_1d(scale))

    optimiser.least, optimiser._holds = least, allowed  # type: ignore[method-assign]
    return optimiser


@pytest.mark.parametrize(
    ("speed", "most", "margin"),
    [(0.04, 99.0, 4.0), (0.04, 2.5, 2.5), (0.005, 99.0, 0.5), (0.2, 99.0, 10.0), (0.2, 0.3, 0.3)],
)
def test_a_margin_ends_where_speed_or_regime_fail(speed: float, most: float, margin: float) -> None:
    optimiser = known_least(lambda s: speed / np.maximum(s, 1e-9), lambda s: s <= most)
    found = optimiser._margin(SETTING, 0.01)
    assert found == (pytest.approx(margin, abs=1.1e-6) if margin < MOST_MARGIN else MOST_MARGIN)
    assert found is not None
    assert found <= margin


def test_a_setting_that_fails_without_any_band_has_no_margin() -> None:
    assert known_least(lambda s: 0.0099 - 0.0 * s, lambda s: s < 99.0)._margin(SETTING, 0.01) is None
    assert known_least(lambda s: 0.02 - 0.0 * s, lambda s: s < 0.0)._margin(SETTING, 0.01) is None
    # at the middle of all bands it just holds, but no wider
    assert known_least(lambda s: 0.01 - s, lambda s: s < 99.0)._margin(SETTING, 0.01) == 0.0


@pytest.mark.parametrize(
    ("speed", "allowed", "holds"), [(0.01, True, True), (0.00999, True, False), (0.02, False, False)]
)
def test_a_setting_holds_at_its_goal_within_the_regime(speed: float, allowed: bool, holds: bool) -> None:
    optimiser = known_least(lambda s: speed + 0.0 * s, lambda s: np.full(s.shape, allowed))
    assert optimiser.holds(SETTING, 0.01) is holds


@pytest.mark.parametrize(("surplus", "slower"), [(-1e-6, False), (0.0, False), (5e-10, False), (1e-8, True)])
def test_a_body_joins_that_is_slower_than_the_scenarios(surplus: float, slower: bool) -> None:
    question = asked(LINE, drift={"amplitude_percent": 2})
    setting = line(1.0e-3)
    guarantee = guarantee_of(question.box(setting))
    optimiser = Known(question)
    optimiser.scenarios = optimiser.scenarios.fixed(np.full((5, 1), 0.5))
    assert optimiser.finds_slower(Optimum(setting, guarantee.speed_min * (1.0 + surplus))) is slower
    # the slowest body, at five loads of its band and at its own
    assert optimiser.scenarios.size == 1 + 6 * slower
    if slower:
        assert sorted(optimiser.scenarios.coordinates[0, 1:].tolist()) == [0.0, 0.0, 0.25, 0.5, 0.75, 1.0]
        assert not optimiser.finds_slower(Optimum(setting, guarantee.speed_min * (1.0 + surplus)))


def test_bodies_beyond_the_checked_regime_are_slowest() -> None:
    question = asked(LINE, Regime.FORWARD_SLIP)
    setting = line(1.1e-3)
    assert max(guarantee_of(question.box(setting)).regimes) is Regime.BACK_SLIP
    optimiser = Known(question)
    optimiser.scenarios = optimiser.scenarios.fixed(np.full((5, 1), 0.5))
    assert not optimiser.finds_slower(Optimum(setting, 1e-9))
    optimiser._checked = Regime.FORWARD_SLIP
    assert optimiser.finds_slower(Optimum(setting, 1e-9))


@pytest.mark.parametrize("content", [LINE, OVAL])
@pytest.mark.parametrize(
    ("highest", "restitution", "place"),
    [(Regime.BACK_SLIP, 0.3, 0), (Regime.HOPPING, 0.0, 1), (Regime.HOPPING, 0.3, 2)],
)
def test_bodies_that_are_slow_to_solve_are_searched_less(
    content: dict[str, Any], highest: Regime, restitution: float, place: int
) -> None:
    question = asked(content, highest, scene={**content["scene"], "restitution": restitution})
    search = (LineOptimiser if content is LINE else EllipseOptimiser)(question)
    assert search._effort is search._efforts[place]
    # limits of the load keep lines to the regime
    assert search._checked is (Regime.HOPPING if content is LINE else highest)
