"""The page's map in a browser: a hand moves the point, cells have their colours, files can be saved."""

from __future__ import annotations

import csv
import io
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import pytest
from playwright.sync_api import expect

from vibro.core.codes import Regime
from vibro.plots.style import REGIME_COLOURS

if TYPE_CHECKING:
    from collections.abc import Callable

    from playwright.sync_api import Browser, Page

SVG = "{http://www.w3.org/2000/svg}"
# The colour of a place of the map, in shares of its sides from the left and from below.
COLOUR = """([u, v]) => {
  const canvas = document.getElementById("cells");
  const at = [Math.round(u * (canvas.width - 1)), Math.round((1 - v) * (canvas.height - 1))];
  const [r, g, b] = canvas.getContext("2d").getImageData(...at, 1, 1).data;
  return "#" + [r, g, b].map((x) => x.toString(16).padStart(2, "0")).join("").toUpperCase();
}"""


@pytest.fixture
def nut(open_page: Callable[..., Page]) -> Page:
    page = open_page()
    drawn(page)
    return page


def drawn(page: Page) -> None:
    page.locator("[data-curve=hop]").first.wait_for(state="attached")


def place(page: Page, u: float, v: float) -> tuple[float, float]:
    box = page.locator("#surface").bounding_box()
    assert box
    return box["x"] + u * box["width"], box["y"] + (1.0 - v) * box["height"]


def field(page: Page, column: str) -> float:
    return float(page.locator(f"#{column}").input_value())


def put(page: Page, box: str, text: str) -> None:
    page.fill(f"#{box}", text)
    page.press(f"#{box}", "Tab")


def test_a_hand_moves_the_operating_point(nut: Page) -> None:
    nut.mouse.click(*place(nut, 0.5, 0.5))
    assert field(nut, "frequency_hz") == pytest.approx(32.5, abs=0.2)
    assert field(nut, "amplitude_mm") == pytest.approx(1.55, abs=0.01)
    nut.mouse.move(*place(nut, 0.5, 0.5))
    nut.mouse.down()
    nut.mouse.move(*place(nut, 0.7, 0.2), steps=3)
    nut.mouse.up()
    assert field(nut, "frequency_hz") == pytest.approx(43.5, abs=0.2)
    assert "frequency_hz=43.5" in nut.url
    nut.mouse.move(*place(nut, 0.7, 0.2))
    nut.mouse.down()
    nut.mouse.move(*place(nut, 1.5, 0.2), steps=3)  # no farther than the map's edge
    nut.mouse.up()
    assert field(nut, "frequency_hz") == 60.0


def test_cells_have_colours_and_a_tip_and_keys_move_the_point(nut: Page) -> None:
    expect(nut.locator("#frame")).not_to_contain_text("preview")
    for u, v, regime in (
        (0.02, 0.02, Regime.NO_SLIP),
        (0.9, 0.9, Regime.HOPPING),
        (0.18, 0.31, Regime.FORWARD_SLIP),
    ):
        assert nut.evaluate(COLOUR, [u, v]) == REGIME_COLOURS[regime]
    names = nut.locator("#frame").evaluate("(frame) => frame.textContent")
    for name in (
        "no-slip",
        "back-slip onset",
        "hop limit",
        "operating point: 15 Hz, 1 mm",
        "frequency f [Hz]",
    ):
        assert name in names
    nut.mouse.move(*place(nut, 0.9, 0.9))
    tip = nut.locator("#tip")
    expect(tip).to_contain_text("hopping")
    expect(tip).to_contain_text("mean speed [mm/s]")
    nut.keyboard.press("Escape")
    expect(tip).to_be_hidden()
    nut.locator("#point").focus()
    nut.keyboard.press("ArrowRight")
    assert field(nut, "frequency_hz") == pytest.approx(15.55)
    nut.keyboard.press("Shift+ArrowUp")
    assert field(nut, "amplitude_mm") == pytest.approx(1.29)
    expect(nut.locator("#point")).to_have_attribute("aria-valuetext", "frequency 15.55 Hz, amplitude 1.29 mm")
    nut.locator("#copy-command").click()
    expect(nut.locator("#says")).to_have_text("selected")  # a window of tests refuses
    assert nut.evaluate("getSelection().toString()").startswith("vibro map ")


def test_a_map_follows_the_state(nut: Page) -> None:
    for friction in ("0.7", "0.5", "0.3"):  # each change cancels the one before
        put(nut, "static_friction", friction)
    nut.locator("#view").select_option("speed")
    frame = nut.locator("#frame")
    expect(frame).to_contain_text("Mean conveying speed")
    expect(frame).to_contain_text("μ_s = 0.3")
    expect(nut.locator("#notes")).to_contain_text("Largest here: ")
    nut.set_viewport_size({"width": 500, "height": 800})
    assert nut.locator("#map").bounding_box()["width"] <= 500.0  # type: ignore[index]
    put(nut, "frequency_hz", "99")
    expect(nut.locator("#outside")).to_be_visible()


# How often the map is drawn for another view, below which there is less to tell.
_DRAWN = """() => new Promise((done) => {
  const [frame, stage, view] = ["frame", "stage", "view"].map((id) => document.getElementById(id));
  const before = stage.clientHeight;
  let count = 0;
  new MutationObserver(() => count++).observe(frame, { childList: true });
  view.value = "speed";
  view.dispatchEvent(new Event("change", { bubbles: true }));
  setTimeout(() => done([count, stage.clientHeight !== before]), 300);
})"""


def test_a_change_draws_one_picture(nut: Page) -> None:
    expect(nut.locator("#frame")).not_to_contain_text("preview")
    assert nut.evaluate(_DRAWN) == [1, True]


def downloaded(page: Page, button: str) -> Path:
    with page.expect_download() as told:
        page.locator(f"#{button}").click()
    name = told.value.suggested_filename
    assert name == "scene.toml" or name.startswith("vibro-nut-")
    expect(page.locator("#saving")).to_have_text(f"{name} was handed to the browser.")
    return Path(told.value.path())


def test_files_can_be_taken_along(nut: Page) -> None:
    svg = ElementTree.parse(downloaded(nut, "svg")).getroot()
    assert not [*svg.iter(f"{SVG}foreignObject")]
    assert next(svg.iter(f"{SVG}image")).get("href", "").startswith("data:image/png;base64,")
    assert "hop limit" in [text.text for text in svg.iter(f"{SVG}text")]
    assert downloaded(nut, "png").read_bytes().startswith(b"\x89PNG")
    tables = [downloaded(nut, name).read_text(encoding="utf-8") for name in ("csv", "csv-comma")]
    points, commas = (
        [*csv.reader(io.StringIO(text), delimiter=mark)] for text, mark in zip(tables, ",;", strict=True)
    )
    assert len(points) == len(commas) == 30_001
    assert points[1] == [text.replace(",", ".") for text in commas[1]]
    scene = tomllib.loads(downloaded(nut, "save-toml").read_text(encoding="utf-8"))
    assert scene["map"] == {"amplitude_mm": "0.1:3:150", "frequency_hz": "5:60:200"}


_NO_WORKERS = (
    "window.Worker = class { constructor() { throw new Error('not here'); } };",
    "window.Worker = class { constructor() { setTimeout(() => this.onerror(), 50); } postMessage() {} };",
)


@pytest.mark.parametrize("script", _NO_WORKERS)
def test_without_workers_the_page_solves_itself(script: str, browser: Browser, tmp_path: Path) -> None:
    from vibro.explore.page import page_text

    (file := tmp_path / "page.html").write_text(page_text(), encoding="utf-8")
    with browser.new_context() as window:
        page, errors = window.new_page(), list[Any]()
        page.on("pageerror", lambda error: errors.append(error))
        page.add_init_script(script)
        page.goto(f"{file.as_uri()}#view=speed")
        drawn(page)
        expect(page.locator("#notes")).to_contain_text("Largest here: ")
        assert not errors
