"""A browser for the tests of pages, and what looks at them.

Without a browser the tests that need one are skipped by name; where VIBRO_BROWSER is "required" they fail.
VIBRO_AXE is the path of axe.min.js, from the npm package axe-core.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator

    from playwright.sync_api import Browser

PATIENCE = 30_000  # [ms] of a busy machine
_PROGRAMS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")  # the lightest first
_OPTIONS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip


def _give_up(reason: str) -> NoReturn:
    if os.environ.get("VIBRO_BROWSER") == "required":
        pytest.fail(reason)
    pytest.skip(reason)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Start the system's Chromium."""
    program = next(filter(None, map(shutil.which, _PROGRAMS)), None)
    if program is None:
        _give_up("no Chromium is installed")
    try:
        from playwright.sync_api import expect, sync_playwright
    except ImportError:
        _give_up("playwright is not installed")
    expect.set_options(timeout=PATIENCE)
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=program, args=list(_OPTIONS))
        yield started
        started.close()


@pytest.fixture(scope="module")
def axe() -> str:
    """Return the script of axe-core, which finds what keeps people from using a page."""
    path = os.environ.get("VIBRO_AXE")
    if not path:
        _give_up("VIBRO_AXE does not say where axe.min.js is")
    return Path(path).read_text(encoding="utf-8")
