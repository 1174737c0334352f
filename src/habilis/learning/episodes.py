"""Episodes, from the transitions that environments made."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from habilis.compiled import compiled
from habilis.mdp import TabularMDP
from habilis.transitions import Transitions


@dataclass(frozen=True, eq=False)
class Ledger:
    """The quantities to sum over an episode, for every transition, numbered as in `Dynamics`.

    Attributes:
        columns: float64[S*A*K, 2 + flags]: a step, its extrinsic reward, and the flags of the
            state that it leads to.
        terminated: bool[S*A*K].
    """

    columns: Float[np.ndarray, "transitions columns"]
    terminated: Bool[np.ndarray, "transitions"]

    @classmethod
    def of(cls, mdp: TabularMDP) -> "Ledger":
        reached, reward, _ = Transitions.of(mdp)
        flags = [flag[reached] for flag in mdp.flags.values()]
        columns = np.stack([np.ones(len(reached)), reward, *flags], axis=1)
        return cls(columns.astype(np.float64), mdp.ends[reached])

    def nothing(self, envs: int) -> Float[np.ndarray, "E columns"]:
        """The running sums of environments that have not made a step."""
        return np.zeros((envs, self.columns.shape[1]))

    def entries(
        self,
        running: Float[np.ndarray, "E columns"],
        transition: Int[np.ndarray, "T E"],
        truncated: Bool[np.ndarray, "T E"],
    ) -> tuple[Float[np.ndarray, "n columns"], Float[np.ndarray, "E columns"]]:
        """The sums of the episodes that ended, in the order of time, and the new running sums.

        A transition of -1 is a step that was not made. It may run in several threads at once.
        """
        each = np.ascontiguousarray(transition), np.ascontiguousarray(truncated)
        return _entries(self.columns, self.terminated, running, *each)


@compiled()
def _entries(
    columns: np.ndarray,
    terminated: np.ndarray,
    running: np.ndarray,
    transition: np.ndarray,
    truncated: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    steps, envs = transition.shape
    width = columns.shape[1]
    count = 0
    for t in range(steps):
        for env in range(envs):
            at = transition[t, env]
            count += at >= 0 and (truncated[t, env] or terminated[at])
    rows = np.empty((count, width))
    sums = np.zeros((envs, width))  # since the stretch began
    before = np.zeros((envs, width))  # what had been summed up when the episode began
    row = 0
    for t in range(steps):
        for env in range(envs):
            at = transition[t, env]
            if at < 0:
                continue
            for column in range(width):
                sums[env, column] += columns[at, column]
            if truncated[t, env] or terminated[at]:
                for column in range(width):
                    total = sums[env, column] + running[env, column]
                    rows[row, column] = total - before[env, column]
                    before[env, column] = total
                row += 1
    return rows, sums + running - before
