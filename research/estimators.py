"""How good estimators of empowerment are: all of the package in every case of the suite.

    python -m research.estimators          # results/estimators.csv, ten minutes of processor time
    python -m research.estimators states   # results/variational_states.csv, a minute

The first table is what `habilis estimators --out estimators.csv` writes. The page
docs/explanation/estimators.md has its summary and the picture. The second is the variational bound
of the can in the yard, trained on other states.
"""

import sys
import time
from pathlib import Path

import numpy as np
import polars as pl

import habilis as hb
from habilis.estimators import RandomSequences, Variational, contestants
from habilis.estimators.evaluation.picture import evaluation_figure
from habilis.files import write_whole
from habilis.statistics import spearman
from habilis.worlds.pictures.figures import save_figure

RESULTS = Path(__file__).parent / "results" / "estimators.csv"
PICTURE = Path(__file__).parents[1] / "docs" / "explanation" / "estimators.png"


def as_table(results: pl.DataFrame) -> str:
    """The rows of the page's table: medians over the cases that an estimator has values in."""
    lines = []
    for name in results["estimator"].unique(maintain_order=True):
        some = results.filter(pl.col("estimator") == name, pl.col("bias").is_not_null())
        ranks = some["rank"].drop_nulls().to_numpy()
        bias = some["bias"].to_numpy()
        cells = [
            name,
            f"{len(some)} of {results['case'].n_unique()}",
            f"{_signed(np.median(bias))} ({_signed(bias.min())} to {_signed(bias.max())})",
            f"{np.median(some['rmse'].to_numpy()):.2f}",
            f"{np.median(ranks):.2f} ({ranks.min():.2f})".replace("-", "−") if len(ranks) else "–",
            f"{np.median(some['steps'].to_numpy()):,.0f}",
            f"{np.median(some['seconds'].to_numpy()):.1f}",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _signed(value: float) -> str:
    return "0.00" if abs(value) < 0.005 else f"{value:+.2f}".replace("-", "−")


def trained_on_states(rounds: int = 300) -> pl.DataFrame:
    """The variational bound of the can in the yard, by what it was trained on."""
    (case,) = hb.suite(["yard-object"])
    pool = case.simulator.random_states(4000, np.random.default_rng(0))  # pyright: ignore[reportAttributeAccessIssue]
    influence = RandomSequences(300).fit(case.simulator, case.horizon, case.sensor).bits(pool)
    chosen = {
        "random": None,
        "random, any influence": pool[influence > 0],
        "random, most influence": pool[influence >= np.quantile(influence, 0.95)],
        "those asked about": case.states,
    }
    rows = []
    for name, states in chosen.items():
        method = Variational(rounds=rounds, patience=rounds, samples=400, states=states)
        bits = method.fit(case.simulator, case.horizon, case.sensor).bits(case.states)
        row = {"trained on": name, "rounds": rounds, "truth": case.bits.mean()}
        ranks = spearman(bits.round(5)[None], case.bits.round(5)[None])
        rows.append(row | {"bits": bits.mean(), "rank": float(ranks[0])})
    return pl.DataFrame(rows)


def states() -> None:
    found = trained_on_states()
    write_whole(RESULTS.parent / "variational_states.csv", found.write_csv)
    print(found)


def main() -> None:
    start = time.perf_counter(), time.process_time()
    results = hb.evaluate(contestants(), hb.suite(), seeds=3, show_progress=True)
    results.write_csv(RESULTS)
    save_figure(evaluation_figure(results), PICTURE)
    print(as_table(results))
    taken = time.perf_counter() - start[0], time.process_time() - start[1]
    print(f"{taken[0] / 60:.1f} minutes, {taken[1] / 60:.1f} of processor time")


if __name__ == "__main__":
    {"states": states}.get(" ".join(sys.argv[1:]), main)()
