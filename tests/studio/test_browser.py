"""The studio in a real browser: what a person does, and what the page then shows."""

import shutil
import socket
from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from playwright.sync_api import (
    Browser,
    Page,
    Request,
    ViewportSize,
    expect,
    sync_playwright,
)
from studio_page import (
    CHROMIUM,
    LANDSCAPE,
    OPTIONS,
    STUCK,
    WORLD,
    drag,
    give_text,
    keep_picture,
    map_text,
    middle,
    served,
    settled,
    shown_averages,
    shown_bits,
    take_in,
    true_bits,
)
from studio_picture import take

from habilis.analysis.averages import compare
from habilis.analysis.futures import futures
from habilis.analysis.landscape import landscape
from habilis.worlds.plans import solve
from habilis.worlds.table import placement, tabulate
from habilis.worlds.tools import TOOLS
from habilis.worlds.world import Cell, World, load_world

pytestmark = pytest.mark.skipif(not CHROMIUM.exists(), reason="apt-get install chromium")

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
LARGEST_PICTURE = 150_000  # bytes
YARD = load_world("yard")
KEYS = ("ArrowUp", "ArrowRight", "ArrowDown", "ArrowLeft", "w", "d", "s", "a")
SIZES = ((1280, 720), (1024, 768), (810, 1080))
SIZE: ViewportSize = {"width": 1280, "height": 720}


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with served() as address:
        yield address


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=OPTIONS)
        expect.set_options(timeout=STUCK)
        yield browser
        browser.close()


@pytest.fixture
def page(browser: Browser, address: str) -> Iterator[Page]:
    """A page on the yard; nothing may go wrong in it, and no other host be asked."""
    page = browser.new_page(viewport=SIZE, color_scheme="light")
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda line: faults.append(line.text) if line.type == "error" else None)

    def look(request: Request) -> None:
        if not request.url.startswith((address.partition("?")[0], "data:", "blob:")):
            faults.append(f"asked {request.url}")

    page.on("request", look)
    page.goto(address)
    settled(page)
    yield page
    page.close()
    assert not faults


def test_shows_the_bits_and_averages_that_the_library_gives(page: Page):
    assert shown_bits(page) == true_bits(YARD, 3)
    averages = {t: round(b, 2) for t, b in compare(YARD, [*TOOLS, "none"], 3).items()}
    assert shown_averages(page) == averages
    assert averages.items() >= {"picker": 0.52, "broom": 0.28, "none": 0.23}.items()
    expect(page.locator("#verdict")).to_contain_text("The picker helps: 0.29 bits more")
    keep_picture(page, "design")


def test_a_wall_drawn_by_dragging_changes_the_bits(page: Page):
    drag(page, WORLD, (7, 4), (7, 5))
    walled = replace(YARD, walls=YARD.walls | {(7, 4), (7, 5)})
    assert true_bits(walled, 3) != true_bits(YARD, 3)
    assert shown_bits(page) == true_bits(walled, 3)


def test_a_wall_dragged_over_again_is_erased(page: Page):
    drag(page, WORLD, (4, 6), (8, 6))
    expected = true_bits(replace(YARD, walls=YARD.walls - {(r, 6) for r in range(4, 9)}), 3)
    assert shown_bits(page) == expected


def test_agent_tool_can_and_bin_are_dragged(page: Page):
    drag(page, WORLD, YARD.object, (5, 4))
    drag(page, WORLD, YARD.goal, (0, 9))
    assert YARD.tool_cell is not None
    drag(page, WORLD, YARD.tool_cell, (6, 4))
    drag(page, WORLD, YARD.agent, (0, 0))
    moved = YARD.with_cells(object=(5, 4), goal=(0, 9), tool=(6, 4), agent=(0, 0))
    assert shown_bits(page) == true_bits(moved, 3)
    assert map_text(page) == "\n".join(moved.rows)


def test_a_thing_is_not_dragged_onto_another_or_into_a_wall(page: Page):
    drag(page, WORLD, YARD.agent, (1, 0))
    expect(page.locator("#undo")).to_be_disabled()
    drag(page, WORLD, YARD.object, (9, 3), (9, 4), YARD.goal)
    assert shown_bits(page) == true_bits(YARD.with_cells(object=(9, 4)), 3)


def test_tool_horizon_sensor_actions_and_slip_are_those_that_are_measured(page: Page):
    page.get_by_role("radio", name="Broom").check(force=True)
    page.locator("#horizon").fill("4")
    assert shown_bits(page) == true_bits(load_world("yard", tool="broom"), 4)
    assert shown_averages(page)["broom"] == round(compare(YARD, ["broom"], 4)["broom"], 2)
    page.locator("#horizon").fill("2")
    page.locator("#sensor").select_option("state")
    page.get_by_role("radio", name="Moves").check(force=True)
    moves = [0, 1, 2, 3]
    broom = load_world("yard", tool="broom")
    assert shown_bits(page) == true_bits(broom, 2, "state", actions=moves)
    page.locator("#slip").fill("0.2")
    assert shown_bits(page) == true_bits(broom, 2, "state", actions=moves, slip=0.2)


def test_estimates_stand_in_a_line_as_what_is_exact(page: Page):
    page.locator("#slip").fill("0.3")
    bits = page.locator(".bars .chosen .bits")
    expect(bits).to_contain_text("≈")
    height = bits.evaluate(
        "(bits) => bits.clientHeight / parseFloat(getComputedStyle(bits).lineHeight)"
    )
    assert round(height) == 1
    assert at_each_size(page, SCROLLED) == [[0, 0]] * len(SIZES)


def test_without_a_tool_there_are_only_moves(page: Page):
    page.get_by_role("radio", name="None").check(force=True)
    assert shown_bits(page) == true_bits(load_world("yard", tool="none"), 3)
    expect(page.get_by_role("radio", name="Moves")).to_be_disabled()
    # The tool's place is plain floor: a wall can be drawn there, and a tool still be taken up.
    assert YARD.tool_cell is not None
    drag(page, WORLD, YARD.tool_cell, YARD.tool_cell)
    bare = load_world("yard", tool="none")
    walled = replace(bare, walls=bare.walls | {YARD.tool_cell}, vacancy=None)
    assert shown_bits(page) == true_bits(walled, 3)
    page.get_by_role("radio", name="Picker").check(force=True)
    assert len(shown_bits(page)) == len(true_bits(walled, 3)) - 1


def test_the_can_is_seen_in_chosen_cells_only(page: Page):
    page.locator("#sensor").select_option("cells")
    settled(page)
    assert set(shown_bits(page).values()) == {0.0}
    scale = page.locator(".landscape .scale-bar")
    expect(scale).to_have_css("background-image", "none")  # of one colour, as all cells
    drag(page, LANDSCAPE, (9, 2), (9, 4))
    shown = shown_bits(page)
    mdp = tabulate(YARD)
    at = mdp.factor("object")
    seen = np.isin(at, [mdp.label((9, column)) for column in (2, 3, 4)])
    assert shown == true_bits(YARD, 3, np.where(seen, at, -1))
    assert max(shown.values()) > 0
    expect(scale).not_to_have_css("background-image", "none")


def test_undo_and_redo_by_keys_and_buttons(page: Page):
    drag(page, WORLD, (7, 3), (7, 5))
    walled = true_bits(replace(YARD, walls=YARD.walls | {(7, c) for c in (3, 4, 5)}), 3)
    page.locator("#horizon").fill("1")
    page.keyboard.press("Control+z")
    assert shown_bits(page) == walled
    page.keyboard.press("Control+z")
    assert shown_bits(page) == true_bits(YARD, 3)
    page.keyboard.press("Control+Shift+Z")
    assert shown_bits(page) == walled
    page.locator("#undo").click()
    assert shown_bits(page) == true_bits(YARD, 3)
    page.locator("#redo").click()
    assert shown_bits(page) == walled


def test_a_link_opens_exactly_what_is_shown(page: Page, browser: Browser):
    drag(page, WORLD, (0, 3), (0, 8))
    drag(page, WORLD, YARD.object, (5, 4))
    page.get_by_role("radio", name="Broom").check(force=True)
    page.locator("#horizon").fill("2")
    page.locator("#slip").fill("0.1")
    shown = shown_bits(page)
    assert len(page.url.partition("#")[2]) < 80
    other = browser.new_page(viewport=SIZE)
    other.goto(page.url)
    assert shown_bits(other) == shown
    expect(other.get_by_role("radio", name="Broom")).to_be_checked()
    expect(other.locator("#horizon")).to_have_value("2")
    other.close()


UNREADABLE = {
    "nonsense": "“#nonsense” is not a link of the studio",
    "t=picker&h=2": "it has no map",
    "w=10x10.A.1.2.3.4&t=picker": "its map “10x10.A.1.2.3.4” is damaged",
    "w=4x4.A*A.0.1.2.3&t=picker": "its map “4x4.A*A.0.1.2.3” is damaged",
    "w=4x4.AAA..1.2.3&t=picker": "its map “4x4.AAA..1.2.3” is damaged",
    "w=4x4.AAA.0.1.2.-&t=picker": "its map “4x4.AAA.0.1.2.-” is damaged",
    "w=9999x9999.AAAA.1.2.3.4&t=picker": (
        "its map has 9999 × 9999 cells, and a map has 4 to 30 rows and columns"
    ),
    "w=4x4.AAA.1.1.2.3&t=picker": "the picker of its map shares a cell with the agent",
    "w=4x4.AAA.0.1.2.16&t=picker": "the bin of the can of its map lies outside the map",
    "w=4x4.__8.0.1.2.3&t=picker": "the agent of its map is in a wall",
    "w=4x4.AAA.0.1.2.3&t=picker&o=spoon": "its object “spoon” is unknown here",
    "w=4x4.AAA.0.1.2.3&t=picker&m=rake@": "its thing “rake@” is damaged",
    "w=4x4.AAA.0.1.2.3&t=picker&m=rake@4,rake@5,rake@6,rake@7": "its map has 5 tools",
}
LINK_FAULT = "#link-fault"


def fragment(page: Page) -> str:
    return page.url.partition("#")[2]


def test_a_link_that_cannot_be_opened_says_why_and_stays_in_the_address(
    browser: Browser, address: str
):
    for link, words in UNREADABLE.items():
        page = browser.new_page(viewport=SIZE)
        page.goto(f"{address}#{link}")
        expect(page.locator(LINK_FAULT)).to_contain_text(f"The link cannot be opened: {words}")
        assert shown_bits(page) == true_bits(YARD, 3)
        page.locator("#tab-play").click()
        assert fragment(page) == link
        page.close()


def test_the_way_back_leads_to_a_link_that_was_not_understood(browser: Browser, address: str):
    page = browser.new_page(viewport=SIZE, color_scheme="light")
    page.goto(f"{address}#nonsense")
    settled(page)
    fault = page.locator(LINK_FAULT)
    expect(fault).to_be_visible()
    keep_picture(page, "link-not-opened")
    drag(page, WORLD, (7, 4), (7, 5))
    expect(fault).to_be_hidden()
    walled = true_bits(replace(YARD, walls=YARD.walls | {(7, 4), (7, 5)}), 3)
    assert shown_bits(page) == walled
    drawn = fragment(page)
    page.go_back()
    expect(fault).to_contain_text("Showing the previous world instead")
    assert fragment(page) == "nonsense"
    assert shown_bits(page) == walled
    page.go_forward()
    expect(fault).to_be_hidden()
    assert fragment(page) == drawn


def test_the_link_that_is_copied_is_of_what_is_shown(browser: Browser, address: str):
    with browser.new_context(permissions=["clipboard-read", "clipboard-write"]) as context:
        page = context.new_page()
        page.goto(f"{address}#w=4x4.AAA.0.1.2.3&t=picker&h=77")
        expect(page.locator(LINK_FAULT)).to_be_visible()
        page.locator("#share").click()
        expect(page.locator(".notice")).to_have_text("Link copied")
        copied = page.evaluate("navigator.clipboard.readText()")
        assert copied == f"{address}#w=4x4.AAA.0.1.2.3&t=picker&h=10"
        assert fragment(page) == "w=4x4.AAA.0.1.2.3&t=picker&h=77"


def test_a_link_that_asks_for_what_is_not_there_is_taken_as_far_as_it_goes(
    browser: Browser, address: str
):
    page = browser.new_page(viewport=SIZE, color_scheme="light")
    link = "w=4x4.AAA.0.1.2.3&t=none&s=tool&x=tool&h=99&v=nowhere&q=1"
    page.goto(f"{address}#{link}")
    bare = World.parse("A.CG\n....\n....\n....")
    assert shown_bits(page) == true_bits(bare, 10)
    expect(page.locator("#sensor")).to_have_value("object")
    expect(page.locator("#fault")).to_be_empty()
    for words in (
        "The link can only be shown in part",
        "its field “q” is unknown",
        "it observes a tool without having one",
        "its horizon “99” is not a whole number from 0 to 10, and 10 is used",
        "its view “nowhere” is unknown",
    ):
        expect(page.locator(LINK_FAULT)).to_contain_text(words)
    keep_picture(page, "link-in-part")
    page.locator("#horizon").fill("2")
    expect(page.locator(LINK_FAULT)).to_be_hidden()
    assert fragment(page) == "w=4x4.AAA.0.1.2.3&t=none&h=2&x=tool"
    page.close()


def test_a_link_with_a_tool_that_is_not_known_here_leaves_it_out(browser: Browser, address: str):
    page = browser.new_page(viewport=SIZE)
    page.goto(f"{address}#w=4x4.AAA.0.1.2.3&t=%2Ftmp%2Fmine.py%3ASpoon&h=2")
    expect(page.locator(LINK_FAULT)).to_contain_text(
        "its tool “/tmp/mine.py:Spoon” is unknown here, and is left out (start the studio with "
        "--tool)"
    )
    assert shown_bits(page) == true_bits(World.parse("A.CG\n....\n....\n...."), 2)
    page.goto(f"{address}#w=4x4.AAA.0.1.2.3&t=picker&m=spoon@8,ball@9&h=2")
    expect(page.locator(LINK_FAULT)).to_contain_text("its tool or object “spoon” is unknown here")
    world = World.parse("D = ball\nG = goal of C\nAPCG\n....\n.D..\n....")
    assert shown_bits(page) == true_bits(world, 2, "object:can")
    page.close()


def test_a_link_has_what_hardly_fails_and_tools_of_any_path(browser: Browser, tmp_path: Path):
    folder = tmp_path / "a,b@1%2C*c>d"
    folder.mkdir()
    (folder / "mine.py").write_text((EXAMPLES / "rake.py").read_text("utf-8"), "utf-8")
    with served("--tool", f"{folder / 'mine.py'}:Rake") as address:
        page = browser.new_page(viewport=SIZE)
        page.goto(address)
        settled(page)
        take_in(
            page, "B = broom slip 0.0000001\nP = picker slip 0.0000002\nABPCG\n.....\n.....\n....."
        )
        page.locator("#add").click()
        page.get_by_role("menuitem", name="Rake (yours)").click()
        expect(page.locator("#add")).to_be_visible()
        settled(page)
        other = browser.new_page(viewport=SIZE)
        other.goto(page.url)
        settled(other)
        expect(other.locator(LINK_FAULT)).to_be_hidden()
        text = map_text(other)
        assert text == map_text(page)
        slips = {tool.kind: tool.slip for tool in World.parse(text).tools}
        assert slips == {"broom": 1e-7, "picker": 2e-7, f"{folder / 'mine.py'}:Rake": 0.0}
        assert fragment(other) == fragment(page)
        page.close()
        other.close()


def test_pointing_at_a_cell_marks_its_reachable_futures(page: Page):
    page.mouse.move(*middle(page, LANDSCAPE, (8, 4)))
    marks = page.locator(f"{LANDSCAPE} .mark")
    expect(marks.first).to_be_visible()
    mdp = tabulate(YARD)
    assert YARD.tool_cell is not None
    found = futures(
        mdp, mdp.find(agent=(8, 4), tool=YARD.tool_cell, object=YARD.object), 3, "object"
    )
    expect(marks).to_have_count(len(found.observations))
    caption = page.locator("#caption")
    expect(caption).to_contain_text(f"{found.empowerment:.2f} bits")
    expect(caption).to_contain_text(f"{len(found.observations)} reachable cells")
    keep_picture(page, "design-futures")
    page.mouse.move(5, 5)
    expect(marks).to_have_count(0)


def test_a_tap_on_a_cell_marks_its_reachable_futures_until_the_next(browser: Browser, address: str):
    with browser.new_context(viewport=SIZE, has_touch=True) as context:
        page = context.new_page()
        page.goto(address)
        settled(page)
        marks = page.locator(f"{LANDSCAPE} .mark")
        for cell, places in (((8, 4), 6), ((7, 1), 2), ((0, 0), 1)):
            page.touchscreen.tap(*middle(page, LANDSCAPE, cell))
            expect(marks).to_have_count(places)
            expect(page.locator("#caption")).to_contain_text(f"{np.log2(places):.2f} bits")


def test_cells_are_chosen_with_a_finger(browser: Browser, address: str):
    with browser.new_context(viewport=SIZE, has_touch=True) as context:
        page = context.new_page()
        page.goto(address)
        page.locator("#sensor").select_option("cells")
        settled(page)
        chosen = page.locator(f"{LANDSCAPE} .chosen-cell")
        page.touchscreen.tap(*middle(page, LANDSCAPE, (0, 0)))
        expect(chosen).to_have_count(1)
        page.touchscreen.tap(*middle(page, LANDSCAPE, (0, 0)))
        expect(chosen).to_have_count(0)
        swipe(page, LANDSCAPE, (9, 2), (9, 4))
        expect(chosen).to_have_count(3)
        mdp = tabulate(YARD)
        at = mdp.factor("object")
        seen = np.isin(at, [mdp.label((9, column)) for column in (2, 3, 4)])
        assert shown_bits(page) == true_bits(YARD, 3, np.where(seen, at, -1))
        swipe(page, LANDSCAPE, (9, 4), (5, 4))  # begun on one that is chosen, it takes away
        expect(chosen).to_have_count(2)


def swipe(page: Page, board: str, start: Cell, end: Cell) -> None:
    """Puts a finger on the first cell, and lifts it from the last."""
    finger = page.context.new_cdp_session(page)

    def touch(kind: str, *points: tuple[float, float]) -> None:
        places = [{"x": x, "y": y} for x, y in points]
        finger.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": places})

    way = np.linspace(middle(page, board, start), middle(page, board, end), 8).tolist()
    touch("touchStart", way[0])
    for place in way[1:]:
        touch("touchMove", place)
    touch("touchEnd")
    finger.detach()


def test_the_picture_of_the_readme_is_taken_by_a_command(browser: Browser, tmp_path: Path):
    take(browser, tmp_path / "studio.png")
    for path in (tmp_path / "studio.png", ROOT / "docs" / "studio.png"):
        taken = plt.imread(path)
        assert taken.shape[:2] == (664, 1280)
        red, green, blue = np.moveaxis(taken[120:560, 540:980, :3], -1, 0)
        marks = (red > 2 * green) & (2 * green > 4 * blue)  # and the can, which is smaller
        assert marks.sum() > 4 * 500
        assert path.stat().st_size < LARGEST_PICTURE


def test_averages_of_the_scene_before_fade_until_those_of_this_one_are_there(page: Page):
    bits = page.locator(".bars [data-tool=none] .bits")
    verdict = page.locator("#verdict")
    shown_averages(page)
    for shown in (bits, verdict):
        expect(shown).to_have_css("opacity", "1")
    take_in(page, "AP.CG" + "." * 19 + ("\n" + "." * 24) * 23)
    settled(page)
    for shown in (bits, verdict):
        expect(shown).to_have_css("opacity", "0.4")
    shown_averages(page)
    for shown in (bits, verdict):
        expect(shown).to_have_css("opacity", "1")


def test_built_in_worlds_and_map_text(page: Page):
    page.locator("#worlds").select_option("corridor")
    assert shown_bits(page) == true_bits(load_world("corridor"), 3)
    text = "; a comment\n.....\n.AB..\n..C..\n....G"
    take_in(page, f"\ufeff{text}".replace("\n", " \r\n"))  # as some editors leave it
    assert shown_bits(page) == true_bits(World.parse(text), 3)
    expect(page.get_by_role("radio", name="Broom")).to_be_checked()


def test_map_text_that_is_no_map_is_refused_in_the_library_s_words(page: Page):
    text = "; its lines count\n....\n.AA.\n..C.\n...G"
    give_text(page, text)
    with pytest.raises(ValueError, match="line 3, column 3: a second agent") as refused:
        World.parse(text)
    expect(page.locator("dialog .fault")).to_have_text(str(refused.value))
    page.keyboard.press("Escape")
    assert shown_bits(page) == true_bits(YARD, 3)


def test_map_text_that_is_too_long_is_refused_and_stays_in_its_field(page: Page, tmp_path: Path):
    page.locator("#map-text").click()
    text = page.locator("#text")
    text.evaluate("(area) => { area.value = `; long\\n`.repeat(10_000) + `AP.CG`; }")
    page.locator("#use-map").click()
    fault = page.locator("dialog .fault")
    expect(fault).to_contain_text("The text has 70,005 characters")
    expect(fault).to_contain_text("the studio accepts up to 65,436")
    assert len(text.input_value()) == 70_005
    keep_picture(page, "map-text-too-long")
    box = text.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 5, box["y"] + 5)
    page.mouse.down()
    page.mouse.move(5, 5)
    page.mouse.up()  # beside the window, which stays, for the press began in the text
    assert len(text.input_value()) == 70_005
    file = page.locator("dialog input[type=file]")
    for size, words in ((70_000, "has 70,000 characters"), (2_000_000, "has 2,000,000 bytes")):
        (tmp_path / "long.txt").write_text("." * size)
        file.set_input_files(tmp_path / "long.txt")
        expect(fault).to_contain_text(f"The file long.txt {words}")
        assert len(text.input_value()) == 70_005
    (tmp_path / "long.txt").write_text(
        "APCG\n....\n....\n....\n" + "; as long as it may be\n" * 2_700
    )
    file.set_input_files(tmp_path / "long.txt")
    expect(fault).to_be_empty()
    page.locator("#use-map").click()
    expect(page.locator("dialog")).to_have_count(0)
    assert shown_bits(page) == true_bits(World.parse("APCG\n....\n....\n...."), 3)


def test_a_tie_is_called_one(page: Page):
    page.locator("#horizon").fill("0")
    verdict = page.locator("#verdict")
    shown_averages(page)
    expect(verdict).to_have_text(
        "The picker makes no difference: the agent cannot affect the can, with it or with bare "
        "hands."
    )
    expect(verdict).to_have_attribute("data-kind", "none")
    keep_picture(page, "design-tie")


def test_the_map_grows_and_shrinks_with_its_things_inside(page: Page):
    for side, value in (("rows", "4"), ("columns", "5")):
        page.locator(f"#{side}").fill(value)
        page.keyboard.press("Tab")
    assert len(shown_bits(page)) > 0
    small = World.parse(map_text(page))
    assert (small.height, small.width) == (4, 5)
    assert shown_bits(page) == true_bits(small, 3)
    page.locator("#rows").fill("99")
    page.keyboard.press("Tab")
    expect(page.locator("#rows")).to_have_value("30")


def test_the_keyboard_alone_draws_moves_and_asks(page: Page):
    page.locator(WORLD).focus()
    for key in ["ArrowDown"] * 7 + ["ArrowRight"] * 4 + ["Space"]:
        page.keyboard.press(key)
    walled = replace(YARD, walls=YARD.walls | {(7, 4)})
    assert shown_bits(page) == true_bits(walled, 3)
    page.keyboard.press("ArrowUp")
    page.keyboard.press("c")
    assert shown_bits(page) == true_bits(walled.with_cells(object=(6, 4)), 3)
    page.locator(LANDSCAPE).focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator("#caption")).to_contain_text("From row 0, column 1")
    page.keyboard.press("?")
    expect(page.get_by_role("dialog", name="What is this?")).to_be_visible()
    keep_picture(page, "help")
    page.keyboard.press("Escape")
    expect(page.locator("dialog")).to_have_count(0)


def test_playing_a_shortest_plan_brings_the_can_to_the_bin(page: Page):
    plan = solve(tabulate(YARD))
    assert plan is not None
    page.locator("#tab-play").click()
    for number, action in enumerate(plan.actions, start=1):
        page.keyboard.press(KEYS[action])
        expect(page.locator("#play-state")).to_contain_text(f"{number} step")
    expect(page.locator("#play-state")).to_have_text(
        f"The can is in the bin after {plan.steps} steps."
    )
    keep_picture(page, "play")
    page.locator("#reset").click()
    expect(page.locator("#play-state")).to_contain_text("0 steps")


def test_the_bits_of_play_are_those_of_the_state(page: Page):
    page.locator("#worlds").select_option("corridor")
    page.locator("#tab-play").click()
    world = load_world("corridor")
    start = true_bits(world, 3)[world.agent]
    expect(page.locator("#bits-now")).to_have_text(f"{start:.2f}")


def test_the_bits_of_every_cell_are_shown_over_the_game_as_it_is_now(page: Page):
    page.locator("#tab-play").click()
    shown = page.locator("#play-board .labels text")
    expect(shown).to_have_count(0)
    page.get_by_role("switch", name="Bits").check()
    world = YARD
    for keys in ((), ("ArrowDown", "ArrowDown", "ArrowRight")):
        for key in keys:
            page.keyboard.press(key)
            world = acted(world, KEYS.index(key))
        expect(page.locator("#play-state")).to_contain_text(f"{len(keys)} step")
        page.wait_for_selector("#play-board:not(.waiting)")
        wanted = landscape(world, 3, "object").values
        wanted = [f"{bits:.1f}" for bits in wanted[np.isfinite(wanted)]]
        assert shown.all_text_contents() == wanted
    keep_picture(page, "play-bits")
    page.keyboard.press("b")
    expect(shown).to_have_count(0)


def acted(world: World, action: int) -> World:
    """A world after an action."""
    mdp = tabulate(world)
    return placement(world, mdp, int(mdp.next_state[mdp.start, action]))


PRESSED_AT_ONCE = """() => {
  for (const key of ["ArrowRight", "ArrowDown", "ArrowDown", "ArrowLeft"])
    document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
}"""


def test_keys_that_are_pressed_while_the_server_thinks_are_not_lost(page: Page):
    page.locator("#tab-play").click()
    expect(page.locator("#bits-now")).not_to_have_text("–")
    page.evaluate(PRESSED_AT_ONCE)
    expect(page.locator("#play-state")).to_contain_text("4 steps")


def test_a_click_beside_the_agent_moves_it_there(page: Page):
    page.locator("#tab-play").click()
    row, column = YARD.agent
    page.mouse.click(*middle(page, "#play-board", (row, column + 1)))
    expect(page.locator("#play-state")).to_contain_text("1 step")
    page.mouse.click(*middle(page, "#play-board", (row, column + 3)))  # too far
    page.mouse.click(*middle(page, "#play-board", (row, column)))
    expect(page.locator("#play-state")).to_contain_text("2 steps")


def test_show_me_acts_out_a_shortest_plan(page: Page):
    plan = solve(tabulate(YARD))
    assert plan is not None
    page.locator("#tab-play").click()
    page.locator("#show-me").click()
    expect(page.locator("#plan")).to_contain_text(f"{plan.steps} steps")
    assert at_each_size(page, SCROLLED) == [[0, 0]] * len(SIZES)
    expect(page.locator("#play-state")).to_have_text(
        f"The can is in the bin after {plan.steps} steps."
    )


def test_show_me_says_that_there_is_no_plan(page: Page):
    take_in(page, "AC#G\n..##\n....\n....")
    page.locator("#tab-play").click()
    page.locator("#show-me").click()
    expect(page.locator("#plan")).to_have_text("No plan: the bin is unreachable.")
    expect(page.locator("#show-me")).to_have_text("Show me")


def test_light_and_dark_by_preference_and_by_the_switch(page: Page):
    body = page.locator("body")
    light, dark = "rgb(246, 245, 241)", "rgb(18, 20, 23)"
    expect(body).to_have_css("background-color", light)
    page.emulate_media(color_scheme="dark")
    expect(body).to_have_css("background-color", dark)
    page.emulate_media(color_scheme="light")
    expect(body).to_have_css("background-color", light)
    page.locator("#theme").click()
    expect(body).to_have_css("background-color", dark)
    keep_picture(page, "design-dark")
    page.reload()
    settled(page)
    expect(body).to_have_css("background-color", dark)


SCROLLED = """() => {
  const { scrollWidth, scrollHeight } = document.documentElement;
  return [scrollWidth - innerWidth, scrollHeight - innerHeight];
}"""


def at_each_size(page: Page, script: str) -> list[object]:
    """A script's result at each size of SIZES; the page then has the first again."""
    found = []
    for width, height in (*SIZES[1:], SIZES[0]):
        page.set_viewport_size({"width": width, "height": height})
        found.append(page.evaluate(script))
    return found


@pytest.mark.parametrize("size", SIZES)
def test_nothing_is_cut_off(page: Page, size: tuple[int, int]):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    for view in ("design", "play", "train", "run"):
        page.locator(f"#tab-{view}").click()
        if view == "play":
            page.get_by_role("switch", name="Bits").check()
            expect(page.locator("#play-board .labels text")).not_to_have_count(0)
        assert page.evaluate(SCROLLED) == [0, 0]
        keep_picture(page, f"{view}-{size[0]}")


@pytest.mark.parametrize("sides", [("30", "4"), ("4", "30"), ("30", "30")])
def test_no_map_is_too_tall_or_too_wide(page: Page, sides: tuple[str, str]):
    for side, value in zip(("rows", "columns"), sides, strict=True):
        page.locator(f"#{side}").fill(value)
        page.keyboard.press("Tab")
    settled(page)
    page.mouse.move(*middle(page, LANDSCAPE, (0, 1)))
    expect(page.locator("#caption")).to_contain_text("From row 0, column 1")
    for view in ("design", "play"):
        page.locator(f"#tab-{view}").click()
        if view == "play":
            page.get_by_role("switch", name="Bits").check()
            expect(page.locator(".play .scale")).to_be_visible()
        assert at_each_size(page, SCROLLED) == [[0, 0]] * len(SIZES)
        keep_picture(page, f"{view}-{'x'.join(sides)}")


def test_a_tablet_held_upright_is_filled(page: Page):
    page.set_viewport_size({"width": 810, "height": 1080})
    for view in ("play", "train"):
        page.locator(f"#tab-{view}").click()
        box = page.locator(f".{view}").bounding_box()
        assert box is not None
        assert box["y"] + box["height"] > 0.9 * 1080


def test_trains_while_the_curve_grows_stops_and_acts_out_what_was_learned(page: Page):
    pytest.importorskip("jax")
    page.locator("#tab-train").click()
    page.locator("#runs").fill("2")
    page.locator("#episodes").fill("300")
    page.locator("#start").click()
    watch = page.get_by_role("button", name="Watch")
    expect(watch).to_have_count(1)
    expect(page.locator("#curves .line")).to_have_count(1)
    expect(page.locator(".training")).to_contain_text("of 2 converged")

    # To whom standing near the can is worth more than the goal, it does not converge: this one ends
    # after ten times a hundred million steps, or when it is stopped.
    page.locator("#beta").fill("10")
    page.locator("#runs").fill("10")
    page.locator("#episodes").fill("100000")
    page.locator("#start").click()
    curve = page.locator("#curves .line.k1")
    expect(curve).to_have_count(1)
    paths = [curve.get_attribute("d")]
    for _ in range(2):
        expect(curve).not_to_have_attribute("d", paths[-1] or "")
        paths.append(curve.get_attribute("d"))
    expect(watch).to_have_count(1)  # the second still trains, and both are drawn
    expect(page.locator("#curves .line")).to_have_count(2)
    expect(page.locator("#start")).to_be_disabled()
    page.locator("#stop").click()
    expect(watch).to_have_count(2)
    expect(page.locator(".training").first).to_contain_text("stopped after")
    expect(page.locator("#start")).to_be_enabled()
    keep_picture(page, "train")

    watch.first.click()
    caption = page.locator("#run-caption")
    expect(caption).to_contain_text("step")
    page.locator("#tab-train").click()
    watch.last.click()
    expect(caption).to_contain_text("step")
    expect(page.locator("#action-bars li")).to_have_count(8)
    shares = [int(text.split()[0]) for text in page.locator("#action-bars .bits").all_inner_texts()]
    assert sum(shares) == pytest.approx(100, abs=4)
    expect(page.locator("#run-board .arrows .arrow").first).to_be_attached()
    expect(page.locator("#run-curve .line")).to_have_count(1)
    keep_picture(page, "run")


def test_a_training_that_is_kept_goes_by_the_name_of_its_folder(browser: Browser, tmp_path: Path):
    pytest.importorskip("jax")
    with served("--out", str(tmp_path / "kept")) as address:
        page = browser.new_page(viewport=SIZE)
        page.goto(address)
        page.locator("#tab-train").click()
        expect(page.locator("#kept")).to_contain_text(str(tmp_path / "kept"))
        page.locator("#runs").fill("1")
        page.locator("#episodes").fill("100")
        page.locator("#start").click()
        expect(page.get_by_role("button", name="Watch")).to_have_count(1)
        (folder,) = (path for path in (tmp_path / "kept").iterdir() if path.is_dir())
        expect(page.locator(".training .name")).to_contain_text(folder.name)
        keep_picture(page, "train-kept")
        page.close()


def test_a_training_is_listed_again_after_a_reload(browser: Browser):
    pytest.importorskip("jax")
    with served() as address:  # of its own: other pages list what is trained here, too
        page = browser.new_page(viewport=SIZE)
        page.goto(address)
        page.locator("#tab-train").click()
        page.locator("#seed").fill("77")
        page.locator("#runs").fill("2")
        page.locator("#episodes").fill("150")
        page.locator("#start").click()
        ours = page.locator(".training").filter(has_text="seed 77")
        watch = ours.get_by_role("button", name="Watch")
        expect(watch).to_have_count(1)
        page.locator("#tab-design").click()
        page.reload()
        settled(page)
        page.locator("#tab-train").click()
        expect(ours).to_contain_text("of 2 converged")
        ours.get_by_role("checkbox").click()
        expect(page.locator("#curves .line")).to_have_count(1)
        expect(ours).to_contain_text("return")
        watch.click()
        expect(page.locator("#run-caption")).to_contain_text("step")

        # What trains when its page is loaded again goes on, until it is stopped.
        page.locator("#tab-train").click()
        page.locator("#seed").fill("78")
        page.locator("#beta").fill("10")
        page.locator("#episodes").fill("100000")
        page.locator("#start").click()
        expect(page.locator("#curves .line")).to_have_count(2)
        page.locator("#tab-design").click()
        page.reload()
        settled(page)
        page.locator("#tab-train").click()
        stopped = page.locator(".training").filter(has_text="seed 78")
        expect(stopped).to_have_count(1)
        page.locator("#stop").click()
        expect(stopped).to_contain_text("stopped after")
        expect(stopped.get_by_role("button", name="Watch")).to_have_count(1)
        page.close()


def test_what_a_folder_has_is_listed_by_the_next_studio_and_what_is_damaged_says_so(
    browser: Browser, tmp_path: Path
):
    pytest.importorskip("jax")
    from habilis.learning.config import Config
    from habilis.learning.replay import play
    from habilis.learning.runner import train

    run = train(Config(world="yard", runs=2, episodes=150, seed=5), out=tmp_path / "my run")
    shutil.copytree(tmp_path / "my run", tmp_path / "torn")
    (tmp_path / "torn" / "config.json").write_text("{")
    shutil.copytree(tmp_path / "my run", tmp_path / "worn")
    (tmp_path / "worn" / "parameters.npz").write_bytes(b"")
    (tmp_path / "photographs").mkdir()
    with served("--out", str(tmp_path)) as address:
        page = browser.new_page(viewport=SIZE, color_scheme="light")
        page.goto(address)
        page.locator("#tab-train").click()
        rows = page.locator(".training")
        expect(rows).to_have_count(3)
        torn, worn = (rows.filter(has_text=name) for name in ("torn", "worn"))
        expect(torn.locator(".fault")).to_contain_text("config.json: is damaged")
        expect(torn.get_by_role("button")).to_have_count(0)
        rows.filter(has_text="my run").get_by_role("button", name="Watch").click()
        caption = page.locator("#run-caption")
        expect(caption).to_contain_text(f"{len(play(run).actions)} step")
        page.locator("#tab-train").click()
        keep_picture(page, "train-listed")
        worn.get_by_role("checkbox").click()
        expect(worn.locator(".fault")).to_contain_text("parameters.npz: is damaged")
        worn.get_by_role("button", name="Watch").click()
        expect(caption).to_contain_text("parameters.npz: is damaged")
        expect(page.locator("#run-board")).to_be_hidden()
        keep_picture(page, "run-damaged")
        page.close()


def test_refused_training_settings_get_the_librarys_error(page: Page):
    pytest.importorskip("jax")
    page.locator("#tab-train").click()
    page.locator("#beta").fill("0")
    page.locator("#start").click()
    expect(page.locator(".training .fault")).to_contain_text(
        "give both the reward and its weight, or neither"
    )
    drawn = page.locator(".training").first.get_by_role("checkbox", name="Draw:")
    expect(drawn).not_to_be_checked()  # there is nothing to draw
    expect(drawn).to_be_disabled()
    expect(page.locator("#start")).to_be_enabled()


ARROW_BEYOND = """() => {
  const board = document.querySelector("#run-board").getBoundingClientRect();
  const boxes = [...document.querySelectorAll("#run-board .now .arrow")]
    .map((arrow) => arrow.getBoundingClientRect());
  const { x, y, height } = boxes.reduce((one, other) => (one.x < other.x ? one : other));
  return { x, y, width: board.x - x, height };
}"""


def test_a_trained_folder_is_acted_out_at_once(browser: Browser, tmp_path: Path):
    pytest.importorskip("jax")
    from habilis.learning.config import Config
    from habilis.learning.replay import play
    from habilis.learning.runner import train

    run = train(Config(world="yard", runs=2, episodes=150), out=tmp_path / "trained")
    with served(str(tmp_path / "trained")) as address:
        page = browser.new_page(viewport=SIZE)
        page.goto(address)
        caption = page.locator("#run-caption")
        for index in (0, 1):
            page.get_by_label("Run number").select_option(str(index))
            steps = len(play(run, index).actions)
            expect(caption).to_contain_text(f"{steps} step")
        expect(page.locator("#tab-run")).to_have_attribute("aria-selected", "true")

        assert at_each_size(page, SCROLLED) == [[0, 0]] * len(SIZES)

        # The agent stands at the edge of the map, and what it would do there is not cut off.
        page.locator("#step").fill("0")
        beyond = page.evaluate(ARROW_BEYOND)
        picture = plt.imread(BytesIO(page.screenshot(clip=beyond)))
        red, green, blue = np.moveaxis(picture[..., :3], -1, 0)
        assert np.any((red > 2 * green) & (green > blue))

        # Dragged elsewhere, the can is where the next episode begins with it.
        drag(page, "#run-board", YARD.object, (6, 5))
        mdp = tabulate(YARD)
        assert YARD.tool_cell is not None
        start = mdp.find(agent=YARD.agent, tool=YARD.tool_cell, object=(6, 5))
        expect(caption).to_contain_text(f"{len(play(run, 1, start).actions)} step")
        expect(caption).to_contain_text("step")
        page.locator("#step").fill("0")
        drag(page, "#run-board", (6, 5), YARD.goal)  # where it would be over
        expect(page.locator("#run-board .object")).to_have_count(1)
        keep_picture(page, "run-elsewhere")
        page.locator("#run-back").click()
        expect(page.locator("#run-back")).to_be_hidden()
        expect(caption).to_contain_text(f"{len(play(run, 1).actions)} step")
        page.close()


def test_a_custom_tool_is_drawn_chosen_and_measured(browser: Browser):
    rake = f"{EXAMPLES / 'rake.py'}:Rake"
    with served("--tool", rake) as address:
        page = browser.new_page(viewport=SIZE)
        page.goto(address)
        settled(page)
        page.get_by_role("radio", name="Rake (yours)").check(force=True)
        assert shown_bits(page) == true_bits(load_world("yard", tool=rake), 3)
        assert shown_averages(page)[rake] == round(compare(YARD, [rake], 3)[rake], 2)
        assert "R" in map_text(page)
        page.close()


def test_several_things_are_put_on_the_map_picked_and_taken_away(page: Page, browser: Browser):
    def add(name: str) -> None:
        page.locator("#add").click()
        page.get_by_role("menuitem", name=name, exact=True).click()
        page.keyboard.press("Escape")
        expect(page.get_by_role("menu")).to_be_hidden()

    add("Rake")
    add("Ball")
    add("Bin of the ball")
    text = map_text(page)
    world = World.parse(text, "map")
    rake = {tool.kind: tool.cell for tool in world.tools}["rake"]
    ball = {thing.kind: thing for thing in world.objects}["ball"]
    assert ball.goal is not None
    drag(page, "#world-board", ball.cell, (5, 5))
    drag(page, "#world-board", rake, (0, 9))
    page.locator("#add").click()
    page.get_by_label("The tool in hand can be dropped").check()
    page.keyboard.press("Escape")
    world = World.parse(map_text(page), "map")
    assert {thing.name: thing.cell for thing in world.objects}["ball"] == (5, 5)
    assert world.drop
    page.locator("#sensor").select_option(label="Ball")
    assert shown_bits(page) == true_bits(world, 3, "object:ball")
    wanted = compare(world.with_object("ball"), [*TOOLS, "none"], 3)
    assert shown_averages(page) == {tool: round(bits, 2) for tool, bits in wanted.items()}
    keep_picture(page, "design-several")

    other = browser.new_page(viewport=SIZE)
    other.goto(page.url)
    assert shown_bits(other) == true_bits(world, 3, "object:ball")
    other.close()

    page.locator("#tab-play").click()
    page.locator("#put-down").click()
    expect(page.locator("#play-state")).to_have_text("1 step")  # and nothing is in hand
    page.keyboard.press("ArrowRight")
    expect(page.locator("#play-state")).to_have_text("2 steps")
    page.keyboard.press("ArrowLeft")
    expect(page.locator("#play-state")).to_contain_text("the picker is in hand")
    page.get_by_role("switch", name="Bits").check()
    assert at_each_size(page, SCROLLED) == [[0, 0]] * len(SIZES)
    keep_picture(page, "play-several")

    page.locator("#tab-design").click()
    row, column = 5, 5
    page.mouse.move(*middle(page, "#world-board", (row, column)))
    page.mouse.down()
    page.mouse.move(5, 5, steps=5)
    page.mouse.up()  # off the map
    left = World.parse(map_text(page), "map")
    assert [thing.kind for thing in left.objects] == ["can"]
    expect(page.locator("#sensor")).to_have_value("object")
    page.keyboard.press("Control+z")
    assert len(World.parse(map_text(page), "map").objects) == 2


def test_a_map_of_several_things_is_taken_in_as_text(page: Page):
    text = "D = crate\nR = rake\nG = goal of C\nA....\n.R.C.\n..D..\nP...G"
    take_in(page, text)
    world = World.parse(text, "map")
    assert shown_bits(page) == true_bits(world, 3, "object:can")
    page.locator("#sensor").select_option(label="Rake")
    assert shown_bits(page) == true_bits(world, 3, "tool:rake")
    page.get_by_role("radio", name="No tool").check(force=True)
    assert shown_bits(page) == true_bits(world.with_tool("none"), 3, "object:can")
    give_text(page, "R = os:path\nARC.G\n.....\n.....\n.....")
    expect(page.locator("dialog .fault")).to_contain_text("line 1: binds a character to a file")


CONTROLS = """() => [...document.querySelectorAll("main, .top button")].map((element) => {
  const { x, y, width, height } = element.getBoundingClientRect();
  return [x, y, width, height];
})"""
HIDDEN_BY_STATUS = """() => {
  const over = document.querySelector(".status").getBoundingClientRect();
  return [...document.querySelectorAll("main, .top button")].filter((element) => {
    const { left, right, top, bottom } = element.getBoundingClientRect();
    return left < over.right && over.left < right && top < over.bottom && over.top < bottom;
  }).map((element) => element.outerHTML.slice(0, 90));
}"""


def test_a_page_goes_on_when_its_server_has_come_back(browser: Browser):
    pytest.importorskip("jax")
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = str(free.getsockname()[1])
    page = browser.new_page(viewport=SIZE)
    with served("--port", port) as address:
        page.goto(address)
        settled(page)
        page.locator("#tab-train").click()
        page.locator("#beta").fill("10")
        page.locator("#episodes").fill("100000")
        page.locator("#start").click()
        expect(page.locator("#stop")).to_be_enabled()
        page.locator("#tab-play").click()
        expect(page.locator("#bits-now")).not_to_have_text("–")
        before = at_each_size(page, CONTROLS)
    status = page.locator(".status")
    expect(status).to_contain_text("Connection lost")
    assert at_each_size(page, CONTROLS) == before
    assert not any(at_each_size(page, HIDDEN_BY_STATUS))
    page.keyboard.press("ArrowDown")  # to nobody
    page.locator("#tab-train").click()
    expect(page.locator(".training .fault")).to_have_text("the connection to the server was lost")
    with served("--port", port):
        expect(status).to_be_hidden()
        expect(page.locator("#start")).to_be_enabled()
        page.locator("#tab-play").click()
        page.keyboard.press("ArrowDown")
        expect(page.locator("#play-state")).to_contain_text("1 step")
        page.locator("#tab-design").click()
        drag(page, WORLD, (7, 4), (7, 5))
        walled = replace(YARD, walls=YARD.walls | {(7, 4), (7, 5)})
        assert shown_bits(page) == true_bits(walled, 3)
    page.close()


CONTRASTS = """() => {
  const numbers = (colour) => colour.match(/[\\d.]+/g).map(Number);
  const light = ([r, g, b]) => [r, g, b]
    .map((v) => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
  const ground = (element) => {
    for (let e = element; e; e = e.parentElement) {
      const of = numbers(getComputedStyle(e).backgroundColor);
      if (of.length === 3 || of[3] === 1) return of;
    }
    return [255, 255, 255];
  };
  const found = [];
  for (const e of document.querySelectorAll("body *:not(svg *, option)")) {
    const text = [...e.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
    const off = e.closest(":disabled, :has(> input:disabled)");
    if (!text || off || !e.checkVisibility({ opacityProperty: true })) continue;
    const both = [light(numbers(getComputedStyle(e).color)), light(ground(e))];
    const [a, b] = both.sort((x, y) => y - x);
    found.push([(a + 0.05) / (b + 0.05), e.outerHTML.slice(0, 90)]);
  }
  return found.sort(([a], [b]) => a - b);
}"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_all_words_can_be_read_against_what_is_behind_them(page: Page, scheme):
    page.emulate_media(color_scheme=scheme)
    shown_averages(page)
    for view in ("design", "play", "train", "run"):
        page.locator(f"#tab-{view}").click()
        page.wait_for_timeout(300)
        contrasts = page.evaluate(CONTRASTS)
        assert len(contrasts) > 5
        assert contrasts[0][0] >= 4.5, contrasts[:5]


RINGED = """() => {
  const at = document.activeElement;
  const near = [at, at.nextElementSibling, at.parentElement];
  const ringed = near.some((e) => e && getComputedStyle(e).outlineStyle === "solid");
  const ring = at.querySelector(".ring");
  const board = ring !== null && getComputedStyle(ring).stroke !== "none";
  return at === document.body ? null : [ringed || board, at.outerHTML.slice(0, 90)];
}"""


def test_what_the_keyboard_is_at_is_seen(page: Page):
    seen = []
    page.keyboard.press("Tab")
    while (at := page.evaluate(RINGED)) is not None and len(seen) < 60:
        assert at[0], at[1]
        seen.append(at[1])
        page.keyboard.press("Tab")
    assert len(set(seen)) > 12


def test_nothing_moves_for_those_who_ask_for_that(page: Page):
    page.locator("#tab-play").click()
    agent = page.locator("#play-board .agent")
    taken = "(e) => getComputedStyle(e).transitionDuration"
    assert agent.evaluate(taken) != "0s"
    page.emulate_media(reduced_motion="reduce")
    assert agent.evaluate(taken) == "0s"
