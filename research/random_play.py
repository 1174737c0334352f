"""Random play in each world of the second experiment, exactly.

    python -m research.random_play        # writes research/results/random_play.csv

A vanilla agent begins as a random one. If random play nearly never reaches the goal within an
episode, or nearly always brings the can to where the tool cannot fetch it, there is nothing to
learn from. What happens within 500 steps is a product of matrices; nothing is sampled.
"""

from pathlib import Path

import numpy as np
import polars as pl
from scipy.sparse import csr_array

from habilis.files import write_whole
from habilis.mdp import TabularMDP
from habilis.studies.maps import MAPS
from habilis.worlds.plans import distances
from habilis.worlds.table import tabulate
from habilis.worlds.world import load_world

RESULTS = Path(__file__).parent / "results" / "random_play.csv"
STEPS = 500


def random_play(mdp: TabularMDP, steps: int = STEPS) -> tuple[float, float]:
    """The outcome of uniformly random actions from the start of a deterministic world.

    Returns:
        The probabilities that the goal is reached within so many steps, and that it can no longer
        be reached after them.
    """
    states, actions = mdp.next_state.shape
    leaves = np.repeat(np.arange(states), actions)
    shares = np.full(states * actions, 1 / actions)
    step = csr_array((shares, (mdp.next_state.reshape(-1), leaves)), shape=(states, states))
    there, reached = np.zeros(states), 0.0
    there[mdp.start] = 1.0
    for _ in range(steps):
        there = step @ there
        reached += float(there[mdp.terminal].sum())
        there[mdp.terminal] = 0.0
    lost = (distances(mdp) < 0) & ~mdp.terminal
    return reached, float(there[lost].sum())


def table() -> pl.DataFrame:
    """A row for each yard: with picker and broom, the goal reached, and out of reach."""
    worlds = ["yard", "yard-b", *map(str, sorted(MAPS.glob("yard-*.txt")))]
    rows = []
    for name in worlds:
        row: dict[str, object] = {"world": Path(name).stem}
        for tool in ("picker", "broom"):
            reached, lost = random_play(tabulate(load_world(name, tool)))
            row |= {f"{tool}_reached": round(reached, 5), f"{tool}_lost": round(lost, 5)}
        rows.append(row)
    return pl.DataFrame(rows)


if __name__ == "__main__":
    found = table()
    write_whole(RESULTS, found.write_csv)
    print(found)
