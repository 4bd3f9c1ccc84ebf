"""The description of files: every table and key of it can be read, and says what it is."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.cases import each

from vibro.errors import Problems
from vibro.files.descriptions import FILES, SCENE_FILE, FileKind
from vibro.files.entries import ABSENT
from vibro.files.scene_files import read_scene_file
from vibro.quantities import BY_COLUMN


@pytest.mark.parametrize("file", FILES.values(), ids=FILES)
def test_every_key_says_what_it_is_and_what_is_needed_is_known(file: FileKind) -> None:
    for name, table in file.tables.items():
        assert table.meaning
        for key, entry in table.entries.items():
            assert key == entry.quantity.column
            assert entry.quantity.meaning, key
            assert entry.example is None or entry.read(entry.example) is not None
        problems, none = Problems(), Problems()
        file.table(name, {}, problems)
        assert len(problems.found) == len(table.needs)
        assert all(set(keys) <= table.entries.keys() for keys in table.needs)
        file.table(name, ABSENT, none)
        assert len(none.found) == (len(table.needs) if table.required else 0)
    if file is SCENE_FILE:
        assert [*file.tables["map"].entries] == [*BY_COLUMN]


@each("key", SCENE_FILE.tables["scene"].entries)
def test_every_key_of_a_scene_is_read(tmp_path: Path, key: str) -> None:
    entry = SCENE_FILE.tables["scene"].entries[key]
    value = [0.5, 0.25] if "rows" in entry.form.spellings else 0.5
    path = tmp_path / "scene.toml"
    name = entry.quantity.name
    clamped = {"normal_force": "mass_kg = 2", "mass": "normal_force_n = 2"}.get(name, "")
    path.write_text(f"[scene]\n{key} = {value}\n{clamped}", encoding="utf-8")
    name = "normal_acceleration" if clamped else name
    assert (name.removesuffix("s") if isinstance(value, list) else name) in read_scene_file(path).scene
