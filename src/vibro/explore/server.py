"""The explorer's server: its routes, queues and socket.

All computing is done in threads, so that the event loop always answers. The page is read from its files once;
no other file is read, and none is written.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import secrets
import socket
from http import HTTPStatus
from importlib.resources import files
from pathlib import PurePath
from typing import TYPE_CHECKING, Final, TypeVar

import h11
import uvicorn
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, Router
from uvicorn.protocols.http.h11_impl import H11Protocol, RequestResponseCycle

from vibro.errors import FileError, InputError, shown
from vibro.explore.answers import Answers
from vibro.explore.guards import HEADERS, Guarded, RefusedError, Session, query_of
from vibro.explore.state import read_state

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator, Mapping
    from threading import Event

    from starlette.types import ASGIApp, Receive, Scope, Send

    from vibro.explore.state import State

__all__ = ["MOST_WAITING", "PORTS", "bind", "create_app", "serve"]

PORTS: Final = range(1024, 65536)
_TRIES: Final = 20  # ports that are tried, from the wanted one on

#: Most requests of a kind in the queue; a page has one of each under way.
MOST_WAITING: Final = 64
_QUICK: Final = 4  # threads: each answer takes a few times 10 ms
_KEPT_ALIVE: Final = 60  # s; a person pauses

_T = TypeVar("_T")

_TYPES: Final = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
}


class _Turns:
    """Requests of one kind, in threads: some at once, the others in a queue.

    Parameters
    ----------
    at_once : int
        Number of threads.
    """

    def __init__(self, at_once: int) -> None:
        self._free = asyncio.Semaphore(at_once)
        self._waiting = 0

    async def take(self, request: Request, work: Callable[[], _T]) -> _T:
        """Do the work of a request when it is its turn.

        Raises
        ------
        RefusedError
            If too many wait already.
        ClientDisconnect
            If the client has disconnected by then.
        """
        if self._waiting >= MOST_WAITING:
            text = f"{MOST_WAITING} requests of this kind wait already"
            raise RefusedError(HTTPStatus.SERVICE_UNAVAILABLE, text, "ask again", Retry_After="1")
        self._waiting += 1
        try:
            await self._free.acquire()
        finally:
            self._waiting -= 1
        try:
            if await request.is_disconnected():
                raise ClientDisconnect
            return await run_in_threadpool(work)
        finally:
            self._free.release()


class _Download(Response):
    """A file that is sent while it is made; on a failure the connection ends before the file is complete.

    Parameters
    ----------
    name : str
        Of the file.
    more : callable
        Awaited for one piece after the other; None after the last. An empty piece says that the next is still
        being made.
    """

    def __init__(self, name: str, first: bytes | None, more: Callable[[], Awaitable[bytes | None]]) -> None:
        super().__init__(
            media_type="text/csv", headers={"Content-Disposition": f'attachment; filename="{name}"'}
        )
        del self.headers["content-length"]
        self._first = first
        self._more = more

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        await send({"type": "http.response.start", "status": self.status_code, "headers": self.raw_headers})
        piece = self._first
        while piece is not None:
            if piece:
                await send({"type": "http.response.body", "body": piece, "more_body": True})
            piece = await self._more()
        await send({"type": "http.response.body", "body": b"", "more_body": False})


class _Routes:
    """The routes of the server.

    Parameters
    ----------
    answers : Answers
        Its methods are called in threads, several at once.
    read : callable
        Makes the state of a query.
    """

    def __init__(self, answers: Answers, read: Callable[[Mapping[str, str]], State]) -> None:
        self._answers = answers
        self._read = read
        self._files = _page_files()
        self._quick, self._advancing, self._tables = _Turns(_QUICK), _Turns(1), _Turns(1)
        self._searches = _Turns(1)

    def routes(self) -> list[Route]:
        """List them."""
        return [
            Route("/", self._page),
            Route("/static/{name}", self._page),
            Route("/schema", self._schema),
            Route("/map", self._map),
            Route("/point", self._point),
            Route("/guarantee", self._guarantee),
            Route("/history", self._history),
            Route("/table.csv", self._table),
        ]

    async def _page(self, request: Request) -> Response:
        name = request.path_params.get("name", "index.html")
        if name not in self._files:
            raise _missing()
        content, kind = self._files[name]
        return Response(content, media_type=kind)

    async def _schema(self, request: Request) -> Response:
        return JSONResponse(await self._quick.take(request, self._answers.schema))

    async def _map(self, request: Request) -> Response:
        state, advance = self._switched(request, "advance")
        turns = self._advancing if advance else self._quick
        return _binary(await turns.take(request, lambda: self._answers.map(state, advance=advance)))

    async def _point(self, request: Request) -> Response:
        state = self._read(query_of(request.scope))
        return JSONResponse(await self._quick.take(request, lambda: self._answers.point(state)))

    async def _guarantee(self, request: Request) -> Response:
        state = self._read(query_of(request.scope))
        return JSONResponse(await self._searches.take(request, lambda: self._answers.guarantee(state)))

    async def _history(self, request: Request) -> Response:
        state = self._read(query_of(request.scope))
        return _binary(await self._quick.take(request, lambda: self._answers.history(state)))

    async def _table(self, request: Request) -> Response:
        state, decimal_comma = self._switched(request, "decimal_comma")
        pieces = iter(self._answers.table(state, decimal_comma=decimal_comma))

        async def more() -> bytes | None:
            return await self._tables.take(request, lambda: next(pieces, None))

        return _Download("vibro-map.csv", await more(), more)

    def _switched(self, request: Request, name: str) -> tuple[State, bool]:
        """Read the state of a query, and a switch beside it."""
        query = query_of(request.scope)
        text = query.pop(name, "0")
        if text not in ("0", "1"):
            raise InputError(f"{name} = {shown(text)}: must be 1 or 0", fields=[name])
        return self._read(query), text == "1"


def _binary(content: bytes) -> Response:
    return Response(content, media_type="application/octet-stream")


def _missing() -> RefusedError:
    return RefusedError(HTTPStatus.NOT_FOUND, "there is nothing here")


def _page_files() -> dict[str, tuple[bytes, str]]:
    """Read the files of the page, with their types."""
    folder = files("vibro.explore") / "static"
    return {
        file.name: (file.read_bytes(), _TYPES[PurePath(file.name).suffix])
        for file in folder.iterdir()
        if file.is_file()
    }


def create_app(
    answers: Answers,
    read: Callable[[Mapping[str, str]], State],
    *,
    port: int,
    session: Session,
    report: Callable[[Exception], None],
) -> ASGIApp:
    """Make the ASGI application of one session.

    Parameters
    ----------
    answers : Answers
        Its methods are called in threads, several at once.
    read : callable
        Makes the state of a query.
    port : int
        Where the server listens.
    session : Session
        Whose requests are answered.
    report : callable
        Called with every unexpected exception.
    """

    async def nothing(scope: Scope, receive: Receive, send: Send) -> None:
        raise _missing()

    router = Router(_Routes(answers, read).routes(), redirect_slashes=False, default=nothing)
    return Guarded(router, session, port, report)


def bind(port: int) -> socket.socket:
    """Listen on 127.0.0.1, at the first free port from this one on.

    Raises
    ------
    FileError
        If no port nearby is free.
    """
    last = min(port + _TRIES, PORTS.stop) - 1
    for number in range(port, last + 1):
        # A small body, which is sent after its header, would wait 40 ms for that to be acknowledged: asyncio
        # turns Nagle's algorithm off, but only where a socket says that it is TCP.
        listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
        try:
            if os.name == "posix":  # elsewhere it means that others may listen there too
                listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listening.bind(("127.0.0.1", number))
            listening.listen()
        except OSError as exc:
            listening.close()
            reason = exc.strerror
        else:
            return listening
    raise FileError(
        f"cannot listen on any port of {port}...{last}: {reason}", hint="choose another with port="
    )


class _Connection(H11Protocol):
    """A connection that refuses requests other than HTTP, with the usual headers, and closes when idle.

    The clock of uvicorn runs from an answer to the next byte alone: a socket that says nothing, or never ends
    what it asks, would stay open for ever. Here one that has asked nothing new since the last look, and waits
    for no answer, is closed.
    """

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self._look_again()

    def connection_lost(self, exc: Exception | None) -> None:
        self._next_look.cancel()
        super().connection_lost(exc)

    def _look_again(self) -> None:
        self._next_look = self.loop.call_later(_KEPT_ALIVE, self._close_if_silent, self.cycle)

    def _close_if_silent(self, last: RequestResponseCycle | None) -> None:
        if self.cycle is last and getattr(last, "response_complete", True):  # there may have been no request
            self.transport.close()
        else:
            self._look_again()

    def send_400_response(self, msg: str) -> None:
        body = msg.encode()
        headers = [*HEADERS.items(), ("Content-Type", "text/plain; charset=utf-8"), ("Connection", "close")]
        headers.append(("Content-Length", str(len(body))))
        response = h11.Response(status_code=HTTPStatus.BAD_REQUEST, headers=headers, reason=b"Bad Request")
        for event in (response, h11.Data(data=body), h11.EndOfMessage()):
            self.transport.write(self.conn.send(event))
        self.transport.close()


class _Server(uvicorn.Server):
    """A server that leaves signals alone: they end the process at once, even during a request."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


def serve(
    initial: State,
    *,
    port: int,
    announce: Callable[[str, int, Event], None],
    report: Callable[[Exception], None],
) -> None:
    """Serve the explorer until a signal ends the process.

    Parameters
    ----------
    initial : State
        What is shown first.
    port : int
        Where to listen, or the first of those to try.
    announce : callable
        Called with the first address, the port, and what is set once the address is used, when the server
        listens.
    report : callable
        Called with every unexpected exception.

    Raises
    ------
    FileError
        If no port is free.
    """
    with bind(port) as listening:
        port = listening.getsockname()[1]
        token = secrets.token_urlsafe(32)
        session = Session(token)
        app = create_app(
            Answers(initial),
            lambda query: read_state(query, initial),
            port=port,
            session=session,
            report=report,
        )
        config = uvicorn.Config(
            app,
            http=_Connection,
            ws="none",
            lifespan="off",
            log_config=None,
            log_level="critical",
            access_log=False,
            proxy_headers=False,
            server_header=False,
            timeout_keep_alive=_KEPT_ALIVE,
        )
        announce(f"http://127.0.0.1:{port}/#token={token}", port, session.begun)
        asyncio.run(_Server(config).serve(sockets=[listening]))
