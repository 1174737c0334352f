"""Answers to requests about trainings and trained runs."""

import time
from pathlib import Path
from typing import Any

from habilis.extras import check_installed
from habilis.studio.clients import Client
from habilis.studio.limits import LISTED
from habilis.studio.messages import Request, one_line
from habilis.studio.pool import StepError
from habilis.studio.scene_requests import Pools
from habilis.studio.training_jobs import Training, Trainings

_INTERVAL = 1.0  # seconds between two updates of the curve


async def train(pools: Pools, trainings: Trainings, client: Client, request: Request) -> None:
    """Trains, and sends the curve while it grows."""
    assert request.scene is not None, "validated with the message"
    check_installed("learn")
    pools.learning.start()
    with trainings.one(request.scene, dict(request.values["settings"])) as training:
        client.trainings[request.id] = training
        try:
            await _train(pools, client, request.id, training)
        finally:
            del client.trainings[request.id]


async def _train(pools: Pools, client: Client, number: int, training: Training) -> None:
    updated, share = float("-inf"), 0.0
    await client.answer(number, progress=share, name=training.name)
    async for report in training.reports():
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
            await client.answer(number, share=share, steps_per_second=speed, **curve)
    try:
        curve = await client.step(pools.learning, "curve", folder=str(training.folder))
    except StepError:
        raise ValueError(
            "stopped before the first checkpoint: nothing is kept; train for longer"
        ) from None
    done = {"name": training.name, "runs": training.config.runs} | {
        name: curve[name] for name in ("converged_at", "best_return")
    }
    await client.answer(number, share=share, done=done, **curve)


async def listed(pools: Pools, trainings: Trainings, client: Client, request: Request) -> None:
    """All trainings with a folder, from any page; damaged ones with their error."""
    names = trainings.names()
    left_out = max(len(names) - LISTED, 0)
    await client.answer(request.id, names=names[:LISTED], left_out=left_out)
    for name in names[:LISTED]:
        under_way = name in trainings.under_way
        try:
            folder = str(trainings.folder / name)
            found = await client.step(pools.learning, "kept", folder=folder)
        except StepError as error:
            found = {"error": one_line(error)}
        await client.answer(request.id, kept={"name": name, "under_way": under_way} | found)


async def curve(pools: Pools, trainings: Trainings, client: Client, request: Request) -> None:
    """The learning curve of a training so far."""
    folder = trainings.path(request.values["name"])
    await client.answer(
        request.id, **await client.step(pools.learning, "curve", folder=str(folder))
    )


async def run(
    pools: Pools, trainings: Trainings, folder: Path | None, client: Client, request: Request
) -> None:
    """The policy, values and an episode of one run of a folder."""
    values: dict[str, Any] = {"index": request.values["index"]}
    if "name" in request.values:
        folder = trainings.path(request.values["name"])
    if folder is None:
        raise ValueError("there is no run to show; give the name of a training")
    if request.values.get("placement"):
        values["at"] = request.values["placement"]
    found = await client.step(pools.learning, "view", folder=str(folder), **values)
    await client.answer(request.id, **found)
