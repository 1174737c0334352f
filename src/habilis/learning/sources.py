"""The sources of training problems: worlds, and tables that no map was made of."""

from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from habilis.bridges import table_files
from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.bridges.puzzles.sokoban import names_puzzle, puzzle_named
from habilis.cache import table_digest
from habilis.learning.config import BY_DIGEST, Config
from habilis.mdp import TabularMDP
from habilis.models import explore
from habilis.worlds.world import ENVIRONMENT, World, load_world
from habilis.worlds.world_checks import check_one_agent

_KEPT = 4  # environments, whose tables take long to make and serve all points of a sweep


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
    if table_files.names_table(world) or names_puzzle(world):
        return True
    return world.startswith((ENVIRONMENT, BY_DIGEST))


def puzzle_of(config: Config) -> PushWorld | None:
    """The puzzle whose file a configuration names, if it names one.

    Raises:
        ValueError: the file cannot be read, or is none.
    """
    return puzzle_named(config.world) if isinstance(config.world, str) else None


@lru_cache(_KEPT)
def _environment(world: str) -> NamedTable:
    """The table of a Gymnasium environment, by its name with "gym:"."""
    from habilis.bridges.gymnasium.named import limit_named, table_named

    name = world.removeprefix(ENVIRONMENT)
    return NamedTable.of(world, table_named(name), limit_named(name))


def source_of(config: Config) -> Source:
    """The world or table that a configuration names.

    Raises:
        ValueError: there is none such, or it is a table and the configuration names a tool.
    """
    named = config.world
    if isinstance(named, str) and not names_table(named):
        world = load_world(named, config.tool)
        check_one_agent(world)
        return world
    if isinstance(named, TabularMDP):
        found = NamedTable.of("table", named)
    elif named.startswith(ENVIRONMENT):
        found = _environment(named)
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
