"""How a browser begins the session, and who learns of its secret."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import TYPE_CHECKING, Any

import pytest
from helpers.browsers import PATIENCE
from helpers.explorers import serve_explorer
from helpers.pages import expect, speed

from vibro.explore.handover import handed_over

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from playwright.sync_api import Browser, BrowserContext, Page


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    """Return a browser that knows nothing yet."""
    with browser.new_context() as made:
        made.set_default_timeout(PATIENCE)
        yield made


def test_the_file_that_is_handed_over_begins_the_session(
    context: BrowserContext, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    url, begun = serve_explorer()
    page = context.new_page()
    with handed_over(url) as file:
        page.goto(file.as_uri())
        speed(page, "16.2635 mm/s")
    assert begun.is_set()
    assert page.url == url.partition("#")[0]  # the token is gone from it
    page.reload()
    speed(page, "16.2635 mm/s")
    other = context.new_page()  # several windows may be open
    other.goto(page.url + "#frequency_hz=20")
    speed(other, "42.3239 mm/s")
    other.goto(url)  # which counted once, and is known by now
    speed(other, "16.2635 mm/s")


def test_a_browser_without_a_session_is_told_and_takes_the_address_in_the_same_tab(
    context: BrowserContext,
) -> None:
    url, begun = serve_explorer()
    page = context.new_page()
    page.goto(url.partition("#")[0])
    expect(page.locator("#gone")).to_contain_text("open the address that it printed")
    assert page.locator("#controls").inner_text() == ""  # nothing of the scene is shown to strangers
    assert not begun.is_set()
    page.goto(url)  # another fragment alone: the browser does not load the page anew by itself
    speed(page, "16.2635 mm/s")
    expect(page.locator("#gone")).to_be_empty()


def test_no_other_server_of_this_host_learns_the_secret(open_page: Callable[..., Page]) -> None:
    page = open_page()
    stored: dict[str, str] = page.evaluate("({ ...localStorage })")
    (secret,) = stored.values()
    with listening() as (address, heard):
        page.goto(address)
        assert page.evaluate("({ ...localStorage })") == {}
        page.evaluate("fetch('/again')")
    assert len(heard) >= 2
    assert not any("cookie" in headers or secret in str(headers) for headers in heard)


@contextmanager
def listening() -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Serve as another user could, at another port; give its address, and the headers that it gets."""
    heard: list[dict[str, Any]] = []

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            heard.append({name.lower(): value for name, value in self.headers.items()})
            self.send_response(200)
            self.end_headers()

        def log_message(self, *_: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/", heard
        server.shutdown()
