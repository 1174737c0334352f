"""A disk cache of results, keyed by their inputs."""

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from habilis.checksums import Arrays, read_arrays, write_arrays
from habilis.files import write_whole

if TYPE_CHECKING:
    from habilis.mdp import TabularMDP

_DIGEST = hashlib.sha256


def cache_folder() -> Path | None:
    """Where things are kept: `$XDG_CACHE_HOME/habilis`, by default `~/.cache/habilis`.

    Returns:
        The folder; `None` for a user who has no home.
    """
    if named := os.environ.get("XDG_CACHE_HOME"):
        return Path(named) / "habilis"
    try:
        return Path.home() / ".cache" / "habilis"
    except RuntimeError:
        return None


def fingerprint(*parts: Any) -> str:
    """A name for contents: equal for equal arrays, numbers and texts, and for no others.

    Args:
        parts: arrays, scipy.sparse arrays, or what `repr` says all of.
    """
    digest = _DIGEST()
    for part in parts:
        if hasattr(part, "indptr"):
            digest.update(fingerprint(part.shape, part.data, part.indices, part.indptr).encode())
        elif isinstance(part, np.ndarray):
            digest.update(f"{part.dtype.str}{part.shape};".encode())
            digest.update(np.ascontiguousarray(part).data)
        else:
            digest.update(f"{type(part).__name__} {part!r};".encode())
    return digest.hexdigest()


def table_digest(mdp: "TabularMDP") -> str:
    """A fingerprint of all in a table that training depends on, in 32 hexadecimal digits."""
    cells = None if mdp.cells is None else sorted(mdp.cells)
    parts: list[Any] = [mdp.transitions, mdp.reward, mdp.terminal, mdp.start, mdp.entry_reward]
    parts += [mdp.shape, cells, mdp.actions]
    for named in (mdp.factors, mdp.flags):
        parts += [part for pair in named.items() for part in pair]
    return fingerprint(*parts)[:32]


def kept(
    name: str,
    compute: Callable[[], Arrays],
    folder: Path | None = None,
    accept: Callable[[Arrays], bool] = lambda arrays: True,
) -> Arrays:
    """Arrays by their common name: from the disk, or computed and put there.

    A file that is damaged is made again; where none can be written, nothing is kept.

    Args:
        name: such as a `fingerprint`.
        compute: makes the arrays.
        folder: where they are kept; by default `cache_folder()`.
        accept: whether those from the disk may be used.
    """
    folder = cache_folder() if folder is None else folder
    if folder is None:
        return compute()
    path = folder / f"{name}.npz"
    with suppress(OSError, ValueError, EOFError):
        found = read_arrays(path)
        if accept(found):
            return found
    arrays = compute()
    with suppress(OSError):  # a full disk is no reason to have no values
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, lambda file: write_arrays(file, arrays))
    return arrays
