"""Answers to requests for what is kept and shared: films and code."""

from collections.abc import Sequence
from pathlib import Path

import msgspec
from msgspec import UNSET

from habilis.studio import as_code, as_code_of_board
from habilis.studio.as_code import Written
from habilis.studio.board_scenes import BoardScene
from habilis.studio.clients import Client
from habilis.studio.drawn_worlds import world_of
from habilis.studio.protocol import requests
from habilis.studio.protocol.answers import CodeAnswer, FilmAnswer
from habilis.studio.protocol.scenes import Drawn
from habilis.studio.scene_requests import Pools
from habilis.studio.scenes import AnyScene, Scene, of_a_map
from habilis.studio.training_jobs import Trainings
from habilis.worlds.world import NO_TOOL, World


async def film(pools: Pools, client: Client, request: requests.Film, scene: AnyScene) -> None:
    """A film of placements."""
    asked = {"scene": scene, "placements": request.placements}
    found = await client.step(pools.slow, "film", **asked)
    await client.pass_on(FilmAnswer, request.id, found)


async def code(
    pools: Pools,
    trainings: Trainings,
    folder: Path | None,
    source: str,
    tools: Sequence[str],
    client: Client,
    request: requests.Code,
    asked: AnyScene,
) -> None:
    """Code that computes what a view shows.

    Args:
        pools: the worker processes.
        trainings: those that a name can be of.
        folder: of the run that the studio was started with.
        source: of the board that the studio was started with.
        tools: the names of all tools.
        client, request, asked: as received.
    """
    if isinstance(asked, BoardScene):
        found = as_code_of_board.code(asked, source, request.view, request.placements)
        await client.answer(CodeAnswer(id=request.id, python=found.python, command=found.command))
        return
    scene = of_a_map(asked)
    if request.view in ("training", "run") and request.name is not UNSET:
        folder = trainings.path(request.name)
    if request.view == "landscape":
        found = as_code.landscape(scene, _drawn(request, scene, tools), request.tools)
    elif request.view == "pairs":
        found = as_code.pairs(scene, _drawn(request, scene, tools), request.tools)
    elif request.view == "game":
        path = [scene.where(placement) for placement in request.placements]
        found = as_code.game(scene, _drawn(request, scene, tools), path or [scene.placement])
    elif request.view == "training":
        found = await _training(pools, folder, tools, client, request, scene)
    elif folder is None:
        raise ValueError("there is no run to show; give the name of a training")
    else:
        start = scene.where(request.placements[0]) if request.placements else None
        found = as_code.run(folder, request.index, start)
    await client.answer(CodeAnswer(id=request.id, python=found.python, command=found.command))


async def _training(
    pools: Pools,
    folder: Path | None,
    tools: Sequence[str],
    client: Client,
    request: requests.Code,
    scene: Scene,
) -> Written:
    """A training that has a folder, or one with the settings of the form."""
    if request.settings is not UNSET:
        settings = msgspec.to_builtins(request.settings)
        return as_code.training(scene.world, settings | {"slip": scene.slip})
    if request.name is UNSET or folder is None:
        raise ValueError("code for a training has no settings; give them, or the training's name")
    kept = await client.step(pools.learning, "kept", folder=str(folder))
    drawn = msgspec.convert(kept["drawn"], Drawn)
    return as_code.training(world_of(drawn, tools, "map"), kept["config"])


def _drawn(request: requests.Code, scene: Scene, tools: Sequence[str]) -> World:
    """The scene's world with its tools, if the agent uses none."""
    if request.scene.tool != NO_TOOL:
        return scene.world
    return Scene.of(msgspec.structs.replace(request.scene, tool=UNSET), tools).world
