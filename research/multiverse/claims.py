"""The verdict of each setting on each of the paper's claims."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import polars as pl
from jaxtyping import Float

from habilis.studies.comparison import Comparison, Outcome, compare
from habilis.studies.pace.data import first_success

MEASURES = ("episodes", "steps", "first success")
"""The measures: episodes to convergence, as in the paper; environment steps to convergence; or
episodes until a hundred of them first average at most twice the cost of the best one."""

KEYS = ("part", "learner", "map", "tool", "reward", "horizon", "beta", "how")
"""The columns that name a condition in the results."""


@dataclass(frozen=True)
class Claim:
    """An order of two agents that the paper states.

    Attributes:
        name: in a few words.
        sooner, later: what distinguishes the two agents, by the columns of the results; the rest
            of the setting is the same.
    """

    name: str
    sooner: dict[str, str]
    later: dict[str, str]


def _against_vanilla(world: str, tool: str, reward: str) -> Claim:
    where = {"map": world, "tool": tool}
    return Claim(
        f"{reward} before vanilla ({world}, {tool})",
        where | {"reward": reward},
        where | {"reward": "none"},
    )


CLAIMS = (
    _against_vanilla("corridor", "picker", "TOE"),
    _against_vanilla("corridor", "picker", "FOE"),
    Claim(
        "TOE before FOE (corridor)",
        {"map": "corridor", "reward": "TOE"},
        {"map": "corridor", "reward": "FOE"},
    ),
    _against_vanilla("yard", "picker", "TOE"),
    _against_vanilla("yard", "broom", "TOE"),
    Claim(
        "picker before broom, vanilla (yard)",
        {"map": "yard", "tool": "picker", "reward": "none"},
        {"map": "yard", "tool": "broom", "reward": "none"},
    ),
    Claim(
        "larger average TOE first, with TOE (yard)",
        {"map": "yard", "tool": "picker", "reward": "TOE"},
        {"map": "yard", "tool": "broom", "reward": "TOE"},
    ),
)
"""The picker's average TOE is the larger one on all maps and at all horizons here, so the last
claim is about the two tools as the one before; a test holds that fact."""


def counts(runs: pl.DataFrame, measure: str) -> Float[np.ndarray, "runs"]:
    """One of `MEASURES` for each run; infinite where a run exceeded its budget."""
    if measure == "first success":
        each = zip(runs["curve"], runs["best_return"], strict=True)
        return np.array([first_success(curve.to_numpy(), best) for curve, best in each])
    column = {"episodes": "converged_at", "steps": "steps_had"}[measure]
    values = runs[column].cast(pl.Float64).fill_null(np.inf).to_numpy()
    return np.where(runs["converged_at"].is_null().to_numpy(), np.inf, values)


def verdict(sooner: pl.DataFrame, later: pl.DataFrame, measure: str) -> Comparison:
    """Two agents' runs compared."""
    return compare(counts(sooner, measure), counts(later, measure))


def multiverse(results: pl.DataFrame) -> pl.DataFrame:
    """Every claim in every setting.

    Args:
        results: a row a run, of the part "multiverse", with the columns `KEYS`.

    Returns:
        A row for each claim, learner, horizon, beta and measure: "superiority", "p", "outcome" and
        how many runs stayed within their budget. A claim about vanilla agents alone has one setting
        per learner and measure (horizon and beta are null).
    """
    rows = []
    for claim in CLAIMS:
        sooner = _chosen(results, claim.sooner)
        later = _chosen(results, claim.later)
        for key, runs in sooner.group_by("learner", "horizon", "beta", maintain_order=True):
            learner, horizon, beta = key
            other = later.filter(pl.col("learner") == learner)
            if claim.later["reward"] != "none":
                other = other.filter(horizon=horizon, beta=beta)
            for measure in MEASURES:
                rows.append(
                    {"claim": claim.name, "learner": learner}
                    | _setting(claim, horizon, beta)
                    | {"measure": measure}
                    | _row(verdict(runs, other, measure))
                )
    return pl.DataFrame(rows, infer_schema_length=None)


def on_maps(results: pl.DataFrame) -> pl.DataFrame:
    """Every claim on every map, with the paper's horizons and betas.

    Args:
        results: as above, of the part "maps"; "map" is a map's name, such as "yard-03".

    Returns:
        A row for each claim and map of its world, as above.
    """
    rows = []
    for claim in CLAIMS:
        world = claim.sooner["map"]
        names = results["map"].unique().sort().to_list()
        for name in [name for name in names if name.startswith(world)]:
            sooner, later = (
                _chosen(results, side | {"map": name}) for side in (claim.sooner, claim.later)
            )
            for measure in MEASURES:
                ranks = verdict(sooner, later, measure)
                rows.append({"claim": claim.name, "map": name, "measure": measure} | _row(ranks))
    return pl.DataFrame(rows)


def shares(verdicts: pl.DataFrame, by: Sequence[str] = ()) -> pl.DataFrame:
    """In what share of the settings each claim holds, is undecided, or is the other way round.

    Args:
        verdicts: of `multiverse` or `on_maps`.
        by: columns to distinguish besides the claim.

    Returns:
        A row for each claim (and value of `by`): "settings", and the shares "holds", "undecided"
        and "opposite".
    """
    outcomes = [(pl.col("outcome") == o.value).mean().alias(o.value) for o in Outcome]
    grouped = verdicts.group_by("claim", *by, maintain_order=True)
    return grouped.agg(pl.len().alias("settings"), *outcomes)


def explained(verdicts: pl.DataFrame) -> pl.DataFrame:
    """Which choice decides a claim: how much of the superiority's variance each one explains.

    The share of the total sum of squares that lies between the values of one choice (eta squared);
    in a full grid these and what only their combinations explain add up to 1.

    Returns:
        A row for each claim, a column for each choice; null where a claim has no such choice.
    """
    choices = ("learner", "horizon", "beta", "measure")
    rows = []
    for (claim,), part in verdicts.group_by("claim", maintain_order=True):
        values = part["superiority"].to_numpy()
        total = np.square(values - values.mean()).sum()
        row: dict[str, object] = {"claim": claim}
        for choice in choices:
            groups = part.group_by(choice).agg(pl.col("superiority").mean(), pl.len())
            off = groups["superiority"].to_numpy() - values.mean()
            between = (groups["len"].to_numpy() * np.square(off)).sum()
            row[choice] = float(between / total) if len(groups) > 1 and total > 0 else None
        rows.append(row)
    return pl.DataFrame(rows, schema={"claim": pl.String} | dict.fromkeys(choices, pl.Float64))


def _setting(claim: Claim, horizon: int, beta: float) -> dict[str, object]:
    bare = claim.sooner["reward"] == "none"
    return {"horizon": None if bare else horizon, "beta": None if bare else beta}


def _chosen(results: pl.DataFrame, values: dict[str, str]) -> pl.DataFrame:
    return results.filter(**values)  # pyright: ignore[reportArgumentType]


def _row(ranks: Comparison) -> dict[str, object]:
    return {
        "superiority": ranks.superiority,
        "p": ranks.p,
        "outcome": ranks.outcome.value,
        "sooner_converged": ranks.sooner_converged,
        "later_converged": ranks.later_converged,
    }
