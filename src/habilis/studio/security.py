"""Access control: only pages served by the studio itself may use it.

Any page open in a browser can send requests to loopback addresses on the user's behalf. Two
headers that pages cannot choose reveal it: `Origin`, the page that sent the request, and `Host`,
the name by which it found the server (an attacker's name that resolves to our address is DNS
rebinding).
"""

import hmac
import ipaddress
import secrets
import socket
from collections.abc import Iterable
from dataclasses import dataclass
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

TOKEN = "token"
_LOOPBACK = ("localhost", "127.0.0.1", "::1")
_REFUSED = 1008  # a WebSocket's close code: policy violation


@dataclass(frozen=True)
class Access:
    """The access rules of a server.

    Attributes:
        names: the host names that requests may use, in lower case.
        any_address: whether they may also use any IP address (which cannot be rebound).
        port: the only port.
        token: the token that requests must have; `None` if only this machine can reach the server.
    """

    names: frozenset[str]
    any_address: bool
    port: int
    token: str | None

    @classmethod
    def of(cls, host: str, port: int) -> "Access":
        """The rules of a server on an address: with a token, unless it is a loopback address."""
        if is_loopback(host):
            return cls(frozenset({*_LOOPBACK, host.lower()}), False, port, None)
        names = {*_LOOPBACK, host.lower(), socket.gethostname().lower(), socket.getfqdn().lower()}
        return cls(frozenset(names), _is_wildcard(host), port, secrets.token_urlsafe(24))

    def address(self, host: str) -> str:
        """The address to open in a browser, including the token."""
        name = socket.gethostname() if _is_wildcard(host) else host
        name = f"[{name}]" if ":" in name else name
        token = "" if self.token is None else f"?{TOKEN}={self.token}"
        return f"http://{name}:{self.port}/{token}"

    def knows(self, host: str | None) -> bool:
        """Whether a `Host` header names this server."""
        try:
            parts = urlsplit(f"//{host}")
            name, port = parts.hostname, parts.port or 80
        except ValueError:
            return False
        if (
            host is None
            or name is None
            or f"//{host}" != parts.geturl()
            or set(host) & set("/?@ \t")
        ):
            return False
        return port == self.port and (
            name in self.names or (self.any_address and _is_address(name))
        )

    def refusal(self, headers: Headers, query: str, open_to_all: bool) -> str | None:
        """The reason to refuse a request, or `None`.

        Args:
            headers: the request's headers.
            query: the query string of its address.
            open_to_all: whether it needs no token.
        """
        if len(headers.getlist("host")) != 1 or not self.knows(headers["host"]):
            return "this is not the studio's address; open the one that it printed"
        for origin in headers.getlist("origin"):
            scheme, _, host = origin.partition("://")
            if scheme != "http" or host != headers["host"]:
                return "a page of another origin may not use the studio; open the studio's own page"
        if self.token is None or open_to_all:
            return None
        given = parse_qs(query, max_num_fields=20).get(TOKEN, [""])
        if len(given) != 1 or not hmac.compare_digest(given[0].encode(), self.token.encode()):
            return "the address has no valid token; open the one that the studio printed"
        return None


class Guard:
    """Middleware that passes only requests allowed by `access`, and sets security headers."""

    def __init__(self, app: ASGIApp, access: Access, open_paths: Iterable[str] = ()):
        self.app, self.access, self.open_paths = app, access, tuple(open_paths)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        open_to_all = scope["type"] == "http" and scope["path"].startswith(self.open_paths)
        query = scope["query_string"].decode("latin-1")
        try:
            why = self.access.refusal(headers, query, open_to_all)
        except ValueError as error:
            why = str(error)
        if why is None and scope["type"] == "http":
            await self.app(scope, receive, _careful(send, headers["host"]))
        elif why is None:
            await self.app(scope, receive, send)
        elif scope["type"] == "http":
            await PlainTextResponse(f"{why}\n", 403)(scope, receive, send)
        else:
            await receive()
            await send({"type": "websocket.close", "code": _REFUSED, "reason": why})


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach an address."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"


def _is_wildcard(host: str) -> bool:
    return _is_address(host) and ipaddress.ip_address(host).is_unspecified


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True


def _careful(send: Send, host: str) -> Send:
    """Adds the headers that restrict the page to its own host."""
    policy = (
        "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
        f"connect-src 'self' ws://{host}; object-src 'none'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    )
    added = {
        "content-security-policy": policy,
        "x-content-type-options": "nosniff",
        "referrer-policy": "no-referrer",  # the address may contain the token
        "cross-origin-resource-policy": "same-origin",
        "cross-origin-opener-policy": "same-origin",
    }
    raw = [(name.encode(), value.encode()) for name, value in added.items()]

    async def answer(message: Message) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [*message.get("headers", []), *raw]
        await send(message)

    return answer
