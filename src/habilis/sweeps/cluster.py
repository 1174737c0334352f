"""Tasks on a Ray cluster."""

import logging
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

# Read when Ray is imported: nothing is reported to anyone, and workers import what is installed
# where they are.
os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
os.environ.setdefault("RAY_ENABLE_UV_RUN_RUNTIME_ENV", "0")

import ray
from ray.exceptions import RayError, RayTaskError

from habilis.sweeps.sweep import Executor, Stopped
from habilis.sweeps.tasks import Done, Outcomes, Task, run_task

LOCAL = "local"
RETRIES = 10
"""How often a task is run again whose worker or node is lost, before the sweep is given up."""

_LOOK = 0.5  # seconds between two looks at whether to stop


@contextmanager
def on_ray(address: str) -> Iterator[Executor]:
    """An executor on a cluster, each task on one processor of it.

    A task whose worker or node is lost is run again elsewhere. What is finished is handed over as
    it comes, so that nothing of it is lost with this process either: whoever starts the sweep
    again goes on.

    Args:
        address: of the cluster's head, as HOST:PORT; "auto" for the one this machine is part of;
            "local" to start one on this machine for as long as the sweep lasts.

    Raises:
        ValueError: there is no cluster; or, when it is used, it is lost, a task cannot be trained,
            or its workers are lost again and again.
    """
    try:
        ray.init(
            address=address,
            include_dashboard=False if address == LOCAL else None,
            log_to_driver=False,
            logging_level=logging.ERROR,
        )
    except Exception as error:  # which is what Ray raises, no more, if a node starts too slowly
        raise ValueError(
            f"{address}: no Ray cluster can be reached there ({_first_line(error)}); start one by "
            "ray start --head, or give --ray local"
        ) from None
    try:
        yield _run
    except RayError as error:
        raise ValueError(
            f"{address}: the Ray cluster is lost ({_first_line(error)}); go on with --resume"
        ) from None
    finally:
        ray.shutdown()


def _run(tasks: Sequence[Task], done: Done, stopped: Stopped) -> None:
    remote = ray.remote(num_cpus=1, max_retries=RETRIES)(_train)
    waiting = list(reversed(tasks))
    running: dict[ray.ObjectRef, Task] = {}
    while (waiting or running) and not stopped():
        # Enough to keep all processors busy, as the cluster is now.
        room = 2 * int(ray.cluster_resources().get("CPU", 1))
        while waiting and len(running) < room:
            task = waiting.pop()
            running[remote.remote(task)] = task
        for finished in ray.wait(list(running), timeout=_LOOK)[0]:
            task = running.pop(finished)
            try:
                outcomes = ray.get(finished)
            except RayTaskError as error:
                raise ValueError(f"{task.world.name}: {error.cause}") from None
            except RayError as error:
                raise ValueError(
                    f"{task.world.name}: a task was lost {RETRIES + 1} times on the cluster "
                    f"({type(error).__name__}); look after its nodes, and go on with --resume"
                ) from None
            done(task, outcomes)
    for reference in running:
        ray.cancel(reference, force=True)


def _train(task: Task) -> Outcomes:
    return run_task(task)


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
