"""Stable-Baselines3's A2C beside ours, on one processor; in an environment that has torch.

`make bench-sb3` makes that environment and measures.
"""

from typing import Any

import numpy as np

from habilis.benchmarks import Result
from habilis.benchmarks.apart import alternating, measured_apart
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
    return measured_apart(__name__, "on_one_processor")


def on_one_processor() -> list[Result]:
    """Steps a second of both, learning included, with the same network, batch and optimiser."""
    import torch  # pyright: ignore[reportMissingImports]
    from stable_baselines3 import A2C  # pyright: ignore[reportMissingImports]
    from stable_baselines3.common.env_util import (  # pyright: ignore[reportMissingImports]
        make_vec_env,
    )

    from habilis.benchmarks import learning
    from habilis.envs.table import TableEnv

    torch.set_num_threads(1)
    settings = learning.A2C
    mdp = tabulate(load_world("corridor"))
    envs: Any = make_vec_env(lambda: TableEnv(mdp), n_envs=settings.envs)
    agent = A2C(
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
    loop = learning.Loop.of(learning.CONFIG)
    seconds = alternating({"ours": loop.train, "sb3": lambda: agent.learn(STEPS)}, rounds=3)
    ours, theirs = learning.STEPS / seconds["ours"], STEPS / seconds["sb3"]
    env = TableEnv(mdp)
    env.reset()
    actions = np.random.default_rng(0).integers(8, size=10_000).tolist()

    def wander() -> None:
        for action in actions:
            if any(env.step(action)[2:4]):
                env.reset()

    alone = len(actions) / alternating({"environment": wander})["environment"]
    note = f"{settings.envs} environments, corridor, MLP 64-64, one processor"
    return [
        Result("Stable-Baselines3 A2C", theirs, "steps/s", note),
        Result("ours", ours, "steps/s", "the same, ten runs side by side"),
        Result("ours / Stable-Baselines3 A2C", ours / theirs, "x", "steps/s, learning included"),
        Result("its environment alone", alone, "steps/s", "so the environment is not what is slow"),
    ]
