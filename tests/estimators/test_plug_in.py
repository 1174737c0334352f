"""Tables of logged transitions, and the intervals made from them."""

import numpy as np
import pytest

import habilis as hb


def logged(mdp, each, seed, states=None):
    """Some transitions from every state by every action."""
    generator = np.random.default_rng(seed)
    s, a, t = [], [], []
    for action in range(mdp.action_count):
        P = mdp.transition(action).toarray()
        for state in range(mdp.states) if states is None else states:
            s += [state] * each
            a += [action] * each
            t += generator.choice(mdp.states, p=P[state], size=each).tolist()
    return s, a, t


def ring(slip=0.0):
    moves = [[(s - 1) % 4, s, (s + 1) % 4] for s in range(4)]
    return hb.TabularMDP.deterministic(moves).slippery(slip)


def test_probabilities_are_relative_frequencies():
    mdp = hb.TabularMDP.from_transitions([0, 0, 0, 2], [1, 1, 1, 0], [0, 2, 2, 1], state_count=4)
    assert mdp.transition(1).toarray()[0].tolist() == [1 / 3, 0, 2 / 3, 0]
    assert np.argwhere(mdp.available).tolist() == [[0, 1], [2, 0]]
    assert mdp.counts is not None
    assert mdp.counts.sum() == 4
    assert hb.TabularMDP.from_transitions([0], [0], [1], action_count=3).action_count == 3


def test_a_deterministic_world_is_logged_as_it_is():
    world = ring()
    mdp = hb.TabularMDP.from_transitions(*logged(world, 2, 0))
    assert np.array_equal(mdp.next_state, world.next_state)
    found = hb.plug_in_interval(mdp, 1, states=[0], resamples=40)
    exact = hb.empowerment(world, 1, states=[0])
    assert np.array_equal(found.plug_in, exact)
    assert found.bits == pytest.approx(exact, abs=1e-6)
    assert (found.low < exact).all()  # two transitions do not prove that there is no other outcome
    assert (found.high >= exact - 1e-9).all()
    assert found.unknown == 0


def test_more_transitions_make_a_narrower_interval_and_correct_less():
    truth = hb.empowerment(ring(0.3), 1, states=[0])
    few, many = (
        hb.plug_in_interval(
            hb.TabularMDP.from_transitions(*logged(ring(0.3), each, 5)), 1, states=[0], resamples=40
        )
        for each in (10, 400)
    )
    assert (many.high - many.low) < (few.high - few.low) / 2
    assert many.low < truth < many.high
    assert few.plug_in - few.bits > many.plug_in - many.bits > 0


def test_the_interval_holds_the_truth_as_often_as_it_says():
    covered = []
    for slip, each, horizon in ((0.05, 20, 1), (0.3, 5, 1), (0.3, 20, 2)):
        truth = hb.empowerment(ring(slip), horizon, states=[0])[0]
        for seed in range(12):
            mdp = hb.TabularMDP.from_transitions(*logged(ring(slip), each, [seed, each]))
            some = hb.plug_in_interval(mdp, horizon, states=[0], resamples=40, seed=seed)
            covered.append(some.low[0] - 1e-6 <= truth <= some.high[0] + 1e-6)
    assert sum(covered) >= 31  # of 36 at 95 %: fewer happen by chance once in 200 times


def test_what_was_never_tried_is_unknown():
    s, a, t = logged(ring(), 3, 0, states=[0, 1])  # never in 2 or 3
    mdp = hb.TabularMDP.from_transitions(s, a, t, state_count=4)
    one, two = (
        hb.plug_in_interval(mdp, horizon, states=[0, 2], resamples=40) for horizon in (1, 2)
    )
    assert one.unknown.tolist() == [0, 1]
    assert two.unknown == pytest.approx([1 / 3, 1])
    assert np.isnan([one.bits, one.low, one.high]).tolist() == [[False, True]] * 3
    assert two.plug_in == pytest.approx(hb.empowerment(mdp, 2, states=[0, 2]))
    assert two.plug_in[0] == pytest.approx(2)  # of 9 sequences the 6 known ones reach all 4


def test_one_sequence_that_is_known_has_no_empowerment_but_is_no_gap():
    mdp = hb.TabularMDP.from_transitions([0, 1], [0, 0], [1, 0], action_count=2)
    found = hb.plug_in_interval(mdp, 3, resamples=40)
    assert found.bits.tolist() == [0, 0]
    assert found.unknown == pytest.approx([7 / 8, 7 / 8])


def test_the_same_seed_gives_the_same_interval():
    mdp = hb.TabularMDP.from_transitions(*logged(ring(0.2), 8, 0))
    first, again, other = (
        hb.plug_in_interval(mdp, 1, states=[1], resamples=40, seed=seed) for seed in (3, 3, 4)
    )
    assert (first.low, first.high) == (again.low, again.high)
    assert first.low != other.low


@pytest.mark.ill_typed
def test_wrong_arguments_are_refused_in_one_line():
    build = hb.TabularMDP.from_transitions
    with pytest.raises(ValueError, match="2 states, 1 actions and 1 next_states"):
        build([0, 1], [0], [1])
    with pytest.raises(ValueError, match="there are no transitions"):
        build([], [], [])
    with pytest.raises(ValueError, match="actions has -1"):
        build([0], [-1], [0])
    with pytest.raises(ValueError, match=r"np\.unique\(observations"):
        build([[0.5, 1]], [0], [0])
    with pytest.raises(ValueError, match="state_count is 2; give at least 3"):
        build([0], [0], [2], state_count=2)
    mdp = build(*logged(ring(0.2), 4, 0))
    with pytest.raises(ValueError, match="was not made of logged transitions"):
        hb.plug_in_interval(ring(), 1)
    with pytest.raises(ValueError, match="no longer those that were logged"):
        hb.plug_in_interval(mdp.slippery(0.5), 1)
    with pytest.raises(ValueError, match="confidence is 95"):
        hb.plug_in_interval(mdp, 1, confidence=95)
    with pytest.raises(ValueError, match="resamples is 10; give at least 40"):
        hb.plug_in_interval(mdp, 1, resamples=10)
    with pytest.raises(ValueError, match="states has 9"):
        hb.plug_in_interval(mdp, 1, states=[9])
