"""Factors of the states of a Minigrid, and its rewards."""

from collections import Counter
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from jaxtyping import Int32

_SCENERY = ("wall", "floor", "goal", "lava")
_CARRIED = -1  # or in a box
_GONE = -2

Thing = tuple[str, str, tuple[int, int] | None]
"""Kind, color and first cell, which stay with a thing through all that happens to it; of a door,
which never moves, the cell where it is."""


def is_minigrid(env: Any) -> bool:
    """Whether an environment is built like Minigrid's."""
    return all(hasattr(env, name) for name in ("grid", "agent_pos", "agent_dir", "carrying"))


def minigrid_factors(states: Iterable[Any]) -> dict[str, Int32[np.ndarray, "S"]]:
    """Factors of Minigrid's states.

    Args:
        states: one environment each; the first has the things that there are, in boxes too.

    Returns:
        "agent": its cell, row * width + column; "direction": 0 east, 1 south, 2 west, 3 north;
        "carried": 0 nothing, else 1 + the number of the thing; and for every thing its cell, -1
        while it is carried or in a box, -2 once it is gone. A door's is its condition: 0 open, 1
        closed, 2 locked. Indistinguishable things have no factor.
    """
    names: dict[Thing, str] = {}
    rows = []
    for number, env in enumerate(states):
        names = _names(env) if number == 0 else names
        rows.append(_labels(env, list(names)))
    columns = ["agent", "direction", "carried", *names.values()]
    return dict(zip(columns, np.array(rows, np.int32).T, strict=True))


def reward_now(env: Any, first: float) -> float:
    """A transition's reward at the present step of an episode.

    Minigrid's success earns 1 - 0.9 * step_count / max_steps; a table keeps that of a first step.

    Args:
        env: after the transition.
        first: the reward that the table has.
    """
    counts = all(hasattr(env, name) for name in ("step_count", "max_steps"))
    if counts and np.float32(first) == np.float32(1 - 0.9 * (1 / env.max_steps)):
        return 1 - 0.9 * (env.step_count / env.max_steps)
    return first


def _names(env: Any) -> dict[Thing, str]:
    every = [
        thing for _, outer in _on_grid(env) for thing in _with_contents(outer) if _is_thing(thing)
    ]
    places = {id(thing): cell for cell, thing in _on_grid(env)}
    marks = [_mark(thing, places.get(id(thing))) for thing in every]
    marks = [mark for mark in marks if Counter(marks)[mark] == 1]
    kinds, colored = Counter(m[0] for m in marks), Counter(m[:2] for m in marks)
    met: Counter[tuple[str, str]] = Counter()
    names = {}
    for mark in marks:
        kind, color, _ = mark
        met[kind, color] += 1
        name = kind if kinds[kind] == 1 else f"{color} {kind}"
        if colored[kind, color] > 1:
            name += f" {met[kind, color]}"
        names[mark] = name
    return names


def _is_thing(thing: Any) -> bool:
    return thing.type not in _SCENERY


def _on_grid(env: Any) -> list[tuple[tuple[int, int], Any]]:
    """(column, row) and what is there."""
    cells = [(column, row) for row in range(env.height) for column in range(env.width)]
    return [(cell, thing) for cell in cells if (thing := env.grid.get(*cell)) is not None]


def _with_contents(thing: Any) -> Iterator[Any]:
    while thing is not None:
        yield thing
        thing = getattr(thing, "contains", None)


def _mark(thing: Any, cell: tuple[int, int] | None) -> Thing:
    first = cell if thing.type == "door" else thing.init_pos
    return thing.type, thing.color, None if first is None else (int(first[0]), int(first[1]))


def _labels(env: Any, marks: list[Thing]) -> list[int]:
    labels = dict.fromkeys(marks, _GONE)
    for (column, row), outer in _on_grid(env):
        for thing in _with_contents(outer):
            mark = _mark(thing, (column, row))
            if mark in labels:
                cell = row * env.width + column if thing is outer else _CARRIED
                labels[mark] = _door(thing) if thing.type == "door" else cell
    carried = 0
    for thing in _with_contents(env.carrying):
        mark = _mark(thing, None)
        if mark in labels:
            labels[mark] = _CARRIED
        if thing is env.carrying:
            carried = 1 + (marks.index(mark) if mark in labels else len(marks))
    column, row = (int(part) for part in env.agent_pos)
    return [row * env.width + column, int(env.agent_dir), carried, *labels.values()]


def _door(door: Any) -> int:
    return 0 if door.is_open else 2 if door.is_locked else 1
