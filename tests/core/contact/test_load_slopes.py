"""How the displacement follows the load: beside differences of solved cycles, for elliptical drives."""

from __future__ import annotations

import math

import numpy as np
import pytest
from two_axis_scenes import Drives, random_drives
from vibro.core.contact.load_slopes import load_slope

from vibro import Status
from vibro.core.codes import Pattern

STEP = 1e-6


def over_scale(some: Drives) -> np.ndarray:
    return some.solve().displacement_per_cycle / some.scene().scale


@pytest.mark.parametrize("steepest", [0.0, 0.6])
def test_the_slope_is_that_of_the_solved_displacements(steepest: float) -> None:
    some = random_drives(3000, 5, steepest=steepest)
    cycle = some.solve()
    found = load_slope(some.scene().flat().loads(), cycle.pattern_code)
    more, less = some.scaled(1.0 + STEP), some.scaled(1.0 - STEP)
    measured = (over_scale(more) - over_scale(less)) / (math.log1p(STEP) - math.log1p(-STEP))
    here = cycle.status == Status.OK
    for beside in (more.solve(), less.solve()):
        here &= beside.pattern == cycle.pattern
    for ratio in (cycle.forward_ratio, cycle.back_ratio):  # differences are poor just above an onset
        here &= (ratio < 1.0) | (ratio > 1.001)
    error = np.abs(found - measured) / (1.0 + np.abs(measured))
    assert np.max(error[here]) < 1e-7
    for pattern in list(Pattern)[1:]:
        assert np.count_nonzero(here & (cycle.pattern_code == pattern)) >= 30


def test_drives_along_a_line_given_by_both_amplitudes_have_the_slope_of_the_line() -> None:
    some = random_drives(2000, 6).changed(lead=0.0)
    cycle = some.solve()
    scene = some.scene().flat().loads()
    line = scene._replace(lead=None, contrast=scene.along * scene.normal)
    slopes = [load_slope(groups, cycle.pattern_code) for groups in (scene, line)]
    told = cycle.status == Status.OK
    assert np.max(np.abs(slopes[0] - slopes[1])[told] / (1.0 + np.abs(slopes[1][told]))) < 1e-11
