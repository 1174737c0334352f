"""The studio behind an HTTPS proxy and at a path of its own, as a hub serves it: nginx."""

import http.client
import shutil
import socket
import ssl
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

import pytest
import trustme
from playwright.sync_api import Browser, Page, expect, sync_playwright
from studio_page import (
    CHROMIUM,
    OPTIONS,
    STUCK,
    WORLD,
    drag,
    keep_picture,
    served,
    settled,
    shown_bits,
    true_bits,
)
from websockets.exceptions import InvalidStatus

from habilis.worlds.world import load_world
from studio import page as connected

NGINX = shutil.which("nginx")
pytestmark = pytest.mark.skipif(
    NGINX is None or not CHROMIUM.exists(), reason="apt-get install nginx-light chromium"
)

YARD = load_world("yard")
BASE = "/user/x%40y/proxy/{port}/"

# One studio from whose path the proxy removes the prefix, with the browser's Host, as
# jupyter-server-proxy does; one that sees the whole path (/proxy/absolute/ there), and the proxy's
# own name for it.
SERVER = """
daemon off; master_process off; pid {folder}/pid; error_log {folder}/errors;
events {{ worker_connections 64; }}
http {{
  access_log off;
  client_body_temp_path {folder}/a; proxy_temp_path {folder}/b; fastcgi_temp_path {folder}/c;
  uwsgi_temp_path {folder}/d; scgi_temp_path {folder}/e;
  server {{
    listen 127.0.0.1:{port} ssl;
    ssl_certificate {folder}/server.pem; ssl_certificate_key {folder}/server.key;
    proxy_http_version 1.1;
    proxy_set_header Upgrade $http_upgrade;
    proxy_set_header Connection "upgrade";
    location = / {{ default_type text/html; return 200 "<title>another page</title>"; }}
    location /user/x@y/proxy/{removed}/ {{
      proxy_set_header Upgrade $http_upgrade;
      proxy_set_header Connection "upgrade";
      proxy_set_header Host $http_host;
      proxy_pass http://127.0.0.1:{removed}/;
    }}
    location /user/x@y/proxy/{kept} {{ proxy_pass http://127.0.0.1:{kept}; }}
  }}
}}
"""


@dataclass(frozen=True)
class Proxy:
    """What is behind it: the addresses that two studios printed."""

    port: int
    removed: str
    kept: str


def port_of(address: str) -> int:
    return int(urlsplit(address).path.split("/")[-2])


@contextmanager
def running(folder: Path, port: int) -> Iterator[None]:
    with subprocess.Popen([str(NGINX), "-p", str(folder), "-c", str(folder / "conf")]) as nginx:
        try:
            while nginx.poll() is None:
                with closing(socket.socket()) as there:
                    if there.connect_ex(("127.0.0.1", port)) == 0:
                        break
                time.sleep(0.02)
            assert nginx.poll() is None, (folder / "errors").read_text()
            yield
        finally:
            nginx.terminate()


@pytest.fixture(scope="module")
def proxy(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Proxy]:
    folder = tmp_path_factory.mktemp("nginx")
    certificate = trustme.CA().issue_cert("localhost", "127.0.0.1")
    certificate.private_key_pem.write_to_path(folder / "server.key")
    for number, blob in enumerate(certificate.cert_chain_pems):
        blob.write_to_path(folder / "server.pem", append=number > 0)
    with closing(socket.create_server(("127.0.0.1", 0))) as free:
        port = free.getsockname()[1]
    options = ("--base-path", BASE, "--trusted-origin", f"https://localhost:{port}")
    with ExitStack() as held:
        removed, kept = (held.enter_context(served(*options)) for _ in range(2))
        behind = {"removed": port_of(removed), "kept": port_of(kept)}
        (folder / "conf").write_text(SERVER.format(folder=folder, port=port, **behind))
        held.enter_context(running(folder, port))
        yield Proxy(port, removed, kept)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=OPTIONS)
        expect.set_options(timeout=STUCK)
        yield browser
        browser.close()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_page(ignore_https_errors=True, color_scheme="light")
    yield page
    page.close()


@pytest.mark.parametrize("kind", ["removed", "kept"])
def test_page_assets_and_socket_go_through_the_proxy(proxy: Proxy, page: Page, kind: str):
    address = getattr(proxy, kind)
    assert address.startswith(f"https://localhost:{proxy.port}/user/x%40y/proxy/")
    assert len(urlsplit(address).query) > 30
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda line: faults.append(line.text) if line.type == "error" else None)
    page.on("request", lambda request: asked.append(request.url))
    page.on("websocket", lambda socket: asked.append(socket.url))
    asked: list[str] = []
    page.goto(address)
    settled(page)
    assert shown_bits(page) == true_bits(YARD, 3)
    drag(page, WORLD, YARD.object, (5, 4))
    assert shown_bits(page) == true_bits(YARD.with_cells(object=(5, 4)), 3)
    base = address.partition("?")[0]
    assert f"{base.replace('https:', 'wss:')}ws?{urlsplit(address).query}" in asked
    outside = [
        url for url in asked if not url.replace("wss:", "https:").startswith((base, "data:"))
    ]
    assert outside == []
    assert faults == []
    keep_picture(page, f"proxied-{kind}")


def test_without_the_slash_at_its_end_the_address_leads_to_the_page(proxy: Proxy, page: Page):
    page.goto(proxy.kept.replace("/?", "?"))
    settled(page)
    assert page.url.startswith(proxy.kept)


def get(proxy: Proxy, path: str, **headers: str) -> int:
    trusting = ssl.create_default_context()
    trusting.check_hostname, trusting.verify_mode = False, ssl.CERT_NONE
    with closing(http.client.HTTPSConnection("localhost", proxy.port, context=trusting)) as there:
        there.request("GET", path, headers=headers)
        return there.getresponse().status


def test_through_the_proxy_token_name_and_origin_are_checked(proxy: Proxy):
    parts = urlsplit(proxy.removed)
    path = f"{parts.path}?{parts.query}"
    assert get(proxy, path) == 200
    assert get(proxy, parts.path) == 403
    assert get(proxy, f"{parts.path}?token=x") == 403
    assert get(proxy, path, Host=f"evil.example:{proxy.port}") == 403
    assert get(proxy, path, Origin=f"https://localhost:{proxy.port}") == 200
    for origin in (f"http://localhost:{proxy.port}", "https://evil.example", "null"):
        assert get(proxy, path, Origin=origin) == 403
    assert get(proxy, f"{parts.path}assets/studio.js") == 200
    assert get(proxy, f"{parts.path}../{port_of(proxy.kept)}/") == 403  # of another: another token


def test_past_the_proxy_the_token_is_asked_for_too(proxy: Proxy):
    port = port_of(proxy.kept)
    with closing(http.client.HTTPConnection("127.0.0.1", port)) as there:
        there.request("GET", "/")
        assert there.getresponse().status == 403
    with pytest.raises(InvalidStatus), connected(f"http://127.0.0.1:{port}/"):
        pass
    with connected(f"http://127.0.0.1:{port}/?{urlsplit(proxy.kept).query}") as there:
        assert there.hello["version"]


ASK = """([url, framed]) => Promise.all([
  new Promise((done) => {
    const socket = new WebSocket(url.replace("https:", "wss:").replace("/?", "/ws?"));
    socket.onopen = () => done("open");
    socket.onerror = () => done("refused");
  }),
  fetch(url).then(() => "read", () => "refused"),
  new Promise((done) => {
    const frame = document.createElement("iframe");
    frame.src = framed;
    frame.onload = () => done("loaded");
    document.body.append(frame);
  }),
])"""


@pytest.mark.parametrize("kind", ["removed", "kept"])
def test_a_page_of_another_origin_can_not_use_it_even_with_the_token(
    proxy: Proxy, page: Page, kind: str
):
    address = getattr(proxy, kind)
    page.goto(f"https://127.0.0.1:{proxy.port}/")
    embedded = f"{address}&embedded=1"
    assert page.evaluate(ASK, [address, embedded])[:2] == ["refused", "refused"]
    (frame,) = page.frames[1:]
    assert frame.url != embedded  # the browser shows an error in its place
    assert frame.locator("#app").count() == 0
