"""The studio in a notebook's cell: a kernel, and in a browser the page that its output frames."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from html import unescape
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient
from playwright.sync_api import Browser, FrameLocator, Locator, Page, expect, sync_playwright
from studio_page import CHROMIUM, LANDSCAPE, OPTIONS, STUCK, WORLD, keep_picture

from habilis.worlds.world import load_world

pytestmark = pytest.mark.skipif(not CHROMIUM.exists(), reason="apt-get install chromium")

YARD = load_world("yard")
ELSEWHERE = "notebook.example"  # a name of this machine, in the browser alone


class Kernel:
    """Runs cells, as a notebook does."""

    def __init__(self, client: NotebookClient):
        self.client, self.cells = client, client.nb.cells

    def run(self, code: str) -> dict[str, Any]:
        """The result of a cell by its formats, and what it printed."""
        self.cells.append(nbformat.v4.new_code_cell(code))
        cell = self.client.execute_cell(self.cells[-1], len(self.cells) - 1)
        found: dict[str, Any] = {}
        for output in cell.outputs:
            found |= output.get("data", {"printed": output.get("text")})
        return found

    def value(self, expression: str) -> str:
        return self.run(f"print(repr({expression}))")["printed"].strip()


@pytest.fixture(scope="module")
def kernel() -> Iterator[Kernel]:
    client = NotebookClient(nbformat.v4.new_notebook(), timeout=120, kernel_name="python3")
    with client.setup_kernel():
        yield Kernel(client)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        names = f"--host-resolver-rules=MAP {ELSEWHERE} 127.0.0.1"
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=[*OPTIONS, names])
        expect.set_options(timeout=STUCK)
        yield browser
        browser.close()


class Notebook(BaseHTTPRequestHandler):
    """A page of another origin with the output of a cell in it."""

    def __init__(self, html: str, *arguments: Any):
        self.html = html
        super().__init__(*arguments)

    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("content-type", "text/html; charset=utf-8")
        self.end_headers()
        self.wfile.write(f"<!doctype html><body>{self.html}</body>".encode())

    def log_message(self, format: str, *_: Any) -> None:
        pass


@contextmanager
def opened(page: Page, html: str, name: str) -> Iterator[FrameLocator]:
    """The frame of an output, in a page under a name of this machine.

    It is served until the end: a browser asks for an icon whenever it likes, and a server that is
    gone by then resets the connection, which the page reports as an error.
    """
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Notebook, html)) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        page.goto(f"http://{name}:{server.server_port}/")
        yield page.frame_locator("iframe")
        page.close()
        server.shutdown()


def middle(place: Locator) -> tuple[float, float]:
    box = place.bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def waited(page: Page, kernel: Kernel, expression: str, value: str) -> None:
    """Until the kernel has a value."""
    for _ in range(100):
        if kernel.value(expression) == value:
            return
        page.wait_for_timeout(50)
    assert kernel.value(expression) == value


def test_edits_come_back_and_what_the_notebook_sets_is_shown(kernel: Kernel, browser: Browser):
    shown = kernel.run('import habilis as hb\nstudio = hb.open_studio("yard")\nstudio')
    html = shown["text/html"]
    page = browser.new_page(viewport={"width": 1000, "height": 700})
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda line: faults.append(line.text) if line.type == "error" else None)
    with opened(page, html, "localhost") as frame:
        expect(frame.locator(f"{LANDSCAPE}[data-pending=false]")).to_be_visible(timeout=STUCK)
        expect(frame.locator("#share")).to_be_hidden()
        assert page.locator("iframe").evaluate("frame => frame.clientHeight") == 640
        keep_picture(page, "notebook")

        page.mouse.move(*middle(frame.locator(f"{WORLD}-8-3")))
        assert YARD.object == (8, 3)
        page.mouse.down()
        page.mouse.move(*middle(frame.locator(f"{WORLD}-5-4")), steps=5)
        page.mouse.up()
        waited(page, kernel, "studio.world.object", "(5, 4)")
        assert kernel.value("studio.world") == repr(YARD.with_cells(object=(5, 4)))

        kernel.run('studio.world = hb.load_world("corridor", tool="broom")')
        corridor = load_world("corridor", tool="broom")
        row, column = corridor.goal
        expect(frame.locator(f"{WORLD}-{row}-{column}")).to_have_attribute(
            "aria-label", re.compile("bin")
        )
        waited(page, kernel, "studio.world", repr(corridor))

        page.keyboard.press("Control+z")  # what the notebook showed is one step back
        waited(page, kernel, "studio.world.object", "(5, 4)")
        assert faults == []
        kernel.run("studio.close()")
        expect(frame.locator(".status").first).to_contain_text("Connection lost")


def test_a_page_elsewhere_can_not_frame_it(kernel: Kernel, browser: Browser):
    html = kernel.run("studio = hb.open_studio()\nstudio")["text/html"]
    src = re.search(r'src="([^"]+)"', html)
    assert src is not None
    page = browser.new_page()
    with opened(page, html, ELSEWHERE):
        (framed,) = page.frames[1:]
        assert framed.url != unescape(src[1])
    kernel.run("studio.close()")


def test_a_world_is_a_picture_in_a_cell(kernel: Kernel):
    shown = kernel.run('import habilis as hb\nhb.load_world("yard")')
    assert shown["image/svg+xml"].startswith("<svg ")
    assert shown["text/plain"] == repr(YARD)
    assert repr(replace(YARD, name="x")) != repr(YARD)
