"""Puzzles and environments in the page, in a browser."""

from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, expect
from studio_page import PICTURES, STUCK, middle, served

import habilis as hb
from habilis.bridges.puzzles.pushworld import load_pushworld
from habilis.bridges.puzzles.sokoban import load_sokoban

LANDSCAPE, PLAY = "#board-landscape", "#board-play"
TOOL = Path(__file__).parents[4] / "shared/pushworld/puzzles/level1/Pick A Tool.pwp"
LEVEL = "#######\n#@ $. #\n# $.  #\n#######\n"


def opened(browser: Browser, address: str) -> Page:
    page = browser.new_page(viewport={"width": 1280, "height": 720}, color_scheme="light")
    page.on("pageerror", lambda error: pytest.fail(str(error)))
    page.goto(address)
    settled(page)
    return page


def settled(page: Page) -> None:
    page.wait_for_selector(f"{LANDSCAPE}[data-pending=false]", timeout=STUCK)


def bits_in(page: Page) -> dict[tuple[int, int], float]:
    labels = page.locator(f"{LANDSCAPE} [role=gridcell]").evaluate_all(
        "cells => cells.map(cell => [cell.id, cell.getAttribute('aria-label')])"
    )
    found = {}
    for name, label in labels:
        if label.endswith(" bits"):
            row, column = map(int, name.split("-")[-2:])
            found[row, column] = float(label.split()[-2])
    return found


def check(page: Page, wanted: np.ndarray) -> None:
    """That the page shows these values, and no others."""
    rows, columns = np.nonzero(~np.isnan(wanted))
    cells = list(zip(rows.tolist(), columns.tolist(), strict=True))
    expect(page.locator("#board-fault")).to_be_empty()
    assert bits_in(page) == {cell: float(f"{wanted[cell]:.2f}") for cell in cells}


def kept(page: Page, name: str) -> None:
    PICTURES.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=PICTURES / f"board-{name}.png")


def test_a_sokoban_level_is_measured_played_and_solved(browser: Browser, tmp_path: Path):
    path = tmp_path / "level.xsb"
    path.write_text(LEVEL)
    level = load_sokoban(path)
    with served(str(path)) as address:
        page = opened(browser, address)
        check(page, hb.landscape(level, 3).values)
        faint = ".walls g[opacity]"  # the two goals under a number, which has to be legible
        expect(page.locator(f"#board-start {faint}")).to_have_count(0)
        expect(page.locator(f"{LANDSCAPE} {faint}")).to_have_count(2)
        page.locator("#board-sensor").select_option(label="B1")
        page.locator("#board-actions input").nth(0).uncheck()
        settled(page)
        check(page, hb.landscape(level, 3, "object:b1", [1, 2, 3]).values)
        page.mouse.move(*middle(page, LANDSCAPE, (2, 1)))
        expect(page.locator("#board-caption")).to_contain_text("of the b1")
        expect(page.locator(f"{LANDSCAPE} .mark").first).to_be_visible()
        kept(page, "sokoban")
        page.locator("#tab-play").click()
        page.keyboard.press("ArrowRight")
        expect(page.locator("#board-state")).to_contain_text("1 step · return −1")
        page.keyboard.press("r")
        page.locator("#board-show").click()
        expect(page.locator("#board-plan")).to_contain_text("4 steps")
        expect(page.locator("#board-state")).to_contain_text("The episode has ended after 4 steps")
        page.keyboard.press("b")
        expect(page.locator(f"{PLAY} .value-cell").first).to_be_visible()
        kept(page, "sokoban-play")
        page.locator("#tab-design").click()
        page.get_by_text("Maps", exact=True).first.click()
        expect(page.locator("#landscape-board")).to_be_visible()
        expect(page.locator(LANDSCAPE)).to_be_hidden()
        page.close()


def test_a_link_has_the_question_about_a_board(browser: Browser, tmp_path: Path):
    path = tmp_path / "level.xsb"
    path.write_text(LEVEL)
    with served(str(path)) as address:
        page = opened(browser, address)
        page.locator("#board-sensor").select_option(label="B1")
        page.locator("#board-horizon").fill("2")
        page.locator("#board-actions input").nth(0).uncheck()
        settled(page)
        link = page.url
        assert link.endswith("#b=level.xsb&s=object%3Ab1&h=2&x=1.2.3")
        bits = bits_in(page)
        other = opened(browser, link)
        assert bits_in(other) == bits
        expect(other.locator("#board-sensor")).to_have_value("factor 2")
        expect(other.locator("#board-actions input").nth(0)).not_to_be_checked()
        other.get_by_text("Maps", exact=True).first.click()
        settled_map = "#landscape-board[data-pending=false]"
        other.wait_for_selector(settled_map, timeout=STUCK)
        assert "#w=" in other.url
        other.reload()
        other.wait_for_selector(settled_map, timeout=STUCK)
        expect(other.locator("#landscape-board")).to_be_visible()  # a link to a map shows the map
        other.goto("about:blank")
        other.goto(link.replace("level.xsb&s=object%3Ab1", "other.xsb"))
        expect(other.locator("#link-fault")).to_contain_text("“other.xsb”, with which this studio")
        other.goto("about:blank")
        other.goto(link.replace("object%3Ab1", "b7").replace("h=2", "h=99"))
        expect(other.locator("#link-fault")).to_contain_text("its sensor “b7” is unknown")
        expect(other.locator("#link-fault")).to_contain_text("its horizon “99” is not a whole")
        expect(other.locator("#board-horizon")).to_have_value("3")
        page.close()
        other.close()


@pytest.mark.skipif(not TOOL.exists(), reason="needs the puzzles of PushWorld")
def test_a_puzzle_of_pushworld_is_shown_with_its_bodies(browser: Browser):
    puzzle = load_pushworld(TOOL)
    with served(str(TOOL)) as address:
        page = opened(browser, address)
        check(page, hb.landscape(puzzle, 3).values)
        expect(page.locator("#board-start .thing.object")).to_have_count(5)
        kept(page, "pushworld")
        page.close()


def test_frozen_lake_is_played_on_its_own_picture(browser: Browser):
    pytest.importorskip("pygame")
    with served("gym:FrozenLake-v1?is_slippery=false") as address:
        page = opened(browser, address)
        before = page.locator(f"{PLAY} image").get_attribute("href")
        page.locator("#tab-play").click()
        page.keyboard.press("ArrowRight")
        expect(page.locator("#board-state")).to_contain_text("1 step")
        assert page.locator(f"{PLAY} image").get_attribute("href") != before
        page.keyboard.press("ArrowDown")  # into the hole
        expect(page.locator("#board-state")).to_contain_text("ended after 2 steps · return 0")
        page.locator("#board-show").click()
        expect(page.locator("#board-state")).to_contain_text("ended after 6 steps · return 1")
        kept(page, "frozen-lake")
        page.close()


def test_minigrid_is_played_with_its_own_actions(browser: Browser):
    pytest.importorskip("minigrid")
    with served("gym:minigrid:MiniGrid-DoorKey-5x5-v0") as address:
        page = opened(browser, address)
        expect(page.locator("#board-facts")).to_contain_text("pickup (P)")
        page.locator("#tab-play").click()
        page.keyboard.press("ArrowRight")  # turns towards the key
        page.keyboard.press("p")
        expect(page.locator("#board-state")).to_contain_text("2 steps")
        page.locator("[data-action=toggle]").click()
        expect(page.locator("#board-state")).to_contain_text("3 steps")
        page.keyboard.press("b")
        expect(page.locator(f"{PLAY} .value-cell")).to_have_count(3)  # the key's cell is free now
        kept(page, "minigrid")
        page.close()
