"""Small tables drawn at random, and what can be reached in them, the slow way."""

import numpy as np
from hypothesis import strategies as st


@st.composite
def labelled_tables(draw, most_states=7, most_actions=3):
    """next_state int[S, A], and an observation for every state."""
    states = draw(st.integers(1, most_states))
    actions = draw(st.integers(1, most_actions))
    cells = st.integers(0, states - 1)
    rows = st.lists(cells, min_size=actions, max_size=actions)
    table = draw(st.lists(rows, min_size=states, max_size=states))
    labels = draw(st.lists(cells, min_size=states, max_size=states))
    return np.array(table), np.array(labels)


def one_step(table: np.ndarray) -> np.ndarray:
    """bool[S, S]: whether some action leads from the one state to the other."""
    leads = np.zeros((len(table),) * 2, bool)
    leads[np.arange(len(table))[:, None], table] = True
    return leads


def after(table: np.ndarray, horizon: int) -> np.ndarray:
    """bool[S, S]: whether so many actions lead from the one state to the other."""
    found = np.eye(len(table), dtype=bool)
    for _ in range(horizon):
        found = found @ one_step(table)
    return found


def ever(table: np.ndarray) -> np.ndarray:
    """bool[S, S]: whether any number of actions does."""
    return np.logical_or.reduce([after(table, h) for h in range(len(table) + 1)])
