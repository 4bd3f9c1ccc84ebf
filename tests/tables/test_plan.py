"""Plans: what a manifest says is read again, whatever was changed is noticed, and differences are named."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.plans import plan_of, swept

from vibro.axes import Axis
from vibro.errors import FileError, InputError
from vibro.sweeps.columns import Table, columns_of
from vibro.tables.plan import Plan, made_by, read_plan, sealed, unsealed

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from vibro.sweeps.whole import Sweep

ARGV = ["vibro", "map", "nut.toml"]
ELLIPSE: dict[str, Any] = {"along_amplitude_mm": 1, "normal_amplitude_mm": "0.1,0.2", "normal_phase_deg": 40}


def nut(**changed: Any) -> Sweep:
    """Sweep something that has numbers which are not short, in tables and in the scene."""
    return swept(**{"amplitude_mm": "0.1:3:7:log", "frequency_hz": [10, 15.1], **changed})


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "_manifest.json"


def bits(values: Any) -> list[int]:
    whole: list[int] = np.asarray(values, np.float64).view(np.int64).tolist()
    return whole


def check_same(again: Plan, plan: Plan) -> None:
    """Compare plans bit for bit."""
    assert again.fingerprint == plan.fingerprint
    assert again.differences(plan) == plan.differences(again) == ""
    assert list(again.grid.axes) == list(plan.grid.axes)
    for name, axis in plan.grid.axes.items():
        assert bits(again.grid.axes[name].values) == bits(axis.values)
        assert again.grid.axes[name].spacing == axis.spacing
    assert list(again.grid.fixed) == list(plan.grid.fixed)
    assert bits(list(again.grid.fixed.values())) == bits(list(plan.grid.fixed.values()))
    for name in ("length", "output", "flight", "coexistence"):
        assert getattr(again.grid, name) == getattr(plan.grid, name)
    assert [c.name for c in again.table.columns] == [c.name for c in plan.table.columns]
    assert dict(again.table.part) == dict(plan.table.part)
    for name in ("shards", "shard_cells", "row_group_cells", "name", "own"):
        assert getattr(again, name) == getattr(plan, name)


@each(
    "plan",
    [
        plan_of(nut()),
        plan_of(nut(trough_length_mm=600.1, restitution=0.3, trough_angle_deg=-2.5), 7),
        plan_of(nut(friction_ratio="0.5:1.2:4"), columns=["regime", "stroke_mm", "friction_ratio"]),
        plan_of(nut(friction_ratio=0.77), part={"pitch_mm": 25.1, "mass_kg": 0.012}),
        plan_of(nut(), part={"pitch_mm": 25.1}, columns=["parts_per_min"]),
        plan_of(swept("regimes", amplitude_mm="1,2")),
        plan_of(swept(stroke_mm="1,2", flight=False)),
        plan_of(swept(amplitude_mm="1,2", coexistence=True)),
        plan_of(swept(**ELLIPSE, along_amplitude_2_mm="0:0.2:3", along_phase_2_deg=30)),
        plan_of(swept(), row_group_cells=3),
    ],
)
def test_a_manifest_is_read_again_as_it_was_written(path: Path, plan: Plan) -> None:
    path.write_text(plan.manifest(ARGV), encoding="utf-8")
    check_same(read_plan(path), plan)
    assert read_plan(path).manifest(ARGV) == path.read_text(encoding="utf-8")
    content = json.loads(path.read_bytes())
    assert (content["argv"], content["cells"]) == (ARGV, plan.grid.size)


def values_in(content: Any) -> Iterator[tuple[Any, Any]]:
    """Yield every list and mapping, with each of its keys."""
    if isinstance(content, dict | list):
        for key, value in content.items() if isinstance(content, dict) else enumerate(content):
            yield content, key
            yield from values_in(value)


def others(value: Any) -> list[Any]:
    """Return what somebody may have put there instead."""
    if isinstance(value, dict | list):
        return [{}, [], None, [*value, 1]]
    if isinstance(value, bool) or value is None:
        return [not value, 7]
    if isinstance(value, str):
        return [f"{value}x", "", 3]
    return [float(np.nextafter(value, 9e9)), -value - 1, str(value), 10**400, None]


def test_every_change_of_a_manifest_is_noticed(path: Path) -> None:
    plan = plan_of(nut(friction_ratio="0.5,0.9", trough_length_mm=600), 5, part={"pitch_mm": 25.0})
    content = json.loads(plan.manifest(ARGV))
    tried = 0
    for holder, key in list(values_in(content)):
        kept = holder[key]
        for other in others(kept):
            if other == kept:
                continue
            holder[key] = other
            path.write_text(json.dumps(content), encoding="utf-8")
            with pytest.raises(FileError, match=r"damaged|is an unknown format|is no manifest") as caught:
                read_plan(path)
            assert caught.value.hint
            tried += 1
        holder[key] = kept
    assert tried > 250
    text = plan.manifest(ARGV)
    path.write_text(text, encoding="utf-8")
    check_same(read_plan(path), plan)
    for other in (text[: len(text) // 2], text + "}", text.replace('"cells"', '"cell"')):
        path.write_text(other, encoding="utf-8")
        with pytest.raises(FileError):
            read_plan(path)


@each("text", ["", "{", "[]", "3", "null", "{}", '{"format": 3}', "\0", "[" * 100_000, "\ud800"])
def test_what_is_no_manifest_is_told(path: Path, text: str) -> None:
    path.write_bytes(text.encode(errors="surrogatepass"))
    with pytest.raises(FileError, match=r"_manifest\.json is no manifest"):
        read_plan(path)
    path.write_text('{"format": "vibro sweep 99"}', encoding="utf-8")
    with pytest.raises(FileError, match="vibro sweep 99"):
        read_plan(path)


def test_a_seal_is_of_what_is_said() -> None:
    content = {"cells": 3, "peaks": {"speed": 0.1 + 0.2}}
    assert unsealed(sealed(content)) == content
    assert unsealed(json.dumps(json.loads(sealed(content)))) == content
    for text in ("{}", "[]", sealed(content).replace("3", "4"), sealed(content)[:-20]):
        with pytest.raises(ValueError, match=r"checksum|delimiter|Expecting|Unterminated"):
            unsealed(text)


def test_what_changes_the_shards_is_named_and_nothing_else_counts() -> None:
    there = plan_of(nut())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibro.tables.plan.made_by", lambda: {**made_by(), "numpy": "1.0"})
        with_numpy_1 = plan_of(nut())
    different = {
        "values: [10.0, 15.1] there, [10.0, 15.100000000000001] here":
            plan_of(nut(frequency_hz=[10, float(np.nextafter(15.1, 16))])),
        'spacing: "log" there, "list" here':
            plan_of(nut(amplitude_mm=there.grid.axes["amplitude"].values.tolist())),
        "scene static_friction: 0.74 there, 0.75 here": plan_of(nut(static_friction=0.75)),
        "scene friction_ratio: null there, 0.77 here": plan_of(nut(friction_ratio=0.77)),
        "scene trough_length_mm: null there, 600.0 here": plan_of(nut(trough_length_mm=600)),
        "flight: true there, false here": plan_of(nut(flight=False)),
        "coexistence: false there, true here": plan_of(nut(coexistence=True), 1_000_000),
        'accuracy: "exact" there, "regimes" here': plan_of(nut(output="regimes")),
        "shard_cells: 1000000 there, 7 here": plan_of(nut(), 7),
        "row_group_cells: 131072 there, 5 here": plan_of(nut(), row_group_cells=5),
        "part: null there": plan_of(nut(), part={"pitch_mm": 25.0}),
        "columns": plan_of(nut(), columns=[c.name for c in reversed(there.table.columns)]),
        f'made_by numpy: "{made_by()["numpy"]}" there, "1.0" here': with_numpy_1,
    }  # fmt: skip
    for said, here in different.items():
        assert said in here.differences(there)
        assert here.fingerprint != there.fingerprint
    other = Plan.of(there.grid, there.table, "bolt", {"amplitude": 2.0})
    assert (other.fingerprint, other.differences(there)) == (there.fingerprint, "")
    assert other.manifest(["vibro"]) != there.manifest(ARGV)
    zeros = [replace(there.grid, fixed={**there.grid.fixed, "trough_angle": x}) for x in (0.0, -0.0)]
    one, two = (Plan.of(grid, there.table, "", {}) for grid in zeros)
    assert one.fingerprint != two.fingerprint


def test_shards_are_ranges_of_all_cells() -> None:
    for shard_cells in (1, 5, 7, 14, 15):
        plan = plan_of(nut(), shard_cells)
        ranges = [plan.range_of(shard) for shard in range(plan.shards)]
        assert [cell for first, end in ranges for cell in range(first, end)] == list(range(14))
        assert {end - first for first, end in ranges[:-1]} <= {shard_cells}
    grid = plan_of(nut()).grid
    long = {name: Axis(name, np.arange(1.0, 1002.0), "list") for name in grid.axes}
    with pytest.raises(InputError, match="1002001 cells"):
        Plan.of(replace(grid, axes=long), Table(columns_of()), "", {}, 1)


@each(
    ("given", "is_dear"),
    [
        ({}, False),
        ({"restitution": 0.3}, True),
        ({"restitution": [0, 0.3]}, True),
        ({"restitution": [0, 0.3], "flight": False}, False),
        ({"restitution": 0.3, "output": "regimes"}, False),
        ({"coexistence": True}, True),
    ],
)
def test_shards_have_fewer_cells_where_cells_are_dear(given: dict[str, Any], is_dear: bool) -> None:
    assert plan_of(nut(**given)).shard_cells == (20_000 if is_dear else 1_000_000)
