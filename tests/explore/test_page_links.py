"""The explorer's page and the world: its address, what it asks the server, and what can be taken along."""

from __future__ import annotations

import re
import struct
from typing import TYPE_CHECKING
from urllib.parse import urlsplit
from xml.etree import ElementTree

from helpers.cases import each
from helpers.pages import AMPLITUDE, CONTACT, FREQUENCY, asked, enter, expect, speed, until

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from playwright.sync_api import Page, Route

    Open = Callable[..., Page]

SVG = "{http://www.w3.org/2000/svg}"


def test_a_map_that_cannot_be_asked_is_asked_again_once_its_axis_is_mended(open_page: Open) -> None:
    page = open_page()
    enter(page, "#x-from", "70")
    expect(page.locator("#x-to")).to_have_attribute("aria-invalid", "true")
    expect(page.locator("#note-x_range")).to_contain_text("ascend")
    enter(page, "#x-from", "5")
    expect(page.locator("#note-x_range")).to_be_empty()
    with page.expect_response("**/map?**"):
        enter(page, "#x-from", "10")


def test_a_link_shows_the_same(open_page: Open) -> None:
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


def test_back_and_forward_go_through_the_changes(open_page: Open) -> None:
    page = open_page()
    enter(page, FREQUENCY, "16")
    page.locator("#view").select_option("speed")
    expect(page.get_by_role("group", name="Mean conveying speed")).to_be_visible()
    page.go_back()
    expect(page.get_by_role("group", name="Regimes")).to_be_visible()
    expect(page.locator(FREQUENCY)).to_have_value("16")
    page.go_back()
    expect(page.locator(FREQUENCY)).to_have_value("15")
    speed(page, "16.2635 mm/s")
    page.go_forward()
    expect(page.locator(FREQUENCY)).to_have_value("16")


def test_a_bad_link_says_so_and_shows_the_initial_state(open_page: Open) -> None:
    page = open_page("#amplitude_mm=banana&view=foo")
    alert = page.get_by_role("alert")
    expect(alert).to_contain_text("This link could not be read: view = 'foo'")
    expect(alert).to_contain_text("The initial state is shown.")
    expect(page.locator(AMPLITUDE)).to_have_value("1")
    speed(page, "16.2635 mm/s")
    enter(page, AMPLITUDE, "0.9")
    expect(alert).to_be_empty()
    page.evaluate("location.hash = '#frequency_hz=-5&amplitude_mm=2'")
    expect(alert).to_contain_text("must be in ")
    expect(page.locator(AMPLITUDE)).to_have_value("1")
    speed(page, "16.2635 mm/s")
    page.evaluate("location.hash = '#amplitude_mm=2'")
    expect(alert).to_be_empty()
    expect(page.locator(AMPLITUDE)).to_have_value("2")


@each("name", ["toString", "constructor", "__proto__", "hasOwnProperty"])
def test_names_that_every_object_knows_are_refused_as_any_other(open_page: Open, name: str) -> None:
    page = open_page(f"#drive={name}&{name}=&x={name}&view={name}")
    expect(page.get_by_role("alert")).to_contain_text(
        f"This link could not be read: drive = '{name}': must be line, ellipse, harmonics"
    )
    speed(page, "16.2635 mm/s")


def test_one_question_at_a_time_and_the_newest_wins(open_page: Open) -> None:
    page = open_page(CONTACT)
    held: list[Route] = []
    page.route("**/map?**", lambda route: held.append(route))
    angle = page.get_by_role("slider", name="drive angle, slider")
    angle.focus()
    with page.expect_request("**/map?**"):
        page.keyboard.press("ArrowRight")
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    expect(page.locator("#tables")).to_contain_text("drive angle 20.6 deg")  # other kinds do not wait
    assert len(held) == 1
    with page.expect_request("**/map?**") as last:
        held[0].continue_()
    assert "drive_angle_deg=20.6" in last.value.url  # of the states between nobody asks
    until(page, lambda: len(held) == 2)
    enter(page, "#x-to", "16")
    held[1].continue_()
    until(page, lambda: len(held) == 3)
    held[2].continue_()
    expect(page.locator("#stage > svg text", has_text=re.compile("^16$"))).to_be_visible()


def test_refining_goes_on_until_the_state_moves_on(open_page: Open) -> None:
    page = open_page()
    queries = asked(page, "map")
    with page.expect_request(lambda request: "advance=1" in request.url):
        enter(page, "#restitution", "0.3")
        page.locator("#view").select_option("speed")
    unfinished = page.locator("#stage > svg text", has_text="% exact")
    expect(unfinished).to_be_visible()  # the picture says what is not exact
    enter(page, "#x-to", "14")
    expect(unfinished).to_have_count(0)
    assert queries[-1]["x_range"] == ["5:14"]
    count = len(queries)
    enter(page, FREQUENCY, "12")
    expect(page.locator("#tables")).to_contain_text("frequency 12 Hz")
    assert len(queries) == count


def test_a_server_that_is_gone_is_told_and_awaited(open_page: Open) -> None:
    page = open_page()
    page.context.set_offline(True)
    enter(page, FREQUENCY, "20")
    banner = page.locator("#gone")
    expect(banner).to_contain_text("vibro does not answer: is it still running?")
    expect(page.locator(FREQUENCY)).to_have_value("20")
    page.context.set_offline(False)
    expect(banner).to_be_empty()
    expect(page.locator("#tables")).to_contain_text("frequency 20 Hz")
    expect(page).to_have_title(re.compile("back-slip"))


def test_a_server_that_was_started_anew_is_told_and_awaited(open_page: Open) -> None:
    page = open_page()
    secret = page.evaluate("localStorage.getItem('vibro-session')")
    page.evaluate("localStorage.setItem('vibro-session', 'of the last one')")
    enter(page, FREQUENCY, "20")
    expect(page.locator("#gone")).to_contain_text("vibro was started anew")
    page.evaluate("(secret) => localStorage.setItem('vibro-session', secret)", secret)
    expect(page.locator("#gone")).to_be_empty()
    expect(page.locator("#tables")).to_contain_text("frequency 20 Hz")


def test_pictures_and_texts_can_be_saved(open_page: Open, tmp_path: Path) -> None:
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


def test_a_table_that_cannot_be_had_is_told(open_page: Open) -> None:
    page = open_page()
    page.route("**/table.csv?*", lambda route: route.abort())
    page.locator("#csv").click()
    expect(page.locator("#saving")).to_have_text("There is no CSV: mend what is refused above, or ask again.")


def test_the_command_line_can_be_copied(open_page: Open) -> None:
    page = open_page()
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.locator("#copy-command").click()
    expect(page.locator("#copy-command")).to_have_text("Copied")
    expect(page.locator("#says")).to_have_text("copied")
    expect(page.locator("#copy-toml")).to_have_text("Copy")
    assert page.evaluate("navigator.clipboard.readText()") == page.locator("#command").inner_text()
    expect(page.locator("#copy-command")).to_have_text("Copy")
