"""Give sphinx-gallery the pictures of a page: the figure of its script, else those that its command writes.

A page has its command in a ``bash`` block and names the pictures that this writes: ``out/nut-regime.png``.
The command runs in a folder that has the examples. vibro's figures know no pyplot, where sphinx-gallery
would look for them: a script calls its figure ``figure``.
"""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

EXAMPLES: Final = Path(__file__).parents[2] / "examples"
BLOCK: Final = re.compile(r"^\.\. code-block:: bash\n\n((?:    .*\n)+)", re.MULTILINE)
# Of the pages, by the names of their scripts.
ORDER: Final = (
    "regimes", "speed", "traverse_time", "impact", "flight", "irregular", "climbing", "frictions",
    "friction_band", "phase", "any_motion", "target_speed", "facets", "one_axis", "curves", "regime_bars",
    "history", "flights", "trough_path", "branch", "compare", "measured_drive", "response",
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


def run_commands(script: Path, folder: Path) -> None:
    """Run the commands of a page in a folder."""
    shutil.copytree(EXAMPLES, folder / "examples", ignore=shutil.ignore_patterns("gallery"))
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    subprocess.run(
        ["bash", "-euo", "pipefail", "-c", commands_of(script)],
        cwd=folder,
        env={**os.environ, "PATH": path},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        check=True,
    )


def _scrape(block: Any, block_vars: Mapping[str, Any], gallery_conf: Mapping[str, Any]) -> str:
    """Save the pictures of a page after its first script, and return what shows them."""
    places, script = block_vars["image_path_iterator"], Path(block_vars["src_file"])
    if len(places):
        return ""
    paths = []
    if figure := block_vars["example_globals"].get("figure"):
        paths.append(Path(next(places)))
        figure.savefig(paths[0])
    else:
        with tempfile.TemporaryDirectory() as folder:
            run_commands(script, Path(folder))
            for name in pictures_of(script):
                paths.append(Path(next(places)))
                shutil.copyfile(Path(folder, name), paths[-1])
    shown = [f".. image:: /{path.relative_to(gallery_conf['src_dir']).as_posix()}" for path in paths]
    return "".join(f"{line}\n   :alt: {_seen(script)}\n\n" for line in shown)


def _get_sg_image_scraper() -> Callable[..., str]:
    """Let sphinx-gallery find the scraper by the name of this module."""
    return _scrape
