"""Episodes, from the transitions that environments made."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from habilis.mdp import TabularMDP
from habilis.worlds.chance import Chance


@dataclass(frozen=True, eq=False)
class Ledger:
    """What to add up over an episode, for every transition, numbered as in `Task`.

    Attributes:
        columns: float64[S*A*K, 2 + flags]: a step, its extrinsic reward, and the flags of the
            state that it leads to.
        terminated: bool[S*A*K].
    """

    columns: Float[np.ndarray, "transitions columns"]
    terminated: Bool[np.ndarray, "transitions"]

    @classmethod
    def of(cls, mdp: TabularMDP) -> "Ledger":
        chance = Chance.in_any(mdp)
        reached, reward = chance.next_state.reshape(-1), chance.reward.reshape(-1)
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

        A transition of -1 is a step that was not made.
        """
        made = transition >= 0
        ended = made & (truncated | self.terminated[transition])
        steps = np.where(made[..., None], self.columns[transition], 0.0)
        sums = np.cumsum(steps, axis=0) + running
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
