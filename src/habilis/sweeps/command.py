"""`habilis sweep` on the terminal."""

from argparse import Namespace
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import polars as pl
from rich.console import Console
from rich.table import Table

from habilis.extras import import_from
from habilis.progress import progress_bar
from habilis.sweeps.grids import sweep
from habilis.sweeps.spec import Spec, read_spec
from habilis.sweeps.store import LAYOUT
from habilis.sweeps.training import TrainingTask, train_tasks
from habilis.tasks.local import processes
from habilis.tasks.task import Executor


def run(args: Namespace, show_progress: bool) -> dict[str, Any]:
    """Runs the sweep that the command line asks for.

    Returns:
        "points", a row a point with its settings, how many of its runs converged and their
        mean episodes; "out"; for a search also "best", the number of the best point.
    """
    spec = read_spec(args.spec)
    LAYOUT.check(args.out, args.resume)  # before a cluster is started
    best: dict[str, Any] = {}
    bar = progress_bar("tasks", show_progress, time_left=True)
    with _executor(args) as executor, bar as on_progress:
        how: Any = {"executor": executor, "resume": args.resume, "on_progress": on_progress}
        if spec.search is None:
            frame = sweep(spec.grid, args.out, **how)
        else:
            search = import_from("habilis.sweeps.searches", "sweep")
            frame = search.search(spec, args.out, **how)
            best["best"] = search.best_point(frame, spec.search.minimise)
    return {"points": summary(frame, spec).to_dicts(), **best, "out": str(args.out)}


def summary(frame: pl.DataFrame, spec: Spec) -> pl.DataFrame:
    """A summary of each point.

    Returns:
        One row a point: "point", the settings that differ, "runs", "converged", and
        "mean_episodes" of those that converged.
    """
    varied = [name for name in spec.varied if name in frame.columns and name != "runs"]
    return frame.group_by("point", *varied, maintain_order=True).agg(
        pl.len().alias("runs"),
        pl.col("converged_at").count().alias("converged"),
        pl.col("converged_at").mean().alias("mean_episodes"),
    )


def show(result: dict[str, Any]) -> None:
    """Prints the table."""
    table = Table(box=None)
    rows = result["points"]
    for name in rows[0]:
        table.add_column(name.replace("_", " "), justify="right")
    for row in rows:
        table.add_row(*map(_shown, row.values()))
    console = Console(highlight=False)
    console.print(table)
    if "best" in result:
        print(f"the best is point {result['best']}")
    print(f"written to {result['out']}")


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _executor(args: Namespace) -> AbstractContextManager[Executor[TrainingTask]]:
    if args.ray is not None and args.processes is not None:
        raise ValueError("--ray and --processes exclude each other; give one of them")
    if args.ray is not None:
        return import_from("habilis.tasks.cluster", "sweep").on_ray(args.ray)
    return nullcontext(train_tasks) if args.processes is None else processes(args.processes)
