"""Answers of the explorer that compute nothing, and clients of its application."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from starlette.testclient import TestClient

from vibro.errors import InputError
from vibro.explore.server import create_app

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

PORT = 8765
HOST = f"127.0.0.1:{PORT}"
TOKEN = "the-token"


class FakeAnswers:
    """Answers that say what they were asked; a state is the query itself."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, object]] = []
        self.release = threading.Event()

    def schema(self) -> dict[str, Any]:
        return {"version": "0"}

    def map(self, state: Mapping[str, str], advance: bool) -> bytes:
        self.asked.append(("map", advance))
        return repr((dict(state), advance)).encode()

    def point(self, state: Mapping[str, str]) -> dict[str, Any]:
        return {"state": dict(state)}

    def history(self, state: Mapping[str, str]) -> bytes:
        return b"history"

    def table(self, state: Mapping[str, str]) -> Iterator[bytes]:
        yield b"a,b\n"
        yield b"1,2\n"


def read(query: Mapping[str, str]) -> Any:
    if "wrong" in query:
        raise InputError("wrong: must be right", hint="put it right")
    return query


def client(answers: Any = None, **more: Any) -> TestClient:
    """A client that knows nothing yet."""
    app = create_app(answers or FakeAnswers(), read, port=PORT, token=TOKEN, report=print)
    return TestClient(app, base_url=f"http://{HOST}", follow_redirects=False, **more)
