"""The motion in a browser: the part on its trough, played, stepped and moved by hand."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from helpers.explored_scenes import FEEDER, GIVEN_DRIVES

if TYPE_CHECKING:
    from collections.abc import Callable

    from playwright.sync_api import Page

_AT = "document.querySelector('#animation rect').parentNode.getAttribute('transform')"


def when(page: Page) -> str:
    return str(page.locator("#when").text_content())


def test_the_part_moves_with_the_slider(open_page: Callable[..., Page]) -> None:
    page = open_page()
    assert when(page) == "0 ms, rest"
    places = []
    for share, moment in (("0.25", "50 ms, rest"), ("0.5", "100 ms, forward slide")):
        page.locator("#moment").fill(share)
        assert when(page) == moment
        assert page.locator("#moment").get_attribute("aria-valuetext") == moment
        places.append(page.evaluate(_AT))
    assert len({*places}) == 2


def test_it_plays_and_stands_still_again(open_page: Callable[..., Page]) -> None:
    page = open_page()
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


def test_who_wants_no_motion_moves_on_step_by_step(open_page: Callable[..., Page]) -> None:
    page = open_page(reduced_motion="reduce")
    play = page.locator("#play")
    assert play.text_content() == "Step"
    play.click()
    assert when(page) == "3.33 ms, rest"
    page.wait_for_timeout(200)
    assert when(page) == "3.33 ms, rest"


def test_panels_are_those_of_the_motion(open_page: Callable[..., Page]) -> None:
    page = open_page("#amplitude_mm=4")
    titles = page.locator("#history > svg > text[font-weight]").all_text_contents()
    assert titles[-1] == "height above the trough [mm]"
    assert len(titles) == 5
    assert page.locator("#history > svg").get_attribute("aria-label") == "first 3 drive cycles from rest"


@pytest.mark.parametrize("scene", [FEEDER, GIVEN_DRIVES["steps, clamped"], GIVEN_DRIVES["third harmonic"]])
def test_every_drive_has_a_motion(scene: str, open_page: Callable[..., Page]) -> None:
    page = open_page("", scene)
    page.locator("#history > svg").wait_for()
    page.locator("#moment").fill("0.7")
    assert " ms, " in when(page)
    assert page.locator("#tables table").count() >= 3
