"""The page for those who hear it, use the keyboard alone, or ask for less motion."""

from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect
from studio_page import shown_averages

AXE = Path(__file__).parents[3] / "studio" / "node_modules" / "axe-core" / "axe.min.js"
RUN = """async () => (await axe.run(document, { resultTypes: ["violations"] })).violations
  .flatMap(({ id, nodes }) => nodes.map(({ html, failureSummary }) =>
    [id, html.slice(0, 120), failureSummary]))"""


def violations(page: Page) -> list[list[str]]:
    """The rules of axe that the page breaks, once nothing fades any more."""
    page.wait_for_timeout(700)
    page.evaluate(AXE.read_text("utf-8"))
    return page.evaluate(RUN)


@pytest.mark.skipif(not AXE.exists(), reason="needs npm ci in studio/")
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_wrong_on_any_tab(page: Page, scheme: Any):
    page.emulate_media(color_scheme=scheme)
    shown_averages(page)
    page.get_by_role("radio", name="Which tool?").check(force=True)
    page.wait_for_selector("#pairs[data-pending=false]")
    assert violations(page) == []
    page.get_by_role("radio", name="Landscape").check(force=True)
    for view in ("design", "play", "train", "run"):
        page.locator(f"#tab-{view}").click()
        if view == "run":
            expect(page.locator("#run-board .arrow").first).to_be_attached()
        assert violations(page) == [], view
    page.locator("#help").click()
    assert violations(page) == []
    page.keyboard.press("Escape")
    page.locator("#keep").click()
    expect(page.locator("#python")).to_be_visible()
    assert violations(page) == []
    page.keyboard.press("Escape")
    page.locator("#tab-design").click()
    page.locator("#map-text").click()
    assert violations(page) == []


@pytest.mark.skipif(not AXE.exists(), reason="needs npm ci in studio/")
def test_axe_finds_nothing_wrong_on_a_phone_with_the_tour(browser: Browser, address: str):
    page = browser.new_page(viewport={"width": 390, "height": 844}, color_scheme="light")
    page.goto(address)
    page.locator("#tab-design").click()
    page.locator("#help").click()
    page.locator("#tour-again").click()
    shown_averages(page)
    assert violations(page) == []
    page.close()
