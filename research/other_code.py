"""Public empowerment code beside exact values: docs/explanation/other-code.md.

The code of others is not ours to ship. Clone it, and name the clones:

    python -m research.other_code --empowerment CLONE --cem CLONE --ave CLONE

of github.com/Mchristos/empowerment (commit 3e47b67), github.com/Thaigun/cem-experiments (9b2df0f)
and github.com/yuqingd/ave (bae5961). A minute.
"""

import argparse
import contextlib
import io
import sys
import time
import types
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import polars as pl
from jaxtyping import Float, Int

import habilis as hb

RESULTS = Path(__file__).parent / "results" / "other_code.csv"
CHANNELS = {
    "binary symmetric, 0.1": [[0.9, 0.1], [0.1, 0.9]],
    "binary symmetric, 0.3": [[0.7, 0.3], [0.3, 0.7]],
    "Z, 0.5": [[1.0, 0.0], [0.5, 0.5]],
    "erasure, 0.5": [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5]],
}


def klyubin(maze: Any) -> Int[np.ndarray, "S A"]:
    """The walls of the maze in the README of Mchristos/empowerment, and its table."""
    walls = [((1, i), "N") for i in range(6)] + [((3, 6), "N")]
    walls += [((i + 2, j), "E") for i in range(2) for j in (5, 6)]
    walls += [((1, i + 7), "N") for i in range(2)] + [((5, i + 2), "N") for i in range(3)]
    walls += [((i + 6, 5), "W") for i in range(2)]
    walls += [((6, 4), "N"), ((7, 4), "N"), ((8, 4), "W"), ((8, 3), "N")]
    for cell, side in walls:
        maze.add_wall(cell, side)
    return maze.compute_model().argmax(axis=0).T.astype(np.int32)


def row(code: str, case: str, theirs: Any, exact: Any, ratio: float | None = None) -> dict:
    """One line of the results: the deviation over states or channels, in bits."""
    error = np.atleast_1d(np.asarray(theirs, float) - np.asarray(exact, float))
    return {
        "code": code,
        "case": case,
        "exact_mean": float(np.mean(exact)),
        "least_error": float(error.min()),
        "largest_error": float(error.max()),
        "wrong": float((abs(error) > 1e-3).mean()),
        "rank_correlation": rank_correlation(theirs, exact),
        "time_ratio": ratio,
    }


def rank_correlation(first: Any, second: Any) -> float | None:
    from scipy.stats import spearmanr

    if np.size(first) < 10 or np.ptp(first) == 0 or np.ptp(second) == 0:
        return None
    found: Any = spearmanr(np.ravel(first), np.ravel(second))
    return float(found.statistic)


def timed(call: Callable[[], Any]) -> tuple[Any, float]:
    """A value, and the seconds of a call."""
    start = time.perf_counter()
    value = call()
    return value, time.perf_counter() - start


def of_mchristos(clone: Path) -> Iterator[dict]:
    sys.path.insert(0, str(clone))
    from empowerment import compute_empowerment  # pyright: ignore[reportMissingImports]
    from empowerment.information_theory import (  # pyright: ignore[reportMissingImports]
        blahut_arimoto,
    )
    from empowerment.mazeworld import MazeWorld  # pyright: ignore[reportMissingImports]

    name = "Mchristos/empowerment"
    np.random.seed(0)
    for channel, P in CHANNELS.items():
        theirs = blahut_arimoto(np.array(P).T, epsilon=1e-6)
        yield row(name, f"capacity: {channel}", theirs, hb.capacity(P).bits)
    maze = MazeWorld(10, 10)
    mdp = hb.TabularMDP.deterministic(klyubin(maze))
    hb.empowerment(mdp, 1)  # compiled before it is timed
    for horizon in (5, 6, 10):
        theirs, slow = timed(lambda h=horizon: maze.compute_empowerment(n_step=h).ravel())
        exact, fast = timed(lambda h=horizon: hb.empowerment(mdp, h))
        yield row(name, f"maze, h = {horizon}", theirs, exact, slow / fast)
    noisy = maze.compute_model(det=0.8)
    exact = hb.empowerment(hb.TabularMDP.stochastic(noisy.transpose(2, 1, 0)), 2)
    theirs = maze.compute_empowerment(n_step=2, det=0.8).ravel()
    yield row(name, "maze, det = 0.8, h = 2", theirs, exact)
    theirs = [compute_empowerment(noisy, False, 2, s) for s in range(len(exact))]
    yield row(name, "the noisy table itself, h = 2", theirs, exact)


def without_imports(path: Path, *names: str) -> ModuleType:
    """A module of a clone, whose imports of simulators we lack do nothing."""
    module = types.ModuleType(path.stem)
    for name in names:
        sys.modules.setdefault(name, types.ModuleType(name))
    sys.modules["griddly"].gd = None  # pyright: ignore[reportAttributeAccessIssue]
    exec(compile(path.read_text("utf-8"), str(path), "exec"), module.__dict__)
    return module


def of_cem(clone: Path) -> Iterator[dict]:
    theirs = without_imports(clone / "empowerment_maximization.py", "gym", "griddly")
    name = "Thaigun/cem-experiments"

    def capacity(P: Float[np.ndarray, "X Y"]) -> float:
        rows = [{y: float(p) for y, p in enumerate(given) if p > 0} for given in P]
        inputs = theirs.blahut_arimoto(rows, np.random.default_rng(0))
        return float(theirs.mutual_information(inputs, rows))

    rng = np.random.default_rng(0)
    for inputs, outputs in ((4, 5), (64, 16), (1024, 64)):
        channels = rng.dirichlet(np.full(outputs, 0.1), size=(20, inputs))
        found, slow = timed(lambda several=channels: [capacity(P) for P in several])
        exact, fast = timed(lambda several=channels: [hb.capacity(P).bits for P in several])
        yield row(name, f"20 random channels {inputs} x {outputs}", found, exact, slow / fast)


def of_ave(clone: Path, maze_clone: Path) -> Iterator[dict]:
    sys.path.insert(0, str(maze_clone))
    from empowerment.mazeworld import MazeWorld  # pyright: ignore[reportMissingImports]

    module = types.ModuleType("emp_by_counting")
    source = clone / "empowerment_gridworld" / "emp_by_counting.py"
    exec(compile(source.read_text("utf-8"), str(source), "exec"), module.__dict__)
    next_state = klyubin(MazeWorld(10, 10))
    exact = hb.empowerment(hb.TabularMDP.deterministic(next_state), 10)
    columns = (
        np.arange(100).reshape(10, 10).T.ravel()
    )  # the same maze, its cells numbered by columns
    renumbered = np.empty_like(next_state)
    renumbered[columns] = columns[next_state]
    name = "yuqingd/ave"
    for samples in (100, 1000):
        found = counted(module, next_state, samples) / np.log(2)  # theirs is in nats
        yield row(name, f"maze, h = 10, {samples} sequences", found, exact)
    by_rows = counted(module, next_state, 1000, proxy=True)
    by_columns = counted(module, renumbered, 1000, proxy=True)[columns]
    yield row(name, "maze, h = 10, proxy", by_rows, exact)
    yield row(name, "maze, h = 10, proxy, cells numbered by columns", by_columns, exact)


def counted(
    module: ModuleType, next_state: Int[np.ndarray, "S A"], samples: int, proxy: bool = False
) -> Float[np.ndarray, "S"]:
    """Their count, or the variance that stands for it, on a table as their environment."""
    env = SimpleNamespace(action_space=SimpleNamespace(n=next_state.shape[1]), state=0)
    env.set_state = lambda state: setattr(env, "state", state)

    def step(action: int) -> tuple[int, float, bool, dict]:
        env.state = int(next_state[env.state, action])
        return env.state, 0.0, False, {}

    env.step = step
    np.random.seed(0)
    policy = module.EmpowermentCountingPolicy(env, 10, samples, estimate_emp=True, proxy=proxy)
    return np.array([policy.compute_n_step_empowerment(s) for s in range(len(next_state))])


def of_dit() -> Iterator[dict]:
    from dit.algorithms import channel_capacity

    rng = np.random.default_rng(0)
    for inputs, outputs in ((4, 5), (64, 16)):
        channels = rng.dirichlet(np.ones(outputs), size=(5, inputs))
        found, slow = timed(lambda several=channels: [channel_capacity(P)[0] for P in several])
        exact, fast = timed(lambda several=channels: [hb.capacity(P).bits for P in several])
        yield row("dit", f"5 random channels {inputs} x {outputs}", found, exact, slow / fast)


def as_table(results: pl.DataFrame) -> str:
    """The rows of the page's table."""
    lines = []
    for found in results.iter_rows(named=True):
        ends = [f"{found[key]:+.3f}" for key in ("least_error", "largest_error")]
        ends = list(dict.fromkeys("0" if float(end) == 0 else end for end in ends))
        rank, ratio = found["rank_correlation"], found["time_ratio"]
        cells = (
            found["code"].split("/")[-1],
            found["case"],
            f"{found['exact_mean']:.2f}",
            " to ".join(ends),
            f"{found['wrong']:.0%}",
            "" if rank is None else f"{rank:.2f}",
            "" if ratio is None else f"{ratio:,.0f}" if ratio >= 10 else f"{ratio:.1f}",
        )
        lines.append(f"| {' | '.join(cells)} |".replace("-0.", "−0.").replace("-1.", "−1."))
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    for name in ("empowerment", "cem", "ave"):
        parser.add_argument(f"--{name}", type=Path, required=True, metavar="CLONE")
    given = parser.parse_args(arguments)
    with contextlib.redirect_stderr(io.StringIO()):  # syntax warnings of the code of others
        rows = [
            *of_mchristos(given.empowerment),
            *of_cem(given.cem),
            *of_ave(given.ave, given.empowerment),
            *of_dit(),
        ]
    table = pl.DataFrame(rows)
    table.write_csv(RESULTS, float_precision=4)
    print(as_table(pl.read_csv(RESULTS)))


if __name__ == "__main__":
    main()
