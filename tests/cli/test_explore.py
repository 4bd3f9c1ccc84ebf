"""``vibro explore``: its options, its messages, and the program itself."""

from __future__ import annotations

import http.client
import json
import re
import signal
import socket
import stat
import subprocess
import sys
import threading
import time
import webbrowser
from contextlib import closing, contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit
from urllib.request import url2pathname

import pytest
from helpers.commands import POSIX, started
from helpers.explorers import bearer
from helpers.made_records import EXAMPLES

from vibro.explore import server

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from helpers.commands import Run

SCENE = str(EXAMPLES / "safety_nut.toml")
URL = "http://127.0.0.1:8765/#token=t"


@pytest.fixture
def served(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """States that would be served; the command believes that it was at port 8765, and that somebody came."""
    states: list[Any] = []
    begun = threading.Event()
    begun.set()

    def serve(initial: Any, *, port: int, announce: Callable[..., None], report: object) -> None:
        states.append(initial)
        announce(URL, 8765, begun)

    monkeypatch.setattr(server, "serve", serve)
    return states


class Page:
    """A browser's part of the conversation with a program that runs."""

    def __init__(self, run: subprocess.Popen[str]) -> None:
        assert run.stdout is not None
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/#token=([\w-]{40,})\n", run.stdout.readline())
        assert found
        self.port, self.token = int(found[1]), found[2]
        self._headers = dict[str, str]()

    def begin(self) -> Page:
        self._headers = bearer(self.token)
        status, _, secret = self.get("/session")
        assert status == 200
        self._headers = bearer(secret.decode())
        return self

    def get(self, path: str) -> tuple[int, http.client.HTTPMessage, bytes]:
        with closing(http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)) as connection:
            connection.request("GET", path, headers=self._headers)
            with connection.getresponse() as response:
                return response.status, response.headers, response.read()

    def ask(self, path: str) -> None:
        """Ask for what may never come."""
        with suppress(OSError, http.client.HTTPException):
            self.get(path)


@contextmanager
def running(folder: Path, *args: str) -> Iterator[subprocess.Popen[str]]:
    """Run the program, and end it whatever happens."""
    run = started("explore", *args, cwd=folder)
    try:
        yield run
    finally:
        run.kill()
        run.communicate()


@POSIX
def test_the_program_serves_until_it_is_interrupted(tmp_path: Path) -> None:
    with (
        running(tmp_path, SCENE, "--no-open") as first,
        running(tmp_path, SCENE, "-A", "2", "--no-open") as second,
    ):
        pages = [Page(first).begin(), Page(second).begin()]
        assert pages[0].port != pages[1].port
        for page, amplitude in zip(pages, ("1", "2"), strict=True):
            status, headers, content = page.get("/schema")
            assert (status, headers["content-type"]) == (200, "application/json")
            assert json.loads(content)["initial"]["amplitude_mm"] == amplitude
            assert "server" not in headers
            assert page.get("/")[0] == 200
        assert page.get("/point?amplitude_mm=x")[0] == 400
        # What is no HTTP at all gets the headers of all responses too.
        with socket.create_connection(("127.0.0.1", pages[0].port)) as client:
            client.sendall(b"\x16\x03\x01\r\n\r\n")
            said = client.makefile("rb").read()
        assert said.startswith(b"HTTP/1.1 400 ")
        assert b"\r\nContent-Security-Policy: default-src 'none'" in said
        # Signals end it at once, whatever it computes for whom.
        asked = [threading.Thread(target=page.ask, args=("/table.csv?restitution=0.5",)) for page in pages]
        for thread in asked:
            thread.start()
        time.sleep(0.2)
        first.send_signal(signal.SIGINT)
        second.send_signal(signal.SIGTERM)
        ends = [(run.communicate(timeout=60)[1].splitlines(), run.returncode) for run in (first, second)]
        for thread in asked:
            thread.join()
    how = ((0, "goodbye: the page gets no more answers"), (130, "error: interrupted"))
    for page, (echo, code), (wanted, last) in zip(pages, ends, how, strict=True):
        assert code == wanted
        assert echo[-3:] == [
            "only this machine reaches it, and one browser; Ctrl-C ends it",
            f"from elsewhere: ssh -L {page.port}:127.0.0.1:{page.port} host",
            last,
        ]
    taken = [echo for echo, _ in ends if len(echo) == 4]
    assert taken != []
    for echo in taken:
        assert re.fullmatch(r"port 8765 is taken: \d+ it is", echo[0])


@pytest.mark.parametrize(("quiet", "said"), [((), "goodbye: the page gets no more answers\n"), (("-q",), "")])
def test_ctrl_c_is_its_end(
    run: Run,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    quiet: tuple[str, ...],
    said: str,
) -> None:
    ended: list[int] = []
    monkeypatch.setattr("os._exit", ended.append)
    monkeypatch.setattr(server, "serve", lambda *_, **__: signal.raise_signal(signal.SIGINT))
    before = signal.getsignal(signal.SIGINT)
    run("explore", "--no-open", *quiet)
    assert ended == [0]
    assert capfd.readouterr().err == said
    assert signal.getsignal(signal.SIGINT) is before


def test_an_ignored_ctrl_c_stays_ignored(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """As for a job in the background of a script."""
    monkeypatch.setattr("os._exit", None)
    monkeypatch.setattr(server, "serve", lambda *_, **__: signal.raise_signal(signal.SIGINT))
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        assert run("explore", "--no-open").exit_code == 0
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[tuple[Path, str]]:
    """The files that a browser is opened with, and what they hold."""
    pages: list[tuple[Path, str]] = []

    def open_(address: str) -> bool:
        file = Path(url2pathname(urlsplit(address).path))
        pages.append((file, file.read_text(encoding="utf-8")))
        return True

    for name in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.setattr(webbrowser, "open", open_)
    monkeypatch.setattr(threading, "Thread", AtOnce)
    monkeypatch.setenv("BROWSER", "firefox")
    return pages


def test_a_browser_is_opened(run: Run, served: list[Any], opened: list[tuple[Path, str]]) -> None:
    result = run("explore")
    ((file, page),) = opened
    assert f'content="0; url={URL}"' in page
    assert not file.exists()  # once it was used
    assert not file.parent.exists()
    assert "open the address above" not in result.stderr
    assert "ssh" not in result.stderr


def test_that_no_browser_can_be_opened_is_told(
    run: Run, served: list[Any], opened: list[tuple[Path, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(webbrowser, "open", lambda _: False)
    assert "no browser could be opened: open the address above in one\n" in run("explore").stderr

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tempfile.mkdtemp", full)
    told = "no browser could be opened (No space left on device): open the address above in one\n"
    assert told in run("explore").stderr


def test_a_browser_that_cannot_read_the_file_is_told_of(
    run: Run, opened: list[tuple[Path, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Such as one of Windows that is opened from its Linux."""

    class Late(threading.Event):
        def wait(self, timeout: float | None = None) -> bool:
            assert opened[0][0].exists()  # it may still come
            return timeout is None

    def serve(*_: object, announce: Callable[..., None], **__: object) -> None:
        announce(URL, 8765, Late())

    monkeypatch.setattr(server, "serve", serve)
    told = "no browser has shown the page yet: open the address above in one\n"
    assert told in run("explore").stderr
    assert not opened[0][0].exists()


@POSIX
def test_the_token_is_in_no_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What everybody may read of the browser's process leads to a file that its owner alone may read.

    It is in the home folder and not hidden: browsers in a sandbox see no other.
    """
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/part && mv {tmp_path}/part {tmp_path}/seen\n')
    browser.chmod(0o700)
    home = tmp_path / "home"
    home.mkdir()
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("BROWSER", f"{browser} %s")
    with running(tmp_path) as run:
        page, seen = Page(run), tmp_path / "seen"
        until(seen.exists)
        (folder,) = home.glob("vibro-*")
        (file,) = folder.iterdir()
        assert seen.read_text().split() == [file.as_uri()]
        assert [stat.S_IMODE(path.stat().st_mode) for path in (folder, file)] == [0o700, 0o600]
        assert page.token in file.read_text()
        run.send_signal(signal.SIGTERM)
        run.communicate(timeout=60)
        until(lambda: not [*home.glob("vibro-*")])


def until(holds: Callable[[], object]) -> None:
    """Wait until something holds; a test that it never does ends at a limit."""
    for _ in range(6000):
        if holds():
            return
        time.sleep(0.01)
    pytest.fail("it never does")


@pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="there is always a screen")
def test_no_browser_is_opened_without_a_screen(
    run: Run, served: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python would start one that draws text into the terminal."""
    monkeypatch.setattr(webbrowser, "open", None)
    monkeypatch.setattr(threading, "Thread", AtOnce)
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    assert "no browser could be opened: open the address above in one\n" in run("explore").stderr


class AtOnce:
    """A thread that is over when it has begun."""

    def __init__(self, target: Callable[..., object], args: tuple[object, ...], daemon: bool) -> None:
        self._run = partial(target, *args)

    def start(self) -> None:
        self._run()


@pytest.mark.parametrize("debug", [False, True])
def test_what_nobody_expected_is_told_on_stderr(
    run: Run, monkeypatch: pytest.MonkeyPatch, debug: bool
) -> None:
    def serve(*_: object, report: Callable[[Exception], None], **__: object) -> None:
        try:
            raise ZeroDivisionError("oops")
        except ZeroDivisionError as exc:
            report(exc)

    monkeypatch.setattr(server, "serve", serve)
    result = run("explore", *["--debug"] * debug)
    assert result.stderr.endswith(
        "error: unexpected ZeroDivisionError: oops\nhint: please report it with the output of --debug\n"
    )
    assert ("Traceback" in result.stderr) == debug
