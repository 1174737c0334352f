"""TensorBoard event files read back."""

import math
import struct
from collections.abc import Collection
from pathlib import Path
from typing import Any

from tensorboardX.proto import event_pb2
from tensorboardX.record_writer import masked_crc32c


def read_events(folder: Path) -> list[Any]:
    """All events of the files in a folder, which must be whole; file after file, by name."""
    event_class: Any = event_pb2.Event  # pyright: ignore[reportAttributeAccessIssue]
    events = []
    for path in sorted(folder.iterdir()):
        assert "tfevents" in path.name
        content = path.read_bytes()
        at = 0
        while at < len(content):
            (length,) = struct.unpack_from("<Q", content, at)
            record = content[at + 12 : at + 12 + length]
            assert len(record) == length
            for checked, place in (
                (content[at : at + 8], at + 8),
                (record, at + 12 + length),
            ):
                assert struct.unpack_from("<I", content, place)[0] == masked_crc32c(checked)
            events.append(event_class.FromString(record))
            at += 16 + length
    return events


def scalars(folder: Path, but: Collection[str] = ()) -> list[tuple[int, str, float]]:
    """Step, tag and value of every point, in the order of the files."""
    found = [
        (event.step, value.tag, value.simple_value)
        for event in read_events(folder)
        for value in event.summary.value
        if value.WhichOneof("value") == "simple_value" and value.tag not in but
    ]
    assert all(math.isfinite(value) for _, _, value in found)
    return found
