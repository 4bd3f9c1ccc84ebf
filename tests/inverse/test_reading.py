"""Questions of inverse design: read exactly, or refused with table, key, value and remedy, all at once."""

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
from vibro.drives import Line
from vibro.errors import FileError, InputError
from vibro.inverse.reading import read_spec
from vibro.inverse.specs import Drift, Drive, Goal, Span, Spec
from vibro.quantities import QUANTITIES


def deg(angle: float) -> float:
    return float(QUANTITIES["drive_angle"].to_si(angle))


def refusal(content: Any) -> InputError:
    with pytest.raises(InputError) as caught:
        read_spec(content)
    return caught.value


def line(
    name: str, amplitude: Span, frequency: Any, drive_angle: Any, acceleration: float = math.inf
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
        ("frequency_hz", (50, "3000rpm", 60), None, "must ascend and differ"),
        ("frequency_hz", np.array([50, 60]), "frequency", ((50.0, 50.0), (60.0, 60.0))),
        ("frequency_hz", "15:15", "frequency", ((15.0, 15.0),)),
        ("drive_angle_deg", 0, "drive_angle", ((0.0, 0.0),)),
        ("name", " two words ", "name", "two words"),
    ],
)
def test_drives(key: str, value: Any, field: str | None, expected: Any) -> None:
    content = changed(**{f"drive__{key}": value})
    if field is None:
        assert expected in str(refusal(content))
    else:
        (drive,) = read_spec(content).drives
        assert (drive.name if field == "name" else drive.choices[field]) == expected


def test_a_single_drive_may_be_a_table_of_its_own() -> None:
    assert read_spec(changed(drive=GOOD["drive"][0])) == read_spec(GOOD)


def test_a_traverse_time_is_a_speed() -> None:
    goal = {"traverse_time_s": "15s"}
    assert read_spec(changed(goal=goal, scene__trough_length_mm=1200)).goal.speed == 0.08


@each(
    ("text", "own", "static", "kinetic"),
    [
        ("steel on steel, dry, lust", None, (0.12, 0.6), (0.08, 0.5)),
        ("Wood on steel", None, (0.45, 0.75), (0.3, 0.6)),
        ("steel on steel, dry, safety nut", "0.5:0.6", (0.74, 0.74), (0.5, 0.6)),
        ("brass on steel, dry", 0.3, (0.35, 0.35), (0.3, 0.3)),
    ],
)
def test_friction_of_the_catalogue(text: str, own: Any, static: Any, kinetic: Any) -> None:
    entries = {"scene__static_friction": text, "scene__friction_ratio": None, "scene__kinetic_friction": own}
    bands = read_spec(changed(**entries)).bands
    assert bands == {"static_friction": static, "kinetic_friction": kinetic, "trough_angle": (0.0, 0.0)}


def test_a_ratio_of_ones_own_replaces_the_kinetic_friction_of_the_catalogue() -> None:
    bands = read_spec(changed(scene__static_friction="wood on steel")).bands
    assert set(bands) == {"static_friction", "friction_ratio", "trough_angle"}


BAND = 'must be a finite number or a band "lo:hi"'
BAD: list[tuple[dict[str, Any], str, str]] = [
    # what is no band
    ({"scene__static_friction": "0.3,0.5"}, f"[scene] static_friction = '0.3,0.5': {BAND}", "no list"),
    ({"scene__static_friction": [0.3, 0.5]}, f"[scene] static_friction = [0.3, 0.5]: {BAND}", "no list"),
    ({"scene__friction_ratio": "0.3:0.5:7"}, f"friction_ratio = '0.3:0.5:7': {BAND}", "or count"),
    ({"scene__friction_ratio": "0.3:0.5:step=0.1"}, BAND, "count"),
    ({"scene__friction_ratio": "0.3:0.5:log"}, BAND, "count"),
    ({"scene__static_friction": "0.3:"}, f"'0.3:': {BAND}", ""),
    ({"scene__static_friction": ":"}, BAND, ""),
    ({"scene__static_friction": ""}, "static_friction = '': not a number", "write it like 0.5"),
    ({"scene__static_friction": "0,3"}, f"static_friction = '0,3': {BAND}", "decimals have a point"),
    ({"scene__static_friction": True}, f"static_friction = True: {BAND}", ""),
    ({"scene__static_friction": math.nan}, f"static_friction = nan: {BAND}", ""),
    ({"scene__static_friction": "inf"}, "static_friction = inf: must be a finite number", ""),
    ({"scene__static_friction": "0.3:nan"}, "static_friction = nan: must be a finite number", ""),
    ({"scene__static_friction": {}}, f"static_friction = {{}}: {BAND}", ""),
    ({"scene__static_friction": 10**400}, f"about 401 digits: {BAND}", ""),
    ({"scene__static_friction": "0.5:0.3"}, "static_friction = '0.5:0.3': must be lo:hi with lo", "lower"),
    ({"scene__trough_angle_deg": "-1:-2"}, "[scene] trough_angle_deg = '-1:-2': must be lo:hi", "is in deg"),
    ({"scene__static_friction": "0.3:0.5mm"}, "'mm' is no unit of static friction", "pure number"),
    # what a quantity may not be
    ({"scene__static_friction": "0:0.5"}, "static_friction = '0:0.5': must be finite and > 0", ""),
    ({"scene__static_friction": -0.3}, "static_friction = -0.3: must be finite and > 0", ""),
    ({"scene__friction_ratio": "0.7:1.1"}, "friction_ratio = '0.7:1.1': must be in [0, 1]", ""),
    ({"scene__friction_ratio": "-0.1:1"}, "friction_ratio = '-0.1:1': must be in [0, 1]", ""),
    ({"scene__trough_angle_deg": 90}, "trough_angle_deg = 90: must be in (-90, 90) deg", ""),
    ({"scene__gravity_m_s2": 0}, "gravity_m_s2 = 0: must be finite and > 0 m/s^2", ""),
    ({"scene__gravity_m_s2": "9:10"}, "gravity_m_s2 = '9:10': not a number", ""),
    ({"scene__restitution": 1}, "restitution = 1: must be in [0, 1)", ""),
    ({"scene__trough_length_mm": -1}, "trough_length_mm = -1: must be finite and > 0 mm", ""),
    ({"drive__amplitude_mm": 0}, "[[drive]] amplitude_mm = 0: must be finite and > 0 mm", ""),
    ({"drive__amplitude_mm": "-1:1"}, "amplitude_mm = '-1:1': must be finite and > 0 mm", ""),
    ({"drive__amplitude_mm": "0:0"}, "amplitude_mm = '0:0': must be finite and > 0 mm", ""),
    ({"drive__amplitude_mm": [0.1, 0.8]}, 'the largest, or a range "lo:hi"', "no list"),
    ({"drive__amplitude_mm": "100:800um"}, "amplitude_mm = '100:800um': must be lo:hi", "an end is in mm"),
    ({"drive__frequency_hz": "15:25:5"}, "frequency_hz = '15:25:5': must be a finite number, a", "count"),
    ({"drive__frequency_hz": []}, "frequency_hz = []: must be a finite number, a list, or a range", ""),
    ({"drive__frequency_hz": [50, True]}, "frequency_hz = True: must be a finite number, a list, or", ""),
    ({"drive__frequency_hz": [[50]]}, "frequency_hz = [50]: must be a finite number", ""),
    ({"drive__frequency_hz": [60, 50]}, "frequency_hz = [60, 50]: the values of a list must ascend", ""),
    ({"drive__frequency_hz": "60,50"}, "frequency_hz = '60,50': the values of a list must", "write 50,60"),
    ({"drive__frequency_hz": "0,5"}, "frequency_hz = '0,5': a decimal comma", "write 0.5"),
    ({"drive__frequency_hz": "0:50"}, "frequency_hz = '0:50': must be finite and > 0 Hz", ""),
    ({"drive__drive_angle_deg": "10:90"}, "drive_angle_deg = '10:90': must be in [0, 90) deg", ""),
    ({"drive__acceleration_g": 0}, "acceleration_g = 0: must be finite and > 0 g", ""),
    ({"drive__acceleration_g": "1:4"}, "acceleration_g = '1:4': not a number", ""),
    ({"drive__name": ""}, "[[drive]] name = '': must be a text on one line", ""),
    ({"drive__name": 3}, "[[drive]] name = 3: must be a text", ""),
    ({"drive__name": "a\x1b[31m"}, "must be a text on one line", ""),
    ({"drift__amplitude_percent": 100}, "[drift] amplitude_percent = 100: must be in [0, 100) %", ""),
    ({"drift__frequency_percent": -1}, "frequency_percent = -1: must be in [0, 100) %", ""),
    ({"drift__drive_angle_deg": -1}, "[drift] drive_angle_deg = -1: must be in [0, 90) deg", ""),
    ({"drift__trough_angle_deg": "1,2"}, "trough_angle_deg = '1,2': must be a finite number", ""),
    ({"goal__speed_mm_s": 0}, "[goal] speed_mm_s = 0: must be finite and > 0 mm/s", ""),
    ({"goal__highest_regime": "no-slip"}, "[goal] highest_regime = 'no-slip': must be forward-slip", ""),
    ({"goal__highest_regime": 2}, "highest_regime = 2: must be forward-slip", ""),
    ({"goal__flight_fraction": 0}, "flight_fraction = 0: must be in (0, 1]", ""),
    ({"goal__impact_speed_mm_s": math.inf}, "impact_speed_mm_s = inf: must be a finite number", ""),
    # what does not fit together
    (
        {"goal": {"traverse_time_s": 9}},
        "[goal] traverse_time_s = 9: needs trough_length_mm in [scene]",
        "[scene] for example: trough_length_mm = 1200",
    ),
    (
        {"goal__traverse_time_s": 9, "scene__trough_length_mm": 100},
        "[goal] gives both speed_mm_s and traverse_time_s",
        "give speed_mm_s or traverse_time_s",
    ),
    (
        {"goal": {"traverse_time_s": 1e-300}, "scene__trough_length_mm": 1e300},
        "the length of the trough over it is beyond",
        "",
    ),
    (
        {"scene__kinetic_friction": "0.2:0.3"},
        "[scene] gives both kinetic_friction and friction_ratio",
        "give kinetic_friction or friction_ratio",
    ),
    (
        {"scene__kinetic_friction": "0.6:0.7", "scene__friction_ratio": None},
        "[scene] kinetic_friction = '0.6:0.7': all of it is above static friction, which is at most 0.5",
        "",
    ),
    ({"drive__stroke_mm": 2}, "[[drive]] gives both amplitude_mm and stroke_mm", "give amplitude_mm or"),
    (
        {"scene__trough_angle_deg": "-17:2"},
        "trough_angle_deg: it is up to 17 deg either way, drift included; must be less than 16.6992 deg",
        "",
    ),
    ({"scene__trough_angle_deg": 16, "drift__trough_angle_deg": 1}, "it is up to 17 deg either way", ""),
    (
        {"drive__drive_angle_deg": [20, 75], "scene__trough_angle_deg": "-3:13", "drift__drive_angle_deg": 2},
        "[[drive]] drive_angle_deg = [20, 75]: with the trough and the drifts it is up to 90 deg; must",
        "",
    ),
    (
        {"drive__amplitude_mm": "0.8:1", "drive__frequency_hz": [50, 60], "drive__acceleration_g": 4},
        "[[drive]] acceleration_g = 4: amplitude and frequency are such that it is at least 8.04861",
        "",
    ),
    # what is missing or not known
    ({"scene__static_friction": None}, "[scene] static_friction is missing", '"0.3:0.5"'),
    ({"scene__friction_ratio": None}, "[scene] kinetic_friction or friction_ratio is missing", '"0.7:0.9"'),
    ({"drive__amplitude_mm": None}, "[[drive]] amplitude_mm or stroke_mm is missing", "amplitude_mm = 0.8"),
    ({"drive__frequency_hz": None}, "[[drive]] frequency_hz is missing", 'frequency_hz = "15:25"'),
    ({"drive__drive_angle_deg": None}, "[[drive]] drive_angle_deg is missing", 'drive_angle_deg = "10:40"'),
    ({"goal": {}}, "[goal] speed_mm_s or traverse_time_s is missing", "speed_mm_s = 80"),
    ({"part__half_base_mm": 1}, "[part] centre_height_mm is missing", "centre_height_mm = 8"),
    ({"drive": []}, "[[drive]] is missing", "[[drive]] for example: amplitude_mm = 0.8, frequency_hz"),
    ({"drive": 4}, "drive = 4: must be a table, written [[drive]]", ""),
    ({"goal": [{"speed_mm_s": 1}]}, "goal = [{'speed_mm_s': 1}]: must be a table, written [goal]", ""),
    ({"scene__trough_angl_deg": 1}, "unknown key 'trough_angl_deg'; did you mean 'trough_angle_deg'?", ""),
    ({"drive__xyzzy": 1}, "[[drive]] unknown key 'xyzzy'; known are name, amplitude_mm, stroke_mm, ", ""),
    ({"scene__amplitude_mm": 1}, "[scene] unknown key 'amplitude_mm'; it belongs in [[drive]]", ""),
    ({"scene__frequency_hz": 1}, "[scene] unknown key 'frequency_hz'; it belongs in [[drive]]", ""),
    ({"scene__drive_angle_deg": 1}, "unknown key 'drive_angle_deg'; it belongs in [[drive]] or [drift]", ""),
    ({"goals": {}}, "unknown table 'goals'; did you mean 'goal'?", ""),
    ({"speed_mm_s": 1}, "unknown key 'speed_mm_s'; it belongs in [goal]", ""),
    # the catalogue
    ({"scene__static_friction": "steel on steel, dry"}, "static_friction = 'steel on steel, dry': 4", "Lust"),
    ({"scene__static_friction": "steel on nylon"}, "= 'steel on nylon': no such pair", "'steel on steel'"),
    ({"scene__static_friction": "polyamide on steel"}, "has no static friction for it", ""),
    (
        {"scene__static_friction": "brass on steel", "scene__friction_ratio": None},
        "[scene] static_friction = 'brass on steel': the catalogue has no kinetic friction of it",
        "give kinetic_friction or friction_ratio too",
    ),
]  # fmt: skip


@each(("entries", "problem", "hint"), BAD)
def test_what_is_wrong_is_named(entries: dict[str, Any], problem: str, hint: str) -> None:
    caught = refusal(changed(**entries))
    assert problem in caught.problems[0]
    assert hint in caught.hint
    extra = [text for text in caught.problems[1:] if " is missing" not in text]
    assert extra == []


def test_drives_of_one_name_are_refused() -> None:
    drive = {**GOOD["drive"][0], "name": "drive 2"}
    caught = refusal(changed(drive=[drive, GOOD["drive"][0]]))
    assert caught.problems == ("[[drive]] name = 'drive 2': 2 drives have it",)
    assert caught.hint == "give each drive its own name"


def test_everything_is_named_at_once_with_the_file(tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(
        '[scene]\nstatic_friction = [0.3, 0.5]\nspeed = 1\n'
        '[[drive]]\namplitude_mm = 1\nfrequency_hz = 50\ndrive_angle_deg = "10:40"\n'
        '[[drive]]\namplitude_mm = 1\nfrequency_hz = true\n'
        "[goal]\nspeed_mm_s = 0\n[drift]\namplitude_percent = -5\n"
    )  # fmt: skip
    caught = refusal(path)
    assert all(problem.startswith(f"{path}: ") for problem in caught.problems)
    assert [problem.removeprefix(f"{path}: ").split(":")[0] for problem in caught.problems] == [
        "[scene] static_friction = [0.3, 0.5]",
        "[scene] unknown key 'speed'; known are static_friction, kinetic_friction, friction_ratio, "
        "trough_angle_deg, trough_length_mm, gravity_m_s2, restitution",
        "[drift] amplitude_percent = -5",
        "[goal] speed_mm_s = 0",
        "[[drive]] 2 frequency_hz = True",
        "[scene] kinetic_friction or friction_ratio is missing",
        "[[drive]] 2 drive_angle_deg is missing",
    ]  # fmt: skip


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "feeder.toml").write_text(FEEDER, encoding="utf-8")
    with pytest.raises(FileError, match="cannot read") as caught:
        read_spec(tmp_path / "feder.toml")
    assert caught.value.hint == f"did you mean '{tmp_path / 'feeder.toml'}'?"
    (tmp_path / "comma.toml").write_text("[goal]\nspeed_mm_s = 0,5\n")
    wrong = refusal(str(tmp_path / "comma.toml"))
    assert "not valid TOML" in str(wrong)
    assert wrong.hint == "write a decimal point: speed_mm_s = 0.5"


@pytest.mark.parametrize(
    ("text", "is_scene"),
    [
        ("[scene]\nstatic_friction = 0.3\n[map]\n", True),
        ("[scene]\nstatic_friction = 0.3\namplitude_mm = 1\n", True),
        ("[scene]\nstatic_friction = 0.3\namplitude_mm = 1\n[goal]\n", False),  # as near to either
        ("[scene]\nstatic_friction = 0.3\n", False),
    ],
)
def test_a_scene_is_told_from_a_question(tmp_path: Path, text: str, is_scene: bool) -> None:
    path = tmp_path / "nut.toml"
    path.write_text(text, encoding="utf-8")
    wrong = refusal(path)
    told = f"{path}: this is a scene of vibro: a drive, a trough and a part"
    assert (wrong.problems == (told,)) is is_scene
    assert (wrong.hint == f'run vibro.read_scene("{path}")') is is_scene


@each("source", [None, 3, ["a"], b"feeder.toml"])
def test_a_source_that_is_no_path_and_no_mapping(source: Any) -> None:
    assert "must be a path, or a mapping with the tables of a question" in str(refusal(source))


def test_keys_that_are_no_texts() -> None:
    caught = refusal({**GOOD, 1: 2, "goal": {None: 1, 10**5000: 1, "speed_mm_s": 1}})
    assert [text.split(";")[0] for text in caught.problems] == [
        "unknown key 1", "[goal] unknown key None", "[goal] unknown key a whole number of about 5001 digits",
    ]  # fmt: skip


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


def test_the_docs_show_a_question(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "guide" / "design.md").read_text(encoding="utf-8")
    path = tmp_path / "feeder.toml"
    path.write_text(page.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    assert [drive.name for drive in read_spec(path).drives] == ["magnet", "motor"]


@each(
    "drive",
    [{"amplitude_mm": 1e300}, {"amplitude_mm": 1e12}, {"frequency_hz": 1e200}, {"frequency_hz": "1:1e9"}],
)
def test_drives_beyond_every_machine_are_refused(drive: dict[str, Any]) -> None:
    said = str(refusal(changed(**{f"drive__{key}": value for key, value in drive.items()})))
    assert "frequency_hz = " in said
    assert "must be at most 1e+09 g" in said


def test_the_larger_amplitude_of_an_ellipse_makes_its_least_acceleration() -> None:
    drive = {"along_amplitude_mm": "0.2:3", "normal_amplitude_mm": 1, "frequency_hz": 25, "acceleration_g": 2}
    said = str(refusal({**GOOD, "drive": [drive]}))
    assert "amplitude and frequency are such that it is at least 2.515" in said
    assert read_spec({**GOOD, "drive": [{**drive, "acceleration_g": 2.52}]}).drives[0].acceleration == 2.52


@pytest.mark.parametrize(("drift", "is_refused"), [(5.9, False), (6.1, True)])
def test_the_drift_of_the_trough_counts_before_the_right_angle(drift: float, is_refused: bool) -> None:
    content = changed(
        scene__static_friction=2.0, scene__trough_angle_deg=4.0, drive__drive_angle_deg=80.0,
        drift={"trough_angle_deg": drift},
    )  # fmt: skip
    if is_refused:
        assert "with the trough and the drifts it is up to 90.1 deg" in str(refusal(content))
    else:
        assert read_spec(content).drift.trough_angle == deg(drift)


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
        ({"scene__static_friction": "1:2", "scene__trough_angle_deg": -45}, "must be less than 45 deg"),
        ({"scene__static_friction": "1:2", "scene__trough_angle_deg": -44.99999}, ""),
        (
            {"scene__static_friction": "1:2", "scene__trough_angle_deg": "-45:0"},
            "it is up to 45 deg either way",
        ),
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
        ({"drive__drive_angle_deg": "10:80", "scene__trough_angle_deg": "0:10"}, "up to 90 deg"),
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
    assert (f"amplitude and frequency are such that it is at least {least:.6g}" in said) is refused
    assert bool(said) is refused


@pytest.mark.parametrize(("share", "refused"), [(0.999, False), (1.001, True)])
def test_accelerations_end_at_a_thousand_million(share: float, refused: bool) -> None:
    amplitude = share * 1e9 * 9.81 / (2 * math.pi * 1e4) ** 2 * 1e3
    said = problem_of(drive=[{"amplitude_mm": amplitude, "frequency_hz": 10000, "drive_angle_deg": 20}])
    assert ("must be at most 1e+09 g" in said) is refused
    assert bool(said) is refused


def test_an_acceleration_of_a_thousand_million_is_allowed() -> None:
    """To the last bit, by a gravity made for it."""
    drive = {"amplitude_mm": 1, "frequency_hz": 50, "drive_angle_deg": 20}
    most = read_spec(changed(drive=[drive])).drives[0].accelerations[1]
    gravity = most / 1e9
    assert most / gravity == 1e9
    assert problem_of(drive=[drive], scene__gravity_m_s2=gravity) == ""
    assert "must be at most 1e+09 g" in problem_of(drive=[drive], scene__gravity_m_s2=gravity * (1 - 1e-15))


@each(("kinetic", "refused"), [("0.5:0.6", False), ("0.51:0.6", True), (0.5, False)])
def test_kinetic_friction_may_begin_at_the_largest_static_friction(kinetic: Any, refused: bool) -> None:
    scene = {"static_friction": "0.3:0.5", "kinetic_friction": kinetic}
    said = problem_of(scene=scene)
    assert ("kinetic_friction" in said and "which is at most 0.5" in said) is refused
    assert bool(said) is refused


@each(("names", "said"), [(("a", "a"), "2 drives"), (("a", "a", "a"), "3 drives"), (("a", "b"), "")])
def test_every_drive_has_its_own_name(names: tuple[str, ...], said: str) -> None:
    drive = {"amplitude_mm": 0.8, "frequency_hz": 50, "drive_angle_deg": 20}
    assert said in (found := problem_of(drive=[{**drive, "name": name} for name in names]))
    assert bool(found) is bool(said)


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


def test_a_stroke_is_two_amplitudes_and_a_stand_ratio_half_base_over_height() -> None:
    drive = {"stroke_mm": "1:6", "frequency_hz": 50, "drive_angle_deg": 20}
    spec = read_spec(changed(drive=[drive], part={"half_base_mm": 6, "centre_height_mm": 8}))
    assert spec.drives[0].span("amplitude") == pytest.approx((0.5e-3, 3e-3))
    assert spec.stand_ratio == 0.75
    assert read_spec(changed()).bands["trough_angle"] == (0.0, 0.0)


def test_the_name_of_a_question_is_that_of_its_file(tmp_path: Path) -> None:
    path = tmp_path / "feeder.one.toml"
    path.write_text(FEEDER, encoding="utf-8")
    assert read_spec(path).name == read_spec(str(path)).name == "feeder.one"
    assert read_spec(changed()).name == ""
    path.write_text(FEEDER.replace("speed_mm_s = 80", "speed_mm_s = -80"), encoding="utf-8")
    with pytest.raises(InputError) as told:
        read_spec(path)
    assert str(told.value).startswith(f"{path}: [goal] speed_mm_s = -80")
