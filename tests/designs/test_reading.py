"""Questions of inverse design: read exactly."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.cases import each
from helpers.questions import FEEDER, GOOD, changed
from hypothesis import given
from hypothesis import strategies as st

from vibro.core.codes import Regime
from vibro.designs.questions import Drift, Drive, Goal, Spec
from vibro.designs.reading import read_spec
from vibro.drives import Line
from vibro.errors import InputError
from vibro.quantities import QUANTITIES


def deg(angle: float) -> float:
    return float(QUANTITIES["drive_angle"].to_si(angle))


def line(
    name: str,
    amplitude: tuple[float, float],
    frequency: Any,
    drive_angle: Any,
    acceleration: float = math.inf,
) -> Drive:
    choices = {"amplitude": (amplitude,), "frequency": frequency, "drive_angle": drive_angle}
    return Drive(name, Line, choices, acceleration)


def test_a_question_is_read_exactly(tmp_path: Path) -> None:
    path = tmp_path / "feeder.toml"
    path.write_text(FEEDER, encoding="utf-8")
    spec = read_spec(path)
    assert spec == read_spec(str(path))
    assert spec == Spec(
        bands={
            "static_friction": (0.3, 0.5),
            "friction_ratio": (0.7, 0.9),
            "trough_angle": (deg(3), deg(3)),
        },
        drives=(
            line("magnet", (0.0, 0.0008), ((50.0, 50.0), (100.0, 100.0)), ((deg(10), deg(40)),), 4.0),
            replace(
                line(
                    "drive 2", (0.0005, 0.003), ((15.0, 25.0),), ((deg(20), deg(20)), (deg(30.5), deg(30.5)))
                ),
                in_stroke=True,
            ),
        ),
        goal=Goal(0.08, Regime.FORWARD_SLIP, 0.1, 0.4),
        drift=Drift(0.05, 0.01, deg(1), deg(0.5)),
        length=1.2,
        stand_ratio=0.75,
        name="feeder",
    )


def test_what_is_left_out_has_its_default() -> None:
    spec = read_spec(GOOD)
    assert spec.bands["trough_angle"] == (0.0, 0.0)
    assert spec == Spec(spec.bands, spec.drives, Goal(0.08))
    assert spec.drives == (line("drive 1", (0.0, 0.0008), ((50.0, 50.0),), ((deg(10), deg(40)),)),)
    assert spec.goal.highest_regime is Regime.BACK_SLIP


@each(
    ("entries", "field", "expected"),
    [
        ({"scene__static_friction": 0.4}, "static_friction", (0.4, 0.4)),
        ({"scene__static_friction": " 0.3 : 0.5 "}, "static_friction", (0.3, 0.5)),
        ({"scene__static_friction": "0.5:0.5"}, "static_friction", (0.5, 0.5)),
        ({"scene__static_friction": np.float64(0.4)}, "static_friction", (0.4, 0.4)),
        ({"scene__friction_ratio": "0:1"}, "friction_ratio", (0.0, 1.0)),
        ({"scene__trough_angle_deg": "-2:3"}, "trough_angle", (deg(-2), deg(3))),
        ({"scene__trough_angle_deg": "-0.01rad:0.02rad"}, "trough_angle", (-0.01, 0.02)),
        (
            {"scene__friction_ratio": None, "scene__kinetic_friction": "0.2:0.6"},
            "kinetic_friction",
            (0.2, 0.6),
        ),
    ],
)  # fmt: skip
def test_bands(entries: dict[str, Any], field: str, expected: tuple[float, float]) -> None:
    assert read_spec(changed(**entries)).bands[field] == pytest.approx(expected, rel=2e-16)


@each(
    ("key", "value", "field", "expected"),
    [
        ("amplitude_mm", "0.1:0.8", "amplitude", ((0.0001, 0.0008),)),
        ("amplitude_mm", "0:800um", "amplitude", ((0.0, 0.0008),)),
        ("amplitude_mm", "0.8:0.8", "amplitude", ((0.0008, 0.0008),)),
        ("frequency_hz", [50], "frequency", ((50.0, 50.0),)),
        ("frequency_hz", np.array([50, 60]), "frequency", ((50.0, 50.0), (60.0, 60.0))),
        ("frequency_hz", "15:15", "frequency", ((15.0, 15.0),)),
        ("drive_angle_deg", 0, "drive_angle", ((0.0, 0.0),)),
        ("name", " two words ", "name", "two words"),
    ],
)
def test_drives(key: str, value: Any, field: str, expected: Any) -> None:
    (drive,) = read_spec(changed(**{f"drive__{key}": value})).drives
    assert (drive.name if field == "name" else drive.choices[field]) == expected


_SIZES = ("amplitude_mm", "stroke_mm", "setting_percent", "along_amplitude_mm", "normal_amplitude_mm")
_MACHINE = {"kind": "unbalance", "vibrating_mass_kg": 120, "motors": 2, "static_moment_kg_mm": 95}
_OVAL = {"along_amplitude_mm": 0.2, "normal_amplitude_mm": 0.1, "normal_phase_deg": 0, "frequency_hz": 50}
_SERVO = {"along_steps": [[0.8, 1.5], [0.2, -6]], "motion_scale": 1, "frequency_hz": 2}
_LINE = {"frequency_hz": 50, "drive_angle_deg": 20}
_WAYS = (
    {"amplitude_mm": 0.2, **_LINE}, {"stroke_mm": 0.4, **_LINE}, _OVAL, _SERVO,
    {**_MACHINE, "setting_percent": 80, **_LINE},
)  # fmt: skip


@given(st.data())
def test_a_number_alone_means_what_the_answer_says_and_a_word_says_the_same(data: st.DataObject) -> None:
    """At most of amplitudes, strokes and settings of a drive, exactly of all else that may be chosen."""
    way: Any = data.draw(st.sampled_from(_WAYS))
    key = data.draw(
        st.sampled_from([key for key in way if isinstance(way[key], int | float) and key not in _MACHINE])
    )
    number = float(f"{way[key] * data.draw(st.floats(0.5, 1.5)):.{data.draw(st.integers(2, 12))}g}")

    def read(value: Any, **more: Any) -> Drive:
        return read_spec({**GOOD, "drive": [{**way, key: value, **more}]}).drives[0]

    alone = read(number)
    usual = "at most" if key in ("amplitude_mm", "stroke_mm", "setting_percent") else "exactly"
    space, case = data.draw(st.sampled_from([" ", "  "])), data.draw(st.sampled_from([str.upper, str.lower]))
    worded = f"{case(usual)}{space}{number!r}"
    assert alone.choices == read(worded).choices
    assert read(f"exactly {number!r}").choices == read(f"{number!r}:{number!r}").choices
    if key in _SIZES:
        assert read(f"at most {number!r}").choices == read(f"0:{number!r}").choices
    # what the answer says of every quantity is a file's text, and means the same
    assert alone.chosen_from[key] == f"{usual} {number:.15g}"
    for drive in (
        alone,
        read(f"{0.5 * number!r}:{number!r}"),
        read(f"exactly {number!r}", acceleration_g=1e6),
    ):
        said = {**way, **drive.chosen_from}
        back = read_spec({**GOOD, "drive": [said]}).drives[0]
        assert back.chosen_from == drive.chosen_from
        for name, ranges in drive.choices.items():
            np.testing.assert_allclose(back.choices[name], ranges, rtol=1e-14)


def test_limits_may_be_said_in_words() -> None:
    plain = changed(drive__acceleration_g=4, goal__speed_mm_s=80, goal__impact_speed_mm_s=100)
    words = {"drive__acceleration_g": "at most 4", "goal__speed_mm_s": "at least 4.8m/min"}
    assert read_spec(changed(**words, goal__impact_speed_mm_s="at most 0.1m/s")) == read_spec(plain)


def test_a_traverse_time_is_a_speed() -> None:
    goal = {"traverse_time_s": "15s"}
    assert read_spec(changed(goal=goal, scene__trough_length_mm=1200)).goal.speed == 0.08


@each(
    ("text", "own", "static", "kinetic"),
    [
        ("steel on steel, dry, lust", None, (0.12, 0.6), (0.08, 0.5)),
        ("Wood on steel", None, (0.45, 0.75), (0.3, 0.6)),
        ("steel on steel, dry, safety nut", "0.5:0.6", (0.74, 0.74), (0.5, 0.6)),
        ("brass on steel, dry, autodesk", 0.3, (0.35, 0.35), (0.3, 0.3)),
    ],
)
def test_friction_of_the_catalogue(text: str, own: Any, static: Any, kinetic: Any) -> None:
    entries = {"scene__static_friction": text, "scene__friction_ratio": None, "scene__kinetic_friction": own}
    bands = read_spec(changed(**entries)).bands
    assert bands == {"static_friction": static, "kinetic_friction": kinetic, "trough_angle": (0.0, 0.0)}


@pytest.mark.parametrize(
    ("text", "is_scene"),
    [
        ("[scene]\nstatic_friction = 0.3\n[map]\n", True),
        ("[scene]\nstatic_friction = 0.3\namplitude_mm = 1\n", True),
        ("[scene]\nstatic_friction = 0.3\namplitude_mm = 1\n[goal]\n", False),  # as near to either
        ("[scene]\nstatic_friction = 0.3\n", True),
    ],
)
def test_a_scene_is_told_from_a_question(tmp_path: Path, text: str, is_scene: bool) -> None:
    path = tmp_path / "nut.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as wrong:
        read_spec(path)
    assert ("vibro.read_scene " in wrong.value.hint) is is_scene


SPAN = st.tuples(st.floats(0.2, 1.0), st.floats(0.2, 1.0)).map(sorted)


@given(SPAN, SPAN, st.lists(st.floats(1.0, 100.0), min_size=1, max_size=4, unique=True).map(sorted))
def test_numbers_are_read_to_the_last_digit(
    static: list[float], ratio: list[float], frequencies: list[float]
) -> None:
    spec = read_spec(
        changed(
            scene__static_friction="{!r}:{!r}".format(*static),
            scene__friction_ratio="{!r}:{!r}".format(*ratio),
            drive__frequency_hz=json.dumps(frequencies)[1:-1] if len(frequencies) > 1 else frequencies,
        )
    )
    assert spec.bands["static_friction"] == tuple(static)
    assert spec.bands["friction_ratio"] == tuple(ratio)
    assert [low for low, _ in spec.drives[0].frequency] == frequencies


def test_the_larger_amplitude_of_an_ellipse_makes_its_least_acceleration() -> None:
    drive = {"along_amplitude_mm": "0.2:3", "normal_amplitude_mm": 1, "frequency_hz": 25, "acceleration_g": 2}
    with pytest.raises(InputError, match=r"acceleration_g = 2: .* 2\.515"):
        read_spec({**GOOD, "drive": [drive]})
    assert read_spec({**GOOD, "drive": [{**drive, "acceleration_g": 2.52}]}).drives[0].acceleration == 2.52


def problem_of(**entries: Any) -> str:
    """Return what is said of a question; empty where it is good."""
    try:
        read_spec(changed(**entries))
    except InputError as exc:
        return str(exc)
    return ""


@each(
    ("entries", "refused"),
    [
        # parts of mu_s = 1 slide down 45 deg: the least friction and the steepest trough count, either way
        ({"scene__static_friction": "1:2", "scene__trough_angle_deg": -45}, "45 deg"),
        ({"scene__static_friction": "1:2", "scene__trough_angle_deg": -44.99999}, ""),
        ({"scene__static_friction": "1:2", "scene__trough_angle_deg": "-45:0"}, "45 deg"),
        (
            {"scene__static_friction": "1:2", "scene__trough_angle_deg": -44, "drift__trough_angle_deg": 1},
            "45 deg",
        ),
        (
            {
                "scene__static_friction": "1:2",
                "scene__trough_angle_deg": -44,
                "drift__trough_angle_deg": 0.99,
            },
            "",
        ),
        # drive, trough and both drifts reach the normal
        ({"drive__drive_angle_deg": "10:80", "scene__trough_angle_deg": "0:10"}, "90 deg"),
        ({"drive__drive_angle_deg": "10:80", "scene__trough_angle_deg": "0:9.99999"}, ""),
        (
            {"drive__drive_angle_deg": 79, "scene__trough_angle_deg": "-1:10", "drift__drive_angle_deg": 1},
            "90 deg",
        ),
        (
            {"drive__drive_angle_deg": 79, "scene__trough_angle_deg": "-1:10", "drift__trough_angle_deg": 1},
            "90 deg",
        ),
        ({"drive__drive_angle_deg": 79, "scene__trough_angle_deg": "-1:9", "drift__trough_angle_deg": 1}, ""),
        ({"drive__drive_angle_deg": [20, 80], "scene__trough_angle_deg": 10}, "90 deg"),
    ],
)
def test_angles_end_just_where_parts_slide_or_the_normal_is_reached(entries: Any, refused: str) -> None:
    said = problem_of(**({"scene__static_friction": "0.5:0.6"} | entries))
    assert refused in said
    assert bool(said) is bool(refused)


@each("gravity", [9.81, 1.62])
@each(("factor", "refused"), [(1.0, False), (1.0 - 1e-12, True), (1.0 + 1e-12, False)])
def test_an_acceleration_may_be_the_least_of_the_drive(gravity: float, factor: float, refused: bool) -> None:
    drive = {"amplitude_mm": "0.8:2", "frequency_hz": [20, 50], "drive_angle_deg": 20}
    spec = read_spec(changed(drive=[drive], scene__gravity_m_s2=gravity))
    least = spec.drives[0].accelerations[0] / gravity
    assert least == pytest.approx(0.8e-3 * (2 * math.pi * 20) ** 2 / gravity)
    said = problem_of(drive=[{**drive, "acceleration_g": least * factor}], scene__gravity_m_s2=gravity)
    assert (f" {least:.6g}" in said) is refused
    assert bool(said) is refused


@pytest.mark.parametrize(("share", "refused"), [(0.999, False), (1.001, True)])
def test_accelerations_end_at_a_thousand_million(share: float, refused: bool) -> None:
    amplitude = share * 1e9 * 9.81 / (2 * math.pi * 1e4) ** 2 * 1e3
    said = problem_of(drive=[{"amplitude_mm": amplitude, "frequency_hz": 10000, "drive_angle_deg": 20}])
    assert ("must be at most 1e+09 g" in said) is refused
    assert bool(said) is refused


@each(("kinetic", "refused"), [("0.5:0.6", False), ("0.51:0.6", True), (0.5, False)])
def test_kinetic_friction_may_begin_at_the_largest_static_friction(kinetic: Any, refused: bool) -> None:
    scene = {"static_friction": "0.3:0.5", "kinetic_friction": kinetic}
    said = problem_of(scene=scene)
    assert ("kinetic_friction" in said and "which is at most 0.5" in said) is refused
    assert bool(said) is refused


def test_drives_without_a_name_are_counted_and_several_are_told_apart() -> None:
    drive = {"amplitude_mm": 0.8, "frequency_hz": 50, "drive_angle_deg": 20}
    assert [d.name for d in read_spec(changed(drive=[drive, drive, drive])).drives] == [
        "drive 1",
        "drive 2",
        "drive 3",
    ]
    bad = {**drive, "amplitude_mm": -1}
    assert "[[drive]] amplitude_mm = -1" in problem_of(drive=[bad])
    assert "[[drive]] 2 amplitude_mm = -1" in problem_of(drive=[drive, bad])


def test_the_name_of_a_question_is_that_of_its_file(tmp_path: Path) -> None:
    path = tmp_path / "feeder.one.toml"
    path.write_text(FEEDER, encoding="utf-8")
    assert read_spec(path).name == read_spec(str(path)).name == "feeder.one"
    assert read_spec(changed()).name == ""
    path.write_text(FEEDER.replace("speed_mm_s = 80", "speed_mm_s = -80"), encoding="utf-8")
    with pytest.raises(InputError) as told:
        read_spec(path)
    assert str(told.value).startswith(f"{path}: ")


def test_the_docs_show_a_question(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "guide" / "design.md").read_text(encoding="utf-8")
    path = tmp_path / "feeder.toml"
    path.write_text(page.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    assert [drive.name for drive in read_spec(path).drives] == ["magnet", "motor"]
