"""Small random models, and all of their trajectories, listed one by one."""

import math

import numpy as np

import habilis as hb


def distributions(rng, *shape):
    """Random rows that are distributions, with zeros among them."""
    rows = rng.dirichlet(np.full(shape[-1], 0.5), size=shape[:-1])
    rows[rows < 0.05] = 0
    return rows / rows.sum(axis=-1, keepdims=True)


def random_model(seed, states=4, actions=2):
    """Transition probabilities float[S, A, S], a policy, their table, and the generator."""
    rng = np.random.default_rng(seed)
    P, policy = distributions(rng, states, actions, states), distributions(rng, states, actions)
    terminal = rng.random(states) < 0.3
    return P, policy, hb.TabularMDP.stochastic(P, terminal=terminal, axes="SAS"), rng


def trajectories(P, policy, start, steps, ends=()):
    """Every trajectory, as its probability and the states after each step.

    In the states of `ends` the agent stays.
    """
    found: list[tuple[float, tuple[int, ...]]] = [(1.0, (start,))]
    for _ in range(steps):
        longer = []
        for probability, path in found:
            if path[-1] in ends:
                longer.append((probability, (*path, path[-1])))
                continue
            for action, chosen in enumerate(policy[path[-1]]):
                for state, moved in enumerate(P[path[-1], action]):
                    if chosen * moved > 0:
                        longer.append((probability * chosen * moved, (*path, state)))
        found = longer
    return [(probability, path[1:]) for probability, path in found]


def entropy(weights):
    """Bits, of a dictionary of probabilities."""
    return -sum(p * math.log2(p) for p in weights.values() if p > 0)


def information(joint):
    """I(X; Y) in bits, of the probabilities of pairs (x, y)."""
    first, second = {}, {}
    for (x, y), p in joint.items():
        first[x] = first.get(x, 0) + p
        second[y] = second.get(y, 0) + p
    return sum(p * math.log2(p / first[x] / second[y]) for (x, y), p in joint.items() if p > 0)


def weighed(pairs):
    """The sum of the weights of each thing."""
    found = {}
    for thing, weight in pairs:
        found[thing] = found.get(thing, 0) + weight
    return found
