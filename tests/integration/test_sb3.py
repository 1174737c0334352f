"""Stable-Baselines3's agents on our environments."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from stable_baselines3 import A2C, PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy

import habilis as hb

torch.set_num_threads(1)

SMALL = "AP.CG\n.....\n"
BONUS: dict[str, Any] = {"horizon": 3, "sensor": "state", "beta": 0.09}
CORRIDOR: dict[str, Any] = {"id": "habilis/Corridor-v0", "observation": "onehot"}
CUT = 20  # steps of an episode, so that some end


def shaped(**arguments):
    """Makes environments whose bonus is inside of what Stable-Baselines3 puts around them."""
    return lambda: hb.EmpowermentReward(gymnasium.make(**CORRIDOR, **arguments), **BONUS)


class Watch(BaseCallback):
    """All rewards and infos of the steps, and the losses of the last update."""

    def __init__(self):
        super().__init__()
        self.rewards, self.infos, self.losses = [], [], []

    def _on_step(self) -> bool:
        self.rewards.append(self.locals["rewards"].copy())
        self.infos.append([dict(info) for info in self.locals["infos"]])
        return True

    def _on_rollout_start(self) -> None:
        said = self.model.logger.name_to_value
        self.losses.append({name: said[name] for name in list(said) if name.endswith("loss")})


@pytest.mark.parametrize("kind", ["factors", "onehot", "grid", "rgb"])
@pytest.mark.parametrize("name", ["habilis/Corridor-v0", "habilis/Yard-v0"])
def test_its_own_check_has_nothing_to_say(name, kind):
    plain = gymnasium.make(name, observation=kind)
    if kind == "grid":  # of three axes it takes pictures alone
        plain = gymnasium.wrappers.FlattenObservation(plain)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(plain)
        check_env(hb.EmpowermentReward(plain, **BONUS))


@pytest.mark.parametrize(("algorithm", "steps"), [(A2C, 2_000), (PPO, 2_048)])
def test_it_trains_on_the_corridor_with_the_bonus(algorithm, steps):
    envs = make_vec_env(shaped(max_steps=CUT), n_envs=4, seed=0)
    settings = {"n_steps": 64, "batch_size": 64} if algorithm is PPO else {}
    model = algorithm("MlpPolicy", envs, seed=0, device="cpu", **settings)
    before = [p.detach().clone() for p in model.policy.parameters()]
    watch = Watch()
    model.learn(steps, callback=watch, log_interval=10**9)
    losses = [loss for loss in watch.losses if loss]
    assert len(losses) >= 7
    assert all(np.isfinite(value) for loss in losses for value in loss.values())
    assert {"train/value_loss"} < losses[-1].keys()
    after = model.policy.parameters()
    assert any(not torch.equal(b, a) for b, a in zip(before, after, strict=True))

    # It learned from the shaped reward, and info has the world's own beside it.
    rewards = np.array(watch.rewards)
    infos = np.array(watch.infos)
    extrinsic = np.vectorize(lambda info: info["extrinsic_reward"])(infos)
    bits = np.vectorize(lambda info: info["empowerment"])(infos)
    assert np.allclose(rewards, extrinsic + 0.09 * bits, atol=1e-5)
    assert set(np.unique(extrinsic)) <= {-1, 0}
    assert bits.max() > 0


def test_its_monitor_counts_what_is_inside_of_it():
    def episodes(envs):
        model = A2C("MlpPolicy", envs, seed=0, device="cpu")
        watch = Watch()
        model.learn(4 * CUT, callback=watch)
        (infos,) = zip(*watch.infos, strict=True)
        rewards = np.array(watch.rewards)[:, 0].reshape(-1, CUT).sum(axis=1)
        return rewards, [info["episode"]["r"] for info in infos if "episode" in info]

    outside = make_vec_env(shaped(max_steps=CUT), n_envs=1, seed=0)
    rewards, counted = episodes(outside)
    assert np.allclose(rewards, counted, atol=1e-4)
    assert (rewards > -CUT).all()

    inside = make_vec_env(
        CORRIDOR["id"],
        n_envs=1,
        seed=0,
        env_kwargs={"observation": "onehot", "max_steps": CUT},
        wrapper_class=hb.EmpowermentReward,  # pyright: ignore[reportArgumentType]
        wrapper_kwargs=BONUS,
    )
    rewards, counted = episodes(inside)
    assert counted == [-CUT] * 4
    assert (rewards > -CUT).all()


def test_an_episode_that_is_cut_off_is_no_end():
    envs = make_vec_env(shaped(max_steps=CUT), n_envs=1, seed=0)
    watch = Watch()
    PPO("MlpPolicy", envs, seed=0, device="cpu", n_steps=CUT, batch_size=CUT).learn(
        CUT, callback=watch
    )
    (last,) = watch.infos[-1]
    assert last["TimeLimit.truncated"]
    assert last["terminal_observation"].shape == envs.observation_space.shape


@pytest.mark.parametrize(
    ("algorithm", "settings"),
    [
        (A2C, {"n_steps": 16, "learning_rate": 3e-3, "ent_coef": 0.01}),
        (PPO, {"n_steps": 64, "batch_size": 128, "learning_rate": 3e-3, "ent_coef": 0.01}),
    ],
)
def test_it_beats_random_play_on_a_small_world(algorithm, settings):
    def make():
        env = gymnasium.make("habilis/World-v0", world=SMALL, observation="onehot", max_steps=60)
        return hb.EmpowermentReward(env, horizon=2, sensor="object", beta=0.1)

    def score(policy):
        plain = gymnasium.make("habilis/World-v0", world=SMALL, observation="onehot", max_steps=60)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Evaluation environment is not wrapped")
            return evaluate_policy(policy, plain, n_eval_episodes=20, deterministic=False)[0]

    envs = make_vec_env(make, n_envs=8, seed=0)
    model = algorithm("MlpPolicy", envs, seed=0, device="cpu", gamma=0.95, **settings)
    untrained = score(model)
    model.learn(20_000)
    plan = hb.solve(hb.tabulate(hb.World.parse(SMALL)))
    assert plan is not None
    assert untrained < 5 * plan.best_return
    assert score(model) > 2 * plan.best_return
