"""One studio for all tests of the page's looks, a browser for each file, and a page in it.

A browser that outlived its file would be in the way of those of other files.
"""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, ViewportSize, expect, sync_playwright
from studio_page import CHROMIUM, OPTIONS, STUCK, served, settled

SIZE: ViewportSize = {"width": 1280, "height": 720}


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    if not CHROMIUM.exists():
        pytest.skip("apt-get install chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=OPTIONS)
        expect.set_options(timeout=STUCK)
        yield browser
        browser.close()


@pytest.fixture(scope="package")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a short training."""
    pytest.importorskip("jax")
    from habilis.learning.config import Config
    from habilis.learning.runner import train

    folder = tmp_path_factory.mktemp("runs") / "trained"
    train(Config(world="yard", runs=2, episodes=150), out=folder)
    return folder


@pytest.fixture(scope="package")
def address(trained: Path) -> Iterator[str]:
    """A studio with a run to watch."""
    with served(str(trained)) as address:
        yield address


@pytest.fixture
def page(browser: Browser, address: str) -> Iterator[Page]:
    """A page on the yard, in which nothing may go wrong."""
    page = browser.new_page(viewport=SIZE, color_scheme="light")
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda line: faults.append(line.text) if line.type == "error" else None)
    page.goto(address)
    page.locator("#tab-design").click()
    settled(page)
    yield page
    page.close()
    assert not faults
