"""The grammar of Cassandra's format: what a file declares, and its entries in their order."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Float64

from habilis.bridges.cassandra.words import RESERVED, Words, is_index, is_number
from habilis.files import shown

Kind = Literal["T", "O", "R"]

ROUNDING = 1e-5  # by how much a distribution may miss 1
_MOST = 1_000_000  # states, actions or observations
_LISTED = 8  # names in a message


@dataclass(frozen=True)
class Names:
    """States, actions or observations: how many there are, and their names if they have any."""

    what: str
    count: int
    names: tuple[str, ...] = ()
    numbers: dict[str, int] = field(default_factory=dict)

    @classmethod
    def of(cls, what: str, names: tuple[str, ...]) -> "Names":
        return cls(what, len(names), names, {name: i for i, name in enumerate(names)})

    def name(self, index: int) -> str:
        return self.names[index] if self.names else str(index)


@dataclass(frozen=True)
class Entry:
    """One `T:`, `O:` or `R:`.

    Attributes:
        kind: which of them.
        line: where it begins.
        selected: an index into actions, states, ... as far as they are given; `None` for all.
        values: a number, a row or a matrix over what is not given; or "uniform", "identity" or
            "reset".
    """

    kind: Kind
    line: int
    selected: tuple[int | None, ...]
    values: Float64[np.ndarray, "..."] | str


@dataclass(frozen=True)
class File:
    """All that a file says.

    Attributes:
        words: its words, for messages.
        discount: from 0 to 1.
        cost: whether values are costs, and not rewards.
        states, actions: of the model.
        observations: of a POMDP; `None` in an MDP.
        belief: float64[S], the distribution over states at first.
        entries: later ones override earlier ones.
    """

    words: Words
    discount: float
    cost: bool
    states: Names
    actions: Names
    observations: Names | None
    belief: Float64[np.ndarray, "S"]
    entries: tuple[Entry, ...]


def parsed(name: str, text: str) -> File:
    """The content of a file.

    Raises:
        FormatError: it does not follow the grammar; the message names the line.
    """
    words = Words.of(name, text)
    declared: dict[str, Names] = {}
    settings: dict[str, float] = {}
    beliefs = []
    entries: list[Entry] = []
    while words.peek():
        if not words.begins_section():
            raise words.error(
                f"{shown(repr(words.peek()))} begins no part of a file; these are discount:, "
                "values:, states:, actions:, observations:, start:, T:, O: and R:"
            )
        line, keyword = words.line, words.take()
        if keyword in declared or keyword in settings or (keyword == "start" and beliefs):
            raise words.error(f"{keyword}: is there twice; remove one", line)
        if entries and keyword not in ("T", "O", "R"):
            first = entries[0]
            raise words.error(
                f"{keyword}: comes after {first.kind}: of line {first.line}; put it above", line
            )
        if keyword in ("T", "O", "R"):
            entries.append(_entry(words, keyword, line, _dimensions(words, keyword, declared)))
        elif keyword == "start":
            (states,) = _known(words, ["states"], "start", declared)
            beliefs.append(_belief(words, states))
        elif keyword in ("states", "actions", "observations"):
            declared[keyword] = _names(words, keyword)
        else:
            settings[keyword] = _setting(words, keyword)
    for keyword, example in (("discount", "0.95"), ("values", "reward")):
        if keyword not in settings:
            raise words.error(f"has no {keyword}; add a line {keyword}: {example}", 0)
    states, actions = _known(words, ["states", "actions"], "", declared)
    uniform = np.full(states.count, 1 / states.count)
    return File(
        words,
        settings["discount"],
        bool(settings["values"]),
        states,
        actions,
        declared.get("observations"),
        beliefs[0] if beliefs else uniform,
        tuple(entries),
    )


def _setting(words: Words, keyword: str) -> float:
    """The discount; or of values 1.0 for costs, 0.0 for rewards."""
    words.skip_colon(keyword)
    line = words.line
    if keyword == "values":
        if words.peek() not in ("reward", "cost"):
            raise words.error(f"values is {shown(repr(words.peek()))}; write reward or cost")
        return float(words.take() == "cost")
    (discount,) = words.numbers(1, keyword)
    if not 0 <= discount <= 1:
        raise words.error(f"discount is {discount:g}; give a number from 0 to 1", line)
    return float(discount)


def _names(words: Words, what: str) -> Names:
    line = words.line
    words.skip_colon(what)
    if is_index(words.peek()):
        count = int(words.take())
        if not words.begins_section():
            raise words.error(f"{shown(words.peek())} follows the number of {what}; remove it")
        if count > _MOST and what != "observations":  # whose sensor has a limit of its own
            raise words.error(f"there are {count:,} {what}; at most {_MOST:,} are read", line)
        if not count:
            raise words.error(f"there are 0 {what}; give at least one", line)
        return Names(what, count)
    names: dict[str, None] = {}
    while not words.begins_section():
        name = words.peek()
        if name in RESERVED or name == ":" or is_number(name) or name in names:
            problem = "is there twice" if name in names else "cannot be a name"
            raise words.error(f"{shown(repr(name))} in {what}: {problem}; choose another one")
        names[words.take()] = None
    if not names:
        raise words.error(f"{what}: is empty; give names, or how many there are", line)
    return Names.of(what, tuple(names))


def _index(words: Words, among: Names) -> int | None:
    """The next word as an index; `None` for `*`."""
    line, word = words.line, words.take()
    if word == "*":
        return None
    if word in among.numbers:
        return among.numbers[word]
    if is_index(word) and int(word) < among.count:
        return int(word)
    listed = ", ".join(among.names[:_LISTED]) + (", ..." if among.count > _LISTED else "")
    known = listed if among.names else f"0 to {among.count - 1}"
    raise words.error(f"{shown(repr(word))} is none of the {among.what}; use {known}", line)


def _belief(words: Words, states: Names) -> Float64[np.ndarray, "S"]:
    if words.peek() in ("include", "exclude"):
        return _included(words, states, words.take())
    words.skip_colon("start")
    line, count = words.line, states.count
    if words.peek() == "uniform":
        words.take()
        return np.full(count, 1 / count)
    first = words.at
    given = words.rest_of_section()
    words.at = first
    if len(given) == 1 and (count > 1 or not is_number(given[0])):
        index = _index(words, states)
        if index is None:
            raise words.error("start is *; write uniform", line)
        return np.eye(1, count, index)[0]
    if len(given) != count:
        raise words.error(
            f"start has {len(given)} entries; give a probability for each of the {count} states, "
            "one state, or uniform",
            line,
        )
    belief = words.numbers(count, "start")
    if (belief < 0).any() or abs(belief.sum() - 1) > ROUNDING:
        raise words.error(
            f"start is not a distribution: it sums to {belief.sum():.8g}, its least entry is "
            f"{belief.min():g}; correct it",
            line,
        )
    return belief / belief.sum()


def _included(words: Words, states: Names, how: str) -> Float64[np.ndarray, "S"]:
    """Uniform over the states listed, or over all others."""
    line = words.line
    words.skip_colon(f"start {how}")
    listed = np.zeros(states.count, bool)
    while not words.begins_section():
        index = _index(words, states)
        listed[slice(None) if index is None else index] = True
    there = listed if how == "include" else ~listed
    if not there.any():
        raise words.error(f"start {how}: leaves no state; give at least one", line)
    return there / there.sum()


def _known(
    words: Words, needed: list[str], keyword: str, declared: dict[str, Names]
) -> list[Names]:
    for what in needed:
        if what not in declared:
            if keyword:
                raise words.error(f"{keyword}: comes before {what}:; put {what}: above it")
            raise words.error(f"has no {what}; add a line {what}: 2", 0)
    return [declared[what] for what in needed]


def _dimensions(words: Words, kind: str, declared: dict[str, Names]) -> list[Names]:
    """What an entry is indexed by."""
    states_first = ["actions", "states"]
    last = {"T": ["states"], "O": ["observations"]}.get(kind, ["states"])
    if kind == "R" and "observations" in declared:
        last = ["states", "observations"]
    return _known(words, states_first + last, kind, declared)


def _entry(words: Words, kind: str, line: int, dimensions: list[Names]) -> Entry:
    selected: list[int | None] = []
    for among in dimensions:
        if words.peek() != ":":
            break
        words.take()
        selected.append(_index(words, among))
    left = dimensions[len(selected) :]
    if len(left) > 2:
        raise words.error(f"{kind}: needs an action and a state; give both", line)
    return Entry(_kind(kind), line, tuple(selected), _values(words, kind, line, left))


def _kind(word: str) -> Kind:
    return "T" if word == "T" else "O" if word == "O" else "R"


def _values(
    words: Words, kind: str, line: int, left: list[Names]
) -> Float64[np.ndarray, "..."] | str:
    word = words.peek()
    known = {"O": ("uniform",), "T": ("uniform", "identity" if len(left) == 2 else "reset")}
    if left and word in known.get(kind, ()):
        return words.take()
    shape = [among.count for among in left]
    over = " and ".join(among.what for among in left)
    what = f"{kind}: over {over}" if left else f"{kind}:"
    values = words.numbers(int(np.prod(shape)), what).reshape(shape)
    if kind != "R" and ((values < 0) | (values > 1 + ROUNDING)).any():
        wrong = values[(values < 0) | (values > 1 + ROUNDING)][0]
        raise words.error(f"{kind}: has {wrong:g}; probabilities are from 0 to 1", line)
    if not words.begins_section():
        raise words.error(
            f"{shown(repr(words.peek()))} follows {values.size} of {values.size} numbers of "
            f"{what}; remove it"
        )
    return values
