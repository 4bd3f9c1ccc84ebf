"""What the pages about working on vibro say of the code is so."""

from __future__ import annotations

import re
from html import unescape

import pytest
from rooms import ROOT, drawing, layers_of, purpose_of, steps_of

INDEX = (ROOT / "docs" / "working" / "index.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("package", ["vibro", "vibro.core"])
def test_every_room_is_drawn_with_its_purpose(package: str) -> None:
    svg = drawing(package)
    words = re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", unescape(svg)))
    for room in (room for layer in layers_of(package) for room in layer):
        assert purpose_of(package, room).endswith("."), room
        assert f">{room}</text>" in svg
        assert re.sub(r"\s+", " ", purpose_of(package, room).replace("``", "")) in words, room


def test_the_way_of_a_scene_is_numbered_in_the_drawing() -> None:
    steps = steps_of(INDEX)
    assert [number for number, _ in steps] == list(range(1, 11))
    svg = drawing("vibro", steps)
    numbers = ",".join(re.findall(r">([\d, ]+)</text>", svg))
    assert sorted(map(int, numbers.split(","))) == list(range(1, 11))
