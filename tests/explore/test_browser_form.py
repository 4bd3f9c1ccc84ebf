"""The page's settings in a browser: what they change, what is refused, tabs, the address."""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import parse_qs

import pytest
from helpers.explored_scenes import FEEDER, GIVEN_DRIVES

from vibro.explore.controls import BANDS, CONTROLS, DRIVES, PRESETS, VIEWS
from vibro.quantities import MACHINE, QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Callable

    from playwright.sync_api import Frame, Page


def put(page: Page | Frame, box: str, text: str) -> None:
    page.fill(f"#{box}", text)
    page.press(f"#{box}", "Tab")


def shown(page: Page, *boxes: str) -> list[str]:
    return [page.input_value(f"#{box}") for box in boxes]


def address(page: Page) -> dict[str, str]:
    """Return the state that the address holds."""
    fragment: str = page.evaluate("location.hash")
    return {key: texts[0] for key, texts in parse_qs(fragment[1:]).items()}


@pytest.fixture
def nut(open_page: Callable[..., Page]) -> Page:
    return open_page()


def test_every_key_has_a_box_with_a_label(nut: Page) -> None:
    def all_of(selector: str, what: str) -> list[str]:
        found: list[str] = nut.evaluate(
            f"[...document.querySelectorAll({selector!r})].map((part) => part.{what})"
        )
        return found

    names = {*all_of("input[name], select[name]", "name")}
    quantities = {*CONTROLS} - {"friction_ratio", "motion_scale", "normal_acceleration", *MACHINE}
    keys = {QUANTITIES[name].column for name in quantities} | {f"{name}_band" for name in BANDS}
    choices = (
        "view",
        "drive",
        "preset",
        "x",
        "y",
        "x_range",
        "y_range",
        "follow",
        "bands",
        "target",
        "cycles",
    )
    assert names == {*keys, *choices}
    ids = all_of("[id]", "id")
    assert [name for name in ids if ids.count(name) > 1] == []
    for attribute in ("for", "aria-describedby", "aria-labelledby"):
        assert {*all_of(f"[{attribute}]", f"getAttribute('{attribute}')")} <= {*ids}
    assert all_of("#view option, #preset option, #drive option", "value") == [*VIEWS, "", *PRESETS, *DRIVES]


def test_numbers_have_units_and_friction_follows(nut: Page) -> None:
    put(nut, "frequency_hz", "900rpm")
    put(nut, "static_friction", "0,8")
    assert shown(nut, "frequency_hz", "static_friction", "kinetic_friction") == ["15", "0.8", "0.6162"]
    assert address(nut)["kinetic_friction"] == "0.6162"
    put(nut, "frequency_hz", "2000rpm")
    assert shown(nut, "frequency_hz") == ["33.3333333333333"]
    assert address(nut)["frequency_hz"] == "33.333333333333336"
    nut.uncheck("#follow")
    put(nut, "static_friction", "0.5")
    assert shown(nut, "kinetic_friction") == ["0.5"]


def test_what_is_refused_is_told_beside_its_box(nut: Page) -> None:
    speed = nut.inner_text("#speed")
    put(nut, "amplitude_mm", "-1")
    said = "amplitude = -1 mm: must be in [1e-12, 1e+09] mm"
    assert nut.inner_text("#note-amplitude_mm") == said
    assert nut.inner_text("#refused") == f"not updated: {said}"
    assert nut.get_attribute("#amplitude_mm", "aria-invalid") == "true"
    assert nut.inner_text("#speed") == speed
    nut.click("#refused button")
    assert nut.evaluate("document.activeElement.id") == "amplitude_mm"
    put(nut, "amplitude_mm", "0.8")
    assert nut.inner_text("#refused") == nut.inner_text("#note-amplitude_mm") == ""
    assert nut.get_attribute("#amplitude_mm", "aria-invalid") == "false"


def test_bands_are_there_for_all_drives(nut: Page) -> None:
    for drive in DRIVES:
        nut.select_option("#drive", drive)
        nut.check("#bands")
        assert shown(nut, "static_friction_band-least", "static_friction_band-most") == ["0.666", "0.814"]
        assert nut.is_visible("#row-friction_ratio_band") == nut.is_checked("#follow")
        assert nut.inner_text("#refused") == ""
        nut.uncheck("#bands")
        assert "static_friction_band" not in address(nut)
    nut.check("#bands")
    put(nut, "restitution_band-most", "0,3")
    put(nut, "restitution_band-least", "0,1")
    nut.uncheck("#follow")
    assert address(nut)["kinetic_friction_band"] == "0.513:0.627"
    assert address(nut)["restitution_band"] == "0.1:0.3"
    nut.select_option("#x", "static_friction")
    assert not nut.is_checked("#bands")
    assert nut.is_disabled("#bands")


def test_axes_swap_and_each_step_can_be_undone(nut: Page) -> None:
    nut.select_option("#preset", "bowl-50")
    assert address(nut)["drive"] == "ellipse"
    nut.select_option("#x", "restitution")
    nut.select_option("#y", "restitution")
    assert shown(nut, "x", "y", "y-to") == ["along_amplitude_mm", "restitution", "0.9"]
    nut.go_back()
    assert shown(nut, "x", "y", "x-to") == ["restitution", "along_amplitude_mm", "0.9"]
    nut.go_back()
    nut.go_back()
    assert shown(nut, "drive", "x", "y") == ["line", "frequency_hz", "amplitude_mm"]


def test_a_drag_is_one_step_to_undo(nut: Page) -> None:
    drag = """(ends) => {
        const slider = document.querySelector("input[type=range][name=frequency_hz]");
        for (let n = ends[0]; n <= ends[1]; n++) {
            slider.value = n;
            slider.dispatchEvent(new Event("input", { bubbles: true }));
        }
        slider.dispatchEvent(new Event("change", { bubbles: true }));
    }"""
    before = nut.evaluate("history.length")
    nut.evaluate(drag, [20, 40])
    assert nut.evaluate("history.length") == before + 1
    assert address(nut)["frequency_hz"] == "40"
    assert nut.get_attribute("[type=range][name=frequency_hz]", "aria-valuetext") == "40 Hz"
    put(nut, "drive_angle_deg", "30")
    assert nut.evaluate("history.length") == before + 2
    nut.go_back()
    nut.go_back()
    assert shown(nut, "frequency_hz") == ["15"]


def test_bands_come_back_when_kinetic_friction_follows_again(nut: Page) -> None:
    nut.check("#bands")
    put(nut, "static_friction_band-least", "0.3")
    put(nut, "static_friction_band-most", "0.4")
    nut.uncheck("#follow")
    assert nut.inner_text("#refused") == ""
    assert address(nut)["kinetic_friction_band"] == "0.2311:0.3081"
    put(nut, "kinetic_friction_band-least", "0.25")
    nut.check("#follow")
    assert {*address(nut)} & {f"{name}_band" for name in BANDS} == {"static_friction_band"}
    nut.uncheck("#follow")
    assert address(nut)["kinetic_friction_band"] == "0.25:0.3081"
    nut.check("#follow")
    put(nut, "static_friction_band-least", "0.1")  # what was typed for other bands may no longer be
    put(nut, "static_friction_band-most", "0.2")
    nut.uncheck("#follow")
    assert nut.inner_text("#refused") == ""
    nut.uncheck("#bands")
    nut.check("#bands")
    assert address(nut)["kinetic_friction_band"] == "0.513:0.627"


def test_each_tab_has_a_state_of_its_own(open_page: Callable[..., Page]) -> None:
    page = open_page("", GIVEN_DRIVES["third harmonic"], FEEDER)
    assert page.locator("#tabs button").all_inner_texts() == ["scene1", "scene2"]
    rows = page.locator("#compare tbody tr")
    assert rows.count() == 2
    assert [text.split("\t")[0] for text in rows.all_inner_texts()] == ["scene1", "scene2"]
    put(page, "motion_scale", "2")
    page.click("#tabs button:nth-child(2)")
    assert address(page)["scene"] == "2"
    page.select_option("#pack", "4 & a half")
    assert shown(page, "natural_hz") == ["47.6"]
    put(page, "natural_hz", "40")
    assert shown(page, "pack") == [""]
    page.click("#tabs button:nth-child(1)")
    assert shown(page, "motion_scale", "drive") == ["2", "given"]
    link = page.evaluate("location.hash")
    page.click("#tabs button:nth-child(2)")
    assert shown(page, "natural_hz") == ["40"]
    page.go_back()
    assert page.evaluate("location.hash") == link
    assert shown(page, "motion_scale") == ["2"]


def test_a_link_that_cannot_be_read_shows_the_start(open_page: Callable[..., Page]) -> None:
    page = open_page("#top&view=speed&view=flight")
    said = "'top' has no value (write top=...); 'view' is given twice (leave one out)"
    assert page.inner_text("#refused") == f"This link could not be read: {said}. The initial state is shown."
    assert shown(page, "frequency_hz") == ["15"]
    put(page, "frequency_hz", "20")
    assert page.inner_text("#refused") == ""
    again = open_page(page.evaluate("location.hash"))
    assert shown(again, "frequency_hz") == ["20"]


def test_paper_says_what_is_asked(nut: Page) -> None:
    put(nut, "trough_angle_deg", "-5")
    nut.emulate_media(media="print")
    said = nut.inner_text("#print-question")
    assert "trough moved along a line: amplitude 1 mm, frequency 15 Hz, drive angle 20°" in said
    assert "trough angle \N{MINUS SIGN}5°" in said
    nut.emulate_media(media="screen")
    nut.check("#bands")
    said = nut.text_content("#print-question") or ""
    assert "static friction 0.666 to 0.814, friction ratio 0.77027, trough" in said
    own = "numbers and motion are those of the operating point, not of the bands"
    assert said.endswith(f"; {own}: static friction 0.74, kinetic friction 0.57")
    nut.emulate_media(media="print")
    nut.emulate_media(media="screen")
    assert nut.is_visible("#controls")
