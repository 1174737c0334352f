"""Stable-Baselines3's A2C beside ours; in an environment that has torch.

`make bench-sb3` makes that environment and measures.
"""

from typing import Any

import numpy as np

from habilis.benchmarks import Result, time_of, times
from habilis.benchmarks.apart import measured_apart
from habilis.extras import MissingExtraError
from habilis.worlds.table import tabulate
from habilis.worlds.world import load_world

STEPS = 8_000


def results() -> list[Result]:
    try:
        import stable_baselines3  # noqa: F401  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise MissingExtraError(
            "stable_baselines3 is not installed here; run: make bench-sb3"
        ) from None
    from habilis.benchmarks.learning import steps_a_second

    agent = _agent()
    theirs = STEPS / time_of(lambda: agent.learn(STEPS))
    ours = np.array([steps_a_second() for _ in theirs])
    return [
        *measured_apart(__name__, "on_one_processor"),
        Result.of(
            "Stable-Baselines3 A2C, all processors", theirs, "steps/s", "torch's own threads"
        ),
        Result.of("ours, all processors", ours, "steps/s", "all of train()"),
        Result.of("ours / Stable-Baselines3 A2C, all processors", ours / theirs, "x", ""),
    ]


def on_one_processor() -> list[Result]:
    """Steps a second of both, learning included."""
    from habilis.benchmarks.learning import CONFIG, ON, Loop
    from habilis.benchmarks.learning import STEPS as OURS
    from habilis.envs.table import TableEnv

    agent, loop = _agent(), Loop.of(CONFIG)
    env = TableEnv(tabulate(load_world("corridor")))
    env.reset()
    actions = np.random.default_rng(0).integers(8, size=10_000).tolist()

    def wander() -> None:
        for action in actions:
            if any(env.step(action)[2:4]):
                env.reset()

    calls = {"ours": loop.train, "sb3": lambda: agent.learn(STEPS), "environment": wander}
    seconds = times(calls)
    ours, theirs = OURS / seconds["ours"], STEPS / seconds["sb3"]
    alone = len(actions) / seconds["environment"]
    return [
        Result.of(
            "Stable-Baselines3 A2C, one processor",
            theirs,
            "steps/s",
            "policy and value apart, as it has them",
        ),
        Result.of("ours, one processor", ours, "steps/s", ON),
        Result.of("ours / Stable-Baselines3 A2C, one processor", ours / theirs, "x", ""),
        Result.of(
            "the environment that it steps, alone", alone, "steps/s", "not what takes its time"
        ),
    ]


def _agent() -> Any:
    """Their A2C with our settings, on our environment."""
    from stable_baselines3 import A2C  # pyright: ignore[reportMissingImports]
    from stable_baselines3.common.env_util import (  # pyright: ignore[reportMissingImports]
        make_vec_env,
    )

    from habilis.benchmarks import learning
    from habilis.envs.table import TableEnv

    settings = learning.A2C
    mdp = tabulate(load_world("corridor"))
    envs: Any = make_vec_env(lambda: TableEnv(mdp), n_envs=settings.envs)
    return A2C(
        "MlpPolicy",
        envs,
        learning_rate=settings.learning_rate,
        n_steps=settings.rollout,
        gamma=settings.discount,
        ent_coef=settings.entropy,
        use_rms_prop=False,  # but Adam, as ours
        policy_kwargs={"net_arch": list(settings.hidden)},
        device="cpu",
        seed=0,
    )
