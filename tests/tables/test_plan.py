"""Plans: what a manifest says is read again, whatever was changed is noticed, and differences are named."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.plans import plan_of, swept

from vibro.errors import FileError
from vibro.tables.plan import MANIFEST, Plan, made_by, read_plan, sealed

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from vibro.sweeps.whole import Sweep

ARGV = ["vibro", "map", "nut.toml"]
ELLIPSE: dict[str, Any] = {"along_amplitude_mm": 1, "normal_amplitude_mm": "0.1,0.2", "normal_phase_deg": 40}


def nut(**changed: Any) -> Sweep:
    """Sweep something that has numbers which are not short, in tables and in the scene."""
    return swept(**{"amplitude_mm": "0.1:3:7:log", "frequency_hz": [10, 15.1], **changed})


@each(
    "plan",
    [
        plan_of(nut(trough_length_mm=600.1, restitution=0.3, trough_angle_deg=-2.5), 7, row_group_cells=3),
        plan_of(nut(friction_ratio="0.5:1.2:4"), columns=["regime", "stroke_mm", "friction_ratio"]),
        plan_of(swept("regimes", stroke_mm="1, 2", flight=False), part={"pitch_mm": 25.1}),
        plan_of(swept(**ELLIPSE, along_amplitude_2_mm="0:0.2:3", along_phase_2_deg=30, starts=16)),
    ],
)
def test_a_manifest_is_read_again_as_it_was_written(tmp_path: Path, plan: Plan) -> None:
    path = tmp_path / MANIFEST
    path.write_text(plan.manifest(ARGV), encoding="utf-8")
    again = read_plan(path)
    assert again.manifest(ARGV) == path.read_text(encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibro.tables.plan.BLOCK", plan.row_group_cells)
        made = Plan.of(again.grid, again.table, again.name, again.own, again.shard_cells)
    assert sealed(made.content) == sealed(plan.content)


def values_in(content: Any) -> Iterator[tuple[Any, Any]]:
    """Yield every list and mapping, with each of its keys."""
    if isinstance(content, dict | list):
        for key, value in content.items() if isinstance(content, dict) else enumerate(content):
            yield content, key
            yield from values_in(value)


def test_every_change_of_a_manifest_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / MANIFEST
    plan = plan_of(nut(friction_ratio="0.5,0.9", trough_length_mm=600), 5, part={"pitch_mm": 25.0})
    content = json.loads(plan.manifest(ARGV))
    changed = ["", "{", "[]", "null", "{}", "\0", "[" * 100_000, '{"format": 3}', plan.manifest(ARGV)[:-9]]
    for holder, key in list(values_in(content)):
        kept = holder[key]
        holder[key] = np.nextafter(kept, 9e9) if isinstance(kept, float) else f"{kept}x"
        changed.append(json.dumps(content))
        holder[key] = kept
    assert len(changed) > 90
    for text in changed:
        path.write_text(text, encoding="utf-8")
        with pytest.raises(FileError, match=r"damaged|is an unknown format|is no manifest") as caught:
            read_plan(path)
        assert caught.value.hint


def test_what_changes_the_shards_is_named_and_nothing_else_counts() -> None:
    there = plan_of(nut())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibro.tables.plan.made_by", lambda: {**made_by(), "numpy": "1.0"})
        with_numpy_1 = plan_of(nut())
    different = {
        "values: [10.0, 15.1] there, [10.0, 15.100000000000001] here":
            plan_of(nut(frequency_hz=[10, float(np.nextafter(15.1, 16))])),
        "spacing: log there, list here":
            plan_of(nut(amplitude_mm=there.grid.axes["amplitude"].values.tolist())),
        "scene trough_length_mm: null there, 600.0 here": plan_of(nut(trough_length_mm=600)),
        "shard_cells: 1000000 there, 7 here": plan_of(nut(), 7),
        "part: null there": plan_of(nut(), part={"pitch_mm": 25.0}),
        "columns": plan_of(nut(), columns=[c.name for c in reversed(there.table.columns)]),
        f"made_by numpy: {made_by()['numpy']} there, 1.0 here": with_numpy_1,
    }  # fmt: skip
    for said, here in different.items():
        assert said in here.differences(there)
        assert here.fingerprint != there.fingerprint
    other = Plan.of(there.grid, there.table, "bolt", {"amplitude": 2.0})
    assert (other.fingerprint, other.differences(there)) == (there.fingerprint, "")


def test_shards_are_ranges_of_all_cells() -> None:
    for shard_cells in (1, 5, 7, 14, 15):
        plan = plan_of(nut(), shard_cells)
        ranges = [plan.range_of(shard) for shard in range(plan.shards)]
        assert [cell for first, end in ranges for cell in range(first, end)] == list(range(14))
        assert {end - first for first, end in ranges[:-1]} <= {shard_cells}
