"""Fixed points of the return map where forces are tiny, or nothing but a stop can end an orbit."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hopping import hopping_cycles, loads_at_throw, random_loads
from scenes import loads_of

from vibro import Scene, Status, solve
from vibro.core.codes import spelt_text
from vibro.core.contact.legs import track_of
from vibro.core.flight.averages import averages
from vibro.core.flight.bounces import bounces
from vibro.core.flight.coexistence import _slides_otherwise
from vibro.core.flight.cycles import HoppingCycles, cycles, entered
from vibro.core.flight.drift import span_of
from vibro.core.flight.orbits import from_rest
from vibro.core.flight.returns import after_stops, hops_of, return_map, velocity_from_rest
from vibro.core.groups import take

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vibro.core.groups import Loads

    Floats = NDArray[np.float64]

TURN = 2.0 * math.pi


def _solve(scene: Loads, restitution: float = 0.0) -> HoppingCycles:
    return hopping_cycles(scene, np.full(scene.normal.shape, restitution))


def _carried(scene: Loads) -> Floats:
    """Displacement per drive cycle of a body that keeps, over the ground, the speed of its first lift-off."""
    track = track_of(scene)
    return np.asarray(TURN * (velocity_from_rest(track) + scene.along * np.cos(track.lift_off)))


def _hard_scenes(count: int, seed: int, restitution: float) -> Scene:
    random = np.random.default_rng(seed)
    mu_s = 10.0 ** random.uniform(-2.0, 0.3, count)
    drive = 10.0 ** random.uniform(-8.0, 0.17, count)
    trough = random.choice([0.0, 1.0], count) * random.uniform(-1.0, 1.0, count) * np.arctan(mu_s)
    trough = np.where(drive + trough < 0.5 * np.pi, trough, -np.abs(trough))
    load = 10.0 ** random.uniform(0.0, 3.0, count) * np.cos(trough) / np.sin(drive)
    return Scene(
        amplitude=load * 9.81 / (TURN * 15.0) ** 2,
        frequency=15.0,
        drive_angle=drive,
        static_friction=mu_s,
        kinetic_friction=mu_s * 10.0 ** random.uniform(-10.0, 0.0, count),
        trough_angle=trough,
        gravity=9.81,
        restitution=restitution,
    )


@pytest.mark.parametrize(
    ("throw", "drive_deg", "mu_s", "mu_d", "trough_deg", "pattern", "displacement"),
    [
        (1.24, 0.00075, 1.0, 1.3e-10, 0.0, "HFB", 0.28197766550342690587),
        (2.0, 0.01, 0.3, 1e-7, -2e-6, "HFB", 3.6495948504758313772),
        (1.5, 30.0, 0.5, 1e-9, 0.0, "HF_F", 5.3823184539217098557),
        (1.1, 2.0, 0.4, 1e-12, 0.0, "HF_F", 6.2788666264706534638),
        (1.4, 1.0, 0.2, 1e-8, 0.0, "HF_F", 6.2822089608441947166),
    ],
)
def test_low_friction_as_50_digits_have_it(
    throw: float,
    drive_deg: float,
    mu_s: float,
    mu_d: float,
    trough_deg: float,
    pattern: str,
    displacement: float,
) -> None:
    # the fixed point was bracketed by 90 bisections of a cycle computed event by event with mpmath
    found = _solve(loads_at_throw([throw], drive_deg, mu_s, mu_d, trough_deg))
    assert found.status[0] == Status.OK
    assert spelt_text(int(found.pattern[0])) == pattern
    assert found.displacement[0] == pytest.approx(displacement, rel=1e-12)


def test_orbits_on_slopes_end_where_the_plain_walk_does() -> None:
    random = np.random.default_rng(3)
    count = 400
    mu_s = 10.0 ** random.uniform(-1.5, 0.3, count)
    mu_d = mu_s * 10.0 ** random.uniform(-1.0, 0.0, count)
    drive = np.degrees(10.0 ** random.uniform(-0.7, 0.1, count))
    trough = np.degrees(random.uniform(-1.0, 1.0, count) * np.arctan(mu_s))
    trough = np.where(drive + trough < 89.0, trough, -np.abs(trough))
    scene = loads_at_throw(10.0 ** random.uniform(0.001, 1.5, count), drive, mu_s, mu_d, trough)
    motion = bounces(scene.across / scene.normal, np.zeros(count))
    hops = hops_of(scene, motion.cycle)
    cells, velocity = entered(scene, motion)
    end = from_rest(cells, hops, velocity, span_of(cells, np.multiply(TURN, motion.cycles)))
    for _ in range(1000):
        walked = return_map(cells, hops, velocity)
        change, velocity = np.abs(walked.velocity - velocity), walked.velocity
    lost = (np.abs(velocity) > 50.0) & (change > 1e-6)
    settled = (change == 0.0) & motion.repeats
    assert motion.repeats.mean() > 0.9
    steep = np.abs(scene.tangential) > mu_d * scene.normal
    assert (steep & settled).sum() > 2
    assert (steep & lost).sum() > 50
    assert (end.status[lost] == Status.RUNAWAY).all()
    assert (end.status[settled] == Status.OK).all()
    assert end.velocity[settled] == pytest.approx(velocity[settled], abs=1e-10)


@pytest.mark.parametrize(
    "values",
    [
        (103695.7250411434, 0.001548011594029168, 1.5707963267948963, 1.4548878090650144, 1.3638867334587919,
         0.0),
        (1659963571.858305, 1.2235038959284048e-05, 1.2925134995417726, 6.70693834486874, 4.423389766550171,
         0.27828282725312353),
        (30052.51113692142, 0.0028755058266588377, 1.5707963267948963, 1.0980659487845863, 1.0001939110972833,
         0.0),
        (2.8433593353179216e-115, 9.348431741268434e56, 1.3005972463863213, 10.0, 9.999999749049953,
         0.270199080408575),
    ],
)  # fmt: skip
def test_bodies_lifted_off_next_to_their_onset_settle(values: tuple[float, ...]) -> None:
    # onset, lift-off and the least speed of a slide are roots of an ulp apart: the body all but rests
    amplitude, frequency, drive, mu_s, mu_d, trough = values
    scene = Scene(
        amplitude=amplitude, frequency=frequency, drive_angle=drive, static_friction=mu_s,
        kinetic_friction=mu_d, trough_angle=trough, gravity=9.81,
    )  # fmt: skip
    cycle = solve(scene)
    assert 1.0 < cycle.throw_number < 1.0 + 1e-13
    assert cycle.status == Status.OK
    assert abs(cycle.displacement_per_cycle) < 1e-12 * amplitude


def test_a_creeping_body_that_nothing_stops_runs_away() -> None:
    scene = Scene(
        amplitude=1.2793193091150989e-195, frequency=9.39266830238507e102, drive_angle=1.6361849208422574e-12,
        static_friction=0.9003736356165309, kinetic_friction=0.7323132329483241,
        trough_angle=0.7330214919566597, gravity=9.81,
    )  # fmt: skip
    # it gains 3e-12 of the trough's speed in a cycle, and rests in none
    assert solve(scene).status == Status.RUNAWAY


@pytest.mark.parametrize("throw", [40.0, 2e3, 1e5])
def test_without_kinetic_friction_a_level_trough_carries_the_body_as_it_threw_it(throw: float) -> None:
    scene = loads_at_throw([throw], 1.0, 0.5, 0.0)
    found = _solve(scene)
    assert found.status[0] == Status.OK
    assert found.displacement == pytest.approx(_carried(scene), rel=1e-9)


def test_so_does_a_motion_without_a_cycle() -> None:
    scene = loads_at_throw(np.linspace(2.4, 2.5, 6), 30.0, 0.5, 0.0)
    found = _solve(scene, 0.3)
    averaged = found.status == Status.AVERAGED
    assert averaged.sum() >= 3
    # a sample does not end at the phase of the drive at which it began
    error = np.abs(found.displacement - _carried(scene))[averaged]
    assert (error < 6.0 * found.deviation[averaged]).all()


def test_little_friction_does_not_let_irregular_motion_run_away() -> None:
    scene = loads_at_throw(np.linspace(2.4, 2.5, 8), 30.0, 0.16, 1e-6)
    mean = averages(scene, np.full(8, 0.3), length=24, longest=True)
    assert (mean.status == Status.AVERAGED).all()
    assert (np.abs(mean.displacement) < TURN * scene.along).all()


def test_gravity_that_kinetic_friction_just_holds() -> None:
    mu_d = 1e-9
    trough = math.degrees(math.atan(mu_d))
    throw = np.array([1.0 + 1e-8, 1.2, 1.6, 2.2])
    mu_s = np.array([1.5e-9, 1e-3, 1e-3, 1e-3])
    scene = loads_at_throw(throw, 20.0, mu_s, mu_d, trough)
    found = _solve(scene)
    assert (found.status == Status.BOUNDARY).all()
    # it slides back ever faster until the trough never overtakes it: over the ground at -A w cos(alpha)
    assert found.displacement[0] == pytest.approx(-TURN * scene.along[0], rel=1e-3)
    flatter, steeper = (
        _solve(loads_at_throw(throw, 20.0, mu_s, mu_d * ratio, trough)) for ratio in (1.0 + 1e-9, 1.0 - 1e-9)
    )
    assert (flatter.status == Status.OK).all()
    assert flatter.displacement == pytest.approx(found.displacement, rel=1e-3)
    assert (steeper.status[[0, 3]] == Status.RUNAWAY).all()
    # in between an impact just stops the body: what it gains in a cycle, 1e-18 A w, is below rounding
    assert np.isin(steeper.status[1:3], (Status.OK, Status.RUNAWAY)).all()


def test_a_rest_in_the_cycle_leaves_nothing_to_rounding_where_kinetic_friction_just_holds_gravity() -> None:
    trough = -math.degrees(math.atan(0.1))
    assert _solve(loads_at_throw([1.2], 20.0, 0.5, 0.1, trough)).status[0] == Status.OK


def test_what_follows_the_last_stop_is_known_beforehand() -> None:
    scene = loads_at_throw([1.3, 2.5, 4.5], 25.0, 0.5, 0.35)
    motion = bounces(scene.across / scene.normal, np.zeros(3))
    hops = hops_of(scene, motion.cycle)
    cells, _ = entered(scene, motion)
    owner, velocity = after_stops(cells, hops)
    known = [np.append(velocity[owner == i], velocity_from_rest(cells.track)[i]) for i in range(3)]
    stopped = 0
    for v in np.linspace(-2.0, 2.0, 101):
        cycle = return_map(cells, hops, np.full(3, v))
        for i in np.flatnonzero(cycle.slope == 0.0):
            stopped += 1
            assert np.abs(known[i] - cycle.velocity[i]).min() < 1e-12
    assert stopped > 20


@pytest.mark.parametrize(("restitution", "count"), [(0.0, 3000), (0.4, 400)])
def test_hopping_scenes_of_tiny_forces_are_all_resolved(restitution: float, count: int) -> None:
    scene = loads_of(_hard_scenes(count, 5, restitution))
    found = cycles(scene, np.full(count, restitution))
    repeats = bounces(scene.across / scene.normal, np.full(count, restitution)).repeats
    assert ((found.status == Status.UNRESOLVED) <= ~repeats).all()
    answered = np.isin(found.status, (Status.OK, Status.BOUNDARY))
    assert np.isfinite(found.displacement[answered]).all()
    assert answered[repeats & (scene.tangential == 0.0)].all()
    assert answered.sum() > 80


@pytest.mark.parametrize(
    ("amplitude", "frequency", "drive", "mu_s", "mu_d", "restitution"),
    [
        (1.3748956736119936e-4, 51.236, 1.0669505127608383, 0.30035830, 0.06672496, 0.4668653293478722),
        (3.36438085517087e-3, 15.0, 0.5277495776122026, 1.00793060, 0.28847504, 0.14350018392575653),
    ],
)
def test_several_stops_may_lead_to_another_cycle(
    amplitude: float, frequency: float, drive: float, mu_s: float, mu_d: float, restitution: float
) -> None:
    cycle = solve(
        Scene(
            amplitude=amplitude,
            frequency=frequency,
            drive_angle=drive,
            static_friction=mu_s,
            kinetic_friction=mu_d,
            restitution=restitution,
        ),
        coexistence=True,
    )
    assert cycle.coexists == 1


def test_bodies_from_anywhere_settle_where_it_is_said() -> None:
    count = 2000
    scene = random_loads(count, 5, most_throw=2.5, least_ratio=0.03)
    restitution = np.random.default_rng(5).uniform(0.0, 0.6, count)
    motion = bounces(scene.across / scene.normal, restitution)
    hops = hops_of(scene, motion.cycle)
    cells, start = entered(scene, motion)
    found = from_rest(cells, hops, start, span_of(cells, np.multiply(TURN, motion.cycles)))

    bound = 2.0 * np.broadcast_to(scene.along, count)
    starts = np.array([start, *(bound * f for f in np.linspace(-1.0, 1.0, 10))])
    velocity = starts.ravel()
    settled = np.zeros(velocity.size, np.bool_)
    active = np.arange(velocity.size)
    for _ in range(300):
        after = return_map(take(cells, active % count), hops, velocity[active]).velocity
        moved = np.abs(after - velocity[active]) > 1e-13
        velocity[active] = after
        settled[active[~moved]] = True
        active = active[moved]
    ends = velocity.reshape(starts.shape)
    known = settled.reshape(starts.shape).all(0) & motion.repeats
    assert known.mean() > 0.5
    np.testing.assert_allclose(found.velocity[known], ends[0][known], rtol=0.0, atol=1e-10)
    apart = np.ptp(ends, axis=0) > 1e-7
    none = np.zeros(count)
    others = _slides_otherwise(
        scene, scene.across / scene.normal, restitution, motion.cycles.astype(np.float64), none
    )
    assert others[known].tolist() == apart[known].tolist()
    assert apart[known].sum() > 20
