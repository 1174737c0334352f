"""The sources of training problems: worlds, and tables that no map was made of."""

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from habilis.bridges import table_files
from habilis.cache import table_digest
from habilis.learning.config import BY_DIGEST, Config
from habilis.mdp import TabularMDP
from habilis.models import explore
from habilis.worlds.world import World, load_world

if TYPE_CHECKING:
    from habilis.bridges.puzzles.pushworld import PushWorld

GYM = "gym:"
_PUZZLE = re.compile(r".+\.(pwp|xsb(#\d+)?)", re.IGNORECASE | re.DOTALL)


@dataclass(frozen=True)
class NamedTable:
    """A table to train on; two of the same digest are the same.

    Attributes:
        name: what messages and pictures call it.
        digest: a fingerprint of all that training depends on.
        mdp: the table.
        limit: after how many steps its environment truncates an episode; `None`: never.
    """

    name: str
    digest: str
    mdp: TabularMDP = field(compare=False, repr=False)
    limit: int | None = field(default=None, compare=False)

    @classmethod
    def of(cls, name: str, mdp: TabularMDP, limit: int | None = None) -> "NamedTable":
        return cls(name, table_digest(mdp), mdp, limit)


Source = World | NamedTable


def map_of(source: Source) -> World:
    """The world of a run.

    Raises:
        ValueError: it was trained on a table.
    """
    if not isinstance(source, World):
        raise ValueError(f"{source.name}: the run was trained on a table, which has no map")
    return source


def names_table(world: str | TabularMDP) -> bool:
    """Whether the world of a configuration is a table, and not a map."""
    if isinstance(world, TabularMDP):
        return True
    file = table_files.names_table(world) or _PUZZLE.fullmatch(world)
    return world.startswith((GYM, BY_DIGEST)) or bool(file)


def puzzle_of(config: Config) -> "PushWorld | None":
    """The puzzle whose file a configuration names, if it names one.

    Raises:
        ValueError: the file cannot be read, or is none.
    """
    if not isinstance(config.world, str) or not _PUZZLE.fullmatch(config.world):
        return None
    from habilis.bridges.puzzles.sokoban import puzzle_named

    return puzzle_named(config.world)


def source_of(config: Config) -> Source:
    """The world or table that a configuration names.

    Raises:
        ValueError: there is none such, or it is a table and the configuration names a tool.
    """
    named = config.world
    if isinstance(named, str) and not names_table(named):
        return load_world(named, config.tool)
    if isinstance(named, TabularMDP):
        found = NamedTable.of("table", named)
    elif named.startswith(GYM):
        from habilis.bridges.gymnasium.named import limit_named, table_named

        env = named.removeprefix(GYM)
        found = NamedTable.of(named, table_named(env), limit_named(env))
    elif table_files.names_table(named):
        found = NamedTable.of(Path(named).stem, table_files.table_named(named))
    elif (puzzle := puzzle_of(config)) is not None:
        found = NamedTable.of(puzzle.name, explore(puzzle))
    else:
        raise ValueError(
            f"world is {named!r}, which only the folder of its run has; give the table"
        )
    if config.tool is not None:
        raise ValueError(f"{found.name} is not a map, and has no tool to replace; leave out tool")
    return found
