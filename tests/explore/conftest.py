"""The explorer's page in a browser."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from helpers.browsers import PATIENCE, axe, browser
from helpers.explorers import serve_explorer

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from playwright.sync_api import Browser, BrowserContext, Page

__all__ = ["axe", "browser"]


@pytest.fixture(scope="module")
def session(browser: Browser) -> tuple[str, Any]:
    """Serve the explorer, and return its address with what the browser that opened it first has stored."""
    url = serve_explorer()
    with browser.new_context() as context:
        page = context.new_page()
        page.goto(url)
        page.locator("#tables caption").first.wait_for(state="attached")
        return url.partition("#")[0], context.storage_state()


@pytest.fixture(scope="module")
def contexts(browser: Browser, session: tuple[str, Any]) -> Iterator[Callable[..., BrowserContext]]:
    """Return what makes windows of the browser that may ask; those with the same options are one."""
    made: dict[str, BrowserContext] = {}

    def context(**options: Any) -> BrowserContext:
        chosen = {"viewport": {"width": 1200, "height": 800}, **options}
        if repr(chosen) not in made:
            made[repr(chosen)] = browser.new_context(storage_state=session[1], **chosen)
            made[repr(chosen)].set_default_timeout(PATIENCE)
        return made[repr(chosen)]

    yield context
    for context_made in made.values():
        context_made.close()


@pytest.fixture
def open_page(
    session: tuple[str, Any], contexts: Callable[..., BrowserContext]
) -> Iterator[Callable[..., Page]]:
    """Return what opens the page at a fragment, and waits until all of it is there."""
    pages, errors = [], []

    def opened(fragment: str = "", **options: Any) -> Page:
        page = contexts(**options).new_page()
        pages.append(page)
        page.on("pageerror", lambda error: errors.append(error))
        page.goto(session[0] + fragment)
        for part in ("#tables caption", ".curves [data-curve]", "#history p"):
            # This goes on at once, where expect() would look now and then.
            page.locator(part).first.wait_for(state="attached")
        return page

    yield opened
    for page in pages:
        page.close()
    assert not errors
