"""Which tool for which object: every pair of them, alone in the scene's world."""

import asyncio
from dataclasses import dataclass
from math import isfinite
from typing import Any

from habilis.analysis.pairs import pairs as measured
from habilis.empowerment.methods import Exact
from habilis.studio.clients import Client
from habilis.studio.limits import GIB, PAIR, SECONDS
from habilis.studio.messages import one_line
from habilis.studio.pool import Pool, StepError
from habilis.studio.protocol import requests
from habilis.studio.protocol.answers import PairsAnswer, PairTool
from habilis.studio.scenes import AnyScene, Scene, of_a_map
from habilis.worlds.world import NO_TOOL

_SETTLED = 0.1  # seconds without an edit before a computation that an edit would cancel
_NOISY = 20.0  # seconds, by an estimate, for a pair in a stochastic world


@dataclass(frozen=True)
class Row:
    """A tool to compare.

    Attributes:
        name: of the world's own tool, or the kind of another.
        kind: of the tool; "none" is the bare agent.
        acts: all that its effect depends on.
    """

    name: str
    kind: str
    acts: tuple[Any, ...]


def rows_of(scene: Scene, tools: tuple[str, ...]) -> list[Row]:
    """The world's own tools, then all others, then none.

    Args:
        scene: the world; one without a place for a tool has only the bare agent.
        tools: the kinds that the studio knows.
    """
    own = [scene.world.tools[of] for of in scene.listed.tools]
    rows = [Row(tool.name, tool.kind, (tool.kind, tool.slip, tool.reading)) for tool in own]
    if scene.world.tool_cell is not None:
        here = {name for row in rows for name in (row.name, row.kind)}
        rows += [Row(kind, kind, (kind, 0.0, None)) for kind in tools if kind not in here]
    return [*rows, Row(NO_TOOL, NO_TOOL, ())]


def pair(scene: Scene, tool: str, object: str) -> dict[str, Any]:
    """The measures of one pair, a step of a worker.

    Raises:
        ValueError: the map is too large, or the tool can never be in hand.
    """
    free = len(scene.world.free_cells)
    placements = free**2 * (1 if tool == NO_TOOL else 4)
    if placements > PAIR:
        raise ValueError(
            f"up to {placements:,} placements are too many to compare while you draw; make the "
            f"map smaller (up to {PAIR:,}), or use habilis compare --pairs"
        )
    method = Exact(threads=1, max_gib=GIB, max_seconds=_NOISY if scene.is_stochastic else SECONDS)
    found = measured(scene.world, horizon_of(scene), [tool], [object], scene.slip, method=method)
    latency, median = float(found.latency[0, 0]), float(found.median_latency[0, 0])
    reliability = float(found.reliability[0, 0])
    return {
        "averages": found.averages[:, 0, 0].tolist(),
        "range": int(found.range[0, 0]),
        "latency": latency if isfinite(latency) else None,
        "median_latency": median if isfinite(median) else None,
        "persistence": float(found.persistence[0, 0]),
        "reliability": reliability if isfinite(reliability) else None,
    }


def horizon_of(scene: Scene) -> int:
    """The largest number of actions: a comparison begins with one."""
    return max(scene.horizon, 1)


async def answer(
    slow: Pool, tools: tuple[str, ...], client: Client, request: requests.Pairs, asked: AnyScene
) -> None:
    """Sends the names of tools and objects, then their pairs one by one."""
    scene = of_a_map(asked)
    rows = rows_of(scene, tools)
    objects = [scene.world.objects[of] for of in scene.listed.objects]
    await client.answer(
        PairsAnswer(
            id=request.id,
            tools=[PairTool(row.name, row.kind) for row in rows],
            objects=[thing.name for thing in objects],
            horizon=horizon_of(scene),
        )
    )
    await asyncio.sleep(_SETTLED)
    known: dict[object, dict[str, Any]] = {}  # things of the same kinds have the same values
    for at, row in enumerate(rows):
        for of, thing in enumerate(objects):
            key = row.acts, thing.kind
            if key not in known:
                try:
                    known[key] = await client.step(
                        slow, "pair", scene=scene, tool=row.name, object=thing.name
                    )
                except StepError as error:
                    known[key] = {"why": one_line(error)}
            found = {"pair": {"tool": at, "object": of, **known[key]}}
            await client.pass_on(PairsAnswer, request.id, found)
