"""Tasks on a Ray cluster."""

import logging
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

# Read when Ray is imported: no usage is reported, and workers import what is installed where they
# run.
os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
os.environ.setdefault("RAY_ENABLE_UV_RUN_RUNTIME_ENV", "0")

import ray
from ray.cloudpickle.cloudpickle import CloudPickler
from ray.exceptions import RayError, RayTaskError

from habilis.tasks.shared import packed, unpacked
from habilis.tasks.store import first_line
from habilis.tasks.task import Arrays, Done, Executor, Stopped, Task

LOCAL = "local"
RETRIES = 10
"""How often a task whose worker or node is lost is run again."""

_LOOK = 0.5  # seconds between two looks at whether to stop


@contextmanager
def on_ray(address: str) -> Iterator[Executor[Task]]:
    """An executor on a cluster, each task on one processor of it.

    A task whose worker or node is lost is run again elsewhere. Results are handed over as they
    come, so that none is lost with this process either. What tasks share goes into the cluster's
    object store, from which each node takes it once.

    Args:
        address: of the cluster's head, as HOST:PORT; "auto" for the one this machine is part of;
            "local" to start one on this machine for as long as the executor is open.

    Returns:
        A context within which this process is connected to the cluster.

    Raises:
        ValueError: there is no cluster; or, when it is used, it is lost, a task fails, or its
            workers are lost again and again.
    """
    try:
        ray.init(
            address=address,
            include_dashboard=False if address == LOCAL else None,
            log_to_driver=False,
            logging_level=logging.ERROR,
        )
    except Exception as error:  # Ray raises a plain Exception if a node starts too slowly
        raise ValueError(
            f"{address}: no Ray cluster can be reached there ({first_line(error)}); start one by "
            "ray start --head, or give --ray local"
        ) from None
    try:
        yield _Cluster()
    except RayError as error:
        raise ValueError(
            f"{address}: the Ray cluster is lost ({first_line(error)}); continue with --resume"
        ) from None
    finally:
        ray.shutdown()


@dataclass(eq=False)
class _Cluster:
    """The executor.

    Attributes:
        stored: references to what tasks share, by key, of the last call.
    """

    stored: dict[str, ray.ObjectRef] = field(default_factory=dict)

    def __call__(self, tasks: Sequence[Task], done: Done, stopped: Stopped) -> None:
        remote = ray.remote(num_cpus=1, max_retries=RETRIES)(_computed)
        waiting = list(reversed(tasks))
        running: dict[ray.ObjectRef, Task] = {}
        used: dict[str, ray.ObjectRef] = {}
        try:
            while (waiting or running) and not stopped():
                # Enough to keep all processors of the cluster, as it is now, busy.
                room = 2 * int(ray.cluster_resources().get("CPU", 1))
                while waiting and len(running) < room:
                    task = waiting.pop()
                    content, values = packed(task, CloudPickler)
                    for key, one in values.items():
                        if key not in used:
                            used[key] = self.stored.get(key) or ray.put(one.value)
                    running[remote.remote(content, {key: used[key] for key in values})] = task
                for finished in ray.wait(list(running), timeout=_LOOK)[0]:
                    task = running.pop(finished)
                    done(task.name, _result(finished, task))
        finally:  # also where a task fails: nobody waits for the others any more
            for reference in running:
                ray.cancel(reference, force=True)
            self.stored = used


def _result(finished: ray.ObjectRef, task: Task) -> Arrays:
    try:
        return ray.get(finished)
    except RayTaskError as error:
        raise ValueError(f"{task.label}: {error.cause}") from None
    except RayError as error:
        raise ValueError(
            f"{task.label}: was lost {RETRIES + 1} times on the cluster "
            f"({type(error).__name__}); check its nodes, and continue with --resume"
        ) from None


def _computed(content: bytes, references: dict[str, ray.ObjectRef]) -> Arrays:
    return unpacked(content, lambda key: _value(references[key])).run()


@lru_cache(2)
def _value(reference: ray.ObjectRef) -> Any:
    """A shared value: the process keeps the last ones; their arrays are in its node's store."""
    return ray.get(reference)
