"""Answers to requests about a scene."""

import asyncio
import time
from collections.abc import AsyncIterator, Callable, Coroutine
from dataclasses import dataclass
from typing import Any

from msgspec import UNSET

from habilis.processors import processors
from habilis.studio.clients import Client
from habilis.studio.drawn_worlds import drawn_of
from habilis.studio.estimates import Estimate, in_stretches, verdicts
from habilis.studio.limits import DRAWN, FEWEST, PATIENCE
from habilis.studio.messages import one_line
from habilis.studio.pool import Pool, StepError
from habilis.studio.protocol import requests
from habilis.studio.protocol.answers import (
    Answer,
    FuturesAnswer,
    LandscapeAnswer,
    MeasureAnswer,
    ReadAnswer,
    SolveAnswer,
    StepAnswer,
)
from habilis.studio.scenes import AnyScene, Scene, of_a_map
from habilis.worlds.grid import Cell
from habilis.worlds.world import NO_TOOL

_SETTLED = 0.1  # seconds without an edit before averages start, since an edit would cancel them
_LONGEST_ESTIMATE = 10.0  # seconds after which an estimate is final
_TRIAL = 10.0  # seconds before a landscape is estimated from what they did
_AT_ONCE = 8  # processes of a pool at most
_QUICK_PATIENCE, _SLOW_PATIENCE = 0.3, 1.0

Grid = list[list[float | None]]


@dataclass(frozen=True)
class Pools:
    """The worker processes.

    Interactive requests have processes of their own, and priority.

    Attributes:
        quick: for what takes milliseconds: a landscape, the futures of a cell, a step of play.
        slow: for what may take longer: averages over all placements, plans, and everything in a
            stochastic world.
        learning: for trained runs. It is started on first use, and never without the extra
            `habilis[learn]`.
    """

    quick: Pool
    slow: Pool
    learning: Pool

    @classmethod
    def made(cls) -> "Pools":
        at_once = min(processors(), _AT_ONCE)
        steps = "habilis.studio.scene_steps"
        return cls(
            Pool(steps, at_once, _QUICK_PATIENCE),
            Pool(steps, at_once, _SLOW_PATIENCE, background=True),
            Pool("habilis.studio.run_steps", 1, _SLOW_PATIENCE, background=True),
        )

    def start(self) -> None:
        self.quick.start()
        self.slow.start()

    async def close(self) -> None:
        await asyncio.gather(*(pool.close() for pool in (self.quick, self.slow, self.learning)))

    def for_one(self, scene: AnyScene) -> Pool:
        """For the value of one state of a scene."""
        return self.slow if scene.is_stochastic or scene.measured.needs_whole else self.quick


async def measure(
    pools: Pools, tools: tuple[str, ...], client: Client, request: requests.Measure, scene: AnyScene
) -> None:
    """Sends the landscape as soon as it is computed, then the tools' averages one by one."""
    await _landscape(pools, client, request.id, scene)
    if isinstance(scene, Scene):  # a board has no tools to compare
        await _averages(pools, tools, client, request.id, scene)


async def landscape(
    pools: Pools, client: Client, request: requests.Landscape, scene: AnyScene
) -> None:
    """Sends the landscape alone, optionally for another placement of the things."""
    at = request.placement
    await _landscape(pools, client, request.id, scene if at is UNSET else scene.with_things(at))


async def _landscape(pools: Pools, client: Client, number: int, scene: AnyScene) -> None:
    began = time.perf_counter()
    if scene.is_stochastic and not scene.measured.needs_whole:
        cells, bits, gaps = await _stretches(pools, client, number, scene)
    else:
        found = await client.step(pools.for_one(scene), "landscape", scene=scene)
        cells, bits, gaps = found["cells"], found["bits"], found["gap"]
    seconds = time.perf_counter() - began
    least, most = (min(bits), max(bits)) if bits else (None, None)
    await client.answer(
        LandscapeAnswer(
            id=number,
            landscape=_grid(scene, cells, bits),
            least=least,
            most=most,
            gap=max(gaps) if gaps else UNSET,
            seconds=seconds,
        )
    )


async def _stretches(
    pools: Pools, client: Client, number: int, scene: AnyScene
) -> tuple[list[Cell], list[float], list[float]]:
    """A landscape of a stochastic table, computed in chunks of cells, and its gaps if known.

    Raises:
        StepError: it would take too long.
    """
    gaps: list[float] = []

    async def step(first: int, end: int) -> list[float]:
        found = await client.step(pools.slow, "stretch", scene=scene, first=first, end=end)
        gaps.extend(found.get("gap", []))
        return found["bits"]

    began = time.perf_counter()
    bits: list[float] = []
    cells = (await client.step(pools.slow, "cells", scene=scene))["cells"]
    async for bits in in_stretches(len(cells), step):
        share, seconds = len(bits) / len(cells), time.perf_counter() - began
        slow = scene.measured.is_closed and share < 1 and seconds > _TRIAL
        if slow and seconds / share > PATIENCE:
            raise StepError(
                f"{scene.horizon} steps ahead take about {seconds / share / 60:.0f} minutes here; "
                "look fewer steps ahead, or observe a single thing"
            )
        await client.answer(Answer(id=number, progress=share))
    return cells, bits, gaps


async def _averages(
    pools: Pools, tools: tuple[str, ...], client: Client, number: int, scene: Scene
) -> None:
    """Sends the average with each tool, or the reason why there is none."""
    await asyncio.sleep(_SETTLED)
    if scene.world.tool_cell is None:
        tools = ()
    # The selected tool first, then none, with which it is compared.
    here = {tool.kind for tool in scene.world.tools} or {NO_TOOL}
    order = sorted([NO_TOOL, *tools], key=lambda tool: (tool not in here, tool != NO_TOOL))
    known: dict[str, Estimate] = {}
    for tool in order:
        try:
            async for average in _average(pools, client, scene, tool):
                known[tool] = average
                await client.answer(
                    MeasureAnswer(
                        id=number,
                        averages={tool: average.bits},
                        within={tool: average.within},
                        verdicts=verdicts(known),
                    )
                )
        except StepError as error:
            none: dict[str, float | None] = {tool: None}
            await client.answer(
                MeasureAnswer(id=number, averages=none, verdicts={}, why=one_line(error))
            )


async def _average(
    pools: Pools, client: Client, scene: Scene, tool: str
) -> AsyncIterator[Estimate]:
    """The average with a tool: exact or, if that takes too long, estimates that improve."""
    found = await client.step(pools.slow, "average", scene=scene, tool=tool)
    if found["bits"] is not None:
        yield Estimate(found["bits"], 0.0, found["some"])
        return

    async def step(first: int, end: int) -> list[float]:
        some = {"scene": scene, "tool": tool, "first": first, "end": end}
        return (await client.step(pools.slow, "sampled", **some))["bits"]

    began = time.perf_counter()
    async for bits in in_stretches(DRAWN, step):
        if len(bits) > 1:
            yield Estimate.of(bits)
        if len(bits) >= FEWEST and time.perf_counter() - began > _LONGEST_ESTIMATE:
            return


async def read(pools: Pools, client: Client, request: requests.Read, scene: AnyScene) -> None:
    world = of_a_map(scene).world
    await client.answer(ReadAnswer(id=request.id, drawn=drawn_of(world), text=world.text()))


async def futures(pools: Pools, client: Client, request: requests.Futures, scene: AnyScene) -> None:
    pool, agent = pools.for_one(scene), request.agent
    found = await client.step(pool, "choices", scene=scene, agent=agent)
    await client.pass_on(FuturesAnswer, request.id, found)


async def solve(pools: Pools, client: Client, request: requests.Solve, scene: AnyScene) -> None:
    at = None if request.placement is UNSET else request.placement
    found = await client.step(pools.slow, "plan", scene=scene, at=at)
    await client.pass_on(SolveAnswer, request.id, found)


async def step(
    pools: Pools,
    image: Callable[[int], str] | None,
    client: Client,
    request: requests.Step,
    scene: AnyScene,
) -> None:
    """Sends the effect of an action.

    Args:
        pools, client, request, scene: as of all requests.
        image: the picture of a state, if the scene's board is drawn by images.
    """
    pool, at = pools.for_one(scene), request.placement
    found = await client.step(pool, "step", scene=scene, at=at, action=request.action)
    if image is not None and "state" in found["placement"]:
        found["image"] = await asyncio.to_thread(image, found["placement"]["state"])
    await client.pass_on(StepAnswer, request.id, found)


ANSWERS: dict[type[requests.Request], Callable[..., Coroutine[Any, Any, None]]] = {
    requests.Landscape: landscape,
    requests.Read: read,
    requests.Futures: futures,
    requests.Solve: solve,
}


def _grid(scene: AnyScene, cells: list[Cell], bits: list[float]) -> Grid:
    """Values of the agent's cells as rows of the map, `None` where the agent cannot be."""
    rows: Any = [[None] * scene.width for _ in range(scene.height)]
    for (row, column), value in zip(cells, bits, strict=True):
        rows[row][column] = value
    return rows
