"""Windows with known speeds: intervals of a scan, parts that are confirmed, and what ends them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.questions import changed
from helpers.scenes import scene_with

import vibro
from vibro import InputError, Regime, solve
from vibro.designs import windows
from vibro.designs.guarantees import Extreme, Landings, guarantee_of
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.designs.spaces import Setting, uncertainty_set
from vibro.designs.windows import Family, _Detail, _Part, _Scan, span_of, window_of
from vibro.limits import critical_loads
from vibro.results.designs import Interval

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

FINE = _Detail(9, 2, 0.0, 33)


def family(drift: float = 0.0, landings: Landings | None = None, **bands: Any) -> Family:
    box = uncertainty_set(scene_with(), bands)
    made = Family(replace(box, factor=(1.0, 1.0)), drift)
    return made if landings is None else replace(made, landings=landings)


def one_load(name: str, **fields: Any) -> float:
    """Amplitude [m] at which a regime begins for a part of the published example."""
    scene = scene_with(**({"amplitude": 1.0} | fields))
    return float(getattr(critical_loads(scene), name) / scene.load)


@pytest.mark.parametrize(
    ("highest", "names"),
    [
        (Regime.FORWARD_SLIP, ["hop", "back slip", "limit"]),
        (Regime.BACK_SLIP, ["hop", "limit"]),
        (Regime.HOPPING, ["limit"]),
    ],
)
def test_caps_are_of_the_first_part_and_the_drift(highest: Regime, names: list[str]) -> None:
    caps = family(0.05, static_friction=(0.7, 0.8)).caps(highest, 7.0, {})
    assert list(caps) == names  # of equal caps the first is named
    expected = {"hop": one_load("hop"), "back slip": one_load("back_slip", static_friction=0.7)}
    for name in names[:-1]:
        assert caps[name] == pytest.approx(expected[name] / 1.05, rel=1e-9)
        assert caps[name] < expected[name] / 1.05
    assert caps["limit"] == 7.0


def test_other_caps_count_and_what_never_happens_is_no_cap() -> None:
    level = family(drive_angle=(0.0, 0.0))
    caps = level.caps(Regime.BACK_SLIP, math.inf, {"tip": 3.0})
    assert caps == {"tip": pytest.approx(3.0, rel=1e-11), "hop": math.inf, "limit": math.inf}
    assert caps["tip"] < 3.0


def test_boxes_of_a_family_drift_both_ways() -> None:
    box = family(0.1).across(2.0, 3.0)
    assert box.factor == pytest.approx((1.8, 3.3))
    many = family(0.1).boxes(np.array([[1.0], [2.0]]))
    assert np.ravel(many.factor[0]) == pytest.approx([0.9, 1.8])
    assert np.ravel(many.factor[1]) == pytest.approx([1.1, 2.2])


@dataclass(frozen=True)
class Known(_Scan):
    """A scan with a known speed of every amplitude."""

    speed: Callable[[Floats], Floats] = np.asarray
    changes: tuple[float, ...] = ()

    def _speeds(self, amplitudes: Floats) -> Floats:
        return np.asarray(self.speed(amplitudes))[:, None]

    def criticals(self) -> list[float]:
        return list(self.changes)


def scan(speed: Callable[[Floats], Floats], target: float, *changes: float) -> Known:
    return Known(family(), np.zeros((6, 1)), target, False, speed, changes)


def test_ends_of_parts_are_where_the_speed_crosses_the_target() -> None:
    """4 - (a - 3)^2 reaches 3 from 2 to 4."""
    known = scan(lambda a: 4.0 - (a - 3.0) ** 2, 3.0)
    (found,) = known.parts(1.0, 6.0, FINE)
    assert found == pytest.approx((2.0, 4.0, 2.0, 4.0), rel=1e-12)
    assert found.below < found.low < found.high < found.above
    assert 4.0 - (found.low - 3.0) ** 2 >= 3.0 <= 4.0 - (found.high - 3.0) ** 2
    (near,) = known.parts(1.0, 6.0, FINE._replace(end=0.1))
    assert 2.0 <= near.low <= 2.3
    assert 3.6 <= near.high <= 4.0


def test_parts_may_begin_at_the_onset_and_end_at_the_cap() -> None:
    (found,) = scan(lambda a: 1.0 + 0.0 * a, 1.0).parts(1.5, 6.0, FINE)
    assert found == pytest.approx((1.5, 6.0, math.nan, math.nan), nan_ok=True)  # just the target is enough
    assert scan(lambda a: 1.0 - 1e-12 + 0.0 * a, 1.0).parts(1.5, 6.0, FINE) == []
    for top in (1.5, 1.0):
        assert scan(lambda a: 2.0 + 0.0 * a, 1.0).parts(1.5, top, FINE) == []


def test_a_scan_without_an_onset_begins_far_below_the_first_change() -> None:
    (found,) = scan(lambda a: a + 1.0, 1.0, 2.0, 3.0).parts(0.0, 6.0, FINE)
    assert found[:2] == pytest.approx((2e-3, 6.0))
    (found,) = scan(lambda a: a + 1.0, 1.0).parts(0.0, 6.0, FINE)
    assert found[:2] == pytest.approx((6e-3, 6.0))


@pytest.mark.parametrize("centre", [3.3, 3.0, 2.71])
def test_a_narrow_dip_parts_an_interval(centre: float) -> None:
    """Between two amplitudes of the grid, below the target within 2 per mille of itself."""
    known = scan(lambda a: 0.999 + np.abs(a / centre - 1.0), 1.0)
    below, above = known.parts(1.0, 6.0, FINE)
    assert (below.high, above.low) == pytest.approx((0.999 * centre, 1.001 * centre), rel=1e-9)
    assert len(known.parts(1.0, 6.0, FINE._replace(rounds=0))) == 1


@pytest.mark.parametrize("centre", [3.3, 2.71, 1.61])
def test_a_narrow_peak_makes_an_interval(centre: float) -> None:
    known = scan(lambda a: 1.001 - np.abs(a / centre - 1.0), 1.0)
    (found,) = known.parts(1.0, 6.0, FINE)
    assert found[:2] == pytest.approx((0.999 * centre, 1.001 * centre), rel=1e-9)
    assert known.parts(1.0, 6.0, FINE._replace(rounds=0)) == []
    # where parts rest or run back no peak is looked at
    below = scan(lambda a: 1.001 - 30.0 * np.abs(a / centre - 1.0), 1.0)
    assert below.parts(1.0, 6.0, FINE._replace(amplitudes=5, rounds=1)) == []


def test_both_sides_of_a_change_are_looked_at() -> None:
    """From 3 on to 3.0001 the speed drops; a change outside of the range is left out."""
    known = scan(lambda a: np.where((a > 3.0) & (a < 3.0001), 0.5, 1.5), 1.0, 0.5, 3.0, 7.0)
    found = known.parts(1.0, 6.0, FINE._replace(rounds=0))
    assert [i[:2] for i in found] == [(1.0, pytest.approx(3.0)), (pytest.approx(3.0001), 6.0)]
    assert found[-1].high == 6.0


def test_what_lies_beyond_the_cap_does_not_count() -> None:
    (found,) = scan(lambda a: np.where(a > 6.5, 0.5, 1.5), 1.0, 7.0).parts(1.0, 6.0, FINE)
    assert found[:2] == (1.0, 6.0)


def test_bodies_that_land_too_hard_are_slowest() -> None:
    """Of two parts of the published example, thrown at 6 mm."""
    bodies = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 1.0], *[[0.0, 0.0]] * 2])
    hardest = float(solve(scene_with(amplitude=6e-3)).impact_velocity)
    bands: dict[str, Any] = {"static_friction": (0.6, 0.74)}
    for share, allowed in ((1.001, True), (0.999, False)):
        made = family(landings=Landings(impact_speed=share * hardest), **bands)
        speeds = _Scan(made, bodies, 0.01, True)._speeds(np.array([1e-3, 6e-3]))
        assert np.isfinite(speeds[0]).all()
        assert np.isfinite(speeds[1]).tolist() == [allowed, allowed]
    # parts in flight are not solved where none may hop
    assert np.isnan(_Scan(family(**bands), bodies, 0.01, False)._speeds(np.array([6e-3]))).all()


@pytest.mark.parametrize(
    ("speed", "percent", "limit"), [(1e-300, 0.0, 1e-3), (0.02, 0.0, math.inf), (0.02, 99.999, 2e-3)]
)
def test_arguments_at_their_edges_are_allowed(
    speed: float, percent: float, limit: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[Any] = []

    def intervals(self: Family, *args: Any) -> list[Interval]:
        calls.append((self.drift, *args))
        return []

    monkeypatch.setattr(Family, "intervals", intervals)
    assert vibro.feasible_amplitudes(scene_with(), speed, amplitude_percent=percent, limit=limit) == []
    assert calls == [(pytest.approx(percent / 100), speed, Regime.BACK_SLIP, limit)]
    refused: list[dict[str, Any]] = [
        {"amplitude_percent": 100.0},
        {"amplitude_percent": -1e-9},
        {"limit": 0.0},
    ]
    for options in refused:
        with pytest.raises(InputError, match=next(iter(options))):
            vibro.feasible_amplitudes(scene_with(), speed, **options)


@pytest.mark.parametrize(
    ("near", "index"), [(1.2, 0), (1.9, 0), (2.0 * (1 + 1e-7), 0), (3.5, 1), (5.9, 1), (2.5, None)]
)
def test_only_the_part_around_an_amplitude_is_returned(near: float, index: int | None) -> None:
    known = scan(lambda a: np.where((a > 2.0) & (a < 3.0), 0.0, 1.0), 1.0, 2.0, 3.0)
    both = known.parts(1.0, 6.0, FINE)
    assert len(both) == 2
    found = known.parts(1.0, 6.0, FINE, near)
    assert [i[:2] for i in found] == ([] if index is None else [both[index][:2]])


def extreme(speed: float) -> Extreme:
    return Extreme(speed, np.zeros((6, 1)), scene_with())


NONE = np.empty((6, 0))


def slowest_of(
    monkeypatch: pytest.MonkeyPatch, speed: Callable[[float], float], landing: Any = NONE
) -> list[Any]:
    """Let the slowest body between two factors have the least known speed; return the record of calls."""
    calls: list[Any] = []

    def slowest(self: Family, low: float, high: float) -> tuple[Extreme, Any]:
        calls.append((low, high))
        return extreme(min(speed(float(x)) for x in np.linspace(low, high, 101))), landing

    monkeypatch.setattr(Family, "_slowest", slowest)
    return calls


@pytest.mark.parametrize(
    ("inside", "outside", "expected"),
    [(1e-3, 0.99999e-3, "speed"), (1.19e-3, 1.1905e-3, "back slip"), (7e-4, 6e-4, "onset"),
     (3.2e-3, 3.3e-3, "hop"), (3.3e-3, 3.2e-3, "hop")],
)  # fmt: skip
def test_a_jump_is_named_by_the_regimes_beside_it(
    inside: float, outside: float, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the published example, which slips from 0.685 mm on, slips back from 1.190 and hops from 3.229."""
    slowest_of(monkeypatch, lambda _: 0.0)
    assert family().set_by(inside, outside, 1.0, 1e-6 if expected == "speed" else 0.0) == expected
    assert family().set_by(inside, outside, 0.0) == "unconfirmed"
    slowest_of(monkeypatch, lambda _: 0.0, np.zeros((6, 1)))
    assert family().set_by(inside, outside, 0.0) == "limit"


@pytest.mark.parametrize(
    ("width", "drop", "expected"),
    [(1e-9, 0.99e-6, "speed"), (1e-9, 1.01e-6, "back slip"), (1e-5, 0.99e-3, "speed"),
     (1e-5, 1.01e-3, "back slip")],
)  # fmt: skip
def test_between_distant_ends_a_speed_may_change_without_a_jump(
    width: float, drop: float, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    slowest_of(monkeypatch, lambda _: 0.0)
    monkeypatch.setattr(windows, "speeds_of", lambda *_, **__: np.array([[1.0], [1.0 - drop]]))
    assert family().set_by(1.19e-3, 1.1905e-3, 1.0, width) == expected


def test_parts_of_an_interval_are_confirmed(monkeypatch: pytest.MonkeyPatch) -> None:
    """From 1 to 16, missed between 3 and 5 and above 12."""
    calls = slowest_of(monkeypatch, lambda a: 0.0 if 3.0 < a < 5.0 or a > 12.0 else 2.0)

    def confirmed(low: float, high: float, near: float | None = None) -> list[Any]:
        return family()._confirmed(_Part(low, high, 0.9 * low, 1.1 * high), 1.0, FINE, near)

    first, last = confirmed(1.0, 16.0)
    assert first == pytest.approx((1.0, 3.0, 0.9, 3.0), rel=0.04)
    assert last == pytest.approx((5.0, 12.0, 5.0, 12.0), rel=0.04)
    assert first.high < first.above
    assert last.below < last.low < last.high < last.above
    assert {low == high for low, high in calls} == {True, False}  # ends by themselves, and whole parts
    assert confirmed(6.0, 11.0) == [(6.0, 11.0, 0.9 * 6.0, 1.1 * 11.0)]
    assert confirmed(3.5, 4.5) == []
    (near,) = confirmed(1.0, 16.0, 7.0)
    assert near == pytest.approx(last, rel=2e-9)
    assert confirmed(1.0, 16.0, 4.0) == []
    assert confirmed(1.0, 2.0, 2.0 * (1 + 1e-9)) == [(1.0, 2.0, 0.9, 1.1 * 2.0)]  # rounding


@pytest.mark.parametrize(
    ("speed", "landing", "holds"),
    [(1.0, NONE, True), (1.0 - 5e-10, NONE, True), (1.0 - 2e-9, NONE, False), (2.0, np.zeros((6, 1)), False)],
)
def test_a_range_holds_that_is_fast_enough_and_lands_softly(
    speed: float, landing: Any, holds: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    slowest_of(monkeypatch, lambda _: speed, landing)
    assert family(static_friction=(0.7, 0.8))._holds(1.0, 2.0, 1.0) is holds


@pytest.mark.parametrize("slow", [1.0, 1.5, 2.0])
def test_slower_bodies_are_looked_for_at_both_ends_too(slow: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A search of the whole interval may miss a body of a sliver at its end."""

    def slowest(self: Family, low: float, high: float) -> tuple[Extreme, Any]:
        return extreme(0.0 if low == high == slow or (slow == 1.5 and low < high) else 2.0), NONE

    monkeypatch.setattr(Family, "_slowest", slowest)
    assert not family()._holds(1.0, 2.0, 1.0)
    assert family()._holds(3.0, 3.0, 1.0)


@pytest.mark.parametrize(
    ("bands", "restitution", "highest", "points"),
    [
        ({}, 0.0, Regime.HOPPING, 32769),
        ({}, 0.3, Regime.BACK_SLIP, 4097),
        ({}, 0.3, Regime.HOPPING, 4097),
        ({"static_friction": (0.7, 0.8)}, 0.3, Regime.BACK_SLIP, 257),
        ({"static_friction": (0.7, 0.8)}, 0.0, Regime.HOPPING, 129),
        ({"static_friction": (0.7, 0.8)}, 0.3, Regime.HOPPING, 33),
    ],
)
def test_bodies_that_are_slow_to_solve_are_scanned_less(
    bands: Any, restitution: float, highest: Regime, points: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    details: list[Any] = []
    whole = _Part(1e-3, 2.5e-3, math.nan, math.nan)

    def parts(self: _Scan, start: float, top: float, detail: Any, near: Any = None) -> list[_Part]:
        details.append((start, top, detail.amplitudes, self.flies, near))
        return [whole]

    monkeypatch.setattr(_Scan, "parts", parts)
    monkeypatch.setattr(Family, "_confirmed", lambda *_: [whole._replace(low=2e-3)])
    made = family(**bands)
    made = replace(made, template=replace(made.template, restitution=(restitution,) * 2))
    found = made.intervals(0.01, highest, 2.5e-3, near=7.0)
    onset = one_load("forward_onset", static_friction=0.8 if bands else 0.74)
    assert details == [(pytest.approx(onset), 2.5e-3, points, highest is Regime.HOPPING, 7.0)]
    assert found == [(2e-3 if bands else 1e-3, 2.5e-3, "onset", "limit")]


def test_an_interval_without_an_end_is_scanned_beyond_every_change() -> None:
    """A level drive down a decline throws no part."""
    scene = scene_with(
        drive_angle=0.0, trough_angle=math.radians(-5), static_friction=0.4, kinetic_friction=0.3
    )
    made = Family(replace(uncertainty_set(scene, {}), factor=(1.0, 1.0)), 0.0)
    (found,) = made.intervals(0.05, Regime.BACK_SLIP, math.inf)
    assert found[1:] == (math.inf, "speed", "limit")
    (found,) = made.intervals(0.05, Regime.BACK_SLIP, 0.5)
    assert found[1:] == (0.5, "speed", "limit")


# Windows of designs

LINE = {"amplitude_mm": "0.9:1.4", "frequency_hz": 15, "drive_angle_deg": 20}
OVAL = {
    "along_amplitude_mm": "0.1:1", "normal_amplitude_mm": "0.05:0.25", "normal_phase_deg": -50,
    "frequency_hz": 25,
}  # fmt: skip


def asked(drive: dict[str, Any], highest: Regime = Regime.BACK_SLIP, **more: Any) -> Question:
    content = {"scene": {"static_friction": "0.7:0.78", "friction_ratio": 0.77}, "drive": [drive]}
    spec = read_spec(changed(**({**content, "goal": {"speed_mm_s": 5}} | more)))
    return Question(spec, spec.drives[0], highest)


def test_the_amplitudes_of_a_drive_in_the_proportions_of_a_setting() -> None:
    """Three to one: the normal amplitude ends first at both ends."""
    assert span_of(asked(OVAL), Setting(6e-4, 2e-4, -0.5, 25.0)) == pytest.approx((1.5e-4, 7.5e-4))
    # eight to one: the one along the trough does, above
    assert span_of(asked(OVAL), Setting(8e-4, 1e-4, -0.5, 25.0)) == pytest.approx((4e-4, 1e-3))
    level = {**OVAL, "along_amplitude_mm": 0}
    assert span_of(asked(level), Setting(0.0, 2e-4, -0.5, 25.0)) == pytest.approx((5e-5, 2.5e-4))
    setting = asked(LINE).space.setting(amplitude=1e-3, frequency=15.0, drive_angle=math.radians(20.0))
    assert span_of(asked(LINE), setting) == pytest.approx((9e-4, 1.4e-3))


def window_with(
    monkeypatch: pytest.MonkeyPatch, intervals: list[Interval], question: Question, setting: Setting
) -> tuple[Interval | None, tuple[Any, ...]]:
    """Return the window of a setting where a family has known intervals, and what that was asked."""
    calls: list[Any] = []

    def known(self: Family, *args: Any, **options: Any) -> list[Interval]:
        calls.append((self, *args, options))
        return intervals

    monkeypatch.setattr(Family, "intervals", known)
    window = window_of(question, setting, guarantee_of(question.box(setting)))
    return window, calls[0] if calls else ()


def line_setting(amplitude: float = 1e-3) -> Setting:
    return asked(LINE).space.setting(amplitude=amplitude, frequency=15.0, drive_angle=math.radians(20.0))


@pytest.mark.parametrize(
    ("interval", "low", "high", "by"),
    [
        (("onset", 0.95e-3, 1.2e-3, "hop"), 0.95e-3, 1.2e-3, ("onset", "hop")),
        (("speed", 0.5e-3, 1.4e-3, "limit"), 0.9e-3, 1.4e-3, ("limit", "limit")),  # below the drive
        (("speed", 1e-3 * (1 + 1e-7), 1.2e-3, "hop"), 1e-3, 1.2e-3, ("speed", "hop")),  # rounding
        (("speed", 0.95e-3, 1e-3 * (1 - 1e-7), "hop"), 0.95e-3, 1e-3, ("speed", "hop")),
    ],
)
def test_a_window_is_the_interval_around_a_design(
    interval: Any, low: float, high: float, by: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = Interval(interval[1], interval[2], interval[0], interval[3])
    window, call = window_with(monkeypatch, [given], asked(LINE), line_setting())
    assert window is not None
    assert window[:2] == pytest.approx((low, high), rel=1e-11)
    assert window[2:] == by
    # jumps are kept clear of, but not limits
    assert bool(window.low > low) is (by[0] != "limit" and low != 1e-3)
    assert bool(window.high < high) is (by[1] != "limit" and high != 1e-3)
    made, target, highest, most, caps, options = call
    assert (target, highest, caps) == (0.005, Regime.BACK_SLIP, {})
    assert (most, options["near"]) == pytest.approx((1.4e-3, 1e-3))
    assert made.template.factor == (1.0, 1.0)


def test_the_factor_of_an_ellipse_is_scaled_to_its_amplitude(monkeypatch: pytest.MonkeyPatch) -> None:
    question = asked(OVAL, drift={"amplitude_percent": 3}, goal={"speed_mm_s": 1})
    setting = Setting(6e-4, 2e-4, math.radians(-50.0), 25.0)
    window, call = window_with(monkeypatch, [Interval(0.8, 1.1, "speed", "limit")], question, setting)
    assert window is not None
    assert window[:2] == pytest.approx((4.8e-4, 6.6e-4))
    made, _, _, most, _, options = call
    assert (most, options["near"], made.drift) == pytest.approx((1.25, 1.0, 0.03))


@pytest.mark.parametrize(("limit", "most"), [(10.0, 1.4e-3), (1.1, 1.1 * 9.81 / (2 * math.pi * 15.0) ** 2)])
def test_a_window_ends_at_the_acceleration_of_the_drive(
    limit: float, most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    question = asked({**LINE, "acceleration_g": limit})
    _, call = window_with(monkeypatch, [], question, line_setting())
    assert call[3] == pytest.approx(most)


@pytest.mark.parametrize(("highest", "flies"), [(Regime.BACK_SLIP, False), (Regime.HOPPING, True)])
@pytest.mark.parametrize("ratio", [0.5, 5.0])
def test_a_window_ends_where_parts_tip_or_hop(
    highest: Regime, flies: bool, ratio: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Parts of a ratio of 0.5 lift an edge at A = 0.5 g / w^2 / (cos + 0.5 sin), wide ones never."""
    part = {"half_base_mm": 10 * ratio, "centre_height_mm": 10}
    question = asked({**LINE, "amplitude_mm": "0.1:5"}, highest, part=part, goal={"speed_mm_s": 1})
    setting = line_setting(0.9e-3)
    _, call = window_with(monkeypatch, [Interval(1e-4, 5e-3, "speed", "tip")], question, setting)
    unit, angle = 9.81 / (2 * math.pi * 15.0) ** 2, math.radians(20.0)
    tip = 0.5 * unit / (math.cos(angle) + 0.5 * math.sin(angle))
    expected = tip if ratio == 0.5 else unit / math.sin(angle) if flies else None
    assert call[4] == ({} if expected is None else {"tip": pytest.approx(expected, rel=1e-9)})
    free = asked({**LINE, "amplitude_mm": "0.1:5"}, highest, goal={"speed_mm_s": 1})
    assert window_with(monkeypatch, [Interval(1e-4, 5e-3, "speed", "tip")], free, setting)[1][4] == {}


def test_a_design_has_a_window_from_its_target_on(monkeypatch: pytest.MonkeyPatch) -> None:
    question = asked(LINE)
    found = guarantee_of(question.box(line_setting()))
    monkeypatch.setattr(Family, "intervals", lambda *_, **__: [Interval(0.9e-3, 1.2e-3, "speed", "hop")])
    for factor, has in ((1.0, True), (1.0 - 1e-12, False)):
        speeds = replace(found, speed_min=0.005 * factor)
        assert (window_of(question, line_setting(), speeds) is not None) is has
