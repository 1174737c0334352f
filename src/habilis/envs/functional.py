"""The worlds as functions of JAX: an environment for `jit`, `vmap` and `scan`.

The interface is gymnax's from 1.0 on, whose `step` separates `terminated` and `truncated` (six
values; before there were five, with one `done`). gymnax itself is not needed, the extras
`habilis[learn]` and `habilis[gymnasium]` are.
"""

import copy
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int8, PRNGKeyArray
from numpy.typing import ArrayLike

from habilis.empowerment.methods import Exact, Method
from habilis.empowerment.sensors import Sensor
from habilis.envs.observations import Labels, Marks, cells, grid, one_hot, ranked
from habilis.envs.params import Empowerment, Params, State
from habilis.envs.spaces import classes
from habilis.envs.steps import (
    Action,
    Alone,
    Stepped,
    action_mask,
    begin,
    cut_off,
    goes_on,
    observed,
    step,
    step_alone,
)
from habilis.envs.table import MAX_STEPS, check_episode
from habilis.envs.world import as_world
from habilis.mdp import TabularMDP
from habilis.rewards.cached_tables import kept_empowerment
from habilis.rewards.shaping import Bonus
from habilis.transitions import Transitions
from habilis.worlds.table import tabulate
from habilis.worlds.tools import Tool
from habilis.worlds.world import World

_EXACT = Exact()
KINDS = ("factors", "onehot", "grid")


class FunctionalEnv:
    """A world, or any table, as functions without a state of their own.

    Rewards, ends and time limits are those of `WorldEnv` and of `train`: an episode that ends by
    the world's rules in the last step it has is terminated, not truncated. The step that ends an
    episode returns the next one's first observation and state, and has the last observation in
    `info["final_observation"]`. `info` has "terminated" and "truncated" too, and of the state that
    was reached "state" (its index), "equipped", "attached" (bool) and "discount" (0 where it is
    terminal, 1 elsewhere).

    Actions are int32; JAX cannot refuse one that does not exist. Where a table's actions are not
    available everywhere, `info["action_mask"]`, int8[A], has a 1 for those that are in the state
    that a step returns, and `action_mask` gives the same of any state. JAX cannot refuse the
    others: they leave the state as it is, for a reward of 0, and cost a step.
    `jax.random.categorical(key, jnp.log(mask))` draws among the available ones, as slip does. In a
    state without actions an episode terminates. The key of a step matters only where outcomes are
    random, by slip or by the table, that of a reset never. All methods work inside `jit`, `vmap`
    and `scan`; `params` may be left out: they are `default_params` then.

    Example:
        >>> import jax
        >>> env = FunctionalEnv("corridor", observation="grid")
        >>> params = env.default_params
        >>> keys = jax.random.split(jax.random.key(0), 1000)
        >>> obs, states = jax.vmap(env.reset, in_axes=(0, None))(keys, params)
        >>> actions = jax.vmap(env.action_space(params).sample)(keys)
        >>> step = jax.vmap(env.step, in_axes=(0, 0, 0, None))
        >>> obs, states, reward, terminated, truncated, info = step(keys, states, actions, params)
        >>> obs.shape, float(reward.sum())
        ((1000, 5, 10, 10), -1000.0)
    """

    def __init__(
        self,
        world: World | TabularMDP | str | Path,
        tool: str | Tool | type | None = None,
        max_steps: int = MAX_STEPS,
        observation: str = "factors",
        slip: float = 0.0,
    ):
        """
        Args:
            world: a world, a built-in one's name, the path of a map, or the text of one; or a
                table.
            tool: takes the place of the map's own, by its name or itself; `None` keeps that.
            max_steps: the length of an episode, at most.
            observation: "factors", int32, the cells of agent, tool and object, each
                `row * columns + column` (of a table each factor, counted from 0 among the values
                that it has); "onehot", the same as zeros and ones, uint8; "grid", uint8
                `[channels, rows, columns]`, of worlds only. See `observations.observation`.
            slip: the probability that an action drawn uniformly takes the place of the chosen one.

        Raises:
            ValueError: no such world, tool or observation, the table's start has no action, or a
                number is out of its range.
        """
        if isinstance(world, TabularMDP):
            if tool is not None:
                raise ValueError(f"tool is {tool!r}, but a table has its own moves; give a world")
            mdp, place, self._name = world, None, "table"
        else:
            place = as_world(world)
            place = place if tool is None else place.with_tool(tool)
            mdp, self._name = tabulate(place), place.name
        check_episode(mdp, max_steps, slip)
        shown = _shown(observation, mdp, place)
        self._mdp, self._slip, self._shown = mdp, slip, shown
        self._params = Params(
            transitions=Transitions.of(mdp).in_jax(),
            terminal=jnp.asarray(mdp.ends),
            start=mdp.start,
            max_steps_in_episode=max_steps,
            flags={name: jnp.asarray(flag) for name, flag in mdp.flags.items()},
            seen=jnp.asarray(shown.at if isinstance(shown, Marks) else shown.of, jnp.int32),
            background=jnp.asarray(shown.still) if isinstance(shown, Marks) else None,
            slip=slip or None,
            available=None if mdp.always_available else jnp.asarray(mdp.available),
        )

    def with_empowerment(
        self,
        horizon: int,
        sensor: Sensor,
        beta: float,
        actions: ArrayLike | None = None,
        *,
        method: Method = _EXACT,
        earned: str = "next",
        terminal_bonus: bool = True,
        extrinsic: bool = True,
        discount: float = 0.99,
    ) -> "FunctionalEnv":
        """This environment with empowerment in the reward: r + beta * M(s').

        `info` has the environment's own reward as "extrinsic_reward", and the bits of the state
        that was reached as "empowerment". The weight may change while an agent learns: it is
        `params.empowerment.weights["beta"]`.

        Args:
            horizon, sensor, actions, method: of the empowerment M, as in `EmpowermentReward`.
            beta, earned, terminal_bonus, extrinsic, discount: as in `EmpowermentReward`.

        Returns:
            Another environment; this one stays as it is.

        Raises:
            ValueError: as in `habilis.empowerment`, or a setting is out of its range.
        """
        bonus = Bonus(beta, earned=earned, terminal_bonus=terminal_bonus, extrinsic=extrinsic)
        weights = bonus.numbers(discount)
        noisy = self._mdp.slippery(self._slip)
        bits = kept_empowerment(noisy, horizon, sensor, actions, method=method)
        other = copy.copy(self)
        other._params = self._params.replace(
            empowerment=Empowerment(jnp.asarray(bits, jnp.float32), weights)
        )
        return other

    @property
    def default_params(self) -> Params:
        """The table and the settings, as this environment was made."""
        return self._params

    @property
    def name(self) -> str:
        """The world's name; "table" of a table."""
        return self._name

    @property
    def num_actions(self) -> int:
        """The number of actions."""
        return self._mdp.action_count

    def reset(self, key: PRNGKeyArray, params: Params | None = None) -> tuple[Array, State]:
        """Begins an episode.

        Args:
            key: has no part in it.
            params: the default ones if left out, as in all that follows.

        Returns:
            (observation, state).
        """
        return begin(self._given(params))

    def step(
        self,
        key: PRNGKeyArray,
        state: State,
        action: Action,
        params: Params | None = None,
    ) -> Stepped:
        """A step; where an episode has ended with it, the next one begins.

        Args:
            key: for slip and random outcomes.
            state: of this environment.
            action: int32.
            params: as in `reset`.

        Returns:
            (observation, state, reward, terminated, truncated, info).
        """
        return step(key, state, action, self._given(params))

    def reset_env(self, key: PRNGKeyArray, params: Params) -> tuple[Array, State]:
        """As `reset`.

        Args:
            key, params: as there.

        Returns:
            (observation, state).
        """
        return begin(params)

    def step_env(self, key: PRNGKeyArray, state: State, action: Action, params: Params) -> Alone:
        """A step; an episode that has ended with it stays where it is.

        Args:
            key, state, action, params: as in `step`.

        Returns:
            (observation, state, reward, terminated, info).
        """
        return step_alone(key, state, action, params)

    def observe(self, key: PRNGKeyArray, state: State, action: Any, params: Params) -> Array:
        """The observation of a state.

        Args:
            state, params: as in `step`.
            key, action: have no part in it.

        Returns:
            An observation.
        """
        return observed(state.index, params)

    def get_obs(
        self, state: State, params: Params | None = None, key: PRNGKeyArray | None = None
    ) -> Array:
        """The observation of a state.

        Args:
            state, params: as in `step`.
            key: has no part in it.

        Returns:
            An observation.
        """
        return observed(state.index, self._given(params))

    def action_mask(self, state: State, params: Params | None = None) -> Int8[Array, "A"]:
        """The actions that are available in a state.

        Args:
            state, params: as in `step`.

        Returns:
            int8, 1 for those that are, 0 for others.
        """
        return action_mask(state.index, self._given(params))

    def is_terminated(self, state: State, params: Params) -> Bool[Array, ""]:
        """Whether an episode that reaches a state terminates there.

        Args:
            state, params: as in `step`.

        Returns:
            bool.
        """
        return params.terminal[state.index]

    is_terminal = is_terminated

    def is_truncated(self, state: State, params: Params) -> Bool[Array, ""]:
        """Whether an episode that reaches a state is truncated there.

        Args:
            state, params: as in `step`.

        Returns:
            bool; not where it is terminated.
        """
        return cut_off(state, params)

    def discount(self, state: State, params: Params) -> Float[Array, ""]:
        """The discount of the future after a state.

        Args:
            state, params: as in `step`.

        Returns:
            float32, 0 where an episode is terminated, else 1.
        """
        return goes_on(params.terminal[state.index])

    def action_space(self, params: Params | None = None) -> Any:
        """The space of actions.

        Args:
            params: have no part in it.

        Returns:
            A `Discrete`: where gymnax is installed its own, as all spaces here; else of
            `envs.spaces`, with `sample(key)` and `contains(x)` too.
        """
        return classes().Discrete(self.num_actions)

    def observation_space(self, params: Params | None = None) -> Any:
        """The space of observations.

        Args:
            params: have no part in it.

        Returns:
            A `Box` of int32 or uint8.
        """
        if isinstance(self._shown, Marks):
            return classes().Box(0, 1, self._shown.still.shape, jnp.uint8)
        high = np.array(self._shown.sizes, np.int32) - 1
        return classes().Box(np.zeros_like(high), high, high.shape, jnp.int32)

    def state_space(self, params: Params | None = None) -> Any:
        """The space of states.

        Args:
            params: as in `reset`.

        Returns:
            A `Dict` with a `Discrete` for each attribute of a `State`.
        """
        limit = int(self._given(params).max_steps_in_episode)
        discrete = classes().Discrete
        return classes().Dict({"index": discrete(self._mdp.states), "time": discrete(limit + 1)})

    def _given(self, params: Params | None) -> Params:
        return self._params if params is None else params


def _shown(kind: str, mdp: TabularMDP, world: World | None) -> Labels | Marks:
    """The observations of all states."""
    if kind not in KINDS:
        raise ValueError(f"observation {kind!r} is unknown; use one of {', '.join(KINDS)}")
    labels = ranked(mdp) if world is None else cells(mdp, world)
    if kind == "factors":
        return labels
    if kind == "onehot":
        return one_hot(labels)
    if world is None:
        raise ValueError('observation "grid" needs a map; of a table use "factors" or "onehot"')
    return grid(labels, world)
