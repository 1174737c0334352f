"""What is on the screen, kept as files: pictures, values, films; and as code, copied."""

import csv
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page, expect
from studio_page import keep_picture, served, settled, shown_averages, shown_bits

from habilis.worlds.plans import solve
from habilis.worlds.table import tabulate
from habilis.worlds.world import load_world

YARD = load_world("yard")
SVG = "{http://www.w3.org/2000/svg}"


def kept(page: Page, what: str, folder: Path) -> Path:
    """A file from the dialog, which is open."""
    with page.expect_download() as download:
        page.get_by_role("button", name=what, exact=True).click()
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def rows(path: Path) -> list[list[str]]:
    with path.open(newline="") as file:
        return list(csv.reader(file))


def colours(path: Path) -> int:
    with Image.open(path) as picture:
        pixels = np.asarray(picture.convert("RGB"))
    return len(np.unique(pixels.reshape(-1, 3), axis=0))


def test_where_the_clipboard_is_closed_code_is_selected_instead(page: Page):
    page.evaluate("Object.defineProperty(navigator, 'clipboard', { value: undefined })")
    page.locator("#keep").click()
    page.locator("#copy-python").click()
    expect(page.locator(".notice")).to_have_text("Selected, but not copied: press Ctrl+C")
    selected = page.evaluate("getSelection().toString()")
    assert selected.strip() == (page.locator("#python").text_content() or "").strip()


def test_design_is_kept_as_pictures_values_and_code(page: Page, tmp_path: Path):
    averages = shown_averages(page)
    bits = shown_bits(page)
    page.locator("#keep").click()
    expect(page.locator("#python")).to_contain_text("hb.landscape(world, 3, 'object')")
    expect(page.locator("#command")).to_contain_text("habilis landscape map.txt --horizon 3")
    keep_picture(page, "keep-design")
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.locator("#copy-python").click()
    expect(page.locator(".notice")).to_have_text("Copied")
    copied = page.evaluate("navigator.clipboard.readText()")
    assert copied == page.locator("#python").text_content()
    table = rows(kept(page, "Landscape as CSV", tmp_path))
    assert table[0] == ["row", "column", "bits"]
    values = {(int(r), int(c)): round(float(v), 2) for r, c, v in table[1:] if v}
    assert values == bits
    tools = rows(kept(page, "Averages as CSV", tmp_path))
    assert {tool: round(float(value), 2) for tool, value, _ in tools[1:]} == averages
    for name in ("World", "Landscape"):
        png = kept(page, f"{name} as PNG", tmp_path)
        with Image.open(png) as picture:
            assert min(picture.size) >= 1200
        assert colours(png) > 20
        svg = ElementTree.parse(kept(page, f"{name} as SVG", tmp_path)).getroot()
        drawn = {part.get("id") for part in svg.iter(f"{SVG}g")}
        uses = {part.get("href", "")[1:] for part in svg.iter(f"{SVG}use")}
        assert {"shape-agent", "shape-picker", "shape-can", "shape-bin"} <= uses <= drawn
        texts = [part.text for part in svg.iter(f"{SVG}text")]
        assert len(texts) == (len(bits) if name == "Landscape" else 0)
        assert "var(" not in ElementTree.tostring(svg, "unicode")


def test_play_is_kept_as_films_and_bits(page: Page, tmp_path: Path):
    page.locator("#tab-play").click()
    expect(page.locator("#bits-now")).not_to_have_text("–")
    for number, key in enumerate(("ArrowDown", "ArrowDown", "ArrowRight"), 1):
        page.keyboard.press(key)
        expect(page.locator("#play-state")).to_contain_text(f"{number} step")
    page.locator("#keep").click()
    table = rows(kept(page, "Bits of the game as CSV", tmp_path))
    assert [row[0] for row in table] == ["step", "0", "1", "2", "3"]
    assert colours(kept(page, "Bits of the game as PNG", tmp_path)) > 3
    plan = solve(tabulate(YARD))
    assert plan is not None
    with Image.open(kept(page, "The game so far as GIF", tmp_path)) as film:
        assert film.n_frames == 4  # type: ignore[attr-defined]
    with Image.open(kept(page, "A shortest plan from here as GIF", tmp_path)) as film:
        assert plan.steps - 3 < film.n_frames <= plan.steps + 4  # type: ignore[attr-defined]
    expect(page.locator("#python")).to_contain_text("hb.empowerment(mdp, 3")


def test_a_run_is_kept_as_a_film_values_curve_and_code(page: Page, tmp_path: Path):
    page.locator("#tab-run").click()
    expect(page.locator("#run-board .arrow").first).to_be_attached()
    steps = int(page.locator("#step").get_attribute("max") or 0)
    page.locator("#keep").click()
    expect(page.locator("#python")).to_contain_text("load_latest(")
    expect(page.locator("#command")).to_contain_text("habilis watch")
    with Image.open(kept(page, "Episode as GIF", tmp_path)) as film:
        assert 1 < film.n_frames <= steps + 1  # type: ignore[attr-defined]
    assert colours(kept(page, "Episode as PNG", tmp_path)) > 20
    assert len(rows(kept(page, "State values as CSV", tmp_path))) == 101
    assert len(rows(kept(page, "Learning curve as CSV", tmp_path))) > 10
    assert colours(kept(page, "Learning curve as PNG", tmp_path)) > 3


def test_a_training_goes_on_after_a_reload_and_a_failed_one_is_dismissed(browser: Browser):
    pytest.importorskip("jax")
    with served() as address:
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.goto(address)
        settled(page)
        page.locator("#tab-train").click()
        page.locator("#beta").fill("10")
        page.locator("#runs").fill("1")
        page.locator("#episodes").fill("100000")
        page.locator("#start").click()
        expect(page.locator("#curves .line")).to_have_count(1)
        page.reload()
        expect(page.locator("#stop")).to_be_enabled()
        expect(page.locator("#start")).to_be_disabled()
        expect(page.locator("#curves .line")).to_have_count(1)
        expect(page.locator(".training .name")).to_contain_text("β 10")
        page.locator("#stop").click()
        expect(page.get_by_role("button", name="Watch")).to_have_count(1)
        page.locator("#beta").fill("0")
        page.locator("#start").click()
        expect(page.locator(".training .fault")).to_have_count(1)
        page.get_by_role("button", name="Dismiss").click()
        expect(page.locator(".training")).to_have_count(1)
        page.locator("#keep").click()
        expect(page.locator("#python")).to_contain_text("'beta': 10.0")
        keep_picture(page, "keep-train")
        page.close()


def test_a_puzzle_is_kept_as_pictures_values_films_and_code(browser: Browser, tmp_path: Path):
    (tmp_path / "level.xsb").write_text("#######\n#@ $. #\n# $.  #\n#######\n")
    with served(str(tmp_path / "level.xsb")) as address:
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        page.goto(address)
        expect(page.locator("#board-landscape .labels text").first).to_be_attached()
        page.locator("#keep").click()
        expect(page.locator("#python")).to_contain_text("hb.load_sokoban(")
        expect(page.locator("#command")).to_contain_text("habilis landscape")
        assert colours(kept(page, "World as PNG", tmp_path)) > 5
        assert colours(kept(page, "Landscape as PNG", tmp_path)) > 5
        assert len(rows(kept(page, "Landscape as CSV", tmp_path))) == 1 + 4 * 7
        page.keyboard.press("Escape")
        page.locator("#tab-play").click()
        page.keyboard.press("ArrowRight")
        expect(page.locator("#board-state")).to_contain_text("1 step")
        page.locator("#keep").click()
        with Image.open(kept(page, "The game so far as GIF", tmp_path)) as film:
            assert film.n_frames == 2  # type: ignore[attr-defined]
        expect(page.locator("#python")).to_contain_text("hb.explore(puzzle")
        page.close()
