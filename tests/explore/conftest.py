"""The explorer's page in a browser, opened as a file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from helpers.browsers import PATIENCE, axe, browser

from vibro.explore.page import page_text
from vibro.sweeps.whole import request_of_call

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from playwright.sync_api import Browser, Page

__all__ = ["axe", "browser"]


@pytest.fixture
def open_page(browser: Browser, tmp_path: Path) -> Iterator[Callable[..., Page]]:
    """Return what opens the page of scene files, given as texts, at a fragment; no script may fail."""
    windows, errors = [], list[str]()

    def opened(fragment: str = "", *scenes: str, **options: Any) -> Page:
        requests = []
        for number, text in enumerate(scenes, 1):
            (file := tmp_path / f"scene{number}.toml").write_text(text, encoding="utf-8")
            requests.append(request_of_call(file, {}))
        (file := tmp_path / "page.html").write_text(page_text(requests or [None]), encoding="utf-8")
        window = browser.new_context(**{"viewport": {"width": 1200, "height": 800}, **options})
        window.set_default_timeout(PATIENCE)
        windows.append(window)
        page = window.new_page()
        page.on("pageerror", lambda error: errors.append(error.stack or error.message))
        page.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
        page.goto(file.as_uri() + fragment)
        return page

    yield opened
    for window in windows:
        window.close()
    assert not errors, "\n".join(errors)
