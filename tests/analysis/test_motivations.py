"""Informations of visited states, beside all trajectories, their relations, and refusals."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trajectories import distributions, entropy, information, random_model, trajectories, weighed

import habilis as hb
from habilis.analysis import music, occupancy_entropy, skill_discriminability

cases = given(st.integers(0, 10_000), st.integers(1, 4), st.booleans())


def ends_of(mdp, absorbing):
    return np.flatnonzero(mdp.terminal) if absorbing else ()


def labelled(mdp, rng, names, values=2):
    """The table with random factors."""
    factors = {name: rng.integers(values, size=mdp.states).astype(np.int32) for name in names}
    return replace(mdp, factors=factors), factors


def visited(paths, label):
    """The probability of each label at a time drawn uniformly."""
    return weighed((label(s), p / len(path)) for p, path in paths for s in path)


@settings(deadline=None, max_examples=20)
@cases
def test_the_entropy_is_that_of_what_trajectories_visit(seed, steps, absorbing):
    P, policy, mdp, rng = random_model(seed, states=3)
    labels = rng.integers(2, size=3)
    for sensor, label in (("state", int), (labels, labels.__getitem__)):
        bits = occupancy_entropy(mdp, policy, steps, sensor, range(3), absorbing=absorbing)
        for start in range(3):
            paths = trajectories(P, policy, start, steps, ends_of(mdp, absorbing))
            assert bits[start] == pytest.approx(entropy(visited(paths, label)), abs=1e-12)


@settings(deadline=None, max_examples=20)
@cases
def test_music_is_the_information_of_agent_and_rest_at_a_random_time(seed, steps, absorbing):
    P, policy, mdp, rng = random_model(seed, states=4)
    mdp, factors = labelled(mdp, rng, ["agent", "tool", "object"])
    agent, tool, thing = factors.values()

    def pair(s):
        return int(agent[s]), (int(tool[s]), int(thing[s]))

    bits = music(mdp, policy, steps, states=range(4), absorbing=absorbing)
    each = music(mdp, policy, steps, states=range(4), absorbing=absorbing, each_step=True)
    for start in range(4):
        paths = trajectories(P, policy, start, steps, ends_of(mdp, absorbing))
        assert bits[start] == pytest.approx(information(visited(paths, pair)), abs=1e-12)
        at = [weighed((pair(path[t]), p) for p, path in paths) for t in range(steps)]
        assert each[start] == pytest.approx(np.mean([*map(information, at)]), abs=1e-12)
        assert bits[start] <= each[start] + np.log2(steps) + 1e-12


def test_music_of_an_agent_of_two_parts():
    P, policy, mdp, rng = random_model(3)
    mdp, factors = labelled(mdp, rng, ["agent", "tool", "object"])
    bits = music(mdp, policy, 2, ["agent", "tool"], range(4))
    paths = [trajectories(P, policy, start, 2) for start in range(4)]
    agent, tool, thing = factors.values()
    expected = [
        information(visited(one, lambda s: ((int(agent[s]), int(tool[s])), int(thing[s]))))
        for one in paths
    ]
    np.testing.assert_allclose(bits, expected, atol=1e-12)


def test_music_is_nothing_while_nothing_can_be_moved_and_something_beside_the_can():
    mdp = hb.tabulate(hb.World.parse("A....\n..C..\n....G").with_tool("none"))
    far = mdp.find(agent=(2, 4), object=(0, 0))
    near = mdp.find(agent=(1, 1), object=(1, 2))
    found = music(mdp, "uniform", 3, states=[far, near])
    assert found[0] == 0 < found[1]


@settings(deadline=None, max_examples=20)
@cases
def test_skills_are_told_apart_as_well_as_trajectories_are(seed, steps, absorbing):
    P, _, mdp, rng = random_model(seed, states=3)
    skills, prior = distributions(rng, 3, 3, 2), distributions(rng, 3)
    labels = rng.integers(2, size=3)
    for sensor, label in (("state", int), (labels, labels.__getitem__)):
        bits = skill_discriminability(
            *(mdp, skills, steps, prior, range(3), sensor), absorbing=absorbing
        )
        for start in range(3):
            joint = {}
            for z in range(3):
                paths = trajectories(P, skills[z], start, steps, ends_of(mdp, absorbing))
                seen = visited(paths, lambda s, label=label: int(label(s)))
                joint |= {(z, o): prior[z] * p for o, p in seen.items()}
            assert bits[start] == pytest.approx(information(joint), abs=1e-12)


def test_it_is_no_lower_bound_of_closed_loop_empowerment():
    # Two ways around an obstacle: on the way one knows which, at the end nothing is left of it.
    diamond = hb.TabularMDP.deterministic([[1, 2], [3, 3], [3, 3], [3, 3]])
    left, right = np.eye(2)[[0] * 4], np.eye(2)[[1] * 4]
    assert skill_discriminability(diamond, [left, right], steps=2) == pytest.approx([0.5])
    assert hb.closed_loop_empowerment(diamond, 2, states=[0]).tolist() == [0]


@settings(deadline=None, max_examples=4)
@given(st.integers(0, 10_000))
def test_it_is_at_most_the_mean_of_the_closed_loop_empowerments_on_the_way(seed):
    _, _, mdp, rng = random_model(seed, states=3)
    skills = distributions(rng, 3, 3, 2)
    bits = skill_discriminability(mdp, skills, 2, states=range(3))
    bounds = [hb.closed_loop_empowerment(mdp, h, return_gap=True) for h in (1, 2)]
    assert (bits <= np.mean([lower + gap for lower, gap in bounds], axis=0) + 1e-9).all()


def test_a_noisy_sensor_tells_no_more_than_the_state():
    _, policy, mdp, rng = random_model(5)
    noisy, skills = distributions(rng, 4, 3), distributions(rng, 2, 4, 2)
    less = skill_discriminability(mdp, skills, 3, sensor=noisy)
    assert 0 < less < skill_discriminability(mdp, skills, 3)
    assert occupancy_entropy(mdp, policy, 3, noisy) <= np.log2(3)


def test_starts_in_several_blocks_have_the_same_bits(monkeypatch):
    _, policy, mdp, rng = random_model(7)
    mdp, _ = labelled(mdp, rng, ["agent", "object"])
    whole = [music(mdp, policy, 3, states=range(4)), occupancy_entropy(mdp, policy, 3, "agent")]
    monkeypatch.setattr(sys.modules["habilis.analysis.occupancy"], "_BLOCK", 8)
    parts = [music(mdp, policy, 3, states=range(4)), occupancy_entropy(mdp, policy, 3, "agent")]
    for one, other in zip(whole, parts, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)
    assert music(mdp, policy, 3, states=[]).shape == (0,)


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda m: music(m, "uniform", 2, "taxi"), "factor 'taxi' is unknown; this MDP has: agent"),
        (lambda m: music(m, "uniform", 2), "there is no rest, as the only factors are agent"),
        (lambda m: music(m, "uniform", 2, []), "agent names no factor; give at least one"),
        (lambda m: occupancy_entropy(m, "greedy", 2), "policy is 'greedy'; give 'uniform' or"),
        (lambda m: occupancy_entropy(m, "uniform", 2, "state + agent"), "several; give one alone"),
        (
            lambda m: occupancy_entropy(m, "uniform", 2, np.full((2, 2, 2), 0.5)),
            "the sensor depends on the last action, and visited states have none",
        ),
        (
            lambda m: skill_discriminability(m, np.eye(2), 2),
            r"policies has shape \(2, 2\); give float\[skills, states, actions\], here",
        ),
        (
            lambda m: skill_discriminability(m, np.full((2, 2, 2), 0.5), 2, prior=[1.0]),
            r"prior has shape \(1,\); give one probability for each of 2 policies",
        ),
        (
            lambda m: skill_discriminability(m, np.full((2, 2, 2), 0.5), 2, prior=[0.5, 0.4]),
            "prior, the row sums to 0.9",
        ),
        (
            lambda m: skill_discriminability(m, [np.eye(2), np.full((2, 2), 0.4)], 2),
            "policy 1, state 0 sums to 0.8",
        ),
    ],
)
def test_what_they_refuse(call, message):
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
    with pytest.raises(ValueError, match=message):
        call(replace(mdp, factors={"agent": np.array([0, 1], np.int32)}))
