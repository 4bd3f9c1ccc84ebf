"""What the pages about working on vibro say of the code is so."""

from __future__ import annotations

from rooms import ROOT, layers_of, purpose_of, steps_of


def test_every_room_says_its_purpose_and_the_way_of_a_scene_leads_through_them() -> None:
    for package in ("vibro", "vibro.core"):
        for room in (room for layer in layers_of(package) for room in layer):
            assert purpose_of(package, room).endswith("."), room
    steps = steps_of((ROOT / "docs" / "working" / "index.md").read_text(encoding="utf-8"))
    assert [number for number, _ in steps] == list(range(1, 11))
    assert {room for _, room in steps} <= {room for layer in layers_of("vibro") for room in layer}
