"""The settings that the server writes into the page."""

from __future__ import annotations

from html.parser import HTMLParser
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from vibro.explore.controls import CONTROLS, DRIVES, PRESETS, VIEWS, Preset, drives_of
from vibro.explore.form import form_html
from vibro.explore.state import initial_state, read_state
from vibro.quantities import QUANTITIES, SWEPT
from vibro.sweeps.whole import request_of_call

if TYPE_CHECKING:
    from collections.abc import Iterator


class Tags(HTMLParser):
    """All opening tags of a text, with their attributes."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def all(self, attribute: str) -> Iterator[str]:
        return (given[attribute] or "" for _, given in self.found if attribute in given)


@pytest.fixture(scope="module")
def tags() -> Tags:
    page = (files("vibro.explore") / "static" / "index.html").read_text(encoding="utf-8")
    return Tags(page + form_html(initial_state()))


def test_every_key_of_the_state_has_a_box_and_every_box_a_key(tags: Tags) -> None:
    names = [name for name in CONTROLS if drives_of(name, DRIVES)]
    columns = {QUANTITIES[name].column for name in names} - {"friction_ratio"}
    keys = {*initial_state().texts, *columns}
    named = {given["name"] for tag, given in tags.found if tag in ("input", "select")}
    assert named == keys | {"preset", "bands"}


def test_labels_and_descriptions_lead_to_what_is_there(tags: Tags) -> None:
    ids = [*tags.all("id")]
    assert len(ids) == len({*ids})
    assert {*tags.all("for")} <= {*ids}
    assert {*tags.all("aria-describedby")} <= {*ids}


def test_options_are_known_and_what_they_set_is_taken(tags: Tags) -> None:
    axes = [QUANTITIES[name].column for name in CONTROLS if name in SWEPT and drives_of(name, DRIVES)]
    known = [*VIEWS, *axes, *axes, "", *PRESETS, *DRIVES]
    assert [given["value"] for tag, given in tags.found if tag == "option"] == known
    for preset in PRESETS.values():
        read_state(preset.state, initial_state())


def test_texts_are_escaped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(PRESETS, '"><b>', Preset("<script>&", {"x": '"&y'}))
    page = form_html(initial_state())
    assert '<option value="&quot;&gt;&lt;b&gt;"' in page
    assert "&lt;script&gt;&amp;</option>" in page
    assert "<script" not in page


def test_a_given_motion_has_its_own_sliders(tmp_path: Path) -> None:
    """They reach the scene's values, however far these lie out."""
    file = tmp_path / "hung.toml"
    file.write_text(
        "[scene]\nalong_amplitudes_mm = [20, 5]\nalong_phases_deg = [0, -110]\nfrequency_hz = 0.8\n"
        "static_friction = 0.6\nkinetic_friction = 0.5\ntrough_angle_deg = 90\n"
        "normal_acceleration_m_s2 = 150\n",
        encoding="utf-8",
    )
    found = Tags(form_html(initial_state(request_of_call(file, {})))).found
    sliders = {g["name"]: g for tag, g in found if g.get("type") == "range"}
    ends = {name: (given["min"], given["max"]) for name, given in sliders.items()}
    assert ends["along_amplitude_mm"] == ("0.0", "40.0")
    assert ends["frequency_hz"] == ("0.8", "120.0")
    assert ends["normal_acceleration_m_s2"] == ("0.5", "300.0")
    assert ends["trough_angle_deg"] == ("-20.0", "90.0")
    assert ends["motion_scale"] == ("0.05", "3.0")
    rows = {g["id"]: g["data-drives"] for _, g in found if "data-drives" in g and "id" in g}
    assert rows["row-motion_scale"] == rows["row-normal_acceleration_m_s2"] == "given"
    assert rows["row-normal_amplitude_mm"] == "ellipse harmonics"
    assert rows["row-along_amplitude_mm"] == "ellipse harmonics given"
    assert not {"row-motion_scale", "row-normal_acceleration_m_s2"} & {
        g.get("id") for _, g in Tags(form_html(initial_state())).found
    }
