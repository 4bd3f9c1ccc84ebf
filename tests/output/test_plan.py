"""Plans: what a manifest says is read again, whatever was changed is noticed, and differences are named."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from unittest import mock

import numpy as np
import pytest
from helpers.cases import each
from helpers.plans import plan_of, swept
from hypothesis import given
from hypothesis import strategies as st

from vibro.axes import Axis
from vibro.errors import FileError, InputError
from vibro.output.plan import ROW_GROUP, Plan, read_plan, usual_shard_cells, versions
from vibro.output.shard_folder import MANIFEST, MOST_SHARDS, SUCCESS
from vibro.sweeps.columns import Table, chosen, columns_of
from vibro.sweeps.grid import Grid

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vibro.sweeps.whole import Sweep

ARGV = ["vibro", "map", "nut.toml"]
NOTICED = r"damaged|is an unknown format|is no manifest"
ELLIPSE: dict[str, Any] = {"along_amplitude_mm": 1, "normal_amplitude_mm": "0.1,0.2", "normal_phase_deg": 40}


def nut(**changed: Any) -> Sweep:
    """Sweep something that has numbers which are not short, in tables and in the scene."""
    return swept(**{"amplitude_mm": "0.1:3:7:log", "frequency_hz": [10, 15.1], **changed})


def bits(values: Any) -> list[int]:
    whole: list[int] = np.asarray(values, np.float64).view(np.int64).tolist()
    return whole


def check_same(again: Plan, plan: Plan) -> None:
    """Compare plans bit for bit."""
    assert again.fingerprint == plan.fingerprint
    assert again.differences(plan) == plan.differences(again) == []
    assert list(again.grid.axes) == list(plan.grid.axes)
    for name, axis in plan.grid.axes.items():
        assert bits(again.grid.axes[name].values) == bits(axis.values)
        assert again.grid.axes[name].spacing == axis.spacing
    assert list(again.grid.fixed) == list(plan.grid.fixed)
    assert bits(list(again.grid.fixed.values())) == bits(list(plan.grid.fixed.values()))
    for name in ("length", "output", "flight", "coexistence"):
        assert getattr(again.grid, name) == getattr(plan.grid, name)
    assert [c.name for c in again.table.columns] == [c.name for c in plan.table.columns]
    assert (again.table.digits, dict(again.table.part)) == (plan.table.digits, dict(plan.table.part))
    for name in ("shards", "shard_cells", "name", "own"):
        assert getattr(again, name) == getattr(plan, name)


@each(
    "plan",
    [
        plan_of(nut()),
        plan_of(nut(trough_length_mm=600.1, restitution=0.3, trough_angle_deg=-2.5), 7, digits=4),
        plan_of(nut(friction_ratio="0.5:1.2:4"), columns=["regime", "stroke_mm", "friction_ratio"]),
        plan_of(nut(friction_ratio=0.77), part={"pitch_mm": 25.1, "mass_kg": 0.012}),
        plan_of(nut(), part={"pitch_mm": 25.1}, columns=["parts_per_min"]),
        plan_of(swept("regimes", amplitude_mm="1,2")),
        plan_of(swept(amplitude_mm="1,2", flight=False)),
        plan_of(swept(amplitude_mm="1,2", coexistence=True)),
        plan_of(swept(**ELLIPSE)),
        plan_of(swept(**ELLIPSE, along_amplitude_2_mm="0:0.2:3", along_phase_2_deg=30)),
        plan_of(swept()),
    ],
)
def test_a_manifest_is_read_again_as_it_was_written(plan: Plan) -> None:
    text = plan.manifest(ARGV)
    check_same(read_plan(text, "m"), plan)
    assert read_plan(text, "m").manifest(ARGV) == text
    content = json.loads(text)
    assert content["argv"] == ARGV
    assert content["fingerprint"] == plan.fingerprint
    assert content["cells"] == plan.grid.size
    assert content["row_group_cells"] == ROW_GROUP


def grid_of(axes: dict[str, list[float]], **fixed: float) -> Grid:
    """Make a grid of any numbers at all: nothing is solved."""
    others = {"frequency": 15.0, "static_friction": 0.74, "kinetic_friction": 0.57, "gravity": 9.81}
    made = {name: Axis(name, np.array(values), "list") for name, values in axes.items()}
    return Grid(made, {name: x for name, x in (others | fixed).items() if name not in axes}, None)


def whole(grid: Grid, shard_cells: int | None = None) -> Plan:
    return Plan.of(grid, Table(columns_of(grid.axes)), shard_cells, "", {})


NUMBERS = st.floats(1e-300, 1e300)
AXES = st.lists(NUMBERS, min_size=1, max_size=5, unique=True).map(sorted)


@given(AXES, AXES, NUMBERS, st.integers(1, 30))
def test_any_numbers_are_read_again_bit_for_bit(
    amplitude: list[float], friction: list[float], angle: float, shard_cells: int
) -> None:
    grid = grid_of({"amplitude": amplitude, "static_friction": friction}, drive_angle=angle)
    plan = whole(grid, shard_cells)
    check_same(read_plan(plan.manifest(ARGV), "m"), plan)


FEW = st.lists(st.sampled_from([1.0, 1.5, np.nextafter(1.5, 2.0), 2.0]), min_size=1, unique=True).map(sorted)
PLANS = st.builds(
    lambda amplitude, angle, shard_cells, names: Plan.of(
        grid_of({"amplitude": amplitude}, drive_angle=angle),
        Table(chosen(names, columns_of())), shard_cells, "", {},
    ),
    FEW, st.sampled_from([20.0, 30.0]), st.sampled_from([2, 3]),
    st.permutations(["regime", "status", "amplitude_mm"]),
)  # fmt: skip


@given(PLANS, PLANS)
def test_fingerprints_differ_where_something_is_named_alone(one: Plan, other: Plan) -> None:
    assert (one.fingerprint == other.fingerprint) == (not one.differences(other))
    assert bool(one.differences(other)) == bool(other.differences(one))


def paths(content: Any, *before: str | int) -> Iterator[tuple[str | int, ...]]:
    """Yield where the values of a manifest are, lists and mappings first."""
    if before:
        yield before
    if isinstance(content, dict | list):
        for key, value in content.items() if isinstance(content, dict) else enumerate(content):
            yield from paths(value, *before, key)


def others(value: Any) -> list[Any]:
    """Return what somebody may have put there instead."""
    if isinstance(value, dict):
        return [{**value, "more": 1}, [], dict(list(value.items())[1:]), None]
    if isinstance(value, list):
        return [[*value, *value[-1:], 1], value[1:], value[::-1], {}, 3]
    if isinstance(value, bool) or value is None:
        return [not value, 7]
    if isinstance(value, str):
        return [f"{value}x", "", 3]
    return [float(np.nextafter(value, 9e9)), -value - 1, str(value), 10**400, None]


def test_every_change_of_a_manifest_is_noticed() -> None:
    plan = plan_of(nut(friction_ratio="0.5,0.9", trough_length_mm=600), 5, digits=4, part={"pitch_mm": 25.0})
    content = json.loads(plan.manifest(ARGV))
    tried = 0
    for path in paths(content):
        if path[0] in ("argv", "name", "own", "pictures"):  # what does not count
            continue
        *before, last = path
        for other in others(_at(content, path)):
            if other == _at(content, path):
                continue
            changed = json.loads(json.dumps(content))
            _at(changed, before)[last] = other
            with pytest.raises(FileError, match=NOTICED) as caught:
                read_plan(json.dumps(changed), "m")
            assert caught.value.hint
            tried += 1
        changed = json.loads(json.dumps(content))
        del _at(changed, before)[last]
        with pytest.raises(FileError, match=NOTICED):
            read_plan(json.dumps(changed), "m")
    assert tried > 200


def _at(content: Any, path: Any) -> Any:
    for key in path:
        content = content[key]
    return content


def test_the_order_of_columns_counts() -> None:
    there, here = (plan_of(nut(), columns=names) for names in (["regime", "status"], ["status", "regime"]))
    assert there.fingerprint != here.fingerprint
    assert here.differences(there) == ["columns: regime,status there, status,regime here"]
    content = json.loads(there.manifest(ARGV))
    content["columns"] = dict(reversed(content["columns"].items()))
    with pytest.raises(FileError, match="damaged"):
        read_plan(json.dumps(content), "m")


def with_numpy_1() -> Plan:
    """Plan as if another NumPy were here."""
    with mock.patch("vibro.output.plan.versions", return_value={**versions(), "numpy": "1.0"}):
        return plan_of(nut())


THERE = plan_of(nut())
DIFFERENT = {
    "amplitude_mm: 7 values, 0.1 ... 3 mm, factor 1.763 there, 8 values, 0.1 ... 3 mm, factor 1.626 here;"
    " cells: 14 there, 16 here": plan_of(nut(amplitude_mm="0.1:3:8:log")),
    "amplitude_mm: 7 values, 0.1 ... 3 mm, factor 1.763 there, 7 values, 0.1 ... 3 mm, step 0.483 here":
        plan_of(nut(amplitude_mm="0.1:3:7")),
    # which looks the same at so many digits
    "frequency_hz: 15.1 there, 15.100000000000001 here":
        plan_of(nut(frequency_hz=[10, float(np.nextafter(15.1, 16))])),
    # the same values, by chance: but steps between them mean another thing to pictures
    "spacing of axes: ['log', 'list'] there, ['list', 'list'] here":
        plan_of(nut(amplitude_mm=THERE.grid.axes["amplitude"].values.tolist())),
    "drive_angle_deg: 20.0 there, none here; drive_angle_deg: no axis there, 2 values, 20, 30 deg here;"
    " cells: 14 there, 28 here": plan_of(nut(drive_angle_deg="20,30")),
    "static_friction: 0.74 there, 0.75 here": plan_of(nut(static_friction=0.75)),
    "friction_ratio: none there, 0.77 here; kinetic_friction: 0.57 there, none here":
        plan_of(nut(friction_ratio=0.77)),
    "trough_angle_deg: 0.0 there, 1.0 here": plan_of(nut(trough_angle_deg=1)),
    "gravity_m_s2: 9.81 there, 1.62 here": plan_of(nut(gravity_m_s2=1.62)),
    "restitution: 0.0 there, 0.3 here": plan_of(nut(restitution=0.3), 1_000_000),
    "trough_length_mm: none there, 600.0 here; columns: none there, trough_length_mm here":
        plan_of(nut(trough_length_mm=600)),
    "accuracy: exact there, regimes here; flight: True there, False here;"
    " columns: restitution there, none here": plan_of(nut(output="regimes")),
    "flight: True there, False here; columns: restitution there, none here": plan_of(nut(flight=False)),
    "coexistence: False there, True here": plan_of(nut(coexistence=True), 1_000_000),
    "digits: none there, 4 here": plan_of(nut(), digits=4),
    "shard cells: 1000000 there, 7 here": plan_of(nut(), 7),
    f"numpy: {versions()['numpy']} there, 1.0 here": with_numpy_1(),
}  # fmt: skip


@each("said", DIFFERENT)
def test_every_difference_is_named(said: str) -> None:
    here = DIFFERENT[said]
    assert "; ".join(here.differences(THERE)) == said
    assert here.fingerprint != THERE.fingerprint


def test_what_a_part_is_and_its_pitch_are_named() -> None:
    there = plan_of(nut(), part={"pitch_mm": 25.0}, columns=["parts_per_min"])
    here = plan_of(nut(), part={"pitch_mm": 30.0, "mass_kg": 0.1}, columns=["parts_per_min"])
    assert here.differences(there) == [
        "pitch_mm: 25.0 there, 30.0 here", "mass_kg: none there, 0.1 here",
    ]  # fmt: skip


def test_names_arguments_own_values_and_pictures_do_not_count() -> None:
    other = Plan.of(THERE.grid, THERE.table, None, "bolt", {"amplitude": 2.0}, ["_regime.png"])
    assert other.fingerprint == THERE.fingerprint
    assert other.differences(THERE) == []
    texts = [plan.manifest(argv) for plan, argv in ((THERE, ARGV), (other, ["vibro"]))]
    assert texts[0] != texts[1]
    assert {json.loads(text)["fingerprint"] for text in texts} == {THERE.fingerprint}


def test_shards_are_ranges_of_all_cells() -> None:
    for shard_cells in (1, 5, 7, 14, 15):
        plan = plan_of(nut(), shard_cells)
        ranges = [plan.range_of(shard) for shard in range(plan.shards)]
        assert [cell for first, end in ranges for cell in range(first, end)] == list(range(14))
        assert {end - first for first, end in ranges[:-1]} <= {shard_cells}


DEAR, CHEAP = 20_000, 1_000_000


@each(
    ("given", "cells"),
    [
        ({}, CHEAP),
        ({"restitution": 0.3}, DEAR),
        ({"restitution": [0, 0.3]}, DEAR),
        ({"restitution": [0, 0.3], "flight": False}, CHEAP),
        ({"restitution": 0.3, "output": "regimes"}, CHEAP),
        ({"restitution": 0.3, "coexistence": True}, DEAR),
        ({"coexistence": True}, DEAR),
        ({"flight": False}, CHEAP),
    ],
)
def test_shards_have_fewer_cells_where_cells_are_dear(given: dict[str, Any], cells: int) -> None:
    solved = nut(**given)
    assert usual_shard_cells(solved._grid) == plan_of(solved).shard_cells == cells
    assert plan_of(solved, 7).shard_cells == 7


def test_its_files_are_those_that_it_lists_under_names_that_vibro_gives() -> None:
    pictures = ["_speed.svg", "_regime.png", "speed.svg", "_hill.png", "../_flight.png"]
    plan = read_plan(plan_of(nut(), 7).manifest(ARGV, pictures), "m")
    shards = {"part-000000.parquet", "part-000001.parquet"}
    assert plan.files == {MANIFEST, SUCCESS, "_speed.svg", "_regime.png", *shards}
    assert list(read_plan(plan.manifest(ARGV, ["_flight.pdf", "_speed.svg"]), "m").pictures) == [
        *pictures, "_flight.pdf",
    ]  # fmt: skip
    with pytest.raises(FileError, match="damaged"):
        read_plan(json.dumps({**plan.content, "pictures": 3}), "m")


def test_more_shards_than_names_can_number_are_refused() -> None:
    axes = {"amplitude": list(np.arange(1.0, 1001.0)), "frequency": list(np.arange(1.0, 1002.0))}
    grid = grid_of(axes, drive_angle=20.0)
    assert grid.size == MOST_SHARDS + 1000
    with pytest.raises(InputError, match="shard_cells=1: ") as caught:
        whole(grid, 1)
    assert "shard_cells=2" in caught.value.hint
    assert whole(grid, 2).shards == MOST_SHARDS / 2 + 500


@each(
    "text",
    ["", "{", "[]", "3", '"vibro sweep 1"', "null", "{}", '{"format": 3}', '{"format": "other"}', "\0"],
)
def test_what_is_no_manifest_is_told(text: str) -> None:
    with pytest.raises(FileError, match=r"out/_manifest\.json is no manifest"):
        read_plan(text, "out/_manifest.json")


def test_a_later_format_is_told() -> None:
    content = json.loads(THERE.manifest(ARGV)) | {"format": "vibro sweep 4"}
    with pytest.raises(FileError, match="vibro sweep 4"):
        read_plan(json.dumps(content), "m")


def test_equal_numbers_that_are_written_differently_differ() -> None:
    """A sign of zero changes the fingerprint, which shards repeat: it must be told, not overlooked."""
    grid = THERE.grid
    grids = [replace(grid, fixed={**grid.fixed, "trough_angle": x}) for x in (0.0, -0.0)]
    zeros = [Plan.of(grid, THERE.table, None, "", {}) for grid in grids]
    assert zeros[0].fingerprint != zeros[1].fingerprint
    assert zeros[0].differences(zeros[1]) == ["trough_angle_deg: -0.0 there, 0.0 here"]
