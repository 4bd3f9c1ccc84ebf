"""Pages read as their readers do: the texts of tables, the ids, what they refer to."""

from __future__ import annotations

import re
from html.parser import HTMLParser


class ReadPage(HTMLParser):
    """A page that is read.

    Attributes
    ----------
    tags : list of str
        Of all elements.
    ids, links : list of str
        Ids of elements, and all that attributes refer to.
    rows : list of list of str
        Cells of all tables.
    text : str
        All that is read.
    """

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.rows: list[list[str]] = []
        self.text = ""
        self._hidden = False
        self.feed(html)
        self.close()

    def row(self, name: str) -> list[str]:
        """Return the row whose head is a name."""
        (found,) = [cells[1:] for cells in self.rows if cells[0] == name]
        return found

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for key, value in attrs:
            if key == "id":
                self.ids.append(value or "")
            elif key in ("href", "xlink:href", "src", "srcset", "data", "action"):
                self.links.append(value or "")
            self.links += [f"#{target}" for target in re.findall(r"url\(#([^)]+)\)", value or "")]
        if tag == "tr":
            self.rows.append([])
        elif tag in ("th", "td"):
            self.rows[-1].append("")
        self._hidden = tag == "style"

    def handle_endtag(self, tag: str) -> None:
        self._hidden = False
        if tag in ("p", "li", "h1", "h2", "dd", "dt", "tr", "figcaption", "caption"):
            self.text += "\n"

    def handle_data(self, data: str) -> None:
        if self._hidden:
            return
        self.text += data
        if self.rows and self.rows[-1] and data.strip():
            self.rows[-1][-1] += data
