"""Small tables of several players, and everything that they can do, path by path."""

from collections import defaultdict
from collections.abc import Sequence
from itertools import product

import numpy as np

from habilis.mdp import TabularMDP

SIZES = ((2, 2), (2, 3), (3, 1), (1, 2), (2, 1, 2))


def names(sizes: Sequence[int]) -> list[str]:
    """One name a player."""
    return ["a", "b", "c"][: len(sizes)]


def random_joint(
    rng: np.random.Generator, stochastic: bool, sizes: Sequence[int] | None = None
) -> TabularMDP:
    """A table of two or three players with up to five states, some of the outcomes certain."""
    sizes = SIZES[int(rng.integers(len(SIZES)))] if sizes is None else sizes
    states, actions = int(rng.integers(2, 6)), int(np.prod(sizes))
    players = dict(zip(names(sizes), sizes, strict=True))
    reward = rng.normal(size=(states, actions))
    if not stochastic:
        table = rng.integers(states, size=(states, actions))
        return TabularMDP.deterministic(table, reward, players=players)
    P = rng.dirichlet(np.full(states, 0.5), (states, actions))
    certain = rng.random((states, actions)) < 0.4
    P[certain] = np.eye(states)[rng.integers(states, size=int(certain.sum()))]
    return TabularMDP.stochastic(P, reward, players=players)


def probabilities(mdp: TabularMDP) -> np.ndarray:
    """float[S, A, S]."""
    return np.stack([mdp.transition(a).toarray() for a in range(mdp.action_count)], axis=1)


def joint_index(sizes: Sequence[int], actions: Sequence[int]) -> int:
    """The number of a joint action, digit by digit."""
    number = 0
    for size, action in zip(sizes, actions, strict=True):
        number = number * size + action
    return number


def others_of(sizes: Sequence[int], place: int) -> list[tuple[int, ...]]:
    """The joint actions of all players but one, in order."""
    return list(product(*(range(n) for p, n in enumerate(sizes) if p != place)))


def with_own(others: Sequence[int], place: int, own: int) -> list[int]:
    """Everyone's actions."""
    return [*others[:place], own, *others[place:]]


def ends(
    mdp: TabularMDP, place: int, start: int, sequence: Sequence[int], policy: np.ndarray
) -> np.ndarray:
    """P(s_h | s, a_1 ... a_h), summed over every path of states and the others' actions."""
    P, sizes = probabilities(mdp), list(mdp.players.values())
    theirs = others_of(sizes, place)
    paths: dict[tuple[int, ...], float] = {(start,): 1.0}
    for own in sequence:
        longer: dict[tuple[int, ...], float] = defaultdict(float)
        for path, weight in paths.items():
            for number, others in enumerate(theirs):
                joint = joint_index(sizes, with_own(others, place, own))
                for state in np.flatnonzero(P[path[-1], joint]).tolist():
                    share = policy[path[-1], number] * P[path[-1], joint, state]
                    longer[(*path, number, state)] += weight * share
        paths = longer
    found = np.zeros(mdp.states)
    for path, weight in paths.items():
        found[path[-1]] += weight
    return found


def against(
    mdp: TabularMDP, place: int, start: int, sequence: Sequence[int], theirs: Sequence[int]
) -> np.ndarray:
    """P(s_h | s, a_1 ... a_h, b_1 ... b_h), the others' joint actions by number."""
    P, sizes = probabilities(mdp), list(mdp.players.values())
    every = others_of(sizes, place)
    belief = np.eye(mdp.states)[start]
    for own, number in zip(sequence, theirs, strict=True):
        belief = belief @ P[:, joint_index(sizes, with_own(every[number], place, own))]
    return belief
