"""Our Gymnasium environments beside Gymnasium's own, on one processor."""

from collections.abc import Callable

import gymnasium
import numpy as np

from habilis.benchmarks import Result, times
from habilis.benchmarks.apart import measured_apart
from habilis.envs import EmpowermentReward, WorldEnv, WorldVectorEnv

MANY = 1_024
_STEPS = 20_000  # of an environment alone
_ROUNDS = 400  # of all of them together
_LOOPED = 20  # of a loop over environments


def results() -> list[Result]:
    return measured_apart(__name__, "on_one_processor")


def on_one_processor() -> list[Result]:
    """Steps per second, with random actions and automatic resets."""
    random = np.random.default_rng(0)
    lake = gymnasium.make("FrozenLake-v1")
    bonus = {"horizon": 6, "sensor": "object", "beta": 0.07}
    together = {"num_envs": MANY, "vectorization_mode": "sync"}
    calls = {
        "ours": _alone(WorldEnv("corridor"), random),
        "lake": _alone(lake.unwrapped, random),
        "wrapped": _alone(EmpowermentReward(WorldEnv("corridor"), **bonus), random),
        "next": _together(WorldVectorEnv(MANY, "corridor"), _ROUNDS, random),
        "same": _together(
            WorldVectorEnv(MANY, "corridor", autoreset_mode="SameStep"), _ROUNDS, random
        ),
        "bonus": _together(
            EmpowermentReward(WorldVectorEnv(MANY, "corridor"), **bonus), _ROUNDS, random
        ),
        "loop": _together(gymnasium.make_vec("FrozenLake-v1", **together), _LOOPED, random),
    }
    seconds = times(calls)
    many = {"next": _ROUNDS, "same": _ROUNDS, "bonus": _ROUNDS, "loop": _LOOPED}
    rate = {name: (many[name] * MANY if name in many else _STEPS) / seconds[name] for name in calls}
    alone, frozen = "one environment, unwrapped", "Gymnasium's FrozenLake, unwrapped"
    rows = [
        (alone, rate["ours"], "steps/s", "factors, info and all"),
        (frozen, rate["lake"], "steps/s", ""),
        ("ours / FrozenLake", rate["ours"] / rate["lake"], "x", ""),
        ("one environment with EmpowermentReward", rate["wrapped"], "steps/s", ""),
        (f"{MANY:,} environments, next-step reset", rate["next"], "steps/s", ""),
        (f"{MANY:,} environments, same-step reset", rate["same"], "steps/s", ""),
        (f"{MANY:,} environments with EmpowermentReward", rate["bonus"], "steps/s", ""),
        (f"{MANY:,} FrozenLakes in a SyncVectorEnv", rate["loop"], "steps/s", ""),
        ("ours / SyncVectorEnv", rate["next"] / rate["loop"], "x", "next-step reset"),
    ]
    return [Result.of(*row) for row in rows]


def _alone(env: gymnasium.Env, random: np.random.Generator) -> Callable[[], None]:
    actions = random.integers(env.action_space.n, size=_STEPS)  # pyright: ignore
    env.reset(seed=0)

    def step() -> None:
        for action in actions:
            if any(env.step(action)[2:4]):
                env.reset()

    return step


def _together(
    envs: gymnasium.vector.VectorEnv, rounds: int, random: np.random.Generator
) -> Callable[[], None]:
    actions = random.integers(envs.single_action_space.n, size=(rounds, MANY))  # pyright: ignore
    envs.reset(seed=0)

    def step() -> None:
        for chosen in actions:
            envs.step(chosen)

    return step
