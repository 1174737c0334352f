"""Empowerment in the reward of any environment."""

import pickle
import warnings
from importlib import import_module
from typing import Any

import gymnasium
import jax.numpy as jnp
import minigrid  # noqa: F401  # registers its environments
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv
from gymnasium.wrappers import RecordEpisodeStatistics
from gymnasium.wrappers.vector import RecordEpisodeStatistics as RecordVectorStatistics
from minigrid.wrappers import ImgObsWrapper

import habilis as hb
from habilis.bridges.gymnasium.access import access
from habilis.bridges.gymnasium.enumeration import enumerate_states
from habilis.bridges.gymnasium.snapshots import Identity
from habilis.envs import EmpowermentReward, VectorEmpowermentReward, WorldEnv, WorldVectorEnv
from habilis.learning import intrinsic
from habilis.learning.dynamics import make_dynamics

TEXT = "AP.CG\n.....\n"
TOE = {"horizon": 2, "sensor": "object", "beta": 0.5}
OTHERS = [
    ("FrozenLake-v1", {}, "state"),
    ("FrozenLake-v1", {"is_slippery": False}, "agent"),
    ("CliffWalking-v1", {}, "agent"),
    ("Taxi-v4", {}, "passenger"),
    ("MiniGrid-Empty-5x5-v0", {"max_steps": 9}, "agent"),
    ("MiniGrid-DoorKey-5x5-v0", {"max_steps": 9}, "key"),
]


def test_a_step_earns_the_bits_of_where_it_leads():
    env = EmpowermentReward(WorldEnv(TEXT), **TOE)
    mdp = hb.tabulate(hb.World.parse(TEXT))
    bits = hb.empowerment(mdp, 2, "object")
    _, info = env.reset(seed=0)
    assert info["empowerment"] == bits[mdp.start]
    state = mdp.start
    for action in np.random.default_rng(0).integers(8, size=400):
        _, reward, terminated, truncated, info = env.step(action)
        after = mdp.next_state[state, action]
        assert info["extrinsic_reward"] == mdp.reward[state, action]
        assert info["empowerment"] == bits[after]
        assert reward == pytest.approx(mdp.reward[state, action] + 0.5 * bits[after])
        state = after
        if terminated or truncated:
            env.reset()
            state = mdp.start


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"earned": "current"},
        {"earned": "difference", "discount": 0.9},
        {"terminal_bonus": False},
        {"extrinsic": False},
        {"beta_schedule": "linear", "beta_steps": 40},
        {"beta_schedule": "exponential", "beta_steps": 10},
    ],
)
def test_rewards_are_the_trainers_whatever_the_settings(settings):
    env = EmpowermentReward(WorldEnv(TEXT, max_steps=30), **TOE, **settings)
    mdp = hb.tabulate(hb.World.parse(TEXT))
    dynamics, _ = make_dynamics(mdp)
    discount = settings.get("discount", 0.99)
    config = hb.Config(intrinsic="object", horizon=2, beta=0.5).changed(
        **settings | {"discount": discount, "reward_scale": 1.0}
    )
    numbers = {name: jnp.float32(value) for name, value in intrinsic.weights(config).items()}
    numbers["reward_scale"] = jnp.float32(1)
    bits = jnp.asarray(hb.empowerment(mdp, 2, "object"))
    env.reset(seed=0)
    state, terminations = mdp.start, 0
    for taken, action in enumerate(np.random.default_rng(5).integers(8, size=200)):
        _, reward, terminated, truncated, info = env.step(action)
        transition = jnp.array(state * 8 + action)
        wanted = intrinsic.reward(
            numbers,
            dynamics.transitions.reward[transition],
            bits[dynamics.transitions.next_state[transition]],
            bits[state],
            dynamics.terminated(transition),
            jnp.float32(taken),
        )
        assert reward == pytest.approx(float(wanted), abs=1e-5)
        terminations += terminated
        state = info["state"]
        if terminated or truncated:
            env.reset()
            state = mdp.start
    assert terminations


def bits_here(env, sensor):
    """The bits of the state that an environment is in, from a table of its own."""
    inner = env.unwrapped
    if hasattr(inner, "P"):
        mdp = hb.TabularMDP.from_gymnasium(inner)
    else:
        with access(inner, None, Identity()) as states:
            mdp = enumerate_states(states, int(inner.action_space.n), 1000, None, False).mdp
    state = getattr(env.unwrapped, "s", 0)  # the first state of an enumeration is this one
    return hb.empowerment(mdp, 2, sensor, states=[state])[0]


@pytest.mark.parametrize(("name", "arguments", "sensor"), OTHERS)
def test_environments_of_others_earn_the_bits_of_their_states(name, arguments, sensor):
    env = EmpowermentReward(gymnasium.make(name, **arguments), 2, sensor, 0.25)
    _, info = env.reset(seed=3)
    assert info["empowerment"] == pytest.approx(bits_here(env, sensor))
    plain: Any = gymnasium.make(name, **arguments)
    plain.reset(seed=3)
    for action in np.random.default_rng(0).integers(plain.action_space.n, size=20):
        _, extrinsic, *ends, _ = plain.step(action)
        _, reward, *shaped_ends, info = env.step(action)
        assert shaped_ends == ends
        assert info["extrinsic_reward"] == extrinsic
        assert reward == pytest.approx(extrinsic + 0.25 * info["empowerment"])
        if any(ends):
            break
        assert info["empowerment"] == pytest.approx(bits_here(env, sensor))


def test_the_sensor_is_the_state_and_the_weight_must_be_given():
    env = EmpowermentReward(WorldEnv(TEXT), 2, beta=0.5)
    mdp = hb.tabulate(hb.World.parse(TEXT))
    assert env.reset()[1]["empowerment"] == hb.empowerment(mdp, 2)[mdp.start]
    for make in (lambda: WorldEnv(TEXT), lambda: WorldVectorEnv(2, TEXT)):
        with pytest.raises(TypeError, match="beta is missing; give the weight of empowerment"):
            EmpowermentReward(make(), 2, "object")


@pytest.mark.parametrize("name", ["MiniGrid-Empty-5x5-v0", "FrozenLake-v1", "habilis/Yard-v0"])
def test_a_wrapped_environment_can_be_pickled(name):
    env = EmpowermentReward(gymnasium.make(name), 2, "agent", 0.1)
    other = pickle.loads(pickle.dumps(env))
    assert [one.reset(seed=1)[1]["empowerment"] for one in (env, other)]
    for action in (2, 1, 2):
        rewards = [one.step(action)[1] for one in (env, other)]
        assert rewards[0] == rewards[1]


class Broken(gymnasium.Wrapper):
    """From some step on, every action is the first one."""

    steps = 0

    def step(self, action):
        Broken.steps += 1
        return self.env.step(0 if Broken.steps > 10_000_000 else action)


@pytest.mark.parametrize("name", ["FrozenLake-v1", "MiniGrid-Empty-5x5-v0", "habilis/Yard-v0"])
def test_a_step_that_the_table_does_not_have_is_refused_when_it_comes(name, monkeypatch):
    arguments = {"is_slippery": False} if name.startswith("Frozen") else {}
    env = EmpowermentReward(Broken(gymnasium.make(name, **arguments)), 2, "agent", 0.1)
    env.reset(seed=0)
    env.step(1)
    monkeypatch.setattr(Broken, "steps", 10_000_000)
    message = r"in step \d+ of an episode, action .* Broken changes what a step does: put it around"

    def steps():
        for step in range(60):
            env.step(1 + step % 3)

    with pytest.raises(ValueError, match=message) as refused:
        steps()
    assert "\n" not in str(refused.value)


REACHED = []


class Records(gymnasium.Wrapper):
    """Notes the state that each step of the environment inside leads to."""

    def step(self, action):
        returned = self.env.step(action)
        REACHED.append(self.unwrapped.s)  # type: ignore[attr-defined]
        return returned


def hidden(env):
    """Shows nothing from which the state could be read, as an encoder may."""
    return gymnasium.wrappers.TransformObservation(
        env, lambda observation: observation % 2, gymnasium.spaces.Discrete(2)
    )


@pytest.mark.parametrize("slippery", [True, False])
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_the_state_is_not_taken_from_what_a_wrapper_shows(slippery, mode):
    lake = {"is_slippery": slippery, "max_episode_steps": 7}
    bits = hb.empowerment(hb.TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1", **lake)), 2)
    envs = SyncVectorEnv(
        [lambda: hidden(Records(gymnasium.make("FrozenLake-v1", **lake)))] * 3, autoreset_mode=mode
    )
    envs = EmpowermentReward(envs, 2, "state", 0.5)
    envs.reset(seed=0)
    ended = 0
    for actions in np.random.default_rng(0).integers(4, size=(60, 3)):
        REACHED.clear()
        *_, terminated, truncated, info = envs.step(actions)
        if len(REACHED) == 3:  # none of them only began an episode
            assert info["empowerment"] == pytest.approx(bits[REACHED])
            ended += (terminated | truncated).sum()
    assert ended > 0


def test_another_layout_is_enumerated_when_an_episode_brings_it():
    env = EmpowermentReward(gymnasium.make("MiniGrid-DoorKey-5x5-v0"), 2, "key", 0.25)
    known = len(env._states.values)
    for seed in range(4):
        _, info = env.reset(seed=seed)
        assert info["empowerment"] == pytest.approx(bits_here(env, "key"))
    assert len(env._states.values) > known


def vectors(mode):
    """Vector environments of several kinds, and how to make one of their copies."""
    own = {"world": TEXT, "max_steps": 9}
    lake: dict[str, Any] = {"is_slippery": True, "max_episode_steps": 9}
    empty: dict[str, Any] = {"max_steps": 9}

    def sync(make):
        return SyncVectorEnv([make] * 4, autoreset_mode=AutoresetMode(mode))

    return {
        "ours": (WorldVectorEnv(4, autoreset_mode=mode, **own), lambda: WorldEnv(**own), "object"),
        "ours in a loop": (sync(lambda: WorldEnv(**own)), lambda: WorldEnv(**own), "object"),
        "toy-text": (
            sync(lambda: gymnasium.make("FrozenLake-v1", **lake)),
            lambda: gymnasium.make("FrozenLake-v1", **lake),
            "agent",
        ),
        "minigrid": (
            sync(lambda: ImgObsWrapper(gymnasium.make("MiniGrid-Empty-5x5-v0", **empty))),
            lambda: ImgObsWrapper(gymnasium.make("MiniGrid-Empty-5x5-v0", **empty)),
            "agent",
        ),
    }


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
@pytest.mark.parametrize("kind", ["ours", "ours in a loop", "toy-text", "minigrid"])
@pytest.mark.parametrize("earned", ["next", "difference"])
def test_a_vector_environment_earns_what_each_of_its_copies_would_alone(kind, mode, earned):
    vector, one, sensor = vectors(mode)[kind]
    settings = {"horizon": 2, "sensor": sensor, "beta": 0.5, "earned": earned}
    together = EmpowermentReward(vector, **settings)
    assert isinstance(together, VectorEmpowermentReward)
    alone = [EmpowermentReward(one(), **settings) for _ in range(4)]
    _, info = together.reset(seed=0)
    for i, env in enumerate(alone):
        assert env.reset(seed=i)[1]["empowerment"] == info["empowerment"][i]
    random = np.random.default_rng(0)
    ended = np.zeros(4, bool)
    for _ in range(40):
        actions = random.integers(one().action_space.n, size=4)
        _, rewards, terminated, truncated, info = together.step(actions)
        for i, env in enumerate(alone):
            if ended[i]:
                env.reset()
            if ended[i] and mode == "NextStep":
                assert rewards[i] == info["extrinsic_reward"][i] == 0
                continue
            _, reward, *ends, reported = env.step(actions[i])
            assert rewards[i] == pytest.approx(reward)
            assert [terminated[i], truncated[i]] == ends
            assert info["extrinsic_reward"][i] == reported["extrinsic_reward"]
            assert info["empowerment"][i] == reported["empowerment"]
        ended = terminated | truncated
    assert info["_empowerment"].all()


def test_the_weight_goes_by_the_steps_of_all_copies():
    settings = {"horizon": 1, "sensor": "state", "beta_schedule": "linear", "beta_steps": 8}
    envs = EmpowermentReward(WorldVectorEnv(4, TEXT), beta=1.0, **settings)
    envs.reset(seed=0)
    weights = []
    for _ in range(3):
        _, rewards, *_, info = envs.step(np.array([0, 0, 0, 0]))
        weights.append((rewards[0] + 1) / info["empowerment"][0])
    assert weights == pytest.approx([1, 0.5, 0])


def test_statistics_count_the_bonus_outside_and_not_inside():
    inside = RecordEpisodeStatistics(WorldEnv(TEXT, max_steps=5), stats_key="extrinsic")
    env = RecordEpisodeStatistics(EmpowermentReward(inside, **TOE))
    env.reset(seed=0)
    shaped, extrinsic, info = 0.0, 0.0, {}
    for _ in range(5):
        _, reward, *_, info = env.step(0)
        shaped, extrinsic = shaped + float(reward), extrinsic + info["extrinsic_reward"]
    assert info["episode"]["r"] == pytest.approx(shaped)
    assert info["extrinsic"]["r"] == pytest.approx(extrinsic) == -5


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_vector_statistics_count_the_bonus_too(mode):
    envs = WorldVectorEnv(3, TEXT, max_steps=5, autoreset_mode=mode)
    envs = RecordVectorStatistics(EmpowermentReward(envs, **TOE))
    envs.reset(seed=0)
    shaped, info = np.zeros(3), {}
    for _ in range(5):
        _, rewards, *_, info = envs.step(np.array([0, 4, 2]))
        shaped += rewards
    assert info["episode"]["r"] == pytest.approx(shaped)
    assert (info["episode"]["l"] == 5).all()


def test_it_passes_gymnasiums_own_check_and_is_part_of_the_spec():
    env = EmpowermentReward(gymnasium.make("habilis/Yard-v0"), **TOE)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*different from the unwrapped version")
        check_env(env, skip_render_check=True)
    again = gymnasium.make(env.spec)
    again.reset(seed=0)
    env.reset(seed=0)
    assert again.step(1)[1] == env.step(1)[1]


@pytest.mark.parametrize("sensor", ["object", "agent + object", "agent * object"])
@pytest.mark.parametrize("method", [hb.Exact(1e-4), hb.Sampled(samples=3, seed=1)])
def test_the_method_is_that_of_empowerment(sensor, method):
    env, options = WorldEnv(TEXT, slip=0.2), {"beta": 0.5, "method": method}
    bits = hb.empowerment(env.mdp.slippery(0.2), 2, sensor, method=method)
    one = EmpowermentReward(env, 2, sensor, **options)
    _, info = one.reset(seed=0)
    assert info["empowerment"] == bits[info["state"]]
    assert one._saved_kwargs["method"] == method
    many = EmpowermentReward(WorldVectorEnv(2, TEXT, slip=0.2), 2, sensor, **options)
    assert (many.reset(seed=0)[1]["empowerment"] == info["empowerment"]).all()
    jax = pytest.importorskip("habilis.envs.functional").FunctionalEnv(TEXT, slip=0.2)
    found = jax.with_empowerment(2, sensor, **options).default_params.empowerment.bits
    np.testing.assert_array_equal(found, bits.astype(np.float32))


def test_values_come_from_the_disk_the_second_time(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = EmpowermentReward(WorldEnv(TEXT), **TOE)
    keeping = import_module("habilis.rewards.cached_tables")
    monkeypatch.setattr(keeping, "empowerment", None)  # not computed again
    second = EmpowermentReward(WorldEnv(hb.World.parse(TEXT, "another name")), **TOE)
    assert np.array_equal(first._states.values, second._states.values)
    with pytest.raises(TypeError):
        EmpowermentReward(WorldEnv(TEXT, tool="broom"), **TOE)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"horizon": -1}, "horizon"),
        ({"sensor": "smell"}, "sensor 'smell' is unknown"),
        ({"beta": float("nan")}, "beta is nan; give a finite number"),
        ({"earned": "twice"}, "earned 'twice' is unknown; use one of"),
        ({"beta_schedule": "linear"}, "beta_steps is 0; give a number above 0"),
        ({"discount": 2}, "discount is 2; give a number from 0 to 1"),
        ({"actions": [9]}, "action"),
    ],
)
@pytest.mark.parametrize("make", [lambda: WorldEnv(TEXT), lambda: WorldVectorEnv(2, TEXT)])
def test_settings_out_of_range_are_refused_in_one_line(settings, message, make):
    with pytest.raises(ValueError, match=message) as refused:
        EmpowermentReward(make(), **TOE | settings)
    assert "\n" not in str(refused.value)


def test_environments_without_a_table_are_refused():
    with pytest.raises(ValueError, match="more than one outcome"):
        EmpowermentReward(gymnasium.make("Blackjack-v1"), **TOE | {"sensor": "state"})
    env = gymnasium.make("MiniGrid-Empty-5x5-v0")
    with pytest.raises(ValueError, match="more than 5 states"):
        EmpowermentReward(env, **TOE | {"sensor": "state"}, max_states=5)


class Turned(gymnasium.Wrapper):
    """Fewer actions outside than inside."""

    def __init__(self, env):
        super().__init__(env)
        self.action_space = gymnasium.spaces.Discrete(2)


@pytest.mark.parametrize("name", ["FrozenLake-v1", "habilis/Yard-v0", "MiniGrid-Empty-5x5-v0"])
def test_wrappers_inside_that_change_actions_are_refused(name):
    sticky = gymnasium.wrappers.StickyAction(gymnasium.make(name), 0.5)
    with pytest.raises(ValueError, match="StickyAction changes the actions"):
        EmpowermentReward(sticky, 2, "state", 0.5)
    with pytest.raises(ValueError, match=r"Discrete\(2\) outside and"):
        EmpowermentReward(Turned(gymnasium.make(name)), 2, "state", 0.5)


def test_environments_in_other_processes_are_to_be_wrapped_there():
    envs = VectorEnv()  # as AsyncVectorEnv, it has no environments in this process
    with pytest.raises(ValueError, match="wrap each environment in EmpowermentReward before"):
        EmpowermentReward(envs, **TOE)


@pytest.mark.parametrize("identity", ["habilis/Corridor-v0", "FrozenLake-v1"])
def test_statistics_inside_are_kept_where_the_next_episode_begins_in_the_same_step(identity):
    def make():
        return RecordEpisodeStatistics(gymnasium.make(identity, max_episode_steps=5))

    envs = SyncVectorEnv([make] * 2, autoreset_mode=AutoresetMode.SAME_STEP)
    envs = EmpowermentReward(envs, 2, "agent", 0.5)
    envs.reset(seed=0)
    ended = 0
    for _ in range(10):
        *_, terminated, truncated, info = envs.step(np.zeros(2, int))
        for i in np.flatnonzero(terminated | truncated):
            assert info["final_info"]["episode"]["l"][i] <= 5
            ended += 1
    assert ended


def different(kind: str) -> list[gymnasium.Env]:
    if kind == "worlds":
        return [WorldEnv("corridor"), WorldEnv("yard")]
    if kind == "slips":
        return [WorldEnv("yard"), WorldEnv("yard", slip=0.5)]
    maps = (["SFF", "FFF", "FFG"], ["SHF", "FFF", "FFG"])
    return [gymnasium.make("FrozenLake-v1", desc=desc) for desc in maps]


@pytest.mark.parametrize("kind", ["worlds", "slips", "lakes"])
def test_different_tables_in_one_vector_are_refused(kind):
    envs = SyncVectorEnv([lambda env=env: env for env in different(kind)])
    with pytest.raises(ValueError, match="environment 1 differs from environment 0; wrap each"):
        EmpowermentReward(envs, 2, "agent", 0.5)


def test_a_mask_left_out_by_none_resets_all():
    envs = EmpowermentReward(WorldVectorEnv(2, "yard"), 2, "object", 0.5)
    info = envs.reset(options={"reset_mask": None})[1]
    assert info["empowerment"].shape == (2,)
