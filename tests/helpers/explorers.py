"""Answers of the explorer that compute nothing, and clients of its application."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from starlette.testclient import TestClient

from vibro.errors import InputError
from vibro.explore.server import create_app

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from starlette.types import ASGIApp

PORT = 8765
HOST = f"127.0.0.1:{PORT}"
TOKEN = "the-token"
STATES = ("/map", "/map?advance=1", "/point", "/guarantee", "/history", "/table.csv")
ROUTES = ("/", "/static/index.html", "/schema", *STATES)


class FakeAnswers:
    """Answers that tell what they were asked; a state is the query itself."""

    def schema(self) -> dict[str, Any]:
        return {"version": "0"}

    def form(self) -> str:
        return "<fieldset>the form</fieldset>"

    def map(self, state: Any, *, advance: bool) -> bytes:
        return repr((state, advance)).encode()

    def point(self, state: Any) -> dict[str, Any]:
        return {"state": state}

    def guarantee(self, state: Any) -> dict[str, Any]:
        return {"text": repr(state)}

    def history(self, state: Any) -> bytes:
        return repr(state).encode()

    def table(self, state: Any) -> Iterator[bytes]:
        yield b"a,b\n"
        yield b"1,2\n"


def read_query(query: Mapping[str, str]) -> Any:
    if "wrong" in query:
        raise InputError("wrong: must be right", hint="put it right")
    return query


def application(answers: object = None, reported: list[Exception] | None = None) -> ASGIApp:
    """Make the application; what it reports goes into a list."""
    reported = [] if reported is None else reported
    chosen: Any = answers or FakeAnswers()
    return create_app(chosen, read_query, port=PORT, token=TOKEN, report=reported.append)


def stranger(app: ASGIApp) -> TestClient:
    """Make a client that has no cookie yet."""
    return TestClient(app, base_url=f"http://{HOST}", follow_redirects=False)


def guest(app: ASGIApp) -> TestClient:
    """Make the client that has shown the token."""
    client = stranger(app)
    assert client.get("/", params={"token": TOKEN}).status_code == 303
    return client
