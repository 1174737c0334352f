"""The runs at the paper's pace that are checked in: `data/pace`.

Every number of the headline is read from these files, and none is needed: what is missing is
named in the report. `docs/how-to/paper.md` describes them.
"""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from jaxtyping import Float

from habilis.studies.paper.published import REWARDS, Experiment, Row

FOLDER = Path(__file__).parents[1] / "data" / "pace"

FILES = {
    "screen.csv": "the settings that were screened",
    "confirm.csv": "the settings that were confirmed, on all maps",
    "pairs.toml": "the five pairs of learner and maps, frozen before any agent with a bonus",
    "ensemble.csv": "the five pairs' agents",
    "thirty.csv": "30 runs of the best pair's agents",
    "compared.csv": "the fast default learner and those of the multiverse",
    "after.toml": "what was decided after agents with a bonus had been seen",
}
"""The content of each file, by its name."""

MEASURES = ("first success", "convergence")
"""The measures, in episodes: until a hundred of them first average at most twice the cost of the
best one, and to convergence by the paper's criterion."""

BLOCK = 100
"""Episodes over which the return is averaged for the first success."""

_COUNTS = {"first success": "first_success", "convergence": "episodes"}
_ROW = ("map", "tool", "reward", "horizon", "beta", "runs", "converged", *_COUNTS.values())


@dataclass(frozen=True, eq=False)
class AgentRuns:
    """The runs of one agent: a row of Table I or II, by one learner on one map.

    Attributes:
        map, tool: where it acts.
        reward: "none", "FOE" or "TOE".
        horizon, beta: of that reward.
        counts: float64[runs] by `MEASURES`, the episodes that each run took; infinite for one that
            exceeded its budget.
        had: float64[runs], episodes that each run had in all.
    """

    map: str
    tool: str
    reward: str
    horizon: int
    beta: float
    counts: Mapping[str, Float[np.ndarray, "runs"]]
    had: Float[np.ndarray, "runs"]

    @property
    def runs(self) -> int:
        return len(self.had)

    def came(self, measure: str = "convergence") -> int:
        """The number of runs that stayed within their budget."""
        return int(np.isfinite(self.counts[measure]).sum())

    def budgeted(self, measure: str = "convergence") -> Float[np.ndarray, "runs"]:
        """The episodes that each run took; for one that exceeded its budget, those it had."""
        counts = self.counts[measure]
        return np.where(np.isfinite(counts), counts, self.had)


@dataclass(frozen=True, eq=False)
class Learner:
    """A learner, the maps it was trained on, and its agents.

    Attributes:
        name: as pictures show it.
        source: "ensemble", "multiverse" or "fast default".
        maps: the name of its map, by the experiment's name ("table1", "table2").
        agents: rows of both tables, as far as they were trained.
    """

    name: str
    source: str
    maps: Mapping[str, str]
    agents: tuple[AgentRuns, ...]

    def agent(self, experiment: Experiment, row: Row) -> AgentRuns | None:
        """The agent of a row of the tables, if it was trained.

        Its horizon and weight may be other ones, where the learner's grid has only nearby ones.
        """
        key = (self.maps[experiment.name], row.tool, REWARDS[row.intrinsic])
        found = [a for a in self.agents if (a.map, a.tool, a.reward) == key]
        return found[0] if found else None


@dataclass(frozen=True)
class Pair:
    """A learner and a map of each world, frozen before any agent with a bonus was trained.

    Attributes:
        setting: its number in the calibration.
        maps: by the experiment's name.
        learner: fields of `Config`.
    """

    setting: int
    maps: Mapping[str, str]
    learner: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Pace:
    """All that is checked in, as far as it is there.

    Attributes:
        screened, confirmed: a row for each setting, map and tool, or `None`.
        pairs: the best one first; none: not frozen yet.
        ensemble: the pairs' agents.
        thirty: the best pair's agents, with more runs.
        compared: other learners.
        after: decisions made after agents with a bonus had been seen, a sentence each.
        missing: names of missing files.
    """

    screened: pl.DataFrame | None
    confirmed: pl.DataFrame | None
    pairs: tuple[Pair, ...]
    ensemble: tuple[Learner, ...]
    thirty: Learner | None
    compared: tuple[Learner, ...]
    after: tuple[str, ...]
    missing: tuple[str, ...]

    @property
    def best(self) -> Pair | None:
        """The pair of the headline."""
        return self.pairs[0] if self.pairs else None

    @cached_property
    def learners(self) -> tuple[Learner, ...]:
        """All of which there are agents."""
        return self.ensemble + self.compared


def first_success(curve: Float[np.ndarray, "blocks"], best_return: float) -> float:
    """Episodes until a learning curve first costs at most twice the best return; else infinite.

    Args:
        curve: the mean return over each `BLOCK` episodes.
        best_return: of a shortest plan; negative, as all returns.

    Example:
        >>> first_success(np.array([-90.0, -28.5, -28.0, -40.0]), -14.0)
        300.0
    """
    reached = np.flatnonzero(curve >= 2 * best_return)
    return float(BLOCK * (reached[0] + 1)) if len(reached) else np.inf


def load_pace(folder: Path = FOLDER) -> Pace:
    """Reads what is checked in.

    Args:
        folder: where the files are.

    Raises:
        ValueError: a file is damaged; the message names it and the place.

    Example:
        >>> pace = load_pace(Path("nowhere"))
        >>> pace.missing == tuple(FILES), pace.best, pace.learners
        (True, None, ())
    """
    there = {name: folder / name for name in FILES if (folder / name).is_file()}
    ensemble = _ensemble(there["ensemble.csv"]) if "ensemble.csv" in there else ()
    thirty = _ensemble(there["thirty.csv"]) if "thirty.csv" in there else ()
    if len(thirty) > 1:
        raise ValueError(f"{there['thirty.csv']}: has {len(thirty)} pairs; keep the best alone")
    return Pace(
        screened=_calibration(there.get("screen.csv")),
        confirmed=_calibration(there.get("confirm.csv")),
        pairs=_pairs(there["pairs.toml"]) if "pairs.toml" in there else (),
        ensemble=ensemble,
        thirty=thirty[0] if thirty else None,
        compared=_compared(there["compared.csv"]) if "compared.csv" in there else (),
        after=_after(there["after.toml"]) if "after.toml" in there else (),
        missing=tuple(name for name in FILES if name not in there),
    )


def _ensemble(path: Path) -> tuple[Learner, ...]:
    """The learners of `ensemble.csv` or `thirty.csv`, the best pair first."""
    learners = []
    for pair, rows in _groups(path, "pair", ("pair", "setting", "corridor", "yard", *_ROW)):
        maps = {"table1": str(rows[0]["corridor"]), "table2": str(rows[0]["yard"])}
        for row in rows:
            if row["map"] not in maps.values():
                raise ValueError(
                    f"{path}: pair {pair} has a row on {row['map']}, but its maps are "
                    f"{' and '.join(maps.values())}; correct one"
                )
        agents = tuple(_agent(path, f"pair {pair}", row) for row in rows)
        learners.append(Learner(f"pair {pair}", "ensemble", maps, agents))
    return tuple(learners)


def _compared(path: Path) -> tuple[Learner, ...]:
    learners = []
    for name, rows in _groups(path, "learner", ("learner", *_ROW)):
        first = next((r["map"] for r in rows if str(r["map"]).startswith("corridor")), "corridor")
        second = next((r["map"] for r in rows if str(r["map"]).startswith("yard")), "yard")
        agents = tuple(_agent(path, str(name), row) for row in rows)
        source = str(name) if name == "fast default" else "multiverse"
        learners.append(Learner(str(name), source, {"table1": first, "table2": second}, agents))
    return tuple(learners)


def _groups(
    path: Path, by: str, columns: Sequence[str]
) -> Iterator[tuple[object, list[dict[str, Any]]]]:
    """The rows of a file, those of a learner together, in the file's order of learners."""
    frame = _read(path, columns)
    for (key,), part in frame.group_by(by, maintain_order=True):
        yield key, part.to_dicts()


def _read(path: Path, columns: Sequence[str]) -> pl.DataFrame:
    names: list[str] = ["episodes", "first_success", "had", "steps"]
    counts = dict.fromkeys(names, pl.String)
    try:
        frame = pl.read_csv(path, schema_overrides=counts, infer_schema_length=None)
    except (OSError, pl.exceptions.PolarsError) as error:
        raise ValueError(f"{path}: cannot be read ({str(error).splitlines()[0]})") from None
    missing = [name for name in columns if name not in frame.columns]
    if missing:
        raise ValueError(f"{path}: has no column {missing[0]!r}; add it")
    return frame


def _agent(path: Path, learner: str, row: Mapping[str, Any]) -> AgentRuns:
    where = f"{path}: {learner}, {row['map']}, {row['tool']}, {row['reward']}"
    if row["reward"] not in REWARDS.values():
        raise ValueError(f"{where}: no such reward; use one of {', '.join(REWARDS.values())}")
    counts = {m: _numbers(where, row, column) for m, column in _COUNTS.items()}
    converged = int(np.isfinite(counts["convergence"]).sum())
    if converged != row["converged"]:
        raise ValueError(
            f"{where}: converged is {row['converged']}, but {converged} runs have episodes; "
            "correct one"
        )
    ended = counts["convergence"]
    had = ended if row.get("had") is None else _numbers(where, row, "had")
    if not np.isfinite(had).all():
        raise ValueError(
            f"{where}: a run that did not converge has no count in 'had'; give the episodes it had"
        )
    return AgentRuns(
        *(row["map"], row["tool"], row["reward"], int(row["horizon"]), float(row["beta"])),
        *(counts, had),
    )


def _numbers(where: str, row: Mapping[str, Any], column: str) -> Float[np.ndarray, "runs"]:
    """Counts with spaces between, "-" for infinite."""
    words = str(row[column]).split()
    if len(words) != row["runs"]:
        raise ValueError(
            f"{where}: {column} has {len(words)} counts for {row['runs']} runs; give one for each"
        )
    try:
        return np.array([np.inf if word == "-" else float(word) for word in words])
    except ValueError:
        raise ValueError(f"{where}: {column} is {row[column]!r}; give numbers and -") from None


def _calibration(path: Path | None) -> pl.DataFrame | None:
    columns = ("setting", "map", "tool", "runs", "converged", *_COUNTS.values())
    return None if path is None else _read(path, columns)


def _pairs(path: Path) -> tuple[Pair, ...]:
    pairs = []
    for number, entry in enumerate(_toml(path).get("pair", []), 1):
        missing = [k for k in ("setting", "corridor", "yard", "learner") if k not in entry]
        if missing:
            raise ValueError(f"{path}: pair {number} has no {missing[0]}; add it")
        maps = {"table1": entry["corridor"], "table2": entry["yard"]}
        fields = {k: tuple(v) if isinstance(v, list) else v for k, v in entry["learner"].items()}
        pairs.append(Pair(entry["setting"], maps, fields))
    if not pairs:
        raise ValueError(f"{path}: has no pair; begin each with [[pair]]")
    return tuple(pairs)


def _after(path: Path) -> tuple[str, ...]:
    decided = _toml(path).get("decided", [])
    if not isinstance(decided, list) or not all(isinstance(one, str) for one in decided):
        raise ValueError(f'{path}: decided is not a list of sentences; write decided = ["..."]')
    return tuple(decided)


def _toml(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read ({error})") from None
