"""The page of an answer: HTML that needs no other file, and prints on A4."""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING, Final, NamedTuple
from xml.etree import ElementTree

from vibro.version import __version__

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.figure import Figure


_SVG: Final = "http://www.w3.org/2000/svg"
_XLINK: Final = "http://www.w3.org/1999/xlink"
_PIXELS: Final = 96.0  # [px] of an inch
# The page has its own: matplotlib's style would hold for all of it.
_DROPPED: Final = tuple(f"{{{_SVG}}}{name}" for name in ("title", "metadata", "style"))
_REFERENCE: Final = re.compile(r"(?<=url\(#)[^)]+")
_LINK: Final = f"{{{_XLINK}}}href"


class Picture(NamedTuple):
    """An inline SVG, how wide it is drawn [px], and what it shows."""

    svg: str
    width: int
    shows: str


def page_html(answer: object, pictures: Mapping[str, Figure], command: str) -> str:
    """Write an answer as self-contained HTML, without scripts, fonts or other files; texts stay texts.

    Parameters
    ----------
    answer : Answer
        All of it is written, what is rare too.
    pictures : mapping of str to Figure
        By what each shows.
    command : str
        That makes the same page.
    """
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("vibro.answers"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    drawn = [picture(figure, f"p{i}", shows) for i, (shows, figure) in enumerate(pictures.items())]
    template = environment.get_template("page.html")
    return template.render(answer=answer, pictures=drawn, command=command, version=__version__)


def picture(figure: Figure, name: str, shows: str) -> Picture:
    """Draw a figure as part of a page; the ids of its elements begin with a name of its own."""
    from vibro.plots import save

    written = io.BytesIO()
    save(figure, written, "svg", {})
    root = ElementTree.fromstring(written.getvalue())
    for parent in [*root.iter()]:
        for child in [*parent]:
            if child.tag in _DROPPED:
                parent.remove(child)
    _rename(root, name)
    root.attrib = {"viewBox": root.attrib["viewBox"], "role": "img", "aria-label": shows}
    ElementTree.register_namespace("", _SVG)
    ElementTree.register_namespace("xlink", _XLINK)
    text = ElementTree.tostring(root, encoding="unicode")
    return Picture(text, round(float(figure.get_figwidth()) * _PIXELS), shows)


def _rename(root: ElementTree.Element, name: str) -> None:
    """Keep the ids that something refers to, each beginning with a name: matplotlib repeats ids."""
    used = set()
    for element in root.iter():
        for key, value in element.attrib.items():
            if key == _LINK and value.startswith("#"):
                used.add(value[1:])
                element.set(key, f"#{name}-{value[1:]}")
            elif found := _REFERENCE.findall(value):
                used.update(found)
                element.set(key, _REFERENCE.sub(lambda match: f"{name}-{match[0]}", value))
    for element in root.iter():
        own = element.attrib.pop("id", None)
        if own in used:
            element.set("id", f"{name}-{own}")
