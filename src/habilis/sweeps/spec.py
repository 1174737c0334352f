"""The specification of a sweep: a SPEC.toml.

[config]                                    any settings, as `habilis train` has them
preset = "book-cartpole"                    or a preset and what differs from it
world = "yard"
runs = 10

[grid]                                      every combination of these
beta = [0.05, 0.08]
"intrinsic, horizon" = [["state", 2], ["object", 3]]      these two vary together

[search]                                    or: a search among these, by Optuna
minimise = "mean_episodes"
trials = 30
seed = 0
at_once = 4
learning_rate = {low = 1e-4, high = 1e-2, log = true}
envs = [8, 16]
"""

import datetime
import itertools
import json
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import polars as pl

from habilis.learning.algorithms import ALGORITHMS
from habilis.learning.config import Config
from habilis.learning.presets import with_preset
from habilis.worlds.world import ENVIRONMENT

Values = dict[str, Any]
"""Settings by their names."""


@dataclass(frozen=True)
class Range:
    """Numbers from `low` to `high`, both included; whole ones for a setting that is whole."""

    low: float
    high: float
    log: bool = False


@dataclass(frozen=True)
class Search:
    """The objective and the space of a search.

    Attributes:
        space: by a setting's name, or several names with commas, a `Range` or the values to
            choose among (each of them a list, where there are several names).
        minimise: the name of an objective, see `OBJECTIVES`.
        trials: how many points to try.
        at_once: how many are chosen before the first of them has been looked at.
        seed: of the choices.
    """

    space: Mapping[str, Range | list[Any]]
    minimise: str = "mean_episodes"
    trials: int = 30
    at_once: int = 4
    seed: int = 0


@dataclass(frozen=True)
class Spec:
    """A sweep as it is written down.

    Attributes:
        config: the settings that all points share.
        varied: the names of those that differ.
        grid: the configurations of a grid, in order; empty for a search.
        search: what to search, if it is a search.
    """

    config: Values
    varied: tuple[str, ...]
    grid: tuple[Config, ...]
    search: Search | None

    def point(self, values: Values) -> Config:
        """The configuration with these values; see `point`."""
        return point(self.config, values)


def _mean_episodes(runs: pl.DataFrame) -> float:
    return float(runs.select(pl.col("converged_at").fill_null(pl.col("episodes"))).mean().item())


def _shortfall(runs: pl.DataFrame) -> float:
    worst = -pl.col("episode_limit").cast(pl.Float64)
    final = pl.when("finite").then(pl.col("final_return").fill_nan(worst)).otherwise(worst)
    return float(runs.select(pl.col("best_return") - final).mean().item())


OBJECTIVES: dict[str, Callable[[pl.DataFrame], float]] = {
    "mean_episodes": _mean_episodes,
    "shortfall": _shortfall,
}
"""Objectives to minimise, of the results of a point's runs: the mean of their episodes to
convergence, or of their budget where they did not converge; and how far the mean return of their
last 100 episodes is below that of a shortest plan."""


_WANTED = "give the path of a TOML file with [config], and [grid] or [search]"


def read_spec(path: str | Path) -> Spec:
    """Reads a SPEC.toml.

    Args:
        path: of the file.

    Returns:
        The sweep that it describes, checked.

    Raises:
        ValueError: it cannot be read, or names something that does not exist or cannot be; says
            where.
    """
    try:
        return _spec(tomllib.loads(Path(path).read_text("utf-8")))
    except OSError as error:
        reason = error.strerror or error
        if str(path).startswith(ENVIRONMENT):
            reason = "it is a Gymnasium environment"
        raise ValueError(f"{path}: cannot be read ({reason}); {_WANTED}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        reason = error if isinstance(error, tomllib.TOMLDecodeError) else "not text"
        raise ValueError(f"{path}: not a TOML file ({reason}); {_WANTED}") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def point(shared: Values, own: Values) -> Config:
    """A configuration from the settings that all points share, and its own.

    Raises:
        ValueError: they do not go together; says of which point that is.
    """
    try:
        return Config.from_dict(shared | own)
    except ValueError as error:
        named = ", ".join(
            f"{name} = {json.dumps(value, default=str)}" for name, value in own.items()
        )
        raise ValueError(f"at {named}: {error}" if own else str(error)) from None


def _spec(tables: Values) -> Spec:
    for name, table in tables.items():
        if name not in ("config", "grid", "search"):
            raise ValueError(f"{name!r} is unknown; use [config] and one of [grid], [search]")
        if not isinstance(table, dict):
            raise ValueError(f"{name} is {table!r}; make it a table, [{name}]")
        _refuse_dates(name, table)
    if ("grid" in tables) == ("search" in tables):
        both = "both [grid] and" if "grid" in tables else "neither [grid] nor"
        raise ValueError(f"has {both} [search]; give one of them")
    shared = dict(tables.get("config", {}))
    named = shared.pop("preset", None)
    _check_names("config", shared)
    own = "grid" if "grid" in tables else "search"
    how = {f.name: f.default for f in fields(Search) if f.name != "space"}
    options = {k: v for k, v in tables[own].items() if own == "search" and k in how}
    space = {name: value for name, value in tables[own].items() if name not in options}
    # `seed` in [search] is the search's own: runs are compared by the same random numbers.
    if not space:
        raise ValueError(f"[{own}] is empty; give a setting and its values, as beta = [0.05, 0.1]")
    varied: list[str] = []
    for names in space:
        varied += split(names)
    _check_names(own, varied)
    for name in varied:
        if varied.count(name) > 1:
            raise ValueError(f"[{own}] gives {name} twice; give it once")
        if name in shared:
            raise ValueError(f"{name} is in both [config] and [{own}]; give it in one of them")
    if named is not None:
        shared = with_preset(named, shared)
    if own == "search":
        for name, default in how.items():
            _check_option(name, options.get(name, default))
        read = {names: _range_or_values(names, value) for names, value in space.items()}
        spec = Spec(shared, tuple(varied), (), Search(read, **options))
        _check_an_end(spec)
        return spec
    listed = [
        [dict(zip(split(names), each, strict=True)) for each in _values("grid", names, value)]
        for names, value in space.items()
    ]
    combinations = itertools.product(*listed)
    grid = tuple(
        point(shared, {k: v for part in parts for k, v in part.items()}) for parts in combinations
    )
    return Spec(shared, tuple(varied), grid, None)


def _check_an_end(spec: Spec) -> None:
    """Refuses a search of which neither the first nor the last of all values go together."""
    assert spec.search is not None
    for last in (True, False):
        values: Values = {}
        for names, among in spec.search.space.items():
            if isinstance(among, Range):
                values[names] = among.high if last else among.low
            else:
                each = split(names)
                one = among[-1 if last else 0]
                values |= dict(zip(each, one if len(each) > 1 else [one], strict=True))
        try:
            spec.point(values)
            return
        except ValueError:
            if not last:
                raise


def split(names: str) -> list[str]:
    """The settings that vary together."""
    return [name.strip() for name in names.split(",")]


def default_of(name: str) -> Any:
    """The default of a setting, of the first algorithm that has it."""
    return _defaults()[name]


def _defaults() -> Values:
    kinds = reversed((Config, *ALGORITHMS.values()))
    return {f.name: f.default for kind in kinds for f in fields(kind)}


def _refuse_dates(where: str, value: Any) -> None:
    """TOML has dates and times; no setting is one."""
    if isinstance(value, datetime.date | datetime.time):
        raise ValueError(f"[{where}] has the date {value}; give a number, a string, true or false")
    for each in value.values() if isinstance(value, dict) else value:
        if isinstance(each, dict | list | datetime.date | datetime.time):
            _refuse_dates(where, each)


def _check_names(table: str, names: Any) -> None:
    for name in names:
        if name == "preset":
            raise ValueError(f"[{table}] has preset, which is for all points; give it in [config]")
        if name not in _defaults():
            raise ValueError(
                f"[{table}] has {name!r}, which is not a setting; use some of "
                f"{', '.join(sorted(_defaults()))}"
            )


def _check_option(name: str, value: Any) -> None:
    if name == "minimise":
        if not isinstance(value, str) or value not in OBJECTIVES:
            raise ValueError(f"minimise {value!r} is unknown; use one of {', '.join(OBJECTIVES)}")
    elif isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**32:
        raise ValueError(f"[search] {name} is {value!r}; give a whole number from 0 to 4294967295")
    elif name != "seed" and value < 1:
        raise ValueError(f"[search] {name} is {value!r}; give at least 1")


def _values(table: str, names: str, values: Any) -> list[list[Any]]:
    """For each choice the values of all names."""
    if not isinstance(values, list) or not values:
        raise ValueError(f"[{table}] {names} is {values!r}; give a list of at least one value")
    count = len(split(names))
    if count == 1:
        return [[value] for value in values]
    for value in values:
        if not isinstance(value, list) or len(value) != count:
            raise ValueError(
                f"[{table}] {names} has {value!r}; give lists of {count} values, one for each name"
            )
    return values


def _range_or_values(names: str, value: Any) -> Range | list[Any]:
    if not isinstance(value, dict):
        return [each if len(each) > 1 else each[0] for each in _values("search", names, value)]
    what = f"[search] {names}"
    numbers = {"low", "high"}
    if not numbers <= set(value) <= numbers | {"log"}:
        raise ValueError(f"{what} is {value!r}; give low, high and, if it is so, log = true")
    default = _defaults().get(names)
    if isinstance(default, bool) or not isinstance(default, int | float):
        raise ValueError(f"{what} has a range, but is not a number; give a list of values")
    kinds = int if isinstance(default, int) else (int, float)
    for end in sorted(numbers):
        if isinstance(value[end], bool) or not isinstance(value[end], kinds):
            whole = "whole " if kinds is int else ""
            raise ValueError(f"{what} has {end} = {value[end]!r}; give a {whole}number")
    if not isinstance(value.get("log", False), bool):
        raise ValueError(f"{what} has log = {value['log']!r}; give true or false")
    if not -1e30 < value["low"] < value["high"] < 1e30:
        raise ValueError(f"{what} goes from {value['low']} to {value['high']}; give low < high")
    if value.get("log") and value["low"] <= 0:
        raise ValueError(f"{what} has log = true and low = {value['low']}; give a low above 0")
    return Range(**value)
