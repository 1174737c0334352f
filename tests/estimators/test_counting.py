"""Counting what is within reach, against exact counts and by hand."""

from itertools import product

import numpy as np
import pytest

import habilis as hb
from habilis.estimators import simulators


def test_counts_of_a_table_are_the_exact_ones():
    mdp = hb.tabulate(hb.load_world("corridor"))
    states = np.flatnonzero(mdp.flags["equipped"])[::4000]
    for sensor in ("state", "object"):
        exact = hb.empowerment(mdp, 5, sensor, states=states)
        assert np.array_equal(
            hb.empowerment(mdp, 5, sensor, states=states, method=hb.Counting(sequences=10**4)),
            exact,
        )
        few = hb.empowerment(mdp, 5, sensor, states=states, method=hb.Counting(sequences=5))
        assert (few <= exact).all()
        assert (few < exact).any()


def test_it_says_when_everything_is_found():
    ring = hb.TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
    simulator = simulators.FiniteSimulator(ring)
    assert hb.Counting(sequences=9).fit(simulator, 30).kind == "exact"  # no more states
    assert hb.Counting(sequences=8).fit(simulator, 3).kind == "exact"  # no more sequences
    assert hb.Counting(sequences=7).fit(simulator, 3).kind == "lower bound"
    assert hb.Counting(sequences=9).fit(simulator, 30).bits([[0]]) == pytest.approx(np.log2(9))


def test_cells_of_a_pushed_mass_are_those_of_all_sequences():
    mass = simulators.linear_system([[1, 1], [0, 1]], [[0.5], [1]], actions=[[-1], [0], [1.0]])
    ends = {
        sum(a * (3.5 - t) for t, a in enumerate(sequence))
        for sequence in product((-1, 0, 1), repeat=4)
    }
    fitted = hb.Counting(0.5).fit(mass, 4, 0)
    assert fitted.kind == "exact"
    assert fitted.bits([[0, 0], [3, 1]]) == pytest.approx(np.log2(len(ends)))


def test_a_longer_search_finds_more_and_never_more_than_there_is():
    arm = simulators.double_integrator(dt=1.0)
    found = [
        float(hb.empowerment(arm, 3, "position", states=[[0, 0]], method=hb.Counting(0.1, n))[0])
        for n in (10, 40, 1000)
    ]
    assert found[0] < found[1] < found[2]
    reach = 0.5 + 1.5 + 2.5  # m to either side
    assert 0.9 * np.log2(2 * reach / 0.1 + 1) < found[2] <= np.log2(2 * reach / 0.1 + 1)


def test_the_same_seed_gives_the_same_numbers_whatever_else_is_asked():
    ball = simulators.ball_in_box()
    states = ball.random_states(3, np.random.default_rng(0))
    fitted = hb.Counting(0.2, 50).fit(ball, 3, "position", seed=4)
    together = fitted.bits(states)
    assert np.array_equal(together, np.concatenate([fitted.bits(one[None]) for one in states]))
    other = hb.Counting(0.2, 50).fit(ball, 3, "position", seed=5)
    assert not np.array_equal(together, other.bits(states))


def test_progress_and_units_are_those_of_every_method():
    ring = hb.TabularMDP.deterministic([[(s - 1) % 99, (s + 1) % 99] for s in range(99)])
    method = hb.Counting()
    plain = hb.empowerment(ring, 3, method=method)
    assert np.array_equal(hb.empowerment(ring, 3, method=method, show_progress=True), plain)
    assert hb.empowerment(ring, 3, method=method, unit="nats") == pytest.approx(plain * np.log(2))
    few = hb.empowerment(ring, 3, method=method, states=np.arange(99) < 5)
    assert np.array_equal(few, plain[:5])


def test_nothing_can_be_done_in_no_time():
    assert hb.Counting().fit(simulators.pendulum(), 0).bits([[1, 2]]) == 0


def test_what_draws_is_refused():
    ring = hb.TabularMDP.deterministic([[0, 1], [1, 0]])

    class Hidden:
        actions = np.array([[0.0]])
        is_stochastic = False

        def __init__(self):
            self.generator = np.random.default_rng(0)

        def step(self, states, actions, key):
            return states + self.generator.normal(size=states.shape)

    with pytest.raises(ValueError, match="the simulator is stochastic"):
        hb.empowerment(ring.slippery(0.1), 2, method=hb.Counting())
    with pytest.raises(ValueError, match="leads elsewhere the second time"):
        hb.empowerment(Hidden(), 2, states=[[0.0]], method=hb.Counting())


@pytest.mark.ill_typed
def test_wrong_arguments_are_refused_in_one_line():
    ring = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
    pendulum = simulators.pendulum()
    for resolution in (0, -1, float("nan"), "fine", []):
        with pytest.raises(ValueError, match="resolution is"):
            hb.Counting(resolution)
    with pytest.raises(ValueError, match="sequences is 0"):
        hb.Counting(sequences=0)
    with pytest.raises(ValueError, match="too fine"):
        hb.Counting(1e-30).fit(pendulum, 1).bits([[0, 1]])
    with pytest.raises(ValueError, match="resolution has 3 numbers, the sensor 2"):
        hb.Counting([1, 1, 1]).fit(pendulum, 1).bits([[0, 0]])
    with pytest.raises(ValueError, match="horizon is 2000000000, and 1,000 sequences"):
        hb.Counting().fit(pendulum, 2 * 10**9)
    with pytest.raises(ValueError, match="horizon is -1"):
        hb.Counting().fit(pendulum, -1)
    with pytest.raises(ValueError, match=r"states\[1\] is not finite"):
        hb.Counting().fit(pendulum, 1).bits([[0, 0], [0, np.nan]])
    with pytest.raises(ValueError, match="a simulator has no list of its states"):
        hb.empowerment(pendulum, 1, method=hb.Counting())
    with pytest.raises(ValueError, match=r"no world; give hb\.tabulate"):
        hb.empowerment(hb.load_world("corridor"), 1, method=hb.Counting())
    with pytest.raises(ValueError, match="int is no simulator: it has no `actions`"):
        hb.empowerment(5, 1, states=[[0.0]], method=hb.Counting())
    with pytest.raises(ValueError, match="states has 2; use indices from 0 to 1"):
        hb.empowerment(ring, 1, states=[2], method=hb.Counting())
    with pytest.raises(ValueError, match="an estimator takes no actions"):
        hb.empowerment(ring, 1, actions=[0], method=hb.Counting())
