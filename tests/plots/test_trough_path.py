"""The path of an elliptical trough: its shape and its way round."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest
from matplotlib.text import Annotation

import vibro
from vibro.motion.histories import trace
from vibro.plots.history import choose_panels, history_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FREQUENCY = 25.0


@cache
def draw(normal: float = 0.3, degrees: float = -60.0) -> tuple[vibro.History, Figure]:
    """Follow a body for three cycles and draw it; tests only look at the figure."""
    scene = vibro.Scene(
        along_amplitude=1e-3,
        normal_amplitude=1e-3 * normal,
        normal_phase=math.radians(degrees),
        frequency=FREQUENCY,
        static_friction=0.4,
        kinetic_friction=0.3,
    )
    history = vibro.simulate(scene, cycles=3)
    rows = trace(history, until=history.end, samples_per_cycle=200, both_sides=True)
    flies = any(p.kind == "H" for p in history.phases)
    seen = choose_panels(None, flies=flies)
    figure = history_figure(history.phases, rows, seen, "title", {}, period=1.0 / FREQUENCY)
    curves = {line.get_label(): np.asarray(line.get_ydata()) for line in figure.axes[1].lines}
    np.testing.assert_allclose(curves["trough, along itself"], 1e3 * rows.trough_along)
    np.testing.assert_allclose(curves["trough, normal to itself"], 1e3 * rows.trough_normal)
    return history, figure


@pytest.mark.parametrize("degrees", [-60.0, 180.0])
def test_the_path_is_the_ellipse_of_the_last_cycle(degrees: float) -> None:
    _, figure = draw(degrees=degrees)
    axes = figure.axes[-1]
    assert axes.get_title() == "path of the trough, last cycle"
    assert axes.get_aspect() == 1.0
    (path,) = (line for line in axes.lines if line.get_linewidth() == 1.2)
    x, y = np.asarray(path.get_xdata()), np.asarray(path.get_ydata())
    assert x.size >= 200
    phase = math.radians(degrees)
    # x = sin p, y = 0.3 sin(p + phi)
    rest = y / 0.3 - x * math.cos(phase)
    assert rest**2 + (x * math.sin(phase)) ** 2 == pytest.approx(math.sin(phase) ** 2, abs=1e-12)
    assert np.ptp(x) == pytest.approx(2.0, rel=1e-3)
    (arrow,) = (text for text in axes.texts if isinstance(text, Annotation))
    head, tail = np.array(arrow.xy), np.array(arrow.xyann)
    turns = float(tail[0] * head[1] - tail[1] * head[0])
    assert np.sign(turns) == (0.0 if degrees == 180.0 else -np.sign(degrees)) or abs(turns) < 1e-12
