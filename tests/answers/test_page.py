"""Pages: pictures look as they do in files and disturb nothing beside them, and texts stay texts."""

from __future__ import annotations

import io
import re

import pytest
from helpers.read_pages import ReadPage
from matplotlib.figure import Figure

from vibro.answers.answer import Answer, Fact, Table
from vibro.answers.page import picture
from vibro.plots import save


@pytest.fixture(scope="module")
def figure() -> Figure:
    """Hatches, markers, clipped lines and words: all that refers to ids."""
    figure = Figure(figsize=(3.0, 2.0))
    axes = figure.subplots()
    axes.plot([0, 1], [0, 3], "o-", color="#994455", label='a "<b>" line')
    axes.axvspan(0.2, 0.6, facecolor="#EECC66", edgecolor="#6699CC", hatch="//")
    axes.set_ylim(0, 1)
    axes.legend()
    return figure


def test_two_pictures_share_no_id_and_every_reference_leads_into_its_own(figure: Figure) -> None:
    pages = [ReadPage(picture(figure, name, "what it shows").svg) for name in ("one", "two")]
    ids = [one for page in pages for one in page.ids]
    assert len(ids) == len(set(ids)) > 10
    for page, name in zip(pages, ("one", "two"), strict=True):
        assert set(page.links) == {f"#{one}" for one in page.ids}
        assert all(one.startswith(f"{name}-") for one in page.ids)


def test_colours_and_shapes_are_those_of_the_file(figure: Figure) -> None:
    written = io.BytesIO()
    save(figure, written, "svg", {})
    file, inline = written.getvalue().decode(), picture(figure, "one", "").svg
    for what in (r'fill[:=] ?"?(#\w+)', r"stroke: (#\w+)", r' d="([^"]+)"'):
        told = [re.sub(r"\s+", " ", text) for text in re.findall(what, file)]
        assert told
        assert [re.sub(r"\s+|&#10;", " ", text) for text in re.findall(what, inline)] == told


def test_nothing_of_it_holds_for_the_page_and_it_says_what_it_shows(figure: Figure) -> None:
    one = picture(figure, "one", 'a "map" & more')
    page = ReadPage(one.svg)
    assert not {"style", "metadata", "title", "script"} & {*page.tags}
    assert 'role="img"' in one.svg
    assert 'aria-label="a &quot;map&quot; &amp; more"' in one.svg
    assert one.width == 288


def test_texts_are_no_markup_and_the_page_needs_nothing_else(figure: Figure) -> None:
    texts = "<b onclick=x>&amp;", "</main>", "<i>"
    table = Table("rows", [(texts[0], "mm"), (texts[1], "")], [(texts[2], 0.5)])
    html = Answer([Fact(texts[0], texts[1])], [table], [texts[2]], title=texts[0]).html(
        {texts[1]: figure}, texts[0]
    )
    page = ReadPage(html)
    assert all(text in page.text for text in texts)
    assert not {"b", "i", "script", "link", "iframe", "img", "object"} & {*page.tags}
    assert page.tags.count("main") == 1
    assert {*page.links} <= {f"#{one}" for one in page.ids}
    assert len(page.ids) == len({*page.ids})
