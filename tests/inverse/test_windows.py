"""Amplitudes that guarantee a speed: they hold at their ends and inside, and fail just outside."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from helpers.boxed import Boxed, boxes, with_fields
from helpers.scenes import replaced, scene_with
from hypothesis import given, settings
from hypothesis import strategies as st

import vibro
from vibro import InputError, Regime, SceneError, feasible_amplitudes, solve
from vibro.inverse.exchange import Found
from vibro.inverse.guarantees import guarantee_of
from vibro.inverse.questions import Question
from vibro.inverse.reading import read_spec
from vibro.inverse.windows import window_of
from vibro.results.designs import Interval

NUT = scene_with()


def least(scene: vibro.Scene, amplitude: float, bands: Any, percent: float = 0.0) -> tuple[float, Regime]:
    """Guarantee of a nominal amplitude: the speed and the highest regime."""
    drift = percent / 100
    ends = (amplitude * (1 - drift), amplitude * (1 + drift))
    found = vibro.guarantee(with_fields(scene, amplitude=amplitude), **bands, amplitude=ends)
    return found.speed_min, max(found.regimes)


def assert_guarantees(
    scene: vibro.Scene, speed: float, interval: Interval, highest: Regime, bands: Any, percent: float = 0.0
) -> None:
    for amplitude in (interval.low, math.sqrt(interval.low * interval.high), interval.high):
        found, regime = least(scene, amplitude, bands, percent)
        assert found >= speed * (1 - 1e-9)
        assert regime <= highest
    for amplitude, ends in (
        (interval.low * (1 - 1e-6), interval.low_set_by),
        (interval.high * (1 + 1e-6), interval.high_set_by),
    ):
        if ends == "limit":
            continue
        found, regime = least(scene, amplitude, bands, percent)
        assert found < speed or regime > highest, ends


@settings(max_examples=15)
@given(boxes(), st.floats(0.05, 1.05))
def test_one_body_is_followed_through_every_jump(box: Boxed, share: float) -> None:
    scene = box.scene
    hop = float(vibro.critical_loads(scene).hop / scene.load * scene.scale)
    grid = hop * np.linspace(0.0, 1.0, 5001)[1:-1]
    speeds = vibro.solve(replaced(scene, amplitude=grid)).mean_velocity
    speed = share * max(float(np.max(speeds)), 1e-6)
    intervals = vibro.feasible_amplitudes(scene, speed)
    inside = np.zeros(grid.size, bool)
    for interval in intervals:
        inside |= (grid >= interval.low) & (grid <= interval.high)
    assert np.array_equal(inside, speeds >= speed)
    for interval in intervals:
        assert_guarantees(scene, speed, interval, Regime.BACK_SLIP, {})
    for before, after in pairwise(intervals):
        assert before.high < after.low


@settings(max_examples=5)
@given(boxes(), st.floats(0.0, 5.0), st.floats(0.1, 0.9))
def test_forward_slip_is_guaranteed_in_a_box(box: Boxed, percent: float, share: float) -> None:
    scene = box.scene
    highest: dict[str, Any] = {"highest_regime": "forward-slip", "amplitude_percent": percent}
    some = vibro.feasible_amplitudes(scene, 1e-9, **highest, **box.bands)
    if not some:
        return
    speed = share * least(scene, some[-1].high, box.bands, percent)[0]
    (interval,) = vibro.feasible_amplitudes(scene, speed, **highest, **box.bands)
    assert interval.high == some[-1].high
    assert_guarantees(scene, speed, interval, Regime.FORWARD_SLIP, box.bands, percent)


def test_back_slip_is_guaranteed_in_a_box() -> None:
    bands: dict[str, Any] = {"static_friction": (0.72, 0.76)}
    speed = 0.0265
    intervals = vibro.feasible_amplitudes(NUT, speed, amplitude_percent=1.0, **bands)
    assert intervals
    for interval in intervals:
        assert_guarantees(NUT, speed, interval, Regime.BACK_SLIP, bands, 1.0)
    assert not any(i.low <= 1.2e-3 <= i.high for i in intervals)
    assert least(NUT, 1.2e-3, bands, 1.0)[0] < speed


def test_what_sets_the_ends() -> None:
    hop = 3.229052215938875e-3
    assert [i[2:] for i in vibro.feasible_amplitudes(NUT, 0.02815)] == [
        ("speed", "back slip"),
        ("speed", "hop"),
    ]
    assert [i[2:] for i in vibro.feasible_amplitudes(NUT, 5e-4)] == [("onset", "hop")]
    (limited,) = vibro.feasible_amplitudes(NUT, 0.02, limit=2e-3)
    assert limited[1:] == (2e-3, "speed", "limit")
    (far,) = vibro.feasible_amplitudes(NUT, 0.02, limit=1.0)
    assert far.high_set_by == "hop"
    assert far.high == pytest.approx(hop, rel=1e-11)
    (drifting,) = vibro.feasible_amplitudes(NUT, 0.02, amplitude_percent=5.0)
    assert drifting.high == pytest.approx(hop / 1.05, rel=1e-11)
    (forward,) = vibro.feasible_amplitudes(NUT, 0.02, highest_regime="forward-slip")
    assert forward.high_set_by == "back slip"
    assert vibro.feasible_amplitudes(NUT, 1.0) == []
    assert vibro.feasible_amplitudes(NUT, 0.02, limit=0.5e-3) == []


def test_hopping_bodies_are_followed_up_to_the_limit() -> None:
    (interval,) = vibro.feasible_amplitudes(NUT, 0.14, highest_regime="hopping", limit=4e-3)
    assert interval[1:] == (4e-3, "speed", "limit")
    assert_guarantees(NUT, 0.14, interval, Regime.HOPPING, {})


@settings(max_examples=15)
@given(boxes(), st.floats(0.2, 5.0))
def test_amplitudes_go_with_the_scale_of_length(box: Boxed, scale: float) -> None:
    speed = 0.01
    small = vibro.feasible_amplitudes(box.scene, speed)
    large = vibro.feasible_amplitudes(
        replaced(box.scene, frequency=box.scene.frequency * scale), speed / scale
    )
    assert [i[2:] for i in small] == [i[2:] for i in large]
    ends = [end for i in small for end in i[:2]]
    assert [end * scale**2 for i in large for end in i[:2]] == pytest.approx(ends, rel=1e-9)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"highest_regime": "flying"},
            "highest_regime = 'flying': must be one of forward-slip, back-slip, hopping",
        ),
        ({"highest_regime": Regime.HOPPING}, "must be one of"),
        ({"highest_regime": "no-slip"}, "must be one of"),
        ({"highest_regime": "hopping"}, "limit = inf: must be finite"),
        ({"limit": 0.0}, "limit = 0 m"),
        ({"limit": math.nan}, "limit = nan"),
        ({"amplitude_percent": 100.0}, "amplitude_percent = 100"),
        ({"amplitude_percent": -1.0}, "amplitude_percent = -1"),
        ({"amplitude_percent": "5"}, "amplitude_percent"),
    ],
)
def test_arguments_that_cannot_be_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        vibro.feasible_amplitudes(NUT, 0.02, **options)
    assert message in str(caught.value)


def test_a_band_of_the_amplitude_is_refused() -> None:
    with pytest.raises(SceneError, match="band 'amplitude'"):
        vibro.feasible_amplitudes(NUT, 0.02, amplitude=(1e-3, 2e-3))


@pytest.mark.parametrize("drive_angle", [0.0, 1e-9])
@pytest.mark.parametrize("bands", [{}, {"static_friction": (0.35, 0.4)}], ids=["one body", "a box"])
def test_horizontal_drives_convey_down_a_decline(drive_angle: float, bands: dict[str, Any]) -> None:
    """They hop at no load, or at a million times that of the onset."""
    scene = scene_with(
        drive_angle=drive_angle, trough_angle=math.radians(-5), static_friction=0.4, kinetic_friction=0.3
    )
    (interval,) = vibro.feasible_amplitudes(scene, 0.05, **bands)
    assert interval.low == pytest.approx(1.31104e-3, rel=1e-5)
    assert interval.low_set_by == "speed"
    assert interval.high > 1e3


@pytest.mark.parametrize("decline_deg", [5.0, 1e-3])
@pytest.mark.parametrize("speed", [0.02, 20.0, 50.0, 5e5])
def test_horizontal_drives_reach_any_speed_down_a_decline(speed: float, decline_deg: float) -> None:
    """At large amplitudes friction balances weight where v = A w sin(pi/2 tan(decline)/mu_d)."""
    decline, mu_d = math.radians(decline_deg), 0.4
    scene = scene_with(drive_angle=0.0, static_friction=0.5, kinetic_friction=mu_d, trough_angle=-decline)
    (found,) = feasible_amplitudes(scene, speed)
    assert math.isinf(found.high)
    assert float(solve(replaced(scene, amplitude=found.low)).mean_velocity) == pytest.approx(speed, rel=1e-9)
    if speed > 1.0:
        share = math.sin(0.5 * math.pi * math.tan(decline) / mu_d)
        assert found.low == pytest.approx(speed / (2.0 * math.pi * 15.0 * share), rel=1e-6)


@pytest.mark.parametrize("percent", [0.0, 3.0, 8.0])
def test_windows_leave_room_for_the_drift_at_both_ends(percent: float) -> None:
    """The weakest drive of the drift must still start every part, and the strongest must not throw one."""
    scene = scene_with(drive_angle=math.radians(30.0), static_friction=0.5, kinetic_friction=0.499)
    bands: dict[str, Any] = {"static_friction": (0.45, 0.5), "friction_ratio": (0.998, 1.0)}
    (interval,) = vibro.feasible_amplitudes(scene, 1e-9, amplitude_percent=percent, **bands)
    hard = replaced(scene, amplitude=1.0)
    limits = vibro.critical_loads(hard)
    assert interval.high_set_by == "hop"
    assert interval.high * (1 + percent / 100) == pytest.approx(float(limits.hop / hard.load), rel=1e-9)
    assert interval.low * (1 - percent / 100) == pytest.approx(
        float(limits.forward_onset / hard.load), rel=1e-3
    )
    forward = {"highest_regime": "forward-slip", **bands}
    (still,) = vibro.feasible_amplitudes(scene, 1e-9, amplitude_percent=percent, **forward)
    found, regime = least(scene, still.high, bands, percent)
    assert (found > 0.0, regime) == (True, Regime.FORWARD_SLIP)
    assert least(scene, still.high * (1 + 1e-9), bands, percent)[1] > Regime.FORWARD_SLIP


def test_a_body_past_a_drop_just_before_the_end_of_a_window_is_found() -> None:
    """In the middle of the band, just past the drop where back slip enters, bodies miss the speed by 5 %."""
    question = {
        "scene": {"static_friction": 0.271, "kinetic_friction": "0:0.136"},
        "drive": [
            {"stroke_mm": 1.5, "frequency_hz": "15:25", "drive_angle_deg": "5:60", "acceleration_g": 1}
        ],
        "goal": {"speed_mm_s": 3},
    }
    spec = read_spec(question)
    asked = Question(spec, spec.drives[0], Regime.BACK_SLIP)
    setting = asked.space.setting(amplitude=0.32768e-3, frequency=15.0, drive_angle=math.radians(12.8210176))
    window = window_of(asked, Found(setting, (), guarantee_of(asked.box(setting))))
    assert window is not None
    assert window.high == pytest.approx(0.3276924e-3, rel=2e-6)
    kinetic = (0.0, 0.136)
    scene = scene_with(
        amplitude=window.high, drive_angle=math.radians(12.8210176), static_friction=0.271,
        kinetic_friction=0.1,
    )  # fmt: skip
    assert vibro.guarantee(scene, kinetic_friction=kinetic).speed_min >= 3e-3 * (1 - 1e-9)


def test_parts_that_must_stay_upright_have_no_window_beyond_the_hop() -> None:
    """With a base twice as wide as the centre is high they never tip in contact, but may when they land."""
    question = {
        "scene": {"static_friction": 0.5, "friction_ratio": 0.9},
        "drive": [{"amplitude_mm": 3, "frequency_hz": 25, "drive_angle_deg": 30}],
        "goal": {"speed_mm_s": 1, "highest_regime": "hopping"},
        "part": {"half_base_mm": 8, "centre_height_mm": 8},
    }
    spec = read_spec(question)
    asked = Question(spec, spec.drives[0], Regime.HOPPING)
    setting = asked.space.setting(amplitude=0.7e-3, frequency=25.0, drive_angle=math.radians(30.0))
    window = window_of(asked, Found(setting, (), guarantee_of(asked.box(setting))))
    assert window is not None
    hop = 9.81 / math.sin(math.radians(30.0)) / (2.0 * math.pi * 25.0) ** 2
    assert window.high == pytest.approx(hop, rel=1e-9)
    assert window.high_set_by == "tip"
