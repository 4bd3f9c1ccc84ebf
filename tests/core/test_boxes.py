"""Boxes of operating points: their loads, bounds of their speeds, branch and bound, and evolution."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pytest
from engines.certificates import bounds as independent_bounds
from helpers.cases import each
from helpers.draws import examples
from helpers.solver_doors import compiled, plain
from hypothesis import assume, given
from hypothesis import strategies as st

import vibro
from vibro import Regime, Scene, solve
from vibro.core.boxes import (
    AXES,
    Box,
    Cover,
    Population,
    cover,
    evolve,
    frequency_at,
    least_speed,
    mean_speed,
    speed_at,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from vibro import SteadyCycle


GRAVITY = 9.81
FREQUENCY = 15.0


def box_of(low: Any, high: Any = None, **fields: Any) -> Box:
    """Make a box of its ends; of a line unless ``ellipse``, at 15 Hz unless ``frequency`` is a band."""
    low = [float(x) for x in low]
    high = low if high is None else [float(x) for x in high]
    f_low, f_high = fields.pop("frequency", (FREQUENCY, FREQUENCY))
    known: dict[str, Any] = {
        "low": low, "high": high, "ellipse": False, "ratio_low": 0.0, "ratio_high": 1.0,
        "factor_low": low[0] * GRAVITY / (2.0 * math.pi * f_high) ** 2,
        "factor_high": high[0] * GRAVITY / (2.0 * math.pi * f_low) ** 2,
        "frequency_low": f_low, "frequency_high": f_high, "gravity": GRAVITY, "way": 1.0,
        "highest": int(Regime.HOPPING),
    }  # fmt: skip
    return Box(**(known | fields))


def bodies(box: Box, shares: Any) -> SteadyCycle:
    """Solve the bodies at shares of the bands, (AXES, n) and of the frequencies, where friction can be so."""
    low, high = np.array(box.low)[:, None], np.array(box.high)[:, None]
    x = np.clip(low + shares[:AXES] * (high - low), low, high)
    ratio = np.clip(x[6], box.ratio_low * x[5], box.ratio_high * x[5])
    kept = (ratio >= low[6]) & (ratio <= high[6])
    f = box.frequency_low + shares[AXES] * (box.frequency_high - box.frequency_low)
    factor = x[0] * box.gravity / (2.0 * math.pi * f) ** 2
    fields: dict[str, Any] = {
        "frequency": f, "trough_angle": x[4], "static_friction": x[5], "kinetic_friction": ratio,
    }  # fmt: skip
    if box.ellipse:
        fields |= {
            "along_amplitude": factor * x[1], "normal_amplitude": factor * x[2], "normal_phase": x[3],
        }  # fmt: skip
    else:
        fields |= {"amplitude": factor, "drive_angle": x[1]}
    return solve(Scene(**{name: value[kept] for name, value in fields.items()}), flight=False)


def largest_speed(box: Box) -> float:
    """Return the trough's, at its largest amplitude [m/s]."""
    size = max(box.high[1], box.high[2]) if box.ellipse else 1.0
    return 2.0 * math.pi * box.frequency_high * box.factor_high * size


@st.composite
def solver_boxes(draw: Callable[[Any], Any], *, widest: float = 0.3, steep: bool = False) -> Box:
    """Draw boxes in contact; the widths of half of the axes are 0."""
    width = [draw(st.sampled_from([0.0, 0.0, 1e-4, 1e-2, 0.1, 1.0])) * widest for _ in range(AXES)]
    mu_s = draw(st.floats(0.1, 1.0))
    mu_d = mu_s * draw(st.one_of(st.just(1.0), st.floats(0.3, 1.0)))
    beta = math.atan(mu_d) * draw(st.one_of(st.just(0.0), st.floats(-1.5 if steep else -0.9, 0.9)))
    ellipse = draw(st.booleans())
    if ellipse:
        along = draw(st.sampled_from([1e-3, 1e-3, 1e-3, 0.0]))
        normal, phase = 1e-3 * draw(st.floats(0.01, 2.0)), draw(st.floats(-math.pi, math.pi))
        low = [along, normal, phase]
        high = [along + 1e-3 * width[1], normal * (1.0 + width[2]), phase + 3.0 * width[3]]
    else:
        low = [draw(st.floats(0.0, 1.0)), 0.0, 0.0]
        high = [low[0] + 0.3 * width[1], 0.0, 0.0]
    troughs = [beta, beta + 0.2 * width[4]]
    normal = high[1] if ellipse else math.sin(high[0])
    hop = min(map(math.cos, troughs)) / max(normal, 0.05 * (1e-3 if ellipse else 1.0))
    load = hop * draw(st.one_of(st.just(1.0), st.floats(0.1, 1.0)))
    static = [mu_s, mu_s * (1.0 + width[5])]
    kinetic = [mu_d * (1.0 - width[6]), min(mu_d * (1.0 + width[6]), static[1])]
    ratio = (0.0, 1.0)
    if draw(st.booleans()):
        ratio = kinetic[0] / static[0], min(kinetic[1] / static[0], 1.0)
        kinetic = [ratio[0] * static[0], ratio[1] * static[1]]
    return box_of(
        [load * (1.0 - 0.5 * width[0]), *low, troughs[0], static[0], kinetic[0]],
        [load, *high, troughs[1], static[1], max(kinetic)],
        ellipse=ellipse, ratio_low=ratio[0], ratio_high=ratio[1], way=draw(st.sampled_from([1.0, -1.0])),
        frequency=draw(st.sampled_from([(15.0, 15.0), (14.0, 15.0)])),
    )  # fmt: skip


NUT = [1.4, 0.35, 0.0, 0.0, 0.0, 0.74, 0.57]
WIDE = [1.5, 0.36, 0.0, 0.0, 0.0, 0.74, 0.57]


@pytest.mark.parametrize("path", [0.7, -0.7])
def test_the_least_speed_of_a_load_is_at_the_frequency_of_its_sign(path: float) -> None:
    box = box_of(NUT, WIDE, frequency=(10.0, 20.0), factor_low=1e-3, factor_high=3e-3)
    w = 2.0 * math.pi * frequency_at(box, 1.45, path > 0.0)
    expected = path * 1.45 * GRAVITY / (2.0 * math.pi * w)
    assert mean_speed(box, 1.45, path) == pytest.approx(expected, rel=1e-14)
    other = 2.0 * math.pi * frequency_at(box, 1.45, path < 0.0)
    assert expected < path * 1.45 * GRAVITY / (2.0 * math.pi * other)
    assert mean_speed(box, 1.4, path) * path < mean_speed(box, 1.5, path) * path  # it grows in size


@each("way", [1.0, -1.0])
@each(
    ("changed", "highest", "expected"),
    [
        ({}, Regime.HOPPING, "speed"), ({}, Regime.BACK_SLIP, "speed"), ({}, Regime.FORWARD_SLIP, "least"),
        ({0: 3.0}, Regime.HOPPING, "unknown"), ({0: 3.0}, Regime.BACK_SLIP, "least"),
        ({4: -0.6}, Regime.HOPPING, "least"), ({4: -0.7}, Regime.HOPPING, "least"),
    ],
)  # fmt: skip
def test_bodies_without_a_speed_count_as_the_slowest(
    changed: dict[int, float], highest: Regime, expected: str, way: float
) -> None:
    """As do those of a regime too high; of bodies that hop the speed is unknown."""
    x: Any = [changed.get(i, value) for i, value in enumerate(NUT)]
    found = speed_at(box_of(x, way=way, highest=int(highest)), x, 0)
    scene: dict[str, Any] = {"drive_angle": 0.35, "static_friction": 0.74, "kinetic_friction": 0.57}
    amplitude = NUT[0] * GRAVITY / (2.0 * math.pi * 15.0) ** 2
    if expected == "speed":
        speed = float(vibro.solve(vibro.Scene(amplitude=amplitude, frequency=15.0, **scene)).mean_velocity)
        assert found == pytest.approx(way * speed, rel=1e-12)
    else:
        assert found == -math.inf if expected == "least" else math.isnan(found)


# ------------------------------------------------------------------------------
# Comparison bodies: never faster than a body of their box, and as fast where it has no width.


INF = math.inf
ROUNDING = 1e-14  # of the trough's largest speed
DRAWN = np.random.default_rng(3).random((AXES + 1, 192))
SHARES = np.hstack([DRAWN, np.round(DRAWN), np.where(DRAWN < 0.5, np.round(DRAWN), DRAWN)])


def bound(box: Box) -> float:
    return least_speed(box, box.low, box.high, 0)


def assert_none_is_slower(box: Box, every: int = 1) -> None:
    """Each of the bodies, or every so many, unless it has no steady motion."""
    cycle, least = bodies(box, SHARES[:, ::every]), bound(box)
    speed = box.way * np.asarray(cycle.mean_velocity)
    speed = speed[np.isfinite(speed) & (np.asarray(cycle.regime) < 3)]
    assert np.all(least <= speed + ROUNDING * largest_speed(box))


def test_friction_beyond_its_ratios_is_that_at_the_cut() -> None:
    box = box_of(NUT, ratio_low=0.7, ratio_high=0.75)
    for kinetic, cut in ((0.2, 0.7 * 0.74), (0.7, 0.75 * 0.74), (0.53, 0.53)):
        given: Any = [*NUT[:6], kinetic, *NUT[:6], cut]
        assert speed_at(box, given, 0) == speed_at(box, given, AXES)


@examples(40)
@given(solver_boxes())
def test_no_body_is_slower_than_the_bound_of_its_box(box: Box) -> None:
    assert_none_is_slower(box)


@examples(30)
@given(solver_boxes(steep=True))
def test_no_body_is_slower_on_a_trough_on_which_some_run_away(box: Box) -> None:
    assert_none_is_slower(box)


def strength(box: Box) -> float:
    """Largest push over the least friction [1]; beyond 20 cycles without rest take hundreds to settle."""
    return box.high[0] * (max(box.high[1:3]) if box.ellipse else 1.0) / box.low[6]


def own_bound(box: Box) -> float:
    """The bound of the checker's comparison body."""
    shape = (
        ("along_amplitude", "normal_amplitude", "normal_phase") if box.ellipse else ("drive_angle", "", "")
    )
    names = ("load", *shape, "trough_angle", "static_friction", "kinetic_friction")
    ends = {name: np.array([[low], [high]]) for name, low, high in zip(names, box.low, box.high, strict=True)}
    ends.pop("", None)
    band = {
        "friction_ratio": (box.ratio_low, box.ratio_high), "gravity": (box.gravity,),
        "amplitude": (box.factor_low, box.factor_high), "frequency": (box.frequency_low, box.frequency_high),
    }  # fmt: skip
    return float(independent_bounds(ends, band, box.way)[0])


@examples(10)
@given(solver_boxes())
def test_bounds_are_no_higher_than_those_of_another_program(box: Box) -> None:
    assume(strength(box) < 20.0)
    assert bound(box) <= own_bound(box) + 1e-11 * largest_speed(box)


LINE = [1.4, 0.35, 0.0, 0.0, 0.0, 0.74, 0.57]


def line(*, way: float = 1.0, **changed: Any) -> Box:
    """A box of a line; ends of bands by the names of its axes."""
    names = ("load", "first", "second", "third", "beta", "static", "kinetic")
    ends = [changed.pop(name, (x, x)) for name, x in zip(names, LINE, strict=True)]
    return box_of([low for low, _ in ends], [high for _, high in ends], way=way, **changed)


@pytest.mark.parametrize(
    ("beta", "way", "bounded"),
    [
        (math.atan(0.57) * (1.0 - 1e-9), 1.0, True), (math.atan(0.57) * (1.0 + 1e-9), 1.0, False),
        (-math.atan(0.57) * (1.0 - 1e-9), 1.0, True), (-math.atan(0.57) * (1.0 + 1e-9), 1.0, False),
        (math.atan(0.57) * (1.0 - 1e-9), -1.0, True), (math.atan(0.57) * (1.0 + 1e-9), -1.0, False),
    ],
)  # fmt: skip
def test_steep_troughs_have_no_bound(beta: float, way: float, bounded: bool) -> None:
    """A band too, if some trough of it is that steep upwards; downwards if all of them are."""
    assert (bound(line(beta=(beta, beta), load=(0.9, 0.9), way=way)) > -INF) is bounded


def test_bodies_that_do_not_slip_have_a_bound_of_0() -> None:
    """Up to the load at which the first one slips."""
    onset = 0.6 / (math.cos(0.35) + 0.6 * math.sin(0.35))
    for way in (1.0, -1.0):
        at_rest = line(load=(0.1, onset * (1.0 - 1e-9)), static=(0.6, 0.8), way=way)
        assert bound(at_rest) == 0.0
    moves = line(load=(0.1, onset * (1.0 + 1e-6)), static=(0.6, 0.8), way=-1.0)
    assert -1e-2 < bound(moves) < 0.0
    assert bound(line(load=(onset * (1.0 + 1e-6),) * 2, static=(0.6, 0.6))) > 0.0


@pytest.mark.parametrize(
    ("kinetic", "ratio", "has_bodies"),
    [
        ((0.5, 0.6), (0.7, 0.75), True), ((0.6, 0.7), (0.7, 0.75), True), ((0.61, 0.7), (0.7, 0.75), False),
        ((0.3, 0.489), (0.7, 0.75), False), ((0.3, 0.491), (0.7, 0.75), True),
        ((0.81, 0.9), (0.0, 1.0), False),
    ],
)  # fmt: skip
def test_a_box_without_bodies_has_the_bound_of_none(
    kinetic: tuple[float, float], ratio: tuple[float, float], has_bodies: bool
) -> None:
    box = line(static=(0.7, 0.8), kinetic=kinetic, ratio_low=ratio[0], ratio_high=ratio[1])
    assert (bound(box) < INF) is has_bodies


@each("way", [1.0, -1.0])
@each("drive", [0.0, math.atan(0.74), 0.5 * math.pi - 1e-5])
@each("ratio", [0.0, 0.7])
def test_no_body_is_slower_beside_a_threshold(drive: float, ratio: float, way: float) -> None:
    """Loads about the onsets of both ways, and up to the hop."""
    mu_s, hop = 0.74, 1.0 / max(math.sin(drive), 0.05)
    onsets = [mu_s / abs(math.cos(drive) + sigma * mu_s * math.sin(drive)) for sigma in (1.0, -1.0)]
    for onset in (*onsets, hop):
        for factor in (1.0 - 1e-12, 1.0, 1.0 + 1e-15, 1.0 + 1e-9, 1.0 + 1e-3):
            load = min(onset * factor, hop)
            low = [load, drive, 0.0, 0.0, 0.0, mu_s, ratio * mu_s]
            assert_none_is_slower(box_of(low, way=way), 12)
            for axis in (0, 1, 4, 5, 6):
                high = list(low)
                high[axis] = min(low[axis] + 1e-6, hop if axis == 0 else mu_s if axis == 6 else INF)
                if drive + high[4] < 0.5 * math.pi and high[0] * math.sin(high[1]) <= math.cos(high[4]):
                    assert_none_is_slower(box_of(low, high, way=way), 12)


@pytest.mark.parametrize("load", [14.4, 15.0, 20.0])
def test_a_cycle_counts_once_where_rounding_parts_it(load: float) -> None:
    """Without kinetic friction on a level trough a slide ends at the phase at which the next may start."""
    assert_none_is_slower(box_of([load, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0], [load, 0.0, 0.0, 0.0, 0.0, 0.57, 0.0]))
    for drive in np.linspace(0.0, 0.2, 21):
        for way in (1.0, -1.0):
            least = min(load, 0.99 / max(math.sin(drive), 1e-3))
            assert_none_is_slower(box_of([least, float(drive), 0.0, 0.0, 0.0, 0.1167, 0.0], way=way))


# ------------------------------------------------------------------------------
# Branch and bound: boxes that cover a box, in the order of a heap, within a budget; compiled and plain.


LOW = [1.3, 0.33, 0.0, 0.0, 0.0, 0.6, 0.45]
HIGH = [1.5, 0.37, 0.0, 0.0, 0.03, 0.8, 0.6]
BOXES = {
    "line": box_of(LOW, HIGH, ratio_low=0.7, ratio_high=0.8),
    "fastest": box_of(LOW, HIGH, ratio_low=0.7, ratio_high=0.8, way=-1.0),
    "ellipse": box_of(
        [1250.0, 1e-3, 3e-4, -0.6, 0.0, 0.35, 0.3], [1300.0, 1e-3, 4e-4, -0.4, 0.0, 0.4, 0.3], ellipse=True
    ),
    "continuous sliding": box_of([2.7, 0.2, 0, 0, 0, 0.18, 0.15], [2.7, 0.2, 0, 0, 0, 0.2, 0.16]),
}


def room(most: int, speed: float = math.inf) -> Cover:
    ends: Any = [0.0] * AXES * most
    others: Any = [0.0] * most, [0] * most, [0.0] * 2 * AXES, [speed]
    return Cover(ends, ends.copy(), *others)


class Covered(NamedTuple):
    low: Any
    high: Any
    bound: Any
    heap: Any
    point: Any
    speed: float


def covered(box: Box, most: int, gap: float = 1e-3, least: float = 0.0, speed: float = math.inf) -> Covered:
    out = room(most, speed)
    count = cover(box, out, gap, least, most)
    low, high = (np.array(x[: AXES * count]).reshape(count, AXES) for x in (out.low, out.high))
    return Covered(low, high, np.array(out.bound[:count]), out.heap[:count], out.point[:AXES], out.speed[0])


def volume(low: Any, high: Any, box: Box) -> Any:
    width = np.array(box.high) - np.array(box.low)
    return np.prod(((high - low) / np.where(width > 0.0, width, 1.0))[:, width > 0.0], axis=1)


@each("name", BOXES)
@each("most", [1, 2, 3, 60])
def test_boxes_fill_the_box(name: str, most: int) -> None:
    """Disjoint, of the whole volume; each with a bound that is its own, or that of a box around it."""
    box = BOXES[name]
    found = covered(box, most)
    count = len(found.bound)
    assert count == most or found.bound.min() >= found.speed * (1.0 - 1e-3)
    assert volume(found.low, found.high, box).sum() == pytest.approx(1.0, rel=1e-12)
    apart = (found.low[:, None] >= found.high) | (found.high[:, None] <= found.low)
    apart &= np.array(box.high) > np.array(box.low)
    assert np.all(apart.any(axis=2) | np.eye(count, dtype=bool))
    own = [least_speed(box, found.low.ravel(), found.high.ravel(), row) for row in range(count)]
    assert np.all(found.bound >= np.array(own))
    assert np.all(found.bound <= np.maximum(own, found.bound.min()) + 2e-5 * largest_speed(box))
    assert found.bound.min() >= least_speed(box, box.low, box.high, 0)


@pytest.mark.parametrize(("gap", "least"), [(1e-1, 0.0), (3e-2, 0.0), (2e-2, 1.0)])
def test_boxes_are_divided_until_the_gap_is_closed(gap: float, least: float) -> None:
    found = covered(BOXES["line"], 8000, gap, least)
    closed = found.speed - gap * max(abs(found.speed), least)
    assert found.bound.min() >= closed
    if len(found.bound) > 1:  # the last step was needed
        before = covered(BOXES["line"], len(found.bound) - 1, gap, least)
        assert before.bound.min() < before.speed - gap * max(abs(before.speed), least)


@given(solver_boxes())
def test_no_body_that_is_met_is_slower_than_the_bounds(box: Box) -> None:
    found = covered(box, 12)
    if math.isfinite(found.speed):
        assert found.bound.min() <= found.speed + 1e-14 * largest_speed(box)


@pytest.mark.parametrize("name", BOXES)
def test_compiled_and_plain_bounds_have_the_same_bits(name: str) -> None:
    box, most, found = BOXES[name], 60, []
    for kind in (compiled, plain):
        with kind() as solver:
            low, high, lows, highs, bounds, heap, met, speed = arrays = [
                np.array(box.low), np.array(box.high), *np.zeros((2, most, AXES)), *np.zeros((2, most)),
                np.zeros(2 * AXES), np.array([math.inf]),
            ]  # fmt: skip
            rows = [solver.row(x) for x in (low, high)]
            room = tuple(map(solver.row, (lows, highs, bounds, heap.view(np.int64), met, speed)))
            count = solver.cover((*rows, *box[2:]), room, 1e-3, 0.0, most)
            found.append([count, *(x.tobytes() for x in arrays)])
    assert found[0] == found[1]


# ------------------------------------------------------------------------------
# Differential evolution: the slowest body of a box among known ones; compiled and plain.


SIZE = 32
LINE_BOX, OVAL = BOXES["line"], BOXES["ellipse"]


def first(box: Box, size: int = SIZE) -> Any:
    """A population within a box, and room for one more."""
    shares = np.random.default_rng(0).random((size + 1, AXES))
    return np.array(box.low) + shares * (np.array(box.high) - np.array(box.low))


def evolved(box: Box, points: Any, generations: int, seed: int = 1) -> tuple[int, Any, Any]:
    rows: Any = points.ravel().tolist()
    speeds: Any = [0.0] * len(points)
    population = Population(rows, speeds)
    best = evolve(box, population, len(points) - 1, generations, seed)
    return best, np.array(population.points).reshape(-1, AXES)[:-1], np.array(population.speeds)[:-1]


@pytest.mark.parametrize(("box", "way"), [(LINE_BOX, 1.0), (OVAL, -1.0)])
def test_the_slowest_of_a_dense_grid_is_found(box: Box, way: float) -> None:
    box = box._replace(way=way)
    best, points, speeds = evolved(box, first(box), 150)
    assert speeds[best] == speeds.min()
    assert speeds[best] == speed_at(box, points[best], 0)
    shares = np.random.default_rng(1).random((2000, AXES))
    shares = np.clip(1.5 * shares - 0.25, 0.0, 1.0)
    grid = np.array(box.low) + shares * (np.array(box.high) - np.array(box.low))
    assert speeds[best] <= min(speed_at(box, x, 0) for x in grid) + 1e-9


@pytest.mark.parametrize("generations", [0, 1, 5, 40])
def test_bodies_stay_within_their_bands_and_only_get_slower(generations: int) -> None:
    points = first(LINE_BOX)
    best, after, speeds = evolved(LINE_BOX, points, generations)
    assert np.all((after >= np.array(LINE_BOX.low)) & (after <= np.array(LINE_BOX.high)))
    begun = np.array([speed_at(LINE_BOX, x, 0) for x in points[:-1]])
    assert np.all(speeds <= begun)
    assert speeds[best] == speeds.min()
    assert np.array_equal(speeds, [speed_at(LINE_BOX, x, 0) for x in after])
    assert np.array_equal(after, points[:-1]) is (generations == 0)


def test_bodies_that_hop_are_passed_over() -> None:
    box = box_of(LOW, [4.0, *HIGH[1:]])
    points = first(box)
    points[0, 0] = 4.0
    assert math.isnan(speed_at(box, points[0], 0))
    best, after, speeds = evolved(box, points, 60)
    assert math.isfinite(speeds[best])
    assert not math.isnan(speeds.sum())
    best, _, speeds = evolved(box_of([3.5, *LOW[1:]], [4.0, *HIGH[1:]]), first(box) + 2.5, 3)
    assert np.all(np.isinf(speeds))
    assert len(after) == SIZE


@pytest.mark.parametrize("box", [LINE_BOX, OVAL, LINE_BOX._replace(way=-1.0)])
def test_compiled_and_plain_searches_have_the_same_bits(box: Box) -> None:
    found = []
    for kind in (compiled, plain):
        with kind() as solver:
            low, high, points, speeds = (
                np.array(box.low), np.array(box.high), first(box), np.zeros(SIZE + 1),
            )  # fmt: skip
            scene = solver.row(low), solver.row(high), *box[2:]
            best = solver.evolve(scene, (solver.row(points), solver.row(speeds)), SIZE, 40, 1)
            found.append((best, points.tobytes(), speeds.tobytes()))
    assert found[0] == found[1]
