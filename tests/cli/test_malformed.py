"""Axes and scene files, most of them wrong: each is understood, or refused in clear lines.

On some hundreds of them, or on some thousands with --hypothesis-profile=thorough.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from helpers.wild import AXIS, KEY, KEYS, QUANTITY, SECTION, TOML_VALUE, exactly
from hypothesis import given
from hypothesis import strategies as st

from vibro.axes import parse_axis
from vibro.errors import InputError
from vibro.files.scene_files import read_scene_file

if TYPE_CHECKING:
    from collections.abc import Callable


def attempt(parse: Callable[[], Any]) -> tuple[Any, InputError | None]:
    """Parse something; return the result, or the error that refuses it."""
    try:
        return parse(), None
    except InputError as refusal:
        return None, refusal


def are_clear(refusal: InputError) -> bool:
    """Whether a message consists of lines that a console can show."""
    hints = refusal.hint.split("\n") if refusal.hint else []
    lines = [*refusal.problems, *hints]
    return bool(refusal.problems) and all(line.strip() and line.isprintable() for line in lines)


@exactly("axes")
@given(AXIS, QUANTITY)
def test_an_axis_is_understood_or_refused_in_one_line(text: str, quantity: Any) -> None:
    spec, refusal = attempt(lambda: parse_axis(text, quantity))
    if spec is not None and (spec.count is None or spec.count < 1000):
        axis, refusal = attempt(lambda: spec.axis(5))
        if axis is not None:
            assert np.isfinite(axis.values).all()
            assert (np.diff(axis.values) > 0.0).all()
    if refusal is not None:
        assert len(refusal.problems) == 1
        assert are_clear(refusal), refusal.problems
        assert quantity.label in refusal.problems[0]


@exactly("texts")
@given(st.one_of(st.lists(SECTION, max_size=3).map("\n".join).map(str.encode), st.binary(max_size=40)))
def test_a_scene_file_is_understood_or_refused_in_lines(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    _, refusal = attempt(lambda: read_scene_file(path))
    assert refusal is None or are_clear(refusal), (refusal.problems, refusal.hint)


@exactly("tables")
@given(st.sampled_from(["scene", "map"]), st.dictionaries(KEY, TOML_VALUE, min_size=1, max_size=4))
def test_every_wrong_entry_of_a_table_is_named(tmp_path: Path, table: str, entries: dict[str, str]) -> None:
    path = tmp_path / "scene.toml"
    text = "\n".join([f"[{table}]", *(f"{key} = {value}" for key, value in entries.items())])
    path.write_text(text, encoding="utf-8")
    found, refusal = attempt(lambda: read_scene_file(path))
    unknown = [key for key in entries if key not in KEYS]
    if refusal is None:
        assert not unknown
        assert len(found.scene) + len(found.sweep) == len(entries)
        return
    assert are_clear(refusal), (refusal.problems, refusal.hint)
    if "not valid TOML" not in refusal.problems[0]:
        assert all(any(repr(key) in problem for problem in refusal.problems) for key in unknown)
        assert len(refusal.problems) <= len(entries)
