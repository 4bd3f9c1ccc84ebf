"""Pictures as SVG that stands in a page, beside others."""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING, Final
from xml.etree import ElementTree

from vibro.plots import save
from vibro.reports.page import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["picture"]

_SVG: Final = "http://www.w3.org/2000/svg"
_XLINK: Final = "http://www.w3.org/1999/xlink"
_PIXELS: Final = 96.0  # [px] of an inch
# The page has its own: matplotlib's style would hold for all of it.
_DROPPED: Final = tuple(f"{{{_SVG}}}{name}" for name in ("title", "metadata", "style"))
_REFERENCE: Final = re.compile(r"(?<=url\(#)[^)]+")
_LINK: Final = f"{{{_XLINK}}}href"


def picture(figure: Figure, name: str, alt: str, caption: str) -> Picture:
    """Draw a figure as part of a page.

    Parameters
    ----------
    figure : Figure
        Its words become paths, so that they look the same on every machine.
    name : str
        Unlike that of any other picture of the page: the ids of its elements begin with it.
    alt, caption : str
        What it shows, for those who do not see it, and how to read it.
    """
    written = io.BytesIO()
    save(figure, written, "svg", {})
    root = ElementTree.fromstring(written.getvalue())
    for parent in [*root.iter()]:
        for child in [*parent]:
            if child.tag in _DROPPED:
                parent.remove(child)
    _rename(root, name)
    root.attrib = {"viewBox": root.attrib["viewBox"], "role": "img", "aria-label": alt}
    ElementTree.register_namespace("", _SVG)
    ElementTree.register_namespace("xlink", _XLINK)
    text = ElementTree.tostring(root, encoding="unicode")
    return Picture(text, round(float(figure.get_figwidth()) * _PIXELS), alt, caption)


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
