"""Give sphinx-gallery the picture of a page: the figure of its script.

A page has its command in a ``bash`` block and names the pictures that this writes: ``out/nut-regime.png``.
vibro's figures know no pyplot, where sphinx-gallery would look for them: a script calls its own ``figure``.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from commands import DOCS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

EXAMPLES: Final = DOCS.parent / "examples"
BLOCK: Final = re.compile(r"^\.\. code-block:: bash\n\n((?:    .*\n)+)", re.MULTILINE)
# Of the pages, by the names of their scripts.
ORDER: Final = (
    "regimes", "speed", "traverse_time", "impact", "flight", "irregular", "climbing", "frictions",
    "friction_band", "phase", "any_motion", "facets", "one_axis", "curves",
    "history", "flights", "trough_path", "compare",
    "design_speed", "design_regimes", "design_band",
)  # fmt: skip
PICTURE: Final = re.compile(r"``(out/[\w-]+\.png)``")


def commands_of(script: Path) -> str:
    """Return the commands that a page shows; empty where there are none."""
    return "".join(re.sub(r"^    ", "", block, flags=re.MULTILINE) for block in BLOCK.findall(_text(script)))


def pictures_of(script: Path) -> list[str]:
    """Name the pictures that a page says its command writes."""
    return list(dict.fromkeys(PICTURE.findall(_text(script))))


def place(script: str) -> int:
    """Return the place of a page among the others, by the name of its script."""
    return ORDER.index(Path(script).stem.removeprefix("plot_"))


def _text(script: Path) -> str:
    return f"{ast.get_docstring(ast.parse(script.read_text(encoding='utf-8')))}\n"


def _seen(script: Path) -> str:
    """Return the title of a page with its first sentence, on one line."""
    title, _, text = _text(script).partition("\n")
    paragraph = " ".join(text.split("\n\n")[1].split())
    return f"{title}. {paragraph.partition('. ')[0]}."


def _scrape(block: Any, block_vars: Mapping[str, Any], gallery_conf: Mapping[str, Any]) -> str:
    """Save the picture of a page, for its thumbnail too; return what shows it."""
    places, script = block_vars["image_path_iterator"], Path(block_vars["src_file"])
    figure = block_vars["example_globals"].get("figure")
    if len(places) or figure is None:
        return ""
    path = Path(next(places))
    figure.savefig(path)
    shown = path.relative_to(gallery_conf["src_dir"]).as_posix()
    return f".. image:: /{shown}\n   :alt: {_seen(script)}\n\n"


def _get_sg_image_scraper() -> Callable[..., str]:
    """Let sphinx-gallery find the scraper by the name of this module."""
    return _scrape
