"""The settings that the server writes into the page."""

from __future__ import annotations

from html.parser import HTMLParser
from importlib.resources import files
from typing import TYPE_CHECKING

import pytest

from vibro.explore.controls import CONTROLS, DRIVES, PRESETS, VIEWS, Preset
from vibro.explore.form import form_html
from vibro.explore.state import initial_state, read_state
from vibro.quantities import QUANTITIES, SWEPT

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
    return Tags(page + form_html())


def test_every_key_of_the_state_has_a_box_and_every_box_a_key(tags: Tags) -> None:
    columns = {QUANTITIES[name].column for name in CONTROLS} - {"friction_ratio"}
    keys = {*initial_state().texts, *columns}
    named = {given["name"] for tag, given in tags.found if tag in ("input", "select")}
    assert named == keys | {"preset", "bands"}


def test_labels_and_descriptions_lead_to_what_is_there(tags: Tags) -> None:
    ids = [*tags.all("id")]
    assert len(ids) == len({*ids})
    assert {*tags.all("for")} <= {*ids}
    assert {*tags.all("aria-describedby")} <= {*ids}


def test_options_are_known_and_what_they_set_is_taken(tags: Tags) -> None:
    axes = [QUANTITIES[name].column for name in CONTROLS if name in SWEPT]
    known = [*VIEWS, *axes, *axes, "", *PRESETS, *DRIVES]
    assert [given["value"] for tag, given in tags.found if tag == "option"] == known
    for preset in PRESETS.values():
        read_state(preset.state, initial_state())


def test_texts_are_escaped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(PRESETS, '"><b>', Preset("<script>&", {"x": '"&y'}))
    page = form_html()
    assert '<option value="&quot;&gt;&lt;b&gt;"' in page
    assert "&lt;script&gt;&amp;</option>" in page
    assert "<script" not in page
