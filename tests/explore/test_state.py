"""What stands in the page's address, and what becomes of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from helpers.cases import each
from helpers.packed import GIVEN_DRIVES

from vibro.errors import InputError
from vibro.explore.controls import CONTROLS, DRIVES, PRESETS, VIEWS
from vibro.explore.state import HEIGHT, WIDTH, State, initial_state, read_state, typed_number
from vibro.files.scene_files import read_scene_file
from vibro.quantities import QUANTITIES, SWEPT
from vibro.scene import Scene
from vibro.sweeps.request import RANGES, gather
from vibro.sweeps.whole import read_scene, request_of_call

INITIAL = initial_state()
EXAMPLES = Path(__file__).parents[2] / "examples"
SCENES = sorted(path for path in EXAMPLES.glob("*.toml") if not path.stem.startswith("design"))


def changed(**query: str) -> State:
    return read_state(query, INITIAL)


def wrong(**query: str) -> dict[str, str]:
    with pytest.raises(InputError) as caught:
        changed(**query)
    return dict(zip(caught.value.fields, caught.value.problems, strict=True))


def test_it_begins_with_the_nut_of_the_example() -> None:
    request = request_of_call(EXAMPLES / "safety_nut.toml", {})
    assert initial_state(request).texts == INITIAL.texts
    assert (INITIAL.texts["x"], INITIAL.texts["y"]) == ("frequency_hz", "amplitude_mm")  # as in pictures


@each("drive", DRIVES)
@each("view", VIEWS)
def test_texts_say_all_of_a_state(drive: str, view: str) -> None:
    state = changed(drive=drive, view=view, frequency_hz="33.3", target="12", cycles="7")
    assert read_state(state.texts, INITIAL) == state
    assert read_state(state.texts, state) == state
    frictions = {"static_friction": 0.4, "kinetic_friction": 0.2}
    other = request_of_call(None, {"amplitude_mm": 3, "frequency_hz": 9, "drive_angle_deg": 3, **frictions})
    assert read_state(state.texts, initial_state(other)).texts == state.texts


def test_numbers_may_have_units_and_come_back_as_they_are_typed() -> None:
    texts = changed(
        amplitude_mm=" 800um", frequency_hz="900rpm", drive_angle_deg="0.5rad", target="2cm/s"
    ).texts
    assert (texts["amplitude_mm"], texts["frequency_hz"], texts["target"]) == ("0.8", "15", "20")
    assert float(texts["drive_angle_deg"]) == float(np.degrees(0.5))
    assert changed(x_range="100um:3", x="amplitude_mm", y="frequency_hz").texts["x_range"] == "0.1:3"


@each("value", [0.1, 1 / 3, 1e-300, 5e-324, 1.7976931348623157e308, 123456789.123456789])
def test_a_number_is_read_as_it_was(value: float) -> None:
    assert float(typed_number(value)) == value
    assert len(typed_number(0.1 + 0.2)) > len(typed_number(0.3))


def test_the_map_has_the_cells_that_its_axes_say() -> None:
    grid = changed(x_range="5:60:log", drive_angle_deg="25").grid()
    assert grid.shape == (HEIGHT, WIDTH)
    assert [(axis.name, axis.spacing) for axis in grid.axes.values()] == [
        ("amplitude", "linear"),
        ("frequency", "log"),
    ]
    assert grid.fixed["drive_angle"] == 25.0
    assert grid.fixed["kinetic_friction"] == 0.57


def test_kinetic_friction_follows_an_axis_of_static_friction() -> None:
    follows = changed(x="static_friction").grid()
    assert follows.fixed["friction_ratio"] == 0.57 / 0.74
    assert "kinetic_friction" not in follows.fixed
    stays = changed(x="static_friction", follow="0").grid()
    assert stays.fixed["kinetic_friction"] == 0.57
    ratio = changed(x="friction_ratio").grid()
    assert not ratio.fixed.keys() & {"kinetic_friction", "friction_ratio"}
    both = changed(x="static_friction", y="kinetic_friction").grid()
    assert {*both.axes} == {"static_friction", "kinetic_friction"}


def test_a_drive_without_friction_has_a_ratio() -> None:
    still = changed(static_friction="0", kinetic_friction="0", x="static_friction", x_range="0:1")
    assert still.grid().fixed["friction_ratio"] == 1.0


@each(
    ("query", "field", "said"),
    [
        ({"amplitude_mm": "-1"}, "amplitude_mm", "amplitude = -1 mm: must be in "),
        ({"amplitude_mm": "1:2"}, "amplitude_mm", "it takes one value"),
        ({"kinetic_friction": "0.8"}, "kinetic_friction", "at most static friction = 0.74"),
        ({"trough_length_mm": "", "view": "traverse"}, "trough_length_mm", "needs the length"),
        ({"drive": "circle"}, "drive", "must be line, ellipse, harmonics"),
        ({"view": "colour"}, "view", "must be regime, speed"),
        ({"follow": "yes"}, "follow", "must be 0, 1"),
        ({"cycles": "21"}, "cycles", "whole number from 1 to 20"),
        ({"x": "gravity_m_s2"}, "x", "no axis of this drive"),
        ({"x": "amplitude_mm"}, "y", "x and y are both amplitude"),
        ({"x": "friction_ratio", "y": "kinetic_friction"}, "y", "describe the same"),
        ({"x_range": "5:6:99"}, "x_range", "must be a range"),
        ({"x_range": "5:5.00000000000001"}, "x_range", "200 values are too close for doubles"),
        ({"x_range": "0:60:log"}, "x_range", "must start above 0"),
        ({"static_friction_band": "0.5:0.3"}, "static_friction_band", "does not ascend"),
        ({"static_friction_band": "0:0.3"}, "static_friction_band", "have no regime"),
        ({"static_friction_band": "1:2", "x": "static_friction"}, "static_friction_band", "cannot have"),
        ({"static_friction_band": "1:2", "drive": "ellipse"}, "static_friction_band", "along a line"),
        ({"friction_ratio_band": "0:1", "kinetic_friction_band": "0:1"}, "friction_ratio_band", "a band too"),
        ({"target": "0"}, "target", "must be in "),
        ({"colour": "red"}, "", "unknown key 'colour'"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_beside_its_field(query: dict[str, str], field: str, said: str) -> None:
    told = wrong(**query)
    assert [*told] == [field]
    assert said in told[field]


def test_all_that_is_wrong_is_told_at_once() -> None:
    assert [*wrong(amplitude_mm="-1", frequency_hz="x")] == ["amplitude_mm", "frequency_hz"]
    assert [*wrong(static_friction_band="3:2", target="0")] == ["static_friction_band", "target"]


def test_axes_go_with_their_drive_and_ranges_with_their_axes() -> None:
    ellipse = changed(drive="ellipse")
    assert {ellipse.texts["x"], ellipse.texts["y"]} <= {QUANTITIES[n].column for n in SWEPT}
    assert changed(x="drive_angle_deg").texts["x_range"] == CONTROLS["drive_angle"].axis
    assert changed(x="drive_angle_deg", x_range="3:4").texts["x_range"] == "3:4"
    assert changed(x="frequency_hz").texts["x_range"] == INITIAL.texts["x_range"]


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_states(name: str) -> None:
    state = changed(**PRESETS[name].state)
    for key, axis in (("x", state.x), ("y", state.y)):
        low, high = (float(end) for end in axis.values)
        assert low < float(state.texts[state.texts[key]]) < high


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_every_scene_of_the_examples_can_be_explored(path: Path) -> None:
    request = gather({}, read_scene_file(path), _Call(), reads_map=True, takes_axes=True, ranges=RANGES)
    state = initial_state(request)
    own = {name: request.own.get(name) for name in request.varying if name != "motion_scale"}
    if None not in own.values():
        assert _same(state.point.scene(), read_scene(path))
    assert len(state.grid().axes) == 2
    assert state.point.name == path.stem
    assert read_state(state.texts, state) == state


def _same(scene: Scene, other: Scene) -> bool:
    """Whether two scenes are the same bit for bit; motions by their accelerations."""
    a, b = scene.arrays().columns(), other.arrays().columns()
    pairs = [*zip(a.fields, b.fields, strict=True), (a.breaks, b.breaks), (a.pieces, b.pieces)]
    return a.kind == b.kind and all(np.array_equal(x, y, equal_nan=True) for x, y in pairs)


def given_state(folder: Path, text: str) -> State:
    file = folder / "given.toml"
    file.write_text(text, encoding="utf-8")
    state = initial_state(request_of_call(file, {}))
    assert _same(state.point.scene(), read_scene(file))
    return state


@pytest.mark.parametrize("name", GIVEN_DRIVES)
def test_a_motion_stays_as_the_scene_gives_it(name: str, tmp_path: Path) -> None:
    initial = given_state(tmp_path, GIVEN_DRIVES[name])
    assert (initial.texts["drive"], initial.x.quantity.name, initial.y.quantity.name) == (
        "given", "frequency", "motion_scale",
    )  # fmt: skip
    assert read_state(initial.texts, initial) == initial
    moved = read_state({"motion_scale": "0.5", "static_friction": "0.6", "frequency_hz": "9"}, initial)
    scene, other = moved.point.scene().arrays(), initial.point.scene().arrays()
    assert (float(scene.frequency), float(scene.static_friction)) == (9.0, 0.6)
    assert np.array_equal(scene.columns().pieces, other.columns().pieces)
    # Another drive has nothing of it, also no clamped part; and back again it is as it was.
    assert not initial.texts.keys() & {"along_amplitude_3_mm"}
    ellipse = read_state(
        {**initial.texts, "trough_angle_deg": "0", "drive": "ellipse", "x": "", "y": ""}, initial
    )
    assert ellipse.point.scene().arrays().kind == "along an ellipse"
    assert "normal_acceleration" not in ellipse.point.specs
    back = {"drive": "given", "x": "", "y": "", "trough_angle_deg": initial.texts["trough_angle_deg"]}
    assert read_state({**ellipse.texts, **back}, initial).texts == initial.texts


def test_a_link_to_another_motion_is_refused(tmp_path: Path) -> None:
    """The address does not hold the motion: it must not show that of another scene file."""
    steps, samples, wave = (
        given_state(tmp_path, GIVEN_DRIVES[name]) for name in ("steps, clamped", "samples", "third harmonic")
    )
    assert len({state.texts["motion"] for state in (steps, samples, wave)}) == 3
    shared = {**samples.texts}
    for other in (steps, wave):
        with pytest.raises(InputError, match="the link is of another motion than that of the scene"):
            read_state(shared, other)
    with pytest.raises(InputError, match="drive = 'given': must be line, ellipse, harmonics"):
        read_state({"drive": "given"}, INITIAL)
    assert read_state(shared, samples) == samples


def test_a_clamped_part_may_hang(tmp_path: Path) -> None:
    hung = given_state(tmp_path, GIVEN_DRIVES["clamped"])
    assert read_state({"x": "trough_angle_deg", "x_range": "-90:90"}, hung).grid().shape == (HEIGHT, WIDTH)
    with pytest.raises(InputError, match=r"trough angle = -90:90: must be in \(-90, 90\) deg"):
        changed(x="trough_angle_deg", x_range="-90:90")


def test_a_new_axis_has_the_operating_point_inside() -> None:
    assert changed(frequency_hz="2.4", x="frequency_hz", y="drive_angle_deg").texts["x_range"] == "5:60"
    slow = {"frequency_hz": "2.4", "x": "drive_angle_deg", "y": "frequency_hz", "y_range": ""}
    assert changed(**slow).texts["y_range"] == "0.8:7.2"
    assert changed(**{**slow, "frequency_hz": "7"}).texts["y_range"] == "5:60"


def test_one_axis_of_a_scene_gets_another_beside_it() -> None:
    state = initial_state(
        request_of_call(
            None,
            {"amplitude_mm": "0.5:2:9", "frequency_hz": 20, "drive_angle_deg": 20, "static_friction": 0.4,
             "friction_ratio": 0.8},
        )
    )  # fmt: skip
    assert (state.texts["x"], state.texts["x_range"], state.texts["y"]) == (
        "amplitude_mm",
        "0.5:2",
        "frequency_hz",
    )
    assert float(state.texts["amplitude_mm"]) == 1.25
    assert state.texts["kinetic_friction"] == "0.32"


class _Call:
    gives = "the call"
    takes_one_value = ("one value", "")

    def axis(self, quantity: object) -> str:
        return ""

    def name(self, quantity: object) -> str:
        return ""

    def example(self, values: object, *, from_scratch: bool) -> str:
        return ""
