import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import QUICK_A2C, learn, row

from habilis.learning import intrinsic
from habilis.learning.algorithms.q_learning import QLearning
from habilis.learning.config import Config
from habilis.learning.dynamics import make_dynamics
from habilis.mdp import TabularMDP

BONUS = Config(algorithm=QUICK_A2C, intrinsic="state", horizon=1, beta=1.0, seed=3)
# To the left or to the right, both then to the end.
FORK = TabularMDP.deterministic([[1, 2], [3, 3], [3, 3], [3, 3]], terminal=[0, 0, 0, 1])
RIGHT = [0.0, 0.0, 1.0, 0.0]


def reward(config, global_step=0.0, extrinsic=2.0, following=3.0, current=5.0, terminated=False):
    """The reward to learn from, by the settings of a configuration."""
    hyperparams = {name: jnp.float32(value) for name, value in intrinsic.weights(config).items()}
    hyperparams["reward_scale"] = jnp.float32(config.algorithm.reward_scale)
    given = extrinsic, following, current, terminated, float(global_step)
    return float(intrinsic.reward(hyperparams, *map(jnp.array, given)))


def test_the_reward_is_that_of_the_paper():
    assert reward(BONUS.changed(beta=0.5)) == 2 + 0.5 * 3
    assert reward(BONUS.changed(beta=0.5, reward_scale=0.1)) == pytest.approx(0.35)


def test_the_bonus_may_be_that_of_the_current_state_or_a_potential():
    assert reward(BONUS.changed(earned="current")) == 2 + 5
    assert reward(BONUS.changed(earned="difference", discount=0.5)) == 2 + 0.5 * 3 - 5


def test_a_terminal_state_earns_if_asked_to_and_never_in_a_potential():
    assert reward(BONUS, terminated=True) == 2 + 3
    assert reward(BONUS.changed(terminal_bonus=False), terminated=True) == 2
    assert reward(BONUS.changed(earned="difference", discount=0.5), terminated=True) == 2 - 5


def test_the_extrinsic_reward_can_be_turned_off():
    assert reward(BONUS.changed(extrinsic=False)) == 3


def test_beta_falls_linearly_to_nothing_or_halves_again_and_again():
    linear = BONUS.changed(beta_schedule="linear", beta_steps=1000)
    assert [reward(linear, global_step=t) for t in (0, 500, 1000, 9999)] == [5, 3.5, 2, 2]
    halving = BONUS.changed(beta_schedule="exponential", beta_steps=1000)
    assert [reward(halving, global_step=t) for t in (0, 1000, 2000)] == [5, 3.5, 2.75]


def test_an_agent_goes_where_the_bonus_is():
    assert learn(FORK, BONUS, table=RIGHT).policy[0, 1] > 0.9
    gone = BONUS.changed(beta_schedule="linear", beta_steps=1)
    assert learn(FORK, gone, table=RIGHT).policy[0, 1] == pytest.approx(0.5, abs=0.35)


def test_a_potential_changes_values_and_not_what_is_best():
    """Shaped Q is Q - Phi(s), whatever Phi is (Ng, Harada and Russell 1999)."""
    mdp = TabularMDP.deterministic(
        [[0, 1], [1, 2], [2, 2]], [[-1.0, -2.0], [-1.0, 5.0], [0, 0]], [False, False, True]
    )
    q = QLearning(epsilon=0.5, epsilon_steps=0, discount=0.8)
    plain = learn(mdp, Config(algorithm=q), updates=2000).values
    potential = np.array([3.0, -7.0, 11.0])
    shaped = Config(algorithm=q, intrinsic="state", horizon=1, beta=1.0, earned="difference")
    values = learn(mdp, shaped, updates=2000, table=potential).values
    np.testing.assert_allclose(values[:2], plain[:2] - potential[:2, None], atol=1e-2)


def test_counts_are_visits_and_novelty_wears_off():
    config = Config(algorithm=QUICK_A2C, intrinsic="count", beta=1.0)
    found = learn(row(3, 2, np.zeros((3, 2))), config, updates=50)
    counts = found.lane.novelty
    assert counts.sum() == 50 * 8 * 4
    assert counts[0] == 0  # nobody enters the start: it is where a new episode begins
    np.testing.assert_allclose(counts[1] / counts.sum(), 0.5, atol=0.01)
    dynamics, _ = make_dynamics(row(3, 2, np.zeros((3, 2))))
    np.testing.assert_allclose(
        intrinsic.values("count", jnp.asarray(counts), jnp.zeros(3), dynamics, jnp.array([0, 1])),
        1 / np.sqrt(counts[:2] + 1),
        rtol=1e-5,
    )


def test_what_is_seen_often_is_distilled_and_what_is_not_stays_new():
    config = Config(algorithm=QUICK_A2C, intrinsic="rnd", beta=1.0)
    # Action 0 stays in the seen half: the far state is never entered.
    mdp = TabularMDP.deterministic([[1], [0], [2]])
    found = learn(mdp, config, updates=3000)
    dynamics, _ = make_dynamics(mdp)
    novelty = intrinsic.values("rnd", found.lane.novelty, jnp.zeros(3), dynamics, jnp.arange(3))
    assert novelty[0] < 0.1 * novelty[2]
    assert novelty[1] < 0.1 * novelty[2]


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"earned": "later"}, "use one of next, current, difference"),
        ({"beta_schedule": "cosine"}, "use one of constant, linear, exponential"),
        ({"beta_schedule": "linear"}, "beta_steps is 0; give a number above 0"),
        ({"beta_steps": -1}, "give at least 0"),
        ({"extrinsic": 1}, "give true or false"),
        ({"algorithm": "dqn"}, "algorithm 'dqn' is unknown; use one of a2c, ppo"),
        ({"algorithm": "q-learning", "clip": 1.0}, "clip is a setting of a2c and ppo, not of"),
        ({"clop": 1.0}, "setting 'clop' is unknown"),
    ],
)
def test_bad_settings_are_refused(change, says):
    with pytest.raises(ValueError, match=says):
        BONUS.changed(**change)


def test_the_scale_of_distances_is_their_running_mean_square():
    dynamics, rows = make_dynamics(row(3, 2, np.zeros((3, 2))))
    kept = intrinsic.init("rnd", dynamics, rows, jax.random.key(0))
    entered = jnp.array([[0, 1, 1]])
    distance = jnp.square(
        kept.predictor(dynamics.inputs[entered]) - kept.target(dynamics.inputs[entered])
    ).mean(axis=-1)
    after = intrinsic.visited("rnd", kept, dynamics, entered)
    expected = 0.999 * 1 + 0.001 * float(jnp.square(distance).mean())
    assert float(after.scale) == pytest.approx(expected, rel=1e-5)
    reported = intrinsic.values("rnd", kept, jnp.zeros(3), dynamics, entered)
    np.testing.assert_allclose(reported, distance, rtol=1e-4)
