"""Environments of worlds with several tools and objects, and of tools that may fail."""

import copy
import pickle

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import habilis as hb
from habilis.envs import EmpowermentReward, WorldEnv, WorldVectorEnv
from habilis.envs.functional import FunctionalEnv
from habilis.worlds.pictures.figures import frame

KINDS = ("factors", "onehot", "grid", "rgb")
SLIPS = "P = picker slip 0.25\nR = rake slip 0.5\n.AP.CG\n......\nR.....\n"
PUSH, EAST = 1, 1


@pytest.fixture(scope="module")
def small() -> hb.World:
    return hb.World.parse("R = rake\nD = can\nG = goal of C\nH = goal of D\nAP.R\n.C.D\nG..H\n")


def walk(env, steps: int, seed: int = 0) -> list:
    random = np.random.default_rng(seed)
    seen = [env.reset(seed=seed)]
    for _ in range(steps):
        seen.append(env.step(int(random.integers(env.action_space.n))))
        if seen[-1][2] or seen[-1][3]:
            seen.append(env.reset())
    return seen


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("slips", [False, True])
def test_every_observation_passes_gymnasiums_own_check(kind: str, slips: bool, small: hb.World):
    world = hb.World.parse(SLIPS) if slips else small
    env = gymnasium.make("habilis/World-v0", world=world, observation=kind, render_mode="rgb_array")
    check_env(env.unwrapped)
    assert env.reset(seed=0)[1].keys() >= {"state", "equipped", "attached"}


def test_a_map_file_may_have_several_things(tmp_path):
    path = tmp_path / "room.txt"
    path.write_text("R = rake\ndrop: true\nAP..\n.C.R\n...G\n")
    env = gymnasium.make("habilis/World-v0", world=str(path))
    assert env.action_space == gymnasium.spaces.Discrete(9)
    assert env.get_wrapper_attr("mdp").actions[8] == "drop"


def test_factors_are_the_cells_and_then_what_is_in_hand():
    env = WorldEnv("R = rake\ndrop: true\nAP..\n.C.R\n...G\n")
    assert env.observation_space.nvec.tolist() == [12, 12, 12, 12, 3, 3]
    assert env.reset(seed=0)[0].tolist() == [0, 1, 7, 5, 1, 0]  # the picker is in hand
    assert env.step(8)[0].tolist() == [0, 1, 7, 5, 0, 1]  # put down
    assert env.step(2)[0].tolist() == [4, 1, 7, 5, 0, 0]  # and left


def test_the_grid_has_a_channel_for_every_thing_goal_and_hand(small: hb.World):
    env = WorldEnv(small, observation="grid")
    shown = env.reset(seed=0)[0]
    assert shown.shape == (1 + 2 + 1 + 2 + 2 + 1, 3, 4)
    ones = {
        channel: list(zip(*np.nonzero(plane), strict=True)) for channel, plane in enumerate(shown)
    }
    assert ones[1] == [(2, 0)]
    assert ones[2] == [(2, 3)]
    assert ones[3] == [(0, 0)]
    assert ones[4] == [(0, 1)]
    assert ones[5] == [(0, 3)]
    assert ones[6] == [(1, 1)]
    assert ones[7] == [(1, 3)]
    assert ones[8] == [(0, 1)]  # the picker, in hand


def test_the_grid_shows_no_tool_in_hand_where_there_is_none():
    shown = WorldEnv("R = rake\nA...\n....\nP.CR\n...G\n", observation="grid").reset(seed=0)[0]
    assert shown[-1].sum() == 0
    assert shown[2].sum() == 1  # the agent's own mark


def test_pictures_are_those_of_the_states(small: hb.World):
    env = WorldEnv(small, render_mode="rgb_array", observation="rgb")
    for step in walk(env, 30):
        state = hb.placement(env.world, env.mdp, step[-1]["state"])
        np.testing.assert_array_equal(step[0], frame(state, 16))
    np.testing.assert_array_equal(
        env.render(), frame(hb.placement(env.world, env.mdp, env.state), 32)
    )


def test_coloured_text_is_rendered(small: hb.World):
    env = WorldEnv(small, render_mode="ansi")
    env.reset(seed=0)
    assert "\x1b[" in env.render()


@pytest.mark.parametrize("kind", KINDS)
def test_many_at_once_are_as_one(kind: str, small: hb.World):
    one, many = WorldEnv(small, observation=kind), WorldVectorEnv(3, small, observation=kind)
    assert (one.reset(seed=0)[0] == many.reset(seed=0)[0][1]).all()
    random = np.random.default_rng(3)
    for _ in range(40):
        action = int(random.integers(8))
        seen, reward, *_, info = one.step(action)
        rows, rewards, *_, infos = many.step(np.full(3, action))
        assert (rows == seen).all()
        assert (rewards == reward).all()
        assert (infos["state"] == info["state"]).all()


@pytest.mark.parametrize("kind", KINDS[:3])
def test_the_functional_environment_is_as_the_other(kind: str, small: hb.World):
    one, other = WorldEnv(small, observation=kind), FunctionalEnv(small, observation=kind)
    key = jax.random.key(0)
    seen, state = other.reset(key)
    assert (np.asarray(seen) == one.reset(seed=0)[0]).all()
    random = np.random.default_rng(4)
    for _ in range(40):
        action = int(random.integers(8))
        seen, state, reward, terminated, _, info = other.step(key, state, jnp.int32(action))
        wanted = one.step(action)
        assert (np.asarray(info["final_observation"]) == wanted[0]).all()
        assert (float(reward), bool(terminated)) == (wanted[1], wanted[2])


def test_a_tool_fails_as_often_as_it_says_and_the_reward_is_of_what_happened():
    mdp = hb.tabulate(hb.World.parse(SLIPS))
    envs = WorldVectorEnv(20_000, SLIPS)
    envs.reset(seed=1)
    envs.step(np.full(20_000, PUSH))  # the picker comes beside the can, for sure
    _, rewards, terminated, *_ = envs.step(np.full(20_000, EAST))
    assert set(rewards) == {0.0, -1.0}
    assert ((rewards == 0) == terminated).all()
    assert abs(terminated.mean() - 0.75) < 0.015
    assert mdp.is_stochastic


def test_functional_tools_fail_as_often():
    env = FunctionalEnv(SLIPS)
    keys = jax.random.split(jax.random.key(0), 20_000)
    _, state = env.reset(keys[0])
    _, state, *_ = env.step(keys[0], state, jnp.int32(PUSH))
    step = jax.vmap(env.step, in_axes=(0, None, None))
    _, _, reward, terminated, *_ = step(keys, state, jnp.int32(EAST))
    assert abs(float(terminated.mean()) - 0.75) < 0.015
    assert ((np.asarray(reward) == 0) == np.asarray(terminated)).all()


def test_slip_of_actions_is_independent_of_tools_that_fail():
    """With both, a push works with (1 - slip) * 0.75, and by chance with slip / 8 * 0.75."""
    env = FunctionalEnv(SLIPS, slip=0.5)
    state = env.reset(jax.random.key(0))[1]
    mdp = hb.tabulate(hb.World.parse(SLIPS))
    state = state.replace(index=int(mdp.transition(PUSH)[[mdp.start]].indices[0]))
    step = jax.vmap(env.step, in_axes=(0, None, None))
    terminated = step(jax.random.split(jax.random.key(7), 20_000), state, jnp.int32(EAST))[3]
    assert abs(float(terminated.mean()) - 0.75 * (0.5 + 0.5 / 8)) < 0.015


def test_the_same_seed_fails_alike():
    env = WorldEnv(SLIPS)
    one, other = walk(env, 60, seed=5), walk(WorldEnv(SLIPS), 60, seed=5)
    assert [step[-1]["state"] for step in one] == [step[-1]["state"] for step in other]


@pytest.mark.parametrize("text", [SLIPS, "R = rake\nAP..\n.C.R\n...G\n"], ids=["slips", "sure"])
def test_copies_go_on_alike(text: str):
    env = WorldEnv(text, render_mode="rgb_array")
    walk(env, 10)
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert other.state == env.state
        one, same = copy.deepcopy(other).step(3), other.step(3)
        assert one[-1] == same[-1]
        assert same[-1].keys() >= {"state", "equipped", "attached"}


def test_empowerment_of_one_of_several_objects_is_in_the_reward(small: hb.World):
    env = EmpowermentReward(WorldEnv(small), horizon=2, sensor="object:can2", beta=0.5)
    bits = hb.empowerment(hb.tabulate(small), 2, "object:can2")
    for step in walk(env, 20)[1:]:
        if len(step) == 5:
            worth = step[4]["extrinsic_reward"] + 0.5 * bits[step[4]["state"]]
            assert step[1] == pytest.approx(worth)
    with pytest.raises(ValueError, match="object:can, object:can2"):
        EmpowermentReward(WorldEnv(small), horizon=2, sensor="object", beta=0.5)


def test_empowerment_with_a_tool_that_may_fail_is_that_of_its_noisy_channel():
    text = "P = picker slip 0.25\nAP.CG\n"
    env = EmpowermentReward(WorldEnv(text), horizon=1, sensor="object", beta=1.0)
    bits = hb.empowerment(hb.tabulate(hb.World.parse(text)), 1, "object")
    info = walk(env, 1)[-1][-1]
    assert info["empowerment"] == pytest.approx(bits[info["state"]])
    found = FunctionalEnv(text).with_empowerment(1, "object", 1.0).default_params.empowerment
    assert found is not None
    assert found.bits == pytest.approx(bits, abs=1e-5)


def test_measures_of_several_things_are_in_info(small: hb.World):
    measures = {"ball": {"horizon": 2, "sensor": "object:can2"}}
    env = gymnasium.make("habilis/World-v0", world=small, measures=measures)
    bits = hb.empowerment(hb.tabulate(small), 2, "object:can2")
    info = env.reset(seed=0)[1]
    assert info["ball"] == bits[info["state"]]


@pytest.mark.parametrize(
    ("sensor", "both"),
    [
        ("object:can + object:can2", lambda one, other: one + other),
        ("object:can*object:can2", lambda one, other: one * other),
    ],
)
def test_the_reward_may_have_the_bits_of_several_objects(sensor, both, small: hb.World):
    alone = [hb.empowerment(hb.tabulate(small), 2, name) for name in ("object:can", "object:can2")]
    bits = both(*alone)
    env = EmpowermentReward(WorldEnv(small), 2, sensor, beta=0.1)
    env.reset(seed=0)
    info = env.step(EAST)[-1]
    assert info["empowerment"] == bits[info["state"]] > 0
    envs = EmpowermentReward(WorldVectorEnv(2, small), 2, sensor, beta=0.1)
    envs.reset(seed=0)
    assert envs.step(np.array([EAST, EAST]))[-1]["empowerment"][1] == info["empowerment"]
    found = FunctionalEnv(small).with_empowerment(2, sensor, beta=0.1).default_params.empowerment
    assert found is not None
    np.testing.assert_array_equal(found.bits, bits.astype(np.float32))
