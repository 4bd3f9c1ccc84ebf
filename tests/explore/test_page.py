"""The explorer's page in a browser: what is seen and said there, what moves it, what can be saved."""

from __future__ import annotations

import io
import os
import re
import struct
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit
from xml.etree import ElementTree

import numpy as np
import pytest
from helpers.browsers import PATIENCE
from helpers.explorers import serve_explorer
from helpers.packed import FEEDER
from helpers.pages import (
    AMPLITUDE,
    CONTACT,
    FREQUENCY,
    asked,
    enter,
    expect,
    middle,
    point,
    speed,
    until,
    until_asked,
)
from PIL import Image

from vibro.explore.state import initial_state
from vibro.sweeps.whole import request_of_call

if TYPE_CHECKING:
    from collections.abc import Callable

    from playwright.sync_api import Browser, Page, Route

    Open = Callable[..., Page]

SVG = "{http://www.w3.org/2000/svg}"
PICTURE = Path(__file__).parents[2] / "docs" / "images" / "explore.png"
FOUND = """(options) => axe.run({resultTypes: ["violations"], ...options}).then(
    (found) => found.violations.map((one) => [one.id, one.nodes.map((node) => node.target)]))"""


def test_the_main_parts_have_roles_and_names(open_page: Open) -> None:
    """With VIBRO_DRAW=1 the picture in the README is made anew."""
    page = open_page("#view=speed", viewport={"width": 1360, "height": 860})
    expect(page).to_have_title("forward-slip, 16.2635 mm/s – vibro")
    expect(page.locator("#readout")).to_contain_text("forward-slip16.2635 mm/s")
    expect(page.locator(".curves [data-curve]")).to_have_count(4)
    expect(page.locator("#says")).to_have_text("")  # nothing has changed
    expect(page.get_by_role("region", name="Map")).to_match_aria_snapshot("""
      - region "Map":
        - group "Mean conveying speed, over frequency f [Hz] and amplitude A [mm]":
          - slider "operating point"
        - paragraph:
          - button "PNG"
          - button "SVG"
          - button "CSV"
          - button "CSV with decimal commas"
          - status
    """)
    expect(page.get_by_role("form", name="Settings")).to_match_aria_snapshot("""
      - form "Settings":
        - group "Map":
          - combobox "Show"
          - group "Horizontal axis":
            - combobox "Across"
            - textbox "from": "5"
            - textbox "to": "60"
            - checkbox "log"
        - group "Drive":
          - combobox "Motion"
          - textbox "amplitude A": "1"
          - slider "amplitude, slider"
        - group "Friction":
          - textbox "static friction μ_s": "0.74"
          - checkbox "kinetic friction follows static friction" [checked]
          - checkbox "friction is not known exactly"
    """)
    expect(page.get_by_role("table", name="Where each motion begins")).to_match_aria_snapshot("""
      - table "Where each motion begins":
        - rowgroup:
          - row "begins times the drive amplitude [mm] frequency [Hz]"
        - rowgroup:
          - row "forward slip 0.6852 0.6852 12.42"
    """)
    expect(page.get_by_role("img", name=re.compile("from rest"))).to_be_visible()
    heights = page.evaluate("""[...document.querySelectorAll('#history svg svg')].map((panel) => {
        const ticks = [...panel.parentElement.nextElementSibling.children];
        const zero = ticks.find((tick) => tick.textContent === '0');
        return [panel, zero].map((part) => part.querySelector('path').getBoundingClientRect().y);
    })""")
    assert len(heights) == 4
    for line, tick in heights:  # zero is drawn where its axis has it
        assert line == pytest.approx(tick, abs=0.1)
    expect(page.locator("#stage")).not_to_contain_text("exact")  # nothing is left to be computed
    page.mouse.move(1, 1)
    drawn = page.screenshot()
    if os.environ.get("VIBRO_DRAW"):
        PICTURE.write_bytes(drawn)
    fresh, shown = (np.asarray(Image.open(x).convert("L"), float) for x in (io.BytesIO(drawn), PICTURE))
    assert fresh.shape == shown.shape
    assert np.abs(fresh - shown).mean() < 2.0  # of 255: fonts differ from machine to machine


def test_the_point_is_dragged_or_moved_by_keys_without_asking_for_the_map(open_page: Open) -> None:
    page = open_page()
    maps, points, entries = asked(page, "map"), asked(page, "point"), page.evaluate("history.length")
    x, y = middle(point(page))
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y - 20, steps=4)
    expect(page.locator(FREQUENCY)).not_to_have_value("15")
    page.mouse.up()
    moved = page.locator(FREQUENCY).input_value()
    assert float(moved) > 15
    until_asked(page, points, "frequency_hz", moved)
    expect(page.locator("#says")).to_contain_text("back-slip, ")
    assert middle(point(page)) == pytest.approx((x + 60, y - 20), abs=2)
    assert page.evaluate("history.length") == entries + 1
    page.go_back()
    expect(page.locator(FREQUENCY)).to_have_value("15")
    expect(page).to_have_title(re.compile("16.2635"))
    point(page).focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator(FREQUENCY)).to_have_value("15.55")
    page.keyboard.press("Shift+ArrowUp")
    expect(page.locator(AMPLITUDE)).to_have_value("1.29")
    expect(point(page)).to_be_focused()
    expect(point(page)).to_have_attribute("aria-valuetext", "frequency 15.55 Hz, amplitude 1.29 mm")
    expect(page.locator("#says")).to_have_text("back-slip, 33.0399 mm/s")
    assert [query for query in maps if "advance" not in query] == []


def test_on_a_phone_a_finger_moves_the_point_and_nothing_is_wider_than_the_window(open_page: Open) -> None:
    fragment = "#view=speed&static_friction_band=0.6:0.8"
    page = open_page(fragment, has_touch=True, viewport={"width": 390, "height": 844})
    box = page.locator("#cells").bounding_box()
    assert box
    lengths = page.evaluate("""[...document.querySelectorAll('#frame text')]
        .filter((text) => /speed \\[|amplitude A/.test(text.textContent))
        .map((text) => text.getBoundingClientRect().height)""")
    assert len(lengths) == 2
    assert max(lengths) < box["height"] + 2  # names of scales are no longer than they
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    expect(page.locator(FREQUENCY)).to_have_value("32.5")
    page.touchscreen.tap(box["x"] + box["width"] / 4, box["y"] + box["height"] / 2)
    expect(page.locator(FREQUENCY)).to_have_value(re.compile(r"18\.[67]"))
    page.locator("#drive").select_option("harmonics")
    expect(page.locator("#no-bands")).to_be_visible()
    for width, height in ((700, 450), (320, 640)):
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        for part in ("#stage > svg", "#controls", "#tables", "#toml"):
            seen = page.locator(part).bounding_box()
            assert seen
            assert seen["x"] + seen["width"] <= width + 0.5, part


def test_units_and_decimal_commas_are_read_and_bad_input_is_told_beside_its_field(open_page: Open) -> None:
    page = open_page()
    field, alert = page.locator(AMPLITUDE), page.get_by_role("alert")
    x, y = middle(point(page))
    page.route("**/point?*", lambda route: None)  # nothing but the page itself reads what is typed
    enter(page, FREQUENCY, "15,5")
    right, _ = middle(point(page))
    assert x + 1 < right < x + 20
    enter(page, AMPLITUDE, "bla")
    assert middle(point(page)) == pytest.approx((right, y), abs=0.01)  # it does not jump
    page.unroute("**/point?*")
    enter(page, AMPLITUDE, "800um")
    expect(field).to_have_value("0.8")
    enter(page, "#x-to", "40,5")
    expect(page).to_have_url(
        re.compile("amplitude_mm=0.8&.*x_range=5:40.5|x_range=5:40.5&.*amplitude_mm=0.8")
    )
    enter(page, AMPLITUDE, "1,250")  # a thousand, or a decimal?
    expect(alert).to_contain_text("write it like 1.5mm")
    enter(page, FREQUENCY, "16")
    expect(alert).to_contain_text("not updated: amplitude")
    alert.get_by_role("button", name="amplitude").click()
    expect(field).to_be_focused()
    expect(field).to_have_attribute("aria-invalid", "true")
    expect(field).to_have_accessible_description(re.compile("write it like 1.5mm"))
    expect(field).to_have_value("1,250")
    expect(page.locator(".curves [data-curve]")).to_have_count(4)
    enter(page, AMPLITUDE, "1")
    expect(alert).to_be_empty()
    expect(field).to_have_attribute("aria-invalid", "false")
    kinetic = page.locator("#kinetic_friction")
    enter(page, "#static_friction", "0.37")
    expect(kinetic).to_have_value("0.285")
    enter(page, "#static_friction", "0.74")
    expect(kinetic).to_have_value("0.57")  # the ratio was not rounded on the way
    page.locator("#follow").uncheck()
    enter(page, "#static_friction", "0.5")
    expect(kinetic).to_have_value("0.5")


def test_drives_and_presets_set_axes_which_keep_apart(open_page: Open) -> None:
    page = open_page()
    page.locator("#drive").select_option("ellipse")
    expect(page.locator("#x")).to_have_value("normal_phase_deg")
    expect(page.locator("#row-amplitude_mm")).to_be_hidden()
    expect(page.locator("#bands")).to_be_disabled()
    expect(page.locator("#no-bands")).to_be_visible()
    page.locator("#preset").select_option("magnet-50")
    expect(page.locator(FREQUENCY)).to_have_value("50")
    expect(page.locator("#drive")).to_have_value("line")
    expect(page.locator("#no-bands")).to_be_hidden()
    expect(page.locator("#preset")).to_have_value("")
    page.locator("#x").select_option("amplitude_mm")
    expect(page.locator("#y")).to_have_value("frequency_hz")
    expect(page.get_by_role("group", name="over amplitude A [mm] and frequency")).to_be_visible()
    enter(page, FREQUENCY, "1000")
    expect(page.locator("#outside")).to_be_visible()


def test_bands_have_two_handles_that_do_not_pass_and_axe_finds_nothing(open_page: Open, axe: str) -> None:
    page = open_page()
    page.locator("#bands").check()
    least, most = (page.get_by_role("slider", name=f"{end} static friction") for end in ("least", "most"))
    expect(least).to_have_value("0.665")
    expect(page.locator("#guaranteed")).not_to_be_empty()
    expect(page.locator("#stage")).to_contain_text("either regime")
    least.focus()
    page.keyboard.press("End")
    expect(most).to_have_value("1.5")
    expect(page.locator("#static_friction_band-most")).to_have_value("1.5")
    page.locator("#view").select_option("speed")
    enter(page, AMPLITUDE, "bla")
    expect(page.locator("#note-amplitude_mm")).not_to_be_empty()
    page.evaluate(axe)
    assert page.evaluate(FOUND, {}) == []
    page.set_viewport_size({"width": 390, "height": 844})
    page.emulate_media(color_scheme="dark")
    page.evaluate("Promise.all(document.getAnimations().map((one) => one.finished))")
    narrow = {"runOnly": ["color-contrast", "target-size", "scrollable-region-focusable"]}
    assert page.evaluate(FOUND, narrow) == []
    page.locator("#bands").uncheck()
    expect(least).to_be_hidden()
    expect(page).to_have_url(re.compile("#(?!.*band)"))


def test_a_link_shows_the_same_and_back_goes_through_the_changes(open_page: Open) -> None:
    page = open_page(CONTACT)
    page.locator("#view").select_option("traverse")
    page.locator("#x").select_option("static_friction")
    enter(page, "#target", "20")
    enter(page, FREQUENCY, "14")
    expect(page.get_by_role("group", name="Traverse time, over static friction")).to_contain_text(
        "20 mm/s, without hopping"
    )
    expect(page).to_have_url(
        re.compile("frequency_hz=14&.*x_range=0.1:1.2|x_range=0.1:1.2.*&frequency_hz=14&")
    )
    expect(page.locator("#tables")).to_contain_text("frequency 14 Hz")
    copy = open_page("#" + urlsplit(page.url).fragment)
    for part in ("#readout", "#tables", "#command", "#toml", "#stage > svg"):
        expect(copy.locator(part)).to_have_text(page.locator(part).text_content() or "")
    for control in ("view", "drive", "x", "y", "x-from", "x-to", "target"):
        expect(copy.locator(f"#{control}")).to_have_value(page.locator(f"#{control}").input_value())
    page.go_back()
    expect(page.locator(FREQUENCY)).to_have_value("15")
    expect(page.locator("#tables")).to_contain_text("frequency 15 Hz")
    page.go_forward()
    expect(page.locator(FREQUENCY)).to_have_value("14")
    alert = copy.get_by_role("alert")
    name = "__proto__"  # which every object knows
    copy.evaluate(f"location.hash = '#amplitude_mm=2&drive={name}&{name}=&view={name}'")
    expect(alert).to_contain_text(f"This link could not be read: drive = '{name}': must be line, ellipse")
    expect(alert).to_contain_text("The initial state is shown.")
    expect(copy.locator(AMPLITUDE)).to_have_value("1")
    speed(copy, "16.2635 mm/s")
    enter(copy, AMPLITUDE, "0.9")
    expect(alert).to_be_empty()


def test_pictures_texts_and_the_command_line_can_be_taken_along(open_page: Open, tmp_path: Path) -> None:
    page = open_page(CONTACT)

    def saved(name: str) -> bytes:
        with page.expect_download() as download:
            page.locator(f"#{name}").click()
        path = tmp_path / download.value.suggested_filename
        download.value.save_as(path)
        return path.read_bytes()

    root = ElementTree.fromstring(saved("svg"))
    width, height = (int(float(root.attrib[side])) for side in ("width", "height"))
    images = [image.attrib["href"] for image in root.iter(f"{SVG}image")]
    assert images
    assert all(address.startswith("data:image/png;base64,") for address in images)
    texts = "".join(root.itertext())
    point = "operating point: 15 Hz, 1 mm"
    for word in ("Mean conveying speed", "frequency f [Hz]", "α = 20°", point, "forward-slip onset", "mm/s"):
        assert word in texts
    picture = saved("png")
    assert picture.startswith(b"\x89PNG")
    assert struct.unpack(">II", picture[16:24]) == (2 * width, 2 * height)
    assert saved("csv").startswith(b"amplitude_mm,frequency_hz,")
    assert saved("csv-comma").startswith(b"amplitude_mm;frequency_hz;")
    assert saved("save-toml").decode().startswith("[scene]")
    assert {path.name for path in tmp_path.iterdir()} == {
        "vibro-speed.svg", "vibro-speed.png", "vibro-map.csv", "scene.toml"
    }  # fmt: skip
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.locator("#copy-command").click()
    expect(page.locator("#copy-command")).to_have_text("Copied")
    expect(page.locator("#says")).to_have_text("copied")
    assert page.evaluate("navigator.clipboard.readText()") == page.locator("#command").inner_text()


def test_a_machine_has_knobs_and_packs_in_place_of_the_amplitude(browser: Browser, tmp_path: Path) -> None:
    file = tmp_path / "feeder.toml"
    file.write_text(FEEDER, encoding="utf-8")
    url = serve_explorer(initial_state(request_of_call(file, {})))
    with browser.new_context() as context:
        context.set_default_timeout(PATIENCE)
        page = context.new_page()
        page.goto(url)
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
        # A refusal that comes after its value was mended does not stay.
        late: list[Route] = []
        page.route(re.compile(r"/map\?.*filling_kg=-1"), lambda route: late.append(route), times=1)
        enter(page, "#filling_kg", "-1")
        enter(page, "#frequency_hz", "51")
        until(page, lambda: bool(late))
        enter(page, "#filling_kg", "2")
        expect(page.locator("#filling_kg")).to_have_attribute("aria-invalid", "false")
        with page.expect_response(lambda response: "/map" in response.url and "filling_kg=2" in response.url):
            late[0].continue_()
        expect(page.locator("#note-filling_kg")).to_be_empty()
        page.evaluate("location.hash = '#x=setting_percent&y=voltage_percent&filling_kg=0'")
        expect(page.get_by_role("group", name="over setting")).to_be_visible()
        box = page.locator("#cells").bounding_box()
        assert box
        page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
        expect(page.locator("#tip")).to_contain_text(re.compile(r"amplitude \[mm\]0\.\d+"))
        page.locator("#drive").select_option("line")
        expect(page.locator("#amplitude_mm")).to_be_visible()
        expect(page.get_by_role("group", name="Machine")).to_be_hidden()
