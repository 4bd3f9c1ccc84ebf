"""Designs as they are printed: drawn bodies hold them, and neither choice nor rounding loses one."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from design import random_question
from helpers.questions import LOOSE, asked, one_drive

import vibro
from vibro.core.codes import Regime
from vibro.designs.design import chosen_of, find_designs
from vibro.designs.guarantees import guarantee_of
from vibro.designs.optima import LineOptimiser
from vibro.designs.reading import read_spec
from vibro.designs.rows import DIGITS, find
from vibro.designs.spaces import Setting
from vibro.designs.windows import Family, window_of

if TYPE_CHECKING:
    from vibro.results.designs import Design, DesignResult

BODIES = 400


def optimiser(question: dict[str, Any], highest: Regime = Regime.BACK_SLIP) -> LineOptimiser:
    return LineOptimiser(asked(question, highest))


# ------------------------------------------------------------------------------
# What is printed holds, by bodies that are drawn from the question as it was written.

# The gentlest setting reaches the goal just where back slip enters: no rounding of it holds.
VERTEX = one_drive(
    {"static_friction": 0.3841, "kinetic_friction": 0.3111, "trough_angle_deg": 9.795},
    {
        "amplitude_mm": 0.194,
        "frequency_hz": "27.28:54.56",
        "drive_angle_deg": "5:80",
        "acceleration_g": 1.421,
    },
    2.2135830290521503,
    drift={"frequency_percent": 0.8539},
    part={"half_base_mm": 7.485, "centre_height_mm": 8},
)
KNOWN: dict[str, Any] = {
    "scene": {"static_friction": 0.5, "kinetic_friction": 0.4, "trough_length_mm": 600},
    "drive": [
        {"name": "magnet", "stroke_mm": 1.1, "frequency_hz": 50, "drive_angle_deg": "10:40"},
        {"name": "motor", "amplitude_mm": 3, "frequency_hz": "1160rpm", "drive_angle_deg": 30},
    ],
    "goal": {"speed_mm_s": 5, "highest_regime": "forward-slip"},
}
#: No peak of the speed lies before the least load of this decline.
DECLINE = one_drive(
    {"static_friction": "0.44:0.54", "friction_ratio": "0.53:0.73", "trough_angle_deg": -4},
    {"amplitude_mm": 40, "frequency_hz": 40, "drive_angle_deg": 42},
    15,
)
GIVEN = one_drive(
    {"static_friction": 0.5, "friction_ratio": 0.8},
    {"amplitude_mm": 2, "frequency_hz": "1450rpm", "drive_angle_deg": "0.5rad", "acceleration_g": 1.5},
    5,
)
SLOW = one_drive(
    {"static_friction": "0.3:0.5", "friction_ratio": "0.7:0.9", "trough_angle_deg": 3},
    {"amplitude_mm": 0.8, "frequency_hz": 50, "drive_angle_deg": "5:60", "acceleration_g": 1.2},
    80,
)
OVAL_SLOW = one_drive(
    {"static_friction": "0.35:0.45", "friction_ratio": 0.9},
    {"along_amplitude_mm": 0.2, "normal_amplitude_mm": 0.08, "normal_phase_deg": -60, "frequency_hz": 50},
    80,
)
ASKED = {"known": KNOWN, "given": GIVEN, "slow": SLOW, "slow oval": OVAL_SLOW}  # fmt: skip


def drawn_question(seed: int) -> dict[str, Any]:
    """Draw a question about a drive along a line or an ellipse that keeps parts in contact."""
    rng = np.random.default_rng([54, seed])
    question = random_question(rng, "ellipse" if seed % 3 == 2 else "line", rng.uniform(-0.5, 0.5))
    question["goal"]["highest_regime"] = ("forward-slip", "back-slip")[seed % 2]
    return question


def span(given: Any) -> tuple[float, float]:
    low, _, high = str(given).partition(":")
    return float(low), float(high or low)


def bodies(question: dict[str, Any], motion: dict[str, float], *, seed: int = 0) -> vibro.SteadyCycle:
    """Solve bodies of a question under a motion [mm, Hz, deg]: within bands and drifts, many at ends."""
    rng = np.random.default_rng(seed)
    drift, scene = question.get("drift", {}), question["scene"]

    def within(low: float, high: float) -> Any:
        shares = rng.random(BODIES)
        return low + (high - low) * np.where(rng.random(BODIES) < 0.3, np.round(shares), shares)

    def off(percent: float) -> Any:
        return 1.0 + 0.01 * within(-percent, percent)

    amplitudes, values = off(drift.get("amplitude_percent", 0.0)), {}
    for name, value in motion.items():
        if name == "frequency":
            values[name] = value * off(drift.get("frequency_percent", 0.0))
        elif "amplitude" in name:
            values[name] = 1e-3 * value * amplitudes
        else:
            turn = drift.get(f"{name}_deg", 0.0)
            values[name] = np.radians(value + within(-turn, turn))
    mu_s = within(*span(scene["static_friction"]))
    ratio, known = scene.get("friction_ratio"), scene.get("kinetic_friction")
    mu_d = within(*span(ratio)) * mu_s if known is None else np.minimum(within(*span(known)), mu_s)
    low, high = span(scene.get("trough_angle_deg", 0.0))
    tilt = drift.get("trough_angle_deg", 0.0)
    return vibro.solve(
        vibro.Scene(
            **values,
            static_friction=mu_s,
            kinetic_friction=mu_d,
            trough_angle=np.radians(within(low - tilt, high + tilt)),
        ),
        flight=False,
    )


def motion_of(design: Design, factor: float = 1.0) -> dict[str, float]:
    """Return a design as it is printed, its amplitudes times a factor [mm, Hz, deg]."""
    assert design.frequency_hz is not None
    motion = {"frequency": design.frequency_hz}
    if design.normal_phase_deg is None:
        size = design.amplitude_mm if design.stroke_mm is None else 0.5 * design.stroke_mm
        sizes, motion["drive_angle"] = {"amplitude": size}, design.drive_angle_deg or 0.0
    else:
        sizes = {"along_amplitude": design.along_amplitude_mm, "normal_amplitude": design.normal_amplitude_mm}
        motion["normal_phase"] = design.normal_phase_deg
    return motion | {name: factor * (x or 0.0) for name, x in sizes.items()}


def assert_each_holds(question: dict[str, Any], designs: list[Design]) -> None:
    """Check each design by bodies: its speed, its regime, its window, and the nearest drive."""
    goal, label = question["goal"]["speed_mm_s"], question["goal"].get("highest_regime", "back-slip")
    highest = next(regime for regime in Regime if regime.label == label)
    for design in designs:
        least, nominal = design.speed_min_mm_s, design.nominal
        assert least is not None
        assert nominal is not None
        cycle = bodies(question, motion_of(design))
        assert cycle.regime.max() <= highest
        assert 1e3 * cycle.mean_velocity.min() >= least * (1.0 - 1e-9)
        assert 1e3 * cycle.mean_velocity.max() <= (design.speed_max_mm_s or 0.0) * (1.0 + 1e-9)
        assert design.restitution is None
        if design.window is not None:
            low, high = design.window
            assert low <= nominal * (1.0 + 1e-9)
            assert nominal <= high * (1.0 + 1e-9)
            for end in design.window:
                ends = bodies(question, motion_of(design, end / nominal))
                assert 1e3 * ends.mean_velocity.min() >= goal * (1.0 - 1e-6)
                assert ends.regime.max() <= highest
        if design.frequency_needed_hz is not None:
            assert least < goal
            size = design.amplitude_needed_mm if design.stroke_mm is None else design.stroke_needed_mm
            needed = motion_of(design, (size or 0.0) / nominal)
            there = bodies(question, needed | {"frequency": design.frequency_needed_hz})
            assert 1e3 * there.mean_velocity.min() >= goal
        length = question["scene"].get("trough_length_mm")
        assert design.traverse_time_max_s == (None if length is None else pytest.approx(length / least))


def assert_holds(question: dict[str, Any], result: DesignResult) -> None:
    """Check each design, and the three of each drive beside each other."""
    goal = question["goal"]["speed_mm_s"]
    found = [design for design in result.designs if design.frequency_hz is not None]
    assert_each_holds(question, found)
    for drive in {design.drive for design in found}:
        three = {design.design: design for design in found if design.drive == drive}
        speeds = [design.speed_min_mm_s or 0.0 for design in three.values()]
        assert three["fastest"].speed_min_mm_s == max(speeds)
        assert (len(three) == 3) is (max(speeds) >= goal)
        if len(three) == 3:
            assert three["gentlest"].acceleration_g == min(d.acceleration_g or 0.0 for d in three.values())
            margins = [design.margin for design in three.values() if design.margin is not None]
            assert not margins or three["safest"].margin == max(margins) >= 1.0
            assert min(speeds) >= goal
    assert result.met is any((design.speed_min_mm_s or 0.0) >= goal for design in found)


@pytest.mark.parametrize("seed", [1, 2, 4, 6, 7])
def test_designs_of_drawn_questions_hold(seed: int) -> None:
    question = drawn_question(seed)
    assert_holds(question, vibro.design(question, only="goal"))


@cache
def answer(name: str, digits: int = DIGITS) -> DesignResult:
    return vibro.design(ASKED[name], digits=digits, only="goal")


@pytest.mark.parametrize("name", ASKED)
def test_designs_of_hard_questions_hold(name: str) -> None:
    assert_holds(ASKED[name], answer(name))


def test_digits_are_as_few_as_hold_and_lose_little() -> None:
    """Of acceleration and speed about as much as one step of the last digit; what is given is kept."""
    fine, coarse = answer("known", 9), answer("known")
    assert coarse.met
    assert len(coarse.designs) == 6
    for best, printed in zip(fine.designs, coarse.designs, strict=True):
        assert (best.drive, best.design, best.set_by) == (printed.drive, printed.design, printed.set_by)
        assert printed.frequency_hz in (50.0, 19.3333333333333)
        for value in (printed.nominal, printed.drive_angle_deg):
            assert value == float(f"{value:.{DIGITS}g}")
        name = "acceleration_g" if best.design == "gentlest" else "speed_min_mm_s"
        sign = 1.0 if best.design == "gentlest" else -1.0
        lost = sign * (getattr(printed, name) / getattr(best, name) - 1.0)
        assert 0.0 <= lost < 3e-3
    given = {design.design: design.frequency_hz for design in answer("given").designs}
    assert given["fastest"] == pytest.approx(145 / 6, rel=1e-14)


@pytest.mark.parametrize(
    ("question", "acceleration"), [(VERTEX, 0.846747), (DECLINE, None)], ids=["vertex", "decline"]
)
def test_what_no_rounding_of_the_optimum_holds_is_rounded_beside_it(
    question: dict[str, Any], acceleration: float | None
) -> None:
    finder = find(asked(question), {}, until="gentlest")
    gentlest, fastest = finder.row("gentlest"), finder.row("fastest")
    assert_each_holds(question, [gentlest, fastest])
    if acceleration is not None:
        assert gentlest.acceleration_g == pytest.approx(acceleration, rel=2e-3)
        assert (gentlest.acceleration_g or 0.0) > acceleration
        return
    assert [design.amplitude_mm for design in (gentlest, fastest)] == [0.154, 0.2315]


def test_the_goals_regime_is_told_first_and_more_allowed_is_never_worse() -> None:
    scene, goal = {**KNOWN["scene"], "restitution": 0}, {"speed_mm_s": 5, "highest_regime": "back-slip"}
    motor = {"scene": scene, "drive": KNOWN["drive"][1:], "goal": goal}
    told: list[tuple[int, int, str]] = []
    whole = find_designs(read_spec(motor), lambda *done: told.append(done)).designs
    regimes = ("forward-slip", "back-slip", "hopping")
    kinds = ("gentlest", "fastest", "safest")
    searched = ("forward-slip at most", "back-slip at most", "hopping allowed")
    progress = [f"motor: {kind}, {where}" for where in searched for kind in ("fastest", "gentlest", "safest")]
    assert [what for *_, what in told if what] == [text for text in progress if text in {t[2] for t in told}]
    assert told[-1] == (9, 9, "")
    assert [(d.highest_regime, d.design) for d in whole] == [
        (regimes[n], kind) for n in (1, 0, 2) for kind in kinds
    ]
    assert whole[:3] == vibro.design(motor, only="goal").designs
    by = {(d.highest_regime, d.design): d for d in whole}
    for lower, higher in pairwise(regimes):
        faster, slower = (by[regime, "fastest"].speed_min_mm_s or 0.0 for regime in (higher, lower))
        harder, softer = (by[regime, "gentlest"].acceleration_g or 0.0 for regime in (lower, higher))
        assert faster >= slower
        assert softer <= harder


def test_with_known_frictions_the_gentlest_of_all_drives_is_shown() -> None:
    result = answer("known")
    chosen = chosen_of(read_spec(KNOWN), result)
    assert chosen is not None
    least = min(d.acceleration_g or math.inf for d in result.designs if d.design == "gentlest")
    assert (chosen.design.design, chosen.design.acceleration_g) == ("gentlest", least)
    assert chosen.design is next(d for d in result.designs if d.drive == "motor")
    assert not any(isinstance(cost, str) for cost in chosen.costs.values())


def test_a_question_in_stroke_is_answered_in_stroke() -> None:
    """The drive that was given an amplitude keeps it; the same question in amplitude has the same answer."""
    result = answer("known", 9)
    magnet, motor = result.designs[0], result.designs[3]
    for design, other in ((magnet, "amplitude"), (motor, "stroke")):
        assert [getattr(design, f"{other}{end}_mm") for end in ("", "_low", "_high", "_needed")] == [None] * 4
    assert [column.name for column in result.columns][3:5] == ["amplitude_mm", "stroke_mm"]
    halved = {**KNOWN["drive"][0], "amplitude_mm": 0.55}
    del halved["stroke_mm"]
    in_amplitude = vibro.design({**KNOWN, "drive": [halved]}, only="goal", digits=9)
    assert not any("stroke" in column.name for column in in_amplitude.columns)
    for one, two in zip(result.designs, in_amplitude.designs, strict=False):
        assert one.window == pytest.approx([2 * x for x in two.window or ()], rel=1e-8)
        assert one.nominal == pytest.approx(2 * (two.nominal or 0.0), rel=1e-8)


def test_the_nearest_drive_is_the_load_at_a_lower_frequency() -> None:
    question = {**SLOW, "goal": {"speed_mm_s": 80, "highest_regime": "forward-slip"}}
    fastest = vibro.design(question, digits=9, only="goal").designs[1]
    assert fastest.set_by == "back slip"
    assert fastest.frequency_needed_hz == pytest.approx(2.90252154972701, rel=1e-6)


# ------------------------------------------------------------------------------
# Optima that searches have missed.


def test_another_frequency_never_makes_a_goal_impossible() -> None:
    scene = {"static_friction": 0.2809, "friction_ratio": 0.845}
    drive = {"amplitude_mm": "0.04158:0.1326", "drive_angle_deg": 29.09}
    for frequencies in (41.9, [41.9, 59.86], [41.9, 59.86, 80.0]):
        question = one_drive(scene, {**drive, "frequency_hz": frequencies}, 0.8)
        best = optimiser(question, Regime.FORWARD_SLIP).fastest()
        assert best is not None
        assert best.speed == pytest.approx(1.4566775e-3, rel=1e-7)
        assert best.setting.frequency == 41.9


def test_more_drive_angles_never_lose_the_one_that_does_it() -> None:
    scene = {"static_friction": 0.2336, "kinetic_friction": "0.20764:0.22736", "trough_angle_deg": 3.496}
    for angles in ("50:56.81", "30:56.81", "11.81:56.81"):
        drive = {"amplitude_mm": 0.6002, "frequency_hz": 35.57, "drive_angle_deg": angles}
        best = optimiser(one_drive(scene, drive, 0.5, drift={"trough_angle_deg": 1.42426})).fastest()
        assert best is not None
        assert best.speed == pytest.approx(0.75956e-3, rel=1e-5)


def test_no_drift_lands_harder_than_the_limit() -> None:
    """At one load landings are hardest where the frequency is low and the amplitude high."""
    scene, shares = {"static_friction": 0.74, "kinetic_friction": 0.57}, np.linspace(-0.01, 0.01, 41)
    question = one_drive(
        scene, {"amplitude_mm": "8:12", "frequency_hz": "12:15", "drive_angle_deg": 20}, 100,
        drift={"amplitude_percent": 18, "frequency_percent": 11},
    )  # fmt: skip
    question["goal"] |= {"highest_regime": "hopping", "impact_speed_mm_s": 660}
    best = optimiser(question, Regime.HOPPING).fastest()
    assert best is not None
    turned = asked(question).space.turned(best.setting)
    sizes = {"amplitude": 1.0 + 18.0 * shares, "frequency": 1.0 + 11.0 * shares[:, None]}
    motion = {name: value * sizes.get(name, 1.0) for name, value in turned.items()}
    cycle = vibro.solve(vibro.Scene(**motion, **scene))
    assert np.nanmax(cycle.impact_velocity) <= 0.66 * (1 + 1e-3)


def test_a_window_that_no_search_confirmed_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    question = asked(one_drive(LOOSE["scene"], LOOSE["drive"][0], 20.0))
    setting = Setting(6e-4, 2.5e-4, math.radians(-50.0), 25.0)
    guarantee = guarantee_of(question.box(setting))
    assert guarantee.speed_min > 0.02  # so that the goal does not end it on either side
    monkeypatch.setattr(Family, "intervals", lambda *_, **__: [])
    assert window_of(question, setting, guarantee) == (6e-4, 6e-4, "unconfirmed", "unconfirmed")
