"""From a model to its table: breadth first through all states that can be reached."""

from collections.abc import Iterable, Sequence
from functools import singledispatch
from typing import Any

import numpy as np

from habilis.mdp import TabularMDP
from habilis.models.limits import MAX_STATES, Limits
from habilis.models.protocol import Model, VectorModel, action_names
from habilis.models.tables import many, table_of
from habilis.models.values import reach_values
from habilis.progress import progress_bar

AnyModel = Any
"""A `TabularMDP`, a `Model`, a `VectorModel`, a `World` or a Gymnasium environment."""


def explore(
    model: AnyModel,
    states: Iterable[Any] | None = None,
    horizon: int | None = None,
    max_states: int = MAX_STATES,
    *,
    show_progress: bool = False,
) -> TabularMDP:
    """The table of all states of a model that can be reached.

    Breadth first, through terminal states too: what follows them is what the model says.

    Args:
        model: a `Model` or a `VectorModel`; a `World`; or a Gymnasium environment, which goes to
            `TabularMDP.from_gymnasium`.
        states: where to begin; by default in the model's `initial` state. The first is the table's
            start.
        horizon: how many actions to go; `None` for all that can ever be reached. States that only
            the last action reaches stay where they are.
        max_states: how many states to accept. One of k numbers of b bits takes about
            16 + k b / 8 bytes, and 8 for each of its actions; one of a scalar model what it takes
            in Python, and about 100.
        show_progress: whether to draw a progress bar on standard error, once it takes two seconds.

    Returns:
        A table, its states numbered in the order in which they are met; `mdp.state(i)` and
        `mdp.index(state)` lead to the model's own states and back. Factors, rewards, terminal
        states and available actions are those of the model.

    Raises:
        ValueError: the model is none, is not deterministic where it says so, or returns states
            that are not hashable or probabilities that do not sum to 1; the message names the
            function and the state. Or more states can be reached than max_states
            (`TooManyStatesError`).

    Example:
        >>> class Line:
        ...     actions = "left", "right"
        ...     initial = 0
        ...
        ...     def step(self, state, action):
        ...         return min(max(state + (-1, 1)[action], 0), 4)
        >>> mdp = explore(Line())
        >>> mdp.states, mdp.state(4), mdp.index(2)
        (5, 4, 2)
        >>> explore(Line(), states=[2], horizon=1).states
        3
    """
    return explored(model, states, _limits(horizon, max_states), show_progress)


@singledispatch
def explored(
    model: Any, states: Iterable[Any] | None, limits: Limits, show_progress: bool
) -> TabularMDP:
    """As `explore`, with checked limits; other types of models register their own way."""
    if is_gymnasium(model):
        if states is not None or limits.horizon is not None:
            raise ValueError(
                "a Gymnasium environment is explored whole, from its first state; leave out states "
                "and horizon"
            )
        most = limits.max_states
        return TabularMDP.from_gymnasium(model, max_states=most, show_progress=show_progress)
    if isinstance(model, type):
        raise ValueError(f"{model.__name__} is a class; give an instance, as {model.__name__}()")
    if not isinstance(model, Model | VectorModel):
        raise ValueError(
            f"{type(model).__name__} is not a model; give it actions and step(state, action), or "
            "step_many(states, actions)"
        )
    action_names(model)  # a simulator is refused whatever its states
    if states is None:
        if (initial := getattr(model, "initial", None)) is None:
            raise ValueError("the model has no initial state; give states=[...]")
        states = [initial]
    if not isinstance(states, Iterable):
        raise ValueError(f"states is {states!r:.80}; give a list of states")
    states = list(states)
    if not states:
        raise ValueError("states is empty; give at least one state")
    with progress_bar("states", show_progress) as report:
        if isinstance(model, VectorModel):
            from habilis.models.vector import explore_rows  # Numba takes long to import

            return explore_rows(model, states, limits, report)
        names, actions = action_names(model)
        available = getattr(model, "available", None)
        found = reach_values(model.step, actions, available, states, limits, report)
        return table_of(model, found, len(found.states), names, found.outcomes)


def explore_to_end(
    model: AnyModel,
    states: Sequence[Any] | None = None,
    max_states: int = MAX_STATES,
    *,
    show_progress: bool = False,
) -> TabularMDP:
    """As `explore`, but no further than it takes to enter a terminal state."""
    terminal = many(model, "terminal")
    if terminal is None:  # as of an environment, or a world
        return explored(model, states, Limits(None, max_states), show_progress)
    near = explored(model, states, Limits(0, max_states), False)
    if not near.terminal[near.start]:
        until = Limits(None, max_states, lambda newest: bool(np.any(terminal(newest))))
        return explored(model, states, until, show_progress)
    # From a terminal state, the nearest one to enter may be itself, which is no new state.
    horizon, before = 1, 0
    while True:
        near = explored(model, states, Limits(horizon, max_states), show_progress)
        if near.states == before or near.is_stochastic:
            return near
        entered = near.terminal[near.next_state] & (near.next_state >= 0)
        entered &= (near.next_state != np.arange(near.states)[:, None]) | (
            near.next_state == near.start
        )
        if entered.any():
            return near
        horizon, before = 2 * horizon, near.states


def is_gymnasium(model: Any) -> bool:
    """Whether it is an environment of Gymnasium's, found out without importing that."""
    return hasattr(model, "action_space") and hasattr(model, "unwrapped")


def _limits(horizon: Any, max_states: Any) -> Limits:
    for name, value, least in (("horizon", horizon, 0), ("max_states", max_states, 1)):
        is_whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if not (is_whole and value >= least) and not (name == "horizon" and value is None):
            raise ValueError(f"{name} is {value!r}; give a whole number from {least} up")
    return Limits(horizon, max_states)
