"""Answers of the explorer that compute nothing, and clients of its application."""

from __future__ import annotations

import threading
from queue import Queue
from typing import TYPE_CHECKING, Any

from starlette.testclient import TestClient

from vibro.errors import InputError
from vibro.explore.guards import Session
from vibro.explore.server import create_app, serve
from vibro.explore.state import initial_state

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from starlette.types import ASGIApp

    from vibro.explore.state import State

PORT = 8765
HOST = f"127.0.0.1:{PORT}"
TOKEN = "the-token"
STATES = ("/map", "/map?advance=1", "/point", "/guarantee", "/history", "/table.csv")
GUARDED = ("/schema", *STATES)
ROUTES = ("/", "/static/index.html", *GUARDED)


class FakeAnswers:
    """Answers that tell what they were asked; a state is the query itself."""

    def schema(self) -> dict[str, Any]:
        return {"version": "0"}

    def map(self, state: Any, *, advance: bool) -> bytes:
        return repr((state, advance)).encode()

    def point(self, state: Any) -> dict[str, Any]:
        return {"state": state}

    def guarantee(self, state: Any) -> dict[str, Any]:
        return {"text": repr(state)}

    def history(self, state: Any) -> bytes:
        return repr(state).encode()

    def table(self, state: Any, *, decimal_comma: bool = False) -> Iterator[bytes]:
        yield b"a;b\n" if decimal_comma else b"a,b\n"
        yield b""  # it takes a while
        yield b"1;2\n" if decimal_comma else b"1,2\n"


def read_query(query: Mapping[str, str]) -> Any:
    if "wrong" in query:
        raise InputError("wrong: must be right", hint="put it right")
    return query


def application(
    answers: object = None,
    reported: list[Exception] | None = None,
    read: Callable[[Mapping[str, str]], Any] = read_query,
) -> ASGIApp:
    """Make the application; what it reports goes into a list."""
    reported = [] if reported is None else reported
    chosen: Any = answers or FakeAnswers()
    return create_app(chosen, read, port=PORT, session=Session(TOKEN), report=reported.append)


def stranger(app: ASGIApp) -> TestClient:
    """Make a client that has no secret yet."""
    return TestClient(app, base_url=f"http://{HOST}", follow_redirects=False)


def guest(app: ASGIApp) -> TestClient:
    """Make the client that has shown the token."""
    client = stranger(app)
    begun = client.get("/session", headers=bearer(TOKEN))
    assert begun.status_code == 200
    client.headers.update(bearer(begun.text))
    return client


def bearer(secret: str) -> dict[str, str]:
    """Return the header that shows a token or a secret."""
    return {"Authorization": f"Bearer {secret}"}


def serve_explorer(initial: State | None = None) -> str:
    """Serve the explorer; return its first address."""
    announced: Queue[str] = Queue()
    reported: list[Exception] = []
    job = {"port": 8800, "announce": lambda url, port, begun: announced.put(url), "report": reported.append}
    threading.Thread(target=serve, args=(initial or initial_state(),), kwargs=job, daemon=True).start()
    return announced.get(timeout=60)
