"""Scene files: read exactly, or refused with the key, the value and the fix."""

from __future__ import annotations

from pathlib import Path

import pytest
from helpers.cases import each

from vibro.errors import InputError
from vibro.files.scene_files import read_scene_file

SCENE = """
[scene]
amplitude_mm = 3.97
frequency_hz = 15
drive_angle_deg = 20.0
static_friction = 0.74
friction_ratio = 0.77
trough_length_mm = 600

[map]
amplitude_mm = "0.1:3:30"
frequency_hz = [10, 20.5]
static_friction = 0.5
"""


def written(folder: Path, text: str | bytes, name: str = "nut.toml") -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_a_scene_file_is_read_exactly(tmp_path: Path) -> None:
    file = read_scene_file(written(tmp_path, SCENE))
    assert file.name == "nut"
    assert {name: spec.value for name, spec in file.scene.items()} == {
        "amplitude": 3.97,
        "frequency": 15.0,
        "drive_angle": 20.0,
        "static_friction": 0.74,
        "friction_ratio": 0.77,
        "trough_length": 600.0,
    }
    assert list(file.sweep["amplitude"].axis(7).values) == [i / 10 for i in range(1, 31)]
    assert list(file.sweep["frequency"].axis(7).values) == [10.0, 20.5]
    assert file.sweep["static_friction"].value == 0.5


def test_every_value_may_be_a_text_with_a_unit(tmp_path: Path) -> None:
    texts = '[scene]\nfrequency_hz = "900rpm"\nalong_amplitudes_mm = ["800um", 0.1]\n'
    numbers = "[scene]\nfrequency_hz = 15\nalong_amplitudes_mm = [0.8, 0.1]\n"
    with_units, plain = (read_scene_file(written(tmp_path, text)).scene for text in (texts, numbers))
    assert with_units == plain
    texts = '[motion]\nalong_steps = [[0.8, "6.9m/s^2"], [0.2, -27.6]]\n'
    motion = read_scene_file(written(tmp_path, texts)).motion
    assert motion is not None
    assert motion.table == {"along_steps": [[0.8, 6.9], [0.2, -27.6]]}


@pytest.mark.parametrize(
    "text", [b"\xef\xbb\xbf[scene]\r\namplitude_mm = 1\r\n", b"[scene]\namplitude_mm = 1 # \xc2\xb5"]
)
def test_files_from_windows_are_read(tmp_path: Path, text: bytes) -> None:
    assert read_scene_file(written(tmp_path, text)).scene["amplitude"].value == 1


@each(
    "text",
    ["[scene]\nstatic_friction = 0,74", "[scene\n", "[scene]\na = 1\na = 2", "a = " + 5000 * "["],
)
def test_what_is_no_toml(tmp_path: Path, text: str) -> None:
    """What its reader says differs from one version of Python to the next."""
    path = written(tmp_path, text)
    with pytest.raises(InputError, match="not valid TOML") as caught:
        read_scene_file(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert ("decimal point: static_friction = 0.74" in caught.value.hint) == ("0,74" in text)


@each("value", ["9" * 400, "9" * 5000, "[1, -" + "9" * 5000 + "]", '"' + "9" * 5000 + '"', "1e" + "9" * 5000])
def test_thousands_of_digits_are_refused_in_few_words(tmp_path: Path, value: str) -> None:
    path = written(tmp_path, f"[map]\nfrequency_hz = {value}\n")
    with pytest.raises(InputError) as caught:
        read_scene_file(path)
    assert len(str(caught.value)) < len(str(path)) + 200
    assert len(caught.value.hint) < 100


QUESTION = "[scene]\nstatic_friction = 0.3\n[goal]\nspeed_mm_s = 80\n"


@each(
    ("text", "is_question"),
    [
        (f"{QUESTION}[drive]\nfreqency_hz = 50\n[drif]\n", True),  # with slips too
        (f"{QUESTION}[drive]\n[map]\namplitude_mm = 1\nfrequency_hz = 50", True),
        (QUESTION, False),  # a scene that has a goal, as nothing is chosen from
    ],
)
def test_a_question_of_vibro_design_is_told_from_a_scene(
    tmp_path: Path, text: str, is_question: bool
) -> None:
    path = written(tmp_path, text)
    with pytest.raises(InputError) as caught:
        read_scene_file(path)
    assert ("vibro.design in Python" in caught.value.hint) is is_question
