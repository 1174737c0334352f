"""Contrastive learning: what it finds, and where it saturates."""

import numpy as np
import pytest

import habilis as hb
from habilis.estimators import simulators

pytest.importorskip("equinox")


def choices(count: int) -> simulators.FiniteSimulator:
    """Every action leads to a state of its own, from everywhere."""
    return simulators.FiniteSimulator(
        hb.TabularMDP.deterministic(np.tile(np.arange(count), (count, 1)))
    )


def test_it_saturates_at_the_logarithm_of_the_batch():
    many = choices(64)  # 6 bits
    for batch in (4, 16):
        method = hb.Contrastive(batch=batch, updates=4096 // batch, rounds=12, width=32)
        found = method.fit(many, 1).bits([[0.0], [1.0]])
        assert (found <= np.log2(batch) + 0.05).all()
        assert (found > np.log2(batch) - 1).all()


def test_a_large_batch_tells_many_outcomes_apart():
    found = hb.Contrastive(batch=512, updates=8, rounds=25, width=32).fit(choices(16), 1)
    assert (found.kind, found.target) == ("approximation", "effective")
    assert found.bits([[0.0], [5.0]]) == pytest.approx([4.0, 4.0], abs=0.25)


def test_it_finds_effective_empowerment_of_a_small_world():
    (case,) = hb.suite(["lake-effective"])
    found = hb.Contrastive(rounds=25, samples=2000).fit(case.simulator, case.horizon, case.sensor)
    bits = found.bits(case.states)
    assert abs(bits - case.bits).max() < 0.15
    assert np.corrcoef(bits, case.bits)[0, 1] > 0.85


def test_a_discount_is_that_of_effective_empowerment():
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 2], [2, 0]])
    exact = hb.effective_empowerment(mdp, "uniform", 0.5)
    method = hb.Contrastive(discount=0.5, rounds=25, width=32, samples=4000)
    found = hb.empowerment(mdp, 1, method=method)
    assert found == pytest.approx(exact, abs=0.06)
    assert abs(exact - hb.effective_empowerment(mdp, "uniform", 0.0)).min() > 0.3


def test_actions_of_a_box_are_numbers():
    line = simulators.JaxSimulator(
        lambda state, action: action,
        hb.estimators.ActionBox([-1.0], [1.0]),
        low=[-1.0],
        high=[1.0],
    )
    blind = simulators.JaxSimulator(
        lambda state, action: 0.0 * action, line.actions, low=[-1.0], high=[1.0]
    )
    method = hb.Contrastive(rounds=6, width=32)
    assert method.fit(line, 1).bits([[0.0]]) > 2
    assert method.fit(blind, 1).bits([[0.0]]) == pytest.approx([0.0], abs=0.05)


def test_the_same_seed_gives_the_same_numbers_whatever_else_is_asked():
    (case,) = hb.suite(["lake-effective"])
    method = hb.Contrastive(rounds=2, width=16, samples=50)
    first, again, other = (method.fit(case.simulator, 2, seed=seed) for seed in (3, 3, 4))
    whole = first.bits(case.states)
    assert np.array_equal(whole[4:7], again.bits(case.states[4:7]))
    assert not np.array_equal(whole, other.bits(case.states))


def test_what_was_trained_is_found_again(tmp_path):
    some = choices(4)
    method = hb.Contrastive(rounds=3, width=16, folder=tmp_path)
    first = method.fit(some, 1)
    (file,) = tmp_path.iterdir()
    assert file.name.startswith("contrastive-")
    second = method.fit(some, 1)
    assert np.array_equal(first.bits([[0.0]]), second.bits([[0.0]]))
    assert np.array_equal(first.bounds, second.bounds)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"batch": 1}, "batch is 1; give at least 2"),
        ({"discount": 1.0}, "discount is 1.0"),
        ({"features": 0}, "features is 0"),
    ],
)
def test_settings_out_of_range_are_refused(settings, message):
    with pytest.raises(ValueError, match=message):
        hb.Contrastive(**settings)


def test_unbounded_actions_are_refused():
    with pytest.raises(ValueError, match="unbounded"):
        hb.Contrastive().fit(simulators.linear_system([[1.0]], [[1.0]]), 1)
