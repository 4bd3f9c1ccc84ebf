"""The page as a whole in a browser: from a disk, in a frame, on paper, on a telephone."""

from __future__ import annotations

import io
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from helpers.explored_scenes import FEEDER
from PIL import Image

import vibro

if TYPE_CHECKING:
    from collections.abc import Callable

    from playwright.sync_api import Browser, Page

PICTURE = Path(__file__).parents[2] / "docs" / "images" / "explore.png"
FOUND = """axe.run({resultTypes: ["violations"]}).then(
    (found) => found.violations.map((one) => [one.id, one.nodes.map((node) => node.target)]))"""
NUT = """[scene]
amplitude_mm = 1
frequency_hz = 15
drive_angle_deg = 20
static_friction = 0.74
kinetic_friction = 0.57
trough_length_mm = 600
"""


def regime(page: Any) -> str:
    page.locator("#tables table").first.wait_for(state="attached")
    return str(page.locator("#regime").text_content())


def test_it_computes_from_a_disk_and_breaks_no_policy(open_page: Callable[..., Page]) -> None:
    page = open_page("", NUT)
    requests: list[str] = []
    page.on("request", lambda request: requests.append(request.url))
    assert regime(page) == "forward-slip"
    assert page.locator("#speed").text_content() == "16.2635 mm/s"
    assert "vibro" in page.title()
    page.locator("#map .curves path, #frame path").first.wait_for(state="attached")
    assert [url for url in requests if not url.startswith("blob:")] == []


def test_names_of_a_scene_stay_texts(open_page: Callable[..., Page]) -> None:
    packed = FEEDER.replace("6 leaves", "<img src=x onerror=alert(1)>")
    page = open_page("", packed, NUT)
    regime(page)
    assert page.locator("img").count() == 0
    assert "<img src=x onerror=alert(1)>" in page.locator("#pack option").all_text_contents()


def test_long_names_stay_in_their_frames_on_a_telephone(open_page: Callable[..., Page]) -> None:
    packed = FEEDER.replace("6 leaves", 100_000 * "l")
    page = open_page("", packed, NUT, viewport={"width": 390, "height": 844})
    regime(page)
    page.locator("#compare tbody th").first.evaluate("(name) => (name.textContent = 'n'.repeat(200))")
    assert page.evaluate("document.scrollingElement.scrollWidth") <= 390
    assert page.locator("#compare").evaluate("(frame) => frame.scrollWidth - frame.clientWidth") == 0
    assert page.evaluate("document.scrollingElement.scrollHeight") < 7000


def test_it_looks_as_the_readme_shows_it(open_page: Callable[..., Page]) -> None:
    """With VIBRO_DRAW=1 the picture is made anew."""
    page = open_page("#view=speed", NUT, viewport={"width": 1360, "height": 860})
    regime(page)
    page.locator("#map .curves path, #frame path").first.wait_for(state="attached")
    while "exact" in str(page.locator("#stage").text_content()):  # something is left to be computed
        page.wait_for_timeout(50)
    page.mouse.move(1, 1)
    drawn = page.screenshot()
    if os.environ.get("VIBRO_DRAW"):
        PICTURE.write_bytes(drawn)
    fresh, shown = (np.asarray(Image.open(x).convert("L"), float) for x in (io.BytesIO(drawn), PICTURE))
    assert fresh.shape == shown.shape
    assert np.abs(fresh - shown).mean() < 2.0  # of 255: fonts differ from machine to machine


@pytest.mark.parametrize(("width", "scheme"), [(1200, "light"), (390, "dark")])
def test_axe_finds_nothing(width: int, scheme: str, open_page: Callable[..., Page], axe: str) -> None:
    page = open_page("", NUT, FEEDER, viewport={"width": width, "height": 844}, color_scheme=scheme)
    regime(page)
    page.locator("#bands").check()
    page.evaluate(axe)
    assert page.evaluate(FOUND) == []


_HOPS = "#amplitude_mm=4&frequency_hz=20&static_friction_band=0.6:0.8&view=speed&target=20"


@pytest.mark.parametrize(
    ("scheme", "asked", "width"),
    [("dark", ("", FEEDER), 390), ("light", (_HOPS, NUT, FEEDER), 1200)],
    ids=["feeder", "both"],
)
def test_paper_has_question_map_numbers_and_motion_on_two_sheets(
    scheme: str, asked: tuple[str, ...], width: int, open_page: Callable[..., Page]
) -> None:
    page = open_page(*asked, viewport={"width": width, "height": 844}, color_scheme=scheme)
    regime(page)
    page.locator("#history path").first.wait_for(state="attached")
    page.locator("#map .curves path").first.wait_for(state="attached")
    sheets = page.pdf(format="A4")
    assert len(re.findall(rb"/Type\s*/Page\b", sheets)) <= 2
    assert page.evaluate("document.scrollingElement.scrollWidth") <= width  # on the screen again
    page.emulate_media(media="print")
    for part in ("#print-question", "#map", "#tables", "#history", "#leaves-out"):
        assert page.locator(part).is_visible(), part
    for part in ("#controls", "#save", "#take", "#tabs", "#play"):
        assert not page.locator(part).is_visible(), part
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"


def test_a_notebook_shows_it_in_a_frame(browser: Browser, tmp_path: Path) -> None:
    (file := tmp_path / "nut.toml").write_text(NUT, encoding="utf-8")
    (tmp_path / "notebook.html").write_text(
        f"<!doctype html><title>n</title>{vibro.page(file)._repr_html_()}", encoding="utf-8"
    )
    with browser.new_context() as window:
        page, errors = window.new_page(), list[str]()
        page.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
        page.goto((tmp_path / "notebook.html").as_uri())
        frame = page.frame_locator("iframe")
        assert regime(frame) == "forward-slip"
        before = frame.locator("#command").text_content()
        frame.locator("#drive_angle_deg").fill("21")
        frame.locator("#drive_angle_deg").press("Tab")  # which a frame without addresses takes too
        page.wait_for_timeout(500)
        assert frame.locator("#command").text_content() != before
        assert not errors
