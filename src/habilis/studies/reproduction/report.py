"""The report: one page that needs nothing else."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import polars as pl

from habilis.files import write_whole
from habilis.studies.comparison import in_words, tally
from habilis.studies.pace.data import FILES, Pace, Pair
from habilis.studies.pace.ratios import one_by_one
from habilis.studies.pace.slowness import sentence
from habilis.studies.page import inlined, render
from habilis.studies.paper.published import EXPERIMENTS, Experiment
from habilis.studies.paper.settings import learner_settings
from habilis.studies.paper.tables import Result, row_orders, table
from habilis.studies.reproduction.result import Reproduction


def write_report(reproduction: Reproduction, folder: Path) -> None:
    """Writes `report.html` into the folder that holds the figures, which go into the page."""
    page = render(
        "report.html",
        reproduction=reproduction,
        summary=reproduction.summary(),
        verdicts=in_words(reproduction.verdicts),
        tables=[_section(e, reproduction.results[e.name], reproduction.pace) for e in EXPERIMENTS],
        settings=learner_settings(reproduction.pace.best),
        method=method_of(reproduction.pace),
        pairs=one_by_one(reproduction.pace.ensemble).to_dicts(),
        ensemble_verdicts=in_words(reproduction.ensemble_verdicts),
        sources=_sources(reproduction.pace),
        sentences=[sentence(found) for found in reproduction.associations],
        figure=lambda name: inlined(folder / f"{name}.svg"),
    )
    write_whole(folder / "report.html", lambda file: file.write(page.encode()))


def _section(experiment: Experiment, results: Sequence[Result], pace: Pace) -> dict[str, Any]:
    """One of the tables, and its pairs of rows."""
    orders = row_orders(experiment, results)
    return {
        "experiment": experiment,
        "rows": table(experiment, results, pace).to_dicts(),
        "world": results[0].map,
        "orders": orders,
        "verdicts": in_words(tally(c.outcome for c in orders)),
    }


def _sources(pace: Pace) -> dict[str, list[str]]:
    """The learners of the picture, by where they come from."""
    found: dict[str, list[str]] = {}
    for learner in pace.learners:
        found.setdefault(learner.source, []).append(learner.name)
    return found


@dataclass(frozen=True)
class Method:
    """The content of the method section.

    Attributes:
        screened, confirmed: these stages, in a phrase; `None` while they are missing.
        pairs: the frozen pairs: number, setting, maps, and the learner's fields in words.
        maps: of the best pair's setting, each vanilla row on every map it was confirmed on.
        after: decisions made after agents with a bonus had been seen.
        missing: the files that are missing, a phrase each.
    """

    screened: str | None
    confirmed: str | None
    pairs: Sequence[dict[str, Any]]
    maps: Sequence[dict[str, Any]]
    after: Sequence[str]
    missing: Sequence[str]


def method_of(pace: Pace) -> Method:
    """The method, as far as the files say it."""
    return Method(
        screened=_stage(pace.screened),
        confirmed=_stage(pace.confirmed),
        pairs=[_pair(number, pair) for number, pair in enumerate(pace.pairs, 1)],
        maps=_maps(pace.confirmed, pace.best),
        after=pace.after,
        missing=[f"{name} ({FILES[name]})" for name in pace.missing],
    )


def _stage(rows: pl.DataFrame | None) -> str | None:
    """The numbers of settings, of maps, and of runs of each vanilla agent, as a phrase.

    Example:
        >>> _stage(pl.DataFrame({"setting": [1, 1, 2], "map": ["a", "b", "a"], "runs": [5, 5, 5]}))
        '2 settings on 1 to 2 maps each, 5 runs of each vanilla agent'
    """
    if rows is None:
        return None
    maps: list[int] = rows.group_by("setting").agg(pl.col("map").n_unique())["map"].to_list()
    runs = " or ".join(str(n) for n in rows["runs"].unique().sort())
    where = " to ".join(map(str, sorted({min(maps), max(maps)})))
    what, each = ("" if count == "1" else "s" for count in (str(len(maps)), where))
    return (
        f"{len(maps):,} setting{what} on {where} map{each} each, {runs} runs of each vanilla agent"
    )


def _pair(number: int, pair: Pair) -> dict[str, Any]:
    maps = ", ".join(pair.maps[e.name] for e in EXPERIMENTS)
    fields = ", ".join(f"{name} {value}" for name, value in pair.learner.items())
    return {"pair": number, "setting": pair.setting, "maps": maps, "learner": fields}


def _maps(confirmed: pl.DataFrame | None, best: Pair | None) -> list[dict[str, Any]]:
    """The best setting's vanilla agents on every map: how much the choice of map changes."""
    if confirmed is None or best is None:
        return []
    rows = confirmed.filter(setting=best.setting).sort("map", "tool")
    found = []
    for row in rows.iter_rows(named=True):
        counts = [int(word) for word in row["episodes"].split() if word != "-"]
        counts = pl.Series(counts, dtype=pl.Float64)
        found.append(
            {name: row[name] for name in ("map", "tool", "converged", "runs")}
            | {"mean": counts.mean(), "deviation": counts.std()}
        )
    return found
