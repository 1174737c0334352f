"""Estimated empowerment in the reward of environments without a table."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import habilis as hb
from habilis.envs import EstimatedReward
from habilis.estimators.simulators import gymnasium_simulator, linear_system

METHOD = hb.Gaussian(power=1.0, noise=0.01)


class Cart(gymnasium.Env):
    """A cart that is pushed: position and velocity, as in `SYSTEM`."""

    observation_space = gymnasium.spaces.Box(-100.0, 100.0, (2,), np.float64)
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float64)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.state = np.zeros(2)
        return self.state.copy(), {}

    def step(self, action):
        self.state = DYNAMICS @ self.state + FORCE @ np.asarray(action)
        return self.state.copy(), 1.0, False, False, {}


DYNAMICS, FORCE = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[0.0], [0.1]])
SYSTEM = linear_system(DYNAMICS, FORCE)


def cart(**settings):
    arguments = {"simulator": SYSTEM, "state": lambda env: env.state, **settings}
    return hb.EmpowermentReward(Cart(), 2, "state", beta=0.5, method=METHOD, **arguments)


def test_the_reward_has_the_estimate_of_the_state_that_was_reached():
    env = gymnasium.make("InvertedPendulum-v5")
    inside: Any = env.unwrapped
    env = hb.EmpowermentReward(env, 3, "hinge", beta=0.5, method=METHOD, seed=1)
    assert isinstance(env, EstimatedReward)
    fitted = METHOD.fit(gymnasium_simulator("InvertedPendulum-v5"), 3, "hinge", seed=1)
    env.reset(seed=0)
    for _ in range(3):
        _, reward, _, _, info = env.step(env.action_space.sample())
        state = np.concatenate([inside.data.qpos, inside.data.qvel])
        assert info["empowerment"] == pytest.approx(fitted.bits(state[None])[0])
        assert reward == pytest.approx(info["extrinsic_reward"] + 0.5 * info["empowerment"])


def test_any_environment_may_bring_its_simulator():
    env = cart()
    _, info = env.reset(seed=0)
    expected = hb.empowerment(SYSTEM, 2, states=np.zeros((1, 2)), method=METHOD)[0]
    assert info["empowerment"] == pytest.approx(expected)


@pytest.mark.filterwarnings("ignore:.*different from the unwrapped version")
def test_it_is_an_environment_as_gymnasium_has_them():
    check_env(cart(), skip_render_check=True)


def test_a_potential_and_a_bonus_alone_are_those_of_tables():
    earned = cart(earned="difference", extrinsic=False, discount=0.9)
    _, before = earned.reset(seed=0)
    _, reward, _, _, after = earned.step(np.array([1.0]))
    expected = 0.5 * (0.9 * after["empowerment"] - before["empowerment"])
    assert reward == pytest.approx(expected)


def test_a_step_before_a_reset_is_refused():
    with pytest.raises(gymnasium.error.ResetNeeded):
        cart().step(np.array([0.0]))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"simulator": None}, "state is given without simulator; give both, or neither"),
        ({"simulator": None, "state": None}, "Cart is no MuJoCo environment; give simulator="),
        ({"actions": [0]}, "actions is for tables, and the method is an estimator; leave it out"),
        ({"earned": "never"}, "earned 'never' is unknown"),
    ],
)
def test_what_an_estimator_has_no_use_for_is_refused(settings, message):
    with pytest.raises(ValueError, match=message):
        cart(**settings)


def test_the_state_is_one_vector():
    env = cart(state=lambda env: env.state[None])
    with pytest.raises(ValueError, match=r"state returns shape \(1, 2\); let it return one vector"):
        env.reset(seed=0)


def test_vector_environments_are_wrapped_one_by_one():
    envs = gymnasium.make_vec("InvertedPendulum-v5", num_envs=2, vectorization_mode="sync")
    with pytest.raises(ValueError, match="wrap each in EmpowermentReward before it is vectorised"):
        hb.EmpowermentReward(envs, 3, "hinge", beta=0.5, method=METHOD)
    envs.close()
