"""What the explorer answers at which path, whose turn it is, and where it listens."""

from __future__ import annotations

import asyncio
import socket
import sys
import threading
from functools import cache
from importlib.resources import files
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest
from helpers.cases import each
from helpers.explorers import HOST, ROUTES, FakeAnswers, application, guest

from vibro.errors import FileError
from vibro.explore import server
from vibro.explore.server import MOST_WAITING, bind

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from starlette.testclient import TestClient
    from starlette.types import ASGIApp, Message


class HeldAnswers(FakeAnswers):
    """Answers that wait until they are let go, and count."""

    def __init__(self) -> None:
        self.go = threading.Event()
        self.begun: list[str] = []

    def _wait(self, what: str) -> None:
        self.begun.append(what)
        assert self.go.wait(timeout=60)

    def map(self, state: Any, *, advance: bool) -> bytes:
        self._wait("advance" if advance else "map")
        return b""

    def guarantee(self, state: Any) -> dict[str, Any]:
        self._wait("guarantee")
        return {}

    def table(self, state: Any, *, decimal_comma: bool = False) -> Iterator[bytes]:
        for number in range(3):
            self._wait(f"table {number}")
            yield b"a row\n"


class Asked:
    """A request without a client in between, so that the client can go away."""

    def __init__(self, app: ASGIApp, path: str, session: str) -> None:
        self.sent: list[Message] = []
        self._gone = asyncio.Event()
        path, _, query = path.partition("?")
        headers = [(b"host", HOST.encode()), (b"authorization", session.encode())]
        scope = {
            "type": "http", "method": "GET", "path": path, "raw_path": path.encode(),
            "query_string": query.encode(), "headers": headers,
        }  # fmt: skip
        self._task = asyncio.ensure_future(app(scope, self._receive, self._send))

    async def _receive(self) -> Message:
        await self._gone.wait()
        return {"type": "http.disconnect"}

    async def _send(self, message: Message) -> None:
        self.sent.append(message)

    def leave(self) -> None:
        self._gone.set()

    async def ended(self) -> None:
        await asyncio.wait_for(self._task, timeout=60)

    @property
    def status(self) -> int | None:
        return self.sent[0]["status"] if self.sent else None


async def until(true: Callable[[], bool]) -> None:
    async with asyncio.timeout(60):
        while not true():
            await asyncio.sleep(0.001)


def session(app: ASGIApp) -> str:
    return guest(app).headers["Authorization"]


@pytest.fixture
def known() -> TestClient:
    return guest(application())


def test_states_reach_their_answers(known: TestClient) -> None:
    state = {"amplitude_mm": "1"}
    assert known.get("/map", params=state).text == repr((state, False))
    assert known.get("/map", params={**state, "advance": "1"}).text == repr((state, True))
    assert known.get("/point", params=state).json() == {"state": state}
    assert known.get("/history", params=state).text == repr(state)
    assert known.get("/schema").json() == {"version": "0"}


@each("path", ["/map", "/map?advance=1&", "/point", "/history", "/table.csv"])
def test_wrong_states_are_refused_before_anything_is_asked(path: str) -> None:
    answers: Any = SimpleNamespace()  # which can do nothing
    response = guest(application(answers)).get(path, params={"wrong": "1"})
    assert response.status_code == 400
    assert response.json() == {
        "problems": [{"field": "", "text": "wrong: must be right"}], "hint": "put it right"
    }  # fmt: skip


@each(("path", "switch"), [("/map", "advance"), ("/table.csv", "decimal_comma")])
@each("text", ["", "2", "yes"])
def test_switches_are_on_or_off(known: TestClient, path: str, switch: str, text: str) -> None:
    response = known.get(path, params={switch: text})
    assert (response.status_code, response.json()["problems"][0]["field"]) == (400, switch)


def test_tables_are_downloads(known: TestClient) -> None:
    response = known.get("/table.csv")
    assert response.text == "a,b\n1,2\n"
    assert response.headers["content-type"] == "text/csv; charset=utf-8"
    assert response.headers["content-disposition"] == 'attachment; filename="vibro-map.csv"'
    assert "content-length" not in response.headers  # nobody knows it yet
    assert known.get("/table.csv?decimal_comma=1").text == "a;b\n1;2\n"


def test_types_are_told(known: TestClient) -> None:
    kinds = {path: known.get(path).headers["content-type"] for path in ROUTES}
    assert kinds["/"] == kinds["/static/index.html"] == "text/html; charset=utf-8"
    assert kinds["/schema"] == kinds["/point"] == "application/json"
    assert kinds["/map"] == kinds["/history"] == "application/octet-stream"


def test_the_page_is_all_there(known: TestClient) -> None:
    kinds = {"html": "text/html", "css": "text/css", "js": "text/javascript", "svg": "image/svg+xml"}
    folder = files("vibro.explore") / "static"
    page = [file for file in folder.iterdir() if file.is_file()]
    assert "index.html" in [file.name for file in page]
    for file in page:
        response = known.get(f"/static/{file.name}")
        assert response.content == file.read_bytes()
        assert response.headers["content-type"].split(";")[0] == kinds[file.name.rpartition(".")[2]]
    assert known.get("/").content == known.get("/static/index.html").content


@each(
    "path",
    [
        "/static/", "/static/nothing.js", "/static/../server.py", "/static/%2e%2e/server.py",
        "/static/..%2fserver.py", "/static//etc/passwd", "/static/%2fetc%2fpasswd", "/map/",
        "/schema.json", "/static/index.html/", "/static/index.html%00", "/static/C:%5Cindex.html",
    ],
)  # fmt: skip
def test_there_is_nothing_else(known: TestClient, path: str) -> None:
    response = known.get(path)
    assert response.status_code == 404
    assert response.json() == {"problems": [{"field": "", "text": "there is nothing here"}], "hint": ""}


_FILE_EVENTS = ("open", "os.listdir", "os.scandir", "os.mkdir", "os.remove", "os.rename")
_noted: list[list[str]] = []


@cache
def _note_files() -> None:
    """Note what is done to files, where somebody wants to know; it lasts as long as the process."""

    def note(event: str, args: tuple[Any, ...]) -> None:
        for noted in _noted:
            if event in _FILE_EVENTS:
                noted.append(f"{event} {args[0]}")

    sys.addaudithook(note)


@pytest.fixture
def opened() -> Iterator[list[str]]:
    """What is done to files, from now on."""
    _note_files()
    _noted.append([])
    yield _noted[0]
    _noted.clear()


def test_requests_touch_no_files(known: TestClient, opened: list[str]) -> None:
    for path in (*ROUTES, "/static/nothing.js", "/static/..%2fserver.py", "/map?wrong=1"):
        known.get(path)
    assert opened == []
    Path(__file__).read_bytes()  # it would be seen
    assert opened == [f"open {__file__}"]


def test_work_takes_turns() -> None:
    """Work on maps, on tables and on guarantees is done by one at a time and holds up nothing else."""
    answers = HeldAnswers()
    app = application(answers)
    known = session(app)

    async def ask() -> None:
        slow = [Asked(app, path, known) for path in 3 * ["/map?advance=1", "/table.csv", "/guarantee"]]
        await until(lambda: len(answers.begun) == 3)
        quick = Asked(app, "/point", known)
        await quick.ended()
        assert quick.status == 200
        maps = [Asked(app, "/map", known) for _ in range(10)]
        await until(lambda: len(answers.begun) == 3 + 4)
        await asyncio.sleep(0.05)
        assert sorted(answers.begun) == ["advance", "guarantee", *4 * ["map"], "table 0"]
        answers.go.set()
        for asked in slow + maps:
            await asked.ended()
            assert asked.status == 200
            assert not asked.sent[-1].get("more_body")

    asyncio.run(ask())
    assert answers.begun.count("advance") == 3
    assert answers.begun.count("map") == 10


def test_too_many_are_asked_to_come_again() -> None:
    answers = HeldAnswers()
    app = application(answers)
    known = session(app)

    async def ask() -> None:
        begun = Asked(app, "/map?advance=1", known)
        await until(lambda: answers.begun != [])
        waiting = [Asked(app, "/map?advance=1", known) for _ in range(MOST_WAITING)]
        await asyncio.sleep(0)
        refused = Asked(app, "/map?advance=1", known)
        await refused.ended()
        assert refused.status == 503
        assert (b"retry-after", b"1") in refused.sent[0]["headers"]
        assert b"64 requests of this kind wait already" in refused.sent[1]["body"]
        answers.go.set()
        for asked in (begun, *waiting):
            await asked.ended()
            assert asked.status == 200
        again = Asked(app, "/map?advance=1", known)
        await again.ended()
        assert again.status == 200

    asyncio.run(ask())


def test_nothing_is_done_for_those_who_have_left() -> None:
    answers = HeldAnswers()
    reported = list[Exception]()
    app = application(answers, reported)
    known = session(app)

    async def ask() -> None:
        stays = Asked(app, "/map?advance=1", known)
        await until(lambda: answers.begun != [])
        leaves = [Asked(app, "/map?advance=1", known) for _ in range(10)]
        table = Asked(app, "/table.csv", known)
        await until(lambda: len(answers.begun) == 2)
        for asked in (*leaves, table):
            asked.leave()
        answers.go.set()
        for asked in (stays, *leaves, table):
            await asked.ended()
        assert stays.status == 200
        assert [asked.sent for asked in leaves] == 10 * [[]]
        assert not any(message.get("more_body") is False for message in table.sent)
        last = Asked(app, "/map?advance=1", known)  # everybody's turn is free again
        await last.ended()
        assert last.status == 200

    asyncio.run(ask())
    assert answers.begun == ["advance", "table 0", "advance"]
    assert reported == []


def test_a_table_that_fails_on_the_way_does_not_end_well() -> None:
    class Failing(FakeAnswers):
        def table(self, state: Any, *, decimal_comma: bool = False) -> Iterator[bytes]:
            yield b"a row\n"
            raise ZeroDivisionError

    reported = list[Exception]()
    app = application(Failing(), reported)
    known = session(app)

    async def ask() -> None:
        asked = Asked(app, "/table.csv", known)
        with pytest.raises(ZeroDivisionError):  # upon which the server closes the connection
            await asked.ended()
        assert [message.get("more_body") for message in asked.sent] == [None, True]

    asyncio.run(ask())
    assert len(reported) == 1


def test_a_table_that_fails_at_once_is_an_error() -> None:
    class Failing(FakeAnswers):
        def table(self, state: Any, *, decimal_comma: bool = False) -> Iterator[bytes]:
            yield from map(int.to_bytes, [-1])

    assert guest(application(Failing())).get("/table.csv").status_code == 500


def test_a_busy_port_picks_the_next() -> None:
    with bind(20_000) as first:
        host, port = first.getsockname()
        assert host == "127.0.0.1"
        with bind(port) as second:
            assert second.getsockname()[0] == "127.0.0.1"
            assert port < second.getsockname()[1] < port + 20


def test_no_free_port_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "_TRIES", 1)
    with bind(21_000) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(FileError, match=f"cannot listen on any port of {port}...{port}: ") as error:
            bind(port)
        assert error.value.hint == "choose another with port="


def test_the_last_port_is_the_last() -> None:
    with bind(65_535) as taken:
        assert taken.getsockname()[1] == 65_535
        with pytest.raises(FileError, match=r"65535\.\.\.65535"):
            bind(65_535)


def test_small_answers_are_sent_at_once() -> None:
    """Nagle's algorithm would keep the body of one back until its header is acknowledged, 40 ms later."""

    async def connect() -> int:
        delays = asyncio.get_running_loop().create_future()

        def met(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            taken = writer.get_extra_info("socket")
            delays.set_result(taken.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
            writer.close()

        with bind(22_000) as listening:
            async with await asyncio.start_server(met, sock=listening):
                _, writer = await asyncio.open_connection(*listening.getsockname())
                writer.close()
                return int(await delays)

    assert asyncio.run(connect()) != 0
