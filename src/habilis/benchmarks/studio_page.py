"""The studio in a real browser: from the press of the mouse to what is on the screen then."""

import random
import shutil

EDITS = 60

_WATCH = """(() => {
  const board = document.querySelector("#landscape-board");
  let pressed = null;
  window.milliseconds = [];
  addEventListener("pointerdown", (event) => { pressed = event.timeStamp; }, true);
  const drawn = () => {
    if (pressed !== null) window.milliseconds.push(performance.now() - pressed);
    pressed = null;
  };
  new MutationObserver(() => {
    // A task after the next picture: what was drawn is on the screen then.
    if (board.dataset.pending === "false") requestAnimationFrame(() => setTimeout(drawn));
  }).observe(board, { attributeFilter: ["data-pending"] });
})()"""
_SEEN = "(count) => window.milliseconds.length === count"


def edits(address: str, horizon: int) -> list[float] | None:
    """Seconds from edits of a world to their landscapes on the screen.

    Each edit draws a wall in the built-in yard of 10 x 10 cells, or erases it.

    Args:
        address: of a studio.
        horizon: in actions.

    Returns:
        `None` where there is no browser: Playwright and Debian's chromium.
    """
    chromium = shutil.which("chromium")
    if chromium is None:
        return None
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        return None
    with sync_playwright() as playwright:
        flags = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"]
        browser = playwright.chromium.launch(executable_path=chromium, args=flags)
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.goto(address)
        page.locator("#horizon").fill(str(horizon))
        page.wait_for_selector("#landscape-board[data-pending=false]")
        page.evaluate(_WATCH)
        clicks = random.Random(0)
        for count in range(1, EDITS + 1):
            row, column = clicks.randrange(10), clicks.randrange(7, 10)  # nothing stands there
            page.locator(f"#world-board-{row}-{column}").click(force=True)
            page.wait_for_function(_SEEN, arg=count)
        found = page.evaluate("window.milliseconds")
        browser.close()
    return [milliseconds / 1e3 for milliseconds in found]
