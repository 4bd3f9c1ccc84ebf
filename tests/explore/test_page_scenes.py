"""Scenes in the units of users, as the page hands them to its solver: motions, friction, machines."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.frozen_questions import Draws, batches
from helpers.whole_page import in_modules

import vibro
from vibro.explore.scenes import pieces_data
from vibro.quantities import QUANTITIES, kinetic_friction, scene_fields

RUN = """
export function run({ data, engine }, asked) {
  return asked.map((scene) => {
    const cycle = engine.solve(engine.gridOf(driveOf(data, scene)));
    return [cycle.regime[0], cycle.status[0], cycle.mean_velocity[0], cycle.peak_velocity[0]];
  });
}
"""
RESULTS = ("regime", "status", "mean_velocity", "peak_velocity")


def assert_same(found: list[Any], scene: vibro.Scene) -> None:
    cycle = vibro.solve(scene)
    for name, x in zip(RESULTS, found, strict=True):
        expected = float(getattr(cycle, name))
        bound = 1e-9 * abs(expected) + 1e-9 * float(scene.scale) * float(scene.frequency)
        if name == "mean_velocity" and cycle.status == vibro.Status.AVERAGED:
            bound = 8.0 * float(cycle.mean_velocity_error)
        if name == "peak_velocity" and cycle.status == vibro.Status.AVERAGED:
            continue
        assert float(x) == pytest.approx(expected, abs=bound, rel=0.0, nan_ok=True), (name, scene)


@pytest.mark.parametrize("name", ["steps", "samples"])
def test_motions_of_pieces_keep_their_scale(name: str) -> None:
    for _, batch in zip(range(2), batches(name), strict=False):
        motion, count = batch["motion"], batch["frequency"].size
        asked, expected = [], []
        for i in range(count):
            values = {
                key: float(QUANTITIES[key].from_si(x[i])) for key, x in batch.items() if key in QUANTITIES
            }
            values["kinetic_friction"] = min(values["kinetic_friction"], values["static_friction"])
            asked.append({"values": values, "given": {"kind": "pieces", "motion": pieces_data(motion)}})
            expected.append(vibro.Scene.allowing_infeasible(**scene_fields(values | {"motion": motion})))
        for scene, one in zip(expected, in_modules(RUN, asked), strict=True):
            assert_same(one, scene)


def test_friction_by_its_ratio_is_spelled_as_in_python() -> None:
    draw = Draws("ratios of pages")
    pairs = np.stack([draw(0.0, 1.0, 2000).round(3), draw(0.01, 2.0, 2000).round(2)], axis=1)
    run = "export const run = (_, asked) => asked.map((pair) => spelledFriction(...pair));"
    assert in_modules(run, pairs.tolist()) == kinetic_friction(pairs[:, 0], pairs[:, 1]).tolist()


MACHINES = """
export const run = ({ data, engine }, asked) => asked.map((one) => operatingOf(data, engine, one));
"""
NAMES = (
    "amplitude", "amplitude_empty", "amplitude_low", "amplitude_high", "phase", "relative_amplitude",
    "frequency_ratio", "filled_frequency_ratio", "added_mass_share", "added_damping_share", "second_harmonic",
    "number", "status", "strikes",
)  # fmt: skip


def test_machines_settle_where_python_says() -> None:
    asked: list[Any] = []
    expected: list[tuple[vibro.Machine, dict[str, Any]]] = []
    for batch in batches("machines"):
        machine = batch.pop("machine")
        fields = {name: getattr(machine, name) for name in machine.__dataclass_fields__} | {"share": None}
        for i in range(batch["frequency"].size):
            one = {key: float(x[i]) for key, x in batch.items()} | {"voltage": 0.9}
            one["kinetic_friction"] = min(one["kinetic_friction"], one["static_friction"])
            values = {key: float(QUANTITIES[key].from_si(x)) for key, x in one.items()}
            asked.append({"values": values, "machine": fields})
            expected.append((machine, {key: float(QUANTITIES[key].to_si(x)) for key, x in values.items()}))
    found = in_modules(MACHINES, asked)
    wrong = []
    for one, (machine, given) in zip(found, expected, strict=True):
        point = vibro.operate(machine, **given, allow_strikes=True)
        for name in NAMES:
            x, y = float(one[name][0]), float(getattr(point, name))
            size = float(point.amplitude_empty) if "amplitude" in name else 1.0
            if not (x == y or abs(x - y) <= 1e-9 * (abs(y) + size) or (math.isnan(x) and math.isnan(y))):
                wrong.append((name, x, y, machine.kind, given))
    assert not wrong, (len(wrong), wrong[:5])
