"""Target numbers of a map: what the paper states about it, as data in a file."""

import re
import tomllib
from dataclasses import dataclass, replace
from importlib.resources import files
from math import inf
from pathlib import Path
from typing import Any, TypeGuard

from habilis.studies.paper.worlds import OVER
from habilis.worlds.tools import OURS, TOOLS, Reading
from habilis.worlds.world import ENVIRONMENT, NO_TOOL

KINDS = {
    "steps": (),
    "return": (),
    "apart": ("of",),
    "average": ("sensor", "horizon", "against"),
    "landscape": (
        *("sensor", "horizon", "statistic", "around", "within", "beyond", "placed", "against"),
    ),
}
"""The kinds of target, each with its own keys besides `tool` and those that every target has."""
_CHOICES = {
    "kind": tuple(KINDS),
    "tool": (*TOOLS, NO_TOOL),
    "of": ("agent", "object"),
    "sensor": ("state", "agent", "tool", "object"),
    "statistic": ("most", "least", "mean", "rank"),
    "around": ("tool", "object", "goal"),
    "against": tuple(TOOLS),
}
_NAME = re.compile(r"[\w-]+")  # of maps, and so of the files in which they are written
_COMMON = ("kind", "text", "section", "tool", "value", "tolerance", "least", "most")


@dataclass(frozen=True)
class Target:
    """One stated number.

    Attributes:
        kind: "steps" and "return" of a shortest plan; "apart", the Manhattan distance of the tool
            to the agent, or to what `of` names, at the start; "average" empowerment; or a
            "landscape", of which `statistic` over some cells is meant.
        text: its meaning, in words.
        section: where it is stated.
        tool: the tool that takes the place of the map's own; "" for that.
        of: "agent" or "object": whose distance to the tool is meant.
        sensor, horizon: of empowerments.
        against: another tool, whose average is subtracted, or from whose landscape the absolute
            difference is meant; "" for none.
        statistic: "most", "least" or "mean" over the cells of a landscape; or "rank", the share of
            all its cells whose values are not above the most of these.
        around: the thing around which the cells are, "tool", "object" or "goal"; "" for all cells.
        within, beyond: the largest distance of a cell to that thing, and the largest that is too
            near; Manhattan.
        placed: whether tool and object are put side by side (`CachedWorld.side_by_side`), and only
            agent cells from which the tool is in hand are considered.
        value, tolerance: what is stated, and how far off still meets it; no value where `least`
            and `most` say it.
        least, most: bounds; both included.
    """

    kind: str
    text: str
    section: str = ""
    tool: str = ""
    of: str = "agent"
    sensor: str = "object"
    horizon: int = 0
    against: str = ""
    statistic: str = "most"
    around: str = ""
    within: float = inf
    beyond: int = -1
    placed: bool = False
    value: float | None = None
    tolerance: float = 0.0
    least: float = -inf
    most: float = inf

    @property
    def bounds(self) -> tuple[float, float]:
        """The least and the largest number that meets it."""
        if self.value is None:
            return self.least, self.most
        return self.value - self.tolerance, self.value + self.tolerance

    @property
    def published(self) -> str:
        """The bounds as text: the value, or at least and at most what."""
        if self.value is not None:
            return f"{self.value:g}"
        low, high = self.bounds
        if low == high:
            return f"{low:g}"
        words = [f"{sign} {bound:g}" for sign, bound in ((">=", low), ("<=", high))]
        return ", ".join(word for word in words if "inf" not in word)

    @property
    def unit(self) -> str:
        return {"steps": "steps", "apart": "steps", "return": ""}.get(self.kind, "bits")

    def miss(self, number: float) -> float:
        """The distance of a number from the bounds; 0 if it meets them."""
        low, high = self.bounds
        slack = 1e-9  # of the tolerance's own rounding
        return 0.0 if low - slack <= number <= high + slack else max(low - number, number - high)


@dataclass(frozen=True)
class TargetMap:
    """The targets of one map.

    Attributes:
        name: what maps that meet it are called: the list's own name, unless it gives another.
        height, width: of the map.
        tool: the map's own tool.
        walls: about how many cells are walls where a search begins.
        numbers: the targets that it has to meet.
        source: the list's own name.
        reading: of the rules by which its tools move.
        over: the states over which averages go, one of `worlds.OVER`.
    """

    name: str
    height: int
    width: int
    tool: str
    walls: int
    numbers: tuple[Target, ...]
    source: str = ""
    reading: Reading = OURS
    over: str = OVER[0]


def target_names() -> list[str]:
    """The names of the lists that come with the package."""
    return sorted(file.name.removesuffix(".toml") for file in _folder().iterdir())


def load_targets(name: str | Path) -> TargetMap:
    """A list of stated numbers, by its name or from a TOML file.

    Args:
        name: "corridor", "yard", "yard-apart", or the path of a file laid out as theirs.

    Raises:
        ValueError: no such list, or one that cannot be read; the message names the entry and the
            fix.

    Example:
        >>> load_targets("corridor").numbers[0].value
        15
    """
    if str(name) in target_names():
        return parse_targets((_folder() / f"{name}.toml").read_text("utf-8"), str(name))
    path = Path(name)
    try:
        return parse_targets(path.read_text("utf-8"), path.stem)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not text"
        if str(name).startswith(ENVIRONMENT):
            reason = "it is a Gymnasium environment"
        raise ValueError(
            f"{str(name)!r}: no such list of stated numbers ({reason}); name one of "
            f"{', '.join(target_names())}, or the path of a TOML file"
        ) from error


_ENTRIES = "give one [map], and a [[number]] for each stated number"


def parse_targets(text: str, name: str = "list") -> TargetMap:
    """Reads a list of stated numbers: `[map]`, and `[[number]]` for each.

    Raises:
        ValueError: it is no TOML, or has an entry that cannot be.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{name}: not a TOML file ({error}); {_ENTRIES}") from error
    head, entries = data.get("map"), data.get("number")
    if isinstance(head, dict) and (like := head.get("like")) is not None:
        return _like(name, head, like, entries)
    if set(data) != {"map", "number"} or not isinstance(head, dict) or not _are_tables(entries):
        raise ValueError(f"{name}: has {', '.join(data) or 'nothing'}; {_ENTRIES}")
    sizes = ("height", "width", "walls")
    named: dict[str, Any] = {"name": name} | head
    if set(named) != {*sizes, "tool", "name"} or any(_bad(int, named[size]) for size in sizes):
        raise ValueError(
            f"{name}: [map] needs height, width and walls (whole numbers), and tool; it may have "
            "name, no more"
        )
    _called(name, named["name"])
    _check_choice(f"{name}, [map]", "tool", named["tool"])
    most = named["height"] * named["width"] - 4
    if min(named["height"], named["width"]) < 1 or not 0 <= named["walls"] <= most:
        raise ValueError(
            f"{name}: {named['walls']} walls on {named['height']} x {named['width']} cells leave "
            f"no room; give 0 to {max(most, 0)}, or a larger map"
        )
    numbers = [
        _stated(f"{name}, number {i}", entry, named) for i, entry in enumerate(entries, start=1)
    ]
    return TargetMap(**named, numbers=tuple(numbers), source=name)


def _like(name: str, head: dict[str, Any], like: Any, entries: Any) -> TargetMap:
    """A list that has all of a built-in one, and more."""
    if set(head) - {"like", "name"} or like not in target_names() or not _are_tables(entries):
        raise ValueError(
            f"{name}: [map] is like {like!r}; name one of {', '.join(target_names())}, leave all "
            f"else but the name to that list, and give a [[number]] for each further number"
        )
    first = load_targets(like)
    more = [
        _stated(f"{name}, number {i}", entry, {"tool": first.tool})
        for i, entry in enumerate(entries, start=1)
    ]
    called = _called(name, head.get("name", first.name))
    return replace(first, name=called, numbers=(*first.numbers, *more), source=name)


def _called(name: str, wanted: Any) -> str:
    if not isinstance(wanted, str) or not _NAME.fullmatch(wanted):
        raise ValueError(
            f"{name}: [map] has the name {wanted!r}; give letters, digits, '-' and '_'"
        )
    return wanted


def _are_tables(entries: Any) -> TypeGuard[list[dict[str, Any]]]:
    return isinstance(entries, list) and bool(entries) and all(isinstance(e, dict) for e in entries)


def _stated(place: str, entry: dict[str, Any], head: dict[str, Any]) -> Target:
    _check_choice(place, "kind", entry.get("kind"))
    kind = entry["kind"]
    known = (*_COMMON, *KINDS[kind])
    for word, value in entry.items():
        if word not in known:
            raise ValueError(f"{place}: {word!r} does not apply to {kind}; use {', '.join(known)}")
        if word in _CHOICES:
            _check_choice(place, word, value)
        elif _bad(_TYPES[word], value):
            raise ValueError(f"{place}: {word} is {value!r}; give a {_WANTED[_TYPES[word]]}")
    for word in ("text", *(word for word in ("sensor", "horizon") if word in known)):
        if word not in entry:
            raise ValueError(f"{place}: has no {word}; give one")
    target = Target(**entry)
    low, high = target.bounds
    bounded = target.least > -inf or target.most < inf
    if bounded == (target.value is not None) or low > high or target.tolerance < 0:
        raise ValueError(
            f"{place}: give a value with a tolerance from 0 up, or else least or most, "
            "the least not above the most"
        )
    tool = target.tool or head["tool"]
    if tool == NO_TOOL and (
        kind == "apart" or target.placed or "tool" in (target.sensor, target.around)
    ):
        raise ValueError(f"{place}: refers to a tool, but there is none; name one as tool")
    if target.tool not in ("", NO_TOOL) and head["tool"] == NO_TOOL:
        raise ValueError(f"{place}: the map has no place for a {target.tool}; give [map] a tool")
    if target.horizon < 0:
        raise ValueError(f"{place}: horizon is {target.horizon}; give 0 or more")
    return target


def _check_choice(place: str, word: str, value: Any) -> None:
    if value not in _CHOICES[word]:
        raise ValueError(f"{place}: {word} is {value!r}; use one of {', '.join(_CHOICES[word])}")


def _bad(kind: type, value: Any) -> bool:
    if kind is float:
        return not isinstance(value, int | float) or isinstance(value, bool) or value != value
    return not isinstance(value, kind) or (kind is int and isinstance(value, bool))


_TYPES: dict[str, type] = {
    "text": str,
    "section": str,
    "horizon": int,
    "within": int,
    "beyond": int,
    "placed": bool,
    "value": float,
    "tolerance": float,
    "least": float,
    "most": float,
}
_WANTED = {str: "text", int: "whole number", bool: "true or false", float: "number"}


def _folder():
    return files("habilis.studies") / "data" / "targets"
