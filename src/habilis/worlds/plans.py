"""Shortest plans: what the best an agent can do in a world is."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from jaxtyping import Float, Float64, Int64

from habilis.mdp import TabularMDP
from habilis.models.explore import AnyModel, explore_to_end
from habilis.models.limits import MAX_STATES
from habilis.reprs import counted, number, quietly, repeated, short, unfailing
from habilis.transitions import Transitions
from habilis.worlds.world import World

_SETTLED = 1e-9  # a change of expected returns that is none


@dataclass(frozen=True)
class Plan:
    """A shortest way from a state to a terminal one.

    Attributes:
        actions: the action indices, first to last.
        states: the states passed through, from the first to the terminal one (one more): indices
            of a table, or a model's own.
        best_return: the sum of the rewards along it, undiscounted.
        table: the table that it was found in.
        table_states: the indices of `states` in it.
    """

    actions: tuple[int, ...]
    states: tuple[Any, ...]
    best_return: float
    table: TabularMDP | None = field(default=None, repr=False, compare=False)
    table_states: tuple[int, ...] = field(default=(), repr=False, compare=False)

    @property
    def steps(self) -> int:
        """How many actions it takes."""
        return len(self.actions)

    @property
    def action_names(self) -> tuple[str, ...]:
        """The names of the actions; their indices where they have none."""
        names = () if self.table is None else self.table.actions
        return tuple(names[a] if a < len(names) else str(a) for a in self.actions)

    @unfailing
    def __repr__(self) -> str:
        size = f"{counted(self.steps, 'step')}, return {number(self.best_return)}"
        return short("Plan", size, repeated(self.action_names))

    @quietly
    def _repr_html_(self) -> str | None:
        """Its states in pictures, each above the action taken there, for notebooks."""
        from habilis.worlds.pictures.states import drawn_state
        from habilis.worlds.pictures.svg import chosen_places, strip_html

        states = {}
        for place in chosen_places(len(self.table_states)):
            state = (
                None if self.table is None else drawn_state(self.table, self.table_states[place])
            )
            if state is None:
                return None
            states[place] = state
        captions = (*self.action_names, f"return {number(self.best_return)}")
        return strip_html(states, captions)


def solve(
    model: AnyModel,
    start: Any = None,
    *,
    max_states: int = MAX_STATES,
    show_progress: bool = False,
) -> Plan | None:
    """A shortest plan, by breadth-first search.

    Of several, the one whose states were met first: lower states and actions win.

    Args:
        model: a table; or any other model, which is explored no further than the plan goes.
        start: the state to begin in, an index or, of a model, a state of its own (of a world a
            placement); by default the model's initial state.
        max_states: how many states of a model to accept, as in `explore`.
        show_progress: whether to draw a progress bar on standard error while a model is explored.

    Returns:
        The plan (at least one step long: what counts is entering a terminal state), or `None`
        if no terminal state can be reached.

    Raises:
        ValueError: there is no such state, the model is stochastic, or more than max_states are met
            before a plan is found.

    Example:
        >>> class Line:
        ...     actions = "left", "right"
        ...     initial = 0
        ...
        ...     def step(self, state, action):
        ...         return state + (-1, 1)[action]
        ...
        ...     def terminal(self, state):
        ...         return state == 3
        >>> solve(Line())
        <Plan: 3 steps, return 0; right ×3>
    """
    if not isinstance(model, TabularMDP):
        starts = None if start is None else [start]
        mdp = explore_to_end(model, starts, max_states, show_progress=show_progress)
        if mdp.is_stochastic:
            raise ValueError(
                "the model is stochastic, so that no sequence of actions is a plan; train an agent "
                "on its table, habilis.explore(model)"
            )
        plan = solve(mdp)
        if plan is None or mdp.model_states is None:
            return plan
        return replace(plan, states=tuple(map(mdp.state, plan.states)))
    if model.is_stochastic:
        raise ValueError(
            "this MDP is stochastic, so that no sequence of actions is a plan; train an agent on "
            "it, with habilis.train(Config(world=mdp))"
        )
    mdp, start = model, model.start if start is None else start
    if not isinstance(start, int | np.integer) or not 0 <= start < mdp.states:
        raise ValueError(f"start is {start}; use a state from 0 to {mdp.states - 1}")
    start = int(start)
    came_from = np.full((mdp.states, 2), -1)
    seen = np.zeros(mdp.states, bool)
    frontier = np.array([start])
    while len(frontier):
        reached = mdp.next_state[frontier].ravel()
        reached, first = np.unique(reached, return_index=True)
        fresh = (reached >= 0) & ~seen[reached]  # below 0: an action that is not available
        reached, first = reached[fresh], first[fresh]
        seen[reached] = True
        source, action = np.divmod(first, mdp.action_count)
        came_from[reached, 0], came_from[reached, 1] = frontier[source], action
        done = reached[mdp.terminal[reached]]
        if len(done):
            return _trace(mdp, came_from, start, int(done[0]))
        frontier = reached
    return None


def distances(mdp: TabularMDP) -> Int64[np.ndarray, "S"]:
    """How many actions the nearest terminal state is away, from every state.

    In a stochastic world, how many they are at least.

    Args:
        mdp: a world's table.

    Returns:
        int64[S]; 0 for terminal states, -1 where none can be reached.
    """
    reached = Transitions.of(mdp).next_state.reshape(mdp.states, -1)
    far = np.where(mdp.terminal, 0, -1)
    left = np.flatnonzero(far < 0)
    step = 0
    while len(left):
        near = (far[reached[left]] == step).any(axis=1)
        if not near.any():
            break
        step += 1
        far[left[near]] = step
        left = left[~near]
    return far


def best_returns(mdp: TabularMDP, limit: int) -> Float64[np.ndarray, "S"]:
    """The return that the best policy expects from every state.

    V_0 = 0, and V_n(s) is the largest over the actions available in s of E[r + V_(n - 1)(s')],
    without V where s' is terminal; 0 in a state without actions, where an episode ends.

    Args:
        mdp: a world's table.
        limit: how many steps an episode has, at most.

    Returns:
        float64[S], undiscounted; in a deterministic table those of shortest plans, if they are no
        longer than the limit.
    """
    best, reward = np.zeros(mdp.states), mdp.reward.astype(np.float64)
    if not mdp.always_available:
        there = mdp.available
        reward[~there & there.any(axis=1, keepdims=True)] = -np.inf
    for _ in range(limit):
        after = _expected(mdp, np.where(mdp.terminal, 0.0, best))
        better = (reward + after).max(axis=1)
        if np.abs(better - best).max() < _SETTLED:
            return better
        best = better
    return best


def policy_returns(
    mdp: TabularMDP, policy: Float[np.ndarray, "S A"], limit: int
) -> Float64[np.ndarray, "S"]:
    """The return that a policy expects from every state.

    Args:
        mdp: the table.
        policy: float[S, A], the probability of each action; 0 where it is not available.
        limit: how many steps an episode has, at most.

    Returns:
        float64[S], undiscounted.
    """
    expected, reward = np.zeros(mdp.states), mdp.reward.astype(np.float64)
    for _ in range(limit):
        after = _expected(mdp, np.where(mdp.terminal, 0.0, expected))
        before, expected = expected, ((reward + after) * policy).sum(axis=1)
        if np.abs(expected - before).max() < _SETTLED:
            break
    return expected


def _expected(mdp: TabularMDP, values: Float64[np.ndarray, "S"]) -> Float64[np.ndarray, "S A"]:
    """The mean value of the states that each action leads to."""
    if isinstance(mdp.transitions, np.ndarray):
        if mdp.always_available:
            return values[mdp.transitions]
        return np.where(mdp.available, values[mdp.transitions], 0.0)
    return (mdp.transitions @ values).reshape(mdp.states, -1)


def check_certain(world: World) -> World:
    """The world, if its tools do what they do for sure; a plan needs that.

    Raises:
        ValueError: one of them may fail; the message names it.
    """
    for tool in world.tools:
        if tool.slip:
            raise ValueError(
                f"{world.name}: the tool {tool.name!r} has slip {tool.slip:g}: a stochastic "
                "world has no shortest plan; leave out its slip"
            )
    return world


def _trace(mdp: TabularMDP, came_from: np.ndarray, start: int, end: int) -> Plan:
    states, actions = [end], []
    while not actions or states[-1] != start:
        source, action = came_from[states[-1]]
        states.append(int(source))
        actions.append(int(action))
    states.reverse()
    actions.reverse()
    best_return = float(mdp.reward[states[:-1], actions].sum())
    return Plan(tuple(actions), tuple(states), best_return, mdp, tuple(states))
