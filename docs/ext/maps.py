"""The page of ``vibro explore`` in the site: on its first page, and behind each map that a task draws.

After a block of a task that runs ``vibro map``, a link opens the same map. It leads to the page of the scene
file, ``maps/safety_nut.html``, with the map's state after ``#``; maps without a scene file to the nut's.
"""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from functools import cache
from html import escape
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlencode

from commands import BLOCK, DOCS

if TYPE_CHECKING:
    from pathlib import Path

    from sphinx.application import Sphinx

_NUT: Final = "examples/safety_nut.toml"
_COMMAND: Final = re.compile(r"^(?:\$ )?vibro map ((?:[^\n]*\\\n)*[^\n]*)$", re.MULTILINE)
_DATA: Final = re.compile(r'<script type="application/json" id="data">(.*?)</script>', re.DOTALL)
#: Options of ``vibro map`` that say nothing of the scene, with how many values each takes.
_OF_THE_RUN: Final = {"-o": 1, "-q": 0, "--decimal-comma": 0, "--columns": 1, "--force": 0}
_STATES: Final = {"--speed": "target", "--show": "view"}


_linked = {_NUT}  # scene files whose pages are linked


@cache
def _page(*arguments: str) -> str:
    """Return the page of a scene."""
    command = [sys.executable, "-m", "vibro", "explore", *arguments, "-q", "-o", "-"]
    return subprocess.run(command, cwd=DOCS.parent, check=True, capture_output=True, encoding="utf-8").stdout


def _state(page: str) -> dict[str, str]:
    """Return the state that a page begins with."""
    found = _DATA.search(page)
    assert found
    state: dict[str, str] = json.loads(found[1])["scenes"][0]["state"]
    return state


def link_of(command: str) -> tuple[str, str] | None:
    """Return the scene file and the fragment that open the map of a command; None if no page can."""
    words = shlex.split(command.replace("\\\n", " "))
    scene = next((word for word in words if word.endswith(".toml")), None)
    if "-" in words or any(word.startswith("--workers") or ".parquet" in word for word in words):
        return None  # a table alone
    if scene and not (DOCS.parent / scene).is_file():  # made by a command before
        return None
    given, wanted, left = [], {}, iter(word for word in words if word != scene)
    for word in left:
        if word in _OF_THE_RUN:
            for _ in range(_OF_THE_RUN[word]):
                next(left)
        elif word in _STATES:
            wanted[_STATES[word]] = next(left)
        else:
            given.append(word)
    base = _state(_page(scene or _NUT))
    state = _state(_page(*([scene] if scene else []), *given)) | wanted
    if state["motion"] != base["motion"]:
        return None
    changed = {key: text for key, text in state.items() if text != base.get(key)}
    return scene or _NUT, urlencode(changed, safe=":")


def _add_links(app: Sphinx, name: str, source: list[str]) -> None:
    """Put a link after each block that draws a map."""
    if not name.startswith("tasks/"):
        return

    def linked(block: re.Match[str]) -> str:
        found = [link for command in _COMMAND.findall(block[3]) if (link := link_of(command))]
        lines = [block[0]]
        for scene, fragment in found:
            _linked.add(scene)
            address = escape(f"../maps/{_file(scene)}#{fragment}".rstrip("#"))
            lines.append(f'<a class="open-map" href="{address}">Open this map</a>\n')
        return "\n\n".join(lines)

    source[0] = BLOCK.sub(linked, source[0])


def _file(scene: str) -> str:
    return f"{scene.rpartition('/')[2].removesuffix('.toml')}.html"


def _write(app: Sphinx, exception: Exception | None) -> None:
    """Write the pages that are linked, and the nut's."""
    if exception or app.builder.name != "html":
        return
    folder: Path = app.outdir / "maps"
    folder.mkdir(exist_ok=True)
    for scene in _linked:
        (folder / _file(scene)).write_text(_page(scene), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Add links to the tasks, and write the pages."""
    app.connect("source-read", _add_links)
    app.connect("build-finished", _write)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
