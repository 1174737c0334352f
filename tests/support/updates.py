"""Updates of the compiled loop, and the same in the float64 reference.

The loop tells which transitions it made; from these and the table the reference has its rollout.
"""

from dataclasses import fields, replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Int
from reference_actor_critic import Rollout, Settings, Step, ppo_steps, steps
from reference_networks import Layers, Parameters

from habilis.learning.algorithms import ALGORITHMS, actor_critic
from habilis.learning.algorithms.ppo import PPO
from habilis.learning.algorithms.protocol import bound
from habilis.learning.config import COORDINATES, Config
from habilis.learning.dynamics import make_dynamics
from habilis.learning.lanes import Lane, Log, Program, advance, settings_of, start_lanes
from habilis.learning.networks import Network
from habilis.learning.rollout import Context, Experience
from habilis.mdp import HELD, TabularMDP


class Update(NamedTuple):
    """A lane before and after one update, and what the update tells of it."""

    before: Lane
    after: Lane
    log: Log


def chain(states: int, available: bool = True) -> TabularMDP:
    """Steps forward lead to the end, a step back to the start, and the third action waits.

    On a map of two rows: factors a cell, and a label that is none.

    Args:
        states: how many there are, the last of them terminal.
        available: whether every action may be taken, or waiting is not possible in odd states.
    """
    random = np.random.default_rng(states)
    state = np.arange(states)
    next_state = np.stack([np.minimum(state + 1, states - 1), 0 * state, state], axis=1)
    if not available:
        next_state[1:-1:2, 2] = -1
    reward = random.integers(-8, 9, size=(states, 3)) / 4
    mdp = TabularMDP.deterministic(next_state, reward, state == states - 1)
    columns = (states + 1) // 2
    cell = random.permutation(2 * columns)[:states]
    factors = {"agent": cell.astype(np.int32), HELD: (state % 3 - 1).astype(np.int32)}
    return replace(mdp, factors=factors, shape=(2, columns))


def updates(mdp: TabularMDP, config: Config, count: int = 2) -> list[Update]:
    """The first updates of one run, each a stretch of its own."""
    dynamics, rows = make_dynamics(mdp, observation=config.observation)
    program = replace(Program.of(config, rows, 1), updates=1)
    settings = jax.tree.map(
        lambda leaf: np.asarray(leaf)[None], settings_of(config, np.zeros(mdp.states))
    )
    lanes = start_lanes(dynamics, program, jax.random.key(config.seed)[None])
    found = []
    for _ in range(count):
        before = jax.tree.map(np.array, lanes)  # copied, for it is given away
        lanes, log = advance(dynamics, settings, lanes, program)
        one = jax.tree.map(lambda leaf: np.array(leaf)[0], (before, lanes, log))
        found.append(Update(*one))
    return found


def parameters_of(network: Any) -> Parameters:
    """A learner's networks as the reference has them."""

    def layers(one: Network) -> Layers:
        pairs = [(one.embedding, one.bias), *one.layers]
        return [(np.asarray(w, float), np.asarray(b, float)) for w, b in pairs]

    if isinstance(network, Network):
        *trunk, (weight, bias) = layers(network)
        return Parameters([(weight[:, :-1], bias[:-1])], [(weight[:, -1:], bias[-1:])], trunk)
    return Parameters(layers(network.policy), layers(network.value))


def inputs_of(mdp: TabularMDP, observation: str) -> np.ndarray:
    """The observation of each state of `chain`, written out independently."""
    cell, held = mdp.factors["agent"], mdp.factors[HELD]
    if observation == COORDINATES:
        assert mdp.shape is not None
        row, column = cell // mdp.shape[1], cell % mdp.shape[1]
        return np.stack([2 * row - 1, 2 * column / (mdp.shape[1] - 1) - 1, held], axis=1)
    cells = sorted(set(cell.tolist()))
    ranks = [cells.index(label) for label in cell.tolist()]
    return np.stack([ranks, len(cells) + held + 1], axis=1)


def rollouts_of(mdp: TabularMDP, config: Config, made: list[Update]) -> list[Rollout]:
    """The environments' steps in each update, according to the reference."""
    inputs = inputs_of(mdp, config.observation)
    found, taken, episodes = [], 0, 0
    for update in made:
        transition, truncated = (np.asarray(part[0]) for part in update.log[:2])
        mask = transition >= 0
        state, action = np.divmod(np.where(mask, transition, 0), mdp.action_count)
        reached = mdp.next_state[state, action]
        terminated = mdp.terminal[reached] & mask
        found.append(
            Rollout(
                inputs=inputs[state],
                actions=action,
                rewards=mdp.reward[state, action],
                terminated=terminated,
                truncated=truncated,
                cut_inputs=inputs[reached],
                mask=mask,
                available=mdp.available[state] | ~mask[..., None],
                count=taken if schedule_of(config) == "steps" else episodes,
            )
        )
        taken += int(mask.sum())
        episodes += int((terminated | truncated).sum())
    return found


def schedule_of(config: Config) -> str:
    return getattr(config.algorithm, "schedule")  # noqa: B009 - not every algorithm has one


def reference_settings(config: Config) -> dict[str, Any]:
    """The settings that the reference knows, by their names."""
    known = {f.name for f in fields(Settings)}
    given = {name: value for name, value in config.as_dict().items() if name in known}
    return given | {
        "normalise_over": "minibatch"
        if ALGORITHMS.name_of(config.algorithm) == "ppo"
        else "rollout"
    }


def reference_updates(
    config: Config, made: list[Update], rollouts: list[Rollout]
) -> list[list[Step]]:
    """The steps of each update, all from the run's initial weights."""
    parameters, settings = (
        parameters_of(made[0].before.train_state.parameters),
        reference_settings(config),
    )
    if not isinstance(config.algorithm, PPO):
        return [[step] for step in steps(parameters, rollouts, **settings)]
    found, moments = [], None
    for update, rollout in zip(made, rollouts, strict=True):
        order = minibatches(config.algorithm, update.before)
        some = ppo_steps(parameters, rollout, order, moments=moments, **settings)
        parameters, moments = some[-1].parameters, some[-1].moments
        found.append(some)
    return found


def minibatches(algorithm: PPO, before: Lane) -> Int[np.ndarray, "steps size"]:
    """Which steps of a rollout PPO takes together, from its lane's random numbers."""
    key = jax.random.fold_in(jax.random.wrap_key_data(before.key), -1 - before.updates)
    size = algorithm.envs * algorithm.rollout
    order = [jax.random.permutation(k, size) for k in jax.random.split(key, algorithm.epochs)]
    return np.concatenate(order).reshape(-1, size // algorithm.minibatches)


def advantages_of(
    mdp: TabularMDP, config: Config, update: Update, rollout: Rollout
) -> tuple[np.ndarray, np.ndarray]:
    """Advantages and targets of an update as the learner has them."""
    dynamics, _ = make_dynamics(mdp, observation=config.observation)
    network = jax.tree.map(jnp.asarray, update.before.train_state.parameters)
    transition = jnp.asarray(np.maximum(update.log.transition[0], 0))
    terminal = rollout.truncated & config.limit_is_terminal
    nothing: Any = None
    experience = Experience(
        state=dynamics.state_of(transition),
        action=dynamics.action_of(transition),
        next_state=dynamics.transitions.next_state[transition],
        reward=jnp.asarray(rollout.rewards * config.algorithm.reward_scale, jnp.float32),
        terminated=jnp.asarray(rollout.terminated | terminal),
        truncated=jnp.asarray(rollout.truncated & ~terminal),
        aux=nothing,
        last_state=jnp.asarray(update.after.env_state.state),
        mask=None if rollout.mask is None else jnp.asarray(rollout.mask),
    )
    hyperparams = settings_of(config, np.zeros(mdp.states)).hyperparams
    algorithm: Any = bound(config.algorithm, hyperparams)

    @jax.jit
    def advantages(network: Any, experience: Any) -> tuple[Any, Any]:
        shown = dynamics.inputs[experience.state]
        aux = actor_critic.Decision(shown, network.activations(shown))
        context = Context(dynamics, jnp.float32(0), jax.random.key(0), jnp.abs)
        return actor_critic.advantages(algorithm, context, network, experience._replace(aux=aux))

    advantage, target = advantages(network, experience)
    return np.asarray(advantage), np.asarray(target)
