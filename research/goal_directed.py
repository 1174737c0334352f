"""Whether goal-directed empowerment keeps its gain near the goal, where plain empowerment is low.

Ten runs of the default learner in the corridor with each bonus, beta = 0.07 as in the paper:

    python -m research.goal_directed          # five minutes: results/goal_directed.csv

The page docs/explanation/kinds.md has the medians.
"""

from pathlib import Path

import numpy as np
import polars as pl

import habilis as hb
from habilis.learning.runs import Run

RESULTS = Path(__file__).parent / "results" / "goal_directed.csv"
RUNS, EPISODES, NEAR = 10, 30_000, -40.0
BONUSES = {
    "none": {},
    "5-step FOE": {"intrinsic": "state", "horizon": 5},
    "goal-directed 5-step FOE": {"intrinsic": "goal-directed:state", "horizon": 5},
    "6-step TOE": {"intrinsic": "object", "horizon": 6},
    "goal-directed 6-step TOE": {"intrinsic": "goal-directed:object", "horizon": 6},
}


def config(bonus: str) -> hb.Config:
    """The runs with a bonus."""
    settings = BONUSES[bonus]
    return hb.Config(
        world="corridor", runs=RUNS, episodes=EPISODES, beta=0.07 * bool(settings), **settings
    )


def rows(bonus: str, run: Run) -> pl.DataFrame:
    """One row a run: when its mean return comes near to the best one, and when it converges."""
    found = []
    for number, episodes in sorted(run.episodes.group_by("run"), key=lambda pair: pair[0]):
        returns = episodes.sort("episode")["return"].to_numpy()
        mean = np.convolve(returns, np.full(100, 0.01), "valid")
        near = np.flatnonzero(mean >= NEAR)
        found.append(
            {
                "bonus": bonus,
                "run": number[0],
                "near": int(near[0]) if len(near) else None,
                "converged_at": run.converged_at[int(str(number[0]))],
            }
        )
    return pl.DataFrame(found, schema_overrides={"converged_at": pl.Int64, "near": pl.Int64})


def as_table(results: pl.DataFrame) -> str:
    """The rows of the page's table: medians, runs that never get there counted as infinite."""
    lines = []
    for bonus in BONUSES:
        some = results.filter(pl.col("bonus") == bonus)
        cells = [bonus]
        for column in ("near", "converged_at"):
            values = [np.inf if one is None else one for one in some[column]]
            middle = float(np.median(values))
            cells.append(f"{middle:,.0f}" if np.isfinite(middle) else "–")
        cells.append(f"{some['converged_at'].count()} of {len(some)}")
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    each = [rows(bonus, hb.train(config(bonus))) for bonus in BONUSES]
    results = pl.concat(each)
    results.write_csv(RESULTS)
    print(as_table(results))


if __name__ == "__main__":
    main()
