"""Answers to requests about trainings and trained runs."""

import contextlib
import time
from pathlib import Path

from msgspec import UNSET

from habilis.extras import check_installed
from habilis.studio.clients import Client
from habilis.studio.limits import LISTED
from habilis.studio.messages import one_line, shown
from habilis.studio.pool import StepError
from habilis.studio.protocol import requests
from habilis.studio.protocol.answers import (
    CurveAnswer,
    RunAnswer,
    TrainAnswer,
    TrainingsAnswer,
)
from habilis.studio.scene_requests import Pools
from habilis.studio.scenes import AnyScene, of_a_map
from habilis.studio.training_jobs import Training, Trainings

_INTERVAL = 1.0  # seconds between two updates of the curve


async def train(
    pools: Pools, trainings: Trainings, client: Client, request: requests.Train, scene: AnyScene
) -> None:
    """Trains, and sends the curve while it grows."""
    check_installed("learn")
    pools.learning.start()
    await _followed(pools, client, request.id, trainings.begin(of_a_map(scene), request.settings))


async def follow(
    pools: Pools, trainings: Trainings, client: Client, request: requests.Follow
) -> None:
    """Goes on with the answers of a training, after its page has been loaded again."""
    training = trainings.under_way.get(request.name)
    if training is None:
        raise ValueError(f"no training {shown(request.name)} is under way; it may have ended")
    await _followed(pools, client, request.id, training)


async def _followed(pools: Pools, client: Client, number: int, training: Training) -> None:
    client.trainings[number] = training
    try:
        await _train(pools, client, number, training)
    finally:
        del client.trainings[number]


async def _train(pools: Pools, client: Client, number: int, training: Training) -> None:
    updated, share = float("-inf"), 0.0
    await client.answer(TrainAnswer(id=number, progress=share, name=training.name))
    async with contextlib.aclosing(training.news()) as news:
        async for report in news:
            if "error" in report:
                raise ValueError(report["error"])
            share = report.get("share", share)
            if "share" in report and time.monotonic() - updated >= _INTERVAL:
                updated = time.monotonic()
                try:
                    curve = await client.step(pools.learning, "curve", folder=str(training.folder))
                except StepError:  # there is no checkpoint yet
                    continue
                speed = report["steps_per_second"]
                part = {"share": share, "steps_per_second": speed, **curve}
                await client.pass_on(TrainAnswer, number, part)
    try:
        curve = await client.step(pools.learning, "curve", folder=str(training.folder))
    except StepError:
        raise ValueError(
            "stopped before the first checkpoint: nothing is kept; train for longer"
        ) from None
    done = {"name": training.name, "runs": training.config.runs} | {
        name: curve[name] for name in ("converged_at", "best_return")
    }
    await client.pass_on(TrainAnswer, number, {"share": share, "done": done, **curve})


async def listed(
    pools: Pools, trainings: Trainings, client: Client, request: requests.Trainings
) -> None:
    """All trainings with a folder, from any page; damaged ones with their error."""
    names = trainings.names()
    left_out = max(len(names) - LISTED, 0)
    await client.answer(TrainingsAnswer(id=request.id, names=names[:LISTED], left_out=left_out))
    for name in names[:LISTED]:
        under_way = name in trainings.under_way
        try:
            folder = str(trainings.folder / name)
            found = await client.step(pools.learning, "kept", folder=folder)
        except StepError as error:
            found = {"error": one_line(error)}
        kept = {"name": name, "under_way": under_way} | found
        await client.pass_on(TrainingsAnswer, request.id, {"kept": kept})


async def curve(
    pools: Pools, trainings: Trainings, client: Client, request: requests.Curve
) -> None:
    """The learning curve of a training so far."""
    folder = trainings.path(request.name)
    found = await client.step(pools.learning, "curve", folder=str(folder))
    await client.pass_on(CurveAnswer, request.id, found)


async def run(
    pools: Pools, trainings: Trainings, folder: Path | None, client: Client, request: requests.Run
) -> None:
    """The policy, values and an episode of one run of a folder."""
    if request.name is not UNSET:
        folder = trainings.path(request.name)
    if folder is None:
        raise ValueError("there is no run to show; give the name of a training")
    at = None if request.placement is UNSET else request.placement
    asked = {"folder": str(folder), "index": request.index, "at": at}
    await client.pass_on(RunAnswer, request.id, await client.step(pools.learning, "view", **asked))
