"""Whom the explorer answers, and what every response says to the browser."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import pytest
from helpers.cases import each
from helpers.explorers import (
    GUARDED,
    HOST,
    PORT,
    ROUTES,
    TOKEN,
    FakeAnswers,
    application,
    bearer,
    guest,
    stranger,
)
from starlette.websockets import WebSocketDisconnect

from vibro.errors import InputError, VibroError
from vibro.explore.guards import LONGEST_QUERY

if TYPE_CHECKING:
    from starlette.testclient import TestClient

EVERYWHERE = ("/", "/static/index.html", "/map?advance=1", "/nowhere", "/session")
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


@each("path", EVERYWHERE)
@each("host", [f"evil.example:{PORT}", "127.0.0.1", "127.0.0.1:8766", f"[::1]:{PORT}", "", "x"])
def test_foreign_hosts_are_refused_everywhere(known: TestClient, path: str, host: str) -> None:
    """Among them names of other sites that resolve to 127.0.0.1."""
    response = known.get(path, headers={"Host": host})
    assert response.status_code == 403
    assert "ssh -L 8765:127.0.0.1:8765 host" in text_of(response)


@each("host", [HOST, f"localhost:{PORT}", f"LocalHost:{PORT}"])
def test_own_hosts_are_answered(known: TestClient, host: str) -> None:
    assert known.get("/schema", headers={"Host": host}).status_code == 200


def test_two_hosts_are_refused(known: TestClient) -> None:
    headers = [("Host", HOST), ("Host", "evil.example")]
    assert known.get("/schema", headers=headers).status_code == 403


@each("path", EVERYWHERE)
@each("origin", ["http://evil.example", "null", "http://127.0.0.1:8766", f"https://{HOST}", ""])
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


@each("origin", ["http://evil.example", f"http://{HOST}"])
@each("path", ["/", "/map"])
def test_web_sockets_are_refused(known: TestClient, path: str, origin: str) -> None:
    """Before they are accepted, which is a 403."""
    with (
        pytest.raises(WebSocketDisconnect) as refused,
        known.websocket_connect(path, headers={"Origin": origin}),
    ):
        pytest.fail("accepted")
    assert refused.value.code == 1008


@each("path", [*GUARDED, "/session", "/nowhere"])
def test_without_the_secret_nothing_is_answered(path: str) -> None:
    response = stranger(application()).get(path)
    assert response.status_code == 403
    assert "open the address that vibro explore printed" in text_of(response)


@each("path", ["/", "/static/index.html", "/static/main.js"])
def test_everybody_gets_the_page_which_knows_nothing(known: TestClient, path: str) -> None:
    response = stranger(application()).get(path)
    assert response.status_code == 200
    assert response.content == known.get(path).content == stranger(application()).get(path).content


def test_the_token_counts_once_and_becomes_a_secret() -> None:
    app = application()
    first, second = stranger(app), stranger(app)
    begun = first.get("/session", headers=bearer(TOKEN))
    assert begun.status_code == 200
    assert re.fullmatch(r"[\w-]{40,}", begun.text)
    again = second.get("/session", headers=bearer(TOKEN))
    assert again.status_code == 403
    assert "start vibro explore again" in text_of(again)
    assert second.get("/schema", headers=bearer(TOKEN)).status_code == 403
    assert first.get("/schema", headers=bearer(begun.text)).status_code == 200


def test_no_cookie_is_set_and_none_lets_in() -> None:
    """A browser sends cookies to every port of this host, among them those of other users' servers."""
    app = application()
    client = stranger(app)
    begun = client.get("/session", headers=bearer(TOKEN))
    assert "set-cookie" not in begun.headers
    for cookie in (f"vibro-{PORT}={begun.text}", begun.text):
        assert client.get("/schema", headers={"Cookie": cookie}).status_code == 403


def test_every_session_has_a_secret_of_its_own() -> None:
    one, other = (guest(application()).headers["Authorization"] for _ in range(2))
    assert one != other


@each("token", ["", "the-toke", "the-tokenn", "The-token", "ü"])
def test_wrong_tokens_are_refused_and_use_nothing_up(token: str) -> None:
    client = stranger(application())
    header = {b"Authorization": f"Bearer {token}".encode()}
    assert client.get("/session", headers=header).status_code == 403
    assert client.get("/session", headers=bearer(TOKEN)).status_code == 200


def test_only_beginning_the_session_uses_the_token_up() -> None:
    """What looks at addresses asks for the head, and other paths and sites begin nothing."""
    client, shown = stranger(application()), bearer(TOKEN)
    assert client.head("/session", headers=shown).status_code == 403
    assert client.get("/schema", headers=shown).status_code == 403
    assert client.get("/", headers=shown).status_code == 200
    for foreign in ({"Host": "evil.example"}, {"Origin": "null"}, {"Sec-Fetch-Site": "same-site"}):
        assert client.get("/session", headers={**shown, **foreign}).status_code == 403
    assert client.get("/session", headers=shown).status_code == 200


def test_only_the_secret_itself_lets_in() -> None:
    app = application()
    shown = guest(app).headers["Authorization"]
    secret = shown.removeprefix("Bearer ")
    for given, status in (
        (shown, 200),
        (f"Bearer {TOKEN}", 403),
        (f"{shown}x", 403),
        (shown[:-1], 403),
        ("Bearer ", 403),
        ("Bearer \xfc", 403),
        (secret, 403),
    ):
        headers = {b"Authorization": given.encode("latin-1")}
        assert stranger(app).get("/schema", headers=headers).status_code == status, given
    assert stranger(app).get(f"/schema?session={secret}").status_code == 403


@each("method", ["POST", "PUT", "PATCH", "DELETE", "OPTIONS", "TRACE", "BREW"])
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


@each(
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
    responses = [stranger(app).get("/schema"), stranger(app).get("/session", headers=bearer(TOKEN))]
    client = stranger(app)
    client.headers.update(bearer(responses[1].text))
    responses += [client.get(path) for path in (*EVERYWHERE, "/point", "/map?a=1&a=1", "/map?wrong=1")]
    responses += [client.post("/"), client.get("/", headers={"Host": "evil.example"})]
    assert {response.status_code for response in responses} == {200, 400, 403, 404, 405, 500}
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


@each(
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
