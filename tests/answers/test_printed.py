"""Pages in a browser: what axe finds on them, whether they fit a phone, and how many sheets they print to."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from typer.testing import CliRunner

from vibro.cli.app import app

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Request

EXAMPLES = Path(__file__).parents[2] / "examples"
#: The longest pages: a path below four panels, bounces, parts in a row; two drives of which none will do.
PAGES = {
    "solve": (
        "bowl_feeder.toml", "along=0.5", "normal=0.3", "phase=-60", "--restitution", "0.3",
        "--pitch", "20", "--mass", "12g",
    ),
    "design": ("design_feeder.toml",),
    "drive": ("full_feeder.toml", "voltage=90:110"),
    "measure": (
        "safety_nut.toml", str(EXAMPLES / "data" / "nut_trough_mv.csv"), "--trough-along", "Trog längs",
        "--trough-normal", "Trog normal", "--sensitivity", "100mV/g", "--fit", "mu_s,mu_d",
    ),
}  # fmt: skip


@pytest.fixture(scope="module", params=PAGES)
def html(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Make a page, of a file with the upper ends of its bands, its pictures from few values."""
    name, *args = PAGES[request.param]
    file = tmp_path_factory.mktemp("page") / name
    text = (EXAMPLES / name).read_text(encoding="utf-8")
    file.write_text(re.sub(r'"[\d.]+:([\d.]+)"', r"\1", text), encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibro.sweeps.run._RESOLVED", {1: 101, 2: 21, 3: 21})
        patch.setattr("vibro.designs.pictured._POINTS", {False: 21, True: 21})
        page = file.with_suffix(".html")
        result = CliRunner().invoke(app, [request.param, str(file), *args, "-q", "-o", str(page)])
    assert result.exit_code in (0, 4)
    return page.read_text(encoding="utf-8")


def test_the_page_is_for_everybody_and_for_paper(browser: Browser, axe: str, html: str) -> None:
    asked: list[str] = []

    def note(request: Request) -> None:
        asked.append(request.url)

    with browser.new_context(color_scheme="dark") as context:
        page = context.new_page()
        page.on("request", note)
        page.set_content(html)
        # whatever the screen shows, paper is white
        printed = page.pdf(prefer_css_page_size=True)
        assert 1 <= len(re.findall(rb"/Type\s*/Page\b", printed)) <= 2
        assert re.search(rb"/MediaBox\s*\[0 0 59[45][.\d]* 84[12]", printed)  # A4
        page.emulate_media(media="print")
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
        # pictures are images with a name: what they consist of takes most of the time
        page.evaluate("document.querySelectorAll('figure svg').forEach(picture => picture.replaceChildren())")
        page.evaluate(axe)
        for rules in (None, ["color-contrast"]):  # the dark scheme on a phone differs in colours alone
            width = 390 if rules else 1200
            page.set_viewport_size({"width": width, "height": 844})
            page.emulate_media(media="screen", color_scheme="dark" if rules else "light")
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
            assert (paper == "rgb(255, 255, 255)") is (rules is None)
            found: dict[str, Any] = page.evaluate("rules => axe.run(rules ? {runOnly: rules} : {})", rules)
            assert len(found["passes"]) > (0 if rules else 10)
            assert [(v["id"], [n["target"] for n in v["nodes"]]) for v in found["violations"]] == []
        assert [url for url in asked if not url.startswith("data:")] == []
