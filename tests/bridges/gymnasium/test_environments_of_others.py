"""Environments that their authors wrote in ordinary ways are tabulated right, or refused."""

import copy
import dataclasses
import itertools
import pickle
import random
import re
import threading
import weakref
from typing import Any

import gymnasium
import minigrid  # noqa: F401  # registers its environments
import numpy as np
import pygame
import pytest
from gymnasium.spaces import Box, Discrete
from gymnasium.utils import EzPickle
from gymnasium.wrappers import TimeAwareObservation, TimeLimit
from minigrid.wrappers import NoDeath

import habilis as hb
from habilis.bridges.gymnasium import enumeration

T = hb.TabularMDP.from_gymnasium


class Cells(gymnasium.Env):
    """A row of cells; action 0 goes left, 1 right."""

    action_space = Discrete(2)
    observation_space = Discrete(1000)

    def __init__(self, cells: int = 5) -> None:
        self.cells, self.at = cells, 0

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict]:
        super().reset(seed=seed)
        self.at = 0
        return self.at, {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        self.move(1 if action else -1)
        return self.at, 0.0, False, False, {}

    def move(self, by: int) -> None:
        self.at = min(max(self.at + by, 0), self.cells - 1)


def bits(env: Any, horizon: int, **options: Any) -> float:
    mdp = T(env, **options)
    return float(hb.empowerment(mdp, horizon, states=[mdp.start])[0])


# One state is counted once


class Stuck(Cells):
    """Nothing can be done, but a tuple becomes an array, an int32 an int64, and 0.0 -0.0."""

    values = itertools.cycle([np.array([0]), [0.0], (np.int32(0),), np.array([-0.0], np.float32)])

    def reset(self, **options: Any) -> tuple[Any, dict]:
        super().reset(**options)
        self.at = (0,)
        return 0, {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        if action:
            self.at = next(Stuck.values)
        return 0, 0.0, False, False, {}


def test_equal_values_of_other_types_are_one_state():
    assert T(Stuck()).states == 1
    assert bits(Stuck(), 1) == 0


def seen(env: Any) -> tuple:
    """The visible state of a Minigrid."""
    carried = env.carrying and env.carrying.encode()
    return env.grid.encode().tobytes(), tuple(map(int, env.agent_pos)), int(env.agent_dir), carried


def searched(name: str) -> dict[tuple, list[tuple]]:
    """Where each action leads in a Minigrid, by a search of its own."""
    first: Any = gymnasium.make(name).unwrapped
    first.reset(seed=0)
    successors, todo = {seen(first): []}, [first]
    while todo:
        env = todo.pop(0)
        for action in range(7):
            after = copy.deepcopy(env)
            after.step_count = 0
            ended = after.step(action)[2]
            there = seen(after)
            successors[seen(env)].append(there)
            if there not in successors:
                successors[there] = [there] * 7 if ended else []
                todo += [] if ended else [after]
    return successors


def test_a_door_and_a_key_are_what_a_search_of_its_own_finds():
    mdp = T(gymnasium.make("MiniGrid-DoorKey-5x5-v0"), seed=0)
    successors = searched("MiniGrid-DoorKey-5x5-v0")
    assert mdp.states == len(successors) == 270
    reached = {next(iter(successors))}
    for _ in range(3):
        reached = {there for here in reached for there in successors[here]}
    assert len(reached) == 8
    assert hb.empowerment(mdp, 3, states=[mdp.start])[0] == 3.0


# Objects refer to each other


class Room:
    def __init__(self, number: int, env: Any) -> None:
        self.number, self.env, self.doors = number, env, list[Room]()


class Rooms(Cells):
    """Rooms in a circle that know their neighbors, and the environment itself."""

    def __init__(self, rooms: int = 4) -> None:
        super().__init__()
        self.rooms = [Room(number, self) for number in range(rooms)]
        for one, other in zip(self.rooms, self.rooms[1:] + self.rooms[:1], strict=True):
            one.doors.append(other)
            other.doors.append(one)
        self.room = self.rooms[0]

    def reset(self, **options: Any) -> tuple[Any, dict]:
        super().reset(**options)
        self.room = self.rooms[0]
        return 0, {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        self.room = self.room.doors[action]
        assert self.room.env is self
        return self.room.number, 0.0, False, False, {}


def test_objects_may_refer_to_each_other_and_to_the_environment():
    mdp = T(Rooms(), factors={"room": lambda env: env.room.number})
    assert mdp.states == 4
    assert hb.empowerment(mdp, 1, states=[0])[0] == 1
    assert sorted(mdp.factor("room")) == [0, 1, 2, 3]


def test_rooms_of_a_minigrid_that_name_their_neighbors_are_enumerated():
    mdp = T(gymnasium.make("MiniGrid-Unlock-v0"))
    assert mdp.states == 1025  # as many as `searched` finds; see also docs/is-it-right


class Linked(Cells):
    """A wrapper inside refers to what is around it."""

    def __init__(self) -> None:
        super().__init__()
        self.outer: Any = None


def test_an_environment_may_know_its_wrapper():
    inner = Linked()
    inner.outer = gymnasium.wrappers.TimeLimit(inner, 50)
    assert T(inner.outer).states == 5


# Randomness, wherever it is drawn from


class Noisy(Cells):
    """A row of 40 cells whose step now and then goes the other way."""

    def __init__(self, kind: str, probability: float = 0.3) -> None:
        super().__init__(40)
        self.kind, self.probability = kind, probability
        self.generator = np.random.default_rng(0)
        self.python = random.Random(0)

    def draw(self) -> float:
        if self.kind == "action_space":
            return self.action_space.sample() * 0.5 + 0.2
        return {
            "numpy": np.random.random,
            "python": random.random,
            "np_random": self.np_random.random,
            "own": self.generator.random,
            "own python": self.python.random,
            "unseen": _UNSEEN.random,
            "system": random.SystemRandom().random,
        }[self.kind]()

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        self.move(1 if (action == 1) != (self.draw() < self.probability) else -1)
        return self.at, 0.0, False, False, {}


_UNSEEN = np.random.default_rng()
KINDS = ["numpy", "python", "np_random", "own", "own python", "action_space", "unseen", "system"]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_randomness_is_found_out_wherever_it_is_drawn(kind: str, seed: int):
    np.random.seed(seed)
    random.seed(seed)
    with pytest.raises(ValueError, match=r"more than one outcome|does not follow its table"):
        T(Noisy(kind))


@pytest.mark.parametrize("kind", ["np_random", "numpy", "own"])
@pytest.mark.parametrize("seed", range(3))
def test_one_other_outcome_in_a_thousand_is_found(
    kind: str, seed: int, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(enumeration, "_SECONDS", 300.0)  # so that all are tried on any machine
    with pytest.raises(ValueError, match="more than one outcome"):
        T(Noisy(kind, 0.001), seed=seed)


def test_what_is_drawn_in_vain_is_no_randomness(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(enumeration, "_TRIES", 1000)
    for kind in KINDS[:-2]:
        assert T(Noisy(kind, -1.0)).states == 40


def test_random_generators_of_the_user_are_left_as_they_are(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(enumeration, "_TRIES", 1000)
    for kind in ("numpy", "python", "np_random", "own"):
        env = Noisy(kind, -1.0)
        env.reset(seed=3)
        np.random.seed(5)
        random.seed(5)
        expected = np.random.random(), random.random(), env.np_random.random()
        env.reset(seed=3)
        np.random.seed(5)
        random.seed(5)
        T(env)
        assert (np.random.random(), random.random(), env.np_random.random()) == expected


# Copies


class Forgetful(Cells, EzPickle):
    """Copies of it begin anew."""

    def __init__(self) -> None:
        super().__init__()
        EzPickle.__init__(self)


class Holder(Cells):
    """Moves what forgets its state when it is copied."""

    def __init__(self) -> None:
        super().__init__()
        self.inside = Forgetful()

    def reset(self, **options: Any) -> tuple[Any, dict]:
        super().reset(**options)
        self.inside.reset()
        return 0, {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        return self.inside.step(action)


@pytest.mark.parametrize("kind", [Forgetful, Holder])
def test_copies_do_not_forget(kind: type):
    mdp = T(kind())
    assert mdp.states == 5
    assert hb.empowerment(mdp, 4, states=[0])[0] == np.log2(5)


def test_empowerment_is_added_to_the_reward_of_what_forgets():
    env = hb.EmpowermentReward(Forgetful(), 4, "state", beta=1.0)
    env.reset(seed=0)
    rewards = [env.step(1)[1] for _ in range(6)]
    assert rewards == pytest.approx([np.log2(5)] * 6)


class PartlyKept(Cells):
    """Leaves its place out of its copies."""

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "at"} | {"at": 0}


class Enclosed(Cells):
    """Its moves are made by a function that has the environment in its closure."""

    def __init__(self) -> None:
        super().__init__()
        self.mover = lambda by: self.move(by)

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        self.mover(1 if action else -1)
        return self.at, 0.0, False, False, {}


@pytest.mark.parametrize(
    ("env", "message"),
    [
        (PartlyKept(), "is not in the state that was copied or saved; give state=(save, load)"),
        (Enclosed(), "still refers to the environment that it was copied from"),
    ],
)
def test_copies_that_are_none_are_refused(env: Any, message: str):
    with pytest.raises(ValueError, match=re.escape(message)):
        T(env)


def place(env: Any) -> int:
    return env.unwrapped.at


def put(env: Any, at: int) -> None:
    env.unwrapped.at = at


@pytest.mark.parametrize("env", [PartlyKept(), Enclosed(), Forgetful(), Cells()])
def test_two_functions_say_what_a_state_is(env: Any):
    env.reset(seed=0)
    env.step(1)
    mdp = T(env, state=(place, put))
    assert mdp.states == 5
    assert hb.empowerment(mdp, 4, states=[0])[0] == np.log2(5)
    assert env.at == 1


def test_functions_that_do_not_restore_a_state_are_refused():
    with pytest.raises(ValueError, match=r"Cells after load\(env, value\) is not in the state"):
        T(Cells(), state=(place, lambda env, value: None))
    with pytest.raises(ValueError, match=r"save\(env\) does not return all that its next steps"):
        T(Cells(3), state=(lambda env: min(env.at, 1), put))


class Anew(Cells):
    """Copies are made by the constructor."""

    def __deepcopy__(self, memo: Any) -> Any:
        return type(self)()


class Body:
    def __init__(self, world: Any) -> None:
        self.world = weakref.proxy(world)


class Proxied(Cells):
    def __init__(self) -> None:
        super().__init__()
        self.body = Body(self)


class Restarts(Cells, EzPickle):
    """Episodes do not begin as the constructor does."""

    def __init__(self) -> None:
        super().__init__()
        EzPickle.__init__(self)

    def reset(self, **options: Any) -> tuple[Any, dict]:
        super().reset(**options)
        self.at = 2
        return 2, {}


def test_the_first_copy_is_compared_with_the_environment_itself():
    for env in (Anew(7), Proxied()):
        with pytest.raises(ValueError, match=r"give state=\(save, load\)"):
            T(env)
        assert T(env, state=(place, put)).states == env.cells
    assert T(Restarts()).states == 5


class Locked(Cells):
    def __init__(self) -> None:
        super().__init__()
        self.lock = threading.Lock()
        self.same_lock = self.lock


def test_what_cannot_be_compared_does_not_matter_where_functions_say_what_a_state_is():
    assert T(Locked(), state=(place, put)).states == 5


class RandomLater(Cells):
    probability = 0.001

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        if self.np_random.random() < self.probability:
            action = 1 - action
        return super().step(action)


class OfTheClass(Cells):
    """Draws from a space that all instances share."""

    noise = Box(0, 1, (1,))
    probability = 0.001

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        if self.noise.sample()[0] < self.probability:
            action = 1 - action
        return super().step(action)


@pytest.mark.parametrize("state", [None, (place, put)])
@pytest.mark.parametrize("kind", [RandomLater, OfTheClass])
def test_generators_that_a_reset_makes_and_those_of_classes_are_watched(kind: Any, state: Any):
    with pytest.raises(ValueError, match="more than one outcome"):
        T(kind(), state=state)


def test_the_generator_of_the_user_is_put_back(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(enumeration, "_TRIES", 100)
    monkeypatch.setattr(RandomLater, "probability", -1.0)
    env, other = RandomLater(), RandomLater()
    for one in (env, other):
        one.reset(seed=7)
    T(env, state=(place, put))
    assert env.np_random.random() == other.np_random.random()
    assert env.np_random_seed == 7


class OfAllInstances(Cells):
    board = np.zeros(5)

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        self.board[0] = (self.board[0] + action) % 5
        return 0, 0.0, False, False, {}


def test_state_of_a_class_is_refused():
    with pytest.raises(ValueError, match="a step changes an attribute of the class OfAllInstances"):
        T(OfAllInstances())


class Ends(Cells):
    """Ends after so many steps, whatever they are."""

    def __init__(self, after: int) -> None:
        super().__init__()
        self.after, self.steps = after, 0

    def reset(self, **options: Any) -> tuple[Any, dict]:
        self.steps = 0
        return super().reset(**options)

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        self.steps += 1
        super().step(action)
        return self.at, 0.0, self.steps >= self.after, False, {}


class LateWind(gymnasium.Wrapper):
    def __init__(self, env: Any) -> None:
        super().__init__(env)
        self.count = 0

    def step(self, action: Any) -> Any:
        self.count += 1
        return self.env.step(0 if self.count > 300 else action)


def test_what_happens_late_in_an_episode_is_found_out():
    for after in (20, 100, 400):
        with pytest.raises(ValueError, match=r"its transitions depend on steps"):
            T(Ends(after), ignore=["steps"])
    for env in (Cells(), WithP(listed())):
        with pytest.raises(ValueError, match="LateWind changes what a step does"):
            T(LateWind(env))


@dataclasses.dataclass(frozen=True)
class Clock:
    at: int = 0
    steps: int = 0


class Ticks(Cells):
    def reset(self, **options: Any) -> tuple[Any, dict]:
        super().reset(**options)
        self.clock = Clock()
        return 0, {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        at = min(max(self.clock.at + (1 if action else -1), 0), 4)
        self.clock = Clock(at, self.clock.steps + 1)
        return at, 0.0, False, False, {}


def test_attributes_of_attributes_are_named_and_ignored():
    with pytest.raises(ValueError, match=r"leave out the attribute 'clock.steps'"):
        T(Ticks(), max_states=40)
    assert T(Ticks(), ignore=["clock.steps"]).states == 5


class Bits(Cells):
    """A board of bits, and sprites that are known by their keys."""

    def reset(self, **options: Any) -> tuple[Any, dict]:
        super().reset(**options)
        self.board = np.uint64(1 << 63)
        self.sprites = {i: pygame.Surface((1, 1)) for i in range(2)}
        self.box = pygame.Rect(0, 0, 1, 1)
        return 0, {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        if action:
            self.board = self.board ^ np.uint64(1)
        else:
            self.sprites.pop(1, None)
            self.box.x = 3
        return 0, 0.0, False, False, {}


def test_bits_keys_and_rectangles_are_part_of_a_state():
    env = Bits()
    env.reset()
    assert T(env, seed=None).states == 4
    assert env.box.x == 0


# Wrappers


class Frozen(Cells):
    """SFFG: the last cell ends the episode."""

    def __init__(self) -> None:
        super().__init__(4)

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        self.move(1 if action else -1)
        return self.at, float(self.at == 3), self.at == 3, False, {}


class RepeatTwice(gymnasium.Wrapper):
    def step(self, action: Any) -> Any:
        returned = self.env.step(action)
        return returned if returned[2] else self.env.step(action)


class Wind(gymnasium.Wrapper):
    """Every third step goes right."""

    def __init__(self, env: Any) -> None:
        super().__init__(env)
        self.count = 0

    def step(self, action: Any) -> Any:
        self.count += 1
        return self.env.step(1 if self.count % 3 == 0 else action)


class RandomNowAndThen(gymnasium.Wrapper):
    def step(self, action: Any) -> Any:
        return self.env.step(self.action_space.sample() if np.random.random() < 0.2 else action)


class Immortal(gymnasium.Wrapper):
    def step(self, action: Any) -> Any:
        shown, reward, _, *rest = self.env.step(action)
        return shown, reward, False, *rest


def lake(**options: Any) -> Any:
    return gymnasium.make("FrozenLake-v1", desc=["SFFG"], is_slippery=False, **options)


@pytest.mark.parametrize("make", [lake, Frozen])
@pytest.mark.parametrize("wrapper", [RepeatTwice, Wind, RandomNowAndThen, Immortal])
def test_wrappers_that_change_what_a_step_does_are_refused_by_name(make: Any, wrapper: Any):
    message = rf"does not follow its table: in step \d+ .* expected.* {wrapper.__name__} changes"
    with pytest.raises(ValueError, match=message) as refused:
        T(wrapper(make()))
    assert "\n" not in str(refused.value)
    with pytest.raises(ValueError, match=message):
        hb.EmpowermentReward(wrapper(make()), 2, "state", 0.1)


def test_repeat_action_is_refused_or_enumerated_through():
    repeated = gymnasium.wrappers.RepeatAction(lake(), 2)
    with pytest.raises(ValueError, match="RepeatAction changes what a step does"):
        T(repeated)

    def save(env: Any) -> int:
        return int(env.unwrapped.s)

    def load(env: Any, value: int) -> None:
        env.unwrapped.s = value

    through = T(repeated, state=(save, load))
    assert through.states == 3  # 0, 2 and the goal
    assert hb.empowerment(through, 3, states=[0])[0] == np.log2(3)
    inside = T(lake())
    assert hb.empowerment(inside, 3, states=[0])[0] == 2.0


def test_lava_that_does_not_kill_is_enumerated_through_its_wrapper():
    env = NoDeath(gymnasium.make("MiniGrid-LavaGapS5-v0"), ("lava",), -1.0)
    with pytest.raises(ValueError, match="NoDeath changes what a step does"):
        T(env)

    def save(env: Any) -> Any:
        return tuple(env.unwrapped.agent_pos), env.unwrapped.agent_dir

    def load(env: Any, value: Any) -> None:
        env.unwrapped.agent_pos, env.unwrapped.agent_dir = value

    through = T(env, state=(save, load))
    inside = T(gymnasium.make("MiniGrid-LavaGapS5-v0"))
    assert through.states > inside.states - inside.terminal.sum()
    assert through.reward.min() == -1


def test_a_table_is_pickled_without_its_environment():
    env = Enclosed()
    mdp = T(env, state=(place, put))
    other = pickle.loads(pickle.dumps(mdp))
    assert np.array_equal(other.next_state, mdp.next_state)
    assert other.origin is None


@pytest.mark.parametrize(
    "wrap",
    [
        lambda env: gymnasium.wrappers.FrameStackObservation(env, 3),
        lambda env: TimeAwareObservation(TimeLimit(env, 20)),
        lambda env: gymnasium.wrappers.NormalizeReward(env),
        lambda env: gymnasium.wrappers.TransformReward(env, lambda reward: 2 * float(reward)),
        lambda env: gymnasium.wrappers.RecordEpisodeStatistics(env),
        lambda env: TimeLimit(env, 20),
        lambda env: gymnasium.wrappers.PassiveEnvChecker(env),
        lambda env: gymnasium.wrappers.OrderEnforcing(env),
    ],
)
@pytest.mark.parametrize("make", [lake, Frozen])
def test_wrappers_that_change_observations_and_rewards_alone_are_harmless(wrap: Any, make: Any):
    assert np.array_equal(T(wrap(make())).next_state, T(make()).next_state)


class Doubled(gymnasium.Wrapper):
    """Changes the reward without declaring it."""

    def step(self, action: Any) -> Any:
        shown, reward, *rest = self.env.step(action)
        return shown, 2 * float(reward), *rest


@pytest.mark.parametrize("make", [lake, Frozen])
def test_a_wrapper_that_does_not_declare_that_it_changes_rewards_is_refused(make: Any):
    with pytest.raises(ValueError, match="reward 1 was expected, and reward 2 came"):
        T(Doubled(make()))


def test_a_table_of_an_environment_with_empowerment_in_its_reward_is_that_of_the_one_inside():
    shaped = hb.EmpowermentReward(Frozen(), 2, "state", 0.1)
    assert np.array_equal(T(shaped).next_state, T(Frozen()).next_state)


# Attributes count, whatever they are called


class Thermostat(Cells):
    def reset(self, **options: Any) -> tuple[Any, dict]:
        super().reset(**options)
        self.t = 18
        return self.t, {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        self.t = min(max(self.t + (1 if action else -1), 15), 22)
        return self.t, 0.0, False, False, {}


NAMES = [
    *("t", "clock", "screen", "mission", "timestep", "steps", "step_count", "window", "viewer"),
    *("lastaction", "num_steps", "elapsed_steps", "_elapsed_steps", "renderer", "reward_range"),
]


@pytest.mark.parametrize("name", NAMES)
def test_no_attribute_is_left_out_because_of_its_name(name: str):
    class Named(Cells):
        def reset(self, **options: Any) -> tuple[Any, dict]:
            super().reset(**options)
            setattr(self, name, 0)
            return 0, {}

        def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
            setattr(self, name, min(max(getattr(self, name) + (1 if action else -1), 0), 7))
            return getattr(self, name), 0.0, False, False, {}

    mdp = T(Named())
    assert mdp.states == 8
    assert hb.empowerment(mdp, 7, states=[0])[0] == 3


def test_a_thermostat_has_its_temperatures():
    mdp = T(Thermostat())
    assert mdp.states == 8
    assert hb.empowerment(mdp, 9, states=[0])[0] == 3


class Opens(Cells):
    """The last cells are behind a wall that opens after three steps."""

    def __init__(self) -> None:
        super().__init__(4)
        self.steps = 0

    def reset(self, **options: Any) -> tuple[Any, dict]:
        self.steps = 0
        return super().reset(**options)

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        self.steps = min(self.steps + 1, 5)
        before = self.at
        self.move(1 if action else -1)
        if self.at > 1 and self.steps <= 3:
            self.at = before
        return self.at, 0.0, False, False, {}


def test_a_wall_that_opens_with_time_is_in_the_table_or_found_out():
    mdp = T(Opens(), factors={"at": lambda env: env.at})
    assert hb.empowerment(mdp, 6, "at", states=[mdp.start])[0] > 1
    with pytest.raises(ValueError, match="its transitions depend on steps: let that be part of"):
        T(Opens(), ignore=("steps",))


class Counter:
    """An object that can be called."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self) -> int:
        self.calls = (self.calls + 1) % 3
        return self.calls


class Calling(Cells):
    def __init__(self) -> None:
        super().__init__()
        self.counter = Counter()

    def reset(self, **options: Any) -> tuple[Any, dict]:
        self.counter.calls = 0
        return super().reset(**options)

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        return (self.counter() if action else self.counter.calls), 0.0, False, False, {}


def test_an_object_that_can_be_called_has_its_attributes():
    assert T(Calling()).states == 3


def test_what_is_ignored_must_be_there():
    with pytest.raises(
        ValueError, match="ignore has 'stpes', but Opens has no such attribute; it has"
    ):
        T(Opens(), ignore=("stpes",))
    with pytest.raises(ValueError, match=re.escape("give a list of names, as ['steps']")):
        T(Opens(), ignore="steps")


# Taxis


class TaxiEnv(Cells):
    """Two rows of seven cells, a passenger and a goal that never change."""

    action_space = Discrete(6)
    observation_space = Discrete(14)

    def __init__(self) -> None:
        super().__init__(14)
        self.s = 0
        moves = [7, -7, 1, -1, 0, 0]
        self.P = {
            s: {
                a: [(1.0, s + by if 0 <= s + by < 14 else s, -1.0, False)]
                for a, by in enumerate(moves)
            }
            for s in range(14)
        }

    def decode(self, s: int) -> tuple[int, int, int, int]:
        return *divmod(s, 7), 0, 1

    def reset(self, **options: Any) -> tuple[Any, dict]:
        super().reset(**options)
        self.s = 0
        return 0, {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        _, self.s, reward, ended = self.P[self.s][action][0]
        return self.s, reward, ended, False, {}


def test_a_taxi_has_a_label_for_each_of_its_cells():
    mdp = T(TaxiEnv())
    assert len(np.unique(mdp.factor("taxi"))) == 14


# Tables called P


class WithP(Cells):
    def __init__(self, P: Any, s: bool = True) -> None:
        super().__init__(3)
        self.P = P
        if s:
            self.s = 0

    def reset(self, **options: Any) -> tuple[Any, dict]:
        shown = super().reset(**options)
        if hasattr(self, "s"):
            self.s = self.at
        return shown

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        shown = super().step(action)
        if hasattr(self, "s"):
            self.s = self.at
        return shown


def listed(cells: int = 3) -> list[list[list[tuple]]]:
    return [
        [[(1.0, max(s - 1, 0), 0.0, False)], [(1.0, min(s + 1, cells - 1), 0.0, False)]]
        for s in range(cells)
    ]


def changed(state: int, action: int, outcomes: Any) -> Any:
    P = listed()
    P[state][action] = outcomes
    return P


@pytest.mark.parametrize("P", [listed(), dict(enumerate(listed())), tuple(listed())])
@pytest.mark.parametrize("s", [True, False])
def test_a_table_may_be_lists_or_dictionaries_with_or_without_s(P: Any, s: bool):
    assert T(WithP(P, s)).next_state.tolist() == [[0, 1], [0, 2], [1, 2]]
    env = hb.EmpowermentReward(WithP(P, s), 1, beta=1.0)
    env.reset(seed=0)
    assert env.step(1)[1] == 1.0


@pytest.mark.parametrize(
    "P", [0.5, np.ones((3, 2, 3)) / 3, "policy", None, [0.1, 0.9], {}, {"a": 1}, [[1, 2], [3, 4]]]
)
def test_what_is_called_p_and_is_no_table_is_an_attribute(P: Any):
    assert T(WithP(P)).next_state.tolist() == [[0, 1], [0, 2], [1, 2]]


@pytest.mark.parametrize(
    ("P", "message"),
    [
        (changed(1, 0, [(1.0, 0, 0.0)]), "P[1][0] is [(1.0, 0, 0.0)]; give a list of (probability"),
        (changed(1, 0, 0.5), "P has no list of outcomes for state 1 and action 0"),
        (changed(1, 0, [(1.0, 7, 0.0, False)]), "P leads to state 7; use states 0 to 2"),
        (changed(1, 0, [(0.5, 0, 0.0, False)]), "state 1 sums to 0.5"),
        (changed(1, 0, [(1.0, 0.5, 0.0, False)]), "P[1][0] is [(1.0, 0.5, 0.0, False)]; give a"),
        (
            changed(1, 0, [(-1.0, 0, 0.0, False), (2.0, 0, 0.0, False)]),
            "P[1][0] has probability -1",
        ),
        (changed(1, 0, [(1.0, float("inf"), 0.0, False)]), "P[1][0] is [(1.0, inf, 0.0, False)]"),
        (dict(enumerate(listed())) | {"a": []}, "P has no list of outcomes for state 3 and action"),
        (changed(1, 1, [(1.0, 1, 0.0, False)]), "state 1 was expected, and state 2 came"),
        (changed(1, 1, [(1.0, 2, 5.0, False)]), "reward 5 was expected, and reward 0 came"),
        (changed(1, 1, [(1.0, 2, 0.0, True)]), "terminated=True was expected"),
    ],
)
def test_a_table_that_is_damaged_or_is_not_the_environments_is_refused(P: Any, message: str):
    with pytest.raises(ValueError, match=re.escape(message)) as refused:
        T(WithP(P))
    assert "\n" not in str(refused.value)


def test_an_empty_list_of_a_table_is_an_action_that_is_not_available():
    P = changed(1, 0, [])
    P[2] = [[], []]
    mdp = T(WithP(P))
    assert mdp.next_state.tolist() == [[0, 1], [-1, 2], [-1, -1]]
    assert hb.empowerment(mdp, 2, states=[0])[0] == np.log2(3)  # to 0, 1 or 2
    env = hb.EmpowermentReward(WithP(P), 1, beta=1.0)
    env.reset(seed=0)
    assert [env.step(1)[1] for _ in range(2)] == [0.0, 0.0]


def test_an_outcome_that_the_table_does_not_list_is_found_where_it_is_random():
    P = gymnasium.make("FrozenLake-v1").unwrapped.P  # type: ignore[attr-defined]

    class Slides(gymnasium.Wrapper):
        def step(self, action: Any) -> Any:
            returned = self.env.step(action)
            inner: Any = self.unwrapped
            if inner.s == 1:
                inner.s = 3
            return returned

    assert P
    with pytest.raises(ValueError, match=r"one of states .* expected, and state 3 came"):
        T(Slides(gymnasium.make("FrozenLake-v1")))


class Elsewhere(WithP):
    """Begins in the last state."""

    def reset(self, **options: Any) -> tuple[Any, dict]:
        super().reset(**options)
        self.at = self.s = 2
        return 2, {}


class Seeds(WithP):
    def reset(self, **options: Any) -> tuple[Any, dict]:
        np.random.seed(0)
        return super().reset(**options)


def test_a_table_starts_where_a_reset_does_and_leaves_numpys_generator_alone():
    assert T(Elsewhere(listed())).start == 2
    np.random.seed(5)
    expected = np.random.random()
    np.random.seed(5)
    T(Seeds(listed()))
    assert np.random.random() == expected


def test_videos_of_the_user_are_not_written_over(tmp_path: Any):
    env = gymnasium.make("FrozenLake-v1", render_mode="rgb_array")
    T(gymnasium.wrappers.RecordVideo(env, str(tmp_path / "videos"), lambda episode: True))
    assert not list((tmp_path / "videos").glob("*"))


# What an environment need not have


class Duck:
    """Built like an environment, without being one."""

    action_space = Discrete(2)

    def __init__(self) -> None:
        self.at = 0

    def reset(self, seed: int | None = None) -> tuple[int, dict]:
        self.at = 0
        return 0, {}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict]:
        self.at = min(max(self.at + (1 if action else -1), 0), 4)
        return self.at, 0.0, False, False, {}


def test_what_is_built_like_an_environment_is_one():
    assert T(Duck()).states == 5


def test_a_minigrid_that_was_never_reset_is_refused():
    with pytest.raises(ValueError, match="reset the environment before") as refused:
        T(gymnasium.make("MiniGrid-Empty-5x5-v0"), seed=None)
    assert "\n" not in str(refused.value)


class Raises(Cells):
    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        if action and self.at == 2:
            raise RuntimeError("no more steps\nof any kind")
        return super().step(action)


class Old(Cells):
    def step(self, action: int) -> Any:
        return super().step(action)[:4]


class NoNumber(Cells):
    def step(self, action: int) -> Any:
        return self.at, "much", False, False, {}


class NoReset(Cells):
    def reset(self, **options: Any) -> tuple[Any, dict]:
        raise RuntimeError("no seed")


@pytest.mark.parametrize(
    ("env", "message"),
    [
        (Raises(), "action 1 in state 2 raises RuntimeError: no more steps; "),
        (Old(), "step(action) returns (0, 0.0, False, False); Gymnasium's is (observation,"),
        (NoNumber(), "action 0 in state 0 has reward 'much'"),
        (NoReset(), "NoReset cannot be reset with seed 0 (no seed)"),
    ],
)
def test_whatever_an_environment_raises_is_one_line(env: Any, message: str):
    with pytest.raises(ValueError, match=re.escape(message)) as refused:
        T(env)
    assert "\n" not in str(refused.value)


# Ends


class Announces(Cells):
    """Action 1 ends the episode and changes nothing, as in GoToDoor."""

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        if action:
            return self.at, float(self.at == 2), True, False, {}
        self.at = (self.at + 1) % 3
        return self.at, 0.0, False, False, {}


def test_an_ended_episode_is_a_state_of_its_own():
    mdp = T(Announces(), factors={"at": lambda env: env.at})
    assert mdp.states == 6
    assert mdp.terminal.sum() == 3
    ended = np.flatnonzero(mdp.terminal)
    assert (mdp.next_state[ended] == ended[:, None]).all()
    assert (mdp.reward[ended] == 0).all()
    assert sorted(mdp.factor("at")[ended]) == [0, 1, 2]
    env = hb.EmpowermentReward(Announces(), 1, "state", beta=1.0)
    for _ in range(2):
        env.reset(seed=0)
        assert env.step(0)[1] == 1.0
        _, reward, terminated, _, info = env.step(1)
        assert (reward, terminated, info["empowerment"]) == (0.0, True, 0.0)


def test_ends_of_a_table_p_are_states_of_their_own_where_they_are_not_always_ends():
    P = listed()
    P[1][1] = [(1.0, 2, 1.0, True)]  # entered from the left state 2 is an end; it also goes on
    P[0][1] = [(1.0, 2, 0.0, False)]

    class Ends(WithP):
        def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
            _, self.s, reward, ended = self.P[self.s][action][0]
            return self.s, reward, ended, False, {}

    mdp = T(Ends(P))
    assert mdp.states == 4
    assert mdp.terminal.tolist() == [False, False, False, True]
    assert mdp.next_state.tolist() == [[0, 2], [0, 3], [1, 2], [3, 3]]


@pytest.mark.parametrize("name", ["MiniGrid-GoToDoor-5x5-v0", "MiniGrid-PutNear-6x6-N2-v0"])
def test_what_ends_without_a_change_is_enumerated(name: str):
    mdp = T(gymnasium.make(name))
    assert mdp.terminal.any()
    assert mdp.origin is not None
    assert mdp.origin.verified > 0


def test_blackjack_is_refused_as_random():
    with pytest.raises(ValueError, match="more than one outcome"):
        T(gymnasium.make("Blackjack-v1"))


# Observations


class ShownTime(Cells):
    """The observation depends on an ignored counter."""

    observation_space = Box(0, 1000, (2,))

    def __init__(self) -> None:
        super().__init__()
        self.steps = 0

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict]:
        self.steps += 1
        super().step(action)
        return np.array([self.at, self.steps]), 0.0, False, False, {}


def test_an_observation_that_the_state_does_not_give_is_found_out():
    with pytest.raises(ValueError, match="the observation of the first time was expected"):
        T(ShownTime(), ignore=("steps",))
