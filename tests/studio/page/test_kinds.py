"""What is measured: the kinds of empowerment, in a browser."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect
from studio_page import LANDSCAPE, PICTURES, middle, served, settled, shown_bits, true_bits

import habilis as hb
from habilis.worlds.world import World

MAP = "A....\nP#...\n.C...\n...G.\n....."
WORLD = World.parse(MAP, "room")
OWN = {  # the settings of each kind
    "open-loop": {"#horizon", "[aria-label=Actions]"},
    "effective": {"#discount"},
    "closed-loop": {"#horizon", "[aria-label=Actions]"},
    "goal-directed": {"#horizon", "#slack"},
}


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    path = tmp_path_factory.mktemp("maps") / "map.txt"
    path.write_text(MAP)
    with served(str(path)) as address:
        yield address


def chosen(page: Page, kind: str) -> None:
    page.locator("#kind").select_option(kind)


def test_each_kind_has_its_sentence_its_settings_and_its_values(page: Page):
    expected = {
        "open-loop": {},
        "effective": {"kind": "effective", "discount": 0.5},
        "closed-loop": {"kind": "closed-loop"},
        "goal-directed": {"kind": "goal-directed", "slack": 4},
    }
    sentences = set()
    for kind, settings in expected.items():
        chosen(page, kind)
        for name, control in (("discount", "#discount"), ("slack", "#slack")):
            if name in settings:
                page.locator(control).fill(str(settings[name]))
        sentences.add(page.locator("#kind-sentence").inner_text())
        for control in set().union(*OWN.values()):
            visible = page.locator(f".design {control}").is_visible()
            assert visible == (control in OWN[kind]), (kind, control)
        assert shown_bits(page) == true_bits(WORLD, 3, **settings), kind
        PICTURES.mkdir(parents=True, exist_ok=True)
        for width, height in ((1280, 720), (390, 844)):
            page.set_viewport_size({"width": width, "height": height})
            page.wait_for_timeout(200)
            page.screenshot(path=PICTURES / f"kind-{kind}-{width}.png", full_page=width == 390)
        page.set_viewport_size({"width": 1280, "height": 720})
    assert len(sentences) == len(expected)


def test_a_cell_shows_the_value_of_its_kind_and_no_futures(page: Page):
    chosen(page, "effective")
    settled(page)
    expect(page.locator("#caption")).to_have_text("Point at a cell to read its value.")
    page.mouse.move(*middle(page, LANDSCAPE, (0, 0)))
    bits = hb.landscape(WORLD, 3, "object", kind="effective", discount=0.9).values[0, 0]
    expect(page.locator("#caption")).to_have_text(f"At row 0, column 0: {bits:.3f} bits.")
    page.mouse.move(0, 0)


def test_a_goal_is_refused_with_slip_and_the_comparison_stays_open_loop(page: Page):
    chosen(page, "goal-directed")
    page.locator("#slip").fill("0.1")
    said = "goal-directed empowerment is defined without noise only"
    expect(page.locator("#fault")).to_contain_text(said)
    page.locator("#slip").fill("0")
    settled(page)
    expect(page.locator("#fault")).to_be_empty()
    expect(page.locator(".averages .quiet")).to_contain_text("Mean open-loop bits, 3 steps ahead")
    page.get_by_role("radio", name="Which tool?").check(force=True)
    page.wait_for_selector("#pairs[data-pending=false]")
    expect(page.get_by_text("over the steps ahead, open loop")).to_be_visible()


def test_a_link_and_the_code_have_the_kind(page: Page, browser: Browser):
    chosen(page, "goal-directed")
    page.locator("#slack").fill("6")
    settled(page)
    shown = shown_bits(page)
    page.wait_for_function(
        "location.hash.includes('k=goal-directed') && location.hash.includes('l=6')"
    )
    other = browser.new_page()
    other.goto(page.url)
    assert shown_bits(other) == shown
    assert other.locator("#kind").input_value() == "goal-directed"
    assert other.locator("#slack").input_value() == "6"
    other.close()
    page.locator("#keep").click()
    expect(page.locator("#python")).to_contain_text("kind='goal-directed', slack=6")
    expect(page.locator("#command")).to_contain_text("--kind goal-directed --slack 6")
    page.keyboard.press("Escape")
    page.locator("#undo").click()
    page.locator("#undo").click()
    assert page.locator("#kind").input_value() == "open-loop"


def test_what_a_link_has_wrong_is_said(page: Page):
    page.evaluate("location.hash = location.hash.replace(/&k=[^&]*/, '') + '&k=best&g=7'")
    expect(
        page.get_by_text("its kind of empowerment “best” is unknown, and open-loop is used")
    ).to_be_visible()
    assert page.locator("#kind").input_value() == "open-loop"
