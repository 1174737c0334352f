"""The worlds as Gymnasium environments."""

import copy
import pickle
import re
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import habilis as hb
from habilis.envs import WorldEnv
from habilis.worlds.pictures.figures import frame
from habilis.worlds.table import placement

KINDS = ("factors", "onehot", "grid", "rgb")
NAMES = ("habilis/Corridor-v0", "habilis/Yard-v0")
SMALL = "#####\n#AP.#\n#..C#\n#..G#\n#####\n"


def episode(env, seed, steps=60):
    """All observations of a random walk."""
    actions = np.random.default_rng(1).integers(env.action_space.n, size=steps)
    seen = [env.reset(seed=seed)]
    for action in actions:
        seen.append(env.step(int(action)))
        if seen[-1][2] or seen[-1][3]:
            seen.append(env.reset())
    return seen


def same(one, other):
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", KINDS)
def test_every_world_and_observation_passes_gymnasiums_own_check(name, kind):
    env = gymnasium.make(name, observation=kind, render_mode="rgb_array")
    check_env(env.unwrapped)


def test_making_and_stepping_warns_of_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make("habilis/World-v0", world="yard", tool="broom", max_steps=5)
        episode(env, seed=0, steps=30)
        env.close()


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_sees_the_same(kind):
    one, other = (
        episode(gymnasium.make("habilis/Corridor-v0", observation=kind, slip=0.3), seed=7)
        for _ in range(2)
    )
    assert same(one, other)


def test_another_seed_slips_elsewhere():
    one, other = (
        episode(gymnasium.make("habilis/Corridor-v0", slip=0.3), seed=seed) for seed in (1, 2)
    )
    assert not same(one, other)


def test_without_slip_nothing_is_random():
    one, other = (episode(gymnasium.make("habilis/Yard-v0"), seed=seed) for seed in (1, 2))
    assert same(one, other)


@pytest.mark.parametrize("given", ["name", "path", "text", "world", "one line"])
def test_a_world_is_given_by_name_path_text_or_itself(given, tmp_path):
    path = tmp_path / "room.txt"
    path.write_text(SMALL)
    world, wanted = {
        "name": ("yard", hb.load_world("yard").text()),
        "path": (str(path), SMALL),
        "text": (SMALL, SMALL),
        "world": (hb.World.parse(SMALL), SMALL),
        "one line": ("AP.CG", "AP.CG\n"),
    }[given]
    env: Any = gymnasium.make("habilis/World-v0", world=world).unwrapped
    assert env.world.text() == wanted


def test_steps_are_those_of_the_table_and_info_says_what_it_says_of_the_state():
    toe = {"horizon": 3, "sensor": "object"}
    env = gymnasium.make("habilis/Yard-v0", measures={"toe": toe, "moves": {"horizon": 1}})
    mdp = hb.tabulate(hb.load_world("yard"))
    bits = hb.empowerment(mdp, **toe)
    observation, info = env.reset(seed=0)
    state = mdp.start
    for action in np.random.default_rng(0).integers(8, size=300):
        assert info == {
            "state": state,
            "equipped": mdp.flags["equipped"][state],
            "attached": mdp.flags["attached"][state],
            "toe": bits[state],
            "moves": pytest.approx(hb.empowerment(mdp, 1)[state]),
        }
        assert [*observation] == [mdp.factors[name][state] for name in ("agent", "tool", "object")]
        observation, reward, terminated, truncated, info = env.step(action)
        assert reward == mdp.reward[state, action]
        state = mdp.next_state[state, action]
        assert terminated == mdp.terminal[state]
        assert not truncated
        if terminated:
            observation, info = env.reset()
            state = mdp.start


def test_with_slip_the_bits_are_those_of_the_slippery_table():
    toe = {"horizon": 2, "sensor": "object"}
    env = gymnasium.make("habilis/World-v0", world=SMALL, slip=0.2, measures={"toe": toe})
    noisy = hb.tabulate(hb.World.parse(SMALL), slip=0.2)
    bits = hb.empowerment(noisy, **toe)
    for info in (step[-1] for step in episode(env, seed=3)):
        assert info["toe"] == pytest.approx(bits[info["state"]])


def test_slipping_is_as_often_and_to_where_the_slippery_table_says():
    env = WorldEnv(SMALL, slip=0.5, max_steps=1)
    noisy = env.dynamics
    reached = []
    for seed in range(4000):
        env.reset(seed=seed)
        reached.append(env.step(1)[-1]["state"])
    share = np.bincount(reached, minlength=noisy.states) / len(reached)
    wanted = noisy.transition(1)[[noisy.start]].toarray()[0]
    assert np.abs(share - wanted).max() < 5 * np.sqrt(0.25 / len(reached))


def test_an_episode_is_cut_off_and_the_next_is_as_long():
    env = WorldEnv("yard", max_steps=3)
    for _ in range(2):
        env.reset()
        assert [env.step(0)[3] for _ in range(3)] == [False, False, True]


def test_a_shortest_plan_earns_its_return_and_terminates():
    plan = hb.solve(hb.tabulate(hb.load_world("corridor")))
    assert plan is not None
    env = gymnasium.make("habilis/Corridor-v0")
    env.reset(seed=0)
    steps = [env.step(action) for action in plan.actions]
    assert sum(float(step[1]) for step in steps) == plan.best_return
    assert [step[2] for step in steps] == [False] * (len(steps) - 1) + [True]


def test_onehot_marks_the_cell_of_each_thing():
    env = WorldEnv(SMALL, observation="onehot")
    shown, _ = env.reset()
    assert np.flatnonzero(shown).tolist() == [6, 25 + 7, 50 + 13]


def test_grid_has_a_channel_a_thing():
    env = WorldEnv(SMALL, observation="grid")
    env.reset()
    shown = env.step(2)[0]  # south: agent and picker go down together, beside the can
    lines = np.array([list(line) for line in SMALL.splitlines()])
    assert (shown[0] == (lines == "#")).all()
    assert [np.argwhere(channel).tolist() for channel in shown[1:]] == [
        [[3, 3]],
        [[2, 1]],
        [[2, 2]],
        [[2, 3]],
    ]


def test_without_a_tool_there_are_four_actions_and_two_things():
    env = WorldEnv("yard", tool="none", observation="grid")
    assert env.action_space.n == 4
    assert env.observation_space.shape == (4, 10, 10)
    assert "equipped" in env.reset()[1]


def test_observations_are_the_callers_own():
    for kind in KINDS:
        env = WorldEnv(SMALL, observation=kind)
        first, _ = env.reset()
        kept = first.copy()
        first[...] = 0
        assert np.array_equal(env.reset()[0], kept)


def test_a_copy_goes_its_own_way():
    env = gymnasium.make("habilis/Yard-v0", measures={"toe": {"horizon": 1}}, slip=0.5)
    env.reset(seed=0)
    env.step(1)
    copied = copy.deepcopy(env)
    ahead = [env.step(2) for _ in range(9)]
    assert same(ahead, [copied.step(2) for _ in range(9)])


def test_its_table_is_its_own():
    env = gymnasium.make("habilis/Yard-v0", slip=0.25)
    mdp = hb.TabularMDP.from_gymnasium(env)
    noisy = hb.tabulate(hb.load_world("yard"), slip=0.25)
    assert np.array_equal(mdp.transition(3).indices, noisy.transition(3).indices)
    assert np.array_equal(mdp.transition(3).data, noisy.transition(3).data)
    assert mdp.start == noisy.start


def test_pictures_are_those_of_the_world():
    env: Any = gymnasium.make("habilis/Yard-v0", render_mode="rgb_array")
    env.reset(seed=0)
    for action in (1, 2, 5, 2, 3):
        env.step(action)
        inner = env.unwrapped
        world = placement(inner.world, inner.mdp, inner.state)
        assert np.array_equal(env.render(), frame(world))


def test_rgb_observations_are_smaller_pictures():
    env = WorldEnv(SMALL, observation="rgb")
    shown, _ = env.reset()
    assert np.array_equal(shown, frame(hb.World.parse(SMALL), 16))


def test_ansi_is_the_map_in_colours():
    env = gymnasium.make("habilis/World-v0", world=SMALL, render_mode="ansi")
    env.reset(seed=0)
    text = str(env.render())
    plain = re.sub(r"\x1b\[[0-9;]*m", "", text)
    assert text != plain
    assert plain.replace(" ", "") == SMALL


def test_render_without_a_mode_draws_nothing_and_says_so():
    env = WorldEnv("yard")
    env.reset()
    with pytest.warns(UserWarning, match="render_mode"):
        assert env.render() is None


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"world": "nowhere"}, "nowhere'?: no such world"),
        ({"world": "A.X\nPCG"}, "line 1, column 3: unknown character 'X'"),
        ({"world": "yard", "tool": "hammer"}, "tool 'hammer' is unknown"),
        ({"world": "yard", "observation": "smell"}, "observation 'smell' is unknown; use one of"),
        ({"world": "yard", "render_mode": "3d"}, "render_mode '3d' is unknown; use one of"),
        ({"world": "yard", "max_steps": 0}, "max_steps is 0; give a whole number"),
        ({"world": "yard", "slip": 2}, "slip is 2; give a probability"),
        ({"world": "yard", "measures": {"state": {"horizon": 1}}}, "measure 'state' is what"),
        ({"world": "yard", "measures": {"toe": {"horizon": -1}}}, "horizon"),
        ({"world": "yard", "measures": {"toe": {"horizn": 1}}}, "measure 'toe'"),
        ({"world": "yard", "measures": {"toe": 3}}, "measure 'toe'"),
        ({"world": "yard", "measures": ["toe"]}, "measures is .*; give names"),
        (
            {"world": "yard", "measures": {"toe": {"horizon": 1, "return_gap": True}}},
            "measure 'toe' needs one value",
        ),
        (
            {"world": "yard", "measures": {"toe": {"horizon": 1, "states": [0]}}},
            "measure 'toe' needs one value",
        ),
        ({"world": 5}, "world is 5; give"),
    ],
)
def test_what_cannot_be_made_is_refused_in_one_line(arguments, message):
    with pytest.raises(ValueError, match=message) as refused:
        WorldEnv(**arguments)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("action", [-1, 8, 1.5, None])
def test_an_action_that_there_is_not_is_refused(action):
    env = WorldEnv("yard")
    env.reset()
    with pytest.raises(ValueError, match=f"action is {action}; use 0 to 7"):
        env.step(action)


def test_a_tool_of_ones_own_is_stepped_shown_and_measured():
    rake = f"{Path(__file__).parents[2] / 'examples' / 'rake.py'}:Rake"
    toe = {"horizon": 2, "sensor": "object"}
    env: Any = gymnasium.make(
        "habilis/Yard-v0", tool=rake, render_mode="rgb_array", measures={"toe": toe}
    )
    mdp = hb.tabulate(hb.load_world("yard", tool=rake))
    bits = hb.empowerment(mdp, **toe)
    _, info = env.reset(seed=0)
    for action in (1, 4, 2, 3, 0):
        inner = env.unwrapped
        assert info["toe"] == bits[info["state"]]
        world = placement(inner.world, inner.mdp, inner.state)
        assert np.array_equal(env.render(), frame(world))
        after = mdp.next_state[info["state"], action]
        info = env.step(action)[4]
        assert info["state"] == after


@pytest.mark.parametrize("kind", ["factors", "onehot", "grid", "rgb"])
def test_an_environment_goes_to_another_process(kind):
    env = gymnasium.make("habilis/Yard-v0", observation=kind)
    env.reset(seed=0)
    env.step(2)
    there = pickle.loads(pickle.dumps(env))
    np.testing.assert_array_equal(there.step(1)[0], env.step(1)[0])
