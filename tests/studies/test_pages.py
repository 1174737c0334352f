"""The reports in a real browser: on a phone and on a screen, by day and by night."""

from pathlib import Path

import pytest
from paces import write_pace
from playwright.sync_api import sync_playwright
from reproductions import reproduction
from studio_page import CHROMIUM, OPTIONS

import habilis.studies.reproduction.reproduce as reproduce_module
from habilis.studies.pace.data import load_pace

pytestmark = pytest.mark.skipif(not CHROMIUM.exists(), reason="apt-get install chromium")

ROOT = Path(__file__).parents[2]
PICTURES = ROOT / "test-output" / "reports"
PAGES = ("paper", "paper-bare", "multiverse", "studies")
PHONE, SCREEN = 390, 1280

_LUMINANCE = """
element => {
  const linear = (c) => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  const of = (colour) => colour.match(/[\\d.]+/g).slice(0, 3).map(Number).map(linear)
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  return [of(getComputedStyle(element).color), of(getComputedStyle(document.body).backgroundColor)];
}
"""
_WIDE = """
() => [...document.querySelectorAll('.scroll, .picture')]
  .filter((box) => box.scrollWidth > box.clientWidth + 1).map((box) => box.textContent.slice(0, 60))
"""


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=OPTIONS)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    paces = {"paper": write_pace(folder / "pace"), "paper-bare": folder / "nowhere"}
    for name, pace in paces.items():
        reproduce_module._write(reproduction(folder / name, load_pace(pace), scale=0.1))
    docs = {name: ROOT / "docs" / name / "report.html" for name in ("multiverse", "studies")}
    return {name: folder / name / "report.html" for name in paces} | docs


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [PHONE, SCREEN])
@pytest.mark.parametrize("name", PAGES)
def test_a_page_fits_and_can_be_read(browser, pages, name, width, scheme):
    page = browser.new_page(viewport={"width": width, "height": 844}, color_scheme=scheme)
    page.goto(pages[name].as_uri())
    page.evaluate("document.querySelectorAll('details').forEach((one) => one.open = true)")
    assert page.evaluate("document.documentElement.scrollWidth") == width
    if width == SCREEN:
        assert page.evaluate(_WIDE) == [], "nothing is cut, or has to be scrolled"
    for selector in ("p", "td", "th", "h1", "a", "figcaption"):
        ink, paper = page.locator(selector).first.evaluate(_LUMINANCE)
        assert (paper < 0.1) == (scheme == "dark")
        assert (max(ink, paper) + 0.05) / (min(ink, paper) + 0.05) >= 4.5, selector
    drawn = page.locator("figure svg")
    assert drawn.count() >= 3
    assert set(
        drawn.evaluate_all("all => all.map((one) => getComputedStyle(one).backgroundColor)")
    ) == {"rgb(255, 255, 255)"}, "figures are drawn in dark ink, and stay on white"
    PICTURES.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=PICTURES / f"{name}-{width}-{scheme}.png", full_page=True)
    page.close()


@pytest.mark.parametrize("name", ["paper", "multiverse"])
def test_on_a_phone_figures_are_scrolled_rather_than_shrunk_illegibly(browser, pages, name):
    page = browser.new_page(viewport={"width": PHONE, "height": 844})
    page.goto(pages[name].as_uri())
    drawn = page.locator(".picture svg[style*=natural]").evaluate_all(
        "all => all.filter((one) => !one.closest('.worlds')).map((one) => "
        "[one.getBoundingClientRect().width, parseFloat(one.style.getPropertyValue('--natural'))])"
    )
    assert len(drawn) >= 5
    for width, natural in drawn:
        assert width >= min(0.69 * natural, 950)
    page.close()
