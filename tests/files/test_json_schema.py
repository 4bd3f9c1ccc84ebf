"""The JSON Schema: valid itself, for all that the readers accept, and of use against what they refuse."""

from __future__ import annotations

import json
import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from helpers.cases import each
from helpers.questions import FEEDER, GOOD, changed
from helpers.wild import AXIS, exactly
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from vibro.designs.reading import read_spec
from vibro.errors import InputError
from vibro.files.descriptions import DESIGN_FILE, FILES, SCENE_FILE, FileKind
from vibro.files.json_schema import VERSION, schema_of
from vibro.files.scene_files import read_scene_file
from vibro.friction import rows

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))


@cache
def validator(name: str) -> Any:
    return Draft202012Validator(schema_of(FILES[name]))


def problems(name: str, content: Any) -> list[str]:
    return [error.message for error in validator(name).iter_errors(content)]


@pytest.mark.parametrize("name", FILES)
def test_it_is_a_schema_whose_keys_are_described_by_valid_examples(name: str) -> None:
    schema = schema_of(FILES[name])
    Draft202012Validator.check_schema(schema)
    assert schema["$schema"] == Draft202012Validator.META_SCHEMA["$id"]
    assert schema["$id"] == f"urn:vibro:schema:{name}:{VERSION}"
    for table in schema["$defs"].values():
        for entry in table["properties"].values():
            assert entry["description"].endswith(".")
            for example in entry.get("examples", ()):
                assert Draft202012Validator(entry).is_valid(example)


@each("path", EXAMPLES)
def test_every_example_is_valid(path: Path) -> None:
    content = tomllib.loads(path.read_text(encoding="utf-8"))
    name = "design" if path.stem.startswith("design") else "scene"
    assert problems(name, content) == []
    assert problems("scene" if name == "design" else "design", content)


def test_the_docs_show_files_that_are_read_and_valid(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "guide" / "files.md").read_text(encoding="utf-8")
    shown = [
        text for text in re.findall(r"```toml\n(.*?)```", page, flags=re.DOTALL) if "[[rule]]" not in text
    ]
    for text in shown:
        assert problems("scene", tomllib.loads(text)) == []
        (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
        file = read_scene_file(tmp_path / "scene.toml")
        assert file.scene or file.machine
    assert len(shown) >= 2


@each(
    "content",
    [
        {"scene": {"amplitude": 1}},
        {"scene": 1},
        {"scene": {"amplitude_mm": "1.2kg"}},
        {"scene": {"amplitude_mm": True}},
        {"scene": {"amplitude_mm": 0}},
        {"scene": {"friction_ratio": 1.1}},
        {"scene": {"along_amplitudes_mm": [1, -1]}},
        {"scene": {"along_amplitudes_mm": 17 * [1]}},
        {"map": {"along_amplitudes_mm": [1]}},
        {"map": {"amplitude_mm": "0.1:3:log:log"}},
        {"map": {"amplitude_mm": "1,,2"}},
        {"map": {"amplitude_mm": [0, 1]}},
        {"motion": {"along_steps": [[1]]}},
        {"motion": {"along_samples_mm": [1, 2]}},
        {"map": {"trough_length_mm": "1:3"}},
    ],
)
def test_malformed_scenes_are_invalid(content: Any) -> None:
    assert problems("scene", content)


@each(
    "entries",
    [
        {"scene__static_friction": None},
        {"scene__static_friction": "0.3:0.5:7"},
        {"scene__trough_angle_deg": "1mm"},
        {"scene__amplitude_mm": 1},
        {"drive__name": " "},
        {"drive__frequency_hz": None},
        {"drive__frequency_hz": [50, True]},
        {"drive__drive_angle_deg": "10;20"},
        {"drift__amplitude_percent": 100},
        {"goal__traverse_time_s": 9},
        {"goal__flight_fraction": 0},
    ],
)
def test_malformed_designs_are_invalid(entries: dict[str, Any]) -> None:
    assert problems("design", changed(**entries))


def test_designs_are_valid_in_all_their_forms() -> None:
    assert problems("design", GOOD) == []
    assert problems("design", tomllib.loads(FEEDER)) == []
    assert problems("design", changed(drive=GOOD["drive"][0])) == []
    for row in rows():
        assert problems("design", changed(scene__static_friction=f"{row.pair}, {row.condition}")) == []


CASES = st.sampled_from([str.lower, str.upper, str.title, str.casefold, " {} ".format])
WORDS = st.sampled_from(["hopping", "wood on steel", " magnet ", "1", "0,5", "1:2:3", "1:2:log", "\u0663"])


@st.composite
def values(draw: st.DrawFn, file: FileKind) -> tuple[str, str, Any]:
    """Draw a table, a key of it, and what somebody might write there: often right, in all forms and units."""
    table = draw(st.sampled_from([*file.tables]))
    key, entry = draw(st.sampled_from([*file.tables[table].entries.items()]))
    size = 0.9 if entry.quantity.allowed.high == 1.0 else 40.0
    number = st.one_of(st.floats(0.3 * size, size), st.floats(-1.0, 100.0), st.integers(-1, 90))
    unit = st.builds(lambda case, unit: case(unit), CASES, st.sampled_from(["", *entry.quantity.kind.sizes]))
    text = st.builds(lambda number, unit: f"{number:.4g}{unit}", number, unit)
    several = st.lists(number, min_size=1, max_size=3, unique=True).map(sorted)
    texts = st.builds(lambda numbers, unit: [f"{n:.4g}{unit}" for n in numbers], several, unit)
    count = st.sampled_from(["", ":7", ": 7.0", ":step=1e-3", ": STEP= .1", ":log", ":2:Log"])
    ends = st.builds(str.__add__, texts.map(":".join), count)
    value = st.one_of(number, text, several, texts, texts.map(" , ".join), ends, WORDS, AXIS)
    return table, key, draw(value)


@exactly("axes")
@given(st.lists(values(DESIGN_FILE), min_size=1, max_size=2))
def test_every_design_that_is_read_is_valid(entries: list[tuple[str, str, Any]]) -> None:
    content = changed(**{f"{table}__{key}": value for table, key, value in entries})
    try:
        read_spec(content)
    except InputError:
        return
    assert problems("design", content) == []


@exactly("axes")
@given(values(SCENE_FILE))
def test_every_entry_of_a_scene_file_that_can_be_used_is_valid(
    tmp_path: Path, entry: tuple[str, str, Any]
) -> None:
    table, key, value = entry
    path = tmp_path / "scene.toml"
    path.write_text(f"[{table}]\n{key} = {json.dumps(value)}\n", encoding="utf-8")
    try:
        file = read_scene_file(path)
    except InputError:
        return
    for spec in [*file.scene.values(), *file.sweep.values()]:
        allowed = spec.quantity.swept if spec.varies else spec.quantity
        ends = [(float(end), allowed.to_si(float(end))) for end in spec.values]
        if not all(allowed.allows(si) for _, si in ends):
            return  # refused as soon as it is used
        if any(end and not si for end, si in ends):
            return  # it vanishes in SI units: -5e-324 mm is 0 m
    assert problems("scene", {table: {key: value}}) == []
