"""Tables of third-party environments match the environments."""

import json
import re
import subprocess
import sys
import threading
from typing import Any

import gymnasium
import minigrid  # noqa: F401  (registers its environments)
import numpy as np
import pytest
from gymnasium.spaces import Discrete, MultiDiscrete

import habilis as hb
from habilis.cli import main
from habilis.mdp import TabularMDP

TOY_TEXT: list[tuple[str, dict[str, Any]]] = [
    ("FrozenLake-v1", {}),
    ("FrozenLake-v1", {"is_slippery": False}),
    ("FrozenLake-v1", {"map_name": "8x8"}),
    ("FrozenLake-v1", {"map_name": "8x8", "is_slippery": False}),
    ("CliffWalking-v1", {}),
    ("CliffWalking-v1", {"is_slippery": True}),
    ("Taxi-v4", {}),
    ("Taxi-v4", {"is_rainy": True}),
]


def table_of(name: str, **arguments: Any) -> TabularMDP:
    return TabularMDP.from_gymnasium(gymnasium.make(name, **arguments))


# Toy text: from their own P


@pytest.mark.parametrize(("name", "arguments"), TOY_TEXT)
def test_a_toy_text_table_says_what_the_environment_says(name: str, arguments: dict[str, Any]):
    env: Any = gymnasium.make(name, **arguments).unwrapped
    mdp = TabularMDP.from_gymnasium(env)
    assert (mdp.states, mdp.action_count) == (env.observation_space.n, env.action_space.n)
    for action in range(mdp.action_count):
        matrix = mdp.transition(action).toarray()
        for state in range(mdp.states):
            said = np.zeros(mdp.states)
            mean = 0.0
            for chance, after, reward, _ in env.P[state][action]:
                said[after] += chance
                mean += chance * reward
            assert np.allclose(matrix[state], said, atol=1e-12)
            assert mdp.reward[state, action] == pytest.approx(mean, abs=1e-5)


@pytest.mark.parametrize(("name", "arguments"), TOY_TEXT)
def test_the_environment_goes_only_where_its_table_leads(name: str, arguments: dict[str, Any]):
    env = gymnasium.make(name, **arguments)
    mdp = TabularMDP.from_gymnasium(env)
    ways = [mdp.transition(action).toarray() for action in range(mdp.action_count)]
    rng = np.random.default_rng(0)
    state, _ = env.reset(seed=0)
    for _ in range(300):
        action = int(rng.integers(mdp.action_count))
        after, reward, terminated, truncated, _ = env.step(action)
        assert ways[action][int(state), int(after)] > 0
        assert terminated == mdp.terminal[int(after)]
        if not mdp.is_stochastic:
            assert reward == mdp.reward[int(state), action]
        state = env.reset()[0] if terminated or truncated else after


def test_only_what_is_slippery_is_stochastic():
    for name, arguments in TOY_TEXT:
        chance = arguments.get("is_slippery", name == "FrozenLake-v1")
        chance = arguments.get("is_rainy", chance)
        assert table_of(name, **arguments).is_stochastic is chance


def test_the_factors_of_toy_text_are_what_is_where():
    lake = table_of("FrozenLake-v1", map_name="8x8")
    assert lake.shape == (8, 8)
    assert lake.find(agent=(7, 7)) == 63
    assert lake.actions == ("left", "down", "right", "up")
    cliff = table_of("CliffWalking-v1")
    assert cliff.start == cliff.find(agent=(3, 0))
    assert np.flatnonzero(cliff.terminal).tolist() == [cliff.find(agent=(3, 11))]
    taxi = table_of("Taxi-v4")
    # The documentation's own example: taxi at (3, 1), passenger at place 2, destination 0.
    assert [int(taxi.factor(name)[328]) for name in taxi.factors] == [3 * 5 + 1, 2, 0]
    assert taxi.actions[4:] == ("pick up", "drop off")


def test_walking_on_dry_ice_counts_cells():
    lake = table_of("FrozenLake-v1", is_slippery=False, desc=["SFF", "FFF", "FFG"])
    assert np.allclose(hb.empowerment(lake, 1), np.log2([3, 4, 3, 4, 4, 4, 3, 4, 1]))
    # Four steps reach every cell but for parity, which walls undo.
    assert hb.empowerment(lake, 4)[0] == np.log2(9)


def test_slippery_ice_is_a_channel_with_a_closed_form():
    # In the middle each action leads to three of four sides with 1/3: by symmetry all alike.
    lake = table_of("FrozenLake-v1", desc=["FFFFF", "FFFFF", "FFFFF", "FFFFF", "SFFFG"])
    assert hb.empowerment(lake, 1)[12] == pytest.approx(np.log2(4) - np.log2(3), abs=1e-6)


def test_a_taxi_can_do_one_thing_to_a_passenger_at_its_own_place():
    taxi = table_of("Taxi-v4")
    bits = hb.empowerment(taxi, 1, "passenger")
    at = taxi.factor("taxi")
    places = np.array([0, 4, 20, 23])
    waiting = taxi.factor("passenger") < 4
    beside = waiting & (at == places[np.minimum(taxi.factor("passenger"), 3)])
    carrying = ~waiting & np.isin(at, places)
    assert np.array_equal(bits, np.where(beside | carrying, 1.0, 0.0))


def test_a_taxi_far_sighted_enough_brings_the_passenger_anywhere():
    taxi = table_of("Taxi-v4")
    bits = hb.empowerment(taxi, 40, "passenger")
    assert np.allclose(bits, np.log2(5))
    assert (hb.empowerment(taxi, 40, "destination") == 0).all()


def test_a_taxi_whose_passengers_change_their_minds_is_refused():
    with pytest.raises(ValueError, match="fickle_passenger=False"):
        table_of("Taxi-v4", fickle_passenger=True)


# Others: by stepping through all states


@pytest.fixture(scope="module")
def rooms() -> dict[str, TabularMDP]:
    names = ("MiniGrid-Empty-8x8-v0", "MiniGrid-DoorKey-5x5-v0")
    return {name: table_of(name) for name in names}


def test_an_empty_room_has_four_directions_a_cell_but_for_the_goal(rooms: dict[str, TabularMDP]):
    mdp = rooms["MiniGrid-Empty-8x8-v0"]
    assert mdp.states == 35 * 4 + 2  # the goal is entered from the west or the north, and ends
    assert mdp.terminal.sum() == 2
    assert mdp.actions[:3] == ("left", "right", "forward")
    bits = hb.empowerment(mdp, 1, "agent", states=[mdp.start])
    assert bits == 1.0  # stay or go
    assert hb.empowerment(mdp, 1, "direction", states=[mdp.start]) == np.log2(3)
    assert hb.empowerment(mdp, 20, "agent", states=[mdp.start]) == np.log2(36)


def test_a_key_is_a_tool(rooms: dict[str, TabularMDP]):
    mdp = rooms["MiniGrid-DoorKey-5x5-v0"]
    door, key, carried = (mdp.factor(name) for name in ("door", "key", "carried"))
    assert set(np.unique(door)) == {0, 1, 2}
    in_hand = key == -1
    assert np.array_equal(in_hand, carried > 0)
    # What is locked stays so without the key; with it, next to the door, one action opens it.
    bits = hb.empowerment(mdp, 1, "door")
    assert (bits[(door == 2) & ~in_hand] == 0).all()
    assert bits[(door == 2) & in_hand].max() == 1
    # The key is put down, or picked up, where the agent faces it.
    assert set(np.unique(hb.empowerment(mdp, 1, "key"))) == {0.0, 1.0}


@pytest.mark.parametrize("name", ["MiniGrid-Empty-8x8-v0", "MiniGrid-DoorKey-5x5-v0"])
def test_an_enumerated_table_says_what_the_environment_does(
    name: str, rooms: dict[str, TabularMDP]
):
    env, mdp = gymnasium.make(name), rooms[name]
    rng = np.random.default_rng(1)
    for _ in range(20):
        env.reset(seed=0)
        state = mdp.start
        for _ in range(60):
            action = int(rng.integers(mdp.action_count))
            _, reward, terminated, truncated, _ = env.step(action)
            assert (float(reward) > 0) == (mdp.reward[state, action] > 0)
            state = mdp.next_state[state, action]
            inner: Any = env.unwrapped
            column, row = inner.agent_pos
            assert mdp.factor("agent")[state] == row * inner.width + column
            assert mdp.factor("direction")[state] == inner.agent_dir
            assert (mdp.factor("carried")[state] > 0) == (inner.carrying is not None)
            assert terminated == mdp.terminal[state]
            if terminated or truncated:
                break


class Counter(gymnasium.Env):
    """Counts up or down within bounds; no transition depends on `steps`, which is time."""

    action_space = Discrete(2)
    observation_space = Discrete(100)

    def __init__(self, most: int = 5):
        self.most, self.at, self.steps = most, 0, 0

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[int, dict]:
        super().reset(seed=seed)
        self.at, self.steps = 0, 0
        return self.at, {}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict]:
        self.steps += 1
        self.at = min(self.at + 1, self.most) if action else max(self.at - 1, 0)
        return self.at, float(self.at), self.at == self.most, self.steps > 3, {}


def test_what_is_ignored_is_no_part_of_a_state_and_truncation_no_end():
    mdp = TabularMDP.from_gymnasium(Counter(), ignore=("steps",))
    assert mdp.next_state.tolist() == [[0, 1], [0, 2], [1, 3], [2, 4], [3, 5], [5, 5]]
    assert mdp.terminal.tolist() == [False] * 5 + [True]
    assert mdp.reward[3].tolist() == [2.0, 4.0]
    assert mdp.reward[5].tolist() == [0.0, 0.0]


def test_the_environment_is_left_as_it_was():
    env = gymnasium.make("MiniGrid-DoorKey-5x5-v0")
    env.reset(seed=3)
    inner: Any = env.unwrapped
    before = (inner.agent_pos, inner.agent_dir, inner.step_count, inner.grid.encode().tobytes())
    chance = inner.np_random.bit_generator.state
    TabularMDP.from_gymnasium(env, seed=None)
    after = (inner.agent_pos, inner.agent_dir, inner.step_count, inner.grid.encode().tobytes())
    assert after == before
    assert inner.np_random.bit_generator.state == chance


def test_the_table_can_start_where_the_environment_is():
    env = Counter()
    env.reset()
    env.step(1)
    env.step(1)
    env.steps = 0
    factors = {"at": lambda env: env.at}
    mdp = TabularMDP.from_gymnasium(env, seed=None, ignore=["steps"], factors=factors)
    assert mdp.factor("at")[mdp.start] == 2
    assert sorted(mdp.factor("at")) == list(range(6))


class Settable(Counter):
    """Cannot be copied, but its state can be set."""

    def __deepcopy__(self, memo: Any) -> Any:
        raise TypeError("a handle to a simulator")

    def get_state(self) -> dict[str, int]:
        return {"at": self.at}

    def set_state(self, state: dict[str, int]) -> None:
        self.at = state["at"]


def test_an_environment_whose_state_can_be_set_need_not_be_copied():
    env = Settable()
    env.reset()
    env.step(1)
    mdp = TabularMDP.from_gymnasium(env)
    other = TabularMDP.from_gymnasium(Counter(), ignore=("steps",))
    assert np.array_equal(mdp.next_state, other.next_state)
    assert env.at == 1


def test_a_key_defines_which_states_are_equal():
    mdp = TabularMDP.from_gymnasium(Counter(), key=lambda env: (env.at, env.at == env.most))
    assert mdp.states == 6
    with pytest.raises(ValueError, match="its transitions depend on what key= leaves out"):
        TabularMDP.from_gymnasium(Counter(3), key=lambda env: min(env.at, 1))


class Dice(Counter):
    def step(self, action: int) -> tuple[int, float, bool, bool, dict]:
        self.at = int(self.np_random.integers(6))
        return self.at, 0.0, False, False, {}


class DiceInVain(Counter):
    def step(self, action: int) -> tuple[int, float, bool, bool, dict]:
        self.np_random.integers(6)
        return super().step(action)


def test_randomness_is_detected():
    with pytest.raises(ValueError, match="action 0 in state 0 has more than one outcome"):
        TabularMDP.from_gymnasium(Dice())
    assert TabularMDP.from_gymnasium(DiceInVain(), ignore=("steps",)).states == 6


class Uncopyable(Counter):
    def __deepcopy__(self, memo: Any) -> Any:
        raise TypeError("a handle to a simulator")


class ManyActions(Counter):
    action_space = MultiDiscrete([2, 2])


@pytest.mark.parametrize(
    ("env", "message"),
    [
        (Uncopyable(), "Uncopyable cannot be copied (a handle to a simulator); make it without"),
        (ManyActions(), "the actions are MultiDiscrete([2 2]); only Discrete(n)"),
        (
            np.eye(3),
            "array([[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]]) is not a Gymnasium environment",
        ),
        (
            "FrozenLake-v1",
            "'FrozenLake-v1' is not a Gymnasium environment; give what gymnasium.make",
        ),
    ],
)
def test_what_cannot_be_tabulated_is_refused_with_the_fix(env: Any, message: str):
    with pytest.raises(ValueError, match=re.escape(message)):
        TabularMDP.from_gymnasium(env)


def test_an_attribute_that_cannot_be_compared_is_named_and_may_be_ignored():
    class Simulator:
        def __init__(self) -> None:
            self.lock = threading.Lock()

        def __deepcopy__(self, memo: Any) -> "Simulator":
            return Simulator()

    env = Counter()
    env.simulator = Simulator()  # type: ignore[attr-defined]
    with pytest.raises(ValueError, match=r"attribute 'simulator\.lock' .* cannot be compared"):
        TabularMDP.from_gymnasium(env)
    assert TabularMDP.from_gymnasium(env, ignore=["simulator", "steps"]).states == 6


def test_more_states_than_allowed_are_refused():
    with pytest.raises(ValueError, match="more than 40 states can be reached, 39 of them"):
        TabularMDP.from_gymnasium(Counter(60), max_states=40, ignore=("steps",))


def test_the_attribute_that_keeps_growing_is_named():
    with pytest.raises(ValueError, match=r"leave out the attribute 'steps'.*ignore=\['steps'\]"):
        TabularMDP.from_gymnasium(Counter(), max_states=40)


def test_a_factor_that_is_no_number_is_refused():
    with pytest.raises(ValueError, match="factor 'half' is not a whole number in every state"):
        TabularMDP.from_gymnasium(
            Counter(), ignore=["steps"], factors={"half": lambda env: env.at / 2}
        )


# On the command line


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    assert main([*arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_the_command_line_takes_environments(capsys: pytest.CaptureFixture[str]):
    answer = printed(capsys, "empowerment", "gym:FrozenLake-v1", "--horizon", "3")
    bits = hb.empowerment(table_of("FrozenLake-v1"), 3)
    assert answer["states"] == 16
    assert answer["mean"] == pytest.approx(bits.mean())
    assert 0 < answer["gap"] <= 1e-6


def test_arguments_of_the_environment_follow_its_name(capsys: pytest.CaptureFixture[str]):
    name = "gym:FrozenLake-v1?map_name=8x8&is_slippery=false"
    answer = printed(capsys, "empowerment", name, "--horizon", "3")
    assert (answer["states"], answer["gap"]) == (64, 0)


def test_the_package_that_registers_an_environment_may_be_named(
    capsys: pytest.CaptureFixture[str], tmp_path
):
    out = str(tmp_path / "key.csv")
    name = "gym:minigrid:MiniGrid-DoorKey-5x5-v0"
    printed(capsys, "empowerment", name, "--sensor", "key", "--horizon", "2", "--out", out)
    header = (tmp_path / "key.csv").read_text().splitlines()[0]
    assert header == "state,agent,direction,carried,door,key,bits"


def test_attributes_are_ignored_on_the_command_line(capsys: pytest.CaptureFixture[str]):
    gymnasium.register("habilis-tests/Counter-v0", f"{__name__}:Counter")
    name = ["empowerment", "gym:habilis-tests/Counter-v0", "--horizon", "2"]
    try:
        assert main([*name, "--max-states", "40"]) == 2
        error = capsys.readouterr().err
        assert "raise --max-states, or leave out the attribute 'steps'" in error
        assert "with --ignore steps if no transition depends on it" in error
        assert printed(capsys, *name, "--ignore", "steps")["states"] == 6
    finally:
        del gymnasium.registry["habilis-tests/Counter-v0"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["corridor", "--ignore", "steps"], "--ignore is for environments, gym:ID; leave it out"),
        (["gym:Nope-v1"], "gym:Nope-v1 cannot be made (Environment `Nope` doesn't exist"),
        (["gym:FrozenLake-v1?x=1"], "unexpected keyword argument 'x'"),
        (["gym:nopackage:X-v1"], "No module named 'nopackage'"),
        (["gym:FrozenLake-v1", "--tool", "broom"], "gym:FrozenLake-v1 has no tool to choose"),
        (["gym:FrozenLake-v1", "--sensor", "nose"], "sensor 'nose' is unknown; use one of state"),
    ],
)
def test_what_is_no_environment_is_refused(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
):
    assert main(["empowerment", *arguments, "--horizon", "1"]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_a_progress_bar_is_drawn_on_standard_error_when_asked():
    code = (
        "import gymnasium, minigrid, habilis as hb, habilis.progress;"
        "habilis.progress.PATIENCE = 0;"
        "hb.TabularMDP.from_gymnasium("
        "gymnasium.make('MiniGrid-Empty-5x5-v0'), show_progress=True)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={"FORCE_COLOR": "1", "PATH": ""},
    )
    assert "states" in done.stderr
    assert "replays" in done.stderr
    assert done.stdout == ""


def test_without_gymnasium_the_command_line_says_what_to_install():
    code = (
        "import sys; sys.modules['gymnasium'] = None\n"
        "from habilis.cli import main\n"
        "sys.exit(main(['empowerment', 'gym:FrozenLake-v1', '--horizon', '1']))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 2
    assert "run: pip install 'habilis[gymnasium]'" in done.stderr
