"""Every tab on a phone, a tablet, a laptop and a desk: nothing overflows, nothing is too small."""

from typing import Any

import pytest
from playwright.sync_api import Page, expect
from studio_page import keep_picture, middle, shown_averages

SCREENS = {"phone": (390, 844), "tablet": (820, 1180), "laptop": (1280, 720), "desk": (1920, 1080)}
VIEWS = ("design", "pairs", "play", "train", "run")
CHART = 240, 130  # pixels, at least
LETTERS = 10.0  # pixels, at least

OUTSIDE = """() => [...document.querySelectorAll("main *:not(svg *), header *:not(svg *)")]
  .filter((e) => e.checkVisibility() && !e.closest(".shapes"))
  .filter((e) => { const b = e.getBoundingClientRect();
    return b.width && (b.left < -0.5 || b.right > innerWidth + 0.5); })
  .map((e) => e.outerHTML.slice(0, 90))"""
CUT = """() => {
  const cut = [];
  const canvas = document.createElement("canvas").getContext("2d");
  for (const e of document.querySelectorAll("main *:not(svg *), header *:not(svg *)")) {
    if (!e.checkVisibility() || e.closest(".segment-name")) continue;
    const style = getComputedStyle(e);
    if (e.matches("select, input[type=number]")) {
      canvas.font = style.font;
      const text = e.matches("select") ? e.selectedOptions[0]?.text ?? "" : e.value;
      const room = e.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
      if (canvas.measureText(text).width > room + 1) cut.push(`${text}: ${room}`);
    } else if (style.overflowX === "hidden" && e.scrollWidth > e.clientWidth + 1) {
      cut.push(e.outerHTML.slice(0, 90));
    }
  }
  return cut;
}"""
SEEN = """() => ({
  scrolled: document.documentElement.scrollWidth - innerWidth,
  charts: [...document.querySelectorAll(".chart-box")].filter((e) => e.checkVisibility())
    .map((e) => [e.clientWidth, e.clientHeight]),
  boards: [...document.querySelectorAll(".board")].filter((e) => e.checkVisibility())
    .map((e) => [e.clientWidth, e.parentElement.clientWidth, e.getBoundingClientRect().height]),
  letters: [...document.querySelectorAll(".board .labels:has(text)")]
    .filter((e) => e.checkVisibility())
    .map((e) => [e.closest("svg"), parseFloat(getComputedStyle(e).fontSize)])
    .map(([svg, size]) => size * svg.clientWidth / svg.viewBox.baseVal.width),
  texts: [...document.querySelectorAll(".board .labels text")]
    .map((e) => e.getBBox().width),
  bottom: document.querySelector("main").getBoundingClientRect().bottom - innerHeight,
})"""


def open_view(page: Page, view: str) -> None:
    page.locator(f"#tab-{'design' if view == 'pairs' else view}").click()
    if view == "pairs":
        page.get_by_role("radio", name="Which tool?").check(force=True)
        page.wait_for_selector("#pairs[data-pending=false]")
    if view == "design":
        shown_averages(page)
    if view == "play":
        page.get_by_role("switch", name="Bits").check()
        expect(page.locator("#play-board .labels text")).not_to_have_count(0)
    if view == "run":
        expect(page.locator("#run-board .arrow").first).to_be_attached()
        page.locator("#step").fill("0")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_tab_fits_every_screen(page: Page, scheme: Any):
    page.emulate_media(color_scheme=scheme)
    for view in VIEWS:
        open_view(page, view)
        for screen, (width, height) in SCREENS.items():
            where = view, screen
            page.set_viewport_size({"width": width, "height": height})
            page.wait_for_timeout(200)  # until charts and letters have their new sizes
            assert page.evaluate(OUTSIDE) == [], where
            assert page.evaluate(CUT) == [], where
            seen = page.evaluate(SEEN)
            assert seen["scrolled"] <= 0, where
            if screen != "phone":
                assert seen["bottom"] < 1, where
            for wide, high in seen["charts"]:
                assert wide >= CHART[0], where
                assert high >= CHART[1], where
            for wide, room, high in seen["boards"]:
                if screen == "phone":
                    assert wide == room > 320, where
                if screen == "desk":  # as wide as there is room, or as high
                    assert wide == room or high > 0.65 * height, where
            if view in ("design", "play"):
                assert seen["letters"], where
            assert all(letters >= LETTERS for letters in seen["letters"]), where
            assert all(wide <= 100 for wide in seen["texts"]), where
            keep_picture(page, f"{view}-{screen}-{scheme}")


def test_small_values_have_two_decimals(page: Page):
    page.locator("#slip").fill("0.5")
    page.locator("#horizon").fill("1")
    page.wait_for_selector("#landscape-board[data-pending=false]")
    ends = page.locator(".landscape .scale > span:not(.scale-bar):visible").all_inner_texts()
    assert 0.1 <= float(ends[1]) - float(ends[0]) < 1
    for text in page.locator("#landscape-board .labels text").all_text_contents():
        assert len(text.partition(".")[2]) == 2


def test_an_axis_that_is_not_linear_says_so(page: Page):
    open_view(page, "run")
    expect(page.locator("#run-curve .axis").last).to_have_text("return, log scale")
    open_view(page, "play")
    expect(page.locator("#bits-chart .axis").last).to_have_text("bits")


def test_values_that_are_missing_after_a_drag_are_explained(page: Page):
    open_view(page, "run")
    hint = page.locator("#run-hint")
    expect(hint).not_to_contain_text("without a value")
    values = page.locator("#run-board .value-cell")
    before = values.count()
    (x, y), (to_x, to_y) = (middle(page, "#run-board", cell) for cell in ((3, 0), (2, 1)))
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(to_x, to_y, steps=5)
    page.mouse.up()
    expect(hint).to_contain_text("Cells without a value")
    assert values.count() < before / 2
    keep_picture(page, "run-tool-elsewhere")
    page.locator("#run-back").click()
    expect(hint).not_to_contain_text("without a value")


def test_arrows_of_a_policy_can_be_read(page: Page):
    open_view(page, "run")
    for width, height in SCREENS.values():
        page.set_viewport_size({"width": width, "height": height})
        sizes = page.locator("#run-board .arrows .arrow").evaluate_all(
            "all => all.map((e) => { const b = e.getBoundingClientRect();"
            " return Math.max(b.width, b.height); })"
        )
        assert min(sizes) > 14
