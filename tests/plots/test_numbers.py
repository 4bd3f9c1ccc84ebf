"""Maps of speed and traverse time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.drawn import (
    colours_of,
    curve,
    image_of,
    legend,
    only_map,
    path_of,
    said,
    scene_of,
    sweep,
    unarranged,
    words,
)
from matplotlib.colors import AsinhNorm, CenteredNorm, LogNorm, Normalize

from vibro import Regime, Scene, solve
from vibro.plots import map_figures
from vibro.plots.scales import scale_of
from vibro.plots.style import BACKWARDS_LABEL
from vibro.results.sweep import SweepResult

if TYPE_CHECKING:
    from helpers.drawn import Floats
    from matplotlib.figure import Figure

pytestmark = pytest.mark.usefixtures("unarranged")


def test_hopping_leaves_colours_to_speeds_in_contact(pictures: dict[str, Figure], nut: SweepResult) -> None:
    image = image_of(only_map(pictures["speed"]))
    assert image.get_cmap().name == "cividis"
    assert isinstance(image.norm, LogNorm)
    foot = image.get_clim()[0]
    speed = 1e3 * nut.cycle.mean_velocity
    answered = np.isfinite(speed)
    assert image.norm.vmax == pytest.approx(np.nanmax(speed), rel=0.02)
    moving = answered & (nut.cycle.regime != Regime.NO_SLIP)
    expected = colours_of(only_map(pictures["speed"]), np.maximum(speed[moving], foot))
    np.testing.assert_array_equal(image.get_array()[moving], expected)
    in_contact = speed[moving & (nut.cycle.regime != Regime.HOPPING)]
    assert in_contact.max() < 0.2 * image.get_clim()[1]
    assert np.ptp(np.asarray(image.norm(np.maximum(in_contact, foot)))) > 0.4


LEVEL = np.linspace(0.0, 10.0, 101)


@pytest.mark.parametrize(
    ("seen", "regular", "calm", "reverses", "expected", "ends", "extend"),
    [
        (LEVEL, LEVEL, LEVEL, False, Normalize, (0, 10), "neither"),
        (LEVEL, LEVEL, LEVEL[LEVEL < 4], False, Normalize, (0, 10), "neither"),
        (LEVEL, LEVEL, LEVEL[LEVEL < 3], False, LogNorm, (None, 10), "min"),  # hopping is much faster
        (LEVEL, LEVEL[LEVEL < 4], LEVEL[:0], False, LogNorm, (None, 10), "min"),  # irregular motion is
        (LEVEL**4, LEVEL**4, LEVEL**4, False, LogNorm, (None, 1e4), "min"),  # most numbers are small
        (LEVEL[1:] - 0.8, LEVEL, LEVEL, False, Normalize, (0, 9.2), "min"),  # a few bounces go backwards
        (LEVEL - 2, LEVEL - 2, LEVEL - 2, True, CenteredNorm, (-8, 8), "neither"),
        (LEVEL - 2, LEVEL - 2, LEVEL[LEVEL < 2] - 1, True, AsinhNorm, (-8, 8), "neither"),
        (LEVEL + 12, LEVEL + 12, LEVEL + 12, False, Normalize, (12, 22), "neither"),  # all alike
        (LEVEL - 22, LEVEL - 22, LEVEL - 22, True, Normalize, (-22, -12), "neither"),
        (np.zeros(3), np.zeros(3), np.zeros(3), False, Normalize, (0, 1), "neither"),
        (LEVEL[:0], LEVEL[:0], LEVEL[:0], False, Normalize, (0, 1), "neither"),
    ],
)
def test_scales_tell_apart_what_most_bodies_do(
    seen: Floats,
    regular: Floats,
    calm: Floats,
    reverses: bool,
    expected: type[Normalize],
    ends: tuple[float | None, float],
    extend: str,
) -> None:
    scale = scale_of(seen, regular, calm, reverses=reverses)
    assert type(scale.norm) is expected
    assert scale.norm.vmin == (ends[0] if ends[0] is not None else scale.norm.vmin)
    assert scale.norm.vmax == pytest.approx(ends[1])
    assert scale.extend == extend
    assert 0.0 not in scale.levels
    if expected in (LogNorm, AsinhNorm):
        foot = float(scale.norm.vmin or 0.0)
        heights = np.asarray(scale.norm(np.maximum(calm if calm.size else regular, foot)))
        assert np.ptp(heights) > 0.3


def test_a_logarithmic_scale_begins_below_nearly_all_numbers_within_five_decades() -> None:
    def foot(seen: Floats, regular: Floats) -> float:
        scale = scale_of(seen, regular, regular, reverses=False)
        assert type(scale.norm) is LogNorm
        return float(scale.norm.vmin or 0.0)

    assert np.mean(foot(LEVEL, LEVEL[LEVEL < 3]) > LEVEL) == pytest.approx(0.02, abs=0.01)
    few = np.geomspace(1e-9, 10.0, 101)
    assert foot(few, few[few < 3]) == pytest.approx(1e-4)
    fast = np.concatenate([[0.0, 1.0], np.linspace(8.0, 10.0, 199)])
    assert foot(fast, fast[:2]) == pytest.approx(5.0)


def test_contours_carry_their_values(pictures: dict[str, Figure]) -> None:
    axes = only_map(pictures["speed"])
    for level in ("10", "50", "100", "200"):
        assert level in words(axes)
        frequency, amplitude = curve(axes, f"contour {level}").T
        cycle = solve(scene_of(1e-3 * amplitude, frequency))
        speed = 1e3 * cycle.mean_velocity
        once = cycle.period_cycles == 1.0  # elsewhere speeds rise as steeply as a cliff
        off = np.abs(speed / float(level) - 1.0)[once]
        assert np.median(off) < 1e-3
        assert np.quantile(off, 0.98) < 0.06  # by which the speed drops where back slip begins


@pytest.mark.parametrize("name", ["regime", "speed"])
def test_where_bodies_move_backwards_is_hatched_up_to_the_line_of_zero_speed(
    climb_pictures: dict[str, Figure], climb: SweepResult, name: str
) -> None:
    axes = only_map(climb_pictures[name])
    assert "zero speed" in words(axes)
    if name == "speed":
        norm = image_of(axes).norm
        assert image_of(axes).get_cmap().name == "RdBu"
        assert norm.vmin == -norm.vmax
    assert BACKWARDS_LABEL in legend(climb_pictures[name])
    amplitude, angle = curve(axes, "zero speed").T
    cycle = solve(
        Scene(
            amplitude=1e-3 * amplitude,
            frequency=15,
            drive_angle=math.radians(20),
            static_friction=0.74,
            kinetic_friction=0.57,
            trough_angle=np.radians(angle),
        )
    )
    assert np.nanmax(np.abs(cycle.mean_velocity)) < 1e-2 * np.nanmax(np.abs(climb.cycle.mean_velocity))
    y, x = (climb.axes[name].values for name in ("trough_angle", "amplitude"))
    speed = climb.cycle.mean_velocity.T
    hatched = path_of(axes, BACKWARDS_LABEL).contains_points(
        np.column_stack([np.tile(x, len(y)), np.repeat(y, len(x))])
    )
    sure = np.abs(speed) > 0.01 * np.nanmax(np.abs(speed))
    np.testing.assert_array_equal(hatched.reshape(speed.shape)[sure], (speed < 0.0)[sure])


def test_traverse_times(pictures: dict[str, Figure], nut: SweepResult) -> None:
    image = image_of(only_map(pictures["traverse"]))
    assert type(image.norm) is LogNorm
    moving = np.isfinite(nut.cycle.mean_velocity) & (nut.cycle.mean_velocity > 0)
    times = 0.6 / nut.cycle.mean_velocity[moving]
    expected = colours_of(only_map(pictures["traverse"]), times)
    np.testing.assert_array_equal(image.get_array()[moving], expected)
    shortest, longest = image.get_clim()
    assert shortest == pytest.approx(times.min(), rel=0.02)
    assert 0.97 < np.mean(times < longest) < 0.99


@pytest.fixture(scope="module")
def flights() -> tuple[SweepResult, dict[str, Figure]]:
    """Throw numbers up to 10: from rest to flights of several cycles."""
    result = sweep(points=241, amplitude="0.1:8", frequency="5:35", drive_angle=30)
    with unarranged():
        return result, map_figures(result, ["speed", "impact", "flight"])


def test_flight_is_shown_where_there_is_one(flights: tuple[SweepResult, dict[str, Figure]]) -> None:
    result, figures = flights
    hopping = result.cycle.regime == Regime.HOPPING
    for name, expected in (
        ("impact", 1e3 * result.cycle.impact_velocity),
        ("flight", result.cycle.flight_fraction),
    ):
        axes = only_map(figures[name])
        colours = colours_of(axes, expected[hopping])
        np.testing.assert_array_equal(image_of(axes).get_array()[hopping], colours)
        assert "no flight" in words(axes)
        frequency, amplitude = curve(axes, "hop").T
        cover = path_of(axes, "no flight")
        inside = (frequency > 10) & (frequency < 34)
        assert cover.contains_points(np.column_stack([frequency, 0.999 * amplitude])[inside]).all()
        assert not cover.contains_points(np.column_stack([frequency, 1.001 * amplitude])[inside]).any()
    bars = [a.get_ylabel() for f in figures.values() for a in f.axes if a.get_label() == "<colorbar>"]
    assert bars == [
        "mean conveying speed [mm/s]",
        "impact speed, normal to the trough [mm/s]",
        "share of time in flight",
    ]


def test_a_speed_that_is_asked_for_stands_out(nut: SweepResult) -> None:
    figure = map_figures(nut, ["speed"], target_speed=20.0)["speed"]
    line = curve(only_map(figure), "20 mm/s")
    speed = 1e3 * solve(scene_of(1e-3 * line[:, 1], line[:, 0])).mean_velocity
    error = abs(speed / 20.0 - 1.0)
    assert len(line) > 500
    assert np.sum(error > 5e-3) <= 4  # where it crosses a jump
    assert error.max() < 0.1
    (drawn,) = [line for line in only_map(figure).lines if line.get_gid() == "20 mm/s"]
    assert drawn.get_linewidth() > 2.0
    assert "20 mm/s" in said(figure)
