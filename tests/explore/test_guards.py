"""Whom the explorer answers, and what every response says to the browser."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import pytest
from helpers.explorers import HOST, PORT, ROUTES, TOKEN, FakeAnswers, application, guest, stranger
from starlette.websockets import WebSocketDisconnect

from vibro.errors import InputError, VibroError
from vibro.explore.guards import LONGEST_QUERY

if TYPE_CHECKING:
    from starlette.testclient import TestClient

EVERYWHERE = (*ROUTES, "/nowhere", "/static/nothing.js")
HEADERS = {
    "referrer-policy": "no-referrer",
    "content-security-policy": "default-src 'none'; script-src 'self'; style-src 'self';"
    " img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none';"
    " frame-ancestors 'none'",
    "x-content-type-options": "nosniff",
    "cache-control": "no-store",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
}


class FailingAnswers(FakeAnswers):
    def __init__(self, error: Exception) -> None:
        self.error = error

    def point(self, state: Any) -> dict[str, Any]:
        raise self.error


@pytest.fixture(scope="module")
def known() -> TestClient:
    return guest(application())


def text_of(response: Any) -> str:
    """Return the one problem and the hint of a refusal."""
    if response.headers["content-type"].startswith("text/plain"):
        return str(response.text)
    content = response.json()
    (problem,) = content["problems"]
    assert problem["field"] == ""
    return f"{problem['text']}\n{content['hint']}\n"


@pytest.mark.parametrize("path", EVERYWHERE)
@pytest.mark.parametrize(
    "host", [f"evil.example:{PORT}", "127.0.0.1", "127.0.0.1:8766", f"[::1]:{PORT}", "", "x"]
)
def test_foreign_hosts_are_refused_everywhere(known: TestClient, path: str, host: str) -> None:
    """Among them names of other sites that resolve to 127.0.0.1."""
    response = known.get(path, headers={"Host": host})
    assert response.status_code == 403
    assert "ssh -L 8765:127.0.0.1:8765 host" in text_of(response)


@pytest.mark.parametrize("host", [HOST, f"localhost:{PORT}", f"LocalHost:{PORT}"])
def test_own_hosts_are_answered(known: TestClient, host: str) -> None:
    cookie = "; ".join(f"{name}={value}" for name, value in known.cookies.items())
    assert known.get("/schema", headers={"Host": host, "Cookie": cookie}).status_code == 200


def test_two_hosts_are_refused(known: TestClient) -> None:
    headers = [("Host", HOST), ("Host", "evil.example")]
    assert known.get("/schema", headers=headers).status_code == 403


@pytest.mark.parametrize("path", EVERYWHERE)
@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:8766", f"https://{HOST}", ""]
)
def test_foreign_origins_are_refused_everywhere(known: TestClient, path: str, origin: str) -> None:
    response = known.get(path, headers={"Origin": origin})
    assert (response.status_code, "Origin" in text_of(response)) == (403, True)


@pytest.mark.parametrize("origin", [f"http://{HOST}", f"http://localhost:{PORT}"])
def test_own_origins_are_answered(known: TestClient, origin: str) -> None:
    assert known.get("/schema", headers={"Origin": origin}).status_code == 200


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_what_other_pages_make_the_browser_fetch_is_refused(known: TestClient, site: str) -> None:
    link = {"Sec-Fetch-Site": site, "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "document"}
    for path in EVERYWHERE:
        assert known.get(path, headers={"Sec-Fetch-Site": site}).status_code == 403
        assert known.get(path, headers={**link, "Sec-Fetch-Dest": "iframe"}).status_code == 403
        assert known.get(path, headers={**link, "Sec-Fetch-Mode": "cors"}).status_code == 403
        # A link to the page itself is followed.
        assert known.get(path, headers=link).status_code == (200 if path == "/" else 403)


@pytest.mark.parametrize("site", ["same-origin", "none"])
def test_what_the_own_page_fetches_is_answered(known: TestClient, site: str) -> None:
    assert known.get("/schema", headers={"Sec-Fetch-Site": site}).status_code == 200


@pytest.mark.parametrize("origin", ["http://evil.example", f"http://{HOST}"])
@pytest.mark.parametrize("path", ["/", "/map"])
def test_web_sockets_are_refused(known: TestClient, path: str, origin: str) -> None:
    """Before they are accepted, which is a 403."""
    with (
        pytest.raises(WebSocketDisconnect) as refused,
        known.websocket_connect(path, headers={"Origin": origin}),
    ):
        pytest.fail("accepted")
    assert refused.value.code == 1008


@pytest.mark.parametrize("path", EVERYWHERE)
def test_without_the_cookie_nothing_is_answered(path: str) -> None:
    response = stranger(application()).get(path)
    assert response.status_code == 403
    assert "open the address that vibro explore printed" in text_of(response)
    kind = "text/plain" if path == "/" else "application/json"
    assert response.headers["content-type"].startswith(kind)


def test_the_token_counts_once_and_becomes_a_cookie() -> None:
    app = application()
    first, second = stranger(app), stranger(app)
    begun = first.get("/", params={"token": TOKEN})
    assert (begun.status_code, begun.headers["location"], begun.text) == (303, "/", "")
    cookie = re.fullmatch(
        r"vibro-8765=([\w-]{40,}); HttpOnly; SameSite=Strict; Path=/", begun.headers["set-cookie"]
    )
    assert cookie
    assert cookie[1] != TOKEN
    again = second.get("/", params={"token": TOKEN})
    assert again.status_code == 403
    assert "set-cookie" not in again.headers
    assert "start vibro explore again" in again.text
    assert second.get("/schema").status_code == 403
    assert first.get("/schema").status_code == 200
    # The first browser may go back to the first URL.
    back = first.get("/", params={"token": TOKEN})
    assert (back.status_code, back.headers["location"]) == (303, "/")
    assert "set-cookie" not in back.headers


def test_every_session_has_a_cookie_of_its_own() -> None:
    one, other = (guest(application()).cookies["vibro-8765"] for _ in range(2))
    assert one != other


@pytest.mark.parametrize("token", ["", "the-toke", "the-tokenn", "The-token", "ü", "%FF"])
def test_wrong_tokens_are_refused_and_use_nothing_up(token: str) -> None:
    client = stranger(application())
    assert client.get(f"/?token={token}").status_code in (400, 403)
    assert client.cookies == {}
    assert client.get("/", params={"token": TOKEN}).status_code == 303


def test_only_opening_the_page_uses_the_token_up() -> None:
    """What looks at links asks for the head, and other paths begin nothing."""
    client = stranger(application())
    assert client.head("/", params={"token": TOKEN}).status_code == 403
    assert client.get("/schema", params={"token": TOKEN}).status_code == 403
    assert client.get("/", params={"token": TOKEN}, headers={"Host": "evil.example"}).status_code == 403
    assert client.get("/", params={"token": TOKEN}, headers={"Origin": "null"}).status_code == 403
    assert client.get("/", params={"token": TOKEN}).status_code == 303


def test_only_the_cookie_itself_lets_in() -> None:
    app = application()
    value = guest(app).cookies["vibro-8765"]
    for cookies, status in (
        (f"vibro-8765={value}", 200),
        (f"a=b; c; =; vibro-8765=old; vibro-8765={value};;", 200),  # other programs set cookies too
        (f"vibro-8765={TOKEN}", 403),
        (f"vibro-8766={value}", 403),
        (f"vibro-8765={value}x", 403),
        (f"vibro-8765={value[:-1]}", 403),
        ("vibro-8765=", 403),
        ("vibro-8765=\xfc", 403),
        (value, 403),
    ):
        headers = {b"Cookie": cookies.encode("latin-1")}
        assert stranger(app).get("/schema", headers=headers).status_code == status, cookies


@pytest.mark.parametrize("method", ["POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "BREW"])
def test_nothing_but_reading_is_allowed(known: TestClient, method: str) -> None:
    for path in EVERYWHERE:
        response = known.request(method, path)
        assert (response.status_code, response.headers["allow"]) == (405, "GET, HEAD")


def test_heads_are_answered(known: TestClient) -> None:
    for path in ROUTES:
        assert known.head(path).status_code == 200


def test_queries_have_a_limit(known: TestClient) -> None:
    assert known.get("/point?a=" + (LONGEST_QUERY - 2) * "b").status_code == 200
    response = known.get("/point?a=" + (LONGEST_QUERY - 1) * "b")
    assert response.status_code == 400
    assert text_of(response) == "the query has 4097 characters: it must have at most 4096\n\n"


@pytest.mark.parametrize(
    ("query", "said"),
    [
        ("a=1&a=1", "the query gives a twice\n"),
        ("a=1&%61=2", "the query gives a twice\n"),
        ("a&a", "the query gives a twice\n"),
        ("a=%FF", "the query is not UTF-8\n"),
    ],
)
def test_queries_that_cannot_be_read(known: TestClient, query: str, said: str) -> None:
    response = known.get(f"/point?{query}")
    assert response.status_code == 400
    assert text_of(response).startswith(said)


def test_queries_are_read(known: TestClient) -> None:
    response = known.get("/point?a=1%C2%B5m&b=&c&d=1+2%2B3")
    assert response.json() == {"state": {"a": "1µm", "b": "", "c": "", "d": "1 2+3"}}


def test_every_response_has_the_headers() -> None:
    app = application(FailingAnswers(ZeroDivisionError("secret")))
    client = stranger(app)
    responses = [client.get("/"), client.get("/", params={"token": TOKEN})]
    responses += [client.get(path) for path in (*EVERYWHERE, "/map?a=1&a=1", "/map?wrong=1")]
    responses += [client.post("/"), client.get("/", headers={"Host": "evil.example"})]
    assert {response.status_code for response in responses} == {200, 303, 400, 403, 404, 405, 500}
    for response in responses:
        assert {name: response.headers.get_list(name) for name in HEADERS} == {
            name: [value] for name, value in HEADERS.items()
        }


def test_unexpected_errors_are_reported_but_not_to_the_client() -> None:
    error, reported = ZeroDivisionError("secret"), list[Exception]()
    response = guest(application(FailingAnswers(error), reported)).get("/point")
    assert response.status_code == 500
    assert (
        text_of(response) == "unexpected ZeroDivisionError; please report it with the output of --debug\n\n"
    )
    assert reported == [error]


@pytest.mark.parametrize(
    ("error", "content"),
    [
        (
            InputError("a", "b", hint="c"),
            {"problems": [{"field": "", "text": "a"}, {"field": "", "text": "b"}], "hint": "c"},
        ),
        (
            InputError("a", "b", fields=["x", ""]),
            {"problems": [{"field": "x", "text": "a"}, {"field": "", "text": "b"}], "hint": ""},
        ),
        (VibroError("a"), {"problems": [{"field": "", "text": "a"}], "hint": ""}),
    ],
)
def test_wrong_input_is_told_as_json(error: VibroError, content: object) -> None:
    reported = list[Exception]()
    response = guest(application(FailingAnswers(error), reported)).get("/point")
    assert (response.status_code, response.json(), reported) == (400, content, [])
