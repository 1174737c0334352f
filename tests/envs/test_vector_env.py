"""Many environments at once: each does what one alone does."""

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import habilis as hb
from habilis.envs import TableEnv, TableVectorEnv, WorldEnv, WorldVectorEnv

N = 5
TOE = {"toe": {"horizon": 3, "sensor": "object"}}
ARGUMENTS = {"world": "AP.CG\n.....\n", "max_steps": 7, "measures": TOE}


def equal(ours, theirs):
    if isinstance(theirs, dict):
        assert ours.keys() == theirs.keys()
        for name in theirs:
            equal(ours[name], theirs[name])
    elif theirs.dtype == object:
        for one, other in zip(ours, theirs, strict=True):
            assert (one is None) == (other is None)
            assert one is None or np.array_equal(one, other)
    else:
        assert np.array_equal(ours, theirs)
        assert ours.dtype == theirs.dtype


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
@pytest.mark.parametrize("kind", ["factors", "onehot", "grid", "rgb"])
def test_it_is_gymnasiums_loop_over_environments_step_by_step(mode, kind):
    ours = WorldVectorEnv(N, observation=kind, autoreset_mode=mode, **ARGUMENTS)
    theirs = SyncVectorEnv(
        [lambda: WorldEnv(observation=kind, **ARGUMENTS)] * N, autoreset_mode=AutoresetMode(mode)
    )
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    assert ours.metadata["autoreset_mode"] is AutoresetMode(mode)
    equal(ours.reset(seed=0)[0], theirs.reset(seed=0)[0])
    random = np.random.default_rng(0)
    ended = 0
    for _ in range(60):
        actions = random.integers(8, size=N)
        one, other = ours.step(actions), theirs.step(actions)
        for our_part, their_part in zip(one[:4], other[:4], strict=True):
            equal(our_part, their_part)
        equal(one[4], other[4])
        ended += int(one[2].sum()) * 1000 + int(one[3].sum())
    assert ended > 1000  # episodes that reached the goal, and some that were cut off
    assert ended % 1000


def test_make_vec_makes_it():
    envs = gymnasium.make_vec("habilis/Corridor-v0", num_envs=3, autoreset_mode="SameStep")
    assert isinstance(envs.unwrapped, WorldVectorEnv)
    envs.reset(seed=0)
    envs.step(envs.action_space.sample())
    assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP


def test_where_resetting_is_disabled_the_caller_does_it():
    envs = WorldVectorEnv(3, "yard", max_steps=2, autoreset_mode="Disabled")
    envs.reset(seed=0)
    envs.step(np.array([0, 0, 0]))
    assert envs.step(np.array([0, 0, 0]))[3].all()
    with pytest.raises(ValueError, match="the episode of environment 0 has ended; reset it first"):
        envs.step(np.array([0, 0, 0]))
    envs.reset(options={"reset_mask": np.array([True, True, False])})
    with pytest.raises(ValueError, match="the episode of environment 2 has ended"):
        envs.step(np.array([0, 0, 0]))
    envs.reset(options={"reset_mask": np.array([False, False, True])})
    assert not envs.step(np.array([0, 0, 0]))[3].any()
    with pytest.raises(ValueError, match="reset_mask is"):
        envs.reset(options={"reset_mask": [True]})


def test_the_same_seed_slips_alike_and_each_environment_for_itself():
    def states(seed):
        envs = WorldVectorEnv(64, "yard", slip=0.5)
        envs.reset(seed=seed)
        return np.array([envs.step(np.full(64, 1))[4]["state"] for _ in range(10)])

    assert np.array_equal(states(3), states(3))
    assert not np.array_equal(states(3), states(4))
    assert len(np.unique(states(3)[-1])) > 10


def test_rendering_gives_a_picture_an_environment():
    envs = WorldVectorEnv(2, "yard", render_mode="rgb_array")
    envs.reset(seed=0)
    envs.step(np.array([0, 2]))
    alone = WorldEnv("yard", render_mode="rgb_array")
    alone.reset(seed=0)
    alone.step(2)
    pictures = envs.render()
    assert pictures is not None
    assert np.array_equal(pictures[1], alone.render())
    assert not np.array_equal(*pictures)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_an_episode_that_begins_in_a_terminal_state_does_not_end_there(mode):
    table = hb.TabularMDP.deterministic([[0, 1], [0, 1]], terminal=[True, False])
    ours = TableVectorEnv(table, 2, autoreset_mode=mode)
    theirs = SyncVectorEnv([lambda: TableEnv(table)] * 2, autoreset_mode=AutoresetMode(mode))
    ours.reset(seed=0)
    theirs.reset(seed=0)
    for actions in ([0, 1], [0, 0], [1, 0], [0, 1]):
        for one, other in zip(
            ours.step(np.array(actions))[:4], theirs.step(np.array(actions))[:4], strict=True
        ):
            equal(one, other)


def test_any_table_will_do():
    ring = hb.TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
    envs = TableVectorEnv(ring, 2)
    envs.reset(seed=0)
    assert envs.step(np.array([0, 1]))[0].tolist() == [[8], [1]]


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        ([0, 8, 0], "action 8 of environment 1 is unknown; use 0 to 7"),
        ([0, 0, -1], "action -1 of environment 2 is unknown"),
        ([0, 0], "actions have shape"),
        ([0.0, 0.0, 0.0], "give 3 whole numbers"),
    ],
)
def test_actions_that_there_are_not_are_refused(actions, message):
    envs = WorldVectorEnv(3, "yard")
    envs.reset(seed=0)
    with pytest.raises(ValueError, match=message):
        envs.step(np.array(actions))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"num_envs": 0}, "num_envs is 0"),
        ({"autoreset_mode": "Never"}, "autoreset_mode 'Never' is unknown; use one of"),
        ({"render_mode": "human"}, 'render_mode "human" is for one environment'),
    ],
)
def test_what_cannot_be_made_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        WorldVectorEnv(**{"num_envs": 2, "world": "yard"} | arguments)
