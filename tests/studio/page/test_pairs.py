"""Which tool: the matrix of pairs and its curves, in a browser."""

from pathlib import Path

from playwright.sync_api import Browser, Page, expect
from studio_page import PICTURES, STUCK, drag, served

import habilis as hb

MAP = "R = rake\nD = ball\nG = goal of C\nAP...\n.#C..\n.D..R\n....G\n"


def compared(page: Page) -> dict[str, list[str]]:
    """The values that the page shows, by the tool of their row."""
    page.wait_for_selector("#pairs[data-pending=false]", timeout=STUCK)
    rows = page.locator("#pairs tbody tr")
    return {
        row.get_attribute("data-tool") or "": row.locator("td").all_inner_texts()
        for row in rows.all()
    }


def wanted(world: hb.World, tools: list[str]) -> dict[str, list[str]]:
    averages = hb.pairs(world, 3, tools).averages[-1]
    return {
        tool: [f"{bits:.2f}" for bits in row] for tool, row in zip(tools, averages, strict=True)
    }


def test_the_matrix_follows_what_is_drawn(browser: Browser, tmp_path: Path):
    (tmp_path / "map.txt").write_text(MAP)
    with served(str(tmp_path / "map.txt")) as address:
        page = browser.new_page(viewport={"width": 1280, "height": 800}, color_scheme="light")
        page.goto(address)
        page.get_by_text("Which tool?").click()
        before = compared(page)
        assert before == wanted(hb.World.parse(MAP), list(before))
        assert {"picker", "rake", "magnet", "none"} <= set(before)
        expect(page.locator("#pairs-chart .line")).to_have_count(len(before))
        page.locator("[data-tool=picker] .pair-value").nth(1).hover()
        said = page.locator("#pair")
        expect(said).to_contain_text(f"Picker, ball: {before['picker'][1]} bits at 3 steps")
        for measure in ("range", "latency", "persistence", "reliability 1.00"):
            expect(said).to_contain_text(measure)
        page.screenshot(path=PICTURES / "which-tool.png")
        drag(page, "#world-board", (0, 3), (0, 4))
        walled = MAP.replace("AP...", "AP.##")
        expect(page.locator("[data-tool=magnet] .pair-value").first).not_to_have_text(
            before["magnet"][0]
        )
        after = compared(page)
        assert after == wanted(hb.World.parse(walled), list(after))
        page.get_by_text("Landscape", exact=True).click()
        expect(page.locator("#pairs")).to_be_hidden()
        expect(page.locator("#landscape-board")).to_be_visible()
        page.close()
