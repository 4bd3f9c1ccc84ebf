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


def test_drives_beyond_one_harmonic_come_coarse_to_fine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their contact is solved cell by cell: a first picture waits for the widest lattice alone."""
    monkeypatch.setattr("vibro.explore.state.WIDTH", 90)
    monkeypatch.setattr("vibro.explore.state.HEIGHT", 70)
    file = tmp_path / "given.toml"
    file.write_text(GIVEN_DRIVES["samples"], encoding="utf-8")
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
