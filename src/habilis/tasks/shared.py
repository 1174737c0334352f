"""Values that many tasks have in common: they travel to where tasks run once, not with each task.

A task holds such a value as `Shared`. Executors that run tasks elsewhere take it out (`packed`),
send it in their own way, and put it back there (`unpacked`).
"""

import mmap
import pickle
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, Generic, TypeVar

T = TypeVar("T")

_ALIGNED = 64  # bytes


@dataclass(frozen=True, eq=False)
class Shared(Generic[T]):
    """A value that many tasks have in common.

    Attributes:
        key: its identity, equal for equal values only.
        value: it can be pickled, and nobody writes into it.
    """

    key: str
    value: T


def packed(
    task: Any, pickler: type[pickle.Pickler] = pickle.Pickler
) -> tuple[bytes, dict[str, Shared[Any]]]:
    """A task without the shared values in it, and these by their keys."""
    taken: dict[str, Shared[Any]] = {}

    class Leaving(pickler):
        def persistent_id(self, obj: Any) -> str | None:
            if not isinstance(obj, Shared):
                return None
            taken[obj.key] = obj
            return obj.key

    content = BytesIO()
    Leaving(content, 5).dump(task)
    return content.getvalue(), taken


def unpacked(content: bytes, value_of: Callable[[str], Any]) -> Any:
    """The task that `packed` made it of.

    Args:
        content: as `packed` returns it.
        value_of: returns the shared value of a key.
    """

    class Finding(pickle.Unpickler):
        def persistent_load(self, pid: str) -> Shared[Any]:
            return Shared(pid, value_of(pid))

    return Finding(BytesIO(content)).load()


def write(value: Any, file: BinaryIO) -> None:
    """Writes a value for `read`, its arrays apart from the rest."""
    arrays: list[pickle.PickleBuffer] = []
    rest = pickle.dumps(value, protocol=5, buffer_callback=arrays.append)
    pieces = [array.raw() for array in arrays]
    pickle.dump((len(rest), [len(piece) for piece in pieces]), file)
    for piece in (rest, *pieces):
        file.write(bytes(-file.tell() % _ALIGNED))
        file.write(piece)


def read(path: Path) -> Any:
    """The value in a file, whose arrays stay there: processes share them, each copying on write."""
    with path.open("rb") as file:
        first, others = pickle.load(file)
        at = file.tell()
        whole = memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_COPY))
    pieces = []
    for size in (first, *others):
        at += -at % _ALIGNED
        pieces.append(whole[at : at + size])
        at += size
    return pickle.loads(pieces[0], buffers=pieces[1:])
