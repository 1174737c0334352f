"""Tables as files: `TabularMDP.save` and `TabularMDP.load`.

An .npz of plain arrays, without pickles, with a checksum (`habilis.checksums`). NumPy reads it too.
Large arrays stay in the file when it is loaded, mapped into memory:

- `header`: JSON text: format, edition, start, shape, actions, cells, names of factors and flags,
  players if there are several;
- `next_state`: int32[S, A]; or, of a stochastic table, `probability`, `column` and `first`, the
  sparse float64[S * A, S] of `TabularMDP.transitions`;
- `reward`: float32[S, A]; `terminal`: bool[S]; `entry_reward`: float32[S], if there is any;
- `factors`: int32[F, S]; `flags`: bool[G, S].
"""

import json
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from habilis.checksums import Arrays, ChecksumError, read_arrays, write_arrays
from habilis.files import check_file, save_whole, shown
from habilis.mdp import TabularMDP
from habilis.mdp_arguments import UNAVAILABLE

SUFFIX, _STORM = ".npz", ".drn"
_FORMAT, _EDITION = "habilis table", 1
_ROUNDING = 1e-9
_PART = 1 << 20  # numbers checked at once
_BROKEN = (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile)


def save(mdp: TabularMDP, path: str | Path) -> None:
    """`TabularMDP.save`; see there."""
    if not isinstance(path, str | Path):
        raise ValueError(f"path is {path!r:.80}; give the path of a file")
    check_file(path, [SUFFIX])
    try:
        arrays = _arrays(mdp)
        _table(arrays)
    except _BROKEN as error:  # a file that could not be read would be as good as none
        raise ValueError(f"{path}: the table cannot be saved: {_reason(error)}") from None
    save_whole(path, lambda file: write_arrays(file, arrays))


def names_table(name: str) -> bool:
    """Whether a name is that of a file with a table: one of ours (.npz), or of Storm's (.drn)."""
    return Path(name).suffix.lower() in (SUFFIX, _STORM)


def table_named(name: str) -> TabularMDP:
    """The table in such a file.

    Raises:
        ValueError: it cannot be read.
        MissingExtraError: it is one of Storm's, and stormpy is not installed.
    """
    if Path(name).suffix.lower() == _STORM:
        return TabularMDP.from_storm(name)
    return load(name)


def load(path: str | Path) -> TabularMDP:
    """`TabularMDP.load`; see there."""
    if not isinstance(path, str | Path):
        raise ValueError(f"path is {path!r:.80}; give the path of a file")
    name = shown(path) if str(path) else "''"
    try:
        arrays = read_arrays(Path(path), mapped=True)
    except ChecksumError:
        raise ValueError(f"{name}: {_not_a_table(Path(path))}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ValueError(
            f"{name}: cannot be read ({reason}); name a file that TabularMDP.save wrote"
        ) from None
    try:
        return _table(arrays)
    except _BROKEN as error:
        raise ValueError(
            f"{name}: is not a usable table: {_reason(error)}; save the table again"
        ) from None


def _reason(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"{error.args[0]} is missing"
    return (str(error).splitlines() or [type(error).__name__])[0]


def _not_a_table(path: Path) -> str:
    """The problem with a file whose checksum does not match, and what to do."""
    try:
        with path.open("rb") as file, zipfile.ZipFile(file) as saved:
            names = [name.removesuffix(".npy") for name in saved.namelist()]
    except (OSError, NotImplementedError, *_BROKEN):
        names = []
    if names and "header" not in names:
        return (
            f"was not written by TabularMDP.save (it has {shown(', '.join(names))}); pass its "
            "arrays to TabularMDP.deterministic or TabularMDP.stochastic"
        )
    return "is damaged, or was not written by TabularMDP.save; save the table again"


def _arrays(mdp: TabularMDP) -> dict[str, np.ndarray]:
    header = {
        "format": _FORMAT,
        "edition": _EDITION,
        "start": int(mdp.start),
        "shape": None if mdp.shape is None else [int(side) for side in mdp.shape],
        "actions": list(mdp.actions),
        "cells": None if mdp.cells is None else sorted(mdp.cells),
        "factors": list(mdp.factors),
        "flags": list(mdp.flags),
    } | ({"players": dict(mdp.players)} if mdp.players else {})
    arrays = {
        "header": np.array(json.dumps(header)),
        "reward": mdp.reward,
        "terminal": mdp.terminal,
        "factors": _rows(mdp.factors, np.int32, mdp.states),
        "flags": _rows(mdp.flags, np.bool_, mdp.states),
    }
    if mdp.entry_reward is not None:
        arrays["entry_reward"] = mdp.entry_reward
    if isinstance(mdp.transitions, np.ndarray):
        return arrays | {"next_state": mdp.transitions}
    csr = mdp.transitions
    if not csr.has_canonical_format or not csr.data.all():
        csr = csr.copy()
        csr.sum_duplicates()
        csr.eliminate_zeros()
    return arrays | {"probability": csr.data, "column": csr.indices, "first": csr.indptr}


def _rows(named: Mapping[str, np.ndarray], dtype: type, states: int) -> np.ndarray:
    """[names, S]; of labels that their type cannot hold the wider one, which is then refused."""
    rows = np.stack(list(named.values())) if named else np.empty((0, states), dtype)
    narrow = rows.astype(dtype)
    return narrow if np.array_equal(narrow, rows) else rows


def _table(arrays: Arrays) -> TabularMDP:
    """The table of a file's arrays, each of which is checked.

    Raises:
        ValueError, KeyError, TypeError: they are no table.
    """
    header = json.loads(str(arrays["header"]))
    if not isinstance(header, dict) or header.get("format") != _FORMAT:
        raise ValueError("its header is not that of a table")
    if header["edition"] != _EDITION:
        raise ValueError(f"it has edition {header['edition']!r}, and this version reads {_EDITION}")
    reward, shape, cells = arrays["reward"], header["shape"], header["cells"]
    if reward.ndim != 2 or 0 in reward.shape:
        raise ValueError(f"reward has shape {reward.shape}")
    states, actions = reward.shape
    _check(arrays, "reward", np.float32, (states, actions))
    _check(arrays, "terminal", np.bool_, (states,))
    entry_reward = arrays.get("entry_reward")
    if entry_reward is not None:
        _check(arrays, "entry_reward", np.float32, (states,))
    kinds = {"factors": np.int32, "flags": np.bool_}
    for kind, dtype in kinds.items():
        _check_names(header, kind)
        _check(arrays, kind, dtype, (len(header[kind]), states))
    _check_names(header, "actions")
    if header["actions"] and len(header["actions"]) != actions:
        raise ValueError(f"actions has {len(header['actions'])} names for {actions} actions")
    if type(header["start"]) is not int or not 0 <= header["start"] < states:
        raise ValueError(f"start is {header['start']!r}, of {states} states")
    if shape is not None and not (len(shape) == 2 and all(type(n) is int and n > 0 for n in shape)):
        raise ValueError(f"shape is {shape!r}, not rows and columns")
    if cells is not None:
        _check_names(header, "cells")
    named = {kind: dict(zip(header[kind], arrays[kind], strict=True)) for kind in kinds}
    return TabularMDP(
        _transitions(arrays, states, actions),
        reward,
        arrays["terminal"],
        named["factors"],
        named["flags"],
        header["start"],
        None if shape is None else (shape[0], shape[1]),
        tuple(header["actions"]),
        entry_reward=entry_reward,
        cells=None if cells is None else frozenset(cells),
        players=header.get("players", {}),
    )


def _check(arrays: Arrays, name: str, dtype: type, shape: tuple[int, ...]) -> None:
    array = arrays[name]
    if array.dtype != dtype or array.shape != shape:
        wanted = f"{np.dtype(dtype)}{list(shape)}"
        raise ValueError(f"{name} is {array.dtype}{list(array.shape)}, not {wanted}")
    if array.dtype.kind == "f" and not all(np.isfinite(part).all() for part in _parts(array)):
        raise ValueError(f"{name} has entries that are not finite")


def _parts(array: np.ndarray) -> Iterator[np.ndarray]:
    """An array in parts, so that what is made of each stays small."""
    flat = array.reshape(-1)
    return (flat[first : first + _PART] for first in range(0, len(flat), _PART))


def _check_names(header: dict[str, Any], kind: str) -> None:
    names = header[kind]
    whole = isinstance(names, list) and all(isinstance(name, str) for name in names)
    if not whole or len({*names}) != len(names):
        raise ValueError(f"{kind} is {names!r:.60}, not a list of different names")


def _transitions(arrays: Arrays, states: int, actions: int) -> Any:
    if "next_state" in arrays:
        _check(arrays, "next_state", np.int32, (states, actions))
        table = np.ascontiguousarray(arrays["next_state"])
        if not (table.min() >= UNAVAILABLE and table.max() < states):
            raise ValueError(f"next_state has entries that are none of its {states} states")
        return table
    from scipy.sparse import csr_array

    probability, column, first = (arrays[name] for name in ("probability", "column", "first"))
    _check(arrays, "probability", np.float64, (len(column),))
    for name, index in (("column", column), ("first", first)):
        if index.dtype not in (np.int32, np.int64) or index.ndim != 1:
            raise ValueError(f"{name} is {index.dtype}{list(index.shape)}, not int32 or int64[n]")
    if len(first) != states * actions + 1 or first[0] or first[-1] != len(column):
        raise ValueError(f"first does not divide probability into {states * actions} rows")
    if (np.diff(first) < 0).any() or (column < 0).any() or (column >= states).any():
        raise ValueError(f"first or column has entries that are none of its {states} states")
    table = csr_array((probability, column, first), (states * actions, states))
    if not table.has_canonical_format or not (probability > 0).all():
        raise ValueError("probability has zeros, negative or repeated entries")
    off = (np.diff(first) > 0) & (abs(np.asarray(table.sum(axis=1)) - 1) > _ROUNDING)
    if off.any():
        state, action = divmod(int(off.argmax()), actions)
        raise ValueError(f"probability of state {state}, action {action} does not sum to 1")
    return table
