"""The numbers that the page makes itself: every figure of ``vibro solve --all``, as text."""

from __future__ import annotations

import random
import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.explored_scenes import FEEDER
from helpers.machine_files import KINDS
from helpers.machine_files import SCENE as MACHINE_SCENE
from helpers.page_states import cells, state_of
from helpers.whole_page import in_modules

from vibro import Status
from vibro.answers.answer import brief, shown, uncertain
from vibro.answers.scene import OneScene, scene_answer
from vibro.designs.sensitivities import changed_cycles
from vibro.explore.scenes import scene_data
from vibro.quantities import QUANTITIES
from vibro.sweeps.grid import Grid
from vibro.sweeps.machines import points_of
from vibro.sweeps.run import sweep_blocks
from vibro.sweeps.whole import request_of_call

if TYPE_CHECKING:
    from pathlib import Path

_ERRORS = 4.0  # standard errors that means may be apart
_RUN = """
export const run = ({ data, engine, answerOf }, states) => states.map((one) => answerOf(data, engine, one));
"""


@pytest.fixture(scope="module")
def answers() -> dict[str, Any]:
    """Return what the page answers about each scene."""
    asked = cells()
    found = in_modules(_RUN, [state_of(grid) for grid in asked.values()])
    return dict(zip(asked, found, strict=True))


def _known(grid: Grid) -> tuple[OneScene, dict[str, Any]]:
    (block,) = sweep_blocks(grid)
    one = OneScene(block)
    assumes = one.given["restitution"] == 0.0
    answer = scene_answer(one, grid, {}, {}, every=True, assumes_plastic=assumes)
    return one, {
        "facts": [{"label": fact.label, "text": fact.text} for fact in answer.facts],
        "tables": [
            {"title": table.title, "columns": head, "rows": rows}
            for table in answer.tables
            for head, *rows in [table.texts]
        ],
        "notes": [*answer.notes],
    }


def _masked(value: Any) -> str:
    """Write an answer without its numbers."""
    return re.sub(r"-?[0-9][0-9.e+]*", "#", str(value))


def test_scenes_are_of_all_kinds(answers: dict[str, Any]) -> None:
    ones = [_known(grid)[0] for grid in cells().values()]
    assert {one.status for one in ones} >= {Status.OK, Status.AVERAGED, Status.RUNAWAY}
    assert len({one.regime for one in ones}) == 4
    assert answers["nut"]["title"] == "forward-slip, 16.2635 mm/s"


@each(("name", "grid"), [*cells().items()])
def test_every_figure_is_that_of_vibro_solve(name: str, grid: Grid, answers: dict[str, Any]) -> None:
    one, known = _known(grid)
    found = {key: answers[name][key] for key in known}
    # sines of JavaScript differ by roundings, which irregular motion amplifies: its means differ
    _, changed = changed_cycles(one.scene)
    irregular = [n for n, status in enumerate(changed.status[1:]) if status == Status.AVERAGED]
    for answer in (found, known):
        rows = answer["tables"][1]["rows"]
        answer["tables"][1]["rows"] = [row[:1] if n in irregular else row for n, row in enumerate(rows)]
    if one.status is not Status.AVERAGED:
        assert found == known
        return
    mean, error = map(float, re.findall(r"[0-9.]+", answers[name]["speedText"])[:2])
    assert abs(mean - one.speed) < _ERRORS * (error + one.error)
    assert _masked(found["facts"]) == _masked(known["facts"])
    assert _masked(found["notes"]) == _masked(known["notes"])
    assert found["tables"][0] == known["tables"][0]


def test_machines_settle_and_are_told_as_by_vibro_solve(tmp_path: Path) -> None:
    loads: dict[str, dict[str, Any]] = {"": {}, "filled": {"filling_kg": 3}, "heavy": {"filling_kg": 25}}
    loads["half"] = {"setting_percent": 50, "filling_kg": 1}
    grids, doubts, states = {}, {}, []
    for kind, text in {**KINDS, "packs": FEEDER}.items():
        scene = "" if kind == "packs" else MACHINE_SCENE + "trough_length_mm = 400\n"
        file = tmp_path / f"{kind}.toml"
        file.write_text(scene + text, encoding="utf-8")
        for name, load in loads.items():
            if kind in ("crank", "unbalance", "exciter", "rod") and name == "half":
                continue
            request = request_of_call(file, load)
            point = request.fixed | {name: request.own[name] for name in request.varying}
            fixed = {name: point[name] for name in QUANTITIES if name in point}
            grid = Grid({}, fixed, request.length, arrivals=True, machine=request.machine)
            if np.isnan(grid.values()["amplitude"]):
                continue
            grids[f"{kind} {name}"] = grid
            doubts[f"{kind} {name}"] = request.doubts()
            states.append(state_of(grid, machine=scene_data(request)["machine"]))
    assert len(grids) > 15
    found = in_modules(_RUN, states)
    wrong = []
    assert any(answer["warnings"] for answer in found)
    for (name, grid), answer in zip(grids.items(), found, strict=True):
        _, known = _known(grid)
        assert grid.machine is not None
        remarks = points_of(grid.machine, grid.values()).remarks()
        known["warnings"] = [*doubts[name], *remarks]
        answer = {key: answer[key] for key in known}
        if answer != known:
            wrong.append((name, answer, known))
    assert not wrong, wrong[:1]


_SLIPS: list[dict[str, Any]] = [
    {}, {"amplitude_mm": 90}, {"amplitude_mm": 1000}, {"amplitude_mm": 0.001}, {"frequency_hz": 1500},
    {"static_friction": 74, "kinetic_friction": 57}, {"drive_angle_deg": 0.5}, {"trough_length_mm": 1.2},
    {"gravity_m_s2": 981}, {"gravity_m_s2": 0.1, "amplitude_mm": 1},
]  # fmt: skip
_MACHINE_SLIPS: list[dict[str, Any]] = [
    {}, {"filling_kg": 500}, {"voltage_percent": 0.9}, {"natural_hz": 3000}, {"static_friction": 2.1},
    {"frequency_hz": 55.6},
]  # fmt: skip


def test_values_that_are_unusual_are_questioned_as_by_vibro_solve(tmp_path: Path) -> None:
    (feeder := tmp_path / "feeder.toml").write_text(FEEDER.replace('"90:110"', "100"), encoding="utf-8")
    body = {"frequency_hz": 15, "static_friction": 0.74, "kinetic_friction": 0.57, "trough_length_mm": 600}
    line = {**body, "amplitude_mm": 1, "drive_angle_deg": 20}
    ellipse = {**body, "along_amplitude_mm": 301, "normal_amplitude_mm": 0.3, "normal_phase_deg": 0}
    requests = [request_of_call(None, {**line, **own}) for own in _SLIPS] + [request_of_call(None, ellipse)]
    requests += [request_of_call(feeder, {"frequency_hz": 50, **own}) for own in _MACHINE_SLIPS]
    grids = [request.grid() for request in requests]
    machines = [scene_data(request)["machine"] for request in requests]
    found = in_modules(_RUN, [state_of(g, machine=own) for g, own in zip(grids, machines, strict=True)])
    seen = []
    for request, grid, answer in zip(requests, grids, found, strict=True):
        remarks = [] if grid.machine is None else points_of(grid.machine, grid.values()).remarks()
        assert answer["warnings"] == [*request.doubts(), *remarks]
        seen += request.doubts()
    for what in ("acceleration", "amplitude", "static friction", "trough length", "filling"):
        assert any(doubt.startswith(f"{what} = ") for doubt in seen), what


def test_a_machine_whose_masses_strike_has_no_numbers(tmp_path: Path) -> None:
    file = tmp_path / "magnet.toml"
    file.write_text(MACHINE_SCENE + KINDS["magnet"] + "gap_mm = 0.01\n", encoding="utf-8")
    request = request_of_call(file, {"filling_kg": 1, "frequency_hz": 50})
    grid = Grid({}, request.fixed, 400.0, machine=request.machine)
    state = state_of(grid, machine=scene_data(request)["machine"])
    (found,) = in_modules(_RUN, [state])
    texts = {fact["label"]: fact["text"] for fact in found["facts"]}
    assert found["title"] == "unknown"
    assert (texts["none"], texts["traverse time"], texts["amplitude"][:7]) == ("unknown",) * 2 + ("unknown",)
    assert found["tables"] == []
    assert found["notes"] == [Status.INFEASIBLE.message]


_WRITTEN = "export const run = (page, asked) => asked.map(([name, ...values]) => page[name](...values));"


def test_numbers_are_written_as_in_python() -> None:
    draw = random.Random(7)
    values = [0.0, 0.5, 2.5, 1.0625, 0.0009765625, 99995.0, 9.9995, 1e-4, 1e5, 123456.5, 1e22, 1.5e-7]
    values += [draw.choice((-1, 1)) * draw.uniform(1, 10) * 10 ** draw.randint(-9, 9) for _ in range(150)]
    values += [draw.randint(1, 9999) / 2 ** draw.randint(1, 12) for _ in range(150)]  # with ties
    errors = [10 ** draw.uniform(-5, 2) for _ in values]
    asked = [["shownText", value, digits] for value in values for digits in (3, 4, 6, 10, 15)]
    asked += [["uncertainText", value, error] for value, error in zip(values, errors, strict=True)]
    asked += [["briefText", value] for value in values]
    known = [shown(value, digits) for value in values for digits in (3, 4, 6, 10, 15)]
    known += [uncertain(value, error) for value, error in zip(values, errors, strict=True)]
    known += [brief(value) for value in values]
    found = in_modules(_WRITTEN, asked)
    wrong = [
        (ask, ours, theirs) for ask, ours, theirs in zip(asked, found, known, strict=True) if ours != theirs
    ]
    assert not wrong, wrong[:5]
