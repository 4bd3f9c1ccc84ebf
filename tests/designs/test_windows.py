"""Amplitudes that guarantee a speed: they hold at their ends and inside, and fail just outside."""

from __future__ import annotations

import math
from itertools import pairwise, product
from typing import Any, NamedTuple

import numpy as np
import pytest
from helpers.boxed import Boxed, boxes, with_fields
from helpers.draws import examples
from helpers.scenes import replaced, scene_with
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import vibro
from vibro import Regime, SceneError, feasible_amplitudes, solve
from vibro.designs.guarantees import guarantee_of
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.designs.windows import window_of
from vibro.results.designs import Interval

NUT = scene_with()
BOWL = vibro.Scene(
    along_amplitude=3e-3, normal_amplitude=1e-3, normal_phase=math.radians(-60.0), frequency=25.0,
    static_friction=0.4, kinetic_friction=0.3,
)  # fmt: skip
Floats = NDArray[np.float64]


def least(scene: vibro.Scene, amplitude: float, bands: Any, percent: float = 0.0) -> tuple[float, Regime]:
    """Slowest body that is found at a nominal amplitude: the speed and the highest regime."""
    drift = percent / 100
    ends = (amplitude * (1 - drift), amplitude * (1 + drift))
    found = vibro.guarantee(with_fields(scene, amplitude=amplitude), **bands, amplitude=ends)
    return found.found_min, max(found.regimes)


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


@examples(8)
@given(boxes(), st.floats(0.05, 1.05))
def test_one_body_is_followed_through_every_jump(box: Boxed, share: float) -> None:
    scene = box.scene
    hop = float(vibro.critical_loads(scene).hop / scene.load * scene.scale)
    grid = hop * np.linspace(0.0, 1.0, 2001)[1:-1]
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


@examples(5)
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


class Scan(NamedTuple):
    """A scene that is solved at many amplitudes, both amplitudes of an ellipse in their proportion."""

    scene: vibro.Scene
    amplitudes: Floats

    def at(self, amplitudes: Any) -> vibro.SteadyCycle:
        x, y = (float(a or 0.0) for a in (self.scene.along_amplitude, self.scene.normal_amplitude))
        size = x or y
        one = {"along_amplitude": amplitudes * (x / size), "normal_amplitude": amplitudes * (y / size)}
        return solve(replaced(self.scene, **one))

    def speeds(self, amplitudes: Any) -> Floats:
        """Means of irregular motion less three standard errors."""
        cycle = self.at(np.asarray(amplitudes))
        error = np.where(cycle.status == vibro.Status.AVERAGED, cycle.mean_velocity_error, 0.0)
        return np.asarray(cycle.mean_velocity - 3.0 * error)


def ellipse(seed: int, most_throw: float, restitution: float = 0.0, count: int = 5_000) -> Scan:
    """Draw an elliptical drive, level or inclined, and amplitudes up to a throw number."""
    rng = np.random.default_rng(seed)
    x, y = rng.choice([1.0, 1.0, 1.0, 0.0]), rng.uniform(0.05, 1.5)
    mu_s = rng.uniform(0.1, 1.0)
    scene = vibro.Scene(
        along_amplitude=1e-3 * x, normal_amplitude=1e-3 * y, normal_phase=rng.uniform(-math.pi, math.pi),
        frequency=rng.uniform(8.0, 60.0), static_friction=mu_s, kinetic_friction=mu_s * rng.uniform(0.5, 1.0),
        trough_angle=rng.choice([0.0, rng.uniform(-0.2, 0.2)]), restitution=restitution,
    )  # fmt: skip
    top = most_throw * 1e-3 * (x or y) / float(solve(scene, output="regimes").throw_number)
    return Scan(scene, np.linspace(0.0, top, count + 1)[1:-1])


def fastest(speeds: Floats) -> float:
    return float(np.max(np.nan_to_num(speeds), initial=1e-6))


def covered(amplitudes: Floats, intervals: list[Interval]) -> NDArray[np.bool_]:
    inside = np.zeros(amplitudes.size, bool)
    for i in intervals:
        inside |= (i.low <= amplitudes) & (amplitudes <= i.high)
    return inside


def test_ellipses_are_followed_through_every_jump() -> None:
    """Ends are those of the last double; between them, and outside, every amplitude of a fine scan agrees."""
    scans = [ellipse(seed, 1.0) for seed in range(10)]
    known = [(seed, scan, scan.speeds(scan.amplitudes)) for seed, scan in enumerate(scans)]
    for share, (seed, scan, speeds) in product((0.03, 0.5, 0.97), known):
        speed = share * fastest(speeds)
        found = feasible_amplitudes(scan.scene, speed)
        assert np.array_equal(speeds >= speed, covered(scan.amplitudes, found)), seed
        for i in found:
            assert np.all(scan.speeds(i[:2]) >= speed), seed
            assert scan.speeds(np.nextafter(i.low, 0.0)) < speed
            if i.high_set_by == "hop":
                regimes = scan.at(np.array([i.high, i.high * (1 + 1e-9)])).regime
                assert (regimes[0] < Regime.HOPPING, regimes[1]) == (True, Regime.HOPPING)
            else:
                assert scan.speeds(np.nextafter(i.high, 1.0)) < speed


def test_hops_of_ellipses_are_followed_but_for_slivers() -> None:
    """Of 4 scenes those of regular hops agree at every amplitude; irregular ones differ in 0.2 % at most."""
    agree = 0
    for seed in (5, 6, 9, 12):
        scan = ellipse(seed, 10.0, count=3_000)
        speeds = scan.speeds(scan.amplitudes)
        speed = 0.4 * fastest(speeds)
        limit = float(scan.amplitudes[-1])
        found = feasible_amplitudes(scan.scene, speed, highest_regime="hopping", limit=limit)
        differs = np.count_nonzero((speeds >= speed) != covered(scan.amplitudes, found))
        assert differs <= 2e-3 * speeds.size, seed
        agree += differs == 0
        for i in found:
            assert np.all(scan.speeds(i[:2]) >= speed), seed
            assert scan.speeds(np.nextafter(i.low, 0.0)) < speed
            assert i.high == limit or not scan.speeds(np.nextafter(i.high, 1.0)) >= speed
    assert agree == 3


def test_bands_and_drift_of_an_ellipse_are_guaranteed() -> None:
    bands: dict[str, Any] = {"static_friction": (0.35, 0.45), "normal_phase": (-1.2, -0.9)}
    (found,) = feasible_amplitudes(BOWL, 0.03, amplitude_percent=3.0, **bands)
    assert (found.low_set_by, found.high_set_by) == ("speed", "hop")

    def slowest(amplitude: float) -> float:
        frictions, phases, drifts = np.meshgrid(
            np.linspace(0.35, 0.45, 21), np.linspace(-1.2, -0.9, 21), [0.97, 1.0, 1.03]
        )
        cycle = solve(
            replaced(
                BOWL, along_amplitude=drifts * amplitude, normal_amplitude=drifts * amplitude / 3.0,
                static_friction=frictions, normal_phase=phases,
            )
        )  # fmt: skip
        return float(np.min(np.where(cycle.regime == Regime.HOPPING, -1.0, cycle.mean_velocity)))

    # the slowest parts lie at corners, which the grid has
    assert slowest(found.low * (1 + 1e-9)) >= 0.03
    assert 0.0 < slowest(found.low * (1 - 1e-6)) < 0.03
    assert slowest(found.high) >= 0.03
    assert slowest(found.high * (1 + 1e-9)) == -1.0


def test_amplitudes_of_an_ellipse_are_along_the_trough_or_normal_to_it() -> None:
    flat = with_fields(BOWL, normal_amplitude=0.0, trough_angle=math.radians(-5))
    (found,) = feasible_amplitudes(flat, 0.05)
    assert math.isinf(found.high)
    along = Scan(flat, np.array([found.low]))
    assert along.speeds(found.low) == pytest.approx(0.05, rel=1e-9)
    upright = with_fields(BOWL, along_amplitude=0.0, trough_angle=math.radians(-3))
    (found,) = feasible_amplitudes(upright, 3e-4, limit=3.9e-4)
    assert found[1:] == (3.9e-4, "speed", "limit")
    assert Scan(upright, np.array([found.low])).speeds(found.low) == pytest.approx(3e-4, rel=1e-9)
    still = with_fields(BOWL, along_amplitude=0.0, normal_amplitude=0.0)
    with pytest.raises(SceneError, match="along_amplitude = 0 m"):
        feasible_amplitudes(still, 0.05)


def test_a_body_that_an_ellipse_conveys_backwards_reaches_no_speed() -> None:
    back = with_fields(BOWL, normal_phase=math.radians(120.0))
    assert feasible_amplitudes(BOWL, 0.05)
    assert feasible_amplitudes(back, 1e-6) == []
    assert solve(with_fields(back, along_amplitude=9e-4, normal_amplitude=3e-4)).mean_velocity < -0.05


def test_back_slip_that_ends_again_begins_a_window() -> None:
    """On a decline steeper than the angle of kinetic friction, at 0.49 mm."""
    scene = vibro.Scene(
        along_amplitude=1e-3, normal_amplitude=0.7009e-3, normal_phase=3.11133, frequency=20.0,
        static_friction=0.816185, kinetic_friction=0.35913, trough_angle=-0.418498,
    )  # fmt: skip
    (found,) = feasible_amplitudes(scene, 0.02)
    assert found.low_set_by == "back slip"
    regimes = Scan(scene, np.zeros(0)).at(np.array([found.low * (1 - 1e-9), found.low])).regime
    assert regimes.tolist() == [Regime.BACK_SLIP, Regime.FORWARD_SLIP]


@pytest.mark.parametrize(
    ("decline_deg", "speed", "bands"),
    [
        (5.0, 0.02, {}),
        (5.0, 5e3, {}),
        (1e-3, 20.0, {}),
        (1e-3, 5e3, {}),
        (5.0, 0.05, {"static_friction": (0.5, 0.52)}),
    ],
)
def test_horizontal_drives_reach_any_speed_down_a_decline(
    decline_deg: float, speed: float, bands: dict[str, Any]
) -> None:
    """At large amplitudes friction balances weight where v = A w sin(pi/2 tan(decline)/mu_d)."""
    decline, mu_d = math.radians(decline_deg), 0.4
    scene = scene_with(drive_angle=0.0, static_friction=0.5, kinetic_friction=mu_d, trough_angle=-decline)
    (found,) = feasible_amplitudes(scene, speed, **bands)
    assert math.isinf(found.high)
    frictions = bands.get("static_friction", 0.5)
    slowest = solve(replaced(scene, amplitude=found.low, static_friction=frictions)).mean_velocity.min()
    assert float(slowest) == pytest.approx(speed, rel=1e-9)
    if speed > 1.0:
        share = math.sin(0.5 * math.pi * math.tan(decline) / mu_d)
        assert found.low == pytest.approx(speed / (2.0 * math.pi * 15.0 * share), rel=1e-6)


@pytest.mark.parametrize("percent", [0.0, 8.0])
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
    window = window_of(asked, setting, guarantee_of(asked.box(setting)))
    assert window is not None
    assert window.high == pytest.approx(0.3276924e-3, rel=2e-6)
    kinetic = (0.0, 0.136)
    scene = scene_with(
        amplitude=window.high, drive_angle=math.radians(12.8210176), static_friction=0.271,
        kinetic_friction=0.1,
    )  # fmt: skip
    assert vibro.guarantee(scene, kinetic_friction=kinetic).found_min >= 3e-3 * (1 - 1e-9)


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
    window = window_of(asked, setting, guarantee_of(asked.box(setting)))
    assert window is not None
    hop = 9.81 / math.sin(math.radians(30.0)) / (2.0 * math.pi * 25.0) ** 2
    assert window.high == pytest.approx(hop, rel=1e-9)
    assert window.high_set_by == "tip"


@pytest.mark.parametrize(
    ("share", "acceleration", "mu_s", "mu_d", "frequency", "least"),
    [
        (0.6, 3.0, 0.3, 0.25, 5.0, 0.25 * 9.81 / 3.0),
        (0.7, 3.35, 0.43, 0.3, 8.75, 0.3 * 9.81 / 3.35),
        (0.57, 1.32, 0.4, 0.3, 5.7, math.nan),  # at once above the target, from the onset
    ],
)
def test_a_speed_that_a_plateau_just_reaches_is_reached_all_over_it(
    share: float, acceleration: float, mu_s: float, mu_d: float, frequency: float, least: float
) -> None:
    back = -share * acceleration / (1.0 - share)
    motion = vibro.Motion.steps(along=[(share, acceleration), (1.0 - share, back)])
    friction = {"static_friction": mu_s, "kinetic_friction": mu_d}
    scene = vibro.Scene(motion=motion, frequency=frequency, motion_scale=20.0, **friction)
    level = float(solve(scene).mean_velocity)
    for beside in (-1e-9, -1e-12, -1e-15, 0.0, 1e-15, 1e-13):
        (found,) = feasible_amplitudes(scene, level * (1.0 + beside), limit=300.0)
        assert (found.high, found.high_set_by) == (300.0, "limit"), beside
        if not math.isnan(least):
            assert found.low == pytest.approx(least, rel=2e-9)
    for beside in (1e-12, 1e-9, 1e-3):  # too fast for the plateau: before the body slides back
        (found,) = feasible_amplitudes(scene, level * (1.0 + beside), limit=300.0)
        assert found.high_set_by == "back slip"
        assert found.high < 3.0
    with_bands = feasible_amplitudes(scene, level, limit=20.0, static_friction=(mu_s, mu_s + 0.01))
    assert [i.high for i in with_bands] == [20.0]
