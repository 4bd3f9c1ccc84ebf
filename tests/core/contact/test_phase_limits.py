"""Critical loads of elliptical drives: what ``solve`` finds on either side, and one order of classes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from two_axis_scenes import Drives, random_drives

import vibro
from vibro import Regime, Status

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

NEAR = 1e-9


@pytest.fixture(scope="module")
def some() -> Drives:
    drives = random_drives(600, 41)
    tilt = np.arctan(drives.mu_d) * np.random.default_rng(41).uniform(-0.9, 0.9, 600)
    return drives.changed(trough=np.where(np.arange(600) % 2, tilt, 0.0))


@pytest.fixture(scope="module")
def limits(some: Drives) -> vibro.core.contact.limits.CriticalLoads:
    return vibro.critical_loads(some.scene())


def at(some: Drives, load: Floats) -> vibro.SteadyCycle:
    """Solve at loads; those without one at a hundredth of today's."""
    usable = np.where(np.isfinite(load) & (load > 0.0), load, 0.01 * some.scene().load)
    return vibro.solve(some.scaled(usable / some.scene().load).scene(), flight=False)


@pytest.mark.parametrize(
    ("name", "most_missing"),
    [("hop", 0), ("forward_onset", 60), ("back_onset", 60), ("back_slip", 60), ("rest_vanishes", 240)],
)
def test_each_limit_is_where_solve_changes_its_mind(
    some: Drives, limits: vibro.core.contact.limits.CriticalLoads, name: str, most_missing: int
) -> None:
    load = getattr(limits, name)
    real = np.isfinite(load) & (load <= limits.hop) & (load > 0.0)
    assert np.count_nonzero(~real) <= most_missing
    below, above = (at(some, load * (1.0 + side * NEAR)) for side in (-1.0, 1.0))
    tests: dict[str, Callable[[vibro.SteadyCycle], Any]] = {
        "hop": lambda cycle: cycle.regime == Regime.HOPPING,
        "forward_onset": lambda cycle: cycle.forward_ratio > 1.0,
        "back_onset": lambda cycle: cycle.back_ratio > 1.0,
        "back_slip": lambda cycle: cycle.regime == Regime.BACK_SLIP,
        "rest_vanishes": lambda cycle: cycle.pattern == "FB",
    }
    holds = tests[name]
    if name != "hop":
        real &= load * (1.0 + NEAR) < limits.hop
    assert not np.any(real & holds(below))
    assert np.all(~real | holds(above))


def test_classes_follow_each_other_in_one_order(
    some: Drives, limits: vibro.core.contact.limits.CriticalLoads
) -> None:
    reached = np.zeros(limits.hop.shape)
    for share in np.geomspace(0.02, 1.0 - 1e-9, 60):
        cycle = at(some, share * limits.hop)
        rank = np.where(cycle.pattern == "FB", 2.5, cycle.regime.astype(float))
        told = np.isin(cycle.status, (Status.OK, Status.BOUNDARY))
        assert not np.any(told & (rank < reached))
        reached = np.where(told, rank, reached)
    assert np.count_nonzero(reached == 2.5) > 320


def test_what_never_begins_before_the_hop_is_infinite(
    some: Drives, limits: vibro.core.contact.limits.CriticalLoads
) -> None:
    never = np.isinf(limits.rest_vanishes)
    assert np.count_nonzero(never) > 8
    assert not np.any(at(some, limits.hop * (1.0 - NEAR)).pattern[never] == "FB")
