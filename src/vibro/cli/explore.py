"""``vibro explore``: a page in the browser that shows the map while quantities are moved."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import Options  # typer reads the annotation
from vibro.errors import FileError

if TYPE_CHECKING:
    from vibro.sweeps.request import Request

_SCREENS: Final = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")  # variables of the environment
# Where it is, browsers may run in a sandbox that sees no other folders than those of the home folder.
_SNAPS: Final = Path("/snap")


def explore_command(options: Options) -> int:
    """Explore scenes in the browser: move their quantities, and see the map, the numbers and the motion.

    The page is one HTML file, which computes by itself: it needs no network, and can be mailed. It is opened
    from a temporary folder; -o nut.html writes it there, and opens nothing. Axes and [map] are those that the
    map shows first, several files are tabs; without any the page begins with the paper's safety nut, which
    options change.
    """
    from vibro.cli.outputs import Outputs
    from vibro.explore.scenes import file_name

    requests = _requests(options)
    name = file_name([request.name or "" for request in requests if request is not None])
    with Outputs(options, name, forms=("html",), pictures=()) as outputs:
        from vibro.explore.page import page_text

        text = page_text(requests)
        outputs.write_texts({"html": lambda _: text})
        outputs.finish()
    if outputs.takes_stdout:
        print(text, end="")
    elif not outputs.texts:
        path = _temporary(f"{name}.html", text)
        print(path, flush=True)  # some browsers are waited for until they end
        if not _opened(path):
            options.console.echo("no browser could be opened: open this file in one")
    return ExitCode.DONE


def _requests(options: Options) -> list[Request | None]:
    """Read the given scenes: their values are operating points, their axes those of the map."""
    if not options.files and not options.given:
        return [None]
    from vibro.cli.request import request_of
    from vibro.explore.scenes import held, nut_file
    from vibro.quantities import QUANTITIES
    from vibro.sweeps.request import RANGES

    each = [options.of(file) for file in options.files] or [options]
    nut = nut_file()
    how: dict[str, Any] = {"reads_map": True, "takes_axes": True, "ranges": RANGES}
    requests = [request_of(one, without_file=nut, **how) for one in each]
    for name in dict.fromkeys(name for request in requests for name in held(request)):
        options.console.warn(f"{QUANTITIES[name].label}: the map has two axes, and the page holds this one")
    return [*requests]


def _temporary(name: str, text: str) -> Path:
    """Write a file into a new folder; it stays, as the browser may load it again."""
    downloads = Path.home() / "Downloads"
    parent = downloads if _SNAPS.is_dir() and downloads.is_dir() else None
    try:
        path = Path(tempfile.mkdtemp(prefix="vibro-", dir=parent)) / name
        path.write_text(text, encoding="utf-8")
    except OSError as exc:
        raise FileError(
            f"cannot write a temporary file: {exc.strerror or exc}", hint="-o nut.html writes it elsewhere"
        ) from exc
    return path


def _opened(path: Path) -> bool:
    """Open a file in the user's browser, and return whether there is one."""
    import webbrowser

    # Without a screen, Python would open a browser of text in this terminal.
    has_screen = sys.platform in ("win32", "darwin") or not os.environ.keys().isdisjoint(_SCREENS)
    return has_screen and webbrowser.open(path.as_uri())
