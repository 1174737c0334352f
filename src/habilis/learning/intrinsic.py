"""Intrinsic rewards: of a table of values, of counts, of a network that is distilled."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from habilis.empowerment import Exact, empowerment
from habilis.empowerment.combined import check_names
from habilis.empowerment.kinds import OPEN_LOOP
from habilis.learning.config import COUNT, DISTILLATION, NO_INTRINSIC, NOVELTIES, Config
from habilis.learning.dynamics import Dynamics
from habilis.learning.networks import Inputs, Network
from habilis.learning.rollout import Hyperparams
from habilis.mdp import TabularMDP
from habilis.rewards.measures import Named, measured, under_policy
from habilis.rewards.shaping import regularised

FOLLOWED = "followed"
"""The kind of reward whose table follows the agent's policy."""

_FEATURES, _WIDTH = 16, 32  # of the networks that are distilled
_RATE = 1e-3  # at which the one follows the other
_MEMORY = 0.999  # of the running scale of their distance


class Distillation(NamedTuple):
    """Random network distillation (Burda et al. 2019): what is well known is well predicted."""

    target: Network
    predictor: Network
    optimizer: optax.OptState
    scale: Float[Array, ""]
    """A running mean of squared distances, by whose root they are divided."""


def kind_of(config: Config) -> str:
    """Which of these a configuration asks for: "count", "rnd", "followed" or "table"."""
    if config.policy_every:
        return FOLLOWED
    return config.intrinsic if config.intrinsic in NOVELTIES else "table"


def value_table(mdp: TabularMDP, config: Config) -> Float[np.ndarray, "S"]:
    """M, the empowerment of every state in bits, or 0 where a table is not what is asked for.

    Where it follows the policy there is none before the first stretch of training.

    Of several sensors it is the sum, or the product, of their empowerments, as in `empowerment`.
    Where the world is stochastic, which takes far longer, it is kept on disk for the next time.
    """
    if config.intrinsic in (NO_INTRINSIC, *NOVELTIES) or config.policy_every:
        return np.zeros(mdp.states)
    if Named.of(config.intrinsic).kind == OPEN_LOOP and not mdp.is_stochastic:
        return empowerment(mdp, config.horizon, config.intrinsic)
    return measured(mdp, config.horizon, config.intrinsic, config.algorithm.discount)


def followed_table(
    mdp: TabularMDP, config: Config, policy: Float[np.ndarray, "S A"]
) -> Float[np.ndarray, "S"]:
    """The effective empowerment of every state under an agent's policy, in bits."""
    there = np.where(mdp.available, np.asarray(policy, np.float64), 0)
    there /= there.sum(axis=1, keepdims=True)
    discount = config.algorithm.discount
    return under_policy(mdp, config.intrinsic, discount, there, Exact().tolerance)


def check_sensors(mdp: TabularMDP, intrinsic: str) -> None:
    """Refuses an intrinsic reward of which a table has no factor.

    Raises:
        ValueError: names it, and those that there are.
    """
    others = NO_INTRINSIC, *NOVELTIES
    if intrinsic not in others:
        check_names(mdp, str(Named.of(intrinsic).sensor), "intrinsic", others)


def weights(config: Config) -> dict[str, float]:
    """The numerical reward settings of a configuration."""
    return config.bonus.numbers(config.algorithm.discount)


def init(kind: str, dynamics: Dynamics, rows: int, key: PRNGKeyArray) -> Any:
    """The state of a reward that changes while it is earned."""
    if kind in (COUNT, FOLLOWED):
        return jnp.zeros(dynamics.states)
    if kind == DISTILLATION:
        target, predictor = (
            Network(rows, dynamics.inputs.shape[1], _FEATURES, (_WIDTH,), k, gain=1.0)
            for k in jax.random.split(key)
        )
        return Distillation(target, predictor, _optimizer().init(_tree(predictor)), jnp.float32(1))
    return ()


def values(
    kind: str, novelty: Any, table: Float[Array, "S"], dynamics: Dynamics, states: Int[Array, "*n"]
) -> Float[Array, "*n"]:
    """M of some states."""
    if kind == COUNT:
        return jax.lax.rsqrt(novelty[states] + 1)
    if kind == FOLLOWED:
        return novelty[states]
    if kind == DISTILLATION:
        return _distance(
            novelty.predictor, novelty.target, dynamics.inputs[states]
        ) * jax.lax.rsqrt(novelty.scale + 1e-8)
    return table[states]


def visited(
    kind: str,
    novelty: Any,
    dynamics: Dynamics,
    states: Int[Array, "T E"],
    mask: Bool[Array, "T E"] | None = None,
) -> Any:
    """That state after these states of the table were entered, by the steps that were made."""
    flat = None if mask is None else mask.reshape(-1)
    if kind == COUNT:
        visits = 1.0 if flat is None else flat.astype(novelty.dtype)
        return novelty.at[states.reshape(-1)].add(visits)
    if kind == DISTILLATION:
        inputs = dynamics.inputs[states.reshape(-1)]

        def loss(predictor: Network) -> tuple[Float[Array, ""], Float[Array, "n"]]:
            distance = _distance(predictor, novelty.target, inputs)
            return distance.mean(where=flat), distance

        gradient, distance = jax.grad(loss, has_aux=True)(novelty.predictor)
        change, optimizer = _optimizer().update(gradient, novelty.optimizer)
        scale = _MEMORY * novelty.scale + (1 - _MEMORY) * jnp.square(distance).mean(where=flat)
        predictor = jax.tree.map(jnp.add, novelty.predictor, change)
        return Distillation(novelty.target, predictor, optimizer, scale)
    return novelty


def reward(
    hyperparams: Hyperparams,
    extrinsic: Float[Array, "*n"],
    of_next: Float[Array, "*n"],
    of_current: Float[Array, "*n"],
    terminated: Bool[Array, "*n"],
    global_step: Float[Array, ""],
) -> Float[Array, "*n"]:
    """The reward that the agent learns from, after so many environment steps, scaled."""
    whole = regularised(hyperparams, extrinsic, of_next, of_current, terminated, global_step, jnp)
    return hyperparams["reward_scale"] * whole


def _distance(one: Network, other: Network, inputs: Inputs) -> Float[Array, "*batch"]:
    return jnp.square(one(inputs) - other(inputs)).mean(axis=-1)


def _tree(network: Network) -> Any:
    """A network as optax has it: any tree of arrays."""
    return network


def _optimizer() -> optax.GradientTransformation:
    return optax.adam(_RATE)
