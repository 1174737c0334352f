"""The studio's page in a real browser, and what the library says about what it shows."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from playwright.sync_api import Page, expect

from habilis.analysis.landscape import landscape
from habilis.empowerment.sensors import Sensor
from habilis.worlds.world import Cell, World

CHROMIUM = Path("/usr/bin/chromium")
OPTIONS = [
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
]
PICTURES = Path(__file__).parents[2] / "test-output" / "studio"
"""Where the pictures of the views are kept, to be looked at."""

STUCK = 300_000
"""Milliseconds after which what has not come is not going to."""

WORLD, LANDSCAPE = "#world-board", "#landscape-board"
_BITS = re.compile(r"row (\d+), column (\d+): (?:.*, )?(\S+) bits")


@contextmanager
def served(*arguments: str) -> Iterator[str]:
    """A studio of its own; yields its address, without the tour of a first visit."""
    command = [sys.executable, "-m", "habilis", "studio", "--no-browser", "--json"]
    environment = os.environ | {"PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(
        [*command, *arguments], stdout=subprocess.PIPE, text=True, env=environment
    ) as process:
        try:
            assert process.stdout is not None
            yield without_tour(json.loads(process.stdout.readline())["address"])
        finally:
            process.terminate()


def without_tour(address: str) -> str:
    """The address of a page that does not offer the tour."""
    return f"{address}{'&' if '?' in address else '?'}tour=0"


def settled(page: Page) -> None:
    """Waits until the landscape is of the scene that is shown."""
    page.wait_for_selector(f"{LANDSCAPE}[data-pending=false]", timeout=STUCK)


def middle(page: Page, board: str, cell: Cell) -> tuple[float, float]:
    """Where on the screen the middle of a cell is."""
    row, column = cell
    place = page.locator(f"{board}-{row}-{column}")
    box = place.bounding_box() or place.bounding_box()  # none if it has just been drawn anew
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def drag(page: Page, board: str, *cells: Cell) -> None:
    """Presses the mouse in the first cell, and lets it go in the last."""
    page.mouse.move(*middle(page, board, cells[0]))
    page.mouse.down()
    for cell in cells[1:]:
        page.mouse.move(*middle(page, board, cell), steps=5)
    page.mouse.up()


def shown_bits(page: Page) -> dict[Cell, float]:
    """The values that the page shows, by their cells."""
    settled(page)
    labels = page.locator(f"{LANDSCAPE} [role=gridcell]").evaluate_all(
        "cells => cells.map((cell) => cell.getAttribute('aria-label'))"
    )
    found = (_BITS.fullmatch(label) for label in labels)
    return {(int(m[1]), int(m[2])): float(m[3]) for m in found if m}


def true_bits(
    world: World, horizon: int, sensor: Sensor = "object", **options
) -> dict[Cell, float]:
    """The library's values, to the two decimals shown."""
    values = landscape(world, horizon, sensor, **options).values
    return {
        (int(row), int(column)): float(f"{values[row, column]:.2f}")
        for row, column in np.argwhere(np.isfinite(values))
    }


def shown_averages(page: Page) -> dict[str, float]:
    """The tools' averages that the page shows."""
    page.wait_for_function(
        "() => [...document.querySelectorAll('.bars [data-tool]')]"
        ".every((row) => row.dataset.fresh === 'true')",
        timeout=STUCK,
    )
    rows = page.locator(".bars [data-tool]").evaluate_all(
        "rows => rows.map((row) => [row.dataset.tool, row.querySelector('.bits').textContent])"
    )
    return {tool: float(bits) for tool, bits in rows}


def map_text(page: Page) -> str:
    """The page's map text."""
    page.locator("#map-text").click()
    area = page.locator("#text")
    expect(area).not_to_have_value("", timeout=STUCK)
    text = area.input_value()
    page.keyboard.press("Escape")
    return text


def give_text(page: Page, text: str) -> None:
    """Writes a map in the dialog's field, once the dialog has come to rest, and submits it."""
    page.locator("#map-text").click()
    expect(page.locator("#text")).not_to_have_value("", timeout=STUCK)
    page.locator("#text").fill(text)
    page.locator("#use-map").click()


def take_in(page: Page, text: str) -> None:
    """Gives the page a map as text; the page asks the library before it shows it."""
    give_text(page, text)
    expect(page.locator("dialog")).to_have_count(0, timeout=STUCK)


def keep_picture(page: Page, name: str) -> Path:
    """Keeps a picture of the page as it is now."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    page.evaluate("document.activeElement?.blur()")
    page.wait_for_timeout(300)  # until animations have ended
    page.screenshot(path=PICTURES / f"{name}.png")
    return PICTURES / f"{name}.png"
