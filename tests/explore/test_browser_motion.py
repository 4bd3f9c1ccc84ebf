"""The motion in a browser: the part on its trough, played, stepped and moved by hand."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from helpers.explored_scenes import FEEDER, GIVEN_DRIVES

if TYPE_CHECKING:
    from collections.abc import Callable

    from playwright.sync_api import Page

_AT = "document.querySelector('#animation rect').parentNode.getAttribute('transform')"


@pytest.fixture
def open_motion(open_page: Callable[..., Page]) -> Callable[..., Page]:
    def opened(*texts: str, **options: str) -> Page:
        page = open_page(*texts, **options)
        page.locator("#history > svg").wait_for()
        return page

    return opened


def when(page: Page) -> str:
    return str(page.locator("#when").text_content())


# Moves a slider, and tells, once the panels are new, whether they were still old when the numbers were new.
_CHANGE = """() => {
  const [history, speed] = ["history", "speed"].map((id) => document.getElementById(id));
  const [panels] = history.children, before = speed.textContent;
  const slider = document.querySelector("input[type=range][name=drive_angle_deg]");
  slider.value = "25";
  slider.dispatchEvent(new Event("input", { bubbles: true }));
  const found = [speed.textContent !== before, panels.isConnected];
  const later = (done) => (panels.isConnected ? setTimeout(later, 10, done) : done(found));
  return new Promise(later);
}"""


def test_the_part_moves_with_the_slider_plays_and_stands_still_again(
    open_motion: Callable[..., Page],
) -> None:
    page = open_motion()
    assert when(page) == "0 ms, rest"
    places = []
    for share, moment in (("0.25", "50 ms, rest"), ("0.5", "100 ms, forward slide")):
        page.locator("#moment").fill(share)
        assert when(page) == moment
        assert page.locator("#moment").get_attribute("aria-valuetext") == moment
        places.append(page.evaluate(_AT))
    assert len({*places}) == 2
    page.locator("#moment").fill("0")
    play = page.locator("#play")
    assert play.text_content() == "Play"
    assert play.get_attribute("title") == "30 times slower"
    play.click()
    page.locator("#when", has_text="slide").wait_for()
    assert float(page.locator("#moment").input_value()) > 0.0
    assert play.text_content() == "Pause"
    play.click()
    still = when(page)
    page.wait_for_timeout(200)
    assert when(page) == still
    assert page.evaluate(_CHANGE) == [True, True]  # a hand sees the motion after the numbers


def test_who_wants_no_motion_moves_on_step_by_step(open_motion: Callable[..., Page]) -> None:
    page = open_motion("#amplitude_mm=4", reduced_motion="reduce")
    play = page.locator("#play")
    assert play.text_content() == "Step"
    before = when(page)
    play.click()
    after = when(page)
    assert after != before
    page.wait_for_timeout(200)
    assert when(page) == after
    titles = page.locator("#history > svg > text[font-weight]").all_text_contents()
    assert titles[-1] == "height above the trough [mm]"
    assert len(titles) == 5


def test_every_drive_has_a_motion(open_motion: Callable[..., Page]) -> None:
    """Drives without sliders, and a machine, each in a tab of its own."""
    given = ("steps, clamped", "third harmonic", "displacements")
    page = open_motion("", *(GIVEN_DRIVES[name] for name in given), FEEDER)
    tabs = page.locator("#tabs button")
    assert tabs.all_text_contents() == ["scene1", "scene2", "scene3", "scene4"]
    for number, drive in enumerate(("given", "given", "given", "machine")):
        tabs.nth(number).click()
        page.wait_for_function(f"document.querySelector('#drive').value === '{drive}'")
        page.locator("#moment").fill("0.7")
        assert " ms, " in when(page)
        assert page.locator("#tables table").count() >= 3
        assert page.locator("#regime").text_content() in ("no-slip", "forward-slip", "back-slip", "hopping")
