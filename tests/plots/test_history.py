"""Pictures over time: every panel has its curves, units and shades where the phase table says."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.made_records import Walked, nut
from matplotlib.patches import Polygon, Rectangle

import vibro
from vibro.motion.histories import trace
from vibro.plots.comparison import comparison_figure
from vibro.plots.history import PANELS, PHASE_COLOURS, choose_panels, history_figure
from vibro.records.comparison import compare

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@cache
def draw(
    amplitude: float = 1.0, cycles: float = 3.0, panels: str | None = None, since: float = 0.0
) -> tuple[vibro.History, Figure]:
    """Follow the nut at an amplitude [mm], and draw it from a time on [s]; tests only look at the figure."""
    history = vibro.simulate(nut(amplitude), cycles=cycles)
    rows = trace(history, since=since, until=history.end, samples_per_cycle=200, both_sides=True)
    flies = any(p.kind == "H" for p in history.phases)
    return history, history_figure(history.phases, rows, choose_panels(panels, flies=flies), "title", {})


def shades(axes: Axes, kind: str) -> list[tuple[float, float]]:
    """Start and end of the spans that are shaded in the colour of a phase [ms]."""
    from matplotlib.colors import to_rgb

    found = []
    for patch in axes.patches:
        if not isinstance(patch, Rectangle | Polygon) or to_rgb(patch.get_facecolor()) != to_rgb(
            PHASE_COLOURS[kind]
        ):
            continue
        x = np.asarray(patch.get_path().transformed(patch.get_patch_transform()).vertices)[:, 0]
        found.append((float(x.min()), float(x.max())))
    return found


@pytest.mark.parametrize("amplitude", [1.5, 4.0])
def test_slides_and_flights_are_shaded_where_the_phases_say(amplitude: float) -> None:
    history, figure = draw(amplitude)
    for axes in figure.axes[1:]:
        for kind in "FBH":
            expected = [(1e3 * p.start, 1e3 * p.end) for p in history.phases if p.kind == kind]
            np.testing.assert_allclose(np.reshape(shades(axes, kind), (-1, 2)), np.reshape(expected, (-1, 2)))


def test_every_panel_has_its_unit_and_curve() -> None:
    _, figure = draw(4.0)
    labels = [axes.get_ylabel() for axes in figure.axes[1:]]
    assert len(labels) == len(PANELS)
    for label, panel in zip(labels, PANELS.values(), strict=True):
        assert label.endswith(f"[{panel.unit}]")
    assert figure.axes[-1].get_xlabel() == "time [ms]"
    velocity = figure.axes[1 + list(PANELS).index("velocity")].lines[0]
    x, y = np.asarray(velocity.get_xdata()), np.asarray(velocity.get_ydata())
    history = vibro.simulate(nut(4.0), cycles=3)
    np.testing.assert_allclose(y[5], 1e3 * history.sample(x[5] / 1e3).velocity, rtol=1e-12)


def test_phases_are_named_and_events_marked() -> None:
    history, figure = draw()
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert texts == ["rest", "forward slide", "rest", "forward slide", "rest", "forward slide", "rest"]
    marks = {line.get_label(): line for line in figure.axes[2].lines if line.get_marker() not in ("None", "")}
    starts, stops = marks["slide starts"], marks["slide stops"]
    slides = [p for p in history.phases if p.kind == "F"]
    np.testing.assert_allclose(np.asarray(starts.get_xdata()), [1e3 * p.start for p in slides])
    np.testing.assert_allclose(np.asarray(stops.get_xdata()), [1e3 * p.end for p in slides])
    # A slide starts where friction reaches the limit of static friction.
    before = history.sample([p.start for p in slides], side="left")
    np.testing.assert_allclose(np.asarray(starts.get_ydata()), -before.static_limit, rtol=1e-12)
    after = history.sample([p.end for p in slides])
    np.testing.assert_allclose(np.asarray(stops.get_ydata()), after.friction, rtol=1e-12)
    assert set(names_in(figure)) == {
        "limits of static friction",
        "inertial and gravity, along the trough",
        "friction on the body",
        "slide starts",
        "slide stops",
    }


def names_in(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts() if text.get_text().strip()]


def test_nothing_is_named_that_is_not_drawn() -> None:
    history, figure = draw(4.0)
    slide = [p for p in history.phases if p.kind in "FB"][-1]
    air = next(p for p in history.phases if p.kind == "H")
    _, flight = draw(4.0, cycles=15 * 0.5 * (air.start + air.end), since=air.start + 1e-6)
    assert names_in(flight) == ["friction on the body"]
    assert [text.get_text() for text in flight.axes[0].texts] == ["flight"]
    assert not any(shades(axes, slide.kind) for axes in flight.axes)
    # The narrow slides at the start have no room for their name in the strip, flights have.
    assert {"slide starts", "slide stops", "impact", "forward slide"} <= set(names_in(figure))
    assert names_in(draw(0.5)[1]) == [
        "limits of static friction",
        "inertial and gravity, along the trough",
        "friction on the body",
    ]


def test_static_friction_has_a_limit_either_way() -> None:
    _, figure = draw(panels="forces")
    upper, lower = (np.asarray(line.get_ydata()) for line in figure.axes[1].lines[:2])
    np.testing.assert_array_equal(lower, -upper)
    assert np.nanmin(upper) > 0.0


def test_a_comparison_has_a_row_a_signal() -> None:
    comparison = compare(nut(), Walked(nut()).observe("displacement", "velocity", cycles=5))
    figure = comparison_figure(comparison, "title", {}, comparison)
    assert len(figure.axes) == 4
    assert [axes.get_ylabel() for axes in figure.axes[::2]] == [
        "relative displacement\n[mm]",
        "relative velocity\n[mm/s]",
    ]
    over_time, on_one = figure.axes[2], figure.axes[3]
    assert over_time.get_xlim() == pytest.approx((0.0, 200.0))
    assert on_one.get_xlim() == pytest.approx((0.0, 1e3 / 15))
    slides = [(1e3 * start, 1e3 * end) for _, start, end in comparison.motion.slides]
    assert any(np.allclose(shade, slides[0]) for shade in shades(on_one, "F"))
    for axes, noise in ((figure.axes[1], 0.05), (on_one, 3.0)):
        measured, computed, fitted = (
            line for line in axes.lines if not str(line.get_label()).startswith("_")
        )
        x, y, at, wanted = (np.asarray(data) for line in (measured, computed) for data in line.get_data())
        assert len(x) == 201
        assert np.ptp(y - np.interp(x, at, wanted)) < noise
    speeds = comparison.observation.signals["velocity"]
    np.testing.assert_allclose(y, 1e3 * speeds)
    np.testing.assert_allclose(np.asarray(fitted.get_ydata()), np.asarray(computed.get_ydata()))
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert legend == ["measured", "computed", "computed, fitted", "forward slide"]
