"""The words of a file in Cassandra's format, each with its line."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float64

from habilis.files import shown

KEYWORDS = (
    "discount",
    "values",
    "states",
    "actions",
    "observations",
    "start",
    "T",
    "O",
    "R",
)
_SIGN = re.compile(r"(?<!\S)([+-])\s+(?=[\d.])")  # a sign may stand apart from its number
RESERVED = {*KEYWORDS, "reward", "cost", "uniform", "identity", "reset", "include", "exclude", "*"}


class FormatError(ValueError):
    """A file does not follow the format; its message has the place and the fix."""


@dataclass
class Words:
    """A file's words, read one after the other.

    Attributes:
        name: what errors call the file.
        words: without comments; each colon is one.
        lines: the line of each, counted from 1.
        at: the index of the next.
    """

    name: str
    words: Sequence[str]
    lines: Sequence[int]
    at: int = field(default=0)

    @classmethod
    def of(cls, name: str, text: str) -> "Words":
        words, lines = [], []
        for number, line in enumerate(text.splitlines(), 1):
            here = _SIGN.sub(r"\1", line.partition("#")[0]).replace(":", " : ").split()
            words += here
            lines += [number] * len(here)
        return cls(name, words, lines)

    @property
    def line(self) -> int:
        """The line of the next word; at the end, the last one."""
        return self.lines[min(self.at, len(self.lines) - 1)] if self.lines else 1

    def error(self, problem: str, line: int | None = None) -> FormatError:
        """An error at a line; by default that of the next word, of the whole file if it is 0."""
        line = self.line if line is None else line
        return FormatError(f"{self.name}{f', line {line}' if line else ''}: {problem}")

    def peek(self, ahead: int = 0) -> str:
        """A word that comes next; empty at the end."""
        at = self.at + ahead
        return self.words[at] if at < len(self.words) else ""

    def take(self) -> str:
        word = self.peek()
        self.at += 1
        return word

    def skip_colon(self, after: str) -> None:
        if self.peek() != ":":
            raise self.error(f"{shown(self.peek() or 'the end')} follows {after}; write a colon")
        self.at += 1

    def begins_section(self) -> bool:
        """Whether the next word begins another part of the file, or there is none."""
        word = self.peek()
        if word == "start" and self.peek(1) in ("include", "exclude"):
            return True
        return not word or (word in KEYWORDS and self.peek(1) == ":")

    def rest_of_section(self) -> list[str]:
        """The words up to the next part of the file."""
        found = []
        while not self.begins_section():
            found.append(self.take())
        return found

    def numbers(self, count: int, what: str) -> Float64[np.ndarray, "n"]:
        """So many numbers, of which `what` consists."""
        found = self.words[self.at : self.at + count]
        try:
            values = np.array([*map(float, found)])
        except ValueError:
            values = np.empty(0)
        if len(values) < count or not np.isfinite(values).all() or any("_" in w for w in found):
            good = next((i for i, word in enumerate(found) if not is_number(word)), len(found))
            self.at += good
            there = shown(repr(self.peek())) if self.peek() else "the end of the file"
            kind = f"{count} numbers" if count > 1 else "a number"
            raise self.error(f"{what} needs {kind}, and {there} follows {good}; give all of them")
        self.at += count
        return values


def is_number(word: str) -> bool:
    """Whether a word is a finite number."""
    try:
        return "_" not in word and abs(float(word)) < float("inf")
    except ValueError:
        return False


def is_index(word: str) -> bool:
    """Whether a word is a whole number from 0 up."""
    return word.isascii() and word.isdigit()
