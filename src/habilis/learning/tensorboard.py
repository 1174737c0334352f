"""TensorBoard event files: a folder a run, `tensorboard/run-K`.

They are written from the metrics that checkpoints keep, and so agree with them: a session begins
them anew with all metrics up to the checkpoint that it goes on from, and adds to them whenever it
has saved one. None is lost or written twice, however the session before has ended.
"""

import math
import re
import struct
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from tensorboardX.proto import event_pb2, summary_pb2
from tensorboardX.record_writer import masked_crc32c
from tensorboardX.summary import hparams, text

from habilis.files import write_whole
from habilis.learning.jobs import Job
from habilis.learning.runs import Metrics

TAGS = {
    "episode/return": "episode_return",
    "episode/length": "episode_length",
    "episode/number": "episode",
    "learning/loss": "loss",
    "learning/entropy": "entropy",
    "intrinsic/bonus": "bonus",
    "intrinsic/beta": "beta",
    "speed/steps_per_second": "steps_per_second",
}
"""The fields of `Metrics` that are drawn, by their names in TensorBoard."""


_events: Any = event_pb2  # its classes are made when it is imported
_summaries: Any = summary_pb2
_OURS = re.compile(r"\.?events\.out\.tfevents\.(\d+)\.habilis(\.\w+)*$")


class EventFiles:
    """The event files of a session, over environment steps."""

    def __init__(self, job: Job, folder: Path):
        """Begins them anew, with all metrics there are.

        Raises:
            OSError: they cannot be written.
        """
        self._job = job
        self._paths: list[Path] = []
        self._written: list[int] = []
        for run, record in enumerate(job.records):
            place = folder / "tensorboard" / f"run-{run}"
            place.mkdir(parents=True, exist_ok=True)
            earlier = [path for path in place.iterdir() if _OURS.match(path.name)]
            # TensorBoard goes on to the file whose name comes last.
            number = max([int(time.time()), *(1 + _number(path) for path in earlier)])
            path = place / f"events.out.tfevents.{number}.habilis"
            noted = record.metrics()
            content = _records([*_head(job), *_scalars(noted)])
            write_whole(path, lambda file, content=content: file.write(content))
            for old in earlier:
                old.unlink()
            self._paths.append(path)
            self._written.append(len(noted))

    def add(self) -> None:
        """Adds the metrics that are new.

        Raises:
            OSError: they cannot be written.
        """
        for run, record in enumerate(self._job.records):
            noted = record.metrics()[self._written[run] :]
            if len(noted):
                with self._paths[run].open("ab") as file:
                    file.write(_records(_scalars(noted)))
                self._written[run] += len(noted)


def _number(path: Path) -> int:
    found = _OURS.match(path.name)
    return int(found[1]) if found else 0


def _head(job: Job) -> list[Any]:
    """The records before the metrics: the format, and the settings of the run."""
    now = time.time()
    settings = job.config.as_dict()
    rows = [f"| {name} | {value} |" for name, value in settings.items()]
    table = text("config", "\n".join(["| setting | value |", "|---|---|", *rows]))
    plain = {name: str(v) if isinstance(v, tuple) else v for name, v in settings.items()}
    summaries: list[Any] = [table, *hparams(plain, dict.fromkeys(TAGS, 0.0))[:2]]
    # The start of a session makes a TensorBoard that is looking on forget what it has read.
    return [
        _events.Event(wall_time=now, file_version="brain.Event:2"),
        _events.Event(
            wall_time=now, step=0, session_log=_events.SessionLog(status=_events.SessionLog.START)
        ),
        *(_events.Event(wall_time=now, step=0, summary=summary) for summary in summaries),
    ]


def _scalars(noted: np.ndarray) -> Iterator[Any]:
    for one in map(Metrics._make, noted.tolist()):
        values = [
            _summaries.Summary.Value(tag=tag, simple_value=getattr(one, name))
            for tag, name in TAGS.items()
            if math.isfinite(getattr(one, name))
        ]
        yield _events.Event(
            wall_time=one.time, step=int(one.step), summary=_summaries.Summary(value=values)
        )


def _records(events: Iterable[Any]) -> bytes:
    """Events as TFRecords: length, its checksum, content, its checksum."""
    parts = []
    for event in events:
        content = event.SerializeToString()
        length = struct.pack("<Q", len(content))
        parts += [length, struct.pack("<I", masked_crc32c(length))]
        parts += [content, struct.pack("<I", masked_crc32c(content))]
    return b"".join(parts)
