"""The explorer's page in a browser: what is seen and said there, and what moves it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import pytest
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
    until_asked,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from playwright.sync_api import Page

    Open = Callable[..., Page]


def test_tells_regime_and_speed_in_the_title_and_beside_the_map(open_page: Open) -> None:
    page = open_page()
    expect(page).to_have_title("forward-slip, 16.2635 mm/s – vibro")
    expect(page.locator("#readout")).to_contain_text("forward-slip16.2635 mm/s")
    expect(page.locator(".curves [data-curve]")).to_have_count(4)
    expect(page.locator("#says")).to_have_text("")  # nothing has changed


def test_the_main_parts_have_roles_and_names(open_page: Open) -> None:
    page = open_page()
    expect(page.get_by_role("region", name="Map")).to_match_aria_snapshot("""
      - region "Map":
        - group "Regimes, over frequency f [Hz] and amplitude A [mm]":
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
    expect(page.get_by_role("table", name="What begins when")).to_match_aria_snapshot("""
      - table "What begins when":
        - rowgroup:
          - row "begins load now / then amplitude [mm] frequency [Hz]"
        - rowgroup:
          - row "forward slip 1.4595 0.685165 12.4162"
    """)
    expect(page.get_by_role("img", name=re.compile("from rest"))).to_be_visible()


def test_the_point_is_dragged_without_asking_for_the_map(open_page: Open) -> None:
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
    assert [query for query in maps if "advance" not in query] == []
    assert page.evaluate("history.length") == entries + 1
    page.go_back()
    expect(page.locator(FREQUENCY)).to_have_value("15")
    expect(page).to_have_title(re.compile("16.2635"))


def test_a_click_moves_the_point_and_a_finger_too(open_page: Open) -> None:
    page = open_page(has_touch=True, viewport={"width": 390, "height": 844})
    box = page.locator("#cells").bounding_box()
    assert box
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    expect(page.locator(FREQUENCY)).to_have_value("32.5")
    page.touchscreen.tap(box["x"] + box["width"] / 4, box["y"] + box["height"] / 2)
    expect(page.locator(FREQUENCY)).to_have_value(re.compile(r"18\.[67]"))
    expect(page.locator("#says")).to_contain_text("mm/s")


def test_arrow_keys_move_the_point_and_the_speed_is_said(open_page: Open) -> None:
    page = open_page()
    point(page).focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator(FREQUENCY)).to_have_value("15.55")
    page.keyboard.press("Shift+ArrowUp")
    expect(page.locator(AMPLITUDE)).to_have_value("1.29")
    expect(point(page)).to_be_focused()
    expect(point(page)).to_have_attribute("aria-valuetext", "frequency 15.55 Hz, amplitude 1.29 mm")
    speed(page, "33.0399 mm/s")
    expect(page.locator("#says")).to_have_text("back-slip, 33.0399 mm/s")


def test_a_slider_moves_the_map_live_and_is_one_entry(open_page: Open) -> None:
    page = open_page()
    maps, entries = asked(page, "map"), page.evaluate("history.length")
    slider = page.get_by_role("slider", name="drive angle, slider")
    slider.focus()
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    expect(page.locator("#drive_angle_deg")).to_have_value("20.3")
    expect(page.locator("#tables")).to_contain_text("drive angle 20.3 deg")
    until_asked(page, maps, "drive_angle_deg", "20.3")
    assert page.evaluate("history.length") == entries + 1


def test_kinetic_friction_follows_static_friction(open_page: Open) -> None:
    page = open_page()
    kinetic = page.locator("#kinetic_friction")
    enter(page, "#static_friction", "0.37")
    expect(kinetic).to_have_value("0.285")
    enter(page, "#static_friction", "0.74")
    expect(kinetic).to_have_value("0.57")  # the ratio was not rounded on the way
    page.locator("#follow").uncheck()
    enter(page, "#static_friction", "0.6")
    expect(kinetic).to_have_value("0.57")
    enter(page, "#static_friction", "0.5")
    expect(kinetic).to_have_value("0.5")


def test_the_map_over_static_friction_stays_while_the_point_moves(open_page: Open) -> None:
    page = open_page("#x=static_friction&x_range=0.2:1&y=amplitude_mm")
    maps = asked(page, "map")
    point(page).focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator("#static_friction")).to_have_value("0.748")
    expect(page.locator("#kinetic_friction")).to_have_value("0.5762")
    expect(page.locator("#tables")).to_contain_text("kinetic friction 0.5762")
    assert [query for query in maps if "advance" not in query] == []


def test_units_are_read_and_bad_input_is_told_beside_its_field(open_page: Open) -> None:
    page = open_page()
    field = page.locator(AMPLITUDE)
    enter(page, AMPLITUDE, "800um")
    expect(field).to_have_value("0.8")
    expect(page).to_have_url(re.compile("amplitude_mm=0.8&"))
    speed(page, "5.4548 mm/s")
    enter(page, AMPLITUDE, "bla")
    expect(field).to_have_attribute("aria-invalid", "true")
    expect(field).to_have_accessible_description(re.compile("'bla': not a number"))
    expect(page.get_by_role("alert")).to_contain_text("not updated: amplitude = 'bla': not a number")
    expect(field).to_have_value("bla")
    speed(page, "5.4548 mm/s")
    expect(page.locator(".curves [data-curve]")).to_have_count(4)
    enter(page, AMPLITUDE, "1")
    expect(field).to_have_attribute("aria-invalid", "false")
    speed(page, "16.2635 mm/s")


def test_a_decimal_comma_is_read_and_the_point_does_not_jump(open_page: Open) -> None:
    page = open_page()
    x, y = middle(point(page))
    page.route("**/point?*", lambda route: None)  # nothing but the page itself reads what is typed
    enter(page, FREQUENCY, "15,5")
    right, _ = middle(point(page))
    assert x + 1 < right < x + 20
    enter(page, AMPLITUDE, "800um")
    enter(page, AMPLITUDE, "bla")
    assert middle(point(page)) == pytest.approx((right, y), abs=0.01)
    expect(page.get_by_role("slider", name="amplitude, slider")).to_have_value("1")
    page.unroute("**/point?*")
    enter(page, AMPLITUDE, "0,8mm")
    expect(page.locator(AMPLITUDE)).to_have_value("0.8")
    enter(page, "#static_friction", "0,37")
    expect(page.locator("#kinetic_friction")).to_have_value("0.285")
    enter(page, "#x-to", "40,5")
    expect(page).to_have_url(re.compile("x_range=5:40.5"))
    enter(page, "#target", "20,5")
    expect(page.locator("#target")).to_have_value("20.5")
    page.locator("#bands").check()
    enter(page, "#static_friction_band-least", "0,35")
    expect(page).to_have_url(re.compile("static_friction_band=0.35:"))
    expect(page.get_by_role("alert")).to_be_empty()
    enter(page, AMPLITUDE, "1,250")  # a thousand, or a decimal?
    expect(page.get_by_role("alert")).to_contain_text("write 1.25 or 1250, not 1,250")


def test_what_is_being_typed_stays(open_page: Open) -> None:
    page = open_page()
    page.locator(AMPLITUDE).press_sequentially("5")
    with page.expect_response("**/point?**"):
        page.evaluate(
            "history.pushState(null, '', '#frequency_hz=20'); dispatchEvent(new PopStateEvent('popstate'))"
        )
    expect(page.locator(FREQUENCY)).to_have_value("20")
    expect(page.locator(AMPLITUDE)).to_have_value("51")


def test_axes_swap_and_keep_apart(open_page: Open) -> None:
    page = open_page()
    page.locator("#x").select_option("amplitude_mm")
    expect(page.locator("#y")).to_have_value("frequency_hz")
    expect(page.locator("#x-to")).to_have_value("3")
    expect(page.get_by_role("group", name="over amplitude A [mm] and frequency")).to_be_visible()
    page.locator("#y").select_option("friction_ratio")
    expect(page.get_by_role("group", name="and friction ratio")).to_be_visible()
    expect(page.locator("#y-to")).to_have_value("1")
    expect(page.locator("#bands")).to_be_disabled()
    point(page).focus()
    page.keyboard.press("ArrowUp")
    expect(page.locator("#kinetic_friction")).not_to_have_value("0.57")
    page.locator("#x").select_option("frequency_hz")
    expect(page.locator("#x-to")).to_have_value("60")
    enter(page, FREQUENCY, "100")
    expect(page.locator("#outside")).to_be_visible()


def test_bands_have_two_handles_that_do_not_pass(open_page: Open) -> None:
    page = open_page()
    page.locator("#bands").check()
    least, most = (page.get_by_role("slider", name=f"{end} static friction") for end in ("least", "most"))
    expect(least).to_have_value("0.665")
    expect(page.locator("#guaranteed")).not_to_be_empty()
    expect(page.locator("#stage")).to_contain_text("either regime")
    least.focus()
    page.keyboard.press("End")
    expect(most).to_have_value("1.5")
    expect(page.locator("#static_friction_band-least")).to_have_value("1.5")
    expect(page.locator("#static_friction_band-most")).to_have_value("1.5")
    expect(page.locator("#row-kinetic_friction_band")).to_be_hidden()
    page.locator("#follow").uncheck()
    expect(page.get_by_role("slider", name="least kinetic friction")).to_be_visible()
    page.locator("#bands").uncheck()
    expect(least).to_be_hidden()
    expect(page).to_have_url(re.compile("#(?!.*band)"))


def test_where_no_speed_is_proved_the_operating_point_is_searched(open_page: Open) -> None:
    page = open_page("#view=speed&frequency_hz=18&static_friction_band=0.6:0.8")
    bounds = re.compile(r"^back-slip, at least 3\d\.\d+ mm/s \(proved\), at most 3\d\.\d+ mm/s \(proved\)$")
    told = page.locator("#guaranteed")
    expect(told).to_have_text(bounds)
    expect(page.locator("#stage")).to_contain_text("not proved here")
    expect(page.locator("#notes")).to_contain_text("Largest that is proved here: ")
    expect(page.locator("#notes")).to_contain_text("move the operating point there to search")
    expect(page.locator("body")).not_to_contain_text(re.compile(r"vibro\.[a-z]"))  # no name of Python
    searches = asked(page, "guarantee")
    enter(page, FREQUENCY, "13")
    expect(told).to_have_text(re.compile(r"^forward-slip, at least [\d.]+ mm/s$"))
    assert not searches
    enter(page, FREQUENCY, "19")
    expect(told).to_have_text(bounds)
    expect(page.locator("#says")).to_have_text(bounds)
    assert len(searches) == 1
    page.clock.install()
    page.clock.pause_at(4e9)  # a search waits for a pause between changes
    enter(page, FREQUENCY, "18.5")
    expect(told).to_have_text("back-slip, least speed not proved here: searching …")
    enter(page, FREQUENCY, "-1")
    expect(page.locator("#note-frequency_hz")).to_contain_text("must be")
    page.clock.run_for(1000)
    assert len(searches) == 1
    page.locator("#bands").uncheck()
    enter(page, FREQUENCY, "18.5")
    expect(told).to_be_empty()


def test_bands_are_typed_and_that_of_the_ratio_becomes_one_of_kinetic_friction(open_page: Open) -> None:
    page = open_page()
    page.locator("#bands").check()
    ratio = page.get_by_role("group", name="band of friction ratio")
    expect(ratio.get_by_role("textbox", name="least")).to_have_value("")  # known exactly
    enter(page, "#friction_ratio_band-least", "0.7")
    expect(ratio.get_by_role("textbox", name="most")).to_have_value("0.7")
    with page.expect_response(lambda r: "/point" in r.url and "0.7:0.9" in r.url):
        enter(page, "#friction_ratio_band-most", "0.9")
    expect(page).to_have_url(re.compile("friction_ratio_band=0.7:0.9"))
    expect(page.locator("#apart")).to_contain_text("have no bands")
    expect(ratio.get_by_role("slider", name="most")).to_have_attribute("aria-valuetext", "0.9")
    page.locator("#follow").uncheck()
    expect(ratio).to_be_hidden()
    expect(page).to_have_url(re.compile("#(?!.*ratio_band).*kinetic_friction_band=0.518:0.666"))
    page.locator("#follow").check()
    expect(page).to_have_url(re.compile("#(?!.*kinetic_friction_band).*friction_ratio_band=0.7:0.9"))
    page.locator("#friction_ratio_band-most").fill("0.6")
    page.locator("#friction_ratio_band-most").press("Enter")
    expect(page.get_by_role("alert")).to_contain_text("the band does not ascend")


def test_where_there_are_no_bands_is_said(open_page: Open) -> None:
    page = open_page("#drive=ellipse")
    expect(page.locator("#bands")).to_be_disabled()
    expect(page.locator("#no-bands")).to_be_visible()
    page.locator("#drive").select_option("line")
    expect(page.locator("#no-bands")).to_be_hidden()


def test_a_refusal_is_told_in_the_header_and_leads_to_its_field(open_page: Open) -> None:
    page = open_page()
    alert = page.get_by_role("alert")
    enter(page, "#kinetic_friction", "0.9")
    alert.get_by_role("button", name="kinetic friction = 0.9").click()
    expect(page.locator("#kinetic_friction")).to_be_focused()
    expect(page.locator("#kinetic_friction")).to_have_attribute("aria-invalid", "true")
    enter(page, FREQUENCY, "16")
    expect(alert).to_contain_text("not updated: kinetic friction")
    enter(page, "#kinetic_friction", "0.5")
    expect(alert).to_be_empty()


def test_a_preset_sets_drive_and_axes(open_page: Open) -> None:
    page = open_page()
    page.locator("#drive").select_option("ellipse")
    expect(page.locator("#x")).to_have_value("normal_phase_deg")
    expect(page.locator("#row-amplitude_mm")).to_be_hidden()
    page.locator("#preset").select_option("magnet-50")
    expect(page.locator(FREQUENCY)).to_have_value("50")
    expect(page.locator("#drive")).to_have_value("line")
    expect(page.get_by_role("group", name="over frequency f [Hz] and amplitude")).to_be_visible()
    expect(page.locator("#preset")).to_have_value("")


def test_hovering_tells_the_numbers_of_a_cell(open_page: Open) -> None:
    page = open_page(CONTACT)
    x, y = middle(point(page))
    page.mouse.move(x - 40, y)
    tip = page.locator("#tip")
    expect(tip).to_contain_text(re.compile(r"frequency1\d(\.\d+)? Hz"))
    expect(tip).to_contain_text("mean conveying speed")
    page.keyboard.press("Escape")
    expect(tip).to_be_hidden()


def test_what_is_told_of_a_cell_is_of_the_map_that_is_shown(open_page: Open) -> None:
    page = open_page("#restitution=0.5")
    tip, (x, y) = page.locator("#tip"), middle(page.locator("#cells"))
    page.mouse.move(x, y)
    expect(tip).to_contain_text("frequency")
    page.evaluate("location.hash = '#x=drive_angle_deg&y=static_friction'")
    expect(tip).to_contain_text("drive angle")
    page.mouse.down()
    expect(tip).to_be_hidden()
    page.mouse.up()
    expect(tip).to_be_visible()
    page.evaluate("location.hash = '#static_friction_band=0.6:0.8'")
    expect(tip).to_contain_text("amplitude")
    expect(tip).not_to_contain_text("mean speed")


def test_what_is_not_computed_yet_is_called_so(open_page: Open) -> None:
    page = open_page()
    page.route("**/map?*advance=1*", lambda route: None)  # the first answer stays
    page.evaluate("location.hash = '#restitution=0.45&view=speed'")
    x, y = middle(page.locator("#cells"))
    page.mouse.move(x, y)
    expect(page.locator("#tip")).to_contain_text("hoppingnot computed yet")
    expect(page.locator("#tip")).not_to_contain_text("not modelled")


def test_zero_is_drawn_where_its_axis_has_it(open_page: Open) -> None:
    heights = open_page().evaluate("""[...document.querySelectorAll('#history svg svg')].map((panel) => {
        const ticks = [...panel.parentElement.nextElementSibling.children];
        const zero = ticks.find((tick) => tick.textContent === '0');
        return [panel, zero].map((part) => part.querySelector('path').getBoundingClientRect().y);
    })""")
    assert len(heights) == 4
    for line, tick in heights:
        assert line == pytest.approx(tick, abs=0.1)


@pytest.mark.parametrize(("width", "height"), [(390, 844), (700, 450), (320, 640)])
def test_nothing_is_wider_than_the_window(open_page: Open, width: int, height: int) -> None:
    page = open_page("#view=speed&drive=harmonics", viewport={"width": width, "height": height})
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    for part in ("#stage > svg", "#controls", "#tables", "#toml"):
        box = page.locator(part).bounding_box()
        assert box
        assert box["x"] + box["width"] <= width + 0.5, part


def test_names_of_scales_are_no_longer_than_their_scales(open_page: Open) -> None:
    page = open_page("#view=speed&static_friction_band=0.6:0.8", viewport={"width": 390, "height": 844})
    lengths = page.evaluate("""[...document.querySelectorAll('#frame text')]
        .filter((text) => /speed \\[|amplitude A/.test(text.textContent))
        .map((text) => text.getBoundingClientRect().height)""")
    cells = page.locator("#cells").bounding_box()
    assert cells
    assert len(lengths) == 2
    assert max(lengths) < cells["height"] + 2


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1200, 390])
def test_axe_finds_nothing(open_page: Open, axe: str, scheme: str, width: int) -> None:
    page = open_page(CONTACT, color_scheme=scheme, viewport={"width": width, "height": 844})
    page.locator("#bands").check()
    enter(page, AMPLITUDE, "bla")
    expect(page.locator("#note-amplitude_mm")).not_to_be_empty()
    page.evaluate(axe)
    found: dict[str, Any] = page.evaluate("axe.run()")
    assert len(found["passes"]) > 20
    assert [(v["id"], [node["target"] for node in v["nodes"]]) for v in found["violations"]] == []
