"""How good estimators of empowerment are: all of the package in every case of the suite.

    python -m research.estimators     # twelve minutes of one processor: results/estimators.csv

The same table is what `habilis estimators --out estimators.csv` writes. The page
docs/explanation/estimators.md has its summary and the picture.
"""

from pathlib import Path

import numpy as np
import polars as pl

import habilis as hb
from habilis.estimators import contestants
from habilis.estimators.evaluation.picture import evaluation_figure
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


def main() -> None:
    results = hb.evaluate(contestants(), hb.suite(), seeds=3, show_progress=True)
    results.write_csv(RESULTS)
    save_figure(evaluation_figure(results), PICTURE)
    print(as_table(results))


if __name__ == "__main__":
    main()
