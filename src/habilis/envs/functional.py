"""The worlds as functions of JAX: an environment for `jit`, `vmap` and `scan`.

The interface is gymnax's from 1.0 on, whose `step` tells `terminated` and `truncated` apart (six
values; before there were five, with one `done`). gymnax itself is not needed, the extras
`habilis[learn]` and `habilis[gymnasium]` are.
"""

import copy
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, Int32, PRNGKeyArray

from habilis.empowerment.bonus import Bonus, regularised
from habilis.empowerment.keeping import kept_empowerment
from habilis.empowerment.sensors import Sensor
from habilis.envs.observations import Labels, Marks, cells, grid, one_hot, ranked
from habilis.envs.params import Empowerment, Params, State
from habilis.envs.reward import EMPOWERMENT, EXTRINSIC
from habilis.envs.spaces import classes
from habilis.envs.table import MAX_STEPS, check_episode
from habilis.envs.world import as_world
from habilis.mdp import TabularMDP
from habilis.worlds.table import tabulate
from habilis.worlds.world import World

KINDS = ("factors", "onehot", "grid")

Info = dict[str, Any]
Stepped = tuple[
    Array, State, Float[Array, ""], Bool[Array, ""], Bool[Array, ""], Info
]  # observation, state, reward, terminated, truncated, info


class FunctionalEnv:
    """A world, or a deterministic table, as functions without a state of their own.

    Rewards, ends and time limits are those of `WorldEnv` and of `train`: an episode that ends by
    the world's rules in the last step it has is terminated, not truncated. The step that ends an
    episode returns the next one's first observation and state, and has the last observation in
    `info["final_observation"]`. `info` has "terminated" and "truncated" too, and of the state that
    was reached "state" (its index), "equipped", "attached" (bool) and "discount" (0 where it is
    terminal, 1 elsewhere).

    Actions are int32; JAX cannot refuse one that does not exist. The key of a step matters only
    where there is slip, that of a reset never. All methods work inside `jit`, `vmap` and `scan`;
    `params` may be left out: they are `default_params` then.

    Example:
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
        tool: str | None = None,
        max_steps: int = MAX_STEPS,
        observation: str = "factors",
        slip: float = 0.0,
    ):
        """
        Args:
            world: a world, a built-in one's name, the path of a map, or the text of one; or a
                deterministic table.
            tool: takes the place of the map's own; `None` keeps that.
            max_steps: the length of an episode, at most.
            observation: "factors", int32, the cells of agent, tool and object, each
                `row * columns + column` (of a table each factor, counted from 0 among the values
                that it has); "onehot", the same as zeros and ones, uint8; "grid", uint8
                `[channels, rows, columns]`, of worlds only. See `observations.observation`.
            slip: the probability that an action drawn uniformly takes the place of the chosen one.

        Raises:
            ValueError: no such world, tool or observation, the table is stochastic, or a number
                is out of its range.
        """
        check_episode(max_steps, slip)
        if isinstance(world, TabularMDP):
            if tool is not None:
                raise ValueError(f"tool is {tool!r}, but a table has its own moves; give a world")
            mdp, place, self._name = world, None, "table"
        else:
            place = as_world(world)
            place = place if tool is None else place.with_tool(tool)
            mdp, self._name = tabulate(place), place.name
        shown = _shown(observation, mdp, place)
        self._mdp, self._slip, self._shown = mdp, slip, shown
        self._params = Params(
            next_state=jnp.asarray(mdp.next_state),
            reward=jnp.asarray(mdp.reward),
            terminal=jnp.asarray(mdp.terminal),
            start=mdp.start,
            max_steps_in_episode=max_steps,
            flags={name: jnp.asarray(flag) for name, flag in mdp.flags.items()},
            seen=jnp.asarray(shown.at if isinstance(shown, Marks) else shown.of, jnp.int32),
            background=jnp.asarray(shown.still) if isinstance(shown, Marks) else None,
            slip=slip or None,
        )

    def with_empowerment(
        self,
        horizon: int,
        sensor: Sensor,
        beta: float,
        actions: Sequence[int] | None = None,
        *,
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
            horizon, sensor, actions: of the empowerment M, as in `habilis.empowerment`.
            beta, earned, terminal_bonus, extrinsic, discount: as in `EmpowermentReward`.

        Raises:
            ValueError: as in `habilis.empowerment`, or a setting is out of its range.
        """
        bonus = Bonus(beta, earned=earned, terminal_bonus=terminal_bonus, extrinsic=extrinsic)
        weights = bonus.numbers(discount)
        bits = kept_empowerment(self._mdp.slippery(self._slip), horizon, sensor, actions)
        other = copy.copy(self)
        other._params = self._params.replace(
            empowerment=Empowerment(jnp.asarray(bits, jnp.float32), weights)
        )
        return other

    @property
    def default_params(self) -> Params:
        return self._params

    @property
    def name(self) -> str:
        """The world's name; "table" of a table."""
        return self._name

    @property
    def num_actions(self) -> int:
        return self._mdp.action_count

    def reset(self, key: PRNGKeyArray, params: Params | None = None) -> tuple[Array, State]:
        """The first observation and state of an episode."""
        return _reset(self._params if params is None else params)

    def step(
        self,
        key: PRNGKeyArray,
        state: State,
        action: Int[Array, ""],
        params: Params | None = None,
    ) -> Stepped:
        """A step, and where an episode has ended with it, the begin of the next.

        Returns:
            (observation, state, reward, terminated, truncated, info).
        """
        return _step(key, state, action, self._params if params is None else params)

    def reset_env(self, key: PRNGKeyArray, params: Params) -> tuple[Array, State]:
        """As `reset`."""
        return _reset(params)

    def step_env(
        self, key: PRNGKeyArray, state: State, action: Int[Array, ""], params: Params
    ) -> tuple[Array, State, Float[Array, ""], Bool[Array, ""], Info]:
        """A step alone; no episode is begun.

        Returns:
            (observation, state, reward, terminated, info).
        """
        return _step_env(key, state, action, params)

    def observe(self, key: PRNGKeyArray, state: State, action: Any, params: Params) -> Array:
        """What is shown of a state; key and action have no part in it."""
        return _observation(state.index, params)

    def get_obs(self, state: State, params: Params | None = None, key: Any = None) -> Array:
        """What is shown of a state; the key has no part in it."""
        return _observation(state.index, self._params if params is None else params)

    def is_terminated(self, state: State, params: Params) -> Bool[Array, ""]:
        """Whether the entry of this state ends an episode."""
        return params.terminal[state.index]

    is_terminal = is_terminated

    def is_truncated(self, state: State, params: Params) -> Bool[Array, ""]:
        """Whether an episode is cut off in this state."""
        return (state.time >= params.max_steps_in_episode) & ~params.terminal[state.index]

    def discount(self, state: State, params: Params) -> Float[Array, ""]:
        """0 where an episode ends by the world's rules, 1 elsewhere."""
        return _discount(params.terminal[state.index])

    def action_space(self, params: Params | None = None) -> Any:
        """`Discrete`; gymnax's where that is installed, as all spaces here."""
        return classes().Discrete(self.num_actions)

    def observation_space(self, params: Params | None = None) -> Any:
        """`Box`, of int32 or uint8."""
        if isinstance(self._shown, Marks):
            return classes().Box(0, 1, self._shown.still.shape, jnp.uint8)
        high = np.array(self._shown.sizes, np.int32) - 1
        return classes().Box(np.zeros_like(high), high, high.shape, jnp.int32)

    def state_space(self, params: Params | None = None) -> Any:
        """`Dict` of what a `State` has."""
        limit = (self._params if params is None else params).max_steps_in_episode
        discrete = classes().Discrete
        return classes().Dict(
            {"index": discrete(self._mdp.states), "time": discrete(int(limit) + 1)}
        )


def _shown(kind: str, mdp: TabularMDP, world: World | None) -> Labels | Marks:
    """What is observed of each state."""
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


@jax.jit
def _reset(params: Params) -> tuple[Array, State]:
    state = State(jnp.asarray(params.start, jnp.int32), jnp.int32(0))
    return _observation(state.index, params), state


@jax.jit
def _step(key: PRNGKeyArray, state: State, action: Int[Array, ""], params: Params) -> Stepped:
    last, reached, reward, terminated, info = _step_env(key, state, action, params)
    truncated = (reached.time >= params.max_steps_in_episode) & ~terminated
    ended = terminated | truncated
    after = State(
        jnp.where(ended, jnp.asarray(params.start, jnp.int32), reached.index),
        jnp.where(ended, 0, reached.time),
    )
    told = {"terminated": terminated, "truncated": truncated, "final_observation": last}
    seen = _observation(after.index, params)
    return seen, after, reward, terminated, truncated, info | told


@jax.jit
def _step_env(
    key: PRNGKeyArray, state: State, action: Int[Array, ""], params: Params
) -> tuple[Array, State, Float[Array, ""], Bool[Array, ""], Info]:
    actions = params.next_state.shape[-1]
    if params.slip is not None:
        slips, draws = jax.random.split(key)
        drawn = jax.random.randint(draws, (), 0, actions)
        action = jnp.where(jax.random.uniform(slips) < params.slip, drawn, action)
    transition = state.index * actions + jnp.asarray(action, jnp.int32)
    index = params.next_state.reshape(-1)[transition]
    terminated = params.terminal[index]
    info = {
        "state": index,
        "discount": _discount(terminated),
        **{name: flag[index] for name, flag in params.flags.items()},
    }
    reward = params.reward.reshape(-1)[transition]
    if params.empowerment is not None:
        bits, weights = params.empowerment.bits, params.empowerment.weights
        info |= {EXTRINSIC: reward, EMPOWERMENT: bits[index]}
        reward = regularised(
            weights, reward, bits[index], bits[state.index], terminated, jnp.int32(0), jnp
        )
    reached = State(index, state.time + 1)
    return _observation(index, params), reached, reward, terminated, info


def _observation(index: Int32[Array, ""], params: Params) -> Array:
    seen = params.seen[index]
    if params.background is None:
        return seen
    return params.background.reshape(-1).at[seen].set(1).reshape(params.background.shape)


def _discount(terminated: Bool[Array, ""]) -> Float[Array, ""]:
    return jnp.where(terminated, jnp.float32(0), jnp.float32(1))
