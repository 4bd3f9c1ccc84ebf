"""The explorer's page of a scene with a machine, in a browser."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest
from helpers.packed import FEEDER
from helpers.pages import asked, enter, expect, until, until_asked

from vibro.explore.state import State, initial_state
from vibro.sweeps.whole import request_of_call

if TYPE_CHECKING:
    from collections.abc import Callable

    from playwright.sync_api import Page, Route

    Open = Callable[..., Page]

SHOWN = re.compile(r"amplitude[^m]* 0\.4\d+ mm")


@pytest.fixture(scope="module")
def explored(tmp_path_factory: pytest.TempPathFactory) -> State:
    file = tmp_path_factory.mktemp("machine") / "feeder.toml"
    file.write_text(FEEDER, encoding="utf-8")
    return initial_state(request_of_call(file, {}))


def test_knobs_stand_in_place_of_the_amplitude(open_page: Open) -> None:
    page = open_page()
    expect(page.get_by_role("form", name="Settings")).to_match_aria_snapshot("""
      - form "Settings":
        - group "Drive":
          - combobox "Motion"
          - textbox "frequency f": "50"
        - group "Machine":
          - textbox "setting s": "100"
          - slider "setting, slider"
          - textbox "voltage U": "100"
          - textbox "filling m": "2"
          - slider "filling, slider"
          - combobox "Spring pack"
          - textbox "natural frequency f_0": "55.6"
    """)
    expect(page.locator("#amplitude_mm")).to_be_hidden()
    expect(page.locator("#pack")).to_have_value("6 leaves")


def test_a_pack_is_chosen_by_its_name_and_the_address_holds_it(open_page: Open) -> None:
    page = open_page()
    points, speed = asked(page, "point"), page.locator("#speed").text_content()
    page.locator("#pack").select_option("4 & a half")
    until_asked(page, points, "natural_hz", "47.6")
    expect(page.locator("#natural_hz")).to_have_value("47.6")
    expect(page.locator("#speed")).not_to_have_text(speed or "")
    enter(page, "#natural_hz", "50.3")
    expect(page.locator("#pack")).to_have_value("")
    assert "natural_hz=50.3" in page.url
    page.go_back()
    expect(page.locator("#pack")).to_have_value("4 & a half")


def test_a_wrong_filling_is_told_beside_its_field(open_page: Open) -> None:
    page = open_page()
    enter(page, "#filling_kg", "-1")
    expect(page.locator("#note-filling_kg")).to_contain_text("must be in ")
    enter(page, "#filling_kg", "500g")
    expect(page.locator("#filling_kg")).to_have_value("0.5")
    expect(page.locator("#note-filling_kg")).to_have_text("")


def test_a_refusal_that_comes_after_its_value_was_mended_does_not_stay(open_page: Open) -> None:
    page = open_page()
    late: list[Route] = []
    page.route(re.compile(r"/map\?.*filling_kg=-1"), lambda route: late.append(route))
    enter(page, "#filling_kg", "-1")
    enter(page, "#frequency_hz", "51")
    until(page, lambda: bool(late))
    enter(page, "#filling_kg", "2")
    expect(page.locator("#filling_kg")).to_have_attribute("aria-invalid", "false")
    with page.expect_response(lambda response: "/map" in response.url and "filling_kg=2" in response.url):
        late[0].continue_()
    expect(page.locator("#note-filling_kg")).to_be_empty()


def test_pointing_at_a_cell_shows_its_amplitude(open_page: Open) -> None:
    page = open_page("#x=setting_percent&y=voltage_percent&filling_kg=0")
    box = page.locator("#cells").bounding_box()
    assert box
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    expect(page.locator("#tip")).to_contain_text(re.compile(r"amplitude \[mm\]0\.\d+"))


def test_another_drive_has_no_machine(open_page: Open) -> None:
    page = open_page("#drive=line")
    expect(page.locator("#amplitude_mm")).to_be_visible()
    expect(page.get_by_role("group", name="Machine")).to_be_hidden()
