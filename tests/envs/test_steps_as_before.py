"""Steps of the environments are what they were, random outcomes included, byte for byte.

What is expected was recorded from the edition that drew outcomes in each environment by itself.
"""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from digests import digest

import habilis as hb
from habilis.envs import TableEnv, TableVectorEnv, WorldEnv, WorldVectorEnv
from habilis.envs.functional import FunctionalEnv

FAILS = "P = picker slip 0.3\nA....\n.P...\n..C..\n.....\n....G\n"
SEVERAL = "P = picker slip 0.25\nR = rake slip 0.5\n.AP.CG\n......\nR.....\n"
PARTLY = hb.TabularMDP.deterministic(
    [[1, 4, -1], [2, 0, 1], [3, 1, -1], [-1, 2, 0], [0, 3, 4]],
    reward=[[0.5, -1, 0], [2, 3, 5], [0.25, 1, 0], [0, 7, -2], [1, -3, 0.125]],
    terminal=[0, 0, 1, 0, 0],
    start=4,
)
STEPS = 400


def one_by_one(env: TableEnv) -> str:
    random = np.random.default_rng(1)
    observed, info = env.reset(seed=3)
    seen = [observed.tolist(), info["state"]]
    for _ in range(STEPS):
        mask = info.get("action_mask", np.ones(env.mdp.action_count))
        shown, reward, ended, cut, info = env.step(random.choice(np.flatnonzero(mask)))
        seen += [shown.tolist(), float(reward), bool(ended), bool(cut), info["state"]]
        if ended or cut:
            _, info = env.reset()
    return digest(*seen)


def many_at_once(envs: TableVectorEnv) -> str:
    random = np.random.default_rng(2)
    _, info = envs.reset(seed=4)
    seen = []
    for _ in range(STEPS):
        mask = info.get("action_mask", np.ones((envs.num_envs, envs.mdp.action_count)))
        drawn = random.random(mask.shape) * mask
        shown, *stepped, info = envs.step(drawn.argmax(axis=1))
        seen += [shown, *stepped, info["state"]]
    return digest(*seen)


def compiled(env: FunctionalEnv) -> str:
    keys = jax.random.split(jax.random.key(5), (STEPS, 8))
    actions = jnp.asarray(np.random.default_rng(6).integers(env.num_actions, size=(STEPS, 8)))
    params = env.default_params

    def step(states, drawn):
        key, action = drawn
        _, after, *stepped, info = jax.vmap(env.step, (0, 0, 0, None))(key, states, action, params)
        return after, (info["state"], *stepped)

    _, states = jax.vmap(env.reset, (0, None))(keys[0], params)
    return digest(
        *map(np.asarray, jax.lax.scan(step, states, (keys, actions.astype(jnp.int32)))[1])
    )


CASES = {
    "sure": (hb.load_world("yard"), 0.0),
    "slips": (hb.load_world("yard"), 0.25),
    "fails": (hb.World.parse(FAILS, name="fails"), 0.0),
    "fails and slips": (hb.World.parse(FAILS, name="fails"), 0.25),
    "several": (hb.World.parse(SEVERAL, name="several"), 0.1),
    "partly": (PARTLY, 0.3),
}
BEFORE = {
    "sure": ("426ca53f87c811a7", "c38e99967564b107", "bf22efc38139803a"),
    "slips": ("b79a5684497c439d", "3a20dae8d750998b", "b85fe1f29e75eb6a"),
    "fails": ("d1b4fcbc9c9853bc", "0385f867cf7a815c", "c3cdc01d1dd0c067"),
    "fails and slips": ("482dc3815c369e7e", "febca20730118df4", "2ec112699bba3730"),
    "several": ("d8cb79a302d0dab9", "0f957483faee7a72", "c3dacff8bf204bdc"),
    "partly": ("77fa3630eb984ec9", "719fa1a825f7436d", "8d32441038d66960"),
}


@pytest.mark.parametrize("case", CASES)
def test_steps_are_what_they_were(case: str):
    world, slip = CASES[case]
    if isinstance(world, hb.World):
        found = (
            one_by_one(WorldEnv(world, max_steps=30, slip=slip)),
            many_at_once(WorldVectorEnv(16, world, max_steps=30, slip=slip)),
        )
    else:
        found = (
            one_by_one(TableEnv(world, max_steps=30, slip=slip)),
            many_at_once(TableVectorEnv(world, 16, max_steps=30, slip=slip)),
        )
    assert (*found, compiled(FunctionalEnv(world, max_steps=30, slip=slip))) == BEFORE[case]
