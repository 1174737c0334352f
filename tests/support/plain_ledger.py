"""`Ledger.entries`, environment by environment in NumPy."""

import numpy as np

from habilis.learning.episodes import Ledger


def plain_entries(
    ledger: Ledger, running: np.ndarray, transition: np.ndarray, truncated: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The sums of the episodes that ended, in the order of time, and the new running sums."""
    ended = truncated | ledger.terminated[transition]
    sums = np.cumsum(ledger.columns[transition], axis=0) + running
    before = np.zeros_like(running)
    rows, order = [], []
    for env in range(ended.shape[1]):
        at = np.flatnonzero(ended[:, env])
        if len(at):
            up_to = sums[at, env]
            rows.append(np.diff(up_to, axis=0, prepend=np.zeros((1, up_to.shape[1]))))
            order.append(at * ended.shape[1] + env)
            before[env] = up_to[-1]
    after = sums[-1] - before
    if not rows:
        return np.empty((0, running.shape[1])), after
    return np.concatenate(rows)[np.argsort(np.concatenate(order))], after
