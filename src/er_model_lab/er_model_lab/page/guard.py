"""Who may talk to the page: holders of its token, from the page itself, to this address, with bounded uploads.

A page of another site can make a browser send requests here. So every request must name this host (a foreign name
that resolves here is refused), any origin it states must be this page's, and all but the first must carry the cookie
that the token was exchanged for. What is served may fetch from here alone.
"""

from __future__ import annotations

import hmac
from collections.abc import Awaitable, Callable, Mapping, MutableMapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Message, Receive, Send], Awaitable[None]]

HEADERS = {
    "content-security-policy": "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; worker-src 'self' blob:; "
    "connect-src 'self'; frame-ancestors 'none'; form-action 'self'; base-uri 'self'",
    "x-content-type-options": "nosniff", "referrer-policy": "no-referrer", "x-frame-options": "DENY",
    "cross-origin-resource-policy": "same-origin", "cross-origin-opener-policy": "same-origin",
}  # fmt: skip
"""Sent with every answer: nothing is fetched from elsewhere, shown within another page, or told to one."""
OVERHEAD = 1 << 16
"""Bytes of an upload beside the file."""


@dataclass(frozen=True)
class Pass:
    """What lets a request through: the hosts that it may name, and the secret token; largest: bytes of a body."""

    hosts: frozenset[str]
    token: str
    largest: int

    @property
    def cookie(self) -> str:
        """Name of the cookie: ports share cookies, so each page has its own."""
        port = next(iter(self.hosts)).rpartition(":")[2]
        return f"er_lab_{port}"

    def judged(self, headers: Mapping[str, str], query: str) -> tuple[int, str]:
        """Status and reason of a request: 200 lets it through, 303 gives the cookie for the token."""
        if headers.get("host", "") not in self.hosts:
            return 421, "another host"
        origin = headers.get("origin")
        if origin is not None and origin not in {f"http://{host}" for host in self.hosts}:
            return 403, "another origin"
        if int(_number(headers.get("content-length"))) > self.largest + OVERHEAD:
            return 413, f"more than {self.largest} bytes"
        if self._matches(self._sent(headers)):
            return 200, ""
        if self._matches(parse_qs(query).get("token", [""])[0]):
            return 303, "token"
        return 403, "no token: open the address that the command printed"

    def _sent(self, headers: Mapping[str, str]) -> str:
        try:
            found = SimpleCookie(headers.get("cookie", "")).get(self.cookie)
        except CookieError:
            return ""
        return found.value if found else ""

    def _matches(self, said: str) -> bool:
        return hmac.compare_digest(said.encode(), self.token.encode())


def _number(text: str | None) -> int:
    return int(text) if text and text.isdecimal() else 0


class Guard:
    """The application behind the pass."""

    def __init__(self, app: App, wanted: Pass) -> None:
        self.app, self.wanted = app, wanted

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Answer a request of ASGI, or hand it on."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = {k.decode("latin-1").lower(): v.decode("latin-1") for k, v in scope["headers"]}
        status, why = self.wanted.judged(headers, scope.get("query_string", b"").decode("latin-1"))
        if status == 200:
            await self.app(scope, self._bounded(receive), _closed(send))
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": why})
        else:
            await self._answer(status, why, scope, send)

    async def _answer(self, status: int, why: str, scope: Message, send: Send) -> None:
        more = [(b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close")]
        if status == 303:
            cookie = f"{self.wanted.cookie}={self.wanted.token}; Path=/; HttpOnly; SameSite=Strict"
            more += [(b"location", scope["path"].encode()), (b"set-cookie", cookie.encode())]
        await _closed(send)({"type": "http.response.start", "status": status, "headers": more})
        await send({"type": "http.response.body", "body": why.encode()})

    def _bounded(self, receive: Receive) -> Receive:
        """What is received, up to the largest body: one without a length is counted."""
        seen = 0

        async def counted() -> Message:
            nonlocal seen
            message = await receive()
            if message["type"] == "http.request":
                seen += len(message.get("body", b""))
                if seen > self.wanted.largest + OVERHEAD:
                    return {"type": "http.disconnect"}
            return message

        return counted


def _closed(send: Send) -> Send:
    """What is sent, with `HEADERS`."""

    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            own = [(k.encode(), v.encode()) for k, v in HEADERS.items()]
            message = {**message, "headers": [*message.get("headers", ()), *own]}
        await send(message)

    return sent
