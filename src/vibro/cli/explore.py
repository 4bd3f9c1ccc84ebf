"""``vibro explore``: a page in the browser that shows the map while quantities are moved."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
from typing import TYPE_CHECKING, Annotated, Final

from vibro.cli.exit_codes import ExitCode
from vibro.cli.options import Options, option  # typer reads the annotations
from vibro.errors import FileError, how_to_install
from vibro.interrupts import tidy_up

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vibro.cli.console import Console
    from vibro.sweeps.request import Request

_GOODBYE: Final = b"goodbye: the page gets no more answers\n"
_PATIENCE: Final = 20.0  # [s] until the console says that no browser has opened the page
_SCREENS: Final = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")  # variables of the environment


def explore_command(
    options: Options,
    port: Annotated[
        str, option("port", "Port to listen on; if it is taken, the next free one.", "PORT")
    ] = "8765",
    no_open: Annotated[
        bool, option("no-open", "Print the page's address without opening a browser.")
    ] = False,
) -> int:
    """Explore a scene in the browser: move its quantities, and see the map, the numbers and the motion.

    Axes and [map] are those that the map shows first; without a scene file the page begins with the paper's
    safety nut. Only one browser on this computer can open the page; Ctrl-C ends it. Install with
    pip install '.[explore]' in the project's folder.
    """
    from vibro.cli.console import print_unexpected, tell_traceback
    from vibro.cli.request import whole_number

    console = options.console
    _check_extra()
    from vibro.explore.server import PORTS, serve
    from vibro.explore.state import initial_state

    wanted = whole_number("--port", port, PORTS)
    request = _request(options)

    def announce(url: str, bound: int, begun: threading.Event) -> None:
        if bound != wanted:
            console.echo(f"port {wanted} is taken: {bound} it is")
        print(url, flush=True)
        console.echo("only this machine reaches it, and one browser; Ctrl-C ends it")
        if no_open:
            console.echo(f"from elsewhere: ssh -L {bound}:127.0.0.1:{bound} host")
        else:
            # Some browsers are waited for until they end.
            threading.Thread(target=_open, args=(url, begun, console), daemon=True).start()

    def report(exc: Exception) -> None:
        if options.debug:
            tell_traceback(exc)
        print_unexpected(exc)

    with _ended_by_ctrl_c(quiet=options.quiet):
        serve(initial_state(request), port=wanted, announce=announce, report=report)
    return ExitCode.DONE


@contextlib.contextmanager
def _ended_by_ctrl_c(*, quiet: bool) -> Iterator[None]:
    """Let Ctrl-C end this process well: it is how the page is meant to end.

    At once, even while threads compute: nobody waits for their answers, and no file is open.
    """

    def end(*_: object) -> None:
        tidy_up()
        with contextlib.suppress(OSError):
            os.write(2, b"" if quiet else _GOODBYE)
        os._exit(ExitCode.DONE)

    before = signal.getsignal(signal.SIGINT)
    if before is signal.SIG_IGN:  # as whoever started it wants
        yield
        return
    signal.signal(signal.SIGINT, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _check_extra() -> None:
    """Say what to install where the server's libraries are missing."""
    try:
        import starlette  # noqa: F401 - whether they are there
        import uvicorn  # noqa: F401
    except ImportError:
        raise FileError("vibro explore needs starlette and uvicorn", hint=how_to_install("explore")) from None


def _request(options: Options) -> Request | None:
    """Read the given scene, if any: its values are the operating point, its axes those of the map."""
    if options.scene is None and not options.given:
        return None
    from vibro.cli.request import request_of
    from vibro.sweeps.request import RANGES

    return request_of(options, reads_map=True, takes_axes=True, ranges=RANGES)


def _open(url: str, begun: threading.Event, console: Console) -> None:
    """Open the page in the user's browser, and wait until it has begun the session."""
    import webbrowser

    from vibro.explore.handover import handed_over

    # Without a screen, Python would open a browser of text in this terminal.
    has_screen = sys.platform in ("win32", "darwin") or not os.environ.keys().isdisjoint(_SCREENS)
    try:
        with contextlib.ExitStack() as end:
            if not has_screen or not webbrowser.open(end.enter_context(handed_over(url)).as_uri()):
                console.echo("no browser could be opened: open the address above in one")
                return
            if not begun.wait(_PATIENCE):  # one that cannot read the file: of another system, or in a sandbox
                console.echo("no browser has shown the page yet: open the address above in one")
            begun.wait()
    except OSError as exc:
        console.echo(f"no browser could be opened ({exc.strerror}): open the address above in one")
