"""Every benchmark, for the page docs/explanation/performance.md.

    make performance                            # all of them, half an hour
    python -m research.performance growth       # some of them anew, the others as they are

Writes results/performance.csv, a line for each figure with the machine that it was measured on,
results/growth.csv and the picture beside the page. The page takes its tables from these files.
"""

import json
import platform
import subprocess
import sys
from datetime import date
from pathlib import Path

import numpy as np
import polars as pl
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from habilis.benchmarks import BENCHMARKS
from habilis.benchmarks.growth import AXES, Point, points
from habilis.colours import COLOURS
from habilis.processors import processors
from habilis.worlds.pictures.figures import save_figure

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "research" / "results" / "performance.csv"
GROWTH = ROOT / "research" / "results" / "growth.csv"
PICTURE = ROOT / "docs" / "explanation" / "growth.png"
APART = ROOT / ".venv-integration" / "bin" / "python"
"""Where Stable-Baselines3 is: `make .venv-integration/installed`."""
_FEW = 2_000  # up to which sizes are written out
LARGE = ("noise",)


def machine() -> str:
    """The processor, how many of its cores there are, and the versions that matter."""
    names = Path("/proc/cpuinfo")
    lines = names.read_text().splitlines() if names.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    name = models[0] if models else platform.processor()
    python = platform.python_version()
    return f"{name}, {processors()} cores, Python {python}, NumPy {np.__version__}"


def measured(benchmark: str) -> pl.DataFrame:
    """The lines of a benchmark, run by itself as a user would."""
    python = APART if benchmark == "sb3" else Path(sys.executable)
    large = ["--large"] if benchmark in LARGE else []
    command = [python, "-m", "habilis", "bench", benchmark, *large, "--json"]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE)
    lines = pl.DataFrame(json.loads(done.stdout)["results"], infer_schema_length=None)
    return lines.with_columns(
        pl.lit(benchmark).alias("benchmark"),
        pl.lit(machine()).alias("machine"),
        pl.lit(str(date.today())).alias("date"),
        *(pl.col(name).cast(pl.Float64) for name in ("value", "least", "most")),
    )


def keep(lines: pl.DataFrame, benchmark: str) -> None:
    """Replaces the lines of a benchmark in the file."""
    if RESULTS.exists():
        before = pl.read_csv(RESULTS).filter(pl.col("benchmark") != benchmark)
        lines = pl.concat([before.select(lines.columns), lines], how="vertical_relaxed")
    order = {name: place for place, name in enumerate(BENCHMARKS)}
    lines = lines.sort(pl.col("benchmark").replace_strict(order), maintain_order=True)
    lines.write_csv(RESULTS)


def growth_figure(found: list[Point]) -> Figure:
    """Curves of time and memory over each axis."""
    figure = Figure(figsize=(13, 11), layout="constrained")
    panels = figure.subplots(4, 4)
    for place, axis in enumerate(AXES):
        row, column = 2 * (place // 4), place % 4
        for of, ax in (("seconds", panels[row, column]), ("gib", panels[row + 1, column])):
            for colour, name in zip(COLOURS, axis.calls, strict=False):
                curve = [one for one in found if (one.axis, one.name) == (axis.name, name)]
                sizes = [one.size for one in curve]
                # Less than a mebibyte is not told apart from what the system rounds.
                values = [
                    one.seconds if of == "seconds" else max(one.gib or 0, 2**-10) for one in curve
                ]
                ax.loglog(sizes, values, marker="o", markersize=3, color=colour, label=name)
            if max(one.size for one in found if one.axis == axis.name) <= _FEW:
                ax.set_xscale("log", base=2)
                ax.xaxis.set_major_formatter("{x:g}")
            ax.yaxis.set_minor_formatter(NullFormatter())
            ax.set_xlabel(axis.name, fontsize=8)
            ax.set_ylabel("seconds" if of == "seconds" else "GiB", fontsize=8)
            ax.tick_params(labelsize=7)
            ax.spines[["top", "right"]].set_visible(False)
        panels[row, column].set_title(axis.task.replace(": ", ":\n"), fontsize=8, loc="left")
        panels[row, column].legend(fontsize=7, frameon=False)
    return figure


def main(names: list[str]) -> None:
    for name in names or BENCHMARKS:
        print(name, file=sys.stderr)
        if name == "growth":
            found = points(show_progress=True)
            pl.DataFrame([vars(one) for one in found]).with_columns(
                pl.lit(machine()).alias("machine"), pl.lit(str(date.today())).alias("date")
            ).write_csv(GROWTH)
            save_figure(growth_figure(found), PICTURE)
        else:
            keep(measured(name), name)


if __name__ == "__main__":
    main(sys.argv[1:])
