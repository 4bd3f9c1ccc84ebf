"""The site of docs: its links, what it loads, what it lists, and how it is seen.

VIBRO_SITE is the path of a built site, as .ci/run gives it: ``sphinx-build -W docs out/site`` takes minutes,
for it runs all commands of the pages.
"""

from __future__ import annotations

import os
import re
from html import unescape
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote, urlsplit

import pytest
from helpers.browsers import axe, browser

import vibro

if TYPE_CHECKING:
    from playwright.sync_api import Browser
    from playwright.sync_api import Page as WebPage

__all__ = ["axe", "browser"]
pytestmark = pytest.mark.skipif("VIBRO_SITE" not in os.environ, reason="no site is built (VIBRO_SITE)")

DOCS = Path(__file__).parents[1] / "docs"
LOADED = {"img": "src", "script": "src", "link": "href", "source": "src", "iframe": "src", "object": "data"}
TAG = re.compile(r"<(\w+)\s([^<>]*)>")
ATTRIBUTE = re.compile(r'([\w-]+)="([^"]*)"')
WIDTHS = (390, 1200)  # px: a phone, a desktop
SEEN = (
    "index.html", "tasks/*.html", "reference/api/codes.html", "reference/commands/map.html",
    "theory/03-thresholds.html", "gallery/plot_*.html",
)  # fmt: skip
FOUND = """(options) => axe.run({resultTypes: ["violations"], ...options}).then(
    (found) => found.violations.map((one) => [one.id, one.nodes[0].html]))"""


class Page:
    """Links, loaded files and anchors of a page."""

    def __init__(self, text: str) -> None:
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.anchors: list[str] = []
        for tag, attributes in TAG.findall(text):
            told = {name: unescape(value) for name, value in ATTRIBUTE.findall(attributes)}
            self.anchors += [told["id"]] if "id" in told else []
            if tag == "a" and told.get("href"):
                self.links.append(told["href"])
            if told.get(LOADED.get(tag, "")):
                self.loaded.append(told[LOADED[tag]])


def lost_links(folder: Path, pages: dict[Path, Page]) -> list[str]:
    """List links within the site, and files that it loads, that are not there."""
    lost, files = [], {str(path) for path in folder.rglob("*") if path.is_file()}
    for path, page in pages.items():
        for link in dict.fromkeys((*page.links, *page.loaded)):
            at = urlsplit(link)
            if at.scheme in ("http", "https", "data"):
                continue
            target = os.path.normpath(path.parent / unquote(at.path)) if at.path else str(path)
            if target not in files or (
                at.fragment
                and "=" not in at.fragment
                and unquote(at.fragment) not in pages[Path(target)].anchors
            ):
                lost.append(f"{path.relative_to(folder)}: {link}")
    return lost


@pytest.fixture(scope="module")
def site() -> Path:
    """Return the folder of the built site."""
    return Path(os.environ["VIBRO_SITE"]).resolve()


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    """Read all pages."""
    return {path: Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}


def test_links_and_anchors_lead_somewhere(site: Path, pages: dict[Path, Page]) -> None:
    assert len(pages) > 50
    assert lost_links(site, pages) == []


def test_pages_load_nothing_from_other_hosts(site: Path, pages: dict[Path, Page]) -> None:
    assert {link for page in pages.values() for link in page.loaded if urlsplit(link).netloc} == set()
    styles = "".join(path.read_text(encoding="utf-8") for path in site.rglob("*.css"))
    assert re.findall(r"(?:url\(|@import)\s*['\"]?(?:https?:)?//", styles) == []
    theory = pages[site / "theory" / "04-slide.html"]
    assert [link for link in theory.loaded if "tex-svg.js" in link]


def test_every_public_name_is_described_once(site: Path, pages: dict[Path, Page]) -> None:
    api = [page for path, page in pages.items() if path.parent.name == "api"]
    described = [anchor for page in api for anchor in page.anchors]
    assert {name: described.count(f"vibro.{name}") for name in vibro.__all__} == dict.fromkeys(
        vibro.__all__, 1
    )
    texts = [path.read_text(encoding="utf-8") for path in pages if path.parent.name == "api"]
    assert not [text for text in texts if re.search(r"\w -{4,}", text)]  # a title of a section that is none
    private = [anchor for anchor in described if re.search(r"vibro\..*\b_", anchor)]
    assert private == []


def test_every_equation_has_an_anchor_and_docstrings_lead_to_it(site: Path, pages: dict[Path, Page]) -> None:
    for source in (DOCS / "theory").glob("[0-9]*.md"):
        numbers = re.findall(r"\\tag\{(\d+)\}", source.read_text(encoding="utf-8"))
        anchors = pages[site / "theory" / f"{source.stem}.html"].anchors
        assert {f"eq-{number}" for number in numbers} <= set(anchors), source.name
    links = pages[site / "reference" / "api" / "machines.html"].links
    assert "../../theory/19-machines.html#eq-85" in links


@pytest.fixture(scope="module")
def window(browser: Browser) -> WebPage:
    return browser.new_page()


def assert_accessible_and_as_wide_as_the_window(page: WebPage, axe: str) -> None:
    root = "document.documentElement"
    for width in WIDTHS:
        page.set_viewport_size({"width": width, "height": 844})
        page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        assert page.evaluate(f"{root}.scrollWidth <= {root}.clientWidth"), width
    page.emulate_media(color_scheme="light")
    page.evaluate(axe)
    assert page.evaluate(FOUND, {}) == []
    page.emulate_media(color_scheme="dark")
    assert page.evaluate(FOUND, {"runOnly": ["color-contrast"]}) == []


@pytest.mark.parametrize("name", SEEN)
def test_pages_are_accessible_and_as_wide_as_the_window(
    name: str, site: Path, window: WebPage, axe: str
) -> None:
    path = next(path for path in sorted(site.glob(name)) if "*" not in name or path.stem != "index")
    asked: list[str] = []
    window.on("request", lambda request: asked.append(request.url))
    window.goto(path.as_uri())
    window.evaluate("window.MathJax?.startup?.promise")
    assert_accessible_and_as_wide_as_the_window(window, axe)
    assert {urlsplit(url).scheme for url in asked} <= {"file", "data", "blob"}


def test_the_search_finds_words_and_is_accessible(site: Path, window: WebPage, axe: str) -> None:
    found = {
        "traverse": "vibro traverse-time",
        "smartphone": "My phone on the trough: what does it do?",
        "stopwatch": "I have a stopwatch: what is my friction?",
        "inches": "Units",
        "animation": "The explorer: a map that moves under one's hand",
        "polyurethane": "Which restitution?",
    }
    for word, title in found.items():
        window.goto(f"{(site / 'search.html').as_uri()}?q={word}")
        window.wait_for_selector("#search-results li a")
        assert window.get_by_role("link", name=title).count() >= 1, word
    assert_accessible_and_as_wide_as_the_window(window, axe)
