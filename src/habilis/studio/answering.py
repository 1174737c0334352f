"""How each request is answered, in steps."""

import asyncio
import time
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any

from habilis.processors import processors
from habilis.studio.clients import Client
from habilis.studio.messages import Request, one_line
from habilis.studio.pool import Pool, StepError
from habilis.studio.scenes import Scene
from habilis.worlds.world import NO_TOOL

_SETTLED = 0.1  # seconds without an edit, before averages are begun that the next one would end
_STRETCH = 0.1  # seconds of a step that is part of a longer computation
_AT_ONCE = 8  # processes of a pool at most
_QUICK_PATIENCE, _SLOW_PATIENCE = 0.3, 1.0

Grid = list[list[float | None]]


@dataclass(frozen=True)
class Pools:
    """The processes that compute.

    What somebody waits for with the mouse in hand has processes of its own, and goes first.

    Attributes:
        quick: for what takes milliseconds: a landscape, the futures of a cell, a step of play.
        slow: for what may take longer: averages over all placements, plans, and all where chance
            has a part.
        learning: for what was learned. It is started when it is first needed, and none without the
            extra `habilis[learn]`.
    """

    quick: Pool
    slow: Pool
    learning: Pool

    @classmethod
    def made(cls) -> "Pools":
        at_once = min(processors(), _AT_ONCE)
        steps = "habilis.studio.work"
        return cls(
            Pool(steps, at_once, _QUICK_PATIENCE),
            Pool(steps, at_once, _SLOW_PATIENCE, background=True),
            Pool("habilis.studio.trained", 1, _SLOW_PATIENCE, background=True),
        )

    def start(self) -> None:
        self.quick.start()
        self.slow.start()

    async def close(self) -> None:
        await asyncio.gather(*(pool.close() for pool in (self.quick, self.slow, self.learning)))

    def for_one(self, scene: Scene) -> Pool:
        """For the value of one state of a scene."""
        return self.slow if scene.slip else self.quick


async def measure(pools: Pools, tools: tuple[str, ...], client: Client, request: Request) -> None:
    """The landscape as soon as it is there, then the tools' averages one by one."""
    scene = _scene(request)
    await _landscape(pools, client, request.id, scene)
    await _averages(pools, tools, client, request.id, scene)


async def landscape(pools: Pools, client: Client, request: Request) -> None:
    """The landscape alone, perhaps with things elsewhere than on the map."""
    scene, at = _scene(request), request.values.get("placement")
    await _landscape(pools, client, request.id, scene if at is None else scene.with_things(at))


async def _landscape(pools: Pools, client: Client, number: int, scene: Scene) -> None:
    began = time.perf_counter()
    if scene.slip:
        bits = await _stretches(pools, client, number, scene)
    else:
        bits = (await client.step(pools.quick, "landscape", scene=scene))["bits"]
    seconds = time.perf_counter() - began
    least, most = (min(bits), max(bits)) if bits else (None, None)
    await client.tell(number, landscape=_grid(scene, bits), least=least, most=most, seconds=seconds)


async def _stretches(pools: Pools, client: Client, number: int, scene: Scene) -> list[float]:
    """A landscape where chance has a part, some cells at a time."""
    bits: list[float] = []
    places, cells = len(scene.agent_places()), 1
    while len(bits) < places:
        began = time.perf_counter()
        end = min(len(bits) + cells, places)
        found = await client.step(pools.slow, "stretch", scene=scene, first=len(bits), end=end)
        bits += found["bits"]
        seconds = time.perf_counter() - began
        cells = max(1, min(int(cells * _STRETCH / seconds), 2 * cells))
        await client.tell(number, progress=len(bits) / places)
    return bits


async def _averages(
    pools: Pools, tools: tuple[str, ...], client: Client, number: int, scene: Scene
) -> None:
    """What each tool is worth on average; where that cannot be said, why."""
    await asyncio.sleep(_SETTLED)
    if scene.world.tool_cell is None:
        tools = ()
    told = False
    # The tool in hand first: it is what is looked at.
    for tool in sorted(tools, key=lambda tool: tool != scene.world.tool):
        found = await _average(tool, client.step(pools.slow, "average", scene=scene, tool=tool))
        told |= NO_TOOL in found["averages"]
        await client.tell(number, **found)
    if not told:
        work = client.step(pools.slow, "average_without", scene=scene)
        await client.tell(number, **await _average(NO_TOOL, work))


async def _average(tool: str, work: Coroutine[Any, Any, Any]) -> dict[str, Any]:
    try:
        return await work
    except StepError as error:
        return {"averages": {tool: None}, "verdicts": {}, "why": one_line(error)}


async def futures(pools: Pools, client: Client, request: Request) -> None:
    scene = _scene(request)
    agent = request.values["agent"]
    found = await client.step(pools.for_one(scene), "choices", scene=scene, agent=agent)
    await client.tell(request.id, **found)


async def solve(pools: Pools, client: Client, request: Request) -> None:
    await client.tell(request.id, **await client.step(pools.slow, "plan", scene=_scene(request)))


async def step(pools: Pools, client: Client, request: Request) -> None:
    scene, values = _scene(request), request.values
    found = await client.step(
        pools.for_one(scene), "step", scene=scene, at=values["placement"], action=values["action"]
    )
    await client.tell(request.id, **found)


ANSWERS: dict[str, Callable[[Pools, Client, Request], Coroutine[Any, Any, None]]] = {
    "landscape": landscape,
    "futures": futures,
    "solve": solve,
    "step": step,
}


def _scene(request: Request) -> Scene:
    assert request.scene is not None, "its message has one"
    return request.scene


def _grid(scene: Scene, bits: list[float]) -> Grid:
    """Values of the agent's cells as rows of the map, `None` where the agent cannot be."""
    rows: Any = [[None] * scene.world.width for _ in range(scene.world.height)]
    for (row, column), value in zip(scene.agent_places(), bits, strict=True):
        rows[row][column] = value
    return rows
