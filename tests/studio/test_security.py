"""Only pages that the studio served itself may use it."""

import asyncio
from typing import Any
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import InvalidStatus

from habilis.studio.proxied import base_path, origins
from habilis.studio.security import Access, Guard, is_loopback
from studio import get, page, studio


@pytest.fixture(scope="module")
def open_address():
    with studio("--host", "0.0.0.0") as address:
        yield address


def test_the_page_may_do_nothing_with_other_hosts(address):
    status, _, headers = get(address)
    assert status == 200
    policy = headers["content-security-policy"]
    assert "default-src 'self'" in policy
    assert "frame-ancestors 'none'" in policy
    assert headers["referrer-policy"] == "no-referrer"


@pytest.mark.parametrize("name", ["localhost", "127.0.0.1", "[::1]"])
def test_its_own_names_are_known(address, name):
    assert get(address, host=f"{name}:{urlsplit(address).port}")[0] == 200


@pytest.mark.parametrize(
    "host",
    [
        *(
            "evil.example:{}",
            "127.0.0.1",
            "127.0.0.1:1",
            "localhost.evil.example:{}",
            "x@localhost:{}",
        ),
        *("127.0.0.2:{}", "localhost:{}/x", "localhost:{} ", ":{}", "[::1:{}", "localhost:x"),
    ],
)
def test_a_name_that_leads_here_but_is_not_ours_is_refused(address, host):
    port = urlsplit(address).port
    access = Access.of("127.0.0.1", port)
    assert not access.knows(host.format(port))
    if not host.endswith(" "):  # which is no part of a header
        assert get(address, host=host.format(port))[0] in (400, 403)


ORIGINS = [
    "http://evil.example",
    "null",
    "https://127.0.0.1:{}",
    "http://127.0.0.1:1",
    "file://",
    "",
]


@pytest.mark.parametrize("origin", ORIGINS)
def test_a_foreign_page_can_neither_connect_nor_ask(address, origin):
    port = urlsplit(address).port
    with (
        pytest.raises(InvalidStatus),
        page(address, additional_headers={"Origin": origin.format(port)}),
    ):
        pass
    assert get(address, Origin=origin.format(port))[0] == 403


def test_its_own_page_can_connect(address):
    with page(address, additional_headers={"Origin": address.rstrip("/")}) as there:
        assert there.hello["version"]


def test_beyond_loopback_page_and_connection_need_the_token(open_address):
    parts = urlsplit(open_address)
    local = f"http://127.0.0.1:{parts.port}/"
    assert len(parts.query) > 30
    assert get(local, f"/?{parts.query}")[0] == 200
    for query in ("", "token=", "token=x", f"{parts.query}x", f"{parts.query}&{parts.query}"):
        status, text, _ = get(local, f"/?{query}")
        assert status == 403
        assert "token" in text
        with pytest.raises(InvalidStatus), page(f"{local}?{query}"):
            pass
    with page(f"{local}?{parts.query}") as there:
        assert there.hello["version"]


def test_beyond_loopback_foreign_names_and_pages_are_refused_too(open_address):
    parts = urlsplit(open_address)
    assert get(open_address, f"/?{parts.query}", host=f"evil.example:{parts.port}")[0] == 403
    assert get(open_address, f"/?{parts.query}", host=f"192.0.2.7:{parts.port}")[0] == 200
    assert get(open_address, f"/?{parts.query}", Origin="http://evil.example")[0] == 403


def test_each_start_has_another_token():
    assert Access.of("0.0.0.0", 1).token != Access.of("0.0.0.0", 1).token
    assert Access.of("127.0.0.1", 1).token is None


@pytest.mark.parametrize("host", ["127.0.0.1", "127.8.8.8", "::1", "localhost", "LOCALHOST"])
def test_loopback_is_known(host):
    assert is_loopback(host)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.1", "example.org", "127.0.0.1.example"])
def test_what_others_can_reach_is_not_loopback(host):
    assert not is_loopback(host)


def test_paths_do_not_lead_out_of_the_page(address):
    for path in ("/assets/../server.py", "/assets/%2e%2e/server.py", "//etc/passwd", "/server.py"):
        assert get(address, path)[0] == 404


HUB = "https://hub.example"


@pytest.fixture(scope="module")
def behind():
    with studio("--base-path", "/user/x/{port}", "--trusted-origin", f"{HUB}:443/") as address:
        yield address


def test_behind_a_proxy_the_address_is_the_proxys_and_has_a_token(behind):
    parts = urlsplit(behind)
    assert behind.startswith(f"{HUB}/user/x/")
    assert parts.path == f"/user/x/{parts.path.split('/')[-2]}/"
    assert len(parts.query) > 30


def test_a_proxy_may_remove_the_path_and_replace_the_name(behind):
    parts = urlsplit(behind)
    port = parts.path.split("/")[-2]
    local = f"http://127.0.0.1:{port}/"
    page_of = f"?{parts.query}"
    for path in ("/", parts.path):
        for host in (None, "hub.example", "hub.example:443", "Hub.Example"):
            for origin in ({}, {"Origin": HUB}):
                assert get(local, path + page_of, host, **origin)[0] == 200
            assert get(local, path, host)[0] == 403
            for origin in ("http://hub.example", "https://evil.example", f"{HUB}:8443"):
                assert get(local, path + page_of, host, Origin=origin)[0] == 403
        for host in ("evil.example", "hub.example:8443", "hub.example.evil.example", "127.0.0.1"):
            assert get(local, path + page_of, host)[0] == 403
        assert get(local, f"{path}assets/studio.css")[0] == 200
    own = local.rstrip("/")
    assert get(local, f"/{page_of}", Origin=own)[0] == 200
    assert get(local, f"/{page_of}", "hub.example", Origin="http://hub.example")[0] == 403
    status, _, headers = get(local, parts.path.rstrip("/") + page_of)
    assert (status, headers["location"]) == (307, parts.path + page_of)
    assert get(local, parts.path.rstrip("/"))[0] == 403
    policy = get(local, f"/{page_of}")[2]["content-security-policy"]
    assert "wss://hub.example" in policy
    policy = get(local, f"/{page_of}&embedded=1")[2]["content-security-policy"]
    assert "frame-ancestors 'none'" in policy


@pytest.mark.parametrize(
    "path", ["x", "//evil.example/", "/a/../b/", "/a b/", "/a?x=1", "/a#b", "/%zz/", "/./", "/a\n/"]
)
def test_what_is_no_path_is_refused(path):
    with pytest.raises(ValueError, match=r"base path is .*; give the path at which the proxy"):
        base_path(path, 1)


@pytest.mark.parametrize(
    "origin",
    [
        *("hub.example", "ftp://hub.example", "https://", "https://hub.example/user/", "*", "null"),
        *("https://x@hub.example", "https://hub.example:x", "https://*.example", "https://[::1"),
        *("https://hub.example?x", "https://hub.example;script-src *", "https://hub.example:443:1"),
    ],
)
def test_what_is_no_origin_is_refused(origin):
    with pytest.raises(ValueError, match=r"trusted origin is .*; give scheme, host and port alone"):
        origins([origin])


def test_origins_are_as_browsers_send_them():
    assert origins(["HTTP://Hub.Example:80", "http://hub.example/", "https://[::1]:8443"]) == (
        "http://hub.example",
        "https://[::1]:8443",
    )
    assert origins(["https://[2001:DB8:0:0::1]"]) == ("https://[2001:db8::1]",)
    assert base_path("/", 1) == "/"
    assert base_path("/user/x%40y/{port}", 8765) == "/user/x%40y/8765/"


def test_only_an_embedded_page_may_be_framed_and_by_notebooks_alone():
    access = Access.of("127.0.0.1", 1, framed=True)
    assert access.token is not None
    assert Access.of("127.0.0.1", 1).token is None
    assert Access.of("127.0.0.1", 1, trusted=[HUB]).token is not None


def test_an_address_with_many_fields_is_answered_without_a_fault():
    async def served(scope, receive, send):
        await send({"type": "http.response.start", "status": 200, "headers": []})

    async def status(path, access):
        sent = []

        async def send(message):
            sent.append(message)

        scope = {
            "type": "http",
            "path": path,
            "query_string": b"&".join([b"a=1"] * 30),
            "headers": [(b"host", b"127.0.0.1:1")],
        }
        receive: Any = send
        await Guard(served, access, ("/assets/",))(scope, receive, send)
        return sent[0]["status"]

    access = Access.of("127.0.0.1", 1, framed=True)
    assert asyncio.run(status("/assets/studio.js", access)) == 200
    assert asyncio.run(status("/", access)) == 403
