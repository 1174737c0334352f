"""A shortest plan of a model, found without its whole table."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Int32

from habilis.models.limits import MAX_STATES, TooManyStatesError
from habilis.models.protocol import VectorModel, action_names
from habilis.progress import progress_bar

_BLOCK = 1 << 13  # states stepped at once


@dataclass(frozen=True)
class Way:
    """A shortest way from a state to a terminal one.

    Attributes:
        actions: the action indices, first to last.
        states: the model's states passed through, from the first to the terminal one (one more).
        best_return: the sum of the rewards along it, undiscounted.
    """

    actions: tuple[int, ...]
    states: tuple[Any, ...]
    best_return: float


def shortest_way(
    model: VectorModel,
    state: Any = None,
    max_states: int = MAX_STATES,
    *,
    show_progress: bool = False,
) -> Way | None:
    """A shortest plan of a vectorised model, breadth first until a terminal state is entered.

    It is the plan that `solve` finds in the table of `explore`; no state that is further away than
    the nearest terminal one is expanded.

    Args:
        model: the model, with `terminal_many`, all of whose actions are available.
        state: where to begin; by default the model's `initial`.
        max_states: how many states to accept.
        show_progress: whether to draw a progress bar on standard error, once it takes two seconds.

    Returns:
        The plan, or `None` if no terminal state can be reached.

    Raises:
        TooManyStatesError: more states than max_states are met before.
    """
    from habilis.models.interning import InternedRows  # Numba takes long to import

    described: Any = model
    _, actions = action_names(model)
    first = np.array([described.initial if state is None else state], np.int64)
    found = InternedRows(first.shape[1])
    found.add(first)
    levels: list[tuple[int, Int32[np.ndarray, "n A"]]] = []
    done = 0
    with progress_bar("states", show_progress) as report:
        while done < len(found):
            start, frontier = done, len(found)
            leads: list[Int32[np.ndarray, "n A"]] = []
            while done < frontier:
                rows = found.rows(done, min(done + _BLOCK, frontier))
                every = np.tile(np.arange(actions), len(rows))
                after = model.step_many(np.repeat(rows, actions, axis=0), every)
                numbers = found.add(np.asarray(after, np.int64)).reshape(-1, actions)
                leads.append(numbers)
                done += len(rows)
                ends = described.terminal_many(after).reshape(numbers.shape)
                if ends.any():
                    source, action = np.argwhere(ends)[0]
                    last = done - len(rows) + int(source), int(action)
                    return _traced(described, found, levels, last, int(numbers[source, action]))
                if len(found) > max_states:
                    raise TooManyStatesError(
                        f"more than {max_states:,} states are met before a terminal one, "
                        f"{len(levels) + 1} actions from the first: raise max_states if there is "
                        "memory for it"
                    )
                report(done, len(found))
            levels.append((start, np.concatenate(leads)))
    return None


def _traced(
    model: Any,
    found: Any,
    levels: list[tuple[int, Int32[np.ndarray, "n A"]]],
    last: tuple[int, int],
    end: int,
) -> Way:
    """The way to a state: each of its states was met first from a state of the level before."""
    numbers, actions = [end, last[0]], [last[1]]
    for start, leads in reversed(levels):
        source, action = np.divmod(int(np.argmax(leads.ravel() == numbers[-1])), leads.shape[1])
        numbers.append(start + int(source))
        actions.append(int(action))
    states = found.take(np.array(numbers[::-1]))
    rewards = model.reward_many(states[:-1], np.array(actions[::-1]), states[1:])
    return Way(
        tuple(actions[::-1]), tuple(tuple(row) for row in states.tolist()), float(rewards.sum())
    )
