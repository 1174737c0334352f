"""The tour of a first visit: it waits for what it asks for, and is not offered again."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect
from studio_page import WORLD, drag, keep_picture, settled

from habilis.worlds.world import load_world

YARD = load_world("yard")
TOUR = "#tour"


@pytest.fixture
def visitor(browser: Browser) -> Iterator[BrowserContext]:
    """Somebody who has not been here."""
    with browser.new_context(viewport={"width": 1280, "height": 800}) as context:
        yield context


def first(visitor: BrowserContext, address: str) -> Page:
    """A page as a first visitor sees it."""
    page = visitor.new_page()
    page.goto(address.partition("?")[0] + "#w=10x10.ADgCAIAiCIIgiAIAAA.20.30.83.95&t=picker")
    settled(page)
    return page


def test_the_tour_waits_for_each_thing_and_says_what_it_did(visitor: BrowserContext, address: str):
    page = first(visitor, address)
    words = page.locator(".tour-words")
    outcome = page.locator(".tour-outcome")
    count = page.locator(".tour-count")
    expect(words).to_contain_text("Draw a wall")
    expect(page.locator(WORLD)).to_have_class("board tour-target")
    keep_picture(page, "tour")
    drag(page, WORLD, YARD.object, (5, 4))  # is not what it asks for
    settled(page)
    expect(count).to_have_text("1 of 5")
    drag(page, WORLD, (4, 4), (4, 5))
    expect(words).to_contain_text("Drag the can")
    expect(outcome).to_contain_text("The bits changed in")
    drag(page, WORLD, (5, 4), YARD.object)
    expect(words).to_contain_text("Change the tool")
    page.get_by_role("radio", name="Broom").check(force=True)
    expect(words).to_contain_text("See the bits move")
    page.locator("#horizon").fill("4")
    expect(words).to_contain_text("futures behind its number")
    page.get_by_role("button", name="Done").click()
    expect(page.locator(TOUR)).to_be_hidden()
    page.reload()
    settled(page)
    expect(page.locator(TOUR)).to_be_hidden()
    page.locator("#tab-play").click()
    page.keyboard.press("?")
    page.get_by_role("button", name="Take the one-minute tour").click()
    expect(count).to_have_text("1 of 5")
    expect(page.locator(WORLD)).to_be_visible()


def test_the_tour_is_skipped_and_advanced_without_doing_anything(
    visitor: BrowserContext, address: str
):
    page = first(visitor, address)
    for number in range(1, 5):
        expect(page.locator(".tour-count")).to_have_text(f"{number} of 5")
        page.locator("#tour-next").click()
    page.reload()
    settled(page)
    expect(page.locator(TOUR)).to_be_visible()  # it was not ended
    page.locator("#tour-skip").click()
    page.reload()
    settled(page)
    expect(page.locator(TOUR)).to_be_hidden()


def test_no_tour_in_a_notebook_or_where_the_address_asks_for_none(
    visitor: BrowserContext, address: str
):
    page = visitor.new_page()
    for query in ("embedded=1", "tour=0"):
        page.goto(f"{address.partition('?')[0]}?{query}#w=4x4.AAA.0.1.2.3&t=picker")
        settled(page)
        expect(page.locator(TOUR)).to_be_hidden()
