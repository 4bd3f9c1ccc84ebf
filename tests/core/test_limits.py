"""Critical loads: closed forms, what ``steady_cycle`` finds on either side of each, and one order."""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING

import mpmath
import numpy as np
import pytest
from extremes import extreme_fields
from helpers.contact_loads import EPS, ellipse, heavier, line
from helpers.scenes import Groups
from mpmath import mpf

from vibro.core.codes import Pattern, Regime, Status
from vibro.core.contact import Steady, steady_cycle
from vibro.core.limits import critical_loads, tipping_load
from vibro.core.slides import thresholds
from vibro.limits import critical_loads_of_lines

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from vibro.core.drive import Loads

NEAR = 1e-9


def unit_lines(count: int, seed: int, steepest_deg: float, least_ratio: float = 0.3) -> Iterator[Loads]:
    """Draw lines at G = 1."""
    draw = random.Random(seed)
    for _ in range(count):
        mu_s = draw.uniform(0.05, 1.2)
        steepest = min(steepest_deg, 0.98 * math.degrees(math.atan(mu_s)))
        drive = draw.uniform(1.0, 75.0 - 0.6 * steepest_deg)
        yield line(drive, 1.0, mu_s, mu_s * draw.uniform(least_ratio, 1.0), draw.uniform(-steepest, steepest))


def unit_ellipses(count: int, seed: int) -> Iterator[Loads]:
    """Draw ellipses at A w^2 = g, every other one on an incline of up to the angle of kinetic friction."""
    draw = random.Random(seed)
    for i in range(count):
        mu_s = math.exp(draw.uniform(math.log(0.05), math.log(1.5)))
        mu_d = mu_s * draw.uniform(0.4, 1.0)
        trough = draw.uniform(-0.9, 0.9) * math.atan(mu_d) if i % 2 else 0.0
        normal = math.exp(draw.uniform(math.log(0.01), 0.0))
        along = mu_d * math.exp(draw.uniform(math.log(0.1), math.log(30.0)))
        scale, phase = max(along, normal), draw.uniform(-math.pi, math.pi)
        yield ellipse(along / scale, normal / scale, phase, 1.0, mu_s, mu_d, trough)


def at(unit: Loads, load: float) -> Steady:
    loads = heavier(unit, 1.0 / load)
    return steady_cycle(loads, thresholds(loads))


SOME = {
    "level": list(unit_lines(100, 1, 0.0)),
    "inclined": list(unit_lines(70, 2, 8.0)),
    "steep": list(unit_lines(100, 3, 30.0, 0.05)),
    "ellipses": list(unit_ellipses(110, 41)),
    "as ellipses": [x._replace(line=False) for x in unit_lines(100, 4, 5.0)],
}


def forward_load(unit: Loads, load: float) -> bool:
    return thresholds(heavier(unit, 1.0 / load)).forward


def back_load(unit: Loads, load: float) -> bool:
    return thresholds(heavier(unit, 1.0 / load)).back


HAPPENS: dict[str, Callable[[Loads, float], bool]] = {
    "hop": lambda unit, load: at(unit, load).regime == Regime.HOPPING,
    "forward_onset": forward_load,
    "back_onset": back_load,
    "back_slip": lambda unit, load: at(unit, load).regime == Regime.BACK_SLIP,
    "continuous_sliding": lambda unit, load: at(unit, load).pattern == Pattern.FB,
}


@pytest.mark.parametrize("kind", SOME)
@pytest.mark.parametrize("name", HAPPENS)
def test_each_limit_is_where_the_cycle_changes(name: str, kind: str) -> None:
    reached = late = 0
    for unit in SOME[kind]:
        limits = critical_loads(unit)
        critical = getattr(limits, name)
        highest = limits.hop * (1.0 - 10.0 * NEAR)
        if critical == math.inf or (name != "hop" and critical > highest):
            if name in ("back_slip", "continuous_sliding"):  # it never happens in contact
                for share in (0.1, 0.5, 0.9, 1.0):
                    found = at(unit, share * highest)
                    assert found.status == Status.RUNAWAY or not HAPPENS[name](unit, share * highest)
            continue
        reached += 1
        late += critical > limits.back_onset * (1.0 + 1e-6)
        assert not HAPPENS[name](unit, critical * (1.0 - NEAR)), unit
        assert HAPPENS[name](unit, critical * (1.0 + NEAR)), unit
    assert reached > 30
    assert late > 2 or name != "back_slip"


def _continuous_sliding(groups: Groups) -> float:
    """Bisect, with 40 digits, for the load from which both slides of FB start beyond static friction."""
    with mpmath.mp.workdps(40):
        alpha, beta = mpmath.radians(mpf(groups.drive_deg)), mpmath.radians(mpf(groups.trough_deg))
        mu_s, mu_d = mpf(groups.mu_s), mpf(groups.mu_d)

        def rests(load: mpf) -> bool:
            a, b = load * mpmath.cos(alpha), load * mpmath.sin(alpha)
            weight, tilt = mpmath.cos(beta), mpmath.sin(beta)
            k_f, k_b = (mu_d * weight + tilt) / (a + mu_d * b), (mu_d * weight - tilt) / (a - mu_d * b)
            s_f, s_b = (mu_s * weight + tilt) / (a + mu_s * b), (mu_s * weight - tilt) / (a - mu_s * b)
            x = mpmath.pi * k_b / (k_f + k_b)
            sine = k_f * x / mpmath.sin(x)
            if sine >= 1:
                return True
            m = mpmath.pi - mpmath.asin(sine)
            return bool(mpmath.sin(m - x) < s_f or -mpmath.sin(m + x) < s_b)

        low, high = mpf(0.01), mpf(100)
        assert rests(low)
        assert not rests(high)
        for _ in range(100):
            middle = (low + high) / 2
            low, high = (middle, high) if rests(middle) else (low, middle)
        return float(low)


@pytest.mark.parametrize(
    "groups",
    [
        Groups(0.0, 20.0, 0.74, 0.57),
        Groups(0.0, 6.0, 0.182, 0.182),
        Groups(0.0, 30.0, 0.5, 0.4),
        Groups(0.0, 9.0, 0.573, 0.48, -2.5),
        Groups(0.0, 16.5, 0.36, 0.24, 3.0),
        Groups(0.0, 12.0, 0.8, 0.7, 20.0),
    ],
)
def test_continuous_sliding_in_closed_form(groups: Groups) -> None:
    unit = line(groups.drive_deg, 1.0, groups.mu_s, groups.mu_d, groups.trough_deg)
    limits = critical_loads(unit)
    assert limits.continuous_sliding > limits.back_slip
    assert limits.continuous_sliding == pytest.approx(_continuous_sliding(groups), rel=1e-14)


@pytest.mark.parametrize(
    ("groups", "expected"),
    [(Groups(0.0, 44.8, 0.492, 0.189), 0.0), (Groups(0.0, 19.0, 0.237, 0.103, -5.0), 0.0)],
)
def test_back_slip_enters_where_the_forward_slide_just_fills_the_back_window(
    groups: Groups, expected: float
) -> None:
    unit = line(groups.drive_deg, 1.0, groups.mu_s, groups.mu_d, groups.trough_deg)
    limits = critical_loads(unit)
    with mpmath.mp.workdps(40):
        alpha, beta = mpmath.radians(mpf(groups.drive_deg)), mpmath.radians(mpf(groups.trough_deg))
        a, b, n, t = mpmath.cos(alpha), mpmath.sin(alpha), mpmath.cos(beta), mpmath.sin(beta)
        mu_s, mu_d = mpf(groups.mu_s), mpf(groups.mu_d)

        def left(load: mpf) -> mpf:  # of speed at the window's end
            p_f = mpmath.asin((mu_s * n + t) / (a + mu_s * b) / load)
            p_end = 2 * mpmath.pi - mpmath.asin((mu_s * n - t) / (a - mu_s * b) / load)
            k = (mu_d * n + t) / (a + mu_d * b) / load
            return mpmath.cos(p_f) - mpmath.cos(p_end) - k * (p_end - p_f) + expected

        exact = mpmath.findroot(left, mpf(limits.back_slip))
    assert limits.back_slip > 1.01 * limits.back_onset
    assert limits.back_slip == pytest.approx(float(exact), rel=1e-14)


def test_closed_forms() -> None:
    unit = line(20.0, 1.0, 0.5, 0.4, 3.0)
    alpha, beta = math.radians(20.0), math.radians(3.0)
    limits = critical_loads(unit)
    assert limits.hop == pytest.approx(math.cos(beta) / math.sin(alpha), rel=4 * EPS)
    for way, onset in ((1.0, limits.forward_onset), (-1.0, limits.back_onset)):
        needed = 0.5 * math.cos(beta) + way * math.sin(beta)
        assert onset == pytest.approx(needed / (math.cos(alpha) + way * 0.5 * math.sin(alpha)), rel=8 * EPS)
    # Eq. (55) of an ellipse
    x, y, phi, mu = 0.7, 1.0, -1.1, 0.6
    limits = critical_loads(ellipse(x, y, phi, 1.0, mu, 0.5))
    for way, onset in ((1.0, limits.forward_onset), (-1.0, limits.back_onset)):
        load = math.sqrt(x * x + way * 2.0 * mu * x * y * math.cos(phi) + (mu * y) ** 2)
        assert onset == pytest.approx(mu / load, rel=8 * EPS)
    assert limits.hop == 1.0


def test_transitions_that_never_happen_are_at_infinity() -> None:
    assert critical_loads(line(0.0, 1.0, 0.5, 0.4)).hop == math.inf
    pressed = critical_loads(line(60.0, 1.0, 0.9, 0.5))  # a < mu_s b: no load slips the body back
    assert pressed.continuous_sliding == math.inf
    assert math.isfinite(pressed.forward_onset)
    assert pressed.back_onset > pressed.hop
    still = critical_loads(ellipse(0.0, 0.0, 1.0, 1.0, 0.5, 0.4))
    assert still == (math.inf,) * 5
    # a decline steeper than kinetic friction: forward slides outlast every back window
    downhill = critical_loads(line(10.0, 1.0, 0.5, 0.1, -10.0))
    assert downhill.back_onset < downhill.back_slip == math.inf == downhill.continuous_sliding


def test_a_trough_that_nothing_rests_on_has_no_load_to_wait_for() -> None:
    for unit in (line(11.0, 1.0, 0.3, 0.2, -20.0), ellipse(1.0, 0.2, 1.0, 1.0, 0.3, 0.2, -0.35)):
        limits = critical_loads(unit)
        assert limits.forward_onset == 0.0 == limits.continuous_sliding
        assert limits.back_onset > 0.0
    limits = critical_loads(line(11.0, 1.0, 0.3, 0.2, 20.0))
    assert limits.back_onset == 0.0 == limits.continuous_sliding
    for unit in (line(11.0, 1.0, 0.25, 0.2), ellipse(1.0, 0.2, 1.0, 1.0, 0.25, 0.2)):
        on_the_edge = unit._replace(weight_tangential=0.25 * unit.weight_normal)
        assert critical_loads(on_the_edge).continuous_sliding == 0.0


def test_combinations_that_cannot_be_have_no_critical_loads() -> None:
    for unit in (line(20.0, 1.0, 0.5, 0.6), line(20.0, 1.0, 0.0, 0.0)):
        assert all(map(math.isnan, critical_loads(unit)))
    assert not any(map(math.isnan, critical_loads(line(20.0, 1.0, 0.5, 0.5))))


# --------------------------------------------------------------------------------------------- tipping


def test_parts_that_slip_before_they_tip_never_tip() -> None:
    unit = line(20.0, 1.0, 0.5, 0.4)
    assert tipping_load(unit, 0.5) == math.inf == tipping_load(unit, 0.7)
    assert tipping_load(unit, 0.4999) < math.inf
    assert tipping_load(line(20.0, 1.0, 0.5, 0.4, 10.0), 0.1) == 0.0


# ---------------------------------------------------------------------------------------------- lines


def test_limits_of_extreme_frictions_and_angles_raise_nothing() -> None:
    # a back onset below 1e-308, and both onsets an ulp apart
    tiny = critical_loads_of_lines([0.3, 1e-12], [1e-312, 0.5], [1e-313, 1e-14])
    assert (tiny.back_slip >= tiny.back_onset).all()
    fields = extreme_fields(4000, seed=200)
    names = ("drive_angle", "static_friction", "kinetic_friction", "trough_angle")
    limits = critical_loads_of_lines(*(fields[name] for name in names))
    known = ~np.isnan(limits.back_slip)
    assert known.mean() > 0.5
    assert (limits.back_slip >= limits.back_onset)[known].all()
