"""Where words are placed, on an empty map that is measured in pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from matplotlib.figure import Figure

from vibro.plots.labels import Labeller

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH, HEIGHT = 800, 600  # [px]
NAME = "a name of a line"


@pytest.fixture
def axes() -> Axes:
    figure = Figure(figsize=(WIDTH / 100, HEIGHT / 100), dpi=100)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0, WIDTH), ylim=(0, HEIGHT))
    return axes


@pytest.mark.parametrize("falling", [False, True])
def test_no_word_is_upside_down(axes: Axes, falling: bool) -> None:
    for start, end in (((200.0, 150.0), (500.0, 450.0)), ((500.0, 450.0), (200.0, 150.0))):
        line = np.array([start, end]) * ([1.0, -1.0] if falling else [1.0, 1.0]) + [0.0, 600.0 * falling]
        assert Labeller(axes).along(NAME, [line])
    angles = [(text.get_rotation() + 180.0) % 360.0 - 180.0 for text in axes.texts]
    assert angles == pytest.approx([-45.0 if falling else 45.0] * 2)
