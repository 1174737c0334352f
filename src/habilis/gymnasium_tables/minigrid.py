"""What a state of a Minigrid says of the things in it."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from jaxtyping import Int32

_SCENERY = ("wall", "floor", "goal", "lava")
_NOWHERE = -1


def is_minigrid(env: Any) -> bool:
    """Whether an environment is built like Minigrid's."""
    return all(hasattr(env, name) for name in ("grid", "agent_pos", "agent_dir", "carrying"))


def minigrid_factors(states: Iterable[Any]) -> dict[str, Int32[np.ndarray, "S"]]:
    """Factors of Minigrid's states.

    Args:
        states: one environment each; the first says which things there are.

    Returns:
        "agent": its cell, row * width + column; "direction": 0 east, 1 south, 2 west, 3 north;
        "carried": 0 nothing, else 1 + the number of the thing; and for every thing its cell, -1
        while it is carried or in a box. A door's is its condition: 0 open, 1 closed, 2 locked.
    """
    names: dict[tuple[int, int], str] = {}
    rows = []
    for env in states:
        names = names or _names(env)
        rows.append(_labels(env, list(names)))
    columns = ["agent", "direction", "carried", *names.values()]
    return dict(zip(columns, np.array(rows, np.int32).T, strict=True))


def _names(env: Any) -> dict[tuple[int, int], str]:
    """The things of the first state by where they are at first; they keep that in mind."""
    things = [(place, thing) for place, thing in _things(env) if thing.type not in _SCENERY]
    kinds = [thing.type for _, thing in things]
    colored = [f"{thing.color} {thing.type}" for _, thing in things]
    names = {}
    for i, (place, thing) in enumerate(things):
        name = thing.type if kinds.count(thing.type) == 1 else colored[i]
        if kinds.count(thing.type) > 1 and colored.count(colored[i]) > 1:
            name += f" {colored[: i + 1].count(colored[i])}"
        names[place] = name
    return names


def _things(env: Any) -> list[tuple[tuple[int, int], Any]]:
    cells = [(column, row) for row in range(env.height) for column in range(env.width)]
    return [(cell, thing) for cell in cells if (thing := env.grid.get(*cell)) is not None]


def _origin(thing: Any, place: tuple[int, int]) -> tuple[int, int]:
    known = thing.init_pos if thing.init_pos is not None else place
    return int(known[0]), int(known[1])


def _labels(env: Any, origins: list[tuple[int, int]]) -> list[int]:
    labels = dict.fromkeys(origins, _NOWHERE)
    for (column, row), thing in _things(env):
        origin = _origin(thing, (column, row))
        if origin in labels and thing.type not in _SCENERY:
            cell = row * env.width + column
            labels[origin] = _door(thing) if thing.type == "door" else cell
    carried = 0
    if env.carrying is not None:
        origin = _origin(env.carrying, (_NOWHERE, _NOWHERE))
        carried = 1 + origins.index(origin) if origin in labels else len(origins) + 1
    column, row = (int(part) for part in env.agent_pos)
    return [row * env.width + column, int(env.agent_dir), carried, *labels.values()]


def _door(door: Any) -> int:
    return 0 if door.is_open else 2 if door.is_locked else 1
