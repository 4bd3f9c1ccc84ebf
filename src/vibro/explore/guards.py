"""Access checks before every route of the explorer.

The server listens on 127.0.0.1, but so can be reached by any page of the browser and by every user of the
machine. Host and Origin keep other sites out, also those whose names resolve to 127.0.0.1; a token, which is
in the first address alone, and the secret that it is exchanged for keep out everybody else. A browser sends a
cookie to every port of a host, and with it to the servers of other users: the page sends the secret in a
header instead, and keeps it where pages of this port alone can read it. What begins with # in an address, as
the token does, is not sent at all. The page itself and its scripts are the same for everybody and know no
secret: they are answered before there is a session.
"""

from __future__ import annotations

import secrets
from http import HTTPStatus
from itertools import chain, repeat
from threading import Event
from typing import TYPE_CHECKING, Final
from urllib.parse import parse_qsl

from starlette.datastructures import Headers
from starlette.requests import ClientDisconnect
from starlette.responses import JSONResponse, PlainTextResponse, Response

from vibro.errors import InputError, VibroError, cut, printable

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from starlette.types import ASGIApp, Message, Receive, Scope, Send

__all__ = ["HEADERS", "LONGEST_QUERY", "Guarded", "RefusedError", "Session", "query_of"]

LONGEST_QUERY: Final = 4096  # characters; a state with every key takes a few hundred

#: Headers of every response: the page loads from this server only, and no other site may load from it.
HEADERS: Final = {
    "Referrer-Policy": "no-referrer",
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self';"
    " img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none';"
    " frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}
_RAW_HEADERS: Final = [(name.lower().encode(), value.encode()) for name, value in HEADERS.items()]
_METHODS: Final = ("GET", "HEAD")
_NO_SESSION: Final = (
    "no session: open the address that vibro explore printed, which counts once; for another browser,"
    " start vibro explore again"
)


class RefusedError(VibroError):
    """A refused request, and the reason.

    Attributes
    ----------
    status : HTTPStatus
        Of the response.
    hint : str
        The remedy; empty if the message gives it.
    headers : dict of str to str
        Of the response, beside the common ones.
    """

    def __init__(self, status: HTTPStatus, text: str, hint: str = "", **headers: str) -> None:
        self.status = status
        self.hint = hint
        self.headers = {name.replace("_", "-"): value for name, value in headers.items()}
        super().__init__(text)


class Session:
    """The only browser that is served: it showed the token first and has kept the secret since.

    Parameters
    ----------
    token : str
        In the first address; valid once.

    Attributes
    ----------
    begun : threading.Event
        Set once the token was shown.
    """

    def __init__(self, token: str) -> None:
        self.begun = Event()
        self._token = token
        self._secret = secrets.token_urlsafe(32)

    def begin(self, headers: Headers) -> str | None:
        """Return the secret for the token, which counts once; None if a request does not show it."""
        if self.begun.is_set() or not _shows(headers, self._token):
            return None
        self.begun.set()
        return self._secret

    def has(self, headers: Headers) -> bool:
        """Return whether a request shows the secret."""
        return _shows(headers, self._secret)


def _shows(headers: Headers, wanted: str) -> bool:
    """Compare what a request shows in a time that does not depend on where texts differ."""
    given = headers.get("authorization", "")
    return secrets.compare_digest(given.encode(), f"Bearer {wanted}".encode())


def _is_open(path: str) -> bool:
    """Whether a path is answered without a session: the page and its files, which everybody may have."""
    return path == "/" or path.startswith("/static/")


def query_of(scope: Scope) -> dict[str, str]:
    """Read the query of a request.

    Raises
    ------
    RefusedError
        Where it is too long, gives a key twice or is not UTF-8.
    """
    raw: bytes = scope["query_string"]
    if len(raw) > LONGEST_QUERY:
        raise RefusedError(
            HTTPStatus.BAD_REQUEST,
            f"the query has {len(raw)} characters: it must have at most {LONGEST_QUERY}",
        )
    try:
        pairs = parse_qsl(raw.decode("ascii"), keep_blank_values=True, errors="strict")
    except UnicodeDecodeError:
        raise RefusedError(HTTPStatus.BAD_REQUEST, "the query is not UTF-8") from None
    query: dict[str, str] = {}
    for key, value in pairs:
        if key in query:
            raise RefusedError(HTTPStatus.BAD_REQUEST, f"the query gives {cut(key)} twice", "give it once")
        query[key] = value
    return query


class Guarded:
    """ASGI application that passes on requests of the session's own page, and refuses all others.

    Parameters
    ----------
    app : ASGI application
        Receives the requests that pass.
    session : Session
        Whose requests pass.
    port : int
        Where the server listens.
    report : callable
        Called with every unexpected exception; the client gets a message without its traceback.
    """

    def __init__(
        self, app: ASGIApp, session: Session, port: int, report: Callable[[Exception], None]
    ) -> None:
        self._app = app
        self._session = session
        self._port = port
        self._report = report
        self._hosts = (f"127.0.0.1:{port}", f"localhost:{port}")
        self._origins = {f"http://{host}" for host in self._hosts}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it; web sockets are always refused."""
        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})  # before it is accepted: a 403
            return
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        started = False

        async def send_guarded(message: Message) -> None:
            nonlocal started
            if message["type"] == "http.response.start":
                started = True
                message = {**message, "headers": [*message.get("headers", ()), *_RAW_HEADERS]}
            await send(message)

        try:
            await (self._check(scope) or self._app)(scope, receive, send_guarded)
        except ClientDisconnect:  # the client has gone
            return
        except Exception as exc:
            if not isinstance(exc, VibroError):
                self._report(exc)
            if started:
                raise  # the server cuts the response short, and the client sees that
            await _response_of(exc, in_a_tab=scope["path"] == "/")(scope, receive, send_guarded)

    def _check(self, scope: Scope) -> Response | None:
        """Refuse a request, or let it through, or begin the session.

        Raises
        ------
        RefusedError
            If it is not from the session's own page.
        """
        headers = Headers(scope=scope)
        self._check_source(scope, headers)
        if scope["method"] not in _METHODS:
            raise RefusedError(
                HTTPStatus.METHOD_NOT_ALLOWED, "only GET and HEAD are answered", Allow="GET, HEAD"
            )
        if _is_open(scope["path"]) or self._session.has(headers):
            return None
        # What only looks at addresses sends HEAD, which must not use up the token.
        begins = (scope["method"], scope["path"]) == ("GET", "/session")
        if begins and (secret := self._session.begin(headers)):
            return PlainTextResponse(secret)
        raise RefusedError(HTTPStatus.FORBIDDEN, _NO_SESSION)

    def _check_source(self, scope: Scope, headers: Headers) -> None:
        """Refuse requests of other sites, also those that they cause the browser to make."""
        hosts = [host.lower() for host in headers.getlist("host")]
        if len(hosts) != 1 or hosts[0] not in self._hosts:
            port = self._port
            raise RefusedError(
                HTTPStatus.FORBIDDEN,
                f"Host {cut(', '.join(hosts)) or 'is missing'}: it must be {' or '.join(self._hosts)}",
                f"an ssh tunnel needs the same port on both sides: ssh -L {port}:127.0.0.1:{port} host",
            )
        if any(origin.lower() not in self._origins for origin in headers.getlist("origin")):
            raise RefusedError(HTTPStatus.FORBIDDEN, "Origin: pages of other sites are not answered")
        # To a browser other ports of this host are the same site: refuse them. Links may lead to the page.
        is_link = (scope["path"], headers.get("sec-fetch-dest"), headers.get("sec-fetch-mode")) == (
            "/", "document", "navigate",
        )  # fmt: skip
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none") and not is_link:
            raise RefusedError(HTTPStatus.FORBIDDEN, "Sec-Fetch-Site: pages of other sites are not answered")


def _response_of(exc: Exception, *, in_a_tab: bool) -> Response:
    """Report an error: as plain text if a person opened the address, else as JSON."""
    status, headers = HTTPStatus.BAD_REQUEST, dict[str, str]()
    told: Sequence[str] = (str(exc),)
    fields: Sequence[str] = ()
    if isinstance(exc, RefusedError):
        status, headers = exc.status, exc.headers
    elif isinstance(exc, InputError):
        told, fields = exc.problems, exc.fields
    elif not isinstance(exc, VibroError):
        status = HTTPStatus.INTERNAL_SERVER_ERROR
        told = (f"unexpected {type(exc).__name__}; please report it with the output of --debug",)
    problems = [{"field": f, "text": text} for text, f in zip(told, chain(fields, repeat("")), strict=False)]
    hint = getattr(exc, "hint", "")
    if in_a_tab:
        lines = [problem["text"] for problem in problems] + [hint] * bool(hint)
        return PlainTextResponse("\n".join(map(printable, lines)) + "\n", status, headers)
    return JSONResponse({"problems": problems, "hint": hint}, status, headers)
