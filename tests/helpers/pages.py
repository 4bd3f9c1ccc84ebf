"""What tests of the explorer's page share: its parts, and what it asks."""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qs, urlsplit

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    from playwright.sync_api import Locator, Page, Request

_PLAYWRIGHT = "playwright.sync_api"
if os.environ.get("VIBRO_BROWSER") == "required":
    _api: Any = importlib.import_module(_PLAYWRIGHT)
else:
    _api = pytest.importorskip(_PLAYWRIGHT, reason="playwright is not installed")
expect = _api.expect

FREQUENCY, AMPLITUDE = "#frequency_hz", "#amplitude_mm"
CONTACT = "#view=speed&x_range=5:14"  # a map without bodies that hop is exact at once


def point(page: Page) -> Locator:
    return page.get_by_role("slider", name="operating point")


def middle(locator: Locator) -> tuple[float, float]:
    box = locator.bounding_box()
    assert box
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def asked(page: Page, kind: str) -> list[dict[str, list[str]]]:
    """Return a list that grows with the queries of a route."""
    found: list[dict[str, list[str]]] = []

    def note(request: Request) -> None:
        url = urlsplit(request.url)
        if url.path == f"/{kind}":
            found.append(parse_qs(url.query))

    page.on("request", note)
    return found


def until(page: Page, holds: Callable[[], bool]) -> None:
    """Let the browser go on until something holds; a test that it never does runs into its time limit."""
    while not holds():
        page.wait_for_timeout(5)


def until_asked(page: Page, queries: list[dict[str, list[str]]], field: str, text: str) -> None:
    """Wait until the newest query of a route has this text of a field."""
    until(page, lambda: [query.get(field) for query in queries[-1:]] == [[text]])


def enter(page: Page, field: str, text: str) -> None:
    page.locator(field).fill(text)
    page.locator(field).press("Enter")


def speed(page: Page, text: str) -> None:
    expect(page.locator("#speed")).to_have_text(text)
