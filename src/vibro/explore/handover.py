"""The first address on its way to the browser: in a file that its owner alone can read.

A browser's command line is open to every user of the machine, and the address holds the token that begins the
session. So the browser is started with the path of a file, which leads on to the address.
"""

from __future__ import annotations

import os
import tempfile
from contextlib import contextmanager, suppress
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Final

from vibro.interrupts import OnEnd

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["handed_over"]

_PAGE: Final = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={address}">
<title>vibro explore</title>
<a href="{address}">vibro explore</a>
</html>
"""


@contextmanager
def handed_over(address: str) -> Iterator[Path]:
    """Write a page that leads to an address; it is there within this context.

    Parameters
    ----------
    address : str
        Where the page leads.

    Yields
    ------
    Path
        The page: of mode 0600, in a folder of mode 0700. It is removed at the end of the context, or of the
        process if a signal ends it.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    page = _private_folder() / "open-vibro.html"

    def remove() -> None:
        for act, path in ((os.unlink, page), (os.rmdir, page.parent)):
            with suppress(OSError):
                act(path)

    try:
        with OnEnd(remove):
            with open(page, "x", encoding="utf-8", opener=partial(os.open, mode=0o600)) as file:
                file.write(_PAGE.format(address=escape(address)))
            yield page
    finally:
        remove()


def _private_folder() -> Path:
    """Make a folder that its owner alone can read.

    In the home folder, and not hidden: browsers in a sandbox, such as snap packages, see neither the folders
    of temporary files nor hidden ones.
    """
    with suppress(OSError, RuntimeError):  # no home folder, or none to write to
        return Path(tempfile.mkdtemp(prefix="vibro-", dir=Path.home()))
    return Path(tempfile.mkdtemp(prefix="vibro-"))
