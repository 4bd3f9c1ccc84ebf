"""Draw the rooms of vibro, layer by layer, from the import contracts: the directive ``rooms``.

Layers are those of the contract of the package that the directive names; a room's purpose is the first line
of its docstring. A page that numbers files, "4. `src/vibro/sweeps/grid.py`", shows the way through them.
"""

from __future__ import annotations

import ast
import re
import textwrap
import tomllib
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sphinx.application import Sphinx

ROOT: Final = Path(__file__).parents[2]
# All [px].
WIDTH, ROW, GAP, MARGIN, NAME, BADGE = 730, 18, 7, 84, 148, 8
LETTERS: Final = 74  # that a line has room for
STEP: Final = re.compile(r"^(\d+)\. `src/vibro/(\w+)", re.MULTILINE)


def layers_of(package: str) -> list[list[str]]:
    """Return the rooms of a package, one list for each layer, from the top."""
    pyproject = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = pyproject["tool"]["importlinter"]["contracts"]
    (contract,) = (one for one in contracts if one.get("containers") == [package])
    return [layer.split(" : ") for layer in contract["layers"]]


def purpose_of(package: str, room: str) -> str:
    """Return the first line of the docstring of a room."""
    path = ROOT / "src" / package.replace(".", "/") / room
    source = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    return (ast.get_docstring(ast.parse(source.read_text(encoding="utf-8"))) or "").partition("\n")[0]


def steps_of(page: str) -> list[tuple[int, str]]:
    """Return the numbers of a page's files and their rooms."""
    return [(int(number), room) for number, room in STEP.findall(page)]


def drawing(package: str, steps: Sequence[tuple[int, str]] = ()) -> str:
    """Return an SVG that takes its colours from the page, so that it is legible in the dark too."""
    layers, y = layers_of(package), GAP
    places: dict[str, float] = {}
    parts: list[str] = []
    for layer in layers:
        texts = {room: textwrap.wrap(purpose_of(package, room).replace("``", ""), LETTERS) for room in layer}
        height = ROW * sum(map(len, texts.values())) + GAP
        parts.append(
            f'<rect x="{MARGIN}" y="{y}" width="{WIDTH - MARGIN - 1}" height="{height}" rx="4" '
            'fill="none" stroke="currentColor" stroke-opacity="0.4"/>'
        )
        line = y + GAP / 2 + ROW / 2
        for room, text in texts.items():
            places[room] = line
            parts.append(_words(room, text, line))
            line += ROW * len(text)
        y += height + GAP
    ways = [_way(places[a], places[b]) for (_, a), (_, b) in pairwise(steps) if a != b]
    badges = [_badge(room, steps, places[room]) for room in places if room in {at for _, at in steps}]
    alt = f"Layers of {package} from the top, each of which imports those below it alone: "
    alt += "; ".join(", ".join(layer) for layer in layers)
    return (
        f'<div style="overflow-x: auto" tabindex="0" role="region" aria-label="Layers of {package}">'
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y}" width="{WIDTH}" height="{y}" '
        f'role="img" aria-label="{escape(alt)}" font-size="12" fill="currentColor">'
        f"{''.join([*parts, *ways, *badges])}</svg></div>"
    )


def _words(room: str, text: Sequence[str], y: float) -> str:
    name = f'<text x="{MARGIN + 8}" y="{y + 4}" font-family="monospace" font-weight="bold">{room}</text>'
    lines = [
        f'<text x="{MARGIN + NAME}" y="{y + 4 + ROW * i}">{escape(line)}</text>'
        for i, line in enumerate(text)
    ]
    return "".join([name, *lines])


def _way(start: float, end: float) -> str:
    x, bend = MARGIN - 22, min(60.0, 14.0 + abs(end - start) / 6.0)
    return (
        f'<path d="M{x},{start} C{x - bend},{start} {x - bend},{end} {x},{end}" fill="none" '
        'stroke="var(--color-brand-content, currentColor)" stroke-width="1.5"/>'
    )


def _badge(room: str, steps: Sequence[tuple[int, str]], y: float) -> str:
    numbers = ", ".join(str(number) for number, at in steps if at == room)
    width = 7 * len(numbers) + BADGE
    x = MARGIN - 4 - width
    return (
        f'<rect x="{x}" y="{y - BADGE}" width="{width}" height="{2 * BADGE}" rx="{BADGE}" '
        'fill="var(--color-brand-content, #333)"/>'
        f'<text x="{x + width / 2}" y="{y + 4}" text-anchor="middle" font-weight="bold" '
        f'fill="var(--color-background-primary, #fff)">{numbers}</text>'
    )


def setup(app: Sphinx) -> dict[str, Any]:
    """Add the directive; the tests draw without Sphinx."""
    from docutils import nodes
    from sphinx.util.docutils import SphinxDirective

    class Rooms(SphinxDirective):
        """``{rooms} vibro``: the layers of a package."""

        required_arguments = 1

        def run(self) -> list[Any]:
            """Draw them."""
            page = Path(self.state.document["source"]).read_text(encoding="utf-8")
            package = self.arguments[0]
            steps = steps_of(page) if package == "vibro" else []
            return [nodes.raw("", drawing(package, steps), format="html")]

    app.add_directive("rooms", Rooms)
    app.connect("env-get-outdated", lambda *_: ["working/index", "working/solver"])  # contracts may change
    return {"parallel_read_safe": True, "parallel_write_safe": True}
