"""Guarantees, windows, yields and designs of drives that are a given motion."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import vibro
from vibro.core.codes import Regime
from vibro.designs import guarantees
from vibro.designs.optima import EllipseOptimiser
from vibro.designs.proofs import begin_load, change_loads
from vibro.designs.questions import Question
from vibro.designs.reading import read_spec
from vibro.designs.rows import find
from vibro.designs.spaces import uncertainty_set
from vibro.results.designs import DesignResult

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from vibro.results.designs import Design

EXAMPLE = Path(__file__).parents[2] / "examples" / "design_motion.toml"
REST: dict[str, Any] = {"static_friction": 0.4, "kinetic_friction": 0.3}
STEPS = vibro.Motion.steps(along=[(0.8, 1.5), (0.2, -6.0)])
#: An ellipse that conveys, and the same as a motion of one harmonic.
OVAL = {"along_amplitude": 1e-3, "normal_amplitude": 3e-4, "normal_phase": math.radians(-60.0)}
WAVE = vibro.Motion.harmonics(along=[(1e-3, 0.0)], normal=[(3e-4, math.radians(-60.0))])
ELLIPSE = vibro.Scene(**OVAL, frequency=22.0, **REST)
ONE = vibro.Scene(motion=WAVE, frequency=22.0, **REST)
BANDS: dict[str, Any] = {
    "static_friction": (0.35, 0.45), "friction_ratio": (0.7, 0.9), "trough_angle": (-0.02, 0.02),
    "frequency": (21.7, 22.3),
}  # fmt: skip


@pytest.fixture(scope="module")
def brief() -> Iterator[None]:
    """Search fewer bodies and settings: few suffice here."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(guarantees._EVOLVED, False, (9, 16, 15))
        contact, *others = EllipseOptimiser._efforts
        fewer = replace(contact, generations=25, polish=25)
        patch.setattr(EllipseOptimiser, "_efforts", (fewer, *others))
        yield


def drawn(seed: int) -> tuple[vibro.Motion, float]:
    """A random motion, and a frequency at which it moves bodies: three harmonics, or steps."""
    rng = np.random.default_rng(seed)
    if seed % 2:
        shares, levels = rng.dirichlet(np.full(3, 3.0)), 5.0 * rng.normal(size=3)
        levels -= shares @ levels
        return vibro.Motion.steps(
            along=list(zip(shares, levels, strict=True)), normal=[(0.4, 1.5), (0.6, -1)]
        ), 5.0
    x, y = (
        [(size * rng.uniform(0.1, 1.0) / k**2, rng.uniform(-3, 3)) for k in (1, 2, 3)]
        for size in (3e-3, 1e-3)
    )
    return vibro.Motion.harmonics(along=x, normal=y), 9.0


def speeds_of(motion: vibro.Motion, bands: dict[str, Any], count: int, seed: int) -> NDArray[np.float64]:
    """Speeds at random points of a box, many of them on its faces."""
    rng = np.random.default_rng(seed)
    shares = rng.random((len(bands), count))
    shares = np.where(rng.random(shares.shape) < 0.2, np.round(shares), shares)
    values = {
        name: low + (high - low) * x for (name, (low, high)), x in zip(bands.items(), shares, strict=True)
    }
    values["kinetic_friction"] = values.pop("friction_ratio") * values["static_friction"]
    return np.asarray(vibro.solve(vibro.Scene(motion=motion, **values)).mean_velocity)


@pytest.mark.parametrize("seed", [7, 12])
def test_no_sampled_body_is_beyond_a_guarantee(seed: int) -> None:
    motion, frequency = drawn(seed)
    bands = {
        "static_friction": (0.3, 0.5), "friction_ratio": (0.7, 0.95), "motion_scale": (0.9, 1.1),
        "trough_angle": (-0.03, 0.03), "frequency": (0.98 * frequency, 1.02 * frequency),
    }  # fmt: skip
    found = vibro.guarantee(vibro.Scene(motion=motion, frequency=frequency, **REST), **bands)
    assert (found.proof_min, found.proof_max) == ("searched", "searched")
    assert math.isnan(found.proved_min)
    assert found.certificate_min is None
    speeds = speeds_of(motion, bands, 1024, seed)
    tolerance = 1e-6 * np.abs(speeds).max()
    assert found.speed_min <= speeds.min() + tolerance
    assert found.speed_max >= speeds.max() - tolerance
    # both are speeds of bodies of the box
    for at, speed in ((found.min_at, found.speed_min), (found.max_at, found.speed_max)):
        assert set(at) == {
            "motion_scale", "frequency", "static_friction", "kinetic_friction", "trough_angle", "gravity",
            "restitution",
        }  # fmt: skip
        again = vibro.solve(vibro.Scene(motion=motion, **at)).mean_velocity
        assert float(again) == pytest.approx(speed, rel=1e-12, abs=1e-15)


def test_one_harmonic_is_an_ellipse() -> None:
    oval, wave = vibro.guarantee(ELLIPSE, **BANDS), vibro.guarantee(ONE, **BANDS)
    assert (oval.proof_min, wave.proof_min) == ("proved", "searched")
    assert wave.found_min == pytest.approx(oval.found_min, rel=1e-6)
    assert wave.found_max == pytest.approx(oval.found_max, rel=1e-6)
    assert wave.regimes == oval.regimes


@pytest.mark.parametrize(
    "asked",
    [
        {"static_friction": (0.35, 0.45), "amplitude_percent": 2.0},
        {"highest_regime": "hopping", "limit": 1.5},
    ],
)
def test_scales_that_guarantee_a_speed_are_those_of_the_ellipse(asked: dict[str, Any]) -> None:
    size = OVAL["along_amplitude"]
    ends = {**asked, "limit": asked["limit"] * size} if "limit" in asked else asked
    ovals, waves = (
        vibro.feasible_amplitudes(ELLIPSE, 0.01, **ends),
        vibro.feasible_amplitudes(ONE, 0.01, **asked),
    )
    assert waves
    assert len(ovals) == len(waves)
    for oval, wave in zip(ovals, waves, strict=True):
        assert wave[2:] == oval[2:]
        assert wave[:2] == pytest.approx((oval.low / size, oval.high / size), rel=1e-6)


def test_windows_end_where_parts_slip_back_or_are_too_slow() -> None:
    """Just within each end all parts of a grid keep to the goal, just beyond some part does not."""
    scene = vibro.Scene(motion=STEPS, frequency=2.0, **REST)
    (window,) = vibro.feasible_amplitudes(
        scene, 0.03, highest_regime="forward-slip", static_friction=(0.35, 0.45), friction_ratio=(0.7, 0.9)
    )
    assert window[2:] == ("speed", "back slip")
    mu_s = np.linspace(0.35, 0.45, 21)[:, None]

    def parts(scale: float) -> vibro.SteadyCycle:
        kinetic = mu_s * np.linspace(0.7, 0.9, 21)
        return vibro.solve(
            vibro.Scene(
                motion=STEPS,
                motion_scale=scale,
                frequency=2.0,
                static_friction=mu_s,
                kinetic_friction=kinetic,
            )
        )

    assert (
        parts(window.low * (1.0 - 1e-8)).mean_velocity.min() < 0.03 <= parts(window.low).mean_velocity.min()
    )
    assert parts(window.high).regime.max() == Regime.FORWARD_SLIP
    assert parts(window.high * (1.0 + 1e-6)).regime.max() == Regime.BACK_SLIP


@pytest.mark.parametrize(("motion", "frequency"), [(STEPS, 2.0), (WAVE, 22.0), drawn(4), drawn(7)])
def test_changes_are_where_the_regime_changes(motion: vibro.Motion, frequency: float) -> None:
    """Just below and just above each load the solver's regime is another one; at it, the lower one."""
    scene = vibro.Scene(motion=motion, frequency=frequency, **REST)
    loads = change_loads(scene)
    assert list(loads) == ["hop", "forward_onset", "back_onset"]
    first = min(float(loads["forward_onset"]), float(loads["back_onset"]))
    begins = {name: float(begin_load(scene, regime)) for name, regime in (
        ("hop", Regime.HOPPING), ("back", Regime.BACK_SLIP),
    )}  # fmt: skip

    def regime(load: float) -> Regime:
        scale = load / float(scene.load)
        there = vibro.Scene(motion=motion, motion_scale=scale, frequency=frequency, **REST)
        return Regime(int(vibro.solve(there).regime))

    assert regime(first * (1.0 - 1e-9)) is Regime.NO_SLIP
    assert regime(first * (1.0 + 1e-9)) > Regime.NO_SLIP
    if math.isfinite(begins["hop"]):
        assert regime(begins["hop"] * (1.0 - 1e-9)) < Regime.HOPPING
        assert regime(begins["hop"] * (1.0 + 1e-9)) is Regime.HOPPING
    assert math.isfinite(begins["back"])
    assert regime(begins["back"] * (1.0 - 1e-9)) < Regime.BACK_SLIP
    assert regime(begins["back"] * (1.0 + 1e-6)) is Regime.BACK_SLIP


def test_the_limit_at_a_jump_is_named() -> None:
    """Where forward slip begins the speed of a body on steps jumps from 0."""
    scene = vibro.Scene(motion=STEPS, frequency=2.0, **REST)
    scale = float(change_loads(scene)["forward_onset"] / scene.load)
    found = vibro.guarantee(scene, motion_scale=(0.5 * scale, scale))
    assert found.speed_max == 0.0
    above = vibro.guarantee(scene, motion_scale=(scale * (1.0 + 1e-12), 1.5 * scale))
    assert above.speed_min > 1e-3
    assert above.min_limit == "from above the load at which forward slip begins"


def test_clamped_bodies_never_hop() -> None:
    clamped = vibro.Scene(motion=STEPS, frequency=2.0, normal_acceleration=8.0, **REST)
    box = uncertainty_set(clamped, {"static_friction": (0.35, 0.45)})
    assert not box.may_hop
    found = vibro.guarantee(clamped, static_friction=(0.35, 0.45))
    assert found.min_at["normal_acceleration"] == 8.0
    speeds = [
        float(vibro.solve(vibro.Scene(motion=STEPS, frequency=2.0, normal_acceleration=8.0,
                                      static_friction=mu, kinetic_friction=0.3)).mean_velocity)
        for mu in (0.35, 0.45)
    ]  # fmt: skip
    assert (found.speed_min, found.speed_max) == pytest.approx((min(speeds), max(speeds)), rel=1e-9)


def question(drive: dict[str, Any], **goal: Any) -> dict[str, Any]:
    return {
        "scene": {"static_friction": "0.35:0.45", "friction_ratio": "0.7:0.9"},
        "drive": [{"frequency_hz": "15:30", **drive}],
        "drift": {"amplitude_percent": 2},
        "goal": {"speed_mm_s": 10} | goal,
    }


HARMONIC = {"along_harmonics_mm_deg": [[1.0, 0.0]], "normal_harmonics_mm_deg": [[0.3, -60.0]]}
ELLIPTIC = {"along_amplitude_mm": 1.0, "normal_amplitude_mm": 0.3, "normal_phase_deg": -60}
KINDS: dict[str, dict[str, Any]] = {"ellipse": ELLIPTIC, "harmonic": HARMONIC}


@cache
def designs_of(kind: str, **goal: Any) -> tuple[Design, Design]:
    """The gentlest and the fastest design of one of these drives."""
    spec = read_spec(question(KINDS[kind], **goal))
    finder = find(Question(spec, spec.drives[0], Regime.FORWARD_SLIP), {}, 9, until="gentlest")
    if spec.goal.highest_regime > Regime.FORWARD_SLIP:
        finder = find(Question(spec, spec.drives[0], Regime.BACK_SLIP), finder.found, 9, until="gentlest")
    return finder.row("gentlest"), finder.row("fastest")


@pytest.mark.usefixtures("brief")
@pytest.mark.parametrize("goal", [{}])
def test_designs_of_one_harmonic_are_those_of_the_ellipse(goal: dict[str, Any]) -> None:
    ovals, waves = designs_of("ellipse", **goal), designs_of("harmonic", **goal)
    for oval, wave in zip(ovals, waves, strict=True):
        assert (wave.design, wave.set_by) == (oval.design, oval.set_by)
        if oval.frequency_hz is None:
            assert wave.frequency_hz is None
            continue
        assert wave.motion_scale == 1.0
        for name in (
            "frequency_hz",
            "acceleration_g",
            "speed_found_mm_s",
            "throw_number_max",
        ):
            assert getattr(wave, name) == pytest.approx(getattr(oval, name), rel=1e-6)
        assert wave.speed_max_mm_s == pytest.approx(oval.speed_max_mm_s, rel=1e-4)  # found, and proved
        assert (wave.is_guaranteed, oval.is_guaranteed) == (False, True)
        assert wave.window == pytest.approx(oval.window, rel=1e-6)  # of an amplitude of 1 mm


@pytest.fixture(scope="module")
def servo(brief: None) -> DesignResult:
    """The designs of the example, within forward slip: steps make none slip back here."""
    asked = tomllib.loads(EXAMPLE.read_text(encoding="utf-8"))
    asked["goal"]["highest_regime"] = "forward-slip"
    return vibro.design(asked, only="goal")


def slowest(scales: Any, frequencies: Any) -> NDArray[np.float64]:
    """Least speed [mm/s] of a grid of bodies of the servo, over settings."""
    parts = np.meshgrid(
        [0.97, 1.0, 1.03], [0.995, 1.0, 1.005], np.linspace(0.3, 0.4, 3), np.linspace(0.8, 0.95, 3)
    )
    drift, rate, mu_s, ratio = (x.reshape(-1) for x in parts)
    scene = vibro.Scene(
        motion=STEPS, motion_scale=np.asarray(scales)[..., None] * drift,
        frequency=np.asarray(frequencies)[..., None] * rate, static_friction=mu_s,
        kinetic_friction=ratio * mu_s,
    )  # fmt: skip
    return np.asarray(1e3 * vibro.solve(scene).mean_velocity.min(axis=-1))


def test_designs_are_those_of_a_grid(servo: DesignResult) -> None:
    scale, frequency = np.meshgrid(np.linspace(0.5, 1.5, 51), np.linspace(1.5, 3.0, 3))
    least = slowest(scale, frequency)
    gentlest, fastest, safest = servo.designs
    assert [design.motion_scale for design in servo.designs] == [1.381, 1.5, 1.5]
    assert not any(column.name == "amplitude_mm" for column in servo.columns)
    assert fastest.speed_min_mm_s == pytest.approx(least.max(), rel=1e-6)
    assert (fastest.motion_scale, fastest.frequency_hz) == (1.5, 1.5)
    gentle = scale[least >= 100.0].min()
    assert gentlest.motion_scale is not None
    assert gentle - 0.02 <= gentlest.motion_scale <= gentle
    assert gentlest.acceleration_g == pytest.approx(6.0 * gentlest.motion_scale / 9.81, rel=1e-12)
    assert safest.margin is not None
    assert gentlest.margin is not None
    assert safest.margin >= gentlest.margin >= 1.0
    for design in (gentlest, fastest, safest):
        assert design.speed_min_mm_s == pytest.approx(
            float(slowest(design.motion_scale, design.frequency_hz)), rel=1e-6
        )
        assert design.proof == "searched"
        assert design.window is not None
        low, high = design.window
        assert design.motion_scale is not None
        assert low <= design.motion_scale <= high
        below, within = slowest([low * (1.0 - 1e-6), low * (1.0 + 1e-6)], design.frequency_hz)
        assert below < 100.0 <= within


@pytest.mark.usefixtures("brief")
def test_the_nearest_drive_meets_the_goal() -> None:
    asked = tomllib.loads(EXAMPLE.read_text(encoding="utf-8"))
    asked["goal"] = {"speed_mm_s": 400, "highest_regime": "forward-slip"}
    result = vibro.design(asked, only="goal")
    assert not result.met
    fastest = next(d for d in result.designs if d.design == "fastest")
    assert fastest.motion_scale_needed == fastest.motion_scale  # speeds go with 1/f alone
    assert fastest.frequency_needed_hz is not None
    assert slowest(fastest.motion_scale_needed, fastest.frequency_needed_hz) >= 400.0
    assert slowest(fastest.motion_scale_needed, 1.01 * fastest.frequency_needed_hz) < 400.0


def test_a_speed_that_does_not_depend_on_the_scale_takes_no_more_scales(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On a level drive of steps rounding makes an extremum of every third scale, up to the largest."""
    motion = vibro.Motion.steps(along=[(0.8, 6.9), (0.2, -27.6)])
    scene = vibro.Scene(motion=motion, frequency=5.0, static_friction=0.5, kinetic_friction=0.4)
    solved = []

    def counted(scene: vibro.Scene, **options: Any) -> vibro.SteadyCycle:
        solved.append(math.prod(scene.shape))
        return vibro.solve(scene, **options)

    monkeypatch.setattr("vibro.designs.windows.solve", counted)
    (interval,) = vibro.feasible_amplitudes(scene, 0.1)
    assert interval.low == pytest.approx(0.5210559900755547, rel=1e-12)
    assert interval[1:] == (math.inf, "speed", "limit")
    assert sum(solved) < 10_000
