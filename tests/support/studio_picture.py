"""The picture of the studio in README.md.

PYTHONPATH=tests/support python tests/support/studio_picture.py docs/studio.png
"""

import sys
from pathlib import Path

from playwright.sync_api import Browser, expect, sync_playwright
from studio_page import CHROMIUM, LANDSCAPE, OPTIONS, STUCK, middle, served, settled, shown_averages

POINTED = (8, 4)
"""The cell under the pointer: beside the can."""


def take(browser: Browser, path: Path) -> None:
    """Takes the picture: the yard as first shown, with the futures of one cell."""
    with served() as address:
        size = {"width": 1280, "height": 664}
        page = browser.new_page(viewport=size, color_scheme="light")  # type: ignore[arg-type]
        page.goto(address)
        settled(page)
        shown_averages(page)
        page.mouse.move(*middle(page, LANDSCAPE, POINTED))
        expect(page.locator("#caption")).to_contain_text("bits,", timeout=STUCK)
        page.wait_for_timeout(300)  # until animations have ended
        page.screenshot(path=path)
        page.close()


if __name__ == "__main__":
    with sync_playwright() as playwright:
        take(playwright.chromium.launch(executable_path=CHROMIUM, args=OPTIONS), Path(sys.argv[1]))
