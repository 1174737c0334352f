"""A conventional JAX implementation, which recomputes everything in every step.

Advantage actor-critic as in single-file JAX libraries: the world's rules are arithmetic on
coordinates, observations are one-hot vectors into dense layers, actions come from
`jax.random.categorical` with a key split for each step, both outcomes of an ended episode are made
and one is selected, and the loss evaluates the network again. World, network, batch and optimiser
are those of `Config(world="corridor")`; as its models do, it takes a time
limit for an end.
"""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from habilis.learning.algorithms.a2c import A2C
from habilis.worlds.grid import STEPS
from habilis.worlds.world import World

LIMIT = 500  # steps of an episode


class State(NamedTuple):
    """Cells as (row, column), and the steps of the episode."""

    agent: Int[Array, "2"]
    tool: Int[Array, "2"]
    can: Int[Array, "2"]
    steps: Int[Array, ""]


class Room(NamedTuple):
    """A map with a picker."""

    wall: Bool[Array, "rows columns"]
    start: State
    goal: Int[Array, "2"]


class Step(NamedTuple):
    observation: Float[Array, "inputs"]
    action: Int[Array, ""]
    value: Float[Array, ""]
    reward: Float[Array, ""]
    done: Bool[Array, ""]


def room_of(world: World) -> Room:
    wall = np.zeros((world.height, world.width), bool)
    for cell in world.walls:
        wall[cell] = True
    agent, tool, can = (jnp.array(cell) for cell in (world.agent, world.tool_cell, world.object))
    return Room(jnp.asarray(wall), State(agent, tool, can, jnp.int32(0)), jnp.array(world.goal))


def moved(room: Room, state: State, action: Int[Array, ""]) -> State:
    """One action of a world with a picker (rules 1 to 5 of the worlds)."""
    step = jnp.array(STEPS)[action % 4]
    agent, tool, can, _ = state
    equipped = jnp.abs(agent - tool).sum() == 1
    attached = equipped & jnp.all(can - tool == tool - agent)
    entered = jnp.all(agent + step == can)
    pushed = jnp.where(entered | attached, can + step, can)
    swung = jnp.where(attached, agent + 2 * step, can)
    is_move = action < 4
    new_agent = jnp.where(is_move, agent + step, agent)
    carried = jnp.where(is_move, tool + step, agent + step)
    new_tool = jnp.where(equipped, carried, tool)
    new_can = jnp.where(is_move, pushed, swung)
    cells = jnp.stack([new_agent, new_tool, new_can])
    size = jnp.array(room.wall.shape)[None, :]
    inside = jnp.all((cells >= 0) & (cells < size))
    clear = ~jnp.any(room.wall[cells[:, 0], cells[:, 1]])
    apart = ~jnp.any(jnp.array([jnp.all(cells[i] == cells[i - 1]) for i in range(3)]))
    stays = ~(inside & clear & apart)
    chosen = jnp.where(stays, jnp.stack([agent, tool, can]), cells)
    return State(chosen[0], chosen[1], chosen[2], state.steps + 1)


def _observed(room: Room, state: State) -> Float[Array, "inputs"]:
    columns, cells = room.wall.shape[1], room.wall.size
    at = [cell[0] * columns + cell[1] for cell in (state.agent, state.tool, state.can)]
    return jnp.concatenate([jax.nn.one_hot(i, cells) for i in at])


class Network(eqx.Module):
    """Dense layers, tanh between them; logits and a value come out."""

    layers: list[eqx.nn.Linear]

    def __init__(self, inputs: int, outputs: int, hidden: tuple[int, ...], key: PRNGKeyArray):
        widths = (inputs, *hidden, outputs)
        keys = jax.random.split(key, len(widths) - 1)
        pairs = zip(widths[:-1], widths[1:], keys, strict=True)
        self.layers = [eqx.nn.Linear(i, o, key=k) for i, o, k in pairs]

    def __call__(self, x: Float[Array, "inputs"]) -> tuple[Array, Array]:
        for layer in self.layers[:-1]:
            x = jnp.tanh(layer(x))
        out = self.layers[-1](x)
        return out[:-1], out[-1]


def make_train(world: World, settings: A2C, updates: int):
    """A function from a key to what one run learned, to be compiled with `vmap` over keys.

    Returns:
        The function; it gives the network and the mean scaled reward of each update.
    """
    room = room_of(world)
    optimizer = optax.chain(
        optax.clip_by_global_norm(settings.clip),
        optax.adam(settings.learning_rate),
    )

    def env_step(state: State, action: Int[Array, ""]):
        after = moved(room, state, action)
        at_goal = jnp.all(after.can == room.goal)
        done = at_goal | (after.steps >= LIMIT)
        next_state = jax.tree.map(lambda new, old: jnp.where(done, new, old), room.start, after)
        return next_state, jnp.where(at_goal, 0.0, -settings.reward_scale), done

    def train(key: PRNGKeyArray):
        key, for_network = jax.random.split(key)
        network: Any = Network(3 * room.wall.size, 9, settings.hidden, for_network)
        states = jax.tree.map(lambda x: jnp.stack([x] * settings.envs), room.start)

        def act(carry, _):
            network, states, key = carry
            key, for_action = jax.random.split(key)
            observation = jax.vmap(_observed, (None, 0))(room, states)
            logits, value = jax.vmap(network)(observation)
            action = jax.random.categorical(for_action, logits)
            states, reward, done = jax.vmap(env_step)(states, action)
            return (network, states, key), Step(observation, action, value, reward, done)

        def loss(network, steps: Step, advantage, target):
            logits, value = jax.vmap(jax.vmap(network))(steps.observation)
            log_policy = jax.nn.log_softmax(logits)
            chosen = jnp.take_along_axis(log_policy, steps.action[..., None], axis=-1)[..., 0]
            entropy = -(jnp.exp(log_policy) * log_policy).sum(axis=-1)
            each = -chosen * advantage + settings.value * jnp.square(value - target)
            return (each - settings.entropy * entropy).mean()

        def update(carry, _):
            network, optimizer_state, states, key = carry
            (_, states, key), steps = jax.lax.scan(
                act, (network, states, key), None, settings.rollout
            )
            _, last = jax.vmap(network)(jax.vmap(_observed, (None, 0))(room, states))

            def back(carry, step):
                later, next_value = carry
                alive = 1.0 - step.done
                delta = step.reward + settings.discount * next_value * alive - step.value
                gae = delta + settings.discount * settings.gae_lambda * alive * later
                return (gae, step.value), gae

            _, advantage = jax.lax.scan(back, (jnp.zeros_like(last), last), steps, reverse=True)
            gradient = jax.grad(loss)(network, steps, advantage, advantage + steps.value)
            change, optimizer_state = optimizer.update(gradient, optimizer_state)
            network = eqx.apply_updates(network, change)
            return (network, optimizer_state, states, key), steps.reward.mean()

        carry = (network, optimizer.init(network), states, key)
        (network, *_), reward = jax.lax.scan(update, carry, None, updates)
        return network, reward

    return train
