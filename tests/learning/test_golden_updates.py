"""Advantages, loss and steps of the compiled loop against the float64 reference."""

from typing import Any

import numpy as np
import pytest
from reference_actor_critic import Settings, advantages_and_targets
from reference_networks import Parameters
from updates import (
    advantages_of,
    chain,
    parameters_of,
    reference_settings,
    reference_updates,
    rollouts_of,
    updates,
)

from habilis.learning.algorithms.a2c import A2C
from habilis.learning.algorithms.ppo import PPO
from habilis.learning.config import Config
from habilis.learning.presets import preset

SMALL: dict[str, Any] = {
    "envs": 4,
    "rollout": 6,
    "hidden": (7, 5),
    "episode_limit": 7,
    "reward_scale": 0.5,
    "entropy": 0.1,
    "clip": 0.0,
    "learning_rate": 5e-3,
}
EPISODES: dict[str, Any] = SMALL | {"rollout": 0, "episode_limit": 9, "normalise": True}
SCHEDULES: dict[str, Any] = {
    "entropy": 0.3,
    "entropy_end": 0.05,
    "learning_rate_end": 1e-3,
    "learning_rate_decay": 0.8,
}
BY_STEPS = SCHEDULES | {
    "entropy_steps": 30,
    "entropy_hold": 10,
    "learning_rate_steps": 60,
    "learning_rate_every": 9,
}
BY_EPISODES = SCHEDULES | {
    "schedule": "episodes",
    "entropy_steps": 6,
    "entropy_hold": 1,
    "learning_rate_steps": 8,
    "learning_rate_every": 2,
}


def a2c(common=SMALL, **changes) -> Config:
    return Config.from_dict({"algorithm": "a2c", "entropy_hold": 0} | common | changes)


def ppo(**changes) -> Config:
    few = {"epochs": 2, "minibatches": 3}
    return Config.from_dict({"algorithm": "ppo"} | SMALL | few | changes)


CASES: dict[str, tuple[Config, int]] = {
    # A configuration, and the states of the chain, so that some episodes end and some are cut off.
    "a2c": (Config(algorithm=A2C(), episode_limit=5), 4),
    "ppo": (Config(algorithm=PPO(), episode_limit=32), 5),
    "book-cartpole": (preset("book-cartpole", episode_limit=32), 5),
    "book-lander-gae": (preset("book-lander-gae", episode_limit=128), 6),
    "book-lander-nstep": (preset("book-lander-nstep", episode_limit=5, seed=2), 3),
    "book-gridworld": (preset("book-gridworld", episode_limit=9, seed=1), 4),
    "biased": (a2c(normalise=True, clip=0.05, activation="selu", initialisation="orthogonal"), 4),
    "unbiased": (a2c(normalise=True, unbiased=True, activation="sigmoid", **BY_STEPS), 4),
    "separate clips": (a2c(networks="separate", clip=0.05, activation="relu"), 4),
    "rmsprop": (a2c(optimizer="rmsprop", gae_lambda=0.7, value=2.0, **BY_EPISODES), 4),
    "rmsprop-torch": (a2c(optimizer="rmsprop-torch", limit_is_terminal=True, discount=0.9), 4),
    "coordinates": (a2c(observation="coordinates", networks="separate", seed=1), 4),
    "episodes": (a2c(EPISODES, unbiased=True, clip=0.5), 4),
    "episodes, biased": (a2c(EPISODES, networks="separate", **BY_EPISODES), 4),
    "episodes, coordinates": (a2c(EPISODES, observation="coordinates", **BY_STEPS), 4),
    "ppo, separate": (ppo(networks="separate", clip=0.05, normalise=True, unbiased=True), 4),
    "ppo, coordinates": (ppo(observation="coordinates", normalise=True, **BY_EPISODES, seed=1), 4),
}
SOME_ACTIONS = ("ppo", "book-cartpole", "episodes")  # where not all are available


@pytest.mark.parametrize("name", CASES)
def test_two_updates_are_those_of_the_reference(name):
    config, states = CASES[name]
    mdp = chain(states, available=name not in SOME_ACTIONS)
    made = updates(mdp, config)
    rollouts = rollouts_of(mdp, config, made)
    assert sum(one.terminated.sum() for one in rollouts) > 0
    assert sum(one.truncated.sum() for one in rollouts) > 0
    expected = reference_updates(config, made, rollouts)
    settings = Settings(**reference_settings(config))
    before = parameters_of(made[0].before.train_state.parameters)
    for update, rollout, steps in zip(made, rollouts, expected, strict=True):
        ours = advantages_of(mdp, config, update, rollout)
        for found, wanted in zip(
            ours, advantages_and_targets(before, rollout, settings), strict=True
        ):
            counts = rollout.mask
            scale = np.abs(wanted[counts]).max()
            np.testing.assert_allclose(found[counts], wanted[counts], rtol=0, atol=1e-4 * scale)
        loss = np.mean([step.loss.total for step in steps])
        parts = np.mean([abs(s.loss.policy) + settings.value * s.loss.value for s in steps])
        assert abs(update.log.loss[0] - loss) < 2e-5 * parts
        after = steps[-1].parameters
        check_changes(update, before, after)
        before = after


def check_changes(update, before: Parameters, after: Parameters) -> None:
    """The change of each array in an update, compared with the reference's."""
    ours = [
        parameters_of(lane.train_state.parameters).arrays()
        for lane in (update.before, update.after)
    ]
    for found_before, found, old, new in zip(*ours, before.arrays(), after.arrays(), strict=True):
        found_change, change = found - found_before, new - old
        size = np.linalg.norm(change)
        assert np.linalg.norm(found_change - change) < 2e-4 * size
