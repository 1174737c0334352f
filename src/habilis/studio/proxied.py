"""The address of a studio behind a proxy: a path of its own, on other origins."""

import ipaddress
import re
from collections.abc import Iterable
from urllib.parse import unquote, urlsplit

_PORT = "{port}"
_DEFAULT_PORTS = {"http": 80, "https": 443}
# Segments of a URL's path, encoded where they have to be; none is empty, "." or "..".
_PATH = re.compile(r"/(?:(?!\.{1,2}/)(?:[\w.~!$&'()*+,;=:@-]|%[0-9A-Fa-f]{2})+/)*", re.ASCII)


def base_path(given: str, port: int) -> str:
    """The path of the page, with a slash at both ends.

    Args:
        given: as the proxy has it; "{port}" stands for the studio's port.
        port: that.

    Raises:
        ValueError: it is no path.

    Example:
        >>> base_path("/user/x/proxy/{port}", 8765)
        '/user/x/proxy/8765/'
    """
    path = str(given).replace(_PORT, str(port))
    path = path if path.endswith("/") else f"{path}/"
    if (
        not isinstance(given, str)
        or not _PATH.fullmatch(path)
        or set(unquote(path)) & set("\r\n\\?#")
    ):
        raise ValueError(
            f"base path is {given!r}; give the path at which the proxy serves the studio, such as "
            "/user/x/proxy/{port}/"
        )
    return path


def origins(given: Iterable[str]) -> tuple[str, ...]:
    """Origins as browsers send them: in lower case, without a default port.

    Raises:
        ValueError: one is no origin; naming it.

    Example:
        >>> origins(["https://Hub.example:443/", "http://localhost:8888"])
        ('https://hub.example', 'http://localhost:8888')
    """
    return tuple(dict.fromkeys(map(_origin, given)))


def hosts(origin: str) -> tuple[str, ...]:
    """The `Host` headers of requests to an origin."""
    parts = urlsplit(origin)
    return (parts.netloc,) if parts.port else (parts.netloc, f"{parts.netloc}:{_port(origin)}")


def websocket(origin: str) -> str:
    """The origin of its WebSockets."""
    return origin.replace("http", "ws", 1)


def _port(origin: str) -> int:
    return _DEFAULT_PORTS[urlsplit(origin).scheme]


def _origin(given: str) -> str:
    fault = ValueError(
        f"trusted origin is {given!r}; give scheme, host and port alone, such as "
        "https://hub.example.org"
    )
    try:
        parts = urlsplit(given if isinstance(given, str) else "")
        port = parts.port
        name = parts.netloc.removesuffix(f":{port}").lower()
        if name.startswith("["):
            name = f"[{ipaddress.IPv6Address(name[1:-1]).compressed}]"
    except ValueError:
        raise fault from None
    whole = f"{parts.scheme}://{parts.netloc}"
    if (
        parts.scheme not in _DEFAULT_PORTS
        or given.lower().removesuffix("/") != whole.lower()
        or not re.fullmatch(r"[a-z0-9.-]+|\[[0-9a-f:.]+\]", name)
    ):
        raise fault
    origin = f"{parts.scheme}://{name}"
    return origin if port in (None, _port(origin)) else f"{origin}:{port}"
