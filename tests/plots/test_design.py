"""Pictures of designs: what they show of settings is what bodies of the box do there."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.drawn import curve, legend, only_map, path_of, unarranged
from helpers.questions import answered
from matplotlib.path import Path as Outline

import vibro
from vibro import Regime
from vibro.answers.design import goal_text
from vibro.designs.design import chosen_of
from vibro.designs.pictured import setting_fields, speed_band
from vibro.designs.reading import read_spec
from vibro.plots import design as settings_module
from vibro.plots.design import Settings, design_figures
from vibro.results.designs import Design

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from vibro.designs.design import Chosen
    from vibro.designs.questions import Spec

    Floats = NDArray[np.float64]

NUT: dict[str, Any] = {
    "scene": {"static_friction": "0.7:0.78", "kinetic_friction": "0.5:0.6"},
    "drive": [{"name": "motor", "amplitude_mm": 3, "frequency_hz": "10:30", "drive_angle_deg": "5:45"}],
    "goal": {"speed_mm_s": 30, "highest_regime": "forward-slip"},
}
FEEDER: dict[str, Any] = {
    "scene": {"static_friction": "0.3:0.5", "friction_ratio": "0.7:0.9", "trough_angle_deg": 3},
    "drive": [
        {"name": "$magnet", "amplitude_mm": 0.8, "frequency_hz": "50, 100", "drive_angle_deg": "5:60"},
        {
            "name": "unbalance",
            "amplitude_mm": 3,
            "frequency_hz": "15:25",
            "drive_angle_deg": "5:60",
            "acceleration_g": 4,
        },
    ],
    "goal": {"speed_mm_s": 4, "highest_regime": "back-slip"},
}


@pytest.fixture(scope="module", autouse=True)
def _coarse() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(settings_module, "_RESOLVED", 121)
        yield


def design_of(spec: Spec, drive: int, a: float, f: float, angle: float, **more: Any) -> tuple[Spec, Chosen]:
    """Choose a setting by hand."""
    design = Design(
        drive=spec.drives[drive].name,
        highest_regime=spec.goal.highest_regime.label,
        design="safest",
        amplitude_mm=a,
        frequency_hz=f,
        drive_angle_deg=angle,
        **more,
    )
    chosen = chosen_of(spec, answered(True, design))
    assert chosen is not None
    return spec, chosen


def pictures_of(spec: Spec, chosen: Chosen) -> dict[str, Figure]:
    fields, band = setting_fields(spec, chosen), speed_band(spec, chosen)
    with unarranged():
        return design_figures(spec, chosen, fields, band, goal_text(spec, chosen))


@pytest.fixture(scope="module")
def nut() -> tuple[Spec, Chosen]:
    numbers = {"speed_min_mm_s": 36.0, "amplitude_low_mm": 2.3237, "amplitude_high_mm": 3.0}
    return design_of(read_spec(NUT), 0, 2.45, 10.2, 31.0, **numbers)


@pytest.fixture(scope="module")
def pictures(nut: tuple[Spec, Chosen]) -> dict[str, Figure]:
    return pictures_of(*nut)


@pytest.fixture(scope="module")
def magnet() -> tuple[Spec, Chosen]:
    return design_of(read_spec(FEEDER), 0, 0.11, 50.0, 55.0, speed_min_mm_s=4.5)


@pytest.fixture(scope="module")
def magnets_pictures(magnet: tuple[Spec, Chosen]) -> dict[str, Figure]:
    return pictures_of(*magnet)


def settings_over(spec: Spec, chosen: Chosen, count: int) -> tuple[Floats, Floats]:
    """Return frequencies and amplitudes, spread over what is drawn."""
    data = setting_fields(spec, chosen)
    rng = np.random.default_rng(5)
    slow, fast = data.frequency_hz
    frequency = slow + (fast - slow) * rng.random(count)
    low, high = data.amplitudes
    return frequency, low * (high / low) ** rng.random(count)


def cycles(spec: Spec, chosen: Chosen, frequency: Floats, amplitude: Floats) -> vibro.SteadyCycle:
    """Solve settings, a row each, for a grid of frictions; bodies that hop are not followed."""
    static, second = np.meshgrid(*(np.linspace(*spec.bands[name], 5) for name in list(spec.bands)[:2]))
    kinetic = second * static if "friction_ratio" in spec.bands else second
    scene = vibro.Scene(
        amplitude=1e-3 * amplitude[:, np.newaxis],
        frequency=frequency[:, np.newaxis],
        drive_angle=math.radians(chosen.design.drive_angle_deg or 0.0),
        static_friction=static.ravel(),
        kinetic_friction=kinetic.ravel(),
        trough_angle=spec.bands["trough_angle"][0],
    )
    return vibro.solve(scene, flight=False)


def uppermost(axes: Axes, points: Floats) -> list[str]:
    """Name what is filled at points."""
    named = [str(p.get_gid()) for p in axes.patches if p.get_gid() != "beyond the drive"]
    inside = {name: path_of(axes, name).contains_points(points) for name in named}
    return [[name for name in named if inside[name][i]][-1] for i in range(len(points))]


def test_regimes_are_those_of_the_least_and_the_most_lively_part(
    magnet: tuple[Spec, Chosen], magnets_pictures: dict[str, Figure]
) -> None:
    (spec, chosen), figure = magnet, magnets_pictures["regime"]
    for patch in only_map(figure).patches:
        assert bool(patch.get_hatch()) == ("by part" in str(patch.get_gid()))
    frequency, amplitude = settings_over(spec, chosen, 400)
    regime = cycles(spec, chosen, frequency, amplitude).regime
    names = uppermost(only_map(figure), np.column_stack([frequency, amplitude]))
    data = setting_fields(spec, chosen)
    load = Settings(spec, chosen, data, "").load(amplitude, frequency)
    clear = np.ones(load.shape, np.bool_)  # of boundaries, which are drawn between the grid's points
    for edge in np.array(list(data.begins.values())).ravel():
        clear &= abs(np.log(load / edge)) > 1e-3
    assert clear.mean() > 0.95
    seen = set()
    for least, most, name in zip(
        regime.min(axis=1)[clear], regime.max(axis=1)[clear], np.array(names)[clear], strict=True
    ):
        ends = [Regime(code).label for code in (least, most)]
        assert name.startswith(ends[0])
        assert ends[1] in name
        assert ("by part" in name) == (least != most)
        seen.add(name)
    assert len(seen) >= 4


def test_what_meets_the_goal_is_what_every_part_does(
    nut: tuple[Spec, Chosen], pictures: dict[str, Figure]
) -> None:
    spec, chosen = nut
    frequency, amplitude = settings_over(spec, chosen, 1500)
    drive, goal = chosen.drive, spec.goal
    found = cycles(spec, chosen, frequency, amplitude)
    allowed = (found.regime <= goal.highest_regime).all(axis=1)
    slowest = np.where(allowed, np.nan_to_num(found.mean_velocity, nan=-1.0).min(axis=1), -1.0)
    possible = amplitude <= 1e3 * drive.span("amplitude")[1]
    possible &= np.any([(low <= frequency) & (frequency <= high) for low, high in drive.frequency], axis=0)
    settings = Settings(spec, chosen, setting_fields(spec, chosen), "")
    excess = settings.meets(amplitude, frequency)
    meets = possible & (slowest >= goal.speed)
    clear = (abs(excess) > 2e-3) & possible
    assert np.array_equal(excess[clear] > 0.0, meets[clear])
    assert 0.01 < meets.mean() < 0.5
    outline = Outline(curve(only_map(pictures["speed"]), "meets"))
    inside = outline.contains_points(np.column_stack([frequency, amplitude]))
    sure = possible & (abs(excess) >= 0.05)  # of a coarse picture
    assert np.array_equal(inside[sure], meets[sure])


def test_headings_repeat_the_question(pictures: dict[str, Figure], nut: tuple[Spec, Chosen]) -> None:
    for figure in pictures.values():
        text = str(figure.get_suptitle())
        assert "0.7 ... 0.78" in text
        assert "0.5 ... 0.6" in text
        assert "goal: at least 30 mm/s for every part; forward-slip at most" in text
        assert "not met" not in text
        assert "vibro" not in text
    spec, chosen = nut
    slow = replace(chosen, design=replace(chosen.design, speed_min_mm_s=20.0))
    assert "(not met)" in str(pictures_of(spec, slow)["band"].get_suptitle())


def test_the_band_holds_the_speeds_of_all_parts(
    pictures: dict[str, Figure], nut: tuple[Spec, Chosen]
) -> None:
    strip, axes = pictures["band"].axes
    amplitude = np.linspace(1.2, 3.4, 60)
    speed = 1e3 * cycles(*nut, np.full(60, 10.2), amplitude).mean_velocity
    band = speed_band(*nut)
    for values, wanted in ((band.speed_min, speed.min(axis=1)), (band.speed_max, speed.max(axis=1))):
        np.testing.assert_allclose(np.interp(amplitude, band.amplitude, values), wanted, rtol=2e-3, atol=2e-2)
    line = curve(axes, "slowest part")
    np.testing.assert_array_equal(line[:, 1], band.speed_min)
    (goal,) = (line for line in axes.lines if line.get_gid() == "level")
    assert set(np.asarray(goal.get_ydata(), float)) == {30.0}
    (window,) = (patch for patch in axes.patches if patch.get_gid() == "window")
    assert window.get_extents().transformed(axes.transData.inverted()).intervalx == pytest.approx(
        (2.3237, 3.0)
    )
    assert "keeps the goal" in legend(pictures["band"])
    starts = [line for line in axes.lines if str(line.get_label()).partition(" part starts")[1]]
    assert len({str(vars(line)["_dash_pattern"]) for line in starts}) == len(starts) == 2
    assert {text.get_text() for text in strip.texts} >= {"no-slip", "forward-slip"}
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("amplitude $A$ [mm]", "mean conveying speed [mm/s]")


def test_further_limits_narrow_what_meets_the_goal(nut: tuple[Spec, Chosen]) -> None:
    spec, chosen = nut
    goal = replace(spec.goal, highest_regime=Regime.HOPPING, impact_speed=0.2, flight_fraction=0.4)
    limited = replace(spec, goal=goal, restitution=(0.0, 0.0))
    data = setting_fields(limited, chosen)
    steps = {"impact_speed": 200.0 * 20.0 / 0.9, "flight_fraction": 0.4 / 0.9}
    for name, above in steps.items():
        fields: Mapping[str, Any] = {other: np.zeros(data.load.shape) for other in steps}
        changed = replace(data, **{**fields, name: np.where(data.load > 2.0, above, 0.0)}, tips=math.inf)
        _assert_ends_at(Settings(limited, chosen, changed, ""), 2.0)
    _assert_ends_at(Settings(limited, chosen, replace(data, **fields, tips=1.5), ""), 1.5)


def _assert_ends_at(settings: Settings, load: float) -> None:
    """At 20 Hz no setting beyond a load meets the goal, and those just below do."""
    for factor in (0.98, 1.02):
        amplitude = factor * load * 9.81e3 / (2.0 * math.pi * 20.0) ** 2
        excess = settings.meets(np.array([amplitude]), np.array([20.0]))
        assert (excess[0] > 0.0) == (factor < 1.0)
