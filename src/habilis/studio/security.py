"""Access control: only pages served by the studio itself may use it.

Any page open in a browser can send requests to loopback addresses on the user's behalf. Two
headers that pages cannot choose reveal it: `Origin`, the page that sent the request, and `Host`,
the name by which it found the server (an attacker's name that resolves to our address is DNS
rebinding).

Behind a proxy, both may be the proxy's: only the origins that the user trusts are accepted. Others
can reach the proxy, so that a studio behind one always has a token.
"""

import hmac
import ipaddress
import secrets
import socket
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from urllib.parse import parse_qs, quote, unquote, urlsplit

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from habilis.studio.proxied import base_path, hosts, origins, websocket

TOKEN = "token"
EMBEDDED = "embedded"
"""The field of the address of a page that is in a frame."""
# Pages that may frame an embedded studio besides trusted origins: Jupyter on this machine, and
# VS Code. Nobody else knows its token, without which there is nothing to frame.
_NOTEBOOKS = (
    "'self' http://localhost:* http://127.0.0.1:* https://localhost:* https://127.0.0.1:* "
    "vscode-webview: vscode-file:"
)
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
        base: the path of the page, with a slash at both ends; a proxy may remove it.
        origins: those of proxies that serve the studio.
        framed: whether the page may be in a frame of a notebook, if it is asked for as such.
    """

    names: frozenset[str]
    any_address: bool
    port: int
    token: str | None
    base: str = "/"
    origins: tuple[str, ...] = ()
    framed: bool = False

    @classmethod
    def of(
        cls,
        host: str,
        port: int,
        base: str = "/",
        trusted: Iterable[str] = (),
        *,
        framed: bool = False,
    ) -> "Access":
        """The rules of a server on an address.

        It has a token, unless only this machine can reach it.

        Args:
            host, port: the address.
            base: the path at which a proxy serves it, as in `base_path`.
            trusted: the origins of proxies.
            framed: as above.

        Raises:
            ValueError: the path or an origin is none.
        """
        known = origins(trusted)
        alone = is_loopback(host) and not known and not framed
        names = {*_LOOPBACK, host.lower()}
        if not is_loopback(host):
            names |= {socket.gethostname().lower(), socket.getfqdn().lower()}
        return cls(
            names=frozenset(names),
            any_address=not is_loopback(host) and _is_wildcard(host),
            port=port,
            token=None if alone else secrets.token_urlsafe(24),
            base=base_path(base, port),
            origins=known,
            framed=framed,
        )

    def address(self, host: str) -> str:
        """The address to open in a browser, including the token: that of the proxy, if any."""
        name = socket.gethostname() if _is_wildcard(host) else host
        name = f"[{name}]" if ":" in name else name
        origin = self.origins[0] if self.origins else f"http://{name}:{self.port}"
        token = "" if self.token is None else f"?{TOKEN}={self.token}"
        return f"{origin}{self.base}{token}"

    def inside(self, path: str) -> str:
        """A path without the base, which a proxy may have removed already."""
        base = unquote(self.base)
        return path[len(base) - 1 :] if path.startswith(base) else path

    def knows(self, host: str | None) -> bool:
        """Whether a `Host` header names this server, or a proxy that serves it."""
        return self._is_own(host) or (host or "").lower() in self._proxies

    @cached_property
    def _proxies(self) -> frozenset[str]:
        return frozenset(host for origin in self.origins for host in hosts(origin))

    def _is_own(self, host: str | None) -> bool:
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
            own = origin == f"http://{headers['host']}" and self._is_own(headers["host"])
            if not own and origin not in self.origins:
                return "a page of another origin may not use the studio; open the studio's own page"
        if self.token is None or open_to_all:
            return None
        given = _fields(query).get(TOKEN, [""])
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
        path = self.access.inside(scope["path"])
        open_to_all = scope["type"] == "http" and path.startswith(self.open_paths)
        query = scope["query_string"].decode("latin-1")
        why = self.access.refusal(headers, query, open_to_all)
        if why is None and scope["type"] == "http":
            careful = _careful(send, self.access, headers["host"], query)
            if f"{path}/" == unquote(self.access.base) != "/":  # relative addresses need the slash
                to = f"{self.access.base}?{query}" if query else self.access.base
                await RedirectResponse(to)(scope, receive, careful)
                return
            await self.app(_at(scope, path), receive, careful)
        elif why is None:
            await self.app(_at(scope, path), receive, send)
        elif scope["type"] == "http":
            await PlainTextResponse(f"{why}\n", 403)(scope, receive, send)
        else:
            await receive()
            await send({"type": "websocket.close", "code": _REFUSED, "reason": why})


def _at(scope: Scope, path: str) -> Scope:
    return {**scope, "path": path, "raw_path": quote(path).encode()}


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


def _fields(query: str) -> dict[str, list[str]]:
    """The fields of an address; none of one with too many, which nobody asks for its pages."""
    try:
        return parse_qs(query, max_num_fields=20)
    except ValueError:
        return {}


def _careful(send: Send, access: Access, host: str, query: str) -> Send:
    """Adds the headers that restrict the page to its own host, and what may frame it."""
    sockets = " ".join([f"ws://{host}", *map(websocket, access.origins)])
    framed = access.framed and _fields(query).get(EMBEDDED) == ["1"]
    frames = " ".join([_NOTEBOOKS, *access.origins]) if framed else "'none'"
    policy = (
        "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
        f"connect-src 'self' {sockets}; object-src 'none'; base-uri 'none'; form-action 'none'; "
        f"frame-ancestors {frames}"
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
