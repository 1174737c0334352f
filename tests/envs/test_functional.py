"""The worlds as functions of JAX: gymnax's rules, and the same steps as everywhere else.

`make test-integration` runs this where gymnax is installed; the spaces are gymnax's then.
"""

import operator
import subprocess
import sys
from importlib.util import find_spec

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import habilis as hb
from habilis.envs import EmpowermentReward, TableEnv, WorldEnv
from habilis.envs.functional import KINDS, FunctionalEnv
from habilis.learning import intrinsic
from habilis.learning.algorithms.a2c import A2C
from habilis.learning.config import Config
from habilis.learning.dynamics import make_dynamics
from habilis.learning.rollout import EnvState, rollout
from habilis.worlds.table import restarted

SMALL = "AP.CG\n.....\n"
RING = hb.TabularMDP.deterministic(
    [[1, 4], [2, 0], [3, 1], [4, 2], [0, 3]],
    reward=np.arange(10).reshape(5, 2) / 4,
    terminal=[0, 0, 1, 0, 0],
    start=4,
)
KEY = jax.random.key(0)


CASES = [
    *(("corridor", kind) for kind in KINDS),
    ("yard", "factors"),
    (SMALL, "grid"),
    (RING, "factors"),
    (RING, "onehot"),
]


def contains(space, x):
    """gymnax's own `contains` asks for the range alone."""
    return bool(space.contains(x)) and x.shape == space.shape and x.dtype == space.dtype


def walk(env, params, actions):
    """States, rewards, ends and cuts of a walk [T, N], in one compiled program."""

    def step(states, chosen):
        _, after, reward, terminated, truncated, info = jax.vmap(env.step, (None, 0, 0, None))(
            KEY, states, chosen, params
        )
        return after, (states.index, info["state"], reward, terminated, truncated)

    _, states = jax.vmap(env.reset, in_axes=(0, None))(
        jax.random.split(KEY, actions.shape[1]), params
    )
    return jax.lax.scan(step, states, actions)


# What gymnax asks of its own environments.


@pytest.mark.parametrize(("world", "kind"), CASES)
def test_compiled_resets_and_steps_stay_in_their_spaces(world, kind):
    env = FunctionalEnv(world, observation=kind, max_steps=6)
    params = env.default_params
    reset, step = jax.jit(env.reset), jax.jit(env.step)
    observed, state = reset(KEY, params)
    observations, states = env.observation_space(params), env.state_space(params)
    seen = 0
    for key in jax.random.split(KEY, 40):
        assert contains(observations, observed)
        assert bool(states.contains(state))
        assert jnp.array_equal(env.get_obs(state, params), observed)
        assert jnp.array_equal(env.observe(key, state, None, params), observed)
        action = env.action_space(params).sample(key)
        assert contains(env.action_space(params), action)
        observed, state, reward, terminated, truncated, info = step(key, state, action, params)
        assert reward.shape == terminated.shape == truncated.shape == ()
        assert (reward.dtype, terminated.dtype, truncated.dtype) == (jnp.float32, bool, bool)
        assert contains(observations, info["final_observation"])
        assert (info["terminated"], info["truncated"]) == (terminated, truncated)
        assert info["discount"] == 1 - terminated
        seen += int(truncated)
    assert seen  # episodes that were cut off


@pytest.mark.parametrize(("world", "kind"), [("yard", "grid"), (RING, "factors")])
def test_samples_of_a_space_are_in_it(world, kind):
    env = FunctionalEnv(world, observation=kind)
    params = env.default_params
    for space in (env.observation_space(params), env.action_space(params)):
        samples = jax.vmap(space.sample)(jax.random.split(KEY, 20))
        assert all(contains(space, sample) for sample in samples)
    sample = env.state_space(params).sample(KEY)
    assert 0 <= sample["index"] < env.state_space(params).spaces["index"].n
    assert 0 <= sample["time"] <= params.max_steps_in_episode


def test_a_space_does_not_hold_what_is_outside_of_it():
    env = FunctionalEnv(SMALL)
    params = env.default_params
    assert not env.action_space(params).contains(jnp.int32(8))
    assert not env.observation_space(params).contains(jnp.array([0, 1, 10]))
    _, state = env.reset(KEY, params)
    assert not env.state_space(params).contains(state.replace(time=jnp.int32(501)))


@pytest.mark.skipif(find_spec("gymnax") is not None, reason="the spaces are gymnax's here")
def test_samples_reach_every_number():
    space = FunctionalEnv(SMALL).observation_space()
    samples = jax.vmap(space.sample)(jax.random.split(KEY, 500))
    assert [len(np.unique(column)) for column in samples.T] == [10, 10, 10]


def test_it_says_what_it_is():
    env = FunctionalEnv("corridor", tool="none")
    assert (env.name, env.num_actions) == ("corridor", 4)
    assert env.action_space(env.default_params).n == 4
    assert FunctionalEnv(RING).num_actions == 2


def test_params_may_be_left_out():
    env = FunctionalEnv(SMALL, max_steps=1)
    observed, state = env.reset(KEY)
    assert jnp.array_equal(observed, env.get_obs(state))
    assert bool(env.step(KEY, state, jnp.int32(0))[4])


def shortest(env):
    """The last step of a shortest plan, and the same without what follows it."""
    params = env.default_params
    plan = hb.solve(hb.tabulate(hb.World.parse(SMALL)))
    assert plan is not None
    _, state = env.reset(KEY, params)
    for action in plan.actions[:-1]:
        _, state, *_ = env.step(KEY, state, action, params)
    last = plan.actions[-1]
    return env.step(KEY, state, last, params), env.step_env(KEY, state, last, params)


def test_the_end_of_an_episode_is_seen_before_the_next_begins():
    env = FunctionalEnv(SMALL)
    params = env.default_params
    (observed, state, *reported, info), (last, reached, reward, terminated, _) = shortest(env)
    assert reported == [reward, terminated, False] == [0, True, False]
    assert jnp.array_equal(info["final_observation"], last)
    assert not jnp.array_equal(observed, last)
    assert info["state"] == reached.index
    assert info["discount"] == env.discount(reached, params) == 0
    assert bool(env.is_terminal(reached, params) & env.is_terminated(reached, params))
    first, begin = env.reset(KEY, params)
    assert jnp.array_equal(observed, first)
    assert jax.tree.all(jax.tree.map(jnp.array_equal, state, begin))


def test_reaching_the_goal_in_the_last_step_is_no_cut():
    plan = hb.solve(hb.tabulate(hb.World.parse(SMALL)))
    assert plan is not None
    env = FunctionalEnv(SMALL, max_steps=len(plan.actions))
    (*_, terminated, truncated, _), (_, reached, *_) = shortest(env)
    assert bool(terminated)
    assert not truncated
    assert not env.is_truncated(reached, env.default_params)


# jit, vmap, scan.


def test_a_thousand_environments_step_at_once():
    env = FunctionalEnv("corridor", observation="grid")
    params = env.default_params
    keys = jax.random.split(KEY, 1000)
    observed, states = jax.jit(jax.vmap(env.reset, in_axes=(0, None)))(keys, params)
    assert observed.shape == (1000, 5, 10, 10)
    actions = jax.vmap(env.action_space(params).sample)(keys)
    step = jax.jit(jax.vmap(env.step, in_axes=(0, 0, 0, None)))
    _, after, reward, *_ = step(keys, states, actions, params)
    assert reward.shape == (1000,)
    for i in (0, 17, 999):
        _, alone, *_ = env.step(keys[i], env.reset(keys[i])[1], actions[i])
        assert alone.index == after.index[i]


def test_other_params_do_not_recompile():
    traced = []
    env = FunctionalEnv(SMALL).with_empowerment(2, "object", beta=0.1)

    @jax.jit
    def step(key, state, action, params):
        traced.append(1)
        return env.step(key, state, action, params)

    params = env.default_params
    _, state = env.reset(KEY, params)
    for action in range(8):
        _, state, *_ = step(KEY, state, jnp.int32(action), params)
    _, _, *ends = step(KEY, state, jnp.int32(0), params.replace(max_steps_in_episode=1, start=3))
    assert bool(ends[2])
    assert len(traced) == 1


def test_params_may_be_mapped_over():
    env = FunctionalEnv(SMALL)
    params = env.default_params
    axes = jax.tree.map(lambda _: None, params).replace(max_steps_in_episode=0)
    some = params.replace(max_steps_in_episode=jnp.arange(1, 5))
    _, state = env.reset(KEY, params)
    states = [state.time]
    step = jax.vmap(env.step, in_axes=(None, 0, None, axes))
    states = jax.tree.map(lambda x: jnp.repeat(x, 4), state)
    cut = []
    for _ in range(4):
        _, states, _, _, truncated, _ = step(KEY, states, jnp.int32(0), some)
        cut.append(truncated.tolist())
    assert cut == [[(t + 1) % limit == 0 for limit in range(1, 5)] for t in range(4)]


def test_worlds_of_one_shape_are_one_batch():
    world = hb.World.parse(SMALL)
    mdp = hb.tabulate(world)
    goals = [hb.World.parse(text) for text in ("AP.CG\n.....\n", "AP.C.\n....G\n")]
    envs = [FunctionalEnv(restarted(mdp, goal)) for goal in goals]
    params = jax.tree.map(lambda *x: jnp.stack(x), *(env.default_params for env in envs))
    actions = jax.random.randint(KEY, (500, 1), 0, 8)
    _, together = jax.jit(jax.vmap(lambda p: walk(envs[0], p, actions)))(params)
    for i, env in enumerate(envs):
        _, alone = walk(env, env.default_params, actions)
        of_this = jax.tree.map(operator.itemgetter(i), together)
        assert jax.tree.all(jax.tree.map(jnp.array_equal, of_this, alone))
    assert not jnp.array_equal(together[3][0], together[3][1])


def test_it_works_in_double_precision():
    with jax.enable_x64():
        env = FunctionalEnv(SMALL, max_steps=3).with_empowerment(2, "object", beta=0.5)
        after, (_, _, reward, *_) = walk(env, env.default_params, jnp.ones((10, 2), jnp.int64))
        assert after.index.dtype == after.time.dtype == jnp.int32
        assert reward.dtype == jnp.float32


# The same steps as the trainer's and Gymnasium's.


@pytest.mark.parametrize(("world", "limit"), [(SMALL, 9), ("yard", 40), (RING, 7)])
def test_the_trainer_makes_the_same_transitions(world, limit):
    env = FunctionalEnv(world, max_steps=limit)
    mdp = world if isinstance(world, hb.TabularMDP) else hb.tabulate(env_world(world))
    actions = jax.random.randint(KEY, (3000, 4), 0, env.num_actions)
    _, ours = walk(env, env.default_params, actions)
    dynamics, _ = make_dynamics(mdp)
    env_state = EnvState(jnp.full(4, mdp.start), jnp.zeros(4, jnp.int32))
    # Draws are given out one a decision: here each is the action itself.
    _, theirs = rollout(
        *(dynamics, lambda _, draw: (draw.astype(jnp.int32), ())),
        *(env_state, jnp.float32(limit), actions.astype(jnp.float32)),
    )
    state, reached, reward, terminated, truncated = ours
    assert jnp.array_equal(state, theirs.state)
    assert jnp.array_equal(reached, dynamics.transitions.next_state[theirs.transition])
    assert jnp.array_equal(reward, dynamics.transitions.reward[theirs.transition])
    assert jnp.array_equal(terminated, dynamics.terminated(theirs.transition))
    assert jnp.array_equal(truncated, theirs.truncated)
    assert int(truncated.sum()) > 100
    assert int(terminated.sum()) > 100 or world == "yard"


def env_world(world):
    return hb.World.parse(world) if "\n" in world else hb.load_world(world)


@pytest.mark.parametrize("kind", KINDS)
def test_gymnasiums_environment_makes_the_same_transitions(kind):
    ours = FunctionalEnv(SMALL, max_steps=9, observation=kind)
    theirs = WorldEnv(SMALL, max_steps=9, observation=kind)
    follow(ours, theirs)


def test_the_environment_of_a_table_makes_the_same_transitions():
    follow(FunctionalEnv(RING, max_steps=4), TableEnv(RING, max_steps=4))


def follow(ours, theirs):
    """The same actions in both, thousands of them, and all that is seen."""
    params = ours.default_params
    actions = jax.random.randint(KEY, (2000,), 0, ours.num_actions)

    def step(state, action):
        observed, state, *rest = ours.step(KEY, state, action, params)
        return state, (observed, *rest)

    first, state = ours.reset(KEY, params)
    _, walked = jax.jit(lambda state: jax.lax.scan(step, state, actions))(state)
    walked = jax.tree.map(np.asarray, walked)
    seen, info = theirs.reset(seed=0)
    assert np.array_equal(first, seen)
    ended = [0, 0]
    for t, action in enumerate(np.asarray(actions)):
        observed, *reported, ours_info = jax.tree.map(lambda x, t=t: x[t], walked)
        seen, *expected, info = theirs.step(int(action))
        assert reported == expected
        assert np.array_equal(ours_info["final_observation"], seen)
        assert all(ours_info[name] == info[name] for name in info)
        ended = [ended[0] + expected[1], ended[1] + expected[2]]
        if expected[1] or expected[2]:
            seen, _ = theirs.reset()
        assert np.array_equal(observed, seen)
    assert min(ended) > 20


@pytest.mark.parametrize("kind", KINDS)
def test_every_state_is_shown_as_gymnasiums_environment_shows_it(kind):
    env = FunctionalEnv("yard", tool="broom", observation=kind)
    theirs = WorldEnv("yard", tool="broom", observation=kind)
    _, state = env.reset(KEY)
    every = np.arange(theirs.mdp.states)
    shown = jax.vmap(lambda index: env.get_obs(state.replace(index=index)))(jnp.asarray(every))
    for index in every[::7]:
        theirs.state = int(index)
        assert np.array_equal(shown[index], theirs._show(int(index)))
    assert theirs.observation_space.shape == env.observation_space().shape


# Empowerment.


@pytest.mark.parametrize("earned", ["next", "current", "difference"])
@pytest.mark.parametrize("terminal_bonus", [True, False])
def test_the_bonus_is_the_trainers_and_the_wrappers(earned, terminal_bonus):
    settings = {"earned": earned, "terminal_bonus": terminal_bonus}
    env = FunctionalEnv(SMALL, max_steps=30).with_empowerment(2, "object", beta=0.3, **settings)
    wrapped = EmpowermentReward(WorldEnv(SMALL, max_steps=30), 2, "object", beta=0.3, **settings)
    actions = jax.random.randint(KEY, (1000, 1), 0, 8)
    _, (state, reached, reward, terminated, _) = walk(env, env.default_params, actions)
    wrapped.reset()
    theirs, plain = [], []
    for action in np.asarray(actions[:, 0]):
        _, value, *ends, info = wrapped.step(int(action))
        theirs.append(value)
        plain.append(info["extrinsic_reward"])
        if any(ends):
            wrapped.reset()
    assert np.allclose(reward[:, 0], theirs, atol=1e-6)
    assert not np.allclose(theirs, plain)

    config = Config(
        intrinsic="object", horizon=2, beta=0.3, algorithm=A2C(reward_scale=1.0), **settings
    )
    mdp = hb.tabulate(hb.World.parse(SMALL))
    table = jnp.asarray(intrinsic.value_table(mdp, config), jnp.float32)
    weights = {name: jnp.float32(x) for name, x in intrinsic.weights(config).items()}
    trainers = intrinsic.reward(
        {**weights, "reward_scale": jnp.float32(1)},
        *(jnp.asarray(plain)[:, None], table[reached], table[state], terminated, jnp.float32(0)),
    )
    assert np.allclose(reward, trainers, atol=1e-6)
    assert bool(terminated.any())


def test_info_separates_reward_and_bits_and_the_weight_may_change():
    env = FunctionalEnv(SMALL).with_empowerment(2, "object", beta=0.5)
    bits = hb.empowerment(hb.tabulate(hb.World.parse(SMALL)), 2, "object")
    params = env.default_params
    _, state = env.reset(KEY, params)
    _, after, reward, _, _, info = env.step(KEY, state, jnp.int32(1), params)
    assert info["empowerment"] == np.float32(bits[int(after.index)]) > 0
    assert info["extrinsic_reward"] == -1
    assert reward == pytest.approx(-1 + 0.5 * bits[int(after.index)])
    assert params.empowerment is not None
    weights = {**params.empowerment.weights, "beta": 0.0}
    params = params.replace(empowerment=type(params.empowerment)(params.empowerment.bits, weights))
    assert env.step(KEY, state, jnp.int32(1), params)[2] == -1
    assert "empowerment" not in FunctionalEnv(SMALL).step(KEY, state, jnp.int32(1))[-1]


def test_the_bits_are_those_of_the_slipping_world():
    env = FunctionalEnv(SMALL, slip=0.2).with_empowerment(1, "object", beta=1.0)
    mdp = hb.tabulate(hb.World.parse(SMALL), slip=0.2)
    assert env.default_params.empowerment is not None
    bits = env.default_params.empowerment.bits
    assert np.allclose(bits, hb.empowerment(mdp, 1, "object"), atol=1e-6)


# Slip.


def test_a_slip_is_a_drawn_action_in_the_place_of_the_chosen_one():
    env = FunctionalEnv(RING, slip=0.6)
    params = env.default_params
    _, state = env.reset(KEY, params)
    keys = jax.random.split(KEY, 20_000)
    step = jax.jit(jax.vmap(env.step, in_axes=(0, None, None, None)))
    _, after, *_ = step(keys, state, jnp.int32(0), params)
    shares = np.bincount(after.index, minlength=5) / len(keys)
    assert shares[0] == pytest.approx(0.7, abs=0.015)  # chosen, or drawn although it was chosen
    assert shares[3] == pytest.approx(0.3, abs=0.015)
    assert jnp.array_equal(after.index, step(keys, state, jnp.int32(0), params)[1].index)


def test_without_slip_the_key_has_no_part():
    env = FunctionalEnv("yard")
    _, state = env.reset(KEY)
    keys = jax.random.split(KEY, 50)
    _, after, *_ = jax.jit(jax.vmap(env.step, in_axes=(0, None, None)))(keys, state, jnp.int32(2))
    assert len(np.unique(after.index)) == 1


# What cannot be.


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"world": SMALL, "observation": "rgb"}, "use one of factors, onehot, grid"),
        ({"world": RING, "observation": "grid"}, 'use "factors" or "onehot"'),
        ({"world": RING, "tool": "broom"}, "give a world"),
        ({"world": SMALL, "max_steps": 0}, "max_steps is 0"),
        ({"world": SMALL, "slip": 1.5}, "slip is 1.5"),
    ],
)
def test_what_it_cannot_be_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        FunctionalEnv(**arguments)


def test_the_environments_of_gymnasium_do_without_jax():
    code = "import habilis.envs, sys; print('jax' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
