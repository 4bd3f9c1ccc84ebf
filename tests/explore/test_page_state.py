"""What the page's script reads from its address: the same numbers as vibro, and messages that help."""

from __future__ import annotations

import random
from typing import TYPE_CHECKING, Any

import pytest
from helpers.cases import each
from helpers.explored_scenes import FEEDER, GIVEN_DRIVES
from helpers.whole_page import in_modules

from vibro.errors import InputError
from vibro.explore.controls import CONTROLS, DRIVES, PRESETS, VIEWS
from vibro.quantities import LEAST_SPEED, QUANTITIES, Quantity, checked_number, exact_number
from vibro.sweeps.whole import request_of_call

if TYPE_CHECKING:
    from collections.abc import Callable

    from vibro.sweeps.request import Request

_ASK = """
export const run = ({ data, ...page }, asked) => asked.map(([name, first, ...others]) => {
  const value = name === "numberIn" ? data.quantities[first] : first === "DATA" ? data : first;
  try {
    return page[name](value, ...others);
  } catch (error) {
    return { thrown: `${error.name}: ${error.message}`, hint: error.hint };
  }
});
"""


@pytest.fixture(scope="module")
def ask(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., list[Any]]:
    """Return what calls functions of the page in node, each given as its name and its arguments."""
    requests: list[Request | None] = [None]
    for number, text in enumerate((GIVEN_DRIVES["clamped"], FEEDER)):
        (file := tmp_path_factory.mktemp("page") / f"{number}.toml").write_text(text, encoding="utf-8")
        requests.append(request_of_call(file, {}))
    return lambda *calls: list(in_modules(_ASK, calls, requests))


def states(ask: Callable[..., list[Any]], *queries: dict[str, str], scene: int = 0) -> list[Any]:
    return ask(*(["stateOf", "DATA", scene, query] for query in queries))


_UNITS = {
    "amplitude": ["", "mm", "um", "µm", "\u03bcm", " cm", "MM", "in", "ft", "m"],
    "frequency": ["", "Hz", "hz", "kHz", "rpm", " U/min", "/min", " 1/min", " u / min"],
    "drive_angle": ["", "deg", "°", "rad", " RAD"],
    "filling": ["", "kg", "g", "mg", "lb"],
    "static_friction": ["", "%", " %"],
    "setting": ["", "%"],
    "gravity": ["", "m/s^2", "m/s2", "m/s²"],
    "speed": ["", "mm/s", "m/min", "in/min", "ft / min", "cm/s"],
}
_DIGITS = [
    "1", "0.3", "1,5", "+7", ".5", "3.", "1e-3", "2E+2", "900", "0,74", "12345678901234567890", "1e-320",
    "4.35e-7", "0.1000000000000000055511151231257827021181583404541015625", "800", "25,4", "\u22123", "-0",
    "0", "1e-400", "33.333333333333336", "16,6667", "1,2345", "123,45", "1" + 40 * "0", "0." + 300 * "3",
]  # fmt: skip
_SLIPS = [
    "", " ", "x", "5e3.5", "1,250", "12,345,678", "12,345", "12,3456", "1,234mm", "1:2", "1 2",
    "5 mm mm", "nan", "inf", "-Infinity", "1e999",
    "0x10", "1_000", "5e", "5 Meter", "--3", "1..2", "5\u00b2", "½", "constructor", 1100 * "9", 99 * "y",
    "1,5,2", "٣", "3%%", "1e", "5/",
]  # fmt: skip


def _read(text: str, quantity: Quantity) -> float | None:
    try:
        return float(exact_number(text, quantity))
    except InputError:
        return None


@each("name", _UNITS)
def test_numbers_are_the_same_doubles_as_vibro_reads(name: str, ask: Callable[..., list[Any]]) -> None:
    quantity = LEAST_SPEED if name == "speed" else QUANTITIES[name]
    chance = random.Random(51)
    drawn = [
        f"{chance.uniform(0.0, 10.0) * 10.0 ** chance.randint(-9, 9):.{chance.randint(1, 17)}g}"
        for _ in range(99)
    ]
    texts = [digits + unit for digits in (*_DIGITS, *drawn) for unit in _UNITS[name]] + _SLIPS
    found = ask(*(["numberIn", name, text] for text in texts))
    for text, value in zip(texts, found, strict=True):
        wanted = _read(text, quantity)
        if wanted is None:
            assert value["thrown"].startswith(("Error: ", "Refusal: "))
            assert value["thrown"].split(": ", 1)[1].startswith(f"{quantity.label} = ")
        else:
            assert float(value) == wanted, text


def test_numbers_are_typed_as_vibro_types_them(ask: Callable[..., list[Any]]) -> None:
    values = [
        0.1,
        1 / 3,
        0.1 + 0.2,
        123456789.123456789,
        1e12,
        1e-12,
        1e15,
        123456.7,
        0.0001,
        0.00001,
        600.0,
        0.0,
    ]
    typed = ask(*(["typedText", value] for value in values))
    assert typed == [f"{v:.15g}" if float(f"{v:.15g}") == v else repr(v) for v in values]
    assert ask(*(["generalText", v, 5] for v in values)) == [f"{v:.5g}" for v in values]


_REFUSED = {
    ("amplitude_mm", "-1"), ("amplitude_mm", "1e10"), ("amplitude_mm", "5kg"), ("frequency_hz", "fast"),
    ("drive_angle_deg", "90"), ("static_friction", "-1%"), ("restitution", "1"), ("target", "0"),
    ("gravity_m_s2", "inf"), ("trough_angle_deg", "-90"), ("trough_length_mm", "x"),
}  # fmt: skip


def test_messages_are_those_of_vibro(ask: Callable[..., list[Any]]) -> None:
    found = states(ask, *({column: text} for column, text in _REFUSED))
    for (column, text), answer in zip(_REFUSED, found, strict=True):
        quantity = next((q for q in QUANTITIES.values() if q.column == column), LEAST_SPEED)
        with pytest.raises(InputError) as caught:
            checked_number(text, quantity)
        wanted = caught.value.problems[0] + f" ({caught.value.hint})" * bool(caught.value.hint)
        if wanted.startswith(f"{quantity.label} = {text}: must be") and "inf" not in text:
            value = float(exact_number(text, quantity))  # the page tells it with its unit
            wanted = wanted.replace(f"= {text}:", f"= {value:.15g} {quantity.unit}".rstrip() + ":")
        assert answer["state"] is None
        assert answer["problems"][0] == {"field": column, "text": wanted}


_WRONG: list[tuple[dict[str, str], str, str]] = [
    ({"amplitude_mm": "1:2"}, "amplitude_mm", "it takes one value (write 1.25"),
    ({"frequency_hz": "1,250"}, "frequency_hz", "it takes one value (write 1.25 or 1250"),
    ({"kinetic_friction": "0.8"}, "kinetic_friction", "at most static friction = 0.74 (friction at rest"),
    ({"trough_length_mm": "", "view": "traverse"}, "trough_length_mm", "needs the length"),
    ({"drive": "circle"}, "drive", "must be line, ellipse, harmonics"),
    ({"drive": "constructor"}, "drive", "drive = 'constructor': must be"),
    ({"view": "__proto__"}, "view", "must be regime, speed"),
    ({"follow": "yes"}, "follow", "must be 0, 1"),
    ({"cycles": "21"}, "cycles", "whole number from 1 to 20"),
    ({"x": "gravity_m_s2"}, "x", "no axis of this drive (choose from amplitude_mm"),
    ({"x": "amplitude_mm"}, "y", "x and y are both amplitude"),
    ({"x": "friction_ratio", "y": "kinetic_friction"}, "y", "describe the same"),
    ({"x_range": "5:6:99"}, "x_range", "frequency = 5:6:99: must be a range"),
    ({"x_range": "60:5"}, "x_range", "does not ascend (write 5:60)"),
    ({"x_range": "5:5.00000000000001"}, "x_range", "too close for doubles"),
    ({"x_range": "0:60:log"}, "x_range", "must start above 0"),
    ({"x_range": "-5:60"}, "x_range", "frequency = -5:60: must be in [1e-12, 1e+12] Hz"),
    ({"static_friction_band": "0.5:0.3"}, "static_friction_band", "does not ascend (swap its ends)"),
    ({"static_friction_band": "0:0.3"}, "static_friction_band", "have no regime"),
    ({"static_friction_band": "1:2", "x": "static_friction"}, "static_friction_band", "cannot have"),
    ({"restitution_band": "0:0.2", "x": "restitution"}, "restitution_band", "cannot have"),
    ({"restitution_band": "0:1"}, "restitution_band", "must be in [0, 1)"),
    ({"friction_ratio_band": "0:1", "kinetic_friction_band": "0:1"}, "friction_ratio_band", "a band too"),
    ({"kinetic_friction_band": "0.8:0.9"}, "kinetic_friction_band", "must reach down to static friction"),
    ({"target": "0"}, "target", "must be in "),
    ({"colour": "red"}, "", "unknown key 'colour'"),
    ({"constructor": "x"}, "", "unknown key 'constructor'"),
    ({"y" * 100_000: "1"}, "", "(100000 characters)"),
    ({"amplitude_mm": "y" * 100_000}, "amplitude_mm", "longer than 1000 characters"),
    ({"amplitude_mm": "1" * 100_000}, "amplitude_mm", "longer than 1000 characters"),
    ({"x_range": "1:" * 50_000}, "x_range", "must be a range"),
    ({"static_friction_band": "1:" * 50_000}, "static_friction_band", "it takes one value"),
    ({"cycles": "\u202e3\u0000"}, "cycles", "cycles = '\ufffd3\ufffd'"),
]  # fmt: skip


def test_what_is_wrong_is_told_beside_its_field(ask: Callable[..., list[Any]]) -> None:
    several = {"amplitude_mm": "-1", "frequency_hz": "x", "x_range": "3:2", "static_friction_band": "3:2"}
    *found, all_of_them = states(ask, *(query for query, _, _ in _WRONG), several)
    assert [problem["field"] for problem in all_of_them["problems"]] == [*several]
    for (_, field, said), answer in zip(_WRONG, found, strict=True):
        assert answer["state"] is None
        assert [problem["field"] for problem in answer["problems"]] == [field], said
        text = answer["problems"][0]["text"]
        assert said in text
        assert len(text) < 500


def test_texts_say_all_of_a_state(ask: Callable[..., list[Any]]) -> None:
    typed = {
        "frequency_hz": "33,3",
        "target": "2cm/s",
        "amplitude_mm": "800um",
        "restitution_band": "0,1:0.3",
    }
    queries = [typed | {"drive": drive, "view": view, "cycles": "7"} for drive in DRIVES for view in VIEWS]
    found = [answer["state"] for answer in states(ask, *queries)]
    assert {(s["drive"], s["view"]) for s in found} == {(d, v) for d in DRIVES for v in VIEWS}
    assert all(s["values"]["frequency"] == 33.3 and s["target"] == 20.0 and s["cycles"] == 7 for s in found)
    assert all(s["bands"] == {"restitution": [0.1, 0.3]} for s in found)
    assert found[0]["texts"]["amplitude_mm"] == "0.8"
    assert [answer["state"] for answer in states(ask, *(s["texts"] for s in found))] == found


def test_an_address_brings_back_its_state(ask: Callable[..., list[Any]]) -> None:
    queries = {"x_range": "5:60:log"}, {"motion_scale": "0.5"}, {"setting_percent": "50"}
    told = ask(*(["stateOf", "DATA", scene, query] for scene, query in enumerate(queries)))
    addresses = ask(*(["addressOf", "DATA", n, one["state"]["texts"]] for n, one in enumerate(told)))
    assert [address.partition("=")[0] for address in addresses] == ["#drive", "#scene", "#scene"]
    read = ask(*(["readAddress", "DATA", address] for address in addresses))
    assert [(one["scene"], one["problems"]) for one in read] == [(0, []), (1, []), (2, [])]
    again = ask(*(["stateOf", "DATA", one["scene"], one["texts"]] for one in read))
    for one, other in zip(told, again, strict=True):
        assert one["state"]["values"] == other["state"]["values"]
        assert one["state"]["x"] == other["state"]["x"]


_FOREIGN = [
    "#top", "#%zz", "#=&&=", "#__proto__=1", "#constructor=1", "#x=%ff%fe", "#scene=9", "#scene=-1",
    "#scene=__proto__", "#scene=0.5", "#drive=line&drive=line", "#x", "#" + 100_000 * "a",
    "#\u0000=1",
]  # fmt: skip


def test_a_foreign_address_is_refused_without_a_throw(ask: Callable[..., list[Any]]) -> None:
    read = ask(*(["readAddress", "DATA", fragment] for fragment in _FOREIGN))
    found = ask(*(["stateOf", "DATA", each["scene"], each["texts"]] for each in read))
    for fragment, address, answer in zip(_FOREIGN, read, found, strict=True):
        assert address["problems"] or answer["problems"], fragment


def test_a_link_to_another_motion_is_refused(ask: Callable[..., list[Any]]) -> None:
    asked = [(scene, texts) for scene in (1, 2) for texts in ({}, {"motion": "beef"})]
    own, motion, fed, machine = ask(*(["stateOf", "DATA", *one] for one in asked))
    assert own["problems"] == fed["problems"] == []
    for answer, what in ((motion, "motion"), (machine, "machine")):
        assert f"of another {what} than that of the scene" in answer["problems"][0]["text"]


def test_a_clamped_part_may_hang_and_is_not_lifted(ask: Callable[..., list[Any]]) -> None:
    hung = {"x": "trough_angle_deg", "x_range": "-90:90", "trough_angle_deg": "90"}
    ellipse = {"drive": "ellipse", "trough_angle_deg": "0"}
    asked: list[tuple[int, dict[str, str]]] = [(1, hung), (0, hung), (1, {}), (1, ellipse)]
    clamped, free, start, oval = ask(*(["stateOf", "DATA", *one] for one in asked))
    assert clamped["problems"] == []
    assert free["problems"][0]["text"].endswith("must be in (-90, 90) deg")
    values = start["state"]["values"]
    assert (values["along_amplitude_3"], values["normal_acceleration"]) == (0.1, 20.0)
    assert "normal_acceleration" not in oval["state"]["values"]


def test_axes_go_with_their_drive_and_ranges_with_their_axes(ask: Callable[..., list[Any]]) -> None:
    slow = {"frequency_hz": "2.4", "x": "drive_angle_deg", "y": "frequency_hz", "y_range": ""}
    queries = (
        {"drive": "ellipse"},
        {"x": "drive_angle_deg"},
        {"x": "drive_angle_deg", "x_range": "3:4"},
        slow,
    )
    ellipse, angle, narrow, around = (answer["state"] for answer in states(ask, *queries))
    assert (ellipse["x"]["name"], ellipse["y"]["name"]) == ("normal_phase", "along_amplitude")
    assert angle["texts"]["x_range"] == CONTROLS["drive_angle"].axis
    assert narrow["x"] == {"name": "drive_angle", "from": 3.0, "to": 4.0, "log": False}
    assert around["texts"]["y_range"] == "0.8:7.2"
    (least,) = states(ask, {"frequency_hz": "1e-12"})
    assert least["state"]["texts"]["x_range"] == "1e-12:3e-12"


def test_presets_are_states(ask: Callable[..., list[Any]]) -> None:
    for answer in states(ask, *(preset.state for preset in PRESETS.values())):
        state = answer["state"]
        for axis in (state["x"], state["y"]):
            assert axis["from"] < state["values"][axis["name"]] < axis["to"]
