"""Who may talk to the page: token, origin, host, size; threat by threat as docs/open.md lists them."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from er_model_lab.page.guard import HEADERS, OVERHEAD, Guard, Pass

HOST = "127.0.0.1:8123"
PASS = Pass(frozenset({HOST}), "secret", 1000)
COOKIE = {"host": HOST, "cookie": "er_lab_8123=secret"}


@pytest.mark.parametrize(
    ("headers", "query", "status"),
    [
        (COOKIE, "", 200),
        ({**COOKIE, "origin": f"http://{HOST}"}, "", 200),
        ({"host": HOST}, "token=secret", 303),
        ({"host": HOST}, "", 403),
        ({"host": HOST}, "token=guess", 403),
        ({"host": HOST, "cookie": "er_lab_8123=guess"}, "", 403),
        ({"host": HOST, "cookie": "er_lab_9=secret; \xff=\xfe"}, "", 403),
        ({**COOKIE, "origin": "http://evil.example"}, "", 403),
        ({**COOKIE, "origin": "null"}, "", 403),
        ({**COOKIE, "origin": f"https://{HOST}"}, "", 403),
        ({**COOKIE, "origin": "http://127.0.0.1:9"}, "", 403),
        ({**COOKIE, "origin": f"http://{HOST}.evil.example"}, "", 403),
        ({**COOKIE, "host": "evil.example:8123"}, "", 421),
        ({"cookie": COOKIE["cookie"]}, "", 421),
        ({**COOKIE, "content-length": str(2 << 30)}, "", 413),
        ({**COOKIE, "content-length": str(1000 + OVERHEAD)}, "", 200),
        ({**COOKIE, "content-length": "-1"}, "", 200),
    ],
)
def test_only_holders_of_the_token_from_the_page_itself_pass(
    headers: dict[str, str], query: str, status: int
) -> None:
    assert PASS.judged(headers, query)[0] == status


def answered(scope: dict[str, Any], bodies: list[bytes]) -> tuple[list[Any], list[bytes]]:
    """What is sent for a request, and what the application behind the guard received."""
    sent, got = list[Any](), list[bytes]()
    messages = [{"type": "http.request", "body": b, "more_body": True} for b in bodies]

    async def app(scope: Any, receive: Any, send: Any) -> None:
        while (message := await receive())["type"] == "http.request":
            got.append(message["body"])
            if not messages:
                break
        await send({"type": "http.response.start", "status": 200, "headers": []})

    async def receive() -> Any:
        return messages.pop(0) if messages else {"type": "websocket.connect"}

    async def send(message: Any) -> None:
        sent.append(message)

    asyncio.run(Guard(app, PASS)(scope, receive, send))
    return sent, got


def scope_of(headers: dict[str, str], kind: str = "http", query: str = "") -> dict[str, Any]:
    raw = [(k.encode(), v.encode("latin-1")) for k, v in headers.items()]
    return {"type": kind, "headers": raw, "query_string": query.encode(), "path": "/"}


def test_an_answer_lets_nothing_be_fetched_from_elsewhere() -> None:
    sent, got = answered(scope_of(COOKIE), [b"x"])
    assert got == [b"x"]
    assert dict(sent[0]["headers"]).keys() >= {k.encode() for k in HEADERS}
    assert "default-src 'self'" in HEADERS["content-security-policy"]
    assert "http:" not in HEADERS["content-security-policy"]


def test_the_token_is_exchanged_for_a_cookie_that_no_script_and_no_other_site_has() -> None:
    sent, got = answered(scope_of({"host": HOST}, query="token=secret"), [])
    headers = dict(sent[0]["headers"])
    assert (sent[0]["status"], headers[b"location"], got) == (303, b"/", [])
    assert headers[b"set-cookie"].endswith(b"HttpOnly; SameSite=Strict")


def test_a_foreign_socket_is_closed_before_it_is_open() -> None:
    sent, got = answered(scope_of({**COOKIE, "origin": "http://evil.example"}, "websocket"), [])
    assert [m["type"] for m in sent] == ["websocket.close"]
    assert got == []


def test_an_upload_without_a_length_is_cut_off() -> None:
    _, got = answered(scope_of(COOKIE), [b"x" * 40_000] * 4)
    assert sum(map(len, got)) <= 1000 + OVERHEAD
