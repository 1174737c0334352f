"""The studio: from an edit of a world to its landscape, as a page waits for it."""

import asyncio
import json
import random
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from websockets.asyncio.client import ClientConnection, connect

from habilis.benchmarks import Result
from habilis.benchmarks.counting import room
from habilis.benchmarks.studio_page import edits
from habilis.processors import processors

SIDE, HORIZON = 10, 6
CLIENTS = 50
_EDITS, _ROUNDS, _SECONDS = 200, 5, 5.0


def results() -> list[Result]:
    """Milliseconds from an edit to its landscape: in a browser, one page alone, fifty at once.

    An edit puts a wall on some floor cell, or takes it away. The averages of the tools, which come
    after the landscape, are overtaken by the next edit.
    """
    with serving() as page:
        address = page.replace("http:", "ws:") + "ws"
        alone = asyncio.run(_alone(address))
        together = asyncio.run(_together(address))
        served = asyncio.run(_busy(address))
        seen = edits(page, HORIZON)
    world = f"{SIDE}x{SIDE}, h up to {HORIZON}"
    crowd = f"{CLIENTS} pages edit in one moment, {processors()} processors"
    in_page = []
    if seen is not None:
        drawn = f"10x10, h {HORIZON}, from the press of the mouse to the picture, Chromium"
        in_page = [
            Result("an edit to what the page shows, median", *_at(seen, 50), drawn),
            Result("an edit to what the page shows, 95th percentile", *_at(seen, 95), drawn),
            Result("an edit to what the page shows, slowest", *_at(seen, 100), drawn),
        ]
    return [
        *in_page,
        Result("an edit to its landscape, median", *_at(alone, 50), world),
        Result("an edit to its landscape, 95th percentile", *_at(alone, 95), world),
        Result(f"{CLIENTS} pages: median", *_at(together, 50), crowd),
        Result(f"{CLIENTS} pages: 95th percentile", *_at(together, 95), crowd),
        Result("edits answered", sum(served) / _SECONDS, "a second", f"{CLIENTS} pages, no pauses"),
        Result(
            "fewest over most edits answered",
            min(served) / max(served),
            "",
            f"of {CLIENTS} pages that all edit without a pause; fair: 1",
        ),
    ]


@contextmanager
def serving() -> Iterator[str]:
    """A studio in a process of its own; yields its address."""
    command = [sys.executable, "-m", "habilis", "studio", "--no-browser", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        try:
            yield json.loads(process.stdout.readline())["address"]
        finally:
            process.terminate()


def _at(seconds: list[float], percentile: float) -> tuple[float, str]:
    return 1e3 * float(np.percentile(seconds, percentile)), "ms"


class _Page:
    """Edits one world after the other."""

    def __init__(self, socket: ClientConnection, seed: int):
        self.socket, self.random, self.number = socket, random.Random(seed), 0
        self.rows = [list(row) for row in room(SIDE).rows]

    async def edit(self, horizon: int | None = None) -> float:
        """Seconds from an edit to its landscape."""
        row, column = self.random.choice(
            [(r, c) for r in range(SIDE) for c in range(SIDE) if self.rows[r][c] in ".#"]
        )
        self.rows[row][column] = "#" if self.rows[row][column] == "." else "."
        scene = {
            "map": "\n".join("".join(row) for row in self.rows),
            "tool": self.random.choice(["picker", "broom"]),
            "sensor": self.random.choice(["object", "state"]),
            "horizon": self.random.randint(1, HORIZON) if horizon is None else horizon,
        }
        self.number += 1
        began = time.perf_counter()
        await self.socket.send(json.dumps({"id": self.number, "do": "measure", "scene": scene}))
        while True:
            answer = json.loads(await self.socket.recv())
            if answer["id"] == self.number and "landscape" in answer:
                return time.perf_counter() - began
            assert "error" not in answer, answer


async def _opened(address: str, seed: int) -> _Page:
    socket = await connect(address, compression=None, open_timeout=None, ping_interval=None)
    await socket.recv()
    return _Page(socket, seed)


async def _alone(address: str) -> list[float]:
    page = await _opened(address, 0)
    await page.edit()
    seconds = [await page.edit() for _ in range(_EDITS)]
    await page.socket.close()
    return seconds


async def _together(address: str) -> list[float]:
    """All edit at once, again when all have been answered."""
    pages = [await _opened(address, seed) for seed in range(CLIENTS)]
    seconds = []
    for _ in range(_ROUNDS):
        seconds += await asyncio.gather(*(page.edit() for page in pages))
    await asyncio.gather(*(page.socket.close() for page in pages))
    return seconds


async def _busy(address: str) -> list[int]:
    """How many edits each has answered when all ask for the same without a pause."""
    pages = [await _opened(address, seed) for seed in range(CLIENTS)]
    end = time.perf_counter() + _SECONDS

    async def edits(page: _Page) -> int:
        count = 0
        while time.perf_counter() < end:
            await page.edit(HORIZON)
            count += 1
        return count

    counts = await asyncio.gather(*(edits(page) for page in pages))
    await asyncio.gather(*(page.socket.close() for page in pages))
    return counts
