"""The second part of the report, from training to page.

python -m research.multiverse --out docs/multiverse --work multiverse
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl

from habilis.empowerment.api import empowerment
from habilis.learning.convergence import MARGIN
from habilis.learning.intervals import (
    bootstrap_interval,
    interquartile_mean,
    stratified_interval,
)
from habilis.studies.paper.settings import frozen_settings
from habilis.worlds.plans import solve
from habilis.worlds.table import tabulate
from habilis.worlds.world import load_world
from research.multiverse import claims
from research.multiverse.optimum import return_of_the_best_policy
from research.multiverse.settings import (
    BETAS,
    HORIZONS,
    SENSORS,
    SHAPINGS,
    WORLDS,
    Agent,
    paper_rows,
)

_INTERVAL = ("middle", "low", "high")
_INFINITE = 1e30


@dataclass(frozen=True, eq=False)
class Study:
    """All that the second part says.

    Attributes:
        runs: a row a run of every agent (`settings.Agent`), with what it came to.
        multiverse, maps: `claims.multiverse`, `claims.on_maps`.
        optima: for each world, tool, reward, horizon and beta the extrinsic return of the best
            policy for the regularised reward, and the best there is.
        rows: the paper's rows, and the same agents with their bonus given in other ways: IQM of the
            episodes to convergence with its interval, beside vanilla.
    """

    runs: pl.DataFrame
    multiverse: pl.DataFrame
    maps: pl.DataFrame
    optima: pl.DataFrame
    rows: pl.DataFrame

    @classmethod
    def of(cls, runs: pl.DataFrame) -> "Study":
        return cls(
            runs=runs,
            multiverse=claims.multiverse(runs.filter(part="multiverse")),
            maps=claims.on_maps(runs.filter(part="maps")),
            optima=optima(),
            rows=rows(runs.filter(part="shaping")),
        )

    @classmethod
    def read(cls, folder: Path) -> "Study":
        """The data written by `report.write_study`; runs have no learning curves."""
        names = ("runs", "multiverse", "maps", "optima", "rows")
        return cls(**{n: pl.read_csv(folder / f"{n}.csv", infer_schema_length=None) for n in names})

    def changed(self) -> pl.DataFrame:
        """Claim, horizon and beta where the best policy is no longer good enough to converge."""
        lost = self.optima.filter(pl.col("best_policy") < pl.col("best_return") - MARGIN)
        found = []
        for claim in claims.CLAIMS:
            part = lost.filter(**claim.sooner)  # pyright: ignore[reportArgumentType]
            found.append(part.select(pl.lit(claim.name).alias("claim"), "horizon", "beta").unique())
        return pl.concat(found)


def joined(agents: list[Agent], results: pl.DataFrame) -> pl.DataFrame:
    """The results of a sweep over the agents, with the columns that identify an agent."""
    names = [{key: getattr(agent, key) for key in claims.KEYS} for agent in agents]
    keys = pl.DataFrame(names).with_row_index("point").cast({"point": pl.Int64})
    own = (
        "run",
        "converged_at",
        "episodes_had",
        "steps_had",
        "best_return",
        "final_return",
        "curve",
    )
    return keys.join(results.select("point", *own), on="point", maintain_order="left_right")


def optima() -> pl.DataFrame:
    """Optimal policies for the regularised rewards of the multiverse."""
    discount = frozen_settings()["discount"]
    found = []
    for world, tool, rewards in WORLDS:
        mdp = tabulate(load_world(world, tool))
        plan = solve(mdp)
        assert plan is not None
        for reward in rewards:
            for horizon in HORIZONS:
                bits = empowerment(mdp, horizon, SENSORS[reward])
                for beta in BETAS:
                    found.append(
                        {"map": world, "tool": tool, "reward": reward}
                        | {"horizon": horizon, "beta": beta}
                        | {"best_return": plan.best_return}
                        | {"best_policy": return_of_the_best_policy(mdp, bits, beta, discount)}
                    )
    return pl.DataFrame(found)


def rows(runs: pl.DataFrame) -> pl.DataFrame:
    """The paper's agents, their bonus given plainly, as a potential, and decaying.

    Args:
        runs: of the part "shaping".

    Returns:
        A row an agent: `claims.KEYS`, "converged" (of the runs), the interquartile mean of the
        episodes to convergence with its 95 % bootstrap interval ("middle", "low", "high"; null
        where too many runs exceeded their budget), "superiority" over the vanilla agent of its
        world and tool with its interval, "p", and "final_return", the median over the runs.
    """
    found = []
    for key, part in runs.group_by(*claims.KEYS, maintain_order=True):
        row = dict(zip(claims.KEYS, key, strict=True))
        vanilla = runs.filter(map=row["map"], tool=row["tool"], reward="none")
        counts, bare = (claims.counts(side, "episodes") for side in (part, vanilla))
        told = claims.verdict(part, vanilla, "episodes")
        row |= {"converged": int(np.isfinite(counts).sum()), "runs": len(counts)}
        row |= dict(zip(_INTERVAL, iqm(counts), strict=True))
        low, high = _superiority(counts, bare)
        row |= {"superiority": told.superiority, "superiority_low": low, "superiority_high": high}
        found.append(row | {"p": told.p, "final_return": part["final_return"].median()})
    return pl.DataFrame(found, infer_schema_length=None)


def aggregate(runs: pl.DataFrame) -> pl.DataFrame:
    """Over all the paper's worlds and tools together, as rliable pools tasks.

    The score of a run is its episodes to first success (`claims.counts`) over the mean of the
    vanilla agent's in the same world with the same tool. Not those to convergence: these have no
    mean if a run exceeded its budget.

    Returns:
        A row for "vanilla" and each way of giving TOE: the scores' IQM and its stratified interval.
    """
    found = []
    shaping = runs.filter(part="shaping")
    betas = _paper_betas()
    for how in ("vanilla", *SHAPINGS):
        tasks = []
        for world, tool, _ in WORLDS:
            here = shaping.filter(map=world, tool=tool)
            bare = claims.counts(here.filter(reward="none"), "first success")
            beta = betas[world, tool, "TOE"]
            mine = bare
            if how != "vanilla":
                toe = here.filter(reward="TOE", how=how, beta=beta)
                mine = claims.counts(toe, "first success")
            tasks.append(mine / bare.mean())
        row = {"agent": how} | dict(zip(_INTERVAL, pooled(tasks), strict=True))
        found.append(row)
    return pl.DataFrame(found, schema_overrides=dict.fromkeys(_INTERVAL, pl.Float64))


def pooled(tasks: list[np.ndarray]) -> tuple[float | None, float | None, float | None]:
    """The IQM of all scores and the ends of its stratified interval; null where infinite."""
    if not all(np.isfinite(task).any() for task in tasks):
        return None, None, None
    middle = float(interquartile_mean(np.concatenate(tasks)))
    low, high = stratified_interval([_large(task) for task in tasks])
    return _finite(middle), _finite(low), _finite(high)


def paper_curves(runs: pl.DataFrame) -> dict[str, dict[str, np.ndarray]]:
    """Learning curves of the paper's agents, by world and agent: float[runs, blocks].

    A run that has converged is carried on at its last value; the curves of an agent end where the
    first of its runs over budget ends.
    """
    shaping = runs.filter(part="shaping", how="plain")
    betas = _paper_betas()
    panels: dict[str, dict[str, np.ndarray]] = {}
    for world, tool, rewards in WORLDS:
        for reward in ("none", *rewards):
            beta = betas[world, tool, reward]
            part = shaping.filter(map=world, tool=tool, reward=reward, beta=beta)
            name = "vanilla" if reward == "none" else reward
            name = f"{name}, {tool}" if world == "yard" else name
            panels.setdefault(world, {})[name] = _together(part)
    return panels


def _together(runs: pl.DataFrame) -> np.ndarray:
    curves = [curve.to_numpy() for curve in runs["curve"]]
    given_up = [len(c) for c, at in zip(curves, runs["converged_at"], strict=True) if at is None]
    length = min(given_up, default=max(map(len, curves)))
    return np.stack([np.pad(c, (0, max(0, length - len(c))), mode="edge")[:length] for c in curves])


def _paper_betas() -> dict[tuple[str, str, str], float]:
    """By world, tool and reward."""
    return {(world, tool, reward): beta for world, tool, reward, _, beta in paper_rows()}


def iqm(counts: np.ndarray) -> tuple[float | None, float | None, float | None]:
    """The interquartile mean of counts and the ends of its interval, null where infinite.

    A run that exceeded its budget counts as infinite: it is among the upper quarter, or there is no
    mean.
    """
    low, high = bootstrap_interval(_large(counts), interquartile_mean)
    middle = float(interquartile_mean(counts))
    return _finite(middle), _finite(float(low)), _finite(float(high))


def _large(values: np.ndarray) -> np.ndarray:
    """A number that stands for infinity, as quantiles cannot be taken between infinities."""
    return np.where(np.isfinite(values), values, _INFINITE)


def _finite(value: float) -> float | None:
    return value if value < _INFINITE * 1e-6 else None


def _superiority(counts: np.ndarray, bare: np.ndarray) -> tuple[float, float]:
    """The interval of P(sooner than vanilla), runs of both resampled (rliable's improvement)."""
    random = np.random.default_rng(0)
    a = counts[random.integers(len(counts), size=(2000, len(counts)))]
    b = bare[random.integers(len(bare), size=(2000, len(bare)))]
    sooner = (a[:, :, None] < b[:, None]) + 0.5 * (a[:, :, None] == b[:, None])
    low, high = np.quantile(sooner.mean(axis=(1, 2)), [0.025, 0.975])
    return float(low), float(high)
