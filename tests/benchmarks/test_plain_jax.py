"""The plain loop that ours is measured beside does the same as ours."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import habilis as hb
from habilis.benchmarks.plain_jax import LIMIT, State, make_train, moved, room_of
from habilis.learning.algorithms.a2c import A2C
from habilis.learning.config import Config


@pytest.mark.parametrize("name", ["corridor", "yard"])
def test_its_rules_are_those_of_the_table(name):
    world = hb.load_world(name)
    mdp = hb.tabulate(world)
    chosen = np.random.default_rng(0).choice(mdp.states, 2_000, replace=False)
    cells = {
        factor: jnp.stack(jnp.divmod(jnp.asarray(labels[chosen]), world.width), axis=1)
        for factor, labels in mdp.factors.items()
    }
    state = State(cells["agent"], cells["tool"], cells["object"], jnp.zeros(len(chosen), int))
    room = room_of(world)
    step = jax.jit(jax.vmap(moved, (None, 0, None)))
    for action in range(8):
        after = step(room, state, jnp.int32(action))
        reached = mdp.next_state[chosen, action]
        for factor, at in zip(("agent", "tool", "object"), after[:3], strict=True):
            expected = mdp.factor(factor)[reached]
            np.testing.assert_array_equal(at[:, 0] * world.width + at[:, 1], expected)


def test_it_learns():
    world = hb.World.parse("A.PCG", "row")
    settings = A2C(learning_rate=5e-3, reward_scale=1.0)
    _, reward = jax.jit(make_train(world, settings, updates=300))(jax.random.key(0))
    assert reward[:3].mean() < -0.9
    assert reward[-50:].mean() > -0.55, "the shortest plan has two steps: -1, then 0"


def test_its_episodes_are_as_long_as_ours():
    assert Config().episode_limit == LIMIT
