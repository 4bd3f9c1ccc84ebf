"""The cells of a map, coarse to fine: what is told to be exact is what ``vibro.solve`` gives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.packed import GIVEN_DRIVES
from numpy.typing import NDArray

import vibro
from vibro.axes import Axis
from vibro.explore.levels import LOADS, MapCells, Shown
from vibro.explore.state import initial_state, read_state
from vibro.results.steady import RESULTS, SteadyCycle
from vibro.sweeps.grid import Grid, scene_of
from vibro.sweeps.whole import request_of_call

NUMBERS = [result.name for result in RESULTS if result.is_number]
LINE = {"x": "frequency_hz", "y": "amplitude_mm"}
STEEP = {"x": "drive_angle_deg", "y": "static_friction", "amplitude_mm": "1.5", "frequency_hz": "30"}


def grid_of(query: Mapping[str, str], shape: tuple[int, int] = (37, 50)) -> Grid:
    """Make a grid of a state, of fewer cells."""
    grid = read_state(query, initial_state()).grid()
    axes = [
        Axis(axis.name, np.linspace(axis.values[0], axis.values[-1], count), "linear")
        for axis, count in zip(grid.axes.values(), shape, strict=True)
    ]
    return replace(grid, axes={axis.name: axis for axis in axes})


def same(a: SteadyCycle, b: SteadyCycle, where: NDArray[np.bool_]) -> bool:
    """Whether cells are the same bit for bit."""
    pairs = [(getattr(a, r.name)[where], getattr(b, r.name)[where]) for r in RESULTS]
    texts = np.array_equal(a.pattern[where], b.pattern[where])
    return texts and all(np.array_equal(x, y, equal_nan=x.dtype.kind == "f") for x, y in pairs)


def followed(cells: MapCells) -> list[Shown]:
    """Work on a map until all is done, and return all that was to be seen."""
    seen = [cells.shown]
    while not cells.shown.is_done:
        cells.advance(1e-9)
        seen.append(cells.shown)
        assert len(seen) < 1000
    return seen


@pytest.mark.parametrize(
    "query",
    [
        LINE,
        LINE | {"trough_angle_deg": "-5", "drive_angle_deg": "40"},
        {**STEEP},
        {**STEEP, "follow": "0"},  # with combinations that cannot be
        {"x": "trough_angle_deg", "y": "restitution", "amplitude_mm": "2"},
        {"drive": "ellipse"},
        {"drive": "ellipse", "along_amplitude_mm": "4", "frequency_hz": "40", "y": "frequency_hz"},
        {"drive": "harmonics"},
    ],
    ids=lambda query: "-".join(query.values()),
)
def test_what_is_exact_is_what_solve_gives(query: dict[str, str]) -> None:
    grid = grid_of(query, (13, 17) if "restitution" in query.values() else (37, 50))
    wanted = vibro.solve(scene_of(grid.values()))
    seen = followed(MapCells(grid))
    for shown in seen:
        assert same(shown.cycle, wanted, shown.exact)
        assert (shown.known >= shown.exact).all()
        assert shown.is_done or not shown.exact.all() or shown.text
    assert seen[-1].exact.all()
    assert seen[-1].text == ""
    assert [shown.share for shown in seen] == sorted(shown.share for shown in seen)


def test_bouncing_bodies_come_coarse_to_fine() -> None:
    grid = grid_of(STEEP | {"restitution": "0.4"}, (9, 11))
    wanted = vibro.solve(scene_of(grid.values()))
    assert wanted.long_patterns
    seen = followed(MapCells(grid))
    assert not seen[0].known.all()
    assert all(same(shown.cycle, wanted, shown.exact) for shown in seen)
    assert seen[-1].exact.all()


def test_contact_is_exact_at_once() -> None:
    for query in (LINE, STEEP, {"drive": "ellipse"}):
        grid = grid_of(query)
        contact = vibro.solve(scene_of(grid.values()), flight=False)
        shown = MapCells(grid).shown
        answered = np.isfinite(contact.mean_velocity)
        assert answered.any()
        assert shown.exact[answered].all()
        assert same(shown.cycle, contact, answered)


@pytest.mark.parametrize("restitution", ["0", "0.3"])
def test_over_amplitude_and_frequency_a_preview_has_the_nearest_load(restitution: str) -> None:
    grid = grid_of(LINE | {"restitution": restitution})
    cells = MapCells(grid)
    if float(restitution):
        assert not cells.shown.known.all()  # of those that hop nothing is known yet
        cells.advance(1e-9)
    shown = cells.shown
    assert shown.known.all()
    assert not shown.is_done
    scene = scene_of(grid.values())
    hops = np.argwhere(~shown.exact)
    assert len(hops) > 100
    load = np.broadcast_to(scene.load, grid.shape)
    where = load[~shown.exact]
    loads = np.geomspace(where.min(), where.max(), LOADS)
    assert scene.amplitude is not None
    amplitude, frequency = (np.broadcast_to(x, grid.shape) for x in (scene.amplitude, scene.frequency))
    for i, j in hops[:: len(hops) // 40]:
        # A body of such a load, at the frequency of the cell; lengths go with the amplitude.
        found = [
            k
            for k in range(LOADS)
            if abs(loads[k] / load[i, j] - 1.0) < 0.15 and k % (1 if restitution == "0" else 8) == 0
        ]
        best = min(found, key=lambda k: abs(np.log(loads[k] / load[i, j])))
        near = [k for k in found if abs(k - best) <= 8]
        at = amplitude[i, j] * loads[near] / load[i, j]
        body = vibro.solve(
            vibro.Scene(
                amplitude=at,
                frequency=frequency[i, j],
                drive_angle=scene.drive_angle,
                static_friction=scene.static_friction,
                kinetic_friction=scene.kinetic_friction,
                restitution=float(restitution),
            )
        )
        told = shown.cycle.mean_velocity[i, j]
        scaled = body.mean_velocity * amplitude[i, j] / at
        error = shown.cycle.mean_velocity_error[i, j] + body.mean_velocity_error
        assert np.min(np.abs(scaled - told) - 5.0 * error) < 1e-9 * abs(told), (i, j)


def test_a_line_of_loads_comes_before_exact_cells() -> None:
    grid = grid_of(LINE | {"restitution": "0.3"})
    cells = MapCells(grid)
    load = np.broadcast_to(scene_of(grid.values()).load, grid.shape)[~cells.shown.exact]
    texts: list[str] = []
    while cells.shown.share == 0.0 and len(texts) < 100:
        cells.advance(1e-9)
        texts.append(cells.shown.text)
    assert "a preview" in texts[0]
    told = next(text for text in texts if "within" in text)
    spread = float(told.split("within ")[1].split()[0])
    half_a_step = 0.5 * np.log(load.max() / load.min()) / (LOADS - 1)
    assert 0.0 <= spread - 100.0 * np.expm1(half_a_step) < 0.01 + 1e-9  # [%], rounded up


def test_cells_between_show_a_solved_neighbour() -> None:
    grid = grid_of(STEEP)
    cells = MapCells(grid)
    assert not cells.shown.known.all()
    cells.advance(1e-9)
    shown = cells.shown
    borrowed = shown.known & ~shown.exact
    assert borrowed.any()
    solved = {row.tobytes() for row in _rows(shown.cycle, shown.exact)}
    assert {row.tobytes() for row in _rows(shown.cycle, borrowed)} <= solved


def _rows(cycle: SteadyCycle, where: NDArray[np.bool_]) -> NDArray[np.float64]:
    return np.column_stack([getattr(cycle, name)[where] for name in NUMBERS])


def test_ellipses_have_critical_loads_after_a_while_and_harmonics_never() -> None:
    ellipse = MapCells(grid_of({"drive": "ellipse"}))
    assert ellipse.shown.limits is None
    assert "boundaries" in ellipse.shown.text
    grid = grid_of({"drive": "ellipse"})
    wanted = vibro.critical_loads(scene_of(grid.values()))
    found = followed(ellipse)[-1].limits
    assert found is not None
    assert all(np.array_equal(a, b) for a, b in zip(found, wanted, strict=True))
    phases = grid_of({"drive": "ellipse", "y": "frequency_hz"})
    alike = followed(MapCells(phases))[-1].limits
    assert alike is not None
    assert alike.hop.shape == (1, 50)
    assert followed(MapCells(grid_of({"drive": "harmonics"})))[-1].limits is None
    assert MapCells(grid_of({})).shown.limits is not None


@pytest.mark.parametrize("name", ["third harmonic", "samples", "displacements"])
def test_drives_beyond_one_harmonic_come_coarse_to_fine(name: str, tmp_path: Path) -> None:
    """Their contact is solved cell by cell: a first picture waits for the widest lattice alone."""
    file = tmp_path / "given.toml"
    file.write_text(GIVEN_DRIVES[name], encoding="utf-8")
    grid = initial_state(request_of_call(file, {})).grid()
    cells = MapCells(grid, patience=0.0)
    first = cells.shown
    assert first.known.all()
    assert first.exact[::16, ::16].all()
    assert first.exact.sum() == first.exact[::16, ::16].size
    assert first.text.endswith("% exact, the rest from neighbours or to come")
    assert "hopping" not in first.text
    wanted = vibro.solve(scene_of(grid.values()))
    seen = followed(cells)
    for shown in seen[:: len(seen) // 3]:
        assert same(shown.cycle, wanted, shown.exact)
    assert seen[-1].exact.all()
    assert MapCells(grid).shown.is_done  # with all the patience


def test_what_was_seen_stays_as_it_was() -> None:
    cells = MapCells(grid_of(STEEP))
    first = cells.shown
    exact, speed = first.exact.copy(), first.cycle.mean_velocity.copy()
    followed(cells)
    assert np.array_equal(first.exact, exact)
    assert np.array_equal(first.cycle.mean_velocity, speed, equal_nan=True)


def test_loads_that_took_long_are_left_for_later() -> None:
    grid = grid_of(LINE)
    quick = MapCells(grid)
    assert quick.shown.known.all()
    assert quick.took is not None
    slow = MapCells(grid, patience=0.05, expected=0.06)
    assert slow.took is None, slow.took
    assert np.array_equal(slow.shown.known, slow.shown.exact)
    seen = followed(slow)
    assert seen[1].known.all()
    assert MapCells(grid_of(STEEP)).took is None
