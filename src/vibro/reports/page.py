"""A page of sections with tables and pictures, and its HTML."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from vibro import __version__
from vibro.errors import FileError, how_to_install

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Page", "Picture", "Section", "Table", "check_extra", "page_html"]


class Picture(NamedTuple):
    """An inline SVG, how wide it is drawn [px], what it shows in one sentence, and how to read it."""

    svg: str
    width: int
    alt: str
    caption: str


class Table(NamedTuple):
    """A table: its caption, the heads of its columns, if any, and rows that begin with their own head."""

    caption: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    is_numeric: bool = False


@dataclass(frozen=True, kw_only=True)
class Section:
    """A section of a page: what there is of it, in this order; texts are plain.

    One that ``is_half`` is placed beside the next one if there is room.
    """

    title: str
    is_half: bool = False
    texts: Sequence[str] = ()
    items: Sequence[str] = ()
    tables: Sequence[Table] = ()
    pictures: Sequence[Picture] = ()
    notes: Sequence[str] = ()


@dataclass(frozen=True, kw_only=True)
class Page:
    """A page.

    Attributes
    ----------
    title, kind : str
        Name of the scene or the question, as users wrote it, and what the page is.
    answer : str
        What is to be known first.
    highlights : sequence of tuple of str
        A name, a value and what it means, of a few numbers.
    sections : sequence of Section
        In their order.
    command : str
        That makes the same page.
    """

    title: str
    kind: str
    answer: str
    highlights: Sequence[tuple[str, str, str]] = ()
    sections: Sequence[Section] = field(default=())
    command: str = ""


def check_extra() -> None:
    """Refuse to begin where the library that makes pages is missing.

    Raises
    ------
    FileError
        It says what to install.
    """
    _jinja()


def _jinja() -> Any:
    try:
        import jinja2
    except ImportError:
        raise FileError("a report needs Jinja2", hint=how_to_install("report")) from None
    return jinja2


def page_html(page: Page) -> str:
    """Write a page as self-contained HTML, without scripts, fonts or other files.

    Raises
    ------
    FileError
        If Jinja2 is not installed.
    """
    jinja2 = _jinja()
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("vibro.reports"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return str(environment.get_template("page.html").render(page=page, version=__version__))
