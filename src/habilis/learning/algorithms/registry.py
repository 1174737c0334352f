"""Algorithms by their names, and what makes a class one."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any

from habilis.extras import import_from

_METHODS = ("init", "act", "update", "policy", "values")
_SETTINGS = ("envs", "rollout", "discount", "reward_scale")
_FACTS = ("tabular", "ignores", "counts_episodes")


@dataclass(frozen=True)
class _Entry:
    label: str
    algorithm: type[Any] | str


class Algorithms(Mapping[str, type[Any]]):
    """Algorithms by their names, as on the command line; imported when they are first used."""

    def __init__(self) -> None:
        self._entries: dict[str, _Entry] = {}
        self._loaded: dict[str, type[Any]] = {}

    def register(self, name: str, algorithm: type[Any] | str, label: str) -> None:
        """Adds an algorithm.

        Args:
            name: as on the command line, such as "q-learning".
            algorithm: its class, or where that is, as "package.module:Class".
            label: its name in words, such as "Q-learning".

        Raises:
            ValueError: there is one of that name, or the class is no algorithm. Of a class that
                is not imported yet this is found when it is first used.
        """
        if name in self._entries:
            raise ValueError(f"algorithm {name!r} is registered already; give another name")
        if not isinstance(algorithm, str):
            self._loaded[name] = _checked(name, algorithm)
        self._entries[name] = _Entry(label, algorithm)

    def unregister(self, name: str) -> None:
        """Takes an algorithm away.

        Raises:
            KeyError: there is none of that name.
        """
        del self._entries[name]
        self._loaded.pop(name, None)

    def __getitem__(self, name: str) -> type[Any]:
        where = self._entries[name].algorithm
        if name not in self._loaded and isinstance(where, str):
            module, _, kind = where.partition(":")
            self._loaded[name] = _checked(name, getattr(import_from(module, "learn"), kind))
        return self._loaded[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def labels(self) -> dict[str, str]:
        """The names in words, by those on the command line."""
        return {name: entry.label for name, entry in self._entries.items()}

    def name_of(self, algorithm: object) -> str:
        """The name of an algorithm on the command line.

        Raises:
            ValueError: it is not registered.
        """
        for name, kind in self.items():
            if type(algorithm) is kind:
                return name
        raise ValueError(f"algorithm is {algorithm!r:.80}; give a registered one, such as A2C()")


def _checked(name: str, kind: Any) -> type[Any]:
    """A class, if its instances are algorithms.

    Raises:
        ValueError: what it lacks.
    """
    from habilis.learning.config import Config

    parameters = getattr(kind, "__dataclass_params__", None)
    if parameters is None or not parameters.frozen:
        raise ValueError(f"algorithm {name!r}: {kind!r} is not a frozen dataclass; make it one")
    settings = {f.name: f for f in fields(kind)}
    missing = [fact for fact in (*_METHODS, *_FACTS) if not hasattr(kind, fact)]
    missing += [setting for setting in _SETTINGS if setting not in settings]
    if missing:
        raise ValueError(f"algorithm {name!r}: {kind.__name__} has no {missing[0]}; add it")
    own = {f.name for f in fields(Config)}
    for f in settings.values():
        if not f.metadata.keys() >= {"help", "static"}:
            raise ValueError(
                f"algorithm {name!r}: {f.name} has no help; make it with habilis.checks.setting"
            )
        if f.name in own:
            raise ValueError(
                f"algorithm {name!r}: {f.name} is a setting of every run already; rename it"
            )
    return kind
