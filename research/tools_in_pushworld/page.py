"""The numbers of docs/explanation/tools-in-pushworld.md, as its sentences and tables have them."""

from collections.abc import Mapping

import polars as pl

from research.tools_in_pushworld.cases import asks
from research.tools_in_pushworld.losses import LADDER
from research.tools_in_pushworld.precision import CASE, verdicts

_COLUMNS = ("chance", "largest", "nearest", "nearest_along", "lost_fixed", "lost_removed")


def pieces(
    cases: pl.DataFrame, losses: pl.DataFrame, precision: pl.DataFrame, feasible: pl.DataFrame
) -> list[str]:
    """All that the page takes from the study's tables: tables and parts of sentences."""
    return [
        *_sentences(precision),
        *_obstacles(cases, losses),
        _counts(cases, feasible),
        _precision(precision),
        _answers(precision, ("lost_fixed", "lost_removed"), "nearest_along"),
        _answers(precision, ("fixed_first", "removed_first"), "nearest"),
        *_times(feasible),
        _feasible(feasible),
    ]


def _sentences(precision: pl.DataFrame) -> list[str]:
    every = {rule: _by_horizon(precision, rule, "all") for rule in _COLUMNS}
    spans = {rule: _span(its) for rule, its in every.items()}
    removed = _by_horizon(precision, "lost_removed", "answers")
    over = precision.filter(rule="lost_fixed", among="all")
    lead = pl.col("over_nearest_along_low").round(2) <= 0
    first = precision.filter(rule="fixed_first", horizon=12).sort("among")["puzzles"].to_list()
    return [
        f"in {spans['lost_fixed']} of the puzzles, by the horizon; chance is {spans['chance']}",
        f"the largest movable {spans['largest']}, the nearest {spans['nearest_along']}",
        f"right in {_span(removed)} of those",
        f"a lead of {_span(dict(enumerate(over['over_nearest_along'])))}",
        f"its interval reaches zero at {len(over.filter(lead))} of {len(over)} horizons",
        f"falls from {every['lost_removed'][3]:.2f} at horizon 3 to "
        f"{every['lost_removed'][16]:.2f} at 16",
        f"In {first[0] - first[1]} of the {first[0]} puzzles nothing is lost within 12 actions",
    ]


def _obstacles(cases: pl.DataFrame, losses: pl.DataFrame) -> list[str]:
    """How often it is a gain to remove the movable that is wrongly named, and one that is used."""
    found = verdicts(cases, losses)
    counted = found.select(*CASE, "horizon", right="lost_fixed")
    rows = losses.join(cases, on=[*CASE, "object"]).join(counted, on=[*CASE, "horizon"])
    wrong = rows.filter((pl.col("horizon") == 12) & (pl.col("right") < 1))
    named = wrong.filter(pl.col("lost_fixed") == pl.col("lost_fixed").max().over(CASE))
    named = named.filter(steps_through=0)
    harmless = named.filter(pl.col("lost_removed") <= 0)
    gained = {
        horizon: its.select((pl.col("lost_removed") < 0).mean()).item()
        for (horizon,), its in rows.filter(pl.col("steps_through") > 0).group_by("horizon")
    }
    return [
        f"of the {len(named)} unused movables that it names at horizon 12, "
        f"{len(harmless)} cost nothing",
        f"for {gained[3]:.0%} of the used movables at horizon 3, and for {gained[16]:.0%} at 16",
    ]


def _by_horizon(precision: pl.DataFrame, rule: str, among: str) -> dict[int, float]:
    rows = precision.filter(rule=rule, among=among)
    return dict(zip(rows["horizon"], rows["precision"], strict=True))


def _span(values: Mapping[int, float]) -> str:
    return f"{min(values.values()):.2f} to {max(values.values()):.2f}"


def _times(feasible: pl.DataFrame) -> list[str]:
    seconds = feasible["seconds_20"].drop_nulls()
    return [
        f"**{len(seconds)} of the {len(feasible)} puzzles**",
        f"in {seconds.median():.1f} seconds in the median and {seconds.max():.0f} in the longest",
    ]


def _counts(cases: pl.DataFrame, feasible: pl.DataFrame) -> str:
    """What is left of the puzzles."""
    every = dict(cases.filter("goal").group_by(CASE))
    using = [key for key, group in every.items() if group["steps_through"].sum()]
    asked = [key for key, group in every.items() if asks(group.to_dicts())]
    targets = int(feasible["targets"].sum())
    rows = [
        ("all of levels 1 and 2", len(feasible), targets),
        ("with another movable", len({key[:2] for key in every}), len(every)),
        ("the solution pushes the target through one", len({key[:2] for key in using}), len(using)),
        ("and not through all of them: counted", len({key[:2] for key in asked}), len(asked)),
    ]
    return _table(["", "puzzles", "targets"], [[name, *map(str, rest)] for name, *rest in rows])


def _precision(precision: pl.DataFrame) -> str:
    """Each rule's precision by the horizon."""
    words = ["chance", "largest", "nearest at first", "nearest along", "lost fixed", "lost removed"]
    rows = []
    for (horizon,), group in precision.filter(among="all").group_by("horizon", maintain_order=True):
        of = {row["rule"]: row for row in group.iter_rows(named=True)}
        cells = [_interval(of[rule]) for rule in _COLUMNS]
        rows.append([str(horizon), str(of["chance"]["puzzles"]), *cells])
    return _table(["h", "puzzles", *words], rows)


def _answers(precision: pl.DataFrame, rules: tuple[str, str], baseline: str) -> str:
    """In how many puzzles a loss answers, how well, and how much better than the nearest."""
    rows = []
    answered = precision.filter(among="answers")
    for (horizon,), group in answered.group_by("horizon", maintain_order=True):
        cells = [str(horizon)]
        for rule in rules:
            row = group.row(by_predicate=pl.col("rule") == rule, named=True)
            cells += [str(row["puzzles"]), _interval(row), _interval(row, f"over_{baseline}")]
        rows.append(cells)
    ends = ("puzzles", "precision", "above nearest")
    heads = [f"{kind}: {end}" for kind in ("fixed", "removed") for end in ends]
    return _table(["h", *heads], rows)


def _feasible(feasible: pl.DataFrame) -> str:
    """How many puzzles are feasible up to which horizon."""
    rows = []
    for horizon in LADDER:
        count = len(feasible.filter(pl.col("horizon") >= horizon))
        rows.append([str(horizon), str(count)])
    return _table(["horizon", "puzzles"], rows)


def _interval(row: dict[str, float], name: str = "precision") -> str:
    ends = ("low", "high") if name == "precision" else (f"{name}_low", f"{name}_high")
    if row[name] is None:
        return "–"
    numbers = (round(row[column], 2) + 0.0 for column in (name, *ends))  # no -0.00
    middle, low, high = (f"{number:.2f}".replace("-", "−") for number in numbers)
    return f"{middle} ({low} to {high})"


def _table(heads: list[str], rows: list[list[str]]) -> str:
    lines = [heads, ["---", *["--:"] * (len(heads) - 1)], *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
