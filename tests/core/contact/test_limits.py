"""Critical loads: what ``solve`` finds on either side of each, and that classes follow in one order."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np
import pytest
from extremes import extreme_fields
from mpmath import mpf
from scenes import GRAVITY, Groups
from vibro.core.contact.limits import critical_loads

import vibro
from vibro import Regime, Status
from vibro.core.codes import Level

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from vibro.core.contact.limits import CriticalLoads

    Floats = NDArray[np.float64]

ANGLES_AND_FRICTIONS = ("drive_angle", "static_friction", "kinetic_friction", "trough_angle")
FREQUENCY = 1.0
NEAR = 1e-9


class Drives:
    """Many drives without a load: angles [rad] and coefficients of friction."""

    def __init__(self, count: int, seed: int, most_trough_deg: float, *, least_ratio: float = 0.3) -> None:
        random = np.random.default_rng(seed)
        self.drive = np.radians(random.uniform(1.0, 75.0 - 0.6 * most_trough_deg, count))
        self.mu_s = random.uniform(0.05, 1.2, count)
        self.mu_d = self.mu_s * random.uniform(least_ratio, 1.0, count)
        tilt = np.minimum(most_trough_deg, 0.98 * np.degrees(np.arctan(self.mu_s)))
        self.trough = np.radians(random.uniform(-1.0, 1.0, count) * tilt)

    def limits(self) -> CriticalLoads:
        return critical_loads(self.drive, self.mu_s, self.mu_d, self.trough)

    def solve(self, load: Floats, accuracy: Level = Level.EXACT) -> vibro.SteadyCycle:
        """Solve at loads of shape (..., count); drives that no load is given for (inf, NaN) at 1."""
        usable = np.where(np.isfinite(load) & (load > 0.0), load, 1.0)
        return vibro.solve(
            vibro.Scene(
                amplitude=usable * GRAVITY / (2.0 * np.pi * FREQUENCY) ** 2,
                frequency=FREQUENCY,
                drive_angle=self.drive,
                static_friction=self.mu_s,
                kinetic_friction=self.mu_d,
                trough_angle=self.trough,
                gravity=GRAVITY,
            ),
            accuracy=accuracy,
        )


@pytest.fixture(scope="module", params=[0.0, 8.0, 30.0], ids=["flat", "inclined", "steep"])
def drives(request: pytest.FixtureRequest) -> Drives:
    return Drives(5000, seed=round(request.param), most_trough_deg=request.param)


def _sides(drives: Drives, critical: Floats) -> tuple[Any, vibro.SteadyCycle, vibro.SteadyCycle]:
    """Which drives have the transition below the hop, and their cycles just below and above it."""
    reached = (critical > 0.0) & (critical < drives.limits().hop * (1.0 - 10.0 * NEAR))
    critical = np.where(reached, critical, np.nan)  # not to follow hops that nobody looks at
    return reached, drives.solve(critical * (1.0 - NEAR)), drives.solve(critical * (1.0 + NEAR))


def test_the_body_hops_above_its_critical_load(drives: Drives) -> None:
    hop = drives.limits().hop
    assert (drives.solve(hop * (1.0 + NEAR), Level.REGIMES).regime == Regime.HOPPING).all()
    assert (drives.solve(hop * (1.0 - NEAR), Level.REGIMES).regime != Regime.HOPPING).all()


def test_slip_begins_at_the_onsets(drives: Drives) -> None:
    limits = drives.limits()
    for critical, ratio in ((limits.forward_onset, "forward_ratio"), (limits.back_onset, "back_ratio")):
        reached, below, above = _sides(drives, critical)
        assert reached.sum() > 500
        assert (getattr(below, ratio)[reached] < 1.0).all()
        assert (getattr(above, ratio)[reached] > 1.0).all()
    reached, below, above = _sides(drives, np.minimum(limits.forward_onset, limits.back_onset))
    assert (below.regime[reached] == Regime.NO_SLIP).all()
    assert np.isin(above.regime[reached], (Regime.FORWARD_SLIP, Regime.BACK_SLIP)).all()


def test_back_slip_enters_at_its_critical_load(drives: Drives) -> None:
    limits = drives.limits()
    reached, below, above = _sides(drives, limits.back_slip)
    late = reached & (limits.back_slip > limits.back_onset * (1.0 + 1e-6))
    assert reached.sum() > 500
    assert late.sum() > 20
    assert (below.regime[reached] != Regime.BACK_SLIP).all()
    assert (above.regime[reached] == Regime.BACK_SLIP).all()


def test_rest_vanishes_at_its_critical_load(drives: Drives) -> None:
    reached, below, above = _sides(drives, drives.limits().rest_vanishes)
    assert reached.sum() > 500
    assert (below.pattern[reached] != "FB").all()
    assert (above.pattern[reached] == "FB").all()


def test_the_limits_classify_any_load_as_the_solver_does(drives: Drives) -> None:
    limits = drives.limits()
    load = np.exp(np.random.default_rng(7).uniform(np.log(0.02), np.log(8.0), (8, drives.mu_s.size)))
    classes = drives.solve(load, Level.REGIMES)
    slips = np.minimum(limits.forward_onset, limits.back_onset)
    expected = np.select(
        [load > limits.hop, load > limits.back_slip, load > slips],
        [Regime.HOPPING, Regime.BACK_SLIP, Regime.FORWARD_SLIP],
        Regime.NO_SLIP,
    )
    settles = (classes.status == Status.OK) | (classes.regime == Regime.HOPPING)
    assert settles.mean() > 0.75
    assert np.array_equal(classes.regime[settles], expected[settles])

    in_contact = drives.solve(np.minimum(load, 0.999 * limits.hop))
    never_rests = np.minimum(load, 0.999 * limits.hop) > limits.rest_vanishes
    settles = in_contact.status == Status.OK
    assert np.array_equal((in_contact.pattern == "FB")[settles], never_rests[settles])


@pytest.mark.parametrize(
    ("seed", "most_trough_deg", "least_ratio"), [(11, 0.0, 0.3), (12, 10.0, 0.3), (13, 30.0, 0.02)]
)
def test_classes_follow_each_other_in_one_order_as_the_load_grows(
    seed: int, most_trough_deg: float, least_ratio: float
) -> None:
    drives = Drives(4000, seed, most_trough_deg, least_ratio=least_ratio)
    limits = drives.limits()
    first = 0.5 * np.minimum(limits.forward_onset, limits.back_onset)
    share = np.linspace(0.0, 1.0, 50)[:, None]
    regime = drives.solve(first ** (1.0 - share) * (1.01 * limits.hop) ** share, Level.REGIMES).regime
    assert set(regime.flat) == {Regime.NO_SLIP, Regime.FORWARD_SLIP, Regime.BACK_SLIP, Regime.HOPPING}
    assert np.count_nonzero(np.diff(regime.astype(int), axis=0) < 0) == 0
    never_rests = drives.solve(first ** (1.0 - share) * (0.999 * limits.hop) ** share).pattern == "FB"
    assert np.count_nonzero(never_rests[:-1] & ~never_rests[1:]) == 0


def _rest_vanishes(groups: Groups) -> float:
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
def test_rest_vanishes_in_closed_form(groups: Groups) -> None:
    limits = critical_loads(
        math.radians(groups.drive_deg), groups.mu_s, groups.mu_d, math.radians(groups.trough_deg)
    )
    assert limits.rest_vanishes > limits.back_slip
    assert limits.rest_vanishes == pytest.approx(_rest_vanishes(groups), rel=1e-14)


def test_transitions_that_never_happen_are_at_infinity() -> None:
    flat_drive = critical_loads(0.0, 0.5, 0.4)
    assert flat_drive.hop == np.inf
    pressed = critical_loads(math.radians(60.0), 0.9, 0.5)  # a < mu_s b: no load slips the body back
    assert [pressed.back_onset, pressed.back_slip, pressed.rest_vanishes] == [np.inf] * 3
    assert math.isfinite(pressed.forward_onset)


def test_a_trough_that_nothing_rests_on_has_no_load_to_wait_for() -> None:
    limits = critical_loads(0.2, 0.3, 0.2, np.radians([-20.0, 20.0]))
    assert limits.forward_onset[0] == 0.0
    assert limits.back_onset[1] == 0.0
    assert limits.rest_vanishes.tolist() == [0.0, 0.0]


def test_combinations_that_cannot_be_have_no_critical_loads() -> None:
    limits = critical_loads(
        np.radians([20.0, 80.0, 20.0]), [0.5, 0.5, 0.0], [0.6, 0.4, 0.0], np.radians(10.0)
    )
    for critical in limits:
        assert np.isnan(critical).all()


def test_limits_have_the_broadcast_shape() -> None:
    limits = critical_loads(np.full((3, 1), 0.3), np.linspace(0.3, 0.9, 4), 0.25)
    for critical in limits:
        assert critical.shape == (3, 4)
    one = critical_loads(0.3, 0.5, 0.25)
    assert all(np.ndim(critical) == 0 for critical in one)
    middle = critical_loads(0.3, np.linspace(0.3, 0.9, 4)[1], 0.25)
    assert [c[1, 1] for c in limits] == list(middle)


def test_limits_of_extreme_frictions_and_angles_raise_no_warning() -> None:
    # a back onset below 1e-308, and both onsets an ulp apart
    tiny = critical_loads([0.3, 1e-12], [1e-312, 0.5], [1e-313, 1e-14])
    assert (tiny.back_slip >= tiny.back_onset).all()
    fields = extreme_fields(20_000, seed=200)
    limits = critical_loads(*(fields[name] for name in ANGLES_AND_FRICTIONS))
    known = ~np.isnan(limits.back_slip)
    assert known.mean() > 0.5
    assert (limits.back_slip >= limits.back_onset)[known].all()
