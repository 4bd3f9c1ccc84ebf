"""Give sphinx-gallery the pictures of a page: the figure of its script, else those that its command writes.

A page has its command in a ``bash`` block and names the pictures that this writes: ``out/nut-regime.png``.
The command runs in a folder that has the examples. vibro's figures know no pyplot, where sphinx-gallery
would look for them: a script calls its figure ``figure``. A page whose picture Python cannot make shows it
below the command: ``/gallery/images/sphx_glr_plot_history_001.png``.
"""

from __future__ import annotations

import ast
import re
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from commands import DOCS, SHELL, copy_examples, output_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

EXAMPLES: Final = DOCS.parent / "examples"
BLOCK: Final = re.compile(r"^\.\. code-block:: bash\n\n((?:    .*\n)+)", re.MULTILINE)
# Of the pages, by the names of their scripts.
ORDER: Final = (
    "regimes", "speed", "traverse_time", "impact", "flight", "irregular", "climbing", "frictions",
    "friction_band", "phase", "any_motion", "target_speed", "facets", "one_axis", "curves",
    "history", "flights", "trough_path", "compare", "measured_drive", "response",
    "design_speed", "design_regimes", "design_band", "accuracy",
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
    """Save the pictures of a page, for its thumbnail too; return what shows the figure of a script."""
    places, script = block_vars["image_path_iterator"], Path(block_vars["src_file"])
    if len(places):
        return ""
    if figure := block_vars["example_globals"].get("figure"):
        path = Path(next(places))
        figure.savefig(path)
        shown = path.relative_to(gallery_conf["src_dir"]).as_posix()
        return f".. image:: /{shown}\n   :alt: {_seen(script)}\n\n"
    with tempfile.TemporaryDirectory() as folder:
        copy_examples(Path(folder))
        output_of([*SHELL, commands_of(script)], script, Path(folder))
        for name in pictures_of(script):
            shutil.copyfile(Path(folder, name), Path(next(places)))
    return ""


def _get_sg_image_scraper() -> Callable[..., str]:
    """Let sphinx-gallery find the scraper by the name of this module."""
    return _scrape
