"""The second part of the report, from training to page.

python -m research.multiverse --out docs/multiverse --work multiverse
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl

from habilis.empowerment.api import empowerment
from habilis.learning.convergence import MARGIN
from habilis.statistics import (
    interquartile_interval,
    pooled_interquartile_interval,
    superiority_interval,
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
    Condition,
    paper_rows,
)

_INTERVAL = ("middle", "low", "high")


@dataclass(frozen=True, eq=False)
class Multiverse:
    """The data of the second part.

    Attributes:
        runs: a row per run of every condition (`settings.Condition`), with its results.
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
    def of(cls, runs: pl.DataFrame) -> "Multiverse":
        return cls(
            runs=runs,
            multiverse=claims.multiverse(runs.filter(part="multiverse")),
            maps=claims.on_maps(runs.filter(part="maps")),
            optima=optima(),
            rows=rows(runs.filter(part="shaping")),
        )

    @classmethod
    def read(cls, folder: Path) -> "Multiverse":
        """The data that `report.write_study` wrote; the runs without their learning curves."""
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


def joined(agents: list[Condition], results: pl.DataFrame) -> pl.DataFrame:
    """The results of a sweep over conditions, with the columns that name each condition."""
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
    """The optimal policies for the regularised rewards of the multiverse, exactly."""
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
        verdict = claims.verdict(part, vanilla, "episodes")
        row |= {"converged": int(np.isfinite(counts).sum()), "runs": len(counts)}
        row |= dict(zip(_INTERVAL, interquartile_interval(counts), strict=True))
        low, high = superiority_interval(counts, bare)
        row |= {
            "superiority": verdict.superiority,
            "superiority_low": low,
            "superiority_high": high,
        }
        found.append(row | {"p": verdict.p, "final_return": part["final_return"].median()})
    return pl.DataFrame(found, infer_schema_length=None)


def aggregate(runs: pl.DataFrame) -> pl.DataFrame:
    """Over all the paper's worlds and tools together, as rliable pools tasks.

    The score of a run is its episodes to first success (`claims.counts`) over the mean of the
    vanilla agent's in the same world with the same tool. Not those to convergence: these have no
    mean where a run exceeded its budget.

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
        interval = pooled_interquartile_interval(tasks)
        found.append({"agent": how} | dict(zip(_INTERVAL, interval, strict=True)))
    return pl.DataFrame(found, schema_overrides=dict.fromkeys(_INTERVAL, pl.Float64))


def paper_curves(runs: pl.DataFrame) -> dict[str, dict[str, np.ndarray]]:
    """Learning curves of the paper's agents, by world and agent: float[runs, blocks].

    A run that has converged is carried on at its last value; the curves of an agent end where the
    first of its runs exceeds its budget.
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
    exceeded = [len(c) for c, at in zip(curves, runs["converged_at"], strict=True) if at is None]
    length = min(exceeded, default=max(map(len, curves)))
    return np.stack([np.pad(c, (0, max(0, length - len(c))), mode="edge")[:length] for c in curves])


def _paper_betas() -> dict[tuple[str, str, str], float]:
    """By world, tool and reward."""
    return {(world, tool, reward): beta for world, tool, reward, _, beta in paper_rows()}
