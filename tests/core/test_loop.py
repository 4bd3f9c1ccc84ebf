"""The doors as plain Python: what goes where, in SI units, and that every loop ends."""

from __future__ import annotations

import ast
import math
from array import array
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.followed import FLIGHTS, LAST, load_along, load_normal, newton, room, view
from helpers.scenes import at_load, loads_of
from helpers.solver_doors import plain

import vibro
import vibro.core
from vibro import Regime, Scene, Status
from vibro.core import loop
from vibro.core.bounces import Flights
from vibro.core.cells import largest
from vibro.core.codes import IRREGULAR, Mode, Model
from vibro.core.compiled import Doors
from vibro.core.contact import Steady
from vibro.core.drive import Loads, wave_loads
from vibro.core.history import Launch, Legs, State, arrival_cycles, course_of, sections_of
from vibro.core.hops import hopping
from vibro.core.loop import Cycle, arrivals, followed, history
from vibro.core.numbers import ELLIPSE as ELLIPSE_DRIVE
from vibro.core.numbers import EXTREME, HARMONICS, MIXES, ROOM
from vibro.core.numbers import LINE as LINE_DRIVE
from vibro.core.return_map import Hops
from vibro.core.scenes import Place, Scenes, point_at, seek
from vibro.core.slides import thresholds
from vibro.core.timeline import moment_of
from vibro.core.wave_cycle import wave_classes, wave_cycle
from vibro.core.waves import Mix, Waves, prepare_cells, read_harmonic, tabulate, with_bounds
from vibro.results.steady import RESULTS
from vibro.threads import Grid, Scratch

if TYPE_CHECKING:
    from collections.abc import Iterator


LOADS = [0.3, 0.9, 1.1, 1.36, 2.0, 2.9, 3.0, 3.6, 5.0, 9.0]
LINES = at_load(LOADS, 20.0, 0.74, 0.57)
INCLINES = Scene.allowing_infeasible(
    amplitude=[2e-3, 1e-3, 3e-3, 1e-3],
    frequency=[20.0, 30.0, 15.0, 15.0],
    drive_angle=[0.3, 0.2, 0.3, 0.3],
    static_friction=[0.5, 0.3, 0.5, 0.0],
    kinetic_friction=[0.4, 0.02, 0.6, 0.0],
    trough_angle=[-0.1, 0.2, 0.1, 0.1],
    gravity=9.81,
    restitution=0.0,
)
ELLIPSES = Scene(
    along_amplitude=[1e-3, 2e-4, 1e-3, 1.0, 0.0],
    normal_amplitude=[3e-4, 4e-4, 1.5e-3, 1e-9, 1e-4],
    normal_phase=[-1.0, 2.0, 0.5, 0.1, 0.0],
    frequency=25.0,
    static_friction=0.4,
    kinetic_friction=[0.3, 0.1, 0.3, 0.2, 0.3],
    trough_angle=[0.0, 0.05, -0.1, 0.0, 0.1],
    restitution=[0.0, 0.0, 0.3, 0.0, 0.0],
)
SCENES = pytest.mark.parametrize("scene", [LINES, INCLINES, ELLIPSES], ids=["lines", "inclines", "ellipses"])
TURN = 2.0 * math.pi


@pytest.fixture(autouse=True)
def solver() -> Iterator[Doors]:
    with plain() as doors:
        yield doors


class Answers:
    """Buffers of answers, filled with what no answer is."""

    def __init__(self, size: int) -> None:
        self.columns: dict[str, Any] = {r.name: np.full(size, 77).astype(r.dtype) for r in RESULTS}

    @property
    def buffers(self) -> tuple[Any, ...]:
        return tuple(memoryview(x) for x in self.columns.values())

    def row(self, i: int) -> dict[str, Any]:
        return {name: x[i].item() for name, x in self.columns.items()}


def solved(
    solver: Doors, scene: Scene, begin: int, end: int, *, classes: bool = False
) -> tuple[Answers, int]:
    grid = Grid(scene.arrays())
    answers = Answers(grid.size)
    count = solver.solve_contact(grid.scenes, grid.place(), answers.buffers, begin, end, classes)
    return answers, count


@SCENES
def test_a_range_leaves_other_cells_as_they_are(solver: Doors, scene: Scene) -> None:
    whole, _ = solved(solver, scene, 0, len(loads_of(scene)))
    for begin, end in ((0, 2), (1, 3), (2, 2)):
        part, _ = solved(solver, scene, begin, end)
        for i in range(len(loads_of(scene))):
            if begin <= i < end:
                assert part.row(i) == pytest.approx(whole.row(i), nan_ok=True, rel=0.0)
            else:
                assert set(part.row(i).values()) == {77}


def hopped(solver: Doors, scene: Scene, cells: list[int], begin: int, end: int) -> tuple[Answers, Any]:
    grid, scratch = Grid(scene.arrays()), Scratch()
    answers = Answers(grid.size)
    place, room = grid.place(), (scratch.flights, scratch.hops)
    solver.solve_hops(grid.scenes, place, answers.buffers, np.array(cells), *room, begin, end)
    return answers, (grid, place, room)


def test_averaged_and_unmodelled_motions_keep_their_codes(solver: Doors) -> None:
    scene = Scene(
        amplitude=[5e-3, 1e4], frequency=25.0, drive_angle=0.5, static_friction=0.5, kinetic_friction=0.3,
        restitution=0.9,
    )  # fmt: skip
    answers, (_, _, room) = hopped(solver, scene, [0, 1], 0, 2)
    averaged, thrown = answers.row(0), answers.row(1)
    assert averaged["status"] == Status.AVERAGED
    assert averaged["pattern_code"] == IRREGULAR
    assert averaged["model_code"] == Model.FLIGHT
    deviation = hopping(loads_of(scene)[0], 0.9, Flights(*room[0]), Hops(*room[1])).deviation
    assert deviation > 0.0
    assert averaged["mean_velocity_error"] == pytest.approx(5e-3 * 25.0 * deviation, rel=1e-13)
    assert thrown["status"] == Status.FLIGHT_NOT_MODELLED
    assert (thrown["pattern_code"], thrown["model_code"]) == (0, Model.NONE)
    assert math.isnan(thrown["mean_velocity"])


def test_solving_is_contact_then_hops_then_a_search() -> None:
    told: list[tuple[int, int]] = []
    cycle = vibro.solve(LINES, starts=16, progress=lambda done, size: told.append((done, size)))
    contact = vibro.solve(LINES, flight=False)
    hops = contact.status == Status.FLIGHT_NOT_MODELLED
    assert hops.tolist() == [load > 2.924 for load in LOADS]
    for name, ours in cycle.arrays().items():
        if name in ("share", "mean_velocity_over_starts"):
            continue
        np.testing.assert_array_equal(ours[~hops], getattr(contact, name)[~hops])
    assert (cycle.regime[hops] == Regime.HOPPING).all()
    assert np.isin(cycle.status[hops], (Status.OK, Status.AVERAGED)).all()
    assert np.isfinite(cycle.mean_velocity[hops]).all()
    assert np.isnan(contact.mean_velocity[hops]).all()
    assert (cycle.coexists[hops] >= 0).all()
    np.testing.assert_array_equal(cycle.share[~hops], 1.0)
    np.testing.assert_array_equal(cycle.mean_velocity_over_starts[~hops], contact.mean_velocity[~hops])
    assert np.isnan(contact.share).all()
    assert (cycle.share[hops] <= 1.0).all()
    assert told == [(10, 10), (4, 4)]
    np.testing.assert_array_equal(cycle.flight_fraction[~hops], 0.0)
    np.testing.assert_array_equal(cycle.impact_velocity[~hops], 0.0)
    np.testing.assert_array_equal(cycle.mean_velocity_error[~hops], 0.0)
    classes = vibro.solve(LINES, output="regimes")
    np.testing.assert_array_equal(classes.regime, cycle.regime)
    assert (classes.status[hops] == Status.FLIGHT_NOT_MODELLED).all()
    assert np.isnan(classes.mean_velocity[1:]).all()


# ------------------------------------------------------------------------------- limits and slopes


def test_all_doors_are_functions() -> None:
    assert len(loop.DOORS) == len(set(loop.DOORS))
    assert all(callable(door) for door in loop.DOORS)


# ------------------------------------------------------------------------------
# Doors of single motions: which scenes are followed, units, and moments of motions beside Newton's law.


PLACE = Place(view(np.zeros(10, np.int64)), view(np.zeros(1)), view(np.zeros(1, np.int64)))
LINE = {
    "first": 2e-3, "second": 0.35, "third": 1.0, "frequency": 15.0, "static_friction": 0.5,
    "kinetic_friction": 0.4, "trough_angle": 0.02, "gravity": 9.81, "restitution": 0.0,
}  # fmt: skip
ELLIPSE = LINE | {"second": 1.5e-3, "third": -0.7}


def _scenes(*cells: dict[str, float], ellipse: bool = False) -> Scenes:
    columns: Any = [view([cell[name] for cell in cells]) for name in LINE]
    nothing: Any = view([0.0]), view([0])
    grid: Any = (
        view([len(cells)]),
        view(np.ones(9, np.int64)),
        1,
        ELLIPSE_DRIVE if ellipse else LINE_DRIVE,
        0,
        0.0,
    )
    return Scenes(*columns, *nothing, *grid)


def _loads(scenes: Scenes) -> Loads:
    seek(scenes, PLACE, 0)
    return point_at(scenes, PLACE).loads


def _followed(scenes: Scenes) -> int:
    return followed(scenes, PLACE, 0)


def test_which_scenes_are_followed() -> None:
    assert _followed(_scenes(LINE)) == 1
    assert _followed(_scenes(ELLIPSE, ellipse=True)) == 1
    assert _followed(_scenes(LINE | {"second": 1.5, "trough_angle": 0.5})) == 1  # more than a right angle
    for kinetic, expected in ((0.5, 1), (math.nextafter(0.5, 1.0), 0), (0.0, 1), (1e-50, 1), (0.9e-50, 0)):
        assert _followed(_scenes(LINE | {"kinetic_friction": kinetic})) == expected
    for static, expected in ((EXTREME, 1), (1.01 * EXTREME, 0)):
        assert _followed(_scenes(LINE | {"static_friction": static})) == expected


@pytest.mark.parametrize(("throw", "expected"), [(1.0 - 1e-9, 1), (1.0 + 1e-9, 0)])
def test_throws_up_to_a_million_are_followed(throw: float, expected: int) -> None:
    amplitude = 1e6 * throw * 9.81 / (TURN * 15.0) ** 2 / math.sin(0.35) * math.cos(0.02)
    assert _followed(_scenes(LINE | {"first": amplitude})) == expected


@pytest.mark.parametrize(("factor", "expected"), [(1.01, 1), (0.99, 0)])
def test_weights_from_and_up_to_extremes_are_followed(factor: float, expected: int) -> None:
    heavy = 9.81 / (TURN * 15.0) ** 2 / EXTREME * factor
    assert _followed(_scenes(LINE | {"first": heavy, "trough_angle": 0.0})) == expected
    light = 9.81 / (TURN * 15.0) ** 2 * EXTREME / factor
    assert _followed(_scenes(LINE | {"first": light, "trough_angle": 0.0, "second": 0.0})) == expected


def test_arrivals_of_a_range_are_in_si_units() -> None:
    cells = [
        LINE, LINE | {"kinetic_friction": 0.6}, LINE | {"first": 6e-3, "frequency": 20.0},
        LINE | {"first": 6e-3, "restitution": 0.3},
    ]  # fmt: skip
    scenes = _scenes(*cells)
    length, advance = view([0.05, 0.05, 0.01, 0.02]), view(np.full(4, math.nan))
    times = np.full(4, -1.0)
    arrivals(scenes, PLACE, 0.3, 0.04, 0.0, 0.0, length, advance, view(times), FLIGHTS, 0, 3)
    assert times[3] == -1.0
    arrivals(scenes, PLACE, 0.3, 0.04, 0.0, 0.0, length, advance, view(times), FLIGHTS, 3, 4)
    assert math.isnan(times[1])
    for i in (0, 2, 3):
        cell = cells[i]
        loads, scale = _loads(_scenes(cell)), cell["first"]
        course = course_of(loads, cell["restitution"])
        velocity = 0.04 / (scale * TURN * cell["frequency"])
        cycles = arrival_cycles(
            course, sections_of(course, FLIGHTS), length[i] / scale, Launch(0.3, velocity, 0.0, 0.0), math.nan
        )
        assert times[i] == cycles / cell["frequency"]
        assert 0.0 < times[i] < 20.0
    steady = view([-1.0])
    back = _scenes(LINE | {"trough_angle": 0.3})
    arrivals(back, PLACE, 0.0, 0.0, 0.0, 0.0, view([1.0]), steady, view(times), FLIGHTS, 0, 1)
    assert times[0] == math.inf


def _history(scenes: Scenes, cycles: float, phase: float, velocity: float) -> tuple[int, Cycle, Legs]:
    legs = room(4000)
    cycle = Cycle(view([0]), view([0]), view([0.0]))
    number = history(scenes, PLACE, phase, velocity, 0.0, 0.0, cycles, legs, 4000, cycle, LAST, FLIGHTS)
    return number, cycle, legs


def test_a_history_is_that_of_the_first_cell() -> None:
    number, cycle, legs = _history(_scenes(LINE, LINE | {"first": 1.0}), 1e9, 0.4, 0.2)
    assert 0 < cycle.first[0] < number
    assert cycle.period[0] == 1
    last = number - 1
    assert legs.position[last] + legs.displacement[last] - legs.position[cycle.first[0]] == pytest.approx(
        cycle.advance[0], rel=1e-12
    )
    assert (legs.phase[0], legs.velocity[0]) == (0.4, 0.2)
    legs_small = room(3)
    assert history(_scenes(LINE), PLACE, 0.4, 0.2, 0.0, 0.0, 1e9, legs_small, 3, cycle, LAST, FLIGHTS) == -1


CASES: dict[str, Any] = {
    "line": (LINE | {"first": 0.9e-3}, False, 0.0),
    "line that hops": (LINE | {"first": 6e-3}, False, 0.0),
    "ellipse": (ELLIPSE | {"first": 1e-3, "second": 0.5e-3}, True, -0.7),
    "ellipse that bounces": (ELLIPSE | {"second": 2e-3, "restitution": 0.2, "trough_angle": 0.2}, True, -0.7),
}


@pytest.mark.parametrize("name", CASES)
def test_moments_are_those_of_newtons_law(name: str) -> None:
    cell, is_ellipse, lead = CASES[name]
    scenes = _scenes(cell, ellipse=is_ellipse)
    number, _, legs = _history(scenes, 12.0, 0.0, 0.3)
    loads, count = _loads(scenes), 7 * number
    row = np.repeat(np.arange(number), 7)
    shares = np.tile([0.0, 0.11, 0.35, 0.5, 0.77, 0.93, 1.0], number)
    since = shares * np.asarray(legs.length)[row]
    seen = set()
    for i in range(count):
        leg, s = int(row[i]), float(since[i])
        found = moment_of(loads, legs, leg, s, 0.0)
        mode, p = Mode(legs.mode[leg]), legs.phase[leg] + s
        seen.add(mode)
        rate = legs.rate[leg] / loads.weight_normal
        path, velocity, height, _ = newton(
            loads, mode, State(0, legs.phase[leg], int(mode), 0.0, legs.velocity[leg], rate), s
        ) if s else (0.0, legs.velocity[leg], 0.0, 0.0)  # fmt: skip
        rests, flies = mode == Mode.REST, mode == Mode.FLIGHT
        along, normal = float(load_along(loads, p)), max(float(load_normal(loads, p)), 0.0)
        friction = {Mode.FORWARD: -0.4, Mode.BACK: 0.4}.get(mode, 0.0) * normal
        assert found.sine == pytest.approx(math.sin(p), abs=1e-13)
        assert found.trough_normal == pytest.approx(loads.drive_normal * math.sin(p), abs=1e-13)
        assert found.trough_along == pytest.approx(loads.drive_tangential * math.sin(p - lead), abs=1e-13)
        assert found.inertial == pytest.approx(along, abs=1e-13)
        assert found.normal == pytest.approx(0.0 if flies else normal, abs=1e-13)
        assert found.path == pytest.approx(0.0 if rests else path, abs=1e-12)
        assert found.velocity == pytest.approx(0.0 if rests else velocity, abs=1e-12)
        assert found.acceleration == pytest.approx(0.0 if rests else along + friction, abs=1e-12)
        assert found.gap == pytest.approx(height if flies and shares[i] < 1.0 else 0.0, abs=1e-12)
        assert found.gap >= 0.0
        if shares[i] == 1.0:
            assert found.path == legs.displacement[leg]
            assert found.velocity == legs.end_velocity[leg]
    assert len(seen) >= 3
    assert (Mode.FLIGHT in seen) == ("hops" in name or "bounces" in name)


def test_a_long_rest_is_as_exact_as_a_short_one() -> None:
    scenes = _scenes(LINE | {"first": 2e-4})
    number, cycle, legs = _history(scenes, 1e9, 0.0, 0.0)
    assert (number, cycle.period[0], legs.length[0]) == (1, 0, math.inf)
    turns = 2.0**20
    loads = _loads(scenes)
    short, long = (moment_of(loads, legs, 0, since, 0.0) for since in (1.0, 1.0 + turns * TURN))
    np.testing.assert_allclose(short, long, atol=2e-9)
    assert short.sine == pytest.approx(math.sin(1.0))


# ------------------------------------------------------------------------------
# Every loop of the solver ends: it runs over a range that is known before, or over what is at hand.


FILES = sorted(Path(vibro.core.__path__[0]).glob("*.py"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_solver_has_no_loop_without_a_bound(path: Path) -> None:
    """``while`` may go on for ever: use ``for`` over a range, and say what follows at its end."""
    tree = ast.parse(path.read_text("utf-8"))
    assert [node.lineno for node in ast.walk(tree) if isinstance(node, ast.While)] == []


def two_harmonics(size: float) -> Waves:
    number, mark = array("d", bytes(8 * (ROOM * 4 + 32))), array("q", bytes(8 * 2 * MIXES))
    waves = Waves(HARMONICS, 2, memoryview(number), memoryview(mark), 0.0, 0.0, 0.0)
    prepare_cells(2, waves.number)
    for normal in (False, True):
        for order, share in ((1, size), (2, 0.3 * size)):
            read_harmonic(waves, normal, order, share, 0.4 * order)
    tabulate(waves)
    return with_bounds(waves)


def test_a_load_whose_square_is_no_double_has_no_bound() -> None:
    assert largest(two_harmonics(1.0), Mix(0.0, 1.0, 1e150)) < math.inf
    assert largest(two_harmonics(1.0), Mix(0.0, 1.0, 1e155)) == math.inf


def test_a_cycle_under_loads_without_a_bound_is_unresolved() -> None:
    loads = wave_loads(two_harmonics(1.0), 1.0, 2.0, 0.0, 1e155, 0.5)
    at = thresholds(loads)
    cycle = wave_cycle(loads, at, False)
    assert isinstance(cycle, Steady)
    assert (cycle.regime, cycle.status) == (Regime.UNDEFINED, Status.UNRESOLVED)
    assert wave_classes(loads, at).pattern == 0
