"""Designs and their rows with an optimiser of known answers: which is best, and what is printed of it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.questions import changed

import vibro
from vibro import Regime
from vibro.designs import rows
from vibro.designs.guarantees import Landings, guarantee_of
from vibro.designs.optima import Optimum
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.designs.rows import Finder, Rounded, more_digits
from vibro.designs.spaces import Setting
from vibro.results.designs import Guarantee, Interval

if TYPE_CHECKING:
    from collections.abc import Iterator

CONTENT: dict[str, Any] = {
    "scene": {"static_friction": "0.66:0.82", "friction_ratio": 0.77, "trough_length_mm": 600},
    "drive": [{"name": "motor", "amplitude_mm": "0.5:3", "frequency_hz": 15, "drive_angle_deg": "10:40"}],
    "goal": {"speed_mm_s": 10},
}
BOUNDS: dict[str, Any] = {
    "speed_min": 0.02, "speed_max": 0.05, "found_min": 0.02, "found_max": 0.05,
    "min_at": {}, "max_at": {}, "min_limit": "", "max_limit": "",
    "regimes": frozenset({Regime.FORWARD_SLIP}), "proof_min": "proved", "proof_max": "corners",
    "proved_min": 0.0199, "proved_max": 0.05, "certificate_min": None, "certificate_max": None,
    "coexists": True, "samples": 0, "excluded": 7,
}  # fmt: skip


def asked(**changes: Any) -> Question:
    spec = read_spec(changed(**(CONTENT | changes)))
    return Question(spec, spec.drives[0], Regime.BACK_SLIP)


SINGLE = {"static_friction": 0.74, "kinetic_friction": 0.57}


def found_at(
    amplitude: float = 1.0, *, margin: float | None = None, by: Any = None, **bounds: Any
) -> Rounded:
    """A design of an amplitude [mm] with a known guarantee."""
    question = asked()
    angle = math.radians(20.0)
    setting = question.space.setting(amplitude=1e-3 * amplitude, frequency=15.0, drive_angle=angle)
    return Rounded(setting, (amplitude, 15.0, 20.0), Guarantee(**(BOUNDS | bounds)), margin, by)


class Optimiser:
    """Answers by hand, and records what it is asked."""

    surpluses = (0.0, 0.1, 0.2)

    def __init__(self, **answers: Any) -> None:
        self.answers: dict[str, Any] = {
            "has_more": True,
            "holds": True,
            "keeps": True,
        } | answers
        self.asked: list[Any] = []

    def has_more(self) -> Any:
        return self.answers["has_more"]

    def first_cap(self) -> str:
        return "tip"

    def least_set_by(self, setting: Setting) -> str:
        return "onset"

    def limit(self, setting: Setting, scale: float) -> str:
        return f"limit at {scale:g}"

    def margin(self, setting: Any, target: float) -> Any:
        self.asked.append((float(np.hypot(*setting[:2])) if isinstance(setting, tuple) else setting, target))
        return self.answers["margin"]

    def fastest(self) -> Any:
        return self.answers.get("fastest")

    def safest(self, target: float) -> Any:
        return self.answers.get("safest")

    def least_acceleration(self, target: float) -> Any:
        self.asked.append(target)
        return self.answers.get("least", lambda _: None)(target)

    def holds(self, setting: Setting, target: float) -> Any:
        self.asked.append(target)
        return self.answers["holds"] and self.answers.get("speed", target) >= target

    def keeps_to_regime(self, *_: Any) -> Any:
        return self.answers["keeps"]


@pytest.fixture(autouse=True)
def proofs_are_tight(monkeypatch: pytest.MonkeyPatch) -> None:
    """All bodies of an optimum are as fast as the slowest that was found."""
    monkeypatch.setattr(Finder, "_bound", lambda _, optimum: getattr(optimum, "speed", math.inf))


def finder(optimiser: Any = None, found: dict[str, Rounded] | None = None, **changes: Any) -> Finder:
    known: Any = optimiser or Optimiser()
    return Finder(asked(**changes), known, found or {})


@pytest.mark.parametrize(
    ("kind", "speed", "margin", "expected"),
    [
        ("fastest", 0.02, 3.0, "limit at 1"),
        ("safest", 0.02, 3.0, "limit at 3"),
        ("safest", 0.02, None, "limit at 1"),
        ("gentlest", 0.02, 3.0, "onset"),  # twice as fast as needed
        ("gentlest", 0.01, 3.0, "speed"),
        ("gentlest", 0.01 * (1 + 5e-7), 3.0, "speed"),
        ("gentlest", 0.01 * (1 + 2e-6), 3.0, "onset"),
    ],
)
def test_what_sets_a_design(kind: str, speed: float, margin: float | None, expected: str) -> None:
    designs = {kind: found_at(speed_min=speed, margin=margin)}
    assert finder(found=designs).set_by(kind) == expected


@pytest.mark.parametrize(
    ("kind", "speed", "expected"),
    [("fastest", 0.02, "limit of 2 mm at 1"), ("gentlest", 0.01, "speed"), ("gentlest", 0.02, "onset")],
)
def test_what_sets_a_design_is_told_of_the_optimum_and_not_of_its_rounding(
    kind: str, speed: float, expected: str
) -> None:
    class Told(Optimiser):
        def limit(self, setting: Setting, scale: float) -> str:
            return f"limit of {1e3 * np.hypot(*setting[:2]):g} mm at {scale:g}"

    optimum = Optimum(found_at(2.0).setting, speed)
    designs = {kind: replace(found_at(1.9, speed_min=0.0101), optimum=optimum)}
    assert finder(Told(), found=designs).set_by(kind) == expected


@pytest.mark.parametrize(("highest", "expected"), [(Regime.BACK_SLIP, "onset"), (Regime.HOPPING, "speed")])
def test_a_gentlest_design_that_may_hop_is_not_set_by_the_onset(highest: Regime, expected: str) -> None:
    """Its speed jumps past the target where the hops change."""
    asks = finder(found={"gentlest": found_at(speed_min=0.02)})
    asks = replace(asks, question=replace(asks.question, highest=highest))
    assert asks.set_by("gentlest") == expected


def test_without_a_design_what_prevents_it_is_told_of_the_fastest() -> None:
    told = {kind: finder().set_by(kind) for kind in rows.KINDS}
    assert told == {"gentlest": None, "fastest": "tip", "safest": None}
    row = finder().row("fastest")
    assert (row.drive, row.highest_regime, row.design, row.set_by) == ("motor", "back-slip", "fastest", "tip")
    assert (row.amplitude_mm, row.speed_min_mm_s, row.margin, row.proof) == (None, None, None, None)


WINDOW = Interval(0.9e-3, 1.3e-3, "onset", "hop")


def test_every_number_of_a_row_has_its_column(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rows, "window_of", lambda *_: WINDOW)
    drift = {"amplitude_percent": 10}
    row = finder(found={"safest": found_at(margin=2.5)}, drift=drift).row("safest")
    load = 1e-3 * (2 * math.pi * 15.0) ** 2 / 9.81
    nominal = vibro.solve(
        vibro.Scene(
            amplitude=1e-3, frequency=15.0, drive_angle=math.radians(20.0), static_friction=0.74,
            kinetic_friction=0.77 * 0.74,
        )
    ).mean_velocity  # fmt: skip
    expected = {
        "drive": "motor", "highest_regime": "back-slip", "design": "safest", "amplitude_mm": 1.0,
        "frequency_hz": 15.0, "drive_angle_deg": 20.0, "acceleration_g": load, "speed_min_mm_s": 20.0,
        "speed_nominal_mm_s": 1e3 * float(nominal), "speed_max_mm_s": 50.0, "traverse_time_max_s": 30.0,
        "amplitude_low_mm": 0.9, "amplitude_high_mm": 1.3, "low_set_by": "onset", "high_set_by": "hop",
        "margin": 2.5, "throw_number_max": 1.1 * load * math.sin(math.radians(20.0)),
        "set_by": "limit at 2.5",
        "frequency_needed_hz": None, "amplitude_needed_mm": None, "proof": "proved", "coexists": True,
        "excluded": 7, "along_amplitude_mm": None,
    }  # fmt: skip
    for name, value in expected.items():
        given = getattr(row, name)
        assert given == (pytest.approx(value, rel=1e-12) if isinstance(value, float) else value), name


@pytest.mark.parametrize(
    ("bounds", "time", "least", "most"),
    [
        ({"speed_min": -math.inf, "speed_max": math.inf}, None, None, None),
        ({"speed_min": 0.0, "speed_max": 0.1}, None, 0.0, 100.0),
        ({"speed_min": -0.01, "speed_max": math.nan}, None, -10.0, None),
        ({"speed_min": 0.012, "speed_max": 0.1}, 50.0, 12.0, 100.0),
    ],
)
def test_what_is_not_finite_is_left_out(
    bounds: Any, time: float | None, least: float | None, most: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rows, "window_of", lambda *_: None)
    row = finder(found={"fastest": found_at(**bounds)}).row("fastest")
    assert row.traverse_time_max_s == (None if time is None else pytest.approx(time))
    assert (row.speed_min_mm_s, row.speed_max_mm_s) == (least, most)
    window = row.amplitude_low_mm, row.amplitude_high_mm, row.low_set_by, row.high_set_by
    assert window == (None, None, None, None)
    level = finder(
        found={"fastest": found_at(**bounds)},
        scene={k: CONTENT["scene"][k] for k in ("static_friction", "friction_ratio")},
    )
    assert level.row("fastest").traverse_time_max_s is None


SLOW: dict[str, Any] = {"scene": SINGLE, "goal": {"speed_mm_s": 10}}


def slow_finder(digits: int) -> tuple[Finder, Rounded]:
    """A design that moves a single part at half the speed of the goal."""
    question = asked(**SLOW)
    setting = question.space.setting(amplitude=0.78e-3, frequency=15.0, drive_angle=math.radians(20.0))
    known = guarantee_of(question.box(setting))
    goal = {"speed_mm_s": 2e3 * known.speed_min}
    by: Any = Optimiser()
    return Finder(asked(scene=SINGLE, goal=goal), by, {}, digits), Rounded(setting, (0.78, 15.0, 20.0), known)


@pytest.mark.parametrize("digits", [3, 4, 6, 9])
def test_the_nearest_drive_meets_the_goal_as_printed(digits: int) -> None:
    search, found = slow_finder(digits)
    frequency, amplitude = search._nearest_drive(found, 0.78, 15.0)
    assert frequency is not None
    assert amplitude is not None
    for value in (frequency, amplitude):
        assert float(f"{value:.{digits}g}") == value
    assert 7.5 * (1 - 20 * 10.0**-digits) <= frequency <= 7.5
    load = 0.78 * 15.0**2
    assert load * (1 - 10.0 ** (1 - digits)) <= amplitude * frequency**2 <= load * (1 + 1e-15)
    there = search.question.space.setting(
        amplitude=1e-3 * amplitude, frequency=frequency, drive_angle=math.radians(20.0)
    )
    assert guarantee_of(search.question.box(there)).speed_min >= search.target


def test_a_design_that_meets_the_goal_or_conveys_nothing_has_no_nearest_drive() -> None:
    search, found = slow_finder(4)
    for speed in (search.target, 2 * search.target, 0.0, -0.1, -math.inf):
        known = replace(found, guarantee=replace(found.guarantee, speed_min=speed))
        assert search._nearest_drive(known, 0.78, 15.0) == (None, None)


def test_a_row_of_a_slow_design_has_the_nearest_drive(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rows, "window_of", lambda *_: None)
    search, found = slow_finder(4)
    row = replace(search, found={"fastest": found}).row("fastest")
    assert (row.frequency_needed_hz, row.amplitude_needed_mm) == search._nearest_drive(found, 0.78, 15.0)


def test_a_row_of_a_stroke_is_in_stroke(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rows, "window_of", lambda *_: WINDOW)
    drive = [{"stroke_mm": "1:6", "frequency_hz": 15, "drive_angle_deg": "10:40"}]
    found = replace(found_at(), printed=(2.0, 15.0, 20.0))
    row = finder(found={"safest": found}, drive=drive).row("safest")
    assert (row.amplitude_mm, row.amplitude_low_mm, row.amplitude_high_mm) == (None, None, None)
    assert (row.stroke_mm, row.nominal) == (2.0, 2.0)
    assert row.window == (row.stroke_low_mm, row.stroke_high_mm) == pytest.approx((1.8, 2.6))
    slow, known = slow_finder(4)
    stroked = finder(found={}, scene=SINGLE, goal={"speed_mm_s": 1e3 * slow.target}, drive=drive)
    known = replace(known, printed=(1.56, 15.0, 20.0))
    row = replace(stroked, found={"fastest": known}).row("fastest")
    needed = slow._nearest_drive(known, 0.78, 15.0)
    assert needed[1] is not None
    assert row.stroke_needed_mm == pytest.approx(2 * needed[1], rel=2e-3)
    assert row.amplitude_needed_mm is None


@pytest.mark.parametrize(("kind", "best"), [("fastest", "quick"), ("gentlest", "small"), ("safest", "wide")])
def test_each_kind_has_its_merit(kind: str, best: str) -> None:
    """Among a new design, that of the lower regime, and the others of this one; missing ones are left out."""
    by = Optimiser()
    known = {
        "quick": found_at(2.0, speed_min=0.05, margin=2.0, by=by),
        "small": found_at(0.8, speed_min=0.02, margin=1.5, by=by),
        "wide": found_at(1.5, speed_min=0.03, margin=4.0, by=by),
        "bare": found_at(1.7, speed_min=0.001, margin=None, by=by),
    }
    for new in known:
        for calmer in known:
            others = [known[name] for name in known if name not in (new, calmer)]
            chosen = finder(by)._best(
                kind, known[new], {kind: known[calmer], "other": known["bare"]}, *others
            )
            assert chosen == known[best]
    assert finder(by)._best(kind, None, {}) is None
    assert finder(by)._best(kind, None, {kind: known["bare"]}) == known["bare"]


@pytest.mark.parametrize(
    ("speed", "known", "margin", "expected"),
    [
        (0.02, None, 3.0, 3.0),
        (0.02, None, None, 1.0),  # it meets the goal, so the margin is 1 at least
        (0.02, None, 0.5, 1.0),
        (0.02, 5.0, 3.0, 5.0),  # as known within a lower regime
        (0.01, 5.0, None, 5.0),
        (0.0099, 5.0, 0.4, 0.4),  # it misses the goal
        (0.0099, 5.0, None, None),
    ],
)
def test_margins_are_carried_over(
    speed: float, known: float | None, margin: float | None, expected: float | None
) -> None:
    optimiser = Optimiser(margin=margin)
    given = found_at(speed_min=speed, margin=known, by=Optimiser())
    found = finder(optimiser)._with_margin(given)
    by: Any = found.optimiser
    assert (found.margin, by) == (expected, optimiser)
    assert optimiser.asked == [(pytest.approx(1e-3), 0.01)]
    assert finder(optimiser)._with_margin(found) is found  # once is enough
    assert len(optimiser.asked) == 1
    assert finder(optimiser, scene=SINGLE)._with_margin(given) is given  # nothing varies


@pytest.fixture
def tried(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, bool]]:
    """Have every setting rounded to 1.2 mm and then to 1.1 mm; record the digits and the direction."""
    asked_for: list[tuple[int, bool]] = []

    def roundings(_: Any, setting: Setting, digits: int, *, up: bool) -> Iterator[tuple[float, ...]]:
        asked_for.append((digits, up))
        yield from [(1.2, 15.0, 20.0), (1.1, 15.0, 20.0)]

    monkeypatch.setattr(rows, "roundings", roundings)
    return asked_for


def first(found: Iterator[Rounded]) -> Rounded | None:
    return next(found, None)


def test_the_first_rounding_that_holds_is_taken(tried: list[tuple[int, bool]]) -> None:
    optimum = Optimum(found_at().setting, 0.02)
    found = first(finder()._rounded(optimum, 4, 0.001, 0.001, up=False))
    assert found is not None
    assert found.printed == (1.2, 15.0, 20.0)
    assert found.optimum is optimum
    assert found.setting == pytest.approx(found_at(1.2).setting)
    assert found.guarantee.speed_min == guarantee_of(asked().box(found.setting)).speed_min
    assert tried == [(4, False)]
    assert first(finder()._rounded(None, 4, 0.001, 0.001, up=False)) is None


@pytest.mark.parametrize("name", ["holds", "keeps"])
def test_a_rounding_that_breaks_a_condition_is_passed_over(name: str, tried: list[tuple[int, bool]]) -> None:
    optimum = Optimum(found_at().setting, 0.02)
    optimiser = Optimiser(**{name: False}, fastest=optimum)
    assert finder(optimiser)._fastest() is None
    assert tried == [(digits, False) for digits in more_digits(4)] * 2


@pytest.mark.parametrize(
    ("least", "digits"),
    [(0.0199, [4]), (0.0197, [4, 5, 6, 7, 9, 12, 15, 4]), (0.01, [4, 5, 6, 7, 9, 12, 15, 4])],
)
def test_the_fastest_loses_no_speed_by_rounding_if_any_rounding_keeps_it(
    least: float, digits: list[int], tried: list[tuple[int, bool]]
) -> None:
    """At most 1 % at four digits, a tenth of that at five."""
    optimiser = Optimiser(speed=least, fastest=Optimum(found_at().setting, 0.02))
    assert finder(optimiser)._fastest() is not None
    assert [n for n, _ in tried] == digits
    assert optimiser.asked[0] == pytest.approx(0.02 * 0.99)


@pytest.mark.parametrize(
    ("speed", "least"), [(0.0101, 0.01), (0.01, 0.01), (0.01 * (1 - 1e-12), 0.0099), (0.0102, 0.010098)]
)
def test_no_rounding_of_the_fastest_loses_a_goal_that_it_meets(
    speed: float, least: float, tried: list[tuple[int, bool]]
) -> None:
    """The goal is 10 mm/s; at four digits 1 % may be lost, if that is not the goal."""
    optimiser = Optimiser(fastest=Optimum(found_at().setting, speed))
    finder(optimiser)._fastest()
    assert optimiser.asked[0] == pytest.approx(least, rel=1e-11)


@pytest.mark.parametrize(
    ("margins", "amplitude", "digits"),
    [
        # of the optimum, and of each rounding in turn
        ([5.0, 4.96], 1.2, [4]),
        ([5.0, 4.94, 4.96], 1.1, [4]),
        ([5.0, 4.94, 4.93, 4.996], 1.2, [4, 5]),
        ([5.0, 4.94, 4.93, 4.99, 4.90, 4.998], 1.2, [4, 5, 6, 7, 9, 12, 15]),
    ],
)
def test_the_safest_loses_no_margin_by_rounding_if_any_rounding_keeps_it(
    margins: list[float], amplitude: float, digits: list[int], tried: list[tuple[int, bool]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """At most 1 % at four digits, a tenth of that at five; else the largest margin that was met counts."""
    left = iter(margins)
    optimiser = Optimiser(safest=Optimum(found_at().setting, 0.02))
    monkeypatch.setattr(optimiser, "margin", lambda *_: next(left, 1.0))
    found = finder(optimiser)._safest()
    assert found is not None
    assert found.margin == max(margins[1:])
    assert found.printed[0] == amplitude
    assert [n for n, _ in tried] == digits
    assert finder(Optimiser())._safest() is None


def test_a_rounding_that_is_slower_than_the_goal_is_passed_over(
    monkeypatch: pytest.MonkeyPatch, tried: list[tuple[int, bool]]
) -> None:
    speeds = {1.2: 0.0099, 1.1: 0.01}
    monkeypatch.setattr(
        rows,
        "guarantee_of",
        lambda box: Guarantee(**(BOUNDS | {"speed_min": speeds[round(1e3 * box.factor[0], 6)]})),
    )
    found = first(finder()._rounded(Optimum(found_at().setting, 0.02), 4, 0.01, 0.01, up=True))
    assert found is not None
    assert found.printed[0] == 1.1
    assert tried == [(4, True)]


def test_few_guarantees_are_computed_of_roundings_that_miss_their_speed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """They take long where parts hop; more digits have a better chance."""
    many = [(1.0 + 0.01 * i, 15.0, 20.0) for i in range(50)]
    boxes: list[Any] = []

    def missed(box: Any) -> Guarantee:
        boxes.append(box)
        return Guarantee(**(BOUNDS | {"speed_min": 0.009}))

    monkeypatch.setattr(rows, "roundings", lambda *_, up: iter(many))
    monkeypatch.setattr(rows, "guarantee_of", missed)
    assert first(finder()._rounded(Optimum(found_at().setting, 0.02), 4, 0.01, 0.01, up=True)) is None
    assert len(boxes) == 8


def of(monkeypatch: pytest.MonkeyPatch, speeds: dict[float, float]) -> None:
    """Let settings of an amplitude [mm] hold as printed with some speed."""

    def rounded(
        self: Finder, optimum: Any, digits: int, least: float, target: float, *, up: bool
    ) -> Iterator[Rounded]:
        if optimum is not None and speeds[optimum.setting] >= target:
            yield found_at(optimum.setting, speed_min=speeds[optimum.setting])

    monkeypatch.setattr(Finder, "_rounded", rounded)


def at(amplitude: float) -> Any:
    """An optimum of which nothing but the amplitude is known [mm]."""
    return Optimum(amplitude, 0.0)


def test_designs_of_a_goal_that_is_missed_are_the_fastest_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    of(monkeypatch, {2.0: 0.0099, 1.9: 0.01, 0.8: 0.01, 1.5: 0.01})
    optimiser = Optimiser(fastest=at(2.0), margin=None)
    assert list(finder(optimiser).designs({})) == ["fastest"]
    optimiser = Optimiser(fastest=at(1.9), margin=2.0, least=lambda _: at(0.8), safest=at(1.5))
    assert list(finder(optimiser).designs({})) == ["fastest", "gentlest", "safest"]
    assert finder(Optimiser()).designs({}) == {}
    calmer = {"fastest": found_at(), "other": found_at(2.0)}
    assert finder(Optimiser(has_more=False)).designs(calmer) == calmer


def test_designs_compete_with_each_other_and_with_the_lower_regime(monkeypatch: pytest.MonkeyPatch) -> None:
    of(monkeypatch, {2.0: 0.05, 0.8: 0.01, 1.5: 0.03})
    optimiser = Optimiser(fastest=at(2.0), margin=2.0, least=lambda _: at(0.8), safest=at(1.5))
    found = finder(optimiser).designs({})
    assert [found[kind].printed[0] for kind in ("fastest", "gentlest", "safest")] == [2.0, 0.8, 1.5]
    # the fastest is the gentlest where no other holds, and the safest where nothing is uncertain
    only = Optimiser(fastest=at(2.0), margin=2.0)
    assert {kind: f.printed[0] for kind, f in finder(only).designs({}).items()} == dict.fromkeys(
        ("fastest", "gentlest", "safest"), 2.0
    )
    assert finder(optimiser, scene=SINGLE).designs({})["safest"].printed[0] == 2.0
    calmer = {
        "fastest": found_at(1.0, speed_min=0.06),
        "gentlest": found_at(0.7, speed_min=0.01),
        "safest": found_at(1.2, speed_min=0.01, margin=5.0),
    }
    best = finder(optimiser).designs(calmer)
    assert [best[kind].printed[0] for kind in ("fastest", "gentlest", "safest")] == [1.0, 0.7, 1.2]
    # a wide fastest design is the safest too, even if the search for it ends elsewhere
    wide = {"fastest": replace(found_at(1.0, speed_min=0.06), margin=9.0)}
    assert finder(optimiser).designs(wide)["safest"].printed[0] == 1.0


@pytest.mark.parametrize(
    ("speed_of_least", "speed_of_safest", "best"), [(0.07, 0.06, 0.8), (0.06, 0.07, 1.5)]
)
def test_no_design_is_faster_than_the_fastest(
    monkeypatch: pytest.MonkeyPatch, speed_of_least: float, speed_of_safest: float, best: float
) -> None:
    """Even if the search for it, among sampled bodies, found a slower one."""
    of(monkeypatch, {2.0: 0.05, 0.8: speed_of_least, 1.5: speed_of_safest})
    found = finder(Optimiser(fastest=at(2.0), margin=2.0, least=lambda _: at(0.8), safest=at(1.5))).designs(
        {}
    )
    assert found["fastest"].printed[0] == best
    assert [found[kind].guarantee.speed_min for kind in ("gentlest", "safest")][best == 1.5] == 0.07


@pytest.mark.parametrize(("least", "best"), [(0.8, 0.7), (0.6, 0.6)])
def test_no_design_is_gentler_than_the_gentlest(
    monkeypatch: pytest.MonkeyPatch, least: float, best: float
) -> None:
    """Even if the search for it, among sampled bodies, found one of more acceleration than the safest has."""
    of(monkeypatch, {2.0: 0.05, least: 0.03, 0.7: 0.04})
    found = finder(Optimiser(fastest=at(2.0), margin=2.0, least=lambda _: at(least), safest=at(0.7)))
    assert found.designs({})["gentlest"].printed[0] == best


def test_a_nearest_drive_at_which_parts_land_too_hard_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    search, found = slow_finder(4)
    assert search._nearest_drive(found, 0.78, 15.0) != (None, None)
    monkeypatch.setattr(Landings, "worst", lambda self, box: np.zeros((len(box.axes), 1)))
    assert search._nearest_drive(found, 0.78, 15.0) == (None, None)


def test_a_higher_target_is_rounded_where_none_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    of(monkeypatch, {1.0: 0.0099, 1.1: 0.01, 1.2: 0.02})
    optimiser = Optimiser(least=lambda target: at({10: 1.0, 11: 1.1, 12: 1.2}[round(1e3 * target)]))
    found = finder(optimiser)._least_acceleration()
    assert found is not None
    assert found.printed[0] == 1.1
    assert found.optimum == at(1.0)  # what sets it is told of the goal's own optimum
    assert optimiser.asked == [0.01, pytest.approx(0.011)]
    assert finder(Optimiser())._least_acceleration() is None


@pytest.mark.parametrize(("share", "raised"), [(1.0, 1.0), (0.99991, 1.0), (0.8, 1.25), (0.0, 1.0)])
def test_a_goal_is_raised_until_the_target_is_proved(
    share: float, raised: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is proved is a share of the speed of the slowest part found; without a proof nothing is raised."""
    monkeypatch.setattr(Finder, "_bound", lambda _, optimum: share * optimum.speed)
    search = finder()
    goal = search._raised(lambda speed: Optimum(found_at().setting, speed))
    assert goal == pytest.approx(raised * search.target, rel=1e-12)


def test_a_target_is_raised_by_about_the_rounding_before_digits_are_added(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By 1e-3 to 1e-2 at four digits, by 1e-4 to 1e-3 at five; by anything at the last ones."""
    asked_for: list[tuple[int, float]] = []

    def rounded(self: Finder, optimum: Any, digits: int, *_: float, up: bool) -> list[Rounded]:
        asked_for.append((digits, round(optimum / 0.01 - 1.0, 9)))
        return []

    monkeypatch.setattr(Finder, "_rounded", rounded)
    optimiser = Optimiser(least=lambda target: target)
    optimiser.surpluses = (0.0, 1e-6, 1e-4, 1e-2)  # type: ignore[assignment]
    assert finder(optimiser)._least_acceleration() is None
    by_digits = {d: [s for n, s in asked_for if n == d] for d in more_digits(4)}
    assert by_digits == {
        4: [0.0, 1e-2], 5: [0.0, 1e-4], 6: [0.0, 1e-4], 7: [0.0, 1e-6], 9: [0.0, 1e-6], 12: [0.0, 1e-6],
        15: [0.0, 1e-6, 1e-4, 1e-2],
    }  # fmt: skip
    assert len(optimiser.asked) == 4  # each optimum is searched once
