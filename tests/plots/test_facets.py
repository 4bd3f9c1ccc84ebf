"""Facets of a third axis."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from helpers.drawn import GRAVITY, curve, maps_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

pytestmark = pytest.mark.usefixtures("unarranged")


def test_a_map_for_every_value(facets: dict[str, Figure]) -> None:
    for figure in facets.values():
        titles = [axes.get_title() for axes in maps_of(figure)]
        assert titles == [r"$\alpha$ = 10°", r"$\alpha$ = 20°", r"$\alpha$ = 30°"]
        assert r"\alpha" not in figure.get_suptitle()
    maps = maps_of(facets["regime"])
    assert [axes.get_ylabel() for axes in maps] == ["amplitude $A$ [mm]", "", ""]
    marked = [any(line.get_gid() == "operating point" for line in axes.lines) for axes in maps]
    assert marked == [False, True, False]


def test_every_map_has_its_own_curves(facets: dict[str, Figure]) -> None:
    for axes, angle in zip(maps_of(facets["regime"]), (10, 20, 30), strict=True):
        frequency, amplitude = curve(axes, "hop").T
        load = amplitude * 1e-3 * (2 * math.pi * frequency) ** 2 / GRAVITY
        np.testing.assert_allclose(load, 1 / math.sin(math.radians(angle)), rtol=1e-12)
