"""The empowerment of a table on a cluster, by tasks that take their time and leave a note."""

import os
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import habilis as hb
from habilis.empowerment.splitting import StatesTask
from habilis.tasks import kept_in, on_ray
from habilis.tasks.task import Arrays, Done, Stopped

HORIZON, SECONDS = 2, 0.2
HOLD = "hold"
"""A file beside the folder of the notes: as long as it is there no task ends."""


@dataclass(frozen=True)
class Slow:
    """A task that takes a while.

    Attributes:
        task: what it does then.
        notes: a folder in which it says where it ran, and where it found the table.
    """

    task: StatesTask
    notes: Path

    @property
    def name(self) -> str:
        return self.task.name

    @property
    def label(self) -> str:
        return self.task.label

    @property
    def size(self) -> float:
        return self.task.size

    def run(self) -> Arrays:
        import ray

        table: Any = self.task.table.value
        node = ray.get_runtime_context().get_node_id()
        place = f"{node} {os.getpid()} {id(table)} {table.transitions.data.flags.writeable}\n"
        with (self.notes / self.name).open("a") as file:
            file.write(place)
        time.sleep(SECONDS)
        while (self.notes.parent / HOLD).exists():
            time.sleep(0.05)
        return self.task.run()

    def rehearse(self) -> None:
        self.task.rehearse()

    def check(self, result: Arrays) -> None:
        self.task.check(result)


def main() -> None:
    """Arguments: address, table, folder of the tasks, folder of the notes."""
    address, table, work, notes = sys.argv[1:]
    with on_ray(address) as cluster:

        def slowly(tasks: Sequence[StatesTask], done: Done, stopped: Stopped) -> None:
            cluster([Slow(task, Path(notes)) for task in tasks], done, stopped)

        with kept_in(work, slowly) as executor:
            hb.empowerment(hb.TabularMDP.load(table), HORIZON, executor=executor)
