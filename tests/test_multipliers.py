"""The multipliers of steady cycles, against differences of bodies that SciPy integrates."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from engines.integrated import TURN, Body
from helpers.periodic_tables import read_rows, scene_of
from helpers.scenes import Groups, driven, random_scenes, replaced

import vibro
from vibro import Regime, Status

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

STEP = 1e-5  # [A w, A] of the differences: their error is of its square, that of the integration 1e-7


def settled(groups: Groups, restitution: float, turns: int, lead: float) -> Body:
    """Follow a body from rest for whole turns."""
    body = Body(groups, restitution, lead=lead)
    body.until(turns * TURN)
    return body


def strobed(body: Body, groups: Groups, restitution: float, period: int, lead: float) -> float:
    """Return the modulus of the largest multiplier of a motion that repeats after some turns.

    Bodies beside the one given are followed until then: the eigenvalues of what becomes of the differences.
    """
    free = [1, 2, 3] if body.aloft else [1]
    if not body.aloft and not body.way:
        return 0.0
    images = []
    for i in free:
        ends = []
        for sign in (1.0, -1.0):
            other = Body(groups, restitution, phase=body.p, lead=lead)
            other.aloft, other.way, other.state = body.aloft, body.way, body.state.copy()
            other.state[i] += sign * STEP
            other.until(body.p + period * TURN)
            ends.append(other.state[free])
        images.append((ends[0] - ends[1]) / (2.0 * STEP))
    return float(max(abs(np.linalg.eigvals(np.array(images)))))


# of lines: without rest, with flights and slides, flights alone with a complex pair and with real ones, and
# two flights in two turns; of an ellipse
CYCLES = [
    ("FB", Groups(2.2, 20.0, 0.5, 0.3), 0.0, None, 0.3),
    ("HFB", Groups(1.52 / math.sin(0.5), math.degrees(0.5), 0.3, 0.1), 0.0, None, 1.0),
    ("H", Groups(2.83 / math.sin(0.5), math.degrees(0.5), 0.5, 0.4), 0.1, None, 1.0),
    ("H", Groups(2.95 / math.sin(0.5), math.degrees(0.5), 0.5, 0.4), 0.1, None, 1.0),
    ("H", Groups(3.59 / math.sin(0.5), math.degrees(0.5), 0.5, 0.4), 0.0, None, 1.0),
    ("HH", Groups(3.768 / math.sin(0.6), math.degrees(0.6), 0.5, 0.1), 0.0, None, 1.0),
    ("FB", Groups(1.6, 25.0, 0.5, 0.2), 0.0, 50.0, 0.3),
]


@pytest.mark.parametrize(("pattern", "groups", "restitution", "phase_deg", "begin"), CYCLES)
def test_differences_of_integrated_bodies(
    pattern: str, groups: Groups, restitution: float, phase_deg: float | None, begin: float
) -> None:
    cycle = vibro.solve(driven(groups, phase_deg, restitution))
    assert cycle.status == Status.OK
    assert cycle.pattern == pattern
    assert 0.0 < cycle.largest_multiplier < 1.0
    lead = math.radians(phase_deg or 0.0)
    turns = 3 + math.ceil(math.log(1e-6) / math.log(cycle.largest_multiplier))
    body = settled(groups, restitution, turns, lead)
    body.until(body.p + begin)
    found = strobed(body, groups, restitution, int(cycle.period_cycles), lead)
    assert found == pytest.approx(float(cycle.largest_multiplier), rel=2e-4)


def test_flights_without_contact_have_those_of_the_reference() -> None:
    """Computed in 200-bit arithmetic (tests/data/README.md); one row counts a cycle of one turn twice."""
    seen = 0
    for row in read_rows("steady_plastic") + read_rows("steady_bouncing"):
        if row["largest_multiplier"]:
            cycle = vibro.solve(scene_of(row))
            times = int(row["period_cycles"]) / cycle.period_cycles
            expected = float(row["largest_multiplier"])
            assert cycle.largest_multiplier**times == pytest.approx(expected, rel=1e-9)
            seen += 1
    assert seen == 16


def test_what_rests_forgets_and_a_mean_has_none() -> None:
    scenes = random_scenes(400, 1)
    cycle = vibro.solve(scenes)
    rests = np.char.find(cycle.pattern.astype(str), "_") >= 0
    assert rests.sum() > 100
    assert not cycle.largest_multiplier[rests].any()
    slides_on = cycle.pattern == "FB"
    assert slides_on.any()
    assert ((cycle.largest_multiplier[slides_on] > 0.0) & (cycle.largest_multiplier[slides_on] < 1.0)).all()
    hops = replaced(random_scenes(1, 2), amplitude=np.linspace(8e-3, 40e-3, 200), restitution=0.5)
    cycle = vibro.solve(hops)
    assert (cycle.regime == Regime.HOPPING).sum() > 100
    averaged = cycle.status == Status.AVERAGED
    assert averaged.any()
    np.testing.assert_array_equal(np.isnan(cycle.largest_multiplier), averaged)


def test_without_friction_the_velocity_stays() -> None:
    """Nothing acts along a level trough with mu_d = 0 on a body that does not stop: a neutral family."""
    scene = driven(Groups(3.2 / math.sin(0.5), math.degrees(0.5), 0.5, 0.0), None, 0.1)
    cycle = vibro.solve(scene)
    assert cycle.status == Status.BOUNDARY
    assert cycle.largest_multiplier == 1.0
