"""Damaged files, and what is no file: whatever reads them raises an error of vibro, at once."""

from __future__ import annotations

import json
import os
import random
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import pytest

from vibro import FileError, InputError, VibroError, open_sweep, write_sweep
from vibro.designs.reading import read_spec
from vibro.files.points import read_points, read_speeds
from vibro.files.scene_files import read_scene_file
from vibro.records.texts import text_table

if TYPE_CHECKING:
    from collections.abc import Callable

EXAMPLES: Final = Path(__file__).parents[2] / "examples"
READERS: Final[list[tuple[str, Callable[[Path], object]]]] = [
    ("full_feeder.toml", read_scene_file),
    ("slip_stick.toml", read_scene_file),
    ("design_machine.toml", read_spec),
    ("data/feeder_response.csv", read_points),
    ("data/nut_times.csv", read_speeds),
    ("data/nut_times.csv", text_table),
]
VALUES: Final = (b"1e400", b"1" + b"0" * 5000, b"nan", b"[[1], 2]", b'"\\u0000"', b"{a = 1}", b"1979-05-27")
WHOLE: Final = (
    b"", b"\0" * 99, b"a=" + b"[" * 100_000, b".".join([b"a"] * 100_000) + b"=1", b"[" * 9 + b"a.b" * 100_000,
    b",".join([b"1"] * 100_000), b'"' * 9999, b"\xff\xfe" + b"a" * 999, b"PK\3\4" + bytes(range(256)),
)  # fmt: skip


def damaged(whole: bytes, chance: random.Random) -> bytes:
    """Cut a file, change some of its bytes, or put a value of another kind in place of one."""
    kind, at = chance.randrange(4), chance.randrange(len(whole))
    if kind == 0:
        return whole[:at]
    if kind == 1:
        lines = whole.split(b"\n")
        row = at % len(lines)
        head, mark, _ = lines[row].rpartition(b"=" if b"=" in lines[row] else b",")
        return b"\n".join([*lines[:row], head + mark + chance.choice(VALUES), *lines[row + 1 :]])
    if kind == 2:
        return whole[:at] + whole[chance.randrange(len(whole)) :]
    changed = bytearray(whole)
    for _ in range(chance.choice([1, 2, 20])):
        changed[chance.randrange(len(changed))] = chance.randrange(256)
    return bytes(changed)


@pytest.mark.parametrize(("name", "read"), READERS)
def test_a_damaged_file_is_read_or_refused(name: str, read: Callable[[Path], object], tmp_path: Path) -> None:
    whole, chance = (EXAMPLES / name).read_bytes(), random.Random(7)
    path, refused = tmp_path / Path(name).name, list[str]()
    encoded = whole.decode().encode("utf-16")
    for content in (*WHOLE, encoded, *(damaged(whole, chance) for _ in range(25))):
        path.write_bytes(content)
        try:
            read(path)
        except VibroError as exc:
            refused.append(str(exc))
    assert len(refused) > 12
    # A value out of its range may be named alone, as one that is given in a call.
    assert [text for text in refused if path.name not in text and "must be" not in text] == []
    assert [text for text in refused if len(text.splitlines()) > 1] == []


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names")
def test_what_is_no_regular_file_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "endless").symlink_to("/dev/zero")
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "folder").mkdir()
    with (tmp_path / "large").open("wb") as stream:
        stream.truncate(2**30)
    for name in ("pipe", "endless", "loop", "folder", "large"):
        for read in {read for _, read in READERS}:
            with pytest.raises(FileError, match=f"cannot read .*{name}: "):
                read(tmp_path / name)


def test_a_damaged_sweep_is_read_or_refused(tmp_path: Path) -> None:
    nut: dict[str, Any] = {"drive_angle_deg": 20, "static_friction": 0.74, "kinetic_friction": 0.57}
    made, chance = tmp_path / "made", random.Random(3)
    write_sweep(made, amplitude_mm="0.1:3:9", frequency_hz=[10, 20], **nut)
    whole, refused = open_sweep(made).to_frame(), list[str]()
    for file in [path.name for path in made.iterdir()]:
        content = (made / file).read_bytes()
        hostile = [b"", b"[" * 200_000, b"{}", *(damaged(content, chance) for _ in range(12))]
        if not file.endswith(".parquet"):
            known = json.loads(content)
            hostile += [json.dumps({**known, key: 1e308}).encode() for key in known]
        for changed in (*hostile, None):
            there = tmp_path / "there"
            shutil.copytree(made, there)
            (there / file).unlink()
            if changed is None:
                (there / file).mkdir()
            else:
                (there / file).write_bytes(changed)
            try:
                assert open_sweep(there).to_frame().equals(whole)
            except (FileError, InputError) as exc:
                refused.append(str(exc))
            shutil.rmtree(there)
    assert len(refused) > 30
    assert [text for text in refused if "there" not in text] == []
