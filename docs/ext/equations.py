r"""Link "Eq. (43)" and "theory, section 14", on any page and in any docstring, to equation and chapter.

An equation of the theory has its number from ``\tag{43}`` and the anchor ``eq-43``. Inside the theory "(43)"
and "section 14" are links too.
"""

from __future__ import annotations

import re
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from docutils import nodes
from sphinx.util import logging
from sphinx.util.nodes import make_refnode

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sphinx.application import Sphinx

TAG: Final = re.compile(r"\\tag\{(\d+)\}")
CHAPTER: Final = re.compile(r"theory/0*(\d+)-")
CITED: Final = r"\bEqs?\.\s+\(\d+\)(?:(?:-|,|,?\s+(?:and|or|to))\s*\(\d+\))*"
ANYWHERE: Final = re.compile(rf"{CITED}|theory,\s+section\s+\d+")
IN_THEORY: Final = re.compile(rf"{CITED}|\(\d{{1,3}}\)|\b[Ss]ections?\s+\d+(?:\s+(?:and|to)\s+\d+)?")
#: One link each: "(43)" or "section 14", or the second of "sections 3 and 4".
PLACE: Final = re.compile(r"\((\d+)\)|((?:[Ss]ections?\s+)?\d+)(?!\d|\))")
VERBATIM: Final = (
    nodes.literal, nodes.literal_block, nodes.math, nodes.math_block, nodes.reference, nodes.title, nodes.raw,
)  # fmt: skip

_log = logging.getLogger(__name__)


def _number(app: Sphinx, tree: Any) -> None:
    """Give equations that have a number an anchor, and note their page."""
    for block in tree.findall(nodes.math_block):
        formula = block.astext()
        if numbers := TAG.findall(formula):
            block["no-wrap"] = block["nowrap"] = True  # Sphinx would put it where no tag may stand
            block[:] = [nodes.Text(rf"\[{formula}\]")]
            block["ids"] += [f"eq-{number}" for number in numbers]
            _equations(app.env).update(dict.fromkeys(numbers, app.env.docname))


def _link(app: Sphinx, tree: Any, page: str) -> None:
    """Make links of citations."""
    pattern = IN_THEORY if page.startswith("theory/") else ANYWHERE
    for text in list(tree.findall(nodes.Text)):
        if pattern.search(text) and not any(isinstance(node, VERBATIM) for node in _above(text)):
            siblings = text.parent.children
            at = next(i for i, node in enumerate(siblings) if node is text)  # others may be equal
            text.parent[at : at + 1] = list(_linked(app, text, page, pattern))


def _linked(app: Sphinx, text: Any, page: str, pattern: re.Pattern[str]) -> Iterator[Any]:
    """Cut a text into links and what is between them."""
    places = [
        (at.start() + place.start(), at.start() + place.end())
        for at in pattern.finditer(text)
        for place in PLACE.finditer(at[0])
    ]
    edges = [0, *(edge for place in places for edge in place), len(text)]
    chapters = {at[1]: found for found in app.env.found_docs if (at := CHAPTER.match(found))}
    for i, (start, end) in enumerate(pairwise(edges)):
        piece = nodes.Text(text[start:end])
        number = re.sub(r"\D", "", piece)
        is_equation = piece.startswith("(")
        home = (_equations(app.env) if is_equation else chapters).get(number)
        if i % 2 and home:
            yield make_refnode(app.builder, page, home, f"eq-{number}" if is_equation else "", piece)
            continue
        if i % 2:
            _log.warning("the theory has no %s", piece, location=text.parent)
        yield piece


def _above(node: Any) -> Iterator[Any]:
    while node.parent is not None:
        node = node.parent
        yield node


def _equations(env: Any) -> dict[str, str]:
    """Pages of the equations, by number; kept with the environment, for pages that are not read again."""
    if not hasattr(env, "equations_of_theory"):
        env.equations_of_theory = {}
    found: dict[str, str] = env.equations_of_theory
    return found


def _forget(app: Sphinx, env: Any, page: str) -> None:
    for number in [number for number, home in _equations(env).items() if home == page]:
        del _equations(env)[number]


def _merge(app: Sphinx, env: Any, pages: set[str], other: Any) -> None:
    _equations(env).update({number: page for number, page in _equations(other).items() if page in pages})


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect both steps: numbers while pages are read, links once all are."""
    app.connect("doctree-read", _number)
    app.connect("doctree-resolved", _link)
    app.connect("env-purge-doc", _forget)
    app.connect("env-merge-info", _merge)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
