"""The variational bound: below the truth, near it where that is easy, and the same every time."""

from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

import habilis as hb
from habilis.estimators import simulators

pytest.importorskip("equinox")

QUICK: dict[str, Any] = {"rounds": 12, "width": 32, "samples": 800}
CONFIDENCE = 0.999  # of all comparisons of a test together


class Stops:
    """A table as a simulator that fails after so many steps of many states, like a killed run."""

    in_jax, is_finite = False, True

    def __init__(self, mdp, left=10**9):
        self.inner, self.left = simulators.FiniteSimulator(mdp), left
        self.actions, self.names, self.mdp = self.inner.actions, self.inner.names, mdp
        self.is_stochastic = self.inner.is_stochastic

    def random_states(self, count, generator):
        return self.inner.random_states(count, generator)

    def observe(self, states):
        return self.inner.observe(states)

    def step(self, states, actions, key):
        self.left -= 1
        if self.left < 0:
            raise KeyboardInterrupt
        return self.inner.step(states, actions, key)


def check_below(method, case, seeds):
    limit = norm.isf((1 - CONFIDENCE) / (len(case.bits) * len(seeds)))
    for seed in seeds:
        fitted = method.fit(case.simulator, case.horizon, case.sensor, seed=seed)
        assert (fitted.kind, fitted.target) == ("lower bound", "capacity")
        bits, errors = fitted.with_errors(case.states)
        assert (bits <= case.bits + case.error + limit * errors + 1e-4).all()


def test_it_is_below_the_truth_however_little_was_learned():
    (case,) = hb.suite(["channels-2"])
    for rounds in (1, 8):
        check_below(hb.Variational(**{**QUICK, "rounds": rounds}), case, [0, 1])


@pytest.mark.parametrize("name", ["frozen-lake", "maze-slips", "channels-16", "gauss-1", "wall"])
def test_it_is_below_the_truth_of_the_suite(name: str):
    (case,) = hb.suite([name])
    check_below(hb.Variational(**QUICK, power=case.power), case, [0, 1])


def test_it_comes_near_where_that_is_easy():
    (case,) = hb.suite(["channels-2"])
    fitted = hb.Variational(rounds=25, width=32, samples=4000).fit(case.simulator, 1)
    assert fitted.bits(case.states) == pytest.approx(case.bits, abs=0.08)
    assert fitted.predicted_bits(case.states) == pytest.approx(case.bits, abs=0.2)
    assert fitted.bounds[-1] > fitted.bounds[0] + 0.2


def test_it_finds_most_of_a_gaussian_capacity_under_its_power():
    (case,) = hb.suite(["gauss-1"])
    fitted = hb.Variational(rounds=30, power=case.power).fit(case.simulator, case.horizon)
    assert (fitted.bits(case.states) > 0.85 * case.bits).all()


def test_the_source_prefers_what_can_be_told_apart():
    # One action of three is clear, two lead to the same: uniform sequences carry less.
    P = np.zeros((3, 2, 2))
    P[0, :, 0] = P[1, :, 0] = P[2, :, 1] = 1
    mdp = hb.TabularMDP.stochastic(P, axes="ASS")
    found = hb.empowerment(mdp, 1, method=hb.Variational(rounds=40, width=16, samples=4000))
    assert (found > 0.95).all()  # uniform: 0.918


def test_sequences_that_are_too_many_to_list_are_learned_action_by_action():
    line = hb.TabularMDP.deterministic([[max(s - 1, 0), min(s + 1, 12)] for s in range(13)])
    exact = hb.empowerment(line, 12, states=[6])
    fitted = hb.Variational(**QUICK).fit(simulators.FiniteSimulator(line), 12)
    bits, errors = fitted.with_errors([[6.0]])
    assert fitted.coding.length == 12
    assert bits <= exact + 4 * errors
    assert bits > 1.5


def test_the_same_seed_gives_the_same_numbers_whatever_else_is_asked():
    (case,) = hb.suite(["frozen-lake"])
    method = hb.Variational(rounds=3, width=16, samples=50)
    first, again, other = (method.fit(case.simulator, 2, seed=seed) for seed in (3, 3, 4))
    whole = first.bits(case.states)
    assert np.array_equal(whole[4:7], again.bits(case.states[4:7]))
    assert np.array_equal(first.bounds, again.bounds)
    assert not np.array_equal(whole, other.bits(case.states))


def test_training_goes_on_after_a_kill_as_if_there_was_none(tmp_path, monkeypatch):
    from habilis.estimators.learned import training

    monkeypatch.setattr(training, "_SAVE_AFTER", 0.0)
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]]).slippery(0.2)
    whole = hb.Variational(rounds=6, width=16).fit(Stops(mdp), 2)
    kept = hb.Variational(rounds=6, width=16, folder=tmp_path)
    with pytest.raises(KeyboardInterrupt):
        kept.fit(Stops(mdp, left=10), 2)  # two steps a rollout: the probe, the first, three rounds
    (file,) = tmp_path.iterdir()
    before = file.read_bytes()
    resumed = Stops(mdp)
    fitted = kept.fit(resumed, 2)
    assert file.read_bytes() != before
    assert np.array_equal(fitted.bounds, whole.bounds)
    assert np.array_equal(fitted.bits([[0.0], [1.0]]), whole.bits([[0.0], [1.0]]))
    done = Stops(mdp)
    kept.fit(done, 2)
    assert 10**9 - done.left == 4  # the probe and the first rollout: nothing is trained again


def test_another_simulator_or_seed_does_not_go_on_with_it(tmp_path):
    calm = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
    method = hb.Variational(rounds=1, width=8, folder=tmp_path)
    for mdp, seed in ((calm, 0), (calm, 1), (calm.slippery(0.9), 0)):
        method.fit(simulators.FiniteSimulator(mdp), 1, seed=seed)
    assert len(list(tmp_path.iterdir())) == 3


def test_a_damaged_file_is_made_again(tmp_path):
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
    method = hb.Variational(rounds=2, width=8, folder=tmp_path)
    first = method.fit(simulators.FiniteSimulator(mdp), 1)
    (file,) = tmp_path.iterdir()
    file.write_bytes(file.read_bytes()[:-7])
    assert np.array_equal(method.fit(simulators.FiniteSimulator(mdp), 1).bounds, first.bounds)


def test_training_stops_where_nothing_grows():
    blind = hb.TabularMDP.deterministic([[0, 0], [1, 1]])
    fitted = hb.Variational(width=8, patience=3).fit(simulators.FiniteSimulator(blind), 1)
    assert 7 < len(fitted.bounds) < 30


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"rounds": 0}, "rounds is 0"),
        ({"batch": 1.5}, "batch is 1.5"),
        ({"learning_rate": 0.0}, "learning_rate is 0"),
        ({"power": -1}, "power is -1"),
    ],
)
@pytest.mark.ill_typed
def test_settings_out_of_range_are_refused(settings, message):
    with pytest.raises(ValueError, match=message):
        hb.Variational(**settings)


def test_actions_without_a_bound_need_a_power():
    drift = simulators.linear_system([[1.0]], [[1.0]])
    with pytest.raises(ValueError, match="give power="):
        hb.Variational().fit(drift, 1)
    with pytest.raises(ValueError, match="the box has bounds"):
        hb.Variational(power=1.0).fit(simulators.pendulum(), 1)
    with pytest.raises(ValueError, match="these are finitely many"):
        hb.Variational(power=1.0).fit(hb.suite(["maze"])[0].simulator, 1)


def test_a_simulator_without_states_to_learn_from_is_refused():
    class Bare:
        actions, is_stochastic = np.eye(2), False

        def step(self, states, actions, key):
            return states + actions

    with pytest.raises(ValueError, match="no random_states"):
        hb.Variational().fit(Bare(), 1)


def test_it_is_trained_on_the_states_that_are_given(tmp_path):
    """Of 500 states one has a choice, and training on random ones hardly ever sees it."""
    table = np.repeat(np.arange(500)[:, None], 2, axis=1)
    table[7] = 8, 9
    mdp = hb.TabularMDP.deterministic(table)
    few: dict[str, Any] = {"rounds": 6, "width": 16, "samples": 400, "updates": 8}
    given = hb.Variational(**few, states=[[7.0], [8.0]], folder=tmp_path)
    bits = hb.empowerment(mdp, 1, states=[7, 8], method=given)
    assert 0.8 < bits[0] <= 1
    assert abs(bits[1]) < 0.05
    once: dict[str, Any] = few | {"rounds": 1}
    hb.Variational(**once, states=[[7.0]], folder=tmp_path).fit(simulators.FiniteSimulator(mdp), 1)
    assert len(list(tmp_path.iterdir())) == 2  # other states, another checkpoint
    with pytest.raises(ValueError, match="states is empty; give states to train on"):
        hb.Variational(states=np.zeros((0, 1)))
    with pytest.raises(ValueError, match=r"states has shape \(2,\)"):
        hb.Contrastive(states=[1.0, 2.0])
